//! Pictures inside a page.

use ::image::RgbImage;
use base64::{Engine, prelude::BASE64_STANDARD};
use maud::{Markup, html};

use crate::picture::{Drawing, png, svg};

/// A picture of pixels, with what it shows in words.
#[must_use]
pub fn pixels(picture: &RgbImage, alt: &str) -> Markup {
    let (width, height) = picture.dimensions();
    let source = format!(
        "data:image/png;base64,{}",
        BASE64_STANDARD.encode(png(picture))
    );
    html! {
        img.pixels src=(source) width=(width) height=(height) alt=(alt);
    }
}

/// A drawing, with what it shows in words.
#[must_use]
pub fn drawing(drawing: &Drawing, alt: &str) -> Markup {
    let (width, height) = drawing.size();
    let source = format!(
        "data:image/svg+xml;base64,{}",
        BASE64_STANDARD.encode(svg(drawing))
    );
    html! {
        img.drawing src=(source) width=(width.ceil()) height=(height.ceil()) alt=(alt);
    }
}
