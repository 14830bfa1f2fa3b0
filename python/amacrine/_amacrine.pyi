"""The Rust half of the package; `tests/test_types.py` holds this page to it."""

from collections.abc import Callable
from os import PathLike
from typing import Any, TypedDict, TypeVar, final

import numpy as np
import numpy.typing as npt

_T = TypeVar("_T")

_Path = str | PathLike[str]
_Named = tuple[str, bytes | None]
_Search = tuple[str, str, float, int]
_OfKind = tuple[
    list[npt.NDArray[np.float64]], list[float], list[float], list[float], tuple[float, float]
]
_Readout = tuple[str, str | None, list[tuple[str, str]]]
_Lost = tuple[int, int, int, int, int]
_OfArray = tuple[int | None, list[str], _Lost | None]
_Side = tuple[_Path, Events | None, tuple[int, int] | None, _OfArray]
_Shown = tuple[str | None, npt.NDArray[Any] | None, float | None, float | None]
_Waterfall = TypedDict(
    "_Waterfall",
    {
        "kernels": list[_Named],
        "thresholds": list[float],
        "to": str,
        "domain": str,
        "memory": str | None,
        "sets": list[tuple[str, float]],
        "readout": _Readout | None,
        "within_us": int | None,
        "rates": list[float],
        "chips": int,
        "tiles": int | None,
        "steps": bool,
    },
)
_OnChip = TypedDict(
    "_OnChip",
    {
        "kernels": list[_Named],
        "thresholds": list[float],
        "to": list[str],
        "memory": str | None,
        "within_us": int | None,
    },
)
_Trade = TypedDict(
    "_Trade",
    {
        "upsample": float | None,
        "formats": list[str] | None,
        "within_us": int,
        "sample": float,
        "runs": int,
        "verify": bool,
        "seed": int,
        "called": str,
        "scale": str,
    },
)

__version__: str
ASSUMED_FPS: float
"""Frames per second where nobody says it."""
MEMORIES: tuple[str, ...]
"""What an event may do to the memory of a sensor that is made of arguments."""
RANGES: tuple[str, ...]
TRANSFERS: tuple[str, ...]
"""What the samples of a clip may be taken for."""
CANDIDATES: tuple[str, ...]
"""Quantisers that a design and a report try."""
CHIP: str
DOMAIN: str
TO: str
EFFORT: float
"""The chip, the arithmetic of its cells, the values of a kernel, and how long to search, in seconds,
where nobody says it."""
FEASIBILITY_CHIPS: int
LINK_PJ: tuple[float, float]
"""Chips that a report draws, and the energy of a bit on its link."""
WATERFALL_CHIPS: int
SAMPLE: float
TRADE_WITHIN: float
RUNS: int
"""What a trade runs of the sensor, the time in seconds within which an event is the same, and how many
runs share what it took."""

class Error(ValueError):
    """What is wrong, in the words of the command line: what was given, what was expected, and
    what to do."""

class NotFinite(Error):
    """A gradient that goes back, or a sum of it, is NaN or infinite."""

def set_threads(threads: int) -> None:
    """Sets the number of threads from now on; 0 for as many as there are cores."""

def threads() -> int:
    """The number of threads."""

def names(of: str) -> list[str]: ...
def meant(of: str, name: str, otherwise: str) -> str: ...
def is_sensor(text: str) -> bool: ...
def text(of: str, name: str) -> tuple[str, str] | None: ...
@final
class Sensor:
    def __new__(
        cls, file: str, text: str, arrays: dict[str, bytes], folder: _Path | None
    ) -> Sensor: ...
    @property
    def name(self) -> str: ...
    @property
    def channels(self) -> list[str | None]: ...
    @property
    def kernels(self) -> list[list[npt.NDArray[np.float64]] | None]: ...
    @property
    def thresholds(self) -> list[list[tuple[float, float, float]]]: ...
    @property
    def plain(self) -> bool: ...
    def studied(
        self, called: str
    ) -> tuple[
        list[str], list[npt.NDArray[np.float64]], list[float], str | None, list[str]
    ]: ...
    def watch(
        self,
        size: tuple[int, int],
        fps: float,
        scale: float,
        seed: int,
        format: str,
        max_events: int | None,
    ) -> Run: ...
    def warning_of_light(self, subject: str, low: float, high: float) -> str | None: ...
    def without(self, effects: list[str]) -> str: ...
    def changed(
        self,
        kernels: tuple[list[_Named], str] | None,
        threshold: tuple[float, float] | None,
        sigma: float | None,
    ) -> str: ...
    def for_rate(
        self, frames: npt.NDArray[Any], fps: float, scale: float, rate: float, seed: int
    ) -> str: ...
    def on_chip(
        self,
        to: str,
        sum: str,
        memory: str | None,
        chip: str,
        aim: tuple[str, bool],
        events: int | None,
        effort: float,
        seed: int,
    ) -> Chip: ...

@final
class Chip:
    def __new__(
        cls,
        title: str,
        text: str,
        chip: str,
        scale: float,
        levels: list[tuple[npt.NDArray[np.float64], float]],
        notes: list[str],
    ) -> Chip: ...
    @property
    def text(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def chip(self) -> str: ...
    @property
    def words(self) -> int: ...
    @property
    def array_us(self) -> float: ...
    @property
    def lsb(self) -> float: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def levels(self) -> list[tuple[npt.NDArray[np.float64], float]]: ...
    def watch(
        self,
        size: tuple[int, int],
        fps: float,
        scale: float,
        seed: int,
        domain: str,
        slots: bool,
        max_events: int | None,
    ) -> Run: ...

@final
class Run:
    def events(
        self, frames: npt.NDArray[Any], contrast: float | None, readout: _Readout | None
    ) -> npt.NDArray[np.uint8]: ...
    def counts(
        self, frames: npt.NDArray[Any], contrast: float | None, out: npt.NDArray[np.int32]
    ) -> None: ...
    def voxels(self, frames: npt.NDArray[Any], out: npt.NDArray[np.float32]) -> None: ...
    def windows(
        self, frames: npt.NDArray[Any], contrast: float | None, stream: Stream
    ) -> list[npt.NDArray[np.float32]]: ...
    @property
    def seen(self) -> int: ...
    @property
    def dropped(self) -> dict[str, int]: ...
    def warnings(self, subject: str) -> list[tuple[str, str]]: ...
    def heed(self, halt: Halt) -> None: ...

@final
class Halt:
    def __new__(cls) -> Halt: ...
    def ask(self) -> None: ...

@final
class Turn:
    def __new__(cls) -> Turn: ...
    def take(self, what: Callable[[], _T]) -> _T: ...

@final
class Program:
    def __new__(
        cls,
        file: str,
        text: str,
        folder: _Path | None,
        chip: str | None,
        constants: dict[str, float],
    ) -> Program: ...
    @property
    def text(self) -> str: ...
    @property
    def file(self) -> str: ...
    @property
    def chip(self) -> str: ...
    @property
    def chip_folder(self) -> str | None: ...
    @property
    def words(self) -> tuple[int, int]: ...
    @property
    def micros(self) -> tuple[float, float]: ...
    @property
    def warnings(self) -> str | None: ...
    @property
    def decides(self) -> bool: ...
    @property
    def fps(self) -> float | None: ...
    def run(
        self,
        frames: npt.NDArray[Any],
        fps: float,
        scale: float,
        cells: dict[str, Any],
        keep: list[str],
        set: list[tuple[str, npt.NDArray[np.float64]]],
    ) -> tuple[
        npt.NDArray[np.uint8],
        tuple[int, int],
        dict[str, int],
        dict[str, npt.NDArray[Any]],
        dict[str, npt.NDArray[Any]],
        list[tuple[int, str]],
        list[str],
    ]: ...

@final
class Events:
    @staticmethod
    def of(
        records: npt.NDArray[np.uint8], has_channels: bool, signed: bool
    ) -> Events | None: ...
    @property
    def backwards(self) -> int | None: ...
    @property
    def count(self) -> int: ...
    @property
    def latest(self) -> int: ...
    @property
    def reach(self) -> tuple[int, int]: ...

@final
class Voxels:
    def __new__(
        cls,
        bins: int,
        length: float,
        every: float,
        alignment: str,
        share: str,
        polarity: str,
        normalise: str,
    ) -> Voxels: ...
    def count(self, end: int) -> int: ...
    def held(self, size: tuple[int, int], channels: int, windows: int, part: float) -> int: ...
    def bounds(self, n: int) -> tuple[int, int]: ...
    def shape(
        self, size: tuple[int, int], channels: int
    ) -> tuple[int, int, int, int, int]: ...

@final
class Stream:
    def __new__(cls, how: Voxels, size: tuple[int, int], channels: int) -> Stream: ...
    def rest(self, end: int) -> list[npt.NDArray[np.float32]]: ...

@final
class Seen:
    @property
    def voxels(self) -> npt.NDArray[Any]: ...
    @property
    def counts(self) -> npt.NDArray[np.int32]: ...
    @property
    def shape(self) -> tuple[int, int, int, int, int]: ...
    @property
    def events(self) -> int: ...
    def backward(
        self,
        voxels: npt.NDArray[Any] | None,
        counts: npt.NDArray[Any] | None,
        events: float,
        rule: str | None,
        slope: str,
        light: bool,
    ) -> tuple[list[_OfKind], npt.NDArray[Any] | None]: ...

def forward(
    sensor: Sensor,
    parameters: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]] | None,
    light: npt.NDArray[Any],
    times: list[float],
    seed: int,
    phase: float | None,
) -> Seen: ...
def learned_text(
    sensor: Sensor,
    parameters: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]],
    name: str | None,
) -> str: ...
def check_room(what: str, bytes: int, beside: int, help: str) -> None: ...
def voxels(
    events: Events,
    since: int,
    size: tuple[int, int] | None,
    channels: int,
    how: Voxels,
    end: int | None,
    other: int,
) -> tuple[npt.NDArray[np.float32], tuple[int, int, int]]: ...
def surfaces(
    events: Events,
    size: tuple[int, int] | None,
    channels: int,
    times: list[int],
    tau: float,
    decay: str,
    polarity: str,
) -> tuple[npt.NDArray[np.float32], tuple[int, int, int]]: ...
def event_frames(
    events: Events,
    size: tuple[int, int] | None,
    channels: int,
    each: int,
    polarity: str,
    fill: str,
) -> tuple[npt.NDArray[np.int32], tuple[int, int, int]]: ...
def register_picture(values: npt.NDArray[np.float64], low: float, high: float) -> bytes: ...
def event_picture(
    events: Events,
    size: tuple[int, int],
    channels: int,
    span: tuple[int, int] | None,
    title: str,
) -> bytes: ...
def uniform(seed: int, words: list[int]) -> float: ...
def sweep(
    study: tuple[str, str, _Path],
    sets: list[str],
    output: _Path,
    shard: str | None,
    jobs: int,
    max_seconds: float | None,
) -> str: ...
def check_domain(domain: str) -> None: ...
def sweep_hash(study: tuple[str, str, _Path], sets: list[str]) -> str: ...
def merge(folders: list[_Path], output: _Path) -> str: ...
def sweep_rows(folder: _Path) -> str: ...
def read(
    path: _Path, kind: str | None, of: tuple[int, int] | None, stream: int | None
) -> tuple[npt.NDArray[np.uint8], int, str]: ...
def write(
    path: _Path,
    events: Events,
    of: tuple[int, int] | None,
    channels: int | None,
    names: list[str],
    span_us: tuple[int, int] | None,
    lost: _Lost | None,
    to: str | None,
    compression: str,
) -> None: ...
def save(path: _Path, text: str) -> None: ...
def compare(
    a: _Side,
    b: _Side,
    within_us: int | None,
    fps: float | None,
    bins: int,
    seed: int,
    by: tuple[Sensor, str, tuple[str, int], _Shown, float | None] | None,
) -> str: ...
def scene(
    name: str | None,
    fps: float | None,
    scale: float | None,
    frames: int | None,
    coded: tuple[str, str],
    part: tuple[str | None, str | None, str | None],
) -> tuple[npt.NDArray[Any], float, bool, list[str]]: ...
def in_python(text: str) -> str: ...
def compile_filter(
    of: list[_Named],
    how: tuple[str, tuple[float, float] | None, bool, str],
    search: _Search,
) -> tuple[str, list[tuple[str, float]]]: ...
def quantise(of: list[_Named], to: list[str], sum_to: str, seed: int | None) -> str: ...
def on_chip(asked: _OnChip, search: _Search, scene: _Shown) -> str: ...
def design(
    of: list[_Named],
    rate: float | None,
    thresholds: list[float],
    how: tuple[list[str], str | None],
    search: _Search,
    scene: _Shown,
    within_us: int | None,
) -> str: ...
def feasibility(
    of: list[_Named],
    aim: tuple[float | None, list[float]],
    levels: tuple[str | None, list[str], str | None],
    search: _Search,
    scene: _Shown,
    times: tuple[int | None, int | None],
    link: tuple[tuple[float, float], bool],
    chips: int,
) -> tuple[str, str]: ...
def waterfall(
    asked: _Waterfall, search: _Search, scene: _Shown
) -> list[tuple[str, str]]: ...
def trade_program(
    program: Program, domain: str, scene: _Shown, asked: _Trade
) -> tuple[str, str]: ...
def trade(sensor: Sensor, scene: _Shown, asked: _Trade) -> tuple[str, str]: ...
