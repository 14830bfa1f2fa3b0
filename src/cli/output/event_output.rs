//! `--events` of `run`: a file that is written pair by pair, or the packet whole.

use super::files::Output;
use crate::{
    event::{
        Packet,
        file::{FileError, Head, Writer},
    },
    reference::EventList,
};

/// Where the events of a run go.
pub struct EventOutput<'a> {
    path: Option<&'a Output>,
    /// Where the events go as they come.
    writer: Option<Writer>,
}

impl<'a> EventOutput<'a> {
    /// To this path, if any. The packet, which has no events yet, says all else as far as it is
    /// known; where it is wanted `whole`, it is written at the end.
    pub fn new(path: Option<&'a Output>, packet: &Packet, whole: bool) -> Result<Self, FileError> {
        let head = Head::from_packet(packet);
        let streamed = path.filter(|_| !whole);
        let writer = streamed.map(|path| path.writer(&head)).transpose()?;
        Ok(Self { path, writer })
    }

    /// Takes the events of a pair out of the list, unless the packet is wanted whole.
    pub fn take(&mut self, list: Option<&mut EventList<'_>>) -> Result<(), FileError> {
        match (list, &mut self.writer) {
            (Some(list), Some(writer)) => list.pass(|events| writer.put(events)),
            _ => Ok(()),
        }
    }

    /// Gives the file its name; of a packet that is not whole what is not events counts.
    pub fn finish(self, packet: &Packet) -> Result<(), FileError> {
        match (self.writer, self.path) {
            (Some(mut writer), _) => {
                writer.state(packet.span, packet.dropped);
                writer.finish()?;
                self.path
                    .map_or(Ok(()), |path| path.warn_of_drops(packet.dropped))
            }
            (None, Some(path)) => path.write(packet),
            (None, None) => Ok(()),
        }
    }
}
