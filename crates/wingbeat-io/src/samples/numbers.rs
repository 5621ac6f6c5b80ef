//! Numbers of any width and byte order.

use std::io::Read;

/// How one number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberKind {
    /// Whole, with sign.
    Signed(u8),
    /// Whole, without sign.
    Unsigned(u8),
    /// IEEE 754.
    Float(u8),
}

impl NumberKind {
    /// Bytes of one number.
    pub fn size(self) -> usize {
        let (Self::Signed(n) | Self::Unsigned(n) | Self::Float(n)) = self;
        n.into()
    }

    /// None for a width that is not 1, 2, 4 or 8 (floats: 4 or 8).
    pub fn checked(self) -> Option<Self> {
        match self {
            Self::Float(4 | 8) | Self::Signed(1 | 2 | 4 | 8) | Self::Unsigned(1 | 2 | 4 | 8) => Some(self),
            _ => None,
        }
    }

    /// The numbers in `bytes`, in the unit of the file; a last one that is cut short is left out.
    pub fn read(self, bytes: &[u8], big_endian: bool) -> Vec<f64> {
        bytes.chunks_exact(self.size()).map(|chunk| self.one(chunk, big_endian)).collect()
    }

    /// The numbers that `reader` gives, in the unit of the file, until it ends or fails.
    pub fn stream(self, mut reader: impl Read, big_endian: bool) -> impl Iterator<Item = f64> {
        let mut word = [0; 8];
        std::iter::from_fn(move || {
            let chunk = &mut word[..self.size().min(8)];
            reader.read_exact(chunk).ok()?;
            Some(self.one(chunk, big_endian))
        })
    }

    /// The number in `chunk`, in the unit of the file, which has its bytes.
    pub fn one(self, chunk: &[u8], big_endian: bool) -> f64 {
        let mut word = [0; 8];
        for (place, byte) in word.iter_mut().zip(chunk) {
            *place = *byte;
        }
        if big_endian {
            word[..chunk.len().min(8)].reverse();
        }
        let whole = u64::from_le_bytes(word);
        match self {
            Self::Float(4) => f64::from(f32::from_bits(whole as u32)),
            Self::Float(_) => f64::from_bits(whole),
            Self::Unsigned(_) => whole as f64,
            Self::Signed(n) => {
                let unused = 64 - 8 * u32::from(n.min(8));
                ((whole << unused) as i64 >> unused) as f64
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_and_signs() {
        assert_eq!(NumberKind::Signed(2).read(&[0xff, 0xfe, 0, 2], true), [-2.0, 2.0]);
        assert_eq!(NumberKind::Signed(2).read(&[0xfe, 0xff, 2, 0, 9], false), [-2.0, 2.0]);
        assert_eq!(NumberKind::Unsigned(1).read(&[200], false), [200.0]);
        assert_eq!(NumberKind::Float(4).read(&1.5f32.to_be_bytes(), true), [1.5]);
        assert_eq!(NumberKind::Float(8).read(&(-0.1f64).to_le_bytes(), false), [-0.1]);
        assert_eq!((NumberKind::Float(2).checked(), NumberKind::Signed(3).checked()), (None, None));
        let stream = NumberKind::Signed(2).stream(&[0xfe, 0xff, 2, 0, 9][..], false);
        assert_eq!(stream.collect::<Vec<_>>(), [-2.0, 2.0]);
    }
}
