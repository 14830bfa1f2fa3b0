"""What a notebook shows: tables and pictures."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _amacrine

MOST_SIDE = 15
"""Kernels with longer sides are no table that anybody reads."""

MOST_PLANES = 12
"""Kernels that are shown at most."""

MOST_TEXT = 20_000
"""Letters of a file that are shown at most."""

MOST_PIXELS = 128
"""Pixels of the longer side of a small picture."""

Plane = tuple[str, npt.NDArray[np.float64]]
"""A kernel, and what stands above it."""


def table(rows: Sequence[dict[str, Any]], title: str = "") -> str:
    """Rows of plain values as a table of HTML; what is no plain value is left out."""
    plain = [
        {name: of for name, of in row.items() if not isinstance(of, (dict, list))} for row in rows
    ]
    columns = list(dict.fromkeys(name for row in plain for name in row))
    head = "".join(f"<th>{html.escape(name)}</th>" for name in columns)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(_cell(row.get(c)))}</td>" for c in columns) + "</tr>"
        for row in plain
    )
    above = f"<caption>{html.escape(title)}</caption>" if title else ""
    return f"<table>{above}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(of: Any) -> str:
    if of is None:
        return ""
    return f"{of:.4g}" if isinstance(of, float) else str(of)


def plane(values: npt.NDArray[np.float64], title: str = "") -> str:
    """A kernel as a table, row 0 to the north."""
    rows = [dict(zip(map(str, range(len(row))), row)) for row in values.tolist()]
    return table(rows, title)


def planes(given: Iterable[Plane]) -> str:
    """Kernels beside one another: the first of them, and those that are small."""
    all = list(given)
    small = [(title, values) for title, values in all if max(values.shape) <= MOST_SIDE]
    shown = "".join(plane(values, title) for title, values in small[:MOST_PLANES])
    left = len(all) - min(len(small), MOST_PLANES)
    more = f"<p>{left} {'kernel is' if left == 1 else 'kernels are'} not drawn.</p>" if left else ""
    return f'<div style="display: flex; flex-wrap: wrap; gap: 1em">{shown}</div>{more}'


def picture(png: bytes, title: str, alt: str) -> str:
    """A PNG with words below it."""
    data = base64.b64encode(png).decode()
    return (
        f'<figure style="margin: 0"><img src="data:image/png;base64,{data}" '
        f'alt="{html.escape(alt, quote=True)}"/>'
        f"<figcaption>{html.escape(title)}</figcaption></figure>"
    )


def registers(given: Mapping[str, npt.NDArray[Any]]) -> str:
    """Small pictures of registers beside one another: the least value is black, the most white, 0 and 1
    of one bit."""
    shown = "".join(_register(name, values) for name, values in given.items() if values.size)
    return f'<div style="display: flex; flex-wrap: wrap; gap: 1em">{shown}</div>' if shown else ""


def _register(name: str, values: npt.NDArray[Any]) -> str:
    is_bit = values.dtype == bool
    small = _smaller(values.astype(np.float64, copy=False))
    low, high = (0.0, 1.0) if is_bit else (float(small.min()), float(small.max()))
    return picture(_amacrine.register_picture(small, low, high), name, f"register {name}")


def _smaller(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Means of squares of pixels, so that the longer side has :data:`MOST_PIXELS` at most."""
    step = -(-max(values.shape) // MOST_PIXELS)
    if step == 1:
        return np.ascontiguousarray(values)
    height, width = (-(-side // step) for side in values.shape)
    more = [(0, rows * step - side) for rows, side in zip((height, width), values.shape)]
    squares = np.pad(values, more, mode="edge").reshape(height, step, width, step)
    found: npt.NDArray[np.float64] = squares.mean((1, 3))
    return found


def size(values: npt.NDArray[np.float64]) -> str:
    """Columns and rows of a kernel."""
    return f"{values.shape[1]}x{values.shape[0]}"


def sentences(given: Iterable[str]) -> str:
    """A list of sentences."""
    found = "".join(f"<li>{html.escape(one)}</li>" for one in given)
    return f"<ul>{found}</ul>" if found else ""


def text(title: str, of: str) -> str:
    """The text of a file, folded."""
    cut = of if len(of) <= MOST_TEXT else of[:MOST_TEXT] + "\n…"
    return f"<details><summary>{html.escape(title)}</summary><pre>{html.escape(cut)}</pre></details>"


def of_chip(
    rows: Sequence[dict[str, Any]], warnings: Iterable[dict[str, Any]]
) -> list[dict[str, Any]]:
    """The main columns of quantisers that were run on a chip: what a program costs, what is kept of a
    kernel or of each of several, and at the end why that is not known, where it is not."""
    silent = [one["seen"] for one in warnings if one["about"] in NOTHING_KEPT]
    found = [_row(row) for row in rows]
    whys = [_why(row, cells, silent) for row, cells in zip(rows, found)]
    if not any(whys):
        return found
    columns = dict.fromkeys(name for cells in found for name in cells)
    return [
        {name: cells.get(name) for name in columns} | {"why not": why}
        for cells, why in zip(found, whys)
    ]


NOTHING_KEPT = ("no-events", "window")
"""Warnings of what leaves nothing to keep: no event, or chance alone scores nearly 1."""


def _row(row: dict[str, Any]) -> dict[str, Any]:
    cells: dict[str, Any] = {"to": row["to"]}
    if row.get("relative_error") is not None:
        cells["relative error"] = row["relative_error"]
    on_chip = row.get("on_chip")
    if on_chip is None:
        return cells
    cells |= {"words": on_chip["words"], "us": on_chip["array_us"]}
    if "registers" in on_chip:
        cells["registers"] = on_chip["registers"]
    each = [(f" of {kind['name']}", kind["silicon"]) for kind in on_chip.get("kinds", [])]
    for of, likeness in each or [("", row)]:
        cells["kept" + of] = likeness["kept"]
        cells["as threshold, %" + of] = likeness["threshold_equivalent_percent"]
    return cells


def _why(row: dict[str, Any], cells: dict[str, Any], silent: list[str]) -> str:
    """Why there is no program, or why nothing is said of what it keeps."""
    refused = row.get("refused", [])
    if refused:
        return "; ".join([refused] if isinstance(refused, str) else refused)
    unknown = any(name.startswith("kept") and of is None for name, of in cells.items())
    return "; ".join(silent) if unknown else ""
