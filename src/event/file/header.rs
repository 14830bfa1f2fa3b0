//! Text headers in front of binary events.

use std::{
    fmt::Write,
    io::{self, SeekFrom},
};

use super::{
    Fault, Format,
    about::{About, BLANK, NAME},
    chunks::Chunks,
    encoding::Encoding,
    fault::Stop,
    head::Head,
    source::Out,
};
use crate::plane::Size;

/// A header: its lines, each `% key value` or `# key value`.
#[derive(Debug, Default)]
pub struct Header {
    /// What the file says of itself.
    pub about: About,
    /// Whether it has this program's remark.
    pub ours: bool,
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
                ends(chunks, format, mark, last)?;
                // Neither an end nor events: how much is missing is not known.
                if chunks.here().is_empty() && !header.ours {
                    return Err(chunks.truncated("its header".into()));
                }
                break;
            };
            let text = line[1..].trim();
            let here = |fault| Stop::Fault(super::Place::Byte(at), fault);
            if let Some(about) = About::parse(text).map_err(here)? {
                (header.about, header.ours) = (about, true);
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

    /// The size, from any of the ways in which files say it, which must agree; some say 0
    /// where they do not know.
    pub fn size(&self, format: Format) -> Result<Option<Size>, Fault> {
        let number = |text: Option<&str>| {
            let number = text?.trim().parse::<u16>().ok().map(usize::from);
            number.filter(|side| *side > 0)
        };
        let geometry = self.get("geometry").and_then(|g| g.split_once('x'));
        let ours = self.about.size;
        let ways = [
            (
                "the comment `# amacrine …`",
                ours.map(|s| s.width),
                ours.map(|s| s.height),
            ),
            (
                "`format`",
                number(self.setting("width")),
                number(self.setting("height")),
            ),
            (
                "`geometry`",
                number(geometry.map(|(width, _)| width)),
                number(geometry.map(|(_, height)| height)),
            ),
            (
                "`width` and `height`",
                number(self.get("width")),
                number(self.get("height")),
            ),
        ];
        let mut known: [Option<(&str, usize)>; 2] = [None; 2];
        for (way, width, height) in ways {
            let sides = [("wide", width), ("high", height)];
            for (known, (side, here)) in known.iter_mut().zip(sides) {
                let Some(here) = here else { continue };
                let (first, stated) = *known.get_or_insert((way, here));
                if stated != here {
                    let one = format!("{first} says that the sensor is {stated} pixels {side}");
                    return Err(Fault::twice(format, one, format!("{way} says {here}")));
                }
            }
        }
        let [width, height] = known;
        Ok(ours.or_else(|| Some(Size::new(height?.1, width?.1))))
    }

    /// Checks that a Prophesee file is of the encoding that its header names, once or twice.
    pub fn names(&self, format: Format) -> Result<(), Fault> {
        for key in Encoding::KEYS {
            let Some(Encoding {
                name,
                format: named,
            }) = self.get(key).and_then(Encoding::of_value)
            else {
                continue;
            };
            match named {
                Some(named) if named == format => (),
                Some(_) => {
                    let one = format!("`{key}` in its header says {name}");
                    return Err(Fault::twice(format, one, "it is read as another encoding"));
                }
                None => return Err(Fault::Encoding { name }),
            }
        }
        Ok(())
    }
}

/// Checks that no line of a header comes behind its end, which would mean that one before it is
/// damaged.
fn ends(chunks: &mut Chunks, format: Format, mark: u8, last: &str) -> Result<(), Stop> {
    /// How far behind the end such a line is looked for, in bytes.
    const FAR: usize = 4096;
    let from = chunks.at();
    let here = chunks.ahead(FAR)?;
    let here = &here[..here.len().min(FAR)];
    let mark = char::from(mark);
    let gap = if mark == '%' { " " } else { "" };
    let lines = [
        format!("{mark} amacrine size="),
        format!("\n{mark}{gap}{last}\n"),
        format!("\n{mark}{gap}{last}\r\n"),
    ];
    let has = |line: &String| {
        let mut windows = here.windows(line.len());
        windows.position(|window| window == line.as_bytes())
    };
    let known = if last.is_empty() { 1 } else { 3 };
    let Some(more) = lines.iter().take(known).find_map(has) else {
        return Ok(());
    };
    let why = format!(
        "has a header that ends here, and goes on at byte {}",
        from + more as u64
    );
    Err(chunks.stop(Fault::Layout { format, why }))
}

/// Writes the remark in a header again, once all events are written.
pub fn complete(out: &mut dyn Out, header: &[u8], about: &About) -> io::Result<()> {
    let blank = BLANK.as_bytes();
    let Some(end) = header.windows(blank.len()).position(|here| here == blank) else {
        return Ok(());
    };
    let mut names = header[..end].windows(NAME.len());
    let Some(from) = names.rposition(|here| here == NAME.as_bytes()) else {
        return Ok(());
    };
    out.seek(SeekFrom::Start(from as u64))?;
    out.write_all(about.clone().within(end + blank.len() - from).as_bytes())?;
    out.seek(SeekFrom::End(0))?;
    Ok(())
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
         % {}{BLANK}\n% end\n",
        head.about()
    );
    text
}
