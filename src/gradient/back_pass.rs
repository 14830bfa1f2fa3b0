//! A piece on its way back, pair by pair from the last to the first.
//!
//! With `a`, `b` a cell's slopes by its distances at the later and the earlier frame of pair `n`, `κ`
//! how far its memory follows, and `m = dL/dM`:
//!
//! ```text
//! dL/dS_n = a_n + κ_n m_{n+1} + b_{n+1}
//! m_n     = (1 - κ_n) m_{n+1} - a_n - b_n          m_{P+1} = 0
//! dL/dS_0 = m_1 + b_1
//! dL/dθ  += (by the train) + m_{n+1} dM_{n+1}/dθ
//! ```
//!
//! Two rows of state for each row of cells: with `κ = 1` this is `a_n - a_{n+1}`.

use multiversion::multiversion;

use crate::{
    elementary,
    number::Real,
    reference::{drive::Parts, fire, signal::BLOCK},
};

use super::{
    backward::Ask,
    float::Float,
    forward::{Forward, Tape},
    mean::{self, MeanOutput, MeanRows},
    model::{Kind, Model},
    pair::{AUTHORS, Cell, DEAD, Pair, RELEASED, RESET, SNAP, STEP, THROUGH, slopes},
    piece::Piece,
    rule::Rule,
    sums::ChannelSum,
};

/// A piece on its way back.
pub(super) struct BackPass<'a, R: Float> {
    model: &'a Model<R>,
    seen: &'a Forward<R>,
    ask: &'a Ask<'a, R>,
    rule: Rule,
    piece: &'a Piece,
    pub(super) sums: Vec<ChannelSum<R>>,
    /// `dL/dM` and `b` of each cell in the pair after, (channels, rows, columns).
    memory: Vec<R>,
    before: Vec<R>,
    /// `dL/dS` of one row, 0 beyond its end.
    h: Vec<R>,
    /// The same, every other column 0.
    half: Vec<R>,
    from: Vec<R>,
    ones: Vec<R>,
    none: Vec<R>,
    /// The gradients of a row's own thresholds, ON and OFF, where cells have their own.
    own: [Vec<R>; 2],
    drive: Vec<R>,
    parts: Parts<R>,
    /// With [`Rule::Mean`], by how much each cell left its play, (pairs, channels, rows, columns).
    over: Vec<R>,
    /// `dL/dS`, (frames, channels, rows, columns), where the light's gradient is wanted.
    pub(super) light: Vec<R>,
    /// Whether all is finite that the loss asks of this piece.
    pub(super) finite: bool,
}

impl<'a, R: Float> BackPass<'a, R> {
    pub(super) fn new(
        model: &'a Model<R>,
        seen: &'a Forward<R>,
        ask: &'a Ask<'a, R>,
        rule: Rule,
        piece: &'a Piece,
    ) -> Self {
        let width = model.size.width;
        let (cells, whole) = (piece.rows.len() * width, width.next_multiple_of(BLOCK));
        let light = seen.times.len() * model.channels() * cells;
        Self {
            model,
            seen,
            ask,
            rule,
            piece,
            sums: (0..model.channels())
                .map(|k| ChannelSum::new(model, k))
                .collect(),
            memory: vec![R::ZERO; model.channels() * cells],
            before: vec![R::ZERO; model.channels() * cells],
            h: vec![R::ZERO; whole],
            half: vec![R::ZERO; whole],
            from: vec![R::ZERO; width],
            ones: vec![R::ONE; width],
            none: vec![R::ZERO; width],
            own: [vec![R::ZERO; width], vec![R::ZERO; width]],
            drive: vec![R::ZERO; width],
            parts: Parts::default(),
            over: Vec::new(),
            light: vec![R::ZERO; if ask.light { light } else { 0 }],
            finite: true,
        }
    }

    pub(super) fn run(&mut self, tape: &Tape<R>) {
        let (channels, rows) = (self.model.channels(), self.piece.rows.clone());
        if self.rule == Rule::Mean {
            self.plays(tape);
        }
        for pair in (0..self.seen.times.len() - 1).rev() {
            for k in 0..channels {
                for y in rows.clone() {
                    self.pair(tape, pair, k, y);
                    self.settle(k, y);
                    self.frame(tape, pair + 1, k, y);
                }
                self.sums[k].fold();
            }
        }
        for k in 0..channels {
            for y in rows.clone() {
                self.start(k, y);
                self.settle(k, y);
                self.frame(tape, 0, k, y);
            }
            self.sums[k].fold();
        }
    }

    /// The place of row `y` of channel `k` among the piece's cells.
    fn place(&self, k: usize, y: usize) -> std::ops::Range<usize> {
        let width = self.from.len();
        let start = (k * self.piece.rows.len() + y - self.piece.rows.start) * width;
        start..start + width
    }

    /// Leaves the distances of a row from its memories at the earlier frame of a pair.
    fn begin(&mut self, tape: &Tape<R>, pair: usize, k: usize, y: usize) {
        let model = self.model;
        if pair == 0 {
            return model.offset((self.piece.clip, k, y), &mut self.from);
        }
        let all = model.channels() * self.piece.rows.len() * self.from.len();
        let before = &tape.distance[(pair - 1) * all..][self.place(k, y)];
        let thresholds = &model.thresholds[k];
        remainders(
            before,
            thresholds.row(y),
            thresholds.inverse(y),
            &mut self.from,
        );
    }

    /// By how much each cell leaves its play in each pair.
    fn plays(&mut self, tape: &Tape<R>) {
        let (channels, rows) = (self.model.channels(), self.piece.rows.clone());
        let all = channels * rows.len() * self.from.len();
        self.over.resize(tape.distance.len(), R::ZERO);
        let mut play = vec![R::ZERO; all];
        for k in 0..channels {
            for y in rows.clone() {
                self.model.begin((self.piece.clip, k, y), &mut self.from);
                let (on, off) = self.model.thresholds[k].row(y);
                let play = &mut play[self.place(k, y)];
                for (x, (play, part)) in play.iter_mut().zip(&self.from).enumerate() {
                    let theta = if *part >= R::ZERO { on[x] } else { off[x] };
                    *play = mean::begin(*part) * theta;
                }
            }
        }
        for pair in 0..self.seen.times.len() - 1 {
            for k in 0..channels {
                for y in rows.clone() {
                    self.begin(tape, pair, k, y);
                    let place = self.place(k, y);
                    let distances = (&self.from[..], &tape.distance[pair * all..][place.clone()]);
                    let thresholds = self.model.thresholds[k].row(y);
                    let over = &mut self.over[pair * all..][place.clone()];
                    mean::leave(distances, thresholds, &mut play[place], over);
                }
            }
        }
    }

    /// Takes a row of cells back through a pair; leaves `dL/dS` of its later frame.
    fn pair(&mut self, tape: &Tape<R>, pair: usize, k: usize, y: usize) {
        let (model, seen, width) = (self.model, self.seen, self.from.len());
        let (channels, clip) = (model.channels(), self.piece.clip);
        let place = self.place(k, y);
        let all = channels * self.piece.rows.len() * width;
        let on_tape = |pair: usize| pair * all + place.start..pair * all + place.end;
        let thresholds = model.thresholds[k].row(y);
        let per = model.thresholds[k].inverse(y);
        let kind = model.kind();
        self.begin(tape, pair, k, y);
        let pixels = model.size.pixels();
        let row = |plane: usize| plane * pixels + y * width..plane * pixels + (y + 1) * width;
        let frames = seen.times.len();
        let bin = |frame| row((clip * frames + frame) * channels + k);
        let of_pair = row((clip * (frames - 1) + pair) * channels + k);
        let none = &self.none[..];
        let voxels = |frame| self.ask.voxels.map_or(none, |voxels| &voxels[bin(frame)]);
        let timing = tape.timing.get(on_tape(pair));
        let timing = timing.unwrap_or(if kind == Kind::Snap {
            &self.ones[..]
        } else {
            none
        });
        let dt = seen.times[pair + 1] - seen.times[pair];
        let silence = match kind {
            Kind::Authors => model.silence(),
            _ => model.silence() / dt * (1.0 - 1e-9),
        };
        let input = Rows {
            from: &self.from,
            to: &tape.distance[on_tape(pair)],
            thresholds,
            per,
            counts: &seen.counts[of_pair.clone()],
            timing,
            earlier: voxels(pair),
            later: voxels(pair + 1),
            signed: self.ask.counts.map_or(none, |counts| &counts[of_pair]),
        };
        // Each row once: the last bin is of no other pair. They are in the cache here.
        let last = if pair + 2 == frames { input.later } else { &[] };
        self.finite &= finite(input.earlier) && finite(input.signed) && finite(last);
        let shared = Pair {
            silence: R::from_f64(silence),
            duration: R::from_f64(dt),
            events: Pair::asks(self.ask.events, self.ask.slope),
        };
        let [on, off] = sums_of(model, (&mut self.own, &mut self.sums), k, y);
        if self.rule == Rule::Mean {
            let rows = MeanRows {
                from: input.from,
                to: input.to,
                over: &self.over[on_tape(pair)],
                thresholds,
                earlier: input.earlier,
                later: input.later,
                signed: input.signed,
            };
            let output = MeanOutput {
                h: &mut self.h[..width],
                memory: &mut self.memory[place.clone()],
                before: &mut self.before[place],
                on,
                off,
            };
            let run = match kind {
                Kind::Dead => mean::back::<R, true>,
                _ => mean::back::<R, false>,
            };
            return run(&rows, &shared, output);
        }
        let output = Output {
            h: &mut self.h[..width],
            memory: &mut self.memory[place.clone()],
            before: &mut self.before[place],
            on,
            off,
        };
        let kind = match kind {
            Kind::Step => STEP,
            Kind::Dead => DEAD,
            Kind::Authors => AUTHORS,
            Kind::Snap => SNAP,
        };
        let run = match (kind, self.rule.constant()) {
            (STEP, RELEASED) => back::<R, STEP, RELEASED>,
            (STEP, RESET) => back::<R, STEP, RESET>,
            (STEP, _) => back::<R, STEP, THROUGH>,
            (DEAD, RELEASED) => back::<R, DEAD, RELEASED>,
            (DEAD, RESET) => back::<R, DEAD, RESET>,
            (DEAD, _) => back::<R, DEAD, THROUGH>,
            (AUTHORS, RELEASED) => back::<R, AUTHORS, RELEASED>,
            (AUTHORS, RESET) => back::<R, AUTHORS, RESET>,
            (AUTHORS, _) => back::<R, AUTHORS, THROUGH>,
            (_, RELEASED) => back::<R, SNAP, RELEASED>,
            (_, RESET) => back::<R, SNAP, RESET>,
            (_, _) => back::<R, SNAP, THROUGH>,
        };
        run(&input, &shared, output);
    }

    /// Adds what a row has left for its cells' own thresholds, where they have such.
    fn settle(&mut self, k: usize, y: usize) {
        if self.model.is_mismatched(k) {
            let nominal = &self.model.description.channels[k].thresholds;
            let theta = self.model.thresholds[k].row(y);
            self.sums[k].add_row(y, &mut self.own, theta, nominal);
        }
    }

    /// Leaves `dL/dS` of the first frame, from which the memories began.
    fn start(&mut self, k: usize, y: usize) {
        let model = self.model;
        let place = self.place(k, y);
        let memory = &self.memory[place.clone()];
        let cells = memory.iter().zip(&self.before[place]);
        for (h, (memory, before)) in self.h.iter_mut().zip(cells) {
            *h = *memory + *before;
        }
        // A memory that begins a part of a threshold away follows the threshold.
        self.model.begin((self.piece.clip, k, y), &mut self.from);
        let mean = self.rule == Rule::Mean;
        let [on, off] = sums_of(model, (&mut self.own, &mut self.sums), k, y);
        for (x, (&part, memory)) in self.from.iter().zip(memory).enumerate() {
            let part = if mean { mean::begin(part) } else { part };
            let column = if part >= R::ZERO {
                &mut on[x]
            } else {
                &mut off[x]
            };
            *column = *column - part * *memory;
        }
    }

    /// Adds a row of `dL/dS` of a frame to the kernel's sums, and keeps it for the light.
    fn frame(&mut self, tape: &Tape<R>, frame: usize, k: usize, y: usize) {
        let (model, width) = (self.model, self.from.len());
        let signal = &self.seen.signal[self.piece.clip * self.seen.times.len() + frame];
        if model.description.channels[k].log_temporal {
            self.through_logarithm(tape, frame, k, y);
        }
        if !self.light.is_empty() {
            let cells = self.piece.rows.len() * width;
            let start =
                (frame * model.channels() + k) * cells + (y - self.piece.rows.start) * width;
            self.light[start..start + width].copy_from_slice(&self.h[..width]);
        }
        if let [one] = &mut self.sums[k].kernels[..] {
            return one.add(signal, (y, width), &self.h);
        }
        for parity in 0..2 {
            for (x, (half, h)) in self.half.iter_mut().zip(&self.h).enumerate() {
                *half = if x % 2 == parity { *h } else { R::ZERO };
            }
            self.sums[k].kernels[2 * (y % 2) + parity].add(signal, (y, width), &self.half);
        }
    }

    /// From `dL/dT` to `dL/dS`, with `T = ln(max(S, floor) + 1)`.
    ///
    /// The released code lets the gradient through where it clamps; so does its rule.
    fn through_logarithm(&mut self, tape: &Tape<R>, frame: usize, k: usize, y: usize) {
        let (model, released) = (self.model, self.rule == Rule::Authors);
        let signal = &self.seen.signal[self.piece.clip * self.seen.times.len() + frame];
        model.weights[k].row(&R::NUMBER, signal, y, &mut self.drive, &mut self.parts);
        let floor = R::from_f64(if frame == 0 { 0.0 } else { 1e-8 });
        if released && frame > 0 {
            self.gain(tape, frame - 1, k, y);
        }
        for (h, &drive) in self.h.iter_mut().zip(&self.drive) {
            let above = drive > floor;
            let held = if above || (released && frame == 0) {
                drive
            } else {
                floor
            };
            let through = above || released;
            *h = if through {
                *h / (held + R::ONE)
            } else {
                R::ZERO
            };
        }
    }
}

/// Where a row's gradients of its thresholds go: to the channel's columns, or, where cells have their
/// own thresholds, first to those.
fn sums_of<'a, R: Float>(
    model: &Model<R>,
    (own, sums): (&'a mut [Vec<R>; 2], &'a mut [ChannelSum<R>]),
    k: usize,
    y: usize,
) -> &'a mut [Vec<R>; 2] {
    if model.is_mismatched(k) {
        own
    } else {
        &mut sums[k].columns[y % 2]
    }
}

impl<R: Float> BackPass<'_, R> {
    /// The released code's multipliers of the logarithm `T` and of the memory, `d = T - M`.
    fn gain(&mut self, tape: &Tape<R>, pair: usize, k: usize, y: usize) {
        let place = self.place(k, y);
        let all = self.model.channels() * self.piece.rows.len() * self.from.len();
        let distance = &tape.distance[pair * all..][place];
        let [logarithm, memory] = &mut self.sums[k].gains;
        for ((h, drive), d) in self.h.iter().zip(&self.drive).zip(distance) {
            let (h, drive) = (h.to_f64(), drive.to_f64());
            let seen = elementary::ln(drive.max(1e-8) + 1.0);
            *logarithm += h * seen;
            *memory -= h * (seen - d.to_f64());
        }
    }
}

/// What a row of cells had in a pair, and what the loss asks of it.
struct Rows<'a, R> {
    from: &'a [R],
    to: &'a [R],
    thresholds: (&'a [R], &'a [R]),
    per: (&'a [R], &'a [R]),
    counts: &'a [i32],
    timing: &'a [R],
    earlier: &'a [R],
    later: &'a [R],
    signed: &'a [R],
}

/// What a row gives.
struct Output<'a, R> {
    h: &'a mut [R],
    memory: &'a mut [R],
    before: &'a mut [R],
    on: &'a mut [R],
    off: &'a mut [R],
}

/// Whether all are finite: 0 times infinity or NaN is NaN.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn finite<R: Real>(values: &[R]) -> bool {
    let mut all = true;
    for value in values {
        all &= *value * R::ZERO == R::ZERO;
    }
    all
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn back<R: Real, const KIND: u8, const RULE: u8>(
    rows: &Rows<'_, R>,
    pair: &Pair<R>,
    out: Output<'_, R>,
) {
    let cells = rows.to.len();
    // All slices have one length, so that the loop has no bounds checks.
    let (from, to) = (&rows.from[..cells], &rows.to[..cells]);
    let (on, off) = (&rows.thresholds.0[..cells], &rows.thresholds.1[..cells]);
    let (per_on, per_off) = (&rows.per.0[..cells], &rows.per.1[..cells]);
    let (counts, timing) = (&rows.counts[..cells], &rows.timing[..cells]);
    let (earlier, later) = (&rows.earlier[..cells], &rows.later[..cells]);
    let signed = &rows.signed[..cells];
    let (h, memory, before) = (
        &mut out.h[..cells],
        &mut out.memory[..cells],
        &mut out.before[..cells],
    );
    let (sum_on, sum_off) = (&mut out.on[..cells], &mut out.off[..cells]);
    for x in 0..cells {
        let cell = Cell {
            from: from[x],
            to: to[x],
            on: on[x],
            off: off[x],
            per_on: per_on[x],
            per_off: per_off[x],
            count: R::from_i32(counts[x]).abs(),
            timing: timing[x],
            earlier: earlier[x],
            later: later[x],
            signed: signed[x],
        };
        let slopes = slopes::<R, KIND, RULE>(&cell, pair);
        let after = memory[x];
        h[x] = slopes.to + slopes.follow * after + before[x];
        let theta = slopes.theta + slopes.rest * after;
        memory[x] = (R::ONE - slopes.follow) * after - slopes.to - slopes.from;
        before[x] = slopes.from;
        let above = to[x] >= R::ZERO;
        sum_on[x] = sum_on[x] + if above { theta } else { R::ZERO };
        sum_off[x] = sum_off[x] + if above { R::ZERO } else { theta };
    }
}

/// What is left of each distance once its events have moved the memory.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn remainders<R: Real>(
    distances: &[R],
    (on, off): (&[R], &[R]),
    (per_on, per_off): (&[R], &[R]),
    out: &mut [R],
) {
    let cells = distances.len();
    let (on, off, out) = (&on[..cells], &off[..cells], &mut out[..cells]);
    let (per_on, per_off) = (&per_on[..cells], &per_off[..cells]);
    for x in 0..cells {
        let d = distances[x];
        let theta = if d >= R::ZERO { on[x] } else { off[x] };
        let whole = fire::whole(d, per_on[x], per_off[x]);
        out[x] = d - (whole * theta).mul_sign(d);
    }
}
