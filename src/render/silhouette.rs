//! Supersampling of emitter silhouettes, the sharpest edges of an image: where one crosses a pixel,
//! additional points of the pixel show how much of the emitter is visible.
//!
//! The radiance E(x) of an emitter seen directly, or through mirrors, is a function of the point x
//! of the pixel alone. In a sample whose ray passes x, its own E(x) is replaced by the mean over
//! other points that are uniform in the pixel: the expectation stays the same for any estimator,
//! and most of the pixel's variance goes. For that, camera rays follow mirrors before an estimator
//! begins.

use std::array::from_fn;

use glam::DVec3;
use rayon::prelude::*;

use crate::camera::Camera;
use crate::geometry::shape::{Hit, Ray};
use crate::light::emitter::EmitterShape;
use crate::material::{Bsdf, Vertex, fresnel};
use crate::math::frame::Frame;
use crate::sampling::Sampling;
use crate::sampling::rng::{seed_for, stream, uniform2};
use crate::sampling::sampler::{MAX_POINTS, Sobol, scramble};
use crate::scene::Scene;

/// Number of points that replace that of a sample.
pub const POINTS_PER_SAMPLE: usize = 8;

/// Number of corners of the polygon that approximates the silhouette of a sphere.
const SPHERE_CORNERS: u32 = 64;

/// Returns the points for sample `index` of a replication of a pixel, in [0, 1)²: the next ones of
/// an Owen-scrambled sequence; each replication has its own.
pub fn points(
    seed: u64,
    pixel: u32,
    replication: u32,
    index: u32,
) -> [[f64; 2]; POINTS_PER_SAMPLE] {
    let seed = seed_for(seed, "outlines");
    let first = u64::from(index) * POINTS_PER_SAMPLE as u64;
    // A sequence that ends continues in another scramble.
    let (part, first) = (first / u64::from(MAX_POINTS), first % u64::from(MAX_POINTS));
    let scramble = scramble(seed ^ part, pixel, replication);
    let fill = stream(seed, pixel, replication);
    from_fn(|i| {
        uniform2(&mut Sobol::new(
            (first as usize + i) as u16,
            scramble,
            fill.clone(),
        ))
    })
}

/// Returns the radiance of a sample after its own `emission` is replaced by the mean of the
/// points' emission, `visible`.
pub fn with_supersampled_emission(
    radiance: DVec3,
    emission: DVec3,
    visible: [DVec3; POINTS_PER_SAMPLE],
) -> DVec3 {
    let sum = visible.into_iter().fold(DVec3::ZERO, |sum, one| sum + one);
    (radiance - emission) + sum * (1.0 / POINTS_PER_SAMPLE as f64)
}

/// Largest number of mirrors that a camera ray follows before an estimator begins.
pub const MAX_MIRRORS: u32 = 8;

/// A camera ray, perhaps after it has followed mirrors.
#[derive(Clone, Copy, Debug)]
pub struct PrimaryRay {
    /// Ray after the last mirror.
    pub ray: Ray,
    /// Hit of the ray: no mirror, except one that emits and one after [`MAX_MIRRORS`].
    pub hit: Option<Hit>,
    /// Product of the mirrors' reflectances.
    pub weight: DVec3,
    /// Number of mirrors.
    pub mirrors: u32,
}

impl PrimaryRay {
    /// Creates a ray that meets `hit`, before any mirror.
    #[inline]
    pub fn new(ray: Ray, hit: Option<Hit>) -> Self {
        Self {
            ray,
            hit,
            weight: DVec3::ONE,
            mirrors: 0,
        }
    }

    /// Follows mirrors, up to [`MAX_MIRRORS`].
    pub fn follow_mirrors(mut self, scene: &Scene) -> Self {
        while let Some((here, reflectance)) =
            self.hit.and_then(|hit| Some((hit, mirror(scene, &hit)?)))
            && self.mirrors < MAX_MIRRORS
        {
            let at = Vertex::new(&here, &self.ray);
            (self.ray, self.hit) =
                scene.spawn_and_trace(&here, fresnel::reflect(at.direction, at.frame.z));
            self.weight *= reflectance;
            self.mirrors += 1;
        }
        self
    }

    /// Returns the emitted radiance seen, times the weight.
    #[inline]
    pub fn emitted(&self, scene: &Scene) -> DVec3 {
        self.hit.map_or(DVec3::ZERO, |hit| {
            self.weight * scene.emitted(&hit, self.ray.direction)
        })
    }
}

/// Returns the reflectance of a mirror that does not emit; `None` elsewhere.
fn mirror(scene: &Scene, hit: &Hit) -> Option<DVec3> {
    match scene.surface(hit).bsdf {
        Bsdf::Mirror { reflectance } if hit.emitter.is_none() => Some(reflectance),
        _ => None,
    }
}

/// Silhouette pixels of an image; empty if silhouettes are not supersampled.
pub(crate) struct Silhouettes {
    is_silhouette: Vec<bool>,
    seed: u64,
    /// Whether camera rays follow mirrors.
    pub follows_mirrors: bool,
}

impl Silhouettes {
    /// Finds the silhouette pixels, for an estimator that sees in mirrors or not.
    pub fn new(
        scene: &Scene,
        resolution: [u32; 2],
        sampling: Sampling,
        sees_in_mirrors: bool,
    ) -> Self {
        let mut is_silhouette = if sampling.silhouettes {
            silhouette_pixels(scene, resolution)
        } else {
            Vec::new()
        };
        let follows_mirrors = sees_in_mirrors && sampling.silhouettes && has_mirrors(scene);
        if follows_mirrors {
            is_silhouette
                .iter_mut()
                .zip(mirrored_silhouette_pixels(scene, resolution))
                .for_each(|(marked, here)| *marked |= here);
        }
        Self {
            is_silhouette,
            seed: sampling.seed,
            follows_mirrors,
        }
    }

    /// Returns a camera ray as the estimator gets it: after mirrors if these are followed.
    #[inline]
    pub fn view(&self, scene: &Scene, ray: Ray, hit: Option<Hit>) -> PrimaryRay {
        let view = PrimaryRay::new(ray, hit);
        if self.follows_mirrors {
            view.follow_mirrors(scene)
        } else {
            view
        }
    }

    /// Returns the [`points`] for a sample of a silhouette pixel; `None` in other pixels.
    #[inline]
    pub fn points(
        &self,
        pixel: u32,
        replication: u32,
        index: u32,
    ) -> Option<[[f64; 2]; POINTS_PER_SAMPLE]> {
        let crosses = self
            .is_silhouette
            .get(pixel as usize)
            .is_some_and(|&crosses| crosses);
        crosses.then(|| points(self.seed, pixel, replication, index))
    }
}

/// Returns for the pixels of an image, row by row, whether an emitter's silhouette crosses them,
/// occluded or not.
pub fn silhouette_pixels(scene: &Scene, resolution: [u32; 2]) -> Vec<bool> {
    let mut marked = vec![false; resolution[0] as usize * resolution[1] as usize];
    for emitter in scene.emitters() {
        let corners = clip_ahead(
            scene.camera(),
            &silhouette_polygon(&emitter.shape, scene.camera().eye),
        );
        let corners: Vec<_> = corners
            .iter()
            .filter_map(|&c| scene.camera().image_point(resolution, c))
            .collect();
        for (i, &to) in corners.iter().enumerate() {
            let from = corners[(i + corners.len() - 1) % corners.len()];
            mark_segment([from, to], resolution, &mut marked);
        }
    }
    marked
}

fn has_mirrors(scene: &Scene) -> bool {
    scene
        .surfaces()
        .iter()
        .any(|surface| matches!(surface.bsdf, Bsdf::Mirror { .. }))
}

/// Returns for the pixels of an image whether an emitter's silhouette seen in mirrors crosses them:
/// those whose corners do not all show the same emission there. Silhouettes smaller than a pixel
/// are not found.
pub fn mirrored_silhouette_pixels(scene: &Scene, resolution: [u32; 2]) -> Vec<bool> {
    let [width, height] = resolution.map(|n| n as usize);
    let visible_emission = |x: usize, y: usize| {
        let ray = scene.camera().ray(resolution, x as f64, y as f64);
        let view = PrimaryRay::new(ray, scene.intersect(&ray)).follow_mirrors(scene);
        if view.mirrors > 0 {
            view.emitted(scene)
        } else {
            DVec3::ZERO
        }
    };
    // Some rows at a time, to save memory for their corners.
    let rows = |first: usize| {
        let last = height.min(first + CORNER_ROWS);
        let corners: Vec<DVec3> = (first..=last)
            .flat_map(|y| (0..=width).map(move |x| visible_emission(x, y)))
            .collect();
        let differ = move |at: usize| {
            let next = at + width + 1;
            [at + 1, next, next + 1]
                .iter()
                .any(|&corner| corners[corner] != corners[at])
        };
        (0..last - first)
            .flat_map(move |y| (0..width).map(move |x| y * (width + 1) + x))
            .map(differ)
    };
    (0..height.div_ceil(CORNER_ROWS))
        .into_par_iter()
        .flat_map_iter(|part| rows(part * CORNER_ROWS))
        .collect()
}

/// Number of rows of pixels whose corners are traced together.
const CORNER_ROWS: usize = 16;

/// Returns the silhouette of a shape seen from the eye, as a polygon.
fn silhouette_polygon(shape: &EmitterShape, eye: DVec3) -> Vec<DVec3> {
    match *shape {
        EmitterShape::Triangle(corners) => corners.to_vec(),
        EmitterShape::Rectangle {
            corner,
            edges: [a, b],
        } => vec![corner, corner + a, corner + a + b, corner + b],
        EmitterShape::Sphere(sphere) => {
            let to_eye = eye - sphere.centre;
            let cosine = sphere.radius / to_eye.length();
            if cosine.is_nan() || cosine >= 1.0 {
                return Vec::new();
            }
            // The circle in which the cone from the eye touches the sphere.
            let frame = Frame::new(to_eye.normalize());
            let sine = (1.0 - cosine * cosine).sqrt();
            let corner = |i: u32| {
                let (s, c) =
                    (f64::from(i) * std::f64::consts::TAU / f64::from(SPHERE_CORNERS)).sin_cos();
                sphere.centre + sphere.radius * frame.world(DVec3::new(sine * c, sine * s, cosine))
            };
            (0..SPHERE_CORNERS).map(corner).collect()
        }
    }
}

/// Returns the part of a polygon that is ahead of the eye, by a millionth of its distance at least.
fn clip_ahead(camera: &Camera, corners: &[DVec3]) -> Vec<DVec3> {
    let farthest = corners
        .iter()
        .map(|c| c.distance(camera.eye))
        .fold(0.0, f64::max);
    let ahead = |corner: DVec3| camera.depth(corner) - 1e-6 * farthest;
    let mut clipped = Vec::new();
    for (i, &to) in corners.iter().enumerate() {
        let from = corners[(i + corners.len() - 1) % corners.len()];
        let (a, b) = (ahead(from), ahead(to));
        if (a > 0.0) != (b > 0.0) {
            clipped.push(from.lerp(to, a / (a - b)));
        }
        if b > 0.0 {
            clipped.push(to);
        }
    }
    clipped
}

/// Marks the pixels that a segment crosses.
fn mark_segment([from, to]: [[f64; 2]; 2], resolution: [u32; 2], marked: &mut [bool]) {
    let range = |axis: usize| {
        let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
        let pixel = |at: f64| at.clamp(0.0, f64::from(resolution[axis])) as u32;
        if high < 0.0 || low > f64::from(resolution[axis]) {
            0..0
        } else {
            pixel(low)..(pixel(high) + 1).min(resolution[axis])
        }
    };
    let normal = [from[1] - to[1], to[0] - from[0]];
    let reach = 0.5 * (normal[0].abs() + normal[1].abs());
    for y in range(1) {
        for x in range(0) {
            let [dx, dy] = [f64::from(x) + 0.5 - from[0], f64::from(y) + 0.5 - from[1]];
            if (normal[0] * dx + normal[1] * dy).abs() <= reach {
                marked[y as usize * resolution[0] as usize + x as usize] = true;
            }
        }
    }
}
