//! Two packets, sorted so that every metric is one walk over both.

use std::{ops::Range, sync::Arc};

use rayon::{
    iter::{IntoParallelIterator, ParallelIterator},
    slice::ParallelSliceMut,
};

use crate::{
    event::{Event, Packet, Polarity},
    plane::Size,
    unit::{Micros, counted},
};

/// Two packets cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum CompareError {
    /// Sensors of different sizes.
    #[error("the reference is {reference}, the judged packet {judged}")]
    #[diagnostic(help(
        "compare packets of one size; a sensor beside a packet needs a scene (`--scene`) of the packet's size"
    ))]
    Size {
        /// Size of the reference.
        reference: Size,
        /// Size of the other.
        judged: Size,
    },
    /// Different numbers of kinds of cells.
    #[error("the reference has {}, the judged packet {judged}", counted(*reference, "channel"))]
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

    const fn new(channel: u8, y: u16, x: u16, sign: u8) -> Self {
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
        if self.0 & 1 == 1 {
            Polarity::On
        } else {
            Polarity::Off
        }
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
    fn cells(&self) -> impl Iterator<Item = (Cell, Range<usize>)> {
        let mut start = 0;
        self.cells
            .iter()
            .map(move |(cell, end)| (*cell, std::mem::replace(&mut start, *end)..*end))
    }

    fn slice(&self, at: &Range<usize>) -> &[u64] {
        self.times.get(at.clone()).unwrap_or_default()
    }
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
    trains: [Arc<Trains>; 2],
    spoke: Vec<Spoke>,
}

/// The events of a packet, sorted for comparison: a reference that many packets are judged against
/// is sorted once.
#[derive(Clone, Debug)]
pub struct Sorted {
    size: Size,
    channels: u8,
    dropped: u64,
    trains: Arc<Trains>,
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
            trains: Arc::new(sorted(packet)?),
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
        let trains = [&self.trains, &judged.trains].map(Arc::clone);
        Pair {
            size: self.size,
            channels: self.channels,
            dropped: [self.dropped, judged.dropped],
            spoke: spoke(&trains[0], &trains[1]),
            trains,
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
        self.with_judged(Arc::clone(&self.trains[0]))
    }

    /// The reference, and events in place of the judged packet's.
    pub(super) fn with_judged(&self, judged: Arc<Trains>) -> Self {
        let trains = [Arc::clone(&self.trains[0]), judged];
        Self {
            size: self.size,
            channels: self.channels,
            dropped: [self.dropped[0]; 2],
            spoke: spoke(&trains[0], &trains[1]),
            trains,
        }
    }

    /// The times of the reference, by cell, then time.
    pub(super) fn reference(&self) -> &[u64] {
        self.trains[0].times()
    }

    /// Every cell that spoke in the reference, and where its times are.
    pub(super) fn reference_cells(&self) -> impl Iterator<Item = (Cell, Range<usize>)> {
        self.trains[0].cells()
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
        let ends = |own: &[u64]| Some((*own.first()?, *own.last()?));
        self.spoke
            .iter()
            .flat_map(|spoke| self.slices(&spoke.events).map(ends))
            .flatten()
            .reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
            .map(|(first, last)| (Micros(first), Micros(last)))
    }

    /// The times at which anything happened, each once and ascending, [reference, judged].
    #[must_use]
    pub fn times(&self) -> [Vec<u64>; 2] {
        [0, 1].map(|i| {
            let mut times = self.trains[i].times.clone();
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
        [0, 1].map(|i| self.trains[i].times.len() as u64)
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
                let mut both = [Signed::default(); 2];
                for spoke in site {
                    for (signed, times) in both.iter_mut().zip(self.slices(&spoke.events)) {
                        match spoke.cell.polarity() {
                            Polarity::Off => signed.off = times,
                            Polarity::On => signed.on = times,
                        }
                    }
                }
                add(sum, both[0], both[1]);
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

    fn slices(&self, at: &[Range<usize>; 2]) -> [&[u64]; 2] {
        [0, 1].map(|i| self.trains[i].slice(&at[i]))
    }
}

/// The cells with events in either of two packets.
fn spoke(a: &Trains, b: &Trains) -> Vec<Spoke> {
    let (mut a, mut b) = (a.cells().peekable(), b.cells().peekable());
    let mut all = Vec::with_capacity(a.size_hint().0.max(b.size_hint().0));
    while let Some(cell) = a
        .peek()
        .into_iter()
        .chain(b.peek())
        .map(|next| next.0)
        .min()
    {
        let [first, second] = [
            a.next_if(|next| next.0 == cell),
            b.next_if(|next| next.0 == cell),
        ]
        .map(|own| own.map_or(0..0, |(_, at)| at));
        all.push(Spoke {
            cell,
            events: [first, second],
        });
    }
    all
}

/// The times of one pixel and kind, of both signs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Signed<'a> {
    off: &'a [u64],
    on: &'a [u64],
}

impl<'a> Signed<'a> {
    /// One by one: time in microseconds, and sign; first OFF in order of time, then ON.
    pub fn iter(self) -> impl Iterator<Item = (u64, Polarity)> + 'a {
        let off = self.off.iter().map(|t| (*t, Polarity::Off));
        off.chain(self.on.iter().map(|t| (*t, Polarity::On)))
    }

    /// How many of each sign, [OFF, ON].
    #[must_use]
    pub const fn counts(self) -> [u64; 2] {
        [self.off.len() as u64, self.on.len() as u64]
    }
}

/// The times of one cell, ascending.
#[derive(Clone, Copy, Debug)]
pub struct Times<'a>(&'a [u64]);

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
        self.0.iter().copied()
    }
}

/// The events of a packet, cell by cell.
fn sorted(packet: &Packet) -> Result<Trains, CompareError> {
    let (size, channels) = (packet.size, packet.channels);
    let outside = |event: &Event| CompareError::Outside {
        event: *event,
        size,
        channels,
    };
    let cells = 2 * usize::from(channels) * size.height * size.width;
    if cells <= FEW_CELLS.max(packet.events.len()) && u32::try_from(packet.events.len()).is_ok() {
        return by_cell(packet, cells).map_err(outside);
    }
    if let Some(event) = packet.events.iter().find(|event| !is_inside(packet, event)) {
        return Err(outside(event));
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

fn is_inside(packet: &Packet, event: &Event) -> bool {
    usize::from(event.x) < packet.size.width
        && usize::from(event.y) < packet.size.height
        && event.channel < packet.channels
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
        if !is_inside(packet, event) {
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
                    polarity: if on { Polarity::On } else { Polarity::Off },
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
            let said = sorted(&strange).err();
            prop_assert_eq!(said, first.map(|event| CompareError::Outside {
                event: *event,
                size: strange.size,
                channels: 1,
            }));
        }
    }
}
