//! Figures of a run.

use crate::experiments::prelude::*;
use crate::plot::{chart, map};

/// Draws charts one below the other as a figure of the run, of this height in pixels.
pub(super) fn charts(
    run: &mut Run,
    file: &str,
    description: &str,
    height: u32,
    charts: &[Chart],
) -> Result<(), Error> {
    chart::charts(&run.figure(file), description, [900, height], charts)
}

/// Draws maps in rows of `columns` as a figure of the run, of this size in pixels.
pub(super) fn maps(
    run: &mut Run,
    file: &str,
    description: &str,
    size: [u32; 2],
    columns: usize,
    maps: &[Map],
) -> Result<(), Error> {
    map::maps(&run.figure(file), description, size, columns, maps)
}
