//! What came of it, for machines and for people.

use std::{
    fmt,
    path::{Path, PathBuf},
};

use serde_json::json;

use super::reading;
use crate::{
    array::{Arithmetic, Array, Ledger, Readings},
    cli::arguments::light,
    event::{Packet, Polarity},
    program::Cost,
    rig::guard::Warning,
    scene::Observation,
    unit::counted,
};

/// Readings that the table shows.
const READINGS: usize = 40;

/// What the run gave.
pub struct Report<'a> {
    pub program: &'a str,
    pub chip: &'a dyn Array,
    pub arithmetic: Arithmetic,
    /// What analogue cells do without, after the arithmetic.
    pub without: String,
    pub frames: u64,
    /// What a frame costs; none where the host decides, and frames differ.
    pub per_frame: Option<Cost>,
    pub packet: &'a Packet,
    pub light: &'a Observation,
    pub warnings: &'a [Warning],
    /// What there is to warn of in the program's text.
    pub source_warnings: &'a [String],
    /// What is to be said beside.
    pub notes: &'a [String],
    /// Whether its host decides, and looks for one pixel after the other.
    pub decides: bool,
    /// Whether it reads events out, in slots or in whole bit planes.
    pub reads_events: bool,
    /// What the host wrote, and in which frame.
    pub posts: &'a [(u64, String)],
    /// What was written.
    pub written: &'a [Written],
}

/// A file that was written, or a folder with so many of them.
pub struct Written {
    pub path: PathBuf,
    pub files: Option<usize>,
}

impl From<&Path> for Written {
    fn from(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            files: None,
        }
    }
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        match self.files {
            None => write!(f, "{path}"),
            Some(files) => write!(f, "{path} ({})", counted(files, "file")),
        }
    }
}

/// The file and the line of `file:line`.
fn in_file(origin: &str) -> Option<(&str, u32)> {
    let (file, line) = origin.rsplit_once(':')?;
    Some((file, line.parse().ok()?))
}

/// What scans have not read of what was set; beside a host that decides, which may look again.
pub fn lost(ledger: &Ledger, decides: bool) -> Vec<String> {
    let more = if decides {
        "; the host may look for them again"
    } else {
        ""
    };
    let counts = [
        (ledger.missed, "found no slot"),
        (ledger.unscanned, "lie in rows that are not scanned"),
    ];
    let told = counts.into_iter().filter(|(count, _)| *count > 0);
    told.map(|(count, what)| format!("{count} set pixels {what}{more}"))
        .collect()
}

impl Report<'_> {
    fn on_and_off(&self) -> (usize, usize) {
        let events = &self.packet.events;
        let on = events.iter().filter(|e| e.polarity == Polarity::On).count();
        (on, events.len() - on)
    }

    /// Each kind by its name, where it has one.
    fn kinds(&self) -> Vec<serde_json::Value> {
        let all = self.packet.each_kind().into_iter().enumerate();
        all.map(
            |(kind, [on, off])| json!({"name": self.packet.names.get(kind), "on": on, "off": off}),
        )
        .collect()
    }

    pub fn json(&self) -> serde_json::Value {
        let ledger = self.chip.ledger();
        let cost = ledger.cost(self.chip.device());
        let (on, off) = self.on_and_off();
        let readings: Vec<_> = self
            .chip
            .readings()
            .iter()
            .map(|reading| {
                let value = match &reading.values {
                    Readings::Analog { columns, values } => {
                        json!({"columns": columns, "adc": values})
                    }
                    Readings::Digital { columns, values } => {
                        json!({"columns": columns, "bits": values})
                    }
                    Readings::Box(found) => json!({"box": found.map(|w| json!({
                        "top": w.top, "right": w.right, "bottom": w.bottom, "left": w.left
                    }))}),
                    Readings::Sum(sum) => json!({"sum": sum}),
                    Readings::Any(any) => json!({"any": any}),
                };
                let mut told = json!({"line": reading.line, "value": value});
                if let Some((file, line)) = reading.origin.as_deref().and_then(in_file) {
                    told["file"] = json!(file);
                    told["line"] = json!(line);
                }
                told
            })
            .collect();
        json!({
            "program": self.program,
            "chip": self.chip.device().name(),
            "domain": self.arithmetic.to_string(),
            "width": self.packet.size.width,
            "height": self.packet.size.height,
            "frames": self.frames,
            "words": cost.words,
            "words_per_frame": self.per_frame.map(|frame| frame.words),
            "words_by_clock": {
                "analog": ledger.analog,
                "digital": ledger.digital,
                "dnews": ledger.dnews,
                "prop": ledger.prop,
            },
            "array_us": cost.array_us,
            "array_us_per_frame": self.per_frame.map(|frame| frame.array_us),
            "host_us": cost.host_us,
            "slots": ledger.slots,
            "events": self.packet.events.len(),
            "arrived": self.packet.events.len(),
            "on": on,
            "off": off,
            "kinds": self.kinds(),
            "dropped": self.packet.dropped,
            "ambiguous": ledger.ambiguous,
            "readings": readings,
            "light": light::json(self.light),
            "warnings": self.warnings,
            "source_warnings": self.source_warnings,
            "notes": self.notes,
            "posts": self.posts.iter()
                .map(|(frame, text)| json!({"frame": frame, "text": text}))
                .collect::<Vec<_>>(),
            "written": self.written.iter().map(|it| &it.path).collect::<Vec<_>>(),
        })
    }

    pub fn table(&self) -> String {
        let ledger = self.chip.ledger();
        let cost = ledger.cost(self.chip.device());
        let Ledger {
            analog,
            digital,
            dnews,
            prop,
            ..
        } = ledger;
        let (on, off) = self.on_and_off();
        let mut lines = vec![
            format!(
                "program  {} on {}, {}, {}{}",
                self.program,
                self.chip.device().name(),
                self.packet.size,
                self.arithmetic,
                self.without
            ),
            format!("frames   {}", self.frames),
            format!(
                "words    {} ({analog} analog, {digital} digital, {dnews} DNEWS, {prop} PROP)",
                cost.words.0
            ),
            format!(
                "time     {:.1} us on the array, {:.1} us on the host",
                cost.array_us, cost.host_us
            ),
        ];
        let light = light::line(self.light);
        if !light.is_empty() {
            lines.push(light.trim_end().to_owned());
        }
        // A host that decides may read none.
        let events = self.packet.events.len();
        if ledger.slots > 0 || events > 0 || (self.reads_events && !self.decides) {
            let slots = match ledger.slots {
                0 => String::new(),
                slots => format!(" in {}", counted(slots, "slot")),
            };
            lines.push(format!("events   {events} ({on} ON, {off} OFF){slots}"));
            if self.packet.channels > 1 {
                for (kind, [on, off]) in self.packet.each_kind().into_iter().enumerate() {
                    let name = self.packet.names.get(kind).map_or("", |name| name);
                    lines.push(format!("  channel {kind} {name}: {on} ON, {off} OFF"));
                }
            }
        }
        // Of a host that looks again and again they are among the notes.
        let lost = { lost(&ledger, false).into_iter() }.filter(|_| !self.decides);
        lines.extend(lost.map(|note| format!("note     {note}")));
        if ledger.ambiguous > 0 {
            let it = if ledger.ambiguous == 1 { "it" } else { "them" };
            let events = counted(ledger.ambiguous, "event");
            lines.push(format!(
                "note     {events} at the chip's (0,0), the top right pixel, kept here: a host that takes (0,0) for the end of the list would lose {it}"
            ));
        }
        // A host that looks again and again reads much.
        let readings = self.chip.readings();
        for reading in readings.iter().take(READINGS) {
            lines.push(format!("read     {}", reading::line(reading)));
        }
        if let Some(more) = readings.len().checked_sub(READINGS + 1) {
            lines.push(format!("read     {} more (--json lists them)", more + 1));
        }
        // As for what was read: that of the last frame.
        let last = self.posts.iter().filter(|it| it.0 + 1 == self.frames);
        let last = last.flat_map(|it| it.1.lines());
        lines.extend(last.map(|text| format!("post     {text}")));
        lines.extend(self.notes.iter().map(|note| format!("note     {note}")));
        lines.extend(self.written.iter().map(|what| format!("wrote    {what}")));
        lines.join("\n") + "\n"
    }
}
