//! Four panels in a row (the frame, the reference's events, the other's, their difference),
//! with captions; several rows make a contact sheet.

use image::{RgbImage, imageops};

use super::{
    PictureError,
    ink::{self, Ink},
    panel::{self, Difference},
    text::{self, LINE, Weight},
};
use crate::{
    event::{Event, Packet, Polarity},
    plane::{Plane, Size},
    unit::Micros,
};

/// A stretch of time, and what the scene looked like at its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Events after this.
    pub from: Micros,
    /// Events up to and with this.
    pub to: Micros,
    /// Light, `[y, x]`, in any unit.
    pub frame: Plane<f64>,
}

/// What a picture shows: two packets, and what they are called.
#[derive(Clone, Copy, Debug)]
pub struct Show<'a> {
    /// The line on top.
    pub title: &'a str,
    /// Name and packet of the reference.
    pub reference: (&'a str, &'a Packet),
    /// Name and packet of what is judged against it.
    pub device: (&'a str, &'a Packet),
}

/// Panels of small sensors are enlarged to this, in pixels.
const PANEL: usize = 256;
const MARGIN: u32 = 20;
const GAP: u32 = 14;

/// Several moments below each other.
///
/// # Errors
/// When there is no moment, sizes differ, or the sheet would be too large.
pub fn contact_sheet(show: &Show<'_>, moments: &[Moment]) -> Result<RgbImage, PictureError> {
    let layout = Layout::new(show, moments)?;
    layout.page(show, &moments.iter().collect::<Vec<_>>())
}

/// Positions of the panels, and the light shown as black and as white: the same for all moments, so
/// that rows and pages of an animation can be compared by eye.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    size: Size,
    times: u32,
    /// Width of a column.
    column: u32,
    black: f64,
    white: f64,
}

impl Layout {
    /// Fits panels and gray scale to what is shown.
    pub fn new(show: &Show<'_>, moments: &[Moment]) -> Result<Self, PictureError> {
        let want = show.reference.1.size;
        let frames = moments.iter().map(|m| ("frame", Size::of(&m.frame)));
        let device = ("judged packet", show.device.1.size);
        for (what, got) in frames.chain([device]) {
            if got != want {
                return Err(PictureError::Size { what, got, want });
            }
        }
        if moments.is_empty() || want.height == 0 || want.width == 0 {
            return Err(PictureError::Nothing);
        }
        let times = PANEL.div_ceil(want.height.max(want.width));
        let light = || {
            let all = moments.iter().flat_map(|m| m.frame.iter().copied());
            all.filter(|v| v.is_finite())
        };
        Ok(Self {
            size: want,
            times: times as u32,
            column: side((want.width * times).max(PANEL))?,
            black: light().fold(f64::INFINITY, f64::min),
            white: light().fold(f64::NEG_INFINITY, f64::max),
        })
    }

    /// A page with a row for each moment.
    pub fn page(&self, show: &Show<'_>, moments: &[&Moment]) -> Result<RgbImage, PictureError> {
        let head = MARGIN + 2 * LINE + GAP;
        let panel = side(self.size.height * self.times as usize)?;
        let row = u64::from(panel + LINE + GAP);
        let width = 2 * u64::from(MARGIN) + 4 * u64::from(self.column) + 3 * u64::from(GAP);
        let height = u64::from(head + LINE) + row * moments.len() as u64 + u64::from(MARGIN - GAP);
        let (width, height) = (side(width as usize)?, side(height as usize)?);
        let mut page = RgbImage::from_pixel(width, height, ink::PAGE);

        let inner = width - 2 * MARGIN;
        text::write_within(
            &mut page,
            (MARGIN, MARGIN - 4),
            inner,
            show.title,
            Weight::Heading,
            ink::TEXT,
        );
        legend(&mut page, (MARGIN, MARGIN + LINE));
        let names = ["scene", show.reference.0, show.device.0, "difference"];
        for (i, name) in (0..).zip(names) {
            let at = (self.left(i), head);
            text::write_within(&mut page, at, self.column, name, Weight::Heading, ink::TEXT);
        }
        for (i, moment) in (0..).zip(moments) {
            let top = head + LINE + i * (panel + LINE + GAP);
            for (j, (picture, caption)) in (0..).zip(self.row(show, moment)) {
                let (x, y) = (self.left(j), top);
                let picture = panel::enlarged(&picture, self.times);
                imageops::replace(&mut page, &picture, x.into(), y.into());
                let below = (x, top + panel + 2);
                text::write_within(
                    &mut page,
                    below,
                    self.column,
                    &caption,
                    Weight::Plain,
                    ink::CAPTION,
                );
            }
        }
        Ok(page)
    }

    const fn left(&self, column: u32) -> u32 {
        MARGIN + column * (self.column + GAP)
    }

    /// The four panels of a moment, with their captions.
    fn row(&self, show: &Show<'_>, moment: &Moment) -> [(RgbImage, String); 4] {
        let frame = panel::frame(&moment.frame, self.black, self.white);
        let pale = panel::pale(&frame);
        let [reference, device] =
            [show.reference.1, show.device.1].map(|packet| during(packet, moment));
        let difference = Difference::new(reference, device);
        let window = Micros(moment.to.0.saturating_sub(moment.from.0));
        let Difference {
            matched,
            missing,
            extra,
            ..
        } = difference;
        [
            (
                frame,
                format!(
                    "{:.3} s, last {:.1} ms",
                    moment.to.seconds(),
                    window.seconds() * 1e3
                ),
            ),
            (panel::events(pale.clone(), reference), counts(reference)),
            (panel::events(pale, device), counts(device)),
            (
                difference.panel(self.size),
                format!("={matched}  -{missing}  +{extra}"),
            ),
        ]
    }
}

/// The events of a packet in a moment.
fn during<'a>(packet: &'a Packet, moment: &Moment) -> &'a [Event] {
    let until = |t| packet.events.partition_point(|e| e.t <= t);
    packet
        .events
        .get(until(moment.from)..until(moment.to))
        .unwrap_or(&[])
}

fn counts(events: &[Event]) -> String {
    let on = events.iter().filter(|e| e.polarity == Polarity::On).count();
    format!("{on} ON  {} OFF", events.len() - on)
}

fn legend(page: &mut RgbImage, at: (u32, u32)) {
    let (mut x, y) = at;
    let entries: [(Ink, &str); 6] = [
        (ink::ON, "ON"),
        (ink::OFF, "OFF"),
        (ink::MATCHED, "= in both"),
        (ink::MISSING, "- missing from the judged"),
        (ink::EXTRA, "+ extra in the judged"),
        (ink::SWAPPED, "other sign or kind"),
    ];
    for (ink, name) in entries {
        for dy in 0..12 {
            for dx in 0..12 {
                if let Some(pixel) = page.get_pixel_mut_checked(x + dx, y + 3 + dy) {
                    *pixel = ink;
                }
            }
        }
        x = text::write(page, (x + 18, y), name, Weight::Plain, ink::CAPTION) + 22;
    }
}

/// A side of a picture, in pixels, if a picture file can hold it.
fn side(pixels: usize) -> Result<u32, PictureError> {
    match u16::try_from(pixels) {
        Ok(pixels) => Ok(pixels.into()),
        Err(_) => Err(PictureError::TooLarge(Size::new(pixels, pixels))),
    }
}
