# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Packages whose name is also that of a function of the library.

``hst_drive.diagnose`` is a package, and ``hst_drive.diagnose(logs)`` the function: whichever was
imported first, one object is both.
"""
from __future__ import annotations

from importlib import import_module
import sys
from types import ModuleType
from typing import Any


class _Called(ModuleType):
    """A package that passes calls on to the function of its name in ``hst_drive.api``."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self.__wrapped__(*args, **kwargs)

    @property
    def __wrapped__(self) -> Any:
        """The function, imported when it is asked for; ``inspect.signature`` looks here, too."""
        return getattr(import_module('hst_drive.api'), self.__name__.rpartition('.')[2])

    @property
    def __doc__(self) -> str | None:  # type: ignore[override]
        """What the function says of itself: a notebook shows it for ``hd.diagnose?``."""
        return getattr(self.__wrapped__, '__doc__', None)


def make_callable(package: str) -> None:
    """Make a package that can be called of one that is being imported."""
    sys.modules[package].__class__ = _Called
