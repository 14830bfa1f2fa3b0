//! Words for how far the array goes, in the defaults of a form.

use super::{
    Device, Figure,
    text::{Expression, Term},
};

/// What a word is of a side of so many pixels.
#[derive(Clone, Copy)]
enum Of {
    /// The last address.
    Last,
    /// All bits that its addresses have.
    Bits,
}

const WORDS: [(&str, Figure, Of); 4] = [
    ("last_row", Figure::Height, Of::Last),
    ("last_column", Figure::Width, Of::Last),
    ("row_bits", Figure::Height, Of::Bits),
    ("column_bits", Figure::Width, Of::Bits),
];

impl Of {
    const fn side(self, pixels: u32) -> u32 {
        match self {
            Self::Last => pixels - 1,
            Self::Bits => pixels.next_power_of_two() - 1,
        }
    }
}

impl Device {
    /// A default of a form, with numbers for the words that say how far the array goes.
    #[must_use]
    pub fn filled_in(&self, default: &Expression) -> Expression {
        let inner = |inner: &Expression| Box::new(self.filled_in(inner));
        let term = match &default.term {
            Term::Name(name) => match WORDS.iter().find(|(word, ..)| word == name) {
                Some((_, side, of)) => Term::Number(f64::from(of.side(self.value(*side) as u32))),
                None => Term::Name(name.clone()),
            },
            Term::Negate(it) => Term::Negate(inner(it)),
            Term::Binary {
                operator,
                left,
                right,
            } => Term::Binary {
                operator: *operator,
                left: inner(left),
                right: inner(right),
            },
            Term::Number(_) | Term::Of { .. } => default.term.clone(),
        };
        Expression {
            term,
            place: default.place,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{config::Place, isa::text::Operator};

    #[test]
    fn defaults_go_as_far_as_the_array() {
        let place = Place::default();
        let expression = |term| Expression { term, place };
        let name = |name: &str| expression(Term::Name(name.to_owned()));
        for (height, last, bits) in [
            (256.0, 255.0, 255.0),
            (300.0, 299.0, 511.0),
            (1.0, 0.0, 0.0),
        ] {
            let device = Device::scamp5().what_if(Figure::Height, height).unwrap();
            for (word, number) in [("last_row", last), ("row_bits", bits)] {
                assert_eq!(device.filled_in(&name(word)).term, Term::Number(number));
            }
            let less = Term::Binary {
                operator: Operator::Subtract,
                left: Box::new(name("row_bits")),
                right: Box::new(expression(Term::Number(1.0))),
            };
            let Term::Binary { left, .. } = device.filled_in(&expression(less)).term else {
                panic!("a difference stays one");
            };
            assert_eq!(left.term, Term::Number(bits));
            assert_eq!(
                device.filled_in(&name("A")).term,
                Term::Name("A".to_owned())
            );
        }
    }
}
