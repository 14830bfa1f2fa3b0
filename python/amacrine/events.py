"""Events as structured arrays."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _amacrine, arguments, voxels as voxel
from ._amacrine import Error

EVENT = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "i1")])
"""One event: time in microseconds, column, row, 1 for ON and 0 for OFF. The dtype of a `.npy` of
events, and that of tonic."""

EVENT_OF_KINDS = np.dtype([*((n, EVENT[n]) for n in ("t", "x", "y", "p")), ("channel", "u1")])
"""The same of a sensor with several kinds of cells: `channel` counts them from 0."""

FIELDS = (
    "give a structured array with the fields t, x, y and p, t in us, such as amacrine.EVENT; of several "
    "kinds of cells channel, too"
)

Events = npt.NDArray[np.void]
"""A structured array of :data:`EVENT` or :data:`EVENT_OF_KINDS`."""


def view(records: npt.NDArray[np.uint8], channels: int) -> Events:
    """The bytes of records as events; nothing is copied."""
    dtype = EVENT_OF_KINDS if channels > 1 else EVENT
    events: Events = records.view(dtype)
    return events


def records(events: Any) -> npt.NDArray[Any]:
    """Events of a structured array or a pandas data frame, one after the other, their fields checked."""
    if hasattr(events, "to_records"):
        events = events.to_records(index=False)
    given = np.asarray(events).ravel()
    names = given.dtype.names
    if names is None:
        raise Error(f"events of dtype {given.dtype} have no fields\nhelp: {FIELDS}")
    if not set(EVENT.names or ()) <= set(names) <= set(EVENT_OF_KINDS.names or ()):
        raise Error(
            f"events with the fields {', '.join(names)}\n"
            f"help: {FIELDS}; numpy.lib.recfunctions.rename_fields calls fields otherwise"
        )
    for name in names:
        if given.dtype[name].kind not in "uib":
            raise Error(
                f"the field {name} of events is of dtype {given.dtype[name]}, not whole\n"
                "help: give whole numbers; where t is in seconds, t * 1e6, rounded"
            )
    return given


def _placed(events: npt.NDArray[Any], size: tuple[int, int] | None) -> bytes:
    """Events in the order of their times, whose sensor has a size."""
    events = records(events)
    if size is None and events.size == 0:
        raise Error("no events, and no size of their sensor\nhelp: give size=(height, width)")
    times = events["t"]
    if (times[1:] < times[:-1]).any():
        events = events[np.argsort(times, kind="stable")]
    return npy(events)


def npy(events: npt.NDArray[Any]) -> bytes:
    """Events as the bytes of a `.npy`: the library reads, and checks, any order and width of
    fields."""
    file = io.BytesIO()
    np.save(file, records(events), allow_pickle=False)
    return file.getvalue()


def voxels(
    events: npt.NDArray[Any],
    *,
    bins: int,
    window: float | None = None,
    every: float | None = None,
    causal: bool = True,
    polarity: str = "signed",
    share: str = "bilinear",
    normalise: str | None = None,
    dtype: npt.DTypeLike = np.float32,
    size: tuple[int, int] | None = None,
    channels: int | None = None,
    start: float = 0.0,
    end: float | None = None,
) -> npt.NDArray[Any]:
    """Voxels of an array of events, as :meth:`amacrine.Sensor.voxels` makes them of frames.

    Args:
        events: A structured array, or a pandas data frame, with the fields t (us), x, y, p and, of
            several kinds of cells, channel, in any order.
        size: Height and width of the sensor; the smallest that holds the events where it is left
            out.
        channels: Kinds of cells, where some said nothing.
        start: Where windows begin, in seconds; what is before is left out.
        end: Up to where there are windows, in seconds; the last event where it is left out.

    The rest is that of :meth:`amacrine.Sensor.voxels`.

    Returns:
        (windows,K,bins,H,W), or (windows,K,2,bins,H,W) with OFF first where they are split.
    """
    events, number = _after(events, start), voxel.number(dtype)
    last = int(events["t"].max()) if len(events) else 0
    until = last if end is None else max(round((end - start) * 1e6), 0)
    length = max(until, 1) * 1e-6 if window is None else window
    how = voxel.how(bins, length, every, causal, polarity, share, normalise)
    size = arguments.size(size)
    flat, (height, width, kinds) = _amacrine.voxels(
        _placed(events, size), size, channels or 1, how, until
    )
    one = voxel.shape(how, (height, width), kinds, polarity)
    return flat.reshape(-1, *one).astype(number, copy=False)


def time_surfaces(
    events: npt.NDArray[Any],
    times: npt.ArrayLike,
    *,
    tau: float,
    decay: str = "exponential",
    polarity: str = "split",
    size: tuple[int, int] | None = None,
    channels: int | None = None,
) -> npt.NDArray[np.float32]:
    """How long ago each cell fired: 1 for just then, 0 for never.

    Args:
        events: A structured array, as for :func:`voxels`.
        times: When, in seconds; each surface has seen the events up to its time.
        tau: How long a cell remembers, in seconds.
        decay: ``"exponential"`` (Lagorce et al., TPAMI 2017), exp(-age / tau), or ``"linear"``,
            1 - age / tau down to 0.
        polarity: ``"split"``: OFF and ON each have a surface; ``"signed"``: the last event of
            either sign, below 0 where it was OFF.
        size: Height and width of the sensor, as for :func:`voxels`.
        channels: Kinds of cells, where some said nothing.

    Returns:
        ``float32`` (times,K,2,H,W) with OFF first, or (times,K,H,W) where they are signed.
    """
    size, seconds = arguments.size(size), np.asarray(times, np.float64).ravel()
    if not (np.isfinite(seconds).all() and (seconds >= 0).all()):
        raise Error("the times of surfaces\nhelp: give finite seconds, from 0 on")
    micros = [round(time * 1e6) for time in seconds.tolist()]
    flat, place = _amacrine.surfaces(
        _placed(events, size), size, channels or 1, micros, float(tau), decay, polarity
    )
    return flat.reshape(len(micros), *_planes(place, polarity))


def event_frames(
    events: npt.NDArray[Any],
    count: int,
    *,
    polarity: str = "signed",
    fill: str = "count",
    size: tuple[int, int] | None = None,
    channels: int | None = None,
) -> npt.NDArray[np.int32]:
    """Pictures of ``count`` events each, in the order of their times; the last has what is left.
    For pictures of equal times take :func:`voxels` with ``bins=1, share="whole"``.

    Args:
        events: A structured array, as for :func:`voxels`.
        count: Events of a picture.
        polarity: ``"signed"`` or ``"split"``, as for :func:`voxels`.
        fill: ``"count"``: how many events a pixel had; ``"last"``: its last one, 1 or -1 (1 where
            they are split).
        size: Height and width of the sensor, as for :func:`voxels`.
        channels: Kinds of cells, where some said nothing.

    Returns:
        ``int32`` (frames,K,H,W), or (frames,K,2,H,W) with OFF first where they are split.
    """
    if isinstance(count, bool) or count != int(count) or count < 1:
        raise Error(f"frames of {count} events\nhelp: give a whole number above 0")
    size = arguments.size(size)
    flat, place = _amacrine.event_frames(
        _placed(events, size), size, channels or 1, int(count), polarity, fill
    )
    return flat.reshape(-1, *_planes(place, polarity))


def _planes(place: tuple[int, int, int], polarity: str) -> tuple[int, ...]:
    height, width, kinds = place
    return (kinds, *((2,) if polarity == "split" else ()), height, width)


def _after(events: npt.NDArray[Any], start: float) -> npt.NDArray[Any]:
    """The events from a time on, which becomes 0."""
    events = records(events)
    if start == 0.0:
        return events
    micros = round(start * 1e6)
    kept = events[events["t"].astype(np.int64) >= micros]
    fields = [name for name in EVENT_OF_KINDS.names or () if name in (kept.dtype.names or ())]
    moved = kept[fields].astype([(n, "<i8" if n == "t" else kept.dtype[n]) for n in fields])
    moved["t"] -= micros
    return moved
