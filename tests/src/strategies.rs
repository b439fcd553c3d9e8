//! The strategies of the path tracer by name: hits, shadow rays, both, with points on lights picked
//! by area and by solid angle, each against a closed form; and the edge of a shadow.
//!
//! Most lights are near and large, so that hits alone find them often enough. There shadow rays to
//! points uniform in area need up to a thousand times as many samples: these see farther lights.

use whitefurnace::harness::mean::welch;
use whitefurnace::integrator::Heuristic;
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::math::frame::from_spherical;

use crate::irradiance::{Weights, lit, reflected, three};
use crate::mean_radiance::Draws;
use crate::prelude::*;
use crate::scenes::{
    FLOOR, LIGHT, NEAR, RECTANGLE, TRIANGLE, ball, corners, floor, lambert, level, light,
    near_light, origin_from, panel, polygon_irradiance, rectangle_light, scene, sphere_irradiance,
    sphere_light, square, three_lights, triangle, triangle_light,
};

/// A path tracer by strategy and light sampling, with the balance heuristic.
pub const fn by(strategy: Strategy, lights: LightSampling) -> EstimatorKind {
    EstimatorKind::PathBy(strategy, lights, Heuristic::Balance)
}

const BSDF: EstimatorKind = by(Strategy::Bsdf, LightSampling::Area);
const LIGHT_AREA: EstimatorKind = by(Strategy::Light, LightSampling::Area);
pub(super) const LIGHT_ANGLE: EstimatorKind = by(Strategy::Light, LightSampling::SolidAngle);
const MIS_AREA: EstimatorKind = by(Strategy::Mis, LightSampling::Area);
const LIGHT_CONTRIBUTION: EstimatorKind = by(Strategy::Light, LightSampling::ByContribution);
const MIS_CONTRIBUTION: EstimatorKind = by(Strategy::Mis, LightSampling::ByContribution);
pub(super) const MIS_ANGLE: EstimatorKind = by(Strategy::Mis, LightSampling::SolidAngle);

/// A triangle so near and large that most directions hit it; it faces down.
pub const NEAR_TRIANGLE: [DVec3; 3] = [
    DVec3::new(-3.0, -2.0, 0.6),
    DVec3::new(0.0, 4.0, 0.6),
    DVec3::new(3.0, -2.0, 0.6),
];
/// Radius and height of the centre of a sphere that fills most of the sky.
pub const NEAR_SPHERE: [f64; 2] = [1.35, 1.5];

/// The origin from so near that no light is between.
pub(super) fn near_origin(_: &mut Stream) -> Ray {
    origin_from(0.1)
}

fn near_triangle() -> Arc<Scene> {
    scene("near triangle", |s| {
        floor(s, lambert(FLOOR));
        triangle(s, &NEAR_TRIANGLE, light(LIGHT));
    })
}

/// The light [`NEAR`] as so many tiles that they are in groups; this one is [`BRIGHT`] times as
/// bright.
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

/// The centre of a tile.
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
    [
        lights(),
        penumbra(),
        vec![heuristics()],
        vec![power_weights()],
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Lights of each shape by each strategy.
fn lights() -> Vec<FamilyTrial<EstimatorSubject>> {
    let near_square = (near_light(), polygon_irradiance(&NEAR), "a square light");
    let near_triangle = (
        near_triangle(),
        polygon_irradiance(&NEAR_TRIANGLE),
        "a triangular light",
    );
    let [radius, height] = NEAR_SPHERE;
    let near_sphere = (
        near_sphere(),
        sphere_irradiance(radius, height, 1.0),
        "a spherical light",
    );
    let square = (
        rectangle_light(false),
        polygon_irradiance(&RECTANGLE),
        "a square light",
    );
    let far_triangle = (
        triangle_light(),
        polygon_irradiance(&TRIANGLE),
        "a triangular light",
    );
    let sphere = (
        sphere_light(),
        sphere_irradiance(0.5, 2.0, 1.0),
        "a spherical light",
    );
    let three = (three_lights(), three(), "a threefold light");
    let bright = polygon_irradiance(&corners(
        tile(BRIGHT_TILE, BRIGHT_TILE),
        2.0 / f64::from(TILES),
    ));
    let mosaic = (
        mosaic(),
        polygon_irradiance(&NEAR) + (BRIGHT - 1.0) * bright,
        "a light of tiles",
    );
    let by = |name, light, kind, equation, scrambles| {
        lit(
            name,
            light,
            (kind, near_origin),
            equation,
            Draws::Scrambles(scrambles),
        )
    };
    vec![
        by(
            "irradiance/near-square/bsdf",
            &near_square,
            BSDF,
            &MIS,
            47_000,
        ),
        by(
            "irradiance/square/light-area",
            &square,
            LIGHT_AREA,
            &GEOMETRY,
            11_000,
        ),
        by(
            "irradiance/near-square/light-angle",
            &near_square,
            LIGHT_ANGLE,
            &LIGHT_RECTANGLE,
            11_000,
        ),
        by(
            "irradiance/near-square/mis-area",
            &near_square,
            MIS_AREA,
            &MIS,
            29_000,
        ),
        by(
            "irradiance/near-square/mis-angle",
            &near_square,
            MIS_ANGLE,
            &LIGHT_RECTANGLE,
            35_000,
        ),
        by(
            "irradiance/near-triangle/bsdf",
            &near_triangle,
            BSDF,
            &MIS,
            59_000,
        ),
        by(
            "irradiance/triangle/light-area",
            &far_triangle,
            LIGHT_AREA,
            &GEOMETRY,
            18_000,
        ),
        by(
            "irradiance/near-triangle/light-angle",
            &near_triangle,
            LIGHT_ANGLE,
            &SOLID_ANGLE,
            11_000,
        ),
        by(
            "irradiance/near-triangle/mis-area",
            &near_triangle,
            MIS_AREA,
            &MIS,
            66_000,
        ),
        by(
            "irradiance/near-triangle/mis-angle",
            &near_triangle,
            MIS_ANGLE,
            &LIGHT_TRIANGLE,
            24_000,
        ),
        by(
            "irradiance/near-sphere/bsdf",
            &near_sphere,
            BSDF,
            &MIS,
            48_000,
        ),
        // By points nearly every scramble hits the light as often as the others, but for a few:
        // with hits that count the means are skewed.
        lit(
            "irradiance/sphere/light-area",
            &sphere,
            (LIGHT_AREA, near_origin),
            &GEOMETRY,
            Draws::Rays(11_500_000),
        ),
        by(
            "irradiance/near-sphere/light-angle",
            &near_sphere,
            LIGHT_ANGLE,
            &LIGHT_SPHERE,
            11_000,
        ),
        by(
            "irradiance/near-sphere/mis-area",
            &near_sphere,
            MIS_AREA,
            &MIS,
            68_000,
        ),
        by(
            "irradiance/near-sphere/mis-angle",
            &near_sphere,
            MIS_ANGLE,
            &LIGHT_SPHERE,
            28_000,
        ),
        by(
            "irradiance/three-lights/light-angle",
            &three,
            LIGHT_ANGLE,
            &LIGHT_RECTANGLE,
            190_000,
        ),
        by(
            "irradiance/three-lights/contribution",
            &three,
            LIGHT_CONTRIBUTION,
            &LIGHT_PICK,
            500_000,
        ),
        by(
            "irradiance/mosaic/mis",
            &mosaic,
            MIS_CONTRIBUTION,
            &LIGHT_PICK,
            53_000,
        ),
    ]
}

/// Height of the edge of the occluder of [`penumbra_scene`], whose plane is y ≥ 0 at that height.
pub const EDGE: f64 = 0.3;

/// The light [`NEAR`] and a black occluder between it and the floor at y > 0. The floor's penumbra
/// reaches from y = −2 to y = 2.
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

/// The radiance that the floor of [`penumbra_scene`] reflects at (0, y, 0): from what the point
/// sees of the light, which ends on the plane through it and the occluder's edge.
pub fn penumbra_reference(y: f64) -> f64 {
    let edge = y * (1.0 - NEAR[0].z / EDGE);
    let visible = NEAR.map(|v| v.with_y(v.y.min(edge)) - DVec3::new(0.0, y, 0.0));
    reflected(polygon_irradiance(&visible))
}

/// Down to (0, y, 0), steeply and from below the occluder.
pub fn to_floor(y: f64) -> Ray {
    let w = from_spherical(10f64.to_radians(), 4.0);
    Ray::new(DVec3::new(0.0, y, 0.0) + 0.2 * w, -w)
}

fn penumbra() -> Vec<FamilyTrial<EstimatorSubject>> {
    let scene = penumbra_scene();
    let family_trial = |name, y: f64, ray: Rays, kind, scrambles| {
        let reference = penumbra_reference(y);
        let property = format!("in the penumbra at y = {y} the floor reflects {reference:.6}");
        radiance(name, &GEOMETRY, (&scene, kind, ray))
            .says(property)
            .by_points((reference, SINGLE), scrambles)
    };
    vec![
        family_trial(
            "irradiance/penumbra/bright",
            -0.6,
            |_| to_floor(-0.6),
            LIGHT_ANGLE,
            46_000,
        ),
        family_trial(
            "irradiance/penumbra/middle",
            -0.2,
            |_| to_floor(-0.2),
            LIGHT_ANGLE,
            170_000,
        ),
    ]
}

/// Both heuristics have the same mean.
struct SameMean {
    scene: Arc<Scene>,
    samples: u64,
}

impl Property for SameMean {
    fn run<P: EstimatorParts + Copy>(
        &self,
        context: &Context,
        setup: Configuration<P>,
    ) -> Vec<Outcome> {
        let reference = reflected(polygon_irradiance(&NEAR));
        let [balance, power] = [Heuristic::Balance, Heuristic::Power].map(|heuristic| {
            let probe = Probe {
                scene: Arc::clone(&self.scene),
                kind: EstimatorKind::PathBy(Strategy::Mis, LightSampling::SolidAngle, heuristic),
                ray: near_origin,
            };
            let mut radiance = probe.radiances(setup, context.seed_of(&format!("{heuristic:?}")));
            Values::collect(reference, context.n(self.samples), || {
                level(&self.scene, radiance())
            })
        });
        let claim = Claim::Exact {
            delta: SINGLE * reference,
        };
        vec![welch("balance less power", &balance, &power, claim)]
    }
}

fn heuristics() -> FamilyTrial<EstimatorSubject> {
    let same = SameMean {
        scene: near_light(),
        samples: 2_300_000,
    };
    let property = "balance and power heuristic have the same mean";
    trial(
        "irradiance/heuristics",
        property,
        &MIS_POWER,
        ["integrator::Path", "Welch"],
        with_parts(same),
    )
}

fn power_weights() -> FamilyTrial<EstimatorSubject> {
    let property = "power weights sum to one and stand as the squares of the densities";
    let judged = ["geometry::radiometry::power", "exact"];
    trial(
        "irradiance/power-weights",
        property,
        &MIS_POWER,
        judged,
        with_parts(Weights(Heuristic::Power)),
    )
}
