"""Threads."""

from __future__ import annotations

from . import _amacrine, arguments


def set_threads(threads: int) -> None:
    """Sets the number of threads from now on; 0 for as many as there are cores."""
    _amacrine.set_threads(arguments.whole("threads", threads))
