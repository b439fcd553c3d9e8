//! Trials of relations on a fixed random scene each. The program `metamorphic` tests them on any
//! number of scenes.

use glam::DVec3;
use whitefurnace::harness::mean::welch;
use whitefurnace::integrator::NextEvent;
use whitefurnace::sampling::rng::seed_for;

use super::relations::Relation;
use super::technique::{Images, RESOLUTION, Technique};
use super::{Case, Render, differing_pixels, generate, images_of};
use crate::images::not_a_film;
use crate::prelude::*;
use crate::subject::estimates;

/// δ relative to the image mean.
const DELTA: f64 = 0.05;
/// Weights of the channels in the number that stands for an image: unequal, so that exchanged or
/// mixed channels change it.
const WEIGHTS: DVec3 = DVec3::new(1.0 / 7.0, 2.0 / 7.0, 4.0 / 7.0);

/// Camera rays of each side. The scenes of the trials have no rare bright paths, which would leave a
/// difference undecided under one seed in some dozens.
const RAYS: u64 = 180_000;
/// Camera rays of each side where the fault changes only a small part of the light.
const SPLIT_RAYS: u64 = 560_000;

/// A relation on the random scene of a seed.
struct OnScene {
    relation: &'static Relation,
    technique: &'static str,
    scene: u64,
    rays: u64,
}

impl OnScene {
    /// Returns the two sides with their scenes built.
    fn sides(&self) -> [Vec<Render>; 2] {
        let case = Case {
            technique: Technique::named(self.technique).expect("a technique"),
            ..Case::of(self.relation, &generate(self.scene), self.scene)
        };
        let sides = case.renders().expect("a scene that programs take");
        sides.expect("a relation that applies to the scene")
    }
}

/// Returns the radiances along `count` random camera rays of a side, each the sum over its renders.
fn radiances(parts: Parts<'_>, side: &[Render], seed: u64, count: u64) -> Values {
    let mut renders = Vec::new();
    for (number, Render { part, scene }) in side.iter().enumerate() {
        let path = part.technique.path(parts).expect("a path tracer");
        let seed = seed_for(seed, &format!("render {number}"));
        let ray = |rng: &mut SampleStream| {
            let [x, y] = uniform2(rng);
            let [width, height] = RESOLUTION.map(f64::from);
            scene.camera().ray(RESOLUTION, width * x, height * y)
        };
        renders.push(estimates(seed, scene, Box::new(path), ray));
    }
    let sum = || renders.iter_mut().map(|next| next().dot(WEIGHTS)).sum();
    Values::collect(0.0, count, sum)
}

impl Property for OnScene {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let parts = setup.parts;
        let sides = self.sides();
        if let Some(tolerance) = self.relation.tolerance {
            let seed = context.seed_of("images");
            let one = Images {
                count: 1,
                samples: 1,
            };
            let images = |side: usize| images_of(parts, &sides[side], seed, one);
            let [Ok(a), Ok(b)] = [images(0), images(1)] else {
                return not_a_film("image");
            };
            let differing = differing_pixels(&a[0], &b[0], tolerance) as f64;
            let (pixels, worst) = (a[0].len() as u64, "number of pixels that differ");
            return vec![Outcome::identity("image", pixels, differing, 0.0, worst)];
        }
        let [first, second] = [0, 1].map(|i| {
            let seed = context.seed_of(["first", "second"][i]);
            radiances(parts, &sides[i], seed, context.n(self.rays))
        });
        let claim = Claim::Equal {
            delta: DELTA * second.moments.mean(),
        };
        vec![welch("image mean", &first, &second, claim)]
    }
}

/// Returns the trial of a relation on the random scene of a seed.
fn on_scene(
    name: &'static str,
    technique: &'static str,
    scene: u64,
    rays: u64,
    consequence: &'static str,
) -> FamilyTrial<EstimatorSubject> {
    let (_, of_relation) = name.split_once('/').expect("group/relation");
    let relation = super::relation_named(of_relation).expect("a relation");
    let statistic = match relation.tolerance {
        Some(_) => "exact",
        None => "Welch",
    };
    let property = OnScene {
        relation,
        technique,
        scene,
        rays,
    };
    trial(
        name,
        format!("{}, on a random scene", relation.about),
        consequence,
        &RENDERING,
        "integrator::Path",
        statistic,
        with_parts(property),
    )
}

/// Trials and faults of relations.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: vec![
            on_scene(
                "metamorphic/colours",
                "mis",
                12,
                RAYS,
                "a red lamp makes another image than the same lamp in blue, with the colours exchanged",
            ),
            on_scene(
                "metamorphic/doubled",
                "mis",
                12,
                RAYS,
                "brighter lamps change the noise, or lamps of a small power are treated as none",
            ),
            on_scene(
                "metamorphic/unit",
                "mis-area",
                96,
                RAYS,
                "a room modelled in centimetres renders brighter than the same room in metres",
            ),
            on_scene(
                "metamorphic/rigid-motion",
                "mis-area",
                12,
                RAYS,
                "a model looks different when it is turned or moved together with its camera",
            ),
            on_scene(
                "metamorphic/mirrored",
                "mis-area",
                96,
                RAYS,
                "a mirrored model is lit otherwise than the original",
            ),
            on_scene(
                "metamorphic/split",
                "mis-area",
                109,
                SPLIT_RAYS,
                "a lamp gets brighter or darker when a modeller cuts its rectangle in two",
            ),
            on_scene(
                "metamorphic/permuted",
                "light",
                144,
                RAYS,
                "the image depends on the order in which a file lists its objects",
            ),
            on_scene(
                "metamorphic/index-one",
                "mis",
                4,
                RAYS,
                "a body of air is seen in the image, as a faint reflection or a shadow",
            ),
            on_scene(
                "metamorphic/lamps",
                "mis-area",
                96,
                RAYS,
                "rooms with several lamps are too dark or too bright, although each lamp alone is right",
            ),
            on_scene(
                "metamorphic/reciprocity",
                "mis-area",
                130,
                RAYS,
                "light from A to B differs from light from B to A, so that particle and path tracing disagree",
            ),
            on_scene(
                "metamorphic/techniques",
                "mis",
                96,
                RAYS,
                "the image's brightness depends on which strategy for direct light the user chose",
            ),
        ],
        faults: faults(),
        ..Family::whole("metamorphic", STANDARD)
    })]
}

fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("roulette-by-red", ROULETTE, "paths survive by the first channel of their throughput",
            { survival_by_throughput: |throughput, _| throughput.x.clamp(0.05, 1.0) },
            "metamorphic/colours: image"),
        fault!("importance-with-constant", LIGHT_PICK, "a constant is added to the importance of each emitter",
            { emitter_importance: |emitter, from| DefaultParts.emitter_importance(emitter, from) + 1.0 },
            "metamorphic/doubled: image"),
        fault!("distance-with-constant", GEOMETRY, "a small area is added to the squared distance, so that it is never 0",
            { solid_angle_per_area: |cosine, d2| cosine / (d2 + 0.1) }, "metamorphic/unit: image mean"),
        fault!("reflects-by-side", LAMBERT, "surfaces reflect more along the world's x axis than against it",
            { cosine: |normal, direction| {
                DefaultParts.cosine(normal, direction) * (1.0 + direction.x)
            } }, "metamorphic/mirrored: image mean"),
        fault!("shadowed-from-one-side", WHITTED, "shadow rays along the world's y axis never arrive, those against it do",
            { visible: |scene, x, y, glass| y.point.y < x.point.y && scene.visible(x, y, glass) },
            "metamorphic/rigid-motion: image mean"),
        fault!("area-of-lamps-lost", ESTIMATOR, "the density of points on a lamp is 1, whatever its area",
            { emitter_pdf_area: |_| 1.0 }, "metamorphic/split: image mean"),
        fault!("first-emitter-only", LIGHT_PICK, "the first emitter is picked every time, with the density of all",
            { pick_by_probability: |_, shares| (0, shares[0]) }, "metamorphic/permuted: image mean"),
        fault!("air-reflects", FRESNEL, "glass of index 1 reflects a tenth of the light",
            { fresnel: |cos_1, n1, n2| DefaultParts.fresnel(cos_1, n1, n2).max(0.1) },
            "metamorphic/index-one: image mean"),
        fault!("pick-probability-lost", LIGHT_PICK, "the density of a point ignores that its lamp was picked",
            { pdf_of_pick: |pdf, _| pdf }, "metamorphic/lamps: image mean"),
        fault!("light-cosine-lost", GEOMETRY, "the cosine at the lamp is missing in the change of measure",
            { solid_angle_per_area: |_, d2| 1.0 / d2 }, "metamorphic/reciprocity: image mean"),
        fault!("counted-twice", MIS, "light that is hit and light that is sampled both count in full",
            { mis_power_weight: |_, _| 1.0 }, "metamorphic/techniques: image mean"),
    ]
}
