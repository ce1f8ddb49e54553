# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What each key of a rig file means, for people: where to find the number on a datasheet."""

MEANINGS: dict[str, dict[str, str]] = {
    'pump': {
        'shaft_speed_rpm': 'speed of the prime mover, where pump_speed is not recorded',
        'max_displacement_cc_rev': 'geometric displacement at full stroke',
        'displacement_vs_command': 'geometric displacement at each command, dead band included',
        'displacement_lag_s': 'time constant from command to stroke: 63 % of a small step',
        'leakage_L_min': 'flow that the outlet loses: theoretical less delivered flow',
        'mechanical_efficiency': 'theoretical over taken torque; counts only where pump_torque or '
                                 'pump_power is recorded',
    },
    'motor': {
        'displacement_cc_rev': 'geometric displacement of one hydromotor',
        'count': 'hydromotors that turn the shaft together, all alike (1 if not said)',
        'second_displacement_cc_rev': 'the smaller displacement of a two-speed hydromotor',
        'inertia_total_kg_m2': 'all that turns, at the measured shaft: rotor, gear, bit',
        'leakage_L_min': 'flow that does not turn the shaft: supplied less theoretical flow',
        'mechanical_efficiency': 'torque at the shaft over displacement times pressure',
        'pistons': 'of one hydromotor: so often in a turn its torque swings (piston_ripple)',
    },
    'line': {
        'bulk_modulus_Pa': 'of the oil with the walls of the hose',
        'volume_m3': 'oil between pump and hydromotor; of two lines, in each',
        'oil_density_kg_m3': 'of the oil',
        'oil_grade': 'a viscosity grade of config/oil_grades.yaml, as ISO VG 46',
    },
    'relief_valve': {
        'set_pressure_bar': 'from this pressure on it passes oil',
        'reference_pressure_bar': 'pressure from which its flow is counted (the set pressure if '
                                  'not said)',
        'discharge_coefficient': 'of its orifice, usually 0.6 to 0.7',
        'area_m2': 'of its opening',
    },
    'loading': {
        'gear_ratio': 'turns of the loading pump per turn of the hydromotor',
        'pump_displacement_cc_rev': 'of the loading pump',
        'pump_mechanical_efficiency': 'of the loading pump and its gear',
        'pprv_pressure_vs_command': 'pressure that the PPRV holds, at the reference flow',
        'pprv_lag_s': 'time constant of the PPRV',
        'pprv_override_bar_per_L_min': 'by how much its pressure rises with the flow',
        'pprv_reference_flow_L_min': 'flow at which its pressure was measured',
    },
    'gear': {
        'ratio': 'turns of the hydromotors per turn of the measured shaft',
        'efficiency': 'torque out over torque in (1 if not said)',
    },
    'cross_port_relief': {
        'set_pressure_bar': 'difference of the lines from which it passes oil',
        'override_bar_per_L_min': 'by how much the pressure rises with its flow',
    },
    'charge': {
        'pump_displacement_cc_rev': 'of the charge pump, which turns with the main pump',
        'relief_pressure_bar': 'from this charge pressure on its relief passes oil',
        'relief_override_bar_per_L_min': 'by how much the charge pressure rises with that flow',
        'check_valve_bar_per_L_min': 'pressure drop of the check valves to the low line',
        'flushing_L_min': 'what the flushing valve takes out of the low line, at the relief '
                          'pressure of the charge',
    },
    'supply': {'pressure_bar': 'of the constant-pressure supply'},
    'valve': {
        'rated_flow_L_min': 'of one edge, fully open, at the rated pressure drop',
        'rated_pressure_drop_bar': 'of one edge, as the sheet states it',
        'opening_vs_command': 'opening at each command, -1 to 1, dead band included',
        'lag_s': 'time constant of the spool',
    },
    'controller': {
        'kp_V_per_rad_s': 'proportional gain',
        'ki_V_per_rad': 'integral gain',
        'sample_time_s': 'time between two commands',
        'output_limits_V': 'smallest and largest command',
    },
}
