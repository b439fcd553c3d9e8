//! The image of one pass, to which many threads add in any order.

use std::sync::{Mutex, PoisonError};

use glam::DVec3;

use super::check_radiance;
use crate::error::{Error, MAX_RADIANCE};
use crate::math::moments::{FIXED_POINT_UNIT, in_units};

/// [`MAX_RADIANCE`] in multiples of [`FIXED_POINT_UNIT`].
const MAX_SUM: i64 = 1 << 56;
const _: () = assert!(MAX_SUM as f64 * FIXED_POINT_UNIT == MAX_RADIANCE);

/// Approximate number of bands of rows of an image: one thread at a time adds to each.
const BANDS: u32 = 16;

/// Value per channel in multiples of [`FIXED_POINT_UNIT`]: exact, so the order of summation does
/// not matter.
type Units = [i64; 3];

/// Sums per pixel.
#[derive(Debug)]
pub struct Splats {
    width: u32,
    /// Number of rows of a band; the last may have fewer.
    rows: u32,
    bands: Vec<Mutex<Vec<Units>>>,
}

/// Buffer of one thread, kept until it has enough values to add to the bands.
#[derive(Debug)]
pub struct SplatBuffer<'a> {
    image: &'a Splats,
    /// Pending (pixel, value) pairs per band.
    pending: Vec<Vec<(u32, Units)>>,
}

impl Splats {
    /// Creates a black image of `resolution` (width, height) pixels.
    pub fn new([width, height]: [u32; 2]) -> Self {
        let rows = height.div_ceil(BANDS).max(1);
        let band = |first: u32| {
            Mutex::new(vec![
                [0; 3];
                width as usize * (height - first).min(rows) as usize
            ])
        };
        Self {
            width,
            rows,
            bands: (0..height).step_by(rows as usize).map(band).collect(),
        }
    }

    /// Returns an empty buffer for the image.
    pub fn buffer(&self) -> SplatBuffer<'_> {
        SplatBuffer {
            image: self,
            pending: vec![Vec::new(); self.bands.len()],
        }
    }

    /// Returns the sums, row by row from the top.
    pub fn into_values(self) -> Vec<DVec3> {
        let sums = self
            .bands
            .into_iter()
            .flat_map(|band| band.into_inner().unwrap_or_else(PoisonError::into_inner));
        sums.map(|sum| DVec3::from_array(sum.map(|units| units as f64 * FIXED_POINT_UNIT)))
            .collect()
    }
}

impl SplatBuffer<'_> {
    /// Adds a value to the pixel (x, y), once the buffer is [flushed](Self::flush).
    ///
    /// # Errors
    /// [`Error::Radiance`] with the pixel for values that [`check_radiance`] refuses.
    #[inline]
    pub fn add(&mut self, [x, y]: [u32; 2], value: DVec3) -> Result<(), Error> {
        check_radiance(value).map_err(|error| error.at(|| at_pixel([x, y])))?;
        let Splats { width, rows, .. } = self.image;
        self.pending[(y / rows) as usize]
            .push((y % rows * width + x, value.to_array().map(in_units)));
        Ok(())
    }

    /// Adds all pending values to the image.
    ///
    /// # Errors
    /// [`Error::Radiance`] with the pixel if a channel of its sum exceeds [`MAX_RADIANCE`]. The
    /// image is then useless.
    pub fn flush(&mut self) -> Result<(), Error> {
        let Splats { width, rows, bands } = self.image;
        for ((pending, band), first) in self
            .pending
            .iter_mut()
            .zip(bands)
            .zip((0..).step_by(*rows as usize))
        {
            let mut sums = band.lock().unwrap_or_else(PoisonError::into_inner);
            for (pixel, value) in pending.drain(..) {
                for (sum, added) in sums[pixel as usize].iter_mut().zip(value) {
                    // Both are at most 2⁵⁶.
                    *sum += added;
                    if *sum > MAX_SUM {
                        let value = *sum as f64 * FIXED_POINT_UNIT;
                        *sum -= added;
                        return Err(Error::Radiance {
                            value,
                            place: at_pixel([pixel % width, first + pixel / width]),
                        });
                    }
                }
            }
        }
        Ok(())
    }
}

fn at_pixel([x, y]: [u32; 2]) -> String {
    format!(" at pixel ({x}, {y})")
}
