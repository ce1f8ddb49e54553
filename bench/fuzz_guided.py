# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The cases of ``bench.fuzz``, led by the lines of code that they reach (needs ``atheris``).

    python -m bench.fuzz_guided mcap --count 50000

One reader in one process, since libFuzzer ends it; the first failure ends it, too.
"""
from __future__ import annotations

import argparse
import itertools
from pathlib import Path
from random import Random
import sys
from tempfile import TemporaryDirectory
import warnings

import atheris
import hst_drive.effects    # before the rest: these are compiled from their bare source

assert hst_drive.effects
with atheris.instrument_imports(include=['hst_drive', 'mcap', 'yaml']):
    from bench.fuzz import Cases, checker, HEAD, row
    from hst_drive.rig import default_rig


def main() -> None:
    """Fuzz one reader."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('reader')
    parser.add_argument('--count', type=int, default=10000)
    parser.add_argument('--seed', type=int, default=1)
    arguments = parser.parse_args()
    warnings.simplefilter('ignore')     # numpy on overflow
    default_rig()
    with TemporaryDirectory(prefix='fuzz_') as folder:
        run, seen, slowest = checker(Cases(Path(folder)), arguments.reader, arguments.count)
        corpus = Path(folder) / 'corpus'
        corpus.mkdir()
        for number in range(50):    # Hypothesis needs some hundred bytes to draw a case from
            (corpus / str(number)).write_bytes(Random(number).randbytes(1024))
        print(HEAD)
        calls = itertools.count(1)

        def one(data: bytes) -> None:
            run.hypothesis.fuzz_one_input(data)
            if next(calls) == arguments.count:      # libFuzzer's end runs nothing of Python's
                print(row(arguments.reader, seen, slowest[0]), flush=True)

        atheris.Setup([sys.argv[0], f'-runs={arguments.count}', f'-seed={arguments.seed}',
                       '-max_len=4096', '-len_control=0', str(corpus)], one)
        atheris.Fuzz()


if __name__ == '__main__':
    main()
