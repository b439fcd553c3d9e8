//! Random numbers of several samples at once: for each lane those that the sample alone would draw.

use std::array::from_fn;

use rand::Rng;
use wide::{u32x8, u64x8};

use super::Sampling;
use super::rng::{CounterHash, stream_hashes};
use super::sampler::{
    BLOCK, SEQUENCE, Sampler, block_key, next_block, place, scramble, scrambled, unscrambled,
};
use crate::math::real::{Mask, Real};
use crate::math::simd::{SINGLES, Scalar, Wide, lanes_of};

/// One sample: its pixel in the frame, its replication, and its place among the samples of that.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SampleName {
    pub pixel: u32,
    pub replication: u32,
    pub index: u32,
}

/// Where the lanes take their numbers from.
pub(crate) trait LaneSampler<R: Real> {
    /// A uniform number for each lane of the mask; the others draw none, and theirs means nothing.
    fn uniform(&mut self, drawing: R::Mask) -> R;
    /// The random bits of which the next number of a lane is made.
    fn word(&mut self, lane: usize) -> u64;
    /// Says to which blocks the next numbers of these lanes belong.
    fn start_blocks(&mut self, starting: R::Mask, blocks: &[u32]);
    /// Leaves out a number of each lane of the mask, that nothing depends on.
    #[inline]
    fn skip(&mut self, drawing: R::Mask) {
        self.uniform(drawing);
    }
}

/// The numbers of samples of pixels.
pub(crate) trait PixelSampler<R: Real>: LaneSampler<R> {
    /// Lanes without samples, which draw by this seed.
    fn new(seed: u64) -> Self;
    /// Starts a sample in a lane, whose first block must be started next.
    fn start(&mut self, lane: usize, sampling: &Sampling, sample: SampleName);
}

/// Xoshiro256++, the generator of [`crate::sampling::rng::Stream`], one for each lane.
pub(crate) struct Streams<const N: usize> {
    groups: [[u64x8; 4]; SINGLES / EIGHT],
    hashes: [CounterHash; 4],
}

/// Lanes of a group of streams; there are as many groups as the most lanes need.
const EIGHT: usize = 8;

impl<const N: usize> Streams<N> {
    /// Random bits for each lane of the mask; the streams of the others stay where they are.
    #[inline]
    fn words(&mut self, drawing: u32) -> [u64; N] {
        let rotated = |x: u64x8, by: u32| x << by | x >> (u64::BITS - by);
        let mut all = [0; N];
        for group in 0..N / EIGHT {
            let mask = eight_long_bits(drawing >> (EIGHT * group));
            let state = &mut self.groups[group];
            let [a, b, c, d] = *state;
            let words = rotated(a + d, 23) + a;
            all[EIGHT * group..][..EIGHT].copy_from_slice(words.as_array());
            let [c1, d1] = [c ^ a, d ^ b];
            let next = [a ^ d1, b ^ c1, c1 ^ (b << 17), rotated(d1, 45)];
            *state = from_fn(|k| mask.select(next[k], state[k]));
        }
        all
    }
}

impl<R: Wide<N>, const N: usize> PixelSampler<R> for Streams<N> {
    fn new(seed: u64) -> Self {
        Self {
            groups: [[u64x8::splat(1); 4]; SINGLES / EIGHT],
            hashes: stream_hashes(seed),
        }
    }

    #[inline]
    fn start(&mut self, lane: usize, sampling: &Sampling, sample: SampleName) {
        let number = sample.replication * sampling.samples_per_replication() + sample.index;
        for (words, hash) in self.groups[lane / EIGHT].iter_mut().zip(self.hashes) {
            words.as_mut_array()[lane % EIGHT] = hash.number(sample.pixel, number);
        }
    }
}

impl<R: Wide<N>, const N: usize> LaneSampler<R> for Streams<N> {
    #[inline]
    fn uniform(&mut self, drawing: R::Mask) -> R {
        R::of_lanes(self.words(drawing.bits()).map(R::Scalar::unit))
    }
    #[inline]
    fn word(&mut self, lane: usize) -> u64 {
        self.words(1 << lane)[lane]
    }
    #[inline]
    fn start_blocks(&mut self, _: R::Mask, _: &[u32]) {}
}

/// The points of [`crate::sampling::sampler::Sobol`], one for each lane.
///
/// In single precision a number has no more bits than those of the sequence and one that says the
/// middle between this and the next.
pub(crate) struct Points<const N: usize> {
    groups: [EightPoints; SINGLES / EIGHT],
    fill: Streams<N>,
}

/// The points of some lanes.
#[derive(Clone, Copy)]
struct EightPoints {
    indices: [u16; EIGHT],
    hashes: [CounterHash; EIGHT],
    blocks: u32x8,
    /// What scrambles the block.
    keys: u64x8,
    /// By dimension, before they are scrambled.
    numbers: [u32x8; BLOCK as usize],
    /// What is drawn next.
    dimensions: u32x8,
}

impl EightPoints {
    fn new() -> Self {
        Self {
            indices: [0; EIGHT],
            hashes: [CounterHash::new(0); EIGHT],
            blocks: u32x8::ZERO,
            keys: u64x8::ZERO,
            numbers: [u32x8::ZERO; BLOCK as usize],
            dimensions: u32x8::ZERO,
        }
    }

    /// Starts blocks in the lanes whose bits are set.
    #[inline]
    fn start(&mut self, starting: u32, blocks: [u32; EIGHT]) {
        let keys: [u64; EIGHT] = from_fn(|i| block_key(self.hashes[i], blocks[i]));
        let places: [u32; EIGHT] = from_fn(|i| place(self.indices[i], keys[i]));
        let sequence = &*SEQUENCE;
        let rows = u32x8::transpose(places.map(|place| unscrambled(sequence, place)));
        let mask = eight_bits(starting);
        for (numbers, row) in self.numbers.iter_mut().zip(rows) {
            *numbers = mask.select(row, *numbers);
        }
        self.dimensions = mask.select(u32x8::ZERO, self.dimensions);
        self.blocks = mask.select(u32x8::new(blocks), self.blocks);
        self.keys = eight_long_bits(starting).select(u64x8::new(keys), self.keys);
    }

    /// The next number of each lane that draws, before it is scrambled, and what scrambles it.
    #[inline]
    fn next(&self, drawing: u32) -> [(u32, u64); EIGHT] {
        let dimensions = self.dimensions.to_array();
        let (mut numbers, mut left) = (u32x8::ZERO, drawing);
        while left != 0 {
            // Most lanes draw the same dimension.
            let dimension = dimensions[left.trailing_zeros() as usize % EIGHT];
            let here = self.dimensions.simd_eq(u32x8::splat(dimension));
            numbers = here.select(self.numbers[(dimension % BLOCK) as usize], numbers);
            left &= !here.to_bitmask();
        }
        let (numbers, keys) = (numbers.to_array(), self.keys.to_array());
        from_fn(|i| (numbers[i], keys[i] ^ u64::from(dimensions[i])))
    }

    /// Goes on to the next dimension in the lanes whose bits are set.
    #[inline]
    fn go_on(&mut self, drawing: u32) {
        self.dimensions -= eight_bits(drawing);
        let used = self.dimensions.simd_eq(u32x8::splat(BLOCK)).to_bitmask();
        if used != 0 {
            self.start(used, self.blocks.to_array().map(next_block));
        }
    }
}

/// All bits set where one of the lowest is, none elsewhere.
#[inline]
fn eight_bits(bits: u32) -> u32x8 {
    let each = u32x8::new([1, 2, 4, 8, 16, 32, 64, 128]);
    (u32x8::splat(bits) & each).simd_eq(each)
}

/// The same of 64 bits.
#[inline]
fn eight_long_bits(bits: u32) -> u64x8 {
    let each = u64x8::new([1, 2, 4, 8, 16, 32, 64, 128]);
    (u64x8::splat(u64::from(bits)) & each).simd_eq(each)
}

impl<R: Wide<N>, const N: usize> PixelSampler<R> for Points<N> {
    fn new(seed: u64) -> Self {
        let fill = PixelSampler::<R>::new(seed);
        Self {
            groups: [EightPoints::new(); SINGLES / EIGHT],
            fill,
        }
    }

    #[inline]
    fn start(&mut self, lane: usize, sampling: &Sampling, sample: SampleName) {
        let scramble = scramble(sampling.seed, sample.pixel, sample.replication);
        let group = &mut self.groups[lane / EIGHT];
        (group.indices[lane % EIGHT], group.hashes[lane % EIGHT]) =
            (sample.index as u16, CounterHash::new(scramble));
        if !R::IS_SINGLE {
            PixelSampler::<R>::start(&mut self.fill, lane, sampling, sample);
        }
    }
}

impl<const N: usize> Points<N> {
    /// Random bits for each lane of the mask.
    #[inline]
    fn words(&mut self, drawing: u32, is_single: bool) -> [u64; N] {
        let fill = if is_single {
            [MIDDLE; N]
        } else {
            self.fill.words(drawing)
        };
        let mut words = [0; N];
        for group in 0..N / EIGHT {
            let (first, points) = (group * EIGHT, &mut self.groups[group]);
            let own = drawing >> first & 0xFF;
            let next = points.next(own);
            let scrambled: [u64; EIGHT] = from_fn(|i| scrambled(next[i], fill[first + i]));
            words[first..][..EIGHT].copy_from_slice(&scrambled);
            points.go_on(own);
        }
        words
    }
}

impl<R: Wide<N>, const N: usize> LaneSampler<R> for Points<N> {
    #[inline]
    fn uniform(&mut self, drawing: R::Mask) -> R {
        R::of_lanes(
            self.words(drawing.bits(), R::IS_SINGLE)
                .map(R::Scalar::unit),
        )
    }
    #[inline]
    fn word(&mut self, lane: usize) -> u64 {
        self.words(1 << lane, R::IS_SINGLE)[lane]
    }
    #[inline]
    fn start_blocks(&mut self, starting: R::Mask, blocks: &[u32]) {
        let starting = starting.bits();
        for group in 0..N / EIGHT {
            let own = starting >> (group * EIGHT) & 0xFF;
            if own != 0 {
                self.groups[group].start(own, from_fn(|i| blocks[group * EIGHT + i]));
            }
        }
    }
    #[inline]
    fn skip(&mut self, drawing: R::Mask) {
        let drawing = drawing.bits();
        if !R::IS_SINGLE {
            self.fill.words(drawing);
        }
        for group in 0..N / EIGHT {
            self.groups[group].go_on(drawing >> (group * EIGHT) & 0xFF);
        }
    }
}

/// In place of bits that fill up a number: half of what they can add.
const MIDDLE: u64 = 1 << 63;

/// A source of random numbers of its own for each lane.
pub(crate) struct Sources<S, const N: usize>(pub [Option<S>; N]);

impl<S: Sampler, R: Wide<N>, const N: usize> LaneSampler<R> for Sources<S, N> {
    #[inline]
    fn uniform(&mut self, drawing: R::Mask) -> R {
        let mut words = [0; N];
        for lane in lanes_of(drawing.bits()) {
            words[lane] = self.next(lane);
        }
        R::of_lanes(words.map(R::Scalar::unit))
    }
    #[inline]
    fn word(&mut self, lane: usize) -> u64 {
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
    /// The next random bits of a lane; 0 without a source.
    #[inline]
    fn next(&mut self, lane: usize) -> u64 {
        self.0[lane].as_mut().map_or(0, Rng::next_u64)
    }
}
