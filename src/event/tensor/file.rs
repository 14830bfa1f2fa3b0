//! Voxels and what is like them in a file, layer after layer: `.npy` and `.npz` in memory that does
//! not grow, HDF5 in memory that holds all of it.

use std::{
    io::{self, BufWriter, Seek, SeekFrom, Write},
    path::Path,
};

use half::f16;
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use crate::{
    event::file::Steady,
    save::{AtomicFile, SaveError},
};

/// How a number is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// In 32 bits.
    #[default]
    Single,
    /// In 16 bits.
    Half,
}

/// In what the layers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// numpy's array.
    Npy,
    /// numpy's archive of arrays: `voxels`, and the names of the kinds as `kinds`.
    Npz,
    /// HDF5: the data set `voxels`, whose attribute `kinds` has the names; needs the feature
    /// `hdf5`.
    Hdf5,
}

/// What every layer of a file is like.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Shape of a layer; that of the array has the number of layers before it.
    pub shape: Vec<usize>,
    /// How numbers are held.
    pub precision: Precision,
    /// What the kinds of cells are called; empty where nobody says so.
    pub kinds: Vec<String>,
}

/// What the array is called in an archive.
const NAME: &str = "voxels";

/// Bytes kept for the header of an array, a multiple of 64 as the format asks.
const HEADER: usize = 192;

/// A file of layers that grows.
pub struct TensorFile {
    file: AtomicFile,
    layers: Layers,
    count: u64,
    body: Body,
}

enum Body {
    /// Written as it comes, its header at the end.
    Npy,
    /// In a temporary file until it is whole.
    Npz(BufWriter<std::fs::File>),
    #[cfg(feature = "hdf5")]
    Hdf5(hdf5::Open),
}

impl TensorFile {
    /// No layers yet, of a file that will be at `path`.
    ///
    /// # Errors
    /// When no file can be made in that folder, or this build or the format has no such numbers.
    pub fn create(path: &Path, container: Container, layers: Layers) -> Result<Self, SaveError> {
        let mut file = AtomicFile::create(path)?;
        let begun = Body::begin(container, &layers, &mut file);
        let body = begun.map_err(|cause| file.failed(cause))?;
        Ok(Self {
            file,
            layers,
            count: 0,
            body,
        })
    }

    /// Adds a layer: as many values as its shape has.
    ///
    /// # Errors
    /// When the disk does not take it.
    pub fn push(&mut self, layer: &[f32]) -> Result<(), SaveError> {
        self.count += 1;
        let written = match &mut self.body {
            Body::Npy => self.file.write_all(&bytes(layer, self.layers.precision)),
            Body::Npz(rest) => rest.write_all(&bytes(layer, self.layers.precision)),
            #[cfg(feature = "hdf5")]
            Body::Hdf5(open) => {
                open.push(layer);
                Ok(())
            }
        };
        written.map_err(|cause| self.file.failed(cause))
    }

    /// Gives the file its name; returns how many layers it has.
    ///
    /// # Errors
    /// When the disk does not take it; whatever was at the path is then as it was.
    pub fn finish(self) -> Result<u64, SaveError> {
        let Self {
            mut file,
            layers,
            count,
            body,
        } = self;
        let finished = body.finish(&mut file, &layers, count);
        finished.map_err(|cause| file.failed(cause))?;
        file.keep()?;
        Ok(count)
    }
}

impl Body {
    fn begin(container: Container, layers: &Layers, out: &mut AtomicFile) -> io::Result<Self> {
        match container {
            Container::Npy => {
                out.write_all(&[0; HEADER])?;
                Ok(Self::Npy)
            }
            Container::Npz => {
                let mut rest = BufWriter::new(tempfile::tempfile()?);
                rest.write_all(&[0; HEADER])?;
                Ok(Self::Npz(rest))
            }
            Container::Hdf5 => Self::hdf5(layers),
        }
    }

    #[cfg(feature = "hdf5")]
    fn hdf5(layers: &Layers) -> io::Result<Self> {
        hdf5::Open::new(layers).map(Self::Hdf5)
    }

    #[cfg(not(feature = "hdf5"))]
    fn hdf5(_: &Layers) -> io::Result<Self> {
        Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "this amacrine was built without HDF5: build with --features hdf5",
        ))
    }

    fn finish(self, out: &mut AtomicFile, layers: &Layers, count: u64) -> io::Result<()> {
        let header = header(layers, count);
        match self {
            Self::Npy => {
                out.seek(SeekFrom::Start(0))?;
                out.write_all(&header)?;
                out.seek(SeekFrom::End(0)).map(|_| ())
            }
            Self::Npz(mut rest) => {
                rest.seek(SeekFrom::Start(0))?;
                rest.write_all(&header)?;
                rest.flush()?;
                let mut steady = Steady::new(out);
                let written = archive(&mut steady, rest.get_mut(), &layers.kinds);
                // The first error.
                steady.lost.map_or(written, Err)
            }
            #[cfg(feature = "hdf5")]
            Self::Hdf5(open) => open.finish(out, layers, count),
        }
    }
}

/// A layer as it stands in an array, little-endian.
fn bytes(layer: &[f32], precision: Precision) -> Vec<u8> {
    match precision {
        Precision::Single => layer.iter().flat_map(|v| v.to_le_bytes()).collect(),
        Precision::Half => layer
            .iter()
            .flat_map(|v| f16::from_f32(*v).to_le_bytes())
            .collect(),
    }
}

/// NPY format 1.0, NEP 1.
fn header(layers: &Layers, count: u64) -> Vec<u8> {
    let word = match layers.precision {
        Precision::Single => "<f4",
        Precision::Half => "<f2",
    };
    let shape: Vec<String> = layers.shape.iter().map(usize::to_string).collect();
    let text = format!(
        "{{'descr': '{word}', 'fortran_order': False, 'shape': ({count}, {}), }}",
        shape.join(", ")
    );
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend(((HEADER - 10) as u16).to_le_bytes());
    header.extend(text.as_bytes());
    header.resize(HEADER - 1, b' ');
    header.push(b'\n');
    header
}

fn archive(out: &mut Steady<'_>, array: &mut std::fs::File, kinds: &[String]) -> io::Result<()> {
    let length = array.seek(SeekFrom::End(0))?;
    array.seek(SeekFrom::Start(0))?;
    let mut zip = ZipWriter::new(out);
    // The same file for the same voxels: no clock.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .large_file(length >= 1 << 31);
    zip.start_file(format!("{NAME}.npy"), options)?;
    io::copy(array, &mut zip)?;
    if !kinds.is_empty() {
        zip.start_file("kinds.npy", options)?;
        zip.write_all(&texts(kinds))?;
    }
    zip.finish()?;
    Ok(())
}

/// Texts as an array of numpy's unicode strings.
fn texts(texts: &[String]) -> Vec<u8> {
    let longest = texts.iter().map(|text| text.chars().count()).max();
    let longest = longest.unwrap_or(1).max(1);
    let text = format!(
        "{{'descr': '<U{longest}', 'fortran_order': False, 'shape': ({},), }}",
        texts.len()
    );
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    let length = (10 + text.len() + 1).next_multiple_of(64) - 10;
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.resize(10 + length - 1, b' ');
    bytes.push(b'\n');
    for text in texts {
        let letters = text.chars().map(u32::from).chain(std::iter::repeat(0));
        for letter in letters.take(longest) {
            bytes.extend(letter.to_le_bytes());
        }
    }
    bytes
}

#[cfg(feature = "hdf5")]
mod hdf5 {
    use std::io;

    use hdf5_pure::{AttrValue, FileBuilder};

    use super::{AtomicFile, Layers, NAME, Precision};

    /// A file is made of all layers at once: what it is made by appends along one axis only.
    pub(super) struct Open {
        values: Vec<f32>,
    }

    impl Open {
        pub(super) fn new(layers: &Layers) -> io::Result<Self> {
            if layers.precision == Precision::Half {
                return Err(io::Error::new(
                    io::ErrorKind::Unsupported,
                    "HDF5 is written in 32 bits: take .npy or .npz for 16",
                ));
            }
            Ok(Self { values: Vec::new() })
        }

        pub(super) fn push(&mut self, layer: &[f32]) {
            self.values.extend_from_slice(layer);
        }

        pub(super) fn finish(
            self,
            out: &mut AtomicFile,
            layers: &Layers,
            count: u64,
        ) -> io::Result<()> {
            let with = |first: u64| -> Vec<u64> {
                let rest = layers.shape.iter().map(|n| *n as u64);
                std::iter::once(first).chain(rest).collect()
            };
            let mut builder = FileBuilder::new();
            builder.set_attr("kinds", AttrValue::String(layers.kinds.join("\n")));
            let array = builder.create_dataset(NAME);
            array.with_f32_data(&self.values).with_shape(&with(count));
            if count > 0 {
                array.with_chunks(&with(1)).with_deflate(1);
            }
            let bytes = builder.finish().map_err(io::Error::other)?;
            io::Write::write_all(out, &bytes)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array3, ArrayD};
    use ndarray_npy::ReadNpyExt;

    fn written(container: Container, precision: Precision) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let layers = Layers {
            shape: vec![2, 3],
            precision,
            kinds: vec!["é".to_owned(), "two".to_owned()],
        };
        let mut file = TensorFile::create(&path, container, layers).unwrap();
        for layer in 0..3 {
            let values: Vec<f32> = (0..6).map(|i| layer as f32 + 0.25 * i as f32).collect();
            file.push(&values).unwrap();
        }
        assert_eq!(file.finish().unwrap(), 3);
        std::fs::read(path).unwrap()
    }

    fn wanted() -> Array3<f32> {
        Array3::from_shape_fn((3, 2, 3), |(l, y, x)| l as f32 + 0.25 * (3 * y + x) as f32)
    }

    #[test]
    fn layers_read_back() {
        let bytes = written(Container::Npy, Precision::Single);
        let read = Array3::<f32>::read_npy(&bytes[..]).unwrap();
        assert_eq!(read, wanted());
        let bytes = written(Container::Npy, Precision::Half);
        // Quarters are whole in 16 bits.
        let halves = bytes[HEADER..].as_chunks::<2>().0.iter();
        let read: Vec<f32> = halves.map(|h| f16::from_le_bytes(*h).to_f32()).collect();
        assert_eq!(read, wanted().into_raw_vec_and_offset().0);
        assert!(String::from_utf8_lossy(&bytes[..HEADER]).contains("'<f2'"));
        let bytes = written(Container::Npz, Precision::Single);
        let mut zip = zip::ZipArchive::new(io::Cursor::new(bytes)).unwrap();
        let read = ArrayD::<f32>::read_npy(zip.by_name("voxels.npy").unwrap()).unwrap();
        assert_eq!(read, wanted().into_dyn());
        let mut kinds = Vec::new();
        io::Read::read_to_end(&mut zip.by_name("kinds.npy").unwrap(), &mut kinds).unwrap();
        assert!(String::from_utf8_lossy(&kinds).contains("'<U3'"));
    }

    #[cfg(feature = "hdf5")]
    #[test]
    fn layers_read_back_from_hdf5() {
        let bytes = written(Container::Hdf5, Precision::Single);
        let file = hdf5_pure::File::from_bytes(bytes).unwrap();
        let array = file.dataset("voxels").unwrap();
        assert_eq!(
            array.read_f32().unwrap(),
            wanted().into_raw_vec_and_offset().0
        );
    }
}
