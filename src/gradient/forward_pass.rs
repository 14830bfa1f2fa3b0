//! A piece on its way forward, pair by pair, as `reference` takes a band of rows.

use std::ops::Range;

use multiversion::multiversion;

use crate::{
    number::Real,
    reference::{
        Interval, TrainRow,
        drive::{Made, Parts, log_temporal},
        fire, memory,
        memory::Stepped,
        refractory,
        signal::Padded,
        step::Seen,
    },
};

use super::{
    error::GradientError,
    float::Float,
    forward::{Tape, room},
    model::{Kind, Model},
    piece::Piece,
};

/// A piece on its way forward.
pub(super) struct ForwardPass<'a, R: Float> {
    model: &'a Model<R>,
    piece: &'a Piece,
    signal: &'a [Padded<R>],
    cells: Vec<Cells<R>>,
    drive: Vec<R>,
    memory: Vec<R>,
    scratch: Vec<R>,
    parts: Parts<R>,
    trains: TrainRow<R>,
}

/// The cells of one channel in a piece, row after row.
struct Cells<R: Float> {
    memory: Memory<R>,
    made: Made<R>,
    /// The drive at the frame before.
    before: Vec<R>,
    /// When each cell last fired, in seconds.
    fired: Vec<f64>,
}

enum Memory<R: Float> {
    Steps(Stepped<R::Number>),
    Snaps(Vec<R>),
}

impl<'a, R: Float> ForwardPass<'a, R> {
    pub(super) fn new(model: &'a Model<R>, piece: &'a Piece, signal: &'a [Padded<R>]) -> Self {
        let width = model.size.width;
        let mut pass = Self {
            model,
            piece,
            signal,
            cells: Vec::new(),
            drive: vec![R::ZERO; width],
            memory: vec![R::ZERO; width],
            scratch: vec![R::ZERO; width],
            parts: Parts::default(),
            trains: TrainRow::new(width),
        };
        pass.cells = (0..model.channels()).map(|k| pass.settle(k)).collect();
        pass
    }

    /// The cells of a channel after the first frame.
    fn settle(&mut self, channel: usize) -> Cells<R> {
        let (model, width) = (self.model, self.drive.len());
        let cells = self.piece.rows.len() * width;
        let mut before = Vec::with_capacity(cells);
        let mut stored = Vec::with_capacity(cells);
        for y in self.piece.rows.clone() {
            let row = &mut self.drive;
            model.weights[channel].row(&R::NUMBER, &self.signal[0], y, row, &mut self.parts);
            if model.description.channels[channel].log_temporal {
                log_temporal(&R::NUMBER, row, 0.0);
            }
            let offset = &mut self.scratch;
            model.offset((self.piece.clip, channel, y), offset);
            before.extend_from_slice(row);
            stored.extend(
                row.iter()
                    .zip(offset)
                    .map(|(drive, offset)| *drive - *offset),
            );
        }
        let thresholds = &model.thresholds[channel];
        let memory = if model.description.memory.steps() {
            Memory::Steps(Stepped::new(&stored, thresholds.equal))
        } else {
            Memory::Snaps(stored)
        };
        Cells {
            memory,
            made: Made::default(),
            before,
            fired: vec![f64::NEG_INFINITY; cells],
        }
    }

    pub(super) fn run(
        mut self,
        times: &[f64],
        (mut voxels, mut counts): (Vec<&mut [R]>, Vec<&mut [i32]>),
        tape: &mut Tape<R>,
    ) -> Result<(), GradientError> {
        let (model, channels, width) = (self.model, self.model.channels(), self.drive.len());
        let part = self.piece.rows.len() * width;
        let all = (times.len() - 1) * channels * part;
        let timed = model.silence() > 0.0;
        // All of it is written below; of the voxels, each bin by the pair before it.
        room(&mut tape.distance, all, R::ZERO);
        room(&mut tape.timing, if timed { all } else { 0 }, R::ZERO);
        for first in &mut voxels[..channels] {
            first.fill(R::ZERO);
        }
        for (pair, time) in times.windows(2).enumerate() {
            let interval = Interval {
                index: pair as u64,
                from: time[0],
                to: time[1],
            };
            for k in 0..channels {
                let start = (pair * channels + k) * part;
                let bins = [pair * channels + k, (pair + 1) * channels + k];
                for y in self.piece.rows.clone() {
                    let at = (y - self.piece.rows.start) * width;
                    let cells = at..at + width;
                    let on_tape = start + at..start + at + width;
                    let distance = &mut tape.distance[on_tape.clone()];
                    let timing = tape.timing.get_mut(on_tape).unwrap_or_default();
                    let fault = |()| GradientError::Cell {
                        clip: self.piece.clip,
                        pair,
                        channel: k,
                        y,
                    };
                    let frame = pair + 1;
                    let row = (k, y, cells.clone());
                    self.advance(frame, row, interval, (distance, timing))
                        .map_err(fault)?;
                    counts[pair * channels + k][cells.clone()].copy_from_slice(&self.trains.counts);
                    let Ok([earlier, later]) = voxels.get_disjoint_mut(bins) else {
                        continue;
                    };
                    give(&self.trains, &mut earlier[cells.clone()], &mut later[cells]);
                }
            }
        }
        Ok(())
    }

    /// Advances a row of cells through a pair, and leaves their trains.
    fn advance(
        &mut self,
        frame: usize,
        (k, y, range): (usize, usize, Range<usize>),
        interval: Interval,
        (distance, timing): (&mut [R], &mut [R]),
    ) -> Result<(), ()> {
        let (model, number) = (self.model, R::NUMBER);
        let Self {
            drive,
            memory,
            scratch,
            parts,
            trains,
            ..
        } = self;
        let cells = &mut self.cells[k];
        let signal = &self.signal[frame];
        model.weights[k].row_in_order(&number, (signal, &mut cells.made), y, drive, parts);
        if model.description.channels[k].log_temporal {
            log_temporal(&number, drive, 1e-8);
        }
        let (on, off) = model.thresholds[k].row(y);
        let fired = &mut cells.fired[range.clone()];
        let silence = model.silence();
        match (&mut cells.memory, model.kind()) {
            (Memory::Steps(stepped), Kind::Authors) => {
                stepped.values(&number, range.clone(), on, off, memory);
                memory::distance(&number, drive, memory, distance);
                left(silence, interval.from, fired, timing);
                if silence <= 0.0 {
                    fired.fill(f64::NEG_INFINITY);
                }
                let thresholds = (on, off);
                if !refractory::authors(interval, silence, thresholds, distance, fired, trains) {
                    return Err(());
                }
                return stepped.take(range, &trains.counts).map_err(|_| ());
            }
            (Memory::Steps(stepped), _) => {
                stepped.values(&number, range.clone(), on, off, memory);
                memory::distance(&number, drive, memory, distance);
                let seen = Seen {
                    drive,
                    on,
                    off,
                    per: model.thresholds[k].inverse(y),
                    leak: &[],
                    elapsed: (0.0, 0.0),
                };
                let before = &mut cells.before[range.clone()];
                stepped
                    .cross(&number, range, before, &seen, true, (&mut *trains, scratch))
                    .map_err(|_| ())?;
            }
            (Memory::Snaps(stored), _) => {
                let stored = &mut stored[range];
                memory::distance(&number, drive, stored, distance);
                if !fire::snap(distance, on, off, trains) {
                    return Err(());
                }
                for ((stored, drive), count) in stored.iter_mut().zip(&*drive).zip(&trains.counts) {
                    *stored = if *count == 0 { *stored } else { *drive };
                }
            }
        }
        if silence > 0.0 {
            refractory::dead_time(interval, silence, fired, trains);
            awake(silence, interval.to, fired, (trains, timing));
        }
        Ok(())
    }
}

impl<R: Float> Model<R> {
    /// How far the first drive of a row's cells lies above their memories.
    pub(super) fn offset(&self, place: (usize, usize, usize), out: &mut [R]) {
        self.begin(place, out);
        let (on, off) = self.thresholds[place.1].row(place.2);
        for (out, (&on, &off)) in out.iter_mut().zip(on.iter().zip(off)) {
            *out = *out * if *out >= R::ZERO { on } else { off };
        }
    }
}

/// How much of the refractory period is left at a time.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn left<R: Real>(silence: f64, now: f64, fired: &[f64], timing: &mut [R]) {
    for (timing, fired) in timing.iter_mut().zip(fired) {
        let rest = silence - (now - fired);
        *timing = R::from_f64(if rest > 0.0 { rest } else { 0.0 });
    }
}

/// Where the first event is; without one, 1 where the cell is ready at the later frame, 0 where not.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn awake<R: Real>(
    silence: f64,
    to: f64,
    fired: &[f64],
    (trains, timing): (&TrainRow<R>, &mut [R]),
) {
    let ready = silence * (1.0 - 1e-9);
    let trains = trains.counts.iter().zip(&trains.first);
    for ((timing, fired), (&count, &first)) in timing.iter_mut().zip(fired).zip(trains) {
        let silent = if to - fired >= ready { R::ONE } else { R::ZERO };
        *timing = if count == 0 { silent } else { first };
    }
}

/// Adds what a row of trains gives to its earlier bin, and begins the later one with it.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn give<R: Real>(trains: &TrainRow<R>, earlier: &mut [R], later: &mut [R]) {
    let cells = earlier.len();
    let later = &mut later[..cells];
    let (counts, first) = (&trains.counts[..cells], &trains.first[..cells]);
    let spacing = &trains.spacing[..cells];
    for x in 0..cells {
        let given = |what| if counts[x] == 0 { R::ZERO } else { what };
        let (first, spacing) = (given(first[x]), given(spacing[x]));
        let count = R::from_i32(counts[x]);
        let share = count * first + spacing * (count * (count.abs() - R::ONE) * R::from_f64(0.5));
        earlier[x] = earlier[x] + (count - share);
        later[x] = R::ZERO + share;
    }
}
