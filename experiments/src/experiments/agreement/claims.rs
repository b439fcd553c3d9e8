//! What is claimed of each estimator on each scene, and how many images that takes.

use clap::ValueEnum as _;
use whitefurnace::scene::simple::CAP_SHARE;

use super::left_out::Method;
use crate::experiments::prelude::*;

/// The scenes, with the mean radiance of every pixel where a closed form gives it.
pub(super) const SCENES: [(SceneName, Option<f64>); 7] = [
    (SceneName::DiffuseRoom, None),
    (SceneName::Report, None),
    (SceneName::Cornell, None),
    (SceneName::FurnaceBox, Some(4.0)),
    (SceneName::CavityCap, None),
    (SceneName::Environment, Some(1.0)),
    (SceneName::GlassCube, Some(1.0)),
];

/// What is claimed of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Claim {
    /// Within the margin of the tier.
    Equal,
    /// Within this share, for a reason that is known.
    Biased(f64, &'static str),
    /// Within the margin of the tier once what it leaves out is added.
    Lacks(Lack, &'static str),
}

/// How it is known what a method leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Lack {
    /// In closed form: this much radiance in every pixel.
    Known(f64),
    /// By a walk of its own that counts the paths which the method does not follow.
    Counted(Method),
}

const DENSITY: &str = "density estimation blurs over its radius";
const MESH: &str = "the mesh of finite elements";
const NOT_SEEN: &str = "the eye sees nothing in mirrors and through glass";
const DIRECT_ONLY: &str = "emission and the direct light of the first diffuse surface alone, seven segments";
const SEVEN: &str = "cut after seven segments";

/// The albedo of the cavity.
const CAVITY: f64 = 0.75;

/// What reaches every point of the cavity by `bounces` reflections or more: a geometric series.
fn cavity_from(bounces: i32) -> f64 {
    CAP_SHARE * CAVITY.powi(bounces) / (1.0 - CAVITY)
}

/// What is claimed of an estimator on a scene; `None` where it is not defined or its variance infinite.
pub(super) fn claim(scene: SceneName, estimator: EstimatorName) -> Option<Claim> {
    use EstimatorName as E;
    use SceneName as S;
    let lit_by_background = matches!(scene, S::Environment | S::GlassCube);
    let specular = matches!(scene, S::Report | S::Environment | S::GlassCube);
    let lacks = |method, bounces, why| match scene {
        S::CavityCap => Claim::Lacks(Lack::Known(cavity_from(bounces)), why),
        _ => Claim::Lacks(Lack::Counted(method), why),
    };
    Some(match estimator {
        E::Mis | E::Bsdf | E::Bdpt | E::BdptEnds => Claim::Equal,
        // Points uniform in area on walls that meet: the geometry term has no bound.
        E::Light | E::Whitted | E::Report if scene == S::FurnaceBox => return None,
        E::Light => Claim::Equal,
        E::LightTracer | E::Photon | E::Sppm if lit_by_background => return None,
        E::LightTracer if scene == S::Report => Claim::Lacks(Lack::Counted(Method::LightTracer), NOT_SEEN),
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
    /// For lines of the table.
    pub fn label(&self) -> String {
        format!("{}: {}", name(self.scene), name(self.estimator))
    }

    /// For names of files and numbers.
    pub fn key(&self) -> String {
        format!("{}.{}", name(self.scene), name(self.estimator))
    }
}

/// Within which image means must agree. The lights of the Cornell box and the caustics of the report's room
/// make the standard deviation of one image's mean some ten per cent and more: half a per cent would take
/// an hour.
pub(super) fn margin(scene: SceneName, tier: Tier) -> f64 {
    match (tier, scene) {
        (Tier::Quick, _) => 0.02,
        (Tier::Full, SceneName::Report | SceneName::Cornell) => 0.01,
        (Tier::Full, _) => 0.005,
    }
}

/// Images of a case per run, by what its noise asks for: most of it is that of pixels on the border of a
/// light, which particles do not have.
pub(super) fn replications(case: &Case, tier: Tier) -> u64 {
    use EstimatorName as E;
    let (quick, full) = match case.estimator {
        E::Mis => (4_800, 60_000),
        E::Bsdf => (4_800, 40_000),
        E::Light => (1_000, 30_000),
        E::LightTracer => (400, 12_000),
        E::Bdpt => (200, 3_000),
        E::BdptEnds => (400, 6_000),
        E::Photon => (1_500, 3_000),
        E::Sppm => (400, 2_000),
        E::Radiosity => (1_500, 3_000),
        E::Whitted | E::Report => (1_500, 16_000),
    };
    match (tier, case.scene, case.estimator) {
        (Tier::Quick, SceneName::Environment, E::Whitted) => quick / 4,
        (Tier::Quick, SceneName::Environment | SceneName::FurnaceBox, E::Mis | E::Bsdf) => quick / 8,
        (Tier::Quick, SceneName::Environment, _) => quick / 8,
        // The mesh solves it exactly.
        (_, SceneName::FurnaceBox, E::Radiosity) => 100,
        (Tier::Quick, SceneName::FurnaceBox, E::Photon) => quick / 2,
        (Tier::Quick, SceneName::FurnaceBox, E::Sppm) => 2 * quick,
        (Tier::Quick, ..) => quick,
        (Tier::Full, SceneName::Cornell, E::Photon | E::Radiosity) => 4 * full,
        (Tier::Full, SceneName::Report, E::Whitted | E::Report) => full / 2,
        // A tree of glass for each sample.
        (Tier::Full, SceneName::Environment | SceneName::GlassCube, E::Whitted) => full / 8,
        (Tier::Full, SceneName::DiffuseRoom | SceneName::Cornell, _)
        | (Tier::Full, SceneName::Report, E::Bdpt | E::BdptEnds | E::Photon)
        | (Tier::Full, SceneName::CavityCap, E::LightTracer | E::Bdpt | E::BdptEnds)
        | (Tier::Full, SceneName::FurnaceBox, E::Photon) => full,
        (Tier::Full, ..) => full / 4,
    }
}

/// Images of the walk that counts what methods leave out. It never looks at a light straight, where most
/// of the noise of images is.
pub(super) fn replications_left_out(scene: SceneName, tier: Tier) -> u64 {
    match (tier, scene) {
        (Tier::Quick, SceneName::Environment) => 600,
        (Tier::Quick, _) => 1_200,
        (Tier::Full, SceneName::Environment | SceneName::GlassCube) => 4_000,
        (Tier::Full, _) => 15_000,
    }
}

/// Quick: the named subset. Full: all.
pub(super) fn cases(tier: Tier) -> Vec<Case> {
    let all = SCENES.iter().flat_map(|&(scene, _)| {
        EstimatorName::value_variants().iter().filter_map(move |&estimator| {
            let claim = claim(scene, estimator)?;
            Some(Case { scene, estimator, claim })
        })
    });
    let quick = [SceneName::DiffuseRoom, SceneName::FurnaceBox, SceneName::Environment];
    all.filter(|case| tier == Tier::Full || quick.contains(&case.scene)).collect()
}
