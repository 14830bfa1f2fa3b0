//! A task to start from, and the keys of tasks as JSON Schema.

use std::path::{Path, PathBuf};

use amacrine::{
    config::{self, schema},
    save::save,
};
use miette::{Result, miette};

use super::print::say;
use crate::task;

/// What a task begins with.
const TASK: &str = r#"# Keys behind a # hold where nothing else is said. What comes out: docs/guides/learn-a-kernel.md.
goal = "interpolation"           # or "flow", from events alone
steps = 2000
crop = 24                        # px
targets = [0.01, 0.02, 0.05]     # events a pixel and pair of frames
seeds = [1, 2, 3]
arms = ["none", "dvs", "rgc", "ternary", "int-5"]
"#;

/// The schema's file, beside the tasks that it is for.
const BESIDE: &str = "task.schema.json";

/// The keys of a task file.
fn keys() -> String {
    format!("{:#}\n", schema::file(&task::FILE))
}

/// Prints the schema, or writes it.
pub(super) fn schema(output: Option<&Path>) -> Result<()> {
    match output {
        None => say(&keys()),
        Some(path) => write(&[(path.to_owned(), keys())]),
    }
}

/// Writes a task file of this name, with its schema beside it where there is none.
///
/// # Errors
/// When it is there already, or cannot be written.
pub(super) fn task(name: &Path) -> Result<()> {
    if name.file_name().is_none() || name.as_os_str().as_encoded_bytes().ends_with(b"/") {
        return Err(miette!(
            help = "give the path of the task, without the ending, such as `mine`",
            "`{}` is no name of a file",
            name.display()
        ));
    }
    let mut path = PathBuf::from(name);
    if path.extension().is_none_or(|ending| ending != "toml") {
        path.as_mut_os_string().push(".toml");
    }
    if path.exists() {
        return Err(miette!(
            help = "give another name; nothing was written",
            "{} is there already",
            path.display()
        ));
    }
    let text = config::with_keys(TASK, &schema::file(&task::FILE));
    let beside = path.with_file_name(BESIDE);
    let mut files = vec![(path, format!("#:schema ./{BESIDE}\n{text}"))];
    if !beside.exists() {
        files.push((beside, keys()));
    }
    write(&files)
}

/// Writes all of them first: who reads the lines may have gone.
fn write(files: &[(PathBuf, String)]) -> Result<()> {
    for (path, text) in files {
        save(path, |file| file.write_all(text.as_bytes()))?;
    }
    let mut written = files.iter();
    written.try_for_each(|(path, _)| say(&format!("wrote    {}\n", path.display())))
}
