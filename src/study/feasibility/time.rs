//! How long a frame takes, and how many a second that allows.

use super::{
    Question,
    estimate::Estimate,
    named::Named,
    readout::{ReadoutOrder, ReadoutPlan, plans},
};
use crate::{
    isa::{Device, Evidence, Figure, FigureError},
    program::{
        Cost, Step,
        readout::{Demand, Scans, Way},
    },
    study::design::Compiled,
    unit::Micros,
};

/// A frame's time, part by part, and how many frames a second that allows.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Time {
    /// Words at the chip's clock, up to what they take with their launches.
    pub array: Estimate,
    /// The readout, as the cheapest plan that loses nothing has it.
    pub readout: Estimate,
    /// Which plan that is.
    pub plan: Way,
    /// All plans that were weighed.
    pub plans: Vec<ReadoutPlan>,
    /// The readout, with all slots that the program asks for.
    pub readout_as_programmed: Estimate,
    /// Whether the next frame is exposed while events are read.
    pub order: ReadoutOrder,
    /// Slots that the program asks for, for each sign.
    pub slots: u64,
    /// Slots that the busiest frame of the scene needs.
    pub slots_of_scene: u64,
    /// Exposure, where one was given.
    pub exposure: Option<Estimate>,
    /// Frames a second at most, read by the plan.
    pub ceiling: Estimate,
    /// Frames a second at most, with all slots that the program asks for.
    pub ceiling_as_programmed: Estimate,
    /// What takes longest.
    pub binds: Binds,
    /// The longest exposure that leaves the rate that was asked for; none where there is none.
    pub longest_exposure_us: Option<f64>,
}

/// What a frame rate is limited by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Binds {
    /// Instruction words.
    Array,
    /// Events leaving the chip.
    Readout,
    /// Light.
    Exposure,
}

/// The words of a frame, of which the array's time is made.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FrameWords {
    /// How many.
    pub count: f64,
    /// Their time without launches, at the clock of the chip's data, us.
    us: f64,
    /// Kernels that the host launches.
    launches: f64,
    /// The clock in the chip's data, MHz.
    clock: f64,
    /// Between which values clock and launch lie.
    clocks: [f64; 2],
    launch: [f64; 2],
    /// Whether nobody says how many words a launch carries, so that each may take one.
    is_unknown: bool,
    /// The words of each instruction.
    each: Vec<Named>,
}

/// What the words of a frame take: from the chip's highest clock to what their launches may take
/// besides.
///
/// # Errors
/// Never for a chip that was loaded.
pub fn of_array(frame: &[Step], device: &Device) -> Result<Estimate, FigureError> {
    Ok(FrameWords::new(frame, device)?.estimate(device))
}

/// The least and the most of that, in us.
///
/// # Errors
/// Never for a chip that was loaded.
pub fn array_us(frame: &[Step], device: &Device) -> Result<[f64; 2], FigureError> {
    Ok(FrameWords::new(frame, device)?.ends())
}

impl FrameWords {
    /// Of a frame's program.
    ///
    /// # Errors
    /// Never for a chip that was loaded.
    pub fn new(frame: &[Step], device: &Device) -> Result<Self, FigureError> {
        let cost = |launch| {
            let chip = device.clone().what_if(Figure::Launch, launch)?;
            Ok::<_, FigureError>(Cost::of(frame, &chip))
        };
        let (without, with) = (cost(0.0)?, cost(1.0)?);
        let launch = Named::Figure(Figure::Launch);
        Ok(Self {
            count: without.words.0 as f64,
            us: without.array_us,
            launches: with.array_us - without.array_us,
            clock: device.value(Figure::Clock),
            clocks: Named::Figure(Figure::Clock).ends(device),
            launch: launch.ends(device),
            is_unknown: launch.interval(device).is_some(),
            each: Named::words_of(frame),
        })
    }

    /// The least and the most that they take.
    fn ends(&self) -> [f64; 2] {
        let [slow, fast] = self.clocks;
        let [least, most] = self.launch;
        let low = self.us * (self.clock / fast) + self.launches * least;
        let high = if self.is_unknown {
            // The launch was bounded together with a word at the highest clock.
            self.us * (self.clock / fast) + self.count * most
        } else {
            self.us * (self.clock / slow) + self.launches * most
        };
        [low, high.max(self.us * (self.clock / slow))]
    }

    /// Their time on a chip of these data.
    fn estimate(&self, device: &Device) -> Estimate {
        let (clock, launch) = (device.figure(Figure::Clock), device.figure(Figure::Launch));
        Estimate::between(
            self.ends(),
            "us",
            Evidence::Measured,
            format!(
                "from words / {} MHz ({}) to a launch of {} us ({}) with every word",
                clock.ends()[1],
                clock.source,
                launch.ends()[1],
                launch.source
            ),
        )
        .made_of(device, &[Figure::Clock, Figure::Launch].map(Named::Figure))
        .made_of(device, &self.each)
    }

    /// Their time on a chip of this clock and launch, us.
    pub fn us(&self, clock: f64, launch: f64) -> f64 {
        let each = if self.is_unknown {
            self.count
        } else {
            self.launches
        };
        let [_, most] = self.ends();
        (self.us * (self.clock / clock) + each * launch).min(most)
    }
}

/// What a time is made of.
pub(super) struct Parts<'a> {
    /// The words of a frame.
    pub words: FrameWords,
    /// What is read out.
    pub scans: Scans,
    /// How many events there are to read.
    pub busy: &'a Demand,
    /// Where one was given.
    pub exposure: Option<Micros>,
    /// Whether the next frame is exposed meanwhile.
    pub order: ReadoutOrder,
    /// Frames a second that were asked for.
    pub fps: f64,
    /// The chip on which the program is to run.
    pub device: &'a Device,
}

impl Time {
    /// Of all its parts.
    pub(super) fn new(parts: &Parts<'_>) -> Self {
        let Parts { device, order, .. } = parts;
        let (device, order) = (*device, *order);
        let array = parts.words.estimate(device);
        let exposure = parts.exposure.map(|exposure| {
            Estimate::one(
                exposure.0 as f64,
                "us",
                Evidence::Guess,
                "given with the question",
            )
        });
        let light = exposure.as_ref().map_or(0.0, |exposure| exposure.high);
        let ceiling = |readout: &Estimate| {
            let frame = |array, readout| 1e6 / order.frame(light, array, readout);
            let ends = [
                frame(array.high, readout.high),
                frame(array.low, readout.low),
            ];
            let formula = match order {
                ReadoutOrder::Overlapped => "1 / the longer of exposure, and array then readout",
                ReadoutOrder::Sequential => "1 / (the longer of exposure and array, then readout)",
            };
            let rate = Estimate::between(ends, "frames/s", Evidence::Measured, formula);
            let rate = rate.with(&array).with(readout);
            exposure.iter().fold(rate, Estimate::with)
        };
        let plans = plans(&parts.scans, parts.busy, device, ceiling);
        let as_programmed = &plans[0];
        let chosen = plans.iter().find(|plan| plan.is_chosen);
        let chosen = chosen.unwrap_or(as_programmed);
        let readout = chosen.time.clone();
        let first = match order {
            ReadoutOrder::Overlapped => array.high + readout.high,
            ReadoutOrder::Sequential => array.high,
        };
        let binds = if light > first && (light > readout.high || order == ReadoutOrder::Overlapped)
        {
            Binds::Exposure
        } else if readout.high >= array.high {
            Binds::Readout
        } else {
            Binds::Array
        };
        let period = 1e6 / parts.fps;
        let longest = match order {
            ReadoutOrder::Overlapped => period,
            ReadoutOrder::Sequential => period - readout.high,
        };
        Self {
            ceiling: chosen.frames_s.clone(),
            ceiling_as_programmed: as_programmed.frames_s.clone(),
            readout_as_programmed: as_programmed.time.clone(),
            order,
            slots: parts.scans.slots,
            slots_of_scene: parts.busy.busiest().clamp(1, parts.scans.slots.max(1)),
            binds,
            longest_exposure_us: (period >= array.high + readout.high).then_some(longest),
            plan: chosen.plan,
            readout,
            plans,
            exposure,
            array,
        }
    }
}

/// A frame's time on a scene of so many rows and frames a second, and events.
///
/// # Errors
/// Never for a chip that was loaded.
pub(super) fn time(
    question: &Question<'_>,
    program: &Compiled,
    busy: &Demand,
    (rows, fps): (usize, f64),
) -> Result<Time, FigureError> {
    let frame = &program.code.frame;
    Ok(Time::new(&Parts {
        words: FrameWords::new(frame, question.device)?,
        scans: Scans::new(frame, question.device).with_rows(rows),
        busy,
        exposure: question.exposure,
        order: question.order,
        fps,
        device: question.device,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Packet, plane::Size};

    /// Of 190 words and slots that nobody needs.
    fn time(exposure: Option<u64>, order: ReadoutOrder, fps: f64) -> Time {
        let device = Device::scamp5();
        let busy = Demand::new(&Packet::new(Size::new(64, 64), 1), 2);
        Time::new(&Parts {
            words: FrameWords {
                count: 190.0,
                us: 19.0,
                launches: 1.0,
                clock: 10.0,
                clocks: [9.0, 10.0],
                launch: [0.0, 0.23],
                is_unknown: true,
                each: Vec::new(),
            },
            scans: Scans {
                count: 2,
                slots: 4000,
                rest: Vec::new(),
                rows: 64,
            },
            busy: &busy,
            exposure: exposure.map(Micros),
            order,
            fps,
            device: &device,
        })
    }

    #[track_caller]
    fn near(got: f64, want: f64) {
        assert!((got / want - 1.0).abs() < 1e-9, "{got}, not {want}");
    }

    #[test]
    fn the_array_s_time_goes_from_the_peak_clock_to_the_bound_with_launches() {
        let time = time(None, ReadoutOrder::Overlapped, 100.0);
        near(time.array.low, 19.0);
        near(time.array.high, 0.33 * 190.0);
        assert_eq!(time.array.evidence, Evidence::Guess);
        assert_eq!(time.array.inputs, ["clock.rate", "clock.launch"]);
    }

    #[test]
    fn a_drawn_chip_lies_between() {
        let words = FrameWords::new(&[], &Device::scamp5()).unwrap();
        let words = FrameWords {
            count: 190.0,
            us: 19.0,
            launches: 1.0,
            ..words
        };
        near(words.us(10.0, 0.0), 19.0);
        near(words.us(9.5, 0.1), 20.0 + 19.0);
        near(words.us(9.0, 0.23), 0.33 * 190.0);
    }

    #[test]
    fn one_slot_for_each_sign_is_all_that_silence_needs() {
        let time = time(None, ReadoutOrder::Overlapped, 100.0);
        assert_eq!((time.slots, time.slots_of_scene), (4000, 1));
        assert_eq!(time.plan, Way::BusiestFrame);
        near(time.readout.high, 1.82);
        near(time.readout_as_programmed.high, 7280.0);
        near(time.ceiling.low, 1e6 / (62.7 + 1.82));
        near(time.ceiling.high, 1e6 / (19.0 + 0.6));
        near(time.ceiling_as_programmed.low, 1e6 / (62.7 + 7280.0));
    }

    #[test]
    fn exposure_runs_beside_what_the_order_says() {
        use ReadoutOrder::{Overlapped, Sequential};
        let dark = time(Some(4000), Overlapped, 100.0);
        near(dark.ceiling.low, 250.0);
        near(dark.ceiling.high, 250.0);
        assert_eq!(dark.binds, Binds::Exposure);
        assert_eq!(dark.longest_exposure_us, Some(10_000.0));
        let one_by_one = time(Some(4000), Sequential, 100.0);
        near(one_by_one.ceiling.low, 1e6 / (4000.0 + 1.82));
        near(one_by_one.longest_exposure_us.unwrap(), 10_000.0 - 1.82);
        // Shorter than the array's own time: it costs nothing.
        let bright = time(Some(3), Overlapped, 100.0);
        assert_eq!(
            bright.ceiling.ends(),
            time(None, Overlapped, 100.0).ceiling.ends()
        );
        assert_eq!(bright.binds, Binds::Array);
        assert_eq!(time(None, Overlapped, 1e5).longest_exposure_us, None);
    }
}
