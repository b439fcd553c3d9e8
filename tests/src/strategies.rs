//! The strategies of the path tracer by name: BSDF sampling, light sampling and both, with points
//! on lights sampled by area and by solid angle, each against a closed form; and the edge of a
//! shadow.
//!
//! Most lights are near and large, so that BSDF sampling alone finds them often enough. There
//! shadow rays to points uniform in area need up to a thousand times as many samples, so their
//! trials use farther lights.

use whitefurnace::harness::mean::welch;
use whitefurnace::integrator::Heuristic;
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::math::frame::from_spherical;

use crate::irradiance::{Light, Weights, lit, reflected, three};
use crate::mean_radiance::scramble_means;
use crate::prelude::*;
use crate::scenes::{
    FLOOR, LIGHT, NEAR, RECTANGLE, TRIANGLE, ball, corners, floor, lambert, light, near_light,
    panel, polygon_irradiance, ray_to_origin_from, rectangle_light, scene, sphere_irradiance,
    sphere_light, square, three_lights, triangle, triangle_light,
};

/// Returns a path tracer with a strategy, a light sampling and the balance heuristic.
pub const fn path_with(strategy: Strategy, lights: LightSampling) -> EstimatorKind {
    EstimatorKind::PathWith(strategy, lights, Heuristic::Balance)
}

const BSDF: EstimatorKind = path_with(Strategy::Bsdf, LightSampling::Area);
const LIGHT_AREA: EstimatorKind = path_with(Strategy::Light, LightSampling::Area);
pub(super) const LIGHT_ANGLE: EstimatorKind = path_with(Strategy::Light, LightSampling::SolidAngle);
const MIS_AREA: EstimatorKind = path_with(Strategy::Mis, LightSampling::Area);
const LIGHT_IMPORTANCE: EstimatorKind = path_with(Strategy::Light, LightSampling::Importance);
const MIS_IMPORTANCE: EstimatorKind = path_with(Strategy::Mis, LightSampling::Importance);
pub(super) const MIS_ANGLE: EstimatorKind = path_with(Strategy::Mis, LightSampling::SolidAngle);

/// A triangle that faces down, so near and large that most directions hit it.
pub const NEAR_TRIANGLE: [DVec3; 3] = [
    DVec3::new(-3.0, -2.0, 0.6),
    DVec3::new(0.0, 4.0, 0.6),
    DVec3::new(3.0, -2.0, 0.6),
];
/// Radius and height of the centre of a sphere that fills most of the sky.
pub const NEAR_SPHERE: [f64; 2] = [1.35, 1.5];

/// Returns a ray to the origin from so near that no light is between.
pub(super) fn near_origin(_: &mut SampleStream) -> Ray {
    ray_to_origin_from(0.1)
}

fn near_triangle() -> Arc<Scene> {
    scene("near triangle", |s| {
        floor(s, lambert(FLOOR));
        triangle(s, &NEAR_TRIANGLE, light(LIGHT));
    })
}

/// Builds the light [`NEAR`] as so many tiles that a light tree is used; one tile is [`BRIGHT`]
/// times as bright.
fn mosaic() -> Arc<Scene> {
    scene("mosaic", |s| {
        floor(s, lambert(FLOOR));
        for (x, y) in (0..TILES).flat_map(|x| (0..TILES).map(move |y| (x, y))) {
            let radiance = if (x, y) == (BRIGHT_TILE, BRIGHT_TILE) {
                BRIGHT * LIGHT
            } else {
                LIGHT
            };
            square(
                s,
                tile(x, y),
                2.0 / f64::from(TILES),
                false,
                light(radiance),
            );
        }
    })
}

const TILES: u32 = 10;
const BRIGHT_TILE: u32 = 2;
const BRIGHT: f64 = 50.0;

/// Returns the centre of a tile.
fn tile(x: u32, y: u32) -> DVec3 {
    let along = |i: u32| 4.0 * (f64::from(i) + 0.5) / f64::from(TILES) - 2.0;
    DVec3::new(along(x), along(y), NEAR[0].z)
}

fn near_sphere() -> Arc<Scene> {
    scene("near sphere", |s| {
        floor(s, lambert(FLOOR));
        let [radius, height] = NEAR_SPHERE;
        ball(s, Sphere::new(height * DVec3::Z, radius), light(LIGHT));
    })
}

pub(crate) fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    [lights(), penumbra(), vec![heuristics(), power_weights()]]
        .into_iter()
        .flatten()
        .collect()
}

/// Trials of lights of each shape by each strategy.
fn lights() -> Vec<FamilyTrial<EstimatorSubject>> {
    let near_square = Light {
        scene: near_light(),
        irradiance: polygon_irradiance(&NEAR),
        what: "a square light",
    };
    let near_triangle = Light {
        scene: near_triangle(),
        irradiance: polygon_irradiance(&NEAR_TRIANGLE),
        what: "a triangular light",
    };
    let [radius, height] = NEAR_SPHERE;
    let near_sphere = Light {
        scene: near_sphere(),
        irradiance: sphere_irradiance(radius, height, 1.0),
        what: "a spherical light",
    };
    let square = Light {
        scene: rectangle_light(false),
        irradiance: polygon_irradiance(&RECTANGLE),
        what: "a square light",
    };
    let far_triangle = Light {
        scene: triangle_light(),
        irradiance: polygon_irradiance(&TRIANGLE),
        what: "a triangular light",
    };
    let sphere = Light {
        scene: sphere_light(),
        irradiance: sphere_irradiance(0.5, 2.0, 1.0),
        what: "a spherical light",
    };
    let three = Light {
        scene: three_lights(),
        irradiance: three(),
        what: "a threefold light",
    };
    let bright = polygon_irradiance(&corners(
        tile(BRIGHT_TILE, BRIGHT_TILE),
        2.0 / f64::from(TILES),
    ));
    let mosaic = Light {
        scene: mosaic(),
        irradiance: polygon_irradiance(&NEAR) + (BRIGHT - 1.0) * bright,
        what: "a light of tiles",
    };
    let by = |name, consequence, light, kind, equation, draws| {
        lit(name, consequence, light, kind, near_origin, equation, draws)
    };
    vec![
        by(
            "irradiance/near-square/bsdf",
            "a panel just above a floor lights it wrongly if paths find it by chance",
            &near_square,
            BSDF,
            &MIS,
            Draws::scrambles(32, 12_300),
        ),
        by(
            "irradiance/square/light-area",
            "a panel's light does not fall off with distance and angle as it should",
            &square,
            LIGHT_AREA,
            &GEOMETRY,
            Draws::scrambles(16, 11_000),
        ),
        by(
            "irradiance/near-square/light-angle",
            "a panel just above a floor lights it wrongly by shadow rays in solid angle",
            &near_square,
            LIGHT_ANGLE,
            &LIGHT_RECTANGLE,
            Draws::scrambles(16, 11_000),
        ),
        by(
            "irradiance/near-square/mis-area",
            "hits and shadow rays together make the floor under a near panel glow or darken",
            &near_square,
            MIS_AREA,
            &MIS,
            Draws::scrambles(16, 29_000),
        ),
        by(
            "irradiance/near-square/mis-angle",
            "a near panel sampled by solid angle is counted more or less than once with MIS",
            &near_square,
            MIS_ANGLE,
            &LIGHT_RECTANGLE,
            Draws::scrambles(16, 35_000),
        ),
        by(
            "irradiance/near-triangle/bsdf",
            "a near triangle of a mesh lamp is too bright or dim if paths find it by chance",
            &near_triangle,
            BSDF,
            &MIS,
            Draws::scrambles(32, 15_000),
        ),
        by(
            "irradiance/triangle/light-area",
            "mesh lamps are too bright or dim by shadow rays, most where they are slanted",
            &far_triangle,
            LIGHT_AREA,
            &GEOMETRY,
            Draws::scrambles(16, 18_000),
        ),
        by(
            "irradiance/near-triangle/light-angle",
            "a near triangle of a mesh lamp is too bright or dim by rays in solid angle",
            &near_triangle,
            LIGHT_ANGLE,
            &SOLID_ANGLE,
            Draws::scrambles(16, 11_000),
        ),
        by(
            "irradiance/near-triangle/mis-area",
            "mesh lamps near a wall glow or darken if MIS weights them by area",
            &near_triangle,
            MIS_AREA,
            &MIS,
            Draws::scrambles(32, 11_400),
        ),
        by(
            "irradiance/near-triangle/mis-angle",
            "mesh lamps near a wall glow or darken if MIS weights them by solid angle",
            &near_triangle,
            MIS_ANGLE,
            &LIGHT_TRIANGLE,
            Draws::scrambles(16, 24_000),
        ),
        by(
            "irradiance/near-sphere/bsdf",
            "a globe lamp close to a floor lights it wrongly if paths find it by chance",
            &near_sphere,
            BSDF,
            &MIS,
            Draws::scrambles(32, 12_100),
        ),
        // Of sixteen points nearly every scramble would hit the light equally often, so that the few
        // others would skew the means of a fault.
        by(
            "irradiance/sphere/light-area",
            "globe lamps are too bright or dim: points on their far side count wrongly",
            &sphere,
            LIGHT_AREA,
            &GEOMETRY,
            Draws::scrambles(12, 27_000),
        ),
        by(
            "irradiance/near-sphere/light-angle",
            "globe lamps near a floor light it wrongly: shadow rays crowd at their middle",
            &near_sphere,
            LIGHT_ANGLE,
            &LIGHT_SPHERE,
            Draws::scrambles(16, 11_000),
        ),
        by(
            "irradiance/near-sphere/mis-area",
            "globe lamps near a floor glow or darken if MIS weights them by area",
            &near_sphere,
            MIS_AREA,
            &MIS,
            Draws::scrambles(32, 12_200),
        ),
        by(
            "irradiance/near-sphere/mis-angle",
            "globe lamps near a floor glow or darken if MIS weights their visible cap",
            &near_sphere,
            MIS_ANGLE,
            &LIGHT_SPHERE,
            Draws::scrambles(16, 28_000),
        ),
        by(
            "irradiance/three-lights/light-angle",
            "rooms get darker the more lamps they have, if sampled by solid angle",
            &three,
            LIGHT_ANGLE,
            &LIGHT_RECTANGLE,
            Draws::scrambles(64, 9_500),
        ),
        by(
            "irradiance/three-lights/contribution",
            "lamps that are picked by their importance are too bright, too dim or never on",
            &three,
            LIGHT_IMPORTANCE,
            &LIGHT_PICK,
            Draws::scrambles(128, 8_600),
        ),
        by(
            "irradiance/mosaic/mis",
            "one bright tile in a large lamp is too bright or too dim near it",
            &mosaic,
            MIS_IMPORTANCE,
            &LIGHT_PICK,
            Draws::scrambles(32, 12_300),
        ),
    ]
}

/// Height of the edge of the occluder of [`penumbra_scene`], which covers y ≥ 0 at that height.
pub const EDGE: f64 = 0.3;

/// Builds the light [`NEAR`] and a black occluder between it and the floor at y > 0. The floor's
/// penumbra reaches from y = −2 to y = 2.
pub fn penumbra_scene() -> Arc<Scene> {
    scene("penumbra", |s| {
        floor(s, lambert(FLOOR));
        square(s, 0.6 * DVec3::Z, 2.0, false, light(LIGHT));
        panel(
            s,
            DVec3::new(-40.0, 0.0, EDGE),
            [80.0 * DVec3::X, 40.0 * DVec3::Y],
            Surface::new(Bsdf::Black),
        );
    })
}

/// Radiance that the floor of [`penumbra_scene`] reflects at (0, y, 0): the visible part of the
/// light ends on the plane through the point and the occluder's edge.
pub fn penumbra_reference(y: f64) -> f64 {
    let edge = y * (1.0 - NEAR[0].z / EDGE);
    let visible = NEAR.map(|v| v.with_y(v.y.min(edge)) - DVec3::new(0.0, y, 0.0));
    reflected(polygon_irradiance(&visible))
}

/// Returns a ray down to (0, y, 0), steep and from below the occluder.
pub fn to_floor(y: f64) -> Ray {
    let w = from_spherical(10f64.to_radians(), 4.0);
    Ray::new(DVec3::new(0.0, y, 0.0) + 0.2 * w, -w)
}

fn penumbra() -> Vec<FamilyTrial<EstimatorSubject>> {
    let scene = penumbra_scene();
    let family_trial = |name, consequence, y: f64, ray: Rays, kind, draws| {
        let reference = penumbra_reference(y);
        let property = format!("in the penumbra at y = {y} the floor reflects {reference:.6}");
        radiance(name, &GEOMETRY, &scene, kind, ray)
            .states(property, consequence)
            .by_draws(reference, CLOSED_FORM_DELTA, draws)
    };
    vec![
        family_trial(
            "irradiance/penumbra/bright",
            "soft shadows are too wide or too narrow towards their bright side",
            -0.6,
            |_| to_floor(-0.6),
            LIGHT_ANGLE,
            Draws::scrambles(16, 21_000),
        ),
        family_trial(
            "irradiance/penumbra/middle",
            "soft shadows are too dark or too light half way through",
            -0.2,
            |_| to_floor(-0.2),
            LIGHT_ANGLE,
            Draws::scrambles(32, 12_000),
        ),
    ]
}

/// Compares the means of both heuristics.
struct SameMean {
    scene: Arc<Scene>,
    scrambles: u64,
}

impl Property for SameMean {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let reference = reflected(polygon_irradiance(&NEAR));
        let [balance, power] = [Heuristic::Balance, Heuristic::Power].map(|heuristic| {
            let kind = EstimatorKind::PathWith(Strategy::Mis, LightSampling::SolidAngle, heuristic);
            let (seed, estimator) = (
                context.seed_of(&format!("{heuristic:?}")),
                kind.estimator(setup),
            );
            let means = scramble_means(seed, 16, &self.scene, estimator, near_origin);
            Values::collect(reference, context.n(self.scrambles), means)
        });
        let claim = Claim::Equal {
            delta: CLOSED_FORM_DELTA * reference,
        };
        vec![welch("balance less power", &balance, &power, claim)]
    }
}

fn heuristics() -> FamilyTrial<EstimatorSubject> {
    let same = SameMean {
        scene: near_light(),
        scrambles: 17_000,
    };
    trial(
        "irradiance/heuristics",
        "balance and power heuristic have the same mean",
        "choosing another MIS heuristic changes the brightness of an image, not only its noise",
        &MIS_POWER,
        "integrator::Path",
        "Welch",
        with_parts(same),
    )
}

fn power_weights() -> FamilyTrial<EstimatorSubject> {
    trial(
        "irradiance/power-weights",
        "power weights sum to one and are proportional to the squares of the densities",
        "lit surfaces are too dark or bright with the power heuristic, which loses or adds light",
        &MIS_POWER,
        "sampling::mis::power",
        "exact",
        with_parts(Weights(Heuristic::Power)),
    )
}
