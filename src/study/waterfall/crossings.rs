//! How often the float sensor's thresholds are crossed: a threshold far below what light moves by
//! gives more events than anybody can follow, and that is known before any sensor runs.

use std::ops::ControlFlow;

use crate::{
    number::Format,
    reference::{Limit, MemoryRule, Reference, Sinks, Tally},
    rig,
    scene::Scene,
    study::{
        design::Design,
        equivalent::{self, RUNGS},
    },
};

use super::WaterfallError;

/// Shows the scene to the float sensor of each design at the times of its crossings, with the
/// lowest threshold of its ladder, and says no where one has more events than a list of them holds.
/// No event is kept.
///
/// # Errors
/// [`WaterfallError::Crossings`]; when scene or sensor cannot go on.
pub fn check_crossings(
    designs: &[Design<'_>],
    scene: &mut dyn Scene,
) -> Result<(), WaterfallError> {
    let size = scene.size();
    let mut sensors = Vec::new();
    for design in designs {
        let description = design.description(MemoryRule::FilteredStep)?;
        let description = equivalent::at_part(&description, RUNGS[0]);
        let sensor = Reference::in_format(Format::F64, description, size, design.seed);
        sensors.push((design, sensor?, Tally::new(1)));
    }
    let most = Limit::default().events as u64;
    let mut pairs = 0.0;
    rig::play(scene, |frame| {
        for (design, sensor, tally) in &mut sensors {
            let sinks = Sinks {
                tally: Some(&mut *tally),
                ..Sinks::default()
            };
            sensor.watch_into_sinks(&frame, sinks)?;
            if tally.total() > most {
                return Err(WaterfallError::Crossings {
                    threshold: design.threshold,
                    part: RUNGS[0],
                    each: tally.total() as f64 / (pairs * size.pixels() as f64),
                    most,
                });
            }
        }
        pairs += 1.0;
        Ok(ControlFlow::Continue(()))
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        compile::Effort,
        isa::Device,
        kernel::Kernel,
        plane::Plane,
        scene::{OpenOptions, open},
    };

    #[test]
    fn a_threshold_far_below_the_light_is_refused() {
        let device = Device::scamp5();
        let kernel = Kernel::new(Plane::ones((1, 1))).unwrap();
        let check = |threshold| {
            let design = Design {
                kernel: &kernel,
                threshold,
                device: &device,
                effort: Effort::default(),
                seed: 0,
            };
            let scene = "pattern:noise?width=32&height=32&frames=10&fps=100&speed=60";
            check_crossings(
                &[design],
                &mut *open(scene, &OpenOptions::default()).unwrap(),
            )
        };
        assert!(check(1.0).is_ok());
        let said = check(1e-5).unwrap_err();
        let WaterfallError::Crossings { each, most, .. } = said else {
            panic!("{said}");
        };
        // 32 x 32 pixels, 9 pairs of frames.
        assert!(each * 9.0 * 1024.0 > most as f64, "{each}");
    }
}
