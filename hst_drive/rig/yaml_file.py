# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading of a YAML mapping, stricter than plain YAML."""
from __future__ import annotations

from pathlib import Path
import re

from hst_drive.errors import InputError
import yaml


class _Loader(yaml.SafeLoader):
    """Safe YAML that refuses a key written twice (plain YAML keeps the last, silently)."""


def _mapping(loader: yaml.SafeLoader, node: yaml.MappingNode) -> dict:
    seen = set()
    for key_node, _ in node.value:
        key = loader.construct_object(key_node, deep=True)
        try:
            twice = key in seen
        except TypeError:
            raise yaml.constructor.ConstructorError(
                None, None, 'a key must be a word, not a list or mapping',
                key_node.start_mark) from None
        if twice:
            raise yaml.constructor.ConstructorError(
                None, None, f"key '{key}' is written twice; keep one", key_node.start_mark)
        seen.add(key)
    return yaml.SafeLoader.construct_mapping(loader, node, deep=True)


_Loader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping)
# YAML 1.1 takes 16e-6 and 1.6e5 for words; everybody else for numbers.
_Loader.add_implicit_resolver(
    'tag:yaml.org,2002:float', re.compile(r'^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$'),
    list('-+.0123456789'))


def read_yaml(path: str | Path) -> dict:
    """
    Read a YAML mapping.

    Raises
    ------
    InputError
        If the file cannot be read, is not YAML or is not a mapping.

    """
    try:
        content = yaml.load(Path(path).read_text(encoding='utf-8'), Loader=_Loader)
    except OSError as error:
        raise InputError(f'{path}: cannot be read ({error.strerror}); check the path') from None
    except UnicodeDecodeError:
        raise InputError(f'{path}: is not a text file in UTF-8; expected YAML; save it as '
                         'UTF-8') from None
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, 'problem_mark', None)
        line = f' line {mark.line + 1}:' if mark else ''
        problem = getattr(error, 'problem', None) or 'not YAML'
        raise InputError(f'{path}:{line} {problem}; mend the YAML') from None
    if content is None:
        raise InputError(f'{path}: is empty; expected a mapping of keys to values')
    if not isinstance(content, dict):
        raise InputError(f'{path}: found {type(content).__name__}, expected a mapping of '
                         'keys to values')
    return content
