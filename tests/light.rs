//! Proves that samples become the light that people mean: range and transfer from the file or as
//! asked, the scale of an array; that cuts and repeated frames are found, and that each guard
//! speaks and only then.
//! Against: the standards' formulas, arrays of the same light, clips that ffmpeg made.

use std::{fs, io, path::Path};

use amacrine::{
    event::Packet,
    photoreceptor::{Curve, Response},
    plane::{Plane, Size},
    reference::{Description, Reference},
    rig::{
        self,
        guard::{About, Crowd, Guard, Warning},
    },
    scene::{
        Coding, Frame, Observation, Observed, OpenOptions, Origin, Outline, Range, Samples, Scene,
        SceneError, Slice, Sliced, Transfer, bundled, bundled_with, open,
    },
    sensor::{Sensor, Silence},
    unit::Micros,
};
use miette::Diagnostic;
use tempfile::TempDir;

fn data(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join("tests/data/scene")
        .join(name)
        .display()
        .to_string()
}

/// A folder with one file in it; its path.
fn file(name: &str, bytes: &[u8]) -> (TempDir, String) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    (folder, path.display().to_string())
}

/// A y4m of gray frames; with `colour` other than mono, planes of gray chroma follow.
fn y4m(size: Size, fields: &str, frames: &[Vec<u8>]) -> Vec<u8> {
    let Size { height, width } = size;
    let mut bytes = format!("YUV4MPEG2 W{width} H{height} F10:1 {fields}\n").into_bytes();
    let chroma = if fields.contains("C420") {
        2 * width.div_ceil(2) * height.div_ceil(2)
    } else {
        0
    };
    for frame in frames {
        bytes.extend(b"FRAME\n");
        bytes.extend(frame);
        bytes.extend(vec![128; chroma]);
    }
    bytes
}

/// A `.npy` of shape (T, H, W).
fn npy(kind: &str, size: Size, frames: u64, numbers: impl IntoIterator<Item = u8>) -> Vec<u8> {
    let Size { height, width } = size;
    let mut header = format!(
        "{{'descr': '{kind}', 'fortran_order': False, 'shape': ({frames}, {height}, {width}), }}"
    );
    while (header.len() + 11) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.into_bytes());
    bytes.extend(numbers);
    bytes
}

fn doubles(size: Size, frames: &[Vec<f64>]) -> Vec<u8> {
    let numbers = frames.iter().flatten().flat_map(|v| v.to_le_bytes());
    npy("<f8", size, frames.len() as u64, numbers)
}

fn coding(range: Option<Range>, transfer: Option<Transfer>, scale: Option<f64>) -> OpenOptions {
    OpenOptions {
        coding: Coding {
            range,
            transfer,
            scale,
        },
        ..OpenOptions::default()
    }
}

fn asked(range: Range) -> OpenOptions {
    coding(Some(range), Some(Transfer::AsCoded), None)
}

fn frames(mut scene: impl Scene) -> Vec<Plane<f64>> {
    let mut lights = Vec::new();
    while let Some(frame) = scene.next_frame().unwrap() {
        lights.push(frame.light.into_plane());
    }
    lights
}

fn first(path: &str, options: &OpenOptions) -> Vec<f64> {
    let lights = frames(open(path, options).unwrap());
    lights[0].iter().copied().collect()
}

const CODED: [u8; 6] = [0, 16, 100, 126, 235, 255];

fn stretched() -> Vec<f64> {
    let light = |y: &u8| ((f64::from(*y) - 16.0) * 255.0 / 219.0).clamp(0.0, 255.0);
    CODED.iter().map(light).collect()
}

#[test]
fn the_range_of_a_y4m_is_the_files_the_callers_or_that_of_its_kind() {
    let size = Size::new(1, 6);
    let coded: Vec<f64> = CODED.iter().map(|y| f64::from(*y)).collect();
    let stretched = stretched();
    assert_eq!((stretched[1], stretched[4]), (0.0, 255.0));
    for (fields, is_limited, from) in [
        ("Cmono", false, Origin::Assumed),
        ("Cmono XCOLORRANGE=FULL", false, Origin::File),
        ("Cmono XCOLORRANGE=LIMITED", true, Origin::File),
        ("C420jpeg", true, Origin::Assumed),
        ("C420mpeg2 XCOLORRANGE=FULL", false, Origin::File),
        ("C420paldv XCOLORRANGE=LIMITED", true, Origin::File),
    ] {
        let (_folder, path) = file("a.y4m", &y4m(size, fields, &[CODED.to_vec()]));
        let light = open(&path, &OpenOptions::default())
            .unwrap()
            .outline()
            .coding;
        assert_eq!(light.range_from, from, "{fields}");
        let want = if is_limited { &stretched } else { &coded };
        assert_eq!(&first(&path, &OpenOptions::default()), want, "{fields}");
        // The caller comes first.
        assert_eq!(first(&path, &asked(Range::Limited)), stretched, "{fields}");
        assert_eq!(first(&path, &asked(Range::Full)), coded, "{fields}");
    }
    let (_folder, path) = file(
        "a.y4m",
        &y4m(size, "Cmono XCOLORRANGE=HALF", &[CODED.to_vec()]),
    );
    let error = open(&path, &OpenOptions::default()).err().unwrap();
    assert!(error.to_string().contains("COLORRANGE=HALF"), "{error}");
}

#[test]
fn limited_range_of_more_bits() {
    let size = Size::new(1, 4);
    let deep = |bits: u32| -> Vec<u8> {
        let one = 1_u16 << (bits - 8);
        let codes = [16 * one, 235 * one, 16 * one + 73 * one, 4 * one];
        codes.iter().flat_map(|c| c.to_le_bytes()).collect()
    };
    let want = [0.0, 255.0, 85.0, 0.0];
    let near = |got: &[f64], what: &str| {
        let worst = got.iter().zip(&want).map(|(g, w)| (g - w).abs());
        assert!(worst.fold(0.0, f64::max) < 1e-9, "{what}: {got:?}");
    };
    for bits in [10, 12, 16] {
        let fields = format!("Cmono{bits} XCOLORRANGE=LIMITED");
        let (_folder, path) = file("a.y4m", &y4m(size, &fields, &[deep(bits)]));
        near(&first(&path, &OpenOptions::default()), &fields);
    }
    // Whole numbers of an array, which are as given unless asked.
    let (_folder, path) = file("a.npy", &npy("<u2", size, 1, deep(16)));
    assert_eq!(first(&path, &OpenOptions::default())[0], 4096.0);
    near(&first(&path, &asked(Range::Limited)), "u2");
    // Of full range, 65535 is white.
    let full = first(&path, &asked(Range::Full));
    assert_eq!(full[0], 4096.0 * 255.0 / 65_535.0);
    let light = outline(&path, &asked(Range::Full)).coding.to_string();
    assert!(
        light.starts_with("full range (as asked) of 16 bits"),
        "{light}"
    );
    let (_folder, path) = file("a.npy", &npy("|u1", size, 1, [16, 235, 89, 4]));
    near(&first(&path, &asked(Range::Limited)), "u1");
    // Pictures are full, and may be said to be limited.
    assert_eq!(
        first(&data("still.pgm"), &asked(Range::Full)),
        first(&data("still.pgm"), &OpenOptions::default())
    );
    for name in ["still.pgm", "walk.gif", "walk.apng", "pictures"] {
        let full = first(&data(name), &OpenOptions::default());
        let limited = first(&data(name), &asked(Range::Limited));
        for (full, limited) in full.iter().zip(&limited) {
            let want = ((full - 16.0) * 255.0 / 219.0).clamp(0.0, 255.0);
            assert!((limited - want).abs() < 1e-9, "{name}: {limited}, {want}");
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let (_folder, path) = file("a.npy", &doubles(Size::new(1, 2), &[vec![0.0, 1.0]]));
    let says = |spec: &str, options: &OpenOptions, words: &str| {
        let error: SceneError = open(spec, options).err().expect(words);
        let help = error.help().unwrap().to_string();
        assert!(error.to_string().contains(words), "{error}");
        assert!(!help.is_empty());
    };
    says(&path, &asked(Range::Limited), "no limited range");
    for scale in [0.0, -1.0, f64::NAN] {
        says(&path, &coding(None, None, Some(scale)), "no scale");
    }
    let scaled = coding(None, None, Some(255.0));
    says(&data("walk.y4m"), &scaled, "only the numbers of an array");
    for options in [
        scaled,
        asked(Range::Limited),
        coding(None, Some(Transfer::Srgb), None),
    ] {
        says("pattern:bar", &options, "drawn as light");
    }
    let fine = coding(Some(Range::Full), Some(Transfer::Linear), None);
    assert!(open("pattern:bar", &fine).is_ok());
}

/// Every code of 8 bits is coded by the standard's formula from a light, and comes back.
#[test]
fn gamma_is_undone_in_a_file() {
    let size = Size::new(16, 16);
    let codes: Vec<u8> = (0..=255).collect();
    let (_folder, path) = file("a.y4m", &y4m(size, "Cmono", &[codes]));
    let light = |transfer| first(&path, &coding(None, Some(transfer), None));
    let srgb = |v: f64| {
        if v <= 0.04045 {
            v / 12.92
        } else {
            ((v + 0.055) / 1.055).powf(2.4)
        }
    };
    let bt709 = |v: f64| {
        if v < 0.081 {
            v / 4.5
        } else {
            ((v + 0.099) / 1.099).powf(1.0 / 0.45)
        }
    };
    let (in_srgb, in_bt709) = (light(Transfer::Srgb), light(Transfer::Bt709));
    for code in 0..256_usize {
        let v = code as f64 / 255.0;
        assert!((in_srgb[code] - 255.0 * srgb(v)).abs() < 1e-9, "{code}");
        assert!((in_bt709[code] - 255.0 * bt709(v)).abs() < 1e-9, "{code}");
        let back = Transfer::Srgb.coded(in_srgb[code]);
        assert!((back - code as f64).abs() < 1e-4, "{code}: {back}");
        let back = Transfer::Bt709.coded(in_bt709[code]);
        assert!((back - code as f64).abs() < 0.1, "{code}: {back}");
    }
    assert_eq!((in_srgb[0], in_srgb[255]), (0.0, 255.0));
    assert_eq!((in_bt709[0], in_bt709[255]), (0.0, 255.0));
    let as_given = light(Transfer::AsCoded);
    assert_eq!(as_given, light(Transfer::Linear));
    assert_eq!(as_given[128], 128.0);
    // First the range, then the transfer.
    let limited = coding(Some(Range::Limited), Some(Transfer::Srgb), None);
    let got = first(&path, &limited)[126];
    let want = 255.0 * srgb((126.0 - 16.0) / 219.0);
    assert!((got - want).abs() < 1e-9, "{got}, {want}");
}

#[test]
fn the_bundled_clip_is_full_range_and_takes_the_options() {
    let plain = bundled().unwrap();
    let light = plain.outline().coding;
    assert_eq!(
        (light.range, light.transfer, light.scale),
        (Some(Range::Full), Transfer::AsCoded, 1.0)
    );
    let options = OpenOptions {
        fps: Some(25.0),
        ..coding(None, Some(Transfer::Srgb), None)
    };
    let mut undone = bundled_with(&options).unwrap();
    let frame = bundled().unwrap().next_frame().unwrap().unwrap();
    let got = undone.next_frame().unwrap().unwrap();
    assert_eq!(got.light, frame.light.mapv(|v| Transfer::Srgb.light(v)));
    let next = undone.next_frame().unwrap().unwrap();
    assert_eq!((undone.fps(), next.seconds), (25.0, 1.0 / 25.0));
}

/// Slope and offset of the straight line from one clip's light to another's.
#[cfg(feature = "mp4")]
fn line(from: &[Plane<f64>], to: &[Plane<f64>]) -> (f64, f64) {
    let all = |planes: &[Plane<f64>]| -> Vec<f64> { planes.iter().flatten().copied().collect() };
    let (from, to) = (all(from), all(to));
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (a, b) = (mean(&from), mean(&to));
    let both: f64 = from.iter().zip(&to).map(|(x, y)| (x - a) * (y - b)).sum();
    let slope = both / from.iter().map(|x| (x - a).powi(2)).sum::<f64>();
    (slope, b - slope * a)
}

/// ffmpeg made the mp4 from `walk.y4m`, of full range, and coded it in limited range, which it
/// does not write into the file.
#[cfg(feature = "mp4")]
#[test]
fn an_mp4_of_ffmpeg_has_the_light_of_its_source() {
    let walk = frames(open(&data("walk.y4m"), &OpenOptions::default()).unwrap());
    for name in ["baseline.mp4", "bframes.mp4"] {
        let scene = open(&data(name), &OpenOptions::default()).unwrap();
        let light = scene.outline().coding;
        assert_eq!(
            (light.range, light.range_from),
            (Some(Range::Limited), Origin::Assumed)
        );
        let (slope, offset) = line(&walk, &frames(scene));
        assert!((slope - 1.0).abs() < 0.01, "{name}: {slope}");
        assert!(offset.abs() < 1.0, "{name}: {offset}");
        let coded = frames(open(&data(name), &asked(Range::Full)).unwrap());
        let (slope, offset) = line(&walk, &coded);
        assert!((slope - 219.0 / 255.0).abs() < 0.01, "{name}: {slope}");
        assert!((offset - 16.0).abs() < 1.0, "{name}: {offset}");
    }
}

/// The clip with a box `colr` in place of its box `btrt`, which has the same length.
#[cfg(feature = "mp4")]
fn tagged(is_full: bool, transfer: u8) -> Vec<u8> {
    let mut bytes = fs::read(data("baseline.mp4")).unwrap();
    let at = bytes.windows(4).position(|four| four == b"btrt").unwrap();
    assert_eq!(bytes[at - 4..at], [0, 0, 0, 20]);
    bytes[at..at + 4].copy_from_slice(b"colr");
    let content = [0, 1, 0, transfer, 0, 1, u8::from(is_full) << 7, 0];
    bytes[at + 4..at + 8].copy_from_slice(b"nclx");
    bytes[at + 8..at + 16].copy_from_slice(&content);
    bytes
}

#[cfg(feature = "mp4")]
#[test]
fn an_mp4_says_its_range_and_transfer() {
    let plain = data("baseline.mp4");
    for is_full in [false, true] {
        let range = if is_full { Range::Full } else { Range::Limited };
        for (number, transfer) in [(1, Transfer::Bt709), (13, Transfer::Srgb)] {
            let (_folder, path) = file("a.mp4", &tagged(is_full, number));
            let scene = open(&path, &OpenOptions::default()).unwrap();
            let light = scene.outline().coding;
            assert_eq!(
                (light.range, light.range_from, light.stated_transfer),
                (Some(range), Origin::File, Some(transfer))
            );
            assert_eq!(light.transfer, Transfer::AsCoded);
            let as_coded = frames(scene);
            assert_eq!(as_coded, frames(open(&plain, &asked(range)).unwrap()));
            // What the file says is undone where that is asked for.
            let undone = open(&path, &coding(None, None, None)).unwrap();
            assert_eq!(undone.outline().coding.transfer, transfer);
            let want = as_coded[3].mapv(|v| transfer.light(v));
            assert_eq!(frames(undone)[3], want);
        }
    }
}

/// A transfer that nothing undoes is told, and stays whatever `auto` does.
#[cfg(feature = "mp4")]
#[test]
fn an_mp4_of_another_transfer_says_so() {
    for (number, transfer) in [
        (4, Transfer::Gamma22),
        (5, Transfer::Gamma28),
        (7, Transfer::Smpte240m),
    ] {
        let (_folder, path) = file("a.mp4", &tagged(true, number));
        let light = outline(&path, &coding(None, None, None)).coding;
        assert_eq!(
            (light.transfer, light.not_undone),
            (transfer, None),
            "{number}"
        );
    }
    for (number, name) in [(9, "a logarithm"), (16, "PQ"), (18, "HLG")] {
        let (_folder, path) = file("a.mp4", &tagged(true, number));
        for options in [OpenOptions::default(), coding(None, None, None)] {
            let light = outline(&path, &options).coding;
            assert_eq!(light.transfer, Transfer::AsCoded);
            let told = format!("as coded (the file says {name}, which is not undone)");
            assert!(light.to_string().ends_with(&told), "{light}");
            assert!(!light.is_linear());
        }
    }
}

fn outline(spec: &str, options: &OpenOptions) -> Outline {
    open(spec, options).unwrap().outline()
}

/// A PNG with these chunks before its pixels.
fn with_chunks(png: &[u8], chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    // The signature and IHDR.
    let (start, rest) = png.split_at(8 + 25);
    let mut bytes = start.to_vec();
    for (kind, content) in chunks {
        bytes.extend((content.len() as u32).to_be_bytes());
        let named = [&kind[..], content].concat();
        bytes.extend(&named);
        bytes.extend(crc32fast::hash(&named).to_be_bytes());
    }
    bytes.extend(rest);
    bytes
}

/// A gray PNG of one row.
fn gray(codes: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, codes.len() as u32, 1);
    encoder.set_color(png::ColorType::Grayscale);
    encoder
        .write_header()
        .unwrap()
        .write_image_data(codes)
        .unwrap();
    bytes
}

/// Chunks of a PNG by their names.
type Chunks<'a> = Vec<(&'a [u8; 4], &'a [u8])>;

/// In the order of the PNG specification: cICP, iCCP, sRGB, gAMA.
#[test]
fn a_png_says_its_range_and_transfer() {
    use std::io::Write as _;
    let gamma = |gamma: u32| gamma.to_be_bytes();
    let mut profile =
        flate2::write::ZlibEncoder::new(b"name\0\0".to_vec(), flate2::Compression::default());
    profile.write_all(&[7; 128]).unwrap();
    let profile = profile.finish().unwrap();
    let (g22, g28, g20, g1) = (gamma(45_455), gamma(35_714), gamma(50_000), gamma(100_000));
    let (full, limited) = ([1, 13, 0, 1], [9, 16, 0, 0]);
    let file_says = |range| (Some(range), Origin::File);
    let usual = (Some(Range::Full), Origin::Assumed);
    let cases: Vec<(Chunks<'_>, _, Option<Transfer>, Option<&str>)> = vec![
        (vec![], usual, None, None),
        (vec![(b"sRGB", &[0])], usual, Some(Transfer::Srgb), None),
        (vec![(b"gAMA", &g22)], usual, Some(Transfer::Gamma22), None),
        (vec![(b"gAMA", &g28)], usual, Some(Transfer::Gamma28), None),
        (vec![(b"gAMA", &g1)], usual, Some(Transfer::Linear), None),
        (
            vec![(b"gAMA", &g20)],
            usual,
            None,
            Some("a gamma other than 2.2 and 2.8"),
        ),
        (
            vec![(b"gAMA", &g22), (b"sRGB", &[0])],
            usual,
            Some(Transfer::Srgb),
            None,
        ),
        (
            vec![(b"iCCP", &profile), (b"gAMA", &g22)],
            usual,
            None,
            Some("what its ICC profile says"),
        ),
        (
            vec![(b"gAMA", &g22), (b"cICP", &full)],
            file_says(Range::Full),
            Some(Transfer::Srgb),
            None,
        ),
        (
            vec![(b"cICP", &limited)],
            file_says(Range::Limited),
            None,
            Some("PQ"),
        ),
    ];
    for (chunks, range, transfer, not_undone) in cases {
        let (folder, path) = file("a.png", &with_chunks(&gray(&CODED), &chunks));
        let moved = format!("pattern:static?image={path}&frames=1");
        for spec in [&path, &folder.path().display().to_string(), &moved] {
            let light = outline(spec, &coding(None, None, None)).coding;
            let told = (light.stated_transfer, light.not_undone);
            assert_eq!(told, (transfer, not_undone), "{spec}");
            assert_eq!((light.range, light.range_from), range, "{spec}");
            let black = if range.0 == Some(Range::Limited) {
                (16.0, 255.0 / 219.0)
            } else {
                (0.0, 1.0)
            };
            let want: Vec<f64> = { CODED.iter() }
                .map(|code| (f64::from(*code) - black.0) * black.1)
                .map(|code| transfer.unwrap_or_default().light(code.clamp(0.0, 255.0)))
                .collect();
            let got = first(spec, &coding(None, None, None));
            let worst = got.iter().zip(&want).map(|(g, w)| (g - w).abs());
            assert!(worst.fold(0.0, f64::max) < 1e-9, "{spec}: {got:?} {want:?}");
            // What is stated is not undone unless that is asked for.
            let light = outline(spec, &OpenOptions::default()).coding;
            assert_eq!(light.transfer, Transfer::AsCoded, "{spec}");
            assert_eq!(light.is_linear(), transfer == Some(Transfer::Linear));
        }
    }
    let walk = fs::read(data("walk.apng")).unwrap();
    let (_folder, path) = file("a.apng", &with_chunks(&walk, &[(b"sRGB", &[0])]));
    let light = outline(&path, &coding(None, None, None)).coding;
    assert_eq!(light.transfer, Transfer::Srgb);
}

/// What a pattern moves is light, as the picture alone is.
#[test]
fn a_picture_that_moves_is_no_drawn_light() {
    let still = data("still.pgm");
    for transfer in [Transfer::AsCoded, Transfer::Srgb, Transfer::Bt709] {
        for range in [None, Some(Range::Full), Some(Range::Limited)] {
            let options = coding(range, Some(transfer), None);
            for name in ["pan", "rotate", "zoom", "static"] {
                let spec = format!("pattern:{name}?image={still}&speed=0&frames=1");
                let spec = match name {
                    "pan" => spec,
                    _ => spec.replace("&speed=0", ""),
                };
                assert_eq!(first(&spec, &options), first(&still, &options), "{spec}");
                let light = outline(&spec, &options).coding;
                assert_eq!(light.samples, Samples::Moved);
                assert_eq!(light.is_linear(), transfer != Transfer::AsCoded);
                assert!(light.to_string().contains(", transfer "), "{light}");
            }
        }
    }
    let scaled = open(
        &format!("pattern:pan?image={still}"),
        &coding(None, None, Some(2.0)),
    );
    let error = scaled.err().unwrap().to_string();
    assert!(error.contains("only the numbers of an array"), "{error}");
    // Without a picture there is nothing to undo, and fast pans are no cuts.
    assert_eq!(
        outline("pattern:pan", &OpenOptions::default())
            .coding
            .to_string(),
        "drawn as light, nothing to undo"
    );
    let fast = format!("pattern:pan?image={still}&frames=9&speed=1e5&border=wrap");
    let scene = open(&fast, &OpenOptions::default()).unwrap();
    assert_eq!(observed(scene).cuts(), []);
}

/// Patterns finer than pixels, or faster than frames.
#[test]
fn patterns_that_are_seen_as_others_say_so() {
    let told = |spec: &str| {
        let scene = open(spec, &OpenOptions::default()).unwrap();
        let warnings = Warning::of_scene(&observed(scene), Response::IDENTITY);
        warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let image = data("still.pgm");
    let shrunk = format!("pattern:zoom?image={image}&growth=-2&frames=121&fps=120");
    for (spec, words) in [
        ("pattern:noise?grain=1&frames=2", ["grain=1:", "grain=2"]),
        (
            "pattern:static?grain=1.5&frames=2",
            ["grain=1.5:", "--resize"],
        ),
        (
            "pattern:zoom?growth=-4&frames=121&fps=120&width=8&height=8",
            ["growth=-4:", "54.6 pixels"],
        ),
        (&shrunk, ["growth=-2:", "7.4 pixels"]),
        (
            "pattern:flicker?frequency=200&frames=2&width=8",
            ["seen as 40 Hz", "fps= of 800"],
        ),
        (
            "pattern:flicker?frequency=120&frames=2&width=8&fps=240",
            [
                "120 Hz at 240 frames/s is seen as constant light",
                "fps= of 480",
            ],
        ),
        (
            "pattern:flicker?frequency=360&frames=2&width=8&fps=240",
            ["seen as constant light", "fps= of 1440"],
        ),
    ] {
        let told = told(spec);
        assert_eq!(told.len(), 1, "{spec}: {told:?}");
        for word in words {
            assert!(told[0].contains(word), "{told:?}");
        }
    }
    for spec in [
        "pattern:noise?grain=2&frames=2",
        "pattern:zoom?frames=2",
        "pattern:zoom?growth=-1&frames=61&fps=120&width=8&height=8",
        "pattern:flicker?frequency=199&frames=2&width=8&fps=400",
        "pattern:flicker?frequency=200&frames=2&width=8&fps=400&wave=square",
        "pattern:flicker?frequency=0&frames=2&width=8",
        "pattern:spot?sigma=0.1&frames=2",
    ] {
        assert_eq!(told(spec), [""; 0], "{spec}");
    }
}

/// Players make pixels square; here they are taken as they are.
#[test]
fn pixels_that_are_not_square_are_told() {
    let told = |path: &str| {
        let scene = open(path, &OpenOptions::default()).unwrap();
        let warnings = Warning::of_scene(&observed(scene), Response::IDENTITY);
        let shape = warnings.iter().find(|it| it.about == About::Shape);
        shape.map(ToString::to_string)
    };
    let clip = |fields: &str| {
        let frames = [CODED.to_vec(), CODED.to_vec()];
        let (_folder, path) = file("a.y4m", &y4m(Size::new(1, 6), fields, &frames));
        told(&path)
    };
    let wide = clip("A2:1 Cmono").unwrap();
    assert!(wide.contains("not square: width 2, height 1"), "{wide}");
    for square in ["A1:1 Cmono", "A0:0 Cmono", "A8:8 Cmono", "Cmono"] {
        assert_eq!(clip(square), None, "{square}");
    }
    #[cfg(feature = "mp4")]
    {
        // A box `pasp` in place of the box `btrt`, and four bytes that are free.
        let mut bytes = fs::read(data("baseline.mp4")).unwrap();
        let (_folder, path) = file("a.mp4", &bytes);
        assert_eq!(told(&path), None);
        let at = bytes.windows(4).position(|four| four == b"btrt").unwrap();
        bytes[at..at + 4].copy_from_slice(b"pasp");
        bytes[at + 4..at + 12].copy_from_slice(&[0, 0, 0, 4, 0, 0, 0, 3]);
        let (_folder, path) = file("a.mp4", &bytes);
        let wide = told(&path).unwrap();
        assert!(wide.contains("not square: width 4, height 3"), "{wide}");
    }
}

/// Frames in memory.
struct Clip {
    size: Size,
    lights: std::vec::IntoIter<Plane<f64>>,
    next: u64,
}

impl Clip {
    fn new(lights: Vec<Plane<f64>>) -> Self {
        Self {
            size: Size::of(&lights[0]),
            lights: lights.into_iter(),
            next: 0,
        }
    }
}

impl Scene for Clip {
    fn outline(&self) -> Outline {
        Outline {
            // As of a file: patterns have no cuts.
            coding: bundled().unwrap().outline().coding,
            ..Outline::new(self.size, 10.0)
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let index = self.next;
        self.next += 1;
        Ok(self.lights.next().map(|light| Frame {
            index,
            seconds: index as f64 / 10.0,
            light: light.into(),
        }))
    }
}

/// What the plain DVS of `sensors/` says of a scene.
fn dvs(mut scene: impl Scene) -> Packet {
    let text = include_str!("../sensors/dvs.toml");
    let none = |name: &str| Err(io::Error::other(name.to_owned()));
    let description = Description::parse("dvs.toml", text, &none).unwrap();
    let mut sensor = Reference::new(description, scene.size(), 0).unwrap();
    let mut sensors: Vec<&mut (dyn Sensor + Send)> = vec![&mut sensor];
    rig::watch(&mut scene, &mut sensors, |_| {})
        .unwrap()
        .remove(0)
}

/// A limited-range copy of a clip fires as the clip itself, and about half as much where its
/// pedestal stays in the logarithm.
#[test]
fn a_limited_copy_has_the_events_of_the_clip() {
    let mut lights = frames(bundled().unwrap());
    lights.truncate(16);
    let size = Size::of(&lights[0]);
    let luma = |v: &f64| (16.0 + v * 219.0 / 255.0).round() as u8;
    let limited: Vec<Vec<u8>> = lights
        .iter()
        .map(|l| l.iter().map(luma).collect())
        .collect();
    let fields = "Cmono XCOLORRANGE=LIMITED";
    let (_folder, path) = file("limited.y4m", &y4m(size, fields, &limited));
    let events = |options| dvs(open(&path, &options).unwrap()).events.len() as f64;
    let full = dvs(Clip::new(lights)).events.len() as f64;
    let auto = events(OpenOptions::default());
    assert!((auto / full - 1.0).abs() < 0.02, "{auto} of {full}");
    let pedestal = events(asked(Range::Full));
    assert!(pedestal < 0.7 * full, "{pedestal} of {full}");
    // The same light as numbers gives the same events, to the last.
    let numbers: Vec<Vec<f64>> = limited
        .iter()
        .map(|frame| {
            frame
                .iter()
                .map(|y| (f64::from(*y) - 16.0) * 255.0 / 219.0)
                .collect()
        })
        .collect();
    let (_folder, array) = file("limited.npy", &doubles(size, &numbers));
    let options = OpenOptions {
        fps: Some(10.0),
        ..OpenOptions::default()
    };
    let of_array = dvs(open(&array, &options).unwrap());
    assert_eq!(of_array, dvs(open(&path, &OpenOptions::default()).unwrap()));
}

fn observed(scene: impl Scene) -> Observation {
    let observation = Observation::new();
    frames(Observed::new(scene, &observation));
    observation
}

#[test]
fn a_cut_is_found_where_it_is_and_nowhere_else() {
    let lights = frames(bundled().unwrap());
    let mirrored = |light: &Plane<f64>| {
        let mut light = light.clone();
        light.invert_axis(ndarray::Axis(1));
        light.as_standard_layout().into_owned()
    };
    for at in [7, 30] {
        let pieces = lights[..at].iter().cloned();
        let pieces = pieces.chain(lights[at..].iter().map(mirrored)).collect();
        let found = observed(Clip::new(pieces)).cuts();
        let places: Vec<_> = found.iter().map(|cut| (cut.frame, cut.seconds)).collect();
        assert_eq!(places, [(at as u64, at as f64 / 10.0)]);
        let warning = Warning::cuts(&found, None).unwrap();
        assert_eq!(warning.about, About::Cut);
        let text = warning.to_string();
        assert!(text.contains(&format!("a cut at frame {at} ")), "{text}");
        assert!(text.contains("split the clip"), "{text}");
        assert!(text.contains(&format!("--slice ..{at}, ")), "{text}");
        // Frames of a slice are not those that `--slice` counts.
        let slice: Slice = "6..90".parse().unwrap();
        let seen = observed(Sliced::new(Clip::new(lights.clone()), slice));
        assert_eq!(seen.slice(), Some(slice));
        let text = Warning::cuts(&found, Some(slice)).unwrap().to_string();
        for part in [
            format!("--slice 6..{}, ", at + 6),
            format!("--slice {}..90", at + 6),
        ] {
            assert!(text.contains(&part), "{part}: {text}");
        }
    }
    assert_eq!(Warning::cuts(&[], None), None);
    // The clip itself, also when only some of its frames are taken, has none.
    for step in [1, 2, 5, 10] {
        let some = lights.iter().step_by(step).cloned().collect();
        assert_eq!(observed(Clip::new(some)).cuts(), [], "every {step}");
    }
    // Lamps that flicker are no cut: the picture stays.
    let lamp = |(n, light): (usize, &Plane<f64>)| light.mapv(|v| v * [1.0, 0.5][n % 2]);
    let flicker = lights.iter().enumerate().map(lamp).collect();
    assert_eq!(observed(Clip::new(flicker)).cuts(), []);
    let walk = open(&data("walk.y4m"), &OpenOptions::default()).unwrap();
    assert_eq!(observed(walk).cuts(), []);
    for pattern in ["pattern:bar?speed=6000", "pattern:disc?speed=9000"] {
        let scene = open(pattern, &OpenOptions::default()).unwrap();
        assert_eq!(observed(scene).cuts(), [], "{pattern}");
    }
}

#[test]
fn a_clip_that_repeats_frames_says_so() {
    let size = Size::new(32, 32);
    // A line that moves by a column a picture; each picture is shown so many times.
    let clip = |shown: &[usize]| {
        let picture = |at: usize| (0..1024).map(|n| u8::from(n % 8 == at % 8) * 200).collect();
        let frames = shown.iter().enumerate();
        let frames = frames.flat_map(|(at, times)| vec![picture(at); *times]);
        let bytes = y4m(size, "Cmono", &frames.collect::<Vec<Vec<u8>>>());
        let (_folder, path) = file("clip.y4m", &bytes);
        observed(open(&path, &OpenOptions::default()).unwrap())
    };
    let found = |observation: &Observation| {
        let found = observation.repeated();
        found.map(|found| (found.frames, found.of))
    };
    let twice = clip(&[2; 10]);
    assert_eq!(found(&twice), Some((10, 20)));
    let warnings = Warning::of_scene(&twice, Response::IDENTITY);
    let [warning] = warnings.as_slice() else {
        panic!("{warnings:?}");
    };
    assert_eq!(warning.about, About::Repeats);
    let text = warning.to_string();
    assert!(text.contains("10 of 20 frames"), "{text}");
    let change = "drop one frame in 2 and show the others at 50 % of the frame rate";
    assert!(text.contains(change), "{text}");
    // Now and then is no other rate, and a scene may stand still for long.
    let rarely = clip(&[1, 1, 1, 1, 1, 2, 1, 1, 1, 1, 1]);
    assert_eq!(found(&rarely), Some((1, 12)));
    assert!(Warning::of_scene(&rarely, Response::IDENTITY).is_empty());
    assert_eq!(found(&clip(&[9, 1, 1, 1, 9, 1, 1, 9])), None);
    for scene in ["pattern:bar?speed=20", "pattern:disc?speed=1"] {
        let scene = open(scene, &OpenOptions::default()).unwrap();
        assert_eq!(observed(scene).repeated(), None);
    }
    assert_eq!(observed(bundled().unwrap()).repeated(), None);
}

/// Pictures whose numbers lack some, arrays of more than 8 bits, and reals near 1.
#[test]
fn gaps_and_scales_are_told() {
    let folder = tempfile::tempdir().unwrap();
    for n in [1, 2, 3, 7, 8] {
        let still = fs::read(data("still.pgm")).unwrap();
        fs::write(folder.path().join(format!("f{n:03}.pgm")), still).unwrap();
    }
    let scene = open(
        &folder.path().display().to_string(),
        &OpenOptions::default(),
    )
    .unwrap();
    let told = Warning::of_scene(&observed(scene), Response::IDENTITY);
    let gap = told.iter().find(|warning| warning.about == About::Gap);
    let text = gap.expect("three are missing").to_string();
    assert!(
        text.contains("3 pictures are missing in the numbering: after 3 comes 7"),
        "{text}"
    );

    let scaled = |samples, extent| {
        let warning = Warning::scale(samples, Some(extent), Response::IDENTITY);
        warning.map(|warning| warning.to_string())
    };
    let ten = scaled(Samples::Integers, (3.0, 987.0)).unwrap();
    assert!(ten.contains("(0.249267 for 10 bits"), "{ten}");
    // A logarithm does not make changes larger.
    let log = Curve::Log {
        white: 255.0,
        offset: 1e-3,
    };
    let sixteen = Some((256.0, 65_280.0));
    for (curve, grows) in [
        (Curve::Identity, true),
        (Curve::Linear { white: 255.0 }, true),
        (log, false),
        (Curve::LinLog { knee: 20.0 }, false),
    ] {
        let warning = Warning::scale(Samples::Integers, sixteen, Response::new(curve));
        let text = warning.unwrap().to_string();
        assert_eq!(text.contains("larger by the same factor"), grows, "{text}");
        assert!(text.contains("light beyond 255 is used as it is"), "{text}");
    }
    for (samples, extent) in [
        (Samples::Integers, (0.0, 255.0)),
        // What shines, and night.
        (Samples::Floats, (0.0, 700.0)),
        (Samples::Floats, (0.0, 30.0)),
        (Samples::Integers, (0.0, 9.0)),
        (Samples::Video, (0.0, 1.0)),
    ] {
        assert_eq!(scaled(samples, extent), None);
    }
    let above = scaled(Samples::Floats, (0.0, 2.772)).unwrap();
    assert!(above.contains("with light above it"), "{above}");
}

#[test]
fn frames_less_than_a_microsecond_apart_are_told_of() {
    let told = |fps: u64| {
        let text = format!("pattern:bar?fps={fps}&frames=4");
        let observation = observed(open(&text, &OpenOptions::default()).unwrap());
        let mut told = Warning::of_pictures(&observation);
        told.retain(|warning| warning.about == About::SameTime);
        told.first().map(ToString::to_string)
    };
    assert_eq!([told(1000), told(1_000_000)], [None, None]);
    let text = told(10_000_000).unwrap();
    assert!(text.contains("frames are 0.100 us apart"), "{text}");
}

#[test]
fn a_scene_that_is_shown_again_is_seen_once() {
    let observation = Observation::new();
    for _ in 0..3 {
        let clip = open(&data("walk.y4m"), &OpenOptions::default()).unwrap();
        frames(Observed::new(clip, &observation));
    }
    assert_eq!(observation.frames(), 12);
    let walk = frames(open(&data("walk.y4m"), &OpenOptions::default()).unwrap());
    let all = walk.iter().flatten();
    let extent = all.fold((f64::MAX, f64::MIN), |(low, high), v| {
        (low.min(*v), high.max(*v))
    });
    assert_eq!(observation.extent(), Some(extent));
}

#[test]
fn crowds_are_counted_by_frames_and_cells() {
    use amacrine::event::{Event, Polarity};
    let mut packet = Packet::new(Size::new(1, 4), 1);
    let event = |t, x| Event {
        t: Micros(t),
        x,
        y: 0,
        polarity: Polarity::On,
        channel: 0,
    };
    // In the second interval one cell fires twice, and two others once.
    packet.events = vec![
        event(5, 0),
        event(10, 1),
        event(11, 0),
        event(12, 0),
        event(15, 1),
        event(20, 2),
    ];
    let frames = [Micros(0), Micros(10), Micros(20), Micros(30)];
    let crowd = Crowd::from_packet(&packet, &frames);
    let want = Crowd {
        cells: 4,
        frames: 4,
        over: 1,
        most: 3,
        frame: 2,
        first: 0,
    };
    // Two of four are no more than half.
    assert_eq!(crowd, want);
    let mut guard = Guard::new();
    for time in frames {
        guard.frame_at(time);
    }
    guard.packet("dvs", &packet);
    guard.packet("another", &packet);
    guard.packet("silent", &Packet::new(Size::new(1, 4), 1));
    packet.dropped.no_slot = 6;
    packet.events.truncate(2);
    guard.packet("the chip", &packet);
    let warnings = guard.warnings();
    let about: Vec<_> = warnings
        .iter()
        .map(|w| (w.about, w.subjects.len()))
        .collect();
    assert_eq!(
        about,
        [
            (About::MostCells, 2),
            (About::NoEvents, 1),
            (About::Slots, 1)
        ]
    );
    let text = warnings[0].to_string();
    for words in [
        "dvs: 3 of 4 cells (75 %)",
        "frame 2",
        "another",
        "threshold",
    ] {
        assert!(text.contains(words), "{text}");
    }
    let text = warnings[2].to_string();
    assert!(text.contains("6 of 8 events (75.0 %)"), "{text}");
}

fn silence(response: Response, reach: Option<[f64; 2]>) -> Silence {
    Silence {
        response,
        reach,
        ..Silence::default()
    }
}

/// Under the authors' rule what is seen may be large, and come at no time at which a cell fires.
#[test]
fn the_guard_of_silence_knows_the_authors_rule() {
    let said = |fps: f64, light: &[f64]| {
        let text = "response = \"identity\"\nmemory = \"filtered-step\"\nrefractory = { us = 1000, rule = \"authors\" }\n[[channel]]\nkernel = [[1]]\nthreshold = { on = 10, off = 10 }\n";
        let read = |_: &str| Err(io::ErrorKind::NotFound.into());
        let description = Description::parse("s.toml", text, &read).unwrap();
        let size = Size::new(1, 1);
        let mut sensor = Reference::new(description, size, 0).unwrap();
        let mut packet = Packet::new(size, 1);
        let mut guard = Guard::new();
        for (index, light) in (0..).zip(light) {
            let frame = Frame {
                index,
                seconds: index as f64 / fps,
                light: Plane::from_elem((1, 1), *light).into(),
            };
            sensor.watch(&frame, &mut packet).unwrap();
            guard.frame(&frame);
        }
        guard.packet_of("s", &packet, &sensor.silence());
        let warnings = guard.warnings();
        let silent = warnings.iter().find(|it| it.about == About::NoEvents);
        (sensor.report().muted_pairs, silent.map(ToString::to_string))
    };
    let moves = [0.0, 100.0, 0.0, 100.0, 50.0, 20.0, 90.0];
    // Frames one period apart, whatever rounding makes of n / fps.
    for fps in [1000.0, 1001.0, 3000.0] {
        let (muted, text) = said(fps, &moves);
        let text = text.unwrap();
        assert_eq!(muted, 6, "{fps}");
        assert!(
            text.contains("the frame interval is not longer than the refractory period"),
            "{text}"
        );
        assert!(!text.contains("lower the threshold"), "{text}");
    }
    // Further apart they fire, if only just.
    for fps in [999.0, 500.0] {
        assert_eq!(said(fps, &moves), (0, None), "{fps}");
    }
    // Crossed once at 2/3 of a pair, and the period is 0.9 of it: the cell waits for a second crossing.
    let (muted, text) = said(900.0, &[0.0, 15.0, 15.0, 15.0]);
    let text = text.unwrap();
    assert_eq!(muted, 0);
    assert!(
        text.contains("where rule = \"authors\" allows no event\nhelp: shorten refractory.us"),
        "{text}"
    );
}

/// A cell that crosses a threshold without a sign is not one that sees too little.
#[test]
fn the_guard_of_silence_knows_crossings_without_a_sign() {
    let unsigned = Silence {
        without_sign: 8,
        ..silence(Response::IDENTITY, Some([1.0, 255.0]))
    };
    let text = Warning::no_events_of("s", 4, &unsigned).to_string();
    assert!(
        text.contains("its cells cross thresholds (8 crossings), but emit nothing"),
        "{text}"
    );
    assert!(!text.contains("never changes"), "{text}");
}

/// Thresholds beyond what the response makes of any light are told of as such.
#[test]
fn the_guard_of_silence_knows_what_light_reaches() {
    let said = |response: &str, thresholds: &[&str]| {
        let kind =
            |on| format!("[[channel]]\nkernel = \"dvs\"\nthreshold = {{ on = {on}, off = 9 }}\n");
        let kinds: String = thresholds.iter().map(kind).collect();
        let text = format!("response = {response}\nmemory = \"filtered-step\"\n{kinds}");
        let read = |_: &str| Err(io::ErrorKind::NotFound.into());
        let sensor = Description::parse("s.toml", &text, &read).unwrap();
        Warning::no_events_of("s", 9, &silence(sensor.response, sensor.reach())).to_string()
    };
    let linear = said("{ linear = 255 }", &["1.5"]);
    assert!(
        linear.contains("its lowest threshold, 1.5, is out of reach: for light from 0 to 255 the response is 0 to 1, and the filtered signal changes by 1 at most\nhelp: give thresholds in the unit of the response, or response = \"identity\""),
        "{linear}"
    );
    let log = said("{ log = { white = 255, offset = 0.001 } }", &["7"]);
    assert!(log.contains("is -6.9078 to 0.001, and"), "{log}");
    let beyond = said("\"identity\"", &["300"]);
    assert!(
        !beyond.contains("is out of reach"),
        "OFF is within: {beyond}"
    );
    let blind = Warning::no_events_of("s", 9, &silence(Response::IDENTITY, Some([9.0, 0.0])));
    let blind = blind.to_string();
    assert!(
        blind.contains("all weights of its kernels are 0"),
        "{blind}"
    );
    for response in ["{ linear = 255 }", "\"identity\""] {
        let one = said(response, &["0.9", "1.5"]);
        assert!(
            one.contains("the filtered signal never changes by a whole threshold"),
            "{one}"
        );
    }
    let one = silence(Response::IDENTITY, Some([9.0, 1.0]));
    let still = Warning::no_events_of("s", 1, &one).to_string();
    assert!(still.contains("a change between two frames"), "{still}");
}

#[cfg(feature = "cli")]
mod common;

#[cfg(feature = "cli")]
mod verbs {
    use amacrine::event::{Event, Polarity, file::write};
    use serde_json::{Value, json};

    use super::{
        common::{amacrine, good, line, refused},
        *,
    };

    /// What is said to machines, and beside it.
    #[track_caller]
    fn both(folder: &Path, arguments: &[&str]) -> (Value, String) {
        let all = [arguments, &["--json"]].concat();
        let said = amacrine(folder, &all).output().unwrap();
        assert!(said.status.success(), "{}", line(&said.stderr));
        let json = serde_json::from_slice(&said.stdout).unwrap();
        (json, line(&said.stderr))
    }

    /// What the warnings are about.
    fn about(json: &Value) -> Vec<String> {
        let warnings = json["warnings"].as_array().expect("warnings");
        for warning in warnings {
            for part in ["seen", "why", "change"] {
                assert!(!warning[part].as_str().unwrap().is_empty(), "{warning}");
            }
        }
        let about = |w: &Value| w["about"].as_str().unwrap().to_owned();
        warnings.iter().map(about).collect()
    }

    const SIZE: Size = Size::new(24, 32);

    /// A bar that moves, as light from 0 to `white`.
    fn bar(white: f64) -> Vec<Vec<f64>> {
        let spec = "pattern:bar?width=32&height=24&frames=8&speed=400&low=30&high=220";
        let lights = frames(open(spec, &OpenOptions::default()).unwrap());
        let scaled = |light: &Plane<f64>| light.iter().map(|v| v / 255.0 * white).collect();
        lights.iter().map(scaled).collect()
    }

    fn folder() -> TempDir {
        let folder = TempDir::new().unwrap();
        let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
        write("dvs.toml", include_bytes!("../sensors/dvs.toml"));
        write("snap.scamp", include_bytes!("../programs/dvs/snap.scamp"));
        write("unit.npy", &doubles(SIZE, &bar(1.0)));
        write("full.npy", &doubles(SIZE, &bar(255.0)));
        let lit = |level: f64| vec![level; SIZE.pixels()];
        write(
            "lamp.npy",
            &doubles(SIZE, &[lit(20.0), lit(200.0), lit(20.0), lit(200.0)]),
        );
        write("still.npy", &doubles(SIZE, &vec![bar(255.0).remove(0); 5]));
        let luma = |v: &f64| (16.0 + v * 219.0 / 255.0).round() as u8;
        let coded: Vec<Vec<u8>> = bar(255.0)
            .iter()
            .map(|frame| frame.iter().map(luma).collect())
            .collect();
        write(
            "limited.y4m",
            &y4m(SIZE, "Cmono XCOLORRANGE=LIMITED", &coded),
        );
        folder
    }

    const VERBS: [&[&str]; 6] = [
        &["run", "--sensor", "dvs.toml", "--scene"],
        &["exec", "snap.scamp", "--image"],
        &[
            "quantise",
            "csdvs-3",
            "--to",
            "ternary",
            "--threshold",
            "20",
            "--effort",
            "0.01",
            "--scene",
        ],
        &[
            "waterfall",
            "csdvs-3",
            "--threshold",
            "20",
            "--effort",
            "0.01",
            "--scene",
        ],
        &[
            "feasibility",
            "--kernel",
            "csdvs-3",
            "--threshold",
            "20",
            "--effort",
            "0.01",
            "--to",
            "ternary",
            "--candidates",
            "ternary",
            "--scene",
        ],
        &["plan", "--sensor", "dvs.toml", "--scene"],
    ];

    #[test]
    fn every_verb_says_what_light_it_showed() {
        let folder = folder();
        let stated = "light    limited range (said by the file) expanded to 0..255, foot- and headroom clipped, transfer as coded\n";
        let asked = "light    full range (as asked), transfer srgb undone\n";
        for verb in VERBS {
            let with = |more: &[&'static str]| [verb, &["limited.y4m"], more].concat();
            let said = good(folder.path(), &with(&[]));
            assert!(said.contains(stated), "{said}");
            let said = good(
                folder.path(),
                &with(&["--range", "full", "--transfer", "srgb"]),
            );
            assert!(said.contains(asked), "{said}");
            let (json, _) = both(folder.path(), &with(&[]));
            let light = &json["light"];
            assert_eq!(
                (&light["range"], &light["range_from"], &light["transfer"]),
                (&json!("limited"), &json!("file"), &json!("as-coded")),
                "{verb:?}"
            );
            refused(
                folder.path(),
                &with(&["--scale", "255"]),
                &["only the numbers of an array"],
            );
        }
        let said = good(
            folder.path(),
            &[
                "mesh",
                "step",
                "--lambda",
                "2",
                "--tau",
                "0us",
                "--scene",
                "limited.y4m",
                "-o",
                "h.npy",
            ],
        );
        assert!(said.contains(stated), "{said}");
    }

    /// The page of a feasibility can be made again.
    #[test]
    fn the_command_of_a_report_has_the_options() {
        let folder = folder();
        let all = [
            VERBS[4],
            &["unit.npy", "--scale", "255", "--transfer", "bt709"],
        ]
        .concat();
        let (json, _) = both(folder.path(), &all);
        let command = json["command"].as_str().unwrap();
        assert!(
            command.contains(" --transfer bt709 --scale 255 "),
            "{command}"
        );
    }

    /// Arrays and pictures state no frame rate; every verb says which one it took.
    #[test]
    fn a_frame_rate_that_nobody_said_is_told() {
        let folder = folder();
        let assumed = "fps      240 frames/s (assumed; --fps says otherwise)\n";
        for verb in VERBS {
            let all = [verb, &["full.npy"]].concat();
            let said = good(folder.path(), &all);
            assert!(said.contains(assumed), "{said}");
            let (json, _) = both(folder.path(), &all);
            assert_eq!(json["light"]["assumed_fps"], 240.0, "{verb:?}");
            let all = [verb, &["full.npy", "--fps", "240"]].concat();
            let said = good(folder.path(), &all);
            assert!(!said.contains("assumed"), "{said}");
        }
        let study = "scene = \"full.npy\"\nkernel = \"csdvs-3\"\nthreshold = 20\n[[side]]\nside = \"reference\"\n";
        fs::write(folder.path().join("study.toml"), study).unwrap();
        let sweep = |more: &[&str]| {
            let all = [&["sweep", "study.toml"], more].concat();
            line(&amacrine(folder.path(), &all).output().unwrap().stderr)
        };
        let said = sweep(&["-o", "a"]);
        assert!(said.contains("240 frames/s are assumed"), "{said}");
        let said = sweep(&["fps=240", "-o", "b"]);
        assert!(!said.contains("assumed"), "{said}");
        assert!(!said.contains("it ends after"), "{said}");
        let said = sweep(&["fps=240", "frames=500", "-o", "c"]);
        assert!(said.contains("it ends after"), "{said}");
    }

    #[test]
    fn an_array_of_0_to_1_is_told_of_loudly() {
        let folder = folder();
        for verb in &VERBS[..5] {
            // A waterfall of nothing is an error; the warning comes before it.
            let all = [*verb, &["unit.npy"]].concat();
            let said = amacrine(folder.path(), &all).output().unwrap();
            let beside = line(&said.stderr);
            for words in [
                "warning: the scene: all light lies between 0.",
                "--scale 255",
            ] {
                assert!(beside.contains(words), "{verb:?}: {beside}");
            }
            let all = [*verb, &["unit.npy", "--scale", "255"]].concat();
            let (json, beside) = both(folder.path(), &all);
            assert!(!about(&json).contains(&"scale".to_owned()), "{json}");
            assert!(!beside.contains("all light lies"), "{beside}");
            assert_eq!(json["light"]["scale"], 255.0);
        }
        let run = |more: &[&str]| both(folder.path(), &[VERBS[0], more].concat());
        let (json, beside) = run(&["unit.npy"]);
        assert_eq!(json["events"], 0);
        assert_eq!(about(&json), ["scale", "no-events"]);
        assert!(beside.contains("no event at all in 8 frames"), "{beside}");
        let (scaled, _) = run(&["unit.npy", "--scale", "255"]);
        let (full, _) = run(&["full.npy"]);
        assert!(full["events"].as_u64().unwrap() > 50);
        assert_eq!(scaled["events"], full["events"]);
        assert_eq!(about(&full), Vec::<String>::new());
        let said = good(folder.path(), &[VERBS[0], &["full.npy"]].concat());
        assert!(
            said.contains("light    numbers as given, transfer as coded; from 30"),
            "{said}"
        );
        // A sensor whose white is 1 is shown what it expects.
        let text = include_str!("../sensors/dvs.toml").replace(
            "{ lin-log = { knee = 20 } }",
            "{ log = { white = 1, offset = 1e-3 } }",
        );
        fs::write(folder.path().join("one.toml"), text).unwrap();
        let (json, _) = both(
            folder.path(),
            &["run", "--sensor", "one.toml", "--scene", "unit.npy"],
        );
        assert!(!about(&json).contains(&"scale".to_owned()), "{json}");
        assert!(json["events"].as_u64().unwrap() > 50);
    }

    /// What small light does to the signal is told of the response at hand.
    #[test]
    fn the_guard_of_scale_knows_the_response() {
        let said = |curve: Curve, extent| {
            let warning = Warning::scale(Samples::Floats, Some(extent), Response::new(curve));
            warning.map(|warning| warning.to_string())
        };
        let whole = said(Curve::Identity, (0.0, 1.0)).unwrap();
        assert!(
            whole.contains("changes by 1, and with light times 255 by 255\nhelp: give --scale 255")
        );
        let offset = 1e-5;
        let log = Curve::Log {
            white: 255.0,
            offset,
        };
        // Far above its offset a logarithm moves as much on any scale.
        let far = said(log, (0.1, 1.0)).unwrap();
        assert!(
            far.contains("changes by 2.28, and with light times 255 by 2.3025: under a logarithm"),
            "{far}"
        );
        assert!(!far.contains("threshold"));
        let near = said(log, (0.0, 1.0)).unwrap();
        assert!(
            near.contains("changes by 5.9742, and with light times 255 by 11.513"),
            "{near}"
        );
        // Below its knee it is a straight line.
        let below = said(Curve::LinLog { knee: 20.0 }, (0.0, 1.0)).unwrap();
        assert!(
            below.contains("changes by 0.14979, and with light times 255 by 5.5413\n"),
            "{below}"
        );
        let hundred = said(Curve::Linear { white: 100.0 }, (0.0, 1.0)).unwrap();
        assert!(hundred.contains("the sensor takes 0 to 100") && hundred.contains("--scale 100"));
        assert_eq!(said(Curve::Linear { white: 1.0 }, (0.0, 1.0)), None);
        assert_eq!(said(Curve::Identity, (0.0, 9.0)), None);
    }

    #[test]
    fn the_guard_of_silence() {
        let folder = folder();
        for verb in [VERBS[0], VERBS[1], VERBS[2], VERBS[4]] {
            let (json, beside) = both(folder.path(), &[verb, &["still.npy"]].concat());
            assert!(about(&json).contains(&"no-events".to_owned()), "{json}");
            assert!(beside.contains("no event at all in"), "{verb:?}: {beside}");
        }
        // A clip of 1000 frames/s, of whose 71 pairs rounding puts some a little above the period of 1 ms.
        let close = ["run", "--sensor", "authors/dvs", "--fps", "1000", "--scene"];
        let (json, beside) = both(folder.path(), &[&close[..], &["bundled"]].concat());
        assert_eq!(json["events"], 0);
        assert_eq!(json["pairs_shorter_than_authors_refractory"], 71);
        assert!(
            beside.contains("longer than the refractory period"),
            "{beside}"
        );
        assert!(!beside.contains("the light changes too little"), "{beside}");
        let said = good(folder.path(), &[&close[..], &["bundled"]].concat());
        assert!(
            said.contains("note     71 frame pairs are not further apart than"),
            "{said}"
        );
        let unsigned = "response = \"identity\"\nmemory = \"raw-snap\"\npolarity = \"pixel\"\nborder = \"zero\"\n[[channel]]\nkernel = [[1, 0, 0]]\nthreshold = { on = 1, off = 1 }\n";
        fs::write(folder.path().join("unsigned.toml"), unsigned).unwrap();
        let mut edge = vec![0.0; SIZE.pixels()];
        edge.iter_mut()
            .step_by(SIZE.width)
            .for_each(|light| *light = 100.0);
        let dark = vec![0.0; SIZE.pixels()];
        fs::write(folder.path().join("edge.npy"), doubles(SIZE, &[dark, edge])).unwrap();
        let run = [
            "run",
            "--sensor",
            "unsigned.toml",
            "--scene",
            "edge.npy",
            "--fps",
            "10",
        ];
        let (json, beside) = both(folder.path(), &run);
        assert_eq!(json["without_sign"], SIZE.height);
        assert!(
            beside.contains("(24 crossings), but emit nothing"),
            "{beside}"
        );
        let still = [VERBS[3], &["still.npy"]].concat();
        refused(folder.path(), &still, &["no event", "0 to 255"]);
        fs::write(folder.path().join("none.csv"), "t,x,y,p\n").unwrap();
        fs::write(folder.path().join("some.csv"), "t,x,y,p\n10,1,1,1\n").unwrap();
        let (json, beside) = both(folder.path(), &["compare", "some.csv", "none.csv"]);
        assert_eq!(about(&json), ["no-events"]);
        assert!(
            beside.contains("warning: the judged: no event at all"),
            "{beside}"
        );
        let (json, _) = both(folder.path(), &["compare", "some.csv", "some.csv"]);
        assert!(!about(&json).contains(&"no-events".to_owned()), "{json}");
    }

    /// Two kernels that differ: a still scene fires, and one warning says why.
    #[test]
    fn the_guard_of_still_scenes() {
        let folder = folder();
        let text = "response = { linear = 255 }\nmemory = \"authors-pixel-step\"\n[[channel]]\nkernel = [[1.0]]\nmemory-kernel = [[0.9]]\nthreshold = { on = 0.01, off = 0.01 }\n";
        fs::write(folder.path().join("two.toml"), text).unwrap();
        fs::write(folder.path().join("one.toml"), text.replace("0.9", "1.0")).unwrap();
        let run = |sensor| {
            both(
                folder.path(),
                &["run", "--sensor", sensor, "--scene", "still.npy"],
            )
        };
        let (json, beside) = run("two.toml");
        assert!(json["events"].as_u64().unwrap() > 0);
        assert!(about(&json).contains(&"still".to_owned()), "{json}");
        let words = "(W - W_m) * u, up to 0.1 for light from 0 to 255, and the threshold is 0.01";
        assert!(beside.contains(words), "{beside}");
        assert_eq!(beside.matches("cells fire on a still scene").count(), 1);
        let (json, _) = run("one.toml");
        assert_eq!(json["events"], 0);
        assert!(!about(&json).contains(&"still".to_owned()), "{json}");
    }

    /// Seconds in the place of microseconds.
    #[test]
    fn a_refractory_period_below_a_microsecond_is_told() {
        let folder = folder();
        for (us, told) in [("0.001", true), ("0", false), ("1", false), ("1000", false)] {
            let text = format!(
                "response = {{ linear = 255 }}\nmemory = \"filtered-step\"\nrefractory = {{ us = {us} }}\n[[channel]]\nkernel = \"dvs\"\nthreshold = {{ on = 0.2, off = 0.2 }}\n"
            );
            fs::write(folder.path().join("quick.toml"), text).unwrap();
            let (json, beside) = both(
                folder.path(),
                &["run", "--sensor", "quick.toml", "--scene", "still.npy"],
            );
            let known = about(&json).contains(&"refractory".to_owned());
            assert_eq!(known, told, "{us}: {json}");
            let words =
                "a refractory period of 0.001 us: it is shorter than the time resolution of 1 us";
            assert_eq!(beside.contains(words), told, "{us}: {beside}");
        }
    }

    #[test]
    fn kinds_of_other_names_are_told_when_they_are_compared() {
        let folder = folder();
        for (name, kinds) in [("one.npz", ["on", "edge"]), ("other.npz", ["edge", "on"])] {
            let mut packet = Packet::new(Size::new(4, 4), 2);
            packet.names = kinds.map(str::to_owned).to_vec();
            packet.events = (0..20)
                .map(|n| Event {
                    t: Micros(100 * n),
                    x: 1,
                    y: 2,
                    polarity: Polarity::On,
                    channel: (n % 2) as u8,
                })
                .collect();
            write(&folder.path().join(name), &packet).unwrap();
        }
        let (json, beside) = both(folder.path(), &["compare", "one.npz", "other.npz"]);
        assert!(about(&json).contains(&"names".to_owned()), "{json}");
        let said = "the judged: kind 0 is `edge`, but `on` in the reference";
        assert!(beside.contains(said), "{beside}");
        let (json, _) = both(folder.path(), &["compare", "one.npz", "one.npz"]);
        assert!(!about(&json).contains(&"names".to_owned()), "{json}");
    }

    #[test]
    fn the_guard_of_crowds() {
        let folder = folder();
        for verb in [VERBS[0], VERBS[1]] {
            let (json, beside) = both(folder.path(), &[verb, &["lamp.npy"]].concat());
            assert!(about(&json).contains(&"most-cells".to_owned()), "{json}");
            assert!(beside.contains("768 of 768 cells (100 %)"), "{beside}");
            let (json, _) = both(folder.path(), &[verb, &["full.npy"]].concat());
            assert!(!about(&json).contains(&"most-cells".to_owned()), "{json}");
        }
    }

    #[test]
    fn the_guard_of_slots() {
        let folder = folder();
        let exec = |slots| {
            let all = [VERBS[1], &["full.npy", "--const", slots]].concat();
            both(folder.path(), &all)
        };
        let (json, beside) = exec("slots=2");
        assert!(about(&json).contains(&"slots".to_owned()), "{json}");
        assert!(beside.contains("slots were full"), "{beside}");
        let (json, _) = exec("slots=4000");
        assert!(!about(&json).contains(&"slots".to_owned()), "{json}");
    }

    #[test]
    fn the_guard_of_saturation() {
        let folder = folder();
        // Half of A is too large to be doubled.
        let a = Plane::from_shape_fn((4, 6), |(_, x)| if x < 3 { 100.0 } else { 20.0 });
        ndarray_npy::write_npy(folder.path().join("a.npy"), &a).unwrap();
        fs::write(folder.path().join("p.scamp"), "mov(C, A);\nadd(B, A, C);\n").unwrap();
        let exec = |domain| {
            let all = ["exec", "p.scamp", "--set", "A=a.npy", "--domain", domain];
            both(folder.path(), &all)
        };
        let (json, beside) = exec("q8.8");
        assert_eq!(about(&json), ["saturation"]);
        assert!(beside.contains("12 of 24 values (50 %) in B"), "{beside}");
        assert_eq!(about(&exec("q16.16").0), Vec::<String>::new());
        // What has no end itself is held to the chip's.
        let (json, beside) = exec("exact");
        assert_eq!(about(&json), ["saturation"]);
        assert!(beside.contains("the chip does not"), "{beside}");
        let text = include_str!("../sensors/dvs.toml")
            .replace("{ lin-log = { knee = 20 } }", "\"identity\"")
            .replace("0.2", "20");
        fs::write(folder.path().join("plain.toml"), text).unwrap();
        let run = |format| {
            let all = [
                "run",
                "--sensor",
                "plain.toml",
                "--scene",
                "full.npy",
                "--format",
                format,
            ];
            both(folder.path(), &all)
        };
        let (json, beside) = run("q8.8");
        assert_eq!(about(&json), ["saturation"]);
        assert!(beside.contains("the range of q8.8"), "{beside}");
        assert_eq!(about(&run("f64").0), Vec::<String>::new());
    }

    /// A sensor of one kernel, of light from 0 to 1.
    fn of_kernel(folder: &Path, kernel: &str, threshold: f64) {
        let text = format!(
            "response = {{ linear = 255 }}\nmemory = \"filtered-step\"\n[[channel]]\nkernel = {kernel}\nthreshold = {{ on = {threshold}, off = {threshold} }}\n"
        );
        fs::write(folder.join("own.toml"), text).unwrap();
    }

    fn in_format(folder: &Path, sensor: &str, scene: &str, format: &str) -> (Value, String) {
        let all = [
            "run", "--sensor", sensor, "--scene", scene, "--format", format,
        ];
        both(folder, &all)
    }

    /// Light within a format whose drives are not: cut off, come in at the other end, or cut off on the
    /// way.
    #[test]
    fn the_guard_of_drives() {
        let folder = folder();
        let at = folder.path();
        let run = |format| in_format(at, "own.toml", "full.npy", format);
        for kernel in ["[[100, 100, 100]]", "[[100, 100, -100]]"] {
            of_kernel(at, kernel, 10.0);
            let (json, beside) = run("q8.8");
            assert_eq!(about(&json), ["saturation"], "{kernel}");
            for words in [
                "of the drives (kernel times signal)",
                "leave the range of q8.8, -128 to 127.99609375",
                "are clipped",
            ] {
                assert!(beside.contains(words), "{beside}");
            }
            for format in ["f64", "f16", "q16.16"] {
                assert_eq!(about(&run(format).0), Vec::<String>::new(), "{format}");
            }
        }
        of_kernel(at, "[[100, 100, 100]]", 10.0);
        let (json, beside) = run("q8.8-wrap");
        assert_eq!(about(&json), ["saturation"]);
        assert!(beside.contains("wrap around"), "{beside}");
        // As large as the format holds.
        of_kernel(at, "[[127]]", 10.0);
        assert_eq!(about(&run("q8.8").0), Vec::<String>::new());
        // Resistor sheets give their drive as it is.
        let mesh = "response = \"identity\"\nmemory = \"filtered-step\"\n[[channel]]\nmesh = { centre = 2, sheets = [{ gain = 1, lambda = 1 }] }\nthreshold = { on = 20, off = 20 }\n";
        fs::write(at.join("mesh.toml"), mesh).unwrap();
        let run = |format| in_format(at, "mesh.toml", "full.npy", format);
        assert_eq!(about(&run("q9.7").0), ["saturation"]);
        assert_eq!(about(&run("q16.16").0), Vec::<String>::new());
    }

    /// Weights that a format rounds to another kernel, told before what comes of it.
    #[test]
    fn the_guard_of_rounded_kernels() {
        let folder = folder();
        let at = folder.path();
        of_kernel(at, "[[0.001]]", 0.0005);
        let (json, beside) = in_format(at, "own.toml", "full.npy", "q8.8");
        assert_eq!(json["events"], 0);
        assert_eq!(about(&json), ["rounded", "no-events"]);
        assert!(
            beside.contains(
                "in q8.8 its weight is 0: the largest is 0.001, the smallest step 0.0039"
            ),
            "{beside}"
        );
        // No lower threshold brings the kernel back.
        assert!(!beside.contains("lower the threshold"), "{beside}");
        assert!(
            beside.contains("more bits after the point, or scale weights (gain)"),
            "{beside}"
        );
        let (json, _) = in_format(at, "own.toml", "full.npy", "q8.24");
        assert!(json["events"].as_u64().unwrap() > 0);
        assert_eq!(about(&json), Vec::<String>::new());
        of_kernel(at, "[[200]]", 10.0);
        let (json, beside) = in_format(at, "own.toml", "full.npy", "q8.8");
        assert_eq!(about(&json), ["rounded"]);
        assert!(
            beside.contains("its weight, 200, lies beyond the range of q8.8, -128 to 127.99609375"),
            "{beside}"
        );
        // A difference of Gaussians whose tail is gone sees uniform light.
        let (json, beside) = in_format(at, "dog", "lamp.npy", "q8.8");
        assert!(about(&json).contains(&"rounded".to_owned()), "{json}");
        assert!(
            beside.contains("in q8.8 100 of 169 weights are 0"),
            "{beside}"
        );
        for format in ["f64", "f32", "f16", "q4.12", "q8.24"] {
            let (json, _) = in_format(at, "dog", "lamp.npy", format);
            assert!(
                !about(&json).contains(&"rounded".to_owned()),
                "{format} {json}"
            );
        }
    }

    #[test]
    fn a_sweep_takes_the_options_and_warns() {
        let folder = folder();
        let sweep = |name: &str, text: &str| -> Vec<Value> {
            let study = format!(
                "scene = \"limited.y4m\"\nkernel = \"dvs\"\n{text}\n[[side]]\nside = \"reference\"\n"
            );
            fs::write(folder.path().join(format!("{name}.toml")), study).unwrap();
            good(folder.path(), &["sweep", &format!("{name}.toml")]);
            let lines = fs::read_to_string(folder.path().join(name).join("results.jsonl"));
            let lines = lines.unwrap();
            lines
                .lines()
                .map(|l| serde_json::from_str(l).unwrap())
                .collect()
        };
        // The bar changes the light by 190, its samples by 163.
        let plain = sweep("plain", "threshold = 175");
        // What is left out is what it is when it is said.
        let said = sweep(
            "said",
            "threshold = 175\nrange = \"auto\"\ntransfer = \"as-coded\"",
        );
        assert_eq!(plain[0]["id"], said[0]["id"]);
        let rows = sweep(
            "three",
            "threshold = 175\nrange = [\"auto\", \"full\", \"limited\"]",
        );
        // Limited is what the file says: the same light, the same point.
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0]["id"], plain[0]["id"]);
        assert_ne!(rows[0]["events"], rows[1]["events"]);
        assert_eq!(rows[1]["range"], "full");
        let silent = sweep("silent", "threshold = [20, 1000]");
        assert_eq!(
            silent[0].get("warnings").unwrap_or(&Value::Null),
            &Value::Null
        );
        assert_eq!(silent[1]["warnings"], "no-events");
    }
}
