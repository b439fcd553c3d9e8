//! A pinhole camera.

use glam::DVec3;

use crate::shape::Ray;

/// A pinhole camera with square pixels. Its image lies at distance 1 in front of the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the rays start.
    pub eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    half_height: f64,
}

impl Camera {
    /// Looks from `eye` to `target` with `up` as near to upright as can be; `half_height` is half of
    /// the image's height at distance 1, the tangent of half the vertical angle of view.
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

    /// The ray through the point (x, y) of an image of `size` pixels, y downwards; (0, 0) is the top
    /// left corner of the first pixel.
    #[inline]
    pub fn ray(&self, size: [u32; 2], x: f64, y: f64) -> Ray {
        let [width, height] = size.map(f64::from);
        let scale = 2.0 * self.half_height / height;
        let direction = self.forward
            + (x - 0.5 * width) * scale * self.right
            + (0.5 * height - y) * scale * self.up;
        Ray::new(self.eye, direction.normalize())
    }
}
