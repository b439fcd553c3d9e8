//! Means of consecutive values, kept for the data file of a failing test: they show whether all
//! values are off, or only some.

use super::outcome::Cell;

/// Largest number of batches kept.
const MAX_BATCHES: usize = 64;

/// Means of batches of equal size; the size doubles whenever there are too many.
#[derive(Clone, Copy, Debug)]
pub struct Batches {
    /// Values per batch (`size`) and values in the batch that is not yet full (`pending`).
    size: u64,
    pending: u64,
    sum: f64,
    means: [f64; MAX_BATCHES],
    full: usize,
}

impl Default for Batches {
    fn default() -> Self {
        Self {
            size: 1,
            pending: 0,
            sum: 0.0,
            means: [0.0; MAX_BATCHES],
            full: 0,
        }
    }
}

impl Batches {
    /// Adds one value.
    #[inline]
    pub fn push(&mut self, value: f64) {
        self.sum += value;
        self.pending += 1;
        if self.pending == self.size {
            self.close();
        }
    }

    fn close(&mut self) {
        self.means[self.full] = self.sum / self.size as f64;
        (self.sum, self.pending) = (0.0, 0);
        self.full += 1;
        if self.full == MAX_BATCHES {
            for i in 0..MAX_BATCHES / 2 {
                self.means[i] = 0.5 * (self.means[2 * i] + self.means[2 * i + 1]);
            }
            (self.full, self.size) = (MAX_BATCHES / 2, 2 * self.size);
        }
    }

    /// Returns the batches of the values times `factor` plus `shift`.
    pub fn transformed(mut self, factor: f64, shift: f64) -> Self {
        let map = |x: &mut f64| *x = factor * *x + shift;
        self.means.iter_mut().for_each(map);
        self.sum = factor * self.sum + shift * self.pending as f64;
        self
    }

    /// Returns the means of the full batches: 32 to 63 of them once there are as many values.
    pub fn means(&self) -> &[f64] {
        &self.means[..self.full]
    }

    /// Returns the batches of values with this variance as cells against the mean `expected`;
    /// `prefix` begins their places.
    pub fn cells(&self, prefix: &str, expected: f64, variance: f64) -> Vec<Cell> {
        let standard_error = (variance / self.size as f64).sqrt();
        let cell = |(i, &observed): (usize, &f64)| {
            let place = format!("{prefix}batch {} ({} values)", i + 1, self.size);
            Cell::new(place, expected, observed, standard_error)
        };
        self.means().iter().enumerate().map(cell).collect()
    }
}
