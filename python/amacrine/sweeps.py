"""Sweeps: the points of a study, computed once each, here or on a cluster."""

from __future__ import annotations

import importlib
import json
import math
import time
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from . import _amacrine, arguments, toml
from ._amacrine import Error
from .notebook import table
from .caution import caution
from .names import opened

MOST_JOBS = (1 << 16) - 1

Overrides = Mapping[str, Any]
"""Keys of a study, such as ``{"format": ["f32", "q8.8"], "sample.points": 64}``."""


class Sweep:
    """A folder of results, finished or not; :func:`sweep` makes it. It is a table in a notebook."""

    def __init__(self, folder: str | Path, told: Mapping[str, Any] | None = None) -> None:
        self.folder = Path(folder)
        """Where the results are; ``amacrine report`` reads it as well."""
        self._told = dict(told or {})

    def _read(self) -> dict[str, Any]:
        """What is in the folder now."""
        found: dict[str, Any] = json.loads(_amacrine.sweep_rows(self.folder))
        return found

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each point that is there, in the order of the study: ``docs/sweeps.md`` lists the
        columns."""
        found = self._read()
        columns: list[str] = found["columns"]
        return [{key: row[key] for key in columns if key in row} for row in found["rows"]]

    def to_frame(self) -> Any:
        """The rows as a pandas data frame. Needs pandas."""
        return importlib.import_module("pandas").DataFrame(self.rows)

    @property
    def finished(self) -> int:
        """Points that are done, and points that cannot be."""
        return int(self._read()["finished"])

    @property
    def failed(self) -> list[dict[str, Any]]:
        """Points that were given up, with their reason: the next run computes them again."""
        return [row for row in self.rows if row["outcome"] == "failed"]

    @property
    def missing(self) -> list[int]:
        """Numbers of the points that are not there: not computed yet, or left out by a search."""
        return list(self._read()["missing"])

    @property
    def computed(self) -> int:
        """Points that this call computed; the others were there already."""
        return int(self._told.get("computed", 0))

    @property
    def damaged(self) -> list[dict[str, Any]]:
        """Files that this call could not believe, set aside and computed again: the number of the
        ``point`` (None of a pilot's file), its ``path``, and ``why``."""
        return list(self._told.get("damaged", []))

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return f"<Sweep {self.folder}: {len(self)} points>"

    def _repr_html_(self) -> str:
        return table(self.rows)


def sweep(
    study: str | Path,
    output: str | Path | None = None,
    *,
    set: Overrides | None = None,
    client: Any = None,
    shards: int | None = None,
    jobs: int | None = None,
    max_seconds_per_point: float | None = None,
) -> Sweep:
    """Computes each point of a study once, as ``amacrine sweep`` does, in the same folder of results.

    What is finished is not computed again: a folder that exists is gone on with. A kill, Ctrl-C or a
    lost worker costs the points in flight and nothing else.

    Args:
        study: A study file, or one that comes with the package by name, such as ``"formats"``.
        output: The folder of results; the study's name without its ending where it is left out, with
            eight letters of a hash behind it where keys are set.
        set: Keys of the study that are set: a value, several in a list, an array or a range, or a
            table such as ``{"on": 40, "off": 50, "sigma": 0}``.
        client: A ``dask.distributed.Client``: each task is a shard, in a folder of its own
            (``output/shard-0``, …), and all are joined in ``output/all``. The folder must be one that
            all workers see. A shard whose worker is lost is tried again and goes on where it was,
            once nobody works in its folder any longer.
        shards: Tasks with a client; where it is left out, as many as the folder was begun with, or
            four for each worker. Another number would compute finished points again, and is refused.
        jobs: Points at a time without a client, each on one thread; as many as there are cores where it
            is left out.
        max_seconds_per_point: Gives a point up when a sensor takes longer to watch its scene.

    Returns:
        The folder: ``.to_frame()`` is a data frame with a row for each point, ``.rows`` are dicts.
    """
    file, text, folder = opened("studies", study, "study")
    keys = arguments.table("set", set, '{"format": "f32"}')
    sets = [f"{key}={_value(key, value)}" for key, value in keys.items()]
    given = file, text, (folder or Path()).absolute()
    longest = None if max_seconds_per_point is None else _longest(max_seconds_per_point)
    if output is None:
        # Another study than the file's is another folder.
        path = Path(Path(study).stem + (f"-{_amacrine.sweep_hash(given, sets)}" if sets else ""))
    else:
        path = Path(arguments.file("output", output, "the path of a folder"))
    if client is None:
        if shards is not None:
            raise Error("shards without a client\nhelp: give client, or leave shards out")
        count = 0 if jobs is None else arguments.whole("jobs", jobs, 1, MOST_JOBS)
        told = json.loads(_amacrine.sweep(given, sets, path, None, count, longest))
        _caution(told["scene_warnings"] + told["warnings"], [told["set_aside"]])
        return Sweep(path, told)
    if jobs is not None:
        raise Error("jobs with a client\nhelp: leave jobs out: a worker computes a point at a time")
    path = path.absolute()
    count = _count(path, client, shards)
    # The last one first: its number tells how many there are, whenever this is stopped.
    for n in reversed(range(count)):
        (path / f"shard-{n}").mkdir(parents=True, exist_ok=True)
    tasks = [
        client.submit(
            _shard, given, sets, path, (n, count), longest, retries=2, pure=False
        )
        for n in range(count)
    ]
    try:
        done = client.gather(tasks)
    except BaseException:
        client.cancel(tasks)
        raise
    shares = [json.loads(one) for one in done]
    told = json.loads(_amacrine.merge([path / f"shard-{n}" for n in range(count)], path / "all"))
    # Of points as of all of them together.
    of_scenes = [text for one in shares for text in one["scene_warnings"]]
    _caution(of_scenes + told["warnings"], [one["set_aside"] for one in shares])
    told["computed"] = sum(one["computed"] for one in shares)
    told["damaged"] = [file for one in shares for file in one["damaged"]]
    return Sweep(path / "all", told)


def _count(path: Path, client: Any, shards: int | None) -> int:
    """How many shards there are: as many as the folder was begun with."""
    numbers = [one.name.removeprefix("shard-") for one in path.glob("shard-*")]
    begun = max((int(number) + 1 for number in numbers if number.isdecimal()), default=None)
    if shards is not None:
        asked = arguments.whole("shards", shards, 1)
        if begun not in (None, asked):
            raise Error(
                f"shards = {asked}, and {path} was begun with {begun}: finished points would be "
                "computed again\nhelp: leave shards out, or give another output"
            )
        return asked
    return begun or 4 * max(len(client.scheduler_info()["workers"]), 1)


def _caution(told: list[str], set_aside: list[str | None]) -> None:
    """Warns the caller of :func:`sweep` of what it warns of, once of each thing, and of the files that
    it has set aside."""
    for text in dict.fromkeys(told):
        caution(_amacrine.in_python(text))
    for files in set_aside:
        if files is not None:
            caution(files)


def _shard(
    study: tuple[str, str, Path],
    sets: Sequence[str],
    path: Path,
    part: tuple[int, int],
    seconds: float | None,
) -> str:
    """One shard, on a worker. Where a task that was given up still computes it, it is waited for."""
    index, count = part
    output = path / f"shard-{index}"
    while True:
        try:
            return _amacrine.sweep(study, [*sets], output, f"{index}/{count}", 1, seconds)
        except Error as error:
            if "in use by another amacrine" not in str(error):
                raise
            time.sleep(5)


def _longest(given: Any) -> float:
    """Seconds above 0."""
    name, help = "max_seconds_per_point", "give seconds above 0, such as max_seconds_per_point=60"
    found = arguments.number(name, given, help)
    if not 0.0 < found < math.inf:
        raise Error(f"{name} = {found:g}\nhelp: {help}")
    return found


def _said(of: Any) -> str:
    """One value: a word as it is, anything else as TOML."""
    return str(of) if isinstance(of, (str, PathLike)) else toml.value(of)


def _value(key: str, of: Any) -> str:
    """A value as the command line takes it, several with commas between."""
    several = isinstance(of, (list, tuple, range)) or (isinstance(of, np.ndarray) and of.ndim)
    try:
        return ",".join(map(_said, of)) if several else _said(of)
    except Error:
        raise Error(
            f'set = {{"{key}": …}}: {of!r} is nothing that a study can say\n'
            "help: give numbers, words, tables, or lists of them"
        ) from None
