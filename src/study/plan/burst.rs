//! Burst: what an arbiter can do at worst, whatever the order of the events.
//!
//! All events of a pair of frames may come at once. An arbiter that is never idle while one
//! waits has read and sent `k` of them after at most `k (row + event + link)`. So no event waits
//! longer than for those that are there when it comes, at most all of its pair and what was left
//! before.

use crate::event::readout::{Arbiter, Readout, Requests, WhenFull};

use super::bounds::Bounds;

/// Events that the readout may lose, or deliver later than the window; `None` where that cannot
/// be said.
pub(super) fn bound(bounds: &Bounds) -> Option<f64> {
    match bounds.readout? {
        Readout::Ideal(_) => Some(0.0),
        Readout::Arbiter(arbiter) => at_worst(bounds, &arbiter),
        // Their frames merge and move events by rule, not when there are many.
        Readout::Scan(_) | Readout::Frame(_) => None,
    }
}

fn at_worst(bounds: &Bounds, arbiter: &Arbiter) -> Option<f64> {
    let followed = bounds.followed.as_ref()?;
    if bounds.upsampled {
        return None;
    }
    let each = arbiter.row.seconds() + arbiter.event.seconds() + arbiter.link.seconds();
    let strays = if bounds.present.strays {
        bounds.stray_events()
    } else {
        0.0
    };
    // A cell that fires again before it was read is not heard.
    let apart = bounds.closest();
    let (mut left, mut waited, mut changed) = (0.0_f64, 0.0_f64, 0.0);
    for (dt, events) in &followed.pairs {
        let events = *events as f64 + strays;
        let there = left + events;
        let wait = there * each;
        let merges = arbiter.requests == Requests::One && wait.max(waited) >= apart;
        let fills = arbiter.when_full != WhenFull::Stall
            && arbiter.fifo.is_some_and(|depth| there > depth as f64);
        if wait > bounds.within || merges || fills {
            changed += 2.0 * events;
        }
        waited = wait;
        left = (there - dt / each.max(1e-12)).max(0.0);
    }
    Some(changed)
}
