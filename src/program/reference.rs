//! The reference of a chip's instructions, generated from its data: `docs/scamp5.md` is this text.

use std::fmt::Write as _;

use super::{
    Cost, Expansion,
    sample::{Sample, destroyed, nearest_to_one, sample, samples},
};
use crate::isa::{
    Clock, Device, Figure, HostRow, Macro, Operand, PrimitiveKind, PrimitiveRow, Quantity,
    Signature,
    macros::Item,
    signature::{Mode, Parameter},
};

/// Numbers tried to find how a macro's words go with its numbers.
const TRIED: std::ops::RangeInclusive<i32> = 1..=6;

/// Everything that a statement can be on this chip, as Markdown: equation, operands, aliases,
/// what is destroyed, words, evidence.
#[must_use]
pub fn reference(device: &Device) -> String {
    let mut text = format!("# {}\n\n", device.title());
    text.push_str(HEAD);
    text.push_str(
        "\n## Numbers\n\n| figure | value | unit | evidence | source | from | to | why not less or more |\n|---|---|---|---|---|---|---|---|\n",
    );
    for figure in Figure::ALL {
        let (section, key) = figure.key();
        let quantity = device.figure(*figure);
        let (value, unit, evidence) = (quantity.value, &quantity.unit, quantity.evidence.word());
        let source = source(quantity);
        let between = match &quantity.interval {
            Some(it) => format!(
                "{} | {} | {} ({})",
                it.low,
                it.high,
                it.why,
                it.evidence.word()
            ),
            None => " | | ".to_owned(),
        };
        line(
            &mut text,
            &format!(
                "| `{section}.{key}` | {value} | {unit} | {evidence} | {source} | {between} |"
            ),
        );
    }
    let pictured = samples(device);
    text.push_str("\n## Primitives\n\nOne instruction word of the array each. ");
    text.push_str(PICTURES);
    for row in device.primitives() {
        primitive(&mut text, row, &pictured);
    }
    text.push_str(MACROS);
    for it in device.macros().iter().filter(|it| !it.host) {
        of_macro(&mut text, it, device, &pictured);
    }
    text.push_str(HOST_MACROS);
    for it in device.macros().iter().filter(|it| it.host) {
        of_macro(&mut text, it, device, &pictured);
    }
    text.push_str("\n## Host operations\n\nDone by the micro-controller; no word of the array. `call` is paid once, `item` for each slot, sample or row.\n");
    for row in device.hosts() {
        host(&mut text, row);
    }
    text
}

const HEAD: &str = "\
Written from `isa/` by `AMACRINE_BLESS=1 cargo test --test instructions`; a test holds it to the files there.

- Forms are read as `isa/README.md` explains: `areg` an analogue register, `source` what a bus can read, `target` what it can store in, `dreg` and `bit` the same for one bit, `dir` a direction; `out`, `inout` and `trash` are written.
- A direction is that of the neighbour which is read: `movx(A, B, east)` moves the picture west.
- Analogue stores happen where FLAG is 1, each pixel by its own; a store into a neighbour's NEWS by the FLAG of the pixel that drives it. One-bit words do not look at FLAG.
- A register may stand at several places of a form unless it is said to be illegal. What a form destroys may not be its operand: the chip then gives what the sequence of words gives, and `asm` warns.
- From and to: what the public data allow where the value itself is modelled or a guess, with the evidence of these bounds. `feasibility --chips` draws chips from them.
- Evidence: `measured` on the chip or from its published data, `quoted` from whoever made it, `modelled`, `guess`. CAREY13, HW, KIM, 5C, TUT, AICSP13, CNN, ANET: see the head of `isa/scamp5/device.toml` and `isa/scamp5/primitives.toml`.
";

const PICTURES: &str = "\
The pictures show what each register held before a call and holds after it, without errors; what the call has written is framed. Analogue registers are black at -128 LSB and white at 127, bits are white where they are 1.
";

const MACROS: &str = "
## Macros

Sequences of words. Those of the vendor are quoted (HW) where nothing else is said.
";

const HOST_MACROS: &str = "
## Kernels of the host

Macros that the host launches as kernels of its own: their words run and take time, but do not fill the kernel store of the program.
";

fn line(text: &mut String, what: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{what}");
}

fn primitive(text: &mut String, row: &PrimitiveRow, pictured: &[Sample<'_>]) {
    heading(text, &row.forms);
    pictures(text, &row.forms, pictured);
    line(text, &format!("{}\n", row.equation));
    let aliases = match row.kind {
        PrimitiveKind::Bus | PrimitiveKind::Square | PrimitiveKind::Where => {
            "illegal: all registers of one bus must differ, targets too; twice is one connection"
        }
        PrimitiveKind::Blur => "illegal: y = x",
        PrimitiveKind::Or | PrimitiveKind::Nor => {
            "d = s is warned of: the chip takes two words, as `OR(r, x)`, `NOR(r, x)`, `NOT(r)` and `REFRESH(r)` do"
        }
        PrimitiveKind::Nop
        | PrimitiveKind::ResetPix
        | PrimitiveKind::All
        | PrimitiveKind::BlurSet
        | PrimitiveKind::Set
        | PrimitiveKind::Clear
        | PrimitiveKind::WhereBit
        | PrimitiveKind::Dnews
        | PrimitiveKind::PropRead
        | PrimitiveKind::Prop => "legal: all",
    };
    line(text, &format!("- aliases: {aliases}"));
    line(text, "- destroys: nothing");
    let clock = match row.clock {
        Clock::Analog => "analogue",
        Clock::Digital => "digital",
        Clock::Dnews => "DNEWS",
        Clock::Prop => "PROP",
    };
    line(text, &format!("- words: {}, {clock} clock", row.words()));
    line(
        text,
        &format!(
            "- evidence: {}; {}",
            row.cost.evidence.word(),
            row.cost.source
        ),
    );
}

fn heading(text: &mut String, forms: &[Signature]) {
    if let [one] = forms {
        line(text, &format!("\n### `{}`\n", full(one)));
        return;
    }
    let mut names: Vec<String> = forms.iter().map(|f| format!("`{}`", f.name)).collect();
    names.dedup();
    line(text, &format!("\n### {}\n\n```text", names.join(", ")));
    for form in forms {
        line(text, &full(form));
    }
    line(text, "```\n");
}

/// What the registers hold before and after a call of each form.
fn pictures(text: &mut String, forms: &[Signature], pictured: &[Sample<'_>]) {
    let shown = { pictured.iter() }.filter(|sample| forms.contains(sample.form));
    let shown: Vec<String> = shown
        .map(|it| format!("![{}](instructions/{}.png)", it.call, it.name))
        .collect();
    if !shown.is_empty() {
        line(text, &format!("{}\n", shown.join(" ")));
    }
}

/// A form as it stands in the chip's files.
fn full(form: &Signature) -> String {
    let parameters: Vec<String> = form.parameters.iter().map(parameter).collect();
    format!("{}({})", form.name, parameters.join(", "))
}

fn parameter(it: &Parameter) -> String {
    if let Operand::Literal(value) = it.operand {
        return value.to_string();
    }
    let mode = match it.mode {
        Mode::In => "",
        Mode::Out => "out ",
        Mode::InOut => "inout ",
        Mode::Trash => "trash ",
    };
    let bounds = |low: f64, high: f64| {
        if low == f64::MIN {
            String::new()
        } else {
            format!("[{low}..{high}]")
        }
    };
    let kind = match it.operand {
        Operand::Areg => "areg".to_owned(),
        Operand::Target => "target".to_owned(),
        Operand::Source => "source".to_owned(),
        Operand::Dreg => "dreg".to_owned(),
        Operand::Bit => "bit".to_owned(),
        Operand::Direction => "dir".to_owned(),
        Operand::Directions => "dirs".to_owned(),
        Operand::Number(low, high) => format!("lsb{}", bounds(low, high)),
        Operand::Integer(low, high) => format!("int{}", bounds(low, high)),
        Operand::Word => "word".to_owned(),
        Operand::Literal(value) => value.to_string(),
    };
    let count = match it.count {
        (1, 1) => String::new(),
        (least, most) if most >= 1_000_000 => format!(" * {least}.."),
        (least, most) => format!(" * {least}..{most}"),
    };
    let default = it.default.as_ref();
    let default = default.map_or(String::new(), |value| format!(" = {value}"));
    let plain = format!("{mode}{}: {kind}{count}{default}", it.name);
    if it.group {
        format!("{{{plain}}}")
    } else {
        plain
    }
}

fn of_macro(text: &mut String, it: &Macro, device: &Device, pictured: &[Sample<'_>]) {
    let forms = std::slice::from_ref(&it.signature);
    heading(text, forms);
    pictures(text, forms, pictured);
    line(text, &format!("{}\n", it.doc.replace('\n', " ")));
    let illegal: Vec<String> = it
        .distinct
        .iter()
        .map(|d| format!("{} = {} ({})", d.first, d.second, d.reason))
        .collect();
    let aliases = if illegal.is_empty() {
        "legal: all".to_owned()
    } else {
        format!("illegal: {}", illegal.join("; "))
    };
    line(text, &format!("- aliases: {aliases}"));
    if it.whole_flag {
        line(text, "- FLAG: must be 1 everywhere");
    }
    let destroyed = destroyed(&it.signature, device);
    line(text, &format!("- destroys: {}", or_nothing(&destroyed)));
    if !it.gives.is_empty() {
        line(text, &format!("- gives: {}", it.gives.join(", ")));
    }
    line(text, &format!("- words: {}", words(it, device)));
    match &it.evidence {
        Some((evidence, source)) => {
            line(text, &format!("- evidence: {}; {source}", evidence.word()));
        }
        None => line(text, "- evidence: quoted; HW"),
    }
    let mut body = String::new();
    sequence(&mut body, &it.body, 0);
    if body.is_empty() {
        body.push_str("// nothing\n");
    }
    let _ = write!(text, "\n```text\n{body}```\n");
}

fn or_nothing(names: &[String]) -> String {
    if names.is_empty() {
        return "nothing".to_owned();
    }
    names.join(", ")
}

fn sequence(text: &mut String, body: &[Item], level: usize) {
    let indent = "    ".repeat(level);
    for item in body {
        match item {
            Item::Statement(statement) => line(text, &format!("{indent}{statement}")),
            Item::Repeat { times, body } => {
                line(text, &format!("{indent}repeat {times} {{"));
                sequence(text, body, level + 1);
                line(text, &format!("{indent}}}"));
            }
        }
    }
}

/// The number of words of a macro, and how it depends on its numeric parameters.
fn words(it: &Macro, device: &Device) -> String {
    let numbers: Vec<&Parameter> = it
        .signature
        .parameters
        .iter()
        .filter(|p| matches!(p.operand, Operand::Integer(..)))
        .collect();
    let of = |values: &[f64]| {
        let (.., Expansion { code, .. }) = sample(&it.signature, device, values)?;
        Some(Cost::of(&code.frame, device).words.0)
    };
    let base = nearest_to_one(&it.signature);
    let Some(once) = of(&base) else {
        return "as its operands ask".to_owned();
    };
    let mut parts = Vec::new();
    for (at, p) in numbers.iter().enumerate() {
        let Operand::Integer(low, high) = p.operand else {
            continue;
        };
        let tried = TRIED.map(f64::from).filter(|n| (low..=high).contains(n));
        let counts: Option<Vec<(f64, u64)>> = tried
            .map(|n| {
                let mut values = base.clone();
                values[at] = n;
                Some((n, of(&values)?))
            })
            .collect();
        let Some(counts) = counts else { continue };
        let steps: Vec<u64> = counts
            .windows(2)
            .map(|pair| pair[1].1.saturating_sub(pair[0].1))
            .collect();
        match steps.as_slice() {
            [] => {}
            [first, rest @ ..] if rest.iter().all(|s| s == first) => {
                if *first > 0 {
                    parts.push(format!("{first} more for each step of {}", p.name));
                }
            }
            _ => {
                let list: Vec<String> = counts.iter().map(|(_, w)| w.to_string()).collect();
                let ends = counts.first().zip(counts.last());
                let (first, last) = ends.map_or((0.0, 0.0), |(a, b)| (a.0, b.0));
                let list = list.join(", ");
                parts.push(format!("{list} for {} = {first} to {last}", p.name));
            }
        }
    }
    if parts.is_empty() {
        return once.to_string();
    }
    let at: Vec<String> = numbers
        .iter()
        .zip(&base)
        .map(|(p, value)| format!("{} = {value}", p.name))
        .collect();
    format!("{once} for {}; {}", at.join(", "), parts.join("; "))
}

fn host(text: &mut String, row: &HostRow) {
    heading(text, &row.forms);
    line(text, &format!("{}\n", row.meaning));
    let trash: Vec<String> = row
        .forms
        .iter()
        .flat_map(|form| &form.parameters)
        .filter(|p| p.mode == Mode::Trash)
        .map(|p| p.name.clone())
        .collect();
    line(text, "- aliases: legal: all");
    line(text, &format!("- destroys: {}", or_nothing(&trash)));
    let quantity = |what: &str, quantity: &Quantity| {
        let (value, unit, evidence) = (quantity.value, &quantity.unit, quantity.evidence.word());
        let between = quantity.interval.as_ref().map_or(String::new(), |it| {
            let evidence = it.evidence.word();
            format!("; from {} to {} ({evidence}): {}", it.low, it.high, it.why)
        });
        format!(
            "- {what}: {value} {unit}, {evidence}; {}{between}",
            source(quantity)
        )
    };
    line(text, "- words: 0");
    line(text, &quantity("call", &row.call));
    if let Some(item) = &row.item {
        line(text, &quantity("item", item));
    }
}

/// Where a quantity comes from, and what is noted about it.
fn source(quantity: &Quantity) -> String {
    let note = quantity
        .note
        .as_ref()
        .map_or(String::new(), |n| format!("; {n}"));
    format!("{}{note}", quantity.source)
}
