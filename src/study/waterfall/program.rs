//! The program that a fall ends in, its kinds, and the float sensors that they stand for.

use std::borrow::Cow;

use super::question::WaterfallError;
use crate::{
    compile::{DriveMemory, Filter},
    event::Packet,
    kernel::quantise::Quantised,
    number::Format,
    plane::Size,
    reference::{Description, MemoryRule},
    sensor::Sensor,
    study::{
        design::{Compiled, Design, float},
        equivalent::{RUNGS, at_part},
        together::{self, Together},
    },
};

/// Kinds in one program; a fall is of one of them.
#[derive(Clone, Debug)]
pub(super) struct Kinds<'a> {
    pub(super) compiled: Compiled,
    /// What it remembers, and where.
    memory: DriveMemory,
    designs: Vec<Design<'a>>,
    quantised: Vec<Quantised>,
}

impl<'a> Kinds<'a> {
    /// One kind in a program of its own.
    pub(super) fn alone(design: Design<'a>, quantised: Quantised) -> Result<Self, WaterfallError> {
        let compiled = design.in_levels(&quantised).compile("levels")?;
        Ok(Self::of_program(design, quantised, compiled))
    }

    /// One kind in a program that was found.
    pub(super) fn of_program(design: Design<'a>, quantised: Quantised, compiled: Compiled) -> Self {
        Self {
            compiled,
            memory: DriveMemory::Analogue,
            designs: vec![design],
            quantised: vec![quantised],
        }
    }

    /// All of them in one program, with this memory, or with the first that the chip holds them in.
    pub(super) fn together(
        designs: &[Design<'a>],
        quantised: Vec<Quantised>,
        wanted: Option<DriveMemory>,
    ) -> Result<Self, WaterfallError> {
        let levels: Vec<Design<'_>> = { designs.iter().zip(&quantised) }
            .map(|(design, quantised)| design.in_levels(quantised))
            .collect();
        let Together {
            memory, compiled, ..
        } = Together::compile(&levels, "levels", wanted)?.map_err(WaterfallError::Refused)?;
        Ok(Self {
            compiled,
            memory,
            designs: designs.to_vec(),
            quantised,
        })
    }

    pub(super) fn count(&self) -> usize {
        self.designs.len()
    }

    /// What is remembered, where there are several.
    pub(super) fn remembered(&self) -> Option<DriveMemory> {
        (self.count() > 1).then_some(self.memory)
    }

    /// The designs, as they were given or with their kernels in levels.
    fn designs(&self, levels: bool) -> Vec<Design<'_>> {
        let both = self.designs.iter().zip(&self.quantised);
        both.map(|(design, quantised)| {
            if levels {
                design.in_levels(quantised)
            } else {
                *design
            }
        })
        .collect()
    }

    /// The float sensor of all kinds. A memory that snaps is the program's: of the pixel, where its
    /// kinds share one. One that steps is each kind's own.
    pub(super) fn description(
        &self,
        levels: bool,
        rule: MemoryRule,
    ) -> Result<Description, WaterfallError> {
        let designs = self.designs(levels);
        let mut all = together::description(self.memory, &designs)?;
        if rule == MemoryRule::FilteredStep {
            all.memory = rule;
            all.shared = false;
        }
        Ok(all)
    }

    /// That sensor.
    pub(super) fn float(
        &self,
        levels: bool,
        rule: MemoryRule,
        size: Size,
    ) -> Result<Box<dyn Sensor + Send>, WaterfallError> {
        self.sensor(self.description(levels, rule)?, size)
    }

    /// Those of its ladder, in the order of [`RUNGS`].
    pub(super) fn ladder(
        &self,
        rule: MemoryRule,
        size: Size,
    ) -> Result<Vec<Box<dyn Sensor + Send>>, WaterfallError> {
        let all = self.description(false, rule)?;
        let rung = |part: f64| self.sensor(at_part(&all, part), size);
        RUNGS.into_iter().map(rung).collect()
    }

    fn sensor(
        &self,
        description: Description,
        size: Size,
    ) -> Result<Box<dyn Sensor + Send>, WaterfallError> {
        let seed = self.designs.first().map_or(0, |design| design.seed);
        let made = float(description, size, seed, Format::F64);
        Ok(made.map_err(crate::study::design::DesignError::from)?)
    }

    /// The events of one kind, as a sensor of that kind alone has them.
    pub(super) fn own<'p>(&self, packet: &'p Packet, kind: usize) -> Cow<'p, Packet> {
        if self.count() == 1 {
            return Cow::Borrowed(packet);
        }
        Cow::Owned(together::own(packet, kind))
    }

    /// The filter of one kind.
    pub(super) fn filter(&self, kind: usize) -> &Filter {
        let program = &self.compiled.program;
        program.filters.get(kind).unwrap_or(&program.filter)
    }

    /// LSB for each unit of a kind's kernel times light.
    pub(super) fn scale(&self, kind: usize) -> f64 {
        let program = &self.compiled.program;
        program.scales.get(kind).copied().unwrap_or(program.scale())
    }

    /// The threshold of one kind, in its levels times light.
    pub(super) fn threshold(&self, kind: usize) -> f64 {
        let levels = self.designs(true);
        levels.get(kind).map_or(0.0, |levels| levels.threshold)
    }

    /// The farthest that any kernel reaches, in pixels.
    pub(super) fn reach(&self) -> usize {
        let reach = |design: &Design<'_>| {
            let (down, across) = design.kernel.reach();
            down.max(across)
        };
        self.designs.iter().map(reach).max().unwrap_or(0)
    }

    pub(super) fn quantised(&self, kind: usize) -> Option<&Quantised> {
        self.quantised.get(kind)
    }
}
