# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Installation with pip and, as an ament_python package, with colcon."""
from pathlib import Path
import re
import sys

from setuptools import find_packages, setup

NAME = 'hst_drive'
NODES = ('plant', 'controller', 'estimator', 'load_profile', 'recorder')
HERE = Path(__file__).resolve().parent


def version() -> str:
    """Return the version that the package states."""
    text = (HERE / NAME / '__init__.py').read_text(encoding='utf-8')
    return re.search(r"^__version__ = '(.+)'", text, re.MULTILINE)[1]


def shared(folder: str) -> list[tuple[str, list[str]]]:
    """Return the data_files of a folder and of all below it, sorted."""
    places: dict[str, list[str]] = {}
    for path in sorted((HERE / folder).rglob('*')):
        relative = path.relative_to(HERE)
        if path.is_file() and '__pycache__' not in relative.parts:
            places.setdefault(f'share/{NAME}/{relative.parent.as_posix()}', []).append(
                relative.as_posix())
    return list(places.items())


data_files = [
    ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
    (f'share/{NAME}', ['package.xml']),
    *shared('config'),
    *shared('launch'),
]
# pip puts the console script hst-drive on the PATH. colcon installs all console scripts into
# lib/hst_drive for `ros2 run`, so there a launcher in bin, which colcon puts on the PATH, leads
# to it.
if not {'bdist_wheel', 'editable_wheel'} & set(sys.argv):
    data_files.append(('bin', ['scripts/hst-drive']))

setup(
    name=NAME,
    version=version(),
    description='Hydrostatic rotary drive of a drill rig: model, nodes, and what the model lacks',
    author='hst_drive contributors',
    author_email='maintainers@hst-drive.example',
    url='https://hst-drive.example',
    maintainer='hst_drive contributors',
    maintainer_email='maintainers@hst-drive.example',
    license='Apache-2.0',
    package_dir={'': '.'},     # so that a clone beside a script does not hide the package
    packages=find_packages(include=[NAME, f'{NAME}.*']),
    package_data={NAME: ['py.typed', 'export/*.c', 'report/assets/*', 'workbench/assets/*']},
    data_files=data_files,
    python_requires='>=3.10',
    install_requires=['setuptools', 'numpy>=1.26', 'scipy>=1.11', 'pyyaml>=6.0', 'mcap>=1.5'],
    extras_require={
        'cluster': ['distributed>=2024.1'],
        'docs': ['matplotlib>=3.6', 'myst-parser>=3', 'sphinx>=7.2', 'sphinx-rtd-theme>=2'],
        'fast': ['numba>=0.59'],
        'pandas': ['pandas>=2.1'],
        'plot': ['matplotlib>=3.6'],
        'test': ['fmpy', 'hypothesis', 'mypy', 'myst-parser', 'pandas', 'pint', 'playwright',
                 'pytest', 'rosbags', 'sphinx', 'sphinx-rtd-theme'],
    },
    zip_safe=True,
    entry_points={
        'console_scripts': [
            'hst-drive = hst_drive.cli:main',
            *(f'{node} = hst_drive.nodes.entry:{node}' for node in (*NODES, 'manager')),
        ],
        'ros2cli.command': ['hst = hst_drive.cli.ros2:HstCommand'],
        # Effects of other packages: name = module:EFFECT.
        'hst_drive.effects': [],
    },
)
