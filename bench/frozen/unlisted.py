# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What real machines also show and EFFECTS.md does not list: valve, pump, drive train, rock."""
from bench.frozen.kind import Kind
from bench.frozen.listed import JET, Rng
from bench.frozen.plant import Plant
from bench.frozen.profiles import rough
from bench.frozen.unlisted_sensors import KINDS as OF_SENSORS
import numpy as np


def _switched(rng: Rng, t: np.ndarray, off: tuple[float, float],
              on: tuple[float, float]) -> np.ndarray:
    """Return something that is on now and then, for times [s] out of these ranges."""
    values, k = np.zeros(len(t)), 0
    while k < len(t):
        k += int(1e3 * rng.uniform(*off))
        end = k + int(1e3 * rng.uniform(*on))
        values[k:end] = 1.0
        k = end
    return values


def load_grips_slow(rng: Rng, base: Plant) -> Kind:
    w = rng.uniform(0.1, 0.5) * base.w_nominal
    return Kind('load_grips_slow', 'load', 5e-3, 1.5, lambda s: {'grip': s, 'grip_w': w},
                note='rock grips harder the slower the bit turns')


def pprv_sticks(rng: Rng, base: Plant) -> Kind:
    return Kind('pprv_sticks', 'load', 5e-4, 0.06, lambda s: {'pprv_play': s * base.p_top},
                note='spool of the PPRV follows its coil only after a gap')


def bit_lobes(rng: Rng, base: Plant) -> Kind:
    return Kind('bit_lobes', 'load', 3e-3, 0.4, lambda s: {'lobes': s}, slowest_ms=25,
                note='three cones of the bit: load goes up and down three times per turn')


def wrong_gear_ratio(rng: Rng, base: Plant) -> Kind:
    sign = rng.choice([-1.0, 1.0])
    return Kind('wrong_gear_ratio', 'load', 2e-3, 0.2,
                lambda s: {'gear': base.gear * (1 + sign * s)},
                effects=('gearbox_loss',) if sign > 0 else (),
                note='the gear has another ratio than its plate says')


def pprv_coil_warms(rng: Rng, base: Plant) -> Kind:
    time = rng.uniform(8, 40)
    return Kind('pprv_coil_warms', 'load', 3e-3, 0.3, lambda s: {'coil_fade': s},
                shake=lambda r, t: 1 - np.exp(-t / time),
                note='coil of the PPRV warms: the same voltage gives less force')


def loading_pump_starves(rng: Rng, base: Plant) -> Kind:
    w = rng.uniform(0.6, 1.0) * base.w_nominal
    return Kind('loading_pump_starves', 'load', 0.01, 2.0,
                lambda s: {'load_starve': s, 'load_starve_w': w},
                note='loading pump does not fill beyond a speed: the load falls')


def return_filter_clogs(rng: Rng, base: Plant) -> Kind:
    time = rng.uniform(20, 60)
    return Kind('return_filter_clogs', 'torque', 5e-4, 0.15, lambda s: {'clog': s * base.p_top},
                shake=lambda r, t: (t / time) ** 1.5, effects=('back_pressure',),
                note='return filter fills up while the log runs')


def bearing_runs_warm(rng: Rng, base: Plant) -> Kind:
    time = rng.uniform(8, 30)
    return Kind('bearing_runs_warm', 'torque', 2e-3, 0.3,
                lambda s: {'warm_up': s * base.t_nominal},
                shake=lambda r, t: np.exp(-t / time), effects=('bearing_friction',),
                note='stiff grease: friction fades as the bearing warms')


def coupling_chatters(rng: Rng, base: Plant) -> Kind:
    form = {'chatter_w': rng.uniform(0.4, 1.1) * base.w_nominal,
            'chatter_width': rng.uniform(0.15, 0.4) * base.w_nominal}

    def shake(r: Rng, t: np.ndarray) -> np.ndarray:
        beat = np.sin(2 * np.pi * r.uniform(9, 16) * t + r.uniform(0, 6))
        return beat * (1 + 0.5 * rough(r, len(t), 1.0, 0.3))
    return Kind('coupling_chatters', 'torque', 0.01, 1.0,
                lambda s: {'chatter': s * base.t_nominal, **form}, shake=shake, slowest_ms=20,
                note='worn coupling hammers near one speed')


def slippers_touch(rng: Rng, base: Plant) -> Kind:
    p = rng.uniform(0.2, 0.45) * base.p_top
    return Kind('slippers_touch', 'torque', 5e-3, 1.0, lambda s: {
        'slipper': s * base.t_nominal * 200e5 / base.p_top, 'slipper_p': p}, heavy=True,
        note='slippers touch beyond a pressure')


def flywheel(rng: Rng, base: Plant) -> Kind:
    grow = rng.random() < 0.7
    return Kind('flywheel', 'torque', 0.15, 3.0, lambda s: {
        'inertia': base.inertia * ((1 + s) if grow else 1 / (1 + s))},
        sizes=(0.6, 1.0), note='another mass turns than the datasheet says')


def bent_shaft_rubs(rng: Rng, base: Plant) -> Kind:
    return Kind('bent_shaft_rubs', 'torque', 2e-3, 0.4, lambda s: {'rub': s * base.t_nominal},
                slowest_ms=40, effects=('bearing_friction',),
                note='shaft rubs once per turn')


def worn_piston(rng: Rng, base: Plant) -> Kind:
    return Kind('worn_piston', 'flow', 5e-3, 0.6,
                lambda s: {'piston_leak': s * base.q_nominal / JET}, slowest_ms=25,
                effects=('motor_orifice_leakage',), note='one piston leaks once per turn')


def relief_flutters(rng: Rng, base: Plant) -> Kind:
    form = {'flutter_p': rng.uniform(0.15, 0.45) * base.p_top,
            'flutter_hz': rng.uniform(5, 18)}
    return Kind('relief_flutters', 'flow', 2e-3, 0.4,
                lambda s: {'flutter_q': s * base.q_nominal, **form}, heavy=True,
                effects=('prv_cracking',),
                note='pilot of the relief valve flutters beyond a pressure')


def relief_snaps(rng: Rng, base: Plant) -> Kind:
    p = rng.uniform(0.25, 0.5) * base.p_top
    shut = p * rng.uniform(0.5, 0.8)
    return Kind('relief_snaps', 'flow', 2e-3, 0.3, lambda s: {
        'snap_q': s * base.q_nominal, 'snap_open': p, 'snap_shut': shut}, heavy=True,
        effects=('prv_cracking',),
        note='relief valve opens at a pressure and shuts at a lower one')


def dirt_on_seat(rng: Rng, base: Plant) -> Kind:
    return Kind('dirt_on_seat', 'flow', 2e-3, 0.3,
                lambda s: {'dirt': s * base.q_nominal / JET},
                shake=lambda r, t: _switched(r, t, (3, 12), (2, 9)),
                note='dirt holds a bypass valve open now and then')


def other_volume(rng: Rng, base: Plant) -> Kind:
    grow = rng.random() < 0.7
    return Kind('other_volume', 'flow', 0.3, 6.0, lambda s: {
        'volume': base.volume * ((1 + s) if grow else 1 / (1 + s))}, sizes=(0.6, 1.5, 3.0),
        note='the oil volume is not that of the datasheet')


def governor_hunts(rng: Rng, base: Plant) -> Kind:
    hz = rng.uniform(0.2, 1.2)
    return Kind('governor_hunts', 'flow', 5e-4, 0.08, lambda s: {'hunt': s},
                shake=lambda r, t: np.sin(2 * np.pi * hz * t + r.uniform(0, 6))
                * (1 + 0.5 * rough(r, len(t), 0.7, 1.0)),
                note='governor of the prime mover hunts')


def hose_creeps(rng: Rng, base: Plant) -> Kind:
    time = rng.uniform(0.3, 3)
    return Kind('hose_creeps', 'flow', 0.02, 60.0, lambda s: {
        'hose': s * base.volume / base.bulk, 'hose_lag': time},
        effects=('accumulator',), note='wall of the hose gives way slowly')


def supply_sags(rng: Rng, base: Plant) -> Kind:
    return Kind('supply_sags', 'pump_actuator', 1e-3, 0.2, lambda s: {'sag': s},
                shake=lambda r, t: _switched(r, t, (2, 8), (1, 6)),
                note='another consumer pulls the supply of the amplifier down')


def amplifier_saturates(rng: Rng, base: Plant) -> Kind:
    knee = rng.uniform(4.2, 5.4)
    return Kind('amplifier_saturates', 'pump_actuator', 3e-3, 0.8,
                lambda s: {'amp_knee': knee, 'amp_loss': s},
                note='command amplifier: other zero and gain beyond a voltage')


def command_held(rng: Rng, base: Plant) -> Kind:
    return Kind('command_held', 'pump_actuator', 30, 500,
                lambda s: {'hold_ms': int(round(s / 10)) * 10},
                sizes=(50, 100, 200, 400), neutral=10, effects=('pump_lag',),
                note='amplifier takes the command over only now and then')


def actuator_rings(rng: Rng, base: Plant) -> Kind:
    form = {'ring_w': rng.uniform(10, 45), 'ring_damping': rng.uniform(0.05, 0.25)}
    return Kind('actuator_rings', 'pump_actuator', 5e-3, 3.0, lambda s: {'ring': s, **form},
                note='swash plate swings about its place')


def strokes_unevenly(rng: Rng, base: Plant) -> Kind:
    return Kind('strokes_unevenly', 'pump_actuator', 1.3, 30.0, lambda s: {'lag_up': s},
                effects=('pump_lag',), neutral=1.0, note='on stroke is slower than off stroke')


def swash_creeps(rng: Rng, base: Plant) -> Kind:
    time = rng.uniform(1.5, 8)
    return Kind('swash_creeps', 'pump_actuator', 2e-3, 0.4,
                lambda s: {'creep': s, 'creep_lag': time}, effects=('pump_lag',),
                note='the last part of a stroke comes late')


KINDS = {f.__name__: f for f in (
    load_grips_slow, pprv_sticks, bit_lobes, wrong_gear_ratio, pprv_coil_warms,
    loading_pump_starves, return_filter_clogs, bearing_runs_warm, coupling_chatters,
    slippers_touch, flywheel, bent_shaft_rubs, worn_piston, relief_flutters, relief_snaps,
    dirt_on_seat, other_volume, governor_hunts, hose_creeps, supply_sags, amplifier_saturates,
    command_held, actuator_rings, strokes_unevenly, swash_creeps)} | OF_SENSORS
