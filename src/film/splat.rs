//! The image of one pass, to which many threads add in any order.

use std::sync::{Mutex, PoisonError};

use glam::DVec3;

use super::check_radiance;
use crate::error::{Error, LARGEST_RADIANCE};
use crate::math::moments::{UNIT, in_units};

/// [`LARGEST_RADIANCE`] in multiples of [`UNIT`].
const MOST: i64 = 1 << 56;
const _: () = assert!(MOST as f64 * UNIT == LARGEST_RADIANCE);

/// About how many bands of rows an image has: one thread at a time adds to each.
const BANDS: u32 = 16;

/// Per channel in multiples of [`UNIT`]: exact, so the order in which they add up does not show.
type Units = [i64; 3];

/// Sums per pixel.
#[derive(Debug)]
pub struct Splats {
    width: u32,
    /// Rows of a band; of the last perhaps less.
    rows: u32,
    bands: Vec<Mutex<Vec<Units>>>,
}

/// What one thread adds to an image, kept until there is enough of it to go through the bands.
#[derive(Debug)]
pub struct SplatBuffer<'a> {
    image: &'a Splats,
    /// Of each band the pixels and values.
    waiting: Vec<Vec<(u32, Units)>>,
}

impl Splats {
    /// A dark image of `frame` (width, height) pixels.
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

    /// An empty buffer for it.
    pub fn buffer(&self) -> SplatBuffer<'_> {
        SplatBuffer {
            image: self,
            waiting: vec![Vec::new(); self.bands.len()],
        }
    }

    /// The sums, row by row from the top.
    pub fn into_values(self) -> Vec<DVec3> {
        let sums = self
            .bands
            .into_iter()
            .flat_map(|band| band.into_inner().unwrap_or_else(PoisonError::into_inner));
        sums.map(|sum| DVec3::from_array(sum.map(|units| units as f64 * UNIT)))
            .collect()
    }
}

impl SplatBuffer<'_> {
    /// Adds a value to the pixel (x, y), once the buffer is [flushed](Self::flush).
    ///
    /// # Errors
    /// [`Error::Radiance`] with the pixel for what [`check_radiance`] does not let pass.
    #[inline]
    pub fn add(&mut self, [x, y]: [u32; 2], value: DVec3) -> Result<(), Error> {
        check_radiance(value).map_err(|error| error.at(|| at_pixel([x, y])))?;
        let Splats { width, rows, .. } = self.image;
        self.waiting[(y / rows) as usize]
            .push((y % rows * width + x, value.to_array().map(in_units)));
        Ok(())
    }

    /// Adds all that it has to the image.
    ///
    /// # Errors
    /// [`Error::Radiance`] with the pixel if a channel of its sum exceeds [`LARGEST_RADIANCE`]. The image is
    /// then useless.
    pub fn flush(&mut self) -> Result<(), Error> {
        let Splats { width, rows, bands } = self.image;
        for ((waiting, band), first) in self
            .waiting
            .iter_mut()
            .zip(bands)
            .zip((0..).step_by(*rows as usize))
        {
            let mut sums = band.lock().unwrap_or_else(PoisonError::into_inner);
            for (pixel, value) in waiting.drain(..) {
                for (sum, added) in sums[pixel as usize].iter_mut().zip(value) {
                    // Both are at most 2⁵⁶.
                    *sum += added;
                    if *sum > MOST {
                        let value = *sum as f64 * UNIT;
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
