"""Other threads of Python go on while the library computes."""

from __future__ import annotations

import ctypes
import sys
import threading
import time
from pathlib import Path
from typing import Any, Callable

import amacrine
import numpy as np
import pytest
from conftest import Frames, kernels

FPS = 120.0

WANTED = 20
"""Steps of the other thread that are enough."""


def _steps(call: Callable[[], Any], most: int) -> int:
    """Steps that another thread takes within so many calls at most, up to those that are enough.

    Nobody takes the interpreter from a thread before a minute is over, so that thread steps only where
    the call has released it. It gives the interpreter back after each step.
    """
    steps, over = [0], threading.Event()

    def step() -> None:
        while not over.is_set():
            steps[0] += 1
            time.sleep(0)

    before = sys.getswitchinterval()
    other = threading.Thread(target=step)
    # Before the thread waits: it waits by the interval that holds when it begins to.
    sys.setswitchinterval(60)
    other.start()
    try:
        within = 0
        for _ in range(most):
            then = steps[0]
            call()
            within += steps[0] - then
            if within >= WANTED:
                break
        return within
    finally:
        sys.setswitchinterval(before)
        over.set()
        other.join()


def test_a_call_that_holds_the_interpreter_is_seen() -> None:
    """What the other tests rest on: the same wait of C, with the interpreter and without it."""
    assert _steps(lambda: ctypes.PyDLL(None).usleep(20_000), 5) == 0
    assert _steps(lambda: ctypes.CDLL(None).usleep(20_000), 500) >= WANTED


def _calls(frames: Frames, folder: Path) -> dict[str, Callable[[], Any]]:
    """What computes for some milliseconds."""
    clip = np.tile(frames, (1, 4, 4))
    sensor = amacrine.Sensor(kernels(2), 2.0)
    chip = amacrine.compile("dvs", 20, effort=0.01)
    program = amacrine.Program.from_file("dvs/snap")
    events = sensor.events(clip, FPS)
    amacrine.write(folder / "events.csv", events)
    stream = sensor.stream(FPS)
    return {
        "events": lambda: sensor.events(clip, FPS),
        "counts": lambda: sensor.counts(clip, FPS),
        "voxels": lambda: sensor.voxels(clip, FPS, bins=5),
        "a stream": lambda: stream.events(clip),
        "events of a chip": lambda: chip.events(clip, FPS),
        "a program": lambda: program.run(clip, FPS),
        "compile": lambda: amacrine.compile("csdvs-3", 20, effort=0.02),
        "gradient.forward": lambda: amacrine.gradient.forward(sensor, clip, FPS),
        "events.voxels": lambda: amacrine.events.voxels(events, bins=9, window=0.01),
        "compare": lambda: amacrine.compare(events, events),
        "read": lambda: amacrine.read(folder / "events.csv"),
        "write": lambda: amacrine.write(folder / "again.csv", events),
    }


@pytest.mark.filterwarnings("ignore::amacrine.Caution")
def test_the_interpreter_is_released(frames: Frames, tmp_path: Path) -> None:
    for name, call in _calls(frames, tmp_path).items():
        assert _steps(call, 500) >= WANTED, name
