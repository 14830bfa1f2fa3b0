//! Checkpoints: all that a run needs to go on as if it had not been stopped.
//!
//! ```text
//! amacrine-learn checkpoint 2     the version
//! {"identity": …, "step": …, …}   what it is of, and the small numbers
//! …                               weights and moments, little-endian, f32 and then f64
//! …                               SHA-256 of all before it
//! ```

use std::{io, path::Path};

use amacrine::save;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::{network::Adam, record::KernelAt};

use super::{error::TrainError, trainee::State};

const FIRST_LINE: &str = "amacrine-learn checkpoint 2\n";

#[derive(Serialize, Deserialize)]
struct Header {
    /// The task, the photographs, the arm, the target, the seed.
    identity: String,
    step: u64,
    adam_steps: [u64; 2],
    counts: [usize; 2],
    threshold: f64,
    means: [f64; 2],
    pinned: u64,
    chip: [f64; 2],
    words: Option<u64>,
    history: Vec<KernelAt>,
}

impl State {
    /// Writes a checkpoint, whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save(&self, path: &Path, identity: &str) -> Result<(), TrainError> {
        let bytes = self.to_bytes(identity);
        save::save_durably(path, |out| out.write_all(&bytes))?;
        Ok(())
    }

    fn to_bytes(&self, identity: &str) -> Vec<u8> {
        let header = Header {
            identity: identity.to_owned(),
            step: self.step,
            adam_steps: [self.network.1.steps, self.kernel.1.steps],
            counts: [self.network.0.len(), self.kernel.0.len()],
            threshold: self.threshold,
            means: self.means,
            pinned: self.pinned,
            chip: self.chip,
            words: self.words,
            history: self.history.clone(),
        };
        let mut bytes = FIRST_LINE.as_bytes().to_vec();
        // Numbers and texts: they can be written as JSON.
        bytes.extend(serde_json::to_vec(&header).unwrap_or_default());
        bytes.push(b'\n');
        let (weights, adam) = &self.network;
        for values in [weights, &adam.first, &adam.second] {
            bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        }
        let (parameters, adam) = &self.kernel;
        for values in [parameters, &adam.first, &adam.second] {
            bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        }
        let sum = Sha256::digest(&bytes);
        bytes.extend(sum);
        bytes
    }

    /// Reads a checkpoint of the same identity and sizes; what is said of another identity is given with
    /// it.
    ///
    /// # Errors
    /// When it cannot be read, is damaged, or is one of something else.
    pub fn open(
        path: &Path,
        identity: (&str, &dyn Fn(&str) -> String),
        counts: [usize; 2],
    ) -> Result<Self, TrainError> {
        let bytes = std::fs::read(path).map_err(|cause| TrainError::Unreadable {
            path: path.to_owned(),
            cause,
        })?;
        Self::from_bytes(&bytes, identity, counts).map_err(|what| TrainError::Checkpoint {
            path: path.to_owned(),
            what,
        })
    }

    fn from_bytes(
        bytes: &[u8],
        (identity, other): (&str, &dyn Fn(&str) -> String),
        counts: [usize; 2],
    ) -> Result<Self, String> {
        let damaged = || "a damaged checkpoint; without it this arm begins anew".to_owned();
        let rest = bytes.strip_prefix(FIRST_LINE.as_bytes()).ok_or_else(|| {
            let line = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
            let line = String::from_utf8_lossy(&line[..line.len().min(60)]);
            if line.starts_with("amacrine-learn checkpoint") {
                format!("a checkpoint of another version: `{line}`")
            } else {
                "no checkpoint of amacrine-learn".to_owned()
            }
        })?;
        let (all, sum) = bytes
            .split_at_checked(bytes.len().saturating_sub(32))
            .ok_or_else(damaged)?;
        if sum != Sha256::digest(all).as_slice() {
            return Err(damaged());
        }
        let end = rest.iter().position(|b| *b == b'\n').ok_or_else(damaged)?;
        let header: Header = serde_json::from_slice(&rest[..end]).map_err(|_| damaged())?;
        if header.identity != identity {
            return Err(other(&header.identity));
        }
        if header.counts != counts {
            return Err(damaged());
        }
        let mut values = &rest[end + 1..rest.len() - 32];
        let mut single = || floats(&mut values, counts[0], f32::from_le_bytes);
        let network = [single(), single(), single()];
        let mut double = || floats(&mut values, counts[1], f64::from_le_bytes);
        let kernel = [double(), double(), double()];
        let [Some(weights), Some(first), Some(second)] = network else {
            return Err(damaged());
        };
        let steps = header.adam_steps[0];
        let network = (
            weights,
            Adam {
                first,
                second,
                steps,
            },
        );
        let [Some(parameters), Some(first), Some(second)] = kernel else {
            return Err(damaged());
        };
        let steps = header.adam_steps[1];
        Ok(Self {
            step: header.step,
            network,
            kernel: (
                parameters,
                Adam {
                    first,
                    second,
                    steps,
                },
            ),
            threshold: header.threshold,
            means: header.means,
            pinned: header.pinned,
            chip: header.chip,
            words: header.words,
            history: header.history,
        })
    }
}

/// What tells a checkpoint from what it is to be: both are `task digest, arm-target-seed`; `changed` is
/// the first key of the task that is another, where it is known.
pub(super) fn other(theirs: &str, own: &str, changed: Option<&str>) -> String {
    let [(their_task, their_arm), (task, arm)] =
        [theirs, own].map(|identity| identity.split_once(", ").unwrap_or((identity, "")));
    if their_task == task {
        return format!("made for {their_arm} (arm, target, seed), and this is {arm}");
    }
    match changed {
        Some(changed) => another_task(changed),
        None => format!(
            "made with another task file, other photographs, another video or another version: its digest is {their_task}, and that of this run {task}"
        ),
    }
}

/// What is said of a task that has changed.
pub(super) fn another_task(changed: &str) -> String {
    format!("made with another task file: {changed}")
}

/// The next so many numbers of so many bytes each.
fn floats<T, const N: usize>(
    bytes: &mut &[u8],
    count: usize,
    from: fn([u8; N]) -> T,
) -> Option<Vec<T>> {
    let (own, rest) = bytes.split_at_checked(count.checked_mul(N)?)?;
    *bytes = rest;
    Some(
        own.as_chunks::<N>()
            .0
            .iter()
            .map(|chunk| from(*chunk))
            .collect(),
    )
}

/// Whether there is something at a path.
pub(super) fn exists(path: &Path) -> io::Result<bool> {
    path.try_exists()
}
