"""How events become voxels."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _amacrine
from ._amacrine import Error


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
    if isinstance(bins, bool) or bins != int(bins) or bins < 0:
        raise Error(f"{bins} bins in a window\nhelp: give a whole number, 1 to 1000")
    return _amacrine.Voxels(
        int(bins),
        float(window),
        float(window if every is None else every),
        "causal" if causal else "centred",
        share,
        polarity,
        "none" if normalise is None else normalise,
    )


def number(dtype: npt.DTypeLike) -> np.dtype[Any]:
    """The type of voxels."""
    found = np.dtype(dtype)
    if found.kind != "f" or found.itemsize > 8:
        raise Error(
            f"voxels of dtype {found}\nhelp: give float16, float32 or float64; counts are whole"
        )
    return found


def shape(
    how: _amacrine.Voxels, size: tuple[int, int], channels: int, polarity: str
) -> tuple[int, ...]:
    """The shape of a window: (K,bins,H,W), or (K,2,bins,H,W) with OFF first."""
    kinds, sides, *rest = how.shape(size, channels)
    return (kinds, *((sides,) if polarity == "split" else ()), *rest)
