//! A sensor that watches a clip, part by part.

use std::{
    collections::BTreeMap,
    sync::{Mutex, PoisonError},
    time::Instant,
};

use amacrine::{
    event::{Dropped, Packet},
    plane::{Plane, Size},
    reference::Limit,
    rig::guard::Warning,
    scene::{Frame, Levels, Observation, Samples, check_rate, upsample},
    sensor::SensorError,
    study::run_guard::{Done, RunGuard},
    unit::Micros,
};
use miette::Report;
use numpy::{PyArray1, PyReadwriteArray1};
use pyo3::prelude::*;

use crate::{
    error::{raised, refused},
    frames::{Borrowed, Frames},
    options::in_python,
    pool::{self, LOOK},
    readout, record,
    source::{Source, outline},
    stop::Halt,
    tensor::{Stream, arrays},
    watcher::Watcher,
};

/// A sensor that watches a clip, part by part; times go on from part to part. One thread at a time may
/// show it frames, of which its caller takes care.
#[pyclass(frozen, module = "amacrine._amacrine")]
pub struct Run {
    watch: Mutex<Watch>,
}

struct Watch {
    watcher: Box<dyn Watcher>,
    fps: f64,
    scale: f64,
    frame: Frame,
    /// Frames seen.
    seen: u64,
    packet: Packet,
    made: usize,
    most: usize,
    guard: RunGuard,
    /// What was seen of the scene: the extent of its light, its cuts, and frames that repeat.
    observation: Observation,
    /// What codes of 8 bits stand for.
    levels: Levels,
    /// Whether frames were begun and did not come to their end: what cells hold is then not known.
    is_stopped: bool,
    /// What ends it with others.
    halt: Halt,
}

impl Run {
    pub fn new(
        watcher: Box<dyn Watcher>,
        (size, channels): (Size, u8),
        guard: RunGuard,
        fps: f64,
        scale: f64,
        most: Option<usize>,
    ) -> PyResult<Self> {
        check_rate(fps).map_err(raised)?;
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(refused(
                format!("scale = {scale}: no scale"),
                "give a number above 0, such as 255 for light from 0 to 1",
            ));
        }
        let watch = Mutex::new(Watch {
            watcher,
            fps,
            scale,
            frame: Frame {
                index: 0,
                seconds: 0.0,
                light: Plane::zeros(size.shape()).into(),
            },
            seen: 0,
            packet: Packet::new(size, channels),
            made: 0,
            most: most.unwrap_or(Limit::default().events),
            guard,
            observation: Observation::new(),
            levels: Levels::bytes().map(|code| code * scale),
            is_stopped: false,
            halt: Halt::default(),
        });
        Ok(Self { watch })
    }

    fn with<T>(&self, what: impl FnOnce(&mut Watch) -> T) -> T {
        what(&mut self.watch.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Takes frames, all of them or no more at all: whatever ends it early, the frames that were seen
    /// are lost, and nothing more may follow them.
    fn whole(&self, take: impl FnOnce() -> PyResult<()>) -> PyResult<()> {
        self.with(|watch| {
            if watch.is_stopped {
                return Err(refused(
                    format!("the stream stopped at frame {}", watch.seen),
                    "begin a new stream, with frames that the sensor takes",
                ));
            }
            watch.is_stopped = true;
            Ok(())
        })?;
        take()?;
        self.with(|watch| watch.is_stopped = false);
        Ok(())
    }

    /// Gives the frames to `see` with the watch; between two of them, after each that takes long,
    /// the interpreter may break off.
    fn play(
        &self,
        py: Python<'_>,
        frames: &Bound<'_, PyAny>,
        mut see: impl FnMut(&mut Watch, usize) -> Result<(), SensorError> + Send,
    ) -> PyResult<()> {
        let borrowed = Borrowed::new(frames)?;
        let (count, height, width) = borrowed.shape();
        let got = Size::new(height, width);
        let (want, index) = self.with(|watch| (watch.packet.size, watch.seen));
        if got != want {
            return Err(raised(SensorError::Size { index, got, want }));
        }
        let frames = borrowed.frames()?;
        self.whole(|| {
            self.with(|watch| watch.begin(frames.samples()));
            let mut rest = 0..count;
            while !rest.is_empty() {
                let (see, rest) = (&mut see, &mut rest);
                let seen = pool::work(py, || {
                    let since = Instant::now();
                    self.with(|watch| {
                        for n in rest {
                            watch.unless_halted()?;
                            watch.take(frames, n);
                            see(watch, n)?;
                            watch.seen += 1;
                            if since.elapsed() >= LOOK {
                                break;
                            }
                        }
                        Ok(())
                    })
                })?;
                seen.map_err(|error: SensorError| raised(error))?;
                py.check_signals()?;
            }
            Ok(())
        })
    }

    /// The same with frames put in between those of a whole clip, so that no pixel changes by more than
    /// a contrast from one to the next. `see` is told of which frame of the clip it is, or before
    /// which one it is put.
    fn play_between(
        &self,
        py: Python<'_>,
        frames: &Bound<'_, PyAny>,
        contrast: f64,
        mut see: impl FnMut(&mut Watch, usize) -> Result<(), SensorError> + Send,
    ) -> PyResult<()> {
        let (fps, scale) = self.with(|watch| (watch.fps, watch.scale));
        let source = Source::new(None, Some(frames), Some(fps), Some(scale))?;
        self.whole(|| {
            self.with(|watch| watch.observation = source.observation().clone());
            let seen = source.work(py, || {
                let mut scene = upsample::by_contrast(source.open()?, Some(contrast))?;
                let mut n = 0;
                self.with(|watch| {
                    while let Some(frame) = scene.next_frame()? {
                        watch.unless_halted()?;
                        let is_own = frame.seconds >= n as f64 / fps;
                        watch.frame = frame;
                        see(watch, n)?;
                        watch.seen += 1;
                        n += usize::from(is_own);
                    }
                    Ok::<_, Report>(())
                })
            })?;
            seen.map_err(raised)
        })
    }

    /// Plays with frames put in where that is asked.
    fn play_with(
        &self,
        py: Python<'_>,
        frames: &Bound<'_, PyAny>,
        contrast: Option<f64>,
        see: impl FnMut(&mut Watch, usize) -> Result<(), SensorError> + Send,
    ) -> PyResult<()> {
        match contrast {
            Some(contrast) => self.play_between(py, frames, contrast, see),
            None => self.play(py, frames, see),
        }
    }
}

impl Watch {
    /// Ends a run that was told to; who told it says why.
    fn unless_halted(&self) -> Result<(), SensorError> {
        if !self.halt.is_asked() {
            return Ok(());
        }
        Err(SensorError::Stopped {
            sensor: "the run".to_owned(),
            why: "another of its clips has ended them all".to_owned(),
        })
    }

    /// Frames of such numbers follow.
    fn begin(&self, samples: Samples) {
        let frames = (0, self.packet.size);
        self.observation.begin(&outline(samples, frames, self.fps));
    }

    /// Frame `n` of an array becomes the next one.
    fn take(&mut self, frames: Frames<'_>, n: usize) {
        self.frame.index = self.seen;
        self.frame.seconds = self.seen as f64 / self.fps;
        frames.show(n, (self.scale, &self.levels), &mut self.frame.light);
        self.observation.see(&self.frame);
    }

    /// So many cells fired since the frame before.
    fn see(&mut self, firing: u64) {
        self.guard.see(&self.frame, firing);
    }

    /// What happened since the frame before, in `packet`.
    fn watch(&mut self) -> Result<(), SensorError> {
        self.packet.events.clear();
        let firing = self.watcher.events(&self.frame, &mut self.packet)?;
        self.see(firing);
        self.made = self.made.saturating_add(self.packet.events.len());
        if self.made > self.most {
            return Err(SensorError::ListFull { limit: self.most });
        }
        Ok(())
    }
}

#[pymethods]
impl Run {
    /// The events of these frames, as the bytes of their records: with frames put in for a contrast,
    /// and as a readout delivers them, where these are asked for.
    fn events<'py>(
        &self,
        py: Python<'py>,
        frames: &Bound<'py, PyAny>,
        contrast: Option<f64>,
        readout: Option<readout::Asked>,
    ) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let Some(readout) = readout.map(readout::open).transpose()? else {
            let mut bytes = Vec::new();
            self.play_with(py, frames, contrast, |watch, _| {
                watch.watch()?;
                record::append(&watch.packet.events, watch.packet.channels, &mut bytes);
                Ok(())
            })?;
            return Ok(PyArray1::from_vec(py, bytes));
        };
        // A readout wants the whole packet.
        let mut events = Vec::new();
        self.play_with(py, frames, contrast, |watch, _| {
            watch.watch()?;
            events.append(&mut watch.packet.events);
            Ok(())
        })?;
        let bytes = pool::work(py, || {
            self.with(|watch| {
                watch.packet.events = events;
                let last = Micros::from_seconds(watch.frame.seconds);
                watch.packet.span = (Micros(0), last);
                watch.packet = readout.read(&watch.packet).packet;
                watch.made = watch.packet.events.len();
                let mut bytes = Vec::new();
                record::append(&watch.packet.events, watch.packet.channels, &mut bytes);
                bytes
            })
        })?;
        Ok(PyArray1::from_vec(py, bytes))
    }

    /// Fills `out`, `(T - 1, K, H, W)`, or `(T, K, H, W)` where frames were seen before; with frames put
    /// in, what happened between two of the clip's own is added up.
    fn counts(
        &self,
        py: Python<'_>,
        frames: &Bound<'_, PyAny>,
        contrast: Option<f64>,
        mut out: PyReadwriteArray1<'_, i32>,
    ) -> PyResult<()> {
        let out = out.as_slice_mut().map_err(|_| scattered())?;
        let each = self.with(|watch| watch.cells());
        let begun = self.with(|watch| watch.seen > 0);
        let mut own = vec![0; each];
        self.play_with(py, frames, contrast, |watch, n| {
            let place = if begun { Some(n) } else { n.checked_sub(1) };
            let place = match place {
                Some(n) => Some(out.get_mut(n * each..(n + 1) * each).ok_or_else(no_room)?),
                None => None,
            };
            let Watch { watcher, frame, .. } = watch;
            let firing = watcher.counts(frame, &mut own)?;
            for (sum, own) in place.into_iter().flatten().zip(&own) {
                *sum += own;
            }
            watch.see(firing);
            Ok(())
        })
    }

    /// Fills `out`, `(T, K, H, W)`: a bin for each frame of a whole clip.
    fn voxels(
        &self,
        py: Python<'_>,
        frames: &Bound<'_, PyAny>,
        mut out: PyReadwriteArray1<'_, f32>,
    ) -> PyResult<()> {
        let out = out.as_slice_mut().map_err(|_| scattered())?;
        let each = self.with(|watch| watch.cells());
        let mut none = vec![0.0; each];
        self.play(py, frames, |watch, n| {
            let place = n.checked_sub(1);
            let place = place.and_then(|n| out.get_mut(n * each..(n + 1) * each));
            let Watch { watcher, frame, .. } = watch;
            let firing = watcher.voxels(frame, place.unwrap_or(&mut none))?;
            watch.see(firing);
            Ok(())
        })?;
        if let Some(last) = out.len().checked_sub(each) {
            self.with(|watch| watch.watcher.last_voxels(&mut out[last..]));
        }
        Ok(())
    }

    /// The windows that these frames end, each `[channel][side][bin][y, x]`.
    fn windows<'py>(
        &self,
        py: Python<'py>,
        frames: &Bound<'py, PyAny>,
        contrast: Option<f64>,
        stream: &Bound<'py, Stream>,
    ) -> PyResult<Vec<Bound<'py, PyArray1<f32>>>> {
        let stream = stream.get();
        let mut over = Vec::new();
        self.play_with(py, frames, contrast, |watch, _| {
            watch.watch()?;
            // Right behind a frame there may be events of the same microsecond.
            let now = Micros::from_seconds(watch.frame.seconds).0;
            let now = Micros(now.saturating_sub(1));
            stream.with(|stream| {
                stream
                    .add(&watch.packet.events)
                    .map_err(|error| SensorError::Stopped {
                        sensor: "the stream of voxels".to_owned(),
                        why: error.to_string(),
                    })?;
                over.append(&mut stream.finished(now));
                Ok(())
            })
        })?;
        Ok(arrays(py, over))
    }

    /// It ends at the next frame once this is asked.
    fn heed(&self, halt: &Halt) {
        self.with(|watch| watch.halt = halt.clone());
    }

    /// Frames seen.
    #[getter]
    fn seen(&self) -> u64 {
        self.with(|watch| watch.seen)
    }

    /// What there is to warn of in all frames so far: what each is about, and its words.
    fn warnings(&self, subject: &str) -> Vec<(&'static str, String)> {
        let all = self.with(|watch| watch.warnings(subject));
        all.into_iter()
            .map(|warning| (warning.about.word(), in_python(&warning.to_string())))
            .collect()
    }

    /// Events that found no place so far, by reason.
    #[getter]
    fn dropped(&self) -> BTreeMap<&'static str, u64> {
        by_reason(self.with(|watch| watch.packet.dropped))
    }
}

/// Events that found no place, by reason.
pub fn by_reason(dropped: Dropped) -> BTreeMap<&'static str, u64> {
    [
        ("no_slot", dropped.no_slot),
        ("over_limit", dropped.over_limit),
        ("queue_full", dropped.queue_full),
        ("merged", dropped.merged),
        ("unscanned", dropped.unscanned),
    ]
    .into()
}

impl Watch {
    /// As `amacrine run` warns.
    fn warnings(&self, subject: &str) -> Vec<Warning> {
        let mut warnings = Warning::of_scene(&self.observation, self.guard.response());
        let done = Done {
            kinds: self.watcher.kinds(),
            kept: self.made as u64,
            dropped: self.packet.dropped,
            silence: self.watcher.silence(),
            overflowed: self.watcher.overflowed(),
        };
        warnings.extend(self.guard.warnings(subject, &done));
        warnings
    }

    /// Cells of all kinds.
    fn cells(&self) -> usize {
        self.packet.size.pixels() * usize::from(self.packet.channels)
    }
}

fn no_room() -> SensorError {
    SensorError::Stopped {
        sensor: "the stream".to_owned(),
        why: "the output has no room for the counts of all these frames".to_owned(),
    }
}

fn scattered() -> PyErr {
    refused("the output does not lie row by row", "give a new array")
}
