//! Edits that know what bytes are made of: the numbers of a container's own structure are set to
//! what breaks readers, with the frame around them still valid. Bit flips seldom get so far.

/// What a file is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Lines with numbers and names.
    Text,
    /// Numbers, after a header of text or of none.
    Words,
    /// Boxes of MP4: bytes, four letters, content or more boxes.
    Boxes,
    /// Chunks of PNG: bytes, four letters, content, check sum.
    Png,
    /// Blocks of GIF.
    Gif,
    /// Members of a ZIP archive.
    Zip,
    /// Packets of AEDAT4.
    Packets,
}

/// Numbers of the dice, from a seed.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % sides.max(1)
    }
}

/// A number in a file.
#[derive(Clone, Copy)]
struct Field {
    at: usize,
    width: usize,
    big: bool,
}

/// The bytes with one thing of their structure changed, half of the time; `None` leaves the
/// change to libFuzzer.
pub fn edited(shape: Shape, bytes: &[u8], room: usize, seed: u32) -> Option<Vec<u8>> {
    let mut dice = Dice(u64::from(seed) << 1 | 1 << 40);
    for _ in 0..4 {
        dice.roll(1);
    }
    if dice.roll(2) == 0 {
        return None;
    }
    let edited = if shape == Shape::Text {
        line(bytes, &mut dice)
    } else {
        let fields = fields(shape, bytes);
        match fields.get(dice.roll(fields.len())) {
            // A part taken out or put in twice, else a number changed.
            Some(field) if dice.roll(8) == 0 => moved(bytes, *field, &fields, &mut dice),
            Some(field) => set(bytes, *field, &mut dice),
            // Of a header of text: its numbers.
            None => line(bytes, &mut dice),
        }
    };
    let mut edited = edited.filter(|edited| edited.len() <= room && !edited.is_empty())?;
    if shape == Shape::Png {
        sums(&mut edited);
    }
    Some(edited)
}

/// A field set to a number that readers fall over.
fn set(bytes: &[u8], field: Field, dice: &mut Dice) -> Option<Vec<u8>> {
    let Field { at, width, big } = field;
    let mut wide = [0; 8];
    let here = wide.get_mut(..width)?;
    here.copy_from_slice(bytes.get(at..at + width)?);
    if big {
        here.reverse();
    }
    let value = u64::from_le_bytes(wide);
    let most = u64::MAX >> (64 - 8 * width);
    let choices = [
        0,
        1,
        2,
        7,
        8,
        most,
        most - 1,
        most >> 1,
        (most >> 1) + 1,
        value.wrapping_add(1),
        value.wrapping_sub(1),
        value.wrapping_mul(2),
        value / 2,
        bytes.len() as u64,
        (bytes.len() - at) as u64,
        1 << dice.roll(8 * width),
    ];
    let new = choices[dice.roll(choices.len())] & most;
    let mut new = new.to_le_bytes()[..width].to_vec();
    if big {
        new.reverse();
    }
    let mut edited = bytes.to_vec();
    edited[at..at + width].copy_from_slice(&new);
    Some(edited)
}

/// What stands between two fields, taken out or put in twice.
fn moved(bytes: &[u8], field: Field, fields: &[Field], dice: &mut Dice) -> Option<Vec<u8>> {
    let other = fields.get(dice.roll(fields.len()))?;
    let (from, to) = (field.at.min(other.at), field.at.max(other.at));
    let part = bytes.get(from..to)?;
    let mut edited = bytes.to_vec();
    if dice.roll(2) == 0 {
        edited.drain(from..to);
    } else {
        edited.splice(to..to, part.iter().copied());
    }
    Some(edited)
}

/// A number in a text becomes another, or a line comes twice or goes.
fn line(bytes: &[u8], dice: &mut Dice) -> Option<Vec<u8>> {
    const NUMBERS: [&str; 24] = [
        "0",
        "1",
        "-1",
        "2",
        "3",
        "127",
        "128",
        "255",
        "256",
        "4096",
        "32767",
        "65535",
        "65536",
        "2147483647",
        "2147483648",
        "4294967295",
        "4294967297",
        "9223372036854775807",
        "9223372036854775808",
        "18446744073709551615",
        "1e308",
        "1e-320",
        "nan",
        "inf",
    ];
    let digits: Vec<(usize, usize)> = runs(bytes, u8::is_ascii_digit);
    if !digits.is_empty() && dice.roll(4) > 0 {
        let (from, to) = digits[dice.roll(digits.len())];
        let mut edited = bytes.to_vec();
        edited.splice(from..to, NUMBERS[dice.roll(NUMBERS.len())].bytes());
        return Some(edited);
    }
    let lines = runs(bytes, |b| *b != b'\n');
    let (from, to) = *lines.get(dice.roll(lines.len()))?;
    let part = bytes.get(from..(to + 1).min(bytes.len()))?;
    let mut edited = bytes.to_vec();
    match dice.roll(4) {
        0 => drop(edited.drain(from..from + part.len())),
        // Nested: opened again and again.
        1 => {
            let many = 1 << dice.roll(6);
            edited.splice(from..from, part.repeat(many));
        }
        _ => {
            let (there, _) = lines[dice.roll(lines.len())];
            edited.splice(there..there, part.iter().copied());
        }
    }
    Some(edited)
}

/// Runs of bytes that are so.
fn runs(bytes: &[u8], so: impl Fn(&u8) -> bool) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    let mut start = None;
    for (i, byte) in bytes.iter().enumerate() {
        match (so(byte), start) {
            (true, None) => start = Some(i),
            (false, Some(from)) => {
                runs.push((from, i));
                start = None;
            }
            _ => (),
        }
    }
    if let Some(from) = start {
        runs.push((from, bytes.len()));
    }
    runs
}

/// The numbers of a file's structure.
fn fields(shape: Shape, bytes: &[u8]) -> Vec<Field> {
    let mut fields = Vec::new();
    match shape {
        Shape::Text => (),
        Shape::Words => fields.extend(every(0, bytes.len(), 4, false)),
        Shape::Boxes => boxes(bytes, 0, bytes.len(), 0, &mut fields),
        Shape::Png => chunks(bytes, |at, length| {
            fields.push(number(at, 4, true));
            let inside = (at + 8).min(bytes.len())..(at + 8 + length).min(bytes.len());
            fields.extend(every(
                inside.start,
                inside.end.min(inside.start + 26),
                4,
                true,
            ));
            fields.extend(every(
                inside.start,
                inside.end.min(inside.start + 26),
                1,
                true,
            ));
        }),
        Shape::Gif => {
            fields.extend(every(6, 13, 2, false).chain(every(6, 13, 1, false)));
            // Image descriptors and extensions; what only looks like one does no harm.
            for (i, byte) in bytes.iter().enumerate().skip(13) {
                match byte {
                    0x2C => fields.extend(every(i + 1, i + 9, 2, false).chain([number(
                        i + 9,
                        1,
                        false,
                    )])),
                    0x21 => fields.extend(every(i + 1, i + 8, 1, false)),
                    _ => (),
                }
            }
        }
        Shape::Zip => {
            for at in 0..bytes.len() {
                let numbers = match bytes.get(at..at + 4) {
                    Some(b"PK\x03\x04") => (4, 30),
                    Some(b"PK\x01\x02") => (4, 46),
                    Some(b"PK\x05\x06") => (4, 22),
                    _ => continue,
                };
                let (from, to) = (at + numbers.0, at + numbers.1);
                fields.extend(every(from, to, 2, false).chain(every(from, to, 4, false)));
            }
        }
        Shape::Packets => packets(bytes, &mut fields),
    }
    fields.retain(|field| field.at + field.width <= bytes.len());
    fields
}

const fn number(at: usize, width: usize, big: bool) -> Field {
    Field { at, width, big }
}

/// Numbers side by side.
fn every(from: usize, to: usize, width: usize, big: bool) -> impl Iterator<Item = Field> {
    (from..to)
        .step_by(width)
        .map(move |at| number(at, width, big))
}

fn u32_at(bytes: &[u8], at: usize, big: bool) -> Option<usize> {
    let four = *bytes.get(at..)?.first_chunk()?;
    Some(if big {
        u32::from_be_bytes(four)
    } else {
        u32::from_le_bytes(four)
    } as usize)
}

/// Sizes of boxes, and the numbers of those that hold tables.
fn boxes(bytes: &[u8], mut at: usize, end: usize, depth: usize, fields: &mut Vec<Field>) {
    while at + 8 <= end && fields.len() < 4096 {
        let size = u32_at(bytes, at, true).unwrap_or(0);
        let kind = bytes.get(at + 4..at + 8).unwrap_or_default();
        fields.extend([
            number(at, 4, true),
            number(at + 4, 4, true),
            number(at + 8, 8, true),
        ]);
        let next = at.saturating_add(size.max(8)).min(end);
        let holds = [
            &b"moov"[..],
            b"trak",
            b"mdia",
            b"minf",
            b"stbl",
            b"edts",
            b"dinf",
            b"mvex",
            b"moof",
            b"traf",
        ];
        if holds.contains(&kind) && depth < 8 {
            boxes(bytes, at + 8, next, depth + 1, fields);
        } else if kind != b"mdat" {
            let inside = next.min(at + 8 + 120);
            fields.extend(every(at + 8, inside, 4, true).chain(every(at + 8, inside, 2, true)));
        }
        at = next;
    }
}

/// Each chunk of a PNG: where it starts, and how long its content is.
fn chunks(bytes: &[u8], mut each: impl FnMut(usize, usize)) {
    let mut at = 8;
    while at + 12 <= bytes.len() {
        let length = u32_at(bytes, at, true).unwrap_or(0);
        each(at, length);
        at = at.saturating_add(length).saturating_add(12);
    }
}

/// Puts the check sums of a PNG right, so that its reader gets to what was changed.
fn sums(bytes: &mut [u8]) {
    let mut places = Vec::new();
    chunks(bytes, |at, length| places.push((at + 4, at + 8 + length)));
    for (from, to) in places {
        if let Some(part) = bytes.get(from..to) {
            let sum = crc32fast::hash(part).to_be_bytes();
            if let Some(place) = bytes.get_mut(to..to + 4) {
                place.copy_from_slice(&sum);
            }
        }
    }
}

/// The header, the headers of packets, and the table behind them.
fn packets(bytes: &[u8], fields: &mut Vec<Field>) {
    const MAGIC: usize = 14;
    let header = u32_at(bytes, MAGIC, false).unwrap_or(0);
    fields.extend(every(MAGIC, MAGIC + 60, 4, false).chain(every(MAGIC + 4, MAGIC + 60, 8, false)));
    let mut at = (MAGIC + 4).saturating_add(header);
    while at + 8 <= bytes.len() && fields.len() < 1024 {
        fields.extend(every(at, at + 48, 4, false));
        let length = u32_at(bytes, at + 4, false).unwrap_or(0);
        at = at.saturating_add(8).saturating_add(length);
    }
    let tail = bytes.len().saturating_sub(160);
    fields.extend(every(tail, bytes.len(), 4, false).chain(every(tail, bytes.len(), 8, false)));
}
