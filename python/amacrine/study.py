"""Studies: what a kernel, or a sensor, loses on a chip and in plainer models."""

from __future__ import annotations

import importlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Union, overload

import numpy as np
import numpy.typing as npt

from . import _amacrine, arguments, notebook
from ._amacrine import (
    CANDIDATES,
    CHIP,
    DOMAIN,
    EFFORT,
    FEASIBILITY_CHIPS,
    LINK_PJ,
    RUNS,
    SAMPLE,
    TO,
    TRADE_WITHIN,
    WATERFALL_CHIPS,
    Error,
)
from .answer import Answer, told
from .frames import shown
from .caution import caution
from .kernels import Kernels, named, npy
from .names import chip as found_chip
from .program import Program
from .readout import Readout, readout_of
from .sensor import UNIT_OF_COMPILED, Sensor, sensor_of
from .arguments import flag, micros, names, whole, word, word_or_none

Scene = Any
"""What is watched: frames, (T,H,W) or (T,1,H,W), with ``fps``; or what :func:`amacrine.load`
takes; or None, the clip that comes with the package."""


Cells = Union[Kernels, Sensor, Sequence[Any]]
"""Kernels; or a sensor, its file, or a name of :func:`amacrine.names`, which has thresholds, too; or a
list of any of these, each kernel a kind of cell."""

THRESHOLD = f"give a number above 0, {UNIT_OF_COMPILED}"
PART = "give a part above 0 and up to 1, such as sample=0.05"
LINK = "give the least and the most, in pJ, such as link_energy=(1.0, 20.0), or one number"

MOST_CHIPS = 1024
"""Chips that are drawn at most: each is a run."""

MOST_FALLEN = 1000
"""Chips, and tiles, of a waterfall at most."""

MOST_RUNS = (1 << 32) - 1


@dataclass(frozen=True, eq=False)
class Quantised:
    """A kernel in few values: scale times levels."""

    to: str
    """The quantiser."""
    name: str
    """What the kernel is called."""
    levels: npt.NDArray[np.float64]
    """What a chip computes with, (k,k)."""
    scale: float
    """What they are to be multiplied by; divide thresholds by it instead."""
    relative_error: float
    """|w - scale l| / |w|, root mean square."""
    sum: float
    """Its response to uniform light."""
    taps: int
    """Levels that are not 0."""
    erased: tuple[str, ...]
    """What few values have erased: a surround that is gone, levels that are lopsided."""

    @property
    def kernel(self) -> npt.NDArray[np.float64]:
        """The kernel that levels and scale stand for."""
        kernel: npt.NDArray[np.float64] = self.levels * self.scale
        return kernel

    def _repr_html_(self) -> str:
        return notebook.table([self._row()]) + notebook.plane(self.levels)

    def _row(self) -> dict[str, Any]:
        columns = "to", "name", "relative_error", "scale", "sum", "taps"
        row = {name: getattr(self, name) for name in columns}
        erased = "; ".join(self.erased)
        return row | {"erased": erased} if erased else row


class QuantisedList(list[Any]):
    """Quantised kernels, or a list with those of each of several: a list, and a table in a notebook."""

    def _all(self) -> list[Quantised]:
        few = (one if isinstance(one, list) else [one] for one in self)
        return [one for several in few for one in several]

    def _repr_html_(self) -> str:
        drawn = ((f"{one.name}, {one.to}", one.levels) for one in self._all())
        return notebook.table([one._row() for one in self._all()]) + notebook.planes(drawn)

    def to_frame(self) -> Any:
        """Its table as a pandas data frame, a row for each quantised kernel. Needs pandas."""
        return importlib.import_module("pandas").DataFrame([one._row() for one in self._all()])


@overload
def quantise(
    kernel: Cells, to: str | Sequence[str], *, sum: str = "kept", seed: int | None = None
) -> Any: ...
@overload
def quantise(
    kernel: Cells,
    to: str | Sequence[str],
    *,
    thresholds: float | Sequence[float] | None = None,
    sum: str = "kept",
    scene: Scene = None,
    fps: float | None = None,
    scale: float | None = None,
    chip: str | Path | None = None,
    within: float | None = None,
    effort: float | None = None,
    seed: int | None = None,
) -> Answer: ...
@arguments.renamed(threshold="thresholds")
def quantise(
    kernel: Cells,
    to: str | Sequence[str],
    *,
    thresholds: float | Sequence[float] | None = None,
    sum: str = "kept",
    scene: Scene = None,
    fps: float | None = None,
    scale: float | None = None,
    chip: str | Path | None = None,
    within: float | None = None,
    effort: float | None = None,
    seed: int | None = None,
) -> Any:
    """A kernel in few values, or several, and what that does to them.

    Args:
        kernel: A name, a file, an array (k,k), or several as for :class:`Sensor`; or a sensor, its
            file or its name: then each is run on the chip at the sensor's thresholds.
        to: A quantiser such as ``"ternary"``, ``"int-5"``, ``"po2-3"``, ``"q3.4"``; or several.
        thresholds: Compile each for the chip, and run it on a scene beside the float kernel: events
            where kernel times light (0 to 255) moved by more than this. Several kernels are run in one
            program; one threshold for all, or one for each. A sensor has its own.
        sum: What the quantised kernel must sum to: ``"free"``, ``"zero"`` or ``"kept"``.
        scene: What they watch, with ``thresholds`` or a sensor, as all that follow but ``seed``.
        chip: A shipped chip by name, or the folder of another; ``"scamp5"`` where it is left out.
        effort: How long to search for each program, as for :meth:`Sensor.on_chip`; 1 where it is left
            out.
        seed: Of stochastic rounding (``"q3.4:stochastic"``), of the searches and of the silicon; 0 where
            it is left out. Refused where none of these is there.

    Returns:
        A :class:`Quantised`, a list of them where several quantisers were asked for; of several
        kernels a list with that of each. These lists are tables in a notebook. With ``thresholds``, or
        of a sensor, an :class:`Answer` with the names of ``amacrine quantise --json``: ``kernel``, ``quantised``
        (a row for each quantiser: levels, scale, relative error) and ``chip``, whose ``rows``, the
        table of ``to_frame()``, have words, us, what is kept and the threshold equivalent of each; of
        several kernels ``kernels``, each with its ``quantised``, and the table ``together``, a row for
        each quantiser. A notebook shows words, us, and what is kept with the chip's errors, also as a
        threshold equivalent, of each, or why it is not known.
    """
    of, several = _kinds(kernel), not isinstance(to, str)
    given, limits = of.named, of.limits(thresholds)
    values, total = names("to", to), word("sum", sum, "kept")
    drawn = None if seed is None else whole("seed", seed)
    if limits is None:
        of_chip = {
            "within": within,
            "chip": chip,
            "effort": effort,
            "scene": scene,
            "fps": fps,
            "scale": scale,
        }
        for name, one in of_chip.items():
            if one is not None:
                raise Error(
                    f"{name} needs thresholds\n"
                    "help: give thresholds, too, or a sensor, which has its own: then each is run on the "
                    "chip"
                )
        if not values:
            raise Error("to names no quantiser\nhelp: give one, such as to=\"ternary\"")
        found = json.loads(_amacrine.quantise(given, values, total, drawn))
        each = [
            QuantisedList(_quantised(name, of) for of in few)
            for (name, _), few in zip(given, found)
        ]
        of_kernels = QuantisedList(each if several else [few[0] for few in each])
        return of_kernels if len(given) > 1 else of_kernels[0]
    search = _search(
        total, CHIP if chip is None else chip, EFFORT if effort is None else effort, drawn or 0
    )
    text = _amacrine.on_chip(
        {
            "kernels": given,
            "thresholds": limits,
            "to": values,
            "memory": of.memory,
            "within_us": micros("within", within),
        },
        search,
        shown(scene, fps, scale),
    )
    if len(given) > 1:
        return told(Answer.parse(text, rows="together", show=_together))
    return told(Answer.parse(text, rows="chip.rows", show=_alone))


def _alone(of: dict[str, Any]) -> list[dict[str, Any]]:
    return notebook.of_chip(of["chip"]["rows"], of["warnings"])


def _together(of: dict[str, Any]) -> list[dict[str, Any]]:
    return notebook.of_chip(of["together"], of["warnings"])


def _quantised(name: str, of: dict[str, Any]) -> Quantised:
    return Quantised(
        to=of["to"],
        name=name,
        levels=np.asarray(of["levels"], np.float64),
        scale=of["scale"],
        relative_error=of["relative_error"],
        sum=of["sum"],
        taps=of["taps"],
        erased=tuple(of["erased"]),
    )


def design(
    kernels: Cells,
    *,
    rate: float | None = None,
    thresholds: float | Sequence[float] | None = None,
    to: str | Sequence[str] = CANDIDATES,
    memory: str | None = None,
    sum: str = "kept",
    scene: Scene = None,
    fps: float | None = None,
    scale: float | None = None,
    chip: str | Path = CHIP,
    within: float | None = None,
    effort: float = EFFORT,
    seed: int = 0,
) -> Answer:
    """From kernels and a scene to sensors to choose from: the table of ``amacrine design``.

    Args:
        kernels: As for :class:`Sensor`, a kind of cell each; or a sensor, its file or its name.
        rate: Events per pixel and second, all kinds together, each an equal share: the thresholds
            are found.
        thresholds: Instead: events where kernel times light (0 to 255) moved by more than this, one
            for all kernels or one for each. A sensor has its own.
        to: Few values that are tried.
        memory: What the program remembers: ``"analogue"``, ``"shared"`` or ``"bits:N"``; else all
            that the chip has room for are tried.
        scene: What is watched.
        within: Events match within so many seconds.

    Returns:
        ``candidates``, the best first, each compiled and run: what it keeps with the chip's errors
        (``kept``, 0 to 1), ``words``, ``frames_s``, ``on_front``, its ``kinds``, and the texts of its
        files, ``sensor`` (.toml) and ``program`` (.scamp). ``knee`` is the index of the shortest
        program on the front that keeps nearly as much as the best; None where no program keeps
        more than chance does in this scene. ``rated`` has the rate of each kind (``rates``) and how
        many events that is of the float sensor (``events``). What there is to warn of is said of the
        knee.
    """
    of = _kinds(kernels)
    text = _amacrine.design(
        of.named,
        *_aim("a design", rate, thresholds, of),
        (names("to", to), word_or_none("memory", memory, "shared")),
        _search(sum, chip, effort, seed),
        shown(scene, fps, scale),
        micros("within", within),
    )
    return told(Answer.parse(text, rows="candidates"))


@arguments.renamed(threshold="thresholds")
def feasibility(
    kernels: Cells,
    thresholds: float | Sequence[float] | None = None,
    *,
    rate: float | None = None,
    to: str | None = None,
    candidates: str | Sequence[str] = (),
    sum: str = "kept",
    memory: str | None = None,
    scene: Scene = None,
    fps: float | None = None,
    scale: float | None = None,
    chip: str | Path = CHIP,
    exposure: float | None = None,
    link_energy: float | tuple[float, float] = LINK_PJ,
    overlapped: bool = True,
    within: float | None = None,
    chips: int = FEASIBILITY_CHIPS,
    effort: float = EFFORT,
    seed: int = 0,
) -> Answer:
    """Whether kernels can run in the pixels of a chip, and what is lost: the page of ``amacrine
    feasibility``.

    Args:
        kernels: As for :class:`Sensor`; several are to share a chip. Or a sensor, its file or its name.
        thresholds: Events where kernel times light (0 to 255) moved by more than this: one for all
            kernels, or one for each. A sensor has its own.
        rate: Instead: events per pixel and second, all kernels together, each an equal share: the
            thresholds are found.
        to: The few values that the chip computes with; else the best of the candidates.
        candidates: Rows of the table of quantisers; a usual list where it is empty.
        memory: What the program of all kernels remembers: ``"analogue"``, ``"shared"`` or
            ``"bits:N"``; as a sensor of several kinds says, else the first that the chip has room for,
            where it is left out.
        scene: What is watched.
        exposure: How long each frame is exposed, in seconds.
        link_energy: The least and the most energy of a bit on the link, in pJ, or one number: an
            assumption.
        overlapped: Whether the next frame is exposed while events are read.
        within: Events match within so many seconds.
        chips: Chips that are drawn from what the public data allow.

    Returns:
        All numbers; ``verdict``; ``page`` is the report, which a notebook shows and
        ``save("report.html")`` writes. ``docs/feasibility.md`` says how each number is found.
    """
    of = _kinds(kernels)
    aim = _aim("a report", rate, thresholds, of)
    remembered = word_or_none("memory", memory, "shared")
    text, page = _amacrine.feasibility(
        of.named,
        aim,
        (
            word_or_none("to", to, "int-5"),
            names("candidates", candidates),
            of.memory if remembered is None else remembered,
        ),
        _search(sum, chip, effort, seed),
        shown(scene, fps, scale),
        (micros("within", within), micros("exposure", exposure)),
        (_energy(link_energy), flag("overlapped", overlapped)),
        whole("chips", chips, 1, MOST_CHIPS),
    )
    return told(Answer.parse(text, page=page, rows="quantisation"))


class Waterfalls(list[Answer]):
    """Waterfalls of several kernels: a list, and all their drawings in a notebook."""

    def _repr_html_(self) -> str:
        return "".join(one._repr_html_() or "" for one in self)

    def to_frame(self, key: str | None = None) -> Any:
        """The tables of :meth:`Answer.to_frame` of all of them as one pandas data frame, with the
        kernel's name in the column ``kernel``. Needs pandas."""
        each = [one.to_frame(key) for one in self]
        for one, frame in zip(self, each):
            frame.insert(0, "kernel", one.name)
        return importlib.import_module("pandas").concat(each, ignore_index=True)


@arguments.renamed(threshold="thresholds")
def waterfall(
    kernel: Cells,
    thresholds: float | Sequence[float] | None = None,
    to: str = TO,
    *,
    sum: str = "kept",
    domain: str = DOMAIN,
    readout: Readout | None = None,
    rates: float | Sequence[float] | None = None,
    steps: bool = False,
    scene: Scene = None,
    fps: float | None = None,
    scale: float | None = None,
    chip: str | Path = CHIP,
    set: Mapping[str, float] | None = None,
    chips: int | None = None,
    tiles: int | None = None,
    within: float | None = None,
    effort: float = EFFORT,
    seed: int = 0,
) -> Any:
    """Where the events of the float sensor go on the way to the chip, over frame rate and step by
    step.

    Args:
        kernel: A name, a file, an array (k,k), or several as for :class:`Sensor`, all of them in one
            program; or a sensor, its file or its name.
        thresholds: Events where kernel times light (0 to 255) moved by more than this: one number for
            all kernels, or one for each. A sensor has its own.
        to: How the kernel comes into few values.
        domain: What the cells of the array hold.
        readout: How the chip's events are read out, as for :meth:`Sensor.events`; the scan that a
            compiled program asks for where it is left out.
        rates: Frames per second at which the same light is shown; four from the clip's own to the
            most that the chip allows where they are left out.
        steps: Tell only the steps at the clip's own rate, event by event.
        set: Numbers of the chip that are set, as what if: ``{"error.noise": 0.1}``.
        chips: How many chips over ``rates``: seeds from ``seed`` on; 4 if left out.
        tiles: Tiles of the scene on which they are run; as many as take some seconds if left out.

    Returns:
        An :class:`Answer` with ``kept``, ``steps`` and, over frame rate, ``rates``; ``drawing`` is the
        picture, which a notebook shows. Of several kernels a list with that of each, which has its
        ``name`` and the ``memory`` of the program too. ``docs/waterfall.md`` says what each cause is.
    """
    if flag("steps", steps):
        if rates is not None:
            raise Error("steps are told at the clip's own rate\nhelp: leave rates out, or steps")
        for name, one in (("chips", chips), ("tiles", tiles)):
            if one is not None:
                raise Error(
                    "steps are told of one chip and of the whole scene\n"
                    f"help: leave {name} out, or steps"
                )
    of = _kinds(kernel)
    limits = of.limits(thresholds)
    if limits is None:
        raise Error(
            "a waterfall needs a threshold\n"
            f"help: give thresholds=40, {UNIT_OF_COMPILED}, or a sensor, which has its own"
        )
    found = _amacrine.waterfall(
        {
            "kernels": of.named,
            "thresholds": limits,
            "to": word("to", to, "int-5"),
            "domain": word("domain", domain, "exact"),
            "memory": of.memory,
            "sets": _figures(set),
            "readout": readout_of(readout),
            "within_us": micros("within", within),
            "rates": _rates(rates),
            "chips": WATERFALL_CHIPS if chips is None else whole("chips", chips, 1, MOST_FALLEN),
            "tiles": None if tiles is None else whole("tiles", tiles, 1, MOST_FALLEN),
            "steps": steps,
        },
        _search(sum, chip, effort, seed),
        shown(scene, fps, scale),
    )
    rows = "steps" if steps else "rates"
    all = Waterfalls(Answer.parse(text, drawing=svg, rows=rows) for text, svg in found)
    told(*all)
    return all if len(of.named) > 1 else all[0]


def trade(
    sensor: Sensor | Program,
    scene: Scene = None,
    *,
    fps: float | None = None,
    scale: float | None = None,
    upsample: float | None = None,
    domain: str | None = None,
    formats: str | Sequence[str] | None = None,
    within: float = TRADE_WITHIN,
    sample: float = SAMPLE,
    runs: int = RUNS,
    verify: bool = False,
    seed: int | None = None,
) -> Answer:
    """Error against seconds, for every plainer model of a sensor, or of a program, in a scene.

    Args:
        sensor: The full model, with all its effects, in f64; or a :class:`Program`, in ``domain``.
        scene: What is watched, at least three frames.
        upsample: Insert frames so that no pixel's light, of 255, plus 1 changes by more than this, in
            ln units.
        domain: Of a program: what the cells of its full model hold; ``"silicon"`` if left out.
        formats: Number formats in place of the full model's; usual ones where they are left out.
        within: An event that is moved by more seconds is changed.
        sample: The part of the sensor that is run, above 0 and up to 1.
        runs: How many runs of a model share what it took to know its error.
        verify: Run every model on the whole scene, too.
        seed: Chooses mismatch and noise, and the tiles; the sensor's own, or 0 of a program, where it
            is left out.

    Returns:
        ``points``, a table with ``name``, ``error``, ``seconds``, ``seconds_range``, ``on_front``,
        ``is_knee``, ``command`` and more; ``knee`` is the name of the best, and ``command`` what runs
        it, of ``sensor`` or ``program`` on ``frames``; both are None where nothing is known of any
        model, which ``no_knee`` says. It is a drawing in a notebook.
        ``docs/fidelity.md`` says what the limits mean.
    """
    if not isinstance(sensor, (Sensor, Program)):
        raise Error(
            f"a trade is of a float sensor or of a program, not of a {type(sensor).__name__}\n"
            'help: give a Sensor, such as Sensor.from_file("rgc-4"), or a Program, such as '
            "chip.program"
        )
    own = sensor._seed if isinstance(sensor, Sensor) else 0
    drawn = own if seed is None else whole("seed", seed)
    light = shown(scene, fps, scale)
    is_program = isinstance(sensor, Program)
    if is_program and upsample is not None:
        raise Error("upsample of a program\nhelp: leave upsample out: a program sees frames")
    if not is_program and domain is not None:
        raise Error("domain of a float sensor\nhelp: leave domain out, or give a Program")
    if is_program:
        called = "program"
    else:
        called = "sensor" if drawn == own else f"sensor.with_seed({drawn})"
    asked: _amacrine._Trade = {
        "upsample": arguments.contrast(upsample),
        "formats": None if formats is None else names("formats", formats),
        "within_us": micros("within", within) or 0,
        "sample": arguments.number("sample", sample, PART),
        "runs": whole("runs", runs, 1, MOST_RUNS),
        "verify": flag("verify", verify),
        "seed": drawn,
        # As the caller writes it: the same frames, the same seed.
        "called": called,
        "scale": "" if scale is None else f", scale={float(scale)!r}",
    }
    if isinstance(sensor, Program):
        full = DOMAIN if domain is None else word("domain", domain, "silicon")
        found = _amacrine.trade_program(sensor._native, full, light, asked)
    else:
        found = _amacrine.trade(sensor._native, light, asked)
    return Answer.parse(found[0], drawing=found[1], rows="points")


def _search(sum: str, chip: str | Path, effort: float, seed: int) -> tuple[str, str, float, int]:
    """How a program is searched."""
    seconds = arguments.number("effort", effort, "give seconds, such as effort=1")
    on = found_chip(chip)
    return word("sum", sum, "kept"), on, seconds, whole("seed", seed)


def _figures(given: Any) -> list[tuple[str, float]]:
    """Numbers of the chip by name."""
    such_as = '{"error.noise": 0.1}'
    help = f"give numbers, such as set={such_as}"
    return [
        (name, arguments.number(f'set["{name}"]', value, help))
        for name, value in arguments.table("set", given, such_as).items()
    ]


def _energy(given: Any) -> tuple[float, float]:
    """The least and the most energy of a bit, as the command line takes it."""
    ends = arguments.numbers("link_energy", given, LINK)
    low, high = ends * 2 if len(ends) == 1 else (*ends, math.nan, math.nan)[:2]
    if len(ends) > 2 or not 0.0 <= low <= high < math.inf:
        raise Error(f"link_energy = {given!r}\nhelp: {LINK}")
    return low, high


@dataclass(frozen=True)
class _Kinds:
    """The kinds of cells that a study is of."""

    named: list[tuple[str, bytes | None]]
    """What each is called, and the bytes of its kernel unless it is built in."""
    own: list[float] | None = None
    """The threshold of each, of sensors."""
    memory: str | None = None
    """What a program of several must remember, of one sensor."""

    def limits(self, given: Any) -> list[float] | None:
        """A threshold for each: those that are given, else those of sensors; none is none."""
        return self.own if given is None else _limits(given, len(self.named))


def _kinds(given: Any) -> _Kinds:
    """Kernels, or those of sensors with their thresholds. In what programs cannot follow a sensor the
    caller is warned of."""
    parts = list(given) if isinstance(given, (list, tuple)) else [given]
    sensors = [sensor_of(part) for part in parts]
    if all(sensor is None for sensor in sensors):
        return _Kinds(named(given))
    kinds: list[tuple[str, bytes | None]] = []
    own: list[float] | None = []
    memory = None
    for part, sensor in zip(parts, sensors):
        if sensor is None:
            own = None
            kinds += named(part, len(kinds))
            continue
        called, of = sensor
        called_kinds, kernels, thresholds, memory, notes = of._native.studied(called)
        kinds += [(name, npy(kernel)) for name, kernel in zip(called_kinds, kernels)]
        own = None if own is None else own + thresholds
        for note in notes:
            caution(note)
    return _Kinds(kinds, own, memory if len(parts) == 1 else None)


def _limits(thresholds: Any, count: int) -> list[float]:
    """A threshold for each kernel."""
    limits = arguments.numbers("thresholds", thresholds, THRESHOLD)
    if len(limits) == 1:
        limits *= count
    if len(limits) != count:
        raise Error(
            f"{len(limits)} thresholds for {count} kernels\n"
            "help: give one threshold for all kernels, or one for each, in their order"
        )
    return limits


def _aim(
    what: str, rate: Any, thresholds: Any, of: _Kinds
) -> tuple[float | None, list[float]]:
    """A rate, or a threshold for each kernel."""
    limits = of.limits(thresholds) if rate is None else None
    if limits is None and rate is None or None not in (rate, thresholds):
        raise Error(
            f"{what} needs a rate of events, or thresholds, and not both\n"
            "help: give rate=2, events per pixel and second, or thresholds=40, or a sensor, which has "
            "its own"
        )
    if limits is not None:
        return None, limits
    return arguments.number("rate", rate, "give events per pixel and second, such as rate=2"), []


def _rates(given: Any) -> list[float]:
    """Frames per second, or none."""
    if given is None:
        return []
    return arguments.numbers("rates", given, "give frames per second, such as rates=[30, 60]")
