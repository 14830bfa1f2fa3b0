//! The part of `FlatBuffers` that AEDAT4 needs: tables read with every bound checked, and the few
//! tables that are written, laid out by hand.
//!
//! The code that the `FlatBuffers` compiler generates needs `unsafe`. Layout:
//! <https://flatbuffers.dev/internals/>.

/// A table in a buffer.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// `N` bytes from `at` on.
fn at<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..)?.first_chunk().copied()
}

fn u32_at(bytes: &[u8], place: usize) -> Option<usize> {
    at(bytes, place).map(|b| u32::from_le_bytes(b) as usize)
}

/// The file identifier, four letters, of a buffer (without its size prefix).
pub fn identifier(bytes: &[u8]) -> Option<[u8; 4]> {
    at(bytes, 4)
}

impl<'a> Table<'a> {
    /// The root table of a buffer (without its size prefix).
    pub fn root(bytes: &'a [u8]) -> Option<Self> {
        let at = u32_at(bytes, 0)?;
        Some(Self { bytes, at })
    }

    /// The table at byte `at` of a buffer (without its size prefix).
    pub const fn at(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    /// A field that is a struct of two 32-bit numbers.
    pub fn pair(&self, number: usize) -> Option<(i32, i32)> {
        let field = self.field(number)?;
        let first = at(self.bytes, field).map(i32::from_le_bytes)?;
        let second = at(self.bytes, field.checked_add(4)?).map(i32::from_le_bytes)?;
        Some((first, second))
    }

    /// Place of a field; `None` when it is left out.
    fn field(&self, number: usize) -> Option<usize> {
        let back = i32::from_le_bytes(at(self.bytes, self.at)?);
        let table = usize::try_from(i64::try_from(self.at).ok()? - i64::from(back)).ok()?;
        let size = u16::from_le_bytes(at(self.bytes, table)?) as usize;
        let slot = 4 + 2 * number;
        if slot + 2 > size {
            return None;
        }
        let offset = u16::from_le_bytes(at(self.bytes, table + slot)?) as usize;
        (offset != 0).then_some(self.at + offset)
    }

    /// A 32-bit field.
    pub fn i32(&self, number: usize) -> Option<i32> {
        at(self.bytes, self.field(number)?).map(i32::from_le_bytes)
    }

    /// A 64-bit field.
    pub fn i64(&self, number: usize) -> Option<i64> {
        at(self.bytes, self.field(number)?).map(i64::from_le_bytes)
    }

    /// The bytes of a vector whose elements have `size` bytes, and where they start. A vector that
    /// is left out is empty; `None` when it reaches beyond the buffer.
    pub fn vector(&self, number: usize, size: usize) -> Option<(&'a [u8], usize)> {
        let Some(field) = self.field(number) else {
            return Some((&[], 0));
        };
        let start = field.checked_add(u32_at(self.bytes, field)?)?;
        let length = u32_at(self.bytes, start)?.checked_mul(size)?;
        let from = start + 4;
        Some((self.bytes.get(from..from.checked_add(length)?)?, from))
    }
}

/// A buffer with a size prefix; offsets count from behind the prefix.
#[derive(Debug, Default)]
pub struct Builder {
    /// The bytes behind the size.
    pub bytes: Vec<u8>,
}

impl Builder {
    /// A buffer of this kind whose root table has fields at these offsets (0: left out) and
    /// `size` bytes, with its offset to the table of fields; the fields are to be added.
    pub fn new(kind: [u8; 4], size: u16, fields: &[u16]) -> Self {
        let mut bytes = Vec::new();
        // Root, identifier, table of fields, then the table at a multiple of 8 (the size in front
        // makes it 4 more): so 64-bit fields at offsets 4, 12 … are aligned.
        let vtable = 4 + 2 * fields.len();
        let mut table = 8 + vtable;
        while !table.is_multiple_of(8) {
            table += 1;
        }
        bytes.extend((table as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.resize(table - vtable, 0);
        bytes.extend((vtable as u16).to_le_bytes());
        bytes.extend(size.to_le_bytes());
        for field in fields {
            bytes.extend(field.to_le_bytes());
        }
        bytes.extend((vtable as u32).to_le_bytes());
        Self { bytes }
    }

    /// The whole buffer.
    pub fn finish(mut self) -> Vec<u8> {
        let size = (self.bytes.len() as u32).to_le_bytes();
        self.bytes.splice(0..0, size);
        self.bytes
    }
}
