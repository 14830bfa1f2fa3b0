//! What the host read, in words.

use crate::array::{Reading, Readings};

/// A reading of the host, in a line.
pub fn line(reading: &Reading) -> String {
    let what = match &reading.values {
        Readings::Analog { values, .. } => match values[..] {
            [value] => format!("ADC {value}"),
            _ => format!("{} ADC values (--json lists them)", values.len()),
        },
        Readings::Digital { values, .. } => {
            format!("{} bits (--json lists them)", values.len())
        }
        Readings::Box(None) => "no pixel is set".to_owned(),
        Readings::Box(Some(w)) => format!(
            "box from row {}, column {} to row {}, column {} (the chip's count)",
            w.top, w.right, w.bottom, w.left
        ),
        Readings::Sum(sum) => format!("sum {sum}"),
        Readings::Any(any) => format!("any {any}"),
    };
    format!("{}: {what}", reading.stands())
}
