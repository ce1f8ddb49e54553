# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""What went wrong, told so that the reader can mend it."""


class InputError(Exception):
    """
    Input that cannot be used.

    Its text is one line that names the file, the row or key, what was found, what was
    expected and what to do. The command line prints it and leaves with code 2.
    """

    def __init__(self, message: str):
        super().__init__(' '.join(str(message).split()))
