//! The list of formats.
//!
//! A new format is a file beside this one, with its [`Entry`](super::entry::Entry), and a line
//! of the list.

/// Gives the list to a macro: of each format what it is, its variant and its file. What is said
/// of a format stands in its file.
macro_rules! formats {
    ($macro:ident) => {
        $macro! {
            /// Comma-separated text.
            Csv => csv,
            /// Text with seconds, one event a line.
            Txt => txt,
            /// Text with its size in the first line, as E2VID reads it.
            E2vid => e2vid,
            /// The same in a zip archive.
            E2vidZip => e2vid_zip,
            /// numpy's structured array.
            Npy => npy,
            /// numpy's archive of arrays.
            Npz => npz,
            /// Prophesee EVT 2.0: 32-bit words.
            Evt2 => evt2,
            /// Prophesee EVT 2.1: 64-bit words, 32 pixels of a row at a time.
            Evt21 => evt21,
            /// Prophesee EVT 3.0: 16-bit words with a state.
            Evt3 => evt3,
            /// Prophesee DAT: 64-bit records.
            Dat => dat,
            /// jAER's AEDAT 2.0: 64-bit records, big-endian.
            Aedat2 => aedat2,
            /// cAER's AEDAT 3.1: packets of 64-bit records.
            Aedat3 => aedat3,
            /// DV's AEDAT 4.0: compressed packets.
            Aedat4 => aedat4,
            /// Event Stream: five bytes an event.
            Es => es,
            /// HDF5 as in the DSEC data set; needs the feature `hdf5`.
            Hdf5 => hdf5,
            /// Parquet; needs the feature `parquet`.
            Parquet => parquet,
        }
    };
}

/// Makes [`Format`] and [`Format::ALL`] from the list.
macro_rules! variants {
    ($(#[doc = $about:literal] $format:ident => $file:ident,)+) => {
        /// A kind of event file.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Format {
            $(#[doc = $about] $format,)+
        }

        impl Format {
            /// All of them, in the order in which helps and pages list them.
            pub const ALL: &'static [Self] = &[$(Self::$format),+];
        }
    };
}

formats!(variants);

pub(super) use formats;
