//! A CSV file that grows from run to run, so that evidence accumulates.

use std::path::PathBuf;

use whitefurnace::error::Error;

use crate::lab::write_text;

/// Rows of this and earlier runs. The first column of a row is the number of its replication; a run
/// takes the numbers after those that are there.
pub struct Ledger {
    path: PathBuf,
    head: String,
    rows: Vec<Vec<String>>,
}

impl Ledger {
    /// The rows that earlier runs left in `path` under the same `key` (version, seed, sizes: all that
    /// decides a row beside its number) and columns. A file of another key starts afresh.
    pub fn open(path: PathBuf, key: &str, columns: &str) -> Self {
        let head = format!("# {key}\n{columns}\n");
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        let rows = text.strip_prefix(&head).unwrap_or_default().lines();
        let rows = rows
            .map(|row| row.split(',').map(str::to_owned).collect())
            .collect();
        Self { path, head, rows }
    }

    /// The number of the next replication.
    pub fn next(&self) -> u64 {
        self.rows
            .iter()
            .filter_map(|row| row.first()?.parse::<u64>().ok())
            .max()
            .map_or(0, |last| last + 1)
    }

    /// Adds the fields of a replication; none may hold a comma.
    pub fn push(&mut self, replication: u64, fields: &[String]) {
        let mut row = vec![replication.to_string()];
        row.extend_from_slice(fields);
        self.rows.push(row);
    }

    /// All rows: the replication's number and its fields.
    pub fn rows(&self) -> &[Vec<String>] {
        &self.rows
    }

    /// Writes the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self) -> Result<(), Error> {
        let mut text = self.head.clone();
        for row in &self.rows {
            text.push_str(&row.join(","));
            text.push('\n');
        }
        write_text(&self.path, &text)
    }
}

/// A field of a row as a number; NaN if it is none.
pub fn number(row: &[String], column: usize) -> f64 {
    row.get(column)
        .and_then(|field| field.parse().ok())
        .unwrap_or(f64::NAN)
}
