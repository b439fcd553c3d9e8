//! Counter-based random streams: the only place in the library that makes a generator.
//!
//! A stream is named by (seed, domain, index): there is no global state, and asking for the streams
//! in another order, or from another thread, gives the same numbers. The counter (domain, index)
//! enters the generator's first state word through a bijection of 64-bit integers, so two different
//! counters under one seed never start in the same state.

use rand::rngs::Xoshiro256PlusPlus;
use rand::{Rng, RngExt, SeedableRng};

/// Portable generator (Xoshiro256++, Blackman and Vigna 2021) started by [`stream`].
pub type Stream = Xoshiro256PlusPlus;

/// Returns the stream of random numbers for one counter: `high` and `low` name, for example, a
/// pixel and a sample of it.
pub fn stream(seed: u64, high: u32, low: u32) -> Stream {
    let mut state = [0u8; 32];
    for (bytes, hash) in state.chunks_exact_mut(8).zip(stream_hashes(seed)) {
        bytes.copy_from_slice(&hash.number(high, low).to_le_bytes());
    }
    Stream::from_seed(state)
}

/// Returns the hashes that turn a counter into the four state words in which its [`stream`] starts.
#[inline]
pub(crate) fn stream_hashes(seed: u64) -> [CounterHash; 4] {
    // Each word has its own key.
    [0, 1, 2, 3].map(|i| CounterHash::new(seed.wrapping_add(GOLDEN.wrapping_mul(i))))
}

/// Returns the number of a counter under a key of its own, apart from those of [`stream_hashes`].
#[inline]
pub(crate) fn scramble_for(seed: u64, high: u32, low: u32) -> u64 {
    number_for(seed.wrapping_add(GOLDEN.wrapping_mul(4)), high, low)
}

/// Returns a number for a counter: for a fixed seed a bijection, so that different counters have
/// different numbers.
#[inline]
pub(crate) fn number_for(seed: u64, high: u32, low: u32) -> u64 {
    CounterHash::new(seed).number(high, low)
}

/// Hash of counters under one seed, see [`number_for`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct CounterHash(u64);

impl CounterHash {
    #[inline]
    pub fn new(seed: u64) -> Self {
        Self(mix(seed.wrapping_add(GOLDEN)))
    }

    #[inline]
    pub fn number(self, high: u32, low: u32) -> u64 {
        let counter = (u64::from(high) << 32) | u64::from(low);
        mix(counter ^ self.0)
    }
}

/// Returns the seed of a named part of the program (a trial, an experiment): adding or reordering
/// names changes no other name's numbers.
pub fn seed_for(master: u64, name: &str) -> u64 {
    name.bytes().fold(mix(master), |hash, byte| {
        mix((hash ^ u64::from(byte)).wrapping_add(GOLDEN))
    })
}

/// Returns one uniform number in [0, 1) with 53 random bits.
#[inline]
pub fn uniform<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    rng.random()
}

/// Returns two independent uniform numbers in [0, 1).
#[inline]
pub fn uniform2<R: Rng + ?Sized>(rng: &mut R) -> [f64; 2] {
    [rng.random(), rng.random()]
}

const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// Applies the finaliser of SplitMix64 (Steele, Lea and Flood 2014): a bijection of 64-bit
/// integers.
#[inline]
pub(crate) const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
