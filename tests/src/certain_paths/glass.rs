//! Light and glass with certain values: thermal equilibrium, and photons that are looked up through
//! glass.

use whitefurnace::integrator::{Lookup, TransportRules};

use crate::certain_paths::eye::{Eye, PARTICLES, UNBOUNDED_RADIUS};
use crate::certain_paths::{ENDLESS, every_pixel_known};
use crate::glass::{GLASS, INDEX};
use crate::prelude::*;
use crate::scenes::{self, LIGHT, TINT, hollow, lambert, light, seen_by};

/// Segments of the estimators that have a limit: Whitted's tree leaves out R^11 < 10⁻¹³.
const MAX_SEGMENTS: u32 = 12;
/// Radius of the ball in the glass.
const BALL: f64 = 0.3;

/// Builds a ball within glass within a wall, seen from a point on the z axis at this height.
fn glass(name: &str, height: f64, half: f64, up: bool, [wall, ball]: [Surface; 2]) -> Arc<Scene> {
    let eye = height * DVec3::Z;
    let target = if up { eye + DVec3::Z } else { DVec3::ZERO };
    seen_by(Camera::new(eye, target, DVec3::Y, half), name, |s| {
        hollow(s, 2.0, wall);
        scenes::ball(s, Sphere::new(DVec3::ZERO, 0.95), Surface::new(GLASS));
        scenes::ball(s, Sphere::new(DVec3::ZERO, BALL), ball);
    })
}

/// Names of the trials, in the order of [`Eye::all`].
const EQUILIBRIUM: [&str; 6] = [
    "glass/equilibrium/path",
    "glass/equilibrium/photons",
    "glass/equilibrium/sppm",
    "glass/equilibrium/bdpt",
    RULED[0],
    RULED[1],
];
const RULED: &[&str] = &["glass/equilibrium/report", "glass/equilibrium/whitted"];
pub(super) const PHOTON_LOOKUPS: &[&str] = &["glass/photons/direct", "glass/photons/gather"];

pub(super) fn equilibrium() -> Vec<FamilyTrial<EstimatorSubject>> {
    let n2 = INDEX * INDEX;
    let surfaces = [light(1.0), light(n2)];
    let scenes = [
        (
            glass("within, towards the ball", 0.5, 1.0, false, surfaces),
            n2,
        ),
        (glass("within, outwards", 0.5, 1.0, true, surfaces), n2),
        (glass("from outside", 1.4, 0.25, false, surfaces), 1.0),
    ];
    let family_trial = |(name, eye): (_, Eye)| {
        every_pixel_known(
            name,
            &REFRACTION,
            format!("in thermal equilibrium the radiance is {n2} within glass and 1 outside"),
            format!(
                "what lies in glass is n² too bright or too dark by {}",
                eye.method()
            ),
            eye,
            scenes.to_vec(),
        )
    };
    let eyes = Eye::all(MAX_SEGMENTS);
    EQUILIBRIUM
        .into_iter()
        .zip(eyes)
        .map(family_trial)
        .collect()
}

/// Trials of photons beyond glass: light of a ball in the glass that is looked up on the wall from
/// within the glass, and reflected light that is looked up on the ball from outside.
pub(super) fn photon_lookups() -> Vec<FamilyTrial<EstimatorSubject>> {
    let n2 = INDEX * INDEX;
    let black = Surface::new(lambert(0.0));
    let surfaces = [black, black.emitting(LIGHT * TINT)];
    let flux = PI * LIGHT * 4.0 * PI * BALL * BALL;
    let scenes = vec![
        (
            glass("the wall from within", 0.6, 0.5, true, surfaces),
            n2 * flux,
        ),
        (
            glass("the ball from outside", 1.4, 0.05, false, surfaces),
            (LIGHT + flux) / n2,
        ),
    ];
    let gather = Lookup::FinalGather {
        caustic_particles: PARTICLES,
        caustic_radius: UNBOUNDED_RADIUS,
    };
    let family_trial = |name, consequence, lookup| {
        every_pixel_known(
            name,
            &REFRACTION,
            format!("photons of {flux:.6} beyond glass look n² as bright from within"),
            consequence,
            Eye::Photons(lookup),
            scenes.clone(),
        )
    };
    vec![
        family_trial(
            PHOTON_LOOKUPS[0],
            "photons on the bottom of a pool look n² too bright or dark through the water",
            Lookup::DirectVisualization,
        ),
        family_trial(
            PHOTON_LOOKUPS[1],
            "caustics seen through glass are n² too bright or dark by final gathering",
            gather,
        ),
    ]
}

/// Faults of the factor by which refraction scales radiance.
pub(super) fn factors(
    table: PartTable,
    rejected_by: &'static [&'static str],
) -> Vec<Fault<EstimatorSubject>> {
    let fault = |name, wrong, radiance_factor: fn(f64, f64) -> f64| {
        let subject = parts(PartTable {
            radiance_factor,
            ..table
        });
        fault(name, &REFRACTION, wrong, subject, rejected_by)
    };
    vec![
        fault(
            "factor-missing",
            "refraction leaves radiance as it is",
            |_, _| 1.0,
        ),
        fault(
            "factor-twice",
            "refraction scales radiance by (n₁/n₂)⁴",
            |n1, n2| (n1 / n2).powi(4),
        ),
        fault(
            "factor-inverted",
            "refraction scales radiance by (n₂/n₁)²",
            |n1, n2| (n2 / n1).powi(2),
        ),
    ]
}

/// Faults of the trials of equilibrium.
pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    let mut faults = factors(ENDLESS, &EQUILIBRIUM);
    let rules = TransportRules {
        radiance_factor: false,
        ..TransportRules::PHYSICAL
    };
    let subject = EstimatorSubject {
        rules,
        ..parts(ENDLESS)
    };
    faults.push(fault(
        "rules-without-factor",
        &REFRACTION,
        "the rules leave radiance as it is",
        subject,
        RULED,
    ));
    faults
}
