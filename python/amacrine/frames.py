"""Frames as arrays, whatever they come from."""

from __future__ import annotations

from os import PathLike, fspath
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _amacrine, arguments
from ._amacrine import Error
from .caution import caution
from .tensor import widened

SHAPES = "give an array of shape (T,H,W), (T,1,H,W) or (B,T,1,H,W)"


GRAY_LAST = ".299 * frames[..., 0] + .587 * frames[..., 1] + .114 * frames[..., 2]"
GRAY_THIRD = (
    ".299 * frames[..., :1, :, :] + .587 * frames[..., 1:2, :, :] + .114 * frames[..., 2:3, :, :]"
)
"""What makes colour gray, of arrays and of tensors alike."""


class Clips(NamedTuple):
    """Clips of one size."""

    all: npt.NDArray[Any]
    """Light before its scale, (B,T,H,W), of uint8, float32 or float64."""
    scale: float
    """What the numbers are multiplied by to be light from 0 to 255."""
    batched: bool
    """Whether the caller gave several clips."""

    def clip(self, b: int) -> npt.NDArray[Any]:
        """Clip `b`, (T,H,W), row by row; copied only where it does not lie so."""
        return np.require(self.all[b], requirements=("C", "A"))

    @property
    def frames(self) -> int:
        return int(self.all.shape[1])

    @property
    def size(self) -> tuple[int, int]:
        """Height and width."""
        return int(self.all.shape[2]), int(self.all.shape[3])


def clips(frames: Any, scale: float | None) -> Clips:
    """Frames of any of the shapes that are taken; arrays and tensors are not copied where they
    are of a type that is read in place."""
    arguments.unmasked("frames", frames)
    if _is_loaded(frames):
        raise Error(
            "the frames are what load gives: frames, and their rate\n"
            "help: take them apart: frames, fps = amacrine.load(…)"
        )
    try:
        array = np.asarray(widened(frames))
    except (TypeError, RuntimeError, ValueError) as cause:
        raise Error(
            f"the frames are no array: {cause}\n"
            "help: give a numpy array, or a tensor in memory without a gradient "
            "(tensor.detach().cpu())"
        ) from cause
    array, scale = _numbers(array, scale)
    match array.ndim:
        case 3:
            return Clips(array[np.newaxis], scale, batched=False)
        case 4 if array.shape[1] == 1:
            return Clips(array[np.newaxis, :, 0], scale, batched=False)
        case 5 if array.shape[2] == 1:
            return Clips(array[:, :, 0], scale, batched=True)
    raise Error(f"frames of shape {array.shape} are no clip\nhelp: {shaped(array.shape)}")


def _is_loaded(frames: Any) -> bool:
    """Whether it is the pair that :func:`load` gives."""
    return (
        isinstance(frames, tuple)
        and len(frames) == 2
        and arguments.axes(frames[1]) == 0
        and getattr(frames[0], "ndim", 0) == 3
    )


def shaped(shape: tuple[int, ...]) -> str:
    """What makes a clip of frames of another shape."""
    if len(shape) == 2:
        return f"{SHAPES}: one frame is frames[None]"
    if len(shape) in (4, 5) and shape[-1] in (3, 4):
        return f"{SHAPES}: colour must be made gray first, such as {GRAY_LAST}"
    if len(shape) == 4 and shape[-1] == 1:
        return f"{SHAPES}: frames[..., 0] leaves the last axis out"
    if (len(shape) == 4 and shape[1] == 3) or (len(shape) == 5 and shape[2] == 3):
        return f"{SHAPES}: colour must be made gray first, such as {GRAY_THIRD}"
    if len(shape) == 4:
        return f"{SHAPES}: several clips (B,T,H,W) are frames[:, :, None]"
    return SHAPES


def _numbers(array: npt.NDArray[Any], scale: float | None) -> tuple[npt.NDArray[Any], float]:
    kind, width = array.dtype.kind, array.dtype.itemsize
    if array.dtype == object:
        raise Error(
            "the frames are no array of numbers\n"
            "help: stack them first (numpy.stack); what comes part by part goes into stream or "
            "voxel_windows"
        )
    if scale is not None:
        scale = arguments.scale(scale)
    if kind == "b" and scale is not None:
        # Dark and lit: a byte each, 0 or 1, and read in place.
        return array.view(np.uint8), scale
    if kind == "b":
        raise Error(
            "frames of dtype bool have no scale of their own\n"
            "help: say what light True is, of 255: scale=255; or give uint8, or floats with a scale"
        )
    if kind not in "uif" or width > 8:
        raise Error(
            f"frames of dtype {array.dtype} are no light\n"
            "help: give uint8, or floats with a scale"
        )
    if array.dtype == np.uint8:
        return array, 1.0 if scale is None else scale
    if scale is None:
        raise Error(
            f"frames of dtype {array.dtype} have no scale of their own\n"
            "help: say what they are multiplied by to be light from 0 to 255: scale=255 where "
            "they are 0 to 1, scale=1 where they are 0 to 255"
        )
    if kind == "f":
        exact = np.float64 if width == 8 else np.float32
        return array.astype(exact, copy=False), scale
    numbers = array.astype(np.float64)
    if width == 8 and not np.array_equal(numbers.astype(array.dtype), array):
        raise Error(
            "frames hold whole numbers that no float equals\nhelp: give numbers up to 2^53"
        )
    return numbers, scale


def load(
    scene: arguments.File | None = None,
    *,
    fps: float | None = None,
    scale: float | None = None,
    range: str = "auto",
    transfer: str = "as-coded",
    frames: int | None = None,
    slice: str | None = None,
    crop: str | None = None,
    resize: str | None = None,
) -> tuple[npt.NDArray[Any], float]:
    """A clip as an array.

    Args:
        scene: What ``amacrine run --scene`` takes: a clip (.mp4, .y4m, .gif, .apng), a folder of
            pictures, a .npy of shape (T,H,W) or (T,1,H,W), ``pattern:NAME?key=value``, or
            ``bundled``, the clip that comes with the package (the default).
        fps: Frames per second, instead of what the scene says. Where neither says it, as of a .npy and
            of a folder, a rate is assumed, and a :class:`Caution` says so, as it does of cuts, of frames
            that repeat and of pictures that are missing by their numbers.
        scale: What the numbers of a .npy are multiplied by; 255 where they are 0 to 1.
        range: Which samples are black and white: ``"limited"`` (16 and 235 of 255), ``"full"``, or
            ``"auto"``: what the file says, else limited for mp4 and y4m with colour.
        transfer: How light was coded, to be undone: ``"as-coded"`` (nothing is), ``"linear"``,
            ``"srgb"``, ``"bt709"``, ``"gamma22"``, ``"gamma28"``, ``"smpte240m"``, or ``"auto"``, what
            the file says.
        frames: The first so many frames only.
        slice: Some frames only, in times or in numbers of frames: ``"2s..5s"``, ``"..100"``.
        crop: A part of each picture, ``"WIDTHxHEIGHT"`` in its middle, or ``"WIDTHxHEIGHT+X+Y"``.
        resize: ``"WIDTHxHEIGHT"``, pixels that are larger, each with the mean of its light.

    Returns:
        Light from 0 to 255, (T,H,W), and frames per second. It is ``uint8`` where all of it is
        whole numbers, else ``float64``, as that of most mp4 is: ``scale=1`` says that it is light
        already.
    """
    if scene is not None and not isinstance(scene, (str, PathLike)):
        raise Error(
            f"a scene of type {type(scene).__name__}\nhelp: give the name of a clip; an array is one"
        )
    if scene is not None:
        arguments.file("scene", scene, "the name of a clip, or its path as text")
    rate = None if fps is None else arguments.rate(fps)
    first = None if frames is None else arguments.whole("frames", frames)
    by = None if scale is None else arguments.scale(scale)
    name = None if scene is None else str(fspath(scene))
    coded = (
        arguments.one_of("range", range, _amacrine.RANGES),
        arguments.one_of("transfer", transfer, _amacrine.TRANSFERS),
    )
    part = (
        arguments.word_or_none("slice", slice, "2s..5s"),
        arguments.word_or_none("crop", crop, "256x256"),
        arguments.word_or_none("resize", resize, "256x144"),
    )
    light, rate, is_assumed, told = _amacrine.scene(name, rate, by, first, coded, part)
    if is_assumed:
        caution_of_rate(str(name), rate)
    for text in told:
        caution(text)
    return light, rate


def caution_of_rate(of: str, rate: float) -> None:
    """Warns of frames per second that nobody said."""
    caution(f"{of}: {rate:g} frames per second are assumed; say fps=… otherwise")


def shown(
    scene: Any, fps: float | None, scale: float | None
) -> tuple[str | None, npt.NDArray[Any] | None, float | None, float | None]:
    """The scene of a study: its name, or frames."""
    fps = None if fps is None else arguments.rate(fps)
    if scene is None or isinstance(scene, (str, PathLike)):
        by = None if scale is None else arguments.scale(scale)
        if scene is not None:
            scene = fspath(arguments.file("scene", scene, "the name of a clip, or its path as text"))
        return scene, None, fps, by
    given = clips(scene, scale)
    if given.batched:
        raise Error("several clips where one is watched\nhelp: give an array of shape (T,H,W)")
    return None, given.clip(0), fps, given.scale
