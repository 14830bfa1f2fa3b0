//! The models of one program on an array: its domain, and each error of analogue cells.

use std::fmt;

use rayon::prelude::*;

use crate::{
    array::{Arithmetic, Array, Chip, CodeError, Errors, Layout, Settings, Silicon},
    event::{Event, Packet},
    isa::Device,
    mosaic::Mosaic,
    number::Format,
    plane::{At, Size},
    program::Code,
    scene::Frame,
    sensor::{Sensor, SensorError},
};

use super::{estimate::Unseen, family::Family, look::Look, program_halo, term::Term};

/// An arithmetic of the array, with what it leaves out.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Machine {
    /// What cells hold; none for analogue cells.
    pub format: Option<Format>,
    /// What analogue cells do without.
    pub without: Vec<Term>,
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.format {
            Some(format) => Arithmetic::Number(format).fmt(f)?,
            None => f.write_str("silicon")?,
        }
        if self.without.is_empty() {
            return Ok(());
        }
        let without: Vec<_> = self.without.iter().map(Term::to_string).collect();
        write!(f, " without {}", without.join(", "))
    }
}

/// A program, and the array that it runs on.
#[derive(Clone, Copy, Debug)]
pub struct Chips<'a> {
    /// What it is called.
    pub name: &'a str,
    /// What runs.
    pub code: &'a Code,
    /// The chip.
    pub device: &'a Device,
    /// How the array behaves, and is worked on.
    pub settings: Settings,
    /// The full model.
    pub arithmetic: Arithmetic,
}

impl Chips<'_> {
    /// The full model.
    #[must_use]
    pub const fn machine(&self) -> Machine {
        let format = match self.arithmetic {
            Arithmetic::Number(format) => Some(format),
            Arithmetic::Silicon { .. } => None,
        };
        Machine {
            format,
            without: Vec::new(),
        }
    }

    /// What could be left out, one thing at a time: the domain for one of these formats, and each
    /// error of analogue cells.
    #[must_use]
    pub fn candidates(&self, formats: &[Format]) -> Vec<(String, Machine)> {
        let full = self.machine();
        let plain = formats
            .iter()
            .filter(|format| Some(**format) != full.format);
        let plain = plain.map(|format| {
            let machine = Machine {
                format: Some(*format),
                without: Vec::new(),
            };
            (format!("{full}, for {machine}"), machine)
        });
        let terms = Term::ALL.iter().filter(|_| full.format.is_none());
        let terms = terms.map(|term| {
            let machine = Machine {
                format: None,
                without: vec![*term],
            };
            (term.to_string(), machine)
        });
        plain.chain(terms).collect()
    }

    /// A machine of this size, its upper left pixel at this place of an array of so many columns.
    ///
    /// # Errors
    /// When the program cannot run there.
    pub fn chip(
        &self,
        machine: &Machine,
        size: Size,
        lies: (At, usize),
    ) -> Result<Box<dyn Array + Send>, CodeError> {
        let Self {
            name, code, device, ..
        } = *self;
        let seed = match self.arithmetic {
            Arithmetic::Silicon { seed } => seed,
            Arithmetic::Number(_) => 0,
        };
        if let Some(format) = machine.format {
            return Arithmetic::Number(format).chip(name, code, device, size, self.settings);
        }
        let mut errors = Errors::from_device(device);
        for term in &machine.without {
            term.leave_out(&mut errors);
        }
        let domain = Silicon::part(errors, seed, &Layout::new(device, size), lies);
        let chip = Chip::new(name, domain, code, device, size, self.settings)?;
        Ok(Box::new(chip))
    }
}

fn stopped(name: &str, why: &CodeError) -> SensorError {
    SensorError::Stopped {
        sensor: name.to_owned(),
        why: why.to_string(),
    }
}

impl Family for Chips<'_> {
    type Model = Machine;

    fn full(&self) -> Machine {
        self.machine()
    }

    fn halo(&self) -> Result<usize, &'static str> {
        program_halo::halo(self.code, self.device).map(|halo| halo.next_multiple_of(2))
    }

    /// Analogue cells drift, and noise may fire them.
    fn fires_alone(&self) -> bool {
        self.machine().format.is_none()
    }

    fn sees_inserted(&self, _: &Machine) -> bool {
        true
    }

    /// An array for each tile: what lies off the array is a register's edge, which no light makes.
    fn on_tiles(
        &self,
        model: &Machine,
        mosaic: &Mosaic,
    ) -> Result<Box<dyn Sensor + Send>, SensorError> {
        let columns = mosaic.whole().width;
        let tiles = 0..mosaic.tiles().len();
        let chips = tiles.filter_map(|tile| mosaic.window(tile)).map(|window| {
            let size = Size::new(window.0.len(), window.1.len());
            let chip = self.chip(model, size, (window.2, columns));
            let chip = chip.map_err(|why| stopped(self.name, &why))?;
            Ok(Part {
                at: (window.0.start, window.1.start),
                seen: Packet::new(size, chip.channels()),
                chip,
            })
        });
        let chips: Vec<Part> = chips.collect::<Result<_, SensorError>>()?;
        let channels = chips.iter().map(|part| part.chip.channels()).max();
        Ok(Box::new(Tiled {
            size: mosaic.size(),
            channels: channels.unwrap_or(1),
            name: self.name.to_owned(),
            chips,
        }))
    }

    /// What a chip's numbers cannot hold is the scene's doing; errors are each cell's own.
    fn unseen(&self, model: &Machine, _: &Look) -> Unseen {
        let saturates = model.without.contains(&Term::Saturation)
            || model.format.is_some() && model.format != Some(Format::F64);
        if saturates {
            Unseen::Tile
        } else {
            Unseen::Cell
        }
    }

    fn together(&self, models: &[Machine]) -> Option<Machine> {
        // A domain of numbers has none of the errors.
        let mut all = self.machine();
        for model in models {
            if model.format != all.format {
                return None;
            }
            all.without.extend(&model.without);
        }
        all.without.sort_unstable();
        all.without.dedup();
        Some(all)
    }

    /// Tiles are worked on side by side, and so are the rows of the array.
    fn parts(&self, size: Size) -> usize {
        (size.height / 16).max(1)
    }

    fn whole(&self, model: &Machine, size: Size) -> Result<Box<dyn Sensor + Send>, SensorError> {
        let chip = self.chip(model, size, (At { y: 0, x: 0 }, size.width));
        match chip {
            Ok(chip) => Ok(Box::new(chip)),
            Err(why) => Err(stopped(self.name, &why)),
        }
    }

    fn on_the_whole(
        &self,
        model: &Machine,
        size: Size,
    ) -> Option<Result<Box<dyn Sensor + Send>, SensorError>> {
        Some(self.whole(model, size))
    }
}

/// An array that sees one tile.
struct Part {
    /// Row and column of the mosaic where it begins.
    at: (usize, usize),
    chip: Box<dyn Array + Send>,
    seen: Packet,
}

/// Arrays side by side, as one sensor that watches mosaics.
struct Tiled {
    name: String,
    size: Size,
    channels: u8,
    chips: Vec<Part>,
}

impl Sensor for Tiled {
    fn name(&self) -> &str {
        &self.name
    }

    fn size(&self) -> Size {
        self.size
    }

    fn channels(&self) -> u8 {
        self.channels
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        self.chips.par_iter_mut().try_for_each(|part| {
            let (y, x) = part.at;
            let Size { height, width } = part.chip.size();
            let light = frame.light.slice(ndarray::s![y..y + height, x..x + width]);
            let light = light.to_owned();
            part.seen.events.clear();
            part.chip.watch(&Frame { light, ..*frame }, &mut part.seen)
        })?;
        for part in &self.chips {
            let (y, x) = part.at;
            let there = |event: &Event| Event {
                y: event.y + y as u16,
                x: event.x + x as u16,
                ..*event
            };
            packet.events.extend(part.seen.events.iter().map(there));
            packet.span = part.seen.span;
        }
        Ok(())
    }
}
