//! The agreement matrix: every estimator on every scene that it can handle, against closed forms and the
//! path tracer.

use whitefurnace::equation;
use whitefurnace::error::Error;
use whitefurnace::harness::mean::{Values, welch_moments};
use whitefurnace::harness::outcome::{Claim, Verdict, approximate_verdict};
use whitefurnace::harness::tails::student_upper;
use whitefurnace::harness::welch_map::{PValueMap, PixelStatistics, map};
use whitefurnace::moments::Moments;
use whitefurnace::rng::seed_for;

use crate::job::{EstimatorName, Job, SceneName, name};
use crate::lab::{Experiment, Lab, Tier};
use crate::ledger::{Ledger, number};
use crate::plot::agreement::{Square, histograms, squares};
use crate::suite::FAMILY;

/// Every estimator against the reference of its scene.
pub const AGREEMENT: Experiment = Experiment {
    id: "agreement",
    title: "estimator × scene: image means agree (accumulates over runs)",
    version: 1,
    equations: &[&equation::RENDERING, &equation::ESTIMATOR, &equation::WHITTED],
    run,
};
