//! Values that do not depend on a sample's size, shared by runs on several parts of it.

use std::any::Any;
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Values that the runs of a trial on parts of its sample have in common, for
/// [`Context::once`](super::Context::once). The default shares nothing.
#[derive(Clone, Default)]
pub struct Shared(Option<Arc<Part>>);

/// A value's name, and its number among those of that name in its run.
type Key = (String, usize);

/// A run on a part of the sample.
struct Part {
    values: Arc<Mutex<HashMap<Key, Arc<dyn Any + Send + Sync>>>>,
    /// Number of values of each name that this run has used.
    used: Mutex<HashMap<String, usize>>,
}

impl Shared {
    /// Creates the values for the next run, which shares those of this one. That of the default
    /// shares none with any other.
    pub(super) fn next_run(&self) -> Self {
        let values = self.0.as_ref().map(|part| Arc::clone(&part.values));
        Self(Some(Arc::new(Part {
            values: values.unwrap_or_default(),
            used: Mutex::default(),
        })))
    }

    /// Returns the value of this name from an earlier run, or makes it. Values of the same name
    /// within a run are told apart by their order.
    pub(super) fn once<T: Send + Sync + 'static>(
        &self,
        name: String,
        make: impl FnOnce() -> T,
    ) -> Arc<T> {
        let Some(part) = &self.0 else {
            return Arc::new(make());
        };
        let number = {
            let mut used = lock(&part.used);
            let count = used.entry(name.clone()).or_default();
            *count += 1;
            *count
        };
        let key = (name, number);
        let earlier = lock(&part.values).get(&key).cloned();
        if let Some(Ok(value)) = earlier.map(Arc::downcast) {
            return value;
        }
        let made = Arc::new(make());
        let value: Arc<dyn Any + Send + Sync> = Arc::<T>::clone(&made);
        lock(&part.values).insert(key, value);
        made
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl fmt::Debug for Shared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.0.as_ref().map(|part| lock(&part.values).len());
        f.debug_tuple("Shared").field(&count).finish()
    }
}

impl PartialEq for Shared {
    /// Returns whether both share the same values.
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(a), Some(b)) => Arc::ptr_eq(&a.values, &b.values),
            (a, b) => a.is_none() && b.is_none(),
        }
    }
}
