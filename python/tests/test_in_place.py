"""Arrays of frames are read where numpy has them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HELD = """
import numpy as np, amacrine

def peak():
    return int(open("/proc/self/status").read().split("VmHWM:")[1].split()[0]) * 1024

amacrine.set_threads(2)
frames = np.zeros(({count}, 256, 256), {dtype})
frames[:, :, ::2] = 1
{made}
# What is made once, however long the clip.
watch(frames[:3])
before = peak()
watch({given})
print(peak() - before, frames.nbytes)
"""

SENSOR = "watch = lambda clip: amacrine.Sensor('dvs', 1e6).events(clip, 30, scale=1)"
STREAM = """
def watch(clip):
    stream = amacrine.Sensor("dvs", 1e6).stream(30)
    stream.events(clip)
"""
CHIP = """
chip = amacrine.compile("dvs", 50, effort=0.01)
watch = lambda clip: chip.events(clip, 30)
"""
PROGRAM = "watch = lambda clip: amacrine.Program.from_file('dvs/snap').run(clip, 30)"


def _held(made: str, count: int, dtype: str, given: str = "frames") -> tuple[int, int]:
    """Bytes that are held more than before while a clip is watched, and those of the clip."""
    script = HELD.format(made=made, count=count, dtype=f"np.{dtype}", given=given)
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", script], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    held, size = done.stdout.split()
    return int(held), int(size)


linux = pytest.mark.skipif(
    not Path("/proc/self/status").exists(), reason="needs what Linux tells"
)


@linux
@pytest.mark.parametrize(
    "made, count, dtype",
    [
        pytest.param(SENSOR, 1000, "uint8", id="uint8"),
        pytest.param(SENSOR, 1000, "bool_", id="bool"),
        pytest.param(SENSOR, 250, "float32", id="float32"),
        pytest.param(SENSOR, 125, "float64", id="float64"),
        pytest.param(STREAM, 1000, "uint8", id="a stream"),
        pytest.param(CHIP, 500, "uint8", id="a sensor on a chip"),
        pytest.param(PROGRAM, 500, "uint8", id="a program"),
    ],
)
def test_frames_row_by_row_are_not_copied(made: str, count: int, dtype: str) -> None:
    held, size = _held(made, count, dtype)
    assert held < size / 2


@linux
@pytest.mark.parametrize(
    "count, dtype, given", [(1000, "uint8", "frames[:, ::-1]"), (500, "uint16", "frames")]
)
def test_a_copy_is_seen(count: int, dtype: str, given: str) -> None:
    """What the test above rests on: frames that lie otherwise, or are of another type, are copied."""
    held, size = _held(SENSOR, count, dtype, given)
    assert held > 0.9 * size
