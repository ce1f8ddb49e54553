# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Managed nodes seen from their manager: asked for their state, and led from one to the next."""
from __future__ import annotations

from collections.abc import Iterable
import time

from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import Parameter as RosParameter

GOALS = {'configure': (Transition.TRANSITION_CONFIGURE, State.PRIMARY_STATE_INACTIVE),
         'activate': (Transition.TRANSITION_ACTIVATE, State.PRIMARY_STATE_ACTIVE),
         'deactivate': (Transition.TRANSITION_DEACTIVATE, State.PRIMARY_STATE_INACTIVE),
         'cleanup': (Transition.TRANSITION_CLEANUP, State.PRIMARY_STATE_UNCONFIGURED)}
ANSWER = 1.0        # s until an answer is taken for lost, or the node for busy
SILENT = 'silent'
HELD = 'wait_for_start'     # the controller's parameter


class Refused(Exception):
    """A node is not where it should be; the text says which and where."""


class Transitions:
    """
    Leads nodes through their states.

    Parameters
    ----------
    node, spinner : Node, Executor
        Owner of the clients, and what it spins with.
    names : iterable of str
        Managed nodes in the owner's namespace.
    patience : float
        How long to wait for a node and for its answer, s.

    """

    def __init__(self, node, spinner, names: Iterable[str], patience: float):
        self._spinner, self.patience = spinner, patience
        self.clients = {name: (node.create_client(ChangeState, f'{name}/change_state'),
                               node.create_client(GetState, f'{name}/get_state'))
                        for name in names}
        self._parameters = {name: (node.create_client(GetParameters, f'{name}/get_parameters'),
                                   node.create_client(SetParameters, f'{name}/set_parameters'))
                            for name in names}

    def hold(self, name: str) -> None:
        """Let a controller that was started anew wait for a start: nobody expects a motion."""
        ask, put = self._parameters[name]
        if self._answer(name, ask, GetParameters.Request(names=[HELD])).values and not (
                self._answer(name, put, SetParameters.Request(parameters=[RosParameter(
                    HELD, value=True).to_parameter_msg()])).results[0].successful):
            # As it is configured already: by somebody else.
            raise Refused(f'{name}: {HELD} cannot be set; configure and activate it yourself')

    def _answer(self, name: str, client, request):
        """Return the answer to what may be asked twice."""
        end = time.monotonic() + self.patience
        while time.monotonic() < end:
            if client.wait_for_service(timeout_sec=ANSWER):
                asked = client.call_async(request)
                if self._wait(asked):
                    return asked.result()
                client.remove_pending_request(asked)
        raise Refused(f'{name}: does not answer {client.srv_name}')

    def state_of(self, name: str) -> str:
        """Return the name of a node's state, or that it is silent."""
        ask = self.clients[name][1]
        if not ask.service_is_ready():
            return SILENT
        asked = ask.call_async(GetState.Request())
        if self._wait(asked):
            return asked.result().current_state.label
        ask.remove_pending_request(asked)
        return SILENT

    def go(self, name: str, step: str) -> None:
        """
        Take a node one step.

        Raises
        ------
        Refused
            If it does not get there.

        """
        number, goal = GOALS[step]
        change, ask = self.clients[name]
        for client in (change, ask):
            if not client.wait_for_service(timeout_sec=self.patience):
                raise Refused(f'{name}: no such managed node; start it with --managed')
        future = change.call_async(ChangeState.Request(transition=Transition(id=number)))
        end, state = time.monotonic() + self.patience, None
        while time.monotonic() < end:
            # An answer may be lost while endpoints find each other: what counts is the state.
            if self._wait(future) and future.result().success:
                return
            asked = ask.call_async(GetState.Request())
            state = asked.result().current_state if self._wait(asked) else None
            if state is not None and state.id == goal:
                return
            if future.done() and state is not None:
                break
            if state is not None:
                # It answers, but not this: one that was restarted may have found only one of the
                # two clients by then. A second transition that does not fit does no harm.
                future = change.call_async(ChangeState.Request(transition=Transition(id=number)))
        raise Refused(f'{name}: does not {step}; it is {state.label if state else "silent"}, '
                      'its log says why')

    def _wait(self, future) -> bool:
        self._spinner.spin_until_future_complete(future, timeout_sec=min(self.patience, ANSWER))
        return future.done()
