//! Disassembly: expanded code as text, one primitive a line, in the vendor's notation. Parsed
//! again, it gives the same words.

use std::fmt::Write as _;

use super::{Action, Code, Step};
use crate::isa::Device;

/// The words of a program as text.
#[must_use]
pub fn vendor_text(code: &Code, bare: bool, device: &Device) -> String {
    let mut text = String::new();
    if bare {
        steps(&mut text, &code.frame, device, 0);
        return text;
    }
    for (name, list) in [("init", &code.init), ("frame", &code.frame)] {
        if !list.is_empty() {
            line(&mut text, 0, &format!("{name} {{"));
            steps(&mut text, list, device, 1);
            line(&mut text, 0, "}");
        }
    }
    text
}

fn steps(text: &mut String, list: &[Step], device: &Device, level: usize) {
    for step in list {
        match &step.action {
            Action::Word(word) => line(text, level, &format!("{};", word.text(device))),
            Action::Host(host) => line(text, level, &format!("{};", host.text(device))),
            Action::Repeat { times, body } => {
                line(text, level, &format!("repeat {times} {{"));
                steps(text, body, device, level + 1);
                line(text, level, "}");
            }
        }
    }
}

fn line(text: &mut String, level: usize, what: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{:indent$}{what}", "", indent = 4 * level);
}
