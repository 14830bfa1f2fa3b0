//! The events of a window of time.

use super::{look::Look, time::Clock};
use crate::{
    event::{Event, Packet, Polarity},
    unit::Micros,
};

/// The window that frames and surfaces show.
pub(super) struct Window {
    pub from: Micros,
    pub to: Micros,
    /// The time constant of surfaces.
    pub tau: Micros,
}

impl Window {
    pub fn new(packet: &Packet, look: &Look<'_>) -> Self {
        let window = Micros(look.window.0.max(1));
        // Without an event the first window that there is.
        let (begin, end) = packet.span;
        let first = Micros(begin.0.saturating_add(window.0)).min(end);
        let found = || match &packet.events[..] {
            [] => first,
            events => busiest(events, window),
        };
        let to = look.at.unwrap_or_else(found);
        Self {
            from: Micros(to.0.saturating_sub(window.0)),
            to,
            tau: window,
        }
    }

    /// Whether a window that reaches below the first time holds the events of time 0 too.
    pub fn events<'a>(&self, packet: &'a Packet) -> &'a [Event] {
        let until = |t: Micros| packet.events.partition_point(|e| e.t <= t);
        let first = if self.to.0 < self.tau.0 {
            0
        } else {
            until(self.from)
        };
        packet.events.get(first..until(self.to)).unwrap_or(&[])
    }

    /// `0.120 s to 0.130 s`; `at 0 s` where no time has passed.
    pub fn text(&self, clock: Clock) -> String {
        if self.from == self.to {
            return format!("at {}", clock.text(self.to));
        }
        format!("{} to {}", clock.text(self.from), clock.text(self.to))
    }
}

/// The end of the window that holds the most events; it ends with an event.
fn busiest(events: &[Event], window: Micros) -> Micros {
    let (mut most, mut at, mut first) = (0, Micros(0), 0);
    for (last, e) in events.iter().enumerate() {
        while let Some(old) = events.get(first)
            && e.t.0 - old.t.0 >= window.0
        {
            first += 1;
        }
        if last + 1 - first > most {
            most = last + 1 - first;
            at = e.t;
        }
    }
    at
}

/// ON and OFF.
pub(super) fn signs(events: &[Event]) -> [usize; 2] {
    let on = events.iter().filter(|e| e.polarity == Polarity::On).count();
    [on, events.len() - on]
}

#[cfg(test)]
mod tests {
    use super::{
        super::{look::View, tests::packet},
        *,
    };

    #[test]
    fn the_busiest_window_ends_with_an_event() {
        let packet = packet(&[0, 10, 11, 12, 20, 21].map(|t| (t, 0, 0, true)));
        assert_eq!(busiest(&packet.events, Micros(3)), Micros(12));
        assert_eq!(busiest(&packet.events, Micros(11)), Micros(20));
        assert_eq!(busiest(&[], Micros(10)), Micros(0));
    }

    #[test]
    fn without_events_it_is_the_first_of_the_packet() {
        let look = Look {
            title: "",
            view: View::Frame,
            window: Micros(10),
            at: None,
        };
        let mut silent = packet(&[]);
        let text = |packet: &Packet| Window::new(packet, &look).text(Clock::of(packet));
        silent.span = (Micros(30), Micros(1000));
        assert_eq!(text(&silent), "0.00003 s to 0.00004 s");
        silent.span = (Micros(0), Micros(0));
        assert_eq!(text(&silent), "at 0 s");
    }

    #[test]
    fn a_window_from_the_beginning_holds_time_0() {
        let packet = packet(&[0, 10, 20].map(|t| (t, 0, 0, true)));
        let look = |at| Look {
            title: "",
            view: View::Frame,
            window: Micros(10),
            at: Some(Micros(at)),
        };
        let held = |at| Window::new(&packet, &look(at)).events(&packet).len();
        assert_eq!((held(5), held(10), held(20), held(31)), (1, 1, 1, 0));
    }
}
