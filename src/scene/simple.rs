//! Small scenes with known answers, and the Cornell box: files, and the changes that trials make to
//! them.

use glam::DVec3;

use super::builder::cuboid;
use super::file::Description;
use super::{Scene, SceneBuilder, SurfaceId};
use crate::camera::Camera;
use crate::error::Error;
use crate::light::environment::Environment;
use crate::material::Bsdf;

/// Builds the white furnace: a Lambert sphere of albedo 1, a perfect mirror and a glass sphere in a
/// uniform environment of radiance 1. Every pixel's expectation is exactly 1.
///
/// # Errors
/// None for these numbers; the type is that of [`SceneBuilder::build`].
pub fn environment() -> Result<Scene, Error> {
    furnace_under(DVec3::ONE)
}

/// Builds the white furnace under a sky of any radiance, which is then every pixel's expectation.
///
/// # Errors
/// A radiance that is negative or not finite.
pub fn furnace_under(sky: DVec3) -> Result<Scene, Error> {
    let scene = Description::parse("environment", include_str!("files/environment.toml"))?;
    Description {
        background: Environment::Uniform(sky),
        ..scene
    }
    .build()
}

/// Builds a closed cube whose walls emit radiance 1 and reflect with the given albedo a < 1: the
/// radiance is 1/(1 − a) everywhere and in every direction.
///
/// # Errors
/// An albedo outside [0, 1].
pub fn furnace_box(albedo: f64) -> Result<Scene, Error> {
    let mut scene = Description::parse("furnace-box", include_str!("files/furnace-box.toml"))?;
    scene.reflects("wall", albedo)?;
    scene.build()
}

/// Reflection of the emitting cap of [`cavity_cap`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cap {
    /// Reflects like the rest of the cavity.
    Reflecting,
    /// Reflects nothing.
    Black,
}

/// Fraction of the cavity's area that the cap takes: all within 60° of the pole, (1 − cos 60°)/2.
pub const CAP_SHARE: f64 = 0.25;

/// Builds a spherical cavity of albedo ρ with a cap of radiance 1 around its upper pole. With f =
/// [`CAP_SHARE`] the radiance off the cap is ρf/(1 − ρ) if the cap reflects, ρf/(1 − ρ(1 − f)) if
/// it is black, the same everywhere and in every direction, because every point of a sphere sees
/// every area of it under the same form factor.
///
/// # Errors
/// An albedo outside [0, 1].
pub fn cavity_cap(albedo: f64, cap: Cap) -> Result<Scene, Error> {
    let mut scene = Description::parse("cavity-cap", include_str!("files/cavity-cap.toml"))?;
    scene.reflects("dark", albedo)?;
    match cap {
        Cap::Reflecting => scene.reflects("cap", albedo)?,
        Cap::Black => {
            let surface = scene.surface("cap")?;
            (surface.bsdf, surface.absorption) = (Bsdf::Black, 0.0);
        }
    }
    scene.build()
}

/// Builds a glass cube of index 1.5 in a uniform environment of radiance 1. Every pixel's
/// expectation is exactly 1 from outside and 1.5² from inside, total internal reflection included.
///
/// From inside that holds for directions within the critical angle, 41.8°, of some axis; in all
/// others light is trapped and the radiance is 0. The inner camera looks along an axis, so that
/// every pixel of an image up to 4:3 can see out.
///
/// # Errors
/// None for these numbers; the type is that of [`SceneBuilder::build`].
pub fn glass_cube(inside: bool) -> Result<Scene, Error> {
    let mut scene = Description::parse("glass-cube", include_str!("files/glass-cube.toml"))?;
    if inside {
        let eye = 0.1 * DVec3::new(0.9, -1.3, 0.7);
        scene.camera = Camera::new(eye, eye + DVec3::Y, DVec3::Z, 0.5);
    }
    scene.build()
}

/// Builds the Cornell box: published dimensions in decimetres, three-channel albedos near the
/// published spectra, an emitting rectangle just below the ceiling.
///
/// # Errors
/// None for these numbers; the type is that of [`SceneBuilder::build`].
pub fn cornell() -> Result<Scene, Error> {
    Description::parse("cornell", include_str!("files/cornell.toml"))?.build()
}

impl Description {
    /// Sets a surface's albedo and, in the report's roulette, absorbs the rest.
    fn reflects(&mut self, material: &str, albedo: f64) -> Result<(), Error> {
        let surface = self.surface(material)?;
        (surface.bsdf, surface.absorption) = (
            Bsdf::Lambert {
                albedo: DVec3::splat(albedo),
            },
            1.0 - albedo,
        );
        Ok(())
    }
}

/// Adds the cube [−h, h]³ as one indexed mesh, fronts inside or outside.
pub fn closed_cube(scene: &mut SceneBuilder, half: f64, inward: bool, surface: SurfaceId) {
    let (vertices, triangles) = cuboid(DVec3::splat(-half), DVec3::splat(half), inward);
    scene.mesh(&vertices, &triangles, surface);
}
