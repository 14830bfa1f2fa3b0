//! A study whose scenes, kernels and chips have been opened: every point with its identity.
//!
//! A point's identity is a hash (SHA-256, of which 128 bits are kept) of its canonical
//! description, of the content of all that it names (the light of its scene, the weights of
//! its kernel, the data of its chip), of what is measured, and of the version of the results.
//! Two ways to write the same point have one identity, and one row.

use std::{
    collections::{BTreeMap, HashSet},
    path::Path,
    str::FromStr,
    sync::Arc,
};

use miette::Diagnostic;
use serde_json::{Value as Json, json};
use sha2::{Digest, Sha256};

use super::{grid::Axes, point::Point};
use crate::{
    advice::in_study,
    bundled,
    config::{Fault, Faults, Place, UnknownWord},
    isa::Device,
    kernel::{Kernel, KernelFileError, SHAPES},
    plane::Size,
    rig::guard::Warning,
    scene::{Coding, SceneError, Transfer, View, word_or_auto},
    source,
    study::sweep::{
        results::{difference, manifest::Manifest, provenance::SCHEMA},
        scene::cached_scene::{CachedScene, Wanted, hex},
        sensor::description,
        study_file::{key::Side, study::Study},
    },
};

/// Everything there is to compute.
#[derive(Debug)]
pub struct Plan {
    /// The study.
    pub study: Study,
    /// The points in their fixed order, each once.
    pub entries: Vec<Entry>,
    /// Points that the study names; more than there are, where some are the same.
    pub named: u64,
}

/// One point, ready to be computed.
#[derive(Clone, Debug)]
pub struct Entry {
    /// What it is.
    pub point: Point,
    /// Its identity.
    pub id: String,
    /// What its events are measured against: the same for points of one task.
    pub task: String,
    pub(in crate::study::sweep) scene: Arc<CachedScene>,
    /// One for each kind of its cells.
    pub(in crate::study::sweep) kernels: Arc<[Kernel]>,
    pub(in crate::study::sweep) chip: Option<Arc<Device>>,
}

/// What was opened, by name.
pub(in crate::study::sweep) struct Opened<'a> {
    study: &'a Study,
    folder: &'a Path,
    scenes: Vec<(Wanted, Arc<CachedScene>)>,
    kernels: BTreeMap<String, Arc<[Kernel]>>,
    chips: BTreeMap<String, (Arc<Device>, String)>,
}

impl Plan {
    /// Bytes of the scenes that are kept in memory.
    #[must_use]
    pub fn held(&self) -> u128 {
        let mut digests: Vec<&str> = Vec::new();
        let mut all = 0;
        for entry in &self.entries {
            if !digests.contains(&entry.scene.digest.as_str()) {
                digests.push(&entry.scene.digest);
                all += entry.scene.bytes();
            }
        }
        all
    }

    /// Opens all that a study names, files in `folder`, and checks every point.
    ///
    /// # Errors
    /// When something that is named cannot be opened, settings contradict each other, or
    /// there are too many points.
    pub fn new(study: Study, folder: &Path) -> Result<Self, Faults> {
        let points = study.points()?;
        let named = points.len() as u64;
        check(&study, &points)?;
        let mut opened = Opened::new(&study, folder);
        let mut entries = Vec::new();
        let mut known = HashSet::new();
        for point in points {
            let entry = opened.entry(point)?;
            if known.insert(entry.id.clone()) {
                entries.push(entry);
            }
        }
        Ok(Self {
            study,
            entries,
            named,
        })
    }

    /// What the scenes warn of, by the name of each.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut scenes: Vec<&Arc<CachedScene>> = Vec::new();
        for entry in &self.entries {
            if !scenes.iter().any(|known| Arc::ptr_eq(known, &entry.scene)) {
                scenes.push(&entry.scene);
            }
        }
        scenes.iter().flat_map(|scene| scene.warnings()).collect()
    }

    /// What a folder of results says about itself.
    #[must_use]
    pub fn manifest(&self) -> Manifest {
        let points: Vec<String> = self.entries.iter().map(|entry| entry.id.clone()).collect();
        Manifest::new(&self.study, points)
    }
}

/// Looks for settings that contradict each other.
fn check(study: &Study, points: &[Point]) -> Result<(), Faults> {
    let mut seen = HashSet::new();
    for point in points {
        let found = description::contradiction(point, study.settings.against, &mut seen);
        if let Some((key, fault)) = found {
            let fault = Fault {
                place: place(&study.sides, point, &key),
                ..fault
            };
            return Err(study.fault(fault));
        }
    }
    Ok(())
}

/// Where a key of a point has got its value.
fn place(sides: &[Axes], point: &Point, key: &str) -> Place {
    let mut own = sides.iter().filter(|axes| axes.side == point.side());
    let value = point.get(key);
    let found = own.clone().find_map(|axes| {
        let axis = axes.axes.iter().find(|axis| axis.key.name == key)?;
        let has = value.is_some_and(|value| match &axis.values {
            super::value::Values::List(list) => list.iter().any(|(listed, _)| listed == value),
            super::value::Values::Ramp(_) => true,
        });
        has.then(|| value.map_or(axis.place, |value| axis.place_of(value)))
    });
    found
        .or_else(|| own.next().map(|axes| axes.place))
        .unwrap_or_default()
}

/// What a point says about the samples of its scene; else the key whose word is unknown.
fn coding(point: &Point) -> Result<Coding, (&'static str, UnknownWord)> {
    fn asked<T>(
        point: &Point,
        key: &'static str,
        otherwise: Option<T>,
    ) -> Result<Option<T>, (&'static str, UnknownWord)>
    where
        T: FromStr<Err = UnknownWord>,
    {
        point.word(key).map_or(Ok(otherwise), |word| {
            word_or_auto(word).map_err(|unknown| (key, unknown))
        })
    }
    Ok(Coding {
        range: asked(point, "range", None)?,
        transfer: asked(point, "transfer", Some(Transfer::AsCoded))?,
        scale: point.number("scale"),
    })
}

/// What a point shows of its scene.
fn view(point: &Point) -> View {
    View {
        slice: point.word("slice").and_then(|slice| slice.parse().ok()),
        crop: point.word("crop").and_then(|crop| crop.parse().ok()),
        resize: point.word("resize").and_then(Size::read),
    }
}

/// The scene of a point, as it is named; else the key whose word is unknown.
pub(in crate::study::sweep) fn wanted(
    point: &Point,
) -> Result<Wanted, (&'static str, UnknownWord)> {
    Ok(Wanted {
        spec: point.word("scene").unwrap_or_default().to_owned(),
        fps: point.number("fps"),
        frames: point.whole("frames"),
        coding: coding(point)?,
        view: view(point),
        upsample: point.number("upsample"),
    })
}

/// What the kernels of a point are called.
pub(in crate::study::sweep) fn kernel_name(point: &Point) -> &str {
    match point.side() {
        // The pixel alone; the mesh is its surround.
        Side::Mesh => "dvs",
        Side::Reference | Side::Array => point.word("kernel").unwrap_or_default(),
    }
}

impl<'a> Opened<'a> {
    /// Nothing yet; files are looked for in `folder`.
    pub(in crate::study::sweep) const fn new(study: &'a Study, folder: &'a Path) -> Self {
        Self {
            study,
            folder,
            scenes: Vec::new(),
            kernels: BTreeMap::new(),
            chips: BTreeMap::new(),
        }
    }

    /// What the scenes warn of, by the name of each.
    pub(in crate::study::sweep) fn warnings(&self) -> Vec<Warning> {
        let scenes = self.scenes.iter();
        scenes.flat_map(|(_, scene)| scene.warnings()).collect()
    }

    /// A point that contradicts nothing, ready to be computed.
    pub(in crate::study::sweep) fn checked_entry(&mut self, point: Point) -> Result<Entry, Faults> {
        check(self.study, std::slice::from_ref(&point))?;
        self.entry(point)
    }

    fn entry(&mut self, point: Point) -> Result<Entry, Faults> {
        let scene = self.scene(&point)?;
        let kernels = self.kernels(&point)?;
        let thresholds = point.thresholds();
        if let Some(what) = thresholds.and_then(|them| them.wrong_for(kernels.len())) {
            let help = "give a number for all kinds, or a list with one for each kernel of the file, in its order";
            return Err(self.wrong(&point, "threshold", &what, Some(help.to_owned())));
        }
        let chip = self.chip(&point)?;
        let task = description::task(&point, &kernels, self.study.settings.against);
        let task = json!([scene.digest, task]);
        let data = chip.as_ref().map(|(_, data)| data.as_str());
        Ok(Entry {
            id: identity(&self.description(SCHEMA, &point, (&scene, &kernels, data))),
            task: identity(&task),
            scene,
            kernels,
            chip: chip.map(|(device, _)| device),
            point,
        })
    }

    /// All that makes a point, and the version of its results.
    fn description(
        &self,
        schema: u32,
        point: &Point,
        (scene, kernels, chip): (&CachedScene, &[Kernel], Option<&str>),
    ) -> Json {
        let settings = &self.study.settings;
        let mut description: BTreeMap<String, Json> = point.columns().into_iter().collect();
        // Names are replaced by what they stand for.
        for name in difference::names() {
            description.remove(name);
        }
        description.insert("light".to_owned(), json!(scene.digest));
        for (kind, kernel) in kernels.iter().enumerate() {
            let name = match kind {
                0 => "weights".to_owned(),
                other => format!("weights[{other}]"),
            };
            description.insert(name, json!(description::rows(kernel)));
        }
        if let Some(data) = chip {
            description.insert("device".to_owned(), json!(data));
            description.insert("effort".to_owned(), json!(settings.effort));
        }
        json!([schema, description, settings.measured()])
    }

    fn wrong(&self, point: &Point, key: &str, what: &str, help: Option<String>) -> Faults {
        let place = place(&self.study.sides, point, key);
        let fault = Fault::error(place, what, "named here");
        let help = help.map(|help| in_study(&help));
        self.study.fault(Fault { help, ..fault })
    }

    fn scene(&mut self, point: &Point) -> Result<Arc<CachedScene>, Faults> {
        let wanted = wanted(point).map_err(|(key, unknown)| {
            self.wrong(point, key, &unknown.to_string(), Some(unknown.help))
        })?;
        if let Some((_, cached_scene)) = self.scenes.iter().find(|(known, _)| *known == wanted) {
            return Ok(Arc::clone(cached_scene));
        }
        let cached_scene = CachedScene::open(&wanted, self.folder).map_err(|e| {
            let help = e.help().map(|help| help.to_string());
            let key = match e {
                SceneError::EmptySlice { .. } => "slice",
                SceneError::CropOutside { .. } => "crop",
                SceneError::Enlarged { .. } => "resize",
                SceneError::BadRate { .. } if wanted.fps.is_some() => "fps",
                _ => "scene",
            };
            self.wrong(point, key, &e.to_string(), help)
        })?;
        if cached_scene.frames < 2 {
            let what = format!("{} has {} frame", wanted.spec, cached_scene.frames);
            let help = "events happen between frames: give a scene of two at least";
            return Err(self.wrong(point, "scene", &what, Some(help.to_owned())));
        }
        let cached_scene = Arc::new(cached_scene);
        self.scenes.push((wanted, Arc::clone(&cached_scene)));
        Ok(cached_scene)
    }

    /// One for each kind of a point's cells.
    fn kernels(&mut self, point: &Point) -> Result<Arc<[Kernel]>, Faults> {
        let name = kernel_name(point);
        if let Some(kernels) = self.kernels.get(name) {
            return Ok(Arc::clone(kernels));
        }
        let kernels: Arc<[Kernel]> = match Kernel::builtin(name) {
            Some(kernel) => Arc::new([kernel]),
            None => self.kernel_file(point, name)?.into(),
        };
        self.kernels.insert(name.to_owned(), Arc::clone(&kernels));
        Ok(kernels)
    }

    fn kernel_file(&self, point: &Point, name: &str) -> Result<Vec<Kernel>, Faults> {
        let path = self.folder.join(name);
        let known: Vec<_> = Kernel::builtin_names().collect();
        let help = bundled::meant(
            bundled::Kind::Kernel,
            name,
            &format!(
                "give a kernel file (.toml, .npy) beside the study or one of {}",
                known.join(", ")
            ),
        );
        let bytes = source::bytes(&path, &help).map_err(|error| {
            let what = format!("cannot read the kernel {}: {}", path.display(), error.cause);
            self.wrong(point, "kernel", &what, Some(error.help))
        })?;
        let shown = path.display().to_string();
        if let Some(several) = Kernel::several_from_npy(&shown, &bytes) {
            return several
                .map_err(|(what, help)| self.wrong(point, "kernel", &what, Some(help.to_owned())));
        }
        let kernel = Kernel::from_bytes(&shown, &bytes).map_err(|e| {
            let shapes = matches!(e, KernelFileError::Array(_) | KernelFileError::Kernel(_));
            let help = shapes.then(|| SHAPES.to_owned());
            self.wrong(point, "kernel", &e.in_file(&shown), help)
        })?;
        Ok(vec![kernel])
    }

    /// The chip, and its data as text.
    fn chip(&mut self, point: &Point) -> Result<Option<(Arc<Device>, String)>, Faults> {
        let Some(name) = point.word("chip") else {
            return Ok(None);
        };
        if let Some(known) = self.chips.get(name) {
            return Ok(Some(known.clone()));
        }
        let beside = self.folder.join(name);
        let shipped = Device::shipped().any(|shipped| shipped == name);
        let found = if !shipped && beside.is_dir() {
            Device::load(&beside)
        } else {
            Device::find(name)
        };
        let device = found.map_err(|e| {
            let help = e.help().map(|help| help.to_string());
            self.wrong(point, "chip", &e.to_string(), help)
        })?;
        // What it extends is in it. Of a shipped chip all that was read: it is the same in every
        // folder.
        let data = if shipped {
            format!("{device:?}")
        } else {
            device.substance()
        };
        let data = hex(&Sha256::digest(data.as_bytes())[..16]);
        let known = (Arc::new(device), data);
        self.chips.insert(name.to_owned(), known.clone());
        Ok(Some(known))
    }
}

/// 128 bits of the hash of a description.
fn identity(description: &Json) -> String {
    hex(&Sha256::digest(description.to_string().as_bytes())[..16])
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// A chip of one's own is the same in any folder and under any comment; with another statement
    /// it is another.
    #[test]
    fn a_chip_of_a_folder_is_what_it_does() {
        let folder = tempfile::tempdir().unwrap();
        let chip = |beside: &str, macros: &str| {
            let own = folder.path().join(beside).join("own");
            fs::create_dir_all(&own).unwrap();
            let device = "name = \"own\"\ntitle = \"Own\"\nextends = \"scamp5\"\n";
            fs::write(own.join("device.toml"), device).unwrap();
            fs::write(own.join("macros.scamp"), macros).unwrap();
            let text = "scene = \"pattern:disc?width=16&height=12&frames=3\"\nkernel = \"dvs\"\nthreshold = 20\n\
                [[side]]\nside = \"array\"\nchip = \"own\"\n";
            let study = Study::parse("study.toml", text).unwrap();
            let point = study.points().unwrap().remove(0);
            let folder = folder.path().join(beside);
            let mut opened = Opened::new(&study, &folder);
            opened.chip(&point).unwrap().unwrap().1
        };
        let body = "macro copied(out y: areg, x: areg) {\n    mov(y, x);\n}\n";
        let first = chip("one", &format!("/// y := x\n{body}"));
        let other = chip("two", &format!("// Of ours.\n\n/// A copy.\n{body}"));
        assert_eq!(first, other);
        let other = body.replace("mov(y, x);", "bus(NEWS, x);\n    bus(y, NEWS);");
        assert_ne!(first, chip("three", &format!("/// y := x\n{other}")));
        let other = body.replace("copied", "moved");
        assert_ne!(first, chip("four", &format!("/// y := x\n{other}")));
    }

    /// What version 3 said of points of one kernel, whose identities differ by the version alone.
    /// That of an array also changes with the data of its chip, and all with the light of a disc,
    /// which is the mean over each pixel since version 8.
    #[test]
    fn points_of_one_kernel_are_described_as_ever() {
        let text = "scene = \"pattern:disc?width=32&height=24&frames=8&radius=6\"\nkernel = \"csdvs-3\"\n\
            [[side]]\nside = \"reference\"\nthreshold = { on = 30, off = 24, sigma = 2 }\nmemory = \"raw-snap\"\nseed = 5\n\
            [[side]]\nside = \"array\"\nthreshold = 20\nquantise = \"ternary\"\nmemory = \"bits:6\"\ndomain = \"silicon\"\nseed = 1\n";
        let study = Study::parse("study.toml", text).unwrap();
        let mut opened = Opened::new(&study, Path::new(""));
        let mut found = Vec::new();
        for point in study.points().unwrap() {
            let chip = opened.chip(&point).unwrap();
            let chip = chip.as_ref().map(|(_, data)| data.as_str());
            let Entry {
                scene,
                kernels,
                task,
                point,
                ..
            } = opened.entry(point).unwrap();
            let description = opened.description(3, &point, (&scene, &kernels, chip));
            found.push([identity(&description), task]);
        }
        let of_version_3 = [
            [
                "d6bbedc829ca27276a5a68abfbe8bafd",
                "18ceda3694692cbc9b33c29e316897ba",
            ],
            [
                "6b45983ff883586b71ddf7aea746e83c",
                "9a3a075d36e9260c726631fc0d90a587",
            ],
        ];
        assert_eq!(found, of_version_3);
    }
}
