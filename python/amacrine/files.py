"""Event files, and packets compared."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _amacrine, arguments
from ._amacrine import Error
from .answer import Answer, told
from .events import (
    NamedEvents,
    Parts,
    check_addresses,
    fields_of,
    kinds_of,
    named,
    packed,
    size_of,
    view,
    whole,
)
from .frames import shown
from .sensor import Sensor
from .voxels import MOST_BINS

Path_ = arguments.File
Packet = Union[Path_, Parts]
"""Events: a file of any format, a structured array, or a list of such, one after the other."""


@dataclass(frozen=True)
class About:
    """What a file says besides its events."""

    size: tuple[int, int]
    """Height and width of the sensor; the smallest that holds the events where the file does not
    say it."""
    size_known: bool
    """Whether the file says it."""
    channels: int
    """Kinds of cells; as few as its events need where the file does not say it."""
    channels_known: bool
    """Whether the file says it."""
    names: list[str]
    """What each kind is called; empty where the file does not say it."""
    span_us: tuple[int, int]
    """The time watched, in microseconds."""
    dropped: dict[str, int] | None
    """Events that were made and not delivered, by reason; None where the file does not say it."""
    skipped: int
    """Records that are no events of a pixel."""


def _about(text: str) -> About:
    of = json.loads(text)
    return About(
        size=(of["height"], of["width"]),
        size_known=of["size_known"],
        channels=of["channels"],
        channels_known=of["channels_known"],
        names=of["names"],
        span_us=(of["span_us"][0], of["span_us"][1]),
        dropped=of["dropped"],
        skipped=of["skipped"],
    )


def read(
    path: Path_,
    *,
    format: str | None = None,
    size: tuple[int, int] | None = None,
    stream: int | None = None,
) -> NamedEvents:
    """The events of a file: EVT2, EVT2.1, EVT3, DAT, AEDAT2, 3.1 and 4, ES, NPY, NPZ, CSV, text,
    HDF5, Parquet, and the text and zip of E2VID.

    Args:
        path: The file.
        format: Its format, where its name and first bytes do not say it.
        size: Height and width of the sensor, where the file does not say them.
        stream: Which stream of events, of a file of several cameras: its number in an AEDAT4 file, 0
            for left and 1 for right in an HDF5 file of MVSEC.

    Returns:
        A structured array as :meth:`Sensor.events` gives it, with what the file says besides:
        ``.sensor_size``, ``.kinds`` and their ``.names``, ``.span`` and ``.dropped``, which
        :func:`write` writes; None where the file does not say it.
    """
    records, channels, text = _read(path, format, size, stream)
    events, about = view(records, channels), _about(text)
    check_addresses(path, events, about.size)
    size_known = about.size if about.size_known else None
    kinds_known = channels if about.channels_known else None
    first, last = (time / 1e6 for time in about.span_us)
    return named(events, about.names, size_known, kinds_known, (first, last), about.dropped)


def _read(
    path: Any, format: Any, size: Any, stream: Any
) -> tuple[npt.NDArray[np.uint8], int, str]:
    """The bytes of records, the number of kinds, and about them."""
    file = arguments.file("path", path, "the path of an event file")
    kind = arguments.word_or_none("format", format, "evt3")
    number = None if stream is None else arguments.whole("stream", stream, 0, (1 << 31) - 1)
    return _amacrine.read(file, kind, arguments.size(size), number)


def about(
    path: Path_,
    *,
    format: str | None = None,
    size: tuple[int, int] | None = None,
    stream: int | None = None,
) -> About:
    """What a file says besides its events; the arguments are those of :func:`read`. It is read whole."""
    return _about(_read(path, format, size, stream)[2])


def write(
    path: Path_,
    events: Parts,
    *,
    size: tuple[int, int] | None = None,
    channels: int | None = None,
    names: Sequence[str] | None = None,
    span: tuple[float, float] | None = None,
    format: str | None = None,
    compression: str = "lz4",
) -> None:
    """Writes events, whole or not at all, in the format that the extension names.

    Args:
        path: The file.
        events: A structured array, or a pandas data frame, with the fields t (us), x, y, p and, of
            several kinds of cells, channel; integers of any width, in any order. Or a list of such,
            one part after the other, of which is written what all of them know alike.
        size: Height and width of the sensor; where it is left out, that of the sensor or the file
            that the events are of, else the smallest that holds them.
        channels: Kinds of cells, where some said nothing; those of that sensor where it is left out.
        names: What the kinds of cells are called, one for each; those that :func:`read` found where
            they are left out. Formats without a place for them leave them out.
        span: From when to when the sensor watched, in seconds; where it is left out, that of the
            sensor or the file whose events all of these are, if it holds them, else from the first
            to the last event.
        format: Where the extension does not say it.
        compression: Of aedat4: lz4, zstd or none.

    What a format cannot hold is an :class:`Error`, never clipped or flattened. What is known besides
    the events is left out where a format has no place for it: csv has a column ``channel`` of several
    kinds, and none of how many there are, their names, the size, the span, or what was lost.
    """
    given = whole(events)
    place, kinds = size_of(given, size), kinds_of(given, channels)
    if isinstance(given, NamedEvents):
        # Without the field they are of one kind: of several, nobody knows which.
        if names is None and ("channel" in fields_of(given) or given.kinds in (kinds, 1)):
            names = given.names
        # Times that were shifted are no longer of that span.
        span = _holding(given) if span is None else span
    called = [] if names is None else arguments.names("names", names)
    if called and channels is not None and kinds != len(called):
        raise Error(
            f"{len(called)} names for {kinds} kinds of cells\n"
            "help: give one name for each kind, or names=[] for none"
        )
    _amacrine.write(
        arguments.file("path", path, "the path of the file to write"),
        packed(given, place),
        place,
        kinds,
        called,
        _micros(span),
        _lost(given),
        arguments.word_or_none("format", format, "evt3"),
        arguments.word("compression", compression, "zstd"),
    )


def _lost(events: Any) -> tuple[int, int, int, int, int] | None:
    """What is missing, by reason, where the events know it."""
    known = events.dropped if isinstance(events, NamedEvents) else None
    if known is None:
        return None
    why = "no_slot", "over_limit", "queue_full", "merged", "unscanned"
    no_slot, over_limit, queue_full, merged, unscanned = (known.get(one, 0) for one in why)
    return no_slot, over_limit, queue_full, merged, unscanned


def _holding(events: NamedEvents) -> tuple[float, float] | None:
    """The span that the events know, if all of them are in it."""
    span = _micros(events.span)
    if span is None or len(events) == 0:
        return events.span
    first, last = int(events["t"].min()), int(events["t"].max())
    return events.span if span[0] <= first and last <= span[1] else None


def _micros(span: Any) -> tuple[int, int] | None:
    if span is None:
        return None
    help = "give two times in seconds, the later one last, such as (0, 1.5)"
    times = arguments.numbers("span", span, help)
    if len(times) != 2 or not 0.0 <= times[0] <= times[1] <= arguments.SECONDS:
        raise Error(f"span = {span!r}\nhelp: {help}")
    return arguments.to_micros(times[0]), arguments.to_micros(times[1])


def compare(
    reference: Packet,
    judged: Packet,
    *,
    size: tuple[int, int] | None = None,
    within: float | None = None,
    fps: float | None = None,
    bins: int = 8,
    seed: int = 0,
    sensor: Any = None,
    scene: Any = None,
    scale: float | None = None,
    upsample: float | None = None,
) -> Answer:
    """Judges one packet against another, as ``amacrine compare`` does.

    Args:
        reference: An event file of any format, or a structured array.
        judged: What is judged against it.
        size: Height and width of the sensor, where neither a file nor an array says it.
        within: Events of one pixel, kind and sign match when their times differ by at most so many
            seconds; 0.1, or the time from frame to frame where that is longer, if left out.
        fps: Frames per second, where events are at the times of frames.
        bins: Bins of the voxel grids.
        seed: Of the redraw and the permutation that every metric is held against.
        sensor: The sensor that made the reference, its file or its name, with its own seed and number
            format: it is run on the scene at other thresholds, to tell which change of its threshold
            costs as much, and which has as many events.
        scene: With ``sensor``: frames, with ``fps``, or what :func:`load` takes; else the clip that
            comes with the package.
        scale: With ``sensor``: what floats of the scene are multiplied by to be light from 0 to 255.
        upsample: With ``sensor``: insert frames, as for :meth:`Sensor.events`.

    Returns:
        ``headline`` (kept, f1, floor, window_us), ``curve`` over all windows, ``f1``,
        ``precision``, ``recall``, ``events``, ``dropped`` (None where nobody knows it) and more, and under ``ruler`` every metric beside the
        identical packet and chance. ``docs/ruler.md`` has them all. What makes the score mean
        something else than it seems to (kinds of other names, a packet without events, a window
        within which chance alone scores nearly 1) is under ``warnings``, and a :class:`Caution`. With
        ``sensor`` the headline has ``threshold_equivalent_percent``, whether that
        ``threshold_equivalent_is_least``, and ``tuned``, the same against the sensor of as many events.
    """
    made_by = _made_by(sensor, scene, fps, scale, upsample)
    window, place = arguments.micros("within", within), arguments.size(size)
    for name, packet in {"reference": reference, "judged": judged}.items():
        if isinstance(packet, bytes):
            arguments.file(name, packet, "the path of an event file as text, or events")
    one, other = whole(reference), whole(judged)
    _check_kinds(one, other)
    text = _amacrine.compare(
        _side(one, "the reference", place),
        _side(other, "the judged", place),
        window,
        None if fps is None else arguments.rate(fps),
        arguments.whole("bins", bins, 1, MOST_BINS),
        arguments.whole("seed", seed),
        made_by,
    )
    return told(Answer.parse(text, rows="curve"))


def _made_by(given: Any, scene: Any, fps: Any, scale: Any, upsample: Any) -> Any:
    """The sensor that made a reference, and its scene; none is none."""
    if given is None:
        for name, value in {"scene": scene, "scale": scale, "upsample": upsample}.items():
            if value is not None:
                raise Error(
                    f"{name} needs sensor\n"
                    "help: give the sensor that made the reference, too: then it is run at higher "
                    "thresholds"
                )
        return None
    if isinstance(given, Sensor):
        called, sensor = given.name, given
    else:
        what = 'a Sensor, its file, or a name of amacrine.names("sensors")'
        called = str(arguments.file("sensor", given, what))
        sensor = Sensor.from_file(called)
    how = sensor._format, sensor._seed
    return sensor._native, called, how, shown(scene, fps, scale), arguments.contrast(upsample)


def _check_kinds(reference: Any, judged: Any) -> None:
    """Refuses several kinds of cells against one where an array is among the two. What a file did not
    say is as many as the other has, as between two files, also where it was read into an array."""
    both = reference, judged
    if all(isinstance(packet, (str, PathLike)) for packet in both):
        return
    said = [_kinds_said(packet) for packet in both]
    if None not in said and said[0] != said[1]:
        raise Error(
            f"the reference has {said[0]} of cells, the judged packet {said[1]}\n"
            "help: judge one kind at a time, such as events[events['channel'] == 0] without the field"
        )


def _kinds_said(packet: Any) -> str | None:
    """Whether there are several kinds of cells, or one; none where only events of the first are there
    and nobody says of how many."""
    if isinstance(packet, (str, PathLike)):
        of = about(packet)
        is_known, count = of.channels_known, of.channels
    elif "channel" in fields_of(packet):
        known, own = kinds_of(packet, None), np.asarray(packet["channel"])
        # What is no channel is told of with its event, later.
        least = int(np.max(own, initial=0)) + 1 if own.dtype.kind in "uib" else 1
        is_known, count = known is not None, max(known or 1, least)
    else:
        # An array without the field is of one kind, unless it is of a file that does not say it.
        is_known, count = not isinstance(packet, NamedEvents) or packet.kinds is not None, 1
    if count > 1:
        return "several kinds"
    return "one kind" if is_known else None


_Side = tuple[
    Path_,
    _amacrine.Events | None,
    tuple[int, int] | None,
    tuple[int | None, list[str], tuple[int, int, int, int, int] | None],
]


def _side(
    packet: Any, name: str, size: tuple[int, int] | None
) -> _Side:
    """A file, or an array and what it knows: the size of its sensor, its kinds of cells, their names,
    what is missing of them."""
    if isinstance(packet, (str, PathLike)):
        return packet, None, size, (None, [], None)
    place, kinds = size_of(packet, size), kinds_of(packet, None)
    names = getattr(packet, "names", None) or []
    called = names if len(names) == kinds else []
    return name, packed(packet, place), place, (kinds, called, _lost(packet))
