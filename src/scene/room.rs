//! The report's room: one geometry, three conventions, and its all-diffuse variant, from
//! `files/report.toml` and `files/diffuse-room.toml`. The conventions differ only in light
//! transport and display.

use glam::DVec3;

use super::Scene;
use super::file::Description;
use crate::error::Error;
use crate::geometry::shape::Sphere;
use crate::material::{Bsdf, OrenNayarForm};

/// Convention of light transport and display in the room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Convention {
    /// Energy-consistent: the base of every statistical claim.
    #[default]
    Physical,
    /// Light transport as the report's text describes it.
    Report,
    /// A hypothesis about the program that made the published figure 6.
    Published,
}

/// Albedo of the white sphere, chosen so that its brightness meets figure 6.
pub const WHITE: f64 = 0.55;
/// σ of the white sphere's Oren-Nayar model, radians; the report states none.
pub const SIGMA: f64 = 0.3;
/// Reflection coefficient of the room's surfaces: albedo = colour × this.
const COEFFICIENT: f64 = 0.75;

/// The white sphere.
pub const WHITE_SPHERE: Sphere = Sphere {
    centre: DVec3::new(0.0, 1.5, 0.0),
    radius: 1.5,
    zone: [f64::NEG_INFINITY, f64::INFINITY],
    inward: false,
};

/// Colours of the walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Walls {
    /// Colours of the report's figures.
    #[default]
    Coloured,
    /// Grey of the same luminance each.
    Grey,
}

/// Builds the report's final scene under a convention.
///
/// # Errors
/// None for the numbers here; the type is that of
/// [`SceneBuilder::build`](super::SceneBuilder::build).
pub fn report(convention: Convention, form: OrenNayarForm) -> Result<Scene, Error> {
    report_with(convention, form, Walls::default())
}

/// Builds the scene of [`report`] with walls of either kind.
///
/// # Errors
/// Those of [`report`].
pub fn report_with(
    convention: Convention,
    form: OrenNayarForm,
    walls: Walls,
) -> Result<Scene, Error> {
    let white = match convention {
        // The authors' white sphere never absorbs; its extra cosine is in the estimator.
        Convention::Published => Bsdf::oren_nayar(DVec3::ONE, 0.0, form),
        Convention::Physical | Convention::Report => {
            Bsdf::oren_nayar(DVec3::splat(WHITE), SIGMA, form)
        }
    };
    with_white_sphere(white, walls)
}

/// Builds the report's final scene with any reflection model on the white sphere, and walls of
/// either kind.
///
/// # Errors
/// A model that [`SceneBuilder::build`](super::SceneBuilder::build) refuses.
pub fn with_white_sphere(white: Bsdf, walls: Walls) -> Result<Scene, Error> {
    let mut room = Description::parse("report", include_str!("files/report.toml"))?;
    room.surface("white")?.bsdf = white;
    painted(room, walls)
}

/// Builds the report's room with Lambert albedo 0.5 for mirror and glass objects and 0.55 for the
/// white sphere, for methods that support only diffuse surfaces.
///
/// # Errors
/// Those of [`report`].
pub fn diffuse() -> Result<Scene, Error> {
    diffuse_with(Walls::default())
}

/// Builds the scene of [`diffuse`] with walls of either kind.
///
/// # Errors
/// Those of [`report`].
pub fn diffuse_with(walls: Walls) -> Result<Scene, Error> {
    painted(
        Description::parse("diffuse-room", include_str!("files/diffuse-room.toml"))?,
        walls,
    )
}

/// Builds the room with walls of either kind.
fn painted(mut room: Description, walls: Walls) -> Result<Scene, Error> {
    if walls == Walls::Grey {
        for wall in ["blue", "red", "green", "magenta", "cyan", "yellow"] {
            let surface = room.surface(wall)?;
            let grey = luminance(surface.bsdf.albedo() / COEFFICIENT) * COEFFICIENT;
            surface.bsdf = Bsdf::Lambert {
                albedo: DVec3::splat(grey),
            };
        }
    }
    room.build()
}

/// Returns the luminance of a colour with the primaries of ITU-R BT.709.
fn luminance(colour: DVec3) -> f64 {
    0.2126 * colour.x + 0.7152 * colour.y + 0.0722 * colour.z
}
