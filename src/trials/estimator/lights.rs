//! Faults of direct light: picks, points, measures, shadow rays, weights.

use glam::DVec3;

use crate::emitter::{Emitter, EmitterPoint, EmitterShape};
use crate::equation::{ESTIMATOR, GEOMETRY, MIS, WHITTED};
use crate::scene::Scene;
use crate::shape::triangle_point;
use crate::trials::subject::{RIGHT, Subject, Table, parts};
use crate::zoo::{Mutant, mutant};

fn squeezed(emitter: &Emitter, [r1, r2]: [f64; 2]) -> EmitterPoint {
    emitter.sample([r1 * r1, r2])
}

/// The point on a triangle without folding the square: half of them lie beyond the edge.
fn unfolded(emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
    match emitter.shape {
        EmitterShape::Triangle(vertices) => EmitterPoint {
            point: triangle_point(vertices, random[0], random[1]),
            ..emitter.sample(random)
        },
        _ => emitter.sample(random),
    }
}

fn always_visible(_: &Scene, _: (DVec3, DVec3), _: (DVec3, DVec3), _: bool) -> bool {
    true
}

pub(super) fn faults() -> Vec<Mutant<Subject>> {
    let mut faults = light_measures();
    faults.extend([
        mutant(
            "always-the-first",
            &ESTIMATOR,
            "picks the first emitter every time, with the density of all",
            parts(Table {
                pick_emitter: |_, _| 0,
                ..RIGHT
            }),
            &["irradiance/three-lights", "irradiance/picks"],
        ),
        mutant(
            "picks-unevenly",
            &ESTIMATOR,
            "the pick's number is squared",
            parts(Table {
                pick_emitter: |r, count| ((r * r * count as f64) as usize).min(count - 1),
                ..RIGHT
            }),
            &["irradiance/picks", "irradiance/three-lights"],
        ),
        mutant(
            "pick-probability-missing",
            &ESTIMATOR,
            "the density of a point does not know that one of three lights was picked",
            parts(Table {
                emitter_pdf_area: |emitter| 3.0 * emitter.pdf_area(),
                ..RIGHT
            }),
            &["irradiance/three-lights"],
        ),
        mutant(
            "shadows-ignored",
            &WHITTED,
            "shadow rays are not traced",
            parts(Table {
                visible: always_visible,
                ..RIGHT
            }),
            &[
                "irradiance/half-hidden",
                "irradiance/penumbra/bright",
                "irradiance/penumbra/middle",
            ],
        ),
        mutant(
            "shadows-pass-glass",
            &MIS,
            "shadow rays pass glass, and light through glass counts as well when it is hit",
            parts(Table {
                visible: |scene, x, y, _| scene.visible(x, y, true),
                ..RIGHT
            }),
            &["glass/index-matched", "irradiance/after-glass/mis"],
        ),
        mutant(
            "no-shadow-rays",
            &MIS,
            "shadow rays never arrive, but hits are weighted as if they did",
            parts(Table {
                visible: |_, _, _, _| false,
                ..RIGHT
            }),
            &["irradiance/rectangle", "irradiance/rectangle-whitted"],
        ),
        mutant(
            "counted-twice",
            &MIS,
            "light that is hit and light that is sampled both count in full",
            parts(Table {
                mis_weight: |_, _| 1.0,
                ..RIGHT
            }),
            &[
                "irradiance/rectangle",
                "irradiance/near-square/mis-area",
                "irradiance/near-triangle/mis-area",
            ],
        ),
        mutant(
            "not-counted",
            &MIS,
            "light counts neither as hit nor as sampled after a diffuse bounce",
            parts(Table {
                mis_weight: |_, _| 0.0,
                ..RIGHT
            }),
            &["irradiance/rectangle", "irradiance/near-sphere/mis-area"],
        ),
        mutant(
            "squares-weight",
            &MIS,
            "the square of the balance heuristic: weights sum to less than one",
            parts(Table {
                mis_weight: |p, q| (p / (p + q)).powi(2),
                ..RIGHT
            }),
            &[
                "irradiance/weights: sum of weights",
                "irradiance/rectangle",
                "images/three-strategies: bsdf and mis",
            ],
        ),
        mutant(
            "equal-weights",
            &MIS,
            "half for each strategy: the mean stays, the variance does not",
            parts(Table {
                mis_weight: |_, _| 0.5,
                ..RIGHT
            }),
            &["irradiance/weights: balance"],
        ),
        mutant(
            "weights-swapped",
            &MIS,
            "each strategy gets the other's weight: the mean stays, the variance does not",
            parts(Table {
                mis_weight: |p, q| q / (p + q),
                ..RIGHT
            }),
            &["irradiance/weights: balance"],
        ),
    ]);
    faults
}

fn light_measures() -> Vec<Mutant<Subject>> {
    vec![
        mutant(
            "light-cosine-missing",
            &GEOMETRY,
            "the cosine at the light is missing in the change of measure",
            parts(Table {
                solid_angle_per_area: |_, d2| 1.0 / d2,
                ..RIGHT
            }),
            &["irradiance/rectangle-report"],
        ),
        mutant(
            "distance-missing",
            &GEOMETRY,
            "the squared distance is missing in the change of measure",
            parts(Table {
                solid_angle_per_area: |cos, _| cos,
                ..RIGHT
            }),
            &[
                "irradiance/rectangle-report",
                "irradiance/triangle",
                "irradiance/perpendicular-squares",
            ],
        ),
        mutant(
            "distance-not-squared",
            &GEOMETRY,
            "the distance for its square",
            parts(Table {
                solid_angle_per_area: |cos, d2| cos / d2.sqrt(),
                ..RIGHT
            }),
            &[
                "irradiance/rectangle-report",
                "irradiance/sphere",
                "irradiance/parallel-squares",
            ],
        ),
        mutant(
            "back-shines",
            &GEOMETRY,
            "the cosine's magnitude: the back of a light shines, too",
            parts(Table {
                cosine: |n, w| n.dot(w).abs(),
                ..RIGHT
            }),
            &["irradiance/behind"],
        ),
        mutant(
            "area-twice",
            &GEOMETRY,
            "the density on a light is twice too large",
            parts(Table {
                emitter_pdf_area: |emitter| 2.0 * emitter.pdf_area(),
                ..RIGHT
            }),
            &[
                "irradiance/parallel-squares",
                "irradiance/sphere",
                "irradiance/rectangle",
            ],
        ),
        mutant(
            "light-squeezed",
            &GEOMETRY,
            "points are not uniform on a light",
            parts(Table {
                sample_emitter: squeezed,
                ..RIGHT
            }),
            &["irradiance/sphere", "images/convex-object"],
        ),
        mutant(
            "light-centre",
            &GEOMETRY,
            "every shadow ray goes to the middle of the light",
            parts(Table {
                sample_emitter: |emitter, _| emitter.sample([0.5, 0.5]),
                ..RIGHT
            }),
            &["irradiance/rectangle"],
        ),
        mutant(
            "triangle-unfolded",
            &GEOMETRY,
            "points with u + v > 1 on a triangular light",
            parts(Table {
                sample_emitter: unfolded,
                ..RIGHT
            }),
            &["irradiance/triangle"],
        ),
    ]
}
