//! Any number of kinds with one memory: the pixel as it was at the last event of any kind
//! (`raw-snap`, shared; Eq. 2-4 of So & Wetzstein, arXiv 2504.13457).
//!
//! ```text
//! D := light - M                        in the words of the capture itself
//! kind by kind:  r := filter of D       ON where r > θ_on, OFF where -r > θ_off
//! where any kind fired:  M := M + D     which is the light again
//! ```
//!
//! Two registers hold M and D for the whole frame, whatever the number of kinds; the filters have
//! the others, one after the other. The first words of a filter read D in its place, so that no
//! word copies it. The bits of four kinds wait for the readout, which comes after all analogue
//! work; of more kinds, four at a time.

use std::fmt::Write as _;

use super::{
    allocate::ordinary_registers,
    error::CompileError,
    filter::Filter,
    need::Need,
    request::{Effort, Objective, Request},
    sensor::{CellKind, DriveMemory, SLOTS, SensorProgram, constants, largest_light, number},
};
use crate::isa::{Analog, Device, Figure, Primitive, Source, Target};

/// The one-bit registers of each kind that waits for its readout, ON and OFF.
const EVENTS: [[&str; 2]; 4] = [["R5", "R6"], ["R7", "R8"], ["R9", "R10"], ["R1", "R2"]];

/// Words of a frame besides the filters: of each kind, and of all.
const AROUND: (u64, u64) = (14, 16);

/// The program of these kinds.
pub(super) fn program(
    kinds: &[CellKind],
    title: &str,
    request: &Request<'_>,
) -> Result<SensorProgram, CompileError> {
    let device = request.device;
    let all = ordinary_registers(device);
    let needed = Need::new(DriveMemory::Shared, kinds.len()).analogue;
    if all.len() < needed {
        return Err(CompileError::Kinds {
            count: kinds.len(),
            memory: "one memory of the pixel, a difference, and three for filter and threshold",
            needed,
            free: all.len(),
            advice: String::new(),
        });
    }
    let (work, held) = all.split_at(all.len() - 2);
    let registers = Registers {
        result: work[0],
        scratch: work[1],
        threshold: work[2],
        difference: held[0],
        memory: held[1],
    };
    let own = filters(kinds, &registers, request)?;
    let scale = |own: &Own| device.value(Figure::LightScale) * own.filter.scale();
    let scales: Vec<f64> = own.iter().map(scale).collect();
    let writer = Writer {
        device,
        kinds,
        own: &own,
        scales: &scales,
        registers,
    };
    let text = writer.text(title);
    let filters: Vec<Filter> = own.iter().map(|own| own.filter.clone()).collect();
    Ok(SensorProgram {
        text,
        filter: Filter::joined(&filters),
        drives: own.iter().map(|own| own.result).collect(),
        scale: scales.first().copied().unwrap_or(1.0),
        scales,
        steps: Vec::new(),
        difference: Some(registers.difference),
        filters,
    })
}

/// The registers of a frame.
#[derive(Clone, Copy)]
struct Registers {
    /// Of each filter.
    result: Analog,
    scratch: Analog,
    threshold: Analog,
    difference: Analog,
    memory: Analog,
}

/// One kind's filter, from the difference on.
struct Own {
    filter: Filter,
    /// Where its result is; the difference itself where that is the result.
    result: Analog,
}

/// The filter of each kind. Where together they are too long for the chip's store, the longest are
/// searched again for fewer words.
fn filters(
    kinds: &[CellKind],
    registers: &Registers,
    request: &Request<'_>,
) -> Result<Vec<Own>, CompileError> {
    let device = request.device;
    let most = largest_light(device);
    let effort = Effort {
        states: request.effort.states / kinds.len().max(1) as u64,
    };
    let of = |kind: &CellKind, objective| {
        let request = Request {
            kernels: std::slice::from_ref(&kind.kernel),
            input: registers.result,
            into: vec![registers.result],
            keep: vec![registers.difference, registers.memory],
            border: true,
            range: Some((-most, most)),
            effort,
            objective,
            ..request.clone()
        };
        Ok(request.filter()?.from_difference(registers))
    };
    let mut own = Vec::with_capacity(kinds.len());
    for (i, kind) in kinds.iter().enumerate() {
        // The same kernel has the same filter.
        let known = kinds[..i].iter().position(|k| k.kernel == kind.kernel);
        own.push(match known.and_then(|i| own.get(i)) {
            Some(Own { filter, result }) => Own {
                filter: filter.clone(),
                result: *result,
            },
            None => of(kind, request.objective)?,
        });
    }
    let room = device.value(Figure::Store) as u64;
    let words = |own: &[Own]| {
        let filters: usize = own.iter().map(|own| own.filter.words.len()).sum();
        filters as u64 + AROUND.0 * own.len() as u64 + AROUND.1
    };
    let mut longest: Vec<usize> = (0..own.len()).collect();
    longest.sort_by_key(|i| std::cmp::Reverse(own[*i].filter.words.len()));
    for i in longest {
        if words(&own) <= room || request.objective == Objective::Words {
            break;
        }
        let shorter = of(&kinds[i], Objective::Words)?;
        if shorter.filter.words.len() < own[i].filter.words.len() {
            own[i] = shorter;
        }
    }
    let words = words(&own);
    if words > room {
        return Err(CompileError::Store {
            words,
            room,
            chip: device.name().to_owned(),
            advice: String::new(),
        });
    }
    Ok(own)
}

impl Filter {
    /// The same filter of the difference: its words read that register until they first store into
    /// the one where the input was.
    fn from_difference(mut self, registers: &Registers) -> Own {
        let (input, difference) = (registers.result, registers.difference);
        let mut stored = false;
        for (word, live) in self.words.iter_mut().zip(&mut self.live) {
            let Primitive::Bus { targets, sources } = word else {
                continue;
            };
            if !stored {
                for source in sources.iter_mut() {
                    if *source == Source::Register(input) {
                        *source = Source::Register(difference);
                    }
                }
            }
            stored |= targets.contains(&Target::Register(input));
            if !stored {
                live.retain(|register| *register != input);
            }
            live.extend([difference, registers.memory]);
        }
        Own {
            result: if stored { input } else { difference },
            filter: self,
        }
    }

    /// Several filters one after the other, as one: their words, the least of what they promise and
    /// the most of what they take.
    fn joined(all: &[Self]) -> Self {
        let together = |join: fn(&Self) -> usize| all.iter().map(join).max().unwrap_or(0);
        Self {
            words: all.iter().flat_map(|f| f.words.clone()).collect(),
            live: all.iter().flat_map(|f| f.live.clone()).collect(),
            prescale: together(|f| f.prescale as usize) as u32,
            border: all.iter().all(|f| f.border),
            peak: all.iter().map(|f| f.peak).fold(1.0, f64::max),
            holds: all.iter().all(|f| f.holds),
            offsets: all.iter().flat_map(|f| f.offsets.clone()).collect(),
            states: all.iter().map(|f| f.states).sum(),
        }
    }
}

/// The text of a program, part by part.
struct Writer<'a> {
    device: &'a Device,
    kinds: &'a [CellKind],
    own: &'a [Own],
    scales: &'a [f64],
    registers: Registers,
}

impl Writer<'_> {
    fn text(&self, title: &str) -> String {
        let mut text = self.header(title);
        for (i, (kind, scale)) in self.kinds.iter().zip(self.scales).enumerate() {
            let (on, off) = constants(self.kinds, i);
            let _ = writeln!(text, "const {on} = {:?};", kind.on * scale);
            if off != on {
                let _ = writeln!(text, "const {off} = {:?};", kind.off * scale);
            }
        }
        let _ = write!(
            text,
            "const slots = {SLOTS}; // the most that one readout can deliver\n\n"
        );
        let [result, threshold, difference, memory] = [
            self.registers.result,
            self.registers.threshold,
            self.registers.difference,
            self.registers.memory,
        ]
        .map(|register| self.device.analog_name(register));
        let _ = writeln!(
            text,
            "// {memory}: the light at the last event of any kind; {difference}: the light less that; {result}: what a\n// kernel makes of it; {threshold}: minus the threshold; ON and OFF in pairs of one-bit registers"
        );
        let _ = write!(
            text,
            "\ninit {{\n    get_image({memory});\n}}\n\nframe {{\n    // get_image, and minus the memory on the same bus\n    bus(NEWS, PIX);\n    rpix();\n    rpix();\n    nop();\n    bus({difference}, NEWS, PIX, {memory});\n"
        );
        let count = self.kinds.len();
        // Which of R3 and R4 holds whether any kind before has fired.
        let mut before: Option<&str> = None;
        for start in (0..count).step_by(EVENTS.len()) {
            let batch: Vec<usize> = (start..count.min(start + EVENTS.len())).collect();
            for (i, bits) in batch.iter().zip(EVENTS) {
                self.kind(&mut text, *i, bits);
            }
            let last = start + EVENTS.len() >= count;
            self.collect(&mut text, batch.len(), &mut before, last);
            for (i, [on, off]) in batch.iter().zip(EVENTS) {
                let number = number(self.kinds, *i);
                let _ = writeln!(text, "    scamp5_scan_events({on}, on{number}, slots);");
                let _ = writeln!(text, "    scamp5_scan_events({off}, off{number}, slots);");
            }
        }
        text += "}\n";
        text
    }

    fn header(&self, title: &str) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "//! title = {title:?}");
        let _ = writeln!(text, "//! chip = {:?}", self.device.name());
        text += "//! image = \"pattern:disc?width=64&height=48\"\n//! frames = 8\n";
        let _ = writeln!(text, "//! channels = {}", self.kinds.len());
        let halved: Vec<String> = self
            .own
            .iter()
            .map(|own| own.filter.prescale.to_string())
            .collect();
        let reach = if self.own.iter().all(|own| own.filter.border) {
            "right up to the border"
        } else {
            "right where the kernels lie on the array, not at its border"
        };
        let _ = writeln!(
            text,
            "//!\n//! # Compiled. One memory of the pixel for all kinds, which any of them renews (raw-snap, shared):\n//! # each filters the light less it, halved {} times on the way so that no sum leaves the range.\n//! # The filters are {reach}.\n",
            halved.join(", "),
        );
        text
    }

    /// Writes one kind's part of a frame: filter, and comparison with both thresholds.
    fn kind(&self, text: &mut String, i: usize, [on_bit, off_bit]: [&str; 2]) {
        let (
            Some(own),
            Registers {
                scratch, threshold, ..
            },
        ) = (self.own.get(i), self.registers)
        else {
            return;
        };
        let name = |register: Analog| self.device.analog_name(register);
        let (result, scratch, threshold) = (name(own.result), name(scratch), name(threshold));
        let (on, off) = constants(self.kinds, i);
        let _ = writeln!(text, "\n    // kind {i}");
        text.push_str(&own.filter.text(self.device, 4));
        let mut line = |what: &str| {
            let _ = writeln!(text, "    {what}");
        };
        line(&format!("scamp5_in({threshold}, -{off});"));
        line("bus(NEWS);");
        line(&format!("bus({scratch}, NEWS, {result});"));
        line(&format!(
            "where({scratch}, {threshold}); // -drive > threshold"
        ));
        line(&format!("MOV({off_bit}, FLAG);"));
        if on != off {
            line("all();");
            line(&format!("scamp5_in({threshold}, -{on});"));
        }
        line(&format!(
            "where({result}, {threshold}); // drive > threshold"
        ));
        line(&format!("MOV({on_bit}, FLAG);"));
        line("all();");
    }

    /// Writes what collects the bits of so many kinds; after the last the memory becomes the light
    /// wherever any kind has fired.
    fn collect(
        &self,
        text: &mut String,
        kinds: usize,
        before: &mut Option<&'static str>,
        last: bool,
    ) {
        let bits: Vec<&str> = EVENTS[..kinds].iter().flatten().copied().collect();
        let mut any: Vec<&str> = before.iter().copied().collect();
        text.push('\n');
        if bits.len() == 2 {
            any.extend(&bits);
        } else {
            for (into, bits) in ["R11", "R0"].into_iter().zip(bits.chunks(4)) {
                let _ = writeln!(text, "    OR({into}, {});", bits.join(", "));
                any.push(into);
            }
        }
        if last {
            let (difference, memory) = (self.registers.difference, self.registers.memory);
            let [difference, memory] =
                [difference, memory].map(|register| self.device.analog_name(register));
            let _ = writeln!(
                text,
                "    WHERE({}); // where any kind fired, the memory becomes the light",
                any.join(", ")
            );
            let _ = writeln!(
                text,
                "    add({memory}, {memory}, {difference});\n    all();\n"
            );
        } else {
            let next = if *before == Some("R3") { "R4" } else { "R3" };
            let _ = writeln!(text, "    OR({next}, {});\n", any.join(", "));
            *before = Some(next);
        }
    }
}
