//! Bad sensor files: each file of `tests/bad/sensor/` breaks one rule. Each gets one message
//! that names the file, the line and the column, says what is wrong, and what to do.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use amacrine::reference::Description;

/// File, line, column, how the message begins, how the advice begins.
#[rustfmt::skip]
const MESSAGES: &[(&str, usize, usize, &str, &str)] = &[
    ("authors_refractory_that_snaps", 3, 14, "refractory rule = \"authors\" counts the steps of a memory, but this memory snaps", "use rule = \"dead-time\", or memory = \"filtered-step\""),
    ("channel_is_a_table", 4, 1, "`channel` takes a list, this is a table", "write [[channel]], in two brackets, once for each of them"),
    ("damaged_array", 5, 10, "kernel file truncated.npy: missing 20 bytes of data specified in header", "give an array of shape (k,k), (K,k,k) or (K,1,k,k)"),
    ("damaged_kernel_file", 5, 10, "kernel file kernel_without_weights.txt:1:1: missing key `weights`, `centre-surround`", "a kernel file is TOML with one of `weights`,"),
    ("dead_time_for_pixel_step", 3, 14, "memory = \"authors-pixel-step\" exists to agree with the released code, whose refractory", "use rule = \"authors\""),
    ("deep_array", 5, 10, "kernel file four_axes.npy: it has shape (", "give an array of shape (k,k), (K,k,k) or (K,1,k,k)"),
    ("duplicate_key", 3, 1, "not TOML: duplicate key", "leave one of the two out: a table has a key once"),
    ("empty_channels", 3, 11, "`channel` has 0 entries", "give 1 to 16"),
    ("empty_kernel", 5, 10, "the kernel is empty; give an odd number of rows, each with the same odd number of weights", "kernels are 1x1, 3x3, 5x5, …: rows of numbers, row 0 to the"),
    ("even_kernel", 5, 10, "the kernel is 2 rows by 2 columns; both must be odd, so that it has a centre", "kernels are 1x1, 3x3, 5x5, …: rows of numbers, row 0 to the"),
    ("hot_fraction_above_one", 5, 16, "`noise.hot-fraction` is 2", "give a number from 0 to 1: share of the cells that are hot"),
    ("huge_gain", 5, 10, "with gain 1e300: the weight at row 0, column 0 is inf; weights must be finite", "give a smaller gain"),
    ("kernel_is_a_number", 5, 10, "`kernel` takes rows of numbers, such as [[0, -1, 0], [-1, 4, -1], [0, -1, 0]], or the name of a", "docs/reference.md lists every key of a sensor file"),
    ("kernel_of_words", 5, 10, "`kernel` takes rows of numbers, such as [[0, -1, 0], [-1, 4, -1], [0, -1, 0]], or the name of a", "docs/reference.md lists every key of a sensor file"),
    ("kernels_without_pattern", 5, 10, "several kernels in one channel", "add pattern = \"2x2\" for four kernels, or one [[channel]]"),
    ("leak_of_pixels", 5, 11, "noise.leak-hz is in thresholds of the filtered signal, but this memory holds pixels", "use memory = \"filtered-snap\" or \"filtered-step\", or leave"),
    ("leak_under_the_authors_rule", 6, 11, "noise.leak-hz moves the memory between frames, which the authors' refractory rule does", "use rule = \"dead-time\", or leave the leak out"),
    ("log_temporal_of_pixels", 6, 16, "log-temporal is the logarithm of the filtered signal, and this memory holds pixels", "use memory = \"filtered-step\" or \"filtered-snap\", or leave"),
    ("log_without_offset", 1, 20, "missing key `offset`", "add it, such as offset = 1e-5"),
    ("low_knee", 1, 33, "`response.lin-log.knee` is 1", "give a number above 1: the light where the two parts meet"),
    ("memory_kernel_without_pixel_step", 6, 17, "memory-kernel is only for memory = \"authors-pixel-step\"", "leave it out: the memory of the other rules is seen through"),
    ("nan_kernel", 5, 10, "the weight at row 1, column 1 is NaN; weights must be finite", "kernels are 1x1, 3x3, 5x5, …: rows of numbers, row 0 to the"),
    ("nan_noise", 5, 11, "`noise.leak-hz` is NaN", "give a number from 0 to 1000000: ON events"),
    ("nan_threshold", 6, 20, "`threshold.on` is NaN", "give a number above 0: for ON events"),
    ("negative_noise", 6, 11, "`noise.shot-hz` is -5", "give a number from 0 to 1000000: noise events"),
    ("negative_refractory", 3, 21, "`refractory.us` is -1", "give a number of at least 0: how long"),
    ("negative_sigma", 6, 44, "`threshold.sigma` is -0.1", "give a number of at least 0: standard deviation"),
    ("negative_threshold", 6, 31, "`threshold.off` is -0.2", "give a number above 0: for OFF events, a positive magnitude"),
    ("no_channel", 1, 1, "missing key `channel`", "add it, such as [[channel]] with a kernel and a threshold for each"),
    ("no_kernel", 4, 1, "missing key `kernel`", "add one of them, such as kernel = \"csdvs-5\""),
    ("no_light", 1, 23, "`response.linear` is 0", "give a number above 0: the light that maps to 1"),
    ("no_memory", 1, 1, "missing key `memory`", "add it, such as memory = \"filtered-step\""),
    ("no_response", 1, 1, "missing key `response`", "add it, such as response = { linear = 255 }"),
    ("no_threshold", 4, 1, "missing key `threshold`", "add it, such as threshold = { on = 0.2, off = 0.2 }"),
    ("noise_faster_than_time", 5, 11, "`noise.shot-hz` is 1000000000", "give a number from 0 to 1000000"),
    ("not_toml", 2, 10, "not TOML: invalid boolean, expected `false`", "write key = value; words go in quotes, as in name ="),
    ("one_sided_threshold", 6, 13, "missing key `off`", "add it, such as off = 0.2"),
    ("pattern_without_four_kernels", 5, 10, "pattern = \"2x2\" needs four kernels", "give kernel = [k0, k1, k2, k3]; the pixel at (x, y) uses"),
    ("pattern_without_four_thresholds", 7, 13, "pattern = \"2x2\" needs four thresholds", "give threshold = [{ … }, { … }, { … }, { … }]"),
    ("pixel_polarity_that_steps", 3, 12, "polarity = \"pixel\" needs the pixel's value at the last event, which a memory that", "use polarity = \"filtered\", or memory = \"raw-snap\" or"),
    ("pixel_step_that_runs_away", 6, 17, "a pixel memory that steps by filtered thresholds is unstable with this kernel: the", "use memory = \"filtered-step\" or \"raw-snap\", which are"),
    ("pixel_step_with_its_sign_turned", 6, 17, "a pixel memory that steps by filtered thresholds is unstable with this kernel: the difference grows up to 2.00 times", "use memory = \"filtered-step\""),
    ("pixel_step_without_memory_kernel", 4, 1, "memory = \"authors-pixel-step\" needs a memory-kernel", "give the kernel that the memory is seen through (often the"),
    ("ragged_kernel", 5, 10, "row 1 of the kernel has 2 weights, row 0 has 3; all rows must be of one length", "kernels are 1x1, 3x3, 5x5, …: rows of numbers, row 0 to the"),
    ("seventeen_channels", 68, 1, "`channel` has 17 entries", "give 1 to 16"),
    ("shared_filtered_memory", 3, 10, "shared = true is for memory = \"raw-snap\": a picture of the pixels is the same for all", "use memory = \"raw-snap\", or leave shared out"),
    ("shot_at_white_above_one", 5, 17, "`noise.shot-at-white` is 4", "give a number from 0 to 1"),
    ("threshold_is_a_number", 6, 13, "`threshold` takes { on = number, off = number, sigma = number", "docs/reference.md lists every key of a sensor file"),
    ("thresholds_without_pattern", 6, 13, "several thresholds in one channel", "add pattern = \"2x2\" for four thresholds, or give one"),
    ("two_responses", 1, 28, "only one of `linear`, `log`, `lin-log` can be given", "leave the others out"),
    ("unknown_border", 3, 10, "unknown value `wrap`, expected `replicate` or `zero`", "docs/reference.md lists every key of a sensor file"),
    ("unknown_channel_key", 6, 1, "unknown key `weight`, expected one of `name`, `kernel`, `mesh`, `threshold`, `pattern`,", "docs/reference.md lists every key of a sensor file"),
    ("unknown_kernel", 5, 10, "kernel \"mexican-hat\" is neither built in nor a file that can be read (No such file or", "give a file beside the sensor file, rows of numbers, or one"),
    ("unknown_key", 3, 1, "unknown key `colour`, expected one of `name`, `source`, `response`, `memory`, `shared`,", "docs/reference.md lists every key of a sensor file"),
    ("unknown_memory", 2, 10, "unknown value `snap`, expected one of `raw-snap`, `filtered-snap`, `filtered-step`,", "docs/reference.md lists every key of a sensor file"),
    ("unknown_noise_key", 5, 1, "unknown key `hum-hz`, expected one of `leak-hz`, `leak-spread`, `shot-hz`,", "did you mean `hot-hz`?"),
    ("unknown_pattern", 6, 11, "unknown value `3x3`, expected `2x2`", "docs/reference.md lists every key of a sensor file"),
    ("unknown_polarity", 3, 12, "unknown value `on`, expected `filtered` or `pixel`", "docs/reference.md lists every key of a sensor file"),
    ("unknown_refractory_rule", 3, 34, "unknown value `rest`, expected `dead-time` or `authors`", "docs/reference.md lists every key of a sensor file"),
    ("unknown_response", 1, 12, "unknown value `cubic`, expected \"identity\", { linear = 255 }, { log = { white = 255,", "docs/reference.md lists every key of a sensor file"),
    ("unknown_response_curve", 1, 14, "unknown key `gamma`, expected one of `linear`, `log`, `lin-log`", "docs/reference.md lists every key of a sensor file"),
    ("unknown_threshold_key", 6, 36, "unknown key `sd`, expected one of `on`, `off`, `sigma`", "docs/reference.md lists every key of a sensor file"),
    ("zero_gain", 6, 8, "`gain` is 0", "give a number other than 0: scales the weights; -1 exchanges ON and OFF"),
    ("zero_threshold", 6, 20, "`threshold.on` is 0", "give a number above 0: for ON events"),
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad/sensor")
}

#[test]
fn each_file_gets_its_message() {
    for &(file, line, column, message, advice) in MESSAGES {
        let name = format!("{file}.toml");
        let text = fs::read_to_string(folder().join(&name)).unwrap();
        let read = |name: &str| fs::read(folder().join(name));
        let error = Description::parse(&name, &text, &read).expect_err(&name);
        let place = format!("{name}:{line}:{column}: ");
        let said = error.to_string();
        assert!(
            said.starts_with(&(place.clone() + message)),
            "{said}\nexpected {place}{message}"
        );
        let advised = error.faults[0].fault.help.as_deref().unwrap_or("");
        assert!(
            advised.starts_with(advice),
            "{name}: {advised}\nexpected {advice}"
        );
    }
}

#[test]
fn each_file_is_listed() {
    let listed: BTreeSet<_> = MESSAGES.iter().map(|row| row.0.to_owned()).collect();
    let paths = folder().read_dir().unwrap().map(|e| e.unwrap().path());
    let there: BTreeSet<_> = paths
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    assert_eq!(listed, there);
    assert_eq!(listed.len(), MESSAGES.len());
}

/// Every prefix of a good file, and every byte of it made another, is read or refused.
#[test]
fn damage_is_never_a_panic() {
    let good =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("sensors/mosaic.toml"))
            .unwrap();
    let parse =
        |text: &str| Description::parse("damaged.toml", text, &|_| Ok(vec![0xff; 12])).is_ok();
    assert!(parse(&good));
    for at in 0..good.len() {
        parse(good.get(..at).unwrap_or(""));
        for other in ["0", "\"", "[", "nan", "é"] {
            if good.is_char_boundary(at) && good.is_char_boundary(at + 1) {
                parse(&format!("{}{other}{}", &good[..at], &good[at + 1..]));
            }
        }
    }
}
