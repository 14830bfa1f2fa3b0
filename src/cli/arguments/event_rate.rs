//! `--rate`: events per pixel and second, with their unit or without.

use std::convert::Infallible;

/// The number of `2` and of `2/px/s`.
pub(in crate::cli) fn event_rate(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix("/px/s").unwrap_or(text).trim_end();
    let expected = |_| "expected events per pixel and second, such as 2 or 2/px/s".to_owned();
    number.parse().map_err(expected)
}

/// `--rate`, of a verb that has no scene to find thresholds on: it is refused with where it is.
#[derive(Clone, Debug, clap::Args)]
pub(in crate::cli) struct NoRate {
    #[arg(long = "rate", hide = true, value_name = "EVENTS", value_parser = not_here)]
    _rate: Option<Infallible>,
}

fn not_here(_: &str) -> Result<Infallible, &'static str> {
    Err(
        "`amacrine design` and `amacrine feasibility` find the thresholds of a rate, on a scene; here give thresholds",
    )
}

#[cfg(test)]
mod tests {
    use super::event_rate;

    #[test]
    fn the_unit_may_follow() {
        for text in ["2.5", "2.5/px/s", "2.5 /px/s"] {
            assert_eq!(event_rate(text), Ok(2.5), "{text}");
        }
        for text in ["", "/px/s", "2/s", "2Hz", "two"] {
            let said = event_rate(text).unwrap_err();
            assert!(said.contains("2/px/s"), "{text}: {said}");
        }
    }
}
