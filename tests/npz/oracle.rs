//! The authors' outputs: which sensor a file is of.

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
};

use ndarray::{Array1, Array4, ArrayD, ArrayView2, Axis};

use super::Npz;

/// A file of reference outputs.
pub struct Oracle {
    pub name: String,
    pub arrays: Npz,
}

impl Oracle {
    pub fn open(path: &Path) -> Self {
        Self {
            name: path.display().to_string(),
            arrays: Npz::open(path),
        }
    }

    pub fn has(&self, key: &str) -> bool {
        self.arrays.has(key)
    }

    pub fn f64(&mut self, key: &str) -> ArrayD<f64> {
        self.arrays.array(key)
    }

    pub fn is(&self, mode: &str) -> bool {
        self.name.contains(mode)
    }

    /// The sensor file of this mode.
    pub fn sensor(&mut self) -> String {
        let old = self.is("oldmem");
        let pos = self.f64("pos_thres");
        let neg = self.f64("neg_thres");
        let kernels = self.kernels();
        let memory_kernels = if old {
            self.planes("mem_kernel")
        } else {
            vec![]
        };
        let spatial = self.is("svk");
        let mut text = format!(
            "response = \"identity\"\nmemory = \"{}\"\nborder = \"{}\"\nrefractory = {{ us = {:?}, rule = \"authors\" }}\n",
            if old {
                "authors-pixel-step"
            } else {
                "filtered-step"
            },
            if self.is("zeropad") || self.is("dog") {
                "zero"
            } else {
                "replicate"
            },
            self.f64("refractory_s").first().unwrap() * 1e6,
        );
        for channel in 0..pos.shape()[0] {
            let own = if spatial {
                &kernels[..]
            } else {
                &kernels[channel..=channel]
            };
            let four: Vec<_> = (0..4).map(|i| own[i % own.len()].clone()).collect();
            let thresholds: Vec<_> = (0..4)
                .map(|i| {
                    let at = [channel, i / 2, i % 2];
                    format!(
                        "{{ on = {:?}, off = {:?} }}",
                        pos[at.as_slice()],
                        neg[at.as_slice()]
                    )
                })
                .collect();
            let _ = write!(
                text,
                "[[channel]]\npattern = \"2x2\"\nkernel = [{}]\nthreshold = [{}]\nlog-temporal = {}\n",
                four.join(", "),
                thresholds.join(", "),
                self.is("logtemporal"),
            );
            if let Some(kernel) = memory_kernels.get(channel) {
                let _ = writeln!(text, "memory-kernel = {kernel}");
            }
        }
        text
    }

    fn kernels(&mut self) -> Vec<String> {
        if self.has("kernel") {
            return self.planes("kernel");
        }
        // The difference of two Gaussians of different sizes.
        let (small, large) = (self.f64("gauss_1"), self.f64("gauss_2"));
        let amp: Array1<f64> = if self.has("amp") {
            self.f64("amp").into_dimensionality().unwrap()
        } else {
            Array1::ones(2)
        };
        let mut weights = -amp[1]
            * &large
                .index_axis(Axis(0), 0)
                .index_axis(Axis(0), 0)
                .to_owned();
        let inset = (weights.shape()[0] - small.shape()[2]) / 2;
        for (at, value) in small.indexed_iter() {
            weights[[at[2] + inset, at[3] + inset].as_slice()] += amp[0] * value;
        }
        vec![rows(&weights.view().into_dimensionality().unwrap())]
    }

    fn planes(&mut self, key: &str) -> Vec<String> {
        let all: Array4<f64> = self.f64(key).into_dimensionality().unwrap();
        all.outer_iter()
            .map(|k| rows(&k.index_axis(Axis(0), 0)))
            .collect()
    }
}

fn rows(plane: &ArrayView2<'_, f64>) -> String {
    let rows: Vec<_> = plane
        .rows()
        .into_iter()
        .map(|row| format!("{:?}", row.to_vec()))
        .collect();
    format!("[{}]", rows.join(", "))
}

/// All stable files, in order.
pub fn files() -> Vec<PathBuf> {
    let mut files = Vec::new();
    for clip in ["mini_camera_15x21", "mini_random_16x20"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("tests/oracle")
            .join(clip);
        for entry in folder.read_dir().unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "npz") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}
