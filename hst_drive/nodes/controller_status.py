# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What the controller says of itself on /diagnostics."""
from __future__ import annotations

import time

from hst_drive.control import Supervisor
from hst_drive.control.safety import READY, RUNNING, STOPPED
from hst_drive.nodes.audit import Audit
from hst_drive.nodes.diagnostics import Diagnostics, ERROR, OK, WARN
from hst_drive.nodes.pace import Rates

STATUS_PERIOD = 1.0     # s
_SELDOM = 0.6      # of the rate that the sample time asks for: readings below it are told


class Status:
    """
    The status ``safety`` of a controller.

    Parameters
    ----------
    node : DriveNode
        Owner, whose endpoints are open.
    audit : Audit
        Knows the last event.
    wanted : str
        The input with its wishes: set point or manual command.

    """

    def __init__(self, node, audit: Audit, wanted: str):
        self._node, self._audit, self._wanted = node, audit, wanted
        self._diagnostics = Diagnostics(node)
        self._rates = Rates(STATUS_PERIOD)
        self._told: str | None = None

    def count(self) -> bool:
        """Count how often messages come; return whether that is known for a whole time."""
        return self._rates.count(time.monotonic(), {
            name: self._node.inputs[name].received for name in ('motor', self._wanted)})

    def is_told(self, watch: Supervisor) -> bool:
        """Return whether fault and state are what was told last."""
        return self._told == str(watch.fault) + watch.state

    def tell(self, stamp: int, now: float, watch: Supervisor, command: float) -> None:
        """Say how it stands at ``stamp`` (ns), which is ``now`` (s) of the supervisor's time."""
        fault, is_new = watch.fault, not self.is_told(watch)
        self._told = str(fault) + watch.state
        ended = fault is not None and fault.kind == 'shutdown'
        if fault and is_new and not ended:
            self._node.get_logger().error(f'{fault}; {watch.state}')
        warnings = self._warnings(watch)
        if fault:
            message = f'{watch.state}: {fault}' + ('' if ended else '; reset it with ~/reset')
        else:
            message = '; '.join([self._waits(watch) or (
                f'ready; start it with {self._wanted} back at {watch.rest:g}, or ~/start'
                if watch.state == READY else 'running'), *warnings])
        against = watch.causes(now) if fault and not ended else ()
        self._diagnostics.publish(
            stamp, f'{self._node.get_fully_qualified_name()}: safety',
            WARN if ended else ERROR if fault else
            OK if watch.state == RUNNING and not warnings else WARN, message, {
                'state': watch.state, 'fault': fault.kind if fault else '',
                'found': fault.found if fault else '', 'against_reset': ', '.join(against),
                'last_event': self._audit.last, 'command_v': f'{command:.4g}',
                'at_zero': str(watch.state == STOPPED).lower(),
                'readings_passed_over': watch.passed_over,
                **{f'{name}_rate_hz': f'{rate:.3g}' for name, rate in self._rates.found.items()}})

    def _warnings(self, watch: Supervisor) -> list[str]:
        node, found = self._node, []
        output = node.outputs['pump_command']
        # In lockstep nobody else takes part.
        read = [node.inputs[name].name for name in ('motor', self._wanted)]
        for name in () if node.lockstep else (*output.names, *read):
            count = node.count_publishers(name)
            if count > 1:
                found.append(f'{count} nodes publish {name}: only one may')
        asked, rate = 1.0 / node.settings['sample_time'], self._rates.found.get('motor')
        if watch.state == RUNNING and rate is not None and rate < _SELDOM * asked:
            found.append(f'motor comes {rate:.3g} times a second, sample_time asks for '
                         f'{asked:.3g}')
        return found + [output.wrong] * bool(output.wrong)

    def _waits(self, watch: Supervisor) -> str:
        """Return for which topics it still waits, and what is there of them; '' if for none."""
        topics = [self._node.inputs[name].found() for name, absent in zip(
            ('motor', self._wanted), watch.missing) if absent]
        return f'waiting for {", ".join(topics)}' if topics else ''
