//! How many binary digits what a program holds has: an arithmetic whose numbers have them computes
//! as the exact one does, to the bit.
//!
//! Each cell is an interval, and a power of two of which it is a whole multiple. Frames follow each
//! other until nothing new appears. Off the array, and next to it, anything between 0 and the edge
//! may stand in the place of a neighbour, so that both belong to every interval.

use std::sync::Mutex;

use super::{
    super::{Domain, LIMITS, Layout, Place, Settings, Share},
    form::Input,
    pixel::{GenericError, GenericPixel, Ran, Symbolic, effort},
    range::Interval,
};
use crate::{
    isa::{Analog, Device, operands::Access},
    number::{Dyadic, Format},
    plane::{At, Size},
    program::{Code, Step},
};

/// Programs that take more work on a generic pixel are not looked at.
const MOST_EFFORT: u64 = 400_000;

/// Frames after which something new still appears: a register that adds up, frame after frame.
const FRAMES: usize = 16;

/// A part that is a multiple of no power of two.
const ENDLESS: i32 = i32::MIN / 2;

/// 0 is a multiple of all.
const ANY: i32 = i32::MAX / 2;

/// Numbers between two ends that are whole multiples of `2^finest`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    low: f64,
    high: f64,
    finest: i32,
}

impl Span {
    const ZERO: Self = Self {
        low: 0.0,
        high: 0.0,
        finest: ANY,
    };

    fn of(value: f64) -> Self {
        Self {
            low: value,
            high: value,
            finest: Dyadic::from_f64(value).map_or(ENDLESS, finest),
        }
    }

    fn hull(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            finest: self.finest.min(other.finest),
        }
    }

    /// Whether so many binary digits are enough for all of them.
    fn has_at_most(self, digits: i32) -> bool {
        let largest = self.low.abs().max(self.high.abs());
        largest <= 0.0 || largest <= 2f64.powi(digits) * 2f64.powi(self.finest)
    }
}

/// The power of two that a number is an odd multiple of.
fn finest(value: Dyadic) -> i32 {
    if value.is_zero() {
        ANY
    } else {
        value.exponent()
    }
}

/// What a program's numbers need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Digits {
    /// In the cells.
    cells: Span,
    /// On the bus, while sources are added one after the other.
    sums: Span,
}

impl Digits {
    /// What a program's numbers need in light of whole numbers between these, whatever the
    /// number of frames; `None` where that cannot be said.
    #[must_use]
    pub fn of(code: &Code, device: &Device, settings: Settings, light: Interval) -> Option<Self> {
        let work = [&code.init, &code.frame].map(|steps| effort(steps, device));
        if work
            .into_iter()
            .any(|work| work.is_none_or(|work| work > MOST_EFFORT))
        {
            return None;
        }
        let mut found = Self {
            cells: Span::ZERO,
            sums: Span::ZERO,
        };
        let mut pass = |steps: &[Step], start: &[Span]| {
            let domain = Spans {
                start,
                light,
                edge: Span::of(settings.edge),
                sums: Mutex::new(Span::ZERO),
            };
            let end = domain
                .pass(steps, device, settings, &mut found.cells)
                .ok()?;
            let sums = domain.sums.into_inner().ok()?;
            found.sums = found.sums.hull(sums);
            Some(end)
        };
        let zero = Span::ZERO.hull(Span::of(settings.edge));
        let registers = Layout::new(device, Size::new(1, 1)).analog;
        let mut start = vec![zero; registers.into()];
        start = pass(&code.init, &start)?;
        for _ in 0..FRAMES {
            let end = pass(&code.frame, &start)?;
            let all: Vec<Span> = { start.iter().zip(end) }
                .map(|(start, end)| start.hull(end))
                .collect();
            if all == start {
                return Some(found);
            }
            start = all;
        }
        None
    }

    /// Whether cells of this format, and their bus, hold all of them as they are.
    #[must_use]
    pub fn fit(&self, format: Format) -> bool {
        let Self { cells, sums } = self;
        let (low, high) = format.limits();
        let is_inside = low <= cells.low && cells.high <= high;
        let floats = |digits, least| {
            cells.has_at_most(digits) && cells.finest >= least && sums.has_at_most(24)
        };
        is_inside
            && sums.has_at_most(53)
            && match format {
                Format::F64 => true,
                Format::F32 => floats(24, -126),
                Format::F16 => floats(11, -24),
                Format::Bf16 => floats(8, -126),
                // The bus is wide enough for every sum.
                Format::Fixed(format) => cells.finest >= -i32::from(format.fraction()),
            }
    }
}

/// The domain of spans.
struct Spans<'a> {
    /// What each register may hold beforehand.
    start: &'a [Span],
    light: Interval,
    edge: Span,
    /// What was on the bus.
    sums: Mutex<Span>,
}

impl Spans<'_> {
    /// What each register may hold after these steps; what they write joins `cells`.
    fn pass(
        &self,
        steps: &[Step],
        device: &Device,
        settings: Settings,
        cells: &mut Span,
    ) -> Result<Vec<Span>, GenericError> {
        let mut generic = GenericPixel::new(self, device, settings, steps)?;
        *cells = cells.hull(self.exposed(&settings));
        generic.run(steps, &mut |generic, Ran { word, .. }| {
            let operands = device.operands(word);
            for register in operands.writes().filter_map(Access::analog) {
                *cells = cells.hull(*generic.cell(register));
            }
        })?;
        *cells = cells.hull(generic.state.input);
        let registers = 0..generic.state.layout.analog;
        Ok(registers.map(|r| *generic.cell(Analog(r))).collect())
    }

    /// The photodiode.
    fn exposed(&self, settings: &Settings) -> Span {
        let [level, gain] = [settings.reset_level, settings.gain].map(Span::of);
        let ends = [self.light.low, self.light.high].map(|light| settings.gain * light);
        self.beside(Span {
            low: level.low + ends[0].min(ends[1]),
            high: level.high + ends[0].max(ends[1]),
            finest: level.finest.min(gain.finest),
        })
    }

    fn saw(&self, sum: &Bus) {
        let whole = Span {
            low: -sum.most,
            high: sum.most,
            finest: sum.span.finest,
        };
        if let Ok(mut sums) = self.sums.lock() {
            *sums = sums.hull(whole);
        }
    }

    /// What stands beside the array, or in its place, belongs to every cell.
    fn beside(&self, cell: Span) -> Span {
        cell.hull(Span::ZERO).hull(self.edge)
    }
}

/// A sum of cells.
#[derive(Clone)]
struct Bus {
    span: Span,
    /// The largest that any part of the sum can be.
    most: f64,
}

impl Domain for Spans<'_> {
    type Cell = Span;
    type Sum = Bus;

    fn name(&self) -> String {
        "digits".into()
    }

    fn hold(&self, value: f64) -> Span {
        Span::of(value)
    }

    fn value(&self, cell: &Span) -> f64 {
        if cell.low == cell.high {
            cell.low
        } else {
            f64::NAN
        }
    }

    fn nothing(&self) -> Bus {
        Bus {
            span: Span::ZERO,
            most: 0.0,
        }
    }

    fn add(&self, sum: &mut Bus, cell: &Span, times: i32) {
        let ends = [cell.low, cell.high].map(|end| end * f64::from(times));
        let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        sum.most += low.abs().max(high.abs());
        sum.span = Span {
            low: sum.span.low + low,
            high: sum.span.high + high,
            finest: sum.span.finest.min(cell.finest),
        };
    }

    fn join(&self, sum: &mut Bus, other: &Bus) {
        self.add(sum, &other.span, 1);
        sum.most = sum.most.max(other.most);
    }

    fn store(&self, sum: &Bus, share: Share, _: Place) -> Span {
        self.saw(sum);
        let by = f64::from(share.by);
        let Span { low, high, finest } = sum.span;
        self.beside(Span {
            low: (0.0 - high) / by,
            high: (0.0 - low) / by,
            finest: match finest {
                ANY => ANY,
                _ if share.by.is_power_of_two() => finest - share.by.trailing_zeros() as i32,
                _ => ENDLESS,
            },
        })
    }

    fn square(&self, _: &Bus, _: f64, _: Place) -> Option<Span> {
        None
    }

    /// Next to the array it may be another than in its middle.
    fn positive(&self, sum: &Bus) -> Option<bool> {
        self.saw(sum);
        None
    }

    fn limit(&self, cell: Span) -> Span {
        let (low, high) = LIMITS;
        if cell.low >= low && cell.high <= high {
            return cell;
        }
        Span {
            low: cell.low.clamp(low, high),
            high: cell.high.clamp(low, high),
            finest: cell.finest.min(0),
        }
    }
}

impl Symbolic for Spans<'_> {
    fn unknown(&self, input: Input, _: At) -> Span {
        match input {
            Input::Register(Analog(register)) => {
                let span = self.start.get(usize::from(register));
                span.copied().unwrap_or(Span::ZERO)
            }
            Input::Light => Span::ZERO,
        }
    }

    fn light(&self, settings: &Settings, _: At) -> Span {
        self.exposed(settings)
    }

    fn either(&self, old: &Span, new: &Span, _: u64) -> Span {
        old.hull(*new)
    }
}
