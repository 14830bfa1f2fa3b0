//! A whole sensor as a program: capture, filter, threshold comparison, events, memory, readout.

use std::fmt::Write as _;

use super::{
    bit_memory::{self, BitMemory, InBits},
    cell_kind::{CellKind, DriveMemory, constants, header, number, thresholds},
    comparison::Comparison,
    event_readout::EventReadout,
    one_bit_registers::OneBit,
    register_need::{Need, advice},
    shared_memory,
};
use crate::{
    compile::{
        codegen::{
            filter::Filter, instruction_set::check_words, register_allocation::ordinary_registers,
        },
        decision::trial::{Compared, Decision},
        error::{CompileError, most_threshold},
        request::{Border, Request},
        silicon::{dark_offset::places, noise::FilterNoise},
    },
    isa::{Analog, Device, Figure},
    kernel::Kernel,
    unit::counted,
};

/// A sensor as a program for the chip.
#[derive(Clone, Debug)]
pub struct SensorProgram {
    /// Source text of the program, its settings at the head.
    pub text: String,
    /// The filter in it, from the capture to the drives; with a shared memory all filters, one
    /// after the other.
    pub filter: Filter,
    /// The register of each kind's drive, after its filter.
    pub drives: Vec<Analog>,
    /// Scale of each drive: LSB for each unit of kernel times light. One filter gives all the same.
    pub scales: Vec<f64>,
    /// With a shared memory, the words before each filter, which leave the light less the memory
    /// in the register of the drives.
    pub difference: String,
    /// With a shared memory, the filter of each kind.
    pub filters: Vec<Filter>,
    /// The memory of each kind, where it is in bits.
    pub steps: Vec<BitMemory>,
    pub(super) registers: Registers,
}

impl SensorProgram {
    /// Scale of the first drive.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scales.first().copied().unwrap_or(1.0)
    }

    /// Its filters: one for each kind where they share a memory, else one for all.
    #[must_use]
    pub fn each_filter(&self) -> &[Filter] {
        if self.filters.is_empty() {
            std::slice::from_ref(&self.filter)
        } else {
            &self.filters
        }
    }

    /// Whether cells fire again and again on the chip while the picture stays
    /// ([`Restless`](crate::compile::Restless)).
    #[must_use]
    pub fn is_restless(&self) -> bool {
        self.steps.iter().any(|own| own.restless.is_some())
    }
}

/// The registers of a program beside those of its drives.
#[derive(Clone, Debug)]
pub(super) enum Registers {
    /// With a memory for each kind.
    Own {
        memories: Vec<Analog>,
        threshold: Analog,
        scratch: Analog,
        bits: OneBit,
    },
    /// With one for all.
    Shared(shared_memory::Registers),
}

impl SensorProgram {
    /// How many pixels in from the border of the array events may differ from those of a sensor
    /// that sees zeros beyond it, in exact arithmetic too; 0 where the program is right there. Of kinds
    /// that share a memory, how many further with each frame.
    #[must_use]
    pub fn wrong_from_border(&self, device: &Device) -> usize {
        let own = self.filters.iter().chain([&self.filter]);
        let own = own.map(|filter| filter.wrong_from_border(device));
        own.max().unwrap_or(0)
    }

    /// Searches for the filters and writes the program around them: one decision a frame, memory
    /// `filtered-snap`, or shared `raw-snap`. `request` gives the chip, the objective, the effort
    /// and the seed; kernels and registers are chosen here.
    ///
    /// # Errors
    /// When a weight is not dyadic, there are too few registers, or too many words.
    pub fn new(
        kinds: &[CellKind],
        memory: DriveMemory,
        title: &str,
        request: &Request<'_>,
    ) -> Result<Self, CompileError> {
        let built = Self::build(kinds, memory, title, request);
        built.map_err(|error| advice(error, kinds, memory, request))
    }

    /// As [`SensorProgram::new`], with errors that advise nothing.
    pub(super) fn build(
        kinds: &[CellKind],
        memory: DriveMemory,
        title: &str,
        request: &Request<'_>,
    ) -> Result<Self, CompileError> {
        if memory == DriveMemory::Shared {
            let program = shared_memory::program(kinds, title, request)?;
            check_thresholds(request.device, kinds, &program.scales)?;
            check_words(&program.text, request.device)?;
            return Ok(program);
        }
        let device = request.device;
        let all = ordinary_registers(device);
        let count = kinds.len();
        let own_bits = OneBit::of(device);
        let bits = &own_bits.memory;
        let remembered = memory_registers(memory, count, (all.len(), bits.len()), device)?;
        // From the first register on: drives, a scratch; the threshold and the memories are last.
        let memories = all[all.len() - remembered..].to_vec();
        let kernels: Vec<Kernel> = kinds.iter().map(|kind| kind.kernel.clone()).collect();
        let request = Request {
            kernels: &kernels,
            input: all[0],
            into: all[..count].to_vec(),
            keep: match memory {
                DriveMemory::Bits(_) => Vec::new(),
                DriveMemory::Analogue | DriveMemory::Shared => memories.clone(),
            },
            border: request.border.max(Border::Worth),
            range: Some((0.0, largest_light(device))),
            decision: match (kinds, memory) {
                ([kind], DriveMemory::Analogue) => {
                    Some(Decision::new(kind, device, Compared::Drives))
                }
                _ => None,
            },
            ..request.clone()
        };
        let filter = request.filter_of_program()?;
        // The filter is in `init` (for the first memory) and in `frame`.
        if let Some(error) = CompileError::of_store(2 * filter.word_count(device), device) {
            return Err(error);
        }
        let scale = device.value(Figure::LightScale) * filter.scale();
        let steps = match memory {
            DriveMemory::Analogue | DriveMemory::Shared => Vec::new(),
            DriveMemory::Bits(own) => {
                let noises = filter.noise(device, FilterNoise::MIDDLE);
                let dark = places(&filter.words, &filter.results, device, filter.from_border);
                let in_bits = |((kind, noise), dark): ((_, &FilterNoise), _)| {
                    InBits::new(kind, device, (scale, noise.temporal), dark)
                };
                let kinds: Vec<InBits<'_>> = { kinds.iter().zip(&noises).zip(dark) }
                    .map(in_bits)
                    .collect();
                bit_memory::memories(&kinds, own, bits)?
            }
        };
        let scales = vec![scale; count];
        check_thresholds(device, kinds, &scales)?;
        let mut program = Self {
            text: String::new(),
            drives: all[..count].to_vec(),
            filter,
            scales,
            steps,
            difference: String::new(),
            filters: Vec::new(),
            registers: Registers::Own {
                memories,
                threshold: all[all.len() - remembered - 1],
                scratch: all[count],
                bits: own_bits,
            },
        };
        program.text = program.text_with(kinds, title, device, EventReadout::most_slots(device));
        check_words(&program.text, device)?;
        Ok(program)
    }

    /// The text of the program with another readout; `kinds`, `title` and `device` are those that
    /// it was made of.
    #[must_use]
    pub fn text_with(
        &self,
        kinds: &[CellKind],
        title: &str,
        device: &Device,
        readout: EventReadout,
    ) -> String {
        match &self.registers {
            Registers::Own {
                memories,
                threshold,
                scratch,
                bits,
            } => Writer {
                steps: &self.steps,
                device,
                kinds,
                filter: &self.filter,
                scales: &self.scales,
                drives: &self.drives,
                memories,
                threshold: *threshold,
                scratch: *scratch,
                readout,
                bits,
            }
            .text(title),
            Registers::Shared(registers) => shared_memory::Writer {
                device,
                kinds,
                filters: &self.filters,
                scales: &self.scales,
                registers,
                readout,
            }
            .text(title),
        }
    }
}

/// The largest light of a capture, LSB: up to what a register holds. On SCAMP-5 a pixel at the very
/// end of the scale, 255, is half an LSB beyond it.
pub(super) fn largest_light(device: &Device) -> f64 {
    let light = device.value(Figure::LightScale) * 255.0;
    light.max(1.0).min(device.register_range().1)
}

/// The brightest light, of 255, whose capture a register holds: on SCAMP-5 254.
#[must_use]
pub fn brightest(device: &Device) -> f64 {
    let (_, high) = device.register_range();
    (high / device.value(Figure::LightScale))
        .floor()
        .clamp(1.0, 255.0)
}

/// Up to which light a program holds, where that is less than all but the brightest.
pub(super) fn up_to(device: &Device) -> String {
    let brightest = brightest(device);
    if brightest < 254.0 {
        format!(" for\n//! # light up to {brightest} of 255")
    } else {
        String::new()
    }
}

/// Checks that the host can set the threshold of every kind.
fn check_thresholds(
    device: &Device,
    kinds: &[CellKind],
    scales: &[f64],
) -> Result<(), CompileError> {
    let most = most_threshold(device);
    for (kind, scale) in kinds.iter().zip(scales) {
        let threshold = kind.on.max(kind.off);
        if threshold * scale > most {
            let lsb = threshold * scale;
            let reach = kind.kernel.magnitude() * brightest(device) * scale;
            return Err(CompileError::Threshold { lsb, most, reach });
        }
    }
    Ok(())
}

/// How many of `free` analogue registers hold memories of `count` kinds; `free_bits`: the one-bit
/// registers for memories.
///
/// # Errors
/// When there are too few registers, analogue or of one bit.
fn memory_registers(
    memory: DriveMemory,
    count: usize,
    (free, free_bits): (usize, usize),
    device: &Device,
) -> Result<usize, CompileError> {
    // One register for each memory, or one in which bit memories are assembled in turn.
    let (remembered, each) = match memory {
        DriveMemory::Analogue | DriveMemory::Shared => (
            count,
            "a drive and a memory for each, a threshold and a scratch",
        ),
        DriveMemory::Bits(_) => (1, "a drive for each, a memory, a threshold and a scratch"),
    };
    let Need { analogue, bits } = Need::new(memory, count, device);
    if free < analogue {
        return Err(CompileError::Kinds {
            count,
            memory: each,
            needed: analogue,
            free,
            advice: String::new(),
        });
    }
    if let DriveMemory::Bits(own) = memory
        && !(1..=free_bits).contains(&bits)
    {
        return Err(CompileError::Bits {
            count,
            bits: own,
            free: free_bits,
            advice: String::new(),
        });
    }
    Ok(remembered)
}

/// The text of a program, part by part.
struct Writer<'a> {
    steps: &'a [BitMemory],
    device: &'a Device,
    kinds: &'a [CellKind],
    filter: &'a Filter,
    scales: &'a [f64],
    drives: &'a [Analog],
    memories: &'a [Analog],
    threshold: Analog,
    scratch: Analog,
    readout: EventReadout,
    bits: &'a OneBit,
}

impl Writer<'_> {
    fn text(&self, title: &str) -> String {
        let mut text = self.header(title);
        let name = |register: &Analog| self.device.analog_name(*register);
        text += &thresholds(self.kinds, self.scales);
        if !self.steps.is_empty() {
            text += "const zero = 0; // what the drive is in the dark, LSB: on a chip, its transfer errors\n";
        }
        text += &self.readout.head(self.device);
        text.push('\n');
        let list = |registers: &[Analog]| registers.iter().map(name).collect::<Vec<_>>().join(", ");
        let _ = writeln!(
            text,
            "// {}: the drive; {}: minus the memory; {}: minus the threshold; {} ON, {} OFF",
            list(self.drives),
            list(self.memories),
            name(&self.threshold),
            self.bits.events[0],
            self.bits.events[1],
        );
        text += "\ninit {\n";
        self.filter_text(&mut text);
        if self.steps.is_empty() {
            for (drive, memory) in self.drives.iter().zip(self.memories) {
                let _ = writeln!(text, "    neg({}, {});", name(memory), name(drive));
            }
        } else {
            let _ = writeln!(
                text,
                "    SET({}); // all are remembered",
                self.bits.events[0]
            );
        }
        for i in 0..self.steps.len() {
            self.remember_bits(&mut text, i);
        }
        text += "}\n\nframe {\n";
        self.filter_text(&mut text);
        for i in 0..self.kinds.len() {
            self.events(&mut text, i);
        }
        text += "}\n";
        text
    }

    fn header(&self, title: &str) -> String {
        let mut text = header(title, self.device, self.kinds);
        let reach = if self.filter.border {
            "right up to the border"
        } else {
            "right where the kernel lies on the array, not at its border"
        };
        let holds = format!("no sum leaves the range{}", up_to(self.device));
        let range = match (self.filter.decided, self.filter.holds) {
            (Some(_), false) => {
                "for the\n//! # most events on the chip; large sums may leave the range".to_owned()
            }
            (Some(_), true) => format!("for the\n//! # most events on the chip; {holds}"),
            (None, _) => format!("so that {holds}"),
        };
        let _ = writeln!(
            text,
            "//!\n//! # Compiled. The light is halved {} on the way, {range}; the\n//! # filter is {reach}. The memory is the drive at the last event (filtered-snap).",
            counted(self.filter.prescale, "time"),
        );
        // A count writes to a register what depends on the place, so that no frame is read back.
        if let ([kind], [scale]) = (self.kinds, self.scales)
            && self.readout != EventReadout::Counts
        {
            text += "//! [computes]\n//! kernel = [\n";
            for row in kind.kernel.weights().rows() {
                let _ = writeln!(text, "//!     {:?},", row.to_vec());
            }
            let _ = writeln!(text, "//! ]\n//! scale = {scale:?}");
            if kind.on == kind.off {
                text += "//! threshold = \"threshold\"\n";
            }
            if let [own] = self.steps {
                let _ = writeln!(text, "//! step = {:?}", own.step);
            }
        }
        text.push('\n');
        text
    }

    fn filter_text(&self, text: &mut String) {
        let drive = self.device.analog_name(self.drives[0]);
        let _ = writeln!(text, "    get_image({drive});\n");
        text.push_str(&self.filter.text(self.device, 4));
        text.push('\n');
    }

    /// Writes one kind's part of the frame: compare, set event bits, update the memory, read out.
    fn events(&self, text: &mut String, i: usize) {
        let name = |register: Analog| self.device.analog_name(register);
        let in_bits = !self.steps.is_empty();
        let drive = name(self.drives[i]);
        let memory = name(self.memories[if in_bits { 0 } else { i }]);
        if in_bits {
            self.recall_bits(text, i);
        }
        let (threshold, scratch) = (name(self.threshold), name(self.scratch));
        let news = name(self.device.news());
        let [on_bit, off_bit] = self.bits.events.each_ref().map(String::as_str);
        let (on, off) = constants(self.kinds, i);
        let number = number(self.kinds, i);
        Comparison {
            news: &news,
            scratch: &scratch,
            drive: &drive,
            threshold: &threshold,
            memory: Some(&memory),
            bits: [on_bit, off_bit],
        }
        .write(text, [&on, &off]);
        if !in_bits {
            let _ = writeln!(
                text,
                "    WHERE({on_bit}, {off_bit}); // where it fired, the memory becomes the drive"
            );
            let _ = writeln!(text, "    neg({memory}, {drive});");
        }
        text.push_str("    all();\n");
        self.readout
            .write(text, [on_bit, off_bit], &number, (&drive, &scratch));
        if in_bits {
            let _ = writeln!(
                text,
                "    OR({on_bit}, {off_bit}); // where it fired, the memory becomes the drive"
            );
            self.remember_bits(text, i);
        }
    }

    /// Writes statements that recall minus the middle of the remembered step.
    fn recall_bits(&self, text: &mut String, i: usize) {
        let BitMemory {
            low,
            step,
            registers,
            ..
        } = &self.steps[i];
        let name = |register: Analog| self.device.analog_name(register);
        let (memory, level) = (name(self.memories[0]), name(self.threshold));
        let middle = -(low + step / 2.0);
        let _ = writeln!(
            text,
            "    scamp5_in({memory}, {middle:?} - zero); // minus the memory"
        );
        for (bit, register) in registers.iter().enumerate() {
            let size = -step * 2f64.powi(bit as i32);
            let _ = writeln!(text, "    scamp5_in({level}, {size:?});");
            let _ = writeln!(text, "    WHERE({register});");
            let _ = writeln!(text, "    add({memory}, {memory}, {level});");
            let _ = writeln!(text, "    all();");
        }
    }

    /// Writes statements that encode the drive's step into the bits, where that of ON
    /// is set: the highest bit first (successive approximation).
    fn remember_bits(&self, text: &mut String, i: usize) {
        let BitMemory {
            low,
            step,
            registers,
            ..
        } = &self.steps[i];
        let name = |register: Analog| self.device.analog_name(register);
        let (drive, below, level) = (
            name(self.drives[i]),
            name(self.memories[0]),
            name(self.threshold),
        );
        let OneBit { events, spare, .. } = self.bits;
        let chosen = &events[0];
        let _ = writeln!(text, "    scamp5_in({below}, {:?} - zero);", -low);
        for (bit, register) in registers.iter().enumerate().rev() {
            let size = -step * 2f64.powi(bit as i32);
            let _ = writeln!(text, "    scamp5_in({level}, {size:?});");
            let _ = writeln!(
                text,
                "    where({drive}, {below}, {level}); // above the middle"
            );
            let _ = writeln!(text, "    MOV({spare}, FLAG);");
            let _ = writeln!(text, "    add({below}, {below}, {level});");
            let _ = writeln!(text, "    all();");
            let _ = writeln!(text, "    MUX({register}, {chosen}, {spare}, {register});");
        }
    }
}
