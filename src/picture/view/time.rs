//! Times in words.

use crate::unit::Micros;

/// A time to the microsecond, without zeros at its end.
pub(super) fn seconds(t: Micros) -> String {
    format!("{} s", trimmed(t.seconds()))
}

pub(super) fn trimmed(seconds: f64) -> String {
    let text = format!("{seconds:.6}");
    let text = text.trim_end_matches('0');
    let text = text.trim_end_matches('.');
    text.to_owned()
}

/// A length of time in the unit that suits it.
pub(super) fn lasting(t: Micros) -> String {
    match t.0 {
        us if us >= 1_000_000 => format!("{} s", trimmed(t.seconds())),
        us if us >= 1000 => format!("{} ms", trimmed(t.seconds() * 1e3)),
        us => format!("{us} us"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_time_are_short() {
        let texts = [7, 1500, 20_000, 1_900_000].map(|t| lasting(Micros(t)));
        assert_eq!(texts, ["7 us", "1.5 ms", "20 ms", "1.9 s"]);
        assert_eq!(seconds(Micros(330_000)), "0.33 s");
    }
}
