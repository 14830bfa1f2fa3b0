//! The plain version: the released simulator's order of work, and its gradient. Each operation is a
//! pass over a whole plane in double precision, and all planes are kept for the way back.

use amacrine::{plane::Size, reference::Description};

pub struct Plain {
    size: Size,
    side: usize,
    kernels: Vec<Vec<f64>>,
    theta: f64,
    silence: f64,
}

type Planes = Vec<f64>;

/// What is kept of a pair.
struct Kept {
    d: Planes,
    alpha: Planes,
    spacing: Planes,
    wait: Planes,
    before: Planes,
    count: Planes,
}

fn zip(a: &[f64], b: &[f64], f: impl Fn(f64, f64) -> f64) -> Planes {
    a.iter().zip(b).map(|(a, b)| f(*a, *b)).collect()
}

fn map(a: &[f64], f: impl Fn(f64) -> f64) -> Planes {
    a.iter().map(|a| f(*a)).collect()
}

impl Plain {
    pub fn new(description: &Description, size: Size) -> Self {
        let kernels = description.channels.iter().map(|c| c.kernels[0].weights());
        Self {
            size,
            side: description.channels[0].kernels[0].weights().nrows(),
            kernels: kernels.map(|w| w.iter().copied().collect()).collect(),
            theta: description.channels[0].thresholds[0].on,
            silence: description.refractory.us * 1e-6,
        }
    }

    /// Bytes of all planes that are kept at once.
    pub fn bytes(&self, frames: usize) -> usize {
        let planes = frames * (1 + self.kernels.len() * (2 + 6 + 3));
        planes * self.size.pixels() * 8
    }

    /// The gradients of the kernels, one after the other.
    pub fn run(&self, light: &[f64], times: &[f64], asked: &[f64]) -> Vec<f64> {
        let pixels = self.size.pixels();
        let signal: Vec<Planes> = light
            .chunks(pixels)
            .map(|l| map(l, |l| l / 255.0))
            .collect();
        let padded: Vec<Planes> = signal.iter().map(|s| self.pad(s)).collect();
        let kinds = self.kernels.len();
        let mut all = Vec::new();
        for (k, kernel) in self.kernels.iter().enumerate() {
            let drive: Vec<Planes> = padded.iter().map(|p| self.correlate(p, kernel)).collect();
            let kept = self.forward(&drive, times);
            let voxels = voxels(&kept, times, pixels);
            std::hint::black_box(voxels.len());
            let bin = |n: usize| &asked[(n * kinds + k) * pixels..][..pixels];
            all.extend(self.backward(&kept, &padded, times, &bin));
        }
        all
    }

    fn forward(&self, drive: &[Planes], times: &[f64]) -> Vec<Kept> {
        let (theta, r) = (self.theta, self.silence);
        let mut steps = vec![0.0; drive[0].len()];
        let mut fired = vec![f64::NEG_INFINITY; steps.len()];
        let mut all = Vec::new();
        for (n, time) in times.windows(2).enumerate() {
            let dt = time[1] - time[0];
            let memory = zip(&drive[0], &steps, |base, n| base + n * theta);
            let d = zip(&drive[n + 1], &memory, |s, m| s - m);
            let alpha = map(&d, |d| dt / ((d.abs() + 1e-9) / theta));
            let spacing = map(&alpha, |a| ((r / a).floor() + 1.0) * a);
            let wait = map(&fired, |f| (r - (time[0] - f)).max(0.0));
            let before = zip(&wait, &alpha, |w, a| (w / a).floor() * a);
            let count = zip(&spacing, &before, |s, b| {
                if s <= dt - b {
                    ((dt - b) / s).floor()
                } else {
                    0.0
                }
            });
            steps = zip(&steps, &zip(&count, &d, f64::copysign), |m, n| m + n);
            let first = zip(&before, &spacing, |b, s| (b + s) / dt);
            let rest = zip(&spacing, &count, |s, n| s / dt * (n - 1.0));
            let last = zip(&first, &rest, |f, r| time[0] + (f + r).min(1.0) * dt);
            for ((fired, count), last) in fired.iter_mut().zip(&count).zip(last) {
                *fired = if *count > 0.0 { last } else { *fired };
            }
            all.push(Kept {
                d,
                alpha,
                spacing,
                wait,
                before,
                count,
            });
        }
        all
    }

    fn backward<'a>(
        &self,
        kept: &[Kept],
        padded: &[Planes],
        times: &[f64],
        bin: &dyn Fn(usize) -> &'a [f64],
    ) -> Vec<f64> {
        let (theta, r) = (self.theta, self.silence);
        let mut kernel = vec![0.0; self.side * self.side];
        let mut first = vec![0.0; self.size.pixels()];
        for (n, pair) in kept.iter().enumerate() {
            let dt = times[n + 1] - times[n];
            let (earlier, later) = (bin(n), bin(n + 1));
            let q = map(&pair.alpha, |a| dt / a);
            let by_count = zip(&pair.wait, &pair.alpha, |w, a| {
                (dt - w) / (r + a + 1e-9).powi(2) * a
            });
            let by_count = zip(&by_count, &q, |n, q| n / q);
            let by_alpha = zip(&pair.alpha, &q, |a, q| -a / q);
            let mut h = vec![0.0; first.len()];
            for x in 0..h.len() {
                let (n, d, sign) = (pair.count[x], pair.d[x], 1f64.copysign(pair.d[x]));
                let triangle = n * (n + 1.0) / 2.0;
                let plus = pair.before[x] / dt * n + pair.spacing[x] / dt * triangle;
                let slope = pair.before[x] / dt * by_count[x]
                    + by_alpha[x] / dt * triangle
                    + pair.spacing[x] / dt * (2.0 * n + 1.0) / 2.0 * by_count[x];
                let fired = sign * (earlier[x] * (by_count[x] - slope) + later[x] * slope);
                let turn = (1.0 - d.tanh().powi(2)) * (earlier[x] * (n - plus) + later[x] * plus);
                h[x] = if n > 0.0 {
                    turn + fired * sign / theta
                } else {
                    later[x] * sign / theta
                };
            }
            self.kernel_gradient(&padded[n + 1], &h, &mut kernel);
            first = zip(&first, &h, |f, h| f - h);
        }
        self.kernel_gradient(&padded[0], &first, &mut kernel);
        kernel
    }

    fn pad(&self, plane: &[f64]) -> Planes {
        let (Size { height, width }, reach) = (self.size, self.side / 2);
        let at = |n: usize, most: usize| n.saturating_sub(reach).min(most - 1);
        let rows = 0..height + 2 * reach;
        rows.flat_map(|y| {
            let row = &plane[at(y, height) * width..][..width];
            (0..width + 2 * reach).map(move |x| row[at(x, width)])
        })
        .collect()
    }

    fn correlate(&self, padded: &[f64], kernel: &[f64]) -> Planes {
        let mut out = vec![0.0; self.size.pixels()];
        self.taps(|tap, to, from| {
            for (to, from) in out[to].iter_mut().zip(&padded[from]) {
                *to += kernel[tap] * from;
            }
        });
        out
    }

    fn kernel_gradient(&self, padded: &[f64], h: &[f64], kernel: &mut [f64]) {
        self.taps(|tap, to, from| {
            kernel[tap] += h[to]
                .iter()
                .zip(&padded[from])
                .map(|(h, u)| h * u)
                .sum::<f64>();
        });
    }

    /// Each weight with each row of pixels, and the row of the padded plane that it reads.
    fn taps(&self, mut each: impl FnMut(usize, std::ops::Range<usize>, std::ops::Range<usize>)) {
        let Size { height, width } = self.size;
        let stride = width + 2 * (self.side / 2);
        for tap in 0..self.side * self.side {
            for y in 0..height {
                let from = (y + tap / self.side) * stride + tap % self.side;
                each(tap, y * width..(y + 1) * width, from..from + width);
            }
        }
    }
}

fn voxels(kept: &[Kept], times: &[f64], pixels: usize) -> Vec<Planes> {
    let mut bins = vec![vec![0.0; pixels]; times.len()];
    for (n, pair) in kept.iter().enumerate() {
        let dt = times[n + 1] - times[n];
        let triangle = map(&pair.count, |n| n * (n + 1.0) / 2.0);
        let plus = zip(&pair.before, &pair.count, |b, n| b / dt * n);
        let plus = zip(
            &plus,
            &zip(&pair.spacing, &triangle, |s, t| s / dt * t),
            |a, b| a + b,
        );
        let minus = zip(&pair.count, &plus, |n, p| n - p);
        for (x, d) in pair.d.iter().enumerate() {
            bins[n][x] += minus[x].copysign(minus[x] * d);
            bins[n + 1][x] += plus[x].copysign(plus[x] * d);
        }
    }
    bins
}
