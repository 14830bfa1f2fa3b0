//! The time of a call: the median of many repetitions, and their spread.

use std::time::{Duration, Instant};

/// What the repetitions of a call took.
#[derive(Clone, Copy)]
pub struct Timed {
    /// Seconds of the repetition in the middle.
    pub median: f64,
    /// Half of what lies between the quartiles, as a part of the median.
    pub spread: f64,
}

impl Timed {
    /// Repeats `call` so often and for so long at least.
    pub fn new(repetitions: usize, lasting: Duration, mut call: impl FnMut()) -> Self {
        let (begin, mut seconds) = (Instant::now(), Vec::new());
        while seconds.len() < repetitions || begin.elapsed() < lasting {
            let start = Instant::now();
            call();
            seconds.push(start.elapsed().as_secs_f64());
        }
        Self::from_seconds(seconds)
    }

    /// Of what each repetition took.
    pub fn from_seconds(mut seconds: Vec<f64>) -> Self {
        seconds.sort_by(f64::total_cmp);
        // Between two neighbours in order where a quarter falls there.
        let at = |part: f64| {
            let place = part * (seconds.len() - 1) as f64;
            let (low, high) = (place.floor() as usize, place.ceil() as usize);
            seconds[low] + (seconds[high] - seconds[low]) * place.fract()
        };
        let median = at(0.5);
        Self {
            median,
            spread: (at(0.75) - at(0.25)) / 2.0 / median,
        }
    }

    /// The spread as it is printed behind a time, `±3%`.
    pub fn plus_minus(self) -> String {
        format!("±{:.0}%", 100.0 * self.spread)
    }
}

/// What ran the bench: the processor by its name, and how many of its threads are ours.
pub fn cpu() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split(": ").nth(1))
        .unwrap_or("a processor without a name");
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{name} ({}, {threads} threads)", std::env::consts::ARCH)
}
