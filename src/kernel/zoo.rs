//! The built-in kernels: the files of `kernels/`, compiled into the program.

use super::Kernel;

macro_rules! zoo {
    ($($name:literal),* $(,)?) => {
        /// Name and text of each built-in.
        const ZOO: &[(&str, &str)] = &[
            $(($name, include_str!(concat!("../../kernels/", $name, ".toml")))),*
        ];
    };
}

zoo![
    "authors-csdvs-5",
    "authors-csdvs-new-5",
    "authors-laplacian",
    "binary-horizontal",
    "binary-vertical",
    "csdvs-3",
    "csdvs-5",
    "csdvs-7",
    "dog",
    "dog-amplitudes",
    "dvs",
    "laplacian",
    "oblique-135",
    "oblique-45",
    "rgc-5x5",
    "rgc-5x5-ternary",
    "sobel-x",
    "sobel-y",
];

impl Kernel {
    /// The built-in of this name; `None` when there is none.
    #[must_use]
    pub fn builtin(name: &str) -> Option<Self> {
        let text = ZOO.iter().find(|(known, _)| *known == name)?.1;
        // A test reads every shipped file, so a shipped file is a kernel.
        Self::from_toml(name, text).ok()
    }

    /// The names of the built-ins, in alphabetical order.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        ZOO.iter().map(|(name, _)| *name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_file_is_a_kernel_and_listed() {
        for (name, text) in ZOO {
            let kernel = Kernel::from_toml(name, text);
            assert!(kernel.is_ok(), "{name}: {kernel:?}");
            assert!(
                text.contains(&format!("name = \"{name}\"")),
                "{name} names itself otherwise"
            );
            assert!(text.contains("source = "), "{name} has no source");
        }
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/kernels");
        let files = std::fs::read_dir(folder).unwrap().count();
        assert_eq!(files, ZOO.len(), "a file of kernels/ is not listed");
        assert!(ZOO.is_sorted());
    }
}
