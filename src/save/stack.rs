//! A stack of planes as one `.npy` array, written plane by plane.
//!
//! Memory does not grow with the length of the stack: the header, which must say how many
//! planes there are, is written last (NPY format 1.0, NEP 1).

use std::{
    io::{self, Seek, SeekFrom, Write},
    marker::PhantomData,
    path::Path,
};

use super::{AtomicFile, SaveError};
use crate::{
    npy::{Element, framed},
    plane::{Plane, Size},
};

/// Bytes kept for the header, a multiple of 64 as the format asks.
const HEADER: usize = 128;

/// A growing array of shape (layers, planes, height, width).
#[derive(Debug)]
pub struct Stack<T> {
    file: AtomicFile,
    planes: usize,
    size: Size,
    layers: usize,
    element: PhantomData<T>,
}

impl<T: Element> Stack<T> {
    /// An empty stack that will be at `path`, with `planes` planes of `size` in each layer.
    ///
    /// # Errors
    /// When no file can be made in that folder.
    pub fn create(path: &Path, planes: usize, size: Size) -> Result<Self, SaveError> {
        let mut file = AtomicFile::create(path)?;
        let begun = file.write_all(&[0; HEADER]);
        begun.map_err(|cause| file.failed(cause))?;
        Ok(Self {
            file,
            planes,
            size,
            layers: 0,
            element: PhantomData,
        })
    }

    /// Adds one layer of planes.
    ///
    /// # Errors
    /// When the disk does not take it.
    ///
    /// # Panics
    /// When the layer has another number of planes, or planes of another size.
    pub fn push(&mut self, layer: impl IntoIterator<Item = Plane<T>>) -> Result<(), SaveError> {
        let mut planes = 0;
        for plane in layer {
            assert_eq!(Size::of(&plane), self.size, "a plane of another size");
            planes += 1;
            for value in &plane {
                let written = self.file.write_all(value.bytes().as_ref());
                written.map_err(|cause| self.file.failed(cause))?;
            }
        }
        assert_eq!(planes, self.planes, "a layer of another number of planes");
        self.layers += 1;
        Ok(())
    }

    /// Writes the header and gives the file its name.
    ///
    /// # Errors
    /// When the disk does not take it; whatever was at the path is then as it was.
    pub fn finish(self) -> Result<(), SaveError> {
        let Self {
            mut file,
            planes,
            size,
            layers,
            ..
        } = self;
        let shape = [layers, planes, size.height, size.width];
        let header = dictionary(T::DESCRIPTION, shape);
        let finish = |file: &mut AtomicFile| -> io::Result<()> {
            file.seek(SeekFrom::Start(0))?;
            file.write_all(&framed(&header, HEADER)?)
        };
        finish(&mut file).map_err(|cause| file.failed(cause))?;
        file.keep()
    }
}

fn dictionary(description: &str, [a, b, c, d]: [usize; 4]) -> String {
    format!("{{'descr': '{description}', 'fortran_order': False, 'shape': ({a}, {b}, {c}, {d}), }}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array4;

    #[test]
    fn a_stack_reads_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stack.npy");
        let mut stack = Stack::<i32>::create(&path, 2, Size::new(2, 3)).unwrap();
        for layer in 0..5 {
            let plane = |k| {
                Plane::from_shape_fn((2, 3), |(y, x)| 100 * layer + 10 * k + (3 * y + x) as i32)
            };
            stack.push([plane(0), plane(1)]).unwrap();
        }
        assert!(!path.exists());
        stack.finish().unwrap();
        let read: Array4<i32> = ndarray_npy::read_npy(&path).unwrap();
        assert_eq!(read.shape(), [5, 2, 2, 3]);
        assert_eq!(read[[4, 1, 1, 2]], 415);
        // Layers without end, of the most planes of the largest size, leave room in the header.
        let text = dictionary("<f4", [usize::MAX, 16, 65_536, 65_536]);
        assert_eq!(framed(&text, HEADER).unwrap().len(), HEADER);
    }
}
