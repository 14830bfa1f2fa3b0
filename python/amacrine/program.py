"""Programs of the array."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _amacrine, arguments, notebook
from ._amacrine import Error
from .caution import caution
from .events import NamedEvents, check_side, named, picture, view
from .frames import caution_of_rate, clips
from .names import chip as found_chip, opened


@dataclass(frozen=True, eq=False)
class ProgramRun:
    """What a program gave. In a notebook it shows its registers as tables and small pictures, and its
    busiest moment."""

    events: NamedEvents
    """What it read out, as :attr:`amacrine.EVENT`; all at the times of frames."""
    registers: dict[str, npt.NDArray[Any]]
    """After the last frame, by name, (H,W): analogue registers as ``float64``, in LSB, registers of
    one bit and ``FLAG`` as ``bool``."""
    films: dict[str, npt.NDArray[Any]]
    """The registers that were asked for after every frame, (T,H,W)."""
    lost: int
    """Events that found no slot of the readout, or lie in rows that it does not scan."""
    posts: list[tuple[int, str]]
    """What the host wrote (``vs_post_text``, ``printf``), with the frame, counted from 0: of programs
    whose host decides."""

    def __repr__(self) -> str:
        return f"<ProgramRun: {len(self.events)} events, {self.lost} lost>"

    def _repr_html_(self) -> str:
        head = notebook.table([{"events": len(self.events), "lost": self.lost}])
        registers = [
            {"register": name, "least": values.min(), "mean": values.mean(), "most": values.max()}
            for name, values in self.registers.items()
            if values.size
        ]
        posts = [{"frame": frame, "what the host wrote": text} for frame, text in self.posts]
        written = notebook.table(posts) if posts else ""
        drawn = picture(self.events) + notebook.registers(self.registers)
        return head + notebook.table(registers) + written + drawn


class Program:
    """A program of the array, checked and expanded on its chip."""

    def __init__(
        self, given: tuple[str, str, Path | None], chip: str | None, constants: dict[str, float]
    ) -> None:
        self._native = native = _amacrine.Program(*given, chip, constants)
        # A chip that the text names is to be found from another folder, too.
        self._given = given, native.chip_folder or chip, constants
        if native.warnings is not None:
            caution(native.warnings, UserWarning)

    def __reduce__(self) -> tuple[Any, ...]:
        return Program, self._given

    @classmethod
    def from_file(
        cls,
        path: str | Path,
        *,
        chip: str | Path | None = None,
        constants: Mapping[str, float] | None = None,
    ) -> Program:
        """A program (.scamp, or C++ for the vendor's tools), or one that comes with the package by
        name, such as ``"dvs/snap"``.

        Args:
            path: Path or name.
            chip: A shipped chip by name, or the folder of another; else what the program says.
            constants: Values of constants of the program.
        """
        return cls(opened("programs", path), _chip(chip), _constants(constants))

    @classmethod
    def from_text(
        cls,
        text: str,
        *,
        chip: str | Path | None = None,
        constants: Mapping[str, float] | None = None,
    ) -> Program:
        """The text of a program."""
        text = arguments.word("text", text, "mov(A, B);")
        return cls(("program.scamp", text, None), _chip(chip), _constants(constants))

    @property
    def text(self) -> str:
        """Its text."""
        return self._native.text

    @property
    def decides(self) -> bool:
        """Whether its host decides in the run what the array does, by what it reads or by how many
        frames have passed: C++ for the vendor's tools only. Its words are not known before."""
        return self._native.decides

    @property
    def words(self) -> int:
        """Instruction words of a frame; 0 where the host decides."""
        return self._native.words[1]

    @property
    def array_us(self) -> float:
        """Microseconds of a frame on the array, without what the host does; 0 where that decides."""
        return self._native.micros[0]

    @property
    def chip(self) -> str:
        """The name of its chip."""
        return self._native.chip

    def run(
        self,
        frames: Any,
        fps: float | None = None,
        *,
        scale: float | None = None,
        domain: str | None = None,
        clip: bool | None = None,
        seed: int = 0,
        without: str | Sequence[str] = (),
        edge: float | None = None,
        gain: float | None = None,
        keep: str | Sequence[str] = (),
        registers: Mapping[str, npt.ArrayLike] | None = None,
    ) -> ProgramRun:
        """Shows it frames: the first runs ``init``, every later one ``frame``.

        Args:
            frames: Light, (T,H,W) or (T,1,H,W); the array has their size.
            fps: Frames per second; else what the program says. Where neither says it, 240 are assumed,
                as on the command line, and a :class:`Caution` says so.
            scale: What floats are multiplied by to be light from 0 to 255.
            domain: What cells hold: ``exact``, ``silicon``, ``f16``, ``q8.8``, …; else what the
                program says, or ``exact``.
            clip: Whether every store is limited to the range of a register; else what the program
                says, or not.
            seed: Which chip and which noise, in ``silicon``; taken and not used in the other domains,
                whose cells do not err, so that one call serves all.
            without: Errors of analogue cells to leave out: ``"converter"``, ``"saturation"``,
                ``"transfer"``, ``"mismatch"``, ``"noise"``, ``"decay"``.
            edge: What registers off the array hold, in LSB; else what the program says, or 0.
            gain: LSB by which PIX rises for one unit of light; else what the chip says.
            keep: Registers to be looked at after every frame, such as ``("A", "R5")``.
            registers: What registers hold before the first frame, (H,W) each or one number: analogue
                ones in LSB, those of one bit 0 or 1.
        """
        given, seed = clips(frames, scale), arguments.whole("seed", seed)
        if given.batched:
            raise Error("several clips\nhelp: give an array of shape (T,H,W)")
        check_side(given.size)
        said = self._native.fps if fps is None else fps
        rate = arguments.rate(_amacrine.ASSUMED_FPS if said is None else said)
        found = self._native.run(
            given.clip(0),
            rate,
            given.scale,
            {
                "domain": arguments.word_or_none("domain", domain, "silicon"),
                "clip": None if clip is None else arguments.flag("clip", clip),
                "seed": seed,
                "without": arguments.names("without", without),
                "edge": _finite("edge", edge),
                "gain": _finite("gain", gain),
            },
            arguments.names("keep", keep),
            _registers(registers, given.size),
        )
        records, (channels, shown), dropped, registers, films, posts, warned = found
        # One frame has no rate.
        if said is None and given.frames > 1:
            caution_of_rate(self._native.file, rate)
        for text in warned:
            caution(text)
        # Its host may end before the light does.
        seconds = max(shown - 1, 0) / rate
        read = view(records, channels)
        events = named(read, None, given.size, channels, (0.0, seconds), dropped)
        return ProgramRun(events, registers, films, sum(dropped.values()), posts)

    def __repr__(self) -> str:
        if self.decides:
            return f"<Program {self._native.file}: its host decides the words>"
        return f"<Program {self._native.file}: {self.words} words, {self.array_us:.1f} us>"

    def _repr_html_(self) -> str:
        row: dict[str, Any] = {"program": self._native.file, "chip": self.chip}
        if self.decides:
            row["words"] = "its host decides"
        else:
            row |= {"words": self.words, "us on the array": self.array_us}
        if self._native.fps is not None:
            row["frames/s"] = self._native.fps
        return notebook.table([row]) + notebook.text("its text", self.text)


def _registers(given: Any, size: tuple[int, int]) -> list[tuple[str, npt.NDArray[np.float64]]]:
    """What registers are set to, by name."""
    such_as = '{"A": array}'
    all = arguments.table("registers", given, such_as).items()
    return [(name, _plane(f"registers: {name}", values, size)) for name, values in all]


def _plane(name: str, given: Any, size: tuple[int, int]) -> npt.NDArray[np.float64]:
    """What a register holds: one number everywhere, or one for each pixel. What numpy would stretch to
    the size of the frames is taken for a mistake."""
    help = f"give one number, or an array (H,W) of the frames, {size}, of real numbers"
    arguments.unmasked(name, given)
    array = arguments.real(name, given, help)
    if array.ndim not in (0, 2):
        shape = list(array.shape)
        raise Error(f"{name}: it has shape {shape}; expected two axes, rows and columns\nhelp: {help}")
    if array.ndim == 2 and array.shape != size:
        height, width = array.shape
        raise Error(f"{name} is {width}x{height}, the light is {size[1]}x{size[0]}\nhelp: {help}")
    return np.ascontiguousarray(np.broadcast_to(array, size), np.float64)


def _finite(name: str, given: float | None) -> float | None:
    """A number that is one, or none."""
    if given is None:
        return None
    help = f"give a number, such as {name}=1.5"
    found = arguments.number(name, given, help)
    if not math.isfinite(found):
        raise Error(f"{name} = {found}\nhelp: {help}")
    return found


def _chip(given: str | Path | None) -> str | None:
    """A chip by name, or its folder."""
    return None if given is None else found_chip(given)


def _constants(given: Mapping[str, float] | None) -> dict[str, float]:
    """Constants of a program, by name."""
    such_as = '{"threshold": 20}'
    help = f"give numbers, such as constants={such_as}"
    return {
        name: arguments.number(f'constants["{name}"]', value, help)
        for name, value in arguments.table("constants", given, such_as).items()
    }
