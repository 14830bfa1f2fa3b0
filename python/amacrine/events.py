"""Events as structured arrays."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _amacrine, arguments, notebook, voxels as voxel
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

ONE_DTYPE = (
    "give parts of one dtype: require_fields(part, amacrine.EVENT_OF_KINDS), which is in "
    "numpy.lib.recfunctions, has channel 0 where a part has no channel"
)

Events = npt.NDArray[np.void]
"""A structured array of :data:`EVENT` or :data:`EVENT_OF_KINDS`."""

Parts = Union[npt.NDArray[Any], Sequence[npt.NDArray[Any]]]
"""Events, or a list of parts, one after the other."""

MOST_SIDE = 1 << 15
"""The longest side whose addresses an event's ``i2`` holds."""

MOST_ROWS = 5
"""Events that a notebook shows."""

MOST_DRAWN = 20_000_000
"""Events of which a notebook shows a picture: of more it takes seconds."""

RANGES = {"t": (0, (1 << 63) - 1), "x": (0, 65535), "y": (0, 65535), "channel": (0, 254)}
"""What the library's events hold; `p` is 1, 0 or -1."""


class NamedEvents(np.ndarray[Any, np.dtype[np.void]]):
    """Events, with what is known of their sensor. Parts of them know it, too, but for ``span`` and
    ``dropped``, which are of all of them; :func:`amacrine.write` writes it."""

    names: list[str] | None = None
    """What the kinds of cells are called, in the order of their numbers."""
    sensor_size: tuple[int, int] | None = None
    """Height and width of the sensor."""
    kinds: int | None = None
    """Kinds of cells."""
    span: tuple[float, float] | None = None
    """From when to when the sensor watched, in seconds."""
    dropped: dict[str, int] | None = None
    """Events that found no place, by reason."""

    def __array_finalize__(self, of: Any) -> None:
        for name in ("names", "sensor_size", "kinds"):
            setattr(self, name, getattr(of, name, None))
        if getattr(of, "size", None) == self.size:
            self.span, self.dropped = getattr(of, "span", None), getattr(of, "dropped", None)

    def __getitem__(self, key: Any) -> Any:
        found = super().__getitem__(key)
        # A field alone is an array of numbers.
        plain = isinstance(found, np.ndarray) and found.dtype.names is None
        return found.view(np.ndarray) if plain else found

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        found = super().__array_function__(func, types, args, kwargs)
        if func is np.concatenate and isinstance(found, np.ndarray) and found.dtype.names:
            return _joined(args[0] if args else kwargs["arrays"], found)
        return found

    def _repr_html_(self) -> str | None:
        # Parts of it may be of another dtype; they are shown as arrays are.
        if not set(EVENT.names or ()) <= set(self.dtype.names or ()):
            return None
        events = self.view(np.ndarray).ravel()
        head: dict[str, Any] = {"events": len(events)}
        if self.sensor_size is not None:
            head["sensor"] = f"{self.sensor_size[1]}x{self.sensor_size[0]}"
        if self.span is not None:
            head["span, s"] = "{:g} to {:g}".format(*self.span)
        head |= {f"lost: {why}": count for why, count in (self.dropped or {}).items() if count}
        rows = [dict(zip(events.dtype.names or (), event)) for event in events[:MOST_ROWS].tolist()]
        more = "" if len(events) <= MOST_ROWS else f"<p>… {len(events) - MOST_ROWS} more</p>"
        tables = notebook.table([head]) + notebook.table(self._signs(events)) + notebook.table(rows)
        return tables + more + picture(self)

    def _signs(self, events: npt.NDArray[Any]) -> list[dict[str, Any]]:
        """ON and OFF of each kind of cells."""
        on = events["p"] > 0
        if "channel" not in (events.dtype.names or ()):
            return [{"ON": int(on.sum()), "OFF": int((~on).sum())}]
        kinds = max(self.kinds or 0, int(events["channel"].max(initial=0)) + 1)
        each = [np.bincount(events["channel"][of], minlength=kinds) for of in (on, ~on)]
        called = self.names or []
        each_called = [called[n] if n < len(called) else str(n) for n in range(kinds)]
        return [
            {"kind": name, "ON": int(on), "OFF": int(off)}
            for name, on, off in zip(each_called, *each)
        ]

    def __reduce__(self) -> tuple[Any, ...]:
        known = self.names, self.sensor_size, self.kinds, self.span, self.dropped
        return named, (self.view(np.ndarray), *known)


def picture(events: NamedEvents) -> str:
    """The event frame of the busiest 20 ms, as ``amacrine show --view frame`` draws it, for a notebook;
    nothing where there are no events, too many, or none that can be drawn."""
    if not 0 < events.size <= MOST_DRAWN:
        return ""
    try:
        given = packed(events.ravel(), events.sensor_size)
        ends = events.span
        span = None if ends is None else (arguments.to_micros(ends[0]), arguments.to_micros(ends[1]))
        png = _amacrine.event_picture(
            given, events.sensor_size or given.reach, events.kinds or 1, span, "events"
        )
    except Error:
        # Off the sensor, in no order, or of a sensor that is too large for a picture.
        return ""
    return notebook.picture(png, "the busiest 20 ms", "events of the busiest 20 ms")


def named(
    events: npt.NDArray[np.void],
    names: list[str] | None,
    size: tuple[int, int] | None,
    kinds: int | None = None,
    span: tuple[float, float] | None = None,
    dropped: dict[str, int] | None = None,
) -> NamedEvents:
    """The same events, with what is known of their sensor."""
    known = events.view(NamedEvents)
    known.names = list(names) if names else None
    known.sensor_size, known.kinds, known.span, known.dropped = size, kinds, span, dropped
    return known


def _joined(parts: Any, events: Any) -> Any:
    """Parts after one another, with what all of them know alike; of parts that follow one another as
    those of a stream, also from when to when, and what was lost."""
    parts = [*parts]
    if not all(isinstance(part, NamedEvents) for part in parts):
        return events.view(np.ndarray)
    known = events.view(NamedEvents)
    for name in ("names", "sensor_size", "kinds"):
        first, *others = (getattr(part, name) for part in parts)
        setattr(known, name, first if all(other == first for other in others) else None)
    known.span = known.dropped = None
    spans = [part.span for part in parts]
    if all(spans) and all(a[1] == b[0] for a, b in itertools.pairwise(spans)):
        known.span = spans[0][0], spans[-1][1]
    lost = [part.dropped for part in parts]
    if known.span is not None and all(one is not None for one in lost):
        known.dropped = {why: sum(one[why] for one in lost) for why in lost[0]}
    return known


def whole(events: Any) -> Any:
    """Events, or a list of parts of them one after the other, joined."""
    if not isinstance(events, (list, tuple)) or not events:
        return events
    if not all(fields_of(part) for part in events):
        return events
    # One event taken out of an array has no axis.
    parts = [one.reshape(1) if one.ndim == 0 else one for one in map(_records, events)]
    try:
        return np.concatenate(parts)
    except TypeError as error:
        told = " and ".join(dict.fromkeys(", ".join(fields_of(part)) for part in parts))
        all_there = all(set(EVENT.names or ()) <= set(fields_of(part)) for part in parts)
        raise Error(
            f"parts of events that cannot be joined: with the fields {told}\n"
            f"help: {ONE_DTYPE if all_there else FIELDS}"
        ) from error


def size_of(events: Any, size: tuple[int, int] | None) -> tuple[int, int] | None:
    """The size of the sensor, as it is given, else as the events know it."""
    given = arguments.size(size)
    return arguments.size(getattr(events, "sensor_size", None)) if given is None else given


def fields_of(events: Any) -> Iterable[str]:
    """The fields of a structured array, or the columns of a data frame."""
    if hasattr(events, "columns"):
        return list(events.columns)
    return getattr(getattr(events, "dtype", None), "names", None) or ()


def kinds_of(events: Any, channels: int | None) -> int | None:
    """The kinds of cells, as many as are given, else as the events know them; none where nobody says
    it."""
    given = arguments.kinds(channels)
    if "channel" not in fields_of(events):
        return given
    if given is None:
        known: int | None = getattr(events, "kinds", None)
        return known
    least = int(np.max(events["channel"], initial=0)) + 1
    if given < least:
        raise Error(
            f"channels = {given}, and there are events of channel {least - 1}\n"
            "help: give one more than the largest channel, or leave channels out"
        )
    return given


def view(records: npt.NDArray[np.uint8], channels: int) -> Events:
    """The bytes of records as events; nothing is copied."""
    dtype = EVENT_OF_KINDS if channels > 1 else EVENT
    events: Events = records.view(dtype)
    return events


def check_side(size: tuple[int, int]) -> None:
    """Refuses a sensor whose addresses the fields x and y do not hold."""
    if max(size) > MOST_SIDE:
        raise Error(
            f"a sensor of {size[1]}x{size[0]} pixels: the fields x and y hold no more than "
            f"{MOST_SIDE}\nhelp: take a smaller scene"
        )


def check_addresses(path: Any, events: Events, size: tuple[int, int]) -> None:
    """Refuses events of a file whose addresses the fields x and y do not hold."""
    if max(size) <= MOST_SIDE:
        return
    for name in ("x", "y"):
        beyond = np.flatnonzero(events[name] < 0)
        if len(beyond):
            # What is below 0 was 16 bits without a sign.
            value = int(events[name][beyond[0]]) + (1 << 16)
            raise Error(
                f"{path}: event {beyond[0]}: {name} is {value}, and the fields x and y hold no more "
                f"than {MOST_SIDE - 1}\n"
                "help: give compare the file itself; `amacrine convert` keeps such addresses"
            )


def _records(events: Any) -> Any:
    """A pandas data frame as a structured array; else what was given."""
    if not hasattr(events, "to_records"):
        return events
    try:
        return events.to_records(index=False)
    except (TypeError, ValueError) as cause:
        raise Error(f"events of a data frame that is no structured array: {cause}\nhelp: {FIELDS}") from cause


def _array(events: Any) -> npt.NDArray[Any]:
    """Events of a structured array or a pandas data frame, one after the other, their fields
    checked."""
    events = _records(events)
    arguments.unmasked("events", events)
    try:
        given = np.asarray(events).ravel()
    except (TypeError, ValueError, RuntimeError) as cause:
        raise Error(f"the events are no array: {cause}\nhelp: {FIELDS}") from cause
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


def _check_values(name: str, values: npt.NDArray[Any]) -> None:
    """Refuses the first value of a field that no event has, with the number of its event."""
    if name == "p":
        wrong, expected = (values > 1) | (values < -1), "1 for ON, 0 or -1 for OFF"
    else:
        low, high = RANGES[name]
        wrong, expected = (values < low) | (values > high), f"{low} to {high}"
    if wrong.any():
        at = int(wrong.argmax())
        raise Error(
            f"event {at} of the array: `{name}` is {values[at]}\nhelp: {name} should be {expected}"
        )


def _packed(given: npt.NDArray[Any]) -> _amacrine.Events:
    """The events of an array, what stands in its fields checked."""
    names = given.dtype.names or ()
    own = EVENT_OF_KINDS if "channel" in names else EVENT
    has_channels = own is EVENT_OF_KINDS
    if given.dtype == own:
        packed = _amacrine.Events.of(given.view(np.uint8), has_channels, True)
        if packed is not None:
            return packed
    for name in names:
        _check_values(name, given[name])
    # Places of 16 bits without a sign, which are those of the library.
    wide = np.empty(len(given), [(name, "<u2" if name in "xy" else own[name]) for name in own.names or ()])
    for name in names:
        wide[name] = given[name] > 0 if name == "p" else given[name]
    packed = _amacrine.Events.of(wide.view(np.uint8), has_channels, False)
    if packed is None:
        raise AssertionError("each value has been checked")
    return packed


def _off(events: npt.NDArray[Any], size: tuple[int, int]) -> Error:
    """What refuses events off their sensor, with the number of the first."""
    off = (events["y"] >= size[0]) | (events["x"] >= size[1])
    at = int(off.argmax())
    x, y = events["x"][at], events["y"][at]
    return Error(
        f"event {at} of the array: `x` is {x}, `y` is {y}: off the sensor, which is "
        f"{size[1]}x{size[0]}\nhelp: give size=(height, width) of the sensor, or leave it out"
    )


def _checked(events: Any, size: tuple[int, int] | None) -> _amacrine.Events:
    """Events in any order, all of them on their sensor."""
    given = _array(events)
    packed = _packed(given)
    if size is not None and (packed.reach[0] > size[0] or packed.reach[1] > size[1]):
        raise _off(given, size)
    return packed


def _placed(events: _amacrine.Events, size: tuple[int, int] | None) -> _amacrine.Events:
    """Events whose sensor has a size."""
    if size is None and events.count == 0:
        raise Error("no events, and no size of their sensor\nhelp: give size=(height, width)")
    return events


def packed(events: Any, size: tuple[int, int] | None = None) -> _amacrine.Events:
    """Events that are in the order of their times, for the library."""
    own = _checked(events, size)
    at = own.backwards
    if at is not None:
        times = _array(events)["t"]
        raise Error(
            f"event {at} of the array: `t` runs backwards: {times[at]} us comes after "
            f"{times[at - 1]} us\n"
            'help: sort the events: events[numpy.argsort(events["t"], kind="stable")]'
        )
    return own


def voxels(
    events: Parts,
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
    start: float | None = None,
    end: float | None = None,
) -> npt.NDArray[Any]:
    """Voxels of an array of events, as :meth:`amacrine.Sensor.voxels` makes them of frames.

    Args:
        events: A structured array, or a pandas data frame, with the fields t (us), x, y, p and, of
            several kinds of cells, channel, in any order; or a list of such, one part after the other.
        size: Height and width of the sensor; where it is left out, that of the sensor or the file
            that the events are of (``.sensor_size``), else the smallest that holds them.
        channels: Kinds of cells, where some said nothing; where it is left out, those of that sensor
            (``.kinds``), else those that said something.
        start: Where windows begin, in seconds; what is before is left out. By default where the
            recording begins (``.span``), or at 0 where the events do not know that. The windows of
            ``amacrine voxels`` count from 0 in steps of ``--every``, whenever a recording begins.
        end: Up to where there are windows, in seconds. By default where the recording ends (``.span``),
            or at the last event where that does not say it: windows at its end in which nothing happens
            are there, as :meth:`amacrine.Sensor.voxels` has them.

    The rest is that of :meth:`amacrine.Sensor.voxels`.

    Returns:
        (windows,K,bins,H,W), or (windows,K,2,bins,H,W) with OFF first where they are split.
    """
    events = whole(events)
    span = getattr(events, "span", None)
    if start is None:
        start = (span or (0.0, 0.0))[0]
    since = arguments.to_micros(arguments.seconds("start", start, -arguments.SECONDS))
    size, count = size_of(events, size), kinds_of(events, channels) or 1
    given, number = _checked(events, size), voxel.number(dtype)
    last = max(given.latest - since, 0)
    stop = None if end is None else arguments.seconds("end", end, -arguments.SECONDS)
    if stop is not None:
        until = max(arguments.to_micros(stop) - since, 0)
    else:
        # Nobody must lose an event that lies behind the span.
        until = max(last, arguments.to_micros(span[1]) - since if span else 0)
    length = max(until, 1) * 1e-6 if window is None else window
    how = voxel.how(bins, length, every, causal, polarity, share, normalise)
    voxel.check_length(length, until * 1e-6)
    other = 0 if number == np.float32 else number.itemsize
    flat, (height, width, kinds) = _amacrine.voxels(
        _placed(given, size), since, size, count, how, until, other
    )
    one = voxel.shape(how, (height, width), kinds, polarity)
    return voxel.narrowed(flat, number).reshape(-1, *one)


def time_surfaces(
    events: Parts,
    times: npt.ArrayLike,
    *,
    tau: float,
    decay: str = "exponential",
    polarity: str = "split",
    size: tuple[int, int] | None = None,
    channels: int | None = None,
) -> npt.NDArray[np.float32]:
    """How long ago each cell fired: 1 for just then, 0 for never. ``amacrine voxels --as surfaces`` writes
    them of a file of any length.

    Args:
        events: A structured array, as for :func:`voxels`.
        times: When, in seconds; each surface has seen the events up to its time.
        tau: How long a cell remembers, in seconds.
        decay: ``"exponential"`` (Lagorce et al., TPAMI 2017), exp(-age / tau), or ``"linear"``,
            1 - age / tau down to 0.
        polarity: ``"split"``: OFF and ON each have a surface; ``"signed"``: the last event of
            either sign, below 0 where it was OFF.
        size: Height and width of the sensor, as for :func:`voxels`.
        channels: Kinds of cells, as for :func:`voxels`.

    Returns:
        ``float32`` (times,K,2,H,W) with OFF first, or (times,K,H,W) where they are signed.
    """
    events = whole(events)
    size, count = size_of(events, size), kinds_of(events, channels) or 1
    help = "give seconds, from 0 on, such as [0.01, 0.02]"
    seconds = [arguments.seconds("times", one) for one in arguments.numbers("times", times, help)]
    micros = [arguments.to_micros(time) for time in seconds]
    flat, place = _amacrine.surfaces(
        _placed(_checked(events, size), size),
        size,
        count,
        micros,
        arguments.number("tau", tau, "give seconds, such as tau=0.05"),
        arguments.word("decay", decay, "linear"),
        arguments.word("polarity", polarity, "split"),
    )
    return flat.reshape(len(micros), *_planes(place, polarity))


def event_frames(
    events: Parts,
    count: int,
    *,
    polarity: str = "signed",
    fill: str = "count",
    size: tuple[int, int] | None = None,
    channels: int | None = None,
) -> npt.NDArray[np.int32]:
    """Pictures of ``count`` events each, in the order of their times; the last has what is left, as
    ``amacrine voxels --as frames`` writes them of a file of any length.
    For pictures of equal times take :func:`voxels` with ``bins=1, share="whole"``.

    Args:
        events: A structured array, as for :func:`voxels`.
        count: Events of a picture.
        polarity: ``"signed"`` or ``"split"``, as for :func:`voxels`.
        fill: ``"count"``: how many events a pixel had; ``"last"``: its last one, 1 or -1 (1 where
            they are split).
        size: Height and width of the sensor, as for :func:`voxels`.
        channels: Kinds of cells, as for :func:`voxels`.

    Returns:
        ``int32`` (frames,K,H,W), or (frames,K,2,H,W) with OFF first where they are split.
    """
    events = whole(events)
    each, kinds = arguments.whole("count", count, 1), kinds_of(events, channels) or 1
    size = size_of(events, size)
    polarity, fill = arguments.word("polarity", polarity, "split"), arguments.word("fill", fill, "last")
    flat, place = _amacrine.event_frames(
        _placed(_checked(events, size), size), size, kinds, each, polarity, fill
    )
    return flat.reshape(-1, *_planes(place, polarity))


def _planes(place: tuple[int, int, int], polarity: str) -> tuple[int, ...]:
    height, width, kinds = place
    return (kinds, *((2,) if polarity == "split" else ()), height, width)
