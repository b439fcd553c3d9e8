//! Bidirectional paths and light tracing where any two features meet.

use super::*;

pub(super) fn passes_of(
    estimator: &dyn ImageEstimator,
    scene: &Scene,
    seed: u64,
    count: u32,
) -> Measured {
    let mean = |index| {
        let image = estimator
            .pass(scene, FRAME, seed, index)
            .expect("legal values");
        image.iter().map(|pixel| pixel.x).sum::<f64>() / image.len() as f64
    };
    by_means((0..count).map(mean), 0.0)
}

/// Returns the mean of independent images, given the mean of each.
pub(super) fn by_means(means: impl Iterator<Item = f64>, bias: f64) -> Measured {
    let mut moments = Moments::default();
    means.for_each(|mean| moments.push(mean));
    Measured {
        mean: moments.mean(),
        error: moments.standard_error(),
        bias,
    }
}

#[test]
fn bidirectional_paths_are_right_where_any_two_features_meet() {
    let factors = factors(&[("connections", &["all", "ends"])]);
    assert_right("bdpt", factors, supports_images, |row, scene, seed| {
        let connections = if row.is("connections", "all") {
            Connections::All
        } else {
            Connections::Endpoints
        };
        let bdpt = Bdpt {
            connections,
            ..Bdpt::new(Parts::default())
        };
        (
            exact(row).is_none().then_some(Light::All(u32::MAX)),
            passes_of(&bdpt, scene, seed, samples()),
        )
    });
}

/// Returns whether the light tracer handles a row: particles ignore the background.
pub(super) fn supports_particles(row: &Row) -> bool {
    supports_images(row)
        && (row.get("background").starts_with("closed") || row.is("emitter", "none"))
}

#[test]
fn light_tracing_is_right_where_any_two_features_meet() {
    let tracer = LightTracer::default();
    assert_right(
        "light tracer",
        &SCENE,
        supports_particles,
        |_, scene, seed| {
            (
                Some(Light::StraightToTheEye),
                passes_of(&tracer, scene, seed, 2 * samples()),
            )
        },
    );
}
