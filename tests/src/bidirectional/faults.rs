//! Faults of particles, of the camera as a receiver, of connections, and of MIS weights.

use whitefurnace::integrator::{Density, weight};
use whitefurnace::sampling::warp::uniform_hemisphere;

use crate::prelude::*;

pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    let mut faults = particles();
    faults.extend(measures());
    faults.extend(strategies());
    faults
}

fn particles() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("pi-forgotten", COSINE_HEMISPHERE,
            "the density of a particle's direction is cos θ without 1/π",
            { cosine_hemisphere_pdf: |cos| cos.max(0.0) }, "bidirectional/light-tracer/rectangle",
            "bidirectional/bdpt/environment", "bidirectional/alone/sphere-hits"),
        fault!("particles-leave-uniformly", COSINE_HEMISPHERE,
            "uniform directions with the density of cosine-weighted ones",
            { cosine_hemisphere: uniform_hemisphere }, "bidirectional/light-tracer/rectangle",
            "bidirectional/light-tracer/mirror-caustic", "bidirectional/alone/hits"),
        fault!("cosine-forgotten", GEOMETRY,
            "1 for the cosine above the horizon: at the light, at the floor and at the camera",
            { cosine: |n, w| if n.dot(w) > 0.0 { 1.0 } else { 0.0 } },
            "bidirectional/light-tracer/rectangle", "bidirectional/bdpt/rectangle"),
        fault!("flux-scaled-as-radiance", REFRACTION,
            "a particle's flux is multiplied by the radiance factor of refraction",
            { flux_factor: |factor| factor }, "bidirectional/light-tracer/in-glass"),
        fault!("radiance-not-scaled", REFRACTION,
            "the eye's path lacks the radiance factor, so that its share differs from the particles'",
            { radiance_factor: |_, _| 1.0 }, "bidirectional/bdpt/in-glass",
            "bidirectional/bdpt-ends/in-glass"),
        fault!("survivors-not-weighted", ROULETTE,
            "particles that survive roulette carry on as if there were none",
            { roulette_weight: |_| 1.0 }, "bidirectional/light-tracer/furnace-box",
            "bidirectional/light-tracer/cavity-reflecting", "bidirectional/bdpt/furnace-box",
            "bidirectional/bdpt/cavity-black", "bidirectional/light-tracer/sobol", "bidirectional/bdpt/sobol"),
        fault!("pick-forgotten", ESTIMATOR,
            "the density of a particle's start ignores that one of twelve triangles was picked",
            { emitter_pdf_area: |emitter| 12.0 * emitter.pdf_area() },
            "bidirectional/light-tracer/furnace-box", "bidirectional/alone/sphere-shadow-rays",
            "bidirectional/alone/sphere-inner-connections", "bidirectional/alone/sphere-first-connections"),
    ]
}

fn measures() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("importance-without-cosines", IMPORTANCE, "1/A: the cubed cosine is missing",
            {
                importance: |camera, size, direction| {
                    let axis = camera.ray(size, 0.5 * f64::from(size[0]), 0.5 * f64::from(size[1]));
                    camera.importance(size, direction) * direction.dot(axis.direction).powi(3)
                }
            }, "bidirectional/light-tracer/frame: image mean",
            "bidirectional/light-tracer/frame: outer columns", "bidirectional/bdpt/frame: image mean",
            "bidirectional/bdpt/frame: outer columns", "bidirectional/bdpt-ends/frame: image mean", "bidirectional/bdpt-ends/frame: outer columns"),
        fault!("importance-with-fourth-power", IMPORTANCE,
            "1/(A cos⁴ θ), the film's law of irradiance, for the pixel's mean radiance",
            {
                importance: |camera, size, direction| {
                    let axis = camera.ray(size, 0.5 * f64::from(size[0]), 0.5 * f64::from(size[1]));
                    camera.importance(size, direction) / direction.dot(axis.direction)
                }
            }, "bidirectional/light-tracer/frame: outer columns", "bidirectional/bdpt/frame: outer columns"),
        fault!("particles-miscounted", IMPORTANCE,
            "seen particles are divided by one column of pixels too many",
            {
                importance: |camera, size, direction| {
                    let columns = f64::from(size[0]);
                    camera.importance(size, direction) * columns / (columns + 1.0)
                }
            }, "bidirectional/light-tracer/rectangle", "bidirectional/light-tracer/cornell",
            "bidirectional/alone/seen-particles"),
        fault!("connection-cosine-missing", GEOMETRY,
            "the cosine at the far end is missing where paths are connected",
            { solid_angle_per_area: |_, d2| 1.0 / d2 }, "bidirectional/bdpt/sphere"),
        fault!("connection-distance", GEOMETRY, "the distance for its square where paths are connected",
            { solid_angle_per_area: |cos, d2| cos / d2.sqrt() }, "bidirectional/alone/shadow-rays",
            "bidirectional/light-tracer/sphere"),
        fault!("wrong-side", GEOMETRY, "the cosine's magnitude: backs are connected, too",
            { cosine: |n, w| n.dot(w).abs() }, "bidirectional/bdpt/behind"),
        fault!("connected-through-glass", GEOMETRY,
            "glass does not stop connections, and counts again when paths go through it",
            { visible: |scene, x, y, _| scene.visible(x, y, true) }, "bidirectional/bdpt/in-glass"),
    ]
}

fn strategies() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("strategy-left-out", PATH_DENSITY,
            "the sum of densities leaves out seen particles, which count all the same",
            {
                strategy_weight: |path, s| {
                    let seen = weight(path, path.len());
                    if s == path.len() {
                        seen
                    } else {
                        weight(path, s) / (1.0 - seen)
                    }
                }
            }, "bidirectional/weights: sum of weights", "bidirectional/bdpt/rectangle"),
        fault!("strategy-not-made", PATH_DENSITY,
            "particles that the camera sees are weighted for and never counted",
            {
                strategy_weight: |path, s| {
                    if s == path.len() {
                        0.0
                    } else {
                        weight(path, s)
                    }
                }
            }, "bidirectional/weights: sum of weights", "bidirectional/weights: balance",
            "bidirectional/bdpt/rectangle", "bidirectional/bdpt/diffuse-room",
            "bidirectional/bdpt-ends/cavity-black"),
        fault!("hit-and-sampled", MIS,
            "emitters that are hit and emitters that are sampled both count for both",
            {
                strategy_weight: |path, s| {
                    if s < 2 {
                        weight(path, 0) + weight(path, 1)
                    } else {
                        weight(path, s)
                    }
                }
            }, "bidirectional/weights: sum of weights", "bidirectional/bdpt/frame: image mean"),
        fault!("specular-connected", PATH_DENSITY,
            "weights count connections that no strategy makes, at a mirror or between inner vertices",
            {
                strategy_weight: |path, s| {
                    let connectible = |x: &Density| Density {
                        connectible: 1.0,
                        ..*x
                    };
                    weight(&path.iter().map(connectible).collect::<Vec<_>>(), s)
                }
            }, "bidirectional/weights: sum of weights", "bidirectional/bdpt/mirror-caustic",
            "bidirectional/bdpt-ends/cavity-black"),
        fault!("every-strategy-in-full", PATH_DENSITY, "each strategy counts its paths in full",
            { strategy_weight: |_, _| 1.0 }, "bidirectional/bdpt/frame: image mean"),
    ]
}

pub(super) fn equivalents() -> Vec<Fault<EstimatorSubject>> {
    vec![fault!("equal-shares", PATH_DENSITY,
        "the same weight for each strategy of a path without mirrors: they sum to one as well",
        = parts(PartTable { strategy_weight: |path, _| 1.0 / (path.len() + 1) as f64, ..CORRECT }),
        "bidirectional/bdpt/frame")]
}
