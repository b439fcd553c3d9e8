//! The image of one pass, to which many threads add in any order.

use std::sync::atomic::{AtomicI64, Ordering};

use glam::DVec3;

use crate::error::Error;
use crate::film::check_radiance;
use crate::moments::{LARGEST, UNIT, in_units};

/// [`LARGEST`] in multiples of [`UNIT`].
const MOST: i64 = 1 << 56;
const _: () = assert!(MOST as f64 * UNIT == LARGEST);

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
        Self { width, sums: (0..count).map(|_| Default::default()).collect() }
    }

    /// Adds a value to the pixel (x, y).
    ///
    /// # Errors
    /// [`Error::Radiance`] with the pixel if a channel of the value, or of the pixel's sum, is none that
    /// [`check_radiance`] lets pass. The image is then useless.
    #[inline]
    pub fn add(&self, [x, y]: [u32; 2], value: DVec3) -> Result<(), Error> {
        let place = || format!(" at pixel ({x}, {y})");
        check_radiance(value).map_err(|error| error.at(place))?;
        let pixel = &self.sums[y as usize * self.width as usize + x as usize];
        for (sum, value) in pixel.iter().zip(value.to_array()) {
            let added = in_units(value);
            // Before it can wrap beyond 2⁶³, 126 more values would have to be refused as well.
            let sum = sum.fetch_add(added, Ordering::Relaxed) + added;
            if sum > MOST {
                return Err(Error::Radiance { value: sum as f64 * UNIT, place: place() });
            }
        }
        Ok(())
    }

    /// The sums, row by row from the top.
    pub fn into_values(self) -> Vec<DVec3> {
        let value = |sum: AtomicI64| sum.into_inner() as f64 * UNIT;
        self.sums.into_iter().map(|pixel| DVec3::from_array(pixel.map(value))).collect()
    }
}
