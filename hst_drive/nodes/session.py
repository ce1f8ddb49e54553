# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Starting the nodes as processes, watching them, and ending them in order. No rclpy here."""
from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from contextlib import ExitStack
import fcntl
from importlib.util import find_spec
import os
from pathlib import Path
import signal
import subprocess
import sys
import tempfile
import threading
from typing import Any, IO

from hst_drive.errors import InputError
from hst_drive.resources import share
import yaml

PARENT = 'HST_DRIVE_PARENT'
"""Environment variable with the process id of the run that owns a node."""
_PATIENCE = {'recorder': 15.0}
_DEFAULT_PATIENCE = 5.0
_LINES = 20
_LAST_DOMAIN = 232      # of ROS 2: the ports of more do not exist


class NodeDied(Exception):
    """A node has ended by itself; the text says which and why."""

    def __init__(self, name: str, code: int, lines: list[str]):
        self.name, self.code, self.lines = name, code, lines
        self.reason = next((line for line in reversed(lines) if 'Error' in line),
                           lines[-1] if lines else '')
        how = (f'was killed by {signal.Signals(-code).name}' if code < 0
               else f'ended with exit code {code}' if code else 'ended before the run did')
        super().__init__(f'node {name} {how}')


def environment(locks: ExitStack,
                note: Callable[[str], None] = lambda text: None) -> dict[str, str]:
    """
    Return the environment of the nodes: what the user has set stays.

    Without ROS_DOMAIN_ID the run gets a domain of its own, held through a lock in ``locks``, so
    that two runs on a machine do not hear each other. With it, runs may share that domain, of
    which the later is told (``note``), and no run without it gets it.

    Raises
    ------
    InputError
        If there is no rclpy.

    """
    if find_spec('rclpy') is None:
        raise InputError('rclpy is not found; source ROS 2 Jazzy (. /opt/ros/jazzy/setup.bash) '
                         'or install the wheels as the README says')
    env = dict(os.environ)
    tree = str(Path(__file__).resolve().parents[2])
    env['PYTHONPATH'] = os.pathsep.join(filter(None, [tree, env.get('PYTHONPATH')]))
    env['PYTHONUNBUFFERED'] = '1'
    env[PARENT] = str(os.getpid())
    prefix = Path(sys.prefix)
    if (prefix / 'share' / 'ament_index').is_dir():
        env.setdefault('AMENT_PREFIX_PATH', str(prefix))
    env.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    profile = share('config', 'fastdds_local.xml')
    if profile.is_file() and env['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'LOCALHOST':
        env.setdefault('FASTRTPS_DEFAULT_PROFILES_FILE', str(profile))
    chosen = env.get('ROS_DOMAIN_ID', '').strip()
    if chosen:
        _share_domain(locks, chosen, note)
    else:
        env['ROS_DOMAIN_ID'] = str(free_domain(locks))
    return env


def free_domain(locks: ExitStack) -> int:
    """
    Return a domain that no other run on this machine uses, held until ``locks`` are closed.

    Domains above 101 may clash.
    """
    first = os.getpid() % 100
    for number in range(100):
        domain = 1 + (first + number) % 100
        own = _lock(domain, 'own', fcntl.LOCK_EX | fcntl.LOCK_NB)
        if own is None:
            continue
        chosen = _lock(domain, 'chosen', fcntl.LOCK_EX | fcntl.LOCK_NB)
        if chosen is None:
            own.close()
            continue
        chosen.close()
        locks.enter_context(own)
        return domain
    raise InputError('100 runs are going on; set ROS_DOMAIN_ID or end some')


def _share_domain(locks: ExitStack, domain: str, note: Callable[[str], None]) -> None:
    """Keep other runs out of a domain that the user has chosen, but for those told to use it."""
    if not domain.isdecimal():
        return      # which ROS says by itself
    if int(domain) > _LAST_DOMAIN:
        raise InputError(f"ROS_DOMAIN_ID is '{domain}', expected 0 to {_LAST_DOMAIN}")
    # Only the first gets it alone; it waits only for another run's look at this lock.
    alone = _lock(int(domain), 'chosen', fcntl.LOCK_EX | fcntl.LOCK_NB)
    shared = locks.enter_context(alone or _lock(int(domain), 'chosen', fcntl.LOCK_SH))
    fcntl.flock(shared, fcntl.LOCK_SH)
    if alone is None:
        note(f'another run is in ROS_DOMAIN_ID {domain}, and both hear each other; end one, give '
             'another number, or unset it')


def _lock(domain: int, kind: str, how: int) -> IO[str] | None:
    """Return a lock of a domain as an open file; None if it is taken."""
    name = f'hst_drive_{os.getuid()}_domain_{domain}_{kind}.lock'
    stream = open(Path(tempfile.gettempdir()) / name, 'w')
    try:
        fcntl.flock(stream, how)
    except OSError:
        stream.close()
        return None
    return stream


class _Dumper(yaml.SafeDumper):
    """Writes a value again where it occurs again: rcl's parser knows no aliases."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


class _Process:
    """One node: its process and what it says."""

    def __init__(self, name: str, command: list[str], env: Mapping[str, str],
                 on_line: Callable[[str, str], None], on_error: Callable[[str, str], None]):
        self.name = name
        self.errors: deque[str] = deque(maxlen=_LINES)
        # Its own session: Ctrl-C reaches only us, and we end the nodes in order.
        self.process = subprocess.Popen(
            command, env=dict(env), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, errors='replace', start_new_session=True)
        self._threads = [
            threading.Thread(target=self._pump, args=(self.process.stdout, on_line), daemon=True),
            threading.Thread(target=self._pump, args=(self.process.stderr, on_error), daemon=True)]
        for thread in self._threads:
            thread.start()

    def _pump(self, stream, on_line: Callable[[str, str], None]) -> None:
        for line in stream:
            line = line.rstrip()
            if stream is self.process.stderr:
                self.errors.append(line)
            on_line(self.name, line)

    def heard(self) -> list[str]:
        """Return the last lines of standard error, once all of it is read."""
        for thread in self._threads:
            thread.join(timeout=1.0)
        return list(self.errors)


def _can_log(env: Mapping[str, str]) -> bool:
    """Return whether rclpy finds a folder for its log; without one it does not start."""
    if env.get('ROS_LOG_DIR'):
        return True
    home = env.get('ROS_HOME') or (env.get('HOME') and os.path.join(env['HOME'], '.ros'))
    if not home:
        return False
    try:
        os.makedirs(os.path.join(home, 'log'), exist_ok=True)
        with tempfile.TemporaryFile(dir=os.path.join(home, 'log')):
            return True
    except OSError:
        return False


class Session:
    """
    The processes of a run; a context manager that leaves none behind.

    Parameters
    ----------
    parameters : mapping of str to mapping
        Node name to its parameters; the nodes start in this order.
    on_line, on_error : callable
        ``on_line(node, line)`` for each line on a node's standard output, or error.

    """

    def __init__(self, parameters: Mapping[str, Mapping[str, Any]],
                 on_line: Callable[[str, str], None],
                 on_error: Callable[[str, str], None] = lambda name, line: None):
        self._parameters = parameters
        self._on_line, self._on_error = on_line, on_error
        self._stack = ExitStack()
        self.nodes: dict[str, _Process] = {}

    def __enter__(self) -> Session:
        folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix='hst_drive_')))
        try:
            env = environment(self._stack, lambda text: self._on_error('run', text))
            if not _can_log(env):
                env['ROS_LOG_DIR'] = str(folder / 'log')
            path = folder / 'run.yaml'
            path.write_text(yaml.dump({
                f'/**/{name}': {'ros__parameters': dict(values)}
                for name, values in self._parameters.items()}, Dumper=_Dumper), encoding='utf-8')
            for name in self._parameters:
                command = [sys.executable, '-m', f'hst_drive.nodes.{name}', '--ros-args',
                           '--params-file', str(share('config', 'drive.yaml')),
                           '--params-file', str(path)]
                self.nodes[name] = _Process(name, command, env, self._on_line, self._on_error)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        self._stack.close()

    def check(self) -> bool:
        """
        Return whether the plant has come to the end of the run.

        Raises
        ------
        NodeDied
            If any node has ended otherwise.

        """
        codes = {name: node.process.poll() for name, node in self.nodes.items()}
        for name, code in codes.items():
            if code is not None and (code or name != 'plant'):
                raise NodeDied(name, code, self.nodes[name].heard())
        if codes['plant'] is None:
            return False
        self.nodes['plant'].heard()     # all that it has said is passed on
        return True

    def stop(self) -> dict[str, int]:
        """End all nodes, the recorder last so that it takes in everything; return exit codes."""
        others = [name for name in self.nodes if name != 'recorder']
        self._end(others)
        self._end([name for name in self.nodes if name == 'recorder'])
        return {name: node.process.returncode for name, node in self.nodes.items()}

    def _end(self, names: list[str]) -> None:
        running = [self.nodes[name] for name in names if self.nodes[name].process.poll() is None]
        for node in running:
            node.process.send_signal(signal.SIGINT)
        for node in running:
            try:
                node.process.wait(_PATIENCE.get(node.name, _DEFAULT_PATIENCE))
            except subprocess.TimeoutExpired:
                node.process.kill()
                node.process.wait()
        for name in names:
            self.nodes[name].heard()
