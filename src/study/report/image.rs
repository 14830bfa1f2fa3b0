//! Pictures inside the page.

use ::image::RgbImage;
use base64::{Engine, prelude::BASE64_STANDARD};
use maud::{Markup, html};

use crate::picture::png;

/// A picture of pixels, with what it shows in words.
pub(super) fn pixels(picture: &RgbImage, alt: &str) -> Markup {
    let (width, height) = picture.dimensions();
    let source = format!(
        "data:image/png;base64,{}",
        BASE64_STANDARD.encode(png(picture))
    );
    html! {
        img.pixels src=(source) width=(width) height=(height) alt=(alt);
    }
}
