//! The text of a sensor file that a sensor is written as is read back as that sensor: so Python, `design`
//! and learned sensors have the events of the sensor that they were made of.

use amacrine::{
    event::Packet,
    plane::Size,
    property::{Clip, clips, sensors},
    reference::{Description, Effect, MemoryRule, Reference, Refractory, RefractoryRule},
    rig,
    study::pilot::left_out::sensor_without,
};
use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};

const SIZE: Size = Size {
    height: 6,
    width: 7,
};

fn read(text: &str) -> Description {
    Description::parse("again.toml", text, &|_| unreachable!())
        .unwrap_or_else(|e| panic!("{e:?}\n{text}"))
}

/// What a sensor says of a clip; or why it does not.
fn events(sensor: &Description, clip: &Clip) -> Result<Packet, String> {
    let mut sensor = Reference::new(sensor.clone(), SIZE, 3).map_err(|e| e.to_string())?;
    let packets = rig::watch(&mut clip.scene(), &mut [&mut sensor], |_| {});
    packets
        .map(|mut it| it.remove(0))
        .map_err(|e| e.to_string())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_text_is_read_back_as_its_sensor(sensor in sensors(), clip in clips(SIZE, 2..=5)) {
        sensor.check().unwrap();
        let has = |effect: &Effect| effect.is_in(&sensor, false);
        let without = |effect| sensor_without("it", &sensor, &[effect]).unwrap();
        let plainer = Effect::of_sensors().filter(has).map(without);
        for sensor in std::iter::once(sensor.clone()).chain(plainer) {
            let text = sensor.to_toml();
            let again = read(&text);
            prop_assert_eq!(&again, &sensor, "{}", text);
            prop_assert_eq!(again.to_toml(), text);
            prop_assert_eq!(events(&again, &clip), events(&sensor, &clip));
        }
    }
}

/// What is generated has all that there is.
#[test]
fn sensors_at_random_have_every_rule_and_effect() {
    let mut runner = TestRunner::deterministic();
    let all: Vec<Description> = (0..500)
        .map(|_| sensors().new_tree(&mut runner).unwrap().current())
        .collect();
    for memory in MemoryRule::ALL {
        assert!(all.iter().any(|it| it.memory == *memory), "{memory:?}");
    }
    for effect in Effect::of_sensors() {
        let has = all.iter().filter(|it| effect.is_in(it, false)).count();
        assert!((20..450).contains(&has), "{effect}: {has}");
    }
    let authors = |it: &&Description| it.refractory.rule == RefractoryRule::Authors;
    let steps = all
        .iter()
        .filter(|it| it.memory == MemoryRule::FilteredStep);
    assert!(
        steps
            .clone()
            .filter(authors)
            .any(|it| it.refractory.us == 0.0)
    );
    let clip = clips(SIZE, 4..=4).new_tree(&mut runner).unwrap().current();
    let fire = |it: &&Description| events(it, &clip).is_ok_and(|it| !it.events.is_empty());
    assert!(all.iter().filter(fire).count() > 400);
}

/// A sensor with the authors' rule that has no period any more is none with a dead time: the rule
/// counts without a period, too.
#[test]
fn the_authors_rule_stays_without_a_period() {
    let text = "memory = \"filtered-step\"\nresponse = \"identity\"\n\
                refractory = { us = 300, rule = \"authors\" }\n\
                [[channel]]\nkernel = \"csdvs-3\"\nthreshold = { on = 20, off = 20 }\n";
    let sensor = sensor_without("it", &read(text), &[Effect::DeadTime]).unwrap();
    let rule = RefractoryRule::Authors;
    assert_eq!(sensor.refractory, Refractory { us: 0.0, rule });
    assert_eq!(read(&sensor.to_toml()), sensor);
    let mut other = sensor.clone();
    other.refractory.rule = RefractoryRule::DeadTime;
    let clip = clips(SIZE, 6..=6);
    let clip = clip.new_tree(&mut TestRunner::deterministic());
    let clip = clip.unwrap().current();
    assert_ne!(events(&other, &clip), events(&sensor, &clip));
}

/// What a memory cannot have it cannot have without a period either, in a file or in code.
#[test]
fn rules_are_refused_without_a_period() {
    for memory in MemoryRule::ALL {
        for rule in RefractoryRule::ALL {
            let held = match memory {
                MemoryRule::AuthorsPixelStep => "memory-kernel = [[1]]\n",
                _ => "",
            };
            let text = format!(
                "memory = \"{}\"\nresponse = \"identity\"\n[[channel]]\nkernel = [[1]]\n\
                 {held}threshold = {{ on = 20, off = 20 }}\n",
                memory.word()
            );
            let mut sensor = read(&text);
            sensor.refractory.rule = *rule;
            let in_code = sensor.check().is_ok();
            let text = sensor.to_toml();
            let in_file = Description::parse("again.toml", &text, &|_| unreachable!()).is_ok();
            assert_eq!(in_code, in_file, "{text}");
            let has_both = *memory == MemoryRule::FilteredStep;
            let has_dead_time = *memory != MemoryRule::AuthorsPixelStep;
            let is_dead_time = *rule == RefractoryRule::DeadTime;
            assert_eq!(in_code, has_both || has_dead_time == is_dead_time, "{text}");
        }
    }
}
