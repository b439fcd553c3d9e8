//! Imports of most modules of these tests.

pub use crate::helpers::*;
pub use crate::support::{context, folder, master, property, rng};
pub use approx::{assert_abs_diff_eq, assert_relative_eq};
pub use glam::DVec3;
pub use proptest::prelude::*;
pub use rand::Rng;
pub use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
pub use whitefurnace::camera::Camera;
pub use whitefurnace::error::{Error, MAX_RADIANCE as LARGEST};
pub use whitefurnace::film::{Features, Film, Pixel, Window};
pub use whitefurnace::geometry::offsets::EDGE_MARGIN;
pub use whitefurnace::geometry::shape::{Hit, Ray, Sphere, SurfacePoint};
pub use whitefurnace::integrator::photon::photon_map::{PhotonMap, PhotonMapKind};
pub use whitefurnace::integrator::radiosity::MeshResolution;
pub use whitefurnace::integrator::{
    Bdpt, Bidirectional, DefaultParts, Estimator, FiniteElements, Heuristic, ImageEstimator,
    LightTracer, Lookup, NextEvent, Parts, Path, PhotonMapping, Photons, Published, Radiosity,
    Report, Sppm, Strategy as PathStrategy, TransportRules, Whitted,
};
pub use whitefurnace::light::emitter::{Emitter, EmitterShape, LightSampling};
pub use whitefurnace::material::{Bsdf, OrenNayar, OrenNayarForm, Scattering, lambert};
pub use whitefurnace::math::frame::{Frame, from_spherical, to_spherical};
pub use whitefurnace::math::moments::{ExactMoments, FIXED_POINT_UNIT, Moments};
pub use whitefurnace::render::{
    ImageRenderer, LaneEstimator, LaneRenderer, Precision, RayRenderer, Renderer, render,
    render_lanes, render_passes,
};
pub use whitefurnace::sampling::Sampling;
pub use whitefurnace::sampling::pixel::PixelSampling;
pub use whitefurnace::sampling::pixel::PixelSampling::{Centre, Grid, Jitter, Random};
pub use whitefurnace::sampling::rng::{seed_for, stream, uniform, uniform2};
pub use whitefurnace::sampling::roulette::Roulette;
pub use whitefurnace::sampling::sampler::{ImagePass, Sampler, SamplerKind};
pub use whitefurnace::sampling::warp::{
    cosine_hemisphere, cosine_hemisphere_pdf, uniform_hemisphere,
};
pub use whitefurnace::scene::room::Convention;
pub use whitefurnace::scene::simple::Cap;
pub use whitefurnace::scene::{Geometry, Scene, SceneBuilder, Surface, SurfaceId, room, simple};
