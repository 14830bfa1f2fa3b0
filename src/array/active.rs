//! Only where something has changed since the last frame.
//!
//! The light of this frame and the registers before it, in and around a tile as far as the
//! body reaches: where both are as they were one frame ago, the body leaves what it left then,
//! and that is what the tile holds. Registers that the body overwrites before it reads them do
//! not matter. All other pixels are worked on in windows: copies of a part of the array with a
//! margin as wide as the body reaches, whose own values are wrong and are thrown away.
//!
//! What the host reads within a body and the body overwrites later is kept from frame to frame,
//! and brought up to date in the windows alone.

use super::{
    BitPlane, Domain, Settings, State, Undecided,
    cone::{Cone, Inputs},
    light::Light,
    patch::Patch,
    schedule::Plan,
    segment::Segment,
    sweep::Array,
    tiles::Tiles,
};
use crate::{
    aligned::Aligned,
    isa::{Analog, Digital, Primitive},
    plane::Size,
    program::Cell,
};

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
    Analog(Analog, Aligned<C>),
    Bits(Digital, BitPlane),
}

/// What was, one frame ago.
#[derive(Clone, Debug)]
pub(super) struct Active<C> {
    cone: Cone,
    size: Size,
    light: Light<C>,
    /// Where light or registers are not what they were.
    tiles: Tiles,
    input: Option<C>,
    /// Of each look of the host, if the register does not hold it any more after the body.
    looks: Vec<Option<Look<C>>>,
    /// Copies of parts of the array that are no longer needed: the next may be as large.
    spare: Vec<State<C>>,
}

impl<C: Clone + PartialEq + Send + Sync> Active<C> {
    pub(super) fn new(size: Size, cone: Cone) -> Self {
        Self {
            cone,
            size,
            light: Light::new(size),
            tiles: Tiles::new(size),
            input: None,
            looks: Vec::new(),
            spare: Vec::new(),
        }
    }

    /// What the photodiodes hold of the light that has fallen and that no frame has seen yet.
    pub(super) fn unseen(&self) -> Option<&[C]> {
        self.light.is_unseen().then_some(self.light.cells())
    }

    /// Nothing is as it was; the light has been seen.
    pub(super) fn forget(&mut self) {
        self.light.see();
        self.tiles.mark_all();
    }

    pub(super) fn expose<D: Domain<Cell = C>>(
        &mut self,
        domain: &D,
        settings: &Settings,
        light: &[f64],
    ) {
        self.light.fall(domain, settings, light, &mut self.tiles);
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
        self.light.see();
        if self.input.as_ref() != Some(&state.input) {
            self.tiles.mark_all();
            self.input = Some(state.input.clone());
        }
        let whole = state.flag.is_full();
        let mut patches = Vec::new();
        let (reach, step) = (self.inputs(whole).reach, self.step(whole));
        for inner in self.tiles.windows(reach, step) {
            let outer = inner.outer(reach, step, self.size);
            let copy = self.blank(state, outer.size());
            let mut patch = Patch::new(inner, outer, copy);
            patch.cut(state, self.light.cells(), &self.inputs(whole).cells);
            self.run(array, plan, &mut patch, items)?;
            patches.push(patch);
        }
        self.tiles.clear();
        if self.cone.written.contains(&Cell::Flag) {
            for patch in &patches {
                patch.bits(&patch.copy.flag, &mut state.flag, Some(&mut self.tiles));
            }
        }
        // Of this frame and of the next.
        let whole = whole && state.flag.is_full();
        for patch in &patches {
            self.put_back(patch, state, whole);
        }
        self.spare = patches.into_iter().map(|patch| patch.copy).collect();
        Ok(())
    }

    /// Lets the host see in place of a register what it held at the look `k` of the body; and,
    /// called again, takes it back.
    pub(super) fn swap(&mut self, k: usize, state: &mut State<C>) {
        match self.looks.get_mut(k) {
            Some(Some(Look::Analog(register, cells))) => {
                std::mem::swap(cells, state.analog_mut(*register));
            }
            Some(Some(Look::Bits(register, bits))) => {
                std::mem::swap(bits, state.digital_mut(*register));
            }
            // It holds it still.
            Some(None) | None => {}
        }
    }

    /// `whole`: FLAG is 1 in all pixels beforehand.
    const fn inputs(&self, whole: bool) -> &Inputs {
        if whole {
            &self.cone.whole
        } else {
            &self.cone.partial
        }
    }

    /// What the width of copies is a multiple of: of the bits in a word, where many words go by
    /// FLAG; else less of what is copied and worked on is thrown away.
    const fn step(&self, whole: bool) -> usize {
        let [words, masked] = self.cone.words;
        if whole && 16 * masked < words { 16 } else { 64 }
    }

    /// A copy of no part of the array yet.
    fn blank(&mut self, state: &State<C>, size: Size) -> State<C> {
        let like = |spare: &State<C>| spare.layout.size == size;
        match self.spare.iter().position(like) {
            Some(k) => self.spare.swap_remove(k),
            None => Patch::blank(state, size, &self.cone.used),
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
        let mut looks = 0;
        for item in items {
            match item {
                Item::Word(word, line) => {
                    segment.push(word, 0, *line);
                    if segment.is_full() {
                        plan.run(array, &mut patch.copy, &segment)?;
                        segment.clear();
                    }
                }
                Item::Input(cell) => {
                    patch.copy.input = cell.clone();
                    segment.input(&patch.copy);
                }
                Item::Look(cell) => {
                    if self.cone.passing[looks] {
                        plan.run(array, &mut patch.copy, &segment)?;
                        segment.clear();
                        self.look(looks, *cell, patch);
                    }
                    looks += 1;
                }
            }
        }
        plan.run(array, &mut patch.copy, &segment)
    }

    /// Keeps what the host sees of a register, inside a window.
    fn look(&mut self, k: usize, cell: Cell, patch: &Patch<C>) {
        if self.looks.len() <= k {
            // The first time the window is the whole array.
            self.looks.resize_with(k, || None);
            self.looks.push(match cell {
                Cell::Analog(register) => {
                    let nothing = patch.copy.edge.clone();
                    let cells = Aligned::new(k, nothing, self.size.pixels());
                    Some(Look::Analog(register, cells))
                }
                Cell::Digital(register) => Some(Look::Bits(register, BitPlane::zeros(self.size))),
                // The host does not read it.
                Cell::Flag => None,
            });
        }
        match &mut self.looks[k] {
            Some(Look::Analog(register, cells)) => {
                patch.cells(patch.copy.analog(*register), cells, self.size, None);
            }
            Some(Look::Bits(register, bits)) => {
                patch.bits(patch.copy.digital(*register), bits, None);
            }
            None => {}
        }
    }

    /// What a window has come to; pixels are marked where it has changed what the next frame
    /// depends on.
    fn put_back(&mut self, patch: &Patch<C>, state: &mut State<C>, whole: bool) {
        let new = &patch.copy;
        patch.cells(&new.pix, &mut state.pix, self.size, None);
        let inputs = if whole {
            &self.cone.whole
        } else {
            &self.cone.partial
        };
        for cell in &self.cone.written {
            let marks = inputs.cells.contains(cell).then_some(&mut self.tiles);
            match *cell {
                Cell::Analog(register) => {
                    let old = state.analog_mut(register);
                    patch.cells(new.analog(register), old, self.size, marks);
                }
                Cell::Digital(register) => {
                    patch.bits(new.digital(register), state.digital_mut(register), marks);
                }
                // Put back before all others.
                Cell::Flag => {}
            }
        }
    }
}
