//! The packet of one sensor in numbers, and its scores against the float sensor's.

use crate::{
    compare::{
        Pair, matching,
        metric::Metric,
        score::{self, Scales},
    },
    event::{
        Packet, Polarity,
        address::{self, AddressWord},
        codec::Rate,
    },
    stop::Stop,
    study::{equivalent::Likeness, quantisation::Headline},
    unit::Micros,
};

use super::FeasibilityError;

/// One sensor's packet in numbers.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Stream {
    /// Events.
    pub events: u64,
    /// ON events.
    pub on: u64,
    /// OFF events.
    pub off: u64,
    /// How many of them all slots of the program would lose; the readout that is told of loses none.
    pub dropped: u64,
    /// Events per pixel and second; none for a scene without duration.
    pub per_pixel_s: Option<f64>,
    /// Bits of all events as fixed address words.
    pub bits: u64,
    /// Thousands of bits per second over the scene; none for a scene without duration.
    pub mean_kbit_s: Option<f64>,
    /// Thousands of bits per second in the busiest frame.
    pub peak_kbit_s: f64,
    /// Against the float sensor; none for the float sensor itself.
    pub judged: Option<Judged>,
}

/// Events against the float sensor's.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Judged {
    /// What is kept, at which window and frame rate, and the change of threshold that costs as
    /// much.
    #[serde(flatten)]
    pub headline: Headline,
    /// The same with what it is made of, and against a float sensor of as many events.
    pub likeness: Likeness,
    /// Share of its events that the float sensor has too.
    pub precision: Scored,
    /// Share of the float sensor's events that it has.
    pub recall: Scored,
    /// Harmonic mean of the two.
    pub f1: Scored,
    /// The same where an event may be a frame early or late.
    pub f1_a_frame_apart: Scored,
}

/// A score from 0 to 1 with its floor and ceiling.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Scored {
    /// The score.
    pub value: f64,
    /// That of the float sensor against itself.
    pub ceiling: f64,
    /// What a packet scores that knows nothing of when, or nothing of where: the larger score of a
    /// redraw and of a permutation of the float sensor's events.
    pub floor: f64,
    /// How much of the way from floor to ceiling: 0 where there is no way, below 0 where it is less
    /// than chance.
    pub kept: f64,
}

/// Which times count as one.
pub(super) struct Window {
    /// Events closer than this match.
    pub within: Micros,
    /// A frame of the scene.
    pub frame: Micros,
    /// Seed of these baselines.
    pub seed: u64,
}

impl Stream {
    /// A packet, and how it scores against the float sensor's, where it is another's.
    pub(super) fn new(
        packet: &Packet,
        float: Option<(&Packet, Likeness)>,
        window: &Window,
    ) -> Result<Self, FeasibilityError> {
        let word = AddressWord::new(packet.size, packet.channels).bits();
        let costs = vec![word; packet.events.len()];
        let rate = Rate::from_packet(packet, &costs, window.frame);
        let (from, to) = packet.span;
        let seconds = Micros(to.0.saturating_sub(from.0)).seconds();
        let events = packet.events.len() as u64;
        let on = packet.events.iter().filter(|e| e.polarity == Polarity::On);
        let on = on.count() as u64;
        Ok(Self {
            events,
            on,
            off: events - on,
            dropped: 0,
            per_pixel_s: (seconds > 0.0)
                .then(|| events as f64 / (packet.size.pixels().max(1) as f64 * seconds)),
            bits: address::bits(packet),
            mean_kbit_s: rate.mean.map(|bits| bits / 1e3),
            peak_kbit_s: rate.peak / 1e3,
            judged: match float {
                Some((float, likeness)) => Some(Judged::new(float, packet, likeness, window)?),
                None => None,
            },
        })
    }
}

impl Judged {
    fn new(
        float: &Packet,
        packet: &Packet,
        likeness: Likeness,
        window: &Window,
    ) -> Result<Self, FeasibilityError> {
        let pair = Pair::new(float, packet)?;
        let scales = Scales {
            within: vec![window.within, window.frame],
            van_rossum: Vec::new(),
            victor_purpura: Vec::new(),
            bins: 1,
            seed: window.seed,
            stop: Stop::NEVER,
        };
        let scores = score::scores(&pair, &scales);
        let scored = |metric: Metric| {
            let score = scores.iter().find(|score| score.metric == metric);
            let of = |value: fn(&score::Score) -> Option<f64>| score.and_then(value);
            Scored::between(
                of(|s| s.value).unwrap_or(0.0),
                of(|s| s.identical).unwrap_or(1.0),
                [of(|s| s.redraw), of(|s| s.permuted)],
            )
        };
        Ok(Self {
            headline: Headline {
                threshold_equivalent_percent: likeness.judged_equivalent(),
                ..likeness.into()
            },
            likeness,
            precision: scored(matching::PRECISION.at(window.within)),
            recall: scored(matching::RECALL.at(window.within)),
            f1: scored(matching::F1.at(window.within)),
            f1_a_frame_apart: scored(matching::F1.at(window.frame)),
        })
    }
}

impl Scored {
    fn between(value: f64, ceiling: f64, floors: [Option<f64>; 2]) -> Self {
        let floor = floors.into_iter().flatten().fold(0.0, f64::max);
        let way = ceiling - floor;
        Self {
            value,
            ceiling,
            floor,
            kept: if way > 0.0 {
                (value - floor) / way
            } else {
                0.0
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Event, plane::Size, study::equivalent::Ladder};

    fn packet(events: &[(u64, u16, Polarity)]) -> Packet {
        let mut packet = Packet::new(Size::new(4, 4), 1);
        packet.span = (Micros(0), Micros(2_000_000));
        packet.events = events
            .iter()
            .map(|(t, x, polarity)| Event {
                t: Micros(*t),
                x: *x,
                y: 1,
                polarity: *polarity,
                channel: 0,
            })
            .collect();
        packet
    }

    const WINDOW: Window = Window {
        within: Micros(10),
        frame: Micros(1000),
        seed: 1,
    };

    #[test]
    fn rates_and_bits_of_a_packet() {
        use Polarity::{Off, On};
        let packet = packet(&[(0, 0, On), (1000, 1, On), (1000, 2, Off), (1000, 3, On)]);
        let stream = Stream::new(&packet, None, &WINDOW).unwrap();
        assert_eq!((stream.events, stream.on, stream.off), (4, 3, 1));
        // 2 + 2 bits of address and a sign.
        assert_eq!((stream.bits, stream.mean_kbit_s), (20, Some(0.01)));
        assert_eq!(stream.per_pixel_s, Some(4.0 / 32.0));
        assert!((stream.peak_kbit_s - 15.0).abs() < 1e-9);
        assert!(stream.judged.is_none());
    }

    /// Judged by a ladder of thresholds, of which this packet has none.
    fn judged(float: &Packet, packet: &Packet) -> Judged {
        let ladder = Ladder::new(float.clone(), &[], WINDOW.within, 1000.0, WINDOW.seed).unwrap();
        let likeness = ladder.judge(packet).unwrap();
        let stream = Stream::new(packet, Some((float, likeness)), &WINDOW);
        stream.unwrap().judged.unwrap()
    }

    #[test]
    fn the_sensor_itself_keeps_all_and_a_frame_s_delay_shows() {
        use Polarity::On;
        let all: Vec<_> = (1..40).map(|i| (i * 1000, (i % 4) as u16, On)).collect();
        let float = packet(&all);
        let own = judged(&float, &float);
        assert_eq!((own.f1.value, own.f1.ceiling, own.f1.kept), (1.0, 1.0, 1.0));
        assert!(own.f1.floor < 1.0);
        assert_eq!(
            (own.headline.kept, own.headline.window_us),
            (Some(1.0), Micros(10))
        );
        let late: Vec<_> = all.iter().map(|(t, x, p)| (t + 900, *x, *p)).collect();
        let late = judged(&float, &packet(&late));
        assert_eq!((late.f1.value, late.f1_a_frame_apart.value), (0.0, 1.0));
        let floor = late.f1.floor;
        assert_eq!(late.f1.kept, -floor / (1.0 - floor));
        assert!(late.headline.kept.unwrap() <= 0.0);
    }
}
