//! The page that is made of what was measured: rows of tables, and how much of a bound is used.

use std::{
    fmt::{Display, Write},
    fs,
    path::Path,
    sync::Mutex,
};

/// The most of a bound that was used, over many cases.
#[derive(Clone, Copy, Debug, Default)]
pub struct Worst {
    ratio: f64,
    cases: usize,
}

impl Worst {
    /// One more case: it was off by `error`, and may be by `bound`.
    pub fn see(&mut self, error: f64, bound: f64, what: impl Display) {
        // An error that is no number is above any bound, and a bound that is infinite is none.
        assert!(
            bound < f64::INFINITY && error <= bound,
            "{what}: off by {error:e}, the bound is {bound:e}"
        );
        if error > 0.0 {
            self.ratio = self.ratio.max(error / bound);
        }
        self.cases += 1;
    }

    /// How many cases there were.
    pub const fn cases(&self) -> usize {
        self.cases
    }

    /// Coarsely, so that the last digits of another machine change nothing: the first rung that
    /// the ratio does not reach.
    fn class(&self) -> String {
        if self.ratio == 0.0 {
            return "0".into();
        }
        let rung = LADDER.into_iter().find(|most| self.ratio <= *most);
        match rung {
            Some(most) if most < 1.0 => format!("below {most:?}"),
            _ => "up to 1".into(),
        }
    }

    /// Whether another machine's last digits could change the class.
    fn is_near_a_rung(&self) -> bool {
        let near = |rung: &f64| *rung < 1.0 && (self.ratio / rung - 1.0).abs() < 0.1;
        LADDER.iter().any(near)
    }
}

/// Classes of how much of a bound is used.
const LADDER: [f64; 5] = [1e-6, 1e-4, 0.01, 0.12, 1.0];

/// The table of one room.
#[derive(Default)]
pub struct Table {
    rows: Vec<String>,
}

impl Table {
    fn row(&mut self, cells: [&str; 5]) {
        let mut row = String::new();
        for cell in cells {
            let _ = write!(row, "| {} ", cell.replace('|', "\\|").replace('\n', " "));
        }
        self.rows.push(row + "|");
    }

    /// A result that a bound holds for.
    pub fn within(&mut self, what: &str, to: &str, happens: &str, bound: &str, worst: Worst) {
        assert!(worst.cases > 0, "{what}, {to}: nothing was tried");
        if blesses() && worst.is_near_a_rung() {
            println!(
                "another machine may see another class than {}: {what}, {to}",
                worst.ratio
            );
        }
        self.row([what, to, happens, bound, &worst.class()]);
    }

    /// Something that happens, without a bound.
    pub fn happens(&mut self, what: &str, to: &str, happens: &str) {
        self.row([what, to, happens, "", ""]);
    }

    /// A refusal, in its own words.
    pub fn refused(&mut self, what: &str, to: &str, error: impl Display) {
        self.row([what, to, &format!("refused: *{error}*"), "", ""]);
    }

    /// Holds the page's table of this room to the rows; writes it if `AMACRINE_BLESS` is set.
    pub fn check(self, room: &str) {
        static WRITING: Mutex<()> = Mutex::new(());
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/extremes.md");
        let mut table = "| driven | to | what happens | bound | of it is used |\n".to_owned();
        table.push_str("|---|---|---|---|---|\n");
        for row in &self.rows {
            table.push_str(row);
            table.push('\n');
        }
        let held = WRITING.lock();
        let page = fs::read_to_string(&path).unwrap();
        let (begin, end) = (format!("<!-- {room} -->\n"), format!("<!-- end {room} -->"));
        let (before, rest) = page.split_once(&begin).expect("the room's marks");
        let (old, after) = rest.split_once(&end).expect("the room's marks");
        if blesses() {
            fs::write(&path, format!("{before}{begin}{table}{end}{after}")).unwrap();
        }
        drop(held);
        if !blesses() {
            for (old, new) in old.lines().zip(table.lines()) {
                assert_eq!(new, old, "docs/extremes.md says otherwise");
            }
            assert_eq!(old, table, "docs/extremes.md has other rows");
        }
    }
}

/// Whether the page is to be written.
fn blesses() -> bool {
    std::env::var_os("AMACRINE_BLESS").is_some()
}

/// Powers of ten.
pub fn decades(from: i32, to: i32) -> impl Iterator<Item = f64> + Clone {
    (from..=to).map(|exponent| 10f64.powi(exponent))
}
