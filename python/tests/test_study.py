"""Studies give the numbers of the command line."""

from __future__ import annotations

import json
import pickle
import re
import warnings
from pathlib import Path
from typing import Any, Callable

import amacrine
import numpy as np
import pytest
from conftest import ends_on_ctrl_c

SCENE = "pattern:disc?width=48&height=40&frames=12&fps=50"


def test_quantise(program: Callable[..., str]) -> None:
    stated = json.loads(program("quantise", "rgc-5x5", "--to", "ternary,int-5", "--json"))
    few = amacrine.quantise("rgc-5x5", ["ternary", "int-5"])
    for one, row in zip(few, stated["quantised"], strict=True):
        assert one.to == row["to"] and one.scale == row["scale"]
        assert one.levels.tolist() == row["levels"]
        assert one.relative_error == row["relative_error"]
    alone = amacrine.quantise(few[1].kernel, "int-5")
    assert alone.relative_error < 1e-12
    np.testing.assert_allclose(alone.kernel, few[1].kernel)


def test_several_kernels_are_quantised(program: Callable[..., str]) -> None:
    random = np.random.default_rng(3)
    three = random.normal(size=(3, 3, 3))
    by_chance: Any = [
        amacrine.quantise("rgc-5x5", "q3.4:stochastic", sum="free", seed=seed) for seed in (0, 1)
    ]
    assert not np.array_equal(by_chance[0].levels, by_chance[1].levels)
    drawn = amacrine.quantise("rgc-5x5", ["ternary", "q3.4:stochastic"], sum="free", seed=1)
    assert np.array_equal(drawn[1].levels, by_chance[1].levels)
    each = amacrine.quantise(three, "ternary")
    assert [one.name for one in each] == ["kernel 0", "kernel 1", "kernel 2"]
    for one, kernel in zip(each, three, strict=True):
        alone = amacrine.quantise(kernel, "ternary")
        assert (alone.name, alone.scale) == ("the kernel", one.scale)
        assert np.array_equal(alone.levels, one.levels)
    table = amacrine.quantise(["dvs", "sobel-x"], ["ternary", "int-5"])
    assert [[one.to for one in few] for few in table] == [["ternary", "int-5"]] * 2
    stated = json.loads(program("quantise", "dvs,sobel-x", "--to", "ternary,int-5", "--json"))
    for few, kernel in zip(table, stated["kernels"], strict=True):
        assert [one.name for one in few] == [kernel["name"]] * 2
        assert [one.scale for one in few] == [row["scale"] for row in kernel["quantised"]]


def test_several_kernels_are_run_in_one_program(program: Callable[..., str]) -> None:
    words = ("--to", "ternary", "--threshold", "20,30", "--scene", SCENE, "--effort", 0.05)
    stated = json.loads(program("quantise", "dvs,sobel-x", *words, "--json"))
    answer = amacrine.quantise(
        ["dvs", "sobel-x"], "ternary", thresholds=[20, 30], scene=SCENE, effort=0.05
    )
    assert answer.to_dict()["together"] == stated["together"]
    assert answer.to_dict()["kernels"] == stated["kernels"]
    assert [kind.name for kind in answer.kernels] == ["dvs", "sobel-x"]
    assert "ternary" in answer._repr_html_()
    with pytest.raises(amacrine.Error, match="3 thresholds for 2 kernels"):
        amacrine.quantise(["dvs", "sobel-x"], "ternary", thresholds=[1, 2, 3], scene=SCENE)


def test_a_quantised_kernel_is_a_table_in_a_notebook() -> None:
    shown = amacrine.quantise(np.array([[0, 1, 0], [1, -4, 1], [0, 1, 0]]), "ternary")._repr_html_()
    assert shown.count("<table>") == 2
    assert "<td>ternary</td>" in shown and shown.count("<td>-1</td>") == 1


def test_quantised_kernels_are_a_list_and_a_table() -> None:
    two = [np.array([[0, 1, 0], [1, -4, 1], [0, 1, 0]]), np.ones((17, 17))]
    alone: Any = amacrine.quantise(two[0], ["ternary", "int-5"])
    assert issubclass(type(alone), list) and [one.to for one in alone] == ["ternary", "int-5"]
    shown = alone._repr_html_()
    # One for all, and the levels of each.
    assert shown.count("<table>") == 3 and "the kernel, int-5" in shown
    table = amacrine.quantise(two, ["ternary", "int-5"])
    assert [len(few) for few in table] == [2, 2]
    shown = table._repr_html_()
    assert shown.count("<td>kernel 1</td>") == 2
    # Nobody reads a table of 17 columns.
    assert shown.count("<table>") == 3 and "2 kernels are not drawn" in shown
    pandas = pytest.importorskip("pandas")
    frame = table.to_frame()
    assert isinstance(frame, pandas.DataFrame) and len(frame) == 4
    assert frame["scale"].tolist() == [one.scale for few in table for one in few]
    again = pickle.loads(pickle.dumps(alone))
    assert again._repr_html_() == alone._repr_html_()
    assert amacrine.quantise(two, "ternary")._repr_html_().count("<td>ternary</td>") == 2


def _cells(shown: str) -> list[list[str]]:
    """The cells of a table, row by row."""
    rows = re.findall(r"<tr>(.*?)</tr>", shown)
    return [re.findall(r"<t[hd]>(.*?)</t[hd]>", row) for row in rows]


def test_a_notebook_shows_what_is_kept_on_the_chip() -> None:
    how: Any = {"scene": SCENE, "effort": 0.05}
    answer = amacrine.quantise("csdvs-3", ["ternary", "int-5"], thresholds=20, **how)
    head, *rows = _cells(answer._repr_html_())
    assert head == ["to", "relative error", "words", "us", "registers", "kept", "as threshold, %"]
    frame = answer.to_frame()
    assert [row[2] for row in rows] == frame["on_chip.words"].astype(str).tolist()
    assert [float(row[3]) for row in rows] == pytest.approx(frame["on_chip.array_us"], rel=1e-3)
    assert [float(row[5]) for row in rows] == pytest.approx(frame["kept"], rel=1e-3)
    assert pickle.loads(pickle.dumps(answer))._repr_html_() == answer._repr_html_()

    both = amacrine.quantise(["dvs", "sobel-x"], "ternary", thresholds=[20, 30], **how)
    head, row = _cells(both._repr_html_())
    kinds = ["kept of dvs", "as threshold, % of dvs", "kept of sobel-x", "as threshold, % of sobel-x"]
    assert head == ["to", "words", "us", *kinds]
    assert row[1] == str(both.together[0].on_chip.words)
    kept = [kind.silicon.kept for kind in both.together[0].on_chip.kinds]
    assert [float(row[3]), float(row[5])] == pytest.approx(kept, rel=1e-3)


CHANGE = """response = { linear = 255 }
memory = "raw-snap"
shared = true
border = "zero"

[[channel]]
name = "change"
kernel = "dvs"
threshold = { on = 0.1, off = 0.1 }

[[channel]]
kernel = "sobel-x"
threshold = { on = 0.3, off = 0.3 }
"""


def test_studies_take_sensors(program: Callable[..., str], tmp_path: Path) -> None:
    """With their thresholds, in kernel times light, and what they remember, as the command line does."""
    file = tmp_path / "own.toml"
    file.write_text(CHANGE)
    own: Any = file, str(file), amacrine.Sensor.from_file(file)
    words = ("--scene", SCENE, "--effort", 0.05, "--json")
    how: Any = {"scene": SCENE, "effort": 0.05}
    stated = json.loads(program("quantise", file, "--to", "ternary", *words))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", amacrine.Caution)
        for one in own:
            answer = amacrine.quantise(one, "ternary", **how).to_dict()
            if not isinstance(one, amacrine.Sensor):
                assert answer["kernels"] == stated["kernels"]
                assert answer["together"] == stated["together"]
            assert answer["together"][0]["on_chip"]["memory"] == "one memory of the pixel for all kinds"
            kinds = [kind["name"] for kind in answer["kernels"]]
            assert kinds == ["change", f"{'own' if isinstance(one, amacrine.Sensor) else file}[1]"]
        stated = json.loads(program("waterfall", file, "--steps", "--to", "ternary", *words))
        falls = amacrine.waterfall(file, to="ternary", steps=True, **how)
        for fall, its in zip(falls, stated, strict=True):
            assert fall.name == its["name"] and fall.to_dict()["steps"] == its["steps"]
        # Others in place of its own.
        stated = json.loads(
            program("waterfall", file, "--threshold", 20, "--steps", "--to", "ternary", *words)
        )
        falls = amacrine.waterfall(own[2], 20, to="ternary", steps=True, **how)
        assert [fall.to_dict()["steps"] for fall in falls] == [its["steps"] for its in stated]


def test_reports_and_designs_take_sensors(program: Callable[..., str], tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(CHANGE.split("\n\n[[channel]]\nkernel")[0] + "\n")
    words = ("--scene", SCENE, "--effort", 0.05, "--to", "ternary", "--json")
    how: Any = {"scene": SCENE, "effort": 0.05, "to": "ternary"}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", amacrine.Caution)
        few = ("--candidates", "ternary", "--chips", 1)
        stated = json.loads(program("feasibility", file, *words, *few))
        report = amacrine.feasibility(file, candidates="ternary", chips=1, **how).to_dict()
        assert report["kernel"] == stated["kernel"]
        assert report["kernel"]["name"] == "change"
        stated = json.loads(program("design", file, *words))
        design = amacrine.design(amacrine.Sensor.from_file(file), **how).to_dict()
        for own, theirs in zip(design["candidates"], stated["candidates"], strict=True):
            assert {name: own[name] for name in theirs} == theirs
        with pytest.raises(amacrine.Error, match="and not both"):
            amacrine.design(file, rate=2, thresholds=20, **how)
        # A sensor beside a kernel: not all have thresholds.
        with pytest.raises(amacrine.Error, match="(?s)a waterfall needs a threshold.*or a sensor"):
            amacrine.waterfall([file, "dvs"], scene=SCENE)


@pytest.mark.filterwarnings("ignore::amacrine.Caution")
def test_what_no_study_follows_of_a_sensor_is_told_of() -> None:
    with pytest.warns(amacrine.Caution, match="rgc-4: its memory is not filtered-snap") as said:
        amacrine.quantise("rgc-4", "ternary", scene=SCENE, effort=0.01)
    assert {Path(one.filename).name for one in said} == {"test_study.py"}
    for study in (amacrine.design, amacrine.feasibility, amacrine.waterfall):
        with pytest.raises(amacrine.Error, match="a channel has a resistor mesh"):
            study("csdvs-mesh")


def test_a_notebook_says_why_nothing_is_kept() -> None:
    how: Any = {"scene": SCENE, "effort": 0.05}
    small = np.array([[0, 1, 0], [1, -4, 1], [0, 1, 0]]) / 300
    with pytest.warns(amacrine.Caution, match="no event at all") as told:
        answer = amacrine.quantise(small, ["q3.4", "ternary"], thresholds=20, **how)
    # They are of the line that asked.
    assert {one.filename for one in told} == {__file__}
    head, refused, silent = _cells(answer._repr_html_())
    assert head[-1] == "why not" and "kept" in head
    assert refused[-1].startswith("every weight becomes 0 in q3.4")
    assert silent[-1].startswith("no event at all in")


def test_quantise_on_the_chip(program: Callable[..., str]) -> None:
    words = ("--threshold", 20, "--scene", SCENE, "--effort", 0.05)
    stated = json.loads(program("quantise", "csdvs-3", "--to", "ternary", *words, "--json"))
    answer = amacrine.quantise("csdvs-3", ["ternary"], thresholds=20, scene=SCENE, effort=0.05)
    of_command = ("kernel", "sum", "quantised", "chip")
    assert {name: answer.to_dict()[name] for name in of_command} == {
        name: stated[name] for name in of_command
    }
    assert answer.quantised[0].scale == amacrine.quantise("csdvs-3", "ternary").scale
    assert answer.to_frame().to.tolist() == answer.to_frame("chip.rows").to.tolist() == ["ternary"]
    with pytest.raises(KeyError, match="words is no table; there are kernel, quantised, warnings, chip.rows"):
        answer.to_frame("words")
    frames, fps = amacrine.load(SCENE)
    scale = None if frames.dtype == np.uint8 else 1
    same = amacrine.quantise(
        "csdvs-3", ["ternary"], thresholds=20, scene=frames, fps=fps, scale=scale, effort=0.05
    )
    # The same light, of an array.
    own, theirs = ({**of.to_dict(), "light": None} for of in (same, answer))
    assert own == theirs and [same.light[end] for end in ("least", "most")] == [
        answer.light[end] for end in ("least", "most")
    ]
    assert "ternary" in answer._repr_html_()


def test_feasibility(program: Callable[..., str], tmp_path: Path) -> None:
    words = ("--threshold", 20, "--scene", SCENE, "--effort", 0.05, "--chips", 1)
    to = ("--to", "ternary", "--candidates", "ternary")
    stated = json.loads(program("feasibility", "--kernel", "csdvs-3", *words, *to, "--json"))
    answer = amacrine.feasibility(
        "csdvs-3", 20, to="ternary", candidates=["ternary"], scene=SCENE, effort=0.05, chips=1
    )
    of = answer.to_dict()
    assert len(stated) > 15
    said = amacrine.Answer.parse(json.dumps(stated)).to_dict()
    for name in set(stated) - {"command"}:
        assert of[name] == said[name], name
    # What it says is said in arguments.
    assert "(--readout overlapped)" in json.dumps(stated)
    assert "(overlapped=True)" in json.dumps(of) and not re.search(r"--[a-z]", json.dumps(of))
    _check_page(str(answer.page))
    assert "<iframe srcdoc=" in answer._repr_html_()
    answer.save(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>")
    assert pickle.loads(pickle.dumps(answer)) == answer
    with pytest.raises(AttributeError, match="verdict"):
        answer.verdicts


def test_feasibility_of_several_kernels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A table for all of them, each called as on the command line."""
    monkeypatch.chdir(tmp_path)
    np.save("own.npy", amacrine.Sensor("csdvs-3", 1).kernels[0])
    answer = amacrine.feasibility(
        ["own.npy", "sobel-x"], 20, to="ternary", candidates=["ternary", "int-5"], scene=SCENE,
        effort=0.05, chips=1,
    )
    said = json.dumps(answer.to_dict()) + str(answer.page)
    assert "own.npy" in said and "kernel 0" not in said
    pytest.importorskip("pandas")
    frame = answer.to_frame()
    rows = [("own.npy", "ternary"), ("own.npy", "int-5"), ("sobel-x", "ternary"), ("sobel-x", "int-5")]
    assert [*zip(frame["kernel"], frame["to"])] == rows
    assert set(answer.to_frame("tornado")["kernel"]) == {"own.npy", "sobel-x"}
    with pytest.raises(KeyError, match="none is no table; there are"):
        answer.to_frame("none")


def test_files_of_kernels_are_called_as_on_the_command_line(
    program: Callable[..., str], tmp_path: Path
) -> None:
    one, two = tmp_path / "one.npy", tmp_path / "two.npy"
    plane = amacrine.Sensor("sobel-x", 1).kernels[0]
    np.save(one, plane)
    np.save(two, np.stack([plane, plane.T]))
    stated = json.loads(program("quantise", one, two, "dvs", "--to", "ternary", "--json"))
    called = [of["name"] for of in stated["kernels"]]
    assert called == [str(one), f"{two}[0]", f"{two}[1]", "dvs"]
    names = [of.name for of in amacrine.quantise([one, str(two), "dvs", plane], "ternary")]
    assert names == [*called, "kernel 4"]
    assert amacrine.quantise(one, "ternary").name == str(one)
    assert amacrine.quantise(plane, "ternary").name == "the kernel"


def _texts(page: str) -> str:
    """What is read of a page, or a drawing: no tags, no style sheets."""
    return re.sub(r"<style\b.*?</style>|<[^>]*>", " ", page, flags=re.DOTALL)


def _check_page(page: str) -> None:
    """It speaks of arguments, and its style sheet is as it was."""
    assert "(overlapped=True)" in page and "to_dict()" in page
    assert not re.findall(r"--[a-z]+", _texts(page))
    names = set(re.findall(r"var\((--[a-z-]+)\)", page))
    assert len(names) > 3 and all(re.search(rf"{name}\s*:", page) for name in names)


def test_the_drawing_of_a_trade_speaks_of_arguments() -> None:
    frames, fps = amacrine.load(SCENE)
    scale = None if frames.dtype == np.uint8 else 1
    trade = amacrine.trade(amacrine.Sensor("dvs", 0.3), frames, fps=fps, scale=scale)
    texts = _texts(str(trade.drawing))
    assert "verify=True measures them" in texts and "runs=N shares them" in texts
    assert not re.findall(r"--[a-z]+", texts)


def test_feasibility_at_a_rate(program: Callable[..., str]) -> None:
    """The thresholds are found, as on the command line."""
    words = ("--rate", 2, "--scene", SCENE, "--effort", 0.05, "--chips", 1, "--to", "ternary")
    kernels = ["csdvs-3", "sobel-x"]
    stated = program("feasibility", ",".join(kernels), *words, "--candidates", "ternary", "--json")
    how: Any = {"to": "ternary", "candidates": ["ternary"], "scene": SCENE, "effort": 0.05}
    answer = amacrine.feasibility(kernels, rate=2, chips=1, **how)
    theirs = json.loads(stated)["kernels"]
    for own, kernel in zip(answer.to_dict()["kernels"], theirs, strict=True):
        assert own["kernel"] == kernel["kernel"] and own["streams"] == kernel["streams"]


def test_a_rate_that_no_threshold_gives_is_told_of(
    program: Callable[..., str], tmp_path: Path
) -> None:
    """In the words of the command line, by the function and in what it returns."""
    frames = np.zeros((8, 24, 32), np.uint8)
    frames[1::2, :, :16] = 200
    np.save(tmp_path / "halves.npy", frames)
    scene: Any = {"scene": tmp_path / "halves.npy", "fps": 100}
    words = ("--rate", 20, "--scene", scene["scene"], "--fps", 100, "--effort", 0.05)
    to = ("--chips", 1, "--to", "ternary", "--candidates", "ternary")
    stated = json.loads(program("feasibility", "dvs", *words, *to, "--json"))
    how: Any = {"to": "ternary", "candidates": ["ternary"], "effort": 0.05, "chips": 1}
    with pytest.warns(amacrine.Caution, match="no threshold gives 20 events"):
        answer = amacrine.feasibility("dvs", rate=20, **how, **scene)
    own = answer.to_dict()["warnings"]
    assert "rate" in {one["about"] for one in own}
    assert own == amacrine.Answer.parse(json.dumps(stated)).to_dict()["warnings"]
    assert "no threshold gives 20 events" in str(answer.page)


def test_light_of_another_scale_is_told_of() -> None:
    """By studies, whatever they are of."""
    frames, fps = amacrine.load(SCENE)
    light: Any = {"scene": frames / 255, "fps": fps, "scale": 1}
    snap = amacrine.Program.from_file("dvs/snap")
    with pytest.warns(amacrine.Caution, match="all light lies between") as said:
        amacrine.trade(snap, formats=["f32"], **light)
    assert {Path(one.filename).name for one in said} == {"test_study.py"}
    with pytest.warns(amacrine.Caution, match="give scale=255") as said:
        amacrine.waterfall("csdvs-3", 0.1, steps=True, effort=0.01, **light)
    assert {Path(one.filename).name for one in said} == {"test_study.py"}
    with pytest.warns(amacrine.Caution, match="give scale=255") as said:
        amacrine.quantise("csdvs-3", ["int-5"], thresholds=0.1, effort=0.01, **light)
    assert {Path(one.filename).name for one in said} == {"test_study.py"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        amacrine.trade(snap, frames, fps=fps, scale=1, formats=["f32"])


def test_design(program: Callable[..., str], tmp_path: Path) -> None:
    words = ("--rate", 2, "--scene", SCENE, "--effort", 0.05, "--to", "ternary,int-3")
    out = tmp_path / "made"
    stated = json.loads(program("design", "csdvs-3", *words, "--chips", 1, "-o", str(out), "--json"))
    answer = amacrine.design(
        "csdvs-3", rate=2, to=["ternary", "int-3"], scene=SCENE, effort=0.05
    )
    of = answer.to_dict()
    assert (of["knee"], of["rated"]) == (stated["knee"], stated["rated"])
    for own, theirs in zip(of["candidates"], stated["candidates"], strict=True):
        assert {name: own[name] for name in theirs} == theirs
    # Where no row keeps more than chance there is no knee, and the first is taken.
    taken = of["candidates"][of["knee"] or 0]
    assert taken["sensor"].replace("design", "made") == (out / "sensor.toml").read_text()
    written = (out / "program.scamp").read_text()
    assert taken["program"].replace("design", "made") == written
    with pytest.raises(amacrine.Error, match="a rate of events, or thresholds"):
        amacrine.design("csdvs-3")
    for study in (amacrine.design, amacrine.feasibility):
        with pytest.raises(amacrine.Error, match="all weights are 0"):
            study(np.zeros((3, 3)), rate=2, scene=SCENE)


def test_a_design_warns_as_the_command_line(program: Callable[..., str]) -> None:
    scene = "pattern:disc?width=24&height=20&frames=4&fps=50"
    words = ("--threshold", 60, "--scene", scene, "--effort", 0.01, "--to", "ternary")
    stated = json.loads(program("design", "sobel-x", *words, "--memory", "analogue", "--json"))
    with pytest.warns(amacrine.Caution, match="what is kept: the float sensor has ") as said:
        answer = amacrine.design(
            "sobel-x", thresholds=60, to="ternary", memory="analogue", scene=scene, effort=0.01
        )
    assert [one["about"] for one in stated["warnings"]] == ["window", "few-events"]
    for own, theirs in zip(answer.to_dict()["warnings"], stated["warnings"], strict=True):
        # What is to change is called as arguments are.
        change = theirs["change"].replace("--within, in a study `within`", "within")
        assert own == theirs | {"change": change}
    assert {Path(one.filename).name for one in said} == {"test_study.py"}


def test_waterfall(program: Callable[..., str], tmp_path: Path) -> None:
    words = ("--threshold", 20, "--scene", SCENE, "--effort", 0.05, "--steps")
    stated = json.loads(program("waterfall", "csdvs-3", "--to", "ternary", *words, "--json"))
    answer = amacrine.waterfall("csdvs-3", 20, "ternary", scene=SCENE, effort=0.05, steps=True)
    of = answer.to_dict()
    for name in ("kept", "float_events", "chip_events", "steps", "program"):
        assert of[name] == stated[name], name
    assert answer._repr_html_().startswith("<svg")
    answer.save(tmp_path / "fall.svg")
    with pytest.raises(ValueError, match="there is no .html"):
        answer.save(tmp_path / "fall.html")


def test_a_waterfall_of_what_if(program: Callable[..., str]) -> None:
    words = ("--threshold", 20, "--scene", SCENE, "--effort", 0.05, "--steps", "--json")
    set = "--set", "error.noise=2", "--set", "error.offset_mismatch=0"
    how: Any = dict(scene=SCENE, effort=0.05, steps=True)
    what_if = {"error.noise": 2, "error.offset_mismatch": 0.0}
    much: Any = {"error.noise": "much"}
    stated = json.loads(program("waterfall", "csdvs-3", *words, *set))
    answer = amacrine.waterfall("csdvs-3", 20, set=what_if, **how)
    assert answer.to_dict()["steps"] == stated["steps"]
    assert stated["steps"] != json.loads(program("waterfall", "csdvs-3", *words))["steps"]
    with pytest.raises(amacrine.Error, match="no number `error.nois`; did you mean `error.noise`"):
        amacrine.waterfall("csdvs-3", 20, set={"error.nois": 1}, **how)
    with pytest.raises(amacrine.Error, match="error.noise"):
        amacrine.waterfall("csdvs-3", 20, set={"error.noise": -1}, **how)
    with pytest.raises(amacrine.Error, match=r'set\["error.noise"\] = .* is no number'):
        amacrine.waterfall("csdvs-3", 20, set=much, **how)
    with pytest.warns(amacrine.Caution, match='error.noise changes nothing.*domain="silicon"'):
        amacrine.waterfall("csdvs-3", 20, domain="exact", set={"error.noise": 1}, **how)


def test_a_waterfall_of_several_kernels(program: Callable[..., str]) -> None:
    """All of them in one program, as on the command line."""
    words = ["--threshold", "20,64", "--scene", SCENE, "--effort", "0.05", "--steps"]
    stated = json.loads(program("waterfall", "csdvs-3", "sobel-x", *words, "--json"))
    all = amacrine.waterfall(["csdvs-3", "sobel-x"], [20, 64], scene=SCENE, effort=0.05, steps=True)
    assert [one.name for one in all] == [one["name"] for one in stated] == ["csdvs-3", "sobel-x"]
    for own, its in zip(all, stated):
        assert own.to_dict()["steps"] == its["steps"] and own.kept == its["kept"]
        assert own.memory and str(own.drawing).startswith("<svg")
    assert all._repr_html_().count("<svg") == 2
    pytest.importorskip("pandas")
    frame = all.to_frame()
    assert len(frame) == sum(len(own.steps) for own in all)
    assert list(dict.fromkeys(frame["kernel"])) == ["csdvs-3", "sobel-x"]


def test_a_waterfall_behind_a_readout(program: Callable[..., str]) -> None:
    words = ("--threshold", 20, "--scene", SCENE, "--effort", 0.05, "--steps", "--to", "ternary")
    few = ("--readout", "scan", "--with", "slots=3")
    stated = json.loads(program("waterfall", "csdvs-3", *words, *few, "--json"))
    how: Any = {"to": "ternary", "scene": SCENE, "effort": 0.05, "steps": True}
    own = amacrine.waterfall("csdvs-3", 20, readout={"readout": "scan", "slots": 3}, **how)
    assert own.to_dict()["steps"] == stated["steps"]
    assert own.to_dict()["steps"] != amacrine.waterfall("csdvs-3", 20, **how).to_dict()["steps"]


def test_trade() -> None:
    scene = "pattern:grating?width=64&height=64&frames=20&fps=100"
    answer = amacrine.trade(amacrine.Sensor.from_file("rgc"), scene, formats=["f32"])
    names = [point.name for point in answer.points]
    assert "the full model" in names and "f32" in names
    assert answer.knee in names
    assert any(point.on_front for point in answer.points)
    assert answer._repr_html_().startswith("<svg")
    assert answer.drawing is not None and "knee: " in answer.drawing
    for point in answer.points:
        least, most = point.seconds_range
        assert least <= point.seconds <= most
    f32 = next(point for point in answer.points if point.name == "f32")
    assert f32.command == 'sensor.in_format("f32").events(frames, fps)'
    sensor, frames, fps = amacrine.Sensor.from_file("rgc"), np.zeros((3, 8, 8), np.uint8), 30
    of_f32 = amacrine.Sensor.from_file("rgc", format="f32")
    assert sensor.in_format("f32") == of_f32 != sensor
    assert len(eval(f32.command, {"sensor": sensor, "frames": frames, "fps": fps})) == 0
    assert answer.command == next(p.command for p in answer.points if p.is_knee)


def test_a_trade_says_the_command_of_its_own_frames_and_seed() -> None:
    frames = np.random.default_rng(1).random((12, 32, 32))
    sensor = amacrine.Sensor.from_file("dvs-v2e")
    answer = amacrine.trade(sensor, frames, fps=100, scale=255, seed=5, formats=["f32"], verify=True)
    given = {"sensor": sensor, "frames": frames, "fps": 100}
    command = next(point.command for point in answer.points if point.name == "f32")
    of_f32 = amacrine.Sensor.from_file("dvs-v2e", seed=5, format="f32")
    assert of_f32 == sensor.with_seed(5).in_format("f32")
    assert (eval(command, given) == of_f32.events(frames, 100, scale=255)).all()
    program = amacrine.Program.from_file("dvs/snap")
    answer = amacrine.trade(program, frames, fps=100, scale=255, seed=5, formats=["f32"])
    command = next(point.command for point in answer.points if point.name == "f32")
    assert command == 'program.run(frames, fps, scale=255.0, domain="f32", seed=5)'
    run = eval(command, {"program": program, "frames": frames, "fps": 100})
    assert len(run.events) == len(program.run(frames, 100, scale=255, domain="f32").events)


def test_trade_of_a_program(program: Callable[..., str]) -> None:
    scene = "pattern:grating?width=64&height=64&frames=20&fps=100"
    words = ("--scene", scene, "--program", "dvs/snap", "--formats", "f16", "--seed", 3)
    stated = json.loads(program("trade", *words, "--json"))
    snap = amacrine.Program.from_file("dvs/snap")
    answer = amacrine.trade(snap, scene, formats=["f16"], seed=3).to_dict()
    # Which models are tried together depends on seconds; each alone does not.
    for name in ("the full model", "f16", "silicon without mismatch"):
        own, theirs = (
            [point["error"] for point in one["points"] if point["name"] == name]
            for one in (answer, stated)
        )
        assert len(own) == 1 and own == theirs, name
    commands = [point["command"] for point in answer["points"] if point["name"] == "f16"]
    assert commands == ['program.run(frames, fps, domain="f16", seed=3)']
    exact = amacrine.trade(snap, scene, domain="exact", formats=["f32"])
    # Whether an order of the array that changes nothing is quicker depends on seconds.
    assert {point.name for point in exact.points} >= {"the full model", "f32"}
    with pytest.raises(amacrine.Error, match="leave upsample out"):
        amacrine.trade(snap, scene, upsample=0.2)


def test_a_table_is_a_data_frame() -> None:
    pandas = pytest.importorskip("pandas")
    answer = amacrine.Answer({"rows": [{"to": "a", "fit": {"words": 3}}]}, rows="rows")
    frame = answer.to_frame()
    assert isinstance(frame, pandas.DataFrame)
    assert frame["fit.words"].tolist() == [3]
    with pytest.raises(KeyError, match="rows"):
        answer.to_frame("none")


def test_an_answer_is_a_dict_where_one_is_asked_for() -> None:
    events = np.array([(5, 1, 2, 1)], amacrine.EVENT)
    answer = amacrine.compare(events, events)
    assert dict(answer)["f1"] == 1 and {**answer}["equal"] is True
    assert answer.keys() == list(answer)
    with pytest.raises(KeyError, match="there are headline"):
        answer["heading"]


def test_results_that_hold_arrays_can_be_compared() -> None:
    """By what they are, as arrays' own comparison is none."""
    one, other = (amacrine.quantise(np.eye(3), "ternary") for _ in range(2))
    assert one == one and one != other


STUDIES = {
    "feasibility": "amacrine.feasibility('csdvs-3', 20, to='ternary', candidates=['ternary'], **how)",
    "design": "amacrine.design('csdvs-3', thresholds=20, to='ternary', **how)",
    "waterfall": "amacrine.waterfall('csdvs-3', 20, to='ternary', **how)",
    "quantise": "amacrine.quantise('csdvs-3', 'ternary', thresholds=20, **how)",
}

LONG = "pattern:grating?width=192&height=192&frames=600&fps=100"

SEARCHES = {
    "compile": "amacrine.compile('rgc-5x5', 20, to='int-5', effort=3000)",
    "words": "amacrine.compile('rgc-5x5', 20, to='int-5', effort=3000, objective='words')",
    "on_chip": "amacrine.Sensor('dog', 0.1, memory='filtered-snap').on_chip('int-5', effort=3000)",
    "shared": "amacrine.compile(['dog', 'sobel-x'], 20, to='int-5', memory='shared', effort=3000)",
    "candidates": "amacrine.design('dog', thresholds=20, effort=3000)",
    "trade": f"amacrine.trade(amacrine.Sensor.from_file('rgc-4'), '{LONG}', verify=True, sample=1)",
    "trade of a program": f"amacrine.trade(amacrine.Program.from_file('dvs/snap'), '{LONG}', verify=True)",
}
"""What looks at no scene meanwhile, or at one that is kept."""

ENDLESS = """
import amacrine, sys
how = dict(scene="pattern:disc?width=48&height=40&frames=1000000&fps=50", effort=0.01)
print("begun", flush=True)
{}
"""


@pytest.mark.parametrize("study", [*STUDIES, *SEARCHES])
def test_studies_end_on_ctrl_c(study: str) -> None:
    """At the next frame of their scene; searches after what they look at."""
    code = ENDLESS.format((STUDIES | SEARCHES)[study])
    ends_on_ctrl_c(code, 20)
