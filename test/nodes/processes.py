# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs and nodes as a user starts them: processes."""
from __future__ import annotations

from contextlib import contextmanager
import os
from pathlib import Path
import resource
import signal
import subprocess
import sys
import time

import mcap.reader

TREE = Path(__file__).resolve().parents[2]
PATIENCE = 90.0


def environment() -> dict[str, str]:
    """Return the environment of a process of ours."""
    path = os.pathsep.join(filter(None, [str(TREE), os.environ.get('PYTHONPATH')]))
    return {**os.environ, 'PYTHONPATH': path, 'PYTHONFAULTHANDLER': '1'}


def start(*arguments: str, file_size: int | None = None) -> subprocess.Popen:
    """Start ``hst-drive`` with these arguments; no file of it may exceed a size (bytes)."""
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))

    return subprocess.Popen([sys.executable, '-m', 'hst_drive', *arguments], env=environment(),
                            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            preexec_fn=limit if file_size else None)


def run(*arguments: str, patience: float = PATIENCE) -> tuple[int, str, str]:
    """Run ``hst-drive`` to its end; return code, output and errors."""
    process = start(*arguments)
    try:
        out, err = process.communicate(timeout=patience)
    except subprocess.TimeoutExpired:
        # It takes its nodes along, which else would talk to those of the next test.
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE)
        raise
    return process.returncode, out, err


@contextmanager
def node(name: str, *arguments: str, managed: bool = False):
    """Start a node, a managed one if wished; end it with SIGINT and check that it goes cleanly."""
    process = subprocess.Popen(
        [sys.executable, '-m', f'hst_drive.nodes.{name}', *['--managed'] * managed, '--ros-args',
         *arguments], env=environment(), text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        try:
            process.out, process.err = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            # Python's fault handler tells where it hangs.
            process.send_signal(signal.SIGABRT)
            process.out, process.err = process.communicate()
        # Shown with a test that fails.
        print(process.err, file=sys.stderr)
    assert process.returncode == 0, process.err


def children(pid: int) -> dict[str, int]:
    """Return the nodes that a run has started, by name."""
    found = {}
    for folder in Path('/proc').glob('[0-9]*'):
        try:
            words = (folder / 'cmdline').read_bytes().decode().split('\0')
            parent = int((folder / 'stat').read_text().rpartition(')')[2].split()[1])
        except (OSError, ValueError):
            continue
        for word in words:
            if parent == pid and word.startswith('hst_drive.nodes.'):
                found[word.rpartition('.')[2]] = int(folder.name)
    return found


def wait_for(condition, patience: float = PATIENCE):
    """Wait until the condition holds and return what it returned."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError('waited in vain')


def alive(pid: int) -> bool:
    """Return whether a process runs (one that is dead but not yet fetched does not)."""
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except OSError:
        return False


def messages(folder: Path) -> list[tuple[str, int, bytes]]:
    """Return topic, time and bytes of all messages of a bag in the order of the file."""
    found = []
    for path in sorted(Path(folder).glob('*.mcap')):
        with open(path, 'rb') as stream:
            reader = mcap.reader.make_reader(stream, validate_crcs=True)
            found += [(channel.topic, message.log_time, message.data)
                      for _, channel, message in reader.iter_messages(log_time_order=False)]
    return found
