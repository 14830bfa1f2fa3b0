//! Two packets, sorted so that every metric is one walk over both.

use rayon::slice::ParallelSliceMut;

use crate::{
    event::{Event, Packet, Polarity},
    plane::Size,
};

/// Two packets cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum CompareError {
    /// Sensors of different sizes.
    #[error("the reference is {reference}, the judged packet {judged}")]
    #[diagnostic(help("compare packets of one size; crop or convert one of them first"))]
    Size {
        /// Size of the reference.
        reference: Size,
        /// Size of the other.
        judged: Size,
    },
    /// Different numbers of kinds of cells.
    #[error("the reference has {reference} channels, the judged packet {judged}")]
    #[diagnostic(help("compare packets of the same kinds of cells"))]
    Channels {
        /// Channels of the reference.
        reference: u8,
        /// Channels of the other.
        judged: u8,
    },
    /// An event that its own packet has no cell for.
    #[error("an event at x {}, y {} of channel {} in a packet of {size} and {channels} channels", event.x, event.y, event.channel)]
    #[diagnostic(help("the packet is inconsistent: correct its size, its channels or the event"))]
    Outside {
        /// The event.
        event: Event,
        /// Size of its packet.
        size: Size,
        /// Channels of its packet.
        channels: u8,
    },
}

/// One pixel, kind and sign, as a number: channel, row, column, sign from high bits to low.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell(u64);

impl Cell {
    const fn of(event: &Event) -> Self {
        Self(
            (event.channel as u64) << 33
                | (event.y as u64) << 17
                | (event.x as u64) << 1
                | event.polarity.bit() as u64,
        )
    }

    /// Kind of cell.
    #[must_use]
    pub const fn channel(self) -> u8 {
        (self.0 >> 33) as u8
    }

    /// Row.
    #[must_use]
    pub const fn y(self) -> u16 {
        (self.0 >> 17) as u16
    }

    /// Column.
    #[must_use]
    pub const fn x(self) -> u16 {
        (self.0 >> 1) as u16
    }

    /// Sign.
    #[must_use]
    pub const fn polarity(self) -> Polarity {
        if self.0 & 1 == 1 {
            Polarity::On
        } else {
            Polarity::Off
        }
    }
}

/// An event as one number, cell above and time below, so that sorting is comparing integers.
type Key = u128;

const fn cell(key: Key) -> Cell {
    Cell((key >> 64) as u64)
}

const fn time(key: Key) -> u64 {
    key as u64
}

/// The reference and what is judged, each sorted by cell, then time.
#[derive(Clone, Debug)]
pub struct Pair {
    size: Size,
    channels: u8,
    keys: [Vec<Key>; 2],
}

impl Pair {
    /// Sorts two packets for comparison.
    ///
    /// # Errors
    /// When they are not of the same size and number of channels, or hold events outside.
    pub fn of(reference: &Packet, judged: &Packet) -> Result<Self, CompareError> {
        let (size, channels) = (reference.size, reference.channels);
        if size != judged.size {
            return Err(CompareError::Size {
                reference: size,
                judged: judged.size,
            });
        }
        if channels != judged.channels {
            return Err(CompareError::Channels {
                reference: channels,
                judged: judged.channels,
            });
        }
        Ok(Self {
            size,
            channels,
            keys: [sorted(reference)?, sorted(judged)?],
        })
    }

    /// Number of events, [reference, judged].
    #[must_use]
    pub fn events(&self) -> [u64; 2] {
        [self.keys[0].len() as u64, self.keys[1].len() as u64]
    }

    /// Kinds of cells per pixel.
    #[must_use]
    pub const fn channels(&self) -> u8 {
        self.channels
    }

    /// Number of cells, silent ones included: two signs of each kind at each pixel. None where
    /// 128 bits do not hold it.
    #[must_use]
    pub fn cell_count(&self) -> Option<i128> {
        (self.size.height as i128)
            .checked_mul(self.size.width as i128)?
            .checked_mul(i128::from(self.channels) * 2)
    }

    /// Every cell that spoke in either packet, with its times in the reference and in the
    /// other, both ascending.
    pub fn cells(&self) -> impl Iterator<Item = (Cell, Times<'_>, Times<'_>)> {
        let [mut a, mut b] = [self.keys[0].as_slice(), self.keys[1].as_slice()];
        std::iter::from_fn(move || {
            let next = match (a.first(), b.first()) {
                (Some(a), Some(b)) => cell(*a).min(cell(*b)),
                (Some(key), None) | (None, Some(key)) => cell(*key),
                (None, None) => return None,
            };
            Some((next, Times(split(&mut a, next)), Times(split(&mut b, next))))
        })
    }
}

/// Takes the events of `of` off the front of `keys`.
fn split<'a>(keys: &mut &'a [Key], of: Cell) -> &'a [Key] {
    let end = keys
        .iter()
        .position(|key| cell(*key) != of)
        .unwrap_or(keys.len());
    let (front, rest) = keys.split_at(end);
    *keys = rest;
    front
}

/// The times of one cell, ascending.
#[derive(Clone, Copy, Debug)]
pub struct Times<'a>(&'a [Key]);

impl<'a> Times<'a> {
    /// How many.
    #[must_use]
    pub const fn len(self) -> usize {
        self.0.len()
    }

    /// None at all.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0.is_empty()
    }

    /// One by one, in microseconds.
    pub fn iter(self) -> impl Iterator<Item = u64> + 'a {
        self.0.iter().map(|key| time(*key))
    }
}

fn sorted(packet: &Packet) -> Result<Vec<Key>, CompareError> {
    let (size, channels) = (packet.size, packet.channels);
    let mut keys = packet
        .events
        .iter()
        .map(|event| {
            let inside = usize::from(event.x) < size.width
                && usize::from(event.y) < size.height
                && event.channel < channels;
            let key = Key::from(Cell::of(event).0) << 64 | Key::from(event.t.0);
            inside.then_some(key).ok_or(CompareError::Outside {
                event: *event,
                size,
                channels,
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    keys.par_sort_unstable();
    Ok(keys)
}
