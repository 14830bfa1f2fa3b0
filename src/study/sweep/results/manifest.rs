//! What a folder of results says about itself: `sweep.json`.

use std::{
    collections::{BTreeMap, HashSet},
    io,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;
use sha2::{Digest, Sha256};

use super::{
    error::{Kept, StoreError},
    provenance::{NUMERICS, SCHEMA},
    regular_file::{self, Unusable},
    seal::{self, Fields},
};
use crate::{
    save::save_durably,
    study::sweep::{
        points::grid::MOST_POINTS,
        scene::cached_scene::hex,
        study_file::{
            stated::{Stated, changes, is_search, stated},
            study::Study,
        },
        tables::table,
    },
};

/// What a folder of results says about itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The version that made it.
    pub amacrine: String,
    /// The version of its results.
    pub schema: u32,
    /// The version of its numerics.
    pub numerics: u32,
    /// Identity of the study: a hash of its points.
    pub study: String,
    /// What the study is called.
    pub title: String,
    /// The columns of the tables.
    pub columns: Vec<String>,
    /// Identities of all points, in their fixed order.
    pub points: Vec<String>,
    /// The keys of the study, for people: what two studies differ in.
    pub stated: Stated,
}

/// The longest `sweep.json`, in bytes: one of the largest study takes four millions.
pub const LONGEST: u64 = crate::limit::MANIFEST_BYTES;

/// The most columns.
const MOST_COLUMNS: usize = 10_000;

impl Manifest {
    /// Of these points, made by this build.
    #[must_use]
    pub(in crate::study::sweep) fn new(of: &Study, points: Vec<String>) -> Self {
        Self {
            amacrine: env!("CARGO_PKG_VERSION").to_owned(),
            schema: SCHEMA,
            numerics: NUMERICS,
            study: study(&points),
            title: of.title.clone(),
            columns: table::names(&of.settings),
            points,
            stated: stated(of),
        }
    }

    /// The number of a point, by its identity.
    pub(super) fn indices(&self) -> BTreeMap<&str, usize> {
        let points = self.points.iter().enumerate();
        points.map(|(index, id)| (id.as_str(), index)).collect()
    }

    /// Whether a search chose which of its points are computed.
    #[must_use]
    pub fn is_search(&self) -> bool {
        is_search(&self.stated)
    }

    pub(super) fn write(&self, folder: &Path) -> Kept<()> {
        let fields: Fields = match serde_json::to_value(self) {
            Ok(Json::Object(fields)) => fields.into_iter().collect(),
            _ => Fields::new(),
        };
        let path = file(folder);
        let text = serde_json::to_string_pretty(&seal::sealed(fields)).unwrap_or_default() + "\n";
        if text.len() as u64 > LONGEST {
            let cause = io::Error::other(format!(
                "the study takes {} bytes there, the most are {LONGEST}",
                text.len()
            ));
            return Err(StoreError::Save { path, cause });
        }
        Ok(save_durably(&path, |out| out.write_all(text.as_bytes()))?)
    }

    /// Reads and checks that of a folder.
    pub(super) fn read(folder: &Path) -> Kept<Self> {
        let path = file(folder);
        let bytes = match regular_file::read(&path, LONGEST) {
            Ok(bytes) => bytes,
            Err(Unusable::Absent) if folder.exists() => {
                return Err(StoreError::Foreign {
                    folder: folder.to_owned(),
                    found: None,
                });
            }
            Err(Unusable::Absent) => {
                return Err(StoreError::Missing {
                    folder: folder.to_owned(),
                });
            }
            Err(Unusable::System(cause)) => return Err(StoreError::Unreadable { path, cause }),
            Err(Unusable::Kind(found)) => return Err(StoreError::Kind { path, found }),
            Err(Unusable::Long(bytes)) => {
                let why = format!("it has {bytes} bytes, the most are {LONGEST}");
                return Err(StoreError::Damaged { path, why });
            }
        };
        let damaged = |why: String| StoreError::Damaged {
            path: path.clone(),
            why,
        };
        let fields = seal::parse(&bytes).map_err(damaged)?;
        check_version(folder, &fields).map_err(|e| {
            e.unwrap_or_else(|| damaged("it does not say which version made it".to_owned()))
        })?;
        check_points(&fields).map_err(damaged)?;
        let fields = seal::unsealed(fields).map_err(damaged)?;
        let whole = serde_json::from_value(fields.into_iter().collect());
        let whole: Self = whole.map_err(|e| damaged(e.to_string()))?;
        if whole.study != study(&whole.points) {
            return Err(damaged("its identity is not that of its points".to_owned()));
        }
        Ok(whole)
    }

    /// Refuses results of another study.
    pub(super) fn check_same(&self, folder: &Path, asked: &Self) -> Kept<()> {
        if self.study == asked.study && self.columns == asked.columns {
            return Ok(());
        }
        Err(StoreError::Study {
            folder: folder.to_owned(),
            held: self.title.clone(),
            held_points: self.points.len(),
            asked: asked.title.clone(),
            asked_points: asked.points.len(),
            changes: changes(&self.stated, &asked.stated),
        })
    }
}

/// Where it stands.
pub(super) fn file(folder: &Path) -> PathBuf {
    folder.join("sweep.json")
}

/// Identity of a study.
fn study(points: &[String]) -> String {
    let mut digest = Sha256::new();
    for id in points {
        digest.update(id.as_bytes());
    }
    hex(&digest.finalize()[..16])
}

/// Refuses a folder of a build whose numbers may differ. Before the checksum: another version
/// may have written another kind of file.
fn check_version(folder: &Path, fields: &Fields) -> Result<(), Option<StoreError>> {
    let made = fields.get("amacrine").and_then(Json::as_str).ok_or(None)?;
    let schema = fields.get("schema").and_then(Json::as_u64).ok_or(None)?;
    // The first results did not say.
    let numerics = fields.get("numerics").map_or(Some(0), Json::as_u64);
    let numerics = numerics.ok_or(None)?;
    if made == env!("CARGO_PKG_VERSION")
        && schema == u64::from(SCHEMA)
        && numerics == u64::from(NUMERICS)
    {
        return Ok(());
    }
    Err(Some(StoreError::Version {
        folder: folder.to_owned(),
        made: made.chars().take(64).collect(),
        schema,
        numerics,
    }))
}

/// Identities become paths: nothing else may stand there.
fn check_points(fields: &Fields) -> Result<(), String> {
    let list = |name: &str| {
        let list = fields.get(name).and_then(Json::as_array);
        list.ok_or_else(|| format!("it has no list `{name}`"))
    };
    let (points, columns) = (list("points")?, list("columns")?);
    if points.len() as u64 > MOST_POINTS {
        return Err(format!(
            "it has {} points, the most are {MOST_POINTS}",
            points.len()
        ));
    }
    if columns.len() > MOST_COLUMNS {
        return Err(format!(
            "it has {} columns, the most are {MOST_COLUMNS}",
            columns.len()
        ));
    }
    let mut seen = HashSet::new();
    for (index, id) in points.iter().enumerate() {
        let Some(id) = id.as_str().filter(|id| is_identity(id)) else {
            let shown: String = id.to_string().chars().take(64).collect();
            return Err(format!(
                "the identity of point {index} is {shown}, not 32 digits of lower-case hexadecimal"
            ));
        };
        if !seen.insert(id) {
            return Err(format!(
                "the identity of point {index}, {id}, stands there twice"
            ));
        }
    }
    let mut seen = HashSet::new();
    for name in columns {
        if !name.as_str().is_some_and(|name| seen.insert(name)) {
            return Err(format!(
                "its column {name} is no name, or stands there twice"
            ));
        }
    }
    for name in ["index", "id", "outcome"] {
        if !seen.contains(name) {
            return Err(format!("it has no column `{name}`"));
        }
    }
    Ok(())
}

/// Whether a text can be the identity of a point.
pub(super) fn is_identity(text: &str) -> bool {
    text.len() == 32
        && text
            .bytes()
            .all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}
