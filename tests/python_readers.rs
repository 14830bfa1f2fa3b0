//! numpy and pandas' way of reading open what we write, by the lines that the documentation
//! gives, and agree event by event; what numpy writes, we read. Needs python3 with numpy.

use std::{fs, process::Command};

use amacrine::{
    event::{Event, Packet, Polarity, file},
    plane::Size,
    unit::Micros,
};

fn packet(channels: u8) -> Packet {
    let mut packet = Packet::new(Size::new(260, 346), channels);
    packet.span = (Micros(0), Micros(2_000_000));
    packet.events = (0..20_000_u64)
        .map(|i| {
            let h = i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 20;
            Event {
                t: Micros(i * 99 + h % 50),
                x: (h % 346) as u16,
                y: (h / 346 % 260) as u16,
                polarity: if h & 1 << 30 == 0 {
                    Polarity::Off
                } else {
                    Polarity::On
                },
                channel: (h / 89_960 % u64::from(channels)) as u8,
            }
        })
        .collect();
    packet
}

/// Reads every file by its documented line, prints its events as rows, and writes it again.
const SCRIPT: &str = r"
import csv, sys
import numpy
folder, channels = sys.argv[1], int(sys.argv[2])
names = ['t', 'x', 'y', 'p'] + (['channel'] if channels > 1 else [])

array = numpy.load(f'{folder}/a.npy')
wanted = [('t', '<i8'), ('x', '<i2'), ('y', '<i2'), ('p', 'i1')]
assert array.dtype == numpy.dtype(wanted + ([('channel', 'u1')] if channels > 1 else [])), array.dtype
assert numpy.load(f'{folder}/a.npy', mmap_mode='r').shape == array.shape
rows = [[int(v) for v in event] for event in array]

table = numpy.genfromtxt(f'{folder}/a.csv', delimiter=',', names=True, dtype=int)
assert list(table.dtype.names) == names
assert [[int(v) for v in event] for event in table] == rows, 'genfromtxt'
bare = numpy.loadtxt(f'{folder}/a.csv', delimiter=',', skiprows=1, dtype=numpy.int64)
assert bare.tolist() == rows, 'loadtxt'
with open(f'{folder}/a.csv', newline='') as file:
    assert [[int(row[n]) for n in names] for row in csv.DictReader(file)] == rows, 'DictReader'
try:
    import pandas
    assert pandas.read_csv(f'{folder}/a.csv').values.tolist() == rows, 'pandas'
except ImportError:
    pass

if channels == 1:
    text = numpy.loadtxt(f'{folder}/a.txt')
    text[:, 0] = numpy.round(text[:, 0] * 1e6)
    assert text.astype(int).tolist() == rows, 'text'
    numpy.savetxt(f'{folder}/b.txt', numpy.loadtxt(f'{folder}/a.txt'), fmt=['%.9f', '%d', '%d', '%d'])

numpy.save(f'{folder}/b.npy', array)
wide = array.astype([(n, '>i8') for n in names], copy=True)
numpy.save(f'{folder}/c.npy', wide)
numpy.save(f'{folder}/d.npy', array.astype(numpy.dtype(array.dtype.descr, align=True)))
numpy.savetxt(f'{folder}/b.csv', bare, fmt='%d', delimiter=',', header=','.join(names), comments='')
print('\n'.join(','.join(map(str, row)) for row in rows))
";

fn check(channels: u8) {
    let folder = tempfile::tempdir().unwrap();
    let packet = packet(channels);
    let ours: &[&str] = if channels == 1 {
        &["a.npy", "a.csv", "a.txt"]
    } else {
        &["a.npy", "a.csv"]
    };
    for name in ours {
        file::write(&folder.path().join(name), &packet).unwrap();
    }
    let out = Command::new("python3")
        .args(["-c", SCRIPT])
        .arg(folder.path())
        .arg(channels.to_string())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{said}");
    let csv = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    let (_, rows) = csv.split_once('\n').unwrap();
    assert_eq!(String::from_utf8(out.stdout).unwrap(), rows);

    let theirs: &[&str] = if channels == 1 {
        &["b.npy", "c.npy", "d.npy", "b.csv", "b.txt"]
    } else {
        &["b.npy", "c.npy", "d.npy", "b.csv"]
    };
    for name in theirs {
        let loaded = file::read(&folder.path().join(name)).unwrap();
        assert_eq!(loaded.packet.events, packet.events, "{name}");
        assert!(!loaded.size_known, "{name}");
    }
}

#[test]
#[ignore = "needs Python with numpy; run by name in .ci/run"]
fn numpy_and_we_read_each_other() {
    check(1);
}

#[test]
#[ignore = "needs Python with numpy; run by name in .ci/run"]
fn numpy_and_we_read_each_other_with_channels() {
    check(3);
}
