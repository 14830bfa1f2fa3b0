//! From a format's name, known at run time, to the type that holds it.

use super::{Bf16, F16, F32, F64, Format, Number, Q};

/// Work that can be done in any number format.
pub trait Visitor {
    /// What comes out.
    type Output;

    /// Does it in one format.
    fn visit<N: Number>(self, number: N) -> Self::Output;
}

impl Format {
    /// Does the visitor's work in this format.
    pub fn visit<V: Visitor>(self, visitor: V) -> V::Output {
        match self {
            Self::F64 => visitor.visit(F64),
            Self::F32 => visitor.visit(F32),
            Self::F16 => visitor.visit(F16),
            Self::Bf16 => visitor.visit(Bf16),
            Self::Fixed(q) => match q.bits() {
                8 => visitor.visit(Q::<i8>::new(q.fraction()).with_overflow(q.overflow())),
                16 => visitor.visit(Q::<i16>::new(q.fraction()).with_overflow(q.overflow())),
                _ => visitor.visit(Q::<i32>::new(q.fraction()).with_overflow(q.overflow())),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Name;

    impl Visitor for Name {
        type Output = Format;
        fn visit<N: Number>(self, number: N) -> Format {
            number.format()
        }
    }

    #[test]
    fn each_format_is_visited_by_its_own_number() {
        for name in [
            "f64",
            "f32",
            "f16",
            "bf16",
            "q1.7",
            "q8.8",
            "q8.8-wrap",
            "q8.24",
            "q32.0",
        ] {
            let format: Format = name.parse().unwrap();
            assert_eq!(format.visit(Name), format);
        }
    }
}
