//! How many cells fire at a time.

use crate::{
    event::{Event, Packet},
    plane::Size,
    unit::Micros,
};

/// How many cells fire at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crowd {
    /// All cells.
    pub cells: u64,
    /// Frames that were looked at.
    pub frames: u64,
    /// Those in which more than half of all cells fire.
    pub over: u64,
    /// The most cells that fire in one.
    pub most: u64,
    /// Which one that is.
    pub frame: u64,
    /// Those that fire in the first.
    pub first: u64,
}

impl Crowd {
    /// Nothing seen yet of so many cells.
    #[must_use]
    pub fn new(cells: u64) -> Self {
        Self {
            cells,
            ..Self::default()
        }
    }

    /// The next frame, in which so many cells fire.
    pub fn see(&mut self, firing: u64) {
        if firing > self.most {
            self.most = firing;
            self.frame = self.frames;
        }
        if self.frames == 0 {
            self.first = firing;
        }
        self.over += u64::from(2 * firing > self.cells);
        self.frames += 1;
    }

    /// From a packet whose frames were at these times: the cells that fire after one and up to
    /// the next.
    #[must_use]
    pub fn from_packet(packet: &Packet, frames: &[Micros]) -> Self {
        let Size { height, width } = packet.size;
        let cells = height * width * usize::from(packet.channels);
        let mut crowd = Self::new(cells as u64);
        // The last frame, from 1, in which each cell fired.
        let mut last = vec![0_u32; cells];
        let mut events = packet.events.iter().peekable();
        for (frame, time) in (1..).zip(frames) {
            let mut firing = 0;
            while let Some(event) = events.next_if(|event| event.t <= *time) {
                if let Some(last) = last.get_mut(cell(event, packet.size)) {
                    firing += u64::from(*last != frame);
                    *last = frame;
                }
            }
            crowd.see(firing);
        }
        crowd
    }
}

fn cell(event: &Event, size: Size) -> usize {
    let plane = usize::from(event.channel) * size.height + usize::from(event.y);
    plane * size.width + usize::from(event.x)
}
