//! A CSV file that grows from run to run, so that evidence accumulates.
//!
//! Testing growing data again and again at one fixed level rejects a true hypothesis in the end
//! with certainty. So the file counts the looks, and each look spends its own share of the level.

use std::path::{Path, PathBuf};

use whitefurnace::error::Error;

use crate::run::write_text;

/// Rows of this and earlier runs. The first column of a row is the number of its replication; a run
/// continues the numbering of the existing rows.
pub struct Accumulated {
    path: PathBuf,
    key: String,
    columns: String,
    looks: u32,
    rows: Vec<String>,
}

/// Start of the line that holds the number of looks.
const LOOKS_PREFIX: &str = "# looks: ";

/// Returns the share of `level` that look number `look` ≥ 1 may spend: 6/(π² k²). All shares add to
/// 1 (Euler's sum), so that tests at these levels, however many looks there will be and whenever
/// they end, reject a true hypothesis at any of them with probability at most `level` (the union
/// bound over looks of Darling and Robbins, "Confidence sequences for mean, variance, and median",
/// PNAS 58(1), 1967).
pub fn level_of_look(level: f64, look: u32) -> f64 {
    let k = f64::from(look) * std::f64::consts::PI;
    6.0 * level / (k * k)
}

impl Accumulated {
    /// Takes the rows that earlier runs left in the file `before` under the same `key` (version,
    /// seed, sizes: all that decides a row besides its number) and columns, to continue in `path`.
    /// A file with another key starts afresh.
    pub fn continued(before: &Path, path: PathBuf, key: &str, columns: &str) -> Self {
        let text = std::fs::read_to_string(before).unwrap_or_default();
        let (looks, rows) = read(&text, key, columns).unwrap_or_default();
        Self {
            path,
            key: key.to_owned(),
            columns: columns.to_owned(),
            looks,
            rows,
        }
    }

    /// Counts a look at all rows and returns the level that it may spend of `level`. The count is
    /// written with the rows when a run has finished all of its own: an interrupted run has not
    /// looked.
    pub fn look(&mut self, level: f64) -> f64 {
        self.looks += 1;
        level_of_look(level, self.looks)
    }

    /// Returns the number of looks so far.
    pub fn looks(&self) -> u32 {
        self.looks
    }

    /// Returns the number of the next replication.
    pub fn next(&self) -> u64 {
        let numbers = self
            .rows
            .iter()
            .filter_map(|row| row.split(',').next()?.parse::<u64>().ok());
        numbers.max().map_or(0, |last| last + 1)
    }

    /// Adds the fields of a replication; none may hold a comma.
    pub fn push(&mut self, replication: u64, fields: &[String]) {
        self.rows
            .push(format!("{replication},{}", fields.join(",")));
    }

    /// Returns all rows: the replication's number and its fields, separated by commas.
    pub fn rows(&self) -> &[String] {
        &self.rows
    }

    /// Returns the fields of a column; nothing where a row has none.
    pub fn column(&self, name: &str) -> impl Iterator<Item = &str> + use<'_> {
        let at = self.columns.split(',').position(|column| column == name);
        self.rows
            .iter()
            .map(move |row| at.and_then(|at| row.split(',').nth(at)).unwrap_or_default())
    }

    /// Returns the numbers in a column; NaN for a field that is not a number.
    pub fn numbers(&self, column: &str) -> impl Iterator<Item = f64> + use<'_> {
        self.column(column)
            .map(|field| field.parse().unwrap_or(f64::NAN))
    }

    /// Writes the file.
    pub fn write(&self) -> Result<(), Error> {
        let rows: String = self.rows.iter().map(|row| format!("{row}\n")).collect();
        write_text(
            &self.path,
            &format!(
                "# {}\n{LOOKS_PREFIX}{}\n{}\n{rows}",
                self.key, self.looks, self.columns
            ),
        )
    }
}

/// Parses looks and rows of a file with this key and these columns.
fn read(text: &str, key: &str, columns: &str) -> Option<(u32, Vec<String>)> {
    let rest = text.strip_prefix("# ")?.strip_prefix(key)?;
    let (looks, rest) = rest
        .strip_prefix('\n')?
        .strip_prefix(LOOKS_PREFIX)?
        .split_once('\n')?;
    let rows = rest.strip_prefix(columns)?.strip_prefix('\n')?.lines();
    Some((looks.parse().ok()?, rows.map(str::to_owned).collect()))
}
