//! The nearest request that works, where nothing of a kernel comes out of the chip.

use miette::{Report, miette};

use super::{Arguments, Asked, compiled};
use crate::{compile::CompileError, isa::Device};

/// Quantisers that are tried instead, the finest first.
const COARSER: [&str; 4] = ["int-5", "int-4", "int-3", "ternary"];

/// A correlation that is worth naming.
const ENOUGH: f64 = 0.5;

/// A refusal because nothing comes out, with the finest quantiser named that gives a program from
/// which something does; any other refusal as it is.
pub(super) fn named(refused: Report, arguments: &Arguments, device: &Device) -> Report {
    let nothing = refused.downcast_ref::<CompileError>();
    if !matches!(nothing, Some(CompileError::Nothing { .. })) {
        return refused;
    }
    let tried = COARSER.into_iter().filter_map(|name| {
        let (words, correlation) = tried(name, arguments, device)?;
        Some((name, words, correlation))
    });
    let mut best: Option<(&str, usize, f64)> = None;
    for found in tried {
        if best.is_none_or(|best| found.2 > best.2) {
            best = Some(found);
        }
        if found.2 >= ENOUGH {
            break;
        }
    }
    match best {
        Some((name, words, correlation)) => miette!(
            help = format!(
                "the nearest that works: --to {name}, with a predicted correlation of {correlation:.2} in {words} words; or --objective words, which compiles it as it is"
            ),
            "{refused}"
        ),
        None => refused,
    }
}

/// The words of the filter and the correlation of the worst result, with these values.
fn tried(name: &str, arguments: &Arguments, device: &Device) -> Option<(usize, f64)> {
    let to = super::super::quantiser::quantiser(name).ok()?;
    if arguments.to.0 == Some(to) {
        return None;
    }
    let asked = Asked::as_given(arguments).ok()?;
    let asked = asked.prepared(Some(to), arguments).ok()?;
    let program = compiled(arguments, &asked, device).ok()?;
    let worst = { program.forecasts.iter() }.map(|it| it.correlation);
    Some((program.filter.words.len(), worst.fold(1.0, f64::min)))
}
