//! What a verb may hold (`--max-memory`), and the refusal of more before the work begins.

use std::{path::Path, sync::OnceLock};

use crate::{
    event::{Event, Packet},
    memory::{Budget, Bytes, Need},
    reference::Limit,
    save::free_space,
    scene::{OpenOptions, Scene},
};

static BUDGET: OnceLock<Budget> = OnceLock::new();

/// Bytes of an event while a sensor makes it: in the packet, and noted until its pair is sorted.
pub const MADE: u128 = size_of::<Event>() as u128 + 16;

/// Bytes of a pixel of a sensor in a study, float or silicon, with a share of its events.
pub const SENSOR: u128 = 160;

/// The fewest events that a list is begun for.
const SHORTEST: usize = 1000;

/// Sets what all verbs may hold: what was asked for, else what the machine has.
pub fn allow(asked: Option<Budget>) {
    let _ = BUDGET.set(asked.unwrap_or_else(Budget::from_machine));
}

/// What may be held.
pub fn budget() -> Budget {
    *BUDGET.get_or_init(Budget::from_machine)
}

/// Refuses what would hold more than may be held; `help` says what would make it less.
pub fn check(need: &Need, what: &str, help: &str) -> miette::Result<()> {
    Ok(need.within(budget(), what, help)?)
}

/// Refuses a file for which its disk has no room; `help` says what would make it smaller.
pub fn check_disk(path: &Path, bytes: u128, what: &str, help: &str) -> miette::Result<()> {
    let Some(free) = free_space(path)
        .map(u128::from)
        .filter(|free| bytes > *free)
    else {
        return Ok(());
    };
    Err(miette::miette!(
        help = format!("{help}, or write them where there is more room"),
        "{what} would take {} in {}, where {} are free",
        Bytes(bytes),
        path.display(),
        Bytes(free)
    ))
}

/// How a scene is opened: within what may be held.
pub fn opening(fps: Option<f64>) -> OpenOptions {
    OpenOptions {
        fps,
        memory: Some(budget()),
        ..OpenOptions::default()
    }
}

/// What a scene holds.
pub fn of_scene(scene: &dyn Scene) -> Need {
    Need::new().and("frames of the scene", scene.outline().bytes)
}

/// Refuses a scene for which there is no room beside so many sensors that watch it.
pub fn check_study(scene: &dyn Scene, sensors: usize) -> miette::Result<()> {
    let size = scene.size();
    let bytes = SENSOR * sensors as u128 * size.pixels() as u128;
    let part = format!("{sensors} sensors that watch side by side");
    let what = format!("a study on frames of {size}");
    let need = of_scene(scene).and(part, bytes);
    check(&need, &what, "take a smaller scene")
}

/// How many events a list may hold beside `need`, each `bytes`: as many as were asked for, else
/// the usual bound or what there is room for.
pub fn events(
    need: &Need,
    asked: Option<usize>,
    bytes: u128,
    what: &str,
    help: &str,
) -> miette::Result<usize> {
    let Some(asked) = asked else {
        return Ok(Limit::default().events.min(room(need, bytes, what, help)?));
    };
    let help = format!("{help}, give a smaller --max-events");
    check(&with_list(need, asked, bytes), what, &help)?;
    Ok(asked)
}

/// How many events, each `bytes`, there is room for beside `need`.
pub fn room(need: &Need, bytes: u128, what: &str, help: &str) -> miette::Result<usize> {
    check(&with_list(need, SHORTEST, bytes), what, help)?;
    Ok((u128::from(need.left(budget())) / bytes) as usize)
}

fn with_list(need: &Need, events: usize, bytes: u128) -> Need {
    let part = format!("a list of up to {events} events");
    need.clone().and(part, bytes * events as u128)
}

/// The events that a packet may come to hold while something else holds `need`.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    most: usize,
}

impl Growth {
    /// What is left beside `need`.
    pub fn beside(need: &Need) -> Self {
        let room = u128::from(need.left(budget())) / size_of::<Event>() as u128;
        Self {
            most: room as usize,
        }
    }

    /// Stops a packet that has grown beyond it.
    pub fn check(self, packet: &Packet, what: &str) -> miette::Result<()> {
        if packet.events.len() <= self.most {
            return Ok(());
        }
        let held = Need::new().and(
            format!(
                "{} so far",
                crate::unit::counted(packet.events.len(), "event")
            ),
            Packet::bytes(packet.events.len() as u64),
        );
        Err(miette::miette!(
            help = "take fewer frames, or allow more with --max-memory SIZE",
            "{what}: no memory for more events: {held}; the limit for events is {}",
            Bytes(Packet::bytes(self.most as u64))
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_ends_where_the_memory_does() {
        let need = Need::new();
        let bytes = need.left(budget());
        assert_eq!(room(&need, 1, "it", "").unwrap() as u64, bytes);
        let usual = Limit::default().events;
        assert_eq!(events(&need, None, 1, "it", "").unwrap(), usual);
        assert_eq!(
            events(&need, Some(usual + 1), 1, "it", "").unwrap(),
            usual + 1
        );
    }
}
