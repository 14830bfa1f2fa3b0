"""Event files, and packets compared, as the command line has them."""

from __future__ import annotations

import importlib
import json
import os
import pickle
import re
import warnings
from pathlib import Path, PurePath
from typing import Any, Callable

import amacrine
import numpy as np
import pytest
from conftest import Frames, kernels

FPS = 120.0


@pytest.fixture(scope="module")
def events(frames: Frames) -> Any:
    return amacrine.Sensor("csdvs-5", 0.1).events(frames, FPS)


@pytest.mark.parametrize("ending", ["npy", "csv", "evt2", "evt3", "aedat4", "dat", "hdf5", "parquet"])
def test_files_come_back(ending: str, tmp_path: Path, events: Any) -> None:
    path = tmp_path / f"events.{ending}"
    amacrine.write(path, events, size=(61, 83))
    again = amacrine.read(path)
    assert again.dtype == amacrine.EVENT
    # EVT3 may order ties by rows.
    order = ["t", "y", "x", "p"]
    assert np.array_equal(np.sort(again, order=order), np.sort(events, order=order))


def test_what_a_file_says(tmp_path: Path, events: Any) -> None:
    path = tmp_path / "events.npy"
    amacrine.write(path, events, size=(61, 83))
    about = amacrine.about(path)
    assert about.size == (61, 83) and about.size_known and about.channels == 1
    assert np.array_equal(np.load(path), events)
    np.save(path, events)
    bare = amacrine.about(path)
    assert not bare.size_known and bare.size == (events["y"].max() + 1, events["x"].max() + 1)


LOST = {"no_slot": 3, "over_limit": 0, "queue_full": 2, "merged": 0, "unscanned": 1}


@pytest.mark.parametrize("ending", ["csv", "txt", "es", "npz", "evt3"])
def test_what_is_lost_is_known_where_it_is_said(
    ending: str, tmp_path: Path, frames: Frames, program: Callable[..., str]
) -> None:
    """Of a file, and of an array, that does not say it, nobody knows what is missing."""
    path, again = tmp_path / f"events.{ending}", tmp_path / "again.npz"
    events = amacrine.Sensor("dvs", 0.2).events(frames, FPS)
    events.dropped = LOST
    want = LOST if ending in ("npz", "evt3") else None
    lost = None if want is None else 6
    amacrine.write(path, events)
    read = amacrine.read(path)
    assert (read.dropped, amacrine.about(path).dropped) == (want, want)
    amacrine.write(again, read)
    assert amacrine.about(again).dropped == want
    for pair in ((path, again), (read, path)):
        assert amacrine.compare(*pair).dropped == [lost, lost]
        assert amacrine.compare(*pair).to_dict()["reference"]["dropped"] == want
    assert json.loads(program("compare", path, again, "--json"))["dropped"] == [lost, lost]
    amacrine.write(again, np.asarray(events))
    assert amacrine.about(again).dropped is None
    assert amacrine.compare(np.asarray(events), events).dropped == [None, 6]


def test_kinds_are_known_where_they_are_said(tmp_path: Path) -> None:
    """A file that does not say how many there are may be one of more that are silent."""
    events = np.zeros(4, amacrine.EVENT_OF_KINDS)
    events["t"], events["x"], events["channel"], events["p"] = range(4), range(4), [0, 1, 1, 2], 1
    for ending in ("csv", "npz"):
        amacrine.write(tmp_path / f"four.{ending}", events, size=(5, 5), channels=4)
    said, silent = (amacrine.read(tmp_path / f"four.{ending}") for ending in ("npz", "csv"))
    assert (said.kinds, silent.kinds) == (4, None)
    about = amacrine.about(tmp_path / "four.csv")
    assert (about.channels, about.channels_known) == (3, False)
    assert amacrine.about(tmp_path / "four.npz").channels_known
    for pair in ((said, silent), (silent, said), (tmp_path / "four.npz", silent)):
        assert amacrine.compare(*pair).equal


def test_kinds_are_kept(tmp_path: Path, frames: Frames) -> None:
    events = amacrine.Sensor(kernels(3), 0.5).events(frames, FPS)
    path = tmp_path / "kinds.npy"
    amacrine.write(path, events, channels=5)
    assert amacrine.read(path).tobytes() == events.tobytes()
    assert amacrine.about(path).channels == 5
    with pytest.raises(amacrine.Error, match="kinds of cells"):
        amacrine.write(tmp_path / "kinds.evt2", events)


def test_events_know_their_sensor(tmp_path: Path) -> None:
    """Silent columns, silent kinds and what was watched after the last event are not lost."""
    frames = np.zeros((12, 20, 30), np.uint8)
    frames[3:, 4:8, 4:8] = 200
    events = amacrine.Sensor(kernels(2), [0.5, 1e6]).events(frames, FPS)
    assert len(events) and events["channel"].max() == 0 and events["x"].max() < 20
    span = 0.0, 11 / FPS
    assert (events.sensor_size, events.kinds, events.span) == ((20, 30), 2, span)
    assert amacrine.events.voxels(events, bins=9, window=0.1).shape[1:] == (2, 9, 20, 30)
    assert amacrine.events.time_surfaces(events, [0.1], tau=0.01).shape[1] == 2
    assert amacrine.events.event_frames(events, count=10).shape[1] == 2

    path = tmp_path / "events.npy"
    amacrine.write(path, events)
    about = amacrine.about(path)
    assert (about.size, about.channels) == ((20, 30), 2)
    assert about.span_us == tuple(round(time * 1e6) for time in span)
    again = amacrine.read(path)
    assert again.kinds == 2 and again.span == pytest.approx(span, abs=1e-6)
    # The same doubles come back, of whole microseconds.
    for us in ((200_000, 1_800_000), (0, 58_000), (1, 33_333)):
        ends = (us[0] / 1e6, us[1] / 1e6)
        amacrine.write(path, events[:0], span=ends)
        assert amacrine.read(path).span == ends
    assert again.dropped is not None and not any(again.dropped.values())
    assert amacrine.compare(again, events).equal
    # Of a part nobody knows from when to when it is.
    part = again[: len(again) // 2]
    assert part.kinds == 2 and part.sensor_size == (20, 30) and part.span is None
    amacrine.write(path, part, span=(0.0, 2.0))
    assert amacrine.about(path).span_us == (0, 2_000_000)
    later = events.copy()
    later["t"] += 1_700_000_000_000_000
    amacrine.write(path, later)
    assert amacrine.about(path).span_us == (later["t"].min(), later["t"].max())
    with pytest.raises(amacrine.Error, match="two times in seconds"):
        amacrine.write(path, part, span=(2.0, 0.0))
    part["channel"][-1] = 1
    with pytest.raises(amacrine.Error, match="events of channel 1"):
        amacrine.write(path, part, channels=1)


@pytest.mark.parametrize("ending", ["csv", "txt", "npz", "hdf5", "parquet"])
def test_addresses_that_the_fields_do_not_hold_are_refused(ending: str, tmp_path: Path) -> None:
    """They are never negative numbers."""
    path = tmp_path / f"wide.{ending}"
    wide = np.array([(0, 32767, 0, 1), (1, 40000, 0, 1)], [("t", "i8"), ("x", "u2"), ("y", "u2"), ("p", "u1")])
    amacrine.write(path, wide[:1], size=(8, 50000))
    assert amacrine.read(path)["x"].tolist() == [32767]
    amacrine.write(path, wide)
    with pytest.raises(amacrine.Error, match="event 1: x is 40000.*no more than 32767"):
        amacrine.read(path)
    assert amacrine.about(path).size == (1, 40001)
    assert amacrine.compare(path, path).equal


@pytest.mark.parametrize("ending", ["npy", "npz", "hdf5", "parquet"])
def test_names_of_kinds_are_kept(ending: str, tmp_path: Path, frames: Frames) -> None:
    called = ["on centre", "edges", "rest"]
    events = amacrine.Sensor(kernels(3), 0.5, names=called).events(frames, FPS)
    path, again = tmp_path / f"kinds.{ending}", tmp_path / f"again.{ending}"
    amacrine.write(path, events)
    assert amacrine.about(path).names == called
    read = amacrine.read(path)
    assert type(read["t"]) is np.ndarray and read.tobytes() == events.tobytes()
    amacrine.write(again, read[read["channel"] < 2])
    assert amacrine.about(again).names == called and amacrine.about(again).channels == 3
    amacrine.write(again, pickle.loads(pickle.dumps(read)))
    assert amacrine.about(again).names == called
    amacrine.write(again, read, names=["a", "b", "c"])
    assert amacrine.about(again).names == ["a", "b", "c"]
    amacrine.write(again, read, names=[])
    assert amacrine.about(again).names == []
    with pytest.raises(amacrine.Error, match="2 names for 3 kinds"):
        amacrine.write(again, read, names=["a", "b"])


def test_kinds_that_come_late_are_told(tmp_path: Path) -> None:
    """A text says by its events how many kinds there are."""
    path = tmp_path / "late.csv"
    rows = "".join(f"{t},1,0,1,0\n" for t in range(20_000))
    path.write_text(f"t,x,y,p,channel\n{rows}20000,0,0,0,1\n")
    read = amacrine.read(path)
    assert read.dtype == amacrine.EVENT_OF_KINDS and amacrine.about(path).channels == 2
    assert read["t"].tolist() == list(range(20_001))
    assert read["channel"].tolist() == [0] * 20_000 + [1] and not read["p"][-1]


@pytest.mark.parametrize("t", ["<i8", "<u8", ">i4", "<u2"])
@pytest.mark.parametrize("x", ["<u2", "<i2", ">u2", "<i4", "u1"])
@pytest.mark.parametrize("p", ["u1", "i1", "?", "<i8"])
def test_columns_of_any_numbers(tmp_path: Path, events: Any, t: str, x: str, p: str) -> None:
    path = tmp_path / "columns.npz"
    events = events[events["t"] < 1 << 16]
    columns = dict(t=events["t"].astype(t), x=events["x"].astype(x), y=events["y"], p=events["p"].astype(p))
    np.savez(path, **columns)
    assert amacrine.read(path).tobytes() == events.tobytes()
    signs = [name for name, of in (("t", t), ("x", x), ("p", p)) if np.dtype(of).kind == "i"]
    if "p" in signs:
        np.savez(path, **{**columns, "p": np.where(events["p"] > 0, 1, -1).astype(p)})
        assert amacrine.read(path).tobytes() == events.tobytes()
    for name, value in [*((name, -2) for name in signs), *([] if p == "?" else [("p", 2)])]:
        column = columns[name].copy()
        column[2] = value
        np.savez(path, **{**columns, name: column})
        with pytest.raises(amacrine.Error, match=f"event 2.*{value}"):
            amacrine.read(path)


def test_events_taken_out_of_an_array_are_parts(tmp_path: Path, events: Any) -> None:
    amacrine.write(tmp_path / "few.npy", list(events[:5]))
    assert amacrine.read(tmp_path / "few.npy").tobytes() == events[:5].tobytes()
    amacrine.write(tmp_path / "few.npy", [events[:4], events[4]])
    assert amacrine.read(tmp_path / "few.npy").tobytes() == events[:5].tobytes()


def test_paths_of_any_kind(tmp_path: Path, frames: Frames, events: Any) -> None:
    """Each is taken by what reads and by what shows."""
    np.save(tmp_path / "clip.npy", frames)
    amacrine.write(tmp_path / "e.npy", events)
    entries = {entry.name: entry for entry in os.scandir(tmp_path)}
    for path in entries["clip.npy"], PurePath(tmp_path / "clip.npy"):
        assert np.array_equal(amacrine.load(path, fps=10)[0], frames)
    for path in entries["e.npy"], PurePath(tmp_path / "e.npy"):
        assert amacrine.read(path).tobytes() == events.tobytes()


def test_any_fields(tmp_path: Path, events: Any) -> None:
    other = np.zeros(len(events), [("p", "?"), ("y", ">u4"), ("x", "<u8"), ("t", "<u4")])
    for name in ("t", "x", "y", "p"):
        other[name] = events[name]
    amacrine.write(tmp_path / "other.npy", other)
    assert amacrine.read(tmp_path / "other.npy").tobytes() == events.tobytes()


def test_compare_is_that_of_the_program(
    program: Callable[..., str], tmp_path: Path, frames: Frames, events: Any
) -> None:
    judged = amacrine.Sensor("csdvs-5", 0.12).events(frames, FPS)
    a, b = tmp_path / "a.npy", tmp_path / "b.npy"
    amacrine.write(a, events, size=(61, 83))
    amacrine.write(b, judged, size=(61, 83))
    stated = json.loads(program("compare", a, b, "--json"))
    for answer in (
        amacrine.compare(a, b),
        amacrine.compare(events, judged, size=(61, 83)),
        amacrine.compare(str(a), judged),
    ):
        of = answer.to_dict()
        for name in ("events", "on", "off", "matched", "precision", "recall", "time_error_us"):
            assert of[name] == stated[name], name
        for name in ("headline", "curve", "ruler"):
            assert of[name] == stated[name], name
    same = amacrine.compare(events, events)
    assert same.equal and same.headline.kept == 1
    assert 0 < amacrine.compare(events, judged, within=1e-3).headline.kept < 1


def test_a_file_that_says_no_kinds_is_compared_as_an_array_as_well(
    program: Callable[..., str], tmp_path: Path
) -> None:
    """What saw only its first kind, or has no place for kinds, is of as many as the other."""
    several = np.zeros(40, amacrine.EVENT_OF_KINDS)
    several["t"], several["x"] = np.arange(40) * 1000, np.arange(40) % 7
    several["channel"] = np.arange(40) % 2
    first, a = several[several["channel"] == 0], tmp_path / "a.npy"
    amacrine.write(a, several, size=(4, 8))
    for name, text in (
        ("zeros.csv", "t,x,y,p,channel\n" + "".join(f"{t},{x},0,0,0\n" for t, x, *_ in first.tolist())),
        ("none.csv", "t,x,y,p\n" + "".join(f"{t},{x},0,0\n" for t, x, *_ in first.tolist())),
    ):
        b = tmp_path / name
        b.write_text(text, encoding="utf-8")
        stated = json.loads(program("compare", a, b, "--json"))["headline"]["kept"]
        for reference, judged in (
            (a, b), (amacrine.read(a), b), (a, amacrine.read(b)), (amacrine.read(a), amacrine.read(b)),
            (several, amacrine.read(b)), (several, b),
        ):
            answer = amacrine.compare(reference, judged, size=(4, 8))
            assert answer.headline.kept == stated
            back = amacrine.compare(judged, reference, size=(4, 8))
            assert back.matched == answer.matched == len(first)
    # A column of zeros says no more than no column does; of several kinds it is the first.
    assert amacrine.compare(a, first, size=(4, 8)).headline.kept == stated
    plain = np.zeros(3, amacrine.EVENT)
    assert amacrine.compare(first[:3], plain, size=(4, 8)).events == [3, 3]
    for wrong in (plain, amacrine.Sensor("dvs", 0.1).events(np.zeros((2, 4, 8), np.uint8), 10)):
        with pytest.raises(amacrine.Error, match="has several kinds of cells, the judged packet one kind"):
            amacrine.compare(several, wrong, size=(4, 8))


def test_compare_runs_the_sensor_of_the_reference(
    program: Callable[..., str], tmp_path: Path
) -> None:
    scene, at = "pattern:disc?width=48&height=40&frames=12&fps=50", tmp_path / "s.toml"
    sensor, higher = (amacrine.Sensor("csdvs-5", of, format="f64") for of in (0.1, 0.12))
    at.write_text(sensor.text, encoding="utf-8")
    frames, fps = amacrine.load(scene)
    reference, judged = (one.events(frames, fps, scale=1) for one in (sensor, higher))
    a, b = tmp_path / "a.npy", tmp_path / "b.npy"
    for path, events in (a, reference), (b, judged):
        amacrine.write(path, events)
    stated = json.loads(program("compare", a, b, "--sensor", at, "--scene", scene, "--json"))
    for answer in (
        amacrine.compare(a, b, sensor=sensor, scene=scene),
        amacrine.compare(reference, judged, sensor=sensor, scene=frames, fps=fps, scale=1),
    ):
        of = answer.to_dict()["headline"]
        for name, value in of.items():
            assert value == stated["headline"][name], name
        assert of["threshold_equivalent_percent"] > 0 and of["tuned"]
    with pytest.raises(amacrine.Error, match="(?s)is not what .*, fps, upsample and seed.*leave sensor out"):
        amacrine.compare(b, a, sensor=sensor, scene=scene)
    with pytest.raises(amacrine.Error, match="scene needs sensor"):
        amacrine.compare(a, b, scene=scene)
    with pytest.raises(amacrine.Error, match="sensor = 3 is no path"):
        amacrine.compare(a, b, sensor=3)


def test_a_clip_is_an_array(tmp_path: Path, frames: Frames) -> None:
    clip, fps = amacrine.load()
    assert clip.shape == (72, 256, 256) and clip.dtype == np.uint8 and fps == 10
    np.save(tmp_path / "light.npy", frames / 255)
    light, fps = amacrine.load(str(tmp_path / "light.npy"), fps=50, scale=200)
    assert light.dtype == np.float64 and fps == 50
    np.testing.assert_array_equal(light, frames / 255 * 200)
    assert len(amacrine.load(frames=3)[0]) == 3


def test_missing_pictures_and_repeats_are_said(tmp_path: Path) -> None:
    for n in (1, 2, 3, 4, 7, 8):
        picture = bytes([n * 20] * 12)
        (tmp_path / f"f{n}.pgm").write_bytes(b"P5 4 3 255\n" + picture)
    with pytest.warns(amacrine.Caution, match="2 pictures are missing in the numbering"):
        amacrine.load(tmp_path, fps=50)
    clip = np.random.default_rng(1).integers(0, 255, (10, 1, 32, 32)).astype(np.uint8)
    twice = np.repeat(clip[:, 0], 2, axis=0)
    header = b"YUV4MPEG2 W32 H32 F10:1 Cmono\n"
    frames = b"".join(b"FRAME\n" + frame.tobytes() for frame in twice)
    (tmp_path / "twice.y4m").write_bytes(header + frames)
    with pytest.warns(amacrine.Caution, match="10 of 20 frames repeat the frame before"):
        amacrine.load(tmp_path / "twice.y4m")
    with pytest.warns(amacrine.Caution, match="10 of 20 frames repeat the frame before"):
        amacrine.Sensor("dvs", 20.0).events(twice, 50)


@pytest.mark.parametrize("kind", ["numpy", "torch"])
@pytest.mark.parametrize("shape", [(2, 3, 4, 5), (2, 4, 5, 3), (2, 4, 5, 4), (1, 2, 3, 4, 5)])
def test_colour_is_made_gray_as_the_program_does(shape: tuple[int, ...], kind: str) -> None:
    """In every layout, of arrays and of tensors."""
    given: Any = np.random.default_rng(2).integers(0, 255, shape).astype(np.uint8)
    axis = len(shape) - 3 if shape[-1] == 5 else len(shape) - 1
    colour = np.moveaxis(given, axis, -1)[..., :3].reshape(2, 4, 5, 3)
    if kind == "torch":
        given = pytest.importorskip("torch").from_numpy(given)
    sensor = amacrine.Sensor("dvs", 20.0)
    with pytest.raises(amacrine.Error) as error:
        sensor.events(given, 50)
    told = str(error.value).split("such as ")[1]
    gray = eval(told, {"frames": given})
    want = colour @ [0.299, 0.587, 0.114]
    np.testing.assert_allclose(np.asarray(gray).reshape(2, 4, 5), want, rtol=1e-5)
    sensor.events(gray, 50, scale=1)


def test_a_rate_that_is_assumed_is_said(tmp_path: Path, frames: Frames) -> None:
    np.save(tmp_path / "light.npy", frames)
    with pytest.warns(amacrine.Caution, match="240 frames per second are assumed.*fps="):
        _, fps = amacrine.load(tmp_path / "light.npy")
    assert fps == 240
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        amacrine.load(tmp_path / "light.npy", fps=240)
        amacrine.load("pattern:bar?width=16&height=16&frames=3&fps=50")


def test_the_rate_of_a_program_is_that_of_the_command_line(
    program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    np.save(tmp_path / "light.npy", frames)
    shown = ("exec", "dvs/snap", "--image", tmp_path / "light.npy", "--json")
    stated = json.loads(program(*shown, "--events", tmp_path / "events.npy"))
    snap = amacrine.Program.from_file("dvs/snap")
    with pytest.warns(amacrine.Caution, match="dvs/snap.scamp: 240 frames per second are assumed"):
        events = snap.run(frames).events
    assert stated["light"]["assumed_fps"] == 240
    assert np.array_equal(events, np.load(tmp_path / "events.npy"))
    said = amacrine.Program.from_text(snap.text.replace("//! frames", "//! fps = 50\n//! frames"))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert snap.run(frames, 240.0).events.tobytes() == events.tobytes()
        snap.run(frames[:1])
        assert said.run(frames).events["t"].max() == 220_000
    assert not any("assumed" in str(one.message) for one in told)


def test_frames_between_two_microseconds_are_at_the_later(
    program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    """As on the command line, for the span too: frame 5 of 128 a second is at 39062.5 us."""
    np.save(tmp_path / "light.npy", frames[:6])
    shown = ("--scene", tmp_path / "light.npy", "--fps", 128)
    program("run", *shown, "--sensor", "dvs", "-o", tmp_path / "run.npy")
    program("exec", "dvs/snap", *shown, "--events", tmp_path / "exec.npy")
    sensor, snap = amacrine.Sensor.from_file("dvs"), amacrine.Program.from_file("dvs/snap")
    stream = sensor.stream(128)
    made: dict[str, Any] = {
        "run": [
            sensor.events(frames[:6], 128),
            np.concatenate([stream.events(frames[:2]), stream.events(frames[2:6])]),
        ],
        "exec": [snap.run(frames[:6], 128).events],
    }
    for name, several in made.items():
        want = tmp_path / f"{name}.npy"
        assert amacrine.read(want).span == (0.0, 0.039063)
        for events in several:
            amacrine.write(tmp_path / "own.npy", events)
            assert (tmp_path / "own.npy").read_bytes() == want.read_bytes(), name


def test_a_data_frame_is_events(tmp_path: Path, events: Any) -> None:
    pandas = pytest.importorskip("pandas")
    amacrine.write(tmp_path / "frame.npy", pandas.DataFrame(events))
    assert amacrine.read(tmp_path / "frame.npy").tobytes() == events.tobytes()
    got = amacrine.events.voxels(pandas.DataFrame(events), bins=3)
    assert np.array_equal(got, amacrine.events.voxels(events, bins=3))


def test_events_know_the_size_of_their_sensor(tmp_path: Path, events: Any) -> None:
    assert events.sensor_size == (61, 83)
    part = events[events["x"] < 40]
    amacrine.write(tmp_path / "part.npy", part)
    about = amacrine.about(tmp_path / "part.npy")
    assert about.size == (61, 83) and about.size_known
    again: Any = amacrine.read(tmp_path / "part.npy")
    assert again.sensor_size == pickle.loads(pickle.dumps(again)).sensor_size == (61, 83)
    # What is said goes first; of bare arrays nothing is known.
    amacrine.write(tmp_path / "other.npy", part, size=(70, 90))
    assert amacrine.about(tmp_path / "other.npy").size == (70, 90)
    bare = np.array(part.view(np.ndarray))
    amacrine.write(tmp_path / "bare.npy", bare)
    assert amacrine.about(tmp_path / "bare.npy").size == (
        int(bare["y"].max()) + 1,
        int(bare["x"].max()) + 1,
    )


def test_one_kind_is_not_judged_against_several(tmp_path: Path, frames: Frames) -> None:
    several = np.asarray(amacrine.Sensor(kernels(2), 0.4).events(frames, FPS))
    one = np.asarray(amacrine.Sensor(kernels(1), 0.4).events(frames, FPS))
    amacrine.write(tmp_path / "one.npy", one)
    amacrine.write(tmp_path / "several.npy", several)
    pairs: list[tuple[Any, Any]] = [
        (several, one),
        (one, several),
        (several, tmp_path / "one.npy"),
        (tmp_path / "several.npy", one),
    ]
    for pair in pairs:
        with pytest.raises(amacrine.Error, match="kinds? of cells"):
            amacrine.compare(*pair)
    assert amacrine.compare(several, tmp_path / "several.npy")["f1"] == 1
    table: Any = pytest.importorskip("pandas").DataFrame(several)
    assert amacrine.compare(table, several)["f1"] == 1
    with pytest.raises(amacrine.Error, match="kinds? of cells"):
        amacrine.compare(table, one)


def test_kinds_that_are_known_are_compared_as_those_of_files(
    tmp_path: Path, frames: Frames, program: Callable[..., str]
) -> None:
    three = amacrine.Sensor(kernels(3), 0.4).events(frames, FPS)
    two = amacrine.Sensor(kernels(2), 0.4).events(frames, FPS)
    for name, events in (("three", three), ("two", two)):
        amacrine.write(tmp_path / f"{name}.npz", events)
    for pair in (
        (three, two),
        (two, three),
        (three, tmp_path / "two.npz"),
        (tmp_path / "three.npz", two),
    ):
        with pytest.raises(amacrine.Error, match="channels"):
            amacrine.compare(*pair)


def test_compare_warns_as_the_program_does(
    tmp_path: Path, frames: Frames, program: Callable[..., str]
) -> None:
    events = amacrine.Sensor(kernels(2), 0.4).events(frames, FPS)
    for path, names in (("a", ["on", "off"]), ("b", ["off", "on"])):
        amacrine.write(tmp_path / f"{path}.npz", events, names=names)
    a, b = tmp_path / "a.npz", tmp_path / "b.npz"
    stated = json.loads(program("compare", a, b, "--json"))["warnings"]
    assert "kind 0 is `off`" in stated[0]["seen"]
    for pair in ((a, b), (amacrine.read(a), amacrine.read(b)), (a, amacrine.read(b))):
        with pytest.warns(amacrine.Caution, match="kind 0 is `off`"):
            told = amacrine.compare(*pair).to_dict()["warnings"]
        assert [one["seen"] for one in told] == [one["seen"] for one in stated]
    with pytest.warns(amacrine.Caution, match="no event at all"):
        amacrine.compare(events, events[:0])


def test_a_part_of_a_clip_is_that_of_numpy() -> None:
    whole, fps = amacrine.load("pattern:noise?width=20&height=12&frames=9&fps=100")
    part, rate = amacrine.load(
        "pattern:noise?width=20&height=12&frames=9&fps=100", slice="20ms..7", crop="8x6+3+2"
    )
    assert rate == fps and np.array_equal(part, whole[2:7, 2:8, 3:11])
    small, _ = amacrine.load(
        "pattern:noise?width=20&height=12&frames=9&fps=100", resize="5x3"
    )
    np.testing.assert_allclose(small, whole.reshape(9, 3, 4, 5, 4).mean(axis=(2, 4)))
    odd: list[tuple[dict[str, Any], str]] = [
        ({"slice": "5..2"}, "FROM is not before TO"),
        ({"crop": "8"}, "WIDTHxHEIGHT"),
        ({"resize": "40x24"}, "not larger"),
        ({"resize": "4x2+1+1"}, "WIDTHxHEIGHT"),
    ]
    for how, words in odd:
        with pytest.raises(amacrine.Error, match=words):
            amacrine.load("pattern:noise?width=20&height=12&frames=9&fps=100", **how)


def test_parts_of_events_are_one_after_the_other(tmp_path: Path) -> None:
    whole = np.zeros(9, amacrine.EVENT)
    whole["t"] = np.arange(9) * 1000
    amacrine.write(tmp_path / "a.npy", whole, size=(5, 8), names=["change"], span=(0, 1))
    read = amacrine.read(tmp_path / "a.npy")
    assert read.names == ["change"]
    # Of one length, and of two, which numpy joins to no array.
    for parts in ([read[:3], read[3:6], read[6:]], (read[:4], read[4:])):
        amacrine.write(tmp_path / "b.npy", parts)
        again = amacrine.read(tmp_path / "b.npy")
        assert again.tobytes() == whole.tobytes()
        assert (again.sensor_size, again.names) == ((5, 8), ["change"])
        voxels = amacrine.events.voxels(parts, bins=2, window=0.01)
        # Parts do not know the span, of a second.
        want = amacrine.events.voxels(read, bins=2, window=0.01)
        assert len(want) == 100 and not want[1:].any()
        assert np.array_equal(voxels, want[:1])
        assert amacrine.compare(parts, read).f1 == 1
    wide = read.astype([(name, "<i8") for name in "tpxy"])[["t", "p", "x", "y"]]
    with pytest.raises(amacrine.Error, match="parts of events that cannot be joined"):
        amacrine.write(tmp_path / "c.npy", [read, wide])


def test_the_advice_on_parts_joins_them() -> None:
    one, two = np.zeros(3, amacrine.EVENT), np.zeros(2, amacrine.EVENT_OF_KINDS)
    two["channel"] = 1
    for parts in ([two, one], [one, two], [one[["t", "p", "x", "y"]], two]):
        with pytest.raises(amacrine.Error, match="parts of events that cannot be joined") as wrong:
            amacrine.events.voxels(parts, bins=1)
        said = re.search(r"dtype: ((\w+)\(part, \S+\)), which is in ([\w.]+),", str(wrong.value))
        assert said is not None, wrong.value
        call, name, module = said.groups()
        names = {"amacrine": amacrine, name: getattr(importlib.import_module(module), name)}
        mended = [eval(call, {**names, "part": part}) for part in parts]
        assert amacrine.events.voxels(mended, bins=1).sum(axis=(0, 2, 3, 4)).tolist() == [-3, -2]
    with pytest.raises(amacrine.Error, match="give a structured array with the fields t, x, y and p"):
        amacrine.events.voxels([one, one[["t", "x"]]], bins=1)


def test_one_camera_of_several_is_read() -> None:
    data = Path(__file__).parents[2] / "tests/data/event"
    with pytest.raises(amacrine.Error, match=r"two streams of events, 0 and 1[\s\S]*stream=N"):
        amacrine.read(data / "two_cameras.aedat4")
    left, right = (amacrine.read(data / "two_cameras.aedat4", stream=n) for n in (0, 1))
    assert (left.sensor_size, right.sensor_size) == ((4, 6), (5, 8))
    assert (len(left), right["t"].tolist()) == (3, [12, 25])
    assert amacrine.about(data / "two_cameras.aedat4", stream=1).size == (5, 8)
    with pytest.raises(amacrine.Error, match="no stream of events of number 2"):
        amacrine.read(data / "two_cameras.aedat4", stream=2)
