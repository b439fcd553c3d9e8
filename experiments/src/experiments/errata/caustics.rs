//! Light lost if no emission counts that a path hits after a diffuse surface.

use whitefurnace::integrator::Report;

use super::size;
use crate::experiments::prelude::*;

/// Limit whose truncation error is negligible: 0.75 to this power.
const SEGMENTS: u32 = 60;

/// Compares the report's room under physical rules, by the report's estimator without its limit,
/// with and without caustics, with the same random numbers, so that both follow the same paths.
pub(super) fn lost(run: &mut Run) -> Result<(), Error> {
    let images = run.count(run.by_tier(400, 6_000)).max(2) as u32;
    let job = Job {
        size: [40, 30],
        spp: images,
        seed: seed_for(run.seed(), "errata caustics"),
        ..Job::default()
    };
    let mut means = Vec::new();
    for caustics in [true, false] {
        let report = Report {
            segments: SEGMENTS,
            rules: TransportRules {
                caustics,
                ..TransportRules::PHYSICAL
            },
            ..Report::default()
        };
        job.replications_by(report, 0..images, |image| {
            means.push(image.iter().map(|v| v.element_sum()).sum::<f64>());
        })?;
    }
    let (all, without) = means.split_at(images as usize);
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let mut lost = Moments::default();
    for (all, without) in all.iter().zip(without) {
        lost.push((without - all) / mean);
    }
    let what =
        "relative change of the room's mean radiance without light by way of mirrors and glass";
    size(run, "caustics.room", lost.mean(), what);
    size(
        run,
        "caustics.room.error",
        lost.standard_error(),
        "is its standard error",
    );
    Ok(())
}
