"""The examples run."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import ROOT

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


def _blocks() -> list[str]:
    """What is fenced in the project's README, each with its language in the first line."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return text.split("\n```")[1::2]


def _shown_after(words: str) -> tuple[str, list[str]]:
    """The block that holds these words, and the lines of the block after it."""
    blocks = _blocks()
    at = next(n for n, block in enumerate(blocks) if words in block)
    return blocks[at], blocks[at + 1].splitlines()[1:]


def test_the_lines_of_the_readme_print_what_it_shows(tmp_path: Path) -> None:
    block, shown = _shown_after("import amacrine\nframes")
    done = subprocess.run(
        [sys.executable, "-c", block.removeprefix("python\n")],
        capture_output=True, text=True, check=True, cwd=tmp_path,
    )
    assert done.stdout.splitlines() == shown


def test_the_design_of_the_readme_prints_what_it_shows(
    tmp_path: Path, program: Callable[..., str]
) -> None:
    block, shown = _shown_after("amacrine design csdvs-3")
    words = block.split()[1:-1]
    # Chips are drawn for the report alone.
    said = program(*words, tmp_path / "mine", "--chips", 1).replace(f"{tmp_path}/", "")
    lines = [line.rstrip() for line in said.splitlines()]
    shown = [line for line in shown if line]
    assert block.split()[-1] == "mine" and len(shown) > 12
    assert [line for line in lines if line in shown] == shown


def test_peers_find_the_same_events() -> None:
    """Where their packages are there (tests/interop/requirements.txt)."""
    for name in ("eventcv", "faery", "expelliarmus", "evlib", "dv_processing", "pandas", "h5py"):
        pytest.importorskip(name)
    done = subprocess.run(
        [sys.executable, str(HERE / "examples/peers.py"), "--quick"],
        capture_output=True, text=True,
    )
    assert done.returncode == 0, done.stderr
    rows = [line for line in done.stdout.splitlines() if line.startswith("| ")]
    assert len(rows) == 2 * (1 + 8)
    # What the project's README shows is a table of these rows.
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for work in ("EVT3", "EVT2", "AEDAT4", "csv", "npz", "DAT", "HDF5"):
        assert f"| {work}, 500,000 events | read: " in text
        assert any(row.startswith(f"| {work}, 20,000 events | read: ") for row in rows)
