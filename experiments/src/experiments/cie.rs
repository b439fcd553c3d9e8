//! Scenes with known answers: rooms in the manner of CIE 171:2006, furnaces, glass and form factors,
//! each estimate beside its closed form.

use crate::experiments::prelude::*;
use crate::plot::forest::{Line, forest};

pub(super) const CIE: Experiment = Experiment {
    id: "cie",
    title: "scenes with known answers, in the manner of CIE 171:2006: estimate, closed form, deviation",
    version: 1,
    equations: &[&equation::GEOMETRY, &equation::FORM_FACTOR, &equation::RADIOSITY, &equation::FRESNEL],
    run,
};

/// The groups of trials whose scenes have closed-form answers.
const GROUPS: [&str; 4] = ["cie", "irradiance", "furnace", "glass"];

fn run(run: &mut Run) -> Result<(), Error> {
    let mut trials = registry::all();
    trials.retain(|trial| GROUPS.contains(&group(&trial.name)) && trial.statistic == "t");
    let (scale, found) = (suite::scale(run), suite::rows(run, &trials)?);
    let rows: Vec<&Row> = found.iter().flatten().collect();
    let csv: Vec<String> = rows.iter().map(|row| row.csv()).collect();
    run.csv("cie.csv", CSV_HEADER, &csv)?;
    for (trial, rows) in trials.iter().zip(&found) {
        for row in rows {
            let o = &row.outcome;
            let standard_error = o.half_width() / normal_upper(ALPHA / 2.0);
            let value = format!(
                "{}: {:.6}, closed form {:.6}, {:+.2} standard errors of {standard_error:.1e}",
                trial.property, o.estimate, o.reference, o.value
            );
            let half = o.half_width();
            let numbers =
                [("estimate", o.estimate), ("reference", o.reference), ("half", half), ("deviation", o.value)];
            run.numbers(&trial.name, numbers);
            run.claim(&trial.name, value, row.verdict);
        }
    }
    let largest = rows.iter().map(|row| row.outcome.value.abs()).fold(0.0, f64::max);
    // Bonferroni over the table.
    let critical = normal_upper(FAMILY / (2.0 * rows.len() as f64));
    run.number("largest_deviation", largest);
    let value = format!("{largest:.2} standard errors; under {critical:.2} with probability {}", 1.0 - FAMILY);
    run.claim("the largest deviation", value, largest < critical);
    let lines: Vec<Line> = rows.iter().map(|row| Line::of(row.trial.clone(), row)).collect();
    let title = format!("Scenes with known answers, scale {scale}");
    let see = "Zero is the closed form. An interval within the band about it holds.";
    forest(&run.figure("cie.svg"), (&title, see), &lines)
}
