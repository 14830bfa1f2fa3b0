//! The models of one program on an array: its domain, and each error of analogue cells.

use std::{fmt, ops::Range};

use rayon::prelude::*;

use crate::{
    array::{Arithmetic, Array, Chip, CodeError, Layout, Settings, Silicon},
    event::{Dropped, Event, Packet},
    isa::{Device, Errors},
    mosaic::Mosaic,
    number::Format,
    plane::{At, Size},
    program::{Action, Code, Host, Step},
    scene::Frame,
    sensor::{Sensor, SensorError},
};

use super::{
    error_term::ErrorTerm,
    estimate::{History, Unseen},
    family::Family,
    look::Look,
    program_halo,
};

/// An arithmetic of the array, with what it leaves out.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Machine {
    /// What cells hold; none for analogue cells.
    pub format: Option<Format>,
    /// What analogue cells do without.
    pub without: Vec<ErrorTerm>,
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
        let without: Vec<_> = self.without.iter().map(ErrorTerm::to_string).collect();
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
    /// Whether every event is read, however many slots the program has.
    pub reads_all: bool,
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
        let terms = ErrorTerm::ALL.iter().filter(|_| full.format.is_none());
        let terms = terms.map(|term| {
            let machine = Machine {
                format: None,
                without: vec![*term],
            };
            (term.to_string(), machine)
        });
        plain.chain(terms).collect()
    }

    /// A machine of this size: equally wide parts side by side, the upper left pixels of which lie
    /// at these places of an array of so many columns.
    ///
    /// # Errors
    /// When the program cannot run there.
    pub fn chip(
        &self,
        machine: &Machine,
        size: Size,
        (corners, columns): (&[At], usize),
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
        let domain = Silicon::parts(errors, seed, &Layout::new(device, size), corners, columns);
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
    /// Tiles inside the sensor that lie side by side in the mosaic are one array: their halos keep
    /// them apart, and one array of long rows is worked on faster than many small ones.
    fn on_tiles(
        &self,
        model: &Machine,
        mosaic: &Mosaic,
    ) -> Result<Box<dyn Sensor + Send>, SensorError> {
        let columns = mosaic.whole().width;
        let most = fewest_slots(&self.code.frame);
        let strips = strips(mosaic, most).into_iter();
        let chips = strips.map(|strip| {
            let size = Size::new(strip.rows.len(), strip.across.len());
            let chip = self.chip(model, size, (&strip.corners, columns));
            let chip = chip.map_err(|why| stopped(self.name, &why))?;
            Ok(Part {
                at: (strip.rows.start, strip.across.start),
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

    /// What a chip's numbers cannot hold is the scene's doing; errors and rounding change
    /// cells alike that see the same. Registers that are limited to the ADC scale in either domain
    /// never reach the end of a format that is as wide as that.
    fn unseen(&self, model: &Machine, _: &Look) -> Unseen {
        let ends = |format: Format| {
            let (low, high) = format.limits();
            let is_limited = self.settings.clip && matches!(self.arithmetic, Arithmetic::Number(_));
            let (lowest, highest) = self.settings.range();
            !is_limited || low > lowest || high < highest
        };
        let saturates = model.without.contains(&ErrorTerm::Saturation) || { model.format }
            .is_some_and(|format| format != Format::F64 && ends(format));
        if saturates {
            History::Tile.into()
        } else {
            History::Alike.into()
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

    /// Where each pixel has a slot, none is lost.
    fn loses(&self, size: Size) -> Option<&'static str> {
        let Code { init, frame, .. } = self.code;
        let slots = fewest_slots(init).min(fewest_slots(frame));
        (!self.reads_all && slots < size.pixels()).then_some(
            "the readout has fewer slots than the array has pixels, and which events are lost where they are full depends on the whole array",
        )
    }

    /// Tiles are worked on side by side, and so are the rows of the array.
    fn parts(&self, size: Size) -> usize {
        (size.height / 16).max(1)
    }

    fn whole(&self, model: &Machine, size: Size) -> Result<Box<dyn Sensor + Send>, SensorError> {
        let chip = self.chip(model, size, (&[At { y: 0, x: 0 }], size.width));
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

/// Tiles of a mosaic that are one array.
struct Strip {
    /// Rows and columns of the mosaic.
    rows: Range<usize>,
    across: Range<usize>,
    /// Where the first pixel of each tile lies in the plane.
    corners: Vec<At>,
}

/// The windows of the tiles of a mosaic. Neighbours that lie wholly inside the plane are one, of at
/// most so many pixels, so that no slot is missing that a tile has by itself.
fn strips(mosaic: &Mosaic, most: usize) -> Vec<Strip> {
    let mut strips: Vec<(Strip, bool)> = Vec::new();
    for tile in 0..mosaic.tiles().len() {
        let Some((rows, columns, at)) = mosaic.window(tile) else {
            continue;
        };
        let inside = mosaic.is_inside(tile);
        if let Some((before, true)) = strips.last_mut()
            && inside
            && before.rows == rows
            && before.across.end == columns.start
            && rows.len() * (columns.end - before.across.start) <= most
        {
            before.across.end = columns.end;
            before.corners.push(at);
        } else {
            let strip = Strip {
                rows,
                across: columns,
                corners: vec![at],
            };
            strips.push((strip, inside));
        }
    }
    strips.into_iter().map(|(strip, _)| strip).collect()
}

/// The fewest slots of a readout of events in these steps.
fn fewest_slots(steps: &[Step]) -> usize {
    let slots = steps.iter().map(|step| match &step.action {
        Action::Host(Host::ScanEvents { slots, .. }) => {
            usize::try_from(*slots).unwrap_or(usize::MAX)
        }
        Action::Repeat { body, .. } => fewest_slots(body),
        Action::Host(_) | Action::Word(_) => usize::MAX,
    });
    slots.min().unwrap_or(usize::MAX)
}

/// An array that sees one tile, or some side by side.
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
            let light = light.to_owned().into();
            part.seen.events.clear();
            part.seen.dropped = Dropped::default();
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
            packet.dropped += part.seen.dropped;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        program::{Overrides, Program},
        rng::Hash,
        scene::Frame,
    };

    /// Tiles in strips have the events that they have in the whole array, to the bit, at its border
    /// and inside, and no readout of a strip is fuller than a tile's.
    #[test]
    fn strips_of_tiles_have_the_events_of_the_whole_array() {
        // The whole array has slots for all of its pixels, a tile for all of its own.
        let text = |slots: u32| {
            format!(
                "//! channels = 1\ninit {{ get_image(A); neg(C, A); }}\nframe {{ get_image(A); movx(B, A, east); add(E, A, B); divq(A, E); scamp5_in(D, -6); add(E, A, C); sub(F, D, E); where(F); MOV(R5, FLAG); all(); WHERE(R5); neg(C, A); all(); scamp5_scan_events(R5, on, {slots}); }}\n"
            )
        };
        let device = Device::scamp5();
        let code = |slots| {
            let code = Program::parse("strips", &text(slots)).unwrap();
            code.expand(&device, &Overrides::default()).unwrap().code
        };
        let (code, roomy) = (code(300), code(2000));
        let chips = |code, arithmetic| Chips {
            name: "strips",
            code,
            device: &device,
            settings: Settings::from_device(&device),
            arithmetic,
            reads_all: false,
        };
        for arithmetic in [
            Arithmetic::Number(Format::F64),
            Arithmetic::Silicon { seed: 5 },
        ] {
            strips_are_parts(&chips(&code, arithmetic), &chips(&roomy, arithmetic));
        }
    }

    fn strips_are_parts(family: &Chips<'_>, roomy: &Chips<'_>) {
        let code = family.code;
        let (whole, halo) = (Size::new(40, 48), family.halo().unwrap());
        // At three borders, and inside: neighbours and others.
        let corners = [
            (0, 0),
            (8, 8),
            (8, 16),
            (16, 32),
            (24, 8),
            (32, 40),
            (8, 24),
        ];
        let corners: Vec<At> = corners.map(|(y, x)| At { y, x }).to_vec();
        let mosaic = Mosaic::new(whole, Size::new(8, 8), halo, corners, 4);
        let windows = strips(&mosaic, fewest_slots(&code.frame));
        assert_eq!(strips(&mosaic, 0).len(), 7);
        assert!((3..7).contains(&windows.len()), "{}", windows.len());
        let machine = family.full();
        let mut on_tiles = family.on_tiles(&machine, &mosaic).unwrap();
        let mut on_all = roomy.whole(&machine, whole).unwrap();
        let mut seen = Packet::new(mosaic.size(), 1);
        let mut all = Packet::new(whole, 1);
        for index in 0..6 {
            let hash = Hash::new(7).with(index);
            let light = ndarray::Array2::from_shape_fn(whole.shape(), |(y, x)| {
                (200.0 * hash.with((y * whole.width + x) as u64).uniform()).floor()
            });
            let seconds = 0.01 * index as f64;
            let frame = |light: crate::plane::Plane<f64>| Frame {
                index,
                seconds,
                light: light.into(),
            };
            let shown = mosaic.shown(&light, crate::mosaic::Outside::Nearest);
            on_tiles.watch(&frame(shown), &mut seen).unwrap();
            on_all.watch(&frame(light), &mut all).unwrap();
        }
        let key = |t, at: At| (t, at.y, at.x);
        let mut tiles: Vec<_> = { seen.events.iter() }
            .filter(|e| mosaic.tile(e.y.into(), e.x.into()).is_some())
            .map(|e| key(e.t, mosaic.home(e.y.into(), e.x.into())))
            .collect();
        let own = |at: &At| {
            let tiles = mosaic.tiles().iter();
            tiles.clone().any(|tile| {
                (tile.y..tile.y + 8).contains(&at.y) && (tile.x..tile.x + 8).contains(&at.x)
            })
        };
        let mut want: Vec<_> = { all.events.iter() }
            .map(|e| {
                (
                    e.t,
                    At {
                        y: e.y.into(),
                        x: e.x.into(),
                    },
                )
            })
            .filter(|(_, at)| own(at))
            .map(|(t, at)| key(t, at))
            .collect();
        tiles.sort_unstable();
        want.sort_unstable();
        assert!(want.len() > 100, "{}", want.len());
        assert_eq!(all.dropped.total(), 0);
        assert_eq!(tiles, want);
    }
}
