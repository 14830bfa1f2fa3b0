//! A register that is set before the program runs.

use std::path::{Path, PathBuf};

use miette::{WrapErr, miette};

use crate::{
    array::{Array, Register},
    cli::input::npy,
    isa::Device,
    plane::Plane,
};

/// A register and what it is set to.
pub struct Set {
    name: String,
    pub path: PathBuf,
    register: Register,
    pub plane: Plane<f64>,
}

impl Set {
    pub fn read(device: &Device, name: &str, path: &Path) -> miette::Result<Self> {
        let register = Register::named_to_set(device, name)?;
        if register == Register::Pix {
            return Err(miette!(
                help = "light is given with --image",
                "--set {name}: the photodiodes are not set"
            ));
        }
        let plane = npy::read(path)?;
        let wrong = |value: &f64| match register {
            Register::Analog(_) | Register::Pix => !value.is_finite(),
            Register::Digital(_) | Register::Flag => *value != 0.0 && *value != 1.0,
        };
        if let Some(((y, x), value)) = plane.indexed_iter().find(|(_, value)| wrong(value)) {
            let want = match register {
                Register::Analog(_) | Register::Pix => "finite numbers",
                Register::Digital(_) | Register::Flag => "0 or 1",
            };
            return Err(miette!(
                help = format!("{name} holds {want} in every pixel"),
                "{}: {value} at [{y}, {x}]",
                path.display()
            ));
        }
        Ok(Self {
            name: name.to_owned(),
            path: path.to_owned(),
            register,
            plane,
        })
    }

    /// Whether it sets this register.
    pub fn sets(&self, register: Register) -> bool {
        self.register == register
    }

    pub fn apply(&self, chip: &mut dyn Array) -> miette::Result<()> {
        let bits = || self.plane.mapv(|value| value == 1.0);
        match self.register {
            Register::Analog(register) => chip.set_analog(register, &self.plane),
            Register::Digital(register) => chip.set_digital(register, &bits()),
            Register::Flag => chip.set_flag(&bits()),
            Register::Pix => Ok(()),
        }
        .wrap_err_with(|| format!("--set {}={}", self.name, self.path.display()))
    }
}
