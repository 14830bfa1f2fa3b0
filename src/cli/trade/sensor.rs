//! The trade of a sensor file.

use super::{
    super::{files::Input, quoted::quoted, run::read_sensor},
    Arguments,
};
use crate::{
    number::Format,
    reference::Reference,
    study::pilot::{Choice, Effect, Floats, rule},
};

/// Formats that are tried where none are named.
const FORMATS: [&str; 5] = ["f32", "f16", "bf16", "q16.16", "q8.8"];

pub fn run(arguments: &Arguments, sensor: &Input) -> miette::Result<()> {
    let description = read_sensor(sensor)?;
    let scened = arguments.scene()?;
    let bytes = <Reference>::bytes(&description, scened.kept.size());
    Arguments::check(&scened.kept, bytes)?;
    let full = Choice::full();
    let family = Floats {
        description: &description,
        seed: arguments.seed,
        base: &full,
    };
    let formats = match &arguments.formats {
        Some(formats) => formats.clone(),
        None => FORMATS
            .iter()
            .filter_map(|name| name.parse().ok())
            .collect(),
    };
    let inserts = arguments.upsample.is_some();
    let effects = Effect::ALL.iter().copied();
    let effects = effects.filter(|effect| effect.is_in(&description, inserts));
    let mut models: Vec<Choice> = effects.map(|it| Choice::full().and_without(it)).collect();
    models.extend(formats.into_iter().map(|format| Choice {
        format,
        without: Vec::new(),
    }));
    let alternative = |choice: &Choice| choice.format != Format::F64;
    let free = |choice: &Choice, look: &_| {
        // What rules say holds in double precision.
        let is_free = |effect: &Effect| match effect {
            Effect::DeadTime => rule::has_no_close_crossings(&description, look),
            Effect::InsertedFrames => {
                rule::needs_no_inserted_frames(&choice.plainer(&description)).is_some()
            }
            _ => false,
        };
        (choice.format == Format::F64
            && !choice.without.is_empty()
            && choice.without.iter().all(is_free))
        .then_some("the light and the sensor's rules say so")
    };
    let of = sensor.display().to_string();
    let command = |choice: &_| command(arguments, sensor, choice);
    let table = arguments.told(
        (&of, "f64, with all effects of the file"),
        &scened,
        &command,
    );
    let rules = (&alternative as &_, &free as &_);
    let told = (&table, description.response);
    arguments.trade(&family, &scened, models, rules, told)
}

/// The command that runs a model.
fn command(arguments: &Arguments, sensor: &Input, choice: &Choice) -> String {
    let mut words = vec![
        "amacrine run --scene".to_owned(),
        quoted(&arguments.scene),
        "--sensor".to_owned(),
        quoted(&sensor.display().to_string()),
    ];
    let mut add = |name: &str, value: &str| words.push(format!("--{name} {}", quoted(value)));
    arguments.light(&mut add);
    if let Some(contrast) = arguments.upsample
        && !choice.leaves_out(Effect::InsertedFrames)
    {
        add("upsample", &contrast.to_string());
    }
    if arguments.seed != 0 {
        add("seed", &arguments.seed.to_string());
    }
    if choice.format != Format::F64 {
        add("format", &choice.format.to_string());
    }
    let without = choice.without.iter().map(|effect| effect.word());
    let without: Vec<_> = { without }
        .filter(|key| *key != Effect::InsertedFrames.word())
        .collect();
    if !without.is_empty() {
        add("without", &without.join(","));
    }
    words.join(" ")
}

impl Arguments {
    /// The options of the scene that are not what they are when left out.
    pub(super) fn light(&self, add: &mut dyn FnMut(&str, &str)) {
        if let Some(fps) = self.fps {
            add("fps", &fps.to_string());
        }
        for (name, value) in self.samples.written() {
            add(name, &value);
        }
    }
}
