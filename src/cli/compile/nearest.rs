//! The nearest request that works, where nothing of a kernel comes out of the chip.

use miette::{Report, miette};

use super::{Arguments, Asked, compiled, on_chip::OnChip};
use crate::{
    compile::CompileError,
    isa::{Device, Figure},
};

/// Quantisers that are tried instead, the finest first.
const COARSER: [&str; 4] = ["int-5", "int-4", "int-3", "ternary"];

/// A correlation that is worth naming.
const ENOUGH: f64 = 0.5;

/// Times the input that are tried instead, the nearest first.
const RESIZED: [f64; 8] = [0.5, 2.0, 0.25, 4.0, 0.125, 8.0, 0.0625, 16.0];

/// A refusal because nothing comes out, with the finest quantiser and the nearest input named that
/// give programs from which something does; any other refusal as it is.
pub(super) fn named(refused: Report, arguments: &Arguments, device: &Device) -> Report {
    let nothing = refused.downcast_ref::<CompileError>();
    if !matches!(nothing, Some(CompileError::Nothing { .. })) {
        return refused;
    }
    let coarser = COARSER.into_iter().filter_map(|name| {
        let (words, correlation) = coarser(name, arguments, device)?;
        Some((format!("--to {name}"), words, correlation))
    });
    let resized = RESIZED.into_iter().filter_map(|times| {
        let ((low, high), words, correlation) = resized(times, arguments, device)?;
        Some((format!("--input {low}..{high}"), words, correlation))
    });
    let ways: Vec<String> = [best(coarser), best(resized)]
        .into_iter()
        .flatten()
        .map(|(way, words, correlation)| {
            format!(
                "{way}, with a correlation of {correlation:.2} in the model of the chip, in {}",
                crate::unit::counted(words, "word")
            )
        })
        .collect();
    if ways.is_empty() {
        return refused;
    }
    miette!(
        help = format!(
            "the nearest that works: {}; or --objective words, which compiles it as it is",
            ways.join("; or ")
        ),
        "{refused}"
    )
}

/// A way, the words of its filter, and the correlation of its worst result.
type Way = (String, u64, f64);

/// The first of which enough comes out, else that of which the most does.
fn best(ways: impl Iterator<Item = Way>) -> Option<Way> {
    let mut best: Option<Way> = None;
    for found in ways {
        let is_enough = found.2 >= ENOUGH;
        if best.as_ref().is_none_or(|best| found.2 > best.2) {
            best = Some(found);
        }
        if is_enough {
            break;
        }
    }
    best
}

/// With these values.
fn coarser(name: &str, arguments: &Arguments, device: &Device) -> Option<(u64, f64)> {
    let to = crate::cli::arguments::quantiser::quantiser(name).ok()?;
    if arguments.to.0 == Some(to) {
        return None;
    }
    let asked = Asked::as_given(arguments).ok()?;
    let asked = asked.prepared(Some(to), arguments).ok()?;
    tried(&asked, arguments, device)
}

/// With an input of so many times the size.
fn resized(times: f64, arguments: &Arguments, device: &Device) -> Option<((f64, f64), u64, f64)> {
    let (low, high) = arguments.input?;
    // Never -0.
    let input = (low * times + 0.0, high * times + 0.0);
    let lowest = device.value(Figure::Lowest);
    if input.0 < lowest || input.1 > device.value(Figure::Highest) {
        return None;
    }
    let mut asked = Asked::read(arguments).ok()?;
    asked.input = Some(input);
    let (words, correlation) = tried(&asked, arguments, device)?;
    Some((input, words, correlation))
}

/// The words of the filter and the correlation of the worst result.
fn tried(asked: &Asked, arguments: &Arguments, device: &Device) -> Option<(u64, f64)> {
    let program = compiled(arguments, asked, device).ok()?;
    let worst = { program.on_chip.iter() }.map(OnChip::kept);
    Some((program.filter.word_count(device), worst.fold(1.0, f64::min)))
}
