# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
How the equations of any circuit run over a record: text for ``circuit_code``.

A state that is told follows the record, on straight lines between rows; the others are integrated.
Where something jumps or bends, that is done by the classical Runge-Kutta method of fourth order.
Elsewhere an exponential method of Adams and Bashforth, of fourth order too, needs one evaluation
a step (Norsett 1969; Hochbruck and Ostermann 2010, section 2.5): each state ``x`` decays by a rate
``d`` of its own, ``x' = -d * x + N``, which is solved exactly for the cubic through the last four
``N``. Any ``d`` is right to fourth order; that of the equations keeps stiff states stable. The
first slope behind a step tells whether the step was too long.
"""
import math


def weigh(z, i, weights):
    """
    Write what a step takes of state ``i`` and of its last four ``N``.

    In the step it decays by ``z``. The weights come from the integrals of
    ``exp(-z * (1 - s)) * s**j`` over the step: the one for j = 3 by its series, the others by
    parts.
    """
    cube, term = 0.0, 0.25
    for m in range(5, 60):
        cube += term
        term *= -z / m
    square = (1.0 - z * cube) / 3.0
    line = (1.0 - z * square) / 2.0
    flat = 1.0 - z * line
    second, third = 0.5 * (square + line), (cube + 3.0 * square + 2.0 * line) / 6.0
    weights[0, i] = 1.0 - z * flat
    weights[1, i] = flat + line + second + third
    weights[2, i] = -line - 2.0 * second - 3.0 * third
    weights[3, i] = second + 3.0 * third
    weights[4, i] = -third


def run(time, commands, inputs, varied, told, record, state, memory, p, on, cells, layout,
        max_step, work, out):
    """
    Evaluate or integrate a circuit.

    ``commands`` hold until the next row; ``inputs``, one column for each place in ``varied``, and
    what is ``told`` of ``record`` move on straight lines. ``out[k]`` gets the quantities at
    ``time[k]``, ``record`` the states that are not told, ``state`` and ``memory`` the last ones.
    ``work`` is room; its first row holds the inputs that do not vary, its last one what states do
    not fall below.
    """
    n = len(time)
    now, size, here, slope, first = work[0], work[1], work[2], work[3], work[4]
    total, last, held, before, found, decay = work[5], work[6], work[7], work[8], work[9], work[10]
    past, passed, weights, least = work[11:15], work[15:19], work[19:24], work[24]
    free = others = False
    for i in range(STATES):
        if told[i] == 0:
            free = True
            others = others or i > 0
    even, calm, wait, turn = 0, 0, 3, 0     # steps of one length since something jumped or bent
    a = b = c = d = 0                       # where the last four stand, from the newest
    whole_step = trial = 0.0
    known = bends = False                   # the slopes at this row's start; a jump or a bend
    for k in range(n):
        after = min(k + 1, n - 1)
        interval = time[after] - time[k]
        hold_row(commands, k, interval, memory, p, on, cells, layout, held)
        steps = int(math.ceil(interval / max_step - 1e-9)) if free else 0
        step = interval / max(steps, 1)
        if abs(step - whole_step) > 1e-6 * step:
            whole_step, trial, bends = step, step, True
        for i in range(HELD):
            if held[i] != before[i]:
                known = False
            before[i] = held[i]
        # One place for all evaluations, so that the equations are compiled once. At stage 0 a
        # step has arrived ``here``; 1 to 3 are those of Runge and Kutta; then each state is
        # nudged for its decay.
        stage, by_history, done, goal, length = 0, False, 0.0, 0.0, 0.0
        if known:
            stage = -1
        else:
            for i in range(STATES):
                here[i] = state[i]
        while True:
            nudged = stage - 4
            if stage >= 0:
                share = goal
                if stage == 1 or stage == 2:
                    share = 0.5 * (done + goal)
                if nudged >= 0:
                    share = done
                for i in range(len(varied)):
                    now[varied[i]] = inputs[after, i] if share == 1.0 else (
                        inputs[k, i] + share * (inputs[after, i] - inputs[k, i]))
                for i in range(STATES):
                    if told[i]:
                        here[i] = record[after, i] if share == 1.0 else (
                            record[k, i] + share * (record[after, i] - record[k, i]))
                evaluate(here, held, now, p, on, cells, layout, slope, found,
                         others or goal == 0.0)
            if nudged >= 0:
                decay[nudged] = 0.0
                if told[nudged] == 0 and size[nudged] > 0.0:
                    decay[nudged] = min(max((first[nudged] - slope[nudged]) / (
                        NUDGE * size[nudged]), 0.0), MOST_DECAY / step)
                here[nudged] = state[nudged]
                stage += 1
                if nudged < STATES - 1:
                    here[nudged + 1] += NUDGE * size[nudged + 1]
                    continue
                for i in range(STATES):
                    weigh(decay[i] * step, i, weights)
                    for j in range(4):
                        past[j, i] += decay[i] * passed[j, i]
                even, calm = 4, 0
            elif stage > 0:
                for i in range(STATES):
                    total[i] += slope[i] * (length / 6.0 if stage == 3 else length / 3.0)
                    here[i] = max(least[i], state[i] + (
                        total[i] if stage == 3 else
                        slope[i] * (length if stage == 2 else 0.5 * length)))
                    last[i] = slope[i]
                stage += 1
                if stage == 4:
                    stage = 0
                    if goal == 1.0 and not others:
                        for i in range(STATES):
                            state[i] = here[i]
                        break
                continue
            else:
                again = False
                if stage == 0 and goal > 0.0 and others:
                    # By the first slope behind a step: was it right?
                    for i in range(STATES):
                        if told[i]:
                            continue
                        if by_history:
                            error = STRICTER * length * abs(
                                slope[i] + decay[i] * here[i] - 4.0 * past[a, i]
                                + 6.0 * past[b, i] - 4.0 * past[c, i] + past[d, i])
                        else:
                            # A jump in the first half shows in the bend of the stages alone.
                            error = length / 6.0 * abs(slope[i] - last[i]) + BENT * abs(
                                length * (first[i] + last[i]) - 2.0 * total[i])
                        again = again or error > STEP_ERROR * size[i]
                    if by_history and again:
                        wait, bends = 3 if calm > 16 else min(2 * wait, 96), True
                    elif not by_history:
                        again = again and length > SHORTEST * step
                        trial = 0.5 * length if again else min(2.0 * length, step)
                if again:
                    calm = 0
                elif stage == 0:
                    turn, calm = turn + 1, calm + 1
                    a, b, c, d = turn & 3, turn - 1 & 3, turn - 2 & 3, turn - 3 & 3
                    for i in range(STATES):
                        state[i] = here[i]
                        if by_history:
                            past[a, i] = slope[i] + decay[i] * here[i]
                        else:
                            first[i] = slope[i]
                            if others:
                                past[a, i], passed[a, i] = slope[i], here[i]
                                size[i] = max(size[i], abs(here[i]), SIZE_SPAN * abs(slope[i]))
                    if goal == 0.0 or length < 0.999 * step:
                        even = 0
                    elif even < 3:
                        even += others
                    done = goal
                    known = others
                if done == 0.0 and not again:
                    for i in range(QUANTITIES):
                        out[k, i] = found[i]
                    for i in range(STATES):
                        record[k, i] = state[i]
                if done == 1.0 or steps == 0:
                    break
            remaining = (1.0 - done) * interval
            if even == 3 and calm >= wait and not bends and remaining > 0.999 * step:
                stage = 4
                here[0] += NUDGE * size[0]
                continue
            by_history = even > 3 and not bends and remaining > 0.999 * step
            if even > 3 and not by_history:
                bends = True
                for i in range(STATES):
                    first[i] = past[a, i] - decay[i] * state[i]
                    past[a, i] = first[i]
            if bends:
                even, bends = 0, False
            length = step if by_history else min(trial, remaining)
            goal = done + length / interval
            if goal > 1.0 - 1e-9:
                goal = 1.0
            for i in range(STATES):
                if by_history:
                    here[i] = max(least[i], weights[0, i] * state[i] + step * (
                        weights[1, i] * past[a, i] + weights[2, i] * past[b, i]
                        + weights[3, i] * past[c, i] + weights[4, i] * past[d, i]))
                else:
                    total[i] = length / 6.0 * first[i]
                    here[i] = max(least[i], state[i] + 0.5 * length * first[i])
            stage = 0 if by_history else 1
