//! Kernels of vendor C++ are what the vendor's macros make of them: the block of a `static` kernel
//! runs at its first launch alone, which records its words, and that of a dynamic one at each.

mod common;
mod vendor_cpp;
use vendor_cpp::expand;

use amacrine::{
    isa::Device,
    program::{Action, Answer, Beside, Code, Includes, Overrides, Program, Step},
};

const BEGIN: &str = "scamp5_kernel_begin();";
const END: &str = "scamp5_kernel_end();";

fn own(text: &str) -> Code {
    let program = Program::parse("p.scamp", text).unwrap();
    let expansion = program.expand(&Device::scamp5(), &Overrides::new());
    expansion.unwrap().code
}

/// The words and calls of a program in order, without the lines that they came from.
fn texts(code: &Code) -> [Vec<String>; 2] {
    fn each(steps: &[Step]) -> Vec<String> {
        let device = Device::scamp5();
        let one = |step: &Step| match &step.action {
            Action::Word(word) => vec![word.text(&device)],
            Action::Host(host) => vec![host.text(&device)],
            Action::Repeat { times, body } => std::iter::repeat_n(each(body), *times as usize)
                .flatten()
                .collect(),
        };
        steps.iter().flat_map(one).collect()
    }
    [each(&code.init), each(&code.frame)]
}

/// C++ and the statements that it is; what it is warned of.
#[track_caller]
fn is(text: &str, statements: &str) -> Vec<String> {
    let expansion = expand(text).unwrap_or_else(|faults| panic!("{faults:?}\n{text}"));
    assert_eq!(texts(&expansion.code), texts(&own(statements)), "{text}");
    let warnings = expansion.warnings.into_iter();
    warnings.map(|it| it.message).collect()
}

/// Holds a program to one error, at this line.
#[track_caller]
fn refused(text: &str, line: u32, message: &str) {
    let faults = expand(text).expect_err(text).faults;
    let found = { faults.iter() }.any(|it| it.line == line && it.fault.message == message);
    assert!(found, "{text}\n{faults:#?}");
}

/// An array that gives no light and answers nothing; what was posted beside it.
#[derive(Default)]
struct Posts {
    frames: u32,
    posts: Vec<String>,
}

impl Beside for Posts {
    fn frame(&mut self) -> bool {
        let goes_on = self.frames > 0;
        self.frames = self.frames.saturating_sub(1);
        goes_on
    }

    fn run(&mut self, _: &[Step]) -> Option<Answer> {
        Some(Answer {
            value: Some(self.frames.into()),
            memory: None,
        })
    }

    fn micros(&self) -> f64 {
        0.0
    }

    fn post(&mut self, text: String) {
        self.posts.push(text);
    }
}

const CHANGED: &str = "this kernel is recorded only at its first launch, but";

/// A word after an instruction's name may turn its meaning round; a number tells forms apart.
#[test]
fn no_instruction_is_guessed_from_a_longer_name() {
    for call in [
        "SET_IF(R8, R5);",
        "MOV_NOT(R5, R6);",
        "WHERE_NOT(R5);",
        "mov_neg(A, B);",
        "add_ab(A, B, C);",
    ] {
        let text = format!(
            "int main() {{ while (1) {{ vs_frame_loop_control(); scamp5_kernel_begin(); {call} scamp5_kernel_end(); }} }}"
        );
        let faults = expand(&text).expect_err(call).faults;
        let name = call.split('(').next().unwrap();
        assert!(
            faults.iter().any(|it| it.fault.message.contains(name)),
            "{faults:?}"
        );
    }
    let text = "int main() { while (1) { vs_frame_loop_control(); scamp5_kernel_begin(); bus2_3(D, E, A); scamp5_kernel_end(); } }";
    expand(text).unwrap();
}

#[test]
fn the_block_of_a_static_kernel_runs_once() {
    let count = |begin: &str, end: &str| {
        format!(
            "int main() {{ int v = 10; for (int i = 0; i < 3; i++) {{ {begin} add(A, A, F); v += 10; {end} }}\n\
             scamp5_in(B, v); }}"
        )
    };
    let warnings = is(
        &count(BEGIN, END),
        "repeat 3 { add(A, A, F); } scamp5_in(B, 20);",
    );
    assert_eq!(warnings, [format!("{CHANGED} `v` has changed since")]);
    let dynamic = count(
        "scamp5_dynamic_kernel_begin();",
        "scamp5_dynamic_kernel_end();",
    );
    let warnings = is(&dynamic, "repeat 3 { add(A, A, F); } scamp5_in(B, 40);");
    assert_eq!(warnings, [""; 0]);
    // Each place in the text is a kernel of its own, and so is each of a macro.
    is(
        &format!(
            "#define UP {BEGIN} mov(A, B); n++; {END}\nint main() {{ int n = 0; UP UP UP scamp5_in(B, n); }}"
        ),
        "mov(A, B); mov(A, B); mov(A, B); scamp5_in(B, 3);",
    );
}

#[test]
fn a_static_kernel_keeps_its_first_words() {
    for (before, launches, own, name) in [
        (
            "void f(areg_t x) { BEGIN mov(x, B); END }",
            "f(A); f(C);",
            "mov(A, B); mov(A, B);",
            "x",
        ),
        (
            "int n = 1; void g(int k) { for (int i = 0; i < n + k; i++) { mov(A, B); } } void f() { BEGIN g(0); END }",
            "f(); n = 2; f();",
            "mov(A, B); mov(A, B);",
            "n",
        ),
        (
            "struct Way { int steps; int seen; }; Way way; void f() { way.seen++; BEGIN for (int i = 0; i < way.steps; i++) { mov(A, B); } END }",
            "way.steps = 1; f(); f(); way.steps = 3; f();",
            "mov(A, B); mov(A, B); mov(A, B);",
            "way.steps",
        ),
        (
            "struct Way { int steps; int seen; void f() { seen++; BEGIN for (int i = 0; i < steps; i++) { mov(A, B); } END } };",
            "Way way; way.seen = 0; way.steps = 1; way.f(); way.f(); way.steps = 3; way.f();",
            "mov(A, B); mov(A, B); mov(A, B);",
            "steps",
        ),
        (
            "void f(const int *p) { BEGIN if (p[1] == 1) { mov(A, B); } END }",
            "int a[2] = {1, 1}; int b[2] = {1, 1}; f(a); f(b); b[1] = 2; f(b);",
            "mov(A, B); mov(A, B); mov(A, B);",
            "p",
        ),
        (
            "template <typename T> void f(T x) { BEGIN mov(x, B); END }",
            "f(A); f(C);",
            "mov(A, B); mov(A, B);",
            "x",
        ),
    ] {
        let before = before.replace("BEGIN", BEGIN).replace("END", END);
        let text = format!("{before}\nint main() {{ {launches} }}");
        let warnings = is(&text, own);
        assert_eq!(
            warnings,
            [format!("{CHANGED} `{name}` has changed since")],
            "{text}"
        );
    }
    // What does not change is told of nowhere, nor is what the block gives a value first.
    for inside in [
        "int i; BEGIN for (i = 0; i < 2; i++) { mov(A, B); } END",
        "BEGIN int i = 0; while (i < 2) { mov(A, B); i++; } END",
        "BEGIN for (int i : {0, 1}) { mov(A, B); } END",
        "const int n = 2; BEGIN for (int i = 0; i < n; i++) { mov(A, B); } END",
        "static int last = 0; last++; BEGIN mov(A, B); mov(A, B); END",
    ] {
        let inside = inside.replace("BEGIN", BEGIN).replace("END", END);
        let text = format!("int k = 7; int main() {{ for (k = 0; k < 2; k++) {{ {inside} }} }}");
        assert_eq!(is(&text, "repeat 4 { mov(A, B); }"), [""; 0], "{text}");
    }
    // Each instance of a template has a kernel of its own.
    let text = format!(
        "template <int N> void f() {{ {BEGIN} for (int i = 0; i < N; i++) {{ mov(A, B); }} {END} }}\n\
         int main() {{ f<1>(); f<2>(); f<1>(); }}"
    );
    assert_eq!(is(&text, "repeat 4 { mov(A, B); }"), [""; 0]);
}

#[test]
fn what_changes_from_frame_to_frame_is_recorded_in_the_first() {
    let text = format!(
        "int main() {{ int n = 1; while (1) {{ vs_frame_loop_control(); get_image(A, F);\n\
         {BEGIN} for (int i = 0; i < n; i++) {{ mov(B, A); }} {END} n++; }} }}"
    );
    let warnings = is(&text, "frame { get_image(A, F); mov(B, A); }");
    assert!(
        warnings.contains(&format!("{CHANGED} `n` has changed since")),
        "{warnings:?}"
    );
    // One that is launched in the second frame first keeps the words of that.
    let text = format!(
        "int main() {{ int n = 1; bool late = false; while (1) {{ vs_frame_loop_control(); get_image(A, F);\n\
         if (late) {{ {BEGIN} for (int i = 0; i < n; i++) {{ mov(B, A); }} {END} }} n++; late = true; }} }}"
    );
    is(
        &text,
        "init { get_image(A, F); } frame { get_image(A, F); mov(B, A); mov(B, A); }",
    );
    // Beside the array as well.
    let mut array = Posts {
        frames: 3,
        posts: Vec::new(),
    };
    let text = format!(
        "int main() {{ int n = 0; while (1) {{ vs_frame_loop_control();\n\
         {BEGIN} mov(A, B); n++; {END} vs_post_text(\"%d\", n); }} }}"
    );
    let program = Program::read("p.cpp", &text);
    program
        .run_beside(&Device::scamp5(), &Overrides::new(), &mut array)
        .unwrap();
    assert_eq!(array.posts, ["1", "1", "1"]);
}

#[test]
fn a_kernel_is_a_block() {
    is(
        &format!(
            "int main() {{ const int n = 5; {BEGIN} const int n = 1; for (int i = 0; i < n; i++) {{ mov(A, B); }} {END}\n\
             {BEGIN} const int n = 2; for (int i = 0; i < n; i++) {{ mov(B, A); }} {END} scamp5_in(C, n); }}"
        ),
        "mov(A, B); mov(B, A); mov(B, A); scamp5_in(C, 5);",
    );
    // It ends with it.
    refused(
        &format!("int main() {{\n{BEGIN} const int k = 2; mov(A, B); {END}\nscamp5_in(C, k);\n}}"),
        3,
        "`k` is not declared",
    );
    // A block is one statement.
    is(
        &format!(
            "int main() {{ int c = 0;\nif (c)\n{BEGIN} mov(A, B); mov(B, A); {END}\n\
             for (int i = 0; i < 2; i++)\n{BEGIN} mov(C, B); mov(B, A); {END}\n\
             if (!c) {BEGIN} neg(C, B); {END} }}"
        ),
        "repeat 2 { mov(C, B); mov(B, A); } neg(C, B);",
    );
    // Without a `;`, which the macros do not need.
    is(
        "int main() { scamp5_kernel_begin() mov(A, B); scamp5_kernel_end() scamp5_in(C, 1); }",
        "mov(A, B); scamp5_in(C, 1);",
    );
}

#[test]
fn the_host_is_done_once_before_the_words() {
    let text = format!(
        "int main() {{ for (int i = 0; i < 2; i++) {{ {BEGIN} mov(A, B); scamp5_in(C, 5); mov(B, C); {END} }} }}"
    );
    let warnings = is(
        &text,
        "scamp5_in(C, 5); mov(A, B); mov(B, C); mov(A, B); mov(B, C);",
    );
    assert_eq!(warnings, ["`scamp5_in` inside a kernel"]);
    // Of one that is recorded at each launch, each time.
    let text = text.replace("scamp5_kernel", "scamp5_dynamic_kernel");
    is(
        &text,
        "scamp5_in(C, 5); mov(A, B); mov(B, C); scamp5_in(C, 5); mov(A, B); mov(B, C);",
    );
}

#[test]
fn where_a_kernel_begins_and_ends() {
    let text = |inside: &str| {
        format!("void f() {{ {BEGIN} mov(A, B); {END} }}\nint main() {{\n{inside}\n}}")
    };
    for (inside, line, message) in [
        (
            "BEGIN\nmov(A, B);\nBEGIN mov(B, A); END END",
            5,
            "a kernel inside a kernel",
        ),
        ("BEGIN\nf();\nEND", 1, "a kernel inside a kernel"),
        (
            "if (1) {\nBEGIN mov(A, B); } END",
            4,
            "this kernel has no end",
        ),
        ("BEGIN if (1) {\nEND }", 4, "this ends no kernel"),
        (
            "BEGIN mov(A, B);\nscamp5_dynamic_kernel_end();",
            4,
            "this ends another sort of kernel",
        ),
        (
            "int x = 1 +\nscamp5_kernel_begin(); mov(A, B);",
            4,
            "`scamp5_kernel_begin` is used inside an expression",
        ),
        (
            "for (int i = 0; i < 3; i++) {\nBEGIN mov(A, B); break; END }",
            4,
            "this kernel is left before its end",
        ),
        (
            "\nBEGIN mov(A, B); return; END",
            4,
            "this kernel is left before its end",
        ),
        (
            "\nBEGIN while (1) { vs_frame_loop_control(); mov(A, B); } END",
            4,
            "this kernel is left before its end",
        ),
    ] {
        let inside = inside.replace("BEGIN", BEGIN).replace("END", END);
        refused(&text(&inside), line, message);
    }
    // What is left inside it is its own affair.
    is(
        &text("BEGIN for (int i = 0; i < 9; i++) { if (i == 2) break; mov(A, B); } END")
            .replace("BEGIN", BEGIN)
            .replace("END", END),
        "mov(A, B); mov(A, B);",
    );
}

/// The words that a program takes in the store, or why it does not fit.
fn store(text: &str) -> Result<u64, String> {
    let device = Device::scamp5();
    match expand(text) {
        Ok(expansion) => Ok(expansion.stored(&device).0),
        Err(faults) => Err(faults.faults[0].fault.message.clone()),
    }
}

#[test]
fn a_dynamic_kernel_gives_its_room_back() {
    // 20 words each.
    let body = "mov(A, B); ".repeat(10);
    let dynamic = format!("scamp5_dynamic_kernel_begin(); {body} scamp5_dynamic_kernel_end();\n");
    let text = |inside: &str| format!("int main() {{\n{inside}}}");
    assert_eq!(store(&text(&dynamic.repeat(100))), Ok(20));
    // Those that are static stay, and beside them the largest of the others.
    let fixed = format!("{BEGIN} {body} {END}\n");
    assert_eq!(
        store(&text(&(dynamic.repeat(60) + &fixed.repeat(2)))),
        Ok(60)
    );
    let refused = store(&text(&(dynamic.repeat(2) + &fixed.repeat(51)))).unwrap_err();
    assert!(
        refused.contains("has 1040 instruction words, 16 more than"),
        "{refused}"
    );
    // What is recorded anew with other words takes no more room than the longer.
    let grows = format!(
        "for (int i = 1; i < 4; i++) {{ scamp5_dynamic_kernel_begin(); for (int k = 0; k < i; k++) {{ {body} }} scamp5_dynamic_kernel_end(); }}\n"
    );
    assert_eq!(store(&text(&grows)), Ok(60));
    // Two kernels of one macro are two, of the same words too.
    let two =
        format!("#define TWO {BEGIN} {body} {END} {BEGIN} {body} {END}\nint main() {{ TWO }}");
    assert_eq!(store(&two), Ok(40));
}

#[test]
fn what_is_moved_to_the_heap_is_not_in_the_store() {
    let body = "mov(A, B); ".repeat(520);
    let text = format!(
        "int main() {{ {BEGIN} move_to_heap(true); {body} {END} {BEGIN} mov(B, A); {END} }}"
    );
    assert_eq!(store(&text), Ok(2));
    assert!(store(&text.replace("true", "false")).is_err());
    let object = format!(
        "int main() {{ scamp5_kernel k([&] {{ move_to_heap(true); {body} }}); scamp5_launch_kernel(k); }}"
    );
    assert_eq!(store(&object), Ok(0));
    refused(
        "int main() {\nmove_to_heap(true); mov(A, B); }",
        2,
        "`move_to_heap` outside of a kernel",
    );
}

#[test]
fn an_object_records_once() {
    let text = "int main() { scamp5_kernel k; scamp5_in(D, k.null());\n\
                k([&] { neg(C, A); }); k();\n\
                k([&] { mov(C, A); }); k(); scamp5_in(D, k.null()); }";
    let warnings = is(
        text,
        "scamp5_in(D, 1); neg(C, A); neg(C, A); scamp5_in(D, 0);",
    );
    assert_eq!(warnings, ["this kernel is already recorded, in line 2"],);
    // One that was made with words as well, and one that is made again has none.
    let text = "int main() { for (int i = 0; i < 2; i++) { scamp5_kernel k([&] { if (i == 0) { neg(C, A); } else { mov(C, A); } });\n\
                k(); k([&] { mov(A, B); }); scamp5_launch_kernel(k); } }";
    let warnings = is(text, "neg(C, A); neg(C, A); mov(C, A); mov(C, A);");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    // Where one place gives it other words, it says of what they are.
    let text = "int main() { scamp5_kernel k; for (int n = 1; n < 3; n++) {\n\
                k([&] { for (int i = 0; i < n; i++) { mov(A, B); } }); k(); } }";
    let warnings = is(text, "mov(A, B); mov(A, B);");
    assert_eq!(warnings, [format!("{CHANGED} `n` has changed since")]);
    // In it the host is done once, before.
    let text = "int main() { scamp5_kernel k([&] { mov(A, B); scamp5_in(B, 1); }); k(); k(); }";
    is(text, "scamp5_in(B, 1); mov(A, B); mov(A, B);");
}

#[test]
fn what_a_kernel_reads_is_read_while_it_is_recorded() {
    // The host reads 3 before the words run, and decides what is recorded.
    let mut array = Posts {
        frames: 3,
        posts: Vec::new(),
    };
    let text = format!(
        "int main() {{ while (1) {{ vs_frame_loop_control(); int n = -1;\n\
         {BEGIN} n = scamp5_global_or(R5); if (n) {{ SET(R5); }} {END} vs_post_text(\"%d\", n); }} }}"
    );
    let program = Program::read("p.cpp", &text);
    program
        .run_beside(&Device::scamp5(), &Overrides::new(), &mut array)
        .unwrap();
    assert_eq!(array.posts, ["2", "-1", "-1"]);
    // Where the words have to be known before, that is all there is to say.
    let mut faults = expand(&text).unwrap_err().faults;
    faults.retain(|it| it.fault.is_error());
    assert_eq!(faults.len(), 1, "{faults:#?}");
    assert!(
        faults[0]
            .fault
            .message
            .starts_with("whether this kernel runs depends on what `scamp5_global_or`")
    );
}

#[test]
fn a_function_with_the_name_of_a_word_is_the_files_own() {
    let text = format!(
        "void sub(AREG y, AREG a, AREG b) {{ {BEGIN}\nsub(y, a, b); {END} }}\nint main() {{ sub(A, B, C); }}"
    );
    refused(
        &text,
        2,
        "`sub` is here a function of this file, which begins a kernel inside a kernel",
    );
}

/// What a program is warned of: the messages with their help, of the lines on which they stand.
#[track_caller]
fn warned(text: &str, set: &[(&str, f64)]) -> Vec<(usize, String, String)> {
    let overrides: Overrides = { set.iter() }
        .map(|(name, value)| ((*name).to_owned(), *value))
        .collect();
    let program = Program::read("p.cpp", text);
    let expansion = program
        .expand(&Device::scamp5(), &overrides)
        .unwrap_or_else(|faults| panic!("{faults:?}\n{text}"));
    let line = |start: usize| text[..start].matches('\n').count() + 1;
    let warnings = expansion.warnings.into_iter();
    warnings
        .map(|it| {
            (
                line(it.place.start),
                it.message,
                it.help.unwrap_or_default(),
            )
        })
        .collect()
}

#[test]
fn kernels_that_never_run_are_named_with_what_would_run_them() {
    let text = format!(
        "const int trig = 0; int other = 0;\n\
         void unused() {{ {BEGIN} mov(A, B);\nbogus(B, C); {END} }}\n\
         int main() {{ vs_on_gui_update(1, [&](int32_t v) {{\n{BEGIN} mov(A, B);\nmov(R77, B); {END} }});\n\
         if (trig) {{\n{BEGIN} mov(A, B);\nmov(Q, B); {END} }}\n\
         {BEGIN} res(A); {END} }}"
    );
    let all = warned(&text, &[]);
    let told = |line: usize, message: &str| {
        assert!(
            all.iter().any(|it| it.0 == line && it.1 == message),
            "{message}: {all:#?}"
        );
    };
    told(3, "unknown statement `bogus`, in a kernel that never runs");
    told(6, "`R77` is not declared, in a kernel that never runs");
    told(9, "`Q` is not declared, in a kernel that never runs");
    told(2, "3 kernels never run");
    assert_eq!(all.len(), 4, "{all:#?}");
    let list = all.iter().find(|it| it.1 == "3 kernels never run").unwrap();
    assert_eq!(
        list.2,
        "line 2 (in `unused`, which nothing calls), line 5 (when somebody acts at the GUI), line 8 (`--const trig=1`)"
    );
    // A register or a text is not set from outside; what is called with another argument is named.
    let text = format!(
        "void f(DREG r, int n) {{\nif (r == R6) {{\n{BEGIN} res(A); {END} }}\nif (n > 3) {{\n{BEGIN} res(A); {END} }} }} std::string s = \"a\"; int main() {{ f(R5, 1);\nif (s == \"b\") {{\n{BEGIN} res(A); {END} }}\n{BEGIN} res(B); {END} }}"
    );
    let all = warned(&text, &[]);
    assert_eq!(
        all[0].2,
        "line 3 (by a call of `f` with another `r`), line 5 (by a call of `f` with another `n`), line 7 (behind a condition)"
    );
    // It runs then, and is held to what every kernel is held to.
    let text = format!(
        "const int trig = 0; int main() {{ if (!trig) {{\n{BEGIN} res(A); {END} }} else {{\n{BEGIN} res(B); {END} }} }}"
    );
    assert_eq!(warned(&text, &[])[0].0, 3);
    assert_eq!(warned(&text, &[("trig", 1.0)])[0].0, 2);
    let wrong = text.replace("res(B)", "bogus(B)");
    let overrides: Overrides = [("trig".to_owned(), 1.0)].into();
    let program = Program::read("p.cpp", &wrong);
    assert!(program.expand(&Device::scamp5(), &overrides).is_err());
    // A variable of a function can be set as well.
    let text = format!(
        "int main() {{ int c = 0; int d = 7; if (c == 2) {{ for (int i = 0; i < d; i++) {{\n{BEGIN} mov(A, B); {END} }} }} {BEGIN} res(A); {END} }}"
    );
    assert_eq!(warned(&text, &[])[0].2, "line 2 (`--const c=VALUE`)");
    // What a header has and nothing calls is no matter, but for words that nobody has.
    let header = format!(
        "void f() {{ {BEGIN} mov(A, B); {END} }} void g() {{ {BEGIN} bogus(A, B); {END} }}"
    );
    let mut includes = Includes::new();
    includes.insert("a.hpp".to_owned(), header.into());
    let text = "#include \"a.hpp\"\nint main() { f(); }";
    let program = Program::read_with("p.cpp", text, &includes);
    let expansion = program
        .expand(&Device::scamp5(), &Overrides::new())
        .unwrap();
    assert_eq!(expansion.warnings.len(), 1, "{:#?}", expansion.warnings);
    assert!(
        expansion.warnings[0]
            .message
            .contains("unknown statement `bogus`")
    );
}

#[test]
fn registers_that_nothing_writes_are_named_as_they_are_written() {
    let frame = |inside: &str| {
        format!(
            "int main() {{ auto d = vs_gui_add_display(\"d\", 0, 0); while (1) {{ vs_frame_loop_control();\n{inside}\n}} }}"
        )
    };
    for (inside, name) in [
        ("scamp5_output_image(S2, d);", "S2"),
        ("scamp5_output_image(D, d);", "D"),
        ("mov(C, B);", "B"),
        ("MOV(R6, RF);", "RF"),
    ] {
        let all = warned(&frame(inside), &[]);
        let want = format!("nothing in this program writes {name}: it is 0 everywhere");
        assert!(matches!(&all[..], [(2, it, _)] if *it == want), "{all:#?}");
    }
    assert_eq!(warned(&frame("get_image(B, F); mov(C, B);"), &[]), []);
    // A line that is refused may have written it.
    let text = frame("scamp5_load_region(S5, \"1\", 2, 3, 4);\nscamp5_output_image(S5, d);");
    let text = text.replace("while (1)", "scamp5_in(A, 1); while (1)");
    let faults = expand(&text).unwrap_err().faults;
    assert_eq!(faults.len(), 1, "{faults:#?}");
}

#[test]
fn warnings_of_an_included_file_name_it() {
    let header = format!("void f() {{\n{BEGIN} where(A);\nmov2x(B, A, east, north); {END}\n}}");
    let mut includes = Includes::new();
    includes.insert("a.hpp".to_owned(), header.into());
    let text = "#include \"a.hpp\"\nint main() { f(); }";
    let program = Program::read_with("p.cpp", text, &includes);
    let warnings = program
        .expand(&Device::scamp5(), &Overrides::new())
        .unwrap()
        .warnings;
    let [one] = &warnings[..] else {
        panic!("{warnings:#?}");
    };
    assert_eq!(
        one.message,
        "a.hpp:3:1: `mov2x` needs FLAG to be 1 in all pixels, but it may be 0 in some, since `where` in a.hpp:2"
    );
}
