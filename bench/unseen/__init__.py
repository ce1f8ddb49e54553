# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Campaigns that the diagnosis has never seen, and their score.

Written from the datasheet, the contract and the literature alone, without a look at the diagnosis
or at the project's own generator: other equations, other solver, other forms of each effect, and
faults that no list holds.

=============  ===================================================================
``datasheet``  the numbers of the test rig, rigs of another size, one machine of a make
``kernel``     the drive as differential equations
``stepper``    the solver, the controller and the operator's end
``listed``     the listed effects, each in two or three forms
``unlisted``   faults that the list does not hold
``plan``       which seed gets what
``profiles``   what operators do, how the oil warms, how the rock is
``recorder``   sensors, rows, losses, files
``campaign``   puts these together and finds the size of an effect
``make``       the command that writes campaigns
``score``      the command that has them diagnosed and counts
=============  ===================================================================
"""
