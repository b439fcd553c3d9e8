//! The report's room: one geometry, three conventions, and its all-diffuse variant.
//!
//! Units are metres-like, z is up. The conventions differ only in light transport and display.

use glam::DVec3;

use super::{Scene, SceneBuilder, Surface, SurfaceId};
use crate::bsdf::{Bsdf, OrenNayarForm};
use crate::camera::Camera;
use crate::error::Error;
use crate::shape::Sphere;

/// How light travels in the room and how it is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Convention {
    /// Energy-consistent: the base of every statistical claim.
    #[default]
    Physical,
    /// What the report's text describes.
    Report,
    /// A hypothesis about the program that made the published figure 6.
    Published,
}

/// Radiance of the light.
pub const LIGHT: f64 = 50.0;
/// Reflection coefficient of the room's surfaces: albedo = colour × this.
pub(crate) const COEFFICIENT: f64 = 0.75;
/// Albedo of the white sphere, chosen so that its brightness meets figure 6.
pub const WHITE: f64 = 0.55;
/// σ of the white sphere's Oren-Nayar model, radians; the report states none.
pub const SIGMA: f64 = 0.3;
/// Refractive index of the glass sphere.
pub const GLASS: f64 = 1.5;
/// Half the image's height at distance 1 (75.70° vertically), which meets figure 6 to the pixel.
pub const HALF_HEIGHT: f64 = 0.77704;

/// Where the white sphere is.
pub const WHITE_SPHERE: Sphere =
    Sphere { centre: DVec3::new(0.0, 1.5, 0.0), radius: 1.5, zone: [f64::NEG_INFINITY, f64::INFINITY], inward: false };

const FLOOR: f64 = -5.0;
const CEILING: f64 = 5.0;
/// The floor's outline, counter-clockwise seen from above.
const OUTLINE: [[f64; 2]; 6] = [[-3.0, 0.0], [0.0, -6.0], [10.0, -6.0], [13.0, 0.0], [10.0, 6.0], [0.0, 6.0]];
/// Colour of the wall from each corner of the outline to the next.
const WALLS: [[f64; 3]; 6] =
    [[0.157, 0.208, 0.576], [1.0, 0.25, 0.25], [0.0, 1.0, 0.5], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 0.0]];

/// Luminance of a colour with the primaries of ITU-R BT.709.
fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The colours of the walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Walls {
    /// As in the report's figures.
    #[default]
    Coloured,
    /// Grey of the same luminance each.
    Grey,
}

/// The materials of the four objects.
struct Objects {
    mirror: Bsdf,
    glass: Bsdf,
    white: Bsdf,
}

/// The report's final scene under a convention.
///
/// # Errors
/// None for the numbers above; the type is that of [`SceneBuilder::build`].
pub fn report(convention: Convention, form: OrenNayarForm) -> Result<Scene, Error> {
    report_with(convention, form, Walls::default())
}

/// [`report`] with walls of either kind.
///
/// # Errors
/// As [`report`].
pub fn report_with(convention: Convention, form: OrenNayarForm, walls: Walls) -> Result<Scene, Error> {
    let white = match convention {
        // The authors' white sphere never absorbs; its extra cosine is the estimator's doing.
        Convention::Published => Bsdf::oren_nayar(DVec3::ONE, 0.0, form),
        Convention::Physical | Convention::Report => Bsdf::oren_nayar(DVec3::splat(WHITE), SIGMA, form),
    };
    with_white_sphere(white, walls)
}

/// The report's final scene with any reflection model on the white sphere, and walls of either kind.
///
/// # Errors
/// A model that [`SceneBuilder::build`] refuses.
pub fn with_white_sphere(white: Bsdf, walls: Walls) -> Result<Scene, Error> {
    let objects =
        Objects { mirror: Bsdf::Mirror { reflectance: DVec3::ONE }, glass: Bsdf::Glass { index: GLASS }, white };
    room("report", &objects, walls)
}

/// The same room with Lambert albedo 0.5 for mirror and glass objects and 0.55 for the white sphere,
/// for methods that handle only diffuse surfaces.
///
/// # Errors
/// As [`report`].
pub fn diffuse() -> Result<Scene, Error> {
    diffuse_with(Walls::default())
}

/// [`diffuse`] with walls of either kind.
///
/// # Errors
/// As [`report`].
pub fn diffuse_with(walls: Walls) -> Result<Scene, Error> {
    let lambert = |albedo: f64| Bsdf::Lambert { albedo: DVec3::splat(albedo) };
    let objects = Objects { mirror: lambert(0.5), glass: lambert(0.5), white: lambert(WHITE) };
    room("diffuse-room", &objects, walls)
}

fn room(name: &str, objects: &Objects, walls: Walls) -> Result<Scene, Error> {
    let mut scene = SceneBuilder::new(name);
    shell(&mut scene, walls);
    let light = scene.surface(Surface::new(Bsdf::Black).emitting(DVec3::splat(LIGHT)));
    scene.rectangle(DVec3::new(3.0, -1.0, 4.999), [DVec3::new(0.0, 2.0, 0.0), DVec3::new(2.0, 0.0, 0.0)], light);
    let mirror = scene.surface(Surface::new(objects.mirror));
    let glass = scene.surface(Surface::new(objects.glass));
    let white = scene.surface(Surface::new(objects.white));
    scene.sphere(Sphere::new(DVec3::new(2.5, 4.0, -2.0), 2.0), mirror);
    scene.sphere(Sphere::new(DVec3::new(3.25, -0.5, -3.0), 2.0), glass);
    scene.sphere(WHITE_SPHERE, white);
    let corner = DVec3::new(0.0, -6.0, FLOOR);
    let tips = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| corner + 4.0 * axis);
    scene.mesh(&[corner, tips[0], tips[1], tips[2]], &[[1, 2, 3], [0, 2, 1], [0, 1, 3], [0, 3, 2]], mirror);
    let eye = DVec3::new(12.5, 0.0, 0.0);
    scene.build(Camera::new(eye, eye - DVec3::X, DVec3::Z, HALF_HEIGHT))
}

/// Floor, ceiling and walls as one closed set of triangles with their fronts inside: neighbours share
/// the very same coordinates.
fn shell(scene: &mut SceneBuilder, walls: Walls) {
    let ring = |z: f64| OUTLINE.map(|[x, y]| DVec3::new(x, y, z));
    let vertices: Vec<DVec3> = ring(FLOOR).into_iter().chain(ring(CEILING)).collect();
    let mut diffuse = |colour: [f64; 3]| -> SurfaceId {
        let albedo = DVec3::from_array(colour) * COEFFICIENT;
        scene.surface(Surface::new(Bsdf::Lambert { albedo }).absorbing(1.0 - COEFFICIENT))
    };
    let white = diffuse([1.0; 3]);
    let walls = WALLS.map(|colour| {
        diffuse(match walls {
            Walls::Coloured => colour,
            Walls::Grey => [luminance(colour); 3],
        })
    });
    let floor: Vec<[u32; 3]> = (1..5).map(|i| [0, i, i + 1]).collect();
    let ceiling: Vec<[u32; 3]> = (1..5).map(|i| [6, 7 + i, 6 + i]).collect();
    scene.mesh(&vertices, &floor, white);
    scene.mesh(&vertices, &ceiling, white);
    for (i, wall) in (0u32..).zip(walls) {
        let next = (i + 1) % 6;
        let triangles = [[i, i + 6, next + 6], [i, next + 6, next]];
        scene.mesh(&vertices, &triangles, wall);
    }
}
