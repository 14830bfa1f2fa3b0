//! A share of the points, computed again: are they what the folder says, to the bit?

use std::{
    path::{Path, PathBuf},
    str::FromStr,
    sync::{Mutex, PoisonError},
};

use serde::Serialize;
use serde_json::Value as Json;
use sha2::{Digest, Sha256};

use super::{
    difference::differences,
    error::{Kept, StoreError},
    manifest::Manifest,
    pilot_file::{self, PilotFile},
    record::Record,
    store::held,
};
use crate::{
    order::Order,
    study::sweep::{
        measurement::{measure::measure, memo::Shared, run::Run},
        points::plan::Entry,
    },
};

/// A share of the points, in percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share(f64);

/// No share.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` is no share")]
#[diagnostic(help("give percent, above 0 and up to 100, such as 5%"))]
pub struct ShareError {
    /// What was given.
    pub text: String,
}

impl FromStr for Share {
    type Err = ShareError;

    fn from_str(text: &str) -> Result<Self, ShareError> {
        let percent = text.strip_suffix('%').and_then(|text| text.parse().ok());
        match percent {
            Some(percent) if percent > 0.0 && percent <= 100.0 => Ok(Self(percent)),
            _ => Err(ShareError { text: text.into() }),
        }
    }
}

impl Share {
    /// So many of all, at least one; none of none.
    #[must_use]
    pub fn of(self, all: usize) -> usize {
        ((self.0 / 100.0 * all as f64).ceil() as usize)
            .clamp(1, all.max(1))
            .min(all)
    }
}

/// What was compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verified {
    /// Points that were computed again.
    pub compared: usize,
    /// Finished points that they were chosen from.
    pub finished: usize,
    /// What is not the same, in the order of points.
    pub differences: Vec<Difference>,
    /// Files of pilots that say something else than what was measured now.
    pub pilots: Vec<PathBuf>,
}

/// A column of a point that was computed again and is not the same.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The point's number.
    pub point: usize,
    /// Its identity.
    pub id: String,
    /// Which column.
    pub column: String,
    /// What the folder says.
    pub held: Json,
    /// What was computed now.
    pub computed: Json,
    /// Why nothing was computed, where that is so.
    pub reason: Option<String>,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            point,
            id,
            column,
            held,
            computed,
            reason,
        } = self;
        write!(
            f,
            "point {point} ({id}), {column}: {held} in the folder, {computed} now"
        )?;
        match reason {
            Some(reason) => write!(f, " ({reason})"),
            None => Ok(()),
        }
    }
}

impl Run<'_> {
    /// Computes a share of the finished points again, chosen by a hash of their identities and
    /// a seed, and compares every column that is no time. Nothing is written.
    ///
    /// # Errors
    /// When the folder cannot be read, is damaged or of another study, or has nothing finished.
    pub fn verify(
        &self,
        folder: &Path,
        share: Share,
        seed: u64,
        begin: impl FnOnce(u64),
        done: impl Fn() + Sync,
    ) -> Kept<Verified> {
        let asked = self.plan.manifest();
        let manifest = Manifest::read(folder)?;
        manifest.check_same(folder, &asked)?;
        let held = held(folder, &manifest)?;
        if !held.damaged.is_empty() {
            return Err(StoreError::Points {
                damaged: held.damaged,
            });
        }
        let is_final = |entry: &Entry| held.records.get(&entry.id).is_some_and(Record::is_final);
        let mut chosen = self.mine();
        chosen.retain(|(_, entry)| is_final(entry));
        let finished = chosen.len();
        if finished == 0 {
            return Err(StoreError::Unfinished {
                folder: folder.to_owned(),
            });
        }
        chosen.sort_by_cached_key(|(_, entry)| {
            let hash = Sha256::new().chain_update(seed.to_le_bytes());
            <[u8; 32]>::from(hash.chain_update(entry.id.as_bytes()).finalize())
        });
        chosen.truncate(share.of(finished));
        let compared = chosen.len();
        begin(compared as u64);
        let found = Mutex::new(Vec::new());
        let (plan, limits) = (self.plan, self.limits);
        let shared = Shared::new(None);
        self.on_threads(chosen, &shared, |point, entry, shared| {
            let row = self.computed(entry, || measure(plan, entry, shared, limits));
            if let Some(Record { row: kept, .. }) = held.records.get(&entry.id) {
                let own = differences(&asked.columns, kept, &row);
                let own = own.map(|(column, held, computed)| Difference {
                    point,
                    id: entry.id.clone(),
                    column: column.to_owned(),
                    held: held.clone(),
                    computed: computed.clone(),
                    reason: (column == "outcome")
                        .then(|| row.get("reason")?.as_str().map(str::to_owned))
                        .flatten(),
                });
                let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
                found.extend(own);
            }
            done();
            Ok(())
        })?;
        let mut differences = found.into_inner().unwrap_or_else(PoisonError::into_inner);
        differences.order_by_key(|difference| difference.point);
        Ok(Verified {
            compared,
            finished,
            differences,
            pilots: other_pilots(folder, &shared),
        })
    }
}

/// Files of pilots that say something else than what was measured: points would be computed from
/// them again. One that is missing or damaged is measured again.
fn other_pilots(folder: &Path, shared: &Shared) -> Vec<PathBuf> {
    let folder = folder.join("pilots");
    let measured = shared.known_pilots().into_iter();
    let other = measured.filter(|(id, found)| {
        PilotFile::read(&folder, id).is_some_and(|held| held.figures != *found)
    });
    other
        .map(|(id, _)| pilot_file::path(&folder, &id))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_at_least_one_point_and_never_more_than_all() {
        let of = |text: &str, all| text.parse::<Share>().unwrap().of(all);
        assert_eq!(of("5%", 24), 2);
        assert_eq!(of("0.001%", 24), 1);
        assert_eq!(of("100%", 24), 24);
        assert_eq!(of("50%", 1), 1);
        assert_eq!(of("50%", 0), 0);
        for wrong in ["5", "0%", "-1%", "101%", "nan%", "inf%", "%", "", "5 %"] {
            assert!(wrong.parse::<Share>().is_err(), "{wrong}");
        }
    }
}
