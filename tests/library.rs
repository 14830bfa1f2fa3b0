//! What those who use the library rely on, and the command line does not show.

use std::{error::Error, io};

use amacrine::{
    array::{Arithmetic, Settings},
    compile::{Effort, Request},
    event::{
        Event, Packet, Polarity, file,
        tensor::{
            Alignment, Container, Fill, Layers, Precision, Sides, TensorError, TensorFile,
            TimeSurface, VoxelStream, Voxels, Windows, frames,
        },
    },
    gradient::{self, GradientError},
    isa::{Analog, Device},
    kernel::{Gaussian, Kernel, KernelError},
    mosaic::Mosaic,
    npy,
    photoreceptor::{Curve, Response},
    plane::{At, Plane, Size},
    program::{Overrides, Program},
    reference::{
        Counts, Description, Interval, MemoryRule, Reference, RefractoryRule, SheetRule, Surrounds,
        Tally, VoxelGrid,
    },
    rig,
    scene::{Frame, OpenOptions, open},
    sensor::{Sensor, SensorError},
    unit::Micros,
};

/// A sensor that knows nothing of packets but their events.
struct Bare;

impl Sensor for Bare {
    fn name(&self) -> &'static str {
        "bare"
    }

    fn size(&self) -> Size {
        Size::new(5, 6)
    }

    fn channels(&self) -> u8 {
        2
    }

    fn names(&self) -> Vec<String> {
        ["one", "other"].map(str::to_owned).to_vec()
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        if frame.index > 0 {
            packet.events.push(Event {
                t: Micros::from_seconds(frame.seconds),
                x: 1,
                y: 2,
                polarity: Polarity::On,
                channel: 1,
            });
        }
        Ok(())
    }
}

#[test]
fn packets_know_their_span_and_their_kinds() {
    let spec = "pattern:bar?width=6&height=5&frames=9&fps=40";
    let mut scene = open(spec, &OpenOptions::default()).unwrap();
    let float = Description::open("rgc-4").unwrap();
    let names = float.names();
    let mut float = Reference::new(float, scene.size(), 0).unwrap();
    let packets = rig::watch(&mut *scene, &mut [&mut Bare, &mut float], |_| {}).unwrap();
    for packet in &packets {
        assert_eq!(packet.span, (Micros(0), Micros(200_000)));
    }
    assert_eq!(packets[0].names, ["one", "other"]);
    assert_eq!(packets[1].names, names);
    assert_eq!(names.len(), 4);
}

/// Light that rises evenly crosses a threshold of 20 four times, wherever time begins.
#[test]
fn times_do_not_depend_on_where_time_begins() {
    let text = "memory = \"filtered-step\"\nresponse = \"identity\"\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 20, off = 20 }";
    let none = |_: &str| Err(std::io::Error::other("nothing is read"));
    let description = Description::parse("steps", text, &none).unwrap();
    let times = |begin: f64| -> Vec<u64> {
        let mut sensor = Reference::new(description.clone(), Size::new(1, 1), 0).unwrap();
        let mut packet = Packet::new(Size::new(1, 1), 1);
        for (index, light) in [(0, 0.0), (1, 90.0)] {
            let frame = Frame {
                index,
                seconds: begin + index as f64,
                light: Plane::from_elem((1, 1), light).into(),
            };
            sensor.watch(&frame, &mut packet).unwrap();
        }
        packet.events.iter().map(|event| event.t.0).collect()
    };
    assert_eq!(times(0.0), [222_222, 444_444, 666_667, 888_889]);
    assert_eq!(times(-0.5), [0, 0, 166_667, 388_889]);
    assert_eq!(times(2.0), [2_222_222, 2_444_444, 2_666_667, 2_888_889]);
}

/// What a file cannot say, code cannot either.
#[test]
fn descriptions_that_cannot_be_are_refused() {
    let good = Description::open("rgc").unwrap();
    good.check().unwrap();
    let refused = |change: &dyn Fn(&mut Description), words: &str| {
        let mut odd = good.clone();
        change(&mut odd);
        let error = Reference::new(odd, Size::new(4, 4), 0).err().unwrap();
        let said = error.to_string();
        assert!(said.contains(words), "{said}");
    };
    refused(&|it| it.channels.clear(), "0 kinds");
    refused(&|it| it.channels[0].thresholds.clear(), "0 thresholds");
    refused(&|it| it.channels[0].kernels.clear(), "0 kernels");
    refused(&|it| it.channels[0].thresholds[0].on = 0.0, "ON 0");
    refused(&|it| it.channels[0].thresholds[0].off = f64::NAN, "OFF NaN");
    refused(&|it| it.noise.shot_hz = f64::INFINITY, "shot_hz of inf");
    refused(&|it| it.noise.hot_fraction = -0.5, "hot_fraction of -0.5");
    refused(&|it| it.refractory.us = -1.0, "-1 us");
    let kind = good.channels[0].clone();
    refused(&|it| it.channels = vec![kind.clone(); 300], "300 kinds");
    let large = Reference::new(good.clone(), Size::new(65_536, 65_536), 0);
    assert!(matches!(large, Err(SensorError::Addresses { .. })));
}

const STEPS: &str = "memory = \"filtered-step\"\nresponse = \"identity\"\n[[channel]]\nkernel = [[1]]\nthreshold = { on = 20, off = 20 }";

fn described(text: &str) -> Description {
    Description::parse("t", text, &|_| {
        Err(std::io::Error::other("nothing is read"))
    })
    .unwrap()
}

fn frame(index: u64, light: Plane<f64>) -> Frame {
    Frame {
        index,
        seconds: 0.1 * index as f64,
        light: light.into(),
    }
}

fn event(t: u64, x: u16, y: u16) -> Event {
    Event {
        t: Micros(t),
        x,
        y,
        polarity: Polarity::On,
        channel: 0,
    }
}

/// The last pixel of many bands has no light: nothing of the frame happens, and the repaired one
/// gives what it would have.
#[test]
fn a_frame_that_is_refused_leaves_the_sensor_as_it_was() {
    let size = Size::new(256, 64);
    let dark = Plane::from_elem(size.shape(), 1.0);
    // Patches, which a surround sees too.
    let patch = |(y, x): (usize, usize)| [1.0, 101.0][(y / 4 + x / 4) % 2];
    let bright = Plane::from_shape_fn(size.shape(), patch);
    let mut damaged = bright.clone();
    damaged[(255, 63)] = f64::NAN;
    let noise = "\n[noise]\nshot-hz = 100\ncutoff-hz = 300\n[[channel]]";
    let noisy = STEPS.replace("\n[[channel]]", noise);
    let mesh = STEPS.replace("kernel = [[1]]", "mesh = { lambda = 2, tau-us = 9000 }");
    for text in [
        STEPS,
        &STEPS.replace("filtered-step", "filtered-snap"),
        &STEPS.replace("filtered-step", "raw-snap"),
        &noisy,
        &mesh,
    ] {
        let [tried, straight] = [true, false].map(|tries| {
            let mut sensor = Reference::new(described(text), size, 1).unwrap();
            let mut packet = Packet::new(size, 1);
            if tries {
                let first = sensor.watch(&frame(0, damaged.clone()), &mut packet);
                assert!(matches!(first, Err(SensorError::Light { .. })));
            }
            sensor.watch(&frame(0, dark.clone()), &mut packet).unwrap();
            if tries {
                let error = sensor.watch(&frame(1, damaged.clone()), &mut packet);
                let said = error.unwrap_err().to_string();
                assert_eq!(
                    said,
                    "frame 1, x = 63, y = 255: the light is NaN, which is not finite"
                );
                assert!(packet.events.is_empty());
            }
            sensor
                .watch(&frame(1, bright.clone()), &mut packet)
                .unwrap();
            (
                packet,
                sensor.memory(0).unwrap(),
                format!("{:?}", sensor.report()),
            )
        });
        assert!(straight.0.events.len() > 1000);
        assert_eq!(tried, straight, "{text}");
    }
}

/// What cannot be told beforehand stops some cells, and no frame after it is taken.
#[test]
fn a_sensor_that_stopped_half_way_says_so() {
    let size = Size::new(256, 64);
    let mut sensor = Reference::new(described(STEPS), size, 0).unwrap();
    let mut packet = Packet::new(size, 1);
    let mut light = Plane::from_elem(size.shape(), 1.0);
    sensor.watch(&frame(0, light.clone()), &mut packet).unwrap();
    let before = sensor.clone();
    light[(255, 63)] = 1e300;
    let error = sensor.watch(&frame(1, light.clone()), &mut packet);
    assert!(matches!(error, Err(SensorError::Uncountable { .. })));
    light[(255, 63)] = 1.0;
    let error = sensor
        .watch(&frame(1, light.clone()), &mut packet)
        .unwrap_err();
    assert!(matches!(error, SensorError::Halfway { .. }));
    let said = error.to_string();
    assert!(said.starts_with("t failed in an earlier frame"), "{said}");
    let mut again = before;
    again.watch(&frame(1, light), &mut packet).unwrap();
}

/// One rule for files and for code: what is checked is written as a file that can be read.
#[test]
fn what_a_file_cannot_say_code_cannot_either() {
    let refused = |text: &str, change: &dyn Fn(&mut Description), words: &str| {
        let mut odd = described(text);
        odd.check().unwrap();
        change(&mut odd);
        let said = odd.check().unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
        assert!(Reference::new(odd.clone(), Size::new(4, 5), 0).is_err());
        let none = |_: &str| Err(std::io::Error::other("nothing is read"));
        assert!(
            Description::parse("t", &odd.to_toml(), &none).is_err(),
            "{words}"
        );
    };
    let curve = |curve| move |it: &mut Description| it.response = Response::new(curve);
    for white in [0.0, -255.0, f64::NAN, f64::INFINITY] {
        refused(
            STEPS,
            &curve(Curve::Linear { white }),
            "a response with white of",
        );
    }
    let (white, offset) = (255.0, 0.0);
    refused(STEPS, &curve(Curve::Log { white, offset }), "offset of 0");
    refused(STEPS, &curve(Curve::LinLog { knee: 1.0 }), "knee of 1");
    refused(
        STEPS,
        &|it| {
            it.response = Response {
                curve: Curve::LinLog { knee: 20.0 },
                round_f32: true,
            };
        },
        "rounding to f32",
    );
    let raw = &STEPS.replace("filtered-step", "raw-snap");
    refused(
        raw,
        &|it| it.noise.leak_hz = 5.0,
        "this memory holds pixels",
    );
    refused(
        raw,
        &|it| it.channels[0].log_temporal = true,
        "log-temporal is the logarithm of the filtered signal",
    );
    let authors = "\nrefractory = { us = 10, rule = \"authors\" }\n[[channel]]";
    let authors = &STEPS.replace("\n[[channel]]", authors);
    refused(
        authors,
        &|it| it.noise.leak_hz = 1.0,
        "the authors' refractory rule",
    );
    refused(
        authors,
        &|it| it.memory = MemoryRule::FilteredSnap,
        "this memory snaps",
    );
    let kernel = |weight: f64| Kernel::from_rows(&[vec![weight]]).unwrap();
    refused(
        STEPS,
        &|it| it.channels[0].memory_kernel = Some(kernel(1.0)),
        "memory-kernel is only for",
    );
    let pixels = &format!(
        "{}\nmemory-kernel = [[1]]",
        authors.replace("filtered-step", "authors-pixel-step")
    );
    refused(
        pixels,
        &|it| it.channels[0].memory_kernel = Some(kernel(50.0)),
        "is unstable",
    );
    refused(
        pixels,
        &|it| it.refractory.rule = RefractoryRule::DeadTime,
        "rule is its own",
    );
    let mesh = &STEPS.replace("kernel = [[1]]", "mesh = { lambda = 3 }");
    refused(
        mesh,
        &|it| it.memory = MemoryRule::RawSnap,
        "in place of a kernel",
    );
    refused(
        mesh,
        &|it| it.channels[0].log_temporal = true,
        "in place of a kernel",
    );
    let sheets = |change: fn(&mut Surrounds)| {
        move |it: &mut Description| it.channels[0].surrounds.iter_mut().for_each(change)
    };
    refused(
        mesh,
        &sheets(|it| it.sheets.clear()),
        "a mesh without sheets",
    );
    refused(mesh, &sheets(|it| it.sheets[0].tau = -1.0), "tau of");
    refused(mesh, &sheets(|it| it.centre = f64::NAN), "centre of NaN");
    let v2e = |it: &mut Surrounds| (it.rule, it.sheets[0].noise) = (SheetRule::V2e, 1.0);
    refused(mesh, &sheets(v2e), "v2e's sheet");
}

#[test]
fn models_and_their_ways_back_are_checked() {
    let size = Size::new(2, 2);
    let model = |description, size| gradient::Model::<f64>::new(description, size, 0);
    let refused = |change: &dyn Fn(&mut Description), words: &str| {
        let mut odd = described(STEPS);
        change(&mut odd);
        let said = model(odd, size).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
    };
    refused(&|it| it.channels.clear(), "0 kinds of cells");
    refused(
        &|it| it.channels[0].kernels.clear(),
        "0 kernels and 1 threshold",
    );
    refused(
        &|it| it.channels[0].thresholds.clear(),
        "1 kernel and 0 thresholds",
    );
    refused(&|it| it.channels[0].thresholds[0].on = -5.0, "ON -5");
    refused(&|it| it.refractory.us = f64::NAN, "NaN us");
    let light = [0.0, 0.0, 0.0, 0.0, 100.0, 100.0, 100.0, 0.0];
    let clips = || gradient::Clips::new(&light, &[0.0, 1.0], size).unwrap();
    let own = model(described(STEPS), size).unwrap();
    let seen = own.forward(clips()).unwrap();
    let ask = gradient::Ask {
        events: 1.0,
        ..gradient::Ask::default()
    };
    own.backward(&seen, &ask, own.rule()).unwrap();
    let wide = STEPS.replace("[[1]]", "[[0, 0, 0], [0, 1, 0], [0, 0, 0]]");
    let two = STEPS.to_owned() + "\n[[channel]]\nkernel = [[1]]\nthreshold = { on = 1, off = 1 }";
    let rests = STEPS.replace("\n[[channel]]", "\nrefractory = { us = 10 }\n[[channel]]");
    for (text, size) in [
        (STEPS, Size::new(5, 5)),
        (&wide, size),
        (&two, size),
        (&rests, size),
    ] {
        let other = model(described(text), size).unwrap();
        let error = other.backward(&seen, &ask, other.rule()).unwrap_err();
        assert!(matches!(error, GradientError::Forward { .. }), "{error}");
    }
    let counts = gradient::Ask {
        counts: Some(&[1.0]),
        ..ask
    };
    let error = own.backward(&gradient::Forward::default(), &counts, own.rule());
    assert_eq!(
        error.unwrap_err().to_string(),
        "what goes back was made by a model of nothing, and this one is of 2x2, 1 channel, kernels of 1x1, a memory that steps"
    );
}

/// A sink for a sensor of another shape takes nothing, and the sensor does not move.
#[test]
fn sinks_of_another_shape_are_refused() {
    let size = Size::new(4, 5);
    let dark = frame(0, Plane::zeros(size.shape()));
    let bright = frame(1, Plane::from_elem(size.shape(), 50.0));
    let mut sensor = Reference::new(described(STEPS), size, 0).unwrap();
    let shapes = [
        (4, 4, 1),
        (4, 6, 1),
        (3, 5, 1),
        (5, 5, 1),
        (4, 5, 0),
        (4, 5, 2),
    ];
    for (height, width, kinds) in shapes {
        let other = Size::new(height, width);
        let mut packet = Packet::new(other, kinds as u8);
        for seen in [
            sensor.watch_into(&dark, &mut Counts::new(other, kinds)),
            sensor.watch_into(&dark, &mut VoxelGrid::new(other, kinds)),
            sensor.watch_into(&dark, &mut (&mut Tally::new(9), Some(&mut Tally::new(1)))),
            sensor.watch(&dark, &mut packet),
        ] {
            assert!(
                matches!(seen, Err(SensorError::Sink { .. })),
                "{other} {kinds}"
            );
        }
    }
    let error = sensor.watch_into(&dark, &mut VoxelGrid::new(Size::new(4, 4), 1));
    assert_eq!(
        error.unwrap_err().to_string(),
        "voxels of 4x4 and 1 kind of cells, the sensor is 5x4 with 1 kind of cells"
    );
    let mut voxels = VoxelGrid::new(size, 1);
    sensor.watch_into(&dark, &mut voxels).unwrap();
    sensor.watch_into(&bright, &mut voxels).unwrap();
    assert!(voxels.earlier()[0].sum() > 0.0);
}

#[test]
fn tensors_refuse_events_outside_and_what_no_machine_holds() {
    let mut packet = Packet::new(Size::new(3, 4), 1);
    packet.span = (Micros(0), Micros(40));
    let windows = Windows::new(1e-3, 1e-3, Alignment::Causal).unwrap();
    let voxels = Voxels::new(2, windows).unwrap();
    let surface = TimeSurface::new(0.1).unwrap();
    for odd in [
        event(10, 4, 0),
        event(10, 0, 3),
        Event {
            channel: 1,
            ..event(10, 0, 0)
        },
    ] {
        packet.events = vec![event(5, 1, 1), odd];
        let mut stream = VoxelStream::new(voxels, packet.size, 1);
        for error in [
            voxels.of(&packet).unwrap_err(),
            frames(&packet, 9, Sides::Signed, Fill::Count).unwrap_err(),
            surface.of(&packet, &[Micros(40)]).unwrap_err(),
            stream.add(&packet.events).unwrap_err(),
        ] {
            let said = error.to_string();
            assert!(said.ends_with("in a packet of 4x3 and 1 channel"), "{said}");
        }
    }
    // The time of the day, in windows from 1970 on.
    let mut packet = Packet::new(Size::new(256, 256), 1);
    packet.events = vec![event(1_764_000_000_000_000, 1, 1)];
    let error = voxels.of(&packet).unwrap_err();
    assert!(matches!(error, TensorError::Room { .. }), "{error}");
    let mut stream = VoxelStream::new(voxels, packet.size, 1);
    assert!(stream.add(&packet.events).is_err());
}

/// An event that comes when its window is over is in no window, and is counted as such.
#[test]
fn late_events_are_counted() {
    let windows = Windows::new(1e-3, 1e-3, Alignment::Causal).unwrap();
    let voxels = Voxels::new(1, windows).unwrap();
    let mut stream = VoxelStream::new(voxels, Size::new(3, 4), 1);
    let none = |_: &[f32]| Ok::<(), TensorError>(());
    stream.pass(&[event(5000, 0, 0)], none).unwrap();
    assert_eq!((stream.lost(), stream.between()), (0, 0));
    stream.pass(&[event(500, 0, 0)], none).unwrap();
    assert_eq!((stream.lost(), stream.between()), (1, 0));
    let apart = Windows::new(1e-3, 2e-3, Alignment::Causal).unwrap();
    let apart = Voxels::new(1, apart).unwrap();
    let mut stream = VoxelStream::new(apart, Size::new(3, 4), 1);
    stream
        .pass(
            &[event(500, 0, 0), event(2500, 0, 0), event(3500, 0, 0)],
            none,
        )
        .unwrap();
    assert_eq!((stream.lost(), stream.between()), (0, 2));
    stream
        .pass(&[event(1500, 0, 0), event(600, 0, 0)], none)
        .unwrap();
    assert_eq!((stream.lost(), stream.between()), (1, 3));
}

#[test]
fn files_of_layers_and_arrays_hold_what_their_header_says() {
    let folder = tempfile::tempdir().unwrap();
    for (name, container) in [
        ("a.npy", Container::Npy),
        ("a.npz", Container::Npz),
        ("a.h5", Container::Hdf5),
    ] {
        let layers = Layers {
            name: "voxels",
            shape: vec![2, 3],
            precision: Precision::Single,
            kinds: Vec::new(),
        };
        let mut file = TensorFile::create(&folder.path().join(name), container, layers).unwrap();
        for length in [4, 7, 0] {
            let said = file.push(&vec![1.0; length]).unwrap_err().to_string();
            assert!(
                said.ends_with("and layers of shape [2, 3] have 6"),
                "{said}"
            );
        }
        file.push(&[1.0; 6]).unwrap();
        assert_eq!(file.finish().unwrap(), 1);
    }
    let error = npy::write(&mut Vec::new(), &[2, 2], [1.0; 3].into_iter()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "3 numbers, and an array of shape [2, 2] has 4"
    );
}

#[test]
fn requests_that_cannot_be_name_their_field() {
    let device = Device::scamp5();
    let kernel = Kernel::from_rows(&[vec![1.0, -2.0, 1.0]]).unwrap();
    let kernels = [kernel.clone(), kernel.negated()];
    let refused = |kernels: &[Kernel], change: &dyn Fn(&mut Request<'_>), words: &str| {
        let mut request = Request::new(kernels, &device).unwrap();
        request.effort = Effort::states(10);
        change(&mut request);
        for said in [
            request.filter().unwrap_err().to_string(),
            request.front().unwrap_err().to_string(),
        ] {
            assert_eq!(said, words);
        }
    };
    let one = &kernels[..1];
    refused(one, &|it| it.into.clear(), "into: 0 registers for 1 kernel");
    refused(
        one,
        &|it| it.into.push(Analog(1)),
        "into: 2 registers for 1 kernel",
    );
    refused(
        one,
        &|it| it.into = vec![Analog(77)],
        "into: <analogue 77> is no register for values",
    );
    refused(
        one,
        &|it| it.input = Analog(77),
        "input: <analogue 77> is no register for values",
    );
    refused(
        &kernels,
        &|it| it.into = vec![Analog(1); 2],
        "into: B twice",
    );
    refused(
        one,
        &|it| it.keep = it.into.clone(),
        "keep: A is kept, and a result goes into it",
    );
    refused(
        one,
        &|it| (it.keep, it.into) = (vec![it.input], vec![Analog(1)]),
        "keep: A is kept, and the input is in it",
    );
    refused(
        one,
        &|it| it.range = Some((1.0, -1.0)),
        "range: from 1 to -1 LSB",
    );
    refused(
        one,
        &|it| it.range = Some((f64::NAN, 1.0)),
        "range: from NaN to 1 LSB",
    );
}

#[test]
fn settings_that_no_array_has_are_named() {
    let device = Device::scamp5();
    let text = include_str!("../programs/dvs/snap.scamp");
    let program = Program::parse("snap", text).unwrap();
    let code = program.expand(&device, &Overrides::default()).unwrap().code;
    let refused = |change: &dyn Fn(&mut Settings), words: &str| {
        let mut settings = Settings::from_device(&device);
        settings.check().unwrap();
        change(&mut settings);
        for arithmetic in ["exact", "q8.8", "silicon"] {
            let arithmetic: Arithmetic = arithmetic.parse().unwrap();
            let made = arithmetic.chip("x", &code, &device, Size::new(4, 5), settings);
            let said = made.err().unwrap().to_string();
            assert!(said.contains(&format!("the setting {words}")), "{said}");
        }
    };
    refused(&|it| it.edge = f64::NAN, "edge is NaN");
    refused(&|it| it.gain = f64::INFINITY, "gain is inf");
    refused(&|it| it.reset_level = f64::NAN, "reset_level is NaN");
    refused(&|it| it.square_gain = f64::NAN, "square_gain is NaN");
    refused(&|it| it.diffusion = 3, "diffusion is 3; 4 or more");
    refused(&|it| it.converters.high = -200.0, "converters.high is -200");
    refused(&|it| it.converters.low = f64::NAN, "converters.low is NaN");
    refused(
        &|it| it.converters.adc_codes = 0.0,
        "converters.adc_codes is 0",
    );
    refused(
        &|it| it.converters.adc_codes = 1000.0,
        "converters.adc_codes is 1000",
    );
    refused(
        &|it| it.converters.dac_codes = 0.0,
        "converters.dac_codes is 0",
    );
}

#[test]
fn small_things_that_cannot_be_are_refused() {
    for sigma in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        let error = Kernel::from_gaussians(&[Gaussian { sigma, gain: 3.0 }]).unwrap_err();
        assert!(matches!(error, KernelError::Sigma { .. }), "{error}");
    }
    let none = Size::new(0, 0);
    let mosaic = Mosaic::new(none, none, 0, Vec::new(), 0);
    assert_eq!(
        (mosaic.size(), mosaic.home(3, 4)),
        (none, At { y: 0, x: 0 })
    );
}

/// The times of a list are those that its interval says.
#[test]
fn lists_round_as_their_intervals_do() {
    let mut sensor = Reference::new(described(STEPS), Size::new(1, 1), 0).unwrap();
    let mut packet = Packet::new(Size::new(1, 1), 1);
    for (index, light) in [(0, 0.0), (1, 90.0)] {
        let light = Plane::from_elem((1, 1), light);
        sensor.watch(&frame(index, light), &mut packet).unwrap();
    }
    let interval = Interval {
        index: 0,
        from: 0.0,
        to: 0.1,
    };
    let places = [20.0, 40.0, 60.0, 80.0].map(|light| interval.micros(light / 90.0));
    let times: Vec<_> = packet.events.iter().map(|event| event.t).collect();
    assert_eq!(times, places);
    // Half a microsecond, and what rounding left just below it.
    let whole = Interval {
        to: 1e-6,
        ..interval
    };
    assert_eq!(
        [0.4999, 0.5 - 1e-12, 0.5].map(|at| whole.micros(at).0),
        [0, 1, 1]
    );
}

/// A cause can be asked for by its type, however deep it lies.
#[test]
fn errors_have_their_sources() {
    fn deepest(error: &(dyn Error + 'static)) -> io::ErrorKind {
        let mut next = Some(error);
        while let Some(error) = next {
            if let Some(system) = error.downcast_ref::<io::Error>() {
                return system.kind();
            }
            next = error.source();
        }
        panic!("{error}: no cause of the system");
    }
    let folder = tempfile::tempdir().unwrap();
    let nothing = folder.path().join("nothing.y4m");
    let scene = open(nothing.to_str().unwrap(), &OpenOptions::default());
    let scene = scene.err().unwrap();
    assert_eq!(deepest(&scene), io::ErrorKind::NotFound);
    let wrapped = rig::RigError::from(scene);
    assert_eq!(deepest(&wrapped), io::ErrorKind::NotFound);
    let text = folder.path().join("nothing.toml");
    let error = Description::open(text).unwrap_err();
    assert_eq!(deepest(&error), io::ErrorKind::NotFound);
    let packet = Packet::new(Size::new(1, 1), 1);
    let error = file::read(&folder.path().join("a.npy")).unwrap_err();
    assert_eq!(deepest(&error), io::ErrorKind::NotFound);
    // A file where a folder would have to be.
    std::fs::write(folder.path().join("flat"), "").unwrap();
    let error = file::write(&folder.path().join("flat/a.npy"), &packet).unwrap_err();
    deepest(&error);
    let cause = SensorError::Halfway {
        sensor: "s".to_owned(),
    };
    let name = "s".to_owned();
    let error = rig::RigError::Sensor { name, cause };
    let source = error.source().unwrap();
    assert!(source.downcast_ref::<SensorError>().is_some());
    let shown = file::Reader::of_bytes(
        "a.csv".as_ref(),
        b"t,x,y,p\n".to_vec(),
        &file::Opening::default(),
    );
    assert!(format!("{:?}", shown.unwrap()).contains("a.csv"));
}
