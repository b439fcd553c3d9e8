//! The integration tests, one crate; one module per kind of evidence.

mod calibration; // error rates and power of the statistics, at a small size
mod checkup; // the BSDF check-up on a BSDF that is not ours, and on faulty ones
mod references; // pure functions against reference values
mod statistics; // the statistics' own code, tested exactly
mod support; // what the modules share
mod traceability; // equation, code, trial, experiment, chapter: nothing is missing
mod trials; // the registry: every trial and its negative controls
