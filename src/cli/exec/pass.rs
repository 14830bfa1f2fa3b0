//! One pass of the program over its light, with all that is looked at on the way.

use std::ops::ControlFlow;

use super::{
    bench::Bench, debug::Debugger, moment::Part, shows::Shows, strip::Strip, trace::Tracer,
};
use crate::{array::Array, event::Packet, rig::guard::Guard, study::saturation::Saturation};

/// What a pass leaves.
pub struct Pass<'a> {
    pub chip: Box<dyn Array + Send>,
    pub packet: Packet,
    pub frames: u64,
    pub guard: Guard,
    pub saturation: Saturation,
    pub strip: Strip,
    pub tracer: Option<Tracer<'a>>,
    pub shows: Shows<'a>,
}

impl<'a> Pass<'a> {
    /// Runs all frames; where `until_full`, no more after a frame for whose events the readout had
    /// too few slots.
    ///
    /// # Errors
    /// When the light or the array cannot go on, or a file cannot be written.
    pub fn new(bench: &'a Bench<'_>, until_full: bool) -> miette::Result<Self> {
        let arguments = bench.arguments;
        let mut chip = bench.chip(arguments.seed())?;
        let mut strip = Strip::new(bench.written());
        let traced = arguments.trace.as_ref();
        let mut tracer = traced.map(|_| Tracer::new(bench)).transpose()?;
        let mut guard = Guard::new();
        let mut saturation = bench.saturation();
        let mut shows = Shows::new(&bench.opened, arguments.displays.as_deref());
        let (packet, frames) = if arguments.debug {
            let mut debugger = Debugger::new(bench);
            let seen = bench.watch(&mut *chip, |chip, moment, packet| {
                guard.frame_at(moment.t);
                let flow = debugger.frame(chip, moment, packet)?;
                if flow.is_break() {
                    bench.said.stopped.set(true);
                }
                saturation.frame(chip);
                shows.frame(chip, moment.index)?;
                Ok(flow)
            })?;
            debugger.end(&*chip)?;
            seen
        } else {
            bench.watch(&mut *chip, |chip, moment, packet| {
                guard.frame_at(moment.t);
                if moment.part != Part::Ran {
                    saturation.before(chip, moment.steps);
                }
                if arguments.strip.is_some() {
                    strip.frame(&bench.opened, chip, moment, packet)?;
                } else {
                    moment.run(chip, packet)?;
                }
                if let Some(tracer) = &mut tracer {
                    tracer.frame(moment)?;
                }
                saturation.frame(chip);
                shows.frame(chip, moment.index)?;
                Ok(if until_full && packet.dropped.no_slot > 0 {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                })
            })?
        };
        Ok(Self {
            chip,
            packet,
            frames,
            guard,
            saturation,
            strip,
            tracer,
            shows,
        })
    }
}
