//! An mp4 of which any one field lies is read or refused, at once and in little memory.
//!
//! Bit flips hardly ever hit a length in a way that matters; here every field of every box of two
//! real clips is set to each of the numbers that break readers. Found so: a box whose length is 0
//! or 1 was read for ever (9 of 125 one-field edits), and counts that no file could hold were
//! made room for.

#![cfg(feature = "mp4")]

use std::{
    fs,
    ops::Range,
    path::Path,
    sync::mpsc,
    thread,
    time::{Duration, Instant},
};

use amacrine::scene::{OpenOptions, Scene, open};

/// How long one file may take: a thousand times what it does.
const LONGEST: Duration = Duration::from_secs(10);

/// What the test itself may hold at most, in KiB.
const MOST_KIB: u64 = 300 << 10;

/// Boxes that hold boxes, and the bytes before the first of them.
const CONTAINERS: [(&[u8; 4], usize); 13] = [
    (b"moov", 0),
    (b"trak", 0),
    (b"edts", 0),
    (b"mdia", 0),
    (b"minf", 0),
    (b"dinf", 0),
    (b"dref", 8),
    (b"stbl", 0),
    (b"stsd", 8),
    (b"avc1", 78),
    (b"moof", 0),
    (b"traf", 0),
    (b"mvex", 0),
];

fn data(name: &str) -> Vec<u8> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    fs::read(root.join("tests/data/scene").join(name)).unwrap()
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap())
}

/// Where every box begins, and what it is: a walk of its own, over a sound file.
fn boxes(bytes: &[u8], range: Range<usize>, found: &mut Vec<(usize, [u8; 4], Range<usize>)>) {
    let mut at = range.start;
    while at + 8 <= range.end {
        let length = word(bytes, at) as usize;
        let name: [u8; 4] = bytes[at + 4..at + 8].try_into().unwrap();
        assert!(length >= 8 && at + length <= range.end, "the clip is sound");
        found.push((at, name, at + 8..at + length));
        if let Some((_, before)) = CONTAINERS.iter().find(|(known, _)| **known == name) {
            boxes(bytes, at + 8 + before..at + length, found);
        }
        at += length;
    }
}

/// Reads a clip to its end on a thread of its own; how many frames, or why not.
fn read(bytes: &[u8]) -> Result<usize, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.mp4");
    fs::write(&path, bytes).unwrap();
    let path = path.display().to_string();
    let (say, hear) = mpsc::channel();
    thread::spawn(move || {
        let read = || {
            let mut scene = open(&path, &OpenOptions::default())?;
            let mut frames = 0;
            while scene.next_frame()?.is_some() {
                frames += 1;
            }
            Ok(frames)
        };
        let read = read().map_err(|error: amacrine::scene::SceneError| error.to_string());
        let _ = say.send(read);
    });
    hear.recv_timeout(LONGEST)
        .expect("the file is read in time, without a panic")
}

/// The most that this process has held, in KiB, where the system says so.
fn peak() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok()
}

fn check(bytes: &[u8], what: &str) -> Result<usize, String> {
    let start = Instant::now();
    let read = read(bytes);
    assert!(start.elapsed() < LONGEST, "{what}: {:?}", start.elapsed());
    if let Some(peak) = peak() {
        assert!(peak < MOST_KIB, "{what}: {peak} KiB");
    }
    read
}

/// The numbers that a field of four bytes is set to.
fn lies(honest: u32) -> Vec<u32> {
    let mut lies = vec![
        0,
        1,
        2,
        7,
        8,
        15,
        16,
        honest.wrapping_sub(1),
        honest.wrapping_add(1),
        honest.wrapping_mul(2),
        1 << 16,
        0x7fff_ffff,
        1 << 31,
        u32::MAX - 7,
        u32::MAX,
    ];
    lies.retain(|lie| *lie != honest);
    lies
}

#[test]
fn every_length_of_every_box_may_lie() {
    let mut refused = 0;
    for name in ["baseline.mp4", "bframes.mp4"] {
        let sound = data(name);
        let mut all = Vec::new();
        boxes(&sound, 0..sound.len(), &mut all);
        assert!(all.len() > 20, "{name} has boxes");
        for (at, kind, content) in &all {
            let kind = kind.escape_ascii();
            for lie in lies(word(&sound, *at)) {
                let mut bytes = sound.clone();
                bytes[*at..*at + 4].copy_from_slice(&lie.to_be_bytes());
                refused += usize::from(check(&bytes, &format!("{name}, {kind}: {lie}")).is_err());
            }
            // The long form: the length stands in eight bytes behind the name.
            let honest = (content.end - at) as u64;
            for lie in [
                0,
                1,
                8,
                15,
                16,
                honest,
                honest + 1,
                1 << 32,
                1 << 63,
                u64::MAX,
            ] {
                let mut bytes = sound.clone();
                bytes[*at..*at + 4].copy_from_slice(&1_u32.to_be_bytes());
                let tail = bytes.split_off(*at + 8);
                bytes.extend(lie.to_be_bytes());
                bytes.extend(tail);
                refused +=
                    usize::from(check(&bytes, &format!("{name}, {kind}: long {lie}")).is_err());
            }
        }
    }
    assert!(refused > 200, "hardly any lie was noticed: {refused}");
}

#[test]
fn every_field_of_every_table_may_lie() {
    let mut refused = 0;
    for name in ["baseline.mp4", "bframes.mp4"] {
        let sound = data(name);
        let mut all = Vec::new();
        boxes(&sound, 0..sound.len(), &mut all);
        for (_, kind, content) in &all {
            let known = |kinds: &[&[u8; 4]]| kinds.contains(&kind);
            if !known(&[
                b"stsz", b"stco", b"stsc", b"stts", b"ctts", b"stss", b"mdhd", b"tkhd", b"hdlr",
                b"mvhd", b"elst", b"avcC", b"stsd",
            ]) {
                continue;
            }
            let kind = kind.escape_ascii();
            for at in content.clone().step_by(4) {
                let Some(honest) = sound.get(at..at + 4).map(|_| word(&sound, at)) else {
                    continue;
                };
                for lie in lies(honest) {
                    let mut bytes = sound.clone();
                    bytes[at..at + 4].copy_from_slice(&lie.to_be_bytes());
                    let what = format!("{name}, {kind} at byte {at}: {lie}");
                    refused += usize::from(check(&bytes, &what).is_err());
                }
            }
        }
    }
    assert!(refused > 500, "hardly any lie was noticed: {refused}");
}

/// The size of the pictures stands in the H.264 parameters: every byte of them, and of a little
/// of the first pictures.
#[test]
fn every_byte_of_the_parameters_may_lie() {
    for name in ["baseline.mp4", "bframes.mp4"] {
        let sound = data(name);
        let start = sound.windows(4).position(|w| w == b"avcC").unwrap() + 4;
        let pictures = sound.windows(4).position(|w| w == b"mdat").unwrap() + 4;
        for at in (start..start + 48).chain(pictures..pictures + 64) {
            for lie in [0, 1, 0x3f, 0x7f, 0x80, 0xff, !sound[at]] {
                let mut bytes = sound.clone();
                bytes[at] = lie;
                let _ = check(&bytes, &format!("{name}, byte {at}: {lie}"));
            }
        }
    }
}

#[test]
fn a_clip_that_is_cut_anywhere_is_refused_or_shorter() {
    let sound = data("baseline.mp4");
    let whole = check(&sound, "the clip itself").unwrap();
    assert_eq!(whole, 12);
    for cut in (0..sound.len()).step_by(7) {
        let read = check(&sound[..cut], &format!("cut after {cut} bytes"));
        assert!(read.is_err(), "cut after {cut} bytes, {read:?}");
    }
}

/// What a writer may do and still be right.
#[test]
fn sound_files_of_other_shapes_are_read() {
    let sound = data("bframes.mp4");
    let frames = check(&sound, "the clip itself").unwrap();
    // The last box may have a length of 0, "to the end of the file".
    let mut all = Vec::new();
    boxes(&sound, 0..sound.len(), &mut all);
    let last = all
        .iter()
        .find(|(_, _, content)| content.end == sound.len());
    let (at, name, _) = last.unwrap();
    let mut open_ended = sound.clone();
    open_ended[*at..*at + 4].copy_from_slice(&0_u32.to_be_bytes());
    let read = check(&open_ended, "a last box to the end");
    assert_eq!(read, Ok(frames), "{}", name.escape_ascii());
    // Boxes that nobody knows lie between the others, long forms among them.
    let mut filled = sound.clone();
    filled.extend(b"\0\0\0\x0cjunk1234\0\0\0\x01junk\0\0\0\0\0\0\0\x14abcd");
    assert_eq!(check(&filled, "unknown boxes"), Ok(frames));
}
