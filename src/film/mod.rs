//! The film: per pixel, exact first and second moments of the radiance over independent
//! replications, and features of the first hit.

mod pixel;
pub mod splat;

use std::sync::Arc;

use glam::DVec3;

use crate::error::Error;
use crate::math::moments::FIXED_POINT_UNIT;

pub use pixel::{Features, Pixel, check_radiance};
pub(crate) use pixel::{FixedPointFeatures, features, is_valid_depth};
#[cfg(feature = "files")]
pub(crate) use pixel::{SUMS, WORDS};

/// A rectangle of pixels: `corner` is its first pixel, x to the right, y down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// x and y of the first pixel.
    pub corner: [u32; 2],
    /// Width and height in pixels.
    pub size: [u32; 2],
}

/// A window of an image with its accumulators, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    resolution: [u32; 2],
    window: Window,
    samples_per_replication: u32,
    /// Number of samples in a replication of each pixel, where they differ.
    sample_counts: Option<Vec<u32>>,
    /// First samples of the first replications, if they are known.
    pub(crate) begun: Option<Arc<BegunReplications>>,
    pixels: Vec<Pixel>,
    pub(crate) partial: Option<PartialReplication>,
}

/// The first samples of the first replications, which rendering does not take again.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BegunReplications {
    /// Number of these samples in each replication of a pixel.
    pub samples: u32,
    /// Distance between the stream numbers of two replications, in place of their number of samples,
    /// which is not known when the first samples are taken.
    pub stride: u32,
    /// Sums of their radiances, by replication and pixel.
    pub sums: Vec<Vec<DVec3>>,
}

impl BegunReplications {
    /// Returns how many samples a replication of a pixel has begun with, and the sum of their
    /// radiances.
    pub fn samples_of(&self, pixel: usize, replication: u32) -> (u32, DVec3) {
        let sums = self.sums.get(replication as usize);
        sums.map_or((0, DVec3::ZERO), |sums| (self.samples, sums[pixel]))
    }
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
            begun: None,
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
            begun,
            pixels,
            partial,
        } = self;
        (*resolution, *window, *samples_per_replication) = (
            other.resolution,
            other.window,
            other.samples_per_replication,
        );
        sample_counts.clone_from(&other.sample_counts);
        begun.clone_from(&other.begun);
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

    /// Returns the pixels, mutable, their [`sample_counts`](Self::sample_counts), and the samples that
    /// they have begun with.
    pub(crate) fn parts_mut(
        &mut self,
    ) -> (&mut [Pixel], Option<&[u32]>, Option<&BegunReplications>) {
        (
            &mut self.pixels,
            self.sample_counts.as_deref(),
            self.begun.as_deref(),
        )
    }

    /// Returns the number of samples still missing for so many replications of each pixel.
    pub fn missing_samples(&self, replications: u32) -> u64 {
        let count_at = |at: usize| {
            self.sample_counts
                .as_ref()
                .map_or(self.samples_per_replication, |counts| counts[at])
        };
        let missing = |(at, pixel): (usize, &Pixel)| {
            u64::from(replications.saturating_sub(pixel.replications())) * u64::from(count_at(at))
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
                .all(|pixel| pixel.replications() == replications)
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
            let done = samples * f64::from(pixel.replications());
            (pixel.mean() * done + sum) / (done + f64::from(*passes))
        };
        self.pixels.iter().zip(sums).map(mean).collect()
    }

    /// Returns whether image size, window and samples per replication are the same.
    pub fn is_compatible(&self, other: &Self) -> bool {
        self.kind() == other.kind()
    }

    fn kind(&self) -> ([u32; 2], Window, u32) {
        (self.resolution, self.window, self.samples_per_replication)
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
            return Err(Error::Option(format!(
                "films of different frames, windows or replications cannot be merged: {:?} and {:?}",
                self.kind(),
                other.kind()
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
