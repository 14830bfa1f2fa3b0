//! The sensor files of `sensors/`: each is read, says where it comes from, is named in
//! `docs/reference.md`, sees the bundled clip and a drawn pattern, and is silent on a still
//! scene. The files of `sensors/authors/` give the counts of the authors' released simulator
//! when fed its own clips as 8-bit light (`tests/oracle/`, README there).

mod npz;

use std::{
    fs,
    path::{Path, PathBuf},
};

use amacrine::{
    event::{Packet, Polarity},
    kernel::Kernel,
    plane::{Plane, Size},
    reference::{Counts, Description, MemoryRule, Noise, Reference, RefractoryRule},
    scene::{
        Frame, OpenOptions, Outline, Scene, SceneError, bundled, open,
        upsample::{Bound, Upsampled, Upsampling},
    },
    sensor::Sensor,
};
use ndarray::{Array3, Array4, ArrayD, s};
use ndarray_npy::read_npy;
use npz::Npz;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every sensor file, as a path from the root of the repository.
fn files() -> Vec<PathBuf> {
    let mut files = Vec::new();
    for folder in ["sensors", "sensors/authors"] {
        for entry in root().join(folder).read_dir().unwrap() {
            let name = entry.unwrap().file_name();
            if Path::new(&name).extension().is_some_and(|e| e == "toml") {
                files.push(Path::new(folder).join(name));
            }
        }
    }
    files.sort();
    assert!(files.len() > 25, "only {} sensor files", files.len());
    files
}

fn read(file: &Path) -> Description {
    let path = root().join(file);
    let folder = path.parent().unwrap().to_owned();
    let text = fs::read_to_string(&path).unwrap();
    let shown = file.display().to_string();
    Description::parse(&shown, &text, &|name| fs::read(folder.join(name)))
        .unwrap_or_else(|e| panic!("{e}"))
}

fn watch(description: Description, scene: &mut dyn Scene) -> (u64, Packet) {
    let channels = description.channels.len() as u8;
    let mut reference = Reference::new(description, scene.size(), 1).unwrap();
    let mut packet = Packet::new(scene.size(), channels);
    while let Some(frame) = scene.next_frame().unwrap() {
        reference.watch(&frame, &mut packet).unwrap();
    }
    (reference.report().events, packet)
}

/// The first frames of the bundled clip, cut to where something moves.
struct Corner {
    clip: Box<dyn Scene>,
    left: usize,
}

impl Scene for Corner {
    fn outline(&self) -> Outline {
        Outline {
            frames: Some(self.left as u64),
            ..Outline::new(Size::new(64, 64), self.clip.fps())
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        let cut = |frame: Frame| Frame {
            light: frame.light.slice(s![32..96, 32..96]).to_owned().into(),
            ..frame
        };
        Ok(self.clip.next_frame()?.map(cut))
    }
}

#[test]
fn every_file_sees_the_bundled_clip_and_a_pattern() {
    for file in files() {
        let description = read(&file);
        let clip = Corner {
            clip: bundled().unwrap(),
            left: 3,
        };
        // The authors' cells never fire where frames are closer than the refractory period.
        let authors = description.refractory.rule == RefractoryRule::Authors;
        let bound = Bound::Contrast {
            contrast: if authors { 0.5 } else { 0.1 },
            offset: 1.0,
        };
        let how = Upsampling {
            bound,
            ..Upsampling::default()
        };
        let mut clip = Upsampled::new(clip, how).unwrap();
        let (events, packet) = watch(description.clone(), &mut clip);
        assert!(events > 0, "{}: nothing in the clip", file.display());
        assert_eq!(packet.events.len() as u64, events, "{}", file.display());
        let pattern = "pattern:disc?width=40&height=30&frames=24&radius=10";
        let mut pattern = open(pattern, &OpenOptions::default()).unwrap();
        let (events, packet) = watch(description.clone(), &mut pattern);
        assert!(events > 0, "{}: nothing in the pattern", file.display());
        assert!(packet.events.is_sorted_by_key(|e| e.t));
        // Every kind of cell has something to say about a moving bar.
        for channel in 0..description.channels.len() {
            let of = packet.events.iter().any(|e| e.channel as usize == channel);
            assert!(of, "{}: channel {channel} is silent", file.display());
        }
    }
}

#[test]
fn every_file_says_where_it_comes_from_and_is_documented() {
    let page = fs::read_to_string(root().join("docs/reference.md")).unwrap();
    for file in files() {
        let text = fs::read_to_string(root().join(&file)).unwrap();
        let shown = file.display().to_string();
        assert!(text.contains("\nsource = \""), "{shown} has no source");
        let authors = if shown.contains("authors") {
            "authors-"
        } else {
            ""
        };
        let name = format!("{authors}{}", file.file_stem().unwrap().display());
        assert_eq!(read(&file).name, name, "{shown} names itself otherwise");
        assert!(
            page.contains(&format!("`{shown}`")),
            "docs/reference.md does not name {shown}"
        );
    }
}

/// Something with every grey, the same at every frame.
fn still(frames: u64) -> impl Iterator<Item = Frame> {
    let light = Plane::from_shape_fn((19, 23), |(y, x)| ((y * 97 + x * 57) % 256) as f64);
    (0..frames).map(move |index| Frame {
        index,
        seconds: 7.0 + index as f64 / 240.0,
        light: light.clone().into(),
    })
}

fn silent(description: Description, what: &str) {
    let mut reference = Reference::new(description, Size::new(19, 23), 1).unwrap();
    let mut packet = Packet::new(Size::new(19, 23), reference.channels());
    for frame in still(5) {
        reference.watch(&frame, &mut packet).unwrap();
        assert_eq!(
            packet.events.len(),
            0,
            "{what}: events at frame {}",
            frame.index
        );
    }
}

#[test]
fn a_still_scene_without_noise_is_silent_from_its_first_frame() {
    for file in files() {
        let mut description = read(&file);
        description.noise = Noise::NONE;
        silent(description, &file.display().to_string());
    }
    let responses = [
        "\"identity\"",
        "{ linear = 255 }",
        "{ log = { white = 255, offset = 1e-3 } }",
        "{ lin-log = { knee = 20 } }",
    ];
    let rules = [
        "memory = \"raw-snap\"",
        "memory = \"raw-snap\"\npolarity = \"pixel\"",
        "memory = \"raw-snap\"\nshared = true",
        "memory = \"filtered-snap\"",
        "memory = \"filtered-snap\"\npolarity = \"pixel\"",
        "memory = \"filtered-step\"",
        "memory = \"filtered-step\"\nrefractory = { us = 1000, rule = \"authors\" }",
        "memory = \"authors-pixel-step\"",
    ];
    let borders = ["replicate", "zero"];
    for (response, rule, border) in responses
        .iter()
        .flat_map(|a| rules.iter().map(move |b| (a, b)))
        .flat_map(|(a, b)| borders.iter().map(move |c| (a, b, c)))
    {
        let memory_kernel = if rule.contains("authors-pixel") {
            "memory-kernel = \"csdvs-3\""
        } else {
            ""
        };
        let text = format!(
            "response = {response}\n{rule}\nborder = \"{border}\"\n[[channel]]\nkernel = \"csdvs-3\"\n{memory_kernel}\nthreshold = {{ on = 1e-6, off = 1e-6, sigma = 1e-7 }}\n"
        );
        let description = Description::parse("still.toml", &text, &|_| unreachable!()).unwrap();
        let mut filtered = description.clone();
        filtered.noise.cutoff_hz = 100.0;
        silent(description, &text);
        silent(filtered, &text);
    }
}

/// A memory of pixels that is seen through another kernel than the light is off at first by
/// `(W - W_m) * u`: a still scene fires where that reaches a threshold, which is told of.
#[test]
fn a_still_scene_fires_where_the_memorys_kernel_is_another() {
    let size = Size::new(9, 9);
    let sensor = |response: &str, border: &str, [kernel, memory]: [&str; 2], threshold: f64| {
        let text = format!(
            "response = {response}\nmemory = \"authors-pixel-step\"\nborder = \"{border}\"\n[[channel]]\nkernel = {kernel}\nmemory-kernel = {memory}\nthreshold = {{ on = {threshold}, off = {threshold} }}\n"
        );
        Description::parse("still.toml", &text, &|_| unreachable!()).unwrap()
    };
    let fires = |sensor: &Description, light: &Plane<f64>| {
        let mut reference = Reference::new(sensor.clone(), size, 0).unwrap();
        let mut packet = Packet::new(size, 1);
        for index in 0..2 {
            let light = light.clone().into();
            let seconds = index as f64 / 100.0;
            let frame = Frame {
                index,
                seconds,
                light,
            };
            reference.watch(&frame, &mut packet).unwrap();
        }
        !packet.events.is_empty()
    };
    let uniform = |light: f64| Plane::from_elem(size.shape(), light);
    // W - W_m is 0.1: 200 is 20 off, and 255 25.5.
    let weaker = ["[[0.6]]", "[[0.5]]"];
    let identity = |threshold| sensor("\"identity\"", "replicate", weaker, threshold);
    assert!(fires(&identity(19.9), &uniform(200.0)));
    assert!(!fires(&identity(20.1), &uniform(200.0)));
    let [most, threshold] = identity(20.1).still().unwrap();
    assert!((most - 25.5).abs() < 1e-9 && threshold == 20.1, "{most}");
    assert_eq!(identity(25.6).still(), None);
    assert!(!fires(&identity(25.6), &uniform(255.0)));
    // The kernels may differ in where their weights are alone: uniform light is silent then.
    let stripes = Plane::from_shape_fn(size.shape(), |(_, x)| 255.0 * (x % 2) as f64);
    let moved = ["[[0.2]]", "[[0.1, 0, 0.1]]"];
    let linear = |threshold| sensor("{ linear = 255 }", "replicate", moved, threshold);
    assert!(!fires(&linear(0.15), &uniform(255.0)));
    assert!(fires(&linear(0.15), &stripes));
    assert!(linear(0.15).still().is_some());
    assert!(!fires(&linear(0.25), &stripes));
    assert_eq!(linear(0.25).still(), None);
    // The signal of black is below 0 in a logarithm.
    for border in ["replicate", "zero"] {
        let log = "{ log = { white = 255, offset = 1e-3 } }";
        let odd = sensor(log, border, ["[[0.6]]", "[[0, 0.6, 0.01]]"], 0.05);
        assert!(fires(&odd, &uniform(0.0)), "{border}");
        assert!(odd.still().is_some(), "{border}");
    }
    // The same kernel never does, whatever the threshold.
    let same = sensor("\"identity\"", "zero", ["[[0.6]]", "[[0.6]]"], 1e-6);
    assert!(!fires(&same, &stripes));
    assert_eq!(same.still(), None);
    for file in files() {
        assert_eq!(read(&file).still(), None, "{}", file.display());
    }
}

/// The stored modes that are built in: oracle file, sensor file.
const MODES: [(&str, &str); 7] = [
    ("dvs_lin", "dvs"),
    ("csdvs_lin", "csdvs"),
    ("csdvs_new_lin", "csdvs-new"),
    ("csdvs_new_new_lin", "csdvs-new-new"),
    ("csdvs_new_new_k3_lin", "csdvs-new-new-3"),
    ("dog_lin", "dog"),
    ("dog_amp_lin", "dog-amplitudes"),
];

#[test]
fn the_authors_files_give_the_authors_counts() {
    let mut events = 0;
    for clip in ["mini_camera_15x21", "mini_random_16x20"] {
        let folder = root().join("tests/oracle").join(clip);
        let light: Array3<f32> = read_npy(folder.join("frames_u0_255.npy")).unwrap();
        for (mode, file) in MODES {
            for refractory in ["r0", "r1"] {
                let path = folder.join(format!("{mode}_{refractory}.npz"));
                let mut stored = Npz::open(&path);
                let mut one = |key: &str| -> f64 {
                    let array: ArrayD<f64> = stored.array(key);
                    *array.first().unwrap()
                };
                // The stored runs have thresholds of their own, and no mismatch.
                let mut description =
                    read(&Path::new("sensors/authors").join(format!("{file}.toml")));
                let threshold = &mut description.channels[0].thresholds[0];
                (threshold.on, threshold.off) = (one("pos_thres"), one("neg_thres"));
                threshold.sigma = 0.0;
                description.refractory.us = one("refractory_s") * 1e6;
                assert_eq!(description.memory, MemoryRule::FilteredStep);
                let expected: Array4<i16> = stored.array("N");

                let size = Size::new(light.dim().1, light.dim().2);
                let mut reference = Reference::new(description, size, 0).unwrap();
                let mut counts = Counts::new(size, 1);
                for n in 0..=expected.dim().0 {
                    let frame = Frame {
                        index: n as u64,
                        seconds: n as f64 / 240.0,
                        light: light.slice(s![n, .., ..]).mapv(f64::from).into(),
                    };
                    reference.watch_into(&frame, &mut counts).unwrap();
                    if n > 0 {
                        let want = expected.slice(s![n - 1, 0, .., ..]).mapv(i32::from);
                        assert_eq!(
                            counts.planes()[0],
                            want,
                            "{}, pair {}",
                            path.display(),
                            n - 1
                        );
                    }
                }
                events += reference.report().events;
            }
        }
    }
    assert!(events > 50_000, "only {events} events were compared");
}

/// What a message about an unknown key lists.
fn keys_expected(text: &str) -> Vec<String> {
    let error = Description::parse("keys.toml", text, &|_| unreachable!()).unwrap_err();
    let mut messages = error.faults.iter().map(|located| &located.fault.message);
    let (_, listed) = messages
        .find_map(|message| message.split_once("expected"))
        .unwrap();
    listed
        .split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_key_and_built_in_kernel_is_documented() {
    let page = fs::read_to_string(root().join("docs/reference.md")).unwrap();
    let good = "response = { linear = 255 }\nmemory = \"filtered-step\"\n";
    let channel = "[[channel]]\nkernel = \"dvs\"\n";
    let tables = [
        ("", format!("{good}no-key = 1")),
        ("", format!("{good}{channel}no-key = 1")),
        ("", format!("{good}noise = {{ no-key = 1 }}")),
        (
            "refractory.",
            format!("{good}refractory = {{ no-key = 1 }}"),
        ),
        (
            "threshold.",
            format!("{good}{channel}threshold = {{ no-key = 1 }}"),
        ),
        ("", format!("{good}border = \"no-value\"")),
        ("", format!("{good}polarity = \"no-value\"")),
        (
            "",
            "response = { linear = 255 }\nmemory = \"no-value\"".to_owned(),
        ),
        (
            "",
            format!("{good}refractory = {{ us = 1, rule = \"no-value\" }}"),
        ),
    ];
    let mut keys = 0;
    for (prefix, text) in tables {
        for key in keys_expected(&text) {
            let forms = [
                format!("`{prefix}{key}`"),
                format!("`{key}."),
                format!("`\"{key}\"`"),
            ];
            assert!(
                forms.iter().any(|form| page.contains(form)),
                "docs/reference.md does not say what {prefix}{key} is"
            );
            keys += 1;
        }
    }
    assert!(keys > 35, "only {keys} keys");
    for name in Kernel::builtin_names() {
        assert!(
            page.contains(&format!("`{name}`")),
            "docs/reference.md does not name the kernel {name}"
        );
    }
}

fn parsed(channel: &str, read: &dyn Fn(&str) -> std::io::Result<Vec<u8>>) -> Description {
    let text = format!(
        "response = {{ linear = 255 }}\nmemory = \"filtered-step\"\n[[channel]]\n{channel}\nthreshold = {{ on = 0.05, off = 0.05 }}\n"
    );
    Description::parse("parsed.toml", &text, read).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_negative_gain_exchanges_on_and_off() {
    let seen = |channel: &str| {
        let mut disc = open(
            "pattern:disc?width=30&height=20&frames=9",
            &OpenOptions::default(),
        )
        .unwrap();
        watch(parsed(channel, &|_| unreachable!()), &mut disc)
            .1
            .events
    };
    let on = seen("kernel = \"csdvs-5\"");
    assert!(on.len() > 100);
    let mut off = seen("kernel = \"csdvs-5\"\ngain = -1");
    for event in &mut off {
        event.polarity = match event.polarity {
            Polarity::On => Polarity::Off,
            Polarity::Off => Polarity::On,
        };
    }
    assert_eq!(on, off);
    let weights = |channel: &str| {
        let read = parsed(channel, &|_| unreachable!());
        read.channels[0].kernels[0].weights().clone()
    };
    let half = weights("kernel = \"sobel-x\"\ngain = 0.5");
    assert_eq!(half, weights("kernel = \"sobel-x\"") * 0.5);
}

#[test]
fn kernels_may_be_files_beside_the_sensor_file() {
    let rows = ndarray::arr2(&[[0.0, -0.25, 0.0], [-0.25, 1.0, -0.5], [0.125, 0.0, 7.0]]);
    let mut array = Vec::new();
    ndarray_npy::WriteNpyExt::write_npy(&rows, &mut array).unwrap();
    let read = |name: &str| match name {
        "learned/k.npy" => Ok(array.clone()),
        "hand.toml" => Ok(b"weights = [[0, -0.25, 0], [-0.25, 1, -0.5], [0.125, 0, 7]]".to_vec()),
        _ => Err(std::io::ErrorKind::NotFound.into()),
    };
    for name in ["learned/k.npy", "hand.toml"] {
        let description = parsed(&format!("kernel = \"{name}\""), &read);
        assert_eq!(description.channels[0].kernels[0].weights(), rows);
    }
}
