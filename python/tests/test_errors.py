"""Every mistake is one exception, with what is wrong and what to do, in the words of the command
line."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any, Callable

import amacrine
import numpy as np
import pytest
from conftest import ROOT, Frames, kernels

GOOD = np.zeros((3, 8, 8), np.uint8)


def sensor() -> amacrine.Sensor:
    return amacrine.Sensor("dvs", 0.1)


def _wide() -> Any:
    """A long clip that takes no memory."""
    return np.broadcast_to(np.uint8(0), (3_000_000, 512, 512))


def _few() -> Any:
    return np.array([(5, 1, 2, 1)], amacrine.EVENT)


def _odd(field: str, value: int) -> Any:
    """Two events, something of the second of which is wrong."""
    events = np.array([(5, 1, 2, 1), (6, 1, 2, 0)], amacrine.EVENT)
    events[field][1] = value
    return events


def _any(of: Any) -> Any:
    """What the types do not let through."""
    return of


class NoArray:
    """What numpy makes no array of, as an xarray.Dataset, or a tensor that has a gradient."""

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise RuntimeError("none of it")


class NoTable:
    """A data frame whose columns have the same names."""

    def to_records(self, index: bool) -> Any:
        raise ValueError("a column twice")


LARGE = np.zeros((4, 8, 300), np.uint8)

EXACT_SUM = (
    'sum="zero", and exact weights keep the sum that they have\n'
    'help: give a quantiser (to="int-5"), or leave sum out'
)

LARGER: dict[str, Callable[[], Any]] = {
    "design": lambda: amacrine.design("dvs", thresholds=9, scene=LARGE, fps=9, effort=0),
    "quantise": lambda: amacrine.quantise(
        "dvs", "ternary", thresholds=9, scene=LARGE, fps=9, effort=0
    ),
    "quantise of two": lambda: amacrine.quantise(
        ["dvs", "sobel-x"], "ternary", thresholds=9, scene=LARGE, fps=9, effort=0
    ),
    "waterfall": lambda: amacrine.waterfall("dvs", 9, scene=LARGE, fps=9, effort=0),
    "trade": lambda: amacrine.trade(amacrine.Program.from_file("dvs/snap"), LARGE, fps=9),
}

MISTAKES: dict[str, tuple[Callable[[], Any], str]] = {
    "memory of no word": (lambda: amacrine.Sensor("dvs", 1, memory=_any(np.array([]))), "memory = "),
    "rows of a dead time": (
        lambda: amacrine.Sensor("dvs", 1, refractory=_any([[1], [1, 2]])), "`refractory` takes a table"
    ),
    "names of no axes": (lambda: amacrine.Sensor("dvs", 1, names=_any(np.array(3))), "list of names"),
    "rows of names": (lambda: amacrine.Sensor("dvs", 1, names=_any([[["a"], []]])), "list of names"),
    "written names of no axes": (
        lambda: amacrine.write("x.npy", _few(), names=_any(np.array(3))), "names = array(3)"
    ),
    "keep of no axes": (lambda: _snap(keep=np.array(3)), "keep = array(3)"),
    "without of no axes": (lambda: _snap(without=np.array(3)), "without = array(3)"),
    "parts of no axes": (
        lambda: sensor().voxel_windows(_any(np.array(3)), 9, bins=1, window=1), "parts = array(3)"
    ),
    "dtype of a table": (
        lambda: sensor().voxels(GOOD, 9, bins=1, dtype=_any({"readout": "scan"})), "float16, float32"
    ),
    "windows in an array": (
        lambda: sensor().voxels(GOOD, 9, window=_any(np.array([1, 2]))), "give bins"
    ),
    "a pair that is no clip": (lambda: sensor().events((GOOD, [[1], [1, 2]]), 9), "are no array"),
    "sum of exact weights": (
        lambda: amacrine.Sensor("dvs", 1, memory="filtered-snap").on_chip(sum="zero"), EXACT_SUM
    ),
    "sum of a compiled kernel": (lambda: amacrine.compile("dvs", 9, sum="zero"), EXACT_SUM),
    "sum of a filter": (lambda: amacrine.compile_filter("dvs", to="none", sum="zero"), EXACT_SUM),
    "even kernel": (lambda: amacrine.Sensor(np.ones((4, 4)), 1), "must be odd"),
    "kernel of text": (lambda: amacrine.Sensor(np.array(["a"]), 1), "floats or integers"),
    "kernel axes": (lambda: amacrine.Sensor(np.ones((2, 2, 3, 3)), 1), "(K,1,k,k)"),
    "kernel nan": (lambda: amacrine.Sensor(np.full((3, 3), np.nan), 1), "weights must be finite"),
    "kernel name": (lambda: amacrine.Sensor("csdvs-55", 1), "neither built in nor a file"),
    "thresholds": (lambda: amacrine.Sensor(kernels(3), [1, 2]), "2 thresholds for 3 kernels"),
    "threshold": (lambda: amacrine.Sensor("dvs", 0), "above 0"),
    "memory": (lambda: amacrine.Sensor("dvs", 1, memory="snap"), "filtered-snap, raw-snap"),
    "authors' memory": (
        lambda: amacrine.Sensor("dvs", 1, memory="authors-pixel-step"), "Sensor.from_text"
    ),
    "masked frames": (lambda: sensor().events(np.ma.masked_less(GOOD, 1), 9), ".filled(0)"),
    "masked frame": (lambda: sensor().events([np.ma.array(GOOD[0])], 9), "mask"),
    "masked kernel": (lambda: amacrine.Sensor(np.ma.array(np.ones((3, 3))), 1), "kernels of a masked"),
    "masked kernels": (lambda: amacrine.Sensor(["dvs", np.ma.array(np.ones((3, 3)))], 1), "mask"),
    "masked events": (
        lambda: amacrine.compare(np.ma.array(_few()), _few(), size=(8, 8)), "events of a masked"
    ),
    "response": (lambda: amacrine.Sensor("dvs", 1, response={"lin": 2}), "unknown key `lin`"),
    "format": (lambda: amacrine.Sensor("dvs", 1, format="f12").events(GOOD, 9), "f12"),
    "sensor file": (lambda: amacrine.Sensor.from_file("rgc-5"), "rgc-4"),
    "fps": (lambda: sensor().events(GOOD, 0), "0 frames per second is no rate"),
    "axes": (lambda: sensor().events(GOOD[0], 9), "(T,H,W), (T,1,H,W) or (B,T,1,H,W)"),
    "colour": (lambda: sensor().events(np.zeros((3, 3, 8, 8), "u1"), 9), "(3, 3, 8, 8)"),
    "no scale": (lambda: sensor().events(GOOD / 255, 9), "scale=255 where they are 0 to 1"),
    "scale": (lambda: sensor().events(GOOD / 255, 9, scale=-1), "above 0"),
    "bool": (lambda: sensor().events(GOOD > 0, 9), "uint8, or floats with a scale"),
    "scale of bool": (lambda: sensor().events(GOOD > 0, 9, scale=0), "above 0"),
    "nan": (lambda: sensor().events(GOOD + np.nan, 9, scale=1), "not finite"),
    "dark": (lambda: sensor().events(GOOD - 1.0, 9, scale=1), "below zero"),
    "bins": (lambda: sensor().voxels(GOOD, 9, bins=0), "1 to 1000"),
    "no window": (lambda: sensor().voxels(GOOD, 9, bins=3, window=0), "the window is 0 s"),
    "polarity": (lambda: sensor().voxels(GOOD, 9, bins=3, polarity="on"), "signed, split"),
    "share": (lambda: sensor().voxels(GOOD, 9, bins=3, share="all"), "bilinear, whole"),
    "normalise": (lambda: sensor().voxels(GOOD, 9, bins=3, normalise="l2"), "none, std, max"),
    "voxels of": (lambda: sensor().voxels(GOOD, 9, bins=3, dtype="i4"), "float16, float32"),
    "room": (lambda: sensor().voxels(GOOD, 9, bins=999, window=1, every=1e-6), "memory"),
    "room for events": (
        lambda: amacrine.events.voxels(_few(), bins=999, window=1, every=1e-6, end=1e8), "voxels"
    ),
    "no fields": (lambda: amacrine.events.voxels(np.zeros(3), bins=3), "have no fields"),
    "no size": (lambda: amacrine.events.event_frames(np.zeros(0, amacrine.EVENT), 3), "size"),
    "tau": (lambda: amacrine.events.time_surfaces(_few(), 1, tau=0), "tau is 0 s"),
    "times": (lambda: amacrine.events.time_surfaces(_few(), -1, tau=1), "from 0 on"),
    "decay": (
        lambda: amacrine.events.time_surfaces(_few(), 1, tau=1, decay="log"), "exponential, linear"
    ),
    "event frames": (lambda: amacrine.events.event_frames(_few(), 0), "count = 0"),
    "fill": (lambda: amacrine.events.event_frames(_few(), 1, fill="x"), "count, last"),
    "study": (lambda: amacrine.sweep("no-such"), "formats"),
    "study key": (lambda: amacrine.sweep("formats", "x", set={"fromat": "f32"}), "format"),
    "study set": (
        lambda: amacrine.sweep("formats", "x", set="format=f32"),  # type: ignore[arg-type]
        'set={"format": "f32"}',
    ),
    "shards": (lambda: amacrine.sweep("formats", "x", shards=2), "without a client"),
    "window": (lambda: sensor().voxels(GOOD, 9, window=1), "give bins"),
    "size": (lambda: sensor().events(np.zeros((2, 0, 8), "u1"), 9), "cannot be addressed"),
    "too many": (
        lambda: amacrine.Sensor("dvs", 0.1, max_events=1).events(_steps(), 9),
        "the event list is full: more than 1 events",
    ),
    "quantiser": (lambda: sensor().on_chip("int-99"), "int-"),
    "chip": (lambda: sensor().on_chip(chip="scamp6"), "there is no chip `scamp6`"),
    "domain": (lambda: _on_chip().with_domain("f12").events(GOOD, 9), "unknown domain `f12`"),
    "curve": (
        lambda: amacrine.Sensor("dvs", 1, response={"lin-log": {"knee": 20}}).on_chip(),
        "its response is not linear",
    ),
    "threads": (lambda: amacrine.set_threads(-1), "threads = -1"),
    "many threads": (lambda: amacrine.set_threads(10**9), "1024 at most"),
    "program": (lambda: amacrine.Program.from_text("moov(A, B);"), "moov"),
    "program file": (lambda: amacrine.Program.from_file("no/such"), "dvs/snap"),
    "register": (
        lambda: amacrine.Program.from_file("dvs/snap").run(GOOD, keep=["Z"]),
        "Z: no such register",
    ),
    "no events": (lambda: amacrine.write("x.npy", np.zeros(3)), "the fields t, x, y and p"),
    "backwards": (lambda: amacrine.write("x.npy", _events([5, 3])), 'event 1 of the array: `t` runs backwards'),
    "extension": (lambda: amacrine.write("x.tiff", _events([3])), "known are"),
    "no array of events": (lambda: amacrine.write("x.npy", _any(NoArray())), "the events are no array: none of it"),
    "columns twice": (lambda: amacrine.write("x.npy", _any(NoTable())), "no structured array: a column twice"),
    "path of bytes": (lambda: amacrine.read(b"a.npy"), "path = b'a.npy' is no path"),  # type: ignore[arg-type]
    "path like bytes": (lambda: amacrine.read(next(os.scandir(b"/"))), "is no path"),  # type: ignore[arg-type]
    "compared bytes": (lambda: amacrine.compare(b"a.npy", b"b.npy"), "reference = b'a.npy' is no path"),  # type: ignore[arg-type]
    "scene of bytes": (lambda: amacrine.load(next(os.scandir(b"/"))), "is no path"),  # type: ignore[arg-type]
    "dtype of None": (lambda: sensor().voxels(GOOD, 9, bins=1, dtype=_any(None)), "no dtype None"),
    "register that is no array": (
        lambda: amacrine.Program.from_file("dvs/snap").run(GOOD, 9, registers={"A": NoArray()}),
        "registers: A is no array: none of it",
    ),
    "file": (lambda: amacrine.read("no-such.npy"), "no-such.npy"),
    "scene": (lambda: amacrine.load("no-such.mp4"), "no-such.mp4"),
    "pattern": (lambda: amacrine.load("pattern:baar"), "baar"),
    "names": (lambda: amacrine.names("cameras"), "sensors, programs"),
    "levels": (lambda: amacrine.quantise("dvs", "int-99"), "int-"),
    "of no use": (
        lambda: amacrine.quantise("dvs", "ternary", fps=3),
        "give thresholds, too",
    ),
    "chip of no use": (
        lambda: amacrine.quantise("dvs", "ternary", chip="nope"),
        "chip needs thresholds",
    ),
    "effort of no use": (
        lambda: amacrine.quantise("dvs", "ternary", effort=-5),
        "effort needs thresholds",
    ),
    "seed of no use": (
        lambda: amacrine.quantise("dvs", ["ternary", "int-5"], seed=0),
        "seed has no effect without stochastic rounding or thresholds",
    ),
    "rates of steps": (
        lambda: amacrine.waterfall("dvs", 9, steps=True, rates=25), "leave rates out, or steps"
    ),
    "chips of steps": (
        lambda: amacrine.waterfall("dvs", 9, steps=True, chips=9), "leave chips out, or steps"
    ),
    "tiles of steps": (
        lambda: amacrine.waterfall("dvs", 9, steps=True, tiles=1), "leave tiles out, or steps"
    ),
    "frames and their rate": (
        lambda: sensor().events(amacrine.load(frames=2), 9), "frames, fps = amacrine.load(…)"
    ),
    "two kernels": (lambda: amacrine.waterfall(kernels(2), [1, 2, 3]), "3 thresholds for 2 kernels"),
    "old name": (
        lambda: _any(amacrine.quantise)("dvs", "ternary", threshold=20), "give thresholds=20"
    ),
    "old name of a fall": (
        lambda: _any(amacrine.waterfall)("dvs", threshold=20), "it is called thresholds"
    ),
    "old name of a page": (
        lambda: _any(amacrine.feasibility)("dvs", threshold=20), "it is called thresholds"
    ),
    "two thresholds": (
        lambda: amacrine.waterfall("dvs", [1, 2]), "2 thresholds for 1 kernels"
    ),
    "no readout": (lambda: sensor().events(GOOD, 9, readout="scanner"), "scanner"),
    "setting of a readout": (
        lambda: sensor().events(GOOD, 9, readout={"readout": "scan", "fifo": 2}), "fifo"
    ),
    "settings alone": (lambda: sensor().events(GOOD, 9, readout={"fifo": 2}), "readout = None"),
    "contrast": (lambda: sensor().events(GOOD, 9, upsample=0), "upsample=0.2"),
    "upsample of a chip": (lambda: _on_chip().events(GOOD, 9, upsample=0.2), "sees frames"),
    "upsample without bins": (lambda: sensor().voxels(GOOD, 9, upsample=0.2), "give bins"),
    "many a frame": (
        lambda: amacrine.compile("dvs", 16, events_per_frame=10**6), "a cell has one event in a frame"
    ),
    "input": (lambda: amacrine.compile_filter("dvs", input=(0, 300)), "input=(0, 127)"),
    "input of one": (lambda: amacrine.compile_filter("dvs", input=_any(9)), "input=(0, 127)"),
    "filter of zeros": (lambda: amacrine.compile_filter(np.zeros((3, 3))), "no weight but 0"),
    "no register": (lambda: _snap(registers={"Z": 1}), "Z: no such register"),
    "register of text": (lambda: _snap(registers={"A": "x"}), "registers: A"),
    "register of another size": (lambda: _snap(registers={"A": np.zeros((3, 3))}), "(H,W)"),
    "a row of a register": (
        lambda: _snap(registers={"A": np.zeros(8)}), "A: it has shape [8]; expected two axes"
    ),
    "a column of a register": (
        lambda: _snap(registers={"A": np.zeros((8, 1))}), "A is 1x8, the light is 8x8"
    ),
    "complex register": (
        lambda: _snap(registers={"A": np.zeros((8, 8), complex)}), "its numbers are complex128"
    ),
    "register of texts": (lambda: _snap(registers={"A": [["5"] * 8] * 8}), "its numbers are <U1"),
    "half a bit": (lambda: _snap(registers={"R5": 0.5}), "give 0 or 1"),
    "photodiodes": (lambda: _snap(registers={"PIX": 1}), "give light as frames"),
    "range": (lambda: amacrine.load(range="tv"), "auto, limited, full"),
    "range of a pattern": (lambda: amacrine.load("pattern:bar", range="limited"), "drawn as light"),
    "feasibility of neither": (lambda: amacrine.feasibility("dvs"), "or thresholds, and not both"),
    "kernel zero": (lambda: amacrine.quantise(np.zeros((3, 3)), "ternary"), "0"),
    "feasibility memory": (
        lambda: amacrine.feasibility("dvs", 9, memory="bits:9"), "`bits:9` is no memory"
    ),
    "rate": (lambda: sensor().events(GOOD, 1e300), "1e300 frames per second is no rate"),
    "room for counts": (lambda: sensor().counts(_wide(), 9), "counts of shape (1, 2999999, 1, "),
    "feasibility": (lambda: amacrine.feasibility("dvs", -1), "the threshold is -1"),
    "a pair": (lambda: amacrine.Sensor("dvs", (0.1, 0.2)), "[(0.2, 0.3)]"),
    "threshold of text": (lambda: amacrine.Sensor("dvs", "0.3"), "'0.3' is no threshold"),
    "threshold of nothing": (
        lambda: amacrine.Sensor("dvs", None),  # type: ignore[arg-type]
        "None is no threshold",
    ),
    "no kernels": (lambda: amacrine.Sensor(np.ones((0, 3, 3)), 1), "(0, 3, 3)"),
    "kernel of nothing": (
        lambda: amacrine.Sensor(None, 1),  # type: ignore[arg-type]
        "of type NoneType",
    ),
    "seed": (lambda: amacrine.Sensor("dvs", 1, seed=-1), "seed = -1"),
    "seed in part": (
        lambda: amacrine.Sensor("dvs", 1, seed=1.5),  # type: ignore[arg-type]
        "whole number",
    ),
    "format of numpy": (
        lambda: amacrine.Sensor("dvs", 1, format=np.float32),  # type: ignore[arg-type]
        "'f32'",
    ),
    "no fps": (lambda: sensor().events(GOOD, None), "fps = None"),  # type: ignore[arg-type]
    "fps of a scene": (lambda: amacrine.load("pattern:bar", fps=-1), "fps=240"),
    "fps of a stream": (lambda: sensor().stream(0), "0 frames per second is no rate"),
    "fps of windows": (
        lambda: sensor().voxel_windows([GOOD], 0, bins=3, window=1), "0 frames per second"
    ),
    "bins of windows": (
        lambda: sensor().voxel_windows([GOOD], 9, bins=-1, window=1), "give a whole number"
    ),
    "scale of text": (
        lambda: sensor().events(GOOD, 9, scale="x"),  # type: ignore[arg-type]
        "scale = 'x'",
    ),
    "scale of a program": (
        lambda: amacrine.Program.from_file("dvs/snap").run(GOOD, scale=-1), "above 0"
    ),
    "generator": (lambda: sensor().events((f for f in GOOD), 9), "voxel_windows"),
    "one frame": (lambda: sensor().events(GOOD[0], 9), "frames[None]"),
    "colours last": (
        lambda: sensor().events(np.zeros((3, 8, 8, 3), "u1"), 9), "+ .587 * frames[..., 1] +"
    ),
    "clips without an axis": (
        lambda: sensor().events(np.zeros((2, 5, 8, 8), "u1"), 9), "frames[:, :, None]"
    ),
    "share of frames": (lambda: sensor().voxels(GOOD, 9, share="whole"), "give bins"),
    "window of text": (
        lambda: sensor().voxels(GOOD, 9, bins=3, window="5ms"),  # type: ignore[arg-type]
        "window = '5ms'",
    ),
    "no dtype": (lambda: sensor().voxels(GOOD, 9, bins=3, dtype="bfloat16"), "float16"),
    "other fields": (
        lambda: amacrine.events.voxels(np.zeros(2, [("timestamp", "i8"), ("x", "i2")]), bins=3),
        "rename_fields",
    ),
    "seconds": (
        lambda: amacrine.write("x.npy", _few().astype([("t", "f8"), *amacrine.EVENT.descr[1:]])),
        "t * 1e6",
    ),
    "one length": (
        lambda: amacrine.write("x.npy", _few(), size=8),  # type: ignore[arg-type]
        "(height, width)",
    ),
    "two formats": (
        lambda: amacrine.write("x.npy", _few(), format="evt3"), "x.npy is the name of npy"
    ),
    "raw": (lambda: amacrine.write("x.raw", _few()), "give format"),
    "within": (lambda: amacrine.compare(_few(), _few(), within=-1), "within = -1"),
    "within nan": (lambda: amacrine.compare(_few(), _few(), within=np.nan), "from 0 on"),
    "drives": (
        lambda: amacrine.Sensor.from_file("rgc-4").on_chip("ternary", effort=0.01),
        'memory="shared"',
    ),
    "not dyadic": (lambda: amacrine.Sensor(kernels(1), 0.1).on_chip(), "with to (ternary"),
    "far too high": (
        lambda: amacrine.compile("dvs", 1e9, effort=0.01),
        "lower the threshold to 2.4e-7",
    ),
    "link": (
        lambda: amacrine.feasibility("dvs", 9, link_energy=(5, 1)),
        "(1.0, 20.0)",
    ),
    "threshold table": (
        lambda: amacrine.feasibility("dvs", {"on": 3}),  # type: ignore[arg-type]
        "thresholds = ",
    ),
    "link of three": (
        lambda: amacrine.feasibility("dvs", 9, link_energy=_any((1, 2, 3))), "(1.0, 20.0)"
    ),
    "link of text": (
        lambda: amacrine.feasibility("dvs", 9, link_energy=_any(("a", "b"))), "link_energy = 'a'"
    ),
    "chips below": (lambda: amacrine.feasibility("dvs", 9, chips=-1), "1 to 1024"),
    "chips in part": (lambda: amacrine.feasibility("dvs", 9, chips=_any(1.5)), "chips = 1.5"),
    "no flag": (lambda: amacrine.feasibility("dvs", 9, overlapped=_any("no")), "overlapped=True"),
    "tiles": (lambda: amacrine.waterfall("dvs", 9, tiles=-1), "1 to 1000"),
    "bins below": (lambda: amacrine.compare(_few(), _few(), bins=-1), "1 to 1000"),
    "bins in part": (lambda: amacrine.compare(_few(), _few(), bins=_any(1.5)), "bins = 1.5"),
    "bins nan": (lambda: amacrine.events.voxels(_few(), bins=_any(np.nan)), "bins = nan"),
    "fps of text": (lambda: amacrine.compare(_few(), _few(), fps=_any("a")), "fps = 'a'"),
    "upsample": (
        lambda: amacrine.trade(sensor(), GOOD, fps=9, upsample=_any("a")), "upsample = 'a'"
    ),
    "sample": (lambda: amacrine.trade(sensor(), GOOD, fps=9, sample=_any("a")), "sample = 'a'"),
    "runs": (lambda: amacrine.trade(sensor(), GOOD, fps=9, runs=1 << 40), "1 to 4294967295"),
    "domain of a float": (lambda: amacrine.trade(sensor(), GOOD, fps=9, domain="exact"), "a Program"),
    "bare statements": (
        lambda: amacrine.trade(amacrine.Program.from_text("mov(A, B);"), GOOD, fps=9), "`init`"
    ),
    "jobs": (lambda: amacrine.sweep("formats", "x", jobs=-1), "jobs = -1"),
    "longest point": (
        lambda: amacrine.sweep("formats", "x", max_seconds_per_point=-1), "above 0, such as"
    ),
    "set nothing": (lambda: amacrine.sweep("formats", "x", set={"format": None}), '"format"'),
    "clip": (
        lambda: amacrine.Program.from_file("dvs/snap").run(GOOD, clip=_any("off")), "clip=False"
    ),
    "constants": (
        lambda: amacrine.Program.from_file("dvs/snap", constants={"threshold": _any("a")}),
        "constants[\"threshold\"] = 'a'",
    ),
    "start": (lambda: amacrine.events.voxels(_few(), bins=1, start=_any("a")), "start = 'a'"),
    "start nan": (lambda: amacrine.events.voxels(_few(), bins=1, start=np.nan), "start = nan"),
    "end": (lambda: amacrine.events.voxels(_few(), bins=1, end=np.inf), "end = inf"),
    "kinds in part": (
        lambda: amacrine.events.voxels(_few(), bins=1, channels=_any(1.5)), "channels = 1.5"
    ),
    "many kinds": (lambda: amacrine.write("x.npy", _few(), channels=300), "1 to 255"),
    "late": (lambda: amacrine.events.time_surfaces(_few(), [1e300], tau=1), "times = 1e+300"),
    "tau of text": (
        lambda: amacrine.events.time_surfaces(_few(), 1, tau=_any("a")), "tau = 'a'"
    ),
    "count nan": (lambda: amacrine.events.event_frames(_few(), _any(np.nan)), "count = nan"),
    "large size": (lambda: amacrine.write("x.npy", _few(), size=(1 << 70, 1)), "(height, width)"),
    "no path": (lambda: amacrine.read(_any(5)), "path = 5"),
    "no name": (lambda: amacrine.Sensor.from_file(_any(5)), "path = 5"),
    "no kind of name": (lambda: amacrine.names(_any(5)), "of = 5"),
    "compression": (
        lambda: amacrine.write("x.aedat4", _few(), compression=_any(5)), "compression = 5"
    ),
    "names of kinds": (
        lambda: amacrine.write("x.npy", _few(), names=["a", "b"], channels=3), "2 names for 3 kinds"
    ),
    "parts": (lambda: sensor().voxel_windows(_any(5), 9, bins=3, window=1), "parts = 5"),
    "memory of a program": (lambda: amacrine.compile("dvs", 9, memory=_any([])), "memory = []"),
    "sum": (lambda: sensor().on_chip("ternary", sum=_any(5)), "sum = 5"),
    "polarity of an event": (
        lambda: amacrine.write("x.npy", _odd("p", 2)), "event 1 of the array: `p` is 2"
    ),
    "time of an event": (
        lambda: amacrine.events.voxels(_odd("t", -3), bins=1), "event 1 of the array: `t` is -3"
    ),
    "place of an event": (
        lambda: amacrine.compare(_odd("x", -1), _few()), "event 1 of the array: `x` is -1"
    ),
    "off the sensor": (
        lambda: amacrine.events.event_frames(_odd("y", 8), 1, size=(8, 8)),
        "event 1 of the array: `x` is 1, `y` is 8: off the sensor, which is 8x8",
    ),
    "design of both": (lambda: amacrine.design("dvs", rate=1, thresholds=2), "not both"),
    "trade of a name": (
        lambda: amacrine.trade("rgc-4", GOOD, fps=9),  # type: ignore[arg-type]
        "Sensor.from_file",
    ),
    "trade of a chip": (
        lambda: amacrine.trade(_on_chip(), GOOD, fps=9),  # type: ignore[arg-type]
        "of a ChipSensor",
    ),
    "no way back": (lambda: amacrine.gradient.forward(sensor(), GOOD[:1], 9), "at least two frames"),
    **{
        f"larger than the chip in {verb}": (do, "is 300x8, and scamp5 has 256x256 processors")
        for verb, do in LARGER.items()
    },
    "frames short": (lambda: amacrine.trade(sensor(), GOOD[:2], fps=9), "three frames"),
}


def _snap(**how: Any) -> Any:
    return amacrine.Program.from_file("dvs/snap").run(GOOD, **how)


def _on_chip() -> amacrine.ChipSensor:
    return amacrine.compile("dvs", 16, effort=0.01)


def _steps() -> Any:
    return np.stack([np.full((8, 8), 60 * n, np.uint8) for n in range(4)])


def _events(times: list[int]) -> Any:
    events = np.zeros(len(times), amacrine.EVENT)
    events["t"] = times
    return events


@pytest.mark.parametrize("mistake", MISTAKES)
def test_one_message(mistake: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    do, said = MISTAKES[mistake]
    with pytest.raises(amacrine.Error) as raised:
        do()
    assert isinstance(raised.value, ValueError)
    message = str(raised.value)
    assert said in message, message
    assert "help" in message, message
    assert "\x1b" not in message
    # What is to be done is said in arguments of Python.
    assert not re.search(r"--[a-z]", message), message
    assert not list(tmp_path.iterdir())


def test_the_words_of_the_command_line(
    program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    """The same file, refused by both: each line that the program says, Python says."""
    file = tmp_path / "wrong.toml"
    file.write_text('response = { linear = 255 }\nmemory = "filtered-step"\n[[chanel]]\n')
    stated = program(
        "run", "--scene", "pattern:bar", "--sensor", file, "--events", tmp_path / "e.npy",
        good=False,
    )
    with pytest.raises(amacrine.Error) as raised:
        amacrine.Sensor.from_file(file)
    # The program breaks its lines where the path is long.
    stated = " ".join(stated.replace("│", " ").split())
    words = ["wrong.toml:3:3: unknown key `chanel`", "did you mean `channel`?"]
    for word in words:
        assert word in stated and word in str(raised.value)


@pytest.mark.parametrize("verb", ["run --sensor", "exec"])
def test_names_that_are_not_there(program: Callable[..., str], verb: str) -> None:
    """In the words of the command line."""
    of = amacrine.Program if verb == "exec" else amacrine.Sensor
    stated = program(*verb.split(), "nope", "--scene", "pattern:bar", good=False)
    with pytest.raises(amacrine.Error) as raised:
        of.from_file("nope")
    first, help = str(raised.value).split("\n")
    assert first == "cannot read nope: No such file or directory (os error 2)" and first in stated
    assert help.split(",")[0].removeprefix("help: ") in stated
    with pytest.raises(amacrine.Error, match="did you mean `dvs/snap`"):
        amacrine.Program.from_file("dvs/snip")


def test_one_frame_is_one_frame() -> None:
    with pytest.raises(amacrine.Error, match="the frames given: 1 frame, in which nothing"):
        amacrine.trade(sensor(), GOOD[:1], fps=9)


def test_a_write_that_fails_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(amacrine.Error, match="x.npy"):
        amacrine.write(tmp_path / "file" / "x.npy", _events([3]))
    assert len(list(tmp_path.iterdir())) == 1


def test_options_are_arguments() -> None:
    """What the library says of options of the command line, as it is said here."""
    said = amacrine._amacrine.in_python
    for text, want in {
        "use more levels (another --to)": "use more levels (another to)",
        "leave the sum free (--sum free), or": 'leave the sum free (sum="free"), or',
        "leave the compression out (--compression), or": "leave the compression out (compression), or",
        "give a contrast (`--upsample`, or `upsample` in a study) such": "give a contrast (upsample) such",
        "longer (--effort); --objective words compiles it as it is": "longer (effort)",
        "while events are read (--readout overlapped): a": "while events are read (overlapped=True): a",
        "insert frames (--upsample), or --transfer srgb": 'insert frames (upsample), or transfer="srgb"',
        "a lower --threshold, or --objective exact": 'a lower thresholds, or objective="exact"',
        "help: take less, or allow more with --max-memory SIZE, such as --max-memory 5G\nx": "help: take less\nx",
        "whole scene; --verify measures them": "whole scene; verify=True measures them",
        "few events: take a larger --sample": "few events: take a larger sample",
        "the tiles, --runs N shares them": "the tiles, runs=N shares them",
        "first 6 frames (--slice ..6, or `slice` in a study), the next is the rest (--slice 6..)": (
            'first 6 frames (slice="..6" of load, and of a study), the next is the rest (slice="6..")'
        ),
        "6 frames (--slice, or `slice` in a study, in frames of the clip)": (
            "6 frames (slice of load, and of a study, in frames of the clip)"
        ),
        "leave it out (--without noise-events,leak)": 'leave it out (sensor.without("noise-events", "leak"))',
        "--without mismatch in the domain exact": 'without="mismatch" in the domain exact',
        "as separate scenes (--slice)": "as separate scenes (slice of load)",
        "leave the number out (--stream): it": "leave the number out (stream): it",
        "choose one by its number: --stream N, in Python read(path, stream=N)": "choose one by its number: read(path, stream=N)",
        "; `convert --salvage` keeps": "; `amacrine convert --salvage` keeps",
        "set it by hand (--with slots=VALUE); the": 'set it by hand (readout={…, "slots": VALUE}); the',
        "(the file says srgb; --transfer auto undoes it)": '(the file says srgb; transfer="auto" undoes it)',
        "was not undone (--transfer undoes it)": "was not undone (transfer undoes it)",
        "`exec --set A=FILE.npy`; or": "`amacrine exec --set A=FILE.npy`; or",
        "`ffmpeg -i A.gif --x`": "`ffmpeg -i A.gif --x`",
        "`amacrine sweep --x`": "`amacrine sweep --x`",
    }.items():
        assert said(text) == want
        assert said(want) == want


def test_options_that_are_calls_here(tmp_path: Path, frames: Frames) -> None:
    """What the messages say to do is what can be done."""
    spread = amacrine.Sensor("dvs", {"on": 0.1, "off": 0.1, "sigma": 0.05})
    with pytest.warns(amacrine.Caution) as caught:
        spread.events(frames, 30)
    told = " ".join(str(one.message) for one in caught)
    assert 'leave it out (sensor.without("mismatch"))' in told and "--" not in told
    assert "sigma" not in spread.without("mismatch").text
    two = np.zeros(2, amacrine.EVENT_OF_KINDS)
    two["channel"] = 0, 1
    with pytest.raises(amacrine.Error) as wrong:
        amacrine.write(tmp_path / "two.evt3", two)
    told = str(wrong.value)
    assert "or one kind: events[events['channel'] == 0][['t', 'x', 'y', 'p']]" in told
    assert "--" not in told
    amacrine.write(tmp_path / "two.evt3", two[two["channel"] == 0][["t", "x", "y", "p"]])
    with pytest.raises(amacrine.Error, match=r"leave the number out \(stream\)"):
        amacrine.read(tmp_path / "two.evt3", stream=1)


def test_no_option_is_told_of_late_times(tmp_path: Path) -> None:
    late = np.zeros(1, amacrine.EVENT)
    late["t"] = 1 << 60
    with pytest.raises(amacrine.Error) as wrong:
        amacrine.write(tmp_path / "late.evt2", late, size=(8, 8))
    assert "--" not in str(wrong.value) and "events['t'] - events['t'].min()" in str(wrong.value)


ABOVE = "help: give a number above 0, in units of the response"
TABLE = "help: give a table with on, off and, where there is mismatch, sigma"


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (0, f"thresholds = 0\n{ABOVE}"),
        (-1, f"thresholds = -1\n{ABOVE}"),
        (np.nan, f"thresholds = nan\n{ABOVE}"),
        (np.inf, f"thresholds = inf\n{ABOVE}"),
        (np.zeros(4), f"thresholds[0] = 0\n{ABOVE}"),
        ([1, 2, (3, 0), 4], f"thresholds[2] = (3, 0)\n{ABOVE.replace('a number', 'two numbers')}"),
        ({"on": 1, "of": 2}, "thresholds = {'on': 1, 'of': 2} has of and lacks off\n" + TABLE),
        ({"sigma": 2}, "thresholds = {'sigma': 2} lacks on, off\n" + TABLE),
        ({"on": 1, "off": -2}, f'thresholds["off"] = -2\n{ABOVE}'),
        ({"on": 1, "off": True}, f'thresholds["off"] = True is no number\n{ABOVE}'),
        (
            {"on": 1, "off": 2, "sigma": -1},
            f'thresholds["sigma"] = -1\n{ABOVE.replace("above 0", "of 0 or more")}',
        ),
    ],
)
def test_one_wrong_threshold_is_one_message(given: Any, told: str) -> None:
    """Of what was given, however many kernels it is for, and not of a text that was made of it; each in
    its own unit."""
    of_compile = told.replace("units of the response", "units of kernel times light (0 to 255)")
    for make, want in ((amacrine.Sensor, told), (amacrine.compile, of_compile)):
        with pytest.raises(amacrine.Error) as error:
            make(kernels(4), given)
        assert str(error.value) == want


def test_tables_of_thresholds_are_taken() -> None:
    table = {"on": 1, "off": np.float32(2), "sigma": 0}
    limits = amacrine.Sensor(kernels(2), [table, (3, 4)]).thresholds
    assert [of.tolist() for of in limits] == [[1, 2, 0], [3, 4, 0]]


@pytest.mark.parametrize("of", ["sensors", "programs", "kernels", "studies", "readouts", "chips", "patterns"])
def test_all_that_has_a_name_has_a_text(of: str) -> None:
    names = amacrine.names(of)
    assert names and all(amacrine.text(of, name) for name in names)
    with pytest.raises(amacrine.Error, match=f"there is no neither in {of}"):
        amacrine.text(of, "neither")


HUGE = 1 << 32


@pytest.mark.parametrize(
    ("size", "told"),
    [
        ((HUGE, HUGE), "the sensor is 4294967296x4294967296; a side is at most 65536"),
        ((8, 65537), "the sensor is 65537x8; a side is at most 65536"),
        ((0, 0), "the sensor is 0x0; a side is at least 1"),
        ((0, 9), "the sensor is 9x0; a side is at least 1"),
        ((-1, 9), "size = (-1, 9)"),
        ((3.5, 9), "size = (3.5, 9)"),
    ],
)
def test_sizes_that_no_sensor_has(size: Any, told: str, tmp_path: Path) -> None:
    few, none = _few(), np.zeros(0, amacrine.EVENT)
    for wrong in (
        lambda: amacrine.compare(few, few, size=size),
        lambda: amacrine.events.voxels(few, bins=1, size=size),
        lambda: amacrine.events.voxels(none, bins=1, size=size),
        lambda: amacrine.events.event_frames(few, 1, size=size),
        lambda: amacrine.events.event_frames(none, 1, size=size),
        lambda: amacrine.events.time_surfaces(none, [0.1], tau=0.1, size=size),
        lambda: amacrine.write(tmp_path / "e.npz", few, size=size),
    ):
        with pytest.raises(amacrine.Error, match=re.escape(told)) as error:
            wrong()
        assert "give size=(height, width), whole numbers from 1 to 65536" in str(error.value)
    known = few.view(amacrine.events.NamedEvents)
    known.sensor_size = size
    with pytest.raises(amacrine.Error, match=re.escape(told)):
        amacrine.events.event_frames(known, 1)


def test_what_there_is_no_room_for_is_refused() -> None:
    """Sides that a sensor may have, and an array that no machine holds."""
    size = (65536, 65536)
    for wrong in (
        lambda: amacrine.events.voxels(_few(), bins=1000, size=size),
        lambda: amacrine.events.event_frames(np.repeat(_few(), 999), 1, size=size),
        lambda: amacrine.events.time_surfaces(_few(), np.arange(999), tau=0.1, size=size),
    ):
        with pytest.raises(amacrine.Error, match="TiB"):
            wrong()


HALF = "\ud800"


def test_letters_that_no_file_holds() -> None:
    threshold = '[[channel]]\nkernel = "dvs"\nthreshold = 1\n'
    for wrong in (
        lambda: amacrine.Sensor("dvs", 0.1, name=HALF),
        lambda: amacrine.Sensor("dvs", 0.1, names=[HALF]),
        lambda: amacrine.Sensor("dvs", 0.1, noise={HALF: 1}),
        lambda: amacrine.Sensor("dvs", 0.1, format=HALF),
        lambda: amacrine.Sensor.from_text(f'name = "{HALF}"\n{threshold}'),
        lambda: amacrine.Program.from_text(f"// {HALF}"),
        lambda: amacrine.Program.from_file("dvs/snap", constants={HALF: 1}),
        lambda: amacrine.names(HALF),
    ):
        with pytest.raises(amacrine.Error, match="half of a letter"):
            wrong()
    for name in ("a\x7f", 'b"\\\n\t\x01é😀\x7f\x7f'):
        assert amacrine.Sensor("dvs", 0.1, name=name).name == name


def test_an_answer_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    answer = amacrine.compare(_few(), _few(), size=(8, 8))
    path = tmp_path / "new/one.json"
    answer.save(path)
    assert json.loads(path.read_text()) == answer.to_dict()
    path.chmod(0o400)
    answer.save(path)
    assert [one.name for one in path.parent.iterdir()] == ["one.json"]
    for wrong in (path / "two.json", tmp_path / "new.json"):
        if wrong.name == "new.json":
            wrong.mkdir()
        with pytest.raises(amacrine.Error, match="(?s)cannot write .*help: check that its folder") as told:
            answer.save(wrong)
        assert str(wrong) in str(told.value)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device without room")
def test_an_answer_that_finds_no_room(tmp_path: Path) -> None:
    answer = amacrine.compare(_few(), _few(), size=(8, 8))
    with pytest.raises(amacrine.Error, match="No space left"):
        (tmp_path / "full.json").symlink_to("/dev/full")
        answer.save(tmp_path / "full.json")
