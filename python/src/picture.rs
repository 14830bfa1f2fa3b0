//! Pictures for notebooks, as the command line draws them.

use amacrine::{
    picture::{
        panel, png, raster,
        view::{self, Look, View},
    },
    plane::Plane,
    unit::Micros,
};
use numpy::PyReadonlyArray2;
use pyo3::{prelude::*, types::PyBytes};

use crate::{error::raised, events::Events, files, pool};

/// The window of a frame of events, as of `amacrine show`.
const WINDOW: Micros = Micros(20_000);

/// A register as the bytes of a PNG: `low` and below is black, `high` and above white.
#[pyfunction]
pub fn register_picture<'py>(
    py: Python<'py>,
    values: PyReadonlyArray2<'py, f64>,
    low: f64,
    high: f64,
) -> Bound<'py, PyBytes> {
    let array = values.as_array();
    let shape = array.dim();
    let plane = Plane::from_shape_fn(shape, |at| array[at]);
    PyBytes::new(py, &png(&panel::frame(&plane, low, high)))
}

/// The frame of events of the busiest 20 ms as the bytes of a PNG: `amacrine show --view frame`.
#[pyfunction]
pub fn event_picture<'py>(
    py: Python<'py>,
    events: &Events,
    size: (usize, usize),
    channels: u8,
    span: Option<(u64, u64)>,
    title: &str,
) -> PyResult<Bound<'py, PyBytes>> {
    let events = events.borrowed(py)?;
    let given = events.given()?;
    let drawn = pool::work(py, || {
        let mut packet = given.packet(files::size(Some(size)), channels);
        if let Some((from, to)) = span {
            packet.span = (Micros(from), Micros(to));
        }
        let look = Look {
            title,
            view: View::Frame,
            window: WINDOW,
            at: None,
        };
        let drawing = view::draw(&packet, &look)?;
        Ok(png(&raster(&drawing, 1)))
    })?;
    let bytes = drawn.map_err(|error: amacrine::picture::PictureError| raised(error))?;
    Ok(PyBytes::new(py, &bytes))
}
