"""Voxels, time surfaces and event frames as networks are fed."""

from __future__ import annotations

import subprocess
import sys
import warnings
from fractions import Fraction
from pathlib import Path
from typing import Any, Callable

import amacrine
import numpy as np
import pytest
from conftest import Frames, kernels

FPS = 120.0


def _slow(
    events: Any, kinds: int, how: dict[str, Any], end: int
) -> np.ndarray[Any, np.dtype[np.float64]]:
    """An event at t in a window from a to b gives 1 - |bin - (bins - 1) (t - a) / (b - a)|."""
    bins, length = how["bins"], how.get("window") or end * 1e-6
    every = how.get("every") or length
    causal, split = how.get("causal", True), how.get("polarity") == "split"
    bounds: list[tuple[int, int]] = []
    while True:
        n = len(bounds)
        if causal:
            if n and bounds[-1][1] >= end:
                break
            at = (n + 1) * every
            bounds.append((round((n * every + every - length) * 1e6), round(at * 1e6)))
        else:
            if n and round(n * every * 1e6) > end:
                break
            middle = n * every
            bounds.append((round((middle - length / 2) * 1e6), round((middle + length / 2) * 1e6)))
    out = np.zeros((len(bounds), kinds, 2, bins, 61, 83))
    for n, (a, b) in enumerate(bounds):
        # The first window has those at its start, too.
        for event in events[(events["t"] > a - (n == 0)) & (events["t"] <= b)]:
            part = (int(event["t"]) - a) / (b - a)
            for bin in range(bins):
                if how.get("share") == "whole":
                    share = float(bin / bins < (part or 1e-9) <= (bin + 1) / bins)
                else:
                    share = max(0.0, 1 - abs(bin - part * (bins - 1)))
                out[n, event["channel"], event["p"], bin, event["y"], event["x"]] += share
    return out if split else out[:, :, 1] - out[:, :, 0]


WAYS: list[dict[str, Any]] = [
    {"bins": 9},
    {"bins": 5, "window": 0.03},
    {"bins": 5, "window": 0.03, "polarity": "split"},
    {"bins": 1, "window": 0.05},
    {"bins": 4, "window": 0.02, "share": "whole"},
    {"bins": 3, "window": 0.025, "every": 1 / FPS},
    {"bins": 3, "window": 0.025, "every": 1 / FPS, "causal": False},
]


@pytest.mark.parametrize("how", WAYS, ids=str)
def test_voxels_are_those_of_the_equation(how: dict[str, Any], frames: Frames) -> None:
    sensor = amacrine.Sensor(kernels(2), 2.0)
    events = sensor.events(frames, FPS)
    assert len(events) > 1000
    end = round(11 / FPS * 1e6)
    want = _slow(events, 2, how, end)
    got = sensor.voxels(frames, FPS, **how)
    assert got.shape == want.shape and got.dtype == np.float32
    np.testing.assert_allclose(got, want, atol=1e-4)
    of_events = amacrine.events.voxels(events, size=(61, 83), channels=2, end=11 / FPS, **how)
    assert np.array_equal(of_events, got)
    shuffled = np.random.default_rng(1).permutation(events)
    again = amacrine.events.voxels(shuffled, size=(61, 83), channels=2, end=11 / FPS, **how)
    np.testing.assert_allclose(again, got, atol=1e-4)


def test_a_window_after_a_snap_has_the_events_of_its_last_frame(frames: Frames) -> None:
    """A memory that snaps decides at frames: a causal window that ends with a frame has its events."""
    sensor = amacrine.Sensor(kernels(1), 1.0, memory="filtered-snap")
    counts = sensor.counts(frames, FPS)
    voxels = sensor.voxels(frames, FPS, bins=1, window=1 / FPS)
    assert voxels.shape == (11, 1, 1, 61, 83)
    assert np.array_equal(voxels[:, :, 0], counts)


@pytest.mark.parametrize("chip", [False, True])
def test_windows_come_one_by_one(chip: bool, frames: Frames) -> None:
    made = amacrine.Sensor(kernels(2, 3), 0.5, memory="filtered-snap", border="zero")
    sensor = made.on_chip("int-5", domain="exact") if chip else made
    long = np.concatenate([frames] * 4)
    ways: list[dict[str, Any]] = [
        {"bins": 4, "window": 0.05},
        {"bins": 2, "window": 0.06, "every": 0.02, "normalise": "std"},
    ]
    for how in ways:
        want = sensor.voxels(long, FPS, **how)
        parts = (long[n : n + 7] for n in range(0, len(long), 7))
        got = list(sensor.voxel_windows(parts, FPS, **how))
        assert np.array_equal(np.stack(got), want) and want.any()
    assert list(sensor.voxel_windows([], FPS, bins=3, window=1.0)) == []


def test_no_event_falls_between_two_windows() -> None:
    """Crossings right behind a frame have its time in microseconds."""
    light = np.random.default_rng(0).integers(0, 256, (24, 48, 48)).astype(np.uint8)
    sensor = amacrine.Sensor("csdvs-3", 0.02)
    events = sensor.events(light, 1000)
    how: dict[str, Any] = dict(bins=1, window=0.004, polarity="split", share="whole")
    seen = sensor.voxels(light, 1000, **how)
    assert seen.astype(np.float64).sum() == len(events)
    assert np.array_equal(seen, amacrine.events.voxels(events, **how))


def test_silent_windows_at_the_end_are_there(tmp_path: Path) -> None:
    clip = np.full((11, 4, 4), 100, np.uint8)
    clip[2:] = 200
    sensor = amacrine.Sensor(np.ones((1, 1, 1)), 20.0, response="identity", memory="filtered-snap")
    events = sensor.events(clip, 10.0)
    want = sensor.voxels(clip, 10.0, bins=2, window=0.1, share="whole")
    amacrine.write(tmp_path / "e.npy", events)
    for given in (events, amacrine.read(tmp_path / "e.npy")):
        assert np.array_equal(amacrine.events.voxels(given, bins=2, window=0.1, share="whole"), want)
    assert len(want) == 10 and not want[2:].any() and want.any()
    # Who knows no span has the windows up to its last event.
    bare = np.asarray(events)
    assert len(amacrine.events.voxels(bare, bins=2, window=0.1, share="whole", size=(4, 4))) == 2


def test_ranges_and_types(frames: Frames) -> None:
    sensor = amacrine.Sensor(kernels(2), 2.0)
    plain = sensor.voxels(frames, FPS, bins=5)
    for dtype in (np.float16, np.float64):
        other = sensor.voxels(frames, FPS, bins=5, dtype=dtype)
        assert other.dtype == dtype and np.array_equal(other, plain.astype(dtype))
    even = sensor.voxels(frames, FPS, bins=5, normalise="std")
    for kind in range(2):
        fired = plain[0, kind] != 0
        assert even[0, kind][fired].mean() == pytest.approx(0, abs=1e-3)
        assert even[0, kind][fired].std() == pytest.approx(1, abs=1e-3)
        assert not even[0, kind][~fired].any()
    most = sensor.voxels(frames, FPS, bins=5, normalise="max")
    assert np.abs(most).max() == 1
    batch = np.stack([frames, frames[::-1]])[:, :, None]
    several = sensor.voxels(batch, FPS, bins=5)
    assert np.array_equal(several[0], plain) and several.shape == (2, *plain.shape)


def test_what_cancels_is_zero() -> None:
    """Events on the times of frames, against exact fractions; and brought to one range."""
    random = np.random.default_rng(4)
    events = np.zeros(4000, [("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "i1")])
    events["t"] = np.sort(random.integers(1, 11, 4000)) * 10_000
    events["x"], events["y"] = random.integers(0, 4, 4000), random.integers(0, 3, 4000)
    events["p"] = random.integers(0, 2, 4000)
    want = np.full((5, 3, 4), Fraction(0))
    for t, x, y, p in events.tolist():
        at = Fraction(4 * t, 100_000)
        for b in range(5):
            want[b, y, x] += (2 * p - 1) * max(Fraction(0), 1 - abs(at - b))
    how: dict[str, Any] = dict(bins=5, window=0.1, size=(3, 4))
    got = amacrine.events.voxels(events, **how)[0, 0]
    assert np.array_equal(got, want.astype(np.float32)) and not got.all()
    even = amacrine.events.voxels(events, normalise="std", **how)[0, 0]
    there = want.astype(float)[want != 0]
    assert np.array_equal(even != 0, want != 0)
    assert even[want != 0] == pytest.approx((there - there.mean()) / there.std(), abs=1e-6)


def test_time_surfaces(frames: Frames) -> None:
    sensor = amacrine.Sensor(kernels(2), 2.0)
    events = sensor.events(frames, FPS)
    times, tau = [0.0, 0.03, 0.0912, 0.05], 0.01
    got = amacrine.events.time_surfaces(events, times, tau=tau, size=(61, 83))
    want = np.zeros((4, 2, 2, 61, 83))
    for n, time in enumerate(times):
        for e in events[events["t"] <= round(time * 1e6)]:
            age = time - e["t"] * 1e-6
            want[n, e["channel"], e["p"], e["y"], e["x"]] = np.exp(-age / tau)
    assert got.shape == want.shape and got.dtype == np.float32
    np.testing.assert_allclose(got, want, atol=1e-6)
    signed = amacrine.events.time_surfaces(
        events, times, tau=tau, polarity="signed", decay="linear", size=(61, 83)
    )
    assert signed.shape == (4, 2, 61, 83) and signed.min() < 0 < signed.max() <= 1


def test_event_frames(frames: Frames) -> None:
    sensor = amacrine.Sensor(kernels(2), 2.0)
    events = sensor.events(frames, FPS)
    got = amacrine.events.event_frames(events, 1000, size=(61, 83), polarity="split")
    assert got.shape == (-(-len(events) // 1000), 2, 2, 61, 83)
    assert (got[:-1].sum((1, 2, 3, 4)) == 1000).all() and got.sum() == len(events)
    first = np.zeros((2, 2, 61, 83), int)
    np.add.at(first, tuple(events[:1000][n] for n in ("channel", "p", "y", "x")), 1)
    assert np.array_equal(got[0], first)
    last = amacrine.events.event_frames(events, 1000, size=(61, 83), fill="last")
    assert set(np.unique(last)) == {-1, 0, 1}
    none = np.zeros(0, amacrine.EVENT)
    assert amacrine.events.event_frames(none, 5, size=(4, 6)).shape == (0, 1, 4, 6)
    assert not amacrine.events.voxels(none, bins=3, size=(4, 6)).any()


def _written(
    program: Callable[..., str], file: Path, name: str, to: str, how: list[str]
) -> np.ndarray[Any, np.dtype[Any]]:
    """The array that the command line writes of a file of events, as .npy or .npz."""
    out = file.with_name(f"array.{to}")
    program("voxels", file, "-o", out, "--as", name, *how)
    loaded = np.load(out)
    return loaded if to == "npy" else loaded[name]  # type: ignore[no-any-return]


@pytest.mark.parametrize("to, half", [("npy", False), ("npz", False), ("npy", True), ("npz", True)])
def test_the_command_line_writes_the_same(
    program: Callable[..., str], tmp_path: Path, frames: Frames, to: str, half: bool
) -> None:
    """Voxels, time surfaces and event frames of a file, to the bit, but for the axis of sides."""
    events = amacrine.Sensor(kernels(2), 2.0).events(frames, FPS)
    file = tmp_path / "events.npy"
    amacrine.write(file, events)
    number = np.float16 if half else np.float32
    bits = ["--half"] if half else []
    times = [0.013 * n for n in range(1, 9)]
    assert events.span is not None and events["t"][-1] * 1e-6 < events.span[1] < times[-1]
    for polarity in ("signed", "split"):
        both: dict[str, Any] = {"polarity": polarity}
        sides = ["--polarity", polarity, *bits]

        def same(name: str, how: list[str], want: np.ndarray[Any, np.dtype[Any]]) -> None:
            got = _written(program, file, name, to, [*how, *sides])
            assert want.any() and got.dtype == number
            whole = want if polarity == "split" else np.expand_dims(want, 2)
            assert np.array_equal(got, whole.astype(number))
            assert got.tobytes() == whole.astype(number).tobytes()

        voxels = amacrine.events.voxels(events, bins=4, window=0.02, **both)
        same("voxels", ["--bins", "4", "--window", "20ms"], voxels)
        for decay in ("exponential", "linear"):
            surfaces = amacrine.events.time_surfaces(events, times, tau=0.03, decay=decay, **both)
            how = ["--every", "13ms", "--tau", "30ms", "--decay", decay]
            same("surfaces", how, surfaces)
        for fill in ("count", "last"):
            pictures = amacrine.events.event_frames(events, 700, fill=fill, **both)
            same("frames", ["--count", "700", "--fill", fill], pictures)
    # What stands where nothing is said is the same, too.
    plain = amacrine.events.time_surfaces(events, times, tau=0.03).astype(number)
    assert np.array_equal(
        _written(program, file, "surfaces", to, ["--every", "13ms", "--tau", "30ms", *bits]), plain
    )


def test_a_recording_that_begins_late(frames: Frames) -> None:
    sensor = amacrine.Sensor("csdvs-3", 0.2)
    events = sensor.events(frames, FPS)
    late = events.copy()
    late["t"] += 10**9
    how: dict[str, Any] = {"bins": 4, "window": 0.03, "size": (61, 83)}
    want = amacrine.events.voxels(events, **how)
    assert np.array_equal(amacrine.events.voxels(late, start=1000.0, **how), want)
    # A recording of a clock: what there is no room for names the way out.
    late["t"] += 10**15
    with pytest.raises(amacrine.Error, match="before the first event: give a later `start`"):
        amacrine.events.voxels(late, **how)


@pytest.mark.parametrize("share", ["bilinear", "whole"])
@pytest.mark.parametrize("bins", [1, 5])
def test_a_recording_that_begins_at_0_keeps_its_first_events(bins: int, share: str) -> None:
    events = np.array([(0, 1, 0, 1), (0, 2, 0, 0), (40, 1, 1, 1), (90, 0, 1, 1)], amacrine.EVENT)
    for window in (None, 30e-6, 90e-6):
        voxels = amacrine.events.voxels(
            events, bins=bins, window=window, share=share, polarity="split"
        )
        assert voxels.sum() == pytest.approx(4), window
        assert voxels[0, 0, 1, 0, 0, 1] == 1 and voxels[0, 0, 0, 0, 0, 2] == 1
    later = amacrine.events.voxels(events, bins=1, start=40e-6, polarity="split")
    assert later.sum() == pytest.approx(2)


def test_what_half_precision_does_not_hold_is_refused() -> None:
    many = np.zeros(70000, amacrine.EVENT)
    many["p"] = 1
    with pytest.raises(amacrine.Error, match="70000 events is beyond float16"):
        amacrine.events.voxels(many, bins=1, dtype=np.float16, size=(2, 2))
    assert amacrine.events.voxels(many, bins=1, size=(2, 2)).max() == 70000


def test_a_whole_clip_of_less_than_a_microsecond_is_a_window(frames: Frames) -> None:
    sensor = amacrine.Sensor("dvs", 0.1)
    voxels = sensor.voxels(frames, 1e9, bins=2)
    assert voxels.shape == (1, 1, 2, 61, 83) and voxels.sum() == sensor.counts(frames, 1e9).sum() != 0


@pytest.mark.parametrize("window, told", [(40_000.0, True), (50.0, True), (1.0, False), (0.1, False)])
def test_a_window_beside_which_a_clip_is_nothing_is_told_of(window: float, told: bool) -> None:
    """Microseconds in the place of seconds; not of few events in a usual window."""
    clip = np.random.default_rng(3).integers(0, 255, (12, 8, 9)).astype(np.uint8)
    events = amacrine.Sensor("dvs", 0.2).events(clip, 25)
    all: list[Callable[[], Any]] = [
        lambda: amacrine.Sensor("dvs", 0.2).voxels(clip, 25, bins=2, window=window),
        lambda: amacrine.events.voxels(events, bins=2, window=window),
        lambda: list(amacrine.Sensor("dvs", 0.2).voxel_windows([clip], 25, bins=2, window=window)),
    ]
    for watch in all:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            watch()
        assert any("give window in seconds" in str(one.message) for one in said) == told
    few = np.zeros(2, amacrine.EVENT)
    few["t"] = 0, 300
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        amacrine.events.voxels(few, bins=2, window=0.05)
        amacrine.events.voxels(few[:1], bins=2, window=9.0)


OF_EVENTS = """
events = np.zeros(3, amacrine.EVENT)
voxels = amacrine.events.voxels(events, bins=25, window=1.0, size=(512, 1024), {})
"""
OF_FRAMES = """
frames = np.random.default_rng(0).integers(0, 255, (4, 256, 512), dtype=np.uint8)
voxels = amacrine.Sensor("dvs", 0.5).voxels(frames, 30, {})
"""
HOLDS = """
import numpy as np, amacrine
from amacrine import _amacrine

def peak():
    return int(open("/proc/self/status").read().split("VmHWM:")[1].split()[0]) * 1024

room, said = _amacrine.check_room, []
def check_room(what, bytes, beside, help):
    said.append(bytes + beside)
    room(what, bytes, beside, help)
_amacrine.check_room = check_room
amacrine.set_threads(2)
before = peak()
%s
print(peak() - before, sum(said), voxels.nbytes)
"""


def _held(what: str) -> list[int]:
    """The most that was held more than before, what was asked for, and what came of it, in bytes."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", HOLDS % what], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return [int(one) for one in done.stdout.split()]


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs what Linux tells")
def test_what_voxels_hold_is_asked_for() -> None:
    """One window is made in place; whatever else is held is a part of what is asked for."""
    held, _, made = _held(OF_EVENTS.format(""))
    assert made == 25 * 512 * 1024 * 4 and held < 1.2 * made
    held, _, made = _held(OF_EVENTS.format("dtype=np.float16"))
    assert held < 1.2 * 3 * made
    for how in (
        "bins=100", "bins=50, normalise='std'", "bins=50, dtype=np.float16", "bins=25, window=0.02",
        "bins=25, window=0.1, every=0.02", "bins=25, window=0.02, upsample=0.3", "dtype=np.float64",
    ):
        held, asked, made = _held(OF_FRAMES.format(how))
        # Events, and what the interpreter takes, are not asked for.
        assert made / 2 < held < asked + (64 << 20), how
        assert asked < 4.1 * made, how
