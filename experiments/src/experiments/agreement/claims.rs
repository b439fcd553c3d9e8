//! Claims about each estimator on each scene, and the number of images they need.

use clap::ValueEnum as _;
use whitefurnace::scene::simple::CAP_SHARE;

use super::left_out::Method;
use crate::experiments::prelude::*;

/// Scenes, with the mean radiance of every pixel where a closed form gives it.
pub(super) const SCENES: [(SceneName, Option<f64>); 7] = [
    (SceneName::DiffuseRoom, None),
    (SceneName::Report, None),
    (SceneName::Cornell, None),
    (SceneName::FurnaceBox, Some(4.0)),
    (SceneName::CavityCap, None),
    (SceneName::Environment, Some(1.0)),
    (SceneName::GlassCube, Some(1.0)),
];

/// Claim about a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Claim {
    /// Equal within the margin of the tier.
    Equal,
    /// Equal within this relative bias, for a known reason.
    Biased(f64, &'static str),
    /// Equal within the margin of the tier once the light that the method leaves out is added.
    Lacks(MissingLight, &'static str),
}

/// Source of the amount of light that a method leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MissingLight {
    /// Closed form: this radiance in every pixel.
    Known(f64),
    /// Measured by a walk that counts the paths which the method does not sample.
    Measured(Method),
}

const DENSITY: &str = "density estimation blurs over its radius";
const MESH: &str = "the mesh of finite elements";
const NOT_SEEN: &str = "the eye sees nothing in mirrors and through glass";
const DIRECT_ONLY: &str =
    "emission and the direct light of the first diffuse surface alone, seven segments";
const SEVEN: &str = "cut after seven segments";

/// Albedo of the cavity.
const CAVITY: f64 = 0.75;

/// Returns the light that reaches every point of the cavity by `bounces` reflections or more: a
/// geometric series.
fn cavity_from(bounces: i32) -> f64 {
    CAP_SHARE * CAVITY.powi(bounces) / (1.0 - CAVITY)
}

/// Returns the claim about an estimator on a scene; `None` where it is not defined or its variance
/// infinite.
pub(super) fn claim(scene: SceneName, estimator: EstimatorName) -> Option<Claim> {
    use EstimatorName as E;
    use SceneName as S;
    let lit_by_background = matches!(scene, S::Environment | S::GlassCube);
    let specular = matches!(scene, S::Report | S::Environment | S::GlassCube);
    let lacks = |method, bounces, why| match scene {
        S::CavityCap => Claim::Lacks(MissingLight::Known(cavity_from(bounces)), why),
        _ => Claim::Lacks(MissingLight::Measured(method), why),
    };
    Some(match estimator {
        E::Mis | E::Bsdf | E::Bdpt | E::BdptEnds => Claim::Equal,
        // Points uniform in area on walls that meet: the geometry term is unbounded.
        E::Light | E::Whitted | E::Report if scene == S::FurnaceBox => return None,
        E::Light => Claim::Equal,
        E::LightTracer | E::Photon | E::Sppm if lit_by_background => return None,
        E::LightTracer if scene == S::Report => {
            Claim::Lacks(MissingLight::Measured(Method::LightTracer), NOT_SEEN)
        }
        E::LightTracer => Claim::Equal,
        E::Photon => Claim::Biased(0.02, DENSITY),
        E::Sppm => Claim::Biased(0.06, DENSITY),
        E::Radiosity if specular => return None,
        E::Radiosity => Claim::Biased(0.02, MESH),
        E::Whitted => lacks(Method::Whitted, 2, DIRECT_ONLY),
        // Seven segments and a shadow ray: seven reflections.
        E::Report => lacks(Method::Report, 8, SEVEN),
    })
}

pub(super) struct Case {
    pub scene: SceneName,
    pub estimator: EstimatorName,
    pub claim: Claim,
}

impl Case {
    /// Returns the name in lines of the table.
    pub fn label(&self) -> String {
        format!("{}: {}", name(self.scene), name(self.estimator))
    }

    /// Returns the name in file names and keys of numbers.
    pub fn key(&self) -> String {
        format!("{}.{}", name(self.scene), name(self.estimator))
    }
}

/// Returns the relative margin of image means. The lights of the Cornell box and the caustics of
/// the report's room make several times the noise.
pub(super) fn margin(scene: SceneName, tier: Tier) -> f64 {
    match (tier, scene) {
        (Tier::Quick, _) => 0.01,
        (Tier::Full, SceneName::Report | SceneName::Cornell) => 0.002,
        (Tier::Full, _) => 0.001,
    }
}

/// Measured standard deviation of an image's mean in per cent of the reference: of the estimators
/// in the order of their names, and the largest of the light that methods leave out. It only
/// decides the number of images. Path tracing under a sky of 1 has almost no noise, and so has the
/// light left out of the glass cube, but with skewness: these entries make up for Chebyshev's
/// intervals, or for the images that skewness needs.
#[rustfmt::skip]
const NOISE: [(SceneName, [f64; 11], f64); 7] = [
    //                          mis  bsdf light l.tr. bdpt  ends phot.  sppm radi. whit. report left
    // out
    (SceneName::DiffuseRoom, [1.25,  8.7, 1.25, 1.25, 0.70, 0.75, 1.8,  8.6, 1.2,  1.4,  1.5], 4.5),
    (SceneName::Report,      [ 3.2,  8.1,  4.1,  1.3,  5.7,  5.7, 5.4,  8.7, 0.0,  6.1,  7.4], 5.7),
    (SceneName::Cornell,     [ 2.4, 15.7,  2.4,  1.7,  1.1,  1.2, 2.7, 15.9, 2.0,  2.6,  2.8], 8.5),
    (SceneName::FurnaceBox,  [ 1.2,  1.3,  0.0,  2.9,  1.6,  1.9, 4.1,  6.5, 0.0,  0.0,  0.0], 0.0),
    (SceneName::CavityCap,   [ 1.3,  2.8,  1.3,  5.7,  1.7,  2.6, 2.8,  7.1, 0.0,  0.0,  3.3], 0.0),
    (SceneName::Environment, [ 1.0,  1.0,  1.0,  0.0,  0.4,  0.4, 0.0,  0.0, 0.0,  0.2,  0.5], 0.2),
    (SceneName::GlassCube,   [ 2.0,  2.0,  2.0,  0.0,  0.5,  0.5, 0.0,  0.0, 0.0,  0.0,  0.2], 1.2),
];

/// Half width of an interval in standard errors, at the level of a first look.
const HALF_WIDTH: f64 = 4.6;

/// Returns the number of images for which the half width of their mean's interval is `half`, in per
/// cent of the reference. Skewness needs a least number, whatever the noise.
fn images(noise: f64, half: f64, tier: Tier) -> u64 {
    let least = match tier {
        Tier::Quick => 400,
        Tier::Full => 4_000,
    };
    let enough = (HALF_WIDTH * noise / half).powi(2);
    (enough.ceil() as u64).max(least)
}

fn noise(scene: SceneName) -> ([f64; 11], f64) {
    NOISE
        .iter()
        .find(|(of, ..)| *of == scene)
        .map_or(([0.0; 11], 0.0), |&(_, methods, left_out)| {
            (methods, left_out)
        })
}

/// Returns the images of a case per run. The interval of the difference, to which the reference,
/// the method and the light it leaves out contribute, is then 0.6 of the margin on either side, or
/// about a fifth of a bias (two fifths at the quick tier).
pub(super) fn replications(case: &Case, tier: Tier) -> u64 {
    let margin = 100.0 * margin(case.scene, tier);
    let noise = noise(case.scene).0[case.estimator as usize];
    match (case.estimator, case.claim) {
        // The mesh solves these exactly.
        (EstimatorName::Radiosity, _) if noise == 0.0 => {
            if tier == Tier::Quick {
                10
            } else {
                100
            }
        }
        (EstimatorName::Mis, _) | (_, Claim::Lacks(..)) => images(noise, 0.3 * margin, tier),
        (_, Claim::Equal) => images(noise, 0.52 * margin, tier),
        (_, Claim::Biased(bias, _)) => images(
            noise,
            if tier == Tier::Quick { 0.4 } else { 0.2 } * 100.0 * bias,
            tier,
        ),
    }
}

/// Returns the images of the walk that measures the light that methods leave out.
pub(super) fn replications_left_out(scene: SceneName, tier: Tier) -> u64 {
    images(noise(scene).1, 0.42 * 100.0 * margin(scene, tier), tier)
}

/// Returns true if a few hundred images decide the case. They do not where left-out light is
/// measured path by path, where an image takes long, or where skewness needs thousands.
fn is_quick(scene: SceneName, estimator: EstimatorName) -> bool {
    use EstimatorName as E;
    match scene {
        SceneName::DiffuseRoom => !matches!(estimator, E::Radiosity | E::Whitted | E::Report),
        SceneName::FurnaceBox => {
            matches!(estimator, E::Mis | E::Bsdf | E::LightTracer | E::Radiosity)
        }
        SceneName::CavityCap => matches!(estimator, E::Mis | E::Light | E::Whitted | E::Report),
        SceneName::Environment => true,
        SceneName::Report | SceneName::Cornell | SceneName::GlassCube => false,
    }
}

/// Returns the cases of a tier: quick, those that few images decide; full, all.
pub(super) fn cases(tier: Tier) -> Vec<Case> {
    let all = SCENES.iter().flat_map(|&(scene, _)| {
        EstimatorName::value_variants()
            .iter()
            .filter_map(move |&estimator| {
                let claim = claim(scene, estimator)?;
                Some(Case {
                    scene,
                    estimator,
                    claim,
                })
            })
    });
    all.filter(|case| tier == Tier::Full || is_quick(case.scene, case.estimator))
        .collect()
}
