//! Background of a scene: uniform radiance, or an environment map.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::film::{MAX_FILM_PIXELS, check_radiance};

/// Radiance of rays that hit nothing.
#[derive(Clone, Debug, PartialEq)]
pub enum Environment {
    /// Uniform radiance from all directions.
    Uniform(DVec3),
    /// Radiance from an image.
    Map(EnvironmentMap),
}

impl Environment {
    /// Returns the radiance from a unit direction.
    #[inline]
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        match self {
            Self::Uniform(radiance) => *radiance,
            Self::Map(map) => map.radiance(direction),
        }
    }

    /// Returns the environment map, if there is one.
    #[inline]
    pub fn map(&self) -> Option<&EnvironmentMap> {
        match self {
            Self::Uniform(_) => None,
            Self::Map(map) => Some(map),
        }
    }

    /// Returns whether the background is black.
    pub fn is_black(&self) -> bool {
        *self == Self::Uniform(DVec3::ZERO)
    }
}

/// Environment map in longitude and latitude, importance-sampled by shadow rays.
///
/// Its top row is around `up`, its middle column towards `front`, and directions to the right of
/// `front`, with `up` upright, are to the right in the image. Radiance is bilinear between the
/// centres of pixels, across the left and right edge as well, and constant above the centres of the
/// first row and below those of the last.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    size: [usize; 2],
    /// Radiance of the pixels, row by row from the top.
    pixels: Vec<DVec3>,
    /// Directions to the right, up and to the front.
    axes: [DVec3; 3],
    /// Cumulative probabilities of the pixels, in their order; the last is 1.
    sums: Vec<f64>,
}

impl EnvironmentMap {
    /// Creates a map from an image of radiances, row by row from the top; `up` and `front` have any
    /// length, `front` is made perpendicular to `up`.
    ///
    /// # Errors
    /// A message if pixels do not fill the size, are not radiances, or are all black, and if `up`
    /// and `front` are parallel.
    pub fn new(
        size: [usize; 2],
        pixels: Vec<DVec3>,
        up: DVec3,
        front: DVec3,
    ) -> Result<Self, String> {
        let [width, height] = size;
        if pixels.is_empty()
            || width.checked_mul(height) != Some(pixels.len())
            || pixels.len() as u64 > MAX_FILM_PIXELS
        {
            return Err(format!(
                "{} pixels, which are not {width} × {height}",
                pixels.len()
            ));
        }
        if let Some(at) = pixels
            .iter()
            .position(|pixel| check_radiance(*pixel).is_err())
        {
            let (x, y) = (at % width, at / width);
            return Err(format!(
                "pixel ({x}, {y}) is {}, which is no radiance",
                pixels[at]
            ));
        }
        let up = up.try_normalize();
        let front = up.and_then(|up| front.reject_from_normalized(up).try_normalize());
        let (Some(up), Some(front)) = (up, front) else {
            return Err("up and front must not be along one line".to_owned());
        };
        let mut map = Self {
            size,
            pixels,
            axes: [front.cross(up), up, front],
            sums: Vec::new(),
        };
        let mut sum = 0.0;
        map.sums = (0..width * height)
            .map(|i| {
                sum += map.mean_over_cell(i % width, i / width) * map.solid_angle(i / width);
                sum
            })
            .collect();
        if sum <= 0.0 {
            return Err("all pixels are black".to_owned());
        }
        map.sums.iter_mut().for_each(|part| *part /= sum);
        Ok(map)
    }

    /// Returns the radiance from a unit direction.
    #[inline]
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        let [width, height] = self.size;
        let [u, v] = self.texture_coordinates(direction);
        let (x, y) = (
            u * width as f64 - 0.5,
            (v * height as f64 - 0.5).clamp(0.0, (height - 1) as f64),
        );
        let (left, top) = (x.floor(), y.floor());
        let (right_share, lower_share) = (x - left, y - top);
        let columns = [0, 1].map(|k| (left as isize + k).rem_euclid(width as isize) as usize);
        let rows = [top as usize, (top as usize + 1).min(height - 1)];
        let along = |row: usize| {
            let [a, b] = columns.map(|column| self.pixels[row * width + column]);
            a.lerp(b, right_share)
        };
        along(rows[0]).lerp(along(rows[1]), lower_share)
    }

    /// Maps two uniform numbers to a direction, approximately in proportion to its radiance;
    /// returns it and its pdf with respect to solid angle, 1/sr.
    #[inline]
    pub fn sample(&self, [r1, r2]: [f64; 2]) -> (DVec3, f64) {
        let [width, height] = self.size;
        let i = self
            .sums
            .partition_point(|sum| *sum <= r1)
            .min(self.sums.len() - 1);
        // The position of the first number within its pixel is a uniform number again.
        let within = ((r1 - self.sum_before(i)) / self.probability(i)).clamp(0.0, 1.0);
        let [high, low] =
            [i / width, i / width + 1].map(|row| (PI * row as f64 / height as f64).cos());
        let (z, phi) = (
            high + (low - high) * r2,
            TAU * (((i % width) as f64 + within) / width as f64 - 0.5),
        );
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let [right, up, front] = self.axes;
        let direction = right * (radius * phi.sin()) + up * z + front * (radius * phi.cos());
        (direction, self.probability(i) / self.solid_angle(i / width))
    }

    /// Returns the pdf of [`sample`](Self::sample) with respect to solid angle, 1/sr.
    #[inline]
    pub fn pdf(&self, direction: DVec3) -> f64 {
        let [width, height] = self.size;
        let [u, v] = self.texture_coordinates(direction);
        let cell = |share: f64, count: usize| ((share * count as f64) as usize).min(count - 1);
        let row = cell(v, height);
        self.probability(row * width + cell(u, width)) / self.solid_angle(row)
    }

    /// Returns the image position of a direction, in [0, 1]²: to the right and down.
    #[inline]
    fn texture_coordinates(&self, direction: DVec3) -> [f64; 2] {
        let [x, y, z] = self.axes.map(|axis| axis.dot(direction));
        [0.5 + x.atan2(z) / TAU, y.clamp(-1.0, 1.0).acos() / PI]
    }

    /// Returns the solid angle of each pixel of a row.
    #[inline]
    fn solid_angle(&self, row: usize) -> f64 {
        let [width, height] = self.size.map(|n| n as f64);
        let [high, low] = [row, row + 1].map(|row| (PI * row as f64 / height).cos());
        (high - low) * TAU / width
    }

    /// Returns the mean radiance over a pixel and the channels: by linear interpolation each
    /// neighbour in a row or column contributes an eighth.
    fn mean_over_cell(&self, x: usize, y: usize) -> f64 {
        let [width, height] = self.size;
        let columns = [(x + width - 1) % width, x, (x + 1) % width];
        let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
        let shares = [0.125, 0.75, 0.125];
        let parts = (0..9).map(|k| {
            shares[k / 3]
                * shares[k % 3]
                * self.pixels[rows[k / 3] * width + columns[k % 3]].element_sum()
                / 3.0
        });
        parts.sum()
    }

    #[inline]
    fn sum_before(&self, i: usize) -> f64 {
        if i == 0 { 0.0 } else { self.sums[i - 1] }
    }

    #[inline]
    fn probability(&self, i: usize) -> f64 {
        self.sums[i] - self.sum_before(i)
    }
}
