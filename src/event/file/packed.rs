//! How packets of AEDAT4 are compressed and decompressed. What works is kept from packet to packet:
//! its tables and buffers are larger than a packet, and the system would clear them each time.

use std::io::{self, Cursor, Read, Write};

use lz4_flex::frame::{BlockSize, FrameDecoder, FrameEncoder, FrameInfo};
use zstd::bulk::Compressor;

use super::{head::Compression, packets};

/// The longest packet or header of AEDAT 4.0, in bytes, compressed or not.
pub(super) const LONGEST: usize = 1 << 26;

/// Where in the header of an LZ4 frame the length of its blocks is.
const BLOCKS: usize = 5;

/// Decompresses packets.
pub struct Unpacking {
    /// As the header numbers it.
    compression: i32,
    lz4: FrameDecoder<Cursor<Vec<u8>>>,
    /// The byte of the last frame's header that says how long its blocks are: a decoder serves
    /// frames of one such length.
    blocks: u8,
}

impl Unpacking {
    /// Of packets that are compressed in this way.
    pub fn new(compression: i32) -> Self {
        Self {
            compression,
            lz4: FrameDecoder::new(Cursor::default()),
            blocks: 0,
        }
    }

    /// Whether packets are not compressed.
    pub const fn is_plain(&self) -> bool {
        self.compression == 0
    }

    /// Puts what is in a block into `packet`, in place of what that held. The block's content is
    /// lost.
    pub fn unpack(&mut self, block: &mut Vec<u8>, packet: &mut Vec<u8>) -> Result<(), String> {
        packet.clear();
        let most = LONGEST as u64 + 1;
        let read = match self.compression {
            0 => {
                std::mem::swap(block, packet);
                return Ok(());
            }
            // The decoder takes the end of its input for the end of a frame.
            1 | 2 if !packets::is_lz4_frame(block) => {
                return Err("has a packet that is no whole LZ4 frame".into());
            }
            1 | 2 => {
                let blocks = block[BLOCKS];
                if blocks != self.blocks {
                    self.lz4 = FrameDecoder::new(Cursor::default());
                    self.blocks = blocks;
                }
                let input = self.lz4.get_mut();
                input.set_position(0);
                std::mem::swap(input.get_mut(), block);
                let read = (&mut self.lz4).take(most).read_to_end(packet);
                if !matches!(read, Ok(bytes) if bytes <= LONGEST) {
                    // It may be in the middle of a frame.
                    self.lz4 = FrameDecoder::new(Cursor::default());
                }
                read
            }
            _ => zstd::stream::read::Decoder::with_buffer(&block[..])
                .and_then(|decoder| decoder.take(most).read_to_end(packet)),
        };
        match read {
            Ok(bytes) if bytes > LONGEST => Err("has a packet that is too long".into()),
            Ok(_) => Ok(()),
            Err(e) => Err(format!("has a packet that cannot be decompressed: {e}")),
        }
    }
}

/// Compresses packets, with check sums, so that damage is noticed.
#[derive(Debug)]
pub struct Packing {
    compression: Compression,
    lz4: FrameEncoder<Vec<u8>>,
    /// The last packet, where the encoder does not keep it.
    packed: Vec<u8>,
}

/// Bytes of packets that share the kept encoder: the size of its blocks is in the header of a
/// frame, and the smallest that holds the packet is what a new encoder would take.
const ALIKE: std::ops::RangeInclusive<usize> = (1 << 16) + 1..=1 << 18;

impl Packing {
    /// In this way.
    pub fn new(compression: Compression) -> Self {
        let info = FrameInfo::new()
            .content_checksum(true)
            .block_size(BlockSize::Max256KB);
        Self {
            compression,
            lz4: FrameEncoder::with_frame_info(info, Vec::new()),
            packed: Vec::new(),
        }
    }

    /// A packet, compressed. Its bytes do not depend on the packets before.
    pub fn pack<'a>(&'a mut self, bytes: &'a [u8]) -> io::Result<&'a [u8]> {
        match self.compression {
            Compression::None => Ok(bytes),
            Compression::Lz4 if ALIKE.contains(&bytes.len()) => {
                self.lz4.get_mut().clear();
                self.lz4.write_all(bytes)?;
                self.lz4.try_finish().map_err(io::Error::other)?;
                Ok(self.lz4.get_ref())
            }
            Compression::Lz4 => {
                let info = FrameInfo::new().content_checksum(true);
                let mut block = std::mem::take(&mut self.packed);
                block.clear();
                let mut encoder = FrameEncoder::with_frame_info(info, block);
                encoder.write_all(bytes)?;
                self.packed = encoder.finish().map_err(io::Error::other)?;
                Ok(&self.packed)
            }
            Compression::Zstd => {
                let mut compressor = Compressor::new(1)?;
                compressor.include_checksum(true)?;
                self.packed = compressor.compress(bytes)?;
                Ok(&self.packed)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(length: usize) -> Vec<u8> {
        (0..length as u32)
            .map(|i| (((i * i) >> 7) & (i >> 3)) as u8)
            .collect()
    }

    /// What is kept from packet to packet changes no byte.
    #[test]
    fn a_packet_is_packed_as_if_it_were_the_first() {
        let lengths = [
            90_000, 131_000, 200, 65_536, 65_537, 262_144, 300_000, 90_001,
        ];
        for compression in [Compression::Lz4, Compression::Zstd, Compression::None] {
            let mut kept = Packing::new(compression);
            let mut unpacking = Unpacking::new(match compression {
                Compression::Lz4 => 1,
                Compression::Zstd => 3,
                Compression::None => 0,
            });
            for length in lengths {
                let bytes = bytes(length);
                let mut packed = kept.pack(&bytes).unwrap().to_vec();
                let mut fresh = Packing::new(compression);
                assert_eq!(packed, fresh.pack(&bytes).unwrap(), "{length}");
                let mut back = vec![7; 3];
                unpacking.unpack(&mut packed, &mut back).unwrap();
                assert!(back == bytes, "{length}");
            }
        }
    }

    /// As an encoder does that is made for one frame.
    #[test]
    fn frames_are_those_of_a_new_encoder() {
        for length in [65_536, 65_537, 131_104, 262_144, 262_145] {
            let bytes = bytes(length);
            let info = FrameInfo::new().content_checksum(true);
            let mut encoder = FrameEncoder::with_frame_info(info, Vec::new());
            encoder.write_all(&bytes).unwrap();
            let mut packing = Packing::new(Compression::Lz4);
            assert_eq!(packing.pack(&bytes).unwrap(), encoder.finish().unwrap());
        }
    }

    #[test]
    fn damage_does_not_reach_the_next_packet() {
        let good = Packing::new(Compression::Lz4)
            .pack(&bytes(100_000))
            .unwrap()
            .to_vec();
        let mut bad = good.clone();
        bad[5_000] ^= 0x40;
        let (mut unpacking, mut packet) = (Unpacking::new(1), Vec::new());
        assert!(unpacking.unpack(&mut bad, &mut packet).is_err());
        unpacking.unpack(&mut good.clone(), &mut packet).unwrap();
        assert_eq!(packet, bytes(100_000));
    }
}
