//! What a program computes, within which range, and what of it survives on silicon.

use std::{collections::BTreeMap, path::Path};

use miette::WrapErr;
use serde_json::{Value, json};

use crate::{
    array::{
        GenericError, Input, Settings,
        claim::{self, Claim, HeldEvents, MOST_EFFORT, Scaled, SignHeld},
        effort,
        range::{self, Inputs, Interval, Ranges},
        survival::{Analogue, RUNS, SIDE, Survival, survival},
        taps::{self, NoTaps, Taps},
    },
    cli::input::opened_program::Opened,
    isa::{Analog, Cell, Device, Figure},
    plane::Plane,
    program::{Action, Entry, Expanded, Host, Step, for_each},
    unit::Lsb,
};

/// What can be said of a program before it sees a scene.
pub struct Proof {
    /// Whether its settings say what it computes, and how that was found to be true.
    claim: Option<Claim>,
    /// The registers that its frame gives, in the order of the chip, with their kernels.
    kernels: Kernels,
    results: Vec<Cell>,
    given: Option<Given>,
}

/// The kernels of all analogue registers, or why there are none.
enum Kernels {
    Read(Vec<Result<Taps, NoTaps>>),
    /// A pixel like all others cannot stand for it.
    Place(GenericError),
    /// So many words times pixels.
    TooLong,
}

/// What follows from a range of inputs.
struct Given {
    input: Interval,
    is_light: bool,
    ranges: Option<Ranges>,
    survives: Vec<Survival>,
    seed: u64,
}

impl Proof {
    /// What can be said of a program.
    ///
    /// # Errors
    /// When its settings say what is not so, or it does not run.
    pub fn new(opened: &Opened, input: Option<Interval>, seed: u64) -> miette::Result<Self> {
        let Opened {
            program,
            device,
            expansion,
            ..
        } = opened;
        let (code, settings) = (&expansion.code, Settings::from_device(device));
        let written_for = written_for(opened);
        let mut others: Vec<&Device> = written_for.iter().collect();
        others.extend(std::iter::successors(device.base(), |chip| chip.base()));
        let claim = program.settings.computes.as_ref();
        let claim =
            claim.map(|it| claim::check(it, code, device, settings, &expansion.constants, &others));
        let claim = claim.transpose().wrap_err_with(|| program.file.clone())?;
        let short = effort(&code.frame, device).map(|effort| effort <= MOST_EFFORT);
        let kernels = match short {
            Some(false) => Kernels::TooLong,
            _ => match taps::read_all(&code.frame, device, settings) {
                Ok(mut kernels) => {
                    for it in kernels.iter_mut().filter_map(|it| it.as_mut().err()) {
                        let mut before = it.at;
                        let statement = statement_at(&expansion.frame, &mut before);
                        let other = statement.filter(|it| it.origin.is_some());
                        it.origin = other.map(Expanded::stands);
                    }
                    Kernels::Read(kernels)
                }
                Err(why) => Kernels::Place(why),
            },
        };
        let results = results(opened);
        let given = input.map(|input| -> miette::Result<Given> {
            let is_light = sees_light(&code.frame, device);
            let mut inputs = Inputs::from_device(device);
            if is_light {
                inputs.light = input;
            } else {
                inputs.registers = input;
            }
            let ranges = match short {
                Some(true) => range::of(&code.frame, device, settings, inputs).ok(),
                _ => None,
            };
            let bare = expansion.bare;
            Ok(Given {
                input,
                is_light,
                ranges,
                survives: survival(code, bare, device, settings, inputs, seed, &results)?,
                seed,
            })
        });
        Ok(Self {
            claim,
            kernels,
            results,
            given: given.transpose()?,
        })
    }

    /// That a threshold is stated and a sign of its events is not read out, nor anything in their
    /// place: whoever reads them misses it, and nothing was held of it.
    pub fn unread(&self, opened: &Opened) -> Option<String> {
        let held = self.claim.as_ref()?.events?;
        let missing: Vec<&str> = { held.signs().into_iter().zip(["OFF", "ON"]).rev() }
            .filter(|(sign, _)| *sign == SignHeld::NotRead)
            .map(|(_, name)| name)
            .collect();
        if missing.is_empty() || summarises(&opened.expansion.code.frame) {
            return None;
        }
        Some(format!(
            "warning: {}: its [computes] states a threshold, and its {} events are not read out: what it fires there was not held; read them (scamp5_scan_events), or leave `threshold` out of [computes]\n",
            opened.program.file,
            missing.join(" and ")
        ))
    }

    /// For people.
    pub fn text(&self, device: &Device) -> String {
        let mut lines = vec![String::new(), "computes".to_owned()];
        if let Some(Claim {
            proof,
            scaled,
            events,
        }) = &self.claim
        {
            let how = match proof {
                claim::Proof::Words => ": its words were read back as linear forms",
                claim::Proof::Impulse => ", by what one bright pixel leaves behind",
            };
            lines.push(format!("  the kernel that its [computes] says{how}"));
            lines.extend(events.iter().map(|held| format!("  {}", of_events(held))));
            if let Some(Scaled { chip, there, here }) = scaled {
                lines.push(format!(
                    "  times {here}/{there}: that is said for {chip}, where light.scale is {there} LSB/level; here it is {here}"
                ));
            }
        }
        match &self.kernels {
            Kernels::Place(why) => lines.push(format!("  no kernel: {why}")),
            Kernels::TooLong => {
                lines
                    .push("  no kernel is read back: too many words that reach too far".to_owned());
            }
            Kernels::Read(kernels) => {
                for register in analogue(&self.results) {
                    if let Some(kernel) = kernels.get(usize::from(register.0)) {
                        lines.extend(equation(register, kernel, device));
                    }
                }
            }
        }
        if analogue(&self.results).count() == 0 {
            lines.push("  nothing that stays in an analogue register".to_owned());
        }
        match &self.given {
            Some(given) => lines.extend(self.lines_given(given, device)),
            None => lines.push(
                "  (--input LO..HI: within which range, and what survives on silicon)".to_owned(),
            ),
        }
        lines.join("\n") + "\n"
    }

    fn lines_given(&self, given: &Given, device: &Device) -> Vec<String> {
        let Interval { low, high } = given.input;
        let what = if given.is_light {
            "light"
        } else {
            "registers that are read"
        };
        let unit = if given.is_light { "" } else { " LSB" };
        let mut lines = vec![
            String::new(),
            format!("with {what} from {low} to {high}{unit}"),
        ];
        match &given.ranges {
            None => lines.push("  no range can be told".to_owned()),
            Some(ranges) => {
                for register in analogue(&self.results) {
                    if let Some(it) = ranges.registers.get(usize::from(register.0)) {
                        let name = device.analog_name(register);
                        lines.push(format!("  {name:<4} from {}", ends(*it)));
                    }
                }
                for it in &ranges.saturations {
                    lines.push(format!(
                        "  line {} can saturate: {} from {}",
                        it.line,
                        device.analog_name(it.register),
                        ends(it.interval)
                    ));
                }
                if ranges.saturations.is_empty() {
                    lines.push("  no store can saturate".to_owned());
                }
            }
        }
        lines.push(String::new());
        lines.push(format!(
            "on silicon (seed {}), beside exact arithmetic: {RUNS} frames of {SIDE}x{SIDE}, uniform inputs",
            given.seed
        ));
        for (cell, survival) in self.results.iter().zip(&given.survives) {
            let name = cell.name(device);
            lines.push(match survival {
                Survival::Bits(same) => {
                    format!("  {name:<4} is the same in {:.2} % of all pixels", 100.0 * same)
                }
                Survival::Analogue(Analogue {
                    correlation: None,
                    offset,
                    noise,
                    ..
                }) => format!(
                    "  {name:<4} is the same everywhere; offset {:.2}, noise {:.2}",
                    Lsb(*offset),
                    Lsb(*noise)
                ),
                Survival::Analogue(Analogue {
                    correlation: Some(correlation),
                    gain,
                    offset,
                    noise,
                    ..
                }) => format!(
                    "  {name:<4} correlation {correlation:.4}, noise {:.2}, gain {:.3}, offset {:.2} (not counted)",
                    Lsb(*noise),
                    gain.unwrap_or(0.0),
                    Lsb(*offset)
                ),
            });
        }
        lines
    }

    /// For machines.
    pub fn json(&self, device: &Device) -> Value {
        let none = match &self.kernels {
            Kernels::Read(_) => None,
            Kernels::Place(why) => Some(why.to_string()),
            Kernels::TooLong => Some("too many words that reach too far".to_owned()),
        };
        let registers = self.results.iter().enumerate().map(|(i, cell)| {
            let mut it = json!({"register": cell.name(device)});
            if let (Cell::Analog(register), Kernels::Read(all)) = (cell, &self.kernels)
                && let Some(kernel) = all.get(usize::from(register.0))
            {
                match kernel {
                    Ok(taps) => it["computes"] = inputs_json(taps, device),
                    Err(why) => {
                        it["not_linear"] = json!({"line": why.line, "why": why.to_string()});
                    }
                }
            }
            let Some(given) = &self.given else { return it };
            if let (Cell::Analog(register), Some(ranges)) = (cell, &given.ranges) {
                let range = ranges.registers.get(usize::from(register.0));
                it["range_lsb"] = json!(range.map(|it| [it.low, it.high]));
            }
            match given.survives.get(i) {
                Some(Survival::Bits(same)) => it["same"] = json!(same),
                Some(Survival::Analogue(found)) => {
                    it["correlation"] = json!(found.correlation);
                    it["gain"] = json!(found.gain);
                    it["offset_lsb"] = json!(found.offset);
                    it["noise_lsb"] = json!(found.noise);
                }
                None => {}
            }
            it
        });
        let ranges = self.given.as_ref().and_then(|given| given.ranges.as_ref());
        let saturations = ranges.map(|ranges| {
            let all = ranges.saturations.iter().map(|it| {
                json!({
                    "line": it.line,
                    "register": device.analog_name(it.register),
                    "lsb": [it.interval.low, it.interval.high],
                })
            });
            all.collect::<Vec<_>>()
        });
        let scaled = self.claim.as_ref().and_then(|it| it.scaled.as_ref());
        json!({
            "stated": self.claim.as_ref().map(|claim| match claim.proof {
                claim::Proof::Words => "proved from the words",
                claim::Proof::Impulse => "proved by an impulse",
            }),
            "stated_for": scaled.map(|it| json!({
                "chip": it.chip,
                "light_scale": it.there,
                "here": it.here,
            })),
            "stated_threshold": self.claim.as_ref().and_then(|it| it.events).map(|it| {
                let [off, on] = it.signs().map(|sign| match sign {
                    SignHeld::Held => "held",
                    SignHeld::NotRead => "not read out",
                    SignHeld::NotCrossed => "not crossed",
                });
                json!({"lsb": it.threshold, "pictures": it.pictures, "on": on, "off": off})
            }),
            "no_kernels": none,
            "registers": registers.collect::<Vec<_>>(),
            "input": self.given.as_ref().map(|it| [it.input.low, it.input.high]),
            "input_is_light": self.given.as_ref().map(|it| it.is_light),
            "seed": self.given.as_ref().map(|it| it.seed),
            "saturations": saturations,
        })
    }
}

/// How a threshold was held, for people.
fn of_events(held: &HeldEvents) -> String {
    let threshold = Lsb(held.threshold).rounded();
    let [off, on] = held.signs();
    let of = |wanted: SignHeld| -> Option<String> {
        let names = [(on, "ON"), (off, "OFF")].into_iter();
        let names: Vec<&str> = names
            .filter(|(sign, _)| *sign == wanted)
            .map(|(_, name)| name)
            .collect();
        (!names.is_empty()).then(|| names.join(" and "))
    };
    let parts = [
        of(SignHeld::Held).map(|signs| {
            format!(
                "{signs} fire where it says on {} random pictures",
                held.pictures
            )
        }),
        of(SignHeld::NotCrossed)
            .map(|signs| format!("no picture that was shown calls for {signs}, and none fires")),
        of(SignHeld::NotRead)
            .map(|signs| format!("{signs} not read out as events, and so not held")),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    format!("its threshold of {threshold} LSB: {}", parts.join("; "))
}

/// Whether a frame reads out a box, a count, a sum or a bit in place of events.
fn summarises(steps: &[Step]) -> bool {
    steps.iter().any(|step| match &step.action {
        Action::Host(host) => matches!(
            host,
            Host::ScanBoundingBox { .. }
                | Host::GlobalCount { .. }
                | Host::GlobalSum { .. }
                | Host::GlobalOr { .. }
        ),
        Action::Word(_) => false,
        Action::Repeat { body, .. } => summarises(body),
    })
}

/// The chip that a program is written for, where that can be found.
fn written_for(opened: &Opened) -> Option<Device> {
    let file = &opened.program.file;
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    match opened.program.settings.chip.as_deref() {
        Some(chip) => Device::find_for(chip, file, folder).ok(),
        None => Some(Device::scamp5()),
    }
}

/// The ends of a range of values.
fn ends(Interval { low, high }: Interval) -> String {
    format!("{} to {} LSB", Lsb(low).rounded(), Lsb(high).rounded())
}

fn analogue(cells: &[Cell]) -> impl Iterator<Item = Analog> {
    cells.iter().filter_map(|cell| match cell {
        Cell::Analog(register) => Some(*register),
        Cell::Digital(_) | Cell::Flag => None,
    })
}

/// What is in a register when the frame ends and was meant to be: the last statement that writes
/// it gives it as a result.
fn results(opened: &Opened) -> Vec<Cell> {
    let news = Cell::Analog(opened.device.registers().news);
    let mut last: BTreeMap<Cell, bool> = BTreeMap::new();
    for_each(&opened.expansion.frame, &mut |it: &Expanded| {
        for cell in &it.effect.writes {
            last.insert(*cell, it.results.contains(cell));
        }
    });
    let meant = last.into_iter().filter(|(_, meant)| *meant);
    let cells = meant.map(|(cell, _)| cell);
    cells
        .filter(|cell| *cell != news && *cell != Cell::Flag)
        .collect()
}

fn sees_light(steps: &[Step], device: &Device) -> bool {
    steps.iter().any(|step| match &step.action {
        Action::Word(word) => device.operands(word).reads_light(),
        Action::Host(_) => false,
        Action::Repeat { body, .. } => sees_light(body, device),
    })
}

/// Each input of a register, its kernel as whole numbers, and what they are multiplied by: a power of
/// two, and for light the chip's scale where that is none.
fn parts(taps: &Taps, device: &Device) -> Vec<(Input, f64, Plane<f64>)> {
    let mut inputs: Vec<Input> = taps.taps.keys().map(|(input, ..)| *input).collect();
    inputs.sort_unstable();
    inputs.dedup();
    let whole = |input: Input| {
        let scale = match input {
            Input::Light => device.value(Figure::LightScale),
            Input::Register(_) => 1.0,
        };
        // A scale of other digits has rounded the weights.
        let is_dyadic = libm::frexp(scale).0 == 0.5;
        let (scale, tolerance) = if is_dyadic { (1.0, 0.0) } else { (scale, 1e-9) };
        let kernel = taps.kernel(input).mapv(|weight| weight / scale);
        // Weights are whole numbers over a power of two: the largest that they share.
        let mut unit = 2f64.powi(64);
        let is_whole = |times: f64| (times - times.round()).abs() <= tolerance * times.abs();
        let fits = |unit: f64| kernel.iter().all(|w| is_whole(w / unit));
        while !fits(unit) && unit > 2f64.powi(-64) {
            unit /= 2.0;
        }
        let whole = kernel.mapv(|weight| match weight / unit {
            times if is_dyadic => times,
            times => times.round(),
        });
        (input, unit * scale, whole)
    };
    inputs.into_iter().map(whole).collect()
}

/// The statement of the word that runs after so many others.
fn statement_at<'e>(entries: &'e [Entry], before: &mut u64) -> Option<&'e Expanded> {
    for entry in entries {
        match entry {
            Entry::Statement(it) => match before.checked_sub(taps::words(&it.steps)) {
                None => return Some(it),
                Some(rest) => *before = rest,
            },
            Entry::Repeat { times, body, .. } => {
                let found = (0..*times).find_map(|_| statement_at(body, before));
                if found.is_some() {
                    return found;
                }
            }
        }
    }
    None
}

/// Whether it is one part of a whole number of them.
fn is_part(unit: f64) -> bool {
    (1.0 / unit).fract() == 0.0
}

fn equation(register: Analog, kernel: &Result<Taps, NoTaps>, device: &Device) -> Vec<String> {
    let name = device.analog_name(register);
    let taps = match kernel {
        Ok(taps) => taps,
        // A third is linear too.
        Err(why) if why.why == taps::Why::Parts => {
            return vec![format!("  {name:<4} weights that are not read: {why}")];
        }
        Err(why) => return vec![format!("  {name:<4} no linear map: {why}")],
    };
    let parts = parts(taps, device);
    let constant = taps.constant.to_f64();
    if parts.is_empty() {
        return vec![format!("  {name:<4} = {constant} LSB")];
    }
    let mut lines = Vec::new();
    let mut begin = format!("  {name:<4} = ");
    let joined = |value: f64| {
        if value < 0.0 {
            "       - "
        } else {
            "       + "
        }
    };
    for (input, unit, kernel) in parts {
        let input = match input {
            Input::Light => "light".to_owned(),
            Input::Register(register) => device.analog_name(register),
        };
        if kernel.dim() == (1, 1) {
            let mut weight = kernel[(0, 0)];
            if !lines.is_empty() {
                joined(weight).clone_into(&mut begin);
                weight = weight.abs();
            }
            let weight = match weight * unit {
                1.0 => String::new(),
                -1.0 => "-".to_owned(),
                // The product with a scale of other digits has rounded.
                times if !is_part(unit) => format!("{} ", (times * 1e12).round() / 1e12),
                times if unit >= 1.0 => format!("{times} "),
                _ => format!("{weight}/{} ", 1.0 / unit),
            };
            lines.push(format!("{begin}{weight}{input}"));
        } else {
            let unit = if unit == 1.0 {
                String::new()
            } else if !is_part(unit) {
                format!("{unit} ")
            } else {
                format!("1/{} ", 1.0 / unit)
            };
            lines.push(format!("{begin}{unit}{input} under"));
            let wide = kernel
                .iter()
                .map(|w| w.to_string().len())
                .max()
                .unwrap_or(1);
            for row in kernel.rows() {
                let row: Vec<String> = row.iter().map(|w| format!("{w:>wide$}")).collect();
                lines.push(format!("         {}", row.join(" ")));
            }
        }
        "       + ".clone_into(&mut begin);
    }
    if constant != 0.0 {
        lines.push(format!("{}{} LSB", joined(constant), constant.abs()));
    }
    lines
}

fn inputs_json(taps: &Taps, device: &Device) -> Value {
    let parts = parts(taps, device)
        .into_iter()
        .map(|(input, unit, kernel)| {
            let rows: Vec<Vec<f64>> = kernel.rows().into_iter().map(|row| row.to_vec()).collect();
            json!({
                "input": match input {
                    Input::Light => "light".to_owned(),
                    Input::Register(register) => device.analog_name(register),
                },
                "kernel": rows,
                "scale": unit,
            })
        });
    json!({
        "inputs": parts.collect::<Vec<_>>(),
        "constant_lsb": taps.constant.to_f64(),
    })
}
