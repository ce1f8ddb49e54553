# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Lines of README and docs that begin with ros2: by ROS 2's tools where they are installed."""
from contextlib import contextmanager, ExitStack
from importlib import import_module
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys

from hst_drive.resources import share
import pytest

from .nodes.processes import environment, node, PATIENCE, TREE
from .nodes.test_nodes import client, parameters_of, until_answered  # noqa: F401
from .test_launch import launch_stand_in, loaded, REAL

rclpy = pytest.importorskip('rclpy')
PAGES = [TREE / 'README.md', *sorted((TREE / 'docs').glob('*.md'))]
# Programs in C++, which are in no package for the machines that these tests run on.
FOREIGN = ('controller_manager', 'diagnostic_aggregator', 'foxglove_bridge', 'plotjuggler')
CONFIG = re.compile(r'(?:\$\(ros2 pkg prefix --share hst_drive\)/config|\$SHARE)/([\w.]+)')


def lines() -> list[str]:
    """Return the lines of all code blocks, whole and without comments."""
    found = []
    for page in PAGES:
        text = page.read_text(encoding='utf-8').replace('\\\n', '')
        found += re.findall(r'^ {4,}(ros2 .*?)(?: +#.*)?$', text, re.MULTILINE)
    return sorted(set(found))


def of(*start: str) -> list[str]:
    """Return the lines that begin so."""
    return [line for line in lines() if line.split()[1:1 + len(start)] == list(start)]


def test_each_line_is_of_a_kind_that_is_tested():
    known = {*of('run', 'hst_drive'), *of('launch', 'hst_drive'), *of('service', 'call'),
             *of('param', 'set'), *of('security'), *of('hst'),     # the last one in test_docs.py
             *(line for name in FOREIGN for verb in ('run', 'launch') for line in of(verb, name))}
    assert set(lines()) == known and len(known) > 15
    for line in lines():
        for name in CONFIG.findall(line):
            assert share('config', name).is_file(), line


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Return a folder with the files that the guide speaks of."""
    guide = (TREE / 'docs' / 'integration.md').read_text(encoding='utf-8')
    block, = re.findall(r'^    channels:\n(?: {6}.*\n)+', guide, re.MULTILINE)
    (tmp_path / 'map.yaml').write_text(re.sub('^    ', '', block, flags=re.MULTILINE))
    for name in ('my_rig.yaml', 'unit.yaml'):
        shutil.copy(share('config', 'rig', 'test_rig.yaml'), tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@contextmanager
def running(line):
    """Run a line as a shell does, and end it as Ctrl-C does."""
    if shutil.which('ros2') is None:
        line = line.replace('ros2 run hst_drive ', f'{sys.executable} -m hst_drive.nodes.')
    process = subprocess.Popen(['bash', '-c', line], env={**environment(), 'PWD': os.getcwd()},
                               text=True, stdout=subprocess.PIPE, start_new_session=True)
    try:
        yield process
        os.killpg(process.pid, signal.SIGINT)
        assert process.wait(PATIENCE) == 0
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


@pytest.mark.parametrize('line', of('run', 'hst_drive'))
def test_a_node_works_with_what_is_shown(place, client, line):  # noqa: F811
    from rclpy.parameter_client import AsyncParameterClient
    name = line.split()[3]
    space = re.search(r'__ns:=(\S+)', line)
    with ExitStack() as stack:
        for managed in re.findall(r'\w+', (re.search(r'nodes:="\[(.*)\]"', line) or [''] * 2)[1]):
            stack.enter_context(node(managed, *(
                ['-p', 'output:=bag'] * (managed == 'recorder')), managed=True))
        process = stack.enter_context(running(line))
        if name == 'manager':
            assert process.stdout.readline() == 'all nodes are active\n'
            return
        found = AsyncParameterClient(client[0], f'{space[1] if space else "/drive"}/{name}')
        assert found.wait_for_services(timeout_sec=PATIENCE)
        # It answers once it is configured.
        until_answered(client, found.list_parameters)


@pytest.mark.skipif(REAL, reason='the stand-in is for where there is no launch')
@pytest.mark.parametrize('line', of('launch', 'hst_drive'))
def test_a_launch_file_has_the_arguments_that_are_shown(place, monkeypatch, line):
    _, _, _, file, *given = line.split()
    made = loaded(monkeypatch, file.partition('.')[0]).generate_launch_description()
    given = dict(text.split(':=', 1) for text in given)
    assert launch_stand_in.commands(made, given, place)


def test_services_and_gains_are_there_as_shown(client):  # noqa: F811
    """Each call is answered by a controller; a parameter that is set at run time may be."""
    from rclpy.parameter import Parameter
    with node('controller'):
        for line in of('service', 'call'):
            _, _, _, name, kind, *values = shlex.split(line)
            package, _, kind = kind.split('/')
            kind = getattr(import_module(f'{package}.srv'), kind)
            request = kind.Request()
            for key, value in re.findall(r'(\w+): (\w+)', ' '.join(values)):
                setattr(request, key, {'true': True, 'false': False}[value])
            caller = client[0].create_client(kind, name)
            assert caller.wait_for_service(timeout_sec=PATIENCE)
            until_answered(client, lambda: caller.call_async(request))
        for line in of('param', 'set'):
            _, _, _, name, key, value = line.split()
            asked = parameters_of(client, name.rpartition('/')[2])
            result, = client[1](asked.set_parameters(
                [Parameter(key, value=float(value))])).results
            assert result.successful, result.reason
