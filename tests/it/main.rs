//! Exact tests of the library, one module per kind of evidence.

mod bsdf;
mod camera;
mod estimator;
mod film;
mod frame;
mod fresnel;
mod geometry;
mod helpers;
mod hierarchy;
mod image;
mod moments;
mod pixel;
mod radiometry;
mod reference;
mod render;
mod rng;
mod roulette;
mod sampling;
mod scene;
mod seed;
mod watertight;
