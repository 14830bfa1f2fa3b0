//! Scenes: by name, or an array that the caller gives.

use std::{
    io,
    str::FromStr,
    sync::{Arc, atomic::AtomicBool},
};

use amacrine::{
    config::UnknownWord,
    memory::Budget,
    photoreceptor::Response,
    plane::{Plane, Size},
    rig::guard::Warning,
    scene::{
        Coding, Frame, Levels, Light, Observation, Observed, OpenOptions, Outline, Samples, Scene,
        SceneError, View, bundled_with,
        kept::{Kept, Pixels},
        open, word_or_auto,
    },
    stop::Stop,
};
use miette::Report;
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use crate::{
    error::{raised, refused},
    frames::{Borrowed, Frames},
    options::{caution, in_python},
    pool,
    stop::Flag,
};

/// What scenes are watched by a study.
pub struct Source {
    of: Of,
    /// Whether the person wants to stop: scenes then end with an error.
    stop: Flag,
    /// What is seen of them.
    observation: Observation,
}

enum Of {
    /// A file, a folder, a pattern; or the bundled clip.
    Named(Option<String>, OpenOptions),
    Given(Given),
}

/// Frames that the caller gave, kept as they were.
#[derive(Clone)]
pub struct Given {
    numbers: Numbers,
    size: Size,
    frames: usize,
    fps: f64,
    scale: f64,
    /// What codes of 8 bits stand for.
    levels: Levels,
    next: usize,
}

#[derive(Clone)]
enum Numbers {
    U8(Arc<[u8]>),
    F32(Arc<[f32]>),
    F64(Arc<[f64]>),
}

impl Numbers {
    /// The same as frames.
    fn frames(&self) -> Frames<'_> {
        match self {
            Self::U8(all) => Frames::U8(all),
            Self::F32(all) => Frames::F32(all),
            Self::F64(all) => Frames::F64(all),
        }
    }
}

/// How scenes are opened.
fn options(fps: Option<f64>, coding: Coding) -> OpenOptions {
    OpenOptions {
        fps,
        memory: Some(Budget::from_machine()),
        coding,
        view: View::default(),
    }
}

/// What of a scene is asked for: a slice, a part of each picture, and a size, as the command line
/// takes them.
type Part<'a> = (Option<&'a str>, Option<&'a str>, Option<&'a str>);

fn view((slice, crop, resize): Part<'_>) -> PyResult<View> {
    fn read<T: FromStr<Err = String>>(name: &str, text: Option<&str>) -> PyResult<Option<T>> {
        let read = |text: &str| {
            let wrong = |help| refused(format!("{name} = {text:?}"), help);
            text.parse().map_err(wrong)
        };
        text.map(read).transpose()
    }
    let size = |text: &str| {
        let wrong = || {
            refused(
                format!("resize = {text:?}"),
                "give WIDTHxHEIGHT, such as 256x144",
            )
        };
        let size = Size::read(text).filter(|size| size.is_possible());
        size.ok_or_else(wrong)
    };
    Ok(View {
        slice: read("slice", slice)?,
        crop: read("crop", crop)?,
        resize: resize.map(size).transpose()?,
    })
}

impl Source {
    /// The scene of this name, or these frames.
    pub fn new(
        name: Option<String>,
        frames: Option<&Bound<'_, PyAny>>,
        fps: Option<f64>,
        scale: Option<f64>,
    ) -> PyResult<Self> {
        let Some(frames) = frames else {
            let coding = Coding {
                scale,
                ..Coding::default()
            };
            return Ok(Of::Named(name, options(fps, coding)).into());
        };
        let borrowed = Borrowed::new(frames)?;
        let (count, height, width) = borrowed.shape();
        let size = Size::new(height, width);
        if !size.is_possible() {
            return Err(refused(
                format!("frames of {size} pixels"),
                "width and height must be from 1 to 65536",
            ));
        }
        let fps = fps.filter(|fps| *fps > 0.0 && fps.is_finite());
        let fps = fps.ok_or_else(|| {
            refused(
                "the frames have no rate",
                "give fps, a number above 0, in frames/s",
            )
        })?;
        let given = Given {
            levels: Levels::bytes().map(|code| code * scale.unwrap_or(1.0)),
            numbers: match borrowed.frames()? {
                Frames::U8(all) => Numbers::U8(all.into()),
                Frames::F32(all) => Numbers::F32(all.into()),
                Frames::F64(all) => Numbers::F64(all.into()),
            },
            size,
            frames: count,
            fps,
            scale: scale.unwrap_or(1.0),
            next: 0,
        };
        Ok(Of::Given(given).into())
    }

    /// The scene from its start.
    pub fn open(&self) -> Result<Box<dyn Scene>, SceneError> {
        let stop = self.stop.stop();
        check(stop)?;
        let scene = match &self.of {
            Of::Named(Some(name), options) if name != "bundled" => open(name, options)?,
            Of::Named(_, options) => bundled_with(options)?,
            Of::Given(given) => Box::new(given.clone()),
        };
        let scene = Box::new(Observed::new(scene, &self.observation));
        Ok(Box::new(Stoppable { scene, stop }))
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        match &self.of {
            Of::Named(Some(name), _) if name != "bundled" => name,
            Of::Named(..) => "the bundled clip",
            Of::Given(_) => "the frames given",
        }
    }

    /// Does on the pool what looks at these scenes. On Ctrl-C it ends at the next frame of one.
    pub fn work<T: Send>(&self, py: Python<'_>, what: impl FnOnce() -> T + Send) -> PyResult<T> {
        let pool = pool::pool()?;
        pool::watched(py, self.stop.flag(), || pool.install(what))
    }

    /// The same for a study: of what there is to warn of in these scenes, for a sensor of this
    /// response, it warns whoever called the function of Python that called.
    pub fn study<T: Send>(
        &self,
        py: Python<'_>,
        response: Response,
        what: impl FnOnce() -> T + Send,
    ) -> PyResult<T> {
        let made = self.work(py, what)?;
        for warning in Warning::of_scene(&self.observation, response) {
            caution(py, &warning)?;
        }
        Ok(made)
    }

    /// The same for a study whose answer has these warnings: they are told with it, and here only
    /// where there is no answer.
    pub fn answer<T: Send>(
        &self,
        py: Python<'_>,
        response: Response,
        what: impl FnOnce() -> Result<T, Report> + Send,
    ) -> PyResult<T> {
        self.work(py, what)?.or_else(|report| {
            for warning in Warning::of_scene(&self.observation, response) {
                caution(py, &warning)?;
            }
            Err(raised(report))
        })
    }

    /// What was seen of them.
    pub const fn observation(&self) -> &Observation {
        &self.observation
    }

    /// What is set once the person wants to stop.
    pub const fn flag(&self) -> &'static AtomicBool {
        self.stop.flag()
    }

    /// What tells other work that the person wants to stop.
    pub const fn stop(&self) -> Stop {
        self.stop.stop()
    }
}

impl From<Of> for Source {
    fn from(of: Of) -> Self {
        Self {
            of,
            stop: Flag::new(),
            observation: Observation::new(),
        }
    }
}

/// A scene that ends with an error once the person wants to stop.
struct Stoppable {
    scene: Box<dyn Scene>,
    stop: Stop,
}

impl Scene for Stoppable {
    fn outline(&self) -> Outline {
        self.scene.outline()
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        check(self.stop)?;
        self.scene.next_frame()
    }
}

/// The error is not shown: what the signal raised is.
fn check(stop: Stop) -> Result<(), SceneError> {
    if !stop.is_asked() {
        return Ok(());
    }
    Err(SceneError::Unreadable {
        path: "the scene".into(),
        cause: io::ErrorKind::Interrupted.into(),
    })
}

/// What is known of so many frames of a size that the caller gives.
pub fn outline(samples: Samples, (frames, size): (usize, Size), fps: f64) -> Outline {
    Outline {
        frames: Some(frames as u64),
        coding: Light {
            samples,
            ..Light::DRAWN
        },
        ..Outline::new(size, fps)
    }
}

impl Scene for Given {
    fn outline(&self) -> Outline {
        let samples = self.numbers.frames().samples();
        outline(samples, (self.frames, self.size), self.fps)
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        if self.next == self.frames {
            return Ok(None);
        }
        let index = self.next as u64;
        let mut light = Plane::zeros(self.size.shape()).into();
        let frames = self.numbers.frames();
        frames.show(self.next, (self.scale, &self.levels), &mut light);
        self.next += 1;
        Ok(Some(Frame {
            index,
            seconds: index as f64 / self.fps,
            light,
        }))
    }
}

/// The most bytes of a scene that is read whole.
const MOST: usize = 8 << 30;

/// All frames of a scene, `(T, H, W)`, frames a second, whether these are assumed, and what there is to
/// warn of: `uint8` where light is whole numbers from 0 to 255, else `float64`.
#[pyfunction]
pub fn scene<'py>(
    py: Python<'py>,
    name: Option<String>,
    fps: Option<f64>,
    scale: Option<f64>,
    frames: Option<u64>,
    coded: (&str, &str),
    part: Part<'_>,
) -> PyResult<(Bound<'py, PyAny>, f64, bool, Vec<String>)> {
    let (range, transfer) = coded;
    let coding = Coding {
        range: word_or_auto(range).map_err(|e: UnknownWord| raised(e))?,
        transfer: word_or_auto(transfer).map_err(|e: UnknownWord| raised(e))?,
        scale,
    };
    let options = OpenOptions {
        view: view(part)?,
        ..options(fps, coding)
    };
    let source: Source = Of::Named(name, options).into();
    let kept = source.work(py, || {
        let scene = source.open()?;
        let is_assumed = scene.outline().fps_is_assumed;
        let mut scene = amacrine::scene::part::First::new(scene, frames.unwrap_or(u64::MAX));
        Ok::<_, SceneError>((Kept::new(&mut scene, MOST)?, is_assumed))
    })?;
    let (kept, is_assumed) = kept.map_err(raised)?;
    let kept = kept.ok_or_else(|| {
        refused(
            format!("{} is too long to be held", source.name()),
            "ask for fewer frames",
        )
    })?;
    let told = Warning::of_pictures(source.observation());
    let told = told.iter().map(|one| in_python(&one.to_string())).collect();
    let (height, width) = kept.size().shape();
    let shape = [kept.len(), height, width];
    let all = 0..kept.len();
    let whole = { all.clone() }.all(|n| matches!(kept.frame(n), Some((.., Pixels::Bytes(_)))));
    let fps = amacrine::scene::Scene::fps(&kept.scene());
    let wrong = |_| refused("the frames differ in size", "give a scene of one size");
    if whole {
        let mut bytes = Vec::with_capacity(shape.iter().product());
        for n in all {
            if let Some((.., Pixels::Bytes(row))) = kept.frame(n) {
                bytes.extend_from_slice(row);
            }
        }
        let array: Bound<'py, PyArray3<u8>> = PyArray1::from_vec(py, bytes)
            .reshape(shape)
            .map_err(wrong)?;
        return Ok((array.into_any(), fps, is_assumed, told));
    }
    let mut numbers = Vec::with_capacity(shape.iter().product());
    for n in all {
        match kept.frame(n) {
            Some((.., Pixels::Bytes(row))) => numbers.extend(row.iter().map(|b| f64::from(*b))),
            Some((.., Pixels::Numbers(row))) => numbers.extend_from_slice(row),
            None => {}
        }
    }
    let array: Bound<'py, PyArray3<f64>> = PyArray1::from_vec(py, numbers)
        .reshape(shape)
        .map_err(wrong)?;
    Ok((array.into_any(), fps, is_assumed, told))
}
