//! How long the ruler takes: seconds per metric for packets of a million and ten million
//! events.
//!
//! `cargo bench --bench compare`, or with `-- --quick` for the million alone. Every figure is
//! the median over repetitions, with half the distance of its quartiles. The packets are of a 346x260 sensor at 20 events a second and
//! cell; the judged one is the reference with each event up to 2 ms later and a tenth lost.

#[path = "common/timed.rs"]
mod timed;

use std::time::Duration;

use amacrine::{
    compare::{
        Comparison, Pair, baseline, counts, equality, intervals, matching, rates,
        score::{Scales, scores},
        van_rossum, victor_purpura,
        voxel::{Bins, voxels},
    },
    event::{Event, Packet, Polarity},
    plane::Size,
    rng::{GOLDEN, mix},
    unit::Micros,
};

use crate::timed::Timed;

const SIZE: Size = Size::new(260, 346);

fn main() {
    let quick = std::env::args().any(|argument| argument == "--quick");
    println!("{}", timed::cpu());
    for (events, repetitions) in [(1_000_000, 9), (10_000_000, 5)] {
        if quick && events > 1_000_000 {
            break;
        }
        let reference = stream(events);
        let judged = later_and_fewer(&reference);
        println!("\n{events} events against {}", judged.events.len());
        let bench = Bench { repetitions };
        bench.packets(&reference, &judged);
    }
}

/// Events in order of time, cells at random.
fn stream(events: u64) -> Packet {
    let mut packet = Packet::new(SIZE, 1);
    let cells = SIZE.pixels() as u64 * 2;
    let span = events * 1_000_000 / 20 / cells;
    packet.events = (0..events)
        .map(|i| {
            let word = mix(i.wrapping_mul(GOLDEN));
            let pixel = word % SIZE.pixels() as u64;
            Event {
                t: Micros(i * span / events),
                x: (pixel % SIZE.width as u64) as u16,
                y: (pixel / SIZE.width as u64) as u16,
                polarity: if word >> 63 == 1 {
                    Polarity::On
                } else {
                    Polarity::Off
                },
                channel: 0,
            }
        })
        .collect();
    packet
}

fn later_and_fewer(packet: &Packet) -> Packet {
    let mut events: Vec<Event> = (packet.events.iter().zip(0_u64..))
        .filter_map(|(event, i)| {
            let word = mix(!i);
            let t = Micros(event.t.0 + word % 2_001);
            let kept = !(word >> 32).is_multiple_of(10);
            kept.then_some(Event { t, ..*event })
        })
        .collect();
    events.sort_by_key(|event| event.t);
    Packet {
        events,
        ..packet.clone()
    }
}

struct Bench {
    repetitions: usize,
}

impl Bench {
    /// Prints the time that `work` takes.
    fn line<T>(&self, name: &str, work: impl Fn() -> T) {
        let time = Timed::new(self.repetitions, Duration::ZERO, || {
            std::hint::black_box(work());
        });
        println!("{name:<34}{:>9.3} s {:>5}", time.median, time.plus_minus());
    }

    fn packets(&self, reference: &Packet, judged: &Packet) {
        let sorted = Pair::new(reference, judged);
        self.line("sort both packets", || Pair::new(reference, judged));
        let Ok(pair) = &sorted else {
            println!("the packets of this bench do not fit each other");
            return;
        };
        let bins = Bins::over(pair, 8);
        self.line("first divergence", || equality::first_divergence(pair));
        self.line("counts", || (counts::kinds(pair), counts::cells(pair)));
        self.line("F1 within 1 ms", || matching::matched(pair, Micros(1_000)));
        self.line("matches and errors of time", || {
            matching::matches(pair, Micros(1_000))
        });
        for tau in [5_000, 50_000].map(Micros) {
            self.line(&format!("van Rossum, {tau}"), || {
                van_rossum::distance(pair, tau)
            });
        }
        for h in [5_000, 50_000].map(Micros) {
            self.line(&format!("Victor-Purpura, {h}"), || {
                victor_purpura::distance(pair, h)
            });
        }
        self.line("voxels, 8 bins", || voxels(pair, bins));
        self.line("rate maps", || rates::rates(pair));
        self.line("divergence of intervals", || intervals::divergence(pair));
        self.line("a redraw", || baseline::redraw(pair, 0));
        self.line("a permutation", || baseline::permute(pair, 0));
        self.line("plain comparison", || {
            Comparison::from_pair(pair, Micros(1_000))
        });
        self.line("all scores, floors and ceilings", || {
            scores(pair, &Scales::default())
        });
    }
}
