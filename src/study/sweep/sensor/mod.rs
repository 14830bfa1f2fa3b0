//! From a point to its sensor.
//!
//! - [`description`]: the text of the sensor, and of the f64 sensor that it is measured against.
//! - [`build`]: the float model, or the chip with its program; [`level_program`]: programs of kernels
//!   in few values.

pub(super) mod build;
pub(super) mod description;
pub(super) mod level_program;

#[cfg(test)]
mod tests {
    use std::{fmt::Write as _, sync::Arc};

    use super::build::{ArraySpec, Float};
    use crate::{
        isa::Device,
        kernel::Kernel,
        study::sweep::{
            points::{
                plan::{kernel_name, wanted},
                point::Point,
            },
            study_file::{
                key::{Key, Side},
                study::Study,
            },
        },
    };

    /// Keys with a value each.
    type Values = &'static [(&'static str, &'static str)];

    const SCENE: Values = &[
        ("scene", "\"pattern:disc\""),
        ("fps", "50"),
        ("frames", "3"),
        ("range", "\"full\""),
        ("transfer", "\"linear\""),
        ("scale", "2"),
        ("slice", "\"..5\""),
        ("crop", "\"8x8\""),
        ("resize", "\"4x4\""),
        ("upsample", "0.5"),
        ("seed", "1"),
    ];

    const FLOAT: Values = &[
        ("threshold", "9"),
        ("response", "{ linear = 255 }"),
        ("memory", "\"filtered-step\""),
        ("polarity", "\"pixel\""),
        ("refractory", "{ us = 100 }"),
        ("noise", "{ jitter-us = 5 }"),
        ("format", "\"f32\""),
    ];

    /// The point of these values, and others where they are given.
    fn point(side: Side, values: &[(&str, &str)], other: (&str, &str)) -> Point {
        let mut text = format!("[[side]]\nside = \"{side}\"\n{} = {}\n", other.0, other.1);
        for (key, value) in values.iter().filter(|(key, _)| *key != other.0) {
            let _ = writeln!(text, "{key} = {value}");
        }
        let study = Study::parse("study.toml", &text).unwrap_or_else(|e| panic!("{e:?}\n{text}"));
        study.points().unwrap().remove(0)
    }

    /// All that a point is made of.
    fn made_of(point: &Point) -> String {
        let scene = wanted(point).unwrap();
        let kernels = [Kernel::builtin(kernel_name(point)).unwrap()];
        let Some(chip) = point.word("chip") else {
            let float = Float::of(point, &kernels).unwrap();
            return format!("{scene:?} {float:?}");
        };
        let chip = Arc::new(Device::find(chip).unwrap());
        let array = ArraySpec::of(point, &kernels, (&chip, 0)).unwrap();
        format!("{scene:?} {array:?}")
    }

    /// A key that nobody reads would have a column of results that are all the same.
    #[test]
    fn every_key_changes_what_a_point_is_made_of() {
        let sides: [(Side, Values, [Values; 3]); 3] = [
            (
                Side::Reference,
                &[
                    ("scene", "\"pattern:noise\""),
                    ("kernel", "\"dvs\""),
                    ("threshold", "{ on = 8, off = 8, sigma = 1 }"),
                    ("memory", "\"raw-snap\""),
                ],
                [
                    SCENE,
                    FLOAT,
                    &[
                        ("kernel", "\"csdvs-3\""),
                        ("border", "\"replicate\""),
                        ("shared", "true"),
                    ],
                ],
            ),
            (
                Side::Mesh,
                &[
                    ("scene", "\"pattern:noise\""),
                    ("lambda", "2"),
                    ("threshold", "{ on = 8, off = 8, sigma = 1 }"),
                    ("memory", "\"filtered-snap\""),
                ],
                [
                    SCENE,
                    FLOAT,
                    &[
                        ("lambda", "3"),
                        ("lambda-y", "3"),
                        ("tau-us", "10"),
                        ("solver", "\"step\""),
                    ],
                ],
            ),
            (
                Side::Array,
                &[
                    ("scene", "\"pattern:noise\""),
                    ("kernel", "\"csdvs-3\""),
                    ("threshold", "8"),
                    ("quantise", "\"ternary\""),
                    ("domain", "\"silicon\""),
                ],
                [
                    SCENE,
                    &[("chip", "\"scamp5-wide\""), ("kernel", "\"csdvs-5\"")],
                    &[
                        ("threshold", "9"),
                        ("quantise", "\"int-5\""),
                        ("sum", "\"free\""),
                        ("memory", "\"shared\""),
                        ("readout", "\"all\""),
                        ("domain", "\"exact\""),
                        ("schedule", "\"plain\""),
                    ],
                ],
            ),
        ];
        for (side, base, others) in sides {
            let others = others.concat();
            let own = made_of(&point(side, base, base[0]));
            for key in Key::on_side(side) {
                let other = others.iter().find(|(name, _)| *name == key.name);
                let other = other.unwrap_or_else(|| panic!("give {} of {side} here", key.name));
                assert_ne!(
                    made_of(&point(side, base, *other)),
                    own,
                    "{side}: {}",
                    key.name
                );
            }
        }
    }
}
