//! Vendor C++ as a text: the numbers that it loads, and what is told of it.

#![allow(dead_code)] // Each test takes what it needs.

use amacrine::{
    config::Faults,
    isa::Device,
    program::{Action, Expansion, Host, Includes, Overrides, Program, Step},
};

/// A file with others beside it.
pub fn expand_with(text: &str, includes: &Includes) -> Result<Expansion, Faults> {
    Program::read_with("p.cpp", text, includes).expand(&Device::scamp5(), &Overrides::new())
}

/// A file by itself.
pub fn expand(text: &str) -> Result<Expansion, Faults> {
    expand_with(text, &Includes::new())
}

/// The numbers that a program loads.
pub fn loaded(steps: &[Step]) -> Vec<f64> {
    let all = steps.iter().map(|it| match &it.action {
        Action::Host(Host::LoadIn { value }) => vec![*value],
        Action::Repeat { times, body } => loaded(body).repeat(*times as usize),
        _ => Vec::new(),
    });
    all.flatten().collect()
}

/// A program that loads numbers, and the numbers.
#[track_caller]
pub fn numbers_of(read: Result<Expansion, Faults>, all: &[i32], text: &str) {
    let code = read.unwrap_or_else(|faults| panic!("{faults:?}\n{text}"));
    let all: Vec<f64> = all.iter().map(|n| f64::from(*n)).collect();
    assert_eq!(loaded(&code.code.frame), all, "{text}");
}

/// C++ that loads numbers, with what stands before `main`, and the numbers.
#[track_caller]
pub fn numbers(before: &str, inside: &str, all: &[i32]) {
    let text = format!("{before}\nint main() {{ {inside} }}");
    numbers_of(expand(&text), all, &text);
}

/// What is told of C++ that is refused, with its line.
#[track_caller]
pub fn told(text: &str, line: u32, message: &str, help: &str) {
    let faults = expand(text).expect_err(text).faults;
    let found = faults.iter().any(|it| {
        it.line == line
            && it.fault.message.contains(message)
            && it.fault.help.as_deref().unwrap_or_default().contains(help)
    });
    assert!(found, "{text}\n{faults:#?}");
}
