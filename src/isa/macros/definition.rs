//! A macro, and what its heading says.

use super::super::{
    Evidence, Operand, Signature,
    signature::Mode,
    text::{Expression, Statement},
};

/// A macro.
#[derive(Clone, Debug, PartialEq)]
pub struct Macro {
    /// What it does, as its comment says.
    pub doc: String,
    /// What it is called and takes.
    pub signature: Signature,
    /// Where it is written, `file:line`; empty in a text that is no file of a chip.
    pub origin: String,
    /// Run by the host as kernels of its own: its loops do not fill the kernel store.
    pub host: bool,
    /// Registers, besides parameters, that hold a result.
    pub gives: Vec<String>,
    /// Whether it needs FLAG to be 1 everywhere.
    pub whole_flag: bool,
    /// Parameters that may not be the same register.
    pub distinct: Vec<Distinct>,
    /// How well its sequence is known, and who says so, where that is stated.
    pub evidence: Option<(Evidence, String)>,
    /// What it stands for.
    pub body: Vec<Item>,
}

/// Two parameters that may not be the same register.
#[derive(Clone, Debug, PartialEq)]
pub struct Distinct {
    /// Name of the one parameter.
    pub first: String,
    /// Name of the other.
    pub second: String,
    /// Why not, for the message.
    pub reason: String,
}

/// A part of a macro's body.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A statement.
    Statement(Statement),
    /// A part that is done several times.
    Repeat {
        /// How often.
        times: Expression,
        /// What is done.
        body: Vec<Item>,
    },
}

impl Macro {
    /// Whether another macro has the same name and takes the same.
    #[must_use]
    pub fn replaces(&self, other: &Self) -> bool {
        let operands = |m: &Self| -> Vec<Operand> {
            m.signature.parameters.iter().map(|p| p.operand).collect()
        };
        self.signature.name == other.signature.name && operands(self) == operands(other)
    }

    /// Indices of the parameters that hold a result afterwards.
    pub fn results(&self) -> impl Iterator<Item = usize> {
        let parameters = self.signature.parameters.iter().enumerate();
        parameters
            .filter(|(_, p)| matches!(p.mode, Mode::Out | Mode::InOut))
            .map(|(i, _)| i)
    }

    /// Whether a parameter is a register.
    #[must_use]
    pub fn is_register(&self, index: usize) -> bool {
        let parameter = self.signature.parameters.get(index);
        parameter.is_some_and(|p| {
            matches!(
                p.operand,
                Operand::Areg | Operand::Target | Operand::Source | Operand::Dreg | Operand::Bit
            )
        })
    }
}
