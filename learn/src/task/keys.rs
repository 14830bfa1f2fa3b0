//! The keys of a task file.

use amacrine::{
    config::{File, Key, Kind, Range, Table},
    photoreceptor::Response,
};

/// A task file.
pub const FILE: File = File {
    title: "a task of amacrine-learn",
    kind: Kind::Table(&TASK),
    see: "docs/guides/learn-a-kernel.md goes through the keys of a task",
};

/// What the network is to say.
pub(super) const GOALS: &[&str] = &["interpolation", "flow"];

/// How far an answer is from the truth.
pub(super) const LOSSES: &[&str] = &["charbonnier", "l1"];

/// A lower and an upper bound.
const BOUNDS: Kind = Kind::List {
    of: &Kind::Number(Range::POSITIVE),
    least: 2,
    most: 2,
};

const fn whole(least: u64, most: u64) -> Kind {
    Kind::Whole { least, most }
}

pub(super) const TASK: Table = Table::new(&[
    Key::optional(
        "name",
        Kind::Name,
        "what it is called; the file's name when left out",
    )
    .example("name = \"mine\""),
    Key::required("goal", Kind::Choice(GOALS), "what the network is to say")
        .example("goal = \"interpolation\""),
    Key::optional(
        "loss",
        Kind::Choice(LOSSES),
        "how far an answer is from the truth, of white or in px/frame; \"charbonnier\" for interpolation and \"l1\" for flow when left out",
    ),
    Key::with_default("steps", whole(1, 100_000_000), "20000", "steps of each arm"),
    Key::with_default("batch", whole(1, 1024), "8", "clips in a step"),
    Key::with_default("crop", whole(8, 1024), "32", "rows and columns of a clip").unit("px"),
    Key::required(
        "targets",
        Kind::List {
            of: &Kind::Number(Range::FREE),
            least: 1,
            most: 64,
        },
        "events a pixel and pair of frames, all kinds of cells together",
    )
    .example("targets = [0.01, 0.02, 0.05]"),
    Key::required(
        "seeds",
        Kind::List {
            of: &whole(0, i64::MAX as u64),
            least: 1,
            most: 1024,
        },
        "seeds of networks, clips and mismatch",
    )
    .example("seeds = [1, 2, 3]"),
    Key::required(
        "arms",
        Kind::List {
            of: &Kind::Name,
            least: 1,
            most: 64,
        },
        "who takes part: arms by name, or by the few values of their weights, such as `po2-2` or `int-4:zero`",
    )
    .example("arms = [\"none\", \"dvs\", \"rgc\", \"ternary\"]"),
    Key::optional("network", Kind::Table(&NETWORK), "the network of all arms"),
    Key::optional("rates", Kind::Table(&RATES), "how far a step goes at first"),
    Key::optional(
        "sparsity",
        Kind::Table(&SPARSITY),
        "a price of an event in the loss: thresholds are learned in place of following the targets, which only set the first ones",
    ),
    Key::optional("scenes", Kind::Table(&SCENES), "what is seen"),
    Key::optional(
        "sensor",
        Kind::Table(&SENSOR),
        "what all sensors have in common",
    ),
    Key::with_default(
        "chip",
        Kind::Choice(&["scamp5", "none"]),
        "\"scamp5\"",
        "the chip in the loop: its noise, its whole thresholds and its memory, for kernels of few values",
    ),
    Key::optional(
        "price",
        Kind::Table(&PRICE),
        "what the chip adds to the loss of a kernel of few values: neighbours of it are compiled and judged",
    ),
    Key::optional("test", Kind::Table(&TEST), "what the arms are judged on"),
    Key::optional(
        "retrain",
        Kind::Table(&RETRAIN),
        "the network trained on, on the events of each form of the chip; only the network as it was when left out",
    ),
    Key::with_default(
        "checkpoint",
        whole(1, 100_000_000),
        "500",
        "steps between checkpoints: as many are lost when it is killed",
    ),
]);

pub(super) const PRICE: Table = Table::new(&[
    Key::with_default(
        "words",
        Kind::Number(Range::NOT_NEGATIVE),
        "0.0",
        "what a word of the filter adds to the loss",
    ),
    Key::with_default(
        "survival",
        Kind::Number(Range::NOT_NEGATIVE),
        "0.0",
        "what 1 less the predicted correlation with the exact filter on silicon adds to the loss",
    ),
]);

pub(super) const RETRAIN: Table = Table::new(&[
    Key::with_default("steps", whole(1, 1_000_000), "300", "steps of each form"),
    Key::with_default(
        "clips",
        whole(1, 100_000),
        "128",
        "training clips that are shown to the chip",
    ),
]);

pub(super) const NETWORK: Table = Table::new(&[
    Key::optional(
        "widths",
        Kind::List {
            of: &whole(1, 1024),
            least: 1,
            most: 8,
        },
        "channels of each level, the full size first; [16, 24, 32] when left out",
    )
    .example("widths = [16, 24, 32]"),
    Key::with_default(
        "convolutions",
        whole(1, 8),
        "2",
        "3x3 convolutions of a level",
    ),
]);

pub(super) const RATES: Table = Table::new(&[
    Key::with_default(
        "network",
        Kind::Number(Range::POSITIVE),
        "0.001",
        "of the network's weights",
    ),
    Key::with_default(
        "kernel",
        Kind::Number(Range::POSITIVE),
        "0.003",
        "of a kernel's weights, whose squares sum to 1",
    ),
]);

pub(super) const SPARSITY: Table = Table::new(&[Key::required(
    "weight",
    Kind::Number(Range::NOT_NEGATIVE),
    "what an event costs in the loss, summed over the batch",
)
.example("weight = 5e-8")]);

pub(super) const SCENES: Table = Table::new(&[
    Key::optional(
        "photographs",
        Kind::Name,
        "a folder of pictures, from the task file on; those that come with the program when left out",
    )
    .example("photographs = \"a/folder\""),
    Key::optional(
        "video",
        Kind::Name,
        "a video, from the task file on, a pattern or `bundled`, in place of photographs, as `amacrine run` takes it; for interpolation",
    )
    .example("video = \"a/video.mp4\""),
    Key::with_default(
        "clips",
        whole(0, 10_000_000),
        "8192",
        "different clips to train on, each made once and kept; with 0 each step has new ones",
    ),
    Key::with_default("frames", whole(3, 65), "9", "frames of a clip, odd"),
    Key::with_default(
        "fps",
        Kind::Number(Range::POSITIVE),
        "240",
        "frames a second",
    )
    .unit("Hz"),
    Key::with_default(
        "pan",
        Kind::Number(Range::POSITIVE),
        "2.5",
        "the most that a picture moves, `crop` at most",
    )
    .unit("px/frame"),
    Key::with_default(
        "turn",
        Kind::Number(Range::between(0.0, 45.0)),
        "1.0",
        "the most that a picture turns, either way",
    )
    .unit("degrees/frame"),
    Key::with_default(
        "zoom",
        Kind::Number(Range::between(0.0, 0.5)),
        "0.01",
        "the most that a picture grows or shrinks, as a part of its size a frame",
    ),
    Key::with_default(
        "shear",
        Kind::Number(Range::between(0.0, 0.5)),
        "0.004",
        "the most that a picture is stretched and sheared, as a part of its size a frame",
    ),
    Key::optional(
        "gain",
        BOUNDS,
        "what the light of a clip is multiplied by, after the gamma: the least and the most; [0.7, 1.2] when left out",
    )
    .example("gain = [0.7, 1.2]"),
    Key::optional(
        "gamma",
        BOUNDS,
        "the exponent of the light of a clip, in parts of white: the least and the most; [0.8, 1.25] when left out",
    )
    .example("gamma = [0.8, 1.25]"),
    Key::with_default(
        "occluded",
        Kind::Number(Range::between(0.0, 1.0)),
        "0.6",
        "the part of clips with a second layer before the first",
    ),
]);

pub(super) const SENSOR: Table = Table::new(&[
    Key::optional(
        "response",
        Response::KIND,
        "from light to signal; { linear = 255 } when left out",
    )
    .example("response = { linear = 255 }"),
    Key::with_default(
        "refractory-us",
        Kind::Number(Range::NOT_NEGATIVE),
        "0",
        "how long a cell is silent after an event",
    )
    .unit("us"),
    Key::with_default(
        "light-noise",
        Kind::Number(Range::NOT_NEGATIVE),
        "0.5",
        "noise of the light before the kernel, standard deviation, of 255",
    ),
    Key::with_default(
        "mismatch",
        Kind::Number(Range::between(0.0, 1.0)),
        "0.1",
        "mismatch of thresholds, standard deviation, a part of the threshold",
    ),
]);

pub(super) const TEST: Table = Table::new(&[
    Key::with_default("clips", whole(1, 1_000_000), "128", "held-out clips"),
    Key::with_default("crop", whole(8, 1024), "48", "rows and columns of each").unit("px"),
]);
