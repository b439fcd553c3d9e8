//! Tests of the library alone, one crate; one module per kind of evidence.

// Exact: identities, closed forms and stored values of the library, module by module.
mod bidirectional;
mod bsdf;
mod camera;
mod channels; // red stays red, through every estimator
mod defaults; // what no built-in scene uses: fallbacks, empty scenes, numbers at the end of their range
mod eon;
mod estimator;
mod film;
mod frame;
mod fresnel;
mod geometry;
mod graded;
mod helpers; // what the exact modules share
mod hierarchy;
mod image;
mod models; // reflection models that are not of the library
mod moments;
mod photon;
mod pixel;
mod radiometry;
mod radiosity;
mod reference; // tables of reference values
mod render;
mod replications; // numbers and error bars of every way of placing samples
mod rng;
mod roulette;
mod sampler;
mod sampling;
mod scene;
mod scene_tables; // every built-in scene against its table
mod sequential; // thresholds and errors of the sequential test, exactly
mod sobol;
mod solid_angle;
mod spheres;
mod support; // the master seed and what is derived from it
mod swallowed; // what is no radiance surfaces as an error
mod watertight;

// What chance can turn red, module by module.
mod budget;
mod shares; // the same as data, for the budget of the whole suite

// Statistical: what only sampling can show, with its error budget.
mod calibration; // error rates and power of the statistics, at a small size
mod checkup; // the BSDF check-up on a BSDF that is not ours, and on faulty ones
mod checkup_parts; // what each part of the check-up reports
mod counts; // chi-square, Kolmogorov-Smirnov and Welch maps on small sets
mod degenerate;
mod domains; // where samplers put their points, and the masses of cells
mod failures; // what a red trial says
mod guard; // which outcomes are too small for the error budget
mod lobes; // the check-ups of paper, mirrors and glass, and of faulty ones
mod means; // tests of means against textbook formulas
mod power; // stated power, against closed forms and sums over whole laws
mod rates; // orders of convergence, ratios of variances, sequential tests
mod rows; // the rules that trials are run by
mod specular;
mod statistics; // the statistics' own code, tested exactly
mod tails; // tails and quantiles against reference values
mod verdicts; // what an outcome says, at the borders of its claim
