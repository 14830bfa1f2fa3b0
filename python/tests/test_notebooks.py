"""The notebooks run, and what they show is small and stored."""

from __future__ import annotations

import importlib
import json
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb"))
MOST = 100_000
"""Bytes of a notebook."""


def test_there_are_notebooks() -> None:
    assert len(NOTEBOOKS) >= 2


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_what_is_stored_is_small(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert len(text) < MOST
    cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
    assert sum(bool(cell["outputs"]) for cell in cells) * 2 > len(cells)
    assert not any(output["output_type"] == "error" for c in cells for output in c["outputs"])


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs(path: Path, tmp_path: Path) -> None:
    nbformat = importlib.import_module("nbformat")
    nbclient = importlib.import_module("nbclient")
    notebook = nbformat.read(path, as_version=4)
    where = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources=where).execute()
    # What is printed is what is stored: results are the same on every machine.
    assert _printed(notebook) == _printed(nbformat.read(path, as_version=4))


def _printed(notebook: object) -> list[str]:
    outputs = [o for cell in getattr(notebook, "cells") for o in cell.get("outputs", [])]
    return [o["text"] for o in outputs if o["output_type"] == "stream" and o["name"] == "stdout"]
