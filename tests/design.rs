//! `design` makes a sensor, a program and a report that the other verbs take, and which are the
//! candidate that has run; names and kernels of several kinds go the whole way. Against: the other
//! verbs on what it writes, the definition of a front, numpy's own header.

mod common;

use std::{fs, path::Path};

use amacrine::{
    event::{
        file,
        tensor::{Alignment, Normalise, Sides, Voxels, Windows},
    },
    scene::{OpenOptions, Scene, bundled_with},
};
use common::{amacrine, good, json, line, refused};
use ndarray::Array3;
use ndarray_npy::{ReadNpyExt, WriteNpyExt};

/// The first frames of the bundled clip, a part of them, as `.npy`.
fn clip(folder: &Path) {
    let mut scene = bundled_with(&OpenOptions::default()).unwrap();
    let mut frames = Array3::<f32>::zeros((12, 64, 64));
    for mut out in frames.outer_iter_mut() {
        let frame = scene.next_frame().unwrap().unwrap();
        for ((y, x), value) in out.indexed_iter_mut() {
            *value = frame.light[[y + 96, x + 96]] as f32;
        }
    }
    let file = fs::File::create(folder.join("clip.npy")).unwrap();
    frames.write_npy(file).unwrap();
}

/// A centre and three edges, of other scales each.
fn kernels(folder: &Path) {
    let weight = |(k, y, x): (usize, usize, usize)| {
        let (dy, dx) = (y as f64 - 1.0, x as f64 - 1.0);
        match k {
            0 if y == 1 && x == 1 => 1.0,
            0 => -0.125,
            1 => 3.0 * dx,
            2 => 0.2 * dy,
            _ => 0.5 * (dx - dy),
        }
    };
    let all = Array3::from_shape_fn((4, 3, 3), weight);
    let file = fs::File::create(folder.join("four.npy")).unwrap();
    all.write_npy(file).unwrap();
}

const SHOWN: [&str; 4] = ["--scene", "clip.npy", "--fps", "10"];

#[test]
#[expect(clippy::too_many_lines, reason = "one walk from kernels to a report")]
fn four_kernels_become_a_sensor_a_program_and_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    clip(folder);
    kernels(folder);
    let quick = [
        "--to",
        "ternary,int-3,po2-2",
        "--effort",
        "0.05",
        "--chips",
        "1",
    ];
    let ask = [
        &["design", "four.npy", "--rate", "3"][..],
        &SHOWN,
        &quick,
        &["-o", "out/four"],
    ]
    .concat();
    let said = json(folder, &ask);
    let candidates = said["candidates"].as_array().unwrap();
    assert!(candidates.len() >= 2, "{said}");
    // The front, written out.
    let merits = |it: &serde_json::Value| {
        [
            it["kept"].as_f64().unwrap(),
            -it["words"].as_f64().unwrap(),
            it["frames_s"][0].as_f64().unwrap(),
        ]
    };
    for one in candidates {
        let own = merits(one);
        let beaten = candidates.iter().any(|other| {
            let theirs = merits(other);
            theirs != own && theirs.iter().zip(&own).all(|(theirs, own)| theirs >= own)
        });
        assert_eq!(one["on_front"], !beaten, "{one}");
    }
    let picked = &candidates[said["picked"].as_u64().unwrap() as usize];
    assert_eq!(picked["on_front"], true);
    assert_eq!(said["picked"], said["knee"]);

    // The sensor has the rate, each kind a quarter.
    let sensor = "out/four/sensor.toml";
    let run = ["run", "--sensor", sensor, "--events", "float.npy"];
    let ran = json(folder, &[&run[..], &SHOWN].concat());
    let rate = ran["events_per_pixel_per_second"].as_f64().unwrap();
    assert!((rate / 3.0 - 1.0).abs() < 0.1, "{rate}");
    let rated = said["rated"].as_array().unwrap().iter();
    let mut of_pixel = rated.filter(|rated| rated["memory"] == "pixel");
    assert_eq!(
        of_pixel.next().unwrap()["rate"],
        ran["events_per_pixel_per_second"]
    );

    // The program is the one that has run: of each kind as many events as its row says.
    let program = "out/four/program.scamp";
    let exec = ["exec", program, "--image", "clip.npy", "--fps", "10"];
    let silicon = ["--domain", "silicon", "--events", "silicon.npy"];
    good(folder, &[&exec[..], &silicon].concat());
    let count = |name: &str, kind: usize| {
        let packet = file::read(&folder.join(name)).unwrap().packet;
        let own = packet
            .events
            .iter()
            .filter(|e| usize::from(e.channel) == kind);
        own.count() as f64
    };
    for (kind, row) in picked["kinds"].as_array().unwrap().iter().enumerate() {
        let ratio = count("silicon.npy", kind) / count("float.npy", kind);
        let wanted = row["silicon"]["event_ratio"].as_f64().unwrap();
        assert!((ratio - wanted).abs() < 1e-9, "{kind}: {ratio} {wanted}");
    }
    let asm = json(folder, &["asm", program]);
    assert!(
        asm.to_string().contains(&picked["words"].to_string()),
        "{asm}"
    );
    let page = fs::read_to_string(folder.join("out/four/report.html")).unwrap();
    assert!(page.contains("four.npy[3]"), "the report has every kind");

    // With another memory than the first that fits, the page is of that one, and its command
    // gives it again.
    let one = ["design", "csdvs-3", "--rate", "2", "--memory", "shared"];
    let one = [&one[..], &SHOWN, &quick[2..], &["--to", "ternary"]].concat();
    let row = json(folder, &[&one[..], &["-o", "one"]].concat());
    let page = fs::read_to_string(folder.join("one/report.html")).unwrap();
    assert!(page.contains("one memory of the pixel"), "{page}");
    let begins = page.find("amacrine feasibility ").unwrap();
    let command = page[begins..].split('<').next().unwrap();
    assert!(command.contains(" --memory shared "), "{command}");
    let command: Vec<&str> = command.split(' ').skip(1).collect();
    let answered = json(folder, &command);
    assert_eq!(
        answered["together"]["kinds"][0]["kept"],
        row["candidates"][0]["kinds"][0]["silicon"]["kept"]
    );
    let again = fs::read_to_string(folder.join("report.html")).unwrap();
    // But for the command itself, which says more of what is left out here.
    let answer = |page: &str| {
        let (before, after) = page.split_once("amacrine feasibility ").unwrap();
        format!("{before}{}", after.split_once('<').unwrap().1)
    };
    assert!(answer(&again) == answer(&page), "another page");

    // As a table, with the commands; another row.
    let text = good(
        folder,
        &[
            &["design", "four.npy", "--rate", "3", "--pick", "2"][..],
            &SHOWN,
            &quick[..4],
        ]
        .concat(),
    );
    assert!(text.contains("  2> ") && text.contains("knee"), "{text}");
}

/// What was designed is the same for the other verbs: its report again, to the byte, and programs
/// that remember what its sensor does.
#[test]
fn what_was_designed_is_what_other_verbs_judge() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    clip(folder);
    kernels(folder);
    let design = ["design", "four.npy", "--rate", "3", "--memory", "shared"];
    let quick = ["--to", "ternary", "--effort", "0.05", "--chips", "1"];
    let said = json(
        folder,
        &[&design[..], &SHOWN, &quick, &["-o", "out"]].concat(),
    );
    let page = fs::read_to_string(folder.join("out/report.html")).unwrap();
    let begin = page.find("amacrine feasibility ").unwrap();
    let command = page[begin..].split('<').next().unwrap();
    let words: Vec<&str> = command.split_whitespace().skip(1).collect();
    good(folder, &words);
    let again = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(again == page, "{command}");

    let quick = ["--to", "ternary", "--effort", "0.05"];
    let asked = ["quantise", "out/sensor.toml"];
    let table = json(folder, &[&asked[..], &SHOWN, &quick].concat());
    let judged = &table["together"][0]["on_chip"];
    assert_eq!(judged["memory"], "one memory of the pixel for all kinds");
    let kept = |kinds: &serde_json::Value, at: &str| -> Vec<f64> {
        let kinds = kinds.as_array().unwrap().iter();
        kinds
            .map(|kind| kind[at]["kept"].as_f64().unwrap())
            .collect()
    };
    let picked = &said["candidates"][said["picked"].as_u64().unwrap() as usize];
    assert_eq!(
        kept(&judged["kinds"], "silicon"),
        kept(&picked["kinds"], "silicon")
    );

    // What programs cannot follow of a sensor file is said.
    fs::write(
        folder.join("much.toml"),
        "response = { linear = 255 }\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"sobel-x\"\nthreshold = { on = 0.2, off = 0.2, sigma = 0.02 }\n[noise]\nshot-hz = 5\n",
    )
    .unwrap();
    let quick = [
        "--to", "ternary", "--effort", "0.05", "--scene", "clip.npy", "--fps", "10",
    ];
    let asked = [&["quantise", "much.toml"], &quick[..]].concat();
    let ran = amacrine(folder, &asked).output().unwrap();
    let notes = line(&ran.stderr);
    for words in [
        "its memory is not filtered-snap",
        "mismatch of its thresholds",
        "noise in its cells",
    ] {
        assert!(notes.contains(words), "{notes}");
    }
}

/// Where the float sensor says nothing, nothing is kept and nothing is chosen.
#[test]
fn no_event_is_nothing_to_choose_by() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    clip(folder);
    let silent = [
        "sobel-x",
        "--threshold",
        "2000",
        "--to",
        "ternary",
        "--effort",
        "0.01",
    ];
    refused(
        folder,
        &[&["design"], &silent[..], &SHOWN].concat(),
        &[
            "no event on this scene with a threshold of 2000",
            "lower thresholds",
        ],
    );
    let table = json(folder, &[&["quantise"], &silent[..], &SHOWN].concat());
    let chip = &table["rows"][0]["on_chip"];
    assert!(
        chip["silicon"]["kept"].is_null() && chip["exact"]["kept"].is_null(),
        "{table}"
    );
}

#[test]
fn what_cannot_be_designed_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let quick = [
        "--effort",
        "0.05",
        "--to",
        "ternary",
        "--scene",
        "pattern:bar?width=24&height=24&frames=5",
    ];
    let ask = |more: &[&str], words: &[&str]| {
        refused(
            folder,
            &[&["design", "csdvs-3"][..], &quick, more].concat(),
            words,
        );
    };
    ask(&[], &["a rate of events, or thresholds", "--rate"]);
    ask(
        &["--rate", "1e9"],
        &["4096 times as high", "fires at most once per frame"],
    );
    ask(&["--threshold", "1,2"], &["2 thresholds for 1 kernel"]);
    ask(
        &["--threshold", "1e9"],
        &[
            "csdvs-3: no light gives an event: the threshold is 1000000000.0",
            "give a lower threshold",
        ],
    );
    ask(&["--rate", "2", "--chips", "3"], &["--output <DIR>"]);
    ask(&["--threshold", "8", "--pick", "9"], &["--pick 9", "rows"]);
    ask(
        &["--threshold", "8", "--memory", "bits:1"],
        &["none of these choices gives a program for this chip"],
    );
    assert_eq!(folder.read_dir().unwrap().count(), 0);
    ask(
        &["--rate", "-1"],
        &["-1 events per pixel and second", "above 0"],
    );
    let of = |name: &str, words: &[&str]| {
        let ask = ["design", name, "--rate", "2"];
        refused(folder, &[&ask[..], &quick].concat(), words);
    };
    fs::write(folder.join("text.npy"), "1 2 3\n").unwrap();
    of("text.npy", &["text.npy", "something else", "numpy.save"]);
    let array = |name: &str, shape, number: f64| {
        let file = fs::File::create(folder.join(name)).unwrap();
        Array3::from_elem(shape, number).write_npy(file).unwrap();
    };
    array("nan.npy", (2, 3, 3), f64::NAN);
    of("nan.npy", &["nan.npy, kernel 0", "is NaN", "finite floats"]);
    array("even.npy", (2, 4, 4), 1.0);
    of(
        "even.npy",
        &["even.npy, kernel 0", "4 rows by 4", "numpy.pad"],
    );
    array("zero.npy", (2, 3, 3), 0.0);
    of(
        "zero.npy",
        &["zero.npy[0]: all weights are 0", "no threshold"],
    );
}

/// A file of several kernels is several kinds; their names reach files, voxels and the other verbs.
#[test]
fn kinds_of_one_file_keep_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    clip(folder);
    kernels(folder);
    let sensor = |channel: &str| {
        let text = format!(
            "response = \"identity\"\nmemory = \"filtered-snap\"\n[[channel]]\nkernel = \"four.npy\"\n{channel}"
        );
        fs::write(folder.join("sensor.toml"), text).unwrap();
    };
    let run = ["run", "--sensor", "sensor.toml", "--events", "e.npy"];
    let run = [&run[..], &SHOWN].concat();
    sensor(
        "name = [\"centre on\", \"a,b\", \"é\", \"d\"]\nthreshold = [{ on = 9, off = 9 }, { on = 30, off = 40 }, { on = 2, off = 2 }, { on = 5, off = 5 }]\n",
    );
    let said = good(folder, &run);
    assert!(said.contains("channel 0 centre on:"), "{said}");
    for format in ["npz", "h5", "parquet"] {
        let name = format!("e.{format}");
        good(folder, &["convert", "e.npy", &name]);
        let loaded = file::read(&folder.join(&name)).unwrap();
        assert_eq!(
            loaded.packet.names,
            ["centre on", "a,b", "é", "d"],
            "{format}"
        );
        let straight = file::read(&folder.join("e.npy")).unwrap();
        assert_eq!(loaded.packet.events, straight.packet.events);
    }
    good(folder, &["convert", "e.npy", "one.npy", "--kind", "1"]);
    let one = file::read(&folder.join("one.npy")).unwrap();
    assert_eq!(one.packet.names, ["a,b"]);
    good(
        folder,
        &["voxels", "e.npy", "-o", "v.npz", "--window", "200ms"],
    );
    let mut archive = zip::ZipArchive::new(fs::File::open(folder.join("v.npz")).unwrap()).unwrap();
    let mut kinds = Vec::new();
    std::io::copy(&mut archive.by_name("kinds.npy").unwrap(), &mut kinds).unwrap();
    assert!(
        kinds
            .windows(4)
            .any(|it| it == u32::from('é').to_le_bytes())
    );

    // As a program they keep them, where the array is told of them.
    let two = "response = \"identity\"\nmemory = \"filtered-snap\"\n[[channel]]\nname = \"spot é\"\nkernel = \"csdvs-3\"\nthreshold = { on = 9, off = 9 }\n[[channel]]\nkernel = \"sobel-x\"\nthreshold = { on = 30, off = 30 }\n";
    fs::write(folder.join("two.toml"), two).unwrap();
    let compile = ["compile", "--sensor", "two.toml", "--to", "ternary"];
    let compile = [&compile[..], &["--effort", "0.05", "-o", "two.scamp"]].concat();
    good(folder, &compile);
    let exec = ["exec", "two.scamp", "--image", "clip.npy", "--fps", "10"];
    let exec = [&exec[..], &["--events", "x.npz"]].concat();
    good(folder, &exec);
    let packet = file::read(&folder.join("x.npz")).unwrap().packet;
    assert_eq!(packet.names, ["spot é", "kind 1"]);
    let text = fs::read_to_string(folder.join("two.scamp")).unwrap();
    let text = text.replace(", \"kind 1\"]", "]");
    fs::write(folder.join("two.scamp"), text).unwrap();
    refused(
        folder,
        &exec,
        &["two.scamp: `names` has 1 name", "events of 2 kinds"],
    );

    // One name is numbered, one threshold is for all.
    sensor("name = \"cell\"\nthreshold = { on = 9, off = 9 }\n");
    assert!(good(folder, &run).contains("channel 3 cell 3:"));
    sensor("threshold = [{ on = 9, off = 9 }]\n");
    refused(
        folder,
        &run,
        &["sensor.toml:5:", "1 threshold for 4 kernels"],
    );
    sensor("name = [\"a\"]\nthreshold = { on = 9, off = 9 }\n");
    refused(folder, &run, &["1 name for 4 kernels"]);
}

/// Voxels of a file, block by block, are those of the library; halves are what they round to.
#[test]
fn voxels_of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    clip(folder);
    let run = ["run", "--sensor", "rgc-4", "--events", "e.npy"];
    good(folder, &[&run[..], &SHOWN].concat());
    let packet = file::read(&folder.join("e.npy")).unwrap().packet;
    let made = [
        "voxels", "e.npy", "--window", "300ms", "--every", "100ms", "--bins", "3",
    ];
    let how = [
        "--polarity",
        "split",
        "--normalise",
        "max",
        "--align",
        "centred",
    ];
    let said = json(folder, &[&made[..], &how, &["-o", "v.npy"]].concat());
    let windows = Windows::new(0.3, 0.1, Alignment::Centred).unwrap();
    let mut voxels = Voxels::new(3, windows).unwrap();
    (voxels.sides, voxels.normalise) = (Sides::Split, Normalise::Largest);
    let wanted = voxels.of(&packet).unwrap();
    let read = ndarray::Array6::<f32>::read_npy(fs::File::open(folder.join("v.npy")).unwrap());
    let read = read.unwrap();
    let shape: Vec<u64> = serde_json::from_value(said["shape"].clone()).unwrap();
    assert_eq!(
        read.shape().iter().map(|n| *n as u64).collect::<Vec<_>>(),
        shape
    );
    assert_eq!(shape[1..], [4, 2, 3, 64, 64]);
    assert_eq!(read.into_raw_vec_and_offset().0, wanted);
    good(folder, &[&made[..], &how, &["-o", "v.h5"]].concat());
    good(
        folder,
        &[&made[..], &how, &["-o", "h.npy", "--half"]].concat(),
    );
    let half = fs::metadata(folder.join("h.npy")).unwrap().len();
    assert_eq!(half, 192 + 2 * wanted.len() as u64);
    let said = json(folder, &[&made[..], &["-o", "h.h5", "--half"]].concat());
    assert_eq!(said["dtype"], "float16");
    let bytes = |name: &str| fs::metadata(folder.join(name)).unwrap().len();
    assert!(bytes("h.h5") < bytes("v.h5") && bytes("v.h5") < bytes("v.npy"));
    // What 16 bits do not hold is refused, and nothing is written.
    fs::write(
        folder.join("many.csv"),
        "t,x,y,p\n".to_owned() + &"5,0,0,1\n".repeat(70_000),
    )
    .unwrap();
    let many = [
        "voxels", "many.csv", "--window", "1s", "--bins", "1", "-o", "m.npy",
    ];
    good(folder, &many);
    let half = [&many[..7], &["n.npy", "--half"]].concat();
    refused(folder, &half, &["70000 is beyond 16 bits", "65504"]);
    assert!(!folder.join("n.npy").exists());
    let none = ["voxels", "e.npy", "--window", "0us", "-o", "n.npy"];
    refused(folder, &none, &["the window is 0 s"]);
}

#[test]
fn what_comes_with_the_program_is_shown_and_swept_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (of, all, name) in [
        ("sensor", "sensors", "rgc-4"),
        ("program", "programs", "dvs/snap"),
        ("kernel", "kernels", "csdvs-5"),
        ("study", "studies", "formats"),
        ("readout", "readouts", "arbiter"),
        ("chip", "chips", "scamp5-wide"),
    ] {
        let text = good(folder, &["show", of, name]);
        assert_eq!(text, good(folder, &["list", all, name]), "{of}");
        assert!(text.len() > 50, "{text}");
    }
    refused(
        folder,
        &["show", "sensor", "dvss"],
        &["there is no dvss", "rgc-4"],
    );
    refused(
        folder,
        &["show", "thing", "dvs"],
        &["thing is no kind of thing"],
    );
    refused(folder, &["show", "events.npy"], &["--output"]);
    for more in [&["show", "sensor"][..], &["show", "sensor", "-o", "x.png"]] {
        let list = ["which one is not said", "amacrine list sensors"];
        refused(folder, more, &list);
    }
    let space = json(folder, &["sweep", "formats", "frames=2", "--space"]);
    assert!(space.to_string().contains("q8.8"), "{space}");
    let unknown = refused(
        folder,
        &["sweep", "formatss"],
        &["formatss", "amacrine list studies"],
    );
    assert!(!line(unknown.as_bytes()).contains("panic"));
}

/// An MCAP recording holds what the event file holds (`.ci/interop` asks its own readers).
#[test]
fn a_recording_for_viewers() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    clip(folder);
    let run = ["run", "--sensor", "rgc-4", "--events", "e.npy"];
    good(folder, &[&run[..], &SHOWN].concat());
    let said = json(
        folder,
        &["show", "e.npy", "-o", "e.mcap", "--window", "250ms"],
    );
    assert_eq!(said["frames"], 5);
    let bytes = fs::read(folder.join("e.mcap")).unwrap();
    assert_eq!(bytes[..8], *b"\x89MCAP0\r\n");
    let has = |text: &str| {
        bytes
            .windows(text.len())
            .any(|part| part == text.as_bytes())
    };
    assert!(has("/events/kind2_vertical_edges") && has("/image/kind0_change"));
}

/// What `PyTorch` has is taken as it is; more kernels than a sensor has kinds are refused at once,
/// everywhere with the same words.
#[test]
fn arrays_of_kernels_have_one_shape_and_one_limit() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let write = |name: &str, shape: &[usize]| {
        let all = ndarray::ArrayD::<f64>::from_shape_fn(shape, |at| {
            let last = shape.len() - 1;
            if at[last] == 1 && at[last - 1] == 1 {
                1.0
            } else {
                -0.125
            }
        });
        all.write_npy(fs::File::create(at.join(name)).unwrap())
            .unwrap();
    };
    write("torch.npy", &[2, 1, 3, 3]);
    write("flat.npy", &[2, 3, 3]);
    write("inputs.npy", &[2, 2, 3, 3]);
    write("many.npy", &[17, 3, 3]);
    write("nine.npy", &[9, 3, 3]);
    write("even.npy", &[4, 4]);
    let scene = "pattern:bar?width=24&height=24&frames=5";
    let run = ["run", "--scene", scene, "--sensor", "rgc", "--kernel"];
    let ran = |kernel: &str| json(at, &[&run[..], &[kernel]].concat())["events"].clone();
    assert_eq!(ran("torch.npy"), ran("flat.npy"));
    let text = good(at, &[&run[..], &["flat.npy,csdvs-3"]].concat());
    assert!(text.contains("(3 channels"), "{text}");
    let wrong = "shape (2,2,3,3)";
    let shapes = "(k,k), (K,k,k) or (K,1,k,k)";
    refused(at, &[&run[..], &["inputs.npy"]].concat(), &[wrong, shapes]);
    write("wide.npy", &[2, 0, 3]);
    refused(
        at,
        &[&run[..], &["wide.npy"]].concat(),
        &["shape (2,0,3) has no weights", shapes],
    );
    let limit = "1 to 16 kernels at most";
    refused(at, &[&run[..], &["many.npy"]].concat(), &[limit]);
    refused(at, &[&run[..], &["nine.npy,nine.npy"]].concat(), &[limit]);
    refused(at, &["design", "many.npy", "--rate", "2"], &[limit]);
    let sensor = |kernel: &str| {
        format!(
            "response = {{ linear = 255 }}\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"{kernel}\"\nthreshold = {{ on = 0.2, off = 0.2 }}\n"
        )
    };
    for (kernel, words) in [
        ("many.npy", limit),
        ("inputs.npy", shapes),
        ("even.npy", "numpy.pad"),
    ] {
        fs::write(at.join("s.toml"), sensor(kernel)).unwrap();
        refused(
            at,
            &["run", "--scene", scene, "--sensor", "s.toml"],
            &[words],
        );
    }
    fs::write(at.join("s.toml"), sensor("torch.npy")).unwrap();
    good(at, &["run", "--scene", scene, "--sensor", "s.toml"]);
    refused(
        at,
        &["run", "--scene", scene, "--sensor", "flat.npy"],
        &["--kernel"],
    );
    refused(
        at,
        &["design", "flat.npy", "--rate", "1e6", "--scene", scene],
        &[
            "1000000 events per pixel",
            "are 500000 of each of 2",
            "flat.npy[0]",
        ],
    );
    fs::write(
        at.join("study.toml"),
        format!("scene = \"{scene}\"\nkernel = \"many.npy\"\nthreshold = 20\n[[side]]\nside = \"reference\"\n"),
    )
    .unwrap();
    refused(at, &["sweep", "study.toml"], &[limit]);
}

/// Of what is taken although little of it is kept, and of light on another scale, is warned, once.
#[test]
fn what_keeps_little_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let quick = ["--to", "ternary", "--effort", "0.01"];
    let disc = "pattern:disc?width=48&height=40&frames=8&fps=20";
    let asked = ["design", "csdvs-3", "--threshold", "5", "--scene", disc];
    let said = json(at, &[&asked[..], &quick].concat());
    let taken = &said["candidates"][said["picked"].as_u64().unwrap() as usize];
    assert!(taken["kept"].as_f64().unwrap() < 0.5, "{taken}");
    let all = said["warnings"].as_array().unwrap();
    assert!(all.iter().any(|it| it["about"] == "kept"), "{said}");
    let light = Array3::from_shape_fn((8, 24, 24), |(t, y, x)| {
        (((3 * x + 5 * y + 7 * t) % 17) as f32) / 16.0
    });
    let file = fs::File::create(at.join("one.npy")).unwrap();
    light.write_npy(file).unwrap();
    for verb in ["design", "feasibility"] {
        let asked = [
            verb, "csdvs-3", "--rate", "2", "--scene", "one.npy", "--fps", "20",
        ];
        let more: &[&str] = match verb {
            "design" => &[],
            _ => &["--chips", "1", "--candidates", "ternary"],
        };
        let said = amacrine(at, &[&asked[..], &quick, more].concat()).output();
        let said = line(&said.unwrap().stderr);
        let told = said.matches("all light lies between 0 and 1").count();
        assert_eq!(told, 1, "{said}");
    }
}

/// A row that comes before another by an event or two is warned of, kind by kind where there are several.
#[test]
fn what_few_events_decide_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    clip(at);
    let quick = ["--to", "ternary", "--memory", "shared", "--effort", "0.01"];
    let few = |kernels: &str, threshold: &str| {
        let asked = ["design", kernels, "--threshold", threshold];
        let said = json(at, &[&asked[..], &quick, &SHOWN].concat());
        let all = said["warnings"].as_array().unwrap().iter();
        let mut few = all.filter(|it| it["about"] == "few-events");
        let warned = few.next().cloned();
        assert!(few.next().is_none(), "{said}");
        let rated = &said["rated"][0];
        let events = rated["events"].as_array().unwrap().clone();
        // As many as the rate is of: 12 frames of 64x64 pixels at 10 frames/s.
        for (events, rate) in events.iter().zip(rated["rates"].as_array().unwrap()) {
            let made = rate.as_f64().unwrap() * 64.0 * 64.0 * 1.1;
            assert!((made - events.as_f64().unwrap()).abs() < 1e-6, "{said}");
        }
        (warned, events)
    };
    let (warned, events) = few("sobel-x", "160");
    let warned = warned.unwrap_or_else(|| panic!("of {events:?} events"));
    let seen = format!("the float sensor has only {} events, ", events[0]);
    assert_eq!(warned["subjects"], serde_json::json!(["what is kept"]));
    assert!(
        warned["seen"].as_str().unwrap().starts_with(&seen),
        "{warned}"
    );
    let (warned, events) = few("sobel-x", "60");
    assert!(
        warned.is_none() && events[0].as_u64() > Some(100),
        "{events:?}"
    );
    let (warned, events) = few("sobel-x,sobel-y", "60,100");
    let warned = warned.unwrap_or_else(|| panic!("of {events:?} events"));
    assert_eq!(
        warned["subjects"],
        serde_json::json!(["what is kept of sobel-y"])
    );
}

/// Within a window that covers the clip chance scores as much as any program.
#[test]
fn a_window_that_covers_the_clip_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    clip(at);
    kernels(at);
    let short = ["--scene", "clip.npy", "--fps", "1000", "--to", "ternary"];
    let quantised = json(
        at,
        &[&["quantise", "four.npy", "--threshold", "40"][..], &short].concat(),
    );
    let about = |said: &serde_json::Value| {
        let all = said["warnings"].as_array().unwrap();
        all.iter().any(|warning| warning["about"] == "window")
    };
    assert!(about(&quantised), "{quantised}");
    let quick = ["--effort", "0.05", "--threshold", "40"];
    let arguments = [&["design", "csdvs-3"][..], &short, &quick].concat();
    let designed = json(at, &arguments);
    assert!(about(&designed), "{designed}");
    // What is kept is no number, and nothing is chosen by it.
    let candidate = &designed["candidates"][0];
    let silicon = &candidate["kinds"][0]["silicon"];
    assert_eq!(silicon["floor"], 1.0);
    assert!(silicon["f1"].as_f64().unwrap() < 1.0, "{silicon}");
    assert!(
        candidate["kept"].is_null() && candidate["least_kept"].is_null(),
        "{candidate}"
    );
    assert!(designed["knee"].is_null(), "{designed}");
    fs::write(
        at.join("study.toml"),
        "scene = \"clip.npy\"\nfps = 1000\nkernel = \"csdvs-3\"\nthreshold = 20\n[[side]]\nside = \"reference\"\nformat = \"q8.8\"\n",
    )
    .unwrap();
    let swept = json(at, &["sweep", "study.toml", "-o", "out"]);
    assert!(about(&swept), "{swept}");
    let report = json(at, &["report", "out"]);
    assert!(about(&report), "{report}");
    let row = fs::read_to_string(at.join("out/results.jsonl")).unwrap();
    assert!(row.contains("window\""), "{row}");
}

/// A kind without an event has nothing to keep: what is kept is the mean of the others, and says so; a
/// kernel of zeros has no threshold that could help.
#[test]
fn a_silent_kind_is_no_part_of_what_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    clip(folder);
    let asked = [
        "design",
        "sobel-x,laplacian",
        "--threshold",
        "60,1500",
        "--to",
        "ternary",
    ];
    let more = ["--memory", "shared", "--effort", "0.01"];
    let asked = [&asked[..], &more, &SHOWN].concat();
    let ran = amacrine(folder, &asked).output().unwrap();
    let said = String::from_utf8(ran.stdout).unwrap();
    assert!(said.contains("mean over 1 of 2 kinds"), "{said}");
    let warned = line(&ran.stderr);
    assert!(
        warned.contains("the float sensor, laplacian: no event at all in 12 frames"),
        "{warned}"
    );
    let told = json(folder, &[&asked[..], &["--json"]].concat());
    assert_eq!(told["candidates"][0]["kept_kinds"], 1);
    fs::write(folder.join("zero.toml"), "weights = [[0]]").unwrap();
    let zero = ["design", "sobel-x,zero.toml", "--threshold", "60"];
    for verb in ["design", "feasibility", "waterfall"] {
        let asked = [&[verb], &zero[1..], &SHOWN].concat();
        refused(
            folder,
            &asked,
            &["zero.toml: all weights are 0", "no threshold makes events"],
        );
    }
}

/// The commands that are printed show what was judged: all frames of a pattern without a length of its
/// own, on the chip of the seed, whatever the folder is called.
#[test]
fn the_commands_run_what_was_judged() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let ask = [
        "design",
        "csdvs-3",
        "--threshold",
        "25",
        "--to",
        "int-5",
        "--memory",
        "analogue",
        "--seed",
        "5",
        "--effort",
        "0.02",
        "--chips",
        "1",
        "--scene",
        "pattern:noise?width=16&height=12",
    ];
    let said = json(folder, &[&ask[..], &["-o", "out"]].concat());
    let picked = &said["candidates"][said["picked"].as_u64().unwrap() as usize];
    let ratio = picked["kinds"][0]["silicon"]["event_ratio"]
        .as_f64()
        .unwrap();
    let told = good(folder, &[&ask[..], &["-o", "cafe\u{301}"]].concat());
    let run = |verb: &str| {
        let start = told.find(&format!("amacrine {verb} ")).unwrap();
        let command = told[start..].lines().next().unwrap();
        let words = command.split_whitespace().skip(1);
        let words: Vec<&str> = words.map(|word| word.trim_matches('\'')).collect();
        json(folder, &words)["events"].as_u64().unwrap() as f64
    };
    let (float, chip) = (run("run"), run("exec"));
    assert!(
        (chip / float - ratio).abs() < 1e-9,
        "{chip} {float} {ratio}: {told}"
    );
    good(
        folder,
        &[
            "quantise",
            "csdvs-3",
            "--to",
            "ternary",
            "-o",
            "cafe\u{301}.toml",
        ],
    );
    good(folder, &["quantise", "cafe\u{301}.toml", "--to", "ternary"]);
}

/// The readout of a program that is written loses nothing on other chips of the model either.
#[test]
fn a_readout_serves_several_chips() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let noise = "pattern:noise?width=48&height=40&frames=12";
    for threshold in ["10", "15"] {
        let design = [
            "design",
            "csdvs-3",
            "--threshold",
            threshold,
            "--scene",
            noise,
        ];
        let quick = ["--to", "ternary", "--effort", "0.02", "-o", threshold];
        let said = json(at, &[&design[..], &quick].concat());
        let picked = &said["candidates"][said["picked"].as_u64().unwrap() as usize];
        assert_eq!(picked["readout"], "busiest_frame", "slots are told apart");
        let program = format!("{threshold}/program.scamp");
        for seed in ["0", "1", "2", "3"] {
            let exec = ["exec", &program, "--image", noise, "--domain", "silicon"];
            let said = json(at, &[&exec[..], &["--seed", seed]].concat());
            assert_eq!(said["dropped"]["no_slot"], 0, "{threshold}, chip {seed}");
        }
    }
}

/// The kinds of a sensor may stand in a list as well as under their heads.
#[test]
fn a_sensor_whose_kinds_are_a_list_is_one() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("s.toml"),
        "response = \"identity\"\nmemory = \"filtered-snap\"\nborder = \"zero\"\nchannel = [{ kernel = [[-1.0, 1.0, 0.0]], threshold = { on = 25.0, off = 25.0 } }]\n",
    )
    .unwrap();
    let said = json(folder.path(), &["quantise", "s.toml", "--to", "ternary"]);
    assert_eq!(
        said["quantised"][0]["levels"],
        serde_json::json!([[-1.0, 1.0, 0.0]])
    );
}
