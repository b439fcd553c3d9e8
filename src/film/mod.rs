//! The film: per pixel, exact first and second moments of the radiance over independent
//! replications, and features of the first hit.

pub mod splat;

use glam::DVec3;

use crate::error::{Error, MAX_RADIANCE};
use crate::math::moments::{ExactMoments, FIXED_POINT_UNIT, full, in_units};

/// A rectangle of pixels: `corner` is its first pixel, x to the right, y down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// x and y of the first pixel.
    pub corner: [u32; 2],
    /// Width and height in pixels.
    pub size: [u32; 2],
}

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
    match radiance
        .to_array()
        .into_iter()
        .find(|value| !is_valid(value))
    {
        None => Ok(()),
        Some(value) => Err(Error::Radiance {
            value,
            place: String::new(),
        }),
    }
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
        self.hits = add_counts(self.hits, other.hits)?;
        for channel in 0..3 {
            self.radiance[channel].merge(&other.radiance[channel])?;
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

/// A window of an image with its accumulators, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    resolution: [u32; 2],
    window: Window,
    samples_per_replication: u32,
    /// Number of samples in a replication of each pixel, where they differ.
    sample_counts: Option<Vec<u32>>,
    pixels: Vec<Pixel>,
    pub(crate) partial: Option<PartialReplication>,
}

/// An unfinished replication of an image estimator: some of its passes are done.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PartialReplication {
    /// Number of passes done.
    pub passes: u32,
    /// Sum of the passes for each pixel.
    pub sums: Vec<DVec3>,
}

/// Largest number of pixels of a film, about 17 GB of accumulators.
pub const MAX_FILM_PIXELS: u64 = 100_000_000;

impl Film {
    /// Creates an empty film for the `window` (or all) of an image of `resolution` pixels, whose
    /// replications have `samples_per_replication` samples each.
    ///
    /// # Errors
    /// Those of [`checked_window`](Self::checked_window).
    pub fn new(
        resolution: [u32; 2],
        window: Option<Window>,
        samples_per_replication: u32,
    ) -> Result<Self, Error> {
        let window = Self::checked_window(resolution, window)?;
        let [width, height] = window.size.map(|n| n as usize);
        let pixels = vec![Pixel::default(); width * height];
        Ok(Self {
            resolution,
            window,
            samples_per_replication,
            sample_counts: None,
            pixels,
            partial: None,
        })
    }

    /// Returns the window that a film would hold.
    ///
    /// # Errors
    /// [`Error::Option`] for a size of 0, above [`MAX_FILM_PIXELS`], or a window that leaves the
    /// image.
    pub fn checked_window(resolution: [u32; 2], window: Option<Window>) -> Result<Window, Error> {
        let window = window.unwrap_or(Window {
            corner: [0, 0],
            size: resolution,
        });
        let [width, height] = window.size;
        let inside = |axis: usize| {
            u64::from(window.corner[axis]) + u64::from(window.size[axis])
                <= u64::from(resolution[axis])
        };
        if !(inside(0) && inside(1)) {
            return Err(Error::Option(format!(
                "window {width}x{height} at ({}, {}) leaves the frame of {}x{} pixels",
                window.corner[0], window.corner[1], resolution[0], resolution[1]
            )));
        }
        let count = u64::from(width) * u64::from(height);
        if count == 0 {
            return Err(Error::Option(format!(
                "size {width}x{height} has no pixels: both numbers must be at least 1"
            )));
        }
        if count > MAX_FILM_PIXELS || resolution[0].checked_mul(resolution[1]).is_none() {
            return Err(Error::Option(format!(
                "size {width}x{height} is too large for memory: take a smaller one, at most {MAX_FILM_PIXELS} pixels"
            )));
        }
        Ok(window)
    }

    /// Copies the other film into this one, reusing its memory.
    pub fn assign(&mut self, other: &Self) {
        let Self {
            resolution,
            window,
            samples_per_replication,
            sample_counts,
            pixels,
            partial,
        } = self;
        (*resolution, *window, *samples_per_replication) = (
            other.resolution,
            other.window,
            other.samples_per_replication,
        );
        sample_counts.clone_from(&other.sample_counts);
        pixels.clone_from(&other.pixels);
        partial.clone_from(&other.partial);
    }

    /// Returns width and height of the full image in pixels.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// Returns the part of the image that this film holds.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Returns width and height of the film in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.window.size
    }

    /// Returns the number of samples in one replication of a pixel, on average where pixels
    /// [differ](Self::set_sample_counts).
    pub fn samples_per_replication(&self) -> u32 {
        self.samples_per_replication
    }

    /// Sets the number of samples in a replication of each pixel, row by row from the top; for
    /// [`render`](crate::render::render) and [`render_lanes`](crate::render::render_lanes) with
    /// Sobol' points. Files do not hold these numbers: set them again after reading a film.
    ///
    /// # Panics
    /// If there are not as many counts as pixels.
    pub fn set_sample_counts(&mut self, counts: Vec<u32>) {
        assert_eq!(
            counts.len(),
            self.pixels.len(),
            "counts of samples for each pixel"
        );
        self.sample_counts = Some(counts);
    }

    /// Returns the numbers of samples that were [set](Self::set_sample_counts).
    pub fn sample_counts(&self) -> Option<&[u32]> {
        self.sample_counts.as_deref()
    }

    /// Returns the pixels, mutable, and their [`sample_counts`](Self::sample_counts).
    pub(crate) fn pixels_and_counts_mut(&mut self) -> (&mut [Pixel], Option<&[u32]>) {
        (&mut self.pixels, self.sample_counts.as_deref())
    }

    /// Returns the number of samples still missing for so many replications of each pixel.
    pub fn missing_samples(&self, replications: u32) -> u64 {
        let count_at = |at: usize| {
            self.sample_counts
                .as_ref()
                .map_or(self.samples_per_replication, |counts| counts[at])
        };
        let missing = |(at, pixel): (usize, &Pixel)| {
            u64::from(replications.saturating_sub(pixel.replications)) * u64::from(count_at(at))
        };
        self.pixels.iter().enumerate().map(missing).sum()
    }

    /// Returns the pixels, row by row from the top.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// Returns the pixels, mutable.
    pub fn pixels_mut(&mut self) -> &mut [Pixel] {
        &mut self.pixels
    }

    /// Returns the smallest number of replications of any pixel. All have the same number, except
    /// after a render call that was stopped.
    pub fn replications(&self) -> u32 {
        self.pixels
            .iter()
            .map(Pixel::replications)
            .min()
            .unwrap_or(0)
    }

    /// Returns whether all pixels have so many replications, and none is unfinished.
    pub fn has_exactly(&self, replications: u32) -> bool {
        self.partial.is_none()
            && self
                .pixels
                .iter()
                .all(|pixel| pixel.replications == replications)
    }

    /// Returns the pixel at (x, y) of the film.
    pub fn pixel(&self, x: u32, y: u32) -> &Pixel {
        &self.pixels[y as usize * self.window.size[0] as usize + x as usize]
    }

    /// Returns the mean radiance of each pixel's samples so far, including those of an unfinished
    /// replication.
    pub fn means_so_far(&self) -> Vec<DVec3> {
        let Some(PartialReplication { passes, sums }) = &self.partial else {
            return self.pixels.iter().map(Pixel::mean).collect();
        };
        let samples = f64::from(self.samples_per_replication);
        let mean = |(pixel, sum): (&Pixel, &DVec3)| {
            let done = samples * f64::from(pixel.replications);
            (pixel.mean() * done + sum) / (done + f64::from(*passes))
        };
        self.pixels.iter().zip(sums).map(mean).collect()
    }

    /// Returns whether image size, window and samples per replication are the same.
    pub fn is_compatible(&self, other: &Self) -> bool {
        (self.resolution, self.window, self.samples_per_replication)
            == (
                other.resolution,
                other.window,
                other.samples_per_replication,
            )
    }

    /// Adds another film's replications: exact, in any order.
    ///
    /// # Errors
    /// [`Error::Option`] if resolutions, windows or replications differ, one has a replication that
    /// is only begun, or sums are full.
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        if self.partial.is_some() || other.partial.is_some() {
            return Err(Error::Option(
                "a film with an unfinished replication cannot be merged".to_owned(),
            ));
        }
        if !self.is_compatible(other) {
            let kind = |film: &Self| (film.resolution, film.window, film.samples_per_replication);
            return Err(Error::Option(format!(
                "films of different frames, windows or replications cannot be merged: {:?} and {:?}",
                kind(self),
                kind(other)
            )));
        }
        for (pixel, added) in self.pixels.iter_mut().zip(&other.pixels) {
            pixel.merge(added)?;
        }
        Ok(())
    }

    /// Returns the mean radiance over all pixels and channels.
    pub fn mean(&self) -> f64 {
        self.average(Pixel::mean)
    }

    /// Returns the mean standard error of the pixels, relative to the mean radiance; infinite below
    /// two replications. The root of an unbiased variance is too small on average, with four
    /// replications by a twelfth.
    pub fn relative_error(&self) -> f64 {
        self.average(Pixel::standard_error) / self.mean()
    }

    /// Returns the largest relative error of the image's mean due to rounding of values to
    /// multiples of [`FIXED_POINT_UNIT`]: half a unit over the mean; infinite for a black image.
    pub fn rounding_error(&self) -> f64 {
        0.5 * FIXED_POINT_UNIT / self.mean()
    }

    fn average(&self, of: impl Fn(&Pixel) -> DVec3) -> f64 {
        let sum: f64 = self
            .pixels
            .iter()
            .map(|pixel| of(pixel).element_sum())
            .sum();
        sum / (3.0 * self.pixels.len() as f64)
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
