//! Settings shared by a run of trials: seed, scale, folder.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use super::shared::Shared;
use crate::error::Error;
use crate::sampling::rng::{Stream, seed_for, stream};
use crate::shard::{SHARD_FORMAT, Shard};

/// Master seed if `WHITEFURNACE_SEED` is not set.
pub const DEFAULT_SEED: u64 = 2019;

/// Scales allowed for `WHITEFURNACE_SCALE`: below, statistics are undefined; above, samples
/// outnumber the streams.
pub const SCALES: RangeInclusive<f64> = 1e-4..=256.0;

/// Settings shared by a run of trials: master seed, scale of sample sizes, folder for data files.
#[derive(Clone, Debug, PartialEq)]
pub struct Context {
    /// Master seed; every trial's stream is derived from it and the trial's name.
    pub seed: u64,
    /// Factor of all sample sizes.
    pub scale: f64,
    /// Folder for data files of failures; created when needed.
    pub folder: PathBuf,
    /// Name of the trial (and subject) that the random streams are derived from.
    pub name: String,
    /// Names of the outcomes that are asked for: those that must reject a fault. All if it is
    /// empty.
    pub asked: Vec<&'static str>,
    /// Values of [`once`](Self::once) from runs on other parts of the sample.
    pub shared: Shared,
}

impl Context {
    /// Creates a context with the given seed and scale (positive and finite).
    ///
    /// # Errors
    /// [`Error::Option`] for a scale that is not positive and finite.
    pub fn new(seed: u64, scale: f64) -> Result<Self, Error> {
        if !(scale.is_finite() && scale > 0.0) {
            return Err(Error::Option(format!(
                "the scale of sample sizes is {scale}; it must be a positive number such as 16 or 0.25"
            )));
        }
        Ok(Self {
            seed,
            scale,
            folder: PathBuf::from("target/trials"),
            name: String::new(),
            asked: Vec::new(),
            shared: Shared::default(),
        })
    }

    /// Reads `WHITEFURNACE_SEED` (default [`DEFAULT_SEED`]) and `WHITEFURNACE_SCALE` (default 1).
    /// Nothing else in the library reads the environment but [`shard_from_environment`].
    ///
    /// # Errors
    /// [`Error::Option`] if one of them is not a number, or the scale is not among [`SCALES`].
    pub fn from_environment() -> Result<Self, Error> {
        let seeds = "a whole number from 0 to 18446744073709551615, such as 2019";
        let (low, high) = (SCALES.start(), SCALES.end());
        let scales = format!("a number from {low} to {high}, such as 16");
        let is_scale = |scale: &f64| SCALES.contains(scale);
        Self::new(
            read("WHITEFURNACE_SEED", DEFAULT_SEED, seeds, |_: &u64| true)?,
            read("WHITEFURNACE_SCALE", 1.0, &scales, is_scale)?,
        )
    }

    /// Returns the context for the trial or test with this name.
    pub fn named(&self, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..self.clone()
        }
    }

    /// Returns whether an outcome whose name ends like this is asked for. A trial may leave out
    /// outcomes that are not, if they take long and the others have random numbers of their own.
    pub fn asks_for(&self, ending: &str) -> bool {
        self.asked.is_empty() || self.asked.iter().any(|name| name.ends_with(ending))
    }

    /// Returns what `make` makes. A fault runs on several parts of the sample, one after another:
    /// what does not depend on the sample is made once for all of them.
    pub fn once<T: Send + Sync + 'static>(&self, name: &str, make: impl FnOnce() -> T) -> Arc<T> {
        self.shared.once(format!("{}: {name}", self.name), make)
    }

    /// Returns the seed of a part of this trial; independent for different trials and parts.
    pub fn seed_of(&self, part: &str) -> u64 {
        seed_for(seed_for(self.seed, &self.name), part)
    }

    /// Returns whether the [`guard`](crate::harness::guard) judges sample sizes in this run: under
    /// the default seed, at scale 1 or above.
    pub fn guard_applies(&self) -> bool {
        self.seed == DEFAULT_SEED && self.scale >= 1.0
    }

    /// Returns the random stream of a part of this trial.
    pub fn rng(&self, part: &str) -> Stream {
        stream(self.seed_of(part), 0, 0)
    }

    /// Returns a sample size at this scale, at least 2.
    pub fn n(&self, samples: u64) -> u64 {
        ((samples as f64 * self.scale).round() as u64).max(2)
    }

    /// Returns the number of arguments of an exact identity: not reduced at scales below 1, as an
    /// identity cannot turn undecided for lack of samples.
    pub fn arguments(&self, count: u64) -> u64 {
        (count as f64 * self.scale.max(1.0)).round() as u64
    }
}

/// Reads a variable of the environment; `expected` says in words which values `fits` allows.
fn read<T: FromStr>(
    name: &str,
    default: T,
    expected: &str,
    fits: impl Fn(&T) -> bool,
) -> Result<T, Error> {
    let Some(text) = std::env::var_os(name) else {
        return Ok(default);
    };
    let value = text.to_str().and_then(|text| text.trim().parse().ok());
    value.filter(fits).ok_or_else(|| {
        Error::Option(format!(
            "{name} is '{}': set it to {expected}, or unset it",
            text.display()
        ))
    })
}

/// Reads `WHITEFURNACE_SHARD`: the part of a suite of tests to run; all if it is not set.
///
/// # Errors
/// [`Error::Option`] if the value is not a shard.
pub fn shard_from_environment() -> Result<Shard, Error> {
    let any = |_: &Shard| true;
    read("WHITEFURNACE_SHARD", Shard::WHOLE, SHARD_FORMAT, any)
}
