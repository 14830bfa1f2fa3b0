//! A waterfall over frame rate: what is kept at each rate, and what each cause takes.

use super::{
    chart::{
        Anchor, Area, Drawing,
        axes::{Axis, Scale, axes},
    },
    ink::{self, Ink},
    text::{LINE, Weight},
};
use crate::{elementary, order::Order, unit::fixed};

/// What a waterfall over frame rate is shown by. Shares are parts of 1, one for each rate.
#[derive(Clone, Debug)]
pub struct RatesShow<'a> {
    /// The line on top.
    pub title: &'a str,
    /// Lines below it.
    pub captions: &'a [String],
    /// Frames a second, ascending.
    pub rates: &'a [f64],
    /// What is kept.
    pub kept: RatesCause<'a>,
    /// What takes the rest, in order.
    pub causes: &'a [RatesCause<'a>],
    /// Lines below all.
    pub notes: &'a [String],
}

/// One cause.
#[derive(Clone, Debug)]
pub struct RatesCause<'a> {
    /// What it is called.
    pub name: &'a str,
    /// Its colour.
    pub ink: Ink,
    /// What it takes at each rate, and from where to where that lies for most chips; none where
    /// nothing can be said.
    pub shares: Vec<Option<(f64, [f64; 2])>>,
}

impl RatesCause<'_> {
    /// The most that it ever takes.
    fn most(&self) -> f64 {
        let known = self.shares.iter().flatten();
        known.map(|(share, _)| *share).fold(0.0, f64::max)
    }

    /// All shares and the ends of their spreads.
    fn numbers(&self) -> impl Iterator<Item = f64> {
        let known = self.shares.iter().flatten();
        known.flat_map(|(share, [from, to])| [*share, *from, *to])
    }

    /// Whether it changes as much as is written.
    fn is_seen(&self) -> bool {
        self.numbers().map(f64::abs).fold(0.0, f64::max) >= 0.0005
    }
}

const MARGIN: f64 = 24.0;
/// Room for the numbers of a vertical axis.
const NUMBERS: f64 = 44.0;
const PLOT: f64 = 400.0;
const HEIGHT: f64 = 320.0;
const GAP: f64 = 40.0;
/// Room for names beside the lines, and in the table.
const NAMES: f64 = 200.0;
/// Room for a rate in the table.
const COLUMN: f64 = 176.0;
/// Width of a bar, at most.
const BAR: f64 = 56.0;
/// Rates whose places are closer than this are put at equal distances.
const APART: f64 = 44.0;
const SWATCH: f64 = 12.0;
/// Causes whose spread is drawn.
const BIGGEST: usize = 4;

/// At the left a bar for each rate, what is kept at its bottom; at the right the biggest causes
/// with their spread; below all numbers.
#[must_use]
pub fn rates(show: &RatesShow<'_>) -> Drawing {
    let line = f64::from(LINE);
    let seen: Vec<&RatesCause<'_>> = show.causes.iter().filter(|c| c.is_seen()).collect();
    let bars = Area {
        x: MARGIN + NUMBERS,
        y: MARGIN + (show.captions.len() + 3) as f64 * line,
        width: PLOT,
        height: HEIGHT,
    };
    let lines = Area {
        x: bars.right() + GAP + NUMBERS,
        ..bars
    };
    let table = bars.bottom() + 3.5 * line;
    let width = (lines.right() + NAMES + MARGIN)
        .max(2.0 * MARGIN + NAMES + COLUMN * show.rates.len() as f64);
    let rows = (seen.len() + 2) as f64;
    let notes = show.notes.len() as f64 + if show.notes.is_empty() { 0.0 } else { 0.5 };
    let mut page = Drawing::new(width, table + (rows + notes) * line + MARGIN);
    let heading = (MARGIN, MARGIN);
    page.text(
        heading,
        Anchor::Start,
        Weight::Heading,
        ink::TEXT,
        show.title,
    );
    let mut y = MARGIN;
    for caption in show.captions {
        y += line;
        let at = (MARGIN, y);
        page.text(at, Anchor::Start, Weight::Plain, ink::CAPTION, caption);
    }
    stacked(&mut page, bars, show, &seen);
    spreads(&mut page, lines, show, &seen);
    let end = numbers(&mut page, table, show, &seen);
    for (i, note) in show.notes.iter().enumerate() {
        let at = (MARGIN, end + (i as f64 + 0.5) * line);
        page.text(at, Anchor::Start, Weight::Plain, ink::TEXT, note);
    }
    page.fitted(MARGIN)
}

/// Where the rates lie: by their logarithm, or at equal distances where they would touch.
fn places(rates: &[f64], area: Area) -> Vec<f64> {
    let (from, to) = (area.x + APART, area.right() - APART);
    let [Some(first), Some(last)] = [rates.first(), rates.last()] else {
        return Vec::new();
    };
    if first >= last {
        return vec![f64::midpoint(from, to); rates.len()];
    }
    let part = |rate: f64| elementary::ln(rate / first) / elementary::ln(last / first);
    let at: Vec<f64> = { rates.iter() }
        .map(|rate| from + (to - from) * part(*rate))
        .collect();
    if at.windows(2).all(|two| two[1] - two[0] >= APART) {
        return at;
    }
    let each = (to - from) / (rates.len() - 1) as f64;
    (0..rates.len()).map(|i| from + i as f64 * each).collect()
}

/// A share in per cent, and from where to where most chips lie, where they differ by as much as
/// is written: `20.0 (15.0 to 25.0)`; a dash where nothing can be said.
#[must_use]
pub fn share_text(share: Option<(f64, [f64; 2])>) -> String {
    let Some((share, [low, high])) = share else {
        return "-".to_owned();
    };
    let percent = |share: f64| fixed(100.0 * share, 1);
    if 100.0 * (high - low) < 0.05 {
        percent(share)
    } else {
        format!("{} ({} to {})", percent(share), percent(low), percent(high))
    }
}

/// Frames a second in a few characters.
fn rate(fps: f64) -> String {
    let text = format!("{fps:.1}");
    text.trim_end_matches(".0").to_owned()
}

/// Axes with a tick for each rate.
fn grid(page: &mut Drawing, area: Area, rates: &[f64], y: Axis<'_>) {
    let x = Axis {
        label: "frames/s",
        from: 0.0,
        to: 0.0,
        scale: Scale::Plain,
    };
    axes(page, area, x, y);
    for (fps, x) in rates.iter().zip(places(rates, area)) {
        page.line(
            (x, area.bottom()),
            (x, area.bottom() + 5.0),
            1.0,
            ink::CAPTION,
        );
        let at = (x, area.bottom() + 6.0);
        page.text(at, Anchor::Middle, Weight::Plain, ink::CAPTION, rate(*fps));
    }
}

/// A bar for each rate. What makes up for other causes has no place in a bar.
fn stacked(page: &mut Drawing, area: Area, show: &RatesShow<'_>, seen: &[&RatesCause<'_>]) {
    let all = || std::iter::once(&show.kept).chain(seen.iter().copied());
    let share = |cause: &RatesCause<'_>, i: usize| {
        let known = cause.shares.get(i).copied().flatten();
        known.map_or(0.0, |(share, _)| share.max(0.0))
    };
    let sums = (0..show.rates.len()).map(|i| all().map(|cause| share(cause, i)).sum::<f64>());
    let axis = Axis {
        label: "% of what there is to keep",
        from: 0.0,
        to: 100.0 * sums.fold(1.0, f64::max),
        scale: Scale::Plain,
    };
    grid(page, area, show.rates, axis);
    let at = places(show.rates, area);
    let near = at.windows(2).map(|two| two[1] - two[0]);
    let width = near.fold(BAR / 0.8, f64::min) * 0.8;
    // The ends of each cause in the bar before, for the lines between the bars.
    let mut before: Option<(f64, Vec<f64>)> = None;
    for (i, x) in at.iter().enumerate() {
        if show.kept.shares.get(i).is_none_or(Option::is_none) {
            before = None;
            continue;
        }
        let (left, mut bottom) = (x - width / 2.0, area.bottom());
        let mut ends = Vec::new();
        for cause in all() {
            let height = share(cause, i) * 100.0 / axis.to * area.height;
            let bar = Area {
                x: left,
                y: bottom - height,
                width,
                height,
            };
            page.fill(bar, cause.ink);
            bottom -= height;
            ends.push(bottom);
        }
        if let Some((right, tops)) = &before {
            for (from, to) in tops.iter().zip(&ends) {
                page.line((*right, *from), (left, *to), 1.0, ink::MATCHED);
            }
        }
        before = Some((left + width, ends));
    }
}

/// What the biggest causes take, with bars from where to where most chips lie.
fn spreads(page: &mut Drawing, area: Area, show: &RatesShow<'_>, seen: &[&RatesCause<'_>]) {
    let mut biggest = seen.to_vec();
    biggest.order_by(|a, b| b.most().total_cmp(&a.most()));
    biggest.truncate(BIGGEST);
    let all = || biggest.iter().flat_map(|cause| cause.numbers());
    let low = all().fold(0.0, f64::min);
    let high = all().fold(0.01, f64::max);
    let axis = Axis {
        label: "% that the biggest causes take, and where 80 % of further chips lie",
        from: 100.0 * low,
        to: 100.0 * (high + 0.04 * (high - low)),
        scale: Scale::Plain,
    };
    grid(page, area, show.rates, axis);
    let y = |share: f64| area.bottom() - axis.part(100.0 * share) * area.height;
    let at = places(show.rates, area);
    let mut names = Vec::new();
    for (k, cause) in biggest.iter().enumerate() {
        let beside = 6.0 * (k as f64 - (biggest.len() - 1) as f64 / 2.0);
        let dots: Vec<Option<(f64, f64)>> = { at.iter().zip(&cause.shares) }
            .map(|(x, known)| Some((x + beside, y((*known)?.0))))
            .collect();
        for two in dots.windows(2) {
            if let [Some(from), Some(to)] = two {
                page.line(*from, *to, 2.0, cause.ink);
            }
        }
        let spreads = cause.shares.iter().flatten().map(|(_, spread)| *spread);
        for ((x, middle), [from, to]) in dots.iter().flatten().zip(spreads) {
            page.line((*x, y(from)), (*x, y(to)), 3.0, cause.ink);
            let dot = Area {
                x: x - 3.5,
                y: middle - 3.5,
                width: 7.0,
                height: 7.0,
            };
            page.fill(dot, cause.ink);
        }
        if let Some((_, last)) = dots.iter().flatten().last() {
            names.push((*last, cause));
        }
    }
    let line = f64::from(LINE);
    names.order_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut free = area.y - line;
    for (i, (at, cause)) in names.iter().enumerate() {
        // Room for those that are still to come.
        let most = area.bottom() + line / 2.0 - (names.len() - i) as f64 * line;
        let top = (at - line / 2.0).min(most).max(free);
        free = top + line;
        let swatch = Area {
            x: area.right() + 6.0,
            y: top + 4.0,
            width: SWATCH,
            height: SWATCH,
        };
        page.fill(swatch, cause.ink);
        let at = (area.right() + 6.0 + SWATCH + 5.0, top);
        page.text(at, Anchor::Start, Weight::Plain, ink::TEXT, cause.name);
    }
}

/// The legend, with all numbers; where it ends.
fn numbers(page: &mut Drawing, top: f64, show: &RatesShow<'_>, seen: &[&RatesCause<'_>]) -> f64 {
    let line = f64::from(LINE);
    let column = |i: usize| MARGIN + NAMES + i as f64 * COLUMN;
    let head = (MARGIN, top);
    page.text(head, Anchor::Start, Weight::Plain, ink::CAPTION, "%");
    for (i, fps) in show.rates.iter().enumerate() {
        let text = format!("{} frames/s", rate(*fps));
        let at = (column(i), top);
        page.text(at, Anchor::Start, Weight::Plain, ink::CAPTION, text);
    }
    // As in the bars, what is kept at the bottom.
    let rows = seen.iter().rev().copied().chain([&show.kept]);
    let mut y = top;
    for cause in rows {
        y += line;
        let swatch = Area {
            x: MARGIN,
            y: y + 4.0,
            width: SWATCH,
            height: SWATCH,
        };
        page.fill(swatch, cause.ink);
        let at = (MARGIN + SWATCH + 6.0, y);
        page.text(at, Anchor::Start, Weight::Plain, ink::TEXT, cause.name);
        for (i, share) in cause.shares.iter().enumerate() {
            let text = share_text(*share);
            let at = (column(i), y);
            page.text(at, Anchor::Start, Weight::Plain, ink::TEXT, text);
        }
    }
    y + line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{raster, svg};

    fn cause(name: &'static str, ink: Ink, shares: &[f64]) -> RatesCause<'static> {
        RatesCause {
            name,
            ink,
            shares: { shares.iter() }
                .map(|s| Some((*s, [s - 0.05, s + 0.05])))
                .collect(),
        }
    }

    fn drawn(rates: &[f64], causes: &[RatesCause<'_>]) -> Drawing {
        super::rates(&RatesShow {
            title: "light & dark",
            captions: &["a caption".to_owned()],
            rates,
            kept: cause("kept", ink::MATCHED, &vec![0.5; rates.len()]),
            causes,
            notes: &["a note".to_owned()],
        })
    }

    #[test]
    fn bars_are_as_high_as_their_shares() {
        let causes = [
            cause("one", ink::CAUSES[0], &[0.3, 0.1]),
            cause("other", ink::CAUSES[1], &[0.2, 0.4]),
        ];
        let drawing = drawn(&[10.0, 130.0], &causes);
        let picture = raster(&drawing, 1);
        let area = Area {
            x: MARGIN + NUMBERS,
            y: MARGIN + 4.0 * f64::from(LINE),
            width: PLOT,
            height: HEIGHT,
        };
        let at = places(&[10.0, 130.0], area);
        for (i, shares) in [[0.5, 0.3, 0.2], [0.5, 0.1, 0.4]].into_iter().enumerate() {
            let column = at[i] as u32;
            let inks = [ink::MATCHED, ink::CAUSES[0], ink::CAUSES[1]];
            for (share, ink) in shares.into_iter().zip(inks) {
                let count = (area.y as u32..area.bottom() as u32)
                    .filter(|y| *picture.get_pixel(column, *y) == ink)
                    .count() as f64;
                assert!((count - share * HEIGHT).abs() < 2.5, "{count} of {share}");
            }
        }
        let svg = svg(&drawing);
        for text in [
            "light &amp; dark",
            "one",
            "20.0 (15.0 to 25.0)",
            "130 frames/s",
            "a note",
        ] {
            assert!(svg.contains(text), "no {text}");
        }
    }

    /// Rates that are close, one alone, and causes that bring something back.
    #[test]
    fn nothing_lies_over_anything_else() {
        let area = Area {
            x: 0.0,
            y: 0.0,
            width: PLOT,
            height: HEIGHT,
        };
        for rates in [
            &[10.0, 11.0, 130.0][..],
            &[10.0, 20.0, 60.0, 130.0],
            &[240.0],
        ] {
            let at = places(rates, area);
            assert!(at.windows(2).all(|two| two[1] - two[0] >= APART), "{at:?}");
            assert!(
                at.iter()
                    .all(|x| *x >= APART / 2.0 && *x <= PLOT - APART / 2.0)
            );
            let same: Vec<_> = (0..4)
                .map(|i| cause("a cause", ink::CAUSES[i], &vec![0.125; rates.len()]))
                .collect();
            let _ = raster(&drawn(rates, &same), 1);
        }
        let back = [cause("back", ink::CAUSES[2], &[-0.2, 0.0])];
        let texts = drawn(&[10.0, 130.0], &back);
        assert!(texts.texts().any(|text| text == "-20.0 (-25.0 to -15.0)"));
    }
}
