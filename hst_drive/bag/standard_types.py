# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
The message definitions that a bag of ours needs, for machines without ROS 2.

Where the packages' own ``.msg`` files are found (``definitions.py``), those are used instead.
Comments are left out; fields and hashes are those of ROS 2 Jazzy's common_interfaces 5.3.
"""

STANDARD_TYPES: dict[str, tuple[str, str]] = {
    'builtin_interfaces/msg/Time': (
        'int32 sec\nuint32 nanosec\n',
        'RIHS01_b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197'),
    'std_msgs/msg/Header': (
        'builtin_interfaces/Time stamp\nstring frame_id\n',
        'RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01'),
    'std_msgs/msg/Bool': (
        'bool data\n',
        'RIHS01_feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9'),
    'std_msgs/msg/Float32': (
        'float32 data\n',
        'RIHS01_7170d3d8f841f7be3172ce5f4f59f3a4d7f63b0447e8b33327601ad64d83d6e2'),
    'std_msgs/msg/Float64': (
        'float64 data\n',
        'RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a'),
    'std_msgs/msg/Int32': (
        'int32 data\n',
        'RIHS01_b6578ded3c58c626cfe8d1a6fb6e04f706f97e9f03d2727c9ff4e74b1cef0deb'),
    'std_msgs/msg/MultiArrayDimension': (
        'string label\nuint32 size\nuint32 stride\n',
        'RIHS01_5e773a60a4c7fc8a54985f307c7837aa2994252a126c301957a24e31282c9cbe'),
    'std_msgs/msg/MultiArrayLayout': (
        'MultiArrayDimension[] dim\nuint32 data_offset\n',
        'RIHS01_4c66e6f78e740ac103a94cf63259f968e48c617e7699e829b63c21a5cb50dac6'),
    'std_msgs/msg/Float32MultiArray': (
        'MultiArrayLayout layout\nfloat32[] data\n',
        'RIHS01_0599f6f85b4bfca379873a0b4375a0aca022156bd2d7021275d116ed1fa8bfe0'),
    'std_msgs/msg/Float64MultiArray': (
        'MultiArrayLayout layout\nfloat64[] data\n',
        'RIHS01_1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f'),
    'rosgraph_msgs/msg/Clock': (
        'builtin_interfaces/Time clock\n',
        'RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564'),
    'geometry_msgs/msg/Vector3': (
        'float64 x\nfloat64 y\nfloat64 z\n',
        'RIHS01_cc12fe83e4c02719f1ce8070bfd14aecd40f75a96696a67a2a1f37f7dbb0765d'),
    'geometry_msgs/msg/Vector3Stamped': (
        'std_msgs/Header header\nVector3 vector\n',
        'RIHS01_d4829622288cbb443886e7ea94ea5671a3b1be6bab4ad04224432a65f7d7887a'),
    'sensor_msgs/msg/FluidPressure': (
        'std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance\n',
        'RIHS01_22dfb2b145a0bd5a31a1ac3882a1b32148b51d9b2f3bab250290d66f3595bc32'),
    'sensor_msgs/msg/Temperature': (
        'std_msgs/Header header\nfloat64 temperature\nfloat64 variance\n',
        'RIHS01_72514a14126ab9f8a9abec974c78e5610a367b59db5da355ff1fb982d5bad4b8'),
    'sensor_msgs/msg/JointState': (
        'std_msgs/Header header\n\nstring[] name\nfloat64[] position\nfloat64[] velocity\n'
        'float64[] effort\n',
        'RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e'),
    'diagnostic_msgs/msg/KeyValue': (
        'string key\nstring value\n',
        'RIHS01_d68081eaa540288c5440753baecef0c4e16e81a5f78ad68902ded5100413bb42'),
    'diagnostic_msgs/msg/DiagnosticStatus': (
        'byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\n'
        'string message\nstring hardware_id\nKeyValue[] values\n',
        'RIHS01_b0e3e692ea2d54a8af2f4ef1930e81556a2db55216b771f8a7d2724ed47bf0e4'),
    'diagnostic_msgs/msg/DiagnosticArray': (
        'std_msgs/Header header\nDiagnosticStatus[] status\n',
        'RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e'),
}
"""Definition text and type hash by full type name."""
