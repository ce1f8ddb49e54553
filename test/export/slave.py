# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""A unit for co-simulation, loaded as a simulator loads it."""
import ctypes
from pathlib import Path
import re
import subprocess
from xml.etree import ElementTree

import numpy as np

FLAGS = ('-O1', '-std=c99', '-fPIC', '-shared', '-ffp-contract=off')
_REFERENCES = ctypes.c_uint * 64


class _Callbacks(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in (
        'logger', 'allocate', 'release', 'finished', 'environment')]


class Slave:
    """One instance of a unit; ``library`` is that of another instance of the same unit."""

    def __init__(self, unit, folder: Path, library=None):
        path = folder / 'drive.c'
        if library is None:
            path.write_text(unit.source)
            subprocess.run(['cc', *FLAGS, '-o', folder / 'drive.so', path, '-lm'], check=True)
            library = ctypes.CDLL(str(folder / 'drive.so'))
        self.library = library
        library.fmi2Instantiate.restype = ctypes.c_void_p
        guid = re.search('guid="(.*?)"', unit.description)[1]
        self.variables = {entry.get('name'): int(entry.get('valueReference')) for entry in
                          ElementTree.fromstring(unit.description).iter('ScalarVariable')}
        self._calls = _Callbacks()
        self._drive = ctypes.c_void_p(library.fmi2Instantiate(
            b'drive', 1, guid.encode(), None, ctypes.byref(self._calls), 0, 0))
        assert self._drive
        self.saved = ctypes.c_void_p()

    def call(self, name: str, *arguments) -> None:
        """Call a function of FMI, which must be content."""
        assert getattr(self.library, f'fmi2{name}')(self._drive, *arguments) == 0, name

    def refuses(self, name: str, *arguments) -> bool:
        """Say whether a function of FMI returns an error."""
        return getattr(self.library, f'fmi2{name}')(self._drive, *arguments) == 3

    def put(self, **values: float) -> None:
        """Set inputs or parameters; a dot in a name is written as two underscores."""
        names = [self.variables[name.replace('__', '.')] for name in values]
        self.call('SetReal', _REFERENCES(*names), ctypes.c_size_t(len(names)),
                  (ctypes.c_double * 64)(*values.values()))

    def get(self, names) -> np.ndarray:
        """Return variables."""
        found = (ctypes.c_double * 64)()
        self.call('GetReal', _REFERENCES(*(self.variables[name] for name in names)),
                  ctypes.c_size_t(len(names)), found)
        return np.array(found[:len(names)])

    def step(self, seconds: float) -> None:
        """Go on."""
        self.call('DoStep', ctypes.c_double(0.0), ctypes.c_double(seconds), 0)

    def play(self, inputs: dict, interval: float, names) -> np.ndarray:
        """Return variables at the end of each step, shape (steps, names)."""
        self.call('ExitInitializationMode')
        found = []
        for values in zip(*inputs.values()):
            self.put(**dict(zip(inputs, values)))
            self.step(interval)
            found.append(self.get(names))
        return np.array(found)
