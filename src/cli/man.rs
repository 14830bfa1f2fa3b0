//! `amacrine man`: a manual page for each verb, and for each verb of `mesh`.

use std::io;

use clap::Command;
use clap_mangen::Man;

use super::output::{
    content::Content,
    files::{self, Output},
};
use crate::save::save;

/// What `man` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine man -o ~/.local/share/man/man1\n\nThen `man amacrine-run` shows what `amacrine run --help` prints."
)]
pub struct Arguments {
    /// Folder of the pages
    #[arg(short, long, value_name = "FOLDER", value_parser = Content::Folder)]
    output: Output,
}

/// Runs the verb.
///
/// # Errors
/// When a page cannot be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let mut all = without_help(super::command());
    // Options of all verbs come into each of them.
    all.build();
    let mut pages = Vec::new();
    add("amacrine", "amacrine", &all, &mut pages);
    let path = |name: &str| arguments.output.join(format!("{name}.1"));
    files::writes(pages.iter().map(|(name, _)| path(name)))?;
    let count = pages.len();
    for (name, command) in pages {
        let mut text = Vec::new();
        let rendered = Man::new(command).render(&mut text);
        let rendered = rendered.map_err(io::Error::other);
        save(&path(&name), |file| {
            rendered?;
            file.write_all(&text)
        })?;
    }
    let folder = arguments.output.display();
    super::say(&format!("wrote    {count} pages in {folder}\n"));
    Ok(())
}

/// Without the verbs `help`, which have no page.
fn without_help(command: Command) -> Command {
    let verbs: Vec<String> = { command.get_subcommands() }
        .map(|verb| verb.get_name().to_owned())
        .collect();
    let command = command.disable_help_subcommand(true);
    verbs.into_iter().fold(command, |command, verb| {
        command.mut_subcommand(verb, without_help)
    })
}

/// The page of a command, and those of its own.
fn add(name: &str, called: &str, command: &Command, pages: &mut Vec<(String, Command)>) {
    let page = command.clone().display_name(name.to_owned());
    pages.push((name.to_owned(), page.bin_name(called.to_owned())));
    for verb in command.get_subcommands() {
        let verb_name = verb.get_name();
        let (name, called) = (
            format!("{name}-{verb_name}"),
            format!("{called} {verb_name}"),
        );
        add(&name, &called, verb, pages);
    }
}
