//! Bit streams that know the place of every fault.
//!
//! `bitstream-io` does the shifting; this counts bits, since its readers only know bytes.

use bitstream_io::{BigEndian, BitRead, BitReader, BitWrite, BitWriter, UnsignedInteger};

use super::CodecError;

/// Bits into bytes, most significant first.
pub(super) struct Writer {
    out: BitWriter<Vec<u8>, BigEndian>,
    bits: u64,
}

impl Default for Writer {
    fn default() -> Self {
        Self {
            out: BitWriter::new(Vec::new()),
            bits: 0,
        }
    }
}

impl Writer {
    /// Writes the lowest `bits` of a value, which has no higher ones.
    pub fn write<U: UnsignedInteger>(&mut self, bits: u32, value: U) {
        let written = self.out.write_unsigned_var(bits, value);
        debug_assert!(written.is_ok(), "a value wider than its field");
        self.bits += u64::from(bits);
    }

    /// The bytes, the last one padded with zeros, and the number of bits.
    pub fn finish(mut self) -> (Vec<u8>, u64) {
        // A vector takes every byte.
        let _ = self.out.byte_align();
        (self.out.into_writer(), self.bits)
    }
}

/// Bits from bytes.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    input: BitReader<&'a [u8], BigEndian>,
    at: u64,
    bits: u64,
    /// The event that is being read, for messages.
    pub event: usize,
}

impl<'a> Reader<'a> {
    pub fn new(bytes: &'a [u8], bits: u64) -> Result<Self, CodecError> {
        let want = bits.div_ceil(8);
        if want != bytes.len() as u64 {
            let found = bytes.len() as u64;
            return Err(CodecError::Bytes { bits, want, found });
        }
        Ok(Self {
            bytes,
            input: BitReader::new(bytes),
            at: 0,
            bits,
            event: 0,
        })
    }

    /// Bits read so far.
    pub const fn at(&self) -> u64 {
        self.at
    }

    /// Reads a field whose value must be below `limit`.
    pub fn read(
        &mut self,
        field: &'static str,
        bits: u32,
        limit: usize,
    ) -> Result<u16, CodecError> {
        let bit = self.at;
        let value: u32 = self.take(field, bits)?;
        u16::try_from(value)
            .ok()
            .filter(|v| usize::from(*v) < limit)
            .ok_or(CodecError::Outside {
                bit,
                field,
                value,
                limit,
            })
    }

    /// One bit.
    pub fn flag(&mut self, field: &'static str) -> Result<bool, CodecError> {
        Ok(self.take::<u8>(field, 1)? == 1)
    }

    /// One byte, if there is one.
    pub fn byte(&mut self) -> Option<u8> {
        self.take("code book", 8).ok()
    }

    fn take<U: UnsignedInteger>(
        &mut self,
        field: &'static str,
        bits: u32,
    ) -> Result<U, CodecError> {
        let value = (self.bits - self.at >= u64::from(bits))
            .then(|| self.input.read_unsigned_var(bits).ok())
            .flatten();
        let value = value.ok_or(CodecError::Truncated {
            bit: self.at,
            end: self.bits,
            field,
            event: self.event,
        })?;
        self.at += u64::from(bits);
        Ok(value)
    }

    /// Checks that nothing is left but the zeros that pad the last byte.
    pub fn finish(self) -> Result<(), CodecError> {
        if self.at < self.bits {
            return Err(CodecError::Left {
                bit: self.at,
                left: self.bits - self.at,
            });
        }
        let used = self.bits % 8;
        match self.bytes.last() {
            Some(last) if used > 0 && (last << used) != 0 => Err(CodecError::Padding {
                byte: self.bytes.len() as u64 - 1,
            }),
            _ => Ok(()),
        }
    }
}
