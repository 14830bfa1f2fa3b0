//! What a host that runs beside the array is given to read.

use super::{Array, Readings, RunError};
use crate::{
    event::{Event, Packet, readout::scan::Address},
    plane::{At, Size},
    program::{Action, Answer, Host, Step},
    unit::Micros,
};

/// Runs these steps now; what the last of them gives the host. Before the run nobody knows how many
/// kinds of cells are read out: the packet has as many as it has seen.
///
/// # Errors
/// When the domain has no answer for an instruction.
pub fn answered(
    chip: &mut dyn Array,
    steps: &[Step],
    t: Micros,
    packet: &mut Packet,
) -> Result<Answer, RunError> {
    let (events, readings) = (packet.events.len(), chip.readings().len());
    chip.run_steps(steps, t, packet)?;
    let kinds = packet.events[events..].iter();
    let kinds = kinds.map(|it| it.channel.saturating_add(1)).max();
    packet.channels = packet.channels.max(kinds.unwrap_or_default());
    let last = steps.last().map(|it| &it.action);
    if let Some(Action::Host(Host::ScanEvents { slots, by_rows, .. })) = last {
        let found = &packet.events[events..];
        return Ok(list(found, *slots, *by_rows, chip.size()));
    }
    let read = chip.readings().get(readings..).unwrap_or_default();
    Ok(read
        .last()
        .map_or_else(Answer::default, |it| answer(&it.values)))
}

/// A list of slots as the chip writes it: column and row of each event, of a scan by rows row and
/// column; zeros in what is unused.
fn list(events: &[Event], slots: u32, by_rows: bool, size: Size) -> Answer {
    let mut memory = Vec::new();
    for event in events {
        let (y, x) = (event.y.into(), event.x.into());
        let address = Address::from_pixel(At { y, x }, size);
        let (column, row) = (address.column as i64, address.row as i64);
        memory.extend(if by_rows {
            [row, column]
        } else {
            [column, row]
        });
    }
    memory.resize(2 * slots as usize, 0);
    Answer {
        value: None,
        memory: Some(memory),
    }
}

/// What a reading is for a host. How bits lie in bytes, and what the samples of a sum are, the
/// vendor does not say.
fn answer(values: &Readings) -> Answer {
    let value = |value: i64| Answer {
        value: Some(value),
        memory: None,
    };
    match values {
        // In memory the grid lies column by column.
        Readings::Analog { columns, values } => Answer {
            value: match values[..] {
                [one] => Some(one.into()),
                _ => None,
            },
            memory: Some(
                (0..*columns)
                    .flat_map(|x| values.iter().skip(x).step_by(*columns))
                    .map(|it| i64::from(*it))
                    .collect(),
            ),
        },
        Readings::Digital { .. } => Answer::default(),
        Readings::Box(found) => {
            let corners = found.map_or([0; 4], |it| [it.top, it.right, it.bottom, it.left]);
            Answer {
                value: None,
                memory: Some(corners.map(i64::from).to_vec()),
            }
        }
        Readings::Sum(sum) => value((*sum).into()),
        Readings::Any(any) => value((*any).into()),
    }
}
