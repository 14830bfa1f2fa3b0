//! From a program to vendor C++.

use std::{collections::BTreeMap, fmt::Write as _};

use crate::{
    isa::{
        Callable, Device, Figure,
        text::{Argument, Expression, Statement, Term},
    },
    program::{
        Program,
        expand::Overrides,
        syntax::{Comment, Item, Node},
    },
};

/// A program that C++ does not take.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{what}")]
#[diagnostic(help("{help}"))]
pub struct WriteError {
    what: String,
    help: String,
}

/// A program as vendor C++: `init` before the loop over the frames, `frame` in it, every
/// constant in its place. Read back, it gives the same instructions, with what `scamp5_in` sets in
/// whole LSB, as the vendor's function takes it and the chip's converter has it.
///
/// # Errors
/// When a number is none that the vendor's functions take, or the program has faults.
pub fn cpp(program: &Program, device: &Device) -> Result<String, WriteError> {
    let expansion = program.expand(device, &Overrides::new());
    let expansion = expansion.map_err(|faults| WriteError {
        what: faults.to_string(),
        help: "fix the program first".to_owned(),
    })?;
    let mut writer = Writer {
        device,
        constants: expansion.constants,
        text: String::new(),
        level: 1,
        kernel: false,
        buffers: BTreeMap::new(),
        shown: 0,
        loops: 0,
    };
    let (mut init, mut frame): (Vec<&Item>, Vec<&Item>) = (Vec::new(), Vec::new());
    let mut bare = Vec::new();
    for it in &program.syntax.items {
        match &it.node {
            Node::Init(body) => init.extend(body),
            Node::Frame(body) => frame.extend(body),
            Node::Comment(_) | Node::Const { .. } => {}
            _ => bare.push(it),
        }
    }
    let alone = init.is_empty() && frame.is_empty();
    if alone {
        frame = bare;
    }
    if !init.is_empty() {
        writer.line("vs_frame_loop_control(); // the first frame");
        writer.items(&init)?;
        writer.line("");
    }
    writer.line("while (1) {");
    writer.level += 1;
    writer.line("vs_frame_loop_control();");
    writer.items(&frame)?;
    writer.level -= 1;
    writer.line("}");
    let mut text = String::new();
    if let Some(title) = &program.settings.title {
        let _ = writeln!(text, "// {title}");
    }
    if let Some(chip) = program
        .settings
        .chip
        .as_ref()
        .filter(|chip| *chip != "scamp5")
    {
        let _ = writeln!(
            text,
            "// for {chip}: asm and exec read it with --chip {chip}"
        );
    }
    text.push_str(&program.settings.names_line());
    text.push_str("#include <scamp5.hpp>\n\nusing namespace SCAMP5_PE;\n\n");
    for (name, bytes) in &writer.buffers {
        let _ = writeln!(text, "uint8_t {name}[{bytes}];");
    }
    if !writer.buffers.is_empty() {
        text.push('\n');
    }
    text.push_str("int main() {\n    vs_init();\n");
    for n in 0..writer.shown {
        let _ = writeln!(
            text,
            "    auto display_{n} = vs_gui_add_display(\"{n}\", 0, {n});"
        );
    }
    text.push('\n');
    text.push_str(&writer.text);
    text.push_str("    return 0;\n}\n");
    Ok(text)
}

struct Writer<'a> {
    device: &'a Device,
    constants: BTreeMap<String, f64>,
    text: String,
    level: usize,
    /// Whether a kernel is open.
    kernel: bool,
    /// Arrays for what is read, with their lengths in bytes.
    buffers: BTreeMap<String, u64>,
    /// Displays so far.
    shown: usize,
    /// Loops so far, which have counters of their own.
    loops: usize,
}

impl Writer<'_> {
    fn line(&mut self, what: &str) {
        if what.is_empty() {
            self.text.push('\n');
            return;
        }
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{:indent$}{what}", "", indent = 4 * self.level);
    }

    /// Begins or ends a kernel.
    fn kernel(&mut self, open: bool) {
        if open && !self.kernel {
            self.line("scamp5_kernel_begin();");
            self.level += 1;
        } else if !open && self.kernel {
            self.level -= 1;
            self.line("scamp5_kernel_end();");
        }
        self.kernel = open;
    }

    fn items(&mut self, items: &[&Item]) -> Result<(), WriteError> {
        for it in items {
            match &it.node {
                Node::Comment(comment) => self.comment(comment),
                Node::Statement(statement) => {
                    let skip = self
                        .device
                        .callables(&statement.name)
                        .iter()
                        .any(|it| matches!(it, Callable::Macro(it) if it.body.is_empty()));
                    if skip {
                        continue;
                    }
                    self.kernel(!self.is_host(&statement.name));
                    let text = self.statement(statement)?;
                    let trailing = it.trailing.as_ref().map(|it| match it {
                        Comment::Line(text) => format!(" //{text}"),
                        Comment::Block(text) => format!(" /*{text}*/"),
                    });
                    self.line(&format!("{text}{}", trailing.unwrap_or_default()));
                }
                Node::Repeat { times, body } => {
                    self.kernel(false);
                    let times = self.number(times)?;
                    let n = self.loops;
                    self.loops += 1;
                    self.line(&format!("for (int i{n} = 0; i{n} < {times}; i{n}++) {{"));
                    self.level += 1;
                    self.items(&body.iter().collect::<Vec<_>>())?;
                    self.kernel(false);
                    self.level -= 1;
                    self.line("}");
                }
                Node::Kernel(kernel) => {
                    self.kernel(false);
                    self.items(&kernel.body.iter().collect::<Vec<_>>())?;
                    self.kernel(false);
                }
                Node::Const { .. } | Node::Init(_) | Node::Frame(_) => {}
            }
        }
        self.kernel(false);
        Ok(())
    }

    fn comment(&mut self, it: &Comment) {
        match it {
            Comment::Line(text) => self.line(&format!("//{text}")),
            Comment::Block(text) => self.line(&format!("/*{text}*/")),
        }
    }

    /// Whether the host does it, outside of kernels.
    fn is_host(&self, name: &str) -> bool {
        let all = self.device.callables(name);
        all.iter().any(|it| match it {
            Callable::Host(..) => true,
            Callable::Macro(it) => it.host,
            Callable::Primitive(..) => false,
        })
    }

    fn statement(&mut self, it: &Statement) -> Result<String, WriteError> {
        let mut given = Vec::new();
        for argument in &it.arguments {
            given.push(match argument {
                Argument::One(value) => self.argument(value)?,
                Argument::Group { items, .. } => {
                    let inner: Result<Vec<String>, _> =
                        items.iter().map(|it| self.argument(it)).collect();
                    format!("{{{}}}", inner?.join(", "))
                }
            });
        }
        let mut remark = String::new();
        if ["scamp5_in", "scamp5_load_in"].contains(&it.name.as_str()) {
            for value in &mut given {
                let Some((real, whole)) = whole(value) else {
                    continue;
                };
                *value = whole;
                remark = format!(" // {real} LSB; the converter has whole ones");
            }
        }
        let mut name = it.name.as_str();
        match name {
            // The vendor's masks go with what was selected before; a pattern says both.
            "scamp5_select_rowx" | "scamp5_select_colx" if given.len() == 2 => {
                let side = |figure| self.device.value(figure);
                let narrow = side(Figure::Height).max(side(Figure::Width)) <= 256.0;
                let any = if narrow { "255" } else { "65535" };
                let at = usize::from(name == "scamp5_select_rowx");
                given.insert(at, "0".to_owned());
                given.insert(2 + at, any.to_owned());
                name = "scamp5_select_pattern";
            }
            "scamp5_output_image" | "scamp5_output_areg" => {
                given.truncate(1);
                given.push(format!("display_{}", self.shown));
                self.shown += 1;
            }
            "scamp5_scan_events" => {
                let slots = given.get(2).and_then(|it| it.parse::<u64>().ok());
                let slots = slots.unwrap_or(1000);
                if given.len() == 2 {
                    given.push(slots.to_string());
                }
                self.buffer(given.get(1), 2 * slots);
            }
            "scamp5_scan_boundingbox" => self.buffer(given.get(1), 4),
            "scamp5_scan_areg_8x8" | "scamp5_scan_areg_mean_8x8" => self.buffer(given.get(1), 64),
            "scamp5_scan_areg" => self.buffer(given.get(1), 65536),
            "scamp5_scan_dreg" => self.buffer(given.get(1), 8192),
            _ => {}
        }
        Ok(format!("{name}({});{remark}", given.join(", ")))
    }

    fn buffer(&mut self, name: Option<&String>, bytes: u64) {
        if let Some(name) = name.filter(|name| !name.starts_with(|c: char| c.is_ascii_digit())) {
            let most = self.buffers.entry(name.clone()).or_default();
            *most = bytes.max(*most);
        }
    }

    fn argument(&self, it: &Expression) -> Result<String, WriteError> {
        if let Term::Name(name) = &it.term
            && (!self.constants.contains_key(name) || self.device.value_of(name).is_some())
        {
            return Ok(name.clone());
        }
        self.number(it).map(|value| value.to_string())
    }

    fn number(&self, it: &Expression) -> Result<f64, WriteError> {
        let value = match &it.term {
            Term::Number(value) => *value,
            Term::Name(name) => match self.constants.get(name) {
                Some(value) => *value,
                None => return Err(no_number(it)),
            },
            Term::Negate(inner) => -self.number(inner)?,
            Term::Binary {
                operator,
                left,
                right,
            } => operator.apply(self.number(left)?, self.number(right)?),
            Term::Of { .. } => return Err(no_number(it)),
        };
        Ok(value + 0.0)
    }
}

fn no_number(it: &Expression) -> WriteError {
    WriteError {
        what: format!("`{it}` is no number"),
        help: "constants are numbers".to_owned(),
    }
}

/// A number that is not whole, and the whole one that the chip's converter sets for it.
fn whole(value: &str) -> Option<(f64, String)> {
    let real: f64 = value.parse().ok()?;
    (real.fract() != 0.0).then(|| (real, (real.round_ties_even() as i64).to_string()))
}
