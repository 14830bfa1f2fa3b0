//! What the sources leave open, by name, with a default.

use crate::isa::{Device, Figure};

/// How the array behaves where the vendor's sources leave it open.
///
/// Analogue values are on the chip's ADC scale ("LSB", -128 to 127).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What every register of a pixel off the array holds, in LSB. Evidence: guess, the vendor
    /// does not say; open simulators take 0.
    pub edge: f64,
    /// Whether every analogue store is limited to [-128, 127] LSB.
    pub clip: bool,
    /// What PIX rises by for one unit of light, in LSB. 0.5 makes 8-bit light fill the half
    /// range that `get_image` gives. Evidence: modelled; the vendor's older simulator has 0.495.
    pub gain: f64,
    /// What PIX holds after a reset, in LSB. Evidence: quoted, "resets to the lowest level":
    /// it reads as +127 through one inverting store.
    pub reset_level: f64,
    /// How far R12 spreads in one PROP.
    pub propagation: Propagation,
    /// One link of the diffusion network against the pixel's own cell, as one part in so many:
    /// `blur` moves 1/8 of the difference to each connected neighbour. At least 4.
    /// Evidence: guess.
    pub diffusion: u8,
    /// NEWS := this times the square of the sum, in 1/LSB. Evidence: guess; the vendor gives no
    /// calibration of the squarer.
    pub square_gain: f64,
}

/// How far a bit spreads in one PROP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Propagation {
    /// Until nothing changes.
    Settled,
    /// So many pixels. Real chips differ; SCAMP-5's data say 128, about half the array.
    Steps(u32),
}

impl Settings {
    /// What a chip's data says, no clipping.
    #[must_use]
    pub fn of(device: &Device) -> Self {
        Self {
            edge: device.value(Figure::Edge),
            clip: false,
            gain: device.value(Figure::LightScale),
            reset_level: device.value(Figure::LightReset),
            propagation: Propagation::Steps(device.value(Figure::Travel) as u32),
            diffusion: 8,
            square_gain: 1.0,
        }
    }
}
