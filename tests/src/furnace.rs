//! Closed and open furnaces through whole estimators: multiple reflection with closed-form answers.

use rand::Rng;
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::material::OrenNayar;
use whitefurnace::scene::simple::{CAP_SHARE, Cap, cavity_cap, furnace_box};

use crate::bsdf::oren_nayar_albedo;
use crate::mean_radiance::any_direction;
use crate::prelude::*;
use crate::scenes::{
    SIGMA, WALL, ball, eon_floor, lambert, mirror, polygon_irradiance, ray_to_origin,
    ray_to_origin_at, rough_floor, scene, sphere_furnace, valid, walled_sky,
};
use crate::strategies::path_with;
use crate::{infinite_variance, rays_per_hit, survival};

/// Samples a ray from a random point of a small ball in any direction.
pub fn inside<R: Rng + ?Sized>(rng: &mut R) -> Ray {
    let origin = 0.4 * uniform(rng) * any_direction(rng);
    Ray::new(origin, any_direction(rng))
}

/// Samples a ray within the cavity towards its wall outside the emitting cap.
pub fn off_cap(rng: &mut SampleStream) -> Ray {
    let target = loop {
        let target = any_direction(rng);
        if target.z < 1.0 - 2.0 * CAP_SHARE {
            break target;
        }
    };
    let origin = DVec3::new(0.3, -0.5, 0.1);
    Ray::new(origin, (target - origin).normalize())
}

/// Radiance along the rays of [`off_cap`], if the cap emits 1.
pub fn off_cap_radiance(rho: f64, cap: Cap) -> f64 {
    match cap {
        Cap::Reflecting => rho * CAP_SHARE / (1.0 - rho),
        Cap::Black => rho * CAP_SHARE / (1.0 - rho * (1.0 - CAP_SHARE)),
    }
}

const MANY_SEGMENTS: u32 = 60;

pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let mut trials = closed();
    trials.extend(strategies());
    trials.extend(reports());
    trials.push(within());
    trials.extend(rays_per_hit::trials());
    trials.extend(cavities());
    trials.push(survival::cavity());
    trials.extend(skies());
    trials.extend(mirrors());
    trials.push(infinite_variance::hall());
    trials
}

/// Samples a ray from within a box of side 2 in any direction.
pub fn in_box(rng: &mut SampleStream) -> Ray {
    Ray::new(DVec3::new(0.1, 0.2, -0.3), any_direction(rng))
}

fn closed() -> Vec<FamilyTrial<EstimatorSubject>> {
    let cube = |a| (valid(furnace_box(a)), EstimatorKind::Path, in_box as Rays);
    // The longest paths, by BSDF sampling alone: every wall emits, so that shadow rays would cost
    // much and gain little.
    let hits = path_with(Strategy::Bsdf, LightSampling::SolidAngle);
    let sphere = |kind| (sphere_furnace(lambert(0.9), 0.0), kind, inside as Rays);
    [
        (
            "furnace/path/albedo-0.5",
            "grey rooms lose or gain light at each bounce of a path",
            "closed furnace box",
            0.5,
            cube(0.5),
            Draws::Rays(620_000),
        ),
        (
            "furnace/path/albedo-0.75",
            "rooms with pale walls are too dark or too bright, more so than grey ones",
            "closed furnace box",
            0.75,
            cube(0.75),
            Draws::scrambles(16, 60_000),
        ),
        (
            "furnace/path/albedo-0.9",
            "white rooms are too dark or too bright by BSDF sampling alone",
            "spherical furnace",
            0.9,
            sphere(hits),
            Draws::scrambles(4, 250_000),
        ),
        (
            "furnace/path/early",
            "white rooms change brightness when roulette starts later",
            "spherical furnace without early roulette",
            0.9,
            sphere(EstimatorKind::PathWithRrDepth),
            Draws::scrambles(4, 270_000),
        ),
    ]
    .into_iter()
    .map(|(name, consequence, what, a, (scene, kind, ray), draws)| {
        let m = 1.0 / (1.0 - a);
        let property = format!("the radiance in a {what} of albedo {a} is {m:.6}");
        radiance(name, &RENDERING, &scene, kind, ray)
            .states(property, consequence)
            .by_draws(m, BOUNCES_DELTA, draws)
    })
    .collect()
}

/// Trials of one strategy alone. Shadow rays to points uniform in area have infinite variance in a
/// box, as points near its corners can be arbitrarily close; by solid angle their weight is
/// bounded, and in a sphere, which is sampled by area, it is constant.
fn strategies() -> Vec<FamilyTrial<EstimatorSubject>> {
    let (cube, sphere) = (valid(furnace_box(0.5)), sphere_furnace(lambert(0.5), 0.5));
    [
        (
            "furnace/bsdf/box",
            "rooms are too dark or too bright without shadow rays",
            &cube,
            Strategy::Bsdf,
            Draws::Rays(830_000),
        ),
        (
            "furnace/light/box",
            "rooms are too dark or too bright by shadow rays alone, most in their corners",
            &cube,
            Strategy::Light,
            Draws::scrambles(64, 14_900),
        ),
        (
            "furnace/light/sphere",
            "domes are too dark or too bright by shadow rays alone",
            &sphere,
            Strategy::Light,
            Draws::Rays(370_000),
        ),
    ]
    .into_iter()
    .map(|(name, consequence, scene, strategy, draws)| {
        let property =
            format!("in a furnace of albedo 0.5 the radiance by {strategy:?} alone is 2");
        let kind = path_with(strategy, LightSampling::SolidAngle);
        radiance(name, &RENDERING, scene, kind, in_box)
            .states(property, consequence)
            .by_draws(2.0, BOUNCES_DELTA, draws)
    })
    .collect()
}

/// Trials of the report's estimator. In a sphere the shadow ray's weight is constant (from a corner
/// of a box its variance is infinite). A `Report` of s segments counts s + 1 terms of the Neumann
/// series, as its shadow ray is one more.
fn reports() -> Vec<FamilyTrial<EstimatorSubject>> {
    let cut = |a: f64, segments: u32| (1.0 - a.powi(segments as i32 + 1)) / (1.0 - a);
    [
        (
            "furnace/report/absorption-0.25",
            "the report's method darkens or brightens rooms if it ends a quarter of the paths",
            0.5,
            0.25,
            MANY_SEGMENTS,
            Draws::Rays(540_000),
        ),
        (
            "furnace/report/absorption-0.1",
            "the report's method darkens or brightens rooms if it ends a tenth of the paths",
            0.5,
            0.1,
            MANY_SEGMENTS,
            Draws::Rays(300_000),
        ),
        (
            "furnace/report/albedo-0.65",
            "the report's method makes pale rooms too dark or bright if few paths end",
            0.65,
            0.05,
            MANY_SEGMENTS,
            Draws::Rays(1_080_000),
        ),
        (
            "furnace/report/seven-segments",
            "a limit of seven segments darkens rooms more or less than stated",
            0.75,
            0.1,
            7,
            Draws::scrambles(16, 65_000),
        ),
        (
            "furnace/report/three-segments",
            "a limit of three segments darkens rooms more or less than stated",
            0.9,
            0.1,
            3,
            Draws::scrambles(16, 14_500),
        ),
    ]
    .into_iter()
    .map(|(name, consequence, a, absorption, segments, draws)| {
        let scene = sphere_furnace(lambert(a), absorption);
        let m = cut(a, segments);
        let (property, equation) = if segments == MANY_SEGMENTS {
            let property = format!("at absorption {absorption} and albedo {a} the mean is {m:.6}");
            (property, &ROULETTE)
        } else {
            let bias = -a.powi(segments as i32 + 1);
            let property =
                format!("{segments} segments have the relative bias {bias:.6} at albedo {a}");
            (property, &PATH_LENGTH)
        };
        radiance(
            name,
            equation,
            &scene,
            EstimatorKind::Report(segments),
            inside as Rays,
        )
        .states(property, consequence)
        .by_draws(m, BOUNCES_DELTA, draws)
    })
    .collect()
}

/// Trial of a path tracer with limited bounces: a path of s segments has s terms, as its shadow
/// rays are its last segment.
fn within() -> FamilyTrial<EstimatorSubject> {
    let (a, segments) = (0.9, 3u32);
    let m = (0..segments)
        .map(|bounces| f64::powi(a, bounces as i32))
        .sum();
    radiance(
        "furnace/path/three-segments",
        &PATH_LENGTH,
        &sphere_furnace(lambert(a), 0.0),
        EstimatorKind::PathSpecularNeeMaxSegments(segments),
        inside,
    )
    .states(
        format!("light of at most {segments} segments in a furnace of albedo {a} is {m}"),
        "a limit on bounces keeps one bounce too many or too few",
    )
    .by_rays(m, BOUNCES_DELTA, 940_000)
}

fn cavities() -> Vec<FamilyTrial<EstimatorSubject>> {
    let rho = 0.75;
    [
        (
            "furnace/cavity/reflecting",
            "light that a lamp itself reflects is lost or counted twice",
            "reflecting",
            Cap::Reflecting,
            Draws::scrambles(64, 12_800),
        ),
        (
            "furnace/cavity/black",
            "the light of a small bright window is counted twice or lost in a room",
            "black",
            Cap::Black,
            Draws::Rays(925_000),
        ),
    ]
    .into_iter()
    .map(|(name, consequence, what, cap, draws)| {
        let reference = off_cap_radiance(rho, cap);
        radiance(
            name,
            &RENDERING,
            &valid(cavity_cap(rho, cap)),
            EstimatorKind::Path,
            off_cap,
        )
        .states(
            format!("off a {what} cap the radiance in a cavity of albedo {rho} is {reference:.6}"),
            consequence,
        )
        .by_draws(reference, BOUNCES_DELTA, draws)
    })
    .collect()
}

/// Trials of floors under a sky of radiance 1.
fn skies() -> Vec<FamilyTrial<EstimatorSubject>> {
    let walled = walled_sky();
    let visible = 1.0 - polygon_irradiance(&WALL) / PI;
    let property = format!("a floor under a sky that a wall hides in part reflects {visible:.6}");
    let rough = rough_floor();
    let grazing = |_: &mut SampleStream| ray_to_origin_at(75f64.to_radians());
    let albedo = oren_nayar_albedo(OrenNayar::new(SIGMA), 75f64.to_radians());
    vec![
        radiance(
            "furnace/sky/path",
            &COSINE_HEMISPHERE,
            &walled,
            EstimatorKind::Path,
            |_| ray_to_origin(),
        )
        .states(
            property.clone(),
            "a wall takes too much or too little skylight from the floor by it when path traced",
        )
        .by_scrambles(visible, CLOSED_FORM_DELTA, 64, 11_000),
        radiance(
            "furnace/sky/report",
            &HEMISPHERE_PHI,
            &walled,
            EstimatorKind::Report(2),
            |_| ray_to_origin(),
        )
        .states(
            property,
            "the report's method lets a wall take too much or too little skylight from a floor",
        )
        .by_scrambles(visible, CLOSED_FORM_DELTA, 64, 23_500),
        radiance(
            "furnace/sky/oren-nayar",
            &OREN_NAYAR,
            &rough,
            EstimatorKind::Path,
            grazing,
        )
        .states(
            format!("at 75° an Oren-Nayar floor reflects {albedo:.6} of a white sky"),
            "plaster floors are too bright or too dark far from the eye",
        )
        .by_scrambles(albedo, CLOSED_FORM_DELTA, 32, 8_600),
        radiance(
            "furnace/sky/eon",
            &EON_MULTIPLE,
            &eon_floor(1.0),
            EstimatorKind::Path,
            |_| ray_to_origin(),
        )
        .states(
            "a white floor of EON with roughness 1 reflects all of a white sky",
            "a white rough floor is visibly darker than the even sky above it",
        )
        .by_rays(1.0, CLOSED_FORM_DELTA, 1_510_000),
    ]
}

/// Trials of halls of mirrors: paths end and are unbiased even without absorption.
fn mirrors() -> Vec<FamilyTrial<EstimatorSubject>> {
    let reflectance = 0.75;
    let hall = sphere_furnace(mirror(reflectance), 0.0);
    let facing_mirrors = scene("facing mirrors", |s| {
        s.background(DVec3::ONE);
        for z in [-1.0, 1.0] {
            ball(
                s,
                Sphere::new(DVec3::new(0.0, 0.0, 11.0 * z), 10.0),
                Surface::new(mirror(1.0)),
            );
        }
    });
    let hall_mean = 1.0 / (1.0 - reflectance);
    vec![
        radiance(
            "furnace/mirrors/hall",
            &RENDERING,
            &hall,
            EstimatorKind::Path,
            inside,
        )
        .states(
            format!(
                "in a hall of emitting mirrors of reflectance 0.75 the radiance is {hall_mean}"
            ),
            "mirrors that face mirrors get too dark or too bright in the depth",
        )
        .by_rays(hall_mean, BOUNCES_DELTA, 1_340_000),
        radiance(
            "furnace/mirrors/facing",
            &ROULETTE,
            &facing_mirrors,
            EstimatorKind::Path,
            |rng| {
                let w = any_direction(rng);
                let slanted = DVec3::new(w.x, w.y, 0.0).normalize() * 0.3 + DVec3::Z;
                Ray::new(DVec3::ZERO, slanted.normalize())
            },
        )
        .states(
            "between two facing perfect mirrors under a white sky paths end and the radiance is 1",
            "a render of two facing mirrors never ends, or ends too dark",
        )
        .by_rays(1.0, BOUNCES_DELTA, 1_030_000),
    ]
}
