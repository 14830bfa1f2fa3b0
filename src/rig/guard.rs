//! Guards: what in a run makes its figures mean something else than they seem to.
//!
//! A sensor that never fires, one of which most cells fire at once, a readout whose slots are
//! full, registers at the end of their range, light on another scale, a cut, frames that repeat.
//! Each guard says what was seen, why that probably is, and what to change.

use std::fmt;

use miette::Diagnostic as _;

use super::Larger;
use crate::{
    compare::window::can_judge,
    event::{Dropped, Event, Packet},
    kernel::quantise::Erasure,
    photoreceptor::{Curve, Response},
    plane::Size,
    scene::{Alias, Cut, Frame, Gap, Moment, Observation, Repeated, Samples, Slice, Unlike},
    sensor::Silence,
    unit::{Micros, counted, five_digits},
};

/// Light so many times the sensor's white is on another scale; what shines is brighter than white.
const BEYOND: f64 = 4.0;

/// The same for whole numbers, which end at white; a scale that was given may be a little off.
const BEYOND_WHOLE: f64 = 1.1;

/// Reals that are so many times less than the sensor's white, all of them, have another white.
const DARK: f64 = 64.0;

/// What a warning is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum About {
    /// No event at all.
    NoEvents,
    /// Scores of a few events.
    FewEvents,
    /// More than half of all cells fire in one frame.
    MostCells,
    /// Events found no slot of the readout.
    Slots,
    /// Events found the queue of the readout full.
    Queue,
    /// Events lie in rows that the readout does not scan.
    Rows,
    /// A readout that is busy all the time.
    Late,
    /// Thresholds that differ so much from cell to cell that their floor decides.
    Spread,
    /// Values at the end of the range of what holds them.
    Saturation,
    /// Light on another scale than the sensor's.
    Scale,
    /// The clip shows another picture from one frame to the next.
    Cut,
    /// Frames of the clip are the one before once more.
    Repeats,
    /// Numbers are missing among those of pictures.
    Gap,
    /// A pattern finer than pixels, or faster than frames.
    Alias,
    /// Frames less than a microsecond apart, which times of events do not tell apart.
    SameTime,
    /// A clip that players show in another shape.
    Shape,
    /// A frame rate that nobody said.
    AssumedRate,
    /// A clip that ends before all frames that were asked for.
    Short,
    /// Nearly everything matches by accident within the window.
    Window,
    /// A still scene fires.
    Still,
    /// A kernel in few values has lost its surround.
    Surround,
    /// A symmetric kernel is not symmetric in few values.
    Lopsided,
    /// Weights of a kernel lie beyond its levels.
    Clipped,
    /// A kernel is another one in a number format.
    Rounded,
    /// An array larger than the chip's.
    Larger,
    /// Kinds of cells that are compared have other names.
    Names,
    /// No threshold gives the rate of events that was asked for.
    Rate,
    /// Of what was designed, little is kept on the chip.
    Kept,
}

impl About {
    /// As it is written.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoEvents => "no-events",
            Self::FewEvents => "few-events",
            Self::MostCells => "most-cells",
            Self::Slots => "slots",
            Self::Queue => "queue",
            Self::Rows => "rows",
            Self::Late => "late",
            Self::Spread => "spread",
            Self::Saturation => "saturation",
            Self::Scale => "scale",
            Self::Cut => "cut",
            Self::Repeats => "repeats",
            Self::Gap => "gap",
            Self::Alias => "alias",
            Self::SameTime => "same-time",
            Self::Shape => "shape",
            Self::AssumedRate => "assumed-rate",
            Self::Short => "short",
            Self::Window => "window",
            Self::Still => "still",
            Self::Surround => "surround",
            Self::Lopsided => "lopsided",
            Self::Clipped => "clipped",
            Self::Rounded => "rounded",
            Self::Larger => "larger",
            Self::Names => "names",
            Self::Rate => "rate",
            Self::Kept => "kept",
        }
    }
}

/// A guard that has something to say.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Warning {
    /// What it is about.
    pub about: About,
    /// Of whom it holds: sensors, or the scene.
    pub subjects: Vec<String>,
    /// What was seen, of the first of them.
    pub seen: String,
    /// Why that probably is.
    pub why: String,
    /// What to change.
    pub change: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (first, others) = match self.subjects.split_first() {
            Some((first, others)) => (first.as_str(), others),
            None => ("the run", [].as_slice()),
        };
        write!(f, "{first}: {}", self.seen)?;
        if !others.is_empty() {
            write!(f, " (alike: {})", others.join("; "))?;
        }
        write!(f, ": {}; {}", self.why, self.change)
    }
}

impl Warning {
    pub(super) fn new(
        about: About,
        subject: &str,
        seen: impl Into<String>,
        why: impl Into<String>,
        change: impl Into<String>,
    ) -> Self {
        Self {
            about,
            subjects: vec![subject.to_owned()],
            seen: seen.into(),
            why: why.into(),
            change: change.into(),
        }
    }

    /// A sensor that never fired; `frames` where they are known.
    #[must_use]
    pub fn no_events(subject: &str, frames: Option<u64>) -> Self {
        let lower = "lower the threshold, give light on the scale of the sensor (0 to 255; --scale for an array), use a memory that steps, halve less often on a chip, or show a scene that moves";
        let (seen, why, change) = match frames {
            Some(frames @ 0..=1) => (
                format!("no event at all in {}", counted(frames, "frame")),
                "events happen between frames, and there are not two",
                "show a scene of two frames at least",
            ),
            Some(frames) => (
                format!("no event at all in {}", counted(frames, "frame")),
                "what its cells see never moves by a threshold: the light is small against it, or it does not change",
                lower,
            ),
            None => (
                "no event at all".to_owned(),
                "nothing happens in this recording, or in this part of it",
                "give a recording, or a part of it, in which something does",
            ),
        };
        Self::new(About::NoEvents, subject, seen, why, change)
    }

    /// What a comparison of two recordings warns of, in which accident scores `floor` within `window`.
    #[must_use]
    pub fn of_comparison(
        [reference, judged]: [&Packet; 2],
        window: Micros,
        floor: f64,
    ) -> Vec<Self> {
        let mut guard = Guard::new();
        guard.recording("the reference", reference);
        guard.recording("the judged", judged);
        let speak = !reference.events.is_empty() && !judged.events.is_empty();
        let window = Self::window(window, floor).filter(|_| speak);
        guard.extend(Self::names(&reference.names, &judged.names));
        guard.extend(window);
        guard.warnings()
    }

    /// Recordings whose kinds of cells, which are compared by their numbers, have other names.
    #[must_use]
    pub fn names(reference: &[String], judged: &[String]) -> Option<Self> {
        let mut pairs = reference.iter().zip(judged).enumerate();
        let (kind, (one, other)) = pairs.find(|(_, (one, other))| one != other)?;
        Some(Self::new(
            About::Names,
            "the judged",
            format!("kind {kind} is `{other}`, and `{one}` in the reference"),
            "kinds are compared by their numbers, whatever they are called",
            "where they stand in another order, compare kind by kind, each written by `amacrine convert --kind`",
        ))
    }

    /// A sensor whose memory is seen through another kernel than the light: how far off that first is,
    /// and the threshold that it reaches.
    #[must_use]
    pub fn still(subject: &str, [most, threshold]: [f64; 2]) -> Self {
        let shown = |number: f64| (number * 1e4).round() / 1e4;
        Self::new(
            About::Still,
            subject,
            "a still scene fires: memory-kernel is not the kernel",
            format!(
                "the first distance is (W - W_m) * u, which light from 0 to 255 brings to {}, and a threshold is {}",
                shown(most),
                shown(threshold)
            ),
            "give memory-kernel the weights of kernel, or use memory = \"filtered-step\"; as it is, it does what the released code does",
        )
    }

    /// A program that never fired, since nobody gave it light.
    #[must_use]
    pub fn in_the_dark(subject: &str, frames: u64) -> Self {
        Self::new(
            About::NoEvents,
            subject,
            format!(
                "no event at all in {} of the dark",
                counted(frames, "frame")
            ),
            "no light was given, and the program names none of its own",
            "give --image SCENE, a clip or a pattern such as pattern:disc",
        )
    }

    /// Events per pixel and second that were asked for, and those of the nearest threshold, where
    /// these are more than a tenth off.
    #[must_use]
    pub fn rate(subject: &str, asked: f64, nearest: f64) -> Option<Self> {
        ((nearest / asked - 1.0).abs() > 0.1).then(|| {
            Self::new(
                About::Rate,
                subject,
                format!(
                    "no threshold gives {asked} events per pixel and second: {nearest:.4} is the nearest"
                ),
                "many cells change by the same amount (few levels of light), and fire together or not at all",
                "take a rate that there is, give the threshold itself (--threshold), or show a scene of more levels",
            )
        })
    }

    /// What is kept on the chip of a design that was taken, where it is less than `half`.
    #[must_use]
    pub fn kept(subject: &str, kept: f64, half: f64) -> Option<Self> {
        (kept < half).then(|| {
            Self::new(
                About::Kept,
                subject,
                format!("{kept:.2} is kept on the chip"),
                "most of its events are not what the kernels say, and it is the best that was found or taken",
                "give higher thresholds or a lower rate, other few values (--to), a longer search (--effort), or other kernels",
            )
        })
    }

    /// A program on an array that is larger than its chip's.
    #[must_use]
    pub fn larger(subject: &str, larger: &Larger) -> Self {
        let Larger {
            size,
            chip,
            rows,
            columns,
            ..
        } = larger;
        Self::new(
            About::Larger,
            subject,
            format!("an array of {size}, and {chip} has {columns}x{rows} processors"),
            "no chip runs what is shown here, and times are those of the smaller array",
            larger
                .help()
                .map_or_else(String::new, |help| help.to_string()),
        )
    }

    /// A sensor of which most cells fire in one frame.
    #[must_use]
    pub fn most_cells(subject: &str, crowd: &Crowd) -> Self {
        let share = 100.0 * crowd.most as f64 / crowd.cells as f64;
        // The first frame is what a memory begins with: cells fire in it only where there is none.
        let frames = crowd.frames - u64::from(crowd.first == 0 && crowd.frames > 1);
        let seen = format!(
            "{} of {} cells ({share:.0} %) fire in frame {}, and more than half in {} of {} frames",
            crowd.most, crowd.cells, crowd.frame, crowd.over, frames
        );
        Self::new(
            About::MostCells,
            subject,
            seen,
            "the threshold is below what changes everywhere: noise, flicker, a cut, or a memory that fires again",
            "raise the threshold, give light on the scale of the sensor, use a memory that steps rather than snaps, or leave out the frames at which the whole picture changes",
        )
    }

    /// Thresholds whose standard deviation from cell to cell, `sigma`, is more than a third of the
    /// least threshold: some cells in a thousand are then at the floor of a threshold.
    #[must_use]
    pub fn spread(subject: &str, sigma: f64, threshold: f64) -> Option<Self> {
        (3.0 * sigma > threshold).then(|| {
            Self::new(
                About::Spread,
                subject,
                format!("the spread of its thresholds (sigma {sigma}) is more than a third of a threshold ({threshold})"),
                "a cell whose threshold would fall below a twentieth of that has a twentieth, and fires twenty times as often: such cells decide how many events there are",
                "give a smaller sigma (in the sensor file, or run --sigma), or leave it out (--without mismatch)",
            )
        })
    }

    /// A window within which accident scores this much; none where a score still says something
    /// ([`can_judge`]).
    #[must_use]
    pub fn window(within: Micros, floor: f64) -> Option<Self> {
        (!can_judge(floor)).then(|| {
            Self::new(
                About::Window,
                "what is kept",
                format!("within {within} accident scores {floor:.3} of 1"),
                "the events last little longer than the window, or cells speak more often than that",
                "take a shorter window (--within, in a study `within`), or a longer scene",
            )
        })
    }

    /// Two packets without an event, which differ in nothing.
    #[must_use]
    pub fn nothing_to_compare(subject: &str) -> Self {
        Self::new(
            About::NoEvents,
            subject,
            "it cannot be told, since neither sensor has an event",
            "the threshold is above what changes anywhere",
            "leave such points out: lower the thresholds, or show a scene that moves",
        )
    }

    /// What a kernel in few values has lost of its shape.
    #[must_use]
    pub fn erased(subject: &str, erasure: Erasure) -> Self {
        let (about, why, change) = match erasure {
            Erasure::Surround { .. } | Erasure::Sign { .. } => (
                About::Surround,
                "its weights are too small for so few values",
                "take more values (another --to)",
            ),
            Erasure::Lopsided { .. } => (
                About::Lopsided,
                "too few weights are left to keep the sum evenly",
                "take more values (another --to), or leave the sum free",
            ),
            Erasure::Clipped { .. } => (
                About::Clipped,
                "the scale of fixed point is 1, whatever the kernel's is",
                "take more bits before the point, or int-B, whose scale fits the kernel",
            ),
        };
        Self::new(about, subject, erasure.to_string(), why, change)
    }

    /// A readout that lost events.
    #[must_use]
    pub fn slots(subject: &str, lost: u64, kept: u64) -> Self {
        let share = share_lost(lost, kept);
        Self::new(
            About::Slots,
            subject,
            format!("the readout's slots were full: {share} are lost"),
            "more cells fired in a frame than were asked for",
            "ask for more slots, raise the threshold, or read whole bit planes",
        )
    }

    /// A program whose events were all counted, and whose own readout loses some of them.
    #[must_use]
    pub fn own_slots(subject: &str, lost: u64, all: u64) -> Self {
        let share = share_lost(lost, all.saturating_sub(lost));
        Self::new(
            About::Slots,
            subject,
            format!("all slots of the program would lose {share}; what is told counts them"),
            "more cells fire in a frame than one scan delivers",
            "have the program read whole bit planes (amacrine compile --readout planes), or raise the threshold",
        )
    }

    /// A readout whose queue lost events.
    #[must_use]
    pub fn queue(subject: &str, lost: u64, kept: u64) -> Self {
        let share = share_lost(lost, kept);
        Self::new(
            About::Queue,
            subject,
            format!("the readout's queue was full: {share} are lost"),
            "events came faster than the link sends them, and more than the queue holds",
            "give a longer queue (fifo, or fifo=unlimited) or a faster link, let the arbiter wait (when-full=stall, with requests=all so that a cell's events do not merge meanwhile), or raise the threshold",
        )
    }

    /// A readout that scans some rows only, and lost events in others.
    #[must_use]
    pub fn rows(subject: &str, lost: u64, kept: u64) -> Self {
        let share = share_lost(lost, kept);
        Self::new(
            About::Rows,
            subject,
            format!("the readout scans some rows only: {share} lie in others and are lost"),
            "cells fired in rows that the program does not read",
            "compile it for this scene (--scene), read all rows (compile --readout planes, or slots), or leave it so where only these rows are wanted",
        )
    }

    /// A readout without an event, since all of them lie in rows that it does not scan.
    #[must_use]
    pub fn no_events_in_rows(subject: &str, frames: u64, lost: u64) -> Self {
        Self::new(
            About::NoEvents,
            subject,
            format!("no event at all in {}", counted(frames, "frame")),
            format!(
                "its cells made {}, in rows that the program does not scan",
                counted(lost, "event")
            ),
            "scan the rows in which they lie",
        )
    }

    /// Numbers without a scale of their own that lie near 0, or beyond white, for a sensor whose
    /// response takes 0 to 255, or to another white. Whole numbers beyond it are of more bits; of
    /// reals some may be brighter than white.
    #[must_use]
    pub fn scale(samples: Samples, extent: Option<(f64, f64)>, response: Response) -> Option<Self> {
        let (low, high) = extent?;
        let white = response.white();
        let (dark, most) = match samples {
            Samples::Floats => (white / DARK, BEYOND * white),
            Samples::Integers => (1.0, BEYOND_WHOLE * white),
            Samples::Video | Samples::Pictures | Samples::Moved | Samples::Drawn => return None,
        };
        let is_dark = low >= 0.0 && high <= dark.max(1.0001) && high > 0.0;
        if high > most {
            return Some(Self::new(
                About::Scale,
                "the scene",
                format!(
                    "light goes up to {}, but the sensor takes 0 to {white}",
                    five_digits(high)
                ),
                format!(
                    "numbers of more than 8 bits are taken as they are{}",
                    grown(response)
                ),
                format!(
                    "give --scale with {white} over what is white in the array ({:.6} for 10 bits, {:.6} for 12, {:.8} for 16), or multiply the array",
                    white / 1023.0,
                    white / 4095.0,
                    white / 65_535.0
                ),
            ));
        }
        if !is_dark || white <= 2.0 {
            return None;
        }
        let looks = if high <= 1.0001 {
            "the array is scaled to 1"
        } else {
            "the array seems to be scaled to 1, with light above it"
        };
        // Light of 0 and above has a signal in every response.
        let moves = |by: f64| {
            let at = |light: f64| response.apply(by * light).unwrap_or(0.0);
            at(high) - at(low)
        };
        let (here, there) = (moves(1.0), moves(white));
        let also = match response.curve {
            Curve::Log { .. } => {
                ": a logarithm feels the scale by its offset, and noise that depends on light does"
            }
            Curve::Identity | Curve::Linear { .. } | Curve::LinLog { .. } => "",
        };
        Some(Self::new(
            About::Scale,
            "the scene",
            format!(
                "all light lies between {} and {}, but the sensor takes 0 to {white}",
                five_digits(low),
                five_digits(high)
            ),
            format!(
                "{looks}; from its darkest to its brightest the signal moves by {}, and times {white} by {}{also}",
                five_digits(here),
                five_digits(there)
            ),
            format!("give --scale {white}, or multiply the array"),
        ))
    }

    /// A clip with cuts.
    #[must_use]
    pub fn cuts(cuts: &[Cut], slice: Option<Slice>) -> Option<Self> {
        const SHOWN: usize = 5;
        let first = cuts.first()?;
        let at: Vec<String> = cuts
            .iter()
            .take(SHOWN)
            .map(|cut| format!("{} ({:.3} s)", cut.frame, cut.seconds))
            .collect();
        let more = match cuts.len().saturating_sub(SHOWN) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let kind = if cuts.len() == 1 {
            "a cut at frame"
        } else {
            "cuts at frames"
        };
        let usual = first
            .times_usual
            .map_or("where nothing changes otherwise".to_owned(), |times| {
                format!("{times:.0} times the usual change")
            });
        Some(Self::new(
            About::Cut,
            "the scene",
            format!(
                "{kind} {}{more}{}",
                at.join(", "),
                slice.map_or("", |_| " of this slice")
            ),
            format!(
                "another picture, {usual}, correlation {:.2} with the frame before: every pixel may fire there",
                first.correlation
            ),
            format!(
                "split the clip there: one scene is its first {}{}",
                counted(first.frame, "frame"),
                parted(first.frame, slice)
            ),
        ))
    }

    /// A clip of which every tenth frame or more repeats the one before.
    #[must_use]
    pub fn repeats(repeated: Repeated) -> Option<Self> {
        let Repeated { frames, of } = repeated;
        let percent = |new: u64, of: u64| 100.0 * new as f64 / of as f64;
        let change = match repeated.cycle() {
            Some(cycle) => format!(
                "leave out one of {cycle} and show the others at {:.0} % of the rate; of a video file: ffmpeg -i CLIP -vf decimate=cycle={cycle} -pix_fmt gray clip.y4m",
                percent(cycle - 1, cycle)
            ),
            None => format!(
                "leave them out and show the {} others at {:.0} % of the rate; of a video file: mkdir FRAMES; ffmpeg -i CLIP -vf mpdecimate -fps_mode passthrough FRAMES/%06d.png, then --fps",
                of - frames,
                percent(of - frames, of)
            ),
        };
        (10 * frames >= of).then(|| {
            Self::new(
                About::Repeats,
                "the scene",
                format!("{frames} of {of} frames are the frame before once more"),
                "the file has a higher frame rate than the camera had: what moves stands still and then jumps, and events come in bursts",
                change,
            )
        })
    }

    /// A folder of pictures that lacks some by their numbers.
    #[must_use]
    pub fn gap(gap: Gap) -> Self {
        Self::new(
            About::Gap,
            "the scene",
            format!(
                "by their numbers {} missing: after {} comes {}",
                counted(gap.missing, "picture") + if gap.missing == 1 { " is" } else { " are" },
                gap.before,
                gap.after
            ),
            "pictures are shown one after another: what comes behind a gap is too early, and what moves jumps",
            "add them, or show the parts before and behind as scenes of their own (--slice)",
        )
    }

    /// A readout of which this stage cannot keep up.
    #[must_use]
    pub fn late(subject: &str, stage: &str) -> Self {
        Self::new(
            About::Late,
            subject,
            format!("the {stage} of the readout is busy all the time and cannot keep up"),
            "events are lost or leave later and later; what a scan reads keeps the time of its frame, so that no figure tells how late it is",
            "take fewer slots, a faster readout, or a lower frame rate",
        )
    }

    /// A clip whose frames are less than a microsecond apart, the unit of times of events.
    #[must_use]
    pub fn same_time(interval: f64) -> Option<Self> {
        // A microsecond that was rounded is one.
        (interval < 1e-6 * (1.0 - 1e-9)).then(|| {
            Self::new(
                About::SameTime,
                "the scene",
                format!("frames are {:.3} us apart", interval * 1e6),
                "times of events are whole microseconds: events of several frames have the same time (counts and voxels take the exact times)",
                "give the frame rate of the camera (--fps)",
            )
        })
    }

    /// A pattern that is seen as another, since it is finer than pixels or faster than frames.
    #[must_use]
    pub fn alias(alias: Alias) -> Self {
        let (seen, why, change) = match alias {
            Alias::Fine { grain } => (
                format!("grain={grain}: its blobs are smaller than two pixels"),
                "each pixel has the light at its centre, which flickers as they move",
                "give grain=2 or more, or draw more pixels and show them as fewer (--resize)"
                    .to_owned(),
            ),
            Alias::Shrunk { growth, pixels } => (
                format!("growth={growth}: at the end {pixels:.1} pixels of the texture lie side by side in one"),
                "each pixel has the light at its centre, which flickers as they move",
                "give a growth nearer to 0, fewer frames or a coarser texture, or draw more pixels and show them as fewer (--resize)".to_owned(),
            ),
            Alias::Still { frequency, fps } => (
                format!("frequency={frequency} Hz at {fps} frames/s is seen as light at rest"),
                "every frame is taken as it passes its middle",
                format!("give fps= of {} or more, or a lower frequency", 4.0 * frequency),
            ),
            Alias::Fast { frequency, fps } => {
                let seen_as = (frequency - (frequency / fps).round() * fps).abs();
                (
                    format!("frequency={frequency} Hz at {fps} frames/s is seen as {seen_as} Hz"),
                    "it goes up and down more often than every other frame",
                    format!("give fps= of {} or more, or a lower frequency", 4.0 * frequency),
                )
            }
        };
        Self::new(About::Alias, "the scene", seen, why, change)
    }

    /// A clip that players show in another shape.
    #[must_use]
    pub fn shape(unlike: Unlike) -> Self {
        match unlike {
            Unlike::Pixels { width, height } => Self::new(
                About::Shape,
                "the scene",
                format!("its pixels are {width} wide where they are {height} high"),
                "here they are taken as square, so that the picture is narrower or wider than players show it, and what moves along rows has another speed",
                "make them square first: ffmpeg -i CLIP -vf scale=iw*sar:ih,setsar=1 -pix_fmt gray clip.y4m",
            ),
            Unlike::Angle => Self::new(
                About::Shape,
                "the scene",
                "players turn its pictures by an angle that is no quarter of a turn",
                "here they are shown as they are stored",
                "turn them first, such as by ffmpeg -i CLIP -vf rotate=PI/4 -pix_fmt gray clip.y4m",
            ),
        }
    }

    /// A frame rate that neither the scene nor the caller said: for whoever shows no line with it;
    /// `key` is what says another.
    #[must_use]
    pub fn assumed_rate(observation: &Observation, key: &str) -> Option<Self> {
        let fps = observation.assumed_fps()?;
        Some(Self::new(
            About::AssumedRate,
            "the scene",
            format!("{fps} frames/s are assumed"),
            "the file states no frame rate",
            format!("say it with {key}"),
        ))
    }

    /// A scene that has fewer frames than were asked for.
    #[must_use]
    pub fn short(observation: &Observation, asked: Option<u64>) -> Option<Self> {
        let has = observation.frames();
        asked.filter(|asked| has < *asked).map(|asked| {
            Self::new(
                About::Short,
                "the scene",
                format!("it ends after {}", counted(has, "frame")),
                format!("frames = {asked} was asked for"),
                format!(
                    "all that it has are seen: ask for {has}, or for none, or give a longer one"
                ),
            )
        })
    }

    /// What a scene warns of, for a sensor of this response.
    #[must_use]
    pub fn of_scene(observation: &Observation, response: Response) -> Vec<Self> {
        let light = observation.light();
        let scale = light.and_then(|it| Self::scale(it.samples, observation.extent(), response));
        { scale.into_iter() }
            .chain(Self::of_pictures(observation))
            .collect()
    }

    /// The same, without what depends on a sensor.
    #[must_use]
    pub fn of_pictures(observation: &Observation) -> Vec<Self> {
        let cuts = Self::cuts(&observation.cuts(), observation.slice());
        let repeats = observation.repeated().and_then(Self::repeats);
        let gap = observation.gap().map(Self::gap);
        let alias = observation.alias().map(Self::alias);
        let shape = observation.unlike().map(Self::shape);
        let same_time = observation.interval().and_then(Self::same_time);
        { cuts.into_iter() }
            .chain(repeats)
            .chain(gap)
            .chain(alias)
            .chain(shape)
            .chain(same_time)
            .collect()
    }
}

/// How a clip, or this slice of one, is parted before a frame: `--slice` counts frames of the clip.
fn parted(frame: u64, slice: Option<Slice>) -> String {
    let all = Slice {
        from: Moment::Frame(0),
        to: None,
    };
    let slice = slice.unwrap_or(all);
    let Moment::Frame(from) = slice.from else {
        return " (--slice, or `slice` in a study, in frames of the clip)".to_owned();
    };
    let at = Moment::Frame(from.saturating_add(frame));
    let [one, next] = [
        Slice {
            to: Some(at),
            ..slice
        },
        Slice { from: at, ..slice },
    ];
    format!(" (--slice {one}, or `slice` in a study), the next is the rest (--slice {next})")
}

/// What light far above white does to a sensor of this response.
fn grown(response: Response) -> &'static str {
    match response.curve {
        Curve::Identity | Curve::Linear { .. } => {
            ", so that all changes are as much larger and their noise with them"
        }
        Curve::Log { .. } => {
            ": a logarithm feels the scale by its offset, and noise that depends on light does"
        }
        Curve::LinLog { .. } => {
            ": a logarithm does not feel the scale, but what was dark lies above the knee, and noise that depends on light is another"
        }
    }
}

/// How many cells fire at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crowd {
    /// All cells.
    pub cells: u64,
    /// Frames that were looked at.
    pub frames: u64,
    /// Those in which more than half of all cells fire.
    pub over: u64,
    /// The most cells that fire in one.
    pub most: u64,
    /// Which one that is.
    pub frame: u64,
    /// Those that fire in the first.
    pub first: u64,
}

impl Crowd {
    /// Nothing seen yet of so many cells.
    #[must_use]
    pub fn new(cells: u64) -> Self {
        Self {
            cells,
            ..Self::default()
        }
    }

    /// The next frame, in which so many cells fire.
    pub fn see(&mut self, firing: u64) {
        if firing > self.most {
            self.most = firing;
            self.frame = self.frames;
        }
        if self.frames == 0 {
            self.first = firing;
        }
        self.over += u64::from(2 * firing > self.cells);
        self.frames += 1;
    }

    /// From a packet whose frames were at these times: the cells that fire after one and up to
    /// the next.
    #[must_use]
    pub fn from_packet(packet: &Packet, frames: &[Micros]) -> Self {
        let Size { height, width } = packet.size;
        let cells = height * width * usize::from(packet.channels);
        let mut crowd = Self::new(cells as u64);
        // The last frame, from 1, in which each cell fired.
        let mut last = vec![0_u32; cells];
        let mut events = packet.events.iter().peekable();
        for (frame, time) in (1..).zip(frames) {
            let mut firing = 0;
            while let Some(event) = events.next_if(|event| event.t <= *time) {
                if let Some(last) = last.get_mut(cell(event, packet.size)) {
                    firing += u64::from(*last != frame);
                    *last = frame;
                }
            }
            crowd.see(firing);
        }
        crowd
    }
}

fn cell(event: &Event, size: Size) -> usize {
    let plane = usize::from(event.channel) * size.height + usize::from(event.y);
    plane * size.width + usize::from(event.x)
}

/// Looks at the packets of a run.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    frames: Vec<Micros>,
    warnings: Vec<Warning>,
}

/// How many of all events were lost.
fn share_lost(lost: u64, kept: u64) -> String {
    let all = lost.saturating_add(kept);
    let share = 100.0 * lost as f64 / all as f64;
    format!("{lost} of {all} events ({share:.1} %)")
}

impl Guard {
    /// Nothing seen yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The next frame that the sensors see.
    pub fn frame(&mut self, frame: &Frame) {
        self.frame_at(Micros::from_seconds(frame.seconds));
    }

    /// The same, by its time.
    pub fn frame_at(&mut self, time: Micros) {
        self.frames.push(time);
    }

    /// What a sensor said of all frames so far.
    pub fn packet(&mut self, subject: &str, packet: &Packet) {
        self.packet_of(subject, packet, &Silence::default());
    }

    /// The same of a sensor that knows why it is silent, where it is.
    pub fn packet_of(&mut self, subject: &str, packet: &Packet, silence: &Silence) {
        let Dropped {
            no_slot,
            queue_full,
            unscanned,
            ..
        } = packet.dropped;
        let kept = packet.events.len() as u64;
        if (kept, no_slot, queue_full) == (0, 0, 0) {
            let frames = self.frames.len() as u64;
            self.warn(if unscanned > 0 {
                Warning::no_events_in_rows(subject, frames, unscanned)
            } else {
                Warning::no_events_of(subject, frames, silence)
            });
            return self.lost(subject, packet.dropped, kept);
        }
        let crowd = Crowd::from_packet(packet, &self.frames);
        if crowd.over > 0 {
            self.warn(Warning::most_cells(subject, &crowd));
        }
        self.lost(subject, packet.dropped, kept);
    }

    /// Events that a readout lost, beside so many that were kept.
    pub fn lost(&mut self, subject: &str, dropped: Dropped, kept: u64) {
        if dropped.no_slot > 0 {
            self.warn(Warning::slots(subject, dropped.no_slot, kept));
        }
        if dropped.queue_full > 0 {
            self.warn(Warning::queue(subject, dropped.queue_full, kept));
        }
        if dropped.unscanned > 0 {
            self.warn(Warning::rows(subject, dropped.unscanned, kept));
        }
    }

    /// What is in a file of events, of which no frames are known.
    pub fn recording(&mut self, subject: &str, packet: &Packet) {
        let Dropped {
            no_slot,
            queue_full,
            unscanned,
            ..
        } = packet.dropped;
        let kept = packet.events.len() as u64;
        if (kept, no_slot, queue_full, unscanned) == (0, 0, 0, 0) {
            self.warn(Warning::no_events(subject, None));
        }
        self.lost(subject, packet.dropped, kept);
    }

    /// Another warning. Who is warned of the same is named with the first.
    pub fn warn(&mut self, warning: Warning) {
        let same = self.warnings.iter_mut().find(|w| w.about == warning.about);
        match same {
            Some(same) => {
                for subject in warning.subjects {
                    if !same.subjects.contains(&subject) {
                        same.subjects.push(subject);
                    }
                }
            }
            None => self.warnings.push(warning),
        }
    }

    /// All that there is to warn of.
    #[must_use]
    pub fn warnings(self) -> Vec<Warning> {
        self.warnings
    }
}

impl Extend<Warning> for Guard {
    fn extend<T: IntoIterator<Item = Warning>>(&mut self, warnings: T) {
        for warning in warnings {
            self.warn(warning);
        }
    }
}
