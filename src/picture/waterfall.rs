//! The waterfall chart: for each step of a design, which events are kept, changed, lost and new.

use super::{
    chart::{
        Anchor, Area, Drawing,
        axes::{Axis, Scale, axes},
    },
    ink::{self, Ink},
    text::{LINE, Weight},
};
use crate::compare::fate::Fate;

/// What a waterfall chart shows.
#[derive(Clone, Debug)]
pub struct WaterfallShow<'a> {
    /// The line on top.
    pub title: &'a str,
    /// Lines below it.
    pub captions: &'a [String],
    /// The number of events that counts as 100 %.
    pub whole: u64,
    /// From the first to the last.
    pub steps: &'a [WaterfallStep<'a>],
    /// The first packet against the last.
    pub ends: Fate,
}

/// One step.
#[derive(Clone, Copy, Debug)]
pub struct WaterfallStep<'a> {
    /// The name of the step.
    pub name: &'a str,
    /// What it changes when it is added to the steps before it.
    pub forward: Fate,
    /// What changes when it alone is left out of the whole; `None` where that is not known.
    pub backward: Option<Fate>,
}

const MARGIN: f64 = 24.0;
/// Width of the column of step names, in points.
const NAMES: f64 = 212.0;
const PACKETS: f64 = 400.0;
const CHANGES: f64 = 260.0;
/// Width of the column of numbers beside the bars, in points.
const VALUES: f64 = 76.0;
const GAP: f64 = 32.0;
const ROW: f64 = 48.0;
const BAR: f64 = 14.0;

const LEGEND: [(&str, Ink); 5] = [
    ("kept", ink::MATCHED),
    ("mistimed", ink::MISTIMED),
    ("wrong sign", ink::SWAPPED),
    ("lost", ink::MISSING),
    ("extra", ink::EXTRA),
];

/// A row for each step: at the left the packets before and after it, at the right what the
/// step changes, in order and alone.
#[must_use]
pub fn waterfall(show: &WaterfallShow<'_>) -> Drawing {
    let line = f64::from(LINE);
    let top = MARGIN + (show.captions.len() + 4) as f64 * line;
    let rows = show.steps.len() as f64 + 1.0;
    let packets = Area {
        x: MARGIN + NAMES,
        y: top,
        width: PACKETS,
        height: rows * ROW + GAP / 2.0,
    };
    let changes = Area {
        x: packets.right() + GAP,
        width: CHANGES,
        ..packets
    };
    let width = changes.right() + VALUES + MARGIN;
    let mut page = Drawing::new(width, packets.bottom() + 3.0 * line + MARGIN);
    head(&mut page, show, &[packets, changes]);
    let share = |events: u64| 100.0 * events as f64 / show.whole.max(1) as f64;
    let scale = |most: f64, label| Axis {
        label,
        from: 0.0,
        to: if most > 0.0 { 1.04 * most } else { 1.0 },
        scale: Scale::Plain,
    };
    let all = || {
        let steps = show.steps.iter().map(|step| step.forward);
        steps.chain([show.ends])
    };
    let most = all().map(|c| c.after().max(c.kept + c.mistimed + c.wrong_sign + c.lost));
    let held = scale(share(most.max().unwrap_or(0)), "% of the first packet");
    let backward = || show.steps.iter().filter_map(|step| step.backward);
    let most = all().chain(backward()).map(Fate::changed).max();
    let changed = scale(share(most.unwrap_or(0)), "% of the first packet");
    let nothing = Axis {
        to: 0.0,
        ..scale(0.0, "")
    };
    axes(&mut page, packets, held, nothing);
    axes(&mut page, changes, changed, nothing);
    let whole = packets.x + held.part(100.0) * packets.width;
    page.line(
        (whole, packets.y),
        (whole, packets.bottom()),
        1.0,
        ink::GRID,
    );
    let mut row = Row {
        page: &mut page,
        y: top + GAP / 4.0,
        packets: (packets, held),
        changes: (changes, changed),
        whole: show.whole,
    };
    for step in show.steps {
        row.step(step.name, step.forward);
        row.change(0.0, Some(step.forward));
        row.change(BAR + 2.0, step.backward);
        row.y += ROW;
    }
    row.y += GAP / 4.0;
    let y = row.y - GAP / 4.0;
    row.step("first to last at once", show.ends);
    row.change(0.0, Some(show.ends));
    page.line((MARGIN, y), (width - MARGIN, y), 1.0, ink::GRID);
    page.fitted(MARGIN)
}

/// Title, captions, legend, and what each plot shows.
fn head(page: &mut Drawing, show: &WaterfallShow<'_>, plots: &[Area; 2]) {
    let line = f64::from(LINE);
    let mut y = MARGIN;
    page.text(
        (MARGIN, y),
        Anchor::Start,
        Weight::Heading,
        ink::TEXT,
        show.title,
    );
    for caption in show.captions {
        y += line;
        page.text(
            (MARGIN, y),
            Anchor::Start,
            Weight::Plain,
            ink::CAPTION,
            caption,
        );
    }
    y += 1.3 * line;
    let mut x = MARGIN;
    for (name, ink) in LEGEND {
        let swatch = Area {
            x,
            y: y + 3.0,
            width: BAR,
            height: BAR,
        };
        page.fill(swatch, ink);
        page.text(
            (x + BAR + 6.0, y),
            Anchor::Start,
            Weight::Plain,
            ink::TEXT,
            name,
        );
        x += BAR + 6.0 + 7.0 * name.len() as f64 + 20.0;
    }
    let what = [
        "packets: before each step above, after it below",
        "changed: in order above, alone below",
    ];
    for (plot, what) in plots.iter().zip(what) {
        let at = (plot.x, plot.y - 1.2 * line);
        page.text(at, Anchor::Start, Weight::Plain, ink::TEXT, what);
    }
}

/// The row that is being drawn.
struct Row<'a> {
    page: &'a mut Drawing,
    y: f64,
    packets: (Area, Axis<'static>),
    changes: (Area, Axis<'static>),
    whole: u64,
}

impl Row<'_> {
    fn share(&self, events: u64) -> f64 {
        100.0 * events as f64 / self.whole.max(1) as f64
    }

    /// Draws the step's name, and how many events there are before and after it.
    fn step(&mut self, name: &str, classes: Fate) {
        let line = f64::from(LINE);
        let at = (MARGIN, self.y - 4.0);
        self.page
            .text(at, Anchor::Start, Weight::Plain, ink::TEXT, name);
        let after = classes.after();
        let text = format!("leaves {:.1} %", self.share(after));
        let at = (MARGIN, self.y - 4.0 + line);
        self.page
            .text(at, Anchor::Start, Weight::Plain, ink::CAPTION, text);
        let Fate {
            kept,
            mistimed,
            wrong_sign,
            lost,
            extra,
        } = classes;
        let both = [
            (kept, ink::MATCHED),
            (mistimed, ink::MISTIMED),
            (wrong_sign, ink::SWAPPED),
        ];
        for (down, own) in [
            (0.0, (lost, ink::MISSING)),
            (BAR + 2.0, (extra, ink::EXTRA)),
        ] {
            let [a, b, c] = both;
            self.stack(self.packets, down, &[a, b, c, own]);
        }
    }

    /// Draws what a step changes, in the plot at `down`.
    fn change(&mut self, down: f64, classes: Option<Fate>) {
        let (area, axis) = self.changes;
        let mut end = 0;
        let text = if let Some(classes) = classes {
            end = classes.changed();
            let parts = [
                (classes.mistimed, ink::MISTIMED),
                (classes.wrong_sign, ink::SWAPPED),
                (classes.lost, ink::MISSING),
                (classes.extra, ink::EXTRA),
            ];
            self.stack((area, axis), down, &parts);
            format!("{:.2} %", self.share(end))
        } else {
            "no sensor".to_owned()
        };
        let x = area.x + axis.part(self.share(end)) * area.width;
        let at = (x + 6.0, self.y + down - 4.0);
        self.page
            .text(at, Anchor::Start, Weight::Plain, ink::CAPTION, text);
    }

    /// Draws bars end to end: numbers of events, each in its ink.
    fn stack(&mut self, (area, axis): (Area, Axis<'static>), down: f64, parts: &[(u64, Ink)]) {
        let mut sum = 0;
        let mut x = area.x;
        for (events, ink) in parts.iter().filter(|(events, _)| *events > 0) {
            sum += events;
            let right = area.x + axis.part(self.share(sum)) * area.width;
            let bar = Area {
                x,
                y: self.y + down,
                width: right - x,
                height: BAR,
            };
            self.page.fill(bar, *ink);
            x = right;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{raster, svg};

    #[test]
    fn bars_have_the_lengths_of_their_shares() {
        let forward = Fate {
            kept: 50,
            lost: 50,
            extra: 25,
            ..Fate::default()
        };
        let steps = [WaterfallStep {
            name: "half & half",
            forward,
            backward: None,
        }];
        let show = WaterfallShow {
            title: "t",
            captions: &[],
            whole: 100,
            steps: &steps,
            ends: forward,
        };
        let drawing = waterfall(&show);
        let picture = raster(&drawing, 1);
        let count = |y: u32, ink: Ink| {
            let row = (0..picture.width()).map(|x| *picture.get_pixel(x, y));
            row.filter(|pixel| *pixel == ink).count() as f64
        };
        let y = (MARGIN + 4.0 * f64::from(LINE) + GAP / 4.0 + BAR / 2.0) as u32;
        // 100 % is 1/1.04 of the plot.
        let half = PACKETS / 1.04 / 2.0;
        // The plot beside has a share of its own: 50 of 75 that changed.
        let beside = CHANGES / 1.04;
        assert!((count(y, ink::MATCHED) - half).abs() < 2.0);
        assert!((count(y, ink::MISSING) - half - beside * 2.0 / 3.0).abs() < 3.0);
        assert!((count(y, ink::EXTRA) - beside / 3.0).abs() < 3.0);
        let below = y + (BAR + 2.0) as u32;
        assert_eq!(count(below, ink::MISSING), 0.0);
        assert!((count(below, ink::EXTRA) - half / 2.0).abs() < 2.0);
        let texts: Vec<_> = drawing.texts().collect();
        assert!(texts.contains(&"no sensor") && texts.contains(&"75.00 %"));
        assert!(texts.contains(&"leaves 75.0 %"));
        assert!(svg(&drawing).contains("half &amp; half"));
    }
}
