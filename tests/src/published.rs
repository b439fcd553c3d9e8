//! The reconstruction of the program behind the published figure 6, in a furnace that shows each of
//! its quirks.

use whitefurnace::integrator::{Published, Quirks};
use whitefurnace::material::OrenNayarForm;

use crate::furnace::inside;
use crate::prelude::*;
use crate::scenes::{hollow, scene};

const ALBEDO: f64 = 0.6;
const SURVIVAL: f64 = 0.7;
const RADIANCE: f64 = 2.0;
const SEGMENTS: u32 = 7;
const SAMPLES: u64 = 2_300_000;

/// A sphere of radius 1 whose rough wall emits inwards.
fn furnace() -> Arc<Scene> {
    let rough = Bsdf::oren_nayar(DVec3::splat(ALBEDO), 0.5, OrenNayarForm::Corrected);
    let wall = Surface::new(rough)
        .emitting(DVec3::splat(RADIANCE))
        .absorbing(1.0 - SURVIVAL);
    scene("rough furnace", |s| hollow(s, 1.0, wall))
}

/// Mean radiance with all quirks after `segments` segments. With z = cos θ uniform in [0, 1), the
/// path continues where z ≤ q. A wall shows 1, whatever it emits; a shadow ray within a sphere
/// brings L exactly, as cos θ cos θ' / d² is the same for all pairs of points; survivors reflect z
/// (a/q) L of it, on average a L q/2 per hit, and their throughput is multiplied by 2 z² a/q², on
/// average 2 a q/3.
fn known(segments: u32) -> f64 {
    let direct = ALBEDO * RADIANCE * SURVIVAL / 2.0;
    let onward = 2.0 * ALBEDO * SURVIVAL / 3.0;
    (0..segments).fold(0.0, |next, _| 1.0 + direct + onward * next)
}

/// Trial and faults of the reconstruction: its mean in a furnace whose walls are rough.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let scene = furnace();
    let reference = known(SEGMENTS);
    let on = move |context: &Context, quirks: Quirks| -> Vec<Outcome> {
        let mut rng = context.rng("radiance");
        vec![mean_of(
            "radiance",
            reference,
            BOUNCES_DELTA,
            context.n(SAMPLES),
            || {
                let ray = inside(&mut rng);
                let hit = scene.intersect(&ray);
                Published { quirks }.radiance(&scene, &ray, hit, &mut rng).x
            },
        )]
    };
    let right = Quirks::default();
    vec![Box::new(Family {
        trials: vec![trial(
            "furnace/published",
            format!("with its three quirks the radiance in a rough furnace is {reference:.6}"),
            "the report's pictures are blamed on the wrong mistakes of its program",
            &ROULETTE,
            "integrator::Published",
            "t",
            on,
        )],
        faults: vec![
            fault!("roulette-by-its-own-number", ROULETTE,
                "the roulette has a random number of its own, not the direction's cosine",
                = Quirks { roulette_by_cosine: false, ..right }, "furnace/published"),
            fault!("end-keeps-direct", ROULETTE, "a path that ends keeps its direct light",
                = Quirks { end_loses_direct: false, ..right }, "furnace/published"),
            fault!("cosine-once", OREN_NAYAR, "rough surfaces do not multiply by the cosine once more",
                = Quirks { extra_cosine: false, ..right }, "furnace/published"),
        ],
        ..Family::whole("published", right)
    })]
}
