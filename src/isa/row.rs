//! Rows of the tables: what a primitive or a host operation is called, what it takes, what
//! it means, what it costs.

use super::{
    Analog, Bit, Device, Digital, Direction, Evidence, Primitive, Quantity, Signature, Source,
    Target, Value, signature::Bound,
};

/// An enum, the list of its variants and how each is written, from one list.
macro_rules! listed {
    ($(#[$outer:meta])* pub enum $name:ident { $($(#[$doc:meta])* $variant:ident = $word:literal,)* }) => {
        $(#[$outer])*
        pub enum $name { $($(#[$doc])* $variant,)* }

        impl $name {
            /// All of them, in order.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// How they are written in a chip's files, in the same order.
            pub const WORDS: &'static [&'static str] = &[$($word),*];
        }
    };
}

listed! {
/// The name of a primitive in `primitives.toml`; one for every variant of [`Primitive`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// [`Primitive::Nop`]
    Nop = "nop",
    /// [`Primitive::ResetPix`]
    ResetPix = "reset_pix",
    /// [`Primitive::Bus`]
    Bus = "bus",
    /// [`Primitive::Square`]
    Square = "square",
    /// [`Primitive::Where`]
    Where = "where",
    /// [`Primitive::All`]
    All = "all",
    /// [`Primitive::BlurSet`]
    BlurSet = "blur_set",
    /// [`Primitive::Blur`]
    Blur = "blur",
    /// [`Primitive::Set`]
    Set = "set",
    /// [`Primitive::Clear`]
    Clear = "clear",
    /// [`Primitive::Or`]
    Or = "or",
    /// [`Primitive::Nor`]
    Nor = "nor",
    /// [`Primitive::WhereBit`]
    WhereBit = "where_bit",
    /// [`Primitive::Dnews`]
    Dnews = "dnews",
    /// [`Primitive::PropRead`]
    PropRead = "prop_read",
    /// [`Primitive::Prop`]
    Prop = "prop",
}
}

/// The clock that an instruction word runs under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// Analogue words.
    Analog,
    /// One-bit words.
    Digital,
    /// One-bit words that reach the neighbours.
    Dnews,
    /// Propagation.
    Prop,
}

impl Clock {
    /// All, in the order of [`Clock::WORDS`].
    pub const ALL: [Self; 4] = [Self::Analog, Self::Digital, Self::Dnews, Self::Prop];

    /// How they are written.
    pub const WORDS: [&str; 4] = ["analog", "digital", "dnews", "prop"];
}

/// A row of `primitives.toml`.
#[derive(Clone, Debug)]
pub struct PrimitiveRow {
    /// Which primitive.
    pub kind: Kind,
    /// How it can be written.
    pub forms: Vec<Signature>,
    /// What it does.
    pub equation: String,
    /// Instruction words.
    pub words: u64,
    /// The clock that it runs under.
    pub clock: Clock,
    /// Who says so.
    pub source: String,
    /// How well it is known.
    pub evidence: Evidence,
}

listed! {
/// The name of a host operation in `device.toml`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum HostKind {
    /// `program::Host` of this name.
    LoadIn = "load_in",
    /// `program::Host` of this name.
    LoadInRaw = "load_in_raw",
    /// `program::Host` of this name.
    LoadDac = "load_dac",
    /// `program::Host` of this name.
    ScanEvents = "scan_events",
    /// `program::Host` of this name.
    ReadAnalog = "read_analog",
    /// `program::Host` of this name.
    ReadPixel = "read_pixel",
    /// `program::Host` of this name.
    ScanAnalog = "scan_analog",
    /// `program::Host` of this name.
    ScanBlocks = "scan_blocks",
    /// `program::Host` of this name.
    ScanDigital = "scan_digital",
    /// `program::Host` of this name.
    ScanBoundingBox = "scan_bounding_box",
    /// `program::Host` of this name.
    GlobalSum = "global_sum",
    /// `program::Host` of this name.
    GlobalOr = "global_or",
    /// `program::Host` of this name.
    GlobalCount = "global_count",
    /// `program::Host::Load`, an area of a register.
    Load = "load",
    /// `program::Host` of this name.
    Select = "select",
    /// `program::Host` of this name.
    DrawBegin = "draw_begin",
    /// `program::Host` of this name.
    Draw = "draw",
    /// `program::Host` of this name.
    DrawEnd = "draw_end",
}
}

/// A row of `[[host]]` in `device.toml`.
#[derive(Clone, Debug)]
pub struct HostRow {
    /// Which operation.
    pub kind: HostKind,
    /// How it can be written.
    pub forms: Vec<Signature>,
    /// What it does.
    pub meaning: String,
    /// Time of one call.
    pub call: Quantity,
    /// Time of each slot, sample or pixel besides.
    pub item: Option<Quantity>,
}

impl Primitive {
    /// Its row.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Nop => Kind::Nop,
            Self::ResetPix => Kind::ResetPix,
            Self::Bus { .. } => Kind::Bus,
            Self::Square { .. } => Kind::Square,
            Self::Where { .. } => Kind::Where,
            Self::All => Kind::All,
            Self::BlurSet => Kind::BlurSet,
            Self::Blur { .. } => Kind::Blur,
            Self::Set { .. } => Kind::Set,
            Self::Clear { .. } => Kind::Clear,
            Self::Or { .. } => Kind::Or,
            Self::Nor { .. } => Kind::Nor,
            Self::WhereBit { .. } => Kind::WhereBit,
            Self::Dnews { .. } => Kind::Dnews,
            Self::PropRead => Kind::PropRead,
            Self::Prop { .. } => Kind::Prop,
        }
    }

    /// As the vendor writes it, with the device's names.
    #[must_use]
    pub fn text(&self, device: &Device) -> String {
        let analog = |r: &Analog| device.analog_name(*r);
        let digital = |r: &Digital| device.digital_name(*r);
        let bit = |b: &Bit| device.bit_name(*b);
        let source = |s: &Source| device.source_name(*s);
        let target = |t: &Target| device.target_name(*t);
        let call = |name: &str, arguments: Vec<String>| format!("{name}({})", arguments.join(", "));
        match self {
            Self::Nop => call("nop", vec![]),
            Self::ResetPix => call("rpix", vec![]),
            Self::Bus { targets, sources } => {
                let name = match (targets.len(), sources.len()) {
                    (1, 0..=4) => "bus",
                    (2, 0..=2) => "bus2",
                    (3, 1) => "bus3",
                    _ => {
                        let targets: Vec<_> = targets.iter().map(target).collect();
                        let sources: Vec<_> = sources.iter().map(source).collect();
                        return format!(
                            "bus({{{}}}, {{{}}})",
                            targets.join(", "),
                            sources.join(", ")
                        );
                    }
                };
                let targets = targets.iter().map(target);
                call(name, targets.chain(sources.iter().map(source)).collect())
            }
            Self::Square { sources } => call("sq", sources.iter().map(source).collect()),
            Self::Where { sources } => call("where", sources.iter().map(source).collect()),
            Self::All => call("all", vec![]),
            Self::BlurSet => call("blurset", vec![]),
            Self::Blur {
                target,
                source,
                horizontal,
                vertical,
            } => {
                let name = match (horizontal, vertical) {
                    (true, false) => "blurh",
                    (false, true) => "blurv",
                    _ => "blur",
                };
                call(name, vec![analog(target), analog(source)])
            }
            Self::Set { targets } => call("SET", targets.iter().map(digital).collect()),
            Self::Clear { targets } => call("CLR", targets.iter().map(digital).collect()),
            Self::Or { target, sources } => {
                let name = if sources.len() == 1 { "MOV" } else { "OR" };
                let sources = sources.iter().map(bit);
                call(
                    name,
                    std::iter::once(digital(target)).chain(sources).collect(),
                )
            }
            Self::Nor { target, sources } => {
                let name = if sources.len() == 1 { "NOT" } else { "NOR" };
                let sources = sources.iter().map(bit);
                call(
                    name,
                    std::iter::once(digital(target)).chain(sources).collect(),
                )
            }
            Self::WhereBit { sources } => call("WHERE", sources.iter().map(bit).collect()),
            Self::Dnews {
                target,
                source,
                boundary,
            } => {
                let name = if *boundary { "DNEWS1" } else { "DNEWS0" };
                call(name, vec![digital(target), bit(source)])
            }
            Self::PropRead => call("PROP_R", vec![]),
            Self::Prop { boundary } => {
                let name = if *boundary { "PROP_1" } else { "PROP_0" };
                call(name, vec![])
            }
        }
    }
}

/// The primitive that a form stands for, with these values.
///
/// `None` when the row's form does not have the parameters that the primitive needs: loading
/// a device tries every form once, so that this is found there.
#[must_use]
pub fn build(kind: Kind, mnemonic: &str, bound: &[Bound]) -> Option<Primitive> {
    let first = bound.first();
    let all = || bound.iter().flatten();
    let sources = |values: &mut dyn Iterator<Item = &Value>| -> Option<Vec<Source>> {
        values
            .map(|v| match v {
                Value::Source(source) => Some(*source),
                _ => None,
            })
            .collect()
    };
    let bits = |values: &mut dyn Iterator<Item = &Value>| -> Option<Vec<Bit>> {
        values
            .map(|v| match v {
                Value::Bit(bit) => Some(*bit),
                _ => None,
            })
            .collect()
    };
    let registers = || all().map(Value::digital).collect::<Option<Vec<_>>>();
    let one = |part: usize| bound.get(part).and_then(|b| b.first());
    Some(match kind {
        Kind::Nop => Primitive::Nop,
        Kind::ResetPix => Primitive::ResetPix,
        Kind::Bus => {
            let targets = match mnemonic {
                "bus2" => 2,
                "bus3" => 3,
                _ => 1,
            };
            let (targets, sourced) = bound.split_at_checked(targets)?;
            Primitive::Bus {
                targets: targets
                    .iter()
                    .flatten()
                    .map(|v| match v {
                        Value::Source(Source::Register(r)) => Some(Target::Register(*r)),
                        Value::Source(Source::Neighbour(d)) => Some(Target::Neighbour(*d)),
                        _ => None,
                    })
                    .collect::<Option<_>>()?,
                sources: sources(&mut sourced.iter().flatten())?,
            }
        }
        Kind::Square => Primitive::Square {
            sources: sources(&mut all())?,
        },
        Kind::Where => Primitive::Where {
            sources: sources(&mut all())?,
        },
        Kind::All => Primitive::All,
        Kind::BlurSet => Primitive::BlurSet,
        Kind::Blur => Primitive::Blur {
            target: one(0)?.analog()?,
            source: one(1)?.analog()?,
            horizontal: mnemonic != "blurv",
            vertical: mnemonic != "blurh",
        },
        Kind::Set => Primitive::Set {
            targets: registers()?,
        },
        Kind::Clear => Primitive::Clear {
            targets: registers()?,
        },
        Kind::Or => Primitive::Or {
            target: first?.first()?.digital()?,
            sources: bits(&mut all().skip(1))?,
        },
        Kind::Nor => Primitive::Nor {
            target: first?.first()?.digital()?,
            sources: bits(&mut all().skip(1))?,
        },
        Kind::WhereBit => Primitive::WhereBit {
            sources: bits(&mut all())?,
        },
        Kind::Dnews => Primitive::Dnews {
            target: one(0)?.digital()?,
            source: *bits(&mut one(1).into_iter())?.first()?,
            boundary: mnemonic == "DNEWS1",
        },
        Kind::PropRead => Primitive::PropRead,
        Kind::Prop => Primitive::Prop {
            boundary: mnemonic == "PROP_1",
        },
    })
}

/// The name of a neighbour's cell.
#[must_use]
pub const fn neighbour_name(direction: Direction) -> &'static str {
    match direction {
        Direction::North => "XN",
        Direction::East => "XE",
        Direction::South => "XS",
        Direction::West => "XW",
    }
}
