//! Every kind of scene is read to the same light, and every bad one gets its own message.
//!
//! `tests/data/scene/walk.y4m` is 12 frames of 48x32 of the bundled clip. ffmpeg 5.1 made
//! the other clips from it, and the y4m beside each mp4 is the luma that ffmpeg decodes;
//! numpy wrote the `.npy`, Pillow the colour picture. `tests/bad/scene/` holds one file a
//! message; the table below names all of them.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use amacrine::{
    plane::Size,
    scene::{Coding, Frame, OpenOptions, Range, Scene, SceneError, bundled, open},
};
use miette::Diagnostic;
use proptest::prelude::*;

fn data(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join("tests/data/scene")
        .join(name)
        .display()
        .to_string()
}

fn read(mut scene: impl Scene) -> Result<Vec<Frame>, SceneError> {
    let mut frames = Vec::new();
    while let Some(frame) = scene.next_frame()? {
        assert_eq!(Size::of(&frame.light), scene.size());
        assert_eq!(frame.index, frames.len() as u64);
        assert_eq!(frame.seconds, frame.index as f64 / scene.fps());
        frames.push(frame);
    }
    assert!(scene.next_frame()?.is_none());
    if let Some(count) = scene.frames() {
        assert_eq!(frames.len() as u64, count);
    }
    Ok(frames)
}

fn all(name: &str) -> Vec<Frame> {
    read(open(&data(name), &OpenOptions::default()).unwrap()).unwrap()
}

/// The luma of `walk.y4m` without our reader: a text line, then 6 + 48*32 bytes a frame.
fn walk() -> Vec<Vec<f64>> {
    let bytes = fs::read(data("walk.y4m")).unwrap();
    let start = bytes.iter().position(|b| *b == b'\n').unwrap() + 1;
    bytes[start..]
        .chunks(6 + 48 * 32)
        .map(|frame| frame[6..].iter().map(|b| f64::from(*b)).collect())
        .collect()
}

#[test]
fn every_lossless_kind_gives_the_same_light() {
    let walk = walk();
    assert_eq!(walk.len(), 12);
    for (name, fps, assumed) in [
        ("walk.y4m", 10.0, false),
        ("walk.apng", 10.0, false),
        ("walk.gif", 10.0, false),
        ("pictures", 240.0, true),
    ] {
        let scene = open(&data(name), &OpenOptions::default()).unwrap();
        assert_eq!(scene.size(), Size::new(32, 48), "{name}");
        assert!((scene.fps() - fps).abs() < 1e-9, "{name}: {}", scene.fps());
        assert_eq!(scene.outline().fps_is_assumed, assumed, "{name}");
        assert_eq!(scene.frames(), Some(12), "{name}");
        let frames = read(scene).unwrap();
        for (frame, light) in frames.iter().zip(&walk) {
            let got: Vec<_> = frame.light.iter().copied().collect();
            assert!(&got == light, "{name}: frame {} differs", frame.index);
        }
    }
}

#[test]
fn stills_are_scenes_of_one_frame() {
    let first = &walk()[0];
    for name in ["still.pgm", "still16.png"] {
        let frames = all(name);
        assert_eq!(frames.len(), 1);
        let got: Vec<_> = frames[0].light.iter().copied().collect();
        assert_eq!(&got, first, "{name}");
    }
}

#[test]
fn colour_is_weighed_by_rec_601_and_lies_on_black() {
    let light = &all("colour.png")[0].light;
    // The planes of the same picture: red, green, blue, alpha.
    let rgba = all("colour_rgba.npy");
    for (at, got) in light.indexed_iter() {
        let [r, g, b, a] = [0, 1, 2, 3].map(|n: usize| rgba[n].light[at]);
        let want = (0.299 * r + 0.587 * g + 0.114 * b) * a / 255.0;
        assert!((got - want).abs() < 1e-9);
    }
}

#[test]
fn numbers_are_used_as_given_in_every_type() {
    let walk = walk();
    for name in ["u1", "u2", "i2", "i4", "f4", "f8", "i2_big"] {
        let frames = all(&format!("{name}.npy"));
        assert_eq!(frames.len(), 4, "{name}");
        for (frame, light) in frames.iter().zip(&walk) {
            for ((y, x), got) in frame.light.indexed_iter() {
                assert_eq!(*got, light[y * 48 + x], "{name}");
            }
        }
    }
}

#[test]
fn the_caller_rate_comes_first() {
    let options = OpenOptions {
        fps: Some(33.0),
        ..OpenOptions::default()
    };
    for name in [
        "walk.y4m",
        "walk.apng",
        "walk.gif",
        "pictures",
        "u1.npy",
        "still.pgm",
    ] {
        let scene = open(&data(name), &options).unwrap();
        assert_eq!(
            (scene.fps(), scene.outline().fps_is_assumed),
            (33.0, false),
            "{name}"
        );
        assert_eq!(
            read(scene).unwrap().len() as u64,
            read(open(&data(name), &options).unwrap()).unwrap().len() as u64
        );
    }
    // Uneven delays and missing rates are no matter then.
    let bad = |name: &str| open(&bad(name).display().to_string(), &options).unwrap();
    assert_eq!(read(bad("uneven.gif")).unwrap().len(), 5);
    assert_eq!(read(bad("no_rate.y4m")).unwrap().len(), 1);
    for fps in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = OpenOptions {
            fps: Some(fps),
            ..OpenOptions::default()
        };
        let error = open(&data("walk.y4m"), &options).err().unwrap();
        assert!(error.to_string().contains("is no rate"));
    }
}

/// Against `FFmpeg`'s decoder, bit for bit: the same pictures in the order of time, their luma as it
/// is coded. `direct.mp4` is predicted from the motion of later frames (x264's `direct=temporal`),
/// `deep.mp4` has 10 bits and colour in 4:2:2.
#[cfg(feature = "mp4")]
#[test]
fn h264_is_what_ffmpeg_decodes() {
    let coded = OpenOptions {
        coding: Coding {
            range: Some(Range::Full),
            ..Coding::default()
        },
        ..OpenOptions::default()
    };
    for (name, frames) in [
        ("baseline", 12),
        ("bframes", 12),
        ("direct", 16),
        ("deep", 8),
    ] {
        let scene = open(&data(&format!("{name}.mp4")), &coded).unwrap();
        assert!((scene.fps() - 10.0).abs() < 1e-9);
        assert_eq!(scene.frames(), Some(frames));
        let got = read(scene).unwrap();
        let want = all(&format!("{name}.y4m"));
        assert_eq!(got.len(), want.len(), "{name}");
        for (got, want) in got.iter().zip(&want) {
            assert_eq!(*got.light, *want.light, "{name}: frame {}", got.index);
        }
    }
}

/// `cut.mp4` is `bframes.mp4` through `ffmpeg -ss 0.45 -c copy`: all of its samples, and an edit list
/// that shows the pictures from 0.5 s on.
#[cfg(feature = "mp4")]
#[test]
fn what_an_edit_list_leaves_out_is_not_shown() {
    let whole = open(&data("bframes.mp4"), &OpenOptions::default()).unwrap();
    let whole = read(whole).unwrap();
    let cut = open(&data("cut.mp4"), &OpenOptions::default()).unwrap();
    assert_eq!((cut.frames(), cut.fps()), (Some(7), 10.0));
    let cut = read(cut).unwrap();
    assert_eq!(cut.len(), 7);
    for (n, (shown, frame)) in cut.iter().zip(&whole[5..]).enumerate() {
        assert_eq!((shown.index, shown.seconds), (n as u64, n as f64 / 10.0));
        assert_eq!(*shown.light, *frame.light, "{n}");
    }
}

/// Kinds of names that are no single file say what to give.
#[test]
fn what_is_no_single_file_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "x").unwrap();
        path.display().to_string()
    };
    let within = |name: &str| folder.path().join(name).display().to_string();
    let picture = put("pictures/a.jpg");
    let pictures = within("pictures");
    for (scene, help) in [
        ("-".to_owned(), "write it into a file first".to_owned()),
        (within("f%03d.png"), "give the folder".to_owned()),
        (within("*.png"), "give the folder".to_owned()),
        (put("a.npz"), "np.load(FILE)[NAME]".to_owned()),
        (put("a.tif"), "tifffile.imread".to_owned()),
        (put("a.yuv"), "-s WIDTHxHEIGHT -r FPS".to_owned()),
        (
            put("a.mkv"),
            "ffmpeg -i FILE -pix_fmt gray clip.y4m".to_owned(),
        ),
        (pictures.clone(), format!("-i '{pictures}/*.jpg'")),
    ] {
        let error = open(&scene, &OpenOptions::default()).err().unwrap();
        let told = error.help().unwrap().to_string();
        assert!(told.contains(&help), "{scene}: {told}");
    }
    fs::remove_file(picture).unwrap();
}

/// Clips that end inside the word FRAME, and frames of mixed fields, which ffmpeg does not read.
#[test]
fn a_y4m_that_is_cut_or_mixed_is_told_as_that() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.y4m");
    let name = path.display().to_string();
    let whole = b"YUV4MPEG2 W1 H1 F25:1 Cmono\nFRAME\n1FRAME\n2";
    for end in whole.len() - 6..whole.len() - 1 {
        fs::write(&path, &whole[..end]).unwrap();
        let error = read(open(&name, &OpenOptions::default()).unwrap()).unwrap_err();
        let told = error.to_string();
        assert!(told.contains("ends inside frame 1"), "{end}: {told}");
    }
    fs::write(&path, b"YUV4MPEG2 W1 H1 F25:1 Im Cmono\nFRAME\n1").unwrap();
    let error = open(&name, &OpenOptions::default()).err().unwrap();
    let help = error.help().unwrap().to_string();
    assert!(help.contains("the video that it was made from"), "{help}");
}

/// A PNM of several pictures would be a clip of one frame.
#[test]
fn a_pnm_is_one_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pnm");
    let name = path.display().to_string();
    for one in [
        &b"P5 1 1 255\n\x07"[..],
        b"P6 1 1 255\n\x07\x07\x07",
        b"P2 1 1 255\n7\n",
    ] {
        fs::write(&path, [one, b"\n \n"].concat()).unwrap();
        let frames = read(open(&name, &OpenOptions::default()).unwrap()).unwrap();
        assert!((frames[0].light[(0, 0)] - 7.0).abs() < 1e-12);
        for (behind, words) in [(one, "another picture"), (&b"x"[..], "no part of it")] {
            fs::write(&path, [one, behind].concat()).unwrap();
            let opened = open(&name, &OpenOptions::default());
            let told = opened.and_then(read).unwrap_err().to_string();
            assert!(told.contains(words), "{one:?}: {told}");
        }
    }
}

#[cfg(not(feature = "mp4"))]
#[test]
fn without_the_feature_mp4_is_refused_by_name() {
    let error = open(&data("baseline.mp4"), &OpenOptions::default())
        .err()
        .unwrap();
    assert!(error.to_string().contains("feature \"mp4\""), "{error}");
}

/// The hash was computed from the y4m that the clip was packed from.
#[test]
fn the_bundled_clip_is_the_y4m_to_the_bit() {
    let scene = bundled().unwrap();
    assert_eq!((scene.size(), scene.fps()), (Size::new(256, 256), 10.0));
    let frames = read(scene).unwrap();
    assert_eq!(frames.len(), 72);
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for light in frames.iter().flat_map(|frame| &frame.light) {
        assert_eq!(light.fract(), 0.0);
        hash = (hash ^ *light as u64).wrapping_mul(0x0100_0000_01b3);
    }
    assert_eq!(hash, 0xeeb2_bb62_8b76_e779);
    let bytes =
        fs::metadata(Path::new(env!("CARGO_MANIFEST_DIR")).join("clips/vtest_256x256.apng"));
    assert!(bytes.unwrap().len() < 2_000_000);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever a damaged file says, it is read or refused, never a panic.
    #[test]
    fn damaged_files_are_read_or_refused(
        name in prop::sample::select(vec!["walk.y4m", "walk.gif", "walk.apng", "f4.npy", "still16.png", "still.pgm", "colour.png"]),
        cut in 0.5_f64..1.0,
        flips in prop::collection::vec((0.0_f64..1.0, any::<u8>()), 0..6),
    ) {
        let mut bytes = fs::read(data(name)).unwrap();
        bytes.truncate((bytes.len() as f64 * cut).ceil() as usize);
        for (place, value) in flips {
            // Squared: headers are hit more often.
            let place = (bytes.len() as f64 * place * place) as usize;
            bytes[place] = value;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let _ = open(&path.display().to_string(), &OpenOptions::default()).and_then(read);
    }
}

fn bad(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/bad/scene")
        .join(name)
}

/// File, what the message must say, what the help must say.
const BAD: &[(&str, &str, &str)] = &[
    ("missing.y4m", "No such file", "exists"),
    ("empty.y4m", "no byte in it", "at least one frame"),
    ("no_frame.y4m", "no frame in it", "at least one frame"),
    (
        "truncated.y4m",
        "ends inside frame 1: 2 of 4 bytes",
        "cut short",
    ),
    (
        "wrong_magic.y4m",
        "name says y4m video, but the content is something else",
        "rename the file",
    ),
    (
        "is_a_png.y4m",
        "name says y4m video, but the content is a PNG",
        "rename the file",
    ),
    ("zero_size.y4m", "0x2 have no pixels", "at least 1"),
    ("absurd_size.y4m", "larger than", "damaged"),
    (
        "large_but_empty.y4m",
        "ends inside frame 0: 0 of 50331648 bytes",
        "cut short",
    ),
    (
        "no_width.y4m",
        "field W: got \"nothing\", expected a width",
        "ffmpeg",
    ),
    (
        "no_rate.y4m",
        "how many frames there are per second",
        "--fps",
    ),
    ("colour_space.y4m", "colour space Crgb24", "mono, 420"),
    ("interlaced.y4m", "interlaced video (It)", "yadif"),
    (
        "damaged.y4m",
        "frame 1 begins with \"GARBAGE\", expected \"FRAME\"",
        "damaged",
    ),
    (
        "clip.avi",
        ".avi is no known kind",
        "ffmpeg -i FILE -pix_fmt gray clip.y4m",
    ),
    ("nan.npy", "frame 1, y 1, x 1: light is NaN", "np.isfinite"),
    (
        "infinite.npy",
        "frame 0, y 1, x 2: light is -inf",
        "np.isfinite",
    ),
    (
        "two_axes.npy",
        "shape (2, 3), expected three axes",
        "a[None, :, :]",
    ),
    (
        "four_axes.npy",
        "shape (2, 3, 2, 3), expected three axes",
        "gray of a clip of colour",
    ),
    ("no_frames.npy", "no frame in it", "at least one frame"),
    ("no_rows.npy", "3x0 have no pixels", "at least 1"),
    ("complex.npy", "type <c16", "astype"),
    ("fortran.npy", "Fortran order", "ascontiguousarray"),
    (
        "absurd.npy",
        "8 bytes of numbers, but the header says 2361183241434822606720000000",
        "cut short",
    ),
    ("no_shape.npy", "field shape", "write the file anew"),
    (
        "version.npy",
        "field version: got \"\\t\\x00\"",
        "write the file anew",
    ),
    (
        "truncated.npy",
        "91 bytes of numbers, but the header says 96",
        "cut short",
    ),
    (
        "too_long.npy",
        "98 bytes of numbers, but the header says 96",
        "added to",
    ),
    (
        "odd_sizes",
        "3.png: frame 2 is 3x4, the first is 4x3",
        "one size",
    ),
    (
        "not_a_picture",
        "notes.txt: not a picture",
        "move this one out",
    ),
    (
        "damaged_picture",
        "2.png: frame 1 cannot be decoded",
        "damaged",
    ),
    ("no_pictures", "no picture in it", "at least one frame"),
    ("uneven.gif", "s after the one before, where", "-vf fps="),
    ("truncated.gif", "cannot be decoded", "cut short"),
    ("truncated.apng", "cannot be decoded", "cut short"),
    ("absurd.png", "limits are exceeded", "damaged"),
    ("absurd.apng", "larger than", "scale"),
];

/// mp4 files that only a build with the feature looks into.
#[cfg(feature = "mp4")]
const BAD_MP4: &[(&str, &str, &str)] = &[
    ("truncated.mp4", "ends inside frame", "cut short"),
    (
        "no_tables.mp4",
        "ends early, at byte 28 of at least 32",
        "download it again",
    ),
    ("damaged.mp4", "its tables are damaged", "ffmpeg"),
    (
        "hevc.mp4",
        "not H.264",
        "ffmpeg -i FILE -pix_fmt gray clip.y4m",
    ),
    ("not_h264.mp4", "its tables are damaged", "ffmpeg"),
];
#[cfg(not(feature = "mp4"))]
const BAD_MP4: &[(&str, &str, &str)] = &[
    ("truncated.mp4", "feature \"mp4\"", "--features mp4"),
    ("no_tables.mp4", "feature \"mp4\"", "--features mp4"),
    ("damaged.mp4", "feature \"mp4\"", "--features mp4"),
    ("hevc.mp4", "feature \"mp4\"", "--features mp4"),
    ("not_h264.mp4", "feature \"mp4\"", "--features mp4"),
];

/// An mp4 that was cut off is told as such, with where it ends and where it should.
#[cfg(feature = "mp4")]
#[test]
fn a_cut_off_mp4_says_where_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.mp4");
    let boxed = |name: &[u8; 4], stated: u32, content: &[u8]| {
        [&stated.to_be_bytes()[..], name, content].concat()
    };
    let head = boxed(b"ftyp", 16, b"isom\0\0\0\0");
    for (rest, words) in [
        (
            boxed(b"mdat", 1000, &[7; 84]),
            "ends early, at byte 108 of at least 1016: box mdat begins at byte 16",
        ),
        (
            boxed(b"moov", 500, &[0; 12]),
            "ends early, at byte 36 of at least 516: box moov begins at byte 16",
        ),
        (
            vec![0, 0, 1],
            "ends early, at byte 19 of at least 24: a box begins at byte 16",
        ),
    ] {
        fs::write(&path, [&head[..], &rest].concat()).unwrap();
        let scene = open(&path.display().to_string(), &OpenOptions::default());
        let told = scene.err().expect("cut off").to_string();
        assert!(told.contains(words), "{told}");
    }
}

#[test]
fn every_bad_scene_gets_its_message() {
    for (name, says, helps) in BAD.iter().chain(BAD_MP4) {
        let path = bad(name);
        let scene = open(&path.display().to_string(), &OpenOptions::default());
        let error = match scene.and_then(read) {
            Ok(frames) => panic!("{name} was read: {} frames", frames.len()),
            Err(error) => error,
        };
        let message = error.to_string();
        let help = error.help().expect(name).to_string();
        assert!(
            message.contains(&path.display().to_string()),
            "{name} is not named: {message}"
        );
        assert!(message.contains(says), "{name}: {message}");
        assert!(help.contains(helps), "{name}: {help}");
    }
}

/// Times that other simulators put beside pictures are not read: the message has the way to say
/// the rate.
#[test]
fn times_beside_pictures_are_told() {
    for (name, text, helps) in [
        ("fps.txt", "24.5\n", "--fps 24.5"),
        ("fps.txt", "fast\n", "--fps FPS"),
        ("timestamps.txt", "0.0\n0.1\n", "evenly spaced"),
        ("images.csv", "0,frames/a.png\n", "evenly spaced"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(name), text).unwrap();
        let scene = open(
            &folder.path().display().to_string(),
            &OpenOptions::default(),
        );
        let error = scene.err().expect(name);
        assert!(error.to_string().contains(name), "{error}");
        let help = error.help().unwrap().to_string();
        assert!(
            help.contains("move it out") && help.contains(helps),
            "{help}"
        );
    }
}

#[test]
fn every_bad_file_is_in_the_table() {
    let there: BTreeSet<String> = fs::read_dir(bad(""))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .chain(["missing.y4m".into()])
        .collect();
    let listed = BAD
        .iter()
        .chain(BAD_MP4)
        .map(|(name, _, _)| String::from(*name));
    assert_eq!(there, listed.collect());
}
