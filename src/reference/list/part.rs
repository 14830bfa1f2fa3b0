//! What one band of rows has said in a pair of frames, dealt out to stretches of time.

use crate::{event::Event, number::Real};

use super::{
    super::train::TrainRow,
    clock::Clock,
    note::{FEW, Note, expand},
};

/// The events of one band in the current pair.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    clock: Clock,
    /// How many events fit.
    room: u64,
    /// How many there are.
    pub(super) total: u64,
    /// The notes of one row, and a few more.
    row: Vec<Note>,
    /// The notes of each stretch of time, in the order in which they were told.
    stretches: Vec<Stretch>,
    /// The events of a pair that is too long for notes.
    pub(super) events: Vec<Event>,
}

impl Part {
    /// Forgets what was said.
    pub(super) fn begin(&mut self, clock: Clock, room: u64) {
        (self.clock, self.room, self.total) = (clock, room, 0);
        self.events.clear();
        self.stretches
            .resize_with(clock.stretches(), Stretch::default);
        for stretch in &mut self.stretches {
            stretch.len = 0;
        }
    }

    /// Keeps the events of a row of trains, if they fit: a single cell may say 2^30 events.
    pub(super) fn take<R: Real>(&mut self, row: &TrainRow<R>) {
        let events = row.events();
        self.total = self.total.saturating_add(events);
        if self.total > self.room {
            return;
        }
        if self.clock.is_long() {
            self.take_long(row);
            return;
        }
        let events = events as usize;
        if let [all] = &mut self.stretches[..] {
            expand(row, &self.clock, all.room(events + FEW));
            all.len += events;
            return;
        }
        if self.row.len() < events + FEW {
            self.row.resize(events + FEW, Note::default());
        }
        expand(row, &self.clock, &mut self.row);
        let row = &self.row[..events];
        for (k, stretch) in self.stretches.iter_mut().enumerate() {
            stretch.pick(row, self.clock.stretch(k));
        }
    }

    /// What was told of a stretch.
    pub(super) fn stretch(&self, k: usize) -> &[Note] {
        self.stretches[k].notes()
    }

    fn take_long<R: Real>(&mut self, row: &TrainRow<R>) {
        let clock = self.clock;
        for (x, train) in row.trains() {
            let note = Note::of(row.channel, row.y).column(x, row.counts[x]);
            let event = |i| note.at(clock.time(clock.at(train.at(i))));
            self.events.extend((0..train.count).map(event));
        }
    }
}

/// The notes of a stretch of time, in the order in which they were told; the buffer is longer.
#[derive(Clone, Debug, Default)]
struct Stretch {
    notes: Vec<Note>,
    len: usize,
}

impl Stretch {
    fn notes(&self) -> &[Note] {
        &self.notes[..self.len]
    }

    /// Room for so many more.
    fn room(&mut self, more: usize) -> &mut [Note] {
        let end = self.len + more;
        if self.notes.len() < end {
            self.notes.resize(end.next_power_of_two(), Note::default());
        }
        &mut self.notes[self.len..end]
    }

    /// Appends those of some notes that are in it; no branch depends on them.
    fn pick(&mut self, notes: &[Note], (since, length): (u64, u64)) {
        let out = self.room(notes.len());
        let mut len = 0;
        for note in notes {
            out[len] = *note;
            len += usize::from(note.since().wrapping_sub(since) < length);
        }
        self.len += len;
    }
}

/// Sorts the notes of one stretch by time; those of one microsecond stay in order.
pub(super) fn sort<'a, I: Iterator<Item = &'a [Note]>>(
    told: impl Fn() -> I,
    (since, length): (u64, u64),
    next: &mut Vec<u32>,
    out: &mut [Note],
) {
    if length > 4 * out.len() as u64 {
        for (out, note) in out.iter_mut().zip(told().flatten()) {
            *out = *note;
        }
        out.sort_by_key(|note| note.since());
        return;
    }
    next.clear();
    next.resize(length as usize, 0);
    for notes in told() {
        for note in notes {
            next[(note.since() - since) as usize] += 1;
        }
    }
    let mut sum = 0;
    for place in &mut *next {
        sum += std::mem::replace(place, sum);
    }
    for notes in told() {
        for note in notes {
            let place = &mut next[(note.since() - since) as usize];
            out[*place as usize] = *note;
            *place += 1;
        }
    }
}
