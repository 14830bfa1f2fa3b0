//! Reading a task file.

use std::path::Path;

use amacrine::{
    config::{Fault, Faults, Read, Section, line_column, suggestion_or},
    photoreceptor::{Curve, Response},
};

use crate::{arm, levels, scene::Motion};

use super::{
    Distance, Goal, Origin, Scenes, Sensors, Task,
    keys::{
        FILE, GOALS, LOSSES, NETWORK, PRICE, RATES, RETRAIN, SCENES, SENSOR, SPARSITY, TASK, TEST,
    },
};

/// A task file that cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum TaskError {
    /// It cannot be read.
    #[error("{file}: {cause}")]
    #[diagnostic(help(
        "give the path of a task file; `amacrine-learn new NAME` writes one to start from"
    ))]
    Unreadable {
        /// Its path.
        file: String,
        /// Why not.
        cause: std::io::Error,
    },
    /// Not TOML, or not the keys and values of a task.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Wrong(#[from] Faults),
}

/// A table that may be left out: all of its keys then have what holds without them.
fn part<T>(
    task: &Section<'_>,
    key: &str,
    read: impl FnOnce(Option<Section<'_>>) -> Read<T>,
) -> Read<T> {
    read(task.table(key))
}

fn number(section: Option<Section<'_>>, key: &str, otherwise: f64) -> Read<f64> {
    section.map_or(Ok(otherwise), |section| section.number(key))
}

fn whole(section: Option<Section<'_>>, key: &str, otherwise: u64) -> Read<u64> {
    section.map_or(Ok(otherwise), |section| section.whole(key))
}

impl Task {
    /// The task of a file; its folders and its video are relative to it.
    ///
    /// # Errors
    /// When it cannot be read, or is not a task.
    pub fn open(path: &Path) -> Result<Self, TaskError> {
        Self::open_with_text(path).map(|(task, _)| task)
    }

    /// The same, and its text as it stands in the file.
    ///
    /// # Errors
    /// As [`Task::open`].
    pub fn open_with_text(path: &Path) -> Result<(Self, String), TaskError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path);
        let text = text.map_err(|cause| TaskError::Unreadable {
            file: file.clone(),
            cause,
        })?;
        let mut task = Self::parse(&file, &text)?;
        let beside = path.parent().unwrap_or(Path::new(""));
        if let Some(folder) = &mut task.scenes.photographs {
            *folder = beside.join(&*folder);
        }
        if let Some(video) = &mut task.scenes.video
            && !video.starts_with("pattern:")
            && (video != "bundled" || beside.join("bundled").exists())
        {
            *video = beside.join(&*video).to_string_lossy().into_owned();
        }
        Ok((task, text))
    }

    /// The task of a text; `file` is told in messages.
    ///
    /// # Errors
    /// When it is not a task.
    pub fn parse(file: &str, text: &str) -> Result<Self, Faults> {
        let stem = Path::new(file).file_stem().unwrap_or_default();
        FILE.read(file, text, |root| {
            let section = Section::new(root, &TASK);
            let mut task = read(&section, &stem.to_string_lossy())?;
            task.origin = origin(&section, (file, text));
            Ok(task)
        })
    }
}

/// The file, and the lines of the keys that errors are about later on.
fn origin(task: &Section<'_>, (file, text): (&str, &str)) -> Origin {
    let mut lines = Vec::new();
    let mut take = |section: Option<Section<'_>>, key| {
        if let Some(node) = section.and_then(|section| section.get(key)) {
            lines.push((key, line_column(text, node.place().start).0));
        }
    };
    for key in ["targets", "arms", "crop", "rates"] {
        take(Some(*task), key);
    }
    for key in ["photographs", "video"] {
        take(task.table("scenes"), key);
    }
    Origin {
        file: file.to_owned(),
        lines,
    }
}

fn read(task: &Section<'_>, stem: &str) -> Read<Task> {
    let goal = task.word("goal", &[Goal::Interpolation, Goal::Flow])?;
    debug_assert_eq!(GOALS.len(), 2);
    let goal = goal.unwrap_or(Goal::Interpolation);
    let loss = task.word("loss", &[Distance::Charbonnier, Distance::Absolute])?;
    debug_assert_eq!(LOSSES.len(), 2);
    let loss = loss.unwrap_or(match goal {
        Goal::Interpolation => Distance::Charbonnier,
        Goal::Flow => Distance::Absolute,
    });
    let (widths, convolutions) = part(task, "network", |network| {
        debug_assert!(NETWORK.key("widths").is_some());
        let widths: Vec<usize> = network.map_or_else(Vec::new, |network| {
            let list = network.list("widths").into_iter();
            list.filter_map(|width| Some(width.as_whole()? as usize))
                .collect()
        });
        let widths = if widths.is_empty() {
            vec![16, 24, 32]
        } else {
            widths
        };
        Ok((widths, whole(network, "convolutions", 2)? as usize))
    })?;
    let multiple = 1usize << (widths.len() - 1);
    let crop = sides(task, "crop", multiple, task.whole("crop")?)?;
    let scenes = part(task, "scenes", |scenes| scenes_of(task, scenes, goal))?;
    let sensor = part(task, "sensor", |sensor| sensor_of(task, sensor, &scenes))?;
    let test = part(task, "test", |test| {
        debug_assert!(TEST.key("clips").is_some());
        let crop = whole(test, "crop", 48)?;
        let place = test.as_ref().unwrap_or(task);
        let key = if test.is_some() { "crop" } else { "goal" };
        Ok((
            whole(test, "clips", 128)?,
            sides(place, key, multiple, crop)?,
        ))
    })?;
    let rates = part(task, "rates", |rates| {
        debug_assert!(RATES.key("kernel").is_some());
        Ok((
            number(rates, "network", 1e-3)?,
            number(rates, "kernel", 3e-3)?,
        ))
    })?;
    let sparsity = part(task, "sparsity", |sparsity| {
        debug_assert!(SPARSITY.key("weight").is_some());
        sparsity
            .map(|sparsity| sparsity.number("weight"))
            .transpose()
    })?;
    let price = part(task, "price", |price| {
        debug_assert!(PRICE.key("words").is_some());
        Ok([
            number(price, "words", 0.0)?,
            number(price, "survival", 0.0)?,
        ])
    })?;
    let retrain = part(task, "retrain", |retrain| {
        debug_assert!(RETRAIN.key("steps").is_some());
        let read = |retrain: Section<'_>| Ok((retrain.whole("steps")?, retrain.whole("clips")?));
        retrain.map(read).transpose()
    })?;
    let targets = targets(task, cells(test, scenes.frames))?;
    Ok(Task {
        name: task.maybe_text("name").unwrap_or_else(|| stem.to_owned()),
        goal,
        loss,
        steps: task.whole("steps")?,
        batch: task.whole("batch")? as usize,
        crop,
        targets,
        seeds: seeds(task)?,
        arms: arms(task, goal)?,
        widths,
        convolutions,
        rates,
        sparsity,
        scenes,
        sensor,
        chip: Some(task.text("chip")?.to_owned()).filter(|chip| chip != "none"),
        price,
        test,
        retrain,
        checkpoint: task.whole("checkpoint")?,
        origin: Origin::default(),
    })
}

/// Who takes part.
fn arms(task: &Section<'_>, goal: Goal) -> Read<Vec<arm::Arm>> {
    let mut arms: Vec<arm::Arm> = Vec::new();
    for node in task.list("arms") {
        let word = node.as_text().unwrap_or_default();
        let Some(arm) = arm::named(word) else {
            let message = format!("`arms` cannot be \"{word}\"");
            let near = suggestion_or(word, arm::NAMES.iter().copied(), "here");
            return Err(Fault::error(node.place(), message, near).help(format!(
                "the arms are {}; others are named by the few values of their weights: {}",
                arm::NAMES.join(", "),
                levels::KNOWN
            )));
        };
        if arms.iter().any(|other| other.name == arm.name) {
            let message = format!("the arm `{word}` takes part twice");
            return Err(Fault::error(node.place(), message, "remove one"));
        }
        if goal == Goal::Flow && arm.kinds() == 0 {
            let message =
                format!("the arm `{word}` has no events, and flow is told from events alone");
            return Err(Fault::error(node.place(), message, "remove it"));
        }
        let begun = { arm.cells() }.map(|cells| arm::Shape::new(cells, 0).apply(true));
        if let Some(Err(cause)) = begun {
            let message = format!("the arm `{word}` cannot begin with a point: {cause}");
            return Err(Fault::error(node.place(), message, "remove it")
                .help("take more levels, or leave the sum or the symmetry free"));
        }
        arms.push(arm);
    }
    Ok(arms)
}

/// Each once: a job is known by its arm, target and seed.
fn seeds(task: &Section<'_>) -> Read<Vec<u64>> {
    let mut seeds = Vec::new();
    for node in task.list("seeds") {
        let Some(seed) = node.as_whole() else {
            continue;
        };
        if seeds.contains(&seed) {
            let message = format!("the seed {seed} takes part twice");
            return Err(Fault::error(node.place(), message, "remove one"));
        }
        seeds.push(seed);
    }
    Ok(seeds)
}

/// Pixels times pairs of frames of all held-out clips.
fn cells((clips, crop): (u64, usize), frames: usize) -> f64 {
    clips as f64 * (crop * crop) as f64 * (frames - 1) as f64
}

/// Events a pixel and pair of frames.
fn targets(task: &Section<'_>, cells: f64) -> Read<Vec<f64>> {
    let mut targets: Vec<f64> = Vec::new();
    for node in task.list("targets") {
        let target = node.as_number().unwrap_or(f64::NAN);
        if !(target > 0.0 && target <= 1.0) {
            let message = format!("a target of {target} events a pixel and pair of frames");
            return Err(Fault::error(node.place(), message, "above 0 and at most 1")
                .help("at more than one event a pixel and pair frames are cheaper than events"));
        }
        if target * cells < 1.0 {
            let message = format!(
                "a target of {target} events a pixel and pair of frames is less than one event in all held-out clips"
            );
            return Err(Fault::error(node.place(), message, "here").help(format!(
                "give at least {:.1e}, or more clips or a larger `crop` in [test]",
                1.0 / cells
            )));
        }
        if targets.contains(&target) {
            let message = format!("the target {target} takes part twice");
            return Err(Fault::error(node.place(), message, "remove one"));
        }
        targets.push(target);
    }
    Ok(targets)
}

/// A side that all levels of the network halve evenly.
fn sides(section: &Section<'_>, key: &str, multiple: usize, side: u64) -> Read<usize> {
    let side = side as usize;
    if side.is_multiple_of(multiple) {
        return Ok(side);
    }
    let message = format!("a crop of {side} is not a multiple of {multiple}");
    Err(Fault::error(section.place_of(key), message, "here")
        .help("each level of the network halves the side of the one before"))
}

fn scenes_of(task: &Section<'_>, scenes: Option<Section<'_>>, goal: Goal) -> Read<Scenes> {
    debug_assert!(SCENES.key("frames").is_some());
    let frames = whole(scenes, "frames", 9)? as usize;
    let place = |key: &str| scenes.map_or_else(|| task.place(), |scenes| scenes.place_of(key));
    if frames.is_multiple_of(2) {
        let message = format!("a clip of {frames} frames has none in the middle");
        return Err(Fault::error(place("frames"), message, "give an odd number"));
    }
    let text = |key: &str| scenes.and_then(|scenes| scenes.maybe_text(key));
    let video = text("video");
    if video.is_some() && (goal == Goal::Flow || text("photographs").is_some()) {
        let message = "a video has no known flow, and stands in place of photographs";
        return Err(Fault::error(place("video"), message, "here").help(
            "give either `photographs` or `video`, and `video` with goal = \"interpolation\" only",
        ));
    }
    Ok(Scenes {
        photographs: text("photographs").map(Into::into),
        video,
        clips: whole(scenes, "clips", 8192)?,
        frames,
        fps: number(scenes, "fps", 240.0)?,
        motion: motion_of(task, scenes)?,
    })
}

fn motion_of(task: &Section<'_>, scenes: Option<Section<'_>>) -> Read<Motion> {
    let usual = Motion::default();
    let (pan, crop) = (number(scenes, "pan", usual.pan[1])?, task.whole("crop")?);
    if pan > crop as f64 {
        let place = scenes.map_or_else(|| task.place(), |scenes| scenes.place_of("pan"));
        let message = format!(
            "a picture that moves by {pan} px in a frame leaves a crop of {crop} px between two frames"
        );
        return Err(Fault::error(place, message, "here").help(format!("give at most {crop}")));
    }
    Ok(Motion {
        pan: [usual.pan[0], pan],
        turn: number(scenes, "turn", usual.turn)?,
        zoom: number(scenes, "zoom", usual.zoom)?,
        shear: number(scenes, "shear", usual.shear)?,
        occluder: number(scenes, "occluded", usual.occluder)?,
        gain: bounds(scenes, "gain", usual.gain)?,
        gamma: bounds(scenes, "gamma", usual.gamma)?,
    })
}

/// The least and the most of something.
fn bounds(scenes: Option<Section<'_>>, key: &str, otherwise: [f64; 2]) -> Read<[f64; 2]> {
    let Some(scenes) = scenes.filter(|scenes| scenes.get(key).is_some()) else {
        return Ok(otherwise);
    };
    let all: Vec<f64> = { scenes.list(key).into_iter() }
        .filter_map(amacrine::config::Node::as_number)
        .collect();
    match all[..] {
        [least, most] if least <= most => Ok([least, most]),
        _ => {
            let message = format!("`{key}` is the least and the most, in this order");
            Err(Fault::error(scenes.place_of(key), message, "here"))
        }
    }
}

fn sensor_of(task: &Section<'_>, sensor: Option<Section<'_>>, scenes: &Scenes) -> Read<Sensors> {
    debug_assert!(SENSOR.key("mismatch").is_some());
    let linear = Response::new(Curve::Linear { white: 255.0 });
    let response = sensor.and_then(|sensor| sensor.get("response"));
    let refractory_us = number(sensor, "refractory-us", 0.0)?;
    let pair = 1e6 / scenes.fps;
    if refractory_us > pair {
        let place = sensor.map_or_else(|| task.place(), |s| s.place_of("refractory-us"));
        let message = format!(
            "a refractory period of {refractory_us} us is longer than a pair of frames, {pair:.0} us"
        );
        return Err(Fault::error(place, message, "here")
            .help("a cell would miss whole pairs: shorten it, or lower `fps`"));
    }
    Ok(Sensors {
        response: response.map_or(Ok(linear), Response::read)?,
        refractory_us,
        light_noise: number(sensor, "light-noise", 0.5)?,
        mismatch: number(sensor, "mismatch", 0.1)?,
    })
}
