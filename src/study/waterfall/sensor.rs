//! The sensor that is left when some steps are switched on and the others off.

use std::collections::BTreeSet;

use super::{
    cause::Cause,
    program::Kinds,
    question::{Question, WaterfallError},
};
use crate::{
    array::{Arithmetic, Settings},
    event::{Event, Packet},
    isa::Errors,
    number::Format,
    plane::Size,
    reference::MemoryRule,
    scene::Frame,
    sensor::{Overflowed, Sensor, SensorError, Silence},
    study::pilot::ErrorTerm,
    unit::Micros,
};

/// Steps that are switched on.
pub(super) type Switches = BTreeSet<Cause>;

/// A sensor, short of its readout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Setup {
    /// The float model.
    Float {
        /// One event a frame.
        frames: bool,
        /// Whether the memory snaps.
        memory: bool,
        /// Whether the kernel is the quantised one.
        kernel: bool,
    },
    /// The program, cells that hold numbers.
    Numbers {
        /// Their format.
        format: Format,
        /// Whether they saturate.
        clip: bool,
    },
    /// The program, analogue cells.
    Silicon {
        /// How they err, and where they saturate.
        errors: Errors,
    },
}

impl Setup {
    /// `None` where there is no such sensor: a memory that snaps speaks once a frame, the chip
    /// has one memory and runs the levels alone, and analogue cells are computed in f32.
    pub(super) fn new(question: &Question<'_>, on: &Switches) -> Option<Self> {
        let is = |cause| on.contains(&cause);
        let (frames, memory, kernel) = (is(Cause::Frames), is(Cause::Memory), is(Cause::Kernel));
        let on_chip = on.iter().any(|c| !c.is_float() && *c != Cause::Readout);
        if !on_chip {
            let float = Self::Float {
                frames,
                memory,
                kernel,
            };
            return (frames || !memory).then_some(float);
        }
        if !(frames && memory && kernel) {
            return None;
        }
        match question.arithmetic {
            Arithmetic::Number(format) => Some(Self::Numbers {
                format: if is(Cause::Format) {
                    format
                } else {
                    Format::F64
                },
                clip: is(Cause::Saturation),
            }),
            Arithmetic::Silicon { .. } if !is(Cause::Format) => None,
            Arithmetic::Silicon { .. } if on.last() == Some(&Cause::Format) => {
                Some(Self::Numbers {
                    format: Format::F32,
                    clip: false,
                })
            }
            Arithmetic::Silicon { .. } => Some(Self::Silicon {
                errors: errors(question, on),
            }),
        }
    }

    /// Makes it, with all kinds of the program.
    pub(super) fn sensor(
        self,
        question: &Question<'_>,
        kinds: &Kinds<'_>,
        size: Size,
    ) -> Result<Box<dyn Sensor + Send>, WaterfallError> {
        let program = &kinds.compiled;
        Ok(match self {
            Self::Float {
                frames,
                memory,
                kernel,
            } => {
                let rule = if memory {
                    MemoryRule::FilteredSnap
                } else {
                    MemoryRule::FilteredStep
                };
                let sensor = kinds.float(kernel, rule, size)?;
                if frames {
                    Box::new(OncePerFrame::new(sensor))
                } else {
                    sensor
                }
            }
            Self::Numbers { format, clip } => {
                let settings = Settings {
                    clip,
                    ..program.settings()
                };
                let chip = program.chip(Arithmetic::Number(format), size, settings)?;
                Box::new(program.all_events(chip))
            }
            Self::Silicon { errors } => {
                let seed = match question.arithmetic {
                    Arithmetic::Silicon { seed } => seed,
                    Arithmetic::Number(_) => 0,
                };
                let chip = program.silicon(errors, seed, size, program.settings())?;
                Box::new(program.all_events(chip))
            }
        })
    }
}

/// The chip's errors, those that are switched off as if it had none.
fn errors(question: &Question<'_>, on: &Switches) -> Errors {
    let mut errors = Errors::from_device(question.design.device);
    for term in ErrorTerm::ALL {
        if !on.contains(&Cause::of(*term)) {
            term.leave_out(&mut errors);
        }
    }
    errors
}

/// A sensor whose cells say one event a frame at most, at the frame's time.
struct OncePerFrame<S> {
    sensor: S,
    /// What was said since the frame before.
    fired: Packet,
}

impl<S: Sensor> OncePerFrame<S> {
    fn new(sensor: S) -> Self {
        Self {
            fired: Packet::new(sensor.size(), sensor.channels()),
            sensor,
        }
    }
}

impl<S: Sensor> Sensor for OncePerFrame<S> {
    fn name(&self) -> &str {
        self.sensor.name()
    }

    fn size(&self) -> Size {
        self.sensor.size()
    }

    fn channels(&self) -> u8 {
        self.sensor.channels()
    }

    fn names(&self) -> Vec<String> {
        self.sensor.names()
    }

    fn silence(&self) -> Silence {
        self.sensor.silence()
    }

    fn overflowed(&self) -> Overflowed {
        self.sensor.overflowed()
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        let fired = &mut self.fired;
        fired.events.clear();
        self.sensor.watch(frame, fired)?;
        packet.span = fired.span;
        // Between two frames the events of a cell have one sign.
        let cell = |e: &Event| (e.y, e.channel, e.x);
        fired.events.sort_unstable_by_key(cell);
        fired.events.dedup_by_key(|e| cell(e));
        let t = Micros::from_seconds(frame.seconds);
        let stamped = fired.events.iter().map(|e| Event { t, ..*e });
        packet.events.extend(stamped);
        packet.dropped = fired.dropped;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Polarity, plane::Plane};

    /// Emits the given events, frame by frame.
    struct Script(Vec<Vec<Event>>);

    impl Sensor for Script {
        fn name(&self) -> &'static str {
            "script"
        }
        fn size(&self) -> Size {
            Size::new(2, 2)
        }
        fn channels(&self) -> u8 {
            2
        }
        fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
            packet.span.1 = Micros::from_seconds(frame.seconds);
            packet.events.append(&mut self.0[frame.index as usize]);
            Ok(())
        }
    }

    #[test]
    fn what_a_cell_says_between_two_frames_is_one_event() {
        let event = |t, x, channel, polarity| Event {
            t: Micros(t),
            x,
            y: 1,
            polarity,
            channel,
        };
        let (on, off) = (Polarity::On, Polarity::Off);
        let script = vec![
            Vec::new(),
            vec![
                event(300, 1, 0, on),
                event(400, 0, 0, off),
                event(600, 1, 0, on),
                event(700, 1, 1, on),
                event(900, 1, 0, on),
            ],
            vec![event(1000, 1, 0, off)],
        ];
        let mut sensor = OncePerFrame::new(Script(script));
        let mut packet = Packet::new(sensor.size(), sensor.channels());
        for index in 0..3_u32 {
            let frame = Frame {
                index: index.into(),
                seconds: f64::from(index) * 1e-3,
                light: Plane::zeros((2, 2)).into(),
            };
            sensor.watch(&frame, &mut packet).unwrap();
        }
        let expected = [
            event(1000, 0, 0, off),
            event(1000, 1, 0, on),
            event(1000, 1, 1, on),
            event(2000, 1, 0, off),
        ];
        assert_eq!(packet.events, expected);
        assert_eq!(packet.span.1, Micros(2000));
    }
}
