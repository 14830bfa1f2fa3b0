//! Random numbers of the language's library (`<random>`): sources, and distributions of what they draw.
//!
//! Nobody says which numbers a chip's library draws, and a seed comes from a clock or the chip: here
//! they are a fixed sequence.

use crate::{
    elementary,
    program::vendor::{
        host::Random,
        interpreter::{machine::Machine, value::Value},
        syntax::tree::{Expr, Width},
    },
};

impl Machine<'_> {
    /// The object of a class that draws, with what it is made of.
    pub(in crate::program::vendor) fn random(&mut self, random: Random, given: &[Expr]) -> Value {
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        let mut parameters = random.parameters();
        for (parameter, value) in parameters.iter_mut().zip(&values) {
            match value.number() {
                // A source is made of a seed.
                Some(value) if random != Random::Bits => *parameter = value,
                Some(_) => {}
                None if random == Random::Bits => {}
                None => return Value::Unknown("a distribution known only at run time".into()),
            }
        }
        Value::Random(random, parameters)
    }

    /// What it draws, where the host runs; beforehand nobody knows.
    pub(in crate::program::vendor) fn draws(
        &mut self,
        random: Random,
        parameters: [f64; 2],
        given: &[Expr],
    ) -> Value {
        // The source of a distribution may be made here.
        for it in given {
            self.raw(it);
        }
        match &mut self.companion {
            None => Value::Unknown("a random number".into()),
            Some(companion) => drawn(random, parameters, || companion.even()),
        }
    }
}

/// A number of these parameters, from two that are even between 0 and 1.
fn drawn(random: Random, [a, b]: [f64; 2], mut even: impl FnMut() -> f64) -> Value {
    match random {
        Random::Bits => Value::Wide((even() * 4_294_967_296.0) as i64, Width::Unsigned),
        Random::Whole => {
            let most = (b - a).max(0.0);
            Value::from_number(a + (even() * (most + 1.0)).floor().min(most))
        }
        Random::Real => Value::Real(a + even() * (b - a)),
        Random::Normal => {
            // Box and Muller's.
            let far = (-2.0 * elementary::ln((1.0 - even()).max(f64::MIN_POSITIVE))).sqrt();
            let angle = elementary::sin(2.0 * std::f64::consts::PI * even());
            Value::Real(a + b * far * angle)
        }
        Random::Flag => Value::flag(even() < a),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::vendor::syntax::tree::Kind;

    #[test]
    fn ends_are_drawn_and_nothing_beyond() {
        for (even, least) in [(0.0, 3.0), (0.5, 6.0), (1.0 - 1e-12, 8.0)] {
            let value = drawn(Random::Whole, [3.0, 8.0], || even);
            assert_eq!(value.number(), Some(least));
            assert_eq!(value.kind(), Kind::INT);
        }
        let all = [Random::Bits, Random::Real, Random::Normal];
        for random in all {
            let mut draws = [0.0, 0.25].into_iter().cycle();
            let value = drawn(random, [0.0, 1.0], || draws.next().unwrap());
            assert!(value.number().unwrap().is_finite(), "{random:?}");
        }
        assert_eq!(drawn(Random::Flag, [0.5, 0.0], || 0.4), Value::flag(true));
    }
}
