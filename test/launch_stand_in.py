# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the launch file uses of ROS 2's ``launch``, where that is not installed.

A description is made as ``launch`` makes it; ``commands`` says what it would start, with which
arguments and parameters, as ``launch_ros.actions.Node`` does (Jazzy, launch_ros 0.26).
"""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
import sys
from types import ModuleType
from typing import Any

import yaml


class LaunchConfiguration(str):
    """The value of an argument, by its name."""


@dataclass
class DeclareLaunchArgument:
    name: str
    default_value: str
    description: str
    choices: list[str] | None = None


@dataclass
class ParameterValue:
    value: Any
    value_type: type


@dataclass
class IfCondition:
    predicate: Any


@dataclass
class Shutdown:
    reason: str


@dataclass
class OnProcessExit:
    target_action: Any
    on_exit: list


@dataclass
class RegisterEventHandler:
    event_handler: OnProcessExit


@dataclass
class LaunchDescription:
    entities: list


class Node:
    """A node to start; what it takes is what the launch file gives."""

    def __init__(self, *, package: str, executable: str, namespace: Any, output: str,
                 parameters: list, arguments: list = (), remappings: list = (),
                 sigterm_timeout: str = '5', condition: IfCondition | None = None,
                 respawn: Any = False, respawn_delay: float | None = None):
        self.node_package, self.node_executable = package, executable
        self.namespace, self.parameters, self.arguments = namespace, parameters, arguments
        self.remappings, self.condition = remappings, condition
        self.respawn, self.respawn_delay = respawn, respawn_delay


def install(monkeypatch) -> None:
    """Put the stand-in where ``launch`` and ``launch_ros`` are looked for."""
    for path, names in {
            'launch': (LaunchDescription,), 'launch_ros': (),
            'launch.actions': (DeclareLaunchArgument, RegisterEventHandler, Shutdown),
            'launch.conditions': (IfCondition,), 'launch.event_handlers': (OnProcessExit,),
            'launch.substitutions': (LaunchConfiguration,), 'launch_ros.actions': (Node,),
            'launch_ros.parameter_descriptions': (ParameterValue,)}.items():
        module = ModuleType(path)
        for name in names:
            setattr(module, name.__name__, name)
        monkeypatch.setitem(sys.modules, path, module)


def commands(description: LaunchDescription, given: Mapping[str, str],
             folder: Path) -> dict[str, list[str]]:
    """
    Return by executable the arguments with which its process is started.

    ``given`` are arguments as ``name:=value``; files of parameters are written to ``folder``.
    """
    values = {}
    for entry in description.entities:
        if isinstance(entry, DeclareLaunchArgument):
            values[entry.name] = given.get(entry.name, entry.default_value)
            assert entry.choices is None or values[entry.name] in entry.choices, entry.name
    assert set(given) <= set(values), 'an argument that is not declared'

    def told(value: Any) -> Any:
        if isinstance(value, LaunchConfiguration):
            return values[value]
        if isinstance(value, ParameterValue):
            text = told(value.value)
            return text if value.value_type is str else value.value_type(yaml.safe_load(text))
        return value

    found = {}
    for node in description.entities:
        if not isinstance(node, Node) or (
                node.condition and told(node.condition.predicate) != 'true'):
            continue
        files = []
        for place, entry in enumerate(node.parameters):
            path = told(entry)
            if isinstance(entry, dict):
                path = folder / f'{node.node_executable}_{place}.yaml'
                path.write_text(yaml.dump({'/**': {'ros__parameters': {
                    key: told(value) for key, value in entry.items()}}}))
            files += ['--params-file', str(path)]
        remapped = [part for pair in node.remappings
                    for part in ('-r', ':='.join(map(told, pair)))]
        found[node.node_executable] = [
            *map(told, node.arguments), '--ros-args', '-r', f'__ns:=/{told(node.namespace)}',
            *remapped, *files]
    return found
