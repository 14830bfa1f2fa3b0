//! What verbs write, and the endings of names that say so.

use crate::event::file::Format;

/// What is in something that a verb writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Events; the ending names the format.
    Events,
    /// Events whose format is given beside the name: the verb checks the name.
    Converted,
    /// An array of numbers.
    Array,
    /// Arrays of numbers, layer after layer.
    Tensor,
    /// A plane, as an array or as a picture.
    Plane,
    /// A picture of pixels.
    Picture,
    /// A drawing.
    Drawing,
    /// A drawing, or pages one after the other.
    View,
    /// A page for a browser.
    Page,
    /// A program of the array.
    Program,
    /// A kernel.
    Kernel,
    /// A JSON Schema.
    Schema,
    /// A folder of several files.
    Folder,
}

impl Content {
    /// The endings that say so, the one first that is taken where there is no name; none where
    /// the table has no say.
    #[must_use]
    pub const fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Events | Self::Converted | Self::Folder => &[],
            Self::Array => &["npy"],
            Self::Tensor => &["npy", "npz", "h5", "hdf5"],
            Self::Plane => &["npy", "png"],
            Self::Picture => &["png"],
            Self::Drawing => &["svg", "png"],
            Self::View => &["png", "svg", "gif", "apng", "mcap"],
            Self::Page => &["html", "htm"],
            Self::Program => &["scamp", "cpp", "hpp"],
            Self::Kernel => &["toml"],
            Self::Schema => &["json"],
        }
    }

    /// What it is, in a message.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Events | Self::Converted => "events",
            Self::Array | Self::Tensor => "an array",
            Self::Plane => "a plane",
            Self::Picture => "a picture",
            Self::Drawing | Self::View => "a drawing",
            Self::Page => "a page",
            Self::Program => "a program",
            Self::Kernel => "a kernel",
            Self::Schema => "a schema",
            Self::Folder => "a folder",
        }
    }

    /// The events' format where no name tells.
    pub(super) const STREAM: Format = Format::Csv;
}
