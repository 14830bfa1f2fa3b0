"""Event files, and packets compared."""

from __future__ import annotations

import json
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Union

import numpy.typing as npt

from . import _amacrine, arguments
from .answer import Answer
from .events import Events, npy, view

Path_ = Union[str, "PathLike[str]"]
Packet = Union[Path_, npt.NDArray[Any]]
"""Events: a file of any format, or a structured array."""


@dataclass(frozen=True)
class About:
    """What a file says besides its events."""

    size: tuple[int, int]
    """Height and width of the sensor; the smallest that holds the events where the file does not
    say it."""
    size_known: bool
    """Whether the file says it."""
    channels: int
    """Kinds of cells."""
    span_us: tuple[int, int]
    """The time watched, in microseconds."""
    dropped: dict[str, int]
    """Events that were made and not delivered, by reason."""
    skipped: int
    """Records that are no events of a pixel."""


def _about(text: str) -> About:
    of = json.loads(text)
    return About(
        size=(of["height"], of["width"]),
        size_known=of["size_known"],
        channels=of["channels"],
        span_us=(of["span_us"][0], of["span_us"][1]),
        dropped=of["dropped"],
        skipped=of["skipped"],
    )


def read(
    path: Path_, *, format: str | None = None, size: tuple[int, int] | None = None
) -> Events:
    """The events of a file: EVT2, EVT2.1, EVT3, DAT, AEDAT2, 3.1 and 4, ES, NPY, NPZ, CSV, text,
    HDF5, Parquet.

    Args:
        path: The file.
        format: Its format, where its name and first bytes do not say it.
        size: Height and width of the sensor, where the file does not say them.

    Returns:
        A structured array as :meth:`Sensor.events` gives it.
    """
    records, channels, _ = _amacrine.read(path, format, arguments.size(size))
    return view(records, channels)


def about(
    path: Path_, *, format: str | None = None, size: tuple[int, int] | None = None
) -> About:
    """What a file says besides its events. It is read whole."""
    return _about(_amacrine.read(path, format, arguments.size(size))[2])


def write(
    path: Path_,
    events: npt.NDArray[Any],
    *,
    size: tuple[int, int] | None = None,
    channels: int | None = None,
    format: str | None = None,
    compression: str = "lz4",
) -> None:
    """Writes events, whole or not at all, in the format that the extension names.

    Args:
        path: The file.
        events: A structured array, or a pandas data frame, with the fields t (us), x, y, p and, of
            several kinds of cells, channel; integers of any width, in any order.
        size: Height and width of the sensor; the smallest that holds the events where it is left
            out.
        channels: Kinds of cells, where some said nothing.
        format: Where the extension does not say it.
        compression: Of aedat4: lz4, zstd or none.

    What a format cannot hold is an :class:`Error`, never clipped or flattened.
    """
    _amacrine.write(path, npy(events), arguments.size(size), channels, format, compression)


def compare(
    reference: Packet,
    judged: Packet,
    *,
    size: tuple[int, int] | None = None,
    within: float | None = None,
    fps: float | None = None,
    bins: int = 8,
    seed: int = 0,
) -> Answer:
    """Judges one packet against another, as ``amacrine compare`` does.

    Args:
        reference: An event file of any format, or a structured array.
        judged: What is judged against it.
        size: Height and width of the sensor, where they are not known.
        within: Events of one pixel, kind and sign match when their times differ by at most so many
            seconds; 0.1, or the time from frame to frame where that is longer, if left out.
        fps: Frames per second, where events are at the times of frames.
        bins: Bins of the voxel grids.
        seed: Of the redraw and the permutation that every metric is held against.

    Returns:
        ``headline`` (kept, f1, floor, window_us), ``curve`` over all windows, ``f1``,
        ``precision``, ``recall``, ``events`` and more, and under ``ruler`` every metric beside the
        identical packet and accident. ``docs/ruler.md`` has them all.
    """
    window = arguments.micros("within", within)
    sides = _side(reference, "the reference"), _side(judged, "the judged")
    text = _amacrine.compare(
        *sides, arguments.size(size), window, fps, bins, arguments.whole("seed", seed)
    )
    return Answer.parse(text, rows="curve")


def _side(packet: Packet, name: str) -> tuple[Path_, bytes | None]:
    if isinstance(packet, (str, Path, PathLike)):
        return packet, None
    return name, npy(packet)
