//! Options that several verbs share, as `clap` reads them.
//!
//! - [`heading`]: the headings under which a help lists them.
//! - [`clip`], [`light`], [`flip`]: the scene, and what its samples mean.
//! - [`kernel_names`], [`quantiser`], [`effort`]: kernels, in which few values, how long to search.
//! - [`sensor_changes`], [`event_rate`], [`without`], [`chip_figure`]: what is changed of a sensor, a
//!   model or a chip.
//! - [`readout`], [`recording`]: how events are read out, and what an event file does not say itself.
//! - [`fidelity`]: plans of what a model leaves out.
//! - [`window`]: the window of matches.
//! - [`threads`], [`budget`]: what a verb may take of the machine.

pub(super) mod budget;
pub(super) mod chip_figure;
pub(super) mod clip;
pub(super) mod effort;
pub(super) mod event_rate;
pub(super) mod fidelity;
pub(super) mod flip;
pub(super) mod heading;
pub(super) mod kernel_names;
pub(super) mod light;
pub(super) mod quantiser;
pub(super) mod readout;
pub(super) mod recording;
pub(super) mod sensor_changes;
pub(super) mod threads;
pub(super) mod window;
pub(super) mod without;
