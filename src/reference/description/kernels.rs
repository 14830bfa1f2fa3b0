//! The kernels of a channel: rows, built-in ones, files.

use crate::{
    config::{Node, Place, Read},
    kernel::{Kernel, KernelError, KernelFileError, SHAPES},
    plane::Plane,
};

use super::{
    reader::{Reader, wrong},
    rules::MemoryRule,
    soundness,
};

impl Reader<'_> {
    pub(super) fn memory_kernel(
        &self,
        memory: MemoryRule,
        given: Option<Node<'_>>,
        gain: f64,
        channel: Place,
    ) -> Read<Option<Kernel>> {
        let place = given.map_or(channel, Node::place);
        let kernel = given.map(|given| scaled(&self.kernel(given)?, gain, place));
        let kernel = kernel.transpose()?;
        soundness::memory_kernel(memory, kernel.as_ref()).map_err(|odd| odd.at(place))?;
        Ok(kernel)
    }

    /// One kernel, or four for a pattern.
    pub(super) fn kernels(&self, node: Node<'_>, four: bool) -> Read<Vec<Kernel>> {
        let one = node.as_text().is_some() || node.as_rows().is_some();
        match (node.as_list(), four) {
            (_, false) if one => Ok(vec![self.kernel(node)?]),
            (Some(list), true) if !one && list.len() == 4 => {
                list.into_iter().map(|it| self.kernel(it)).collect()
            }
            (_, false) => Err(wrong(
                node.place(),
                "several kernels in one channel",
                "add pattern = \"2x2\" for four kernels, or one [[channel]] for each",
            )),
            (_, true) => Err(wrong(
                node.place(),
                "pattern = \"2x2\" needs four kernels",
                "give kernel = [k0, k1, k2, k3]; the pixel at (x, y) uses number 2*(y%2) + (x%2)",
            )),
        }
    }

    /// The kernels of a file of several, a `.npy` of shape (K,k,k) or (K,1,k,k); none where it is
    /// one kernel.
    pub(super) fn stack(&self, node: Node<'_>) -> Read<Option<Vec<Kernel>>> {
        let name = node
            .as_text()
            .filter(|name| Kernel::builtin(name).is_none());
        let Some(name) = name else {
            return Ok(None);
        };
        // What cannot be read is told of where one kernel is looked for.
        let bytes = (self.read)(name).unwrap_or_default();
        Kernel::several_from_npy(name, &bytes)
            .transpose()
            .map_err(|(what, help)| wrong(node.place(), format!("kernel file {what}"), help))
    }

    fn kernel(&self, node: Node<'_>) -> Read<Kernel> {
        if let Some(name) = node.as_text() {
            return self.named(name, node.place());
        }
        Kernel::from_rows(&node.as_rows().unwrap_or_default()).map_err(|e| {
            wrong(
                node.place(),
                e.to_string(),
                "kernels are 1x1, 3x3, 5x5, …: rows of numbers, row 0 to the north",
            )
        })
    }

    fn named(&self, name: &str, place: Place) -> Read<Kernel> {
        if let Some(kernel) = Kernel::builtin(name) {
            return Ok(kernel);
        }
        let bytes = (self.read)(name).map_err(|e| {
            let known: Vec<_> = Kernel::builtin_names().collect();
            wrong(
                place,
                format!("kernel \"{name}\" is neither built in nor a file that can be read ({e})"),
                &format!(
                    "give a file beside the sensor file, rows of numbers, or one of {}",
                    known.join(", ")
                ),
            )
        })?;
        Kernel::from_bytes(name, &bytes).map_err(|e| {
            let advice = match e {
                KernelFileError::Array(_) | KernelFileError::Kernel(_) => SHAPES,
                _ => "a kernel file is TOML with one of `weights`, `centre-surround` and `gaussians`, or a .npy array",
            };
            wrong(place, format!("kernel file {}", e.in_file(name)), advice)
        })
    }
}

pub(super) fn scaled(kernel: &Kernel, gain: f64, place: Place) -> Read<Kernel> {
    let scaled = kernel.weights() * gain;
    let is_zero = |weights: &Plane<f64>| weights.iter().all(|w| *w == 0.0);
    if is_zero(&scaled) && !is_zero(kernel.weights()) {
        let what = format!("with gain {gain:e}: every weight becomes 0");
        return Err(wrong(place, what, "give a larger gain"));
    }
    Kernel::new(scaled).map_err(|e| {
        let advice = match e {
            KernelError::Subnormal { .. } => "give a larger gain",
            _ => "give a smaller gain",
        };
        wrong(place, format!("with gain {gain:e}: {e}"), advice)
    })
}
