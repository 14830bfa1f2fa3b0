//! Only where something has changed since the last frame.
//!
//! The light of this frame and the registers before it, in and around a tile as far as the
//! body reaches: where both are as they were one frame ago, the body leaves what it left then,
//! and that is what the tile holds. All other pixels are worked on in windows: copies of a
//! part of the array with a margin as wide as the body reaches, whose own values are wrong
//! and are thrown away.
//!
//! What the host reads within a body is kept from frame to frame, and brought up to date in
//! the windows alone.

use std::ops::Range;

use super::{
    BitPlane, Domain, State, Undecided, cells::Cells, cone::Cone, rows, schedule::Plan,
    segment::Segment, semantics::Array,
};
use crate::{
    isa::{Analog, Digital, Primitive},
    plane::Size,
    program::Cell,
};

/// Rows and columns of a tile.
const TILE: usize = 16;

/// With more windows than this, all is one.
const WINDOWS: usize = 64;

/// One step of a body without loops.
pub(super) enum Item<'a, C> {
    Word(&'a Primitive, u32),
    /// The global input now holds this.
    Input(C),
    /// The host reads a register.
    Look(Cell),
}

/// What the host saw.
#[derive(Clone, Debug)]
enum Look<C> {
    Analog(Analog, Cells<C>),
    Bits(Digital, BitPlane),
}

/// What was, one frame ago.
#[derive(Clone, Debug)]
pub(super) struct Active<C> {
    cone: Cone,
    size: Size,
    light: Vec<f64>,
    /// Whether light fell since the last frame.
    exposed: bool,
    /// Tiles whose light or registers are not what they were; row by row.
    changed: Vec<bool>,
    input: Option<C>,
    looks: Vec<Look<C>>,
    /// Copies of parts of the array that are no longer needed: the next may be as large.
    spare: Vec<State<C>>,
}

/// Rows and columns of the array.
#[derive(Clone, Debug)]
struct Window {
    y: Range<usize>,
    x: Range<usize>,
}

impl Window {
    fn grown(&self, [rows, columns]: [usize; 2], size: Size) -> Self {
        let along = |range: &Range<usize>, by: usize, end: usize| {
            range.start.saturating_sub(by)..range.end.saturating_add(by).min(end)
        };
        Self {
            y: along(&self.y, rows, size.height),
            x: along(&self.x, columns, size.width),
        }
    }

    fn with(&self, other: &Self) -> Self {
        let along = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        Self {
            y: along(&self.y, &other.y),
            x: along(&self.x, &other.x),
        }
    }

    /// So wide that its rows are whole words of bits of the array.
    fn widened(self, size: Size) -> Self {
        let (start, end) = (self.x.start / 64 * 64, self.x.end.next_multiple_of(64));
        Self {
            x: start..end.min(size.width),
            ..self
        }
    }

    fn pixels(&self) -> usize {
        self.y.len() * self.x.len()
    }
}

impl<C: Clone + PartialEq + Send + Sync> Active<C> {
    pub(super) fn new(size: Size, cone: Cone) -> Self {
        let tiles = size.height.div_ceil(TILE) * size.width.div_ceil(TILE);
        Self {
            cone,
            size,
            light: Vec::new(),
            exposed: false,
            changed: vec![true; tiles],
            input: None,
            looks: Vec::new(),
            spare: Vec::new(),
        }
    }

    /// The light that has fallen and that no frame has seen yet.
    pub(super) fn unseen(&mut self) -> Option<&[f64]> {
        std::mem::take(&mut self.exposed).then_some(&self.light)
    }

    pub(super) const fn is_exposed(&self) -> bool {
        self.exposed
    }

    /// Nothing is as it was.
    pub(super) fn forget(&mut self) {
        self.changed.fill(true);
    }

    pub(super) fn expose(&mut self, light: &[f64]) {
        self.exposed = true;
        if self.light.len() != light.len() {
            self.light = light.to_vec();
            self.forget();
            return;
        }
        let across = self.size.width.div_ceil(TILE);
        let rows = light.chunks_exact(self.size.width);
        let before = self.light.chunks_exact_mut(self.size.width);
        for (y, (row, before)) in rows.zip(before).enumerate() {
            let changed = &mut self.changed[y / TILE * across..][..across];
            let tiles = row.chunks(TILE).zip(before.chunks_mut(TILE));
            for (changed, (now, before)) in changed.iter_mut().zip(tiles) {
                if now != before {
                    *changed = true;
                    before.copy_from_slice(now);
                }
            }
        }
    }

    /// Runs a body of a frame where it must be run.
    ///
    /// # Errors
    /// The line of a word that has no answer in this domain.
    pub(super) fn frame<D: Domain<Cell = C>>(
        &mut self,
        array: Array<'_, D>,
        plan: &mut Plan<C>,
        state: &mut State<C>,
        items: &[Item<'_, C>],
    ) -> Result<(), (u32, Undecided)> {
        if self.input.as_ref() != Some(&state.input) {
            self.forget();
            self.input = Some(state.input.clone());
        }
        let whole = state.flag.count() == self.size.pixels() as u64;
        let reach = if whole {
            self.cone.whole
        } else {
            self.cone.partial
        };
        let mut patches = Vec::new();
        for inner in self.windows(reach) {
            let outer = inner.grown(reach, self.size).widened(self.size);
            let copy = self.cut(array, state, &outer);
            patches.push(Patch { inner, outer, copy });
        }
        for patch in &mut patches {
            self.run(array, plan, patch, items)?;
        }
        self.changed.fill(false);
        for patch in &patches {
            self.put_back(patch, state);
        }
        self.spare = patches.into_iter().map(|patch| patch.copy).collect();
        Ok(())
    }

    /// Lets the host see in place of a register what it held at the look `k` of the body; and,
    /// called again, takes it back.
    pub(super) fn swap(&mut self, k: usize, state: &mut State<C>) {
        match &mut self.looks[k] {
            Look::Analog(register, cells) => std::mem::swap(cells, state.analog_mut(*register)),
            Look::Bits(register, bits) => std::mem::swap(bits, state.digital_mut(*register)),
        }
    }

    /// Rectangles that hold all pixels that may come out otherwise than last time.
    fn windows(&self, reach: [usize; 2]) -> Vec<Window> {
        let across = self.size.width.div_ceil(TILE);
        let cost = |window: &Window| {
            let outer = window.grown(reach, self.size).widened(self.size);
            outer.pixels()
        };
        let mut windows: Vec<Window> = Vec::new();
        for (i, _) in self
            .changed
            .iter()
            .enumerate()
            .filter(|(_, changed)| **changed)
        {
            let (y, x) = (i / across * TILE, i % across * TILE);
            let tile = Window {
                y: y..(y + TILE).min(self.size.height),
                x: x..(x + TILE).min(self.size.width),
            };
            let window = tile.grown(reach, self.size);
            // With a window that costs less to make larger than a new one.
            let best = windows.iter_mut().find(|other| {
                let both = other.with(&window);
                cost(&both) <= cost(other) + cost(&window)
            });
            match best {
                Some(other) => *other = other.with(&window),
                None => windows.push(window),
            }
            if windows.len() > WINDOWS {
                break;
            }
        }
        let mut k = 0;
        while k < windows.len() {
            let window = windows[k].clone();
            let other = (0..windows.len()).find(|j| {
                *j != k && {
                    let both = windows[*j].with(&window);
                    cost(&both) <= cost(&windows[*j]) + cost(&window)
                }
            });
            match other {
                Some(other) => {
                    windows[other] = windows[other].with(&window);
                    windows.swap_remove(k);
                    k = 0;
                }
                None => k += 1,
            }
        }
        let all: usize = windows.iter().map(cost).sum();
        if windows.len() > WINDOWS || 2 * all > self.size.pixels() {
            return vec![Window {
                y: 0..self.size.height,
                x: 0..self.size.width,
            }];
        }
        windows
    }

    /// A part of the array, newly exposed.
    fn cut<D: Domain<Cell = C>>(
        &mut self,
        array: Array<'_, D>,
        state: &State<C>,
        outer: &Window,
    ) -> State<C> {
        let size = Size::new(outer.y.len(), outer.x.len());
        let like = |spare: &State<C>| spare.layout.size == size;
        let spare = self.spare.iter().position(like);
        let mut copy = match spare {
            Some(k) => self.spare.swap_remove(k),
            None => self.blank(state, size),
        };
        for cell in &self.cone.used {
            match *cell {
                Cell::Analog(register) => {
                    let from = state.analog(register);
                    let to = copy.analog_mut(register).chunks_exact_mut(size.width);
                    for (y, row) in outer.y.clone().zip(to) {
                        row.clone_from_slice(&from[y * self.size.width..][outer.x.clone()]);
                    }
                }
                Cell::Digital(register) => {
                    let from = state.digital(register);
                    from.cut(&outer.y, &outer.x, copy.digital_mut(register));
                }
                Cell::Flag => {}
            }
        }
        state.flag.cut(&outer.y, &outer.x, &mut copy.flag);
        state.select.cut(&outer.y, &outer.x, &mut copy.select);
        state.rect.cut(&outer.y, &outer.x, &mut copy.rect);
        copy.input = state.input.clone();
        let settings = array.settings;
        let pix = copy.pix.chunks_exact_mut(size.width);
        for (y, pix) in outer.y.clone().zip(pix) {
            let light = &self.light[y * self.size.width..][outer.x.clone()];
            rows::expose(
                array.domain,
                settings.reset_level,
                settings.gain,
                light,
                pix,
            );
        }
        copy
    }

    /// A part of the array that holds nothing yet; registers that the body does not know have
    /// no cells.
    fn blank(&self, state: &State<C>, size: Size) -> State<C> {
        let layout = super::Layout {
            size,
            ..state.layout
        };
        let used = |cell| self.cone.used.contains(&cell);
        let cells = |k: u8| {
            if used(Cell::Analog(Analog(k))) {
                Cells::new(k.into(), state.edge.clone(), size.pixels())
            } else {
                Cells::default()
            }
        };
        let bits = |k: u8| {
            if used(Cell::Digital(Digital(k))) {
                BitPlane::apart(size, k.into())
            } else {
                BitPlane::zeros(Size::new(0, 0))
            }
        };
        State {
            layout,
            analog: (0..layout.analog).map(cells).collect(),
            pix: Cells::new(layout.analog.into(), state.edge.clone(), size.pixels()),
            input: state.input.clone(),
            edge: state.edge.clone(),
            digital: (0..layout.digital).map(bits).collect(),
            flag: BitPlane::zeros(size),
            select: BitPlane::zeros(size),
            rect: BitPlane::zeros(size),
        }
    }

    fn run<D: Domain<Cell = C>>(
        &mut self,
        array: Array<'_, D>,
        plan: &mut Plan<C>,
        patch: &mut Patch<C>,
        items: &[Item<'_, C>],
    ) -> Result<(), (u32, Undecided)> {
        let mut segment = Segment::new(&patch.copy);
        let mut look = 0;
        for item in items {
            match item {
                Item::Word(word, line) => {
                    segment.push(word, 0, *line);
                    if !segment.is_full() {
                        continue;
                    }
                }
                Item::Input(cell) => {
                    patch.copy.input = cell.clone();
                    segment.input(&patch.copy);
                    continue;
                }
                Item::Look(_) => {}
            }
            plan.run(array, &mut patch.copy, &segment)?;
            segment.clear();
            if let Item::Look(cell) = item {
                self.look(look, *cell, patch);
                look += 1;
            }
        }
        plan.run(array, &mut patch.copy, &segment)
    }

    /// Keeps what the host sees of a register, inside a window.
    fn look(&mut self, k: usize, cell: Cell, patch: &Patch<C>) {
        if self.looks.len() == k {
            // The first time the window is the whole array.
            self.looks.push(match cell {
                Cell::Analog(register) => {
                    let nothing = patch.copy.edge.clone();
                    Look::Analog(register, Cells::new(k, nothing, self.size.pixels()))
                }
                Cell::Digital(register) => Look::Bits(register, BitPlane::zeros(self.size)),
                Cell::Flag => unreachable!("the host does not read FLAG"),
            });
        }
        match &mut self.looks[k] {
            Look::Analog(register, cells) => {
                let new = patch.copy.analog(*register);
                patch.cells(new, cells, self.size, &mut []);
            }
            Look::Bits(register, bits) => {
                patch.bits(patch.copy.digital(*register), bits, &mut []);
            }
        }
    }

    /// What a window has come to; tiles that it has changed are marked.
    fn put_back(&mut self, patch: &Patch<C>, state: &mut State<C>) {
        let (new, changed) = (&patch.copy, &mut self.changed[..]);
        patch.cells(&new.pix, &mut state.pix, self.size, &mut []);
        for cell in &self.cone.written {
            match *cell {
                Cell::Analog(register) => {
                    let old = state.analog_mut(register);
                    patch.cells(new.analog(register), old, self.size, changed);
                }
                Cell::Digital(register) => {
                    let old = state.digital_mut(register);
                    patch.bits(new.digital(register), old, changed);
                }
                Cell::Flag => patch.bits(&new.flag, &mut state.flag, changed),
            }
        }
    }
}

/// A part of the array, on its own.
struct Patch<C> {
    /// The pixels that come out right.
    inner: Window,
    /// Those of the copy.
    outer: Window,
    copy: State<C>,
}

impl<C: Clone + PartialEq> Patch<C> {
    /// The columns of the inner window, tile by tile.
    fn tiles(&self) -> impl Iterator<Item = Range<usize>> {
        let Range { start, end } = self.inner.x;
        let first = start / TILE * TILE;
        (first..end)
            .step_by(TILE)
            .map(move |x| x.max(start)..(x + TILE).min(end))
    }

    /// Brings a plane of the array to the inner part of one of the copy; tiles in which it
    /// differed are marked, if there are marks.
    fn cells(&self, new: &[C], old: &mut [C], size: Size, changed: &mut [bool]) {
        let (x, across) = (&self.inner.x, size.width.div_ceil(TILE));
        for y in self.inner.y.clone() {
            let new = &new[(y - self.outer.y.start) * self.outer.x.len()..];
            let new = &new[x.start - self.outer.x.start..][..x.len()];
            let old = &mut old[y * size.width..][x.clone()];
            if let Some(changed) = changed.get_mut(y / TILE * across..) {
                for tile in self.tiles() {
                    let at = tile.start - x.start..tile.end - x.start;
                    if let Some(changed) = changed.get_mut(tile.start / TILE) {
                        *changed = *changed || old[at.clone()] != new[at];
                    }
                }
            }
            old.clone_from_slice(new);
        }
    }

    /// The same of bits.
    fn bits(&self, new: &BitPlane, old: &mut BitPlane, changed: &mut [bool]) {
        // Words of the copy begin where words of the array do.
        let (first, inner) = (self.outer.x.start, &self.inner.x);
        let across = old.size().width.div_ceil(TILE);
        for y in self.inner.y.clone() {
            let from = new.row(y - self.outer.y.start);
            let to = &mut old.row_mut(y)[first / 64..][..from.len()];
            for (k, (to, from)) in to.iter_mut().zip(from).enumerate() {
                let x = first + 64 * k;
                // The bits of the inner window.
                let low = inner.start.saturating_sub(x).min(64) as u32;
                let high = (x + 64).saturating_sub(inner.end).min(64) as u32;
                let mask =
                    (!0u64).checked_shl(low).unwrap_or(0) & (!0u64).checked_shr(high).unwrap_or(0);
                let differs = (*to ^ from) & mask;
                *to ^= differs;
                for tile in (0..64).step_by(TILE) {
                    if differs >> tile & ((1 << TILE) - 1) != 0
                        && let Some(changed) =
                            changed.get_mut(y / TILE * across + (x + tile) / TILE)
                    {
                        *changed = true;
                    }
                }
            }
        }
    }
}
