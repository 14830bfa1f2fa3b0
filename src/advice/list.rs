//! The list of options that messages name.

use super::Advised;

/// All of them, by name.
pub const OPTIONS: &[Advised] = &[
    Advised::word("chip")
        .said(&[("programs and --chip then", "programs and chip then")])
        .key("chip"),
    Advised::number("chips"),
    Advised::phrases(
        "clip",
        &[(
            "--clip on or --domain silicon",
            "clip=True or domain=\"silicon\"",
        )],
    ),
    Advised::word("compression"),
    Advised::phrases("const", &[("--const ", "constants ")]),
    Advised::typed(
        "cost",
        "the page of a study's keys names an option of `report`",
    ),
    Advised::phrases("counts", &[NO_LIST]),
    Advised::word("crop").key("crop"),
    Advised::word("domain").key("domain"),
    Advised::number("effort"),
    Advised::typed("events", "of `run`, beside `--counts`"),
    Advised::number("exposure"),
    Advised::typed("features", "of `cargo`"),
    Advised::typed(
        "flip",
        "`convert` alone tells in which way a file counts rows",
    ),
    Advised::phrases(
        "format",
        &[
            ("`amacrine convert` also takes --format", "or give format"),
            (
                "or tell `amacrine convert` what it writes: --format NAME",
                "or give format",
            ),
        ],
    ),
    Advised::number("fps").key("fps"),
    Advised::phrases(
        "from",
        &[
            (
                "or tell `amacrine convert` what it reads: --from NAME",
                "or give format",
            ),
            (
                "say which with `amacrine convert --from NAME`",
                "say which: format=NAME",
            ),
            ("(or `--from`)", "(or format)"),
        ],
    ),
    Advised::typed("image", "a program of `exec` may run without a scene"),
    Advised::number("jobs"),
    Advised::typed(
        "json",
        "a report names it, for which Python has words of its own",
    ),
    Advised::typed("keep", "filters of `compile` alone keep registers"),
    Advised::phrases(
        "kernel",
        &[
            (
                "an array of kernels goes after --kernel, beside it",
                "of an array of kernels Sensor(kernels, thresholds) makes one",
            ),
            ("--kernel ", "kernels "),
        ],
    )
    .key("kernel"),
    Advised::phrases(
        "kind",
        &[(
            "or one kind with `convert --kind N`, or one file a kind with `convert --each-kind`",
            "or one kind: events[events['channel'] == 0][['t', 'x', 'y', 'p']]",
        )],
    ),
    Advised::number("link-energy"),
    Advised::number("max-events").said(&[(
        "the limit (--max-events, and --max-memory where there is no room for more); \
         `amacrine run` also has --counts and --voxels instead of --events, and --when-full drop",
        "the limit (max_events), or take counts, or voxels without bins, which need no list",
    )]),
    Advised::phrases(
        "max-memory",
        &[
            (
                "allow more with --max-memory SIZE, raise the thresholds",
                "raise the thresholds",
            ),
            (
                "raise --max-memory, or lower --jobs: points share it",
                "lower jobs: points share the memory",
            ),
            ("--max-memory allows", "the limit is"),
        ],
    ),
    Advised::number("max-seconds-per-point"),
    Advised::word("memory").key("memory"),
    Advised::word("objective").said(&[("; --objective words compiles it as it is", "")]),
    Advised::number("output"),
    Advised::word("range")
        .said(&[("leave --range out", "leave range out")])
        .key("range"),
    Advised::number("rate"),
    Advised::phrases(
        "readout",
        &[
            ("(--readout overlapped)", "(overlapped=True)"),
            ("(--readout sequential)", "(overlapped=False)"),
        ],
    ),
    Advised::word("resize").key("resize"),
    Advised::phrases("runs", &[("--runs N shares them", "runs=N shares them")]),
    Advised::number("sample"),
    Advised::number("scale").key("scale"),
    Advised::phrases(
        "scene",
        &[
            (
                "; a sensor beside a packet needs a scene (`--scene`) of the packet's size",
                "",
            ),
            (
                "compile it for this scene (--scene)",
                "compile it for as many events (events_per_frame)",
            ),
        ],
    )
    .key("scene"),
    Advised::number("seed").key("seed"),
    Advised::number("sensor"),
    Advised::phrases(
        "set",
        &[(
            "load them with `--set REGISTER=FILE.npy`",
            "give them to run as registers={\"REGISTER\": array}",
        )],
    ),
    Advised::phrases(
        "shard",
        &[
            ("--shard of a search", "shards of a search"),
            (
                "leave --shard out, or sweep the whole grid on several machines",
                "leave client out, or take the whole grid",
            ),
        ],
    ),
    Advised::number("sigma").said(&[(
        "(in the sensor file, or run --sigma)",
        "(in thresholds, or the sensor file)",
    )]),
    Advised::number("size"),
    Advised::word("slice")
        .said(&[
            (
                "(`convert --from-zero`), and cut what is longer (`--slice`)",
                "(events['t'] - events['t'].min()), and cut what is longer",
            ),
            (
                "(--slice, or `slice` in a study, in frames of the clip)",
                "(slice of load, and of a study, in frames of the clip)",
            ),
            (", or `slice` in a study", " of load, and of a study"),
            ("(--slice)", "(slice of load)"),
        ])
        .key("slice"),
    Advised::phrases(
        "space",
        &[(
            "; --space lists them",
            "; `amacrine sweep --space` lists them",
        )],
    ),
    Advised::number("stream").said(&[(
        "--stream N, in Python read(path, stream=N)",
        "read(path, stream=N)",
    )]),
    Advised::word("sum").key("sum"),
    Advised::typed("threads", "the page of limits"),
    Advised::phrases("threshold", &[("--threshold", "thresholds")]).key("threshold"),
    Advised::word("to").key("quantise"),
    Advised::word("transfer")
        .said(&[("--transfer undoes it", "transfer undoes it")])
        .key("transfer"),
    Advised::number("upsample")
        .said(&[("(`--upsample`, or `upsample` in a study)", "(upsample)")])
        .key("upsample"),
    Advised::phrases(
        "verify",
        &[
            ("--verify measures them", "verify=True measures them"),
            (
                "run `amacrine sweep` without --verify first",
                "sweep it first",
            ),
        ],
    ),
    Advised::typed("voxels", "of `run`, beside `--counts`"),
    Advised::typed("when-full", "of `run`, beside `--counts`"),
    Advised::phrases("with", &[]),
    Advised::number("within")
        .said(&[("--within, in a study `within`", "within")])
        .key("within"),
    Advised::word("without"),
];

/// What `run` has in place of a list that is full.
const NO_LIST: (&str, &str) = (
    "; `amacrine run` also has --counts and --voxels instead of --events, and --when-full drop",
    "; counts, and voxels without bins, need no list",
);
