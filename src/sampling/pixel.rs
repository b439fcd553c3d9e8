//! Sampling of the pixel, section 2.7: [`crate::equation::SUPERSAMPLING`] and
//! [`crate::equation::RANDOMISATION`]. The filter is a box of one pixel.

/// A sampling strategy of section 2.7. A replication is the smallest set of samples that is
/// independent of the next one: one sample, or one whole grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelSampling {
    /// Every ray through the centre.
    Centre,
    /// The centres of n × n sub-pixels.
    Grid(u32),
    /// One uniform random point per ray.
    Random,
    /// One uniform random point in each of n × n sub-pixels.
    Jitter(u32),
}

impl PixelSampling {
    /// Returns the number of samples of one replication.
    pub fn samples_per_replication(self) -> u32 {
        match self {
            Self::Centre | Self::Random => 1,
            Self::Grid(n) | Self::Jitter(n) => n.saturating_mul(n),
        }
    }

    /// Returns the position in [0, 1]² of sample `index` of a replication; `random` are two uniform
    /// numbers in [0, 1), used by the random strategies only.
    #[inline]
    pub fn position(self, index: u32, random: [f64; 2]) -> [f64; 2] {
        let cell = |n: u32, offset: [f64; 2]| {
            let inverse = 1.0 / f64::from(n);
            [
                (f64::from(index % n) + offset[0]) * inverse,
                (f64::from(index / n) + offset[1]) * inverse,
            ]
        };
        match self {
            Self::Centre => [0.5, 0.5],
            Self::Grid(n) => cell(n, [0.5, 0.5]),
            Self::Random => random,
            Self::Jitter(n) => cell(n, random),
        }
    }
}
