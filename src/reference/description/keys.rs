//! The keys of a sensor file.

use crate::{
    config::{File, Key, Kind, Range, Table},
    kernel,
    photoreceptor::Response,
    reference::{noise::Noise, surround},
};

use super::rules::{Border, MemoryRule, PolarityRule, RefractoryRule};

/// Kinds of cells that a pixel may have.
pub(super) const MOST_CHANNELS: usize = crate::limit::KERNELS;

/// A sensor file.
pub const FILE: File = File {
    title: "a sensor of amacrine",
    kind: Kind::Table(&SENSOR),
    see: "docs/reference.md lists every key of a sensor file",
};

pub(super) const SENSOR: Table = Table::new(&[
    Key::optional(
        "name",
        Kind::Text,
        "what it is called; the file's name when left out",
    ),
    Key::optional("source", Kind::Text, "where it came from, for people"),
    Key::required("response", Response::KIND, "from light to signal")
        .example("response = { linear = 255 }"),
    Key::required(
        "memory",
        Kind::Choice(MemoryRule::WORDS),
        "what an event does to the memory",
    )
    .example("memory = \"filtered-step\""),
    Key::with_default(
        "shared",
        Kind::Flag,
        "false",
        "one memory of the pixel for all kinds, which any of them renews when it fires; with memory = \"raw-snap\"",
    ),
    Key::with_default(
        "polarity",
        Kind::Choice(PolarityRule::WORDS),
        "\"filtered\"",
        "where an event's sign comes from",
    ),
    Key::with_default(
        "border",
        Kind::Choice(Border::WORDS),
        "\"replicate\"",
        "what the kernel reads off the array",
    ),
    Key::optional(
        "refractory",
        Kind::Table(&REFRACTORY),
        "how long a cell is silent after an event; not at all when left out",
    ),
    Key::optional(
        "noise",
        Kind::Table(&Noise::TABLE),
        "what disturbs the cells; nothing when left out",
    ),
    Key::required(
        "channel",
        Kind::List {
            of: &Kind::Table(&CHANNEL),
            least: 1,
            most: MOST_CHANNELS,
        },
        "the kinds of cells",
    )
    .example("[[channel]] with a kernel and a threshold for each kind of cell"),
]);

/// The keys of `refractory`.
pub const REFRACTORY: Table = Table::new(&[
    Key::required(
        "us",
        Kind::Number(Range::NOT_NEGATIVE),
        "how long a cell is silent",
    )
    .unit("us")
    .example("us = 1000"),
    Key::with_default(
        "rule",
        Kind::Choice(RefractoryRule::WORDS),
        "\"dead-time\"",
        "how the silence works",
    ),
]);

/// The keys of `threshold`.
pub const THRESHOLD: Table = Table::new(&[
    Key::required("on", Kind::Number(Range::POSITIVE), "for ON events").example("on = 0.2"),
    Key::required(
        "off",
        Kind::Number(Range::POSITIVE),
        "for OFF events, a positive magnitude",
    )
    .example("off = 0.2"),
    Key::with_default(
        "sigma",
        Kind::Number(Range::NOT_NEGATIVE),
        "0",
        "standard deviation of the fixed-pattern mismatch, in the unit of the threshold",
    ),
]);

const CHANNEL: Table = Table {
    one_of: &["kernel", "mesh"],
    keys: &[
        Key::optional(
            "name",
            Kind::Either {
                ways: &[Kind::Text, Kind::list(&Kind::Text)],
                expected: "a text (with an array of several kernels: or a list of as many)",
            },
            "what this kind of cell is called",
        ),
        Key::optional(
            "kernel",
            Kind::Either {
                ways: &[Kind::Text, kernel::ROWS, Kind::list(&ONE)],
                expected: "rows of numbers, such as [[0, -1, 0], [-1, 4, -1], [0, -1, 0]], or the name of a built-in kernel or of a kernel file, of which a .npy of shape (K,k,k) or (K,1,k,k) is K kinds of cells (with pattern = \"2x2\": an array of four)",
            },
            "the receptive field",
        )
        .example("kernel = \"csdvs-5\""),
        Key::optional(
            "mesh",
            Kind::Table(&surround::MESH),
            "resistor sheets that the channel sees through in place of a kernel",
        )
        .example("mesh = { lambda = 10 }"),
        Key::required(
            "threshold",
            Kind::Either {
                ways: &[Kind::Table(&THRESHOLD), Kind::list(&Kind::Table(&THRESHOLD))],
                expected: "{ on = number, off = number, sigma = number }, where sigma may be left out (with pattern = \"2x2\": an array of four; with K kernels in one file: one for all, or K)",
            },
            "when a cell fires, in the unit of the filtered signal",
        )
        .example("threshold = { on = 0.2, off = 0.2 }"),
        Key::optional(
            "pattern",
            Kind::Choice(&["2x2"]),
            "four kernels and thresholds: the pixel at (x, y) uses number 2 (y mod 2) + (x mod 2); the same everywhere when left out",
        ),
        Key::with_default(
            "gain",
            Kind::NONZERO,
            "1",
            "scales the weights; -1 exchanges ON and OFF",
        ),
        Key::optional(
            "memory-kernel",
            ONE,
            "the kernel that the memory is seen through, for memory = \"authors-pixel-step\"",
        ),
        Key::with_default(
            "log-temporal",
            Kind::Flag,
            "false",
            "ln(max(W u, 1e-8) + 1) in place of W u: the released simulator's `log_temporal`; with memory = \"filtered-step\" or \"filtered-snap\"",
        ),
    ],
};

const ONE: Kind = Kind::Either {
    ways: &[Kind::Text, kernel::ROWS],
    expected: "rows of numbers or the name of a built-in kernel or of a kernel file",
};
