//! What a warning is about.

use crate::config::listed;

listed! {
/// What a warning is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum About {
    /// No event at all.
    NoEvents = "no-events",
    /// Scores of a few events.
    FewEvents = "few-events",
    /// More than half of all cells fire in one frame.
    MostCells = "most-cells",
    /// Events found no slot of the readout.
    Slots = "slots",
    /// Events found the queue of the readout full.
    Queue = "queue",
    /// Events lie in rows that the readout does not scan.
    Rows = "rows",
    /// A readout that is busy all the time.
    Late = "late",
    /// Thresholds that differ so much from cell to cell that their floor decides.
    Spread = "spread",
    /// Values at the end of the range of what holds them.
    Saturation = "saturation",
    /// Light on another scale than the sensor's.
    Scale = "scale",
    /// The clip shows another picture from one frame to the next.
    Cut = "cut",
    /// Frames of the clip are the one before once more.
    Repeats = "repeats",
    /// Numbers are missing among those of pictures.
    Gap = "gap",
    /// A pattern finer than pixels, or faster than frames.
    Alias = "alias",
    /// Frames less than a microsecond apart, which times of events do not tell apart.
    SameTime = "same-time",
    /// A clip that players show in another shape.
    Shape = "shape",
    /// A frame rate that nobody said.
    AssumedRate = "assumed-rate",
    /// A clip that ends before all frames that were asked for.
    Short = "short",
    /// Nearly everything matches by chance within the window.
    Window = "window",
    /// A still scene fires.
    Still = "still",
    /// A refractory period too short for times of events.
    Refractory = "refractory",
    /// A kernel in few values has lost its surround.
    Surround = "surround",
    /// A symmetric kernel is not symmetric in few values.
    Lopsided = "lopsided",
    /// Weights of a kernel lie beyond its levels.
    Clipped = "clipped",
    /// A kernel is another one in a number format.
    Rounded = "rounded",
    /// An array larger than the chip's.
    Larger = "larger",
    /// Kinds of cells that are compared have other names.
    Names = "names",
    /// No threshold gives the rate of events that was asked for.
    Rate = "rate",
    /// Of what was designed, little is kept on the chip.
    Kept = "kept",
}
}
