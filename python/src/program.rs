//! Programs of the array.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use amacrine::{
    array::{Arithmetic, ArithmeticError, Array, Register, Settings, Unheld},
    event::Packet,
    isa::Device,
    photoreceptor::Response,
    plane::{At, Plane, Size},
    program::{
        Action, Cost, Expansion, Exposure, Host, Overrides, Program as Text, Runnable, Step,
        included_files,
    },
    rig::guard::{Guard, Warning},
    study::{
        pilot::{Chips, ErrorTerm, UnknownPart, left_out},
        saturation::{self, Saturation},
    },
    unit::Micros,
};
use miette::{Report, miette};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray2};
use pyo3::{prelude::*, types::PyDict};

use crate::{
    beside::Companion,
    chip::plane,
    error::{raised, refused, told},
    frames::{Borrowed, Frames},
    options::in_python,
    pool, record,
    run::by_reason,
};

/// What a host has written, with the frame, how many frames it saw, and what it did with the
/// photodiodes.
type Beside = (Vec<(usize, String)>, usize, Exposure);

/// A program, expanded on its chip.
#[pyclass(frozen, module = "amacrine._amacrine")]
pub struct Program {
    source: Text,
    device: Device,
    /// What it became; nothing where its host decides.
    expansion: Expansion,
    /// Whether its host decides in the run, beside the array, what the array does.
    decides: bool,
    overrides: Overrides,
}

/// What the cells of the array are: where nothing is given, what the program or the chip says.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Cells {
    domain: Option<String>,
    clip: Option<bool>,
    seed: u64,
    without: Vec<String>,
    edge: Option<f64>,
    gain: Option<f64>,
}

#[pymethods]
impl Program {
    /// The text of a program called `file`, on a chip, with constants of the caller.
    #[new]
    fn new(
        py: Python<'_>,
        file: &str,
        text: &str,
        folder: Option<PathBuf>,
        chip: Option<&str>,
        constants: BTreeMap<String, f64>,
    ) -> PyResult<Self> {
        let made = pool::work(py, || {
            let read = |folder: &PathBuf| included_files(text, folder);
            let includes = folder.as_ref().map(read).unwrap_or_default();
            let program = Text::read_with(file, text, &includes);
            let device = match (chip, program.settings.chip.as_deref()) {
                (Some(chip), _) => Device::find(chip)?,
                (None, Some(chip)) => {
                    let folder = folder.as_deref().or(Path::new(file).parent());
                    Device::find_for(chip, file, folder.unwrap_or(Path::new("")))?
                }
                (None, None) => Device::scamp5(),
            };
            let overrides: Overrides = constants.into_iter().collect();
            let Runnable { expansion, decides } = program.layout(&device, &overrides)?;
            let steady = expansion.filter(|_| !decides);
            Ok(Self {
                source: program,
                device,
                expansion: steady.unwrap_or_default(),
                decides,
                overrides,
            })
        })?;
        made.map_err(|report: Report| raised(report))
    }

    #[getter]
    fn text(&self) -> &str {
        &self.source.text
    }

    #[getter]
    pub fn file(&self) -> &str {
        &self.source.file
    }

    /// The name of the chip.
    #[getter]
    fn chip(&self) -> &str {
        self.device.name()
    }

    /// Instruction words of `init` and of `frame`.
    #[getter]
    fn words(&self) -> (u64, u64) {
        let code = &self.expansion.code;
        let words = |steps: &[Step]| Cost::of(steps, &self.device).words.0;
        (words(&code.init), words(&code.frame))
    }

    /// Microseconds of a frame on the array, and with what the host does.
    #[getter]
    fn micros(&self) -> (f64, f64) {
        let cost = Cost::of(&self.expansion.code.frame, &self.device);
        (cost.array_us, cost.micros())
    }

    /// What is to be warned of in its text, in words.
    #[getter]
    fn warnings(&self) -> Option<String> {
        let warnings = self.source.warnings(&self.expansion)?;
        Some(in_python(&told(&Report::new(warnings))))
    }

    /// Whether it reads events out.
    #[getter]
    fn reads_events(&self) -> bool {
        let code = &self.expansion.code;
        reads_events(&code.init) || reads_events(&code.frame)
    }

    /// Whether its host decides in the run what the array does.
    #[getter]
    fn decides(&self) -> bool {
        self.decides
    }

    /// Frames a second that it states.
    #[getter]
    fn fps(&self) -> Option<f64> {
        self.source.settings.fps
    }

    /// Shows it frames: the bytes of the records of events, the number of kinds, events that
    /// found no slot, registers after the last frame, those of `keep` after every frame, what a
    /// host wrote that runs beside the array, with the frame, and what is to be warned of.
    #[expect(clippy::type_complexity, reason = "what a run gives, once")]
    fn run<'py>(
        &self,
        py: Python<'py>,
        frames: &Bound<'py, PyAny>,
        fps: f64,
        scale: f64,
        cells: Cells,
        keep: Vec<String>,
        set: Vec<(String, PyReadonlyArray2<'py, f64>)>,
    ) -> PyResult<(
        Bound<'py, PyArray1<u8>>,
        u8,
        BTreeMap<&'static str, u64>,
        Bound<'py, PyDict>,
        Bound<'py, PyDict>,
        Vec<(usize, String)>,
        Vec<String>,
    )> {
        let borrowed = Borrowed::new(frames)?;
        let (count, height, width) = borrowed.shape();
        let size = Size::new(height, width);
        let light = Light {
            frames: borrowed.frames()?,
            count,
            fps,
            scale,
        };
        let registers = Register::all(&self.device);
        let named = |name: &String| Register::named(&self.device, name);
        let kept: Vec<_> = keep
            .iter()
            .map(named)
            .collect::<Result<_, _>>()
            .map_err(raised)?;
        let mut chip = pool::work(py, || self.chip_of(size, &cells))?.map_err(raised)?;
        for (name, values) in &set {
            self.set(&mut *chip, name, &values.as_array().to_owned())?;
        }
        let mut packet = Packet::new(size, amacrine::sensor::Sensor::channels(&*chip));
        let mut films: Vec<Vec<f64>> = vec![Vec::new(); kept.len()];
        let (mut posts, mut shown, mut exposure) = (Vec::new(), count, Exposure::default());
        let mut saturation = self.saturation(&*chip, &cells);
        if self.decides {
            let seen = (&kept[..], &mut films[..], saturation.as_mut());
            (posts, shown, exposure) =
                self.run_beside(py, &mut *chip, &light, &mut packet, seen)?;
        }
        let steady = if self.decides { 0 } else { count };
        for n in 0..steady {
            let done = pool::work(py, || {
                self.show(&mut *chip, &light, n, &mut packet)?;
                if let Some(saturation) = &mut saturation {
                    saturation.frame(&*chip);
                }
                for (register, film) in kept.iter().zip(&mut films) {
                    film.extend(register.values(&*chip));
                }
                Ok(())
            })?;
            done.map_err(|report: Report| raised(report))?;
            py.check_signals()?;
        }
        let mut bytes = Vec::new();
        record::append(&packet.events, packet.channels, &mut bytes);
        let last = PyDict::new(py);
        for register in registers {
            let name = register.name(&self.device);
            let values = register.values(&*chip);
            if register.is_bit() {
                last.set_item(name, plane(py, &values.mapv(|bit| bit != 0.0)))?;
            } else {
                last.set_item(name, plane(py, &values))?;
            }
        }
        let every = PyDict::new(py);
        for (register, film) in kept.iter().zip(films) {
            let name = register.name(&self.device);
            let shape = [shown, height, width];
            let wrong = |_| refused("a register is not of the frames' size", "report this");
            if register.is_bit() {
                let bits: Vec<bool> = film.into_iter().map(|bit| bit != 0.0).collect();
                let bits = PyArray1::from_vec(py, bits).reshape(shape);
                every.set_item(name, bits.map_err(wrong)?)?;
            } else {
                let film = PyArray1::from_vec(py, film).reshape(shape);
                every.set_item(name, film.map_err(wrong)?)?;
            }
        }
        let records = PyArray1::from_vec(py, bytes);
        let unheld = self.unheld(&*chip, exposure);
        let held = (unheld.as_ref(), saturation);
        let warned = self.warned(&*chip, &packet, &light, held);
        Ok((
            records,
            packet.channels,
            by_reason(packet.dropped),
            last,
            every,
            posts,
            warned,
        ))
    }
}

/// The frames of a run.
pub struct Light<'a> {
    frames: Frames<'a>,
    pub count: usize,
    fps: f64,
    scale: f64,
}

/// Lets the light of a frame fall on the array; when that is.
pub fn begin(
    chip: &mut (dyn Array + Send),
    light: &Light<'_>,
    n: usize,
    packet: &mut Packet,
) -> Result<Micros, Report> {
    let mut plane = Plane::zeros(packet.size.shape());
    if let Some(plane) = plane.as_slice_mut() {
        light.frames.light(n, light.scale, plane);
    }
    let seconds = n as f64 / light.fps;
    let t = Micros::from_seconds(seconds);
    if let Some((at, wrong)) = { plane.indexed_iter() }.find(|(_, light)| !light.is_finite()) {
        return Err(miette!(
            help = "give finite light",
            "frame {n} of {}, x = {}, y = {}: the light is {wrong}",
            light.count,
            at.1,
            at.0
        ));
    }
    chip.begin_frame();
    chip.expose(&plane)?;
    if n > 0 {
        let before = (n - 1) as f64 / light.fps;
        chip.wait(seconds - before);
    }
    packet.span.1 = t;
    Ok(t)
}

impl Program {
    /// Refuses a program of which no frame after another can be measured.
    pub fn check_steady(&self) -> PyResult<()> {
        let file = &self.source.file;
        let why = if self.decides {
            "its host decides in the run what the array does"
        } else if self.expansion.bare {
            "bare statements say no events"
        } else {
            return Ok(());
        };
        Err(refused(
            format!("{file}: {why}"),
            "give a program with `init` and `frame` that reads events out",
        ))
    }

    /// The chip that it runs on.
    pub const fn device(&self) -> &Device {
        &self.device
    }

    /// The settings of its chip, and its own.
    pub fn settings(&self) -> Settings {
        let own = &self.source.settings;
        let mut settings = Settings::from_device(&self.device);
        settings.clip = own.clip.unwrap_or(settings.clip);
        settings.edge = own.edge.unwrap_or(settings.edge);
        settings
    }

    /// The same, with those of the caller.
    fn settings_of(&self, cells: &Cells) -> Settings {
        let own = self.settings();
        Settings {
            clip: cells.clip.unwrap_or(own.clip),
            edge: cells.edge.unwrap_or(own.edge),
            gain: cells.gain.unwrap_or(own.gain),
            ..own
        }
    }

    /// It on a chip, for a pilot.
    pub fn chips(&self, settings: Settings, arithmetic: Arithmetic) -> Chips<'_> {
        Chips {
            name: &self.source.file,
            code: &self.expansion.code,
            device: &self.device,
            settings,
            arithmetic,
        }
    }

    /// The array that it runs on, as `amacrine exec` makes it.
    fn chip_of(&self, size: Size, cells: &Cells) -> Result<Box<dyn Array + Send>, Report> {
        if !size.is_possible() {
            return Err(miette!(
                help = "height and width must be from 1 to 65536",
                "an array of {size}"
            ));
        }
        let own = &self.source.settings;
        let name = cells.domain.as_ref().or(own.domain.as_ref());
        let name = name.map_or("exact", String::as_str);
        let arithmetic: Arithmetic = name.parse().map_err(|e: ArithmeticError| e)?;
        let settings = self.settings_of(cells);
        let without = cells.without.iter().map(|name| name.parse());
        let without: Vec<ErrorTerm> = without.collect::<Result<_, UnknownPart>>()?;
        let chips = self.chips(settings, arithmetic.with_seed(cells.seed));
        let machine = left_out::cells_without(arithmetic, &without)?;
        let machine = machine.unwrap_or_else(|| chips.machine());
        let lies = (At { y: 0, x: 0 }, size.width);
        chips.chip(&machine, size, lies).map_err(Report::new)
    }

    /// Sets a register before it runs.
    fn set(&self, chip: &mut dyn Array, name: &str, values: &Plane<f64>) -> PyResult<()> {
        let register = Register::named_to_set(&self.device, name).map_err(raised)?;
        let is_bit = register.is_bit();
        let wrong = |value: &f64| !value.is_finite() || (is_bit && *value != 0.0 && *value != 1.0);
        if let Some(((y, x), value)) = values.indexed_iter().find(|(_, value)| wrong(value)) {
            let want = if is_bit { "0 or 1" } else { "finite numbers" };
            return Err(refused(
                format!("registers: {name} is {value} at y = {y}, x = {x}"),
                format!("give {want}"),
            ));
        }
        let bits = || values.mapv(|value| value == 1.0);
        let set = match register {
            Register::Analog(register) => chip.set_analog(register, values),
            Register::Digital(register) => chip.set_digital(register, &bits()),
            Register::Flag => chip.set_flag(&bits()),
            Register::Pix => {
                return Err(refused(
                    format!("registers: {name} are the photodiodes"),
                    "give light as frames",
                ));
            }
        };
        set.map_err(|error| {
            refused(
                format!("registers: {name}: {error}"),
                "give (H,W) of the frames",
            )
        })
    }

    /// Runs its host beside the array.
    fn run_beside(
        &self,
        py: Python<'_>,
        chip: &mut (dyn Array + Send),
        light: &Light<'_>,
        packet: &mut Packet,
        (kept, films, saturation): (&[Register], &mut [Vec<f64>], Option<&mut Saturation>),
    ) -> PyResult<Beside> {
        let mut array = Companion {
            chip,
            light,
            packet,
            kept,
            films,
            saturation,
            pool: pool::pool()?,
            begun: 0,
            t: Micros(0),
            exposure: Exposure::default(),
            dark: false,
            posts: Vec::new(),
            stopped: None,
        };
        let program = &self.source;
        let ran = py.detach(|| program.run_beside(&self.device, &self.overrides, &mut array));
        if let Some(stopped) = array.stopped {
            return Err(stopped);
        }
        ran.map_err(raised)?;
        // The last frame ends with the light, or with the program.
        if !array.dark {
            array.end_frame();
        }
        Ok((array.posts, array.begun, array.exposure))
    }

    /// What is seen of registers at the end of their range.
    fn saturation(&self, chip: &dyn Array, cells: &Cells) -> Option<Saturation> {
        let arithmetic = chip.domain().parse().ok()?;
        let settings = self.settings_of(cells);
        Some(Saturation::new(arithmetic, &self.device, &settings))
    }

    /// What of its numbers the cells of this chip do not hold.
    fn unheld(&self, chip: &dyn Array, exposure: Exposure) -> Option<Unheld> {
        let (cells, settings) = (chip.domain().parse().ok()?, self.settings());
        if self.decides {
            return { exposure.reads().then(|| Unheld::of_light(cells, &settings)) }.flatten();
        }
        let code = &self.expansion.code;
        Unheld::of_program(cells, &[&code.init, &code.frame], &self.device, &settings)
    }

    /// What a run is to be warned of, as `amacrine exec` warns.
    fn warned(
        &self,
        chip: &dyn Array,
        packet: &Packet,
        light: &Light<'_>,
        (unheld, saturation): (Option<&Unheld>, Option<Saturation>),
    ) -> Vec<String> {
        let mut guard = Guard::new();
        let extent = light.frames.extent(light.scale);
        let scale = Warning::scale(light.frames.samples(), extent, Response::IDENTITY);
        if let Some(warning) = scale {
            guard.warn(warning);
        }
        if let Some(unheld) = unheld {
            saturation::warn_unheld(&mut guard, &self.source.file, unheld);
        }
        // A program that reads no events out, and a single frame, have none to miss; a host that
        // decides knows what it leaves, and one without its own numbers tells nothing of light.
        if unheld.is_none() && !self.decides && chip.ledger().slots > 0 && light.count > 1 {
            for n in 0..light.count {
                guard.frame_at(Micros::from_seconds(n as f64 / light.fps));
            }
            guard.packet(&self.source.file, packet);
        }
        if let Some(saturation) = saturation {
            let code = &self.expansion.code;
            let steps = [&code.init[..], &code.frame].concat();
            let loads = |register: &str| {
                // What a host decides is not known before.
                self.decides || saturation::loads(&steps, &self.device, self.settings(), register)
            };
            saturation.warn(&mut guard, &self.source.file, loads);
        }
        let warnings = guard.warnings().into_iter();
        warnings
            .map(|warning| in_python(&warning.to_string()))
            .collect()
    }

    /// One frame: `init` with the first, `frame` with the others; bare statements with each.
    fn show(
        &self,
        chip: &mut (dyn Array + Send),
        light: &Light<'_>,
        n: usize,
        packet: &mut Packet,
    ) -> Result<(), Report> {
        let t = begin(chip, light, n, packet)?;
        if n == 0 && !self.expansion.bare {
            chip.run_init(t, packet)?;
        } else {
            chip.run_frame(t, packet)?;
        }
        Ok(())
    }
}

fn reads_events(steps: &[Step]) -> bool {
    steps.iter().any(|step| match &step.action {
        Action::Word(_) => false,
        Action::Host(host) => {
            matches!(host, Host::ScanEvents { .. })
        }
        Action::Repeat { body, .. } => reads_events(body),
    })
}
