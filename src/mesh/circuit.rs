//! What a resistive grid costs in silicon: constants, noise, power, area, drift with temperature.
//! All of it is modelled (textbook equations over the numbers that are given), nothing is measured.
//!
//! | equation | source |
//! |---|---|
//! | `λ = 1/sqrt(R g)`, `τ = C/g` | Kirchhoff |
//! | noise `sqrt(kT/C)` on every node | equipartition |
//! | slope of the photoreceptor `U_T/κ` an e-fold, `U_T = kT/q` | Delbruck and Mead 1994 |
//! | bias of a follower whose conductance is `g = κ I / 2 U_T` | Mead 1989, subthreshold |
//! | `g` of such a follower falls as `1/T` at a fixed `I` | the same |
//! | a resistor of `R/R_sheet` squares of width `w` at pitch `p` takes `w p R/R_sheet` | geometry |

/// Boltzmann's constant, J/K (exact in the SI since 2019).
pub const BOLTZMANN: f64 = 1.380_649e-23;
/// The elementary charge, C (exact in the SI since 2019).
pub const CHARGE: f64 = 1.602_176_634e-19;

/// The circuit of one pixel.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Circuit {
    /// Lateral resistor, ohm.
    pub lateral: f64,
    /// Transverse conductance, siemens.
    pub transverse: f64,
    /// Capacitor, farad.
    pub capacitance: f64,
    /// Temperature, kelvin.
    pub kelvin: f64,
    /// Slope factor κ of the transistors, 0 to 1.
    pub kappa: f64,
}

/// A layer of the process from which resistors are made.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Layer {
    /// Sheet resistance, ohm per square.
    pub sheet: f64,
    /// Width of a resistor, micrometres.
    pub width: f64,
    /// Distance from one turn of a meandering resistor to the next, micrometres.
    pub pitch: f64,
}

impl Circuit {
    /// The transverse conductance that gives a space constant of `lambda` pixels.
    #[must_use]
    pub fn with_lambda(self, lambda: f64) -> Self {
        Self {
            transverse: 1.0 / (lambda * lambda * self.lateral),
            ..self
        }
    }

    /// Space constant, pixels.
    #[must_use]
    pub fn lambda(self) -> f64 {
        1.0 / (self.lateral * self.transverse).sqrt()
    }

    /// Time constant `C / g`, seconds.
    #[must_use]
    pub fn tau(self) -> f64 {
        self.capacitance / self.transverse
    }

    /// Thermal voltage `kT/q`, volts.
    #[must_use]
    pub fn thermal_volts(self) -> f64 {
        BOLTZMANN * self.kelvin / CHARGE
    }

    /// What a photoreceptor's output moves by when the light grows by a factor e, volts.
    #[must_use]
    pub fn volts_per_efold(self) -> f64 {
        self.thermal_volts() / self.kappa
    }

    /// Thermal noise of a node, `sqrt(kT/C)`, volts, standard deviation. Active followers make
    /// more.
    #[must_use]
    pub fn noise_volts(self) -> f64 {
        (BOLTZMANN * self.kelvin / self.capacitance).sqrt()
    }

    /// The same noise in e-folds of light: the `noise` of a mesh behind a logarithmic
    /// photoreceptor.
    #[must_use]
    pub fn noise_efolds(self) -> f64 {
        self.noise_volts() / self.volts_per_efold()
    }

    /// Bias power of a pixel whose transverse conductance is a subthreshold follower, at
    /// `supply` volts, watts.
    #[must_use]
    pub fn bias_watts(self, supply: f64) -> f64 {
        supply * 2.0 * self.thermal_volts() * self.transverse / self.kappa
    }

    /// Power dissipated by one lateral resistor with `volts` across it, watts.
    #[must_use]
    pub fn lateral_watts(self, volts: f64) -> f64 {
        volts * volts / self.lateral
    }

    /// Area of the two lateral resistors of a pixel, square micrometres.
    #[must_use]
    pub fn area(self, layer: Layer) -> f64 {
        2.0 * self.lateral / layer.sheet * layer.width * layer.pitch
    }

    /// The same pixel at another temperature: the resistor changes by `per_kelvin` of itself a
    /// kelvin, the follower's conductance as `1/T`.
    #[must_use]
    pub fn at(self, kelvin: f64, per_kelvin: f64) -> Self {
        Self {
            lateral: self.lateral * (1.0 + per_kelvin * (kelvin - self.kelvin)),
            transverse: self.transverse * self.kelvin / kelvin,
            kelvin,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(got: f64, want: f64) {
        assert!((got / want - 1.0).abs() < 0.03, "{got}, not {want}");
    }

    /// Figures worked out apart from this code.
    #[test]
    fn figures() {
        let pixel = Circuit {
            lateral: 1e7,
            transverse: 0.0,
            capacitance: 20e-15,
            kelvin: 300.0,
            kappa: 0.7,
        };
        near(pixel.with_lambda(3.0).tau(), 1.8e-6);
        near(pixel.with_lambda(10.0).tau(), 20e-6);
        near(pixel.with_lambda(10.0).lambda(), 10.0);
        near(pixel.volts_per_efold(), 0.037);
        near(
            Circuit {
                capacitance: 10e-15,
                ..pixel
            }
            .noise_volts(),
            643e-6,
        );
        near(
            Circuit {
                capacitance: 10e-15,
                ..pixel
            }
            .noise_efolds(),
            0.0174,
        );
        near(pixel.with_lambda(3.0).bias_watts(1.8), 1.5e-9);
        let layer = |sheet| Layer {
            sheet,
            width: 0.5,
            pitch: 1.0,
        };
        let megohm = Circuit {
            lateral: 1e6,
            ..pixel
        };
        near(megohm.area(layer(200.0)), 2.0 * 2500.0);
        near(megohm.lateral_watts(pixel.volts_per_efold()), 1.4e-9);
        // 30 K warmer: the follower is 10 % weaker, so the surround is 5 % wider.
        let warm = pixel.with_lambda(10.0).at(330.0, 0.0);
        near(warm.lambda(), 10.0 * 1.1f64.sqrt());
        near(warm.tau(), 22e-6);
        near(
            pixel.with_lambda(10.0).at(330.0, -1e-3).lambda(),
            10.0 * (1.1f64 / 0.97).sqrt(),
        );
    }
}
