//! Random numbers of several samples at once: for each lane those that the sample alone would draw.

use std::array::from_fn;

use wide::u64x8;

use crate::real::{LANES, LaneMask, Lanes};
use crate::render::Sampling;
use crate::rng::{stream_state, uniform};
use crate::sampler::{BLOCK, Point, Sampler, scramble, scrambled};

/// One sample: its pixel in the frame, its replication, and its place among the samples of that.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SampleName {
    pub pixel: u32,
    pub replication: u32,
    pub index: u32,
}

/// Where the lanes take their numbers from.
pub(super) trait LaneSampler {
    /// A uniform number for each lane of the mask; the others draw none, and theirs means nothing.
    fn uniform(&mut self, drawing: LaneMask) -> Lanes;
    /// Says that the next numbers of a lane belong to this block.
    fn block(&mut self, lane: usize, block: u32);
}

/// The numbers of samples of pixels.
pub(super) trait PixelSampler: LaneSampler {
    /// Lanes without samples.
    fn new() -> Self;
    /// Starts a sample in a lane.
    fn start(&mut self, lane: usize, sampling: &Sampling, sample: SampleName);
}

/// Xoshiro256++, the generator of [`crate::rng::Stream`], one for each lane.
pub(super) struct Streams([u64x8; 4]);

impl Streams {
    /// Random bits for each lane of the mask; the streams of the others stay where they are.
    #[inline]
    fn words(&mut self, drawing: LaneMask) -> [u64; LANES] {
        let mask = u64x8::new(drawing.words());
        let rotated = |x: u64x8, by: u32| x << by | x >> (u64::BITS - by);
        let [a, b, c, d] = self.0;
        let words = rotated(a + d, 23) + a;
        let [c1, d1] = [c ^ a, d ^ b];
        let next = [a ^ d1, b ^ c1, c1 ^ (b << 17), rotated(d1, 45)];
        self.0 = from_fn(|k| self.0[k] ^ ((self.0[k] ^ next[k]) & mask));
        words.to_array()
    }
}

/// The number in [0, 1) that a generator makes of 64 bits.
#[inline]
fn to_unit(word: u64) -> f64 {
    (word >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

impl PixelSampler for Streams {
    fn new() -> Self {
        Self([u64x8::splat(1); 4])
    }

    #[inline]
    fn start(&mut self, lane: usize, sampling: &Sampling, sample: SampleName) {
        let number = sample.replication * sampling.samples_per_replication() + sample.index;
        for (words, word) in self.0.iter_mut().zip(stream_state(sampling.seed, sample.pixel, number)) {
            words.as_mut_array()[lane] = word;
        }
    }
}

impl LaneSampler for Streams {
    #[inline]
    fn uniform(&mut self, drawing: LaneMask) -> Lanes {
        Lanes::new(self.words(drawing).map(to_unit))
    }

    #[inline]
    fn block(&mut self, _lane: usize, _block: u32) {}
}

/// The points of [`crate::sampler::Sobol`], one for each lane.
pub(super) struct Points {
    points: [Point; LANES],
    dimensions: [u32; LANES],
    fill: Streams,
}

impl PixelSampler for Points {
    fn new() -> Self {
        Self { points: [Point::new(0, 0); LANES], dimensions: [0; LANES], fill: Streams::new() }
    }

    #[inline]
    fn start(&mut self, lane: usize, sampling: &Sampling, sample: SampleName) {
        self.points[lane] = Point::new(sample.index as u16, scramble(sampling.seed, sample.pixel, sample.replication));
        self.dimensions[lane] = 0;
        self.fill.start(lane, sampling, sample);
    }
}

impl LaneSampler for Points {
    #[inline]
    fn uniform(&mut self, drawing: LaneMask) -> Lanes {
        let fill = self.fill.words(drawing);
        // Gathered first: the rest is the same for all lanes at once.
        let gathered = from_fn::<_, LANES, _>(|i| self.points[i].unscrambled(self.dimensions[i]));
        let mut numbers = [0.0; LANES];
        for i in 0..LANES {
            numbers[i] = to_unit(scrambled(gathered[i], fill[i]));
        }
        for (dimension, mask) in self.dimensions.iter_mut().zip(drawing.words()) {
            *dimension += (mask & 1) as u32;
        }
        if self.dimensions.contains(&BLOCK) {
            for (dimension, point) in self.dimensions.iter_mut().zip(&mut self.points).filter(|(d, _)| **d == BLOCK) {
                point.go_on();
                *dimension = 0;
            }
        }
        Lanes::new(numbers)
    }

    #[inline]
    fn block(&mut self, lane: usize, block: u32) {
        self.points[lane].start(block);
        self.dimensions[lane] = 0;
    }
}

/// Random numbers that each lane draws for itself.
pub(super) struct Sources<R>(pub [Option<R>; LANES]);

impl<R: Sampler> LaneSampler for Sources<R> {
    #[inline]
    fn uniform(&mut self, drawing: LaneMask) -> Lanes {
        let bits = drawing.bits();
        let mut numbers = [0.0; LANES];
        for (lane, (number, source)) in numbers.iter_mut().zip(&mut self.0).enumerate() {
            if bits >> lane & 1 == 1 {
                *number = source.as_mut().map_or(0.0, uniform);
            }
        }
        Lanes::new(numbers)
    }

    #[inline]
    fn block(&mut self, lane: usize, block: u32) {
        if let Some(source) = &mut self.0[lane] {
            source.block(block);
        }
    }
}
