//! Names the build: a hash of the sources, and the compiler. No network, no repository: sources
//! unpacked from crates.io give the same name as a checkout. And lists the chips of `isa/` and the
//! files that come with the program, so that a new chip is a folder and a new sensor is a file.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
    process::Command,
};

/// What is compiled in: the code, and the data that it includes.
const SOURCES: [&str; 7] = [
    "src", "isa", "kernels", "sensors", "programs", "studies", "readouts",
];

/// Folders whose files are found by name, with what these end in.
const BUNDLED: [(&str, &str); 5] = [
    ("sensors", "toml"),
    ("programs", "scamp"),
    ("kernels", "toml"),
    ("studies", "toml"),
    ("readouts", "toml"),
];

fn main() -> io::Result<()> {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut files = Vec::new();
    for folder in SOURCES {
        println!("cargo::rerun-if-changed={folder}");
        collect(&root.join(folder), &mut files)?;
    }
    files.sort();
    let mut hash = Hash::new();
    for path in &files {
        // A name is the same on every system.
        let inside = path.strip_prefix(&root).unwrap_or(path);
        let names = inside.iter().map(|name| name.to_string_lossy());
        let bytes = fs::read(path)?;
        hash.add(names.collect::<Vec<_>>().join("/").as_bytes());
        hash.add(&(bytes.len() as u64).to_le_bytes());
        hash.add(&bytes);
    }
    println!("cargo::rustc-env=AMACRINE_SOURCES={:016x}", hash.0);
    let compiler = Command::new(env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .arg("--version")
        .output();
    let compiler = compiler.map_or_else(
        |_| "unknown".to_owned(),
        |said| String::from_utf8_lossy(&said.stdout).trim().to_owned(),
    );
    println!("cargo::rustc-env=AMACRINE_COMPILER={compiler}");
    let target = env::var("TARGET").unwrap_or_default();
    println!("cargo::rustc-env=AMACRINE_TARGET={target}");
    // Vendor code may nest as deep as Linux's stack has room for; Windows gives an eighth of it.
    if target.contains("windows-msvc") {
        println!("cargo::rustc-link-arg-bins=/STACK:8388608");
    } else if target.contains("windows-gnu") {
        println!("cargo::rustc-link-arg-bins=-Wl,--stack,8388608");
    }
    let chips = chips(&root.join("isa"))?;
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(out.join("chips.rs"), chips)?;
    fs::write(out.join("bundled.rs"), bundled(&root)?)
}

/// The files that come with the program as a Rust slice: folder, name in it, text.
fn bundled(root: &Path) -> io::Result<String> {
    let mut rows = Vec::new();
    for (folder, ending) in BUNDLED {
        let mut files = Vec::new();
        collect(&root.join(folder), &mut files)?;
        files.sort();
        for file in files {
            if file.extension().is_none_or(|it| it != ending) {
                continue;
            }
            let inside = file.strip_prefix(root.join(folder)).unwrap_or(&file);
            let parts = inside.with_extension("");
            let parts = parts.iter().map(|name| name.to_string_lossy());
            let name = parts.collect::<Vec<_>>().join("/");
            let path = format!("/{folder}/{name}.{ending}");
            let text = format!("include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), {path:?}))");
            rows.push(format!("({folder:?}, {name:?}, {text}),\n"));
        }
    }
    Ok(format!("&[\n{}]", rows.concat()))
}

/// The chips as a Rust slice: name, `device.toml`, and the other two files where there are any.
fn chips(isa: &Path) -> io::Result<String> {
    let mut names = Vec::new();
    for entry in isa.read_dir()? {
        let entry = entry?;
        if entry.path().join("device.toml").is_file() {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    names.sort();
    let text = |name: &str, file: &str| {
        format!("include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/isa/{name}/{file}\"))")
    };
    let row = |name: &String| {
        let other = |file: &str| {
            let there = isa.join(name).join(file).is_file();
            there.then(|| text(name, file))
        };
        let other = |file| other(file).map_or("None".to_owned(), |text| format!("Some({text})"));
        let device = text(name, "device.toml");
        let (words, macros) = (other("primitives.toml"), other("macros.scamp"));
        format!("({name:?}, {device}, {words}, {macros}),\n")
    };
    let rows: String = names.iter().map(row).collect();
    Ok(format!("&[\n{rows}]"))
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in folder.read_dir()? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}

/// FNV-1a of 64 bits: it tells builds apart and guards nothing, so no crate is built for it.
struct Hash(u64);

impl Hash {
    const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
