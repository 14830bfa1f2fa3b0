//! Whether a chip's own form of an instruction says which of its parameters the word writes.

use crate::{
    config::{Fault, Place},
    isa::{
        PrimitiveKind, Signature,
        signature::{Mode, Parameter},
    },
};

/// The fault of a form whose `out` is not on the registers that the word writes.
pub(super) fn misfit(kind: PrimitiveKind, form: &Signature, place: Place) -> Option<Fault> {
    let written = written(kind, &form.name)?.min(form.parameters.len());
    let (targets, rest) = form.parameters.split_at(written);
    let name = |it: &Parameter| format!("`{}`", it.name);
    let is_out = |it: &&Parameter| it.mode == Mode::Out;
    let what = if let Some(silent) = targets.iter().find(|it| !is_out(it)) {
        format!("`{}` writes {}, which is no `out`", form.name, name(silent))
    } else {
        let over = rest.iter().find(is_out)?;
        let many = crate::unit::counted(written, "register");
        format!(
            "`{}` writes {many}, and {} is an `out`",
            form.name,
            name(over)
        )
    };
    let help = if kind == PrimitiveKind::Bus {
        "a word of one target is written bus(out y: target, …), of two bus2(out y: target, out z: target, …), of three bus3, of any number bus({out y: target * 1..}, {x: source * 0..})"
    } else {
        "put `out` before what the word writes, as the shipped row does, and before nothing else"
    };
    Some(Fault::error(place, what, "this form").help(help))
}

/// How many of the first parameters of a form the word writes; what is not here is not known.
const WRITTEN: [(PrimitiveKind, usize); 9] = [
    (PrimitiveKind::Square, 0),
    (PrimitiveKind::Where, 0),
    (PrimitiveKind::WhereBit, 0),
    (PrimitiveKind::Blur, 1),
    (PrimitiveKind::Or, 1),
    (PrimitiveKind::Nor, 1),
    (PrimitiveKind::Dnews, 1),
    (PrimitiveKind::Set, usize::MAX),
    (PrimitiveKind::Clear, usize::MAX),
];

fn written(kind: PrimitiveKind, name: &str) -> Option<usize> {
    if kind == PrimitiveKind::Bus {
        return Some(match name {
            "bus2" => 2,
            "bus3" => 3,
            _ => 1,
        });
    }
    let found = WRITTEN.iter().find(|(known, _)| *known == kind);
    found.map(|(_, many)| *many)
}
