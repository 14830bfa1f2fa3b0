//! What is said of effects of a sensor (`Effect::influence`) is true of sensors at random: which cells
//! fire on a still scene, and which see more than the drive of their sheets. Whether inserted frames
//! say nothing new, and which tiles are unseen, `fidelity` tries.

use amacrine::{
    event::Packet,
    number::Format,
    plane::Size,
    property::{Clip, clips, sensors},
    reference::{Alone, Description, Effect, Reference, SheetDrive, SheetRule},
    rig,
    scene::{Frame, Scene, held::Held},
    study::rate,
};
use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};

const SIZE: Size = Size {
    height: 6,
    width: 7,
};

/// The events of a sensor, or why there are none.
fn events(sensor: &Description, scene: &mut dyn Scene) -> Result<Packet, String> {
    let mut sensor = Reference::new(sensor.clone(), SIZE, 3).map_err(|e| e.to_string())?;
    let packets = rig::watch(scene, &mut [&mut sensor], |_| {});
    let packets = packets.map_err(|e| e.to_string());
    packets.map(|mut it| it.remove(0))
}

/// The first frame of a clip, for two seconds.
fn still(clip: &Clip) -> Held {
    let frames = vec![clip.frames[0].clone(); 21];
    Clip { frames, fps: 10.0 }.scene()
}

fn fires(sensor: &Description, clip: &Clip) -> bool {
    !events(sensor, &mut still(clip)).unwrap().events.is_empty()
}

/// Whether its sheets are settled in a still scene.
fn is_settled(sensor: &Description) -> bool {
    let surrounds = sensor
        .channels
        .iter()
        .filter_map(|it| it.surrounds.as_ref());
    surrounds.clone().all(|it| it.rule != SheetRule::V2e)
}

/// Only with these of its effects.
fn with_only(sensor: &Description, keep: impl Fn(Effect) -> bool) -> Description {
    let mut plain = sensor.clone();
    for effect in sensor.effects() {
        if !keep(effect) {
            effect.leave_out(&mut plain);
        }
    }
    plain
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Where a cell may fire alone is told by all that the sensor has, not only what was thought of.
    #[test]
    fn what_fires_alone_is_told(sensor in sensors(), clip in clips(SIZE, 1..=1)) {
        if is_settled(&sensor) && !sensor.memory.moves_alone() {
            let quiet = with_only(&sensor, |it| it.influence().alone == Alone::Never);
            prop_assert!(!quiet.fires_alone());
            prop_assert!(!fires(&quiet, &clip));
            prop_assert!(sensor.fires_alone() || sensor == quiet);
            let some = with_only(&sensor, |it| it.influence().alone != Alone::AtAnyThreshold);
            prop_assert!(!fires(&rate::times(&some, 1e6), &clip));
        }
    }

    /// What sees more than the drive of its sheets is not shown it alone.
    #[test]
    fn cells_behind_sheets_have_the_events_of_the_sensor(
        sensor in sensors(),
        clip in clips(SIZE, 2..=6),
    ) {
        let Some(cells) = sensor.behind_sheets(Format::F64) else {
            return Ok(());
        };
        let mut sheets = SheetDrive::new(sensor.sheets(3).unwrap(), SIZE);
        let drives = clip.frames.iter().enumerate().map(|(index, light)| {
            let (index, seconds) = (index as u64, index as f64 / clip.fps);
            let light = light.clone().into();
            let frame = Frame { index, seconds, light };
            let light = sheets.see(&frame).unwrap().into();
            Frame { light, ..frame }
        });
        let mut drives = Held::new(drives.collect(), SIZE, clip.fps);
        prop_assert_eq!(events(&cells, &mut drives), events(&sensor, &mut clip.scene()));
    }
}

/// Each effect of which it is said makes cells fire on a still scene, by itself.
#[test]
fn what_is_said_to_fire_alone_does() {
    let mut runner = TestRunner::deterministic();
    let mut drawn = || {
        let sensor = sensors().new_tree(&mut runner).unwrap().current();
        let clip = clips(SIZE, 1..=1).new_tree(&mut runner).unwrap().current();
        (sensor, clip)
    };
    let mut left: Vec<Effect> = Effect::of_sensors()
        .filter(|it| it.influence().alone != Alone::Never)
        .collect();
    assert!(left.len() >= 3);
    for _ in 0..2000 {
        let (sensor, clip) = drawn();
        if is_settled(&sensor) && !sensor.memory.moves_alone() {
            let has = sensor.effects();
            left.retain(|effect| {
                !has.contains(effect) || !fires(&with_only(&sensor, |it| it == *effect), &clip)
            });
        }
    }
    assert_eq!(left, []);
}
