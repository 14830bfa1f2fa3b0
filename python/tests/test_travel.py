"""What a worker of another process is sent, and copies."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import shutil
from pathlib import Path
from typing import Any

import amacrine
import numpy as np
import pytest
from conftest import ROOT, Frames, kernels

FPS = 50.0


def _float() -> amacrine.Sensor:
    return amacrine.Sensor(
        kernels(2, 3), [0.3, (0.2, 0.4)], memory="filtered-snap", border="zero", seed=3
    )


def _chip(**more: Any) -> amacrine.ChipSensor:
    return _float().on_chip("int-5", effort=0.05, **more)


def _watched(sensor: amacrine.EventSensor, frames: Frames) -> bytes:
    events = sensor.events(frames, FPS)
    assert len(events) > 100
    return bytes(events.tobytes())


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda of: pickle.loads(pickle.dumps(of))])
def test_a_program_that_was_found_travels(again: Any, frames: Frames) -> None:
    chip = _chip(readout="slots")
    other = again(chip)
    assert _watched(other, frames) == _watched(chip, frames)
    assert other.text == chip.text and other.notes == chip.notes
    assert (other.name, other.channels, other.words) == (chip.name, chip.channels, chip.words)
    assert (other.array_us, other.lsb) == (chip.array_us, chip.lsb)
    for (levels, scale), (want, by) in zip(other.levels, chip.levels, strict=True):
        assert np.array_equal(levels, want) and scale == by


def test_a_new_interpreter_watches_the_same(frames: Frames) -> None:
    sensors = [_float(), _chip()]
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        got = pool.starmap(_watched, [(sensor, frames) for sensor in sensors])
    assert got == [_watched(sensor, frames) for sensor in sensors]


def test_a_chip_in_a_folder_travels(tmp_path: Path, frames: Frames) -> None:
    folder = tmp_path / "mine"
    shutil.copytree(ROOT / "isa/scamp5", folder)
    data = folder / "device.toml"
    data.write_text(data.read_text().replace('name = "scamp5"', 'name = "mine"', 1))
    chip = _chip(chip=str(folder))
    assert _watched(pickle.loads(pickle.dumps(chip)), frames) == _watched(chip, frames)
    assert chip.program.words == chip.words


def test_a_program_travels(frames: Frames) -> None:
    snap = amacrine.Program.from_file("dvs/snap", constants={"threshold": 20})
    for other in (copy.deepcopy(snap), pickle.loads(pickle.dumps(snap))):
        assert repr(other) == repr(snap)
        run = other.run(frames, FPS)
        assert run.events.tobytes() == snap.run(frames, FPS).events.tobytes()


def _chip_of_mine(folder: Path) -> None:
    """A chip called `mine`, with the numbers of another."""
    shutil.copytree(ROOT / "isa/scamp5", folder / "mine")
    data = folder / "mine/device.toml"
    data.write_text(data.read_text().replace('name = "scamp5"', 'name = "mine"', 1))


def test_a_chip_of_a_relative_folder_is_found_from_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _chip_of_mine(tmp_path)
    said = amacrine.text("programs", "dvs/snap").replace('chip = "scamp5"', 'chip = "mine"')
    (tmp_path / "own.scamp").write_text(said)
    monkeypatch.chdir(tmp_path)
    chip = _chip(chip="mine")
    programs = [
        amacrine.Program.from_file("dvs/snap", chip="mine"),
        amacrine.Program.from_file("dvs/snap", chip=Path("mine")),
        amacrine.Program.from_text(said),
        amacrine.Program.from_file("own.scamp"),
        amacrine.compile_filter("csdvs-3", to="ternary", chip="mine", effort=0.02).program,
    ]
    sent = pickle.dumps((chip, programs))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert chip.program.chip == "mine"
    again, others = pickle.loads(sent)
    assert again.program.words == chip.words
    assert [other.chip for other in others] == ["mine"] * len(programs)
    assert [repr(other) for other in others] == [repr(one) for one in programs]


class Own(amacrine.Sensor):
    """A sensor that knows more."""

    gain: float

    def half(self) -> float:
        return self.gain / 2


@pytest.mark.parametrize(
    "again",
    [
        copy.copy,
        copy.deepcopy,
        lambda of: pickle.loads(pickle.dumps(of)),
        lambda of: of.with_seed(4),
        lambda of: of.in_format("f32"),
        lambda of: of.without("mismatch"),
        lambda of: of.for_rate(np.arange(3 * 8 * 8, dtype=np.uint8).reshape(3, 8, 8), FPS, 1.0),
    ],
)
@pytest.mark.filterwarnings("ignore::amacrine.Caution")
def test_a_subclass_stays_what_it_is(again: Any) -> None:
    sensor = Own("dvs", {"on": 0.1, "off": 0.1, "sigma": 0.01}, seed=3)
    sensor.gain = 5.0
    assert sensor.channels == ["0"]
    other = again(sensor)
    assert type(other) is Own and other.half() == 2.5 and other.channels == ["0"]


def test_sensors_of_the_same_text_are_equal() -> None:
    sensor = _float()
    assert sensor == amacrine.Sensor.from_text(sensor.text, seed=3)
    assert sensor == _float() == pickle.loads(pickle.dumps(sensor))
    assert len({sensor, _float()}) == 1
    assert sensor != amacrine.Sensor.from_text(sensor.text, seed=4) and sensor != sensor.text


def test_a_kernel_file_is_found_from_another_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine.toml").write_text("centre-surround = 5\n")
    (tmp_path / "sensor.toml").write_text(
        'response = "identity"\nmemory = "filtered-step"\n[[channel]]\nkernel = "mine.toml"\n'
        "threshold = { on = 1, off = 1 }\n"
    )
    monkeypatch.chdir(tmp_path)
    sensors = [amacrine.Sensor("mine.toml", 0.1), amacrine.Sensor.from_file("sensor.toml")]
    sent = pickle.dumps(sensors)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    (tmp_path / "elsewhere/mine.toml").write_text("centre-surround = 3\n")
    assert amacrine.Sensor("mine.toml", 0.1) != sensors[0]
    assert [sensor.kernels[0].shape for sensor in pickle.loads(sent)] == [(5, 5), (5, 5)]
