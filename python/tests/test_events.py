"""A sensor in Python is the sensor of the command line, to the bit."""

from __future__ import annotations

import json
import multiprocessing
import pickle
import threading
import time
import warnings
from pathlib import Path
from typing import Any, Callable

import amacrine
import numpy as np
import pytest
from conftest import Frames, kernels

FPS = 120.0


def of_program(
    program: Callable[..., str], folder: Path, frames: Any, text: str, *more: Any
) -> dict[str, Any]:
    """Events, counts and voxels of the command line."""
    np.save(folder / "scene.npy", frames)
    (folder / "sensor.toml").write_text(text)
    made = {name: folder / f"{name}.npy" for name in ("events", "counts", "voxels")}
    outputs = [word for name, path in made.items() for word in (f"--{name}", path)]
    scene, sensor = folder / "scene.npy", folder / "sensor.toml"
    program("run", "--scene", scene, "--sensor", sensor, "--fps", FPS, *outputs, *more)
    return {name: np.load(path) for name, path in made.items()}


def test_what_is_changed_is_what_the_program_changes(
    program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    own = amacrine.Sensor.from_file("rgc-4", seed=3)
    limits = {"on": 0.3, "off": 0.2, "sigma": 0.02}
    for changed, options in (
        (own.changed(thresholds=(0.3, 0.2)), ("--threshold", "0.3,0.2")),
        (own.changed(thresholds=limits), ("--threshold", "0.3,0.2", "--sigma", 0.02)),
        (own.changed(sigma=0), ("--sigma", 0)),
        (own.changed(kernels=["dvs", "sobel-x"]), ("--kernel", "dvs,sobel-x")),
    ):
        want = of_program(program, tmp_path, frames, own.text, "--seed", 3, *options)
        assert changed.events(frames, FPS).tobytes() == want["events"].tobytes(), options
    assert own.changed(kernels=["dvs", "sobel-x"]).channels == ["dvs", "sobel-x"]
    assert np.array_equal(own.changed(kernels=kernels(1)).kernels[0], kernels(1)[0, 0])
    assert own.changed(thresholds=0.3).changed(thresholds=own.thresholds[0][:2]) == own.changed()
    for wrong, told in (
        (dict(thresholds=0), "thresholds = 0"),
        (dict(sigma=-1), "sigma=-1 is no spread"),
        (dict(sigma="wide"), "sigma = 'wide' is no number"),
        (dict(kernels=np.ones((2, 2))), "both must be odd"),
    ):
        with pytest.raises(amacrine.Error, match=told):
            own.changed(**wrong)
    with pytest.raises(amacrine.Error, match="kernels given: .*mesh or a pattern"):
        amacrine.Sensor.from_file("csdvs-mesh").changed(kernels="dvs")


def sensors() -> dict[str, amacrine.Sensor]:
    return {
        "shipped": amacrine.Sensor.from_file("rgc-4", seed=3),
        "one": amacrine.Sensor("csdvs-5", 0.1, seed=3),
        "learned": amacrine.Sensor(
            kernels(3),
            [0.5, (0.4, 0.6), {"on": 0.5, "off": 0.5, "sigma": 0.05}],
            memory="filtered-snap",
            border="zero",
            refractory=500,
            noise={"shot-hz": 40},
            names=["a", "b", "c"],
            seed=3,
        ),
        "narrow": amacrine.Sensor(kernels(2), 0.5, format="q8.8", seed=3),
    }


@pytest.mark.parametrize("which", sensors())
def test_what_the_program_writes(
    which: str, program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    sensor = sensors()[which]
    format = "q8.8" if which == "narrow" else "f64"
    want = of_program(program, tmp_path, frames, sensor.text, "--seed", 3, "--format", format)
    events = sensor.events(frames, FPS)
    assert len(events) > 1000
    assert events.dtype == want["events"].dtype
    assert events.tobytes() == want["events"].tobytes()
    counts = sensor.counts(frames, FPS)
    assert counts.dtype == np.int32
    assert np.array_equal(counts, want["counts"]) and counts.any()
    voxels = sensor.voxels(frames, FPS)
    assert voxels.dtype == np.float32
    assert np.array_equal(voxels, want["voxels"]) and voxels.any()


@pytest.mark.parametrize("dtype", ["f2", "f4", "f8", ">f4", "u2", "i4"])
def test_numbers_with_a_scale(
    dtype: str, program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    sensor = amacrine.Sensor("csdvs-3", 0.1)
    given = (frames / 8).astype(dtype)
    want = of_program(program, tmp_path, given, sensor.text, "--scale", 4)
    assert sensor.events(given, FPS, scale=4).tobytes() == want["events"].tobytes()


def test_frames_of_true_and_false(frames: Frames) -> None:
    """True is the light that the scale says, however the array lies."""
    lit = frames > 128
    sensor = amacrine.Sensor(kernels(2), 0.3)
    want = sensor.counts(lit * np.uint8(255), FPS)
    assert np.count_nonzero(want) > 100
    assert np.array_equal(sensor.counts(lit, FPS, scale=255), want)
    turned = sensor.events(lit.transpose(0, 2, 1), FPS, scale=255)
    same = sensor.events((lit * 255.0).transpose(0, 2, 1), FPS, scale=1)
    assert turned.tobytes() == same.tobytes()
    snap = amacrine.Program.from_file("dvs/snap")
    run = snap.run(lit, FPS, scale=200)
    assert run.events.tobytes() == snap.run(lit * np.uint8(200), FPS).events.tobytes()


def test_frames_are_put_in(
    program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    """As `--upsample` does."""
    sensor = sensors()["learned"]
    want = of_program(program, tmp_path, frames[:4], sensor.text, "--seed", 3, "--upsample", 0.5)
    events = sensor.events(frames[:4], FPS, upsample=0.5)
    assert events.tobytes() == want["events"].tobytes()
    assert events.tobytes() != sensor.events(frames[:4], FPS).tobytes()
    assert len(want["counts"]) > 3
    counts = sensor.counts(frames[:4], FPS, upsample=0.5)
    assert counts.shape == (3, 3, *frames.shape[1:])
    assert np.array_equal(counts.sum(axis=0), want["counts"].sum(axis=0))
    same = np.zeros_like(counts)
    # An event at the time of a frame is before it.
    pair = np.ceil(np.round(events["t"] * 1e-6 * FPS, 4)).astype(int) - 1
    sign = np.where(events["p"] == 1, 1, -1)
    np.add.at(same, (pair, events["channel"], events["y"], events["x"]), sign)
    assert (same != counts).mean() < 1e-3
    how: Any = {"bins": 4, "window": 1 / FPS}
    voxels = sensor.voxels(frames[:4], FPS, upsample=0.5, **how)
    assert np.array_equal(voxels, amacrine.events.voxels(events, end=3 / FPS, **how))


def test_a_readout_stands_between(
    program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    """As `--readout` and `--with` say, in every form."""
    sensor = sensors()["shipped"]
    np.save(tmp_path / "scene.npy", frames)
    (tmp_path / "sensor.toml").write_text(sensor.text)
    (tmp_path / "own.toml").write_text(amacrine.text("readouts", "arbiter"))
    scene = ("--scene", tmp_path / "scene.npy", "--sensor", tmp_path / "sensor.toml", "--fps", FPS)
    ways: list[tuple[Any, tuple[Any, ...]]] = [
        ("scan", ("scan",)),
        (tmp_path / "own.toml", (tmp_path / "own.toml",)),
        ({"readout": "scan", "slots": 20}, ("scan", "--with", "slots=20")),
        (
            {"readout": "arbiter", "fifo": 16, "when_full": "drop-newest"},
            ("arbiter", "--with", "fifo=16", "--with", "when-full=drop-newest"),
        ),
    ]
    for readout, words in ways:
        out = tmp_path / "e.npy"
        stated = program("run", *scene, "--seed", 3, "--readout", *words, "-o", out, "--json")
        dropped = json.loads(stated)["dropped"]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", amacrine.Caution)
            events = sensor.events(frames, FPS, readout=readout)
        assert events.tobytes() == np.load(out).tobytes(), readout
        assert events.dropped == dropped
    with pytest.warns(amacrine.Caution, match="the readout's slots were full"):
        sensor.events(frames, FPS, readout={"readout": "scan", "slots": 20})


def test_a_span_reaches_to_what_a_readout_delays(program: Callable[..., str], tmp_path: Path) -> None:
    clip = np.random.default_rng(3).integers(0, 256, (6, 8, 8)).astype(np.uint8)
    np.save(tmp_path / "scene.npy", clip)
    scene = ("--scene", tmp_path / "scene.npy", "--sensor", "dvs", "--fps", 240)
    program("run", *scene, "--readout", "frame", "-o", tmp_path / "want.npy")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", amacrine.Caution)
        events = amacrine.Sensor.from_file("dvs").events(clip, 240, readout="frame")
    assert events.span == (0.0, 0.021) and events["t"].max() == 21_000 > 5e6 / 240
    amacrine.write(tmp_path / "own.npy", events)
    assert (tmp_path / "own.npy").read_bytes() == (tmp_path / "want.npy").read_bytes()
    assert amacrine.read(tmp_path / "own.npy").span == (0.0, 0.021)


def test_dtypes() -> None:
    assert amacrine.EVENT.descr == [("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "|i1")]
    assert amacrine.EVENT_OF_KINDS.descr == [*amacrine.EVENT.descr, ("channel", "|u1")]


class Tensor:
    """Only the array protocol, as a tensor has it."""

    def __init__(self, array: Any) -> None:
        self.array = array

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        return self.array


def test_shapes(frames: Frames) -> None:
    sensor = amacrine.Sensor(kernels(2), 0.5)
    want = sensor.events(frames, FPS).tobytes()
    assert sensor.events(frames[:, None], FPS).tobytes() == want
    assert sensor.events(Tensor(frames), FPS).tobytes() == want
    scattered = np.asfortranarray(frames)
    assert sensor.events(scattered, FPS).tobytes() == want
    assert sensor.events(frames[:, ::-1, ::-1][:, ::-1, ::-1], FPS).tobytes() == want
    other = frames[::-1]
    batch = np.stack([frames, other, frames])[:, :, None]
    several = sensor.events(batch, FPS)
    assert [e.tobytes() for e in several] == [want, sensor.events(other, FPS).tobytes(), want]
    counts = sensor.counts(batch, FPS)
    assert counts.shape == (3, 11, 2, 61, 83)
    assert np.array_equal(counts[1], sensor.counts(other, FPS))
    voxels = sensor.voxels(batch, FPS)
    assert voxels.shape == (3, 12, 2, 61, 83)
    assert np.array_equal(voxels[1], sensor.voxels(other, FPS))
    binned = sensor.voxels(batch, FPS, bins=5)
    assert binned.shape == (3, 1, 2, 5, 61, 83)
    assert np.array_equal(binned[1], sensor.voxels(other, FPS, bins=5))


def test_few_frames(frames: Frames) -> None:
    sensor = amacrine.Sensor("dvs", 0.1)
    for few in (frames[:0], frames[:1]):
        assert len(sensor.events(few, FPS)) == 0
        assert sensor.counts(few, FPS).shape == (0, 1, 61, 83)
        assert sensor.voxels(few, FPS).shape == (len(few), 1, 61, 83)


def test_kernels_as_networks_have_them(frames: Frames) -> None:
    weights = kernels(4)
    want = amacrine.Sensor(weights, 0.5).events(frames, FPS).tobytes()
    for given in (weights[:, 0], list(weights[:, 0]), weights[:, 0].tolist()):
        assert amacrine.Sensor(given, 0.5).events(frames, FPS).tobytes() == want
    narrow = amacrine.Sensor(weights.astype("f4"), 0.5)
    wide = amacrine.Sensor(weights.astype("f4").astype("f8"), 0.5)
    assert narrow.events(frames, FPS).tobytes() == wide.events(frames, FPS).tobytes()
    alone = amacrine.Sensor(weights[1, 0], 0.5).events(frames, FPS)
    of_one = amacrine.Sensor(weights, 0.5).events(frames, FPS)
    of_one = of_one[of_one["channel"] == 1]
    assert all(np.array_equal(np.sort(alone[n]), np.sort(of_one[n])) for n in ("t", "x", "y"))


def test_any_number_of_threads(frames: Frames) -> None:
    sensor = amacrine.Sensor(kernels(3), 0.5, noise={"shot-hz": 50})
    large = np.tile(frames, (1, 4, 4))
    before = amacrine.threads()
    try:
        said = []
        for threads in (1, 2, 5):
            amacrine.set_threads(threads)
            assert amacrine.threads() == threads
            said.append(
                (
                    sensor.events(large, FPS).tobytes(),
                    sensor.counts(large, FPS).tobytes(),
                    sensor.voxels(large, FPS).tobytes(),
                    sensor.voxels(large, FPS, bins=4, window=0.03).tobytes(),
                )
            )
    finally:
        amacrine.set_threads(before)
    assert said[0] == said[1] == said[2]


def _count(frames: Frames) -> int:
    return len(amacrine.Sensor("csdvs-5", 0.1).events(np.tile(frames, (1, 3, 3)), FPS))


def _norms(frames: Frames) -> float:
    sensor = amacrine.Sensor(["dvs", "csdvs-5"], 0.1)
    return float(np.abs(sensor.voxels(frames, FPS, bins=3, normalise="std")).sum())


def _run(frames: Frames) -> int:
    program = amacrine.Program.from_file("dvs/snap")
    return len(program.run(np.tile(frames, (1, 9, 9)), FPS, domain="exact", clip=True).events)


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning", "ignore::amacrine.Caution")
@pytest.mark.parametrize("made", [_count, _norms, _run])
def test_a_fork_has_threads_of_its_own(frames: Frames, made: Callable[[Frames], Any]) -> None:
    """The workers of a data loader are forks: a pool that was there before has no threads in
    them."""
    want = made(frames)
    assert want > 0
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(made, [frames] * 4).get(timeout=60) == [want] * 4


def test_a_stream_goes_on(frames: Frames) -> None:
    sensor = amacrine.Sensor.from_file("rgc-4")
    want = sensor.events(frames, FPS)
    stream = sensor.stream(FPS)
    parts = [frames[:1], frames[1:2], frames[2:9], frames[9:]]
    assert np.concatenate(list(stream.each(parts))).tobytes() == want.tobytes()
    assert stream.seen == 12
    stream = sensor.stream(FPS)
    counts = np.concatenate([stream.counts(part) for part in parts])
    assert np.array_equal(counts, sensor.counts(frames, FPS))


def test_a_sensor_that_never_fires_says_so(frames: Frames) -> None:
    with pytest.warns(amacrine.Caution, match="no event at all in 12 frames"):
        amacrine.Sensor("dvs", 50.0).events(frames, FPS)


def test_thresholds_that_no_light_reaches_are_told_of(
    frames: Frames, program: Callable[..., str], tmp_path: Path
) -> None:
    """In the words of `amacrine run`: what the response makes of light is why."""
    sensor = amacrine.Sensor("csdvs-3", 20)
    (tmp_path / "it.toml").write_text(sensor.text)
    np.save(tmp_path / "light.npy", frames)
    words = ("run", "--sensor", tmp_path / "it.toml", "--scene", tmp_path / "light.npy")
    (told,) = json.loads(program(*words, "--fps", FPS, "--json"))["warnings"]
    want = f"sensor: {told['seen']}: {told['why']}\nhelp: {told['change']}"
    assert "its lowest threshold, 20, is out of reach: for light from 0 to 255 the response is 0 to 1" in want
    assert 'response = "identity"' in want
    assert _said(lambda: sensor.events(frames, FPS)) == [want]
    identity = amacrine.Sensor("csdvs-3", 20, response="identity")
    assert not any("no event" in said for said in _said(lambda: identity.events(frames, FPS)))


RULES = """response = "identity"
memory = "{memory}"
polarity = "{polarity}"
border = "zero"
{more}
[[channel]]
kernel = {kernel}
threshold = {{ on = 1, off = 1 }}
"""


def test_silence_of_the_rules_is_told_as_such(frames: Frames) -> None:
    """As `amacrine run` does: frames a refractory period apart, and crossings without a sign, are no
    small light."""
    rule = 'refractory = { us = 1000, rule = "authors" }'
    close = RULES.format(memory="filtered-step", polarity="filtered", more=rule, kernel="[[1]]")
    (said,) = _said(lambda: amacrine.Sensor.from_text(close).events(frames, 1000.0))
    assert "the frame interval is not longer than the refractory period" in said
    unsigned = RULES.format(
        memory="raw-snap", polarity="pixel", more="", kernel="[[1, 0, 0]]"
    )
    edge = np.zeros((2, 8, 8), np.uint8)
    edge[1, :, 0] = 100
    (said,) = _said(lambda: amacrine.Sensor.from_text(unsigned).counts(edge, 10.0))
    assert "its cells cross thresholds (8 crossings), but emit nothing" in said


def test_a_still_scene_that_fires_is_told_of(frames: Frames) -> None:
    """Where the memory is seen through another kernel than the light."""
    more = 'refractory = { us = 0, rule = "authors" }'
    text = RULES.format(memory="authors-pixel-step", polarity="filtered", more=more, kernel="[[1]]")
    still = np.repeat(frames[:1], 3, axis=0)
    sensor = amacrine.Sensor.from_text(text + "memory-kernel = [[0.9]]\n")
    assert any("cells fire on a still scene" in said for said in _said(lambda: sensor.events(still, FPS)))
    same = amacrine.Sensor.from_text(text + "memory-kernel = [[1]]\n")
    assert not any("still scene" in said for said in _said(lambda: same.events(still, FPS)))


def _said(watch: Callable[[], Any]) -> list[str]:
    """What a call warns of."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        watch()
    assert {Path(one.filename).name for one in said} <= {"test_events.py"}
    return [str(one.message) for one in said if issubclass(one.category, amacrine.Caution)]


def _ways(sensor: amacrine.EventSensor, clip: Any) -> dict[str, Callable[[], Any]]:
    """Each way to watch a clip."""
    return {
        "events": lambda: sensor.events(clip, FPS),
        "counts": lambda: sensor.counts(clip, FPS),
        "voxels": lambda: sensor.voxels(clip, FPS),
        "bins": lambda: sensor.voxels(clip, FPS, bins=3),
        "windows": lambda: list(sensor.voxel_windows([clip], FPS, bins=3, window=0.02)),
        "stream": lambda: sensor.stream(FPS).events(clip),
        "stream of counts": lambda: sensor.stream(FPS).counts(clip),
        "each": lambda: list(sensor.stream(FPS).each([clip[:2], clip[2:]])),
    }


def test_every_way_to_watch_warns(frames: Frames) -> None:
    """As `amacrine run` does: of no event, and of most cells firing at once."""
    clip = np.concatenate([frames, frames[::-1]])
    chip = amacrine.compile("dvs", 255, effort=0.01)
    for silent in (amacrine.Sensor("dvs", 50.0), chip):
        for way, watch in _ways(silent, clip).items():
            said = _said(watch)
            assert len(said) == 1 and "no event at all in 24 frames" in said[0], way
    for way, watch in _ways(amacrine.Sensor("dvs", 0.1), clip).items():
        said = _said(watch)
        assert len(said) == 1 and "cells" in said[0] and "raise the threshold" in said[0], way
    for way, watch in _ways(amacrine.Sensor("dvs", 0.7), clip).items():
        assert _said(watch) == [], way
    # One clip of a batch that is silent is no mistake; all are.
    still = np.stack([np.repeat(clip[:1], 24, axis=0), clip])[:, :, None]
    assert _said(lambda: amacrine.Sensor("dvs", 0.7).events(still, FPS)) == []
    assert len(_said(lambda: amacrine.Sensor("dvs", 0.7).events(still[:1], FPS))) == 1


def test_light_of_0_to_1_is_told_of(
    frames: Frames, program: Callable[..., str], tmp_path: Path
) -> None:
    """In the words of `amacrine run`, for the sensor's response."""
    small = np.concatenate([frames, frames[::-1]]) / 255
    np.save(tmp_path / "small.npy", small)
    log = {"log": {"white": 255, "offset": 1e-5}}
    for sensor in (amacrine.Sensor("dvs", 0.002), amacrine.Sensor("dvs", 0.9, response=log)):
        (tmp_path / "it.toml").write_text(sensor.text)
        words = ("run", "--sensor", tmp_path / "it.toml", "--scene", tmp_path / "small.npy")
        told = json.loads(program(*words, "--fps", FPS, "--json"))["warnings"]
        stated = next(one for one in told if one["about"] == "scale")
        want = f"{stated['seen']}: {stated['why']}\nhelp: give scale=255, or multiply the array"

        def of(clip: Any) -> list[str]:
            return [said for said in _said(lambda: sensor.events(clip, FPS, scale=1)) if "lies" in said]

        assert of(small) == [f"the scene: {want}"]
        assert of(small * 255) == []
        # Of a batch only where all clips are small; of a stream when enough was seen.
        assert of(np.stack([small, small * 255])[:, :, None]) == []
        assert of(np.stack([small, small])[:, :, None]) == [f"the scene: {want}"]
        stream = sensor.stream(FPS, scale=1)
        assert not any("lies" in said for said in _said(lambda: stream.counts(small[:4])))
        assert any("lies" in said for said in _said(lambda: stream.counts(small[4:])))


def test_a_stream_is_silent_for_a_while(frames: Frames) -> None:
    stream = amacrine.Sensor("dvs", 50.0).stream(FPS)
    assert _said(lambda: stream.events(frames)) == []
    assert "in 24 frames" in _said(lambda: stream.events(frames))[0]
    assert _said(lambda: stream.events(frames)) == []


def test_sensors_come_by_name(tmp_path: Path, frames: Frames) -> None:
    assert "rgc-4" in amacrine.names("sensors")
    sensor = amacrine.Sensor.from_file("rgc-4")
    assert sensor.channels == ["change", "centre-on", "vertical edges", "horizontal edges"]
    copy = tmp_path / "copy.toml"
    copy.write_text(amacrine.text("sensors", "rgc-4"))
    again = amacrine.Sensor.from_file(copy)
    assert again.events(frames, FPS).tobytes() == sensor.events(frames, FPS).tobytes()
    for name in amacrine.names("sensors"):
        amacrine.Sensor.from_file(name)


def test_a_clip_in_which_nothing_can_fire_is_told_of(frames: Frames) -> None:
    for few in (frames[:0], frames[:1]):
        with pytest.warns(amacrine.Caution, match="no event at all"):
            assert len(amacrine.Sensor("dvs", 0.2).events(few, FPS)) == 0


def test_kernels_of_several_sizes() -> None:
    sensor = amacrine.Sensor.from_file("mosaic")
    assert sensor == amacrine.Sensor.from_file("mosaic")
    pattern = next(own for own in sensor.kernels if own.ndim == 3)
    assert len(pattern) == 4 and pattern.shape[1] % 2 == 1


def test_thresholds_for_a_rate(
    frames: Frames, program: Callable[..., str], tmp_path: Path
) -> None:
    """Those of `amacrine run --rate`."""
    np.save(tmp_path / "scene.npy", frames)
    spread = {"on": 0.2, "off": 0.3, "sigma": 0.02}
    noise = {"shot-hz": 5}
    sensor = amacrine.Sensor(kernels(2, 3), [spread, 0.4], noise=noise, name="two", seed=3)
    (tmp_path / "it.toml").write_text(sensor.text)
    words = ("--scene", tmp_path / "scene.npy", "--sensor", tmp_path / "it.toml", "--fps", FPS)
    stated = json.loads(program("run", *words, "--rate", 20, "--seed", 3, "--json"))
    rated = sensor.for_rate(frames, FPS, 20)
    for own, before in zip(rated.thresholds, sensor.thresholds, strict=True):
        np.testing.assert_array_equal(own, before * stated["rate"]["factor"])
    assert [own[0] for own in rated.thresholds] == stated["rate"]["thresholds"]
    assert len(rated.events(frames, FPS)) == stated["events"]
    assert (rated.name, rated.channels) == ("two", sensor.channels)
    for own, before in zip(rated.kernels, sensor.kernels, strict=True):
        assert np.array_equal(own, before)
    # The same light, as floats with a scale.
    assert sensor.for_rate(frames / 255, FPS, 20, scale=255).channels == rated.channels
    with pytest.raises(amacrine.Error, match="give a rate between them"):
        sensor.for_rate(frames, FPS, 1e12)
    with pytest.raises(amacrine.Error, match="no event at any threshold"):
        amacrine.Sensor("dvs", 0.1).for_rate(frames[:1].repeat(3, axis=0), FPS, 1)
    with pytest.raises(amacrine.Error, match="rate=2"):
        sensor.for_rate(frames, FPS, "fast")  # type: ignore[arg-type]


def test_a_rate_that_no_threshold_gives_is_warned_of() -> None:
    """Half of all pixels change by the same: either all of them fire, or none."""
    frames = np.full((6, 8, 8), 20, dtype=np.uint8)
    frames[1::2, :, :4] = 200
    with pytest.warns(amacrine.Caution, match=r"no threshold gives 5 events .* the nearest rate is"):
        amacrine.Sensor("dvs", 0.1).for_rate(frames, 30, 5)


def test_effects_are_left_out_as_run_does(
    frames: Frames, program: Callable[..., str], tmp_path: Path
) -> None:
    np.save(tmp_path / "scene.npy", frames)
    spread = {"on": 0.2, "off": 0.3, "sigma": 0.05}
    noise = {"shot-hz": 5, "leak-hz": 2}
    sensor = amacrine.Sensor(kernels(2, 3), [spread, 0.4], noise=noise, refractory=9000, seed=3)
    (tmp_path / "it.toml").write_text(sensor.text)
    words = ("--scene", tmp_path / "scene.npy", "--sensor", tmp_path / "it.toml", "--fps", FPS)
    for effects in [("mismatch",), ("leak", "noise-events"), ("dead-time",)]:
        program(
            "run", *words, "--seed", 3, "--events", tmp_path / "e.npy",
            "--without", ",".join(effects),
        )
        plain = sensor.without(*effects)
        events = plain.events(frames, FPS)
        assert events.tobytes() == np.load(tmp_path / "e.npy").tobytes()
        assert events.tobytes() != sensor.events(frames, FPS).tobytes()
        assert plain.without().text == plain.text
    # Without a period, the authors' rule is still another than a dead time.
    authors = amacrine.Sensor(kernels(2, 3), 0.3, refractory={"us": 9000, "rule": "authors"})
    (tmp_path / "it.toml").write_text(authors.text)
    program("run", *words, "--events", tmp_path / "e.npy", "--without", "dead-time")
    events = authors.without("dead-time").events(frames, FPS)
    assert events.tobytes() == np.load(tmp_path / "e.npy").tobytes()
    assert events.tobytes() != amacrine.Sensor(kernels(2, 3), 0.3).events(frames, FPS).tobytes()
    with pytest.raises(amacrine.Error, match="has no jitter to leave out"):
        sensor.without("jitter")
    with pytest.raises(amacrine.Error, match="did you mean `leak`"):
        sensor.without("laek")


def test_a_notebook_shows_the_first_events() -> None:
    given = np.array([(5, 1, 2, 1, 0), (6, 3, 2, 0, 1), *[(9, 0, 0, 1, 1)] * 8], amacrine.EVENT_OF_KINDS)
    random = np.random.default_rng(3).integers(0, 256, (4, 16, 24)).astype(np.uint8)
    sensor = amacrine.Sensor(kernels(2), 0.3, names=["one<", "other"])
    seen = sensor.events(random, FPS)
    shown = seen._repr_html_()
    assert shown is not None
    assert f"<td>{len(seen)}</td><td>24x16</td><td>0 to 0.025</td>" in shown
    assert f"… {len(seen) - 5} more" in shown and shown.count("<tr>") == 3 + 2 + 1 + 1 + 5 - 1
    for n, name in enumerate(["one&lt;", "other"]):
        of = seen["p"][seen["channel"] == n]
        assert f"<td>{name}</td><td>{(of == 1).sum()}</td><td>{(of == 0).sum()}</td>" in shown
    # A picture of the busiest moment, where it can be drawn.
    figure = '<figure style="margin: 0"><img src="data:image/png;base64,'
    assert figure in shown and figure in str(seen[:3]._repr_html_())
    for none in (seen[:0], seen[::-1], amacrine.events.named(given, None, (2, 2))):
        assert figure not in str(none._repr_html_())
    # Without what is known of a sensor, and with nothing at all.
    plain = amacrine.events.named(given, None, None)
    shown = plain._repr_html_()
    assert shown is not None and "<td>1</td><td>8</td><td>1</td>" in shown
    assert "span" not in shown and "more" in shown
    assert seen[:0]._repr_html_() is not None
    none = amacrine.events.named(np.zeros(0, amacrine.EVENT), None, (4, 4), dropped={"no_slot": 7})
    assert "<th>lost: no_slot</th>" in str(none._repr_html_())
    # What is no list of events is shown as arrays are.
    numbers: Any = seen.view("u1")
    assert numbers._repr_html_() is None


def test_a_notebook_shows_a_sensor() -> None:
    sensor = amacrine.Sensor(kernels(2, 3), [0.2, (0.3, 0.4)], names=["one", "other"], seed=7)
    shown = sensor._repr_html_()
    assert "<td>sensor</td><td>f64</td><td>7</td>" in shown
    assert "<td>0.3</td><td>0.4</td><td>0</td>" in shown and shown.count("<td>3x3</td>") == 2
    # The sensor, its kinds, and a kernel each; its file is folded.
    assert shown.count("<table>") == 4 and "<details>" in shown
    assert f"<td>{kernels(2, 3)[1, 0, 0, 0]:.4g}</td>" in shown
    large = amacrine.Sensor(np.ones((17, 17)), 0.2)._repr_html_()
    assert "1 kernel is not drawn" in large and large.count("<table>") == 2
    # A kernel for each pixel of two by two.
    mosaic = amacrine.Sensor.from_file("mosaic")._repr_html_()
    assert ", x 1, y 0</td>" in mosaic and ", x 1, y 1</td>" in mosaic


def test_a_mesh_is_no_kernel() -> None:
    """What it is has no (k,k): another sensor would come of what is handed on."""
    mesh = amacrine.Sensor.from_file("csdvs-mesh")
    with pytest.raises(amacrine.Error, match="(?s)sees through a mesh.*`amacrine mesh solve"):
        mesh.kernels
    assert mesh.thresholds[0].tolist() == [0.2, 0.2, 0.03]
    shown = mesh._repr_html_()
    assert "<td>mesh</td><td></td><td>0.2</td>" in shown and "<td>1x1</td>" not in shown
    assert mesh == amacrine.Sensor.from_text(mesh.text) and hash(mesh) == hash(pickle.loads(pickle.dumps(mesh)))
    assert mesh != amacrine.Sensor.from_text(mesh.text.replace("lambda = 10", "lambda = 5"))


def test_channels_are_counted_by_numpy() -> None:
    """Python's own `max` over a column of a million takes as long as all the rest."""
    events = np.zeros(1_000_000, amacrine.EVENT_OF_KINDS)
    events["channel"][7] = 3

    def seconds(what: Callable[[], Any]) -> float:
        begin = time.process_time()
        what()
        return time.process_time() - begin

    plain = seconds(lambda: max(events["channel"]))
    assert min(seconds(lambda: amacrine.events.kinds_of(events, 4)) for _ in range(3)) < plain / 4
    assert amacrine.events.kinds_of(events, 4) == 4
    with pytest.raises(amacrine.Error, match="channels = 3, and there are events of channel 3"):
        amacrine.events.kinds_of(events, 3)
    assert amacrine.events.kinds_of(events[:0], 1) == 1


@pytest.mark.filterwarnings("ignore::amacrine.Caution")
@pytest.mark.parametrize("how", ["events", "counts"])
def test_who_comes_while_another_is_in_a_stream_changes_nothing(how: str) -> None:
    """Wherever the other is: here its frames are just being read."""
    few = np.random.default_rng(0).integers(0, 255, (4, 16, 16), dtype=np.uint8)
    sensor = amacrine.Sensor("dvs", 0.3)
    stream = sensor.stream(FPS)
    wrong: list[str] = []

    def show() -> None:
        try:
            getattr(stream, how)(few)
        except amacrine.Error as error:
            wrong.append(str(error))

    class Frames:
        def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
            thread = threading.Thread(target=show)
            thread.start()
            thread.join()
            return few

    got = getattr(stream, how)(Frames())
    assert len(wrong) == 1 and wrong[0].startswith("another thread is in this stream")
    assert stream.seen == len(few)
    alone = sensor.stream(FPS)
    assert np.array_equal(got, getattr(alone, how)(few))
    assert np.array_equal(getattr(stream, how)(few), getattr(alone, how)(few))


@pytest.mark.filterwarnings("ignore::amacrine.Caution")
def test_a_stream_is_of_one_thread_at_a_time() -> None:
    """Who comes while another is in it is told so, and nothing is lost of what that one shows it."""
    few = np.random.default_rng(0).integers(0, 255, (4, 96, 96), dtype=np.uint8)
    long = np.tile(few, (100, 1, 1))
    sensor = amacrine.Sensor("dvs", 0.3)
    stream = sensor.stream(FPS)
    wrong: list[str] = []
    seen: list[Any] = []

    together = threading.Barrier(4)

    def watch() -> None:
        together.wait()
        try:
            seen.append(stream.counts(long))
        except amacrine.Error as error:
            wrong.append(str(error))

    # On a busy machine one may be done before the next begins.
    for _ in range(20):
        threads = [threading.Thread(target=watch) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        if wrong:
            break
    assert seen and wrong and stream.seen == len(seen) * len(long)
    assert set(wrong) <= {
        "another thread is in this stream: frames come one after the other\n"
        "help: call it from one thread at a time, or give each thread a stream of its own"
    }
    alone = sensor.stream(FPS)
    first = next(one for one in seen if len(one) == len(long) - 1)
    assert np.array_equal(first, alone.counts(long))
    for _ in seen[1:]:
        alone.counts(long)
    assert np.array_equal(stream.counts(few), alone.counts(few))
