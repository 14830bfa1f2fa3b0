//! Words against what comes out of the chip.

use std::fmt::Write as _;

use serde_json::json;

use super::{Arguments, Asked, bare};
use crate::{
    compile::{Forecast, Signal},
    isa::Device,
};

/// Prints the front of a filter.
pub(super) fn print(arguments: &Arguments, asked: &Asked, device: &Device) -> miette::Result<()> {
    let request = bare(arguments, asked, device)?;
    let registers = (request.input, &request.into[..]);
    let mut rows = Vec::new();
    for filter in request.front()? {
        let forecasts = match asked.input.map(Signal::from_range) {
            Some(signal) => filter.forecast(device, registers, &asked.kernels, signal),
            None => filter.best_forecast(device, registers, &asked.kernels),
        };
        let worst = forecasts
            .into_iter()
            .min_by(|a, b| a.correlation.total_cmp(&b.correlation));
        rows.push((
            filter.words.len(),
            filter.prescale,
            worst.unwrap_or_default(),
        ));
    }
    if arguments.json {
        let row = |(words, bits, forecast): &(usize, u32, Forecast)| json!({ "words": words, "prescale_bits": bits, "predicted": forecast });
        let rows: Vec<_> = rows.iter().map(row).collect();
        super::super::say(&format!("{}\n", json!(rows)));
        return Ok(());
    }
    let mut text = "words  halvings  correlation  at ±LSB  signal  noise  offset, LSB\n".to_owned();
    for (words, bits, forecast) in rows {
        let Forecast {
            amplitude,
            correlation,
            signal,
            noise,
            offset,
            ..
        } = forecast;
        let _ = writeln!(
            text,
            "{words:>5}{bits:>10}{correlation:>13.4}{amplitude:>9.1}{signal:>8.2}{noise:>7.2}{offset:>13.1}"
        );
    }
    text += "\npredicted from the chip's data (modelled, in part a guess), for the worst result\n";
    super::super::say(&text);
    Ok(())
}
