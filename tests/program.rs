//! Programs as text: what is printed reads back as the same, no text breaks the parser, every
//! mistake has its message at its place, and every shipped program is in order.

use std::{collections::BTreeMap, fs, path::Path};

use amacrine::{
    config::{Place, Severity},
    event::{Polarity, readout::scan::Order},
    isa::{
        Analog, Bit, Device, Digital, Direction, Primitive, Source, Target,
        text::{Argument, Expression, Operator, Statement, Term},
    },
    program::{
        Action, Cost, ExpectedWords, Host, Program, Syntax, stored,
        syntax::{Comment, Item, Node},
        vendor_text,
    },
};
use proptest::prelude::*;

// ---- arbitrary programs -----------------------------------------------------------------

fn name() -> impl Strategy<Value = String> {
    "[a-zA-Z_][a-zA-Z0-9_]{0,7}".prop_filter("a word of the frame language", |name| {
        !["const", "init", "frame", "repeat"].contains(&name.as_str())
    })
}

fn expression() -> impl Strategy<Value = Expression> {
    let of = |term| Expression {
        term,
        place: Place::default(),
    };
    let leaf = prop_oneof![
        name().prop_map(Term::Name),
        (0u32..5000).prop_map(|n| Term::Number(f64::from(n))),
        (0.0f64..1e6).prop_map(Term::Number),
        (prop_oneof![Just("X"), Just("R")], any::<bool>(), name()).prop_map(
            |(base, opposite, direction)| Term::Of {
                base: base.to_owned(),
                opposite,
                direction
            }
        ),
    ];
    leaf.prop_map(of).prop_recursive(4, 16, 2, move |inner| {
        let operator = prop_oneof![
            Just(Operator::Add),
            Just(Operator::Subtract),
            Just(Operator::Multiply),
            Just(Operator::Divide),
            Just(Operator::Remainder),
        ];
        prop_oneof![
            inner
                .clone()
                .prop_map(move |e| of(Term::Negate(Box::new(e)))),
            (operator, inner.clone(), inner).prop_map(move |(operator, left, right)| of(
                Term::Binary {
                    operator,
                    left: Box::new(left),
                    right: Box::new(right),
                }
            )),
        ]
    })
}

fn statement() -> impl Strategy<Value = Node> {
    let group = prop::collection::vec(expression(), 0..3).prop_map(|items| Argument::Group {
        items,
        place: Place::default(),
    });
    let argument = prop_oneof![4 => expression().prop_map(Argument::One), 1 => group];
    (name(), prop::collection::vec(argument, 0..4)).prop_map(|(name, arguments)| {
        Node::Statement(Statement {
            name,
            name_place: Place::default(),
            arguments,
            place: Place::default(),
            origin: None,
        })
    })
}

fn comment() -> impl Strategy<Value = Comment> {
    prop_oneof![
        "[a-z ({;]{0,8}[a-z]".prop_map(|t| Comment::Line(format!(" {t}"))),
        "[a-z /\n;]{0,8}".prop_map(Comment::Block),
    ]
}

fn item(node: impl Strategy<Value = Node>) -> impl Strategy<Value = Item> {
    (node, any::<bool>(), prop::option::of(comment())).prop_map(|(node, blank_before, trailing)| {
        let trailing = match node {
            Node::Comment(_) => None,
            _ => trailing,
        };
        Item {
            node,
            blank_before,
            trailing,
            place: Place::default(),
        }
    })
}

/// Nothing stands before the first item that a blank line could keep apart from it.
fn list(items: impl Strategy<Value = Item>) -> impl Strategy<Value = Vec<Item>> {
    prop::collection::vec(items, 0..5).prop_map(|mut items| {
        if let Some(first) = items.first_mut() {
            first.blank_before = false;
        }
        items
    })
}

fn body() -> impl Strategy<Value = Vec<Item>> {
    let leaf = prop_oneof![statement(), comment().prop_map(Node::Comment)];
    let leaf = item(leaf).boxed();
    let deeper = leaf.clone().prop_recursive(3, 24, 4, |inner| {
        item((expression(), list(inner)).prop_map(|(times, body)| Node::Repeat { times, body }))
    });
    list(prop_oneof![leaf, deeper])
}

fn syntax() -> impl Strategy<Value = Syntax> {
    let constant = (name(), expression()).prop_map(|(name, value)| Node::Const {
        name,
        name_place: Place::default(),
        value,
    });
    let top = prop_oneof![
        constant,
        body().prop_map(Node::Init),
        body().prop_map(Node::Frame),
        statement(),
        comment().prop_map(Node::Comment),
    ];
    let header = prop::option::of("[a-z ]{1,9}")
        .prop_map(|t| t.map_or(vec![], |t| vec![format!(" title = \"{t}\"")]));
    let footer = prop::option::of(any::<u16>()).prop_map(|on| {
        on.map_or(vec![], |on| {
            vec![
                " [events]".to_owned(),
                format!(" on = {on}"),
                " off = 0".to_owned(),
            ]
        })
    });
    (header, list(item(top)), footer).prop_map(|(header, items, footer)| Syntax {
        header,
        items,
        footer,
    })
}

proptest! {
    #[test]
    fn what_is_printed_reads_back_as_the_same(syntax in syntax()) {
        let text = syntax.to_string();
        let program = Program::parse("test.scamp", &text);
        prop_assert!(program.is_ok(), "{:?}\n{text}", program.err());
        let back = program.unwrap().syntax;
        prop_assert_eq!(&back, &syntax, "{}", text);
        prop_assert_eq!(back.to_string(), text);
    }

    #[test]
    fn no_bytes_break_the_parser(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        no_panic(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn no_heap_of_words_breaks_the_parser(words in prop::collection::vec(prop::sample::select(WORDS), 0..60)) {
        no_panic(&words.join(" "));
        no_panic(&words.concat());
    }

    #[test]
    fn words_read_back_as_the_same_words(calls in prop::collection::vec(prop::sample::select(CALLS), 0..12)) {
        let text = calls.join("\n");
        let device = Device::scamp5();
        // Calls are drawn blindly, so some programs are refused; they are no test of this.
        let Ok(first) = Program::read("a", &text).expand(&device, &BTreeMap::new()) else {
            return Ok(());
        };
        let printed = vendor_text(&first.code, first.bare, &device);
        let second = Program::read("b", &printed).expand(&device, &BTreeMap::new());
        prop_assert!(second.is_ok(), "{:?}\n{printed}", second.err());
        let second = second.unwrap();
        prop_assert_eq!(flat(&first.code.frame), flat(&second.code.frame), "{}", printed);
    }
}

const WORDS: &[&str] = &[
    "const",
    "init",
    "frame",
    "repeat",
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    ",",
    ";",
    "=",
    "-",
    "*",
    "//!",
    "//=",
    "//",
    "/*",
    "*/",
    "\n",
    "A",
    "R5",
    "mov",
    "mov(A, B);",
    "add(A, B, C);",
    "1e9",
    "0x",
    "3",
    "..",
    "\"",
    "title = 3",
    "é",
    "east",
    "SET",
    "scamp5_in(A, 3);",
    "%",
    "/",
];

const CALLS: &[&str] = &[
    "mov(A, B);",
    "abs(A, B);",
    "diva(A, B, C);",
    "bus({A, B}, {C, D, E, F});",
    "bus({A}, {});",
    "bus3(A, B, C, D);",
    "sq(A, B);",
    "where(A, IN);",
    "WHERE(R5, FLAG);",
    "all();",
    "mov2x(A, B, east, north);",
    "gauss(A, B, 2);",
    "gaussh(A, B);",
    "SET(R0, R1);",
    "CLR(R5, R6);",
    "NOR(R5, R6, SELECT, RECT);",
    "MUX(R5, R6, R7, R8);",
    "NOT(R5);",
    "DNEWS(R5, R6, alldir, 1);",
    "PROP1();",
    "get_image(A, B);",
    "scamp5_get_image(A, B, 3);",
    "scamp5_in(A, -7.25, B);",
    "scamp5_load_in(A, 5);",
    "scamp5_load_in(-5);",
    "scamp5_load_dac(A, 77);",
    "scamp5_shift(A, 5, -4);",
    "scamp5_shift(R5, -3, 2);",
    "scamp5_shift(R5, 3, -2, 1);",
    "scamp5_diffuse(A, 3);",
    "scamp5_diffuse(A, 3, 1, 0, B);",
    "scamp5_flood(R5, R6, 1);",
    "scamp5_flood(R5, R6, 0, 3, true);",
    "scamp5_scan_events(R5, off3, 20);",
    "scamp5_scan_events(R5, buffer, 20, 1, 0);",
    "scamp5_scan_events_rc(R5, off, 20);",
    "scamp5_output_image(A);",
    "scamp5_read_areg(A, 3, 4);",
    "scamp5_scan_areg(A, buffer, 0, 0, 255, 255, 8, 8);",
    "scamp5_scan_areg_mean_8x8(A, buffer);",
    "scamp5_scan_areg_8x8(A, buffer);",
    "scamp5_scan_dreg(R5, mem);",
    "scamp5_scan_boundingbox(R5, vec);",
    "scamp5_global_sum_16(A);",
    "scamp5_global_sum_64(A, NULL);",
    "scamp5_global_sum_fast(A);",
    "scamp5_global_sum_sparse(A);",
    "scamp5_global_or(R5);",
    "scamp5_global_count(R5, A, 1);",
    "scamp5_load_point(R5, 1, 2);",
    "scamp5_load_rect(R5, 1, 2, 3, 4);",
    "scamp5_load_pattern(R5, 1, 2, 3, 4);",
    "scamp5_select_point(1, 2);",
    "scamp5_select_rect(1, 2, 3, 4);",
    "scamp5_select_pattern(1, 2, 3, 4);",
    "scamp5_select_row(3);",
    "scamp5_select_colx(3, 192);",
    "scamp5_draw_begin(R5); scamp5_draw_line(0, 0, 9, 9); scamp5_draw_circle(5, 5, 3); scamp5_draw_negate(); scamp5_draw_end();",
    "scamp5_kernel_begin(); repeat 3 { movx(A, A, east); repeat 2 { NOT(R5); } } scamp5_kernel_end();",
];

fn no_panic(text: &str) {
    let program = Program::read("test.scamp", text);
    let _ = program.syntax.to_string();
    let _ = program.expand(&Device::scamp5(), &BTreeMap::new());
}

/// Steps without the lines that they came from.
fn flat(steps: &[amacrine::program::Step]) -> Vec<String> {
    let text = |step: &amacrine::program::Step| match &step.action {
        Action::Repeat { times, body } => format!("{times} {:?}", flat(body)),
        other => format!("{other:?}"),
    };
    steps.iter().map(text).collect()
}

// ---- the language -----------------------------------------------------------------------

fn frame(text: &str) -> Vec<amacrine::program::Step> {
    let program = Program::parse("test.scamp", text).unwrap_or_else(|e| panic!("{e:?}"));
    let expansion = program.expand(&Device::scamp5(), &BTreeMap::new());
    expansion.unwrap_or_else(|e| panic!("{e:?}")).code.frame
}

#[test]
fn a_vendor_kernel_is_a_whole_program() {
    let text = "
        scamp5_kernel_begin();
            /* several on a line */ mov(A, B); add(A, A, C); // and a comment
            bus(NEWS, A); bus(B, XW);
            MOV(S0, RF); WHERE(R5); ALL();
        scamp5_kernel_end();";
    let program = Program::parse("kernel.cpp", text).unwrap();
    let expansion = program.expand(&Device::scamp5(), &BTreeMap::new()).unwrap();
    assert!(expansion.bare && expansion.code.init.is_empty());
    assert_eq!(
        Cost::of(&expansion.code.frame, &Device::scamp5()).words.0,
        9
    );
}

/// Shapes in which programs for the chip come: with the words that each must have, and
/// without a warning. Written for this test after the public examples, not taken from them.
#[test]
fn text_for_the_chip_runs_unmodified() {
    let shapes = [
        // Event readout of a tutorial, as the host's loop has it.
        (
            "scamp5_in(E, 12, NEWS);\r\nscamp5_kernel_begin();\r\n\tget_image(C,D);\r\n\tsub(A,C,F); // since then\r\n\
             \tmov(F,C);\r\n\tabs(B,A);\r\n\tsub(A,B,E);\r\n\twhere(A);\r\n\t\tMOV(R5,FLAG);\r\n\tall();\r\n\
             scamp5_kernel_end();\r\nscamp5_scan_events(R5, buffer, 100);\r\n",
            2 + 6 + 2 + 2 + 6 + 2 + 1 + 1 + 1,
        ),
        // What kernel compilers emit: one macro a line, notes between.
        (
            "// input: A   output: A B\n/* cost 18 */\ndiv(B, C, D, A);\nmovx(C, B, south);\n\
             mov2x(D, B, north, west);\nadd2x(E, B, C, east, east);\nsub2x(A, D, south, west, E);\n\
             subx(B, C, north, A);\naddx(C, B, D, west);\nneg(D, C);\nadd(A, A, B, D);\nres(E, F);\ndivq(B, A);",
            5 + 2 * 8 + 3 + 2,
        ),
        // A dynamic kernel, several statements on a line, hexadecimal and C numbers.
        (
            "scamp5_dynamic_kernel_begin(); bus(NEWS,B);bus(B,XW); /* one to the right */ nop();\n\
             scamp5_dynamic_kernel_end(); scamp5_load_in(A, 0x10); scamp5_in(B, -7);",
            3 + 2 + 2,
        ),
        // Flooding, its registers by their other names.
        (
            "CLR(RN,RS,RE,RW); SET(RN,RS,RE,RW);\nSET(RF);MOV(RP,S0);MOV(RF,S1);\nPROP0();PROP0();\n\
             MOV(S0,RP);SET(RF);ALL();",
            2 + 3 + 4 + 3,
        ),
        // Diffusion inside regions, an old overload, a generic bus, a comment at the end.
        (
            "NOT(R1,R5);MOV(R2,R1);gaussh(A,A,4);mov(B,A,east);sub(C,B,west,A);bus({D,E},{A,B,C});// end",
            2 + 9 + 2 + 2 + 1,
        ),
    ];
    for (text, words) in shapes {
        let device = Device::scamp5();
        let program = Program::parse("kernel.cpp", text).unwrap_or_else(|e| panic!("{e:?}"));
        let expansion = program.expand(&device, &BTreeMap::new());
        let expansion = expansion.unwrap_or_else(|e| panic!("{e:?}"));
        assert!(
            expansion.warnings.is_empty(),
            "{text}: {:?}",
            expansion.warnings
        );
        assert_eq!(
            Cost::of(&expansion.code.frame, &device).words.0,
            words,
            "{text}"
        );
        let printed = program.syntax.to_string();
        let again = Program::parse("again", &printed).unwrap();
        assert_eq!(again.syntax.to_string(), printed);
    }
}

#[test]
fn every_step_carries_its_line() {
    let steps = frame("mov(A, B);\n\nadd(A, A, C); mov(B, A);");
    let lines: Vec<u32> = steps.iter().map(|s| s.line).collect();
    assert_eq!(lines, [1, 1, 3, 3, 3, 3]);
}

#[test]
fn constants_can_be_set_from_outside() {
    let text = "const t = 10; const twice = 2 * t; scamp5_in(A, -twice);";
    let program = Program::parse("test.scamp", text).unwrap();
    let value = |overrides: &[(&str, f64)]| {
        let overrides = overrides.iter().map(|(n, v)| ((*n).to_owned(), *v));
        let expansion = program.expand(&Device::scamp5(), &overrides.collect());
        match expansion.unwrap().code.frame[0].action {
            Action::Host(Host::LoadIn { value }) => value,
            _ => panic!("no LoadIn"),
        }
    };
    assert_eq!(value(&[]), -20.0);
    assert_eq!(value(&[("t", 7.5)]), -15.0);
    assert_eq!(value(&[("twice", 3.0)]), -3.0);
    let wrong = program.expand(&Device::scamp5(), &BTreeMap::from([("tt".to_owned(), 1.0)]));
    let help = wrong.unwrap_err().faults[0].fault.help.clone();
    assert_eq!(help.as_deref(), Some("did you mean `t`?"));
}

#[test]
fn a_constant_can_name_a_register() {
    assert_eq!(
        flat(&frame("const memory = D; mov(memory, A);")),
        flat(&frame("mov(D, A);"))
    );
}

#[test]
fn a_buffer_says_polarity_and_channel() {
    let events = |text: &str| match frame(text).remove(0).action {
        Action::Host(host) => host,
        other => panic!("{other:?}"),
    };
    assert_eq!(
        events("scamp5_scan_events(R5, off2);"),
        Host::ScanEvents {
            source: Digital(5),
            polarity: Polarity::Off,
            channel: 2,
            slots: 1000,
            order: Order::default(),
            by_rows: false,
        }
    );
    assert!(matches!(
        events("scamp5_scan_events(R5, BUFFER, 4000, 0, 1);"),
        Host::ScanEvents {
            polarity: Polarity::On,
            channel: 0,
            slots: 4000,
            order: Order {
                from_left: false,
                from_bottom: true
            },
            by_rows: false,
            ..
        }
    ));
    assert!(matches!(
        events("scamp5_scan_events_rc(R5, off, 4);"),
        Host::ScanEvents {
            polarity: Polarity::Off,
            slots: 4,
            order: Order {
                from_left: false,
                from_bottom: false
            },
            by_rows: true,
            ..
        }
    ));
    assert_eq!(
        events("scamp5_output_image(NEWS);"),
        Host::ReadAnalog { source: Analog(6) }
    );
}

#[test]
fn a_repetition_costs_as_often_as_it_runs_and_is_stored_once() {
    let device = Device::scamp5();
    let steps = frame("repeat 10 { mov(A, B); repeat 3 { NOT(R5); } }");
    assert_eq!(Cost::of(&steps, &device).words.0, 80);
    assert_eq!(stored(&steps, &device).0, 4);
    assert_eq!(Cost::of(&steps, &device).array_us, 8.0);
}

#[test]
fn a_readout_costs_by_its_slots() {
    let device = Device::scamp5();
    let cost = |slots: u32| {
        Cost::of(
            &frame(&format!("scamp5_scan_events(R5, on, {slots});")),
            &device,
        )
    };
    assert_eq!(cost(100).host_us, 91.0);
    assert_eq!(cost(200).host_us, 182.0);
}

/// What the rules allow must not be refused, nor warned of.
#[test]
fn legal_programs_are_left_alone() {
    for text in [
        "sub(A, B, B);",
        "add(A, A, B);",
        "add(A, B, A);",
        "sub(A, A, B);",
        "mov(A, A);",
        "where(A); mov(B, C);",
        "OR(R5, R6); NOR(R5, R6); NOT(R5);",
        "where(A); all(); mov2x(A, B, east, north);",
        "where(A); ALL(); add2x(A, B, C, east, north);",
        "abs(A, B); where(A); mov(C, D); all();",
        "AND(R5, R6, R7); SET(R0); MOV(R12, R5); MOV(R8, R12);",
        "diva(A, E, F); diva(B, E, F); mov(E, A); mov(F, E);",
        "init { where(A); } frame { all(); mov2x(A, B, east, north); }",
        "repeat 3 { where(A); mov(B, C); all(); sub2x(A, B, east, north, C); }",
        "",
        "// nothing",
    ] {
        let program = Program::parse("test.scamp", text).unwrap();
        let expansion = program.expand(&Device::scamp5(), &BTreeMap::new());
        let expansion = expansion.unwrap_or_else(|e| panic!("{text}: {e:?}"));
        assert!(
            expansion.warnings.is_empty(),
            "{text}: {:?}",
            expansion.warnings
        );
    }
}

#[test]
fn blessing_changes_the_expectation_alone() {
    let text = "//! title = \"t\"\nmov(A,B);   // as written\n\n//= [words]\n//= init = 1\n//= frame = 1\n";
    let program = Program::parse("test.scamp", text).unwrap();
    let mut expectation = program.expectation.clone();
    expectation.words = Some(ExpectedWords { init: 0, frame: 2 });
    let blessed = program.blessed(&expectation).unwrap();
    let again = Program::parse("test.scamp", &blessed).unwrap();
    assert_eq!(again.expectation, expectation);
    assert!(blessed.starts_with("//! title = \"t\"\nmov(A,B);   // as written\n"));
}

// ---- the shipped programs ---------------------------------------------------------------

fn shipped() -> Vec<(String, String)> {
    let mut found = Vec::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("programs");
    for folder in fs::read_dir(root).unwrap() {
        for file in fs::read_dir(folder.unwrap().path()).unwrap() {
            let path = file.unwrap().path();
            found.push((
                path.display().to_string(),
                fs::read_to_string(&path).unwrap(),
            ));
        }
    }
    assert!(found.len() >= 4);
    found
}

#[test]
fn shipped_programs_are_canonical_silent_and_cost_what_they_say() {
    for (file, text) in shipped() {
        let program = Program::parse(&file, &text).unwrap_or_else(|e| panic!("{e:?}"));
        assert_eq!(
            program.syntax.to_string(),
            text,
            "{file}: amacrine asm --format"
        );
        for chip in Device::shipped() {
            let device = Device::find(chip).unwrap();
            let expansion = program.expand(&device, &BTreeMap::new());
            let expansion = expansion.unwrap_or_else(|e| panic!("{e:?}"));
            assert!(
                expansion.warnings.is_empty(),
                "{file}: {:?}",
                expansion.warnings
            );
            let words = |steps| Cost::of(steps, &device).words.0;
            let got = ExpectedWords {
                init: words(&expansion.code.init),
                frame: words(&expansion.code.frame),
            };
            assert_eq!(program.expectation.words, Some(got), "{file}");
        }
    }
}

// ---- mistakes ---------------------------------------------------------------------------

/// Every file in `tests/bad/program` says on top, in lines `// 3:5 error: message | help`,
/// what is to be found in it: all of it, and nothing else.
#[test]
fn every_mistake_has_its_message_at_its_place() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad/program");
    let mut files: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|f| f.unwrap().path())
        .collect();
    files.sort();
    assert!(files.len() > 20);
    for path in files {
        let text = fs::read_to_string(&path).unwrap();
        let expected: Vec<&str> = text
            .lines()
            .filter_map(|line| line.strip_prefix("// "))
            .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()))
            .collect();
        let program = Program::read("file.scamp", &text);
        let faults = match program.expand(&Device::scamp5(), &BTreeMap::new()) {
            Err(faults) => faults,
            Ok(expansion) => program
                .warnings(&expansion)
                .unwrap_or_else(|| panic!("{}: nothing wrong", path.display())),
        };
        let found: Vec<String> = faults
            .faults
            .iter()
            .map(|l| {
                let severity = match l.fault.severity {
                    Severity::Error => "error",
                    Severity::Warning => "warning",
                };
                let help = l.fault.help.as_deref().unwrap_or("");
                let (line, column) = (l.line, l.column);
                format!("{line}:{column} {severity}: {} | {help}", l.fault.message)
            })
            .collect();
        assert_eq!(found, expected, "{}", path.display());
        assert!(
            faults
                .faults
                .iter()
                .all(|l| !l.fault.label.is_empty() && l.fault.help.is_some())
        );
    }
}

/// Every call of the list, so that none is only drawn where it is refused.
#[test]
fn each_call_reads_back_as_the_same_words() {
    let device = Device::scamp5();
    for call in CALLS {
        let first = frame(call);
        let code = amacrine::program::Code {
            init: Vec::new(),
            frame: first.clone(),
        };
        let printed = vendor_text(&code, true, &device);
        assert_eq!(flat(&first), flat(&frame(&printed)), "{call}\n{printed}");
    }
}

// ---- what the shipped programs compute --------------------------------------------------

/// The array in the plainest way: f64 planes, pixels off it hold 0 and are on. Knows the words
/// that the shipped programs use, and refuses others.
struct Slow {
    height: isize,
    width: isize,
    light: Vec<f64>,
    pix: Vec<f64>,
    analog: Vec<Vec<f64>>,
    bits: Vec<Vec<bool>>,
    flag: Vec<bool>,
    input: f64,
    /// Largest and smallest value that was stored.
    range: (f64, f64),
}

impl Slow {
    fn new(height: usize, width: usize) -> Self {
        let size = height * width;
        Self {
            height: height as isize,
            width: width as isize,
            light: vec![0.0; size],
            pix: vec![0.0; size],
            analog: vec![vec![0.0; size]; 7],
            bits: vec![vec![false; size]; 13],
            flag: vec![true; size],
            input: 0.0,
            range: (0.0, 0.0),
        }
    }

    fn expose(&mut self, light: &[f64]) {
        self.light = light.to_vec();
        self.pix = light.iter().map(|l| l / 2.0 - 127.0).collect();
    }

    /// The pixel in a direction, if it is on the array.
    fn neighbour(&self, at: usize, direction: Direction) -> Option<usize> {
        let (dy, dx) = direction.step();
        let (y, x) = (at as isize / self.width + dy, at as isize % self.width + dx);
        let inside = (0..self.height).contains(&y) && (0..self.width).contains(&x);
        inside.then_some((y * self.width + x) as usize)
    }

    fn source(&self, source: Source, at: usize) -> f64 {
        match source {
            Source::Register(r) => self.analog[usize::from(r.0)][at],
            Source::Pix => self.pix[at],
            Source::In => self.input,
            Source::Neighbour(d) => self.neighbour(at, d).map_or(0.0, |n| self.analog[6][n]),
        }
    }

    fn sum(&self, sources: &[Source], at: usize) -> f64 {
        sources.iter().map(|s| self.source(*s, at)).sum()
    }

    fn bit(&self, bit: Bit, at: usize) -> bool {
        match bit {
            Bit::Register(r) => self.bits[usize::from(r.0)][at],
            Bit::Flag => self.flag[at],
            Bit::Select | Bit::Rect => panic!("not here"),
        }
    }

    fn run(&mut self, steps: &[amacrine::program::Step]) {
        let size = self.flag.len();
        for step in steps {
            match &step.action {
                Action::Word(Primitive::Nop) | Action::Host(Host::ScanEvents { .. }) => {}
                Action::Word(Primitive::ResetPix) => self.pix = vec![-127.0; size],
                Action::Word(Primitive::All) => self.flag = vec![true; size],
                Action::Word(Primitive::Where { sources }) => {
                    self.flag = (0..size).map(|at| self.sum(sources, at) > 0.0).collect();
                }
                Action::Word(Primitive::WhereBit { sources }) => {
                    self.flag = (0..size)
                        .map(|at| sources.iter().any(|b| self.bit(*b, at)))
                        .collect();
                }
                Action::Word(Primitive::Or { target, sources }) => {
                    self.bits[usize::from(target.0)] = (0..size)
                        .map(|at| sources.iter().any(|b| self.bit(*b, at)))
                        .collect();
                }
                Action::Word(Primitive::Bus { targets, sources }) => self.bus(targets, sources),
                Action::Host(Host::LoadIn { value }) => self.input = *value,
                other => panic!("{other:?}"),
            }
        }
    }

    fn bus(&mut self, targets: &[Target], sources: &[Source]) {
        let drive: Vec<f64> = (0..self.flag.len())
            .map(|at| -self.sum(sources, at) / targets.len() as f64)
            .collect();
        for target in targets {
            let mut next = match target {
                Target::Register(r) => self.analog[usize::from(r.0)].clone(),
                Target::Neighbour(_) => self.analog[6].clone(),
            };
            for (at, stored) in next.iter_mut().enumerate() {
                // Who drives this pixel's cell: itself, or the one that calls it its neighbour.
                let driver = match target {
                    Target::Register(_) => Some(at),
                    Target::Neighbour(d) => self.neighbour(at, d.opposite()),
                };
                if driver.is_none_or(|d| self.flag[d]) {
                    *stored = driver.map_or(0.0, |d| drive[d]);
                    self.range.0 = self.range.0.min(*stored);
                    self.range.1 = self.range.1.max(*stored);
                }
            }
            match target {
                Target::Register(r) => self.analog[usize::from(r.0)] = next,
                Target::Neighbour(_) => self.analog[6] = next,
            }
        }
    }
}

/// Correlation with zeros around.
fn correlate(light: &[f64], (height, width): (usize, usize), kernel: &[Vec<f64>]) -> Vec<f64> {
    let (ry, rx) = (kernel.len() / 2, kernel[0].len() / 2);
    let mut out = vec![0.0; light.len()];
    for (at, sum) in out.iter_mut().enumerate() {
        for (j, row) in kernel.iter().enumerate() {
            for (i, weight) in row.iter().enumerate() {
                let (y, x) = (at / width + j, at % width + i);
                if (ry..height + ry).contains(&y) && (rx..width + rx).contains(&x) {
                    *sum += weight * light[(y - ry) * width + x - rx];
                }
            }
        }
    }
    out
}

/// Every shipped program that says what it computes, run on two pictures: the drive moves by
/// exactly the stated kernel, events are where it moved by more than the threshold, and the
/// memory follows there alone. No store leaves the range for light of 0 to 254.
fn computes(size: (usize, usize), first: &[f64], second: &[f64]) {
    let device = Device::scamp5();
    for (file, text) in shipped() {
        let program = Program::parse(&file, &text).unwrap();
        let Some(computes) = &program.settings.computes else {
            continue;
        };
        let expansion = program.expand(&device, &BTreeMap::new()).unwrap();
        let filtered = |light: &[f64]| -> Vec<f64> {
            let sums = correlate(light, size, &computes.kernel);
            sums.iter().map(|s| s * computes.scale).collect()
        };
        let mut slow = Slow::new(size.0, size.1);
        slow.expose(first);
        if let Some(register) = &computes.register {
            slow.run(&expansion.code.frame);
            let at = device
                .registers()
                .analog
                .iter()
                .position(|n| n == register)
                .unwrap();
            assert_eq!(slow.analog[at], filtered(first), "{file}");
        } else {
            slow.run(&expansion.code.init);
            // A comparison below may clip, its sign stays; the filter itself may not.
            in_range(&file, slow.range);
            let before = slow.analog[4].clone();
            slow.expose(second);
            slow.run(&expansion.code.frame);
            let threshold = expansion.constants[computes.threshold.as_ref().unwrap()];
            let moved = filtered(second).into_iter().zip(filtered(first));
            for (at, (new, old)) in moved.enumerate() {
                let drive = new - old;
                assert_eq!(slow.bits[5][at], drive > threshold, "{file}: ON at {at}");
                assert_eq!(slow.bits[6][at], drive < -threshold, "{file}: OFF at {at}");
                let fired = drive.abs() > threshold;
                let kept = if fired {
                    before[at] - drive
                } else {
                    before[at]
                };
                assert_eq!(slow.analog[4][at], kept, "{file}: memory at {at}");
            }
            assert!(slow.flag.iter().all(|f| *f), "{file} leaves FLAG whole");
        }
        if computes.threshold.is_none() {
            in_range(&file, slow.range);
        }
    }
}

fn in_range(file: &str, (low, high): (f64, f64)) {
    assert!(-128.0 <= low && high <= 127.0, "{file}: {low} to {high}");
}

proptest! {
    #[test]
    fn shipped_programs_compute_what_they_say(
        (size, first, second) in (1usize..9, 1usize..9).prop_flat_map(|(h, w)| {
            let picture = || prop::collection::vec((0u8..255).prop_map(f64::from), h * w);
            (Just((h, w)), picture(), picture())
        })
    ) {
        computes(size, &first, &second);
    }

    /// Black and white alone: the widest sums.
    #[test]
    fn shipped_programs_stay_in_range(
        (size, first, second) in (1usize..9, 1usize..9).prop_flat_map(|(h, w)| {
            let picture = || prop::collection::vec(prop::sample::select(vec![0.0, 254.0]), h * w);
            (Just((h, w)), picture(), picture())
        })
    ) {
        computes(size, &first, &second);
    }
}

/// The kernel that a program states is what it was chosen for.
#[test]
fn the_centre_surround_kernel_is_ternary_and_sums_to_zero() {
    let text = fs::read_to_string("programs/rgc/centre_surround.scamp").unwrap();
    let program = Program::parse("rgc", &text).unwrap();
    let kernel = program.settings.computes.unwrap().kernel;
    let weights: Vec<f64> = kernel.concat();
    assert_eq!(weights.len(), 25);
    assert_eq!(weights.iter().sum::<f64>(), 0.0);
    assert!(weights.iter().all(|w| [-1.0, 0.0, 1.0].contains(w)));
}

/// Propagation reads and writes R12, and DNEWS may read what it writes: these are the networks',
/// not one-bit logic that takes two words.
#[test]
fn networks_over_neighbours_are_not_warned_of() {
    let device = Device::scamp5();
    for (text, warned) in [
        ("PROP_0();", false),
        ("PROP_1();", false),
        ("DNEWS0(R5, R5);", false),
        ("WHERE(FLAG);", false),
        ("NOR(R5, R5, R6);", true),
    ] {
        let program = Program::parse("networks.scamp", text).unwrap();
        let expansion = program.expand(&device, &BTreeMap::new()).unwrap();
        let told = expansion.warnings.iter().map(|fault| &fault.message);
        let told: Vec<_> = told.filter(|m| m.contains("in one word")).collect();
        assert_eq!(!told.is_empty(), warned, "{text} {told:?}");
    }
}
