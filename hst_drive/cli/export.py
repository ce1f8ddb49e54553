# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The verb ``export``: the drive with its adopted effects for other simulators.

Writes a unit for co-simulation (FMU, FMI 2.0) for Simulink, Amesim, Modelica tools and machine
simulators: the equations as C source, and compiled for this machine. It starts at rest; inputs
are pump and PPRV command, oil temperature and a load torque, outputs all readings, parameters
the factors of the unit and the sizes of its effects, all in SI. A C compiler is needed.
"""
from __future__ import annotations

import argparse
from io import BytesIO
import os
from pathlib import Path
import platform
import shutil
import subprocess
from tempfile import TemporaryDirectory
from zipfile import ZIP_DEFLATED, ZipFile

from hst_drive.cli.output import (
    add_force_argument, add_json_argument, refuse_to_replace, say, write_json)
from hst_drive.errors import InputError

HELP = 'write the drive as an FMU for other simulators'
SCHEMA = 'hst_drive/export/1'
# The same result as here to the last digits: no products with sums in one operation.
_FLAGS = ('-O2', '-std=c99', '-fPIC', '-shared', '-ffp-contract=off', '-fvisibility=hidden')
_PLATFORMS = {'x86_64': 'linux64', 'AMD64': 'linux64', 'aarch64': 'aarch64-linux'}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('rig', metavar='RIG.yaml', nargs='?',
                        help='rig file (default: the shipped test rig)')
    parser.add_argument('-o', '--output', metavar='DRIVE.fmu', required=True,
                        help='file to write')
    add_force_argument(parser, 'DRIVE.fmu')
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Translate, compile and write."""
    from hst_drive.export.c_source import Untranslatable
    from hst_drive.export.fmu import IDENTIFIER, unit_of
    from hst_drive.model import Drive
    from hst_drive.rig import load_rig

    if not args.output.endswith('.fmu'):
        raise InputError(f'{args.output}: is no name of an FMU, which other tools would load; '
                         'let it end with .fmu')
    refuse_to_replace(args.output, args.force)
    drive = Drive(load_rig(args.rig))
    try:
        unit = unit_of(drive)
    except Untranslatable as error:
        raise InputError(f'an effect of {drive.rig.source or drive.rig.name} cannot be said in C: '
                         f'{error}') from None
    folder = _PLATFORMS.get(platform.machine(), f'{platform.machine()}-linux')
    packed = BytesIO()
    with ZipFile(packed, 'w', ZIP_DEFLATED) as file:
        file.writestr('modelDescription.xml', unit.description)
        file.writestr(f'sources/{IDENTIFIER}.c', unit.source)
        file.writestr(f'binaries/{folder}/{IDENTIFIER}.so', compiled(unit.source))
    part = Path(f'{args.output}.part')
    try:
        part.write_bytes(packed.getvalue())
        os.replace(part, args.output)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise InputError(f'{args.output}: cannot be written: {error.strerror}') from None
    if args.json:
        write_json({'schema': SCHEMA, 'rig': drive.rig.source, 'output': args.output,
                    'fmi': '2.0', 'platform': folder, 'effects': drive.effects}, args.json)
    tell = say if args.json == '-' else print
    tell(f'{args.output}: {drive.rig.name} for co-simulation (FMI 2.0, {folder}), with '
         f'{", ".join(drive.effects) or "no effect"}')
    return 0


def compiled(source: str) -> bytes:
    """
    Return C source as a shared library.

    Raises
    ------
    InputError
        If there is no compiler, or it fails.

    """
    compiler = os.environ.get('CC') or next(filter(shutil.which, ('cc', 'gcc', 'clang')), None)
    if compiler is None or shutil.which(compiler) is None:
        raise InputError(f"no C compiler found ({compiler or 'cc, gcc, clang'}); export needs "
                         "one: 'sudo apt install gcc', or set CC")
    with TemporaryDirectory() as folder:
        path, library = Path(folder) / 'drive.c', Path(folder) / 'drive.so'
        path.write_text(source, encoding='utf-8')
        done = subprocess.run([compiler, *_FLAGS, '-o', library, path, '-lm'],
                              capture_output=True, text=True)
        if done.returncode:
            raise InputError(f'{compiler}: {(done.stderr.strip() or "failed").splitlines()[0]}; '
                             'choose another C compiler with CC')
        return library.read_bytes()
