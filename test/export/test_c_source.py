# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The translator: what C computes is what Python computes."""
import ctypes
import inspect
import math
import shutil
import subprocess
import textwrap

from hst_drive.export.c_source import Array, translate, Untranslatable
from hypothesis import given, settings, strategies as st
import pytest


def shapes(a, b, n):
    """Exercise numbers, branches, loops, tuples that swap, whole numbers and comparisons."""
    low, high = min(a, b), max(a, b, 0.5)
    low, high = high, low
    steps = min(int(10.0 * abs(a)) + 1, 7)
    total, count = 0.0, 0
    for k in range(1, steps):
        if k == 3 and not a > b:
            continue_here = 1.0
            total += continue_here
        elif -1.0 < a <= b or k > 4:
            total -= k / 2
        else:
            total += a**2 - abs(b)**1.5
        count += 1
    while count > 2:
        count -= 2
        if total > 1e6:
            break
    return total + (low if a < b else high) + math.tanh(a) * math.sqrt(abs(b)) + count + n / 4


@pytest.mark.skipif(shutil.which('cc') is None, reason='needs a C compiler')
def test_c_computes_what_python_computes(tmp_path):
    source = textwrap.dedent(inspect.getsource(shapes))
    text = translate(source, {}, 2, integers=('n',)).replace('static double shapes',
                                                             'double shapes')
    (tmp_path / 's.c').write_text(text)
    subprocess.run(['cc', '-std=c99', '-fPIC', '-shared', '-ffp-contract=off', '-o',
                    tmp_path / 's.so', tmp_path / 's.c', '-lm'], check=True)
    compiled = ctypes.CDLL(str(tmp_path / 's.so')).shapes
    compiled.restype = ctypes.c_double
    compiled.argtypes = [ctypes.c_double, ctypes.c_double, ctypes.c_long]
    number = st.floats(-3.0, 3.0)

    @settings(max_examples=300, deadline=None)
    @given(a=number, b=number, n=st.integers(-9, 9))
    def check(a, b, n):
        assert compiled(a, b, n) == pytest.approx(shapes(a, b, n), rel=1e-12, abs=1e-12)
    check()


@pytest.mark.parametrize('line', [
    'x = [1, 2]', 'x = a if a else other(a)', 'x = math.gamma(a)', 'x = b[0]', 'import os',
    'with a: pass', 'x = "text"', 'for x in a: pass', 'x = {}', 'del a', 'x = a // 2', 'a **= 2',
    'x = a % 2', 'x = math.foo', 'x = a is a', 'x = ~1', 'for x in range(9, 0, -1): pass'])
def test_what_c_does_not_know_is_named(line):
    source = f'def f(a):\n    {line}\n    return a\n'
    with pytest.raises(Untranslatable, match='line 2: '):
        translate(source, {'c': Array('double')}, 2)
