//! What those who use the library rely on, and the command line does not show.

use amacrine::{
    event::{Event, Packet, Polarity},
    plane::{Plane, Size},
    reference::{Description, Reference},
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
