# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``demo``: the main job, start to end, in about a minute, without questions.

The nodes drill through changing rock on a rig with something that the model lacks, and record
it; the model is laid beside the recording; the tool names what is missing; it is added, and the
error falls.
"""
from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from hst_drive.cli.output import say, table

if TYPE_CHECKING:
    from hst_drive.load.ground import Ground
    from hst_drive.measure.run import Run

HELP = 'drill, record, compare, find what the model lacks, add it: the main job in a minute'
_HIDDEN = 'motor_leakage.conductance=0.0078[L/min/bar]'
_RUNS = ('layered_ground', 'commissioning')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('-o', '--output', metavar='FOLDER',
                        help='where everything goes (default: hst_drive_demo, numbered)')


def run(args: argparse.Namespace) -> int:
    """Run the demo."""
    from hst_drive.errors import InputError

    folder = Path(args.output) if args.output else _free('hst_drive_demo')
    try:
        folder.mkdir(parents=True)
    except OSError as error:
        raise InputError(f'{folder}: cannot be made ({error.strerror}); choose another folder '
                         'with -o') from None
    _say_step(1, 'The nodes drill on a rig that hides something, and record it')
    bags = [str(_record(name, folder / name)) for name in _RUNS]
    _drilled(bags[0])
    _say_step(2, 'The model beside the recording')
    from hst_drive.bag import read_log
    runs = [read_log(bag) for bag in bags]
    _compared(runs)
    _say_step(3, 'What is missing?')
    rig_file = _diagnosed(runs, folder)
    if rig_file is None:
        say(f'the hidden effect ({_HIDDEN}) was not found: the demo ends here')
        return 1
    _say_step(4, 'The same comparison with it')
    _compared(runs, rig_file)
    called = os.environ.get('HST_DRIVE_CALLED') or 'hst-drive'   # ./dev says how it was called
    print(f'\nbags: {bags[0]} (drilling) and {bags[1]} (commissioning, commands by hand)\n'
          f'the rig with what was found: {rig_file}\n'
          f'again, step by step:\n'
          f'  {called} compare {bags[0]} --plot drilling.png\n'
          f'  {called} diagnose {" ".join(bags)} --json diagnosis.json\n'
          f'  {called} adopt diagnosis.json -o rig.yaml\n'
          f'  {called} compare {bags[0]} --rig rig.yaml')
    return 0


def _free(name: str) -> Path:
    for number in range(1, 10000):
        path = Path(name if number == 1 else f'{name}_{number}')
        if not path.exists():
            return path
    return Path(f'{name}_10000')


def _say_step(number: int, what: str) -> None:
    print(f'\n{number}. {what}\n', flush=True)


def _record(name: str, folder: Path) -> Path:
    from hst_drive.cli.run import progress_line
    from hst_drive.nodes.plan import make_plan, Options
    from hst_drive.nodes.runner import execute

    plan = make_plan(Options(name, str(folder), effects=(_HIDDEN,)))
    say(f'{plan.title}: {plan.duration:g} s, recording to {plan.output}')
    result = execute(plan, progress_line(plan.duration), lambda node, line: None)
    if result['interrupted']:
        raise KeyboardInterrupt
    return folder


def _drilled(bag: str) -> None:
    """Print how the speed was held, rock by rock."""
    import numpy as np

    from hst_drive.bag import read_log
    from hst_drive.load import load_scenario
    from hst_drive.units import from_si

    run = read_log(bag)
    ground: Ground = load_scenario(_RUNS[0]).load.torque_profile
    rows = []
    for rock, start, end in _layers(ground):
        part = run.between(run.time[0] + start, run.time[0] + end)
        if len(part) < 10:
            continue
        speed = from_si(part['motor_speed'], 'rpm')
        wanted = from_si(part['speed_setpoint'], 'rpm')
        off = speed - wanted
        rows.append([rock, f'{start:.1f} to {end:.1f}', f"{np.mean(part['load_torque']):.0f}",
                     f"{np.mean(from_si(part['pump_outlet_pressure'], 'bar')):.1f}",
                     f"{np.mean(part['pump_command']):.2f}", f'{np.mean(speed):.2f}',
                     f'{off[np.argmax(np.abs(off))]:+.1f}'])
    print(table(['rock', 'time [s]', 'torque [N.m]', 'pressure [bar]', 'pump command [V]',
                 'speed [rpm]', 'worst excursion [rpm]'], rows))


def _layers(ground: Ground) -> list[tuple[str, float, float]]:
    """Return rock, start and end (s) of each layer that was drilled."""
    import numpy as np

    bottoms = np.cumsum([layer.thickness for layer in ground.layers])
    touched = float(ground.time[int(np.argmax(ground.depth > 0))])
    times = [touched, *(float(np.interp(bottom, ground.depth, ground.time))
                        for bottom in bottoms[:-1]), float(ground.time[-1])]
    return [(layer.rock, start, end)
            for layer, start, end in zip(ground.layers, times, times[1:]) if end > start]


def _compared(runs: list[Run], rig_file: str | None = None) -> None:
    from hst_drive.measure.compare import compare
    from hst_drive.model import Drive
    from hst_drive.report.comparison import text
    from hst_drive.rig import load_rig

    result = compare(Drive(load_rig(rig_file)), runs)
    print(text(result, most_regions=3))
    drilling = result.logs[0].signals
    print("\nRussell's comprehensive error while drilling (the paper: speed below 3 %, pressure "
          f"3.1 %): speed {100 * drilling['motor_speed'].russell.comprehensive:.2f} %, pressure "
          f"{100 * drilling['pump_outlet_pressure'].russell.comprehensive:.2f} %")


def _diagnosed(runs: list[Run], folder: Path) -> str | None:
    """Print what is missing; return the file of the rig with it, None if nothing was found."""
    from hst_drive.cli.diagnose import progress_line
    from hst_drive.cli.output import write_json, write_yaml
    from hst_drive.diagnose.adopt import adopt
    from hst_drive.diagnose.decide import diagnose
    from hst_drive.diagnose.result import as_json
    from hst_drive.report.diagnosis import text
    from hst_drive.rig import default_rig_file, load_rig
    from hst_drive.rig.yaml_file import read_yaml

    source = str(default_rig_file())
    result = diagnose(load_rig(source), runs, progress=progress_line())
    print(text(result, short=True))
    content = as_json(result)
    write_json(content, folder / 'diagnosis.json')
    rig_file = folder / 'rig.yaml'
    if not result.effects:
        return None
    write_yaml(adopt(read_yaml(source), content, str(folder / 'diagnosis.json'), source),
               rig_file)
    return str(rig_file)
