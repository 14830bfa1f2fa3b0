//! Voxels: events in bins of time.
//!
//! In a window from `a` to `b` with `n` bins, with [`Share::Bilinear`], an event at `t` stands at
//! `u = (n - 1) (t - a) / (b - a)` and gives `1 - |i - u|` to the two bins `i` that are nearest
//! (Zhu et al., CVPR 2019): the first bin has its middle at `a`, the last at `b`. With
//! [`Share::Whole`] a bin is an `n`-th of the window, and an event counts where it falls: bin `i` has
//! the events after its start, `a + i (b - a) / n`, and up to its end, as a window has.
//!
//! Shares are added up exactly, in whole numbers, and rounded to `f32` once: a voxel whose shares
//! cancel is 0.

use std::str::FromStr;

use rayon::prelude::*;

use super::{
    error::{MOST_BINS, TensorError, check_room, named},
    normalise::Normalise,
    sides::Sides,
    sorted,
    sums::Sums,
    windows::Windows,
};
use crate::{
    event::{Event, Packet, outside},
    number::greatest_common_divisor,
    plane::Size,
};

/// How an event is shared between bins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Share {
    /// Between the two nearest.
    #[default]
    Bilinear,
    /// All of it to the bin in which it falls: a bin is over when its time is.
    Whole,
}

const NAMES: [(&str, Share); 2] = [("bilinear", Share::Bilinear), ("whole", Share::Whole)];

impl FromStr for Share {
    type Err = TensorError;

    fn from_str(text: &str) -> Result<Self, TensorError> {
        named(&NAMES, "way to share an event", text)
    }
}

/// How events become voxels: of each window `[channel][side][bin][y, x]`, in events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Voxels {
    /// Bins of a window.
    bins: usize,
    /// The windows.
    pub windows: Windows,
    /// How an event is shared between bins.
    pub share: Share,
    /// ON and OFF.
    pub sides: Sides,
    /// What a window's voxels are brought to.
    pub normalise: Normalise,
}

impl Voxels {
    /// Signed voxels in events, bilinear.
    ///
    /// # Errors
    /// When there are no bins, or more than a thousand.
    pub fn new(bins: usize, windows: Windows) -> Result<Self, TensorError> {
        if !(1..=MOST_BINS).contains(&bins) {
            return Err(TensorError::Bins { bins });
        }
        Ok(Self {
            bins,
            windows,
            share: Share::default(),
            sides: Sides::default(),
            normalise: Normalise::default(),
        })
    }

    /// Bins of a window.
    #[must_use]
    pub const fn bins(&self) -> usize {
        self.bins
    }

    /// The shape of a window's voxels: kinds of cells, sides, bins, rows, columns.
    #[must_use]
    pub const fn shape(&self, size: Size, channels: u8) -> [usize; 5] {
        let sides = self.sides.count();
        [channels as usize, sides, self.bins, size.height, size.width]
    }

    /// Values of a window.
    #[must_use]
    pub fn len(&self, size: Size, channels: u8) -> usize {
        let sides = self.shape(size, channels);
        sides.into_iter().fold(1, usize::saturating_mul)
    }

    /// Bytes that are held when the first `count` windows are made: their voxels, and the sums of
    /// the windows that are worked on at once.
    #[must_use]
    pub fn held(&self, size: Size, channels: u8, count: u64) -> u128 {
        let each = self.len(size, channels) as u128;
        // Wide sums do not become voxels in place.
        let is_wide = self.places(0).parts > NARROW_PARTS;
        let sum = if is_wide { 8 + 4 } else { 4 };
        if count == 1 {
            return each.saturating_mul(sum);
        }
        let at_once = u128::from(count).min(rayon::current_num_threads() as u128);
        let bytes = u128::from(count) * 4 + at_once * sum;
        each.saturating_mul(bytes)
    }

    /// The voxels of all windows of a packet, up to the end of what was watched.
    ///
    /// # Errors
    /// When an event lies outside of the packet, or the windows are more than this machine holds.
    pub fn of(&self, packet: &Packet) -> Result<Vec<f32>, TensorError> {
        let last = packet.events.iter().map(|event| event.t).max();
        let end = last.unwrap_or_default().max(packet.span.1);
        self.first(packet, self.windows.count(end))
    }

    /// The voxels of a packet's first `count` windows.
    ///
    /// # Errors
    /// When an event lies outside of the packet, or the windows are more than this machine holds.
    pub fn first(&self, packet: &Packet, count: u64) -> Result<Vec<f32>, TensorError> {
        let place = (packet.size, packet.channels);
        let each = self.len(place.0, place.1);
        check_room(
            count,
            "windows of voxels",
            self.held(place.0, place.1, count),
        )?;
        outside::check(&packet.events, packet.size, packet.channels)?;
        let events = sorted(&packet.events);
        let window = |n| {
            let mut sums = Sums::new(each);
            self.add(&events, n, place, &mut sums);
            self.finish(place, n, sums)
        };
        // The sums of one become its voxels: no second array.
        if count == 1 {
            return Ok(window(0));
        }
        let mut voxels = vec![0.0; count as usize * each];
        let windows = voxels.par_chunks_mut(each.max(1)).enumerate();
        windows.for_each(|(n, out)| out.copy_from_slice(&window(n as u64)));
        Ok(voxels)
    }

    /// Adds what these events, in the order of their times, give to window `n`.
    pub(super) fn add(&self, events: &[Event], n: u64, (size, _): (Size, u8), sums: &mut Sums) {
        let (from, to) = self.windows.bounds(n);
        let up_to = |time: i64| events.partition_point(|event| event.t.0 as i64 <= time);
        let events = &events[up_to(self.windows.after(n))..up_to(to)];
        let (pixels, places) = (size.pixels(), self.places(n));
        for event in events {
            let since = event.t.0 as i64 - from;
            let sign = i64::from(self.sides.sign(event.polarity));
            let plane = usize::from(event.channel) * self.sides.count();
            let plane = plane + self.sides.plane(event.polarity);
            let pixel = usize::from(event.y) * size.width + usize::from(event.x);
            let (bin, after) = match self.share {
                Share::Bilinear => places.of(since),
                // It is after the start, or at that of the first window.
                Share::Whole => (places.of((since * self.bins as i64 - 1).max(0)).0, 0),
            };
            let first = (plane * self.bins + bin) * pixels + pixel;
            sums.add(first, sign * (places.parts - after));
            // The last bin has none after it, and gives it nothing.
            if after > 0 {
                sums.add(first + pixels, sign * after);
            }
        }
    }

    /// Where the events of window `n` are among its bins.
    fn places(&self, n: u64) -> Places {
        let (from, to) = self.windows.bounds(n);
        let length = to.saturating_sub(from);
        match self.share {
            Share::Bilinear => Places::new(self.bins as i64 - 1, length),
            Share::Whole => Places {
                parts: 1,
                ..Places::new(1, length)
            },
        }
    }

    /// The voxels of window `n`, which is over, normalised kind by kind.
    pub(super) fn finish(&self, (size, channels): (Size, u8), n: u64, sums: Sums) -> Vec<f32> {
        let mut out = sums.into_events(self.places(n).parts);
        if self.normalise != Normalise::None {
            let each = self.len(size, channels) / usize::from(channels).max(1);
            let kinds = out.par_chunks_mut(each.max(1));
            kinds.for_each(|kind| self.normalise.apply(kind));
        }
        out
    }
}

/// Places among the bins of a window, in whole numbers: after so many microseconds it is
/// `steps / length` times as many bins on.
#[derive(Clone, Copy)]
struct Places {
    steps: i64,
    length: i64,
    /// The same fraction, about.
    per: f64,
    /// Into how many parts an event is cut.
    parts: i64,
}

/// The most parts of an event: of windows longer than this in microseconds, 71 minutes, shares are
/// cut to such a part. 2^31 whole events then fit in a sum.
const MOST_PARTS: i64 = 1 << 32;

/// From more parts on a few events in one voxel are more than a narrow sum holds.
const NARROW_PARTS: i64 = 1 << 27;

impl Places {
    fn new(steps: i64, length: i64) -> Self {
        let common = greatest_common_divisor(steps, length).max(1);
        let (steps, length) = (steps / common, length / common);
        Self {
            steps,
            length,
            per: steps as f64 / length as f64,
            parts: length.min(MOST_PARTS),
        }
    }

    /// The bin at or before a time since the window's start, and the parts of an event that the
    /// bin after it gets.
    #[inline]
    fn of(&self, since: i64) -> (usize, i64) {
        // One too many or too few where floating point rounds.
        let mut bin = (since as f64 * self.per) as i64;
        let mut after = since * self.steps - bin * self.length;
        if after < 0 {
            (bin, after) = (bin - 1, after + self.length);
        } else if after >= self.length {
            (bin, after) = (bin + 1, after - self.length);
        }
        if self.length > MOST_PARTS {
            let parts = i128::from(after) * i128::from(MOST_PARTS);
            after = (parts / i128::from(self.length)) as i64;
        }
        (bin as usize, after)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rayon::ThreadPoolBuilder;

    use super::*;
    use crate::{
        event::{
            Polarity,
            tensor::{Alignment, VoxelStream},
        },
        unit::Micros,
    };

    const SIZE: Size = Size {
        height: 3,
        width: 4,
    };

    fn events() -> impl Strategy<Value = Vec<Event>> {
        let event = (0u64..100_000, 0u16..4, 0u16..3, 0u8..2, any::<bool>()).prop_map(
            |(t, x, y, channel, on)| Event {
                t: Micros(t),
                x,
                y,
                polarity: Polarity::of(on),
                channel,
            },
        );
        proptest::collection::vec(event, 0..200)
    }

    fn how() -> impl Strategy<Value = Voxels> {
        let names = (any::<bool>(), any::<bool>(), any::<bool>());
        (1usize..7, 0.001f64..0.1, 0.002f64..0.1, names).prop_map(
            |(bins, length, every, (centred, whole, split))| {
                let alignment = if centred {
                    Alignment::Centred
                } else {
                    Alignment::Causal
                };
                let windows = Windows::new(length, every, alignment).unwrap();
                let mut voxels = Voxels::new(bins, windows).unwrap();
                voxels.share = if whole { Share::Whole } else { Share::Bilinear };
                voxels.sides = if split { Sides::Split } else { Sides::Signed };
                voxels
            },
        )
    }

    /// Event by event, window by window, bin by bin, as the equation stands.
    fn slow(how: &Voxels, packet: &Packet) -> Vec<f64> {
        let count = how.windows.count(packet.span.1);
        let each = how.len(packet.size, packet.channels);
        let mut out = vec![0.0; count as usize * each];
        let bins = how.bins as f64;
        for (n, event) in (0..count).flat_map(|n| packet.events.iter().map(move |e| (n, e))) {
            let (a, b) = how.windows.bounds(n);
            let t = event.t.0 as i64;
            if t < a || (t == a && n > 0) || t > b {
                continue;
            }
            let part = (t - a) as f64 / (b - a) as f64;
            for bin in 0..how.bins {
                let share = match how.share {
                    Share::Bilinear if how.bins == 1 => 1.0,
                    Share::Bilinear => (1.0 - (bin as f64 - part * (bins - 1.0)).abs()).max(0.0),
                    Share::Whole => f64::from(u8::from((part * bins - 1e-9) as usize == bin)),
                };
                let (on, split) = (event.polarity == Polarity::On, how.sides == Sides::Split);
                let side = usize::from(split && on);
                let plane = usize::from(event.channel) * how.sides.count() + side;
                let place =
                    (plane * how.bins + bin) * 12 + usize::from(event.y) * 4 + usize::from(event.x);
                out[n as usize * each + place] += if split || on { share } else { -share };
            }
        }
        out
    }

    fn packet(events: Vec<Event>) -> Packet {
        let mut packet = Packet::new(SIZE, 2);
        packet.span.1 = Micros(100_000);
        packet.events = events;
        packet
    }

    proptest! {
        #[test]
        fn voxels_are_those_of_the_equation(how in how(), events in events()) {
            let packet = packet(events);
            let (got, want) = (how.of(&packet).unwrap(), slow(&how, &packet));
            prop_assert_eq!(got.len(), want.len());
            for (got, want) in got.iter().zip(want) {
                // A sum is rounded once; what cancels is 0.
                let most = want.abs() * 2_f64.powi(-24) + 1e-11;
                prop_assert!((f64::from(*got) - want).abs() < most, "{} {}", got, want);
                prop_assert!((*got == 0.0) == (want.abs() < 1e-11), "{} {}", got, want);
            }
        }

        /// Part by part, however the parts are cut, they are the same to the bit.
        #[test]
        fn a_stream_gives_the_same_windows(how in how(), mut events in events(), normal: bool, step in 1u64..40_000) {
            let mut how = how;
            how.normalise = if normal { Normalise::Deviation } else { Normalise::None };
            events.sort_by_key(|event| event.t);
            let packet = packet(events);
            let mut stream = VoxelStream::new(how, SIZE, 2);
            let mut got = Vec::new();
            let mut rest = &packet.events[..];
            let mut until = 0;
            while until < 100_000 {
                until = (until + step).min(100_000);
                let part = rest.partition_point(|event| event.t.0 <= until);
                stream.add(&rest[..part]).unwrap();
                rest = &rest[part..];
                got.extend(stream.finished(Micros(until)).into_iter().flatten());
            }
            got.extend(stream.rest(Micros(100_000)).into_iter().flatten());
            prop_assert_eq!(&got, &how.of(&packet).unwrap());
            // And passed on one by one.
            let mut stream = VoxelStream::new(how, SIZE, 2);
            let mut passed = Vec::new();
            for part in packet.events.chunks(1 + step as usize % 9) {
                let pass = |window: &[f32]| {
                    passed.extend_from_slice(window);
                    Ok::<(), TensorError>(())
                };
                stream.pass(part, pass).unwrap();
            }
            while let Some(window) = stream.next_left(Micros(100_000)) {
                passed.extend(window);
            }
            prop_assert_eq!(passed, got);
        }
    }

    /// Events on the times of frames, a number that no `f32` holds, and windows beyond the parts.
    #[test]
    fn sums_are_exact() {
        let window = |seconds, bins| {
            let windows = Windows::new(seconds, seconds, Alignment::Causal).unwrap();
            Voxels::new(bins, windows).unwrap()
        };
        let event = |t, polarity| Event {
            t: Micros(t),
            x: 0,
            y: 0,
            polarity,
            channel: 0,
        };
        let (on, off) = (Polarity::On, Polarity::Off);
        let mut packet = Packet::new(Size::new(1, 1), 1);
        packet.events = vec![event(10_000, off), event(20_000, on), event(40_000, off)];
        let mut how = window(0.1, 5);
        assert_eq!(how.of(&packet).unwrap(), [-0.4, 0.0, -0.6, 0.0, 0.0]);
        how.normalise = Normalise::Deviation;
        assert_eq!(how.of(&packet).unwrap(), [1.0, 0.0, -1.0, 0.0, 0.0]);
        packet.events = vec![event(33_333, on); 1_000_000];
        assert_eq!(
            window(0.1, 4).of(&packet).unwrap(),
            [10.0, 999_990.0, 0.0, 0.0]
        );
        // 10^9 s, at three quarters of the way to the second bin.
        packet.events = vec![
            event(375_000_000_000_000, on),
            event(250_000_000_000_000, off),
        ];
        assert_eq!(window(1e9, 3).of(&packet).unwrap(), [-0.25, 0.25, 0.0]);
    }

    /// One window is made in place, several beside the sums of those that are worked on at once.
    #[test]
    fn what_is_held_is_counted() {
        let one = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        one.install(|| {
            let held = |seconds, bins, count| {
                let windows = Windows::new(seconds, seconds, Alignment::Causal).unwrap();
                Voxels::new(bins, windows).unwrap().held(SIZE, 2, count)
            };
            let values = 5 * 12 * 2;
            assert_eq!(held(0.1, 5, 1), values * 4);
            assert_eq!(held(0.1, 5, 9), values * (9 * 4 + 4));
            assert_eq!(held(7200.0, 5, 1), values * 12);
            assert_eq!(held(7200.0, 5, 2), values * (2 * 4 + 12));
        });
        let mut packet = packet(vec![]);
        packet.size = Size::new(1 << 31, 1 << 31);
        let windows = Windows::new(0.1, 0.1, Alignment::Causal).unwrap();
        let voxels = Voxels::new(5, windows).unwrap();
        let refused = voxels.of(&packet);
        assert!(
            matches!(refused, Err(TensorError::Room { .. })),
            "{refused:?}"
        );
    }

    #[test]
    fn bins_are_counted() {
        let windows = Windows::new(1.0, 1.0, Alignment::Causal).unwrap();
        for bins in [0, 1001] {
            assert_eq!(Voxels::new(bins, windows), Err(TensorError::Bins { bins }));
        }
    }
}
