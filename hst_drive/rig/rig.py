# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The numbers of a rig in SI.

A rig file may describe a part only (a hydromotor on a bench): the sections it leaves out are
None, and what needs them says so.
"""
from __future__ import annotations

from dataclasses import dataclass, field
import math

from hst_drive.effects.oil import GRADE, viscosity_ratio
from hst_drive.errors import InputError
from hst_drive.rig.fingerprint import Fingerprint
from hst_drive.rig.tables import Curve, ideal, nothing, Surface
import numpy as np

# The sections of a whole drive; a file without one of them describes a part.
OPEN = 'open'
WHOLE = ('pump', 'motor', 'line', 'relief_valve', 'loading')
CREEPING = 0.023    # of the full speed
# Most of the drill drive, for which the catalogue has its bounds: N.m, rad/s, m^3/s.
_FULL_TORQUE, _FULL_FLOW = 195e-6 / (2.0 * np.pi) * 200e5, 28e-6 * 1450.0 / 60.0
_FULL_SPEED = 28.0 * 1450.0 / 195.0 * np.pi / 30.0
STANDSTILL = 0.0046     # of the full speed: below, the sign of the rotation is the noise's
_USUAL = 3.5e7      # Pa, which a drive is made for where nothing tells it
NO_SIGN = 5.0       # deviations of a speed sensor's noise: below, it is not known either


@dataclass(frozen=True)
class Pump:
    """
    Pump: rad/s, m^3/rad over V, s, m^3/s over (Pa, V), 1 over (Pa, rad/s).

    ``given`` are the keys of the file: one of a part may leave some out, and then the part is
    ideal; 0 and None stand for numbers that only a balance which needs them asks for.
    """

    shaft_speed: float = 0.0
    max_displacement: float = 0.0
    displacement: Curve | None = None
    displacement_lag: float = 0.0
    leakage: Surface = field(default_factory=nothing)
    mechanical_efficiency: Surface = field(default_factory=ideal)
    given: frozenset[str] = frozenset()

    def command_of(self, displacement):
        """Return the command (V) on which the plate settles at a displacement (m^3/rad)."""
        return np.interp(displacement, self.displacement.y, self.displacement.x)


@dataclass(frozen=True)
class Motor:
    """
    Hydromotor: m^3/rad, kg.m^2 (all that turns with it), m^3/s and 1 over (Pa, rad/s).

    Those of ``count`` alike on a gear are one here, as seen from the measured shaft (``shaft``).
    ``torque_loss`` are the coefficients that the efficiency was made from, if it was: N.m,
    N.m.s/rad, share of the ideal torque. ``given`` as for ``Pump``.
    """

    displacement: float = 0.0
    inertia: float = 0.0
    leakage: Surface = field(default_factory=nothing)
    mechanical_efficiency: Surface = field(default_factory=ideal)
    pistons: float = 7
    count: int = 1
    second_displacement: float = 0.0
    torque_loss: tuple[float, float, float] | None = None
    given: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Line:
    """
    The oil between pump and hydromotor: Pa, m^3, kg/m^3 and the oil's ISO grade.

    ``given`` as for ``Pump``; what a file of a part leaves out is 0, its oil a usual one.
    """

    bulk_modulus: float = 0.0
    volume: float = 0.0
    oil_density: float = 0.0
    oil_grade: str = GRADE
    given: frozenset[str] = frozenset()


@dataclass(frozen=True)
class ReliefValve:
    """
    Pressure relief valve: Pa, Pa, 1, m^2.

    The drill-drive paper's Eq. (2) opens at 200 bar but takes the root of ``P - 100``: the flow
    would jump. Both pressures are parameters; equal ones, the default, give a steady flow.
    """

    set_pressure: float
    reference_pressure: float
    discharge_coefficient: float
    area: float


@dataclass(frozen=True)
class Loading:
    """Loading unit: 1, m^3/rad, 1 over Pa, Pa over V, s, Pa.s/m^3, m^3/s."""

    gear_ratio: float
    pump_displacement: float
    pump_mechanical_efficiency: Curve
    pprv_pressure: Curve
    pprv_lag: float
    pprv_override: float
    pprv_reference_flow: float


@dataclass(frozen=True)
class Gear:
    """Gear behind the hydromotors: their turns per turn of the measured shaft, efficiency."""

    ratio: float
    efficiency: float = 1.0


@dataclass(frozen=True)
class CrossPortRelief:
    """Relief valves from line to line of a closed circuit: Pa, Pa.s/m^3."""

    set_pressure: float
    override: float


@dataclass(frozen=True)
class Charge:
    """Charge pump of a closed circuit, its relief, check valves: m^3/rad, Pa, Pa.s/m^3, m^3/s."""

    pump_displacement: float
    relief_pressure: float
    relief_override: float
    check_valve: float
    flushing: float = 0.0


@dataclass(frozen=True)
class Supply:
    """Supply of constant pressure, Pa."""

    pressure: float


@dataclass(frozen=True)
class Valve:
    """Proportional valve: m^3/s through an edge, at Pa, opening (-1 to 1) over V, s."""

    rated_flow: float
    rated_pressure_drop: float
    opening: Curve
    lag: float


@dataclass(frozen=True)
class Controller:
    """PI law: V.s/rad, V/rad, s, V."""

    kp: float
    ki: float
    sample_time: float
    output_limits: tuple[float, float]


@dataclass(frozen=True)
class Sensor:
    """
    Standard deviation of the noise, step of the reading and range, all in SI.

    ``zero_std`` is one standard deviation of how far the zero may be off. ``delay`` (s) is how
    late it is known to read and ``delay_std`` how well, None where nobody said. Other numbers are
    0 then: records show their noise by themselves.
    """

    noise_std: float
    resolution: float = 0.0
    range: tuple[float, float] | None = None
    zero_std: float = 0.0
    delay: float = 0.0
    delay_std: float | None = None

    @property
    def step_std(self) -> float:
        """Standard deviation that the step of the reading alone makes, SI."""
        return self.resolution / math.sqrt(12.0)

    @property
    def std(self) -> float:
        """Standard deviation of a reading, its step included, SI."""
        return math.hypot(self.noise_std, self.step_std)


@dataclass(frozen=True)
class Rig:
    """
    A rig, or a part of one.

    Attributes
    ----------
    name : str
        Title for people.
    circuit : str
        'open', or another file of ``model/circuits``.
    pump, motor, line, relief_valve, loading, controller, ... : objects or None
        Sections; None where the file leaves a part out.
    sensors : dict of str to Sensor
        By channel name.
    tolerances : dict of str to float
        One-sigma relative scatter between units of this make, by 'section.quantity'.
    characterised_at : float
        Oil temperature at which the tables were measured, K.
    effects : dict of str to dict
        Adopted effects: id to parameter values in SI.
    calibration : dict of str to float
        Factor of this unit on each quantity that is off the datasheet.
    fingerprint : Fingerprint or None
        How well these factors are known, where the machine was commissioned.
    provenance : dict
        Where effects and calibration came from; for people and for refusals.
    source : str
        File the rig was read from.
    digest : str
        Tells rigs apart by their numbers (``identity``).

    """

    name: str
    circuit: str = OPEN
    pump: Pump | None = None
    motor: Motor | None = None
    line: Line | None = None
    relief_valve: ReliefValve | None = None
    loading: Loading | None = None
    gear: Gear | None = None
    cross_port_relief: CrossPortRelief | None = None
    charge: Charge | None = None
    supply: Supply | None = None
    valve: Valve | None = None
    controller: Controller | None = None
    sensors: dict[str, Sensor] = field(default_factory=dict)
    tolerances: dict[str, float] = field(default_factory=dict)
    characterised_at: float = 323.15
    effects: dict[str, dict[str, float]] = field(default_factory=dict)
    calibration: dict[str, float] = field(default_factory=dict)
    fingerprint: Fingerprint | None = None
    provenance: dict = field(default_factory=dict)
    source: str = ''
    digest: str = ''

    @property
    def scatter(self) -> dict[str, float]:
        """By how much each quantity may be off: of this machine where that is known."""
        return {**self.tolerances, **(self.fingerprint.sigmas if self.fingerprint else {})}

    @property
    def zeros(self) -> dict[str, float]:
        """What each sensor of this machine reads beyond the truth throughout, SI."""
        known = self.fingerprint.zeros if self.fingerprint else {}
        return {name: value for name, (value, _) in known.items()}

    @property
    def delays(self) -> dict[str, float]:
        """How late each sensor is known to read, s."""
        return {name: sensor.delay for name, sensor in self.sensors.items() if sensor.delay}

    @property
    def rated_pressure(self) -> float:
        """Pressure (Pa) that the drive is made for: of its relief valve, or of its supply."""
        limit = self.relief_valve or self.cross_port_relief
        return limit.set_pressure if limit else self.supply.pressure if self.supply else _USUAL

    @property
    def oil_grade(self) -> str:
        """Viscosity grade of the oil; a usual one where the file of a part tells none."""
        return (self.line or Line()).oil_grade

    def viscosity_ratio(self, temperature: np.ndarray | float) -> np.ndarray | float:
        """Return the oil's viscosity (K) over that at which the tables were measured."""
        return viscosity_ratio(temperature, self.characterised_at, self.oil_grade)

    @property
    def whole(self) -> bool:
        """Whether all sections of the open circuit's drive are there."""
        return self.circuit == OPEN and all(getattr(self, name) is not None for name in WHOLE)

    @property
    def full_speed(self) -> float:
        """Speed of the hydromotor on the pump's full flow, rad/s; 0 where it is not given."""
        if not (self.pump and self.motor and self.motor.displacement):
            return 0.0
        return self.pump.max_displacement * self.pump.shaft_speed / self.motor.displacement

    @property
    def sizes(self) -> tuple[float, float, float]:
        """Torque, speed and flow of a whole drive, over those of the drill drive; else 1."""
        if not self.whole:
            return 1.0, 1.0, 1.0
        flow = float(self.full_speed) * self.motor.displacement
        return (self.motor.displacement * self.rated_pressure / _FULL_TORQUE,
                float(self.full_speed) / _FULL_SPEED, flow / _FULL_FLOW)

    @property
    def creeping(self) -> float:
        """Speed of the hydromotor below which it creeps, rad/s: its friction is not sure."""
        return CREEPING * self.full_speed

    def require(self, *sections: str, purpose: str) -> None:
        """
        Check that the rig has these sections.

        Raises
        ------
        InputError
            Naming the file, the missing section and what needs it.

        """
        for section in sections:
            if getattr(self, section) is None and self.circuit != OPEN:
                raise InputError(f"{self.source or self.name}: is of 'circuit: {self.circuit}'; "
                                 f'{purpose} knows the open circuit only')
            if getattr(self, section) is None:
                raise InputError(f"{self.source or self.name}: section '{section}' is missing; "
                                 f'{purpose} needs it; add it to the rig file')
