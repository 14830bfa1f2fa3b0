"""Arguments of a call, checked before they are used: numbers, words, times, sizes, files.

Each function is given the name of an argument and what stands in it, and gives back a plain value of
Python, or raises :class:`Error` with the name, what was given, and what to give.
"""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Callable, Iterable, Mapping
from os import PathLike, fspath
from typing import Any, ParamSpec, TypeGuard, TypeVar, Union

import numpy as np
import numpy.typing as npt

from ._amacrine import Error

File = Union[str, "PathLike[str]"]

MOST = (1 << 64) - 1
"""The largest whole number that the library takes."""

MOST_SIDE = 1 << 16
"""Rows or columns of a sensor: addresses have 16 bits."""

SECONDS = (1 << 63) // 10**6
"""No time is longer: microseconds are kept in 63 bits."""


P = ParamSpec("P")
R = TypeVar("R")


def renamed(**names: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A function whose arguments had other names before: who gives one of those is told the new one."""

    def checked(function: Callable[P, R]) -> Callable[P, R]:
        @functools.wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            for old, new in names.items():
                if old in kwargs:
                    raise Error(
                        f"{function.__name__} has no argument {old}\n"
                        f"help: it is called {new}: give {new}={kwargs[old]!r}"
                    )
            return function(*args, **kwargs)

        return called

    return checked


def number(name: str, given: Any, help: str) -> float:
    """A number, which may be infinite or none."""
    if not isinstance(given, (str, bytes)):
        try:
            return float(given)
        except (TypeError, ValueError, RuntimeError, OverflowError):
            pass
    raise Error(f"{name} = {given!r} is no number\nhelp: {help}")


def axes(of: Any) -> int:
    """How many axes it has as an array; 1 of what numpy makes no array of, such as rows of several
    lengths."""
    try:
        return np.ndim(of)
    except (TypeError, ValueError, RuntimeError):
        return 1


def is_list(given: Any) -> TypeGuard[Iterable[Any]]:
    """Whether it has parts. A word has letters only, and an array of no axes only looks iterable."""
    is_word = isinstance(given, (str, bytes))
    return isinstance(given, Iterable) and not is_word and getattr(given, "ndim", 1) != 0


def real(name: str, given: Any, help: str) -> npt.NDArray[Any]:
    """An array of real numbers. Text would be read as numbers, and of complex ones a part be lost."""
    try:
        array = np.asarray(given)
    except (TypeError, ValueError, RuntimeError) as cause:
        raise Error(f"{name} is no array: {cause}\nhelp: {help}") from cause
    if array.dtype.kind not in "buif":
        raise Error(f"{name}: its numbers are {array.dtype}; expected floats or integers\nhelp: {help}")
    return array


def dtype(given: Any, known: str) -> np.dtype[Any]:
    """A type of numbers. PyTorch's are called as numpy's are; for numpy None is float64, for whoever
    leaves it out another."""
    named = "none" if given is None else str(given).removeprefix("torch.")
    try:
        return np.dtype(given if named == str(given) else named)
    except (TypeError, ValueError, SyntaxError):
        raise Error(f"no dtype {given!r}\nhelp: give {known}") from None


def phase(given: Any) -> float | None:
    """A part of once around, or none."""
    help = "give a part of 1, such as phase=0.3"
    part = None if given is None else number("phase", given, help)
    if part is not None and not math.isfinite(part):
        raise Error(f"phase = {part}\nhelp: {help}")
    return part


def numbers(name: str, given: Any, help: str) -> list[float]:
    """A list of numbers; one number alone is a list of one."""
    # A table has keys only.
    all = given if is_list(given) and not isinstance(given, Mapping) else [given]
    return [number(name, one, help) for one in all]


def unmasked(name: str, given: Any) -> None:
    """Refuses a masked array of numpy, or a list with one: the mask would be lost."""
    all = given if isinstance(given, (list, tuple)) else (given,)
    if any(isinstance(one, np.ma.MaskedArray) for one in all):
        raise Error(
            f"{name} of a masked array, whose mask would be ignored\n"
            "help: say what stands where it masks, as array.filled(0) does, or leave that out"
        )


CONTRAST = "give a number above 0, in ln units, such as upsample=0.2"


def contrast(given: Any) -> float | None:
    """By how much a pixel may change from frame to frame, in ln units; none is none."""
    if given is None:
        return None
    found = number("upsample", given, CONTRAST)
    if not 0.0 < found < math.inf:
        raise Error(f"upsample = {found:g}\nhelp: {CONTRAST}")
    return found


def share(name: str, given: Any) -> float:
    """A share of something, below all of it."""
    help = f"give a share, from 0 on and below 1, such as {name}=0.1"
    found = number(name, given, help)
    if not 0.0 <= found < 1.0:
        raise Error(f"{name} = {found:g}\nhelp: {help}")
    return found


def whole(name: str, given: Any, least: int = 0, most: int = MOST) -> int:
    """A whole number; a float that is one, too."""
    to = "or more" if most == MOST else f"to {most}"
    help = f"give a whole number, {least} {to}"
    found = None
    if not isinstance(given, (bool, np.bool_)):
        try:
            found = operator.index(given)
        except TypeError:
            if isinstance(given, (float, np.floating)) and float(given).is_integer():
                found = int(given)
    if found is None:
        raise Error(f"{name} = {given!r} is no whole number\nhelp: {help}")
    if not least <= found <= most:
        less = ", and less than 2^64" if found > most == MOST else ""
        raise Error(f"{name} = {found}\nhelp: {help}{less}")
    return found


def kinds(given: Any) -> int | None:
    """A number of kinds of cells; none is none."""
    return None if given is None else whole("channels", given, 1, 255)


def flag(name: str, given: Any) -> bool:
    """True or false."""
    if not isinstance(given, (bool, np.bool_)):
        raise Error(
            f"{name} = {given!r} is neither true nor false\nhelp: give {name}=True or {name}=False"
        )
    return bool(given)


def rate(fps: Any) -> float:
    """Frames per second, above 0 and not without end."""
    help = "give fps, a number above 0, such as fps=240"
    found = number("fps", fps, help)
    if not 0.0 < found < math.inf:
        raise Error(f"{found:g} frames per second is no rate\nhelp: {help}")
    return found


def scale(given: Any) -> float:
    """What numbers are multiplied by to be light."""
    found = number("scale", given, "give a number above 0, such as scale=255")
    if not 0.0 < found < math.inf:
        raise Error(
            f"scale = {found:g}: no scale\n"
            "help: give a number above 0, such as 255 for light from 0 to 1"
        )
    return found


def word(name: str, given: Any, such_as: str) -> str:
    """A name."""
    if not isinstance(given, str):
        raise Error(f"{name} = {given!r} is no name\nhelp: give one, such as {name}={such_as!r}")
    return letters(name, given)


def letters(name: str, given: str) -> str:
    """A text that a file can hold."""
    try:
        given.encode()
    except UnicodeEncodeError:
        raise Error(
            f"{name} = {given!r} has half of a letter (a surrogate), which no file holds\n"
            "help: give whole letters"
        ) from None
    return given


def word_or_none(name: str, given: Any, such_as: str) -> str | None:
    """A name; none is none."""
    return None if given is None else word(name, given, such_as)


def one_of(name: str, given: Any, known: tuple[str, ...]) -> str:
    """One of a few words."""
    if not isinstance(given, str) or given not in known:
        raise Error(f"{name} = {given!r} is not known\nhelp: give one of {', '.join(known)}")
    return given


def file(name: str, given: Any, what: str) -> File:
    """The path of a file, or the name of what comes with the package."""
    # A path of bytes, as os.scandir(b"…") gives, is refused as bytes are.
    if not isinstance(given, (str, PathLike)) or not isinstance(fspath(given), str):
        raise Error(f"{name} = {given!r} is no path\nhelp: give {what}")
    return given


def seconds(name: str, given: Any, least: float = 0.0) -> float:
    """A time in seconds, from 0 on unless it may be earlier."""
    since = ", from 0 on" if least == 0.0 else ""
    help = f"give {name} in seconds{since}, such as {name}=0.01"
    found = number(name, given, help)
    if not least <= found <= SECONDS:
        raise Error(f"{name} = {given!r}\nhelp: {help}")
    return found


def micros(name: str, given: Any) -> int | None:
    """Seconds as whole microseconds; none is none."""
    return None if given is None else to_micros(seconds(name, given))


def to_micros(seconds: float) -> int:
    """The nearest microsecond; of two as near the later, as the library has it from 0 on. ``round``
    takes the even one."""
    exact = seconds * 1e6
    before = math.floor(exact)
    return before + int(exact - before >= 0.5)


def size(given: Any, name: str = "size") -> tuple[int, int] | None:
    """Height and width; none is none."""
    if given is None:
        return None
    try:
        height, width = given
        found = operator.index(height), operator.index(width)
    except (TypeError, ValueError):
        found = -1, -1
    help = f"give {name}=(height, width), whole numbers from 1 to {MOST_SIDE}"
    if min(found) < 0:
        raise Error(f"{name} = {given!r}\nhelp: {help}")
    if not 1 <= min(found) <= max(found) <= MOST_SIDE:
        what = "the sensor" if name == "size" else "it"
        end = f"most {MOST_SIDE}" if min(found) else "least 1"
        raise Error(
            f"{name} = {given!r}: {what} is {found[1]}x{found[0]}; a side is at {end}\n"
            f"help: {help}"
        )
    return found


def names(name: str, given: Any) -> list[str]:
    """A list of names; one name alone is a list of one."""
    if isinstance(given, str):
        return [letters(name, given)]
    if is_list(given):
        all = list(given)
        if not any(isinstance(one, (bytes, Mapping)) or axes(one) for one in all):
            return [letters(name, str(one)) for one in all]
    raise Error(f"{name} = {given!r}\nhelp: give a name, or a list of names")


def parts(given: Any) -> Iterable[Any]:
    """A clip that comes part by part."""
    if is_list(given):
        return given
    raise Error(
        f"parts = {given!r} are no clip\nhelp: give a list, or a generator, of arrays (t,H,W)"
    )


def table(name: str, given: Any, such_as: str) -> dict[str, Any]:
    """Names with their values; none has no names."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise Error(
            f"{name} = {given!r}\nhelp: give names with their values, such as {name}={such_as}"
        )
    return {letters(name, str(key)): value for key, value in given.items()}
