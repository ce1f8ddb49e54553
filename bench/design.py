# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Whether the advised test ends the ambiguity.

    python -m bench.design --cases 20 --seed 500 --json design.json

Every case is a drive of the independent truth generator with one hidden effect and a unit of
its own. Its first log is 30 s of drilling at one speed and one temperature. Where the
diagnosis of that is ambiguous, the advised test is recorded on the same unit and both logs are
diagnosed together. Prints each case and the share of ambiguities that end with the right name.
"""
import argparse
import json
from test.diagnose.ambiguous import case, Outcome
import time

from hst_drive.rig import default_rig

TRUTHS = ('bearing_friction', 'back_pressure', 'pressure_sensor_bias', 'line_loss',
          'viscous_drag', 'hydrodynamic_drag', 'stribeck_friction', 'motor_leakage',
          'pump_leakage', 'elastic_leakage', 'compressibility_flow', 'pump_speed_droop',
          'flow_sensor_scale', 'torque_sensor_scale', 'gearbox_loss', 'pump_command_offset')


def main() -> None:
    """Run the cases."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--cases', type=int, default=20, help='ambiguous ones to collect')
    parser.add_argument('--seed', type=int, default=500)
    parser.add_argument('--most', type=int, default=200, help='drives to try')
    parser.add_argument('--json')
    args = parser.parse_args()
    rig, outcomes, tried = default_rig(), [], 0
    while sum(entry.before == 'ambiguous' for entry in outcomes) < args.cases \
            and tried < args.most:
        started = time.monotonic()
        outcomes.append(case(rig, TRUTHS[(args.seed + tried) % len(TRUTHS)], args.seed + tried))
        tried += 1
        entry = outcomes[-1]
        print(f'{entry.seed} {entry.truth}: {entry.before}', end='')
        if entry.before == 'ambiguous':
            print(f' ({", ".join(entry.rivals)}); {entry.advice}: {entry.test}, '
                  f'{entry.expected:.1f} sigma; {entry.after} {"+".join(entry.named)}: '
                  f'{"or " + ", ".join(entry.left) + " " if entry.left else ""}'
                  f'{_word(entry)}', end='')
        else:
            print(f' {"+".join(entry.named)}', end='')
        print(f' ({time.monotonic() - started:.0f} s)', flush=True)
        if args.json:
            with open(args.json, 'w', encoding='utf-8') as stream:
                json.dump([item._asdict() | {'right': item.right} for item in outcomes], stream,
                          indent=1)
    doubtful = [entry for entry in outcomes if entry.before == 'ambiguous']
    print(f'{sum(entry.right for entry in doubtful)} of {len(doubtful)} ambiguities ended with '
          f'the right name alone (in {sum(e.right and e.after == "unknown" for e in doubtful)} of '
          f'them something beside it stays unknown); in {sum(e.kept for e in doubtful)} more a '
          f'set stays and the gauge that tells was named; {tried} drives tried')


def _word(entry: Outcome) -> str:
    return 'right' if entry.right else 'a gauge was named' if entry.kept else 'NOT RIGHT'


if __name__ == '__main__':
    main()
