//! A program on its chip: what runs, whoever wrote it.

use super::{all_events::AllEvents, design::DesignError};
use crate::{
    array::{Arithmetic, Array, Chip, Layout, Settings, Silicon},
    isa::{Device, Errors},
    limit::ARRAY_SIDE,
    plane::Size,
    program::{Code, Cost, Overrides, Program},
    sensor::SensorError,
    unit::Words,
};

/// What a study runs on many chips unless more is asked for, in instruction words times pixels times
/// frames: about 13 s on two cores of 2024.
pub(super) const WORK: f64 = 14e9;

/// A program's text expanded on its chip.
#[derive(Clone, Debug)]
pub struct Expanded {
    /// What it is called in messages.
    pub title: String,
    /// The instruction words.
    pub code: Code,
    /// What a frame costs.
    pub cost: Cost,
    /// Words that it takes in the kernel store.
    pub stored: Words,
    /// The chip.
    pub device: Device,
}

impl Expanded {
    /// Of a program's text.
    ///
    /// # Errors
    /// When the text is no program, or more than the chip takes.
    pub fn from_text(title: &str, text: &str, device: &Device) -> Result<Self, DesignError> {
        let parsed = Program::parse(title, text)?;
        let expansion = parsed.expand(device, &Overrides::default())?;
        let stored = expansion.stored(device);
        let code = expansion.code;
        Ok(Self {
            title: title.to_owned(),
            cost: Cost::of(&code.frame, device),
            stored,
            code,
            device: device.clone(),
        })
    }

    /// What the chip's data say, and registers of numbers limited to the chip's range.
    #[must_use]
    pub fn settings(&self) -> Settings {
        Settings {
            clip: true,
            ..Settings::from_device(&self.device)
        }
    }

    /// A chip that runs it.
    ///
    /// # Errors
    /// When the size has no addresses.
    pub fn chip(
        &self,
        arithmetic: Arithmetic,
        size: Size,
        settings: Settings,
    ) -> Result<Box<dyn Array + Send>, DesignError> {
        if let Arithmetic::Silicon { seed } = arithmetic {
            return self.silicon(Errors::from_device(&self.device), seed, size, settings);
        }
        addressed(size)?;
        Ok(arithmetic.chip(&self.title, &self.code, &self.device, size, settings)?)
    }

    /// A chip that errs as `errors` says: [`Errors::from_device`], with any of them changed
    /// or 0. Analogue cells saturate at the range in it, which has the chip's headroom;
    /// `settings.clip` would take that away, and is left out.
    ///
    /// # Errors
    /// When the size has no addresses.
    pub fn silicon(
        &self,
        errors: Errors,
        seed: u64,
        size: Size,
        settings: Settings,
    ) -> Result<Box<dyn Array + Send>, DesignError> {
        addressed(size)?;
        let domain = Silicon::new(errors, seed, &Layout::new(&self.device, size));
        let settings = Settings {
            clip: false,
            ..settings
        };
        let chip = Chip::new(
            &self.title,
            domain,
            &self.code,
            &self.device,
            size,
            settings,
        )?;
        Ok(Box::new(chip))
    }

    /// A chip of this program of which every event is read, however many there are.
    #[must_use]
    pub fn all_events(&self, chip: Box<dyn Array + Send>) -> AllEvents {
        AllEvents::new(chip, &self.code.frame)
    }
}

fn addressed(size: Size) -> Result<(), SensorError> {
    let addresses = 1..=ARRAY_SIDE;
    if addresses.contains(&size.width) && addresses.contains(&size.height) {
        Ok(())
    } else {
        Err(SensorError::Addresses { size })
    }
}
