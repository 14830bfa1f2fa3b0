//! How a compiled program reads its events out.

use std::fmt::Write as _;

use crate::{
    event::readout::scan::SLOTS,
    isa::{Device, HostKind, Operand},
    program::readout::{Plan, Way},
};

/// How a compiled program reads its events out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventReadout {
    /// Event by event, so many slots for each sign and kind.
    Slots(u32),
    /// Whole rows of bits, which the host takes as events: the first and the last row, counted
    /// from the top.
    BitPlanes(u16, u16),
    /// The box around the events of each sign and kind.
    BoundingBox,
    /// An estimate of the number of events of each sign and kind.
    Counts,
    /// A sum of the drive of each kind.
    Sums,
    /// Whether there is any event of each sign and kind.
    Any,
}

impl From<&Plan> for EventReadout {
    fn from(plan: &Plan) -> Self {
        match (plan.slots, &plan.rows) {
            (Some(slots), _) => Self::Slots(slots as u32),
            (None, Some(rows)) => Self::BitPlanes(*rows.start() as u16, *rows.end() as u16),
            (None, None) => match plan.way {
                Way::BoundingBox => Self::BoundingBox,
                Way::EventCounts => Self::Counts,
                Way::Sums => Self::Sums,
                Way::AnyEvent
                // These have slots or rows.
                | Way::AsProgrammed
                | Way::BusiestFrame
                | Way::NinetyNinePercent
                | Way::BitPlanes
                | Way::Region => Self::Any,
            },
        }
    }
}

impl EventReadout {
    /// Event by event, as many as one readout of the chip delivers: 4000, or the bound of the
    /// chip's own row.
    #[must_use]
    pub fn most_slots(device: &Device) -> Self {
        let forms = device.host(HostKind::ScanEvents).forms.iter();
        let own = { forms }.filter(|form| form.name == "scamp5_scan_events");
        let bounds = own.filter_map(|form| match form.parameters.get(2)?.operand {
            Operand::Integer(_, most) | Operand::Number(_, most) => Some(most as u32),
            _ => None,
        });
        Self::Slots(bounds.max().map_or(SLOTS, |most| most.min(SLOTS)))
    }

    /// The line at the head of a program for this chip.
    pub(super) fn head(self, device: &Device) -> String {
        match self {
            Self::Slots(slots) if self == Self::most_slots(device) => {
                format!("const slots = {slots}; // the most that one readout can deliver\n")
            }
            Self::Slots(slots) => format!(
                "const slots = {slots}; // of each sign and kind, as many as the busiest frame that was expected or simulated has: what is beyond is lost\n"
            ),
            Self::BitPlanes(first, last) => format!(
                "// The events leave as bits, rows {first} to {last} of each sign and kind.\n"
            ),
            Self::BoundingBox => {
                "// No event leaves: the box around those of each sign and kind does.\n".to_owned()
            }
            Self::Counts => {
                "// No event leaves: about how many there are of each sign and kind does.\n"
                    .to_owned()
            }
            Self::Sums => "// No event leaves: a sum of the drive of each kind does.\n".to_owned(),
            Self::Any => {
                "// No event leaves: whether there are any of each sign and kind does.\n".to_owned()
            }
        }
    }

    /// Writes the statements that read one kind out: its ON and its OFF events are in `bits`;
    /// `number` is its channel as it stands in names.
    pub(super) fn write(
        self,
        text: &mut String,
        bits: [&str; 2],
        number: &str,
        (drive, scratch): (&str, &str),
    ) {
        for (register, sign) in bits.into_iter().zip(["on", "off"]) {
            let statement = match self {
                Self::Slots(_) => format!("scamp5_scan_events({register}, {sign}{number}, slots)"),
                Self::BitPlanes(first, last) => {
                    format!("scamp5_scan_dreg({register}, {sign}{number}, {first}, {last})")
                }
                Self::BoundingBox => format!("scamp5_scan_boundingbox({register}, {sign}{number})"),
                Self::Counts => format!("scamp5_global_count({register}, {scratch})"),
                Self::Any => format!("scamp5_global_or({register})"),
                // One for both signs.
                Self::Sums if sign == "on" => format!("scamp5_global_sum_16({drive})"),
                Self::Sums => continue,
            };
            let _ = writeln!(text, "    {statement};");
        }
    }
}
