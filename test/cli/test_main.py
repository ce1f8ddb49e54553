# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The frame of the command line, run as a user runs it: as a process."""
import os
import signal
import subprocess
import sys

import hst_drive
from hst_drive import cli
import pytest

VERB = """
HELP = 'a verb for the tests'


def add_arguments(parser):
    parser.add_argument('what')
    parser.add_argument('--number', type=float)


def run(args):
    from hst_drive.errors import InputError

    if args.what == 'wrong':
        raise InputError('log.csv, row 3: column x holds text;\\n expected numbers')
    if args.what == 'bug':
        raise ValueError('two\\nlines')
    if args.what == 'wait':
        import time
        print('waiting', flush=True)
        time.sleep(60)
    if args.what == 'flood':
        for row in range(100000):
            print('row', row)
    return 0
"""
# Runs the command line with one more verb; cli.__path__ is where verbs are looked for.
LAUNCH = """
import sys
from pathlib import Path
from hst_drive import cli
cli.__path__.append(sys.argv[1])
cli.__file__ = sys.argv[1] + '/__init__.py'
sys.exit(cli.main(sys.argv[2:]))
"""


@pytest.fixture
def command(tmp_path):
    """Return the start of a command line that knows the verb ``probe`` alone."""
    (tmp_path / 'probe.py').write_text(VERB)
    return [sys.executable, '-c', LAUNCH, str(tmp_path)]


def run(*command, **environment):
    """Return the finished process."""
    return subprocess.run(command, capture_output=True, text=True, timeout=60,
                          env=os.environ | environment)


def hst(*arguments):
    """Return the finished ``hst-drive`` with these arguments."""
    return run(sys.executable, '-m', 'hst_drive', *arguments)


def test_help_names_every_verb():
    """The overview shows each verb with its line, on standard output."""
    done = hst('--help')
    assert (done.returncode, done.stderr) == (0, '')
    for name, text in cli.verbs().items():
        assert f'  {name} ' in done.stdout and text in done.stdout
    assert hst().stdout == done.stdout


def test_version():
    """The version is the package's."""
    assert hst('--version').stdout.split()[-1] == hst_drive.__version__


def test_help_imports_nothing_heavy():
    """Neither the overview nor the lookup of a verb loads NumPy or ROS."""
    code = ('import sys; from hst_drive.cli import main; main(["--help"]); '
            'print(sorted({"numpy", "scipy", "yaml", "rclpy", "numba"} & set(sys.modules)))')
    assert run(sys.executable, '-c', code).stdout.splitlines()[-1] == '[]'


@pytest.mark.parametrize('name', cli.verbs())
def test_every_verb_explains_itself(name):
    """Each verb's --help works and starts from its line."""
    done = hst(name, '--help')
    assert done.returncode == 0, done.stderr
    assert cli.verbs()[name].split()[0] in done.stdout


@pytest.mark.parametrize('arguments, said', [
    (['nonsense'], "unknown verb 'nonsense'"),
    (['prob', 'x'], "did you mean 'probe'?"),
    (['--nonsense'], '--nonsense'),
    (['probe'], 'required: what (see hst-drive probe --help)'),
    (['probe', 'x', '--number', 'many'], "invalid float value: 'many'"),
    (['probe', 'x', 'y'], 'unrecognized arguments: y'),
    (['probe', 'wrong'], 'log.csv, row 3: column x holds text; expected numbers'),
])
def test_wrong_input_is_one_line_and_2(command, arguments, said):
    """Wrong input of any kind: exit code 2 and one line on standard error."""
    done = run(*command, *arguments)
    assert (done.returncode, done.stdout) == (2, '')
    assert done.stderr.startswith('hst-drive: ') and done.stderr.count('\n') == 1
    assert said in done.stderr


def test_a_bug_is_one_line_and_1(command):
    """Anything unexpected: exit code 1, one line, and the way to the traceback."""
    done = run(*command, 'probe', 'bug')
    assert done.returncode == 1
    assert done.stderr.startswith('hst-drive: ValueError: two lines (')
    assert '--traceback' in done.stderr and done.stderr.count('\n') == 1


@pytest.mark.parametrize('arguments, environment', [
    (['probe', 'bug', '--traceback'], {}),
    (['--traceback', 'probe', 'bug'], {}),
    (['probe', 'bug'], {'HST_DRIVE_TRACEBACK': '1'}),
])
def test_traceback_on_request(command, arguments, environment):
    """The traceback shows where it happened; the code stays."""
    done = run(*command, *arguments, **environment)
    assert done.returncode == 1
    assert 'Traceback' in done.stderr and 'probe.py' in done.stderr


def test_ctrl_c(command):
    """Ctrl-C ends with 130 and one line."""
    # Who starts tests in the background lets them inherit that the signal is ignored.
    process = subprocess.Popen([*command, 'probe', 'wait'], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    assert process.stdout.readline() == 'waiting\n'
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert (process.returncode, errors) == (130, 'hst-drive: interrupted\n')


def test_quiet_when_the_reader_leaves(command):
    """A pipe into head ends without complaint."""
    process = subprocess.Popen([*command, 'probe', 'flood'], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE)
    assert process.stdout.readline() == b'row 0\n'
    process.stdout.close()
    assert process.stderr.read() == b''
    assert process.wait(timeout=30) == 141
    process.stderr.close()
