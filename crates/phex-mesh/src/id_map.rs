//! Hash maps and sets of ids, with a hash that costs one multiplication.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};

/// A map whose keys are made of ids.
pub type IdMap<K, V> = HashMap<K, V, BuildHasherDefault<IdHasher>>;
/// A set of what is made of ids.
pub type IdSet<K> = HashSet<K, BuildHasherDefault<IdHasher>>;

/// Multiplicative hash of small numbers (Knuth, The Art of Computer Programming 3, section 6.4): no
/// defence against keys made to collide.
#[derive(Clone, Copy, Debug, Default)]
pub struct IdHasher(u64);

/// 2^64 over the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

impl Hasher for IdHasher {
    #[inline]
    fn finish(&self) -> u64 {
        // Products are well mixed in their high bits, tables look at the low ones too.
        self.0.rotate_left(26)
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.write_u64(u64::from(*b)));
    }

    #[inline]
    fn write_u32(&mut self, n: u32) {
        self.write_u64(u64::from(n));
    }

    #[inline]
    fn write_u64(&mut self, n: u64) {
        self.0 = (self.0.rotate_left(5) ^ n).wrapping_mul(GOLDEN);
    }

    #[inline]
    fn write_usize(&mut self, n: usize) {
        self.write_u64(n as u64);
    }

    #[inline]
    fn write_isize(&mut self, n: isize) {
        self.write_u64(n as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::hash::Hash;

    /// Pairs of neighbouring numbers, as edges are, fill the low bits evenly, and the seven high
    /// ones that tables compare.
    #[test]
    fn pairs_spread() {
        let (mut low, mut high) = (vec![0; 1024], vec![0; 128]);
        let pairs = (0..200u32).flat_map(|i| (0..200u32).map(move |j| (i, j)));
        for pair in pairs {
            let mut hasher = IdHasher::default();
            pair.hash(&mut hasher);
            low[hasher.finish() as usize % 1024] += 1;
            high[(hasher.finish() >> 57) as usize] += 1;
        }
        assert!(low.iter().all(|n| (15..80).contains(n)), "{low:?}");
        assert!(high.iter().all(|n| (150..600).contains(n)), "{high:?}");
    }
}
