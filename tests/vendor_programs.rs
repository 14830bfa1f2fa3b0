//! Vendor C++ as public programs of the chip are written: classes in a header and a file, types that
//! are defined where they are used, constants of a file, and what the vendor's box adds to the
//! language. The numbers are those of g++ with the vendor's types.

use std::fs;

use amacrine::{
    config::{Fault, Severity},
    isa::Device,
    program::{Action, Expansion, Includes},
};

mod common;
mod vendor_cpp;
use common::good;
use vendor_cpp::{expand, expand_with, numbers, numbers_of, told};

/// What a program is warned of.
#[track_caller]
fn warned(text: &str, message: &str) {
    let all = expand(text).unwrap_or_else(|it| panic!("{it:?}")).warnings;
    let found = all.iter().any(|it| it.message.contains(message));
    assert!(found, "{text}\n{all:#?}");
}

const TREE: &str = r"
class Leaf { public: int n; Leaf(int k); int twice() { return 2 * n; } };
class Tree { public:
  Tree();
  Tree(int a, int b = 5);
  virtual ~Tree();
  int sum() { return x + y + l.twice() + m.n; }
  void run();
private:
  int x, y = 3;
  Leaf l;
  Leaf m{7};
};
";

const TREES: &str = r"
int made = 0;
inline Leaf::Leaf(int k) : n(k) {}
Tree::Tree() : x(1), l(2) { made++; }
Tree::Tree(int a, int b) : x(a), y(b), l(b) {}
Tree::~Tree() {}
void Tree::run() { scamp5_kernel_begin(); mov(A, B); scamp5_kernel_end(); scamp5_in(C, sum()); }
";

/// In the class it is announced; objects that an object holds are made by theirs.
#[test]
fn constructors_stand_behind_their_class() {
    let inside = "Tree t; t.run(); Tree u(10); u.run(); Tree* v = new Tree(1, 2); v->run(); scamp5_in(D, made);";
    let all = [15, 32, 14, 1];
    numbers(&format!("{TREE}{TREES}"), inside, &all);
    let includes = Includes::from([
        (
            "tree.hpp".to_owned(),
            format!("#pragma once\n{TREE}").as_str().into(),
        ),
        (
            "tree.cpp".to_owned(),
            format!("#include \"tree.hpp\"\n{TREES}").as_str().into(),
        ),
    ]);
    let main = format!("#include \"tree.hpp\"\nextern int made; int main() {{ {inside} }}");
    numbers_of(expand_with(&main, &includes), &all, &main);
    numbers(
        "struct K { int n; int m; K(); int get() const; }; K::K() : n(), m{4} {} int K::get() const { return 10 * n + m; }",
        "K k; scamp5_in(A, k.get()); K all[2]; scamp5_in(A, all[1].get());",
        &[4, 4],
    );
}

/// What a constructor asks of the array it asks where an object is made.
#[test]
fn constructors_run_words_where_an_object_is_made() {
    let before = "struct G { G(int n); }; G::G(int n) { scamp5_in(C, n); }";
    numbers(
        before,
        "scamp5_in(A, 1); G g(2); scamp5_in(A, 3);",
        &[1, 2, 3],
    );
    numbers(before, "scamp5_in(A, 1);", &[1]);
}

/// They are not run, and those behind a class neither.
#[test]
fn destructors_behind_their_class_are_looked_at() {
    for does in ["left--;", "vs_post_text(\"end\");"] {
        let text = format!(
            "struct E {{ int n; E(); ~E(); }};\nint left = 1;\nE::E() : n(1) {{}}\nE::~E() {{ {does} }}\nint main() {{ E e; mov(A, B); }}"
        );
        told(
            &text,
            4,
            "the destructor of `E`",
            "at the end of the object's lifetime",
        );
    }
    numbers(
        "struct E { int n; E(); ~E(); }; E::E() : n(6) {} E::~E() { n = 0; }",
        "E e; scamp5_in(A, e.n);",
        &[6],
    );
}

#[test]
fn what_stops_a_class_is_named() {
    told(
        "struct T { int n;\n  operator bool();\n  void run() { mov(A, B); } };\nint main() { T t; t.run(); }",
        4,
        "`t.run` runs instructions of the array",
        "(the first in line 2)",
    );
    told(
        "struct T { int n; T(); };\nint main() { T t;\n if (t.n) mov(A, B); }",
        3,
        "whose constructor in line 1 is not defined",
        "",
    );
}

#[test]
fn types_are_defined_where_they_are_used() {
    numbers(
        r"static struct s { int n; } v; const struct { int a; int b; } w[2] = {{1, 2}, {3, 4}}; static class Q { public: int z = 4; } q;
enum mode { ONE, TWO } st = TWO; enum { P, R } un = R; enum class K : uint8_t { X, Y } k = K::Y; volatile struct pt { int x, y; } *pp; enum mode other = ONE;
struct Box { enum { SMALL, LARGE } size; int n; };",
        r"v.n = 9; pt o; o.x = 8; pp = &o; static enum mode in = TWO; enum loc { L0 = 6, L1 } ll = L1; struct { int r; } own = {5}; Box b; b.size = Box::LARGE; b.n = 2;
scamp5_in(A, v.n); scamp5_in(A, w[1].b); scamp5_in(A, q.z); scamp5_in(A, st); scamp5_in(A, un); scamp5_in(A, (int)k); scamp5_in(A, pp->x);
scamp5_in(A, other); scamp5_in(A, in); scamp5_in(A, ll); scamp5_in(A, own.r); scamp5_in(A, b.size + b.n);",
        &[9, 4, 4, 1, 1, 1, 8, 0, 1, 7, 5, 3],
    );
}

/// As the vendor's own macros are.
#[test]
fn overloads_are_chosen_by_the_kind_of_register() {
    numbers(
        "void f(AREG a) { scamp5_in(a, 1); } void f(DREG d) { SET(d); scamp5_in(A, 2); } struct C { void g(AREG a) { scamp5_in(a, 3); } void g(DREG d) { scamp5_in(A, 4); } };",
        "f(B); f(R5); C c; c.g(C); c.g(S1); AREG r = D; f(r);",
        &[1, 2, 3, 4, 1],
    );
}

/// Constant and `static` ones are each file's own.
#[test]
fn files_have_variables_of_one_name() {
    let file = |name: &str, first: &str, second: u8, start: u8| {
        format!(
            "const dreg_t bits[2] = {{{first}, R6}}; const int size = {second}; static int turns = {start};\nvoid {name}() {{ SET(bits[0]); turns++; scamp5_in(A, size); scamp5_in(A, turns); }}"
        )
    };
    let includes = Includes::from([
        ("one.hpp".to_owned(), "void one();".into()),
        ("two.hpp".to_owned(), "void two();".into()),
        (
            "one.cpp".to_owned(),
            file("one", "R7", 3, 10).as_str().into(),
        ),
        (
            "two.cpp".to_owned(),
            file("two", "R8", 4, 20).as_str().into(),
        ),
    ]);
    let main = "#include \"one.hpp\"\n#include \"two.hpp\"\nconst int size = 5;\nint main() { one(); two(); one(); two(); scamp5_in(B, size); }";
    let read = expand_with(main, &includes);
    let set = |read: &Expansion| {
        let device = Device::scamp5();
        let words = read.code.frame.iter().filter_map(|it| match &it.action {
            Action::Word(word) => Some(word.text(&device)),
            _ => None,
        });
        let words: Vec<String> = words.filter(|it| it.starts_with("SET")).collect();
        words.join(" ")
    };
    if let Ok(read) = &read {
        assert_eq!(set(read), "SET(R7) SET(R8) SET(R7) SET(R8)");
    }
    numbers_of(read, &[3, 11, 4, 21, 3, 12, 4, 22, 5], main);
}

/// The vendor's parameter has eight bits.
#[test]
fn values_for_the_array_are_passed_with_a_sign() {
    let text = "int main() { uint8_t v = -50; scamp5_in(C, v); scamp5_in(A, 241); scamp5_in(B, -129); scamp5_load_in(C, 200); scamp5_in(A, -128); }";
    numbers_of(expand(text), &[-50, -15, 127, -128], text);
    warned(text, "C++ passes -50 instead of 206");
    warned(text, "C++ passes -56 instead of 200");
    let text = "int main() { scamp5_in(A, 0xffffffffffffffff); std::string s = std::to_string(18446744073709551615ULL); scamp5_in(B, s.size()); }";
    numbers_of(expand(text), &[-1, 20], text);
    warned(text, "C++ passes -1 instead of 18446744073709551615");
}

/// What is read or shown in an included file is told with that file and its line there.
#[test]
fn readings_of_an_included_file_name_it() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write(
        "part.hpp",
        "void part() {\n  scamp5_output_image(A, \"seen\");\n  int n = scamp5_global_sum_64(A);\n  scamp5_output_image(F, 0);\n}\n",
    );
    write(
        "p.cpp",
        "#include \"part.hpp\"\nint main() { while (1) { vs_frame_loop_control(); get_image(A, F); part();\nscamp5_output_image(F, \"own\"); } }",
    );
    let scene = "pattern:disc?width=16&height=16&frames=1";
    for host in [&[][..], &["--host"]] {
        let run = ["exec", "p.cpp", "--image", scene, "--displays", "shown"];
        let said = good(folder.path(), &[&run[..], host].concat());
        for read in [
            "read     part.hpp:2: 256 ADC values",
            "read     part.hpp:3: sum ",
            "read     line 3: 256 ADC values",
        ] {
            assert!(said.contains(read), "{said}");
        }
        let mut shown: Vec<String> = fs::read_dir(folder.path().join("shown"))
            .unwrap()
            .map(|it| it.unwrap().file_name().into_string().unwrap())
            .collect();
        shown.sort();
        // Each has its own title.
        for name in ["part-hpp-2-seen", "part-hpp-4", "line-3-own"] {
            let name = format!("{name}-frame-0000.png");
            assert!(shown.contains(&name), "{shown:?}");
        }
        let said = common::json(folder.path(), &[&run[..], host].concat());
        let lines: Vec<_> = { said["readings"].as_array().unwrap().iter() }
            .map(|it| (it["file"].as_str(), it["line"].as_u64().unwrap()))
            .collect();
        let part = Some("part.hpp");
        assert_eq!(lines, [(part, 2), (part, 3), (part, 4), (None, 3)]);
        fs::remove_dir_all(folder.path().join("shown")).unwrap();
    }
}

/// Where the run may have ended before, no word hangs on an element.
#[test]
fn elements_behind_an_undecided_return_are_warned_of() {
    let text = "int n[4];\nvoid count() { uint8_t c[20]; scamp5_scan_events(R5, c, 15); for (int i = 0; i < 15; i++) {\n if (c[2 * i] == 0 && c[2 * i + 1] == 0) return;\n n[c[2 * i] / 64]++; } }\nint main() { CLR(R5); count(); mov(A, B); }";
    warned(text, "element 20 is out of bounds");
    told(
        "int main() { int c[2]; for (int i = 0; i < 3; i++)\nc[i] = 1; mov(A, B); }",
        2,
        "element 2 is out of bounds",
        "",
    );
}

/// Nothing in the loop changes what it waits for.
#[test]
fn a_loop_whose_condition_stays_is_that_of_the_frames() {
    let text = "int run = 1; int main() { while (run) { scamp5_kernel_begin(); mov(A, B); scamp5_kernel_end(); scamp5_output_image(A); } }";
    let code = expand(text).unwrap();
    assert!(code.code.init.is_empty() && !code.code.frame.is_empty());
    numbers(
        "int go = 3;",
        "while (go) { scamp5_in(A, go); go--; }",
        &[3, 2, 1],
    );
    told(
        "int busy = 1; int main() {\nwhile (busy) { vs_process_message(); }\nmov(A, B); }",
        2,
        "nothing in it changes `busy`",
        "--const busy=VALUE",
    );
    for always in ["!0", "!false", "true == 1", "-1", "2 > 1", "(bool)3", "0.5"] {
        let text =
            format!("int main() {{ while ({always}) {{ vs_frame_loop_control(); mov(A, B); }} }}");
        let read = expand(&text).unwrap();
        let ends = |it: &Fault| it.message.contains("ends after");
        assert!(!read.warnings.iter().any(ends), "{text}");
    }
    numbers(
        "",
        "while (2 < 1) { vs_frame_loop_control(); nop(); } scamp5_in(A, 5);",
        &[5],
    );
}

/// What is done once is one frame.
#[test]
fn frames_before_the_loop_are_warned_of() {
    let text = |before: &str| {
        format!(
            "int main() {{ bool first = true; {before} while (1) {{ vs_frame_loop_control(); get_image(A); if (first) {{ mov(C, A); first = false; }} }} }}"
        )
    };
    warned(
        &text("vs_frame_loop_control(); CLR(R5);"),
        "2 frames before the frame loop are merged into one here, `init`",
    );
    warned(
        &text("CLR(R5); vs_frame_loop_control(); CLR(R6); vs_frame_loop_control(); CLR(R7);"),
        "3 frames before the frame loop",
    );
    warned(
        "int main() { vs_frame_loop_control(); vs_frame_loop_control(); while (1) { vs_frame_loop_control(); get_image(A); } }",
        "2 frames before the frame loop",
    );
    for before in ["CLR(R5);", "", "vs_init(); scamp5_in(B, 1);"] {
        let told = |it: &Fault| it.message.contains("before the frame loop");
        let read = expand(&text(before)).unwrap();
        assert!(!read.warnings.iter().any(told), "{before}");
    }
}

/// A loop that its first iteration leaves is none: what stands behind it is run.
#[test]
fn a_loop_that_is_left_at_once_is_no_loop() {
    let words = |text: &str| {
        let code = expand(text).unwrap().code;
        code.init.len() + code.frame.len()
    };
    let left = "vs_frame_loop_control(); get_image(A);";
    for (end, behind) in [("break;", 1), ("return 0;", 0)] {
        let text = format!("int main() {{ while (1) {{ {left} {end} }} CLR(R5); }}");
        let plain = ["get_image(A);", "get_image(A); CLR(R5);"][behind];
        assert_eq!(
            words(&text),
            words(&format!(
                "int main() {{ vs_frame_loop_control(); {plain} }}"
            )),
            "{text}"
        );
    }
}

/// A type of nearly the name of another one is told where it stands.
#[test]
fn misspelt_types_are_named() {
    told(
        "struct Pair { int a; int b; };\nint main() {\nPairs p = {5, 6};\nscamp5_in(A, p.b); }",
        3,
        "the type `Pairs` is not defined in any file here",
        "did you mean `Pair`?",
    );
    numbers(
        "struct Pair { int a; }; typedef Pair Pairs;",
        "Pairs p = {5}; Other o; scamp5_in(A, p.a);",
        &[5],
    );
}

/// A function that no file defines is told with the file that may be missing.
#[test]
fn functions_of_nobody_are_named() {
    told(
        "int main() {\nstartCamera(3); mov(A, B); }",
        2,
        "the function `startCamera` is not defined in any file here",
        "define it",
    );
    told(
        "#include \"camera.hpp\"\nint main() {\nstartCamera(3); mov(A, B); }",
        3,
        "the function `startCamera` is not defined in any file here",
        "`camera.hpp`",
    );
    // A word that is nearly one of the chip's.
    told(
        "int main() {\nmovv(A, B); }",
        2,
        "unknown statement `movv`",
        "did you mean",
    );
    numbers(
        "",
        "srand(time(NULL)); clock_t t = clock(); FILE* f = fopen(\"a\", \"w\"); fprintf(f, \"x\"); fclose(f); scamp5_in(A, 3);",
        &[3],
    );
}

/// Of an object whose type nobody defines nothing is known, its members neither.
#[test]
fn objects_of_unknown_types_take_no_other_name() {
    let text = "int main() { cfg c {}; c.x = UNKNOWN; c.y = 7; c.r = R5; c.s = R6; mov(A, B); }";
    let code = expand(text).unwrap_or_else(|it| panic!("{it:?}"));
    assert!(code.code.frame.len() > 1);
    told(
        "int main() { SCAMP5 s;\ns.add(s.A, s.A, s.B);\nmov(A, B); }",
        2,
        "what `s.add` does with `s.A` is not known",
        "`add(A, A, B);`",
    );
    told(
        "int main() { SCAMP5 s;\ns.movx(s.A, s.B, north);\nmov(A, B); }",
        2,
        "what `s.movx` does with `s.A` is not known",
        "`movx(A, B, north);`",
    );
    told(
        "int main() { SCAMP5* s; int n = 2;\ns->scamp5_in(s->A, 3 * n + 1);\nmov(A, B); }",
        2,
        "what `s.scamp5_in` does with `s.A` is not known",
        "`scamp5_in(A, 3 * n + 1);`",
    );
}

/// A register that a function is given has the parts of the vendor's own class, which are compared.
#[test]
fn parts_of_registers_are_compared() {
    let file = "bool same(dreg_t a, dreg_t b) { return a.LR_bits == b.LR_bits; }
        void negated(dreg_t from) {
            if (from.LR_bits != R10.LR_bits) MOV(R10, from);
            if (!same(from, R9)) NOT(R9, from);
        }";
    let words = |text: &str| {
        let code = expand(&format!("{file} int main() {{ {text} }}"));
        code.unwrap_or_else(|it| panic!("{it:?}")).code.frame.len()
    };
    let bare = words("SET(R5);");
    let more = |text: &str| words(&format!("SET(R5); {text}")) - bare;
    assert!(more("negated(R5);") > more("negated(R10);"));
    assert_eq!(more("negated(R10);"), more("NOT(R9, R10);"));
}

/// C++ gives the variable the handle's number; a slider that the program sets is read so.
#[test]
fn sliders_and_their_handles() {
    let text = "int main() { int h = 32;\nh = vs_gui_add_slider(\"h: \", 3, 64, h, &h); scamp5_in(A, h); }";
    warned(text, "in C++ `h` becomes the number of its slider's handle");
    numbers(
        "",
        "auto s = vs_gui_add_slider(\"s: \", 0, 9, 1); vs_gui_set_slider(s, 7); scamp5_in(A, vs_gui_read_slider(s)); vs_gui_move_slider(s, 9, false); scamp5_in(A, vs_gui_read_slider(s));",
        &[7, 9],
    );
}

/// Marsaglia's sequence, of the first seed and of another.
#[test]
fn the_vendor_s_generator_draws_its_sequence() {
    // By the recurrence, in Python.
    numbers(
        "vs_random draw; vs_random other(5);",
        "scamp5_in(A, draw.get_int(-100, 100)); scamp5_in(A, draw.get_int(-100, 100)); scamp5_in(A, draw.get_int(-100, 100)); scamp5_in(A, draw.get_int(-100, 100)); for (int i = 0; i < 2; i++) scamp5_in(A, other(0, 9)); draw.reset(); scamp5_in(A, draw.get_int(-100, 100)); scamp5_in(A, draw.chance(1, 2) ? 1 : 0);",
        &DRAWN,
    );
}

const DRAWN: [i32; 8] = [6, 65, 79, -79, 4, 4, 6, 0];

/// Comments and texts may be of any encoding.
#[test]
fn code_that_is_no_utf_8_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &[u8]| fs::write(folder.path().join(name), text).unwrap();
    write("part.hpp", b"// gr\xf6\xdfer\nvoid part() { mov(A, B); }\n");
    write("p.cpp", b"#include \"part.hpp\"\n// \xb2\xe2\xca\xd4\nint main() { part(); vs_post_text(\"\xe9\"); }\n");
    let said = good(folder.path(), &["asm", "p.cpp"]);
    assert!(said.contains("A    = B"), "{said}");
}

/// Frames come as far apart as their trigger, and a loop that waits for a slider says which.
#[test]
fn frames_wait_for_their_trigger() {
    let folder = tempfile::tempdir().unwrap();
    let text = "#include \"scamp5.hpp\"\nint main() { vs_frame_trigger_set(1, 50); vs_stopwatch t; while (1) { vs_frame_loop_control(); int us = t.get_usec();\nt.reset(); scamp5_kernel_begin(); get_image(A, F); scamp5_kernel_end(); vs_post_text(\"%d\\n\", us); } }";
    fs::write(folder.path().join("p.cpp"), text).unwrap();
    let line = [
        "exec", "p.cpp", "--scene", "bundled", "--frames", "4", "--host",
    ];
    let told = good(folder.path(), &line);
    assert!(told.contains("post     20000"), "{told}");
    told_of_slider();
}

fn told_of_slider() {
    told(
        "int main() { auto go = vs_gui_add_slider(\"go\", 0, 1, 0); int v = 0;\nwhile (!v) { vs_process_message(); v = vs_gui_read_slider(go); } mov(A, B); }",
        2,
        "statements",
        "--const go=VALUE",
    );
}

/// The loop's counter, and what the program waits.
#[test]
fn the_host_counts_from_where_it_was_set_back() {
    let folder = tempfile::tempdir().unwrap();
    let text = "#include \"scamp5.hpp\"\nint main() { vs_stopwatch t; while (1) { vs_frame_loop_control(); if (vs_loop_counter_get() == 2) vs_loop_counter_reset();\nt.reset(); vs_wait(5000); int us = t.get_usec(); vs_post_text(\"%d %d\\n\", (int)vs_loop_counter_get(), us); } }";
    fs::write(folder.path().join("p.cpp"), text).unwrap();
    let told = good(
        folder.path(),
        &[
            "exec", "p.cpp", "--scene", "bundled", "--frames", "4", "--host",
        ],
    );
    assert!(told.contains("post     0 5000"), "{told}");
}

/// Errors are those of the program, warnings leave it as it is.
#[test]
fn these_warnings_are_no_errors() {
    let all = expand(
        "int main() { int h = 3; h = vs_gui_add_slider(\"h\", 0, 9, h, &h); scamp5_in(A, 200); }",
    );
    let warnings = all.unwrap().warnings;
    assert!(warnings.iter().all(|it| it.severity == Severity::Warning));
    assert!(warnings.len() >= 2);
}
