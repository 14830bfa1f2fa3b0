//! `amacrine asm`.

use serde_json::json;

use super::opened::{Opened, Source};
use crate::{
    isa::{Device, Figure},
    program::{Cell, Cost, Entry, Expanded, Expansion, Overrides, Program, stored, vendor_text},
};

/// What `asm` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine asm programs/rgc/centre_surround.scamp --chip scamp5-wide"
)]
pub struct Arguments {
    #[command(flatten)]
    source: Source,
    /// Print the program in canonical form instead
    #[arg(long, conflicts_with_all = ["disasm", "json"])]
    format: bool,
    /// Print the instruction words instead, as the verb `disasm` does
    #[arg(long, conflicts_with = "json")]
    disasm: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    if arguments.format {
        let program = arguments.source.read()?;
        // What cannot be read cannot be printed either.
        let program = Program::parse(&program.file, &program.text)?;
        super::say(&program.syntax.to_string());
        return Ok(());
    }
    let Opened {
        program,
        device,
        expansion,
    } = arguments.source.open(&[])?;
    let changes = Changes::new(&program, &expansion, &device, &arguments.source.overrides());
    if arguments.disasm {
        super::say(&vendor_text(&expansion.code, expansion.bare, &device));
    } else if arguments.json {
        let json = json(&program, &expansion, &device, changes.as_ref());
        super::say(&format!("{json}\n"));
    } else {
        super::say(&listing(&program, &expansion, &device, changes.as_ref()));
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
            format!("  {:.0} frames/s", 1e6 / cost.micros())
        } else {
            String::new()
        };
        lines.push(format!(
            "{name:<8}{:>6} words  {array_us:>10.1} us on the array  {host_us:>10.1} us on the host{rate}",
            words.0
        ));
    }
    let (kept, room) = (kept(expansion, device), device.value(Figure::Store));
    lines.push(format!("store   {kept:>6} words of {room}"));
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

fn kept(expansion: &Expansion, device: &Device) -> u64 {
    stored(&expansion.code.init, device).0 + stored(&expansion.code.frame, device).0
}

fn rows(lines: &mut Vec<String>, entries: &[Entry], device: &Device, level: usize) {
    let indent = "  ".repeat(level);
    for entry in entries {
        match entry {
            Entry::Statement(it) => {
                let words = Cost::of(&it.steps, device).words.0;
                lines.push(format!("{:>5} {words:>5}  {indent}{}", it.line, it.text));
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
    let cost = |(name, cost): (&str, Cost)| {
        let value = json!({
            "words": cost.words,
            "array_us": cost.array_us,
            "host_us": cost.host_us,
        });
        (name.to_owned(), value)
    };
    let costs: serde_json::Map<_, _> = costs(expansion, device).into_iter().map(cost).collect();
    let warnings = program.warnings(expansion).map_or_else(Vec::new, |faults| {
        let line = |w: &crate::config::Located| w.to_string();
        faults.faults.iter().map(line).collect()
    });
    json!({
        "program": program.file,
        "chip": device.name(),
        "bare": expansion.bare,
        "init": list(&expansion.init, device),
        "frame": list(&expansion.frame, device),
        "cost": costs,
        "stored_words": kept(expansion, device),
        "uses": used,
        "destroys": destroyed,
        "constants": expansion.constants,
        "warnings": warnings,
        "changes": changes.map(Changes::json),
    })
}

/// What a chip that extends another changes for a program.
struct Changes {
    /// The chip that is extended.
    base: String,
    /// What is different about the chip.
    chip: Vec<String>,
    /// What the program costs there: words, time, words kept in the store; or why it does not
    /// run there.
    program: Result<(u64, f64, u64), String>,
    /// What it costs here.
    own: (u64, f64, u64),
}

impl Changes {
    fn new(
        program: &Program,
        expansion: &Expansion,
        device: &Device,
        overrides: &Overrides,
    ) -> Option<Self> {
        let base = device.base()?;
        let of = |expansion: &Expansion, device: &Device| {
            let cost = Cost::of(&expansion.code.frame, device);
            (cost.words.0, cost.micros(), kept(expansion, device))
        };
        Some(Self {
            base: base.name().to_owned(),
            chip: differences(base, device),
            program: match program.expand(base, overrides) {
                Ok(there) => Ok(of(&there, base)),
                Err(faults) => Err(faults
                    .faults
                    .first()
                    .map_or_else(|| faults.to_string(), ToString::to_string)),
            },
            own: of(expansion, device),
        })
    }

    fn lines(&self) -> Vec<String> {
        let mut lines = vec![String::new(), format!("against {}", self.base)];
        lines.extend(self.chip.iter().map(|what| format!("  {what}")));
        lines.push(match &self.program {
            Err(why) => format!("  the program does not run there: {why}"),
            Ok(there) if *there == self.own => {
                "  the program costs the same".to_owned()
            }
            Ok((words, micros, kept)) => format!(
                "  the program's frame: {} words instead of {words}, {:.1} us instead of {micros:.1}, {} words stored instead of {kept}",
                self.own.0, self.own.1, self.own.2
            ),
        });
        lines
    }

    fn json(&self) -> serde_json::Value {
        let cost = |(words, micros, kept): &(u64, f64, u64)| json!({"words": words, "us": micros, "stored_words": kept});
        json!({
            "base": self.base,
            "chip": self.chip,
            "base_cost": self.program.as_ref().ok().map(cost),
            "base_error": self.program.as_ref().err(),
            "cost": cost(&self.own),
        })
    }
}

/// In words, one a line.
fn differences(base: &Device, device: &Device) -> Vec<String> {
    let mut lines = Vec::new();
    let registers = |device: &Device| {
        let registers = device.registers();
        [registers.analog.clone(), registers.digital.clone()]
    };
    for (before, after) in registers(base).iter().zip(&registers(device)) {
        let only = |a: &[String], b: &[String]| {
            let names: Vec<&str> = a
                .iter()
                .filter(|n| !b.contains(n))
                .map(String::as_str)
                .collect();
            names.join(" ")
        };
        let (more, less) = (only(after, before), only(before, after));
        if !more.is_empty() {
            lines.push(format!("more registers: {more}"));
        }
        if !less.is_empty() {
            lines.push(format!("without the registers: {less}"));
        }
    }
    for figure in Figure::ALL {
        let (before, after) = (base.value(*figure), device.value(*figure));
        if before != after {
            let (section, key) = figure.key();
            let after = figure.shown(after);
            lines.push(format!("{section}.{key}: {after} instead of {before}"));
        }
    }
    for row in device.primitives() {
        let before = base.row(row.kind);
        if before.words != row.words {
            let name = row.forms.first().map_or("", |form| form.name.as_str());
            lines.push(format!(
                "{name}: {} words instead of {}",
                row.words, before.words
            ));
        }
        if before.forms != row.forms {
            lines.push(format!("{:?}: written in other ways", row.kind));
        }
    }
    for row in device.hosts() {
        let before = base.host(row.kind);
        if before.call != row.call || before.item != row.item {
            let name = row.forms.first().map_or("", |form| form.name.as_str());
            lines.push(format!("{name}: takes another time"));
        }
    }
    for it in device.macros() {
        match base.macros().iter().find(|m| m.replaces(it)) {
            None => lines.push(format!("new macro: {}", it.signature)),
            Some(before) if before.body != it.body => {
                lines.push(format!("another body: {}", it.signature));
            }
            Some(_) => {}
        }
    }
    if lines.is_empty() {
        lines.push("nothing about the chip is different".to_owned());
    }
    lines
}
