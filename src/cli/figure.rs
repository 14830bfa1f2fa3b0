//! Another value for a number of the chip, on the command line.

use crate::{array::Arithmetic, config::nearest, isa::Figure};

/// The number of the chip of this name (`error.noise`), and the value that is written for it.
pub(super) fn figure(name: &str, value: &str) -> Result<(Figure, f64), String> {
    let Some(figure) = Figure::named(name) else {
        let all: Vec<String> = Figure::ALL
            .iter()
            .map(|figure| format!("{}.{}", figure.key().0, figure.key().1))
            .collect();
        let near = nearest(name, all.iter().map(String::as_str));
        return Err(match near {
            Some(near) => format!("the chip has no number `{name}`; did you mean `{near}`?"),
            None => format!("the chip has no number `{name}`; it has {}", all.join(", ")),
        });
    };
    let number = value.parse().map_err(|_| {
        format!(
            "`{value}` is not a number: {name} is {}",
            figure.range().expected()
        )
    })?;
    Ok((figure, number))
}

/// The name of a number that says how cells err; none of another number.
pub(super) fn error_name(figure: Figure) -> Option<String> {
    let (section, key) = figure.key();
    (section == "error").then(|| format!("{section}.{key}"))
}

/// That something that was set, by which cells err, changes nothing in a domain without errors;
/// `option` sets the domain.
pub(super) fn changes_nothing(set: &str, domain: Arithmetic, option: &str) -> String {
    format!(
        "{set} changes nothing in the domain {domain}, whose cells do not err: {option} silicon has errors"
    )
}
