//! Kinds of cells that say nothing where others of the same sensor do.

use crate::{event::Packet, rig::guard::Warning};

/// That some of several kinds have no event, given how many each has; `subject` is the sensor, and
/// `names` what its kinds are called, where they have names. Where none has any, the sensor itself is
/// silent, which is told elsewhere.
pub(super) fn warning(
    subject: &str,
    names: &[Option<&str>],
    events: &[u64],
    frames: u64,
) -> Option<Warning> {
    if events.iter().all(|count| *count == 0) {
        return None;
    }
    let silent = events.iter().enumerate().filter(|(_, count)| **count == 0);
    let subjects = silent.map(|(kind, _)| match names.get(kind).copied().flatten() {
        Some(name) => format!("{subject}, {name}"),
        None => format!("{subject}, kind {kind}"),
    });
    let subjects: Vec<String> = subjects.collect();
    (!subjects.is_empty()).then(|| Warning {
        subjects,
        ..Warning::no_events(subject, Some(frames))
    })
}

/// Events of each kind of a packet, ON and OFF.
pub(super) fn each_kind(packet: &Packet) -> Vec<[u64; 2]> {
    let mut all = vec![[0; 2]; usize::from(packet.channels)];
    for event in &packet.events {
        if let Some(own) = all.get_mut(usize::from(event.channel)) {
            own[usize::from(event.polarity == crate::event::Polarity::Off)] += 1;
        }
    }
    all
}
