//! The gallery: what every bundled sensor says of four scenes, and what every bundled program leaves
//! in its registers. Writes `docs/gallery.md` and the pictures beside it.
//!
//! ```text
//! cargo run --release --example gallery            # or: just gallery
//! cargo run --release --example gallery -- FOLDER  # elsewhere than docs
//! ```

use std::{collections::BTreeMap, fmt::Write as _, fs, path::Path};

use amacrine::{
    array::{Arithmetic, Settings},
    bundled::{self, File, Kind},
    event::Packet,
    isa::{Cell, Device, Figure},
    number::Format,
    picture::{StripCell, panel, strip, write_png},
    plane::Plane,
    program::{CellEffect, Overrides, Program},
    reference::{Description, EventList, Limit, Reference},
    scene::{Frame, OpenOptions, Scene, bundled_with, open},
    sensor::Sensor as _,
};
use miette::{IntoDiagnostic, Report, miette};

/// The scenes: what they are called, how they are opened (`bundled` is the clip), and the frame
/// whose events are shown.
const SCENES: [(&str, &str, u64); 4] = [
    ("the bundled clip", "bundled", 30),
    (
        "a bar that moves",
        "pattern:bar?width=112&height=112&frames=9&speed=120",
        8,
    ),
    (
        "a disc that moves",
        "pattern:disc?width=112&height=112&frames=9&speed=120",
        8,
    ),
    (
        "blobs that drift",
        "pattern:noise?width=112&height=112&frames=9&speed=120&grain=14",
        8,
    ),
];

fn main() -> miette::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "docs".to_owned());
    let folder = Path::new(&folder);
    let pictures = folder.join("gallery");
    fs::create_dir_all(&pictures).into_diagnostic()?;
    let mut page = String::from(
        "# Gallery\n\nWhat comes with the program, at work. `cargo run --release --example gallery` makes this page and its pictures.\n\n## Sensors by clips\n\nThe events between one frame and the next, over the light: ON blue, OFF red. A list of the sensors is `amacrine list sensors`; `amacrine show sensor NAME` prints one; `amacrine run --scene SCENE --sensor NAME` runs it.\n\nThe scenes, from left to right:\n",
    );
    for (name, scene, _) in SCENES {
        // Writing to a string cannot fail.
        let _ = write!(page, "\n- {name}, `--scene '{scene}'`");
    }
    page += "\n";
    // The authors' files are variants of the others.
    for file in bundled::all(Kind::Sensor).filter(|file| !file.name.starts_with("authors/")) {
        let sensor = Description::open(file.name)?;
        let shown = shown_by(&sensor)?;
        let name = file.name.replace('/', "-");
        save(
            &pictures.join(format!("sensor-{name}.png")),
            file.name,
            shown,
        )?;
        let kinds = match sensor.channels.len() {
            1 => "one kind of cell".to_owned(),
            n => format!("{n} kinds of cells"),
        };
        let _ = write!(
            page,
            "\n### {}\n\n{kinds}. `amacrine show sensor {}`\n\n![{}, four scenes](gallery/sensor-{name}.png)\n",
            file.name, file.name, file.name
        );
    }
    page += "\n## Programs by registers\n\nWhat the registers that a program writes hold after its last frame, in exact arithmetic: analogue ones from -128 (black) to 127 LSB, one-bit registers black and white. `amacrine exec NAME --strip s.png` shows them line by line, `--trace page.html` word by word.\n";
    for file in bundled::all(Kind::Program) {
        let (about, shown) = left_by(file)?;
        let name = file.name.replace('/', "-");
        save(
            &pictures.join(format!("program-{name}.png")),
            file.name,
            shown,
        )?;
        let _ = write!(
            page,
            "\n### {}\n\n{about}. `amacrine exec {}`\n\n![{}, its registers](gallery/program-{name}.png)\n",
            file.name, file.name, file.name
        );
    }
    fs::write(folder.join("gallery.md"), page).into_diagnostic()?;
    Ok(())
}

/// A row of pictures with captions.
fn save(path: &Path, title: &str, columns: Vec<(String, StripCell)>) -> miette::Result<()> {
    let columns: Vec<_> = columns
        .into_iter()
        .map(|(caption, cell)| (caption, vec![cell]))
        .collect();
    write_png(path, &strip(title, &[String::new()], &columns)?)?;
    Ok(())
}

fn opened(scene: &str) -> miette::Result<Box<dyn Scene>> {
    let options = OpenOptions::default();
    if scene == "bundled" {
        return Ok(Box::new(bundled_with(&options)?));
    }
    Ok(open(scene, &options)?)
}

/// The events of a sensor on each scene.
fn shown_by(sensor: &Description) -> miette::Result<Vec<(String, StripCell)>> {
    let mut cells = Vec::new();
    for (name, scene, last) in SCENES {
        let mut scene = opened(scene)?;
        let (size, kinds) = (scene.size(), sensor.channels.len() as u8);
        let mut reference = Reference::new(sensor.clone(), size, 0)?;
        let mut packet = Packet::new(size, kinds);
        let mut light = None;
        while let Some(frame) = scene.next_frame()? {
            packet.events.clear();
            let mut list = EventList::new(&mut packet, Limit::default());
            reference.watch_into(&frame, &mut list)?;
            let index = frame.index;
            light = Some(frame.light);
            if index == last {
                break;
            }
        }
        let light = light.ok_or_else(|| miette!("{name} has no frame"))?;
        let light = light.mapv(|it| levelled(it, 0.0, 255.0));
        let ground = panel::pale(&panel::frame(&light, 0.0, 255.0));
        cells.push((
            name.to_owned(),
            StripCell {
                picture: panel::events(ground, &packet.events),
                written: true,
            },
        ));
    }
    Ok(cells)
}

/// The title of a program, and what its registers hold after its last frame.
fn left_by(file: File) -> miette::Result<(String, Vec<(String, StripCell)>)> {
    let program = Program::parse(&file.path(), file.text)?;
    let own = &program.settings;
    let device = Device::find(own.chip.as_deref().unwrap_or("scamp5"))?;
    let code = program.expand(&device, &Overrides::default())?.code;
    let image = own
        .image
        .as_deref()
        .unwrap_or("pattern:disc?width=64&height=48");
    let mut scene = opened(image)?;
    let settings = Settings {
        clip: true,
        edge: own.edge.unwrap_or_default(),
        ..Settings::from_device(&device)
    };
    let exact = Arithmetic::Number(Format::F64);
    let mut chip = exact.chip(file.name, &code, &device, scene.size(), settings)?;
    let mut packet = Packet::new(chip.size(), chip.channels());
    let mut light: Option<Plane<f64>> = None;
    // Statements without an `init` begin with the second frame.
    let frames = own.frames.unwrap_or(2) + u64::from(code.init.is_empty());
    for index in 0..frames {
        // A picture that does not move is shown again.
        if let Some(frame) = scene.next_frame()? {
            light = Some(frame.light.into_plane());
        }
        let light = light
            .clone()
            .ok_or_else(|| miette!("{image} has no frame"))?;
        let seconds = index as f64 / scene.fps();
        packet.events.clear();
        let frame = Frame {
            index,
            seconds,
            light: light.into(),
        };
        chip.watch(&frame, &mut packet)?;
    }
    let about = own.title.clone().unwrap_or_else(|| file.name.to_owned());
    let mut cells = vec![("light".to_owned(), cell(light.as_ref(), 0.0, 255.0)?)];
    let (low, high) = (device.value(Figure::Lowest), device.value(Figure::Highest));
    let mut written: BTreeMap<String, (Cell, f64, f64)> = BTreeMap::new();
    for steps in [&code.init, &code.frame] {
        for it in CellEffect::of(steps, &device).writes {
            let (black, white) = match it {
                Cell::Analog(_) => (low, high),
                Cell::Digital(_) | Cell::Flag => (0.0, 1.0),
            };
            written.insert(it.name(&device), (it, black, white));
        }
    }
    for (name, (it, black, white)) in written {
        let held = match it {
            Cell::Analog(register) => chip.analog(register),
            Cell::Digital(register) => chip.digital(register).mapv(|bit| f64::from(u8::from(bit))),
            Cell::Flag => continue,
        };
        cells.push((name, cell(Some(&held), black, white)?));
    }
    Ok((about, cells))
}

/// In few greys: the pictures are small files.
fn levelled(value: f64, black: f64, white: f64) -> f64 {
    let step = (white - black) / 16.0;
    black + ((value - black) / step).round() * step
}

fn cell(held: Option<&Plane<f64>>, black: f64, white: f64) -> Result<StripCell, Report> {
    let held = held.ok_or_else(|| miette!("nothing was shown"))?;
    let held = &held.mapv(|it| levelled(it, black, white));
    Ok(StripCell {
        picture: panel::frame(held, black, white),
        written: true,
    })
}
