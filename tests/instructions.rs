//! Proves that `docs/scamp5.md` is what `isa/` says, and says something of every statement.
//! `AMACRINE_BLESS=1 cargo test --test instructions` writes it anew.

use std::{collections::BTreeSet, fs, path::Path};

use amacrine::{
    array::{Array, Chip, Exact, Register, Settings},
    event::Packet,
    isa::{Analog, Cell, Device, Digital, Figure, Operand, Signature, signature::Mode},
    picture::{StripCell, panel, strip, write_png},
    plane::{Plane, Size},
    program::{CellEffect, Sample, reference, samples},
    unit::Micros,
};
use image::RgbImage;

/// What to do where they differ, and the chip is right.
const BLESS: &str = "if isa/ is right, write it: AMACRINE_BLESS=1 cargo test --test instructions";

#[test]
fn the_page_is_what_the_files_say() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scamp5.md");
    let text = reference(&Device::scamp5());
    if std::env::var_os("AMACRINE_BLESS").is_some() {
        fs::write(&path, &text).unwrap();
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    for (number, (a, b)) in (1..).zip(written.lines().zip(text.lines())) {
        assert_eq!(a, b, "docs/scamp5.md:{number}: {BLESS}");
    }
    assert_eq!(written, text, "docs/scamp5.md: {BLESS}");
}

/// R12 is written only where R0 is 1, whatever writes it: each statement that can says so.
#[test]
fn what_can_write_r12_says_where() {
    let device = Device::scamp5();
    let words = { device.primitives().iter() }.map(|row| (&row.forms, &row.equation));
    let hosts = device.hosts().iter().map(|row| (&row.forms, &row.meaning));
    let bits = |form: &Signature| {
        let mut written = form.parameters.iter().filter(|it| it.mode == Mode::Out);
        written.any(|it| it.operand == Operand::Dreg)
    };
    let mut seen = 0;
    for (forms, says) in words.chain(hosts) {
        if forms.iter().any(bits) {
            seen += 1;
            assert!(says.contains("R12 is written only where R0 is 1"), "{says}");
        }
    }
    assert_eq!(
        seen, 6,
        "SET, CLR, OR, NOR, DNEWS and the areas of the host"
    );
}

const SIDE: usize = 32;

/// Shapes on a ground, unlike in each register: a disc, a wedge of greys, bars, a square.
fn analogue(register: usize) -> Plane<f64> {
    Plane::from_shape_fn((SIDE, SIDE), |(y, x)| {
        let (y, x) = (y as f64 - 15.5, x as f64 - 15.5);
        match register % 4 {
            0 if (y * y + x * x).sqrt() < 9.0 => 90.0,
            1 => 5.0 * x + if y.abs() < 4.0 { 20.0 } else { 0.0 },
            2 if (x - y).rem_euclid(12.0) < 4.0 => 60.0,
            3 if y.abs().max(x.abs()) < 7.0 => -70.0,
            _ => -20.0,
        }
    })
}

fn bits(register: usize) -> Plane<bool> {
    let at = |y: usize, x: usize| match register % 3 {
        0 => ((y + 1) / 6).is_multiple_of(2),
        1 => y.abs_diff(16).pow(2) + x.abs_diff(16).pow(2) < 100,
        _ => x > y,
    };
    Plane::from_shape_fn((SIDE, SIDE), |(y, x)| at(y, x))
}

/// What registers hold: analogue ones, bits, FLAG.
fn held(chip: &Chip<Exact>, cell: Cell) -> RgbImage {
    let register = Register::from(cell);
    let (black, white) = if register.is_bit() {
        (0.0, 1.0)
    } else {
        (-128.0, 127.0)
    };
    panel::frame(&register.values(chip), black, white)
}

/// The registers that a call reads or writes, before it and behind it.
fn drawn(device: &Device, sample: &Sample<'_>) -> RgbImage {
    let code = sample.expansion.code.clone();
    let settings = Settings::from_device(device);
    let size = Size::new(SIDE, SIDE);
    let mut chip = Chip::new("sample", Exact, &code, device, size, settings).unwrap();
    let registers = device.registers();
    for k in 0..registers.analog.len() {
        chip.set_analog(Analog(k as u8), &analogue(k)).unwrap();
    }
    let roles = registers.roles;
    for k in 0..registers.digital.len() {
        let digital = Digital(k as u8);
        let all = |value| Plane::from_elem((SIDE, SIDE), value);
        let east = roles.enable[1];
        let plane = match digital {
            // Everything passes the mask, and the neighbour in the east is read.
            _ if digital == roles.mask || digital == east => all(true),
            _ if roles.enable.contains(&digital) => all(false),
            _ => bits(k),
        };
        chip.set_digital(digital, &plane).unwrap();
    }
    // Words without operands are about FLAG: it is then not 1 everywhere.
    let whole = !sample.call.ends_with("()");
    let flag = Plane::from_shape_fn((SIDE, SIDE), |(_, x)| whole || x < SIDE / 2);
    chip.set_flag(&flag).unwrap();
    chip.expose(&analogue(0).mapv(|v| v + 100.0)).unwrap();
    let effect = CellEffect::of(&code.frame, device);
    let mut cells: BTreeSet<Cell> = effect.writes.clone();
    cells.extend(effect.reads.iter().filter(|cell| **cell != Cell::Flag));
    let column = |chip: &Chip<Exact>, written: &BTreeSet<Cell>| {
        let cell = |cell: &Cell| StripCell {
            picture: held(chip, *cell),
            written: written.contains(cell),
        };
        cells.iter().map(cell).collect::<Vec<_>>()
    };
    let before = column(&chip, &BTreeSet::new());
    let mut packet = Packet::new(size, 1);
    chip.run_frame(Micros(0), &mut packet).unwrap();
    let behind = column(&chip, &effect.writes);
    let names: Vec<String> = cells.iter().map(|cell| cell.name(device)).collect();
    let columns = [("before".to_owned(), before), ("after".to_owned(), behind)];
    strip(&sample.call, &names, &columns).unwrap()
}

/// Every word and macro that writes a register has a picture, and it is that of the semantics.
#[test]
fn the_pictures_are_what_the_calls_do() {
    let device = Device::scamp5();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/instructions");
    let samples = samples(&device);
    assert!(samples.len() > 80, "{}", samples.len());
    let mut names = BTreeSet::new();
    for sample in &samples {
        let file = format!("{}.png", sample.name);
        let (path, drawn) = (folder.join(&file), drawn(&device, sample));
        if std::env::var_os("AMACRINE_BLESS").is_some() {
            fs::create_dir_all(&folder).unwrap();
            write_png(&path, &drawn).unwrap();
        }
        let written = image::open(&path).unwrap_or_else(|e| panic!("{file}: {e}: {BLESS}"));
        assert!(
            written.to_rgb8() == drawn,
            "docs/instructions/{file}: {BLESS}"
        );
        names.insert(file);
    }
    for entry in fs::read_dir(&folder).unwrap() {
        let file = entry.unwrap().file_name().into_string().unwrap();
        assert!(
            names.contains(&file),
            "docs/instructions/{file} shows nothing that there is"
        );
    }
}

#[test]
fn every_statement_has_equation_operands_aliases_destroys_words_and_evidence() {
    let device = Device::scamp5();
    let text = reference(&device);
    let entries: Vec<&str> = text.split("\n### ").skip(1).collect();
    for callable in device.all_callables() {
        let name = &callable.signature().name;
        let entry = entries
            .iter()
            .find(|entry| entry.contains(&format!("{name}(")));
        let entry = entry.unwrap_or_else(|| panic!("{name} is missing"));
        for part in ["- aliases: ", "- destroys: ", "- words: "] {
            assert!(entry.contains(part), "{name}: {part}");
        }
        let known = ["measured", "quoted", "modelled", "guess"];
        assert!(known.iter().any(|e| entry.contains(e)), "{name}: evidence");
    }
    for figure in Figure::ALL {
        let (section, key) = figure.key();
        assert!(text.contains(&format!("`{section}.{key}`")));
    }
}

/// What is said of some macros whose rules are known from the vendor's tables.
#[test]
fn what_the_tables_say_is_on_the_page() {
    let text = reference(&Device::scamp5());
    let entry = |heading: &str| {
        let (_, rest) = text.split_once(&format!("### `{heading}`")).unwrap();
        rest.split_once("\n### ").map_or(rest, |(entry, _)| entry)
    };
    let sub = entry("sub(out y: areg, x0: source, x1: source)");
    assert!(sub.contains("illegal: y = x1") && sub.contains("- destroys: NEWS\n- words: 2\n"));
    let xor = entry("XORX(out l: dreg, trash x: dreg, y: bit)");
    assert!(xor.contains("- destroys: R0, x\n- words: 6\n"), "{xor}");
    let abs = entry("abs(out y: areg, x: source)");
    assert!(
        abs.contains("- destroys: NEWS, FLAG\n- words: 6\n"),
        "{abs}"
    );
    let gauss = entry("gauss(out y: areg, x: areg, n: int[1..65535] = 3)");
    assert!(
        gauss.contains("3 for n = 1; 2 more for each step of n"),
        "{gauss}"
    );
    let two = entry("mov2x(out y: areg, x: source, d1: dir, d2: dir)");
    assert!(two.contains("- FLAG: must be 1 everywhere"));
}
