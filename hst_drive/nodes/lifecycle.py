# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A node of ours as a managed node: the states of ROS 2's lifecycle."""
from __future__ import annotations

import functools
import traceback

from hst_drive.errors import InputError
from lifecycle_msgs.msg import State
from rcl_interfaces.msg import SetParametersResult
from rclpy.lifecycle import LifecycleNodeMixin, TransitionCallbackReturn

_KINDS = ('publisher', 'subscription', 'timer', 'service', 'client')


def managed(node_class):
    """
    Return the class of a node that is configured and activated from outside.

    * unconfigured: parameters can be set, with the checks of a start.
    * configure: the parameters are turned into what the node works with; what is wrong is
      logged, and the node stays unconfigured.
    * activate: the endpoints open; no topic of ours exists in another state. Each activation
      begins afresh.
    * deactivate: the node ends its work as at its end (the controller goes to 0 V first) and
      closes the endpoints. A timer or message that was due in that very moment is dropped.
    * an exception in a transition is logged, what is open is closed, the node is unconfigured.
    """
    class Managed(LifecycleNodeMixin, node_class):
        managed = True
        _opening = 0    # which one it is; 0: none

        def __init__(self):
            self._openings = 0
            node_class.__init__(self)
            self._opened_before: set | None = None
            self._fresh = False
            LifecycleNodeMixin.__init__(self)
            self._declared = {entry.name: entry for entry in self.parameters}
            self.add_on_set_parameters_callback(self._judge_setting)
            self.add_post_set_parameters_callback(self._take_settings)

        def _judge_setting(self, parameters) -> SetParametersResult:
            """Take what ``configure`` reads only before it, and only what it could be given."""
            state = self._state_machine.current_state
            try:
                for entry in parameters:
                    known = self._declared.get(entry.name)
                    if known is None:
                        continue
                    if not known.live and state[0] != State.PRIMARY_STATE_UNCONFIGURED:
                        raise InputError(f'parameter {entry.name} is read when the node is '
                                         f'configured; it is {state[1]}: clean it up first')
                    known.read(entry.value)
            except InputError as error:
                return SetParametersResult(successful=False, reason=str(error))
            return SetParametersResult(successful=True)

        def _take_settings(self, parameters) -> None:
            self.settings.update({entry.name: self._declared[entry.name].read(entry.value)
                                  for entry in parameters if entry.name in self._declared})

        def on_configure(self, state) -> TransitionCallbackReturn:
            self._fresh = True
            return self._carry_out(self.configure)

        def on_activate(self, state) -> TransitionCallbackReturn:
            return self._carry_out(self._open)

        def on_deactivate(self, state) -> TransitionCallbackReturn:
            return self._carry_out(self._close)

        def on_cleanup(self, state) -> TransitionCallbackReturn:
            return TransitionCallbackReturn.SUCCESS

        def on_shutdown(self, state) -> TransitionCallbackReturn:
            return self._carry_out(self._close)

        def on_error(self, state) -> TransitionCallbackReturn:
            return self._carry_out(self._close)

        def _open(self) -> None:
            if not self._fresh:
                self.configure()
            self._fresh = False
            self._opened_before = self._endpoints()
            self._openings += 1
            self._opening = self._openings
            try:
                self.activate()
            except BaseException:
                self._close()
                raise

        def _close(self) -> None:
            if self._opened_before is None:
                return
            before, self._opened_before = self._opened_before, None
            try:
                self.deactivate()
            finally:
                self._opening = 0
                for kind, entity in self._endpoints() - before:
                    getattr(self, f'destroy_{kind}')(entity)
                self.outputs.clear()
                self.inputs.clear()

        def create_timer(self, period, callback, *args, **options):
            return super().create_timer(period, self._while_open(callback), *args, **options)

        def create_subscription(self, kind, topic, callback, *args, **options):
            return super().create_subscription(kind, topic, self._while_open(callback), *args,
                                               **options)

        def _while_open(self, callback):
            """Guard what belongs to an opening: the executor may hold it ready beyond the end."""
            opening = self._opening

            @functools.wraps(callback)
            def call(*args):
                if opening == self._opening:
                    return callback(*args)

            return call if opening else callback

        def _endpoints(self) -> set:
            return {(kind, entity) for kind in _KINDS for entity in getattr(self, f'{kind}s')}

        def _carry_out(self, step) -> TransitionCallbackReturn:
            try:
                step()
            except InputError as error:
                self.get_logger().error(str(error).removeprefix(f'{self.role}: '))
                return TransitionCallbackReturn.FAILURE
            except Exception:
                # rclpy would take it without a word.
                self.get_logger().error(traceback.format_exc())
                return TransitionCallbackReturn.ERROR
            return TransitionCallbackReturn.SUCCESS

        def _LifecycleNodeMixin__on_change_state(self, request, response):
            """Answer a transition that does not fit the state; rclpy 7.1 would end the node."""
            try:
                return super()._LifecycleNodeMixin__on_change_state(request, response)
            except Exception as error:
                self.get_logger().warning(f'no such transition from here: {error}')
                response.success = False
                return response

    Managed.__name__ = f'Managed{node_class.__name__}'
    return Managed
