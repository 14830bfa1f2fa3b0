//! The shipped chips, held against the published tables: every macro's words, every name; and
//! one message for each way in which a chip's files can be wrong.

use std::{collections::BTreeMap, fs, path::Path};

use amacrine::{
    config::Located,
    isa::{Device, Figure, LoadError},
    program::{Action, Program, Step, stored},
};
use syn::{
    Expr, Pat, Token,
    parse::{ParseStream, Parser},
    punctuated::Punctuated,
    visit::{self, Visit},
};

/// Words as the vendor's headers have them, one call for each overload.
const WORDS: &[(&str, u64)] = &[
    // One word each.
    ("nop()", 1),
    ("rpix()", 1),
    ("bus(A)", 1),
    ("bus(A, B)", 1),
    ("bus(A, B, C)", 1),
    ("bus(A, B, C, D)", 1),
    ("bus(A, B, C, D, E)", 1),
    ("bus({A, B}, {C, D, E})", 1),
    ("bus(B, XW)", 1),
    ("bus(XE, A)", 1),
    ("bus2(A, B)", 1),
    ("bus2(A, B, C)", 1),
    ("bus2(A, B, C, D)", 1),
    ("bus3(A, B, C, D)", 1),
    ("sq(A)", 1),
    ("sq(A, B)", 1),
    ("where(A)", 1),
    ("where(A, B)", 1),
    ("where(A, B, C)", 1),
    ("all()", 1),
    ("ALL()", 1),
    ("blurset()", 1),
    ("blur(A, B)", 1),
    ("blurh(A, B)", 1),
    ("blurv(A, B)", 1),
    ("SET(R5)", 1),
    ("SET(R5, R6, R7, R8)", 1),
    ("CLR(R5, R6)", 1),
    ("MOV(R5, R6)", 1),
    ("MOV(R5, FLAG)", 1),
    ("OR(R5, R6, R7)", 1),
    ("OR(R5, R6, R7, R8, R9)", 1),
    ("NOT(R5, R6)", 1),
    ("NOR(R5, R6, R7)", 1),
    ("WHERE(R5)", 1),
    ("WHERE(R5, R6, R7)", 1),
    ("DNEWS0(R5, R6)", 1),
    ("DNEWS1(R5, R6)", 1),
    // Analogue macros.
    ("res(A)", 2),
    ("res(A, B)", 3),
    ("mov(A, B)", 2),
    ("mov(A, A)", 2),
    ("mov(A, B, east)", 2),
    ("add(A, B, C)", 2),
    ("add(A, B, C, D)", 2),
    ("add(A, A, B)", 2),
    ("sub(A, B, C)", 2),
    ("sub(A, B, B)", 2),
    ("sub(A, A, B)", 2),
    ("sub(A, B, east, C)", 2),
    ("neg(A, B)", 2),
    ("abs(A, B)", 6),
    ("divq(A, B)", 2),
    ("div(A, B, C)", 5),
    ("div(A, B, C, D)", 5),
    ("diva(A, B, C)", 5),
    ("movx(A, B, east)", 2),
    ("movx(A, A, north)", 2),
    ("mov2x(A, B, south, west)", 2),
    ("addx(A, B, C, east)", 2),
    ("add2x(A, B, C, north, west)", 2),
    ("subx(A, B, east, C)", 2),
    ("sub2x(A, B, east, north, C)", 2),
    ("get_image(A)", 5),
    ("get_image(A, B)", 6),
    ("respix()", 3),
    ("respix(A)", 5),
    ("getpix(A, B)", 2),
    ("getpix(A, B, C)", 3),
    ("gauss(A, B)", 7),
    ("gauss(A, B, 5)", 11),
    ("gaussh(A, B, 2)", 5),
    ("gaussv(A, B, 2)", 5),
    ("newsblur(A, B)", 2),
    ("newsblur(A, B, 4)", 8),
    ("newsblurh(A, B)", 2),
    ("newsblurv(A, B)", 2),
    // One-bit macros.
    ("NOT(R5)", 2),
    ("OR(R5, R6)", 2),
    ("NOR(R5, R6)", 2),
    ("AND(R5, R6, R7)", 4),
    ("NAND(R5, R6, R7)", 4),
    ("ANDX(R5, R6, R7)", 3),
    ("NANDX(R5, R6, R7)", 3),
    ("IMP(R5, R6, R7)", 2),
    ("NIMP(R5, R6, R7)", 2),
    ("XORX(R5, R6, R7)", 6),
    ("XOR(R5, R6, R7)", 6),
    ("MUX(R5, R6, R7, R8)", 5),
    ("CLR_IF(R5, R6)", 2),
    ("REFRESH(R5)", 2),
    ("DNEWS(R5, R6, east)", 3),
    ("DNEWS(R5, R6, alldir)", 3),
    ("DNEWS(R5, R6, east, 0)", 3),
    ("DNEWS(R5, R6, east, 1)", 3),
    ("PROP0()", 2),
    ("PROP1()", 2),
    // What the host launches.
    ("scamp5_kernel_begin()", 0),
    ("scamp5_dynamic_kernel_begin()", 0),
    ("scamp5_dynamic_kernel_end()", 0),
    ("scamp5_kernel_end()", 0),
    ("scamp5_kernel_all()", 1),
    ("north(A, B)", 2),
    ("east(A, A)", 2),
    ("south(A, B)", 2),
    ("west(A, B)", 2),
    ("div2(A, B)", 5),
    ("div2_inplace(A)", 5),
    ("neg_inplace(A, A)", 4),
    ("add_twice(A, B, B)", 4),
    ("sub_inplace(A, B, A)", 4),
    ("scamp5_kernel_refresh_dreg()", 26),
    ("scamp5_in(A, 10)", 2),
    ("scamp5_in(A, 10, B)", 2),
    ("scamp5_load_in(A, 10)", 2),
    ("scamp5_load_in(10)", 0),
    ("scamp5_load_dac(A, 4095)", 2),
    ("scamp5_get_image(A, B)", 12),
];

fn expand(text: &str) -> Vec<Step> {
    let program = Program::parse("test", text).unwrap();
    let expansion = program.expand(&Device::scamp5(), &BTreeMap::new());
    expansion
        .unwrap_or_else(|e| panic!("{text}: {e}"))
        .code
        .frame
}

#[test]
fn every_macro_has_the_words_of_the_table() {
    for (call, words) in WORDS {
        let steps = expand(&format!("{call};"));
        assert_eq!(stored(&steps, &Device::scamp5()).0, *words, "{call}");
    }
}

#[test]
fn the_table_names_every_macro_and_every_primitive_form() {
    let device = Device::scamp5();
    let called = |name: &str| {
        WORDS
            .iter()
            .any(|(call, _)| call.starts_with(&format!("{name}(")))
            || ["scamp5_", "PROP_"].iter().any(|p| name.starts_with(p))
    };
    for callable in device.all_callables() {
        assert!(
            called(&callable.signature().name),
            "{}",
            callable.signature()
        );
    }
}

/// The primitives of a call as text: what a macro really does.
fn words(call: &str) -> String {
    let device = Device::scamp5();
    let text = |step: &Step| match &step.action {
        Action::Word(word) => word.text(&device),
        Action::Host(host) => host.text(&device),
        Action::Repeat { times, .. } => format!("repeat {times}"),
    };
    let steps = expand(&format!("{call};"));
    steps.iter().map(text).collect::<Vec<_>>().join("; ")
}

#[test]
fn directions_name_the_neighbour_that_is_read() {
    assert_eq!(words("movx(A, B, east)"), "bus(XW, B); bus(A, NEWS)");
    assert_eq!(words("movx(A, B, north)"), "bus(XS, B); bus(A, NEWS)");
    assert_eq!(words("mov2x(A, B, east, north)"), "bus(XW, B); bus(A, XN)");
    assert_eq!(
        words("sub2x(A, B, south, west, C)"),
        "bus(XN, B); bus(A, XW, C)"
    );
    assert_eq!(
        words("DNEWS(R5, R6, east)"),
        "CLR(R1, R2, R3, R4); SET(R4); DNEWS0(R5, R6)"
    );
    assert_eq!(
        words("DNEWS(R5, R6, alldir, 1)"),
        "CLR(R1, R2, R3, R4); SET(R3, R4, R1, R2); DNEWS1(R5, R6)"
    );
}

#[test]
fn sequences_of_the_table() {
    assert_eq!(
        words("abs(A, B)"),
        "bus(NEWS); bus(A, NEWS, B); bus(NEWS, B); where(B); bus(A, NEWS); all()"
    );
    assert_eq!(
        words("diva(A, B, C)"),
        "bus2(B, C, A); bus(NEWS, B, A); bus(A, NEWS, C); bus2(B, C, A); bus(A, B)"
    );
    assert_eq!(
        words("get_image(A, B)"),
        "bus(NEWS, PIX); bus(B, PIX); rpix(); rpix(); nop(); bus(A, B, NEWS, PIX)"
    );
    assert_eq!(
        words("MUX(R5, R6, R7, R8)"),
        "SET(R0); MOV(R12, R8); MOV(R0, R6); MOV(R12, R7); MOV(R5, R12)"
    );
    assert_eq!(
        words("XORX(R5, R6, R7)"),
        "NOT(R0, R7); NOR(R5, R6, R0); NOT(R0, R6); NOR(R6, R7, R0); nop(); OR(R5, R5, R6)"
    );
    assert_eq!(
        words("scamp5_in(A, -7)"),
        "scamp5_in(-7); bus(NEWS, IN); bus(A, NEWS)"
    );
}

#[test]
fn a_shift_costs_a_word_a_pixel_and_one_more_when_odd() {
    let cost = |call: &str| {
        let steps = expand(&format!("{call};"));
        amacrine::program::Cost::of(&steps, &Device::scamp5())
            .words
            .0
    };
    assert_eq!(cost("scamp5_shift(A, 4, 0)"), 4);
    assert_eq!(cost("scamp5_shift(A, -5, 0)"), 6);
    assert_eq!(cost("scamp5_shift(A, 2, -3)"), 6);
    assert_eq!(words("scamp5_shift(A, 1, 0)"), "bus(XE, A); bus(A, NEWS)");
    assert_eq!(words("scamp5_shift(A, 2, 0)"), "bus(XE, A); bus(A, XW)");
    assert_eq!(words("scamp5_shift(A, 0, -2)"), "bus(XS, A); bus(A, XN)");
    // Bits in place, so that no register but those of the directions is lost.
    assert_eq!(
        words("scamp5_shift(R5, 1, 0)"),
        "CLR(R1, R2, R3, R4); SET(R2); nop(); DNEWS0(R5, R5); CLR(R2, R4)"
    );
    assert_eq!(
        words("scamp5_shift(R5, 2, 0)"),
        "CLR(R1, R2, R3, R4); SET(R2); repeat 2; CLR(R2, R4)"
    );
    assert_eq!(
        words("scamp5_shift(R5, 0, -1, 1)"),
        "CLR(R1, R2, R3, R4); CLR(R2, R4); SET(R3); nop(); DNEWS1(R5, R5)"
    );
    assert_eq!(cost("scamp5_shift(R5, -64, 65)"), 2 + 2 + 2 * (64 + 65));
}

#[test]
fn every_shipped_chip_loads_and_states_every_figure() {
    for name in Device::shipped() {
        let device = Device::find(name).unwrap();
        assert_eq!(device.name(), name);
        for figure in Figure::ALL {
            assert_eq!(device.figure(*figure).unit, figure.unit());
        }
    }
    let wide = Device::find("scamp5-wide").unwrap();
    assert_eq!(wide.registers().analog.len(), 13);
    assert_eq!(wide.news(), Device::scamp5().news());
    assert_eq!(wide.value(Figure::Width), 512.0);
    assert_eq!(wide.macros(), Device::scamp5().macros());
}

/// Every folder in `tests/bad/isa` is a chip with mistakes. The file that is wrong says on top,
/// in lines `# 3:5 message | help` (or `//`), all that is to be found in it.
#[test]
fn every_mistake_in_a_chip_has_its_message_at_its_place() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad/isa");
    let mut folders: Vec<_> = fs::read_dir(root)
        .unwrap()
        .map(|f| f.unwrap().path())
        .collect();
    folders.sort();
    assert!(folders.len() > 20);
    for folder in folders {
        let mut expected = Vec::new();
        for name in ["device.toml", "primitives.toml", "macros.scamp"] {
            let Ok(text) = fs::read_to_string(folder.join(name)) else {
                continue;
            };
            for line in text.lines() {
                let line = line.strip_prefix("# ").or_else(|| line.strip_prefix("// "));
                if let Some(line) = line
                    && line.starts_with(|c: char| c.is_ascii_digit())
                {
                    expected.push(format!("{name}:{line}"));
                }
            }
        }
        let error = Device::load(&folder).expect_err(&folder.display().to_string());
        let LoadError::Wrong(faults) = error else {
            panic!("{}: {error:?}", folder.display());
        };
        let found: Vec<String> = faults.faults.iter().map(|l| shown(l, &folder)).collect();
        assert_eq!(found, expected, "{}", folder.display());
    }
}

fn shown(located: &Located, folder: &Path) -> String {
    let file = located.file.strip_prefix(&folder.display().to_string());
    let file = file.unwrap_or(&located.file).trim_start_matches('/');
    let help = located.fault.help.as_deref().unwrap_or("");
    let (line, column) = (located.line, located.column);
    format!("{file}:{line}:{column} {} | {help}", located.fault.message)
}

#[test]
fn a_chip_that_is_not_there_is_named() {
    let error = Device::find("scamp6").unwrap_err().to_string();
    assert!(error.contains("scamp6"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let error = Device::load(folder.path()).unwrap_err();
    assert!(error.to_string().contains("device.toml"), "{error}");
}

fn readme() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    fs::read_to_string(root.join("isa/README.md")).unwrap()
}

/// The block of isa/README.md that is headed by a name.
fn block(name: &str) -> String {
    let readme = readme();
    let (_, rest) = readme.split_once(&format!(" {name}\n")).unwrap();
    rest.split_once("```").unwrap().0.to_owned()
}

/// The walk through isa/README.md, followed to the letter: its files make a chip with an
/// instruction, macros and registers of its own, and its program costs there what it says.
#[test]
fn the_walk_through_the_readme_works() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("my-chip");
    fs::create_dir(&own).unwrap();
    for file in ["device.toml", "macros.scamp", "primitives.toml"] {
        fs::write(own.join(file), block(file)).unwrap();
    }
    let device = Device::load(&own).unwrap();
    let program = Program::parse("program.scamp", &block("program.scamp")).unwrap();
    let expansion = program.expand(&device, &BTreeMap::new()).unwrap();
    let cost = |steps: &[Step]| amacrine::program::Cost::of(steps, &device);
    let all = cost(&expansion.code.frame);
    let mut each = Vec::new();
    amacrine::program::for_each(&expansion.frame, &mut |statement| {
        each.push(cost(&statement.steps).words.0.to_string());
    });
    let (last, others) = each.split_last().unwrap();
    let says = format!(
        "takes {} words ({} and {last}), {:.2} us at 20 MHz",
        all.words.0,
        others.join(", "),
        all.array_us
    );
    assert!(readme().contains(&says), "{says}");
    // None of it is on the chip that is extended.
    let base = program.expand(device.base().unwrap(), &BTreeMap::new());
    let messages = base.unwrap_err().faults;
    let unknown = messages.iter().map(|f| f.fault.message.clone());
    let unknown: Vec<String> = unknown.collect();
    assert!(
        unknown.iter().any(|m| m == "unknown name `G`"),
        "{unknown:?}"
    );
    for name in ["double", "addeast", "COPY"] {
        let message = format!("unknown statement `{name}`");
        assert!(unknown.contains(&message), "{unknown:?}");
    }
}

/// The row of a new instruction, as the page has it: before there is a variant, loading says
/// so at its line, in a copy of the chip as in one that extends it.
#[test]
fn a_row_without_a_variant_is_told_where_it_stands() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("isa/scamp5");
    let folder = tempfile::tempdir().unwrap();
    let (copy, extends) = (folder.path().join("scamp5"), folder.path().join("my-chip"));
    fs::create_dir(&copy).unwrap();
    fs::create_dir(&extends).unwrap();
    let mut shipped = String::new();
    for file in ["device.toml", "macros.scamp", "primitives.toml"] {
        shipped = fs::read_to_string(root.join(file)).unwrap();
        fs::write(copy.join(file), &shipped).unwrap();
    }
    assert!(Device::load(&copy).is_ok());
    let row = block("new row");
    fs::write(copy.join("primitives.toml"), format!("{shipped}\n{row}")).unwrap();
    fs::write(extends.join("device.toml"), block("device.toml")).unwrap();
    fs::write(extends.join("primitives.toml"), &row).unwrap();
    for (folder, line) in [(&extends, 2), (&copy, shipped.lines().count() as u32 + 3)] {
        let error = Device::load(folder).unwrap_err();
        let LoadError::Wrong(faults) = &error else {
            panic!("{error:?}");
        };
        let fault = &faults.faults[0];
        assert!(fault.fault.message.starts_with("unknown value `nand`"));
        assert_eq!(fault.line, line);
    }
    assert!(readme().contains("\"unknown value `nand`\""));
}

/// The files that the page names are those that take primitives apart, and none of them has
/// an arm for the rest.
#[test]
fn the_page_names_every_file_that_must_know_an_instruction() {
    fn rust_files(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                rust_files(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    rust_files(&root.join("src"), &mut files);
    let readme = readme();
    let (_, list) = readme.split_once("one after the other:\n").unwrap();
    let (list, _) = list.split_once("A host operation").unwrap();
    for path in files {
        let text = fs::read_to_string(&path).unwrap();
        // The least of all primitives: only a `match` over all of them names it.
        let knows = [
            "Primitive::Nop",
            "PrimitiveKind::Nop",
            "Self::Nop",
            "    Nop,",
        ];
        let knows = knows.iter().any(|name| text.contains(name));
        let name = path.strip_prefix(root).unwrap().display().to_string();
        assert_eq!(list.contains(&format!("`{name}`")), knows, "{name}");
    }
}

/// Patterns that name a variant of `Primitive`, and those of them that a new word would pass unseen:
/// of a `match` with an arm for the rest, of `if let`, `let … else` and `matches!`.
#[derive(Default)]
struct Patterns {
    /// Inside `impl Primitive`, where `Self` is one.
    own: bool,
    /// Matches on primitives.
    matches: usize,
    /// Patterns that a new word would pass.
    open: usize,
}

impl Patterns {
    fn of(text: &str) -> Self {
        let mut found = Self::default();
        found.visit_file(&syn::parse_file(text).unwrap());
        found
    }

    /// Whether a pattern names a variant; `round` gets the names of the patterns round it.
    fn names(&self, pattern: &Pat, round: &mut Vec<String>) -> bool {
        let variant = |path: &syn::Path| {
            let before = path.segments.iter().rev().nth(1);
            before.is_some_and(|s| s.ident == "Primitive" || (self.own && s.ident == "Self"))
        };
        let mut any = |patterns: &mut dyn Iterator<Item = &Pat>| {
            patterns.filter(|p| self.names(p, round)).count() > 0
        };
        match pattern {
            Pat::Path(it) => variant(&it.path),
            Pat::Struct(it) => {
                variant(&it.path) || any(&mut it.fields.iter().map(|field| &*field.pat))
            }
            Pat::TupleStruct(it) => {
                let inside = any(&mut it.elems.iter());
                if inside {
                    round.extend(last(&it.path));
                }
                inside || variant(&it.path)
            }
            Pat::Or(it) => any(&mut it.cases.iter()),
            Pat::Tuple(it) => any(&mut it.elems.iter()),
            Pat::Slice(it) => any(&mut it.elems.iter()),
            Pat::Paren(it) => self.names(&it.pat, round),
            Pat::Reference(it) => self.names(&it.pat, round),
            Pat::Type(it) => self.names(&it.pat, round),
            Pat::Ident(it) => {
                let inner = it.subpat.as_ref();
                inner.is_some_and(|(_, inner)| self.names(inner, round))
            }
            _ => false,
        }
    }

    /// A pattern outside of a `match`: the rest is what does not fit it.
    fn alone(&mut self, pattern: &Pat) {
        if self.names(pattern, &mut Vec::new()) {
            self.open += 1;
        }
    }
}

fn last(path: &syn::Path) -> Option<String> {
    path.segments.last().map(|s| s.ident.to_string())
}

/// Whether a pattern takes whatever is left, at least of what a pattern of one of these names holds.
fn takes_the_rest(pattern: &Pat, round: &[String]) -> bool {
    match pattern {
        Pat::Wild(_) | Pat::Rest(_) => true,
        Pat::Ident(it) => it.subpat.is_none(),
        Pat::Tuple(it) => it.elems.iter().all(|p| takes_the_rest(p, round)),
        Pat::Or(it) => it.cases.iter().any(|p| takes_the_rest(p, round)),
        Pat::TupleStruct(it) => {
            last(&it.path).is_some_and(|name| round.contains(&name))
                && it.elems.iter().all(|p| takes_the_rest(p, round))
        }
        _ => false,
    }
}

impl<'ast> Visit<'ast> for Patterns {
    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        self.own = match &*item.self_ty {
            syn::Type::Path(it) => it.path.is_ident("Primitive"),
            _ => false,
        };
        visit::visit_item_impl(self, item);
        self.own = false;
    }

    fn visit_expr_match(&mut self, it: &'ast syn::ExprMatch) {
        let mut round = Vec::new();
        let names = { it.arms.iter() }.filter(|arm| self.names(&arm.pat, &mut round));
        if names.count() > 0 {
            self.matches += 1;
            let open = { it.arms.iter() }.filter(|arm| takes_the_rest(&arm.pat, &round));
            self.open += open.count();
        }
        visit::visit_expr_match(self, it);
    }

    fn visit_expr_let(&mut self, it: &'ast syn::ExprLet) {
        self.alone(&it.pat);
        visit::visit_expr_let(self, it);
    }

    fn visit_local(&mut self, it: &'ast syn::Local) {
        self.alone(&it.pat);
        visit::visit_local(self, it);
    }

    fn visit_macro(&mut self, it: &'ast syn::Macro) {
        let asked = |input: ParseStream<'_>| {
            input.parse::<Expr>()?;
            input.parse::<Token![,]>()?;
            let pattern = Pat::parse_multi_with_leading_vert(input)?;
            if input.parse::<Option<Token![if]>>()?.is_some() {
                input.parse::<Expr>()?;
            }
            input.parse::<Option<Token![,]>>()?;
            Ok(pattern)
        };
        if it.path.is_ident("matches") {
            self.alone(&it.parse_body_with(asked).unwrap());
        } else if let Ok(expressions) =
            Punctuated::<Expr, Token![,]>::parse_terminated.parse2(it.tokens.clone())
        {
            for expression in &expressions {
                Visit::visit_expr(self, expression);
            }
        }
    }
}

/// What takes primitives apart names all of them: a new word would pass an arm for the rest, or a
/// pattern for some, unseen.
#[test]
fn no_pattern_on_primitives_lets_the_rest_pass() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = vec![root.join("src")];
    let (mut found, mut open) = (0, Vec::new());
    while let Some(path) = files.pop() {
        if path.is_dir() {
            let entries = fs::read_dir(&path).unwrap();
            files.extend(entries.map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|e| e == "rs") {
            let patterns = Patterns::of(&fs::read_to_string(&path).unwrap());
            found += patterns.matches;
            if patterns.open > 0 {
                open.push(format!("{}: {}", path.display(), patterns.open));
            }
        }
    }
    assert!(found >= 4, "only {found} are found");
    assert!(open.is_empty(), "{open:#?}");
}

/// All ways to ask for one variant are found.
#[test]
fn what_lets_the_rest_pass_is_found() {
    for (body, open) in [
        ("match word { Primitive::Nop => 1, Primitive::All => 2 }", 0),
        ("match word { Primitive::Nop => 1, _ => 2 }", 1),
        (
            "match word { Primitive::Nop => 1, other => other.words() }",
            1,
        ),
        (
            "match it { Action::Word(Primitive::Nop) => 1, Action::Word(_) => 2, Action::Host(_) => 3 }",
            1,
        ),
        ("if let Primitive::Bus { targets, .. } = word {}", 1),
        ("while let Some(Primitive::Nop) = words.next() {}", 1),
        (
            "let Primitive::Bus { targets, .. } = word else { return };",
            1,
        ),
        (
            "let is = matches!(word, Primitive::Nop | Primitive::All if true);",
            1,
        ),
        ("assert!(!matches!(word, Primitive::Nop));", 1),
        ("if let Some(targets) = word.as_bus() {}", 0),
    ] {
        let found = Patterns::of(&format!("fn it() {{ {body} }}"));
        assert_eq!(found.open, open, "{body}");
    }
}

/// A chip `x` that extends SCAMP-5 by these lines of `device.toml` and this row, if any.
fn extended(lines: &str, row: &str) -> Device {
    let parent = tempfile::tempdir().unwrap();
    let folder = parent.path().join("x");
    fs::create_dir(&folder).unwrap();
    let text = format!("name = \"x\"\ntitle = \"x\"\nextends = \"scamp5\"\n{lines}");
    fs::write(folder.join("device.toml"), text).unwrap();
    if !row.is_empty() {
        let rest = "equation = \"x\"\nwords = 1\nclock = \"analog\"\nsource = \"x\"\nevidence = \"guess\"\n";
        let text = format!("[[primitive]]\n{row}\n{rest}");
        fs::write(folder.join("primitives.toml"), text).unwrap();
    }
    Device::load(&folder).unwrap()
}

/// What is wrong with a program on a chip: message and advice of the first fault.
fn wrong(device: &Device, text: &str) -> String {
    let program = Program::parse("test", text).unwrap();
    let faults = program.expand(device, &BTreeMap::new()).unwrap_err();
    let fault = &faults.faults[0].fault;
    format!(
        "{} | {}",
        fault.message,
        fault.help.as_deref().unwrap_or_default()
    )
}

/// A chip of fewer registers does without the macros that need another.
#[test]
fn a_chip_of_four_registers_has_the_macros_that_fit() {
    let four = extended(
        "[registers]\nanalogue = [\"A\", \"B\", \"C\", \"D\", \"NEWS\"]\n",
        "",
    );
    let forms = |device: &Device| {
        let named = device.macros().iter().map(|it| it.signature.to_string());
        named
            .filter(|it| it.starts_with("scamp5_get_image"))
            .count()
    };
    assert_eq!(forms(&four), forms(&Device::scamp5()));
    // F, where nothing is given: what takes its place is.
    let expanded = |text: &str| {
        let program = Program::parse("test", text).unwrap();
        program.expand(&four, &BTreeMap::new()).is_ok()
    };
    assert!(expanded("div2(A, B, C);"));
    assert_eq!(
        wrong(&four, "nop();\ndiv2(A, B);"),
        "scamp5 has this `div2`, and x does not | here it is written div2(y, x, t); or run it on another chip (--chip)"
    );
}

/// What needs a one-bit register that is not there, and other names of it.
#[test]
fn a_chip_of_fewer_bits_does_without_what_needs_another() {
    let bits = ["R0", "R1", "R2", "R3", "R4", "R5", "R6", "R12"];
    let few = extended(&format!("[registers]\ndigital = {bits:?}\n"), "");
    assert_eq!(few.digital_name(few.registers().roles.propagated), "R12");
    let elsewhere = "use the statements that x has; or run it on another chip (--chip)";
    for (text, why) in [
        (
            "scamp5_kernel_refresh_dreg();",
            "`scamp5_kernel_refresh_dreg` is left out on x, which has no register `R7`",
        ),
        (
            "MOV(R6, S6);",
            "`S6` is left out on x, which has no register `R11`",
        ),
        (
            "MOV(R6, R11);",
            "`R11` is a register of scamp5, and not of x",
        ),
    ] {
        assert_eq!(wrong(&few, text), format!("{why} | {elsewhere}"));
    }
    let program = Program::parse("test", "MUX(R5, R6, S0, S1);").unwrap();
    assert!(program.expand(&few, &BTreeMap::new()).is_ok());
    // The hardware uses others, and macros are written with those of SCAMP-5.
    let roles = "mask = \"R5\"\npropagated = \"R6\"\nnorth = \"R3\"\neast = \"R4\"\nsouth = \"R1\"\nwest = \"R2\"\n";
    let other = extended(&format!("[registers.roles]\n{roles}"), "");
    assert!(
        wrong(&other, "MUX(R7, R8, R9, R10);")
            .starts_with("`MUX` is left out on x, which has no `R0` as `mask`")
    );
    let program = Program::parse("test", "DNEWS(R7, R8, east);").unwrap();
    assert!(program.expand(&other, &BTreeMap::new()).is_ok());
}

/// A word that is not there, in a form of its row or in all: what is made of it, and of that.
#[test]
fn a_chip_of_fewer_words_does_without_what_is_made_of_them() {
    let bus = "name = \"bus\"\nforms = [\"bus(out y: target, x: source * 0..2)\"]";
    let one = extended("", bus);
    for (text, why) in [
        ("bus2(A, B, C);", "scamp5 has this `bus2`, and x does not"),
        ("bus(A, B, C, D);", "scamp5 has this `bus`, and x does not"),
        (
            "divq(A, B);",
            "`divq` is left out on x, which has no `bus2`",
        ),
        (
            "div2(A, B);",
            "`div2` is left out on x, which has no `bus2`",
        ),
        (
            "newsblur(A, B);",
            "`newsblur` is left out on x, which has no `bus` of 5 arguments",
        ),
    ] {
        let said = wrong(&one, text);
        assert!(said.starts_with(why), "{said}");
    }
    // A form goes with what its body needs of it, the forms that only pass a number on with it.
    let still = extended("", "name = \"prop\"\nforms = []");
    let elsewhere = "use the statements that x has; or run it on another chip (--chip)";
    assert_eq!(
        wrong(&still, "scamp5_flood(R5, R6, 0, 3);"),
        format!("`scamp5_flood` is left out on x, which has no `PROP_0` | {elsewhere}")
    );
    let blind = extended("", "name = \"where\"\nforms = []");
    assert!(
        wrong(&blind, "abs(A, B);").starts_with("`abs` is left out on x, which has no `where`")
    );
    assert_eq!(blind.left_out().len(), 1);
}

/// A chip of these macros, on SCAMP-5.
fn with_macros(macros: &str) -> Device {
    let parent = tempfile::tempdir().unwrap();
    let folder = parent.path().join("x");
    fs::create_dir(&folder).unwrap();
    let text = "name = \"x\"\ntitle = \"x\"\nextends = \"scamp5\"\n";
    fs::write(folder.join("device.toml"), text).unwrap();
    fs::write(folder.join("macros.scamp"), macros).unwrap();
    Device::load(&folder).unwrap()
}

/// Instruction words and host operations of a program.
fn steps(device: &Device, text: &str) -> usize {
    let program = Program::parse("test", text).unwrap();
    let expanded = program.expand(device, &BTreeMap::new());
    expanded.unwrap().code.frame.len()
}

/// In whichever order they stand, and whichever chip has the general one.
#[test]
fn a_form_for_a_number_is_meant_before_one_for_any() {
    let any = "/// waits\nmacro z(n: int[0..5]) { repeat n { nop(); nop(); } nop(); }\n";
    let none = "/// waits not\nmacro z(0) { }\n";
    for text in [format!("{any}{none}"), format!("{none}{any}")] {
        let device = with_macros(&text);
        assert_eq!(steps(&device, "z(0);"), 0, "{text}");
        assert_eq!(steps(&device, "z(2);"), 5, "{text}");
    }
    let zero = "/// a := 0\nmacro scamp5_in(out a: areg, 0)\n    gives NEWS\n{\n    bus(NEWS);\n    bus(a, NEWS);\n}\n";
    let device = with_macros(zero);
    assert_eq!(steps(&device, "scamp5_in(B, 0);"), 2);
    assert_eq!(
        steps(&device, "scamp5_in(B, 3);"),
        steps(&Device::scamp5(), "scamp5_in(B, 3);")
    );
}

/// A chip's own form is tried before those from below, which its macros may call.
#[test]
fn a_form_of_the_chip_s_own_comes_first() {
    let device =
        with_macros("/// y := x\nmacro mov(out y: areg, x: areg) { nop(); nop(); bus(y, x); }\n");
    assert_eq!(steps(&device, "mov(A, B);"), 3);
    assert_eq!(steps(&device, "mov(A, XE);"), 2);
    let first = device.macros().first().unwrap();
    assert!(first.origin.ends_with("/x/macros.scamp:2"), "{first:?}");
    let shipped = Device::scamp5();
    assert_eq!(device.macros()[1..], *shipped.macros());
}

/// What only some calls make impossible is told with the macro that says it.
#[test]
fn what_a_macro_makes_impossible_names_it() {
    let device =
        with_macros("/// y := F - x\nmacro less(out y: areg, x: areg) { sub(y, F, x); }\n");
    let told = wrong(&device, "less(A, A);");
    assert!(
        told.starts_with("`less` (") && told.contains("/x/macros.scamp:2)"),
        "{told}"
    );
    assert!(
        told.ends_with("says `sub(y, F, x);`: `sub` cannot have A as both y and x1 | give `less` other registers; it is written less(y, x)"),
        "{told}"
    );
}

/// A role that is not stated is that of the chip below.
#[test]
fn roles_are_stated_one_by_one() {
    let shipped = Device::scamp5();
    let [own, other] = [extended("[registers.roles]\nmask = \"R5\"\n", ""), shipped];
    let (own, other) = (own.registers(), other.registers());
    assert_eq!(own.roles.mask, amacrine::isa::Digital(5));
    assert_eq!(own.roles.propagated, other.roles.propagated);
    assert_eq!(own.roles.enable, other.roles.enable);
}
