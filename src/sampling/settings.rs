//! Settings of a render that decide every sample.

use super::pixel::PixelSampling;
use super::sampler::{ImagePass, SampleStream, SamplerKind};

/// Sampling settings: with scene and estimator, they decide every sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Sampling of the pixel.
    pub pixel: PixelSampling,
    /// Source of the random numbers.
    pub sampler: SamplerKind,
    /// Master seed.
    pub seed: u64,
    /// Whether emitter silhouettes, seen directly or in mirrors, are supersampled as in
    /// [`silhouette`](crate::render::silhouette); only where samples lie anywhere in a pixel.
    pub silhouettes: bool,
}

impl Sampling {
    /// Returns the number of samples of one replication: the smallest number that is independent of
    /// the next.
    pub fn samples_per_replication(&self) -> u32 {
        self.pixel
            .samples_per_replication()
            .saturating_mul(self.sampler.samples())
    }

    /// Returns the settings with another number of samples in a replication; for independent
    /// numbers it is always one.
    pub(crate) fn with_samples(self, samples: u32) -> Self {
        match self.sampler {
            SamplerKind::Independent => self,
            SamplerKind::Sobol(_) => Self {
                sampler: SamplerKind::Sobol(samples / self.pixel.samples_per_replication()),
                ..self
            },
        }
    }

    /// Returns the random numbers of sample `index` of a replication of a pixel.
    #[inline]
    pub(crate) fn source(&self, pixel: u32, replication: u32, index: u32) -> SampleStream {
        let samples = self.samples_per_replication();
        let sampler = match self.sampler {
            SamplerKind::Independent => SamplerKind::Independent,
            // One sequence for all positions of the pixel.
            SamplerKind::Sobol(_) => SamplerKind::Sobol(samples),
        };
        ImagePass {
            sampler,
            seed: self.seed,
            index: replication * samples + index,
        }
        .pixel_stream(pixel)
    }
}
