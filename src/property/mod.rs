//! Property tests of a design against the float model (feature `proptest`).
//!
//! Strategies for what a design meets, and one question: does a program on the array say what a
//! sensor of the float model says, on whatever scene? A scene on which they part is shrunk to
//! the smallest that still shows it.
//!
//! ```
//! use amacrine::{isa::Device, program::Program, property::{Tolerance, assert_agrees}, reference::Description};
//!
//! let program = Program::parse("dvs", include_str!("../../programs/dvs/snap.scamp"))?;
//! let float = "memory = \"filtered-snap\"\nresponse = \"identity\"\n[[channel]]\nkernel = [[1]]\nthreshold = { on = 20, off = 20 }\n";
//! let float = Description::parse("float", float, &|name| Err(std::io::Error::other(name.to_owned())))?;
//! assert_agrees(&program, &float, &Tolerance::default());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A sensor of one's own, of whatever make, against the float model or another:
//!
//! ```
//! use amacrine::{
//!     event::{Event, Packet, Polarity},
//!     plane::{Plane, Size},
//!     property::{Tolerance, assert_sensors_agree},
//!     reference::{Description, Reference},
//!     scene::Frame,
//!     sensor::{Sensor, SensorError},
//!     unit::Micros,
//! };
//!
//! /// Fires at a frame where light is more than 20 away from where it last fired.
//! struct Own {
//!     memory: Option<Plane<f64>>,
//!     size: Size,
//! }
//!
//! impl Sensor for Own {
//!     fn name(&self) -> &str {
//!         "own"
//!     }
//!     fn size(&self) -> Size {
//!         self.size
//!     }
//!     fn channels(&self) -> u8 {
//!         1
//!     }
//!     fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
//!         let memory = self.memory.get_or_insert_with(|| (*frame.light).clone());
//!         for ((y, x), light) in frame.light.indexed_iter() {
//!             let moved = light - memory[(y, x)];
//!             if moved.abs() > 20.0 {
//!                 memory[(y, x)] = *light;
//!                 let polarity = if moved > 0.0 { Polarity::On } else { Polarity::Off };
//!                 let t = Micros::from_seconds(frame.seconds);
//!                 packet.events.push(Event { t, x: x as u16, y: y as u16, polarity, channel: 0 });
//!             }
//!         }
//!         Ok(())
//!     }
//! }
//!
//! let float = "memory = \"filtered-snap\"\nresponse = \"identity\"\n[[channel]]\nkernel = [[1]]\nthreshold = { on = 20, off = 20 }\n";
//! let float = Description::parse("float", float, &|name| Err(std::io::Error::other(name.to_owned())))?;
//! assert_sensors_agree(
//!     |size| Reference::new(float.clone(), size, 0),
//!     |size| Ok(Own { memory: None, size }),
//!     &Tolerance::default(),
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod agreement;
mod sensor;
mod strategy;

pub use agreement::{
    Disagreement, Tolerance, agree, agree_sensors, assert_agrees, assert_sensors_agree,
};
pub use sensor::sensors;
pub use strategy::{Clip, clips, devices, formats, kernels, programs};
