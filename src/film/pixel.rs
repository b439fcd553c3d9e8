//! The accumulators of a pixel: exact sums of radiance and of the features of first hits.

use glam::DVec3;

use crate::error::{Error, MAX_RADIANCE};
use crate::math::moments::{ExactMoments, FIXED_POINT_UNIT, full, in_units};

/// Features of a camera ray's first hit, for denoisers and comparisons.
#[derive(Clone, Copy, Debug, Default)]
pub struct Features {
    /// Albedo per channel, in [0, 1].
    pub albedo: DVec3,
    /// Unit normal on the camera's side, in world space.
    pub normal: DVec3,
    /// Distance from the eye along the ray.
    pub depth: f64,
}

/// Albedo and normal in multiples of [`FIXED_POINT_UNIT`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct FixedPointFeatures {
    albedo: [i64; 3],
    normal: [i64; 3],
}

impl FixedPointFeatures {
    /// Converts the features; `None` if the albedo does not lie in [0, 1] or the normal is not a
    /// unit vector.
    #[inline]
    pub fn new(albedo: DVec3, normal: DVec3) -> Option<Self> {
        let is_valid = albedo.to_array().iter().all(|a| (0.0..=1.0).contains(a))
            && (normal.length_squared() - 1.0).abs() < 1e-6;
        let units = |v: DVec3| v.to_array().map(in_units);
        is_valid.then(|| Self {
            albedo: units(albedo),
            normal: units(normal),
        })
    }
}

/// Returns whether a film accepts a depth.
#[inline]
pub(crate) fn is_valid_depth(depth: f64) -> bool {
    (0.0..=MAX_RADIANCE).contains(&depth)
}

/// Refuses invalid radiances: each channel must be at least 0 and at most [`MAX_RADIANCE`].
/// Negative values that round to 0 in multiples of [`FIXED_POINT_UNIT`] pass.
///
/// # Errors
/// [`Error::Radiance`] with the first such channel's value, without a place.
#[inline]
pub fn check_radiance(radiance: DVec3) -> Result<(), Error> {
    // False for NaN, too.
    let is_valid = |value: &f64| *value > -0.5 * FIXED_POINT_UNIT && *value <= MAX_RADIANCE;
    let mut channels = radiance.to_array().into_iter();
    let invalid = channels.find(|value| !is_valid(value));
    invalid.map_or(Ok(()), |value| {
        let place = String::new();
        Err(Error::Radiance { value, place })
    })
}

/// Names of a pixel's sums in files, and the number of 32-bit words of each, lowest first. For the
/// channels of radiance the sums come first, then those of the squares; negative sums are in two's
/// complement.
pub(crate) const SUMS: [(&str, usize); 16] = [
    ("replications", 1),
    ("samples", 1),
    ("hits", 1),
    ("R", 4),
    ("R2", 4),
    ("G", 4),
    ("G2", 4),
    ("B", 4),
    ("B2", 4),
    ("albedo.R", 2),
    ("albedo.G", 2),
    ("albedo.B", 2),
    ("normal.X", 2),
    ("normal.Y", 2),
    ("normal.Z", 2),
    ("depth", 4),
];

/// Number of words of a pixel's [`SUMS`].
pub(crate) const WORDS: usize = 43;

/// Returns a sum of counts, which must be below 2³¹.
fn add_counts(count: u32, more: u32) -> Result<u32, Error> {
    let sum = u64::from(count) + u64::from(more);
    i32::try_from(sum).map_err(|_| full())?;
    Ok(sum as u32)
}

/// The accumulators of one pixel. All are integers, so sums are exact in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pixel {
    replications: u32,
    /// Number of camera rays of all replications.
    samples: u32,
    /// Number of camera rays that hit something.
    hits: u32,
    radiance: [ExactMoments; 3],
    /// Sums over the hits, in multiples of [`FIXED_POINT_UNIT`].
    albedo: [i64; 3],
    normal: [i64; 3],
    depth: i128,
}

impl Pixel {
    /// Adds one replication: the mean radiance of `samples` samples.
    ///
    /// # Errors
    /// Those of [`check_radiance`]; [`Error::Option`] if the sums are full. The pixel is then
    /// useless.
    #[inline]
    pub fn push(&mut self, radiance: DVec3, samples: u32) -> Result<(), Error> {
        check_radiance(radiance)?;
        for (channel, value) in self.radiance.iter_mut().zip(radiance.to_array()) {
            channel.push(value)?;
        }
        self.replications = add_counts(self.replications, 1)?;
        self.samples = add_counts(self.samples, samples)?;
        Ok(())
    }

    /// Adds the features of one camera ray's hit.
    ///
    /// # Errors
    /// [`Error::Option`] for an albedo outside [0, 1], a normal that is not a unit vector, a depth
    /// that is negative or exceeds [`MAX_RADIANCE`], and if the sums are full.
    #[inline]
    pub fn push_features(&mut self, features: &Features) -> Result<(), Error> {
        let Features {
            albedo,
            normal,
            depth,
        } = *features;
        match FixedPointFeatures::new(albedo, normal) {
            Some(fixed) if is_valid_depth(depth) => self.push_fixed_point(&fixed, false, depth),
            _ => Err(Error::Option(format!(
                "a camera ray met a surface of albedo {albedo}, normal {normal} at distance {depth:?}: albedos lie \
                 in [0, 1], normals are unit vectors and distances at most {MAX_RADIANCE}"
            ))),
        }
    }

    /// Adds the features of a flat surface, whose normal is flipped if it is back-facing, at a
    /// valid depth.
    #[inline]
    pub(crate) fn push_fixed_point(
        &mut self,
        fixed: &FixedPointFeatures,
        back_facing: bool,
        depth: f64,
    ) -> Result<(), Error> {
        // Sums of so many features of at most 1, in units of 2⁻³², fit 64 bits.
        self.hits = add_counts(self.hits, 1)?;
        let sign = if back_facing { -1 } else { 1 };
        for channel in 0..3 {
            self.albedo[channel] += fixed.albedo[channel];
            self.normal[channel] += sign * fixed.normal[channel];
        }
        self.depth += i128::from(in_units(depth));
        Ok(())
    }

    /// Adds another pixel's replications: exact, in any order.
    ///
    /// # Errors
    /// [`Error::Option`] if the sums are full. The pixel is then useless.
    #[inline]
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.replications = add_counts(self.replications, other.replications)?;
        self.samples = add_counts(self.samples, other.samples)?;
        for (channel, added) in self.radiance.iter_mut().zip(&other.radiance) {
            channel.merge(added)?;
        }
        self.merge_features(other)
    }

    /// Adds another pixel's features alone: exact, in any order.
    ///
    /// # Errors
    /// [`Error::Option`] if the sums are full. The pixel is then useless.
    pub(crate) fn merge_features(&mut self, other: &Self) -> Result<(), Error> {
        self.hits = add_counts(self.hits, other.hits)?;
        for channel in 0..3 {
            self.albedo[channel] += other.albedo[channel];
            self.normal[channel] += other.normal[channel];
        }
        self.depth += other.depth;
        Ok(())
    }

    /// Returns the words of the pixel's [`SUMS`].
    pub(crate) fn words(&self) -> [u32; WORDS] {
        let mut words = [0; WORDS];
        let mut at = 0;
        let mut put = |sum: i128, length: usize| {
            (0..length).for_each(|k| words[at + k] = (sum >> (32 * k)) as u32);
            at += length;
        };
        put(self.replications.into(), 1);
        put(self.samples.into(), 1);
        put(self.hits.into(), 1);
        for channel in &self.radiance {
            channel.sums().into_iter().for_each(|sum| put(sum, 4));
        }
        self.albedo
            .iter()
            .chain(&self.normal)
            .for_each(|sum| put((*sum).into(), 2));
        put(self.depth, 4);
        words
    }

    /// Restores the pixel from its words; `None` if no samples can have such sums.
    pub(crate) fn from_words(words: &[u32; WORDS]) -> Option<Self> {
        let mut rest = words.as_slice();
        let sums = SUMS.map(|(_, length)| {
            let (words_of_sum, others) = rest.split_at(length);
            rest = others;
            words_of_sum
                .iter()
                .rev()
                .fold(0_i128, |sum, word| sum << 32 | i128::from(*word))
        });
        let [replications, samples, hits] = [0, 1, 2].map(|at| i32::try_from(sums[at]).ok());
        let (replications, samples, hits) = (replications? as u32, samples? as u32, hits? as u32);
        let radiance =
            |c: usize| ExactMoments::of_sums([sums[3 + 2 * c], sums[4 + 2 * c]], replications);
        let albedo = [9, 10, 11].map(|at| sums[at] as i64);
        let normal = [12, 13, 14].map(|at| sums[at] as i64);
        let depth = sums[15];
        let max_sum = |largest: f64| i128::from(hits) * i128::from(in_units(largest));
        let is_valid = albedo
            .iter()
            .all(|sum| (0..=max_sum(1.0)).contains(&i128::from(*sum)))
            && normal
                .iter()
                .all(|sum| i128::from(sum.unsigned_abs()) <= max_sum(1.0 + 1e-6))
            && (0..=max_sum(MAX_RADIANCE)).contains(&depth);
        let radiance = [radiance(0)?, radiance(1)?, radiance(2)?];
        is_valid.then_some(Self {
            replications,
            samples,
            hits,
            radiance,
            albedo,
            normal,
            depth,
        })
    }

    /// Returns the number of independent replications.
    pub fn replications(&self) -> u32 {
        self.replications
    }

    /// Returns whether it holds neither replications nor features.
    pub(crate) fn is_empty(&self) -> bool {
        self.replications == 0 && self.hits == 0
    }

    /// Returns the number of samples of all replications.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Returns the mean radiance per channel; 0 without replications.
    pub fn mean(&self) -> DVec3 {
        DVec3::from_array(self.radiance.map(|channel| channel.mean(self.replications)))
    }

    /// Returns the standard error of the mean per channel; infinite below two replications. Its
    /// square is unbiased; a confidence interval takes Student's distribution with one degree of
    /// freedom less than there are replications.
    pub fn standard_error(&self) -> DVec3 {
        DVec3::from_array(
            self.radiance
                .map(|channel| channel.standard_error(self.replications)),
        )
    }

    /// Returns the mean features over the camera rays that hit something; zero if none did.
    pub fn features(&self) -> Features {
        if self.hits == 0 {
            return Features::default();
        }
        let scale = FIXED_POINT_UNIT / f64::from(self.hits);
        let mean = |sums: [i64; 3]| DVec3::from_array(sums.map(|sum| sum as f64 * scale));
        Features {
            albedo: mean(self.albedo),
            normal: mean(self.normal),
            depth: self.depth as f64 * scale,
        }
    }
}

/// Returns the features of a hit from the surface's albedo, the normal of its front, the depth and
/// the ray's direction.
#[inline]
pub(crate) fn features(albedo: DVec3, normal: DVec3, depth: f64, direction: DVec3) -> Features {
    Features {
        albedo,
        normal: normal * -normal.dot(direction).signum(),
        depth,
    }
}
