//! A program of any number of kinds with one memory of the pixel, and its proof: what the capture
//! leaves, and each filter by itself.

use miette::{WrapErr, miette};

use super::{Arguments, Asked, Compiled, Proof, on_chip::OnChip, readout, request};
use crate::{
    array::{
        Input, Settings,
        range::{Inputs, Interval},
        taps,
    },
    compile::{CellKind, DriveMemory, SensorProgram, Signal, brightest, check_words},
    isa::{Analog, Device, Figure},
    program::{Action, Code, Overrides, Program},
};

pub(super) fn whole(
    arguments: &Arguments,
    asked: &Asked,
    kinds: &[CellKind],
    device: &Device,
) -> miette::Result<Compiled> {
    let request = request(arguments, &asked.kernels[..1], device)?;
    let program = SensorProgram::new(kinds, DriveMemory::Shared, &asked.title, &request)?;
    let fault = || {
        miette!(
            help = "this is a fault of amacrine: please report the kernels and the command",
            "the compiled program computes another kernel than asked for"
        )
    };
    if arguments.readout == readout::Asking::Sums {
        return Err(miette!(
            help = "give --readout counts, or --memory analogue if the kinds fit",
            "--readout sums: kinds that share a memory have their drives in one register, one after the other"
        ));
    }
    let (readout, readouts) = readout::planned(arguments, asked, &program, kinds, device)?;
    let text = program.text_with(kinds, &asked.title, device, readout);
    check_words(&text, device)?;
    let parsed = Program::parse("compiled", &text)?;
    let expansion = parsed.expand(device, &Overrides::default())?;
    let drive = program.drives.first().copied().ok_or_else(fault)?;
    if !is_difference(&program.difference, device, drive)? {
        return Err(fault());
    }
    let most = brightest(device) * device.value(Figure::LightScale);
    let mut compiled = Compiled {
        text,
        expansion,
        scales: program.scales.clone(),
        kernels: Vec::new(),
        results: Vec::new(),
        thresholds: Vec::new(),
        saturations: 0,
        results_in: program.drives.clone(),
        snake: 0,
        ranged: true,
        to_border: false,
        on_chip: Vec::new(),
        noises: Vec::new(),
        filter: program.filter.clone(),
        filters: program.filters.clone(),
        memory: None,
        in_bits: Vec::new(),
        readouts: Some(readouts),
    };
    for (i, filter) in program.filters.iter().enumerate() {
        let (kernels, results) = (&asked.kernels[i..=i], &program.drives[i..=i]);
        let text = filter.text(device, 0);
        let words = format!("{}{text}", program.difference);
        if !holds(&compiled.expansion.code, &words, device)? {
            return Err(fault());
        }
        let proof = Proof {
            kernels,
            device,
            results,
            input: Input::Register(drive),
            inputs: Inputs {
                registers: Interval::new(-most, most),
                ..Inputs::from_device(device)
            },
            scale: filter.scale(),
        };
        let own = proof.compiled(text, filter.clone(), filter.decided.is_none());
        let own = own.wrap_err_with(|| asked.sources[i].clone())?;
        compiled.kernels.extend(own.kernels);
        compiled.results.extend(own.results);
        compiled.saturations += own.saturations;
        compiled.snake += own.snake;
        // Beyond that it saturates, for the threshold's sake.
        let within = filter
            .decided
            .map_or(most, |_| filter.exact_within.min(most).floor().max(1.0));
        let signal = Signal::around_zero(within);
        compiled
            .on_chip
            .extend(OnChip::run(filter, device, results, signal)?);
        compiled.noises.extend(own.noises);
    }
    let thresholds = asked.thresholds.iter().zip(&program.scales);
    compiled.thresholds = thresholds
        .map(|((on, off), scale)| [on * scale, off * scale])
        .collect();
    Ok(compiled)
}

/// Whether these words leave the light less the memory: of two inputs one as it is, the other with
/// its sign turned.
fn is_difference(words: &str, device: &Device, drive: Analog) -> miette::Result<bool> {
    let words = Program::parse("difference", words)?.expand(device, &Overrides::default())?;
    let settings = Settings::from_device(device);
    let taps = taps::read(&words.code.frame, device, settings, drive)
        .wrap_err("the program cannot be read back")?;
    let mut weights: Vec<f64> = { taps.taps.iter() }
        .map(|((input, ..), weight)| match input {
            Input::Light => weight.to_f64() / device.value(Figure::LightScale),
            Input::Register(_) => weight.to_f64(),
        })
        .collect();
    weights.sort_by(f64::total_cmp);
    Ok(weights == [-1.0, 1.0])
}

/// Whether these words stand in the frame, one after the other.
fn holds(code: &Code, words: &str, device: &Device) -> miette::Result<bool> {
    let filter = Program::parse("filter", words)?.expand(device, &Overrides::default())?;
    let actions = |steps: &[crate::program::Step]| -> Vec<Action> {
        steps.iter().map(|step| step.action.clone()).collect()
    };
    let (all, own) = (actions(&code.frame), actions(&filter.code.frame));
    Ok(own.is_empty() || all.windows(own.len()).any(|part| part == own))
}
