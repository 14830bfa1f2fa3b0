//! A file of `pilots/`: what a pilot or a rung of a search has measured, under a checksum as a
//! point's file is.

use std::{collections::BTreeMap, fs, path::Path};

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{
    damage::Damage,
    error::{Kept, StoreError},
    manifest::is_identity,
    regular_file::{self, Unusable},
    seal,
};
use crate::{limit::MANIFEST_BYTES, save::save_durably};

/// Figures by name: the limit of each plainer model, or columns of a row.
pub(in crate::study::sweep) type Found = BTreeMap<String, f64>;

/// What was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::study::sweep) struct PilotFile {
    /// By content: its file's name.
    pub id: String,
    /// What came of it.
    pub figures: Found,
    /// Why a search has no use for it; none: it has.
    pub reason: Option<String>,
}

/// Why there is nothing to go by.
enum Unread {
    Absent,
    Damaged(String),
    System(std::io::Error),
}

impl PilotFile {
    /// What is kept under an identity; none where nothing is, or it cannot be believed.
    pub fn read(folder: &Path, id: &str) -> Option<Self> {
        Self::checked(&path(folder, id), id).ok()
    }

    fn checked(path: &Path, id: &str) -> Result<Self, Unread> {
        let bytes =
            regular_file::read(path, MANIFEST_BYTES).map_err(|unusable| match unusable {
                Unusable::Absent => Unread::Absent,
                Unusable::Kind(found) => Unread::Damaged(format!("{found} stands there")),
                Unusable::Long(bytes) => Unread::Damaged(format!(
                    "it has {bytes} bytes, the most are {MANIFEST_BYTES}"
                )),
                Unusable::System(cause) => Unread::System(cause),
            })?;
        let fields = seal::parse(&bytes).and_then(seal::unsealed);
        let fields = fields.map_err(Unread::Damaged)?;
        let file: Self = serde_json::from_value(json!(fields))
            .map_err(|error| Unread::Damaged(format!("it is no pilot: {error}")))?;
        if file.id == id {
            Ok(file)
        } else {
            Err(Unread::Damaged("it is of another pilot".to_owned()))
        }
    }

    /// Keeps it.
    ///
    /// # Errors
    /// When the disk does not take it; then there is nothing of it.
    pub fn write(&self, folder: &Path) -> Kept<()> {
        let fields = json!(self).as_object().cloned().unwrap_or_default();
        let text = json!(seal::sealed(fields.into_iter().collect())).to_string() + "\n";
        let path = path(folder, &self.id);
        Ok(save_durably(&path, |out| out.write_all(text.as_bytes()))?)
    }
}

pub(super) fn path(folder: &Path, id: &str) -> std::path::PathBuf {
    folder.join(format!("{id}.json"))
}

/// The files of a folder of pilots that cannot be believed, in the order of their names.
///
/// # Errors
/// When the folder or a file cannot be read.
pub(in crate::study::sweep) fn damaged(folder: &Path) -> Kept<Vec<Damage>> {
    let cannot = |path: &Path| {
        let path = path.to_owned();
        |cause| StoreError::Unreadable { path, cause }
    };
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(cannot(folder))? {
        let name = entry.map_err(cannot(folder))?.file_name();
        let id = name.to_str().and_then(|name| name.strip_suffix(".json"));
        let Some(id) = id.filter(|id| is_identity(id)) else {
            continue;
        };
        let path = path(folder, id);
        match PilotFile::checked(&path, id) {
            Ok(_) | Err(Unread::Absent) => {}
            Err(Unread::Damaged(why)) => found.push(Damage {
                point: None,
                path,
                why,
            }),
            Err(Unread::System(cause)) => return Err(cannot(&path)(cause)),
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}
