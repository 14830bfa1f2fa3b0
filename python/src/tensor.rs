//! Events as networks are fed: the doors to the library's tensors.

use std::sync::{Mutex, PoisonError};

use amacrine::{
    event::{
        Event, Packet,
        tensor::{
            self, Sides, TensorError, TimeSurface, VoxelStream, Windows, frames as frames_of,
        },
    },
    memory::{Budget, Need},
    plane::Size,
    unit::Micros,
};
use miette::{Report, miette};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::{error::raised, events::Events, files, pool};

/// How events become voxels.
#[pyclass(frozen, module = "amacrine._amacrine")]
pub struct Voxels {
    pub how: tensor::Voxels,
}

fn named<T: std::str::FromStr<Err = TensorError>>(text: &str) -> PyResult<T> {
    text.parse().map_err(raised)
}

#[pymethods]
impl Voxels {
    /// Windows of `length` seconds, one `every` so many, with so many bins.
    #[new]
    fn new(
        bins: usize,
        length: f64,
        every: f64,
        alignment: &str,
        share: &str,
        polarity: &str,
        normalise: &str,
    ) -> PyResult<Self> {
        let windows = Windows::new(length, every, named(alignment)?).map_err(raised)?;
        let mut how = tensor::Voxels::new(bins, windows).map_err(raised)?;
        how.share = named(share)?;
        how.sides = named(polarity)?;
        how.normalise = named(normalise)?;
        Ok(Self { how })
    }

    /// How many windows it takes for what ends at `end`, in microseconds.
    fn count(&self, end: u64) -> u64 {
        self.how.windows.count(Micros(end))
    }

    /// Bytes of the windows of a clip that are held at once beside those that are done with, of so
    /// many windows, when it comes in parts of so many seconds.
    fn held(&self, size: (usize, usize), channels: u8, windows: u64, part: f64) -> u64 {
        let of = self.how.windows;
        let ((from, to), (_, next)) = (of.bounds(1), of.bounds(2));
        let every = next.saturating_sub(to).max(1);
        let reach = to.saturating_sub(from).saturating_add((part * 1e6) as i64);
        let at_once = (reach / every).saturating_add(2) as u64;
        let each = self.how.held(Size::new(size.0, size.1), channels, 1);
        let bytes = each.saturating_mul(at_once.min(windows).into());
        u64::try_from(bytes).unwrap_or(u64::MAX)
    }

    /// Start and end of window `n`, in microseconds.
    fn bounds(&self, n: u64) -> (i64, i64) {
        self.how.windows.bounds(n)
    }

    /// The shape of a window: kinds of cells, sides, bins, rows, columns.
    fn shape(&self, size: (usize, usize), channels: u8) -> [usize; 5] {
        self.how.shape(Size::new(size.0, size.1), channels)
    }
}

/// Windows of a clip that comes part by part.
#[pyclass(frozen, module = "amacrine._amacrine")]
pub struct Stream(Mutex<VoxelStream>);

impl Stream {
    pub fn with<T>(&self, what: impl FnOnce(&mut VoxelStream) -> T) -> T {
        what(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[pymethods]
impl Stream {
    #[new]
    fn new(how: &Voxels, size: (usize, usize), channels: u8) -> Self {
        let size = Size::new(size.0, size.1);
        Self(Mutex::new(VoxelStream::new(how.how, size, channels)))
    }

    /// The windows that are left of a clip that ends at `end`, in microseconds.
    fn rest<'py>(&self, py: Python<'py>, end: u64) -> PyResult<Vec<Bound<'py, PyArray1<f32>>>> {
        let left = pool::work(py, || self.with(|stream| stream.rest(Micros(end))))?;
        Ok(arrays(py, left))
    }
}

/// Each as an array of its own.
pub fn arrays(py: Python<'_>, all: Vec<Vec<f32>>) -> Vec<Bound<'_, PyArray1<f32>>> {
    all.into_iter()
        .map(|one| PyArray1::from_vec(py, one))
        .collect()
}

const FEWER: &str = "take fewer of them, or a part of the events";

/// Whether there is room for so many bytes.
fn room(what: &str, bytes: u128) -> Result<(), Report> {
    within(&Need::new().and(what, bytes), what, FEWER)
}

/// Refuses what this machine's memory does not hold.
fn within(need: &Need, what: &str, help: &str) -> Result<(), Report> {
    let held = need.within(Budget::from_machine(), what, help);
    // There is no --max-memory here.
    held.map_err(|much| miette!(help = help.to_owned(), "{much}"))
}

/// Refuses an array of so many bytes, and what is held beside it, where this machine has less memory.
#[pyfunction]
pub fn check_room(what: &str, bytes: u64, beside: u64, help: &str) -> PyResult<()> {
    let need = Need::new().and("the array", bytes.into());
    let need = need.and("what it is made of", beside.into());
    within(&need, what, help).map_err(raised)
}

/// Leaves out what is before a time, in microseconds, which becomes 0.
fn start_at(micros: i64, events: &mut Vec<Event>) {
    events.retain_mut(|event| {
        let t = event.t.0.cast_signed().saturating_sub(micros);
        event.t = Micros(t.max(0).cast_unsigned());
        t >= 0
    });
}

/// Rows, columns and kinds of cells.
type Place = (usize, usize, u8);

/// Values of all kinds and sides.
fn planes(packet: &Packet, sides: Sides) -> u128 {
    let kinds = usize::from(packet.channels) * sides.count();
    (packet.size.pixels() as u128).saturating_mul(kinds as u128)
}

fn place(packet: &Packet) -> Place {
    (packet.size.height, packet.size.width, packet.channels)
}

/// The voxels of an array of events from `since` microseconds on, which become 0, up to `end` or the
/// last of them; they will be held once more in another type, of so many bytes each.
#[pyfunction]
pub fn voxels<'py>(
    py: Python<'py>,
    events: &Events,
    since: i64,
    size: Option<(usize, usize)>,
    channels: u8,
    how: &Voxels,
    end: Option<u64>,
    other: u64,
) -> PyResult<(Bound<'py, PyArray1<f32>>, Place)> {
    let events = events.borrowed(py)?;
    let given = events.given()?;
    let made = pool::work(py, || {
        let mut packet = given.packet(files::size(size), channels);
        start_at(since, &mut packet.events);
        let times = || packet.events.iter().map(|event| event.t);
        let (first, last) = (times().min(), times().max());
        packet.span.1 = end.map_or(last.unwrap_or_default(), Micros);
        let count = how.how.windows.count(packet.span.1);
        let (of, kinds) = (packet.size, packet.channels);
        let each = how.how.len(of, kinds) as u128;
        // Recordings with times of the day begin with years of nothing.
        let first = first.filter(|first| first.0 > packet.span.1.0 / 2);
        let help = first.map_or(FEWER.to_owned(), |first| {
            let first = first.seconds();
            format!(
                "windows begin {first} s before the first event: give a later `start`, in seconds"
            )
        });
        let all = each.saturating_mul(count.into());
        let first = how.how.held(of, kinds, count);
        // In the other type they are made when the sums are gone.
        let then = all.saturating_mul(u128::from(other) + 4);
        let most = if other > 0 { first.max(then) } else { first };
        within(&Need::new().and("voxels", most), "voxels", &help)?;
        let voxels = how.how.first(&packet, count)?;
        Ok((voxels, place(&packet)))
    })?;
    let (voxels, place) = made.map_err(|report: Report| raised(report))?;
    Ok((PyArray1::from_vec(py, voxels), place))
}

/// Time surfaces of an array of events, at these microseconds.
#[pyfunction]
pub fn surfaces<'py>(
    py: Python<'py>,
    events: &Events,
    size: Option<(usize, usize)>,
    channels: u8,
    times: Vec<u64>,
    tau: f64,
    decay: &str,
    polarity: &str,
) -> PyResult<(Bound<'py, PyArray1<f32>>, Place)> {
    let mut how = TimeSurface::new(tau).map_err(raised)?;
    how.decay = named(decay)?;
    how.sides = named(polarity)?;
    let events = events.borrowed(py)?;
    let given = events.given()?;
    let made = pool::work(py, || {
        let packet = given.packet(files::size(size), channels);
        let held = how.held(packet.size, packet.channels, times.len());
        room("time surfaces", held)?;
        let times: Vec<_> = times.into_iter().map(Micros).collect();
        Ok((how.of(&packet, &times)?, place(&packet)))
    })?;
    let (surfaces, place) = made.map_err(|report: Report| raised(report))?;
    Ok((PyArray1::from_vec(py, surfaces), place))
}

/// Frames of `each` events of an array.
#[pyfunction]
pub fn event_frames<'py>(
    py: Python<'py>,
    events: &Events,
    size: Option<(usize, usize)>,
    channels: u8,
    each: usize,
    polarity: &str,
    fill: &str,
) -> PyResult<(Bound<'py, PyArray1<i32>>, Place)> {
    let (sides, fill) = (named(polarity)?, named(fill)?);
    let events = events.borrowed(py)?;
    let given = events.given()?;
    let made = pool::work(py, || {
        let packet = given.packet(files::size(size), channels);
        let frames = packet.events.len().div_ceil(each.max(1));
        let values = planes(&packet, sides).saturating_mul(frames as u128);
        room("event frames", values.saturating_mul(4))?;
        Ok((frames_of(&packet, each, sides, fill)?, place(&packet)))
    })?;
    let (frames, place) = made.map_err(|report: Report| raised(report))?;
    Ok((PyArray1::from_vec(py, frames), place))
}
