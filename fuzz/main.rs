//! The target that `AMACRINE_FUZZ` names; `AMACRINE_FUZZ=list` prints all names.
#![no_main]

use std::sync::OnceLock;

use amacrine_fuzz::{TARGETS, Target, mutate, spare_what_is_guarded};
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

fn target() -> &'static Target {
    static TARGET: OnceLock<&Target> = OnceLock::new();
    TARGET.get_or_init(|| {
        spare_what_is_guarded();
        let asked = std::env::var("AMACRINE_FUZZ").unwrap_or_default();
        let names = TARGETS.iter().map(|target| target.name);
        let names = names.collect::<Vec<_>>().join("\n");
        if asked == "list" {
            println!("{names}");
            std::process::exit(0);
        }
        let mut targets = TARGETS.iter();
        targets
            .find(|target| target.name == asked)
            .unwrap_or_else(|| {
                eprintln!("AMACRINE_FUZZ should be one of\n{names}");
                std::process::exit(2);
            })
    })
}

fuzz_target!(init: { target(); }, |bytes: &[u8]| (target().run)(bytes));

fuzz_mutator!(|data: &mut [u8], size: usize, room: usize, seed: u32| {
    // Bits as libFuzzer likes them, or a number of the file's own structure.
    let Some(edited) = mutate::edited(target().shape, &data[..size], room, seed) else {
        return fuzzer_mutate(data, size, room);
    };
    data[..edited.len()].copy_from_slice(&edited);
    edited.len()
});
