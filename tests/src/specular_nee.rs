//! Specular next-event estimation: shadow rays that connect to lights through one mirror or glass
//! body. The radiance in a closed furnace is the same whatever stands in it.

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use whitefurnace::geometry::specular_connection::{CasterKind, SpecularConnection};
use whitefurnace::integrator::{Heuristic, NextEvent as _};
use whitefurnace::material::fresnel::reflectance;

use crate::furnace::inside;
use crate::glass::{GLASS, INDEX};
use crate::prelude::*;
use crate::scenes::{FLOOR, LIGHT, ball, hollow, lambert, light, mirror, scene, square};
use crate::strategies::near_origin;

/// The path tracer with specular next-event estimation, weighted by the balance heuristic.
pub const SPECULAR_NEE: EstimatorKind = EstimatorKind::PathSpecularNee(Heuristic::Balance);

/// Albedo of all walls.
const ALBEDO: f64 = 0.5;

/// Builds a sphere whose inside emits, with something in it.
fn furnace_with(name: &str, parts: impl FnOnce(&mut SceneBuilder)) -> Arc<Scene> {
    scene(name, |s| {
        hollow(s, 1.0, Surface::new(lambert(ALBEDO)).emitting(DVec3::ONE));
        parts(s);
    })
}

/// Balls of glass, one of them nearly at the wall, where light takes three specular paths.
fn with_glass() -> Arc<Scene> {
    furnace_with("furnace with glass", |s| {
        for (x, radius, index) in [(-0.65, 0.2, 1.5), (0.65, 0.3, 2.0)] {
            ball(
                s,
                Sphere::new(DVec3::new(x, 0.1, 0.2), radius),
                Surface::new(Bsdf::Glass { index }),
            );
        }
    })
}

/// A ball and a box of mirrors.
fn with_mirrors() -> Arc<Scene> {
    furnace_with("furnace with mirrors", |s| {
        ball(
            s,
            Sphere::new(DVec3::new(0.1, -0.7, 0.0), 0.2),
            Surface::new(mirror(1.0)),
        );
        let [a, b] = [DVec3::new(0.2, 0.1, 0.0), DVec3::new(-0.05, 0.1, 0.2)];
        let surface = s.surface(Surface::new(mirror(1.0)));
        for z in [-0.65, 0.55] {
            s.rectangle(
                DVec3::new(0.0, 0.0, z),
                if z < 0.0 { [a, b] } else { [b, a] },
                surface,
            );
        }
    })
}

/// Adds a ball of glass over a small patch at the origin, 1.3 radii from its centre, and a light on
/// a cap of the concentric sphere of twice the radius, which illuminates the patch through the ball
/// alone.
pub(super) fn add_lens(s: &mut SceneBuilder) {
    square(s, DVec3::ZERO, 1e-3, true, Surface::new(lambert(FLOOR)));
    ball(s, lens(), Surface::new(GLASS));
    let zone = [CAP_DISTANCE * CAP_HALF_ANGLE.cos(), f64::INFINITY];
    ball(
        s,
        Sphere {
            zone,
            inward: true,
            ..Sphere::new(lens().centre, CAP_DISTANCE)
        },
        light(LIGHT),
    );
}

/// The ball of [`add_lens`].
pub(super) fn lens() -> Sphere {
    Sphere::new(DVec3::new(0.0, 0.0, PATCH_DISTANCE), 1.0)
}

/// Distance of the patch below the ball's centre, distance of the cap above it, and half angle of
/// the cap.
const PATCH_DISTANCE: f64 = 1.3;
const CAP_DISTANCE: f64 = 2.0;
const CAP_HALF_ANGLE: f64 = 0.4;

/// Irradiance of the patch, divided by π and by the radiance of the cap: the sum over angles of
/// incidence at the ball, and over these numbers of reflections within it, of the light that
/// arrives from the cap. A path comes from the cap if it meets the cap's sphere within the half
/// angle of its top.
fn through_lens(reflections: Range<i32>) -> f64 {
    const STEPS: u32 = 200_000;
    let arriving = |i: u32| {
        let alpha = FRAC_PI_2 * (f64::from(i) + 0.5) / f64::from(STEPS);
        let (sin, cos) = alpha.sin_cos();
        let reflected = reflectance(cos, 1.0, INDEX);
        let within = (sin / INDEX).asin();
        let turned = 2.0 * alpha
            - 2.0 * within
            - (sin / PATCH_DISTANCE).asin()
            - (sin / CAP_DISTANCE).asin();
        let arrives = |reflections: i32| {
            let angle = turned + f64::from(reflections) * (PI - 2.0 * within);
            let from_top = (angle + PI).rem_euclid(TAU) - PI;
            let passed = (1.0 - reflected).powi(2) * reflected.powi(reflections);
            if from_top.abs() <= CAP_HALF_ANGLE {
                passed
            } else {
                0.0
            }
        };
        // sin ψ d(sin ψ), where sin ψ = sin α / BELOW.
        reflections.clone().map(arrives).sum::<f64>() * sin * cos
            / (PATCH_DISTANCE * PATCH_DISTANCE)
    };
    2.0 * (0..STEPS).map(arriving).sum::<f64>() * FRAC_PI_2 / f64::from(STEPS)
}

pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let level = 1.0 / (1.0 - ALBEDO);
    let furnace = |name, consequence, what, equation, scene: &Arc<Scene>, kind, ray, scrambles| {
        let property =
            format!("among {what} in a furnace of albedo {ALBEDO} the radiance is {level}");
        radiance(name, equation, scene, kind, ray)
            .states(property, consequence)
            .by_scrambles(level, BOUNCES_DELTA, 16, scrambles)
    };
    let (glass, mirrors, lens) = (
        with_glass(),
        with_mirrors(),
        scene("under a lens", add_lens),
    );
    let [lit, straight] =
        [0..12, 0..1].map(|reflections| FLOOR * LIGHT * through_lens(reflections));
    vec![
        radiance(
            "irradiance/by-bodies/lens",
            &SPECULAR_ANGLE,
            &lens,
            SPECULAR_NEE,
            near_origin,
        )
        .states(
            format!(
                "a patch reflects {lit:.6} of a light that it sees through a ball of glass only"
            ),
            "the caustic of a glass ball is too bright or too dim by specular shadow rays",
        )
        .by_scrambles(lit, BOUNCES_DELTA, 64, 11_500),
        radiance(
            "irradiance/by-bodies/lens-four-segments",
            &SPECULAR_ANGLE,
            &lens,
            EstimatorKind::PathSpecularNeeMaxSegments(4),
            near_origin,
        )
        .states(
            format!(
                "without reflections within the ball of glass the patch reflects {straight:.6}"
            ),
            "a limit on bounces cuts the caustic of a glass ball, or does not limit it",
        )
        .by_scrambles(straight, BOUNCES_DELTA, 64, 12_500),
        furnace(
            "furnace/by-bodies/glass",
            "glass balls in a room change how bright it is: their caustics are counted wrongly",
            "balls of glass",
            &SPECULAR_ANGLE,
            &glass,
            SPECULAR_NEE,
            inside as Rays,
            27_500,
        ),
        furnace(
            "furnace/by-bodies/mirrors",
            "mirrors in a room change how bright it is: their light is counted twice or lost",
            "mirrors",
            &SPECULAR_SPREAD,
            &mirrors,
            EstimatorKind::PathSpecularNee(Heuristic::Power),
            inside as Rays,
            29_000,
        ),
    ]
}

pub fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("spread-doubled", SPECULAR_SPREAD, "the geometry term of a specular connection is doubled",
            { connection: |_, _, connection| Some(SpecularConnection { geometry_term: 2.0 * connection.geometry_term, ..connection }) },
            "irradiance/by-bodies/lens", "furnace/by-bodies/glass", "furnace/by-bodies/mirrors", "irradiance/after-mirror/by-bodies"),
        fault!("spread-without-slant", SPECULAR_SPREAD, "the cosine at the body is counted twice",
            { connection: |_, _, connection| Some(SpecularConnection { geometry_term: connection.cosine * connection.geometry_term, ..connection }) },
            "irradiance/by-bodies/lens", "irradiance/after-mirror/by-bodies"),
        fault!("one-root", SPECULAR_ANGLE, "the search ends at the first root",
            { connection: |_, number, connection| (number == 0).then_some(connection) }, "irradiance/by-bodies/lens"),
        fault!("first-root-lost", SPECULAR_ANGLE, "the first root is left out: light that is bent beyond the axis, or reflected",
            { connection: |_, number, connection| (number > 0).then_some(connection) },
            "furnace/by-bodies/glass", "furnace/by-bodies/mirrors", "irradiance/after-mirror/by-bodies"),
        fault!("enters-and-stays", FRESNEL, "light is weakened where it enters a ball of glass, but not where it leaves",
            { caster_throughput: |caster, cosine| {
                let (passed, chance) = DefaultParts.caster_throughput(caster, cosine);
                (if caster.kind == CasterKind::Refraction { DVec3::splat(passed.x.sqrt()) } else { passed }, chance)
            } },
            "irradiance/by-bodies/lens"),
        fault!("glint-of-a-mirror", FRESNEL, "a ball of glass reflects as a mirror does",
            { caster_throughput: |caster, cosine| {
                let (passed, chance) = DefaultParts.caster_throughput(caster, cosine);
                (if caster.kind == CasterKind::Reflection { DVec3::ONE } else { passed }, chance)
            } },
            "furnace/by-bodies/glass"),
        fault!("mirror-twice", RENDERING, "specular connections are multiplied by the body's reflectance or transmittance twice",
            { caster_throughput: |caster, cosine| {
                let (passed, chance) = DefaultParts.caster_throughput(caster, cosine);
                (passed * passed, chance)
            } },
            "irradiance/after-mirror/by-bodies", "irradiance/by-bodies/lens"),
        fault!("body-not-picked", LIGHT_PICK, "a specular connection is not divided by the probability of picking its body",
            { pick_by_probability: |r, shares| (DefaultParts.pick_by_probability(r, shares).0, 1.0) },
            "irradiance/by-bodies/lens", "furnace/by-bodies/glass"),
    ]
}
