//! A sensor as the text of a sensor file: what [`Description::parse`] reads back as it was.

use std::{fmt::Write as _, iter};

use crate::{
    config::on_one_line,
    kernel::Kernel,
    reference::{
        noise::Noise,
        surround::{Surround, Surrounds, from_micros},
    },
};

use super::{
    channel::{Channel, Threshold},
    rules::{Border, PolarityRule, Refractory},
    sensor::Description,
};

impl Description {
    /// The text of a sensor file that says all of it: kernels as rows of numbers, no other file
    /// needed. What [`check`](Self::check) takes is read back as it was.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let Self {
            name,
            response,
            memory,
            shared,
            polarity,
            border,
            refractory,
            noise,
            channels,
        } = self;
        let mut text = format!("name = {}\n", on_one_line(name));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "response = {}", response.text());
        let _ = writeln!(text, "memory = \"{}\"", memory.word());
        if *shared {
            text += "shared = true\n";
        }
        if *polarity != PolarityRule::default() {
            let _ = writeln!(text, "polarity = \"{}\"", polarity.word());
        }
        if *border != Border::default() {
            let _ = writeln!(text, "border = \"{}\"", border.word());
        }
        // The rule counts without a period, too.
        if *refractory != memory.unstated_refractory() {
            let Refractory { us, rule } = refractory;
            let rule = rule.word();
            let _ = writeln!(text, "refractory = {{ us = {us:?}, rule = \"{rule}\" }}");
        }
        text += &noisy(noise);
        for channel in channels {
            text += "\n[[channel]]\n";
            text += &channel.to_toml();
        }
        text
    }
}

fn noisy(noise: &Noise) -> String {
    if *noise == Noise::NONE {
        return String::new();
    }
    let numbers = noise.numbers();
    let lines = numbers.map(|(key, value)| format!("{key} = {value:?}\n"));
    let rule = noise.cutoff_rule;
    format!("\n[noise]\n{}cutoff-rule = \"{rule}\"\n", lines.concat())
}

impl Channel {
    fn to_toml(&self) -> String {
        let Self {
            name,
            kernels,
            surrounds,
            thresholds,
            memory_kernel,
            log_temporal,
        } = self;
        let mut text = String::new();
        if let Some(name) = name {
            let _ = writeln!(text, "name = {}", on_one_line(name));
        }
        if kernels.len() > 1 {
            text += "pattern = \"2x2\"\n";
        }
        let field = match surrounds {
            Some(surrounds) => mesh(surrounds),
            None => format!("kernel = {}\n", listed(kernels, rows)),
        };
        text += &field;
        let _ = writeln!(text, "threshold = {}", listed(thresholds, threshold));
        if let Some(kernel) = memory_kernel {
            let _ = writeln!(text, "memory-kernel = {}", rows(kernel));
        }
        if *log_temporal {
            text += "log-temporal = true\n";
        }
        text
    }
}

/// One as it is, several as an array.
fn listed<T>(all: &[T], written: impl Fn(&T) -> String) -> String {
    match all {
        [one] => written(one),
        several => {
            let each: Vec<String> = several.iter().map(written).collect();
            format!("[\n{}]", each.join(",\n") + ",\n")
        }
    }
}

fn rows(kernel: &Kernel) -> String {
    let rows = kernel.weights().rows();
    let rows = rows
        .into_iter()
        .map(|row| format!("  {:?},\n", row.to_vec()));
    format!("[\n{}]", rows.collect::<String>())
}

fn threshold(threshold: &Threshold) -> String {
    let Threshold { on, off, sigma } = threshold;
    let mut text = format!("{{ on = {on:?}, off = {off:?}");
    if *sigma > 0.0 {
        let _ = write!(text, ", sigma = {sigma:?}");
    }
    text + " }"
}

fn mesh(surrounds: &Surrounds) -> String {
    let Surrounds {
        centre,
        sheets,
        rule,
    } = surrounds;
    let sheets = sheets.iter().map(|surround| {
        let Surround {
            gain,
            sheet,
            tau,
            noise,
        } = surround;
        let ((down, across), tau) = (sheet.lambdas(), micros(*tau));
        format!(
            "{{ gain = {gain:?}, lambda = {across:?}, lambda-y = {down:?}, tau-us = {tau:?}, noise = {noise:?} }}"
        )
    });
    let sheets: Vec<String> = sheets.collect();
    format!(
        "mesh = {{ centre = {centre:?}, rule = \"{}\", sheets = [{}] }}\n",
        rule.word(),
        sheets.join(", ")
    )
}

/// The microseconds that are read as these seconds: the product may be a few units in the last place
/// off. Seconds that no number of microseconds is read as get the nearest.
fn micros(seconds: f64) -> f64 {
    let product = seconds * 1e6;
    let below = iter::successors(Some(product), |us| Some(us.next_down()));
    let above = iter::successors(Some(product), |us| Some(us.next_up()));
    let mut near = below.zip(above).take(5).flat_map(|(us, more)| [us, more]);
    let found = near.find(|us| from_micros(*us) == seconds);
    found.unwrap_or(product)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        bundled::{self, Kind},
        photoreceptor::{Curve, Response},
    };

    fn read(text: &str) -> Description {
        let none = |_: &str| Err(std::io::ErrorKind::NotFound.into());
        Description::parse("again.toml", text, &none).unwrap_or_else(|e| panic!("{e:?}\n{text}"))
    }

    /// Every sensor that comes with the program, and one with all that they do not have.
    #[test]
    fn what_is_written_reads_back() {
        let mut all: Vec<Description> = bundled::all(Kind::Sensor)
            .map(|file| read(file.text))
            .collect();
        assert!(all.len() > 20);
        let mut odd = read(
            "name = \"a \\\"b\\\"\\nc\"\nmemory = \"filtered-snap\"\npolarity = \"pixel\"\nborder = \"zero\"\n\
             response = { linear = { white = 200, round = \"f32\" } }\n\
             [noise]\nleak-hz = 0.1\nshot-at-white = 0.25\njitter-us = 3\n\
             [[channel]]\nkernel = \"dvs\"\nlog-temporal = true\nthreshold = { on = 1e-7, off = 2, sigma = 0.5 }\n",
        );
        all.push(odd.clone());
        odd.response = Response::new(Curve::LinLog { knee: 20.0 });
        all.push(odd);
        for sensor in all {
            let text = sensor.to_toml();
            let again = read(&text);
            assert_eq!(again, sensor, "{text}");
            assert_eq!(again.to_toml(), text);
        }
    }
}
