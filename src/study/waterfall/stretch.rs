//! A stretch of a scene that stands for all of it.

use crate::{
    event::{Event, Packet},
    rig,
    scene::{
        Scene,
        part::{After, First},
    },
    sensor::Sensor,
    study::waterfall::WaterfallError,
    unit::Micros,
};

/// Some intervals between frames that follow each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    /// Its first frame.
    first: u64,
    /// Intervals.
    intervals: u64,
    fps: f64,
}

impl Stretch {
    /// Of a scene of so many frames, at most so many seconds: of the stretches that it can be
    /// cut into from its beginning, that whose events are nearest to the mean of all.
    pub(super) fn new(events: &[Event], frames: u64, fps: f64, seconds: f64) -> Self {
        let all = frames.saturating_sub(1);
        // `as` saturates; half a microsecond decides nothing.
        let intervals = (((seconds + 5e-7) * fps) as u64).clamp(1, all.max(1));
        let cuts = (all / intervals).max(1);
        let stretch = |cut: u64| Self {
            first: cut * intervals,
            intervals,
            fps,
        };
        let counts: Vec<usize> = (0..cuts)
            .map(|cut| stretch(cut).events(events).len())
            .collect();
        let mean = counts.iter().sum::<usize>() as f64 / counts.len() as f64;
        let far = |count: usize| (count as f64 - mean).abs();
        let nearest = { (0..).zip(&counts) }.min_by(|(_, a), (_, b)| far(**a).total_cmp(&far(**b)));
        stretch(nearest.map_or(0, |(cut, _)| cut))
    }

    pub(super) fn start_seconds(self) -> f64 {
        self.first as f64 / self.fps
    }

    pub(super) fn seconds(self) -> f64 {
        self.intervals as f64 / self.fps
    }

    /// Frames of the scene, both ends included.
    pub(super) const fn frames(self) -> u64 {
        self.intervals + 1
    }

    /// The events after its first frame, up to its last; of events in order of time.
    pub(super) fn events(self, events: &[Event]) -> &[Event] {
        let at = |frame: u64| {
            let t = Micros::from_seconds(frame as f64 / self.fps);
            events.partition_point(|event| event.t <= t)
        };
        let (from, to) = (at(self.first), at(self.first + self.intervals));
        events.get(from..to).unwrap_or_default()
    }

    /// It alone.
    pub(super) fn of<S: Scene>(self, scene: S) -> First<After<S>> {
        First::new(After::new(scene, self.first), self.frames())
    }

    /// What a sensor says that sees it alone.
    pub(super) fn watched(
        self,
        scene: Box<dyn Scene>,
        sensor: &mut (dyn Sensor + Send),
    ) -> Result<Packet, WaterfallError> {
        let said = rig::watch(&mut self.of(scene), &mut [sensor], |_| ())?;
        said.into_iter().next().ok_or(WaterfallError::Packet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::Polarity;

    #[test]
    fn it_has_as_many_events_as_is_usual() {
        // 9 intervals of 10 ms; events at the end of each: 9, 0, 3, 3, 3, 3, 0, 0, 0.
        let counts = [9, 0, 3, 3, 3, 3, 0, 0, 0];
        let events: Vec<Event> = (1..)
            .zip(counts)
            .flat_map(|(frame, count)| {
                let event = Event {
                    t: Micros(10_000 * frame),
                    x: 0,
                    y: 0,
                    polarity: Polarity::On,
                    channel: 0,
                };
                vec![event; count]
            })
            .collect();
        let stretch = Stretch::new(&events, 10, 100.0, 0.03);
        // 12, 9 and 0 events in 3 intervals each: the mean is 7.
        assert_eq!((stretch.first, stretch.intervals), (3, 3));
        assert_eq!((stretch.start_seconds(), stretch.seconds()), (0.03, 0.03));
        assert_eq!(stretch.events(&events).len(), 9);
        let whole = Stretch::new(&events, 10, 100.0, 9.0);
        assert_eq!((whole.first, whole.frames()), (0, 10));
        assert_eq!(whole.events(&events).len(), 21);
    }
}
