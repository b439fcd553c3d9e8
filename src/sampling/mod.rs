//! Random numbers, low-discrepancy points, and the distributions drawn with them.

pub(crate) mod lanes;
pub mod pixel;
pub mod rng;
pub mod roulette;
pub mod sampler;
pub mod warp;

use pixel::PixelSampling;
use sampler::{Numbers, Pass, Source};

/// What, besides scene and estimator, decides every sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Where in a pixel the rays go.
    pub pixel: PixelSampling,
    /// Where the random numbers come from.
    pub numbers: Numbers,
    /// The master seed.
    pub seed: u64,
    /// Whether more points tell what emitters show directly or in mirrors where their outlines
    /// cross a pixel, as [`outline`](crate::render::silhouette) says; for samples anywhere in a pixel.
    pub outlines: bool,
}

impl Sampling {
    /// How many samples one replication has: the smallest number that is independent of the next.
    pub fn samples_per_replication(&self) -> u32 {
        self.pixel
            .samples_per_replication()
            .saturating_mul(self.numbers.samples())
    }

    /// The same with another number of samples in a replication; of independent numbers it is
    /// always one.
    pub(crate) fn with_samples(self, samples: u32) -> Self {
        match self.numbers {
            Numbers::Independent => self,
            Numbers::Sobol(_) => Self {
                numbers: Numbers::Sobol(samples / self.pixel.samples_per_replication()),
                ..self
            },
        }
    }

    /// What sample `index` of a replication of a pixel draws from.
    #[inline]
    pub(crate) fn source(&self, pixel: u32, replication: u32, index: u32) -> Source {
        let samples = self.samples_per_replication();
        let numbers = match self.numbers {
            Numbers::Independent => Numbers::Independent,
            // One sequence for all positions of the pixel.
            Numbers::Sobol(_) => Numbers::Sobol(samples),
        };
        Pass {
            numbers,
            seed: self.seed,
            index: replication * samples + index,
        }
        .pixel(pixel)
    }
}
