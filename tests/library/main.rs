//! Tests of the library alone, in one crate: a module for each of the library's, and shared
//! helpers.
#![expect(
    clippy::single_range_in_vec_init,
    reason = "one range is a run in one piece"
)]

use library_tests::{reference, shares};

mod budget; // random tests, counted
mod helpers; // random geometry, meshes, scenes, films
mod prelude; // imports of most modules
mod support; // the master seed, and generators derived from it

mod harness;

mod accel;
mod adaptive;
mod bad_values; // invalid radiance is an error, wherever it is accumulated
mod bidirectional;
mod bsdf;
mod camera;
mod channels; // red stays red, in every estimator
mod checkpoints; // interrupted work, and its files
mod coincident;
mod corner_cases; // lights without solid angle, scenes without light, limits of zero, refusals
mod degenerate; // flat, coincident, nested, tiny, huge, not finite
mod environment; // maps of all directions
mod eon;
mod estimator;
mod features; // every pair of features in one scene, in every estimator
mod film;
mod frame;
mod fresnel;
mod geometry; // rays and triangles
mod ggx;
mod image;
mod image_read; // EXR of other programs, PFM, and refusals
mod lanes; // eight paths at a time, with the bits of one
mod light_sampler;
mod lights_without_extent; // refused, with a light that does the same
mod meshes; // OBJ files and meshes as other programs write them
mod models; // reflection models from outside the library
mod moments;
mod photon;
mod pixel;
mod radiometry;
mod radiosity;
mod render;
mod replications; // numbers and error bars of every sample placement
mod rng;
mod rough_glass;
mod roulette;
mod sampler; // Sobol' points
mod sampling;
mod scene;
mod scene_file; // scenes as data
mod scene_tables; // every built-in scene against its table
mod silhouettes; // silhouettes of lights that the camera sees
mod single_precision; // sixteen paths at a time in single precision
mod single_precision_coincidence; // single precision where surfaces are near to each other
mod single_precision_kernels; // functions of single-precision lanes
mod sizes; // wide, tall, odd, one, and beyond each threshold
mod solid_angle;
mod specular; // paths through mirrors and glass
mod specular_casters;
mod specular_connections;
mod sphere;
mod walks; // particles and paths in lanes, with the bits of one
mod watertight;
