//! Scenes in which photons have closed-form answers, in metres, z up.

use std::f64::consts::FRAC_PI_2;

use whitefurnace::harness::quadrature::{Rectangle, integrate};

use crate::glass::GLASS;
use crate::prelude::*;
use crate::scenes::{
    FLOOR, LIGHT, ball, corners, floor, hollow, lambert, light, panel, polygon_irradiance,
    ray_to_origin_from, scene, seen_by, square,
};

/// Height and half side of the light over the floor: most of its particles land within [`RADIUS`].
const CENTRE: DVec3 = DVec3::new(0.0, 0.0, 0.5);
const HALF: f64 = 0.2;
/// Radius of the lookups around the origin, so large that the irradiance varies over the disc.
pub const RADIUS: f64 = 2.0;
/// x of the wall of [`corner`].
pub const WALL_AT: f64 = 1.0;
/// Albedo of that wall: its contribution to the floor is a hundredth of δ.
const WALL_ALBEDO: f64 = 1e-4;

fn low_light(builder: &mut SceneBuilder) {
    square(builder, CENTRE, HALF, false, light(LIGHT));
}

/// Returns a ray to the origin from close by, below the light and the glass around it.
pub fn ray_to_origin() -> Ray {
    ray_to_origin_from(0.04)
}

/// Builds a small light just over the floor.
pub fn over_floor() -> Arc<Scene> {
    scene("low light", |s| {
        floor(s, lambert(FLOOR));
        low_light(s);
    })
}

/// Builds the small light under the floor, whose upper side stays dark.
pub fn under_floor() -> Arc<Scene> {
    scene("light below", |s| {
        floor(s, lambert(FLOOR));
        square(s, -CENTRE, HALF, true, light(LIGHT));
    })
}

/// Builds the small light over the floor beside a wall that reflects almost nothing.
pub fn corner() -> Arc<Scene> {
    scene("corner", |s| {
        floor(s, lambert(FLOOR));
        low_light(s);
        let wall = Surface::new(lambert(WALL_ALBEDO));
        panel(
            s,
            DVec3::new(WALL_AT, -3.0, 0.0),
            [3.0 * DVec3::Z, 6.0 * DVec3::Y],
            wall,
        );
    })
}

/// Builds the small light within a sphere of glass of index 1: all its photons are caustic photons.
pub fn matched() -> Arc<Scene> {
    scene("index-matched sphere", |s| {
        floor(s, lambert(FLOOR));
        low_light(s);
        ball(
            s,
            Sphere::new(CENTRE, 0.45),
            Surface::new(Bsdf::Glass { index: 1.0 }),
        );
    })
}

/// Radiance that the floor under the light reflects, averaged over the disc of this radius around
/// the origin, of which only the part x < `end` exists; E/L is that of Lambert's polygon.
pub fn disc_average(radius: f64, end: f64) -> f64 {
    let vertices = corners(CENTRE, HALF);
    let irradiance =
        |x: f64, y: f64| polygon_irradiance(&vertices.map(|v| v - DVec3::new(x, y, 0.0)));
    // x = r sin t and y = s r cos t make a smooth integrand of the disc.
    let domain = Rectangle {
        x: [-FRAC_PI_2, (end / radius).min(1.0).asin()],
        y: [-1.0, 1.0],
    };
    let mut f = |t: f64, s: f64| {
        let half = radius * t.cos();
        half * half * irradiance(radius * t.sin(), s * half)
    };
    let sum = integrate(domain, 1e-9, &mut f).value;
    FLOOR / PI * LIGHT * sum / (PI * radius * radius)
}

/// Radiance that the floor reflects of the light at the origin.
pub fn at_point() -> f64 {
    FLOOR / PI * LIGHT * polygon_irradiance(&corners(CENTRE, HALF))
}

/// Builds the floor and the light, seen by a camera whose pixel is but a point, the origin.
pub fn point_camera() -> Arc<Scene> {
    let camera = Camera::new(DVec3::new(0.3, -0.1, 0.2), DVec3::ZERO, DVec3::Z, 1e-9);
    seen_by(camera, "low light, one point", |s| {
        floor(s, lambert(FLOOR));
        low_light(s);
    })
}

/// Distance of the light of [`glass_in_cavity`] from the centre of the glass, and half of its side.
const GLASS_DISTANCE: f64 = 1.06;
const GLASS_LIGHT: f64 = 0.05;

/// Builds a cavity with a glass sphere of radius 1 and a small light over it. Cavity and light are
/// Lambert surfaces of albedo 0, so that photons are stored and end there.
pub fn glass_in_cavity() -> Arc<Scene> {
    scene("glass in a cavity", |s| {
        hollow(s, 4.0, Surface::new(lambert(0.0)));
        ball(s, Sphere::new(DVec3::ZERO, 1.0), Surface::new(GLASS));
        let light = Surface::new(lambert(0.0)).emitting(DVec3::splat(LIGHT));
        square(s, GLASS_DISTANCE * DVec3::Z, GLASS_LIGHT, false, light);
    })
}

/// Flux that the light of [`glass_in_cavity`] sends into the sphere, all of which leaves it again:
/// the mean over the light of the form factor cos θ/d² of a unit sphere at distance d, times π L A.
pub fn flux_into_glass() -> f64 {
    let domain = Rectangle {
        x: [-GLASS_LIGHT, GLASS_LIGHT],
        y: [-GLASS_LIGHT, GLASS_LIGHT],
    };
    let mut factor = |x: f64, y: f64| {
        let d2 = x * x + y * y + GLASS_DISTANCE * GLASS_DISTANCE;
        GLASS_DISTANCE / (d2 * d2.sqrt())
    };
    PI * LIGHT * integrate(domain, 1e-12, &mut factor).value
}

/// Radius of the disc around the origin that the caustic of [`caustic`] covers.
pub const CAUSTIC: f64 = 0.5;

/// Builds a sphere of glass of this index between a floor and an area light: a caustic that paths
/// from the eye find, too. At index 1 the glass is invisible.
pub fn caustic(index: f64) -> Arc<Scene> {
    floor_under_area_light("caustic", |s| {
        ball(
            s,
            Sphere::new(DVec3::new(0.0, 0.0, 0.6), 0.5),
            Surface::new(Bsdf::Glass { index }),
        );
    })
}

/// Builds the floor and the light of [`caustic`] without the glass.
pub fn no_caustic() -> Arc<Scene> {
    floor_under_area_light("no caustic", |_| {})
}

fn floor_under_area_light(name: &str, glass: impl FnOnce(&mut SceneBuilder)) -> Arc<Scene> {
    let camera = Camera::new(
        DVec3::new(0.0, -2.6, 1.9),
        DVec3::new(0.0, 0.0, 0.3),
        DVec3::Z,
        0.4,
    );
    seen_by(camera, name, |s| {
        glass(s);
        floor(s, lambert(FLOOR));
        square(s, 1.4 * DVec3::Z, 0.5, false, light(LIGHT));
    })
}
