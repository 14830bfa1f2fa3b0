//! Files that lie: whatever single number of a header, a table or a list of one of our own
//! files is changed, reading it ends in a message or in the very events that were written;
//! a file cut anywhere is noticed; and no event is missing in silence, also where the bytes of
//! the events themselves are changed. What is exempt is named in `docs/formats.md`.

use std::{fs, ops::Range, panic, path::Path};

use amacrine::{
    catch_panic,
    event::{
        Dropped, Event, Packet, Polarity,
        file::{self, Compression, FileError, Format, Opening, Reader},
    },
    plane::Size,
    unit::Micros,
};

/// The formats that this build reads and writes.
fn formats() -> impl Iterator<Item = Format> {
    Format::ALL
        .iter()
        .copied()
        .filter(|format| format.is_built())
}

/// Formats that have no room for a remark: how many events there should be is not known.
fn counts_nothing(format: Format) -> bool {
    matches!(
        format,
        Format::Csv | Format::Txt | Format::E2vid | Format::Es
    )
}

fn packet(format: Format, events: u64) -> Packet {
    let channels = if format.limits().channels { 3 } else { 1 };
    let mut packet = Packet::new(Size::new(260, 346), channels);
    packet.span = (Micros(5), Micros(5_000_000));
    packet.dropped = Dropped {
        no_slot: 7,
        ..Dropped::default()
    };
    packet.events = (0..events)
        .map(|i| Event {
            t: Micros(1000 + 700 * i),
            x: (i * 37 % 346) as u16,
            y: (i * 11 % 260) as u16,
            polarity: if i % 3 == 0 {
                Polarity::On
            } else {
                Polarity::Off
            },
            channel: (i % u64::from(channels)) as u8,
        })
        .collect();
    packet
}

fn bytes_of(format: Format, compression: Compression, packet: &Packet) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    file::write_as(&path, format, compression, packet).unwrap();
    fs::read(&path).unwrap()
}

fn read(format: Format, bytes: Vec<u8>) -> Result<Packet, (Vec<Event>, FileError)> {
    let opening = Opening {
        format: Some(format),
        ..Opening::default()
    };
    let opened = Reader::of_bytes(Path::new("a"), bytes, &opening);
    let (loaded, error) = file::all(opened.map_err(|error| (Vec::new(), error))?);
    match error {
        None => Ok(loaded.packet),
        Some(error) => Err((loaded.packet.events, error)),
    }
}

/// The bytes of the events themselves, in formats without a check sum over them.
#[expect(
    clippy::single_range_in_vec_init,
    reason = "some formats have one stretch of events, others several"
)]
fn payload(format: Format, compression: Compression, bytes: &[u8]) -> Vec<Range<usize>> {
    let after = |end: &[u8]| {
        let at = bytes.windows(end.len()).position(|w| w == end).unwrap();
        at + end.len()..bytes.len()
    };
    match format {
        Format::Csv => vec![after(b"channel\n")],
        Format::Txt => vec![0..bytes.len()],
        Format::E2vid => vec![after(b"346 260\n")],
        Format::Npy => vec![npy_data(bytes)..bytes.len()],
        Format::Evt2 | Format::Evt21 | Format::Evt3 => vec![after(b"% end\n")],
        Format::Dat => vec![after(b"\n\x0C\x08")],
        Format::Aedat2 => vec![remark_end(bytes)..bytes.len()],
        // One packet: 28 bytes of header, then its events.
        Format::Aedat3 => vec![after(b"END-HEADER\r\n").start + 28..bytes.len()],
        Format::Es => vec![20..bytes.len()],
        // The pages; the footer is behind them, and its length before the last four bytes.
        Format::Parquet => {
            let end = bytes.len() - 8;
            let length = u32::from_le_bytes(bytes[end..end + 4].try_into().unwrap());
            vec![4..end - length as usize]
        }
        // The three events stand before the table.
        Format::Aedat4 if compression == Compression::None => {
            let table = bytes.windows(4).position(|w| w == b"FTAB").unwrap() - 8;
            vec![table - 48..table]
        }
        Format::E2vidZip | Format::Npz | Format::Aedat4 | Format::Hdf5 => Vec::new(),
    }
}

/// Where the data of an NPY file start.
fn npy_data(bytes: &[u8]) -> usize {
    10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]))
}

/// Behind the line that the remark is in.
fn remark_end(bytes: &[u8]) -> usize {
    let remark = bytes.windows(8).position(|w| w == b"amacrine").unwrap();
    remark + bytes[remark..].iter().position(|b| *b == b'\n').unwrap() + 1
}

/// A number of so many bytes, little-endian, or big-endian, and what it is changed to.
fn edits(bytes: &[u8], at: usize, width: usize) -> Vec<Vec<u8>> {
    let Some(field) = bytes.get(at..at + width) else {
        return Vec::new();
    };
    let mut wide = [0; 8];
    wide[..width].copy_from_slice(field);
    let value = u64::from_le_bytes(wide);
    let most = u64::MAX >> (64 - 8 * width);
    let values = [
        0,
        1,
        most,
        most >> 1,
        value.wrapping_add(1),
        value.wrapping_sub(1),
    ];
    let mut edits: Vec<Vec<u8>> = values
        .iter()
        .filter(|new| **new & most != value)
        .map(|new| {
            let mut bytes = bytes.to_vec();
            bytes[at..at + width].copy_from_slice(&new.to_le_bytes()[..width]);
            bytes
        })
        .collect();
    if width == 1 {
        for bit in 1..8 {
            let mut bytes = bytes.to_vec();
            bytes[at] ^= 1 << bit;
            edits.push(bytes);
        }
    }
    edits
}

fn every_edit(format: Format, compression: Compression, packet: &Packet, widths: &[usize]) {
    let bytes = bytes_of(format, compression, packet);
    let exempt = payload(format, compression, &bytes);
    let mut seen = 0_u64;
    // Of the long ones every third byte: what is checked is checked everywhere.
    let step = if format == Format::Hdf5 { 3 } else { 1 };
    for at in (0..bytes.len()).step_by(step) {
        for width in widths {
            for damaged in edits(&bytes, at, *width) {
                seen += 1;
                let Ok(read) = read(format, damaged) else {
                    continue;
                };
                let mut exempt = exempt.iter();
                let of_events =
                    exempt.any(|part| part.contains(&at) || part.contains(&(at + width - 1)));
                let same = read.events == packet.events;
                if of_events {
                    let all = read.events.len() == packet.events.len();
                    assert!(
                        all || counts_nothing(format),
                        "{format} {compression:?}: {width} bytes at {at} of {}: {} events of {}",
                        bytes.len(),
                        read.events.len(),
                        packet.events.len()
                    );
                } else {
                    assert!(
                        same,
                        "{format} {compression:?}: {width} bytes at {at} of {}: other events ({} of {}) in silence",
                        bytes.len(),
                        read.events.len(),
                        packet.events.len()
                    );
                }
            }
        }
    }
    assert!(seen > bytes.len() as u64, "{format}");
}

#[test]
fn a_changed_number_is_noticed_or_changes_nothing() {
    // What a guard answers is no news.
    let hook = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        if !catch_panic::is_catching() {
            hook(panic);
        }
    }));
    for format in formats() {
        let widths = if format == Format::Hdf5 {
            &[1, 8][..]
        } else {
            &[1, 2, 4, 8]
        };
        every_edit(format, Compression::Lz4, &packet(format, 3), widths);
    }
    for compression in [Compression::None, Compression::Zstd] {
        let packet = packet(Format::Aedat4, 3);
        every_edit(Format::Aedat4, compression, &packet, &[1, 2, 4, 8]);
    }
}

/// Cut anywhere, also between two packets or two events.
#[test]
fn a_file_cut_anywhere_is_noticed() {
    let compressions = [Compression::None, Compression::Zstd];
    let others = compressions.map(|compression| (Format::Aedat4, compression));
    let all = formats()
        .map(|format| (format, Compression::Lz4))
        .chain(others);
    for (format, compression) in all {
        // Text and es have no room for a count: what they lack is not known.
        if counts_nothing(format) {
            continue;
        }
        let packet = packet(format, 20);
        let bytes = bytes_of(format, compression, &packet);
        for length in 0..bytes.len() {
            let cut = read(format, bytes[..length].to_vec());
            let Err((kept, _)) = cut else {
                panic!(
                    "{format} {compression:?}: {length} of {} bytes pass for the file",
                    bytes.len()
                );
            };
            assert_eq!(kept, packet.events[..kept.len()], "{format}");
        }
    }
}

/// The table of an AEDAT4 file of several packets: its place in the header, and its rows.
#[test]
fn packets_are_held_to_their_table() {
    let packet = packet(Format::Aedat4, 40_000);
    let bytes = bytes_of(Format::Aedat4, Compression::None, &packet);
    let says = |bytes: Vec<u8>, says: &str| {
        let (kept, error) = read(Format::Aedat4, bytes).expect_err(says);
        let said = error.to_string();
        assert!(said.contains(says), "{said}");
        kept
    };
    let table = bytes.windows(4).position(|w| w == b"FTAB").unwrap() - 8;
    let position = (table as u64).to_le_bytes();
    let field = bytes.windows(8).position(|w| w == position).unwrap();
    let with = |at: usize, new: &[u8]| {
        let mut bytes = bytes.clone();
        bytes[at..at + new.len()].copy_from_slice(new);
        bytes
    };
    // All packets are read all the same, and the damage is told.
    for wrong in [0_i64, 1, i64::MAX, -2, table as i64 + 1, table as i64 - 1] {
        let kept = says(with(field, &wrong.to_le_bytes()), "the table of packets");
        assert_eq!(kept, packet.events, "table at {wrong}");
    }
    let kept = says(with(field, &(-1_i64).to_le_bytes()), "is not there (-1)");
    assert_eq!(kept, packet.events);
    // A packet taken out, where all else is as it was.
    let row = bytes[table..]
        .windows(8)
        .position(|w| w == 8192_u64.to_le_bytes())
        .unwrap()
        + table;
    says(
        with(row, &8191_u64.to_le_bytes()),
        "packet 0 has this many events: 8191",
    );
    says(
        with(row + 8, &1_u64.to_le_bytes()),
        "packet 0 has its first event at 1",
    );
    // Cut before the table.
    let kept = says(bytes[..table].to_vec(), "without one");
    assert_eq!(kept, packet.events);
    // A recording that was never closed does not lie, as long as its events are all there.
    let mut open = with(field, &(-1_i64).to_le_bytes());
    open.truncate(table);
    assert_eq!(
        read(Format::Aedat4, open.clone()).ok().unwrap().events,
        packet.events
    );
    let last = 8 + 4 + 28 + (40_000 - 4 * 8192) * 16;
    open.truncate(open.len() - last);
    let kept = says(open, "says 40000 events, but the file has 32768 events");
    assert_eq!(kept, packet.events[..32_768]);
}

/// The damaged file of which 8,192 of 40,000 events were once read without a word.
#[test]
fn a_table_in_the_middle_is_no_end() {
    let packet = packet(Format::Aedat4, 40_000);
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        let bytes = bytes_of(Format::Aedat4, compression, &packet);
        // Behind the header: the first packet, its length, the second.
        let header = u32::from_le_bytes(bytes[14..18].try_into().unwrap()) as usize + 18;
        let length = u32::from_le_bytes(bytes[header + 4..header + 8].try_into().unwrap());
        let second = (header + 8 + length as usize) as u64;
        let mut candidates = 0;
        for at in 18..header - 8 {
            let here = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
            // The table's place is the one number that is nearly the file's length.
            if here <= second || here >= bytes.len() as u64 {
                continue;
            }
            candidates += 1;
            let mut damaged = bytes.clone();
            damaged[at..at + 8].copy_from_slice(&second.to_le_bytes());
            let (kept, error) = read(Format::Aedat4, damaged).expect_err("a table");
            let one = format!("its header says that the table of packets is at byte {second}");
            assert!(error.to_string().contains(&one), "{error}");
            assert_eq!(kept, packet.events, "salvage goes on");
        }
        assert_eq!(candidates, 1, "{compression:?}");
    }
}

/// What files of cameras say twice.
#[test]
fn headers_that_contradict_themselves() {
    let cases: [(Format, &[u8], &str); 5] = [
        (
            Format::Evt3,
            b"% evt 3.0\n% format EVT2;height=4;width=4\n% end\n",
            "`format` in its header says EVT2",
        ),
        (
            Format::Evt2,
            b"% format EVT2;height=480;width=640\n% geometry 640x360\n% end\n",
            "`format` says that the sensor is 480 pixels high, `geometry` says 360",
        ),
        (
            Format::Dat,
            b"% amacrine size=640x480\n% Version 2\n% Height 480\n% Width 64\n\x0C\x08",
            "the comment `# amacrine …` says that the sensor is 640 pixels wide",
        ),
        (
            Format::Csv,
            b"# amacrine events=2\nt,x,y,p\n1,2,3,1\n",
            "says 2 events, but the file has 1 event",
        ),
        (
            Format::Txt,
            b"# amacrine events=1 times=7..7\n0.000008 2 3 1\n",
            "says a first event at 7 us and a last at 7 us, but the file has a first event at 8 us",
        ),
    ];
    for (format, bytes, says) in cases {
        let (_, error) = read(format, bytes.to_vec()).unwrap_err();
        assert!(error.to_string().contains(says), "{error}");
    }
}

/// A packet's count of valid events, and the room that it has.
#[test]
fn packets_of_aedat3_are_counted() {
    let mut bytes = b"#!AER-DAT3.1\r\n#!END-HEADER\r\n".to_vec();
    let header = bytes.len();
    bytes.extend([1, 0, 1, 0]);
    for field in [8_u32, 4, 0, 2, 2, 2] {
        bytes.extend(field.to_le_bytes());
    }
    for t in [5_u32, 6] {
        bytes.extend((3_u32 << 17 | 4 << 2 | 1).to_le_bytes());
        bytes.extend(t.to_le_bytes());
    }
    assert_eq!(read(Format::Aedat3, bytes.clone()).unwrap().events.len(), 2);
    let with = |field: usize, value: u8| {
        let mut bytes = bytes.clone();
        bytes[header + 4 + 4 * field] = value;
        read(Format::Aedat3, bytes).unwrap_err().1.to_string()
    };
    // Room that is not used lies behind the records, as readers of the field take it.
    let mut roomy = bytes.clone();
    roomy[header + 4 + 4 * 3] = 4;
    roomy.extend([0; 16]);
    let second = roomy.len();
    roomy.extend_from_slice(&bytes[header..]);
    roomy[second + 28 + 4] = 6;
    assert_eq!(read(Format::Aedat3, roomy.clone()).unwrap().events.len(), 4);
    roomy.truncate(bytes.len() + 8);
    assert!(read(Format::Aedat3, roomy).is_err());
    assert!(with(3, 1).contains("room for 1 records, it says that it has 2"));
    assert!(with(5, 1).contains("says that 1 of its events are valid, 2 are"));
}
