//! A sensor of any kind: light in; events, counts or voxels out.

use amacrine::{
    event::{Event, Packet, Polarity},
    number::Format,
    plane::{Plane, Size},
    reference::{AnyReference, Counts, Description, Firing, Reference, Sinks, Tally, VoxelGrid},
    scene::Frame,
    sensor::{Overflowed, Sensor, SensorError, Silence},
};

/// What watches frames, and tells how many cells fired since the frame before. A clip is watched by
/// one of the three alone.
pub trait Watcher: Send {
    /// Appends what happened since the frame before to an empty packet.
    fn events(&mut self, frame: &Frame, packet: &mut Packet) -> Result<u64, SensorError>;

    /// Signed counts of each kind and pixel since the frame before; the first frame has none.
    fn counts(&mut self, frame: &Frame, out: &mut [i32]) -> Result<u64, SensorError>;

    /// The bin of the frame before, which no later event can reach; before the first frame there
    /// is none.
    fn voxels(&mut self, frame: &Frame, out: &mut [f32]) -> Result<u64, SensorError>;

    /// The bin of the last frame.
    fn last_voxels(&mut self, out: &mut [f32]);

    /// Events of each kind so far.
    fn kinds(&self) -> &[u64];

    /// Why no cell fired so far, where none did.
    fn silence(&self) -> Silence;

    /// How much of what cells saw so far their numbers did not hold.
    fn overflowed(&self) -> Overflowed;
}

/// The float model.
struct Float {
    reference: Box<dyn AnyReference>,
    firing: Firing,
    fired: Fired,
    tally: Tally,
    counts: Counts,
    grid: VoxelGrid,
    begun: bool,
}

impl Watcher for Float {
    fn events(&mut self, frame: &Frame, packet: &mut Packet) -> Result<u64, SensorError> {
        self.reference.watch(frame, packet)?;
        Ok(self.fired.of(packet))
    }

    fn counts(&mut self, frame: &Frame, out: &mut [i32]) -> Result<u64, SensorError> {
        let sinks = Sinks {
            tally: Some(&mut self.tally),
            firing: Some(&mut self.firing),
            counts: Some(&mut self.counts),
            ..Sinks::default()
        };
        self.reference.watch_into_sinks(frame, sinks)?;
        self.fired.tallied(&self.tally);
        lay(self.counts.planes(), out, |count| count);
        Ok(self.firing.cells())
    }

    fn voxels(&mut self, frame: &Frame, out: &mut [f32]) -> Result<u64, SensorError> {
        let sinks = Sinks {
            tally: Some(&mut self.tally),
            firing: Some(&mut self.firing),
            voxels: Some(&mut self.grid),
            ..Sinks::default()
        };
        self.reference.watch_into_sinks(frame, sinks)?;
        self.fired.tallied(&self.tally);
        if std::mem::replace(&mut self.begun, true) {
            lay(self.grid.earlier(), out, |share| share as f32);
            self.grid.advance();
        }
        Ok(self.firing.cells())
    }

    fn last_voxels(&mut self, out: &mut [f32]) {
        lay(self.grid.earlier(), out, |share| share as f32);
    }

    fn kinds(&self) -> &[u64] {
        &self.fired.kinds
    }

    fn silence(&self) -> Silence {
        self.reference.silence()
    }

    fn overflowed(&self) -> Overflowed {
        self.reference.overflowed()
    }
}

/// Planes one after the other.
fn lay<T: Copy, U>(planes: &[Plane<T>], out: &mut [U], of: impl Fn(T) -> U) {
    let all = planes.iter().flatten();
    for (to, from) in out.iter_mut().zip(all) {
        *to = of(*from);
    }
}

/// The float model of a sensor.
pub fn float(
    description: Description,
    size: Size,
    seed: u64,
    format: Format,
) -> Result<Box<dyn Watcher>, SensorError> {
    let channels = description.channels.len();
    Ok(Box::new(Float {
        reference: Reference::in_format(format, description, size, seed)?,
        firing: Firing::new(),
        fired: Fired::new(channels),
        tally: Tally::new(channels),
        counts: Counts::new(size, channels),
        grid: VoxelGrid::new(size, channels),
        begun: false,
    }))
}

/// Any sensor of which only events are known: a program on the array.
pub struct Events {
    sensor: Box<dyn Sensor + Send>,
    fired: Fired,
    packet: Packet,
    /// When the frame before was shown, in seconds.
    before: Option<f64>,
    /// The bin of the later frame, `[channel][y, x]`.
    later: Vec<f32>,
}

impl Events {
    pub fn new(sensor: Box<dyn Sensor + Send>) -> Self {
        let packet = Packet::new(sensor.size(), sensor.channels());
        let cells = packet.size.pixels() * usize::from(packet.channels);
        Self {
            sensor,
            fired: Fired::new(packet.channels.into()),
            packet,
            before: None,
            later: vec![0.0; cells],
        }
    }

    /// The events since the frame before, and when that was.
    fn watch(&mut self, frame: &Frame) -> Result<Option<f64>, SensorError> {
        self.packet.events.clear();
        self.sensor.watch(frame, &mut self.packet)?;
        Ok(self.before.replace(frame.seconds))
    }

    fn cell(&self, event: &Event) -> usize {
        cell(event, self.packet.size)
    }
}

/// The place of an event's cell among those of all kinds.
fn cell(event: &Event, Size { height, width }: Size) -> usize {
    let row = usize::from(event.channel) * height + usize::from(event.y);
    row * width + usize::from(event.x)
}

/// Counts the cells that fired in an interval, and the events of each kind over all of them.
struct Fired {
    kinds: Vec<u64>,
    /// The last interval, from 1, in which each cell fired.
    last: Vec<u32>,
    intervals: u32,
}

impl Fired {
    fn new(kinds: usize) -> Self {
        Self {
            kinds: vec![0; kinds],
            last: Vec::new(),
            intervals: 0,
        }
    }

    /// Events that were counted elsewhere.
    fn tallied(&mut self, tally: &Tally) {
        for (kind, (on, off)) in self.kinds.iter_mut().zip(tally.kinds()) {
            *kind = on + off;
        }
    }

    /// Cells in a packet of one interval.
    fn of(&mut self, packet: &Packet) -> u64 {
        let cells = packet.size.pixels() * usize::from(packet.channels);
        self.last.resize(cells, 0);
        if self.intervals == u32::MAX {
            self.last.fill(0);
            self.intervals = 0;
        }
        self.intervals += 1;
        let mut fired = 0;
        for event in &packet.events {
            if let Some(kind) = self.kinds.get_mut(usize::from(event.channel)) {
                *kind += 1;
            }
            if let Some(last) = self.last.get_mut(cell(event, packet.size)) {
                fired += u64::from(*last != self.intervals);
                *last = self.intervals;
            }
        }
        fired
    }
}

impl Watcher for Events {
    fn events(&mut self, frame: &Frame, packet: &mut Packet) -> Result<u64, SensorError> {
        self.sensor.watch(frame, packet)?;
        Ok(self.fired.of(packet))
    }

    fn counts(&mut self, frame: &Frame, out: &mut [i32]) -> Result<u64, SensorError> {
        self.watch(frame)?;
        out.fill(0);
        for event in &self.packet.events {
            if let Some(count) = out.get_mut(self.cell(event)) {
                *count += event.polarity.sign();
            }
        }
        Ok(self.fired.of(&self.packet))
    }

    fn voxels(&mut self, frame: &Frame, out: &mut [f32]) -> Result<u64, SensorError> {
        let Some(before) = self.watch(frame)? else {
            return Ok(0);
        };
        out.copy_from_slice(&self.later);
        self.later.fill(0.0);
        for event in &self.packet.events {
            let since = (event.t.seconds() - before) / (frame.seconds - before);
            let later = since.clamp(0.0, 1.0) as f32;
            let sign = if event.polarity == Polarity::On {
                1.0
            } else {
                -1.0
            };
            let cell = self.cell(event);
            if let (Some(earlier), Some(bin)) = (out.get_mut(cell), self.later.get_mut(cell)) {
                *earlier += sign * (1.0 - later);
                *bin += sign * later;
            }
        }
        Ok(self.fired.of(&self.packet))
    }

    fn last_voxels(&mut self, out: &mut [f32]) {
        out.copy_from_slice(&self.later);
    }

    fn kinds(&self) -> &[u64] {
        &self.fired.kinds
    }

    fn silence(&self) -> Silence {
        self.sensor.silence()
    }

    fn overflowed(&self) -> Overflowed {
        self.sensor.overflowed()
    }
}
