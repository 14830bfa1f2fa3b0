"""Kernels: arrays, files and names."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import arguments
from ._amacrine import Error
from .tensor import untracked

Kernels = Union[str, Path, npt.ArrayLike, Sequence[Any]]
"""A kernel or several: a name, a file, an array of shape (k,k), (K,k,k) or (K,1,k,k), or a list of
these. Row 0 is to the north; kernels are correlations, as the weights of `torch.nn.Conv2d`."""

Kernel = Union[str, npt.NDArray[Any]]

SHAPES = "give an array of shape (k,k), (K,k,k) or (K,1,k,k), k odd"


def kernels(given: Any) -> list[Kernel]:
    """Each kernel on its own: a name, or an array (k,k)."""
    return [kernel for _, kernel in _called(given)]


def _called(given: Any) -> list[tuple[str | None, Kernel]]:
    """Each kernel on its own, and what the command line calls it; none of what is no file and no
    name."""
    if isinstance(given, (str, Path)):
        found = _named(given)
        of_one = [str(given)] if len(found) == 1 else [f"{given}[{i}]" for i in range(len(found))]
        return [*zip(of_one, found)]
    if isinstance(given, (list, tuple)) and any(
        isinstance(one, (str, Path)) or arguments.axes(one) >= 2 for one in given
    ):
        return [kernel for one in given for kernel in _called(one)]
    return [(None, kernel) for kernel in _planes(_array(given))]


def _array(given: Any) -> npt.NDArray[Any]:
    arguments.unmasked("kernels", given)
    try:
        array = np.asarray(untracked(given))
    except (TypeError, RuntimeError, ValueError) as cause:
        raise Error(f"the kernels are no array: {cause}\nhelp: {SHAPES}") from cause
    if array.dtype == object:
        raise Error(f"kernels of type {type(given).__name__}\nhelp: {SHAPES}, or a name")
    if array.dtype.kind not in "uif":
        raise Error(f"kernels of dtype {array.dtype}\nhelp: give floats or integers")
    # Whatever narrow format a network was trained in; no weight changes.
    return array.astype(np.float64)


def _planes(array: npt.NDArray[Any]) -> list[Kernel]:
    if array.ndim == 4 and array.shape[1] == 1:
        array = array[:, 0]
    if array.ndim == 2:
        return [array]
    if array.ndim == 3 and len(array):
        return list(array)
    raise Error(f"kernels of shape {array.shape}\nhelp: {SHAPES}")


def _named(name: str | Path) -> list[Kernel]:
    path = Path(name)
    if path.suffix == ".npy" and path.is_file():
        try:
            return _planes(_array(np.load(path, allow_pickle=False)))
        except Error as cause:
            raise Error(f"{path}: {cause}") from cause
        except (OSError, ValueError) as cause:
            raise Error(f"{path}: {cause}\nhelp: {SHAPES}") from cause
    return [str(name)]


def npy(kernel: npt.NDArray[Any]) -> bytes:
    """A kernel as the bytes of a `.npy`, which the library checks as it does a file's."""
    file = io.BytesIO()
    np.save(file, np.ascontiguousarray(kernel, dtype=np.float64), allow_pickle=False)
    return file.getvalue()


def named(given: Any, first: int | None = None) -> list[tuple[str, bytes | None]]:
    """Each kernel for a study: what it is called, and its bytes unless it is built in. Arrays are called
    by their numbers, from ``first`` on of kernels that follow others."""
    found = _called(given)
    is_alone = first is None and len(found) == 1
    return [
        (name or ("the kernel" if is_alone else f"kernel {n}"), _bytes(kernel))
        for n, (name, kernel) in enumerate(found, first or 0)
    ]


def _bytes(kernel: Kernel) -> bytes | None:
    if not isinstance(kernel, str):
        return npy(kernel)
    return Path(kernel).read_bytes() if Path(kernel).is_file() else None
