//! A sensor that watches a clip, part by part.

use std::sync::{Mutex, PoisonError};

use amacrine::{
    event::{Packet, Polarity},
    plane::{Plane, Size},
    reference::Limit,
    scene::Frame,
    sensor::SensorError,
};
use numpy::{PyArray1, PyReadwriteArray1};
use pyo3::prelude::*;

use crate::{
    error::{raised, refused},
    frames::{Borrowed, Frames},
    pool, record,
    watcher::Watcher,
};

/// Frames between two looks at whether the person wants to stop.
const PART: usize = 16;

/// A sensor that watches a clip, part by part; times go on from part to part.
#[pyclass(frozen, module = "amacrine._amacrine")]
pub struct Run(Mutex<Watch>);

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
}

/// Windows of time, each in bins.
#[derive(Clone, Copy)]
struct Windows {
    /// Length of a window, in seconds.
    length: f64,
    bins: usize,
    /// OFF and ON in bins of their own.
    apart: bool,
    /// Where it all begins, in seconds.
    start: f64,
}

impl Run {
    pub fn new(
        watcher: Box<dyn Watcher>,
        (size, channels): (Size, u8),
        fps: f64,
        scale: f64,
        most: Option<usize>,
    ) -> PyResult<Self> {
        if !(fps > 0.0 && fps.is_finite()) {
            return Err(refused(
                format!("{fps} frames a second is no rate"),
                "give a number above 0, in frames/s",
            ));
        }
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(refused(
                format!("scale = {scale}: no scale"),
                "give a number above 0, such as 255 for light from 0 to 1",
            ));
        }
        Ok(Self(Mutex::new(Watch {
            watcher,
            fps,
            scale,
            frame: Frame {
                index: 0,
                seconds: 0.0,
                light: Plane::zeros(size.shape()),
            },
            seen: 0,
            packet: Packet::new(size, channels),
            made: 0,
            most: most.unwrap_or(Limit::default().events),
        })))
    }

    fn with<T>(&self, what: impl FnOnce(&mut Watch) -> T) -> T {
        what(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Gives the frames to `see` with the watch, some at a time; in between the interpreter may
    /// break off.
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
        for from in (0..count).step_by(PART) {
            let part = from..(from + PART).min(count);
            let see = &mut see;
            let seen = pool::work(py, || {
                self.with(|watch| {
                    part.into_iter().try_for_each(|n| {
                        watch.take(frames, n);
                        see(watch, n)?;
                        watch.seen += 1;
                        Ok(())
                    })
                })
            })?;
            seen.map_err(|error: SensorError| raised(error))?;
            py.check_signals()?;
        }
        Ok(())
    }
}

impl Watch {
    /// Frame `n` of an array becomes the next one.
    fn take(&mut self, frames: Frames<'_>, n: usize) {
        self.frame.index = self.seen;
        self.frame.seconds = self.seen as f64 / self.fps;
        if let Some(light) = self.frame.light.as_slice_mut() {
            frames.light(n, self.scale, light);
        }
    }

    /// What happened since the frame before, in `packet`.
    fn watch(&mut self) -> Result<(), SensorError> {
        self.packet.events.clear();
        self.watcher.events(&self.frame, &mut self.packet)?;
        self.made = self.made.saturating_add(self.packet.events.len());
        if self.made > self.most {
            return Err(SensorError::ListFull { limit: self.most });
        }
        Ok(())
    }

    /// Shares the events of the frame out to the bins.
    fn share(&self, windows: Windows, out: &mut [f32]) {
        let Size { height, width } = self.packet.size;
        let pixels = height * width;
        let signs = 1 + usize::from(windows.apart);
        let each = usize::from(self.packet.channels) * signs * windows.bins * pixels;
        let last = (out.len() / each.max(1)).saturating_sub(1);
        let steps = windows.bins.saturating_sub(1) as f64;
        for event in &self.packet.events {
            let since = (event.t.seconds() - windows.start) / windows.length;
            let window = (since as usize).min(last);
            let at = ((since - window as f64) * steps).clamp(0.0, steps);
            let (bin, after) = (at as usize, at.fract() as f32);
            let is_on = event.polarity == Polarity::On;
            let sign = if is_on || windows.apart { 1.0 } else { -1.0 };
            let plane = usize::from(event.channel) * signs + usize::from(is_on && windows.apart);
            let pixel = usize::from(event.y) * width + usize::from(event.x);
            let first = window * each + (plane * windows.bins + bin) * pixels + pixel;
            if let Some(voxel) = out.get_mut(first) {
                *voxel += sign * (1.0 - after);
            }
            // The last bin has none after it, and gives it nothing.
            if after > 0.0
                && let Some(voxel) = out.get_mut(first + pixels)
            {
                *voxel += sign * after;
            }
        }
    }
}

#[pymethods]
impl Run {
    /// The events of these frames, as the bytes of their records.
    fn events<'py>(
        &self,
        py: Python<'py>,
        frames: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let mut bytes = Vec::new();
        self.play(py, frames, |watch, _| {
            watch.watch()?;
            record::append(&watch.packet.events, watch.packet.channels, &mut bytes);
            Ok(())
        })?;
        Ok(PyArray1::from_vec(py, bytes))
    }

    /// Fills `out`, `(T - 1, K, H, W)`, or `(T, K, H, W)` where frames were seen before.
    fn counts(
        &self,
        py: Python<'_>,
        frames: &Bound<'_, PyAny>,
        mut out: PyReadwriteArray1<'_, i32>,
    ) -> PyResult<()> {
        let out = out.as_slice_mut().map_err(|_| scattered())?;
        let each = self.with(|watch| watch.cells());
        let begun = self.with(|watch| watch.seen > 0);
        let mut none = vec![0; each];
        self.play(py, frames, |watch, n| {
            let place = if begun { Some(n) } else { n.checked_sub(1) };
            let place = place.and_then(|n| out.get_mut(n * each..(n + 1) * each));
            let Watch { watcher, frame, .. } = watch;
            watcher.counts(frame, place.unwrap_or(&mut none))
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
            watcher.voxels(frame, place.unwrap_or(&mut none))
        })?;
        if let Some(last) = out.len().checked_sub(each) {
            self.with(|watch| watch.watcher.last_voxels(&mut out[last..]));
        }
        Ok(())
    }

    /// Adds to `out`, `(windows, K, bins, H, W)` of windows of `length` seconds from the first of
    /// these frames on; with `apart` `(windows, K, 2, bins, H, W)`, OFF first.
    fn bins(
        &self,
        py: Python<'_>,
        frames: &Bound<'_, PyAny>,
        mut out: PyReadwriteArray1<'_, f32>,
        bins: usize,
        length: f64,
        apart: bool,
    ) -> PyResult<()> {
        let out = out.as_slice_mut().map_err(|_| scattered())?;
        let start = self.with(|watch| watch.seen as f64 / watch.fps);
        let windows = Windows {
            length,
            bins,
            apart,
            start,
        };
        self.play(py, frames, |watch, _| {
            watch.watch()?;
            watch.share(windows, out);
            Ok(())
        })
    }

    /// Frames seen.
    #[getter]
    fn seen(&self) -> u64 {
        self.with(|watch| watch.seen)
    }

    /// Events that found no slot of a readout, or were merged.
    #[getter]
    fn dropped(&self) -> u64 {
        self.with(|watch| watch.packet.dropped.total())
    }
}

impl Watch {
    /// Cells of all kinds.
    fn cells(&self) -> usize {
        self.packet.size.pixels() * usize::from(self.packet.channels)
    }
}

fn scattered() -> PyErr {
    refused("the output does not lie row by row", "give a new array")
}
