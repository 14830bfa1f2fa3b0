//! Programs of the array.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use amacrine::{
    array::{Arithmetic, Array, Register, Settings},
    event::Packet,
    isa::Device,
    plane::{Plane, Size},
    program::{
        Cost, Expansion, Exposure, Overrides, Program as Text, Runnable, Step, included_files,
    },
    rig::guard::Guard,
    scene::{Frame, Levels, Observation, check_rate},
    study::{
        execution::{self, CellOptions, Execution, Ran},
        pilot::{Chips, ErrorTerm, Machine, UnknownPart, left_out},
        saturation::Saturation,
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
    source::outline,
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
    /// The folder of the chip that its text names, where that is none that comes with the package.
    chip_folder: Option<PathBuf>,
}

/// The folder of a chip that a program in `folder` names, as [`Device::find_for`] finds it.
fn chip_folder(name: &str, folder: &Path) -> Option<PathBuf> {
    if Device::shipped().any(|shipped| shipped == name) {
        return None;
    }
    let places = [PathBuf::from(name), folder.join(name)];
    let found = places.into_iter().find(|place| place.is_dir())?;
    std::path::absolute(found).ok()
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
            let (device, chip_folder) = match (chip, program.settings.chip.as_deref()) {
                (Some(chip), _) => (Device::find(chip)?, None),
                (None, Some(chip)) => {
                    let folder = folder.as_deref().or(Path::new(file).parent());
                    let folder = folder.unwrap_or(Path::new(""));
                    let device = Device::find_for(chip, file, folder)?;
                    (device, chip_folder(chip, folder))
                }
                (None, None) => (Device::scamp5(), None),
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
                chip_folder,
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

    /// Where the chip that its text names lies, where that is none that comes with the package.
    #[getter]
    fn chip_folder(&self) -> Option<&str> {
        self.chip_folder.as_deref()?.to_str()
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

    /// Shows it frames: the bytes of the records of events, the numbers of kinds and of frames, events that
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
        (u8, usize),
        BTreeMap<&'static str, u64>,
        Bound<'py, PyDict>,
        Bound<'py, PyDict>,
        Vec<(usize, String)>,
        Vec<String>,
    )> {
        check_rate(fps).map_err(raised)?;
        let borrowed = Borrowed::new(frames)?;
        let (count, height, width) = borrowed.shape();
        let size = Size::new(height, width);
        let light = Light::new(borrowed.frames()?, (count, size), fps, scale);
        let registers = Register::all(&self.device);
        let named = |name: &String| Register::named(&self.device, name);
        let kept: Vec<_> = keep
            .iter()
            .map(named)
            .collect::<Result<_, _>>()
            .map_err(raised)?;
        let execution = self.execution(&cells).map_err(raised)?;
        let machine = cells.machine(&execution).map_err(raised)?;
        let made = pool::work(py, || made(&execution, machine.as_ref(), size))?;
        let mut chip = made.map_err(raised)?;
        for (name, values) in &set {
            self.set(&mut *chip, name, &values.as_array().to_owned())?;
        }
        let mut packet = Packet::new(size, amacrine::sensor::Sensor::channels(&*chip));
        packet.names = self.source.names_of(packet.channels).map_err(raised)?;
        let mut films: Vec<Vec<f64>> = vec![Vec::new(); kept.len()];
        let (mut posts, mut shown) = (Vec::new(), count);
        let mut exposure = Exposure::default();
        exposure.see(&self.expansion.code.frame, &self.device);
        let mut saturation = execution.saturation();
        if self.decides {
            let seen = (&kept[..], &mut films[..], &mut saturation);
            (posts, shown, exposure) =
                self.run_beside(py, &mut *chip, &light, &mut packet, seen)?;
        }
        let steady = if self.decides { 0 } else { count };
        for n in 0..steady {
            let done = pool::work(py, || {
                self.show(&mut *chip, &light, n, &mut packet, &mut saturation)?;
                saturation.frame(&*chip);
                for (register, film) in kept.iter().zip(&mut films) {
                    film.extend(register.values(&*chip));
                }
                Ok(())
            })?;
            done.map_err(|report: Report| raised(report))?;
            py.check_signals()?;
        }
        let bytes = pool::work(py, || {
            let mut bytes = Vec::new();
            record::append(&packet.events, packet.channels, &mut bytes);
            bytes
        })?;
        let last = PyDict::new(py);
        for register in registers {
            let name = register.name(&self.device);
            let values = register.values(&*chip);
            if register.is_bit() {
                last.set_item(name, plane(py, &values.mapv(|bit| bit != 0.0))?)?;
            } else {
                last.set_item(name, plane(py, &values)?)?;
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
        let mut guard = Guard::new();
        for n in 0..shown {
            guard.frame_at(Micros::from_seconds(n as f64 / light.fps));
        }
        let warned = execution.warnings(Ran {
            chip: &*chip,
            packet: &packet,
            frames: shown as u64,
            observation: &light.observation,
            is_dark: false,
            exposure,
            saturation,
            guard,
        });
        let warned = warned.iter().map(|it| in_python(&it.to_string()));
        let set = set.iter().map(|(name, _)| name.as_str());
        let warned = warned.chain(self.uncaptured(set)).collect();
        Ok((
            records,
            (packet.channels, shown),
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
    size: Size,
    fps: f64,
    scale: f64,
    /// What codes of 8 bits stand for.
    levels: Levels,
    /// What was seen of them.
    observation: Observation,
}

impl<'a> Light<'a> {
    fn new(frames: Frames<'a>, (count, size): (usize, Size), fps: f64, scale: f64) -> Self {
        let observation = Observation::new();
        observation.begin(&outline(frames.samples(), (count, size), fps));
        Self {
            frames,
            count,
            size,
            fps,
            scale,
            levels: Levels::bytes().map(|code| code * scale),
            observation,
        }
    }

    /// Frame `n`.
    fn frame(&self, n: usize) -> Result<Frame, Report> {
        let mut light = Plane::zeros(self.size.shape()).into();
        { self.frames }.show(n, (self.scale, &self.levels), &mut light);
        if let Some((at, wrong)) = { light.indexed_iter() }.find(|(_, light)| !light.is_finite()) {
            return Err(miette!(
                help = "give finite light",
                "frame {n} of {}, x = {}, y = {}: the light is {wrong}",
                self.count,
                at.1,
                at.0
            ));
        }
        Ok(Frame {
            index: n as u64,
            seconds: n as f64 / self.fps,
            light,
        })
    }
}

/// Lets the light of a frame fall on the array; when that is.
pub fn begin(
    chip: &mut (dyn Array + Send),
    light: &Light<'_>,
    n: usize,
    packet: &mut Packet,
) -> Result<Micros, Report> {
    let frame = light.frame(n)?;
    light.observation.see(&frame);
    let before = n.checked_sub(1).map(|n| n as f64 / light.fps);
    let (t, _) = execution::begin(chip, &frame, before, packet)?;
    Ok(t)
}

/// The array of a run, as switched on.
fn made(
    execution: &Execution<'_>,
    machine: Option<&Machine>,
    size: Size,
) -> Result<Box<dyn Array + Send>, Report> {
    if !size.is_possible() {
        return Err(miette!(
            help = "height and width must be from 1 to 65536",
            "an array of {size}"
        ));
    }
    Ok(execution.chip(machine, size)?)
}

impl Cells {
    /// What the library calls them.
    fn options(&self) -> CellOptions<'_> {
        CellOptions {
            domain: self.domain.as_deref(),
            seed: self.seed,
            clip: self.clip,
            edge: self.edge,
            gain: self.gain,
        }
    }

    /// What runs in place of the full model; nothing where that does.
    fn machine(&self, execution: &Execution<'_>) -> Result<Option<Machine>, Report> {
        let without = self.without.iter().map(|name| name.parse());
        let without: Vec<ErrorTerm> = without.collect::<Result<_, UnknownPart>>()?;
        Ok(left_out::cells_without(execution.arithmetic, &without)?)
    }
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
        CellOptions::default().settings(&self.source, &self.device)
    }

    /// It on a chip, for a pilot.
    pub fn chips(&self, settings: Settings, arithmetic: Arithmetic) -> Chips<'_> {
        self.on(settings, arithmetic).chips()
    }

    /// It on an array of these cells.
    fn execution(&self, cells: &Cells) -> Result<Execution<'_>, Report> {
        let options = cells.options();
        let arithmetic = options.arithmetic(&self.source)?;
        Ok(self.on(options.settings(&self.source, &self.device), arithmetic))
    }

    fn on(&self, settings: Settings, arithmetic: Arithmetic) -> Execution<'_> {
        Execution {
            program: &self.source,
            code: &self.expansion.code,
            decides: self.decides,
            recorded: &[],
            device: &self.device,
            arithmetic,
            settings,
        }
    }

    /// That nothing captures the light, where these registers are set.
    fn uncaptured<'a>(&self, set: impl Iterator<Item = &'a str>) -> Option<String> {
        let set = set.filter_map(|name| Register::named_to_set(&self.device, name).ok());
        let set: Vec<Register> = set.collect();
        execution::uncaptured(
            &self.source.file,
            &self.expansion,
            &self.device,
            |register| set.contains(&register),
            |name| format!("registers={{\"{name}\": …}}"),
        )
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
        (kept, films, saturation): (&[Register], &mut [Vec<f64>], &mut Saturation),
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

    /// One frame: `init` with the first, `frame` with the others; bare statements with each.
    fn show(
        &self,
        chip: &mut (dyn Array + Send),
        light: &Light<'_>,
        n: usize,
        packet: &mut Packet,
        saturation: &mut Saturation,
    ) -> Result<(), Report> {
        let t = begin(chip, light, n, packet)?;
        let code = &self.expansion.code;
        if n == 0 && !self.expansion.bare {
            saturation.before(chip, &code.init);
            chip.run_init(t, packet)?;
        } else {
            saturation.before(chip, &code.frame);
            chip.run_frame(t, packet)?;
        }
        Ok(())
    }
}
