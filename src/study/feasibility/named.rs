//! The chip's numbers that an answer rests on, by name.

use crate::{
    isa::{Device, Evidence, Figure, HostKind, Interval, PrimitiveKind, Quantity},
    program::{Action, Step},
};

/// What no compiled sensor uses, and how large the chip is, on which only whether there is room
/// rests.
const NO_RESULT: [Figure; 11] = [
    Figure::Height,
    Figure::Width,
    Figure::Pitch,
    Figure::Store,
    Figure::WordBits,
    Figure::AdcCodes,
    Figure::DacCodes,
    Figure::EdgeFlag,
    Figure::DiffusionParts,
    Figure::SquareGain,
    Figure::Travel,
];

/// How much room a chip has.
const ROOM: [Figure; 3] = [Figure::Height, Figure::Width, Figure::Store];

/// The operations of the host by which events leave the chip, slot by slot or row by row.
const OF_READOUT: [HostKind; 2] = [HostKind::ScanEvents, HostKind::ScanDigital];

/// The operations of the host that compiled sensors call.
const CALLED: [HostKind; 3] = [
    HostKind::LoadIn,
    HostKind::ScanEvents,
    HostKind::ScanDigital,
];

/// The instructions that compiled sensors are made of, but for those that only wait.
const OF_SENSORS: [PrimitiveKind; 6] = [
    PrimitiveKind::ResetPix,
    PrimitiveKind::Bus,
    PrimitiveKind::Where,
    PrimitiveKind::All,
    PrimitiveKind::Or,
    PrimitiveKind::WhereBit,
];

/// A number in a chip's data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Named {
    /// One about the silicon.
    Figure(Figure),
    /// The time of each slot, sample or row of an operation of the host.
    Item(HostKind),
    /// The time of a call of an operation of the host.
    Call(HostKind),
    /// The words of an instruction.
    Words(PrimitiveKind),
}

impl Named {
    /// All that have an interval, in the order of the chip's data.
    #[must_use]
    pub fn with_interval(device: &Device) -> Vec<Self> {
        let figures = Figure::ALL.iter().copied().map(Self::Figure);
        let items = OF_READOUT.map(Self::Item).into_iter();
        let all = figures.chain(items).chain(CALLED.map(Self::Call));
        // An interval of one value leaves nothing to draw.
        let is_open = |it: &Interval| it.low < it.high;
        all.filter(|named| named.interval(device).is_some_and(is_open))
            .collect()
    }

    /// All on which what comes out of the chips rests: events, time and power.
    #[must_use]
    pub fn of_results(device: &Device) -> Vec<Self> {
        let figures = { Figure::ALL.iter() }.filter(|figure| !NO_RESULT.contains(figure));
        let items = OF_READOUT.map(Self::Item).into_iter();
        let items = items.filter(|named| named.quantity(device).is_some());
        let calls = CALLED.map(Self::Call).into_iter();
        let calls = calls.filter(|call| call.takes_time(device));
        let figures = figures.copied().map(Self::Figure);
        figures.chain(items).chain(calls).collect()
    }

    /// Whether it may be more than 0: a call that is said to lie within its slots or rows is not.
    #[must_use]
    pub fn takes_time(self, device: &Device) -> bool {
        self.ends(device)[1] > 0.0
    }

    /// Those on which a verdict rests and that are guesses of one value: nobody says how far off
    /// they may be, and no chip is drawn elsewhere.
    #[must_use]
    pub fn guessed_values(device: &Device) -> Vec<Self> {
        let is_bare = |quantity: &Quantity| {
            quantity.evidence == Evidence::Guess && quantity.interval.is_none()
        };
        let mut all = Self::of_results(device);
        all.extend(OF_SENSORS.map(Self::Words));
        all.retain(|named| {
            *named != Self::Figure(Figure::Power) && named.quantity(device).is_some_and(is_bare)
        });
        all
    }

    /// What leaves open whether a chip has room for so many rows, columns and words of its store: a
    /// guess of one value, or an interval that the number lies in.
    #[must_use]
    pub fn open_room(device: &Device, needed: [Option<u64>; 3]) -> Vec<Self> {
        let is_open = |(figure, needed): &(Figure, Option<u64>)| {
            let quantity = device.figure(*figure);
            let [low, high] = quantity.ends();
            needed.is_some_and(|needed| {
                quantity.evidence == Evidence::Guess && quantity.interval.is_none()
                    || low < needed as f64 && needed as f64 <= high
            })
        };
        { ROOM.into_iter().zip(needed) }
            .filter(is_open)
            .map(|(figure, _)| Self::Figure(figure))
            .collect()
    }

    /// Whether it says how much room there is.
    #[must_use]
    pub fn is_of_room(name: &str) -> bool {
        ROOM.iter()
            .any(|figure| Self::Figure(*figure).name() == name)
    }

    /// The words of each instruction of a frame.
    #[must_use]
    pub fn words_of(frame: &[Step]) -> Vec<Self> {
        let mut found: Vec<PrimitiveKind> = Vec::new();
        kinds(frame, &mut found);
        found.into_iter().map(Self::Words).collect()
    }

    /// Whether what is made of it tells it: the words of an instruction only where they are neither
    /// measured nor stated by whoever made the chip.
    #[must_use]
    pub fn is_told(self, device: &Device) -> bool {
        match self {
            Self::Words(kind) => {
                let evidence = device.row(kind).cost.evidence;
                matches!(evidence, Evidence::Guess | Evidence::Modelled)
            }
            Self::Figure(_) | Self::Item(_) | Self::Call(_) => true,
        }
    }

    /// What a chip computes with: numbers on which its events depend, and not only their cost.
    #[must_use]
    pub const fn is_of_events(self) -> bool {
        match self {
            Self::Figure(figure) => !matches!(
                figure,
                Figure::Clock | Figure::Launch | Figure::Power | Figure::Pitch
            ),
            Self::Item(_) | Self::Call(_) | Self::Words(_) => false,
        }
    }

    /// As `section.key`, or the operation's name and `item` or `call`.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Figure(figure) => {
                let (section, key) = figure.key();
                format!("{section}.{key}")
            }
            Self::Item(kind) => format!("{}.item", HostKind::WORDS[kind as usize]),
            Self::Call(kind) => format!("{}.call", HostKind::WORDS[kind as usize]),
            Self::Words(kind) => format!("{}.words", kind.word()),
        }
    }

    /// Its unit.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Figure(figure) => figure.unit(),
            Self::Item(_) | Self::Call(_) => "us",
            Self::Words(_) => "words",
        }
    }

    /// What the chip's data say of it; nothing where an operation has no such time.
    #[must_use]
    pub fn quantity(self, device: &Device) -> Option<&Quantity> {
        match self {
            Self::Figure(figure) => Some(device.figure(figure)),
            Self::Item(kind) => device.host(kind).item.as_ref(),
            Self::Call(kind) => Some(&device.host(kind).call),
            Self::Words(kind) => Some(&device.row(kind).cost),
        }
    }

    /// Between which values it may lie.
    #[must_use]
    pub fn interval(self, device: &Device) -> Option<&Interval> {
        self.quantity(device)?.interval.as_ref()
    }

    /// Its value; 0 where an operation has no such time.
    #[must_use]
    pub fn value(self, device: &Device) -> f64 {
        self.quantity(device).map_or(0.0, |it| it.value)
    }

    /// The least and the most; the value twice where no interval was stated.
    #[must_use]
    pub fn ends(self, device: &Device) -> [f64; 2] {
        self.quantity(device).map_or([0.0; 2], Quantity::ends)
    }
}

/// Adds the instructions of some steps, each once.
fn kinds(steps: &[Step], found: &mut Vec<PrimitiveKind>) {
    for step in steps {
        match &step.action {
            Action::Word(word) if !found.contains(&word.kind()) => found.push(word.kind()),
            Action::Repeat { body, .. } => kinds(body, found),
            Action::Word(_) | Action::Host(_) => {}
        }
    }
}

/// A number about the chip, as the answer tells it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct FigureSummary {
    /// As `section.key`.
    pub figure: String,
    /// The value.
    pub value: f64,
    /// The least that it may be.
    pub low: f64,
    /// The most.
    pub high: f64,
    /// Its unit.
    pub unit: &'static str,
    /// How well the value is known.
    pub evidence: Evidence,
    /// How well it is known that it lies between the two: as well as the weaker of both.
    pub interval_evidence: Evidence,
    /// Who states the value.
    pub source: String,
    /// Why it is not less, and not more; nothing where no interval was stated.
    pub why: Option<String>,
}

impl FigureSummary {
    /// Of all that have an interval, and of those that events, times and power are made of.
    /// `words`: those of the instructions of a frame.
    pub(super) fn all(device: &Device, words: &[Named]) -> Vec<Self> {
        let mut named = Named::with_interval(device);
        let others = Named::of_results(device).into_iter();
        let of_costs = [Figure::Clock, Figure::Launch, Figure::Power, Figure::Store];
        let calls = [
            HostKind::LoadIn,
            HostKind::ScanBoundingBox,
            HostKind::GlobalCount,
            HostKind::GlobalSum,
            HostKind::GlobalOr,
        ];
        let hosts = OF_READOUT.map(Named::Item).into_iter();
        let costs = of_costs.map(Named::Figure).into_iter().chain(hosts);
        let costs = costs.chain(calls.map(Named::Call));
        for other in costs.chain(words.iter().copied()).chain(others) {
            if other.is_told(device) && !named.contains(&other) {
                named.push(other);
            }
        }
        { named.into_iter() }
            .filter_map(|named| Self::new(named, device))
            .collect()
    }

    fn new(named: Named, device: &Device) -> Option<Self> {
        let quantity = named.quantity(device)?;
        let [low, high] = quantity.ends();
        Some(Self {
            figure: named.name(),
            value: quantity.value,
            low,
            high,
            unit: named.unit(),
            evidence: quantity.evidence,
            interval_evidence: quantity.interval_evidence(),
            source: quantity.source.clone(),
            why: quantity.interval.as_ref().map(|it| it.why.clone()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_guess_and_model_that_matters_has_an_interval() {
        let device = Device::scamp5();
        for figure in Figure::ALL {
            let named = Named::Figure(*figure);
            let quantity = device.figure(*figure);
            let weak = matches!(quantity.evidence, Evidence::Guess | Evidence::Modelled);
            if weak && !NO_RESULT.contains(figure) {
                let interval = named.interval(&device);
                let interval = interval.unwrap_or_else(|| panic!("{}", named.name()));
                assert!(interval.low < interval.high && interval.why.len() > 20);
            }
        }
        assert_eq!(Named::guessed_values(&device), []);
        let names: Vec<String> = { Named::with_interval(&device).into_iter() }
            .map(Named::name)
            .collect();
        for name in ["clock.rate", "error.noise", "scan_events.item"] {
            assert!(names.iter().any(|n| n == name), "{name}");
        }
    }
}
