//! Scenes whose images have closed-form means, for estimators that trace particles to the camera.

use whitefurnace::error::Error;
use whitefurnace::scene::room;
use whitefurnace::scene::simple::{Cap, cavity_cap, cornell};

use crate::prelude::*;
use crate::scenes::{
    FLOOR, HEIGHT, LIGHT, NEAR, RECTANGLE, TINT, ball, floor, hollow, lambert, light, mirror,
    panel, polygon_irradiance, seen_by, sphere_irradiance, square, valid,
};

/// A scene, and the mean radiance of its image in closed form.
pub struct KnownImage {
    /// The scene, with its camera.
    pub scene: Arc<Scene>,
    /// Mean radiance over the image.
    pub mean: f64,
}

/// Returns a camera that looks straight down from (x, y, z). The image shows the floor z = 0 from
/// −`half` z to `half` z in height.
fn overhead(eye: DVec3, half: f64) -> Camera {
    Camera::new(eye, eye - DVec3::Z, DVec3::Y, half)
}

/// Position of the cameras over floors: off the axis of the light.
const EYE: DVec3 = DVec3::new(0.1, -0.2, 1.5);
/// Half height of their images at distance 1; the frame is square.
const HALF: f64 = 3.0;

/// Mean radiance over the image of a floor at height 0 that reflects the fraction `share` of an
/// irradiance given as E/L. An overhead image shows equal areas of the floor in equal areas. `half`
/// are the half sides of the visible floor.
fn floor_mean(eye: DVec3, [x, y]: [f64; 2], share: f64, irradiance: &dyn Fn(DVec3) -> f64) -> f64 {
    let at = |p: DVec3| {
        let offset = DVec3::new((2.0 * p.x - 1.0) * x, (2.0 * p.y - 1.0) * y, 0.0);
        irradiance(eye.with_z(0.0) + offset)
    };
    share * FRAC_1_PI * LIGHT * Domain::Square.integrate_all(1e-7, &at).value
}

/// Irradiance E/L of a polygon at a point of the floor.
fn polygon_at(vertices: &[DVec3], x: DVec3) -> f64 {
    let shifted: Vec<DVec3> = vertices.iter().map(|vertex| *vertex - x).collect();
    polygon_irradiance(&shifted)
}

/// A square light over a Lambert floor, and the mean of the image, which is dark if the light faces
/// up.
pub fn rectangle(up: bool) -> KnownImage {
    let scene = seen_by(overhead(EYE, HALF), "rectangle from above", |s| {
        floor(s, lambert(FLOOR));
        square(s, HEIGHT * DVec3::Z, 1.0, up, light(LIGHT));
    });
    let half = [EYE.z * HALF; 2];
    let mean = floor_mean(EYE, half, FLOOR, &|x| polygon_at(&RECTANGLE, x));
    KnownImage {
        scene,
        mean: if up { 0.0 } else { mean },
    }
}

/// A light so near and large that most directions from the floor hit it, and the mean of the image.
pub fn near() -> KnownImage {
    let eye = EYE.with_z(0.5);
    let scene = seen_by(overhead(eye, 1.0), "near light from above", |s| {
        floor(s, lambert(FLOOR));
        square(s, NEAR[0].z * DVec3::Z, NEAR[2].x, false, light(LIGHT));
    });
    let mean = floor_mean(eye, [eye.z; 2], FLOOR, &|x| polygon_at(&NEAR, x));
    KnownImage { scene, mean }
}

/// A whole sphere as a light over the floor, and the mean of the image.
pub fn sphere() -> KnownImage {
    let (centre, radius) = (HEIGHT * DVec3::Z, 0.5);
    let scene = seen_by(overhead(EYE, HALF), "sphere from above", |s| {
        floor(s, lambert(FLOOR));
        ball(s, Sphere::new(centre, radius), light(LIGHT));
    });
    let mean = floor_mean(EYE, [EYE.z * HALF; 2], FLOOR, &|x| {
        let distance = centre.distance(x);
        sphere_irradiance(radius, distance, HEIGHT / distance)
    });
    KnownImage { scene, mean }
}

/// Reflectance of the mirror of [`mirror_caustic`].
const REFLECTANCE: f64 = 0.9;

/// A light that faces up under a mirror at height 1, which reflects it onto a patch of Lambert
/// floor, and the mean of the image. The line from a patch point y to a point y' of the light's
/// mirror image at height 1.1 crosses the mirror at y + (y' − y)/1.1, between −0.64 and −0.35, and
/// passes beside the light. A line from the patch to its own mirror image would cross at positive
/// y, where the mirror is not.
pub fn mirror_caustic() -> KnownImage {
    let eye = DVec3::new(0.0, 1.05, 0.8);
    let half = [2.25, 0.9];
    let corner = DVec3::new(-0.5, -0.7, 0.9);
    let (width, depth) = (DVec3::X, 0.1 * DVec3::Y);
    let scene = seen_by(overhead(eye, half[1] / eye.z), "mirror caustic", |s| {
        let sides = [4.6 * DVec3::X, 2.0 * DVec3::Y];
        let patch = Surface::new(lambert(FLOOR));
        panel(s, DVec3::new(-2.3, 0.05, 0.0), sides, patch);
        panel(s, corner, [width, depth], light(LIGHT));
        let sides = [2.0 * DVec3::X, 0.4 * DVec3::Y];
        let mirror = Surface::new(mirror(REFLECTANCE));
        panel(s, DVec3::new(-1.0, -0.7, 1.0), sides, mirror);
    });
    let image = corner.with_z(2.0 - corner.z);
    let image = [image, image + width, image + width + depth, image + depth];
    let mean = floor_mean(eye, half, FLOOR * REFLECTANCE, &|x| polygon_at(&image, x));
    KnownImage { scene, mean }
}

/// Index of the glass of [`in_glass`].
const INDEX: f64 = 1.5;
/// Albedo of the ball within the glass of [`in_glass`].
const BALL: f64 = 0.25;

/// Thermal equilibrium with glass: a wall of radiance 1 around a glass ball, and in its middle a
/// ball that emits what it does not reflect, (1 − ρ) n². The camera within the glass sees n² along
/// every ray: the inner ball is smaller than the glass divided by n, so that nothing from it is
/// reflected totally.
///
/// Returns the scene, n², and the fraction of its square image that shows the ball, a disc of
/// radius tan β with sin β = 1/3. A light tracer sees nothing else.
pub fn in_glass() -> (Arc<Scene>, f64, f64) {
    let (half, squared_tangent) = (0.36, 0.125);
    let scene = seen_by(overhead(0.9 * DVec3::Z, half), "in glass", |s| {
        hollow(s, 1.0, light(1.0));
        let glass = Surface::new(Bsdf::Glass { index: INDEX });
        ball(s, Sphere::new(DVec3::ZERO, 0.95), glass);
        let emission = (1.0 - BALL) * INDEX * INDEX * TINT;
        let surface = Surface::new(lambert(BALL)).emitting(emission);
        ball(s, Sphere::new(DVec3::ZERO, 0.3), surface);
    });
    let share = PI * squared_tangent / (4.0 * half * half);
    (scene, INDEX * INDEX, share)
}

/// An emitting plane that more than fills an image three times as wide as high, up to 78° off the
/// axis, and its radiance.
pub fn emitting_plane() -> KnownImage {
    let scene = seen_by(overhead(DVec3::Z, 1.5), "emitting plane", |s| {
        let sides = [9.2 * DVec3::X, 3.2 * DVec3::Y];
        panel(s, DVec3::new(-4.6, -1.6, 0.0), sides, light(LIGHT));
    });
    KnownImage { scene, mean: LIGHT }
}

/// A sphere of radius 1 that emits 1 and reflects `albedo`, seen from within.
pub fn sphere_furnace(albedo: f64) -> Arc<Scene> {
    seen_by(inside(), "sphere furnace from within", |s| {
        let wall = Surface::new(lambert(albedo)).emitting(DVec3::ONE);
        hollow(s, 1.0, wall);
    })
}

/// Returns a camera that looks down from within a sphere of radius 1. A square image shows only
/// what lies below height 0.
fn inside() -> Camera {
    overhead(DVec3::new(0.3, -0.5, 0.1), 1.0)
}

/// The cavity with a cap, seen from within and off the cap.
pub fn cavity(albedo: f64, cap: Cap) -> Arc<Scene> {
    seen_anew(cavity_cap(albedo, cap), inside())
}

/// The all-diffuse room without its light in sight, and with more of its red walls than of others.
pub fn diffuse_room() -> Arc<Scene> {
    let target = DVec3::new(5.0, -5.0, -3.0);
    let camera = Camera::new(DVec3::new(12.5, 0.0, 0.0), target, DVec3::Z, 0.5);
    seen_anew(room::diffuse(), camera)
}

/// The Cornell box from just under its ceiling, without the light in sight.
pub fn cornell_box() -> Arc<Scene> {
    let eye = DVec3::new(2.78, 5.0, 0.2);
    let target = DVec3::new(2.78, 0.0, 4.0);
    seen_anew(cornell(), Camera::new(eye, target, DVec3::Y, 0.8))
}

/// Gives a scene another camera.
fn seen_anew(scene: Result<Scene, Error>, camera: Camera) -> Arc<Scene> {
    valid(scene.and_then(|scene| scene.with_camera(camera)))
}
