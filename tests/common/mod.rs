//! The harness of tests that run the program: a command in a folder, what it says, how it
//! refuses, and its pages in a browser.

#![allow(dead_code)] // Each test takes what it needs.

use std::{
    fs,
    path::Path,
    process::{self, Output},
};

use assert_cmd::Command;
use serde_json::Value;

/// The program in a folder, without colours.
pub fn amacrine(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("amacrine").unwrap();
    command.current_dir(folder).env("NO_COLOR", "1");
    command.args(arguments);
    command
}

/// What the program prints when all goes well.
#[track_caller]
pub fn good(folder: &Path, arguments: &[&str]) -> String {
    let said = amacrine(folder, arguments).output().unwrap();
    assert!(
        said.status.success(),
        "{arguments:?}: {}",
        line(&said.stderr)
    );
    String::from_utf8(said.stdout).unwrap()
}

/// What it tells machines; `--json` is added where it is not asked for.
#[track_caller]
pub fn json(folder: &Path, arguments: &[&str]) -> Value {
    let mut all = arguments.to_vec();
    if !all.contains(&"--json") {
        all.push("--json");
    }
    serde_json::from_str(&good(folder, &all)).unwrap()
}

/// A message on one line: long ones are broken at the width of the terminal, and framed.
pub fn line(message: &[u8]) -> String {
    let message = String::from_utf8_lossy(message).replace('│', " ");
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The message of what must fail with exit code 2, without a panic; it has these words.
#[track_caller]
pub fn refused(folder: &Path, arguments: &[&str], words: &[&str]) -> String {
    refusal(&amacrine(folder, arguments).output().unwrap(), words)
}

/// As [`refused`]; besides, nothing is printed and no file comes or goes.
#[track_caller]
pub fn refused_untouched(folder: &Path, arguments: &[&str], words: &[&str]) -> String {
    let files = || folder.read_dir().unwrap().count();
    let before = files();
    let said = amacrine(folder, arguments).output().unwrap();
    let message = refusal(&said, words);
    assert!(said.stdout.is_empty(), "{message}");
    assert_eq!(files(), before, "files were left: {message}");
    message
}

#[track_caller]
pub fn refusal(said: &Output, words: &[&str]) -> String {
    let message = line(&said.stderr);
    assert_eq!(said.status.code(), Some(2), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    // Long paths and numbers are broken inside of a word.
    let close = message.replace(' ', "");
    for word in words {
        let found = close.contains(&word.replace(' ', ""));
        assert!(found, "no {word:?} in: {message}");
    }
    message
}

/// Headless Chromium, as Debian has it, in a folder: what it prints, and what it logs. A page that
/// complains is a failure.
#[track_caller]
pub fn chromium(folder: &Path, arguments: &[&str]) -> (String, String) {
    let name = std::env::var("CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let profile = format!("--user-data-dir={}", folder.join("profile").display());
    let done = process::Command::new(name)
        .current_dir(folder)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
        ])
        .args([
            "--enable-logging=stderr",
            "--virtual-time-budget=5000",
            &profile,
        ])
        .args(arguments)
        .output()
        .expect("chromium starts");
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    let (out, log) = (text(&done.stdout), text(&done.stderr));
    // What the page itself complains of; the browser's own complaints are not ours.
    let said: Vec<&str> = log
        .lines()
        .filter(|line| line.contains("CONSOLE"))
        .collect();
    assert_eq!(said, Vec::<&str>::new());
    (out, log)
}

/// A chip that extends SCAMP-5 by these lines, in a folder of its name.
pub fn chip(folder: &Path, name: &str, lines: &str) {
    fs::create_dir(folder.join(name)).unwrap();
    let text = format!("name = \"{name}\"\ntitle = \"{name}\"\nextends = \"scamp5\"\n{lines}");
    fs::write(folder.join(name).join("device.toml"), text).unwrap();
}
