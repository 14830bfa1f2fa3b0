//! Files that import each other in a circle are read together or not at all: no circle inside a
//! room has more than three files.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

use syn::visit::{self, Visit};

/// The most files of a circle.
const MOST: usize = 3;

/// A module, as its path from the root of the crate.
type Module = Vec<String>;

/// What a file names of others: paths from `crate`, `super` or `self`, and which of them it hands on.
#[derive(Default)]
struct Named {
    paths: Vec<(Module, bool)>,
}

impl Named {
    fn tree(&mut self, tree: &syn::UseTree, before: &[String], hands_on: bool) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.tree(&path.tree, &with(&path.ident), hands_on),
            syn::UseTree::Name(name) => self.paths.push((with(&name.ident), hands_on)),
            syn::UseTree::Rename(name) => self.paths.push((with(&name.ident), hands_on)),
            syn::UseTree::Glob(_) => self.paths.push((before.to_vec(), hands_on)),
            syn::UseTree::Group(group) => {
                for tree in &group.items {
                    self.tree(tree, before, hands_on);
                }
            }
        }
    }
}

impl<'ast> Visit<'ast> for Named {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        // Tests of a file may look anywhere.
        if module.ident != "tests" {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let hands_on = !matches!(item.vis, syn::Visibility::Inherited);
        self.tree(&item.tree, &[], hands_on);
    }

    // `pub(super)` names no file.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names = path.segments.iter().map(|s| s.ident.to_string());
        let names: Module = names.collect();
        if matches!(names[0].as_str(), "crate" | "super") {
            self.paths.push((names, false));
        }
        visit::visit_path(self, path);
    }
}

/// The files of a crate, and what each names.
struct Crate {
    files: BTreeMap<Module, Named>,
    /// What a module hands on, by name.
    handed_on: BTreeMap<Module, BTreeMap<String, Module>>,
}

impl Crate {
    fn read(root: &Path) -> Self {
        let mut files = BTreeMap::new();
        read(root, root, &mut files);
        let mut all = Self {
            files,
            handed_on: BTreeMap::new(),
        };
        for (module, named) in &all.files {
            for (path, _) in named.paths.iter().filter(|(_, hands_on)| *hands_on) {
                if let (Some(whole), Some(name)) = (all.absolute(module, path), path.last()) {
                    let own = all.handed_on.entry(module.clone()).or_default();
                    own.insert(name.clone(), whole);
                }
            }
        }
        all
    }

    /// A path as it is from the root; none for other crates.
    fn absolute(&self, module: &[String], path: &[String]) -> Option<Module> {
        let mut from = module.to_vec();
        let mut rest = path;
        match path.first()?.as_str() {
            "crate" => return Some(path[1..].to_vec()),
            "self" => rest = &path[1..],
            "super" => {
                while rest.first().is_some_and(|name| name == "super") {
                    from.pop();
                    rest = &rest[1..];
                }
            }
            first => {
                let inner = [module, &[first.to_owned()]].concat();
                self.files.get(&inner)?;
            }
        }
        Some([&from[..], rest].concat())
    }

    /// The file that a path leads to, through what modules hand on.
    fn file(&self, path: &[String], depth: usize) -> Option<Module> {
        let length = (1..=path.len())
            .rev()
            .find(|n| self.files.contains_key(&path[..*n]))?;
        let (module, rest) = path.split_at(length);
        let further = { rest.first() }.and_then(|name| self.handed_on.get(module)?.get(name));
        match further {
            Some(further) if depth < 8 => self.file(&[further, &rest[1..]].concat(), depth + 1),
            _ => Some(module.to_vec()),
        }
    }

    /// The files that each file imports; what a module hands on it need not know.
    fn imports(&self) -> BTreeMap<&Module, BTreeSet<Module>> {
        let one = |(module, named): (&'_ Module, &Named)| {
            let own = named.paths.iter().filter(|(_, hands_on)| !hands_on);
            let whole = own.filter_map(|(path, _)| self.absolute(module, path));
            let mut files: BTreeSet<_> = whole.filter_map(|path| self.file(&path, 0)).collect();
            files.remove(module);
            files
        };
        let all = self.files.iter();
        all.map(|(module, named)| (module, one((module, named))))
            .collect()
    }

    /// Files that reach each other, the largest such group first.
    fn circles(&self) -> Vec<Vec<Module>> {
        let imports = self.imports();
        let reached = |from: &Module| {
            let (mut seen, mut next) = (BTreeSet::new(), vec![from.clone()]);
            while let Some(file) = next.pop() {
                for import in imports.get(&file).into_iter().flatten() {
                    if seen.insert(import.clone()) {
                        next.push(import.clone());
                    }
                }
            }
            seen
        };
        let reach: BTreeMap<_, _> = imports.keys().map(|file| (*file, reached(file))).collect();
        let mut circles = BTreeSet::new();
        for (file, own) in &reach {
            if own.contains(*file) {
                let back = own
                    .iter()
                    .filter(|other| reach.get(other).is_some_and(|their| their.contains(*file)));
                circles.insert(back.cloned().collect::<Vec<_>>());
            }
        }
        let mut circles: Vec<_> = circles.into_iter().collect();
        circles.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
        circles
    }
}

fn read(root: &Path, folder: &Path, files: &mut BTreeMap<Module, Named>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            read(root, &path, files);
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("main.rs") {
            let inner = path.strip_prefix(root).unwrap().with_extension("");
            let parts = inner.iter().map(|part| part.to_str().unwrap().to_owned());
            let module: Module = parts
                .filter(|part| part != "mod" && part != "lib")
                .collect();
            let text = fs::read_to_string(&path).unwrap();
            let mut named = Named::default();
            named.visit_file(&syn::parse_file(&text).unwrap());
            files.insert(module, named);
        }
    }
}

#[test]
fn no_circle_has_more_than_three_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let code = Crate::read(&root);
    let large: Vec<_> = { code.circles().into_iter() }
        .filter(|circle| circle.len() > MOST)
        .map(|circle| {
            circle
                .iter()
                .map(|file| file.join("::"))
                .collect::<Vec<_>>()
        })
        .collect();
    assert!(large.is_empty(), "{large:#?}");
    // The reader sees circles at all.
    assert!(!code.circles().is_empty());
}
