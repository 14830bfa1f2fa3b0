//! Everything that takes in bytes, as functions of bytes: an end or a message, never a panic,
//! in time and memory that the fuzzer bounds.

pub mod mutate;

use std::{
    collections::BTreeMap,
    fs, panic,
    path::{Path, PathBuf},
    sync::{Once, OnceLock},
};

use amacrine::{
    array::{Array, Chip, Exact, Settings},
    catch_panic, compare,
    event::{
        Packet,
        codec::{Arrival, Coded, Coding, Layout},
        file::{self, Compression, Format, Opening, Reader},
        readout,
    },
    isa::Device,
    kernel::Kernel,
    plane::{Plane, Size},
    program::{Action, Answer, Beside, Program, Step},
    reference::{Description, Reference},
    scene::{self, Frame, OpenOptions},
    sensor::Sensor,
    study::sweep::{Study, store},
    unit::Micros,
};
use mutate::Shape;

/// Something that takes in bytes.
pub struct Target {
    /// Its name, also of its folder of seeds.
    pub name: &'static str,
    /// What its bytes are made of.
    pub shape: Shape,
    /// Takes them in.
    pub run: fn(&[u8]),
}

macro_rules! targets {
    ($($name:literal $shape:ident $run:expr;)*) => {
        /// All of them.
        pub const TARGETS: &[Target] = &[$(
            Target { name: $name, shape: Shape::$shape, run: $run },
        )*];
    };
}

targets! {
    "csv" Text |b| events(Format::Csv, b);
    "txt" Text |b| events(Format::Txt, b);
    "npy" Words |b| events(Format::Npy, b);
    "npz" Zip |b| events(Format::Npz, b);
    "evt2" Words |b| events(Format::Evt2, b);
    "evt2.1" Words |b| events(Format::Evt21, b);
    "evt3" Words |b| events(Format::Evt3, b);
    "dat" Words |b| events(Format::Dat, b);
    "aedat2" Words |b| events(Format::Aedat2, b);
    "aedat3" Words |b| events(Format::Aedat3, b);
    "aedat4" Packets |b| events(Format::Aedat4, b);
    "e2vid" Text |b| events(Format::E2vid, b);
    "zip" Zip |b| events(Format::E2vidZip, b);
    "es" Words |b| events(Format::Es, b);
    "hdf5" Words |b| events(Format::Hdf5, b);
    "parquet" Words |b| events(Format::Parquet, b);
    "words" Words words;
    "compare" Words pair;
    "y4m" Text |b| clip("y4m", b);
    "mp4" Boxes |b| clip("mp4", b);
    "gif" Gif |b| clip("gif", b);
    "png" Png |b| clip("png", b);
    "apng" Png |b| clip("apng", b);
    "pgm" Text |b| clip("pgm", b);
    "light" Words |b| clip("npy", b);
    "folder" Png folder;
    "pattern" Text |b| text(b, |t| play(&format!("pattern:{t}")));
    "kernel" Text |b| text(b, |t| drop(Kernel::from_toml("k.toml", t)));
    "weights" Words |b| drop(Kernel::from_npy(b));
    "sensor" Text |b| text(b, sensor);
    "device" Text |b| chip(0, b);
    "primitives" Text |b| chip(1, b);
    "macros" Text |b| chip(2, b);
    "program" Text |b| text(b, program);
    "vendor" Text |b| text(b, vendor);
    "study" Text |b| text(b, study);
    "readout" Text |b| text(b, arbiter);
    "results" Text results;
}

/// libFuzzer's hook ends the program at every panic.
pub fn spare_what_is_guarded() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let hook = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            if !catch_panic::is_catching() {
                hook(panic);
            }
        }));
    });
}

/// A folder in memory, of this process; gone with it or with the machine.
fn place() -> &'static Path {
    static PLACE: OnceLock<PathBuf> = OnceLock::new();
    PLACE.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() {
            tempfile::tempdir_in(memory)
        } else {
            tempfile::tempdir()
        };
        folder.expect("a folder for temporary files").keep()
    })
}

/// The bytes as a file of this name.
fn placed(name: &str, bytes: &[u8]) -> PathBuf {
    let path = place().join(name);
    fs::write(&path, bytes).expect("a temporary file");
    path
}

/// What is no text is nobody's text file.
fn text(bytes: &[u8], work: impl FnOnce(&str)) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        work(text);
    }
}

/// Two files in one input: the first two bytes say where the second starts.
fn halves(bytes: &[u8]) -> (&[u8], &[u8]) {
    let Some(([a, b], rest)) = bytes.split_first_chunk() else {
        return (bytes, &[]);
    };
    rest.split_at(usize::from(u16::from_le_bytes([*a, *b])).min(rest.len()))
}

/// Event files: what was read is written in the same format and read again.
fn events(format: Format, bytes: &[u8]) {
    let opening = Opening {
        format: Some(format),
        ..Opening::default()
    };
    let Ok(reader) = Reader::of_bytes(Path::new("fuzz"), bytes.to_vec(), &opening) else {
        return;
    };
    let (loaded, _) = file::all(reader);
    let path = place().join("again");
    if file::write_as(&path, format, Compression::Lz4, &loaded.packet).is_ok() {
        let again = file::read_as(&path, &opening).expect("we wrote it");
        assert_eq!(again.packet.events, loaded.packet.events);
    }
}

/// Takes five bytes for what sender and receiver agreed on, the rest for address words. The
/// events are written as words and read again.
fn words(bytes: &[u8]) {
    let Some((&[height, width, channels, flags, events], words)) = bytes.split_first_chunk() else {
        return;
    };
    let side = |byte: u8| usize::from(byte) * 7 + 1;
    let coded = Coded {
        size: Size::new(side(height), side(width)),
        channels: channels.max(1),
        layout: if flags & 1 == 0 {
            Layout::Single
        } else {
            Layout::Burst
        },
        huffman: flags & 2 != 0,
        bytes: words.to_vec(),
        bits: (8 * words.len() as u64).saturating_sub(u64::from(flags >> 5)),
        arrivals: vec![Arrival {
            t: Micros(1),
            events: events.into(),
        }],
    };
    let Ok(events) = coded.decode() else { return };
    let mut packet = Packet::new(coded.size, coded.channels);
    packet.events = events;
    let coding = Coding {
        layout: coded.layout,
        book: None,
    };
    let again = coding.encode(&packet).and_then(|coded| coded.decode());
    assert_eq!(again.expect("we wrote it"), packet.events);
}

/// Two recordings, and the ruler between them.
fn pair(bytes: &[u8]) {
    let read = |bytes: &[u8]| {
        let opening = Opening {
            format: Some(Format::Dat),
            size: Some(Size::new(64, 64)),
            stream: None,
        };
        let reader = Reader::of_bytes(Path::new("fuzz"), bytes.to_vec(), &opening);
        reader.ok().map(|reader| file::all(reader).0)
    };
    let (a, b) = halves(bytes);
    if let (Some(mut a), Some(mut b)) = (read(a), read(b)) {
        a.widen_to(&b.packet);
        b.widen_to(&a.packet);
        drop(compare::compare(&a.packet, &b.packet, Micros(1000)));
    }
}

/// A clip of this kind.
fn clip(kind: &str, bytes: &[u8]) {
    let path = placed(&format!("clip.{kind}"), bytes);
    play(&path.to_string_lossy());
}

/// A folder of two pictures.
fn folder(bytes: &[u8]) {
    let (a, b) = halves(bytes);
    let folder = place().join("pictures");
    fs::create_dir_all(&folder).expect("a temporary folder");
    placed("pictures/1.png", a);
    placed("pictures/2.png", b);
    play(&folder.to_string_lossy());
}

/// The first frames of a scene, as far as they are small.
fn play(spec: &str) {
    let Ok(mut scene) = scene::open(spec, &OpenOptions::default()) else {
        return;
    };
    let frames = (1 << 22) / scene.size().pixels().max(1);
    for _ in 0..frames.min(16) {
        if !matches!(scene.next_frame(), Ok(Some(_))) {
            break;
        }
    }
}

/// A sensor, and what it says of two frames.
fn sensor(text: &str) {
    let none = |_: &str| Err(std::io::Error::other("no other file"));
    let Ok(description) = Description::parse("fuzz.toml", text, &none) else {
        return;
    };
    let Ok(mut sensor) = Reference::new(description, Size::new(5, 6), 1) else {
        return;
    };
    watch(&mut sensor);
}

/// Two small frames.
fn watch(sensor: &mut dyn Sensor) {
    let mut packet = Packet::new(Size::new(5, 6), sensor.channels());
    for index in 0..2_u64 {
        let light =
            Plane::from_shape_fn((5, 6), |(y, x)| ((x + y) as u64 * 9 * (index + 1)) as f64);
        let frame = Frame {
            index,
            seconds: index as f64 / 100.0,
            light: light.into(),
        };
        if sensor.watch(&frame, &mut packet).is_err() {
            return;
        }
    }
}

/// A chip of which one file is the bytes and the others are SCAMP-5's.
fn chip(number: usize, bytes: &[u8]) {
    let files = ["device.toml", "primitives.toml", "macros.scamp"];
    let own = [
        &include_bytes!("../isa/scamp5/device.toml")[..],
        include_bytes!("../isa/scamp5/primitives.toml"),
        include_bytes!("../isa/scamp5/macros.scamp"),
    ];
    fs::create_dir_all(place().join("chip")).expect("a temporary folder");
    for (i, (name, own)) in files.iter().zip(own).enumerate() {
        placed(
            &format!("chip/{name}"),
            if i == number { bytes } else { own },
        );
    }
    drop(Device::load(&place().join("chip")));
}

/// A program; a short one runs.
fn program(text: &str) {
    static CHIP: OnceLock<Device> = OnceLock::new();
    let device = CHIP.get_or_init(Device::scamp5);
    let Ok(program) = Program::parse("fuzz.scamp", text) else {
        return;
    };
    let Ok(expansion) = program.expand(device, &BTreeMap::new()) else {
        return;
    };
    let code = &expansion.code;
    if steps(&code.init) + steps(&code.frame) > 1000.0 {
        return;
    }
    let chip = Chip::new(
        "fuzz",
        Exact,
        code,
        device,
        Size::new(5, 6),
        Settings::from_device(device),
    );
    if let Ok(mut chip) = chip {
        watch(&mut chip);
        let _ = chip.ledger();
    }
}

/// C++ for the vendor's tools; where its host decides, it runs beside an array.
fn vendor(text: &str) {
    static CHIP: OnceLock<Device> = OnceLock::new();
    let device = CHIP.get_or_init(Device::scamp5);
    let (program, none) = (Program::read("fuzz.cpp", text), BTreeMap::new());
    if program.layout(device, &none).is_ok_and(|it| it.decides) {
        drop(program.run_beside(device, &none, &mut Answering(50)));
    }
}

/// An array that has this many answers.
struct Answering(u8);

impl Beside for Answering {
    fn frame(&mut self) -> bool {
        self.0 = self.0.saturating_sub(10);
        self.0 > 0
    }

    fn run(&mut self, _: &[Step]) -> Option<Answer> {
        self.0 = self.0.checked_sub(1)?;
        Some(Answer {
            value: Some(i64::from(self.0 % 3)),
            memory: Some(vec![self.0.into(); 4]),
        })
    }

    fn micros(&self) -> f64 {
        1.0
    }

    fn post(&mut self, _: String) {}
}

/// How many steps run in all.
fn steps(steps: &[Step]) -> f64 {
    let of = |step: &Step| match &step.action {
        Action::Repeat { times, body } => f64::from(*times) * self::steps(body),
        _ => 1.0,
    };
    steps.iter().map(of).sum()
}

/// A study and its points.
fn study(text: &str) {
    if let Ok(study) = Study::parse("fuzz.toml", text) {
        drop(study.points());
    }
}

/// A readout's settings.
fn arbiter(text: &str) {
    if let Ok(settings) = readout::settings::Description::parse("fuzz", text) {
        drop(settings.readout());
    }
}

/// A folder of results: what it says of itself, and one point.
fn results(bytes: &[u8]) {
    let (said, point) = halves(bytes);
    let folder = place().join("results");
    let points = folder.join("points");
    fs::create_dir_all(&points).expect("a temporary folder");
    placed("results/sweep.json", said);
    // As each of the first points that the folder names; the others are missing.
    let id = String::from_utf8_lossy(said);
    let is_id = |word: &&str| word.len() == 32 && word.bytes().all(|b| b.is_ascii_hexdigit());
    for id in id.split('"').filter(is_id).take(4) {
        placed(&format!("results/points/{id}.json"), point);
    }
    drop(store::read(&folder));
}
