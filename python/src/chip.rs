//! A sensor as one program of a chip.

use std::str::FromStr;

use amacrine::{
    array::{Arithmetic, ArithmeticError},
    compile::{Border, DriveMemory, Effort, EventReadout, Request, SensorProgram},
    config::UnknownWord,
    isa::{Device, Figure},
    kernel::{
        Kernel,
        quantise::{Quantiser, QuantiserNameError, Sum},
    },
    plane::Size,
    program::{
        Overrides, Program,
        readout::{Demand, Scans, choose},
    },
    reference::Description,
    rig::guard::Warning,
    sensor::Sensor,
    stop::Stop,
    study::{
        cells::{compiled_cells, memory_of},
        design::{Compiled, DesignError},
        expanded::Expanded,
        run_guard::RunGuard,
    },
    unit::counted,
};
use miette::Report;
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;

use crate::{
    error::{raised, refused},
    options::in_python,
    pool,
    run::Run,
    watcher,
};

/// How a sensor is to become a program.
pub struct Asked<'a> {
    /// A quantiser, or `exact`.
    pub to: &'a str,
    pub sum: &'a str,
    /// `analogue`, `shared` or `bits:N`.
    pub memory: Option<&'a str>,
    pub chip: &'a str,
    /// What the program is to be best at.
    pub objective: &'a str,
    /// Whether it must be right up to the border.
    pub border: bool,
    /// Events that the busiest frame is expected to have, for which the readout is chosen.
    pub events: Option<u64>,
    /// Seconds.
    pub effort: f64,
    pub seed: u64,
    /// Whether to give up.
    pub stop: Stop,
}

/// What a word stands for.
pub fn named<T: FromStr<Err = UnknownWord>>(word: &str) -> PyResult<T> {
    word.parse().map_err(|e: UnknownWord| raised(e))
}

/// What a program remembers, by name; what is nearest to the sensor where none is given.
fn memory(name: Option<&str>, sensor: &Description) -> PyResult<DriveMemory> {
    // What no program remembers is told of in the notes.
    name.map_or_else(
        || Ok(memory_of(&sensor.name, sensor).unwrap_or_default()),
        named,
    )
}

/// A quantiser by name.
pub fn quantiser(name: &str) -> PyResult<Quantiser> {
    name.parse().map_err(|e: QuantiserNameError| raised(e))
}

/// How long to search.
pub fn effort(seconds: f64, stop: Stop) -> PyResult<Effort> {
    if (0.0..=3600.0).contains(&seconds) {
        return Ok(Effort {
            stop,
            ..Effort::seconds(seconds)
        });
    }
    Err(refused(
        format!("`{seconds}` is not a number of seconds from 0 to 3600"),
        "give effort=1",
    ))
}

/// The cheapest readout that loses none of so many events in a frame.
fn readout(
    program: &SensorProgram,
    kinds: usize,
    events: u64,
    device: &Device,
) -> PyResult<EventReadout> {
    let [rows, columns] = [Figure::Height, Figure::Width].map(|of| device.value(of) as u64);
    let cells = rows * columns * kinds as u64;
    if events > cells {
        return Err(refused(
            format!(
                "events_per_frame = {events}, of {} on {rows} x {columns} pixels",
                counted(kinds, "kind")
            ),
            format!("give at most {cells}: a cell has one event in a frame at most"),
        ));
    }
    let parsed = Program::parse("compiled", &program.text).map_err(raised)?;
    let code = parsed.expand(device, &Overrides::default());
    let code = code.map_err(raised)?.code;
    let plans = Scans::new(&code.frame, device).plans(Some(&Demand::expected(events)), device);
    let chosen = choose(&plans).and_then(|chosen| plans.get(chosen));
    Ok(chosen.map_or_else(|| EventReadout::most_slots(device), EventReadout::from))
}

/// A sensor as a program of a chip.
#[pyclass(frozen, module = "amacrine._amacrine")]
pub struct Chip {
    expanded: Expanded,
    /// The program as it was written.
    text: String,
    /// The name of its chip, or the folder.
    device: String,
    /// LSB for each unit of level times light.
    scale: f64,
    /// The kernel of each kind as it is computed, and what it is to be multiplied by.
    levels: Vec<(Kernel, f64)>,
    /// In what the program differs from the float sensor, and what few values have erased.
    notes: Vec<String>,
}

impl Chip {
    /// Brings the kernels to few values, finds a program for them, and reads it back.
    pub fn new(description: &Description, asked: &Asked<'_>) -> PyResult<Self> {
        let to = match asked.to {
            "exact" | "none" => None,
            name => Some(quantiser(name)?),
        };
        let sum: Sum = named(asked.sum)?;
        let device = Device::find(asked.chip).map_err(raised)?;
        let effort = effort(asked.effort, asked.stop)?;
        let memory = memory(asked.memory, description)?;
        let cells = compiled_cells(&description.name, description, memory).map_err(raised)?;
        let (mut kinds, mut notes) = (cells.kinds, cells.notes);
        let mut levels = Vec::new();
        for kind in &mut kinds {
            let Some(to) = to else {
                levels.push((kind.kernel.clone(), 1.0));
                continue;
            };
            let quantised = to.quantise(&kind.kernel, sum, asked.seed).map_err(raised)?;
            let erased = quantised.erasures(&kind.kernel).into_iter();
            let said = erased.map(|it| Warning::erased(&to.to_string(), it).to_string());
            notes.extend(said.map(|note| in_python(&note)));
            let quantised = quantised.within_one();
            kind.on /= quantised.scale;
            kind.off /= quantised.scale;
            kind.kernel = quantised.levels.clone();
            levels.push((quantised.levels, quantised.scale));
        }
        let first = [kinds[0].kernel.clone()];
        let mut request = Request::new(&first, &device).map_err(raised)?;
        (request.effort, request.seed) = (effort, asked.seed);
        request.objective = named(asked.objective)?;
        if asked.border {
            request.border = Border::Right;
        }
        let name = &description.name;
        let mut program = SensorProgram::new(&kinds, memory, name, &request).map_err(raised)?;
        let wrong = program.wrong_from_border(&device);
        if wrong > 0 {
            let (far, edge) = (counted(wrong, "pixel"), device.value(Figure::Edge));
            let within = format!("within {far} of the border");
            if asked.border && edge == 0.0 {
                return Err(refused(
                    format!("{name}: no program was found that is right {within}"),
                    "search longer (effort=…), ask for fewer kinds, take a chip with more registers (chip=\"scamp5-wide\"), or leave border=True out",
                ));
            }
            let within = match memory {
                // A wrong event renews the memory that its neighbours see.
                DriveMemory::Shared => {
                    format!("from the border inwards, by up to {far} further with each frame,")
                }
                DriveMemory::Analogue | DriveMemory::Bits(_) => within,
            };
            let way = if edge == 0.0 {
                "border=True asks for a program that is right there".to_owned()
            } else {
                format!(
                    "beyond the border registers of {} hold {edge} LSB (edge.analogue)",
                    device.name()
                )
            };
            notes.push(format!(
                "{name}: {within} events differ from those of a sensor that sees 0 beyond it, in exact arithmetic too; {way}"
            ));
        }
        if let Some(events) = asked.events {
            let readout = readout(&program, kinds.len(), events, &device)?;
            program.text = program.text_with(&kinds, name, &device, readout);
        }
        let compiled = Compiled::from_program(name, program, &device);
        let Compiled { program, expanded } = compiled.map_err(raised)?;
        Ok(Self {
            expanded,
            scale: program.scale(),
            text: program.text,
            device: asked.chip.to_owned(),
            levels,
            notes,
        })
    }
}

#[pymethods]
impl Chip {
    /// A program that was found before, on `chip`: what is written here is what getters gave.
    #[new]
    fn of_text(
        py: Python<'_>,
        title: &str,
        text: &str,
        chip: &str,
        scale: f64,
        levels: Vec<(PyReadonlyArray2<'_, f64>, f64)>,
        notes: Vec<String>,
    ) -> PyResult<Self> {
        let unread = |error| refused(error, "give the levels that a chip has told");
        let mut kernels = Vec::with_capacity(levels.len());
        for (rows, by) in levels {
            let rows: Vec<_> = rows
                .as_array()
                .outer_iter()
                .map(|row| row.to_vec())
                .collect();
            kernels.push((Kernel::from_rows(&rows).map_err(unread)?, by));
        }
        let expanded = pool::work(py, || {
            let device = Device::find(chip)?;
            Ok::<_, Report>(Expanded::from_text(title, text, &device)?)
        })?;
        Ok(Self {
            expanded: expanded.map_err(raised)?,
            text: text.to_owned(),
            device: chip.to_owned(),
            scale,
            levels: kernels,
            notes,
        })
    }

    /// The program.
    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    #[getter]
    fn title(&self) -> &str {
        &self.expanded.title
    }

    /// The chip, as it was asked for: a name, or a folder.
    #[getter]
    fn chip(&self) -> &str {
        &self.device
    }

    /// Instruction words of a frame.
    #[getter]
    fn words(&self) -> u64 {
        self.expanded.cost.words.0
    }

    /// Microseconds of a frame on the array, without readout.
    #[getter]
    fn array_us(&self) -> f64 {
        self.expanded.cost.array_us
    }

    /// LSB for each unit of level times light.
    #[getter]
    fn lsb(&self) -> f64 {
        self.scale
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// The levels of each kind, `(k, k)`, and what they are to be multiplied by.
    #[getter]
    fn levels<'py>(&self, py: Python<'py>) -> PyResult<Vec<(Bound<'py, PyArray2<f64>>, f64)>> {
        let levels = self.levels.iter();
        levels
            .map(|(kernel, scale)| Ok((plane(py, kernel.weights())?, *scale)))
            .collect()
    }

    /// The chip at this size as switched on.
    fn watch(
        &self,
        py: Python<'_>,
        size: (usize, usize),
        fps: f64,
        scale: f64,
        seed: u64,
        domain: &str,
        slots: bool,
        max_events: Option<usize>,
    ) -> PyResult<Run> {
        let arithmetic = arithmetic(domain)?.with_seed(seed);
        let size = Size::new(size.0, size.1);
        let made = pool::work(py, || {
            let chip = self
                .expanded
                .chip(arithmetic, size, self.expanded.settings())?;
            let channels = chip.channels();
            let sensor: Box<dyn Sensor + Send> = if slots {
                Box::new(chip)
            } else {
                Box::new(self.expanded.all_events(chip))
            };
            Ok::<_, DesignError>((sensor, channels))
        })?;
        let (sensor, channels) = made.map_err(raised)?;
        let watcher = Box::new(watcher::Events::new(sensor));
        let program = (&self.expanded.code, &self.expanded.device);
        let settings = self.expanded.settings();
        let guard = RunGuard::of_program(program, arithmetic, &settings, size, channels.into());
        Run::new(watcher, (size, channels), guard, fps, scale, max_events)
    }
}

/// A plane as an array of its own, `(H, W)`.
pub fn plane<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    plane: &amacrine::plane::Plane<T>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let (height, width) = plane.dim();
    let flat: Vec<T> = plane.iter().copied().collect();
    let array = flat.to_pyarray(py);
    array
        .reshape([height, width])
        .map_err(|_| refused("a plane has not as many numbers as its size", "report this"))
}

fn arithmetic(domain: &str) -> PyResult<Arithmetic> {
    domain.parse().map_err(|e: ArithmeticError| raised(e))
}

/// Refuses what cells of an array cannot hold.
#[pyfunction]
pub fn check_domain(domain: &str) -> PyResult<()> {
    arithmetic(domain).map(|_| ())
}
