//! What there is to warn of in a run of a sensor, as `amacrine run` and the Python package both say it.

use crate::{
    array::{Arithmetic, Settings, Unheld},
    event::Dropped,
    isa::Device,
    number::Format,
    photoreceptor::Response,
    plane::Size,
    program::Code,
    reference::Description,
    rig::{
        Larger, Overflow,
        guard::{Crowd, Guard, Warning},
    },
    scene::Frame,
    sensor::{Overflowed, Silence},
};

use super::saturation;

/// Looks at a run of a sensor, frame by frame.
#[derive(Clone, Debug)]
pub struct RunGuard {
    crowd: Crowd,
    overflow: Overflow,
    response: Response,
    /// What its kinds of cells are called, where they have names.
    names: Vec<Option<String>>,
    /// What its number format makes of its kernels.
    rounded: Option<Warning>,
    /// The spread of thresholds and the least of them, of the kind where it is the largest part.
    spread: Option<(f64, f64)>,
    /// How far a still scene is from the memory, and the threshold that it reaches.
    still: Option<[f64; 2]>,
    /// Numbers of its program that its cells do not hold.
    unheld: Option<Unheld>,
    /// The chip whose array is smaller than what its program is shown.
    larger: Option<Larger>,
    /// How long a cell is silent, in microseconds.
    refractory: f64,
    /// Whether its events go through slots of its own program, which may lose those of a kind.
    has_slots: bool,
}

/// What a sensor has done in all frames so far.
#[derive(Clone, Debug)]
pub struct Done<'a> {
    /// Events of each kind.
    pub kinds: &'a [u64],
    /// Events that left the readout.
    pub kept: u64,
    /// Those that did not.
    pub dropped: Dropped,
    /// Why no cell fired, where none did.
    pub silence: Silence,
    /// Drives beyond their numbers.
    pub overflowed: Overflowed,
}

impl RunGuard {
    /// Nothing seen yet of a float sensor of this size.
    #[must_use]
    pub fn new(description: &Description, size: Size, format: Format) -> Self {
        let kinds = description.channels.len();
        let losses = description.losses(format);
        let names = description.channels.iter().map(|kind| kind.name.clone());
        Self {
            crowd: Crowd::new((kinds * size.pixels()) as u64),
            overflow: Overflow::new(format, description.response),
            response: description.response,
            names: names.collect(),
            rounded: losses.map(|loss| Warning::rounded(&description.name, kinds, loss)),
            spread: spread(description),
            still: description.still(),
            unheld: None,
            larger: None,
            refractory: description.refractory.us,
            has_slots: false,
        }
    }

    /// The same of a sensor that is a program.
    #[must_use]
    pub fn of_program(
        (code, device): (&Code, &Device),
        cells: Arithmetic,
        settings: &Settings,
        size: Size,
        kinds: usize,
    ) -> Self {
        Self {
            crowd: Crowd::new((kinds * size.pixels()) as u64),
            overflow: saturation::of_light(cells, settings),
            response: Response::IDENTITY,
            names: vec![None; kinds],
            rounded: None,
            spread: None,
            still: None,
            unheld: Unheld::of_program(cells, &[&code.init, &code.frame], device, settings),
            larger: Larger::check("the array", size, device).err(),
            refractory: 0.0,
            has_slots: true,
        }
    }

    /// From light to what its cells see.
    #[must_use]
    pub const fn response(&self) -> Response {
        self.response
    }

    /// A frame that the sensor has seen, at which so many cells fired. The first one sets the memory,
    /// and nobody fires.
    pub fn see(&mut self, frame: &Frame, firing: u64) {
        self.crowd.see(firing);
        self.overflow.see(frame);
    }

    /// What there is to warn of, beside the scene, of a sensor that is called `subject`.
    #[must_use]
    pub fn warnings(&self, subject: &str, done: &Done<'_>) -> Vec<Warning> {
        let mut guard = Guard::new();
        let frames = self.crowd.frames;
        let (lost, unscanned) = (done.dropped.no_slot, done.dropped.unscanned);
        // Without its own numbers nothing that it says tells of light or thresholds, and where slots
        // were lacking or rows were not scanned, the events of a kind may be lost.
        let is_whole = !self.has_slots || (lost, unscanned) == (0, 0);
        let can_judge = self.unheld.is_none() && is_whole;
        let is_silent = can_judge && done.kinds.iter().all(|events| *events == 0);
        let spread = self.spread;
        let rounded = self.rounded.clone();
        let silent = is_silent.then(|| Warning::no_events_of(subject, frames, &done.silence));
        let still = self.still.map(|reached| Warning::still(subject, reached));
        let spread = spread.and_then(|(sigma, least)| Warning::spread(subject, sigma, least));
        let crowd = (self.crowd.over > 0).then(|| Warning::most_cells(subject, &self.crowd));
        let slots = (lost > 0).then(|| Warning::slots("the readout", lost, done.kept));
        let full = done.dropped.queue_full;
        let queue = (full > 0).then(|| Warning::queue("the readout", full, done.kept));
        let nothing = unscanned > 0 && (done.kept, lost, full) == (0, 0, 0);
        let nothing = nothing.then(|| Warning::no_events_in_rows(subject, frames, unscanned));
        let rows = (unscanned > 0).then(|| Warning::rows(subject, unscanned, done.kept));
        let larger = self.larger.as_ref();
        let larger = larger.map(|larger| Warning::larger(subject, larger));
        let refractory = Warning::refractory(subject, self.refractory);
        let all = [
            larger, rounded, silent, still, spread, refractory, crowd, slots, queue, nothing, rows,
        ];
        guard.extend(all.into_iter().flatten());
        if let Some(unheld) = &self.unheld {
            saturation::warn_unheld(&mut guard, subject, unheld);
        } else {
            guard.extend(self.overflow.warning(subject, done.overflowed));
        }
        let names: Vec<_> = self.names.iter().map(Option::as_deref).collect();
        let silent = Warning::silent_kinds(subject, &names, done.kinds, frames);
        guard.extend(silent.filter(|_| can_judge));
        guard.warnings()
    }
}

/// The largest spread of thresholds as a part of them: it, and the threshold.
fn spread(description: &Description) -> Option<(f64, f64)> {
    let all = description
        .channels
        .iter()
        .flat_map(|kind| &kind.thresholds);
    all.map(|own| (own.sigma, own.on.min(own.off)))
        .max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)))
}
