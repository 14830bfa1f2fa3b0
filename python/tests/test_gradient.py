"""Gradients in Python: those of the released simulator, of differences, and of the reference."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import amacrine
import numpy as np
import pytest
from amacrine import gradient
from conftest import ROOT, Frames, kernels

ORACLE = ROOT / "tests/oracle"
EVENT = 1e-3
"""What the released test adds to its loss for each event."""

RELEASED = sorted(
    path
    for path in ORACLE.glob("*/lrgc*.npz")
    if not any(word in path.name for word in ("oldmem", "svk", "svt", "norm", "logtemporal"))
)


def _sensor(of: Any, zero: bool) -> amacrine.Sensor:
    return amacrine.Sensor(
        of["kernel"],
        [(on[0, 0], off[0, 0]) for on, off in zip(of["pos_thres"], of["neg_thres"])],
        response="identity",
        border="zero" if zero else "replicate",
        refractory={"us": float(of["refractory_s"]) * 1e6, "rule": "authors"},
    )


@pytest.mark.parametrize("path", RELEASED, ids=lambda p: f"{p.parent.name}-{p.stem}")
def test_the_released_gradients_are_met(path: Path) -> None:
    of = np.load(path)
    if "loss_weight" not in of:
        pytest.skip("a file without gradients")
    weight = of["loss_weight"].astype(np.float64)
    pairs = len(weight)
    frames = of["input"].astype(np.float64)[: pairs + 1]
    sensor = _sensor(of, "zeropad" in path.name)
    seen = gradient.forward(sensor, frames, times=of["t"][: pairs + 1], scale=1, dtype="f8")
    # In the stored tensor each inner bin stands twice.
    asked = np.zeros((pairs + 1, *weight.shape[1:2], *weight.shape[3:]))
    for side in range(2):
        asked[side : side + pairs] += weight[:, :, side]
    back = seen.backward(asked, events=EVENT, rule="authors", slope="fired")
    theirs = of["grad_current_kernel_weight"][:, 0]
    ours = np.stack(back.kernels)
    assert ours.shape == theirs.shape
    np.testing.assert_allclose(ours, theirs, atol=1e-6 * np.abs(theirs).max())


def test_there_are_released_gradients() -> None:
    assert sum("loss_weight" in np.load(path) for path in RELEASED) >= 30


@pytest.mark.parametrize("dtype", ["f4", "f8"])
@pytest.mark.parametrize("memory", ["filtered-step", "filtered-snap"])
def test_forward_is_the_sensor(dtype: str, memory: str, frames: Frames) -> None:
    sensor = amacrine.Sensor(kernels(3), 0.3, memory=memory, format="f32" if dtype == "f4" else "f64")
    batch = np.stack([frames, frames[::-1]])[:, :, None]
    seen = gradient.forward(sensor, batch, 120, dtype=dtype)
    assert seen.voxels.dtype == np.dtype(dtype)
    assert np.array_equal(seen.counts, sensor.counts(batch, 120)) and seen.counts.any()
    assert seen.events == np.abs(seen.counts).sum()
    np.testing.assert_allclose(seen.voxels, sensor.voxels(batch, 120), atol=1e-5)
    one = gradient.forward(sensor, frames, 120, dtype=dtype)
    assert np.array_equal(one.voxels, seen.voxels[0])


def _without_counts(
    seen: gradient.Forward, weights: np.ndarray[Any, Any]
) -> np.ndarray[Any, Any]:
    """What to ask of the counts of two frames so that what stands for the derivative of a number of
    events comes to 0, and the true derivative of times at a fixed number is left.

    Of `N` events of a line from the memory the later bin has `L = N (N + 1) / (2 r)`, and the rules
    take `dN = dr`: with `g = -G_e - (G_l - G_e) (N + 1/2) / r` that term vanishes, and with
    `g = -G_l` that of a silent cell."""
    earlier, later = weights
    number, share = np.abs(seen.counts[0]), np.abs(seen.voxels[1])
    r = np.where(number > 0, number * (number + 1) / (2 * np.where(number > 0, share, 1)), 1)
    fired = -earlier - (later - earlier) * (number + 0.5) / r
    asked: np.ndarray[Any, Any] = np.where(number > 0, fired, -later)[np.newaxis]
    return asked


@pytest.mark.parametrize("rule", ["through", "reset"])
@pytest.mark.parametrize("response", ["identity", {"linear": 255}, {"lin-log": {"knee": 20}}])
def test_differences_where_no_event_comes_or_goes(rule: Any, response: Any) -> None:
    random = np.random.default_rng(3)
    frames = random.uniform(30, 255, (2, 7, 9))
    weights = random.normal(size=(2, 2, 7, 9))
    limits = np.array([[0.31, 0.42], [0.27, 0.35]])
    limits *= 255 if response == "identity" else 1
    start = kernels(2, 3)[:, 0]

    def watch(kernel: Any, limit: Any, light: Any) -> gradient.Forward:
        sensor = amacrine.Sensor(kernel, list(map(tuple, limit)), response=response)
        return gradient.forward(sensor, light, 30, scale=1, dtype="f8")

    base = watch(start, limits, frames)
    assert np.abs(base.counts).max() > 2
    back = base.backward(weights, _without_counts(base, weights), rule=rule, light=True)
    assert back.light is not None
    ours = {
        "kernels": np.stack(back.kernels),
        "thresholds": np.stack([np.concatenate(pair) for pair in zip(back.on, back.off)]),
        "light": back.light,
    }
    compared = 0
    for which, (name, gradients) in enumerate(ours.items()):
        for place in np.ndindex(gradients.shape):
            given = [start, limits, frames]
            step = 1e-6 * max(abs(float(given[which][place])), 0.1)
            sides = []
            for way in (1, -1):
                moved = given[which].copy()
                moved[place] += way * step
                other = watch(*[*given[:which], moved, *given[which + 1 :]])
                if not np.array_equal(other.counts, base.counts):
                    break
                sides.append(float((other.voxels * weights).sum()))
            if len(sides) < 2:
                continue
            compared += 1
            difference = (sides[0] - sides[1]) / (2 * step)
            most = np.abs(gradients).max()
            assert gradients[place] == pytest.approx(difference, abs=1e-6 * most), (name, place)
    assert compared > 120


def test_the_gradient_of_a_count_follows_the_phase() -> None:
    """Averaged over phases the number of events is smooth: `mean` is its slope by the threshold."""
    random = np.random.default_rng(8)
    texture = np.cumsum(random.normal(size=(30, 60)), 1)
    texture = 40 + 170 * (texture - texture.min()) / np.ptp(texture)
    frames = np.stack([texture[4:24, 2 * n : 2 * n + 24] for n in range(9)])
    weights = np.array([[0, -0.2, 0], [-0.2, 1.0, -0.2], [0, -0.2, 0]])
    phases = np.arange(16) / 16

    def events(threshold: float) -> tuple[float, float]:
        sensor = amacrine.Sensor(weights, threshold)
        of = [gradient.forward(sensor, frames, 30, scale=1, dtype="f8", phase=p) for p in phases]
        back = [seen.backward(events=1.0, rule="mean") for seen in of]
        slope = sum(float(b.on[0][0] + b.off[0][0]) for b in back)
        return float(sum(seen.events for seen in of)), slope

    low, high, (_, slope) = events(0.045)[0], events(0.055)[0], events(0.05)
    difference = (high - low) / 0.01
    assert difference < 0
    assert slope == pytest.approx(difference, rel=0.1)


def test_any_number_of_threads(frames: Frames) -> None:
    sensor = amacrine.Sensor(kernels(3), 0.3)
    large = np.tile(frames, (1, 3, 2))
    before, said = amacrine.threads(), []
    try:
        for threads in (1, 2, 5):
            amacrine.set_threads(threads)
            seen = gradient.forward(sensor, large, 120)
            back = seen.backward(np.cos(seen.voxels), events=0.1, light=True)
            assert back.light is not None
            said.append((seen.voxels.tobytes(), [k.tobytes() for k in back.kernels],
                         [t.tobytes() for t in back.on + back.off], back.light.tobytes()))
    finally:
        amacrine.set_threads(before)
    assert said[0] == said[1] == said[2]


def test_kernels_of_several_sizes_have_gradients(frames: Frames) -> None:
    sensor = amacrine.Sensor.from_file("mosaic")
    made = gradient.forward(sensor, frames, 50)
    assert repr(made).startswith("<Forward: voxels (12, ") and made.events > 0
    back = made.backward(events=1.0)
    assert [own.shape for own in back.kernels] == [own.shape for own in sensor.kernels]
    for own, of in zip(back.kernels, sensor.kernels):
        # Only what a kernel has is learned: not the zeros around a smaller one.
        small = [kernel for kernel in of if np.count_nonzero(kernel) == 1]
        assert len(of) == 4 and bool(small)
        for kernel, slope in zip(of, own):
            if np.count_nonzero(kernel) == 1:
                assert np.count_nonzero(slope) <= 1


def test_patterns_have_gradients(frames: Frames) -> None:
    four = "[" + ", ".join(["[[0.0, -1.0, 0.0], [-1.0, 4.0, -1.0], [0.0, -1.0, 0.0]]"] * 4) + "]"
    text = (
        'response = { linear = 255 }\nmemory = "filtered-step"\n[[channel]]\npattern = "2x2"\n'
        f"kernel = {four}\nthreshold = [{', '.join(['{ on = 0.3, off = 0.4 }'] * 4)}]\n"
    )
    sensor = amacrine.Sensor.from_text(text)
    assert sensor.kernels[0].shape == (4, 3, 3)
    back = gradient.forward(sensor, frames, 120).backward(events=1.0)
    assert back.kernels[0].shape == (4, 3, 3) and back.kernels[0].any()


def test_of_no_clip_there_is_nothing() -> None:
    """As of `Sensor.counts`, and of the layer."""
    made = gradient.forward(_plain(), np.zeros((0, 3, 1, 8, 9), np.uint8), 30)
    assert made.voxels.shape == (0, 3, 1, 8, 9) and made.counts.shape == (0, 2, 1, 8, 9)
    back = made.backward(made.voxels, made.counts, events=1.0, light=True)
    assert made.events == 0 and not back.kernels[0].any()
    assert back.light is not None and back.light.shape == (0, 3, 8, 9)


def _any(of: Any) -> Any:
    """What the types do not let through."""
    return of


MISTAKES: dict[str, tuple[Any, str]] = {
    "memory": (lambda f: _forward(f, memory="raw-snap"), "its memory holds pixels"),
    "noise": (lambda f: _forward(f, noise={"shot-hz": 5}), "noise in its cells"),
    "rate": (lambda f: gradient.forward(_plain(), f), "fps = None"),
    "rate and times": (lambda f: gradient.forward(_plain(), f, 9, times=[1]), "give one of them"),
    "times of text": (lambda f: gradient.forward(_plain(), f, times=_any("a")), "times = 'a'"),
    "phase": (lambda f: gradient.forward(_plain(), f, 9, phase=_any("a")), "phase = 'a'"),
    "a phase that is no number": (lambda f: gradient.forward(_plain(), f, 9, phase=float("nan")), "phase = nan"),
    "no sensor": (lambda f: gradient.forward(_any("dvs"), f, 9), "give a Sensor"),
    "no dtype": (lambda f: gradient.forward(_plain(), f, 9, dtype=_any("f9")), "float32 or float64"),
    "no array": (lambda f: _forward(f).backward(_any([[1], [1, 2]])), "no array"),
    "complex": (lambda f: _forward(f).backward(_any(1j * _forward(f).voxels)), "are complex64"),
    "counts of text": (lambda f: _forward(f).backward(counts=_forward(f).counts.astype(str)), "are <U"),
    "dtype of a table": (
        lambda f: gradient.forward(_plain(), f, 9, dtype=_any({"readout": "scan"})), "float32 or float64"
    ),
    "events of text": (lambda f: _forward(f).backward(events=_any("a")), "events = 'a'"),
    "times": (lambda f: gradient.forward(_plain(), f, times=[0, 1]), "2 times for 12 frames"),
    "order": (lambda f: gradient.forward(_plain(), f, times=[0] * 12), "frame 1 is at 0 s"),
    "dtype": (lambda f: gradient.forward(_plain(), f, 9, dtype="f2"), "float32 or float64"),
    "few": (lambda f: gradient.forward(_plain(), f[:1], 9), "at least two frames"),
    "rule": (lambda f: _forward(f).backward(events=1, rule=_any("straight")), "no rule of the gradient"),
    "slope": (lambda f: _forward(f).backward(events=1, slope=_any("some")), "is no slope"),
    "shape": (lambda f: _forward(f).backward(np.zeros(3)), "of shape (3,)"),
    "events inf": (
        lambda f: _forward(f).backward(events=np.inf), "the gradient of the number of events is inf"
    ),
    "events nan": (
        lambda f: _forward(f).backward(events=np.nan), "the gradient of the number of events is NaN"
    ),
    "nan": (lambda f: _nan(f), "has NaN at [0, 0, 0, 0, 0]"),
    "mean": (
        lambda f: _forward(f, memory="filtered-snap").backward(events=1, rule="mean"),
        "a memory that steps",
    ),
}


def _plain(**options: Any) -> amacrine.Sensor:
    return amacrine.Sensor("csdvs-3", 0.2, **options)


def _forward(frames: Frames, **options: Any) -> gradient.Forward:
    return gradient.forward(_plain(**options), frames, 120)


def _nan(frames: Frames) -> gradient.Gradient:
    seen = _forward(frames)
    return seen.backward(np.full(seen.voxels.shape, np.nan))


@pytest.mark.parametrize("which", MISTAKES)
def test_mistakes(which: str, frames: Frames) -> None:
    what, words = MISTAKES[which]
    with pytest.raises(amacrine.Error) as told:
        what(frames)
    assert words in str(told.value), str(told.value)
