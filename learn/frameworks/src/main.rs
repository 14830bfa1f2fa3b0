//! One step of a U-Net 11-16-32-48-64-1, batch 8, 64x64, in candle: forward, backward, Adam.
//!
//! `RAYON_NUM_THREADS=1 cargo run --release --manifest-path learn/frameworks/Cargo.toml`

use std::time::Instant;

use candle_core::{DType, Device, Result, Tensor};
use candle_nn::{AdamW, Conv2d, Conv2dConfig, Module, Optimizer, ParamsAdamW, VarBuilder, VarMap, conv2d};

const WIDTHS: [usize; 4] = [16, 32, 48, 64];

fn level(inputs: usize, width: usize, vb: &VarBuilder<'_>) -> Result<[Conv2d; 2]> {
    let padded = Conv2dConfig { padding: 1, ..Conv2dConfig::default() };
    Ok([
        conv2d(inputs, width, 3, padded, vb.pp("a"))?,
        conv2d(width, width, 3, padded, vb.pp("b"))?,
    ])
}

fn apply(layers: &[Conv2d; 2], x: &Tensor) -> Result<Tensor> {
    layers[1].forward(&layers[0].forward(x)?.relu()?)?.relu()
}

fn main() -> Result<()> {
    let device = Device::Cpu;
    let vars = VarMap::new();
    let vb = VarBuilder::from_varmap(&vars, DType::F32, &device);
    let mut down = Vec::new();
    let mut inputs = 11;
    for (n, width) in WIDTHS.into_iter().enumerate() {
        down.push(level(inputs, width, &vb.pp(format!("down{n}")))?);
        inputs = width;
    }
    let mut up = Vec::new();
    for (n, width) in WIDTHS.into_iter().enumerate().rev().skip(1) {
        up.push(level(inputs + width, width, &vb.pp(format!("up{n}")))?);
        inputs = width;
    }
    let head = conv2d(inputs, 1, 1, Conv2dConfig::default(), vb.pp("head"))?;
    let mut adam = AdamW::new(vars.all_vars(), ParamsAdamW { lr: 1e-4, ..ParamsAdamW::default() })?;
    let x = Tensor::rand(0f32, 1.0, (8, 11, 64, 64), &device)?;
    let mut times = Vec::new();
    for _ in 0..15 {
        let start = cpu(Instant::now());
        let mut seen = Vec::new();
        let mut at = x.clone();
        for (n, layers) in down.iter().enumerate() {
            if n > 0 {
                at = at.avg_pool2d(2)?;
            }
            at = apply(layers, &at)?;
            seen.push(at.clone());
        }
        for (n, layers) in up.iter().enumerate() {
            let skip = &seen[2 - n];
            let (_, _, h, w) = skip.dims4()?;
            at = apply(layers, &Tensor::cat(&[&at.upsample_nearest2d(h, w)?, skip], 1)?)?;
        }
        let loss = head.forward(&at)?.sqr()?.mean_all()?;
        adam.backward_step(&loss)?;
        times.push((cpu(Instant::now()) - start) * 1e3);
    }
    times.sort_by(f64::total_cmp);
    println!("candle: median {:.0} ms, least {:.0} ms of processor time", times[7], times[0]);
    Ok(())
}

/// Seconds of this process on processors: user time of all its threads.
fn cpu(_: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = told.rsplit(')').next().unwrap_or_default();
    let ticks: f64 = after.split_whitespace().skip(11).take(2).filter_map(|t| t.parse::<f64>().ok()).sum();
    ticks * 0.01
}
