//! `amacrine`, the command: parse, run, print the diagnostic, exit code.
//!
//! The command line is a room of the program, not of the library: nobody who links the library
//! compiles it.

#![warn(clippy::disallowed_methods)]
#![cfg_attr(test, allow(clippy::disallowed_methods))]

mod cli;

use std::process::ExitCode;

// The rooms of the library by the names that they have in it.
use amacrine::{
    array, bundled, catch_panic, compare, compile, config, elementary, event, isa, kernel, limit,
    memory, mesh, npy, number, photoreceptor, picture, plane, program, reference, rig, save, scene,
    sensor, source, stop, study, told, unit,
};

fn main() -> ExitCode {
    cli::main()
}
