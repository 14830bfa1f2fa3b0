"""Sensors: frames in; events, counts, voxels out."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _amacrine, arguments, notebook, toml, voxels as voxel
from ._amacrine import CHIP, DOMAIN, EFFORT, Error
from .caution import OF_ALL, Said, caution, caution_of
from .events import NamedEvents, check_side, named, view
from .frames import Clips, clips
from .kernels import Kernel, Kernels, kernels as each, named as files, npy
from .names import chip as found_chip, names as names_of, opened
from .program import Program
from .readout import Readout, readout_of
from .tensor import untracked

T = TypeVar("T")

Thresholds = Union[float, Mapping[str, float], Sequence[Any], npt.NDArray[Any]]
"""One for all kernels, or one for each: a number for both signs, a pair (on, off), or a table with
the keys ``on``, ``off`` and ``sigma``."""

UNIT = "in units of the response"
"""The unit of a sensor's thresholds."""

UNIT_OF_COMPILED = "in units of kernel times light (0 to 255)"
"""That of those who take kernels: :func:`compile`, and the studies."""

PART = 16
"""Frames that are watched before windows that are over are handed on."""

FEWER = "take them window by window (voxel_windows), or fewer or narrower ones"
"""What to do about voxels for which there is no room."""

BRIGHT = (
    "what `amacrine mesh solve --show difference` makes of one bright pixel is the kernel that is "
    "nearest to a mesh (docs/mesh.md)"
)
"""What there is in place of the kernel of a mesh."""

OWN = ("_native", "_text", "_from", "_seed", "_format", "_max_events", "channels")
"""What every float sensor has, and is made of anew in another process."""


class EventSensor(ABC):
    """What watches frames: a float sensor, or its program on a chip.

    Each call switches the sensor on anew: its first frame sets the memory and makes no event.
    Frame n is at n / fps seconds. Frames are arrays, or tensors in memory, of shape (T,H,W),
    (T,1,H,W) or (B,T,1,H,W), ``uint8``, or floats, whole numbers of other widths or ``bool`` with a ``scale``; those that lie row by row are
    read in place. The interpreter is released meanwhile. The same frames give the same events, on
    any number of threads.
    """

    @abstractmethod
    def _watch(self, size: tuple[int, int], fps: float, scale: float) -> _amacrine.Run: ...

    @abstractmethod
    def _reseeded(self, seed: int) -> EventSensor:
        """The same with another pattern of mismatch, and other noise."""

    @property
    @abstractmethod
    def name(self) -> str:
        """What it is called."""

    @property
    @abstractmethod
    def channels(self) -> list[str]:
        """The kinds of cells, by name."""

    @property
    def _called(self) -> list[str]:
        """What several kinds of cells are called in files, where one of them has a name."""
        own = [str(i) for i in range(len(self.channels))]
        if len(own) < 2 or self.channels == own:
            return []
        pairs = zip(self.channels, own)
        return [f"kind {i}" if name == i else name for name, i in pairs]

    def _each(
        self, given: Clips, fps: float, watch: Callable[[int, _amacrine.Run], T]
    ) -> list[T]:
        """What is made of every clip, each by a run of its own, which the caller is warned of."""
        halt = _amacrine.Halt()

        def one(b: int) -> tuple[T, Said]:
            run = self._watch(given.size, fps, given.scale)
            run.heed(halt)
            return watch(b, run), run.warnings(self.name)

        seen = _all(len(given.all), one, halt)
        caution_of(said for _, said in seen)
        return [made for made, _ in seen]

    def _contrast(self, upsample: Any) -> float | None:
        """The contrast for which frames are put in."""
        return arguments.contrast(upsample)

    def events(
        self,
        frames: Any,
        fps: float,
        *,
        scale: float | None = None,
        upsample: float | None = None,
        readout: Readout | None = None,
    ) -> NamedEvents:
        """The events of a clip.

        Args:
            frames: Light, (T,H,W), (T,1,H,W) or (B,T,1,H,W).
            fps: Frames per second.
            scale: What floats are multiplied by to be light from 0 to 255.
            upsample: Frames are put in so that no pixel's light changes by more than this from one to
                the next, in ln units; of float sensors.
            readout: What stands between the cells and the array: a name of
                ``amacrine.names("readouts")``, a file like those, or a table with settings, such as
                ``{"readout": "arbiter", "fifo": 64, "link": "1us"}``. What it loses is in
                ``.dropped``.

        Returns:
            A structured array with the fields ``t`` (us), ``x``, ``y`` (pixels), ``p`` (1 for ON,
            0 for OFF), ordered by time, and ``channel`` where there are several kinds of cells:
            what ``numpy.load`` makes of the file that ``amacrine run --events`` writes. It knows
            its ``.sensor_size``, ``.kinds`` and their ``.names``, and the ``.span`` of the clip, up to
            the last event where a readout has it arrive later. A list of arrays where there are several
            clips, as (B,T,1,H,W) has them.
        """
        given, fps = clips(frames, scale), arguments.rate(fps)
        check_side(given.size)
        kinds, called = len(self.channels), self._called
        contrast, through = self._contrast(upsample), readout_of(readout)
        end = max(given.frames - 1, 0) / fps

        def watch(b: int, run: _amacrine.Run) -> NamedEvents:
            records = view(run.events(given.clip(b), contrast, through), kinds)
            # What a readout delays may arrive after the last frame.
            last = 0 if through is None else int(records["t"].max(initial=0))
            span = 0.0, max(end, last / 1e6)
            return named(records, called, given.size, kinds, span, run.dropped)

        all: Any = self._each(given, fps, watch)
        found: NamedEvents = all if given.batched else all[0]
        return found

    def counts(
        self,
        frames: Any,
        fps: float,
        *,
        scale: float | None = None,
        upsample: float | None = None,
    ) -> npt.NDArray[np.int32]:
        """Signed event counts between each two frames.

        Args:
            frames: Light, (T,H,W), (T,1,H,W) or (B,T,1,H,W).
            fps: Frames per second.
            scale: What floats are multiplied by to be light from 0 to 255.
            upsample: As for :meth:`events`; counts are those between two frames of the clip.

        Returns:
            ``int32`` of shape (T-1,K,H,W), or (B,T-1,K,H,W): ON less OFF of each of the K kinds
            of cells.
        """
        given, fps = clips(frames, scale), arguments.rate(fps)
        pairs = max(given.frames - 1, 0)
        shape = (len(given.all), pairs, len(self.channels), *given.size)
        out = _zeros("counts", shape, np.int32, "take them part by part (stream)")
        contrast = self._contrast(upsample)

        def watch(b: int, run: _amacrine.Run) -> None:
            # Arrays of nothing all lie at one place, and are borrowed one at a time.
            into = out[b].reshape(-1) if pairs else np.zeros(0, np.int32)
            run.counts(given.clip(b), contrast, into)

        self._each(given, fps, watch)
        return out if given.batched else out[0]

    def voxels(
        self,
        frames: Any,
        fps: float,
        *,
        bins: int | None = None,
        window: float | None = None,
        every: float | None = None,
        causal: bool = True,
        polarity: str = "signed",
        share: str = "bilinear",
        normalise: str | None = None,
        dtype: npt.DTypeLike = np.float32,
        scale: float | None = None,
        upsample: float | None = None,
    ) -> npt.NDArray[Any]:
        """Events in bins of time.

        Args:
            frames: Light, (T,H,W), (T,1,H,W) or (B,T,1,H,W).
            fps: Frames per second.
            bins: Bins of a window. Left out: a bin for each frame, centred on it.
            window: Length of a window, in seconds; the whole clip where it is left out.
            every: From one window to the next, in seconds; as ``window`` where it is left out, so
                that they tile the clip.
            causal: Window n ends at (n + 1) every, so that nothing in it comes from later; else it
                has its middle at n every, each end to the nearest microsecond. It has the events
                after its start and up to its end, the first one those at its start, too.
            polarity: ``"signed"``: ON less OFF; ``"split"``: OFF and ON each have bins of their
                own.
            share: ``"bilinear"``: an event is shared between the two nearest bins, the first of
                which has its middle at the window's start and the last at its end (Zhu et al., CVPR
                2019); ``"whole"``: each bin is a ``bins``-th of the window, and an event counts where
                it falls, at the end of a bin in that bin.
            normalise: Kind by kind in each window: ``"std"``: what is not 0 has a mean of 0 and a
                deviation of 1, as E2VID takes it (where all of that are equal, or one, they become
                0); ``"max"``: the largest is 1 in size.
            dtype: float32, float16 or float64; of single precision each.
            scale: What floats are multiplied by to be light from 0 to 255.
            upsample: As for :meth:`events`, with ``bins``.

        Returns:
            Voxels in events. Without ``bins`` (T,K,H,W), what ``amacrine run --voxels`` writes.
            With them (windows,K,bins,H,W), or (windows,K,2,bins,H,W) with OFF first where they are
            split. Of several clips with a leading axis (B,…).
        """
        given, number, fps = clips(frames, scale), voxel.number(dtype), arguments.rate(fps)
        kinds, size = len(self.channels), given.size
        if bins is None:
            asked = window, every, causal, polarity, share, normalise, upsample
            usual = None, None, True, "signed", "bilinear", None, None
            # An array has no one answer to whether it is equal.
            if any(arguments.axes(one) or one != its for one, its in zip(asked, usual)):
                raise Error(
                    "window, every, causal, polarity, share, normalise and upsample are of windows of "
                    "bins\n"
                    "help: give bins, such as bins=9"
                )
            shape = (len(given.all), given.frames, kinds, *size)
            again = 0 if number == np.float32 else math.prod(shape) * number.itemsize
            out = _zeros("voxels", shape, np.float32, FEWER, again)

            def watch(b: int, run: _amacrine.Run) -> None:
                run.voxels(given.clip(b), out[b].reshape(-1))

            self._each(given, fps, watch)
            cast = voxel.narrowed(out, number)
            return cast if given.batched else cast[0]
        seconds = max(given.frames - 1, 0) / fps
        # The whole clip; no window is shorter than a microsecond.
        whole = max(seconds, 1e-6) if seconds else 1.0
        length = whole if window is None else window
        how = voxel.how(bins, length, every, causal, polarity, share, normalise)
        one = voxel.shape(how, size, kinds, polarity)
        voxel.check_length(length, seconds)
        windows = how.count(arguments.to_micros(seconds))
        contrast = self._contrast(upsample)
        step = PART if contrast is None else max(given.frames, 1)
        # Sums of windows that have begun, and windows that end within a part.
        held = how.held(size, kinds, windows, step / fps)
        held += 0 if number == np.float32 else math.prod(one) * number.itemsize
        beside = held * min(len(given.all), _amacrine.threads())
        shared = _zeros("voxels", (len(given.all), windows, *one), number, FEWER, beside)

        def bin(b: int, run: _amacrine.Run) -> None:
            clip = given.clip(b)
            parts = (clip[n : n + step] for n in range(0, len(clip), step))
            over = _windows(run, (parts, contrast), how, (size, kinds), seconds)
            for to, values in zip(shared[b], over):
                to[...] = voxel.narrowed(values, number).reshape(one)

        self._each(given, fps, bin)
        return shared if given.batched else shared[0]

    def voxel_windows(
        self,
        parts: Iterable[Any],
        fps: float,
        *,
        bins: int,
        window: float,
        every: float | None = None,
        causal: bool = True,
        polarity: str = "signed",
        share: str = "bilinear",
        normalise: str | None = None,
        dtype: npt.DTypeLike = np.float32,
        scale: float | None = None,
    ) -> Iterator[npt.NDArray[Any]]:
        """The windows of :meth:`voxels` one after the other, as soon as each is over: for clips that
        do not fit into memory.

        Args:
            parts: The clip, part by part: arrays of shape (t,H,W) or (t,1,H,W).

        The rest is that of :meth:`voxels`. A window comes with the frame after the one that ends
        it, since right behind a frame there may be events of its microsecond; the last windows come
        when the parts end.

        Yields:
            Windows of shape (K,bins,H,W), or (K,2,bins,H,W) where they are split.
        """
        how = voxel.how(bins, window, every, causal, polarity, share, normalise)
        stream = self.stream(fps, scale=scale)
        parts = arguments.parts(parts)
        return self._windows_of(parts, stream, (how, window), polarity, voxel.number(dtype))

    def _windows_of(
        self,
        parts: Iterable[Any],
        stream: Stream,
        asked: tuple[_amacrine.Voxels, float],
        polarity: str,
        number: np.dtype[Any],
    ) -> Iterator[npt.NDArray[Any]]:
        how, window = asked
        opened: _amacrine.Stream | None = None
        one: tuple[int, ...] = ()
        for part in parts:
            run, clip = stream._next(part)
            for n in range(0, len(clip), PART):
                if opened is None:
                    size = clip.shape[1], clip.shape[2]
                    opened = _amacrine.Stream(how, size, len(self.channels))
                    one = voxel.shape(how, size, len(self.channels), polarity)
                for values in run.windows(clip[n : n + PART], None, opened):
                    yield voxel.narrowed(values, number).reshape(one)
        if opened is not None:
            seconds = max(stream.seen - 1, 0) / stream.fps
            # How long the clip is nobody knows before; it is said with the windows that its end leaves.
            voxel.check_length(window, seconds)
            for values in opened.rest(arguments.to_micros(seconds)):
                yield voxel.narrowed(values, number).reshape(one)
        stream._caution(over=True)

    def stream(self, fps: float, *, scale: float | None = None) -> Stream:
        """A clip that comes part by part: memory and time go on from one part to the next."""
        return Stream(self, fps, scale)


class Stream:
    """A sensor that watches a clip part by part."""

    def __init__(self, sensor: EventSensor, fps: float, scale: float | None) -> None:
        self._sensor, self._scale = sensor, scale
        self.fps = arguments.rate(fps)
        """Frames per second."""
        self._run: _amacrine.Run | None = None
        self._turn = _amacrine.Turn()
        self._told: set[str] = set()

    def _next(self, frames: Any) -> tuple[_amacrine.Run, npt.NDArray[Any]]:
        given = clips(frames, self._scale)
        if given.batched:
            raise Error("a stream is of one clip\nhelp: give an array of shape (T,H,W)")
        if self._run is None:
            self._run = self._sensor._watch(given.size, self.fps, given.scale)
        return self._run, given.clip(0)

    def _caution(self, *, over: bool = False) -> None:
        """Warns once of each thing; of no event and of small light where so much was seen, or the
        clip is over."""
        if self._run is None:
            return
        for about, text in self._run.warnings(self._sensor.name):
            early = about in OF_ALL and not over and self.seen < PART
            if about not in self._told and not early:
                self._told.add(about)
                caution(text)

    def events(self, frames: Any) -> NamedEvents:
        """The events of the next frames."""
        return self._turn.take(lambda: self._events(frames))

    def _events(self, frames: Any) -> NamedEvents:
        run, clip = self._next(frames)
        size = clip.shape[1], clip.shape[2]
        check_side(size)
        kinds, begin, before = len(self._sensor.channels), max(run.seen - 1, 0), run.dropped
        events = view(run.events(clip, None, None), kinds)
        span = begin / self.fps, max(run.seen - 1, 0) / self.fps
        dropped = {why: count - before[why] for why, count in run.dropped.items()}
        self._caution()
        return named(events, self._sensor._called, size, kinds, span, dropped)

    def counts(self, frames: Any) -> npt.NDArray[np.int32]:
        """The counts of the next frames, (n,K,H,W), one less of the very first."""
        return self._turn.take(lambda: self._counts(frames))

    def _counts(self, frames: Any) -> npt.NDArray[np.int32]:
        run, clip = self._next(frames)
        pairs = len(clip) - (run.seen == 0)
        out = np.zeros((max(pairs, 0), len(self._sensor.channels), *clip.shape[1:]), np.int32)
        run.counts(clip, None, out.reshape(-1))
        self._caution()
        return out

    def each(self, parts: Iterable[Any]) -> Iterator[NamedEvents]:
        """The events of each part, and a :class:`Caution` at the end where there was none at all."""
        for part in arguments.parts(parts):
            yield self.events(part)
        self._caution(over=True)

    @property
    def seen(self) -> int:
        """Frames seen."""
        return 0 if self._run is None else self._run.seen


class Sensor(EventSensor):
    """A float sensor: for each kind of cell a kernel, and a threshold on how far the filtered
    signal moves.

    Args:
        kernels: (k,k), (K,k,k) or (K,1,k,k), k odd, row 0 to the north: the weights of a
            convolution are taken as they are. Or the name of a built-in kernel, a kernel file, or
            a list of any of these.
        thresholds: One number for all kernels, or a list of one for each, in the unit of the
            filtered signal: a number, a pair (on, off), or a table with ``on``, ``off`` and
            ``sigma`` (mismatch).
        response: From light (0 to 255) to signal: ``"identity"``, ``{"linear": 255}`` (light/255,
            the default), ``{"log": {"white": 255, "offset": 1e-5}}`` or ``{"lin-log": {"knee":
            20}}``.
        memory: What an event does to the memory: ``"filtered-step"`` (it moves by one threshold),
            ``"filtered-snap"`` (it stores the filtered signal) or ``"raw-snap"`` (the pixel).
        shared: One memory of the pixel for all kinds, with ``"raw-snap"``.
        polarity: ``"filtered"`` or ``"pixel"``: where an event's sign comes from.
        border: ``"replicate"`` or ``"zero"``: what kernels read off the array.
        refractory: How long a cell is silent after an event, in us, or a table with ``us`` and
            ``rule``.
        noise: A table of what disturbs the cells, such as ``{"shot-hz": 5, "leak-hz": 0.1}``.
        names: What the kinds of cells are called.
        name: What the sensor is called.
        seed: Chooses mismatch and noise, both together and the same in every clip, of a batch or
            not; 0 is a seed as any other. Give each clip of training data its own. A sensor without
            mismatch and noise takes one, too: it is handed on to its program (:meth:`on_chip`).
        format: The number format of signals, weights and memory: ``f64``, ``f32``, ``f16``,
            ``bf16``, ``q8.8``, …
        max_events: More events of a clip than this are an error, where events are listed:
            :meth:`events`, and :meth:`voxels` with ``bins``.

    ``docs/reference.md`` has the equations, and what noise there is.
    """

    def __init__(
        self,
        kernels: Kernels,
        thresholds: Thresholds,
        *,
        response: str | Mapping[str, Any] | None = None,
        memory: str = "filtered-step",
        shared: bool | None = None,
        polarity: str | None = None,
        border: str | None = None,
        refractory: float | Mapping[str, Any] | None = None,
        noise: Mapping[str, Any] | None = None,
        names: Sequence[str] | None = None,
        name: str = "sensor",
        seed: int = 0,
        format: str = "f64",
        max_events: int | None = None,
    ) -> None:
        if isinstance(memory, str) and memory == "authors-pixel-step":
            raise Error(
                f"memory = {memory!r} needs a kernel for the memory and the authors' refractory rule\n"
                "help: write a sensor file with its memory-kernel, for Sensor.from_text or from_file"
            )
        arguments.one_of("memory", memory, _amacrine.MEMORIES)
        head = {
            "name": name,
            "response": {"linear": 255} if response is None else response,
            "memory": memory,
            "shared": shared,
            "polarity": polarity,
            "border": border,
            "refractory": _refractory(refractory),
            "noise": noise,
        }
        found = each(kernels)
        limits = _thresholds(thresholds, len(found))
        names = None if names is None else arguments.names("names", names)
        if names is not None and len(names) != len(found):
            raise Error(f"{len(names)} names for {len(found)} kernels\nhelp: give one for each")

        def text(kernel_of: Callable[[int, Kernel], Any]) -> str:
            channels = (
                "\n[[channel]]\n"
                + toml.table(
                    {
                        "name": None if names is None else str(names[i]),
                        "kernel": kernel_of(i, kernel),
                        "threshold": limits[i],
                    }
                )
                for i, kernel in enumerate(found)
            )
            return toml.table(head) + "".join(channels)

        # What is wrong with an array is said of the array, not of a line of numbers.
        arrays = {
            f"kernels[{i}]": npy(kernel)
            for i, kernel in enumerate(found)
            if not isinstance(kernel, str)
        }
        checked = text(lambda i, kernel: kernel if isinstance(kernel, str) else f"kernels[{i}]")
        # Kernel files that are named are found from elsewhere, too: a worker may be in another folder.
        folder = Path().absolute()
        self._native = _amacrine.Sensor("Sensor(…)", checked, arrays, folder)
        self._text = text(lambda i, kernel: kernel)
        self._from: tuple[str, Path | None] = "Sensor(…)", folder
        self._seed, self._format, self._max_events = _how(seed, format, max_events)

    @classmethod
    def from_file(
        cls,
        path: str | Path,
        *,
        seed: int = 0,
        format: str = "f64",
        max_events: int | None = None,
    ) -> Sensor:
        """A sensor file, or one that comes with the package by name, such as ``"rgc-4"``
        (:func:`amacrine.names` lists them)."""
        file, text, folder = opened("sensors", path)
        return cls._of_text(file, text, folder, (seed, format, max_events))

    @classmethod
    def from_text(
        cls,
        text: str,
        *,
        seed: int = 0,
        format: str = "f64",
        max_events: int | None = None,
    ) -> Sensor:
        """The text of a sensor file."""
        text = arguments.word("text", text, '[[channel]]\nkernel = "dvs"\nthreshold = 0.2')
        return cls._of_text("sensor.toml", text, Path().absolute(), (seed, format, max_events))

    @classmethod
    def _of_text(
        cls, file: str, text: str, folder: Path | None, how: tuple[int, str, int | None]
    ) -> Sensor:
        self = cls.__new__(cls)
        self._native = _amacrine.Sensor(file, text, {}, folder)
        self._text = text
        self._from = file, folder
        self._seed, self._format, self._max_events = _how(*how)
        return self

    def _watch(self, size: tuple[int, int], fps: float, scale: float) -> _amacrine.Run:
        return self._native.watch(
            size, fps, scale, self._seed, self._format, self._max_events
        )

    def _reseeded(self, seed: int) -> Sensor:
        return self._with(_seed=seed)

    def _with(self, **others: Any) -> Sensor:
        """The same, of the same class, but for these."""
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__, **others)
        return other

    def _rewritten(self, text: str) -> Sensor:
        """The same with another text, which needs no files."""
        how = (self._seed, self._format, self._max_events)
        made = type(self)._of_text(self._from[0], text, None, how)
        made.__dict__.update(self._added())
        return made

    def _added(self) -> dict[str, Any]:
        """What a subclass, or whoever has it, has put into it."""
        return {name: of for name, of in self.__dict__.items() if name not in OWN}

    @property
    def name(self) -> str:
        """What it is called."""
        return self._native.name

    @cached_property
    def channels(self) -> list[str]:
        """The kinds of cells, by name."""
        named = self._native.channels
        return [str(i) if name is None else name for i, name in enumerate(named)]

    @property
    def text(self) -> str:
        """The sensor file: ``amacrine run --sensor`` takes it."""
        return self._text

    @property
    def kernels(self) -> list[npt.NDArray[np.float64]]:
        """For each kind of cell its kernel, (k,k), row 0 to the north; (4,k,k) of a 2x2 pattern, whose
        smaller kernels have zeros round them. A kind that sees through a mesh has none: an
        :class:`Error`."""
        found = []
        for i, own in enumerate(self._native.kernels):
            if own is None:
                raise Error(
                    f"{self.name}, channel {i}: it sees through a mesh, which no kernel (k,k) is\n"
                    f"help: {BRIGHT}"
                )
            found.append(stacked(own) if len(own) > 1 else own[0])
        return found

    @property
    def thresholds(self) -> list[npt.NDArray[np.float64]]:
        """For each kind of cell its thresholds, (3,): ON, OFF, and the deviation of their mismatch,
        in the unit of the filtered signal; (4,3) of a 2x2 pattern."""
        return [
            np.array(own) if len(own) > 1 else np.array(own[0]) for own in self._native.thresholds
        ]

    def __reduce__(self) -> tuple[Any, ...]:
        (file, folder), how = self._from, (self._seed, self._format, self._max_events)
        return type(self)._of_text, (file, self._text, folder, how), self._added() or None

    def __eq__(self, other: object) -> bool:
        """Whether text, kernels, seed, number format and limit are the same: they then make the same
        events."""
        if not isinstance(other, Sensor):
            return NotImplemented
        same = self._stated() == other._stated()
        # Files of kernels that are called the same may hold others.
        both = self._weights(), other._weights()
        return same and len(both[0]) == len(both[1]) and all(map(np.array_equal, *both))

    def _weights(self) -> list[npt.NDArray[np.float64]]:
        """All its kernels; of a mesh, whose numbers are in the text, none."""
        return [kernel for own in self._native.kernels for kernel in own or ()]

    def __hash__(self) -> int:
        return hash(self._stated())

    def _stated(self) -> tuple[Any, ...]:
        return self._text, self._seed, self._format, self._max_events

    def __repr__(self) -> str:
        return f"<Sensor {self.name}: {', '.join(self.channels)}>"

    def _repr_html_(self) -> str:
        head = {"sensor": self.name, "format": self._format, "seed": self._seed}
        kinds: list[dict[str, Any]] = []
        drawn: list[notebook.Plane] = []
        for name, kernels, limits in zip(
            self.channels, self._native.kernels, self._native.thresholds
        ):
            count = max(len(limits), len(kernels or ()))
            for n in range(count):
                # The four of a 2x2 pattern, in the order of its pixels.
                kind = name if count == 1 else f"{name}, x {n % 2}, y {n // 2}"
                on, off, sigma = limits[n % len(limits)]
                signs = {"threshold ON": on, "OFF": off, "mismatch": sigma}
                of_sum: dict[str, Any] = {"kernel": "mesh", "sum": None}
                if kernels is not None:
                    kernel = kernels[n % len(kernels)]
                    of_sum = {"kernel": notebook.size(kernel), "sum": float(kernel.sum())}
                    drawn.append((kind, kernel))
                kinds.append({"kind": kind} | of_sum | signs)
        tables = notebook.table([head]) + notebook.table(kinds) + notebook.planes(drawn)
        return tables + notebook.text("its file", self.text)

    def without(self, *effects: str) -> Sensor:
        """The sensor without some of its effects: ``"dead-time"``, ``"noise-events"``, ``"jitter"``,
        ``"bandwidth"``, ``"leak"``, ``"mismatch"``, ``"mesh-noise"``. What it does not have it
        cannot leave out."""
        return self._rewritten(self._native.without(arguments.names("effects", effects)))

    def changed(
        self,
        *,
        kernels: Kernels | None = None,
        thresholds: Any = None,
        sigma: float | None = None,
    ) -> Sensor:
        """The sensor with others than its own, as ``amacrine run --kernel``, ``--threshold`` and
        ``--sigma`` have it.

        Args:
            kernels: As for :class:`Sensor`: a kind of cell for each, which is else as the first.
            thresholds: A number, or (on, off), of every kind; or a table with on, off and sigma. Without
                sigma the spread from cell to cell stays.
            sigma: The spread of thresholds from cell to cell, their standard deviation.
        """
        table = {} if thresholds is None else _threshold("thresholds", thresholds, UNIT)
        spread = table.get("sigma") if sigma is None else sigma
        if spread is not None:
            help = f"give a number of 0 or more, {UNIT}"
            spread = arguments.number("sigma", spread, help)
        of = None if kernels is None else (files(kernels), "given")
        both = (table["on"], table["off"]) if table else None
        return self._rewritten(self._native.changed(of, both, spread))

    def with_seed(self, seed: int) -> Sensor:
        """The sensor with another mismatch and other noise: those of this seed."""
        return self._reseeded(arguments.whole("seed", seed))

    def in_format(self, format: str) -> Sensor:
        """The sensor in another number format: ``f64``, ``f32``, ``f16``, ``bf16``, ``q8.8``, …"""
        return self._with(_format=arguments.word("format", format, "f32"))

    def for_rate(
        self, frames: Any, fps: float, rate: float, *, scale: float | None = None
    ) -> Sensor:
        """The sensor that says so many events of these frames: all thresholds, and their mismatch,
        times one number, as ``amacrine run --rate`` finds it.

        Args:
            frames: Light, one clip.
            fps: Frames per second.
            rate: Events per pixel and second, all kinds together.
            scale: What makes light from 0 to 255 of the numbers.

        The thresholds are found in ``f64``, whatever the format. Warns (:class:`Caution`) where no
        threshold gives that rate, and takes the nearest.
        """
        given, fps = clips(frames, scale), arguments.rate(fps)
        if given.batched:
            raise Error("several clips where one is watched\nhelp: give an array of shape (T,H,W)")
        rate = arguments.number("rate", rate, "give events per pixel and second, such as rate=2")
        text = self._native.for_rate(given.clip(0), fps, given.scale, rate, self._seed)
        return self._rewritten(text)

    def on_chip(
        self,
        to: str = "exact",
        *,
        domain: str = DOMAIN,
        chip: str | Path = CHIP,
        sum: str = "kept",
        memory: str | None = None,
        readout: str = "all",
        objective: str = "silicon",
        border: bool = False,
        events_per_frame: int | None = None,
        effort: float = EFFORT,
        seed: int | None = None,
    ) -> ChipSensor:
        """Its cells as one program of a chip, watching the same frames.

        Args:
            to: The few values that kernels are brought to: a quantiser such as ``"ternary"`` or
                ``"int-5"``, or ``"exact"`` for weights as they are.
            domain: What the cells of the array hold: ``"silicon"`` (with the errors of the chip),
                ``"exact"``, ``"f16"``, ``"q8.8"``, …; in those of numbers registers end at the chip's
                range, as in studies (``.program.run`` does so with ``clip=True``); cells of silicon
                saturate as the chip's data say (``clip=False``).
            chip: A shipped chip by name, or the folder of another.
            sum: What the quantised kernels must sum to: ``"free"``, ``"zero"``, which weights as they
                are cannot be told to, or ``"kept"``.
            memory: What the program remembers: ``"analogue"``, the drive of each kind, for which
                SCAMP-5 has registers enough for two kinds; ``"shared"``, the pixel, in one register
                for all kinds; ``"bits:N"``, the drive in N one-bit registers a kind. What
                is nearest to the sensor where it is left out.
            readout: ``"all"`` reads every event, ``"slots"`` at most 4000 in each scan, as the
                program asks for; others are lost.
            objective: What the program is to be best at: ``"silicon"``, the events that are kept on
                the chip and nearly all of them without its errors too; ``"events"``, whatever
                saturates; ``"exact"``, event for event what the float model of the same levels says
                where the array is exact; ``"words"``, the fewest where no light saturates.
            border: Whether the program must be right up to the border of the array, zeros beyond it,
                however little comes out of it, or is refused; else one that is not is told of.
            events_per_frame: How many events the busiest frame is expected to have, all signs and
                kinds together: the program reads them in the cheapest way that loses none of so
                many; all slots where it is left out.
            effort: How long to search for the program, in seconds of two cores of 2024 for one
                kernel of 3x3: it counts states, of which larger kernels and several kinds take
                longer.
            seed: Which chip and which noise, and the seed of the search; the sensor's own where it
                is left out.

        The program takes one decision a frame, stores what was seen (``filtered-snap``) and sees 0
        off the array: where the sensor is another, or the program is wrong at the border, a
        :class:`Caution` says so.
        """
        how = (sum, memory, readout, objective, border, events_per_frame)
        return _cautioned(self._found(to, domain, chip, how, effort, seed))

    def _found(
        self,
        to: str,
        domain: str,
        chip: str | Path,
        how: tuple[str, str | None, str, str, bool, int | None],
        effort: float,
        seed: int | None,
    ) -> ChipSensor:
        sum, memory, readout, objective, border, busiest = how
        if busiest is not None:
            busiest = arguments.whole("events_per_frame", busiest, 1)
        arguments.one_of("readout", readout, ("all", "slots"))
        seed = self._seed if seed is None else arguments.whole("seed", seed)
        effort = arguments.number("effort", effort, "give seconds, such as effort=1")
        (to, sum), domain = _levels(to, sum), _domain(domain)
        memory = arguments.word_or_none("memory", memory, "shared")
        objective = arguments.word("objective", objective, "silicon")
        on = found_chip(chip)
        aim = (objective, arguments.flag("border", border))
        native = self._native.on_chip(to, sum, memory, on, aim, busiest, effort, seed)
        watched = (seed, domain, readout == "slots", self._max_events)
        return ChipSensor(native, self.channels, watched)


class ChipSensor(EventSensor):
    """A sensor as one program of a chip; :meth:`Sensor.on_chip` and :func:`compile` make it."""

    def __init__(
        self,
        native: _amacrine.Chip,
        channels: list[str],
        how: tuple[int, str, bool, int | None],
    ) -> None:
        self._native, self._channels = native, channels
        self._how = how

    def _watch(self, size: tuple[int, int], fps: float, scale: float) -> _amacrine.Run:
        seed, domain, slots, most = self._how
        return self._native.watch(size, fps, scale, seed, domain, slots, most)

    def _contrast(self, upsample: Any) -> None:
        if upsample is not None:
            raise Error("upsample of a program\nhelp: leave upsample out: a program sees frames")

    def _reseeded(self, seed: int) -> ChipSensor:
        return self.with_domain(self._how[1], seed=seed)

    def with_domain(self, domain: str, *, seed: int | None = None) -> ChipSensor:
        """The same program on cells that hold something else, or on another chip (``seed``, which
        cells without errors keep for when they have some again)."""
        own, _, slots, most = self._how
        domain = _domain(domain)
        how = (own if seed is None else arguments.whole("seed", seed), domain, slots, most)
        return ChipSensor(self._native, self._channels, how)

    @property
    def name(self) -> str:
        """What it is called."""
        return self._native.title

    @property
    def channels(self) -> list[str]:
        """The kinds of cells, by name."""
        return self._channels

    @property
    def words(self) -> int:
        """Instruction words of a frame."""
        return self._native.words

    @property
    def array_us(self) -> float:
        """Microseconds of a frame on the array, without readout."""
        return self._native.array_us

    @property
    def lsb(self) -> float:
        """LSB of the drive for each unit of level times light."""
        return self._native.lsb

    @property
    def levels(self) -> list[tuple[npt.NDArray[np.float64], float]]:
        """For each kind of cell the kernel that the chip computes, (k,k), and what it is to be
        multiplied by to be the sensor's."""
        return self._native.levels

    @property
    def notes(self) -> list[str]:
        """In what it differs from the float sensor, and what few values have erased."""
        return self._native.notes

    @property
    def text(self) -> str:
        """The program, as ``amacrine exec`` takes it."""
        return self._native.text

    @property
    def program(self) -> Program:
        """The program, whose registers can be looked at."""
        return Program.from_text(self.text, chip=self._native.chip)

    def __reduce__(self) -> tuple[Any, ...]:
        of = self._native
        found = of.title, of.text, of.chip, of.lsb, of.levels, of.notes
        return _found_before, (found, self._channels, self._how)

    def __repr__(self) -> str:
        return f"<ChipSensor {self.name}: {self.words} words, {self.array_us:.1f} us>"

    def _repr_html_(self) -> str:
        seed, domain, slots, _ = self._how
        head = {
            "program": self.name,
            "chip": Path(self._native.chip).name,
            "words": self.words,
            "us on the array": self.array_us,
            "LSB for a unit": self.lsb,
            "domain": domain,
            "seed": seed,
            "readout": "slots" if slots else "all",
        }
        named = list(zip(self.channels, self.levels))
        kinds = [
            {"kind": kind, "levels": notebook.size(levels), "taps": int(np.count_nonzero(levels))}
            | {"scale": scale, "sum": float(levels.sum()) * scale}
            for kind, (levels, scale) in named
        ]
        drawn = notebook.planes((f"levels of {kind}", levels) for kind, (levels, _) in named)
        tables = notebook.table([head]) + notebook.table(kinds) + drawn
        return tables + notebook.sentences(self.notes) + notebook.text("the program", self.text)


def _found_before(
    found: tuple[Any, ...], channels: list[str], how: tuple[int, str, bool, int | None]
) -> ChipSensor:
    """A program that was found in another process: nothing is searched."""
    return ChipSensor(_amacrine.Chip(*found), channels, how)


def compile(
    kernels: Kernels | Sensor,
    thresholds: Thresholds | None = None,
    *,
    to: str = "exact",
    domain: str = DOMAIN,
    chip: str | Path = CHIP,
    sum: str = "kept",
    memory: str | None = None,
    readout: str = "all",
    objective: str = "silicon",
    border: bool = False,
    events_per_frame: int | None = None,
    effort: float = EFFORT,
    seed: int | None = None,
) -> ChipSensor:
    """Kernels, or a sensor, as one program of a chip, with the proof that it computes them.

    Args:
        kernels: As for :class:`Sensor`; or a sensor, or the file or the name of one, as
            ``amacrine compile --sensor`` has it.
        thresholds: Events where kernel times light (0 to 255) moved by more than this; a sensor has its
            own.
        to: A quantiser, or ``"exact"``.
        memory: ``"analogue"`` of kernels, and what is nearest to a sensor, where it is left out.
        seed: 0 of kernels, and a sensor's own, where it is left out.

    The rest is that of :meth:`Sensor.on_chip`.
    """
    how = (sum, memory, readout, objective, border, events_per_frame)
    given = sensor_of(kernels)
    if given is not None:
        if thresholds is not None:
            raise Error(
                f"{given[0]} has thresholds of its own, and thresholds = {thresholds!r}\n"
                "help: leave thresholds out, or give its kernels (Sensor.kernels) with thresholds"
            )
        return _cautioned(given[1]._found(to, domain, chip, how, effort, seed))
    if thresholds is None:
        raise Error(
            "a program needs a threshold\n"
            "help: give thresholds=40, in units of kernel times light (0 to 255), or a sensor, which "
            "has its own; compile_filter is the filter alone"
        )
    memory = "analogue" if memory is None else arguments.word("memory", memory, "shared")
    found = each(kernels)
    sensor = Sensor(
        found,
        _thresholds(thresholds, len(found), UNIT_OF_COMPILED),
        response="identity",
        memory="raw-snap" if memory == "shared" else "filtered-snap",
        shared=True if memory == "shared" else None,
        border="zero",
        name="compiled",
        seed=0 if seed is None else seed,
    )
    how = (sum, memory, readout, objective, border, events_per_frame)
    return _cautioned(sensor._found(to, domain, chip, how, effort, None))


def sensor_of(given: Any) -> tuple[str, Sensor] | None:
    """The sensor that is given, or whose file or name is, and what it is called; none of what is no
    sensor. A kernel of the same name comes first."""
    if isinstance(given, Sensor):
        return given.name, given
    if not isinstance(given, (str, Path)) or str(given) in names_of("kernels"):
        return None
    path = Path(given)
    if not path.is_file():
        is_known = _amacrine.text("sensors", str(given)) is not None
        return (str(given), Sensor.from_file(given)) if is_known else None
    if path.suffix != ".toml":
        return None
    try:
        is_sensor = _amacrine.is_sensor(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError):
        return None
    return (str(given), Sensor.from_file(given)) if is_sensor else None


@dataclass(frozen=True)
class CompiledFilter:
    """Kernels as statements of the array, without thresholds and events."""

    program: Program
    """The statements, which filter what ``A`` holds: ``program.run(frames, registers={"A": …})``."""
    results: dict[str, float]
    """The register of each result, in the order of the kernels, and what it holds of the kernel's
    response: kernel times input times this."""

    @property
    def text(self) -> str:
        """The statements."""
        return self.program.text

    @property
    def words(self) -> int:
        """Instruction words."""
        return self.program.words

    def _repr_html_(self) -> str:
        head = {"words": self.words, "us on the array": self.program.array_us}
        rows = [{"register": name, "of the response": of} for name, of in self.results.items()]
        return notebook.table([head]) + notebook.table(rows) + notebook.text("the statements", self.text)


def compile_filter(
    kernels: Kernels,
    *,
    to: str = "exact",
    input: tuple[float, float] | None = None,
    border: bool = False,
    chip: str | Path = CHIP,
    sum: str = "kept",
    objective: str = "silicon",
    effort: float = EFFORT,
    seed: int = 0,
) -> CompiledFilter:
    """Kernels as statements that filter what register ``A`` holds, without thresholds and events:
    ``amacrine compile --filter-only``.

    Args:
        kernels: As for :class:`Sensor`; the results lie in ``A``, ``B``, ….
        to: A quantiser, or ``"exact"``.
        input: The least and the most that ``A`` holds, in LSB: it is halved until nothing saturates.
            Without it as often as more comes out of the chip, if too little does of the kernels themselves.
        border: Right up to the border, zeros beyond it, if that can be had.

    The rest is that of :meth:`Sensor.on_chip`.
    """
    ends = None if input is None else arguments.numbers("input", input, INPUT)
    if ends is not None and len(ends) != 2:
        raise Error(f"input = {input!r}\nhelp: {INPUT}")
    on, (to, sum) = found_chip(chip), _levels(to, sum)
    text, results = _amacrine.compile_filter(
        files(kernels),
        (
            to,
            None if ends is None else (ends[0], ends[1]),
            arguments.flag("border", border),
            arguments.word("objective", objective, "silicon"),
        ),
        (
            sum,
            on,
            arguments.number("effort", effort, "give seconds, such as effort=1"),
            arguments.whole("seed", seed),
        ),
    )
    return CompiledFilter(Program.from_text(text, chip=on), dict(results))


INPUT = "give the least and the most, in LSB, such as input=(0, 127)"


def _levels(to: Any, sum: Any) -> tuple[str, str]:
    """The few values that weights are brought to, and what they must sum to."""
    to, sum = arguments.word("to", to, "int-5"), arguments.word("sum", sum, "kept")
    if sum == "zero" and to in ("exact", "none"):
        raise Error(
            'sum="zero", and exact weights keep the sum that they have\n'
            'help: give a quantiser (to="int-5"), or leave sum out'
        )
    return to, sum


def _cautioned(chip: ChipSensor) -> ChipSensor:
    """Warns the caller of whoever found it."""
    for note in chip.notes:
        caution(note)
    return chip


def _zeros(
    what: str, shape: tuple[int, ...], dtype: npt.DTypeLike, help: str, beside: int = 0
) -> npt.NDArray[Any]:
    """An array of zeros that this machine's memory holds, with so many bytes beside it: numpy would
    ask for it only as it fills."""
    number = np.dtype(dtype)
    bytes = min(math.prod(shape) * number.itemsize, arguments.MOST)
    _amacrine.check_room(f"{what} of shape {shape}", bytes, min(beside, arguments.MOST), help)
    return np.zeros(shape, number)


def _windows(
    run: _amacrine.Run,
    shown: tuple[Iterable[npt.NDArray[Any]], float | None],
    how: _amacrine.Voxels,
    place: tuple[tuple[int, int], int],
    seconds: float,
) -> Iterator[npt.NDArray[np.float32]]:
    """The windows of a clip of so many seconds, each when it is over."""
    (parts, contrast), stream = shown, _amacrine.Stream(how, *place)
    for part in parts:
        yield from run.windows(part, contrast, stream)
    yield from stream.rest(arguments.to_micros(seconds))


def _all(count: int, watch: Callable[[int], T], halt: _amacrine.Halt) -> list[T]:
    """Every clip; several at a time, since a small one does not fill all threads."""
    if count == 1:
        return [watch(0)]

    def one(b: int) -> T:
        try:
            return watch(b)
        except Error as error:
            raise Error(f"clip {b}: {error}") from None

    with ThreadPoolExecutor(max_workers=max(1, min(count, _amacrine.threads()))) as pool:
        try:
            return list(pool.map(one, range(count)))
        except BaseException:
            # The threads of the pool hear of no signal, and the pool waits for them.
            halt.ask()
            raise


def _how(seed: Any, format: Any, max_events: Any) -> tuple[int, str, int | None]:
    """Seed, number format and limit, checked."""
    most = None if max_events is None else arguments.whole("max_events", max_events)
    return arguments.whole("seed", seed), arguments.word("format", format, "f32"), most


def _refractory(given: Any) -> Any:
    """A table; a number is microseconds."""
    if given is None or isinstance(given, (Mapping, str)) or arguments.axes(given) > 0:
        return given
    return {"us": arguments.number("refractory", given, "give microseconds, or a table")}


def _thresholds(given: Any, count: int, unit: str = UNIT) -> list[dict[str, Any]]:
    """A table for each kernel, in this unit. What is wrong is told of what was given, once for all kernels: a text
    that is made of it nobody has written."""
    given = untracked(given)
    if isinstance(given, Mapping) or (
        not isinstance(given, (list, tuple)) and arguments.axes(given) == 0
    ):
        return [_threshold("thresholds", given, unit)] * count
    all = list(given)
    if len(all) != count:
        raise Error(
            f"{len(all)} thresholds for {count} kernels\n"
            "help: give one threshold for all kernels, or one for each, in their order; a pair (on, "
            "off) is one of them: [(0.2, 0.3)]"
        )
    return [_threshold(f"thresholds[{i}]", one, unit) for i, one in enumerate(all)]


OF_TABLE = "give a table with on, off and, where there is mismatch, sigma"


def _threshold(name: str, given: Any, unit: str) -> dict[str, Any]:
    if isinstance(given, Mapping):
        return _of_table(name, given, unit)
    try:
        numbers = np.asarray(untracked(given)).ravel()
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.dtype.kind not in "uif" or numbers.size not in (1, 2):
        raise Error(
            f"{name} = {given!r} is no threshold\n"
            "help: give a number, a pair (on, off), or a table with on, off and sigma"
        )
    on, off = float(numbers[0]), float(numbers[-1])
    if not all(0.0 < one < math.inf for one in (on, off)):
        what = "a number" if numbers.size == 1 else "two numbers"
        raise Error(f"{name} = {_plain(numbers)}\nhelp: give {what} above 0, {unit}")
    return {"on": on, "off": off}


def _of_table(name: str, given: Mapping[str, Any], unit: str) -> dict[str, Any]:
    """A table with a threshold for each sign, and what they are spread by."""
    found = {str(key): value for key, value in given.items()}
    unknown = ", ".join(key for key in found if key not in ("on", "off", "sigma"))
    missing = ", ".join(key for key in ("on", "off") if key not in found)
    if unknown or missing:
        has = " and ".join(
            [f"has {unknown}"] * bool(unknown) + [f"lacks {missing}"] * bool(missing)
        )
        raise Error(f"{name} = {given!r} {has}\nhelp: {OF_TABLE}")
    for key, value in found.items():
        is_spread = key == "sigma"
        least = "of 0 or more" if is_spread else "above 0"
        help = f"give a number {least}, {unit}"
        if isinstance(value, (bool, np.bool_)):
            raise Error(f'{name}["{key}"] = {value} is no number\nhelp: {help}')
        number = arguments.number(f'{name}["{key}"]', value, help)
        if not (0.0 < number < math.inf or is_spread and number == 0.0):
            raise Error(f'{name}["{key}"] = {number:g}\nhelp: {help}')
        found[key] = number
    return found


def _plain(numbers: npt.NDArray[Any]) -> str:
    """A threshold as it was given, without the names of types."""
    each = [f"{one:g}" for one in numbers.tolist()]
    return each[0] if len(each) == 1 else f"({', '.join(each)})"


def _domain(domain: str) -> str:
    """What the cells of an array hold, which must be known."""
    domain = arguments.word("domain", domain, "exact")
    _amacrine.check_domain(domain)
    return domain


def stacked(kernels: list[npt.NDArray[np.float64]]) -> npt.NDArray[np.float64]:
    """Kernels of several sizes as one array: each has its middle in the middle."""
    height = max(kernel.shape[0] for kernel in kernels)
    width = max(kernel.shape[1] for kernel in kernels)

    def padded(kernel: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        rows, columns = (height - kernel.shape[0]) // 2, (width - kernel.shape[1]) // 2
        return np.pad(kernel, ((rows, rows), (columns, columns)))

    return np.stack([padded(kernel) for kernel in kernels])
