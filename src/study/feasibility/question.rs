//! The question, and how it is answered.

use super::{
    Assumption, Chosen, Feasibility, FeasibilityError, Fit, Known, Named, Sight, Stream, Streams,
    Watched, Weights,
    chip::{OnChip, Parts, Time},
    power::{Link, Power},
    stream::{self, Window},
    verdict::Verdict,
};
use crate::{
    array::{Arithmetic, Array},
    compile::Effort,
    event::{Packet, readout::Readout},
    isa::{Device, Evidence},
    kernel::{
        Kernel,
        quantise::{Quantised, Quantiser, Sum},
    },
    mesh::{self, Fitting},
    number::Format,
    plane::{Plane, Size},
    program::{Action, Cost, Host, Step},
    reference::MemoryRule,
    rig,
    scene::{Frame, Scene, SceneError},
    sensor::Sensor,
    study::{
        design::{Compiled, Design, DesignError},
        quantisation::{self, Outcome, Row},
        waterfall::{self, Waterfall, WaterfallError},
    },
    unit::Micros,
};

/// What is asked.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// What the kernel is called.
    pub name: &'a str,
    /// The kernel.
    pub kernel: &'a Kernel,
    /// Events where kernel times light (0 to 255) moved by more than this.
    pub threshold: f64,
    /// The few values that the chip computes with; else the best of the candidates.
    pub to: Option<Quantiser>,
    /// Rows of the table.
    pub candidates: &'a [Quantiser],
    /// What quantised kernels must sum to.
    pub sum: Sum,
    /// The chip.
    pub device: &'a Device,
    /// How long each frame is exposed, where that is known.
    pub exposure: Option<Micros>,
    /// Energy of a bit on the link, pJ: the least and the most.
    pub link: [f64; 2],
    /// How long to search for each program.
    pub effort: Effort,
    /// Seed of the searches, of stochastic rounding, of the silicon and of the null streams.
    pub seed: u64,
    /// How events leave the chip, in the waterfall.
    pub readout: Readout,
    /// Events of one pixel and sign that are closer than this match.
    pub within: Micros,
    /// What the scene is called.
    pub scene: &'a str,
    /// The command that asks all this.
    pub command: &'a str,
}

/// Two scores that are closer than this are one: then fewer words win.
pub(super) const ALIKE: f64 = 0.005;

/// Of the mesh fits: what is added to the squared relative error for each squared gain.
const RIDGE: f64 = 1e-4;

/// Asks the question of a scene that can be opened again: it is watched for the table, for the
/// sensors, for the waterfall and for the pictures. `seen` is called after each frame that sensors watched.
///
/// # Errors
/// When the threshold is not positive, the kernel is all 0 or not to be had in the values that
/// were asked for, or the scene cannot be read.
pub fn ask(
    question: &Question<'_>,
    open: &dyn Fn() -> Result<Box<dyn Scene>, SceneError>,
    mut seen: impl FnMut(&Frame),
) -> Result<(Feasibility, Sight), FeasibilityError> {
    let design = question.design();
    design.description(MemoryRule::FilteredSnap)?;
    let quantisation = question.table(&design, &mut *open()?, &mut seen)?;
    let (to, quantised) = question.choose(&design, &quantisation)?;
    let compiled = match design.in_levels(&quantised).compile(question.name) {
        Ok(compiled) => Ok(compiled),
        Err(error) if error.is_refusal() => Err(error.to_string()),
        Err(error) => return Err(error.into()),
    };
    let program = compiled.as_ref().ok();

    let mut scene = open()?;
    let (said, frames) = question.watch(&design, program, &mut *scene, &mut seen)?;
    let scene = Watched::of(question.scene, &*scene, frames, &said.float);
    let streams = said.streams(question, scene.fps)?;
    let waterfall = match program {
        Some(_) => question.waterfall(&design, to, &mut *open()?, &mut seen)?,
        None => None,
    };
    let sight = Sight::of(&said.float, said.silicon.as_ref(), &mut *open()?)?;
    let on_chip = |compiled: &Compiled| {
        let threshold = question.threshold / quantised.scale * compiled.program.scale;
        let time = time(question, compiled, said.silicon.as_ref(), scene.fps);
        OnChip::of(
            &compiled.program,
            &compiled.code,
            question.device,
            threshold,
            time,
        )
    };
    let rate = |stream: &Stream| Some(stream.events as f64 / scene.seconds);
    let events_s = streams
        .silicon
        .as_ref()
        .filter(|_| scene.seconds > 0.0)
        .and_then(rate);
    let mut feasibility = Feasibility {
        amacrine: env!("CARGO_PKG_VERSION"),
        command: question.command.to_owned(),
        seed: question.seed,
        verdict: Verdict::default(),
        kernel: Weights::of(question.name, question.kernel),
        threshold: question.threshold,
        chip: Named::of(question.device),
        chosen: Chosen {
            to: to.to_string(),
            asked_for: question.to.is_some(),
            relative_error: quantised.relative_error(question.kernel),
            scale: quantised.scale,
            levels: Weights::of(&to.to_string(), &quantised.levels),
        },
        fit: match &compiled {
            Ok(compiled) => Fit::OnChip(Box::new(on_chip(compiled))),
            Err(why) => Fit::Refused(why.clone()),
        },
        within_us: question.within,
        power: program.map(|p| Power::of(&p.cost, question.device, scene.fps, events_s)),
        link: question.link_of(&streams, &scene),
        streams,
        waterfall,
        quantisation,
        mesh: meshes(question.kernel),
        assumptions: question.assumptions(&scene),
        scene,
    };
    feasibility.verdict = Verdict::of(&feasibility);
    Ok((feasibility, sight))
}

/// The kernel as one sheet and as two have it; nothing of a kernel of zeros.
fn meshes(kernel: &Kernel) -> Vec<mesh::Fit> {
    let fit = |sheets| {
        let how = Fitting {
            sheets,
            anisotropic: false,
            ridge: RIDGE,
        };
        mesh::fit(kernel, how).ok()
    };
    (1..=2).filter_map(fit).collect()
}

/// A frame's time, as programmed and with the slots that the scene needs.
fn time(question: &Question<'_>, program: &Compiled, said: Option<&Packet>, fps: f64) -> Time {
    let slots = slots(&program.code.frame);
    let needed = said
        .map_or(0, stream::most_in_a_frame)
        .clamp(1, slots.max(1));
    let fewer = program.clone().with_slots(needed as u32);
    Time::of(&Parts {
        cost: program.cost,
        cost_of_scene: Cost::of(&fewer.code.frame, question.device),
        slots: [slots, needed],
        exposure: question.exposure,
        fps,
        device: question.device,
    })
}

/// Slots of a readout of events.
fn slots(steps: &[Step]) -> u64 {
    let of = |step: &Step| match &step.action {
        Action::Host(Host::ScanEvents { slots, .. } | Host::ScanEventsFrom { slots, .. }) => {
            u64::from(*slots)
        }
        Action::Repeat { body, .. } => self::slots(body),
        Action::Host(_) | Action::Word(_) => 0,
    };
    steps.iter().map(of).max().unwrap_or(0)
}

impl Question<'_> {
    fn design(&self) -> Design<'_> {
        Design {
            kernel: self.kernel,
            threshold: self.threshold,
            device: self.device,
            effort: self.effort,
            seed: self.seed,
        }
    }

    /// A row for each candidate, also for those that the kernel is not to be had in.
    fn table(
        &self,
        design: &Design<'_>,
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<Vec<Row>, FeasibilityError> {
        let why_not = |to: &Quantiser| design.quantise(*to, self.sum).err();
        let usable: Vec<Quantiser> = self
            .candidates
            .iter()
            .copied()
            .filter(|to| why_not(to).is_none())
            .collect();
        let table = quantisation::Question {
            kernel: self.kernel,
            threshold: self.threshold,
            quantisers: &usable,
            sum: self.sum,
            device: self.device,
            effort: self.effort,
            seed: self.seed,
            within: self.within,
        };
        let mut rows = quantisation::ask(&table, scene, seen)?.rows.into_iter();
        let row = |to: &Quantiser| match why_not(to) {
            None => rows.next(),
            Some(error) => Some(Row {
                to: to.to_string(),
                relative_error: 1.0,
                outcome: Outcome::Refused(error.to_string()),
            }),
        };
        Ok(self.candidates.iter().filter_map(row).collect())
    }

    /// What was asked for; else the candidate that scores best with the chip's errors, of those
    /// that score alike the one with the fewest words; else, where none has a program, the first
    /// that there is.
    fn choose(
        &self,
        design: &Design<'_>,
        rows: &[Row],
    ) -> Result<(Quantiser, Quantised), DesignError> {
        let quantised = |to: Quantiser| Ok((to, design.quantise(to, self.sum)?));
        if let Some(to) = self.to {
            return quantised(to);
        }
        let programs = || {
            let both = self.candidates.iter().zip(rows);
            both.filter_map(|(to, row)| match &row.outcome {
                Outcome::OnChip(chip) => Some((*to, chip)),
                Outcome::Refused(_) => None,
            })
        };
        let best = programs()
            .map(|(_, chip)| chip.silicon.f1)
            .fold(0.0, f64::max);
        let alike = programs().filter(|(_, chip)| chip.silicon.f1 > best - ALIKE);
        if let Some((to, _)) = alike.min_by_key(|(_, chip)| chip.words) {
            return quantised(to);
        }
        let mut all = self.candidates.iter().map(|to| quantised(*to));
        let first = all.next().unwrap_or_else(|| quantised(Quantiser::Ternary));
        first.or_else(|error| all.find_map(Result::ok).ok_or(error))
    }

    /// Shows the scene to the float sensor, to a plain DVS, and to the program's chips.
    fn watch(
        &self,
        design: &Design<'_>,
        program: Option<&Compiled>,
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<(Said, u64), FeasibilityError> {
        let size = scene.size();
        let alone = one_pixel();
        let plain = Design {
            kernel: &alone,
            ..*design
        };
        let float =
            |design: &Design<'_>| design.reference(size, MemoryRule::FilteredSnap, Format::F64);
        let (mut float, mut dvs) = (float(design)?, float(&plain)?);
        let mut chips: Vec<Box<dyn Array + Send>> = Vec::new();
        if let Some(program) = program {
            let silicon = Arithmetic::Silicon { seed: self.seed };
            for arithmetic in [Arithmetic::Number(Format::F64), silicon] {
                chips.push(program.chip(arithmetic, size, program.settings())?);
            }
        }
        let mut sensors: Vec<&mut (dyn Sensor + Send)> = vec![&mut float, &mut dvs];
        sensors.extend(
            chips
                .iter_mut()
                .map(|chip| chip as &mut (dyn Sensor + Send)),
        );
        let mut frames = 0;
        let packets = rig::watch(scene, &mut sensors, |frame| {
            frames += 1;
            seen(frame);
        })?;
        let mut packets = packets.into_iter();
        let mut next = || packets.next();
        let empty = || Packet::new(size, 1);
        let said = Said {
            float: next().unwrap_or_else(empty),
            dvs: next().unwrap_or_else(empty),
            exact: next(),
            silicon: next(),
        };
        Ok((said, frames))
    }

    /// Where the events went; none where the float sensor has none.
    fn waterfall(
        &self,
        design: &Design<'_>,
        to: Quantiser,
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<Option<Waterfall>, FeasibilityError> {
        let asked = waterfall::Question {
            design: *design,
            to,
            sum: self.sum,
            arithmetic: Arithmetic::Silicon { seed: self.seed },
            readout: self.readout,
            within: self.within,
        };
        match waterfall::ask(&asked, scene, seen) {
            Ok(waterfall) => Ok(Some(waterfall)),
            Err(WaterfallError::Silent { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    fn link_of(&self, streams: &Streams, scene: &Watched) -> Link {
        let bit = Known::between(
            self.link,
            "pJ",
            Evidence::Guess,
            "given with the question; nobody states it for a chip that does not exist yet",
        );
        let mut sent = vec![
            ("the plain DVS", &streams.dvs),
            ("the float sensor", &streams.float),
        ];
        sent.extend(streams.silicon.as_ref().map(|s| ("the chip", s)));
        Link::of(bit, &sent, Size::new(scene.height, scene.width), scene.fps)
    }

    fn assumptions(&self, scene: &Watched) -> Vec<Assumption> {
        let mut all = Vec::new();
        let mut assume = |evidence, what: String| all.push(Assumption { what, evidence });
        assume(
            Evidence::Modelled,
            "Light is linear, 0 to 255, and one frame is one shot: both sensors decide once a frame (memory filtered-snap), with zeros beyond the border.".to_owned(),
        );
        if scene.fps_is_assumed {
            assume(
                Evidence::Guess,
                format!(
                    "The scene states no frame rate; {} frames/s were assumed.",
                    scene.fps
                ),
            );
        }
        assume(
            Evidence::Guess,
            match self.exposure {
                Some(exposure) => format!("Exposure is {exposure} a frame, as given."),
                None => "Exposure is not limiting: none was given. The longest that the frame rate leaves is stated.".to_owned(),
            },
        );
        assume(
            Evidence::Modelled,
            "Exposure runs while the array works; the readout comes after both and holds up the next frame.".to_owned(),
        );
        assume(
            Evidence::Modelled,
            "The chip's errors are one drawn chip (the seed): transfer, division and mismatch fitted to the one public measurement of SCAMP-5, noise and decay as its data say. Another seed is another chip.".to_owned(),
        );
        assume(
            Evidence::Modelled,
            "An event costs one address word: row, column and sign. Time is arrival and costs nothing.".to_owned(),
        );
        assume(
            Evidence::Quoted,
            "Power is that of the chip at its full instruction rate; what it takes when it waits is not public. 180 nm numbers of 2013 do not predict a modern stacked part.".to_owned(),
        );
        assume(
            Evidence::Guess,
            format!(
                "A bit on the link takes {} to {} pJ, as given.",
                self.link[0], self.link[1]
            ),
        );
        all
    }
}

/// The kernel of a plain DVS.
fn one_pixel() -> Kernel {
    Kernel::new(Plane::ones((1, 1))).expect("one finite weight is a kernel")
}

/// What the sensors said.
struct Said {
    float: Packet,
    dvs: Packet,
    exact: Option<Packet>,
    silicon: Option<Packet>,
}

impl Said {
    fn streams(&self, question: &Question<'_>, fps: f64) -> Result<Streams, FeasibilityError> {
        let window = Window {
            within: question.within,
            frame: Micros::from_seconds(1.0 / fps),
            seed: question.seed,
        };
        let judged = |packet: &Packet| Stream::of(packet, Some(&self.float), &window);
        Ok(Streams {
            float: Stream::of(&self.float, None, &window)?,
            dvs: judged(&self.dvs)?,
            exact: self.exact.as_ref().map(judged).transpose()?,
            silicon: self.silicon.as_ref().map(judged).transpose()?,
        })
    }
}

impl Watched {
    fn of(name: &str, scene: &dyn Scene, frames: u64, packet: &Packet) -> Self {
        let Size { height, width } = scene.size();
        let (from, to) = packet.span;
        Self {
            name: name.to_owned(),
            width,
            height,
            frames,
            seconds: Micros(to.0.saturating_sub(from.0)).seconds(),
            fps: scene.fps(),
            fps_is_assumed: scene.fps_is_assumed(),
        }
    }
}
