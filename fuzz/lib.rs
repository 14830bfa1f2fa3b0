//! What every target does with its bytes.

use std::path::Path;

use amacrine::event::file::{self, Compression, Format, Opening, Reader};

/// Reads the bytes as a file of this format: an end or a message, never a panic, and memory
/// in proportion to the bytes. What was read is written in the same format and read again.
pub fn read(format: Format, bytes: &[u8]) {
    let opening = Opening {
        format: Some(format),
        size: None,
    };
    let Ok(reader) = Reader::of_bytes(Path::new("fuzz"), bytes.to_vec(), &opening) else {
        return;
    };
    let (loaded, _) = file::all(reader);
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let path = folder.path().join("again");
    if file::write_as(&path, format, Compression::Lz4, &loaded.packet).is_ok() {
        let again = file::read_as(&path, &opening).expect("we wrote it");
        assert_eq!(again.packet.events, loaded.packet.events);
    }
}
