//! A drawing as SVG.
//!
//! Text stays text, in the reader's own monospaced typeface, stretched to the width that it
//! was laid out for. Pixels are embedded as PNG.

use std::fmt::Write;

use base64::{Engine, prelude::BASE64_STANDARD};
use image::{ExtendedColorType, ImageEncoder, RgbImage, codecs::png::PngEncoder};

use super::drawing::{Anchor, Drawing, Mark};
use crate::picture::ink;
use crate::picture::text::{Face, Weight};

/// The drawing as the text of an SVG file.
#[must_use]
pub fn svg(drawing: &Drawing) -> String {
    let (w, h) = drawing.size();
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" font-family=\"'Noto Sans Mono','DejaVu Sans Mono',Menlo,Consolas,monospace\" font-size=\"12\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"{}\"/>\n",
        ink::hex(ink::PAGE)
    );
    for mark in &drawing.marks {
        let written = match mark {
            Mark::Fill(a, ink) => writeln!(
                out,
                "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" fill=\"{}\"/>",
                a.x,
                a.y,
                a.width.max(0.0),
                a.height.max(0.0),
                ink::hex(*ink)
            ),
            Mark::Line(from, to, width, ink) => writeln!(
                out,
                "<line x1=\"{:.2}\" y1=\"{:.2}\" x2=\"{:.2}\" y2=\"{:.2}\" stroke=\"{}\" stroke-width=\"{width}\"/>",
                from.0,
                from.1,
                to.0,
                to.1,
                ink::hex(*ink)
            ),
            Mark::Pixels(a, picture) => writeln!(
                out,
                "<image x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>",
                a.x,
                a.y,
                a.width,
                a.height,
                BASE64_STANDARD.encode(png(picture))
            ),
            Mark::Text(at, anchor, weight, ink, words) => {
                let anchor = match anchor {
                    Anchor::Start => "start",
                    Anchor::Middle => "middle",
                    Anchor::End => "end",
                };
                let bold = match weight {
                    Weight::Plain => "",
                    Weight::Heading => " font-weight=\"bold\"",
                };
                // The typeface's letters stand 13 points below the upper edge.
                writeln!(
                    out,
                    "<text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"{anchor}\" textLength=\"{}\" lengthAdjust=\"spacingAndGlyphs\" fill=\"{}\"{bold} xml:space=\"preserve\">{}</text>",
                    at.0,
                    at.1 + 13.0,
                    Face::new(*weight, 1).width(words),
                    ink::hex(*ink),
                    escaped(words)
                )
            }
        };
        // A string takes all that is written to it.
        debug_assert!(written.is_ok());
    }
    out + "</svg>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .chars()
        .map(|c| if c.is_control() { '?' } else { c })
        .collect()
}

/// A picture as the bytes of a PNG file.
#[must_use]
pub fn png(picture: &RgbImage) -> Vec<u8> {
    let mut bytes = Vec::new();
    let (width, height) = picture.dimensions();
    // A vector takes every byte, and a picture in memory has the size that it says.
    let written =
        PngEncoder::new(&mut bytes).write_image(picture, width, height, ExtendedColorType::Rgb8);
    debug_assert!(written.is_ok());
    bytes
}
