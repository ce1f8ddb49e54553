# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What can be told of the drive while it runs: figures of merit, loss resistances, a watch."""
