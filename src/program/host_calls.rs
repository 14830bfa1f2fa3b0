//! What the host does in some steps: calls, and slots, samples or rows, operation by operation.

use super::{
    code::{Action, Step},
    cost::host_calls,
};
use crate::isa::{Device, Evidence, HostKind, Quantity};

/// Calls of one operation of the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HostCalls {
    /// The operation.
    pub kind: HostKind,
    /// How often it is called.
    pub calls: f64,
    /// Slots, samples or rows of all calls.
    pub items: f64,
}

/// The times of an operation of the host, us: of a call, and of a slot, a sample or a row.
pub type HostTimes = [f64; 2];

impl HostCalls {
    /// All of some steps, each operation once.
    #[must_use]
    pub fn of(steps: &[Step], device: &Device) -> Vec<Self> {
        let mut all = Vec::new();
        collect(steps, device, 1.0, &mut all);
        all
    }

    /// Their time, us.
    #[must_use]
    pub fn us(&self, [call, item]: HostTimes) -> f64 {
        self.calls * call + self.items * item
    }

    /// The least and the most times of an operation by the chip's data.
    #[must_use]
    pub fn times(kind: HostKind, device: &Device) -> [HostTimes; 2] {
        let row = device.host(kind);
        let call = row.call.ends();
        let item = row.item.as_ref().map_or([0.0; 2], Quantity::ends);
        [0, 1].map(|end| [call[end], item[end]])
    }

    /// The least and the most time that some take by the chip's data, us, and how well that is known.
    #[must_use]
    pub fn between(all: &[Self], device: &Device) -> ([f64; 2], Evidence) {
        let us = |end: usize| {
            all.iter()
                .map(|it| it.us(Self::times(it.kind, device)[end]))
                // A sum of nothing would be -0.
                .fold(0.0, |all, us| all + us)
        };
        let parts = all.iter().flat_map(|it| {
            let row = device.host(it.kind);
            [(it.calls, Some(&row.call)), (it.items, row.item.as_ref())]
        });
        // What takes no time may be known as badly as it likes.
        let known = parts.filter_map(|(count, quantity)| {
            let quantity = quantity.filter(|it| count * it.ends()[1] > 0.0)?;
            Some(quantity.interval_evidence())
        });
        ([us(0), us(1)], Evidence::weakest(known))
    }
}

/// Adds what some steps do, so many times over.
fn collect(steps: &[Step], device: &Device, times: f64, all: &mut Vec<HostCalls>) {
    for step in steps {
        match &step.action {
            Action::Host(host) => {
                let (kind, [calls, items]) = (host.kind(), host_calls(host, device));
                let (calls, items) = (times * calls, times * items);
                if let Some(known) = all.iter_mut().find(|it| it.kind == kind) {
                    known.calls += calls;
                    known.items += items;
                } else {
                    all.push(HostCalls { kind, calls, items });
                }
            }
            Action::Repeat { body, times: turns } => {
                collect(body, device, times * f64::from(*turns), all);
            }
            Action::Word(_) => {}
        }
    }
}
