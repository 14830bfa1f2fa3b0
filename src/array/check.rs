//! A program against an array, before it runs.

use super::Layout;
use crate::{
    event::readout::scan::SLOTS,
    isa::{Analog, Cell, Digital, Primitive, operands::Unit},
    plane::Size,
    program::{Action, Code, Host, Step},
};

/// A program cannot run on this array.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("line {line}: {problem}")]
#[diagnostic(help("{}", problem.help()))]
pub struct CodeError {
    /// Line of the program text, from 1.
    pub line: u32,
    /// What is wrong there.
    pub problem: CodeProblem,
}

/// What is wrong with an instruction.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CodeProblem {
    /// An analogue register that the array does not have.
    #[error("analogue register number {number} on an array that has {count}")]
    Analog {
        /// Its index.
        number: u8,
        /// How many there are.
        count: u8,
    },
    /// A one-bit register that the array does not have.
    #[error("one-bit register number {number} on an array that has {count}")]
    Digital {
        /// Its index.
        number: u8,
        /// How many there are.
        count: u8,
    },
    /// Fewer registers than the logic of a pixel needs.
    #[error("an array of {analog} analogue and {digital} one-bit registers")]
    Layout {
        /// Analogue registers.
        analog: u8,
        /// One-bit registers.
        digital: u8,
    },
    /// An array without pixels, or with more than event addresses.
    #[error("an array of {size} pixels cannot be addressed")]
    Size {
        /// The size.
        size: Size,
    },
    /// A field of the [`Settings`](super::Settings) that no array has.
    #[error("the setting {field} is {value}; {want} was expected")]
    Setting {
        /// Its name.
        field: &'static str,
        /// Its value.
        value: String,
        /// What it can be.
        want: &'static str,
    },
    /// A bus without a target.
    #[error("a bus without a target")]
    NoTarget,
    /// The same register twice on one bus.
    #[error("the same register twice on one bus")]
    Twice,
    /// More slots than the chip can read out at once.
    #[error("{slots} slots of event readout; at most {SLOTS}")]
    Slots {
        /// How many were asked.
        slots: u32,
    },
    /// A value that is not a number.
    #[error("the input {value} is not a finite number")]
    Value {
        /// The value as text.
        value: String,
    },
}

impl CodeProblem {
    fn help(&self) -> &'static str {
        match self {
            Self::Analog { .. } | Self::Digital { .. } => {
                "use a register that this chip has, or a chip with more registers"
            }
            Self::Layout { .. } => {
                "a pixel needs NEWS, and two different registers that mask and spread"
            }
            Self::Size { .. } => "width and height must be from 1 to 65536",
            Self::Setting { .. } => "Settings::from_device has those of a chip's data",
            Self::NoTarget => "name the register that the bus is stored in",
            Self::Twice => {
                "on a bus all registers must differ, the targets too: a register connected twice is connected once"
            }
            Self::Slots { .. } => "ask for fewer slots, or scan twice",
            Self::Value { .. } => "give a value from -128 to 127",
        }
    }
}

/// Checks that every instruction can run on an array of this layout.
///
/// # Errors
/// The first instruction that cannot, on line 0 the array itself.
pub fn check(code: &Code, layout: &Layout) -> Result<(), CodeError> {
    if !layout.size.is_possible() {
        let size = layout.size;
        let problem = CodeProblem::Size { size };
        return Err(CodeError { line: 0, problem });
    }
    let problem = CodeProblem::Layout {
        analog: layout.analog,
        digital: layout.digital,
    };
    let roles = layout.roles;
    let named = [roles.mask, roles.propagated]
        .into_iter()
        .chain(roles.enable);
    if layout.news.0 >= layout.analog
        || named
            .into_iter()
            .any(|register| register.0 >= layout.digital)
        || roles.mask == roles.propagated
    {
        return Err(CodeError { line: 0, problem });
    }
    body(&code.init, layout)?;
    body(&code.frame, layout)
}

fn body(steps: &[Step], layout: &Layout) -> Result<(), CodeError> {
    for step in steps {
        let at_line = |problem| CodeError {
            line: step.line,
            problem,
        };
        match &step.action {
            Action::Word(primitive) => word(primitive, layout).map_err(at_line)?,
            Action::Host(operation) => host(operation, layout).map_err(at_line)?,
            Action::Repeat { body: steps, .. } => body(steps, layout)?,
        }
    }
    Ok(())
}

fn word(word: &Primitive, layout: &Layout) -> Result<(), CodeProblem> {
    let operands = layout.operands(word);
    if operands.unit == Unit::Bus && operands.writes().next().is_none() {
        return Err(CodeProblem::NoTarget);
    }
    for access in &operands.accesses {
        match access.cell() {
            Some(Cell::Analog(register)) => analog(register, layout)?,
            Some(Cell::Digital(register)) => digital(register, layout)?,
            Some(Cell::Flag) | None => {}
        }
    }
    match operands.twice() {
        // A program's text may not diffuse a register into itself; the array reads a copy then.
        Some(_) if operands.unit != Unit::Diffusion => Err(CodeProblem::Twice),
        _ => Ok(()),
    }
}

fn host(host: &Host, layout: &Layout) -> Result<(), CodeProblem> {
    match host {
        Host::LoadIn { value } | Host::LoadInRaw { value } => {
            let value = *value;
            if value.is_finite() {
                Ok(())
            } else {
                Err(CodeProblem::Value {
                    value: value.to_string(),
                })
            }
        }
        Host::ScanEvents { source, slots, .. } => {
            digital(*source, layout)?;
            if *slots > SLOTS {
                return Err(CodeProblem::Slots { slots: *slots });
            }
            Ok(())
        }
        Host::ReadAnalog { source }
        | Host::ReadPixel { source, .. }
        | Host::ScanAnalog { source, .. }
        | Host::ScanBlocks { source, .. }
        | Host::GlobalSum { source, .. } => analog(*source, layout),
        Host::ScanDigital { source, .. }
        | Host::ScanBoundingBox { source }
        | Host::GlobalOr { source, .. } => digital(*source, layout),
        Host::GlobalCount {
            source, temporary, ..
        } => {
            digital(*source, layout)?;
            analog(*temporary, layout)
        }
        Host::Load { target, .. } | Host::DrawBegin { target } | Host::Draw { target, .. } => {
            digital(*target, layout)
        }
        Host::LoadDac { .. } | Host::Select { .. } | Host::DrawEnd => Ok(()),
    }
}

fn analog(register: Analog, layout: &Layout) -> Result<(), CodeProblem> {
    if register.0 < layout.analog {
        return Ok(());
    }
    Err(CodeProblem::Analog {
        number: register.0,
        count: layout.analog,
    })
}

fn digital(register: Digital, layout: &Layout) -> Result<(), CodeProblem> {
    if register.0 < layout.digital {
        return Ok(());
    }
    Err(CodeProblem::Digital {
        number: register.0,
        count: layout.digital,
    })
}
