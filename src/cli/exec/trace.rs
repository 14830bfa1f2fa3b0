//! `exec --trace`: the last frames word by word, on a chip and in exact arithmetic, as a page.

use std::collections::VecDeque;

use super::{bench::Bench, moment::Moment};
use crate::{
    array::{Arithmetic, Array, Register},
    cli::input::opened_program::Opened,
    event::Packet,
    isa::{Device, Figure, operands::Terminal},
    number::Format,
    picture::trace::{Trace, TraceParting, TraceRegister, TraceStep, TraceVersion, page},
    plane::{At, Plane, Size},
    program::{Action, CellEffect, Step},
};

/// Numbers of a page, those of a chip: 220 planes of 64x64. A plane of bits is an eighth.
const MOST: usize = 220 * 64 * 64;

/// Words of a frame.
const WORDS: usize = 3000;

/// By how many LSB a pixel parts, the median of all not counted.
const LIMIT: f64 = 1.0;

/// The most bytes that a trace holds.
pub fn bytes(device: &Device, size: Size) -> u128 {
    let silicon = Arithmetic::Silicon { seed: 0 }.bytes(device, size);
    let planes = 6 * 8 * size.pixels() as u128;
    2 * silicon + Arithmetic::Number(Format::F64).bytes(device, size) + planes + 24 * MOST as u128
}

/// A program on a chip, in exact arithmetic, and on the chip without the noise of its stores; all
/// see the same light.
pub struct Tracer<'a> {
    opened: &'a Opened,
    machine: String,
    chip: Box<dyn Array + Send>,
    twin: Box<dyn Array + Send>,
    quiet: Option<Box<dyn Array + Send>>,
    /// All that the program touches, with the cells that they are.
    registers: Vec<Register>,
    /// The last frames.
    frames: VecDeque<Vec<TraceStep>>,
    /// Frames that were left out.
    dropped: u64,
    /// Words of a frame that were left out, the most of any.
    unseen: usize,
    every: usize,
    parting: Option<TraceParting>,
    /// In which arithmetic the host decided what runs, if it did.
    decided: Option<Arithmetic>,
}

impl<'a> Tracer<'a> {
    pub fn new(bench: &'a Bench<'_>) -> miette::Result<Self> {
        let opened = &bench.opened;
        let device = &opened.device;
        let exact = Arithmetic::Number(Format::F64);
        let silicon = Arithmetic::Silicon {
            seed: bench.arguments.seed(),
        };
        let arithmetic = if bench.arithmetic == exact {
            silicon
        } else {
            bench.arithmetic
        };
        let without = &bench.arguments.without;
        let plainer = match &bench.machine {
            None => without.machine(arithmetic)?,
            plainer => plainer.clone(),
        };
        let quiet = if arithmetic == silicon {
            let device = device.clone().what_if(Figure::StoreNoise, 0.0)?;
            Some(bench.chip_in(silicon, &device, plainer.as_ref())?)
        } else {
            None
        };
        let mut machine = format!("{} in {arithmetic}{}", device.name(), without.told());
        if quiet.is_some() {
            machine = format!("{machine} (chip {})", bench.arguments.seed());
        }
        let codes = bench.codes();
        let registers = touched(&codes, device);
        let most = codes.iter().map(|steps| planes(steps, device)).max();
        let planes = most.unwrap_or(0) + registers.len();
        let shown = |every: usize| {
            bench.size.height.div_ceil(every) * bench.size.width.div_ceil(every) * planes
        };
        let longest = bench.size.height.max(bench.size.width);
        let every = (1..=longest).find(|every| shown(*every) <= MOST);
        Ok(Self {
            opened,
            machine,
            chip: bench.chip_in(arithmetic, device, plainer.as_ref())?,
            twin: bench.chip_in(exact, device, None)?,
            quiet,
            registers,
            frames: VecDeque::new(),
            dropped: 0,
            unseen: 0,
            every: every.unwrap_or(longest),
            parting: None,
            decided: opened.decides.then_some(bench.arithmetic),
        })
    }

    /// Runs a frame, word by word.
    pub fn frame(&mut self, moment: &Moment<'_>) -> miette::Result<()> {
        for chip in self.chips() {
            chip.begin_frame();
            chip.expose(moment.light)?;
            if let Some(seconds) = moment.since {
                chip.wait(seconds);
            }
        }
        let mut recording = Recording {
            packet: Packet::new(self.chip.size(), self.chip.channels()),
            steps: Vec::new(),
            words: 0,
        };
        let all: Vec<usize> = (0..self.registers.len()).collect();
        let begin = TraceStep {
            frame: moment.index,
            line: 0,
            text: format!(
                "begins at {} us; the light is on the photodiodes",
                moment.t.0
            ),
            reads: Vec::new(),
            written: Vec::new(),
        };
        self.take(begin, &all, moment, &mut recording);
        self.steps(moment.steps, moment, &mut recording)?;
        self.unseen = self.unseen.max(recording.words.saturating_sub(WORDS));
        self.frames.push_back(recording.steps);
        // The last frame stays, however large it is.
        let held = |frames: &VecDeque<Vec<TraceStep>>| {
            let steps = frames.iter().flatten();
            let planes = steps.flat_map(|step| &step.written);
            planes.map(|it| it.chip.len()).sum::<usize>()
        };
        while self.frames.len() > 1 && held(&self.frames) > MOST {
            self.frames.pop_front();
            self.dropped += 1;
        }
        Ok(())
    }

    fn chips(&mut self) -> impl Iterator<Item = &mut Box<dyn Array + Send>> {
        let both = [&mut self.chip, &mut self.twin].into_iter();
        both.chain(self.quiet.as_mut())
    }

    fn steps(
        &mut self,
        steps: &[Step],
        moment: &Moment<'_>,
        recording: &mut Recording,
    ) -> miette::Result<()> {
        for step in steps {
            let text = match &step.action {
                Action::Repeat { times, body } => {
                    for _ in 0..*times {
                        self.steps(body, moment, recording)?;
                    }
                    continue;
                }
                Action::Word(word) => word.text(&self.opened.device),
                Action::Host(host) => host.text(&self.opened.device),
            };
            let one = std::slice::from_ref(step);
            for chip in self.chips() {
                recording.packet.events.clear();
                chip.run_steps(one, moment.t, &mut recording.packet)?;
            }
            recording.words += 1;
            if recording.words > WORDS && self.parting.is_some() {
                continue;
            }
            let [reads, written] = uses(one, &self.opened.device);
            let number = |register: &Register| self.registers.iter().position(|it| it == register);
            let written: Vec<usize> = written.iter().filter_map(number).collect();
            let seen = TraceStep {
                frame: moment.index,
                line: step.line,
                text,
                reads: reads.iter().filter_map(number).collect(),
                written: Vec::new(),
            };
            self.take(seen, &written, moment, recording);
        }
        Ok(())
    }

    /// Looks at what these registers hold.
    fn take(
        &mut self,
        mut step: TraceStep,
        written: &[usize],
        moment: &Moment<'_>,
        recording: &mut Recording,
    ) {
        for register in written {
            let it = self.registers[*register];
            let (chip, twin) = (it.values(&*self.chip), it.values(&*self.twin));
            if self.parting.is_none() {
                self.parting = parting(it, &chip, &twin).map(|(at, median)| TraceParting {
                    frame: moment.index,
                    word: recording.words,
                    line: step.line,
                    text: step.text.clone(),
                    register: it.name(&self.opened.device),
                    at,
                    chip: chip[(at.y, at.x)],
                    twin: twin[(at.y, at.x)],
                    median,
                });
            }
            if recording.words > WORDS {
                continue;
            }
            let shown = |plane: &Plane<f64>| -> Vec<f64> {
                let every = ndarray::s![..;self.every as isize, ..;self.every as isize];
                plane.slice(every).iter().copied().collect()
            };
            step.written.push(TraceVersion {
                register: *register,
                chip: shown(&chip),
                twin: shown(&twin),
                quiet: self.quiet.as_ref().map(|quiet| shown(&it.values(&**quiet))),
            });
        }
        if recording.words <= WORDS {
            recording.steps.push(step);
        }
    }

    /// The page, and what is to be said beside.
    pub fn page(self) -> miette::Result<(String, Vec<String>)> {
        let Opened {
            program, device, ..
        } = self.opened;
        let mut notes = Vec::new();
        if let Some(arithmetic) = self.decided {
            notes.push(format!(
                "the host decided by what it read in {arithmetic}; the same words ran here"
            ));
        }
        if self.dropped > 0 {
            notes.push(format!(
                "the first {} frames were run and are left out: --frames runs fewer",
                self.dropped
            ));
        }
        if self.unseen > 0 {
            notes.push(format!(
                "of each frame the first {WORDS} words and operations are shown; {} more were run",
                self.unseen
            ));
        }
        let registers = self.registers.iter().map(|register| TraceRegister {
            name: register.name(device),
            is_bit: register.is_bit(),
        });
        let mut said = vec![match &self.parting {
            Some(parting) => {
                format!("trace: chip and exact part first, by more than {LIMIT} LSB, in {parting}")
            }
            None => format!("trace: no pixel parts by more than {LIMIT} LSB from exact arithmetic"),
        }];
        if self.every > 1 {
            said.push(format!(
                "trace: of {} rows and columns one is shown",
                self.every
            ));
        }
        said.extend(notes.iter().map(|note| format!("trace: {note}")));
        let trace = Trace {
            program: program.file.clone(),
            title: program.settings.title.clone(),
            text: program.text.to_string(),
            machine: self.machine,
            size: self.chip.size(),
            every: self.every,
            registers: registers.collect(),
            steps: self.frames.into_iter().flatten().collect(),
            limit: LIMIT,
            parting: self.parting,
            notes,
        };
        Ok((page(&trace)?, said))
    }
}

/// A frame that is being recorded.
struct Recording {
    packet: Packet,
    steps: Vec<TraceStep>,
    /// Words and operations so far.
    words: usize,
}

/// The first pixel in which a register is another than its exact self, and the median difference,
/// which does not count: a few pixels that are far off do not move it.
fn parting(register: Register, chip: &Plane<f64>, twin: &Plane<f64>) -> Option<(At, f64)> {
    let apart = chip - twin;
    let (limit, median) = if register.is_bit() {
        (0.0, 0.0)
    } else {
        let mut sorted: Vec<f64> = apart.iter().copied().collect();
        let middle = sorted.len() / 2;
        let (_, median, _) = sorted.select_nth_unstable_by(middle, f64::total_cmp);
        (LIMIT, *median)
    };
    let mut apart = apart.indexed_iter();
    let found = apart.find(|(_, value)| (**value - median).abs() > limit);
    found.map(|((y, x), _)| (At { y, x }, median))
}

/// What a program touches, in the order of the chip: photodiodes, analogue registers, bits, FLAG.
fn touched(codes: &[&[Step]], device: &Device) -> Vec<Register> {
    let uses = codes.iter().map(|steps| uses(steps, device));
    let mut all: Vec<Register> = uses.flatten().flatten().collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The registers that some steps read, and those that they write.
fn uses(steps: &[Step], device: &Device) -> [Vec<Register>; 2] {
    let effect = CellEffect::of(steps, device);
    let mut reads: Vec<Register> = effect.reads.into_iter().map(Register::from).collect();
    let mut writes: Vec<Register> = effect.writes.into_iter().map(Register::from).collect();
    let [read, written] = photodiode(steps, device);
    if read {
        reads.push(Register::Pix);
    }
    if written {
        writes.push(Register::Pix);
    }
    [reads, writes]
}

/// Whether some steps read the photodiodes, and whether they reset them.
fn photodiode(steps: &[Step], device: &Device) -> [bool; 2] {
    let mut all = [false; 2];
    for step in steps {
        let [read, written] = match &step.action {
            Action::Host(_) => continue,
            Action::Repeat { body, .. } => photodiode(body, device),
            Action::Word(word) => {
                let operands = device.operands(word);
                let pix = Terminal::Pix;
                [
                    operands.reads().any(|it| it.terminal == pix),
                    operands.writes().any(|it| it.terminal == pix),
                ]
            }
        };
        all = [all[0] | read, all[1] | written];
    }
    all
}

/// How many planes of numbers the words of some steps write.
fn planes(steps: &[Step], device: &Device) -> usize {
    let mut eighths = 0usize;
    for step in steps {
        let more = match &step.action {
            Action::Repeat { times, body } => {
                8 * planes(body, device).saturating_mul(*times as usize)
            }
            Action::Word(_) | Action::Host(_) => {
                let [_, written] = uses(std::slice::from_ref(step), device);
                let eighths = |it: &Register| if it.is_bit() { 1 } else { 8 };
                written.iter().map(eighths).sum()
            }
        };
        eighths = eighths.saturating_add(more);
    }
    // So many words are shown, and a word writes up to three.
    eighths.div_ceil(8).min(3 * WORDS)
}
