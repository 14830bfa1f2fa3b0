//! The same light at 10 to 500 frames a second: what is kept within the headline's window stays,
//! and F1 within a millisecond does not. Against: the frame rate itself.

use amacrine::{
    compare::{
        Pair,
        window::{self, Point, Redraws},
    },
    compile::Effort,
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    number::Format,
    plane::Size,
    reference::MemoryRule,
    rig,
    scene::{Frame, Outline, Scene, SceneError, bundled, part::First, resample::Resampled},
    study::design::Design,
    unit::Micros,
};
use ndarray::s;

/// The middle of the clip, where people walk.
struct Middle(Box<dyn Scene>);

const SIDE: usize = 128;

impl Scene for Middle {
    fn outline(&self) -> Outline {
        Outline {
            frames: self.0.frames(),
            ..Outline::new(Size::new(SIDE, SIDE), self.0.fps())
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let from = (256 - SIDE) / 2;
        let cut = s![from..from + SIDE, from..from + SIDE];
        let frame = self.0.next_frame()?;
        Ok(frame.map(|frame| Frame {
            light: frame.light.slice(cut).to_owned().into(),
            ..frame
        }))
    }
}

/// What each of two sensors keeps at a frame rate, and its F1 within a millisecond.
fn judged(times: u32) -> [(f64, f64); 2] {
    let (kernel, device) = (Kernel::builtin("rgc-5x5").unwrap(), Device::scamp5());
    let float = Design {
        kernel: &kernel,
        threshold: 128.0,
        device: &device,
        effort: Effort::states(1),
        seed: 0,
    };
    let levels = float.quantise(Quantiser::TERNARY, Sum::Kept).unwrap();
    let higher = Design {
        threshold: 1.1 * float.threshold,
        ..float
    };
    let clip = First::new(Middle(bundled().unwrap()), 40);
    let fps = 10.0 * f64::from(times);
    let mut scene = Resampled::new(clip, fps).unwrap();
    let memory = MemoryRule::FilteredSnap;
    let mut sensors = [float, float.in_levels(&levels), higher]
        .map(|design| design.reference(scene.size(), memory, Format::F64).unwrap());
    let packets = rig::watch(&mut scene, &mut rig::each(&mut sensors), |_| ()).unwrap();
    assert!(packets[0].events.len() > 10_000);
    [1, 2].map(|other| {
        let pair = Pair::new(&packets[0], &packets[other]).unwrap();
        if times > 1 {
            // The frames are those that were inserted, and every one is used.
            let told = window::frame_interval(&pair).unwrap();
            assert_eq!(told, window::interval(fps));
        }
        let within = window::headline(fps);
        let point = Point::new(&pair, &Redraws::new(&pair, 0), within);
        (point.kept.unwrap(), window::f1(&pair, Micros(1_000)))
    })
}

#[test]
fn what_is_kept_does_not_depend_on_the_frame_rate() {
    let all = [1, 5, 50].map(judged);
    for (which, name) in ["ternary", "a threshold 10 % higher"].iter().enumerate() {
        let spread = |of: fn(&(f64, f64)) -> f64| {
            let values = all.map(|rate| of(&rate[which]));
            println!("{name}: {values:?}");
            let most = values.into_iter().fold(f64::MIN, f64::max);
            let least = values.into_iter().fold(f64::MAX, f64::min);
            (most - least) / most
        };
        let kept = spread(|(kept, _)| *kept);
        let f1 = spread(|(_, f1)| *f1);
        assert!(kept < 0.15, "{name}: kept changes by {kept}");
        assert!(f1 > 0.3, "{name}: F1 within 1 ms changes by {f1} only");
    }
}
