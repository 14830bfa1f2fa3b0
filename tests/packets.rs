//! The verbs `packets` and `show`, and `run --readout`, from outside: what they count is what
//! the definitions say, what is lost travels in the file, bad input gets one message.
#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use amacrine::{
    event::{
        file,
        readout::{Readout, settings::Description},
    },
    isa::{Device, HostKind},
};
use common::{amacrine, good, json, refused_untouched};
use serde_json::Value;
use tempfile::TempDir;

/// Eight rows of four kinds: three events of kind 0 in row 5 at once, one of kind 3 and one of
/// kind 1 later.
const EVENTS: &str = "# amacrine size=16x8 channels=4 span=0..20000 dropped=0,0
t,x,y,p,channel
1000,3,5,1,0
1000,4,5,1,0
1000,9,5,0,0
1500,9,5,0,3
12000,0,0,1,1
";

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("e.csv"), EVENTS).unwrap();
    folder
}

#[track_caller]
fn refused(arguments: &[&str], words: &[&str]) {
    refused_untouched(folder().path(), arguments, words);
}

/// Every picture of pixels, not charts alone; an SVG has all letters.
#[test]
fn letters_that_pixels_do_not_have_are_warned_of() {
    let folder = folder();
    let at = folder.path();
    let program = "//! title = \"眼\"\nmov(B, A);\n";
    fs::write(at.join("p.scamp"), program).unwrap();
    let show = ["show", "e.csv", "--title", "眼", "-o"];
    let exec = ["exec", "p.scamp", "--strip", "strip.png"];
    let mesh = ["mesh", "show", "--kernel", "眼.toml", "-o", "mesh.png"];
    let kernel = "name = \"a\"\nsource = \"b\"\nweights = [[0, 1, 0], [1, -4, 1], [0, 1, 0]]\n";
    fs::write(at.join("眼.toml"), kernel).unwrap();
    let all = [
        ([&show[..], &["a.png"]].concat(), "a.png"),
        ([&show[..], &["a.gif"]].concat(), "a.gif"),
        (
            [&show[..], &["k.apng", "--view", "kinds"]].concat(),
            "k.apng",
        ),
        (exec.to_vec(), "strip.png"),
        (mesh.to_vec(), "mesh.png"),
    ];
    let said = |arguments: &[&str]| {
        let output = amacrine(at, arguments).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{arguments:?}: {said}");
        said
    };
    for (arguments, file) in all {
        let warning = format!("warning: {file}: `眼` is drawn as ?");
        let said = said(&arguments);
        assert!(said.contains(&warning), "{arguments:?}: {said}");
    }
    assert_eq!(said(&[&show[..], &["a.svg"]].concat()), "");
    assert_eq!(said(&["show", "e.csv", "-o", "b.gif"]), "");
}

#[test]
fn sizes_and_rates_are_the_definitions() {
    let folder = folder();
    let seen = json(folder.path(), &["packets", "e.csv", "--window", "10ms"]);
    assert_eq!(
        (seen["events"].as_u64(), seen["seconds"].as_f64()),
        (Some(5), Some(0.02))
    );
    let rates: Vec<(&str, u64)> = seen["codings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| {
            (
                c["coding"].as_str().unwrap(),
                c["rate"]["bits"].as_u64().unwrap(),
            )
        })
        .collect();
    // y 3, x 4, kind 2, sign 1. Bursts: three rows of 1 + 3, five times 1 + 4 + 2 + 1.
    // Kinds 3, 1, 0, 1 of 5: words of 1, 2, none, 2 bits.
    assert_eq!(
        rates,
        [
            ("fixed words", 50),
            ("bursts of a row", 12 + 40),
            ("Huffman kinds", 40 + 7),
            ("bursts, Huffman kinds", 12 + 30 + 7),
        ]
    );
    let fixed = &seen["codings"][0]["rate"];
    assert_eq!(fixed["mean_bits_per_s"].as_f64(), Some(2500.0));
    // Four of ten bits within 10 ms.
    assert_eq!(fixed["peak_bits_per_s"].as_f64(), Some(4000.0));
    assert_eq!(fixed["peak_from_us"].as_u64(), Some(1000));
    // Two bits for each of 8 x 16 x 4 cells, over ten.
    assert_eq!(seen["bit_map_bits"].as_u64(), Some(1024));
    assert_eq!(fixed["crossover_events_per_window"].as_f64(), Some(102.4));
    let words: Vec<_> = seen["kinds"]
        .as_array()
        .unwrap()
        .iter()
        .map(|k| k["word"].as_str())
        .collect();
    assert_eq!(words, [Some("0"), Some("10"), None, Some("11")]);
    let entropy = 0.6 * (5.0_f64 / 3.0).log2() + 0.4 * 5.0_f64.log2();
    assert!((seen["entropy_bits"].as_f64().unwrap() - entropy).abs() < 1e-12);
    assert_eq!(seen["mean_word_bits"].as_f64(), Some(1.4));
    assert!(seen["readout"].is_null());

    let table = good(folder.path(), &["packets", "e.csv"]);
    for line in [
        "fixed words",
        "bit map",
        "entropy 1.371 bits a kind, mean word 1.400 bits",
    ] {
        assert!(table.contains(line), "{table}");
    }
}

#[test]
fn given_frequencies_make_the_book() {
    let folder = folder();
    let with = ["packets", "e.csv", "--frequencies", "1,1,1,1"];
    let seen = json(folder.path(), &with);
    assert_eq!(seen["codings"][2]["rate"]["bits"].as_u64(), Some(50));
    refused(
        &["packets", "e.csv", "--frequencies", "1,1"],
        &[
            "--frequencies has 2 numbers",
            "4 kinds",
            "one number for each kind",
        ],
    );
    refused(
        &["packets", "e.csv", "--frequencies", "1,1,1,0"],
        &["event 3", "no word for channel 3", "not 0"],
    );
}

/// Events that go to the file pair by pair make the file that the whole packet makes, to the byte,
/// in every format: `ideal` changes nothing, and wants the packet.
#[test]
fn a_file_does_not_know_how_its_events_came() {
    let folder = TempDir::new().unwrap();
    for (sensor, more) in [("dvs", &[][..]), ("rgc-4", &["--upsample", "0.5"])] {
        for format in file::Format::ALL.iter().filter(|f| f.is_built()) {
            if sensor == "rgc-4" && !format.limits().channels {
                continue;
            }
            // An ending that says this format alone.
            let ending = format.name().replace('.', "");
            let names = ["whole", "streamed"].map(|name| format!("{name}.{ending}"));
            let readouts: [&[&str]; 2] = [&["--readout", "ideal"], &[]];
            for (name, readout) in names.iter().zip(readouts) {
                let scene = "pattern:bar?width=48&height=40&frames=40&fps=100";
                let sensor = sensor_file(sensor);
                let run = [
                    "run", "--scene", scene, "--sensor", &sensor, "--events", name,
                ];
                good(folder.path(), &[&run[..], more, readout].concat());
            }
            let bytes = names.map(|name| fs::read(folder.path().join(name)).unwrap());
            // Some formats pack ten thousand events that tightly.
            assert!(bytes[0].len() > 2_000, "{format}");
            assert!(bytes[0] == bytes[1], "{format}");
        }
    }
}

fn sensor_file(name: &str) -> String {
    format!("{}/sensors/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn what_a_readout_drops_travels_in_the_file() {
    let folder = folder();
    // One event may be sent, none may wait: the two others of the burst are lost.
    let with = [
        "packets",
        "e.csv",
        "--readout",
        "arbiter",
        "--with",
        "fifo=0",
        "--with",
        "when-full=drop-newest",
        "--with",
        "link=1ms",
        "-o",
        "out.npy",
    ];
    let seen = json(folder.path(), &with);
    let dropped = &seen["readout"]["statistics"]["dropped"];
    // At 1000 three fire, one is sent until 2000; at 1500 the fourth finds no room either.
    assert_eq!(dropped["queue_full"].as_u64(), Some(3));
    assert_eq!(seen["dropped"]["queue_full"].as_u64(), Some(3));
    assert_eq!(seen["events"].as_u64(), Some(2));
    assert_eq!(
        seen["readout"]["settings"]["settings"]["fifo"]["source"],
        "set by hand"
    );
    let packet = file::read(&folder.path().join("out.npy")).unwrap().packet;
    assert_eq!((packet.events.len(), packet.dropped.queue_full), (2, 3));
    // 36 ns to choose the row, 36 ns to read column 3, 1 ms to send it.
    assert_eq!((packet.events[0].t.0, packet.events[0].x), (2000, 3));
    let latency = &seen["readout"]["statistics"]["latency"]["max_ps"];
    assert_eq!(latency.as_u64(), Some(1_000_072_000));
    let table = good(folder.path(), &with);
    assert!(table.contains("lost     3 (60.00 %) queue full"), "{table}");
    let again = good(folder.path(), &["packets", "out.npy"]);
    assert!(again.contains("dropped  3 queue full"), "{again}");
}

#[test]
fn run_offers_the_same_readout() {
    let folder = TempDir::new().unwrap();
    let sensor = Path::new(env!("CARGO_MANIFEST_DIR")).join("sensors/dvs.toml");
    let sensor = sensor.to_str().unwrap();
    let scene = "pattern:disc?width=24&height=20&frames=6&radius=6";
    let run = ["run", "--scene", scene, "--sensor", sensor, "--events"];
    good(folder.path(), &[&run[..], &["plain.npy"]].concat());
    let slow = ["--readout", "arbiter", "--with", "link=5us"];
    let seen = json(folder.path(), &[&run[..], &["read.npy"], &slow].concat());
    good(
        folder.path(),
        &[&["packets", "plain.npy", "-o", "again.npy"][..], &slow].concat(),
    );
    let read = |name| file::read(&folder.path().join(name)).unwrap().packet;
    assert_eq!(read("read.npy"), read("again.npy"));
    assert_ne!(read("read.npy"), read("plain.npy"));
    assert!(
        seen["readout"]["statistics"]["latency"]["mean_s"]
            .as_f64()
            .unwrap()
            > 0.0
    );
    // What is lost is told as in every verb: all of it, by reason.
    let full = [
        &slow[..],
        &["--with", "fifo=0", "--with", "when-full=drop-newest"],
    ];
    let seen = json(
        folder.path(),
        &[&run[..], &["few.npy"], &full.concat()].concat(),
    );
    let lost = read("few.npy").dropped;
    assert!(lost.queue_full > 0);
    assert_eq!(seen["dropped"], serde_json::to_value(lost).unwrap());
    let alone = amacrine(
        folder.path(),
        &[
            "run",
            "--scene",
            scene,
            "--sensor",
            sensor,
            "--readout",
            "ideal",
        ],
    )
    .output()
    .unwrap();
    assert_eq!(alone.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&alone.stderr).contains("--readout needs --events"));
}

#[test]
fn a_readout_of_ones_own() {
    let folder = folder();
    let file = "readout = \"frame\"\n[settings]\nperiod = { value = \"10ms\", source = \"mine\", evidence = \"guess\" }\nbit = { value = \"0ns\", source = \"mine\", evidence = \"guess\" }\n";
    fs::write(folder.path().join("my.toml"), file).unwrap();
    let seen = json(
        folder.path(),
        &["packets", "e.csv", "--readout", "my.toml", "-o", "f.csv"],
    );
    assert_eq!(seen["readout"]["statistics"]["readout"], "frame");
    let text = fs::read_to_string(folder.path().join("f.csv")).unwrap();
    let times: Vec<_> = text
        .lines()
        .skip(1)
        .map(|l| l.split(',').next().unwrap())
        .collect();
    assert_eq!(times, ["10000", "10000", "10000", "10000", "20000"]);
}

#[test]
fn bad_input_gets_one_message() {
    let packets =
        |more: &[&str], words: &[&str]| refused(&[&["packets", "e.csv"], more].concat(), words);
    packets(
        &["--readout", "x"],
        &["no readout `x`", "ideal, scan, arbiter, frame"],
    );
    packets(&["--readout", "no.toml"], &["cannot read no.toml"]);
    packets(
        &["--readout", "scan", "--with", "fifo=1"],
        &["scan has no setting `fifo`", "slots"],
    );
    packets(
        &["--readout", "scan", "--with", "slots=4001"],
        &["scan: `slots` cannot be `4001`", "1 to 4000"],
    );
    packets(
        &["--readout", "scan", "--with", "slots"],
        &["`slots` is not KEY=VALUE"],
    );
    packets(&["--with", "slots=3"], &["--readout"]);
    packets(&["-o", "x.npy"], &["--readout"]);
    packets(&["--readout", "ideal", "-o", "x.zzz"], &["zzz"]);
    packets(&["--window", "0us"], &["--window 0"]);
    refused(&["packets", "none.csv"], &["none.csv"]);

    let show = |more: &[&str], words: &[&str]| refused(&[&["show", "e.csv"], more].concat(), words);
    show(
        &["-o", "x.jpg"],
        &["x.jpg ends in `.jpg`", ".png, .svg, .gif, .apng or .mcap"],
    );
    show(
        &["-o", "x.apng", "--view", "rate"],
        &["this view shows all of the packet at once", ".png or .svg"],
    );
    show(
        &["-o", "x.gif", "--view", "surface"],
        &["a GIF has too few colours", ".apng"],
    );
    show(
        &["-o", "x.png", "--size", "16"],
        &["width x height in pixels"],
    );
    show(
        &["-o", "x.png", "--size", "0x8"],
        &["width x height in pixels"],
    );
    show(
        &["-o", "x.gif", "--window", "1us"],
        &["20000 frames", "at most 2000"],
    );
    show(
        &["-o", "x.png", "--from", "2s"],
        &["nothing is in between", "0 us to 20000 us"],
    );
    for at in ["2s", "21ms"] {
        show(
            &["-o", "x.png", "--view", "frame", "--at", at],
            &["--at", "watched from 0 us to 20000 us"],
        );
    }
    show(&["-o", "e.csv/x.png"], &["cannot write e.csv/x.png"]);
    show(&[], &["--output"]);
}

/// From the file, else from the command line, else the smallest that holds the events.
#[test]
fn sizes_are_asked_for_in_order() {
    let folder = folder();
    let bare = "t,x,y,p\n1000,3,5,1\n2000,9,2,0\n";
    fs::write(folder.path().join("bare.csv"), bare).unwrap();
    let size = |arguments: &[&str]| {
        let seen = json(folder.path(), arguments);
        (
            seen["width"].as_u64(),
            seen["height"].as_u64(),
            seen["size_known"].as_bool(),
        )
    };
    for verb in [
        &["packets", "bare.csv"][..],
        &["show", "bare.csv", "-o", "x.svg"],
    ] {
        let given = [verb, &["--size", "346x260"]].concat();
        let stated: Vec<&str> = given
            .iter()
            .map(|a| if *a == "bare.csv" { "e.csv" } else { a })
            .collect();
        assert_eq!(size(verb), (Some(10), Some(6), Some(false)), "{verb:?}");
        assert_eq!(size(&given), (Some(346), Some(260), Some(true)), "{verb:?}");
        // What the file says is not contradicted, by a larger size either.
        common::refused_untouched(
            folder.path(),
            &stated,
            &["e.csv: the file states the sensor size 16x8, but 346x260 was given"],
        );
        let same = [&stated[..stated.len() - 1], &["16x8"]].concat();
        assert_eq!(size(&same), (Some(16), Some(8), Some(true)), "{verb:?}");
        let said = good(folder.path(), verb);
        assert!(said.contains("give --size WxH"), "{said}");
    }
    let compared = json(
        folder.path(),
        &["compare", "bare.csv", "bare.csv", "--size", "40x30"],
    );
    assert_eq!(compared["reference"]["width"], 40);
    refused_untouched(
        folder.path(),
        &["packets", "bare.csv", "--size", "9x9"],
        &["bare.csv", "x"],
    );
}

#[test]
fn surfaces_and_kinds_move_too() {
    let folder = folder();
    for view in ["surface", "kinds", "frame"] {
        let name = format!("{view}.apng");
        let said = json(
            folder.path(),
            &[
                "show", "e.csv", "-o", &name, "--view", view, "--window", "5ms",
            ],
        );
        assert_eq!(said["frames"].as_u64(), Some(4));
        let file = fs::File::open(folder.path().join(&name)).unwrap();
        let decoder = image::codecs::png::PngDecoder::new(std::io::BufReader::new(file)).unwrap();
        let frames = image::AnimationDecoder::into_frames(decoder.apng().unwrap());
        let frames: Vec<_> = frames.map(|f| f.unwrap().into_buffer()).collect();
        assert_eq!(frames.len(), 4, "{view}");
        assert!(frames[0] != frames[1], "{view}: nothing moves");
    }
}

#[test]
fn pictures_are_of_what_was_asked_for() {
    let folder = folder();
    let size = |name: &str| {
        image::open(folder.path().join(name))
            .unwrap()
            .into_rgb8()
            .dimensions()
    };
    let show = |more: &[&str]| good(folder.path(), &[&["show", "e.csv", "-o"], more].concat());
    assert_eq!(show(&["a.png"]), "wrote    a.png: 5 events\n");
    assert_eq!(
        show(&["b.png", "--view", "frame", "--to", "1ms"]),
        "wrote    b.png: 3 events\n"
    );
    assert!(size("a.png") > size("b.png"));
    assert_eq!(
        show(&["c.gif", "--window", "1ms"]),
        "wrote    c.gif: 5 events in 20 frames\n"
    );
    // An animation has 2000 frames at most.
    if cfg!(feature = "mcap") {
        assert_eq!(
            show(&["c.mcap", "--window", "5us"]),
            "wrote    c.mcap: 5 events in 4000 frames\n"
        );
    }
    assert_eq!(
        show(&["d.apng", "--from", "1ms"]),
        "wrote    d.apng: 2 events in 1 frame\n"
    );
    let mistaken = |more: &[&str], words: &[&str]| {
        refused_untouched(
            folder.path(),
            &[&["show", "e.csv", "-o"], more].concat(),
            words,
        );
    };
    mistaken(
        &["f.gif", "--hold", "4ms"],
        &["hundredths of a second", "--hold 10ms"],
    );
    mistaken(
        &["f.mcap", "--view", "cloud"],
        &["no other view", "leave --view out"],
    );
    let never = ["packets", "e.csv", "--frequencies", "0,0,0,0"];
    refused_untouched(
        folder.path(),
        &never,
        &["never comes", "leave --frequencies out"],
    );
    let said = show(&["e.svg", "--title", "a title", "--json"]);
    let said: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(
        (said["events"].as_u64(), said["frames"].as_u64()),
        (Some(5), None)
    );
    let text = fs::read_to_string(folder.path().join("e.svg")).unwrap();
    assert!(text.contains(">a title</text>") && text.contains(">kind 3</text>"));
}

/// The slot's time is stated once for programs, in `isa/`, and once for packets, in `readouts/`.
#[test]
fn the_scan_has_the_slots_of_the_chip() {
    let device = Device::find("scamp5").unwrap();
    let slot = device.host(HostKind::ScanEvents).item.as_ref().unwrap();
    assert_eq!(slot.unit, "us");
    let Readout::Scan(scan) = Description::shipped("scan").unwrap().readout().unwrap() else {
        panic!("not a scan");
    };
    assert_eq!(scan.slot.seconds(), slot.value * 1e-6);
}

/// What `docs/packets.md` shows of the bundled clip is what the commands above it print.
#[test]
fn the_table_of_the_documentation_is_printed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let doc = fs::read_to_string(root.join("docs/packets.md")).unwrap();
    let block = doc
        .split("```console\n")
        .nth(1)
        .unwrap()
        .split("```")
        .next()
        .unwrap();
    let commands: Vec<_> = block
        .lines()
        .filter_map(|l| l.strip_prefix("$ amacrine "))
        .collect();
    let folder = TempDir::new().unwrap();
    fs::create_dir(folder.path().join("out")).unwrap();
    let mut printed = String::new();
    for command in &commands {
        let arguments: Vec<_> = command
            .split(' ')
            .map(|word| {
                if word.starts_with("clips/") || word.starts_with("sensors/") {
                    root.join(word).to_str().unwrap().to_owned()
                } else {
                    word.to_owned()
                }
            })
            .collect();
        let arguments: Vec<_> = arguments.iter().map(String::as_str).collect();
        printed = good(folder.path(), &arguments);
    }
    assert_eq!(commands.len(), 2);
    let shown: Vec<_> = block.lines().filter(|l| !l.starts_with("$ ")).collect();
    let printed: Vec<_> = printed.lines().map(str::trim_end).collect();
    assert_eq!(printed, shown);
}

#[test]
fn what_a_file_cannot_say_of_its_losses_is_not_known() {
    let folder = folder();
    let here = folder.path();
    let lossy = [
        "packets",
        "e.csv",
        "--readout",
        "arbiter",
        "--with",
        "fifo=0",
        "--with",
        "when-full=drop-newest",
        "--with",
        "link=1ms",
        "-o",
    ];
    let to = |name| [&lossy[..], &[name]].concat();
    let warned = amacrine(here, &to("out.npy")).output().unwrap();
    let warned = String::from_utf8(warned.stderr).unwrap();
    assert!(
        warned.starts_with("warning: the readout: the readout's queue was full: 3 of 5 events")
            && warned.lines().count() == 2,
        "{warned}"
    );
    let said = amacrine(here, &to("out.csv")).output().unwrap();
    let said = String::from_utf8(said.stderr).unwrap();
    assert!(said.contains("out.csv: 3 events lost on the way"), "{said}");
    let said = good(here, &["convert", "out.npy", "again.csv"]);
    assert!(said.contains("csv has no room to say so"), "{said}");
    let table = good(
        here,
        &["compare", "out.npy", "again.csv", "--within", "1ms"],
    );
    let line = table.lines().find(|line| line.starts_with("dropped"));
    let words: Vec<_> = line.unwrap().split_whitespace().collect();
    assert_eq!(words, ["dropped", "3", "not", "known"]);
    let seen = json(
        here,
        &["compare", "out.npy", "again.csv", "--within", "1ms"],
    );
    assert_eq!(seen["judged"]["dropped_known"], false);
    assert_eq!(seen["reference"]["dropped_known"], true);
    assert_eq!(seen["dropped"], serde_json::json!([3, null]));
    for (file, known, lost) in [
        ("out.npy", true, Value::from(3)),
        ("again.csv", false, Value::Null),
    ] {
        let seen = json(here, &["packets", file]);
        assert_eq!(seen["dropped_known"], known, "{file}");
        assert_eq!(seen["dropped"]["queue_full"], lost, "{file}");
        assert_eq!(seen["dropped"].as_object().unwrap().len(), 5, "{file}");
    }
}

fn about(told: &Value) -> Vec<&str> {
    let all = told["warnings"].as_array().unwrap().iter();
    all.map(|it| it["about"].as_str().unwrap()).collect()
}

const MOVING: [&str; 6] = [
    "run",
    "--scene",
    "pattern:disc?width=24&height=20&frames=6&radius=6",
    "--sensor",
    "rgc-4",
    "-o",
];

/// What a queue loses is warned of by `run` and by `packets`, and each advice ends it.
#[test]
fn a_full_queue_is_warned_of_until_the_advice_is_taken() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    good(here, &[&MOVING[..], &["fired.npy"]].concat());
    let lossy = ["fifo=1", "link=15us", "when-full=drop-newest"];
    let with = |changed: &[&'static str]| {
        let key = |of: &str| of.split('=').next().unwrap().to_owned();
        let kept = lossy
            .iter()
            .filter(|it| changed.iter().all(|new| key(new) != key(it)));
        let all = kept.chain(changed).flat_map(|it| ["--with", it]);
        ["--readout", "arbiter"]
            .into_iter()
            .chain(all)
            .collect::<Vec<_>>()
    };
    let run = |changed: &[&'static str]| {
        let all = [&MOVING[..], &["read.npy"], &with(changed)].concat();
        let said = amacrine(here, &all).output().unwrap();
        assert!(said.status.success());
        (json(here, &all), String::from_utf8(said.stderr).unwrap())
    };
    let read = ["packets", "fired.npy", "-o", "again.npy"];
    let (told, text) = run(&[]);
    let (lost, kept) = (&told["dropped"]["queue_full"], &told["arrived"]);
    let (lost, kept) = (lost.as_u64().unwrap(), kept.as_u64().unwrap());
    assert!(lost > 100, "{told}");
    let full = format!("queue was full: {lost} of {} events", lost + kept);
    assert!(
        about(&told).contains(&"queue") && text.contains(&full),
        "{text}"
    );
    let later = [&read[..], &with(&[])].concat();
    let of_packets = json(here, &later);
    let of_run = told["warnings"].as_array().unwrap();
    let queue: Vec<_> = of_run.iter().filter(|it| it["about"] == "queue").collect();
    assert_eq!(of_packets["warnings"], serde_json::json!(queue));
    let said = amacrine(here, &later).output().unwrap();
    assert!(String::from_utf8(said.stderr).unwrap().contains(&full));
    for words in [
        "fifo=unlimited",
        "when-full=stall",
        "requests=all",
        "faster link",
    ] {
        assert!(text.contains(words), "{text}");
    }
    // What is in the file is warned of where it is judged, too.
    let judged = json(here, &["compare", "fired.npy", "again.npy"]);
    assert!(about(&judged).contains(&"queue"), "{judged}");
    for advice in [
        &["fifo=100000"][..],
        &["fifo=unlimited"],
        &["link=36ns"],
        &["when-full=stall", "requests=all"],
    ] {
        let (told, text) = run(advice);
        assert!(
            !about(&told).contains(&"queue") && !text.contains("queue"),
            "{text}"
        );
        let told = json(here, &[&read[..], &with(advice)].concat());
        assert!(about(&told).is_empty(), "{advice:?}: {told}");
    }
    let threshold = ["read.npy", "--threshold", "0.5"];
    let higher = json(here, &[&MOVING[..], &threshold, &with(&[])].concat());
    assert!(higher["events"].as_u64() > Some(0));
    assert!(!about(&higher).contains(&"queue"), "{higher}");
}

/// A scan of too few slots is warned of in `packets` as in `run`.
#[test]
fn lost_slots_are_warned_of_by_packets_too() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    good(here, &[&MOVING[..], &["fired.npy"]].concat());
    let scan = [
        "--readout",
        "scan",
        "--with",
        "slots=10",
        "--with",
        "period=40ms",
    ];
    let of_run = json(here, &[&MOVING[..], &["read.npy"], &scan].concat());
    let packets = [&["packets", "fired.npy"][..], &scan].concat();
    let told = json(here, &packets);
    assert_eq!(about(&told), ["slots"]);
    let of_run = of_run["warnings"].as_array().unwrap();
    assert!(of_run.contains(&told["warnings"][0]), "{of_run:?}");
    let said = amacrine(here, &packets).output().unwrap();
    let said = String::from_utf8(said.stderr).unwrap();
    assert!(said.contains("the readout's slots were full"), "{said}");
    assert!(about(&json(here, &["packets", "fired.npy"])).is_empty());
}

/// One key is the events that left the readout, whoever ran it.
#[test]
fn arrived_means_the_same_in_every_verb() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let of = |told: &Value, key: &str| told[key].as_u64().unwrap();
    let events = |name: &str| file::read(&here.join(name)).unwrap().packet.events.len() as u64;
    let plain = json(here, &[&MOVING[..], &["fired.npy"]].concat());
    assert_eq!(of(&plain, "arrived"), of(&plain, "events"));
    assert_eq!(of(&plain, "arrived"), events("fired.npy"));
    let most = ["few.npy", "--max-events", "20", "--when-full", "drop"];
    let few = json(here, &[&MOVING[..], &most].concat());
    assert_eq!(of(&few, "arrived"), events("few.npy"));
    assert!(of(&few, "arrived") < of(&few, "events"));
    let scan = [
        "--readout",
        "scan",
        "--with",
        "slots=10",
        "--with",
        "period=40ms",
    ];
    let read = json(here, &[&MOVING[..], &["read.npy"], &scan].concat());
    assert_eq!(of(&read, "events"), of(&plain, "events"));
    assert_eq!(of(&read, "arrived"), events("read.npy"));
    assert!(of(&read, "arrived") < of(&read, "events"));
    assert_eq!(
        of(&read, "bits"),
        of(&read, "events") * of(&read, "bits_per_event")
    );
    let packets = ["packets", "fired.npy", "-o", "again.npy"];
    let again = json(here, &[&packets[..], &scan].concat());
    assert_eq!(of(&again, "arrived"), of(&read, "arrived"));
    assert_eq!(of(&again, "arrived"), events("again.npy"));
    let program = "init { CLR(R5); }\nframe { SET(R5); scamp5_scan_events(R5, on, 5); }\n";
    fs::write(here.join("p.scamp"), program).unwrap();
    let scene = "pattern:disc?width=24&height=20&frames=6";
    let exec = ["exec", "p.scamp", "--image", scene, "-o", "chip.npy"];
    let chip = json(here, &exec);
    assert_eq!(of(&chip, "arrived"), 25);
    assert_eq!(events("chip.npy"), 25);
}

#[test]
fn a_link_that_cannot_keep_up_is_said_however_slow_it_is() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let events = (0..2000).map(|i| format!("{},{},{},1\n", 10 * i, 7 * i % 16, i % 8));
    let text = "# amacrine size=16x8 span=0..20000 dropped=0,0\nt,x,y,p\n";
    fs::write(
        here.join("e.csv"),
        events.fold(text.to_owned(), |all, e| all + &e),
    )
    .unwrap();
    let says = |with: &[&str]| {
        let with = with.iter().flat_map(|it| ["--with", it]);
        let all = ["packets", "e.csv", "--readout", "arbiter"];
        let all: Vec<_> = all.into_iter().chain(with).collect();
        good(here, &all).contains("the link cannot keep up")
    };
    for link in ["link=10.5us", "link=20us", "link=1ms", "link=1s"] {
        for requests in ["requests=all", "requests=one"] {
            assert!(says(&[link, requests]), "{link} {requests}");
            assert!(says(&[link, requests, "burst=no"]), "{link} {requests}");
        }
        assert!(says(&[link, "when-full=drop-oldest", "fifo=3"]), "{link}");
    }
    assert!(!says(&["link=9.9us", "requests=all"]));
    assert!(!says(&["link=1us"]));
}

/// A packet of crossing times is late for its stamps, not for the scan.
#[test]
fn crossing_times_need_a_period() {
    let folder = TempDir::new().unwrap();
    let here = folder.path();
    let text = "# amacrine size=16x8 span=0..20000 dropped=0,0\nt,x,y,p\n";
    let packet = |name: &str, each: usize| {
        let events = (0..2000).map(|i| format!("{},{},{},1\n", 10 * (i / each), 7 * i % 16, i % 8));
        fs::write(
            here.join(name),
            events.fold(text.to_owned(), |all, e| all + &e),
        )
        .unwrap();
    };
    packet("crossings.csv", 1);
    packet("frames.csv", 4);
    let note = |file: &str, with: &[&str]| {
        good(
            here,
            &[&["packets", file, "--readout", "scan"][..], with].concat(),
        )
    };
    let told = note("crossings.csv", &[]);
    assert!(
        told.contains("give --with period=TIME") && !told.contains("cannot keep up"),
        "{told}"
    );
    assert!(note("frames.csv", &[]).contains("the scan cannot keep up"));
    // The same sentences are in the answers for machines.
    let run = [
        "run",
        "--scene",
        "bundled",
        "--slice",
        "..6",
        "--sensor",
        "rgc-4",
        "-o",
        "read.npy",
        "--readout",
        "scan",
    ];
    for command in [&["packets", "crossings.csv", "--readout", "scan"][..], &run] {
        let (table, told) = (good(here, command), json(here, command));
        let notes = told["notes"].as_array().unwrap();
        let late = notes.iter().filter_map(Value::as_str);
        let late: Vec<_> = late
            .filter(|it| it.contains("give --with period=TIME"))
            .collect();
        assert_eq!(late.len(), 1, "{told}");
        assert!(
            table.contains(&format!("\nnote     {}\n", late[0])),
            "{table}"
        );
    }
    let told = note("crossings.csv", &["--with", "period=10us"]);
    assert!(told.contains("the scan cannot keep up"), "{told}");
}

#[test]
fn counts_of_a_readout_need_no_quotes() {
    let folder = folder();
    let text = good(folder.path(), &["list", "readouts", "arbiter"]);
    let plain = text.replace("value = \"512\"", "value = 512");
    assert_ne!(plain, text);
    fs::write(folder.path().join("mine.toml"), &plain).unwrap();
    let read = |name| json(folder.path(), &["packets", "e.csv", "--readout", name]);
    let (own, shipped) = (read("mine.toml"), read("arbiter"));
    assert_eq!(own["readout"]["settings"], shipped["readout"]["settings"]);
    let wrong = plain.replace("value = 512", "value = 512.5");
    fs::write(folder.path().join("wrong.toml"), wrong).unwrap();
    let words = [
        "wrong.toml:",
        "512.5",
        "a whole number from 0 to 4294967296",
    ];
    refused_untouched(
        folder.path(),
        &["packets", "e.csv", "--readout", "wrong.toml"],
        &words,
    );
}
