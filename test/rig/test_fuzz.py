# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Whatever a rig file holds, there is a rig or one line, never anything else."""
import copy
from pathlib import Path
import tempfile

from hst_drive.errors import InputError
from hst_drive.resources import share
from hst_drive.rig import load_rig, parse_rig, Rig
from hypothesis import given, HealthCheck, settings, strategies as st
import yaml

TEXT = share('config', 'rig', 'test_rig.yaml').read_text()
GOOD = yaml.safe_load(TEXT)
LEAVES = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8),
                   st.dates(), st.binary(max_size=4), st.just(10**400))
KEYS = st.one_of(st.sampled_from(sorted(GOOD)), st.text(max_size=8), st.integers(), st.none())
ANYTHING = st.recursive(LEAVES, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(
    KEYS, inner, max_size=4), max_leaves=12)
QUICK = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def places(content, path=()):
    """Yield the path of every entry."""
    entries = content.items() if isinstance(content, dict) else enumerate(content)
    for key, value in entries:
        yield (*path, key)
        if isinstance(value, (dict, list)):
            yield from places(value, (*path, key))


PLACES = sorted(places(GOOD), key=str)


def holds(load):
    """Check that loading gives a rig, or one line."""
    try:
        assert isinstance(load(), Rig)
    except InputError as error:
        assert str(error) and '\n' not in str(error) and len(str(error)) < 1000


@QUICK
@given(st.dictionaries(KEYS, ANYTHING, max_size=5))
def test_any_mapping(content):
    holds(lambda: parse_rig(content, 'rig.yaml'))


@QUICK
@given(st.sampled_from(PLACES), ANYTHING, st.booleans())
def test_a_good_rig_with_one_entry_spoilt(path, value, remove):
    content = copy.deepcopy(GOOD)
    place = content
    for key in path[:-1]:
        place = place[key]
    if remove:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    holds(lambda: parse_rig(content, 'rig.yaml'))


@QUICK
@given(st.integers(0, len(TEXT)), st.integers(0, 40),
       st.binary(max_size=6) | st.sampled_from([b'\t', b'&a ', b'*a', b': ', b'{', b'\x00']))
def test_a_good_file_with_bytes_spoilt(at, length, put):
    raw = TEXT.encode()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'rig.yaml'
        path.write_bytes(raw[:at] + put + raw[at + length:])
        holds(lambda: load_rig(path))
