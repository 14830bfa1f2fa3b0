//! What a PNG says about its samples, in the chunks `cICP`, `iCCP`, `sRGB` and `gAMA`.
//!
//! Where there are several, the first of this order holds, as the PNG specification has it (third
//! edition, "Colour chunk precedence").

use crate::scene::{Range, Transfer, light::conversion::Source};

/// `gAMA` is in steps of 1/100,000; programs round 1/2.2 and 1/2.8 to it in several ways.
const NEAR: u32 = 50;

/// The samples of a picture of so many bits.
pub(super) fn source(bits: u32, info: &png::Info<'_>) -> Source {
    let source = Source::pictures(bits);
    if let Some(points) = info.coding_independent_code_points {
        let is_full = points.is_video_full_range_image;
        return Source {
            range: Some(if is_full { Range::Full } else { Range::Limited }),
            ..source.stating(Some(points.transfer_function))
        };
    }
    let (transfer, not_undone) = if info.icc_profile.is_some() {
        (None, Some("what its ICC profile says"))
    } else if info.srgb.is_some() {
        (Some(Transfer::Srgb), None)
    } else {
        info.gama_chunk
            .map_or((None, None), |gamma| power(gamma.into_scaled()))
    };
    Source {
        transfer,
        not_undone,
        ..source
    }
}

/// The transfer that `gAMA` states. The specification decodes by a power of its inverse: 0.45455
/// is a power of 2.2, and not the curve of sRGB, which has a chunk of its own.
fn power(gamma: u32) -> (Option<Transfer>, Option<&'static str>) {
    let near = |other: u32| gamma.abs_diff(other) <= NEAR;
    if near(100_000) {
        (Some(Transfer::Linear), None)
    } else if near(45_455) {
        (Some(Transfer::Gamma22), None)
    } else if near(35_714) {
        (Some(Transfer::Gamma28), None)
    } else if gamma == 0 {
        // Decoders are to ignore it.
        (None, None)
    } else {
        (None, Some("a gamma other than 2.2 and 2.8"))
    }
}
