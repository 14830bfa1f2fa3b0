"""Sweeps in Python are those of the command line, in the same folders."""

from __future__ import annotations

import fcntl
import json
import os
import re
import runpy
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Callable
from unittest.mock import MagicMock

import amacrine
import numpy as np
import pytest
from amacrine import _amacrine, sweeps
from conftest import ROOT

STUDY = """
title = "small"
scene = "pattern:bar?width=48&height=32&frames=8&fps=100"
kernel = "csdvs-3"
threshold = [4, 8, 16]
[[side]]
side = "reference"
format = ["f64", "f32"]
[[side]]
side = "array"
quantise = "ternary"
effort = 0.1
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    path = tmp_path / "small.toml"
    text = STUDY.replace('effort = 0.1\n', "")
    path.write_text(text.replace('title = "small"', 'title = "small"\neffort = 0.1'))
    return path


def _rows(folder: Path) -> list[dict[str, Any]]:
    """What does not differ between machines."""
    lines = (folder / "results.jsonl").read_text().splitlines()
    differ = ("seconds", "per_s", "memory")
    return [
        {k: v for k, v in json.loads(line).items() if not any(d in k for d in differ)}
        for line in lines
    ]


def test_it_is_the_sweep_of_the_program(
    study: Path, program: Callable[..., str], tmp_path: Path
) -> None:
    program("sweep", study, "--output", tmp_path / "theirs")
    ours = amacrine.sweep(study, tmp_path / "ours")
    assert _rows(tmp_path / "ours") == _rows(tmp_path / "theirs")
    assert (len(ours), ours.finished, ours.computed, ours.missing) == (9, 9, 9, [])
    assert "<table>" in ours._repr_html_()
    again = amacrine.sweep(study, tmp_path / "ours")
    assert again.computed == 0
    # The program goes on with the folder.
    told = json.loads(program("sweep", study, "--output", tmp_path / "ours", "--json"))
    assert told["computed"] == 0
    other = amacrine.sweep(study, tmp_path / "other", set={"threshold": [4], "reference.format": ["f16"]})
    assert len(other) == 2 and {row["threshold_on"] for row in other.rows} == {4.0}


def test_a_folder_that_is_not_finished_is_read(study: Path, program: Callable[..., str], tmp_path: Path) -> None:
    program("sweep", study, "--output", tmp_path / "part", "--shard", "0/2")
    part = amacrine.Sweep(tmp_path / "part")
    assert (len(part), part.finished, part.missing) == (5, 5, [1, 3, 5, 7])
    assert [row["index"] for row in part.rows] == [0, 2, 4, 6, 8]
    # A kill leaves points and no tables; one more point is there than the tables know.
    program("sweep", study, "--output", tmp_path / "other", "--shard", "1/2")
    kept = next((tmp_path / "other" / "points").iterdir())
    (tmp_path / "part" / "points" / kept.name).write_bytes(kept.read_bytes())
    assert (len(part), len(part.missing)) == (6, 3)
    (tmp_path / "part" / "results.jsonl").unlink()
    assert len(part.rows) == 6
    # In the order of docs/sweeps.md.
    assert list(part.rows[0])[:4] == ["index", "id", "task", "side"]
    with pytest.raises(amacrine.Error, match="is not a folder of results"):
        _ = amacrine.Sweep(tmp_path).rows


def test_a_scene_that_ends_early_is_told_of(study: Path, tmp_path: Path) -> None:
    keys = {"threshold": 4, "frames": 50, "reference.format": "f32"}
    with pytest.warns(amacrine.Caution, match="it ends after 8 frames") as said:
        amacrine.sweep(study, tmp_path / "out", set=keys)
    assert {Path(one.filename).name for one in said} == {"test_sweep.py"}


def test_rows_as_a_frame(study: Path, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    swept = amacrine.sweep(study, tmp_path / "out", set={"threshold": 4})
    frame = swept.to_frame()
    assert isinstance(frame, pandas.DataFrame) and list(frame["side"])[0] == "reference"


def test_keys_of_any_kind_are_set(study: Path, tmp_path: Path) -> None:
    def thresholds(name: str, given: Any) -> list[tuple[float, float]]:
        swept = amacrine.sweep(study, tmp_path / name, set={"threshold": given, "format": "f64"})
        found = {(row["threshold_on"], row["threshold_off"]) for row in swept.rows}
        return sorted(found)

    assert thresholds("table", {"on": 8, "off": 16, "sigma": 0}) == [(8.0, 16.0)]
    assert thresholds("tables", [{"on": 8, "off": 16}, 4]) == [(4.0, 4.0), (8.0, 16.0)]
    assert thresholds("array", np.array([8, 16.0])) == [(8.0, 8.0), (16.0, 16.0)]
    assert thresholds("range", range(4, 10, 4)) == [(4.0, 4.0), (8.0, 8.0)]


def test_an_array_of_kernels_is_one_sensor(study: Path, tmp_path: Path) -> None:
    edge = np.array([[-1.0, 0, 1]] * 3)
    np.save(tmp_path / "two.npy", np.stack([edge, edge.T]) / 4)
    keys = {"kernel": "two.npy", "threshold": {"on": np.array([4, 8]), "off": 8}, "array.memory": "shared"}
    swept = amacrine.sweep(study, tmp_path / "out", set=keys)
    assert {(row["kinds"], row["outcome"]) for row in swept.rows} == {(2, "done")}
    words = "{ on = [4.0, 8.0], off = 8.0, sigma = 0.0 }"
    assert {row["thresholds"] for row in swept.rows} == {words}


def test_keys_that_are_set_have_a_folder_of_their_own(
    study: Path, program: Callable[..., str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    program("sweep", study, "threshold=4", "reference.format=f16")
    made = [path.name for path in tmp_path.iterdir() if path.is_dir()]
    assert len(made) == 1 and re.fullmatch("small-[0-9a-f]{8}", made[0])
    set = {"threshold": 4, "reference.format": ["f16"]}
    swept = amacrine.sweep(study, set=set)
    assert (swept.folder.name, swept.computed) == (made[0], 0)
    other = amacrine.sweep(study, set={"threshold": 8, "reference.format": ["f16"]})
    assert other.folder.name not in (made[0], "small") and other.computed == 2
    with pytest.raises(amacrine.Error, match=r"\(2 points\), not .*\(9 points\)"):
        amacrine.sweep(study, other.folder)


LONG = """
import amacrine, sys
amacrine.sweep(sys.argv[1], sys.argv[2], jobs=1, set={"threshold": [*range(1, 60)], "frames": 8})
"""


def blown(script: str, study: Path, output: Path, kept: Path, blow: signal.Signals) -> str:
    """What a sweep says that a signal ends once three files are kept."""
    with subprocess.Popen(
        [sys.executable, "-c", script, study, output], stderr=subprocess.PIPE, text=True
    ) as run:
        until = time.monotonic() + 60
        while len(list(kept.glob("*.json"))) < 3 and time.monotonic() < until:
            time.sleep(0.02)
        os.kill(run.pid, blow)
        return run.communicate(timeout=60)[1]


@pytest.mark.parametrize("blow", [signal.SIGKILL, signal.SIGINT])
def test_what_is_finished_is_kept(blow: signal.Signals, study: Path, tmp_path: Path) -> None:
    """Killed, or stopped by Ctrl-C, it goes on where it was."""
    output = tmp_path / "out"
    points = output / "points"
    said = blown(LONG, study, output, points, blow)
    there = len([p for p in points.iterdir() if len(p.stem) == 32])
    assert 3 <= there < 177, there
    assert ("KeyboardInterrupt" in said) == (blow == signal.SIGINT), said
    some = {"threshold": [*range(1, 60)], "frames": 8}
    subprocess.run(
        [sys.executable, "-c", LONG.replace("jobs=1", "jobs=2"), study, output], check=True
    )
    swept = amacrine.sweep(study, output, set=some)
    assert (swept.computed, len(swept)) == (0, 177)


SEARCH = """
scene = "pattern:noise?width=48&height=32&frames=40&fps=100"
kernel = "csdvs-3"
threshold = { from = 1, to = 60, steps = 1000 }
sample = { method = "search", points = 4000, cost = "bits" }
[[side]]
side = "reference"
format = ["f64", "f32"]
"""

STOPPED = """
import amacrine, sys
amacrine.sweep(sys.argv[1], sys.argv[2], jobs=1)
"""


def test_ctrl_c_ends_a_search(tmp_path: Path) -> None:
    study, output = tmp_path / "search.toml", tmp_path / "out"
    study.write_text(SEARCH)
    tried = output / "pilots"
    said = blown(STOPPED, study, output, tried, signal.SIGINT)
    assert "KeyboardInterrupt" in said, said
    assert 3 <= len(list(tried.glob("*.json"))) < 2000
    assert not list((output / "points").glob("*.json"))


FULL = """
scene = "bundled"
frames = 8
kernel = "dvs"
threshold = [2, 3]
effort = 0.1
[[side]]
side = "array"
"""


def test_it_warns_as_the_program_does(program: Callable[..., str], tmp_path: Path) -> None:
    """Of what the points say, too, not of the scenes alone."""
    study = tmp_path / "full.toml"
    study.write_text(FULL)
    said = program("sweep", study, "--output", tmp_path / "theirs", beside=True)
    theirs = re.findall(r"^warning: (.*(?:\nhelp: .*)?)$", said, flags=re.MULTILINE)
    assert any("slots were full" in text for text in theirs), said
    with pytest.warns(amacrine.Caution) as caught:
        amacrine.sweep(study, tmp_path / "ours")
    assert [str(one.message) for one in caught] == [_amacrine.in_python(text) for text in theirs]


def test_files_that_are_set_aside_are_told_of(
    study: Path, program: Callable[..., str], tmp_path: Path
) -> None:
    set, output = {"threshold": 4, "reference.format": ["f16"]}, tmp_path / "out"
    assert amacrine.sweep(study, output, set=set).damaged == []
    point = next((output / "points").iterdir())
    point.write_text(point.read_text()[:-9])
    program("sweep", study, "threshold=4", "reference.format=f16", "--output", output)
    point.write_text(point.read_text()[:-9])
    with pytest.warns(amacrine.Caution, match="damaged 1 file of points, set aside in ") as said:
        swept = amacrine.sweep(study, output, set=set)
    (file,) = swept.damaged
    assert Path(file["path"]) == point and file["point"] in (0, 1) and swept.computed == 1
    (text,) = (str(one.message) for one in said if "set aside" in str(one.message))
    assert f"{output}/damaged:" in text and f"{point}: {file['why']}" in text
    assert len(list((output / "damaged").iterdir())) == 2


@pytest.mark.parametrize("script", [None, "dask_sweep.py", "ray_sweep.py"])
def test_a_shard_that_is_still_computed_is_waited_for(
    script: str | None, study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A task that is tried again may meet what a lost worker has left running."""
    # The program breaks the lines of its messages: of one of these names in the middle of the words.
    monkeypatch.chdir(tmp_path)
    for letters in (1, 20, 40, 50, 60):
        output = Path("o" * letters)
        folder = output / "shard-0"
        folder.mkdir(parents=True)
        lock = (folder / "lock").open("w")
        fcntl.flock(lock, fcntl.LOCK_EX)
        waits: list[float] = []

        def sleep(seconds: float) -> None:
            waits.append(seconds)
            lock.close()

        with monkeypatch.context() as patch:
            patch.setattr(time, "sleep", sleep)
            if script is None:
                given = str(study), study.read_text(), tmp_path
                told = sweeps._shard(given, [], output, (0, 3), None)
            else:
                for engine in ("dask", "dask.distributed", "ray"):
                    patch.setitem(sys.modules, engine, MagicMock())
                # What is decorated is as it was.
                sys.modules["ray"].remote = lambda **_: lambda made: made  # type: ignore[attr-defined]
                patch.setenv("FORCE_COLOR", "1")
                own = runpy.run_path(str(ROOT / "examples/cluster" / script))
                program = os.environ.get("AMACRINE", ROOT / "target/release/amacrine")
                told = own["shard"](program, study, output, 0, 3)
        assert waits == [5], output
        assert json.loads(told)["computed"] == 3


def test_on_a_cluster(study: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("dask.distributed")
    amacrine.sweep(study, tmp_path / "alone")
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, processes=True
    )
    with cluster, distributed.Client(cluster) as client:
        swept = amacrine.sweep(study, tmp_path / "dask", client=client, shards=3)
        assert swept.folder == tmp_path / "dask/all" and swept.computed == 9
        assert _rows(swept.folder) == _rows(tmp_path / "alone")
        again = amacrine.sweep(study, tmp_path / "dask", client=client)
        assert len(again) == 9 and again.computed == 0
        with pytest.raises(amacrine.Error, match="was begun with 3: .*computed again"):
            amacrine.sweep(study, tmp_path / "dask", client=client, shards=2)
        with pytest.raises(amacrine.Error, match="shards = 0"):
            amacrine.sweep(study, tmp_path / "x", client=client, shards=0)
        assert not (tmp_path / "x").exists()
        with pytest.raises(amacrine.Error, match="jobs with a client"):
            amacrine.sweep(study, tmp_path / "x", client=client, jobs=2)


def _begun(folder: Path) -> list[str]:
    """The points whose computation was begun, as often as it was."""
    return (folder / "ledger.txt").read_text().split()


@pytest.mark.filterwarnings("ignore::amacrine.Caution")
def test_a_worker_that_is_killed_costs_the_point_in_flight(study: Path, tmp_path: Path) -> None:
    """A worker of a cluster is killed in the middle of its shard, which goes on on another."""
    distributed = pytest.importorskip("dask.distributed")
    many = {"threshold": [*range(4, 20)]}
    amacrine.sweep(study, tmp_path / "alone", set=many)
    output = tmp_path / "dask"
    shards = [output / "shard-0", output / "shard-1"]

    def kept(shard: Path) -> set[str]:
        return {path.name for path in shard.glob("points/*.json") if len(path.stem) == 32}

    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, processes=True
    )
    with cluster, distributed.Client(cluster) as client, ThreadPoolExecutor(1) as pool:
        workers = client.run(os.getpid)
        sweep = pool.submit(amacrine.sweep, study, output, set=many, client=client, shards=2)
        while any(len(kept(shard)) < 3 for shard in shards) and not sweep.done():
            time.sleep(0.005)
        busy = next((worker for worker, tasks in client.processing().items() if tasks), None)
        assert busy, sweep.result()
        os.kill(workers[busy], signal.SIGKILL)
        there = [kept(shard) for shard in shards]
        swept = sweep.result()
        # The task of the killed worker was computed in two parts, of which the second is told.
        assert swept.computed < len(swept) == 48
        assert _rows(swept.folder) == _rows(tmp_path / "alone")
        for shard, before in zip(shards, there):
            assert before <= kept(shard)
        begun = [point for shard in shards for point in _begun(shard)]
        assert len(set(begun)) == 48 and len(begun) <= 49
        assert amacrine.sweep(study, output, set=many, client=client).computed == 0
