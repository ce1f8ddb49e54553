# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The drive as equations; ``compose`` turns this text into the code that runs.

A line ``# slot NAME`` is where the terms of the effects enter: ``compose`` puts one guarded
line per effect there. Everything is scalar, so that the same text runs in plain Python and
compiled by numba. Without effects this file is the baseline, Eqs. (1) to (8) of the
drill-drive paper. It is long because it is one text: compiled code calls no file of its own, and
the balances are read side by side.
"""
import math


def find(x, y, number, cells, layout):
    """Note in which cell of a table ``x`` and ``y`` lie; see ``baseline_tables``."""
    cell = layout[number, 0]
    while x > cells[cell, 1]:
        cell += layout[number, 1]
    while x < cells[cell, 0]:
        cell -= layout[number, 1]
    while y > cells[cell, 3]:
        cell += layout[number, 2]
    while y < cells[cell, 2]:
        cell -= layout[number, 2]
    layout[number, 0] = cell


def interpolate(x, number, cells, layout):
    """Look a value up in a table over one variable: linear, end values held."""
    cell = layout[number, 0]
    if not cells[cell, 0] <= x <= cells[cell, 1]:
        find(x, 0.0, number, cells, layout)
        cell = layout[number, 0]
    return cells[cell, 4] + cells[cell, 5] * x


def along(x, between_points, number, bulge, cells, layout):
    """Look a curve up that may bend between its points: at 1 it is straight, at 2 smooth."""
    found = interpolate(x, number, cells, layout)
    if between_points != 1.0:
        found += (between_points - 1.0) * interpolate(x, bulge, cells, layout)
    return found


def waved(value, command, lowest_command, command_range, displacement_wave_1,
          displacement_wave_2, displacement_wave_3):
    """Return the value of a curve at a command, if the curve has waves that a sheet lacks."""
    first, second, third = (
        displacement_wave_1 - 1.0, displacement_wave_2 - 1.0, displacement_wave_3 - 1.0)
    if first == 0.0 and second == 0.0 and third == 0.0:
        return value
    # Cosines of one, two and three half waves along the curve.
    wave = math.cos(math.pi * min(max((command - lowest_command) / command_range, 0.0), 1.0))
    return value * (1.0 + first * wave + second * (2.0 * wave * wave - 1.0)
                    + third * (4.0 * wave * wave - 3.0) * wave)


def of_unit(efficiency, pressure, rated_pressure, motor_efficiency_scale, torque_loss,
            efficiency_tilt, efficiency_bend):
    """Return the efficiency of a unit's hydromotor whose sheet gives this one."""
    lossy = efficiency - (torque_loss - 1.0) * (1.0 - efficiency)
    if efficiency_tilt == 1.0 and efficiency_bend == 1.0:
        return lossy * motor_efficiency_scale
    along = 2.0 * min(max(pressure / rated_pressure, 0.0), 1.0) - 1.0
    return lossy * (motor_efficiency_scale * (
        1.0 + (efficiency_tilt - 1.0) * along + (efficiency_bend - 1.0) * (
            2.0 * along * along - 1.0)))


def interpolate2(x, y, number, cells, layout):
    """Look a value up in a table over two variables: bilinear, end values held."""
    cell = layout[number, 0]
    if not (cells[cell, 0] <= x <= cells[cell, 1] and cells[cell, 2] <= y <= cells[cell, 3]):
        find(x, y, number, cells, layout)
        cell = layout[number, 0]
    return cells[cell, 4] + cells[cell, 5] * x + (cells[cell, 6] + cells[cell, 7] * x) * y


def smooth_sign(speed):
    """Return the sign of a speed, smooth around standstill."""
    if speed > SIGN_SATURATED:
        return 1.0
    if speed < -SIGN_SATURATED:
        return -1.0
    return math.tanh(speed / SIGN_WIDTH)


def played(follower, last, command, half, softness):
    """
    Return where the follower of a play goes when the command moves from ``last`` to ``command``.

    Hard (softness 0): the play operator. Soft: what the play holds back, z, command minus
    follower, grows as with Bouc and Wen, ``dz/du = 1 - |z/half|^(1/softness)`` on the way out and
    1 on the way back.
    """
    if softness < 0.02:
        return min(max(follower, command - half), command + half)
    # Steps of a tenth of ``half``; after some forty of them the play is taken up anyhow.
    steps = min(int(10.0 * abs(command - last) / half) + 1, 40)
    change = (command - last) / steps
    held = min(max(last - follower, -half), half)
    for _ in range(steps):
        step = change
        if held * change > 0.0:
            step *= 1.0 - (abs(held) / half)**(1.0 / softness)
        held = min(max(held + step, -half), half)
    return command - held


def load_model(motor_speed, pprv_pressure, pprv_command, oil_temperature, motor_angle, p, on,
               cells, layout):
    """Return the torque with which the loading unit brakes, Eq. (7) with the gear ratio."""
    pistons = p[P_pistons]
    displacement = p[P_load_displacement] * p[P_gear_ratio]
    # What the speed does comes last: the next stage waits for it.
    pressure = (pprv_pressure - p[P_pprv_override] * p[P_pprv_reference_flow]
                + p[P_pprv_override] * displacement * abs(motor_speed))
    pressure = max(pressure, 0.0)
    load_torque = pressure * (displacement / p[P_load_efficiency_scale]) / interpolate(
        pressure, T_LOAD_EFFICIENCY, cells, layout)
    whole_load_torque = load_torque
    # slot load_torque
    return whole_load_torque


def shaft(twist, p, on):
    """Return stiffness (N.m/rad), damping (N.m.s/rad) and compliance of a flexible shaft."""
    shaft_compliance = 0.0
    # slot shaft_compliance
    shaft_damping_time = SHAFT_DAMPING_TIME
    # slot shaft_damping_time
    softness = max(shaft_compliance, SHAFT_RIGID / p[P_inertia])
    # Beyond twice the root nothing oscillates any more, and more would be stiff.
    shaft_damping_time = min(shaft_damping_time, 2.0 * math.sqrt(softness * p[P_inertia]))
    return 1.0 / softness, shaft_damping_time / softness, shaft_compliance


def twist_under(torque, p, on):
    """Return the twist at which a shaft that may harden carries a torque."""
    near, far = 0.0, torque / shaft(0.0, p, on)[0]
    for _ in range(50):
        middle = 0.5 * (near + far)
        if abs(middle) * shaft(middle, p, on)[0] < abs(torque):
            near = middle
        else:
            far = middle
    return far


def load_record(time, pprv_commands, motor_speeds, oil_temperatures, motor_angles, p, on, cells,
                layout, out):
    """
    Evaluate the load model over a record at the measured speed.

    The PPRV's first-order lag is solved exactly for a command held between samples. ``out`` gets
    what the torque sensor would read. On a flexible shaft that is not the load: what lies behind
    swings as the measured speed drives it (midpoint rule; the load's size by Adams and Bashforth).
    """
    pprv_pressure = load_speed = twist = last_brake = 0.0
    load_inertia = p[P_inertia]
    if on[SLOT_shaft_compliance]:
        shaft_load_share = SHAFT_LOAD_SIDE_SHARE
        # slot shaft_load_share
        load_inertia *= shaft_load_share
    n = len(time)
    for k in range(n):
        target = p[P_pprv_pressure_scale] * along(
            pprv_commands[k], p[P_pprv_between_points], T_PPRV_PRESSURE, T_PPRV_BULGE, cells,
            layout)
        if k == 0:
            pprv_pressure = target
        oil_temperature = oil_temperatures[k]
        motor_speed = motor_speeds[k]
        load_torque = 0.0
        if k == 0 or not on[SLOT_shaft_compliance]:
            load_torque = load_model(motor_speed, pprv_pressure, pprv_commands[k],
                                     oil_temperature, motor_angles[k], p, on, cells, layout)
        if k == 0:
            load_speed, last_brake = motor_speed, load_torque
        load_torque *= smooth_sign(motor_speed)
        following = min(k + 1, n - 1)
        interval = time[following] - time[k]
        if on[SLOT_shaft_compliance]:
            if k == 0:
                twist = twist_under(load_torque, p, on)
            stiffness, damping, shaft_compliance = shaft(twist, p, on)
            load_torque = stiffness * twist + damping * (motor_speed - load_speed)
            # A cubic through the rows: straight lines would cut off the tips of the swings.
            after, before = min(k + 2, n - 1), max(k - 1, 0)
            change = motor_speeds[following] - motor_speed
            slope = (motor_speeds[following] - motor_speeds[before]) / max(
                time[following] - time[before], 1e-9) * interval
            end_slope = (motor_speeds[after] - motor_speed) / max(
                time[after] - time[k], 1e-9) * interval
            steps = int(interval / min(SHAFT_STALL_STEP, SHAFT_STEP * math.sqrt(max(
                shaft_compliance * p[P_inertia], SHAFT_RIGID)))) + 1
            h = interval / steps
            for part in range(steps if k < n - 1 else 0):
                x = part / steps
                brake = load_model(
                    load_speed, target + (pprv_pressure - target) * math.exp(
                        -x * interval / p[P_pprv_lag]), pprv_commands[k], oil_temperature,
                    motor_angles[k] + x * (motor_angles[following] - motor_angles[k]), p, on,
                    cells, layout)
                # At the middle of the step.
                x += 0.5 / steps
                slip = motor_speed + x * (slope + x * (
                    3.0 * change - 2.0 * slope - end_slope
                    + x * (slope + end_slope - 2.0 * change))) - load_speed
                braking = 1.5 * brake - 0.5 * last_brake
                last_brake = brake
                stiffness, damping, shaft_compliance = shaft(twist + 0.5 * h * slip, p, on)
                direction = smooth_sign(load_speed)
                change_of_load_speed = h * (
                    stiffness * (twist + 0.5 * h * slip) + damping * slip - braking * direction
                ) / (load_inertia + 0.5 * h * (damping + 0.5 * h * stiffness + abs(braking) * (
                    1.0 - direction * direction) / SIGN_WIDTH))
                twist += h * (slip - 0.5 * change_of_load_speed)
                load_speed += change_of_load_speed
        torque_reading = load_torque
        # slot torque_reading
        out[k] = torque_reading
        pprv_pressure = target + (pprv_pressure - target) * math.exp(
            -interval / p[P_pprv_lag])


def balances(displacement, pump_pressure, motor_speed, pprv_pressure, motor_angle, load_speed,
             twist, slowdown, far_pressure, pump_command, pprv_command, oil_temperature,
             viscosity_ratio, disturbance, oil_compliance, oil_bend, p, on, cells, layout):
    """
    Evaluate all balances at one instant; without mass in the line its far pressure is NaN.

    Returns flow into the hydromotor, its inlet pressure, its torque, load torque, flow that the
    pump delivers beyond the relief valve's, pump speed, hydromotor leakage, compressibility,
    shaft torque, relief flow, pressure drop of the line, compliance of the shaft, change of the
    pump speed once it has settled and its lag, pressure at the hydromotor's outlet, displacement
    that pressure takes.
    """
    motor_displacement = p[P_motor_displacement]
    max_displacement = p[P_max_displacement]
    bulk_modulus = p[P_bulk_modulus]
    line_volume = p[P_volume]
    oil_density = p[P_oil_density]
    relief_pressure = rated_pressure = p[P_relief_set_pressure]
    pistons = p[P_pistons]
    characterised_at = p[P_characterised_at]
    nominal_speed = p[P_pump_shaft_speed]
    speed = abs(motor_speed)
    direction = smooth_sign(motor_speed)
    pump_leakage = p[P_pump_leakage_scale] * interpolate2(
        pump_pressure, pump_command, T_PUMP_LEAKAGE, cells, layout)
    pressure = pump_pressure
    motor_leakage = p[P_motor_leakage_scale] * interpolate2(
        pressure, speed, T_MOTOR_LEAKAGE, cells, layout)
    flow = motor_displacement * motor_speed + motor_leakage

    pump_speed = nominal_speed
    # slot pump_speed
    speed_change = pump_speed - nominal_speed
    pump_speed_lag = 0.0
    # slot pump_speed_lag
    if pump_speed_lag > PUMP_SPEED_AT_ONCE and not math.isnan(slowdown):
        pump_speed = nominal_speed + slowdown
    pump_flow_loss = 0.0
    # slot pump_flow_loss
    relief_flow = 0.0
    if pump_pressure > relief_pressure:
        relief_flow = p[P_relief_gain] * math.sqrt(
            max(pump_pressure - p[P_relief_reference_pressure], 0.0))
    pump_flow = displacement * pump_speed - pump_leakage - pump_flow_loss - relief_flow
    line_upstream_share = LINE_UPSTREAM_SHARE
    # slot line_upstream_share
    if math.isnan(far_pressure):
        # Through the resistance runs what the oil on either side of it does not take up.
        flow = pump_flow + line_upstream_share * (flow - pump_flow)
    line_drop = 0.0
    # slot line_drop
    # The pressure state stands for the whole line: part of the loss lies before its middle.
    pressure = pump_pressure - line_upstream_share * line_drop
    if not math.isnan(far_pressure):
        pressure = far_pressure
    motor_flow_loss = motor_flow_loss_kept = 0.0
    # slot motor_flow_loss
    # slot motor_flow_loss kept
    motor_leakage_total = motor_leakage + motor_flow_loss
    # What it takes along to its outlet is not drained.
    flow = motor_displacement * motor_speed + motor_leakage_total + motor_flow_loss_kept

    pump_yield = 0.0
    # slot pump_yield

    compliance = oil_compliance * (1.0 + oil_bend * pump_pressure)
    # slot compliance

    back_pressure = 0.0
    # slot back_pressure
    loss_pressure = 0.0
    # slot loss_pressure
    net_pressure = pressure - back_pressure + loss_pressure
    efficiency = of_unit(
        interpolate2(net_pressure, speed, T_MOTOR_EFFICIENCY, cells, layout), net_pressure,
        rated_pressure, p[P_motor_efficiency_scale], p[P_torque_loss], p[P_efficiency_tilt],
        p[P_efficiency_bend])
    load_side_speed = motor_speed
    load_direction = direction
    if on[SLOT_shaft_compliance]:
        load_side_speed = load_speed
        load_direction = smooth_sign(load_speed)
    load_torque = load_model(load_side_speed, pprv_pressure, pprv_command, oil_temperature,
                             motor_angle, p, on, cells, layout) * load_direction
    # What the model of the load does not explain brakes, too: it cannot move a drive at rest.
    load_torque += disturbance * abs(load_direction)

    motor_torque_loss = 0.0
    # slot motor_torque_loss
    motor_torque = 0.0
    # slot motor_torque
    # A cavitating inlet neither drives nor brakes.
    motor_torque_loss += (1.0 - efficiency) * loss_pressure * motor_displacement
    motor_torque += (efficiency * max(pressure - back_pressure, 0.0) * motor_displacement
                     - motor_torque_loss * direction)

    shaft_torque = load_torque
    shaft_compliance = 0.0
    if on[SLOT_shaft_compliance]:
        stiffness, damping, shaft_compliance = shaft(twist, p, on)
        shaft_torque = stiffness * twist + damping * (motor_speed - load_speed)
    return (flow, pressure, motor_torque, load_torque, pump_flow, pump_speed,
            motor_leakage_total, compliance, shaft_torque, relief_flow, line_drop,
            shaft_compliance, speed_change, pump_speed_lag, back_pressure, pump_yield)


def derivatives(flow, motor_torque, load_torque, pump_flow, compliance, shaft_torque,
                speed_change, pump_speed_lag, displacement, pump_pressure, motor_speed,
                pprv_pressure, load_speed, reading, slowdown, target, pprv_target, lag, rate,
                back_rate, reading_lag, near_share, per_inertia, per_pprv_lag, p, on):
    """
    Return the time derivatives of the first nine states from what the balances have found.

    ``flow`` leaves the share ``near_share`` of the line's volume that lies at the pump.
    """
    displacement_rate = (target - displacement) / lag
    if rate > 0.0:
        displacement_rate = min(max(displacement_rate, -back_rate), rate)
    # Not divided by what is known before: the next stage waits for both sums.
    stiffness = 1.0 / (compliance * (near_share * p[P_volume]))
    pressure_rate = (pump_flow - flow) * stiffness
    if pump_pressure <= CAVITATION_PRESSURE and pressure_rate < 0.0:
        pressure_rate = 0.0
    load_acceleration = 0.0
    twist_rate = 0.0
    if on[SLOT_shaft_compliance]:
        shaft_load_share = SHAFT_LOAD_SIDE_SHARE
        # slot shaft_load_share
        acceleration = (motor_torque - shaft_torque) * per_inertia / (1.0 - shaft_load_share)
        load_acceleration = (shaft_torque - load_torque) * per_inertia / shaft_load_share
        twist_rate = motor_speed - load_speed
    else:
        acceleration = (motor_torque - load_torque) * per_inertia
    reading_rate = 0.0
    if reading_lag > 0.0:
        reading_rate = (motor_speed - reading) / reading_lag
    slowdown_rate = 0.0
    if pump_speed_lag > PUMP_SPEED_AT_ONCE:
        slowdown_rate = (speed_change - slowdown) / pump_speed_lag
    return (displacement_rate, pressure_rate, acceleration,
            (pprv_target - pprv_pressure) * per_pprv_lag, motor_speed, load_acceleration,
            twist_rate, reading_rate, slowdown_rate)


def simulate(time, pump_commands, pprv_commands, oil_temperatures, viscosity_ratios, disturbances,
             motor_angles, state, p, on, cells, layout, max_step, out):
    """
    Integrate over a record with the classical Runge-Kutta method of fourth order.

    ``out[k]`` gets the readings at ``time[k]``; then the commands of sample k hold until
    ``time[k + 1]`` while the disturbance moves on a straight line. The step is cut near
    standstill and at the relief valve, where the equations are stiff. Where three rows close
    together had the same inputs, the next step is that of Adams and Bashforth, fourth order,
    too: one evaluation instead of four. ``state`` is updated. Where
    ``motor_angles`` is a number it takes the place of the integrated one: over minutes an error
    of a thousandth in speed turns the pistons out of phase.
    """
    n = len(time)
    displacement, pump_pressure, motor_speed = state[0], state[1], state[2]
    pprv_pressure, motor_angle, load_speed = state[3], state[4], state[5]
    twist, reading, play, last_command = state[6], state[7], state[8], state[9]
    slowdown, wide_play, pilot_aim = state[10], state[11], state[12]
    late_reading, line_flow, far_pressure = state[13], state[14], state[15]
    nominal_speed = p[P_pump_shaft_speed]
    max_displacement = p[P_max_displacement]
    # The fastest that Adams and Bashforth have to follow: the oil's spring with the inertia.
    swing = p[P_motor_displacement] * math.sqrt(p[P_bulk_modulus] / (p[P_volume] * p[P_inertia]))
    actuator = (on[SLOT_pump_command] or on[SLOT_pump_play] or on[SLOT_pump_play_softness]
                or on[SLOT_pump_play_spread] or on[SLOT_pump_lag] or on[SLOT_pump_series_lag]
                or on[SLOT_pump_stroke_time] or on[SLOT_pump_stroke_asymmetry])
    reads = (on[SLOT_pressure_reading] or on[SLOT_flow_reading] or on[SLOT_speed_reading]
             or on[SLOT_torque_reading])
    # Divided once, not in each evaluation.
    oil_compliance, per_inertia = 1.0 / p[P_bulk_modulus], 1.0 / p[P_inertia]
    oil_bend = (p[P_compressibility_under_pressure] - 1.0) / p[P_relief_set_pressure]
    per_pprv_lag = 1.0 / p[P_pprv_lag]
    line_inertance = 0.0
    # slot line_inertance
    line_far_share = LINE_FAR_SHARE
    # slot line_far_share
    line_damping = 0.0
    # slot line_damping
    near_share, wave = 1.0, line_inertance > 0.0
    if wave:
        near_share -= line_far_share
        # Of the line between its two volumes, rad/s; a faster one cannot be seen, and is stiff.
        between = near_share * line_far_share * p[P_volume] * oil_compliance
        line_inertance = max(line_inertance, 1.0 / (between * LINE_FASTEST**2))
        line_step = LINE_STEP * math.sqrt(line_inertance * between)
    # Whether any but the first five states moves by itself.
    extended = (on[SLOT_shaft_compliance] or on[SLOT_speed_reading_lag]
                or on[SLOT_pump_speed_lag])
    still = 0
    # Slopes at the last row, at the one before, and before that.
    a0 = a1 = a2 = a3 = a4 = a5 = a6 = a7 = a8 = 0.0
    b0 = b1 = b2 = b3 = b4 = b5 = b6 = b7 = b8 = 0.0
    c0 = c1 = c2 = c3 = c4 = c5 = c6 = c7 = c8 = 0.0
    for k in range(n):
        raw_command = pump_commands[k]
        pprv_command = pprv_commands[k]
        oil_temperature = oil_temperatures[k]
        viscosity_ratio = viscosity_ratios[k]
        disturbance = disturbances[k]
        if not math.isnan(motor_angles[k]):
            motor_angle = motor_angles[k]
        pump_command = raw_command
        pump_play = pump_play_softness = pump_play_spread = 0.0
        pump_lag = p[P_displacement_lag]
        pump_series_lag = max(p[P_displacement_series_lag] - 1.0, 0.0) * pump_lag
        pump_stroke_time = pump_stroke_asymmetry = 0.0
        if actuator:
            # slot pump_command
            # slot pump_play
            # slot pump_play_softness
            # slot pump_play_spread
            # slot pump_lag
            # slot pump_series_lag
            # slot pump_stroke_time
            # slot pump_stroke_asymmetry
            pass
        whole_command = pump_command
        if pump_play > 0.0:
            play = played(play, last_command, pump_command,
                          0.5 * pump_play * (1.0 - pump_play_spread), pump_play_softness)
            pump_command = play
            if pump_play_spread > 0.0:
                wide_play = played(wide_play, last_command, whole_command,
                                   0.5 * pump_play * (1.0 + pump_play_spread),
                                   pump_play_softness)
                pump_command = 0.5 * (play + wide_play)
        else:
            play = wide_play = pump_command
        last_command = whole_command
        shortest_lag = min(pump_lag, p[P_pprv_lag])
        rate = back_rate = 0.0
        if pump_stroke_time > 0.0:
            rate = max_displacement / pump_stroke_time * (1.0 + pump_stroke_asymmetry)
            back_rate = max_displacement / pump_stroke_time * (1.0 - pump_stroke_asymmetry)
        speed_reading_lag = speed_reading_series_lag = 0.0
        # slot speed_reading_lag
        # slot speed_reading_series_lag
        nearer = 1.0
        if speed_reading_lag <= 0.0:
            reading = motor_speed
        else:
            # A shorter lag would be stiff: of a longer one a part is as late.
            nearer = min(speed_reading_lag / (0.5 * max_step), 1.0)
            speed_reading_lag /= nearer
            shortest_lag = min(shortest_lag, speed_reading_lag)
        earlier_reading = motor_speed + nearer * (reading - motor_speed)
        if speed_reading_series_lag <= 0.0:
            late_reading = earlier_reading
        target = p[P_displacement_scale] * waved(
            along(pump_command, p[P_displacement_between_points], T_DISPLACEMENT,
                  T_DISPLACEMENT_BULGE, cells, layout),
            pump_command, p[P_lowest_command], p[P_command_range],
            p[P_displacement_wave_1], p[P_displacement_wave_2], p[P_displacement_wave_3])
        pprv_target = p[P_pprv_pressure_scale] * along(
            pprv_command, p[P_pprv_between_points], T_PPRV_PRESSURE, T_PPRV_BULGE, cells, layout)

        if pump_series_lag <= 0.0 or math.isnan(pilot_aim):
            pilot_aim = target
        # At rest steps may come from history.
        piloted = abs(pilot_aim - target) > PILOT_SETTLED * max_displacement
        if piloted:
            shortest_lag = min(shortest_lag, pump_series_lag)

        interval = time[min(k + 1, n - 1)] - time[k]
        span = min(interval, max_step)
        pilot_share = pilot_stages = 1.0
        if 0.0 < pump_series_lag < 0.5 * span:
            # Too short for the stages of a step to follow: its mean over the step.
            pilot_share = pump_series_lag / span * (1.0 - math.exp(-span / pump_series_lag))
            pilot_stages = 0.0
        slope = disturbances[min(k + 1, n - 1)] - disturbance
        if slope != 0.0:
            slope /= max(interval, 1e-12)
        last = max(k - 1, 0)
        still += 1
        if (raw_command != pump_commands[last] or pprv_command != pprv_commands[last]
                or oil_temperature != oil_temperatures[last] or slope != 0.0
                or disturbance != disturbances[last]
                or abs(interval - (time[k] - time[last])) > 1e-9):
            still = 0
        elapsed = 0.0
        while True:
            # One place for all four stages, so that the balances are compiled once. A stage
            # stands ``ahead`` of the step's start; x0 to x8 are the states there, s0 to s8 the
            # weighted sums of the slopes.
            x0, x1, x2, x3, x4 = (displacement, pump_pressure, motor_speed, pprv_pressure,
                                  motor_angle)
            x5, x6, x7, x8 = load_speed, twist, reading, slowdown
            x9, x10 = line_flow, math.nan
            if wave:
                x10 = x1 if math.isnan(far_pressure) else far_pressure
            s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = s8 = s9 = s10 = 0.0
            step = ahead = 0.0
            stiff = False
            for stage in range(4):
                (flow, pressure, motor_torque, load_torque, pump_flow, pump_speed, leakage,
                 compliance, shaft_torque, relief_flow, line_drop, shaft_compliance,
                 speed_change, pump_speed_lag, back_pressure, pump_yield) = balances(
                    x0, x1, x2, x3, x4, x5, x6, x8, x10, pump_command, pprv_command,
                    oil_temperature, viscosity_ratio, disturbance + slope * (elapsed + ahead),
                    oil_compliance, oil_bend, p, on, cells, layout)
                if stage == 0 and elapsed == 0.0:
                    if k == 0 and math.isnan(slowdown):
                        # Not known at the start: taken as settled.
                        slowdown = x8 = speed_change
                    if wave and math.isnan(far_pressure):
                        # So is what stands in the line.
                        line_flow, far_pressure = flow, x1 - line_drop
                        x9, x10 = line_flow, far_pressure
                    # Of the stage, not of the step, or the compiler takes what effects do with it
                    # (a sine) out of this block and does it in every step.
                    motor_angle = x4
                    pressure_reading = x1 if wave else pressure + line_drop
                    flow_reading = flow
                    speed_reading = late_reading
                    torque_reading = shaft_torque
                    if reads:
                        # slot pressure_reading
                        # slot flow_reading
                        # slot speed_reading
                        # slot torque_reading
                        pass
                    out[k, 0] = pressure_reading
                    out[k, 1] = flow_reading
                    out[k, 2] = speed_reading
                    out[k, 3] = torque_reading
                    out[k, 4] = displacement
                    out[k, 5] = pressure
                    out[k, 6] = leakage
                    out[k, 7] = pump_speed
                    out[k, 8] = motor_torque
                    out[k, 9] = pump_flow + relief_flow
                    out[k, 10] = relief_flow
                    out[k, 11] = pprv_pressure
                    out[k, 12] = back_pressure
                    if k == n - 1:
                        break
                aim = target
                if piloted:
                    # The lag before the swash plate's own: exact, since the command holds.
                    aim += pilot_share * (pilot_aim - target) * math.exp(
                        -(elapsed + pilot_stages * ahead) / pump_series_lag)
                leaving = x9 if wave else flow
                r0, r1, r2, r3, r4, r5, r6, r7, r8 = derivatives(
                    leaving, motor_torque, load_torque, pump_flow, compliance, shaft_torque,
                    speed_change, pump_speed_lag, x0, x1, x2, x3, x5, x7, x8, max(
                        aim - pump_yield, min(aim, 0.0)),
                    pprv_target, pump_lag, rate, back_rate, speed_reading_lag, near_share,
                    per_inertia, per_pprv_lag, p, on)
                r9 = r10 = 0.0
                if wave:
                    r9 = (x1 - x10 - line_drop) / line_inertance - line_damping * (x9 - flow)
                    r10 = (x9 - flow) / (compliance * (line_far_share * p[P_volume]))
                    if x10 <= CAVITATION_PRESSURE and r10 < 0.0:
                        r10 = 0.0
                if stage == 0:
                    step = max_step
                    if on[SLOT_shaft_compliance]:
                        step = min(step, SHAFT_STEP * math.sqrt(
                            max(shaft_compliance * p[P_inertia], SHAFT_RIGID)))
                    if compliance != oil_compliance * (1.0 + oil_bend * x1) and (
                            abs(r1) * step > BEND_COMPLIANCE):
                        # What gas adds to the oil's spring changes within a few bar.
                        step = max(BEND_COMPLIANCE / abs(r1), 0.1 * max_step)
                    if wave:
                        step = min(step, line_step)
                        still = -1
                    # A full step would start in, or run into, what is stiff.
                    if abs(motor_speed) < STIFF_SPEED + abs(r2) * step or (
                            pump_pressure + max(r1, 0.0) * step
                            > STIFF_PRESSURE_SHARE * p[P_relief_set_pressure]):
                        stiff = True
                        step = min(step, 0.1 * max_step)
                    if on[SLOT_shaft_compliance] and (
                            abs(load_speed) < 2.0 * STIFF_SPEED + abs(r5) * step):
                        # So much less inertia meets the same friction at standstill.
                        stiff = True
                        step = min(step, 0.1 * max_step) * SHAFT_STIFF_SHARE
                    if stiff or pump_pressure <= CAVITATION_PRESSURE:
                        still = -1
                    # The differences of third order are great where a corner lies behind, and
                    # grow where the damping is too strong for this method.
                    from_history = (
                        still >= 3 and elapsed == 0.0 and interval <= 0.4001 * step
                        and interval * swing < 0.2 and 5.0 * interval < shortest_lag
                        and interval * abs(r1 - 3.0 * a1 + 3.0 * b1 - c1) < BEND_PRESSURE
                        and interval * abs(r2 - 3.0 * a2 + 3.0 * b2 - c2) < BEND_SPEED
                        and (not extended
                             or interval * abs(r5 - 3.0 * a5 + 3.0 * b5 - c5) < BEND_SPEED))
                    if from_history:
                        step = interval
                        s0 = 13.75 * r0 - 14.75 * a0 + 9.25 * b0 - 2.25 * c0
                        s1 = 13.75 * r1 - 14.75 * a1 + 9.25 * b1 - 2.25 * c1
                        s2 = 13.75 * r2 - 14.75 * a2 + 9.25 * b2 - 2.25 * c2
                        s3 = 13.75 * r3 - 14.75 * a3 + 9.25 * b3 - 2.25 * c3
                        s4 = 13.75 * r4 - 14.75 * a4 + 9.25 * b4 - 2.25 * c4
                        if extended:
                            s5 = 13.75 * r5 - 14.75 * a5 + 9.25 * b5 - 2.25 * c5
                            s6 = 13.75 * r6 - 14.75 * a6 + 9.25 * b6 - 2.25 * c6
                            s7 = 13.75 * r7 - 14.75 * a7 + 9.25 * b7 - 2.25 * c7
                            s8 = 13.75 * r8 - 14.75 * a8 + 9.25 * b8 - 2.25 * c8
                    if elapsed == 0.0:
                        c0, c1, c2, c3, c4 = b0, b1, b2, b3, b4
                        b0, b1, b2, b3, b4 = a0, a1, a2, a3, a4
                        a0, a1, a2, a3, a4 = r0, r1, r2, r3, r4
                        if extended:
                            c5, c6, c7, c8 = b5, b6, b7, b8
                            b5, b6, b7, b8 = a5, a6, a7, a8
                            a5, a6, a7, a8 = r5, r6, r7, r8
                    if from_history:
                        break
                    remaining = interval - elapsed
                    step = remaining / max(math.ceil(remaining / step - 1e-9), 1.0)
                weight = 1.0 if stage == 0 or stage == 3 else 2.0
                s0 += weight * r0
                s1 += weight * r1
                s2 += weight * r2
                s3 += weight * r3
                s4 += weight * r4
                s5 += weight * r5
                s6 += weight * r6
                s7 += weight * r7
                s8 += weight * r8
                s9 += weight * r9
                s10 += weight * r10
                ahead = step if stage == 2 else 0.5 * step
                x0 = displacement + ahead * r0
                x1 = pump_pressure + ahead * r1
                x2 = motor_speed + ahead * r2
                x3 = pprv_pressure + ahead * r3
                x4 = motor_angle + ahead * r4
                x5 = load_speed + ahead * r5
                x6 = twist + ahead * r6
                x7 = reading + ahead * r7
                x8 = slowdown + ahead * r8
                x9 = line_flow + ahead * r9
                x10 = far_pressure + ahead * r10 if wave else math.nan
            if k == n - 1:
                break
            w = step / 6.0
            displacement += w * s0
            pump_pressure = max(pump_pressure + w * s1, CAVITATION_PRESSURE)
            motor_speed += w * s2
            pprv_pressure += w * s3
            motor_angle += w * s4
            load_speed += w * s5
            twist += w * s6
            reading += w * s7
            slowdown += w * s8
            if wave:
                line_flow += w * s9
                far_pressure = max(far_pressure + w * s10, CAVITATION_PRESSURE)
            elapsed += step
            if interval - elapsed <= 1e-12:
                break
        if pump_series_lag > 0.0:
            pilot_aim = target + (pilot_aim - target) * math.exp(-interval / pump_series_lag)
        if speed_reading_lag <= 0.0:
            reading = motor_speed
        if speed_reading_series_lag > 0.0 and interval > 0.0:
            # The second lag of the reading: exact for a first one that moves on a straight line.
            first_reading = motor_speed + nearer * (reading - motor_speed)
            behind = (first_reading - earlier_reading) / interval * speed_reading_series_lag
            late_reading = first_reading - behind + (
                late_reading - earlier_reading + behind) * math.exp(
                -interval / speed_reading_series_lag)
        if not (abs(motor_speed) < 1e4 and abs(pump_pressure) < 1e11):
            for i in range(k + 1, n):
                for j in range(out.shape[1]):
                    out[i, j] = math.nan
            break
    state[0], state[1], state[2] = displacement, pump_pressure, motor_speed
    state[3], state[4], state[5] = pprv_pressure, motor_angle, load_speed
    state[6], state[7], state[8], state[9] = twist, reading, play, last_command
    state[10], state[11], state[12], state[13] = slowdown, wide_play, pilot_aim, late_reading
    state[14], state[15] = line_flow, far_pressure
