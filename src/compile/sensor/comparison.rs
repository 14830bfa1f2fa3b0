//! The comparison of a drive with both thresholds of its kind.

use std::fmt::Write as _;

/// What is compared, and the registers for it.
pub(super) struct Comparison<'a> {
    pub(super) news: &'a str,
    pub(super) scratch: &'a str,
    pub(super) drive: &'a str,
    pub(super) threshold: &'a str,
    /// The register of minus the memory, where the drive is compared with one.
    pub(super) memory: Option<&'a str>,
    /// Where ON goes, and OFF.
    pub(super) bits: [&'a str; 2],
}

impl Comparison<'_> {
    /// Writes its statements, with the constants of both thresholds; FLAG is left where ON is.
    pub(super) fn write(&self, text: &mut String, [on, off]: [&str; 2]) {
        let Self {
            news,
            scratch,
            drive,
            threshold,
            memory,
            bits: [on_bit, off_bit],
        } = self;
        let (memory, above, below) = match memory {
            Some(memory) => (format!(", {memory}"), "drive - memory", "memory - drive"),
            None => (String::new(), "drive", "-drive"),
        };
        let mut line = |what: &str| {
            let _ = writeln!(text, "    {what}");
        };
        line(&format!("scamp5_in({threshold}, -{off});"));
        line(&format!("bus({news});"));
        line(&format!("bus({scratch}, {news}, {drive}{memory});"));
        line(&format!(
            "where({scratch}, {threshold}); // {below} > threshold"
        ));
        line(&format!("MOV({off_bit}, FLAG);"));
        if on != off {
            line("all();");
            line(&format!("scamp5_in({threshold}, -{on});"));
        }
        line(&format!(
            "where({drive}{memory}, {threshold}); // {above} > threshold"
        ));
        line(&format!("MOV({on_bit}, FLAG);"));
    }
}
