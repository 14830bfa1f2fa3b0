//! What falls on the array, and what lies in its registers.

use std::path::Path;

use miette::{WrapErr, miette};
use ndarray::ArrayView2;
use ndarray_npy::{ReadNpyError, ReadableElement, ViewElement, ViewNpyError, npy::header::Header};

use super::{
    super::{files, registers::Register},
    Arguments, Light, Set,
};
use crate::{
    array::Array,
    isa::{Device, Figure},
    limit::FRAMES,
    plane::{Plane, Size},
    program::Program,
    scene::{ASSUMED_FPS, Frame, Observation, Scene, SceneError},
    source,
};

impl Set {
    pub(super) fn read(device: &Device, name: &str, path: &Path) -> miette::Result<Self> {
        let register = Register::named(device, name)?;
        if register == Register::Pix {
            return Err(miette!(
                help = "light is given with --image",
                "--set {name}: the photodiodes are not set"
            ));
        }
        let plane = read_plane(path)?;
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

    pub(super) fn apply(&self, chip: &mut dyn Array) -> miette::Result<()> {
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

impl Light {
    pub(super) fn open(
        arguments: &Arguments,
        program: &Program,
        observation: &Observation,
    ) -> miette::Result<Self> {
        let own = program.settings.image.as_ref().map(|image| {
            if image.starts_with("pattern:") {
                return image.clone();
            }
            arguments.source.folder().join(image).display().to_string()
        });
        let asked = arguments.fps.or(program.settings.fps);
        let image = arguments.image.as_deref().or(own.as_deref());
        if let (None, Some(image)) = (&arguments.image, image) {
            files::reads(Path::new(image))?;
        }
        let scene = image
            .map(|spec| arguments.samples.open(Some(spec), asked, observation))
            .transpose()?;
        let found = scene.as_deref().map_or(ASSUMED_FPS, <dyn Scene>::fps);
        let frames = arguments.frames.or(program.settings.frames);
        if frames == Some(0) {
            return Err(miette!(
                help = "the first frame runs `init`, every later one `frame`",
                "--frames 0: nothing would run"
            ));
        }
        if let Some(asked) = frames.filter(|asked| *asked > FRAMES) {
            return Err(miette!(
                help = "run fewer frames, or a clip of your own in parts",
                "{asked} frames; {FRAMES} frames at most"
            ));
        }
        Ok(Self {
            scene,
            frames,
            fps: asked.unwrap_or(found),
        })
    }
}

/// The light as a scene. What ends, a still picture or the dark, is there as long as it is asked
/// for; the dark has the size of the array.
pub(super) struct Lasting {
    light: Light,
    size: Size,
    /// Frames in all, where the scene has fewer.
    enough: u64,
    given: u64,
    /// The light that goes on when the scene ends, kept only if it may end too soon.
    last: Option<Plane<f64>>,
}

impl Lasting {
    /// At least so many frames, unless others are asked for.
    pub(super) fn new(light: Light, size: Size, least: u64) -> Self {
        Self {
            size,
            enough: light.frames.unwrap_or(least),
            light,
            given: 0,
            last: None,
        }
    }
}

impl Scene for Lasting {
    fn size(&self) -> Size {
        self.size
    }

    fn fps(&self) -> f64 {
        self.light.fps
    }

    fn frames(&self) -> Option<u64> {
        self.light.frames
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        if self.light.frames.is_some_and(|asked| self.given >= asked) {
            return Ok(None);
        }
        let scene = self.light.scene.as_mut();
        let too_short = scene
            .as_ref()
            .is_none_or(|scene| scene.frames().is_none_or(|all| all < self.enough));
        let next = match scene {
            Some(scene) => scene.next_frame()?,
            None => None,
        };
        let index = self.given;
        let frame = match next {
            Some(frame) => frame,
            None if index >= self.enough => return Ok(None),
            None => Frame {
                index,
                seconds: index as f64 / self.light.fps,
                light: { self.last.take() }.unwrap_or_else(|| Plane::zeros(self.size.shape())),
            },
        };
        self.given += 1;
        if too_short && self.given < self.enough {
            self.last = Some(frame.light.clone());
        }
        Ok(Some(frame))
    }
}

/// Reads a plane of any numbers.
pub(in crate::cli) fn read_plane(path: &Path) -> miette::Result<Plane<f64>> {
    fn of<T: ReadableElement + ViewElement + Copy>(
        bytes: &[u8],
        number: impl Fn(T) -> f64,
    ) -> Result<Plane<f64>, ReadNpyError> {
        use ndarray_npy::{ReadNpyExt, ViewNpyExt};
        // A view allocates nothing, so that a header can claim what it likes.
        match ArrayView2::<T>::view_npy(bytes) {
            Err(ViewNpyError::LengthOverflow) => return Err(ReadNpyError::LengthOverflow),
            Err(ViewNpyError::MissingBytes(_)) => return Err(ReadNpyError::MissingData),
            _ => {}
        }
        let plane = Plane::<T>::read_npy(bytes)?;
        Ok(plane.map(|value| number(*value)))
    }
    let shown = path.display();
    let help = "give a .npy of shape (H,W), as numpy.save writes it";
    let bytes = source::numbers(path, help)?;
    let bytes = bytes.as_slice();
    source::npy_header(bytes).map_err(|what| miette!(help = help, "{shown}: {what}"))?;
    // The header must agree with the file, before room is made for what it says.
    check_shape(bytes).map_err(|why| {
        miette!(
            help = "give a .npy of shape (H,W) with real numbers, as numpy.save writes it",
            "{shown}: {why}"
        )
    })?;
    let mut result = of::<f64>(bytes, |v| v);
    // Every kind of number that numpy saves; which one it is stands in the header.
    macro_rules! or_else {
        ($($kind:ty),*) => {$(
            if let Err(ReadNpyError::WrongDescriptor(_)) = result {
                result = of::<$kind>(bytes, |v| v as f64);
            }
        )*};
    }
    or_else!(f32, i64, i32, i16, i8, u64, u32, u16, u8);
    if let Err(ReadNpyError::WrongDescriptor(_)) = result {
        result = of::<bool>(bytes, |v| if v { 1.0 } else { 0.0 });
    }
    let plane = result.map_err(|e| {
        miette!(
            help = "give a .npy of shape (H,W) with real numbers, as numpy.save writes it",
            "{shown}: {e}"
        )
    })?;
    if plane.is_empty() {
        return Err(miette!(
            help = "a plane has at least one pixel",
            "{shown}: a plane of {}",
            Size::of(&plane)
        ));
    }
    Ok(plane)
}

/// Whether a header promises no more numbers than there are bytes. What else is wrong with it,
/// its reader says.
fn check_shape(bytes: &[u8]) -> Result<(), String> {
    let Ok(header) = Header::from_reader(&mut &*bytes) else {
        return Ok(());
    };
    let all = header
        .shape
        .iter()
        .try_fold(1_usize, |all, n| all.checked_mul(*n));
    match all {
        Some(all) if all <= bytes.len() => Ok(()),
        _ => Err(format!(
            "its header promises an array of shape {:?}, the file has {} bytes",
            header.shape,
            bytes.len()
        )),
    }
}

/// The size of the array: of what is set, else of the light, else of the program, else of the chip.
pub(super) fn size(
    planes: &[Set],
    scene: Option<&dyn Scene>,
    program: &Program,
    device: &Device,
) -> miette::Result<Size> {
    let set = planes
        .iter()
        .map(|set| (set.path.display().to_string(), Size::of(&set.plane)));
    let light = scene.map(|scene| ("the light".to_owned(), scene.size()));
    let mut all = set.chain(light);
    let Some((first, size)) = all.next() else {
        let height = device.value(Figure::Height) as usize;
        let width = device.value(Figure::Width) as usize;
        let (height, width) = program.settings.size.unwrap_or((height, width));
        return checked(Size::new(height, width));
    };
    if let Some((other, its)) = all.find(|(_, its)| *its != size) {
        return Err(miette!(
            help = "all planes and the light must have one size: that of the array",
            "{first} is {size}, {other} is {its}"
        ));
    }
    checked(size)
}

pub(super) fn checked(size: Size) -> miette::Result<Size> {
    if size.is_possible() {
        return Ok(size);
    }
    Err(miette!(
        help = format!(
            "height and width must be from 1 to {}, and {} pixels at most",
            Size::LONGEST_SIDE,
            Size::MOST_PIXELS
        ),
        "an array of {size}"
    ))
}
