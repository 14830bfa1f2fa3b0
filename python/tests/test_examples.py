"""The examples run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parents[1]


def test_a_clip_becomes_a_loss() -> None:
    example = HERE / "examples/video_to_loss.py"
    body = [
        line
        for line in example.read_text().split('"""')[2].splitlines()
        if line.strip() and not line.startswith("#")
    ]
    assert len(body) <= 12, "ten lines, and two that print"
    done = subprocess.run(
        [sys.executable, str(example)], capture_output=True, text=True, check=True
    )
    assert "loss" in done.stdout
