//! `amacrine`, the command: parse, run, print the diagnostic, exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    amacrine::cli::main()
}
