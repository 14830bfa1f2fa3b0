"""Ctrl-C ends what is computed, long before it would have come to its end."""

from __future__ import annotations

import pytest
from conftest import ends_on_ctrl_c

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
    "one clip": "sensor.counts(frames(8000, 128), 30)",
    "large frames": "sensor.counts(frames(64, 1024), 30)",
    "a batch": "sensor.counts(frames(800, 128, 4), 30)",
    "a batch with frames put in": "sensor.voxels(frames(160, 96, 3), 30, bins=2, upsample=0.02)",
    "a batch on a chip": "amacrine.compile('dvs', 100).events(frames(800, 128, 60), 30)",
}


COMPARED = """
events = np.zeros(5_000_000, amacrine.EVENT)
events["t"] = np.sort(random.integers(0, 9_000_000, len(events)))
events["x"], events["y"] = random.integers(0, 200, (2, len(events)))
print("begun", flush=True)
amacrine.compare(events, events[::2], size=(200, 200))
"""

IN_SECONDS = 30.0
"""Within which it ends on a busy machine; each goes on for longer by itself, on an idle one too."""


@pytest.mark.parametrize("work", WORK)
def test_sensors_end_at_the_next_frame(work: str) -> None:
    ends_on_ctrl_c(f'{BEGIN}print("begun", flush=True)\n{WORK[work]}', IN_SECONDS)


def test_a_comparison_ends_with_its_metric() -> None:
    ends_on_ctrl_c(BEGIN + COMPARED, IN_SECONDS)
