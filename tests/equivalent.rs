//! The threshold equivalent: float sensors with other thresholds are told by their own thresholds,
//! and gain is told apart from shape.

use amacrine::{
    compare::window,
    compile::Effort,
    event::Packet,
    isa::Device,
    kernel::Kernel,
    number::Format,
    reference::MemoryRule,
    rig, scene,
    scene::{Frame, OpenOptions, Scene},
    sensor::Sensor,
    study::{
        design::Design,
        equivalent::{self, Ladder, Likeness, RUNGS},
    },
};

const MEMORY: MemoryRule = MemoryRule::FilteredSnap;

fn open() -> Box<dyn Scene> {
    let options = OpenOptions::default();
    scene::open(
        "pattern:noise?width=64&height=48&frames=60&speed=90&fps=30",
        &options,
    )
    .unwrap()
}

/// The same cell at parts of its threshold, in the scene.
fn watched(design: &Design<'_>, parts: &[f64]) -> Vec<Packet> {
    let mut scene = open();
    let mut sensors: Vec<Box<dyn Sensor + Send>> = { parts.iter() }
        .map(|part| {
            let threshold = design.threshold * part;
            let design = Design {
                threshold,
                ..*design
            };
            design.reference(scene.size(), MEMORY, Format::F64).unwrap()
        })
        .collect();
    rig::watch(&mut *scene, &mut rig::each(&mut sensors), |_: &Frame| ()).unwrap()
}

fn with_ladder(see: impl FnOnce(&Design<'_>, &Ladder)) {
    let (kernel, device) = (Kernel::builtin("csdvs-3").unwrap(), Device::scamp5());
    let design = Design {
        kernel: &kernel,
        threshold: 6.0,
        device: &device,
        effort: Effort::states(1),
        seed: 0,
    };
    let fps = open().fps();
    let truth = watched(&design, &[1.0]).remove(0);
    assert!(truth.events.len() > 2000, "{}", truth.events.len());
    let rungs = watched(&design, &RUNGS);
    let ladder = Ladder::new(truth, &rungs, window::headline(fps), fps, 0).unwrap();
    see(&design, &ladder);
}

#[test]
fn the_reference_itself_keeps_all() {
    with_ladder(|_, ladder| {
        let own = ladder.judge(ladder.reference()).unwrap();
        assert_eq!(
            (own.kept, own.f1, own.event_ratio),
            (Some(1.0), 1.0, Some(1.0))
        );
        assert_eq!(own.threshold_equivalent_percent, Some(0.0));
        assert!(!own.threshold_equivalent_is_least);
        assert!(own.floor < 0.9, "{}", own.floor);
    });
}

#[test]
fn a_higher_threshold_is_told_by_its_own_height() {
    with_ladder(|design, ladder| {
        let parts = [1.05, 1.1, 1.15, 1.2, 1.5];
        let mut before = 1.0;
        for (part, packet) in parts.iter().zip(watched(design, &parts)) {
            let told = ladder.judge(&packet).unwrap();
            let percent = told.threshold_equivalent_percent.unwrap();
            let off = percent - 100.0 * (part - 1.0);
            // On a rung it is the rung; between two it is near.
            let far = if RUNGS.contains(part) { 1e-9 } else { 4.0 };
            assert!(off.abs() < far, "{part}: {percent} %");
            let kept = told.kept.unwrap();
            assert!(kept < before, "{part}: {kept} after {before}");
            before = kept;
        }
    });
}

#[test]
fn gain_and_shape_are_told_apart() {
    with_ladder(|design, ladder| {
        let packet = watched(design, &[1.3]).remove(0);
        let mut told = ladder.judge(&packet).unwrap();
        let mut pairs = [(&packet, &mut told)];
        equivalent::tune(ladder, design, MEMORY, &mut *open(), &mut pairs, |_| ()).unwrap();
        let tuned = told.tuned.unwrap();
        // All of it is gain: with as many events nearly nothing is lost.
        assert!((tuned.threshold_percent - 30.0).abs() < 8.0, "{tuned:?}");
        assert!(
            tuned.kept > Some(0.95) && tuned.kept > told.kept.map(|kept| kept + 0.02),
            "{told:?}"
        );

        // The same events elsewhere are all shape.
        let mut moved = ladder.reference().clone();
        for event in &mut moved.events {
            event.x = (event.x + 31) % 64;
        }
        let mut told = ladder.judge(&moved).unwrap();
        let mut pairs = [(&moved, &mut told)];
        equivalent::tune(ladder, design, MEMORY, &mut *open(), &mut pairs, |_| ()).unwrap();
        let tuned = told.tuned.unwrap();
        assert!(tuned.threshold_percent.abs() < 0.5, "{tuned:?}");
        assert!(
            (tuned.kept.unwrap() - told.kept.unwrap()).abs() < 0.02,
            "{told:?}"
        );
    });
}

#[test]
fn what_is_beyond_the_ladder_says_so() {
    with_ladder(|_, ladder| {
        let mut none = ladder.reference().clone();
        none.events.clear();
        let told: Likeness = ladder.judge(&none).unwrap();
        assert!(
            told.kept.unwrap() < 0.0 && told.threshold_equivalent_is_least,
            "{told:?}"
        );
        assert_eq!(told.threshold_equivalent_percent, Some(900.0));
        assert_eq!(told.equivalent(), "> 900 %");
        assert_eq!(ladder.part_of(0), None);
        assert_eq!(ladder.part_of(u64::MAX), None);
        let all = ladder.reference().events.len() as u64;
        assert_eq!(ladder.part_of(all), Some(1.0));
    });
}
