//! A study file: which points, and what is measured of each.

use super::{
    key::{FLOAT_MEMORIES, KEYS, Key, Side},
    key_values::SEE,
    overrides::{Override, overridden},
};
pub use crate::compare::metric::IN_STUDIES as METRICS;
use crate::{
    compare::{metric::Scale, window},
    compile::Effort,
    config::{
        self, CHANGES_NOTHING, Document, Fault, Faults, Kind, Name, Node, Place, Range, Read,
        Section, Spelling, Table, unknown_key,
    },
    study::sweep::points::{
        grid::{self, Axes},
        point::Point,
        sample::{Method, Sample, Search},
    },
    unit::Micros,
};

/// The columns that error may be weighed against.
pub const COSTS: [&str; 4] = ["seconds_per_frame", "bits", "words", "state_memory_bytes"];

/// A study, read and checked; nothing that it names has been opened.
#[derive(Clone, Debug)]
pub struct Study {
    /// The file's name as it was given.
    pub file: String,
    /// Its text.
    pub text: String,
    /// What it is called.
    pub title: String,
    /// What is measured.
    pub settings: Settings,
    /// The axes of each `[[side]]`.
    pub sides: Vec<Axes>,
    /// Points drawn in place of the grid.
    pub sample: Option<Sample>,
}

/// What holds for every point.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// What is measured, by name.
    pub metrics: Vec<&'static str>,
    /// Windows of matches: what is kept in the first of them is a point's headline. Where there
    /// is none, the headline's is 100 ms or the time from frame to frame of the point's scene.
    pub within: Vec<Micros>,
    /// Time constants of van Rossum's distance.
    pub van_rossum: Vec<Micros>,
    /// Shifts that cost 1 in Victor and Purpura's distance.
    pub victor_purpura: Vec<Micros>,
    /// Which memory the sensor has against which events are measured.
    pub against: &'static str,
    /// Whether the f64 sensor is run at other thresholds, too, to tell what costs as much.
    pub threshold_equivalent: bool,
    /// How long to search for each program, in states.
    pub effort: u64,
    /// The share of a point's events that a plainer model may change, where one may stand for it.
    pub tolerance: Option<f64>,
}

impl Settings {
    /// All that changes what is written of a point, in a fixed order.
    pub(in crate::study::sweep) fn measured(&self) -> serde_json::Value {
        let mut all = vec![
            serde_json::json!(self.metrics),
            serde_json::json!(self.within),
            serde_json::json!(self.van_rossum),
            serde_json::json!(self.victor_purpura),
            serde_json::json!(self.against),
            serde_json::json!(self.threshold_equivalent),
        ];
        all.extend(
            self.tolerance
                .map(|tolerance| serde_json::json!({"tolerance": tolerance})),
        );
        all.into()
    }

    /// The windows of the metrics that are measured in windows.
    pub(in crate::study::sweep) fn windows(&self) -> &[Micros] {
        if self.within.is_empty() {
            &[window::HEADLINE]
        } else {
            &self.within
        }
    }

    /// What metrics of a scale are measured at: windows, or time constants.
    pub(in crate::study::sweep) fn scales(&self, scale: Scale) -> &[Micros] {
        match scale {
            Scale::Window => self.windows(),
            Scale::TimeConstant => &self.van_rossum,
            Scale::Shift => &self.victor_purpura,
            Scale::None => &[],
        }
    }

    /// The window of a point's headline, for a scene of so many frames a second.
    pub(in crate::study::sweep) fn headline(&self, fps: f64) -> Micros {
        let first = self.within.first().copied();
        first.unwrap_or_else(|| window::headline(fps))
    }
}

/// Metrics that are measured when none are named: the cheap ones.
const USUAL: [&str; 5] = ["f1", "precision", "recall", "count-l1", "van-rossum"];

/// What the events are measured against.
pub const AGAINST: [&str; 4] = {
    let [one, other, third] = FLOAT_MEMORIES;
    ["same", one, other, third]
};

const NAMES: [&str; METRICS.len()] = {
    let mut names = [""; METRICS.len()];
    let mut at = 0;
    while at < names.len() {
        names[at] = METRICS[at].0;
        at += 1;
    }
    names
};

/// Some of the metrics, or one.
const CHOSEN: Kind = Kind::Either {
    ways: &[Kind::Choice(&NAMES), Kind::list(&Kind::Choice(&NAMES))],
    expected: "the name of a metric, or a list of them",
};

/// Times, or one.
const WINDOWS: Kind = Kind::Either {
    ways: &[WINDOW, several(&WINDOW)],
    expected: "a time such as 1ms, or a list of them",
};

const WINDOW: Kind = Kind::Spelled(&Spelling {
    what: "a number and a unit, such as 100us, 1ms or 0.5s",
    pattern: TIME,
    holds: |text| text.parse::<Micros>().is_ok(),
});

/// A share: a number, or per cent.
const SHARE: Kind = Kind::Either {
    ways: &[
        Kind::Number(Range::between(0.0, 1.0)),
        Kind::Spelled(&Spelling {
            what: "a percentage",
            pattern: r"^\s*[0-9]+\.?[0-9]*\s*%\s*$",
            holds: |text| per_cent(text).is_some(),
        }),
    ],
    expected: "a number from 0 to 1, or a percentage such as \"1%\"",
};

/// `1%`, as a share.
fn per_cent(text: &str) -> Option<f64> {
    let number = text.trim().strip_suffix('%')?.trim_end();
    let digits = number.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let share = number.parse::<f64>().ok().filter(|_| digits)? / 100.0;
    (0.0..=1.0).contains(&share).then_some(share)
}

/// Times above zero, or one.
const TIMES: Kind = Kind::Either {
    ways: &[ABOVE, several(&ABOVE)],
    expected: "a time such as 5ms, or a list of them",
};

const ABOVE: Kind = Kind::Spelled(&Spelling {
    what: "a number above 0 and a unit, such as 100us, 1ms or 0.5s",
    pattern: TIME,
    holds: |text| text.parse().is_ok_and(|time: Micros| time.0 > 0),
});

const TIME: &str = r"^\s*[0-9]+\.?[0-9]*\s*(us|µs|ms|s)$";

const fn several(of: &'static Kind) -> Kind {
    Kind::List {
        of,
        least: 1,
        most: usize::MAX,
    }
}

const SAMPLE: Table = Table::new(&[
    config::Key::required(
        "method",
        Kind::Choice(&["random", "sobol", "search"]),
        "how points are drawn; `search` tries them on parts of the scene and computes the best",
    )
    .example("method = \"search\""),
    config::Key::required(
        "points",
        Kind::Whole {
            least: 1,
            most: i64::MAX as u64,
        },
        "how many",
    )
    .example("points = 256"),
    config::Key::with_default(
        "seed",
        Kind::Whole {
            least: 0,
            most: i64::MAX as u64,
        },
        "0",
        "chooses the points",
    ),
    config::Key::with_default(
        "finish",
        Kind::Number(Range::between(0.001, 1.0)),
        "0.05",
        "of a search: the share of the points that are computed on the whole scene",
    ),
    config::Key::with_default(
        "cost",
        Kind::Choice(&COSTS),
        "\"seconds_per_frame\"",
        "of a search: what error is weighed against, as `--cost` of `amacrine report`",
    ),
]);

const BESIDE: Table = Table::new(&SETTINGS);

/// The keys beside the axes, and what each is.
pub const SETTINGS: [config::Key; 12] = [
    config::Key::optional(
        "title",
        Kind::Text,
        "what the study is called; the file's name when left out",
    ),
    config::Key::optional(
        "source",
        Kind::Text,
        "where the numbers come from, for people",
    ),
    config::Key::optional(
        "metrics",
        CHOSEN,
        "what is measured of each point; `f1`, `precision`, `recall`, `count-l1` and `van-rossum` when left out",
    ),
    config::Key::optional(
        "within",
        WINDOWS,
        "windows of matches, such as `[\"10ms\", \"100ms\"]`; a point's error is 1 - kept in the first. When left out metrics are measured at 100 ms, and the error at 100 ms or the time from frame to frame where that is longer",
    ),
    config::Key::with_default(
        "van-rossum",
        TIMES,
        "\"5ms\"",
        "time constants of van Rossum's distance; `\"5ms\"` when left out",
    ),
    config::Key::with_default(
        "victor-purpura",
        TIMES,
        "\"5ms\"",
        "shifts that cost 1 in Victor and Purpura's distance; `\"5ms\"` when left out",
    ),
    config::Key::with_default(
        "against",
        Kind::Choice(&AGAINST),
        "\"same\"",
        "memory of the f64 sensor that events are measured against: `same` as the point's own (when left out), or one for all",
    ),
    config::Key::with_default(
        "threshold-equivalent",
        Kind::Flag,
        "true",
        "also tell errors as the change of the f64 sensor's threshold that costs as much: for each task the f64 sensor watches ten times more; `true` when left out",
    ),
    config::Key::with_default(
        "effort",
        Kind::Number(Range::between(0.0, 3600.0)),
        "1",
        "how long to search for each program of an array, in seconds of two cores of 2024 (a kernel of 3x3; larger ones and several take some times as long); counted in states, so the result does not depend on the machine; 1 when left out",
    ),
    config::Key::with_default(
        "fidelity",
        Kind::Choice(&["full", "auto"]),
        "\"full\"",
        "`auto`: a plainer model stands for a point where a pilot finds that it changes no more than `tolerance`; `full` when left out",
    ),
    config::Key::with_default(
        "tolerance",
        SHARE,
        "0.01",
        "the share of a point's events that may change under `fidelity = \"auto\"`, such as 0.01 or \"1%\"; 0.01 when left out",
    ),
    config::Key::optional(
        "sample",
        Kind::Table(&SAMPLE),
        "draw points instead of taking the whole grid: `{ method = \"sobol\", points = 256, seed = 0 }` or `method = \"random\"`; `method = \"search\"` computes the best of them",
    ),
];

impl Study {
    /// Reads the text of a study called `file`.
    ///
    /// # Errors
    /// Everything that is wrong, each with its place.
    pub fn parse(file: &str, text: &str) -> Result<Self, Faults> {
        let document = Document::parse(text).map_err(|fault| Faults::one(file, text, fault))?;
        let mut reader = Reader {
            text,
            faults: Vec::new(),
        };
        let study = reader.study(file, document.root());
        if !reader.faults.is_empty() {
            return Err(Faults::new(file, text, reader.faults));
        }
        study.ok_or_else(|| {
            // Nothing is missing without a fault.
            Faults::one(file, text, no_side())
        })
    }

    /// Reads the text with keys set from outside.
    ///
    /// # Errors
    /// Everything that is wrong, each with its place in the text with the keys in it.
    pub fn parse_with(file: &str, text: &str, overrides: &[Override]) -> Result<Self, Faults> {
        if overrides.is_empty() {
            return Self::parse(file, text);
        }
        let text = overridden(file, text, overrides)?;
        let set: Vec<_> = overrides.iter().map(ToString::to_string).collect();
        let shown = format!("{file} with {}", set.join(" "));
        let title = Self::parse(file, &text).map(|study| study.title);
        let study = Self::parse(&shown, &text)?;
        Ok(Self {
            title: title.unwrap_or_default(),
            ..study
        })
    }

    /// The points in their fixed order, as they are named: the same one may come twice.
    ///
    /// # Errors
    /// When there are too many, or none.
    pub fn points(&self) -> Result<Vec<Point>, Faults> {
        let points = match &self.sample {
            Some(sample) => Ok(sample.points(&self.sides)),
            None => grid::points(&self.sides),
        };
        points.map_err(|fault| self.fault(fault))
    }

    /// The same study with each point computed in full, whatever `fidelity` says.
    #[must_use]
    pub fn in_full(mut self) -> Self {
        self.settings.tolerance = None;
        self
    }

    /// A fault in this file.
    #[must_use]
    pub fn fault(&self, fault: Fault) -> Faults {
        Faults::one(&self.file, &self.text, fault)
    }
}

fn no_side() -> Fault {
    Fault::error(
        Place::new(0, 0),
        "there is no [[side]]",
        "a study needs one",
    )
    .help("add [[side]] with side = \"reference\", \"array\" or \"mesh\", once for each sensor")
}

/// A key and what it is set to.
pub(super) type Entry<'a> = (Name<'a>, Node<'a>);

/// The study being read; everything that is wrong with it so far.
pub(super) struct Reader<'a> {
    pub text: &'a str,
    pub faults: Vec<Fault>,
}

impl Reader<'_> {
    /// What was read, or its fault is kept.
    pub fn keep<T>(&mut self, read: Read<T>) -> Option<T> {
        read.map_err(|fault| self.faults.push(fault)).ok()
    }

    fn study(&mut self, file: &str, root: Node<'_>) -> Option<Study> {
        let mut axes = Vec::new();
        let mut sides = None;
        let mut right = true;
        for (name, node) in root.as_table().unwrap_or_default() {
            if name.text == "side" {
                sides = Some(node);
            } else if let Some(key) = BESIDE.key(name.text) {
                let checked = key.kind.check(node, key.name, SEE);
                right &= self.keep(checked).is_some();
            } else if all_names().any(|known| known == name.text) {
                axes.push((name, node));
            } else {
                self.faults.push(unknown_key(name, all_names(), SEE));
            }
        }
        // What is built of wrong settings would only repeat what is wrong.
        let read = if right {
            let settings = Section::new(root, &BESIDE);
            let read = settings_of(&settings).and_then(|it| Ok((it, sample_of(&settings)?)));
            self.keep(read)
        } else {
            None
        };
        let Some(section) = sides else {
            self.faults.push(no_side());
            return None;
        };
        let sides = self.sides(section, &axes, root.get("sample").is_some());
        self.unused(&axes, section, &sides);
        let no_array = sides.iter().all(|side| side.side != Side::Array);
        if let Some(effort) = root.get("effort").filter(|_| no_array && !sides.is_empty()) {
            let what = "`effort` is of programs, and no side of this study searches for one";
            self.faults.push(
                Fault::error(effort.place(), what, CHANGES_NOTHING)
                    .help("leave it out, or add a [[side]] with side = \"array\""),
            );
        }
        let (settings, sample) = read?;
        let cost = sample.and_then(|sample| sample.search).map(|it| it.cost);
        if cost == Some("words") && no_array {
            let place = root.get("sample").map_or(Place::default(), Node::place);
            let what = "no point has `words`: only the array has, and there is no such side";
            self.faults.push(
                Fault::error(place, what, "weighs error against words")
                    .help("take another cost, or add a [[side]] with side = \"array\""),
            );
        }
        let title = root.get("title").and_then(Node::as_text);
        let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
        let title = title.unwrap_or_else(|| name.strip_suffix(".toml").unwrap_or(name));
        Some(Study {
            file: file.to_owned(),
            text: self.text.to_owned(),
            title: title.to_owned(),
            settings,
            sides,
            sample,
        })
    }
}

fn settings_of(section: &Section<'_>) -> Read<Settings> {
    let times = |key: &str, usual: &[Micros]| match section.get(key) {
        None => usual.to_vec(),
        Some(node) => each_once(node, |text| text.parse().ok()),
    };
    let equivalent = section.get("threshold-equivalent");
    let metric = |text: &str| NAMES.into_iter().find(|name| *name == text);
    let metrics = section.get("metrics");
    if section.get("tolerance").is_some() && section.get("fidelity").is_none() {
        let what = "`tolerance` is of plainer models, and none stands for a point";
        let fault = Fault::error(section.place_of("tolerance"), what, CHANGES_NOTHING);
        return Err(fault.help("leave it out, or set fidelity = \"auto\""));
    }
    let metrics: Vec<_> = metrics.map_or(USUAL.to_vec(), |node| each_once(node, metric));
    // Each has the name of its metric.
    for key in ["van-rossum", "victor-purpura"] {
        if section.get(key).is_some() && !metrics.contains(&key) {
            let what = format!("`{key}` is of a metric that this study does not measure");
            let fault = Fault::error(section.place_of(key), what, CHANGES_NOTHING);
            return Err(fault.help(format!("leave it out, or add \"{key}\" to `metrics`")));
        }
    }
    let against = section.text("against")?;
    let against = AGAINST.into_iter().find(|name| *name == against);
    Ok(Settings {
        metrics,
        within: times("within", &[]),
        van_rossum: times("van-rossum", &[Micros(5_000)]),
        victor_purpura: times("victor-purpura", &[Micros(5_000)]),
        against: against.unwrap_or(AGAINST[0]),
        threshold_equivalent: equivalent.and_then(Node::as_flag).unwrap_or(true),
        effort: Effort::seconds(section.number("effort")?).states,
        tolerance: if section.text("fidelity")? == "auto" {
            let written = section.get("tolerance").and_then(Node::as_text);
            let share = match written.and_then(per_cent) {
                Some(share) => share,
                None => section.number("tolerance")?,
            };
            Some(share).filter(|share| *share > 0.0)
        } else {
            None
        },
    })
}

fn sample_of(settings: &Section<'_>) -> Read<Option<Sample>> {
    let Some(sample) = settings.table("sample") else {
        return Ok(None);
    };
    let ways = [Method::Random, Method::Sobol, Method::Search];
    let method = sample.word("method", &ways)?;
    let method = method.unwrap_or(Method::Random);
    let points = sample.whole("points")?;
    let most = method.most();
    if points > most {
        let what = format!("`sample.points` is {points}");
        let place = sample.place_of("points");
        return Err(Fault::error(place, what, "here").help(format!("give from 1 to {most} points")));
    }
    let seed = sample.whole("seed")?;
    let mut search = None;
    if method == Method::Search {
        let cost = sample.text("cost")?;
        search = Some(Search {
            finish: sample.number("finish")?,
            cost: { COSTS.into_iter() }
                .find(|known| *known == cost)
                .unwrap_or(COSTS[0]),
            seed,
        });
    } else if let Some(key) = ["finish", "cost"]
        .iter()
        .find(|key| sample.get(key).is_some())
    {
        let what = format!("`sample.{key}` is of a search, and nothing is searched for");
        let fault = Fault::error(sample.place_of(key), what, CHANGES_NOTHING);
        return Err(fault.help("leave it out, or set method = \"search\""));
    }
    Ok(Some(Sample {
        method,
        points,
        seed,
        search,
    }))
}

/// Every key that can stand at the top.
fn all_names() -> impl Iterator<Item = &'static str> + Clone {
    let settings = BESIDE.names().chain(["side"]);
    // Two sides may have keys of one name.
    let once = |(i, key): (usize, &'static Key)| {
        let before = KEYS.iter().take(i).any(|other| other.name == key.name);
        (!before).then_some(key.name)
    };
    settings.chain(KEYS.iter().enumerate().filter_map(once))
}

/// A value, or those of a list, each once.
fn each_once<T: PartialEq>(node: Node<'_>, read: impl Fn(&str) -> Option<T>) -> Vec<T> {
    let mut all = Vec::new();
    for item in node.as_list().unwrap_or_else(|| vec![node]) {
        if let Some(value) = item.as_text().and_then(&read)
            && !all.contains(&value)
        {
            all.push(value);
        }
    }
    all
}
