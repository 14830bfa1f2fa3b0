//! The report as one page: text, tables and pictures in one file.

use amacrine::{
    picture::{Drawing, Line, LinesShow, kernels, lines},
    plane::Plane,
    study::report::image::{drawing, pixels},
    unit::fixed,
};
use image::RgbImage;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{Report, metric::Metric, table::told};
use crate::record::KernelAt;

/// That of the feasibility report.
const STYLE: &str = include_str!("../../../src/study/report/style.css");

/// What a browser may load for it: nothing but what is in it.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

/// The most pictures of a kernel on its way.
const MOMENTS: usize = 7;

impl Report {
    /// Quality over bits: a line an arm, every run a dot.
    #[must_use]
    pub fn drawing(&self, metric: Metric) -> Drawing {
        let label = metric.label();
        let mut show = LinesShow {
            title: &format!("{} over bits", metric.title()),
            captions: &["a line an arm: means over seeds; a dot: one seed".to_owned()],
            across: "bits a pixel and pair of frames",
            up: &label,
            lines: Vec::new(),
            levels: Vec::new(),
        };
        for arm in &self.arms {
            let curve = self.curve(arm, metric);
            let place = |point: &super::Point| [point.bits, point.quality];
            if curve.points.iter().all(|point| point.bits > 0.0) {
                show.lines.push(Line {
                    name: arm.clone(),
                    corners: curve.points.iter().map(place).collect(),
                    dots: curve.runs.iter().map(place).collect(),
                });
            } else if let Some(point) = curve.points.first() {
                show.levels
                    .push((format!("{arm} (no bits)"), point.quality));
            }
        }
        lines(&show)
    }

    /// The kernels of an arm on their way at its middle target and first seed; `None` where they
    /// were not learned.
    #[must_use]
    pub fn way(&self, arm: &str) -> Option<RgbImage> {
        let own: Vec<&KernelAt> = { self.record.kernels.iter() }
            .filter(|one| one.arm == arm)
            .collect();
        let mut targets: Vec<f64> = own.iter().map(|one| one.target).collect();
        targets.sort_by(f64::total_cmp);
        targets.dedup();
        let target = *targets.get(targets.len() / 2)?;
        let seed = own.iter().map(|one| one.seed).min()?;
        let steps: Vec<&KernelAt> = { own.into_iter() }
            .filter(|one| one.target == target && one.seed == seed)
            .collect();
        let last = steps.len() - 1;
        let shown = MOMENTS.min(steps.len());
        let planes: Vec<(String, Plane<f64>)> = (0..shown)
            .map(|n| steps[n * last / (shown - 1).max(1)])
            .filter_map(|one| {
                let kernel = one.kernels.first()?;
                let width = kernel.first()?.len();
                let plane = Plane::from_shape_fn((kernel.len(), width), |(y, x)| kernel[y][x]);
                Some((format!("step {}", one.step), plane))
            })
            .collect();
        let named: Vec<_> = planes
            .iter()
            .map(|(name, plane)| (name.clone(), plane))
            .collect();
        (!named.is_empty()).then(|| kernels(&named))
    }

    /// The page: it needs no other file, no network and no script.
    #[must_use]
    pub fn page(&self) -> String {
        let headline = self.headline();
        let heading = format!("What {} has learned", self.record.task);
        let page = html! {
            (DOCTYPE)
            html lang="en-GB" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="generator" content={ "amacrine-learn " (env!("CARGO_PKG_VERSION")) };
                    title { (heading) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    header {
                        p.kind { "Learning report" }
                        h1 { (heading) }
                        p.lead { (self.summary()) "." }
                    }
                    main {
                        (self.quality_section())
                        (self.difference_section(headline))
                        (self.chip_section(headline))
                        (self.remark_section())
                        (self.kernel_section())
                        @for note in self.notes() { p.verdict { (note) "." } }
                    }
                    footer {
                        p { "Every arm has the same network from the same start, as many steps and the same target of events; bits are those of address events. An interval is the middle 95 % of 1,000 resamplings of photographs and seeds, both with replacement; a difference whose interval, as it is told, contains 0 is not shown, nor is one of a single photograph or a single seed. With few photographs or seeds intervals are too narrow rather than too wide." }
                    }
                }
            }
        };
        page.into_string()
    }

    fn quality_section(&self) -> Markup {
        let metrics = self.metrics();
        html! {
            section {
                h2 { "Quality over bits" }
                @for metric in &metrics {
                    @let alt = format!("{} over bits, a line an arm; the table has the numbers", metric.name());
                    div.wide { (drawing(&self.drawing(*metric), &alt)) }
                }
                div.wide { table {
                    thead { tr {
                        th { "arm" } th.n { "events a pixel and pair" } th.n { "bits" }
                        @for metric in &metrics { th.n { (metric.label()) } }
                    } }
                    tbody { @for arm in &self.arms {
                        @let curves: Vec<_> = metrics.iter().map(|metric| self.curve(arm, *metric)).collect();
                        @for (n, point) in curves.first().map(|curve| curve.points.as_slice()).unwrap_or_default().iter().enumerate() {
                            tr {
                                th { (arm) }
                                td.n { (format!("{:.4}", point.events)) }
                                td.n { (format!("{:.3}", point.bits)) }
                                @for (metric, curve) in metrics.iter().zip(&curves) {
                                    td.n { (curve.points.get(n).map_or(String::new(), |point| fixed(point.quality, metric.digits()))) }
                                }
                            }
                        }
                    } }
                } }
            }
        }
    }

    fn difference_section(&self, metric: Metric) -> Markup {
        let pairs = self.pairs();
        if pairs.is_empty() {
            return html! {};
        }
        let better = if metric.sign() > 0.0 { "more" } else { "less" };
        html! {
            section {
                h2 { "Differences at equal bits" }
                p { "In " (metric.label()) "; " (better) " is better. The mean over the bits that both arms have, straight lines between their targets on log2 of bits." }
                div.wide { table {
                    thead { tr { th { "arms" } th { "difference, and 95 % over photographs and seeds" } } }
                    tbody { @for (a, b, difference) in &pairs {
                        tr { th { (a) " minus " (b) } td { (told(difference.as_ref(), metric)) } }
                    } }
                } }
            }
        }
    }

    fn chip_section(&self, metric: Metric) -> Markup {
        let kept = self.kept();
        if kept.is_empty() {
            return html! {};
        }
        html! {
            section {
                h2 { "On the chip" }
                @for verdict in kept.iter().filter_map(|arm| arm.verdict(metric)) { p.verdict { (verdict) "." } }
                p { "All forms of an arm on the clips that the chip was shown." }
                div.wide { table {
                    thead { tr { th { "arm" } th { "events by" } th { "decoder" } th.n { "bits" } th.n { (metric.label()) } th { "against the float model, at equal bits" } } }
                    tbody { @for arm in &kept { @for stage in &arm.stages { @for (n, point) in stage.curve.points.iter().enumerate() {
                        tr {
                            th { (arm.arm) } td { (stage.form.name()) } td { (stage.decoder.name()) }
                            td.n { (format!("{:.3}", point.bits)) }
                            td.n { (fixed(point.quality, metric.digits())) }
                            td { @if n == 0 && stage.change.is_some() { (told(stage.change.as_ref(), metric)) } }
                        }
                    } } } }
                } }
            }
        }
    }

    fn remark_section(&self) -> Markup {
        let remarks = self.remarks();
        if remarks.is_empty() {
            return html! {};
        }
        html! {
            section {
                h2 { "To be known of arms" }
                @for remark in remarks { p { (remark) "." } }
            }
        }
    }

    fn kernel_section(&self) -> Markup {
        let mut arms: Vec<&str> = Vec::new();
        for one in &self.record.kernels {
            if !arms.contains(&one.arm.as_str()) {
                arms.push(&one.arm);
            }
        }
        let ways: Vec<(&str, RgbImage)> = { arms.into_iter() }
            .filter_map(|arm| Some((arm, self.way(arm)?)))
            .collect();
        if ways.is_empty() {
            return html! {};
        }
        html! {
            section {
                h2 { "Kernels on their way" }
                p { "Blue is positive, vermilion negative; one scale a row. The first seed at the middle target." }
                @for (arm, picture) in &ways {
                    h3 { (arm) }
                    div.wide { (pixels(picture, &format!("the kernel of {arm} after some steps"))) }
                }
                @if let Some(line) = self.surround_line() { p.verdict { (line) "." } }
            }
        }
    }
}
