//! A pinhole camera.

use glam::DVec3;

use crate::geometry::offsets::LARGEST;
use crate::geometry::shape::Ray;
use crate::math::real::{Real, Vector};

/// A pinhole camera with square pixels. Its image lies at distance 1 in front of the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Origin of the rays.
    pub eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    half_height: f64,
}

/// Largest half height at distance 1: in wider images, rounding loses the rays' component along the
/// line of sight.
pub const MAX_HALF_HEIGHT: f64 = 1e5;

/// Names of the camera's vectors in its text.
const NAMES: [&str; 4] = ["eye", "forward", "right", "up"];
const HALF_HEIGHT: &str = "half-height";

impl Camera {
    /// Creates a camera that looks from `eye` to `target` with `up` as near to upright as possible;
    /// `half_height` is half of the image's height at distance 1, the tangent of half the vertical
    /// angle of view.
    pub fn new(eye: DVec3, target: DVec3, up: DVec3, half_height: f64) -> Self {
        let forward = (target - eye).normalize();
        let right = forward.cross(up).normalize();
        Self {
            eye,
            forward,
            right,
            up: right.cross(forward),
            half_height,
        }
    }

    /// Returns the camera as text, a line `name=numbers` each, with enough digits to restore the
    /// same camera by [`parse`](Self::parse).
    pub fn text(&self) -> String {
        let line = |(name, DVec3 { x, y, z }): (&str, DVec3)| format!("{name}={x} {y} {z}\n");
        let lines = NAMES
            .into_iter()
            .zip([self.eye, self.forward, self.right, self.up])
            .map(line);
        lines
            .chain([format!("{HALF_HEIGHT}={}\n", self.half_height)])
            .collect()
    }

    /// Reads the camera from a text that contains such lines, among others.
    pub fn parse(text: &str) -> Option<Self> {
        let line = |name| {
            text.lines()
                .find_map(|line| line.strip_prefix(name)?.strip_prefix('='))
        };
        let vector = |name| {
            let numbers: Vec<f64> = line(name)?
                .split(' ')
                .map(|number| number.parse().ok())
                .collect::<Option<_>>()?;
            numbers.try_into().ok().map(DVec3::from_array)
        };
        let [eye, forward, right, up] = NAMES.map(vector);
        let half_height = line(HALF_HEIGHT)?.parse().ok()?;
        Some(Self {
            eye: eye?,
            forward: forward?,
            right: right?,
            up: up?,
            half_height,
        })
        .filter(Self::is_valid)
    }

    /// Returns the unit vectors ahead, to the right and upwards, and half of the image's height at
    /// distance 1.
    pub fn frame(&self) -> ([DVec3; 3], f64) {
        ([self.forward, self.right, self.up], self.half_height)
    }

    /// Returns whether the camera is valid: numbers up to [`LARGEST`], a target away from the eye,
    /// `up` not along the line of sight, and a half height from the reciprocal of [`LARGEST`] to
    /// [`MAX_HALF_HEIGHT`].
    pub(crate) fn is_valid(&self) -> bool {
        [self.eye, self.forward, self.right, self.up]
            .iter()
            .all(|v| v.abs().max_element() <= LARGEST && v.is_finite())
            && (LARGEST.recip()..=MAX_HALF_HEIGHT).contains(&self.half_height)
    }

    /// Returns the ray through the point (x, y) of an image of `size` pixels, y downwards; (0, 0)
    /// is the top left corner of the first pixel.
    #[inline]
    pub fn ray<R: Real>(&self, size: [u32; 2], x: R, y: R) -> Ray<R::Vector> {
        let [width, height] = size.map(f64::from);
        let scale = 2.0 * self.half_height / height;
        let [forward, right, up] = [self.forward, self.right, self.up].map(R::Vector::splat_vector);
        let across = (x - 0.5 * width) * scale;
        let upward = (R::splat(0.5 * height) - y) * scale;
        let direction = forward + right * across + up * upward;
        Ray::new(R::Vector::splat_vector(self.eye), direction.normalize())
    }

    /// Returns the distance of a point ahead of the eye, along the line of sight.
    #[inline]
    pub(crate) fn depth(&self, point: DVec3) -> f64 {
        (point - self.eye).dot(self.forward)
    }

    /// Projects a point to the image point (x, y) of [`ray`](Self::ray), which may lie outside the
    /// image of `size` pixels; `None` behind the eye.
    #[inline]
    pub(crate) fn image_point(&self, size: [u32; 2], point: DVec3) -> Option<[f64; 2]> {
        let [width, height] = size.map(f64::from);
        let depth = self.depth(point);
        if depth <= 0.0 {
            return None;
        }
        let offset = point - self.eye;
        let scale = 2.0 * self.half_height / height;
        let x = 0.5 * width + offset.dot(self.right) / (depth * scale);
        let y = 0.5 * height - offset.dot(self.up) / (depth * scale);
        Some([x, y])
    }

    /// Projects a point to a pixel of an image of `size` pixels; `None` outside the image and
    /// behind the eye.
    #[inline]
    pub fn project(&self, size: [u32; 2], point: DVec3) -> Option<Projection> {
        let [width, height] = size.map(f64::from);
        let [x, y] = self.image_point(size, point)?;
        if !(0.0..width).contains(&x) || !(0.0..height).contains(&y) {
            return None;
        }
        let offset = point - self.eye;
        let distance_squared = offset.length_squared();
        Some(Projection {
            pixel: [x as u32, y as u32],
            to_eye: offset / -distance_squared.sqrt(),
            distance_squared,
        })
    }

    /// Returns W(ω) of [`crate::equation::IMPORTANCE`], 1/sr: the contribution to the mean radiance
    /// of a pixel of an image of `size` pixels from radiance 1 per solid angle around a unit
    /// direction ω that leaves the eye through the pixel. It is also the pdf, with respect to solid
    /// angle, of a ray through a uniform point of that pixel: the pixel has area A at distance 1,
    /// and dω covers dω/cos³θ of it.
    #[inline]
    pub fn importance(&self, size: [u32; 2], direction: DVec3) -> f64 {
        let side = 2.0 * self.half_height / f64::from(size[1]);
        1.0 / (side * side * direction.dot(self.forward).powi(3))
    }
}

/// Projection of a point into the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Column and row of its pixel.
    pub pixel: [u32; 2],
    /// Unit direction from the point to the eye.
    pub to_eye: DVec3,
    /// Squared distance to the eye.
    pub distance_squared: f64,
}
