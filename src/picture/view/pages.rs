//! One view, window by window.

use image::RgbImage;

use super::{look::Look, page::draw};
use crate::{
    event::Packet,
    picture::{PictureError, chart::raster},
    unit::Micros,
};

/// One page after the other, each as [`draw`] draws it at the end of a window of `look.window`,
/// from `from` to `to`; for [`write_frames`](crate::picture::write_frames) as APNG, since a
/// GIF's palette does not hold the shades.
///
/// # Errors
/// When the packet's sensor has no pixels, or too many for a picture.
pub fn pages<'a>(
    packet: &'a Packet,
    look: Look<'a>,
    from: Micros,
    to: Micros,
) -> Result<impl Iterator<Item = RgbImage> + Clone + 'a, PictureError> {
    crate::picture::error::check_size(packet.size)?;
    let window = look.window.0.max(1);
    let number = to.0.saturating_sub(from.0).div_ceil(window);
    let page = move |i: u64| {
        let start = from.0.saturating_add(i.saturating_mul(window));
        let end = start.saturating_add(window).min(to.0);
        let look = Look {
            at: Some(Micros(end)),
            window: Micros(end - start),
            ..look
        };
        // What can be wrong has been checked.
        draw(packet, &look).map(|drawing| raster(&drawing, 1)).ok()
    };
    Ok((0..number).filter_map(page))
}

#[cfg(test)]
mod tests {
    use super::{
        super::{look::View, tests::packet},
        *,
    };
    use crate::picture::ink;

    #[test]
    fn a_surface_fades_from_page_to_page() {
        let packet = packet(&[(50, 0, 0, true)]);
        let look = Look {
            title: "t",
            view: View::Surface,
            window: Micros(100),
            at: None,
        };
        let pages: Vec<_> = pages(&packet, look, Micros(0), Micros(300))
            .unwrap()
            .collect();
        assert_eq!(pages.len(), 3);
        // How many pixels have exactly this colour: the first cell's, page by page.
        let shade = |ago: f64| super::super::frame::mixed(ink::ON, (-ago / 100.0).exp());
        for (page, ago) in pages.iter().zip([50.0, 150.0, 250.0]) {
            let many = page.pixels().filter(|p| **p == shade(ago)).count();
            assert!(many > 1000, "{many} pixels of {ago} us ago");
        }
    }
}
