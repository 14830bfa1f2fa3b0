//! Numbers that are written.

/// A number that an array file can hold.
pub trait Element: Copy {
    /// Its name in the header.
    const DESCRIPTION: &'static str;

    /// So many bytes.
    type Bytes: AsRef<[u8]>;

    /// Its bytes, little-endian.
    fn bytes(self) -> Self::Bytes;
}

macro_rules! element {
    ($($number:ty, $bytes:literal, $description:literal;)*) => {$(
        impl Element for $number {
            const DESCRIPTION: &'static str = $description;
            type Bytes = [u8; $bytes];

            fn bytes(self) -> Self::Bytes {
                self.to_le_bytes()
            }
        }
    )*};
}

element! {
    u8, 1, "|u1";
    i32, 4, "<i4";
    f32, 4, "<f4";
    f64, 8, "<f8";
}
