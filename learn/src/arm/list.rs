//! The arms that a task may name.

use super::{Arm, Cells, Few, Sight, Start};
use crate::levels::Levels;

/// Their names, in the order in which they are told; all other [`Levels`] are arms too, by theirs.
pub const NAMES: &[&str] = &[
    "blend",
    "none",
    "dvs",
    "csdvs",
    "laplacian",
    "dog",
    "rgc",
    "rgc-rounded",
    "ternary",
    "int-5",
    "mesh",
    "rgc-k2",
    "rgc-k4",
    "rgc-2x2",
    "fs-dvs",
];

/// The arm of a name: one of [`NAMES`], or that of the few values that its weights come to have.
///
/// ```
/// use amacrine_learn::arm;
/// assert!(arm::NAMES.iter().all(|name| arm::named(name).is_some()));
/// assert_eq!(arm::named("rgc-k4").unwrap().kinds(), 4);
/// assert!(arm::named("po2-2:mirror").is_some() && arm::named("po2-9").is_none());
/// ```
#[must_use]
pub fn named(name: &str) -> Option<Arm> {
    let given = |kernel: &str| Cells {
        start: Start::Builtin(kernel.to_owned()),
        learned: false,
        ..free()
    };
    let cells = match name {
        "blend" | "none" => None,
        "dvs" => Some(given("dvs")),
        "csdvs" => Some(given("csdvs-5")),
        "laplacian" => Some(given("laplacian")),
        // As near to the one point as it can be, with a wide surround.
        "dog" => Some(Cells {
            start: Start::Gaussians([0.4, 1.2, -0.3]),
            ..free()
        }),
        "rgc" => Some(free()),
        "rgc-rounded" => Some(Cells {
            few: few("ternary", false),
            ..free()
        }),
        // What resistors between pixels carry: the pixel, less its surround.
        "mesh" => Some(Cells {
            start: Start::Mesh([1.0, -0.3]),
            ..free()
        }),
        "rgc-k2" => Some(Cells { kinds: 2, ..free() }),
        "rgc-k4" => Some(Cells { kinds: 4, ..free() }),
        "rgc-2x2" => Some(Cells {
            pattern: true,
            ..free()
        }),
        "fs-dvs" => Some(Cells {
            log: true,
            ..free()
        }),
        // Few values, by what they are called.
        _ => Some(Cells {
            few: Some(few(name, true).filter(|few| few.levels.to_string() == name)?),
            ..free()
        }),
    };
    let sight = match (cells, name) {
        (Some(cells), _) => Sight::Events(cells),
        (None, "blend") => Sight::Blend,
        (None, _) => Sight::Frames,
    };
    Some(Arm {
        name: name.to_owned(),
        sight,
    })
}

fn few(name: &str, drawn: bool) -> Option<Few> {
    Levels::parse(name).map(|levels| Few { levels, drawn })
}

/// A learned kernel of any weights, that of an event camera at first.
const fn free() -> Cells {
    Cells {
        start: Start::Delta(5),
        learned: true,
        kinds: 1,
        pattern: false,
        few: None,
        log: false,
    }
}
