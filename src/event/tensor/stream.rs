//! Voxels of a clip that comes part by part: only windows that are not over are held.

use std::collections::VecDeque;

use super::voxels::Voxels;
use crate::{event::Event, plane::Size, unit::Micros};

/// The voxels of events that come part by part.
#[derive(Clone, Debug)]
pub struct VoxelStream {
    how: Voxels,
    size: Size,
    channels: u8,
    /// The number of the first window that is not over.
    next: u64,
    /// Windows from there on that have begun.
    begun: VecDeque<Vec<f32>>,
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
        }
    }

    /// How they become voxels.
    #[must_use]
    pub const fn how(&self) -> &Voxels {
        &self.how
    }

    /// Takes in the next events, in the order of their times. What belongs to windows that are over
    /// is lost.
    pub fn add(&mut self, events: &[Event]) {
        let Some(last) = events.last() else { return };
        let last = last.t.0 as i64;
        let place = (self.size, self.channels);
        let windows = self.how.windows;
        for n in (self.next..).take_while(|n| windows.bounds(*n).0 < last) {
            let at = (n - self.next) as usize;
            self.begin(at);
            self.how.add(events, n, place, &mut self.begun[at]);
        }
    }

    /// The windows that end by `until`, up to which all events are in, in their order.
    pub fn finished(&mut self, until: Micros) -> Vec<Vec<f32>> {
        let over = (self.next..).take_while(|n| self.how.windows.bounds(*n).1 <= until.0 as i64);
        let count = over.count();
        self.end(count)
    }

    /// The windows that are left of a clip that ends at `end`.
    pub fn rest(&mut self, end: Micros) -> Vec<Vec<f32>> {
        let count = self.how.windows.count(end).saturating_sub(self.next);
        self.end(count as usize)
    }

    fn begin(&mut self, at: usize) {
        let each = self.how.len(self.size, self.channels);
        while self.begun.len() <= at {
            self.begun.push_back(vec![0.0; each]);
        }
    }

    fn end(&mut self, count: usize) -> Vec<Vec<f32>> {
        if count > 0 {
            self.begin(count - 1);
        }
        self.next += count as u64;
        let mut over: Vec<_> = self.begun.drain(..count).collect();
        for window in &mut over {
            self.how.finish((self.size, self.channels), window);
        }
        over
    }
}
