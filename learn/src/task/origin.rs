//! Where a task comes from: what errors name.

/// The file of a task, and the lines of some of its keys.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    pub(super) file: String,
    pub(super) lines: Vec<(&'static str, u32)>,
}

impl Origin {
    /// File, line and key of the first of these keys that the file has; the file alone where it has
    /// none of them. `None` where an error is not about a task's keys.
    #[must_use]
    pub fn told(&self, keys: &[&str]) -> Option<String> {
        let line = |key: &&str| self.lines.iter().find(|(own, _)| own == key);
        if let Some((key, line)) = keys.iter().find_map(line) {
            return Some(format!("{}:{line}: `{key}`", self.file));
        }
        (!keys.is_empty()).then(|| self.file.clone())
    }
}
