# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""CDR against two independent implementations, over random message types and values."""
from hst_drive.bag.cdr import Codec, MalformedError
from hst_drive.bag.definitions import find_definition, parse_definition, PRIMITIVES
from hst_drive.errors import InputError
from hypothesis import given, settings, strategies as st
from mcap_ros2._dynamic import generate_dynamic
import numpy as np
import pytest
from rosbags.typesys import get_types_from_msg, get_typestore, Stores

# The other implementations differ on whether byte and char have a sign; in ROS 2 they have none.
INTEGERS = {'byte': (0, 127), 'char': (0, 127), 'int8': (-128, 127), 'uint8': (0, 255),
            'int16': (-2**15, 2**15 - 1), 'uint16': (0, 2**16 - 1),
            'int32': (-2**31, 2**31 - 1), 'uint32': (0, 2**32 - 1),
            'int64': (-2**53, 2**53), 'uint64': (0, 2**53)}


def values(kind):
    if kind in INTEGERS:
        return st.integers(*INTEGERS[kind])
    if kind == 'bool':
        return st.booleans()
    if kind == 'string':
        return st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=9)
    return st.floats(allow_nan=False, width=32 if kind == 'float32' else 64)


@st.composite
def messages(draw):
    """Return definition text, member list and a value of a random flat message type."""
    lines, value = [], {}
    for index in range(draw(st.integers(1, 7))):
        kind = draw(st.sampled_from([*sorted(PRIMITIVES), 'string', 'std_msgs/Header']))
        array = draw(st.sampled_from(['', '', '[]', '[3]', '[<=4]']))
        if kind == 'std_msgs/Header':
            lines.append(f'{kind} f{index}')
            value[f'f{index}'] = {'stamp': {'sec': draw(values('int32')),
                                            'nanosec': draw(values('uint32'))},
                                  'frame_id': draw(values('string'))}
            continue
        lines.append(f'{kind}{array} f{index}  # a comment')
        size = {'[]': (0, 4), '[3]': (3, 3), '[<=4]': (0, 4)}.get(array)
        value[f'f{index}'] = draw(values(kind)) if size is None else draw(
            st.lists(values(kind), min_size=size[0], max_size=size[1]))
    header = find_definition('std_msgs/msg/Header')
    text = '\n'.join(lines) + '\n\n' + '=' * 80 + '\nMSG: std_msgs/Header\n' + header
    return text, value


def plain(decoded, like):
    """Return a decoded message as the mapping that it came from."""
    if isinstance(like, dict):
        return {key: plain(getattr(decoded, key), value) for key, value in like.items()}
    if isinstance(like, list):
        return [int.from_bytes(item, 'little') if isinstance(item, bytes) else item
                for item in (list(decoded))]
    return int.from_bytes(decoded, 'little') if isinstance(decoded, bytes) else decoded


@settings(max_examples=150, deadline=None)
@given(messages())
def test_encoding_agrees_with_two_other_implementations(message):
    text, value = message
    data = Codec('pkg/msg/Thing', text).encode(value)
    decoded = generate_dynamic('pkg/msg/Thing', text)['pkg/msg/Thing'](data)
    assert plain(decoded, value) == value
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text, 'pkg/msg/Thing'))
    assert plain(store.deserialize_cdr(data, 'pkg/msg/Thing'), value) == value


@settings(max_examples=100, deadline=None)
@given(messages(), st.booleans(), st.data())
def test_extraction_agrees_with_what_was_encoded(message, big, data):
    text, value = message
    codec = Codec('pkg/msg/Thing', text)
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text, 'pkg/msg/Thing'))
    raw = codec.encode(value)
    if big:
        decoded = store.deserialize_cdr(raw, 'pkg/msg/Thing')
        raw = bytes(store.serialize_cdr(decoded, 'pkg/msg/Thing', little_endian=False))
    expected = {}
    for name, item in value.items():
        if isinstance(item, dict):
            expected[f'{name}.stamp.sec'] = item['stamp']['sec']
            expected[f'{name}.stamp.nanosec'] = item['stamp']['nanosec']
        elif isinstance(item, list):
            if item and not isinstance(item[0], str):
                expected[f'{name}[{len(item) - 1}]'] = item[-1]
        elif not isinstance(item, str):
            expected[name] = item
    other = codec.encode({})
    found = codec.extract([raw, other, raw], list(expected))
    for path, number in expected.items():
        codec.check_path(path)
        assert found[path][0] == found[path][2] == float(number)


def test_messages_of_many_layouts_are_told_apart():
    kind = 'sensor_msgs/msg/JointState'
    codec = Codec(kind, find_definition(kind))
    raw = []
    for index in range(300):
        names = [f'j{k}' for k in range(index % 90)] + ['drill']
        raw.append(codec.encode({'name': names, 'header': {'frame_id': 'x' * (index % 7)},
                                 'velocity': [0.0] * (len(names) - 1) + [float(index)]}))
    found = codec.extract(raw, ['velocity[drill]', 'velocity[0]', 'effort[0]'])
    np.testing.assert_array_equal(found['velocity[drill]'], np.arange(300.0))
    assert np.isnan(found['effort[0]']).all()
    assert np.count_nonzero(found['velocity[0]']) == 3


def test_names_of_equal_length_in_another_order_are_told_apart():
    kind = 'sensor_msgs/msg/JointState'
    codec = Codec(kind, find_definition(kind))
    raw = [codec.encode({'name': ['ab', 'cd'], 'velocity': [1.0, 2.0]}),
           codec.encode({'name': ['cd', 'ab'], 'velocity': [3.0, 4.0]})]
    np.testing.assert_array_equal(codec.extract(raw, ['velocity[ab]'])['velocity[ab]'], [1.0, 4.0])


def test_columns_are_written_as_single_messages_are():
    kind = 'sensor_msgs/msg/FluidPressure'
    codec = Codec(kind, find_definition(kind))
    rows = codec.encode_columns({'header': {'frame_id': 'p'}}, {
        'header.stamp.sec': np.array([1, -2]), 'fluid_pressure': np.array([5.0, 6.0])})
    assert rows == [codec.encode({'header': {'frame_id': 'p', 'stamp': {'sec': sec}},
                                  'fluid_pressure': pressure})
                    for sec, pressure in ((1, 5.0), (-2, 6.0))]


@pytest.mark.parametrize('path, said', [
    ('velocty[0]', "no field 'velocty.*did you mean 'velocity'"),
    ('velocity', r'an array; write an element as velocity\[0\]'),
    ('header', 'not to a number'),
    ('header.stamp.sec[0]', 'a single value'),
    ('header.stamp.sec.x', "no field 'x'"),
])
def test_a_wrong_path_says_what_there_is(path, said):
    kind = 'sensor_msgs/msg/JointState'
    with pytest.raises(InputError, match=said):
        Codec(kind, find_definition(kind)).check_path(path)


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=60))
def test_any_bytes_are_read_or_refused(data):
    kind = 'sensor_msgs/msg/JointState'
    codec = Codec(kind, find_definition(kind))
    try:
        codec.extract([data], ['velocity[0]'])
    except MalformedError:
        pass


def test_constants_defaults_and_bounds_are_understood():
    text = 'uint8 A=3\nstring<=5 name\nfloat64 x 1.5\nint32[<=2] many\nstring S = "a # b"\n'
    members = parse_definition('p/msg/T', text)['p/msg/T']
    assert [(m.name, m.type, m.count) for m in members] == [
        ('name', 'string', None), ('x', 'float64', None), ('many', 'int32', -1)]
