"""How long others take for the same work: a table of ratios, measured side by side.

    python examples/peers.py [--quick]

Needs the readers of tests/interop/requirements.txt. Each pair of amacrine and a peer takes turns on
the same frames or events, and each turn is one ratio: seconds of the peer over seconds of amacrine, so
that above 1 amacrine is quicker. The median is told with both quartiles. Seconds are those of the
processor, all threads together, which other work on the machine lengthens less than the clock's; the
ratio by the clock stands in the second table. Events are checked to be the same before anything is
told; ``--quick`` only sees to that, and that it runs.

Video becomes events in a plain DVS of both, of equal settings as far as there are such: linear light
(sRGB undone, which EventCV does itself and numpy before amacrine's sensor, inside of its time), lin-log
with a knee at 20 of 255, thresholds of 0.2 without mismatch, no noise, no low-pass, no dead time, no
frames put in (``upsample="off"``). EventCV rounds times down, amacrine to the nearest microsecond.

Everybody reads the file that amacrine wrote, up to arrays or a table in memory, and writes to a file of
its own from what it takes: conversion into that is left out of its time. Files of one format differ in
what is beside the events: amacrine's know their sensor and the time that was watched.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import platform
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import amacrine
import numpy as np

Columns = list[Any]
"""Times, columns, rows, and 1 for ON."""

Do = Callable[[], Any]

Row = tuple[str, ...]
"""What is done, and the ratios, of the processor and by the clock."""

SECONDS, LEAST, MOST = 2.5, 5, 15
"""How long a pair takes its turns, and how many it takes."""

EVENTS = 500_000
"""Events of a file."""

SIZE = (256, 256)


class Ratios:
    """Seconds of a peer over those of amacrine, turn by turn."""

    def __init__(self, ours: Do, theirs: Do, quick: bool) -> None:
        self.cpu: list[float] = []
        self.clock: list[float] = []
        self.seconds: tuple[list[float], list[float]] = [], []
        seconds(ours), seconds(theirs)
        begun = time.perf_counter()
        for turn in range(1 if quick else MOST):
            if turn >= LEAST and time.perf_counter() - begun > SECONDS:
                break
            # Who begins changes, so that neither always finds the caches of the other.
            if turn % 2 == 0:
                a, b = seconds(ours), seconds(theirs)
            else:
                b, a = seconds(theirs), seconds(ours)
            self.clock.append(b[0] / a[0])
            self.cpu.append(b[1] / a[1])
            self.seconds[0].append(a[0])
            self.seconds[1].append(b[0])


def seconds(do: Do) -> tuple[float, float]:
    """By the clock, and of the processor."""
    clock, cpu = time.perf_counter(), time.process_time()
    made = do()
    taken = time.perf_counter() - clock, time.process_time() - cpu
    # Its memory goes when the clock has stopped.
    del made
    return taken


def told(ratios: list[float]) -> str:
    low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75])
    return f"{middle:.2g} ({low:.2g} to {high:.2g})"


def check(what: str, found: Columns, events: Any) -> None:
    for name, column in zip("txyp", found):
        own, wanted = np.asarray(column).astype(np.int64), events[name].astype(np.int64)
        if not np.array_equal(own, wanted):
            raise SystemExit(f"{what}: {name} is not that of the events that were written")


# Video to events.


def video(quick: bool) -> tuple[Row, Any]:
    """A row of the tables, and events for the files."""
    eventcv = importlib.import_module("eventcv")
    frames, fps = amacrine.load()
    frames = frames[: 8 if quick else None].astype(np.uint8)
    coded = np.arange(256) / 255
    light = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4) * 255
    linear = light.astype(np.float32)
    none = {"sigma_thres": 0.0, "leak_rate_hz": 0.0, "shot_noise_rate_hz": 0.0}
    plain = {"refractory_us": 0, "cutoff_hz": 0.0, "upsample": "off"}

    def theirs() -> Any:
        return eventcv.simulate(frames, fps=fps, pos_thres=0.2, neg_thres=0.2, **none, **plain)

    other, cells = theirs().numpy(), []
    for format in ("f64", "f32"):
        sensor = amacrine.Sensor("dvs", 0.2, response={"lin-log": {"knee": 20}}, format=format)

        def ours(sensor: amacrine.Sensor = sensor) -> Any:
            return sensor.events(linear[frames], fps, scale=1)

        events = ours()
        compared(events, other)
        ratios = Ratios(ours, theirs, quick)
        own, its = (len(frames) / np.median(each) for each in ratios.seconds)
        said = f" ({own:.0f} against {its:.0f} frames/s by the clock)"
        cells.append([f"EventCV {told(of)} of {format}{said}" for of in (ratios.cpu, ratios.clock)])
    work = f"video to events, {len(frames)} frames of 256x256: {len(events):,} events, {len(other):,} of EventCV"
    return (work, *("; ".join(each) for each in zip(*cells))), events


def compared(events: Any, other: Any) -> None:
    """Two models of the same pixel differ where rounding decides, and nowhere else."""
    where = [events["y"].astype(int) * SIZE[1] + events["x"], other[:, 1] * SIZE[1] + other[:, 0]]
    counts = [np.bincount(each.astype(np.int64), minlength=SIZE[0] * SIZE[1]) for each in where]
    moved = int(np.abs(counts[0] - counts[1]).sum()) / len(events)
    if moved > 0.005:
        raise SystemExit(f"video: {moved:.1%} of the events are not in both")


# Files. A reader gives columns; a writer takes what `made` made, outside of its time.


def by_faery(path: Path) -> Do:
    faery = importlib.import_module("faery")
    return lambda: faery.events_stream_from_file(path).to_array()


def by_expelliarmus(encoding: str) -> Callable[[Path], Do]:
    wizard = importlib.import_module("expelliarmus").Wizard(encoding)
    return lambda path: lambda: wizard.read(str(path))


def by_evlib(path: Path) -> Do:
    evlib = importlib.import_module("evlib")
    return lambda: evlib.load_events(str(path)).collect()


def by_dv_processing(path: Path) -> Do:
    dv = importlib.import_module("dv_processing")

    def read() -> Any:
        recording = dv.io.MonoCameraRecording(str(path))
        return np.concatenate([b.numpy() for b in iter(recording.getNextEventBatch, None)])

    return read


def by_pandas(path: Path) -> Do:
    pandas = importlib.import_module("pandas")
    return lambda: pandas.read_csv(path)


def by_numpy(path: Path) -> Do:
    def read() -> Any:
        with np.load(path) as arrays:
            return {name: arrays[name] for name in "txyp"}

    return read


def by_h5py(path: Path) -> Do:
    h5py = importlib.import_module("h5py")

    def read() -> Any:
        with h5py.File(path) as file:
            found = {name: file["events"][name][:] for name in "txyp"}
            found["t"] = found["t"] + int(file["t_offset"][()])
        return found

    return read


def columns(found: Any) -> Columns:
    """Whatever a reader gives."""
    names = getattr(getattr(found, "dtype", None), "names", None)
    names = names or list(getattr(found, "columns", found))
    each = []
    for known in (("t", "timestamp"), ("x",), ("y",), ("p", "on", "polarity")):
        column = found[next(name for name in known if name in names)]
        # Tables have numbers of their own: durations, and -1 for OFF.
        each.append(column.to_physical().to_numpy() if hasattr(column, "to_physical") else column)
    return [*each[:3], np.asarray(each[3]) > 0]


def with_faery(events: Any, version: str | None = None, name: str = "") -> Callable[[Path], Do]:
    faery = importlib.import_module("faery")
    given = np.zeros(len(events), faery.EVENTS_DTYPE)
    for own, name_of in zip(("t", "x", "y", "on"), "txyp"):
        given[own] = events[name_of]
    # Or it takes the first time off.
    more: dict[str, Any] = {} if name == "AEDAT4" else {"zero_t0": False}
    more |= {} if version is None else {"version": version}

    def made(path: Path) -> Do:
        stream = faery.events_stream_from_array(given, SIZE[::-1])
        return lambda: stream.to_file(str(path), **more)

    return made


def with_expelliarmus(events: Any, encoding: str) -> Callable[[Path], Do]:
    given = np.zeros(len(events), [("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "u1")])
    for name in "txyp":
        given[name] = events[name]
    wizard = importlib.import_module("expelliarmus").Wizard(encoding)
    return lambda path: lambda: wizard.save(str(path), given)


def with_dv_processing(events: Any) -> Callable[[Path], Do]:
    dv = importlib.import_module("dv_processing")
    store = dv.EventStore()
    for t, x, y, p in events.tolist():
        store.push_back(t, x, y, bool(p))

    def write(path: Path) -> None:
        lz4 = dv.CompressionType.LZ4
        config = dv.io.MonoCameraWriter.EventOnlyConfig("camera", SIZE[::-1], lz4)
        writer = dv.io.MonoCameraWriter(str(path), config)
        writer.writeEvents(store)
        # The end of the file is written when it goes.
        del writer

    return lambda path: lambda: write(path)


def with_pandas(events: Any) -> Callable[[Path], Do]:
    pandas = importlib.import_module("pandas")
    table = pandas.DataFrame({name: events[name] for name in "txyp"})
    return lambda path: lambda: table.to_csv(path, index=False)


def with_numpy(events: Any) -> Callable[[Path], Do]:
    given: dict[str, Any] = {name: np.ascontiguousarray(events[name]) for name in "txyp"}
    return lambda path: lambda: np.savez(path, **given)


def with_h5py(events: Any) -> Callable[[Path], Do]:
    h5py = importlib.import_module("h5py")
    given = {name: np.ascontiguousarray(events[name]) for name in "txyp"}

    def write(path: Path) -> None:
        with h5py.File(path, "w") as file:
            for name, values in given.items():
                # As amacrine has them.
                chunks = (min(32768, len(values)),)
                how = {"compression": "gzip", "compression_opts": 1, "chunks": chunks}
                file.create_dataset(f"events/{name}", data=values, **how)
            file["t_offset"] = 0

    return lambda path: lambda: write(path)


def formats(events: Any) -> list[tuple[str, str, str | None, dict[str, Any], dict[str, Any]]]:
    """Each format: its ending, how it is called, who reads it, and who writes it."""
    faery, evlib = by_faery, by_evlib
    return [
        (
            "EVT3", ".raw", "evt3", {"faery": faery, "evlib": evlib},
            {"faery": with_faery(events, "evt3")},
        ),
        (
            "EVT2", ".raw", "evt2",
            {"faery": faery, "expelliarmus": by_expelliarmus("evt2"), "evlib": evlib},
            {"faery": with_faery(events, "evt2"), "expelliarmus": with_expelliarmus(events, "evt2")},
        ),
        (
            "AEDAT4", ".aedat4", None, {"faery": faery, "dv_processing": by_dv_processing},
            {"faery": with_faery(events, name="AEDAT4"), "dv_processing": with_dv_processing(events)},
        ),
        (
            "csv", ".csv", None, {"faery": faery, "pandas": by_pandas},
            {"faery": with_faery(events), "pandas": with_pandas(events)},
        ),
        ("npz", ".npz", None, {"numpy": by_numpy}, {"numpy": with_numpy(events)}),
        (
            "DAT", ".dat", None, {"faery": faery, "expelliarmus": by_expelliarmus("dat")},
            {"faery": with_faery(events), "expelliarmus": with_expelliarmus(events, "dat")},
        ),
        (
            "HDF5", ".h5", None, {"evlib": evlib, "h5py": by_h5py}, {"h5py": with_h5py(events)},
        ),
    ]


def files(events: Any, quick: bool) -> list[Row]:
    """A row for each format."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as name:
        for called, ending, format, readers, writers in formats(events):
            ours = Path(name) / f"ours{ending}"
            read: list[tuple[str, Ratios]] = []
            wrote: list[tuple[str, Ratios]] = []

            def write(path: Path = ours, format: str | None = format) -> None:
                amacrine.write(path, events, format=format)

            write()
            check(f"{called}, amacrine", columns(amacrine.read(ours)), events)
            for peer, reader in readers.items():
                do = reader(ours)
                check(f"{called} read by {peer}", columns(do()), events)
                read.append((peer, Ratios(lambda: amacrine.read(ours), do, quick)))
            for peer, writer in writers.items():
                path = Path(name) / f"{peer}{ending}"
                do = writer(path)
                do()
                check(f"{called} written by {peer}", back(path, called), events)
                wrote.append((peer, Ratios(write, do, quick)))
            cpu = [", ".join(f"{peer} {told(of.cpu)}" for peer, of in both) for both in (read, wrote)]
            clock = [", ".join(f"{peer} {told(of.clock)}" for peer, of in both) for both in (read, wrote)]
            each = [f"read: {cells[0]}; write: {cells[1]}" for cells in (cpu, clock)]
            rows.append((f"{called}, {len(events):,} events", *each))
    return rows


def back(path: Path, called: str) -> Columns:
    """What stands in the file of another."""
    if called == "HDF5":
        return columns(by_h5py(path)())
    if called == "csv" and "faery" in path.name:
        return columns(by_faery(path)())
    return columns(amacrine.read(path))


def version(name: str) -> str:
    return importlib.metadata.version(name)


def processor() -> str:
    """The name of the processor, and how many of its cores this process may use."""
    name = platform.processor() or platform.machine()
    about = Path("/proc/cpuinfo")
    if about.is_file():
        lines = about.read_text().splitlines()
        name = next((n.split(":")[1].strip() for n in lines if n.startswith("model name")), name)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{name}, {cores} cores"


def main(quick: bool) -> None:
    warnings.filterwarnings("ignore")
    others = ["eventcv", "faery", "expelliarmus", "evlib", "dv_processing", "pandas", "numpy", "h5py"]
    row, events = video(quick)
    rows = [row, *files(events[: 20_000 if quick else EVENTS], quick)]
    print(f"{processor()}; amacrine {amacrine.__version__}, ", end="")
    print(", ".join(f"{name} {version(name)}" for name in others))
    print("Seconds of the other over those of amacrine, median of the turns (quartiles)")
    for which, title in enumerate(("seconds of the processor", "seconds by the clock")):
        print(f"\n| the same work | {title} |\n|---|---|")
        print("\n".join(f"| {row[0]} | {row[1 + which]} |" for row in rows))


if __name__ == "__main__":
    main("--quick" in sys.argv[1:])
