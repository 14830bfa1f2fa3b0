//! Whether a chip's own form of a host operation has the parameters that the operation is made of.

use crate::{
    config::{Fault, Place},
    isa::{Device, HostKind, Operand, Signature, signature::Parameter},
};

/// The fault of a form that lacks parameters, by the shipped form of its name.
pub(super) fn misfit(kind: HostKind, form: &Signature, place: Place) -> Option<Fault> {
    let scamp5 = Device::scamp5();
    let shipped = &scamp5.host(kind).forms;
    let of_name = shipped.iter().find(|it| it.name == form.name);
    let model = of_name.or(shipped.first())?;
    let needed = &model.parameters[..needed(kind, model)];
    let lacking: Vec<String> = { needed.iter().enumerate() }
        .filter(|(at, want)| !{ form.parameters.get(*at) }.is_some_and(|own| serves(own, want)))
        .map(|(_, want)| format!("`{}`", want.name))
        .collect();
    if lacking.is_empty() {
        return None;
    }
    let what = format!("`{}` lacks {}", form.name, lacking.join(", "));
    let help = format!(
        "give it the parameters of `{model}` in their order; one that nobody chooses has a default and can have one value, as in `h_dir: int[0..0] = 0`"
    );
    Some(Fault::error(place, what, "this form").help(help))
}

/// How many of the first parameters of a shipped form the operation is made of.
fn needed(kind: HostKind, model: &Signature) -> usize {
    let all = model.parameters.len();
    match kind {
        // The rest says where what is read goes, or which part is read: all is the rule.
        HostKind::ScanDigital | HostKind::ScanBlocks | HostKind::ScanBoundingBox => 1,
        HostKind::GlobalSum if model.name != "scamp5_global_sum_sparse" => 1,
        _ => all,
    }
}

/// Whether a parameter serves where another is wanted.
fn serves(own: &Parameter, want: &Parameter) -> bool {
    let same = match want.operand {
        // A buffer's name is all that is read of it, and that only if it is one.
        Operand::Word => true,
        Operand::Number(..) | Operand::Integer(..) | Operand::Literal(_) => matches!(
            own.operand,
            Operand::Number(..) | Operand::Integer(..) | Operand::Literal(_)
        ),
        Operand::Areg | Operand::Source | Operand::Target => own.operand == Operand::Areg,
        other => own.operand == other,
    };
    same && own.count == (1, 1) && !own.group
}
