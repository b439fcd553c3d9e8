//! Where an estimator's random numbers come from: independent streams, or Owen-scrambled Sobol' points.

use std::convert::Infallible;

use rand::{Rng, TryRng};

use crate::rng::Stream;

/// A source of uniform numbers that knows which part of a path asks.
///
/// The dimensions of one sample are divided into blocks of [`BLOCK`]: block 0 is the camera's, block
/// k ≥ 1 that of the eye path's k-th vertex, block [`LIGHT`] + k that of the light path's k-th vertex
/// (k = 0 is the emitter). Within a block the order of use is the order of dimensions: which emitter,
/// point on it, direction, roulette. So a dimension means the same in every estimator that walks.
pub trait Sampler: Rng {
    /// Says that the next numbers belong to this block. Independent streams need not know.
    #[inline]
    fn block(&mut self, _block: u32) {}
}

/// Dimensions per block.
pub const BLOCK: u32 = 8;
/// The first block of the light path.
pub const LIGHT: u32 = 1 << 16;

impl Sampler for Stream {}

/// One point of a Sobol' sequence (Joe and Kuo 2008) with Owen scrambling by hash (Burley 2020).
///
/// Each block takes the first [`BLOCK`] dimensions of a sequence with scramble and shuffle of its own,
/// so that there are as many as a path needs. The 23 leading bits of a number are the sequence's, the
/// others those of an independent stream.
#[derive(Clone, Debug)]
pub struct Sobol {
    index: u32,
    scramble: u32,
    block: u32,
    dimension: u32,
    fill: Stream,
}

/// The most points of one scramble.
pub const LONGEST: u32 = 1 << 16;

impl Sobol {
    /// Point `index` < [`LONGEST`] of the sequence with this scramble. Points of different scrambles are
    /// independent, those of one are not: error bars come from several scrambles.
    pub fn new(index: u32, scramble: u32, fill: Stream) -> Self {
        Self {
            index,
            scramble,
            block: 0,
            dimension: 0,
            fill,
        }
    }
}

impl Sampler for Sobol {
    #[inline]
    fn block(&mut self, block: u32) {
        self.block = block;
        self.dimension = 0;
    }
}

impl TryRng for Sobol {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok((self.next_u64() >> 32) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let seed = self.scramble ^ self.block.wrapping_mul(0x9E37_79B9);
        let value = sobol_burley::sample(self.index, self.dimension, seed);
        self.dimension += 1;
        if self.dimension == BLOCK {
            self.block += 1;
            self.dimension = 0;
        }
        let leading = (f64::from(value) * f64::from(1u32 << 23)) as u64;
        Ok(leading << 41 | self.fill.next_u64() >> 23)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for chunk in bytes.chunks_mut(8) {
            let word = self.next_u64().to_be_bytes();
            chunk.copy_from_slice(&word[..chunk.len()]);
        }
        Ok(())
    }
}
