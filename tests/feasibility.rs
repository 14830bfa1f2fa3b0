//! The verb `feasibility` from outside: the page stands alone, is sound HTML that anyone can
//! read, and says the numbers of `--json`, which agree with those of `compile` and `quantise`;
//! what does not fit and what makes no sense is said. One test, which needs Chromium, opens
//! the page as a reader does.
#![cfg(feature = "cli")]

#[path = "feasibility/browser.rs"]
mod browser;

mod common;

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

use common::{amacrine, json, refused};
use scraper::{ElementRef, Html, Selector};
use serde_json::Value;
use tempfile::TempDir;

const SCENE: &str = "pattern:disc?width=40&height=32&frames=8&radius=7";

/// A bright centre in a dark surround, of weights that few values do not make exactly.
const KERNEL: &str = "name = \"k\"\nsource = \"test\"\nweights = [[-0.4, -0.5, -0.4], [-0.5, 3.7, -0.5], [-0.4, -0.5, -0.4]]\n";

const ASK: [&str; 11] = [
    "feasibility",
    "--kernel",
    "k.toml",
    "--threshold",
    "40",
    "--scene",
    SCENE,
    "--candidates",
    "ternary,int-4",
    "--effort",
    "0.05",
];

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("k.toml"), KERNEL).unwrap();
    folder
}

/// The page of a question, and its numbers.
fn asked(folder: &Path, more: &[&str]) -> (String, Value) {
    let all = [&ASK, more, &["-o", "report.html", "--json"]].concat();
    let numbers = json(folder, &all);
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    (page, numbers)
}

fn all<'a>(page: &'a Html, selector: &str) -> Vec<ElementRef<'a>> {
    page.select(&Selector::parse(selector).unwrap()).collect()
}

fn text(element: ElementRef<'_>) -> String {
    element.text().collect()
}

/// What a browser would fetch or run.
fn stands_alone(source: &str, page: &Html) {
    for tag in [
        "script", "link", "iframe", "object", "embed", "base", "form", "video",
    ] {
        assert!(all(page, tag).is_empty(), "<{tag}>");
    }
    for element in all(page, "*") {
        for (name, value) in element.value().attrs() {
            assert!(!name.starts_with("on"), "{name}");
            let fetched = ["src", "href", "xlink:href", "srcset", "style", "action"];
            if fetched.contains(&name) {
                let inside = value.starts_with("data:") || value.starts_with('#');
                assert!(inside, "{name}={value}");
            }
        }
    }
    assert!(!source.contains("url(") && !source.contains("@import"));
}

/// Sound HTML, with all that a screen reader asks for.
fn is_readable(page: &Html) {
    assert_eq!(page.errors, Vec::<String>::new());
    let html = page.root_element().value();
    assert_eq!(html.attr("lang"), Some("en-GB"));
    assert_eq!(all(page, "title").len(), 1);
    assert_eq!(all(page, "main").len(), 1);
    for image in all(page, "img") {
        assert!(
            image
                .value()
                .attr("src")
                .unwrap()
                .starts_with("data:image/")
        );
        assert!(image.value().attr("alt").unwrap().len() > 10);
    }
    for drawing in all(page, "svg") {
        let attribute = |name| drawing.value().attr(name);
        let named = attribute("role") == Some("img") && attribute("aria-label").is_some();
        assert!(named || attribute("aria-hidden") == Some("true"));
    }
    let mut ids = BTreeSet::new();
    for element in all(page, "[id]") {
        assert!(
            ids.insert(element.value().attr("id").unwrap()),
            "an id twice"
        );
    }
    for element in all(page, "[aria-labelledby]") {
        assert!(ids.contains(element.value().attr("aria-labelledby").unwrap()));
    }
    let mut level = 0;
    for heading in all(page, "h1, h2, h3, h4, h5, h6") {
        let own: usize = heading.value().name()[1..].parse().unwrap();
        assert!(
            own <= level + 1,
            "{} after h{level}",
            heading.value().name()
        );
        assert!(!text(heading).trim().is_empty());
        level = own;
    }
    assert_eq!(all(page, "h1").len(), 1);
    for table in all(page, "table") {
        let inside = |selector: &str| table.select(&Selector::parse(selector).unwrap()).count();
        assert_eq!(inside("caption"), 1);
        assert_eq!(inside("th"), inside("th[scope]"));
        assert_eq!(
            inside("tbody tr"),
            inside("tbody tr > th[scope=row]:first-child")
        );
    }
}

/// Where in the JSON a number of the page stands: in a chapter, its root comes before.
fn pointer(data: ElementRef<'_>) -> String {
    let roots = data.ancestors().filter_map(ElementRef::wrap);
    let root = roots.into_iter().find_map(|e| e.value().attr("data-root"));
    root.unwrap_or("").to_owned() + data.value().attr("data-at").unwrap()
}

/// Every number on the page is the one of the JSON, and what is shown is that number.
fn says_the_numbers(page: &Html, numbers: &Value) {
    let mut seen = 0;
    for data in all(page, "data") {
        let at = pointer(data);
        let value: f64 = data.value().attr("value").unwrap().parse().unwrap();
        // The JSON reader is right to the last bit but one.
        let off = (number(numbers, &at) - value).abs();
        assert!(off <= 4.0 * f64::EPSILON * value.abs(), "{at}: {value}");
        let by = data
            .value()
            .attr("data-by")
            .map_or(1.0, |by| by.parse().unwrap());
        let value = by * value;
        let shown = text(data).replace('\u{2212}', "-").replace('\u{202f}', "");
        let decimals = shown.split_once('.').map_or(0, |(_, after)| {
            after.chars().take_while(char::is_ascii_digit).count()
        });
        let exponent = shown.split_once('e').map_or(0, |(_, e)| e.parse().unwrap());
        let step = 10f64.powi(exponent - decimals as i32);
        let shown: f64 = shown.parse().unwrap();
        assert!(
            (shown - value).abs() <= 0.501 * step,
            "{at}: {shown} of {value}"
        );
        seen += 1;
    }
    assert!(seen > 60, "only {seen} numbers");
    for cell in all(page, "td.n") {
        let marked = cell
            .select(&Selector::parse("data, .none").unwrap())
            .count();
        assert!(marked > 0, "a bare number: {}", text(cell));
    }
}

/// The questions that architects ask are answered first, each with a link to the part of the
/// page that says why.
fn answers_the_questions(page: &Html) {
    let links = all(page, "table.answers tbody th a");
    let asked: Vec<_> = links.iter().map(|link| text(*link)).collect();
    let one = [
        "Which task belongs on the sensor?",
        "What should it emit?",
        "What are the trade-offs?",
        "Does it fit?",
        "How fast?",
        "How much power?",
        "What decides?",
    ];
    assert!(!asked.is_empty() && asked.len().is_multiple_of(one.len()));
    for (i, question) in asked.iter().enumerate() {
        assert_eq!(question, one[i % one.len()]);
    }
    for link in all(page, "a[href^='#']") {
        let id = &link.value().attr("href").unwrap()[1..];
        let there = all(page, &format!("[id='{id}']"));
        assert_eq!(there.len(), 1, "nothing is at #{id}");
    }
    // The table comes before the paragraph.
    let verdict = all(page, "section[aria-labelledby=verdict], article section");
    let inside: Vec<_> = verdict[0].child_elements().collect();
    let place = |name: &str, class: &str| {
        let is =
            |e: &ElementRef<'_>| e.value().name() == name && e.value().attr("class") == Some(class);
        inside
            .iter()
            .position(is)
            .unwrap_or_else(|| panic!("no {name}.{class}"))
    };
    assert!(place("table", "answers") < place("p", "verdict"));
}

#[test]
fn the_page_stands_alone_and_says_the_numbers() {
    let folder = folder();
    let (source, numbers) = asked(folder.path(), &[]);
    let page = Html::parse_document(&source);
    stands_alone(&source, &page);
    is_readable(&page);
    says_the_numbers(&page, &numbers);
    answers_the_questions(&page);
    // Frame, two kinds of events, their difference, the waterfall.
    assert_eq!(all(&page, "img").len(), 5);
    // The kernel, its levels at their scale, its levels: 9 squares each.
    assert_eq!(all(&page, "svg.kernel rect").len(), 27);
    let verdict = text(all(&page, "p.verdict")[0]);
    for finding in numbers["verdict"]["findings"].as_array().unwrap() {
        assert!(verdict.contains(finding["says"].as_str().unwrap()));
        let rule = finding["rule"].as_str().unwrap();
        assert!(
            all(&page, ".rules td")
                .into_iter()
                .any(|td| text(td) == rule)
        );
    }
    // Every number about hardware has an evidence beside it.
    assert!(all(&page, ".evidence").len() >= 15);
    let command = numbers["command"].as_str().unwrap();
    assert_eq!(text(all(&page, "pre code")[0]), command);
}

#[test]
fn the_command_on_the_page_gives_the_page_again() {
    let folder = folder();
    let more = ["--exposure", "500us", "--seed", "3", "--to", "int-4"];
    let (first, numbers) = asked(folder.path(), &more);
    let command = numbers["command"].as_str().unwrap().replace('\'', "");
    let words: Vec<&str> = command.split(' ').skip(1).collect();
    fs::remove_file(folder.path().join("report.html")).unwrap();
    amacrine(folder.path(), &words)
        .env("RAYON_NUM_THREADS", "1")
        .assert()
        .success();
    let again = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(first == again, "the page differs");
}

/// The same questions, asked of the verbs that answer a part of them.
#[test]
fn compile_and_quantise_say_the_same() {
    let folder = folder();
    let (_, numbers) = asked(folder.path(), &["--to", "int-4", "--within", "2ms"]);
    let compiled = json(
        folder.path(),
        &[
            "compile",
            "k.toml",
            "--to",
            "int-4",
            "--sum",
            "kept",
            "--threshold",
            "40",
            "--effort",
            "0.05",
            "--json",
        ],
    );
    let chip = &numbers["fit"]["on_chip"];
    assert_eq!(chip["frame_words"], compiled["words"]);
    assert_eq!(chip["filter_words"], compiled["filter_words"]);
    assert_eq!(chip["prescale_bits"], compiled["prescale_bits"]);
    assert_eq!(chip["time"]["array"]["low"], compiled["array_us"]);
    assert_eq!(chip["time"]["readout"]["low"], compiled["host_us"]);
    let noise = &compiled["noise_lsb"][0];
    assert_eq!(chip["noise"]["temporal"]["low"], noise["temporal"]);
    assert_eq!(chip["noise"]["fixed"]["low"], noise["fixed"]);
    let quantised = json(
        folder.path(),
        &[
            "quantise",
            "k.toml",
            "--to",
            "ternary,int-4",
            "--sum",
            "kept",
            "--threshold",
            "40",
            "--scene",
            SCENE,
            "--effort",
            "0.05",
            "--within",
            "2ms",
            "--json",
        ],
    );
    let table = &quantised["chip"];
    assert_eq!(numbers["quantisation"], table["rows"]);
    assert_eq!(
        numbers["streams"]["float"]["events"],
        table["reference_events"]
    );
    // What the sensors said in the report is what the table says of the chosen row.
    let row = &table["rows"][1]["on_chip"];
    for domain in ["exact", "silicon"] {
        let judged = &numbers["streams"][domain]["judged"];
        assert_eq!(judged["f1"]["value"], row[domain]["f1"]);
    }
    let mesh = json(folder.path(), &["mesh", "fit", "k.toml", "--json"]);
    for (own, other) in [(0, 0), (1, 1)] {
        assert_eq!(numbers["mesh"][own]["error"], mesh[other]["error"]);
    }
}

/// Two kernels and what each is asked about: as one alone, and as `compile` makes both.
#[test]
fn several_kernels_are_a_chapter_each_and_one_program() {
    let folder = folder();
    let both = |threshold: &'static str| {
        let mut ask = ASK;
        (ask[2], ask[4]) = ("k.toml,sobel-x", threshold);
        [
            &ask[..],
            &["--to", "ternary", "-o", "report.html", "--json"],
        ]
        .concat()
    };
    let numbers = json(folder.path(), &both("40,90"));
    let source = fs::read_to_string(folder.path().join("report.html")).unwrap();
    let page = Html::parse_document(&source);
    stands_alone(&source, &page);
    is_readable(&page);
    says_the_numbers(&page, &numbers);
    answers_the_questions(&page);
    assert_eq!(all(&page, "article").len(), 2);
    assert_eq!(all(&page, "table.answers").len(), 2);

    // Each chapter is the answer to its own question, but for the command.
    let (_, alone) = asked(folder.path(), &["--to", "ternary"]);
    let mut chapter = numbers["kernels"][0].clone();
    chapter["command"] = alone["command"].clone();
    assert_eq!(chapter, alone);
    assert_eq!(numbers["kernels"][1]["threshold"], 90.0);
    assert_eq!(numbers["kernels"][1]["kernel"]["name"], "sobel-x");

    // One program: the words that `compile` has for both.
    let threshold = both("40");
    let together = json(folder.path(), &threshold);
    let compiled = json(
        folder.path(),
        &[
            "compile",
            "k.toml",
            "sobel-x",
            "--to",
            "ternary",
            "--sum",
            "kept",
            "--threshold",
            "40",
            "--effort",
            "0.05",
        ],
    );
    let program = &together["together"]["fit"]["on_chip"];
    assert_eq!(program["frame_words"], compiled["words"]);
    assert_eq!(program["filter_words"], compiled["filter_words"]);
    let apart: f64 = { together["kernels"].as_array().unwrap().iter() }
        .map(|one| number(one, "/fit/on_chip/frame_words"))
        .sum();
    assert_eq!(number(program, "/frame_words_apart"), apart);
    assert!(number(program, "/frame_words") < apart);
    let kinds = together["together"]["kinds"].as_array().unwrap();
    assert_eq!(kinds.len(), 2);
    for (i, kind) in kinds.iter().enumerate() {
        for key in ["kept", "window_us", "fps", "threshold_equivalent_percent"] {
            assert!(kind[key].is_number(), "no {key}");
        }
        // Without errors it says what its own program says: the same kernel, the same rule.
        let row = format!("/kernels/{i}/quantisation/0/on_chip/exact");
        assert_eq!(kind["exact"]["f1"], together.pointer(&row).unwrap()["f1"]);
    }
}

/// A file of several kernels, and more of them than the chip has registers for.
#[test]
fn kernels_that_do_not_fit_together_are_told_so() {
    let folder = folder();
    let plane = |k: i32| (0..9).map(move |i| f64::from((i + k) % 3 - 1) + f64::from(i == 4));
    let mut file = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    let head = "{'descr': '<f8', 'fortran_order': False, 'shape': (4, 3, 3), }";
    file.extend(format!("{head:<117}\n").bytes());
    file.extend((0..4).flat_map(plane).flat_map(f64::to_le_bytes));
    fs::write(folder.path().join("k.npy"), file).unwrap();
    let mut ask = ASK;
    (ask[2], ask[8]) = ("k.npy", "ternary");
    let more = ["-o", "report.html", "--json"];
    let numbers = json(folder.path(), &[&ask[..], &more].concat());
    let names: Vec<_> = { numbers["kernels"].as_array().unwrap().iter() }
        .map(|one| one["kernel"]["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["k.npy[0]", "k.npy[1]", "k.npy[2]", "k.npy[3]"]);
    let together = &numbers["together"];
    assert_eq!(together["headline"], "Do not fit together");
    let why = together["fit"]["refused"].as_array().unwrap();
    assert_eq!(why.len(), 2);
    assert!(why[0].as_str().unwrap().contains("registers"));
    let source = fs::read_to_string(folder.path().join("report.html")).unwrap();
    let page = Html::parse_document(&source);
    is_readable(&page);
    says_the_numbers(&page, &numbers);
    assert!(source.contains("Do not fit together"));
    // What a pixel of its own would keep is told all the same.
    assert!(number(&numbers, "/together/kinds/3/kept_apart") > 0.0);
    assert!(together["kinds"][3]["kept"].is_null());
}

fn number(of: &Value, at: &str) -> f64 {
    of.pointer(at)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("no {at}"))
}

#[track_caller]
fn near(got: f64, want: f64) {
    assert!(
        (got - want).abs() <= 1e-12 * want.abs(),
        "{got}, not {want}"
    );
}

/// What numbers are made of, worked out again.
#[test]
fn the_numbers_belong_together() {
    let folder = folder();
    let more = ["--exposure", "9ms", "--link-energy", "2..8", "--fps", "50"];
    let (_, all) = asked(folder.path(), &more);
    let at = |path: &str| number(&all, path);
    let time = |key: &str| at(&format!("/fit/on_chip/time/{key}/low"));
    near(time("ceiling"), 1e6 / (9000.0 + time("readout")));
    near(
        time("ceiling_of_scene"),
        1e6 / (9000.0 + time("readout_of_scene")),
    );
    assert_eq!(all["fit"]["on_chip"]["time"]["binds"], "exposure");
    let left = 1e6 / 50.0 - time("readout");
    near(at("/fit/on_chip/time/longest_exposure_us"), left);
    // 1.2 W: full power, and the share of it in which words run.
    near(at("/power/busy"), time("array") * 50e-6);
    near(at("/power/array/low"), 1200.0 * at("/power/busy"));
    near(at("/power/array/high"), 1200.0);
    near(at("/power/frame/high"), 1.2e6 / 50.0);
    // 40 and 32 take 6 and 5 bits, the sign one.
    for sensor in ["float", "dvs", "exact", "silicon"] {
        let stream = |key: &str| at(&format!("/streams/{sensor}/{key}"));
        near(stream("bits"), 12.0 * stream("events"));
        near(stream("events"), stream("on") + stream("off"));
        near(
            stream("mean_kbit_s"),
            stream("bits") / at("/scene/seconds") / 1e3,
        );
    }
    let rows = all["link"]["rows"].as_array().unwrap();
    for row in rows {
        let kbit = number(row, "/kbit_s");
        near(number(row, "/power/low"), 2e-3 * kbit);
        near(number(row, "/power/high"), 8e-3 * kbit);
    }
    near(
        number(&rows[rows.len() - 2], "/kbit_s"),
        2.0 * 40.0 * 32.0 * 50.0 / 1e3,
    );
    for sensor in ["dvs", "exact", "silicon"] {
        let f1 = |key: &str| at(&format!("/streams/{sensor}/judged/f1/{key}"));
        assert_eq!(f1("ceiling"), 1.0);
        assert!(0.0 < f1("floor") && f1("floor") < 1.0);
        let kept = (f1("value") - f1("floor")) / (1.0 - f1("floor"));
        near(f1("kept"), kept.clamp(0.0, 1.0));
    }
    // The busiest frame has room in the slots that it is said to need.
    assert!(at("/fit/on_chip/time/slots_of_scene") <= at("/fit/on_chip/time/slots"));
}

fn words(numbers: &Value) -> BTreeMap<String, String> {
    let findings = numbers["verdict"]["findings"].as_array().unwrap();
    let pair = |finding: &Value| {
        let of = |key: &str| finding[key].as_str().unwrap().to_owned();
        (of("about"), of("word"))
    };
    findings.iter().map(pair).collect()
}

/// The rules of the page, once more, on its own numbers.
#[test]
fn the_words_follow_from_the_numbers() {
    let folder = folder();
    let mut seen = BTreeSet::new();
    for more in [
        &["--fps", "20"][..],
        &["--fps", "100"],
        &["--fps", "200"],
        &["--to", "ternary", "--sum", "zero"],
    ] {
        let (_, all) = asked(folder.path(), more);
        let words = words(&all);
        let ceiling = number(&all, "/fit/on_chip/time/ceiling/low");
        let fps = number(&all, "/scene/fps");
        let speed = match ceiling / fps {
            r if r < 1.0 => "too slow",
            r if r < 2.0 => "just fast enough",
            _ => "fast enough",
        };
        assert_eq!(words["speed"], speed);
        let kept = number(&all, "/streams/silicon/judged/f1/kept");
        let fidelity = match kept {
            k if k >= 0.95 => "kept",
            k if k >= 0.8 => "mostly kept",
            k if k >= 0.5 => "half kept",
            _ => "mostly lost",
        };
        assert_eq!(words["fidelity"], fidelity);
        let chip = number(&all, "/streams/silicon/events");
        let events = match chip / number(&all, "/streams/dvs/events") {
            r if !r.is_finite() => "no comparison",
            r if r < 0.8 => "fewer",
            r if r > 1.25 => "more",
            _ => "about as many",
        };
        assert_eq!(words["events"], events);
        let f1 = |of: &str| number(&all, &format!("/streams/{of}/judged/f1/value"));
        let [few, chip] = [1.0 - f1("exact"), f1("exact") - f1("silicon")];
        let limits = match (few, chip) {
            _ if few.max(chip) < 0.05 => "little",
            _ if few >= chip => "few values",
            _ => "the chip's errors",
        };
        assert_eq!(words["what limits"], limits);
        let noise = match number(&all, "/fit/on_chip/noise/margin") {
            margin if margin >= 5.0 => "clear of noise",
            margin if margin >= 3.0 => "near the noise",
            _ => "in the noise",
        };
        assert_eq!(words["noise"], noise);
        let errors = [0, 1].map(|i| number(&all, &format!("/mesh/{i}/error")));
        let mesh = match errors[0].min(errors[1]) {
            error if error <= 0.05 => "carries it",
            error if error <= 0.2 => "comes near",
            _ => "cannot",
        };
        assert_eq!(words["mesh"], mesh);
        let headline = all["verdict"]["headline"].as_str().unwrap().to_owned();
        assert_eq!(headline == "Fits, but is too slow", speed == "too slow");
        seen.insert(headline);
    }
    assert!(seen.len() >= 2, "one headline for all: {seen:?}");
}

#[test]
fn what_does_not_fit_gets_a_page_that_says_so() {
    let folder = folder();
    let weight = |y: i32, x: i32| f64::from((7 * y * y + 3 * x * x + x * y) % 61) - 30.0;
    let rows: Vec<Vec<f64>> = (0..15)
        .map(|y| (0..15).map(|x| weight(y, x)).collect())
        .collect();
    let text = format!("name = \"large\"\nsource = \"test\"\nweights = {rows:?}\n");
    fs::write(folder.path().join("k.toml"), text).unwrap();
    let (source, numbers) = asked(folder.path(), &["--to", "int-7"]);
    let page = Html::parse_document(&source);
    stands_alone(&source, &page);
    is_readable(&page);
    says_the_numbers(&page, &numbers);
    answers_the_questions(&page);
    assert_eq!(numbers["verdict"]["headline"], "Does not fit");
    let why = numbers["fit"]["refused"].as_str().unwrap();
    assert!(why.contains("words"), "{why}");
    assert!(source.contains(why));
    assert!(numbers["streams"]["silicon"].is_null() && numbers["power"].is_null());
    // What can be said without a program is said.
    assert!(number(&numbers, "/streams/float/events") > 0.0);
    assert_eq!(all(&page, "img").len(), 2);
    // What was asked for has a row of its own.
    let last = numbers["quantisation"].as_array().unwrap().last().unwrap();
    assert_eq!(last["to"], "int-7");
    assert_eq!(last["refused"].as_str(), Some(why));
}

#[test]
fn a_scene_larger_than_the_array_does_not_fit() {
    let folder = folder();
    let chip = "name = \"small\"\ntitle = \"a small one\"\nextends = \"scamp5\"\n[figure.array]\nheight = { value = 16, unit = \"px\", source = \"what if\", evidence = \"guess\" }\nwidth = { value = 64, unit = \"px\", source = \"what if\", evidence = \"guess\" }\n";
    fs::create_dir(folder.path().join("small")).unwrap();
    fs::write(folder.path().join("small/device.toml"), chip).unwrap();
    let (source, numbers) = asked(folder.path(), &["--chip", "small"]);
    assert_eq!(numbers["verdict"]["headline"], "Does not fit");
    assert!(source.contains("40x32 pixels and small has 64x16"));
    says_the_numbers(&Html::parse_document(&source), &numbers);
}

#[test]
fn a_still_scene_gives_a_page_without_events() {
    let folder = folder();
    let mut ask = ASK;
    ask[6] = "pattern:disc?width=40&height=32&frames=1";
    let more = ["--fps", "20", "-o", "report.html", "--json"];
    let numbers = json(folder.path(), &[&ask[..], &more].concat());
    assert_eq!(numbers["streams"]["float"]["events"], 0);
    assert_eq!(words(&numbers)["fidelity"], "nothing to keep");
    let headline = numbers["verdict"]["headline"].as_str().unwrap();
    assert!(headline.contains("cannot judge"), "{headline}");
    let source = fs::read_to_string(folder.path().join("report.html")).unwrap();
    let page = Html::parse_document(&source);
    is_readable(&page);
    says_the_numbers(&page, &numbers);
}

#[test]
fn bad_input_is_one_message_and_no_page() {
    let folder = folder();
    fs::write(
        folder.path().join("zero.toml"),
        KERNEL.replace(|c: char| c.is_ascii_digit() && c != '0', "0"),
    )
    .unwrap();
    let with = |replaced: usize, by: &'static str| {
        let mut ask = ASK;
        ask[replaced] = by;
        [&ask[..], &["-o", "report.html"]].concat()
    };
    let more = |more: &[&'static str]| [&ASK, more, &["-o", "report.html"]].concat();
    let cases: [(Vec<&str>, &[&str]); 14] = [
        (with(2, "nowhere.toml"), &["nowhere.toml", "rgc-5x5"]),
        (with(2, "zero.toml"), &["all weights are 0"]),
        (with(4, "0"), &["threshold is 0", "positive"]),
        (with(4, "-3"), &["threshold is -3", "positive"]),
        (with(4, "nan"), &["threshold", "positive"]),
        (
            with(4, "40,50"),
            &["2 thresholds for 1 kernels", "one for each"],
        ),
        (with(2, "k.toml,nowhere.toml"), &["nowhere.toml", "rgc-5x5"]),
        (with(6, "gone.mp4"), &["gone.mp4"]),
        (with(8, "ternary,septenary"), &["septenary", "ternary"]),
        (more(&["--chip", "scamp9"]), &["scamp9"]),
        (more(&["--fps", "0"]), &["frames"]),
        (more(&["--link-energy", "9..1"]), &["9..1", "1..20"]),
        (more(&["--exposure", "soon"]), &["soon", "1ms"]),
        (
            [&ASK[..], &["-o", "zero.toml/report.html"]].concat(),
            &["cannot write zero.toml/report.html", "Not a directory"],
        ),
    ];
    for (arguments, words) in cases {
        refused(folder.path(), &arguments, words);
        assert!(
            !folder.path().join("report.html").exists(),
            "a page was left"
        );
    }
}
