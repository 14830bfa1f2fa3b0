//! The kinds of primitives and of host operations, and their rows.

use super::super::{figure::Quantity, primitive::Primitive, signature::Signature};
use crate::config::listed;

listed! {
/// The name of a primitive in `primitives.toml`; one for every variant of [`Primitive`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PrimitiveKind {
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

listed! {
/// The clock that an instruction word runs under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// Analogue words.
    Analog = "analog",
    /// One-bit words.
    Digital = "digital",
    /// One-bit words that reach the neighbours.
    Dnews = "dnews",
    /// Propagation.
    Prop = "prop",
}
}

/// A row of `primitives.toml`.
#[derive(Clone, Debug)]
pub struct PrimitiveRow {
    /// Which primitive.
    pub kind: PrimitiveKind,
    /// How it can be written.
    pub forms: Vec<Signature>,
    /// What it does.
    pub equation: String,
    /// Its instruction words, with who says so and how well it is known.
    pub cost: Quantity,
    /// The clock that it runs under, which says how long a word takes.
    pub clock: Clock,
}

impl PrimitiveRow {
    /// Instruction words.
    #[must_use]
    pub const fn words(&self) -> u64 {
        self.cost.value as u64
    }
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

impl HostKind {
    /// Whether its time is that of the slots, samples or rows that it reads.
    #[must_use]
    pub const fn is_of_items(self) -> bool {
        matches!(
            self,
            Self::ScanEvents
                | Self::ReadAnalog
                | Self::ScanAnalog
                | Self::ScanBlocks
                | Self::ScanDigital
        )
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
    pub const fn kind(&self) -> PrimitiveKind {
        match self {
            Self::Nop => PrimitiveKind::Nop,
            Self::ResetPix => PrimitiveKind::ResetPix,
            Self::Bus { .. } => PrimitiveKind::Bus,
            Self::Square { .. } => PrimitiveKind::Square,
            Self::Where { .. } => PrimitiveKind::Where,
            Self::All => PrimitiveKind::All,
            Self::BlurSet => PrimitiveKind::BlurSet,
            Self::Blur { .. } => PrimitiveKind::Blur,
            Self::Set { .. } => PrimitiveKind::Set,
            Self::Clear { .. } => PrimitiveKind::Clear,
            Self::Or { .. } => PrimitiveKind::Or,
            Self::Nor { .. } => PrimitiveKind::Nor,
            Self::WhereBit { .. } => PrimitiveKind::WhereBit,
            Self::Dnews { .. } => PrimitiveKind::Dnews,
            Self::PropRead => PrimitiveKind::PropRead,
            Self::Prop { .. } => PrimitiveKind::Prop,
        }
    }
}
