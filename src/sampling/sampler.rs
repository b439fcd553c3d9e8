//! Sources of an estimator's random numbers: independent streams, or Owen-scrambled Sobol' points.

use std::array::from_fn;
use std::convert::Infallible;
use std::sync::LazyLock;

use rand::{Rng, TryRng};
use sobol_burley::parts::{owen_scramble_rev, sobol_rev};
use wide::u32x8;

use super::rng::{CounterHash, Stream, mix, scramble_for, seed_for, stream};

/// A source of uniform numbers that knows which part of a path draws them.
///
/// The dimensions of one sample are divided into blocks of [`BLOCK`]: block 0 is the camera's,
/// block k ≥ 1 that of the eye path's k-th vertex, block [`FIRST_LIGHT_BLOCK`] + k that of the
/// light path's k-th vertex (k = 0 is the emitter). Within a block the order of use is the order of
/// dimensions: emitter, point on it, direction, roulette. So a dimension has the same meaning in
/// every estimator of paths.
pub trait Sampler: Rng {
    /// Selects the block of the next numbers. Independent streams ignore it.
    #[inline]
    fn block(&mut self, _block: u32) {}
}

impl<S: Sampler + ?Sized> Sampler for &mut S {
    #[inline]
    fn block(&mut self, block: u32) {
        (**self).block(block);
    }
}

/// Kind of an estimator's random numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerKind {
    /// An independent stream for each sample.
    #[default]
    Independent,
    /// Points of [`Sobol`]; a replication is one scramble of this many for each of the pixel's
    /// positions.
    Sobol(u32),
}

impl SamplerKind {
    /// Returns the number of samples of one replication.
    pub fn samples(self) -> u32 {
        match self {
            Self::Independent => 1,
            Self::Sobol(points) => points,
        }
    }
}

/// A pass over a whole image: with scene and image size, it decides all samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImagePass {
    /// Source of its random numbers. With Sobol' points, as many consecutive passes make up a
    /// replication.
    pub sampler: SamplerKind,
    /// Master seed.
    pub seed: u64,
    /// Index of the pass.
    pub index: u32,
}

impl ImagePass {
    /// Returns a pass of independent numbers.
    pub fn independent(seed: u64, index: u32) -> Self {
        Self {
            sampler: SamplerKind::Independent,
            seed,
            index,
        }
    }

    /// Returns the random numbers of the paths of a pixel. The passes of a replication take the
    /// points of one scramble.
    pub fn pixel_stream(self, pixel: u32) -> SampleStream {
        let low_bits = stream(self.seed, pixel, self.index);
        match self.sampler {
            SamplerKind::Independent => SampleStream::Independent(low_bits),
            SamplerKind::Sobol(points) => {
                let [replication, point] = [self.index / points, self.index % points];
                SampleStream::Sobol(Sobol::new(
                    point as u16,
                    scramble(self.seed, pixel, replication),
                    low_bits,
                ))
            }
        }
    }

    /// Returns the random numbers of particle `number` of `count`. All particles of a replication,
    /// pass after pass, take the points of one sequence, which continues in another scramble where
    /// it ends.
    pub fn particle_stream(self, number: u32, count: u32) -> SampleStream {
        let low_bits = stream(self.seed, number, self.index);
        match self.sampler {
            SamplerKind::Independent => SampleStream::Independent(low_bits),
            SamplerKind::Sobol(points) => {
                let [replication, pass] = [self.index / points, self.index % points];
                let point = u64::from(pass) * u64::from(count) + u64::from(number);
                let [part, point] = [point / u64::from(MAX_POINTS), point % u64::from(MAX_POINTS)];
                SampleStream::Sobol(Sobol::new(
                    point as u16,
                    scramble(self.seed, part as u32, replication),
                    low_bits,
                ))
            }
        }
    }

    /// Returns the pass of the same index under the seed of a named part.
    pub fn for_part(self, part: &str) -> Self {
        Self {
            seed: seed_for(self.seed, part),
            ..self
        }
    }
}

/// Random numbers of either kind.
#[derive(Clone, Debug)]
pub enum SampleStream {
    /// Numbers of [`SamplerKind::Independent`].
    Independent(Stream),
    /// Numbers of [`SamplerKind::Sobol`].
    Sobol(Sobol),
}

impl From<Stream> for SampleStream {
    fn from(stream: Stream) -> Self {
        Self::Independent(stream)
    }
}

impl From<Sobol> for SampleStream {
    fn from(point: Sobol) -> Self {
        Self::Sobol(point)
    }
}

impl Sampler for SampleStream {
    #[inline]
    fn block(&mut self, block: u32) {
        if let Self::Sobol(point) = self {
            point.block(block);
        }
    }
}

impl TryRng for SampleStream {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        match self {
            Self::Independent(stream) => stream.try_next_u32(),
            Self::Sobol(point) => point.try_next_u32(),
        }
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        match self {
            Self::Independent(stream) => stream.try_next_u64(),
            Self::Sobol(point) => point.try_next_u64(),
        }
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        match self {
            Self::Independent(stream) => stream.try_fill_bytes(bytes),
            Self::Sobol(point) => point.try_fill_bytes(bytes),
        }
    }
}

/// Number of dimensions per block.
pub const BLOCK: u32 = 8;
/// First block of the light path.
pub const FIRST_LIGHT_BLOCK: u32 = 1 << 16;
/// Distance to the block in which a used-up block continues; nothing else asks for that block.
const OVERFLOW_STRIDE: u32 = 1 << 20;

impl Sampler for Stream {}

/// One point of a Sobol' sequence (Joe and Kuo 2008) with Owen scrambling by hash (Laine and Karras
/// 2011, Burley 2020), [`crate::equation::SOBOL`].
///
/// Each block takes the first [`BLOCK`] dimensions of a sequence with its own scramble and shuffle,
/// so that there are as many as a path needs. The hash that scrambles and shuffles has 32 bits, too
/// few for all pixels of a large image: each dimension is also shifted (exclusive or) by bits of
/// its own, which leaves every elementary interval its points. The 23 leading bits of a number are
/// the sequence's, the others those of an independent stream.
#[derive(Clone, Debug)]
pub struct Sobol {
    point: Point,
    dimension: u32,
    low_bits: Stream,
}

/// Numbers of a [`Sobol`] in one block, without the low bits.
#[derive(Clone, Copy, Debug)]
struct Point {
    index: u16,
    /// Hash that gives the keys of blocks.
    hash: CounterHash,
    block: u32,
    /// Key that scrambles and shuffles the block.
    key: u64,
    /// Numbers of the sequence by dimension, before they are scrambled, bits reversed.
    numbers: [u32; BLOCK as usize],
}

/// Largest number of points of one scramble: the number of indices of [`Sobol::new`].
pub const MAX_POINTS: u32 = 1 << 16;
/// Number of leading bits that are the sequence's.
const SOBOL_BITS: u32 = 23;

impl Point {
    #[inline]
    fn new(index: u16, scramble: u64) -> Self {
        let mut point = Self {
            index,
            hash: CounterHash::new(scramble),
            block: 0,
            key: 0,
            numbers: [0; BLOCK as usize],
        };
        point.start(0);
        point
    }

    /// Starts a block.
    #[inline]
    fn start(&mut self, block: u32) {
        let key = block_key(self.hash, block);
        *self = Self {
            block,
            key,
            numbers: unscrambled(&SEQUENCE, shuffled_index(self.index, key)).to_array(),
            ..*self
        };
    }
}

/// Returns the key that scrambles and shuffles a block.
#[inline]
pub(crate) fn block_key(hash: CounterHash, block: u32) -> u64 {
    hash.number(block, 0)
}

/// Returns the shuffled index in a block of this key, bits reversed.
#[inline]
pub(crate) fn shuffled_index(index: u16, key: u64) -> u32 {
    owen_scramble_rev(u32::from(index).reverse_bits(), key as u32)
}

/// Returns the numbers of a block by dimension, before they are scrambled, bits reversed.
#[inline]
pub(crate) fn unscrambled(sequence: &Sequence, shuffled_index: u32) -> u32x8 {
    let numbers = |i: usize| sequence[i][shuffled_index as usize >> (16 + 4 * i) & 15];
    numbers(0) ^ numbers(1) ^ numbers(2) ^ numbers(3)
}

/// Returns the block in which a used-up one continues.
#[inline]
pub(crate) fn next_block(block: u32) -> u32 {
    block.wrapping_add(OVERFLOW_STRIDE)
}

/// Scrambles a number of the sequence by its key, and appends the leading bits of `low_bits`.
#[inline]
pub(crate) fn scrambled(number: u32, key: u64, low_bits: u64) -> u64 {
    let own = mix(key);
    let leading = owen_scramble_rev(number, own as u32).reverse_bits();
    (own ^ u64::from(leading) << 32) & !(u64::MAX >> SOBOL_BITS) | low_bits >> SOBOL_BITS
}

/// Table of points of the sequence.
pub(crate) type Sequence = [[u32x8; 16]; 4];

/// Points of the sequence, bits reversed, at the indices that have bits in one group of four only,
/// by group and bits: the others are sums (exclusive or) of these.
pub(crate) static SEQUENCE: LazyLock<Sequence> = LazyLock::new(|| {
    from_fn(|i| {
        let index = |bits: usize| (bits as u32) << (16 + 4 * i);
        from_fn(|bits| {
            u32x8::new(from_fn(|dimension| {
                sobol_rev(index(bits), dimension as u32)
            }))
        })
    })
});

impl Sobol {
    /// Creates point `index` of the sequence with this scramble. Points of different scrambles are
    /// independent, those of one are not: error bars come from several scrambles.
    pub fn new(index: u16, scramble: u64, low_bits: Stream) -> Self {
        Self {
            point: Point::new(index, scramble),
            dimension: 0,
            low_bits,
        }
    }
}

/// Returns the scramble of a pixel's replication under a master seed: a bijection, so that no two
/// are the same.
#[inline]
pub fn scramble(seed: u64, pixel: u32, replication: u32) -> u64 {
    scramble_for(seed, pixel, replication)
}

impl Sampler for Sobol {
    #[inline]
    fn block(&mut self, block: u32) {
        self.point.start(block);
        self.dimension = 0;
    }
}

impl TryRng for Sobol {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok((self.next_u64() >> 32) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let Point {
            numbers,
            key,
            block,
            ..
        } = self.point;
        let number = numbers[(self.dimension % BLOCK) as usize];
        let number = scrambled(
            number,
            key ^ u64::from(self.dimension),
            self.low_bits.next_u64(),
        );
        self.dimension += 1;
        if self.dimension == BLOCK {
            self.point.start(next_block(block));
            self.dimension = 0;
        }
        Ok(number)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for chunk in bytes.chunks_mut(8) {
            let word = self.next_u64().to_be_bytes();
            chunk.copy_from_slice(&word[..chunk.len()]);
        }
        Ok(())
    }
}
