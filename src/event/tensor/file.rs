//! Voxels, time surfaces or event frames in a file, layer after layer, in memory that does not grow.

use std::{
    io::{self, BufWriter, Seek, SeekFrom, Write},
    path::Path,
};

use half::f16;
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

use super::hdf5::Chunks;
use crate::{
    event::file::Steady,
    npy::framed,
    save::{AtomicFile, SaveError},
    unit::counted,
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

impl Precision {
    /// Bytes of a number.
    #[must_use]
    pub const fn bytes(self) -> u128 {
        match self {
            Self::Single => 4,
            Self::Half => 2,
        }
    }
}

/// In what the layers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// numpy's array.
    Npy,
    /// numpy's archive of arrays: the array by its name, and the names of the kinds as `kinds`.
    Npz,
    /// HDF5: a data set of the array's name, a chunk for each layer, and in the file's attribute
    /// `kinds` the names, a line each.
    Hdf5,
}

/// What every layer of a file is like.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// What the array is called in an archive or in HDF5, such as `voxels`.
    pub name: &'static str,
    /// Shape of a layer; that of the array has the number of layers before it.
    pub shape: Vec<usize>,
    /// How numbers are held.
    pub precision: Precision,
    /// What the kinds of cells are called; empty where nobody says so.
    pub kinds: Vec<String>,
}

/// Bytes kept for the header of an array, a multiple of 64 as the format asks.
const HEADER: usize = 192;

/// A file of layers that grows.
#[derive(Debug)]
pub struct TensorFile {
    file: AtomicFile,
    layers: Layers,
    count: u64,
    body: Body,
}

#[derive(Debug)]
enum Body {
    /// Written as it comes, its header at the end.
    Npy,
    /// In a temporary file until it is whole.
    Npz(BufWriter<std::fs::File>),
    /// Chunks as they come, the way to them at the end.
    Hdf5(Chunks),
}

impl TensorFile {
    /// No layers yet, of a file that will be at `path`.
    ///
    /// # Errors
    /// When no file can be made in that folder, or nothing can be written there.
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
    /// When it has more values or fewer, when the disk does not take it, or 16 bits do not hold it;
    /// of the disk, the file is then no longer whole, and is not to be finished.
    pub fn push(&mut self, layer: &[f32]) -> Result<(), SaveError> {
        let shape = &self.layers.shape;
        let want = shape
            .iter()
            .fold(1, |n: usize, side| n.saturating_mul(*side));
        if layer.len() != want {
            let why = format!(
                "a layer of {}, and layers of shape {shape:?} have {want}",
                counted(layer.len() as u64, "value")
            );
            let cause = io::Error::new(io::ErrorKind::InvalidData, why);
            return Err(self.file.failed(cause));
        }
        if self.layers.precision == Precision::Half {
            let most = layer
                .iter()
                .fold(0.0f32, |most, value| most.max(value.abs()));
            if f16::from_f32(most).is_infinite() {
                let cause = io::Error::new(
                    io::ErrorKind::InvalidData,
                    format!(
                        "a value of {most} is beyond 16 bits, which end at {}: take 32 bits, shorter windows or more bins, or normalise",
                        f16::MAX
                    ),
                );
                return Err(self.file.failed(cause));
            }
        }
        let written = match &mut self.body {
            Body::Npy => self.file.write_all(&bytes(layer, self.layers.precision)),
            Body::Npz(rest) => rest.write_all(&bytes(layer, self.layers.precision)),
            Body::Hdf5(chunks) => chunks.push(&mut self.file, &bytes(layer, self.layers.precision)),
        };
        written.map_err(|cause| self.file.failed(cause))?;
        self.count += 1;
        Ok(())
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
            Container::Hdf5 => Chunks::begin(out, layers).map(Self::Hdf5),
        }
    }

    fn finish(self, out: &mut AtomicFile, layers: &Layers, count: u64) -> io::Result<()> {
        let header = header(layers, count)?;
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
                let written = archive(&mut steady, rest.get_mut(), layers);
                // The first error.
                steady.lost.map_or(written, Err)
            }
            Self::Hdf5(chunks) => chunks.finish(out, layers),
        }
    }
}

/// A layer as it stands in an array, little-endian.
fn bytes(layer: &[f32], precision: Precision) -> Vec<u8> {
    fn each<const N: usize>(layer: &[f32], number: impl Fn(f32) -> [u8; N]) -> Vec<u8> {
        let mut bytes = vec![0; layer.len() * N];
        let (numbers, _) = bytes.as_chunks_mut::<N>();
        for (bytes, value) in numbers.iter_mut().zip(layer) {
            *bytes = number(*value);
        }
        bytes
    }
    match precision {
        Precision::Single => each(layer, f32::to_le_bytes),
        Precision::Half => each(layer, |value| f16::from_f32(value).to_le_bytes()),
    }
}

fn header(layers: &Layers, count: u64) -> io::Result<Vec<u8>> {
    let word = match layers.precision {
        Precision::Single => "<f4",
        Precision::Half => "<f2",
    };
    let shape: Vec<String> = layers.shape.iter().map(usize::to_string).collect();
    let text = format!(
        "{{'descr': '{word}', 'fortran_order': False, 'shape': ({count}, {}), }}",
        shape.join(", ")
    );
    framed(&text, HEADER)
}

fn archive(out: &mut Steady<'_>, array: &mut std::fs::File, layers: &Layers) -> io::Result<()> {
    let length = array.seek(SeekFrom::End(0))?;
    array.seek(SeekFrom::Start(0))?;
    let mut zip = ZipWriter::new(out);
    // The same file for the same voxels: no clock.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .large_file(length >= 1 << 31);
    zip.start_file(format!("{}.npy", layers.name), options)?;
    io::copy(array, &mut zip)?;
    if !layers.kinds.is_empty() {
        zip.start_file("kinds.npy", options)?;
        zip.write_all(&texts(&layers.kinds)?)?;
    }
    zip.finish()?;
    Ok(())
}

/// Texts as an array of numpy's unicode strings.
fn texts(texts: &[String]) -> io::Result<Vec<u8>> {
    let longest = texts.iter().map(|text| text.chars().count()).max();
    let longest = longest.unwrap_or(1).max(1);
    let text = format!(
        "{{'descr': '<U{longest}', 'fortran_order': False, 'shape': ({},), }}",
        texts.len()
    );
    let mut bytes = framed(&text, 0)?;
    for text in texts {
        let letters = text.chars().map(u32::from).chain(std::iter::repeat(0));
        for letter in letters.take(longest) {
            bytes.extend(letter.to_le_bytes());
        }
    }
    Ok(bytes)
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
            name: "voxels",
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

    /// By hdf5-pure, which has no part in the writing.
    #[cfg(feature = "hdf5")]
    #[test]
    fn layers_read_back_from_hdf5() {
        for precision in [Precision::Single, Precision::Half] {
            let bytes = written(Container::Hdf5, precision);
            let file = hdf5_pure::File::from_bytes(bytes).unwrap();
            let array = file.dataset("voxels").unwrap();
            assert_eq!(array.shape().unwrap(), [3, 2, 3]);
            let kinds = file.root().attrs().unwrap();
            assert_eq!(kinds["kinds"].as_str(), Some("é\ntwo"));
            let raw = array.read_raw().unwrap();
            let read: Vec<f32> = match precision {
                Precision::Single => array.read_f32().unwrap(),
                Precision::Half => { raw.as_chunks::<2>().0.iter() }
                    .map(|half| f16::from_le_bytes(*half).to_f32())
                    .collect(),
            };
            assert_eq!(read, wanted().into_raw_vec_and_offset().0);
        }
    }

    /// More layers than a page of the reference library's own index holds, and none.
    #[cfg(feature = "hdf5")]
    #[test]
    fn any_number_of_layers_is_found() {
        for count in [0, 1, 1024, 3000] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.h5");
            let layers = Layers {
                name: "voxels",
                shape: vec![300],
                precision: Precision::Single,
                kinds: Vec::new(),
            };
            let mut file = TensorFile::create(&path, Container::Hdf5, layers).unwrap();
            for n in 0..count {
                file.push(&[n as f32; 300]).unwrap();
            }
            file.finish().unwrap();
            let file = hdf5_pure::File::open(&path).unwrap();
            let array = file.dataset("voxels").unwrap();
            assert_eq!(array.shape().unwrap(), [count, 300]);
            let read = array.read_f32().unwrap();
            assert!((0..count as usize * 300).all(|i| read[i] == (i / 300) as f32));
        }
    }
}
