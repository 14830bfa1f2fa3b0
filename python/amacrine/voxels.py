"""How events become voxels."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _amacrine, arguments
from ._amacrine import Error
from .caution import caution

SECONDS = "give seconds, such as 0.05"

MOST_CLIPS = 100.0
"""A window that is longer than so many clips, and than a second, is taken for a mistake."""

MOST_BINS = 1000
"""Of a window, as on the command line."""


def how(
    bins: int,
    window: float,
    every: float | None,
    causal: bool,
    polarity: str,
    share: str,
    normalise: str | None,
) -> _amacrine.Voxels:
    """The settings, checked."""
    number = arguments.whole("bins", bins, 1, MOST_BINS)
    length = arguments.number("window", window, SECONDS)
    step = length if every is None else arguments.number("every", every, SECONDS)
    return _amacrine.Voxels(
        number,
        length,
        step,
        "causal" if arguments.flag("causal", causal) else "centred",
        arguments.word("share", share, "whole"),
        arguments.word("polarity", polarity, "split"),
        "none" if normalise is None else arguments.word("normalise", normalise, "std"),
    )


def check_length(window: float, seconds: float) -> None:
    """Warns of a window beside which what it is of is nothing: microseconds, or milliseconds, that are
    taken for seconds. Nobody is warned of a usual window and a few events."""
    if window > max(MOST_CLIPS * seconds, 1.0) and seconds > 0.0:
        caution(
            f"a window of {window:g} s, and {seconds:g} s in all: nearly all of it is empty; give window in "
            "seconds"
        )


def number(dtype: npt.DTypeLike) -> np.dtype[Any]:
    """The type of voxels."""
    found = arguments.dtype(dtype, "float16, float32 or float64")
    if found.kind != "f" or found.itemsize > 8:
        raise Error(
            f"voxels of dtype {found}\nhelp: give float16, float32 or float64; counts are whole"
        )
    return found


def narrowed(values: npt.NDArray[Any], number: np.dtype[Any]) -> npt.NDArray[Any]:
    """Voxels in this type, which must hold them."""
    if number.itemsize == 2:
        # An array of what is without its sign would be as large again.
        most = max(float(values.max(initial=0.0)), -float(values.min(initial=0.0)))
        # What is nearer to 65504 than to the number after it is rounded to it.
        if most >= 65520:
            raise Error(
                f"a voxel of {most:.6g} events is beyond {number}, which ends at 65504\n"
                "help: give dtype=np.float32, shorter windows, more bins, or normalise"
            )
    return values.astype(number, copy=False)


def shape(
    how: _amacrine.Voxels, size: tuple[int, int], channels: int, polarity: str
) -> tuple[int, ...]:
    """The shape of a window: (K,bins,H,W), or (K,2,bins,H,W) with OFF first."""
    kinds, sides, *rest = how.shape(size, channels)
    return (kinds, *((sides,) if polarity == "split" else ()), *rest)
