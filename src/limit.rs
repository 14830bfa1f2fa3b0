//! How much of what comes from outside is taken: one constant for each limit, all of them in
//! one table.
//!
//! A limit is checked before anything is allocated or looped over. What is beyond it is bad
//! input, with a message that names the limit. `docs/limits.md` is held to [`TABLE`] by a test,
//! which also drives each limit through the program: at the limit it works, one beyond it does
//! not.

/// Bytes of a text file: a sensor, a kernel, a chip's file, a program, a study, a readout; and
/// of a `.npy` of kernels.
pub const TEXT_BYTES: u64 = 4 << 20;

/// Bytes of one line of a text file.
pub const LINE_BYTES: u64 = 64 << 10;

/// Bytes of a `.npy` that is read whole: a register.
pub const NUMBERS_BYTES: u64 = (128 << 20) + (64 << 10);

/// Things that are wrong with one text and are told.
pub const FAULTS: usize = 64;

/// Parentheses and blocks inside each other, in programs and macros.
pub const NESTING: usize = 32;

/// Tokens that a text of vendor C++ becomes, those of its macros included.
pub const VENDOR_TOKENS: usize = 1 << 20;

/// Statements and calls of vendor C++ that are run before the program is known, or in one frame: a
/// second or two. Code that counts its coverage takes ten times as long.
pub const VENDOR_WORK: usize = if cfg!(fuzzing) { 1 << 17 } else { 1 << 21 };

/// Values in one variable of vendor C++.
pub const VENDOR_VALUES: usize = 1 << 20;

/// Operators and calls one behind the other in a value of vendor C++, or `else if`s of one `if`.
pub const CHAIN: usize = 1024;

/// Rows or columns of a kernel.
pub const KERNEL_SIDE: usize = 127;

/// Kernels of one command, and kinds of cells of a sensor.
pub const KERNELS: usize = 16;

/// Size of the largest weight of a kernel that a command names, or that is quantised, compiled or
/// fitted: at least.
pub const LEAST_WEIGHT: f64 = 1e-30;

/// Size of the largest weight of a kernel that a command names, or that is quantised, compiled or
/// fitted: at most.
pub const MOST_WEIGHT: f64 = 1e30;

/// Steps of the search for a kernel's levels.
pub const QUANTISER_STEPS: u64 = 1 << 30;

/// Entries of the table from which levels with a given sum, or a budget of digits, are found.
pub const QUANTISER_TABLE: u64 = 1 << 26;

/// Instruction words, host operations and calls of macros that a program's text becomes.
pub const EXPANDED_STEPS: usize = 1 << 18;

/// Instruction words that one statement becomes.
pub const STATEMENT_WORDS: usize = 100_000;

/// Steps that `init`, or one frame, runs: each word, each host operation, each turn of a
/// `repeat`.
pub const FRAME_STEPS: u64 = 1 << 24;

/// Macros of a chip.
pub const MACROS: usize = 1024;

/// Macros inside each other.
pub const MACRO_DEPTH: usize = 32;

/// Statements in the macros of a chip.
pub const MACRO_STATEMENTS: usize = 1 << 16;

/// Parameters of a form, and arguments that one parameter takes.
pub const ARGUMENTS: usize = 64;

/// Forms of one row of a chip.
pub const FORMS: usize = 64;

/// Other names of registers of a chip.
pub const ALIASES: usize = 256;

/// Rows or columns of an array or a sensor: addresses of events have sixteen bits.
pub const ARRAY_SIDE: usize = 1 << 16;

/// Size of a number about a chip; those that must be above zero are at least one over it.
pub const FIGURE: f64 = 1e12;

/// Instruction words that a chip's store can be said to hold.
pub const STORE_WORDS: u64 = 1 << 18;

/// Values of an axis of a study, or points of a grid.
pub const STUDY_POINTS: u64 = 100_000;

/// Runs of one `exec --repeat`.
pub const RUNS: u64 = 1_000_000;

/// Frames of a scene, or of `exec`.
pub const FRAMES: u64 = 1 << 24;

/// Threads that can be asked for.
pub const THREADS: usize = 1024;

/// Events that the queue of a readout can be said to hold.
pub const QUEUE: u64 = 1 << 32;

/// Pixels of a sensor, and of a frame that it watches.
pub const PIXELS: usize = 1 << 24;

/// Pixels of all frames of an animation or a pattern, which are not in a file pixel by pixel.
pub const DRAWN_PIXELS: u64 = 1 << 38;

/// Pictures of a folder.
pub const PICTURES: usize = 1 << 20;

/// Bytes of one coded picture of an mp4.
pub const SAMPLE_BYTES: u64 = 1 << 26;

/// Bytes of the tables of an mp4, or of one fragment.
pub const MP4_TABLES: u64 = 1 << 26;

/// Coded pictures of an mp4.
pub const SAMPLES: u64 = 1 << 22;

/// Boxes at the top of an mp4.
pub const BOXES: u64 = 1 << 18;

/// Bytes of the file of a point of a sweep.
pub const POINT_BYTES: u64 = 1 << 20;

/// Bytes of the file that says what a folder of results holds.
pub const MANIFEST_BYTES: u64 = 1 << 24;

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The name of its constant.
    pub name: &'static str,
    /// What it limits.
    pub of: &'static str,
    /// The limit.
    pub value: f64,
    /// In what it counts.
    pub unit: &'static str,
    /// Why there.
    pub why: &'static str,
    /// A part of what is said beyond it.
    pub beyond: &'static str,
}

/// Builds the table from the constants, so that no value stands in two places.
macro_rules! table {
    ($(#[$doc:meta])* $table:ident: $($name:ident, $of:literal, $unit:literal, $why:literal, $beyond:literal;)*) => {
        $(#[$doc])*
        pub const $table: &[Limit] = &[$(Limit {
            name: stringify!($name),
            of: $of,
            value: $name as f64,
            unit: $unit,
            why: $why,
            beyond: $beyond,
        }),*];
    };
}

table! {
    /// All limits on text and on the data of chips, kernels and studies.
    TABLE:
    TEXT_BYTES, "a text file (sensor, kernel, chip, program, study, readout), or a .npy of kernels", "bytes",
        "two hundred times the longest that ships", "a text file holds at most";
    LINE_BYTES, "one line of a text file", "bytes",
        "a message shows the line that it is about", "a line holds at most";
    NUMBERS_BYTES, "a .npy that is read whole", "bytes",
        "4096 x 4096 of float64, and a header", "a .npy file holds at most";
    FAULTS, "things that are wrong with one text and are told", "faults",
        "nobody mends more at once", "more are not shown";
    NESTING, "blocks, or parentheses, inside each other", "levels",
        "nobody reads more", "levels inside each other";
    VENDOR_TOKENS, "what vendor C++ becomes before it is parsed: tokens, those of its macros included", "tokens",
        "four for each of the words that a program can become", "more than 1048576 tokens";
    VENDOR_WORK, "what the host of a vendor C++ program does in a frame, or before its program is known", "statements",
        "a second or two; large copies count as many", "statements run";
    VENDOR_VALUES, "values in one variable of vendor C++", "values",
        "sixteen for each cell of a chip", "values in one variable";
    CHAIN, "operators and calls in one value of vendor C++, `else if`s of one `if`", "operators",
        "nobody reads more", "in a row";
    KERNEL_SIDE, "rows or columns of a kernel", "px",
        "Gaussians of the largest sigma, 20 px, have 121", "a side of a kernel is at most";
    KERNELS, "kernels of one file or command, kinds of cells of a sensor", "kernels",
        "as many as the paper's largest sensor has", "kernels at most";
    LEAST_WEIGHT, "the largest weight of a kernel that a command names (`run --kernel` too) or that is quantised, compiled or fitted: least", "",
        "its square is still a number", "is too small";
    MOST_WEIGHT, "the largest weight of a kernel that a command names (`run --kernel` too) or that is quantised, compiled or fitted: most", "",
        "sums of squares are still numbers", "is too large";
    QUANTISER_STEPS, "the search for the levels of a kernel", "steps",
        "ten seconds, about", "steps of search";
    QUANTISER_TABLE, "the table for levels with a sum, or for digits", "entries",
        "128 MiB", "entries of a table";
    EXPANDED_STEPS, "what the text of a program becomes: words, host operations, calls of macros", "steps",
        "64 times the words that the largest shipped chip stores", "the program expands to more than";
    STATEMENT_WORDS, "what one statement becomes", "words",
        "no kernel store holds it", "this statement is longer than";
    FRAME_STEPS, "what `init`, or one frame, runs: words, host operations, turns of `repeat`", "steps",
        "1.7 s of the chip's clock", "runs more than";
    MACROS, "macros of a chip", "macros",
        "twelve times what scamp5 has", "macros at most";
    MACRO_DEPTH, "macros inside each other", "levels",
        "nobody reads more", "macros inside each other";
    MACRO_STATEMENTS, "statements in the macros of a chip", "statements",
        "two hundred and fifty times what scamp5 has", "statements at most";
    ARGUMENTS, "parameters of a form, arguments of a parameter", "arguments",
        "the most registers of one kind", "arguments at most";
    FORMS, "forms of one row of a chip", "forms",
        "one for each way to write it", "forms at most";
    ALIASES, "other names of registers", "names",
        "scamp5 has 13", "aliases at most";
    ARRAY_SIDE, "rows or columns of an array or a sensor", "px",
        "addresses of events have 16 bits", "65536 a side";
    FIGURE, "the size of a number about a chip", "",
        "times and powers stay finite", "at most 1e12 in size";
    STORE_WORDS, "the kernel store of a chip", "words",
        "64 times what the largest shipped chip has", "at most 262144";
    STUDY_POINTS, "points of a study", "points",
        "a day at one a second", "more than 100000";
    RUNS, "runs of `exec --repeat`", "runs",
        "a mean to a thousandth of the spread", "runs at most";
    FRAMES, "frames of a scene, or of `exec`", "frames",
        "19 hours at 240 frames/s", "frames at most";
    THREADS, "threads of `--threads`", "threads",
        "more than any one machine has cores", "threads at most";
    QUEUE, "events in the queue of a readout", "events",
        "more than any packet has", "at most 4294967296";
}

table! {
    /// The limits on scenes and on folders of results.
    FILES:
    PIXELS, "pixels of a sensor, a frame, a register", "px",
        "4096 x 4096: the largest published sensors have 2^20", "are larger than";
    DRAWN_PIXELS, "pixels of all frames of an animation or a pattern", "px",
        "four million frames of 256 x 256", "are more than";
    PICTURES, "pictures of a folder", "pictures",
        "72 minutes at 240 frames/s", "more than";
    SAMPLE_BYTES, "one coded picture of an mp4", "bytes",
        "H.264 at its highest level has less", "expected at most";
    MP4_TABLES, "the tables of an mp4, or of a fragment of it", "bytes",
        "sixteen bytes for each of the coded pictures", "bytes of tables";
    SAMPLES, "coded pictures of an mp4", "pictures",
        "38 hours at 30 frames/s", "more than";
    BOXES, "boxes at the top of an mp4", "boxes",
        "a fragment a second for 36 hours", "more than";
    POINT_BYTES, "the file of a point of a sweep", "bytes",
        "one takes about 2000", "it is damaged, and computed again";
    MANIFEST_BYTES, "the file `sweep.json`", "bytes",
        "the largest study takes four millions", "it is damaged";
}
