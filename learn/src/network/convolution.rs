//! 3x3 and 1x1 convolutions, there and back.
//!
//! A convolution with side 3 reads the nine neighbours, one with side 1 the value itself; beyond the
//! border there are zeros. Sums are taken in one order, and without fused multiply-add, so the bits
//! are the same on every machine.

use std::{array::from_fn, hint::black_box};

use amacrine::{gradient::Float, number::Real};
use multiversion::{multiversion, target::target_cfg_f};

use super::maps::{BLOCK, Maps, Shape};

/// Output channels that are worked on together.
const TOGETHER: usize = 4;

/// Partial sums of a weight's gradient.
const LANES: usize = BLOCK;

/// Places that are worked on together: their sums stay in the first cache.
const CHUNK: usize = 64 * BLOCK;

/// The weights' places in a network's parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Convolution {
    pub(super) inputs: usize,
    pub(super) outputs: usize,
    /// 3 or 1.
    pub(super) side: usize,
    /// Where its weights (outputs, inputs, rows, columns) and then its biases begin.
    pub(super) start: usize,
    /// Whether values below 0 become 0.
    pub(super) rectified: bool,
}

impl Convolution {
    fn taps(&self) -> usize {
        self.side * self.side
    }

    fn weight_count(&self) -> usize {
        self.inputs * self.outputs * self.taps()
    }

    /// Weights and biases.
    pub(super) fn parameters(&self) -> usize {
        self.weight_count() + self.outputs
    }

    fn weights<'a, R>(&self, parameters: &'a [R]) -> (&'a [R], &'a [R]) {
        parameters[self.start..][..self.parameters()].split_at(self.weight_count())
    }

    /// The weights in the order in which the loop reads them: (blocks of outputs, inputs, taps,
    /// outputs in a block); with `back`, of the convolution that takes gradients back.
    pub(super) fn packed<R: Float>(&self, parameters: &[R], back: bool) -> Vec<R> {
        let (weights, _) = self.weights(parameters);
        let taps = self.taps();
        let (inputs, outputs) = if back {
            (self.outputs, self.inputs)
        } else {
            (self.inputs, self.outputs)
        };
        let mut packed = Vec::with_capacity(outputs.next_multiple_of(TOGETHER) * inputs * taps);
        for block in 0..outputs.div_ceil(TOGETHER) {
            for i in 0..inputs {
                for tap in 0..taps {
                    for o in block * TOGETHER..(block + 1) * TOGETHER {
                        packed.push(if o >= outputs {
                            R::ZERO
                        } else if back {
                            weights[(i * self.inputs + o) * taps + taps - 1 - tap]
                        } else {
                            weights[(o * self.inputs + i) * taps + tap]
                        });
                    }
                }
            }
        }
        packed
    }

    /// The maps of this layer.
    pub(super) fn forward<R: Float>(
        &self,
        (shape, parameters, packed): (&Shape<R>, &[R], &[R]),
        input: &Maps<R>,
    ) -> Maps<R> {
        let (_, biases) = self.weights(parameters);
        let mut output = Maps::unwritten(shape, self.outputs);
        self.apply((shape, packed, self.rectified), input, biases, &mut output);
        output
    }

    /// The gradient of the input from that of the output, which is left as that of the sums before
    /// they were rectified; adds the gradient of the parameters.
    pub(super) fn backward<R: Float>(
        &self,
        (shape, packed): (&Shape<R>, &[R]),
        (input, output): (&Maps<R>, &Maps<R>),
        mut asked: Maps<R>,
        (gradient, further): (&mut [R], bool),
    ) -> Option<Maps<R>> {
        if self.rectified {
            gate(asked.values_mut(), output.values());
        }
        let gradient = &mut gradient[self.start..][..self.parameters()];
        let (weights, biases) = gradient.split_at_mut(self.weight_count());
        let taps = self.taps();
        for block in 0..self.outputs.div_ceil(TOGETHER) {
            let least = block * TOGETHER;
            let maps: [&[R]; TOGETHER] = std::array::from_fn(|o| {
                &asked.map((least + o).min(self.outputs - 1))[shape.start()..][..shape.mask().len()]
            });
            for i in 0..self.inputs {
                let mut sums = [[R::ZERO; TOGETHER]; 9];
                if self.side == 3 {
                    for dy in 0..3 {
                        let first = shape.start() + dy * shape.stride() - shape.stride() - 1;
                        let three = across(&input.map(i)[first..], maps);
                        sums[3 * dy..3 * dy + 3].copy_from_slice(&three);
                    }
                } else {
                    // The middle one of three.
                    sums[0] = across(&input.map(i)[shape.start() - 1..], maps)[1];
                }
                for (tap, sums) in sums.iter().enumerate().take(taps) {
                    for (o, sum) in sums.iter().enumerate().take(self.outputs - least) {
                        let at = ((least + o) * self.inputs + i) * taps + tap;
                        weights[at] = weights[at] + *sum;
                    }
                }
            }
        }
        for (o, bias) in biases.iter_mut().enumerate() {
            *bias = *bias + total(asked.map(o));
        }
        further.then(|| {
            let mut back = Maps::unwritten(shape, self.inputs);
            let turned = Self {
                inputs: self.outputs,
                outputs: self.inputs,
                rectified: false,
                ..self.clone()
            };
            turned.apply((shape, packed, false), &asked, &[], &mut back);
            back
        })
    }

    fn apply<R: Float>(
        &self,
        (shape, packed, rectified): (&Shape<R>, &[R], bool),
        input: &Maps<R>,
        biases: &[R],
        output: &mut Maps<R>,
    ) {
        let each = self.inputs * self.taps() * TOGETHER;
        let mut sums = [R::ZERO; TOGETHER * CHUNK];
        for (block, packed) in packed.chunks(each).enumerate() {
            let least = block * TOGETHER;
            for (n, mask) in shape.mask().chunks(CHUNK).enumerate() {
                let start = shape.start() + n * CHUNK;
                let sums = &mut sums[..TOGETHER * mask.len()];
                for (o, sums) in sums.chunks_exact_mut(mask.len()).enumerate() {
                    sums.fill(biases.get(least + o).copied().unwrap_or(R::ZERO));
                }
                let taps = packed.chunks_exact(self.taps() * TOGETHER);
                for (i, weights) in taps.enumerate() {
                    let map = input.map(i);
                    if let Some(weights) = weights.first_chunk::<{ 9 * TOGETHER }>() {
                        let stride = shape.stride();
                        add_nine(sums, (&map[start - stride - 1..], stride), weights);
                    } else if let Some(weights) = weights.first_chunk::<TOGETHER>() {
                        add_one(sums, &map[start..], weights);
                    }
                }
                for (o, sums) in sums
                    .chunks_exact(mask.len())
                    .enumerate()
                    .take(output.channels() - least)
                {
                    finish(
                        &mut output.map_mut(least + o)[start..],
                        sums,
                        mask,
                        rectified,
                    );
                }
            }
        }
    }
}

/// Adds the nine taps of a map to each of a few sums.
///
/// Each sum is loaded and stored once for nine products, and the loop has no bounds checks, so that
/// it runs in the widest vectors there are.
#[multiversion(targets(
    "x86_64+avx512f+avx512vl+avx512dq+avx512bw",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn add_nine<R: Real>(sums: &mut [R], (map, stride): (&[R], usize), weights: &[R; 9 * TOGETHER]) {
    let n = sums.len() / TOGETHER;
    let (a, rest) = sums.split_at_mut(n);
    let (b, rest) = rest.split_at_mut(n);
    let (c, d) = rest.split_at_mut(n);
    let d = &mut d[..n];
    let (north, middle, south) = (map, &map[stride..], &map[2 * stride..]);
    let (nw, nn, ne) = (&north[..n], &north[1..=n], &north[2..n + 2]);
    let (ww, here, ee) = (&middle[..n], &middle[1..=n], &middle[2..n + 2]);
    let (sw, ss, se) = (&south[..n], &south[1..=n], &south[2..n + 2]);
    let w = weights;
    for l in 0..n {
        let v = [
            nw[l], nn[l], ne[l], ww[l], here[l], ee[l], sw[l], ss[l], se[l],
        ];
        // One order of the sum, whatever the vectors.
        let row = |o: usize, t: usize| {
            let at = |t: usize| w[TOGETHER * t + o] * v[t];
            (at(t) + at(t + 1)) + at(t + 2)
        };
        let all = |o: usize| (row(o, 0) + row(o, 3)) + row(o, 6);
        a[l] = a[l] + all(0);
        b[l] = b[l] + all(1);
        c[l] = c[l] + all(2);
        d[l] = d[l] + all(3);
    }
}

/// Adds one tap of a map to each of a few sums.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn add_one<R: Real>(sums: &mut [R], map: &[R], weights: &[R; TOGETHER]) {
    let n = sums.len() / TOGETHER;
    for (sums, weight) in sums.chunks_exact_mut(n).zip(weights) {
        for (sum, value) in sums.iter_mut().zip(&map[..n]) {
            *sum = *sum + *weight * *value;
        }
    }
}

/// Rectifies sums where that is wanted, and leaves 0 on the rim.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn finish<R: Real>(map: &mut [R], sums: &[R], mask: &[R], rectified: bool) {
    let n = sums.len();
    let (map, mask) = (&mut map[..n], &mask[..n]);
    for l in 0..n {
        let sum = sums[l];
        let kept = if rectified && sum < R::ZERO {
            R::ZERO
        } else {
            sum
        };
        map[l] = kept * mask[l];
    }
}

/// Partial sums of products.
type Lanes<R> = [R; LANES];

/// Half of them.
type Half<R> = [R; HALF];

const HALF: usize = LANES / 2;

/// Blocks of three maps that stay in the first cache.
const CACHED: usize = 64;

#[allow(clippy::inline_always, reason = "takes the vectors of its caller")]
#[inline(always)]
fn add_products<R: Real, const N: usize>(mut sums: [R; N], a: [R; N], b: [R; N]) -> [R; N] {
    for l in 0..N {
        sums[l] = sums[l] + a[l] * b[l];
    }
    sums
}

/// The sums of products of a map, shifted by 0, 1 and 2, with each of a few.
#[multiversion(targets(
    "x86_64+avx512f+avx512vl+avx512dq+avx512bw",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn across<R: Real>(input: &[R], asked: [&[R]; TOGETHER]) -> [[R; TOGETHER]; 3] {
    let [a, b, c, d] = asked;
    let sums = if target_cfg_f!(target_feature = "avx512f") {
        let [(wa, ha, ea), (wb, hb, eb), (wc, hc, ec), (wd, hd, ed)] = with_four(input, asked);
        [[wa, wb, wc, wd], [ha, hb, hc, hd], [ea, eb, ec, ed]]
    } else {
        // As many sums as there are registers.
        let [(wa, ha, ea), (wb, hb, eb)] = with_two(input, [a, b]);
        let [(wc, hc, ec), (wd, hd, ed)] = with_two(input, [c, d]);
        [[wa, wb, wc, wd], [ha, hb, hc, hd], [ea, eb, ec, ed]]
    };
    sums.map(|each| each.map(|lanes| folded(&lanes)))
}

/// Sums with the place to the west, with the place itself, with the place to the east.
type Three<R> = (Lanes<R>, Lanes<R>, Lanes<R>);

/// Sums are variables of their own, so that they stay in registers.
#[allow(clippy::inline_always, reason = "takes the vectors of its caller")]
#[inline(always)]
fn with_four<R: Real>(input: &[R], asked: [&[R]; 4]) -> [Three<R>; 4] {
    let n = asked[0].len() / LANES;
    let [a, b, c, d] = asked.map(|map| &map.as_chunks::<LANES>().0[..n]);
    let [west, here, east] = shifted(input, n);
    let zero = [R::ZERO; LANES];
    let (mut wa, mut wb, mut wc, mut wd) = (zero, zero, zero, zero);
    let (mut ha, mut hb, mut hc, mut hd) = (zero, zero, zero, zero);
    let (mut ea, mut eb, mut ec, mut ed) = (zero, zero, zero, zero);
    for i in 0..n {
        let (x, y, z) = (west[i], here[i], east[i]);
        wa = add_products(wa, x, a[i]);
        wb = add_products(wb, x, b[i]);
        wc = add_products(wc, x, c[i]);
        wd = add_products(wd, x, d[i]);
        ha = add_products(ha, y, a[i]);
        hb = add_products(hb, y, b[i]);
        hc = add_products(hc, y, c[i]);
        hd = add_products(hd, y, d[i]);
        ea = add_products(ea, z, a[i]);
        eb = add_products(eb, z, b[i]);
        ec = add_products(ec, z, c[i]);
        ed = add_products(ed, z, d[i]);
    }
    [(wa, ha, ea), (wb, hb, eb), (wc, hc, ec), (wd, hd, ed)]
}

/// The same with two maps, a half of the lanes after the other: their sums then stay in sixteen
/// registers of 256 bits. What a half leaves in the first cache the other finds there.
#[allow(clippy::inline_always, reason = "takes the vectors of its caller")]
#[inline(always)]
fn with_two<R: Real>(input: &[R], asked: [&[R]; 2]) -> [Three<R>; 2] {
    let n = asked[0].len() / LANES;
    let maps = asked.map(|map| &map.as_chunks::<LANES>().0[..n]);
    let shifted = shifted(input, n);
    let (mut low, mut high) = ([[R::ZERO; HALF]; 6], [[R::ZERO; HALF]; 6]);
    for from in (0..n).step_by(CACHED) {
        let range = from..n.min(from + CACHED);
        let shifted = shifted.map(|lanes| &lanes[range.clone()]);
        let maps = maps.map(|lanes| &lanes[range.clone()]);
        low = add_half::<R, 0>(low, shifted, maps);
        high = add_half::<R, HALF>(high, shifted, maps);
    }
    let both = |n: usize| {
        from_fn(|l| {
            if l < HALF {
                low[n][l]
            } else {
                high[n][l - HALF]
            }
        })
    };
    [(both(0), both(1), both(2)), (both(3), both(4), both(5))]
}

/// Adds the products of the half of each block's lanes that begins at `FROM`.
#[allow(clippy::inline_always, reason = "takes the vectors of its caller")]
#[inline(always)]
fn add_half<R: Real, const FROM: usize>(
    [mut wa, mut ha, mut ea, mut wb, mut hb, mut eb]: [Half<R>; 6],
    [west, here, east]: [&[Lanes<R>]; 3],
    [a, b]: [&[Lanes<R>]; 2],
) -> [Half<R>; 6] {
    let half = |lanes: &Lanes<R>| -> Half<R> { from_fn(|l| lanes[FROM + l]) };
    let n = west.len();
    let (here, east, a, b) = (&here[..n], &east[..n], &a[..n], &b[..n]);
    for i in 0..n {
        let (x, y, z) = (half(&west[i]), half(&here[i]), half(&east[i]));
        let (a, b) = (half(&a[i]), half(&b[i]));
        wa = add_products(wa, x, a);
        ha = add_products(ha, y, a);
        ea = add_products(ea, z, a);
        wb = add_products(wb, x, b);
        hb = add_products(hb, y, b);
        eb = add_products(eb, z, b);
    }
    [wa, ha, ea, wb, hb, eb]
}

/// A map from each of three places on, in lanes. That they overlap is hidden from the compiler: it
/// would make one's vectors of the others', with more shuffles than there are products.
#[allow(clippy::inline_always, reason = "takes the vectors of its caller")]
#[inline(always)]
fn shifted<R: Real>(input: &[R], n: usize) -> [&[Lanes<R>]; 3] {
    [0, 1, 2].map(|by| black_box(&input[by..by + n * LANES].as_chunks::<LANES>().0[..n]))
}

/// A sum of lanes, in one order.
fn folded<R: Real>(lanes: &[R; LANES]) -> R {
    let mut lanes = *lanes;
    let mut half = LANES / 2;
    while half > 0 {
        for l in 0..half {
            lanes[l] = lanes[l] + lanes[l + half];
        }
        half /= 2;
    }
    lanes[0]
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn total<R: Real>(values: &[R]) -> R {
    let mut lanes = [R::ZERO; LANES];
    let (whole, rest) = values.as_chunks::<LANES>();
    for chunk in whole {
        for l in 0..LANES {
            lanes[l] = lanes[l] + chunk[l];
        }
    }
    rest.iter().fold(folded(&lanes), |sum, value| sum + *value)
}

/// Leaves a gradient where the output is above 0.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn gate<R: Real>(asked: &mut [R], output: &[R]) {
    for (asked, output) in asked.iter_mut().zip(output) {
        *asked = if *output > R::ZERO { *asked } else { R::ZERO };
    }
}
