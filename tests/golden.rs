//! Every program of `programs/` gives what is written below it: instruction words, events, and
//! registers after the last frame, on the scene of its settings, in the `Exact` domain.
//! `AMACRINE_BLESS=1 cargo test --test golden` writes down what they give now.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use amacrine::{
    array::{Arithmetic, Settings},
    event::{Packet, Polarity},
    isa::Device,
    plane::{Plane, Size},
    program::{Cost, Expectation, ExpectedEvents, ExpectedWords, Overrides, Program, Summary},
    scene::{OpenOptions, Scene, open},
    unit::Micros,
};

fn programs() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("programs");
    let mut found = Vec::new();
    for folder in fs::read_dir(root).unwrap() {
        let files = fs::read_dir(folder.unwrap().path()).unwrap();
        found.extend(files.map(|file| file.unwrap().path()));
    }
    found.sort();
    found
}

/// Runs a program as its settings say, and sums up what it gave.
fn outcome(program: &Program) -> Expectation {
    let settings = &program.settings;
    let device = Device::find(settings.chip.as_deref().unwrap_or("scamp5")).unwrap();
    let expansion = program.expand(&device, &Overrides::new()).unwrap();
    let code = expansion.code;
    let words = ExpectedWords {
        init: Cost::of(&code.init, &device).words.0,
        frame: Cost::of(&code.frame, &device).words.0,
    };
    let spec = settings
        .image
        .as_ref()
        .unwrap_or_else(|| panic!("{}: no image in the settings", program.file));
    let mut scene = open(
        spec,
        &OpenOptions {
            fps: settings.fps,
            ..OpenOptions::default()
        },
    )
    .unwrap();
    let chip_settings = Settings {
        clip: settings.clip.unwrap_or(false),
        edge: settings.edge.unwrap_or(Settings::from_device(&device).edge),
        ..Settings::from_device(&device)
    };
    let arithmetic: Arithmetic = settings
        .domain
        .as_deref()
        .unwrap_or("exact")
        .parse()
        .unwrap();
    let mut chip = arithmetic
        .chip("golden", &code, &device, scene.size(), chip_settings)
        .unwrap();
    let mut packet = Packet::new(scene.size(), settings.channels.unwrap_or(1));
    for _ in 0..settings.frames.unwrap_or(1) {
        let frame = scene
            .next_frame()
            .unwrap()
            .expect("a frame for each that the settings ask for");
        if expansion.bare {
            chip.expose(&frame.light).unwrap();
            chip.run_frame(Micros::from_seconds(frame.seconds), &mut packet)
                .unwrap();
        } else {
            chip.watch(&frame, &mut packet).unwrap();
        }
    }
    let told = &program.expectation.registers;
    let registers = told
        .keys()
        .map(|name| (name.clone(), summary(&register(&*chip, &device, name))));
    let computed = settings
        .computes
        .as_ref()
        .and_then(|computes| computes.register.clone());
    let mut registers: BTreeMap<_, _> = registers.collect();
    if let Some(name) = computed {
        let value = summary(&register(&*chip, &device, &name));
        registers.insert(name, value);
    }
    let count = |polarity| {
        packet
            .events
            .iter()
            .filter(|e| e.polarity == polarity)
            .count() as u64
    };
    let events = ExpectedEvents {
        on: count(Polarity::On),
        off: count(Polarity::Off),
    };
    Expectation {
        words: Some(words),
        events: (settings.channels.is_some()).then_some(events),
        registers,
    }
}

fn register(chip: &dyn amacrine::array::Array, device: &Device, name: &str) -> Plane<f64> {
    use amacrine::isa::{Analog, Digital};
    if name == "FLAG" {
        return chip.flag().mapv(|bit| f64::from(u8::from(bit)));
    }
    let layout = chip.layout();
    let size: Size = layout.size;
    let analog = (0..u8::MAX)
        .map(Analog)
        .take_while(|r| !device.analog_name(*r).is_empty())
        .take(64)
        .find(|r| device.analog_name(*r) == name);
    if let Some(analog) = analog {
        return chip.analog(analog);
    }
    let digital = (0..64)
        .map(Digital)
        .find(|r| device.digital_name(*r) == name);
    let digital = digital.unwrap_or_else(|| panic!("no register {name} on an array of {size}"));
    chip.digital(digital).mapv(|bit| f64::from(u8::from(bit)))
}

fn summary(plane: &Plane<f64>) -> Summary {
    Summary {
        min: plane.iter().copied().fold(f64::INFINITY, f64::min),
        max: plane.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        sum: plane.sum(),
    }
}

#[test]
fn programs_give_what_is_written_below_them() {
    let bless = std::env::var_os("AMACRINE_BLESS").is_some();
    let mut wrong = Vec::new();
    let programs = programs();
    assert!(programs.len() >= 16);
    for path in programs {
        let text = fs::read_to_string(&path).unwrap();
        let program =
            Program::parse(&path.display().to_string(), &text).unwrap_or_else(|e| panic!("{e:?}"));
        let outcome = outcome(&program);
        if bless {
            fs::write(&path, program.blessed(&outcome).unwrap()).unwrap();
        } else if outcome != program.expectation {
            wrong.push(format!(
                "{}\n  gives   {outcome:?}\n  expects {:?}",
                path.display(),
                program.expectation
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn folders_hold_what_the_map_says() {
    for folder in [
        "capture", "convolve", "dvs", "features", "motion", "regions", "rgc",
    ] {
        let here = format!("programs/{folder}/");
        assert!(
            programs()
                .iter()
                .any(|path| path.display().to_string().contains(&here)),
            "{here} is empty"
        );
    }
}
