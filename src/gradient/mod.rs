//! The float model's gradient: from what a loss asks of voxels and counts back to kernels,
//! thresholds and light.
//!
//! ```text
//! light ─ response ─ u ─ kernel W ─ drive S ─ distance d ─ events N ─┬─ voxels
//!   ↑                      ↑            ↑      ↑ memory, thresholds  └─ counts
//!   └──────────────────────┴── backward ┴──────┘        (by hand, no framework)
//! ```
//!
//! [`Model::forward`] makes the events of a batch of clips, to the bit those of
//! [`Reference`](crate::reference::Reference), and keeps what the way back needs; [`Model::backward`]
//! takes the loss's gradients of voxels and counts and gives those of kernels, thresholds and, where
//! asked, of the light. What counts whole events has no derivative; the [`Rule`]s differ in what
//! takes its place in the memory. `docs/learning.md` derives each of them.
//!
//! Sums are taken in fixed pieces and in a fixed order, so gradients have the same bits on any number
//! of threads.
//!
//! ```
//! use amacrine::{gradient::{Ask, Clips, Model}, plane::Size, reference::Description};
//!
//! let text = "response = { linear = 255 }\nmemory = \"filtered-step\"\n[[channel]]\n\
//!             kernel = [[0, -0.25, 0], [-0.25, 1, -0.25], [0, -0.25, 0]]\n\
//!             threshold = { on = 0.1, off = 0.1 }";
//! let description = Description::parse("cell.toml", text, &|_| Err(std::io::ErrorKind::NotFound.into())).unwrap();
//! let model = Model::<f32>::new(description, Size::new(2, 2), 0).unwrap();
//! // Two frames of four pixels: one pixel grows brighter.
//! let light = [50.0, 50.0, 50.0, 50.0, 150.0, 50.0, 50.0, 50.0];
//! let seen = model.forward(Clips::new(&light, &[0.0, 0.01], Size::new(2, 2)).unwrap()).unwrap();
//! assert_eq!(seen.counts(), [1, 0, 0, 0]);
//! // The loss: the number of events.
//! let ask = Ask { events: 1.0, ..Ask::default() };
//! let gradient = model.backward(&seen, &ask, model.rule()).unwrap();
//! assert!(gradient.channels[0].on[0] < 0.0); // a higher threshold makes fewer events
//! ```

mod back_pass;
mod backward;
mod clips;
mod error;
mod float;
mod forward;
mod forward_pass;
mod gaussians;
mod kernel_sum;
mod light;
mod mean;
mod model;
mod pair;
mod piece;
mod rate;
mod rule;
mod signal;
mod sums;

pub use backward::{Ask, ChannelGradient, Gradient};
pub use clips::Clips;
pub use error::{GradientError, Tensor};
pub use float::Float;
pub use forward::Forward;
pub use gaussians::{GaussianGradient, gaussian_gradients};
pub use model::Model;
pub use rate::{ConstantRate, Rated, rate_threshold};
pub use rule::{Rule, Slope};
