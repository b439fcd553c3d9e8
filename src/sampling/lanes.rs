//! Random numbers in lanes: each lane draws the same numbers as its sample would draw alone.

use std::array::from_fn;

use rand::Rng;
use wide::{u32x8, u64x8};

use super::Sampling;
use super::rng::{CounterHash, stream_hashes};
use super::sampler::{
    BLOCK, SEQUENCE, Sampler, block_key, next_block, scramble, scrambled, shuffled_index,
    unscrambled,
};
use crate::math::real::{Mask, Real};
use crate::math::simd::{SINGLES, Scalar, Wide, lanes_of, map_array};

/// A sample: its pixel in the frame, its replication, and its index within the replication.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SampleId {
    pub pixel: u32,
    pub replication: u32,
    pub index: u32,
}

/// Source of random numbers for all lanes.
pub(crate) trait LaneSampler<R: Real> {
    /// Draws a uniform number in [0, 1) in each lane of the mask; other lanes draw none and hold
    /// arbitrary values.
    fn uniform(&mut self, drawing: R::Mask) -> R;
    /// Draws the random bits of the next number of a lane.
    fn next_bits(&mut self, lane: usize) -> u64;
    /// Starts these blocks of random numbers in the lanes of the mask.
    fn start_blocks(&mut self, starting: R::Mask, blocks: &[u32]);
    /// Skips a number, which nothing depends on, in each lane of the mask.
    #[inline]
    fn skip(&mut self, drawing: R::Mask) {
        self.uniform(drawing);
    }
}

/// A [`LaneSampler`] for the samples of pixels.
pub(crate) trait PixelSampler<R: Real>: LaneSampler<R> {
    /// Creates a sampler with this seed; no lane has a sample yet.
    fn new(seed: u64) -> Self;
    /// Starts a sample in a lane; its first block must be started next.
    fn start(&mut self, lane: usize, sampling: &Sampling, sample: SampleId);
}

/// A Xoshiro256++ generator per lane, as [`crate::sampling::rng::Stream`].
pub(crate) struct LaneStreams<const N: usize> {
    groups: [[u64x8; 4]; SINGLES / GROUP_SIZE],
    hashes: [CounterHash; 4],
}

/// Lanes per group of streams; there are enough groups for the highest lane count.
const GROUP_SIZE: usize = 8;

impl<const N: usize> LaneStreams<N> {
    /// Draws 64 random bits in each lane of the mask; the other streams do not advance.
    #[inline]
    fn draw_bits(&mut self, drawing: u32) -> [u64; N] {
        let rotated = |x: u64x8, by: u32| x << by | x >> (u64::BITS - by);
        let mut all = [0; N];
        for group in 0..N / GROUP_SIZE {
            let mask = long_group_mask(drawing >> (GROUP_SIZE * group));
            let state = &mut self.groups[group];
            let [a, b, c, d] = *state;
            let bits = rotated(a + d, 23) + a;
            all[GROUP_SIZE * group..][..GROUP_SIZE].copy_from_slice(bits.as_array());
            let [c1, d1] = [c ^ a, d ^ b];
            let next = [a ^ d1, b ^ c1, c1 ^ (b << 17), rotated(d1, 45)];
            *state = from_fn(|k| mask.select(next[k], state[k]));
        }
        all
    }
}

impl<R: Wide<N>, const N: usize> PixelSampler<R> for LaneStreams<N> {
    fn new(seed: u64) -> Self {
        Self {
            groups: [[u64x8::splat(1); 4]; SINGLES / GROUP_SIZE],
            hashes: stream_hashes(seed),
        }
    }

    #[inline]
    fn start(&mut self, lane: usize, sampling: &Sampling, sample: SampleId) {
        let number = sample.replication * sampling.samples_per_replication() + sample.index;
        for (bits, hash) in self.groups[lane / GROUP_SIZE].iter_mut().zip(self.hashes) {
            bits.as_mut_array()[lane % GROUP_SIZE] = hash.number(sample.pixel, number);
        }
    }
}

impl<R: Wide<N>, const N: usize> LaneSampler<R> for LaneStreams<N> {
    #[inline]
    fn uniform(&mut self, drawing: R::Mask) -> R {
        R::from_array(map_array(self.draw_bits(drawing.bits()), R::Scalar::unit))
    }
    #[inline]
    fn next_bits(&mut self, lane: usize) -> u64 {
        self.draw_bits(1 << lane)[lane]
    }
    #[inline]
    fn start_blocks(&mut self, _: R::Mask, _: &[u32]) {}
}

/// Points of [`crate::sampling::sampler::Sobol`], one sequence per lane.
///
/// In single precision a number has only the bits of the sequence and one more, which puts it in
/// the middle of its interval.
pub(crate) struct LaneSobol<const N: usize> {
    groups: [SobolGroup; SINGLES / GROUP_SIZE],
    low_bits: LaneStreams<N>,
}

/// Sobol' points of eight lanes.
#[derive(Clone, Copy)]
struct SobolGroup {
    indices: [u16; GROUP_SIZE],
    hashes: [CounterHash; GROUP_SIZE],
    blocks: u32x8,
    /// Scrambling keys of the blocks.
    keys: u64x8,
    /// Coordinates by dimension, before scrambling.
    numbers: [u32x8; BLOCK as usize],
    /// Dimensions that are drawn next.
    dimensions: u32x8,
}

impl SobolGroup {
    fn new() -> Self {
        Self {
            indices: [0; GROUP_SIZE],
            hashes: [CounterHash::new(0); GROUP_SIZE],
            blocks: u32x8::ZERO,
            keys: u64x8::ZERO,
            numbers: [u32x8::ZERO; BLOCK as usize],
            dimensions: u32x8::ZERO,
        }
    }

    /// Starts blocks in the lanes whose bits are set.
    #[inline]
    fn start(&mut self, starting: u32, blocks: [u32; GROUP_SIZE]) {
        let keys: [u64; GROUP_SIZE] = from_fn(|i| block_key(self.hashes[i], blocks[i]));
        let indices: [u32; GROUP_SIZE] = from_fn(|i| shuffled_index(self.indices[i], keys[i]));
        let sequence = &*SEQUENCE;
        let rows = u32x8::transpose(indices.map(|place| unscrambled(sequence, place)));
        let mask = group_mask(starting);
        for (numbers, row) in self.numbers.iter_mut().zip(rows) {
            *numbers = mask.select(row, *numbers);
        }
        self.dimensions = mask.select(u32x8::ZERO, self.dimensions);
        self.blocks = mask.select(u32x8::new(blocks), self.blocks);
        self.keys = long_group_mask(starting).select(u64x8::new(keys), self.keys);
    }

    /// Returns each drawing lane's next number, before scrambling, and its scrambling key.
    #[inline]
    fn next(&self, drawing: u32) -> [(u32, u64); GROUP_SIZE] {
        let dimensions = self.dimensions.to_array();
        let (mut numbers, mut left) = (u32x8::ZERO, drawing);
        while left != 0 {
            // Most lanes draw the same dimension.
            let dimension = dimensions[left.trailing_zeros() as usize % GROUP_SIZE];
            let here = self.dimensions.simd_eq(u32x8::splat(dimension));
            numbers = here.select(self.numbers[(dimension % BLOCK) as usize], numbers);
            left &= !here.to_bitmask();
        }
        let (numbers, keys) = (numbers.to_array(), self.keys.to_array());
        from_fn(|i| (numbers[i], keys[i] ^ u64::from(dimensions[i])))
    }

    /// Advances to the next dimension in the lanes whose bits are set.
    #[inline]
    fn advance(&mut self, drawing: u32) {
        self.dimensions -= group_mask(drawing);
        let used = self.dimensions.simd_eq(u32x8::splat(BLOCK)).to_bitmask();
        if used != 0 {
            self.start(used, self.blocks.to_array().map(next_block));
        }
    }
}

/// Expands the eight lowest bits to lane masks of 32 bits.
#[inline]
fn group_mask(bits: u32) -> u32x8 {
    let each = u32x8::new([1, 2, 4, 8, 16, 32, 64, 128]);
    (u32x8::splat(bits) & each).simd_eq(each)
}

/// Expands the eight lowest bits to lane masks of 64 bits.
#[inline]
fn long_group_mask(bits: u32) -> u64x8 {
    let each = u64x8::new([1, 2, 4, 8, 16, 32, 64, 128]);
    (u64x8::splat(u64::from(bits)) & each).simd_eq(each)
}

impl<R: Wide<N>, const N: usize> PixelSampler<R> for LaneSobol<N> {
    fn new(seed: u64) -> Self {
        let low_bits = PixelSampler::<R>::new(seed);
        Self {
            groups: [SobolGroup::new(); SINGLES / GROUP_SIZE],
            low_bits,
        }
    }

    #[inline]
    fn start(&mut self, lane: usize, sampling: &Sampling, sample: SampleId) {
        let scramble = scramble(sampling.seed, sample.pixel, sample.replication);
        let group = &mut self.groups[lane / GROUP_SIZE];
        (
            group.indices[lane % GROUP_SIZE],
            group.hashes[lane % GROUP_SIZE],
        ) = (sample.index as u16, CounterHash::new(scramble));
        if !R::IS_SINGLE {
            PixelSampler::<R>::start(&mut self.low_bits, lane, sampling, sample);
        }
    }
}

impl<const N: usize> LaneSobol<N> {
    /// Draws 64 random bits in each lane of the mask.
    #[inline]
    fn draw_bits(&mut self, drawing: u32, is_single: bool) -> [u64; N] {
        let low_bits = if is_single {
            [INTERVAL_MIDPOINT; N]
        } else {
            self.low_bits.draw_bits(drawing)
        };
        let mut bits = [0; N];
        for group in 0..N / GROUP_SIZE {
            let (first, points) = (group * GROUP_SIZE, &mut self.groups[group]);
            let own = drawing >> first & 0xFF;
            let next = points.next(own);
            let scrambled: [u64; GROUP_SIZE] =
                from_fn(|i| scrambled(next[i].0, next[i].1, low_bits[first + i]));
            bits[first..][..GROUP_SIZE].copy_from_slice(&scrambled);
            points.advance(own);
        }
        bits
    }
}

impl<R: Wide<N>, const N: usize> LaneSampler<R> for LaneSobol<N> {
    #[inline]
    fn uniform(&mut self, drawing: R::Mask) -> R {
        R::from_array(map_array(
            self.draw_bits(drawing.bits(), R::IS_SINGLE),
            R::Scalar::unit,
        ))
    }
    #[inline]
    fn next_bits(&mut self, lane: usize) -> u64 {
        self.draw_bits(1 << lane, R::IS_SINGLE)[lane]
    }
    #[inline]
    fn start_blocks(&mut self, starting: R::Mask, blocks: &[u32]) {
        let starting = starting.bits();
        for group in 0..N / GROUP_SIZE {
            let own = starting >> (group * GROUP_SIZE) & 0xFF;
            if own != 0 {
                self.groups[group].start(own, from_fn(|i| blocks[group * GROUP_SIZE + i]));
            }
        }
    }
    #[inline]
    fn skip(&mut self, drawing: R::Mask) {
        let drawing = drawing.bits();
        if !R::IS_SINGLE {
            self.low_bits.draw_bits(drawing);
        }
        for group in 0..N / GROUP_SIZE {
            self.groups[group].advance(drawing >> (group * GROUP_SIZE) & 0xFF);
        }
    }
}

/// Low bits of a number in single precision: the middle of its interval.
const INTERVAL_MIDPOINT: u64 = 1 << 63;

/// A separate sampler for each lane.
pub(crate) struct Sources<S, const N: usize>(pub [Option<S>; N]);

impl<S: Sampler, R: Wide<N>, const N: usize> LaneSampler<R> for Sources<S, N> {
    #[inline]
    fn uniform(&mut self, drawing: R::Mask) -> R {
        let mut bits = [0; N];
        for lane in lanes_of(drawing.bits()) {
            bits[lane] = self.next(lane);
        }
        R::from_array(map_array(bits, R::Scalar::unit))
    }
    #[inline]
    fn next_bits(&mut self, lane: usize) -> u64 {
        self.next(lane)
    }
    #[inline]
    fn start_blocks(&mut self, starting: R::Mask, blocks: &[u32]) {
        for lane in lanes_of(starting.bits()) {
            if let Some(source) = &mut self.0[lane] {
                source.block(blocks[lane]);
            }
        }
    }
}

impl<S: Sampler, const N: usize> Sources<S, N> {
    /// Draws the next random bits of a lane; 0 without a sampler.
    #[inline]
    fn next(&mut self, lane: usize) -> u64 {
        self.0[lane].as_mut().map_or(0, Rng::next_u64)
    }
}
