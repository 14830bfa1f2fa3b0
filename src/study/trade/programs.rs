//! The models of a program: those of the pilot, each in every schedule.

use std::fmt;

use crate::{
    array::Schedule,
    mosaic::{Mosaic, Outside},
    plane::Size,
    sensor::{Sensor, SensorError},
    study::pilot::{Chips, ErrorTerm, Look, Machine, estimate::Unseen, family::Family},
};

/// A program on an array, whose schedule is part of the model.
#[derive(Clone, Copy, Debug)]
pub struct Programs<'a> {
    /// The program and the array.
    pub chips: Chips<'a>,
    /// The schedule of the full model.
    pub schedule: Schedule,
}

/// An arithmetic of the array, and the order in which it is worked on.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// The arithmetic, with what it leaves out.
    pub machine: Machine,
    /// The order.
    pub schedule: Schedule,
    /// Whether that is another than the full model's.
    pub ordered: bool,
}

impl fmt::Display for Setup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.machine.fmt(f)?;
        if self.ordered {
            write!(f, ", {}", self.schedule)?;
        }
        Ok(())
    }
}

impl Programs<'_> {
    fn ordered(&self, schedule: Schedule) -> Chips<'_> {
        let mut chips = self.chips;
        chips.settings.schedule = Some(schedule);
        chips
    }

    fn setup(&self, machine: Machine, schedule: Schedule) -> Setup {
        Setup {
            machine,
            schedule,
            ordered: schedule != self.schedule,
        }
    }

    /// What is left out one at a time: the arithmetic for another, each error of analogue cells,
    /// and each arithmetic in the other schedule.
    #[must_use]
    pub fn models(&self, formats: &[crate::number::Format]) -> Vec<Setup> {
        let own = self.chips.candidates(formats).into_iter();
        let machines: Vec<Machine> = own.map(|(_, machine)| machine).collect();
        let other = match self.schedule {
            Schedule::Plain => Schedule::Tiled { rows: 0 },
            Schedule::Tiled { .. } => Schedule::Plain,
        };
        let whole = { machines.iter() }.filter(|machine| machine.without.is_empty());
        let reordered: Vec<Machine> = std::iter::once(self.chips.machine())
            .chain(whole.cloned())
            .collect();
        let same = machines.into_iter().map(|it| self.setup(it, self.schedule));
        same.chain(reordered.into_iter().map(|it| self.setup(it, other)))
            .collect()
    }

    /// Whether a model is another's alternative: of several numbers there is one.
    #[must_use]
    pub fn alternative(&self, model: &Setup) -> bool {
        model.ordered || model.machine.format != self.chips.machine().format
    }

    /// The order of work changes nothing.
    #[must_use]
    pub fn free(&self, model: &Setup) -> Option<&'static str> {
        (model.machine == self.chips.machine())
            .then_some("a schedule changes no event, only the time")
    }
}

impl Family for Programs<'_> {
    type Model = Setup;

    fn full(&self) -> Setup {
        self.setup(self.chips.machine(), self.schedule)
    }

    fn halo(&self) -> Result<usize, &'static str> {
        self.chips.halo()
    }

    fn outside(&self) -> Outside {
        self.chips.outside()
    }

    fn is_relative(&self) -> bool {
        self.chips.is_relative()
    }

    fn fires_alone(&self) -> bool {
        self.chips.fires_alone()
    }

    fn sees_inserted(&self, model: &Setup) -> bool {
        self.chips.sees_inserted(&model.machine)
    }

    fn on_tiles(
        &self,
        model: &Setup,
        mosaic: &Mosaic,
    ) -> Result<Box<dyn Sensor + Send>, SensorError> {
        self.ordered(model.schedule)
            .on_tiles(&model.machine, mosaic)
    }

    fn unseen(&self, model: &Setup, look: &Look) -> Unseen {
        self.chips.unseen(&model.machine, look)
    }

    fn together(&self, models: &[Setup]) -> Option<Setup> {
        let schedule = models.iter().find(|model| model.ordered);
        let schedule = schedule.map_or(self.schedule, |model| model.schedule);
        let machines: Vec<Machine> = models.iter().map(|model| model.machine.clone()).collect();
        let machine = self.chips.together(&machines)?;
        Some(self.setup(machine, schedule))
    }

    fn whole(&self, model: &Setup, size: Size) -> Result<Box<dyn Sensor + Send>, SensorError> {
        self.ordered(model.schedule).whole(&model.machine, size)
    }

    fn on_the_whole(
        &self,
        model: &Setup,
        size: Size,
    ) -> Option<Result<Box<dyn Sensor + Send>, SensorError>> {
        Some(self.whole(model, size))
    }

    fn loses(&self, size: Size) -> Option<&'static str> {
        self.chips.loses(size)
    }

    fn parts(&self, size: Size) -> usize {
        self.chips.parts(size)
    }
}

impl Setup {
    /// What analogue cells do without.
    #[must_use]
    pub fn without(&self) -> &[ErrorTerm] {
        &self.machine.without
    }
}
