"""Voxels made on the fly of a folder of videos, by sensors that are drawn."""

from __future__ import annotations

import inspect
import math
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt
import torch

from .. import _amacrine, arguments
from .._amacrine import Error
from ..caution import Place, collected
from ..frames import load
from ..kernels import Kernels
from ..sensor import EventSensor, Sensor

VIDEOS = (".mp4", ".y4m", ".gif", ".apng", ".npy")
"""Endings of the files of a folder that are videos; a folder in it is one of pictures."""


VOXELS = {*inspect.signature(EventSensor.voxels).parameters} - {"self", "frames", "fps", "scale"}
"""What :meth:`amacrine.Sensor.voxels` can be told of the voxels of an item."""


class Item(TypedDict):
    """What a data set gives for an index."""

    voxels: torch.Tensor
    """(windows,K,bins,H,W), (windows,K,2,bins,H,W) where they are split, or (T,K,H,W) without
    ``bins``; in events."""
    frames: torch.Tensor
    """Light from 0 to 255 that the sensor watched, (T,1,H,W), ``uint8`` or ``float32``."""
    video: int
    """Which of :attr:`EventDataset.videos`."""
    start: int
    """The first frame in the video."""
    sensor: int
    """Which of the sensors that were drawn: :meth:`EventDataset.sensor`."""
    fps: float
    """Frames per second."""


# What a number is drawn for.
_VIDEO, _START, _ROW, _COLUMN, _FLIP, _SENSOR, _SEED = range(7)
_KERNELS, _THRESHOLD, _QUANTISER, _CHIP = range(16, 20)


class EventDataset(torch.utils.data.Dataset[Item]):
    """Voxels on the fly: each item is some frames of a video, watched by a sensor that is drawn.

    All that is drawn is a hash of (seed, epoch, index): an item is the same on any number of workers,
    whatever was asked for before.

    Args:
        folder: A folder of videos (.mp4, .y4m, .gif, .apng, .npy, or folders of pictures), or a list of
            them; or names that :func:`amacrine.load` takes, in a list.
        frames: Frames of an item.
        crop: Height and width of a part that is drawn; whole frames where it is left out.
        flips: Mirrors items, left to right and top to bottom, half of them each.
        kernels: What sensors are drawn from: a list of kernels as :class:`amacrine.Sensor` takes them, of
            as many kinds each.
        thresholds: The range that thresholds are drawn from, even in the logarithm.
        mismatch: Deviation of a float sensor's thresholds from cell to cell, as a share of them; a chip
            has its own.
        quantisers: What is drawn: ``None`` is the float sensor, a quantiser such as ``"int-5"`` the
            sensor as a program of a chip.
        chips: What is drawn for a quantiser: chips by name, or folders.
        domain: What the cells of the array hold, as in :meth:`amacrine.Sensor.on_chip`.
        sensors: How many sensors are drawn. A program is compiled once for each, in each worker.
        options: Of :class:`amacrine.Sensor`: ``response``, ``memory``, ``noise``, …; by default what a
            chip can follow (``filtered-snap``, border ``zero``).
        voxels: Of :meth:`amacrine.Sensor.voxels`: ``bins``, ``window``, ``polarity``, ``normalise``, ….
            With a ``window`` the videos must have one rate, or ``fps`` be given, for items to be as many
            windows each; a :class:`amacrine.Caution` says where they are not.
        fps: Frames per second, instead of what the videos say.
        scale: What the numbers of .npy videos are multiplied by to be light from 0 to 255: 255 where
            they are 0 to 1.
        length: Items of an epoch; as many as there are videos where it is left out.
        seed: Chooses everything. The seed of a sensor's mismatch and noise is drawn for each item.
        cache: Bytes of videos that each worker keeps.
        transform: Is given each :class:`Item`.

    With a ``DataLoader`` call :meth:`set_epoch` before each epoch (and leave
    ``persistent_workers`` off), else all epochs are the same.
    """

    def __init__(
        self,
        folder: str | Path | Sequence[str | Path],
        *,
        frames: int = 16,
        crop: tuple[int, int] | None = None,
        flips: bool = True,
        kernels: Sequence[Kernels] = ("csdvs-5",),
        thresholds: tuple[float, float] = (0.1, 0.4),
        mismatch: float = 0.0,
        quantisers: Sequence[str | None] = (None,),
        chips: Sequence[str] = ("scamp5",),
        domain: str = "silicon",
        sensors: int = 16,
        options: Mapping[str, Any] | None = None,
        voxels: Mapping[str, Any] | None = None,
        fps: float | None = None,
        scale: float | None = None,
        length: int | None = None,
        seed: int = 0,
        cache: int = 1 << 30,
        transform: Callable[[Item], Any] | None = None,
    ) -> None:
        self._place = Place()
        self.videos = _videos(folder)
        help = "give a range above 0, low to high, such as thresholds=(0.1, 0.4)"
        ends = arguments.numbers("thresholds", thresholds, help)
        if len(ends) != 2 or not 0.0 < ends[0] <= ends[1] < math.inf:
            raise Error(f"thresholds = {thresholds!r}\nhelp: {help}")
        for name, list in {"kernels": kernels, "quantisers": quantisers, "chips": chips}.items():
            if hasattr(list, "shape"):
                # An array of kernels are the kinds of one sensor elsewhere.
                raise Error(f"{name} to draw from are an array\nhelp: give a list: {name}=[array]")
            if isinstance(list, str) or len(list) == 0:
                raise Error(f"{name} to draw from are no list\nhelp: give a list of one or more")
        self._mismatch = arguments.share("mismatch", mismatch)
        self._frames = arguments.whole("frames", frames, 2)
        self._flips = arguments.flag("flips", flips)
        self._crop = arguments.size(crop, "crop")
        self._kernels, self._range = [*kernels], (ends[0], ends[1])
        self._quantisers, self._chips, self._domain = [*quantisers], [*chips], domain
        self._sensors = arguments.whole("sensors", sensors, 1)
        self._options = {"memory": "filtered-snap", "border": "zero", **(options or {})}
        self._voxels = dict(voxels or {})
        self._fps = None if fps is None else arguments.rate(fps)
        self._scale = None if scale is None else arguments.scale(scale)
        odd = sorted(set(self._voxels) - VOXELS)
        if odd:
            raise Error(
                f"voxels: there is no {odd[0]}\nhelp: give {', '.join(sorted(VOXELS))}"
            )
        self._seed = arguments.whole("seed", seed)
        self._check()
        self._length = None if length is None else arguments.whole("length", length, 1)
        self._most = arguments.whole("cache", cache)
        self._transform, self._epoch = transform, 0
        self._forget()
        self._check_chips()
        self._check_windows()

    def _check(self) -> None:
        """Tells what no sensor takes here, not in a worker."""
        if "seed" in self._options:
            raise Error(
                "options: the seed of a sensor is drawn for each item\nhelp: give seed=… of the data set"
            )
        sensors = [Sensor(of, self._range[0], **self._options) for of in self._kernels]
        if len({len(sensor.channels) for sensor in sensors}) > 1:
            told = ", ".join(str(len(sensor.channels)) for sensor in sensors)
            raise Error(
                f"kernels to draw from have {told} kinds of cells\nhelp: give as many kinds each"
            )
        for to in self._quantisers:
            if to is not None:
                _amacrine.quantise([("dvs", None)], [arguments.word("quantisers", to, "int-5")], "kept", None)
        for chip in self._chips:
            if chip not in _amacrine.names("chips") and not Path(chip).is_dir():
                names = ", ".join(_amacrine.names("chips"))
                raise Error(f"chips: there is no chip {chip}\nhelp: give {names}, or a folder")
        if self._crop is not None and 0 in self._crop:
            raise Error(f"crop = {self._crop}\nhelp: give a height and a width above 0")
        self._any = sensors[0]
        self._try(sensors[0], self._fps or 30.0)

    def _try(self, sensor: EventSensor, rate: float) -> int:
        """Tells which voxels it does not make; else of how many windows they are."""
        still = np.zeros((self._frames, 16, 16), np.uint8)
        with collected():
            return len(sensor.voxels(still, rate, **self._voxels))

    def _check_windows(self) -> None:
        """Tells of videos whose items no batch holds together: as many frames at another rate are
        another number of windows."""
        if self._fps is not None or not {"window", "every"} & set(self._voxels):
            return
        rates: dict[float, str] = {}
        for video in self.videos:
            # Cautions are told where its items are asked for.
            with collected():
                _, rate = load(video, frames=2, scale=self._scale)
            rates.setdefault(rate, video)
        first: dict[int, float] = {}
        for rate in rates:
            first.setdefault(self._try(self._any, rate), rate)
        if len(first) > 1:
            (count, rate), *others = first.items()
            told = [f"{rates[rate]} has {count} windows ({rate:g} frames per second)"]
            told += [f"{rates[rate]} has {count} ({rate:g})" for count, rate in others]
            self._place.caution(
                f"{self._frames} frames are not as many windows in all videos: {', '.join(told)}; "
                "a batch holds items of one shape: give fps=…, which all have then, leave window out, "
                "or give the DataLoader a collate_fn that takes lists"
            )

    def _check_chips(self) -> None:
        """Compiles the first sensor of each kernel, quantiser and chip that are drawn: tells here what
        no chip takes, and once what a chip leaves out of the sensor."""
        tried, told = set(), set()
        for number in range(self._sensors):
            kernels, to, chip = self._drawn(number)
            if to is None or (kernels, to, chip) in tried:
                continue
            tried.add((kernels, to, chip))
            with collected() as texts:
                self._made[number] = self._make(number)
            if len(tried) == 1:
                self._try(self._made[number], self._fps or 30.0)
            for text in texts:
                if text not in told:
                    told.add(text)
                    self._place.caution(text)

    def __repr__(self) -> str:
        return (
            f"<EventDataset: {len(self)} items of {len(self.videos)} videos, {self._frames} frames "
            f"each, {self._sensors} sensors>"
        )

    def _forget(self) -> None:
        self._clips: OrderedDict[int, tuple[npt.NDArray[Any], float]] = OrderedDict()
        self._made: dict[int, EventSensor] = {}

    def __getstate__(self) -> dict[str, Any]:
        # A worker reads its own; programs that were found already go with it.
        return {**self.__dict__, "_clips": OrderedDict()}

    def __len__(self) -> int:
        return len(self.videos) if self._length is None else self._length

    def set_epoch(self, epoch: int) -> None:
        """Draws other items from now on."""
        self._epoch = arguments.whole("epoch", epoch)

    def _draw(self, what: int, index: int) -> float:
        """From 0 to 1."""
        return _amacrine.uniform(self._seed, [what, self._epoch, index])

    def sensor(self, number: int) -> EventSensor:
        """A sensor that was drawn, from 0: a :class:`amacrine.Sensor`, or its program on a chip."""
        if not 0 <= number < self._sensors:
            raise Error(f"there is no sensor {number}\nhelp: give 0 to {self._sensors - 1}")
        if number not in self._made:
            # Cautions are in its notes, and were told of the first sensor that is made so.
            with collected():
                self._made[number] = self._make(number)
        return self._made[number]

    def _drawn(self, number: int) -> tuple[int, str | None, str]:
        """Which kernels, which quantiser and which chip a sensor has."""

        def one(what: int, of: int) -> int:
            return int(_amacrine.uniform(self._seed, [what, number]) * of)

        to = self._quantisers[one(_QUANTISER, len(self._quantisers))]
        chip = self._chips[one(_CHIP, len(self._chips))]
        return one(_KERNELS, len(self._kernels)), to, chip

    def _make(self, number: int) -> EventSensor:
        kernels, to, chip = self._drawn(number)
        low, high = self._range
        part = _amacrine.uniform(self._seed, [_THRESHOLD, number])
        threshold = low * (high / low) ** part
        sigma = self._mismatch * threshold if to is None else 0.0
        limits = {"on": threshold, "off": threshold, "sigma": sigma}
        sensor = Sensor(self._kernels[kernels], limits, **self._options)
        if to is None:
            return sensor
        return sensor.on_chip(to, domain=self._domain, chip=chip, effort=0.2)

    def _clip(self, video: int) -> tuple[npt.NDArray[Any], float]:
        """Light (T,H,W) of a whole video, and its frames per second."""
        kept = self._clips.get(video)
        if kept is not None:
            # Another thread may have dropped it meanwhile. There is no lock: a fork would keep it locked.
            with suppress(KeyError):
                self._clips.move_to_end(video)
            return kept
        with collected() as cautions:
            clip, fps = load(self.videos[video], fps=self._fps, scale=self._scale)
        if clip.dtype != np.uint8:
            clip = clip.astype(np.float32)
        if clip.size > 0 and (clip.dtype != np.uint8 or self._scale is not None):
            low, high = float(clip.min()), float(clip.max())
            of_light = self._any._native.warning_of_light(self.videos[video], low, high)
            cautions += [] if of_light is None else [of_light]
        for text in cautions:
            self._place.caution(text)
        self._clips[video] = clip, fps
        while sum(other.nbytes for other, _ in [*self._clips.values()]) > self._most:
            if len(self._clips) <= 1:
                break
            with suppress(KeyError):
                self._clips.popitem(last=False)
        return clip, fps

    def __getitem__(self, index: int) -> Item:
        if not -len(self) <= index < len(self):
            raise IndexError(index)
        index %= len(self)
        # In order where each comes once, else drawn.
        video = index
        if self._length is not None:
            video = int(self._draw(_VIDEO, index) * len(self.videos))
        clip, fps = self._clip(video)
        count, height, width = clip.shape
        crop = self._crop or (height, width)
        if count < self._frames or height < crop[0] or width < crop[1]:
            raise Error(
                f"{self.videos[video]}: {count} frames of {width}x{height} pixels, where "
                f"{self._frames} of {crop[1]}x{crop[0]} are asked for\n"
                "help: leave it out, or ask for fewer frames or a smaller part"
            )

        def at(what: int, room: int) -> int:
            return int(self._draw(what, index) * (room + 1))

        start = at(_START, count - self._frames)
        y, x = at(_ROW, height - crop[0]), at(_COLUMN, width - crop[1])
        part = clip[start : start + self._frames, y : y + crop[0], x : x + crop[1]]
        if self._flips:
            way = at(_FLIP, 3)
            part = part[:, :: -1 if way & 1 else 1, :: -1 if way & 2 else 1]
        part = np.ascontiguousarray(part)
        number = at(_SENSOR, self._sensors - 1)
        seed = int(self._draw(_SEED, index) * (1 << 53))
        scale = None if part.dtype == np.uint8 else 1.0
        sensor = self.sensor(number)._reseeded(seed)
        # A part of a video in which nothing moves is no mistake.
        with collected():
            try:
                voxels = sensor.voxels(part, fps, scale=scale, **self._voxels)
            except Error as cause:
                raise Error(f"{self.videos[video]}, from frame {start}, y {y} and x {x} on: {cause}") from None
        item = Item(
            voxels=torch.from_numpy(voxels),
            frames=torch.from_numpy(part)[:, None],
            video=video,
            start=start,
            sensor=number,
            fps=fps,
        )
        return item if self._transform is None else self._transform(item)


def _videos(folder: str | Path | Sequence[str | Path]) -> list[str]:
    """Videos in the order of their names."""
    if not isinstance(folder, (str, Path)):
        videos = [str(video) for video in folder]
        if not videos:
            raise Error("a list without videos\nhelp: give a folder, or paths")
        return videos
    path = Path(folder)
    if not path.is_dir():
        raise Error(f"{path}: no such folder\nhelp: give a folder of videos, or a list of paths")
    seen = [p for p in path.iterdir() if not p.name.startswith(".")]
    found = sorted(p for p in seen if p.suffix.lower() in VIDEOS or p.is_dir())
    if not found:
        raise Error(f"{path}: no videos\nhelp: give a folder of {', '.join(VIDEOS)}, or of folders")
    return [str(video) for video in found]
