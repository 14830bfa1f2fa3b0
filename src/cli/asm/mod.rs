//! `amacrine asm`.

mod changes;
mod foot;
mod proof;

use serde_json::json;

use self::{changes::Changes, proof::Proof};
use super::input::opened_program::{Opened, Source};
use crate::{
    array::range::Interval,
    isa::{Cell, Device, Figure},
    program::{Cost, Entry, Expanded, Expansion, HostCalls, Program, vendor_text},
};

/// What `asm` is asked to do.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: amacrine asm rgc/centre_surround --chip scamp5-wide")]
pub struct Arguments {
    #[command(flatten)]
    source: Source,
    /// Print the program in canonical form
    #[arg(long, conflicts_with_all = ["disasm", "json"])]
    format: bool,
    /// Print the instruction words, as the verb `disasm` does
    #[arg(long, conflicts_with = "json")]
    disasm: bool,
    /// Range of the input; prints the values that registers can take
    ///
    /// The range is that of the light (0 to 255) if the program takes light in, else that of the
    /// registers that it reads, in LSB. The program also prints the stores that can saturate, and
    /// what of each register survives on the model of the real chip. Excludes --format and
    /// --disasm.
    #[arg(long, value_name = "LO..HI", value_parser = interval, allow_hyphen_values = true, conflicts_with_all = ["format", "disasm"])]
    input: Option<Interval>,
    /// Seed of the silicon, with --input: the chip of the model, and its noise
    #[arg(long, default_value_t = 0, requires = "input")]
    seed: u64,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// `low..high`, for the command line.
fn interval(text: &str) -> Result<Interval, String> {
    let wrong = || format!("`{text}` is not LO..HI, such as 0..255 or -20..20");
    let (low, high) = text.split_once("..").ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match (number(low), number(high)) {
        (Some(low), Some(high)) if low < high => Ok(Interval::new(low, high)),
        (Some(_), Some(_)) => Err(format!("`{text}`: the first must be below the second")),
        _ => Err(wrong()),
    }
}

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    if arguments.format {
        // What cannot be read cannot be printed either.
        super::say(&arguments.source.canonical()?.to_string());
        return Ok(());
    }
    let opened = arguments.source.open(&[])?;
    let proof = Proof::new(&opened, arguments.input, arguments.seed)?;
    let is_as_written = arguments.source.is_as_written();
    let miscounted = is_as_written.then(|| foot::miscounted(&opened));
    let warnings = miscounted.into_iter().flatten();
    for warning in warnings.chain(proof.unread(&opened)) {
        super::complain(&warning);
    }
    if arguments.disasm {
        super::say(&arguments.source.words(&opened));
        return Ok(());
    }
    let Opened {
        program,
        device,
        expansion,
        ..
    } = opened;
    let changes = Changes::new(&program, &expansion, &device, &arguments.source.overrides());
    if arguments.json {
        let mut json = json(&program, &expansion, &device, changes.as_ref());
        json["proof"] = proof.json(&device);
        super::say(&format!("{json}\n"));
    } else {
        let mut text = listing(&program, &expansion, &device, changes.as_ref());
        text += &proof.text(&device);
        super::say(&text);
    }
    Ok(())
}

/// The table for people.
fn listing(
    program: &Program,
    expansion: &Expansion,
    device: &Device,
    changes: Option<&Changes>,
) -> String {
    let mut lines: Vec<String> = program.settings.title.iter().cloned().collect();
    let (chip, title) = (device.name(), device.title());
    lines.push(format!("{} on {chip} ({title})", program.file));
    for (name, entries) in sections(expansion) {
        lines.extend([
            String::new(),
            name.to_owned(),
            " line words  statement".to_owned(),
        ]);
        rows(&mut lines, entries, device, 0);
    }
    lines.push(String::new());
    for (name, cost) in costs(expansion, device) {
        let Cost {
            words,
            array_us,
            host_us,
        } = cost;
        let rate = if name == "frame" && cost.micros() > 0.0 {
            format!("  {:.0} frames/s", cost.frames_per_second())
        } else {
            String::new()
        };
        lines.push(format!(
            "{name:<8}{:>6} {:<5}  {array_us:>10.1} us on the array  {host_us:>10.1} us on the host{rate}",
            words.0,
            if words.0 == 1 { "word" } else { "words" }
        ));
    }
    let (stored, room) = (expansion.stored(device).0, device.value(Figure::Store));
    let unit = if stored == 1 { "word" } else { "words" };
    lines.push(format!("store   {stored:>6} {unit} of {room}"));
    let (used, destroyed) = registers(expansion, device);
    lines.push(format!("uses      {}", or_none(&used)));
    lines.push(format!("destroys  {}", or_none(&destroyed)));
    if let Some(changes) = changes {
        lines.extend(changes.lines());
    }
    lines.push(String::new());
    lines.join("\n")
}

fn or_none(names: &[String]) -> String {
    if names.is_empty() {
        return "nothing".to_owned();
    }
    names.join(" ")
}

/// `init` and `frame`, where there is something in them.
fn sections(expansion: &Expansion) -> impl Iterator<Item = (&'static str, &[Entry])> {
    let frame = if expansion.bare { "program" } else { "frame" };
    [("init", &expansion.init), (frame, &expansion.frame)]
        .into_iter()
        .filter(|(_, entries)| !entries.is_empty())
        .map(|(name, entries)| (name, entries.as_slice()))
}

fn costs(expansion: &Expansion, device: &Device) -> Vec<(&'static str, Cost)> {
    let frame = if expansion.bare { "program" } else { "frame" };
    let mut list = Vec::new();
    if !expansion.bare {
        list.push(("init", Cost::of(&expansion.code.init, device)));
    }
    list.push((frame, Cost::of(&expansion.code.frame, device)));
    list
}

fn rows(lines: &mut Vec<String>, entries: &[Entry], device: &Device, level: usize) {
    let indent = "  ".repeat(level);
    for entry in entries {
        match entry {
            Entry::Statement(it) => {
                let words = Cost::of(&it.steps, device).words.0;
                let line = match it.origin {
                    None => it.line.to_string(),
                    Some(_) => it.stands(),
                };
                lines.push(format!("{line:>5} {words:>5}  {indent}{}", it.text));
                let shown = primitives(it, device).into_iter();
                lines.extend(shown.map(|line| format!("             {indent}  {line}")));
            }
            Entry::Repeat { times, body, line } => {
                lines.push(format!("{line:>5}        {indent}repeat {times}"));
                rows(lines, body, device, level + 1);
            }
        }
    }
}

/// What a statement became, when that is not the statement itself.
fn primitives(it: &Expanded, device: &Device) -> Vec<String> {
    let code = crate::program::Code {
        init: Vec::new(),
        frame: it.steps.clone(),
    };
    let text = vendor_text(&code, true, device);
    let lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if lines == [it.text.as_str()] {
        return Vec::new();
    }
    lines
}

/// Registers that are read or written, and those that some statement overwrites as scratch.
fn registers(expansion: &Expansion, device: &Device) -> (Vec<String>, Vec<String>) {
    let mut used: Vec<Cell> = Vec::new();
    let mut destroyed: Vec<Cell> = Vec::new();
    let mut add = |it: &Expanded| {
        used.extend(&it.effect.reads);
        used.extend(&it.effect.writes);
        destroyed.extend(it.destroys());
    };
    for (_, entries) in sections(expansion) {
        crate::program::for_each(entries, &mut add);
    }
    let names = |mut cells: Vec<Cell>| {
        cells.sort_unstable();
        cells.dedup();
        cells.into_iter().map(|c| c.name(device)).collect()
    };
    (names(used), names(destroyed))
}

fn json(
    program: &Program,
    expansion: &Expansion,
    device: &Device,
    changes: Option<&Changes>,
) -> serde_json::Value {
    fn list(entries: &[Entry], device: &Device) -> Vec<serde_json::Value> {
        entries
            .iter()
            .map(|entry| match entry {
                Entry::Statement(it) => json!({
                    "line": it.line,
                    "statement": it.text,
                    "words": Cost::of(&it.steps, device).words,
                    "primitives": primitives(it, device),
                }),
                Entry::Repeat { times, body, line } => json!({
                    "line": line,
                    "repeat": times,
                    "body": list(body, device),
                }),
            })
            .collect()
    }
    let (used, destroyed) = registers(expansion, device);
    let code = &expansion.code;
    let cost = |(name, cost): (&str, Cost)| {
        let steps = if name == "init" {
            &code.init
        } else {
            &code.frame
        };
        let (host, evidence) = HostCalls::between(&HostCalls::of(steps, device), device);
        let value = json!({
            "words": cost.words,
            "array_us": cost.array_us,
            "host_us": cost.host_us,
            "host_us_range": host,
            "evidence": { "host_us": evidence },
        });
        (name.to_owned(), value)
    };
    let costs: serde_json::Map<_, _> = costs(expansion, device).into_iter().map(cost).collect();
    let warnings = program.warnings(expansion);
    let warnings = warnings.map_or_else(Vec::new, |faults| faults.lines());
    json!({
        "program": program.file,
        "chip": device.name(),
        "bare": expansion.bare,
        "init": list(&expansion.init, device),
        "frame": list(&expansion.frame, device),
        "cost": costs,
        "stored_words": expansion.stored(device).0,
        "uses": used,
        "destroys": destroyed,
        "constants": expansion.constants,
        "warnings": warnings,
        "changes": changes.map(Changes::json),
    })
}
