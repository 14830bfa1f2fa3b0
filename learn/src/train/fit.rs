//! Which arms the chip has a program of, and why it has none of others.

use amacrine::photoreceptor::{Curve, Response};

use crate::{
    arm::{Arm, Start},
    task::Task,
};

/// Why the chip has no program of an arm, whatever it learns; `None` where it may have one, and of arms
/// without events.
#[must_use]
pub fn no_program(task: &Task, arm: &Arm) -> Option<String> {
    let cells = arm.cells()?;
    let mut why = if cells.kinds > 1 {
        format!(
            "it has {} kinds of cells, and programs are made of one",
            cells.kinds
        )
    } else if cells.pattern {
        "its kernels alternate in a 2x2 pattern, and all pixels of the chip work on the same words"
            .to_owned()
    } else if matches!(cells.start, Start::Mesh(_)) {
        "its surround is made by resistors, and not by a program".to_owned()
    } else if cells.log {
        "its response is logarithmic, and the chip sees light as it is".to_owned()
    } else if white(task.sensor.response).is_none() {
        format!(
            "the task's sensors have a response of `{}`, and the chip sees light as it is",
            word(task.sensor.response)
        )
    } else if task.sensor.refractory_us > 0.0 {
        "the task has a refractory period, and programs have none".to_owned()
    } else {
        return None;
    };
    if cells.few.is_some() && task.chip.is_some() {
        why.push_str("; it is trained without the chip in the loop");
    }
    Some(format!("no program: {why}"))
}

/// The light that makes a signal of 1; `None` where the signal is not a multiple of the light.
pub(super) const fn white(response: Response) -> Option<f64> {
    match response.curve {
        Curve::Identity => Some(1.0),
        Curve::Linear { white } => Some(white),
        Curve::Log { .. } | Curve::LinLog { .. } => None,
    }
}

const fn word(response: Response) -> &'static str {
    match response.curve {
        Curve::Identity => "identity",
        Curve::Linear { .. } => "linear",
        Curve::Log { .. } => "log",
        Curve::LinLog { .. } => "lin-log",
    }
}
