"""What the tests share: the program of the command line, and small clips."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Callable

import numpy as np
import numpy.typing as npt
import pytest

ROOT = Path(__file__).resolve().parents[2]

Frames = npt.NDArray[np.uint8]


@pytest.fixture(scope="session")
def program() -> Callable[..., str]:
    """Runs the program of the command line; what it printed, or what it said beside that."""
    path = Path(os.environ.get("AMACRINE", ROOT / "target/release/amacrine"))
    if not path.is_file():
        pytest.fail(f"no program at {path}: build it, or set AMACRINE")

    def run(*words: Any, good: bool = True, beside: bool = False) -> str:
        done = subprocess.run([path, *map(str, words)], capture_output=True, text=True)
        assert (done.returncode == 0) == good, done.stderr
        return done.stdout if good and not beside else done.stderr

    return run


@pytest.fixture(scope="session")
def frames() -> Frames:
    """Twelve frames of texture that moves over an odd size, (T,H,W)."""
    random = np.random.default_rng(5)
    texture = random.integers(0, 256, (120, 160)).astype(np.uint8)
    return np.stack([texture[n : n + 61, 2 * n : 2 * n + 83] for n in range(12)])


def kernels(count: int, side: int = 5) -> npt.NDArray[np.float64]:
    """Kernels without a sum, (K,1,k,k), as a convolution has them."""
    random = np.random.default_rng(7)
    weights = random.normal(size=(count, 1, side, side))
    weights -= weights.mean(axis=(2, 3), keepdims=True)
    return weights


def ends_on_ctrl_c(code: str, seconds: float) -> None:
    """Runs code that prints ``begun`` and goes on for long: it ends within so many seconds of the
    signal."""
    with subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", code],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as run:
        assert run.stdout is not None and run.stdout.readline() == "begun\n"
        time.sleep(2)
        assert run.poll() is None, "it was over before it could be stopped"
        begun = time.monotonic()
        os.kill(run.pid, signal.SIGINT)
        try:
            said = run.communicate(timeout=seconds + 10)[1]
        finally:
            run.kill()
    assert "KeyboardInterrupt" in said, said
    assert time.monotonic() - begun < seconds
