//! The order of the array's work: it changes no event, so that only a clock is asked.

use super::{Chips, Machine, family::Family, first_frames::clocked, measure::WORTH};
use crate::{array::Schedule, scene::kept::Kept};

/// A schedule that is quicker than the one that was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quicker {
    /// The quicker one.
    pub schedule: Schedule,
    /// Seconds of a frame: in the schedule that was asked for, and in this one.
    pub seconds: [f64; 2],
}

/// Frames that are timed in each order, after one that fills caches.
const TIMED: usize = 2;

/// Frames that both orders see.
const SEEN: f64 = 2.0 * (TIMED as f64 + 1.0);

/// The quicker schedule of a machine on the whole array, from its first frames; none where that is
/// the one it has, or where trying would take more than a part of the run and some seconds besides
/// (`budget`). `clock`: seconds since any moment.
#[must_use]
pub fn quicker(
    family: &Chips<'_>,
    machine: &Machine,
    kept: &Kept,
    budget: (f64, f64),
    clock: &(dyn Fn() -> f64 + Sync),
) -> Option<Quicker> {
    if budget.1 < 0.0 {
        return None;
    }
    let asked = family.settings.schedule;
    let asked = asked.unwrap_or_else(|| Schedule::for_size(kept.size()));
    let other = match asked {
        Schedule::Plain => Schedule::Tiled { rows: 0 },
        Schedule::Tiled { .. } => Schedule::Plain,
    };
    let own = per_frame(family, machine, asked, kept, clock)?;
    let whole = own * kept.len() as f64;
    if SEEN * own > budget.0 * whole + budget.1 {
        return None;
    }
    let seconds = per_frame(family, machine, other, kept, clock)?;
    (seconds < (1.0 - WORTH) * own).then_some(Quicker {
        schedule: other,
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
    let seconds = clocked(sensor, kept, TIMED, clock).ok()??;
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
                schedule: Some(Schedule::Plain),
                ..Settings::from_device(&device)
            },
            arithmetic: Arithmetic::Number(Format::F64),
            reads_all: false,
        };
        let size = Size::new(4, 4);
        let frames = (0..4).map(|index| Frame {
            index,
            seconds: index as f64,
            light: Plane::zeros(size.shape()).into(),
        });
        let mut held = Held::new(frames.collect(), size, 1.0);
        let kept = Kept::new(&mut held, 1 << 20).unwrap().unwrap();
        // Two readings a frame; the first order sees three frames.
        let asked = |slow: [u64; 2], budget| {
            let (now, readings) = (AtomicU64::new(0), AtomicU64::new(0));
            let clock = || {
                let reading = readings.fetch_add(1, Ordering::Relaxed);
                let step = slow[usize::from(reading >= 4)];
                now.fetch_add(step, Ordering::Relaxed) as f64
            };
            quicker(&family, &family.machine(), &kept, budget, &clock)
        };
        let found = asked([10, 2], (0.0, 1e9)).unwrap();
        assert_eq!(found.schedule, Schedule::Tiled { rows: 0 });
        assert!(found.seconds[1] < found.seconds[0]);
        assert_eq!(asked([2, 10], (0.0, 1e9)), None);
        assert_eq!(asked([10, 2], (0.04, 0.0)), None);
    }
}
