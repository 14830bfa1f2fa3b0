//! Voxels of a clip that comes part by part: only windows that are not over are held.

use std::collections::VecDeque;

use super::{
    error::{TensorError, room},
    sums::Sums,
    voxels::Voxels,
};
use crate::{
    event::{Event, outside},
    plane::Size,
    unit::Micros,
};

/// The voxels of events that come part by part.
#[derive(Clone, Debug)]
pub struct VoxelStream {
    how: Voxels,
    size: Size,
    channels: u8,
    /// The number of the first window that is not over.
    next: u64,
    /// Windows from there on that have begun.
    begun: VecDeque<Sums>,
    /// Events so far that lie between windows.
    between: u64,
    /// Events so far that came when a window of theirs was over.
    lost: u64,
}

impl VoxelStream {
    /// No events yet, of a sensor of this size with so many kinds of cells.
    #[must_use]
    pub const fn new(how: Voxels, size: Size, channels: u8) -> Self {
        Self {
            how,
            size,
            channels,
            next: 0,
            begun: VecDeque::new(),
            between: 0,
            lost: 0,
        }
    }

    /// How they become voxels.
    #[must_use]
    pub const fn how(&self) -> &Voxels {
        &self.how
    }

    /// Takes in the next events, in the order of their times. What belongs to windows that are over
    /// is [lost](Self::lost).
    ///
    /// # Errors
    /// When an event lies outside of the sensor, or the windows that it begins are more than this
    /// machine holds; nothing was then taken in.
    pub fn add(&mut self, events: &[Event]) -> Result<(), TensorError> {
        let Some(last) = events.last() else {
            return Ok(());
        };
        let place = (self.size, self.channels);
        outside::check(events, self.size, self.channels)?;
        let windows = self.how.windows;
        let open = windows.count(last.t).saturating_sub(self.next);
        room(open, "windows of voxels", self.how.len(place.0, place.1))?;
        self.lost += events.iter().filter(|event| self.is_late(event)).count() as u64;
        let last = last.t.0 as i64;
        for n in (self.next..).take_while(|n| windows.after(*n) < last) {
            let at = (n - self.next) as usize;
            self.begin(at);
            self.how.add(events, n, place, &mut self.begun[at]);
        }
        Ok(())
    }

    /// Whether a window is over to which an event belongs.
    fn is_late(&self, event: &Event) -> bool {
        let windows = self.how.windows;
        let t = event.t.0 as i64;
        let Some(last) = self.next.checked_sub(1) else {
            return false;
        };
        if t > windows.bounds(last).1 {
            return false;
        }
        // The first that ends no earlier than it.
        let (mut low, mut high) = (0, last);
        while low < high {
            let middle = u64::midpoint(low, high);
            if windows.bounds(middle).1 < t {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        windows.after(low) < t
    }

    /// As [`add`](Self::add), and passes on each window that is over, one after the other: only those
    /// that overlap are held, however far apart events are.
    ///
    /// # Errors
    /// Those of [`add`](Self::add), and the first of `pass`.
    pub fn pass<E: From<TensorError>>(
        &mut self,
        events: &[Event],
        mut pass: impl FnMut(&[f32]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut rest = events;
        while let Some(first) = rest.first() {
            // More events of one time may follow.
            let before = Micros(first.t.0.saturating_sub(1));
            while let Some(window) = self.next_finished(before) {
                pass(&window)?;
            }
            // So the first window left ends no earlier than this event.
            let end = self.how.windows.bounds(self.next).1;
            let part = rest.partition_point(|event| event.t.0 as i64 <= end);
            let (now, later) = rest.split_at(part.max(1));
            let after = self.how.windows.after(self.next);
            let start = self.how.windows.start();
            let is_between = |e: &&Event| e.t.0 as i64 <= after && e.t >= start && !self.is_late(e);
            let between = now.iter().filter(is_between).count();
            self.add(now)?;
            self.between += between as u64;
            rest = later;
        }
        Ok(())
    }

    /// Events so far that came when a window to which they belong was over: they are not in it.
    /// None where events come in the order of their times.
    #[must_use]
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Events so far that lie between two windows of those that [`pass`](Self::pass) has made, or
    /// between the start and the first: windows farther apart than they are long leave them out.
    #[must_use]
    pub const fn between(&self) -> u64 {
        self.between
    }

    /// The windows that end by `until`, up to which all events are in, in their order.
    pub fn finished(&mut self, until: Micros) -> Vec<Vec<f32>> {
        std::iter::from_fn(|| self.next_finished(until)).collect()
    }

    /// The windows that are left of a clip that ends at `end`.
    pub fn rest(&mut self, end: Micros) -> Vec<Vec<f32>> {
        std::iter::from_fn(|| self.next_left(end)).collect()
    }

    /// The next window, if it ends by `until`, up to which all events are in.
    pub fn next_finished(&mut self, until: Micros) -> Option<Vec<f32>> {
        let over = self.how.windows.bounds(self.next).1 <= until.0 as i64;
        over.then(|| self.end())
    }

    /// The next window, if any is left of a clip that ends at `end`.
    pub fn next_left(&mut self, end: Micros) -> Option<Vec<f32>> {
        let left = self.next < self.how.windows.count(end);
        left.then(|| self.end())
    }

    fn begin(&mut self, at: usize) {
        let each = self.how.len(self.size, self.channels);
        while self.begun.len() <= at {
            self.begun.push_back(Sums::new(each));
        }
    }

    /// The next window, which is over.
    fn end(&mut self) -> Vec<f32> {
        let place = (self.size, self.channels);
        let silent = || Sums::new(self.how.len(place.0, place.1));
        let sums = self.begun.pop_front().unwrap_or_else(silent);
        let n = self.next;
        self.next += 1;
        self.how.finish(place, n, sums)
    }
}
