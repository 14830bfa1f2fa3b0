//! Numbers as people read them, each with its place in the JSON.

use maud::{Markup, html};

use crate::{elementary, isa::Evidence, study::feasibility::Estimate, unit};

/// Between groups of three digits.
const GROUP: char = '\u{202f}';

/// A number with four digits that count; whole ones in full.
pub(super) fn plain(at: &str, value: f64) -> Markup {
    data(at, value, &short(value))
}

/// A number with so many digits behind the point.
pub(super) fn fixed(at: &str, value: f64, decimals: usize) -> Markup {
    data(at, value, &unit::fixed(value, decimals))
}

/// The same of a number that may be missing.
pub(super) fn fixed_or_none(at: &str, value: Option<f64>, decimals: usize) -> Markup {
    value.map_or_else(none, |value| fixed(at, value, decimals))
}

/// A number in another unit than that of the JSON, which is so many times it.
pub(super) fn scaled(at: &str, value: f64, by: f64) -> Markup {
    html! { data value=(value) data-at=(at) data-by=(by) { (minus(&short(value * by))) } }
}

/// A change of threshold in per cent, as [`Likeness::equivalent`] writes it.
///
/// [`Likeness::equivalent`]: crate::study::equivalent::Likeness::equivalent
pub(super) fn equivalent(at: &str, percent: Option<f64>, is_least: bool) -> Markup {
    let Some(percent) = percent else {
        return none();
    };
    let decimals = usize::from(percent < 9.95);
    html! { @if is_least { "> " } (fixed(at, percent, decimals)) " %" }
}

/// A number that stands elsewhere on the page with its place, such as the end of an axis.
pub(super) fn plain_text(value: f64) -> String {
    minus(&short(value))
}

/// A number that may be missing.
pub(super) fn maybe(at: &str, value: Option<f64>) -> Markup {
    match value {
        Some(value) => plain(at, value),
        None => none(),
    }
}

/// Where there is no number.
pub(super) fn none() -> Markup {
    html! { span.none { "none" } }
}

/// A number or an interval, with its unit.
pub(super) fn known(at: &str, known: &Estimate) -> Markup {
    html! {
        (plain(&format!("{at}/low"), known.low))
        @if known.high > known.low {
            " to " (plain(&format!("{at}/high"), known.high))
        }
        " " (unit(known.unit))
    }
}

/// A row of a table of numbers about hardware: what it is, the number, how well it is known.
pub(super) fn row(what: &str, at: &str, value: &Estimate) -> Markup {
    html! {
        tr {
            th scope="row" { (what) span.source { (value.source) } }
            td.n { (known(at, value)) }
            td { (evidence(value.evidence)) }
        }
    }
}

/// A row for a number that is counted, not known from elsewhere.
pub(super) fn counted(what: &str, from: &str, value: &Markup) -> Markup {
    told(what, from, value, &html! { "counted" })
}

/// A row for a number that is worked out from others, of which this is the weakest evidence.
pub(super) fn worked_out(what: &str, from: &str, value: &Markup, weakest: Evidence) -> Markup {
    told(what, from, value, &evidence(weakest))
}

fn told(what: &str, from: &str, value: &Markup, how_well: &Markup) -> Markup {
    html! {
        tr {
            th scope="row" { (what) span.source { (from) } }
            td.n { (value) }
            td { (how_well) }
        }
    }
}

/// The head of such a table.
pub(super) fn head() -> Markup {
    html! {
        thead { tr {
            th scope="col" { "What" }
            th.n scope="col" { "Value" }
            th scope="col" { "Evidence" }
        } }
    }
}

/// How well a number is known.
pub(super) fn evidence(evidence: Evidence) -> Markup {
    let word = match evidence {
        Evidence::Measured => "measured",
        Evidence::Quoted => "quoted",
        Evidence::Modelled => "modelled",
        Evidence::Guess => "guess",
    };
    html! { span class={ "evidence " (word) } { (word) } }
}

/// A unit as people write it.
pub(super) fn unit(unit: &str) -> String {
    match unit.strip_prefix('u') {
        Some(rest) if !rest.is_empty() => format!("\u{b5}{rest}"),
        _ => unit.to_owned(),
    }
}

fn data(at: &str, value: f64, shown: &str) -> Markup {
    html! { data value=(value) data-at=(at) { (minus(shown)) } }
}

/// With a minus, not a hyphen.
pub(super) fn minus(shown: &str) -> String {
    shown.replace('-', "\u{2212}")
}

fn short(value: f64) -> String {
    let size = value.abs();
    if value.fract() == 0.0 && size < 1e15 {
        return grouped(&format!("{value:.0}"));
    }
    if !(1e-4..1e15).contains(&size) {
        return format!("{value:.2e}");
    }
    let decimals = (3 - elementary::log10(size).floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if !text.contains('.') {
        return grouped(&text);
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Groups of three, from five digits on.
fn grouped(text: &str) -> String {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => ("-", digits),
        None => ("", text),
    };
    if digits.len() < 5 {
        return text.to_owned();
    }
    let mut out = sign.to_owned();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(GROUP);
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_whole_ones_whole() {
        for (value, text) in [
            (0.0, "0"),
            (7.0, "7"),
            (1024.0, "1024"),
            (254_393.0, "254\u{202f}393"),
            (-12_345_678.0, "-12\u{202f}345\u{202f}678"),
            (5.5, "5.5"),
            (0.912_34, "0.9123"),
            (137.344, "137.3"),
            (20_000.4, "20\u{202f}000"),
            (0.000_012_345, "1.23e-5"),
            (-0.25, "-0.25"),
        ] {
            assert_eq!(short(value), text, "{value}");
        }
    }

    #[test]
    fn a_number_carries_its_place_and_its_whole_value() {
        let markup = plain("/a/b", 0.123_456_789).into_string();
        assert_eq!(
            markup,
            "<data value=\"0.123456789\" data-at=\"/a/b\">0.1235</data>"
        );
        let zero = fixed("/a", -0.000_2, 3).into_string();
        assert!(zero.ends_with(">0.000</data>"), "{zero}");
        let below = fixed("/a", -0.02, 2).into_string();
        assert!(below.ends_with(">\u{2212}0.02</data>"), "{below}");
        assert_eq!(unit("us"), "\u{b5}s");
        assert_eq!(unit("LSB"), "LSB");
    }
}
