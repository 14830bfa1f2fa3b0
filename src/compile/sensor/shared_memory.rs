//! Any number of kinds with one memory: the pixel as it was at the last event of any kind
//! (`raw-snap`, shared; Eq. 2-4 of So & Wetzstein, arXiv 2504.13457).
//!
//! ```text
//! kind by kind:  D := light - M         two words, which read the photodiode and do not reset it
//!                r := filter of D       ON where r > θ_on, OFF where -r > θ_off
//! where any kind fired:  M := light
//! then the photodiode is reset, and all events are read out
//! ```
//!
//! M takes one register for the whole frame, whatever the number of kinds; the filters have the
//! others, one after the other. The photodiode integrates on while they run, which is a hundredth
//! of a frame or less, beside the readout. The bits of five kinds wait for the readout, which comes
//! after all analogue work (of fewer, where the chip has fewer one-bit registers). More kinds are
//! read out five at a time, so that the light of the frame is held in a register as well.

use std::fmt::Write as _;

use super::{
    cell_kind::{CellKind, DriveMemory, constants, header, number, thresholds},
    comparison::Comparison,
    event_readout::EventReadout,
    one_bit_registers::OneBit,
    program::{self, SensorProgram, largest_light},
    register_need::Need,
};
use crate::{
    compile::{
        codegen::{filter::Filter, register_allocation::ordinary_registers},
        decision::trial::{Compared, Decision},
        error::CompileError,
        request::{Border, Objective, Request},
    },
    isa::{Analog, Device, Figure},
    order::Order,
};

/// Kinds whose bits wait for one readout, at most.
const AT_A_TIME: usize = 5;

/// Kinds whose bits wait for one readout on a chip.
pub(super) fn at_a_time(device: &Device) -> usize {
    OneBit::of(device).pairs(AT_A_TIME).len()
}

/// Words besides the filters: of each kind, of a second threshold, and of all.
const AROUND: (u64, u64, u64) = (11, 3, 16);

/// The program of these kinds.
pub(super) fn program(
    kinds: &[CellKind],
    title: &str,
    request: &Request<'_>,
) -> Result<SensorProgram, CompileError> {
    let device = request.device;
    let all = ordinary_registers(device);
    let bits = OneBit::of(device);
    let needed = Need::new(DriveMemory::Shared, kinds.len(), device).analogue;
    let enough = all.split_last().filter(|_| needed <= all.len());
    let Some((&memory, work)) = enough else {
        return Err(CompileError::Kinds {
            count: kinds.len(),
            memory: "one memory of the pixel, and three registers for filter and threshold",
            needed,
            free: all.len(),
            advice: String::new(),
        });
    };
    let light = (kinds.len() > bits.pairs(AT_A_TIME).len()).then(|| work[work.len() - 1]);
    let registers = Registers {
        drive: work[0],
        scratch: work[1],
        threshold: work[2],
        light,
        memory,
        bits,
    };
    let filters = filters(kinds, &registers, request)?;
    let scales: Vec<f64> = { filters.iter() }
        .map(|filter| device.value(Figure::LightScale) * filter.scale())
        .collect();
    let writer = Writer {
        device,
        kinds,
        filters: &filters,
        scales: &scales,
        registers: &registers,
        readout: EventReadout::most_slots(device),
    };
    let (text, difference) = (writer.text(title), writer.difference());
    Ok(SensorProgram {
        text,
        filter: Filter::joined(registers.drive, &filters),
        drives: vec![registers.drive; kinds.len()],
        registers: program::Registers::Shared(registers),
        scales,
        steps: Vec::new(),
        difference,
        filters,
    })
}

/// The registers of a frame.
#[derive(Clone, Debug)]
pub(super) struct Registers {
    /// The light less the memory, and what a filter makes of it.
    drive: Analog,
    scratch: Analog,
    threshold: Analog,
    /// The light of the frame, where the photodiode is not to be read for so long.
    light: Option<Analog>,
    memory: Analog,
    /// Those of one bit.
    bits: OneBit,
}

/// The filter of each kind. Where together they are too long for the chip's store, the longest are
/// searched again for fewer words.
fn filters(
    kinds: &[CellKind],
    registers: &Registers,
    request: &Request<'_>,
) -> Result<Vec<Filter>, CompileError> {
    let device = request.device;
    let most = largest_light(device);
    let states = request.effort.states / kinds.len().max(1) as u64;
    let effort = request.effort.with_states(states);
    let of = |kind: &CellKind, objective| {
        Request {
            kernels: std::slice::from_ref(&kind.kernel),
            input: registers.drive,
            into: vec![registers.drive],
            keep: registers
                .light
                .into_iter()
                .chain([registers.memory])
                .collect(),
            border: request.border.max(Border::Worth),
            range: Some((-most, most)),
            // What is compared is a difference: no constant of the chip drops out of it.
            zero_counts: true,
            decision: Some(Decision::new(kind, device, Compared::Difference)),
            effort,
            objective,
            ..request.clone()
        }
        .filter_of_program()
    };
    let mut own: Vec<Filter> = Vec::with_capacity(kinds.len());
    for (i, kind) in kinds.iter().enumerate() {
        let known = kinds[..i].iter().position(|k| k == kind);
        own.push(match known.and_then(|i| own.get(i)) {
            Some(filter) => filter.clone(),
            None => of(kind, request.objective)?,
        });
    }
    let room = device.value(Figure::Store) as u64;
    let twice = kinds.iter().filter(|kind| kind.on != kind.off).count() as u64;
    let around = AROUND.0 * kinds.len() as u64 + AROUND.1 * twice + AROUND.2;
    let words = |own: &[Filter]| {
        let filters: u64 = own.iter().map(|own| own.word_count(device)).sum();
        filters + around
    };
    let mut longest: Vec<usize> = (0..own.len()).collect();
    longest.order_by_key(|i| std::cmp::Reverse(own[*i].words.len()));
    for i in longest {
        if words(&own) <= room || request.objective == Objective::Words {
            break;
        }
        let shorter = of(&kinds[i], Objective::Words)?;
        let as_right = shorter.border || !own[i].border;
        if as_right && shorter.words.len() < own[i].words.len() {
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
    /// Several filters of one input one after the other, as one: their words, the least of what they
    /// promise and the most of what they take.
    fn joined(input: Analog, all: &[Self]) -> Self {
        let together = |join: fn(&Self) -> usize| all.iter().map(join).max().unwrap_or(0);
        Self {
            words: all.iter().flat_map(|f| f.words.clone()).collect(),
            input,
            results: all.iter().flat_map(|f| f.results.clone()).collect(),
            live: all.iter().flat_map(|f| f.live.clone()).collect(),
            prescale: together(|f| f.prescale as usize) as u32,
            border: all.iter().all(|f| f.border),
            peak: all.iter().map(|f| f.peak).fold(1.0, f64::max),
            holds: all.iter().all(|f| f.holds),
            exact_within: { all.iter() }
                .map(|f| f.exact_within)
                .fold(f64::INFINITY, f64::min),
            decided: None,
            offsets: all.iter().flat_map(|f| f.offsets.clone()).collect(),
            states: all.iter().map(|f| f.states).sum(),
            from_border: together(|f| f.from_border),
        }
    }
}

/// The text of a program, part by part.
pub(super) struct Writer<'a> {
    pub(super) device: &'a Device,
    pub(super) kinds: &'a [CellKind],
    pub(super) filters: &'a [Filter],
    pub(super) scales: &'a [f64],
    pub(super) registers: &'a Registers,
    pub(super) readout: EventReadout,
}

impl Writer<'_> {
    pub(super) fn text(&self, title: &str) -> String {
        let mut text = self.header(title);
        text += &thresholds(self.kinds, self.scales);
        text += &self.readout.head(self.device);
        text.push('\n');
        let name = |register: Analog| self.device.analog_name(register);
        let Registers {
            drive,
            scratch,
            threshold,
            memory,
            light,
            ref bits,
        } = *self.registers;
        let [drive, scratch, threshold, memory] = [drive, scratch, threshold, memory].map(name);
        let _ = writeln!(
            text,
            "// {memory}: the photodiode at the last event of any kind; {drive}: what has changed since, then what a\n// kernel makes of it; {threshold}: minus the threshold; ON and OFF in pairs of one-bit registers"
        );
        let _ = write!(
            text,
            "\ninit {{\n    mov({memory}, PIX);\n    respix();\n}}\n\nframe {{\n"
        );
        if let Some(light) = light.map(name) {
            let _ = writeln!(
                text,
                "    mov({light}, PIX); // the light, through all readouts\n    respix();"
            );
        }
        let count = self.kinds.len();
        let pairs = bits.pairs(AT_A_TIME);
        // The bit that holds whether any kind before has fired.
        let mut before = false;
        for start in (0..count).step_by(pairs.len()) {
            let batch: Vec<usize> = (start..count.min(start + pairs.len())).collect();
            for (i, bits) in batch.iter().zip(&pairs) {
                self.kind(&mut text, *i, *bits);
            }
            self.collect(&mut text, &pairs[..batch.len()], before);
            before = true;
            if start + pairs.len() >= count {
                self.remember(&mut text);
            }
            for (i, bits) in batch.iter().zip(&pairs) {
                let number = number(self.kinds, *i);
                self.readout
                    .write(&mut text, *bits, &number, (&drive, &scratch));
            }
        }
        text += "}\n";
        text
    }

    fn header(&self, title: &str) -> String {
        let mut text = header(title, self.device, self.kinds);
        let halved: Vec<String> = { self.filters.iter() }
            .map(|filter| filter.prescale.to_string())
            .collect();
        let reach = if self.filters.iter().all(|filter| filter.border) {
            "right up to the border"
        } else {
            "right where the kernels lie on the array, not at its border"
        };
        let _ = writeln!(
            text,
            "//!\n//! # Compiled. One memory of the pixel for all kinds, which any of them renews (raw-snap, shared):\n//! # each filters the light less it, halved {} times on the way, {}.\n//! # The filters are {reach}.\n",
            halved.join(", "),
            if { self.filters.iter() }.any(|filter| filter.decided.is_some() && !filter.holds) {
                "for the most events on the chip;\n//! # large sums may leave the range".to_owned()
            } else {
                format!(
                    "so that no sum leaves the range{}",
                    program::up_to(self.device)
                )
            },
        );
        text
    }

    /// What the light of a frame is read from.
    fn light(&self) -> String {
        let held = self.registers.light;
        held.map_or("PIX".to_owned(), |light| self.device.analog_name(light))
    }

    /// The words before each filter: the light less the memory.
    fn difference(&self) -> String {
        let Registers { drive, memory, .. } = *self.registers;
        let [drive, memory] = [drive, memory].map(|register| self.device.analog_name(register));
        let (light, news) = (self.light(), self.device.analog_name(self.device.news()));
        format!("    bus({news}, {light});\n    bus({drive}, {news}, {memory});\n")
    }

    /// Writes one kind's part of a frame: filter, and comparison with both thresholds.
    fn kind(&self, text: &mut String, i: usize, bits: [&str; 2]) {
        let name = |register: Analog| self.device.analog_name(register);
        let Registers {
            drive,
            scratch,
            threshold,
            ..
        } = *self.registers;
        let [drive, scratch, threshold, news] =
            [drive, scratch, threshold, self.device.news()].map(name);
        let (on, off) = constants(self.kinds, i);
        let called = self.kinds[i].name.iter().map(|name| format!(", {name}"));
        // A name of several lines would end the comment.
        let called: String = called.collect::<String>().replace(char::is_control, " ");
        let _ = writeln!(text, "\n    // kind {i}{called}");
        text.push_str(&self.difference());
        text.push_str(&self.filters[i].text(self.device, 4));
        Comparison {
            news: &news,
            scratch: &scratch,
            drive: &drive,
            threshold: &threshold,
            memory: None,
            bits,
        }
        .write(text, [&on, &off]);
        text.push_str("    all();\n");
    }

    /// Writes what collects the bits of kinds in the spare register; with those of the kinds
    /// `before`, which are there already.
    fn collect(&self, text: &mut String, pairs: &[[&str; 2]], before: bool) {
        let OneBit { spare, scratch, .. } = &self.registers.bits;
        let bits: Vec<&str> = pairs.iter().flatten().copied().collect();
        text.push('\n');
        // No word may store where it reads, so that the sums go to and fro.
        let (mut from, mut into) = (&**spare, &**scratch);
        let mut any = before;
        let mut left = &bits[..];
        while !left.is_empty() {
            if !any {
                (from, into) = (scratch, spare);
            }
            let (now, later) = left.split_at(left.len().min(if any { 3 } else { 4 }));
            let held = any.then_some(from);
            let all: Vec<&str> = held.into_iter().chain(now.iter().copied()).collect();
            let _ = writeln!(text, "    OR({into}, {});", all.join(", "));
            (from, into) = (into, from);
            (any, left) = (true, later);
        }
        if from != spare {
            let _ = writeln!(text, "    MOV({spare}, {from});");
        }
    }

    /// Writes what an event of any kind does to the memory, and the reset.
    fn remember(&self, text: &mut String) {
        let memory = self.device.analog_name(self.registers.memory);
        let (light, any) = (self.light(), &self.registers.bits.spare);
        let _ = writeln!(
            text,
            "    WHERE({any}); // where any kind fired, the memory becomes the light\n    mov({memory}, {light});\n    all();"
        );
        if self.registers.light.is_none() {
            text.push_str("    respix();\n");
        }
        text.push('\n');
    }
}
