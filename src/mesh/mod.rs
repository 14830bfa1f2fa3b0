//! The resistive grid, a centre-surround filter made by the silicon itself. It is called a *sheet*
//! here when its parts are equal, a *network* when they differ.
//!
//! Every pixel has a node. A transverse conductance `g` ties it to the pixel's own signal,
//! four lateral resistors `R` tie it to its neighbours, a capacitor `C` to ground:
//!
//! ```text
//!            P (the photoreceptor's signal)
//!            │
//!            ┴ g
//!       R    │    R
//!  … ─/\/\/─ H ─/\/\/─ …      and the same to the rows above and below
//!            │
//!            ┴ C
//! ```
//!
//! | equation | |
//! |---|---|
//! | `C dH/dt = g (P - H) + (1/R) Lap H` | Kirchhoff's current law at a node |
//! | `τ dH/dt = P - H + λ² Lap H` | the same, over `g` |
//! | `λ = 1 / sqrt(R g)`, in pixels; `τ = C / g`, in seconds | space and time constant |
//! | `(1 - λ² Lap) H = P` | settled |
//! | `P - H` | what the Center Surround DVS is driven by |
//!
//! `Lap H` is the sum of the neighbours' `H` less as many times the node's own. There is nothing
//! beyond the edge (open ends), which is the same as a replicated border. So the cosines of the
//! DCT-II are the modes of the sheet; the one of `k` half waves across `N` pixels has
//!
//! ```text
//! μ = 4 sin²(π k / 2N)      gain 1 / (1 + λy² μy + λx² μx)      time constant τ times the gain
//! ```
//!
//! Everything about a sheet of equal parts is therefore known in closed form: [`Steady`] is its
//! settled state, [`Flow`] how it moves. [`Network`] is a sheet whose parts all differ, and
//! whose laterals may be transistors; [`fit()`] says which receptive fields a sheet can carry.
//!
//! Sources: T. Delbruck, C. Li, R. Graca, B. `McReynolds`, *Utility and feasibility of a center
//! surround event camera*, ICIP 2022, arXiv 2202.13076; Mead, *Analog VLSI and Neural Systems*,
//! 1989, appendix C. `docs/mesh.md` has all of it with pictures.

mod cosine;
mod error;
mod euler;
mod fit;
mod float;
mod flow;
mod krylov;
mod network;
mod reason;
mod sheet;
mod signal;
mod steady;

pub use error::MeshError;
pub use euler::Euler;
pub use fit::{Fit, FittedSheet, Fitting, fit};
pub use float::Float;
pub use flow::{Between, Flow};
pub use network::{Laterals, Mismatch, Network, Settled};
pub use sheet::{MOST_LAMBDA, MOST_SIGNAL, Sheet};
pub use steady::Steady;
