"""A sensor as a layer of PyTorch, and its data set. Skipped where torch is not installed; `.ci/torch`
installs it."""

from __future__ import annotations

import copy
import io
import pickle
import warnings
import weakref
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import amacrine
import numpy as np
import pytest
from amacrine import gradient
from conftest import Frames, kernels

torch = pytest.importorskip("torch")

from amacrine.torch import EventDataset, EventSensor, event_sensor  # noqa: E402
from torch.autograd.graph import save_on_cpu, saved_tensors_hooks  # noqa: E402
from torch.utils.checkpoint import checkpoint  # noqa: E402


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("memory", ["filtered-step", "filtered-snap"])
def test_it_is_the_sensor_that_it_becomes(dtype: str, memory: str, frames: Frames) -> None:
    batch = np.stack([frames, frames[::-1]])[:, :, None]
    layer = EventSensor(
        torch.from_numpy(kernels(3)), [0.3, (0.3, 0.5), 0.4], fps=120, memory=memory,
        mismatch=0.1, seed=4, refractory=500 if memory == "filtered-step" else None,
        dtype=getattr(torch, dtype), names=["a", "b", "c"], name="layer",
    )
    seen = layer(torch.from_numpy(batch))
    assert seen.voxels.shape == (2, 12, 3, 61, 83) and seen.voxels.dtype == layer.kernels.dtype
    sensor = layer.to_sensor()
    assert sensor.channels == ["a", "b", "c"] and sensor.name == "layer"
    counts = sensor.counts(batch, 120)
    assert np.array_equal(seen.counts.detach().numpy(), counts) and counts.any()
    assert float(seen.events.detach()) == np.abs(counts).sum()
    want = sensor.voxels(batch, 120)
    np.testing.assert_allclose(seen.voxels.detach().numpy(), want, atol=1e-5)
    one = layer(torch.from_numpy(batch[0]))
    assert torch.equal(one.voxels, seen.voxels[0]) and torch.equal(one.counts, seen.counts[0])
    again = EventSensor.from_sensor(sensor, fps=120, dtype=layer.kernels.dtype)
    assert torch.equal(again.kernels, layer.kernels)
    assert layer.to_sensor("other").name == "other"


def test_it_begins_as_the_sensor_that_it_is_given(frames: Frames) -> None:
    """Thresholds that single precision does not hold, mismatch, a seed, and tables in any order."""
    text = """
name = "x [[channel]] y"
memory = "filtered-snap"
response = { linear = 255 }

[[ channel ]]
kernel = "csdvs-3"
threshold = { on = 0.1, off = 0.13, sigma = 0.02 }

[refractory]   # [[channel]]
us = 20000
"""
    sensor = amacrine.Sensor.from_text(text, seed=9)
    counts = sensor.counts(frames, 120)
    layer = EventSensor.from_sensor(sensor, fps=120, dtype=torch.float64)
    np.testing.assert_allclose(layer.thresholds.detach().numpy(), [[0.1, 0.13]], rtol=1e-15)
    seen = layer(torch.from_numpy(frames)).counts.detach().numpy()
    assert counts.any() and np.array_equal(seen, counts)
    for again in (layer.to_sensor(), layer.to_sensor("other")):
        assert np.array_equal(again.counts(frames, 120), counts)
    two = amacrine.Sensor(kernels(2), [{"on": 0.3, "off": 0.3, "sigma": 0.1}, 0.3])
    with pytest.raises(amacrine.Error, match="give one for all"):
        EventSensor.from_sensor(two, fps=120)
    assert EventSensor.from_sensor(two, fps=120, mismatch=0.1).mismatch == 0.1
    with pytest.raises(amacrine.Error, match="more than kernels"):
        EventSensor.from_sensor(amacrine.Sensor.from_file("mosaic"), fps=120)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_its_thresholds_are_those_that_were_given_to_the_bit(dtype: Any) -> None:
    """A step of light by a whole threshold decides the same in both."""
    for first in range(1, 256, 15):
        given = [float(n) for n in range(first, first + 15)]
        sensor = amacrine.Sensor(["dvs"] * 15, given, response="identity", memory="filtered-snap")
        layer = EventSensor.from_sensor(sensor, fps=10, dtype=dtype)
        assert layer.thresholds[:, 0].tolist() == given
        assert [own[0] for own in layer.to_sensor().thresholds] == given
        steps = np.zeros((2, 1, 255), np.uint8)
        steps[1, 0] = np.arange(1, 256)
        seen = layer(torch.from_numpy(steps)).counts.detach().numpy()
        assert np.array_equal(seen, sensor.counts(steps, 10))
    # They are learned as before.
    torch.autograd.backward(layer.thresholds.sum())
    torch.testing.assert_close(layer.log_thresholds.grad, layer.thresholds.detach())
    with torch.no_grad():
        layer.log_thresholds.add_(0.5)
    torch.testing.assert_close(layer.thresholds, layer.log_thresholds.exp(), rtol=0, atol=0)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_its_mismatch_is_that_which_was_given_to_the_bit(dtype: Any) -> None:
    """A share of the thresholds, times the thresholds, is often the number beside it."""
    random = np.random.default_rng(7)
    for n in range(100):
        on, off, part = random.uniform(0.05, 0.5, 3)
        limits = {"on": on, "off": off, "sigma": part * on}
        sensor = amacrine.Sensor(["dvs"], [limits], seed=n, format="f64")
        layer = EventSensor.from_sensor(sensor, fps=10, dtype=dtype)
        made = layer.to_sensor()
        assert made.thresholds[0][2] == limits["sigma"]
        again = EventSensor.from_sensor(made, fps=10, dtype=dtype)
        other = EventSensor.from_sensor(made, fps=10, dtype=dtype)
        other.load_state_dict(layer.state_dict())
        assert made == again.to_sensor() == other.to_sensor() == copy.deepcopy(layer).to_sensor()
        # Learned, it is a share of the thresholds.
        with torch.no_grad():
            layer.log_thresholds.add_(0.25)
        learned = layer.to_sensor()
        mean = learned.thresholds[0][:2].mean()
        assert learned.thresholds[0][2] == layer.mismatch * mean
        again = EventSensor.from_sensor(learned, fps=10, dtype=dtype)
        assert again.to_sensor() == learned
        own = EventSensor(["dvs", "csdvs-3"], [(on, off), off], fps=10, mismatch=round(part, 3), dtype=dtype)
        again = EventSensor.from_sensor(own.to_sensor(), fps=10, dtype=dtype)
        assert (again.mismatch, again.to_sensor()) == (own.mismatch, own.to_sensor())
        # Whoever says another has that.
        layer.mismatch = 0.5
        assert layer.to_sensor().thresholds[0][2] == 0.5 * mean


@pytest.mark.parametrize("way", ["double", "float", "load wide", "load narrow", "there and back"])
def test_thresholds_that_were_not_learned_stay_in_another_dtype(way: str) -> None:
    """Whole ones to the bit, others as the dtype rounds them; what was learned is moved as it is."""
    given = [(n / 8, 1 + n / 3) for n in range(1, 200)]
    for n in range(0, 192, 8):
        limits = given[n : n + 8]
        thin, wide = (
            EventSensor(["dvs"] * 8, limits, fps=10, dtype=dtype) for dtype in (torch.float32, torch.float64)
        )
        if way == "double":
            moved, want = copy.deepcopy(thin).double(), thin.thresholds.double()
        elif way == "float":
            moved, want = copy.deepcopy(wide).float(), wide.thresholds.float()
        elif way == "load wide":
            wide.load_state_dict(thin.state_dict())
            moved, want = wide, thin.thresholds.double()
        elif way == "load narrow":
            want = wide.thresholds.float()
            thin.load_state_dict(wide.state_dict())
            moved = thin
        else:
            moved, want = copy.deepcopy(wide).float().double(), wide.thresholds.float().double()
        assert torch.equal(moved.thresholds, want)
        assert torch.equal(moved.thresholds[:, 0].double(), torch.tensor(limits).double()[:, 0])
        with torch.no_grad():
            moved.log_thresholds.add_(1e-9 if moved.kernels.dtype == torch.float64 else 1e-5)
        assert torch.equal(moved.thresholds, moved.log_thresholds.exp())


def test_what_no_layer_begins_as() -> None:
    for wrong in ("rgc-4", amacrine.Sensor("dvs", 0.1, format="q8.8")):
        with pytest.raises(amacrine.Error, match="give "):
            EventSensor.from_sensor(wrong, fps=10)  # type: ignore[arg-type]
    layer = EventSensor("dvs", 0.1, fps=10, scale=255)
    clip = np.random.default_rng(0).integers(0, 2, (4, 8, 8)).astype(bool)
    both = [layer(frames).counts for frames in (torch.from_numpy(clip), clip, clip[:, ::-1, ::-1][:, ::-1, ::-1])]
    assert both[0].any() and all(torch.equal(one, both[0]) for one in both)
    turned = [layer(clip.astype(dtype)).counts for dtype in (">f4", ">u2", "f2", ">f8")]
    assert all(torch.equal(one, both[0]) for one in turned)
    light = torch.from_numpy(clip).float()
    for odd, told in (
        ("clip.mp4", "no light"),
        (clip.astype(object), "dtype object are no light"),
        (np.ma.masked_array(clip), "whose mask would be ignored"),
        (light.to_sparse(), "a tensor that is sparse"),
        (light.to("meta"), "a tensor without memory"),
    ):
        with pytest.raises(amacrine.Error, match=told):
            layer(odd)
    text = EventSensor("dvs", 0.1, fps=10, mismatch=0.1, seed=7).to_sensor().text
    assert "--seed 7" in text and "seed" not in layer.to_sensor().text


def test_kernels_of_several_sizes_have_zeros_round_them(frames: Frames) -> None:
    sensor = amacrine.Sensor(["dvs", "csdvs-5"], 0.1, memory="filtered-snap")
    layer = EventSensor.from_sensor(sensor, fps=120, dtype=torch.float64)
    assert layer.kernels.shape == (2, 5, 5)
    counts = sensor.counts(frames, 120)
    seen = layer(torch.from_numpy(frames)).counts.detach().numpy()
    assert counts.any() and np.array_equal(seen, counts)


@pytest.mark.parametrize("rule", ["through", "reset", "authors", "mean"])
def test_its_gradients_are_those_of_the_model(rule: Any, frames: Frames) -> None:
    layer = EventSensor(kernels(2), 0.3, fps=120, rule=rule, dtype=torch.float64)
    light = torch.tensor(frames, dtype=torch.float64, requires_grad=True)
    layer.scale = 1.0
    seen = layer(light)
    weight = torch.cos(torch.arange(seen.voxels.numel(), dtype=torch.float64)).reshape_as(seen.voxels)
    ask = torch.sin(torch.arange(seen.counts.numel(), dtype=torch.float64)).reshape_as(seen.counts)
    loss = (seen.voxels * weight).sum() + (seen.counts * ask).sum() + 0.3 * seen.events
    loss.backward()
    model = gradient.forward(layer.to_sensor(), frames, 120, dtype="f8")
    want = model.backward(weight.numpy(), ask.numpy(), events=0.3, rule=rule, light=True)
    assert torch.equal(layer.kernels.grad, torch.from_numpy(np.stack(want.kernels)))
    limits = torch.tensor([[on[0], off[0]] for on, off in zip(want.on, want.off)])
    chained = limits.double() * layer.thresholds.detach()
    torch.testing.assert_close(layer.log_thresholds.grad, chained)
    assert want.light is not None and light.grad is not None
    assert torch.equal(light.grad, torch.from_numpy(want.light)) and bool(light.grad.any())


def test_gradcheck_where_no_event_comes_or_goes() -> None:
    """PyTorch's own check, on a loss from which what stands for the derivative of a number of events
    is taken out (`test_gradient.py` says how)."""
    from test_gradient import _without_counts

    random = np.random.default_rng(3)
    frames = torch.from_numpy(random.uniform(30, 255, (2, 5, 6))).requires_grad_()
    layer = EventSensor(kernels(1, 3), 0.31, fps=30, scale=1, dtype=torch.float64)
    weights = random.normal(size=(2, 1, 5, 6))
    base = gradient.forward(layer.to_sensor(), frames.detach().numpy(), 30, scale=1, dtype="f8")
    ask = torch.from_numpy(_without_counts(base, weights))
    counts = torch.from_numpy(base.counts).double()

    def loss(kernel: Any, logs: Any, light: Any) -> Any:
        parameters = {"kernels": kernel, "log_thresholds": logs}
        seen = torch.func.functional_call(layer, parameters, (light,))
        assert torch.equal(seen.counts, counts)
        return (seen.voxels * torch.from_numpy(weights)).sum() + (seen.counts * ask).sum()

    given = [it.detach().clone().requires_grad_() for it in (layer.kernels, layer.log_thresholds)]
    assert torch.autograd.gradcheck(loss, (*given, frames), eps=1e-7, atol=1e-5, rtol=1e-5)


@pytest.mark.parametrize("optimiser", ["SGD", "Adam", "LBFGS"])
def test_it_learns(optimiser: str) -> None:
    """Kernels and thresholds that make the voxels of another sensor, from its events alone."""
    random = np.random.default_rng(2)
    texture = np.cumsum(np.cumsum(random.normal(size=(50, 90)), 0), 1)
    texture = 20 + 200 * (texture - texture.min()) / np.ptp(texture)
    frames = torch.from_numpy(
        np.stack([texture[n : n + 24, 2 * n : 2 * n + 32] for n in range(10)]).astype("u1")
    )
    teacher = EventSensor(kernels(1, 3) * 3, 0.05, fps=30)
    with torch.no_grad():
        want = teacher(frames).voxels
    start = teacher.kernels.detach().numpy() * 0.8 + 0.02 * random.normal(size=(1, 3, 3))
    layer = EventSensor(start, 0.06, fps=30, rule="through")
    rate = {"SGD": 3e-2, "Adam": 5e-3, "LBFGS": 0.02}[optimiser]
    steps = torch.optim.__dict__[optimiser](layer.parameters(), lr=rate)
    losses: list[float] = []

    def step() -> Any:
        steps.zero_grad()
        loss = (layer(frames).voxels - want).square().mean()
        loss.backward()
        losses.append(float(loss.detach()))
        return loss

    for _ in range(30):
        steps.step(step)
    assert min(losses) < 0.5 * losses[0], losses


def test_state_goes_round(frames: Frames) -> None:
    layer = EventSensor(kernels(2), 0.3, fps=120)
    with torch.no_grad():
        layer.kernels.add_(0.01)
    file = io.BytesIO()
    torch.save(layer.state_dict(), file)
    file.seek(0)
    other = EventSensor(kernels(2) * 0, 0.5, fps=120)
    other.load_state_dict(torch.load(file))
    given = torch.from_numpy(frames)
    want = layer(given).voxels
    for same in (other, copy.deepcopy(layer), pickle.loads(pickle.dumps(layer))):
        assert torch.equal(same(given).voxels, want)
    assert set(layer.state_dict()) == {"kernels", "log_thresholds", "given_thresholds", "given_log_thresholds"}


def test_the_same_on_any_number_of_threads(frames: Frames) -> None:
    large = torch.from_numpy(np.tile(frames, (1, 3, 2)))
    before, said = amacrine.threads(), []
    try:
        for threads in (1, 3):
            amacrine.set_threads(threads)
            layer = EventSensor(kernels(3), 0.3, fps=120)
            seen = layer(large)
            (seen.voxels.square().sum() + seen.events).backward()
            assert layer.kernels.grad is not None and layer.log_thresholds.grad is not None
            said.append((layer.kernels.grad.numpy().tobytes(),
                         layer.log_thresholds.grad.numpy().tobytes()))
    finally:
        amacrine.set_threads(before)
    assert said[0] == said[1]


def _any(of: Any) -> Any:
    """What the types do not let through."""
    return of


MISTAKES: dict[str, tuple[Any, str]] = {
    "scale": (lambda f: EventSensor("dvs", 0.1, fps=9)(f / 255), "scale=255"),
    "axes": (lambda f: EventSensor("dvs", 0.1, fps=9)(f[0]), "(T,H,W), (T,1,H,W)"),
    "one frame": (lambda f: EventSensor("dvs", 0.1, fps=9)(f[:1]), "at least two frames"),
    "rule": (lambda f: EventSensor("dvs", 0.1, fps=9, rule=_any("ste")), "no rule of the gradient"),
    "rate": (lambda f: EventSensor("dvs", 0.1, fps=0), "no rate"),
    "dtype": (lambda f: EventSensor("dvs", 0.1, fps=9, dtype=torch.float16), "torch.float32"),
    "half": (lambda f: EventSensor("dvs", 0.1, fps=9).half()(f), "a sensor in torch.float16"),
    "brain": (lambda f: EventSensor("dvs", 0.1, fps=9).bfloat16()(f), "a sensor in torch.bfloat16"),
    "mismatch": (lambda f: EventSensor("dvs", 0.1, fps=9, mismatch=_any("a")), "mismatch = 'a'"),
    "scale of text": (lambda f: EventSensor("dvs", 0.1, fps=9, scale=_any("a")), "scale = 'a'"),
    "memory": (lambda f: EventSensor("dvs", 0.1, fps=9, memory="raw-snap")(f), "holds pixels"),
    "diverged": (lambda f: _diverged(f), "kernels must be finite"),
}


def _diverged(frames: Any) -> None:
    layer = EventSensor("csdvs-3", 0.1, fps=9)
    with torch.no_grad():
        layer.kernels[0, 1, 1] = torch.nan
    layer(frames)


@pytest.mark.parametrize("which", MISTAKES)
def test_mistakes(which: str, frames: Frames) -> None:
    what, words = MISTAKES[which]
    with pytest.raises(amacrine.Error) as told:
        what(torch.from_numpy(frames))
    assert words in str(told.value), str(told.value)


@pytest.mark.parametrize("rule", ["through", "reset", "mean"])
def test_mismatch_learns_with_the_thresholds(rule: Any, frames: Frames) -> None:
    """Kernels and thresholds scaled together, mismatch with them, change no event."""
    how: dict[str, Any] = dict(fps=60, rule=rule, dtype=torch.float64)
    layer = EventSensor(kernels(2, 3), {"on": 0.2, "off": 0.3, "sigma": 0.05}, **how)
    assert layer.mismatch == pytest.approx(0.2)
    seen = layer(torch.from_numpy(frames))
    (seen.voxels * torch.rand(seen.voxels.shape[-2:])).sum().backward()
    assert layer.kernels.grad is not None and layer.log_thresholds.grad is not None
    by_kernel = float((layer.kernels * layer.kernels.grad).sum())
    by_threshold = float(layer.log_thresholds.grad.sum())
    assert abs(by_kernel) > 1.0
    assert by_threshold == pytest.approx(-by_kernel, rel=1e-9)
    plain = EventSensor(kernels(2, 3), (0.2, 0.3), **how)
    assert not torch.equal(plain(torch.from_numpy(frames)).counts, seen.counts)


@pytest.mark.parametrize("of", ["voxels", "counts", "events", "a sum"])
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_gradient_that_is_not_finite_gives_nan_back(of: str, value: float, frames: Frames) -> None:
    """As a layer of PyTorch, so that what watches gradients sees it."""
    layer = EventSensor(kernels(2), 0.2, fps=60, scale=1)
    light = torch.from_numpy(frames).float().requires_grad_()
    seen = layer(light)
    # Of finite gradients a sum leaves the format.
    part, by = (seen.voxels, 1e38) if of == "a sum" else (getattr(seen, of), value)
    (part.sum() * by).backward()
    assert light.grad is not None
    for back in (layer.kernels.grad, layer.log_thresholds.grad, light.grad):
        assert back is not None and bool(back.isnan().all())


def test_a_scaler_of_gradients_skips_the_step_that_overflows(frames: Frames) -> None:
    layer = EventSensor(kernels(1), 0.2, fps=60)
    start = layer.kernels.detach().clone()
    steps = torch.optim.SGD(layer.parameters(), 1e-9)
    scaler = torch.amp.GradScaler("cpu", init_scale=2.0**120)
    scales = []
    for _ in range(3):
        steps.zero_grad()
        loss = layer(torch.from_numpy(frames)).voxels.square().sum()
        scaler.scale(loss).backward()
        scaler.step(steps)
        scaler.update()
        scales.append(scaler.get_scale())
        if len(scales) == 1:
            assert torch.equal(layer.kernels, start) and scales[0] == 2.0**119
            scaler.update(2.0**4)
    assert scales[1:] == [2.0**4] * 2 and not torch.equal(layer.kernels, start)
    assert bool(layer.kernels.isfinite().all())


def test_a_layer_is_made_on_the_default_device_and_works_under_any(frames: Frames) -> None:
    usual = EventSensor(kernels(2), 0.2, fps=60)
    given = torch.from_numpy(frames)
    seen = usual(given)
    (seen.voxels.square().sum() + seen.events).backward()
    with torch.device("meta"):
        layers = [
            EventSensor(kernels(2), 0.2, fps=60),
            EventSensor.from_sensor(amacrine.Sensor(kernels(2), 0.2), fps=60),
        ]
        # One that is elsewhere, with frames that are no tensor.
        other = EventSensor.from_sensor(amacrine.Sensor(kernels(2), 0.2), fps=60).to_empty(device="cpu")
        other.load_state_dict(usual.state_dict())
        again = other(frames)
        (again.voxels.square().sum() + again.events).backward()
    for layer in layers:
        assert {own.device.type for own in layer.state_dict().values()} == {"meta"}
        assert all(isinstance(own, torch.nn.Parameter) for own in (layer.kernels, layer.log_thresholds))
    assert again.voxels.device.type == "cpu" and torch.equal(again.voxels, seen.voxels)
    for name in ("kernels", "log_thresholds"):
        assert torch.equal(getattr(other, name).grad, getattr(usual, name).grad)


def test_a_layer_may_be_changed_in_place_and_given_nothing(frames: Frames) -> None:
    layer = EventSensor("csdvs-3", 0.2, fps=60)
    light = torch.from_numpy(frames)
    torch.nn.ReLU(inplace=True)(layer(light).voxels).sum().backward()
    first = layer.kernels.grad
    layer.zero_grad()
    torch.nn.ReLU()(layer(light).voxels).sum().backward()
    assert first is not None and layer.kernels.grad is not None
    assert torch.equal(first, layer.kernels.grad)
    clip = light if light.ndim == 5 else light.reshape(1, *light.shape[:1], 1, *light.shape[-2:])
    none = layer(clip[:0])
    assert none.voxels.shape == (0, *layer(clip).voxels.shape[1:])
    assert float(none.events) == 0.0


def test_what_no_clip_passes_is_told_by_the_layer() -> None:
    mistakes: list[tuple[dict[str, Any], str]] = [
        ({"rule": "mean", "memory": "filtered-snap"}, "filtered-step"),
        ({"memory": "raw-snap"}, "holds pixels"),
        ({"noise": {"shot-hz": 5}}, "noise in its cells"),
        ({"format": "f16"}, "no option format"),
        ({"phase": float("nan")}, "phase = nan"),
    ]
    for how, words in mistakes:
        with pytest.raises(amacrine.Error, match=words):
            EventSensor("csdvs-3", 0.2, fps=60, **how)


@pytest.fixture(scope="module")
def videos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("videos")
    random = np.random.default_rng(6)
    for n in range(3):
        texture = random.integers(0, 256, (80, 90)).astype(np.uint8)
        clip = np.stack([texture[t : t + 40, 2 * t : 2 * t + 48] for t in range(14 + n)])
        np.save(folder / f"clip{n}.npy", clip)
    return folder


def _dataset(videos: Path, **more: Any) -> EventDataset:
    how: dict[str, Any] = dict(
        frames=6, crop=(24, 32), kernels=[kernels(1, 3), -kernels(1, 3)], thresholds=(0.2, 0.6),
        quantisers=[None, "int-5"], sensors=4, voxels={"bins": 5}, fps=60, length=10, seed=3,
    )
    return EventDataset(videos, **{**how, **more})


def _equal(a: Any, b: Any) -> bool:
    return all(
        torch.equal(a[key], b[key]) if isinstance(a[key], torch.Tensor) else a[key] == b[key]
        for key in a
    )


def test_a_data_set_is_the_same_on_any_number_of_workers(videos: Path) -> None:
    data = _dataset(videos)
    assert len(data) == 10
    alone = [data[n] for n in range(10)]
    assert alone[0]["voxels"].shape == (1, 1, 5, 24, 32)
    assert alone[0]["frames"].shape == (6, 1, 24, 32)
    assert all(bool(item["voxels"].any()) for item in alone)
    kinds = {type(data.sensor(n)).__name__ for n in range(4)}
    assert kinds == {"Sensor", "ChipSensor"}
    assert len({(i["video"], i["start"], i["sensor"]) for i in alone}) > 5
    again = _dataset(videos)
    assert all(_equal(again[n], alone[n]) for n in reversed(range(10)))
    for workers in (0, 2):
        loader: Any = torch.utils.data.DataLoader(_dataset(videos), batch_size=2, num_workers=workers)
        batches = list(loader)
        assert len(batches) == 5
        for n, item in enumerate(alone):
            assert torch.equal(batches[n // 2]["voxels"][n % 2], item["voxels"])
    data.set_epoch(1)
    assert not all(_equal(data[n], alone[n]) for n in range(10))


def test_an_item_is_what_its_sensor_makes_of_its_frames(videos: Path) -> None:
    data = _dataset(videos, quantisers=[None], length=None, flips=False)
    assert len(data) == 3
    item = data[2]
    clip = np.load(data.videos[2])
    frames = item["frames"][:, 0].numpy()
    start = item["start"]
    windows = np.lib.stride_tricks.sliding_window_view(clip[start : start + 6], (24, 32), (1, 2))
    assert any((windows[:, y, x] == frames).all() for y in range(17) for x in range(17))
    want = data.sensor(item["sensor"]).voxels(frames, 60, bins=5)
    assert torch.equal(item["voxels"], torch.from_numpy(want))


@pytest.mark.parametrize("quantiser", [None, "int-5"])
def test_each_item_has_its_own_mismatch(quantiser: Any, videos: Path) -> None:
    """The same sensor on the same frames: another chip, or other cells, each time."""
    same: dict[str, Any] = dict(
        frames=14, crop=None, flips=False, quantisers=[quantiser], sensors=1, length=2
    )
    first = [str(sorted(videos.iterdir())[0])]
    still = EventDataset(first, **same, fps=60, voxels={"bins": 3})
    moved = EventDataset(first, **same, fps=60, voxels={"bins": 3}, mismatch=0.1)
    assert torch.equal(moved[0]["frames"], moved[1]["frames"])
    assert not torch.equal(moved[0]["voxels"], moved[1]["voxels"])
    assert torch.equal(still[0]["voxels"], still[1]["voxels"]) == (quantiser is None)


def test_mistakes_of_data_sets(videos: Path, tmp_path: Path) -> None:
    mistakes: list[tuple[Any, str]] = [
        (lambda: EventDataset(tmp_path / "none"), "no such folder"),
        (lambda: EventDataset(tmp_path), "no videos"),
        (lambda: _dataset(videos, thresholds=(0.5, 0.1)), "thresholds = "),
        (lambda: _dataset(videos, frames=1), "frames = 1"),
        (lambda: _dataset(videos, mismatch=2), "mismatch = 2"),
        (lambda: _dataset(videos, mismatch="a"), "mismatch = 'a'"),
        (lambda: _dataset(videos, frames="a"), "frames = 'a'"),
        (
            lambda: _dataset(videos, quantisers=["int-5"], voxels={"bins": 3, "upsample": 0.1}),
            "upsample",
        ),
        (lambda: _dataset(videos, thresholds=3), "thresholds = 3"),
        (lambda: _dataset(videos, frames=99)[0], "where 99 of 32x24"),
        (lambda: _dataset(videos, kernels="dvs"), "kernels to draw from"),
        (lambda: _dataset(videos, kernels=["dvs", ["dvs", "dvs"]]), "as many kinds each"),
        (lambda: _dataset(videos, kernels=kernels(2, 3)), "are an array"),
        (lambda: _dataset(videos, quantisers=["int-99"]), "int-99"),
        (lambda: _dataset(videos, chips=["scamp9"]), "no chip scamp9"),
        (lambda: _dataset(videos, voxels={"bins": -1}), "bins"),
        (lambda: _dataset(videos, crop=(0, 8)), "crop"),
        (lambda: _dataset(videos, options={"seed": 1}), "seed of a sensor"),
    ]
    for make, words in mistakes:
        with pytest.raises(amacrine.Error, match=words):
            make()


def test_light_of_videos_has_its_scale(tmp_path: Path) -> None:
    clip = np.random.default_rng(1).random((8, 16, 16)).astype(np.float32)
    np.save(tmp_path / "clip.npy", clip)
    (tmp_path / ".hidden").mkdir()
    how: dict[str, Any] = dict(frames=8, fps=60, flips=False, thresholds=(0.1, 0.1))
    with pytest.warns(amacrine.Caution, match="scale=255"):
        dark = EventDataset(tmp_path, **how)[0]
    lit = EventDataset(tmp_path, **how, scale=255)
    assert len(lit.videos) == 1
    assert not bool(dark["voxels"].any()) and bool(lit[0]["voxels"].any())
    assert torch.allclose(lit[0]["frames"][:, 0], torch.from_numpy(clip * 255))


def test_a_data_set_tells_once_what_a_chip_leaves_out(tmp_path: Path) -> None:
    np.save(tmp_path / "clip.npy", np.zeros((4, 16, 16), np.uint8))
    options = {"memory": "filtered-step", "noise": {"shot-hz": 3}, "border": "replicate"}
    with pytest.warns(amacrine.Caution) as told:
        data = EventDataset(tmp_path, frames=4, quantisers=["int-5"], options=options)
    texts = [str(one.message) for one in told]
    assert len(set(texts)) == len(texts) and "noise" in " ".join(texts)
    assert all(one.filename == __file__ for one in told)
    assert "1 videos, 4 frames each, 16 sensors" in repr(data)


def test_numbers_that_have_their_scale_are_not_scaled_twice(tmp_path: Path) -> None:
    np.save(tmp_path / "clip.npy", np.full((4, 16, 16), 200, np.uint8))
    data = EventDataset(tmp_path, frames=4, scale=255, fps=60)
    with pytest.warns(amacrine.Caution, match="light goes up to 51000") as told:
        data[0]
    # In the words of a run, of this video; a loader's own lines are not the caller's.
    said = f"{tmp_path / 'clip.npy'}: light goes up to 51000, but the sensor takes 0 to 255: "
    assert str(told[0].message).startswith(said) and "give scale as" in str(told[0].message)
    with pytest.warns(amacrine.Caution) as told:
        data = EventDataset(tmp_path, frames=4, scale=255, fps=60)
        [*torch.utils.data.DataLoader(data, collate_fn=list)]
    assert [one.filename for one in told] == [__file__]


def test_videos_that_have_not_as_many_windows_are_told_at_once(tmp_path: Path) -> None:
    for name, rate in {"a": 10, "b": 25, "c": 10, "d": 11}.items():
        head, frame = f"YUV4MPEG2 W16 H16 F{rate}:1 Cmono\n", b"FRAME\n" + bytes(256)
        (tmp_path / f"{name}.y4m").write_bytes(head.encode() + 8 * frame)
    windows: dict[str, Any] = {"bins": 2, "window": 0.1}
    with pytest.warns(amacrine.Caution) as told:
        data = EventDataset(tmp_path, frames=8, voxels=windows)
    [text] = [str(one.message) for one in told]
    assert f"{tmp_path / 'a.y4m'} has 7 windows (10 frames per second)" in text
    assert f"{tmp_path / 'b.y4m'} has 3 (25)" in text and "c.y4m" not in text and "d.y4m" not in text
    assert "fps=" in text and "leave window out" in text and told[0].filename == __file__
    assert [len(data[n]["voxels"]) for n in range(4)] == [7, 3, 7, 7]
    with warnings.catch_warnings():
        warnings.simplefilter("error", amacrine.Caution)
        for how in ({"voxels": windows, "fps": 30}, {"voxels": {"bins": 2}}, {}):
            same = EventDataset(tmp_path, frames=8, **_any(how))
            loader: Any = torch.utils.data.DataLoader(same, batch_size=4)
            assert len(next(iter(loader))["voxels"]) == 4
        # As many windows at either rate.
        EventDataset([tmp_path / "a.y4m", tmp_path / "d.y4m"], frames=8, voxels=windows)


def test_threads_that_share_a_data_set_hide_no_warning_of_others(videos: Path) -> None:
    """Filters of `warnings` are those of all threads: two that put them back in the order in which
    they took them would leave theirs."""
    data, again = _dataset(videos), _dataset(videos)
    want = [again[n] for n in range(len(again))]
    filters = list(warnings.filters)
    with ThreadPoolExecutor(4) as pool:
        got = list(pool.map(data.__getitem__, [*range(len(data))] * 4))
    assert all(_equal(one, want[n % len(want)]) for n, one in enumerate(got))
    assert warnings.filters == filters
    again = pickle.loads(pickle.dumps(data))
    assert _equal(again[1], want[1])


def test_types_of_torch_are_types_of_voxels(videos: Path) -> None:
    data = _dataset(videos, voxels={"bins": 3, "dtype": torch.float16})
    assert data[0]["voxels"].dtype == torch.float16


def test_weights_are_taken_as_a_layer_has_them() -> None:
    conv = torch.nn.Conv2d(1, 2, 3, bias=False)
    limits = torch.nn.Parameter(torch.tensor([0.1, 0.2]))
    sensor = amacrine.Sensor(conv.weight, limits)
    want = conv.weight.detach().double().numpy()[:, 0]
    assert np.array_equal(np.stack(sensor.kernels), want)
    assert np.allclose([own[0] for own in sensor.thresholds], [0.1, 0.2])
    light = torch.rand(4, 8, 9).bfloat16()
    events = amacrine.Sensor("dvs", 0.1).events(light, 9, scale=255)
    wide = amacrine.Sensor("dvs", 0.1).events(light.float().numpy(), 9, scale=255)
    assert len(events) > 0 and events.tobytes() == wide.tobytes()
    half = conv.weight.bfloat16()
    got = np.stack(amacrine.Sensor([half], 0.1).kernels)
    assert np.array_equal(got, half.detach().double().numpy()[:, 0])


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"crop": 16}, "crop=\\(height, width\\)"),
        ({"voxels": {"bin": 3}}, "there is no bin"),
        ({"kernels": [np.ones((2, 2))]}, "odd"),
        ({"options": {"memory": "snap"}}, "filtered-step"),
        ({"quantisers": ["int-5"], "domain": "silicium"}, "unknown domain"),
        ({"quantisers": ["ternary"], "kernels": [kernels(3, 3)]}, "registers are needed"),
    ],
)
def test_a_data_set_that_cannot_be_is_told_at_once(
    how: dict[str, Any], said: str, tmp_path: Path
) -> None:
    np.save(tmp_path / "clip.npy", np.zeros((4, 16, 16), np.uint8))
    with pytest.raises(amacrine.Error, match=said):
        EventDataset(tmp_path, frames=4, **how)


def test_what_the_way_back_needs_is_freed_with_it_and_not_with_the_outputs() -> None:
    batch = torch.rand(1, 6, 1, 16, 16)
    layer = EventSensor("csdvs-3", 4.0, fps=9, scale=255)
    before = set(event_sensor._KEPT)
    seen = layer(batch)
    [key] = set(event_sensor._KEPT) - before
    held = weakref.ref(event_sensor._KEPT[key])
    assert held() is not None
    loss = seen.voxels.sum()
    loss.backward(retain_graph=True)
    assert layer.kernels.grad is not None
    once = layer.kernels.grad.clone()
    loss.backward()
    assert torch.equal(layer.kernels.grad, 2 * once)
    assert held() is None
    with pytest.raises(RuntimeError, match="second time"):
        loss.backward()
    assert torch.isfinite(seen.voxels).all()


def test_it_is_made_in_inference_mode() -> None:
    """And learned outside of it."""
    with torch.inference_mode():
        layers = [EventSensor("csdvs-3", 4.0, fps=9, scale=255)]
        layers.append(EventSensor.from_sensor(amacrine.Sensor("csdvs-3", 0.2), fps=9, scale=255))
        assert not layers[0](torch.rand(1, 6, 1, 16, 16)).voxels.requires_grad
    for layer in layers:
        layer(torch.rand(1, 6, 1, 16, 16)).voxels.sum().backward()
        assert layer.kernels.grad is not None


def test_a_mesh_is_no_layer() -> None:
    mesh = amacrine.Sensor.from_file("csdvs-mesh")
    with pytest.raises(amacrine.Error, match="(?s)more than kernels.*without a pattern, a mesh"):
        EventSensor.from_sensor(mesh, fps=9)


WAYS: dict[str, Any] = {
    "checkpoint": lambda f, x: checkpoint(f, x, use_reentrant=False),
    "checkpoint of inputs": lambda f, x: checkpoint(f, x, use_reentrant=True),
    "save_on_cpu": lambda f, x: _within(save_on_cpu(), f, x),
    "copies": lambda f, x: _within(saved_tensors_hooks(lambda t: t.clone(), lambda t: t), f, x),
    "arrays": lambda f, x: _within(saved_tensors_hooks(lambda t: t.numpy().copy(), torch.from_numpy), f, x),
}


def _within(hooks: Any, of: Any, light: Any) -> Any:
    with hooks:
        return of(light)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("changed", [False, True])
def test_its_gradient_is_the_same_however_what_it_saves_is_kept(way: str, changed: bool) -> None:
    """Where only copies are kept, or nothing, the events are made again."""
    batch = torch.rand(2, 6, 1, 16, 16)
    layer = EventSensor(kernels(2, 3), 0.3, fps=9, scale=255, mismatch=0.1, phase=0.2)

    def loss(frames: Any) -> Any:
        seen = layer(frames)
        return seen.voxels.square().sum() + 0.1 * seen.events

    light = batch.clone().requires_grad_()
    loss(light).backward()
    parts = (layer.kernels, layer.log_thresholds, light)
    want = [part.grad.clone() for part in parts if part.grad is not None]
    assert len(want) == 3
    layer.zero_grad()
    light.grad = None
    before = set(event_sensor._KEPT)
    asked = WAYS[way](loss, light)
    # On the processor it is not a copy that is saved on the processor.
    assert (set(event_sensor._KEPT) <= before) == (way != "save_on_cpu")
    if changed and "checkpoint" not in way:
        # What was saved is what it was.
        with torch.no_grad():
            layer.kernels.add_(1.0)
            light.mul_(0.5)
    asked.backward()
    assert all(torch.equal(_any(part.grad), own) for part, own in zip(parts, want))
    assert set(event_sensor._KEPT) <= before
