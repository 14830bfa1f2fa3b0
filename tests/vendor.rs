//! Programs as the vendor has them: every construct of C++ that such programs are made of gives
//! the words that the frame language gives, what is not understood is named with its line, all at
//! once, and a program that is written as C++ reads back as the same instructions.

mod common;

use std::{fs, path::Path};

use amacrine::{
    compile::{CellKind, DriveMemory, Effort, Request, SensorProgram},
    config::Faults,
    isa::Device,
    kernel::Kernel,
    program::{
        Action, Code, Expansion, Host, Includes, Overrides, Program, Step, cpp, included, stored,
    },
};
use common::{good, json, refused};

fn expand(text: &str, set: &[(&str, f64)]) -> Result<Expansion, Faults> {
    let overrides: Overrides = set
        .iter()
        .map(|(name, v)| ((*name).to_owned(), *v))
        .collect();
    Program::read("p.cpp", text).expand(&Device::scamp5(), &overrides)
}

fn cpp_code(text: &str) -> Code {
    bare(
        expand(text, &[])
            .unwrap_or_else(|faults| panic!("{faults:?}\n{text}"))
            .code,
    )
}

/// Without the lines that they came from.
fn bare(code: Code) -> Code {
    fn steps(all: Vec<Step>) -> Vec<Step> {
        all.into_iter()
            .map(|step| Step {
                action: match step.action {
                    Action::Repeat { times, body } => Action::Repeat {
                        times,
                        body: steps(body),
                    },
                    other => other,
                },
                line: 0,
                origin: None,
            })
            .collect()
    }
    Code {
        init: steps(code.init),
        frame: steps(code.frame),
    }
}

fn own_code(text: &str) -> Code {
    let program = Program::parse("p.scamp", text).unwrap();
    bare(
        program
            .expand(&Device::scamp5(), &Overrides::new())
            .unwrap()
            .code,
    )
}

/// C++ inside of `main` and a loop over the frames, and the statements that it is.
#[track_caller]
fn same(inside: &str, own: &str) {
    let text = format!(
        "#include <scamp5.hpp>\nusing namespace SCAMP5_PE;\nint main() {{ vs_init();\n\
         while (1) {{ vs_frame_loop_control();\n{inside}\n}} return 0; }}"
    );
    assert_eq!(cpp_code(&text), own_code(own), "{inside}");
}

/// Whole C++, and the statements that it is.
#[track_caller]
fn whole(text: &str, own: &str) {
    assert_eq!(cpp_code(text), own_code(own), "{text}");
}

const BEGIN: &str = "scamp5_kernel_begin();";
const END: &str = "scamp5_kernel_end();";

#[test]
fn kernels_and_calls_of_the_host() {
    same(
        &format!(
            "{BEGIN} get_image(A, F); where(A); MOV(S0, FLAG); all(); {END} scamp5_in(B, -3);"
        ),
        "get_image(A, F); where(A); MOV(R5, FLAG); all(); scamp5_in(B, -3);",
    );
    same(
        "scamp5_dynamic_kernel_begin(); add(A, B, C); scamp5_dynamic_kernel_end();",
        "add(A, B, C);",
    );
    same("bus({A, B}, {C, D});", "bus({A, B}, {C, D});");
    // The older form stores into the pixel's own NEWS, unlike `subx`.
    same("sub(C, B, west, A);", "bus(NEWS, B); bus(C, XW, A);");
    same(
        "scamp5_load_region(R5, 1, 2, 3, 4);",
        "scamp5_load_rect(R5, 1, 2, 3, 4);",
    );
    same("scamp5_shift(R5, -2, 1, 0, 4);", "scamp5_shift(R5, -2, 1);");
    // Ones come in at the edge.
    same(
        "scamp5_shift(R5, -2, 1, true, 4);",
        "scamp5_shift(R5, -2, 1, 1);",
    );
    same(
        "scamp5_diffuse(A, 5, true, false);",
        "scamp5_diffuse(A, 5, 1, 0);",
    );
}

#[test]
fn constants_and_arithmetic_are_those_of_cpp() {
    same("int y = 7; scamp5_in(A, y / 2);", "scamp5_in(A, 3);");
    same("scamp5_in(A, 7.0 / 2 + 0.5);", "scamp5_in(A, 4);");
    same(
        "uint8_t b = 250; b += 10; scamp5_in(A, (int)b % 100);",
        "scamp5_in(A, 4);",
    );
    same(
        "scamp5_load_pattern(R5, 0, 0, 0b1100, 0x1F);",
        "scamp5_load_pattern(R5, 0, 0, 12, 31);",
    );
    same(
        "scamp5_in(A, (1 << 3) | 1); scamp5_in(B, ~0 & 6);",
        "scamp5_in(A, 9); scamp5_in(B, 6);",
    );
    same(
        "scamp5_in(A, 3 > 2 ? std::max(4, 5) : 0);",
        "scamp5_in(A, 5);",
    );
    same(
        "int x = -4; if (abs(x) > 3) scamp5_in(A, abs(x));",
        "scamp5_in(A, 4);",
    );
    same(
        "enum { A0, B0 = 4, C0 }; scamp5_in(A, C0);",
        "scamp5_in(A, 5);",
    );
    same(
        "int a[2][3] = {{1, 2, 3}, {4, 5}}; a[1][0]++; scamp5_in(A, a[1][0] + a[1][2]);",
        "scamp5_in(A, 5);",
    );
    same(
        "int v = 1; int &w = v; w = 6; int *p = &v; *p += 1; scamp5_in(A, v);",
        "scamp5_in(A, 7);",
    );
}

/// C++ that loads numbers into `A`, and the numbers.
#[track_caller]
fn numbers(inside: &str, all: &[i32]) {
    numbers_with("", inside, all);
}

/// The same, with what stands before `main`.
#[track_caller]
fn numbers_with(before: &str, inside: &str, all: &[i32]) {
    let text = format!("{before}\nint main() {{ {inside} }}");
    let own: Vec<String> = all.iter().map(|n| format!("scamp5_in(A, {n});")).collect();
    assert_eq!(cpp_code(&text), own_code(&own.join(" ")), "{text}");
}

/// The messages of C++ that is refused.
#[track_caller]
fn messages(text: &str) -> Vec<String> {
    let faults = expand(text, &[]).expect_err(text).faults;
    faults.into_iter().map(|it| it.fault.message).collect()
}

/// C++ inside of `main` that is refused, for one reason.
#[track_caller]
fn refused_for(inside: &str, reason: &str) {
    let all = messages(&format!("int main() {{ {inside} }}"));
    assert!(
        matches!(&all[..], [one] if one.contains(reason)),
        "{inside}: {all:?}"
    );
}

#[test]
fn a_variable_keeps_its_width() {
    numbers(
        "uint8_t b = 255; b++; scamp5_in(A, b); b--; scamp5_in(A, b == 255); b += 10; scamp5_in(A, b);",
        &[0, 1, 9],
    );
    numbers(
        "uint16_t x = 0; x--; scamp5_in(A, x == 65535); int8_t y = 127; y++; scamp5_in(A, y);",
        &[1, -128],
    );
    numbers(
        "uint8_t a[2] = {250, 1}; a[0] += 10; a[1] = 300; scamp5_in(A, a[0]); scamp5_in(A, a[1]);",
        &[4, 44],
    );
    numbers(
        "uint8_t b; int c = (b = 300); scamp5_in(A, c); bool f; f = 7; scamp5_in(A, f);",
        &[44, 1],
    );
    numbers(
        "unsigned y = 1; y -= 2; scamp5_in(A, y == 4294967295u); scamp5_in(A, (y - 2) / 2 > 5);",
        &[1, 1],
    );
    numbers(
        "scamp5_in(A, (1 << 31) < 0); scamp5_in(A, -1 < 1u); scamp5_in(A, 0xFFFFFFFF == -1);",
        &[1, 0, 1],
    );
    numbers(
        "long l = 1; l <<= 40; scamp5_in(A, l >> 38); uint64_t u = 0; u--; scamp5_in(A, u >> 60);",
        &[4, 15],
    );
    numbers(
        "int n = 0; for (uint8_t i = 3; i < 4; i--) n++; scamp5_in(A, n);",
        &[4],
    );
    numbers(
        "typedef uint8_t byte; using word = uint16_t; byte b = 250; b += 10; word w = 0; w--;\n\
         scamp5_in(A, b); scamp5_in(A, w == 65535);",
        &[4, 1],
    );
    numbers(
        "unsigned char c = 256; unsigned short s = 65537; long double x = 2.5; unsigned long y = 3;\n\
         scamp5_in(A, c); scamp5_in(A, s); scamp5_in(A, (int)x); scamp5_in(A, y);",
        &[0, 1, 2, 3],
    );
    // So do parameters, and what a function gives back.
    numbers_with(
        "uint8_t r8(int x) { return x; }\nint half(float x) { return x / 2; }\nint p(uint8_t x = 300) { x -= 45; return x; }",
        "scamp5_in(A, r8(300)); scamp5_in(A, half(5)); scamp5_in(A, p(256)  == 211); scamp5_in(A, p() == 255);",
        &[44, 2, 1, 1],
    );
    refused_for("scamp5_in(A, 1 << 32);", "1 << 32 is undefined");
}

#[test]
fn a_target_is_found_once() {
    numbers(
        "int t[4] = {10, 20, 30, 40}; int i = 0; while (i < 4) t[i++] /= 10;\n\
         for (int k = 0; k < 4; k++) scamp5_in(A, t[k]);",
        &[1, 2, 3, 4],
    );
    numbers(
        "int a[3] = {0, 0, 0}; int n = 0; auto next = [&]() { return n++; }; a[next()]++; a[n++] += 5;\n\
         scamp5_in(A, a[0]); scamp5_in(A, a[1]); scamp5_in(A, n);",
        &[1, 5, 2],
    );
    numbers_with(
        "int all[2] = {1, 2}; int at = 0;\nint *cur() { return &all[at++]; }",
        "*cur() += 10; *cur() *= 3; scamp5_in(A, all[0]); scamp5_in(A, all[1]); scamp5_in(A, at);",
        &[11, 6, 2],
    );
    numbers("int i = 1; (++i) += 3; scamp5_in(A, i);", &[5]);
}

#[test]
fn references_are_the_elements_themselves() {
    numbers_with(
        "void f(int &x) { x += 3; }\nvoid sw(int &a, int &b) { int t = a; a = b; b = t; }",
        "int a[3] = {1, 2, 3}; f(a[1]); scamp5_in(A, a[1]); int &r = a[1]; r = 9; scamp5_in(A, a[1]);\n\
         for (auto &x : a) x *= 2; scamp5_in(A, a[2]); for (auto x : a) x = 0; scamp5_in(A, a[2]);\n\
         sw(a[0], a[2]); scamp5_in(A, a[0]); std::swap(a[0], a[2]); scamp5_in(A, a[0]);\n\
         int p = 1, q = 2; std::swap(p, q); scamp5_in(A, p); scamp5_in(A, q);",
        &[5, 9, 6, 6, 6, 2, 2, 1],
    );
    numbers(
        "int m[2][2] = {1, 2, 3, 4}; for (auto &row : m) for (int &x : row) x++; scamp5_in(A, m[1][0]);",
        &[4],
    );
}

#[test]
fn pointers_count_elements() {
    numbers(
        "int w[3] = {1, 2, 3}; int *t = w; int s = 0; for (int i = 0; i < 3; i++) s += *t++;\n\
         scamp5_in(A, s); scamp5_in(A, w[0]); scamp5_in(A, t - w); *w = 8; scamp5_in(A, w[0]);",
        &[6, 1, 3, 8],
    );
    numbers(
        "int a[2][3] = {1, 2, 3, 4, 5, 6}; scamp5_in(A, *(*(a + 1) + 1)); int *q = a[1]; q[2] = 9;\n\
         scamp5_in(A, a[1][2]); scamp5_in(A, *q);",
        &[5, 9, 4],
    );
    numbers(
        "int w[3] = {1, 2, 3}; int *e = w + 3; int n = 0; for (int *p = w; p != e; ++p) n += *p;\n\
         scamp5_in(A, n); int *p = w, x = 5; p++; scamp5_in(A, *p + x);",
        &[6, 7],
    );
    numbers(
        "uint8_t *p = new uint8_t[8192]; p[3] = 300; scamp5_in(A, p[3]); delete[] p;",
        &[44],
    );
    // Pointers to whole arrays, as weights are passed.
    numbers_with(
        "const int8_t w[2][1][3] = {{{1, -2, 3}}, {{4, 5, -6}}};\n\
         void load(int size, const void *given) {\n\
         int8_t (*w)[2][1][size] = (int8_t (*)[2][1][size]) (given);\n\
         for (int n = 0; n < 2; n++) scamp5_in(A, (*w)[n][0][size - 1]); }",
        "load(3, w); int v[2] = {7, 8}; int (*q)[2] = &v; (*q)[1] = 9; scamp5_in(A, v[1]); scamp5_in(A, (*q)[0]);\n\
         int m[2][2] = {{1, 2}, {3, 4}}; auto sum = [](int (*r)[2], int n) { return r[1][0] + n; };\n\
         scamp5_in(A, sum(m, 10));",
        &[3, -6, 9, 7, 13],
    );
}

#[test]
fn overloads_are_chosen_by_their_arguments() {
    numbers_with(
        "void clear(areg_t r) { scamp5_in(r, 1); }\nvoid clear(dreg_t r) { scamp5_in(A, 2); }\n\
         void load(areg_t r, int v) { scamp5_in(r, 3); }\nvoid load(areg_t r, float v) { scamp5_in(r, 4); }\n\
         void load(areg_t r, bool v) { scamp5_in(r, 5); }",
        "clear(A); clear(R5); load(A, 1); load(A, 1.5f); load(A, 1 < 2); load(A, true); uint8_t b = 1; load(A, b);",
        &[1, 2, 3, 4, 5, 5, 3],
    );
    let functions = "void f(int a, float b) { nop(); }\nvoid f(float a, int b) { nop(); }\n\
                     void g(areg_t x) { nop(); }\nvoid g(areg_t x, int n) { nop(); }\nvoid g(int x) { nop(); }\n";
    for (call, reason) in [
        ("f(1, 2);", "the call of `f` is ambiguous"),
        ("g(R5);", "no overload of `g` takes these arguments"),
    ] {
        let all = messages(&format!("{functions}int main() {{ {call} }}"));
        assert!(matches!(&all[..], [one] if one == reason), "{all:?}");
    }
}

#[test]
fn initialisers_have_the_forms_of_cpp() {
    numbers(
        "int q{7}; int z(8); const int w = {9}; uint8_t e{}; auto k(3); scamp5_in(A, q); scamp5_in(A, z);\n\
         scamp5_in(A, w); scamp5_in(A, e); scamp5_in(A, k); scamp5_in(A, unsigned(2)); scamp5_in(A, int{1});",
        &[7, 8, 9, 0, 3, 2, 1],
    );
    same("areg_t r(B); areg_t q{C}; mov(r, q);", "mov(B, C);");
    // Inner braces may be left out.
    numbers(
        "int a[2][3] = {1, 2, 3, 4, 5, 6}; scamp5_in(A, a[1][0]); int b[][2] = {1, 2, {3, 4}, 5};\n\
         scamp5_in(A, b[1][1]); scamp5_in(A, b[2][0]); scamp5_in(A, b[2][1]);",
        &[4, 4, 5, 0],
    );
    numbers(
        "std::array<int, 3> w{{4, 5, 6}}; auto c = w; c[0] = 9; scamp5_in(A, w[0]); scamp5_in(A, c[0]);\n\
         std::vector<int> z(3, 7); z.push_back(1); scamp5_in(A, z[2]); scamp5_in(A, z.size());\n\
         std::array<std::array<int, 2>, 2> m{{{1, 2}, {3, 4}}}; scamp5_in(A, m[1][0]);",
        &[4, 9, 7, 4, 3],
    );
    numbers(
        "int c[2][2][2] = {{{1, 2}, {3, 4}}}; scamp5_in(A, c[0][1][0]); scamp5_in(A, c[1][0][0]);",
        &[3, 0],
    );
    refused_for("int a[2] = {1, 2, 3}; nop();", "1 value too many");
    refused_for("int a = {1, 2}; nop();", "2 values for one variable");
    // An array is no number.
    refused_for(
        "int a[2] = {1, 2}; scamp5_in(A, a);",
        "`scamp5_in` does not take `a`",
    );
    refused_for(
        "scamp5_in(A, \"text\");",
        "`scamp5_in` does not take a text",
    );
}

/// An array inside of another is passed as a pointer to its first row.
#[test]
fn pointers_into_arrays_of_arrays() {
    numbers_with(
        "const int W[2][2][3] = {{{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}, {10, 11, 12}}};\n\
         int at(const int w[2][3]) { return w[1][0]; }\nint of(const int w[][3]) { return w[1][2]; }\n\
         struct L { int w[2][3]; };\nvoid set(int w[2][3]) { w[1][0] = 5; }",
        "scamp5_in(A, at(W[1])); int s = 0; for (auto &w : W) s += of(w); scamp5_in(A, s); auto &k = W[1];\n\
         scamp5_in(A, of(k)); L l; l.w[1][2] = 9; scamp5_in(A, of(l.w)); int t[2][2][3] = {}; set(t[1]);\n\
         scamp5_in(A, t[1][1][0]); scamp5_in(A, t[1][0][1]);",
        &[10, 18, 12, 9, 5, 0],
    );
    // Rows lie one behind the other.
    numbers_with(
        "const int W[2][4] = {{1, 2, 3, 4}, {5, 6, 7, 8}};",
        "const int (*q)[4] = W; scamp5_in(A, q[1][0]); const int *p = &W[0][0]; scamp5_in(A, p[6]); p += 5;\n\
         scamp5_in(A, *p); int (*r)[4] = &W[1]; scamp5_in(A, (*r)[2]);",
        &[5, 7, 6, 7],
    );
    numbers_with(
        "int last(int (&a)[3]) { return a[2]; }\n\
         template <class T, int N> int all(const T (&a)[N]) { return N + a[0]; }\ntypedef int8_t Kernel[2][2];",
        "int a[3] = {10, 20, 30}; int (&t)[3] = a; t[1] = 70; scamp5_in(A, a[1]); scamp5_in(A, last(a));\n\
         scamp5_in(A, all(a)); Kernel k = {{1, 2}, {3, -4}}; scamp5_in(A, k[1][1]);",
        &[70, 30, 13, -4],
    );
}

/// What the language's library does with arrays is done, or not known any more.
#[test]
fn algorithms_change_what_they_are_given() {
    numbers(
        "std::vector<int> v = {30, 10, 20}; std::reverse(v.begin(), v.end()); scamp5_in(A, v[2]);\n\
         std::sort(v.begin(), v.end()); scamp5_in(A, v[2]); int w[4] = {1, 2, 3, 4};\n\
         std::copy(v.begin(), v.end(), w + 1); scamp5_in(A, w[3]); int sum = 0;\n\
         std::for_each(w, w + 4, [&](int x) { sum += x; }); scamp5_in(A, sum); std::rotate(w, w + 1, w + 4);\n\
         scamp5_in(A, w[3]); std::iota(w, w + 4, 10); scamp5_in(A, w[2]); std::fill_n(w, 2, 7);\n\
         scamp5_in(A, w[1]); std::transform(w, w + 4, w, [](int x) { return x / 2; }); scamp5_in(A, w[3]);\n\
         std::iter_swap(w, w + 3); scamp5_in(A, w[0]); scamp5_in(A, *std::max_element(w, w + 4));\n\
         scamp5_in(A, std::accumulate(std::begin(w), std::end(w), 100));",
        &[30, 30, 30, 61, 1, 12, 7, 6, 6, 6, 118],
    );
    numbers(
        "std::vector<int> v(3); v.resize(7); scamp5_in(A, v.size()); v.assign(2, 40); scamp5_in(A, v[1]);\n\
         v.insert(v.begin(), 5); scamp5_in(A, v[0]); v.erase(v.begin() + 1); scamp5_in(A, v.size());\n\
         std::vector<int> w = {1, 2, 3}; v.swap(w); scamp5_in(A, v.size()); std::deque<int> d = {1, 2};\n\
         d.push_front(9); d.pop_back(); scamp5_in(A, d[0] + d.size());",
        &[7, 40, 5, 2, 3, 11],
    );
    numbers(
        "int t[4] = {40, 30, 20, 10}; memset(&t[1], 0, 2 * sizeof(int)); scamp5_in(A, t[2]); scamp5_in(A, t[3]);\n\
         int u[4]; memcpy(u, t, sizeof t); scamp5_in(A, u[0]); memset(t, 0, sizeof t); scamp5_in(A, t[3]);\n\
         int8_t b[3]; memset(b, -1, 3); scamp5_in(A, b[2]);",
        &[0, 10, 40, 0, -1],
    );
    for unknown in [
        "int v[3] = {5, 6, 7}; std::partial_sort(v, v + 2, v + 3); scamp5_in(A, v[1]);",
        "int v[3] = {5, 6, 7}; std::rotate(v, v + 3, v + 1); scamp5_in(A, v[1]);",
        "int s = 0; int v[2] = {1, 2}; std::is_partitioned(v, v + 2, [&](int x) { s += x; return true; }); scamp5_in(A, s);",
        "uint8_t e[4] = {1, 2, 3, 4}; uint16_t *w = (uint16_t *)e; scamp5_in(A, w[0]);",
        "uint8_t e[4] = {1, 2, 3, 4}; uint16_t *w = (uint16_t *)e; w[0] = 7; scamp5_in(A, e[0]);",
    ] {
        refused_for(unknown, "depends on");
    }
    numbers(
        "uint8_t e[4] = {1, 2, 3, 4}; uint8_t *p = (uint8_t *)e; p[1] = 9; scamp5_in(A, e[1]);",
        &[9],
    );
}

/// The functions of a class that holds data are run with their object.
#[test]
fn functions_of_plain_classes() {
    numbers_with(
        "struct Box { static constexpr int W = 25; int l, r; int width() const { return r - l + 1; }\n\
         void grow(int by = 1) { r += by; this->l -= by; } bool wide() { return width() > 10; } };",
        "Box b{10, 19}; scamp5_in(A, b.width()); scamp5_in(A, b.wide()); b.grow(); scamp5_in(A, b.width());\n\
         Box *p = &b; p->grow(4); scamp5_in(A, b.l); scamp5_in(A, b.wide()); scamp5_in(A, Box::W);\n\
         Box c[2] = {{1, 2}, {3, 9}}; scamp5_in(A, c[1].width()); scamp5_in(A, sizeof(Box) + sizeof(c) / sizeof(c[0]));",
        &[10, 0, 12, 5, 1, 25, 7, 10],
    );
    // What is static has no object; the data of the others stay known.
    numbers_with(
        "struct C { int gain; int thr; static int most() { return 9; } static int half(int x) { return x / 2; } };\n\
         C c = {2, 40};",
        "scamp5_in(A, c.thr); scamp5_in(A, C::most()); scamp5_in(A, c.half(c.gain)); scamp5_in(A, C::half(8));",
        &[40, 9, 1, 4],
    );
}

#[test]
fn objects_of_plain_classes() {
    numbers_with(
        "struct C { int t; uint8_t u[2]; };\nstruct S { int a; int b = 4; };\nvoid set(S &s) { s.a = 42; }\n\
         int sum(S s) { s.a += 1; return s.a + s.b; }",
        "C c; c.t = 5; c.u[1] = 300; scamp5_in(A, c.t); scamp5_in(A, c.u[1]); S s = {3, 5}; S d = s; d.a = 9;\n\
         scamp5_in(A, s.a); S *p = &s; p->b = 7; scamp5_in(A, s.b); scamp5_in(A, sum(s)); scamp5_in(A, s.a);\n\
         set(s); scamp5_in(A, s.a); S t[2] = {{1, 2}, {3}}; scamp5_in(A, t[1].b); s = {6, 7}; scamp5_in(A, s.a);\n\
         struct { int x; int y; } one = {1, 2}; scamp5_in(A, one.y); typedef struct { int q; } T; T v; v.q = 8;\n\
         scamp5_in(A, v.q);",
        &[5, 44, 3, 7, 11, 3, 42, 4, 6, 2, 8],
    );
}

#[test]
fn objects_are_made_by_constructors() {
    let classes = "class Edge { int t, gain_; public: int made = 1;\n\
         explicit Edge(int t, int gain = 2) : t(t), gain_{gain} { made += t; }\n\
         Edge() : t(4), gain_(1) {} ~Edge() {}\n\
         int level() const { return t * gain_; } };\n\
         struct Pair { int a, b; Pair(int a, int b) noexcept { this->a = a; this->b = b; } };\n\
         struct Same { int a = 6; Same() = default; Same(const Same &) = delete; };\n\
         Edge strong(10, 3); int level(Edge e) { return e.level(); } Pair swapped(Pair p) { return Pair(p.b, p.a); }";
    numbers_with(
        classes,
        "Edge plain; Edge one{7}; Edge copy = Edge(5); Edge other(copy); Edge all[2]; Edge *p = new Edge(6, 1);\n\
         Edge *q = new Edge; auto r = Edge{8}; scamp5_in(A, strong.level()); scamp5_in(A, plain.level());\n\
         scamp5_in(A, one.level()); scamp5_in(A, copy.made); scamp5_in(A, other.level()); scamp5_in(A, all[1].level());\n\
         scamp5_in(A, p->level()); scamp5_in(A, q->level()); scamp5_in(A, r.level()); scamp5_in(A, level(Edge(3)));\n\
         scamp5_in(A, swapped(Pair(1, 2)).a); Pair b = {5, 9}; scamp5_in(A, b.b); Same s; scamp5_in(A, s.a);",
        &[30, 4, 14, 6, 10, 4, 6, 4, 16, 6, 2, 9, 6],
    );
    // By the kinds of what is given, as functions are.
    numbers_with(
        "struct Level { int n; Level(int n) : n(n) {} Level(double x) { n = x * 10; } Level(areg_t a) : n(99) {}\n\
         int of(int) { return 1; } int of(double) { return 2; } };",
        "Level a(3); Level b(1.5); Level c(B); scamp5_in(A, a.n); scamp5_in(A, b.n); scamp5_in(A, c.n);\n\
         scamp5_in(A, a.of(1)); scamp5_in(A, a.of(1.0));",
        &[3, 15, 99, 1, 2],
    );
    // What it asks of the array is asked where the object is made.
    same(
        "struct Start { Start(areg_t a) { res(a); } void go() { mov(A, B); } };\n\
         scamp5_kernel_begin(); Start s(C); s.go(); scamp5_kernel_end();",
        "res(C); mov(A, B);",
    );
    told(
        classes,
        "Pair p(1);",
        1,
        "no constructor of `Pair` takes 1 value",
        "one of its constructors",
    );
}

#[test]
fn lambdas_take_along_what_they_say() {
    numbers(
        "int x = 3; auto f = [x]() { return x; }; auto g = [&]() { return x; }; auto h = [=] { return x; };\n\
         auto k = [y = x + 1] { return y; }; auto m = [=, &x] { return x; }; auto n = [x]() mutable { return x++; };\n\
         x = 5; scamp5_in(A, f()); scamp5_in(A, g()); scamp5_in(A, h()); scamp5_in(A, k()); scamp5_in(A, m());\n\
         n(); scamp5_in(A, n()); scamp5_in(A, x);",
        &[3, 5, 3, 4, 5, 4, 5],
    );
    // It sees the names where it is made, not those where it is called.
    numbers_with(
        "template<class F> int twice(F f) { int t = 100; return f() + f(); }",
        "int t = 4; auto f = [&]() -> uint8_t { return t + 256; }; scamp5_in(A, twice(f));",
        &[8],
    );
}

#[test]
fn templates_of_numbers_and_types() {
    numbers_with(
        "template<typename T> T largest(T a, T b) { return a > b ? a : b; }\n\
         template<typename T> int held(int v) { T x = v; return x; }\n\
         template<int N, int M = N + 1> int next() { return M; }",
        "scamp5_in(A, largest<int>(3.5, 7.5)); scamp5_in(A, largest(4, 2)); scamp5_in(A, held<uint8_t>(300));\n\
         scamp5_in(A, next<2>()); scamp5_in(A, next<2, 9>());",
        &[7, 4, 44, 3, 9],
    );
    whole(
        "template<int N> void rep(areg_t r) { for (int i = 0; i < N; i++) mov(r, B); }\nint main() { rep<3>(A); }",
        "repeat 3 { mov(A, B); }",
    );
}

#[test]
fn smaller_constructs() {
    numbers(
        "int w[5]; uint8_t v[7]; scamp5_in(A, sizeof(w) / sizeof(w[0])); scamp5_in(A, sizeof(int));\n\
         scamp5_in(A, sizeof v); scamp5_in(A, sizeof(float) + sizeof(double)); uint16_t h; scamp5_in(A, sizeof(h));",
        &[5, 4, 7, 12, 2],
    );
    numbers(
        "static_assert(sizeof(int) == 4, \"int\"); scamp5_in(A, 1);",
        &[1],
    );
    refused_for(
        "static_assert(1 == 2, \"not so\"); nop();",
        "`static_assert` failed: not so",
    );
    numbers(
        "if (int x = 3) scamp5_in(A, x); if (int y = 4; y > 3) scamp5_in(A, y);\n\
         switch (int s = 2; s) { case 2: scamp5_in(A, s); }",
        &[3, 4, 2],
    );
    numbers(
        "int m = 3; scamp5_in(A, (uint8_t)~m == 252); scamp5_in(A, (int)!m); scamp5_in(A, (int)+m);",
        &[1, 0, 3],
    );
    numbers(
        "scamp5_in(A, roundf(2.6f)); scamp5_in(A, std::clamp(9, 1, 5)); scamp5_in(A, (int)std::pow(2, 3));\n\
         scamp5_in(A, trunc(4.2)); scamp5_in(A, lround(1.5)); scamp5_in(A, (int)(100 * sin(1.0)));\n\
         scamp5_in(A, (int)(100 * atan2f(1, 1)));",
        &[3, 5, 8, 4, 2, 84, 78],
    );
    numbers_with(
        "#define TEXT(x) #x",
        "scamp5_in(A, TEXT(a b)[1]); scamp5_in(A, TEXT(abc)[2]);",
        &[32, 99],
    );
    for inside in [
        "int a[3] = {1, 2, 3}; scamp5_in(A, a[5]);",
        "int a[3] = {1, 2, 3}; a[3] = 2; nop();",
        "int a[3] = {1, 2, 3}; a[-1]++; nop();",
    ] {
        refused_for(inside, "is out of bounds: `a`");
    }
    numbers(
        "std::vector<std::vector<int>> v(2, std::vector<int>(3, 7)); scamp5_in(A, v[1][2]);\n\
         v[0][1] = 4; scamp5_in(A, v[0][1] + v[1][1]); scamp5_in(A, v[0].size());\n\
         std::vector<int> w = std::vector<int>(4); scamp5_in(A, w[3] + w.size());",
        &[7, 11, 3, 4],
    );
    numbers(
        "for (int i = 0; i < 6; i++) switch (i) { case 1 ... 3: scamp5_in(A, i); break; case 5: scamp5_in(A, 50); }",
        &[1, 2, 3, 50],
    );
    refused_for("again: nop(); goto again;", "`goto` is not supported");
    refused_for("none = 3; nop();", "`none` is not declared");
    // One fault, not one of the body as well.
    for inside in ["ADD(A);", "scamp5_in(A, ADD(1));"] {
        let all = messages(&format!(
            "#define ADD(x, n) add(x, x, n)\nint main() {{ {inside} nop(); }}"
        ));
        assert!(
            matches!(&all[..], [one] if one == "`ADD` takes 2 arguments, not 1"),
            "{all:?}"
        );
    }
}

#[test]
fn registers_have_aliases() {
    same(
        "const areg_t P = B; auto Q = S1; mov(A, P); SET(Q);",
        "mov(A, B); SET(R6);",
    );
    same(
        "if (S5 == R10) { SET(R5); } if (R5 != S0) { SET(R6); }",
        "SET(R5);",
    );
    same(
        "areg_t all[2] = {A, B}; for (int i = 0; i < 2; i++) mov(all[i], C);",
        "mov(A, C); mov(B, C);",
    );
    whole(
        "#define IN_REG C\n#define TWICE(x, n) add(x, x, IN_REG); scamp5_in(x, n)\nTWICE(A, 5);",
        "add(A, A, C); scamp5_in(A, 5);",
    );
}

#[test]
fn the_preprocessor() {
    whole(
        "#define LAYERS 2\n#if LAYERS == 1 || defined(NONE)\nneg(A, B);\n#elif LAYERS > 1\nmov(A, B);\n#else\nabs(A, B);\n#endif\n\
         #ifndef MORE\n#define MORE(x) \\\n  neg(x, B)\n#endif\nMORE(C);\n#undef LAYERS\n#ifdef LAYERS\nabs(A, B);\n#endif",
        "mov(A, B); neg(C, B);",
    );
    whole(
        "#define west(X, Y) {mov(X, Y, west);}\nwest(A, B);",
        "movx(A, B, west);",
    );
    whole(
        "#define TRY(X)({\\\n mov(F, X);\\\n neg(X, F);\\\n})\nTRY(A);",
        "mov(F, A); neg(A, F);",
    );
    whole(
        "#define GLUE(a, b) a##b\nbus(A, GLUE(NE, WS));",
        "bus(A, NEWS);",
    );
}

#[test]
fn loops_and_branches_on_constants() {
    // Inside a kernel the words are there again and again, outside it is launched again.
    same(
        &format!("{BEGIN} for (int i = 0; i < 3; i++) {{ mov(A, B); }} {END}"),
        "mov(A, B); mov(A, B); mov(A, B);",
    );
    same(
        &format!("for (int i = 0; i < 3; i++) {{ {BEGIN} mov(A, B); {END} }}"),
        "repeat 3 { mov(A, B); }",
    );
    same(
        "for (int i = 0; i < 3; i++) scamp5_in(A, i);",
        "scamp5_in(A, 0); scamp5_in(A, 1); scamp5_in(A, 2);",
    );
    same(
        "int i = 4; while (i--) { if (i == 1) break; if (i % 2) continue; scamp5_in(A, i); }",
        "scamp5_in(A, 2);",
    );
    same(
        "int i = 0; do { scamp5_in(A, i); i += 2; } while (i < 4);",
        "scamp5_in(A, 0); scamp5_in(A, 2);",
    );
    same(
        "switch (2) { case 1: neg(A, B); break; case 2: mov(A, B); case 3: abs(A, B); break; default: nop(); }",
        "mov(A, B); abs(A, B);",
    );
    same(
        "int all[] = {1, 5}; for (auto x : all) scamp5_in(A, x);",
        "scamp5_in(A, 1); scamp5_in(A, 5);",
    );
}

#[test]
fn functions_are_run_where_they_are_called() {
    whole(
        "void f(areg_t y, areg_t x, int by = 2);\n\
         namespace tools { int twice(int n) { return 2 * n; } }\n\
         int main() { f(A, B); f(C, D, tools::twice(3)); auto g = [&](dreg_t r) { SET(r); }; g(R5); }\n\
         void f(areg_t y, areg_t x, int by) { mov(y, x); scamp5_in(x, by); }\n\
         void f(dreg_t y) { SET(y); }",
        "mov(A, B); scamp5_in(B, 2); mov(C, D); scamp5_in(D, 6); SET(R5);",
    );
    whole(
        "inline void only() { scamp5_kernel_begin(); south(A, A); scamp5_kernel_end(); }",
        "movx(A, A, south);",
    );
    whole(
        "scamp5_kernel k;\nint main() { k([]{ mov(A, B); }); scamp5_launch_kernel(k); }",
        "mov(A, B);",
    );
}

#[test]
fn a_name_that_nothing_declares_decides_nothing() {
    let inside = [
        "if (n == LIMIT) mov(A, B);",
        "if (n != LIMIT) mov(A, B);",
        "if (!LIMIT) mov(A, B);",
        "if (n && LIMIT) mov(A, B);",
        "if (n == Mode::LIMIT) mov(A, B);",
        "scamp5_in(A, (n == LIMIT) + 4);",
        "switch (n) { case LIMIT: mov(A, B); break; default: mov(A, C); }",
    ];
    for inside in inside {
        let text = format!("int main() {{ int n = 3; while (1) {{ {inside} }} }}");
        let told = expand(&text, &[]).unwrap_err().to_string();
        assert!(told.contains("`LIMIT` is not declared"), "{inside}: {told}");
    }
    // What the vendor's header has besides is not known here.
    let text =
        "int main() { int n = 3; while (1) { switch (n) { case VS_SOME_KEY: mov(A, B); } } }";
    let told = expand(text, &[]).unwrap_err().to_string();
    assert!(told.contains("depends on `VS_SOME_KEY`"), "{told}");
}

#[test]
fn a_switch_is_over_directions_and_registers_too() {
    whole(
        "news_t opposite(news_t d) { switch (d) { case north: return south; case south: return north;\n\
         case east: return west; default: return east; } }\n\
         int main() { const news_t all[] = {north, east, south, west};\n\
         while (1) { for (news_t d : all) movx(A, A, opposite(d));\n\
         areg_t r = B; switch (r) { case A: mov(C, A); break; case B: mov(C, B); break; } } }",
        "movx(A, A, south); movx(A, A, west); movx(A, A, north); movx(A, A, east); mov(C, B);",
    );
    let inner = "int f(int k) { switch (k) { case 1: { if (0) { case 2: return 20; } return 10; } } return 30; }\n\
                 int main() { while (1) { scamp5_in(A, f(2)); } }";
    let told = expand(inner, &[]).unwrap_err().to_string();
    assert!(
        told.contains("a `case` inside a nested statement"),
        "{told}"
    );
}

#[test]
fn functions_give_back_variables_themselves() {
    // The calls of a macro have one place; only the outer one's variable is given.
    whole(
        "#define SIZE(i) std::abs(entry(i))\nint table[] = {-5, 7};\n\
         int& entry(int i) { return table[i]; } template <int I> int& at() { return table[I]; }\n\
         void set(int v) { scamp5_in(A, v); }\n\
         int main() { auto second = [&]() -> int& { return table[1]; };\n\
         while (1) { set(SIZE(0)); set(std::abs(entry(0))); at<1>() = 8; set(table[1]);\n\
         int& third = at<1>(); third = 9; set(table[1]); second() = 3; set(table[1]); } }",
        "scamp5_in(A, 5); scamp5_in(A, 5); scamp5_in(A, 8); scamp5_in(A, 9); scamp5_in(A, 3);",
    );
    whole(
        "struct Settings { int th = 10, n = 1;\n\
         Settings& threshold(int t) { th = t; return *this; } Settings& times(int k) { n = k; return *this; } };\n\
         int table[4] = {1, 2, 3, 4};\n\
         int& entry(int i) { return table[i & 3]; }\n\
         int main() { Settings s; s.threshold(40).times(3);\n\
         int& e = entry(2); e = 30; entry(5) += 5; int copy = entry(0); copy = 9;\n\
         std::vector<int> v; v.push_back(1); v.push_back(2); v.back() = 7; v.at(0)++; int last = v.back();\n\
         while (1) { scamp5_in(A, s.th); scamp5_in(A, s.n); for (int k : table) scamp5_in(B, k);\n\
         scamp5_in(C, v[0]); scamp5_in(C, last); } }",
        "scamp5_in(A, 40); scamp5_in(A, 3); scamp5_in(B, 1); scamp5_in(B, 7); scamp5_in(B, 30);\n\
         scamp5_in(B, 4); scamp5_in(C, 2); scamp5_in(C, 7);",
    );
}

/// Of 32 bits, and not by way of 64.
#[test]
fn floats_are_those_of_cpp() {
    whole(
        "const float gain = 1.15f;\nint main() { int k = 0; for (float x = 0; x < 1.0f; x += 0.1f) k++;\n\
         double d = 0; int n = 0; while (d < 1.0) { d += 0.1; n++; }\n\
         float third = 1.0f / 3; auto more = 3 * third;\n\
         while (1) { scamp5_in(A, k); scamp5_in(A, n); scamp5_in(B, (int)(100 * gain)); scamp5_in(B, (int)(100 * 1.15));\n\
         scamp5_in(C, 1.1f == 1.1); scamp5_in(C, sqrtf(2.0f) == (float)sqrt(2.0)); scamp5_in(C, sizeof(more)); } }",
        "scamp5_in(A, 10); scamp5_in(A, 11); scamp5_in(B, 115); scamp5_in(B, 114);\n\
         scamp5_in(C, 0); scamp5_in(C, 1); scamp5_in(C, 4);",
    );
    // A setting is told as it is written.
    let text = "const float gain = 1.15f;\nint main() { while (1) { scamp5_in(A, 10 * gain); } }";
    assert_eq!(expand(text, &[]).unwrap().constants["gain"], 1.15);
}

#[test]
fn what_the_objects_of_a_class_share_is_its_own() {
    whole(
        "class Edge { int level; public: static int launches; inline static int most = 9;\n\
         Edge(int l) : level(l) {} void detect(dreg_t out) { scamp5_in(F, level);\n\
         scamp5_dynamic_kernel_begin(); where(A, F); MOV(out, FLAG); all(); scamp5_dynamic_kernel_end(); launches++; } };\n\
         struct Other { static int launches; };\n\
         int Edge::launches = 1;\nint Other::launches = 40;\n\
         int main() { Edge e(10); std::vector<int> v = {3, 1, 2};\n\
         std::sort(v.begin(), v.end(), std::greater<int>());\n\
         e.detect(S0); Other::launches++; scamp5_in(A, Edge::launches); scamp5_in(B, Other::launches);\n\
         scamp5_in(C, Edge::most); for (int k : v) scamp5_in(D, k); }",
        "scamp5_in(F, 10); where(A, F); MOV(R5, FLAG); all(); scamp5_in(A, 2); scamp5_in(B, 41);\n\
         scamp5_in(C, 9); scamp5_in(D, 3); scamp5_in(D, 2); scamp5_in(D, 1);",
    );
}

#[test]
fn a_kernel_has_the_words_that_it_was_made_with() {
    whole(
        "int main() { int n = 2; scamp5_kernel k([&] { for (int i = 0; i < n; i++) movx(A, A, west); });\n\
         scamp5_kernel other; other.begin(); add(B, B, A); other.end(); n = 5;\n\
         while (1) { vs_frame_loop_control(); scamp5_launch_kernel(k); k(); other(); other.launch();\n\
         scamp5_launch_kernel(other); } }",
        "movx(A, A, west); movx(A, A, west); movx(A, A, west); movx(A, A, west);\n\
         add(B, B, A); add(B, B, A); add(B, B, A);",
    );
    // Each instance of a template has a kernel of its own.
    let text = "template <int N> void far() { scamp5_kernel_begin();\n\
                for (int i = 0; i < N; i++) movx(A, A, west); scamp5_kernel_end(); }\n\
                int main() { while (1) { far<1>(); far<2>(); } }";
    assert_eq!(expand(text, &[]).unwrap().warnings, []);
    // Nothing in the constructor is a word.
    whole(
        "template <typename T, int N> class Ring { T data[N]; int head; public:\n\
         Ring() : head(0) { for (int i = 0; i < N; i++) data[i] = T(); } };\n\
         Ring<int, 4> ring;\nint main() { while (1) { mov(A, B); } }",
        "mov(A, B);",
    );
}

#[test]
fn sliders_are_settings_with_defaults() {
    let text = "int main() { int t = 12; vs_gui_add_slider(\"t\", 0, 99, t, &t); int on = 0;\n\
                vs_gui_add_switch(\"on\", on == 1, &on); auto rate = vs_gui_add_slider(\"r\", 0, 9, 4);\n\
                while (1) { vs_frame_loop_control(); scamp5_in(A, t); if (on) scamp5_in(B, vs_gui_read_slider(rate)); } }";
    let code = |set: &[(&str, f64)]| bare(expand(text, set).unwrap().code);
    assert_eq!(code(&[]), own_code("scamp5_in(A, 12);"));
    assert_eq!(
        code(&[("t", 20.0), ("on", 1.0), ("rate", 7.0)]),
        own_code("scamp5_in(A, 20); scamp5_in(B, 7);")
    );
    let found = expand(text, &[]).unwrap().constants;
    assert_eq!((found["t"], found["on"], found["rate"]), (12.0, 0.0, 4.0));
    // What a type does not hold is refused.
    let refused = |text: &str, set: (&str, f64)| expand(text, &[set]).unwrap_err().to_string();
    assert!(refused(text, ("t", 2.5)).contains("`t` is set to 2.5, which its type converts to 2"));
    let narrow = "int8_t level = 3;\nint main() { scamp5_in(A, level); }";
    assert!(refused(narrow, ("level", 300.0)).contains("its type converts to 44"));
    assert!(
        expand(text, &[("s", 1.0)])
            .unwrap_err()
            .to_string()
            .contains("no constant `s`")
    );
    // `#define` and constants as well.
    let text = "#define N 3\nconst int up = N * 2;\nscamp5_in(A, up);";
    let code = |set: &[(&str, f64)]| bare(expand(text, set).unwrap().code);
    assert_eq!(code(&[("N", -4.0)]), own_code("scamp5_in(A, -8);"));
    assert_eq!(code(&[("up", 1.0)]), own_code("scamp5_in(A, 1);"));
}

#[test]
fn the_first_frame_and_the_others() {
    let frames = |text: &str, init: &str, frame: &str| {
        whole(text, &format!("init {{ {init} }} frame {{ {frame} }}"));
    };
    let text = "int main() { bool first = true; CLR(R5); while (1) { vs_frame_loop_control(); get_image(A);\n\
                if (first) { mov(B, A); first = false; } sub(C, A, B); } }";
    frames(
        text,
        "CLR(R5); get_image(A); mov(B, A); sub(C, A, B);",
        "get_image(A); sub(C, A, B);",
    );
    // What is captured before the loop has a moment of its own.
    let text = "int main() { get_image(B); while (1) { vs_frame_loop_control(); get_image(A); sub(C, A, B); } }";
    frames(text, "get_image(B);", "get_image(A); sub(C, A, B);");
    // Waiting at the end of a turn.
    let text = "int main() { for (;;) { get_image(A); vs_wait_frame_trigger(); } }";
    whole(text, "get_image(A);");
}

#[test]
fn what_is_shown_and_read() {
    same(
        "auto d = vs_gui_add_display(\"x\", 0, 0); scamp5_output_image(A, d);",
        "scamp5_output_image(A);",
    );
    same(
        "scamp5_output_image(S0, 0);",
        "scamp5_scan_dreg(R5, mem, 0, 255);",
    );
    same(
        "uint8_t e[200]; scamp5_scan_events(R5, e, 100); for (int i = 0; i < 100; i++) { if (e[2*i] == 0) break; }",
        "scamp5_scan_events(R5, on, 100);",
    );
    same(
        "uint8_t off1[9]; scamp5_scan_events(R5, off1, 4, 1);",
        "scamp5_scan_events(R5, off1, 4, 1);",
    );
    // A word of a buffer's name says which events it takes.
    for (name, takes) in [
        ("ev_off", "off"),
        ("eventsNeg", "off"),
        ("OFF_EVENTS", "off"),
        ("falling3", "off"),
        ("offsets", "on"),
        ("officer", "off"),
        ("ev_on", "on"),
        ("negate", "on"),
    ] {
        same(
            &format!("uint8_t {name}[20]; scamp5_scan_events(R5, {name}, 10);"),
            &format!("scamp5_scan_events(R5, {takes}, 10);"),
        );
    }
    // A variable of the name of a buffer is another thing.
    same(
        "const bool on = true; bool off = false; vs_gui_add_switch(\"off\", false, &off); uint8_t e[20];\n\
         scamp5_scan_events(R5, e, 10); scamp5_in(A, on + off);",
        "scamp5_scan_events(R5, on, 10); scamp5_in(A, 1);",
    );
    let text = "int main() { uint8_t a[20], b[20], b_off[20]; scamp5_scan_events(R5, a, 10);\n\
                scamp5_scan_events(R6, b, 10); scamp5_scan_events(R7, b_off, 10); }";
    let warned = expand(text, &[]).unwrap().warnings;
    assert!(
        matches!(&warned[..], [one] if one.message == "the events of `a` and `b` are taken as one kind"),
        "{warned:?}"
    );
    // What is only printed decides nothing, now and then or always.
    let text = "uint8_t ev[200];\nint main() { int n = 0; while (1) { vs_frame_loop_control();\n\
                scamp5_scan_events(R5, ev, 100); if (n % 10 == 0) vs_post_text(\"%d\", ev[0]); n++; } }";
    whole(text, "scamp5_scan_events(R5, on, 100);");
    // Of an array that changes, what stays is known.
    let text = "int main() { int a[2] = {0, 5}; while (1) { vs_frame_loop_control(); a[0]++; scamp5_in(A, a[1]); } }";
    whole(text, "scamp5_in(A, 5);");
    same(
        "scamp5_output_events(R5, 0, 10);",
        "scamp5_scan_events(R5, on, 10);",
    );
    same(
        "uint8_t b[4]; scamp5_output_boundingbox(R5, 0, b); int w = b[2] - b[0]; vs_post_text(\"%d\", w);",
        "scamp5_scan_boundingbox(R5, mem);",
    );
    // Whether it is shown, the run decides.
    same(
        "get_image(A, F); if (vs_loop_counter_get() % 30 == 0) { scamp5_output_image(A, 0); }",
        "get_image(A, F);",
    );
    same(
        "int s = scamp5_global_sum_64(A); if (s > 9) { s = 9; vs_led_on(VS_LED_2); }",
        "scamp5_global_sum_64(A);",
    );
}

#[test]
fn a_kernel_is_stored_once() {
    let words = |text: &str| {
        let device = Device::scamp5();
        let expansion = Program::read("p.cpp", text).expand(&device, &Overrides::new());
        expansion.map(|it| stored(&it.code.frame, &device).0)
    };
    // 1,100 words run, in launches of 110 that are stored once.
    let body = "mov(A, B); ".repeat(55);
    let calls = "f(); scamp5_in(C, 1);".repeat(10);
    let text = format!("void f() {{ {BEGIN} {body} {END} }}\nint main() {{ {calls} }}");
    assert!(words(&text).unwrap() > 1024);
    // The same without kernels does not fit.
    let text = format!("void f() {{ {body} }}\nint main() {{ {calls} }}");
    assert!(
        words(&text)
            .unwrap_err()
            .to_string()
            .contains("more than the 1024")
    );
    // A kernel that is static keeps the words of its first launch: said.
    let text =
        format!("void f(areg_t x) {{ {BEGIN} mov(x, B); {END} }}\nint main() {{ f(A); f(C); }}");
    let expansion = expand(&text, &[]).unwrap();
    assert!(expansion.warnings.iter().any(|it| {
        it.message
            .contains("recorded only at its first launch, but `x` has changed")
    }));
}

#[test]
fn names_of_kernel_compilers() {
    whole(
        "south(A, A); div2_inplace(A, A); west(B, A); neg_inplace(B, B);",
        "movx(A, A, south); diva(A, E, F); movx(B, A, west); mov(F, B); neg(B, F);",
    );
    whole(
        "div2(C, B); add_twice(C, C, C); sub_inplace(A, B, A);",
        "div(C, F, B); mov(F, C); add(C, C, F); sub(F, B, A); mov(A, F);",
    );
    whole(
        "bus2_3(D, E, A); add_2(A, B, C);",
        "bus2(D, E, A); add(A, B, C);",
    );
    // In the frame language too.
    assert_eq!(own_code("north(D, C);"), own_code("movx(D, C, north);"));
    same(
        "DNEWS(R5, R6, north | west);",
        "CLR(RS, RW, RN, RE); SET(RN, RW); DNEWS0(R5, R6);",
    );
}

#[test]
fn text_whose_lines_are_statements() {
    let text = "// a comment\nget_image(A, D)\nscamp5_in(C, 15)\nsub(D, A, C); // with an end\nwhere(D)\n    MOV(R5, FLAG)\nall()\ndisplay()\n";
    let program = Program::read("p.txt", text);
    assert!(program.is_vendor());
    let code = program
        .expand(&Device::scamp5(), &Overrides::new())
        .unwrap()
        .code;
    assert_eq!(
        bare(code),
        own_code(
            "get_image(A, D); scamp5_in(C, 15); sub(D, A, C); where(D); MOV(R5, FLAG); all();"
        )
    );
    // A program of the frame language must have its marks.
    let faults = Program::parse("p.scamp", "mov(A, B)\nmov(C, A);").unwrap_err();
    assert!(faults.to_string().contains("expected `;`"));
}

/// Kernels and names that the vendor or a kernel compiler has alone: such a text is theirs whatever
/// its file is called, and what is done inside a kernel is done before its words.
#[test]
fn a_text_of_the_vendor_s_words_is_the_vendor_s() {
    let device = Device::scamp5();
    let read = |file: &str, text: &str| {
        let program = Program::read(file, text);
        let code = program.expand(&device, &Overrides::new());
        (
            program.is_vendor(),
            code.map(|it| bare(it.code)).map_err(|it| it.to_string()),
        )
    };
    for text in [
        "scamp5_kernel_begin();\nmov(B, A);\nscamp5_in(A, 5);\nadd(B, B, A);\nscamp5_kernel_end();\n",
        "scamp5_dynamic_kernel_begin();\nmov(B, A);\nscamp5_in(A, 5);\nscamp5_dynamic_kernel_end();\n",
        "mov(B, A);\ndiv2_inplace(B, B);\n",
        "bus2_3(D, E, A);\n",
        "add(A, A, B);\ndisplay() ;\n",
        "mov(B, A);\nscamp5_output_events(R5, list, 10);\n",
    ] {
        let cpp = read("p.cpp", text);
        assert!(cpp.1.is_ok(), "{text}: {:?}", cpp.1);
        assert_eq!(read("p.txt", text), cpp, "{text}");
        // Without `;` as well.
        let lines = text.replace(';', "");
        assert_eq!(read("p.txt", &lines), cpp, "{lines}");
    }
    let kernel = "scamp5_kernel_begin(); mov(B, A); scamp5_in(A, 5); scamp5_kernel_end();\n";
    assert_eq!(
        read("p.txt", kernel).1.unwrap(),
        own_code("scamp5_in(A, 5); mov(B, A);")
    );
    // The frame language has its marks, its blocks, and scratch of its own choice.
    for (file, text) in [
        ("p.scamp", kernel.to_owned()),
        ("p.txt", format!("//! title = \"a kernel\"\n{kernel}")),
        ("p.txt", format!("init {{ }}\nframe {{ {kernel} }}\n")),
        ("p.txt", "div2_inplace(A, B);\n".to_owned()),
        ("p.txt", "mov(B, A);\nblurr(A, B);\n".to_owned()),
    ] {
        assert!(!read(file, &text).0, "{text}");
    }
}

#[test]
fn everything_that_is_not_understood_is_named_at_once() {
    let text = "#include \"nowhere.hpp\"\nint main() {\n int n = 0;\n while (1) {\n  vs_frame_loop_control();\n  n++;\n\
                \x20 icw(1, {SEL4});\n  blurr(A, B);\n  if (n % 2) { mov(B, A); }\n  int s = scamp5_global_sum_fast(A);\n\
                \x20 if (s > 100) { neg(C, A); }\n  while (scamp5_global_or(R5)) { NOT(R5); }\n  scamp5_shift(A, s, 0);\n\
                \x20 mov(A, G);\n  scamp5_in(B, some + 1);\n  if (missing) { nop(); }\n  A = 3;\n }\n}\n";
    let faults = expand(text, &[]).unwrap_err();
    let told: Vec<(u32, &str, &str)> = faults
        .faults
        .iter()
        .map(|it| {
            (
                it.line,
                it.fault.message.as_str(),
                it.fault.help.as_deref().unwrap_or_default(),
            )
        })
        .collect();
    for (line, message, help) in [
        (
            1,
            "the included file `nowhere.hpp` was not found",
            "into the same folder",
        ),
        (7, "`icw`", "by its name"),
        (8, "unknown statement `blurr`", "`blur`"),
        (
            9,
            "depends on `n`, which changes from frame to frame",
            "--const n=VALUE",
        ),
        (
            11,
            "`scamp5_global_sum_fast` reads in line 10",
            "--const s=VALUE",
        ),
        (
            12,
            "how often this loop runs",
            "only the C++ that docs/vendor-code.md lists",
        ),
        (13, "`scamp5_shift` takes a value", "--const s=VALUE"),
        (14, "unknown name `G`", "--chip scamp5-wide"),
        (15, "`some` is not declared", "const int some"),
        (16, "`missing` is not declared", "const int missing"),
        (17, "`A` is a register", "scamp5_in(A, value)"),
    ] {
        let found = told
            .iter()
            .any(|it| it.0 == line && it.1.contains(message) && it.2.contains(help));
        assert!(found, "{line}: {message}: {help}\n{told:#?}");
    }
    // With the values given, the rest is a program.
    let text = "int main() { int n = 0; while (1) { vs_frame_loop_control(); n++; if (n % 2) { mov(B, A); } } }";
    assert_eq!(
        bare(expand(text, &[("n", 1.0)]).unwrap().code),
        own_code("mov(B, A);")
    );
}

#[test]
fn what_does_not_parse_has_its_place() {
    for (text, message) in [
        ("int main() { mov(A, B; }", "expected `,` or `)`, found `;`"),
        ("int main() { mov(A B); }", "expected `,` or `)`, found `B`"),
        ("int main() { if (1 { nop(); } }", "expected `)`"),
        ("int main() { for (int i = 0; i < 3) { } }", "expected `;`"),
        ("int main() { nop();", "this block has no end"),
        ("#if 1\nnop();", "this `#if` has no end"),
        ("#endif\nnop();", "`#endif` without `#if`"),
        ("scamp5_kernel_begin(); nop();", "this kernel has no end"),
        ("scamp5_kernel_end(); nop();", "this ends no kernel"),
        (
            "void f() { f(); nop(); } int main() { f(); }",
            "nested calls",
        ),
        (
            "int f(int x = f()) { return x; } int main() { scamp5_in(A, f()); }",
            "nested calls",
        ),
        (
            "struct S { int n; S(int x = S().n) : n(x) {} }; int main() { S s; scamp5_in(A, s.n); }",
            "nested calls",
        ),
        (
            "int main() { for (int i = 0; i >= 0; i++) { int x = 1; } }",
            "statements run before",
        ),
        ("int x = 5;", "nothing in this file uses the array"),
        (
            "void f(areg_t x) { neg(A, x); } void g(areg_t x) { mov(A, x); }",
            "there is no `main` to say which",
        ),
        ("repeat { nop(); }", "is not C++"),
        ("scamp5_load_dac(A, 5000);", "scamp5_load_dac"),
        ("/* never", "a comment without an end"),
    ] {
        let faults = expand(text, &[]).unwrap_err();
        let all: Vec<&str> = faults
            .faults
            .iter()
            .map(|it| it.fault.message.as_str())
            .collect();
        assert!(all.iter().any(|it| it.contains(message)), "{text}: {all:?}");
    }
}

#[test]
fn included_files_lie_beside_and_say_where_they_are_wrong() {
    let main = "#include \"a.hpp\"\n#include <b.hpp>\nint main() { f(A); }";
    assert_eq!(included(main)[0], "a.hpp");
    let read = |header: &str| {
        let mut includes = Includes::new();
        includes.insert("a.hpp".to_owned(), header.into());
        Program::read_with("p.cpp", main, &includes).expand(&Device::scamp5(), &Overrides::new())
    };
    let code = read("#pragma once\nvoid f(areg_t x) {\n mov(x, B);\n}")
        .unwrap()
        .code;
    assert_eq!(bare(code), own_code("mov(A, B);"));
    let faults = read("#pragma once\nvoid f(areg_t x) {\n mov(x, 3 +);\n}").unwrap_err();
    assert!(faults.to_string().contains("a.hpp:3:"), "{faults}");
    let label = &faults.faults[0].fault.label;
    assert!(label.contains("its line is `mov(x, 3 +);`"), "{label}");
    // What the chip has none of, too.
    let faults =
        read("#pragma once\nvoid f(areg_t x) {\n mov(x, B);\n  blurr(x, B);\n}").unwrap_err();
    let told = faults.to_string();
    assert!(
        told.contains("a.hpp:4:3: unknown statement `blurr`"),
        "{told}"
    );
}

/// Its registers would be numbers.
#[test]
fn a_copy_of_the_vendor_s_header_is_not_read() {
    let mut includes = Includes::new();
    let header = "typedef enum { A = 1, B, NEWS } areg_t;\nvoid mov(areg_t y, areg_t x);\n";
    for name in ["scamp5.hpp", "sdk/SCAMP5.hpp"] {
        includes.insert(name.to_owned(), header.into());
        let main = format!("#include \"{name}\"\nint main() {{ mov(A, B); }}");
        assert!(!included(&main).contains(&name.to_owned()));
        let read = Program::read_with("p.cpp", &main, &includes);
        let code = read
            .expand(&Device::scamp5(), &Overrides::new())
            .unwrap()
            .code;
        assert_eq!(bare(code), own_code("mov(A, B);"));
    }
}

/// Programs that are written as C++ and read back.
/// What the chip's converter sets.
fn in_whole_lsb(steps: &mut [Step]) {
    for step in steps {
        match &mut step.action {
            Action::Host(Host::LoadIn { value }) => *value = value.round_ties_even(),
            Action::Repeat { body, .. } => in_whole_lsb(body),
            _ => {}
        }
    }
}

fn back(program: &Program, device: &Device) {
    let text = cpp(program, device).unwrap();
    let mut before = program.expand(device, &Overrides::new()).unwrap().code;
    in_whole_lsb(&mut before.init);
    in_whole_lsb(&mut before.frame);
    let after = Program::read("p.cpp", &text).expand(device, &Overrides::new());
    let after = after
        .unwrap_or_else(|faults| panic!("{faults:?}\n{text}"))
        .code;
    assert_eq!(bare(before), bare(after), "{text}");
}

#[test]
fn every_shipped_program_reads_back_from_cpp() {
    let device = Device::scamp5();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("programs");
    let mut seen = 0;
    for folder in fs::read_dir(root).unwrap() {
        for file in fs::read_dir(folder.unwrap().path()).unwrap() {
            let path = file.unwrap().path();
            let text = fs::read_to_string(&path).unwrap();
            if path.extension().is_some_and(|it| it == "scamp") {
                back(
                    &Program::parse(&path.display().to_string(), &text).unwrap(),
                    &device,
                );
                seen += 1;
            }
        }
    }
    assert!(seen > 15, "{seen}");
}

#[test]
fn every_bundled_kernel_reads_back_from_cpp() {
    let device = Device::scamp5();
    let mut seen = 0;
    for name in Kernel::builtin_names() {
        let kernels = [Kernel::builtin(name).unwrap()];
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = Effort::states(300);
        let kinds = [CellKind {
            name: None,
            kernel: kernels[0].clone(),
            on: 16.0,
            off: 16.0,
        }];
        let Ok(filter) = request.filter() else {
            continue;
        };
        back(
            &Program::parse(name, &filter.text(&device, 0)).unwrap(),
            &device,
        );
        if let Ok(sensor) = SensorProgram::new(&kinds, DriveMemory::Analogue, name, &request) {
            let program = Program::parse(name, &sensor.text).unwrap();
            back(&program, &device);
        }
        seen += 1;
    }
    assert!(seen > 5, "{seen}");
}

#[test]
fn files_run_and_show_what_they_show() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/vendor");
    let out = tempfile::tempdir().unwrap();
    let shown = out.path().join("shown").display().to_string();
    let clip = "pattern:disc?width=32&height=24&frames=6";
    let said = json(
        &root,
        &[
            "exec",
            "threshold.cpp",
            "--image",
            clip,
            "--frames",
            "3",
            "--set",
            "threshold=20",
            "--displays",
            &shown,
        ],
    );
    assert_eq!(said["frames"], 3);
    let names: Vec<String> = fs::read_dir(&shown)
        .unwrap()
        .map(|it| it.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(names.len(), 6, "{names:?}");
    assert!(names.iter().any(|name| name.contains("picture-frame-0002")));
    assert_eq!(said["written"], serde_json::json!([shown]));
    for file in ["blobs.cpp", "generated.cpp", "lines.txt"] {
        good(&root, &["asm", file]);
    }
    assert!(
        good(
            &root,
            &["asm", "threshold.cpp", "--const", "clean=0", "--disasm"]
        )
        .lines()
        .count()
            < 30
    );
}

#[test]
fn compile_writes_cpp() {
    let folder = tempfile::tempdir().unwrap();
    let compile = |more: &[&str]| {
        let mut all = vec![
            "compile",
            "csdvs-3",
            "--threshold",
            "16",
            "--effort",
            "0.01",
        ];
        all.extend(more);
        good(folder.path(), &all)
    };
    compile(&["-o", "p.cpp"]);
    compile(&["-o", "p.scamp"]);
    // By the ending, in any letters.
    for name in ["q.CPP", "q.hpp", "q.Hpp"] {
        compile(&["-o", name]);
        let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(text(name), text("p.cpp"), "{name}");
    }
    assert!(compile(&["--as", "cpp"]).contains("scamp5_kernel_begin();"));
    let other = |language: &str, file: &str, words: &[&str]| {
        let asked = [
            "compile",
            "csdvs-3",
            "--threshold",
            "16",
            "--as",
            language,
            "-o",
            file,
        ];
        refused(folder.path(), &asked, words);
    };
    other(
        "scamp",
        "a.cpp",
        &["--as scamp, and a.cpp", "name it a.scamp"],
    );
    other(
        "cpp",
        "a.scamp",
        &["--as cpp, and a.scamp", "name it a.cpp"],
    );
    let words = |file: &str| good(folder.path(), &["disasm", file]);
    assert_eq!(words("p.cpp"), words("p.scamp"));
    // Thresholds that are no whole LSB are written as the converter sets them.
    let line = "compile rgc-5x5 --to ternary --threshold 128 --effort 0.01 -o q.cpp";
    good(folder.path(), &line.split(' ').collect::<Vec<_>>());
    let text = fs::read_to_string(folder.path().join("q.cpp")).unwrap();
    let mut inputs = text
        .lines()
        .filter(|line| line.contains("LSB; the converter"));
    assert!(inputs.next().is_some(), "{text}");
    fs::write(
        folder.path().join("bad.cpp"),
        "int main() { mov(A, B) neg(A, A); blub(A); }",
    )
    .unwrap();
    refused(folder.path(), &["asm", "bad.cpp"], &["expected `;`"]);
}

/// Inside of `main` and a loop over the frames: what is told, with its line from 1 on.
#[track_caller]
fn told(before: &str, inside: &str, line: u32, message: &str, help: &str) {
    let text = format!(
        "{} int main() {{ while (1) {{ vs_frame_loop_control(); int s = scamp5_global_sum_16(A);\n{inside}\n}} }}",
        before.replace('\n', " ")
    );
    let faults = expand(&text, &[]).expect_err(&text).faults;
    let found = faults.iter().any(|it| {
        it.line == line + 1
            && it.fault.message.contains(message)
            && it.fault.help.as_deref().unwrap_or_default().contains(help)
    });
    assert!(found, "{text}\n{faults:#?}");
}

#[test]
fn no_kernel_hides_from_what_only_the_run_knows() {
    let kernel = "scamp5_kernel_begin(); res(A); scamp5_kernel_end();";
    let functions = format!("void ka() {{ {kernel} }} void kb() {{ {kernel} }}");
    let whether = "whether this kernel runs depends on what `scamp5_global_sum_16` reads";
    for inside in [
        format!("auto k = [&] {{ {kernel} }};\nif (s > 100) k();"),
        format!("auto k = [&](int n) {{ {kernel} }}; auto l = [&] {{ k(1); }};\nif (s > 100) l();"),
        format!("\nif (s > 100) [&] {{ {kernel} }}();"),
        "\ns > 100 ? ka() : kb();".to_owned(),
        "\nint n = s > 100 && (ka(), 1);".to_owned(),
        "auto p = ka;\nif (s > 100) p();".to_owned(),
        "auto call = [&](auto f) { f(); };\nif (s > 100) call(ka);".to_owned(),
    ] {
        told(&functions, &inside, 2, whether, "--const s=VALUE");
    }
    let often = "how often this loop runs";
    told(
        &functions,
        &format!("auto k = [&](int n) {{ {kernel} }};\nwhile (scamp5_global_or(R5)) k(1);"),
        2,
        often,
        "",
    );
    told(
        &functions,
        "for (int i = 0; i < s; ka()) { i++; }",
        1,
        often,
        "--const s=VALUE",
    );
    told(
        &functions,
        "auto p = s > 100 ? ka : kb;\np();",
        2,
        "what this call runs depends on what",
        "--const p=VALUE",
    );
    // What changes nothing in the array may depend on it.
    same(
        "int s = scamp5_global_sum_16(A); auto show = [&] { vs_post_text(\"x\"); };\n\
         if (s) show(); if (s) { auto own = [&] { s = 3; }; own(); } int n = s ? 1 : 2;\n\
         std::mt19937 make; int r = make();",
        "scamp5_global_sum_16(A);",
    );
}

/// A `return` that only the run decides on ends the function, not only the loop that it is in.
#[test]
fn a_return_in_a_loop_ends_more_than_the_loop() {
    for turns in ["for (int i = 0; i < 3; i++)", "for (;;)"] {
        let before = format!(
            "int k = 0; void f() {{ {turns} {{ if (k > 2) return; k += 0; if (k < 9) break; }} mov(A, B); }}"
        );
        told(
            &before,
            "k++; f();",
            0,
            "`k`, which changes from frame to frame",
            "",
        );
    }
}

#[test]
fn what_a_branch_may_have_changed_is_not_known() {
    for inside in [
        "int n = 0; auto up = [&] { n++; }; if (s) up();",
        "int n = 0; if (s) up(n);",
        "int n = 0; s && n++;",
        "int n = 0; s ? n++ : 0;",
        "int n = 0; auto p = up; if (s) p(n);",
    ] {
        told(
            "void up(int &n) { n++; }",
            &format!("{inside}\nscamp5_in(A, n);"),
            2,
            "`scamp5_in` takes a value that depends on",
            "--const n=VALUE",
        );
    }
}

#[test]
fn functions_have_other_names() {
    whole(
        "typedef void (*fn)(areg_t);\nvoid g(areg_t a) { mov(a, B); }\nvoid h(areg_t a) { neg(a, B); }\n\
         void twice(void (*f)(areg_t), areg_t a) { f(a); (*f)(a); }\n\
         int main() { auto p = g; p(A); (*p)(C); fn t[] = {g, h}; t[1](A); auto q = &h; q(D);\n\
         auto apply = [&](fn f, areg_t r) { f(r); }; apply(g, E); void (*z)(areg_t) = h; z(A);\n\
         void (*all[])(areg_t) = {g, h}; all[0](D); twice(g, F);\n\
         auto again = [&](auto f) { f(); f(); }; again([&] { res(F); }); }",
        "mov(A, B); mov(C, B); neg(A, B); neg(D, B); mov(E, B); neg(A, B); mov(D, B);\n\
         mov(F, B); mov(F, B); res(F); res(F);",
    );
    // A lambda that calls kernels, or the host, is no kernel itself.
    same(
        "auto f = [&] { scamp5_kernel_begin(); mov(A, B); scamp5_kernel_end(); }; auto g = [&] { f(); scamp5_in(C, 3); }; g();",
        "mov(A, B); scamp5_in(C, 3);",
    );
}

#[test]
fn members_of_classes_do_not_run_kernels_unseen() {
    let class = "struct Filter { int n; operator int() const { return n; } void run(areg_t a) const { scamp5_kernel_begin(); mov(a, B); scamp5_kernel_end(); }\n\
                 int get() { return n; } void later(); void all() { run(A); } };\n\
                 void Filter::later() { res(A); }";
    let message = |member: &str| format!("`f.{member}` runs instructions of the array");
    told(
        class,
        "Filter f;\nf.run(A);",
        2,
        &message("run"),
        "outside the class",
    );
    told(
        class,
        "Filter f;\nf.later();",
        2,
        &message("later"),
        "outside the class",
    );
    told(
        class,
        "Filter f;\nf.all();",
        2,
        &message("all"),
        "outside the class",
    );
    told(
        class,
        "Filter f;\nif (s) f.run(A);",
        2,
        "whether this kernel runs",
        "",
    );
    told(
        "",
        "other.run(A);",
        1,
        "what `other.run` does with `A` is not known",
        "function",
    );
    for class in [
        "class G { int n; ~G() { res(C); } };",
        "class G : H { G() { res(C); } };",
    ] {
        told(
            class,
            "",
            0,
            "`G` runs instructions of the array without an explicit call",
            "outside the class",
        );
    }
    told(
        "class G : H { G(int n); }; G::G(int n) { res(C); }",
        "",
        0,
        "`G` runs instructions of the array without an explicit call",
        "outside the class",
    );
    whole(
        &format!(
            "{class}\nvs_stopwatch timer; int main() {{ Filter f; int n = f.get(); timer.reset(); mov(A, B); }}"
        ),
        "mov(A, B);",
    );
}

#[test]
fn each_frame_is_one_or_is_refused() {
    let frames = |text: &str, init: &str, frame: &str| {
        whole(text, &format!("init {{ {init} }} frame {{ {frame} }}"));
    };
    let refuses = |text: &str, message: &str, help: &str| {
        let faults = expand(text, &[]).expect_err(text).faults;
        let found = faults.iter().any(|it| {
            it.line == 2
                && it.fault.message.contains(message)
                && it.fault.help.as_deref().unwrap_or_default().contains(help)
        });
        assert!(found, "{text}\n{faults:#?}");
    };
    // A calibration of four frames before the loop.
    let calibrate = |times: usize| {
        format!(
            "int main() {{ for (int i = 0; i < {times}; i++) {{ vs_frame_loop_control();\n\
             scamp5_kernel_begin(); get_image(A, F); add(D, D, A); scamp5_kernel_end(); }}\n\
             while (1) {{ vs_frame_loop_control(); get_image(A, F); sub(E, A, D); }} }}"
        )
    };
    refuses(
        &calibrate(4),
        "4 frames are captured before the frame loop",
        "exec --dump",
    );
    frames(
        &calibrate(1),
        "get_image(A, F); add(D, D, A);",
        "get_image(A, F); sub(E, A, D);",
    );
    // One before the loop, and one in its first turn alone.
    refuses(
        "int main() { bool first = true; get_image(B); while (1) { vs_frame_loop_control();\n\
         get_image(A); if (first) { mov(C, A); first = false; } } }",
        "2 frames are captured before the frame loop",
        "capture once before the loop",
    );
    // The first turn does more since a kernel is recorded in it: that is named.
    let text = "int main() { get_image(F); while (1) { vs_frame_loop_control(); get_image(A); scamp5_kernel_begin();\n\
                scamp5_load_pattern(R5, 3, 0, 252, 252); WHERE(R5); res(A); all(); scamp5_kernel_end(); } }";
    refuses(
        text,
        "`scamp5_load_pattern` runs only in the first iteration of this loop, while the kernel is recorded",
        "before `scamp5_kernel_begin();`",
    );
    frames(
        &text.replace(
            "scamp5_kernel_begin();\nscamp5_load_pattern(R5, 3, 0, 252, 252);",
            "scamp5_load_pattern(R5, 3, 0, 252, 252); scamp5_kernel_begin();",
        ),
        "get_image(F);",
        "get_image(A); scamp5_load_pattern(R5, 3, 0, 252, 252); WHERE(R5); res(A); all();",
    );
    // What the first turn alone does is not left out behind a frame before the loop.
    frames(
        "int main() { bool first = true; vs_frame_loop_control(); CLR(R5); while (1) { vs_frame_loop_control();\n\
         get_image(A); if (first) { mov(C, A); first = false; } } }",
        "CLR(R5); get_image(A); mov(C, A);",
        "get_image(A);",
    );
    // A loop over the frames that ends.
    refuses(
        "int main() { for (int f = 0; f < 3; f++) { vs_frame_loop_control();\n\
         scamp5_get_image(A, B); scamp5_in(C, f); } }",
        "3 frames that differ",
        "while (1)",
    );
    let text = "int main() { for (int f = 0; f < 3; f++) { vs_frame_loop_control(); get_image(A); mov(B, A); } }";
    whole(text, "get_image(A); mov(B, A);");
    let warnings = expand(text, &[]).unwrap().warnings;
    assert!(
        warnings
            .iter()
            .any(|it| it.message.contains("ends after 3 frames"))
    );
    // Waiting in the middle of a turn.
    frames(
        "int main() { while (1) { scamp5_get_image(A, F); vs_wait_frame_trigger(); scamp5_kernel_begin(); neg(B, A); scamp5_kernel_end(); } }",
        "scamp5_get_image(A, F);",
        "neg(B, A); scamp5_get_image(A, F);",
    );
}

#[test]
fn warnings_and_faults_are_told_where_they_stand() {
    let warned = |text: &str| -> Vec<(usize, String)> {
        let expansion = expand(text, &[]).unwrap_or_else(|faults| panic!("{faults:?}"));
        let line = |start: usize| text[..start].matches('\n').count() + 1;
        let all = expansion.warnings.iter();
        all.map(|it| (line(it.place.start), it.message.clone()))
            .collect()
    };
    // The same mistake in two places is told twice.
    let both = warned(
        "void p(AREG y, AREG x) { scamp5_kernel_begin(); mov(y, x); scamp5_kernel_end(); }\n\
         void q(DREG y, DREG x) { scamp5_kernel_begin(); MOV(y, x); scamp5_kernel_end(); }\n\
         int main() { while (1) { vs_frame_loop_control(); get_image(A, C); p(B, A); p(D, A); SET(R6, R8); q(R5, R6); q(R7, R8); } }",
    );
    let other = |it: &&(usize, String)| it.1.contains("is recorded only at its first launch");
    let lines: Vec<usize> = both.iter().filter(other).map(|it| it.0).collect();
    assert_eq!(lines, [1, 2], "{both:?}");
    let faults = expand("int main() {\nnone(A);\nnone(A);\n}", &[]).unwrap_err();
    assert_eq!(faults.faults.len(), 2, "{faults:?}");
    // Nothing writes what is shown.
    let shown = warned(
        "int main() { auto d = vs_gui_add_display(\"d\", 0, 0); while (1) { vs_frame_loop_control(); scamp5_get_image(A, C);\n\
         scamp5_output_image(R7, d); } }",
    );
    assert_eq!(shown.len(), 1, "{shown:?}");
    assert!(
        shown[0].0 == 2 && shown[0].1.contains("nothing in this program writes R7"),
        "{shown:?}"
    );
    // Light falls once a frame.
    let twice = warned(
        "int main() { while (1) { vs_frame_loop_control();\n\
         scamp5_kernel_begin(); get_image(C); respix(F); scamp5_kernel_end(); vs_wait(500);\n\
         scamp5_kernel_begin(); getpix(D, F); scamp5_kernel_end(); } }",
    );
    assert!(
        twice
            .iter()
            .any(|it| it.0 == 3 && it.1.contains("reads no light")),
        "{twice:?}"
    );
    let once =
        warned("int main() { while (1) { vs_frame_loop_control(); getpix(D, F); respix(F); } }");
    assert!(
        !once.iter().any(|it| it.1.contains("reads no light")),
        "{once:?}"
    );
    // What is declared has its body somewhere.
    let faults = expand(
        "void later(int x);\nint main() { while (1) { vs_frame_loop_control(); later(3); } }",
        &[],
    );
    let faults = faults.unwrap_err().faults;
    assert!(
        faults[0]
            .fault
            .message
            .contains("`later` is declared in line 1"),
        "{faults:?}"
    );
}

#[test]
fn bodies_lie_beside_under_the_names_of_functions() {
    let text = "void later(areg_t y);\nvoid here();\nvoid here() { }\n\
                int main() { while (1) { vs_frame_loop_control(); here(); later(B); } }";
    let asked = included(text);
    assert!(asked.contains(&"later.cpp".to_owned()), "{asked:?}");
    assert!(!asked.contains(&"here.cpp".to_owned()), "{asked:?}");
    let with = |body: &str| {
        let includes = Includes::from([("later.cpp".to_owned(), body.into())]);
        Program::read_with("p.cpp", text, &includes).expand(&Device::scamp5(), &Overrides::new())
    };
    let body = "void later(areg_t y) { scamp5_kernel_begin(); mov(y, A); scamp5_kernel_end(); }";
    assert_eq!(bare(with(body).unwrap().code), own_code("mov(B, A);"));
    // Another program is not read.
    let other = with(&format!("{body}\nint main() {{ }}")).unwrap_err();
    assert!(
        other.to_string().contains("`later` is declared in line 1"),
        "{other}"
    );
}

#[test]
fn macros_and_chains_have_limits() {
    let doubling = (1..40).fold("#define L0 1\n".to_owned(), |text, i| {
        format!("{text}#define L{i} L{0}+L{0}\n", i - 1)
    });
    let chain = (1..1000).fold("#define M0 1\n".to_owned(), |text, i| {
        format!("{text}#define M{i} M{}\n", i - 1)
    });
    for (text, message) in [
        (
            format!("{doubling}scamp5_in(A, L39);"),
            "more than 1048576 tokens",
        ),
        (format!("{doubling}scamp5_in(A, L12);"), "in a row"),
        (
            format!("{chain}scamp5_in(A, M999);"),
            "levels of nested macros",
        ),
        (
            format!(
                "#define D(x) x x\n{}nop();{}",
                "D(".repeat(100),
                ")".repeat(100)
            ),
            "more than 1048576 tokens",
        ),
        (
            format!("scamp5_in(A, a{});", "[0]".repeat(5000)),
            "in a row",
        ),
    ] {
        let faults = expand(&text, &[]).unwrap_err().faults;
        assert!(
            faults[0].fault.message.contains(message),
            "{message}: {faults:#?}"
        );
    }
    // What is copied, looked through or made counts as well as what is run.
    for text in [
        "vector<int> v; vector<int> w; for (int i = 0; i < 100000; i++) v.push_back(i); for (int i = 0; i < 10000; i++) w = v;".to_owned(),
        "vector<int> v; for (int i = 0; i < 1000000; i++) v.push_front(i);".to_owned(),
        "vector<int> v(100000); int n = 0; for (int i = 0; i < 100000; i++) std::for_each(v.begin(), v.end(), [&](int x) { n += x; });".to_owned(),
        "struct S { int a[1000]; }; S s[1000]; for (int i = 0; i < 1000; i++) { S t[1000]; t[0] = s[0]; }".to_owned(),
        "struct S { int a; S() { a = 1; } int get() { return a; } }; for (int i = 0; i < 100; i++) { S s[200000]; }".to_owned(),
        "struct S { int a[100000]; int b; }; int n = 0; for (int i = 0; i < 100000; i++) n += S{}.b;".to_owned(),
        "struct T { vector<T> all; int v = 1; }; T t; for (int i = 0; i < 2000; i++) { T u; u.all.push_back(t); t = u; }".to_owned(),
        "struct T { vector<T> all; int v = 1; }; T t; for (int i = 0; i < 60; i++) { T u; u.all.push_back(t); u.all.push_back(t); t = u; }".to_owned(),
        "int w[100][10000]; int n = 0; for (int i = 0; i < 100000; i++) n += w[1] != &w[2][5];".to_owned(),
        format!("int n = 0; for (int i = 0; i < 1000000; i++) {{ auto f = [&](int x) {{ {} }}; }}", "n = x + 1;".repeat(1000)),
        format!("int n; for (int i = 0; i < 1000000; i++) {{ if (n) {{ {} }} }}", "n = n + 1;".repeat(1000)),
    ] {
        let faults = expand(&format!("int main() {{ {text} nop(); }}"), &[]).unwrap_err().faults;
        let said = &faults[0].fault.message;
        assert!(said.contains("statements run before the program is known"), "{text}: {said}");
    }
    for text in [
        "int a[1000000][1000000];",
        "int a[1000000000][0];",
        "struct S { int a[2000]; }; S s[1000];",
        "struct S { int a[2000]; }; struct T { S s[1000]; }; T t;",
        "vector<vector<int>> v(2000, vector<int>(2000));",
        "struct S { int a[2000]; }; struct T { S s[1000]; }; auto t = T{};",
    ] {
        let faults = expand(&format!("int main() {{ {text} nop(); }}"), &[])
            .unwrap_err()
            .faults;
        let said = &faults[0].fault.message;
        assert!(
            said.contains("more than 1048576 values in one variable"),
            "{text}: {said}"
        );
    }
    // Where the beginning of a value fits a type, both are tried: inside each other, not for ever.
    let casts = format!("int x = {}1{};", "(array<int,".repeat(60), ")".repeat(60));
    let faults = expand(&casts, &[]).unwrap_err().faults;
    assert!(!faults.is_empty());
    // Directions that are joined again and again are the same ones.
    same(
        "auto d = north; for (int i = 0; i < 100; i++) d = d | d; DNEWS(R5, R6, d);",
        "DNEWS(R5, R6, north);",
    );
    // An `else if` is no deeper than its `if`.
    let branches = (0..400).fold("if (0) { }".to_owned(), |text, i| {
        format!("{text} else if (x == {i}) {{ scamp5_in(A, {i} % 100); }}")
    });
    same(&format!("int x = 333; {branches}"), "scamp5_in(A, 33);");
}

#[test]
fn namespaces_have_names_of_their_own() {
    whole(
        "namespace a { const int N = 1; int f() { return N; } namespace in { int g() { return N + f(); } } }\n\
         namespace b { const int N = 2; int f() { return N; } }\n\
         int x = 3; const int only = 9; namespace c { const int own = 4; int x = 8; }\n\
         int main() { int x = 5; scamp5_in(A, a::N); scamp5_in(A, b::N); scamp5_in(A, a::f()); scamp5_in(A, b::f());\n\
         scamp5_in(A, ::x); scamp5_in(A, x); scamp5_in(A, c::x); scamp5_in(A, own + ::only); scamp5_in(A, a::in::g()); }",
        "scamp5_in(A, 1); scamp5_in(A, 2); scamp5_in(A, 1); scamp5_in(A, 2);\n\
         scamp5_in(A, 3); scamp5_in(A, 5); scamp5_in(A, 8); scamp5_in(A, 13); scamp5_in(A, 2);",
    );
    // The vendor's names are in a namespace too.
    whole(
        "namespace u { void mov(areg_t a, areg_t b) { SCAMP5_PE::mov(b, a); } }\n\
         int main() { u::mov(A, B); SCAMP5_PE::mov(A, SCAMP5_PE::B); }",
        "mov(B, A); mov(A, B);",
    );
    let spaces = "namespace a { const int N = 1; void f() { nop(); } } namespace b { const int N = 2; void f() { all(); } }";
    told(
        spaces,
        "scamp5_in(A, N);",
        1,
        "`N` is declared in several namespaces",
        "`space::N`",
    );
    told(
        spaces,
        "f();",
        1,
        "`f` is declared in several namespaces",
        "`space::f`",
    );
}

#[test]
fn the_host_does_nothing_inside_a_kernel() {
    let text = format!(
        "int main() {{ while (1) {{ vs_frame_loop_control(); scamp5_in(B, 1); {BEGIN}\nscamp5_in(C, 5);\nscamp5_shift(A, 1, 0);\n\
         scamp5_load_rect(R5, 1, 1, 3, 3);\nscamp5_global_or(R5);\nscamp5_output_image(A, 0);\nmov(A, B); {END} }} }}"
    );
    let warnings = expand(&text, &[]).unwrap().warnings;
    for name in ["in", "shift", "load_rect", "global_or", "output_image"] {
        let message = format!("`scamp5_{name}` inside a kernel");
        assert!(
            warnings.iter().any(|it| it.message == message),
            "{name}: {warnings:#?}"
        );
    }
    assert_eq!(warnings.len(), 5, "{warnings:#?}");
}

#[test]
fn settings_are_those_of_every_verb() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write(
        "slider.cpp",
        "int main() { int t = 12; vs_gui_add_slider(\"t\", 0, 99, t, &t); while (1) { vs_frame_loop_control(); scamp5_in(A, t); } }",
    );
    write(
        "average.cpp",
        "int main() { while (1) { vs_frame_loop_control(); int avg = scamp5_global_sum_16(A); scamp5_in(A, avg); } }",
    );
    let asm = |more: &[&str]| good(folder.path(), &[&["asm"], more].concat());
    assert_eq!(asm(&["slider.cpp", "--format"]), "scamp5_in(A, 12);\n");
    assert_eq!(
        asm(&["slider.cpp", "--format", "--const", "t=50"]),
        "scamp5_in(A, 50);\n"
    );
    assert!(asm(&["average.cpp", "--format", "--const", "avg=40"]).contains("scamp5_in(A, 40);"));
    refused(
        folder.path(),
        &["asm", "average.cpp", "--format"],
        &["--const avg=VALUE"],
    );
    refused(
        folder.path(),
        &["asm", "slider.cpp", "--format", "--const", "u=1"],
        &["no constant `u`"],
    );
    // A slider has ends.
    let text = fs::read_to_string(folder.path().join("slider.cpp")).unwrap();
    let warned = |t: f64| {
        let warnings = expand(&text, &[("t", t)]).unwrap().warnings;
        warnings
            .iter()
            .any(|it| it.message == "`t` is set to 120, but its slider goes from 0 to 99")
    };
    assert!(warned(120.0) && !warned(99.0));
    // A register is none of the constants.
    refused(
        folder.path(),
        &["exec", "slider.cpp", "--set", "A=5"],
        &["`A` is a name of the chip", "--set A=FILE.npy"],
    );
}

#[test]
fn scoped_enumerators_leave_registers_alone() {
    let stated = "enum class Reg : uint8_t { A, B = 4, R5, R6 };\n\
                  void copy(Reg from) { switch (from) { case Reg::A: mov(C, A); break; case Reg::R5: MOV(R7, R5); break; } }";
    numbers_with(stated, "scamp5_in(A, (int)Reg::R6);", &[6]);
    whole(
        &format!("{stated}\nint main() {{ copy(Reg::R5); copy(Reg::A); MOV(R6, R5); }}"),
        "MOV(R7, R5); mov(C, A); MOV(R6, R5);",
    );
    numbers(
        "enum struct Own { R5 = 3, R6 }; if (Own::R6 == (Own)4) scamp5_in(A, (int)Own::R5);",
        &[3],
    );
    numbers_with(
        "namespace a { enum class E { X = 7 }; int f() { return (int)E::X; } }",
        "scamp5_in(A, a::f()); scamp5_in(A, (int)a::E::X);",
        &[7, 7],
    );
    // One may be made of those before it.
    numbers_with(
        "enum class M { A1 = 1, B1, C1 = A1 | B1, D1 = C1 > 2 ? -B1 : 7, E1 = (int)C1 }; class K { public: enum { P = 2, Q = P * 3 }; };",
        "scamp5_in(A, (int)M::C1); scamp5_in(A, (int)M::D1); scamp5_in(A, (int)M::E1); scamp5_in(A, K::Q);",
        &[3, -2, 3, 6],
    );
    // Those of a plain `enum` are names like others.
    numbers("enum Plain { P = 2, Q }; scamp5_in(A, Plain::Q + P);", &[5]);
}

#[test]
fn calls_of_the_vendor_simulation() {
    let before = "vs_sim::config(\"server_ip\", \"127.0.0.1\"); vs_sim::enable_keyboard_control(); scamp5_sim::reset_model(3);";
    let frame =
        "if (vs_sim::is_simulation()) { res(B); } mov(A, C); vs_sim::save_image(A, \"a.bmp\");";
    let text =
        format!("int main() {{ {before} while (1) {{ vs_frame_loop_control(); {frame} }} }}");
    whole(&text, "mov(A, C); scamp5_output_image(A);");
    let simulated = expand(&text, &[("is_simulation", 1.0)]).unwrap().code;
    assert_eq!(
        bare(simulated),
        own_code("res(B); mov(A, C); scamp5_output_image(A);")
    );
    let warnings = expand(
        "int main() { vs_sim::pix_integrate(1, 2); get_image(A); }",
        &[],
    );
    let warnings = warnings.unwrap().warnings;
    assert!(
        warnings[0].message.contains("`pix_integrate`"),
        "{warnings:?}"
    );
}

#[test]
fn addresses_have_eight_bits() {
    for (cpp, own) in [
        (
            "scamp5_load_pattern(R8, 0, -1, 252, 252);",
            "scamp5_load_pattern(R8, 0, 255, 252, 252);",
        ),
        (
            "scamp5_load_rect(R5, 1, -9, 3, 4.75);",
            "scamp5_load_rect(R5, 1, 247, 3, 4);",
        ),
        (
            "scamp5_select_pattern(-2, 0, 0, 255);",
            "scamp5_select_pattern(254, 0, 0, 255);",
        ),
        (
            "scamp5_global_sum_sparse(A, 0, -1, 124, 124);",
            "scamp5_global_sum_sparse(A, 0, 255, 124, 124);",
        ),
        (
            "scamp5_load_point(R6, 300, 5);",
            "scamp5_load_point(R6, 44, 5);",
        ),
        (
            "scamp5_load_rect(R5, 260, -3, 270, 255);",
            "scamp5_load_rect(R5, 4, 253, 14, 255);",
        ),
        (
            "scamp5_draw_begin(R5); scamp5_draw_pixel(256, -2); scamp5_draw_end();",
            "scamp5_draw_begin(R5); scamp5_draw_pixel(0, 254); scamp5_draw_end();",
        ),
        (
            "scamp5_draw_begin(R5); scamp5_draw_rect(224, 64, 256, 96); scamp5_draw_end();",
            "scamp5_draw_begin(R5); scamp5_draw_rect(224, 64, 0, 96); scamp5_draw_end();",
        ),
    ] {
        same(cpp, own);
        let text = format!("int main() {{ while (1) {{ vs_frame_loop_control();\n{cpp} }} }}");
        let warnings = expand(&text, &[]).unwrap().warnings;
        let told = |it: &amacrine::config::Fault| it.message.contains("C++ passes");
        assert!(warnings.iter().any(told), "{cpp}: {warnings:?}");
    }
    // A rectangle that ends before it begins, by its end or its start; others do as they did.
    let turned = |call: &str| {
        let text = format!("int main() {{ while (1) {{ vs_frame_loop_control();\n{call} }} }}");
        let mut warnings = expand(&text, &[]).unwrap().warnings.into_iter();
        warnings.find(|it| it.message.contains("before its start"))
    };
    for (call, message, help) in [
        (
            "scamp5_load_rect(R5, 250, 0, 260, 9);",
            "C++ passes 4 instead of 260: the rectangle ends at 4, before its start at 250",
            "is empty here",
        ),
        (
            "scamp5_select_rect(0, -2, 9, 9);",
            "C++ passes 254 instead of -2: the rectangle ends at 9, before its start at 254",
            "is empty here",
        ),
        (
            "scamp5_draw_begin(R5); scamp5_draw_rect(224, 64, 256, 96); scamp5_draw_end();",
            "C++ passes 0 instead of 256: the rectangle ends at 0, before its start at 224",
            "between the two are drawn",
        ),
    ] {
        let fault = turned(call).unwrap_or_else(|| panic!("{call}"));
        assert_eq!(fault.message, message);
        assert!(fault.help.unwrap().contains(help), "{call}");
    }
    assert!(turned("scamp5_load_rect(R5, 260, -3, 270, 255);").is_none());
    // In a loop, once.
    let many = "int main() { while (1) { vs_frame_loop_control();\n\
                for (int i = 250; i < 260; i++) scamp5_load_point(R5, i, 0); } }";
    let warnings = expand(many, &[]).unwrap().warnings;
    let told = warnings
        .iter()
        .filter(|it| it.message.contains("C++ passes"));
    assert_eq!(told.count(), 1, "{warnings:?}");
    // Shapes are drawn where they are said to be.
    same(
        "scamp5_draw_begin(R5); scamp5_draw_point(-3, 300); scamp5_draw_end();",
        "scamp5_draw_begin(R5); scamp5_draw_point(-3, 300); scamp5_draw_end();",
    );
}

/// More slots than the list has, and what no document describes.
/// The vendor's masks of a row and a column go with the one that was selected last.
#[test]
fn masks_of_rows_and_columns() {
    same(
        "scamp5_select_col(3); scamp5_select_colx(192); scamp5_select_row(5); scamp5_select_rowx(-2); scamp5_select_colx(1);",
        "scamp5_select_col(3); scamp5_select_colx(3, 192); scamp5_select_row(5); scamp5_select_rowx(5, 254); scamp5_select_colx(3, 1);",
    );
    let help = "`scamp5_select_col(column);`";
    for before in [
        "",
        "scamp5_select_row(1);",
        "scamp5_select_col(1); scamp5_select_point(2, 3);",
    ] {
        let inside = format!("{before}\nscamp5_select_colx(3);");
        told(
            "",
            &inside,
            2,
            "`scamp5_select_colx` masks the column that was selected last",
            help,
        );
    }
    told(
        "",
        "scamp5_select_row(1);\nscamp5_select_rowx(1, 2);",
        2,
        "`scamp5_select_rowx` takes one argument",
        "scamp5_select_rowx(mask);",
    );
    // Back to C++ by a statement that the vendor has.
    let program = Program::parse(
        "p.scamp",
        "scamp5_select_rowx(5, 254); scamp5_select_colx(3, 192);",
    )
    .unwrap();
    let text = cpp(&program, &Device::scamp5()).unwrap();
    assert!(
        text.contains("scamp5_select_pattern(5, 0, 254, 255);"),
        "{text}"
    );
    assert!(
        text.contains("scamp5_select_pattern(0, 3, 255, 192);"),
        "{text}"
    );
}

#[test]
fn calls_that_ask_for_more_than_there_is() {
    same(
        "uint8_t on[10000]; scamp5_scan_events(R5, on, 5000);",
        "scamp5_scan_events(R5, on0, 4000);",
    );
    let text = "#define COLLECTED_EVENTS 5000\n\
                int main() { uint8_t on[2 * COLLECTED_EVENTS]; while (1) { vs_frame_loop_control();\n\
                scamp5_scan_events(R5, on, COLLECTED_EVENTS); } }";
    let warned = |set: &[(&str, f64)]| {
        let warnings = expand(text, set).unwrap().warnings.into_iter();
        let mut slots = warnings.filter(|it| it.message.contains("at most 4000 events"));
        slots.next().map(|it| it.help.unwrap())
    };
    let help = warned(&[]).unwrap();
    assert!(help.contains("`--const COLLECTED_EVENTS=4000`"), "{help}");
    assert_eq!(warned(&[("COLLECTED_EVENTS", 4000.0)]), None);
    let says = [
        (
            "int k = scamp5_global_sum_region(A, 0, 0, 63, 63);",
            "scamp5_global_sum_sparse",
        ),
        ("blur_repeat(D, A, 3);", "`gauss(y, x, n)`"),
    ];
    for (call, help) in says {
        let name = call[..call.find('(').unwrap()].rsplit(' ').next().unwrap();
        told("", call, 1, &format!("unknown statement `{name}`"), help);
    }
}

#[test]
fn constants_of_the_language() {
    numbers(
        "scamp5_in(A, (int)(M_PI * 10)); scamp5_in(A, INT_MAX / 100000000); scamp5_in(A, INT8_MIN);",
        &[31, 21, -128],
    );
    numbers(
        "int best = INT_MIN; for (int x : {3, 9, 4}) best = std::max(best, x); scamp5_in(A, best);",
        &[9],
    );
    numbers("int M_PI = 3; scamp5_in(A, M_PI);", &[3]);
    numbers("scamp5_in(A, UINT32_MAX > 0 && UINT8_MAX == 255);", &[1]);
}

#[test]
fn words_of_compilers_say_nothing() {
    whole(
        "extern \"C\" { __declspec(dllexport) void f(AREG a) { mov(a, B); }\n\
         __attribute__((noinline)) static void g(areg_t a) { neg(a, B); } }\n\
         int main() { f(A); g(C); }",
        "mov(A, B); neg(C, B);",
    );
}

#[test]
fn text_is_written_elsewhere() {
    same(
        "char name[20]; strcpy(name, \"a\"); strcat(name, \".bmp\"); sprintf(name, \"%d\", 3);\n\
         std::string n = std::to_string(4); strcpy(name, (\"in \" + n).c_str());\n\
         std::cout << \"frame \" << 3 << n << std::endl; std::cerr << name;\n\
         int port = std::stoi(\"27715\"); std::cout << std::setw(3) << port;\n\
         char *more = new char[strlen(name) + 1]; mov(A, B);",
        "mov(A, B);",
    );
    same(
        "using namespace std; cout << \"s\" << endl; mov(A, B);",
        "mov(A, B);",
    );
    numbers("scamp5_in(A, (int)strlen(\"abc\"));", &[3]);
    same(
        "vs_post_text(\"%s\\n\", scamp5_verbose_str()); mov(A, B);",
        "mov(A, B);",
    );
    // What is not run decides nothing.
    told(
        "",
        "std::string t = \"3\";\nif (memcmp(t.c_str(), \"3\", 1) == 0) { mov(A, B); }",
        2,
        "depends on `memcmp`",
        "only the C++ that docs/vendor-code.md lists",
    );
    // No register goes where it is not known what is done with it.
    let all = messages("int main() { std::sort(A, B); mov(A, B); }");
    assert!(all[0].contains("what `sort` does with `A`"), "{all:?}");
}

#[test]
fn a_register_has_no_one_value() {
    let text = "int main() { while (1) { vs_frame_loop_control(); where(A); MOV(R8, FLAG);\nif (R8 == 0) { bus(E); }\nmov(A, B); all(); } }";
    let faults = expand(text, &[]).unwrap_err().faults;
    let it = &faults[0];
    assert_eq!(it.line, 2);
    assert!(
        it.fault.message.contains("`R8`")
            && it.fault.help.as_deref().unwrap().contains("WHERE(R8)"),
        "{it:?}"
    );
    told("", "\nif (FLAG) { mov(A, B); }", 2, "`FLAG`", "where");
    told("", "\nmov(A, R6 ? B : C);", 2, "`R6`", "WHERE(R6)");
}

#[test]
fn a_name_that_nobody_knows_keeps_its_end() {
    let all = messages("int main() { blur_repeat(D, A, 30); }");
    assert!(
        all[0].contains("unknown statement `blur_repeat`"),
        "{all:?}"
    );
}

/// C++ of several files: that of `main`, and those beside it.
fn together(main: &str, beside: &[(&str, &str)]) -> Result<Expansion, Faults> {
    let includes: Includes = beside
        .iter()
        .map(|(name, text)| ((*name).to_owned(), (*text).into()))
        .collect();
    Program::read_with("p.cpp", main, &includes).expand(&Device::scamp5(), &Overrides::new())
}

#[test]
fn bodies_lie_beside_their_headers() {
    let main = "#include \"a.hpp\"\nint level = 3;\nint main() { work::f(A); }";
    assert!(included(main).contains(&"a.cpp".to_owned()));
    let header = "#pragma once\nnamespace work { void f(areg_t x); }";
    let body = "#include \"a.hpp\"\n#include \"b.h\"\nextern int level;\nstatic const int by = 2;\n\
                namespace work { void f(areg_t x) { scamp5_in(x, level * by); g(x); } }";
    let b = ("b.h", "#pragma once\nvoid g(areg_t x);");
    let c = (
        "b.c",
        "#include \"b.h\"\nstatic const int by = 2;\nvoid g(areg_t x) { neg(B, x); }",
    );
    let all = [("a.hpp", header), ("a.cpp", body), b, c];
    let code = together(main, &all).unwrap().code;
    assert_eq!(bare(code), own_code("scamp5_in(A, 6); neg(B, A);"));
    // Names that only one file should know.
    for other in [
        "static const int by = 5; void g(areg_t x) { neg(B, x); }",
        "static int by; void g(areg_t x) { neg(B, x); }",
    ] {
        let all = [("a.hpp", header), ("a.cpp", body), b, ("b.c", other)];
        let code = together(main, &all).unwrap().code;
        assert_eq!(
            bare(code),
            own_code("scamp5_in(A, 6); neg(B, A);"),
            "{other}"
        );
    }
    // Functions that only one file should know.
    let other = "void g(areg_t x) { neg(B, x); } namespace work { void f(areg_t y) { } }";
    let all = [("a.hpp", header), ("a.cpp", body), b, ("b.c", other)];
    let faults = together(main, &all).expect_err(other).to_string();
    assert!(
        faults.contains("`f`") && faults.contains("a.cpp:"),
        "{faults}"
    );
    // A file that is read for its own sake is not read again.
    let own = "#include \"p.hpp\"\nvoid f(areg_t x) { mov(x, B); }\nint main() { f(A); }";
    let all = [("p.hpp", "void f(areg_t x);"), ("p.cpp", own)];
    let code = together(own, &all).unwrap().code;
    assert_eq!(bare(code), own_code("mov(A, B);"));
    // On the disk too.
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("p.cpp", main);
    for (name, text) in [("a.hpp", header), ("a.cpp", body), b, c] {
        write(name, text);
    }
    let out = good(folder.path(), &["asm", "p.cpp", "--format"]);
    assert!(out.contains("scamp5_in(A, 6);"), "{out}");
}

#[test]
fn what_main_is_started_with_is_not_known() {
    let text = "int main(int argc, char *argv[]) {\nif (argc < 2) { return 1; }\nmov(A, B); }";
    let faults = expand(text, &[]).unwrap_err().faults;
    assert!(faults[0].fault.message.contains("`argc`"), "{faults:?}");
    let code = expand(text, &[("argc", 2.0)]).unwrap().code;
    assert_eq!(bare(code), own_code("mov(A, B);"));
    // No run knows it: each way says what gives it.
    let text = "int main(int argc, char *argv[]) {\nif (argc < 2) { return 1; }\nscamp5_in(E, 20);\n\
                if (argc > 3) { mov(C, D); }\nif (argv[1][0] > 3) { mov(D, C); } }";
    let faults = expand(text, &[]).unwrap_err().faults;
    let helps: Vec<_> = faults
        .iter()
        .filter_map(|it| it.fault.help.as_deref())
        .collect();
    let argc = "give the value with `--const argc=VALUE`, or remove this";
    let argv = "use only the C++ that docs/vendor-code.md lists, or remove this";
    assert!(
        helps.iter().all(|it| [argc, argv].contains(it)),
        "{helps:?}"
    );
    let help = |line| {
        let mut there = faults.iter().filter(|it| it.line == line);
        there.next().and_then(|it| it.fault.help.as_deref())
    };
    assert_eq!([help(3), help(4)], [Some(argc); 2], "{faults:#?}");
    let text = text.replace("if (argv[1][0] > 3) { mov(D, C); }", "");
    let code = expand(&text, &[("argc", 2.0)]).unwrap().code;
    assert_eq!(bare(code), own_code("scamp5_in(E, 20);"));
    // What is shown is left out, and told of in the same way.
    let text = "int main(int argc, char *argv[]) { while (1) { vs_frame_loop_control(); mov(A, B);\n\
                if (argc > 3) scamp5_output_image(A, 0); } }";
    let warnings = expand(text, &[]).unwrap().warnings;
    let help = warnings[0].help.as_deref().unwrap_or_default();
    assert!(help.contains("--const argc=VALUE"), "{warnings:#?}");
}

#[test]
fn casts_to_types_of_others() {
    same(
        "char a[4]; memcpy((Header *)&a, (Other*)a, sizeof(a)); mov(A, B);",
        "mov(A, B);",
    );
}

#[test]
fn each_kernel_of_a_macro_is_its_own() {
    let text = format!(
        "#define TWICE(d) ({{ {BEGIN} mov(A, B); {END} scamp5_in(C, 3); {BEGIN} mov(d, A); {END} }})\n\
         void f(areg_t d) {{ TWICE(d); }}\nint main() {{ while (1) {{ vs_frame_loop_control(); scamp5_in(B, 1);\n"
    );
    let warnings = |inside: &str| {
        let text = format!("{text}{inside} }} }}");
        expand(&text, &[]).unwrap().warnings
    };
    assert_eq!(warnings("TWICE(D); f(E);"), []);
    let all = warnings("f(D); f(E);");
    assert!(
        matches!(&all[..], [one] if one.message.contains("recorded only at its first launch, but `d` has")),
        "{all:?}"
    );
}

#[test]
fn a_stack_of_bits_has_its_display() {
    let text = "int main() { auto d = vs_gui_add_display(\"four bits\", 0, 0);\nwhile (1) { vs_frame_loop_control();\n\
                scamp5_output_bitstack_begin(d, 2);\nscamp5_output_bitstack_bit(R5);\nscamp5_output_bitstack_bit(R6);\n\
                scamp5_output_bitstack_end();\nscamp5_output_image(R7, 0); } }";
    let titles = Program::read("p.cpp", text).titles;
    let titles: Vec<(&str, &str)> = titles.iter().map(|(at, it)| (&**at, &**it)).collect();
    assert_eq!(titles, [("line 4", "four bits"), ("line 5", "four bits")]);
}

/// Pointers into rows and objects are as far apart as their elements lie in memory.
#[test]
fn pointers_are_compared_by_where_they_lead() {
    let rows = "int8_t w[3][3] = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};\n";
    numbers_with(
        rows,
        "int sum = 0; for (const int8_t *p = &w[0][0]; p <= &w[2][2]; ++p) sum += *p; scamp5_in(A, sum);\n\
         scamp5_in(A, &w[2][2] - &w[0][0]); scamp5_in(A, &w[1][1] == &w[0][1]); scamp5_in(A, w[1] == w[0]);\n\
         scamp5_in(A, &w[1][0] > &w[0][2]); int8_t *q = w[1]; scamp5_in(A, q == &w[1][0]);",
        &[45, 8, 0, 0, 1, 1],
    );
    let objects = "struct T { dreg_t d; int n; }; static T t[] = {{R5, 3}, {R6, 4}, {R7, 5}};\n";
    numbers_with(
        objects,
        "int sum = 0; for (T *p = t; p < t + 3; p++) sum += p->n; scamp5_in(A, sum);\n\
         scamp5_in(A, &t[0].n == &t[1].n); T *last = &t[2]; scamp5_in(A, last - t); scamp5_in(A, t->n);",
        &[12, 0, 2, 3],
    );
    numbers_with(
        objects,
        "areg_t regs[] = {B, C, D}; scamp5_in(A, sizeof(regs) / sizeof(regs[0]));\n\
         scamp5_in(A, sizeof(t) / sizeof(t[0]));",
        &[3, 3],
    );
}

/// Constants of a class, objects in braces, names for the members of each element.
#[test]
fn constants_and_objects_of_classes() {
    let class = "struct S { enum { N = 3, M, }; enum class E { X = 7 }; static const int K = 5;\n\
         static int f(int x) { return x + K + N; } int g() const { return M; } int a = 1; };\n";
    numbers_with(
        class,
        "scamp5_in(A, S::N + S::M); scamp5_in(A, S::f(2)); S s; scamp5_in(A, s.g()); scamp5_in(A, (int)S::E::X);\n\
         for (int i = 0; i < S::N; i++) scamp5_in(A, i);",
        &[7, 10, 4, 7, 0, 1, 2],
    );
    numbers_with(
        "struct Box { int t; int r; }; Box made(int r) { return Box{3, r}; } int sum(Box b) { return b.t + b.r; }\n",
        "Box b{1, 2}; b = Box{3, 4}; scamp5_in(A, b.t + b.r); scamp5_in(A, sum(Box{5, 6})); scamp5_in(A, made(9).r);\n\
         Box all[2] = {{1, 2}, {3, 4}}; for (auto [t, r] : all) scamp5_in(A, 10 * t + r);\n\
         for (auto &[t, r] : all) t = 8; scamp5_in(A, all[1].t);",
        &[7, 11, 9, 12, 34, 8],
    );
}

/// What a header asks for may lie beside the header.
#[test]
fn headers_ask_for_what_lies_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("lib");
    std::fs::create_dir(&inner).unwrap();
    let main = "#include \"lib/pool.h\"\nint main() { pool(A); }";
    std::fs::write(
        inner.join("pool.h"),
        "#include \"conv.hpp\"\nvoid pool(areg_t a) { conv(a); }",
    )
    .unwrap();
    std::fs::write(inner.join("conv.hpp"), "void conv(areg_t a) { neg(a, B); }").unwrap();
    let includes = amacrine::program::included_files(main, folder.path());
    let program = Program::read_with("p.cpp", main, &includes);
    let code = program
        .expand(&Device::scamp5(), &Overrides::new())
        .unwrap()
        .code;
    assert_eq!(bare(code), own_code("neg(A, B);"));
}

/// Messages name the file that was read, however it is asked for.
#[test]
fn files_that_are_asked_for_from_windows_are_named_as_they_lie() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("lib");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(inner.join("conv.hpp"), "void conv() {\nnonsense(A);\n}").unwrap();
    std::fs::write(inner.join("pool.hpp"), "void pool() {\nnonsense(B);\n}").unwrap();
    std::fs::write(
        folder.path().join("own.hpp"),
        "void own() {\nnonsense(C);\n}",
    )
    .unwrap();
    std::fs::write(inner.join("all.hpp"), "#include \"pool.hpp\"").unwrap();
    let main = "#include \"lib\\conv.hpp\"\n#include \"lib/all.hpp\"\n#include \"..\\elsewhere\\own.hpp\"\n\
                int main() { conv(); pool(); own(); }";
    let includes = amacrine::program::included_files(main, folder.path());
    let program = Program::read_with("p.cpp", main, &includes);
    let faults = { program.expand(&Device::scamp5(), &Overrides::new()) }
        .unwrap_err()
        .faults;
    for place in ["lib/conv.hpp:2:1: ", "lib/pool.hpp:2:1: ", "own.hpp:2:1: "] {
        let named = |it: &amacrine::config::Located| it.fault.message.starts_with(place);
        assert!(faults.iter().any(named), "{place}: {faults:#?}");
    }
}

/// Words that no kernel holds are warned of, where there are kernels; one fault is told as one.
#[test]
fn words_outside_of_kernels() {
    let text = "int main() { while (1) { vs_frame_loop_control(); scamp5_kernel_begin(); get_image(A); scamp5_kernel_end(); mov(B, A); scamp5_output_image(B, 0); } }";
    let all = expand(text, &[]).unwrap().warnings;
    assert!(
        all.iter()
            .any(|it| it.message == "`mov` outside of a kernel"),
        "{all:?}"
    );
    let bare = "int main() { while (1) { vs_frame_loop_control(); get_image(A); mov(B, A); scamp5_output_image(B, 0); } }";
    let all = expand(bare, &[]).unwrap().warnings;
    assert!(
        all.iter().all(|it| !it.message.contains("outside")),
        "{all:?}"
    );
    let all = messages(
        "struct P { int a; };\nint main() { while (1) { P p = try { }; NOT(R5); } nop(); }",
    );
    assert!(
        all.iter().all(|it| !it.contains("unmatched `}`")),
        "{all:?}"
    );
}

/// Elements are sorted by a function, equal ones in their order.
#[test]
fn sorted_by_a_function() {
    numbers(
        "int a[4] = {3, 1, 5, 2}; std::sort(a, a + 4, [](int x, int y) { return x > y; }); for (int x : a) scamp5_in(A, x);",
        &[5, 3, 2, 1],
    );
    numbers(
        "int sign = -1; std::vector<int> a = {3, 1, 2}; std::sort(a.begin() + 1, a.end(), [&](int x, int y) { return sign * x < sign * y; }); for (int x : a) scamp5_in(A, x);",
        &[3, 2, 1],
    );
    numbers_with(
        "struct P { int key; int tag; };\nbool less(const P& a, const P& b) { return a.key < b.key; }",
        "P all[3] = {{2, 1}, {1, 2}, {2, 3}}; std::stable_sort(all, all + 3, less); for (int i = 0; i < 3; i++) scamp5_in(A, all[i].tag);",
        &[2, 1, 3],
    );
}

/// What a compiler refuses, or leaves without a value, is told for what it is.
#[test]
fn mistakes_that_a_compiler_sees() {
    let told = |text: &str, reason: &str| {
        let all = messages(text);
        assert!(all.iter().any(|it| it.contains(reason)), "{text}: {all:?}");
    };
    let f = "int f(int a, int b = 2) { return a; }\nint g(int a) { return a; }\n";
    told(
        &format!("{f}int main() {{ scamp5_in(A, g(1, 2)); }}"),
        "`g` takes 1 argument, not 2",
    );
    told(
        &format!("{f}int main() {{ scamp5_in(A, f()); }}"),
        "`f` takes 1 to 2 arguments, not 0",
    );
    told(
        "int f(int a) { if (a > 1) return 3; }\nint main() { scamp5_in(A, f(0)); }",
        "`f`, which ends without a `return`",
    );
    told(
        "struct P { int x; };\nint main() { P p = {1}; scamp5_in(A, p.z); }",
        "`z`, which is not a member of `P`",
    );
    refused_for(
        "int q = 1; int q = 2; scamp5_in(A, q);",
        "`q` is declared twice in this block",
    );
    numbers(
        "int q = 1; { int q = 2; scamp5_in(A, q); } for (int i = 0; i < 2; i++) { int q = i; scamp5_in(A, q); } scamp5_in(A, q);",
        &[2, 0, 1, 1],
    );
}

/// What of C++ is not supported is named, with its line; a value is only asked for where a variable
/// can take one.
#[test]
fn what_is_not_followed_is_named() {
    let told = |text: &str, reason: &str| {
        let all = expand(text, &[]).expect_err(text).faults;
        let named = all.iter().any(|it| it.fault.message.contains(reason));
        let const_of_nothing = all.iter().any(|it| {
            let help = it.fault.help.as_deref().unwrap_or_default();
            help.contains("--const NAME") || reason.contains("supported") && help.contains("`exec`")
        });
        assert!(named && !const_of_nothing, "{text}: {all:?}");
    };
    told(
        "template <typename T> struct Pair { T a; T b; };\nint main() { Pair<int> p{1, 2}; scamp5_in(A, p.a); }",
        "`p`, a class template in line 1, which is not supported",
    );
    told(
        "struct B { int x; int get() { return x; } };\nstruct D : public B, C { int y; };\nint main() { D d; scamp5_in(A, d.get()); }",
        "`d`, a class with several bases in line 2, which is not supported",
    );
    for inside in [
        "scamp5_in(A, m.count(0));",
        "for (auto& it : m) scamp5_in(A, it);",
    ] {
        told(
            &format!("int main() {{ std::set<int> m = {{1, 2}}; {inside} }}"),
            "`m`, a `std::set`, which is not supported",
        );
    }
    told(
        "template <typename T> T f(T a) { return a; }\nstruct S { int n; };\ntemplate <> int f<S>(S a) { return 3; }\nint main() { scamp5_in(A, f(2)); }",
        "a template specialised for a class is not supported",
    );
    told(
        "int main() { if (scamp5_global_or(R5)) { mov(A, B); } }",
        "whether this kernel runs",
    );
    // A variable can be given one.
    let text = "int main() { int n = scamp5_global_or(R5); if (n) { mov(A, B); } }";
    let faults = expand(text, &[]).expect_err(text).faults;
    let help = faults[0].fault.help.clone().unwrap_or_default();
    assert!(help.contains("`--const n=VALUE`"), "{help}");
}

/// A word without parentheses that ends with its line, whatever stands in the next one.
#[test]
fn words_without_parentheses_are_named() {
    for (text, words) in [
        (
            "get_image(A)\nmovx(B, A, east)\nnop\nadd(C, A, B)\nmov(D, C)\n",
            1,
        ),
        ("get_image(A)\nneg\nadd(C, A, B)\nloop\nmov(D, C)\n", 2),
        ("add(A, A, B)\nfoo\nmovx(B, A, east)\n", 1),
        ("where(A)\nall\nmov(B, A)\n", 1),
        ("where(A)\nrespix\nall\n", 2),
        ("nop\nadd(C, A, B)\nneg\nmov(D, C)\n", 2),
        ("mov(B, A)\nall", 1),
        ("mov(B, A)\nnop\nall();\n", 1),
    ] {
        let faults = Program::read("p.txt", text).expand(&Device::scamp5(), &Overrides::new());
        let faults = faults.expect_err(text).faults;
        let found = { faults.iter() }.filter(|it| it.fault.message.contains("expected `(`"));
        assert_eq!(found.count(), words, "{text}: {faults:?}");
    }
    // With types and braces, declarations may go over lines as in C++.
    whole(
        "void\nf(areg_t a)\n{ neg(a, B); }\nint\nmain()\n{ int n\n= 3; int\nm(4); scamp5_in(C, n + m); f(A); }",
        "scamp5_in(C, 7); neg(A, B);",
    );
}

/// What only looks like a declaration would leave out what it says of registers.
#[test]
fn types_that_nothing_defines_take_no_registers() {
    told(
        "",
        "Thing t(A, B);\nmov(C, D);",
        1,
        "what `Thing` does with `A`",
        "define it",
    );
    told(
        "",
        "Thing t{A, B};",
        1,
        "what `Thing` does with `A`",
        "define it",
    );
    told(
        "",
        "static Thing t(A, B);",
        1,
        "what `Thing` does with `A`",
        "define it",
    );
    told(
        "",
        "nop add(B, A, C);",
        1,
        "`nop` is a statement of the chip",
        "`nop(…);`",
    );
    told(
        "",
        "mov(A, B);\nall add(B, A, C); mov(D, B);",
        2,
        "`all` is a statement of the chip",
        "`all(…);`",
    );
    told(
        "",
        "nop all();",
        1,
        "`nop` is not a type",
        "ends before the next one",
    );
    told(
        "",
        "foo all();",
        1,
        "`foo` is not a type",
        "ends before the next one",
    );
    told(
        "",
        "foo neg(1, 2);",
        1,
        "`neg` is a statement of the chip",
        "rename the variable",
    );
    whole(
        "struct P { int a; int b; }; enum E { X, Y };\nint main() { P p{1, 2}; E e(Y); std::ofstream f(\"x\"); std::list<areg_t> l{A, B}; std::set<int> s(f, 3); int all(4); scamp5_in(A, p.b + e + all); }",
        "scamp5_in(A, 7);",
    );
}

/// What compilers know beforehand, and what is written for them alone.
#[test]
fn attributes_and_predefined_names() {
    whole(
        "[[nodiscard]] int f([[maybe_unused]] int a) { return 3; }\n\
         struct [[gnu::packed]] P { [[maybe_unused]] int n; };\n\
         int main() { [[maybe_unused]] int k = f(1); int all[3] = {1, 2, 3}; int one[] = {0};\n\
         switch (k) { case 3: scamp5_in(A, 1); [[fallthrough]]; case 4: scamp5_in(A, 2); }\n\
         scamp5_in(A, all[one[0]]); [[likely]] scamp5_in(A, __LINE__); }",
        "scamp5_in(A, 1); scamp5_in(A, 2); scamp5_in(A, 1); scamp5_in(A, 5);",
    );
    let long = "const char *name() { return __func__; }\n#define LINE __LINE__\nstruct S { int n; int size() { return (int)strlen(__func__); } };\n";
    numbers_with(
        long,
        "S s{1}; auto l = [] { return (int)strlen(__func__); };\n\
         scamp5_in(A, strcmp(name(), \"name\")); scamp5_in(A, strcmp(__FUNCTION__, \"main\")); scamp5_in(A, s.size()); scamp5_in(A, l());\n\
         scamp5_in(A, LINE); scamp5_in(A, strcmp(__FILE__, \"p.cpp\"));",
        &[0, 0, 4, 10, 7, 0],
    );
    told(
        "",
        "vs_post_text(\"%s\", missing);",
        1,
        "`missing` is not declared",
        "declare it",
    );
}

/// Statements that a compiler warns of.
#[test]
fn statements_that_do_nothing_are_warned_of() {
    for (inside, help) in [
        ("all;", "`all(…);`"),
        ("add;", "`add(…);`"),
        ("A;", "or remove it"),
        ("A + B;", "write what to do with it, such as"),
    ] {
        let text = format!("int main() {{ mov(A, B);\n{inside} }}");
        let warnings = expand(&text, &[]).unwrap().warnings;
        let found = warnings.iter().any(|it| {
            it.message == "this statement does nothing"
                && it.help.as_deref().unwrap_or_default().contains(help)
        });
        assert!(found, "{text}: {warnings:?}");
    }
    told("", "foo;", 1, "`foo` is not declared", "");
    let quiet = expand("int n; int main() { n; mov(A, B); }", &[]).unwrap();
    assert!(quiet.warnings.is_empty());
}
