//! Why a sensor that never fired was silent, and what to change; kinds of cells that say nothing where
//! others of the same sensor do.

use super::{
    guard::{About, Warning},
    rounded,
};
use crate::{event::Packet, photoreceptor::Curve, sensor::Silence, unit::counted};

impl Warning {
    /// A sensor that never fired in so many frames, of which this is known.
    #[must_use]
    pub fn no_events_of(subject: &str, frames: u64, silence: &Silence) -> Self {
        let pairs = frames.saturating_sub(1);
        let Some([why, change]) = (pairs > 0).then(|| reason(pairs, silence)).flatten() else {
            return Self::no_events(subject, Some(frames));
        };
        let seen = format!("no event at all in {}", counted(frames, "frame"));
        Self::new(About::NoEvents, subject, seen, why, change)
    }

    /// That some of several kinds have no event, given how many each has; `subject` is the sensor, and
    /// `names` what its kinds are called, where they have names. Where none has any, the sensor itself
    /// is silent, which is told elsewhere.
    #[must_use]
    pub fn silent_kinds(
        subject: &str,
        names: &[Option<&str>],
        events: &[u64],
        frames: u64,
    ) -> Option<Self> {
        if events.iter().all(|count| *count == 0) {
            return None;
        }
        let silent = events.iter().enumerate().filter(|(_, count)| **count == 0);
        let subjects = silent.map(|(kind, _)| match names.get(kind).copied().flatten() {
            Some(name) => format!("{subject}, {name}"),
            None => format!("{subject}, kind {kind}"),
        });
        let subjects: Vec<String> = subjects.collect();
        (!subjects.is_empty()).then(|| Self {
            subjects,
            ..Self::no_events(subject, Some(frames))
        })
    }

    /// The same of a packet. Where slots were lacking, the queue was full, or rows were not scanned, the
    /// events of a kind may be lost.
    #[must_use]
    pub fn silent_kinds_in(subject: &str, packet: &Packet, frames: u64) -> Option<Self> {
        let lost = packet.dropped;
        if (lost.no_slot, lost.queue_full, lost.unscanned) != (0, 0, 0) {
            return None;
        }
        let names: Vec<_> = packet.names.iter().map(|name| Some(&**name)).collect();
        let events = packet.each_kind().into_iter();
        let events: Vec<u64> = events.map(|[on, off]| on + off).collect();
        Self::silent_kinds(subject, &names, &events, frames)
    }
}

/// Why it is silent, and what to change, where that is known.
fn reason(pairs: u64, silence: &Silence) -> Option<[String; 2]> {
    if let Some(loss) = &silence.lost {
        return Some(rounded::reason(loss));
    }
    if silence.muted_pairs >= pairs {
        return Some([
            "the frame interval is not longer than the refractory period, and rule = \"authors\" allows no event then".to_owned(),
            "lower the frame rate (--fps), shorten refractory.us, or use rule = \"dead-time\"".to_owned(),
        ]);
    }
    if silence.without_sign > 0 {
        return Some([
            format!(
                "its cells cross thresholds ({}), but emit nothing: under polarity = \"pixel\" a cell has no sign while its own pixel does not change",
                counted(silence.without_sign, "crossing")
            ),
            "use polarity = \"filtered\", or a kernel that weighs the cell's own pixel".to_owned(),
        ]);
    }
    if let Some([threshold, most]) = silence.reach
        && most < threshold
    {
        return Some(unreachable(silence, threshold, most));
    }
    silence.waits.then(|| waits(pairs, silence.muted_pairs))
}

/// No light makes so much signal.
fn unreachable(silence: &Silence, threshold: f64, most: f64) -> [String; 2] {
    if most == 0.0 {
        return [
            "all weights of its kernels are 0".to_owned(),
            "give kernels with weights other than 0; no threshold helps".to_owned(),
        ];
    }
    let shown = |number: f64| (number * 1e4).round() / 1e4;
    let response = silence.response;
    let [dark, bright] = [0.0, 255.0].map(|light| response.apply(light).unwrap_or(0.0));
    let why = format!(
        "its lowest threshold, {}, is out of reach: for light from 0 to 255 the response is {} to {}, and the filtered signal changes by {} at most",
        shown(threshold),
        shown(dark),
        shown(bright),
        shown(most)
    );
    let change = if response.curve == Curve::Identity {
        "give lower thresholds"
    } else {
        "give thresholds in the unit of the response, or response = \"identity\" for thresholds in kernel times light (0 to 255)"
    };
    [why, change.to_owned()]
}

/// Under the authors' rule what is too small is not told from what comes too early in its pair.
fn waits(pairs: u64, muted: u64) -> [String; 2] {
    let no_time = match muted {
        0 => String::new(),
        muted => format!(
            " ({muted} of {} of frames are not further apart than that period)",
            counted(pairs, "pair")
        ),
    };
    let why = format!(
        "the filtered signal crosses no threshold, or only within a refractory period after a frame, where rule = \"authors\" allows no event{no_time}"
    );
    let change = "shorten refractory.us, use rule = \"dead-time\", lower the frame rate (--fps) or the threshold, or show a scene that moves";
    [why, change.to_owned()]
}
