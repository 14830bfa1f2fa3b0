//! Two packets, sorted so that every metric is one walk over both.

use std::{ops::Range, sync::Arc};

use rayon::{
    iter::{IntoParallelIterator, ParallelIterator},
    slice::ParallelSliceMut,
};

use crate::{
    event::{Event, Packet, Polarity},
    plane::Size,
    unit::Micros,
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
    const fn site(self) -> u64 {
        self.0 >> 1
    }

    /// An event of this cell.
    pub(super) const fn at(self, t: u64) -> Key {
        (self.0 as Key) << 64 | t as Key
    }

    const fn from_event(event: &Event) -> Self {
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

/// An event as one number, cell above and time below, so that sorting compares integers.
pub(super) type Key = u128;

const fn cell(key: Key) -> Cell {
    Cell((key >> 64) as u64)
}

pub(super) const fn time(key: Key) -> u64 {
    key as u64
}

/// A cell with events, and the indices of its events, [reference, judged].
#[derive(Clone, Debug)]
struct Spoke {
    cell: Cell,
    events: [Range<usize>; 2],
}

/// Cells in one piece of work; fixed, so that sums do not depend on the number of threads.
const PIECE: usize = 512;

/// Up to so many cells are counted, however few events there are.
const FEW_CELLS: usize = 1 << 20;

/// The reference and what is judged, each sorted by cell, then time.
#[derive(Clone, Debug)]
pub struct Pair {
    size: Size,
    channels: u8,
    dropped: [u64; 2],
    keys: [Arc<Vec<Key>>; 2],
    spoke: Vec<Spoke>,
}

/// The events of a packet, sorted for comparison: a reference that many packets are judged against
/// is sorted once.
#[derive(Clone, Debug)]
pub struct Sorted {
    size: Size,
    channels: u8,
    dropped: u64,
    keys: Arc<Vec<Key>>,
}

impl Sorted {
    /// Sorts a packet by cell, then time.
    ///
    /// # Errors
    /// When it holds events outside of its own size and channels.
    pub fn new(packet: &Packet) -> Result<Self, CompareError> {
        Ok(Self {
            size: packet.size,
            channels: packet.channels,
            dropped: packet.dropped.total(),
            keys: Arc::new(sorted(packet)?),
        })
    }

    /// This packet as the reference, and another that is judged against it.
    ///
    /// # Errors
    /// When they are not of the same size and number of channels, or the other holds events outside.
    pub fn judge(&self, judged: &Packet) -> Result<Pair, CompareError> {
        check_alike((self.size, self.channels), judged)?;
        Ok(self.beside(&Self::new(judged)?))
    }

    /// This packet, judged against itself.
    #[must_use]
    pub fn identical(&self) -> Pair {
        self.beside(self)
    }

    /// Both are of one size.
    fn beside(&self, judged: &Self) -> Pair {
        let keys = [&self.keys, &judged.keys].map(Arc::clone);
        Pair {
            size: self.size,
            channels: self.channels,
            dropped: [self.dropped, judged.dropped],
            spoke: spoke(&keys[0], &keys[1]),
            keys,
        }
    }
}

/// Whether a packet is of the same size and number of channels as a reference.
fn check_alike((size, channels): (Size, u8), judged: &Packet) -> Result<(), CompareError> {
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
    Ok(())
}

impl Pair {
    /// Sorts two packets for comparison.
    ///
    /// # Errors
    /// When they are not of the same size and number of channels, or hold events outside.
    pub fn new(reference: &Packet, judged: &Packet) -> Result<Self, CompareError> {
        check_alike((reference.size, reference.channels), judged)?;
        let (reference, judged) = rayon::join(|| Sorted::new(reference), || Sorted::new(judged));
        Ok(reference?.beside(&judged?))
    }

    /// The reference, judged against itself.
    #[must_use]
    pub fn identical(&self) -> Self {
        self.with_judged(Arc::clone(&self.keys[0]))
    }

    /// The reference, and events in place of the judged packet's. They ascend.
    pub(super) fn with_judged(&self, judged: Arc<Vec<Key>>) -> Self {
        let keys = [Arc::clone(&self.keys[0]), judged];
        Self {
            size: self.size,
            channels: self.channels,
            dropped: [self.dropped[0]; 2],
            spoke: spoke(&keys[0], &keys[1]),
            keys,
        }
    }

    /// The events of the reference, by cell, then time.
    pub(super) fn reference(&self) -> &[Key] {
        &self.keys[0]
    }

    /// Every cell that spoke in the reference, and where its events are.
    pub(super) fn reference_cells(&self) -> impl Iterator<Item = (Cell, Range<usize>)> {
        self.spoke
            .iter()
            .filter(|spoke| !spoke.events[0].is_empty())
            .map(|spoke| (spoke.cell, spoke.events[0].clone()))
    }

    /// Size of both sensors.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The first and the last time of either packet; none without events.
    #[must_use]
    pub fn span(&self) -> Option<(Micros, Micros)> {
        // The times of a cell ascend, so its first and last are its ends.
        let ends = |side: &[Key], at: &Range<usize>| {
            let own = side.get(at.clone())?;
            Some((time(*own.first()?), time(*own.last()?)))
        };
        self.spoke
            .iter()
            .flat_map(|spoke| [0, 1].map(|i| ends(&self.keys[i], &spoke.events[i])))
            .flatten()
            .reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
            .map(|(first, last)| (Micros(first), Micros(last)))
    }

    /// The times at which anything happened, each once and ascending, [reference, judged].
    #[must_use]
    pub fn times(&self) -> [Vec<u64>; 2] {
        [0, 1].map(|i| {
            let mut times: Vec<u64> = self.keys[i].iter().map(|key| time(*key)).collect();
            times.par_sort_unstable();
            times.dedup();
            times
        })
    }

    /// `total` divided by the mean number of events of the two; 0 where nobody spoke.
    #[must_use]
    pub fn per_event(&self, total: f64) -> f64 {
        let [a, b] = self.events();
        let mean = u128::from(a) + u128::from(b);
        if mean == 0 {
            0.0
        } else {
            2.0 * total / mean as f64
        }
    }

    /// Number of events, [reference, judged].
    #[must_use]
    pub fn events(&self) -> [u64; 2] {
        [self.keys[0].len() as u64, self.keys[1].len() as u64]
    }

    /// Events that each sensor made and could not deliver, [reference, judged].
    #[must_use]
    pub const fn dropped(&self) -> [u64; 2] {
        self.dropped
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

    /// Pixels and kinds, silent ones included: half the cells, since signs are not told apart.
    #[must_use]
    pub fn site_count(&self) -> Option<i128> {
        self.cell_count().map(|cells| cells / 2)
    }

    /// Every cell with events in either packet, with its times in the reference and in the judged
    /// packet, both ascending.
    pub fn cells(&self) -> impl Iterator<Item = (Cell, Times<'_>, Times<'_>)> {
        self.spoke.iter().map(|spoke| {
            let [a, b] = self.slices(&spoke.events);
            (spoke.cell, Times(a), Times(b))
        })
    }

    /// A parallel fold over the cells: every piece of work starts with `start`, adds its cells with
    /// `add`, and the pieces are joined in the order of the cells.
    pub fn fold<T: Send>(
        &self,
        start: impl Fn() -> T + Sync,
        add: impl Fn(&mut T, Times<'_>, Times<'_>) + Sync,
        join: impl Fn(T, T) -> T,
    ) -> T {
        let piece = |sum: &mut T, piece: &[Spoke]| {
            for spoke in piece {
                let [a, b] = self.slices(&spoke.events);
                add(sum, Times(a), Times(b));
            }
        };
        self.walk(start, piece, join)
    }

    /// As [`Pair::fold`], both signs of a pixel and kind at once.
    pub fn fold_sites<T: Send>(
        &self,
        start: impl Fn() -> T + Sync,
        add: impl Fn(&mut T, Signed<'_>, Signed<'_>) + Sync,
        join: impl Fn(T, T) -> T,
    ) -> T {
        let piece = |sum: &mut T, piece: &[Spoke]| {
            for site in piece.chunk_by(|a, b| a.cell.site() == b.cell.site()) {
                if let (Some(first), Some(last)) = (site.first(), site.last()) {
                    // OFF lies right before ON.
                    let both = [0, 1].map(|i| first.events[i].start..last.events[i].end);
                    let [a, b] = self.slices(&both);
                    add(sum, Signed(a), Signed(b));
                }
            }
        };
        self.walk(start, piece, join)
    }

    fn walk<T: Send>(
        &self,
        start: impl Fn() -> T + Sync,
        add: impl Fn(&mut T, &[Spoke]) + Sync,
        join: impl Fn(T, T) -> T,
    ) -> T {
        let one = |piece: &[Spoke]| {
            let mut sum = start();
            add(&mut sum, piece);
            sum
        };
        // Never without a piece, though it may be empty.
        let sums: Vec<T> = self.pieces().into_par_iter().map(one).collect();
        sums.into_iter().reduce(join).unwrap_or_else(start)
    }

    /// The cells in pieces that do not separate the signs of a pixel.
    fn pieces(&self) -> Vec<&[Spoke]> {
        let mut rest = self.spoke.as_slice();
        let mut pieces = Vec::new();
        while let Some(last) = rest.get(PIECE - 1) {
            let more = rest[PIECE..]
                .iter()
                .take_while(|spoke| spoke.cell.site() == last.cell.site());
            let (piece, after) = rest.split_at(PIECE + more.count());
            pieces.push(piece);
            rest = after;
        }
        pieces.push(rest);
        pieces
    }

    fn slices(&self, at: &[Range<usize>; 2]) -> [&[Key]; 2] {
        [0, 1].map(|i| self.keys[i].get(at[i].clone()).unwrap_or_default())
    }
}

/// The cells with events in either of two ascending lists.
fn spoke(a: &[Key], b: &[Key]) -> Vec<Spoke> {
    let mut at = [0, 0];
    let mut all = Vec::new();
    loop {
        let next = match (a.get(at[0]), b.get(at[1])) {
            (Some(a), Some(b)) => cell(*a).min(cell(*b)),
            (Some(key), None) | (None, Some(key)) => cell(*key),
            (None, None) => return all,
        };
        let events = [end(a, at[0], next), end(b, at[1], next)];
        at = [events[0].end, events[1].end];
        all.push(Spoke { cell: next, events });
    }
}

/// Where the events of `of` are, when they can start only at `from`.
fn end(keys: &[Key], from: usize, of: Cell) -> Range<usize> {
    let own = keys[from..].iter().take_while(|key| cell(**key) == of);
    from..from + own.count()
}

/// The events of one pixel and kind, of both signs.
#[derive(Clone, Copy, Debug)]
pub struct Signed<'a>(&'a [Key]);

impl<'a> Signed<'a> {
    /// One by one: time in microseconds, and sign; first OFF in order of time, then ON.
    pub fn iter(self) -> impl Iterator<Item = (u64, Polarity)> + 'a {
        self.0.iter().map(|key| (time(*key), cell(*key).polarity()))
    }

    /// How many of each sign, [OFF, ON].
    #[must_use]
    pub fn counts(self) -> [u64; 2] {
        let off = self
            .0
            .partition_point(|key| cell(*key).polarity() == Polarity::Off);
        [off as u64, (self.0.len() - off) as u64]
    }
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

/// The keys of a packet's events, ascending.
fn sorted(packet: &Packet) -> Result<Vec<Key>, CompareError> {
    let (size, channels) = (packet.size, packet.channels);
    let inside = |event: &&Event| {
        usize::from(event.x) < size.width
            && usize::from(event.y) < size.height
            && event.channel < channels
    };
    if let Some(event) = packet.events.iter().find(|event| !inside(event)) {
        return Err(CompareError::Outside {
            event: *event,
            size,
            channels,
        });
    }
    let cells = 2 * usize::from(channels) * size.height * size.width;
    if cells <= FEW_CELLS.max(packet.events.len()) && u32::try_from(packet.events.len()).is_ok() {
        return Ok(by_cell(packet, cells));
    }
    let events = packet.events.iter();
    let mut keys: Vec<Key> = events.map(|e| Cell::from_event(e).at(e.t.0)).collect();
    keys.par_sort_unstable();
    Ok(keys)
}

/// Counting sort by cell, which keeps the order of time in a packet that has it.
fn by_cell(packet: &Packet, cells: usize) -> Vec<Key> {
    let Size { height, width } = packet.size;
    let index = |e: &Event| {
        let row = usize::from(e.channel) * height + usize::from(e.y);
        2 * (row * width + usize::from(e.x)) + usize::from(e.polarity.bit())
    };
    let mut next = vec![0u32; cells];
    for event in &packet.events {
        next[index(event)] += 1;
    }
    let mut sum = 0;
    for place in &mut next {
        sum += std::mem::replace(place, sum);
    }
    let mut keys = vec![0; packet.events.len()];
    for event in &packet.events {
        let place = &mut next[index(event)];
        keys[*place as usize] = Cell::from_event(event).at(event.t.0);
        *place += 1;
    }
    if !packet.events.is_sorted_by_key(|event| event.t) {
        // Each place is now where its cell ends.
        let mut start = 0;
        for end in next {
            keys[start..end as usize].sort_unstable();
            start = end as usize;
        }
    }
    keys
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
                    polarity: if on { Polarity::On } else { Polarity::Off },
                    channel,
                })
                .collect();
            if in_order {
                packet.events.sort_by_key(|event| event.t);
            }
            let mut keys: Vec<Key> = { packet.events.iter() }
                .map(|e| Cell::from_event(e).at(e.t.0))
                .collect();
            keys.sort_unstable();
            prop_assert_eq!(sorted(&packet), Ok(keys));
        }
    }
}
