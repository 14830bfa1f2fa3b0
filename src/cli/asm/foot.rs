//! The foot of a program (`//=`), held to what its words are.

use crate::{
    cli::input::opened_program::Opened,
    program::{Cost, ExpectedWords},
};

/// That the words which stand below a program, one a warning, are not those that it has.
pub fn miscounted(opened: &Opened) -> Vec<String> {
    let Some(ExpectedWords { init, frame }) = opened.program.expectation.words else {
        return Vec::new();
    };
    let code = &opened.expansion.code;
    let of = |steps| Cost::of(steps, &opened.device).words.0;
    let stated = [
        ("init", init, of(&code.init)),
        ("frame", frame, of(&code.frame)),
    ];
    { stated.into_iter() }
        .filter(|(_, stated, counted)| stated != counted)
        .map(|(part, stated, counted)| {
            format!(
                "warning: {}: `{part} = {stated}` stands below it, and its {part} has {}; write `{part} = {counted}`, or leave [words] out\n",
                opened.program.file,
                crate::unit::counted(counted, "word"),
            )
        })
        .collect()
}
