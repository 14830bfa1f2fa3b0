//! The atlas of ternary 3x3 kernels: for each of the 2,862 classes that differ by more than a turn
//! or a mirror the fewest words that are known to be needed, those of the program found, and how
//! much of it comes out of the silicon. `docs/atlas.md` is made by it.
//!
//! ```text
//! cargo run --release --example atlas                    # all classes; goes on where it was stopped
//! cargo run --release --example atlas -- --shard 0/4     # a part of them, for several machines
//! cargo run --release --example atlas -- --states 60000  # how long to search for each
//! cargo run --release --example atlas -- --prove 5       # the exhaustive search, as src/compile/search/bound/ternary.csv
//! ```
//!
//! Rows are added to `docs/atlas.csv` one by one; a class that has a row is not compiled again, so
//! shards are joined by putting their rows into one file. Once all are there the page is written.

use std::{
    collections::BTreeMap,
    error::Error,
    fmt::Write as _,
    fs::{self, OpenOptions},
    io::Write as _,
    path::Path,
    time::Instant,
};

use amacrine::{
    compile::{
        Effort, Objective, Request,
        bound::{LowerBound, TERNARY, canonical, classes, fewest_words, table, weights},
    },
    isa::Device,
    kernel::Kernel,
};

const CSV: &str = "docs/atlas.csv";
const PAGE: &str = "docs/atlas.md";
const HEAD: &str = "class,kernel,taps,lower,words,correlation,silicon_words,silicon_correlation";

/// States that each of the two searches of a class looks at.
const STATES: u64 = 12_000;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |name: &str| {
        let at = arguments.iter().position(|it| it == name)?;
        arguments.get(at + 1).map(String::as_str)
    };
    if let Some(words) = value("--prove") {
        let found = fewest_words(words.parse()?);
        eprintln!("{} states, and two words more for each", found.states);
        print!("{}", table(&found));
        return Ok(());
    }
    let states = value("--states").map_or(Ok(STATES), str::parse)?;
    let (shard, shards) = match value("--shard").map(|it| it.split_once('/')) {
        Some(Some((shard, shards))) => (shard.parse::<usize>()?, shards.parse::<usize>()?),
        Some(None) => return Err("--shard is I/N, such as 0/4".into()),
        None => (0, 1),
    };
    let mut rows = read()?;
    let began = Instant::now();
    let mut file = OpenOptions::new().create(true).append(true).open(CSV)?;
    if rows.is_empty() {
        writeln!(file, "{HEAD}")?;
    }
    for class in classes().skip(shard).step_by(shards) {
        if rows.contains_key(&class) {
            continue;
        }
        let row = Row::new(class, states)?;
        writeln!(file, "{}", row.line(class))?;
        rows.insert(class, row);
        if rows.len() % 100 == 0 {
            eprintln!(
                "{} classes, {:.0} s",
                rows.len(),
                began.elapsed().as_secs_f64()
            );
        }
    }
    if rows.len() == classes().count() {
        let all: String = rows
            .iter()
            .map(|(class, row)| row.line(*class) + "\n")
            .collect();
        fs::write(CSV, format!("{HEAD}\n{all}"))?;
        fs::write(PAGE, page(&rows))?;
    }
    Ok(())
}

/// What is known of a class.
struct Row {
    lower: u8,
    /// Words and predicted correlation of the shortest program, and of the one chosen for the
    /// silicon, which may be none.
    shortest: (usize, f64),
    silicon: Option<(usize, f64)>,
}

impl Row {
    fn new(class: u16, states: u64) -> Outcome<Self> {
        let kernels = [kernel(class)?];
        let device = Device::scamp5();
        let found = |objective| {
            let mut request = Request::new(&kernels, &device)?;
            request.effort = Effort::states(states);
            request.objective = objective;
            let filter = request.filter()?;
            let said = filter.best_forecast(&device, &kernels);
            let correlation = said.first().map_or(0.0, |it| it.correlation);
            Ok::<_, Box<dyn Error>>((filter.words.len(), correlation))
        };
        Ok(Self {
            lower: LowerBound::new(&kernels).words,
            shortest: found(Objective::Words)?,
            silicon: found(Objective::Silicon).ok(),
        })
    }

    fn line(&self, class: u16) -> String {
        let (words, correlation) = self.shortest;
        let silicon = self.silicon.map_or(",".to_owned(), |(words, correlation)| {
            format!("{words},{correlation:.4}")
        });
        format!(
            "{class},{},{},{},{words},{correlation:.4},{silicon}",
            picture(class),
            taps(class),
            self.lower
        )
    }

    /// As [`line`](Self::line) writes it.
    fn parse(fields: &[&str]) -> Option<Self> {
        let [lower, words, correlation, silicon_words, silicon] = fields else {
            return None;
        };
        let silicon = silicon_words.parse().ok().zip(silicon.parse().ok());
        Some(Self {
            lower: lower.parse().ok()?,
            shortest: (words.parse().ok()?, correlation.parse().ok()?),
            silicon,
        })
    }
}

fn read() -> Outcome<BTreeMap<u16, Row>> {
    let mut rows = BTreeMap::new();
    if !Path::new(CSV).exists() {
        return Ok(rows);
    }
    for line in fs::read_to_string(CSV)?.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        // A line that was cut off is made again.
        if let [class, _, _, rest @ ..] = &fields[..]
            && let (Ok(class), Some(row)) = (class.parse(), Row::parse(rest))
        {
            rows.insert(class, row);
        }
    }
    Ok(rows)
}

fn kernel(class: u16) -> Outcome<Kernel> {
    let rows = weights(class).map(|row| row.map(f64::from).to_vec());
    Ok(Kernel::from_rows(&rows)?)
}

/// Row by row: `+`, `-` and `0`.
fn picture(class: u16) -> String {
    let signs = |row: [i8; 3]| row.map(|weight| ['-', '0', '+'][(weight + 1) as usize]);
    let rows = weights(class).map(|row| signs(row).iter().collect::<String>());
    rows.join("/")
}

fn taps(class: u16) -> usize {
    weights(class)
        .iter()
        .flatten()
        .filter(|it| **it != 0)
        .count()
}

/// Shares of some numbers: the least, the median, the most.
fn spread(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
    if values.is_empty() {
        return "| | ".to_owned();
    }
    format!("{:.3} | {:.3} | {:.3}", at(0.0), at(0.5), at(1.0))
}

fn page(rows: &BTreeMap<u16, Row>) -> String {
    let mut text = "# Atlas of ternary 3x3 kernels\n\n".to_owned();
    let signed = |class: &&u16| canonical(TERNARY as u16 - 1 - **class) >= **class;
    let optimal = |row: &&Row| row.shortest.0 <= usize::from(row.lower);
    let _ = write!(
        text,
        "The {} classes of ternary 3x3 kernels that differ by more than a turn or a mirror ({} where a kernel and its negative count as one), each compiled for SCAMP-5, from register A into A. `atlas.csv` has a line for each: the kernel row by row, its taps, the fewest words that any program can have (`lower`), the words of the shortest program found and the correlation with the exact kernel that is predicted of it on the chip, and both for the program that is chosen for the silicon. Made by\n\n```\ncargo run --release --example atlas\n```\n\n",
        rows.len(),
        rows.keys().filter(signed).count()
    );
    let _ = write!(
        text,
        "Of {} classes the shortest program is proved to be optimal: every program of fewer words was tried, whatever its registers (`cargo run --release --example atlas -- --prove 5`). Of the others it lies between `lower` and `words`. A correlation is predicted from the chip's data, in part a guess, at the best of five input amplitudes (`silicon.md`).\n\n",
        rows.values().filter(optimal).count()
    );
    text += "## Words of the shortest program\n\n| words | classes | proved optimal | correlation, least | median | most |\n|---|---|---|---|---|---|\n";
    let mut of_words: BTreeMap<usize, Vec<&Row>> = BTreeMap::new();
    for row in rows.values() {
        of_words.entry(row.shortest.0).or_default().push(row);
    }
    for (words, own) in &of_words {
        let proved = own.iter().filter(|row| optimal(row)).count();
        let all = own.iter().map(|row| row.shortest.1).collect();
        let _ = writeln!(
            text,
            "| {words} | {} | {proved} | {} |",
            own.len(),
            spread(all)
        );
    }
    text += "\n## By taps\n\n| taps | classes | words, least to most | correlation, median | words for the silicon | correlation, median |\n|---|---|---|---|---|---|\n";
    let median = |mut all: Vec<f64>| {
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0)
    };
    let between = |all: Vec<usize>| {
        let [least, most] = [all.iter().min(), all.iter().max()].map(|it| it.copied().unwrap_or(0));
        format!("{least} to {most}")
    };
    for count in 0..=9 {
        let own: Vec<&Row> = { rows.iter() }
            .filter(|(class, _)| taps(**class) == count)
            .map(|(_, row)| row)
            .collect();
        let silicon = || own.iter().filter_map(|row| row.silicon);
        let _ = writeln!(
            text,
            "| {count} | {} | {} | {:.3} | {} | {:.3} |",
            own.len(),
            between(own.iter().map(|row| row.shortest.0).collect()),
            median(own.iter().map(|row| row.shortest.1).collect()),
            between(silicon().map(|it| it.0).collect()),
            median(silicon().map(|it| it.1).collect()),
        );
    }
    text
}
