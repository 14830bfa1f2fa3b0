//! The released rule's gradients, held to those of the authors' simulator: every `grad_*` of the
//! files in `tests/oracle/` whose memory holds the filtered signal, to 1e-6 of the largest of its
//! tensor (of its terms, where it is a sum in which they cancel). Against: gradients computed with the released code (README there).

mod npz;

use amacrine::{
    gradient::{Ask, Clips, Forward, Gradient, Model, Rule, Slope, gaussian_gradients},
    kernel::Gaussian,
    plane::Size,
    reference::Description,
};
use ndarray::{Array3, Array5, ArrayD};
use npz::oracle::{Oracle, files};

/// What the released test adds to its loss for each event.
const EVENT: f64 = 1e-3;

#[test]
fn every_released_gradient_is_met() {
    let mut tensors = 0;
    let (mut with, mut old) = (0, 0);
    for path in files() {
        let mut oracle = Oracle::open(&path);
        if !oracle.has("loss_weight") {
            continue;
        }
        if oracle.is("oldmem") {
            old += 1;
            refused(&mut oracle);
            continue;
        }
        with += 1;
        tensors += agree(&mut oracle);
    }
    assert_eq!((with, old), (74, 8));
    assert!(tensors > 90, "only {tensors} tensors were compared");
}

fn description(oracle: &mut Oracle) -> Description {
    let text = oracle.sensor();
    Description::parse(&oracle.name, &text, &|_| unreachable!()).unwrap()
}

/// A memory of pixels has no gradient here, and says so.
fn refused(oracle: &mut Oracle) {
    let said = Model::<f64>::new(description(oracle), Size::new(9, 9), 0).unwrap_err();
    assert!(
        said.to_string().contains("its memory holds pixels"),
        "{said}"
    );
}

/// Compares one file; returns the number of tensors in it.
fn agree(oracle: &mut Oracle) -> usize {
    let description = description(oracle);
    let input: Array3<f32> = oracle.arrays.array("input");
    let weight: Array5<f32> = oracle.arrays.array("loss_weight");
    let times: Vec<f64> = oracle.f64("t").iter().copied().collect();
    let [pairs, channels, ..] = *weight.shape() else {
        unreachable!()
    };
    let size = Size::new(input.shape()[1], input.shape()[2]);
    let light: Vec<f64> = input.iter().map(|v| f64::from(*v)).collect();
    let light = &light[..(pairs + 1) * size.pixels()];
    let clips = Clips::new(light, &times[..=pairs], size).unwrap();
    let model = Model::<f64>::new(description, size, 0).unwrap();
    let seen = model.forward(clips).unwrap();
    let asked = asked(oracle, &seen, &weight.mapv(f64::from));
    let asked: Vec<f64> = bins(&asked, (pairs, channels), size.pixels());
    let ask = Ask {
        voxels: Some(&asked),
        events: EVENT,
        slope: Slope::Fired,
        ..Ask::default()
    };
    let gradient = model.backward(&seen, &ask, Rule::Authors).unwrap();
    compare(oracle, &model, &gradient)
}

/// The loss's gradient of the stored tensor, in which each inner bin stands twice.
fn asked(oracle: &Oracle, seen: &Forward<f64>, weight: &Array5<f64>) -> Array5<f64> {
    if !oracle.is("norm") {
        return weight.clone();
    }
    // `(v - mean) / (deviation + 1e-8)` where `v` is not 0, and `v` where it is; mean and
    // deviation are sums over all entries, divided by the number of those.
    let [_, _, channels, height, width] = seen.shape();
    let voxel = |at: [usize; 5]| {
        let bin = at[0] + at[2];
        let cell = ((bin * channels + at[1]) * height + at[3]) * width + at[4];
        seen.voxels()[cell]
    };
    let entries = || weight.indexed_iter().map(|(at, w)| (voxel(at.into()), *w));
    let fired = || entries().filter(|(v, _)| *v != 0.0);
    let n = fired().count() as f64;
    let mean = fired().map(|(v, _)| v).sum::<f64>() / n;
    let variance = fired().map(|(v, _)| (v - mean).powi(2)).sum::<f64>() / n;
    let deviation = variance.sqrt();
    let all = deviation + 1e-8;
    let by_mean = fired().map(|(_, w)| w).sum::<f64>() / (all * n);
    let by_deviation = fired().map(|(v, w)| w * (v - mean)).sum::<f64>() / (all * all);
    let mut asked = weight.clone();
    for (at, asked) in asked.indexed_iter_mut() {
        let v = voxel(at.into());
        let own = if v == 0.0 { *asked } else { *asked / all };
        *asked = own - by_mean - by_deviation * (v - mean) / (n * deviation);
    }
    asked
}

/// From the stored tensor to the bins.
fn bins(stored: &Array5<f64>, (pairs, channels): (usize, usize), pixels: usize) -> Vec<f64> {
    let mut bins = vec![0.0; (pairs + 1) * channels * pixels];
    let width = stored.shape()[4];
    for ((pair, channel, side, y, x), value) in stored.indexed_iter() {
        bins[((pair + side) * channels + channel) * pixels + y * width + x] += value;
    }
    bins
}

fn compare(oracle: &mut Oracle, model: &Model<f64>, gradient: &Gradient<f64>) -> usize {
    let channels = &gradient.channels;
    // A pattern of four equal kernels is one.
    let kernels = |k: usize| -> Vec<f64> {
        let four = &channels[k].kernels;
        let sum = || four[1..].iter().fold(four[0].clone(), |sum, one| sum + one);
        let own = oracle.is("svk").then(|| four.clone());
        own.unwrap_or_else(|| vec![sum()])
            .iter()
            .flatten()
            .copied()
            .collect()
    };
    let all: Vec<f64> = (0..channels.len()).flat_map(kernels).collect();
    let sum = channels[0].kernels[1..]
        .iter()
        .fold(channels[0].kernels[0].clone(), |sum, one| sum + one);
    let mut tensors = 0;
    let mut held = |oracle: &mut Oracle, key: &str, ours: &[f64], terms: f64| {
        if !oracle.has(key) {
            return;
        }
        let theirs = values(oracle, key);
        assert_eq!(theirs.len(), ours.len(), "{}: {key}", oracle.name);
        let most = theirs.iter().fold(terms, |a: f64, b| a.max(b.abs()));
        for (n, (ours, theirs)) in ours.iter().zip(&theirs).enumerate() {
            assert!(
                (ours - theirs).abs() <= 1e-6 * most,
                "{}: {key}[{n}] is {ours}, not {theirs}",
                oracle.name
            );
        }
        tensors += 1;
    };
    held(oracle, "grad_current_kernel_weight", &all, 0.0);
    held(oracle, "grad_current_kernel_event_conv_weight", &all, 0.0);
    held(oracle, "grad_multiplier_curr", &channels[0].gains[..1], 0.0);
    held(oracle, "grad_multiplier_mem", &channels[0].gains[1..], 0.0);
    if oracle.has("grad_p_pos") {
        // A threshold is a nominal one, the same for all, times a place of the pattern.
        for (key, nominal, side) in [("pos", 0.05, 0), ("neg", 0.07, 1)] {
            let own = |k: usize| {
                if side == 0 {
                    &channels[k].on
                } else {
                    &channels[k].off
                }
            };
            let thresholds = &model.description().channels;
            let place = |k: usize, i: usize| {
                let threshold = thresholds[k].thresholds[i];
                [threshold.on, threshold.off][side] / nominal
            };
            let by_nominal: Vec<f64> = (0..channels.len())
                .map(|k| (0..4).map(|i| own(k)[i] * place(k, i)).sum())
                .collect();
            let by_place: Vec<f64> = (0..channels.len())
                .flat_map(|k| own(k).iter().map(|g| g * nominal))
                .collect();
            let terms = (0..channels.len()).flat_map(|k| (0..4).map(move |i| (k, i)));
            let terms = terms.map(|(k, i)| (own(k)[i] * place(k, i)).abs());
            let terms = terms.fold(0.0, f64::max);
            held(
                oracle,
                &format!("grad_{key}_thres_nominal"),
                &by_nominal,
                terms,
            );
            held(oracle, &format!("grad_p_{key}"), &by_place, 0.0);
        }
    }
    if oracle.has("grad_sigma_1") {
        let sigma: Vec<f64> = values(oracle, "sigma");
        let amp = if oracle.has("amp") {
            values(oracle, "amp")
        } else {
            vec![1.0, 1.0]
        };
        let parts = [0, 1].map(|i| Gaussian {
            sigma: sigma[i],
            gain: if i == 0 { amp[0] } else { -amp[1] },
        });
        let own = gaussian_gradients(&parts, &sum).unwrap();
        for (i, sign) in [(0, 1.0), (1, -1.0)] {
            held(
                oracle,
                &format!("grad_sigma_{}", i + 1),
                &[own[i].sigma],
                0.0,
            );
            held(
                oracle,
                &format!("grad_amp_{}", i + 1),
                &[sign * own[i].gain],
                0.0,
            );
        }
    }
    assert!(tensors > 0, "{}: no gradient was compared", oracle.name);
    tensors
}

/// A tensor of either precision.
fn values(oracle: &mut Oracle, key: &str) -> Vec<f64> {
    if key.starts_with("grad_multiplier") {
        let single: ArrayD<f32> = oracle.arrays.array(key);
        return single.iter().map(|v| f64::from(*v)).collect();
    }
    oracle.f64(key).iter().copied().collect()
}
