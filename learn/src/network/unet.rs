//! A U-Net (Ronneberger et al. 2015, <https://arxiv.org/abs/1505.04597>): levels of half the size
//! each, and back up with what each level has seen.
//!
//! ```text
//! input ─ 3x3, 3x3 ─────────────────────────── joined ─ 3x3, 3x3 ─ 1x1 ─ output
//!              └ half ─ 3x3, 3x3 ─ joined ─ … ─ double ┘
//! ```

use amacrine::{gradient::Float, plane::Size, rng::Hash};
use rayon::prelude::*;

use super::{
    convolution::Convolution,
    maps::{Maps, Shape},
    resample::{doubled, halved},
};

/// What a network is made of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Channels of each level, the full size first.
    pub widths: Vec<usize>,
    /// 3x3 convolutions of a level, on the way down and on the way up.
    pub convolutions: usize,
    /// Maps that go in.
    pub inputs: usize,
    /// Maps that come out.
    pub outputs: usize,
}

impl Plan {
    /// Sides of its pictures are multiples of this.
    #[must_use]
    pub fn multiple(&self) -> usize {
        1 << (self.widths.len() - 1)
    }
}

/// Pictures that a network works on at once at the most. A batch is cut into so many: its sums hang on
/// this, so it is one number on any machine.
pub const PICTURES: usize = 4;

/// A network for so many pictures of one size: the same weights work at every size.
#[derive(Clone, Debug)]
pub struct Network<R> {
    plan: Plan,
    shapes: Vec<Shape<R>>,
    down: Vec<Vec<Convolution>>,
    /// From the second smallest level to the full size.
    up: Vec<Vec<Convolution>>,
    head: Convolution,
    parameters: usize,
}

/// What the way back needs of some pictures.
#[derive(Clone, Debug)]
pub struct Seen<R> {
    /// For each level on the way down, what went in and what came out of each layer.
    down: Vec<Vec<Maps<R>>>,
    up: Vec<Vec<Maps<R>>>,
}

/// Weights in the order in which loops read them.
#[derive(Clone, Debug)]
pub struct Packed<R> {
    there: Vec<Vec<R>>,
    back: Vec<Vec<R>>,
}

impl<R: Float> Network<R> {
    /// The network of a plan for batches of pictures of `size`, whose sides are multiples of
    /// [`Plan::multiple`]: it works on [`PICTURES`] at once, or on the batch where that is smaller.
    #[must_use]
    pub fn new(plan: Plan, size: Size, batch: usize) -> Self {
        let pictures = batch.clamp(1, PICTURES);
        let mut parameters = 0;
        let mut layer = |inputs: usize, outputs: usize, side: usize| {
            let layer = Convolution {
                inputs,
                outputs,
                side,
                start: parameters,
                rectified: side == 3,
            };
            parameters += layer.parameters();
            layer
        };
        let mut level = |inputs: usize, width: usize| -> Vec<Convolution> {
            (0..plan.convolutions)
                .map(|n| layer(if n == 0 { inputs } else { width }, width, 3))
                .collect()
        };
        let mut inputs = plan.inputs;
        let mut down = Vec::new();
        for width in &plan.widths {
            down.push(level(inputs, *width));
            inputs = *width;
        }
        let mut up = Vec::new();
        for width in plan.widths.iter().rev().skip(1) {
            up.push(level(inputs + width, *width));
            inputs = *width;
        }
        let head = layer(inputs, plan.outputs, 1);
        let shape = |n: usize| Shape::new(Size::new(size.height >> n, size.width >> n), pictures);
        Self {
            shapes: (0..plan.widths.len()).map(shape).collect(),
            down,
            up,
            head,
            parameters,
            plan,
        }
    }

    /// What it is made of.
    #[must_use]
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The places of a picture's values.
    #[must_use]
    pub fn shape(&self) -> &Shape<R> {
        &self.shapes[0]
    }

    /// How many weights and biases.
    #[must_use]
    pub const fn parameters(&self) -> usize {
        self.parameters
    }

    /// Where a parameter is, in words.
    #[must_use]
    pub fn place(&self, parameter: usize) -> String {
        let (down, up) = (self.down.iter().enumerate(), self.up.iter().enumerate());
        let levels = self.down.len();
        let layers = down
            .map(|(n, layers)| (n, "down", layers))
            .chain(up.map(|(n, layers)| (levels - 2 - n, "up", layers)));
        for (level, way, layers) in layers {
            let own = |layer: &Convolution| parameter < layer.start + layer.parameters();
            if let Some(n) = layers.iter().position(own) {
                return format!(
                    "convolution {} of the network's level {}, on the way {way}",
                    n + 1,
                    level + 1
                );
            }
        }
        "the network's head".to_owned()
    }

    /// Multiplications of one picture on the way there.
    #[must_use]
    pub fn products(&self) -> usize {
        let of = |(level, layers): (usize, &Vec<Convolution>)| {
            let each = layers.iter().map(|layer| layer.inputs * layer.outputs * 9);
            each.sum::<usize>() * self.shapes[level].size().pixels()
        };
        let down = self.down.iter().enumerate().map(of).sum::<usize>();
        let up = self.up.iter().rev().enumerate().map(of).sum::<usize>();
        let head = self.head.inputs * self.head.outputs * self.shapes[0].size().pixels();
        down + up + head
    }

    /// Bytes of all maps of the pictures that are worked on at once.
    #[must_use]
    pub fn map_bytes(&self) -> usize {
        let of = |(level, layers): (usize, &Vec<Convolution>)| {
            let maps = layers.iter().map(|layer| layer.outputs).sum::<usize>();
            let inputs = layers.first().map_or(0, |layer| layer.inputs);
            (maps + inputs) * self.shapes[level].plane() * size_of::<R>()
        };
        let down = self.down.iter().enumerate().map(of).sum::<usize>();
        down + self.up.iter().rev().enumerate().map(of).sum::<usize>()
    }

    /// Where training begins: weights of zero mean whose spread keeps the size of what passes
    /// (He et al. 2015), and a head of zeros, so that the first answer is nothing.
    ///
    /// A weight hangs on the seed and its place alone: networks with more inputs begin with the same
    /// weights for those that they share.
    #[must_use]
    pub fn start(&self, seed: u64, fan: usize) -> Vec<R> {
        let mut parameters = vec![R::ZERO; self.parameters];
        let layers = self.down.iter().chain(&self.up).flatten();
        for (n, layer) in layers.enumerate() {
            let inputs = if n == 0 { fan } else { layer.inputs };
            let spread = (2.0 / (9 * inputs) as f64).sqrt();
            let of_layer = Hash::new(seed).with(0x6e65_7477).with(n as u64);
            for o in 0..layer.outputs {
                for i in 0..layer.inputs {
                    for tap in 0..9 {
                        let place = of_layer.with(o as u64).with(i as u64).with(tap as u64);
                        // Uniform, of the same variance.
                        let value = (2.0 * place.uniform() - 1.0) * spread * 3f64.sqrt();
                        let at = layer.start + (o * layer.inputs + i) * 9 + tap;
                        parameters[at] = R::from_f64(value);
                    }
                }
            }
        }
        parameters
    }

    /// Weights as loops read them.
    #[must_use]
    pub fn packed(&self, parameters: &[R]) -> Packed<R> {
        let of = |back| {
            let layers = self.down.iter().chain(&self.up).flatten();
            let layers = layers.chain(std::iter::once(&self.head));
            layers.map(|layer| layer.packed(parameters, back)).collect()
        };
        Packed {
            there: of(false),
            back: of(true),
        }
    }

    /// The layers of a level, one after the other; leaves what went in and what came out of each.
    fn level(
        (parameters, packed): (&[R], &[Vec<R>]),
        (layers, shape, first): (&[Convolution], &Shape<R>, usize),
        input: Maps<R>,
    ) -> Vec<Maps<R>> {
        let mut maps = vec![input];
        for (n, layer) in layers.iter().enumerate() {
            let output = layer.forward((shape, parameters, &packed[first + n]), &maps[n]);
            maps.push(output);
        }
        maps
    }

    /// What the network makes of some pictures, and what the way back needs.
    #[must_use]
    pub fn forward(
        &self,
        parameters: &[R],
        packed: &Packed<R>,
        input: Maps<R>,
    ) -> (Maps<R>, Seen<R>) {
        let weights = (parameters, &packed.there[..]);
        let each = self.plan.convolutions;
        let mut down: Vec<Vec<Maps<R>>> = Vec::new();
        let mut input = Some(input);
        for (n, layers) in self.down.iter().enumerate() {
            let from = match (input.take(), down.last().and_then(|maps| maps.last())) {
                (Some(input), _) => input,
                (None, Some(maps)) => {
                    let shapes = (&self.shapes[n - 1], &self.shapes[n]);
                    halved(shapes, maps, R::from_f64(0.25))
                }
                (None, None) => Maps::zeros(&self.shapes[0], 0),
            };
            down.push(Self::level(
                weights,
                (layers, &self.shapes[n], n * each),
                from,
            ));
        }
        let levels = self.down.len();
        let mut up: Vec<Vec<Maps<R>>> = Vec::new();
        for (n, layers) in self.up.iter().enumerate() {
            let level = levels - 2 - n;
            let below = up.last().unwrap_or(&down[level + 1]);
            let shapes = (&self.shapes[level + 1], &self.shapes[level]);
            let from = doubled(shapes, &below[each], R::ONE);
            let from = from.joined(&self.shapes[level], &down[level][each]);
            let place = (&layers[..], &self.shapes[level], (levels + n) * each);
            up.push(Self::level(weights, place, from));
        }
        let last = up.last().unwrap_or(&down[0]);
        let packed = &packed.there[packed.there.len() - 1];
        let output = self
            .head
            .forward((&self.shapes[0], parameters, packed), &last[each]);
        (output, Seen { down, up })
    }

    /// Adds the gradient of the parameters to `gradient`; gives that of the input where it is wanted.
    pub fn backward(
        &self,
        packed: &Packed<R>,
        seen: &Seen<R>,
        asked: Maps<R>,
        (gradient, further): (&mut [R], bool),
    ) -> Option<Maps<R>> {
        let each = self.plan.convolutions;
        let levels = self.down.len();
        let last = seen.up.last().unwrap_or(&seen.down[0]);
        let head = &packed.back[packed.back.len() - 1];
        // The head is not rectified: its own output is not asked for.
        let mut asked = self.head.backward(
            (&self.shapes[0], head),
            (&last[each], &last[each]),
            asked,
            (gradient, true),
        )?;
        let mut level_back = |layers: &[Convolution],
                              (shape, first): (&Shape<R>, usize),
                              maps: &[Maps<R>],
                              mut asked: Maps<R>,
                              further: bool| {
            for (n, layer) in layers.iter().enumerate().rev() {
                asked = layer.backward(
                    (shape, &packed.back[first + n]),
                    (&maps[n], &maps[n + 1]),
                    asked,
                    (gradient, n > 0 || further),
                )?;
            }
            Some(asked)
        };
        // What the way up asks of each level of the way down.
        let mut skipped = Vec::new();
        for (n, layers) in self.up.iter().enumerate().rev() {
            let level = levels - 2 - n;
            let place = (&self.shapes[level], (levels + n) * each);
            let both = level_back(layers, place, &seen.up[n], asked, true)?;
            let (below, skip) = both.parted(&self.shapes[level], self.plan.widths[level + 1]);
            skipped.push(skip);
            let shapes = (&self.shapes[level], &self.shapes[level + 1]);
            asked = halved(shapes, &below, R::ONE);
        }
        for (n, layers) in self.down.iter().enumerate().rev() {
            if n + 1 < levels {
                let shapes = (&self.shapes[n + 1], &self.shapes[n]);
                asked = doubled(shapes, &asked, R::from_f64(0.25));
                if let Some(skip) = skipped.pop() {
                    asked.add(&skip);
                }
            }
            let place = (&self.shapes[n], n * each);
            asked = level_back(layers, place, &seen.down[n], asked, n > 0 || further)?;
        }
        Some(asked)
    }

    /// What the network makes of the pictures of a batch.
    #[must_use]
    pub fn answers(&self, parameters: &[R], inputs: Vec<Maps<R>>) -> Vec<Maps<R>> {
        let packed = self.packed(parameters);
        let answer = |input| self.forward(parameters, &packed, input).0;
        inputs.into_par_iter().map(answer).collect()
    }
}
