"""How fast Python is against the program of the command line, on the same work.

    python examples/speed.py path/to/amacrine

A clip of 256x256, a 5x5 kernel: read from a .npy, watched, the events written to a .npy. Both do
all of it, the program from its start to its end; the best of some runs each, in turn.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Callable

import amacrine
import numpy as np

FRAMES, FPS, RUNS = 600, 100.0, 7


def best(what: list[Callable[[], object]]) -> list[float]:
    """Seconds of each, the least of some runs."""
    least = [float("inf")] * len(what)
    for _ in range(RUNS):
        for i, do in enumerate(what):
            start = time.perf_counter()
            do()
            least[i] = min(least[i], time.perf_counter() - start)
    return least


def main(program: str) -> None:
    clip, _ = amacrine.load()
    frames = np.resize(clip, (FRAMES, *clip.shape[1:]))
    sensor = amacrine.Sensor("csdvs-5", 0.02, format="f32")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene, made, own = folder / "scene.npy", folder / "program.npy", folder / "python.npy"
        np.save(scene, frames)
        (folder / "sensor.toml").write_text(sensor.text)
        words = [program, "run", "--scene", scene, "--sensor", folder / "sensor.toml"]
        words += ["--fps", str(FPS), "--format", "f32", "--events", made]

        def of_program() -> None:
            subprocess.run([str(word) for word in words], check=True, capture_output=True)

        def of_python() -> None:
            np.save(own, sensor.events(np.load(scene), FPS))

        def in_memory() -> None:
            sensor.events(frames, FPS)

        by_program, by_python, alone = best([of_program, of_python, in_memory])
        assert np.array_equal(np.load(made), np.load(own)), "not the same events"
        events = len(np.load(own))
    pairs = FRAMES - 1
    print(f"{FRAMES} frames of 256x256, {events / pairs / 65536:.2f} events a pixel and pair")
    print(f"program        {pairs / by_program:7.0f} frame pairs/s")
    print(f"python         {pairs / by_python:7.0f} frame pairs/s, {by_program / by_python:.0%}")
    print(f"python, arrays {pairs / alone:7.0f} frame pairs/s, {by_program / alone:.0%}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "amacrine")
