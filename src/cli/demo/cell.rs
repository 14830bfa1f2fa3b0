//! The cells of the demo, and their programs.

use crate::{
    array::Arithmetic,
    compile::Effort,
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    study::design::{Compiled, Design},
};

use super::choice::{CHOSEN, DOMAINS, FEWER, KERNEL, SHOWN, THRESHOLD};

/// A cell: a float sensor, and the programs that stand for it on the chip.
pub(super) struct Cell {
    /// What it is called.
    pub name: &'static str,
    pub kernel: Kernel,
    pub device: Device,
    pub programs: Vec<OnChip>,
}

/// A program, and what it runs in.
pub(super) struct OnChip {
    /// The few values of its kernel.
    pub to: &'static str,
    /// How far the kernel in these values is from the cell's.
    pub relative_error: f64,
    pub compiled: Compiled,
    pub domains: Vec<Arithmetic>,
}

/// A plain DVS, which says what the chip does to the simplest cell, and the kernel of the demo,
/// as the chip can carry it and in fewer values.
pub(super) fn all(seed: u64) -> miette::Result<Vec<Cell>> {
    // What it is in fixed point is told once, of the one that the chip carries.
    let [exact, _, silicon] = DOMAINS.map(|(domain, _)| domain);
    let every = DOMAINS.map(|(domain, _)| domain);
    Ok(vec![
        Cell::new("dvs", "plain DVS", &[("ternary", &[exact, silicon])], seed)?,
        Cell::new(
            KERNEL,
            KERNEL,
            &[(CHOSEN, &every), (FEWER, &[exact, silicon])],
            seed,
        )?,
    ])
}

impl Cell {
    fn new(
        kernel: &str,
        name: &'static str,
        programs: &[(&'static str, &[&str])],
        seed: u64,
    ) -> miette::Result<Self> {
        let unknown = || std::io::Error::other(format!("{kernel} is not built in"));
        let mut cell = Self {
            name,
            kernel: Kernel::builtin(kernel)
                .ok_or_else(unknown)
                .map_err(|e| miette::miette!(e))?,
            device: Device::scamp5(),
            programs: Vec::new(),
        };
        for (to, domains) in programs {
            let program = cell.program(to, domains, seed)?;
            cell.programs.push(program);
        }
        Ok(cell)
    }

    fn program(&self, to: &'static str, domains: &[&str], seed: u64) -> miette::Result<OnChip> {
        let design = self.design(seed);
        let quantised = design.quantise(to.parse::<Quantiser>()?, Sum::Kept)?;
        let domains = domains
            .iter()
            .map(|domain| Ok(domain.parse::<Arithmetic>()?.with_seed(seed)))
            .collect::<miette::Result<_>>()?;
        Ok(OnChip {
            to,
            relative_error: quantised.relative_error(&self.kernel),
            compiled: design.in_levels(&quantised).compile(self.name)?,
            domains,
        })
    }

    /// The float sensor, and how programs for it are found.
    pub fn design(&self, seed: u64) -> Design<'_> {
        Design {
            kernel: &self.kernel,
            threshold: THRESHOLD,
            device: &self.device,
            effort: Effort::default(),
            seed,
        }
    }
}

impl OnChip {
    /// Whether it is the one that the chip can carry.
    pub fn is_chosen(&self) -> bool {
        self.to == CHOSEN
    }
}

/// Whether the pictures show this arithmetic.
pub(super) fn is_shown(domain: Option<Arithmetic>) -> bool {
    domain.is_some_and(|domain| domain.to_string() == SHOWN)
}
