//! The preprocessor: `#include`, `#define`, `#if` and its kin.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use super::{
    prototype::{is_program, undefined},
    source_map::{Files, Includes, Lying, bodies, named, plain},
    token::{Token, TokenKind, tokens},
};
use crate::{
    config::{Fault, Place},
    limit::{NESTING, VENDOR_TOKENS},
    program::{Overrides, vendor::syntax::tree::Width},
};

/// Files inside each other.
const DEPTH: usize = 16;

/// What a text becomes.
pub(in crate::program::vendor) struct Preprocessed {
    pub tokens: Vec<Token>,
    pub faults: Vec<Fault>,
    /// Names that stand for one number, as `#define` has them.
    pub numbers: BTreeMap<String, f64>,
    /// Files that are asked for and are not there.
    pub missing: Vec<String>,
}

/// The header that declares the chip's words: they are known, and a copy of it that lies beside a
/// file would declare registers as numbers.
const OF_THE_CHIP: &str = "scamp5.hpp";

fn is_of_the_chip(name: &str) -> bool {
    plain(name).eq_ignore_ascii_case(OF_THE_CHIP)
}

/// The names of files that a text asks for in quotes, without the vendor's own.
pub(super) fn asked(text: &str) -> Vec<String> {
    let lines = text.lines().map(str::trim_start);
    let included = lines.filter_map(|line| {
        let line = line.strip_prefix('#')?.trim_start();
        let line = line.strip_prefix("include")?.trim_start();
        line.strip_prefix('"')?.split('"').next()
    });
    let own = included.filter(|name| !is_of_the_chip(name));
    own.map(str::to_owned).collect()
}

/// What only speaks to a compiler: it expands to nothing.
fn of_compilers() -> BTreeMap<Arc<str>, Macro> {
    let nothing = |name: &str, parameters: Option<Vec<Arc<str>>>| {
        let it = Macro {
            parameters,
            variadic: true,
            body: Vec::new(),
        };
        (Arc::from(name), it)
    };
    let called = ["__declspec", "__attribute__"];
    let called = called.map(|name| nothing(name, Some(vec!["all".into()])));
    let alone = ["__forceinline", "__restrict", "__volatile__"];
    let alone = alone.map(|name| nothing(name, None));
    called.into_iter().chain(alone).collect()
}

pub(in crate::program::vendor) fn preprocess(
    text: &str,
    includes: &Includes,
    overrides: &Overrides,
    files: &mut Files,
) -> Preprocessed {
    let mut it = Preprocessor {
        own: text,
        includes,
        overrides,
        files,
        macros: of_compilers(),
        once: BTreeSet::new(),
        read: Vec::new(),
        out: Vec::new(),
        faults: Vec::new(),
        numbers: BTreeMap::new(),
        missing: Vec::new(),
        made: 0,
        depth: 0,
        full: false,
    };
    it.generator(text);
    it.text(text, 0, 0);
    it.bodies(text);
    Preprocessed {
        // A part of the text would only give faults of its own.
        tokens: if it.full { Vec::new() } else { it.out },
        faults: it.faults,
        numbers: it.numbers,
        missing: it.missing,
    }
}

/// `#define name body` or `#define name(parameters) body`.
#[derive(Clone)]
struct Macro {
    parameters: Option<Vec<Arc<str>>>,
    /// Whether the last parameter takes all that is left.
    variadic: bool,
    body: Vec<Token>,
}

/// A group between `#if` and `#endif`.
struct Group {
    /// Whether it is read.
    on: bool,
    /// Whether one of its parts was read already.
    done: bool,
    place: Place,
}

struct Preprocessor<'a> {
    /// The text itself.
    own: &'a str,
    includes: &'a Includes,
    overrides: &'a Overrides,
    files: &'a mut Files,
    macros: BTreeMap<Arc<str>, Macro>,
    /// Files with `#pragma once` that were read.
    once: BTreeSet<String>,
    /// Files that were read, and where they were asked for.
    read: Vec<(String, Place)>,
    out: Vec<Token>,
    faults: Vec<Fault>,
    numbers: BTreeMap<String, f64>,
    missing: Vec<String>,
    /// Tokens that were looked at, those of macros again in each use.
    made: usize,
    /// Macros inside each other.
    depth: usize,
    /// Whether a limit was told.
    full: bool,
}

impl Preprocessor<'_> {
    fn text(&mut self, text: &str, base: usize, depth: usize) {
        let (all, mut faults) = tokens(text, base);
        let all = without_attributes(all);
        self.faults.append(&mut faults);
        let mut groups: Vec<Group> = Vec::new();
        let mut rest = &all[..];
        while let Some(first) = rest.first() {
            if self.full {
                return;
            }
            if first.is("#") && first.first {
                let end = rest[1..].iter().position(|t| t.first);
                let (line, after) = rest.split_at(end.map_or(rest.len(), |end| end + 1));
                rest = after;
                self.directive(&line[1..], first.place, &mut groups, depth);
                continue;
            }
            // Up to the next directive: a call of a macro may go over lines.
            let end = rest.iter().position(|t| t.is("#") && t.first);
            let (lines, after) = rest.split_at(end.unwrap_or(rest.len()));
            rest = after;
            if groups.iter().all(|group| group.on) {
                let mut active = Vec::new();
                self.expand(lines, &mut active, None);
            }
        }
        for group in groups {
            self.faults.push(
                Fault::error(group.place, "this `#if` has no end", "begins here")
                    .help("close it with `#endif`"),
            );
        }
    }

    fn directive(&mut self, line: &[Token], place: Place, groups: &mut Vec<Group>, depth: usize) {
        let Some((word, rest)) = line.split_first() else {
            return;
        };
        let name = word.name().map_or("", |name| &**name);
        let on = groups.iter().all(|group| group.on);
        match name {
            "if" | "ifdef" | "ifndef" => {
                let met = on && self.condition(name, rest, place);
                groups.push(Group {
                    on: met,
                    done: met || !on,
                    place,
                });
            }
            "elif" | "else" => {
                let Some(group) = groups.last() else {
                    self.stray(name, place);
                    return;
                };
                let done = group.done;
                let met = !done && (name == "else" || self.condition("if", rest, place));
                if let Some(group) = groups.last_mut() {
                    group.on = met;
                    group.done |= met;
                }
            }
            "endif" if groups.pop().is_none() => {
                self.stray(name, place);
            }
            _ if !on => {}
            "define" => self.define(rest),
            "undef" => {
                if let Some(name) = rest.first().and_then(Token::name) {
                    self.macros.remove(name);
                }
            }
            "include" => self.include(rest, place, depth),
            "error" => self.faults.push(
                Fault::error(place, "`#error` stands here", "this line")
                    .help("define what the text asks for"),
            ),
            // `#pragma` and the rest speak to a compiler.
            _ => {}
        }
    }

    fn stray(&mut self, name: &str, place: Place) {
        self.faults.push(
            Fault::error(place, format!("`#{name}` without `#if`"), "this line").help("remove it"),
        );
    }

    fn condition(&mut self, kind: &str, line: &[Token], place: Place) -> bool {
        let defined = |name: Option<&Token>| {
            let name = name.and_then(Token::name);
            name.is_some_and(|name| self.macros.contains_key(name))
        };
        if kind != "if" {
            return defined(line.first()) == (kind == "ifdef");
        }
        // `defined X` and `defined(X)` first: X is not to be expanded.
        let mut known = Vec::new();
        let mut rest = line;
        while let Some((token, after)) = rest.split_first() {
            rest = after;
            if token.name().is_some_and(|name| &**name == "defined") {
                let wrapped = rest.first().is_some_and(|t| t.is("("));
                let name = rest.get(usize::from(wrapped));
                let kind = TokenKind::Whole(i64::from(defined(name)));
                known.push(Token {
                    kind,
                    ..token.clone()
                });
                rest = rest.get(if wrapped { 3 } else { 1 }..).unwrap_or_default();
            } else {
                known.push(token.clone());
            }
        }
        let before = std::mem::take(&mut self.out);
        self.expand(&known, &mut Vec::new(), None);
        let line = std::mem::replace(&mut self.out, before);
        if let Some(value) = super::constant::value(&line) {
            value != 0
        } else {
            self.faults.push(
                Fault::error(
                    place,
                    "the condition of this `#if` is not a constant",
                    "this line",
                )
                .help("`#if` takes whole numbers, names of `#define`, and `defined(NAME)`"),
            );
            false
        }
    }

    fn define(&mut self, line: &[Token]) {
        let Some((head, mut body)) = line.split_first() else {
            return;
        };
        let Some(name) = head.name() else {
            self.faults.push(
                Fault::error(head.place, "`#define` takes a name", "this")
                    .help("write `#define NAME value`"),
            );
            return;
        };
        let mut it = Macro {
            parameters: None,
            variadic: false,
            body: Vec::new(),
        };
        // A parameter list touches the name.
        let list = body.first().filter(|t| t.is("("));
        if list.is_some_and(|t| t.place.start == head.place.end) {
            let end = body.iter().position(|t| t.is(")")).unwrap_or(0);
            let inside = body.get(1..end).unwrap_or_default();
            it.variadic = inside.iter().any(|t| t.is("..."));
            let mut names: Vec<Arc<str>> = inside.iter().filter_map(Token::name).cloned().collect();
            if inside.last().is_some_and(|t| t.is("..."))
                && inside
                    .len()
                    .checked_sub(2)
                    .is_none_or(|i| inside[i].name().is_none())
            {
                names.push("__VA_ARGS__".into());
            }
            it.parameters = Some(names);
            body = body.get(end + 1..).unwrap_or_default();
        }
        it.body = body.to_vec();
        if it.parameters.is_none() {
            if let Some(value) = self.overrides.get(&**name) {
                let kind = number(*value);
                let place = head.place;
                let negative = *value < 0.0;
                let first = false;
                it.body = Vec::new();
                if negative {
                    let kind = TokenKind::Punctuator("-");
                    it.body.push(Token { kind, place, first });
                }
                it.body.push(Token { kind, place, first });
            }
            if let Some(value) = literal(&it.body) {
                self.numbers.insert(name.to_string(), value);
            }
        }
        self.macros.insert(Arc::clone(name), it);
    }

    fn include(&mut self, line: &[Token], place: Place, depth: usize) {
        let Some(TokenKind::Text(name)) = line.first().map(|t| &t.kind) else {
            // `<…>` is the vendor's or the language's own.
            return;
        };
        let place = place.to(line.last().map_or(place, |t| t.place));
        if is_of_the_chip(name) {
            return;
        }
        let Some(it) = self.includes.get(&**name) else {
            if !vendor_header(name) {
                self.missing.push(name.to_string());
                self.faults.push(
                    Fault::warning(
                        place,
                        format!("the included file `{name}` was not found"),
                        "its declarations are missing",
                    )
                    .help("put it into the same folder, under this name"),
                );
            }
            return;
        };
        if depth == DEPTH {
            self.faults.push(
                Fault::error(
                    place,
                    format!("more than {DEPTH} nested `#include`s"),
                    "this one",
                )
                .help("if a file includes itself, begin it with `#pragma once`"),
            );
            return;
        }
        if it.text.contains("#pragma once") && !self.once.insert(name.to_string()) {
            return;
        }
        let it = it.clone();
        self.file(name, &it, place, depth + 1);
    }

    /// Reads the vendor's generator of random numbers, where something here uses it and nothing
    /// defines it.
    fn generator(&mut self, text: &str) {
        const NAME: &str = "vs_random";
        let all: Vec<&str> = { self.includes.values() }
            .map(|it| &*it.text)
            .chain([text])
            .collect();
        let defined = all.iter().any(|it| it.contains("class vs_random"));
        if !defined && all.iter().any(|it| it.contains(NAME)) {
            let text = Lying::from(include_str!("random.hpp"));
            self.file("vs_random.hpp", &text, Place::default(), 1);
        }
    }

    fn file(&mut self, name: &str, it: &Lying, place: Place, depth: usize) {
        self.read.push((name.to_owned(), place));
        let shown = it.file.as_deref().unwrap_or(name);
        let base = self.files.add(shown, &it.text, place);
        self.text(&it.text, base, depth);
    }

    /// Reads what lies beside the headers under their names, and under those of functions that are
    /// declared: the vendor's tools build all of it.
    fn bodies(&mut self, own: &str) {
        for (name, place) in undefined(own) {
            self.beside(&named(&name), place, own);
        }
        let mut at = 0;
        while let Some((header, place)) = self.read.get(at).cloned() {
            at += 1;
            self.beside(&bodies(&header), place, own);
            let Some(it) = self.includes.get(&header).cloned() else {
                continue;
            };
            for (name, _) in undefined(&it.text) {
                self.beside(&named(&name), place, own);
            }
        }
    }

    /// Reads the files of these names that are there, were not read, and are no other program.
    fn beside(&mut self, names: &[String], place: Place, own: &str) {
        for name in names {
            let known = |it: &(String, Place)| plain(&it.0) == plain(name);
            if let Some(it) = self.includes.get(name).cloned()
                && !self.read.iter().any(known)
                && *it.text != *own
                && !is_program(&it.text)
            {
                self.file(name, &it, place, 1);
            }
        }
    }

    /// Tells of a limit, once: nothing more is read.
    fn stop(&mut self, place: Place, message: String) {
        if !self.full {
            self.full = true;
            self.faults.push(
                Fault::error(place, message, "from here on")
                    .help("macros that call each other grow fast; use functions and loops"),
            );
        }
    }

    /// Appends tokens, macros expanded. `at` is the place of the outermost call.
    fn expand(&mut self, tokens: &[Token], active: &mut Vec<Arc<str>>, at: Option<Place>) {
        if self.depth == 4 * NESTING {
            let place = at.or_else(|| Some(tokens.first()?.place));
            let message = format!("more than {} levels of nested macros", 4 * NESTING);
            self.stop(place.unwrap_or_default(), message);
            return;
        }
        self.depth += 1;
        self.expand_all(tokens, active, at);
        self.depth -= 1;
    }

    fn expand_all(&mut self, tokens: &[Token], active: &mut Vec<Arc<str>>, at: Option<Place>) {
        let mut rest = tokens;
        while let Some((token, after)) = rest.split_first() {
            rest = after;
            let place = at.unwrap_or(token.place);
            self.made += 1;
            if self.made > VENDOR_TOKENS {
                self.stop(place, format!("more than {VENDOR_TOKENS} tokens"));
            }
            if self.full {
                return;
            }
            let found = token.name().filter(|name| !active.contains(name));
            let found = found.and_then(|name| Some((name, self.macros.get(name)?.clone())));
            let Some((name, it)) = found else {
                let kind = self.predefined(token, place);
                self.out.push(Token {
                    place,
                    kind: kind.unwrap_or_else(|| token.kind.clone()),
                    ..*token
                });
                continue;
            };
            let mut body = it.body.clone();
            if let Some(parameters) = &it.parameters {
                let Some((given, after)) = arguments(rest) else {
                    // Without parentheses the name stands for itself.
                    self.out.push(Token {
                        place,
                        ..token.clone()
                    });
                    continue;
                };
                rest = after;
                body = self.substitute((name, &it), parameters, &given, active, place);
            }
            if let (Some(first), Some(body)) = (Some(token.first), body.first_mut()) {
                body.first = first;
            }
            active.push(Arc::clone(name));
            // What the body leaves open, a name of a macro with its parentheses outside, is not
            // looked for: nobody writes kernels so.
            self.expand(&body, active, Some(place));
            active.pop();
        }
    }

    /// What `__LINE__` and `__FILE__` stand for; nothing of another name.
    fn predefined(&self, token: &Token, place: Place) -> Option<TokenKind> {
        match &**token.name()? {
            "__LINE__" => {
                let (_, line) = self.files.stands(self.own, place);
                Some(TokenKind::Whole(line.into()))
            }
            "__FILE__" => {
                let (name, _) = self.files.stands(self.own, place);
                // As it would be written in quotes.
                Some(TokenKind::Text(name.replace('\\', "\\\\").into()))
            }
            _ => None,
        }
    }

    fn substitute(
        &mut self,
        (name, it): (&Arc<str>, &Macro),
        parameters: &[Arc<str>],
        given: &[&[Token]],
        active: &mut Vec<Arc<str>>,
        place: Place,
    ) -> Vec<Token> {
        let mut given: Vec<Vec<Token>> = given.iter().map(|tokens| tokens.to_vec()).collect();
        if it.variadic && given.len() > parameters.len() && !parameters.is_empty() {
            let last = given.split_off(parameters.len() - 1);
            let comma = Token {
                kind: TokenKind::Punctuator(","),
                place,
                first: false,
            };
            given.push(last.join(&comma));
        }
        if !it.variadic
            && given.len() != parameters.len()
            && !(parameters.is_empty() && given.iter().all(Vec::is_empty))
        {
            self.faults.push(
                Fault::error(
                    place,
                    format!(
                        "`{name}` takes {}, not {}",
                        crate::unit::counted(parameters.len(), "argument"),
                        given.len()
                    ),
                    "this call",
                )
                .help("see its `#define`"),
            );
            // A value and a statement: what the body makes of too little is no fault of its own.
            return vec![Token {
                kind: TokenKind::Whole(0),
                place,
                first: false,
            }];
        }
        let mut body: Vec<Token> = Vec::new();
        let mut paste = false;
        let mut tokens_of_body = it.body.iter().peekable();
        while let Some(token) = tokens_of_body.next() {
            if token.is("#")
                && let Some(name) = tokens_of_body.peek().and_then(|next| next.name())
                && let Some(index) = parameters.iter().position(|it| it == name)
            {
                tokens_of_body.next();
                let given = given.get(index).map(|given| written(given));
                body.push(Token {
                    kind: TokenKind::Text(given.unwrap_or_default().into()),
                    place,
                    first: false,
                });
                continue;
            }
            if token.is("##") {
                paste = true;
                continue;
            }
            let index = token
                .name()
                .and_then(|name| parameters.iter().position(|parameter| parameter == name));
            let mut inner = match index {
                None => vec![token.clone()],
                Some(index) => {
                    let raw = given.get(index).cloned().unwrap_or_default();
                    if paste {
                        raw
                    } else {
                        let before = std::mem::take(&mut self.out);
                        self.expand(&raw, active, Some(place));
                        std::mem::replace(&mut self.out, before)
                    }
                }
            };
            for token in &mut inner {
                token.first = false;
            }
            if paste && !inner.is_empty() {
                paste = false;
                if let (Some(last), Some(text)) = (body.last_mut(), spelled(&inner[0]))
                    && let Some(before) = spelled(last)
                {
                    let (mut glued, _) = tokens(&format!("{before}{text}"), 0);
                    if let Some(one) = glued.pop() {
                        last.kind = one.kind;
                        inner.remove(0);
                    }
                }
            }
            body.extend(inner);
            if body.len() > VENDOR_TOKENS {
                self.stop(place, format!("more than {VENDOR_TOKENS} tokens"));
            }
            if self.full {
                break;
            }
        }
        body
    }
}

/// Without `[[attributes]]`, which say nothing about what runs.
fn without_attributes(all: Vec<Token>) -> Vec<Token> {
    let opens = |at: usize| all.get(at).is_some_and(|it| it.is("["));
    if !(0..all.len()).any(|at| opens(at) && opens(at + 1)) {
        return all;
    }
    let (mut kept, mut at, mut first): (Vec<Token>, usize, bool) = (Vec::new(), 0, false);
    while let Some(token) = all.get(at) {
        let length = (opens(at) && opens(at + 1)).then(|| attribute(&all[at..]));
        if let Some(length) = length.flatten() {
            first |= token.first;
            at += length;
            continue;
        }
        let first = std::mem::take(&mut first) || token.first;
        let kind = token.kind.clone();
        kept.push(Token {
            kind,
            first,
            ..*token
        });
        at += 1;
    }
    kept
}

/// How many tokens `[[…]]` has, from its beginning on; nothing where it has no end.
fn attribute(all: &[Token]) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, token) in all.iter().enumerate() {
        if token.is("[") || token.is("(") {
            depth += 1;
        } else if token.is("]") || token.is(")") {
            depth = depth.checked_sub(1)?;
            if depth == 0 {
                return Some(at + 1);
            }
        } else if token.is(";") || token.is("{") {
            return None;
        }
    }
    None
}

/// The arguments of a call of a macro: what stands between commas, and what comes behind it.
fn arguments(tokens: &[Token]) -> Option<(Vec<&[Token]>, &[Token])> {
    if !tokens.first()?.is("(") {
        return None;
    }
    let (mut depth, mut start, mut given) = (0_usize, 1, Vec::new());
    for (i, token) in tokens.iter().enumerate() {
        let TokenKind::Punctuator(punctuator) = token.kind else {
            continue;
        };
        match punctuator {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => {
                depth = depth.checked_sub(1)?;
                if depth == 0 {
                    given.push(&tokens[start..i]);
                    return Some((given, &tokens[i + 1..]));
                }
            }
            "," if depth == 1 => {
                given.push(&tokens[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    None
}

fn spelled(token: &Token) -> Option<String> {
    match &token.kind {
        TokenKind::Name(name) => Some(name.to_string()),
        TokenKind::Whole(value) | TokenKind::Character(value) | TokenKind::Wide(value, _) => {
            Some(value.to_string())
        }
        _ => None,
    }
}

/// Tokens as text, for `#parameter`.
fn written(given: &[Token]) -> String {
    let mut text = String::new();
    let mut end = None;
    for token in given {
        if end.is_some_and(|end| end != token.place.start) {
            text.push(' ');
        }
        end = Some(token.place.end);
        match &token.kind {
            TokenKind::Name(name) => text.push_str(name),
            TokenKind::Whole(value) | TokenKind::Character(value) | TokenKind::Wide(value, _) => {
                text.push_str(&value.to_string());
            }
            TokenKind::Real(value) => text.push_str(&value.to_string()),
            TokenKind::Single(value) => {
                text.push_str(&value.to_string());
                text.push('f');
            }
            TokenKind::Text(inner) => {
                text.push('"');
                text.push_str(inner);
                text.push('"');
            }
            TokenKind::Punctuator(punctuator) => text.push_str(punctuator),
        }
    }
    text
}

fn number(value: f64) -> TokenKind {
    let value = value.abs();
    if value.fract() == 0.0 && value < 1e15 {
        if value > f64::from(i32::MAX) {
            return TokenKind::Wide(value as i64, Width::Long);
        }
        TokenKind::Whole(value as i64)
    } else {
        TokenKind::Real(value)
    }
}

/// The number that a body is, with its sign and parentheses.
fn literal(body: &[Token]) -> Option<f64> {
    let mut body = body;
    while let [open, inner @ .., close] = body {
        if !(open.is("(") && close.is(")")) {
            break;
        }
        body = inner;
    }
    let (sign, body) = match body {
        [minus, rest @ ..] if minus.is("-") => (-1.0, rest),
        body => (1.0, body),
    };
    match body {
        [one] => match one.kind {
            TokenKind::Whole(value) | TokenKind::Character(value) | TokenKind::Wide(value, _) => {
                Some(sign * value as f64)
            }
            TokenKind::Real(value) | TokenKind::Single(value) => Some(sign * value),
            _ => None,
        },
        _ => None,
    }
}

/// Headers of the vendor, whose words are the chip's.
fn vendor_header(name: &str) -> bool {
    let name = plain(name);
    name.starts_with("scamp") || name.starts_with("vs_") || name.starts_with("sim_")
}
