//! Readouts against theory and against a twin: the arbiter's mean wait is that of the queue
//! M/D/1, within a statistical bound, and its every arrival and drop is that of a slow model
//! that goes tick by tick; nothing is lost without being counted.

use std::collections::VecDeque;

use amacrine::{
    event::{
        Event, Packet, Polarity,
        readout::{
            Arbiter, Frame, Requests, RowOrder, Scan, WhenFull, scan::Order, settings::Description,
        },
    },
    plane::Size,
    rng::{GOLDEN, mix, uniform},
    unit::{Micros, Picos},
};
use proptest::prelude::*;

fn us(n: u64) -> Picos {
    Picos(n * 1_000_000)
}

fn packet(size: Size, channels: u8, events: Vec<Event>) -> Packet {
    let mut packet = Packet::new(size, channels);
    packet.events = events;
    packet
}

/// Cells that fire at random (a Poisson process), `gap` microseconds apart in the mean.
fn poisson(seed: u64, events: u64, gap: f64) -> Packet {
    let mut t = 0.0;
    let random = |i: u64| mix(seed.wrapping_add(i.wrapping_mul(GOLDEN)));
    let events = (1..=events)
        .map(|i| {
            t -= gap * (1.0 - uniform(random(2 * i))).ln();
            let cell = random(2 * i + 1);
            Event {
                t: Micros(t.round() as u64),
                x: (cell % 128) as u16,
                y: (cell / 128 % 128) as u16,
                polarity: Polarity::On,
                channel: 0,
            }
        })
        .collect();
    packet(Size::new(128, 128), 1, events)
}

/// One event after the other, no losses.
fn single_server() -> Arbiter {
    Arbiter {
        row: us(0),
        event: us(1000),
        burst: false,
        order: RowOrder::Oldest,
        requests: Requests::All,
        link: us(0),
        fifo: None,
        when_full: WhenFull::Stall,
    }
}

/// Mean wait before service over service time, and its standard error from the spread of
/// batches that are long against the queue's memory.
fn mean_wait(packet: &Packet, arbiter: Arbiter, service: f64) -> (f64, f64) {
    let read = arbiter.read(packet);
    assert_eq!(
        read.packet.events.len(),
        packet.events.len(),
        "nothing is lost"
    );
    // In their order, so that the nth that arrives is the nth that fired.
    let waits: Vec<f64> = read
        .packet
        .events
        .iter()
        .zip(&packet.events)
        .map(|(out, fired)| (out.t.0 - fired.t.0) as f64 / service - 1.0)
        .collect();
    let batches: Vec<f64> = waits
        .chunks_exact(waits.len() / 50)
        .map(|batch| batch.iter().sum::<f64>() / batch.len() as f64)
        .collect();
    let n = batches.len() as f64;
    let mean = batches.iter().sum::<f64>() / n;
    let variance = batches.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

#[test]
fn the_mean_wait_is_that_of_m_d_1() {
    for (load, seed) in [(0.1, 1), (0.5, 2), (0.8, 3), (0.9, 4)] {
        let packet = poisson(seed, 500_000, 1000.0 / load);
        let theory = load / (2.0 * (1.0 - load));
        let by_link = Arbiter {
            event: us(0),
            link: us(1000),
            ..single_server()
        };
        let by_row = Arbiter {
            row: us(400),
            event: us(600),
            ..single_server()
        };
        for (what, arbiter) in [
            ("columns", single_server()),
            ("link", by_link),
            ("rows", by_row),
        ] {
            let (mean, error) = mean_wait(&packet, arbiter, 1000.0);
            // Four standard errors, and the rounding of firing times to 1 us of 1000.
            let bound = 4.0 * error + 0.001;
            assert!(
                (mean - theory).abs() < bound,
                "{what}, load {load}: {mean} +- {error}, theory {theory}"
            );
            assert!(
                bound < 0.08 * theory + 0.01,
                "load {load}: a bound that tells nothing: {bound}"
            );
        }
    }
}

#[test]
fn utilisation_is_the_load() {
    let packet = poisson(5, 100_000, 2000.0);
    let read = single_server().read(&packet);
    let busy = read.statistics.stages[0].busy;
    // Arrivals of a Poisson process spread by the square root of their number.
    assert!(
        (busy - 0.5).abs() < 4.0 * 0.5 / (100_000_f64).sqrt(),
        "{busy}"
    );
    assert_eq!(read.statistics.stages[1].busy, 0.0);
}

#[test]
fn bursts_carry_more_than_single_events() {
    // Whole rows fire at once: a burst of 128 pays for its row once.
    let events = (0..20)
        .flat_map(|t| {
            (0..128).map(move |x| Event {
                t: Micros(t * 10_000),
                x,
                y: t as u16,
                polarity: Polarity::Off,
                channel: 0,
            })
        })
        .collect();
    let packet = packet(Size::new(128, 128), 1, events);
    let arbiter = |burst| Arbiter {
        row: us(10),
        event: us(1),
        burst,
        ..single_server()
    };
    let worst = |burst| arbiter(burst).read(&packet).statistics.latency.unwrap().max;
    assert_eq!((worst(true), worst(false)), (us(10 + 128), us(11 * 128)));
}

/// What the arbiter is doing, in the twin.
enum Doing {
    Nothing,
    Choosing { row: u16, until: u64 },
    Reading { left: VecDeque<usize>, until: u64 },
    Stalled { left: VecDeque<usize>, event: usize },
}

/// The arbiter tick by tick (1 us), with lists that are searched from end to end.
struct Twin<'a> {
    a: &'a Arbiter,
    events: &'a [Event],
    row: u64,
    event: u64,
    link: u64,
    requests: Vec<usize>,
    up: Vec<(u16, u16, u8)>,
    queue: VecDeque<usize>,
    sending: Option<(u64, usize)>,
    arrived: Vec<(u64, usize)>,
    merged: u64,
    queue_full: u64,
    last: Option<u16>,
}

impl Twin<'_> {
    fn run(a: &Arbiter, events: &[Event]) -> (Vec<(u64, usize)>, u64, u64) {
        let ticks = |p: Picos| p.0 / 1_000_000;
        let mut twin = Twin {
            a,
            events,
            row: ticks(a.row),
            event: ticks(a.event),
            link: ticks(a.link),
            requests: Vec::new(),
            up: Vec::new(),
            queue: VecDeque::new(),
            sending: None,
            arrived: Vec::new(),
            merged: 0,
            queue_full: 0,
            last: None,
        };
        let mut doing = Doing::Nothing;
        for now in 0..4000 {
            twin.link_goes_on(now);
            for (i, e) in events.iter().enumerate().filter(|(_, e)| e.t.0 == now) {
                let cell = (e.x, e.y, e.channel);
                if a.requests == Requests::One && twin.up.contains(&cell) {
                    twin.merged += 1;
                } else {
                    twin.up.push(cell);
                    twin.requests.push(i);
                }
            }
            doing = twin.arbiter_goes_on(doing, now);
        }
        assert!(matches!(doing, Doing::Nothing) && twin.sending.is_none());
        (twin.arrived, twin.merged, twin.queue_full)
    }

    fn link_goes_on(&mut self, now: u64) {
        if let Some((until, event)) = self.sending
            && until <= now
        {
            self.arrived.push((until, event));
            self.sending = self.queue.pop_front().map(|next| (now + self.link, next));
        }
    }

    /// Whether the event found a place, or was dropped as the policy says.
    fn offer(&mut self, event: usize, now: u64) -> bool {
        if self.link == 0 {
            self.arrived.push((now, event));
        } else if self.sending.is_none() {
            self.sending = Some((now + self.link, event));
        } else if self.a.fifo.is_none_or(|d| (self.queue.len() as u64) < d) {
            self.queue.push_back(event);
        } else {
            match self.a.when_full {
                WhenFull::Stall => return false,
                WhenFull::DropNewest => {}
                WhenFull::DropOldest => {
                    if self.queue.pop_front().is_some() {
                        self.queue.push_back(event);
                    }
                }
            }
            self.queue_full += 1;
        }
        true
    }

    fn acknowledge(&mut self, event: usize) {
        let e = self.events[event];
        let cell = (e.x, e.y, e.channel);
        let at = self.up.iter().position(|c| *c == cell).unwrap();
        self.up.remove(at);
    }

    fn choose(&mut self) -> Option<u16> {
        let oldest = self.requests.iter().min().map(|i| self.events[*i].y)?;
        let row = match (self.a.order, self.last) {
            (RowOrder::Oldest, _) => oldest,
            (RowOrder::Round, last) => (0..8)
                .map(|step| (last.map_or(0, |l| l + 1) + step) % 8)
                .find(|row| self.requests.iter().any(|i| self.events[*i].y == *row))?,
        };
        self.last = Some(row);
        Some(row)
    }

    fn latch(&mut self, row: u16) -> VecDeque<usize> {
        let mut of_row: Vec<usize> = self.requests.clone();
        of_row.retain(|i| self.events[*i].y == row);
        of_row.sort_unstable();
        if !self.a.burst {
            of_row.truncate(1);
        }
        self.requests.retain(|i| !of_row.contains(i));
        of_row.sort_by_key(|i| (self.events[*i].x, self.events[*i].channel, *i));
        of_row.into()
    }

    /// All that the arbiter does at one moment.
    fn arbiter_goes_on(&mut self, mut doing: Doing, now: u64) -> Doing {
        loop {
            doing = match doing {
                Doing::Nothing => match self.choose() {
                    Some(row) => Doing::Choosing {
                        row,
                        until: now + self.row,
                    },
                    None => return Doing::Nothing,
                },
                Doing::Choosing { row, until } if until == now => Doing::Reading {
                    left: self.latch(row),
                    until: now + self.event,
                },
                Doing::Reading { mut left, until } if until == now => match left.pop_front() {
                    Some(event) => Doing::Stalled { left, event },
                    None => Doing::Nothing,
                },
                Doing::Stalled { left, event } => {
                    if !self.offer(event, now) {
                        return Doing::Stalled { left, event };
                    }
                    self.acknowledge(event);
                    if left.is_empty() {
                        Doing::Nothing
                    } else {
                        Doing::Reading {
                            left,
                            until: now + self.event,
                        }
                    }
                }
                waiting => return waiting,
            };
        }
    }
}

prop_compose! {
    fn any_arbiter()(
        row in 0..4_u64,
        event in 1..4_u64,
        link in 0..6_u64,
        burst: bool,
        round: bool,
        all: bool,
        fifo in prop::option::of(0..4_u64),
        when_full in 0..3_usize,
    ) -> Arbiter {
        Arbiter {
            row: us(row),
            event: us(event),
            burst,
            order: if round { RowOrder::Round } else { RowOrder::Oldest },
            requests: if all { Requests::All } else { Requests::One },
            link: us(link),
            fifo,
            when_full: [WhenFull::Stall, WhenFull::DropNewest, WhenFull::DropOldest][when_full],
        }
    }
}

prop_compose! {
    /// Few cells, times that crowd.
    fn any_events(most: usize)(
        mut events in prop::collection::vec(
            (0..120_u64, 0..4_u16, 0..8_u16, any::<bool>(), 0..2_u8), 0..most
        )
    ) -> Vec<Event> {
        events.sort_unstable();
        events
            .into_iter()
            .map(|(t, x, y, on, channel)| Event {
                t: Micros(t),
                x,
                y,
                polarity: if on { Polarity::On } else { Polarity::Off },
                channel,
            })
            .collect()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn the_arbiter_is_its_twin(arbiter in any_arbiter(), events in any_events(60)) {
        let packet = packet(Size::new(8, 4), 2, events);
        let read = arbiter.read(&packet);
        let (arrived, merged, queue_full) = Twin::run(&arbiter, &packet.events);
        let expected: Vec<Event> = arrived
            .iter()
            .map(|(t, i)| Event { t: Micros(*t), ..packet.events[*i] })
            .collect();
        prop_assert_eq!(&read.packet.events, &expected);
        let dropped = read.packet.dropped;
        prop_assert_eq!((dropped.merged, dropped.queue_full), (merged, queue_full));
        let longest = arrived.iter().map(|(t, i)| t - packet.events[*i].t.0).max();
        prop_assert_eq!(read.statistics.latency.map(|l| l.max), longest.map(us));
        if arbiter.when_full == WhenFull::Stall || arbiter.fifo.is_none() {
            prop_assert_eq!(dropped.queue_full, 0);
        }
    }

    /// Whatever a readout does not deliver it counts, on top of what was lost before; arrivals
    /// are in order of time; ON and OFF, rows and kinds stay what they were.
    #[test]
    fn nothing_is_lost_uncounted(
        arbiter in any_arbiter(),
        events in any_events(200),
        slots in 1..6_u32,
        period in 0..30_u64,
        from_left: bool,
        from_bottom: bool,
    ) {
        let mut packet = packet(Size::new(8, 4), 2, events);
        packet.dropped.over_limit = 5;
        let order = Order { from_left, from_bottom };
        let period = Micros(period);
        let reads = [
            arbiter.read(&packet),
            Scan { slots, slot: us(1), period, order }.read(&packet),
            Frame { period, bit: Picos(3) }.read(&packet),
        ];
        for read in reads {
            let lost = read.packet.dropped.total() - 5;
            prop_assert_eq!(lost, read.statistics.dropped.total());
            prop_assert_eq!(read.packet.events.len() as u64 + lost, packet.events.len() as u64);
            prop_assert!(read.packet.events.is_sorted_by_key(|e| e.t));
            let mut cells: Vec<_> =
                packet.events.iter().map(|e| (e.x, e.y, e.polarity, e.channel)).collect();
            for e in &read.packet.events {
                let at = cells.iter().position(|c| *c == (e.x, e.y, e.polarity, e.channel));
                prop_assert!(at.is_some(), "{e:?} was never fired");
                cells.swap_remove(at.unwrap_or(0));
            }
            for stage in &read.statistics.stages {
                prop_assert!((0.0..=1.0 + 1e-9).contains(&stage.busy), "{stage:?}");
            }
        }
    }
}

#[test]
fn absurd_times_do_not_overflow() {
    let late = |t| Event {
        t: Micros(t),
        x: 0,
        y: 0,
        polarity: Polarity::On,
        channel: 0,
    };
    let packet = packet(Size::new(1, 1), 1, vec![late(0), late(u64::MAX)]);
    for name in ["ideal", "scan", "arbiter", "frame"] {
        let mut description = Description::shipped(name).unwrap();
        for (key, value) in [("link", "1s"), ("slot", "1s"), ("bit", "1s")] {
            let _ = description.set(key, value);
        }
        let read = description.readout().unwrap().read(&packet);
        assert_eq!(read.packet.events.len(), 2, "{name}");
    }
}
