//! Options in messages of the library: each is in the list of them, Python says it in words of its own
//! or is never told of it, a study says the key where it has one; and nothing in the list is said in
//! vain.

use std::{
    fs,
    path::{Path, PathBuf},
};

use amacrine::advice::{InPython, InStudy, OPTIONS, in_python, in_study};
use syn::{
    Attribute, Ident, ItemFn, ItemMod, LitStr, Macro, Meta, Token,
    parse::{Parse, ParseStream},
    token,
    visit::{self, Visit},
};

/// The texts of a file: no comments, no tests.
#[derive(Default)]
struct Texts(Vec<String>);

impl Texts {
    fn of(file: &Path) -> Self {
        let file = syn::parse_file(&fs::read_to_string(file).unwrap()).unwrap();
        let mut texts = Self::default();
        texts.visit_file(&file);
        texts
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|it| {
        let of = |list: &syn::MetaList| list.tokens.to_string() == "test";
        it.path().is_ident("cfg") && it.meta.require_list().is_ok_and(of)
    })
}

impl<'a> Visit<'a> for Texts {
    fn visit_item_mod(&mut self, item: &'a ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'a ItemFn) {
        if !is_test(&item.attrs) {
            visit::visit_item_fn(self, item);
        }
    }

    fn visit_attribute(&mut self, attribute: &'a Attribute) {
        if let Meta::List(list) = &attribute.meta {
            let InTokens(texts) = syn::parse2(list.tokens.clone()).unwrap();
            self.0.extend(texts);
        }
    }

    fn visit_lit_str(&mut self, text: &'a LitStr) {
        self.0.push(text.value());
    }

    fn visit_macro(&mut self, of: &'a Macro) {
        let InTokens(texts) = syn::parse2(of.tokens.clone()).unwrap();
        self.0.extend(texts);
    }
}

/// The texts among the tokens of a macro or an attribute.
struct InTokens(Vec<String>);

impl Parse for InTokens {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut texts = Vec::new();
        while !input.is_empty() {
            if input.peek(LitStr) {
                texts.push(input.parse::<LitStr>()?.value());
                continue;
            }
            let inner;
            if input.peek(token::Paren) {
                syn::parenthesized!(inner in input);
            } else if input.peek(token::Brace) {
                syn::braced!(inner in input);
            } else if input.peek(token::Bracket) {
                syn::bracketed!(inner in input);
                // A comment.
                let doc = inner.fork();
                if doc.parse::<Ident>().is_ok_and(|it| it == "doc") && doc.peek(Token![=]) {
                    inner.step(|cursor| Ok(((), skipped(*cursor))))?;
                    continue;
                }
            } else {
                input.step(|cursor| match cursor.token_tree() {
                    Some((_, rest)) => Ok(((), rest)),
                    None => Err(cursor.error("no token")),
                })?;
                continue;
            }
            texts.extend(inner.call(Self::parse)?.0);
        }
        Ok(Self(texts))
    }
}

/// The end of what a cursor stands in.
fn skipped(mut cursor: syn::buffer::Cursor<'_>) -> syn::buffer::Cursor<'_> {
    while let Some((_, rest)) = cursor.token_tree() {
        cursor = rest;
    }
    cursor
}

fn files(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, all);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            all.push(path);
        }
    }
}

/// Every text of the library, with its file; those of the list itself are none.
fn texts() -> Vec<(String, String)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut all = Vec::new();
    files(&src, &mut all);
    all.sort();
    let is_of_library = |path: &PathBuf| {
        let inside = path.strip_prefix(&src).unwrap();
        !["cli", "advice", "main.rs"]
            .iter()
            .any(|it| inside.starts_with(it))
    };
    all.retain(is_of_library);
    let of = |path: PathBuf| {
        let name = path.strip_prefix(&src).unwrap().display().to_string();
        let texts = Texts::of(&path).0.into_iter();
        texts.map(move |text| (name.clone(), text))
    };
    all.into_iter().flat_map(of).collect()
}

/// The options that a text names outside of commands.
fn bare(text: &str) -> Vec<String> {
    let parts = text.split('`').enumerate();
    let parts = parts.filter(|(n, part)| n % 2 == 0 || part.starts_with("--"));
    let mut found = Vec::new();
    for (_, part) in parts {
        for (at, _) in part.match_indices("--") {
            let before = part[..at].chars().next_back();
            let name: String = { part[at + 2..].chars() }
                .take_while(|c| c.is_ascii_lowercase() || *c == '-')
                .collect();
            let is_first = before.is_none_or(|c| !c.is_ascii_alphanumeric() && c != '-');
            if is_first && name.starts_with(|c: char| c.is_ascii_lowercase()) {
                found.push(name);
            }
        }
    }
    found
}

#[test]
fn every_option_of_a_message_is_in_the_list() {
    let known: Vec<_> = OPTIONS.iter().map(|it| it.option).collect();
    assert!(known.is_sorted());
    let mut named = 0;
    for (file, text) in texts() {
        for option in bare(&text) {
            named += 1;
            assert!(
                known.contains(&&*option),
                "{file}: --{option}, in {text:?}, is not in src/advice/list.rs"
            );
        }
    }
    assert!(named > 100);
}

#[test]
fn python_says_every_option_in_its_own_words() {
    for (file, text) in texts() {
        let said = in_python(&text);
        for option in bare(&said) {
            let of = OPTIONS.iter().find(|it| it.option == option);
            assert!(
                of.is_some_and(|it| matches!(it.python, InPython::Typed(_))),
                "{file}: Python says --{option}: {said:?}"
            );
        }
        assert_eq!(in_python(&said), said, "{file}");
    }
}

#[test]
fn a_study_says_the_keys_that_it_has() {
    for (file, text) in texts() {
        let said = in_study(&text);
        for option in bare(&said) {
            let of = OPTIONS.iter().find(|it| it.option == option);
            assert!(
                of.is_some_and(|it| it.study == InStudy::None),
                "{file}: a study says --{option}: {said:?}"
            );
        }
    }
}

#[test]
fn what_is_in_the_list_is_in_a_message() {
    let texts = texts();
    for advised in OPTIONS {
        let option = format!("--{}", advised.option);
        assert!(
            texts.iter().any(|(_, text)| text.contains(&option)),
            "{option} is in no message"
        );
        for (phrase, _) in advised.phrases {
            assert!(
                texts.iter().any(|(_, text)| text.contains(phrase)),
                "{phrase:?} is in no message"
            );
        }
    }
}
