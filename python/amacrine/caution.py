"""Warnings."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import FrameType
from typing import Any

Said = list[tuple[str, str]]
"""What a run warns of: what each warning is about, and its words."""

OF_ALL = ("no-events", "scale")
"""What warnings are about that hold of a whole clip alone: that no cell fires, that all light is
small."""


class Caution(UserWarning):
    """What makes figures mean something else than they seem to: no event at all, most cells firing at
    once, a rate that is assumed, a program that cannot follow its sensor in something."""


PACKAGE = str(Path(__file__).parent)


def _caller() -> tuple[FrameType, int]:
    """The line that called this package, and its level for whoever asks here."""
    # The first is the line that called who asks.
    frame, level = sys._getframe(2), 2
    while frame.f_back is not None and frame.f_code.co_filename.startswith(PACKAGE):
        frame, level = frame.f_back, level + 1
    return frame, level


_COLLECTED: ContextVar[list[str] | None] = ContextVar("_COLLECTED", default=None)


@contextmanager
def collected() -> Iterator[list[str]]:
    """Cautions of this thread go to a list and to nobody else. ``warnings.catch_warnings`` is of all
    threads at once: two that leave it in the order in which they entered it leave a filter behind."""
    texts: list[str] = []
    before = _COLLECTED.set(texts)
    try:
        yield texts
    finally:
        _COLLECTED.reset(before)


def caution(text: str, kind: type[Warning] = Caution) -> None:
    """Warns of it at the line that called this package."""
    texts = _COLLECTED.get()
    if texts is not None and issubclass(kind, Caution):
        texts.append(text)
        return
    warnings.warn(text, kind, stacklevel=_caller()[1])


def caution_of(runs: Iterable[Said]) -> None:
    """Warns the caller of what its runs say: once of each thing, and of no event or small light only
    where that holds of all of them."""
    said = list(runs)
    first: dict[str, str] = {}
    for run in said:
        for about, text in run:
            first.setdefault(about, text)
    for of_all in OF_ALL:
        if not all(any(about == of_all for about, _ in run) for run in said):
            first.pop(of_all, None)
    for text in first.values():
        caution(text)


class Place:
    """The line of the caller that is not of this package, of which cautions are told that come later:
    in a worker process, where none of the caller's lines runs."""

    def __init__(self) -> None:
        frame, _ = _caller()
        self._file, self._line = frame.f_code.co_filename, frame.f_lineno
        self._module = frame.f_globals.get("__name__")
        self._told: dict[Any, Any] = {}

    def caution(self, text: str) -> None:
        """Warns of it there, once where filters say so."""
        warnings.warn_explicit(text, Caution, self._file, self._line, self._module, self._told)
