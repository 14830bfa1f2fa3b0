//! A word that has no row form does what it means, wherever it stands and in every schedule.

use super::{
    super::{
        Fixed, Layout, Settings,
        semantics::{RowForm, execute, row_form},
    },
    *,
};
use crate::{
    isa::{Analog, Bit, Device, Digital, Direction, Primitive, Source, Target},
    number::Q,
    plane::Plane,
};

/// Words of all parts of the pixel: with borders, masks, copies, and stores that can be dead or
/// fused.
fn program() -> Vec<Primitive> {
    let news = 6;
    let register = |k: u8| Source::Register(Analog(k));
    let bus = |to: &[Target], from: &[Source]| Primitive::Bus {
        targets: to.to_vec(),
        sources: from.to_vec(),
    };
    let store = |to: u8, from: &[Source]| bus(&[Target::Register(Analog(to))], from);
    let drive = |to: &[Direction], from: u8| {
        let to: Vec<_> = to.iter().map(|to| Target::Neighbour(*to)).collect();
        bus(&to, &[register(from)])
    };
    let nor = |target: u8, sources: &[Bit]| Primitive::Nor {
        target: Digital(target),
        sources: sources.to_vec(),
    };
    vec![
        store(news, &[register(0), register(1)]),
        store(2, &[register(news)]),
        Primitive::Where {
            sources: vec![register(2), Source::Neighbour(Direction::East)],
        },
        drive(&[Direction::North], 1),
        store(3, &[register(news), register(4)]),
        nor(5, &[Bit::Flag]),
        Primitive::All,
        store(news, &[Source::Neighbour(Direction::South), Source::Pix]),
        Primitive::ResetPix,
        store(1, &[register(news), register(3)]),
        Primitive::Square {
            sources: vec![register(1)],
        },
        Primitive::Dnews {
            target: Digital(12),
            source: Bit::Register(Digital(12)),
            boundary: true,
        },
        Primitive::Set {
            targets: vec![Digital(0), Digital(12), Digital(7)],
        },
        nor(12, &[Bit::Register(Digital(5)), Bit::Select]),
        Primitive::Prop { boundary: false },
        Primitive::WhereBit {
            sources: vec![Bit::Register(Digital(12)), Bit::Register(Digital(5))],
        },
        Primitive::Blur {
            target: Analog(4),
            source: Analog(4),
            horizontal: true,
            vertical: true,
        },
        drive(&[Direction::West, Direction::South], 4),
        store(0, &[register(news), Source::In]),
    ]
}

/// Which words have a row form.
type Forms = fn(&Primitive) -> Option<RowForm<'_>>;

const FORMS: [Forms; 5] = [
    row_form,
    |_| None,
    |word| row_form(word).filter(|form| matches!(form, RowForm::Bus { .. })),
    |word| row_form(word).filter(|form| !matches!(form, RowForm::Bus { .. })),
    |word| {
        let of_flag = |form: &RowForm<'_>| {
            let bit = |target| target == Bit::Flag;
            matches!(form, RowForm::Sign { .. })
                || matches!(form, RowForm::Logic { target, .. } if bit(*target))
        };
        row_form(word).filter(|form| !of_flag(form))
    },
];

#[test]
fn a_word_without_a_row_form_does_what_it_means() {
    let device = Device::scamp5();
    let settings = Settings::from_device(&device);
    let domain = Fixed::new(Q::<i16>::new(8));
    let program = program();
    for size in [Size::new(24, 70), Size::new(40, 64)] {
        let layout = Layout::new(&device, size);
        let mut before = State::new(&domain, layout, 3.0);
        let plane = |k: usize| {
            let at = |(y, x)| ((31 * y + 17 * x + 7 * k + x * y) % 97) as f64 / 2.0 - 24.0;
            Plane::from_shape_fn(size.shape(), at)
        };
        for k in 0..layout.analog {
            before.set_analog(&domain, Analog(k), &plane(k.into()));
        }
        for k in 0..layout.digital {
            let bits = plane(20 + usize::from(k)).mapv(|value| value > 0.0);
            before.set_digital(Digital(k), &bits);
        }
        before.set_light(&domain, &plane(40));
        let mut meant = before.clone();
        let input = before.input;
        for (step, word) in (0..).zip(&program) {
            execute(&domain, &settings, &mut meant, word, &input, step).unwrap();
        }
        for schedule in [Schedule::Plain, Schedule::Tiled { rows: 3 }] {
            for (k, form) in FORMS.into_iter().enumerate() {
                let mut state = before.clone();
                let mut engine = Engine::new(&state, schedule, 2);
                let mut block = Block::default();
                for word in &program {
                    block.push(word, 1);
                }
                block.lower_with(&layout, engine.lowering(domain.fuses()), form);
                engine.begin(0, &input, std::iter::empty());
                let semantics = Semantics {
                    domain: &domain,
                    settings: &settings,
                };
                engine.run(semantics, &mut state, &block).unwrap();
                assert!(state == meant, "{schedule} {size}, forms {k}");
            }
        }
    }
}
