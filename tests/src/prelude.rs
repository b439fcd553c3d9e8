//! Imports that trials and faults share: the equations by name, the harness, and the registry's own
//! types.

pub(crate) use std::f64::consts::{FRAC_1_PI, PI, TAU};
pub(crate) use std::sync::Arc;

pub(crate) use glam::DVec3;
pub(crate) use whitefurnace::camera::Camera;
pub(crate) use whitefurnace::equation::*;
pub(crate) use whitefurnace::geometry::shape::{Ray, Sphere, SurfacePoint};
pub(crate) use whitefurnace::harness::domain::{Domain, Partition};
pub(crate) use whitefurnace::harness::mean::{Values, mean};
pub(crate) use whitefurnace::harness::outcome::{Claim, Outcome};
pub(crate) use whitefurnace::harness::trial::Context;
pub(crate) use whitefurnace::integrator::{DefaultParts, Estimator, Parts, Path, Strategy};
pub(crate) use whitefurnace::material::{Bsdf, Scattering};
pub(crate) use whitefurnace::sampling::rng::{Stream, uniform, uniform2};
pub(crate) use whitefurnace::sampling::sampler::SampleStream;
pub(crate) use whitefurnace::scene::{Scene, SceneBuilder, Surface};

pub(crate) use crate::faults::{AnyFamily, Family, FamilyTrial, Fault, TrialFn, fault, trial};
pub(crate) use crate::mean_radiance::{
    BOUNCES_DELTA, CLOSED_FORM_DELTA, Draws, IMAGE_DELTA, Rays, mean_of, means, radiance,
};
pub(crate) use crate::subject::{
    CORRECT, Configuration, EstimatorKind, EstimatorSubject, PartTable, Probe, Property, STANDARD,
    fault, parts, with_parts,
};
