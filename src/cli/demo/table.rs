//! The demo for people: two tables, and how to read them.

use super::{
    Demo, TIMES,
    choice::{CHOSEN, DOMAINS, FEWER, KERNEL, SHOWN, THRESHOLD},
    showing::{Judged, Row, Showing},
};
use crate::{
    cli::arguments::light, compare::metric::Short, event::readout::scan::SLOTS, study::equivalent,
    unit::frame_rate,
};

/// Where no number stands.
const NONE: &str = "-";

impl Demo<'_> {
    pub(super) fn table(&self) -> String {
        let [own, faster] = &self.showings;
        let mut lines = Vec::new();
        if let Some(row) = own.reference() {
            let (from, to) = row.packet.span;
            lines.push(format!(
                "scene   the bundled clip, {}, {:.1} s",
                row.packet.size,
                to.seconds() - from.seconds()
            ));
        }
        let light = light::line(&self.observation);
        let light = light.trim_start_matches("light").trim();
        lines.push(format!("light   {light}"));
        lines.push(format!(
            "cells   a plain DVS, and {KERNEL} in {CHOSEN} (the values that `amacrine feasibility` chooses for it) and in {FEWER}"
        ));
        lines.push(format!(
            "        in all: an event where kernel times light (0 to 255) moved by more than {THRESHOLD}, one decision a frame"
        ));
        lines.push(String::new());
        lines.push(format!(
            "at {} frames/s, the clip's own: {} frames",
            frame_rate(own.fps),
            own.frames
        ));
        lines.extend(rows(own));
        lines.push(String::new());
        lines.push(format!(
            "at {} frames/s, which the chip can run: the same light, {} frames put in between each two",
            frame_rate(faster.fps),
            TIMES - 1
        ));
        lines.extend(rows(faster));
        lines.push(String::new());
        lines.extend(self.reading());
        lines.push(String::new());
        lines.extend(
            self.written
                .iter()
                .map(|path| format!("wrote {}", path.display())),
        );
        lines.push(String::new());
        lines.push(format!(
            "verbs: {}; amacrine help says what each does",
            super::super::verbs()
        ));
        lines.join("\n") + "\n"
    }

    /// What the columns are, and what the rows say.
    fn reading(&self) -> Vec<String> {
        let [own, faster] = &self.showings;
        let window = Short(own.window);
        let mut lines = vec![
            "How to read it: each row is compared with the float sensor of its own cell. kept is F1, from its".to_owned(),
            "floor (0: one that knows only how often each pixel fires) to 1 (every event right); the same as a".to_owned(),
            "threshold: a float sensor with a threshold so much higher keeps as much. An event is right within".to_owned(),
            format!(
                "{window} at its pixel with its sign; F1 within 1 ms is not shown: it asks for the same frame, and falls"
            ),
            "for any sensor with every frame that is put in.".to_owned(),
        ];
        let domains = DOMAINS.map(|(domain, what)| format!("{domain}: {what}"));
        lines.push(format!("{}.", domains.join("; ")));
        lines.push(format!(
            "Chip, nominal: by the nominal times of its data, with 2 x {SLOTS} readout slots."
        ));
        lines.push(String::new());
        let of = |showing: &Showing<'_>, to: &str, domain: &str| {
            let judged = showing.rows.iter().filter(|row| row.cell.name == KERNEL);
            let judged = judged.filter_map(|row| row.chip.as_ref());
            let mut found = judged.filter(|chip| chip.program.to == to);
            let found = found.find(|chip| chip.domain.to_string() == domain);
            found.map(|chip| chip.likeness)
        };
        let [exact, _, silicon] = DOMAINS.map(|(domain, _)| domain);
        if let (Some(values), Some(chip)) = (of(own, CHOSEN, exact), of(own, CHOSEN, silicon)) {
            lines.push(format!(
                "So {KERNEL} runs in the pixels: {CHOSEN} loses as much as a threshold {} higher, the chip's errors make that {}.",
                values.equivalent(),
                chip.equivalent()
            ));
        }
        let kept = |rows| of(rows, CHOSEN, silicon)?.kept;
        if let (Some(slow), Some(fast)) = (kept(own), kept(faster))
            && fast < slow
        {
            lines.push(format!(
                "With more frames less is kept ({fast:.3}, not {slow:.3}): each is another chance for noise to cross the threshold, and"
            ));
            lines.push(
                "the memory stores it. `amacrine waterfall` shows what each error does.".to_owned(),
            );
        }
        if let Some(fewer) = of(own, FEWER, exact) {
            lines.push(format!(
                "In {FEWER} it is another kernel: {} even without an error of the chip ({SHOWN} adds to that).",
                fewer.equivalent()
            ));
        }
        let dropped: u64 = { self.showings.iter() }
            .flat_map(|showing| &showing.rows)
            .map(|row| row.packet.dropped.total())
            .sum();
        if dropped > 0 {
            lines.push(format!(
                "({dropped} events of all rows found no readout slot)"
            ));
        }
        lines
    }
}

fn rows(showing: &Showing<'_>) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<18}{:<9}{:>9}{:>7}{:>7}{:>14}{:>7}{:>16}{:>15}",
        "", "", "events", "floor", "kept", "as threshold", "words", "chip, nominal", "emulated"
    )];
    lines.extend(showing.rows.iter().map(row));
    lines
}

fn row(row: &Row<'_>) -> String {
    let number = |value: f64| format!("{value:.3}");
    let missing = || NONE.to_owned();
    let of = |tell: &dyn Fn(&Judged<'_>) -> String| row.chip.as_ref().map_or_else(missing, tell);
    let few = row.chip.as_ref().filter(|_| row.cell.name == KERNEL);
    let name = few.map_or(row.cell.name.to_owned(), |chip| {
        format!("{} {}", row.cell.name, chip.program.to)
    });
    format!(
        "{name:<18}{:<9}{:>9}{:>7}{:>7}{:>14}{:>7}{:>16}{:>11.0} f/s",
        row.runs_in(),
        row.packet.events.len(),
        of(&|chip| number(chip.likeness.floor)),
        of(&|chip| equivalent::kept(chip.likeness.kept, 3)),
        of(&|chip| format!("+{}", chip.likeness.equivalent()).replace("+> ", "> +")),
        of(&|chip| chip.program.compiled.cost.words.0.to_string()),
        of(&|chip| format!(
            "{:.0} frames/s",
            chip.program.compiled.cost.frames_per_second()
        )),
        row.speed,
    )
}
