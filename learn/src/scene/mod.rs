//! Scenes: photographs moved along exact flow.
