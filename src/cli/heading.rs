//! Headings of the options in a help; options without one stand first, under "Options".

pub(super) const CHIP: &str = "Chip";
pub(super) const COMPARISON: &str = "Comparison";
pub(super) const FILTER: &str = "Filter alone";
pub(super) const INPUT: &str = "Input";
pub(super) const MODELS: &str = "Plainer models";
pub(super) const OUTPUT: &str = "Output";
pub(super) const PARTS: &str = "Parts";
pub(super) const POINTS: &str = "Single points";
pub(super) const PROGRAM: &str = "Program";
pub(super) const READOUT: &str = "Readout";
pub(super) const RESOURCES: &str = "Resources";
pub(super) const SCENE: &str = "Scene";
pub(super) const SEARCH: &str = "Search";
pub(super) const SENSOR: &str = "Sensor";
