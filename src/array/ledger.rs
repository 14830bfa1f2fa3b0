//! What a program costs: the same count over its text and over its run.

use super::Settings;
use crate::{
    isa::Primitive,
    program::{Action, Host, Step},
    unit::Words,
};

/// The clock that an instruction word runs by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Class {
    /// Everything that moves currents, and words that wait.
    Analog,
    /// One-bit logic.
    Digital,
    /// One-bit reads from neighbours.
    Dnews,
    /// Asynchronous propagation.
    Prop,
}

impl Class {
    /// The class of an instruction word.
    #[must_use]
    pub const fn of(word: &Primitive) -> Self {
        match word {
            Primitive::Nop
            | Primitive::ResetPix
            | Primitive::Bus { .. }
            | Primitive::Square { .. }
            | Primitive::Where { .. }
            | Primitive::All
            | Primitive::BlurSet
            | Primitive::Blur { .. } => Self::Analog,
            Primitive::Set { .. }
            | Primitive::Clear { .. }
            | Primitive::Or { .. }
            | Primitive::Nor { .. }
            | Primitive::WhereBit { .. } => Self::Digital,
            Primitive::Dnews { .. } => Self::Dnews,
            Primitive::PropRead | Primitive::Prop { .. } => Self::Prop,
        }
    }
}

/// A count of what was, or will be, done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Ledger {
    /// Words on the analogue clock.
    pub analog: u64,
    /// Words on the digital clock.
    pub digital: u64,
    /// Words on the clock of DNEWS.
    pub dnews: u64,
    /// Words on the clock of PROP.
    pub prop: u64,
    /// Operations of the host.
    pub host: u64,
    /// Slots of event readout.
    pub slots: u64,
}

impl Ledger {
    /// What a body costs, once through.
    #[must_use]
    pub fn of(body: &[Step]) -> Self {
        let mut ledger = Self::default();
        for step in body {
            match &step.action {
                Action::Word(word) => ledger.word(word),
                Action::Host(host) => ledger.host(host),
                Action::Repeat { times, body } => {
                    let once = Self::of(body);
                    ledger.add(once, u64::from(*times));
                }
            }
        }
        ledger
    }

    /// One more word.
    pub(super) fn word(&mut self, word: &Primitive) {
        match Class::of(word) {
            Class::Analog => self.analog += 1,
            Class::Digital => self.digital += 1,
            Class::Dnews => self.dnews += 1,
            Class::Prop => self.prop += 1,
        }
    }

    /// One more operation of the host.
    pub(super) fn host(&mut self, host: &Host) {
        self.host += 1;
        if let Host::ScanEvents { slots, .. } | Host::ScanEventsFrom { slots, .. } = host {
            self.slots += u64::from(*slots);
        }
    }

    /// Another ledger, `times` over.
    pub fn add(&mut self, other: Self, times: u64) {
        self.analog += other.analog * times;
        self.digital += other.digital * times;
        self.dnews += other.dnews * times;
        self.prop += other.prop * times;
        self.host += other.host * times;
        self.slots += other.slots * times;
    }

    /// All instruction words.
    #[must_use]
    pub const fn words(&self) -> Words {
        Words(self.analog + self.digital + self.dnews + self.prop)
    }

    /// Microseconds on the chip: words and event slots. Other work of the host is not in it.
    #[must_use]
    pub fn micros(&self, settings: &Settings) -> f64 {
        self.words().0 as f64 * settings.word_us + self.slots as f64 * settings.slot_us
    }
}
