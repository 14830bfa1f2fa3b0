"""Python's answers have the keys and the values of the command line's ``--json``."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import amacrine
import numpy as np
import pytest

SCENE = "pattern:disc?width=48&height=40&frames=12&fps=50"
HOW: Any = {"scene": SCENE, "effort": 0.05}
WORDS = ("--scene", SCENE, "--effort", 0.05, "--json")

Program = Callable[..., str]


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", amacrine.Caution)
        yield


def _stated(text: str) -> Any:
    """What the command line prints, in the words of Python."""
    stated = json.loads(text)
    if isinstance(stated, list):
        return [amacrine.Answer.parse(json.dumps(one)).to_dict() for one in stated]
    return amacrine.Answer.parse(text).to_dict()


def _same(own: Any, stated: Any) -> None:
    """First the keys, so that a failure names them."""
    assert sorted(own) == sorted(stated)
    assert own == stated


def _without(of: dict[str, Any], *names: str) -> dict[str, Any]:
    """All but some keys, which are there."""
    assert set(names) <= set(of)
    return {name: one for name, one in of.items() if name not in names}


@pytest.mark.parametrize("steps", [True, False])
def test_waterfall(program: Program, steps: bool) -> None:
    words: tuple[Any, ...] = ("--steps",) if steps else ("--rates", "50", "--tiles", 2)
    how: Any = {"steps": True} if steps else {"rates": 50, "tiles": 2}
    stated = program("waterfall", "csdvs-3", "--threshold", 20, *words, *WORDS)
    _same(amacrine.waterfall("csdvs-3", 20, **how, **HOW).to_dict(), _stated(stated))


def test_waterfall_of_several_kernels(program: Program) -> None:
    words = ("--threshold", "20,64", "--steps", *WORDS)
    stated = _stated(program("waterfall", "csdvs-3", "sobel-x", *words))
    falls = amacrine.waterfall(["csdvs-3", "sobel-x"], [20, 64], steps=True, **HOW)
    for own, theirs in zip(falls, stated, strict=True):
        assert own.memory
        _same(own.to_dict(), theirs)


def test_the_drawing_of_a_waterfall(program: Program, tmp_path: Path) -> None:
    words = ("--threshold", "20,64", "--steps", "--kind", 1, "-o", tmp_path / "fall.svg")
    program("waterfall", "csdvs-3", "sobel-x", *words, *WORDS)
    falls = amacrine.waterfall(["csdvs-3", "sobel-x"], [20, 64], steps=True, **HOW)
    assert falls[1].drawing == (tmp_path / "fall.svg").read_text()


TIMED = {"seconds", "seconds_range", "planning_seconds", "planning", "command"}
"""What of a model is measured by the clock, and what is typed to run it."""

JUDGED = {"on_front", "beaten_by", "is_knee"}
"""What depends on that."""


def _untimed(of: Any) -> Any:
    if isinstance(of, list):
        return [_untimed(one) for one in of]
    if isinstance(of, dict):
        left_out = TIMED | JUDGED
        return {name: None if name in left_out else _untimed(one) for name, one in of.items()}
    return of


def _trades(own: dict[str, Any], stated: dict[str, Any], names: list[str]) -> None:
    """Which models are tried together depends on seconds; each alone does not."""
    timed = "points", "reading_seconds", "command", "knee"
    assert list(own) and sorted(own) == sorted(stated)
    _same(_without(own, *timed), _without(stated, *timed))
    for name in names:
        one, other = (
            [_untimed(point) for point in of["points"] if point["name"] == name]
            for of in (own, stated)
        )
        assert len(one) == 1
        _same(one[0], other[0])


GRATING = "pattern:grating?width=64&height=64&frames=20&fps=100"


def test_trade(program: Program) -> None:
    words = ("--scene", GRATING, "--sensor", "rgc", "--formats", "f32,f16", "--json")
    stated = _stated(program("trade", *words))
    sensor = amacrine.Sensor.from_file("rgc")
    own = amacrine.trade(sensor, GRATING, formats=["f32", "f16"]).to_dict()
    _trades(own, stated, ["the full model", "f32", "f16"])


def test_trade_of_a_program(program: Program) -> None:
    words = ("--scene", GRATING, "--program", "dvs/snap", "--formats", "f16", "--json")
    stated = _stated(program("trade", *words))
    snap = amacrine.Program.from_file("dvs/snap")
    own = amacrine.trade(snap, GRATING, formats=["f16"]).to_dict()
    _trades(own, stated, ["the full model", "f16"])


@pytest.mark.parametrize("frames", [1, 2])
def test_a_trade_of_too_few_frames(program: Program, frames: int) -> None:
    short = f"pattern:disc?width=24&height=20&frames={frames}&radius=6"
    said = program("trade", "--scene", short, "--sensor", "rgc", good=False)
    with pytest.raises(amacrine.Error) as wrong:
        amacrine.trade(amacrine.Sensor.from_file("rgc"), short)
    message, help = str(wrong.value).split("\nhelp: ")
    for words in (message, help):
        assert words in " ".join(said.replace("│", " ").split())


def test_quantise(program: Program) -> None:
    words = ("--to", "ternary,q3.4", "--threshold", 20, *WORDS)
    stated = _stated(program("quantise", "csdvs-3", *words))
    own = amacrine.quantise("csdvs-3", ["ternary", "q3.4"], thresholds=20, **HOW)
    _same(own.to_dict(), stated)


def test_quantise_of_several_kernels(program: Program) -> None:
    words = ("--to", "ternary", "--threshold", "20,30", *WORDS)
    stated = _stated(program("quantise", "dog,sobel-x", *words))
    own = amacrine.quantise(["dog", "sobel-x"], "ternary", thresholds=[20, 30], **HOW)
    _same(own.to_dict(), stated)


def test_quantise_says_what_cannot_be() -> None:
    small = "q3.4"
    kernel = np.array([[0, 1, 0], [1, -4, 1], [0, 1, 0]]) / 300
    with pytest.raises(amacrine.Error, match="the kernel cannot be q3.4: every weight becomes 0"):
        amacrine.quantise(kernel, small, thresholds=20, **HOW)


def test_feasibility(program: Program) -> None:
    few = ("--to", "ternary", "--candidates", "ternary", "--chips", 1)
    stated = _stated(program("feasibility", "csdvs-3", "--threshold", 20, *few, *WORDS))
    how: Any = {"to": "ternary", "candidates": "ternary", "chips": 1}
    own = amacrine.feasibility("csdvs-3", 20, **how, **HOW).to_dict()
    # The command that gives the page again is typed.
    _same(_without(own, "command"), _without(stated, "command"))


def test_design(program: Program) -> None:
    stated = _stated(program("design", "csdvs-3", "--rate", 2, "--to", "ternary", *WORDS))
    own = amacrine.design("csdvs-3", rate=2, to="ternary", **HOW).to_dict()
    # The command line writes files, and says which; Python has their texts.
    for candidate in own["candidates"]:
        del candidate["sensor"], candidate["program"]
    _same(own, _without(stated, "written", "commands"))


def test_compare(program: Program, tmp_path: Path) -> None:
    events = np.zeros(40, amacrine.EVENT)
    events["t"] = np.arange(40) * 1000
    events["x"], events["y"], events["p"] = events["t"] % 7, events["t"] % 5, 1
    judged = events[5:].copy()
    judged["t"] += 3
    files = tmp_path / "a.npy", tmp_path / "b.npy"
    for file, of in zip(files, (events, judged), strict=True):
        amacrine.write(file, of, size=(8, 8))
    stated = _stated(program("compare", *files, "--fps", 100, "--json"))
    _same(amacrine.compare(*files, fps=100).to_dict(), stated)


def test_defaults_are_those_of_the_command_line(program: Program) -> None:
    """As its helps tell them."""
    own = amacrine._amacrine
    for verb, told in {
        "trade": [
            f"[default: {own.TRADE_WITHIN * 1e6:g}us]",
            f"[default: {own.SAMPLE:.0%}]",
            f"[default: {own.RUNS}]",
            f"[default: {own.DOMAIN}]",
        ],
        "waterfall": [
            f"[default: {own.TO}]",
            f"[default: {own.CHIP}]",
            f"[default: {own.DOMAIN}]",
            f"[default: {own.WATERFALL_CHIPS}]",
            f"[default: {own.EFFORT:g}]",
        ],
        "feasibility": [
            f"[default: {','.join(own.CANDIDATES)}]",
            f"[default: {own.FEASIBILITY_CHIPS}]",
            "[default: {:g}..{:g}]".format(*own.LINK_PJ),
        ],
    }.items():
        help = " ".join(program(verb, "--help").split())
        for one in told:
            assert one in help, verb
