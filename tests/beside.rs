//! Hosts that run beside the array: what they read decides what comes next, and where they would
//! decide nothing, all is as if the program had been laid out before.

mod common;

use std::{fs, path::Path};

use amacrine::{
    isa::Device,
    program::{Action, Answer, Beside, Host, Overrides, Program, Runnable, Step},
};
use common::{amacrine, good, json, line, refused};
use ndarray::{Array2, Array3};
use ndarray_npy::WriteNpyExt;
use serde_json::Value;

const VENDOR: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/vendor");

/// An array that answers what it was told to, frame by frame.
#[derive(Default)]
struct Told {
    frames: u32,
    answers: Vec<i64>,
    asked: Vec<String>,
    posts: Vec<String>,
}

impl Told {
    fn asks(&mut self, steps: &[Step], device: &Device) {
        for step in steps {
            match &step.action {
                Action::Word(word) => self.asked.push(word.text(device)),
                Action::Host(host) => self.asked.push(host.text(device)),
                Action::Repeat { times, body } => {
                    (0..*times).for_each(|_| self.asks(body, device));
                }
            }
        }
    }
}

impl Beside for Told {
    fn frame(&mut self) -> bool {
        self.asked.push("frame".to_owned());
        let goes_on = self.frames > 0;
        self.frames = self.frames.saturating_sub(1);
        goes_on
    }

    fn run(&mut self, steps: &[Step]) -> Option<Answer> {
        self.asks(steps, &Device::scamp5());
        let reads = |it: &&Step| {
            matches!(
                it.action,
                Action::Host(
                    Host::GlobalOr { .. } | Host::GlobalSum { .. } | Host::ScanEvents { .. }
                )
            )
        };
        let Some(_) = steps.last().filter(reads) else {
            return Some(Answer::default());
        };
        let value = if self.answers.is_empty() {
            0
        } else {
            self.answers.remove(0)
        };
        Some(Answer {
            value: Some(value),
            memory: Some(vec![value, value + 1]),
        })
    }

    fn micros(&self) -> f64 {
        10.0 * self.asked.iter().filter(|it| *it != "frame").count() as f64
    }

    fn post(&mut self, text: String) {
        self.posts.push(text);
    }
}

/// Runs C++ beside an array that answers so; what it was asked, and what was posted.
#[track_caller]
fn told(text: &str, frames: u32, answers: &[i64]) -> (Vec<String>, Vec<String>) {
    let mut array = Told {
        frames,
        answers: answers.to_vec(),
        ..Told::default()
    };
    let program = Program::read("p.cpp", text);
    program
        .run_beside(&Device::scamp5(), &Overrides::new(), &mut array)
        .unwrap_or_else(|faults| panic!("{faults:?}"));
    (array.asked, array.posts)
}

/// What a program posts that reads these numbers.
#[track_caller]
fn posts(inside: &str, frames: u32, answers: &[i64]) -> Vec<String> {
    let text =
        format!("int main() {{ int k = 0; while (1) {{ vs_frame_loop_control();\n{inside}\n}} }}");
    told(&text, frames, answers).1
}

/// Holds what a file posts in each of two frames to this; what `exec --host` says of it.
#[track_caller]
fn posts_each_frame(text: &str, want: [&str; 3]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("p.cpp"), text).unwrap();
    let scene = "pattern:disc?width=8&height=8&frames=1";
    let said = json(
        folder.path(),
        &["exec", "p.cpp", "--host", "--image", scene],
    );
    let posts = said["posts"].as_array().unwrap().iter();
    let posts: Vec<_> = posts.map(|it| it["text"].as_str().unwrap()).collect();
    assert_eq!(posts.len(), 6, "two frames");
    for frame in posts.chunks(3) {
        assert_eq!(frame, want);
    }
    said
}

#[test]
fn what_is_read_decides_what_comes_next() {
    let text = "int main() { while (1) { vs_frame_loop_control(); get_image(A, F);\n\
                if (scamp5_global_or(R5) > 0) { MOV(R6, R5); } else { CLR(R6); } } }";
    let (asked, _) = told(text, 2, &[1, 0]);
    let frames: Vec<&[String]> = asked.split(|it| it == "frame").collect();
    assert_eq!(frames.len(), 4, "{asked:?}");
    assert!(frames[1].last().unwrap().starts_with("MOV"), "{asked:?}");
    assert!(frames[2].last().unwrap().starts_with("CLR"), "{asked:?}");
    assert!(frames[3].is_empty());
}

#[test]
fn what_is_read_goes_into_memory() {
    let all = posts(
        "uint8_t a[3][2]; scamp5_scan_events(R5, a[1], 1);\n\
         uint8_t b[4]; scamp5_scan_events(R5, b + 2, 1); scamp5_scan_events(R5, &b[1], 1);\n\
         uint8_t *c = new uint8_t[2]; scamp5_scan_events(R5, c, 1);\n\
         std::vector<uint8_t> d(2); scamp5_scan_events(R5, d.data(), 1);\n\
         vs_post_text(\"%d %d, %d %d %d, %d %d, %d\", a[1][0], a[1][1], b[1], b[2], b[3], c[0], c[1], d[1]);",
        1,
        &[4, 7, 20, 9, 30],
    );
    assert_eq!(all, ["4 5, 20 21 8, 9 10, 31"]);
    // A cast to numbers as large writes what it says.
    let all = posts(
        "int8_t a[2]; scamp5_scan_events(R5, (uint8_t*)a, 1); vs_post_text(\"%d %d\", a[0], a[1]);",
        1,
        &[126 + 74],
    );
    assert_eq!(all, ["-56 -55"]);
}

/// What is drawn into stays, whatever is read between two shapes.
#[test]
fn drawing_goes_on_after_a_reading() {
    let text = "int main() { while (1) { vs_frame_loop_control(); scamp5_draw_begin(R5); scamp5_draw_pixel(1, 2);\n\
                if (scamp5_global_or(R6)) scamp5_draw_pixel(3, 4); scamp5_draw_end(); } }";
    let (asked, _) = told(text, 1, &[1]);
    let pixels = asked.iter().filter(|it| it.contains("draw_pixel"));
    assert_eq!(pixels.count(), 2, "{asked:?}");
    assert!(
        asked.iter().any(|it| it.contains("draw_begin(R5)")),
        "{asked:?}"
    );
    // One that was never begun, or has ended, has no register.
    let ended = text.replace(
        "vs_frame_loop_control();",
        "vs_frame_loop_control(); scamp5_draw_pixel(5, 6);",
    );
    let mut array = Told {
        frames: 1,
        ..Told::default()
    };
    let program = Program::read("p.cpp", &ended);
    let refused = program.run_beside(&Device::scamp5(), &Overrides::new(), &mut array);
    assert!(format!("{:?}", refused.unwrap_err()).contains("scamp5_draw_begin"));
}

#[test]
fn frames_may_differ() {
    let all = posts(
        "k = k * 2 + scamp5_global_sum_16(A); vs_post_text(\"%3d|%u|%.1f\", k, k, k / 2.0);",
        3,
        &[1, 0, 5],
    );
    assert_eq!(all, ["  1|1|0.5", "  2|2|1.0", "  9|9|4.5"]);
    // A state that goes on, frames inside of functions, and a loop that waits for something.
    let text = "void wait(int n) { for (int i = 0; i < n; i++) vs_frame_loop_control(); }\n\
                int main() { int seen = 0; while (1) { wait(2); get_image(A, F);\n\
                while (!scamp5_global_or(R5)) { vs_frame_loop_control(); seen++; }\n\
                printf(\"%d\", seen); } }";
    let (asked, said) = told(text, 7, &[0, 1, 0, 0, 1]);
    assert_eq!(said, ["1", "3"]);
    assert_eq!(asked.iter().filter(|it| *it == "frame").count(), 8);
}

/// A loop that some variable ends is no loop over the frames that could be laid out.
#[test]
fn a_loop_that_a_variable_ends() {
    let text = "int main() { bool running = true; int n = 0; while (running) { vs_frame_loop_control();\n\
                get_image(A, F); if (++n == 100) running = false; } printf(\"%d\", n); }";
    let program = Program::read("p.cpp", text);
    assert!(decides(&program));
    assert_eq!(told(text, 500, &[]).1, ["100"]);
    let (asked, said) = told(text, 30, &[]);
    assert_eq!(
        (asked.iter().filter(|it| *it == "frame").count(), said.len()),
        (31, 0)
    );
    // A number of any type is a constant.
    let steady = Program::read(
        "p.cpp",
        "int main() { while (4294967295u) { vs_frame_loop_control(); get_image(A, F); } }",
    );
    assert!(!decides(&steady));
}

/// A loop that changes variables of the host alone, and that only a `break` ends.
#[test]
fn a_loop_that_only_a_break_ends() {
    let frames = |before: &str, turns: &str| {
        format!(
            "{before} int main() {{ while (1) {{ vs_frame_loop_control(); {turns} scamp5_in(A, q); }} }}"
        )
    };
    for (before, turns) in [
        ("int q = 0;", "for (;;) { q++; if (q > 2) break; }"),
        ("int q = 0;", "while (true) { q++; if (q > 2) break; }"),
        ("int q = 0;", "while (1) { if (++q > 2) break; }"),
        ("int q = 0;", "do { q++; if (q > 2) { break; } } while (1);"),
        (
            "int q = 0; int f() { for (;;) { if (++q > 2) return q; } }",
            "f();",
        ),
        (
            "int q = 0;",
            "for (;;) { switch (q) { case 0: q++; continue; default: q++; } if (q > 2) break; }",
        ),
    ] {
        let text = frames(before, turns);
        let program = Program::read("p.cpp", &text);
        assert!(decides(&program), "{text}");
        let (asked, _) = told(&text, 2, &[]);
        let loads: Vec<&String> = asked.iter().filter(|it| it.contains("in(")).collect();
        assert!(
            loads[0].contains('3') && loads[1].contains('4'),
            "{text}: {asked:?}"
        );
    }
    // What a loop of this kind asks of the array is what the run decides.
    let text = frames(
        "int q = 0;",
        "for (;;) { neg(A, B); if (scamp5_global_or(R5)) break; }",
    );
    assert!(decides(&Program::read("p.cpp", &text)));
    let (asked, _) = told(&text, 1, &[0, 0, 1]);
    assert_eq!(
        asked
            .iter()
            .filter(|it| it.contains("sub") || it.contains("neg"))
            .count()
            % 3,
        0
    );
    // Made once, and known: nothing is left to decide.
    let (_, said) = told(
        "int main() { while (1) { vs_frame_loop_control(); for (;;) { static int q = 0; if (++q % 3 == 0) break; vs_post_text(\"%d\", q); } } }",
        2,
        &[],
    );
    assert_eq!(said, ["1", "2", "4", "5"]);
}

/// The text is that of the C library.
#[test]
fn posts_are_as_printf_writes_them() {
    for (format, values, all) in [
        (
            "[%g] [%.3g] [%9g] [%G]",
            "1234567.0, 1.0 / 3, 0.5, 1e-5",
            "[1.23457e+06] [0.333] [      0.5] [1E-05]",
        ),
        (
            "[%g] [%g] [%g] [%g]",
            "0.0, 100.0, 100.25, -3.0",
            "[0] [100] [100.25] [-3]",
        ),
        (
            "[%.1e] [%10.2e] [%e]",
            "0.0, 123456.0, -0.5",
            "[0.0e+00] [  1.23e+05] [-5.000000e-01]",
        ),
        (
            "[%-8g] [%+g] [%08.2f] [%#g]",
            "1e10, 2.5, -1.5, 1.0",
            "[1e+10   ] [+2.5] [-0001.50] [1.00000]",
        ),
        (
            "%hhu %hd %hhd %u %d",
            "300, 70000, 200, -1, 4294967295u",
            "44 4464 -56 4294967295 -1",
        ),
        (
            "[%*d] [%-*d] [%.*f] %% %d",
            "4, 7, -3, 8, 2, 1.0, 5",
            "[   7] [8  ] [1.00] % 5",
        ),
        (
            "[%.3d] [%5.3d] [%-6.2d] [%08.3d] [%+.2d] [%.0d]",
            "7, -7, 3, 7, 3, 0",
            "[007] [ -007] [03    ] [     007] [+03] []",
        ),
        (
            "[%.3x] [%#.4X] [%#.2o] [%.5ld] [%.*d] [%.3i]",
            "10, 255, 8, -42L, 4, 7, -7",
            "[00a] [0X00FF] [010] [-00042] [0007] [-007]",
        ),
        (
            "[%ld] [%llu] [%zu] [%hx] [%5s]",
            "5000000000L, 7, sizeof(int), -1, \"ab\"",
            "[5000000000] [7] [4] [ffff] [   ab]",
        ),
    ] {
        let inside = format!("vs_post_text(\"{format}\", {values});");
        assert_eq!(posts(&inside, 1, &[]), [all], "{inside}");
    }
}

/// What is posted is told whatever its types are, a scalar is a place to read into, and what the
/// light does and why the run ended is said.
#[test]
fn posts_places_and_ends() {
    let text = posts("vs_post_text(\"%d %s %g %g\", k, 3, 1e-7, 1e10);", 1, &[]);
    assert_eq!(text, ["0 ? 1e-07 1e+10"]);
    // Arrays of characters are texts; where it is not known whether something is posted, it is said.
    let text = posts(
        "char line[8]; sprintf(line, \"%d!\", 12); vs_post_text(\"%s %3s\", line, line + 2); vs_post_text(line);",
        1,
        &[],
    );
    assert_eq!(text, ["12!   !", "12!"]);
    // Texts are made of arrays of characters; of what is not known it is said that it is left out.
    let text = posts(
        "char line[8] = \"ab\"; std::string s = std::string(line) + std::string(\"/0\"); line[0] = 'x'; vs_post_text(s.c_str()); vs_post_text(\"%s %d\", s.c_str(), (int)(s < line));",
        1,
        &[],
    );
    assert_eq!(text, ["ab/0", "ab/0 1"]);
    let said = posts_each_frame(
        "int main() { char line[8] = \"ab\"; std::string s = line; while (1) { vs_frame_loop_control(); get_image(A, F); vs_post_text(\"1\"); vs_post_text(\"2\"); vs_post_text(s.c_str()); line[0] = vs_gpio_read(1); vs_post_text(line); } }",
        ["1", "2", "ab"],
    );
    let said = said["source_warnings"].to_string();
    assert!(
        said.contains("what is posted depends on the text in `line`: it is left out"),
        "{said}"
    );
    // Halves are rounded to even, as the C library does.
    let text = posts(
        "vs_post_text(\"%.1f %.1f %.0f %.0f %6.2f\", 0.25, 0.75, 2.5, 3.5, -1.005);",
        1,
        &[],
    );
    assert_eq!(text, ["0.2 0.8 2 4  -1.00"]);
    let folder = tempfile::tempdir().unwrap();
    let light = Array3::from_elem((5, 16, 16), 20u8);
    light
        .write_npy(fs::File::create(folder.path().join("clip.npy")).unwrap())
        .unwrap();
    let notes = |loops: &str, captures: &str| {
        let text = format!(
            "int main() {{ uint8_t one = 0; respix(C); for (int n = 0; n < {loops}; n++) {{ vs_frame_loop_control(); {captures}\n\
             scamp5_scan_areg(A, &one, 5, 6, 5, 6, 1, 1); if (one > 2) printf(\"%d\", one); }} }}"
        );
        fs::write(folder.path().join("p.cpp"), text).unwrap();
        let run = ["exec", "p.cpp", "--image", "clip.npy", "--host"];
        let said = json(folder.path(), &run);
        let one = said["posts"][0]["text"].as_str().unwrap();
        assert!(one.parse::<u8>().unwrap() > 2, "{said}");
        said["notes"].to_string()
    };
    let ends = notes("3", "get_image(A, B);");
    assert!(ends.contains("the program ended after 4 frames"), "{ends}");
    assert!(!ends.contains("adds up"), "{ends}");
    let adds = notes("9", "getpix(A, C);");
    assert!(adds.contains("light adds up"), "{adds}");
    assert!(!adds.contains("ended"), "{adds}");
}

fn decides(program: &Program) -> bool {
    let layout = program.layout(&Device::scamp5(), &Overrides::new());
    layout.unwrap().decides
}

/// Whether something is read out may hang on another readout: laid out it is left out, and said.
#[test]
fn what_is_read_out_may_hang_on_what_was_read() {
    let scans = [
        "if (scamp5_global_or(R6)) scamp5_scan_events(R5, b, 10);",
        "scamp5_global_or(R6) && scamp5_scan_events(R5, b, 10);",
        "int n = scamp5_global_or(R6); while (n) { scamp5_scan_events(R5, b, 10); n = 0; }",
    ];
    for scan in scans {
        let text = format!(
            "int main() {{ uint8_t b[20]; while (1) {{ vs_frame_loop_control(); scamp5_kernel_begin();\n\
             CLR(R6); SET(R5); MOV(R6, R5); scamp5_kernel_end();\n{scan} }} }}"
        );
        let program = Program::read("p.cpp", &text);
        let layout = program.layout(&Device::scamp5(), &Overrides::new());
        let Runnable { expansion, decides } = layout.unwrap();
        assert!(decides, "{scan}");
        let warned = format!("{:?}", program.warnings(&expansion.unwrap()).unwrap());
        assert!(
            warned.contains("read out") && warned.contains("left out"),
            "{warned}"
        );
        for (read, times) in [(1, 1), (0, 0)] {
            let asked = told(&text, 1, &[read, 5]).0;
            let scanned = asked
                .iter()
                .filter(|it| it.starts_with("scamp5_scan_events"));
            assert_eq!(scanned.count(), times, "{scan}");
        }
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("p.cpp"), &text).unwrap();
        let light = Array3::from_elem((2, 16, 16), 20u8);
        light
            .write_npy(fs::File::create(folder.path().join("clip.npy")).unwrap())
            .unwrap();
        let run = [
            "exec", "p.cpp", "--image", "clip.npy", "--domain", "q8.8", "--events", "e.csv",
        ];
        let said = json(folder.path(), &run);
        assert_eq!(said["events"], 20, "{scan} {said}");
        // What looks at the steps before the run goes without it, and says so.
        let looked = amacrine(folder.path(), &["asm", "p.cpp"]).output().unwrap();
        let warned = line(&looked.stderr);
        assert!(warned.contains("left out"), "{warned}");
    }
}

#[test]
fn a_turn_that_never_waits_is_a_frame() {
    let text =
        "int main() { while (1) { get_image(A, F); if (scamp5_global_or(R5)) MOV(R6, R5); } }";
    let (asked, _) = told(text, 3, &[1, 1, 0]);
    assert_eq!(asked.iter().filter(|it| *it == "frame").count(), 4);
    assert_eq!(
        asked.iter().filter(|it| it.starts_with("MOV(R6")).count(),
        2
    );
}

#[test]
fn statements_without_main_run_for_every_frame() {
    let text = "int n = scamp5_global_sum_16(A);\nfor (int i = 0; i < n; i++) mov(B, A);";
    let (asked, _) = told(text, 3, &[1, 2, 0]);
    let frames: Vec<usize> = asked
        .split(|it| it == "frame")
        .map(<[String]>::len)
        .collect();
    let one = frames[1] - 1;
    assert_eq!(frames, [0, 1 + one, 1 + 2 * one, 1, 0]);
}

#[test]
fn the_first_frame_is_the_one_that_is_captured_first() {
    // What is captured before the loop has a frame of its own, what else is done there has none.
    let captured = "int main() { get_image(B, F); int i = 0; while (1) { vs_frame_loop_control();\n\
                    get_image(A, F); if (i++ > 0) sub(C, A, B); } }";
    let (asked, _) = told(captured, 3, &[]);
    let frames: Vec<usize> = asked
        .split(|it| it == "frame")
        .map(<[String]>::len)
        .collect();
    assert_eq!(frames.len(), 5);
    assert!(
        frames[1] > 0 && frames[2] == frames[1] && frames[3] > frames[2],
        "{frames:?}"
    );
    let set = "int main() { scamp5_in(B, 3); int i = 0; while (1) { vs_frame_loop_control();\n\
               get_image(A, F); if (i++ > 0) sub(C, A, B); } }";
    let (asked, _) = told(set, 2, &[]);
    assert_eq!(asked.iter().filter(|it| *it == "frame").count(), 3);
}

#[test]
fn stopwatches_count_what_the_array_takes() {
    let text = "vs_stopwatch all, one; int main() { while (1) { vs_frame_loop_control(); all.reset(); NOT(R5, R6);\n\
                one.reset(); CLR(R5); CLR(R6); int t = one.get_usec(); printf(\"%d %d\", t, all.get_usec());\n\
                if (t > 15) CLR(R7); } }";
    let (asked, said) = told(text, 2, &[]);
    assert_eq!(said, ["20 30", "20 30"], "{asked:?}");
    assert_eq!(asked.iter().filter(|it| it.contains("R7")).count(), 2);
    // Waiting for one ends.
    let text = "vs_stopwatch one; int main() { while (1) { vs_frame_loop_control(); NOT(R5, R6); one.reset();\n\
                while (one.get_usec() < 1000); printf(\"%d\", one.get_usec() < 1100); } }";
    assert_eq!(told(text, 2, &[]).1, ["1", "1"]);
}

/// What a host cannot know is told, and a host that asks on and on ends.
#[test]
fn what_is_not_known_is_told_and_asking_ends() {
    let program = |inside: &str| {
        let text = format!(
            "#include <set>\nint main() {{ while (1) {{ vs_frame_loop_control(); {inside} }} }}"
        );
        let mut array = Told {
            frames: 1,
            answers: vec![0; 1 << 20],
            ..Told::default()
        };
        let program = Program::read("p.cpp", &text);
        program
            .run_beside(&Device::scamp5(), &Overrides::new(), &mut array)
            .map_err(|faults| faults.to_string())
    };
    let said = program(
        "std::set<int> m; m.insert(2); if (m.size() == 1) { scamp5_output_events(R5, 0, 4); }",
    );
    let warnings = said.unwrap().unwrap().faults;
    let is_told = { warnings.iter() }.any(|it| it.fault.message.contains("it is left out"));
    assert!(is_told, "{warnings:?}");
    // What is only shown hangs on nothing else.
    let said =
        program("std::set<int> m; m.insert(2); if (m.size() == 1) { scamp5_output_image(A); }");
    let warnings = said.unwrap().unwrap().faults;
    let is_told = { warnings.iter() }.any(|it| it.fault.message.contains(": it is shown"));
    assert!(is_told, "{warnings:?}");
    let said = program("while (scamp5_global_or(R5) == 0) NOT(R5);").unwrap_err();
    assert!(said.contains("statements run in one frame"), "{said}");
}

#[test]
fn long_runs_hold_few_variables() {
    // Each turn makes a few hundred variables: ten thousand frames are millions.
    let text = "struct P { int x, y; }; int sum(P *p, int n) { int s = 0; for (int i = 0; i < n; i++) { int v = p[i].x; s += v; } return s; }\n\
                int main() { P *kept = new P[3]; kept[2].x = 7; static int all = 0; auto add = [&](int by) { all += by; };\n\
                while (1) { vs_frame_loop_control(); P p[100] = {}; p[5].x = 2; add(sum(p, 100) + sum(kept, 3));\n\
                if (scamp5_global_or(R5)) MOV(R6, R5);\n\
                if (all == 18000) printf(\"%d %d\", all, kept[2].x); } }";
    let (_, said) = told(text, 2000, &[]);
    assert_eq!(said, ["18000 7"]);
}

/// Boxes in places that `<random>` draws, as the vendor's tutorial on shapes has them.
#[test]
fn random_numbers_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let text = "#include <random>
int main() {
    std::random_device rd;
    std::mt19937 gen(rd());
    std::uniform_int_distribution<> distr(4, 7);
    std::uniform_real_distribution<float> real{-1.0f, 1.0f};
    std::bernoulli_distribution coin(1.0);
    std::normal_distribution<> bell;
    while (1) {
        vs_frame_loop_control();
        int row = distr(gen);
        float part = real(gen);
        scamp5_load_rect(R5, row, 1, row + 2, 3);
        vs_post_text(\"%d %d %d %.3f\\n\", row, part >= -1.0f && part < 1.0f, (int)coin(gen), bell(gen));
        scamp5_output_image(R5, 0);
    }
}
";
    fs::write(folder.path().join("p.cpp"), text).unwrap();
    let scene = "pattern:disc?width=16&height=16&frames=12";
    let run = |more: &[&str]| {
        let all = [&["exec", "p.cpp", "--image", scene, "--frames", "12"], more].concat();
        json(folder.path(), &all)["posts"].clone()
    };
    let posts = run(&[]);
    let posts = posts.as_array().unwrap();
    assert_eq!(posts.len(), 12, "{posts:?}");
    let mut rows = Vec::new();
    for post in posts {
        let words: Vec<&str> = post["text"].as_str().unwrap().split_whitespace().collect();
        rows.push(words[0].parse::<u8>().unwrap());
        assert_eq!(words[1..3], ["1", "1"], "{post}");
        assert!(words[3].parse::<f64>().unwrap().abs() < 5.0, "{post}");
    }
    assert!(rows.iter().all(|row| (4..=7).contains(row)), "{rows:?}");
    assert!(rows.windows(2).any(|pair| pair[0] != pair[1]), "{rows:?}");
    // The same numbers in every run.
    assert_eq!(run(&["--domain", "q8.8"]).as_array(), Some(posts));
    refused(
        folder.path(),
        &["asm", "p.cpp"],
        &["p.cpp:13:", "depends on a random number"],
    );
}

#[test]
fn posts_are_written_as_c_does() {
    let all = posts(
        "float f = 2.5f; uint32_t u = 0xFFFFFFFF; vs_post_text(\"%d%% %5.2f %s %x %c %lu %u\", -3, f, \"text\", 255, 65, 1ul << 40, u);\n\
         vs_post_text(\"%d\", f); vs_post_text(\"%f\", 3); vs_post_text(\"plain\"); vs_post_text(\"%d %d\", 1);",
        1,
        &[],
    );
    assert_eq!(
        all,
        [
            "-3%  2.50 text ff A 1099511627776 4294967295",
            "2",
            "3.000000",
            "plain",
            "%d %d"
        ]
    );
}

#[test]
fn sliders_that_programs_move_loops_that_count_and_texts() {
    // Handles lead to what a slider writes, or to a number of its own.
    let all = posts(
        "static int v = 2; static int h = vs_gui_add_slider(\"v\", 0, 10, v, &v);\n\
         static auto own = vs_gui_add_slider(\"own\", 0, 10, 5); vs_on_gui_update(own, [&](int32_t x) { });\n\
         vs_post_text(\"%d %d %d %d\", v, vs_gui_read_slider(h), vs_gui_read_slider(own), vs_gui_read_slider(VS_GUI_FRAME_GAIN));\n\
         vs_gui_move_slider(h, v + 3); vs_gui_move_slider(own, v); vs_gui_move_slider(VS_GUI_FRAME_GAIN, 4);",
        2,
        &[],
    );
    assert_eq!(all, ["2 2 5 1", "5 5 5 4"]);
    let all = posts(
        "vs_post_text(\"%d %u\", (int)vs_loop_counter_get(), VS_LC);",
        3,
        &[],
    );
    assert_eq!(all, ["1 1", "2 2", "3 3"]);
    let all = posts(
        "std::string s = \"RED\", t; t += s; t += \"/\" + std::to_string(7); t.append(s);\n\
         std::pair<int, int> p = {3, 4}; auto [x, y] = p; auto f = [](int a) { return std::make_pair(a, 2 * a); };\n\
         struct Pair { int a; int b; }; Pair q = {5, 6}; auto &[a, b] = q; b = 9;\n\
         vs_post_text(\"%s %d %s %d %d %d %d %d\", t.c_str(), (int)t.size(), s.empty() ? \"\" : \"full\", x, y, p.second, a, q.b);",
        1,
        &[],
    );
    assert_eq!(all, ["RED/7RED 8 full 3 4 4 5 9"]);
    // A stopwatch that was just set back is divided by.
    let all = posts(
        "vs_stopwatch t; t.reset(); vs_post_text(\"%d\", 1000000 / t.get_usec());",
        1,
        &[],
    );
    assert_eq!(all, ["1000000"]);
}

#[test]
fn what_is_shown_may_hang_on_a_clock_and_readouts_have_their_lines() {
    let folder = tempfile::tempdir().unwrap();
    let text = "int main() { vs_stopwatch t; t.reset(); auto d = vs_gui_add_display(\"d\", 0, 0);\n\
        int before = scamp5_global_sum_fast(A);\n\
        while (1) { vs_frame_loop_control(); get_image(A, F);\n\
        int now = scamp5_global_sum_fast(A);\n\
        if (t.get_usec() > 1000000)\n\
        scamp5_output_image(A, d); } }";
    fs::write(folder.path().join("p.cpp"), text).unwrap();
    let exec = [
        "exec",
        "p.cpp",
        "--image",
        "pattern:disc?width=16&height=16&frames=3",
    ];
    let said = json(folder.path(), &exec);
    let lines: Vec<i64> = said["readings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|it| it["line"].as_i64().unwrap())
        .collect();
    assert_eq!(lines, [4], "{said}");
    let output = good(folder.path(), &["asm", "p.cpp"]);
    assert!(!output.contains("scamp5_output_image"), "{output}");
}

/// A clip of spots in a folder of its own.
fn clip_of_spots() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    // Five spots of two rows and more, one of a single pixel.
    let mut clip = Array3::<u8>::zeros((3, 24, 32));
    let mut set = |t: usize, y: usize, x: usize, h: usize, w: usize| {
        clip.slice_mut(ndarray::s![t, y..y + h, x..x + w]).fill(200);
    };
    for (t, spots) in [(0, 5), (1, 2), (2, 0)] {
        for k in 0..spots {
            set(t, 2 + k, 1 + 6 * k, 2 + k, 3);
        }
        set(t, 22, 30, 1, 1);
    }
    let path = folder.path().join("clip.npy");
    clip.write_npy(fs::File::create(&path).unwrap()).unwrap();
    folder
}

#[test]
fn a_host_that_decides_is_looked_at_word_by_word() {
    let folder = clip_of_spots();
    let program = format!("{VENDOR}/spots.cpp");
    let strip = ["--image", "clip.npy", "--frames", "1", "--strip", "s.png"];
    let table = good(folder.path(), &[&["exec", &program][..], &strip].concat());
    assert!(table.contains("post     frame 0: 5 spots"), "{table}");
    assert!(folder.path().join("s.png").is_file());
    let debug = amacrine(
        folder.path(),
        &["exec", &program, "--image", "clip.npy", "--debug"],
    )
    .write_stdin("break 17\nc\nc\nc\nc\nc\nc\nc\nc\nprint R10 1 2\nquit\n")
    .assert()
    .success();
    let debug = String::from_utf8(debug.get_output().stdout.clone()).unwrap();
    // Five spots and a single pixel in the first frame, the other stops in the second.
    let stops = debug.matches("line 17: NOT(R6, R11)").count();
    assert_eq!(stops, 8, "{debug}");
    assert!(debug.contains("frame 1"), "{debug}");
}

#[test]
fn spots_are_counted() {
    let folder = clip_of_spots();
    let program = format!("{VENDOR}/spots.cpp");
    for domain in ["exact", "silicon"] {
        let said = json(
            folder.path(),
            &[
                "exec",
                &program,
                "--image",
                "clip.npy",
                "--fps",
                "30",
                "--domain",
                domain,
                "--displays",
                "shown",
            ],
        );
        let posts: Vec<&str> = said["posts"]
            .as_array()
            .unwrap()
            .iter()
            .map(|it| it["text"].as_str().unwrap())
            .collect();
        assert_eq!(
            posts,
            [
                "frame 0: 5 spots, the tallest of 6 rows\n",
                "frame 1: 2 spots, the tallest of 6 rows\n",
                "frame 2: 0 spots, the tallest of 6 rows\n"
            ],
            "{domain}"
        );
        assert_eq!(said["frames"], 3);
        let note = said["notes"][0].as_str().unwrap();
        assert!(note.starts_with("the host decides what runs: "), "{note}");
        assert_eq!(
            fs::read_dir(folder.path().join("shown")).unwrap().count(),
            3
        );
    }
    // A value that is given holds for good.
    let said = json(
        folder.path(),
        &[
            "exec", &program, "--image", "clip.npy", "--const", "count=3",
        ],
    );
    assert_eq!(
        said["posts"][1]["text"],
        "frame 1: 3 spots, the tallest of 6 rows\n"
    );
    let table = good(folder.path(), &["exec", &program, "--image", "clip.npy"]);
    assert!(table.contains("post     frame 2: 0 spots"), "{table}");
    // What needs the words before says so; what looks at them runs them again.
    refused(
        folder.path(),
        &[
            "exec",
            &program,
            "--image",
            "clip.npy",
            "--fidelity",
            "auto",
        ],
        &[
            "the host of",
            "decides in the run",
            "--fidelity auto",
            "amacrine compare full.npy less.npy",
        ],
    );
    refused(
        folder.path(),
        &["asm", &program],
        &["`exec` runs it, with the host beside the array"],
    );
    refused(
        folder.path(),
        &["exec", &program, "--const", "spotz=1"],
        &["there is no constant `spotz`"],
    );
}

/// The page shows what is printed.
#[test]
fn the_page_of_hosts_that_decide() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("docs/vendor-code.md")).unwrap();
    let command = "amacrine exec tests/data/vendor/spots.cpp --image bundled --frames 3 --const threshold=115";
    let mut blocks = page.split("\n```").skip(1).step_by(2);
    assert!(blocks.any(|block| block.contains(command)));
    let shown = blocks.next().unwrap().lines().skip(1);
    let words: Vec<&str> = command.split(' ').skip(1).collect();
    let said = good(root, &words);
    for line in shown.filter(|line| *line != "...") {
        assert!(said.lines().any(|it| it == line), "{line}: {said}");
    }
    // A search that stops by itself is no loss: a note says what each look left, and no warning.
    assert!(
        said.contains("found no slot; the host may look for them again"),
        "{said}"
    );
    let warnings = json(root, &words)["warnings"].to_string();
    assert!(!warnings.contains("\"slots\""), "{warnings}");
}

/// What finds no slot is told beside a host too, in the table and to scripts.
#[test]
fn events_that_are_lost_beside_a_host_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let text = "uint8_t on[20];\nint main() { while (1) { vs_frame_loop_control();\n\
                get_image(A); where(A); MOV(R5, FLAG); all(); scamp5_scan_events(R5, on, 10); } }";
    fs::write(folder.path().join("p.cpp"), text).unwrap();
    let scene = "pattern:disc?width=8&height=8&frames=2";
    let run = ["exec", "p.cpp", "--image", scene];
    let laid_out = json(folder.path(), &run);
    let lost = laid_out["dropped"]["no_slot"].as_u64().unwrap();
    assert!(lost > 0, "{laid_out}");
    let host = [&run[..], &["--host"]].concat();
    let note = format!("{lost} set pixels found no slot; the host may look for them again");
    let said = json(folder.path(), &host);
    assert!(
        said["notes"].to_string().contains(&note),
        "{}",
        said["notes"]
    );
    let table = good(folder.path(), &host);
    assert_eq!(table.matches("found no slot").count(), 1, "{table}");
    assert!(table.contains(&note), "{table}");
}

/// Kinds of cells are counted as they are read out.
#[test]
fn kinds_are_those_that_are_read_out() {
    let folder = tempfile::tempdir().unwrap();
    let text = "int main() { uint8_t on0[20], off2[20]; while (1) { vs_frame_loop_control(); SET(R5);\n\
                scamp5_scan_events(R5, on0, 10); if (on0[3] > 0) { MOV(R6, R5); scamp5_scan_events(R6, off2, 10); } } }";
    fs::write(folder.path().join("p.cpp"), text).unwrap();
    let scene = "pattern:disc?width=4&height=2&frames=2";
    let arguments = ["exec", "p.cpp", "--image", scene, "--events", "e.csv"];
    let said = json(folder.path(), &arguments);
    assert_eq!(
        (said["on"].as_u64(), said["off"].as_u64()),
        (Some(16), Some(16))
    );
    let all = fs::read_to_string(folder.path().join("e.csv")).unwrap();
    let mut lines = all.lines();
    assert!(lines.next().unwrap().ends_with(",p,channel"), "{all}");
    let kinds = |end: &str| all.lines().filter(|it| it.ends_with(end)).count();
    assert_eq!((kinds(",1,0"), kinds(",0,2")), (16, 16), "{all}");
}

/// In memory samples lie column by column from the top right, as the vendor states it.
#[test]
fn samples_are_read_column_by_column() {
    let folder = tempfile::tempdir().unwrap();
    let light = Array3::from_shape_fn((2, 8, 8), |(_, y, x)| (2 * (10 * y + x)) as f64);
    let path = folder.path().join("light.npy");
    light.write_npy(fs::File::create(path).unwrap()).unwrap();
    let text = "int main() { uint8_t b[6], all[64]; while (1) { vs_frame_loop_control(); get_image(A, F);\n\
                scamp5_scan_areg(A, b, 1, 0, 3, 1, 1, 1); scamp5_scan_areg_8x8(A, all);\n\
                vs_post_text(\"%d %d %d %d %d %d\", b[0] - 128, b[1] - 128, b[2] - 128, b[3] - 128, b[4] - 128, b[5] - 128);\n\
                vs_post_text(\"%d %d %d\", all[1] - 128, all[8] - 128, scamp5_read_areg(A, 2, 3) - 128);\n\
                if (b[0] > 0) CLR(R5); } }";
    fs::write(folder.path().join("p.cpp"), text).unwrap();
    let said = json(folder.path(), &["exec", "p.cpp", "--image", "light.npy"]);
    // The light less 127; column 0 is the rightmost one, x = 7.
    assert_eq!(said["posts"][0]["text"], "-93 -73 -53 -95 -75 -55");
    assert_eq!(said["posts"][1]["text"], "-93 -115 -79");
}

/// Row by row, each pair row first; of more events than slots the first rows.
#[test]
fn events_are_read_row_by_row_too() {
    let text = "int main() { uint8_t e[20]; while (1) { vs_frame_loop_control();\n\
                scamp5_load_rect(R5, 1, 2, 2, 4);\n\
                scamp5_scan_events_rc(R5, e, 4);\n\
                vs_post_text(\"%d %d %d %d %d %d %d %d\", e[0], e[1], e[2], e[3], e[4], e[5], e[6], e[7]);\n\
                scamp5_scan_events_rc(R5, e, 9, 0, 1);\n\
                vs_post_text(\"%d %d %d %d %d\", e[0], e[1], e[10], e[11], e[12]);\n\
                scamp5_scan_events_cr(R5, e, 9);\n\
                vs_post_text(\"%d %d %d %d\", e[0], e[1], e[2], e[3]); } }";
    let said = posts_each_frame(text, ["1 2 1 3 1 4 2 2", "2 2 1 4 0", "2 1 2 2"]);
    assert!(!said["warnings"].to_string().contains("row by row"));
}

/// Whether a point is drawn hangs on its place alone.
#[test]
fn a_point_off_the_array_is_not_drawn() {
    let inside = "int n = 0; scamp5_draw_begin(R6);\n\
                  for (int i = 0; i < 20; i++) if (scamp5_draw_point(i * 20, 250 + i)) n++;\n\
                  bool out = scamp5_draw_point(-1, 3); scamp5_draw_end(); vs_post_text(\"%d %d\", n, out);";
    assert_eq!(posts(inside, 1, &[]), ["6 0"]);
}

/// Moves change the four registers of directions, and no other one.
#[test]
fn bits_move_in_place() {
    let text = "int main() { while (1) { vs_frame_loop_control();\n\
                scamp5_load_rect(RF, 0, 0, 1, 1); scamp5_load_rect(R5, 1, 1, 2, 2); scamp5_load_rect(R6, 1, 1, 2, 2);\n\
                scamp5_shift(R5, -3, 2); scamp5_shift(R6, 2, -1, 1);\n\
                uint8_t b[4]; scamp5_scan_boundingbox(RF, b); vs_post_text(\"%d %d %d %d\", b[0], b[1], b[2], b[3]);\n\
                scamp5_scan_boundingbox(R5, b); vs_post_text(\"%d %d %d %d\", b[0], b[1], b[2], b[3]);\n\
                uint8_t e[128]; scamp5_scan_events_rc(R6, e, 60); int n = 0;\n\
                for (int i = 0; i < 120; i += 2) if (e[i] || e[i + 1]) n++;\n\
                vs_post_text(\"%d %d\", n, scamp5_global_or(R6, 7, 7, 0, 0)); } }";
    posts_each_frame(text, ["0 0 1 1", "0 4 0 5", "23 1"]);
}

/// What can be laid out runs alike with its host beside the array, on noisy silicon too.
#[test]
fn a_host_that_decides_nothing_changes_nothing() {
    let root = Path::new(VENDOR);
    let folder = tempfile::tempdir().unwrap();
    let scene = "pattern:disc?width=40&height=30&frames=5";
    for file in ["threshold.cpp", "blobs.cpp", "generated.cpp"] {
        let program = root.join(file).display().to_string();
        for domain in ["exact", "silicon"] {
            let run = |dump: &str, more: &[&str]| {
                let arguments = [
                    "exec", &program, "--image", scene, "--domain", domain, "--dump", dump,
                ];
                let mut said = json(folder.path(), &[&arguments[..], more].concat());
                // What is shown, the host decides in `blobs.cpp`; of events that one misses it is not
                // warned.
                for key in [
                    "notes",
                    "written",
                    "posts",
                    "array_us",
                    "words_per_frame",
                    "array_us_per_frame",
                    "host_us",
                    "readings",
                    "warnings",
                    "source_warnings",
                ] {
                    said.as_object_mut().unwrap().remove(key);
                }
                let registers: Vec<(String, Vec<u8>)> = {
                    let all = fs::read_dir(folder.path().join(dump)).unwrap();
                    let mut all: Vec<_> = all.map(|it| it.unwrap().path()).collect();
                    all.sort();
                    let named = |it: &Path| it.file_name().unwrap().to_string_lossy().into_owned();
                    all.iter()
                        .map(|it| (named(it), fs::read(it).unwrap()))
                        .collect()
                };
                (said, registers)
            };
            let (laid_out, beside) = (run("a", &[]), run("b", &["--host"]));
            assert_eq!(laid_out.0, beside.0, "{file} in {domain}");
            for (a, b) in laid_out.1.iter().zip(&beside.1) {
                assert!(a == b, "{file} in {domain}: {} differs", a.0);
            }
        }
    }
}

/// Passes of a loop that ask the same are one beside the array too, with what is drawn in them.
#[test]
fn equal_passes_are_one_beside_the_array() {
    let text = "int main() { scamp5_draw_begin(R5); int s = scamp5_global_or(R6);\n\
                for (int i = 0; i < 3; i++) scamp5_draw_pixel(1, 2); scamp5_global_or(R5);\n\
                for (int i = 0; i < 2; i++) { scamp5_in(A, 3); scamp5_global_or(R6); scamp5_draw_begin(R6); scamp5_draw_end(); } }";
    let (asked, _) = told(text, 1, &[]);
    let count = |of: &str| asked.iter().filter(|it| it.contains(of)).count();
    let pixels = count("scamp5_draw_pixel(1, 2)");
    assert_eq!(
        [pixels, count("scamp5_in"), count("global_or")],
        [3, 2, 4],
        "{asked:?}"
    );
    // More than there is room for, but for that.
    let text = format!(
        "int main() {{ get_image(A, C);\n for (int i = 0; i < 4500; i++) {{\n\
         scamp5_in(B, 3); scamp5_kernel_begin(); {} scamp5_kernel_end(); }} }}",
        "diva(A, D, E);".repeat(10)
    );
    let folder = tempfile::tempdir().unwrap();
    let (path, file) = (folder.path(), folder.path().join("p.cpp"));
    let scene = "pattern:disc?width=16&height=16&frames=1";
    let exec = ["exec", "p.cpp", "--image", scene, "--frames", "1"];
    fs::write(&file, &text).unwrap();
    let said = json(path, &[&exec[..], &["--host"]].concat());
    assert_eq!(said["words"], 6 + 52 * 4500);
    // Passes that differ are too many, and C++ has no `repeat`.
    fs::write(&file, text.replace("(B, 3)", "(B, i % 100)")).unwrap();
    for host in [&[][..], &["--host"]] {
        let words = ["262144 steps", "give its passes the same body"];
        refused(path, &[&exec[..], host].concat(), &words);
    }
}

/// The loop over the frames is the inner one, and what stands around it is done once; where it may
/// end, the host decides.
#[test]
fn loops_over_the_frames_inside_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "pattern:disc?width=16&height=16&frames=4";
    for (inside, words) in [
        ("while (1) { W; while (1) { W; get_image(A); } }", 15),
        (
            "while (1) { for (;;) { W; while (1) { W; get_image(A); } } }",
            15,
        ),
        (
            "while (1) { res(B); while (!restart) { W; get_image(A); } restart = 0; }",
            22,
        ),
        (
            "res(B); do { CLR(R5); W; while (1) { get_image(A); W; } } while (1);",
            23,
        ),
        // Its first iteration leaves it: the outer one is that over the frames.
        (
            "while (1) { res(B); while (1) { W; get_image(A); if (!restart) break; } }",
            30,
        ),
    ] {
        let text = format!(
            "#define W vs_frame_loop_control()\nint main() {{ int restart = 0; vs_gui_add_switch(\"restart\", false, &restart); {inside} }}"
        );
        fs::write(folder.path().join("p.cpp"), &text).unwrap();
        let run = |more: &[&str]| {
            let all = [&["exec", "p.cpp", "--image", scene], more].concat();
            json(folder.path(), &all)["words"].as_u64().unwrap()
        };
        assert_eq!((run(&[]), run(&["--host"])), (words, words), "{text}");
    }
    for inside in [
        "while (1) { res(B); while (1) { W; get_image(A); if (scamp5_global_or(R5)) break; } }",
        "while (1) { W; get_image(A); if (n == 2) while (1) { W; res(B); } n++; }",
        "bool again = false; while (1) { W; get_image(A); if (again) while (1) { W; res(B); } again = true; }",
    ] {
        let text =
            format!("#define W vs_frame_loop_control()\nint main() {{ int n = 1; {inside} }}");
        assert!(decides(&Program::read("p.cpp", &text)), "{text}");
    }
}

#[test]
fn what_goes_wrong_beside_the_array_has_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = |inside: &str, words: &[&str]| {
        let text = format!(
            "int main() {{ int n = 0; while (1) {{ vs_frame_loop_control(); get_image(A, F);\nint s = scamp5_global_sum_fast(A);\nif (s > n) mov(B, A);\n{inside}\n}} }}"
        );
        fs::write(folder.path().join("p.cpp"), text).unwrap();
        refused(
            folder.path(),
            &[
                "exec",
                "p.cpp",
                "--image",
                "pattern:disc?width=16&height=16&frames=2",
            ],
            words,
        );
    };
    wrong(
        "uint8_t few[4]; scamp5_scan_events(R5, few, 100);",
        &[
            "p.cpp:4:",
            "`scamp5_scan_events` writes 200 numbers, but the buffer has room for 4",
        ],
    );
    wrong(
        "while (1) { n++; if (n < 0) break; }",
        &["p.cpp:4:", "statements run before the program is known"],
    );
    wrong(
        "if (startCamera(0) > 3) mov(C, A);",
        &[
            "p.cpp:4:5",
            "the function `startCamera` is not defined in any file here",
        ],
    );
    wrong(
        "if (time(0) > 3) mov(C, A);",
        &["p.cpp:4:5", "whether this kernel runs depends on `time`"],
    );
    wrong(
        "int a[3]; a[s] = 1; scamp5_in(C, a[s + 9]);",
        &["p.cpp:4:", "out of bounds"],
    );
    wrong("if (s >= 0) scamp5_load_in(D, 1, 2, 3);", &["p.cpp:4:"]);
    wrong(
        "printf(\"%.*f\", 100000, 0.1);",
        &[
            "p.cpp:4:",
            "a width or a precision of more than 4096 characters",
        ],
    );
    // The array itself says no.
    fs::write(
        folder.path().join("p.cpp"),
        "int main() { while (1) { if (scamp5_global_or(R5) == 0) get_image(A, F); } }",
    )
    .unwrap();
    let light = Array2::<f64>::from_elem((4, 4), 1e300);
    light
        .write_npy(fs::File::create(folder.path().join("light.npy")).unwrap())
        .unwrap();
    refused(
        folder.path(),
        &[
            "exec",
            "p.cpp",
            "--image",
            "light.npy",
            "--host",
            "--set",
            "A=none.npy",
        ],
        &["none.npy"],
    );
    refused(
        folder.path(),
        &["exec", "convolve/sobel", "--host"],
        &["--host is for vendor C++"],
    );
}

/// What is warned of in the program's text is in the JSON, whoever decides.
#[test]
fn warnings_of_the_text_are_told_to_scripts() {
    let folder = tempfile::tempdir().unwrap();
    let text = "int main() { while (1) { vs_frame_loop_control();\n\
                scamp5_kernel_begin(); get_image(A, C); CLR(R5); scamp5_kernel_end();\n\
                auto d = vs_gui_add_display(\"d\", 0, 0);\n\
                scamp5_output_image(R7, d); } }";
    fs::write(folder.path().join("p.cpp"), text).unwrap();
    for host in [&[][..], &["--host"]] {
        let scene = "pattern:disc?width=40&height=30&frames=3";
        let arguments = [&["exec", "p.cpp", "--image", scene], host].concat();
        let said = json(folder.path(), &arguments);
        let warnings = said["source_warnings"].as_array().unwrap();
        let told = |it: &Value| it.as_str().unwrap().starts_with("p.cpp:4:");
        assert!(warnings.iter().any(told), "{host:?}: {said}");
    }
}

#[test]
fn texts_that_are_not_shown_are_told_of() {
    let folder = tempfile::tempdir().unwrap();
    let text = "int main() { while (1) { vs_frame_loop_control(); get_image(A, F);\n\
                vs_post_text(\"a\"); vs_post_text(\"b\"); } }";
    fs::write(folder.path().join("p.cpp"), text).unwrap();
    let scene = "pattern:disc?width=8&height=8&frames=2";
    let notes = |more: &[&str]| {
        let all = [&["exec", "p.cpp", "--image", scene], more].concat();
        json(folder.path(), &all)["notes"].to_string()
    };
    assert!(notes(&[]).contains("texts that the host posts in 2 places are not shown: --host"));
    assert!(!notes(&["--host"]).contains("not shown"));
}
