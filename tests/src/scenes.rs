//! Small scenes for the trials of whole estimators, in metres, z up, each with a closed-form
//! answer.

use whitefurnace::error::Error;
use whitefurnace::light::emitter::Emitter;
use whitefurnace::material::OrenNayarForm;
use whitefurnace::math::frame::from_spherical;

use crate::prelude::*;

/// Height of the 2 × 2 light above the origin.
pub const HEIGHT: f64 = 2.0;
/// Radiance of lights: not 1, so that a missing or squared radiance shows.
pub const LIGHT: f64 = 3.0;
/// Albedo of the floors.
pub const FLOOR: f64 = 0.8;

/// Returns Lambert with the same albedo in all channels.
pub fn lambert(albedo: f64) -> Bsdf {
    Bsdf::Lambert {
        albedo: DVec3::splat(albedo),
    }
}

/// Returns a mirror with the same reflectance in all channels.
pub fn mirror(reflectance: f64) -> Bsdf {
    Bsdf::Mirror {
        reflectance: DVec3::splat(reflectance),
    }
}

/// Colour of the lights: powers of two, so that every channel is exactly that of a white light
/// times its own factor.
pub const TINT: DVec3 = DVec3::new(1.0, 0.5, 2.0);

/// Returns a black surface that emits; `radiance` is that of the first channel.
pub fn light(radiance: f64) -> Surface {
    Surface::new(Bsdf::Black).emitting(radiance * TINT)
}

/// Reduces a radiance (or flux) to one number that depends on every channel: the mean of the
/// channels in units of the colour of the scene's first emitter, white if there is none. Exchanged
/// or mixed channels raise it.
pub fn mean_channel(scene: &Scene, radiance: DVec3) -> f64 {
    let tint = |emitter: &Emitter| emitter.radiance / emitter.radiance.x;
    let tint = scene.emitters().first().map_or(DVec3::ONE, tint);
    (radiance / tint).element_sum() / 3.0
}

/// Builds a scene whose numbers are known to be valid.
///
/// # Panics
/// If they are not, which is a mistake in a trial.
pub fn scene(name: &str, parts: impl FnOnce(&mut SceneBuilder)) -> Arc<Scene> {
    let camera = Camera::new(DVec3::new(0.3, -1.0, 1.2), DVec3::ZERO, DVec3::Z, 0.4);
    seen_by(camera, name, parts)
}

/// Builds a scene as [`scene`] does, with a camera of its own.
///
/// # Panics
/// If the numbers are not valid.
pub fn seen_by(camera: Camera, name: &str, parts: impl FnOnce(&mut SceneBuilder)) -> Arc<Scene> {
    let mut builder = SceneBuilder::new(name);
    parts(&mut builder);
    valid(builder.build(camera))
}

/// Builds an empty scene, seen along y. In an image of this size pixels have side 1 at distance 1.
pub fn nothing(size: [u32; 2]) -> Arc<Scene> {
    let half_height = 0.5 * f64::from(size[1]);
    let camera = Camera::new(DVec3::ZERO, DVec3::Y, DVec3::Z, half_height);
    seen_by(camera, "nothing", |_| {})
}

/// Unwraps a scene whose numbers are known to be valid.
///
/// # Panics
/// If they are not.
pub fn valid(scene: Result<Scene, Error>) -> Arc<Scene> {
    Arc::new(scene.unwrap_or_else(|error| panic!("{error}")))
}

/// Adds a parallelogram with a surface of its own.
pub fn panel(builder: &mut SceneBuilder, corner: DVec3, edges: [DVec3; 2], surface: Surface) {
    let surface = builder.surface(surface);
    builder.rectangle(corner, edges, surface);
}

/// Adds a sphere with a surface of its own.
pub fn ball(builder: &mut SceneBuilder, sphere: Sphere, surface: Surface) {
    let surface = builder.surface(surface);
    builder.sphere(sphere, surface);
}

/// Adds a sphere around the origin whose front is inside.
pub fn hollow(builder: &mut SceneBuilder, radius: f64, surface: Surface) {
    ball(
        builder,
        Sphere {
            inward: true,
            ..Sphere::new(DVec3::ZERO, radius)
        },
        surface,
    );
}

/// Adds a horizontal square of half side `half` around `centre`, whose front is above or below.
pub fn square(builder: &mut SceneBuilder, centre: DVec3, half: f64, up: bool, surface: Surface) {
    let [x, y] = [DVec3::X, DVec3::Y].map(|axis| 2.0 * half * axis);
    panel(
        builder,
        centre - 0.5 * (x + y),
        if up { [x, y] } else { [y, x] },
        surface,
    );
}

/// Adds a floor that reflects by `bsdf`, its front up.
pub fn floor(builder: &mut SceneBuilder, bsdf: Bsdf) {
    square(builder, DVec3::ZERO, 50.0, true, Surface::new(bsdf));
}

/// Builds the light of side 2 at [`HEIGHT`] over a Lambert floor.
pub fn rectangle_light(up: bool) -> Arc<Scene> {
    scene("rectangle light", |s| {
        floor(s, lambert(FLOOR));
        square(s, HEIGHT * DVec3::Z, 1.0, up, light(LIGHT));
    })
}

/// The corners of the light of [`rectangle_light`], counter-clockwise seen from above.
pub const RECTANGLE: [DVec3; 4] = level_square(1.0, HEIGHT);

/// The corners of a light so near and large that most directions hit it.
pub const NEAR: [DVec3; 4] = level_square(2.0, 0.6);

/// Returns the corners of a horizontal square around the z axis.
const fn level_square(half: f64, z: f64) -> [DVec3; 4] {
    let corner = DVec3::new;
    [
        corner(-half, -half, z),
        corner(half, -half, z),
        corner(half, half, z),
        corner(-half, half, z),
    ]
}

/// Builds the light [`NEAR`] over the floor.
pub fn near_light() -> Arc<Scene> {
    scene("near light", |s| {
        floor(s, lambert(FLOOR));
        square(s, 0.6 * DVec3::Z, 2.0, false, light(LIGHT));
    })
}

/// A slanted triangle that faces the origin.
pub const TRIANGLE: [DVec3; 3] = [
    DVec3::new(1.0, -0.5, 1.5),
    DVec3::new(0.5, 1.0, 2.0),
    DVec3::new(2.0, 0.5, 1.0),
];

/// Builds [`TRIANGLE`] as a light over the floor.
pub fn triangle_light() -> Arc<Scene> {
    scene("triangle light", |s| {
        floor(s, lambert(FLOOR));
        triangle(s, &TRIANGLE, light(LIGHT));
    })
}

/// Adds one triangle with a surface of its own.
pub fn triangle(builder: &mut SceneBuilder, vertices: &[DVec3; 3], surface: Surface) {
    let surface = builder.surface(surface);
    builder.mesh(vertices, &[[0, 1, 2]], surface);
}

/// Builds a spherical light of radius 1/2 at distance 2 overhead; only the zone that the origin
/// sees exists and emits.
pub fn sphere_light() -> Arc<Scene> {
    scene("sphere light", |s| {
        floor(s, lambert(FLOOR));
        add_sphere(s, 2.0 * DVec3::Z, LIGHT);
    })
}

fn add_sphere(builder: &mut SceneBuilder, centre: DVec3, radiance: f64) {
    let zone = [f64::NEG_INFINITY, -0.5 * 0.5 / centre.length()];
    ball(
        builder,
        Sphere {
            zone,
            ..Sphere::new(centre, 0.5)
        },
        light(radiance),
    );
}

/// Irradiance E/L of a sphere wholly above the horizon: π R²/d² times the cosine at the receiver.
pub fn sphere_irradiance(radius: f64, distance: f64, cosine: f64) -> f64 {
    PI * (radius / distance).powi(2) * cosine
}

/// Builds three lights of different shape, size and radiance that do not hide each other from the
/// origin.
pub fn three_lights() -> Arc<Scene> {
    scene("three lights", |s| {
        floor(s, lambert(FLOOR));
        triangle(s, &TRIANGLE, light(0.5 * LIGHT));
        add_sphere(s, 2.0 * DVec3::Z, 2.0 * LIGHT);
        square(s, SMALL_LIGHT, 0.4, false, light(4.0 * LIGHT));
    })
}

/// Returns the probabilities with which white lights of these fluxes are picked: one half of the
/// picks by flux, the other uniformly.
pub fn pick_probabilities(fluxes: &[f64]) -> Vec<f64> {
    let (sum, count) = (fluxes.iter().sum::<f64>(), fluxes.len() as f64);
    fluxes
        .iter()
        .map(|flux| 0.5 * flux / sum + 0.5 / count)
        .collect()
}

/// Centre of the small square light of [`three_lights`].
pub const SMALL_LIGHT: DVec3 = DVec3::new(-1.5, -0.5, 1.5);

/// Returns the corners of a horizontal square.
pub fn corners(centre: DVec3, half: f64) -> [DVec3; 4] {
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, y]| centre + half * DVec3::new(x, y, 0.0))
}

/// Builds the rectangle light with a black wall that hides its half y > 0 from the origin exactly.
pub fn half_hidden_light() -> Arc<Scene> {
    scene("half hidden light", |s| {
        floor(s, lambert(FLOOR));
        square(s, HEIGHT * DVec3::Z, 1.0, false, light(LIGHT));
        panel(
            s,
            DVec3::new(-2.0, 0.0, 1.0),
            [4.0 * DVec3::X, 2.0 * DVec3::Y],
            Surface::new(Bsdf::Black),
        );
    })
}

/// Builds a white floor under a sky of radiance 1, partly hidden by a black wall at y = 1.
pub fn walled_sky() -> Arc<Scene> {
    scene("walled sky", |s| {
        s.background(DVec3::ONE);
        floor(s, lambert(1.0));
        panel(
            s,
            WALL[0],
            [4.0 * DVec3::X, 3.0 * DVec3::Z],
            Surface::new(Bsdf::Black),
        );
    })
}

/// The wall of [`walled_sky`].
pub const WALL: [DVec3; 4] = [
    DVec3::new(-1.0, 1.0, 0.0),
    DVec3::new(3.0, 1.0, 0.0),
    DVec3::new(3.0, 1.0, 3.0),
    DVec3::new(-1.0, 1.0, 3.0),
];

/// σ of [`rough_floor`], radians.
pub const SIGMA: f64 = 0.5;

/// Builds a white Oren-Nayar floor under a sky of radiance 1.
pub fn rough_floor() -> Arc<Scene> {
    scene("rough floor", |s| {
        s.background(DVec3::ONE);
        floor(
            s,
            Bsdf::oren_nayar(DVec3::ONE, SIGMA, OrenNayarForm::Corrected),
        );
    })
}

/// Builds a floor of EON with roughness 1 under a sky of radiance 1.
pub fn eon_floor(albedo: f64) -> Arc<Scene> {
    scene("EON floor", |s| {
        s.background(DVec3::ONE);
        floor(
            s,
            Bsdf::Eon {
                albedo: DVec3::splat(albedo),
                roughness: 1.0,
            },
        );
    })
}

/// Returns a ray to the origin from an inclination of 25°.
pub fn ray_to_origin() -> Ray {
    ray_to_origin_from(0.5)
}

/// Returns a ray to the origin from an inclination of 25° and this distance.
pub fn ray_to_origin_from(distance: f64) -> Ray {
    let w = from_spherical(25f64.to_radians(), 4.0);
    Ray::new(distance * w, -w)
}

/// Returns a ray to the origin from an inclination, radians, in a plane of no symmetry.
pub fn ray_to_origin_at(inclination: f64) -> Ray {
    let w = from_spherical(inclination, 4.0);
    Ray::new(0.5 * w, -w)
}

/// Irradiance E/L of a polygon seen from the origin with normal z, wholly above the horizon: half
/// the angle of each side times the height of its plane's normal, summed (Lambert 1760). Written
/// here, not taken from the code under test.
pub fn polygon_irradiance(vertices: &[DVec3]) -> f64 {
    let seen: Vec<DVec3> = vertices.iter().map(|v| v.normalize()).collect();
    let side = |i: usize| {
        let [a, b] = [seen[i], seen[(i + 1) % seen.len()]];
        // Kahan's formula for half of an angle.
        let half_angle = (a - b).length().atan2((a + b).length());
        half_angle * a.cross(b).normalize_or_zero().z
    };
    (0..seen.len()).map(side).sum::<f64>().abs()
}

/// Builds a spherical furnace of radius 1: every wall emits 1 and reflects by `bsdf`.
pub fn sphere_furnace(bsdf: Bsdf, absorption: f64) -> Arc<Scene> {
    let wall = Surface::new(bsdf)
        .emitting(DVec3::ONE)
        .absorbing(absorption);
    scene("sphere furnace", |s| hollow(s, 1.0, wall))
}
