//! A whole sensor as a program: capture, filter, compare, events, memory, readout.

use std::fmt::Write as _;

use super::{CompileError, Filter, Request, ordinary};
use crate::{
    isa::{Analog, Device, Figure},
    kernel::Kernel,
};

/// One kind of cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// Its kernel, of dyadic weights.
    pub kernel: Kernel,
    /// An ON event happens when kernel times light (0 to 255) has risen by more than this since
    /// the last event,
    pub on: f64,
    /// an OFF event when it has fallen by more than this.
    pub off: f64,
}

/// The light of a capture, in LSB: up to what a register holds; a pixel at the very end of the
/// scale, 255, is half an LSB beyond it.
const CAPTURE: (f64, f64) = (0.0, 127.0);

/// A sensor in chip text.
#[derive(Clone, Debug)]
pub struct SensorProgram {
    /// The text, settings above.
    pub text: String,
    /// The filter in it, from the capture to the drives.
    pub filter: Filter,
    /// The register of each kind's drive.
    pub drives: Vec<Analog>,
    /// From kernel times light to LSB in the drive.
    pub scale: f64,
}

impl SensorProgram {
    /// Searches for the filter and writes the program around it: memory `filtered-snap`, one
    /// decision a frame. `request` gives the chip, the effort and the seed; registers are chosen
    /// here.
    ///
    /// # Errors
    /// When a weight is not dyadic, or there are too few registers.
    pub fn new(kinds: &[Kind], title: &str, request: &Request<'_>) -> Result<Self, CompileError> {
        let device = request.device;
        let all = ordinary(device);
        let count = kinds.len();
        if all.len() < 2 * count + 2 {
            return Err(CompileError::Registers {
                what: format!(
                    "{count} kinds, each with a drive and a memory, a threshold and a scratch"
                ),
                needed: 2 * count + 2,
                free: all.len(),
            });
        }
        let memories = all[all.len() - count..].to_vec();
        let kernels: Vec<Kernel> = kinds.iter().map(|kind| kind.kernel.clone()).collect();
        let light = device.value(Figure::LightScale) * 255.0;
        let request = Request {
            kernels: &kernels,
            input: all[0],
            into: all[..count].to_vec(),
            keep: memories.clone(),
            border: true,
            range: Some((CAPTURE.0, light.clamp(1.0, CAPTURE.1))),
            ..request.clone()
        };
        let filter = request.filter()?;
        let scale = device.value(Figure::LightScale) * 2f64.powi(-(filter.prescale as i32));
        let writer = Writer {
            device,
            kinds,
            filter: &filter,
            scale,
            drives: &all[..count],
            memories: &memories,
            threshold: all[all.len() - count - 1],
            scratch: all[count],
        };
        let text = writer.text(title);
        Ok(Self {
            text,
            drives: all[..count].to_vec(),
            filter,
            scale,
        })
    }
}

struct Writer<'a> {
    device: &'a Device,
    kinds: &'a [Kind],
    filter: &'a Filter,
    scale: f64,
    drives: &'a [Analog],
    memories: &'a [Analog],
    threshold: Analog,
    scratch: Analog,
}

impl Writer<'_> {
    fn text(&self, title: &str) -> String {
        let mut text = self.header(title);
        let name = |register: &Analog| self.device.analog_name(*register);
        for (i, kind) in self.kinds.iter().enumerate() {
            let (on, off) = self.constants(i);
            let _ = writeln!(text, "const {on} = {:?};", kind.on * self.scale);
            if off != on {
                let _ = writeln!(text, "const {off} = {:?};", kind.off * self.scale);
            }
        }
        text += "const slots = 4000; // the most that one readout can deliver\n\n";
        let list = |registers: &[Analog]| registers.iter().map(name).collect::<Vec<_>>().join(", ");
        let _ = writeln!(
            text,
            "// {}: the drive; {}: minus the memory; {}: minus the threshold; R5 ON, R6 OFF",
            list(self.drives),
            list(self.memories),
            name(&self.threshold),
        );
        text += "\ninit {\n";
        self.filter_text(&mut text);
        for (drive, memory) in self.drives.iter().zip(self.memories) {
            let _ = writeln!(text, "    neg({}, {});", name(memory), name(drive));
        }
        text += "}\n\nframe {\n";
        self.filter_text(&mut text);
        for i in 0..self.kinds.len() {
            self.events(&mut text, i);
        }
        text += "}\n";
        text
    }

    fn header(&self, title: &str) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "//! title = {title:?}");
        let _ = writeln!(text, "//! chip = {:?}", self.device.name());
        text += "//! image = \"pattern:disc?width=64&height=48\"\n//! frames = 8\n";
        let _ = writeln!(text, "//! channels = {}", self.kinds.len());
        let reach = if self.filter.border {
            "right up to the border"
        } else {
            "right where the kernel lies on the array, not at its border"
        };
        let _ = writeln!(
            text,
            "//!\n//! # Compiled. The light is halved {} times first, so that no sum leaves the range; the\n//! # filter is {reach}. The memory is the drive at the last event (filtered-snap).",
            self.filter.prescale,
        );
        if let [kind] = self.kinds {
            text += "//! [computes]\n//! kernel = [\n";
            for row in kind.kernel.weights().rows() {
                let _ = writeln!(text, "//!     {:?},", row.to_vec());
            }
            let _ = writeln!(text, "//! ]\n//! scale = {:?}", self.scale);
            if kind.on == kind.off {
                text += "//! threshold = \"threshold\"\n";
            }
        }
        text.push('\n');
        text
    }

    /// Names of the thresholds.
    fn constants(&self, i: usize) -> (String, String) {
        let number = if self.kinds.len() > 1 {
            i.to_string()
        } else {
            String::new()
        };
        if self.kinds[i].on == self.kinds[i].off {
            let both = format!("threshold{number}");
            return (both.clone(), both);
        }
        (
            format!("on_threshold{number}"),
            format!("off_threshold{number}"),
        )
    }

    fn filter_text(&self, text: &mut String) {
        let drive = self.device.analog_name(self.drives[0]);
        let _ = writeln!(text, "    get_image({drive});\n");
        text.push_str(&self.filter.text(self.device, 4));
        text.push('\n');
    }

    /// Compare, note, remember, read out.
    fn events(&self, text: &mut String, i: usize) {
        let name = |register: Analog| self.device.analog_name(register);
        let (drive, memory) = (name(self.drives[i]), name(self.memories[i]));
        let (threshold, scratch) = (name(self.threshold), name(self.scratch));
        let (on, off) = self.constants(i);
        let number = if self.kinds.len() > 1 {
            i.to_string()
        } else {
            String::new()
        };
        let mut line = |what: &str| {
            let _ = writeln!(text, "    {what}");
        };
        line(&format!("scamp5_in({threshold}, -{off});"));
        line("bus(NEWS);");
        line(&format!("bus({scratch}, NEWS, {drive}, {memory});"));
        line(&format!(
            "where({scratch}, {threshold}); // memory - drive > threshold"
        ));
        line("MOV(R6, FLAG);");
        if on != off {
            line("all();");
            line(&format!("scamp5_in({threshold}, -{on});"));
        }
        line(&format!(
            "where({drive}, {memory}, {threshold}); // drive - memory > threshold"
        ));
        line("MOV(R5, FLAG);");
        line("WHERE(R5, R6); // where it fired, the memory becomes the drive");
        line(&format!("neg({memory}, {drive});"));
        line("all();");
        line(&format!("scamp5_scan_events(R5, on{number}, slots);"));
        line(&format!("scamp5_scan_events(R6, off{number}, slots);"));
    }
}

impl Filter {
    /// The words as statements, one a line.
    #[must_use]
    pub fn text(&self, device: &Device, indent: usize) -> String {
        let mut text = String::new();
        for word in &self.words {
            let _ = writeln!(text, "{:indent$}{};", "", word.text(device));
        }
        text
    }
}
