# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The machine's numbers in SI units: what a healthy unit has, and what can be wrong with it."""
from typing import NamedTuple

from bench.frozen import curves, datasheet
import numpy as np

BAR = 1e5
LPM = 1e-3 / 60
CC = 1e-6 / (2 * np.pi)
RPM = np.pi / 30


class Charts(NamedTuple):
    """The curves and charts of a machine."""

    stroke: np.ndarray
    pump_leak: np.ndarray
    motor_leak: np.ndarray
    motor_eta: np.ndarray
    load_eta: np.ndarray
    pprv: np.ndarray


class Plant(NamedTuple):
    """All numbers of one machine. A neutral fault is 0 unless its line says otherwise."""

    # Healthy machine: charts and curves on even grids, then numbers.
    stroke: np.ndarray          # m3/rad over 0..10 V
    pump_leak: np.ndarray       # m3/s over pressure and 0..10 V
    motor_leak: np.ndarray      # m3/s over pressure and speed
    motor_eta: np.ndarray       # 1 over pressure and speed
    load_eta: np.ndarray        # 1 over pressure
    pprv: np.ndarray            # Pa over 0..10 V
    p_top: float                # Pa, end of the pressure axes
    w_top: float                # rad/s, end of the speed axes
    shaft_speed: float          # rad/s
    stroke_max: float           # m3/rad
    stroke_lag: float           # s, swash plate
    servo_lag: float            # s, its valve: together they make up the datasheet's lag
    motor: float                # m3/rad
    inertia: float              # kg m2
    bulk: float                 # Pa, at half of p_top / 2
    stiffening: float           # 1, rise of the bulk modulus with pressure (Tait)
    volume: float               # m3
    density: float              # kg/m3
    relief_set: float           # Pa
    relief_area: float          # m2, discharge coefficient included
    gear: float                 # 1
    loading: float              # m3/rad
    pprv_lag: float             # s
    coil_lag: float             # s
    override: float             # Pa s/m3
    override_flow: float        # m3/s
    q_nominal: float            # m3/s, hydromotor at its nominal speed
    w_nominal: float            # rad/s
    t_nominal: float            # N m, hydromotor at half of the relief pressure
    kp: float                   # V s/rad
    ki: float                   # V/rad
    speed_step: float           # rad/s, resolution of the speed reading
    # Flow.
    visc_share: float = 0.0     # share of the leakage that goes with 1/viscosity
    pump_wear: float = 0.0      # m3/s at 100 bar
    pump_wear_power: float = 1.0
    motor_wear: float = 0.0     # m3/s at 100 bar
    motor_wear_speed: float = 0.0   # share that goes with speed
    motor_elastic: float = 0.0  # 1/Pa, growth of the gap
    orifice: float = 0.0        # m2, discharge coefficient included
    air: float = 0.0            # 1, volume share at ambient pressure
    air_power: float = 1.3      # polytropic exponent
    air_gone: float = 1e9       # Pa, all air is in solution above it
    decompress: float = 0.0     # displaced volumes that are decompressed, pump
    decompress_motor: float = 0.0
    crack_q: float = 0.0        # m3/s at the set pressure
    crack_p: float = 1e9        # Pa
    crack_power: float = 1.5
    droop: float = 0.0          # 1, slip at nominal pump torque
    droop_lag: float = 0.3      # s
    droop_bend: float = 0.0
    starve: float = 0.0         # 1, lost share per share of flow beyond starve_q
    starve_q: float = 1.0       # m3/s
    acc_volume: float = 0.0     # m3
    acc_p: float = 1.0          # Pa, gauge precharge
    acc_power: float = 1.2
    acc_neck: float = 1e9       # Pa s/m3
    piston_leak: float = 0.0    # m2
    flutter_q: float = 0.0      # m3/s
    flutter_p: float = 1e9      # Pa
    flutter_hz: float = 20.0
    snap_q: float = 0.0         # m3/s at 100 bar: relief valve that snaps open and shut
    snap_open: float = 1e9      # Pa
    snap_shut: float = 0.9e9    # Pa
    dirt: float = 0.0           # m2, times the disturbance
    hose: float = 0.0           # m3/Pa, creep of the hose wall
    hose_lag: float = 1.0       # s
    hunt: float = 0.0           # 1, times the disturbance
    # Pump actuator.
    offset: float = 0.0         # V
    offset_fade: float = 0.0    # share of it that is gone at 10 V
    play: float = 0.0           # m3/rad, half width
    play_power: float = 0.0     # 0: a gap; else the exponent of a rounded (Dahl) loop
    rate_up: float = 0.0        # m3/rad/s, 0: no limit
    rate_down: float = 0.0
    rate_round: float = 6.0     # how sharp the limit bends
    extra_lag: float = 0.0      # s, a further pole
    lag_up: float = 1.0         # factor on the lag while displacement rises (neutral 1)
    swash_yield: float = 0.0    # m3/rad at 100 bar and full displacement
    swash_power: float = 1.0
    sag: float = 0.0            # 1, times the disturbance
    amp_knee: float = 99.0      # V
    amp_loss: float = 0.0
    hold_ms: int = 10           # ms between two values that the amplifier takes over
    ring: float = 0.0           # 1, how much the plate swings after a stroke
    ring_w: float = 30.0        # rad/s
    ring_damping: float = 0.2
    creep: float = 0.0          # 1, share of a stroke that comes late
    creep_lag: float = 5.0      # s
    # Torque.
    coulomb: float = 0.0        # N m
    coulomb_load: float = 0.0   # share of the load
    coulomb_power: float = 1.0  # exponent of that share
    stribeck: float = 0.0       # N m
    stribeck_w: float = 1.0     # rad/s
    stribeck_power: float = 1.0
    bristles: float = 0.0       # 1/rad, 0: a smooth sign, else LuGre
    viscous: float = 0.0        # N m at nominal speed
    viscous_power: float = 1.0
    churn: float = 0.0          # N m at nominal speed
    churn_power: float = 2.0
    line_on: int = 0            # 1: hose between two volumes
    line_laminar: float = 0.0   # Pa at nominal flow
    line_turbulent: float = 0.0
    line_inertance: float = 1e7  # kg/m4
    line_share: float = 0.5     # share of the volume upstream
    back: float = 0.0           # Pa, spring of a return check valve
    back_flow: float = 0.0      # Pa at nominal flow
    back_power: float = 1.75
    ripple: float = 0.0         # 1, share of the torque
    ripple_second: float = 0.0  # share of the second harmonic
    ripple_pistons: float = 7.0
    twist: float = 0.0          # rad/(N m)
    twist_share: float = 0.5    # share of the inertia behind the shaft
    twist_damping: float = 0.05
    hang: float = 0.0           # N m
    slipper: float = 0.0        # N m per 100 bar beyond slipper_p
    slipper_p: float = 1e9      # Pa
    clog: float = 0.0           # Pa at nominal flow, times the disturbance
    warm_up: float = 0.0        # N m, times the disturbance
    chatter: float = 0.0        # N m, times the disturbance
    chatter_w: float = 0.0      # rad/s, where it is worst
    chatter_width: float = 1.0
    rub: float = 0.0            # N m, once per turn
    # Load.
    gear_share: float = 0.0     # share of the torque that the gear eats
    gear_idle: float = 0.0      # N m
    grip: float = 0.0           # 1, extra load at standstill
    grip_w: float = 1.0         # rad/s
    pprv_play: float = 0.0      # Pa, half width
    lobes: float = 0.0          # 1, three times per turn
    coil_fade: float = 0.0      # 1, times the disturbance
    load_starve: float = 0.0    # 1 per nominal speed beyond load_starve_w
    load_starve_w: float = 99.0
    # Speed reading, which the controller has, too.
    speed_lag: float = 0.0      # s
    tooth: float = 0.0          # 1, dip once per turn
    tooth_width: float = 0.1    # rad

    def packed(self) -> tuple[np.record, Charts]:
        """Return numbers and charts as the equations read them quickest."""
        numbers = {k: v for k, v in self._asdict().items() if k not in Charts._fields}
        kind = np.dtype([(k, type(v)) for k, v in numbers.items()])
        return (np.rec.array([tuple(numbers.values())], kind)[0],
                Charts(*(getattr(self, k) for k in Charts._fields)))


def build(sheet: dict, unit: dict) -> Plant:
    """Return the healthy machine of a datasheet whose numbers are off by a unit's factors."""
    pump, motor, load = sheet['pump'], sheet['motor'], sheet['loading']
    line, relief = sheet['line'], sheet['relief_valve']
    speed = datasheet.nominal_speed(sheet) * RPM
    p_top = motor['leakage_L_min']['pressure_bar'][-1] * BAR
    w_top = motor['leakage_L_min']['speed_rpm'][-1] * RPM

    def chart(table: dict, across: str, scale: float, unit_across: float, top: float,
              name: str) -> np.ndarray:
        values = curves.chart(np.array(table['pressure_bar']) * BAR,
                              np.array(table[across]) * unit_across,
                              np.array(table['table']) * scale, p_top, top)
        return curves.tilted(values, *unit[name])

    def line_curve(x: list, y: list, x_unit: float, y_unit: float, top: float,
                   name: str) -> np.ndarray:
        return curves.tilted(curves.curve(np.array(x) * x_unit, np.array(y) * y_unit, top),
                             *unit[name])

    strokes = pump['displacement_vs_command']
    pprv = load['pprv_pressure_vs_command']
    eta = load['pump_mechanical_efficiency']
    d_motor = motor['displacement_cc_rev'] * CC * unit['motor.displacement'][0]
    servo_lag = 0.04 * pump['displacement_lag_s']
    coil_lag = 0.03 * load['pprv_lag_s']
    return Plant(
        stroke=line_curve(strokes['command_V'], strokes['displacement_cc_rev'], 1.0, CC, 10.0,
                          'pump.displacement_vs_command'),
        pump_leak=chart(pump['leakage_L_min'], 'command_V', LPM, 1.0, 10.0, 'pump.leakage'),
        motor_leak=chart(motor['leakage_L_min'], 'speed_rpm', LPM, RPM, w_top, 'motor.leakage'),
        motor_eta=chart(motor['mechanical_efficiency'], 'speed_rpm', 1.0, RPM, w_top,
                        'motor.mechanical_efficiency'),
        load_eta=line_curve(eta['pressure_bar'], eta['efficiency'], BAR, 1.0, p_top,
                            'loading.pump_mechanical_efficiency'),
        pprv=line_curve(pprv['command_V'], pprv['pressure_bar'], 1.0, BAR, 10.0,
                        'loading.pprv_pressure'),
        p_top=p_top, w_top=w_top, shaft_speed=pump['shaft_speed_rpm'] * RPM,
        stroke_max=pump['max_displacement_cc_rev'] * CC,
        stroke_lag=pump['displacement_lag_s'] * unit['pump.displacement_lag'][0] - servo_lag,
        servo_lag=servo_lag, motor=d_motor,
        inertia=motor['inertia_total_kg_m2'] * unit['motor.inertia'][0],
        bulk=line['bulk_modulus_Pa'] * unit['line.bulk_modulus'][0], stiffening=4.0,
        volume=line['volume_m3'], density=line['oil_density_kg_m3'],
        relief_set=relief['set_pressure_bar'] * BAR,
        relief_area=relief['discharge_coefficient'] * relief['area_m2'],
        gear=float(load['gear_ratio']), loading=load['pump_displacement_cc_rev'] * CC,
        pprv_lag=load['pprv_lag_s'] * unit['loading.pprv_lag'][0] - coil_lag, coil_lag=coil_lag,
        override=load['pprv_override_bar_per_L_min'] * BAR / LPM
        * unit['loading.pprv_override'][0],
        override_flow=load['pprv_reference_flow_L_min'] * LPM,
        q_nominal=d_motor * speed, w_nominal=speed,
        t_nominal=0.5 * relief['set_pressure_bar'] * BAR * d_motor,
        kp=sheet['controller']['kp_V_per_rad_s'], ki=sheet['controller']['ki_V_per_rad'],
        speed_step=sheet['sensors']['motor_speed']['resolution_rpm'] * RPM)
