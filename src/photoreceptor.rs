//! From light to the signal that the kernels see.
//!
//! Four static responses, `u = R(I)` for light `I` (0 to 255 for 8-bit video):
//!
//! | response | `R(I)` | who uses it |
//! |---|---|---|
//! | `"identity"` | `I` | scenes that are a signal already; the only one that takes negative values |
//! | `{ linear = 255 }` | `I / 255` | the released Neural Ganglion Sensors data set ("linear") |
//! | `{ log = { white = 255, offset = 1e-5 } }` | `ln(I / white + offset)` | the same, "log"; ESIM (offset 1e-3) |
//! | `{ lin-log = { knee = 20 } }` | `I ln(knee) / knee` up to the knee, `ln I` above | v2e |
//!
//! `round = "f32"` in a response rounds the result to single precision, as the released data
//! set does before its double-precision simulator reads it.

use crate::{
    config::{Document, Fault, Key, Kind, Node, Range, Read, Section, Table},
    elementary,
};

/// The static response of the photoreceptor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// The curve.
    pub curve: Curve,
    /// Whether the result is rounded to single precision.
    pub round_f32: bool,
}

/// The shape of a response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// `I`, which may be negative.
    Identity,
    /// `I / white`.
    Linear {
        /// The light that maps to 1.
        white: f64,
    },
    /// `ln(I / white + offset)`.
    Log {
        /// The light that maps to `ln(1 + offset)`.
        white: f64,
        /// What keeps the logarithm of black finite.
        offset: f64,
    },
    /// `I ln(knee) / knee` up to the knee, `ln I` above it.
    LinLog {
        /// Where the two parts meet, in units of light; v2e uses 20.
        knee: f64,
    },
}

/// Light that a response is not defined for, or that an arithmetic does not hold.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LightError {
    /// NaN or infinite.
    #[error("the light is {0}, which is not finite")]
    NotFinite(f64),
    /// Below zero where the response needs light.
    #[error("the light is {0}, below zero; only response = \"identity\" takes negative values")]
    Negative(f64),
    /// More than the photodiodes of an array can hold in its arithmetic.
    #[error("the light is {0:e}, more than the arithmetic of the array holds")]
    Beyond(f64),
}

impl Response {
    /// Light as it is.
    pub const IDENTITY: Self = Self::new(Curve::Identity);

    /// A response of this shape in full precision.
    #[must_use]
    pub const fn new(curve: Curve) -> Self {
        Self {
            curve,
            round_f32: false,
        }
    }

    /// `R(light)`.
    ///
    /// # Errors
    /// When the light is not finite, or negative and the response is not the identity.
    pub fn apply(self, light: f64) -> Result<f64, LightError> {
        if !light.is_finite() {
            return Err(LightError::NotFinite(light));
        }
        if light < 0.0 && self.curve != Curve::Identity {
            return Err(LightError::Negative(light));
        }
        let signal = match self.curve {
            Curve::Identity => light,
            Curve::Linear { white } => light / white,
            Curve::Log { white, offset } => elementary::ln(light / white + offset),
            Curve::LinLog { knee } if light <= knee => light * (elementary::ln(knee) / knee),
            Curve::LinLog { .. } => elementary::ln(light),
        };
        Ok(if self.round_f32 {
            f64::from(signal as f32)
        } else {
            signal
        })
    }

    /// The first of its numbers that a file cannot state.
    #[must_use]
    pub(crate) fn odd(self) -> Option<String> {
        let numbers = match self.curve {
            Curve::Identity => Vec::new(),
            Curve::Linear { white } => vec![("white", white, Range::POSITIVE)],
            Curve::Log { white, offset } => vec![
                ("white", white, Range::POSITIVE),
                ("offset", offset, Range::POSITIVE),
            ],
            Curve::LinLog { knee } => vec![("knee", knee, KNEE)],
        };
        let mut odd = numbers
            .iter()
            .filter(|(_, value, range)| !range.holds(*value));
        if let Some((name, value, _)) = odd.next() {
            return Some(format!("{name} of {value}"));
        }
        let rounds = matches!(self.curve, Curve::Identity | Curve::LinLog { .. }) && self.round_f32;
        rounds.then(|| "rounding to f32, which only linear and log have".to_owned())
    }

    /// The light that it takes for white; 255 where it does not say.
    #[must_use]
    pub const fn white(self) -> f64 {
        match self.curve {
            Curve::Linear { white } | Curve::Log { white, .. } => white,
            Curve::Identity | Curve::LinLog { .. } => 255.0,
        }
    }

    /// `dR/dI` at `light`, which must be one that the response is defined for; at the knee of
    /// `lin-log` that of the lower part. Rounding is passed over.
    #[must_use]
    pub fn slope(self, light: f64) -> f64 {
        match self.curve {
            Curve::Identity => 1.0,
            Curve::Linear { white } => 1.0 / white,
            Curve::Log { white, offset } => 1.0 / (light + offset * white),
            Curve::LinLog { knee } if light <= knee => elementary::ln(knee) / knee,
            Curve::LinLog { .. } => 1.0 / light,
        }
    }

    /// The light that gives `signal`: the inverse of [`Response::apply`], but for rounding.
    #[must_use]
    pub fn light(self, signal: f64) -> f64 {
        match self.curve {
            Curve::Identity => signal,
            Curve::Linear { white } => signal * white,
            Curve::Log { white, offset } => (elementary::exp(signal) - offset) * white,
            Curve::LinLog { knee } if signal <= elementary::ln(knee) => {
                signal * (knee / elementary::ln(knee))
            }
            Curve::LinLog { .. } => elementary::exp(signal),
        }
    }
}

const CURVES: Table = Table {
    one_of: &["linear", "log", "lin-log"],
    keys: &[
        Key::optional(
            "linear",
            Kind::Either {
                ways: &[WHITE, Kind::Table(&LINEAR)],
                expected: "the light that maps to 1, or { white = 255, round = \"f32\" }",
            },
            "the light that maps to 1",
        )
        .example("linear = 255"),
        Key::optional("log", Kind::Table(&LOG), "ln(I / white + offset)")
            .example("log = { white = 255, offset = 1e-5 }"),
        Key::optional(
            "lin-log",
            Kind::Table(&LIN_LOG),
            "linear up to the knee, ln I above it",
        )
        .example("lin-log = { knee = 20 }"),
    ],
};

const WHITE: Kind = Kind::Number(Range::POSITIVE);

const ROUND: Key = Key::with_default(
    "round",
    Kind::Choice(&["f64", "f32"]),
    "\"f64\"",
    "to which precision the result is rounded",
);

const LINEAR: Table = Table::new(&[
    Key::required("white", WHITE, "the light that maps to 1").example("white = 255"),
    ROUND,
]);

const LOG: Table = Table::new(&[
    Key::required("white", WHITE, "the light that maps to ln(1 + offset)").example("white = 255"),
    Key::required(
        "offset",
        Kind::Number(Range::POSITIVE),
        "what keeps the logarithm of black finite",
    )
    .example("offset = 1e-5"),
    ROUND,
]);

/// Below 1 the two parts cannot both rise.
const KNEE: Range = Range::above(1.0);

const LIN_LOG: Table = Table::new(&[Key::required(
    "knee",
    Kind::Number(KNEE),
    "the light where the two parts meet",
)
.example("knee = 20")]);

impl Response {
    /// How a response is written in a file.
    pub const KIND: Kind = Kind::Either {
        ways: &[Kind::Choice(&["identity"]), Kind::Table(&CURVES)],
        expected: "\"identity\", { linear = 255 }, { log = { white = 255, offset = 1e-5 } } or { lin-log = { knee = 20 } }",
    };

    /// The response that a text of TOML states, such as `{ linear = 255 }`.
    ///
    /// # Errors
    /// When it states none.
    pub fn parse(text: &str) -> Read<Self> {
        let document = Document::value(text)?;
        Self::read(Self::KIND.check(document.root(), "response", "")?)
    }

    /// The response that a checked value of [`Response::KIND`] states.
    ///
    /// # Errors
    /// When a number is missing.
    pub fn read(node: Node<'_>) -> Read<Self> {
        let curves = Section::new(node, &CURVES);
        let round =
            |section: &Section<'_>| Ok(section.word("round", &[false, true])? == Some(true));
        let mut keys = CURVES.keys.iter();
        let Some(key) = keys.find(|key| curves.get(key.name).is_some()) else {
            // The one that is no table.
            return Ok(Self::IDENTITY);
        };
        match (key.name, curves.table(key.name)) {
            ("linear", None) => Ok(Self::new(Curve::Linear {
                white: curves.number("linear")?,
            })),
            ("linear", Some(linear)) => Ok(Self {
                curve: Curve::Linear {
                    white: linear.number("white")?,
                },
                round_f32: round(&linear)?,
            }),
            ("log", Some(log)) => Ok(Self {
                curve: Curve::Log {
                    white: log.number("white")?,
                    offset: log.number("offset")?,
                },
                round_f32: round(&log)?,
            }),
            ("lin-log", Some(lin_log)) => Ok(Self::new(Curve::LinLog {
                knee: lin_log.number("knee")?,
            })),
            (name, _) => {
                let what = format!("the response `{name}` is listed and not read");
                let fault = Fault::error(node.place(), what, "this response");
                Err(fault.help("read it in src/photoreceptor.rs"))
            }
        }
    }

    /// As a file states it; a rounding that no file may have is refused when it is read.
    #[must_use]
    pub fn text(self) -> String {
        let Self { curve, round_f32 } = self;
        let round = if round_f32 { ", round = \"f32\"" } else { "" };
        match curve {
            Curve::Identity => "\"identity\"".to_owned(),
            Curve::Linear { white } if round.is_empty() => format!("{{ linear = {white:?} }}"),
            Curve::Linear { white } => format!("{{ linear = {{ white = {white:?}{round} }} }}"),
            Curve::Log { white, offset } => {
                format!("{{ log = {{ white = {white:?}, offset = {offset:?}{round} }} }}")
            }
            Curve::LinLog { knee } => format!("{{ lin-log = {{ knee = {knee:?}{round} }} }}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Response, String> {
        Response::parse(text).map_err(|fault| fault.message)
    }

    #[test]
    fn each_form_is_read() {
        assert_eq!(parse("\"identity\"").unwrap().curve, Curve::Identity);
        assert_eq!(
            parse("{ linear = 255 }").unwrap().curve,
            Curve::Linear { white: 255.0 }
        );
        let rounded = parse("{ linear = { white = 255, round = \"f32\" } }").unwrap();
        assert!(rounded.round_f32);
        assert_eq!(
            parse("{ log = { white = 255, offset = 1e-5 } }")
                .unwrap()
                .curve,
            Curve::Log {
                white: 255.0,
                offset: 1e-5
            }
        );
        assert_eq!(
            parse("{ lin-log = { knee = 20 } }").unwrap().curve,
            Curve::LinLog { knee: 20.0 }
        );
    }

    /// A key of the table that nobody reads would be a fault.
    #[test]
    fn every_listed_curve_is_read_and_written_back() {
        for key in CURVES.keys {
            let text = format!("{{ {} }}", key.example);
            let read = parse(&text).unwrap();
            assert_ne!(read.curve, Curve::Identity, "{text}");
            assert_eq!(parse(&read.text()).unwrap(), read, "{text}");
        }
        let rounded = "{ linear = { white = 255.0, round = \"f32\" } }";
        assert_eq!(parse(rounded).unwrap().text(), rounded);
        assert_eq!(parse("\"identity\"").unwrap().text(), "\"identity\"");
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, want) in [
            (
                "\"cubic\"",
                "unknown value `cubic`, expected \"identity\", {",
            ),
            ("{ linear = 0 }", "`response.linear` is 0"),
            (
                "{ log = { white = 255, offset = 0 } }",
                "`response.log.offset` is 0",
            ),
            ("{}", "missing key `linear`, `log`, `lin-log`"),
            ("3", "`response` takes \"identity\", {"),
        ] {
            let message = parse(text).unwrap_err();
            assert!(message.starts_with(want), "{text}: {message}");
        }
    }

    #[test]
    fn values_are_the_formulas() {
        let at = |curve, light| Response::new(curve).apply(light).unwrap();
        assert_eq!(at(Curve::Linear { white: 255.0 }, 51.0), 0.2);
        assert_eq!(
            at(
                Curve::Log {
                    white: 255.0,
                    offset: 1e-5
                },
                0.0
            ),
            1e-5_f64.ln()
        );
        // Both parts of lin-log meet at the knee; black is finite.
        let knee = Curve::LinLog { knee: 20.0 };
        assert!((at(knee, 20.0) - 20f64.ln()).abs() < 1e-15);
        assert!((at(knee, 20.0 + 1e-12) - 20f64.ln()).abs() < 1e-12);
        assert_eq!(at(knee, 0.0), 0.0);
    }

    #[test]
    fn light_can_be_had_back() {
        let curves = [
            Curve::Identity,
            Curve::Linear { white: 255.0 },
            Curve::Log {
                white: 255.0,
                offset: 1e-3,
            },
            Curve::LinLog { knee: 20.0 },
        ];
        for curve in curves {
            for light in [0.0, 1e-6, 3.0, 20.0, 21.0, 255.0, 1e9] {
                let response = Response::new(curve);
                let back = response.light(response.apply(light).unwrap());
                assert!(
                    (back - light).abs() <= 1e-12 * light.max(1.0),
                    "{curve:?}: {back}, not {light}"
                );
            }
        }
    }

    #[test]
    fn impossible_light_is_refused() {
        let log = Response::new(Curve::Log {
            white: 255.0,
            offset: 1e-5,
        });
        assert_eq!(log.apply(-1.0), Err(LightError::Negative(-1.0)));
        assert!(log.apply(f64::NAN).is_err());
        assert!(Response::new(Curve::Identity).apply(f64::INFINITY).is_err());
        assert_eq!(Response::new(Curve::Identity).apply(-3.0), Ok(-3.0));
    }
}
