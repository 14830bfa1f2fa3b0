//! Derivatives against central differences, and the speed of a step.

use amacrine::{gradient::Float, plane::Size, rng::Hash};

use super::*;

fn noise<R: Float>(seed: u64, shape: &Shape<R>, channels: usize) -> Maps<R> {
    let mut maps = Maps::zeros(shape, channels);
    for (p, c) in (0..shape.pictures()).flat_map(|p| (0..channels).map(move |c| (p, c))) {
        for y in 0..shape.size().height {
            for (x, value) in maps.row_mut(shape, (p, c), y).iter_mut().enumerate() {
                let place = [p, c, y, x]
                    .iter()
                    .fold(Hash::new(seed), |h, n| h.with(*n as u64));
                *value = R::from_f64(2.0 * place.uniform() - 1.0);
            }
        }
    }
    maps
}

fn plan(inputs: usize, outputs: usize, widths: &[usize]) -> Plan {
    Plan {
        widths: widths.to_vec(),
        convolutions: 2,
        inputs,
        outputs,
    }
}

/// Weights with a head that is not 0.
fn weights<R: Float>(network: &Network<R>, seed: u64) -> Vec<R> {
    let mut weights = network.start(seed, network.plan().inputs);
    for (n, weight) in weights.iter_mut().enumerate() {
        let extra = 0.2 * (Hash::new(seed + 1).with(n as u64).uniform() - 0.5);
        *weight = *weight + R::from_f64(extra);
    }
    weights
}

fn product<R: Float>(a: &Maps<R>, b: &Maps<R>) -> f64 {
    let pairs = a.values().iter().zip(b.values());
    pairs.map(|(a, b)| a.to_f64() * b.to_f64()).sum()
}

#[test]
fn gradients_are_differences() {
    let size = Size::new(8, 12);
    let network = Network::<f64>::new(plan(3, 2, &[5, 6, 7]), size, 2);
    let mut parameters = weights(&network, 7);
    let mut input = noise(1, network.shape(), 3);
    let asked = noise(2, network.shape(), 2);
    let loss = |parameters: &[f64], input: &Maps<f64>| {
        let packed = network.packed(parameters);
        product(
            &network.forward(parameters, &packed, input.clone()).0,
            &asked,
        )
    };
    let packed = network.packed(&parameters);
    let (_, seen) = network.forward(&parameters, &packed, input.clone());
    let mut gradient = vec![0.0; network.parameters()];
    let back = network.backward(&packed, &seen, asked.clone(), (&mut gradient, true));
    let back = back.expect("it was asked for");
    let step = 1e-6;
    let mut worst = 0f64;
    for n in (0..parameters.len()).step_by(37) {
        let held = parameters[n];
        let mut at = |by: f64| {
            parameters[n] = held + by;
            loss(&parameters, &input)
        };
        let difference = (at(step) - at(-step)) / (2.0 * step);
        parameters[n] = held;
        worst = worst.max((difference - gradient[n]).abs() / gradient[n].abs().max(1.0));
    }
    let shape = network.shape().clone();
    for n in (0..6 * size.pixels()).step_by(17) {
        let (c, y, x) = (
            (n / size.pixels() % 2, n / size.pixels() / 2),
            n / 12 % 8,
            n % 12,
        );
        let held = input.row(&shape, c, y)[x];
        let mut at = |by: f64| {
            input.row_mut(&shape, c, y)[x] = held + by;
            loss(&parameters, &input)
        };
        let difference = (at(step) - at(-step)) / (2.0 * step);
        input.row_mut(&shape, c, y)[x] = held;
        worst = worst.max((difference - back.row(&shape, c, y)[x]).abs());
    }
    assert!(worst < 1e-6, "{worst:e}");
}

/// Without rectification a layer is linear in its input: `<A v, g> = <v, A^T g>`.
#[test]
fn the_way_back_is_the_transpose() {
    for side in [1, 3] {
        let shape = Shape::<f64>::new(Size::new(7, 9), 3);
        let layer = convolution::Convolution {
            inputs: 5,
            outputs: 6,
            side,
            start: 0,
            rectified: false,
        };
        let mut parameters: Vec<f64> = (0..layer.parameters())
            .map(|n| Hash::new(3).with(n as u64).uniform() - 0.5)
            .collect();
        let biases = parameters.len() - 6;
        parameters[biases..].fill(0.0);
        let (v, g) = (noise(4, &shape, 5), noise(5, &shape, 6));
        let there = layer.forward((&shape, &parameters, &layer.packed(&parameters, false)), &v);
        let mut gradient = vec![0.0; layer.parameters()];
        let packed = layer.packed(&parameters, true);
        let back = layer.backward(
            (&shape, &packed),
            (&v, &there),
            g.clone(),
            (&mut gradient, true),
        );
        let (a, b) = (
            product(&there, &g),
            product(&v, &back.expect("it was asked for")),
        );
        assert!((a - b).abs() < 1e-12 * a.abs().max(1.0), "{a} {b}");
        // And linear in its weights.
        let by_weight: f64 = gradient.iter().zip(&parameters).map(|(g, w)| g * w).sum();
        assert!(
            (a - by_weight).abs() < 1e-12 * a.abs().max(1.0),
            "{a} {by_weight}"
        );
    }
    let (large, small) = (
        Shape::<f64>::new(Size::new(6, 8), 2),
        Shape::new(Size::new(3, 4), 2),
    );
    let (v, g) = (noise(4, &large, 2), noise(5, &small, 2));
    let a = product(&resample::halved((&large, &small), &v, 0.25), &g);
    let b = product(&v, &resample::doubled((&small, &large), &g, 0.25));
    assert!((a - b).abs() < 1e-12);
}

#[test]
fn a_convolution_is_what_it_says() {
    let shape = Shape::<f64>::new(Size::new(4, 5), 2);
    let layer = convolution::Convolution {
        inputs: 2,
        outputs: 3,
        side: 3,
        start: 0,
        rectified: true,
    };
    let parameters: Vec<f64> = (0..layer.parameters())
        .map(|n| Hash::new(9).with(n as u64).uniform() - 0.5)
        .collect();
    let input = noise(1, &shape, 2);
    let got = layer.forward(
        (&shape, &parameters, &layer.packed(&parameters, false)),
        &input,
    );
    for (p, o) in (0..2).flat_map(|p| (0..3).map(move |o| (p, o))) {
        for y in 0..4i32 {
            for x in 0..5i32 {
                let mut sum = parameters[54 + o];
                for i in 0..2 {
                    for (tap, (dy, dx)) in (-1..2)
                        .flat_map(|y| (-1..2).map(move |x| (y, x)))
                        .enumerate()
                    {
                        let (v, u) = (y + dy, x + dx);
                        if (0..4).contains(&v) && (0..5).contains(&u) {
                            sum += parameters[(o * 2 + i) * 9 + tap]
                                * input.row(&shape, (p, i), v as usize)[u as usize];
                        }
                    }
                }
                let got = got.row(&shape, (p, o), y as usize)[x as usize];
                assert!((got - sum.max(0.0)).abs() < 1e-12);
            }
        }
    }
}

/// What is shared begins alike, and the first answer is nothing.
#[test]
fn networks_begin_alike() {
    let size = Size::new(8, 8);
    let few = Network::<f32>::new(plan(2, 1, &[4, 8]), size, 1);
    let many = Network::<f32>::new(plan(11, 1, &[4, 8]), size, 1);
    let (a, b) = (few.start(5, 11), many.start(5, 11));
    assert_eq!(a[..18], b[..18]);
    assert_ne!(a[..18], few.start(6, 11)[..18]);
    let input = noise(1, few.shape(), 2);
    let answer = few.forward(&a, &few.packed(&a), input).0;
    assert!(answer.values().iter().all(|v| *v == 0.0));
}
