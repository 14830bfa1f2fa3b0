"""Arguments of one number, or of a list of names, checked before they are used."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable
from typing import Any

from ._amacrine import Error

MOST = (1 << 64) - 1
"""The largest whole number that the library takes."""


def number(name: str, given: Any, help: str) -> float:
    """A number, which may be infinite or none."""
    if not isinstance(given, (str, bytes)):
        try:
            return float(given)
        except (TypeError, ValueError, RuntimeError):
            pass
    raise Error(f"{name} = {given!r} is no number\nhelp: {help}")


def whole(name: str, given: Any, least: int = 0) -> int:
    """A whole number."""
    help = f"give a whole number, {least} or more"
    try:
        found = operator.index(given)
    except TypeError:
        raise Error(f"{name} = {given!r} is no whole number\nhelp: {help}") from None
    if not least <= found <= MOST:
        raise Error(f"{name} = {found}\nhelp: {help}, and less than 2^64")
    return found


def rate(fps: Any) -> float:
    """Frames per second, above 0."""
    help = "give fps, a number above 0, such as fps=240"
    found = number("fps", fps, help)
    if not found > 0.0:
        raise Error(f"{found:g} frames per second is no rate\nhelp: {help}")
    return found


def word(name: str, given: Any, such_as: str) -> str:
    """A name."""
    if not isinstance(given, str):
        raise Error(f"{name} = {given!r} is no name\nhelp: give one, such as {name}={such_as!r}")
    return given


def micros(name: str, seconds: Any) -> int | None:
    """Seconds as whole microseconds; none is none."""
    if seconds is None:
        return None
    help = f"give {name} in seconds, from 0 on, such as {name}=0.01"
    found = number(name, seconds, help)
    if not 0.0 <= found < math.inf:
        raise Error(f"{name} = {seconds!r}\nhelp: {help}")
    return round(found * 1e6)


def size(given: Any, name: str = "size") -> tuple[int, int] | None:
    """Height and width; none is none."""
    if given is None:
        return None
    try:
        height, width = given
        found = operator.index(height), operator.index(width)
    except (TypeError, ValueError):
        found = -1, -1
    if min(found) < 0:
        raise Error(f"{name} = {given!r}\nhelp: give {name}=(height, width), whole numbers")
    return found


def names(name: str, given: Any) -> list[str]:
    """A list of names; one name alone is a list of one."""
    if isinstance(given, str):
        return [given]
    if isinstance(given, Iterable):
        return [str(one) for one in given]
    raise Error(f"{name} = {given!r}\nhelp: give a name, or a list of names")
