//! The replaceable parts of an estimator: the library's own functions, or others in their place.

use std::fmt;
use std::ops::Deref;

use super::{Bidirectional, DefaultParts, FiniteElements, NextEvent, Photons};
use crate::material::Scattering;
use crate::sampling::roulette::Roulette;

/// All functions of estimators that can be replaced.
pub trait Replacement:
    Scattering + Roulette + NextEvent + Photons + Bidirectional + FiniteElements
{
}

impl<P: Scattering + Roulette + NextEvent + Photons + Bidirectional + FiniteElements> Replacement
    for P
{
}

/// The parts of an estimator: [`DefaultParts`] unless they are replaced.
///
/// Each estimator is compiled twice, both times in this crate: for the default parts, which are
/// called directly, and for replaced ones behind a pointer. It dereferences to the functions.
#[derive(Clone, Copy, Default)]
pub struct Parts<'a>(pub(super) Option<&'a dyn Replacement>);

impl<'a> Parts<'a> {
    /// Returns these functions in place of the library's own.
    pub const fn replaced(by: &'a dyn Replacement) -> Self {
        Self(Some(by))
    }

    /// Returns whether nothing is replaced.
    pub const fn are_default(self) -> bool {
        self.0.is_none()
    }
}

impl<'a> Deref for Parts<'a> {
    type Target = dyn Replacement + 'a;
    fn deref(&self) -> &Self::Target {
        self.0.unwrap_or(&DefaultParts)
    }
}

impl fmt::Debug for Parts<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.are_default() {
            "DefaultParts"
        } else {
            "replaced parts"
        })
    }
}

/// Evaluates an expression with a reference to the parts, of either type.
macro_rules! with_parts {
    ($parts:expr, |$name:ident| $value:expr) => {
        match $parts.0 {
            None => {
                let $name = &$crate::integrator::DefaultParts;
                $value
            }
            Some($name) => $value,
        }
    };
}
pub(crate) use with_parts;
