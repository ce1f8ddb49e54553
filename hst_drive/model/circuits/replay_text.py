# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How the equations of any circuit run over a record: text for ``circuit_code``.

A state that is told follows the record, on straight lines between rows; the others are integrated
by the classical Runge-Kutta method of fourth order.
"""
import math


def run(time, commands, inputs, told, record, state, memory, p, on, cells, layout, max_step, work,
        out):
    """
    Evaluate or integrate a circuit.

    ``commands`` hold until the next row, ``inputs`` and what is ``told`` of ``record`` move on
    straight lines. ``out[k]`` gets the quantities at ``time[k]``, ``record`` the states that are
    not told, ``state`` and ``memory`` the last ones. ``work`` is room: rows for states, slopes,
    their sum, what is held, inputs, quantities.
    """
    n, size, width = len(time), len(state), inputs.shape[1]
    here, slope, total, held, now, found = work[0], work[1], work[2], work[3], work[4], work[5]
    free = others = False
    for i in range(size):
        if told[i] == 0:
            free = True
            others = others or i > 0
        else:
            state[i] = record[0, i]
    for k in range(n):
        after = min(k + 1, n - 1)
        interval = time[after] - time[k]
        hold_row(commands, k, interval, memory, p, on, cells, layout, held)
        steps = int(math.ceil(interval / max_step - 1e-9)) if free else 0
        step = interval / max(steps, 1)
        for part in range(max(steps, 1)):
            for i in range(size):
                total[i] = 0.0
                here[i] = state[i]
            for stage in range(4):
                ahead = 0.0 if stage == 0 else 1.0 if stage == 3 else 0.5
                share = (part + ahead) / max(steps, 1)
                for i in range(width):
                    now[i] = inputs[k, i] + share * (inputs[after, i] - inputs[k, i])
                for i in range(size):
                    if told[i]:
                        here[i] = record[k, i] + share * (record[after, i] - record[k, i])
                    elif stage > 0:
                        here[i] = state[i] + ahead * step * slope[i]
                evaluate(here, held, now, p, on, cells, layout, slope, found,
                         others or stage == 0 and part == 0)
                if stage == 0 and part == 0:
                    for i in range(out.shape[1]):
                        out[k, i] = found[i]
                    for i in range(size):
                        if told[i] == 0:
                            record[k, i] = state[i]
                    if steps == 0:
                        break
                weight = step / 6.0 if stage == 0 or stage == 3 else step / 3.0
                for i in range(size):
                    total[i] += weight * slope[i]
            for i in range(size):
                if told[i]:
                    share = (part + 1.0) / max(steps, 1)
                    state[i] = record[k, i] + share * (record[after, i] - record[k, i])
                else:
                    state[i] += total[i]
