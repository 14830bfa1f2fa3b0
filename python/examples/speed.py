"""How fast Python is against Rust, on the same work.

    python examples/speed.py path/to/amacrine [path/to/in_memory]

A clip of 256x256, a 5x5 kernel. Both from a .npy of frames to a .npy of events; and, with the Rust
example `in_memory` (`cargo build --release --example in_memory`), both from an array of frames to a
list of events. Runs take turns; the medians are told, with half the distance of the quartiles, and the
seconds of the processor as well, which other work on the machine does not lengthen as much.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Callable

import amacrine
import numpy as np

FRAMES, FPS, RUNS = 600, 100.0, 9

Taken = tuple[list[float], list[float]]
"""Seconds of each run, by the clock and of the processor."""


def processor() -> float:
    """Seconds of this process and of those that it waited for."""
    of = os.times()
    return of.user + of.system + of.children_user + of.children_system


def turns(what: list[Callable[[], object]]) -> list[Taken]:
    """What each takes; the first round warms up."""
    taken: list[Taken] = [([], []) for _ in what]
    for run in range(RUNS + 1):
        for (clock, cpu), do in zip(taken, what):
            start, own = time.perf_counter(), processor()
            made = do()
            seconds = time.perf_counter() - start
            # Its memory goes when the clock has stopped, as that of the loop in Rust does.
            del made
            if run > 0:
                clock.append(seconds)
                cpu.append(processor() - own)
    return taken


def main(program: str, rust: str | None = None) -> None:
    clip, _ = amacrine.load()
    frames = np.resize(clip, (FRAMES, *clip.shape[1:]))
    sensor = amacrine.Sensor("csdvs-5", 0.02, format="f32")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene, made, own = folder / "scene.npy", folder / "program.npy", folder / "python.npy"
        np.save(scene, frames)
        text = folder / "sensor.toml"
        text.write_text(sensor.text)
        words = [program, "run", "--scene", scene, "--sensor", text]
        words += ["--fps", FPS, "--format", "f32", "--events", made]

        def of_program() -> None:
            subprocess.run([str(word) for word in words], check=True, capture_output=True)

        def of_python() -> None:
            np.save(own, sensor.events(np.load(scene), FPS))

        files = turns([of_program, of_python])
        assert np.array_equal(np.load(made), np.load(own)), "not the same events"
        pairs, events = FRAMES - 1, len(np.load(own))
        print(f"{FRAMES} frames of 256x256, {events / pairs / 65536:.2f} events a pixel and pair")
        print("from file to file")
        told("program", files[0], pairs)
        told("python", files[1], pairs, files[0])
        if rust is None:
            return

        def rust_runs(runs: int) -> None:
            loops = [str(word) for word in (rust, scene, text, FPS, runs)]
            done = subprocess.run(loops, check=True, capture_output=True, text=True)
            for line in done.stdout.splitlines():
                count, seconds = line.split()
                assert int(count) == events, "not as many events"
                loop.append(float(seconds))

        loop: list[float] = []
        # Its own clock, and the processor without what it takes to read the file.
        reading = statistics.median(turns([lambda: rust_runs(0)])[0][1])
        arrays = turns([lambda: rust_runs(1), lambda: sensor.events(frames, FPS)])
        print("from array to list")
        of = loop[1:], [seconds - reading for seconds in arrays[0][1]]
        told("rust", of, pairs)
        told("python", arrays[1], pairs, of)


def told(name: str, taken: Taken, pairs: int, of: Taken | None = None) -> None:
    clock, cpu = taken
    half = (np.quantile(clock, 0.75) - np.quantile(clock, 0.25)) / 2
    middle = statistics.median(clock)
    line = f"  {name:8}{pairs / middle:7.0f} frame pairs/s +- {half / middle:.0%}"
    if cpu:
        line += f", {statistics.median(cpu) / pairs * 1e3:.2f} ms of the processor a pair"
    if of is not None:
        line += f"; {statistics.median(of[0]) / middle:.0%} of the speed by the clock"
        line += f", {statistics.median(of[1]) / statistics.median(cpu):.0%} by the processor"
    print(line)


if __name__ == "__main__":
    main(*(sys.argv[1:] or ["amacrine"]))
