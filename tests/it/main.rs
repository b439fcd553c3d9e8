//! The integration tests, one crate; one module per kind of evidence.

mod statistics; // the statistics' own code against reference values
