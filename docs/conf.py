# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Sphinx configuration of the documentation, for ``./dev docs`` and for rosdoc2.

Nothing here needs a network. rosdoc2 runs this text from a copy of the folder.
"""
from pathlib import Path
import sys

_HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(_HERE / '_ext'))
if (_HERE.parent / 'hst_drive' / '__init__.py').is_file():
    sys.path.insert(0, str(_HERE.parent))

# rosdoc2 takes known extensions only, but it calls a 'setup' of this file.
from declared import setup  # noqa: E402, F401, I100
import hst_drive  # noqa: E402

project = 'hst_drive'
author = 'hst_drive contributors'
copyright = '2026, hst_drive contributors. Licence: Apache-2.0'  # noqa: A001
release = version = hst_drive.__version__

extensions = ['myst_parser', 'sphinx.ext.autodoc', 'sphinx.ext.napoleon', 'sphinx_rtd_theme']
html_math_renderer = 'mathml'
exclude_patterns = ['_build', '_ext']
source_suffix = {'.md': 'markdown', '.rst': 'restructuredtext'}
root_doc = 'index'
smartquotes = False      # '--rig' is an option, not a dash

myst_enable_extensions = ['deflist', 'dollarmath']
myst_heading_anchors = 3
autodoc_typehints = 'none'
autodoc_member_order = 'bysource'

html_theme = 'sphinx_rtd_theme'
html_theme_options = {'collapse_navigation': False, 'navigation_depth': 2}
html_title = f'hst_drive {release}'
html_static_path = ['_static']
html_css_files = ['site.css']
html_show_sourcelink = False
html_use_index = False
