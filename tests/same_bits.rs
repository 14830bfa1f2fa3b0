//! The same command writes the same bits on every machine: hashes of what the program writes,
//! in `tests/hashes/manifest.txt`, hold here and on an emulated CPU that has neither AVX nor
//! fused multiply-add. What may differ in its last bits (`docs/limits.md`) is held to its bound.
//!
//! `AMACRINE_BLESS=1 cargo test --release --all-features --test same_bits` writes the manifest
//! anew. Whoever does so has changed results: say so in the CHANGELOG, and raise the version of
//! the numbers (`NUMERICS` in `src/study/sweep/results/provenance.rs`), so that results are not mixed.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use amacrine::study::sweep::NUMERICS;
use ndarray::{Array3, Ix2, OwnedRepr};
use ndarray_npy::{read_npy, write_npy};
use sha2::{Digest, Sha256};

/// What is hashed: a name, the command line, and the files that it writes.
const CASES: &[(&str, &str, &[&str])] = &[
    (
        "events, f64, four kinds of cells, a real clip",
        "run --scene ROOT/clips/vtest_256x256.apng --sensor ROOT/sensors/rgc-4.toml --events e.npy --counts c.npy",
        &["e.npy", "c.npy"],
    ),
    (
        "events, counts and voxels, one kernel",
        "run --scene clip.npy --fps 40 --sensor ROOT/sensors/rgc.toml --upsample 0.1 --events e.csv --counts c.npy --voxels v.npy",
        &["e.csv", "c.npy", "v.npy"],
    ),
    (
        "events, f32",
        "run --scene clip.npy --fps 40 --sensor ROOT/sensors/rgc.toml --format f32 --events e.csv --voxels v.npy",
        &["e.csv", "v.npy"],
    ),
    (
        "events, f16",
        "run --scene clip.npy --fps 40 --sensor ROOT/sensors/rgc.toml --format f16 --events e.csv",
        &["e.csv"],
    ),
    (
        "events, q8.8",
        "run --scene clip.npy --fps 40 --sensor ROOT/sensors/rgc-on-chip.toml --format q8.8 --events e.csv",
        &["e.csv"],
    ),
    (
        "events, a logarithmic response with every noise",
        "run --scene clip.npy --fps 40 --sensor ROOT/sensors/dvs-noisy.toml --seed 3 --events e.csv --counts c.npy --voxels v.npy",
        &["e.csv", "c.npy", "v.npy"],
    ),
    (
        "events, lin-log with leak and shot noise",
        "run --scene clip.npy --fps 40 --sensor ROOT/sensors/dvs-v2e.toml --upsample 0.1 --events e.csv",
        &["e.csv"],
    ),
    (
        "a pattern",
        "run --scene pattern:grating?width=40&height=30&frames=20 --sensor ROOT/sensors/dog.toml --events e.csv --counts c.npy",
        &["e.csv", "c.npy"],
    ),
    (
        "a program, exact",
        "exec ROOT/programs/rgc/centre_surround.scamp --image clip.npy --fps 40 --frames 8 --events e.csv --dump d",
        &["e.csv", "d/A.npy", "d/B.npy", "d/R5.npy"],
    ),
    (
        "a program, f32",
        "exec ROOT/programs/convolve/gaussian.scamp --image clip.npy --fps 40 --frames 1 --domain f32 --dump d",
        &["d/A.npy", "d/B.npy", "d/C.npy"],
    ),
    (
        "a program, f16",
        "exec ROOT/programs/convolve/sobel.scamp --image clip.npy --fps 40 --frames 1 --domain f16 --dump d",
        &["d/A.npy", "d/B.npy", "d/C.npy"],
    ),
    (
        "a program, q8.8, by tiles",
        "exec ROOT/programs/rgc/centre_surround.scamp --image clip.npy --fps 40 --frames 8 --domain q8.8 --schedule tiled --events e.csv --dump d",
        &["e.csv", "d/A.npy", "d/B.npy"],
    ),
    (
        "a program, silicon",
        "exec ROOT/programs/rgc/centre_surround.scamp --image clip.npy --fps 40 --frames 8 --domain silicon --seed 5 --events e.csv --dump d",
        &["e.csv", "d/A.npy", "d/B.npy", "d/R5.npy"],
    ),
    (
        "a diffusion, silicon",
        "exec ROOT/programs/convolve/diffusion.scamp --image clip.npy --fps 40 --frames 1 --domain silicon --dump d",
        &["d/A.npy", "d/B.npy"],
    ),
    (
        "a compiled sensor",
        "compile csdvs-5 --to ternary --threshold 16 -o p.scamp",
        &["p.scamp"],
    ),
    (
        "a compiled filter",
        "compile sobel-x --filter-only -o p.scamp",
        &["p.scamp"],
    ),
    (
        "quantised levels",
        "quantise csdvs-5 --to ternary,int-4,po2-3,q2.3 --json",
        &["stdout"],
    ),
    (
        "an event file converted",
        "convert made.csv e.aedat4",
        &["e.aedat4"],
    ),
    (
        "two packets compared",
        "compare made.csv moved.csv --size 40x30 --json",
        &["stdout"],
    ),
];

/// Meshes go by fast Fourier transforms, whose sums have another order where the CPU has wider
/// vectors: a name, the command line, the array that it writes.
const MESHES: &[(&str, &str, &str)] = &[
    (
        "a settled surround",
        "mesh solve --lambda 10 --input light.npy --output h.npy",
        "h.npy",
    ),
    (
        "a settled difference, two space constants",
        "mesh solve --lambda 3 --lambda-y 1 --show difference --input light.npy --output h.npy",
        "h.npy",
    ),
];

/// How far a mesh may be from that of another machine, as a share of the largest voltage.
const MESH_DIFFERENCE: f64 = 4e-15;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A moving, flickering field without symmetries, from whole numbers alone.
fn light() -> Array3<f64> {
    Array3::from_shape_fn((24, 30, 40), |(n, y, x)| {
        let (n, y, x) = (n as u64, y as u64, x as u64);
        let bar = if (x + 2 * n) % 23 < 5 { 120 } else { 20 };
        let mixed = (y * 7919 + x * 104_729 + n * 15_485_863).wrapping_mul(2_654_435_761) >> 7;
        f64::from(bar as u32 + (mixed % 61) as u32) + 0.25 * f64::from((y * n % 5) as u32)
    })
}

/// A folder with the inputs of all cases.
fn inputs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let light = light();
    write_npy(folder.path().join("clip.npy"), &light).unwrap();
    let first = light.index_axis(ndarray::Axis(0), 0);
    write_npy(folder.path().join("light.npy"), &first).unwrap();
    let list = |shift: u64| {
        let mut text = "t,x,y,p\n".to_owned();
        for i in 0..400u64 {
            let t = 50 * i + shift * (i % 7);
            let _ = writeln!(text, "{t},{},{},{}", i * 13 % 40, i * 7 % 30, i % 2);
        }
        text
    };
    fs::write(folder.path().join("made.csv"), list(0)).unwrap();
    fs::write(folder.path().join("moved.csv"), list(3)).unwrap();
    folder
}

/// Runs the program, perhaps by way of another one; what it printed.
fn amacrine(by_way_of: &[&str], command: &str, folder: &Path) -> Vec<u8> {
    let program = env!("CARGO_BIN_EXE_amacrine");
    let words = command
        .split(' ')
        .map(|word| word.replace("ROOT", root().to_str().unwrap()));
    let mut all = by_way_of
        .iter()
        .map(ToString::to_string)
        .collect::<Vec<_>>();
    all.push(program.to_owned());
    all.extend(words);
    let out = Command::new(&all[0])
        .args(&all[1..])
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .unwrap_or_else(|cause| panic!("{}: {cause}", all[0]));
    assert!(
        out.status.success(),
        "{command}: {}",
        String::from_utf8_lossy(&out.stderr)
    );
    out.stdout
}

/// A line for each file of each case, run with one option more: its hash, which case, which file.
fn hashes(by_way_of: &[&str], option: &str) -> String {
    let folder = inputs();
    let mut lines = String::new();
    for (name, command, files) in CASES {
        let printed = amacrine(by_way_of, &format!("{command}{option}"), folder.path());
        for file in *files {
            let bytes = match *file {
                "stdout" => printed.clone(),
                file => fs::read(folder.path().join(file))
                    .unwrap_or_else(|cause| panic!("{name}: {file}: {cause}")),
            };
            let mut hash = String::new();
            for byte in &Sha256::digest(&bytes)[..16] {
                let _ = write!(hash, "{byte:02x}");
            }
            let _ = writeln!(lines, "{hash}  {name}: {file}");
        }
    }
    lines
}

fn manifest() -> PathBuf {
    root().join("tests/hashes/manifest.txt")
}

/// The manifest as it should be: the version of the numbers, then the hashes.
fn expected(hashes: &str) -> String {
    format!("numerics {NUMERICS}\n{hashes}")
}

fn check(found: &str) {
    let held = fs::read_to_string(manifest()).unwrap();
    let differ: Vec<_> = found
        .lines()
        .filter(|line| !held.lines().any(|other| other == *line))
        .collect();
    assert!(
        differ.is_empty(),
        "not as in tests/hashes/manifest.txt:\n{}\nIf results were meant to change, raise NUMERICS and write the manifest anew (see the head of this file)",
        differ.join("\n")
    );
    assert_eq!(
        held.lines().count(),
        found.lines().count(),
        "lines of the manifest"
    );
}

#[test]
fn the_manifest_holds_here() {
    let found = expected(&hashes(&[], ""));
    if std::env::var_os("AMACRINE_BLESS").is_some() {
        fs::write(manifest(), &found).unwrap();
    }
    check(&found);
}

#[test]
fn other_numbers_of_threads_write_the_same() {
    for option in [" --threads=1", " --threads=3"] {
        check(&expected(&hashes(&[], option)));
    }
}

#[test]
#[ignore = "needs qemu-x86_64 (Debian's qemu-user); .ci/run has it"]
fn the_manifest_holds_without_avx_and_fma() {
    check(&expected(&hashes(&EMULATED, "")));
}

/// A CPU of 2003: no SSE3 beyond the first, no AVX, no fused multiply-add.
const EMULATED: [&str; 3] = ["qemu-x86_64", "-cpu", "qemu64,-avx,-avx2,-fma"];

#[test]
#[ignore = "needs qemu-x86_64 (Debian's qemu-user); .ci/run has it"]
fn meshes_differ_by_no_more_than_is_said() {
    let folder = inputs();
    for (name, command, file) in MESHES {
        let mut arrays = [&[][..], &EMULATED[..]].map(|by_way_of| {
            amacrine(by_way_of, command, folder.path());
            let read: ndarray::ArrayBase<OwnedRepr<f64>, Ix2> =
                read_npy(folder.path().join(file)).unwrap();
            read
        });
        let largest = arrays[0].iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let [here, there] = &mut arrays;
        let furthest = here
            .iter()
            .zip(there.iter())
            .fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        println!("{name}: {:.1e} of the largest voltage", furthest / largest);
        assert!(
            furthest <= MESH_DIFFERENCE * largest,
            "{name}: {furthest:e} of {largest}"
        );
    }
}
