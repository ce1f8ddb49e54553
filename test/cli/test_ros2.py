# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
``ros2 hst``, with a stand-in for ros2cli.

ros2cli comes with ROS 2 and not from PyPI. The stand-in does what its ``ros2cli.cli`` and
``ros2cli.command`` do with a command: instantiate it, let it add arguments, call its main.
"""
import argparse
from importlib import import_module, metadata
import sys
from types import ModuleType

import hst_drive
import pytest


@pytest.fixture
def ros2(monkeypatch):
    """Return a function that does what ``ros2 hst ARGUMENTS`` does."""
    base = ModuleType('ros2cli.command')
    base.CommandExtension = object
    monkeypatch.setitem(sys.modules, 'ros2cli', ModuleType('ros2cli'))
    monkeypatch.setitem(sys.modules, 'ros2cli.command', base)
    monkeypatch.delitem(sys.modules, 'hst_drive.cli.ros2', raising=False)

    def call(*arguments):
        extension = import_module('hst_drive.cli.ros2').HstCommand()
        parser = argparse.ArgumentParser(prog='ros2')
        command = parser.add_subparsers().add_parser('hst')
        extension.add_arguments(command, 'ros2 hst')
        return extension.main(parser=parser, args=parser.parse_args(['hst', *arguments]))
    yield call
    sys.modules.pop('hst_drive.cli.ros2', None)


def test_hands_over(ros2, capsys):
    """Arguments, options of the verb among them, reach the verb; the exit code comes back."""
    assert ros2('no-such-verb', '--json', 'x') == 2
    assert "unknown verb 'no-such-verb'" in capsys.readouterr().err


def test_help_of_a_verb(ros2, capsys):
    """A verb's help speaks of ros2 hst."""
    assert ros2('recover', '--help') == 0
    assert 'usage: ros2 hst recover' in capsys.readouterr().out


def test_own_help(ros2, capsys):
    """``ros2 hst --help`` lists the verbs."""
    with pytest.raises(SystemExit):
        ros2('--help')
    shown = capsys.readouterr().out
    assert 'recover' in shown and 'ros2 hst VERB --help' in shown


def test_is_declared():
    """ros2cli finds commands by this entry point, and instantiates what it names."""
    try:
        package = metadata.distribution(hst_drive.__name__)
    except metadata.PackageNotFoundError:
        pytest.skip('hst_drive runs from the source tree')
    found = [entry for entry in package.entry_points if entry.group == 'ros2cli.command']
    assert [(entry.name, entry.value) for entry in found] == [
        ('hst', 'hst_drive.cli.ros2:HstCommand')]
