//! A program on an array: a sensor.
//!
//! Light comes in frame by frame. Before a body runs, the photodiodes hold
//! `PIX = reset level + gain · light`, one whole exposure; `rpix` takes them back to the reset
//! level. With the default gain of 1/2, the vendor's `get_image(y)`, which subtracts the reset
//! level, gives `y = light / 2`, the half range 0 to 127.5.
//!
//! The first frame runs the program's `init`, every later one its `frame`.

use super::{
    BitPlane, CodeError, Converters, Domain, Layout, Ledger, Reading, Scan, Schedule, Settings,
    State, Undecided,
    active::{Active, Item},
    check,
    cone::{self, Cone},
    host, logic, rows,
    schedule::Plan,
    segment::Segment,
    semantics::Array as Meaning,
};
use crate::{
    event::{Event, Packet, Polarity},
    isa::{Analog, Device, Digital, Primitive},
    photoreceptor::LightError,
    plane::{Plane, Size},
    program::{Action, Cell, Code, Effect, Host, Step},
    scene::Frame,
    sensor::{Sensor, SensorError, brightest, check_time, light_error},
    unit::Micros,
};

/// A plane of another size than the array.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("a plane of {got} on an array of {want}")]
#[diagnostic(help("give a plane of the size of the array"))]
pub struct ShapeError {
    /// The plane's size.
    pub got: Size,
    /// The array's size.
    pub want: Size,
}

/// A program stopped.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("line {line}: `{operation}` has no answer in the domain {domain}")]
#[diagnostic(help(
    "here it depends on the light; run the program in a domain of numbers, such as exact"
))]
pub struct RunError {
    /// Line of the program text, from 1.
    pub line: u32,
    /// Which instruction.
    pub operation: &'static str,
    /// Which domain.
    pub domain: String,
}

/// A program on an array in one domain.
#[derive(Clone, Debug)]
pub struct Chip<D: Domain> {
    name: String,
    domain: D,
    device: Device,
    settings: Settings,
    code: Code,
    state: State<D::Cell>,
    channels: u8,
    /// Time of the last frame watched, in seconds.
    watched: Option<f64>,
    /// Seconds since each one-bit register was written.
    idle: Vec<f64>,
    /// Words since power-on.
    step: u64,
    ledger: Ledger,
    readings: Vec<Reading>,
    plan: Plan<D::Cell>,
    active: Option<Active<D::Cell>>,
    /// While a body is gone through whose words have run already: how often the host has
    /// looked at the array.
    looks: Option<usize>,
}

/// An array whose domain was chosen at run time.
pub trait Array: Sensor {
    /// The name of its domain.
    fn domain(&self) -> String;

    /// The chip.
    fn device(&self) -> &Device;

    /// Its registers and size.
    fn layout(&self) -> Layout;

    /// Chooses how the array is walked, and by how many threads at most; what it computes
    /// is the same to the bit.
    fn set_schedule(&mut self, schedule: Schedule, threads: usize);

    /// How the array is walked.
    fn schedule(&self) -> Schedule;

    /// Sets an analogue register, in LSB; never clipped.
    ///
    /// # Errors
    /// When the plane has another size.
    fn set_analog(&mut self, register: Analog, values: &Plane<f64>) -> Result<(), ShapeError>;

    /// Sets a one-bit register, whatever R0 is.
    ///
    /// # Errors
    /// When the plane has another size.
    fn set_digital(&mut self, register: Digital, bits: &Plane<bool>) -> Result<(), ShapeError>;

    /// Sets FLAG.
    ///
    /// # Errors
    /// When the plane has another size.
    fn set_flag(&mut self, bits: &Plane<bool>) -> Result<(), ShapeError>;

    /// An analogue register, in LSB, without loss.
    fn analog(&self, register: Analog) -> Plane<f64>;

    /// A one-bit register.
    fn digital(&self, register: Digital) -> Plane<bool>;

    /// FLAG.
    fn flag(&self) -> Plane<bool>;

    /// Lets light fall on the photodiodes for one exposure.
    ///
    /// # Errors
    /// When the picture has another size.
    fn expose(&mut self, light: &Plane<f64>) -> Result<(), ShapeError>;

    /// Runs `init` once; events are stamped with `t`.
    ///
    /// # Errors
    /// When the domain has no answer for an instruction.
    fn run_init(&mut self, t: Micros, packet: &mut Packet) -> Result<(), RunError>;

    /// Runs `frame` once; events are stamped with `t`.
    ///
    /// # Errors
    /// When the domain has no answer for an instruction.
    fn run_frame(&mut self, t: Micros, packet: &mut Packet) -> Result<(), RunError>;

    /// Runs these steps now, as a kernel of their own; what was read before is kept.
    ///
    /// # Errors
    /// When the domain has no answer for an instruction.
    ///
    /// # Panics
    /// When a step names a register that the array does not have; steps of its own program
    /// never do.
    fn run_steps(&mut self, steps: &[Step], t: Micros, packet: &mut Packet)
    -> Result<(), RunError>;

    /// Forgets what was read before, as each frame does.
    fn begin_frame(&mut self);

    /// Lets some seconds pass: registers decay, where the domain has it.
    fn wait(&mut self, seconds: f64);

    /// The photodiodes, in LSB.
    fn pix(&self) -> Plane<f64>;

    /// What was done since power-on.
    fn ledger(&self) -> Ledger;

    /// What the host read during the last body that ran.
    fn readings(&self) -> &[Reading];
}

impl<D: Domain> Chip<D> {
    /// A chip as switched on: every register 0, FLAG 1.
    ///
    /// # Errors
    /// When the program cannot run on an array of this layout and size.
    pub fn new(
        name: &str,
        domain: D,
        code: Code,
        device: &Device,
        size: Size,
        settings: Settings,
    ) -> Result<Self, CodeError> {
        let layout = Layout::of(device, size);
        check(&code, &layout)?;
        let mut state = State::new(&domain, layout, settings.edge);
        // Switched on in the dark.
        state.pix.fill(domain.hold(settings.reset_level));
        Ok(Self {
            name: name.into(),
            state,
            channels: channels(&code.init).max(channels(&code.frame)).max(1),
            domain,
            device: device.clone(),
            settings,
            code,
            watched: None,
            idle: vec![0.0; layout.digital.into()],
            step: 0,
            ledger: Ledger::default(),
            readings: Vec::new(),
            plan: Plan::new(Schedule::of(size), rayon::current_num_threads()),
            active: None,
            looks: None,
        })
    }

    /// All registers.
    #[must_use]
    pub fn state(&self) -> &State<D::Cell> {
        &self.state
    }

    /// The arithmetic.
    #[must_use]
    pub fn domain(&self) -> &D {
        &self.domain
    }

    /// What the sources leave open.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    fn run(&mut self, body: &[Step], t: Micros, packet: &mut Packet) -> Result<(), RunError> {
        let mut segment = Segment::new(&self.state);
        self.body(body, &mut segment, t, packet)?;
        self.flush(&mut segment)
    }

    fn body<'a>(
        &mut self,
        body: &'a [Step],
        segment: &mut Segment<'a, D::Cell>,
        t: Micros,
        packet: &mut Packet,
    ) -> Result<(), RunError> {
        let mut launched = false;
        for step in body {
            let word = matches!(step.action, Action::Word(_));
            self.ledger.launches += u64::from(word && !launched);
            launched = word;
            match &step.action {
                Action::Word(word) => {
                    self.ledger.word(word, &self.device);
                    if self.looks.is_some() {
                        // It has run.
                    } else if let Primitive::Prop { boundary } = word {
                        self.flush(segment)?;
                        logic::propagate(&mut self.state, self.settings.propagation, *boundary);
                    } else {
                        segment.push(word, self.step, step.line);
                        if segment.is_full() {
                            self.flush(segment)?;
                        }
                    }
                    self.step += 1;
                }
                Action::Host(operation) => {
                    self.ledger.host(operation, &self.device);
                    let input = cone::is_input(operation);
                    if !input {
                        self.flush(segment)?;
                    }
                    self.look(cone::looked_at(operation).is_some());
                    self.host(operation, step.line, t, packet);
                    self.look(cone::looked_at(operation).is_some());
                    if input {
                        segment.input(&self.state);
                    }
                }
                Action::Repeat { times, body } => {
                    for _ in 0..*times {
                        self.body(body, segment, t, packet)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Runs a body for a frame.
    fn frame(&mut self, body: &[Step], t: Micros, packet: &mut Packet) -> Result<(), RunError> {
        let exposed = |active: &&mut Active<_>| active.unseen().is_some();
        let Some(active) = self.active.as_mut().filter(exposed) else {
            self.forget();
            return self.run(body, t, packet);
        };
        let mut items = Vec::new();
        flat(&self.domain, &self.settings.converters, body, &mut items);
        let meaning = Meaning {
            domain: &self.domain,
            settings: &self.settings,
        };
        let result = active.frame(meaning, &mut self.plan, &mut self.state, &items);
        result.map_err(|error| stopped(&self.domain, error))?;
        self.looks = Some(0);
        let result = self.run(body, t, packet);
        self.looks = None;
        result
    }

    /// Where words have run already: shows the host what a register held, or takes it back.
    fn look(&mut self, looks: bool) {
        if let (Some(twice), Some(active), true) = (&mut self.looks, &mut self.active, looks) {
            active.swap(*twice / 2, &mut self.state);
            *twice += 1;
        }
    }

    /// Something else than frames has changed the array: nothing is as it was.
    fn forget(&mut self) {
        if let Some(active) = &mut self.active {
            if let Some(light) = active.unseen() {
                self.state.pix.clone_from_slice(light);
            }
            active.forget();
        }
    }

    /// Runs the words that wait.
    fn flush(&mut self, segment: &mut Segment<'_, D::Cell>) -> Result<(), RunError> {
        let meaning = Meaning {
            domain: &self.domain,
            settings: &self.settings,
        };
        let result = self.plan.run(meaning, &mut self.state, segment);
        segment.clear();
        result.map_err(|error| stopped(&self.domain, error))
    }

    fn host(&mut self, operation: &Host, line: u32, t: Micros, packet: &mut Packet) {
        let mut scan = |source, polarity, channel, slots, from_left, from_bottom| {
            let bits = self.state.digital(source);
            let scan = Scan::new(bits, self.state.layout.size, slots, from_left, from_bottom);
            self.ledger.events += scan.found.len() as u64;
            self.ledger.missed += scan.missed;
            self.ledger.ambiguous += u64::from(scan.ambiguous);
            deliver(&scan, polarity, channel, t, packet);
        };
        match *operation {
            Host::ScanEvents {
                source,
                polarity,
                channel,
                slots,
            } => scan(source, polarity, channel, slots, false, false),
            Host::ScanEventsFrom {
                source,
                polarity,
                channel,
                slots,
                columns_reversed,
                rows_reversed,
            } => scan(
                source,
                polarity,
                channel,
                slots,
                columns_reversed,
                rows_reversed,
            ),
            _ => {
                let values = host::execute(
                    &self.domain,
                    &self.settings.converters,
                    &mut self.state,
                    operation,
                );
                let reading = values.map(|values| Reading { line, values });
                self.readings.extend(reading);
            }
        }
    }

    /// Analogue registers some seconds later.
    fn age(&mut self, seconds: f64) {
        for plane in &mut self.state.analog {
            for cell in plane.iter_mut() {
                match self.domain.aged(cell, seconds) {
                    Some(aged) => *cell = aged,
                    None => return,
                }
            }
        }
    }

    /// One-bit registers some seconds later: what was not written for too long reads 0.
    fn fade(&mut self, seconds: f64) {
        let Some(retention) = self.domain.retention() else {
            return;
        };
        for (register, idle) in (0..).map(Digital).zip(&mut self.idle) {
            *idle += seconds;
            if *idle > retention {
                let held = |pixel| self.domain.holds(register, pixel, *idle);
                self.state.fade(register, held);
            }
        }
    }

    /// These registers are as new.
    fn refresh(&mut self, body: &[Step]) {
        if self.domain.retention().is_none() {
            return;
        }
        for cell in Effect::of(body, &self.device).writes {
            if let Cell::Digital(register) = cell
                && let Some(idle) = self.idle.get_mut(usize::from(register.0))
            {
                *idle = 0.0;
            }
        }
    }

    /// Whether the photodiodes can hold light of this size: in floats, what they cannot becomes
    /// infinite, and its difference from anything is no number.
    fn holds(&self, frame: &Frame, most: f64) -> Result<(), SensorError> {
        let Settings {
            gain, reset_level, ..
        } = self.settings;
        let held = |light: f64| {
            let most = reset_level.abs() + (gain * light).abs();
            self.domain.value(&self.domain.hold(most)).is_finite()
        };
        if held(most) {
            return Ok(());
        }
        let beyond = |light| (!held(light)).then_some(LightError::Beyond(light));
        Err(light_error(frame, beyond))
    }

    fn fits<T>(&self, plane: &Plane<T>) -> Result<(), ShapeError> {
        let (got, want) = (Size::of(plane), self.state.layout.size);
        if got == want {
            Ok(())
        } else {
            Err(ShapeError { got, want })
        }
    }
}

fn stopped<D: Domain>(domain: &D, (line, undecided): (u32, Undecided)) -> RunError {
    RunError {
        line,
        operation: undecided.operation,
        domain: domain.name(),
    }
}

/// A body without its loops.
fn flat<'a, D: Domain>(
    domain: &D,
    converters: &Converters,
    body: &'a [Step],
    items: &mut Vec<Item<'a, D::Cell>>,
) {
    for step in body {
        match &step.action {
            Action::Word(word) => items.push(Item::Word(word, step.line)),
            Action::Host(operation) => {
                let input = host::input(domain, converters, operation).map(Item::Input);
                let look = cone::looked_at(operation).map(Item::Look);
                items.extend(input.or(look));
            }
            Action::Repeat { times, body } => {
                for _ in 0..*times {
                    flat(domain, converters, body, items);
                }
            }
        }
    }
}

fn deliver(scan: &Scan, polarity: Polarity, channel: u8, t: Micros, packet: &mut Packet) {
    packet.dropped.no_slot += scan.missed;
    packet.events.extend(scan.found.iter().map(|at| Event {
        t,
        x: at.x as u16,
        y: at.y as u16,
        polarity,
        channel,
    }));
}

/// One more than the highest channel that a body reads out.
fn channels(body: &[Step]) -> u8 {
    let of = |step: &Step| match &step.action {
        Action::Host(Host::ScanEvents { channel, .. } | Host::ScanEventsFrom { channel, .. }) => {
            channel.saturating_add(1)
        }
        Action::Host(_) | Action::Word(_) => 0,
        Action::Repeat { body, .. } => channels(body),
    };
    body.iter().map(of).max().unwrap_or(0)
}

impl<D: Domain> Array for Chip<D> {
    fn domain(&self) -> String {
        self.domain.name()
    }

    fn device(&self) -> &Device {
        &self.device
    }

    fn layout(&self) -> Layout {
        self.state.layout
    }

    fn set_schedule(&mut self, schedule: Schedule, threads: usize) {
        self.forget();
        self.plan = Plan::new(schedule, threads);
        let small = schedule == Schedule::Active && self.domain.is_steady();
        let cone = small.then(|| Cone::of(&self.code.frame, &self.device));
        let size = self.state.layout.size;
        self.active = cone.flatten().map(|cone| Active::new(size, cone));
    }

    fn schedule(&self) -> Schedule {
        self.plan.schedule()
    }

    fn set_analog(&mut self, register: Analog, values: &Plane<f64>) -> Result<(), ShapeError> {
        self.fits(values)?;
        self.forget();
        let cells = self.state.analog_mut(register).iter_mut();
        for (cell, value) in cells.zip(values) {
            *cell = self.domain.hold(*value);
        }
        Ok(())
    }

    fn set_digital(&mut self, register: Digital, bits: &Plane<bool>) -> Result<(), ShapeError> {
        self.fits(bits)?;
        self.forget();
        let words = self.state.digital_mut(register).words_mut();
        words.copy_from_slice(BitPlane::from_plane(bits).words());
        Ok(())
    }

    fn set_flag(&mut self, bits: &Plane<bool>) -> Result<(), ShapeError> {
        self.fits(bits)?;
        self.forget();
        self.state.flag = BitPlane::from_plane(bits);
        Ok(())
    }

    fn analog(&self, register: Analog) -> Plane<f64> {
        self.state.values(&self.domain, register)
    }

    fn digital(&self, register: Digital) -> Plane<bool> {
        self.state.digital(register).to_plane()
    }

    fn flag(&self) -> Plane<bool> {
        self.state.flag.to_plane()
    }

    fn expose(&mut self, light: &Plane<f64>) -> Result<(), ShapeError> {
        self.fits(light)?;
        let light = light.as_standard_layout();
        let light = light.as_slice().unwrap_or_default();
        if let Some(active) = &mut self.active {
            active.expose(&self.domain, &self.settings, light);
            return Ok(());
        }
        let Settings {
            gain, reset_level, ..
        } = self.settings;
        rows::expose(&self.domain, reset_level, gain, light, &mut self.state.pix);
        Ok(())
    }

    fn run_init(&mut self, t: Micros, packet: &mut Packet) -> Result<(), RunError> {
        self.begin_frame();
        let body = std::mem::take(&mut self.code.init);
        let result = self.run_steps(&body, t, packet);
        self.code.init = body;
        result
    }

    fn run_frame(&mut self, t: Micros, packet: &mut Packet) -> Result<(), RunError> {
        self.begin_frame();
        let body = std::mem::take(&mut self.code.frame);
        self.refresh(&body);
        let result = self.frame(&body, t, packet);
        self.code.frame = body;
        result
    }

    fn run_steps(
        &mut self,
        steps: &[Step],
        t: Micros,
        packet: &mut Packet,
    ) -> Result<(), RunError> {
        self.forget();
        // Steps that are not the chip's own may lie where others lay before.
        self.plan.forget();
        self.refresh(steps);
        self.run(steps, t, packet)
    }

    fn begin_frame(&mut self) {
        self.readings.clear();
    }

    fn wait(&mut self, seconds: f64) {
        // Where nothing decays there is nothing to forget, and the next frame stays small.
        if !self.domain.is_steady() {
            self.forget();
        }
        self.age(seconds);
        self.fade(seconds);
    }

    fn pix(&self) -> Plane<f64> {
        let unseen = self.active.as_ref().and_then(Active::unseen);
        self.state.light(&self.domain, unseen)
    }

    fn ledger(&self) -> Ledger {
        self.ledger
    }

    fn readings(&self) -> &[Reading] {
        &self.readings
    }
}

impl<D: Domain> Sensor for Chip<D> {
    fn name(&self) -> &str {
        &self.name
    }

    fn size(&self) -> Size {
        self.state.layout.size
    }

    fn channels(&self) -> u8 {
        self.channels
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        check_time(frame, self.watched)?;
        self.holds(frame, brightest(frame)?)?;
        self.expose(&frame.light)
            .map_err(|error| SensorError::Size {
                index: frame.index,
                got: error.got,
                want: error.want,
            })?;
        let t = Micros::from_seconds(frame.seconds);
        let result = if let Some(before) = self.watched.replace(frame.seconds) {
            self.wait(frame.seconds - before);
            self.run_frame(t, packet)
        } else {
            packet.span.0 = t;
            self.run_init(t, packet)
        };
        packet.span.1 = t;
        result.map_err(|error| SensorError::Stopped {
            sensor: self.name.clone(),
            why: error.to_string(),
        })
    }
}
