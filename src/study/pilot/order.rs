//! The order of the array's work, and formats that hold all numbers as they are: they change no
//! event, so that only a clock is asked.

use super::{Chips, Machine, family::Family, first_frames::clocked};
use crate::{array::Schedule, scene::kept::Kept};

/// A way to run a program that is quicker than the one that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Quicker {
    /// What cells hold.
    pub machine: Machine,
    /// The order.
    pub schedule: Schedule,
    /// Seconds of a frame: as was asked for, and so.
    pub seconds: [f64; 2],
}

/// Frames that are timed in each way, after one that fills caches.
const TIMED: usize = 2;

/// Frames that two ways see.
const SEEN: f64 = 2.0 * (TIMED as f64 + 1.0);

/// A way that saves less than this part of the time is not worth it.
const WORTH: f64 = 0.07;

/// The quickest way to run a machine on the whole array, from its first frames: it, or one of those
/// that have the same events (`alike`), each in its schedule, then the best of them in the other one.
/// None where that is the way that it has, or where trying would take more than a part of the run
/// and some seconds besides (`budget`). A schedule that was asked for stays. `clock`: seconds since
/// any moment.
#[must_use]
pub fn quicker(
    family: &Chips<'_>,
    (machine, alike): (&Machine, &[Machine]),
    kept: &Kept,
    budget: (f64, f64),
    clock: &(dyn Fn() -> f64 + Sync),
) -> Option<Quicker> {
    if budget.1 < 0.0 {
        return None;
    }
    let stated = family.settings.schedule;
    let schedule = stated.unwrap_or_else(|| Schedule::for_size(kept.size()));
    let own = per_frame(family, machine, schedule, kept, clock)?;
    let budget = budget.0 * own * kept.len() as f64 + budget.1;
    let (mut best, mut spent) = ((machine, schedule, own), SEEN / 2.0 * own);
    let mut is_tried = false;
    let mut attempt = |machine, schedule, best: &mut (_, _, f64)| {
        // What is tried may take as long as the best so far.
        let more = SEEN / 2.0 * best.2;
        if spent + more > budget {
            return;
        }
        let Some(seconds) = per_frame(family, machine, schedule, kept, clock) else {
            return;
        };
        spent += SEEN / 2.0 * seconds;
        is_tried = true;
        if seconds < (1.0 - WORTH) * best.2 {
            *best = (machine, schedule, seconds);
        }
    };
    for machine in alike {
        attempt(machine, schedule, &mut best);
    }
    if stated.is_none() {
        let other = match schedule {
            Schedule::Plain => Schedule::Tiled { rows: 0 },
            Schedule::Tiled { .. } => Schedule::Plain,
        };
        let machine = best.0;
        attempt(machine, other, &mut best);
    }
    let (quickest, order, seconds) = best;
    (is_tried && (quickest != machine || order != schedule)).then(|| Quicker {
        machine: quickest.clone(),
        schedule: order,
        seconds: [own, seconds],
    })
}

/// Seconds of a frame, the least of some; none where the program cannot go on.
fn per_frame(
    family: &Chips<'_>,
    machine: &Machine,
    schedule: Schedule,
    kept: &Kept,
    clock: &(dyn Fn() -> f64 + Sync),
) -> Option<f64> {
    let mut family = *family;
    family.settings.schedule = Some(schedule);
    let sensor = family.whole(machine, kept.size()).ok()?;
    let (seconds, _) = clocked(sensor, kept, TIMED, clock).ok()??;
    Some(seconds.into_iter().fold(f64::INFINITY, f64::min))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::{
        array::{Arithmetic, Settings},
        isa::Device,
        number::Format,
        plane::{Plane, Size},
        program::{Overrides, Program},
        scene::{Frame, held::Held},
    };

    /// The clock decides, and what would take too long to try is not tried.
    #[test]
    fn the_quicker_order_is_the_clocks() {
        let device = Device::scamp5();
        let text = "//! channels = 1\ninit { get_image(A); }\nframe { get_image(A); }\n";
        let code = Program::parse("order", text).unwrap();
        let code = code.expand(&device, &Overrides::default()).unwrap().code;
        let family = Chips {
            name: "order",
            code: &code,
            device: &device,
            settings: Settings {
                schedule: None,
                ..Settings::from_device(&device)
            },
            arithmetic: Arithmetic::Number(Format::F64),
        };
        let size = Size::new(4, 4);
        let frames = (0..4).map(|index| Frame {
            index,
            seconds: index as f64,
            light: Plane::zeros(size.shape()).into(),
        });
        let mut held = Held::new(frames.collect(), size, 1.0);
        let kept = Kept::new(&mut held, 1 << 20).unwrap().unwrap();
        let usual = Schedule::for_size(size);
        let f32 = Machine {
            format: Some(Format::F32),
            without: Vec::new(),
        };
        // Two readings a frame; the first way sees three frames.
        let asked = |slow: [u64; 2], alike: &[Machine], budget| {
            let (now, readings) = (AtomicU64::new(0), AtomicU64::new(0));
            let clock = || {
                let reading = readings.fetch_add(1, Ordering::Relaxed);
                let step = slow[usize::from(reading >= 4)];
                now.fetch_add(step, Ordering::Relaxed) as f64
            };
            let ways = (&family.machine(), alike);
            quicker(&family, ways, &kept, budget, &clock)
        };
        let found = asked([10, 2], &[], (0.0, 1e9)).unwrap();
        assert_eq!(found.machine, family.machine());
        assert_ne!(found.schedule, usual);
        assert!(found.seconds[1] < found.seconds[0]);
        let alike = std::slice::from_ref(&f32);
        let found = asked([10, 2], alike, (0.0, 1e9)).unwrap();
        assert_eq!((found.machine, found.schedule), (f32.clone(), usual));
        assert_eq!(asked([2, 10], alike, (0.0, 1e9)), None);
        assert_eq!(asked([10, 2], alike, (0.04, 0.0)), None);
    }
}
