//! Two packets, sorted so that every metric is one walk over both.

use std::{ops::Range, sync::Arc};

use rayon::{
    iter::{IntoParallelIterator, ParallelIterator},
    slice::ParallelSliceMut,
};

use super::trains::{Cell, Trains, sorted};
use crate::{
    event::{Outside, Packet, Polarity},
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
    #[error(transparent)]
    #[diagnostic(transparent)]
    Outside(#[from] Outside),
}

/// A cell with events, and the indices of its events, [reference, judged].
#[derive(Clone, Debug)]
struct Spoke {
    cell: Cell,
    events: [Range<usize>; 2],
}

/// Cells in one piece of work; fixed, so that sums do not depend on the number of threads.
const PIECE: usize = 512;

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
        let (size, channels) = (packet.size, packet.channels);
        let trains = sorted(packet).map_err(|event| Outside {
            event: *event,
            size,
            channels,
        })?;
        Ok(Self {
            size,
            channels,
            dropped: packet.dropped.total(),
            trains: Arc::new(trains),
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
            let mut times = self.trains[i].times().to_vec();
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
        [0, 1].map(|i| self.trains[i].times().len() as u64)
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
