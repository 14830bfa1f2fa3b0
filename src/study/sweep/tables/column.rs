//! Columns of the results that every study has.

/// What stands in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Text.
    Text,
    /// Whole numbers.
    Whole,
    /// Numbers.
    Real,
}

/// Its name, what stands in it, and what that is, with its unit.
pub type Fixed = (&'static str, Holds, &'static str);

pub(super) const fn text(name: &'static str, what: &'static str) -> Fixed {
    (name, Holds::Text, what)
}

pub(super) const fn whole(name: &'static str, what: &'static str) -> Fixed {
    (name, Holds::Whole, what)
}

pub(super) const fn real(name: &'static str, what: &'static str) -> Fixed {
    (name, Holds::Real, what)
}

/// What of a point a column says: sensors and tasks are told apart by it, and named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The light, of the task.
    Light,
    /// The receptive field and its thresholds: what a user chooses of a task as of a sensor.
    Field,
    /// What the f64 sensor of the task has of the sensor.
    Model,
    /// The task alone.
    Task,
    /// The sensor alone.
    Sensor,
    /// What neither is called by.
    Other,
}

impl Part {
    pub(in crate::study::sweep) const fn text(
        self,
        name: &'static str,
        what: &'static str,
    ) -> (Self, Fixed) {
        (self, text(name, what))
    }

    pub(in crate::study::sweep) const fn whole(
        self,
        name: &'static str,
        what: &'static str,
    ) -> (Self, Fixed) {
        (self, whole(name, what))
    }

    pub(in crate::study::sweep) const fn real(
        self,
        name: &'static str,
        what: &'static str,
    ) -> (Self, Fixed) {
        (self, real(name, what))
    }
}
