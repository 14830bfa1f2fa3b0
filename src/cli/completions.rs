//! `amacrine completions`: what a shell needs to complete the command line.

use clap_complete::{Shell, generate};

/// What `completions` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine completions bash > ~/.local/share/bash-completion/completions/amacrine\n  amacrine completions zsh > ~/.zfunc/_amacrine\n  amacrine completions fish > ~/.config/fish/completions/amacrine.fish"
)]
pub struct Arguments {
    /// Shell
    shell: Shell,
}

/// Runs the verb.
///
/// # Errors
/// None.
#[expect(clippy::unnecessary_wraps, reason = "as all verbs")]
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let mut text = Vec::new();
    generate(
        arguments.shell,
        &mut super::command(),
        "amacrine",
        &mut text,
    );
    super::say(&String::from_utf8_lossy(&text));
    Ok(())
}
