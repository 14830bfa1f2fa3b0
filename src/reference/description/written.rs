//! The keys of a sensor file, as they are written.

use std::fmt;

use serde::{
    Deserialize, Deserializer,
    de::{
        MapAccess, SeqAccess, Visitor,
        value::{MapAccessDeserializer, SeqAccessDeserializer},
    },
};
use toml::Spanned;

use crate::photoreceptor::Response;

use super::{
    super::{noise::Noise, surround},
    Border, MemoryRule, PolarityRule, Refractory, Threshold,
};

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Written {
    pub(super) name: Option<String>,
    #[expect(dead_code, reason = "for people")]
    pub(super) source: Option<String>,
    pub(super) response: Response,
    pub(super) memory: Spanned<MemoryRule>,
    #[serde(default)]
    pub(super) polarity: Option<Spanned<PolarityRule>>,
    #[serde(default)]
    pub(super) border: Border,
    pub(super) refractory: Option<Spanned<Refractory>>,
    pub(super) noise: Option<Spanned<Noise>>,
    pub(super) channel: Option<Spanned<Vec<Spanned<WrittenChannel>>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct WrittenChannel {
    pub(super) name: Option<String>,
    pub(super) kernel: Option<Spanned<WrittenKernels>>,
    pub(super) mesh: Option<Spanned<surround::Written>>,
    pub(super) threshold: Spanned<WrittenThresholds>,
    pub(super) pattern: Option<Spanned<String>>,
    pub(super) gain: Option<Spanned<f64>>,
    pub(super) memory_kernel: Option<Spanned<WrittenKernel>>,
    #[serde(default)]
    pub(super) log_temporal: bool,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected rows of numbers, such as [[0, -1, 0], [-1, 4, -1], [0, -1, 0]], or the name of a built-in kernel or of a kernel file (with pattern = \"2x2\": an array of four)"
)]
pub(super) enum WrittenKernels {
    One(WrittenKernel),
    Several(Vec<WrittenKernel>),
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected rows of numbers or the name of a built-in kernel or of a kernel file"
)]
pub(super) enum WrittenKernel {
    Rows(Vec<Vec<f64>>),
    Name(String),
}

pub(super) enum WrittenThresholds {
    One(Threshold),
    Several(Vec<Threshold>),
}

/// Not an untagged enum, whose errors do not say which key is wrong.
impl<'de> Deserialize<'de> for WrittenThresholds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;

        impl<'de> Visitor<'de> for Either {
            type Value = WrittenThresholds;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("{ on = number, off = number, sigma = number }, where sigma may be left out (with pattern = \"2x2\": an array of four)")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                Threshold::deserialize(MapAccessDeserializer::new(map)).map(WrittenThresholds::One)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(seq)).map(WrittenThresholds::Several)
            }
        }

        deserializer.deserialize_any(Either)
    }
}
