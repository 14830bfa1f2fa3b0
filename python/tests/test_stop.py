"""Ctrl-C ends what is computed, long before it would have come to its end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

BEGIN = """
import numpy as np, amacrine
random = np.random.default_rng(0)

def frames(count, side, clips=1):
    some = random.integers(0, 255, (16, 1, side, side), dtype=np.uint8)
    one = np.tile(some, (count // 16, 1, 1, 1))
    return one[:, 0] if clips == 1 else np.broadcast_to(one, (clips, *one.shape))

sensor = amacrine.Sensor(["dog"] * 4, 0.02)
"""

WORK = {
    "one clip": "sensor.counts(frames(1600, 128), 30)",
    "large frames": "sensor.counts(frames(32, 1024), 30)",
    "a batch": "sensor.counts(frames(800, 128, 4), 30)",
    "a batch with frames put in": "sensor.voxels(frames(160, 96, 3), 30, bins=2, upsample=0.02)",
    "a batch on a chip": "amacrine.compile('dvs', 5).voxels(frames(800, 128, 3), 30)",
}


COMPARED = """
events = np.zeros(2_000_000, amacrine.EVENT)
events["t"] = np.sort(random.integers(0, 9_000_000, len(events)))
events["x"], events["y"] = random.integers(0, 200, (2, len(events)))
print("begun", flush=True)
amacrine.compare(events, events[::2], size=(200, 200))
"""

IN_SECONDS = 10.0
"""Within which it ends on a busy machine; each goes on for longer by itself."""


def _stopped(code: str) -> None:
    """Sends a signal to what has begun, and waits for its end."""
    with subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", BEGIN + code],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as run:
        assert run.stdout is not None and run.stdout.readline() == "begun\n"
        time.sleep(1.5)
        assert run.poll() is None, "it was over before it could be stopped"
        begun = time.monotonic()
        os.kill(run.pid, signal.SIGINT)
        try:
            said = run.communicate(timeout=2 * IN_SECONDS)[1]
        finally:
            run.kill()
    assert "KeyboardInterrupt" in said, said
    assert time.monotonic() - begun < IN_SECONDS


@pytest.mark.parametrize("work", WORK)
def test_sensors_end_at_the_next_frame(work: str) -> None:
    _stopped(f'print("begun", flush=True)\n{WORK[work]}')


def test_a_comparison_ends_with_its_metric() -> None:
    _stopped(COMPARED)
