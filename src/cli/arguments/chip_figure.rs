//! Another value for a number of the chip, on the command line.

use crate::isa::Figure;

/// The number of the chip of this name (`error.noise`), and the value that is written for it.
pub(in crate::cli) fn figure(name: &str, value: &str) -> Result<(Figure, f64), String> {
    let figure = Figure::find(name).map_err(|error| error.to_string())?;
    let number = value.parse().map_err(|_| {
        format!(
            "`{value}` is not a number: {name} is {}",
            figure.range().expected()
        )
    })?;
    Ok((figure, number))
}
