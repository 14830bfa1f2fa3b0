//! The ways in which a frame's events can leave the chip.

use crate::{config::listed, isa::HostKind};

listed! {
/// What a frame's events leave the chip as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// As many slots as the program asks for.
    AsProgrammed = "as_programmed",
    /// Slots for the busiest frame that is expected.
    BusiestFrame = "busiest_frame",
    /// Slots within which 99 % of the frames of the scene stay.
    NinetyNinePercent = "ninety_nine_percent",
    /// All bits of the registers of events.
    BitPlanes = "bit_planes",
    /// The bits of those rows in which the scene has events.
    Region = "region",
    /// The box around the events of each register.
    BoundingBox = "bounding_box",
    /// An estimate of the number of events in each register.
    EventCounts = "event_counts",
    /// A sum of each kind's drive over the array.
    Sums = "sums",
    /// Whether any pixel of each register has an event.
    AnyEvent = "any_event",
}
}

impl Way {
    /// In a few words.
    #[must_use]
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::AsProgrammed => "all slots that the program asks for",
            Self::BusiestFrame => "slots for the busiest frame",
            Self::NinetyNinePercent => "slots for 99 % of the frames",
            Self::BitPlanes => "whole bit planes",
            Self::Region => "bit planes, rows with events",
            Self::BoundingBox => "a bounding box",
            Self::EventCounts => "event counts",
            Self::Sums => "global sums",
            Self::AnyEvent => "whether there is any event",
        }
    }

    /// What comes out of the chip.
    #[must_use]
    pub const fn carries(self) -> &'static str {
        match self {
            Self::AsProgrammed | Self::BusiestFrame | Self::NinetyNinePercent => {
                "events, up to the slots"
            }
            Self::BitPlanes => "every event",
            Self::Region => "every event of these rows",
            Self::BoundingBox => "a box for each sign and kind, no event",
            Self::EventCounts => "about how many of each sign and kind, no event",
            Self::Sums => "a sum of the drive for each kind, no event",
            Self::AnyEvent => "one bit for each sign and kind, no event",
        }
    }

    /// The operation of the host that does it.
    #[must_use]
    pub const fn host(self) -> HostKind {
        match self {
            Self::AsProgrammed | Self::BusiestFrame | Self::NinetyNinePercent => {
                HostKind::ScanEvents
            }
            Self::BitPlanes | Self::Region => HostKind::ScanDigital,
            Self::BoundingBox => HostKind::ScanBoundingBox,
            Self::EventCounts => HostKind::GlobalCount,
            Self::Sums => HostKind::GlobalSum,
            Self::AnyEvent => HostKind::GlobalOr,
        }
    }

    /// Whether only a summary of the events leaves the chip, and none of their addresses.
    #[must_use]
    pub const fn is_summary(self) -> bool {
        match self {
            Self::AsProgrammed
            | Self::BusiestFrame
            | Self::NinetyNinePercent
            | Self::BitPlanes
            | Self::Region => false,
            Self::BoundingBox | Self::EventCounts | Self::Sums | Self::AnyEvent => true,
        }
    }

    /// Whether it reads a kind's drive, which both signs share, and not the bits of each sign.
    #[must_use]
    pub const fn reads_drives(self) -> bool {
        match self {
            Self::Sums => true,
            Self::AsProgrammed
            | Self::BusiestFrame
            | Self::NinetyNinePercent
            | Self::BitPlanes
            | Self::Region
            | Self::BoundingBox
            | Self::EventCounts
            | Self::AnyEvent => false,
        }
    }
}
