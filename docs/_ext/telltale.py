# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
A picture of each effect's tell-tale: the same commands, with the effect and without.

The model runs the shipped scenario 'commissioning' twice. On the left stands the signal that the
effect moves most, in the ten seconds where it moves most. On the right it stands by how much, over
a quantity that the equation reads: the one that explains most of it.
"""
from functools import lru_cache
from html import escape

import hst_drive as hd
from hst_drive.channels import CHANNELS
from hst_drive.effects import catalogue
from hst_drive.effects.base import arguments
from hst_drive.model import Drive
from hst_drive.model.compose import kernel
from hst_drive.rig import default_rig
from hst_drive.units import difference_from_si, from_si
import numpy as np

FOLDER = '_images/telltales'
_START = 6.0            # s: a start from rest is judged by no datasheet
_WINDOW = 10.0          # s shown on the left
_BINS = 20              # of a variable, to see how much of the difference it explains
# What an equation may read, and the signal that shows it.
_OVER = {'pressure': 'pump_outlet_pressure', 'pump_pressure': 'pump_outlet_pressure',
         'motor_speed': 'motor_speed', 'pump_command': 'pump_command',
         'displacement': 'pump_command', 'oil_temperature': 'oil_temperature',
         'viscosity_ratio': 'oil_temperature', 'load_torque': 'load_torque',
         'flow': 'motor_inlet_flow'}


def figure(effect):
    """Return the picture of an effect for a page, in HTML; none of one of another circuit."""
    if effect.id not in kernel().usable:
        return ''
    told = (f'The same commands with {effect.id} at its typical size and without it: the signal '
            'that moves most, and the difference')
    return (f'<figure class="telltale"><img src="{FOLDER}/{effect.id}.png" alt="{escape(told)}" '
            'loading="lazy"></figure>')


@lru_cache(maxsize=1)
def _commands():
    run = hd.simulate('commissioning').run
    return run.time, {name: run[name] for name in (
        'pump_command', 'pprv_command', 'oil_temperature')}


@lru_cache(maxsize=1)
def _baseline():
    time, inputs = _commands()
    return {**Drive(default_rig()).simulate(time, inputs), **inputs}


def shown(identity):
    """
    Return what an effect moves most, and over what.

    Returns
    -------
    tuple
        Time (s), the signal's name, its values with and without the effect (SI), the name and
        the values of the variable that explains most of the difference.

    """
    time, inputs = _commands()
    without = _baseline()
    drive = Drive(default_rig(), {identity: catalogue()[identity].typical})
    within = drive.simulate(time, inputs)
    judged = time > _START
    noise = {name: sensor.noise_std for name, sensor in default_rig().sensors.items()
             if sensor.noise_std > 0.0 and name in within and name != 'oil_temperature'}
    signal = max(noise, key=lambda name: np.std((within[name] - without[name])[judged])
                 / noise[name] + abs(np.mean((within[name] - without[name])[judged]))
                 / noise[name])
    moved = within[signal] - without[signal]
    read = {_OVER[name] for _, function in catalogue()[identity].terms
            for name in arguments(function) if name in _OVER}
    over = max(sorted(read or _OVER.values()),
               key=lambda name: _explained(without[name][judged], moved[judged]))
    return time, signal, within[signal], without[signal], over, without[over]


def _explained(variable, moved):
    """Return the share of a difference's variance that lies between bins of a variable."""
    edges = np.quantile(variable, np.linspace(0.0, 1.0, _BINS + 1)[1:-1])
    place = np.searchsorted(edges, variable)
    count = np.maximum(np.bincount(place, minlength=_BINS), 1)
    mean = np.bincount(place, moved, _BINS) / count
    return np.var(mean[place]) / max(np.var(moved), 1e-30)


def draw(identity, path):
    """Draw one effect's tell-tale into a file."""
    from hst_drive.report.drawing import BLACK, BLUE, new_figure, save, VERMILION

    time, signal, within, without, over, variable = shown(identity)
    moved = within - without
    judged = time > _START
    size = np.convolve(moved**2 * judged, np.ones(round(_WINDOW / (time[1] - time[0]))), 'valid')
    start = time[max(int(np.argmax(size)), int(np.argmax(judged)))]
    part = (time >= start) & (time <= start + _WINDOW)
    channel, other = CHANNELS[signal], CHANNELS[over]
    figure_ = new_figure(8.4, 2.7, layout='constrained')
    left, right = figure_.subplots(1, 2)
    left.plot(time[part], from_si(within[part], channel.display), color=BLACK, lw=1.2,
              label='with the effect')
    left.plot(time[part], from_si(without[part], channel.display), color=VERMILION, lw=1.0,
              label='without')
    left.set_xlabel('time [s]')
    left.set_ylabel(f'{channel.title} [{channel.display}]')
    left.legend(frameon=False, fontsize=8)
    right.plot(from_si(variable[judged][::5], other.display),
               difference_from_si(moved[judged][::5], channel.display), '.', ms=2, color=BLUE)
    right.axhline(0.0, color='0.5', lw=0.6)
    right.set_xlabel(f'{other.title} [{other.display}]')
    right.set_ylabel(f'difference [{channel.display}]')
    for axis in (left, right):
        axis.spines[['top', 'right']].set_visible(False)
        axis.tick_params(labelsize=8)
    save(figure_, path)


def draw_all(folder):
    """Draw the tell-tale of each effect of the catalogue."""
    folder.mkdir(parents=True, exist_ok=True)
    for identity in catalogue():
        draw(identity, folder / f'{identity}.png')
