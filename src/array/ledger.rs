//! What a run cost, counted while it ran.
//!
//! [`Cost::of`](crate::program::Cost::of) says the same beforehand, from the program alone; a
//! test holds the two together.

use crate::{
    isa::{Clock, Device, Primitive},
    program::{Cost, Host, array_us, host_us},
    unit::Words,
};

/// A count of what was done since the chip was switched on.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Ledger {
    /// Words on the analogue clock.
    pub analog: u64,
    /// Words on the digital clock.
    pub digital: u64,
    /// Words on the clock of DNEWS.
    pub dnews: u64,
    /// Words on the clock of PROP.
    pub prop: u64,
    /// Kernels launched.
    pub launches: u64,
    /// Operations of the host.
    pub host: u64,
    /// Their time, in microseconds.
    pub host_us: f64,
    /// Slots of event readout asked for.
    pub slots: u64,
    /// Events read out.
    pub events: u64,
    /// Set pixels that found no slot.
    pub missed: u64,
    /// Set pixels in rows that no scan of their frame read.
    pub unscanned: u64,
    /// Events at the chip's (0,0), which a host cannot tell from the end of the list. They are
    /// in our packets.
    pub ambiguous: u64,
}

impl Ledger {
    /// One more instruction.
    pub(super) fn word(&mut self, word: &Primitive, device: &Device) {
        let row = device.row(word.kind());
        *match row.clock {
            Clock::Analog => &mut self.analog,
            Clock::Digital => &mut self.digital,
            Clock::Dnews => &mut self.dnews,
            Clock::Prop => &mut self.prop,
        } += row.words();
    }

    /// What a block costs, once more.
    pub(super) const fn block(&mut self, cost: &Self) {
        self.analog += cost.analog;
        self.digital += cost.digital;
        self.dnews += cost.dnews;
        self.prop += cost.prop;
        self.launches += cost.launches;
    }

    /// One more operation of the host.
    pub(super) fn host(&mut self, host: &Host, device: &Device) {
        self.host += 1;
        self.host_us += host_us(host, device);
        if let Host::ScanEvents { slots, .. } = host {
            self.slots += u64::from(*slots);
        }
    }

    /// All instruction words.
    #[must_use]
    pub const fn words(&self) -> Words {
        Words(self.analog + self.digital + self.dnews + self.prop)
    }

    /// What that cost on this chip.
    #[must_use]
    pub fn cost(&self, device: &Device) -> Cost {
        let words = self.words();
        Cost {
            words,
            array_us: array_us(words, self.launches, device),
            host_us: self.host_us,
        }
    }
}
