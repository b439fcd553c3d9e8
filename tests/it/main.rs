//! The integration tests, one crate; one module per kind of evidence.

// Exact: identities, closed forms and stored values of the library, module by module.
mod bsdf;
mod camera;
mod estimator;
mod film;
mod frame;
mod fresnel;
mod geometry;
mod helpers; // what the exact modules share
mod hierarchy;
mod image;
mod moments;
mod pixel;
mod radiometry;
mod radiosity;
mod reference; // tables of reference values
mod render;
mod rng;
mod roulette;
mod sampling;
mod scene;
mod seed; // the master seed and what is derived from it
mod spheres;
mod watertight;

// Statistical: what only sampling can show, with its error budget.
mod calibration; // error rates and power of the statistics, at a small size
mod checkup; // the BSDF check-up on a BSDF that is not ours, and on faulty ones
mod references; // closed forms of the trials against reference values
mod statistics; // the statistics' own code, tested exactly
mod support; // what the statistical modules share
mod tails; // tails and quantiles against reference values
mod traceability; // equation, code, trial, experiment, chapter: nothing is missing
mod trials; // the registry: every trial and its negative controls
mod zoo; // every fault under the trials that must reject it
