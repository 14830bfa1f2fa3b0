"""Programs of the array, and sensors as programs."""

from __future__ import annotations

import base64
import functools
import io
import re
import warnings
from pathlib import Path
from typing import Any, Callable

import amacrine
import numpy as np
import pytest
from conftest import Frames, kernels
from matplotlib import image

FPS = 50.0


@pytest.mark.parametrize("domain", ["exact", "silicon"])
def test_a_program_is_that_of_exec(
    domain: str, program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    np.save(tmp_path / "light.npy", frames)
    (tmp_path / "snap.scamp").write_text(amacrine.text("programs", "dvs/snap"))
    program(
        "exec", tmp_path / "snap.scamp", "--image", tmp_path / "light.npy", "--fps", FPS,
        "--domain", domain, "--seed", 4, "--frames", len(frames),
        "--dump", tmp_path / "dump", "--events", tmp_path / "e.npy",
    )
    snap = amacrine.Program.from_file("dvs/snap")
    run = snap.run(frames, FPS, domain=domain, seed=4, keep=["A", "R5"])
    assert run.events.tobytes() == np.load(tmp_path / "e.npy").tobytes()
    assert len(run.events) > 100
    for name, values in run.registers.items():
        want = np.load(tmp_path / "dump" / f"{name}.npy")
        assert np.array_equal(values, want), name
    assert run.films["A"].shape == frames.shape
    assert run.films["R5"].dtype == bool
    assert np.array_equal(run.films["A"][-1], run.registers["A"])
    shown = run._repr_html_()
    assert shown.count("<table>") == 2 and f"<td>{len(run.events)}</td>" in shown
    assert "<td>FLAG</td>" in shown and "<td>A</td>" in shown
    # What is drawn is what the command line draws: 0 and 1 of one bit, analogue ones from end to end.
    drawn = _pictures(shown)
    assert set(drawn) == {"events of the busiest 20 ms", *(f"register {one}" for one in run.registers)}
    for name in ("R5", "FLAG"):
        assert drawn[f"register {name}"] == (tmp_path / "dump" / f"{name}.png").read_bytes()
    values = run.registers["A"]
    gray = (values - values.min()) * (255 / (values.max() - values.min()))
    assert np.array_equal(_gray(drawn["register A"]), np.round(gray))
    program(
        "show", tmp_path / "e.npy", "-o", tmp_path / "e.svg", "--view", "frame", "--title", "events"
    )
    svg = (tmp_path / "e.svg").read_text()
    (pixels,) = re.findall(r"data:image/png;base64,([^\"]*)", svg)
    theirs = _pixels(base64.b64decode(pixels))
    ours = _pixels(drawn["events of the busiest 20 ms"])
    # A pixel of the sensor is some pixels of the picture.
    inks = {tuple(one) for one in theirs.reshape(-1, 3).tolist()}
    assert len(inks) > 2 and inks <= {tuple(one) for one in ours.reshape(-1, 3).tolist()}


def _pictures(shown: str) -> dict[str, bytes]:
    """The PNGs of what a notebook shows, by what they are of."""
    found = re.findall(r'<img src="data:image/png;base64,([^"]*)" alt="([^"]*)"/>', shown)
    return {name: base64.b64decode(data) for data, name in found}


def _pixels(png: bytes) -> Any:
    """The pixels of a PNG, (H,W,3)."""
    return np.rint(image.imread(io.BytesIO(png))[..., :3] * 255).astype(int)


def _gray(png: bytes) -> Any:
    found = _pixels(png)
    assert (found == found[..., :1]).all()
    return found[..., 0]


def test_large_registers_are_drawn_small() -> None:
    frames = np.random.default_rng(0).integers(0, 256, (2, 200, 301)).astype(np.uint8)
    run = amacrine.Program.from_file("dvs/snap").run(frames, FPS)
    shown = run._repr_html_()
    drawn = _gray(_pictures(shown)["register A"])
    # Means of 3x3 pixels, those beyond the edge as the edge is.
    assert drawn.shape == (67, 101)
    values = np.pad(run.registers["A"], ((0, 1), (0, 2)), mode="edge")
    means = values.reshape(67, 3, 101, 3).mean((1, 3))
    gray = (means - means.min()) * (255 / (means.max() - means.min()))
    assert np.abs(drawn - gray).max() <= 0.5 + 1e-9
    assert len(shown) < 500_000


def test_what_was_lost_goes_with_the_events(
    program: Callable[..., str], tmp_path: Path
) -> None:
    frames = np.random.default_rng(0).integers(0, 256, (6, 128, 128)).astype(np.uint8)
    np.save(tmp_path / "light.npy", frames)
    program(
        "exec", "dvs/snap", "--image", tmp_path / "light.npy", "--fps", FPS,
        "--events", tmp_path / "e.npz",
    )
    run = amacrine.Program.from_file("dvs/snap").run(frames, FPS)
    want = amacrine.about(tmp_path / "e.npz").dropped
    assert want is not None and run.events.dropped == want and run.lost == want["no_slot"] > 1000
    amacrine.write(tmp_path / "mine.npz", run.events)
    assert amacrine.about(tmp_path / "mine.npz").dropped == want


def test_parts_of_a_stream_know_what_was_lost() -> None:
    frames = np.random.default_rng(0).integers(0, 256, (9, 96, 96)).astype(np.uint8)
    chip = amacrine.compile("sobel-x", 8, to="ternary", readout="slots", effort=0.2)
    with pytest.warns(amacrine.Caution, match="slots"):
        whole = chip.events(frames, FPS)
        stream = chip.stream(FPS)
        parts = [stream.events(frames[n : n + 3]) for n in (0, 3, 6)]
    joined: Any = np.concatenate(parts)
    assert whole.dropped is not None and whole.dropped["no_slot"] > 1000
    assert joined.dropped == whole.dropped and joined.span == whole.span
    assert joined.sensor_size == (96, 96) and joined.tobytes() == whole.tobytes()
    # What lies between is not known of two parts that do not follow one another.
    apart: Any = np.concatenate([parts[0], parts[2]])
    assert apart.span is None and apart.dropped is None and apart.sensor_size == (96, 96)
    assert not isinstance(np.concatenate([parts[0], np.asarray(parts[1])]), type(joined))


@pytest.mark.parametrize(
    "how", [{"without": ["noise", "mismatch"]}, {"without": "transfer", "edge": 40}, {"gain": 0.25}]
)
def test_what_cells_do_without_is_that_of_exec(
    how: dict[str, Any], program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    np.save(tmp_path / "light.npy", frames)
    (tmp_path / "sobel.scamp").write_text(amacrine.text("programs", "convolve/sobel"))
    words = [f"--{name}={one if isinstance(one, (str, int, float)) else ','.join(one)}"
             for name, one in how.items()]
    program(
        "exec", tmp_path / "sobel.scamp", "--image", tmp_path / "light.npy", "--fps", FPS,
        "--domain", "silicon", "--seed", 4, "--frames", len(frames), "--dump", tmp_path, *words,
    )
    sobel = amacrine.Program.from_file("convolve/sobel")
    run = sobel.run(frames, FPS, domain="silicon", seed=4, **how)
    full = sobel.run(frames, FPS, domain="silicon", seed=4)
    parted = False
    for name, values in run.registers.items():
        assert np.array_equal(values, np.load(tmp_path / f"{name}.npy")), name
        parted |= not np.array_equal(values, full.registers[name])
    assert parted
    with pytest.raises(amacrine.Error, match="did you mean `noise`"):
        sobel.run(frames, FPS, domain="silicon", without="nose")
    with pytest.raises(amacrine.Error, match='leave `without` out, or add domain="silicon"'):
        sobel.run(frames, FPS, without="noise")
    with pytest.raises(amacrine.Error, match="edge=1.5"):
        sobel.run(frames, FPS, edge=float("nan"))


def test_what_a_program_costs() -> None:
    snap = amacrine.Program.from_file("dvs/snap")
    assert snap.words > 0 and snap.array_us > 0 and snap.chip == "scamp5"
    wide = amacrine.Program.from_file("dvs/snap", chip="scamp5-wide")
    assert wide.chip == "scamp5-wide"
    assert amacrine.Program.from_text("mov(A, B);").words == 2


def chip(to: str, domain: str, **more: Any) -> tuple[amacrine.Sensor, amacrine.ChipSensor]:
    sensor = amacrine.Sensor(
        kernels(2, 3), 0.3, memory="filtered-snap", border="zero", name="two", seed=2
    )
    return sensor, sensor.on_chip(to, domain=domain, effort=0.05, **more)


def test_a_sensor_on_the_chip_is_its_program(
    program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    sensor, slots = chip("int-5", "exact", readout="slots")
    run = slots.program.run(frames, FPS, domain="exact", clip=True)
    events = slots.events(frames, FPS)
    assert events.tobytes() == run.events.tobytes()
    _, every = chip("int-5", "exact")
    assert every.text == slots.text
    assert run.lost == 0
    # All of them in the order in which the chip gives them.
    assert every.events(frames, FPS).tobytes() == events.tobytes()
    (tmp_path / "s.toml").write_text(sensor.text)
    out = tmp_path / "s.scamp"
    program(
        "compile", "--sensor", tmp_path / "s.toml", "--to", "int-5", "--effort", 0.05,
        "--seed", 2, "-o", out,
    )
    bare = [line for line in out.read_text().splitlines() if not line.startswith("//=")]
    assert "\n".join(bare).strip() == slots.text.strip()


def test_a_program_for_so_many_events(
    program: Callable[..., str], tmp_path: Path, frames: Frames
) -> None:
    """The readout is chosen as on the command line; what is seen of all events stays the same."""
    sensor, usual = chip("int-5", "exact")
    (tmp_path / "s.toml").write_text(sensor.text)
    want = usual.events(frames, FPS)
    for events, readout in ((300, "scamp5_scan_events"), (60_000, "scamp5_scan_dreg")):
        _, own = chip("int-5", "exact", events_per_frame=events)
        out = tmp_path / f"{events}.scamp"
        program(
            "compile", "--sensor", tmp_path / "s.toml", "--to", "int-5", "--effort", 0.05,
            "--seed", 2, "--events-per-frame", events, "-o", out,
        )
        bare = [line for line in out.read_text().splitlines() if not line.startswith("//=")]
        assert "\n".join(bare).strip() == own.text.strip()
        assert readout in own.text
        got = own.events(frames, FPS)
        fields = [name for name in got.dtype.names or ()]
        assert np.array_equal(np.sort(got, order=fields), np.sort(want, order=fields))


def test_a_filter_alone(program: Callable[..., str], tmp_path: Path) -> None:
    """As `compile --filter-only`, and it computes the kernel from what A holds."""
    out = tmp_path / "f.scamp"
    program(
        "compile", "sobel-x", "--filter-only", "--input", "0..127", "--border", "--effort", 0.05, "-o", out
    )
    filter = amacrine.compile_filter("sobel-x", input=(0, 127), border=True, effort=0.05)
    assert filter.text.strip() == out.read_text().strip() and filter.words > 3
    light = np.random.default_rng(3).integers(0, 128, (8, 9)).astype(float)
    run = filter.program.run(np.zeros((1, 8, 9), np.uint8), registers={"A": light})
    (name, scale), = filter.results.items()
    padded = np.pad(light, 1)
    kernel = amacrine.Sensor("sobel-x", 1).kernels[0]
    want = sum(kernel[y, x] * padded[y : y + 8, x : x + 9] for y in range(3) for x in range(3))
    np.testing.assert_array_equal(run.registers[name], want * scale)
    two = amacrine.compile_filter(np.stack([kernel, kernel.T]), to="ternary", effort=0.05)
    assert list(two.results) == ["A", "B"]


@pytest.mark.parametrize("given", [True, 3, np.float16(2.5), np.array(4)])
def test_registers_are_one_number_or_a_plane_of_the_frames(given: Any) -> None:
    still = amacrine.Program.from_text("mov(B, A);")
    planes = [np.full((4, 6), given), np.full((4, 6), given).astype(np.float32)]
    for own in (given, *planes):
        run = still.run(np.zeros((1, 4, 6), np.uint8), 9, registers={"A": own})
        np.testing.assert_array_equal(run.registers["B"], planes[0])


def test_small_light_is_told_of(frames: Frames) -> None:
    snap = amacrine.Program.from_file("dvs/snap")
    with pytest.warns(amacrine.Caution, match="all light lies between 0 and 1, but") as said:
        snap.run(frames / 255, FPS, scale=1)
    assert "give scale=255" in " ".join(str(one.message) for one in said)


def told(what: Callable[[], Any]) -> str:
    """What it warns of."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        what()
    return " ".join(str(one.message) for one in said)


@pytest.mark.parametrize(
    ("domain", "words"),
    [
        ("q8.8", "after the last frame lie at the end of its range, -128 to 127.99609375"),
        ("silicon", "lie at the end of its range"),
        ("exact", "lie beyond the range of a register, -128 to 127"),
        ("f16", "lie beyond the range of a register, -128 to 127"),
        ("q4.12", "at which the photodiodes begin (light.reset)"),
        ("q16.16", "lie beyond the range of a register"),
    ],
)
def test_registers_at_the_end_of_their_range_are_told_of(
    domain: str, words: str, tmp_path: Path
) -> None:
    sums = "get_image(A);\nmov(B, A);\nadd(C, A, B);\nmov(B, C);\nadd(D, C, B);\n"
    (tmp_path / "sums.scamp").write_text(sums)
    program = amacrine.Program.from_file(tmp_path / "sums.scamp")
    light = np.full((2, 6, 8), 40, np.uint8)
    light[:, :, 4:] = 250
    said = told(lambda: program.run(light, FPS, domain=domain))
    if domain == "q16.16":
        assert said == ""
    else:
        assert words in said


def test_what_a_format_does_not_hold_of_a_sensor_is_told_of(frames: Frames) -> None:
    def of(kernel: Any, format: str, response: Any = "identity") -> str:
        sensor = amacrine.Sensor(kernel, 10, response=response, format=format)
        said = [told(lambda: sensor.events(frames, FPS)), told(lambda: sensor.counts(frames, FPS))]
        said.append(told(lambda: sensor.voxels(frames, FPS)))
        assert said[0] == said[1] == said[2]
        return said[0]

    assert "in the signals lie at the end of the range of q8.8" in of([[1.0]], "q8.8")
    white = {"linear": 255}
    assert "of the drives (kernel times signal)" in of([[100.0, 100, 100]], "q8.8", white)
    nothing = of([[0.001]], "q8.8", white)
    assert "in q8.8 its weight is 0" in nothing and "lower the threshold" not in nothing
    for format in ("f64", "f16", "q16.16"):
        for words in ("range of", "range,", "weight"):
            assert words not in of([[100.0, 100, 100]], format, white)


def test_a_domain_that_does_not_hold_a_sensors_program_is_told_of(frames: Frames) -> None:
    sensor = amacrine.Sensor(
        [[[0, -0.25, 0], [-0.25, 1, -0.25], [0, -0.25, 0]]], 10, response="identity",
        memory="filtered-snap", border="zero",
    )

    def of(domain: str) -> str:
        chip = sensor.on_chip("exact", domain=domain, effort=0.1)
        said = told(lambda: chip.events(frames, FPS))
        assert said == told(lambda: chip.voxels(frames, FPS))
        return said

    assert "at which the photodiodes begin (light.reset)" in of("q4.12")
    assert "light.reset" not in of("exact")


def test_without_errors_it_is_the_float_sensor_of_its_levels(frames: Frames) -> None:
    """One decision a frame: the same cells fire in the same frames."""
    _, on_chip = chip("int-5", "exact")
    levels = [levels for levels, _ in on_chip.levels]
    thresholds = [0.3 * 255 / scale for _, scale in on_chip.levels]
    float_ = amacrine.Sensor(
        levels, thresholds, response="identity", memory="filtered-snap", border="zero"
    )
    fired = np.sign(float_.counts(frames, FPS))
    got = on_chip.counts(frames, FPS)
    inner = (slice(None), slice(None), slice(2, -2), slice(2, -2))
    assert got.any() and (got[inner] == fired[inner]).mean() > 0.99


def test_the_same_arrays_in_every_form(frames: Frames) -> None:
    _, on_chip = chip("int-5", "silicon")
    events = on_chip.events(frames, FPS)
    assert events.dtype == amacrine.EVENT_OF_KINDS and len(events) > 100
    counts = on_chip.counts(frames, FPS)
    want = np.zeros_like(counts)
    frame = np.rint(events["t"] * 1e-6 * FPS).astype(int) - 1
    sign = np.where(events["p"] == 1, 1, -1)
    np.add.at(want, (frame, events["channel"], events["y"], events["x"]), sign)
    assert np.array_equal(counts, want)
    voxels = on_chip.voxels(frames, FPS)
    # All events are at the times of frames.
    assert np.allclose(voxels[1:], counts, atol=2e-3) and not voxels[0].any()
    again = on_chip.with_domain("silicon", seed=9).events(frames, FPS)
    assert again.tobytes() != events.tobytes()
    assert on_chip.events(frames, FPS).tobytes() == events.tobytes()
    assert on_chip.words > 10 and on_chip.array_us > 1


def test_what_the_chip_cannot_follow_is_said() -> None:
    with pytest.warns(amacrine.Caution) as said:
        amacrine.Sensor("csdvs-3", 0.1, refractory=500).on_chip("ternary", effort=0.05)
    text = " ".join(str(one.message) for one in said)
    assert "filtered-snap" in text and "replicates the border" in text and "refractory" in text


def test_a_program_that_is_wrong_at_the_border_says_so(frames: Frames) -> None:
    made = np.random.default_rng(0).normal(size=(2, 5, 5))
    made -= made.mean((1, 2), keepdims=True)
    made /= np.abs(made).sum((1, 2), keepdims=True)
    options: dict[str, Any] = {"memory": "filtered-snap", "border": "zero"}
    sensor = amacrine.Sensor(made, 0.03, **options)
    with pytest.warns(amacrine.Caution, match="within 2 pixels of the border events differ"):
        chip = sensor.on_chip("int-5", domain="exact", effort=0.2)
    assert any("border=True" in note for note in chip.notes)
    same = amacrine.Sensor(np.stack([a * b for a, b in chip.levels]), 0.03, **options)
    wrong = same.counts(frames, FPS) != chip.counts(frames, FPS)
    inside = wrong[..., 2:-2, 2:-2]
    assert wrong.sum() > 20 * inside.sum(), (wrong.sum(), inside.sum())
    with pytest.raises(amacrine.Error, match="no program was found that is right within 2 pixels"):
        sensor.on_chip("int-5", border=True, effort=0.2)
    with warnings.catch_warnings():
        warnings.simplefilter("error", amacrine.Caution)
        amacrine.compile("sobel-x", 40, border=True, effort=0.05)


def test_three_kinds_share_a_memory(frames: Frames) -> None:
    three = ["dvs", "sobel-x", "sobel-y"]
    with pytest.raises(amacrine.Error, match="register"):
        amacrine.compile(three, 40, effort=0.05)
    shared = amacrine.compile(three, 40, memory="shared", effort=0.05, domain="exact")
    assert np.unique(shared.events(frames, FPS)["channel"]).tolist() == [0, 1, 2]
    sensor = amacrine.Sensor(
        three, 40, response="identity", memory="raw-snap", shared=True, border="zero"
    )
    assert sensor.on_chip(effort=0.05, domain="exact").words == shared.words
    with pytest.raises(amacrine.Error, match="bits"):
        amacrine.compile("dvs", 40, memory="bits")


def test_compile_is_a_program_of_kernels(frames: Frames) -> None:
    compiled = amacrine.compile("csdvs-3", 16, to="ternary", effort=0.05)
    assert "scamp5_scan_events" in compiled.text
    run = compiled.program.run(frames, FPS)
    assert run.events.dtype == amacrine.EVENT and len(run.events) > 0


def test_compile_takes_sensors(tmp_path: Path) -> None:
    """As the command line's ``--sensor``: with its thresholds and its memory."""
    sensor = amacrine.Sensor.from_file("rgc-4-on-chip")
    want = sensor.on_chip("ternary", effort=0.05)
    (tmp_path / "own.toml").write_text(sensor.text)
    given: Any
    for given in (sensor, "rgc-4-on-chip", tmp_path / "own.toml"):
        assert amacrine.compile(given, to="ternary", effort=0.05).text == want.text
    with pytest.raises(amacrine.Error, match="rgc-4 has thresholds of its own, and thresholds = 3"):
        amacrine.compile("rgc-4", 3)
    with pytest.raises(amacrine.Error, match="a program needs a threshold"):
        amacrine.compile("csdvs-3")


def test_one_name_is_a_list_of_one(frames: Frames) -> None:
    snap = amacrine.Program.from_file("dvs/snap")
    assert list(snap.run(frames, FPS, keep="R5").films) == ["R5"]
    assert amacrine.Sensor("dvs", 1, names="centre").channels == ["centre"]
    with pytest.raises(amacrine.Error, match="`tern` is no quantiser"):
        amacrine.design("dvs", thresholds=9, to="tern")


def test_notes_speak_of_arguments() -> None:
    sensor = amacrine.Sensor("csdvs-3", 0.1, memory="filtered-snap", border="zero")
    with pytest.warns(amacrine.Caution) as said:
        sensor.on_chip("ternary", effort=0.01)
    assert "(another to)" in str(said[0].message) and "--" not in str(said[0].message)
    compiled = functools.partial(amacrine.compile, "csdvs-3", 9)
    for find in (sensor.on_chip, compiled):
        with pytest.warns(amacrine.Caution) as said:
            find(to="ternary", effort=0.01)
        assert {Path(one.filename).name for one in said} == {"test_chip.py"}
    with pytest.warns(amacrine.Caution) as said:
        sensor.events(np.zeros((3, 8, 8), np.uint8), FPS)
    assert "--" not in str(said[0].message)


SPOTS = Path(__file__).parents[2] / "tests" / "data" / "vendor" / "spots.cpp"


def test_a_host_that_decides_runs_beside_the_array() -> None:
    clip = np.zeros((3, 24, 32), np.uint8)
    for t, spots in enumerate((5, 2, 0)):
        for k in range(spots):
            clip[t, 2 + k : 4 + 2 * k, 1 + 6 * k : 4 + 6 * k] = 200
    program = amacrine.Program.from_file(SPOTS)
    assert program.decides and program.words == 0 and "decides" in repr(program)
    run = program.run(clip, keep=["R5", "A"])
    assert run.posts == [
        (0, "frame 0: 5 spots, the tallest of 6 rows\n"),
        (1, "frame 1: 2 spots, the tallest of 6 rows\n"),
        (2, "frame 2: 0 spots, the tallest of 6 rows\n"),
    ]
    assert len(run.events) > 0 and run.events["t"].max() <= 2e6 / 30 + 1
    assert run.films["R5"].shape == (3, 24, 32)
    # R5 is the light above the threshold, and A what is above it.
    np.testing.assert_array_equal(run.films["R5"], clip / 2 > 30)
    np.testing.assert_array_equal(run.films["A"][-1], run.registers["A"])
    # A value for good, and what is refused.
    fixed = amacrine.Program.from_file(SPOTS, constants={"count": 3})
    assert fixed.run(clip).posts[2][1].startswith("frame 2: 3 spots")
    with pytest.raises(amacrine.Error, match="finite light"):
        program.run(np.full((1, 4, 4), np.nan), scale=1.0)
    assert not amacrine.Program.from_file("dvs/snap").decides


def test_a_host_that_ends_shows_fewer_frames(tmp_path: Path) -> None:
    text = (
        "int main() { for (int i = 0; i < 2; i++) { vs_frame_loop_control(); get_image(A, F);\n"
        'if (scamp5_global_or(R5)) mov(B, A); printf("%d", i); } }'
    )
    (tmp_path / "p.cpp").write_text(text)
    ends = amacrine.Program.from_file(tmp_path / "p.cpp")
    run = ends.run(np.zeros((5, 4, 4), np.uint8), 100, keep=["A"])
    assert run.posts == [(0, "0"), (1, "1")] and run.films["A"].shape == (2, 4, 4)
    # As in the file that `amacrine exec --events` writes.
    assert run.events.span == (0.0, 0.01)


@pytest.mark.parametrize(
    "memory, where", [("shared", "by up to 1 pixel further with each frame"), ("analogue", "within 1 pixel")]
)
def test_a_chip_without_zeros_beyond_its_border_is_told_of(
    memory: str, where: str, tmp_path: Path
) -> None:
    edge = '{ value = -3, unit = "LSB", source = "test", evidence = "guess" }'
    head = 'name = "edge"\ntitle = "t"\nextends = "scamp5"\n'
    chip = tmp_path / "edge"
    chip.mkdir()
    (chip / "device.toml").write_text(f"{head}[figure.edge]\nanalogue = {edge}\n")
    with pytest.warns(amacrine.Caution, match=where) as said:
        amacrine.compile("sobel-x", 80, to="ternary", memory=memory, chip=chip, effort=0.02)
    assert any("hold -3 LSB (edge.analogue)" in str(one.message) for one in said)


def test_a_program_of_an_objective(frames: Frames) -> None:
    def compiled(objective: str) -> amacrine.ChipSensor:
        how: Any = {"domain": "exact", "objective": objective, "effort": 0.2}
        return amacrine.compile("csdvs-3", 20.0, to="int-4", **how)

    words = {name: compiled(name).words for name in ("silicon", "exact", "words")}
    # The default lets strong light saturate.
    assert words["words"] <= words["exact"]
    exact = compiled("exact")
    kernel, scale = exact.levels[0]
    same = amacrine.Sensor(
        kernel, 20.0 / scale, response="identity", memory="filtered-snap", border="zero", format="f64"
    )
    assert np.array_equal(exact.counts(frames, FPS), same.counts(frames, FPS))
    with pytest.raises(amacrine.Error, match="`quick` is no objective"):
        compiled("quick")


def test_a_notebook_shows_a_program_and_its_levels() -> None:
    chip = amacrine.compile(["dvs", "sobel-x"], 20, to="ternary", effort=0.1, domain="exact", seed=3)
    shown = chip._repr_html_()
    assert f"<td>scamp5</td><td>{chip.words}</td><td>{chip.array_us:.4g}</td>" in shown
    assert "<td>exact</td><td>3</td><td>all</td>" in shown
    assert "levels of dvs" in shown or "levels of 0" in shown
    assert shown.count("<table>") == 4 and "<details>" in shown
    taps = [int(np.count_nonzero(levels)) for levels, _ in chip.levels]
    for (levels, scale), count in zip(chip.levels, taps):
        side = f"{levels.shape[1]}x{levels.shape[0]}"
        assert f"<td>{side}</td><td>{count}</td><td>{scale:.4g}</td>" in shown

    program = chip.program
    shown = program._repr_html_()
    assert f"<td>scamp5</td><td>{program.words}</td>" in shown
    assert "<details>" in shown and "scamp5_scan_events(" in shown

    filtered = amacrine.compile_filter("sobel-x", effort=0.1)
    shown = filtered._repr_html_()
    register, of = next(iter(filtered.results.items()))
    assert f"<td>{filtered.words}</td>" in shown and f"<td>{register}</td><td>{of:.4g}</td>" in shown


def test_a_notebook_says_of_a_program_in_what_it_differs() -> None:
    sensor = amacrine.Sensor("dvs", 0.2, border="replicate")
    with pytest.warns(amacrine.Caution):
        chip = sensor.on_chip("ternary", effort=0.1)
    shown = chip._repr_html_()
    assert chip.notes and shown.count("<li>") == len(chip.notes)
