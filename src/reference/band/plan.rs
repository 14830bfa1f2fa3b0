//! The constants of a sensor, which its bands share, and their input in an interval.

use crate::{
    mosaic::Mosaic,
    number::Number,
    plane::Size,
    reference::{
        description::Description,
        drive::{self, Exact, Weights},
        reason::Place,
        sheets::Sheets,
        signal::{Light, Padded},
        thresholds::Thresholds,
        train::Interval,
    },
    sensor::Overflowed,
};

/// The constants of a sensor, which all of its bands share.
#[derive(Clone, Debug)]
pub(in crate::reference) struct Plan<N: Number> {
    pub(in crate::reference) number: N,
    pub(in crate::reference) description: Description,
    pub(in crate::reference) seed: u64,
    /// For each channel.
    pub(in crate::reference) weights: Vec<Weights<N::Held>>,
    /// The same in doubles, where the format is fixed point; else none.
    pub(in crate::reference) exact: Vec<Exact>,
    pub(in crate::reference) memory_weights: Vec<Option<Weights<N::Held>>>,
    pub(in crate::reference) thresholds: Vec<Thresholds<N::Real>>,
    /// Where each cell is at home, row by row, where that is not where it lies: random numbers
    /// are drawn for that place.
    homes: Option<Homes>,
}

/// The home of each cell of a mosaic.
#[derive(Clone, Debug)]
struct Homes {
    places: Vec<(u16, u16)>,
    width: usize,
}

impl Homes {
    fn new(mosaic: &Mosaic) -> Self {
        let size = mosaic.size();
        let cells = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (y, x)));
        let home = |(y, x)| {
            let at = mosaic.home(y, x);
            (at.y as u16, at.x as u16)
        };
        Self {
            places: cells.map(home).collect(),
            width: size.width,
        }
    }
}

impl<N: Number> Plan<N> {
    pub(in crate::reference) fn new(
        number: N,
        description: Description,
        size: Size,
        seed: u64,
        mosaic: Option<&Mosaic>,
    ) -> Self {
        let homes = mosaic.map(Homes::new);
        let home = |y: usize, x: usize| home(homes.as_ref(), y, x);
        let channels = &description.channels;
        let weights = channels
            .iter()
            .map(|c| Weights::new(&number, &c.kernels))
            .collect();
        let exact = channels.iter();
        let exact = exact.filter_map(|c| Exact::new(&number, &c.kernels));
        let exact = exact.collect();
        let memory_weights = channels
            .iter()
            .map(|c| {
                c.memory_kernel
                    .as_ref()
                    .map(|k| Weights::new(&number, std::slice::from_ref(k)))
            })
            .collect();
        let thresholds = channels
            .iter()
            .enumerate()
            .map(|(number, channel)| {
                Thresholds::new(&channel.thresholds, size, seed, (number, &home))
            })
            .collect();
        Self {
            number,
            description,
            seed,
            weights,
            exact,
            memory_weights,
            thresholds,
            homes,
        }
    }

    /// What random numbers of a cell are drawn for.
    #[inline]
    pub(super) fn place(&self, channel: usize, y: usize, x: usize) -> Place {
        let (y, x) = home(self.homes.as_ref(), y, x);
        Place {
            seed: self.seed,
            channel,
            y,
            x,
        }
    }

    /// How many drives of row `y` of a channel, of these pixels (`most` at most) or of its grids, the
    /// format does not hold.
    pub(super) fn overflowed(
        &self,
        (channel, y): (usize, usize),
        (pixels, most, sheets): (&Padded<N::Held>, f64, Option<&Sheets>),
        drive: &[N::Held],
    ) -> Overflowed {
        let Some(exact) = self.exact.get(channel) else {
            return Overflowed::default();
        };
        match sheets.and_then(|sheets| sheets.row(channel, y)) {
            Some(reals) => drive::held(&self.number, drive, reals),
            // Nearly always no light so far can make so much.
            None if exact.holds(most, false) => Overflowed {
                at: 0,
                of: drive.len() as u64,
            },
            None => exact.overflowed(&self.number, pixels, y, drive),
        }
    }

    pub(super) fn refractory(&self) -> f64 {
        self.description.refractory.us * 1e-6
    }
}

/// The home of a cell.
#[inline]
fn home(homes: Option<&Homes>, y: usize, x: usize) -> (usize, usize) {
    let Some(homes) = homes else { return (y, x) };
    let place = homes.places.get(y * homes.width + x);
    place.map_or((y, x), |(y, x)| ((*y).into(), (*x).into()))
}

/// The input of all bands in an interval.
#[derive(Debug)]
pub(in crate::reference) struct IntervalInput<'a, N: Number> {
    /// The frame; `None` if the bands have its signal already.
    pub(in crate::reference) light: Option<Light<'a, N>>,
    /// For each channel, or once where all share a memory, where it holds pixels: the memory if
    /// it steps, the signal's distance from it if it snaps.
    pub(in crate::reference) pixels: &'a [Padded<N::Held>],
    /// The resistive grids, for channels that see through one.
    pub(in crate::reference) sheets: Option<&'a Sheets>,
    pub(in crate::reference) interval: Interval,
    /// Seconds since the first frame.
    pub(in crate::reference) elapsed: f64,
    /// Whether the times of the events are wanted.
    pub(in crate::reference) times: bool,
}

impl<'a, N: Number> IntervalInput<'a, N> {
    /// The pixels that a channel's kernel sees.
    pub(super) fn pixels_of(&self, channel: usize) -> &'a Padded<N::Held> {
        self.pixels.get(channel).unwrap_or(&self.pixels[0])
    }
}

/// Implemented by hand: derived, it would require `N: Copy`.
impl<N: Number> Copy for IntervalInput<'_, N> {}

#[expect(clippy::expl_impl_clone_on_copy, reason = "as above")]
impl<N: Number> Clone for IntervalInput<'_, N> {
    fn clone(&self) -> Self {
        *self
    }
}
