//! A sensor as the text of a sensor file: what [`Description::parse`] reads back as it was.

use std::fmt::Write as _;

use crate::{
    kernel::Kernel,
    reference::{noise::Noise, surround::Surrounds},
};

use super::{
    channel::{Channel, Threshold},
    rules::{Border, PolarityRule},
    sensor::Description,
};

impl Description {
    /// The text of a sensor file that says all of it: kernels as rows of numbers, no other file
    /// needed.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!("name = {}\n", quoted(&self.name));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "response = {}", self.response.text());
        let _ = writeln!(text, "memory = \"{}\"", self.memory.word());
        if self.shared {
            text += "shared = true\n";
        }
        if self.polarity != PolarityRule::default() {
            let _ = writeln!(text, "polarity = \"{}\"", self.polarity.word());
        }
        if self.border != Border::default() {
            let _ = writeln!(text, "border = \"{}\"", self.border.word());
        }
        let rule = self.refractory.rule.word();
        let us = self.refractory.us;
        if us > 0.0 {
            let _ = writeln!(text, "refractory = {{ us = {us:?}, rule = \"{rule}\" }}");
        }
        text += &noise(&self.noise);
        for channel in &self.channels {
            text += "\n[[channel]]\n";
            text += &channel.to_toml();
        }
        text
    }
}

fn noise(noise: &Noise) -> String {
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
        let mut text = String::new();
        if let Some(name) = &self.name {
            let _ = writeln!(text, "name = {}", quoted(name));
        }
        if self.kernels.len() > 1 {
            text += "pattern = \"2x2\"\n";
        }
        let field = match &self.surrounds {
            Some(surrounds) => mesh(surrounds),
            None => format!("kernel = {}\n", listed(&self.kernels, rows)),
        };
        text += &field;
        let _ = writeln!(text, "threshold = {}", listed(&self.thresholds, threshold));
        if let Some(kernel) = &self.memory_kernel {
            let _ = writeln!(text, "memory-kernel = {}", rows(kernel));
        }
        if self.log_temporal {
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
    let sheets = surrounds.sheets.iter().map(|sheet| {
        let (down, across) = sheet.sheet.lambdas();
        let (gain, tau, noise) = (sheet.gain, sheet.tau * 1e6, sheet.noise);
        format!(
            "{{ gain = {gain:?}, lambda = {across:?}, lambda-y = {down:?}, tau-us = {tau:?}, noise = {noise:?} }}"
        )
    });
    let sheets: Vec<String> = sheets.collect();
    format!(
        "mesh = {{ centre = {:?}, rule = \"{}\", sheets = [{}] }}\n",
        surrounds.centre,
        surrounds.rule.word(),
        sheets.join(", ")
    )
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
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
            // Three square roots lie between a space constant and its square.
            if sensor.channels.iter().all(|kind| kind.surrounds.is_none()) {
                assert_eq!(again, sensor, "{text}");
            }
            let [first, second] = [text, again.to_toml()].map(|text| text.parse().unwrap());
            assert_alike(&toml::Value::Table(first), &toml::Value::Table(second));
        }
    }

    /// The same but for the last digits of numbers.
    fn assert_alike(one: &toml::Value, other: &toml::Value) {
        use toml::Value::{Array, Float, Table};
        match (one, other) {
            (Float(a), Float(b)) => assert!((a - b).abs() <= 1e-12 * a.abs(), "{a} {b}"),
            (Array(a), Array(b)) => {
                assert_eq!(a.len(), b.len());
                a.iter().zip(b).for_each(|(a, b)| assert_alike(a, b));
            }
            (Table(a), Table(b)) => {
                assert!(a.keys().eq(b.keys()));
                a.values()
                    .zip(b.values())
                    .for_each(|(a, b)| assert_alike(a, b));
            }
            _ => assert_eq!(one, other),
        }
    }
}
