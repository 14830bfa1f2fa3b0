//! `amacrine run`: a scene through a sensor file.

use std::{cell::RefCell, ops::ControlFlow, path::Path};

use miette::{WrapErr, miette};
use serde_json::json;

use super::{
    arguments::{
        budget,
        clip::GivenScene,
        fidelity::{Fidelity, KeptOrUnread, make},
        heading, light,
        quantiser::number_format,
        readout,
        sensor_changes::{Changes, Found},
        without::Effects,
    },
    list::{bundled, of_another_kind},
    output::{
        content::Content,
        event_output::EventOutput,
        files::{self, Input, Output},
        progress::Progress,
    },
};
use crate::{
    bundled::Kind,
    event::{
        Dropped, Packet,
        address::AddressWord,
        readout::{Statistics, settings::Description as ReadoutDescription},
    },
    number::Format,
    plane::Size,
    reference::{
        Counts, Description, Effect, EventList, Firing, Limit, Reference, Report, Sinks, Tally,
        VoxelGrid, WhenFull,
    },
    rig::{self, guard::Warning},
    save::Stack,
    scene::{Observation, Scene, SceneError, upsample},
    source,
    study::{
        pilot::{Part, Plan},
        run_guard::{Done, RunGuard},
    },
    unit::{Micros, counted},
};

/// What `run` is asked to do.
#[derive(Clone, Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine run --scene bundled --sensor rgc --upsample 0.1 --events out/events.npy"
)]
pub struct Arguments {
    #[command(flatten)]
    given: GivenScene,
    /// Sensor file, or a name that `amacrine list sensors` prints
    #[arg(long)]
    sensor: Input,
    #[command(flatten)]
    changes: Changes,
    /// Insert frames so that light changes by at most this contrast from one to the next
    ///
    /// The contrast is the largest change of ln(light + 1) at any pixel, for light from 0 to 255;
    /// 0.1 suits 8-bit video. If left out, no frame is inserted.
    #[arg(long, value_name = "CONTRAST", value_parser = light::contrast, help_heading = heading::SCENE)]
    upsample: Option<f64>,
    /// Seed of mismatch and noise
    ///
    /// 0 is a seed like any other. Under one seed the noise of every clip is the same: give each
    /// clip of training data a seed of its own.
    #[arg(long, default_value_t = 0, help_heading = heading::SENSOR)]
    seed: u64,
    #[arg(long, default_value = "f64", value_parser = number_format, help = format!("Number format of signals, weights and memory: {}", Format::names()), help_heading = heading::SENSOR)]
    format: Format,
    #[arg(short = 'o', long, help = format!("Write the events to this file; the extension names the format ({})", crate::event::file::Format::names()), value_parser = Content::Events)]
    events: Option<Output>,
    #[command(flatten)]
    readout: readout::Choice,
    #[command(flatten)]
    fidelity: Fidelity,
    #[command(flatten)]
    without: Effects,
    /// Write signed event counts: int32 of shape (P,K,H,W), for P frame pairs and K kinds
    #[arg(long, value_name = "C.npy", value_parser = Content::Array, help_heading = heading::OUTPUT)]
    counts: Option<Output>,
    /// Write voxels: float32 of shape (P+1,K,H,W), for P frame pairs and K kinds
    ///
    /// Each event is shared between the two nearest frame times.
    #[arg(long, value_name = "V.npy", value_parser = Content::Array, help_heading = heading::OUTPUT)]
    voxels: Option<Output>,
    /// Largest number of events in the list of --events
    ///
    /// Default: any number, where the events of one frame pair must fit into memory. With
    /// --readout: 100000000, or as many as fit into memory.
    #[arg(long, help_heading = heading::OUTPUT)]
    max_events: Option<usize>,
    /// What to do if a frame pair has too many events for --events [default: stop]
    #[arg(long, value_enum, help_heading = heading::OUTPUT)]
    when_full: Option<Full>,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Full {
    /// Stop with an error, write nothing
    Stop,
    /// Drop the events of that pair, count them, go on
    Drop,
}

/// Runs the verb.
///
/// # Errors
/// When the scene or the sensor file is not what it should be, or an output cannot be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let description = read_sensor(&arguments.sensor)?;
    let chosen = arguments.readout.open()?;
    if chosen.map(|d| d.readout()).transpose()?.is_some() && arguments.events.is_none() {
        return Err(miette!(
            help = "add --events FILE, or leave --readout out",
            "--readout needs --events: counts and voxels are taken before the readout"
        ));
    }
    arguments.check_list()?;
    arguments.fidelity.check()?;
    let without = arguments.without.told();
    arguments.fidelity.check_without(&without)?;
    let observation = Observation::new();
    let open = || arguments.given.open(&observation);
    let shown = || -> Result<Box<dyn Scene>, SceneError> {
        // What is seen of it is noted in the run itself.
        let scene = arguments.given.open(&Observation::new())?;
        upsample::by_contrast(scene, arguments.upsample)
    };
    // What is left out goes last, so that no change puts it back; thresholds for a rate are those of
    // what runs.
    let name = arguments.sensor.display().to_string();
    let description = arguments.changes.set(description)?;
    let description = arguments.without.leave_out(&name, &description)?;
    let (description, found) =
        arguments
            .changes
            .rated(description, (arguments.seed, arguments.format), &shown)?;
    if let Some(found) = found.as_ref().filter(|_| !arguments.json) {
        super::say(&found.line());
    }
    let kept = arguments.changes.line(&description);
    if let Some(kept) = kept.filter(|_| !arguments.json) {
        super::say(&kept);
    }
    let found = found.as_ref();
    if !arguments.fidelity.is_auto() {
        let scene = (open()?, &observation);
        return watched(arguments, &description, (found, None), scene);
    }
    let (plan, scene) = arguments.planned(&description, open)?;
    let plainer = plan.choice.plainer(&description);
    let mut arguments = arguments.clone();
    arguments.format = plan.choice.format;
    if plan.choice.leaves_out(Effect::InsertedFrames) {
        arguments.upsample = None;
    }
    let scene = (scene, &observation);
    watched(&arguments, &plainer, (found, Some(&plan)), scene)
}

impl Arguments {
    /// Refuses what is said of the list of events where there is none.
    fn check_list(&self) -> miette::Result<()> {
        if self.events.is_some() {
            return Ok(());
        }
        if let Some(most) = self.max_events {
            return Err(miette!(
                help = "add --events FILE, or leave --max-events out",
                "--max-events {most} needs --events: it limits the list of events"
            ));
        }
        if self.when_full.is_some() {
            return Err(miette!(
                help = "add --events FILE, or leave --when-full out",
                "--when-full needs --events: it is about the list of events"
            ));
        }
        Ok(())
    }

    /// How many events are taken, where so many may be held.
    fn limit(&self, held: usize) -> Limit {
        let all = if self.readout.is_asked() {
            held
        } else {
            usize::MAX
        };
        Limit {
            events: self.max_events.unwrap_or(all),
            when_full: match self.when_full {
                None | Some(Full::Stop) => WhenFull::Stop,
                Some(Full::Drop) => WhenFull::Drop,
            },
        }
    }

    /// Refuses arrays for which their disks have no room, as far as it is known: frames that are put
    /// in come besides.
    fn check_disk(&self, frames: Option<u64>, channels: usize, size: Size) -> miette::Result<()> {
        let planes = u128::from(frames.unwrap_or_default()) * channels as u128;
        let bytes = planes * size.pixels() as u128 * 4;
        let help = "take fewer frames or a smaller scene";
        let outputs = [(&self.counts, "counts"), (&self.voxels, "voxels")];
        let files: Vec<(&Path, &str)> = { outputs.into_iter() }
            .filter_map(|(output, what)| Some((output.as_ref()?, what)))
            .filter(|(path, _)| !path.is_node())
            .map(|(path, what)| (&**path, what))
            .collect();
        match files[..] {
            [(counts, _), (voxels, _)] if counts.parent() == voxels.parent() => {
                budget::check_disk(counts, 2 * bytes, "counts and voxels", help)
            }
            _ => (files.iter())
                .try_for_each(|(path, what)| budget::check_disk(path, bytes, what, help)),
        }
    }

    /// The plan that was asked for, and the scene, which may have been read for it.
    fn planned(
        &self,
        description: &Description,
        open: impl Fn() -> Result<Box<dyn Scene>, SceneError>,
    ) -> miette::Result<(Plan, Box<dyn Scene>)> {
        if self.format != Format::F64 {
            return Err(miette!(
                help = "leave --format out, or choose the rest by hand as well",
                "--format {} with --fidelity auto, which chooses the format",
                self.format
            ));
        }
        let readout = self.readout.open()?.map(|d| d.readout()).transpose()?;
        let sensor = (description, self.seed);
        // Arrays that are written are whole.
        let crop = self.counts.is_none() && self.voxels.is_none();
        let question = self.fidelity.question(sensor, self.upsample, readout, crop);
        let source = KeptOrUnread::new(question.looks(), open)?;
        let plan =
            make(&question, source.kept()).wrap_err_with(|| self.given.seen_by(&self.sensor))?;
        Ok((plan, source.scene()))
    }
}

/// Watches, and says what was seen.
fn watched(
    arguments: &Arguments,
    description: &Description,
    (found, plan): (Option<&Found>, Option<&Plan>),
    (scene, observation): (Box<dyn Scene>, &Observation),
) -> miette::Result<()> {
    let sensor = description.clone();
    let end = end(&*scene);
    let shown = (scene.frames(), scene.fps());
    arguments.check_disk(shown.0, sensor.channels.len(), scene.size())?;
    let scene = upsample::by_contrast(scene, arguments.upsample)?;
    let window = plan.and_then(Plan::crop);
    let part = window.map(|window| Part::new(scene.size(), window));
    let watched = watch(Run {
        arguments,
        description: sensor,
        scene,
        end,
        shown,
        part,
    });
    let mut warnings = Warning::of_scene(observation, description.response);
    warnings.extend(found.and_then(|found| found.warning(&description.name)));
    light::warn(&warnings);
    let mut watched = watched.wrap_err_with(|| arguments.given.seen_by(&arguments.sensor))?;
    light::warn(&watched.warnings);
    warnings.append(&mut watched.warnings);
    if arguments.json {
        let mut json = watched.json(arguments, description);
        json["light"] = light::json(observation);
        json["warnings"] = json!(warnings);
        if let Some(found) = found {
            json["rate"] = found.json();
        }
        if let Some(plan) = plan {
            json["fidelity"] = arguments.fidelity.json(plan)?;
        }
        super::say(&format!("{json}\n"));
    } else {
        super::say(&watched.table(arguments, description, &light::line(observation)));
        if let Some(plan) = plan {
            super::say(&arguments.fidelity.lines(plan));
        }
        if let Some(path) = &arguments.events {
            super::say(&super::convert::opened(path));
        }
    }
    Ok(())
}

/// Reads a sensor file, or one that comes with the program; the kernel files it names are looked
/// for beside it.
///
/// # Errors
/// When a file cannot be read, or is not what it should be.
pub fn read_sensor(path: &Path) -> miette::Result<Description> {
    if bundled(Kind::Sensor, path).is_none()
        && let Some(other) = path.to_str().and_then(of_another_kind)
    {
        return Err(miette!(
            help = format!(
                "{other}; here give a sensor file, or a name that `amacrine list sensors` prints"
            ),
            "{} is no sensor",
            path.display()
        ));
    }
    let named = RefCell::new(Vec::new());
    let read = |path: &Path| {
        named.borrow_mut().push(path.to_owned());
        Ok(source::bytes(path, "")?)
    };
    let description = Description::open_with(path, &read)?;
    named
        .take()
        .iter()
        .try_for_each(|path| files::reads(path))?;
    Ok(description)
}

/// What a run has to say.
struct Watched {
    size: Size,
    frames: u64,
    fps: f64,
    fps_is_assumed: bool,
    seconds: f64,
    tally: Tally,
    report: Report,
    /// What is not in the file, by reason.
    dropped: Dropped,
    read_out: Option<(ReadoutDescription, Statistics)>,
    paper_metric: Option<f64>,
    warnings: Vec<Warning>,
}

/// The run.
struct Run<'a> {
    arguments: &'a Arguments,
    description: Description,
    scene: Box<dyn Scene>,
    /// When its last frame is to come.
    end: Micros,
    /// Frames before any are put in, where that is known, and how many a second.
    shown: (Option<u64>, f64),
    /// What the plan leaves of the array, where it cuts it.
    part: Option<Part>,
}

/// When the last frame of a scene is to come; 0 where nobody knows.
fn end(scene: &dyn Scene) -> Micros {
    let last = scene.frames().unwrap_or_default().saturating_sub(1);
    Micros::from_seconds(last as f64 / scene.fps())
}

fn watch(run: Run<'_>) -> miette::Result<Watched> {
    let Run {
        arguments,
        description,
        mut scene,
        end,
        shown: (frames, fps),
        part,
    } = run;
    let size = scene.size();
    let channels = description.channels.len();
    let (names, name) = (description.names(), description.name.clone());
    let mut guard = RunGuard::new(&description, size, arguments.format);
    let mut firing = Firing::new();
    let sensor = Reference::bytes_in(arguments.format, &description, size);
    let held = events(arguments, &*scene, sensor, channels)?;
    let limit = arguments.limit(held);
    let sensor = (arguments.format, description, arguments.seed);
    let mut reference = Part::sensor(part.as_ref(), size, sensor)?;
    let mut packet = Packet::new(size, channels as u8);
    packet.names = names;
    packet.span.1 = end;
    // A readout wants the whole packet; without one, events go to the file pair by pair.
    let whole = arguments.readout.is_asked();
    let mut output = EventOutput::new(arguments.events.as_ref(), &packet, whole)?;
    let mut tally = Tally::new(channels);
    let counts_path = arguments.counts.as_ref();
    let mut counts = counts_path.map(|_| Counts::new(size, channels));
    let stack = |path: &Output| Stack::<i32>::create(path, channels, size);
    let mut count_stack = counts_path.map(stack).transpose()?;
    let voxels_path = arguments.voxels.as_ref();
    let mut grid = voxels_path.map(|_| VoxelGrid::new(size, channels));
    let stack = |path: &Output| Stack::<f32>::create(path, channels, size);
    let mut voxel_stack = voxels_path.map(stack).transpose()?;
    let mut paper = PaperMetric::default();
    // Frames that are put in are not known before; those between which they are put are.
    let progress = Progress::new("watching", frames);

    let (mut first, mut last) = (None, 0.0);
    let mut list = { arguments.events.as_ref() }.map(|_| {
        let list = EventList::new(&mut packet, limit).holding(held);
        list.of_part(reference.size(), part.as_ref().map(Part::corner))
    });
    let frames = rig::play(&mut scene, |frame| {
        let sinks = Sinks {
            tally: Some(&mut tally),
            firing: Some(&mut firing),
            list: list.as_mut(),
            counts: counts.as_mut(),
            voxels: grid.as_mut(),
        };
        let cut = part.as_ref().map(|part| part.of(&frame));
        reference.watch_into_sinks(cut.as_ref().unwrap_or(&frame), sinks)?;
        output.take(list.as_mut())?;
        guard.see(&frame, firing.cells());
        if first.is_some() {
            if let (Some(counts), Some(stack)) = (&counts, &mut count_stack) {
                stack.push(counts.planes().iter().cloned())?;
            }
            if let Some(grid) = &mut grid {
                finish_bin(grid, voxel_stack.as_mut(), &mut paper)?;
            }
        }
        first.get_or_insert(frame.seconds);
        last = frame.seconds;
        progress.at((frame.seconds * fps).floor() as u64 + 1);
        Ok::<_, miette::Report>(ControlFlow::Continue(()))
    })?;
    light::check_frames(frames)?;
    if let Some(grid) = &mut grid {
        finish_bin(grid, voxel_stack.as_mut(), &mut paper)?;
    }
    progress.finish();
    let first = first.unwrap_or(0.0);
    packet.span = (Micros::from_seconds(first), Micros::from_seconds(last));
    let mut read_out = None;
    if let Some((chosen, read)) = arguments.readout.apply(&packet)? {
        packet = read.packet;
        read_out = Some((chosen, read.statistics));
    }
    output.finish(&packet)?;
    count_stack.map(Stack::finish).transpose()?;
    voxel_stack.map(Stack::finish).transpose()?;
    let kinds: Vec<u64> = tally.kinds().iter().map(|(on, off)| on + off).collect();
    let done = Done {
        kinds: &kinds,
        kept: packet.events.len() as u64,
        dropped: packet.dropped,
        silence: reference.silence(),
        overflowed: reference.overflowed(),
    };
    Ok(Watched {
        size,
        frames,
        fps: scene.fps(),
        fps_is_assumed: scene.outline().fps_is_assumed,
        seconds: last - first,
        warnings: guard.warnings(&name, &done),
        tally,
        report: reference.report(),
        dropped: packet.dropped,
        read_out,
        paper_metric: grid.is_some().then(|| paper.value()),
    })
}

/// How many events may be held, after all that a run holds besides: those of a pair of frames, or
/// with a readout all of them.
fn events(
    arguments: &Arguments,
    scene: &dyn Scene,
    sensor: u128,
    channels: usize,
) -> miette::Result<usize> {
    let size = scene.size();
    let cells = (channels * size.pixels()) as u128;
    let [planes, binned, listed] = [
        arguments.counts.is_some(),
        arguments.voxels.is_some(),
        arguments.events.is_some(),
    ]
    .map(u128::from);
    let need = budget::of_scene(scene)
        .and("the sensor's cells", sensor)
        // The planes, and one on its way to the file.
        .and("counts", planes * (cells + size.pixels() as u128) * 4)
        .and("voxels", binned * (2 * cells + size.pixels() as u128) * 8);
    let what = format!(
        "a run of {size} with {} of cells in {}",
        counted(channels, "kind"),
        arguments.format
    );
    let help = "take a smaller scene, fewer kinds of cells or a narrower --format";
    if listed == 0 {
        budget::check(&need, &what, help)?;
        return Ok(Limit::default().events);
    }
    if !arguments.readout.is_asked() {
        return budget::room(&need, budget::MADE, &what, help);
    }
    // A readout makes a second packet.
    let each = budget::MADE + Packet::bytes(1);
    budget::events(&need, arguments.max_events, each, &what, help)
}

/// The bin of a frame that no later event can reach goes out.
fn finish_bin(
    grid: &mut VoxelGrid,
    stack: Option<&mut Stack<f32>>,
    paper: &mut PaperMetric,
) -> miette::Result<()> {
    if let Some(stack) = stack {
        stack.push(grid.earlier().iter().map(|plane| plane.mapv(|v| v as f32)))?;
    }
    paper
        .bins
        .push(grid.earlier().iter().flatten().map(|v| v.abs()).sum());
    grid.advance();
    Ok(())
}

/// "Events per bin" as the paper's evaluation computes it: the sum of |voxel| over pairs and
/// their two bins, after neighbouring pairs have been added up, divided by the pairs. Interior
/// bins count twice and opposite signs cancel: it is not a number of events.
#[derive(Default)]
struct PaperMetric {
    bins: Vec<f64>,
}

impl PaperMetric {
    fn value(&self) -> f64 {
        let pairs = self.bins.len().saturating_sub(1);
        let twice: f64 = self.bins.windows(2).map(|pair| pair[0] + pair[1]).sum();
        if pairs == 0 {
            0.0
        } else {
            twice / pairs as f64
        }
    }
}

impl Watched {
    fn per_pixel_second(&self) -> f64 {
        let pixel_seconds = self.size.pixels() as f64 * self.seconds;
        if pixel_seconds > 0.0 {
            self.tally.total() as f64 / pixel_seconds
        } else {
            0.0
        }
    }

    fn bits_per_event(&self) -> u32 {
        AddressWord::new(self.size, self.tally.kinds().len() as u8).bits()
    }

    fn json(&self, arguments: &Arguments, description: &Description) -> serde_json::Value {
        let total = self.tally.total();
        let (on, off) = self
            .tally
            .kinds()
            .iter()
            .fold((0, 0), |sum, kind| (sum.0 + kind.0, sum.1 + kind.1));
        let kinds = self.tally.kinds().iter().zip(&description.channels);
        let kinds = kinds
            .map(|((on, off), kind)| json!({"name": kind.name, "on": on, "off": off}))
            .collect::<Vec<_>>();
        json!({
            "sensor": description.name,
            "scene": arguments.given.scene,
            "format": arguments.format.to_string(),
            "width": self.size.width,
            "height": self.size.height,
            "channels": self.tally.kinds().len(),
            "frames": self.frames,
            "pairs": self.frames - 1,
            "fps": self.fps,
            "fps_is_assumed": self.fps_is_assumed,
            "seconds": self.seconds,
            "events": total,
            "on": on,
            "off": off,
            "kinds": kinds,
            "events_per_pixel_per_second": self.per_pixel_second(),
            "bits_per_event": self.bits_per_event(),
            "bits": total * u64::from(self.bits_per_event()),
            "paper_events_per_bin": self.paper_metric,
            "lost_to_refractory": self.report.lost_to_refractory,
            "pairs_shorter_than_authors_refractory": self.report.muted_pairs,
            "livelocked": self.report.livelocked,
            "without_sign": self.report.without_sign,
            "dropped": self.dropped,
            "arrived": self.arrived(),
            "notes": self.all_notes(),
            "readout": self.read_out.as_ref().map(|(settings, statistics)| json!({"settings": settings, "statistics": statistics})),
        })
    }

    /// What became of crossings, a sentence for each of which there is any.
    fn notes(&self) -> Vec<String> {
        let is = |count: u64| if count == 1 { "is" } else { "are" };
        let Report {
            lost_to_refractory: lost,
            muted_pairs: muted,
            livelocked,
            without_sign: unsigned,
            ..
        } = self.report;
        let over = self.dropped.over_limit;
        let notes = [
            (
                lost,
                format!(
                    "{} lost to the refractory period",
                    counted(lost, "crossing")
                ),
            ),
            (
                muted,
                format!(
                    "{} {} not further apart than the refractory period: rule = \"authors\" allows no event in them",
                    counted(muted, "frame pair"),
                    is(muted)
                ),
            ),
            (
                livelocked,
                format!(
                    "{} from cells whose input has not changed: on a still scene they never stop firing (memory = \"raw-snap\")",
                    counted(livelocked, "event")
                ),
            ),
            (
                unsigned,
                format!(
                    "{} without a sign of the own pixel, not emitted (polarity = \"pixel\")",
                    counted(unsigned, "crossing")
                ),
            ),
            (
                over,
                format!(
                    "{over} of the events {} not in the file: the event list was full (counts above, --counts and --voxels have all)",
                    is(over)
                ),
            ),
        ];
        { notes.into_iter() }
            .filter(|(count, _)| *count > 0)
            .map(|(_, told)| told)
            .collect()
    }

    /// These, and those of the readout.
    fn all_notes(&self) -> Vec<String> {
        let read = self.read_out.iter();
        let of_readout = read.flat_map(|(chosen, read)| readout::notes(chosen, read));
        self.notes().into_iter().chain(of_readout).collect()
    }

    /// Events that left the readout, or that the cells fired where there is none, but for those
    /// beyond a limit.
    fn arrived(&self) -> u64 {
        match &self.read_out {
            Some((_, read)) => read.events[1],
            None => self.tally.total() - self.dropped.over_limit,
        }
    }

    fn table(&self, arguments: &Arguments, description: &Description, light: &str) -> String {
        let kinds = self.tally.kinds();
        let total = self.tally.total();
        let (on, off) = kinds
            .iter()
            .fold((0, 0), |sum, kind| (sum.0 + kind.0, sum.1 + kind.1));
        let (put_in, own) = match arguments.upsample {
            Some(_) => (" with those put in,", " of the scene"),
            None => ("", ""),
        };
        let mut lines = vec![
            format!(
                "sensor   {} ({}, {}{})",
                description.name,
                counted(kinds.len(), "channel"),
                arguments.format,
                arguments.without.told()
            ),
            format!(
                "scene    {}, {}, {}{} in {:.6} s, {} frames/s{}",
                arguments.given.scene,
                self.size,
                counted(self.frames, "frame"),
                put_in,
                self.seconds,
                self.fps,
                own,
            ),
            light.trim_end().to_owned(),
            format!(
                "events   {total} ({on} ON, {off} OFF), {:.4} per pixel per second",
                self.per_pixel_second()
            ),
            format!(
                "bits     {} ({} an event)",
                total * u64::from(self.bits_per_event()),
                self.bits_per_event()
            ),
        ];
        if kinds.len() > 1 {
            for (channel, (on, off)) in kinds.iter().enumerate() {
                let name = description.channels[channel]
                    .name
                    .clone()
                    .unwrap_or_default();
                lines.push(format!("  channel {channel} {name}: {on} ON, {off} OFF"));
            }
        }
        lines.extend(self.notes().iter().map(|note| format!("note     {note}")));
        if let Some((chosen, statistics)) = &self.read_out {
            lines.extend(readout::lines(chosen, statistics));
        }
        let written = [&arguments.events, &arguments.counts, &arguments.voxels];
        lines.extend(
            written
                .into_iter()
                .flatten()
                .map(|path| format!("wrote    {}", path.display())),
        );
        lines.join("\n") + "\n"
    }
}
