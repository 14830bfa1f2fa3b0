//! Pictures of packets: what the scene showed, what both sensors said, where they differ; and
//! of one packet alone, in [`view`].
//!
//! [`contact_sheet`] puts several moments below each other, [`write_animation`] one after the
//! other; both show the same four panels. Single panels are in [`panel`], colours in [`ink`].
//! An event belongs to a moment when `from < t <= to`, so moments that touch share no event.

mod animation;
mod chart;
mod curve;
mod error;
pub mod front;
pub mod ink;
mod kernels;
mod lines;
pub mod panel;
mod rates;
mod sheet;
mod strip;
mod surround;
mod text;
pub mod trace;
mod trade;
pub mod view;
mod waterfall;
mod write;

pub use animation::{write_animation, write_frames};
pub use chart::{Drawing, png, raster, svg};
pub use curve::{CurvePoint, CurveShow, curve};
pub use error::PictureError;
pub use kernels::kernels;
pub use lines::{Line, LinesShow, lines};
pub use rates::{RatesCause, RatesShow, rates, share_text};
pub use sheet::{Moment, Show, contact_sheet};
pub use strip::{StripCell, strip};
pub use surround::{SurroundShow, relief, surround};
pub use text::unknown_letters;
pub use trade::{TradeDot, TradeShow, trade};
pub use waterfall::{WaterfallShow, WaterfallStep, waterfall};
pub use write::{write_drawing, write_png, write_svg};
