//! `amacrine man`: a manual page for each verb.

use std::io;

use clap_mangen::Man;

use super::{
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
    /// The folder of the pages
    #[arg(short, long, value_name = "FOLDER", value_parser = Content::Folder)]
    output: Output,
}

/// Runs the verb.
///
/// # Errors
/// When a page cannot be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let all = super::command();
    let mut pages = vec![("amacrine".to_owned(), all.clone())];
    for verb in all.get_subcommands() {
        let name = format!("amacrine-{}", verb.get_name());
        let called = format!("amacrine {}", verb.get_name());
        let page = verb.clone().display_name(name.clone()).bin_name(called);
        pages.push((name, page));
    }
    let path = |name: &str| arguments.output.join(format!("{name}.1"));
    files::writes(pages.iter().map(|(name, _)| path(name)))?;
    for (name, command) in pages {
        let mut text = Vec::new();
        let rendered = Man::new(command).render(&mut text);
        let rendered = rendered.map_err(io::Error::other);
        save(&path(&name), |file| {
            rendered?;
            file.write_all(&text)
        })?;
    }
    let (pages, folder) = (
        all.get_subcommands().count() + 1,
        arguments.output.display(),
    );
    super::say(&format!("wrote    {pages} pages in {folder}\n"));
    Ok(())
}
