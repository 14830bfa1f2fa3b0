//! Words against what comes out of the chip.

use std::fmt::Write as _;

use serde_json::json;

use super::{Arguments, Asked, bare, on_chip::OnChip};
use crate::isa::{Device, Errors};

/// Prints the front of a filter.
pub(super) fn print(arguments: &Arguments, asked: &Asked, device: &Device) -> miette::Result<()> {
    let request = bare(arguments, asked, device)?;
    let mut rows = Vec::new();
    for filter in request.front()? {
        let signal = asked.signal(&filter, &request);
        let worst = OnChip::run(&filter, device, &request.into, signal)?
            .into_iter()
            .min_by(|a, b| a.kept().total_cmp(&b.kept()));
        rows.extend(worst.map(|worst| (filter.word_count(device), filter.prescale, worst)));
    }
    // They were chosen by what is forecast; a run may tell that fewer words are as good.
    let mut best = f64::NEG_INFINITY;
    rows.retain(|(.., worst)| {
        let is_better = worst.kept() > best;
        best = best.max(worst.kept());
        is_better
    });
    if arguments.json {
        let row = |(words, bits, on_chip): &(u64, u32, OnChip)| json!({ "words": words, "prescale_bits": bits, "on_chip": on_chip });
        let rows: Vec<_> = rows.iter().map(row).collect();
        super::super::say(&format!("{}\n", json!(rows)));
        return Ok(());
    }
    let mut text = "words  halvings  correlation  at ±LSB  signal  noise  offset, LSB\n".to_owned();
    for (words, bits, on_chip) in rows {
        let correlation =
            { on_chip.correlation }.map_or("none".to_owned(), |it| format!("{it:.4}"));
        let OnChip {
            amplitude,
            signal,
            noise,
            offset,
            ..
        } = on_chip;
        let _ = writeln!(
            text,
            "{words:>5}{bits:>10}{correlation:>13}{amplitude:>9.1}{signal:>8.2}{noise:>7.2}{offset:>13.1}"
        );
    }
    let evidence = Errors::evidence_with_range(device).word();
    let _ = writeln!(
        text,
        "\nrun in the model of the chip: {evidence}; of the worst result"
    );
    super::super::say(&text);
    Ok(())
}
