//! YUV4MPEG2, the raw video that `ffmpeg` and `mplayer` write; its luma.
//!
//! More than 8 bits are scaled to 0..255 as real numbers, so that all depths share a scale. The
//! range is that of the field `XCOLORRANGE`; without it gray video has full range, and video with
//! colour limited range, as ffmpeg takes it.
//! Format: the man page `yuv4mpeg(5)` of mjpegtools; depths above 8 as ffmpeg writes them.

use std::{
    io::{BufRead, Read},
    path::{Path, PathBuf},
};

use crate::{
    plane::Size,
    scene::{
        Frame, Image, Levels, OpenOptions, Outline, Range, Scene, SceneError,
        checks::{self, MemoryLimit},
        light::conversion::Source,
        observation::playback::Unlike,
        time::frame_rate::Rate,
    },
};

/// The first word of every file.
pub(in crate::scene) const MAGIC: &[u8] = b"YUV4MPEG2";

/// The longest header or frame line that is read.
const LONGEST_LINE: u64 = 4096;

/// A y4m stream.
pub(super) struct Y4m<R> {
    path: PathBuf,
    stream: R,
    size: Size,
    samples: Samples,
    source: Source,
    unlike: Option<Unlike>,
    rate: Rate,
    frames: Option<u64>,
    next: u64,
    /// What each sample stands for.
    levels: Levels,
    /// The bytes behind the luma of a frame.
    others: Vec<u8>,
}

/// How the samples of one frame are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Samples {
    /// Bits of a sample; above 8 they take two bytes, little end first.
    bits: u32,
    /// Bytes of luma, the first plane of a frame.
    luma: u64,
    /// Bytes of a whole frame.
    frame: u64,
}

/// Opens a y4m file.
pub(in crate::scene) fn open(
    path: &Path,
    options: OpenOptions,
) -> Result<(impl Scene + use<>, Source), SceneError> {
    let stream = checks::open_file(path)?;
    let length = checks::known_length(&stream);
    let y4m = Y4m::new(path, stream, length, options)?;
    let source = y4m.source;
    Ok((y4m, source))
}

impl<R: BufRead + Send> Y4m<R> {
    /// Reads the header; `length` is that of the whole stream, where it is known.
    fn new(
        path: &Path,
        mut stream: R,
        length: Option<u64>,
        options: OpenOptions,
    ) -> Result<Self, SceneError> {
        let header = match line(&mut stream, path)? {
            Line::Whole(text) => text,
            Line::Nothing => {
                return Err(SceneError::Empty {
                    path: path.into(),
                    missing: "header",
                });
            }
            Line::Broken(got) => {
                return Err(SceneError::Header {
                    path: path.into(),
                    field: "first line",
                    got: format!("{got:?}"),
                    want: "YUV4MPEG2 and its fields, ended by a new line",
                });
            }
        };
        let fields = Fields::parse(path, &header)?;
        let size = checks::checked_size(path, fields.height, fields.width)?;
        let samples = samples(&fields.colour, size).ok_or_else(|| SceneError::ColourSpace {
            path: path.into(),
            got: fields.colour.clone(),
        })?;
        MemoryLimit::new(options).check(path, size, held(samples, size))?;
        let rate = Rate::asked_or_found(options.fps, fields.fps, path)?;
        // Frame lines may carry fields; the count is known only where none does.
        let frames = length
            .and_then(|length| length.checked_sub(header.len() as u64 + 1))
            .and_then(|body| {
                let step = samples.frame + 6;
                (body % step == 0).then_some(body / step)
            });
        if frames == Some(0) {
            return Err(SceneError::Empty {
                path: path.into(),
                missing: "frame",
            });
        }
        let usual = if fields.colour.starts_with("mono") {
            Range::Full
        } else {
            Range::Limited
        };
        Ok(Self {
            path: path.into(),
            stream,
            size,
            source: Source {
                range: fields.range,
                ..Source::video(samples.bits, usual)
            },
            samples,
            rate,
            frames,
            next: 0,
            unlike: fields.unlike,
            levels: Levels::of_bits(samples.bits),
            others: Vec::new(),
        })
    }
}

impl<R: BufRead + Send> Scene for Y4m<R> {
    fn outline(&self) -> Outline {
        Outline {
            frames: self.frames,
            unlike: self.unlike,
            ..Outline::new(self.size, self.rate.fps)
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let index = self.next;
        let no_frame = |got: String| SceneError::NoFrame {
            path: self.path.clone(),
            frame: index,
            got,
        };
        match line(&mut self.stream, &self.path)? {
            Line::Nothing if index == 0 => {
                return Err(SceneError::Empty {
                    path: self.path.clone(),
                    missing: "frame",
                });
            }
            Line::Nothing => return Ok(None),
            Line::Whole(text) if text == "FRAME" || text.starts_with("FRAME ") => {}
            Line::Whole(text) => return Err(no_frame(text.chars().take(20).collect())),
            Line::Broken(text) if "FRAME".starts_with(&text) || text.starts_with("FRAME ") => {
                return Err(SceneError::Truncated {
                    path: self.path.clone(),
                    frame: index,
                    got: 0,
                    want: self.samples.frame,
                });
            }
            Line::Broken(text) => return Err(no_frame(text)),
        }
        // Reading through `take` allocates what is there, not what the header claims.
        let Samples { bits, luma, frame } = self.samples;
        let mut codes = Vec::new();
        self.others.clear();
        let parts = [(luma, &mut codes), (frame - luma, &mut self.others)];
        let mut got = 0;
        for (want, part) in parts {
            let read = (&mut self.stream).take(want).read_to_end(part);
            got += read.map_err(|cause| SceneError::unreadable(&self.path, cause))? as u64;
        }
        let truncated = || SceneError::Truncated {
            path: self.path.clone(),
            frame: index,
            got,
            want: frame,
        };
        if got < frame {
            return Err(truncated());
        }
        checks::check_number(&self.path, index)?;
        let levels = self.levels.clone();
        let light = if bits == 8 {
            Image::of_bytes(self.size, codes, levels)
        } else {
            let (pairs, _) = codes.as_chunks();
            let codes = pairs.iter().map(|&pair| u16::from_le_bytes(pair)).collect();
            Image::of_words(self.size, codes, levels)
        };
        let light = light.ok_or_else(truncated)?;
        self.next += 1;
        Ok(Some(Frame {
            index,
            seconds: self.rate.seconds(index),
            light,
        }))
    }
}

/// Bytes held for a frame: as it is coded, twice where that is light, and as light.
fn held(samples: Samples, size: Size) -> u128 {
    u128::from(samples.frame + samples.luma) + checks::PIXEL_BYTES_HELD * size.pixels() as u128
}

/// The fields of the header that matter here.
struct Fields {
    width: usize,
    height: usize,
    fps: Option<f64>,
    colour: String,
    /// Of the field that ffmpeg writes.
    range: Option<Range>,
    /// Of pixels that are not square.
    unlike: Option<Unlike>,
}

impl Fields {
    fn parse(path: &Path, header: &str) -> Result<Self, SceneError> {
        let bad = |field, got: &str, want| SceneError::Header {
            path: path.into(),
            field,
            got: format!("{got:?}"),
            want,
        };
        let mut words = header.split(' ').filter(|word| !word.is_empty());
        match words.next() {
            Some("YUV4MPEG2") => {}
            other => return Err(bad("first word", other.unwrap_or(""), "YUV4MPEG2")),
        }
        let (mut width, mut height, mut fps, mut range) = (None, None, None, None);
        let mut unlike = None;
        // What the format means when the field is missing.
        let mut colour = "420jpeg".to_owned();
        for word in words {
            let Some(tag) = word.chars().next() else {
                continue;
            };
            let value = &word[tag.len_utf8()..];
            match tag {
                'W' => width = Some(whole(value).ok_or_else(|| bad("W", value, "a width"))?),
                'H' => height = Some(whole(value).ok_or_else(|| bad("H", value, "a height"))?),
                'F' => {
                    let rate = ratio(value);
                    fps = Some(rate.ok_or_else(|| bad("F", value, "frames per second as a:b"))?);
                }
                'C' => value.clone_into(&mut colour),
                'I' if matches!(value, "t" | "b" | "m") => {
                    return Err(SceneError::Interlaced {
                        path: path.into(),
                        got: value.into(),
                    });
                }
                'I' if matches!(value, "p" | "?") => {}
                'I' => return Err(bad("I", value, "p, t, b, m or ?")),
                'X' if value.starts_with("COLORRANGE=") => {
                    range = Some(match value {
                        "COLORRANGE=FULL" => Range::Full,
                        "COLORRANGE=LIMITED" => Range::Limited,
                        other => return Err(bad("X", other, "COLORRANGE=FULL or LIMITED")),
                    });
                }
                'A' => unlike = shape(value),
                // Comments.
                'X' => {}
                _ => return Err(bad("(unknown)", word, "one of W H F I A C X")),
            }
        }
        Ok(Self {
            width: width.ok_or_else(|| bad("W", "nothing", "a width"))?,
            height: height.ok_or_else(|| bad("H", "nothing", "a height"))?,
            fps,
            colour,
            range,
            unlike,
        })
    }
}

fn whole(text: &str) -> Option<usize> {
    text.parse().ok()
}

/// `a:b` as a rate; `0:0`, which means "unknown", is no usable rate.
fn ratio(text: &str) -> Option<f64> {
    let (a, b) = text.split_once(':')?;
    let (a, b): (u64, u64) = (a.parse().ok()?, b.parse().ok()?);
    Some(a as f64 / b as f64)
}

/// `a:b` as the shape of a pixel, where that is no square; `0:0` means "unknown".
fn shape(text: &str) -> Option<Unlike> {
    let (a, b) = text.split_once(':')?;
    Unlike::pixels(a.parse().ok()?, b.parse().ok()?)
}

/// The sample layout of a colour space; `None` where it is not known.
fn samples(colour: &str, size: Size) -> Option<Samples> {
    let (layout, bits) = match colour {
        "420" | "420jpeg" | "420mpeg2" | "420paldv" => ("420", 8),
        "mono" | "411" | "422" | "440" | "444" | "444alpha" => (colour, 8),
        deep => {
            let (layout, bits) = deep
                .strip_prefix("mono")
                .map(|bits| ("mono", bits))
                .or_else(|| deep.split_once('p'))?;
            match (layout, bits) {
                ("mono" | "420" | "422" | "444", "9" | "10" | "12" | "14" | "16") => {
                    (layout, bits.parse().ok()?)
                }
                _ => return None,
            }
        }
    };
    let (height, width) = (size.height as u64, size.width as u64);
    let luma = height * width;
    let others = match layout {
        "mono" => 0,
        "420" => 2 * width.div_ceil(2) * height.div_ceil(2),
        "411" => 2 * width.div_ceil(4) * height,
        "422" => 2 * width.div_ceil(2) * height,
        "440" => 2 * width * height.div_ceil(2),
        "444" => 2 * luma,
        "444alpha" => 3 * luma,
        _ => return None,
    };
    let bytes = if bits > 8 { 2 } else { 1 };
    Some(Samples {
        bits,
        luma: luma * bytes,
        frame: (luma + others) * bytes,
    })
}

/// The result of reading a line.
enum Line {
    /// A line of text, without its end.
    Whole(String),
    /// No end of line within the limit, or not text: its first bytes.
    Broken(String),
    /// The end of the stream.
    Nothing,
}

fn line(stream: &mut impl BufRead, path: &Path) -> Result<Line, SceneError> {
    let mut bytes = Vec::new();
    stream
        .take(LONGEST_LINE)
        .read_until(b'\n', &mut bytes)
        .map_err(|cause| SceneError::unreadable(path, cause))?;
    if bytes.is_empty() {
        return Ok(Line::Nothing);
    }
    if bytes.pop_if(|last| *last == b'\n').is_some() {
        match String::from_utf8(bytes) {
            Ok(text) => return Ok(Line::Whole(text)),
            Err(error) => bytes = error.into_bytes(),
        }
    }
    bytes.truncate(20);
    Ok(Line::Broken(bytes.escape_ascii().to_string()))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(bytes: &[u8]) -> Result<Vec<Frame>, SceneError> {
        let mut scene = Y4m::new(
            Path::new("a.y4m"),
            bytes,
            Some(bytes.len() as u64),
            OpenOptions::default(),
        )?;
        let mut frames = Vec::new();
        while let Some(frame) = scene.next_frame()? {
            frames.push(frame);
        }
        Ok(frames)
    }

    #[test]
    fn every_colour_space_gives_its_luma() {
        // 3x3, so that halves are rounded up: planes of chroma must be passed over exactly.
        for (colour, bits, others) in [
            ("mono", 8, 0),
            ("420jpeg", 8, 8),
            ("420paldv", 8, 8),
            ("411", 8, 6),
            ("422", 8, 12),
            ("440", 8, 12),
            ("444", 8, 18),
            ("444alpha", 8, 27),
            ("mono16", 16, 0),
            ("420p10", 10, 8),
            ("422p12", 12, 12),
        ] {
            let mut bytes = format!("YUV4MPEG2 W3 H3 F30000:1001 Ip C{colour}\n").into_bytes();
            for frame in 0..2_u8 {
                bytes.extend(b"FRAME\n");
                for place in 0..9_u8 {
                    bytes.push(10 * frame + place);
                    if bits > 8 {
                        bytes.push(0);
                    }
                }
                let wide = if bits > 8 { 2 } else { 1 };
                bytes.extend(vec![200; others * wide]);
            }
            let frames = read(&bytes).unwrap();
            assert_eq!(frames.len(), 2, "{colour}");
            assert_eq!(frames[1].seconds, 1001.0 / 30000.0);
            let scale = 255.0 / f64::from((1 << bits) - 1);
            for (place, light) in frames[1].light.iter().enumerate() {
                assert!(
                    (light - (10 + place) as f64 * scale).abs() < 1e-12,
                    "{colour}"
                );
            }
        }
    }

    #[test]
    fn a_missing_colour_space_is_420() {
        let mut bytes = b"YUV4MPEG2 W2 H2 F25:1\nFRAME Ip\n".to_vec();
        bytes.extend([1, 2, 3, 4, 128, 128]);
        assert_eq!(read(&bytes).unwrap()[0].light[(1, 0)], 3.0);
    }

    #[test]
    fn the_count_of_frames_is_known_beforehand() {
        let bytes = b"YUV4MPEG2 W1 H1 F25:1 Cmono\nFRAME\n1FRAME\n2";
        let scene = Y4m::new(
            Path::new("a"),
            &bytes[..],
            Some(bytes.len() as u64),
            OpenOptions::default(),
        )
        .unwrap();
        assert_eq!(scene.frames(), Some(2));
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes: Vec<u8>) {
            let _ = read(&bytes);
            let mut after = b"YUV4MPEG2 ".to_vec();
            after.extend(&bytes);
            let _ = read(&after);
            let mut framed = b"YUV4MPEG2 W2 H1 F1:1 Cmono\n".to_vec();
            framed.extend(&bytes);
            prop_assert!(read(&framed).is_err() || bytes.starts_with(b"FRAME"));
        }

        #[test]
        fn any_header_is_read_or_refused(header in "YUV4MPEG2( [WHFICAX][0-9a-z:]{0,6}){0,6}\nFRAME\n.{0,9}") {
            let _ = read(header.as_bytes());
        }

        #[test]
        fn a_cut_clip_is_an_error_unless_cut_between_frames(cut in 0_usize..57) {
            let mut bytes = b"YUV4MPEG2 W3 H1 F1:1 Cmono\n".to_vec();
            let header = bytes.len();
            for frame in 0..3 {
                bytes.extend(b"FRAME\n");
                bytes.extend([frame; 3]);
            }
            let cut = cut.min(bytes.len());
            let whole = cut > header && (cut - header).is_multiple_of(9);
            prop_assert_eq!(read(&bytes[..cut]).is_ok(), whole);
        }
    }
}
