//! Faults of whole estimators. The trials of their family are in [`super::furnace`],
//! [`super::irradiance`], [`super::strategies`], [`super::specular_chains`],
//! [`super::environment_map`], [`super::glass`], [`super::rough_glass`], [`super::images`],
//! [`super::specular_nee`] and [`super::near_coincident`].

mod interfaces;
mod light_sampling;
mod lights;
mod reflection;
mod sampling;

use whitefurnace::integrator::TransportRules;
use whitefurnace::sampling::warp::{cosine_hemisphere, uniform_hemisphere};

use crate::prelude::*;
use crate::{
    cie, environment_map, furnace, glass, glass_bodies, images, irradiance, near_coincident,
    rough_glass, specular_chains, specular_nee, strategies,
};

/// Trials and faults of whole estimators.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let mut trials = furnace::trials();
    trials.extend(irradiance::trials());
    trials.extend(strategies::trials());
    trials.extend(specular_chains::trials());
    trials.extend(glass::trials());
    trials.extend(glass_bodies::trials());
    trials.extend(rough_glass::trials());
    trials.extend(cie::trials());
    trials.extend(environment_map::trials());
    trials.extend(images::trials());
    trials.extend(specular_nee::trials());
    trials.extend(near_coincident::trials());
    vec![Box::new(Family {
        trials,
        faults: faults(),
        equivalents: equivalents(),
        ..Family::whole("estimator", STANDARD)
    })]
}

/// Faults of whole estimators.
pub fn faults() -> Vec<Fault<EstimatorSubject>> {
    let mut faults = reflection::faults();
    faults.extend(sampling::faults());
    faults.extend(lights::faults());
    faults.extend(light_sampling::faults());
    faults.extend(interfaces::faults());
    faults.extend(configuration_faults());
    faults.extend(environment_map::faults());
    faults.extend(specular_nee::faults());
    faults.extend(near_coincident::faults());
    faults
}

/// Faults in the configuration of an estimator.
fn configuration_faults() -> Vec<Fault<EstimatorSubject>> {
    let rules = |rules| EstimatorSubject { rules, ..STANDARD };
    let segments = |segments| EstimatorSubject {
        segments: Some(segments),
        ..STANDARD
    };
    vec![
        fault!("seven-segments", PATH_LENGTH, "at most seven segments, called unbiased",
            = segments(7), "furnace/report/albedo-0.65"),
        fault!("four-segments", PATH_LENGTH, "one segment more than said",
            = segments(4),
            "furnace/report/three-segments", "furnace/path/three-segments", "furnace/report/rays-1", "furnace/report/rays-2", "furnace/report/cost-1",
            "furnace/report/cost-2", "furnace/report/cost-4"),
        fault!("three-segments", PATH_LENGTH, "one segment less than said",
            = segments(3), "irradiance/by-bodies/lens-four-segments"),
        fault!("not-seen-in-mirrors", WHITTED, "lights are dark to rays that have met only mirrors and glass",
            = rules(TransportRules { emitted_radiance: Some(0.0), ..TransportRules::PHYSICAL }), "glass/mirror-aim"),
        fault!("lights-show-one", WHITTED, "lights that are seen show 1, as in the report's figures",
            = rules(TransportRules { emitted_radiance: Some(1.0), ..TransportRules::PHYSICAL }), "glass/mirror-aim"),
        fault!("caustics-left-out", RENDERING,
            "no light that is hit after a diffuse surface counts, found by shadow rays or not",
            = rules(TransportRules { caustics: false, ..TransportRules::PHYSICAL }),
            "irradiance/after-mirror/report", "irradiance/after-glass/report"),
        fault!("rules-without-factor", REFRACTION, "the report's rules: radiance is not scaled by (n₁/n₂)²",
            = rules(TransportRules { radiance_factor: false, ..TransportRules::PHYSICAL }), "glass/snell-aim"),
    ]
}

fn equivalents() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("survival-constant", ROULETTE,
            "survival 0.9 whatever the throughput: every policy has the same mean",
            { survival_by_throughput: |_, _| 0.9 }, "furnace/cavity/black"),
        fault!("one-minus-r", COSINE_HEMISPHERE, "1 − r for r: as uniform as r",
            { cosine_hemisphere: |[r1, r2]| cosine_hemisphere([1.0 - r1, 1.0 - r2]) }, "furnace/sky/path"),
        fault!("uniform-with-its-weight", ESTIMATOR,
            "uniform directions with the uniform pdf: another density, the same mean",
            { cosine_hemisphere: uniform_hemisphere, cosine_hemisphere_pdf: |_| 0.5 * FRAC_1_PI },
            "furnace/light/sphere"),
    ]
}
