//! Times in words.

use crate::{event::Packet, unit::Micros};

/// Recordings that begin later have their times counted from their beginning.
const LATE: Micros = Micros(1_000_000_000);

/// From when on the times of a page count: 0, or the second in which a recording begins whose
/// clock counts from long before it, such as from 1970.
#[derive(Clone, Copy)]
pub(super) struct Clock {
    from: Micros,
}

impl Clock {
    pub fn of(packet: &Packet) -> Self {
        let begin = packet.span.0;
        Self {
            from: if begin < LATE {
                Micros(0)
            } else {
                Micros(begin.0 - begin.0 % 1_000_000)
            },
        }
    }

    /// Seconds on this clock.
    pub fn seconds(self, t: Micros) -> f64 {
        let since = i128::from(t.0) - i128::from(self.from.0);
        since as f64 / 1e6
    }

    /// A time on this clock to the microsecond, without zeros at its end.
    pub fn text(self, t: Micros) -> String {
        format!("{} s", trimmed(self.seconds(t)))
    }

    /// What has to be said of it once on each page.
    pub fn note(self) -> Option<String> {
        (self.from > Micros(0)).then(|| format!("times from {} s on", self.from.0 / 1_000_000))
    }
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
    }

    #[test]
    fn late_recordings_count_from_their_beginning() {
        let mut packet = Packet::new(crate::plane::Size::new(1, 1), 1);
        let clock = Clock::of(&packet);
        assert_eq!(
            (clock.text(Micros(330_000)), clock.note()),
            ("0.33 s".into(), None)
        );
        packet.span = (Micros(1_600_000_000_005_000), Micros(1_600_000_003_000_000));
        let clock = Clock::of(&packet);
        assert_eq!(clock.text(Micros(1_600_000_000_526_637)), "0.526637 s");
        // The beginning of a window may lie before that of the recording.
        assert_eq!(clock.text(Micros(1_599_999_999_985_000)), "-0.015 s");
        assert_eq!(clock.note().unwrap(), "times from 1600000000 s on");
    }
}
