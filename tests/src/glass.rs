//! Mirrors and glass through whole estimators: directions, reflectance, radiance factors, total
//! reflection, and index-matched glass, which must not be visible.

use whitefurnace::harness::chi_square::binomial;
use whitefurnace::scene::simple::glass_cube;

use crate::irradiance::reflected;
use crate::mean_radiance::any_direction;
use crate::prelude::*;
use crate::scenes::{
    FLOOR, HEIGHT, LIGHT, RECTANGLE, ball, floor, lambert, light, mirror, polygon_irradiance,
    ray_to_origin, ray_to_origin_at, scene, square, valid,
};

pub(super) const INDEX: f64 = 1.5;
pub(super) const GLASS: Bsdf = Bsdf::Glass { index: INDEX };
/// Inclination of the probe rays of the aim trials, degrees from the normal.
const AIM: f64 = 50.0;

/// R of (12) by Fresnel's tangent and sine laws in the angles θ₁ and θ₂, a derivation independent
/// of (10) and (11).
pub(super) fn reflectance_by_angles(theta_1: f64, n1: f64, n2: f64) -> f64 {
    let theta_2 = (n1 / n2 * theta_1.sin()).asin();
    let s = (theta_1 - theta_2).sin() / (theta_1 + theta_2).sin();
    let p = (theta_1 - theta_2).tan() / (theta_1 + theta_2).tan();
    0.5 * (s * s + p * p)
}

/// A plane of glass at z = 0, glass below, under a ceiling that emits 1.
fn pane() -> Arc<Scene> {
    scene("glass plane", |s| {
        floor(s, GLASS);
        square(s, 3.0 * DVec3::Z, 50.0, false, light(1.0));
    })
}

/// A plane of glass at z = 0 under a dark ceiling, with an emitting ground within the glass.
fn lit_from_below() -> Arc<Scene> {
    scene("glass plane, lit from below", |s| {
        floor(s, GLASS);
        square(s, -3.0 * DVec3::Z, 50.0, true, light(1.0));
    })
}

/// A plane of `bsdf`, and a small light that faces the origin at distance 1 along `direction`.
fn aim(bsdf: Bsdf, direction: DVec3) -> Arc<Scene> {
    scene("aim", |s| {
        floor(s, bsdf);
        square(s, direction, 0.01, direction.z < 0.0, light(LIGHT));
    })
}

/// Continuation of a ray from [`ray_to_origin_at`] beyond the origin, at another inclination below.
fn beyond(inclination: f64) -> DVec3 {
    -whitefurnace::math::frame::from_spherical(inclination, 4.0)
}

pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    [aims(), lobes(), cubes(), vec![vanishing()]]
        .into_iter()
        .flatten()
        .collect()
}

fn aims() -> Vec<FamilyTrial<EstimatorSubject>> {
    let back = beyond(AIM.to_radians()).with_z(AIM.to_radians().cos());
    let theta_1 = AIM.to_radians();
    let refracted = beyond((theta_1.sin() / INDEX).asin());
    let transmitted = (1.0 - reflectance_by_angles(theta_1, 1.0, INDEX)) / (INDEX * INDEX) * LIGHT;
    let probe: Rays = |_| ray_to_origin_at(AIM.to_radians());
    vec![
        radiance(
            "glass/mirror-aim",
            &REFRACTION,
            &aim(mirror(0.9), back),
            EstimatorKind::Whitted(3),
            probe,
        )
        .states(
            "a small light lies where the law of reflection says, and is seen in the mirror",
            "things seen in a mirror appear in the wrong place",
        )
        .by_rays(0.9 * LIGHT, 0.0, 1000),
        radiance(
            "glass/snell-aim",
            &REFRACTION,
            &aim(GLASS, refracted),
            EstimatorKind::Whitted(3),
            probe,
        )
        .states(
            "a small light in glass lies where Snell's law says, at (1 − R)/n² of its radiance",
            "things under water or in glass appear in the wrong place, or at full brightness",
        )
        .by_rays(transmitted, 0.0, 1000),
        radiance(
            "glass/lit-from-below",
            &REFRACTION,
            &lit_from_below(),
            EstimatorKind::Path,
            probe,
        )
        .states(
            "light from within glass arrives as (1 − R)/n² of its radiance",
            "lamps in glass or water look n² too bright, as suspected in tunabrain/tungsten#54",
        )
        .by_rays(transmitted / LIGHT, CLOSED_FORM_DELTA, 2_400_000),
    ]
}

/// Compares how often rays are reflected by the glass, to the lit side, with a probability.
struct Lobe {
    probe: Probe,
    probability: f64,
    delta: f64,
    samples: u64,
}

impl Property for Lobe {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let mut radiance = self.probe.radiances(setup, context.seed_of("lobes"));
        let n = context.n(self.samples);
        let k = (0..n).filter(|_| radiance().x > 0.0).count() as u64;
        vec![binomial("reflected", k, n, self.probability, self.delta)]
    }
}

/// Returns the trial of the probability of reflection at an inclination.
fn lobe<const DEGREES: u32>(name: &str, samples: u64) -> FamilyTrial<EstimatorSubject> {
    let r = reflectance_by_angles(f64::from(DEGREES).to_radians(), 1.0, INDEX);
    let probe = Probe {
        scene: pane(),
        kind: EstimatorKind::Report(3),
        ray: |_| ray_to_origin_at(f64::from(DEGREES).to_radians()),
    };
    let lobe = Lobe {
        probe,
        probability: r,
        delta: CELL * r,
        samples,
    };
    trial(
        name,
        format!("at {DEGREES}° glass reflects with probability R = {r:.6}"),
        format!("a window seen at {DEGREES}° reflects too strongly or too weakly"),
        &FRESNEL,
        "integrator::Report",
        "binomial",
        with_parts(lobe),
    )
}

fn lobes() -> Vec<FamilyTrial<EstimatorSubject>> {
    vec![
        lobe::<60>("glass/reflects-60", 4_500_000),
        lobe::<75>("glass/reflects-75", 1_500_000),
        lobe::<85>("glass/reflects-85", 500_000),
        total_reflection(),
    ]
}

/// Relative δ of a probability.
const CELL: f64 = whitefurnace::harness::chi_square::CELL_DELTA;

/// Trial of total reflection: from within the glass, past the critical angle, every ray goes back
/// down to the lit ground.
fn total_reflection() -> FamilyTrial<EstimatorSubject> {
    let up = |_: &mut SampleStream| {
        let d = whitefurnace::math::frame::from_spherical(50f64.to_radians(), 1.0);
        Ray::new(-0.5 * d, d)
    };
    radiance(
        "glass/total-reflection",
        &FRESNEL,
        &lit_from_below(),
        EstimatorKind::Report(3),
        up,
    )
    .states(
        "within glass, past the critical angle, the surface shows the lit ground undiminished",
        "water seen from below is black where it must mirror, as in Twinklebear/ChameleonRT#3",
    )
    .by_rays(1.0, 0.0, 2_000_000)
}

/// Samples a ray from within a glass cube whose largest cosine with the faces' normals is `wanted`.
fn within_cube(rng: &mut SampleStream, wanted: impl Fn(f64) -> bool) -> Ray {
    loop {
        let d = any_direction(rng);
        if wanted(d.abs().max_element()) {
            return Ray::new(DVec3::new(0.09, -0.13, 0.07), d);
        }
    }
}

/// Samples a ray by which light can leave: well within the critical angle of a face. Just within it
/// R is near 1, a path outlives any roulette, and the variance is infinite.
fn leaving(rng: &mut SampleStream) -> Ray {
    within_cube(rng, |cosine| cosine > 0.85)
}

/// Samples a ray that is totally reflected at every face.
fn trapped(rng: &mut SampleStream) -> Ray {
    let critical = (1.0 - 1.0 / (INDEX * INDEX)).sqrt();
    within_cube(rng, |cosine| cosine < critical - 1e-6)
}

fn from_outside(rng: &mut SampleStream) -> Ray {
    let target = DVec3::new(uniform(rng), uniform(rng), uniform(rng)) - 0.5;
    let origin = DVec3::new(2.7, -3.9, 2.1);
    Ray::new(origin, (target - origin).normalize())
}

fn cubes() -> Vec<FamilyTrial<EstimatorSubject>> {
    let [outside, inside] = [false, true].map(|inside| valid(glass_cube(inside)));
    let n2 = INDEX * INDEX;
    vec![
        radiance(
            "glass/cube-outside",
            &FRESNEL,
            &outside,
            EstimatorKind::Path,
            from_outside,
        )
        .states(
            "a glass cube under a white sky shows 1 from outside",
            "a block of glass has dark areas under a white sky, as in mmp/pbrt-v3#254",
        )
        .by_rays(1.0, BOUNCES_DELTA, 1_000_000),
        radiance(
            "glass/cube-inside",
            &REFRACTION,
            &inside,
            EstimatorKind::Path,
            leaving,
        )
        .states(
            "from inside it a glass cube under a white sky shows n² in directions that can leave",
            "the world seen from within glass is as dim as from outside",
        )
        .by_rays(n2, BOUNCES_DELTA, 1_300_000),
        radiance(
            "glass/cube-trapped",
            &FRESNEL,
            &inside,
            EstimatorKind::Path,
            trapped,
        )
        .states(
            "from inside it a glass cube shows nothing in directions that total reflection traps",
            "light seeps into a block of glass at angles at which none can enter",
        )
        .by_rays(0.0, 0.0, 1_600_000),
    ]
}

/// Trial of a sphere of index 1 between light and floor: shadow rays stop at it, paths pass through
/// it.
fn vanishing() -> FamilyTrial<EstimatorSubject> {
    let scene = scene("index-matched sphere", |s| {
        floor(s, lambert(FLOOR));
        square(s, HEIGHT * DVec3::Z, 1.0, false, light(LIGHT));
        ball(
            s,
            Sphere::new(DVec3::new(0.1, 0.0, 1.3), 0.5),
            Surface::new(Bsdf::Glass { index: 1.0 }),
        );
    });
    let reference = reflected(polygon_irradiance(&RECTANGLE));
    radiance(
        "glass/index-matched",
        &REFRACTION,
        &scene,
        EstimatorKind::Path,
        |_| ray_to_origin(),
    )
    .states(
        "a sphere of index 1 before a light changes nothing",
        "a body that bends no light casts a shadow on a floor, or brightens it",
    )
    .by_scrambles(reference, IMAGE_DELTA, 64, 15_800)
}
