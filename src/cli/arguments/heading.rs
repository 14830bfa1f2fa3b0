//! Headings of the options in a help; options without one stand first, under "Options".

pub(in crate::cli) const CHIP: &str = "Chip";
pub(in crate::cli) const COMPARISON: &str = "Comparison";
pub(in crate::cli) const FILTER: &str = "Filter alone";
pub(in crate::cli) const FRAMES: &str = "Event frames";
pub(in crate::cli) const INPUT: &str = "Input";
pub(in crate::cli) const MODELS: &str = "Plainer models";
pub(in crate::cli) const OUTPUT: &str = "Output";
pub(in crate::cli) const PARTS: &str = "Parts";
pub(in crate::cli) const POINTS: &str = "Single points";
pub(in crate::cli) const PROGRAM: &str = "Program";
pub(in crate::cli) const READOUT: &str = "Readout";
pub(in crate::cli) const RESOURCES: &str = "Resources";
pub(in crate::cli) const SCENE: &str = "Scene";
pub(in crate::cli) const SEARCH: &str = "Search";
pub(in crate::cli) const SENSOR: &str = "Sensor";
pub(in crate::cli) const SURFACES: &str = "Time surfaces";
pub(in crate::cli) const VOXELS: &str = "Voxels";
