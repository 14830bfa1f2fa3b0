//! `amacrine merge`: the folders of a sweep's shards into one.

use std::{fmt::Write as _, path::PathBuf};

use serde_json::json;

use super::output::{
    command_line::quoted,
    content::Content,
    files::{Input, Output},
};
use crate::{study::sweep::merge, unit::counted};

/// What `merge` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine merge out/shard-0 out/shard-1 out/shard-2 out/shard-3 --output out/all"
)]
pub struct Arguments {
    /// Folders of the shards of one study
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<Input>,
    /// Folder of all results
    #[arg(short, long, value_name = "DIR", value_parser = Content::Folder)]
    output: Output,
    /// Write results.parquet, too
    #[arg(long)]
    parquet: bool,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// The most identities of missing points that are shown.
const SHOWN: usize = 5;

/// Runs the verb.
///
/// # Errors
/// When the folders are not of one study, are damaged, disagree on a point, or cannot be read or
/// written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    super::sweep::check_parquet(arguments.parquet)?;
    let folders: Vec<PathBuf> = arguments.folders.iter().map(|f| f.to_path_buf()).collect();
    let (manifest, tables) = merge(&folders, &arguments.output, arguments.parquet)?;
    let missing = &tables.missing;
    if arguments.json {
        let said = json!({
            "study": manifest.title,
            "output": arguments.output,
            "points": manifest.points.len(),
            "finished": tables.finished,
            "failed": tables.failed,
            "missing": missing,
            "computed_by": tables.computed_by,
        });
        super::say(&format!("{said}\n"));
        return Ok(());
    }
    let mut text = format!(
        "study    {}\npoints   {} of {}\n",
        manifest.title,
        tables.finished,
        manifest.points.len()
    );
    let output = arguments.output.display();
    let sweep = format!(
        "`amacrine sweep STUDY --output {}`",
        quoted(&output.to_string())
    );
    if tables.failed > 0 {
        let _ = writeln!(
            text,
            "failed   {}: compute again with {sweep}",
            counted(tables.failed, "point")
        );
    }
    if !missing.is_empty() {
        let first: Vec<String> = missing.iter().take(SHOWN).map(usize::to_string).collect();
        let more = if missing.len() > SHOWN { ", …" } else { "" };
        let what = if manifest.is_search() {
            // Those that it leaves out are never computed.
            "left out by the search, or not computed yet".to_owned()
        } else {
            format!("numbered {}{more}; compute with {sweep}", first.join(", "))
        };
        let _ = writeln!(text, "missing  {}: {what}", counted(missing.len(), "point"));
    }
    let _ = writeln!(text, "wrote    {output}/results.csv and results.jsonl");
    super::say(&text);
    Ok(())
}
