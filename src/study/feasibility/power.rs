//! Power and link, as intervals: nobody has published what the chip takes when it waits.

use super::{
    Stream,
    estimate::{Estimate, weakest},
};
use crate::{
    event::readout::Frame,
    isa::{Device, Evidence, Figure},
    plane::Size,
    program::Cost,
};

/// Electrical power of the array and of the link, at the frame rate that was asked for.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Power {
    /// Share of the time in which the array runs words.
    pub busy: f64,
    /// Of the array: from none while it waits to full power all the time.
    pub array: Estimate,
    /// The same, were the quoted power wrong by a factor of two either way.
    pub array_doubtful: Estimate,
    /// Of the array, for one frame.
    pub frame: Estimate,
    /// Of the array, for one event of the chip; none without events.
    pub event: Option<Estimate>,
}

impl Power {
    /// Of a program at a frame rate.
    pub(super) fn new(cost: &Cost, device: &Device, fps: f64, events_s: Option<f64>) -> Self {
        let full = Estimate::figure(device, Figure::Power);
        let busy = (cost.array_us * 1e-6 * fps).min(1.0);
        let evidence = weakest([full.evidence, Evidence::Modelled]);
        let watts = [busy * full.low, full.high];
        let array = Estimate::between(
            watts.map(|w| w * 1e3),
            "mW",
            evidence,
            format!(
                "{} W ({}) while the array is busy, or all the time; idle power is not public",
                full.low, full.source
            ),
        );
        Self {
            busy,
            array_doubtful: Estimate::between(
                [array.low / 2.0, array.high * 2.0],
                "mW",
                evidence,
                "the interval above, halved and doubled",
            ),
            frame: array.times(1e3 / fps, "uJ", "power / frame rate"),
            event: events_s
                .filter(|rate| *rate > 0.0)
                .map(|rate| array.times(1e6 / rate, "nJ", "power / events of the chip a second")),
            array,
        }
    }
}

/// What leaves the chip a second, in the codings that one would compare.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Link {
    /// Energy of a bit on the link.
    pub bit: Estimate,
    /// A row for each way to send.
    pub rows: Vec<LinkRow>,
}

/// One way to send.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct LinkRow {
    /// What is sent.
    pub what: String,
    /// Thousands of bits a second over the scene.
    pub kbit_s: f64,
    /// What the link takes for that.
    pub power: Estimate,
}

/// A byte a pixel.
const VIDEO_BITS: f64 = 8.0;

impl Link {
    /// Of streams by name, a bit map and plain video, at a frame rate; `bit` in pJ.
    pub(super) fn new(bit: Estimate, streams: &[(&str, &Stream)], size: Size, fps: f64) -> Self {
        let sent = streams
            .iter()
            .filter_map(|(name, stream)| Some((format!("events of {name}"), stream.mean_kbit_s?)));
        let fixed = [
            (
                "a bit map of ON and OFF, every frame".to_owned(),
                Frame::bits(size, 1) as f64 * fps * 1e-3,
            ),
            (
                "8-bit video, every frame".to_owned(),
                size.pixels() as f64 * VIDEO_BITS * fps * 1e-3,
            ),
        ];
        let rows = sent.chain(fixed).map(|(what, kbit_s)| LinkRow {
            what,
            kbit_s,
            power: bit.times(kbit_s * 1e-3, "uW", "bits a second x energy of a bit"),
        });
        Self {
            rows: rows.collect(),
            bit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::Words;

    #[test]
    fn power_lies_between_busy_time_and_all_the_time() {
        let cost = Cost {
            words: Words(100),
            array_us: 10.0,
            host_us: 500.0,
        };
        let power = Power::new(&cost, &Device::scamp5(), 1000.0, Some(2000.0));
        assert!((power.busy - 0.01).abs() < 1e-12);
        assert!((power.array.low - 12.0).abs() < 1e-9 && (power.array.high - 1200.0).abs() < 1e-9);
        // 12 uJ a frame of 1 ms, 6 uJ an event at two a frame.
        assert!((power.frame.low - 12.0).abs() < 1e-9);
        assert!((power.event.unwrap().low - 6000.0).abs() < 1e-6);
        assert_eq!(power.array.evidence, Evidence::Modelled);
        assert!((power.array_doubtful.high - 2400.0).abs() < 1e-9);
        // Never more than full power, however fast it is asked to be.
        let fast = Power::new(&cost, &Device::scamp5(), 1e9, None);
        assert!((fast.array.low - fast.array.high).abs() < 1e-9 && fast.event.is_none());
    }

    #[test]
    fn a_link_takes_energy_by_the_bit() {
        let bit = Estimate::between([1.0, 20.0], "pJ", Evidence::Guess, "test");
        let link = Link::new(bit, &[], Size::new(256, 256), 100.0);
        let rows: Vec<f64> = link.rows.iter().map(|row| row.kbit_s).collect();
        assert_eq!(rows, [13_107.2, 52_428.8]);
        assert!((link.rows[0].power.low - 13.1072).abs() < 1e-9);
        assert!((link.rows[0].power.high - 262.144).abs() < 1e-9);
    }
}
