//! Common imports of experiments: runs, scenes, estimators, trials, random numbers, charts.

pub(super) use glam::DVec3;
pub(super) use whitefurnace::equation;
pub(super) use whitefurnace::error::Error;
pub(super) use whitefurnace::film::{Film, Window};
pub(super) use whitefurnace::geometry::shape::{Ray, Sphere, SurfacePoint};
pub(super) use whitefurnace::harness::mean::Values;
pub(super) use whitefurnace::harness::outcome::{
    ALPHA, CAPACITY, Claim, Outcome, Verdict, equivalence_verdict,
};
pub(super) use whitefurnace::harness::tails::{normal_upper, student_upper};
pub(super) use whitefurnace::harness::trial::{
    CSV_HEADER, Context, Row, Trial, group, required_outcomes, run_trial,
};
pub(super) use whitefurnace::image::{Display, write_png};
pub(super) use whitefurnace::integrator::radiosity::MeshResolution;
pub(super) use whitefurnace::integrator::{
    DefaultParts, Estimator, Heuristic, Lookup, Parts, Path, PhotonMapping, Radiosity, Sppm,
    Strategy, TransportRules,
};
pub(super) use whitefurnace::material::{Bsdf, OrenNayar, OrenNayarForm};
pub(super) use whitefurnace::math::moments::Moments;
pub(super) use whitefurnace::sampling::pixel::PixelSampling;
pub(super) use whitefurnace::sampling::rng::{Stream, seed_for, stream, uniform, uniform2};
pub(super) use whitefurnace::sampling::warp::{
    cosine_hemisphere, hemisphere_printed, uniform_hemisphere,
};
pub(super) use whitefurnace::scene::{Scene, SceneBuilder, Surface, room};

pub(super) use super::drawing::{charts, maps};
pub(super) use super::peers::recorded;
pub(super) use super::planes::{Planes, compare_planes, planes};
pub(super) use crate::plot::chart::{Chart, Mark, Series};
pub(super) use crate::plot::map::Map;
pub(super) use crate::render::{ConventionName, DiffuseName, EstimatorName, Job, SceneName, name};
pub(super) use crate::run::accumulated::Accumulated;
pub(super) use crate::run::pictures::{
    pixel_centres, radiance_along, random_points, render_film, render_paths, render_samples,
    write_row,
};
pub(super) use crate::run::progress::{Bar, interrupted};
pub(super) use crate::run::suite::{FAMILYWISE_LEVEL, parallel_map};
pub(super) use crate::run::{Experiment, Judgement, Run, Tier, suite};
