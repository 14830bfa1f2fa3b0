//! Proves that macros which repeat (`gauss`, `newsblur`, `scamp5_diffuse`, `scamp5_get_image`
//! with gain) do what their equations say for every count: against the equation, applied to
//! whole planes again and again.

use std::collections::BTreeMap;

use amacrine::{
    array::{Array, Chip, Exact, Settings},
    event::Packet,
    isa::{Analog, Device, Digital},
    plane::{Plane, Size},
    program::Program,
    unit::Micros,
};
use proptest::prelude::*;

type Light = Plane<f64>;

const FOUR: [(isize, isize); 4] = [(-1, 0), (0, 1), (1, 0), (0, -1)];

/// The plane, whole numbers, and the gates of columns (R1) and rows (R2).
#[derive(Clone, Debug)]
struct Scene {
    values: Light,
    columns: Plane<bool>,
    rows: Plane<bool>,
}

fn scenes() -> impl Strategy<Value = Scene> {
    (1usize..7, 1usize..7).prop_flat_map(|size| {
        let pixels = size.0 * size.1;
        let gates = || prop::collection::vec(prop::bool::weighted(0.8), pixels);
        let values = prop::collection::vec((-40i32..40).prop_map(f64::from), pixels);
        (values, gates(), gates()).prop_map(move |(values, columns, rows)| Scene {
            values: Light::from_shape_vec(size, values).unwrap(),
            columns: Plane::from_shape_vec(size, columns).unwrap(),
            rows: Plane::from_shape_vec(size, rows).unwrap(),
        })
    })
}

fn at<T: Copy>(plane: &Plane<T>, p: (usize, usize), (dy, dx): (isize, isize)) -> Option<T> {
    let (y, x) = (p.0.wrapping_add_signed(dy), p.1.wrapping_add_signed(dx));
    plane.get((y, x)).copied()
}

/// Registers A and B after one run with the scene in B.
fn run(text: &str, scene: &Scene) -> [Light; 2] {
    let device = Device::scamp5();
    let program = Program::parse("test", text).unwrap();
    let expansion = program.expand(&device, &BTreeMap::new()).unwrap();
    let size = Size::of(&scene.values);
    let settings = Settings::from_device(&device);
    let mut chip = Chip::new("t", Exact, &expansion.code, &device, size, settings).unwrap();
    chip.set_analog(Analog(1), &scene.values).unwrap();
    chip.set_digital(Digital(1), &scene.columns).unwrap();
    chip.set_digital(Digital(2), &scene.rows).unwrap();
    chip.run_frame(Micros(0), &mut Packet::new(size, 1))
        .unwrap();
    [0, 1].map(|r| chip.analog(Analog(r)))
}

/// Two steps of the net, as often as said: an eighth flows over each link whose gates are open.
fn diffused(scene: &Scene, directions: &[(isize, isize)], times: usize) -> Light {
    let step = |plane: &Light| {
        Light::from_shape_fn(plane.dim(), |p| {
            let own = plane[p];
            let mut value = own;
            for way in directions {
                let gates = if way.1 == 0 {
                    &scene.columns
                } else {
                    &scene.rows
                };
                if let (Some(there), Some(true), true) =
                    (at(plane, p, *way), at(gates, p, *way), gates[p])
                {
                    value += (there - own) / 8.0;
                }
            }
            value
        })
    };
    (0..2 * times).fold(scene.values.clone(), |plane, _| step(&plane))
}

fn summed(scene: &Scene, directions: &[(isize, isize)], times: usize) -> Light {
    (0..times).fold(scene.values.clone(), |plane, _| {
        Light::from_shape_fn(plane.dim(), |p| {
            directions
                .iter()
                .map(|way| at(&plane, p, *way).unwrap_or(0.0))
                .sum()
        })
    })
}

const VERTICAL: [(isize, isize); 2] = [FOUR[0], FOUR[2]];
const HORIZONTAL: [(isize, isize); 2] = [FOUR[1], FOUR[3]];

proptest! {
    #[test]
    fn gauss_spreads_as_often_as_it_says(scene in scenes(), n in 1usize..5) {
        for (name, directions) in [
            ("gauss", &FOUR[..]), ("gaussv", &VERTICAL[..]), ("gaussh", &HORIZONTAL[..]),
        ] {
            let expected = diffused(&scene, directions, n);
            let [apart, kept] = run(&format!("{name}(A, B, {n});"), &scene);
            prop_assert_eq!(&apart, &expected, "{}", name);
            prop_assert_eq!(&kept, &scene.values);
            let [_, in_place] = run(&format!("{name}(B, B, {n});"), &scene);
            prop_assert_eq!(&in_place, &expected, "{} in place", name);
        }
        let three = diffused(&scene, &FOUR, 3);
        prop_assert_eq!(&run("gauss(A, B);", &scene)[0], &three);
    }

    #[test]
    fn newsblur_sums_as_often_as_it_says(scene in scenes(), n in 1usize..5) {
        for (name, directions) in [
            ("newsblur", &FOUR[..]), ("newsblurv", &VERTICAL[..]), ("newsblurh", &HORIZONTAL[..]),
        ] {
            let expected = summed(&scene, directions, n);
            let [apart, _] = run(&format!("{name}(A, B, {n});"), &scene);
            prop_assert_eq!(&apart, &expected, "{}", name);
            let [_, in_place] = run(&format!("{name}(B, B, {n});"), &scene);
            prop_assert_eq!(&in_place, &expected, "{} in place", name);
        }
    }

    #[test]
    fn diffuse_opens_all_gates(scene in scenes(), n in 0usize..4) {
        let open = Scene {
            columns: scene.columns.mapv(|_| true),
            rows: scene.rows.mapv(|_| true),
            ..scene.clone()
        };
        for (arguments, directions) in [
            ("", &FOUR[..]), (", 1, 1", &FOUR[..]), (", 1, 0", &VERTICAL[..]),
            (", 0, 1", &HORIZONTAL[..]), (", 0", &HORIZONTAL[..]), (", 1, 1, C", &FOUR[..]),
        ] {
            let [_, spread] = run(&format!("scamp5_diffuse(B, {n}{arguments});"), &scene);
            prop_assert_eq!(&spread, &diffused(&open, directions, n), "{}", arguments);
        }
    }

    /// The light above black counts 2^(gain - 1) times: -127 + 2^(gain - 1) · light in all, and half
    /// of what is above -127 in the other register.
    #[test]
    fn gain_multiplies_the_light(light in prop::collection::vec(0u8..=255, 6), gain in 1u32..=5) {
        let device = Device::scamp5();
        let program = Program::parse("t", &format!("scamp5_get_image(A, B, {gain});")).unwrap();
        let code = program.expand(&device, &BTreeMap::new()).unwrap().code;
        let size = Size::new(2, 3);
        let settings = Settings::from_device(&device);
        let mut chip = Chip::new("t", Exact, &code, &device, size, settings).unwrap();
        let light: Vec<f64> = light.into_iter().map(f64::from).collect();
        let light = Light::from_shape_vec((2, 3), light).unwrap();
        chip.expose(&light).unwrap();
        chip.run_frame(Micros(0), &mut Packet::new(size, 1)).unwrap();
        let factor = f64::from(1 << (gain - 1));
        let expected = light.mapv(|l| factor * l - 127.0);
        prop_assert_eq!(chip.analog(Analog(0)), expected);
        prop_assert_eq!(chip.analog(Analog(1)), light.mapv(|l| factor * l / 2.0));
    }
}
