//! What a scene is warned of: its light, its frames, its rate.

use super::{About, Warning};
use crate::{
    photoreceptor::{Curve, Response},
    scene::{Alias, Cut, Gap, Moment, Observation, Repeated, Samples, Slice, Unlike},
    unit::{counted, five_digits},
};

/// Light so many times the sensor's white is on another scale; what shines is brighter than white.
const BEYOND: f64 = 4.0;

/// The same for whole numbers, which end at white; a scale that was given may be a little off.
const BEYOND_WHOLE: f64 = 1.1;

/// Reals that are so many times less than the sensor's white, all of them, have another white.
const DARK: f64 = 64.0;

impl Warning {
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
                format!("light beyond {white} is used as it is{}", grown(response)),
                format!(
                    "give --scale as {white} divided by white in the array ({:.6} for 10 bits, {:.6} for 12, {:.8} for 16), or multiply the array",
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
                ": under a logarithm the scale acts through the offset and light-dependent noise"
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
                "{looks}; from its darkest to its brightest value the signal changes by {}, and with light times {white} by {}{also}",
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
            .map_or("where nothing else changes".to_owned(), |times| {
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
                "the whole picture changes ({usual}, correlation {:.2} with the frame before), and every pixel may fire",
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
                "drop one frame in {cycle} and show the others at {:.0} % of the frame rate; for a video file: ffmpeg -i CLIP -vf decimate=cycle={cycle} -pix_fmt gray clip.y4m",
                percent(cycle - 1, cycle)
            ),
            None => format!(
                "drop them and show the {} others at {:.0} % of the frame rate; for a video file: mkdir FRAMES; ffmpeg -i CLIP -vf mpdecimate -fps_mode passthrough FRAMES/%06d.png, then --fps",
                of - frames,
                percent(of - frames, of)
            ),
        };
        (10 * frames >= of).then(|| {
            Self::new(
                About::Repeats,
                "the scene",
                format!("{frames} of {of} frames repeat the frame before"),
                "the file has a higher frame rate than the camera: motion stops and jumps, and events come in bursts",
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
                "{} missing in the numbering: after {} comes {}",
                counted(gap.missing, "picture") + if gap.missing == 1 { " is" } else { " are" },
                gap.before,
                gap.after
            ),
            "pictures are shown at even intervals: those after a gap come too early, and motion jumps",
            "add them, or show the parts before and after the gap as separate scenes (--slice)",
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
                "event times are whole microseconds, so events of several frames get the same time (counts and voxels use exact times)",
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
                "each pixel samples the light at its centre, so moving blobs flicker (aliasing)",
                "give grain=2 or more, or draw more pixels and reduce them (--resize)"
                    .to_owned(),
            ),
            Alias::Shrunk { growth, pixels } => (
                format!("growth={growth}: at the end one pixel spans {pixels:.1} pixels of the texture"),
                "each pixel samples the light at its centre, so moving texture flickers (aliasing)",
                "give a growth nearer to 0, fewer frames or a coarser texture, or draw more pixels and reduce them (--resize)".to_owned(),
            ),
            Alias::Still { frequency, fps } => (
                format!("frequency={frequency} Hz at {fps} frames/s is seen as constant light"),
                "every frame samples the wave at its middle level",
                format!("give fps= of {} or more, or a lower frequency", 4.0 * frequency),
            ),
            Alias::Fast { frequency, fps } => {
                let seen_as = (frequency - (frequency / fps).round() * fps).abs();
                (
                    format!("frequency={frequency} Hz at {fps} frames/s is seen as {seen_as} Hz"),
                    "it is above half the frame rate (aliasing)",
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
                format!("its pixels are not square: width {width}, height {height}"),
                "they are taken as square: the picture is narrower or wider than players show it, and horizontal speeds differ",
                "make them square first: ffmpeg -i CLIP -vf scale=iw*sar:ih,setsar=1 -pix_fmt gray clip.y4m",
            ),
            Unlike::Angle => Self::new(
                About::Shape,
                "the scene",
                "players rotate its pictures by an angle that is not a multiple of 90 degrees",
                "here they are shown as they are stored",
                "rotate them first, such as by ffmpeg -i CLIP -vf rotate=PI/4 -pix_fmt gray clip.y4m",
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
                    "all its frames were shown: ask for {has}, give no number, or take a longer scene"
                ),
            )
        })
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
            ", so all changes and their noise are larger by the same factor"
        }
        Curve::Log { .. } => {
            ": under a logarithm the scale acts through the offset and light-dependent noise"
        }
        Curve::LinLog { .. } => {
            ": a logarithm ignores the scale, but dark light now lies above the knee, and light-dependent noise differs"
        }
    }
}
