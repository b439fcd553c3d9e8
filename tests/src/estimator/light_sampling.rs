//! Faults of lights sampled by solid angle, of the power heuristic, and of light that is hit.

use whitefurnace::integrator::NextEvent as _;
use whitefurnace::light::emitter::{EmitterPoint, EmitterShape};

use crate::prelude::*;
use crate::solid_angle::{uniform_in_area, with_pdf};

pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        // Points.
        fault!("angle-pdf-of-area", LIGHT_RECTANGLE,
            "points by solid angle under the pdf of points by area, in the measure of area",
            { sample_solid_angle: |emitter, from, random| with_pdf(emitter, from, random, |_| emitter.pdf_area()) },
            "irradiance/near-square/light-angle"),
        fault!("area-points-angle-pdf", LIGHT_TRIANGLE,
            "points by area under the pdf of points by solid angle",
            { sample_solid_angle: uniform_in_area }, "irradiance/near-square/light-angle",
            "irradiance/near-triangle/light-angle"),
        fault!("angle-normal-flipped", LIGHT_RECTANGLE,
            "the normal of a point by solid angle is that of the light's back",
            { sample_solid_angle: |emitter, from, random| {
                let (light, pdf) = emitter.sample_solid_angle(from, random)?;
                Some((EmitterPoint { normal: -light.normal, ..light }, pdf))
            } },
            "irradiance/near-square/light-angle", "irradiance/near-square/mis-angle"),
        fault!("angle-pick-forgotten", LIGHT_RECTANGLE,
            "the pdf by solid angle ignores that one of three lights was picked",
            { sample_solid_angle: |emitter, from, random| with_pdf(emitter, from, random, |pdf| 3.0 * pdf) },
            "irradiance/three-lights/light-angle"),
        fault!("angle-of-the-rest", SOLID_ANGLE,
            "the sign of the spherical excess is wrong: the solid angle of all that is not the light",
            { sample_solid_angle: |emitter, from, random| {
                with_pdf(emitter, from, random, |pdf| 1.0 / (4.0 * PI - 1.0 / pdf))
            } },
            "irradiance/near-triangle/light-angle"),
        fault!("spheres-have-no-share", LIGHT_PICK, "a sphere that is seen may contribute nothing",
            { emitter_importance: |emitter, from| match emitter.shape {
                EmitterShape::Sphere(_) => 0.0,
                _ => emitter.importance(from),
            } },
            "irradiance/three-lights/contribution"),
        fault!("picked-evenly-for-its-share", LIGHT_PICK, "picks are even, but count as if they were by share",
            { pick_by_probability: |r, shares| {
                let pick = (r * shares.len() as f64) as usize;
                (pick, shares[pick])
            } },
            "irradiance/picks-by-share: picks", "irradiance/three-lights/contribution",
            "irradiance/mosaic/mis"),
        fault!("share-taken-for-even", LIGHT_PICK, "picks are by share, but count as if they were even",
            { pick_by_probability: |r, shares| (DefaultParts.pick_by_probability(r, shares).0, 1.0 / shares.len() as f64) },
            "irradiance/picks-by-share: share of the pick", "irradiance/mosaic/mis"),
        fault!("next-in-the-list", LIGHT_PICK, "the share is that of the emitter after the picked one",
            { pick_by_probability: |r, shares| {
                let (pick, _) = DefaultParts.pick_by_probability(r, shares);
                (pick, shares[(pick + 1) % shares.len()])
            } },
            "irradiance/picks-by-share: share of the pick", "irradiance/mosaic/mis"),
        fault!("cone-squeezed", LIGHT_SPHERE, "directions crowd at the middle of the cone",
            { sample_solid_angle: |emitter, from, [r1, r2]| emitter.sample_solid_angle(from, [r1 * r1, r2]) },
            "irradiance/near-sphere/light-angle"),
        // Weights.
        fault!("hits-weighted-by-area", MIS,
            "points by solid angle, but hits are weighted with the pdf of points by area",
            { pdf_solid_angle: |_, _| None }, "irradiance/near-square/mis-angle",
            "irradiance/near-triangle/mis-angle", "irradiance/near-sphere/mis-angle"),
        fault!("hit-and-sampled", MIS, "shadow rays alone, but lights that are hit count in full",
            { counts_emission: |_, _| true }, "irradiance/rectangle-report", "irradiance/square/light-area",
            "irradiance/near-triangle/light-angle", "irradiance/triangle/light-area",
            "irradiance/sphere/light-area", "furnace/light/box", "furnace/light/sphere",
            "images/three-strategies: light and mis", "sky/overcast/light"),
        fault!("lost-after-mirror", MIS,
            "shadow rays alone: light that is hit through a mirror is lost, too",
            { counts_emission: |strategy, _| strategy != Strategy::Light }, "irradiance/after-mirror/light",
            "irradiance/after-mirror/report"),
        fault!("lost-without-pdf", MIS,
            "light that only hits can find counts only if shadow rays look for it",
            { counts_emission: |_, sampled| sampled }, "irradiance/after-mirror/mis",
            "irradiance/after-glass/mis"),
        fault!("hits-not-counted", MIS, "without shadow rays nothing that is hit after a bounce counts",
            { counts_emission: |_, sampled| !sampled }, "irradiance/near-square/bsdf", "furnace/bsdf/box",
            "irradiance/near-triangle/bsdf", "irradiance/near-sphere/bsdf"),
        fault!("power-without-square", MIS_POWER,
            "the balance heuristic under the name of power: the mean stays",
            { mis_power_weight: |p, q| p / (p + q) }, "irradiance/power-weights: squares"),
        fault!("power-of-the-sum", MIS_POWER,
            "the square of the sum for the sum of squares: weights sum to less than one",
            { mis_power_weight: |p, q| p * p / ((p + q) * (p + q)) },
            "irradiance/power-weights: sum of weights", "irradiance/heuristics"),
        fault!("power-swapped", MIS_POWER,
            "each strategy gets the other's weight: the mean stays, the variance does not",
            { mis_power_weight: |p, q| q * q / (p * p + q * q) }, "irradiance/power-weights: squares"),
    ]
}
