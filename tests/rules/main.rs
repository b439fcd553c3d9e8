//! The registry as data, and what its trials compare with.

mod budget; // everything that chance can turn red, counted
mod calibration; // error rates and power of the statistics, at a small size
mod closed_forms;
mod data; // what trials and faults say of themselves
#[expect(dead_code, reason = "other tables are for the tests of the library")]
#[path = "../library/reference.rs"]
mod reference; // tables of reference values
#[path = "../library/shares.rs"]
mod shares; // what the other target uses of the error budget
