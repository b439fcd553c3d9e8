//! Columns of a file of samples.

use glam::DVec3;
use whitefurnace::harness::directions::{Precision, Sample};

/// Names of the columns of samples.
pub(super) const NAMES: [&str; 5] = ["x", "y", "z", "weight", "pdf"];

/// Index in a row of each of [`NAMES`].
#[derive(Clone, Debug)]
pub(super) struct Columns {
    pub(super) places: [Option<usize>; NAMES.len()],
    count: usize,
}

impl Columns {
    /// Finds the columns by names; `None` if there are none.
    pub(super) fn by_names(names: &[String]) -> Result<Option<Self>, String> {
        if names.is_empty() {
            return Ok(None);
        }
        let mut columns = Self {
            places: [None; NAMES.len()],
            count: names.len(),
        };
        for (place, name) in names.iter().enumerate().filter(|(_, name)| *name != "-") {
            match NAMES.iter().position(|known| known == name) {
                Some(which) if columns.places[which].replace(place).is_none() => {}
                Some(_) => {
                    return Err(format!(
                        "the column {name} occurs twice: choose by --columns, with - for the others"
                    ));
                }
                None => {
                    return Err(format!(
                        "no column is called {name}: there are {}, and - for ignored ones (--columns)",
                        NAMES.join(", ")
                    ));
                }
            }
        }
        match columns.places[..3].iter().position(Option::is_none) {
            Some(missing) => Err(format!("there is no column {}", NAMES[missing])),
            None => Ok(Some(columns)),
        }
    }

    /// Finds the columns by a header, or in order.
    pub(super) fn found(header: Option<&[String]>, count: usize) -> Result<Self, String> {
        if let Some(columns) = Self::by_names(header.unwrap_or_default())? {
            return Ok(columns);
        }
        if !(3..=NAMES.len()).contains(&count) {
            return Err(format!(
                "{count} columns, where 3 to 5 are expected: name them by --columns{}",
                transposition_hint(count)
            ));
        }
        Ok(Self {
            places: std::array::from_fn(|which| (which < count).then_some(which)),
            count,
        })
    }

    /// Lists the columns as they are understood.
    pub(super) fn words(&self) -> String {
        let of = |place: usize| self.places.iter().position(|other| *other == Some(place));
        let names: Vec<&str> = (0..self.count)
            .map(|place| of(place).map_or("-", |which| NAMES[which]))
            .collect();
        names.join(", ")
    }

    /// Checks that a row has the expected number of columns.
    pub(super) fn check(&self, count: usize) -> Result<(), String> {
        if count == self.count {
            return Ok(());
        }
        Err(format!(
            "{count} numbers, where {} are expected{}",
            self.count,
            transposition_hint(count)
        ))
    }

    pub(super) fn sample(&self, row: &[f64], precision: &Precision) -> Result<Sample, String> {
        let [x, y, z, weight, pdf] = self.places.map(|place| place.map(|place| row[place]));
        let direction = DVec3::new(x.unwrap_or(0.0), y.unwrap_or(0.0), z.unwrap_or(0.0));
        let length = direction.length();
        for (name, value) in NAMES[3..].iter().zip([weight, pdf]) {
            if value.is_some_and(|value| !(value.is_finite() && value >= 0.0)) {
                return Err(format!(
                    "the {name} is {}, which must be finite and at least 0",
                    value.unwrap_or_default()
                ));
            }
        }
        if length == 0.0 {
            return Ok(Sample {
                direction: None,
                weight,
                pdf,
            });
        }
        if (length - 1.0).abs() <= precision.length_tolerance() {
            return Ok(Sample {
                direction: Some(direction),
                weight,
                pdf,
            });
        }
        Err(format!(
            "the direction {direction} has length {length}: it must be a unit vector, or 0, 0, 0 if lost"
        ))
    }
}

/// Suggests a transposition if a row has many numbers; else empty.
fn transposition_hint(count: usize) -> &'static str {
    if count > 2 * NAMES.len() {
        "; if each column is a sample, transpose them (samples.T): a row for each is needed"
    } else {
        ""
    }
}
