//! Rules of the registry, its reference values, and rules of style for the sources.

mod budget; // all random outcomes, counted
mod calibration; // error rates and power of the statistics, at a small size
mod closed_forms;
mod data; // names, claims and controls of trials and faults
mod dependencies; // packages that are held back
mod modules; // layers of the library
mod prose; // documentation comments and parameters
