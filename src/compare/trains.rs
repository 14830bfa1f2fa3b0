//! The events of a packet, cell by cell.

use std::ops::Range;

use rayon::slice::ParallelSliceMut;

use crate::{
    event::{Event, Packet, Polarity},
    plane::Size,
    unit::Micros,
};

/// Up to so many cells are counted, however few events there are.
const FEW_CELLS: usize = 1 << 20;

/// A cell as a number: one pixel, kind and sign. From high bits to low: channel, row, column, sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell(u64);

impl Cell {
    /// As one number, all its own.
    pub(super) const fn word(self) -> u64 {
        self.0
    }

    /// The same kind and sign at another pixel.
    pub(super) const fn moved_to(self, x: u16, y: u16) -> Self {
        Self(self.0 >> 33 << 33 | (y as u64) << 17 | (x as u64) << 1 | self.0 & 1)
    }

    /// Its pixel and kind, whatever the sign.
    pub(super) const fn site(self) -> u64 {
        self.0 >> 1
    }

    pub(super) const fn new(channel: u8, y: u16, x: u16, sign: u8) -> Self {
        Self((channel as u64) << 33 | (y as u64) << 17 | (x as u64) << 1 | sign as u64)
    }

    const fn from_event(event: &Event) -> Self {
        Self::new(event.channel, event.y, event.x, event.polarity.bit())
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
        Polarity::of(self.0 & 1 == 1)
    }
}

/// The events of a packet, cell by cell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Trains {
    /// The times of all cells, one cell after the other, each ascending.
    times: Vec<u64>,
    /// The cells that spoke, ascending, and where the times of each end.
    cells: Vec<(Cell, usize)>,
}

impl Trains {
    /// Adds the times of a cell, which ascend, after those of all cells before it.
    pub(super) fn push(&mut self, cell: Cell, times: impl IntoIterator<Item = u64>) {
        self.times.extend(times);
        self.cells.push((cell, self.times.len()));
    }

    /// The times of all cells.
    pub(super) fn times(&self) -> &[u64] {
        &self.times
    }

    /// The cells, and where the times of each are.
    pub(super) fn cells(&self) -> impl Iterator<Item = (Cell, Range<usize>)> {
        let mut start = 0;
        self.cells
            .iter()
            .map(move |(cell, end)| (*cell, std::mem::replace(&mut start, *end)..*end))
    }

    pub(super) fn slice(&self, at: &Range<usize>) -> &[u64] {
        self.times.get(at.clone()).unwrap_or_default()
    }
}

/// The events of a packet, cell by cell.
///
/// # Errors
/// The first event outside of its size and channels.
pub(super) fn sorted(packet: &Packet) -> Result<Trains, &Event> {
    let (size, channels) = (packet.size, packet.channels);
    let cells = size.pixels().saturating_mul(2 * usize::from(channels));
    if cells <= FEW_CELLS.max(packet.events.len()) && u32::try_from(packet.events.len()).is_ok() {
        return by_cell(packet, cells);
    }
    if let Some(event) = packet
        .events
        .iter()
        .find(|event| !event.is_inside(packet.size, packet.channels))
    {
        return Err(event);
    }
    let events = packet.events.iter();
    let mut keys: Vec<(Cell, u64)> = events.map(|e| (Cell::from_event(e), e.t.0)).collect();
    keys.par_sort_unstable();
    let mut trains = Trains::default();
    trains.times.reserve_exact(keys.len());
    for own in keys.chunk_by(|a, b| a.0 == b.0) {
        if let Some((cell, _)) = own.first() {
            trains.push(*cell, own.iter().map(|(_, t)| *t));
        }
    }
    Ok(trains)
}

/// Counting sort by cell, which keeps the order of time in a packet that has it.
///
/// # Errors
/// The first event outside.
fn by_cell(packet: &Packet, cells: usize) -> Result<Trains, &Event> {
    let Size { height, width } = packet.size;
    let index = |e: &Event| {
        let row = usize::from(e.channel) * height + usize::from(e.y);
        2 * (row * width + usize::from(e.x)) + usize::from(e.polarity.bit())
    };
    let mut next = vec![0u32; cells];
    let mut in_order = true;
    let mut last = Micros(0);
    for event in &packet.events {
        if !event.is_inside(packet.size, packet.channels) {
            return Err(event);
        }
        next[index(event)] += 1;
        in_order &= last <= event.t;
        last = event.t;
    }
    let mut sum = 0;
    for place in &mut next {
        sum += std::mem::replace(place, sum);
    }
    let mut times = vec![0; packet.events.len()];
    for event in &packet.events {
        let place = &mut next[index(event)];
        times[*place as usize] = event.t.0;
        *place += 1;
    }
    // Each place is now where its cell ends.
    let mut spoke = Vec::new();
    let mut start = 0;
    for (row, ends) in next.chunks(2 * width.max(1)).enumerate() {
        for (at, end) in ends.iter().enumerate() {
            let end = *end as usize;
            if end > start {
                let (channel, y) = ((row / height) as u8, (row % height) as u16);
                spoke.push((Cell::new(channel, y, (at / 2) as u16, (at % 2) as u8), end));
                if !in_order {
                    times[start..end].sort_unstable();
                }
                start = end;
            }
        }
    }
    Ok(Trains {
        times,
        cells: spoke,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// In order of time or not, of few cells and of more than there are events.
        #[test]
        fn counting_gives_what_comparing_gives(
            events in proptest::collection::vec((0u64..50, 0u16..5, 0u16..3, 0u8..2, any::<bool>()), 0..200),
            in_order: bool,
        ) {
            let mut packet = Packet::new(Size::new(3, 5), 2);
            packet.events = { events.iter() }
                .map(|&(t, x, y, channel, on)| Event {
                    t: Micros(t),
                    x,
                    y,
                    polarity: Polarity::of(on),
                    channel,
                })
                .collect();
            if in_order {
                packet.events.sort_by_key(|event| event.t);
            }
            let mut keys: Vec<_> = { packet.events.iter() }
                .map(|e| (Cell::from_event(e), e.t.0))
                .collect();
            keys.sort_unstable();
            let trains = sorted(&packet).unwrap();
            let cells = trains.cells().flat_map(|(cell, at)| {
                trains.slice(&at).iter().map(move |t| (cell, *t)).collect::<Vec<_>>()
            });
            prop_assert_eq!(cells.collect::<Vec<_>>(), keys);
            let mut strange = packet.clone();
            strange.channels = 1;
            let first = packet.events.iter().find(|event| event.channel > 0);
            prop_assert_eq!(sorted(&strange).err(), first);
        }
    }
}
