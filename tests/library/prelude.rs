//! What most modules of these tests use.

pub use crate::helpers::*;
pub use crate::support::{context, master, property, rng};
pub use approx::{assert_abs_diff_eq, assert_relative_eq};
pub use glam::DVec3;
pub use proptest::prelude::*;
pub use rand::Rng;
pub use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
pub use whitefurnace::bsdf::{Bsdf, OrenNayar, OrenNayarForm, Scattering, lambert};
pub use whitefurnace::camera::Camera;
pub use whitefurnace::emitter::{Emitter, EmitterShape, LightSampling};
pub use whitefurnace::error::Error;
pub use whitefurnace::estimator::photon_map::{Kept, PhotonMap};
pub use whitefurnace::estimator::radiosity::Fineness;
pub use whitefurnace::estimator::{
    Bdpt, Bidirectional, Estimator, ImageEstimator, LightRules, LightTracer, Lookup, NextEvent,
    PhotonMapping, Photons, Published, Radiosity, Report, Sppm, Standard, Whitted,
};
pub use whitefurnace::film::{Features, Film, Pixel, Window};
pub use whitefurnace::frame::{Frame, from_spherical, to_spherical};
pub use whitefurnace::moments::{ExactMoments, LARGEST, Moments, UNIT};
pub use whitefurnace::pixel::PixelSampling::{self, Centre, Grid, Jitter, Random};
pub use whitefurnace::render::{Numbers, Sampling, render, render_passes};
pub use whitefurnace::rng::{seed_for, stream, uniform, uniform2};
pub use whitefurnace::roulette::Roulette;
pub use whitefurnace::sampler::Sampler;
pub use whitefurnace::sampling::{cosine_hemisphere, cosine_hemisphere_pdf, uniform_hemisphere};
pub use whitefurnace::scene::room::{self, Convention};
pub use whitefurnace::scene::simple::{self, Cap};
pub use whitefurnace::scene::{
    EDGE_MARGIN, Geometry, Hit, Scene, SceneBuilder, Surface, SurfaceId,
};
pub use whitefurnace::shape::{Ray, Sphere};
