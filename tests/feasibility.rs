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
    fmt::Write as _,
    fs,
    path::Path,
};

use common::{amacrine, good, json, refused};
use scraper::{ElementRef, Html, Selector};
use serde_json::Value;
use tempfile::TempDir;

const SCENE: &str = "pattern:disc?width=40&height=32&frames=8&radius=7";

/// A bright centre in a dark surround, of weights that few values do not make exactly.
const KERNEL: &str = "name = \"k\"\nsource = \"test\"\nweights = [[-0.4, -0.5, -0.4], [-0.5, 3.7, -0.5], [-0.4, -0.5, -0.4]]\n";

const ASK: [&str; 13] = [
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
    "--chips",
    "4",
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
    // Frame, two kinds of events, their difference, the waterfall over frame rate and in steps.
    assert_eq!(all(&page, "img").len(), 6);
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
    let evidence = |what: &str| {
        let mut rows = all(&page, "tr").into_iter();
        let row = rows.find(|row| text(*row).starts_with(what)).unwrap();
        text(
            row.select(&Selector::parse(".evidence").unwrap())
                .next()
                .unwrap(),
        )
    };
    let noise = &numbers["fit"]["on_chip"]["noise"]["temporal"]["evidence"];
    assert_eq!(evidence("Threshold over noise"), *noise);
    assert_eq!(evidence("Threshold, where it is compared"), "modelled");
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
        .args(["--threads", "1"])
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
    for (end, at) in [("low", 0), ("high", 1)] {
        let told = format!("/time/readout_as_programmed/{end}");
        let compiled = number(&compiled, &format!("/host_us_range/{at}"));
        near(number(chip, &told), compiled);
    }
    assert_eq!(compiled["evidence"]["host_us"], "guess");
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
        assert_eq!(judged["likeness"], row[domain]);
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
            &["--to", "ternary", "--within", "10ms"],
            &["-o", "report.html", "--json"],
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
    let (_, alone) = asked(folder.path(), &["--to", "ternary", "--within", "10ms"]);
    let mut chapter = numbers["kernels"][0].clone();
    chapter["command"] = alone["command"].clone();
    // The light is that of all.
    chapter["light"] = numbers["light"].clone();
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

/// Four kernels of three rows as an array.
fn four_kernels(folder: &Path) {
    let plane = |k: i32| (0..9).map(move |i| f64::from((i + k) % 3 - 1) + f64::from(i == 4));
    let mut file = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    let head = "{'descr': '<f8', 'fortran_order': False, 'shape': (4, 3, 3), }";
    file.extend(format!("{head:<117}\n").bytes());
    file.extend((0..4).flat_map(plane).flat_map(f64::to_le_bytes));
    fs::write(folder.join("k.npy"), file).unwrap();
}

/// A file of more kernels than the chip has registers for memories: they share one.
#[test]
fn four_kernels_share_a_memory() {
    let folder = folder();
    four_kernels(folder.path());
    let scene = "pattern:disc?width=40&height=32&frames=8&radius=7.5";
    let mut ask = ASK;
    (ask[2], ask[6], ask[8]) = ("k.npy", scene, "ternary");
    let more = ["--within", "5ms", "-o", "report.html", "--json"];
    let numbers = json(folder.path(), &[&ask[..], &more].concat());
    let names: Vec<_> = { numbers["kernels"].as_array().unwrap().iter() }
        .map(|one| one["kernel"]["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["k.npy[0]", "k.npy[1]", "k.npy[2]", "k.npy[3]"]);
    let together = &numbers["together"];
    assert!(
        together["headline"]
            .as_str()
            .unwrap()
            .starts_with("Fit together")
    );
    let program = &together["fit"]["on_chip"];
    assert_eq!(program["memory"], "one memory of the pixel for all kinds");
    assert!(number(program, "/registers") <= 6.0);
    assert!(number(program, "/carried") >= 4.0);
    for kind in together["kinds"].as_array().unwrap() {
        // What few values leave, without the chip's errors.
        assert!(number(kind, "/exact/kept") > 0.5, "{kind}");
        assert!(kind["kept"].is_number());
    }
    // What `compile` makes of them.
    let compile =
        "compile k.npy --to ternary --sum kept --threshold 40 --memory shared --effort 0.05";
    let compiled = json(folder.path(), &compile.split(' ').collect::<Vec<_>>());
    assert_eq!(program["frame_words"], compiled["words"]);
    // And `quantise`, which runs them as well.
    let quantise = format!(
        "quantise k.npy --to ternary --sum kept --threshold 40 --effort 0.05 --within 5ms --scene {scene}"
    );
    let quantised = json(folder.path(), &quantise.split(' ').collect::<Vec<_>>());
    let on_chip = &quantised["together"][0]["on_chip"];
    assert_eq!(on_chip["words"], compiled["words"]);
    for (i, kind) in on_chip["kinds"].as_array().unwrap().iter().enumerate() {
        assert_eq!(kind["silicon"]["f1"], together["kinds"][i]["silicon"]["f1"]);
    }
    let source = fs::read_to_string(folder.path().join("report.html")).unwrap();
    let page = Html::parse_document(&source);
    is_readable(&page);
    says_the_numbers(&page, &numbers);
}

/// More kernels than the chip has words for.
#[test]
fn kernels_that_do_not_fit_together_are_told_so() {
    let folder = folder();
    four_kernels(folder.path());
    let chip = folder.path().join("small");
    fs::create_dir(&chip).unwrap();
    let device = "name = \"small\"\ntitle = \"a small store\"\nextends = \"scamp5\"\n\n[figure.store]\nwords = { value = 60, unit = \"words\", source = \"test\", evidence = \"guess\" }\n";
    fs::write(chip.join("device.toml"), device).unwrap();
    let mut ask = ASK;
    (ask[2], ask[8]) = ("k.npy", "ternary");
    let more = [
        "--chip",
        "small",
        "--within",
        "5ms",
        "-o",
        "report.html",
        "--json",
    ];
    let numbers = json(folder.path(), &[&ask[..], &more].concat());
    let together = &numbers["together"];
    assert_eq!(together["headline"], "Do not fit together");
    let why = together["fit"]["refused"].as_array().unwrap();
    assert_eq!(why.len(), 3);
    assert!(why[0].as_str().unwrap().contains("registers"));
    assert!(why[1].as_str().unwrap().contains("words"));
    let source = fs::read_to_string(folder.path().join("report.html")).unwrap();
    let page = Html::parse_document(&source);
    is_readable(&page);
    says_the_numbers(&page, &numbers);
    assert!(source.contains("Do not fit together"));
    // What a pixel of its own would keep is told all the same.
    assert!(number(&numbers, "/together/kinds/2/kept_apart") > 0.5);
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
    let more = [
        "--exposure",
        "9ms",
        "--link-energy",
        "2..8",
        "--fps",
        "50",
        "--within",
        "1ms",
    ];
    let (_, all) = asked(folder.path(), &more);
    let at = |path: &str| number(&all, path);
    let time = |key: &str, end: &str| at(&format!("/fit/on_chip/time/{key}/{end}"));
    // 9 ms of exposure are longer than array and readout together, at either end.
    for end in ["low", "high"] {
        near(time("ceiling", end), 1e6 / 9000.0);
    }
    let frame = time("array", "high") + time("readout_as_programmed", "high");
    near(
        time("ceiling_as_programmed", "low"),
        1e6 / frame.max(9000.0),
    );
    assert_eq!(all["fit"]["on_chip"]["time"]["binds"], "exposure");
    near(at("/fit/on_chip/time/longest_exposure_us"), 1e6 / 50.0);
    // From words at the peak clock to the bound with launches, 0.33 us a word.
    let words = at("/fit/on_chip/frame_words");
    near(time("array", "low"), 0.1 * words);
    near(time("array", "high"), 0.33 * words);
    // The plan is the cheapest of those that lose nothing.
    let plans = all["fit"]["on_chip"]["time"]["plans"].as_array().unwrap();
    let lossless = plans.iter().filter(|plan| number(plan, "/lost") == 0.0);
    let cheapest = lossless.map(|plan| number(plan, "/time/high"));
    near(
        time("readout", "high"),
        cheapest.fold(f64::INFINITY, f64::min),
    );
    assert!(time("readout", "high") < time("readout_as_programmed", "high"));
    // 0.12 to 0.158 uJ a word, and 2 to 8 pJ a bit; what is not known is in no sum.
    near(at("/power/share/low"), time("array", "low") * 50e-6);
    near(at("/power/busy/power/low"), 0.12 * words * 50.0 / 1e3);
    near(at("/power/busy/power/high"), 0.158 * words * 50.0 / 1e3);
    let kbit = at("/streams/silicon/mean_kbit_s");
    near(at("/power/link/power/high"), 8e-6 * kbit);
    near(
        at("/power/known/high"),
        at("/power/busy/power/high") + at("/power/link/power/high"),
    );
    near(
        at("/power/frame/high"),
        at("/power/known/high") * 1e3 / 50.0,
    );
    for part in ["idle", "readout", "host"] {
        assert!(all["power"][part]["power"].is_null(), "{part} is known");
    }
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
        let judged = |key: &str| at(&format!("/streams/{sensor}/judged/{key}"));
        assert_eq!(judged("f1/ceiling"), 1.0);
        assert!(0.0 < judged("f1/floor") && judged("f1/floor") < 1.0);
        let [f1, floor] = ["likeness/f1", "likeness/floor"].map(judged);
        near(judged("kept"), (f1 - floor) / (1.0 - floor));
        assert_eq!(judged("window_us"), at("/within_us"));
        assert_eq!(judged("fps"), 50.0);
        assert!(judged("threshold_equivalent_percent") >= 0.0);
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
    // From frame to frame the disc moves as far at each rate.
    for (speed, more) in [
        (5, &["--fps", "20", "--within", "1ms"][..]),
        (1500, &["--fps", "6000", "--within", "50us"]),
        (50_000, &["--fps", "200000", "--within", "2us"]),
        (60, &["--to", "ternary", "--sum", "zero", "--within", "1ms"]),
    ] {
        let scene = format!("{SCENE}&speed={speed}");
        let mut ask = ASK;
        ask[6] = &scene;
        let all = json(folder.path(), &[&ask, more, &["--json"]].concat());
        let words = words(&all);
        let ceiling = |end| number(&all, &format!("/fit/on_chip/time/ceiling/{end}"));
        let fps = number(&all, "/scene/fps");
        let drawn = all["drawn"].as_array().unwrap().iter();
        let slowest = drawn.map(|chip| number(chip, "/frames_s"));
        let least = slowest.fold(ceiling("low"), f64::min);
        let speed = match (least / fps, ceiling("high") / fps) {
            (_, most) if most < 1.0 => "too slow",
            (least, _) if least < 1.0 => "in doubt",
            (least, _) if least < 2.0 => "just fast enough",
            _ => "fast enough",
        };
        assert_eq!(words["speed"], speed);
        let kept = number(&all, "/streams/silicon/judged/kept");
        let fidelity = match kept {
            k if k >= 0.95 => "kept",
            k if k >= 0.8 => "mostly kept",
            k if k >= 0.5 => "half kept",
            _ => "mostly lost",
        };
        assert_eq!(words["fidelity"], fidelity);
        let floor = number(&all, "/streams/silicon/judged/likeness/floor");
        assert!(floor < 0.9, "{more:?}: the scene cannot judge: {floor}");
        let chip = number(&all, "/streams/silicon/events");
        let events = match chip / number(&all, "/streams/dvs/events") {
            r if !r.is_finite() => "no comparison",
            r if r < 0.8 => "fewer",
            r if r > 1.25 => "more",
            _ => "about as many",
        };
        assert_eq!(words["events"], events);
        let kept = |of: &str| number(&all, &format!("/streams/{of}/judged/kept"));
        let [few, chip] = [1.0 - kept("exact"), kept("exact") - kept("silicon")];
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
        let share = |key: &str| number(&all, key);
        let (clean, with_loss) = (share("/chips_feasible"), share("/chips_feasible_with_loss"));
        let chips = match () {
            () if clean >= 0.9 => "nearly all",
            () if with_loss >= 0.9 => "nearly all, with loss",
            () if with_loss > 0.1 => "some",
            () => "hardly any",
        };
        assert_eq!(words["chips"], chips);
        let headline = all["verdict"]["headline"].as_str().unwrap().to_owned();
        assert_eq!(headline == "Fits, but is too slow", speed == "too slow");
        if speed != "too slow" {
            let said = format!("on {:.0} of 4 chips", 4.0 * clean);
            assert!(headline.contains(&said), "{headline}: {said}");
        }
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
    assert_eq!(number(&numbers, "/chips_feasible"), 0.0);
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
    let chip = "name = \"small\"\ntitle = \"a small one\"\nextends = \"scamp5\"\n[figure.array]\nheight = { value = 16, unit = \"px\", source = \"test\", evidence = \"quoted\" }\nwidth = { value = 64, unit = \"px\", source = \"test\", evidence = \"quoted\" }\n";
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
    assert!(numbers["chips_feasible"].is_null());
    let source = fs::read_to_string(folder.path().join("report.html")).unwrap();
    let page = Html::parse_document(&source);
    is_readable(&page);
    says_the_numbers(&page, &numbers);
    // Nothing is said of a busiest moment, of most events, or of bars that are not there.
    assert!(source.contains("The first frame, at 0.000 s, since the float kernel has no event"));
    for words in ["busiest moment", "keeps most", "The mark in each bar"] {
        assert!(!source.contains(words), "{words}");
    }
    // No figure of what is kept, neither on the page nor in the summary.
    assert!(source.contains("nothing to keep: the float kernel has no event"));
    let summary = good(folder.path(), &[&ask[..], &["--fps", "20"]].concat());
    let kept = { summary.lines() }.filter(|line| line.starts_with("kept"));
    let kept: Vec<&str> = kept.collect();
    assert!(
        kept.len() == 1 && kept[0].contains("nothing to keep: "),
        "{summary}"
    );
    assert!(!summary.contains("what decides"), "{summary}");
}

/// In the dark the chip of the seed says nothing and is quick; a drawn chip of more noise has events
/// to read out, and no drawn chip is below the least that is said.
#[test]
fn the_least_rate_is_that_of_the_slowest_drawn_chip() {
    let folder = folder();
    let dark = ndarray::Array3::<f64>::zeros((10, 48, 64));
    ndarray_npy::write_npy(folder.path().join("dark.npy"), &dark).unwrap();
    let ask = |fps: &str| {
        let all = [
            "feasibility rgc-5x5 --to int-5 --candidates int-5 --threshold 128 --scene dark.npy",
            "--chips 8 --within 1ms --json --fps",
            fps,
        ];
        let all = all.join(" ");
        json(folder.path(), &all.split(' ').collect::<Vec<_>>())
    };
    let all = ask("7600");
    let drawn = all["drawn"].as_array().unwrap().iter();
    let slowest = drawn.map(|chip| number(chip, "/frames_s"));
    let slowest = slowest.fold(f64::INFINITY, f64::min);
    let stated = number(&all, "/fit/on_chip/time/ceiling/low");
    assert!(
        slowest < 7600.0 && stated > 1.7 * 7600.0,
        "{slowest} {stated}"
    );
    assert_eq!(words(&all)["speed"], "in doubt");
    let findings = all["verdict"]["findings"].as_array().unwrap();
    let speed = findings.iter().find(|it| it["about"] == "speed").unwrap();
    let says = speed["says"].as_str().unwrap();
    let said = format!("It reaches {slowest:.0} to ");
    assert!(
        says.starts_with(&said) && says.contains("The lowest is that of a drawn chip"),
        "{says}"
    );
}

/// A window that is longer than the scene matches everything: nothing is to be said.
#[test]
fn a_window_beyond_the_scene_cannot_judge() {
    let folder = folder();
    let (source, numbers) = asked(folder.path(), &["--within", "10s"]);
    assert_eq!(words(&numbers)["fidelity"], "nothing to keep");
    let headline = numbers["verdict"]["headline"].as_str().unwrap();
    assert!(headline.contains("cannot judge"), "{headline}");
    assert!(numbers["chips_feasible"].is_null());
    let verdict = numbers["verdict"].to_string();
    assert!(verdict.contains("--within"), "{verdict}");
    // A chip that chance makes perfect is no chip that keeps all, and nothing decides.
    assert_eq!(number(&numbers, "/stretch/floor"), 1.0);
    assert!(numbers["ranges"]["kept"].is_null());
    assert!(numbers["ranges"]["event_ratio"].is_object());
    for chip in numbers["drawn"].as_array().unwrap() {
        assert!(chip["kept"].is_null() && chip["is_feasible"] == false);
    }
    for turn in numbers["tornado"].as_array().unwrap() {
        for key in ["kept_at_low", "kept_at_high", "kept_nominal"] {
            assert!(turn[key].is_null(), "{turn}");
        }
        assert!(turn["frames_s_at_low"].is_number());
    }
    let page = Html::parse_document(&source);
    is_readable(&page);
    says_the_numbers(&page, &numbers);
    assert!(all(&page, ".tornado").is_empty());
    for words in [
        "chance alone scores nearly 1 in what they were shown",
        "None: chance alone scores 1 there",
        "since this scene cannot tell what they keep",
        "This scene cannot tell what they keep",
    ] {
        assert!(source.contains(words), "{words}");
    }
    let kept: Vec<_> = { all(&page, "table.answers td.n").into_iter() }
        .map(text)
        .filter(|cell| cell.contains("kept"))
        .collect();
    assert!(kept.is_empty(), "{kept:?}");
    let said = amacrine(folder.path(), &[&ASK[..], &["--within", "10s"]].concat());
    let said = { said }.assert().success().get_output().clone();
    let summary = String::from_utf8(said.stdout).unwrap();
    assert!(summary.starts_with(headline), "{summary}");
    assert!(!summary.contains("what decides") && !summary.contains("warning:"));
    let told = String::from_utf8(said.stderr).unwrap();
    assert!(told.contains("warning: "), "{told}");
}

/// What few values lose is told beside the output, by the kernel's name where there are several.
#[test]
fn warnings_stand_beside_the_verdict() {
    let folder = folder();
    let mut ask = ASK;
    (ask[2], ask[8]) = ("csdvs-3,sobel-x", "ternary");
    let more = ["--sum", "free", "--chips", "1"];
    let ask = [&ask[..11], &more].concat();
    let said = amacrine(folder.path(), &ask);
    let said = { said }.assert().success().get_output().clone();
    let (summary, told) = (common::line(&said.stdout), common::line(&said.stderr));
    assert!(summary.starts_with("Fit together"), "{summary}");
    assert!(!summary.contains("warning:"), "{summary}");
    assert!(
        told.contains("warning: csdvs-3: ") && told.contains("plain DVS"),
        "{told}"
    );
}

/// Numbers that nobody gave a scale, and in which nothing moves.
#[test]
fn the_page_says_how_light_was_read_and_what_is_warned_of() {
    let folder = folder();
    let still = ndarray::Array3::<f64>::from_elem((3, 32, 40), 0.5);
    ndarray_npy::write_npy(folder.path().join("still.npy"), &still).unwrap();
    let mut ask = ASK;
    (ask[6], ask[12]) = ("still.npy", "1");
    let more = ["--fps", "20", "-o", "report.html", "--json"];
    let numbers = json(folder.path(), &[&ask[..], &more].concat());
    let source = fs::read_to_string(folder.path().join("report.html")).unwrap();
    let page = Html::parse_document(&source);
    is_readable(&page);
    says_the_numbers(&page, &numbers);
    let light =
        "Light: numbers as given, transfer as coded; from 0.5 to 0.5 in the 3 frames shown.";
    assert!(source.contains(light), "{source}");
    assert!(!source.contains("is linear") && source.contains("was not undone (--transfer"));
    let told: Vec<_> = { all(&page, "ul.warnings li").into_iter() }
        .map(text)
        .collect();
    assert_eq!(told.len(), numbers["warnings"].as_array().unwrap().len());
    assert!(told.iter().any(|told| told.contains("--scale")), "{told:?}");
    let (_, drawn) = asked(folder.path(), &[]);
    let drawn_page = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(drawn_page.contains("Light: drawn as light, nothing to undo."));
    assert!(
        drawn["assumptions"][0]["what"]
            .as_str()
            .unwrap()
            .contains("is linear")
    );
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
    let cases: [(Vec<&str>, &[&str]); 17] = [
        (with(2, "nowhere.toml"), &["nowhere.toml", "rgc-5x5"]),
        (with(2, "zero.toml"), &["all weights are 0"]),
        (with(4, "0"), &["threshold is 0", "positive"]),
        (with(4, "-3"), &["threshold is -3", "positive"]),
        (with(4, "nan"), &["threshold", "positive"]),
        (
            with(4, "40,50"),
            &["2 thresholds for 1 kernel", "one for each"],
        ),
        (with(2, "k.toml,nowhere.toml"), &["nowhere.toml", "rgc-5x5"]),
        (with(6, "gone.mp4"), &["gone.mp4"]),
        (with(8, "ternary,septenary"), &["septenary", "ternary"]),
        (more(&["--chip", "scamp9"]), &["scamp9"]),
        (more(&["--fps", "0"]), &["frames"]),
        (more(&["--link-energy", "9..1"]), &["9..1", "1..20"]),
        (more(&["--exposure", "soon"]), &["soon", "1ms"]),
        (with(12, "0"), &["--chips", "whole number from 1 to"]),
        (more(&["--readout", "beside"]), &["beside", "overlapped"]),
        (
            more(&["--explain", "powr.busy"]),
            &["powr.busy", "power.busy"],
        ),
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

/// Every estimate, wherever it stands.
fn estimates<'a>(of: &'a Value, at: &str, found: &mut Vec<(String, &'a Value)>) {
    match of {
        Value::Object(members) => {
            if members.contains_key("evidence") && members.contains_key("inputs") {
                found.push((at.to_owned(), of));
            }
            for (key, value) in members {
                estimates(value, &format!("{at}/{key}"), found);
            }
        }
        Value::Array(items) => {
            for (i, value) in items.iter().enumerate() {
                estimates(value, &format!("{at}/{i}"), found);
            }
        }
        _ => {}
    }
}

fn rank(evidence: &Value) -> usize {
    let words = ["measured", "quoted", "modelled", "guess"];
    let word = evidence.as_str().unwrap();
    words.iter().position(|known| *known == word).unwrap()
}

/// Nothing that depends on a guess is called modelled, quoted or measured.
#[test]
fn labels_follow_the_weakest_input() {
    let folder = folder();
    let (_, all) = asked(folder.path(), &["--exposure", "500us"]);
    let figures = all["figures"].as_array().unwrap();
    let of = |name: &Value| {
        let found = figures.iter().find(|figure| figure["figure"] == *name);
        found.unwrap_or_else(|| panic!("no figure {name}"))
    };
    let mut found = Vec::new();
    estimates(&all, "", &mut found);
    let mut guessed = 0;
    for (at, estimate) in &found {
        let own = rank(&estimate["evidence"]);
        for name in estimate["inputs"].as_array().unwrap() {
            // An interval rests on its bounds, one number on the value alone.
            let is_one = estimate["low"] == estimate["high"];
            let key = if is_one {
                "evidence"
            } else {
                "interval_evidence"
            };
            let input = rank(&of(name)[key]);
            assert!(own >= input, "{at} is better known than {name}");
            guessed += usize::from(input == 3);
        }
    }
    assert!(found.len() > 10 && guessed > 5, "{} {guessed}", found.len());
    // Time rests on the launch, which nobody states; what was drawn on every guess there is.
    assert_eq!(
        all["fit"]["on_chip"]["time"]["ceiling"]["evidence"],
        "guess"
    );
    assert_eq!(all["chips_evidence"], "guess");
    for name in ["clock.launch", "error.noise", "error.analogue_decay"] {
        let name = Value::from(name);
        assert_eq!(of(&name)["evidence"], "guess");
    }
}

#[test]
fn chips_are_drawn_and_what_decides_is_said() {
    let folder = folder();
    let more = ["--to", "int-4", "--within", "1ms"];
    let mut ask = ASK;
    ask[12] = "12";
    let all = json(folder.path(), &[&ask[..], &more, &["--json"]].concat());
    let at = |path: &str| number(&all, path);
    let drawn = all["drawn"].as_array().unwrap();
    assert_eq!((at("/chips"), drawn.len()), (12.0, 12));
    let fps = at("/scene/fps");
    let feasible = |chip: &&Value| number(chip, "/kept") >= 0.8 && number(chip, "/frames_s") >= fps;
    for chip in drawn {
        assert_eq!(chip["is_feasible"], feasible(&chip));
    }
    let share = drawn.iter().filter(feasible).count() as f64 / 12.0;
    near(at("/chips_feasible"), share);
    // Numbers lie in their intervals, and no two chips are alike.
    let figures = all["figures"].as_array().unwrap();
    let mut noises = BTreeSet::new();
    for value in drawn
        .iter()
        .flat_map(|chip| chip["values"].as_array().unwrap())
    {
        let figure = figures.iter().find(|it| it["figure"] == value["figure"]);
        let (low, high) = (
            number(figure.unwrap(), "/low"),
            number(figure.unwrap(), "/high"),
        );
        assert!((low..=high).contains(&number(value, "/value")));
        if value["figure"] == "error.noise" {
            noises.insert(value["value"].to_string());
        }
    }
    assert_eq!(noises.len(), 12);
    let kept: Vec<f64> = drawn.iter().map(|chip| number(chip, "/kept")).collect();
    let inside = |value: &&f64| (at("/ranges/kept/p10")..=at("/ranges/kept/p90")).contains(value);
    assert!((8..=12).contains(&kept.iter().filter(inside).count()));
    // The tornado: the strongest first, the chip of the seed between or beside its ends.
    let tornado = all["tornado"].as_array().unwrap();
    let swing = |turn: &Value| {
        let ends = ["kept_at_low", "kept_at_high", "kept_nominal"];
        let ends = ends.map(|end| number(turn, &format!("/{end}")));
        ends.into_iter().fold(f64::MIN, f64::max) - ends.into_iter().fold(f64::MAX, f64::min)
    };
    assert!(
        tornado
            .windows(2)
            .all(|two| swing(&two[0]) >= swing(&two[1]))
    );
    let turn = |name: &str| tornado.iter().find(|turn| turn["figure"] == name).unwrap();
    // More noise keeps less, and no launch makes the chip slower than the most.
    let noise = turn("error.noise");
    assert!(number(noise, "/kept_at_low") > number(noise, "/kept_at_high"));
    let launch = turn("clock.launch");
    assert!(number(launch, "/frames_s_at_low") > number(launch, "/frames_s_at_high"));
    near(
        number(launch, "/kept_at_low"),
        number(launch, "/kept_at_high"),
    );
    // The whole scene was watched, so the chip of the seed is the one of the table.
    assert_eq!(all["stretch"]["frames"], all["stretch"]["of_frames"]);
    near(
        number(noise, "/kept_nominal"),
        at("/streams/silicon/judged/kept"),
    );
    // Another seed draws others.
    let seed = ["--seed", "5"];
    let other = json(
        folder.path(),
        &[&ASK[..], &more, &seed, &["--json"]].concat(),
    );
    assert_ne!(all["drawn"][0]["values"], other["drawn"][0]["values"]);
}

/// A chip whose numbers have no intervals is drawn by its mismatch alone.
#[test]
fn a_chip_without_intervals_has_nothing_to_turn() {
    let folder = folder();
    let stated = |key: &str, value: f64, unit: &str| {
        format!(
            "{key} = {{ value = {value}, unit = \"{unit}\", source = \"test\", evidence = \"measured\" }}\n"
        )
    };
    let chip = [
        "name = \"quiet\"\ntitle = \"a quiet one\"\nextends = \"scamp5\"\n[figure.error]\n",
        &stated("noise", 0.0, "LSB"),
        "[figure.clock]\n",
        &stated("launch", 0.0, "us"),
        &stated("rate", 10.0, "MHz"),
    ]
    .concat();
    fs::create_dir(folder.path().join("quiet")).unwrap();
    fs::write(folder.path().join("quiet/device.toml"), chip).unwrap();
    let (_, all) = asked(folder.path(), &["--chip", "quiet"]);
    let names: Vec<&str> = { all["tornado"].as_array().unwrap().iter() }
        .map(|turn| turn["figure"].as_str().unwrap())
        .collect();
    assert!(names.contains(&"error.headroom"), "{names:?}");
    for name in ["error.noise", "clock.launch", "clock.rate"] {
        assert!(!names.contains(&name), "{name} was restated");
    }
    let array = &all["fit"]["on_chip"]["time"]["array"];
    near(number(array, "/low"), number(array, "/high"));
    // The words of instructions are quoted.
    assert_eq!(array["evidence"], "quoted");
}

#[test]
fn a_number_is_explained_down_to_its_sources() {
    let folder = folder();
    let said = |what: &str| {
        let all = [&ASK[..], &["--within", "10ms", "--explain", what]].concat();
        let output = amacrine(folder.path(), &all).assert().success();
        String::from_utf8(output.get_output().stdout.clone()).unwrap()
    };
    let ceiling = said("ceiling");
    for part in [
        "ceiling",
        "array_us",
        "clock.rate",
        "CAREY13",
        "clock.launch",
        "readout_us",
        "slots",
        "frames/s",
        "guess",
    ] {
        assert!(ceiling.contains(part), "{part} is not in\n{ceiling}");
    }
    let noise = said("error.noise");
    assert!(
        noise.contains("0 to 0.2500 LSB") && noise.contains("log-likelihood"),
        "{noise}"
    );
    let margin = said("noise.margin");
    let of = |what: &str| margin.lines().find(|line| line.trim().starts_with(what));
    assert!(of("noise.margin").unwrap().contains(" guess "), "{margin}");
    assert!(
        of("noise.temporal").unwrap().contains(" guess "),
        "{margin}"
    );
    // A place in the JSON leads to the same chain as the name.
    assert_eq!(said("/power/busy/power/low"), said("power.busy"));
    assert!(said("/scene/frames").contains('8'));
    let kept = said("kept");
    for part in [
        "window_us",
        "error.noise",
        "error.headroom",
        "docs/silicon.md",
    ] {
        assert!(kept.contains(part), "{part} is not in\n{kept}");
    }
}

#[test]
fn one_after_the_other_is_slower_than_side_by_side() {
    let folder = folder();
    let ceiling = |order: &str| {
        let more = ["--readout", order, "--exposure", "2ms"];
        let (_, all) = asked(folder.path(), &more);
        assert_eq!(all["fit"]["on_chip"]["time"]["order"], order);
        let said = format!("--readout {order}");
        let assumed = all["assumptions"].as_array().unwrap();
        let is_said = |it: &Value| it["what"].as_str().unwrap().contains(&said);
        assert!(assumed.iter().any(is_said), "{order} is not stated");
        let readout = number(&all, "/fit/on_chip/time/readout/high");
        (number(&all, "/fit/on_chip/time/ceiling/low"), readout)
    };
    let (beside, _) = ceiling("overlapped");
    let (after, readout) = ceiling("sequential");
    near(beside, 500.0);
    near(after, 1e6 / (2000.0 + readout));
}

/// A sensor file says what is remembered: where that does not fit, what would is named.
#[test]
fn what_a_sensor_file_remembers_is_not_changed_but_a_way_is_named() {
    let folder = folder();
    let mut text =
        "response = \"identity\"\nmemory = \"filtered-snap\"\nborder = \"zero\"\n".to_owned();
    for kernel in ["sobel-x", "sobel-y", "laplacian"] {
        let _ = writeln!(
            text,
            "[[channel]]\nkernel = \"{kernel}\"\nthreshold = {{ on = 60, off = 60 }}"
        );
    }
    fs::write(folder.path().join("s.toml"), text).unwrap();
    let asked = ["s.toml", "--scene", SCENE, "--effort", "0.01"];
    let way = "With one memory of the pixel for all kinds there is a program: feasibility and design take it with --memory shared";
    let more = ["--candidates", "ternary", "--chips", "1", "--within", "5ms"];
    let feasibility = [&["feasibility"], &asked[..], &more].concat();
    let said = good(folder.path(), &feasibility);
    assert!(said.starts_with("Do not fit together"), "{said}");
    assert!(said.contains("2 too few") && said.contains(way), "{said}");
    let said = good(
        folder.path(),
        &[&feasibility[..], &["--memory", "shared"]].concat(),
    );
    assert!(said.starts_with("Fit together"), "{said}");
    let said = good(
        folder.path(),
        &[&["quantise"], &asked[..], &["--to", "ternary"]].concat(),
    );
    assert!(said.contains("2 too few") && said.contains(way), "{said}");
}

/// What the report says of halvings is what they are for.
#[test]
fn halvings_are_for_what_compile_says() {
    let folder = folder();
    four_kernels(folder.path());
    let mut ask = ASK;
    (ask[2], ask[8]) = ("k.npy", "ternary");
    let more = ["--within", "5ms", "-o", "report.html", "--json"];
    let numbers = json(folder.path(), &[&ask[..], &more].concat());
    let program = &numbers["together"]["fit"]["on_chip"];
    let compile =
        "compile k.npy --to ternary --sum kept --threshold 40 --memory shared --effort 0.05";
    let compile: Vec<_> = compile.split(' ').collect();
    let said = good(folder.path(), &compile);
    let halved = program["halvings"].as_array().unwrap();
    assert_eq!(halved.len(), 4);
    let told: Vec<_> = halved.iter().map(Value::to_string).collect();
    let told = format!(
        "is halved {} times on the way, for the most events on the chip",
        told.join(", ")
    );
    assert!(said.contains(&told), "{said}");
    assert_eq!(
        (&program["halved_for"], &program["holds"]),
        (&"events".into(), &false.into())
    );
    let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("for the most events on the chip: large sums may leave the range"));
    assert!(page.contains("Halvings of the change, kind by kind"));
}

/// The frame rate at either end of a figure is that of the events that the chip there has.
#[test]
fn rates_at_the_ends_are_of_the_chips_there() {
    let folder = folder();
    let scene = "pattern:noise?width=40&height=200&frames=24&seed=3&fps=100";
    let told = json(
        folder.path(),
        &[
            "feasibility",
            "csdvs-3",
            "--threshold",
            "30",
            "--to",
            "int-4",
            "--candidates",
            "int-4",
            "--chips",
            "1",
            "--within",
            "20ms",
            "--scene",
            scene,
            "--effort",
            "0.03",
            "-o",
            "r.html",
            "--json",
        ],
    );
    let turns = told["tornado"].as_array().unwrap();
    let noise = turns.iter().find(|turn| turn["figure"] == "error.noise");
    let [low, high] =
        ["low", "high"].map(|end| number(noise.unwrap(), &format!("/frames_s_at_{end}")));
    // More noise, more events in the busiest frame, more slots.
    assert!(high < 0.95 * low, "{low} to {high}");
}

/// A frame with more events than one scan delivers is read as whole bit planes: what is kept is of
/// all events, of one kernel as of several, and the same as `quantise` tells.
#[test]
fn what_is_judged_is_read_as_it_is_told() {
    let folder = folder();
    let scene = "pattern:noise?width=128&height=128&frames=6&fps=10&grain=2";
    let of = |kernels: &[&str]| {
        let rest = [
            "--to",
            "ternary",
            "--candidates",
            "ternary",
            "--threshold",
            "20",
            "--scene",
            scene,
            "--effort",
            "0.01",
            "--chips",
            "1",
            "-o",
            "report.html",
            "--json",
        ];
        json(folder.path(), &[&["feasibility"], kernels, &rest].concat())
    };
    let one = of(&["sobel-x"]);
    let plans = one["fit"]["on_chip"]["time"]["plans"].as_array().unwrap();
    let chosen = plans.iter().find(|plan| plan["is_chosen"] == true).unwrap();
    assert_eq!(chosen["lost"], 0.0);
    let slots = plans.iter().find(|plan| plan["plan"] == "busiest_frame");
    let lost = number(slots.unwrap(), "/lost");
    let (all, dropped) = (
        number(&one, "/streams/silicon/events"),
        number(&one, "/streams/silicon/dropped"),
    );
    assert!(
        dropped > 0.2 * all && (lost - dropped / all).abs() < 1e-9,
        "{lost} {dropped} {all}"
    );
    assert!((0.9..1.1).contains(&(all / number(&one, "/streams/float/events"))));
    let exact = number(&one, "/streams/exact/judged/f1/value");
    let kept = number(&one, "/streams/silicon/judged/kept");
    let drawn = number(&one, "/drawn/0/kept");
    assert!(kept > 0.8 && drawn > 0.8, "{kept} {drawn}");
    let steps = one["waterfall"]["steps"].as_array().unwrap();
    let read = steps
        .iter()
        .find(|step| step["cause"] == "readout")
        .unwrap();
    assert_eq!(number(read, "/forward/lost"), 0.0, "{read}");
    let said = one["verdict"]["findings"].to_string();
    assert!(said.contains(&format!(
        "With all slots of the program {dropped:.0} of them would be lost"
    )));

    let two = of(&["sobel-x", "sobel-y"]);
    let together = &two["together"]["kinds"][0];
    assert!(
        (number(together, "/kept") - kept).abs() < 0.05,
        "{together}"
    );
    for kernels in [&["sobel-x"][..], &["sobel-x", "sobel-y"]] {
        let ask = [
            "--to",
            "ternary",
            "--threshold",
            "20",
            "--scene",
            scene,
            "--effort",
            "0.01",
            "--json",
        ];
        let said = json(folder.path(), &[&["quantise"], kernels, &ask].concat());
        let warned = said["warnings"].to_string();
        assert!(
            warned.contains("all slots of the program would lose"),
            "{warned}"
        );
        // The filter of two kernels is another, and so is what its sums round.
        let (own, within) = match kernels {
            [_] => (&said["chip"]["rows"][0]["on_chip"]["exact"], 1e-12),
            _ => (&said["together"][0]["on_chip"]["kinds"][0]["exact"], 0.01),
        };
        assert!((number(own, "/f1") - exact).abs() < within, "{own}");
    }
}
