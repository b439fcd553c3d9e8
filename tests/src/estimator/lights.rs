//! Faults of direct light: choice of light, sampled points, measures, shadow rays, weights.

use whitefurnace::geometry::shape::triangle_point;
use whitefurnace::light::emitter::{Emitter, EmitterPoint, EmitterShape};

use crate::prelude::*;

/// Samples a triangle without folding the square, so that half of the points lie beyond the edge.
fn unfolded(emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
    match emitter.shape {
        EmitterShape::Triangle(vertices) => EmitterPoint {
            point: triangle_point(vertices, random[0], random[1]),
            ..emitter.sample(random)
        },
        _ => emitter.sample(random),
    }
}

pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        // Measures.
        fault!("light-cosine-missing", GEOMETRY,
            "the cosine at the light is missing in the change of measure",
            { solid_angle_per_area: |_, d2| 1.0 / d2 }, "irradiance/rectangle-report"),
        fault!("distance-missing", GEOMETRY, "the squared distance is missing in the change of measure",
            { solid_angle_per_area: |cos, _| cos }, "irradiance/rectangle-report", "irradiance/triangle",
            "irradiance/perpendicular-squares"),
        fault!("distance-not-squared", GEOMETRY, "the distance for its square",
            { solid_angle_per_area: |cos, d2| cos / d2.sqrt() }, "irradiance/rectangle-report",
            "irradiance/sphere", "irradiance/parallel-squares"),
        fault!("back-shines", GEOMETRY, "the cosine's magnitude: the back of a light shines, too",
            { cosine: |n, w| n.dot(w).abs() }, "irradiance/behind"),
        fault!("area-twice", GEOMETRY, "the density on a light is twice too large",
            { emitter_pdf_area: |emitter| 2.0 * emitter.pdf_area() }, "irradiance/parallel-squares",
            "irradiance/sphere", "irradiance/rectangle"),
        fault!("light-squeezed", GEOMETRY, "points are not uniform on a light",
            { sample_emitter: |emitter, [r1, r2]| emitter.sample([r1 * r1, r2]) },
            "irradiance/sphere", "images/convex-object"),
        fault!("light-centre", GEOMETRY, "every shadow ray goes to the middle of the light",
            { sample_emitter: |emitter, _| emitter.sample([0.5, 0.5]) }, "irradiance/rectangle"),
        fault!("triangle-unfolded", GEOMETRY, "points with u + v > 1 on a triangular light",
            { sample_emitter: unfolded }, "irradiance/triangle"),
        // Picks, shadow rays and weights.
        fault!("always-the-first", ESTIMATOR, "picks the first emitter every time, with the density of all",
            { pick_emitter: |_, _| 0 }, "irradiance/three-lights", "irradiance/picks"),
        fault!("picks-unevenly", ESTIMATOR, "the pick's number is squared",
            { pick_emitter: |r, picks| picks.pick(r * r) },
            "irradiance/picks", "irradiance/three-lights"),
        fault!("pick-probability-missing", ESTIMATOR,
            "the density of a point ignores that one of three lights was picked",
            { pdf_of_pick: |pdf, _| pdf }, "irradiance/three-lights"),
        fault!("shadows-ignored", WHITTED, "shadow rays are not traced",
            { visible: |_, _, _, _| true }, "irradiance/half-hidden", "irradiance/penumbra/bright",
            "irradiance/penumbra/middle"),
        fault!("shadows-pass-glass", MIS,
            "shadow rays pass glass, and light through glass counts as well when it is hit",
            { visible: |scene, x, y, _| scene.visible(x, y, true) }, "glass/index-matched",
            "irradiance/after-glass/mis"),
        fault!("no-shadow-rays", MIS, "shadow rays never arrive, but hits are weighted as if they did",
            { visible: |_, _, _, _| false }, "irradiance/rectangle", "irradiance/rectangle-whitted"),
        fault!("counted-twice", MIS, "light that is hit and light that is sampled both count in full",
            { mis_weight: |_, _| 1.0 }, "irradiance/rectangle", "irradiance/near-square/mis-area",
            "irradiance/near-triangle/mis-area"),
        fault!("not-counted", MIS, "light counts neither as hit nor as sampled after a diffuse bounce",
            { mis_weight: |_, _| 0.0 }, "irradiance/rectangle", "irradiance/near-sphere/mis-area"),
        fault!("squares-weight", MIS, "the square of the balance heuristic: weights sum to less than one",
            { mis_weight: |p, q| (p / (p + q)).powi(2) }, "irradiance/weights: sum of weights",
            "irradiance/rectangle", "images/three-strategies: bsdf and mis"),
        fault!("equal-weights", MIS, "half for each strategy: the mean stays, the variance does not",
            { mis_weight: |_, _| 0.5 }, "irradiance/weights: balance"),
        fault!("weights-swapped", MIS,
            "each strategy gets the other's weight: the mean stays, the variance does not",
            { mis_weight: |p, q| q / (p + q) }, "irradiance/weights: balance"),
    ]
}
