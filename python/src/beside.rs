//! A program whose host runs beside the array.

use std::sync::Arc;

use amacrine::{
    array::{Array, Register, answered},
    event::Packet,
    program::{Answer, Beside, Exposure, Step},
    study::saturation::Saturation,
    unit::Micros,
};
use miette::Report;
use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::{
    error::raised,
    program::{Light, begin},
};

/// The array and its light, as the host sees them.
pub struct Companion<'a> {
    pub chip: &'a mut (dyn Array + Send),
    pub light: &'a Light<'a>,
    pub packet: &'a mut Packet,
    /// Registers that are looked at after every frame, and what they held.
    pub kept: &'a [Register],
    pub films: &'a mut [Vec<f64>],
    /// What is seen of registers at the end of their range.
    pub saturation: &'a mut Saturation,
    pub pool: Arc<ThreadPool>,
    /// Frames that have begun.
    pub begun: usize,
    pub t: Micros,
    /// What is done with the photodiodes.
    pub exposure: Exposure,
    /// Whether the light has ended.
    pub dark: bool,
    /// What the host wrote, and in which frame.
    pub posts: Vec<(usize, String)>,
    pub stopped: Option<PyErr>,
}

impl Companion<'_> {
    /// Looks at the registers after a frame.
    pub fn end_frame(&mut self) {
        if self.begun == 0 {
            return;
        }
        for (register, film) in self.kept.iter().zip(&mut *self.films) {
            film.extend(register.values(self.chip));
        }
        self.saturation.frame(self.chip);
    }

    fn next_frame(&mut self) -> PyResult<bool> {
        self.end_frame();
        let interrupted = |py: Python<'_>| py.check_signals();
        Python::attach(interrupted)?;
        self.dark = self.begun == self.light.count;
        if self.dark {
            return Ok(false);
        }
        self.t = begin(self.chip, self.light, self.begun, self.packet).map_err(raised)?;
        self.begun += 1;
        Ok(true)
    }
}

impl Beside for Companion<'_> {
    fn frame(&mut self) -> bool {
        self.next_frame().unwrap_or_else(|why| {
            self.stopped = Some(why);
            false
        })
    }

    fn run(&mut self, steps: &[Step]) -> Option<Answer> {
        self.exposure.see(steps, self.chip.device());
        let (pool, t) = (Arc::clone(&self.pool), self.t);
        let answer = pool.install(|| answered(self.chip, steps, t, self.packet));
        let refused = |why| self.stopped = Some(raised(Report::new(why)));
        answer.map_err(refused).ok()
    }

    fn micros(&self) -> f64 {
        self.chip.ledger().cost(self.chip.device()).micros()
    }

    fn post(&mut self, text: String) {
        self.posts.push((self.begun.saturating_sub(1), text));
    }
}
