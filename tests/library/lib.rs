//! Reference values, and the shares of the error budget that the tests of the library use.

pub mod reference;
pub mod shares;
