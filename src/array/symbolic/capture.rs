//! Whether a chip's `get_image` leaves the light in its register, as compiled programs take it to.

use super::{
    super::Settings,
    form::Input,
    taps::{self, Taps},
};
use crate::{
    isa::{Analog, Device, Figure},
    program::{Overrides, Program},
};

/// A chip whose macro `get_image` leaves something else than the light.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("the macro `get_image` of {chip} does not leave the light in its register: {why}")]
#[diagnostic(help(
    "compiled programs begin with `get_image(y);` and take y for the light, as on scamp5: bus(NEWS, PIX); rpix(); rpix(); nop(); bus(y, NEWS, PIX);"
))]
pub struct CaptureError {
    /// The chip.
    pub chip: String,
    /// What it leaves.
    pub why: String,
}

/// Checks that `get_image(y);` leaves in y the light of the pixel, and nothing else that went in. A
/// chip without such a macro is no matter of this.
///
/// # Errors
/// When it does not.
pub fn check_capture(device: &Device) -> Result<(), CaptureError> {
    let all = 0..device.registers().analog.len() as u8;
    let Some(register) = all.map(Analog).find(|it| *it != device.news()) else {
        return Ok(());
    };
    let text = format!("get_image({});", device.analog_name(register));
    let program = Program::parse("get_image", &text);
    let program = program.and_then(|it| it.expand(device, &Overrides::default()));
    let Ok(program) = program else {
        return Ok(());
    };
    let settings = Settings::from_device(device);
    let why = match taps::read(&program.code.frame, device, settings, register) {
        Ok(found) => wrong(&found, device),
        Err(error) => Some(error.to_string()),
    };
    why.map_or(Ok(()), |why| {
        Err(CaptureError {
            chip: device.name().to_owned(),
            why,
        })
    })
}

/// What it leaves instead of the light.
fn wrong(found: &Taps, device: &Device) -> Option<String> {
    let scale = device.value(Figure::LightScale);
    let mut taps = found.taps.iter();
    match (taps.next(), taps.next()) {
        (None, _) => Some("nothing of the light is in it".to_owned()),
        (Some(((Input::Light, 0, 0), weight)), None) => {
            let times = weight.to_f64() / scale;
            (times != 1.0).then(|| format!("it holds {times} times the light"))
        }
        _ => Some("other cells are in it, too".to_owned()),
    }
}
