//! Proves that the page of `exec --trace` has what registers hold after every word: unpacked and
//! replayed, it ends where `--dump` does, on the chip and in exact arithmetic; that it needs nothing
//! else, is small, and says where chip and exact part. A browser steps through it (ignored in plain
//! `cargo test`).

mod common;

use std::{collections::BTreeMap, fs, io::Read as _, path::Path};

use amacrine::plane::Plane;
use base64::{Engine, prelude::BASE64_STANDARD};
use common::{amacrine, chromium, good, json, refused_untouched};
use flate2::read::DeflateDecoder;
use ndarray::Array3;
use ndarray_npy::{ReadNpyExt, WriteNpyExt};
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use tempfile::TempDir;

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What a page holds, replayed to its end.
struct Page {
    text: String,
    description: Value,
    /// By register: twin, chip, chip without noise, in LSB or bits, row by row.
    last: BTreeMap<String, Vec<Vec<f64>>>,
}

fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let (_, rest) = text.split_once(from).unwrap_or_else(|| panic!("no {from}"));
    rest.split_once(to).unwrap_or_else(|| panic!("no {to}")).0
}

impl Page {
    fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap();
        let data = between(&text, "type=\"application/octet-stream\">", "</script>");
        let mut bytes = Vec::new();
        let packed = BASE64_STANDARD.decode(data).unwrap();
        DeflateDecoder::new(&packed[..])
            .read_to_end(&mut bytes)
            .unwrap();
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        let description: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        let number = |key: &str| description[key].as_u64().unwrap() as usize;
        let (width, pixels) = (number("width"), number("width") * number("height"));
        let parts = number("parts") as f64;
        let variants = if description["quiet"] == true { 3 } else { 2 };
        let mut rest = &bytes[4 + length..];
        let mut take = |n: usize| {
            let (taken, more) = rest.split_at(n);
            rest = more;
            taken
        };
        let mut last = BTreeMap::new();
        for step in description["steps"].as_array().unwrap() {
            for register in step[4].as_array().unwrap() {
                let register = &description["registers"][register.as_u64().unwrap() as usize];
                let mut planes: Vec<Vec<i32>> = Vec::new();
                for variant in 0..variants {
                    let plane = if register[1] == true {
                        let bits = take(pixels.div_ceil(8));
                        (0..pixels)
                            .map(|i| i32::from(bits[i / 8] >> (i % 8) & 1))
                            .collect()
                    } else {
                        let bytes: Vec<_> = (0..4).map(|_| take(pixels)).collect();
                        let mut plane: Vec<i32> = Vec::new();
                        let folded =
                            |i: usize| u32::from_le_bytes([0, 1, 2, 3].map(|k| bytes[k][i]));
                        for i in 0..pixels {
                            let apart = (folded(i) >> 1) as i32 ^ -((folded(i) & 1) as i32);
                            let before = match (variant, i) {
                                (0, 0) => 0,
                                (0, i) if i % width == 0 => plane[i - width],
                                (0, i) => plane[i - 1],
                                (variant, i) => planes[variant - 1][i],
                            };
                            plane.push(before + apart);
                        }
                        plane
                    };
                    planes.push(plane);
                }
                let unit = if register[1] == true { 1.0 } else { parts };
                let values = planes.into_iter();
                let values = values.map(|p| p.into_iter().map(|v| f64::from(v) / unit).collect());
                last.insert(register[0].as_str().unwrap().to_owned(), values.collect());
            }
        }
        assert!(rest.is_empty(), "{} bytes too many", rest.len());
        Self {
            text,
            description,
            last,
        }
    }

    /// How far apart the last values of a variant and a dump are.
    fn is_the_dump(&self, variant: usize, dump: &Path) {
        let parts = self.description["parts"].as_f64().unwrap();
        let every = self.description["every"].as_u64().unwrap() as usize;
        for (name, variants) in self.last.iter().filter(|(name, _)| *name != "PIX") {
            let bytes = fs::read(dump.join(format!("{name}.npy"))).unwrap();
            let plane = Plane::<f64>::read_npy(&bytes[..])
                .unwrap_or_else(|_| Plane::<u8>::read_npy(&bytes[..]).unwrap().mapv(f64::from));
            let shown = plane.slice(ndarray::s![..;every, ..;every]);
            assert_eq!(shown.len(), variants[variant].len());
            for (a, b) in shown.iter().zip(&variants[variant]) {
                assert!((a - b).abs() <= 0.5 / parts + 1e-12, "{name}: {a} and {b}");
            }
        }
    }
}

/// What a page may not have: anything that a browser would fetch.
fn stands_alone(text: &str) {
    for word in [
        "http:", "https:", "src=", "href=", "url(", "@import", "fetch(", "eval(",
    ] {
        assert!(!text.contains(word), "{word}");
    }
    let script = text.rsplit_once("<script>").unwrap().1;
    let script = script.split_once("</script>").unwrap().0;
    let hash = BASE64_STANDARD.encode(Sha256::digest(script.as_bytes()));
    let policy =
        format!("default-src 'none'; script-src 'sha256-{hash}'; style-src 'unsafe-inline'");
    assert!(text.contains(&policy.replace('\'', "&#39;")) || text.contains(&policy));
}

/// A program that ships on both, and its page.
fn traced(program: &str, more: &[&str]) -> Page {
    traced_at(&here().join("programs").join(program), more)
}

/// The program on both, and its page.
fn traced_at(program: &Path, more: &[&str]) -> Page {
    let folder = TempDir::new().unwrap();
    let program = program.display().to_string();
    let page = folder.path().join("t.html");
    for (variant, domain) in [(0, "exact"), (1, "silicon")] {
        let mut ask = vec!["exec", &program, "--domain", domain, "--frames", "3"];
        ask.extend(["--trace", "t.html", "--dump", domain]);
        ask.extend(more);
        good(folder.path(), &ask);
        Page::read(&page).is_the_dump(variant, &folder.path().join(domain));
    }
    Page::read(&page)
}

#[test]
fn replayed_it_ends_where_the_program_does() {
    // Masks and memories, one-bit words and neighbours, diffusion, propagation, the host's bits.
    for program in [
        "rgc/centre_surround.scamp",
        "rgc/direction.scamp",
        "convolve/diffusion.scamp",
        "regions/fill_holes.scamp",
    ] {
        let page = traced(program, &[]);
        stands_alone(&page.text);
        assert_eq!(page.description["quiet"], true, "{program}");
    }
}

/// The host decides in the arithmetic that is asked for; its words run again on both.
#[test]
fn a_host_that_decides_is_traced_as_it_ran() {
    let program = here().join("tests/data/vendor/spots.cpp");
    let folder = TempDir::new().unwrap();
    let mut clip = Array3::<u8>::zeros((3, 24, 32));
    clip.slice_mut(ndarray::s![0, 3..8, 4..9]).fill(200);
    clip.slice_mut(ndarray::s![1, 3..8, 6..11]).fill(200);
    clip.slice_mut(ndarray::s![1, 12..16, 20..24]).fill(200);
    let light = folder.path().join("clip.npy");
    clip.write_npy(fs::File::create(&light).unwrap()).unwrap();
    let page = traced_at(&program, &["--image", light.to_str().unwrap()]);
    stands_alone(&page.text);
    assert!(
        page.text
            .contains("he host decided by what it read in silicon")
    );
    let steps = page.description["steps"].as_array().unwrap();
    assert!(
        steps
            .iter()
            .any(|step| step.to_string().contains("scamp5_scan_boundingbox"))
    );
}

#[test]
fn a_hundred_words_of_64_by_64_fit_pixel_by_pixel() {
    let folder = TempDir::new().unwrap();
    let program =
        "add(A, B, C);\nmovx(B, A, east);\nsub(C, B, A);\ndivq(D, C);\nneg(B, D);\n".repeat(10);
    fs::write(
        folder.path().join("p.scamp"),
        format!("get_image(A);\n{program}"),
    )
    .unwrap();
    let image = "pattern:noise?width=64&height=64&low=0&high=255&speed=0";
    let ask = [
        "exec", "p.scamp", "--image", image, "--frames", "1", "--trace", "t.html",
    ];
    let said = json(folder.path(), &ask);
    assert!(said["words"].as_u64() >= Some(100), "{said}");
    assert_eq!(said["written"][0], "t.html");
    let page = Page::read(&folder.path().join("t.html"));
    assert!(page.text.len() <= 2_000_000, "{}", page.text.len());
    assert_eq!(page.description["every"], 1);
    assert!(page.description["parts"].as_u64() >= Some(16));
    // The beginning of the frame, and every word.
    let steps = page.description["steps"].as_array().unwrap().len() as u64;
    assert!(steps > said["words"].as_u64().unwrap());
    assert!(!page.text.contains("id=\"sampled\""));
}

#[test]
fn a_large_array_is_sampled_and_says_so() {
    let image = "pattern:disc?width=256&height=256&speed=0";
    let page = traced("rgc/centre_surround.scamp", &["--image", image]);
    assert!(page.text.len() <= 2_000_000, "{}", page.text.len());
    let every = page.description["every"].as_u64().unwrap();
    assert!(every > 1);
    let said = format!("of {every} rows and columns one is shown");
    assert!(page.text.contains(&said) && page.text.contains("id=\"sampled\""));
    // Frames that do not fit are left out, the oldest first.
    assert_eq!(page.description["steps"][0][0], 2);
    assert!(
        page.text
            .contains("The first 2 frames were run and are left out")
    );
}

#[test]
fn the_first_pixel_that_parts_is_told() {
    let folder = TempDir::new().unwrap();
    let mut light = Plane::<f64>::from_elem((4, 5), 10.0);
    light[(2, 3)] = 250.0;
    ndarray_npy::write_npy(folder.path().join("a.npy"), &light.mapv(|v| v / 2.0)).unwrap();
    // The third word doubles 125 LSB: q8.8 holds 127.996 at most.
    fs::write(
        folder.path().join("p.scamp"),
        "mov(B, A);\nbus(NEWS, A, B);\nbus(C, NEWS);\n",
    )
    .unwrap();
    let exec = ["exec", "p.scamp", "--set", "A=a.npy", "--trace", "t.html"];
    let ask = |domain: &str| {
        let ask = [&exec[..], &["--domain", domain]].concat();
        let said = json(folder.path(), &ask);
        said["notes"][0].as_str().unwrap().to_owned()
    };
    let said = ask("q8.8");
    let expected = "frame 0, word 3, line 2, bus(NEWS, A, B): NEWS at (3, 2) is -128.000 on the chip and -250.000 exactly";
    assert!(said.contains(expected), "{said}");
    let page = Page::read(&folder.path().join("t.html"));
    let parting = &page.description["parting"];
    assert_eq!(
        (&parting["word"], &parting["x"], &parting["y"]),
        (&3.into(), &3.into(), &2.into())
    );
    assert_eq!(page.description["quiet"], false);
    assert!(ask("f32").contains("no pixel parts by more than 1 LSB"));
    // Of itself exact arithmetic does not part: then it is the silicon that is shown.
    assert!(ask("exact").contains("chip and exact part first"));
}

/// The cells of the page err by what the run was left of errors.
#[test]
fn what_is_left_out_is_left_out_of_the_page() {
    let folder = TempDir::new().unwrap();
    fs::write(
        folder.path().join("p.scamp"),
        "get_image(A);\nmov(B, A);\nadd(C, A, B);\n",
    )
    .unwrap();
    let exec = [
        "exec",
        "p.scamp",
        "--image",
        "pattern:disc?width=8&height=8",
        "--frames",
        "1",
    ];
    let errors = "noise,mismatch,transfer,converter,saturation,decay";
    let all = ["--trace", "t.html", "--without", errors];
    let said = |more: &[&str]| {
        let said = json(folder.path(), &[&exec[..], more].concat());
        said["notes"].to_string()
    };
    assert!(said(&all[..2]).contains("part first"));
    for domain in [&[][..], &["--domain", "silicon"]] {
        let said = said(&[&all[..], domain].concat());
        assert!(said.contains("no pixel parts by more than 1 LSB"), "{said}");
    }
}

#[test]
fn what_does_not_go_with_it_is_refused() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("p.scamp"), "mov(B, A);\n").unwrap();
    let ask = |more: &[&str], words: &[&str]| {
        let ask = [&["exec", "p.scamp", "--trace"], more].concat();
        refused_untouched(folder.path(), &ask, words);
    };
    ask(&["t.html", "--repeat", "3"], &["--repeat"]);
    ask(&["t.html", "--debug"], &["--debug"]);
    ask(&["t.png"], &["give a name that ends in .html"]);
    ask(&["t.html", "--fidelity", "auto"], &["--trace"]);
}

/// Steps through the page in a frame of a phone's width, and writes down what it finds.
const PROBE: &str = r"<!doctype html><meta charset=utf-8><title>probe</title><pre id=found></pre>
<iframe id=page width=WIDTH height=780 srcdoc='PAGE'></iframe>
<script>
document.getElementById('page').addEventListener('load', async event => {
  const page = event.target.contentDocument, root = page.documentElement;
  const wait = () => new Promise(done => setTimeout(done, 20));
  for (let i = 0; i < 200 && page.body.dataset.ready !== 'yes'; i++) await wait();
  const id = name => page.getElementById(name);
  const all = what => [...page.querySelectorAll(what)];
  const card = name => all('.register').find(c => c.querySelector('b').textContent === name);
  const picture = (name, side) => card(name).querySelectorAll('canvas')[side].toDataURL();
  const found = { ready: page.body.dataset.ready, steps: Number(id('slide').max) };
  id('next').click();
  id('next').click();
  found.two = page.body.dataset.step;
  id('back').click();
  found.one = page.body.dataset.step;
  found.word = id('word').textContent;
  id('last').click();
  found.end = page.body.dataset.step;
  found.written = all('.register.written b').map(b => b.textContent);
  const noisy = picture('B', 0);
  id('noise').click();
  found.noise = noisy !== picture('B', 0);
  id('apart').click();
  found.apart = card('B').querySelector('figcaption').textContent;
  id('apart').click();
  const box = card('A').querySelector('canvas').getBoundingClientRect();
  card('A').querySelector('.picture').dispatchEvent(new page.defaultView.PointerEvent('pointermove',
    { clientX: box.left + 0.5 * box.width / 64, clientY: box.top + 1.5 * box.height / 48 }));
  found.value = card('A').querySelector('.value').textContent;
  id('part').click();
  found.part = id('found').textContent;
  found.here = all('#text .here').length;
  page.body.dispatchEvent(new page.defaultView.KeyboardEvent('keydown', { key: 'Home', bubbles: true }));
  found.home = page.body.dataset.step;
  found.width = root.clientWidth;
  found.scroll = root.scrollWidth;
  found.outside = all('body *').filter(e => !e.closest('#text') && e.getBoundingClientRect().right > root.clientWidth + 1).map(e => e.outerHTML.slice(0, 80));
  found.small = all('p, li, h3, figcaption, label').filter(e => parseFloat(getComputedStyle(e).fontSize) < 11).length;
  document.getElementById('found').textContent = JSON.stringify(found);
});
</script>";

#[test]
#[ignore = "needs chromium"]
fn a_browser_steps_through_it() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let program = here().join("programs/rgc/centre_surround.scamp");
    let ask = [
        "exec",
        program.to_str().unwrap(),
        "--frames",
        "3",
        "--trace",
        "t.html",
    ];
    amacrine(folder, &ask).assert().success();
    let page = fs::read_to_string(folder.join("t.html")).unwrap();
    let inside = page.replace('&', "&amp;").replace('\'', "&#39;");
    for width in [360, 1000] {
        let probe = PROBE
            .replace("WIDTH", &width.to_string())
            .replace("PAGE", &inside);
        fs::write(folder.join("probe.html"), probe).unwrap();
        let (dom, _) = chromium(folder, &["--dump-dom", "probe.html"]);
        let found = between(&dom, "<pre id=\"found\">", "</pre>");
        let found = found
            .replace("&amp;", "&")
            .replace("&lt;", "<")
            .replace("&gt;", ">");
        let found: Value = serde_json::from_str(&found).unwrap_or_else(|_| panic!("{found}"));
        let steps = found["steps"].as_u64().unwrap().to_string();
        assert_eq!(found["ready"], "yes");
        assert_eq!((&found["two"], &found["one"]), (&"2".into(), &"1".into()));
        assert_eq!(found["end"], steps.as_str());
        assert_eq!(found["home"], "0");
        assert!(
            found["word"].as_str().unwrap().contains("word 1 of "),
            "{found}"
        );
        assert_eq!(found["noise"], true, "without noise B is another picture");
        assert!(
            found["apart"].as_str().unwrap().contains("exact"),
            "{found}"
        );
        let value = found["value"].as_str().unwrap();
        assert!(
            value.starts_with("(0, 1): ") && value.contains("exact "),
            "{value}"
        );
        assert!(
            found["part"].as_str().unwrap().contains(" parts at ("),
            "{found}"
        );
        assert_eq!(found["here"], 1);
        assert_eq!(found["width"], width);
        assert!(
            found["scroll"].as_u64() <= Some(width),
            "wider than the screen"
        );
        assert_eq!(
            found["outside"],
            serde_json::json!([]),
            "cut off at the right"
        );
        assert_eq!(found["small"], 0);
    }
    for (name, width, height) in [("phone", 500, 900), ("desktop", 1000, 900)] {
        let file = format!("{name}.png");
        let size = format!("--window-size={width},{height}");
        chromium(folder, &[&size, &format!("--screenshot={file}"), "t.html"]);
        let shot = image::open(folder.join(&file)).unwrap().to_rgb8();
        let dark = shot
            .pixels()
            .filter(|pixel| pixel.0.iter().all(|v| *v < 100));
        assert!(dark.count() > 2000, "{name}: nothing is shown");
    }
}
