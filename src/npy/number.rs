//! Types of numbers, as a `descr` names them.

/// How the numbers of an array are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Number {
    /// What they are.
    pub kind: Kind,
    /// Whether the first byte is the most significant.
    pub big_end_first: bool,
}

/// What numbers are: floats, whole numbers without and with a sign, truth values; bytes of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Kind {
    F2,
    F4,
    F8,
    U1,
    U2,
    U4,
    U8,
    I1,
    I2,
    I4,
    I8,
    B1,
}

/// A number that was read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// As it stands.
    Real(f64),
    /// A whole number that no `f64` equals.
    Inexact(i128),
}

impl Value {
    /// The nearest `f64`.
    #[must_use]
    pub const fn nearest(self) -> f64 {
        match self {
            Self::Real(value) => value,
            Self::Inexact(value) => value as f64,
        }
    }
}

impl Number {
    /// The type that a `descr` such as `<f8` names.
    #[must_use]
    pub fn named(descr: &str) -> Option<Self> {
        let (big_end_first, name) = match descr.as_bytes().first()? {
            b'<' | b'|' => (false, &descr[1..]),
            b'>' => (true, &descr[1..]),
            b'=' => (cfg!(target_endian = "big"), &descr[1..]),
            _ => return None,
        };
        let kind = match name {
            "f2" => Kind::F2,
            "f4" => Kind::F4,
            "f8" => Kind::F8,
            "u1" => Kind::U1,
            "u2" => Kind::U2,
            "u4" => Kind::U4,
            "u8" => Kind::U8,
            "i1" => Kind::I1,
            "i2" => Kind::I2,
            "i4" => Kind::I4,
            "i8" => Kind::I8,
            "b1" => Kind::B1,
            _ => return None,
        };
        Some(Self {
            kind,
            big_end_first,
        })
    }

    /// Bytes of each.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self.kind {
            Kind::U1 | Kind::I1 | Kind::B1 => 1,
            Kind::F2 | Kind::U2 | Kind::I2 => 2,
            Kind::F4 | Kind::U4 | Kind::I4 => 4,
            Kind::F8 | Kind::U8 | Kind::I8 => 8,
        }
    }

    /// The number in so many bytes; what is true is 1.
    #[must_use]
    pub fn read(self, bytes: &[u8]) -> Value {
        let fold = |all: u64, byte: &u8| all << 8 | u64::from(*byte);
        let bits = if self.big_end_first {
            bytes.iter().fold(0, fold)
        } else {
            bytes.iter().rev().fold(0, fold)
        };
        match self.kind {
            Kind::F2 => Value::Real(half::f16::from_bits(bits as u16).to_f64()),
            Kind::F4 => Value::Real(f32::from_bits(bits as u32).into()),
            Kind::F8 => Value::Real(f64::from_bits(bits)),
            Kind::U1 | Kind::U2 | Kind::U4 | Kind::U8 => exact(bits.into()),
            Kind::I1 => exact((bits as i8).into()),
            Kind::I2 => exact((bits as i16).into()),
            Kind::I4 => exact((bits as i32).into()),
            Kind::I8 => exact((bits as i64).into()),
            Kind::B1 => Value::Real(f64::from(u8::from(bits != 0))),
        }
    }
}

fn exact(value: i128) -> Value {
    let real = value as f64;
    if real as i128 == value {
        Value::Real(real)
    } else {
        Value::Inexact(value)
    }
}
