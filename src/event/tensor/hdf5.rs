//! Layers in HDF5, one after the other: a chunk for each, and behind them the index that leads to
//! them, so that memory does not grow with their number.
//!
//! Laid out by hand: hdf5-pure adds to arrays of one axis only, or takes all of an array at once.
//! One data set with an index of a fixed array, of which all is in one page. Source: HDF5 file format
//! specification, version 3.0,
//! <https://support.hdfgroup.org/documentation/hdf5/latest/_f_m_t3.html>.

use std::io::{self, Seek, SeekFrom, Write};

use flate2::{Compression, write::ZlibEncoder};

use super::file::{Layers, Precision};

/// Bytes of the superblock.
const SUPERBLOCK: u64 = 48;

/// Bytes of a chunk at most: their number has 32 bits.
const MOST_BYTES: usize = u32::MAX as usize;

/// Bytes of the names at most: a message of a header has less than 64 KiB.
const MOST_NAMES: usize = 60_000;

/// Of an address that is not there.
const NOWHERE: u64 = u64::MAX;

/// The type of chunk that the index is of: one that filters have changed.
const FILTERED: u8 = 1;

/// A file of chunks that grows.
#[derive(Debug)]
pub(super) struct Chunks {
    /// Bytes so far.
    at: u64,
    /// Where each chunk is, and how many bytes it has there.
    places: Vec<(u64, u64)>,
    /// The last chunk, compressed.
    packed: Vec<u8>,
}

impl Chunks {
    /// None yet.
    ///
    /// # Errors
    /// When the format cannot hold such layers, or their kinds' names, or nothing can be written.
    pub(super) fn begin(out: &mut impl Write, layers: &Layers) -> io::Result<Self> {
        let refused = |why: String| Err(io::Error::new(io::ErrorKind::InvalidInput, why));
        let bytes = bytes_of_layer(layers);
        if bytes > MOST_BYTES {
            return refused(format!(
                "a layer has {bytes} bytes, and a chunk of HDF5 at most {MOST_BYTES}: take fewer bins, or .npy"
            ));
        }
        let names: usize = layers.kinds.iter().map(|name| name.len() + 1).sum();
        if names > MOST_NAMES {
            return refused(format!(
                "the names of the kinds have {names} bytes, and HDF5 has room for {MOST_NAMES}: take shorter ones, or .npz"
            ));
        }
        out.write_all(&[0; SUPERBLOCK as usize])?;
        Ok(Self {
            at: SUPERBLOCK,
            places: Vec::new(),
            packed: Vec::new(),
        })
    }

    /// Adds a layer's bytes.
    pub(super) fn push(&mut self, out: &mut impl Write, layer: &[u8]) -> io::Result<()> {
        let mut packed = std::mem::take(&mut self.packed);
        packed.clear();
        let mut encoder = ZlibEncoder::new(packed, Compression::fast());
        encoder.write_all(layer)?;
        self.packed = encoder.finish()?;
        out.write_all(&self.packed)?;
        let bytes = self.packed.len() as u64;
        self.places.push((self.at, bytes));
        self.at += bytes;
        Ok(())
    }

    /// Writes the index, the headers, and the superblock in front.
    pub(super) fn finish<O: Write + Seek>(self, out: &mut O, layers: &Layers) -> io::Result<()> {
        let mut end = Vec::new();
        let index = self.index(layers, &mut end);
        let here = |end: &[u8]| self.at + end.len() as u64;
        let array = here(&end);
        end.extend(self.array(layers, index));
        let root = here(&end);
        end.extend(root_group(layers, array));
        let length = here(&end);
        out.write_all(&end)?;
        out.seek(SeekFrom::Start(0))?;
        out.write_all(&superblock(length, root))?;
        out.seek(SeekFrom::End(0)).map(|_| ())
    }

    /// Adds the index to what stands behind the chunks; returns where it is.
    fn index(&self, layers: &Layers, end: &mut Vec<u8>) -> u64 {
        if self.places.is_empty() {
            return NOWHERE;
        }
        let (at, wide) = (self.at, wide(layers));
        let mut head = b"FAHD".to_vec();
        head.extend([0, FILTERED, (8 + wide + 4) as u8, self.page()]);
        head.extend((self.places.len() as u64).to_le_bytes());
        // Behind this, and its check sum.
        head.extend((at + head.len() as u64 + 12).to_le_bytes());
        let mut block = b"FADB".to_vec();
        block.extend([0, FILTERED]);
        block.extend(at.to_le_bytes());
        for (place, bytes) in &self.places {
            block.extend(place.to_le_bytes());
            block.extend(&bytes.to_le_bytes()[..wide]);
            // No filter was left out.
            block.extend([0; 4]);
        }
        end.extend(summed(head));
        end.extend(summed(block));
        at
    }

    /// Bits of the number of chunks in a page: as many as take them all.
    fn page(&self) -> u8 {
        (usize::BITS - self.places.len().leading_zeros()).max(10) as u8
    }

    /// The header of the array.
    fn array(&self, layers: &Layers, index: u64) -> Vec<u8> {
        let mut shape = vec![self.places.len() as u64];
        shape.extend(layers.shape.iter().map(|side| *side as u64));
        let mut space = vec![2, shape.len() as u8, 0, 1];
        space.extend(shape.iter().flat_map(|side| side.to_le_bytes()));
        // A chunk, and the bytes of a number, in as few bytes as the largest takes.
        let mut chunk = shape;
        chunk[0] = 1;
        chunk.push(bytes_of(layers.precision) as u64);
        let each = chunk
            .iter()
            .map(|side| (side.max(&1).ilog2() as usize + 8) / 8);
        let each = each.max().unwrap_or(1);
        let mut layout = vec![4, 2, 0, chunk.len() as u8, each as u8];
        for side in &chunk {
            layout.extend(&side.to_le_bytes()[..each]);
        }
        // An index of a fixed array.
        layout.extend([3, self.page()]);
        layout.extend(index.to_le_bytes());
        let mut deflate = vec![2, 1];
        for number in [1_u16, 0, 1] {
            deflate.extend(number.to_le_bytes());
        }
        deflate.extend(1_u32.to_le_bytes());
        object(&[
            (DATASPACE, space),
            (DATATYPE, float(layers.precision)),
            // Chunks are allocated as they come, and nothing fills them before.
            (FILL, vec![3, 0x0B]),
            (LAYOUT, layout),
            (FILTERS, deflate),
        ])
    }
}

const DATASPACE: u8 = 1;
const LINKS: u8 = 2;
const DATATYPE: u8 = 3;
const FILL: u8 = 5;
const LINK: u8 = 6;
const LAYOUT: u8 = 8;
const GROUP: u8 = 10;
const FILTERS: u8 = 11;
const ATTRIBUTE: u8 = 12;

/// Bytes of a number.
const fn bytes_of(precision: Precision) -> usize {
    match precision {
        Precision::Single => 4,
        Precision::Half => 2,
    }
}

/// Bytes of a layer.
fn bytes_of_layer(layers: &Layers) -> usize {
    layers.shape.iter().product::<usize>() * bytes_of(layers.precision)
}

/// Bytes in which the index holds the length of a chunk.
fn wide(layers: &Layers) -> usize {
    let bytes = bytes_of_layer(layers);
    (1 + (bytes.max(1).ilog2() as usize + 8) / 8).min(8)
}

/// The type of a number of IEEE 754, little-endian: sign, exponent, mantissa.
fn float(precision: Precision) -> Vec<u8> {
    let (size, bits, exponent, mantissa, bias) = match precision {
        Precision::Single => (4_u32, 32_u16, 8_u8, 23_u8, 127_u32),
        Precision::Half => (2, 16, 5, 10, 15),
    };
    // Version 1 of class 1; the first bit of the mantissa is implied; the sign is the last bit.
    let mut float = vec![0x11, 0x20, (bits - 1) as u8, 0];
    float.extend(size.to_le_bytes());
    float.extend([0, 0]);
    float.extend(bits.to_le_bytes());
    float.extend([mantissa, exponent, 0, mantissa]);
    float.extend(bias.to_le_bytes());
    float
}

/// The header of the group that has the array, and says what the kinds are called.
fn root_group(layers: &Layers, array: u64) -> Vec<u8> {
    let mut links = vec![0, 0];
    links.extend([NOWHERE, NOWHERE].iter().flat_map(|n| n.to_le_bytes()));
    let mut link = vec![1, 0, layers.name.len() as u8];
    link.extend(layers.name.bytes());
    link.extend(array.to_le_bytes());
    // A text of no letters has no size.
    let mut text = layers.kinds.join("\n").into_bytes();
    if text.is_empty() {
        text.push(0);
    }
    // A text of fixed length, UTF-8, filled with zeros.
    let mut texts = vec![0x13, 0x11, 0, 0];
    texts.extend((text.len() as u32).to_le_bytes());
    let one = [2, 0, 0, 0];
    let name = b"kinds\0";
    let mut kinds = vec![3, 0];
    for length in [name.len(), texts.len(), one.len()] {
        kinds.extend((length as u16).to_le_bytes());
    }
    kinds.push(0);
    kinds.extend(name);
    kinds.extend(texts);
    kinds.extend(one);
    kinds.extend(text);
    object(&[
        (LINKS, links),
        (GROUP, vec![0, 0]),
        (LINK, link),
        (ATTRIBUTE, kinds),
    ])
}

/// The header of an object, of messages.
fn object(messages: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, message) in messages {
        body.push(*kind);
        body.extend((message.len() as u16).to_le_bytes());
        body.push(0);
        body.extend(message);
    }
    let mut header = b"OHDR".to_vec();
    // Version 2, its length in four bytes.
    header.extend([2, 2]);
    header.extend((body.len() as u32).to_le_bytes());
    header.extend(body);
    summed(header)
}

/// The superblock of a file of this length.
fn superblock(length: u64, root: u64) -> Vec<u8> {
    let mut block = b"\x89HDF\r\n\x1a\n".to_vec();
    // Version 3; addresses and lengths have eight bytes.
    block.extend([3, 8, 8, 0]);
    for address in [0, NOWHERE, length, root] {
        block.extend(address.to_le_bytes());
    }
    summed(block)
}

/// With its check sum behind it.
fn summed(mut bytes: Vec<u8>) -> Vec<u8> {
    let sum = lookup3(&bytes);
    bytes.extend(sum.to_le_bytes());
    bytes
}

/// Jenkins's lookup3, `hashlittle` with an initial value of 0:
/// <https://burtleburtle.net/bob/c/lookup3.c>.
fn lookup3(bytes: &[u8]) -> u32 {
    let word = |part: &[u8]| {
        let mut word = [0; 4];
        word[..part.len()].copy_from_slice(part);
        u32::from_le_bytes(word)
    };
    let start = 0xDEAD_BEEF_u32.wrapping_add(bytes.len() as u32);
    let (mut a, mut b, mut c) = (start, start, start);
    let mut rest = bytes;
    while !rest.is_empty() {
        let (now, later) = rest.split_at(rest.len().min(12));
        let mut words = now.chunks(4).map(word);
        a = a.wrapping_add(words.next().unwrap_or(0));
        b = b.wrapping_add(words.next().unwrap_or(0));
        c = c.wrapping_add(words.next().unwrap_or(0));
        rest = later;
        if rest.is_empty() {
            // The last words are mixed for good.
            let mut words = [a, b, c];
            for (of, by, bits) in LAST {
                let other = words[by];
                words[of] = (words[of] ^ other).wrapping_sub(other.rotate_left(bits));
            }
            c = words[2];
        } else {
            for bits in [[4, 6, 8], [16, 19, 4]] {
                a = a.wrapping_sub(c) ^ c.rotate_left(bits[0]);
                c = c.wrapping_add(b);
                b = b.wrapping_sub(a) ^ a.rotate_left(bits[1]);
                a = a.wrapping_add(c);
                c = c.wrapping_sub(b) ^ b.rotate_left(bits[2]);
                b = b.wrapping_add(a);
            }
        }
    }
    c
}

/// The last mix of lookup3: which of three words is changed by which, turned by so many bits.
const LAST: [(usize, usize, u32); 7] = [
    (2, 1, 14),
    (0, 2, 11),
    (1, 0, 25),
    (2, 1, 16),
    (0, 2, 4),
    (1, 0, 14),
    (2, 1, 24),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// As the test driver of lookup3.c prints them.
    #[test]
    fn sums_are_those_of_the_source() {
        assert_eq!(lookup3(b""), 0xDEAD_BEEF);
        assert_eq!(lookup3(b"Four score and seven years ago"), 0x1777_0551);
    }
}
