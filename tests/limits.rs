//! What comes from outside has limits, and `docs/limits.md` says which.
//!
//! Every limit of `amacrine::limit::TABLE` is driven through the program: at the limit it works,
//! one beyond it is refused with exit code 2, in little time and little memory.

mod common;

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
    time::{Duration, Instant},
};

use amacrine::limit::{self, FILES, TABLE};

/// What the program may take of address space, in KiB: less than 300 MB are then in use, as the
/// program itself, its threads and its allocator take a part without using it.
const MEMORY: u64 = 480_000;

/// Whoever waits so long takes it for hung. Far above what anything takes, so that a busy machine is
/// no failure.
const TIME: Duration = Duration::from_mins(1);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs the program in a folder, with bounded memory and time.
fn amacrine(folder: &Path, arguments: &[&str]) -> Output {
    let shell = format!(
        "ulimit -v {MEMORY} && exec timeout {} \"$0\" \"$@\"",
        2 * TIME.as_secs()
    );
    let start = Instant::now();
    let output = Command::new("sh")
        .args(["-c", &shell, env!("CARGO_BIN_EXE_amacrine")])
        .args(arguments)
        .current_dir(folder)
        .env("RAYON_NUM_THREADS", "2")
        .env("MALLOC_ARENA_MAX", "1")
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    assert!(
        start.elapsed() < TIME,
        "{arguments:?} took {:?}",
        start.elapsed()
    );
    output
}

/// What is told, on one line.
fn told(output: &Output) -> String {
    common::line(&output.stderr)
}

fn refused(folder: &Path, arguments: &[&str], what: &str) {
    let output = amacrine(folder, arguments);
    let told = told(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
    assert!(told.contains(what), "{arguments:?}: no `{what}` in: {told}");
    assert!(
        told.len() < 200_000,
        "{arguments:?} tells {} bytes",
        told.len()
    );
}

/// One way to meet a limit: files, and what is asked for. Without an answer to "at the limit"
/// only what is beyond is tried.
struct Case {
    folder: tempfile::TempDir,
    arguments: Vec<String>,
    /// At the limit something else may be wrong.
    works: bool,
}

impl Case {
    fn new(arguments: &[&str]) -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
            arguments: arguments.iter().map(|a| (*a).to_owned()).collect(),
            works: true,
        }
    }

    fn file(self, name: &str, bytes: impl AsRef<[u8]>) -> Self {
        let path = self.folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
        self
    }

    /// At the limit something else is wrong.
    fn wrong_anyway(self) -> Self {
        Self {
            works: false,
            ..self
        }
    }

    /// A program, and `asm`.
    fn program(text: impl AsRef<[u8]>) -> Self {
        Self::new(&["asm", "p.scamp"]).file("p.scamp", text)
    }

    /// A chip that extends scamp5, and a program for it.
    fn chip(device: &str, primitives: &str, macros: &str) -> Self {
        let device = format!("name = \"c\"\ntitle = \"t\"\nextends = \"scamp5\"\n{device}");
        let case = Self::new(&["asm", "p.scamp", "--chip", "c"])
            .file("p.scamp", "nop();")
            .file("c/device.toml", device);
        let case = if primitives.is_empty() {
            case
        } else {
            case.file("c/primitives.toml", primitives)
        };
        case.file("c/macros.scamp", macros)
    }

    fn kernel(text: &str, to: &[&str]) -> Self {
        let text = format!("name = \"k\"\nsource = \"s\"\n{text}");
        let arguments = [["quantise", "k.toml", "--to"].as_slice(), to].concat();
        Self::new(&arguments).file("k.toml", text)
    }

    fn exec(arguments: &[&str]) -> Self {
        let arguments = [["exec", "p.scamp"].as_slice(), arguments].concat();
        Self::new(&arguments).file("p.scamp", "//! size = [4, 4]\nnop();")
    }

    fn run(&self) -> Output {
        let arguments: Vec<&str> = self.arguments.iter().map(String::as_str).collect();
        amacrine(self.folder.path(), &arguments)
    }
}

/// A `.npy` of zeros.
fn npy(descriptor: &str, shape: &[usize]) -> Vec<u8> {
    let shape: String = shape.iter().fold(String::new(), |mut text, n| {
        write!(text, "{n},").unwrap();
        text
    });
    let mut header =
        format!("{{'descr': '{descriptor}', 'fortran_order': False, 'shape': ({shape}), }}");
    while (header.len() + 11) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes
}

/// A `.npy` with its numbers.
fn zeros(descriptor: &str, shape: &[usize], bytes: usize) -> Vec<u8> {
    let mut file = npy(descriptor, shape);
    file.resize(file.len() + bytes * shape.iter().product::<usize>(), 0);
    file
}

fn row(form: &str) -> String {
    format!(
        "[[primitive]]\nname = \"nop\"\nforms = [{form}]\nequation = \"e\"\nwords = 1\nclock = \"analog\"\nsource = \"s\"\nevidence = \"guess\"\n"
    )
}

const SENSOR: &str = "response = \"identity\"\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"k.toml\"\nthreshold = { on = 1, off = 1 }\n";

/// A case at a limit, or one beyond it; `None` where the limit itself takes long.
#[expect(clippy::too_many_lines, reason = "one arm a limit")]
fn case(name: &str, value: usize, beyond: bool) -> Option<Case> {
    let n = value.saturating_add(usize::from(beyond));
    Some(match name {
        "TEXT_BYTES" => Case::program("\n".repeat(n)),
        "LINE_BYTES" => Case::program(format!("//{}\nnop();", "x".repeat(n - 2))),
        "NUMBERS_BYTES" => {
            let case = Case::exec(&["--set", "A=a.npy"]).file("a.npy", b"\x93NUMPY");
            let file = fs::File::options()
                .write(true)
                .open(case.folder.path().join("a.npy"));
            file.unwrap().set_len(n as u64).unwrap();
            case.wrong_anyway()
        }
        "FAULTS" => {
            let lines = (0..n).fold(String::new(), |mut text, i| {
                writeln!(text, "none{i}();").unwrap();
                text
            });
            Case::program(lines).wrong_anyway()
        }
        "NESTING" => Case::program(format!("{}nop();{}", "repeat 1 {".repeat(n), "}".repeat(n))),
        "VENDOR_TOKENS" => Case::new(&["asm", "p.cpp"])
            .file("p.cpp", ";\n".repeat(n))
            .wrong_anyway(),
        "VENDOR_WORK" => {
            // A turn is two statements, and some values that are looked at.
            let turns = if beyond { n } else { n / 4 };
            let text = format!("int main() {{ for (int i = 0; i < {turns}; i++) ; nop(); }}");
            Case::new(&["asm", "p.cpp"]).file("p.cpp", text)
        }
        "VENDOR_VALUES" => {
            let text = format!("int a[{n}]; int main() {{ nop(); }}");
            Case::new(&["asm", "p.cpp"]).file("p.cpp", text)
        }
        "CHAIN" => {
            // The call is one.
            let sum = "+0\n".repeat(n - 1);
            Case::new(&["asm", "p.cpp"]).file("p.cpp", format!("scamp5_in(A, 1 {sum});"))
        }
        "KERNEL_SIDE" => {
            // The next odd side.
            let side = value + 2 * usize::from(beyond);
            Case::new(&[
                "run",
                "--scene",
                "pattern:bar?width=4&height=4&frames=2",
                "--sensor",
                "s.toml",
            ])
            .file("s.toml", SENSOR)
            .file("k.toml", format!("centre-surround = {side}"))
        }
        "KERNELS" => Case::new(&["quantise", "k.npy", "--to", "ternary"])
            .file("k.npy", zeros("<f8", &[n, 1, 1], 8))
            .wrong_anyway(),
        "LEAST_WEIGHT" => {
            let weight = if beyond { "9.9e-31" } else { "1e-30" };
            Case::kernel(
                &format!("weights = [[{weight}]]"),
                &["ternary,int-5,csd-2,po2-3"],
            )
        }
        "MOST_WEIGHT" => {
            let weight = if beyond { "1.1e30" } else { "1e30" };
            Case::kernel(
                &format!("weights = [[{weight}]]"),
                &["ternary,int-5,csd-2,po2-3"],
            )
        }
        "QUANTISER_STEPS" if beyond => Case::kernel("centre-surround = 29", &["int-12"]),
        "QUANTISER_TABLE" if beyond => {
            Case::kernel("centre-surround = 33", &["po2-8", "--sum", "kept"])
        }
        "EXPANDED_STEPS" => Case::program("nop();\n".repeat(n)).wrong_anyway(),
        "STATEMENT_WORDS" => {
            let macros = "/// many\nmacro many(n: int[0..1000000]) { repeat n { nop(); } }";
            Case::chip("", "", macros)
                .file("p.scamp", format!("many({n});"))
                .wrong_anyway()
        }
        "FRAME_STEPS" => Case::program(format!("repeat {n} {{ }}")),
        "MACROS" => {
            let macros = (0..n).fold(String::new(), |mut text, i| {
                writeln!(text, "/// m\nmacro m{i}() {{ nop(); }}").unwrap();
                text
            });
            Case::chip("", "", &macros)
        }
        "MACRO_DEPTH" => {
            let mut macros = "/// m\nmacro m1() { nop(); }\n".to_owned();
            for i in 2..=n {
                writeln!(macros, "/// m\nmacro m{i}() {{ m{}(); }}", i - 1).unwrap();
            }
            Case::chip("", "", &macros)
        }
        "MACRO_STATEMENTS" => {
            let body = "nop();\n".repeat(n);
            Case::chip("", "", &format!("/// m\nmacro m() {{ {body} }}"))
        }
        "ARGUMENTS" => {
            let form = row(&format!("\"nop(x: bit * 0..{n})\""));
            Case::chip("", &form, "")
        }
        "FORMS" => Case::chip("", &row(&"\"nop()\", ".repeat(n)), ""),
        "ALIASES" => {
            let own = n - 13;
            let aliases = (0..own).fold("[registers.aliases]\n".to_owned(), |mut text, i| {
                writeln!(text, "alias{i} = \"R5\"").unwrap();
                text
            });
            Case::chip(&aliases, "", "")
        }
        "ARRAY_SIDE" => Case::new(&[
            "run", "--scene", "s.npy", "--fps", "100", "--sensor", "s.toml",
        ])
        .file("s.npy", zeros("|u1", &[2, 1, n], 1))
        .file("k.toml", "weights = [[1]]")
        .file("s.toml", SENSOR),
        "FIGURE" => {
            let value = if beyond { "1.1e12" } else { "1e12" };
            Case::exec(&["--set", &format!("clock.rate={value}")])
        }
        "STORE_WORDS" => Case::exec(&["--set", &format!("store.words={n}")]),
        "STUDY_POINTS" if beyond => Case::new(&["sweep", "s.toml"]).file(
            "s.toml",
            format!(
                "scene = \"pattern:bar\"\nkernel = \"sobel-x\"\nthreshold = 1\nseed = {{ from = 1, to = {n} }}\n[[side]]\nside = \"reference\"\n"
            ),
        ),
        "RUNS" if beyond => Case::exec(&["--repeat", &n.to_string()]),
        "FRAMES" if beyond => Case::exec(&["--frames", &n.to_string()]),
        "THREADS" if beyond => Case::exec(&["--threads", &n.to_string()]),
        "QUEUE" => Case::new(&[
            "packets",
            "e.csv",
            "--size",
            "4x4",
            "--readout",
            "arbiter",
            "--with",
            &format!("fifo={n}"),
        ])
        .file("e.csv", "t,x,y,p\n1,0,0,1\n"),
        "QUANTISER_STEPS" | "QUANTISER_TABLE" | "STUDY_POINTS" | "RUNS" | "FRAMES" | "THREADS" => {
            return None;
        }
        _ => panic!("{name} is not tried"),
    })
}

#[test]
fn at_each_limit_it_works_and_one_beyond_is_refused() {
    for row in TABLE {
        let value = row.value as usize;
        let Some(beyond) = case(row.name, value, true) else {
            panic!("nothing is beyond {}", row.name)
        };
        let output = beyond.run();
        let what = told(&output);
        assert_eq!(output.status.code(), Some(2), "beyond {}: {what}", row.name);
        assert!(what.contains(row.beyond), "beyond {}: {what}", row.name);
        if let Some(at) = case(row.name, value, false) {
            let output = at.run();
            let what = told(&output);
            assert!(!what.contains(row.beyond), "at {}: {what}", row.name);
            if at.works {
                assert!(output.status.success(), "at {}: {what}", row.name);
            }
        }
    }
}

#[test]
fn the_page_holds_the_table() {
    let page = fs::read_to_string(root().join("docs/limits.md")).unwrap();
    for rows in [TABLE, FILES] {
        let mut table =
            "| limit | of | value | why there | beyond it |\n|---|---|---|---|---|\n".to_owned();
        for row in rows {
            let value = if row.value.fract() == 0.0 && row.value < 1e12 {
                format!("{}", row.value)
            } else {
                format!("{:e}", row.value)
            };
            let value = format!("{value} {}", row.unit);
            let (name, of, why, beyond) = (row.name, row.of, row.why, row.beyond);
            writeln!(
                table,
                "| `{name}` | {of} | {} | {why} | “{beyond} …” |",
                value.trim()
            )
            .unwrap();
        }
        assert!(page.contains(&table), "docs/limits.md should hold\n{table}");
    }
}

/// All texts come through `source`; `store` reads what it has written itself.
#[test]
fn nobody_else_reads_files_whole() {
    fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in folder.read_dir().unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, files);
            } else {
                files.push(path);
            }
        }
    }
    let mut files = Vec::new();
    walk(&root().join("src"), &mut files);
    assert!(files.len() > 100);
    for path in files {
        let text = fs::read_to_string(&path).unwrap_or_default();
        let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
        let shown = path.strip_prefix(root()).unwrap().display().to_string();
        // What the system says of itself is short.
        let exempt = [
            "src/source.rs",
            "src/study/sweep/results/store.rs",
            "src/memory.rs",
            "src/cli/output/signals.rs",
        ];
        if exempt.contains(&shown.as_str()) {
            continue;
        }
        for word in ["fs::read(", "read_to_string(", "read_line("] {
            assert!(
                !code.contains(word),
                "{shown} reads by {word}…), not through source"
            );
        }
    }
}

#[test]
fn kernels_whose_side_overflows_are_refused() {
    let folder = root().join("tests/bad/limit");
    for name in ["huge_kernel.toml", "overflowing_side.toml"] {
        let every: [&[&str]; 5] = [
            &["quantise", name, "--to", "ternary"],
            &["compile", name, "--filter-only"],
            &["mesh", "fit", name],
            &["waterfall", name, "--threshold", "128"],
            &[
                "feasibility",
                "--kernel",
                name,
                "--threshold",
                "128",
                "-o",
                "/dev/null",
            ],
        ];
        for arguments in every {
            refused(&folder, arguments, "a side of a kernel is at most 127");
        }
    }
}

#[test]
fn repeats_inside_each_other_are_refused() {
    let folder = root().join("tests/bad/limit");
    for verb in ["asm", "disasm", "exec"] {
        refused(
            &folder,
            &[verb, "nested_repeat.scamp"],
            "levels inside each other",
        );
    }
    // Shallow enough to be read, and still without end.
    for depth in [25, 28, 32] {
        let text = format!("{}nop();{}", "repeat 2 {".repeat(depth), "}".repeat(depth));
        let case = Case::new(&[]).file("p.scamp", text);
        for verb in ["asm", "disasm", "exec"] {
            refused(
                case.folder.path(),
                &[verb, "p.scamp"],
                "runs more than 16777216 steps",
            );
        }
    }
    let one = Case::program("repeat 4294967295 { repeat 4294967295 { add(A, B, C); } }");
    refused(one.folder.path(), &["exec", "p.scamp"], "runs more than");
}

#[test]
fn a_chip_cannot_ask_for_billions_of_arguments() {
    let whole = fs::read_to_string(root().join("isa/scamp5/primitives.toml")).unwrap();
    let was = "bus2(out y: target, out z: target, x: source * 0..2)";
    assert!(whole.contains(was));
    for wrong in [
        "x: source * 2147483648..2",
        "x: source * 0..2147483648",
        "x: source * 2..1",
        "x: source * 0.5..1.5",
        "x: source * 1..2, w: source",
    ] {
        let form = format!("bus2(out y: target, out z: target, {wrong})");
        let case = Case::chip("", &whole.replace(was, &form), "");
        refused(
            case.folder.path(),
            &["asm", "p.scamp", "--chip", "c"],
            "arguments",
        );
    }
    let deep = format!("nop({}", "{".repeat(100_000));
    let case = Case::chip(
        "",
        &row(&format!("'''{}'''", deep[..60_000].to_owned())),
        "",
    );
    refused(
        case.folder.path(),
        &["asm", "p.scamp", "--chip", "c"],
        "levels inside each other",
    );
}

/// Calls and what stands inside each other multiply, on one stack.
#[test]
fn vendor_code_goes_only_so_deep() {
    let call = "if (x == 0) return 0; int y = 0;";
    let (loops, ifs) = (
        "for (int i = 0; i < 1; i++) ".repeat(58),
        "if (x) ".repeat(100),
    );
    for deep in [
        format!("{call} {loops} y = f(x - 1); return y;"),
        format!("{call} {ifs} y = {}f(x - 1); return y;", "!".repeat(20)),
        format!(
            "{call} y = {}f(x - 1){}; return y;",
            "-(1+".repeat(40),
            ")".repeat(40)
        ),
    ] {
        let text = format!("int f(int x) {{ {deep} }}\nint main() {{ scamp5_in(A, f(60)); }}");
        let case = Case::new(&[]).file("p.cpp", text);
        refused(
            case.folder.path(),
            &["asm", "p.cpp"],
            "more than 1152 nested statements and expressions",
        );
    }
    // One limit is told once, without what follows from it.
    for text in [
        format!(
            "int main() {{ {} nop(); }}",
            "for (int i = 0; i < 1; i++) ".repeat(200)
        ),
        format!(
            "int main() {{ int x = 1; {} nop(); }}",
            "if (x) ; else ".repeat(2000)
        ),
    ] {
        let case = Case::new(&[]).file("p.cpp", text);
        let output = amacrine(case.folder.path(), &["asm", "p.cpp"]);
        assert_eq!(told(&output).matches('×').count(), 1, "{}", told(&output));
    }
}

/// Values that are put into values are counted where they lie.
#[test]
fn values_in_values_of_vendor_code_are_counted() {
    let nested = |of: &dyn Fn(usize) -> String| (1..40).map(of).collect::<String>();
    let classes = nested(&|i| format!("struct S{i} {{ S{} a; S{0} b; }};\n", i - 1));
    let pairs = nested(&|i| format!("typedef std::pair<T{}, T{0}> T{i};\n", i - 1));
    let values = "1048576 values in one variable";
    for (before, inside, what) in [
        (
            "std::vector<std::vector<uint8_t>> all;\n",
            "for (int i = 0; i < 100; i++) all.push_back(std::vector<uint8_t>(256 * 256));",
            values,
        ),
        (
            "std::vector<std::vector<int>> all(100);\n",
            "for (int i = 0; i < 20; i++) all[i] = std::vector<int>(1000000);",
            values,
        ),
        (
            "",
            "std::map<int, std::vector<int>> m; std::vector<int> v(1000000); for (int i = 0; i < 300; i++) m[i] = v;",
            values,
        ),
        (
            &format!("struct S0 {{ int a; }};\n{classes}"),
            "S39 s; scamp5_in(A, 1);",
            values,
        ),
        (
            &format!("typedef int T0;\n{pairs}"),
            "T39 s; scamp5_in(A, 1);",
            "with a name of more than 4096 characters",
        ),
    ] {
        let text = format!("{before}int main() {{\n{inside}\nnop(); }}");
        let case = Case::new(&[]).file("p.cpp", text);
        refused(case.folder.path(), &["asm", "p.cpp"], what);
    }
}

#[test]
fn macros_that_double_each_other_are_refused() {
    for inner in ["nop();", ""] {
        let mut macros = format!("/// m\nmacro m0() {{ {inner} }}\n");
        for i in 1..30 {
            let before = i - 1;
            writeln!(
                macros,
                "/// m\nmacro m{i}() {{ m{before}(); m{before}(); }}"
            )
            .unwrap();
        }
        let case = Case::chip("", "", &macros).file("p.scamp", "m29();");
        let arguments = ["asm", "p.scamp", "--chip", "c"];
        refused(case.folder.path(), &arguments, "than");
    }
    // A long chain, and a long circle.
    for last in ["nop", "m4999"] {
        let mut macros = format!("/// m\nmacro m0() {{ {last}(); }}\n");
        for i in 1..1000 {
            writeln!(macros, "/// m\nmacro m{i}() {{ m{}(); }}", i - 1).unwrap();
        }
        let macros = macros.replace("m4999", "m999");
        let case = Case::chip("", "", &macros);
        refused(case.folder.path(), &["asm", "p.scamp", "--chip", "c"], "m");
    }
}

#[test]
fn what_never_ends_is_read_no_further() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let zero = "/dev/zero";
    let scene = "pattern:bar?width=4&height=4&frames=2";
    let every: [&[&str]; 9] = [
        &["run", "--scene", scene, "--sensor", zero],
        &["asm", zero],
        &["exec", zero],
        &["disasm", zero],
        &["quantise", zero, "--to", "ternary"],
        &["compile", zero],
        &["mesh", "fit", zero],
        &["sweep", zero],
        &[
            "feasibility",
            "--kernel",
            zero,
            "--threshold",
            "128",
            "-o",
            "x.html",
        ],
    ];
    for arguments in every {
        refused(here, arguments, "a text file holds at most 4194304 bytes");
    }
    // A pipe is read like a file.
    let shell = |text: &str| {
        let output = Command::new("sh")
            .args(["-c", text, env!("CARGO_BIN_EXE_amacrine")])
            .current_dir(here)
            .output()
            .unwrap();
        (output.status.code(), told(&output))
    };
    let (code, what) = shell("yes 'nop();' | \"$0\" asm /dev/stdin");
    assert!(code == Some(2) && what.contains("holds at most"), "{what}");
    let (code, what) = shell("echo 'nop();' | \"$0\" asm /dev/stdin");
    assert_eq!(code, Some(0), "{what}");
    let (code, what) = shell("mkfifo p.scamp && (echo 'nop();' > p.scamp & \"$0\" asm p.scamp)");
    assert_eq!(code, Some(0), "{what}");
    refused(here, &["asm", "."], "it is a directory");
}

#[test]
fn brackets_without_end_are_refused() {
    let deep = |open: &str| open.repeat(60_000);
    let programs = [
        format!("nop({}", deep("(")),
        format!("const a = {};", deep("-")),
        deep("repeat 1 {"),
        deep("{"),
        format!("//! a = {}", deep("[")),
        format!("const a = {}1;", deep("1 + ")),
        deep("frame {"),
    ];
    for text in programs {
        // No line is too long.
        let text = if text.starts_with("//!") {
            text
        } else {
            text.replace(['{', '+'], "$0\n").replace("$0", "{")
        };
        let case = Case::program(text);
        refused(case.folder.path(), &["asm", "p.scamp"], "");
    }
    for text in [
        format!("weights = {}", deep("[")),
        format!("weights = {}", deep("{a=")),
        format!("a{} = 1", deep(".a")),
    ] {
        let case = Case::new(&[]).file("k.toml", &text[..60_000]);
        refused(
            case.folder.path(),
            &["quantise", "k.toml", "--to", "ternary"],
            "k.toml",
        );
        refused(case.folder.path(), &["sweep", "k.toml"], "");
        refused(
            case.folder.path(),
            &["run", "--scene", "pattern:bar", "--sensor", "k.toml"],
            "",
        );
    }
}

#[test]
fn arrays_that_lie_are_refused() {
    for shape in [
        &[1 << 20, 1 << 20][..],
        &[1 << 40, 1 << 40],
        &[3, 1 << 40, 1 << 20],
        &[3, 0, 0],
    ] {
        let case = Case::new(&[]).file("k.npy", npy("<f8", shape));
        refused(
            case.folder.path(),
            &["quantise", "k.npy", "--to", "ternary"],
            "k.npy",
        );
        let case = case.file("p.scamp", "nop();");
        refused(
            case.folder.path(),
            &["exec", "p.scamp", "--set", "A=k.npy"],
            "k.npy",
        );
    }
    let mut deep = b"\x93NUMPY\x01\x00".to_vec();
    deep.extend(60_000_u16.to_le_bytes());
    deep.extend(vec![b'('; 60_000]);
    deep.push(b'\n');
    let case = Case::new(&[]).file("k.npy", deep).file("p.scamp", "nop();");
    refused(
        case.folder.path(),
        &["quantise", "k.npy", "--to", "ternary"],
        "expected {'descr': …",
    );
    refused(
        case.folder.path(),
        &["exec", "p.scamp", "--set", "A=k.npy"],
        "expected {'descr': …",
    );
}

/// Each verb that takes a kernel says what is wrong with one that floats cannot compute with.
#[test]
fn kernels_at_the_ends_of_floats_are_refused_truly() {
    for (weights, what) in [
        ("[[5e-324]]", "is too small"),
        ("[[1e-310, -1e-310, 0]]", "is too small"),
        ("[[1e-200]]", "is too small"),
        ("[[1e308, 1e308, 1e308]]", "beyond the largest float"),
        ("[[1e200, -1e200, 1]]", "is too large"),
        ("[[nan]]", "weights must be finite"),
        ("[[inf, 1, 1]]", "weights must be finite"),
        ("[[-inf, 1, 1]]", "weights must be finite"),
    ] {
        let case = Case::new(&[]).file("k.toml", format!("weights = {weights}"));
        let every: [&[&str]; 8] = [
            &["quantise", "k.toml", "--to", "ternary"],
            &["quantise", "k.toml", "--to", "q3.4"],
            &["compile", "k.toml", "--filter-only"],
            &["compile", "k.toml", "--to", "int-5", "--filter-only"],
            &["mesh", "fit", "k.toml"],
            &["mesh", "show", "--kernel", "k.toml", "-o", "x.png"],
            &[
                "waterfall",
                "k.toml",
                "--to",
                "ternary",
                "--threshold",
                "128",
            ],
            &[
                "feasibility",
                "--kernel",
                "k.toml",
                "--threshold",
                "128",
                "-o",
                "x.html",
            ],
        ];
        for arguments in every {
            refused(case.folder.path(), arguments, what);
        }
    }
    for (weights, what) in [
        ("[[5e-324]]", "is too small"),
        ("[[1e308, 1e308, 1e308]]", "beyond the largest float"),
        ("[[nan]]", "weights must be finite"),
    ] {
        let sensor = SENSOR.replace("\"k.toml\"", weights);
        let case = Case::new(&[]).file("s.toml", sensor);
        let arguments = [
            "run",
            "--scene",
            "pattern:bar?width=4&height=4&frames=2",
            "--sensor",
            "s.toml",
        ];
        refused(case.folder.path(), &arguments, what);
    }
    // All zero is another thing.
    let case = Case::new(&[]).file("k.toml", "weights = [[0]]");
    refused(
        case.folder.path(),
        &["quantise", "k.toml", "--to", "ternary"],
        "all weights are 0",
    );
    // A weight that is nothing beside the others is no reason to refuse them.
    let case = Case::new(&[]).file("k.toml", "weights = [[1, 5e-324, -0.5]]");
    for to in [
        "binary",
        "ternary",
        "ternary-0.7",
        "ternary-split",
        "po2-3",
        "int-5",
        "csd-4",
        "q3.4",
    ] {
        let output = amacrine(
            case.folder.path(),
            &["quantise", "k.toml", "--to", to, "--sum", "free"],
        );
        let table = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{to}: {}", told(&output));
        assert!(
            !table.contains("NaN") && !table.contains("inf"),
            "{to}: {table}"
        );
    }
}

#[test]
fn a_sum_far_away_is_found_at_once() {
    let case = Case::new(&[]).file(
        "k.toml",
        "weights = [[8000000, -8000000, 0], [1, 2, 3], [0, 0, 1]]",
    );
    let zero = ["quantise", "k.toml", "--to", "q24.24", "--sum", "zero"];
    let output = amacrine(case.folder.path(), &zero);
    assert!(output.status.success(), "{}", told(&output));
    let case = Case::new(&[]).file("k.toml", "weights = [[1e29, 0, 0]]");
    let kept = ["quantise", "k.toml", "--to", "q24.24", "--sum", "kept"];
    refused(case.folder.path(), &kept, "no choice of levels");
}

/// What is wrong everywhere is told, but not without end.
#[test]
fn a_text_that_is_wrong_everywhere_is_told_in_part() {
    let texts = [
        "§\n".repeat(500_000),
        "x;\n".repeat(1_000_000),
        "none();\n".repeat(300_000),
        "const a = 1;\n".repeat(200_000),
        "where(A);add(A,A,B);\n".repeat(100_000),
    ];
    for text in texts {
        let case = Case::program(text);
        refused(case.folder.path(), &["asm", "p.scamp"], "more");
    }
    // A long line is not shown, but named.
    let case = Case::program(format!("nop();\n{}none();", "nop();".repeat(9000)));
    let output = amacrine(case.folder.path(), &["asm", "p.scamp"]);
    let what = told(&output);
    assert!(
        what.contains("p.scamp:2:54001: unknown statement `none`"),
        "{what}"
    );
    assert!(what.len() < 1000, "{what}");
}

/// Sixty thousand statements take a moment, not minutes.
#[test]
fn assembling_takes_time_in_proportion() {
    let case = Case::program(format!("{}\n", "mov(A, B); // one\n".repeat(60_000)));
    // More than the chip stores, and all of it was looked at.
    refused(
        case.folder.path(),
        &["asm", "p.scamp"],
        "120000 instruction words",
    );
}

#[test]
fn limits_are_one_with_the_code() {
    assert_eq!(limit::KERNEL_SIDE % 2, 1);
    const { assert!(limit::STATEMENT_WORDS < limit::EXPANDED_STEPS) };
}

/// Pieces of which texts are made that look like something: names, numbers at the ends of what
/// a float holds, brackets.
const PIECES: &[&str] = &[
    "weights",
    "centre-surround",
    "gaussians",
    "sigma",
    "gain",
    "kernel",
    "channel",
    "threshold",
    "response",
    "memory",
    "\"identity\"",
    "\"filtered-step\"",
    "noise",
    "mesh",
    "lambda",
    "side",
    "sensor",
    "\"reference\"",
    "seed",
    "from",
    "to",
    "steps",
    "sample",
    "points",
    "readout",
    "settings",
    "fifo",
    "value",
    "repeat",
    "const",
    "frame",
    "init",
    "macro",
    "source",
    "dreg",
    "add",
    "mov",
    "A",
    "B",
    "nop",
    "out",
    "{",
    "}",
    "[",
    "]",
    "[[",
    "]]",
    "(",
    ")",
    ",",
    ";",
    "=",
    ".",
    "..",
    "*",
    "-",
    "/",
    "\n",
    " ",
    "0",
    "1",
    "-1",
    "3",
    "1e308",
    "5e-324",
    "nan",
    "inf",
    "4294967297",
    "18446744073709551616",
    "1e999",
    "//!",
    "//=",
    "\"",
    "'''",
    "#",
    "§",
    "\u{feff}",
];

/// Every reader of texts, with what it says.
fn read_all(text: &str) {
    use amacrine::{
        event::readout::settings,
        isa::{Device, macros, signature::Signature},
        kernel::Kernel,
        program::{Overrides, Program},
        reference::Description,
        study::sweep::Study,
    };
    let none = |name: &str| Err(std::io::Error::other(name.to_owned()));
    let _ = Description::parse("s.toml", text, &none).map_err(|e| e.to_string());
    let _ = Kernel::from_toml("k.toml", text).map_err(|e| e.to_string());
    let _ = Kernel::from_npy(text.as_bytes()).map_err(|e| e.to_string());
    let _ = Study::parse("study.toml", text).map_err(|e| e.to_string());
    let _ = settings::Description::parse("r.toml", text).map(|d| d.readout().is_ok());
    let _ = macros::parse(text);
    let _ = Signature::parse(text).map(|form| form.to_string());
    let program = Program::read("p.scamp", text);
    let _ = program
        .expand(&Device::scamp5(), &Overrides::default())
        .map_err(|e| e.to_string());
}

proptest::proptest! {
    #![proptest_config(proptest::test_runner::Config { failure_persistence: None, ..proptest::test_runner::Config::with_cases(400) })]

    /// Whatever text comes: an answer, soon, without a panic.
    #[test]
    fn any_text_is_answered(
        pieces in proptest::collection::vec(proptest::sample::select(PIECES), 0..60),
        times in 1_usize..40,
        junk in ".{0,40}",
    ) {
        let text = format!("{}{junk}", pieces.concat().repeat(times));
        let start = Instant::now();
        read_all(&text);
        assert!(start.elapsed() < TIME, "{text}");
    }
}
