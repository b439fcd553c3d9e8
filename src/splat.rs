//! The image of one pass, to which many threads add in any order.

use std::sync::atomic::{AtomicI64, Ordering};

use glam::DVec3;

use crate::error::Error;
use crate::moments::{LARGEST, UNIT, in_units};

/// Sums per pixel and channel in multiples of [`UNIT`]: exact, so the order does not show.
#[derive(Debug)]
pub struct Splats {
    width: u32,
    sums: Vec<[AtomicI64; 3]>,
}

impl Splats {
    /// A dark image of `frame` (width, height) pixels.
    pub fn new(frame: [u32; 2]) -> Self {
        let [width, height] = frame;
        let count = width as usize * height as usize;
        Self {
            width,
            sums: (0..count).map(|_| Default::default()).collect(),
        }
    }

    /// Adds a value to the pixel (x, y). A pixel's sum must stay below 2³¹.
    ///
    /// # Errors
    /// [`Error::Radiance`] if a channel is not finite or exceeds [`LARGEST`].
    #[inline]
    pub fn add(&self, [x, y]: [u32; 2], value: DVec3) -> Result<(), Error> {
        let pixel = &self.sums[y as usize * self.width as usize + x as usize];
        for (sum, value) in pixel.iter().zip(value.to_array()) {
            if value.is_nan() || value.abs() > LARGEST {
                return Err(Error::Radiance {
                    value,
                    place: format!(" at pixel ({x}, {y})"),
                });
            }
            sum.fetch_add(in_units(value), Ordering::Relaxed);
        }
        Ok(())
    }

    /// The sums, row by row from the top.
    pub fn into_values(self) -> Vec<DVec3> {
        let value = |sum: AtomicI64| sum.into_inner() as f64 * UNIT;
        self.sums
            .into_iter()
            .map(|pixel| DVec3::from_array(pixel.map(value)))
            .collect()
    }
}
