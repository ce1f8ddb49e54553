# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""``python -m hst_drive`` is ``hst-drive``."""
import sys

from hst_drive.cli import main

if __name__ == '__main__':
    sys.exit(main())
