//! Small scenes whose answers are known, and the Cornell box.

use glam::DVec3;

use super::{Scene, SceneBuilder, Surface};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::error::Error;
use crate::shape::Sphere;

/// The white furnace: a Lambert sphere of albedo 1, a perfect mirror and a glass sphere in a uniform
/// environment of radiance 1. Every pixel's expectation is exactly 1.
///
/// # Errors
/// None for these numbers; the type is that of [`SceneBuilder::build`].
pub fn environment() -> Result<Scene, Error> {
    furnace_under(DVec3::ONE)
}

/// The same under a sky of any radiance, which is every pixel's expectation then.
///
/// # Errors
/// A radiance that is negative or not finite.
pub fn furnace_under(sky: DVec3) -> Result<Scene, Error> {
    let mut scene = SceneBuilder::new("environment");
    scene.background(sky);
    let bsdfs =
        [Bsdf::Lambert { albedo: DVec3::ONE }, Bsdf::Mirror { reflectance: DVec3::ONE }, Bsdf::Glass { index: 1.5 }];
    for (x, bsdf) in [-2.5, 0.0, 2.5].into_iter().zip(bsdfs) {
        let surface = scene.surface(Surface::new(bsdf));
        scene.sphere(Sphere::new(DVec3::new(x, 0.0, 0.0), 1.0), surface);
    }
    scene.build(Camera::new(DVec3::new(0.0, -8.0, 0.0), DVec3::ZERO, DVec3::Z, 0.36))
}

/// A closed cube whose walls emit radiance 1 and reflect with the given albedo a < 1: the radiance is
/// 1/(1 − a) everywhere and in every direction.
///
/// # Errors
/// An albedo outside [0, 1].
pub fn furnace_box(albedo: f64) -> Result<Scene, Error> {
    let mut scene = SceneBuilder::new("furnace-box");
    let bsdf = Bsdf::Lambert { albedo: DVec3::splat(albedo) };
    let surface = Surface::new(bsdf).emitting(DVec3::ONE).absorbing(1.0 - albedo);
    let wall = scene.surface(surface);
    closed_cube(&mut scene, 1.0, true, wall);
    let eye = DVec3::new(-0.7, -0.4, 0.1);
    scene.build(Camera::new(eye, DVec3::new(0.6, 0.5, -0.2), DVec3::Z, 1.0))
}

/// What the emitting cap of [`cavity_cap`] does with light that arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cap {
    /// Reflects like the rest of the cavity.
    Reflecting,
    /// Reflects nothing.
    Black,
}

/// Share of the cavity's area that the cap takes: all within 60° of the pole, (1 − cos 60°)/2.
pub const CAP_SHARE: f64 = 0.25;

/// A spherical cavity of albedo ρ with a cap of radiance 1 around its upper pole. With f =
/// [`CAP_SHARE`] the radiance off the cap is ρf/(1 − ρ) if the cap reflects, ρf/(1 − ρ(1 − f)) if it is
/// black, the same everywhere and in every direction, because every point of a sphere sees every area
/// of it under the same form factor.
///
/// # Errors
/// An albedo outside [0, 1].
pub fn cavity_cap(albedo: f64, cap: Cap) -> Result<Scene, Error> {
    let mut scene = SceneBuilder::new("cavity-cap");
    let diffuse = Surface::new(Bsdf::Lambert { albedo: DVec3::splat(albedo) });
    let lower = scene.surface(diffuse.absorbing(1.0 - albedo));
    let upper = scene.surface(match cap {
        Cap::Reflecting => diffuse.absorbing(1.0 - albedo).emitting(DVec3::ONE),
        Cap::Black => Surface::new(Bsdf::Black).emitting(DVec3::ONE),
    });
    let border = 1.0 - 2.0 * CAP_SHARE;
    for (zone, surface) in [([f64::NEG_INFINITY, border], lower), ([border, f64::INFINITY], upper)] {
        let sphere = Sphere { zone, inward: true, ..Sphere::new(DVec3::ZERO, 1.0) };
        scene.sphere(sphere, surface);
    }
    let eye = DVec3::new(0.3, -0.5, 0.1);
    scene.build(Camera::new(eye, DVec3::new(0.0, 1.0, -0.8), DVec3::Z, 0.3))
}

/// A glass cube of index 1.5 in a uniform environment of radiance 1. Every pixel's expectation is
/// exactly 1 from outside and 1.5² from inside, total internal reflection included.
///
/// From inside that holds for directions within the critical angle, 41.8°, of some axis; in all others
/// light is trapped and the radiance is 0. The inner camera looks along an axis, so that every pixel of
/// a frame up to 4:3 can see out.
///
/// # Errors
/// None for these numbers; the type is that of [`SceneBuilder::build`].
pub fn glass_cube(inside: bool) -> Result<Scene, Error> {
    let mut scene = SceneBuilder::new("glass-cube");
    scene.background(DVec3::ONE);
    let glass = scene.surface(Surface::new(Bsdf::Glass { index: 1.5 }));
    closed_cube(&mut scene, 1.0, false, glass);
    let distance = if inside { 0.1 } else { 3.0 };
    let eye = distance * DVec3::new(0.9, -1.3, 0.7);
    let target = if inside { eye + DVec3::Y } else { DVec3::ZERO };
    scene.build(Camera::new(eye, target, DVec3::Z, 0.5))
}

/// The Cornell box: published dimensions in decimetres, three-channel albedos near the published
/// spectra, an emitting rectangle just below the ceiling.
///
/// # Errors
/// None for these numbers; the type is that of [`SceneBuilder::build`].
pub fn cornell() -> Result<Scene, Error> {
    const UNIT: f64 = 0.01;
    let mut scene = SceneBuilder::new("cornell");
    let mut lambert = |r: f64, g: f64, b: f64| {
        let bsdf = Bsdf::Lambert { albedo: DVec3::new(r, g, b) };
        scene.surface(Surface::new(bsdf))
    };
    let white = lambert(0.73, 0.73, 0.73);
    let red = lambert(0.63, 0.065, 0.05);
    let green = lambert(0.14, 0.45, 0.091);
    let light =
        scene.surface(Surface::new(Bsdf::Lambert { albedo: DVec3::splat(0.78) }).emitting(DVec3::new(17.0, 12.0, 4.0)));
    let room = [
        [552.8, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 559.2],
        [549.6, 0.0, 559.2],
        [556.0, 548.8, 0.0],
        [0.0, 548.8, 0.0],
        [0.0, 548.8, 559.2],
        [556.0, 548.8, 559.2],
    ]
    .map(|v| DVec3::from_array(v) * UNIT);
    let quad = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    for (corners, surface) in [
        ([0, 1, 2, 3], white),
        ([4, 7, 6, 5], white),
        ([3, 2, 6, 7], white),
        ([2, 1, 5, 6], green),
        ([0, 3, 7, 4], red),
    ] {
        scene.mesh(&room, &quad(corners), surface);
    }
    scene.rectangle(
        DVec3::new(343.0, 548.7, 227.0) * UNIT,
        [DVec3::new(0.0, 0.0, 105.0) * UNIT, DVec3::new(-130.0, 0.0, 0.0) * UNIT],
        light,
    );
    for (height, base) in [
        (165.0, [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]]),
        (330.0, [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]]),
    ] {
        let ring = |y: f64| base.map(|[x, z]: [f64; 2]| DVec3::new(x, y, z) * UNIT);
        let vertices: Vec<DVec3> = ring(0.0).into_iter().chain(ring(height)).collect();
        for corners in [[4, 5, 6, 7], [0, 4, 7, 3], [3, 7, 6, 2], [2, 6, 5, 1], [1, 5, 4, 0]] {
            scene.mesh(&vertices, &quad(corners), white);
        }
    }
    let eye = DVec3::new(278.0, 273.0, -800.0) * UNIT;
    scene.build(Camera::new(eye, eye + DVec3::Z, DVec3::Y, 0.0125 / 0.035))
}

/// The cube [−h, h]³ as one indexed mesh, fronts inside or outside.
pub fn closed_cube(scene: &mut SceneBuilder, half: f64, inward: bool, surface: super::SurfaceId) {
    let vertices: Vec<DVec3> = (0..8)
        .map(|i| {
            let sign = |bit: u32| if i >> bit & 1 == 1 { half } else { -half };
            DVec3::new(sign(0), sign(1), sign(2))
        })
        .collect();
    let mut triangles = vec![
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    if inward {
        triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    scene.mesh(&vertices, &triangles, surface);
}
