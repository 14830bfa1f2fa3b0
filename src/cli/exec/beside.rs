//! A program whose host decides as it goes, beside the array.

use std::{ops::ControlFlow, sync::Arc};

use miette::miette;

use super::{
    bench::Bench,
    light::{Lasting, Light},
    moment::{Moment, Part},
};
use crate::{
    array::{Array, answered},
    cli::{arguments::budget::Growth, complain},
    event::Packet,
    program::{Answer, Beside, Exposure, Step},
    scene::{Frame, Scene},
    study::execution::begin,
    unit::Micros,
};

/// How many frames a still picture is shown for.
pub const FRAMES: u64 = 2;

/// Frames before, with which one may share its steps.
const KNOWN: usize = 16;

/// What is done in each frame.
pub type Run<'r> =
    dyn FnMut(&mut dyn Array, &Moment<'_>, &mut Packet) -> miette::Result<ControlFlow<()>> + 'r;

/// What the host asked for in this frame, and in those before.
#[derive(Default)]
struct Recorder {
    asked: Vec<Step>,
    frames: Vec<Arc<[Step]>>,
}

impl Recorder {
    fn end_frame(&mut self) {
        let steps = std::mem::take(&mut self.asked);
        // Most frames are alike.
        let mut known = self.frames.iter().rev().take(KNOWN);
        let known = known.find(|it| ***it == *steps).cloned();
        self.frames.push(known.unwrap_or_else(|| steps.into()));
    }
}

/// The array and its light, as the host sees them.
struct Companion<'r> {
    chip: &'r mut dyn Array,
    program: &'r str,
    light: Lasting,
    run: &'r mut Run<'r>,
    packet: Packet,
    growth: Growth,
    /// The frame that runs, when it falls, and the seconds since the one before.
    now: Option<(Frame, Micros, Option<f64>)>,
    frames: u64,
    /// Words before this frame.
    before: u64,
    /// What is done with the photodiodes.
    exposure: Exposure,
    /// Words of the shortest and of the longest frame.
    words: Option<(u64, u64)>,
    /// What the host wrote, and in which frame.
    posts: Vec<(u64, String)>,
    /// What keeps the steps, where somebody looks at them.
    recorder: Option<&'r mut Recorder>,
    stopped: Option<miette::Report>,
    /// Whether there is no light any more.
    over: bool,
}

/// Runs the program with its host beside this chip; what it said, and how many frames it saw.
pub fn watch(
    bench: &Bench<'_>,
    chip: &mut dyn Array,
    run: &mut Run<'_>,
) -> miette::Result<(Packet, u64)> {
    ran(bench, chip, run, None)
}

/// Runs the program with its host beside this chip; the steps of each frame.
pub fn record(bench: &Bench<'_>, chip: &mut dyn Array) -> miette::Result<Vec<Arc<[Step]>>> {
    let mut on = |_: &mut dyn Array, _: &Moment<'_>, _: &mut Packet| Ok(ControlFlow::Continue(()));
    let mut recorder = Recorder::default();
    ran(bench, chip, &mut on, Some(&mut recorder))?;
    Ok(recorder.frames)
}

fn ran(
    bench: &Bench<'_>,
    chip: &mut dyn Array,
    run: &mut Run<'_>,
    recorder: Option<&mut Recorder>,
) -> miette::Result<(Packet, u64)> {
    let opened = &bench.opened;
    let light = Light::open(bench.arguments, &opened.program, &bench.observation)?;
    let mut array = Companion {
        packet: Packet::new(chip.size(), chip.channels()),
        before: chip.ledger().words().0,
        chip,
        program: &opened.program.file,
        light: Lasting::new(light, bench.size, FRAMES),
        run,
        growth: bench.growth(),
        now: None,
        frames: 0,
        exposure: Exposure::default(),
        words: None,
        posts: Vec::new(),
        recorder,
        stopped: None,
        over: false,
    };
    let ran = opened
        .program
        .run_beside(&opened.device, &opened.overrides, &mut array);
    if array.stopped.is_none() && ran.is_ok() {
        array.stopped = array.end_frame().err();
    }
    if let Some(stopped) = array.stopped.take() {
        return Err(stopped);
    }
    if let Some(warnings) = ran? {
        bench.said.source.replace(warnings.lines());
        complain(&format!("{:?}\n", miette!(warnings)));
    }
    bench.said.set(&array.light);
    let left = array.now.is_none() && !array.over && array.light.next_frame()?.is_some();
    bench.said.left.set(left);
    bench.said.words.set(array.words);
    bench.said.exposure.set(array.exposure);
    bench.said.posts.replace(array.posts);
    let mut packet = array.packet;
    packet.names = opened.program.names_of(packet.channels)?;
    Ok((packet, array.frames))
}

impl Companion<'_> {
    fn end_frame(&mut self) -> miette::Result<()> {
        let Some((frame, t, since)) = self.now.take() else {
            return Ok(());
        };
        let words = self.chip.ledger().words().0;
        let count = words - std::mem::replace(&mut self.before, words);
        let (least, most) = self.words.unwrap_or((count, count));
        self.words = Some((least.min(count), most.max(count)));
        let moment = Moment {
            index: self.frames,
            t,
            since,
            light: &frame.light,
            steps: &[],
            part: Part::Ran,
        };
        if let Some(recorder) = &mut self.recorder {
            recorder.end_frame();
        }
        self.frames += 1;
        // What ends a run early is only there where its steps are known.
        let _ = (self.run)(self.chip, &moment, &mut self.packet)?;
        self.growth.check(&self.packet, self.program)
    }

    fn next_frame(&mut self) -> miette::Result<bool> {
        let before = self.now.as_ref().map(|now| now.0.seconds);
        if self.frames > 0 {
            self.exposure.next_frame();
        }
        self.end_frame()?;
        let Some(frame) = self.light.next_frame()? else {
            self.over = true;
            return Ok(false);
        };
        let (t, since) = begin(self.chip, &frame, before, &mut self.packet)?;
        self.now = Some((frame, t, since));
        Ok(true)
    }
}

impl Beside for Companion<'_> {
    fn frame(&mut self) -> bool {
        self.next_frame().unwrap_or_else(|why| {
            self.stopped = Some(why);
            false
        })
    }

    fn run(&mut self, steps: &[Step]) -> Option<Answer> {
        let t = self.now.as_ref().map_or(Micros(0), |now| now.1);
        if self.frames > 0 {
            self.exposure.see(steps, self.chip.device());
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.asked.extend_from_slice(steps);
        }
        let answer = answered(self.chip, steps, t, &mut self.packet);
        answer.map_err(|why| self.stopped = Some(why.into())).ok()
    }

    fn micros(&self) -> f64 {
        self.chip.ledger().cost(self.chip.device()).micros()
    }

    fn post(&mut self, text: String) {
        self.posts.push((self.frames, text));
    }
}
