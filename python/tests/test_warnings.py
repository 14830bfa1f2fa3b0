"""What Python warns of in a run is what the command line warns of in the same run."""

from __future__ import annotations

import json
import signal
import threading
import warnings
from pathlib import Path
from typing import Any, Callable, NamedTuple

import numpy as np
import numpy.typing as npt
import pytest

import amacrine
from amacrine import _amacrine

FPS = 100.0

SPOTS = Path(__file__).parents[2] / "tests" / "data" / "vendor" / "spots.cpp"

Array = npt.NDArray[Any]


def moving(frames: int = 6, height: int = 24, width: int = 32) -> Array:
    """Texture that moves."""
    texture = np.random.default_rng(5).integers(0, 256, (height, width + frames)).astype(np.uint8)
    return np.stack([texture[:, n : n + width] for n in range(frames)])


def still(frames: int = 6) -> Array:
    return np.repeat(moving(1), frames, axis=0)


def cut() -> Array:
    """Twenty frames of slow change, and another picture from the tenth on."""
    random = np.random.default_rng(3)
    pictures = random.integers(20, 230, (2, 24, 32)).astype(np.uint8)
    return np.stack([pictures[int(n >= 10)] + n % 3 for n in range(20)]).astype(np.uint8)


def spot() -> Array:
    """One bright spot that moves."""
    clip = np.full((6, 24, 32), 60, np.uint8)
    for n in range(6):
        clip[n, 5, 4 + 2 * n] = 220
    return clip


def flash() -> Array:
    """One bright spot that appears."""
    clip = np.zeros((3, 24, 32))
    clip[1:, 2, 3] = 200.0
    return clip


def said(watch: Callable[[], Any]) -> set[str]:
    """What a call warns of."""
    with warnings.catch_warnings(record=True) as all:
        warnings.simplefilter("always")
        watch()
    return {str(one.message) for one in all if issubclass(one.category, amacrine.Caution)}


def words(warning: dict[str, Any]) -> str:
    """A warning of the command line, in the words of Python."""
    first, *others = warning["subjects"]
    also = f" (also: {'; '.join(others)})" if others else ""
    text = f"{first}: {warning['seen']}{also}: {warning['why']}\nhelp: {warning['change']}"
    return str(_amacrine.in_python(text))


class Case(NamedTuple):
    """A program or a sensor, what it is shown, and what the warnings are about."""

    text: str
    clip: Array
    about: set[str]
    given: dict[str, Any] = {}
    """Arguments of Python."""
    options: tuple[Any, ...] = ()
    """The same as options of the command line."""


def two_kinds(program: str = "sub(E, D, C); scamp5_in(F, 5); sub(E, E, F);") -> str:
    """A program of two kinds of cells, of which the second says nothing."""
    return (
        '//! names = ["spot", "dead"]\ninit { get_image(C); }\nframe {\n get_image(D);'
        f" {program} where(E); MOV(R5, FLAG); all(); scamp5_scan_events(R5, on0, 100);"
        " CLR(R5); scamp5_scan_events(R5, on1, 100);\n mov(C, D); }"
    )


SUMS = "get_image(A);\nmov(B, A);\nadd(C, A, B);\nmov(B, C);\nadd(D, C, B);\n"

FULL = "init { get_image(C); }\nframe {\n SET(R5); scamp5_scan_events(R5, on, 100); }"

ALL = "SET(R5); scamp5_scan_events(R5, on, 100);"

ROWS = "init { CLR(R5); }\nframe {\n SET(R5); scamp5_scan_dreg(R5, on, 1, 2); }"

NO_ROW = (
    "init { CLR(R5); }\nframe {\n scamp5_load_point(R5, 0, 0); scamp5_scan_dreg(R5, on, 1, 2); }"
)

SILENT = "init { CLR(R5); }\nframe {\n CLR(R5); scamp5_scan_dreg(R5, on, 0, 255); }"

MIDDLE = (
    "get_image(A);\nmov(B, A); add(A, A, B);\nmov(B, A); add(A, A, B);\n"
    "divq(B, A); divq(A, B); res(B);\n"
)

PROGRAMS = {
    "rows that are not scanned": Case(ROWS, moving(), {"rows"}),
    "all in rows that are not scanned": Case(NO_ROW, moving(), {"no-events", "rows"}),
    "no event in bit planes": Case(SILENT, moving(), {"no-events"}),
    "beyond registers on the way": Case(MIDDLE, moving(), {"saturation"}),
    "the end of registers on the way": Case(
        MIDDLE, moving(), {"saturation"}, {"domain": "silicon"}, ("--domain", "silicon")
    ),
    "nothing": Case("dvs/snap", spot(), set()),
    "larger than the chip": Case("dvs/snap", moving(6, 300, 300), {"larger", "slots"}),
    "no event": Case("dvs/snap", still(), {"no-events"}),
    "a cut": Case("dvs/snap", cut(), {"cut", "most-cells"}),
    "light of 0 to 1": Case("dvs/snap", moving() / 255, {"scale", "no-events"}),
    "a silent kind": Case(two_kinds(), flash(), {"no-events"}),
    "full slots": Case(FULL, moving(), {"slots"}),
    "full slots of one frame": Case(ALL, moving(1), {"slots"}),
    "beyond registers": Case(SUMS, moving(), {"saturation"}),
    "the end of registers": Case(
        SUMS, moving(), {"saturation"}, {"domain": "silicon"}, ("--domain", "silicon")
    ),
    "without a part": Case(
        SUMS,
        moving(),
        {"saturation"},
        {"domain": "silicon", "seed": 3, "without": "noise"},
        ("--domain", "silicon", "--seed", 3, "--without", "noise"),
    ),
    "clipped": Case(SUMS, moving(), {"saturation"}, {"clip": True}, ("--clip", "on")),
    "unheld": Case("dvs/snap", moving(), {"saturation"}, {"domain": "q4.12"}, ("--domain", "q4.12")),
    "unheld by its gain": Case(
        "dvs/snap",
        moving(),
        {"saturation"},
        {"domain": "q8.8", "gain": 4.0},
        ("--domain", "q8.8", "--gain", 4.0),
    ),
    "a host that decides": Case(str(SPOTS), still(4), {"saturation"}),
    "a host that decides, larger": Case(str(SPOTS), moving(3, 24, 300), {"larger", "saturation"}),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_programs(name: str, program: Callable[..., str], tmp_path: Path) -> None:
    case = PROGRAMS[name]
    np.save(tmp_path / "clip.npy", case.clip)
    of = case.text
    if "\n" in of or ";" in of:
        (tmp_path / "p.scamp").write_text(of)
        of = str(tmp_path / "p.scamp")
    shown = ("--image", tmp_path / "clip.npy", "--fps", FPS, "--json")
    told = json.loads(program("exec", of, *shown, *case.options))["warnings"]
    native = amacrine.Program.from_file(of)
    got = said(lambda: native.run(case.clip, FPS, scale=scale(case), **case.given))
    assert got == {words(one) for one in told}
    assert {one["about"] for one in told} == case.about


HEAD = 'response = "identity"\nmemory = "filtered-snap"\nborder = "zero"\n'


def kind(on: float, name: str, kernel: str = "[[1]]", more: str = "") -> str:
    threshold = f"{{ on = {on}, off = {on}{more} }}"
    return f'[[channel]]\nname = "{name}"\nkernel = {kernel}\nthreshold = {threshold}\n'


SENSORS = {
    "nothing": Case(HEAD + kind(40, "change"), spot(), set()),
    "no event": Case(HEAD + kind(900, "change"), moving(), {"no-events"}),
    "a silent kind": Case(HEAD + kind(40, "change") + kind(900, "dead"), moving(), {"no-events"}),
    "most cells": Case(HEAD + kind(2, "change"), moving(), {"most-cells"}),
    "spread": Case(HEAD + kind(40, "change", more=", sigma = 20"), spot(), {"spread"}),
    "a still scene": Case(HEAD + kind(40, "change"), still(), {"no-events"}),
    "a cut": Case(HEAD + kind(40, "change"), cut(), {"cut", "most-cells"}),
    "light of 0 to 1": Case(HEAD + kind(40, "change"), moving() / 255, {"scale", "no-events"}),
    "beyond a format": Case(HEAD + kind(40, "change"), moving(), {"saturation"}, {}, ("q8.8",)),
    "rounded": Case(
        HEAD + kind(4, "change", "[[0.001, 0.001, 0.001], [0.001, 0.4, 0.001], [0, 0, 0.001]]"),
        spot(),
        {"rounded"},
        {},
        ("q12.4",),
    ),
}


@pytest.mark.parametrize("way", ["events", "counts", "voxels"])
@pytest.mark.parametrize("name", SENSORS)
def test_sensors(name: str, way: str, program: Callable[..., str], tmp_path: Path) -> None:
    case = SENSORS[name]
    np.save(tmp_path / "clip.npy", case.clip)
    (tmp_path / "s.toml").write_text(case.text)
    shown = ("--sensor", tmp_path / "s.toml", "--scene", tmp_path / "clip.npy", "--fps", FPS)
    formats = [word for format in case.options for word in ("--format", format)]
    told = json.loads(program("run", *shown, *formats, "--json"))["warnings"]
    sensor = amacrine.Sensor.from_file(tmp_path / "s.toml")
    for format in case.options:
        sensor = sensor.in_format(format)
    got = said(lambda: getattr(sensor, way)(case.clip, FPS, scale=scale(case)))
    assert got == {words(one) for one in told}
    assert {one["about"] for one in told} == case.about


def scale(case: Case) -> float | None:
    """The command line takes numbers as they are."""
    return None if case.clip.dtype == np.uint8 else 1.0


def test_light_that_nothing_captures(program: Callable[..., str], tmp_path: Path) -> None:
    text = "movx(B, A, south);\nadd(A, B, C);\n"
    (tmp_path / "p.scamp").write_text(text)
    clip = moving(1)
    np.save(tmp_path / "clip.npy", clip)
    shown = ("--image", tmp_path / "clip.npy", "--fps", FPS, "--json")
    (told,) = json.loads(program("exec", tmp_path / "p.scamp", *shown))["source_warnings"]
    assert "no word captures it" in told
    native = amacrine.Program.from_file(tmp_path / "p.scamp")
    assert said(lambda: native.run(clip, FPS)) == {
        told.replace("--set A=FILE.npy", 'registers={"A": …}')
    }
    (some,) = said(lambda: native.run(clip, FPS, registers={"A": 3}))
    assert "nothing has written C before it is read" in some
    assert said(lambda: native.run(clip, FPS, registers={"A": 3, "C": 1})) == set()


def test_a_program_has_a_rate() -> None:
    snap = amacrine.Program.from_file("dvs/snap")
    for fps in (float("inf"), 0.0, float("nan")):
        with pytest.raises(amacrine.Error, match="frames per second is no rate"):
            snap.run(moving(), fps)
    with pytest.raises(amacrine.Error, match="frames per second is no rate"):
        snap.run(moving(), 1e300)
    with pytest.raises(amacrine.Error, match="inf frames per second is no rate"):
        amacrine.Sensor("dvs", 0.2).events(moving(), float("inf"))


def test_names_of_a_program_are_those_of_its_kinds() -> None:
    few = amacrine.Program.from_text(two_kinds().replace(', "dead"', ""))
    with pytest.raises(amacrine.Error, match="names"):
        few.run(flash(), FPS, scale=1)


def test_words_that_are_not_known_are_told() -> None:
    for range, transfer, match in (
        ("narrow", "auto", "`narrow` is no range\nhelp: give auto, limited or full"),
        ("auto", "sRGB", "`sRGB` is no transfer\nhelp: give auto, as-coded, linear"),
    ):
        with pytest.raises(amacrine.Error, match=match):
            _amacrine.scene("pattern:disc", None, None, 2, (range, transfer), (None, None, None))


def test_a_stream_that_was_interrupted_has_stopped() -> None:
    """What it saw is lost, so that nothing may follow it."""
    clip = np.repeat(moving(2, 128, 128), 3000, axis=0)
    main = threading.main_thread().ident
    assert main is not None
    for contrast in (None, 0.5):
        run = amacrine.Sensor(["csdvs-7"] * 4, 0.2)._watch((128, 128), FPS, 1.0)
        timer = threading.Timer(0.5, signal.pthread_kill, (main, signal.SIGINT))
        with pytest.raises(KeyboardInterrupt):
            timer.start()
            run.events(clip, contrast, None)
            # It may come right behind.
            threading.Event().wait(5)
        timer.join()
        assert contrast or run.seen < len(clip)
        for again in (None, 0.5):
            with pytest.raises(amacrine.Error, match=f"the stream stopped at frame {run.seen}"):
                run.events(clip[:2], again, None)


def test_a_picture_larger_than_the_chip_is_told_of() -> None:
    """Of a sensor on a chip as of its program."""
    sensor = amacrine.Sensor("dvs", 0.1, memory="filtered-snap", border="zero")
    chip = sensor.on_chip("exact", domain="exact", effort=0.01)
    wide = moving(3, 8, 300)
    seen = "an array of 300x8, but scamp5 has 256x256 processors: the run is larger than the chip"
    all: list[Callable[[Array], Any]] = [
        lambda clip: chip.events(clip, FPS),
        lambda clip: chip.counts(clip, FPS),
        lambda clip: chip.voxels(clip, FPS, bins=2),
        lambda clip: chip.stream(FPS).events(clip),
        lambda clip: chip.program.run(clip, FPS),
    ]
    for watch in all:
        assert sum(seen in text for text in said(lambda: watch(wide))) == 1
        assert not any("larger than the chip" in text for text in said(lambda: watch(wide[:, :, :256])))


def test_a_refractory_period_in_seconds_is_told_of() -> None:
    for us, told in ((0.001, True), (1.0, False), (None, False)):
        sensor = amacrine.Sensor("dvs", 0.1, refractory=us)
        found = said(lambda: sensor.events(moving(), FPS))
        assert any("a refractory period of 0.001 us" in text for text in found) == told


def test_a_full_queue_is_told_until_the_advice_is_taken(
    program: Callable[..., str], tmp_path: Path
) -> None:
    np.save(tmp_path / "clip.npy", moving())
    lossy = {"fifo": 1, "link": "15us", "when-full": "drop-newest"}
    shown = ("--sensor", "rgc-4", "--scene", tmp_path / "clip.npy", "--fps", FPS)
    read = ("-o", tmp_path / "e.npy", "--readout", "arbiter")
    settings = [word for key, value in lossy.items() for word in ("--with", f"{key}={value}")]
    told = json.loads(program("run", *shown, *read, *settings, "--json"))["warnings"]
    sensor = amacrine.Sensor.from_file("rgc-4")

    def got(changed: dict[str, str]) -> set[str]:
        readout = {"readout": "arbiter", **lossy, **changed}
        return said(lambda: sensor.events(moving(), FPS, readout=readout))

    assert got({}) == {words(one) for one in told}
    assert "queue" in {one["about"] for one in told}
    for advice in (
        {"fifo": "unlimited"},
        {"link": "36ns"},
        {"when-full": "stall", "requests": "all"},
    ):
        assert not any("queue" in one for one in got(advice)), advice
