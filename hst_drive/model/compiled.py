# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Generated equations as running code, in plain Python or compiled.

All effects are in the code, so that one compilation serves every combination; numba keeps the
machine code beside the generated file in the user's cache folder.
"""
from __future__ import annotations

import hashlib
import importlib.util
import inspect
import linecache
import os
from pathlib import Path
import re
import sys
import tempfile
import types
from typing import Callable, Sequence

from hst_drive.effects import Effect


def compiles() -> bool:
    """Say whether code runs compiled, if nothing else is asked; numba is not imported."""
    return (importlib.util.find_spec('numba') is not None
            and os.environ.get('NUMBA_DISABLE_JIT', '0') != '1')


def terms(effects: dict[str, Effect]) -> list[tuple[str, Effect, str, Callable]]:
    """Return each term's name in the code, effect, slot and function."""
    return [(f'effect_{effect.id}' + (f'__{number}' if number else ''), effect, slot, function)
            for effect in effects.values()
            for number, (slot, function) in enumerate(effect.terms)]


def running(text: str, effects: dict[str, Effect], compiled: bool, inline: Sequence[str],
            inside: Sequence[str], called: Sequence[str]) -> types.ModuleType:
    """
    Return a generated text as a module.

    ``inline`` and ``inside`` are the functions that only others of the text call, the first put
    into their callers; ``called`` those that are called from Python.
    """
    if not compiled:
        return _plain(text, effects)
    return _compiled(text, effects, inline, inside, called)


def _plain(text: str, effects: dict[str, Effect]) -> types.ModuleType:
    name = f'hst_drive_kernel_{hashlib.sha256(text.encode()).hexdigest()[:8]}'
    module = types.ModuleType(name)
    module.__dict__.update({key: function for key, _, _, function in terms(effects)})
    filename = f'<{name}>'
    linecache.cache[filename] = (len(text), None, text.splitlines(True), filename)
    exec(compile(text, filename, 'exec'), module.__dict__)
    return module


def cache_folder() -> Path:
    """Return the folder for generated code: HST_DRIVE_CACHE, the user's cache, or a new one."""
    base = os.environ.get('HST_DRIVE_CACHE') or os.path.join(
        os.environ.get('XDG_CACHE_HOME') or os.path.expanduser('~/.cache'), 'hst_drive')
    folder = Path(base)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = tempfile.TemporaryFile(dir=folder)
        probe.close()
    except OSError:
        folder = Path(tempfile.mkdtemp(prefix='hst_drive_'))
    return folder


def _compiled(text: str, effects: dict[str, Effect], inline: Sequence[str],
              inside: Sequence[str], called: Sequence[str]) -> types.ModuleType:
    """Write the code with its effects into one file and import that, so that numba can cache."""
    import numba
    from numba.core.options import DefaultOptions

    parts = ['import numba', '', python_of(text, effects)]
    # Inlined, the inner functions cost half: a call hands over some forty words.
    inline = (*(key for key, _, _, _ in terms(effects)), *inline)
    usual = 'nogil=True, error_model="numpy"'
    if hasattr(DefaultOptions, '_nrt'):
        # References to arrays are counted in each branch, which took half of the time; nothing
        # here makes an array. The option is not documented, so it may go.
        usual += ', _nrt=False'
    # What only compiled code calls needs neither a wrapper nor a file: that halves compilation.
    within = f'{usual}, no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline='
    parts += [f'{name} = numba.njit({within}{name in inline})({name})'
              for name in (*inline, *inside)]
    parts += [f'{name} = numba.njit(cache=True, {usual})({name})' for name in called]
    source = '\n\n'.join(parts) + '\n'
    digest = hashlib.sha256((source + numba.__version__ + sys.version).encode()).hexdigest()[:16]
    name = f'hst_drive_kernel_{digest}'
    if name in sys.modules:
        return sys.modules[name]
    path = cache_folder() / f'{name}.py'
    if not path.exists():
        handle, draft = tempfile.mkstemp(dir=path.parent, suffix='.py')
        with os.fdopen(handle, 'w', encoding='utf-8') as file:
            file.write(source)
        os.replace(draft, path)
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def python_of(text: str, effects: dict[str, Effect]) -> str:
    """Return a generated text with the functions of its effects behind it."""
    return '\n\n'.join([text, *(_function_source(effect.id, function, key)
                                for key, effect, _, function in terms(effects))])


def _function_source(identity: str, function: Callable, name: str) -> str:
    """Return an effect's function as text under another name, with the numbers that it uses."""
    source = inspect.cleandoc('\n' + inspect.getsource(function))
    head, _, rest = source.partition('(')
    if not head.startswith('def '):
        raise ValueError(f"effect '{identity}': its function must be a plain 'def'")
    used = {key: function.__globals__[key] for key in function.__code__.co_names
            if isinstance(function.__globals__.get(key), (int, float))}
    constants = [f'{name}_{key} = {float(value)!r}' for key, value in used.items()]
    body = f'def {name}({rest}'
    for key in used:
        body = re.sub(rf'\b{re.escape(key)}\b', f'{name}_{key}', body)
    return '\n'.join([*constants, body])
