//! Parallel iterators of rayon; without the feature `render`, iterators of one thread in their
//! place.

#[cfg(feature = "render")]
pub(super) use rayon::prelude::*;

/// Conversion into an iterator, under the name of rayon's conversion into a parallel one.
#[cfg(not(feature = "render"))]
pub(super) trait IntoParallelIterator: IntoIterator + Sized {
    /// Returns the iterator.
    fn into_par_iter(self) -> Self::IntoIter {
        self.into_iter()
    }
}

#[cfg(not(feature = "render"))]
impl<T: IntoIterator> IntoParallelIterator for T {}
