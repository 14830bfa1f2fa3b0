//! Events of an array, on their way into the library.

use amacrine::{
    event::{Event, Packet, file::Loaded},
    plane::Size,
};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::{
    error::refused,
    pool,
    record::{Layout, Scan},
};

/// Events that are taken at a time.
const BLOCK: usize = 1 << 13;

/// Events of an array, which stay where numpy has them. Each of them is one.
#[pyclass(frozen, module = "amacrine._amacrine")]
pub struct Events {
    records: Py<PyArray1<u8>>,
    layout: Layout,
    scan: Scan,
}

/// The records, while nobody writes to them.
pub struct Borrowed<'py> {
    records: PyReadonlyArray1<'py, u8>,
    layout: Layout,
    scan: Scan,
}

impl Events {
    pub fn borrowed<'py>(&self, py: Python<'py>) -> PyResult<Borrowed<'py>> {
        Ok(Borrowed {
            records: readable(self.records.bind(py))?,
            layout: self.layout,
            scan: self.scan,
        })
    }
}

fn readable<'py>(records: &Bound<'py, PyArray1<u8>>) -> PyResult<PyReadonlyArray1<'py, u8>> {
    let busy = |_| refused("the events are being written to", "give a copy of them");
    records.try_readonly().map_err(busy)
}

/// Records that lie one after the other.
fn bytes<'a>(records: &'a PyReadonlyArray1<'_, u8>) -> PyResult<&'a [u8]> {
    let scattered = |_| refused("the records do not lie one after the other", "report this");
    records.as_slice().map_err(scattered)
}

impl Borrowed<'_> {
    pub fn given(&self) -> PyResult<Given<'_>> {
        Ok(Given {
            bytes: bytes(&self.records)?,
            layout: self.layout,
            scan: self.scan,
        })
    }
}

/// Events of an array, for threads of the library.
#[derive(Clone, Copy)]
pub struct Given<'a> {
    bytes: &'a [u8],
    layout: Layout,
    scan: Scan,
}

impl<'a> Given<'a> {
    /// A packet without the events, of a sensor of this size, or the smallest that holds them, and
    /// at least so many kinds of cells; from the first event to the last.
    pub fn head(&self, size: Option<Size>, kinds: u8) -> Packet {
        Packet {
            span: self.scan.span,
            ..Packet::new(size.unwrap_or(self.scan.reach), self.scan.kinds.max(kinds))
        }
    }

    /// How many events there are.
    pub const fn events(&self) -> usize {
        self.scan.events
    }

    /// The events, some at a time.
    pub fn blocks(self) -> impl Iterator<Item = Vec<Event>> + 'a {
        let records = self.bytes.chunks(BLOCK * self.layout.width());
        records.map(move |records| self.layout.parse(records))
    }

    /// As [`Given::head`], with the events in the order of their times.
    pub fn packet(self, size: Option<Size>, kinds: u8) -> Packet {
        let mut packet = self.head(size, kinds);
        packet.events = self.layout.parse(self.bytes);
        if self.scan.backwards.is_some() {
            packet.events.sort_by_key(|event| event.t);
        }
        packet
    }

    /// As [`Given::packet`], and what of it was said.
    pub fn load(self, size: Option<Size>, kinds: Option<u8>) -> Loaded {
        Loaded {
            packet: self.packet(size, kinds.unwrap_or(1)),
            size_known: size.is_some(),
            channels_known: kinds.is_some(),
            dropped_known: false,
            skipped: 0,
        }
    }
}

#[pymethods]
impl Events {
    /// The events of the records of an array of `amacrine.EVENT`, or of `amacrine.EVENT_OF_KINDS`
    /// where it has channels; columns and rows may be of 16 bits without a sign. `None` where one of
    /// them is no event.
    #[staticmethod]
    fn of(
        py: Python<'_>,
        records: Bound<'_, PyArray1<u8>>,
        has_channels: bool,
        signed: bool,
    ) -> PyResult<Option<Self>> {
        let layout = Layout {
            has_channels,
            signed,
        };
        let scan = {
            let records = readable(&records)?;
            let bytes = bytes(&records)?;
            pool::work(py, || layout.scan(bytes))?
        };
        let records = records.unbind();
        Ok(scan.map(|scan| Self {
            records,
            layout,
            scan,
        }))
    }

    /// The number of the first event that is earlier than the one before it.
    #[getter]
    const fn backwards(&self) -> Option<usize> {
        self.scan.backwards
    }

    /// How many there are.
    #[getter]
    const fn count(&self) -> usize {
        self.scan.events
    }

    /// The latest time, in microseconds; 0 where there are none.
    #[getter]
    const fn latest(&self) -> u64 {
        self.scan.latest
    }

    /// Rows and columns of the smallest sensor that holds them.
    #[getter]
    const fn reach(&self) -> (usize, usize) {
        (self.scan.reach.height, self.scan.reach.width)
    }
}
