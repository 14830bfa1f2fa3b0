//! What came of it, for machines and for people.

use std::fmt::Write as _;

use serde_json::json;

use super::{Added, Aim, Asked, Compiled, MIDDLE, bounds::Bounds, readout::Readouts};
use crate::{
    cli::output::readout_table::between,
    compile::{
        BitMemory, Decided, DriveMemory, Filter, Need, Restless, bound::LowerBound, brightest,
        carried, four_digits, largest_of_both_signs, like_these,
    },
    isa::{Analog, Device, Errors, Evidence, Figure, PrimitiveKind},
    plane::Plane,
    program::{Cost, HostCalls, for_each},
    study::feasibility::{Estimate, power::words_energy, time},
    unit::{Lsb, counted},
};

impl Compiled {
    pub(super) fn statements(&self) -> u64 {
        let mut count = 0;
        for_each(&self.expansion.frame, &mut |_| count += 1);
        count
    }

    pub(super) fn registers(&self) -> Vec<Analog> {
        let mut all: Vec<Analog> = self.filter.live.iter().flatten().copied().collect();
        all.extend(&self.results_in);
        all.sort_unstable();
        all.dedup();
        all
    }

    pub(super) fn json(&self, asked: &Asked, device: &Device, seconds: f64) -> serde_json::Value {
        let frame = &self.expansion.code.frame;
        let cost = Cost::of(frame, device);
        let host = HostCalls::between(&HostCalls::of(frame, device), device);
        let rows = |plane: &Plane<f64>| -> Vec<Vec<f64>> {
            plane.rows().into_iter().map(|row| row.to_vec()).collect()
        };
        let stack: Vec<_> = self.kernels.iter().map(rows).collect();
        let kernel = match &stack[..] {
            [one] if !asked.stacked => json!(one),
            all => json!(all),
        };
        let names = |all: &[Analog]| -> Vec<String> {
            all.iter().map(|r| device.analog_name(*r)).collect()
        };
        let results = self.results.iter().map(|i| json!([i.low, i.high]));
        let exact_within: Vec<f64> = self.filters.iter().map(|f| f.exact_within).collect();
        let bounds = self.bounds(asked, device);
        let decided: Vec<Option<Decided>> = self.filters.iter().map(kept).collect();
        let on_chip = { self.thresholds.iter() }.map(|lsb| held(*lsb, device));
        let on_chip: Vec<[f64; 2]> = on_chip.collect();
        let energy = self.energy(device);
        let mut said = json!({
            "chip": device.name(),
            "words": cost.words.0,
            "macros": self.statements(),
            "registers": names(&self.registers()),
            "into": names(&self.results_in),
            "kernel": kernel,
            "scale": self.scales.first(),
            "scales": self.scales,
            "quantised_scales": asked.scales,
            "warnings": asked.warnings,
            "prescale_bits": self.filter.prescale,
            "bounds": bounds.as_ref().ok().map(Bounds::json),
            "filter_words": self.filter.word_count(device),
            "snake_words": self.snake,
            "border": self.wrong_within(device) == 0,
            "wrong_from_border_px": (!self.wrong_spreads(device)).then(|| self.wrong_within(device)),
            "array_us": cost.array_us,
            "array_us_range": self.array(device).map(|it| it.ends()),
            "host_us": cost.host_us,
            "host_us_range": host.0,
            "readout": self.readouts.as_ref().map(Readouts::json),
            "results_lsb": results.collect::<Vec<_>>(),
            "thresholds_lsb": self.thresholds,
            "thresholds_on_chip_lsb": on_chip,
            "notes": self.notes(asked, device),
            "saturating_stores": self.saturations,
            "holds_with_transfer_errors": self.ranged.then_some(self.filter.holds),
            "largest_input_lsb": self.largest_input(device),
            "offset_stores": self.filter.offsets,
            "noise_lsb": self.noises,
            "on_chip": self.on_chip,
            "exact_within_lsb": exact_within,
            "decided": self.is_captured(device).then_some(decided),
            "energy_uj": energy.low,
            "energy_uj_range": energy.ends(),
            "evidence": {
                "array_us": self.array(device).map(|it| it.evidence),
                "host_us": host.1,
                "energy_uj": energy.evidence,
                "on_chip": Errors::evidence_with_range(device),
            },
            "states": self.filter.states,
            "seconds": seconds,
            "memory": self.memory.map(|memory| self.remembered(memory, device)),
            "carried": self.memory.map(|memory| self.carried(memory, device)),
            "text": self.text,
        });
        // The macro takes no more keys.
        said["no_bounds"] = json!(bounds.err());
        said
    }

    /// What to know of each kind: what the table says on its way, and what is warned of.
    fn notes(&self, asked: &Asked, device: &Device) -> Vec<String> {
        let units = self.scales.iter().zip(&asked.scales);
        let kinds = self.thresholds.iter().zip(units).enumerate();
        let of_kind = |(kind, (lsb, (own, few))): (usize, (&[f64; 2], (&f64, &f64)))| {
            let fires = any_fires(*lsb, few / own, device);
            let notes = [fires, self.chatters(kind, (*own, *few), device)];
            { notes.into_iter().flatten() }
                .map(|note| format!("threshold of kind {kind}: {note}"))
                .collect::<Vec<_>>()
        };
        let cut_off = { self.memory.is_some() }.then(|| capture_cut_off(device));
        { kinds.flat_map(of_kind) }
            .chain(cut_off.flatten())
            .collect()
    }

    /// Warns of memories in bits with which cells fire again and again on the chip.
    pub(super) fn restless(&self, asked: &Asked, device: &Device) -> Vec<String> {
        let units = self.scales.iter().zip(&asked.scales).enumerate();
        let note = |(kind, (own, few)): (usize, (&f64, &f64))| {
            let note = self.chatters(kind, (*own, *few), device)?;
            Some(format!("warning: threshold of kind {kind}: {note}\n"))
        };
        units.filter_map(note).collect()
    }

    /// That a cell fires again and again on the chip whose drive stays between two levels, or beyond
    /// the last, of its memory in bits; its scale, and what few values took from its kernel.
    fn chatters(&self, kind: usize, (own, few): (f64, f64), device: &Device) -> Option<String> {
        let BitMemory { step, restless, .. } = self.in_bits.get(kind)?;
        let Restless {
            firing,
            least,
            bits,
        } = (*restless)?;
        let thresholds = *self.thresholds.get(kind)?;
        let [on, off] = held(thresholds, device);
        let kinds = self.kernels.len();
        let bits = bits.filter(|it| Need::new(DriveMemory::Bits(*it), kinds, device).fits(device));
        let errors = Errors::from_device(device);
        // Where both signs have one threshold, what the converter makes of it is what counts.
        let is_one = thresholds[0] == thresholds[1];
        let from = |least: f64| {
            four_digits(least * few / own, |it| {
                let lsb = it / few * own;
                lsb >= least || is_one && errors.held(lsb) >= errors.held(least)
            })
        };
        let ways = [
            bits.map(|bits| format!("use --memory bits:{bits}")),
            least.map(|least| format!("use thresholds from {} on", from(least))),
        ];
        let ways: Vec<String> = ways.into_iter().flatten().collect();
        let ways = match &ways[..] {
            [] => "use another memory (--memory analogue or shared)".to_owned(),
            ways => ways.join(", or "),
        };
        Some(format!(
            "half a step of its memory is {:.2} LSB, its threshold on the chip {} LSB, and recall has errors: a cell between two levels, or beyond the last, fires again and again, about {:.1} % of the cells in each frame of a still picture (predicted); {ways}",
            step / 2.0,
            on.min(off),
            100.0 * firing,
        ))
    }

    /// What the chip makes of the thresholds of each kind.
    fn threshold_lines(&self, asked: &Asked, device: &Device) -> Vec<String> {
        let units = self.scales.iter().zip(&asked.scales);
        let kinds = self.thresholds.iter().zip(units);
        kinds
            .map(|(lsb, (own, few))| threshold(*lsb, few / own, device))
            .collect()
    }

    /// Whether registers hold what the program takes of the photodiode, so that its events are as
    /// predicted.
    fn is_captured(&self, device: &Device) -> bool {
        self.memory.is_none() || capture_cut_off(device).is_none()
    }

    /// Words that the program takes of the chip's store.
    fn stored(&self, device: &Device) -> u64 {
        self.expansion.stored(device).0
    }

    /// Kinds like these that the chip carries.
    fn carried(&self, memory: DriveMemory, device: &Device) -> usize {
        carried(memory, device, (self.kernels.len(), self.stored(device)))
    }

    /// What the program remembers, and what that takes of the registers.
    fn remembered(&self, memory: DriveMemory, device: &Device) -> String {
        let kinds = self.kernels.len();
        let what = match memory {
            DriveMemory::Analogue => "the drive of each kind in an analogue register".to_owned(),
            DriveMemory::Shared => {
                "the pixel at the last event of any kind, in one register for all".to_owned()
            }
            DriveMemory::Bits(bits) => {
                format!("the drive of each kind in {}", counted(bits, "bit"))
            }
        };
        let needed = Need::new(memory, kinds, device).analogue;
        format!(
            "{what}: {needed} of {} analogue registers at least; the chip carries {}",
            Need::free(device),
            like_these(self.carried(memory, device), "these")
        )
    }

    /// What the words of a frame take; none where no other launch can be asked about.
    fn array(&self, device: &Device) -> Option<Estimate> {
        time::of_array(&self.expansion.code.frame, device).ok()
    }

    /// Between which numbers the fewest words lie; or why nobody says so.
    fn bounds(&self, asked: &Asked, device: &Device) -> Result<Bounds, &'static str> {
        if self.filters.len() > 1 {
            return Err("each kind has a filter of its own, and bounds are of one filter");
        }
        let halvings = self.filter.prescale;
        Ok(Bounds {
            lower: LowerBound::on(&asked.kernels, halvings, device),
            stores: self.filter.words.len(),
            each: device.row(PrimitiveKind::Bus).words(),
            kernels: asked.kernels.len(),
            halvings,
            searched: asked.objective == Aim::Words,
        })
    }

    fn bound_line(&self, asked: &Asked, device: &Device) -> String {
        let bounds = self.bounds(asked, device);
        bounds.map_or_else(|why| format!("none: {why}"), |bounds| bounds.words())
    }

    /// What the words of a frame take.
    fn energy(&self, device: &Device) -> Estimate {
        words_energy(&self.expansion.code.frame, device)
    }

    fn energy_line(&self, device: &Device) -> String {
        let energy = self.energy(device);
        format!(
            "{} uJ a frame for its words, each at full power over the highest clock ({}); the power of the idle array and of the readout is not public",
            between(energy.ends(), 2),
            energy.evidence.word()
        )
    }

    /// What a frame takes on the array and on the host.
    fn time_line(&self, cost: &Cost, device: &Device) -> String {
        let host = { self.readouts.as_ref() }.map_or_else(
            || {
                let array = self.array(device);
                let array = array.map_or([cost.array_us; 2], |time| time.ends());
                let rates = [1, 0].map(|end| 1e6 / (array[end] + cost.host_us));
                format!(
                    "{:.1} us on the host, without a readout: {} frames/s",
                    cost.host_us,
                    between(rates, 0)
                )
            },
            Readouts::time,
        );
        match self.array(device).filter(|time| time.high > 0.0) {
            Some(time) => format!(
                "{} us on the array (highest clock, to a launch with every word: {}), {host}, of compute alone {:.0} at most",
                between(time.ends(), 1),
                time.evidence.word(),
                1e6 / time.low
            ),
            None => "none: the result is the input".to_owned(),
        }
    }

    /// The table for people.
    pub(super) fn account(&self, asked: &Asked, device: &Device, seconds: f64) -> String {
        let cost = Cost::of(&self.expansion.code.frame, device);
        let mut text = String::new();
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "{name:<10}{what}");
        };
        line(
            "words",
            format!(
                "{} (the filter {}, a naive snake {})",
                cost.words.0,
                self.filter.word_count(device),
                self.snake
            ),
        );
        line("bound", self.bound_line(asked, device));
        let room = device.value(Figure::Store);
        line(
            "store",
            format!("{} of {room}", counted(self.stored(device), "word")),
        );
        if let Some(memory) = self.memory {
            line("memory", self.remembered(memory, device));
        }
        line("time", self.time_line(&cost, device));
        line(
            "proof",
            "the program was read back: it computes the kernel exactly".to_owned(),
        );
        for (register, result) in self.results_in.iter().zip(&self.results) {
            line(
                "result",
                format!(
                    "{} from {} to {} LSB{}",
                    device.analog_name(*register),
                    Lsb(result.low).rounded(),
                    Lsb(result.high).rounded(),
                    self.over()
                ),
            );
        }
        for thresholds in self.threshold_lines(asked, device) {
            line("threshold", thresholds);
        }
        line("range", self.range(device));
        let offsets = self.filter.offsets.iter().map(|o| format!("{o}"));
        line(
            "offset",
            format!(
                "{} transfer errors of one store stay in the result",
                offsets.collect::<Vec<_>>().join(", ")
            ),
        );
        for on_chip in &self.on_chip {
            line("chip", on_chip.line(device));
        }
        if let Some(decided) = self.decided(device) {
            line("events", decided);
        }
        for added in &self.noises {
            line("noise", noise(added, device));
        }
        line("energy", self.energy_line(device));
        line("border", self.border(device));
        line(
            "search",
            format!("{} states in {seconds:.1} s", self.filter.states),
        );
        if let Some(readouts) = &self.readouts {
            text.push('\n');
            text.push_str(&readouts.table());
        }
        text.push_str("\nregisters live over the filter's words\n");
        text.push_str(&self.chart(device));
        text
    }

    /// How many pixels in from the border the results may be wrong: where registers beyond it hold
    /// no 0, as far as a result looks.
    fn wrong_within(&self, device: &Device) -> usize {
        let own = { self.filters.iter() }.map(|filter| filter.wrong_from_border(device));
        own.max().unwrap_or(0)
    }

    /// Whether what is wrong at the border goes further in with each frame: a wrong event renews the
    /// memory of its pixel, which the filters of its neighbours read.
    fn wrong_spreads(&self, device: &Device) -> bool {
        self.memory == Some(DriveMemory::Shared) && self.wrong_within(device) > 0
    }

    /// Whether the results are right at the border, and what follows where they are not.
    fn border(&self, device: &Device) -> String {
        let edge = device.value(Figure::Edge);
        let spreads = self.wrong_spreads(device);
        let far = match self.wrong_within(device) {
            0 => return "right up to the border, zeros beyond it".to_owned(),
            far if spreads => format!(
                "from it inwards, by up to {} further with each frame (the kinds share a memory of the pixel)",
                counted(far, "pixel")
            ),
            1 if edge == 0.0 => "in the outermost rows and columns".to_owned(),
            far => format!("within {} of it", counted(far, "pixel")),
        };
        if edge != 0.0 {
            return format!(
                "not right at the border, {far}: beyond it registers of {} hold {edge} LSB (edge.analogue), but the kernel assumes zeros; exec --edge 0 runs it without",
                device.name()
            );
        }
        if self.memory.is_some() {
            format!(
                "not right at the border: {far} events differ from the float model's, in exact arithmetic too; search longer (--effort), or use a chip with more registers; --border insists on a program that is right there"
            )
        } else {
            let way = if self.to_border {
                "no plan was found that is: search longer (--effort)"
            } else {
                "--border asks for it"
            };
            format!("not right at the border, {far} ({way})")
        }
    }

    /// Whether anything saturates, and what that costs.
    pub(super) fn range(&self, device: &Device) -> String {
        if self.memory.is_some()
            && let Some(cut_off) = capture_cut_off(device)
        {
            return format!("every capture saturates: {cut_off}");
        }
        let saturates = |filter: &Filter| filter.decided.is_some() && !filter.holds;
        if self.filters.iter().any(saturates) {
            return self.exact_range();
        }
        let range = match (self.saturations, self.filter.prescale) {
            (0, 0) => "nothing saturates".to_owned(),
            (0, bits) if self.filters.len() == 1 => format!(
                "nothing saturates; the input is halved {} on the way, which costs {}",
                counted(bits, "time"),
                counted(bits, "bit")
            ),
            (0, _) => {
                format!(
                    "nothing saturates; the difference is halved {} on the way, which costs as many bits",
                    self.halvings()
                )
            }
            (n, _) if self.memory.is_some() => format!(
                "{} can saturate: search longer (--effort), or use fewer digits (--to)",
                counted(n, "store"),
            ),
            (n, bits) => {
                let on_the_way = match bits {
                    0 => String::new(),
                    bits => format!(
                        "the input is halved {} on the way, since the chip's errors are too large otherwise; ",
                        counted(bits, "time")
                    ),
                };
                format!(
                    "{on_the_way}{} can saturate; with inputs within ±{:.2} LSB none does (--input halves them)",
                    counted(n, "store"),
                    self.largest_input(device)
                )
            }
        };
        // Of SCAMP-5, the brightest of 8 bits is half an LSB beyond the register's end.
        let range = match range.strip_prefix("nothing saturates") {
            Some(rest) if self.memory.is_some() => {
                format!(
                    "nothing saturates for light up to {} of 255, but the difference from the memory may{rest}",
                    brightest(device)
                )
            }
            _ => range,
        };
        let errors = if self.filter.holds || !self.ranged {
            ""
        } else {
            "; but the transfer errors of a real chip come on top, and no plan was found that keeps them in range: search longer (--effort), or use fewer digits (--to)"
        };
        range + errors
    }

    /// What the result of a filter alone is of its kernel's, where that is halved on the way.
    fn over(&self) -> String {
        match (self.memory, self.filter.prescale) {
            (Some(_), _) | (None, 0) => String::new(),
            (None, bits) => format!(", the kernel's result over {}", 1u64 << bits),
        }
    }

    /// The largest input, of either sign, with which no store of the filter saturates, LSB.
    fn largest_input(&self, device: &Device) -> f64 {
        largest_of_both_signs(device) / self.filter.peak
    }

    /// The range within which each filter is exact, where large differences may saturate.
    fn exact_range(&self) -> String {
        let (what, store, where_) = match self.memory {
            // A difference that saturates decides as it should.
            Some(DriveMemory::Shared) => (
                "each difference",
                "no store of a filter but its result",
                "changes of a pixel",
            ),
            _ => ("the light", "no store of a filter", "light"),
        };
        let within = match &self.filters[..] {
            filters if filters.iter().all(|filter| filter.exact_within < 1.0) => {
                format!("a sum may saturate for any {where_}")
            }
            _ => format!(
                "{store} saturates for {where_} of at most {} LSB, above that a sum may",
                self.each(|filter| format!("{:.0}", filter.exact_within.floor()))
            ),
        };
        format!(
            "{what} is halved {} on the way, for the most events on the chip; {within}, and then decisions in exact arithmetic differ from the kernel's (--objective exact halves until none does)",
            self.halvings()
        )
    }

    /// How often each filter halves, in words.
    fn halvings(&self) -> String {
        match &self.filters[..] {
            [one] => counted(one.prescale, "time"),
            _ => format!("{} times", self.each(|filter| filter.prescale.to_string())),
        }
    }

    /// How well each filter decides.
    fn decided(&self, device: &Device) -> Option<String> {
        if !self.is_captured(device) {
            return Some("not predicted: the light itself is clipped (range)".to_owned());
        }
        let f1 = |of: fn(Decided) -> f64| {
            self.each(|filter| kept(filter).map_or("-".to_owned(), |it| format!("{:.2}", of(it))))
        };
        self.filters.iter().any(|filter| filter.decided.is_some()).then(|| {
            format!(
                "F1 {} on the chip, {} in exact arithmetic, against the kernel in its levels (predicted on moving light)",
                f1(|it| it.silicon),
                f1(|it| it.exact),
            )
        })
    }

    /// Something of each filter, with commas between.
    fn each(&self, what: impl Fn(&Filter) -> String) -> String {
        self.filters.iter().map(what).collect::<Vec<_>>().join(", ")
    }

    /// A row for each register, a column for each word.
    pub(super) fn chart(&self, device: &Device) -> String {
        let mut text = String::new();
        for (start, part) in self.filter.live.chunks(64).enumerate() {
            if start > 0 {
                text.push('\n');
            }
            for register in self.registers() {
                let marks: String = part
                    .iter()
                    .map(|live| if live.contains(&register) { '#' } else { '.' })
                    .collect();
                let _ = writeln!(text, "  {:<4} {marks}", device.analog_name(register));
            }
        }
        text
    }
}

/// How well a filter decides; none where that is not looked at, or there is no event to keep.
fn kept(filter: &Filter) -> Option<Decided> {
    filter.decided.filter(Decided::has_events)
}

/// That no register holds the reset level of the photodiode, negated, as a capture stores it.
fn capture_cut_off(device: &Device) -> Option<String> {
    let (_, high) = device.register_range();
    let reset = device.value(Figure::LightReset);
    (-reset > high).then(|| {
        format!(
            "the capture stores the photodiode's reset level (light.reset), {reset} LSB, negated, and a register holds {high} at most; change light.reset or range.high of the chip's data"
        )
    })
}

/// What a filter adds to its result, for people.
fn noise(added: &Added, device: &Device) -> String {
    let input = |lsb: Option<f64>| lsb.map_or("-".to_owned(), |lsb| format!("{lsb:.2}"));
    format!(
        "the filter adds {:.2} LSB from frame to frame and {:.2} LSB from pixel to pixel; as an error of every input: {} and {} LSB ({}; at {MIDDLE} LSB, saturation left out)",
        added.temporal,
        added.fixed,
        input(added.input_temporal),
        input(added.input_fixed),
        Evidence::weakest([Evidence::Modelled, Errors::evidence(device)]).word(),
    )
}

/// The thresholds that the chip's converter sets, LSB.
fn held(thresholds: [f64; 2], device: &Device) -> [f64; 2] {
    let errors = Errors::from_device(device);
    thresholds.map(|lsb| errors.held(lsb))
}

/// What to do about thresholds of which one is 0 on the chip; `unit`: kernel times light for each
/// LSB.
fn any_fires(thresholds: [f64; 2], unit: f64, device: &Device) -> Option<String> {
    let held = held(thresholds, device);
    let lost = (0..2).any(|k| thresholds[k] > 0.0 && held[k] == 0.0);
    lost.then(|| {
        format!(
            "any change fires; use thresholds from {:.1} on, or a kernel that needs fewer halvings (--to)",
            Errors::from_device(device).input_step * unit
        )
    })
}

/// What the chip makes of a kernel's thresholds; `unit`: kernel times light for each LSB.
fn threshold(thresholds: [f64; 2], unit: f64, device: &Device) -> String {
    let both = |[on, off]: [f64; 2], digits: usize| {
        if on == off {
            format!("{on:.digits$}")
        } else {
            format!("{on:.digits$} ON and {off:.digits$} OFF")
        }
    };
    let advice = any_fires(thresholds, unit, device);
    let advice = advice.map_or_else(String::new, |advice| format!(": {advice}"));
    format!(
        "{} LSB of the result, on the chip {}{advice}",
        both(thresholds, 3),
        both(held(thresholds, device), 0),
    )
}
