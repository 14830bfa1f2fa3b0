//! `amacrine demo`: a real clip through the float reference and through a program on the array.

use std::path::{Path, PathBuf};

use serde_json::json;

use crate::{
    array::{Arithmetic, Array, AtBorder, Settings},
    compare::{Comparison, compare},
    event::{Packet, address, file},
    isa::Device,
    picture::{Moment, Show, contact_sheet, write_animation, write_png},
    plane::Plane,
    program::{Cost, Overrides, Program},
    reference::{Description, Reference},
    rig::{
        self,
        guard::{Guard, Warning},
    },
    scene::{
        Frame, Observation, Observed, Scene, bundled,
        upsample::{Bound, Upsampled, Upsampling},
    },
    sensor::Sensor,
    unit::Micros,
};

use super::{
    content::Content,
    files::{self, Output},
    light,
    progress::Progress,
    timed::Timed,
};

/// The float model.
const SENSOR: (&str, &str) = (
    "sensors/rgc-on-chip.toml",
    include_str!("../../sensors/rgc-on-chip.toml"),
);

/// The program that does the same on the chip.
const PROGRAM: (&str, &str) = (
    "programs/rgc/centre_surround.scamp",
    include_str!("../../programs/rgc/centre_surround.scamp"),
);

/// What the array computes in, and how that is called.
const DOMAINS: [(&str, &str); 3] = [
    ("exact", "no error at all"),
    ("q8.8", "16-bit fixed point"),
    ("silicon", "as the chip errs"),
];

/// Which of them the pictures show.
const SHOWN: &str = "silicon";

/// How finely the clip is cut in time.
const UPSAMPLING: Upsampling = Upsampling {
    bound: Bound::Contrast {
        contrast: 0.5,
        offset: 10.0,
    },
    most_steps: 1000,
};

/// Slots asked for at each of the two readouts: their time is most of a frame's.
const SLOTS: f64 = 1000.0;

/// Events of one pixel and sign that are closer than this match.
const WITHIN: Micros = Micros(1000);

/// A wider window: how much of the loss is a matter of when.
const WIDE: Micros = Micros(20_000);

/// What `demo` is asked to do.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: amacrine demo --out out")]
pub struct Arguments {
    /// Where the event files and pictures go
    #[arg(long, default_value = "out", value_name = "FOLDER", value_parser = Content::Folder)]
    out: Output,
    /// Chooses the silicon's mismatch and noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print one JSON object instead of the table
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
///
/// # Errors
/// When the output folder cannot be written to.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    files::writes(events(&arguments.out).into_iter().flatten())?;
    files::writes(pictures(&arguments.out))?;
    let observation = Observation::new();
    let clip: Box<dyn Scene> = Box::new(Observed::new(bundled()?, &observation));
    let mut scene = Upsampled::new(clip, UPSAMPLING)?;
    let size = scene.size();
    let mut reference = Timed::new(Reference::new(description()?, size, arguments.seed)?);
    let device = Device::scamp5();
    let program = Program::parse(PROGRAM.0, PROGRAM.1)?;
    let code = program
        .expand(&device, &Overrides::from([("slots".to_owned(), SLOTS)]))?
        .code;
    let cost = Cost::of(&code.frame, &device);
    let settings = Settings {
        clip: true,
        ..Settings::from_device(&device)
    };
    let mut chips = Vec::new();
    for (domain, _) in DOMAINS {
        let arithmetic = domain.parse::<Arithmetic>()?.with_seed(arguments.seed);
        let chip = arithmetic.chip(domain, &code, &device, size, settings)?;
        chips.push(Timed::new(chip));
    }

    let (mut moments, mut guard) = (Moments::default(), Guard::new());
    let progress = Progress::new("watching", None);
    let mut sensors: Vec<&mut (dyn Sensor + Send)> = vec![&mut reference];
    sensors.extend(
        chips
            .iter_mut()
            .map(|chip| chip as &mut (dyn Sensor + Send)),
    );
    let mut packets = rig::watch(&mut scene, &mut sensors, |frame| {
        moments.see(frame);
        guard.frame(frame);
        progress.tick();
    })?;
    progress.finish();
    let truth = packets.remove(0);
    guard.packet("float", &truth);
    for (((domain, _), packet), chip) in DOMAINS.iter().zip(&packets).zip(&chips) {
        let subject = format!("array {domain}");
        guard.packet(&subject, packet);
        let ends = domain.parse::<Arithmetic>()?.ends(&device, &settings);
        for at in ends.map_or(Vec::new(), |ends| AtBorder::registers(&*chip.sensor, ends)) {
            let place = format!("{} after the last frame", at.register);
            let counted = (at.pixels, at.of);
            guard.warn(Warning::saturation(&subject, &place, counted, at.ends));
        }
    }
    let mut warnings = Warning::of_scene(&observation, 255.0);
    warnings.append(&mut guard.warnings());
    light::warn(&warnings);

    let mut scores = Vec::new();
    for packet in &packets {
        scores.push([
            compare(&truth, packet, WITHIN)?,
            compare(&truth, packet, WIDE)?,
        ]);
    }
    let written = write(&arguments.out, &truth, &packets, &moments.kept)?;
    let story = Story {
        reference: &reference,
        chips: &chips,
        truth: &truth,
        said: &packets,
        scores: &scores,
        cost,
        scene: &scene,
        observation: &observation,
        warnings: &warnings,
        written,
    };
    if arguments.json {
        super::say(&format!("{}\n", story.json()));
    } else {
        super::say(&story.table());
    }
    Ok(())
}

fn description() -> miette::Result<Description> {
    let nothing = |name: &str| Err(std::io::Error::other(format!("{name} is not built in")));
    Ok(Description::parse(SENSOR.0, SENSOR.1, &nothing)?)
}

/// A picture for every tenth of a second: the frame at its end, the events in it.
#[derive(Default)]
struct Moments {
    kept: Vec<Moment>,
    from: f64,
}

impl Moments {
    fn see(&mut self, frame: &Frame) {
        // The clip's own frames are a tenth of a second apart, to the last bit but one.
        if frame.seconds + 1e-9 < self.from + 0.1 {
            return;
        }
        let light: Plane<f64> = frame.light.clone();
        self.kept.push(Moment {
            from: Micros::from_seconds(self.from),
            to: Micros::from_seconds(frame.seconds),
            frame: light,
        });
        self.from = frame.seconds;
    }
}

/// The event files: the reference's first.
fn events(out: &Path) -> Vec<[PathBuf; 2]> {
    let names = std::iter::once("reference").chain(DOMAINS.iter().map(|(domain, _)| *domain));
    names
        .map(|name| ["csv", "npy"].map(|kind| out.join(format!("{name}.{kind}"))))
        .collect()
}

/// The pictures.
fn pictures(out: &Path) -> [PathBuf; 2] {
    ["sheet.png", "watch.gif"].map(|name| out.join(name))
}

/// Writes events and pictures; returns what was written.
fn write(
    out: &Path,
    truth: &Packet,
    said: &[Packet],
    moments: &[Moment],
) -> miette::Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    let packets = std::iter::once(truth).chain(said);
    for (paths, packet) in events(out).into_iter().zip(packets) {
        for path in paths {
            file::write(&path, packet)?;
            written.push(path);
        }
    }
    let shown = DOMAINS
        .iter()
        .position(|(domain, _)| *domain == SHOWN)
        .unwrap_or(0);
    let device = format!("SCAMP-5 array, {}", DOMAINS[shown].1);
    let show = Show {
        title: "A clip seen by ganglion cells: the float model, and a program on a SCAMP-5 array",
        reference: ("float reference", truth),
        device: (&device, &said[shown]),
    };
    // The busiest moments, in order of time.
    let events = |moment: &Moment| {
        let inside = |t: Micros| moment.from < t && t <= moment.to;
        truth.events.iter().filter(|event| inside(event.t)).count()
    };
    let mut busiest = moments.to_vec();
    busiest.sort_by_cached_key(|moment| std::cmp::Reverse(events(moment)));
    busiest.truncate(4);
    busiest.sort_by_key(|moment| moment.from);
    let [sheet, animation] = pictures(out);
    write_png(&sheet, &contact_sheet(&show, &busiest)?)?;
    write_animation(&animation, &show, moments, 0.1)?;
    written.extend([sheet, animation]);
    Ok(written)
}

/// All that the demo has to say.
struct Story<'a> {
    reference: &'a Timed<Reference>,
    chips: &'a [Timed<Box<dyn Array + Send>>],
    truth: &'a Packet,
    said: &'a [Packet],
    /// Within each of the two windows.
    scores: &'a [[Comparison; 2]],
    cost: Cost,
    scene: &'a Upsampled<Box<dyn Scene>>,
    observation: &'a Observation,
    warnings: &'a [Warning],
    written: Vec<PathBuf>,
}

impl Story<'_> {
    fn frames(&self) -> u64 {
        self.reference.frames
    }

    fn seconds(&self) -> f64 {
        self.truth.span.1.seconds() - self.truth.span.0.seconds()
    }

    fn per_pixel_second(&self, packet: &Packet) -> f64 {
        packet.events.len() as f64 / (packet.size.pixels() as f64 * self.seconds())
    }

    fn frame_rate(&self) -> f64 {
        1e6 / self.cost.micros()
    }

    fn table(&self) -> String {
        let scene = format!(
            "scene      the bundled clip, {}, {:.1} s: {} frames at {} frames/s, {} more between them",
            self.truth.size,
            self.seconds(),
            self.frames() - self.scene.inserted(),
            self.scene.fps(),
            self.scene.inserted(),
        );
        let cost = format!(
            "           {} words, {:.1} us on the array and {:.1} us on the host (2 x {SLOTS} readout slots) a frame: at most {:.0} frames/s",
            self.cost.words.0,
            self.cost.array_us,
            self.cost.host_us,
            self.frame_rate(),
        );
        let mut lines = vec![
            scene,
            format!(
                "light      {}",
                light::line(self.observation)
                    .trim_start_matches("light")
                    .trim()
            ),
            "           (linear in light between two frames: things fade, they do not move)"
                .to_owned(),
            format!(
                "reference  {}: kernel rgc-5x5 in f64, one decision a frame",
                SENSOR.0
            ),
            format!("array      {}: the kernel in three values", PROGRAM.0),
            cost,
            String::new(),
            format!(
                "{:<14}{:<20}{:>8}{:>10}{:>10}{:>11}{:>8}{:>8}{:>10}{:>13}",
                "",
                "",
                "events",
                "/pixel/s",
                "bits",
                "precision",
                "recall",
                "F1",
                "F1 20 ms",
                "emulated"
            ),
            format!(
                "{:<14}{:<20}{:>8}{:>10.4}{:>10}{:>11}{:>8}{:>8}{:>10}{:>9.0} f/s",
                "float f64",
                "the model",
                self.truth.events.len(),
                self.per_pixel_second(self.truth),
                address::bits(self.truth),
                "-",
                "-",
                "-",
                "-",
                self.reference.speed(),
            ),
        ];
        for (i, (domain, what)) in DOMAINS.iter().enumerate() {
            let (packet, [score, wide]) = (&self.said[i], &self.scores[i]);
            lines.push(format!(
                "{:<14}{what:<20}{:>8}{:>10.4}{:>10}{:>11.4}{:>8.4}{:>8.4}{:>10.4}{:>9.0} f/s",
                format!("array {domain}"),
                packet.events.len(),
                self.per_pixel_second(packet),
                address::bits(packet),
                score.precision,
                score.recall,
                score.f1,
                wide.f1,
                self.chips[i].speed(),
            ));
        }
        lines.push(format!(
            "(events of one pixel and sign match within {} ms, in the last column within {} ms; bits are those of address words)",
            WITHIN.0 / 1000,
            WIDE.0 / 1000
        ));
        let dropped: u64 = self.said.iter().map(|packet| packet.dropped.total()).sum();
        if dropped > 0 {
            lines.push(format!(
                "({dropped} events of the arrays found no readout slot)"
            ));
        }
        lines.push(String::new());
        lines.extend(
            self.written
                .iter()
                .map(|path| format!("wrote {}", path.display())),
        );
        lines.push(String::new());
        lines.push(format!(
            "verbs: {}; amacrine help says what each does",
            super::verbs()
        ));
        lines.join("\n") + "\n"
    }

    fn json(&self) -> serde_json::Value {
        let devices = self.said.iter().zip(self.scores).zip(self.chips);
        let devices = devices.map(|((packet, [score, wide]), chip)| {
            json!({
                "domain": chip.name(),
                "events": packet.events.len(),
                "events_per_pixel_per_second": self.per_pixel_second(packet),
                "bits": address::bits(packet),
                "dropped": packet.dropped.total(),
                "precision": score.precision,
                "recall": score.recall,
                "f1": score.f1,
                "f1_within_20ms": wide.f1,
                "emulated_frames_per_s": chip.speed(),
            })
        });
        json!({
            "scene": "bundled",
            "width": self.truth.size.width,
            "height": self.truth.size.height,
            "frames": self.frames(),
            "inserted": self.scene.inserted(),
            "seconds": self.seconds(),
            "within_us": WITHIN.0,
            "words_per_frame": self.cost.words.0,
            "us_per_frame": self.cost.micros(),
            "frames_per_s": self.frame_rate(),
            "reference": {
                "events": self.truth.events.len(),
                "events_per_pixel_per_second": self.per_pixel_second(self.truth),
                "bits": address::bits(self.truth),
                "emulated_frames_per_s": self.reference.speed(),
            },
            "devices": devices.collect::<Vec<_>>(),
            "written": self.written,
            "light": light::json(self.observation),
            "warnings": self.warnings,
        })
    }
}
