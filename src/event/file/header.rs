//! The headers of text in front of binary events.

use std::fmt::Write;

use super::{Fault, Format, about::About, chunks::Chunks, fault::Stop, writer::Head};
use crate::plane::Size;

/// What the lines of a header say, each `% key value` or `# key value`.
#[derive(Debug, Default)]
pub struct Header {
    /// What the file says of itself.
    pub about: About,
    /// All keys and values, keys in small letters.
    pub lines: Vec<(String, String)>,
}

impl Header {
    /// Reads lines that start with `mark`, up to and with `last`, or to the first line that
    /// does not.
    pub fn read(chunks: &mut Chunks, format: Format, mark: u8, last: &str) -> Result<Self, Stop> {
        let mut header = Self::default();
        loop {
            let at = chunks.at();
            let Some(line) = chunks.line(mark)? else {
                break;
            };
            let text = line[1..].trim();
            let here = |fault| Stop::Fault(super::Place::Byte(at), fault);
            if let Some(about) = About::parse(text).map_err(here)? {
                header.about = about;
            }
            if text == last {
                break;
            }
            let (key, value) = text.split_once([' ', ':']).unwrap_or((text, ""));
            let pair = (key.to_ascii_lowercase(), value.trim().to_owned());
            header.lines.push(pair);
            if header.lines.len() > 4096 {
                let why = "has a header of more than 4096 lines".into();
                return Err(here(Fault::Layout { format, why }));
            }
        }
        Ok(header)
    }

    /// The last value of a key.
    pub fn get(&self, key: &str) -> Option<&str> {
        let mut of_key = self.lines.iter().rev().filter(|(k, _)| k == key);
        of_key.next().map(|(_, value)| value.as_str())
    }

    /// A setting of Prophesee's `% format EVT3;height=720;width=1280`.
    pub fn setting(&self, name: &str) -> Option<&str> {
        let mut settings = self.get("format")?.split(';').skip(1);
        settings.find_map(|s| s.trim().strip_prefix(name)?.strip_prefix('='))
    }

    /// The size, from any of the ways in which Prophesee's files say it.
    pub fn prophesee_size(&self) -> Option<Size> {
        let number = |text: Option<&str>| text?.trim().parse::<u16>().ok().map(usize::from);
        let size = |height, width| Some(Size::new(number(height)?, number(width)?));
        let geometry = || {
            let (width, height) = self.get("geometry")?.split_once('x')?;
            size(Some(height), Some(width))
        };
        let found = size(self.setting("height"), self.setting("width"))
            .or_else(geometry)
            .or_else(|| size(self.get("height"), self.get("width")));
        // Some files say 0 where they do not know.
        found.filter(|size| size.pixels() > 0)
    }
}

/// The header of a Prophesee file of words.
pub fn prophesee(format: Format, head: &Head) -> String {
    let (evt, name) = match format {
        Format::Evt21 => ("2.1", "EVT21"),
        Format::Evt3 => ("3.0", "EVT3"),
        _ => ("2.0", "EVT2"),
    };
    let Size { height, width } = head.size;
    let mut text = String::new();
    // The version before the format: readers that know only one of the two find it.
    let _ = write!(
        text,
        "% evt {evt}\n% format {name};height={height};width={width}\n% geometry {width}x{height}\n\
         % {}\n% end\n",
        head.about()
    );
    text
}
