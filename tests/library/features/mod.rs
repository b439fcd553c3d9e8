//! Every pair of features stands in a scene, and every estimator is compared there with a closed
//! form or with a walk that cannot share its mistakes.
//!
//! In a furnace the radiance that arrives anywhere is 1 whatever stands in it, if all that absorbs
//! emits as much. Where surfaces lose light there is no closed form, but a walk without shadow rays
//! has little noise.
//!
//! Means see gross mistakes, of as many per cent as each table prints. What is smaller, or met by
//! few paths, is seen path by path: [`shadow_rays`] and [`strategies`] follow what one strategy
//! found and hold it against what the others make of it.
//!
//! Not compared are estimators with no right mean here: photon mapping and progressive photon
//! mapping, whose discs reach beyond edges (they share walks and emission with the light tracer,
//! and know nothing of the background); radiosity, which takes diffuse scenes alone; and the
//! published figure's, which is wrong by design.

mod naive;
mod scenes;
mod shadow_rays;
mod strategies;
mod table;

use std::sync::LazyLock;

use rayon::prelude::*;
use whitefurnace::integrator::{Connections, Heuristic, Path, Strategy as Finds, Walking};
use whitefurnace::render::{ByLanes, ByRays, LaneEstimator, Precision, Renderer};
use whitefurnace::sampling::roulette::EARLY;

use naive::{Light, Naive};
use scenes::{SCENE, exact, scene_of};
use table::{Factor, Row, missing, required, table};

use crate::prelude::*;

/// A frame that is wide and whose sides no tile divides.
const FRAME: [u32; 2] = [45, 23];
/// Samples per pixel of each side, at scale 1.
const SAMPLES: f64 = 96.0;
/// A difference of so many standard errors is not chance: its probability is below 10⁻¹³ in a t
/// distribution of 95 degrees of freedom, and below 10⁻⁹ in all comparisons together however skewed
/// their means of thousands of samples are.
const FAR: f64 = 9.0;
/// The largest relative standard error of a comparison, half as large again as any that was
/// measured: a mistake of 5 % of an image's mean is seen. Smaller ones are for the trials of single
/// scenes.
const PRECISE: f64 = 0.0035;
/// The same of the light tracer: 20 %.
const PRECISE_BY_PARTICLES: f64 = 0.0125;

/// The assertions that chance can turn red: a comparison of each table of scenes, what must be
/// rejected, and identities of random paths.
pub const ASSERTIONS: usize = 10;

/// How rays are followed and what estimates along them.
const SETTINGS: [Factor; 9] = [
    ("finds", &["bsdf", "light", "mis"]),
    (
        "lights",
        &["area", "solid angle", "by shape", "contribution"],
    ),
    ("heuristic", &["balance", "power"]),
    ("bodies", &["no", "yes"]),
    ("early", &["none", "some"]),
    ("bounces", &["unlimited", "three"]),
    ("numbers", &["independent", "sobol"]),
    ("pixel", &["random", "jitter", "grid", "outlines"]),
    ("engine", &["lanes", "single"]),
];

fn samples() -> u32 {
    (SAMPLES * context("features").scale).ceil() as u32
}

/// The factors of a scene, and these settings.
fn factors(settings: &[Factor]) -> &'static [Factor] {
    Box::leak([&SCENE[..], settings].concat().into_boxed_slice())
}

/// The table of scenes and settings of paths, which several tests take.
fn path_rows() -> Vec<Row> {
    static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| table(factors(&SETTINGS), path_takes));
    ROWS.clone()
}

/// Emitters alone would leave the reference too much noise, as would points uniform in area in the
/// corners of a box that shines.
fn is_calm(row: &Row) -> bool {
    let dark = row.is("background", "dark") && !row.is("emitter", "none");
    let corners = row.is("background", "closed box")
        && row.is("finds", "light")
        && !row.is("lights", "solid angle");
    !dark && !corners
}

fn path_takes(row: &Row) -> bool {
    is_calm(row)
}

fn path_of(row: &Row) -> Path {
    let strategy = match row.get("finds") {
        "bsdf" => Finds::Bsdf,
        "light" => Finds::Light,
        _ => Finds::Mis,
    };
    Path {
        lights: match row.get("lights") {
            "area" => LightSampling::Area,
            "solid angle" => LightSampling::SolidAngle,
            "by shape" => LightSampling::ByShape,
            _ => LightSampling::ByContribution,
        },
        heuristic: if row.is("heuristic", "power") {
            Heuristic::Power
        } else {
            Heuristic::Balance
        },
        early: if row.is("early", "some") { EARLY } else { 0 },
        by_bodies: row.is("bodies", "yes"),
        bounces: row.is("bounces", "three").then_some(3),
        ..Path::new(Standard, strategy)
    }
}

fn sampling_of(row: &Row, seed: u64) -> Sampling {
    let pixel = match row.get("pixel") {
        "jitter" => Jitter(2),
        "grid" => Grid(2),
        _ => Random,
    };
    let numbers = if row.is("numbers", "sobol") {
        Numbers::Sobol(4)
    } else {
        Numbers::Independent
    };
    Sampling {
        pixel,
        numbers,
        seed,
        outlines: row.is("pixel", "outlines"),
    }
}

/// A film of about so many samples per pixel.
fn film(scene: &Scene, renderer: &impl Renderer, samples: u32) -> Film {
    let own = renderer.samples_per_replication();
    let mut film = Film::new(FRAME, None, own).expect("a legal size");
    renderer
        .add(scene, &mut film, 0..samples.div_ceil(own), &|_| true)
        .expect("legal values");
    film
}

fn by_path<P: Walking + Copy>(row: &Row, parts: P, scene: &Scene, seed: u64) -> Film {
    let (path, sampling) = (path_of(row), sampling_of(row, seed));
    let Path {
        strategy,
        lights,
        heuristic,
        early,
        by_bodies,
        bounces,
        ..
    } = path;
    let estimator = Path {
        parts,
        strategy,
        lights,
        heuristic,
        early,
        by_bodies,
        bounces,
    };
    let lanes = |precision| ByLanes {
        estimator: LaneEstimator::Path(path),
        sampling,
        precision,
    };
    // Shadow rays alone are noisy where surfaces shine.
    let count = samples() * if row.is("finds", "light") { 4 } else { 1 };
    match row.get("engine") {
        _ if !parts.is_standard() => film(
            scene,
            &ByRays {
                estimator,
                sampling,
            },
            count,
        ),
        "single" => film(scene, &lanes(Precision::Single), count),
        _ => film(scene, &lanes(Precision::Double), count),
    }
}

/// How far a film is from what it should be: the mean difference of red light, its standard error
/// from pixel to pixel, and its expectation.
struct Found {
    row: String,
    difference: f64,
    error: f64,
    expected: f64,
    precise: f64,
}

impl Found {
    fn new(
        row: &Row,
        scene: &Scene,
        (light, (mean, error)): (Option<Light>, Measured),
        seed: u64,
    ) -> Self {
        let straight = matches!(light, Some(Light::StraightToTheEye));
        let precise = if straight {
            PRECISE_BY_PARTICLES
        } else {
            PRECISE
        } / context("features").scale.sqrt();
        let (expected, own) = match light {
            None => (exact(row).expect("a closed form"), 0.0),
            Some(light) => {
                let sampling = Sampling {
                    numbers: Numbers::Independent,
                    outlines: false,
                    ..sampling_of(row, seed)
                };
                by_pixel(&film(
                    scene,
                    &ByRays {
                        estimator: Naive(light),
                        sampling,
                    },
                    samples(),
                ))
            }
        };
        Self {
            row: row.to_string(),
            difference: mean - expected,
            error: error.hypot(own),
            expected,
            precise,
        }
    }

    /// Why it does not hold.
    fn objection(&self) -> Option<String> {
        let Self {
            row,
            difference,
            error,
            expected,
            ..
        } = self;
        let text = |what: &str| {
            let (difference, error) = (100.0 * difference / expected, 100.0 * error / expected);
            Some(format!(
                "{what}: {difference:+.3} % ± {error:.3} % of {expected:.4}: {row}"
            ))
        };
        // Rounding, of single precision.
        let rounding = 1e-4 * expected;
        // False for NaN.
        let is_near = difference.abs() <= FAR * error + rounding;
        if !is_near {
            return text("differs");
        }
        if *error > self.precise * expected {
            text("undecided")
        } else {
            None
        }
    }
}

/// A mean of red light over an image, and its standard error.
type Measured = (f64, f64);

/// The mean over a film, whose pixels are independent.
fn by_pixel(film: &Film) -> Measured {
    let [mean, squares] = film
        .pixels()
        .iter()
        .fold([0.0; 2], |[mean, squares], pixel| {
            [
                mean + pixel.mean().x,
                squares + pixel.standard_error().x.powi(2),
            ]
        });
    let count = film.pixels().len() as f64;
    (mean / count, squares.sqrt() / count)
}

/// Asserts that an estimator is right in a table of scenes that has all pairs. `run` returns what
/// light it counts, if that has no closed form, and what was measured.
fn assert_right(
    (name, factors, takes): (&str, &'static [Factor], impl Fn(&Row) -> bool),
    run: impl Fn(&Row, &Scene, u64) -> (Option<Light>, Measured) + Sync,
) {
    let rows = table(factors, &takes);
    let check = |(at, row): (usize, &Row)| {
        let scene = scene_of(row);
        let seed = |side: &str| seed_for(context("features").seed, &format!("{name} {side} {at}"));
        Found::new(
            row,
            &scene,
            run(row, &scene, seed("subject")),
            seed("reference"),
        )
    };
    let found: Vec<Found> = rows.par_iter().enumerate().map(check).collect();
    let pairs = required(factors, takes);
    let seen = found
        .iter()
        .filter(|found| found.expected > 0.0)
        .map(|found| FAR * found.error / found.expected);
    let seen = 100.0 * seen.fold(0.0, f64::max);
    println!(
        "{name}: {} pairs in {} scenes; a mistake of {seen:.1} % is seen in each",
        pairs.len(),
        rows.len()
    );
    let missing = missing(pairs, &rows);
    assert!(missing.is_empty(), "{name}: {missing:?}");
    assert_all_hold(&found);
}

fn assert_all_hold(found: &[Found]) {
    let objections: Vec<String> = found.iter().filter_map(Found::objection).collect();
    assert!(
        objections.is_empty(),
        "{} of {}:\n{}",
        objections.len(),
        found.len(),
        objections.join("\n")
    );
}

#[test]
fn paths_are_right_where_any_two_features_meet() {
    assert_right(
        ("path", factors(&SETTINGS), path_takes),
        |row, scene, seed| {
            let light = match row.get("bounces") {
                "three" => Some(Light::All(3)),
                _ if exact(row).is_some() => None,
                _ => Some(Light::All(u32::MAX)),
            };
            (light, by_pixel(&by_path(row, Standard, scene, seed)))
        },
    );
}

/// Weights that count light twice are seen in most scenes.
#[test]
fn paths_that_are_wrong_are_seen() {
    #[derive(Clone, Copy)]
    struct Twice;
    impl Scattering for Twice {}
    impl Roulette for Twice {}
    impl NextEvent for Twice {
        fn mis_weight(&self, _: f64, _: f64) -> f64 {
            1.0
        }
    }
    // What an eye in glass sees in it, no shadow ray from it finds.
    let shows = [
        ("c material", "lambert"),
        ("eye", "outside"),
        ("finds", "mis"),
        ("heuristic", "balance"),
    ];
    let rows = path_rows()
        .into_iter()
        .filter(|row| !row.is("emitter", "none") && row.is("bounces", "unlimited"));
    let shown = |row: Row| {
        shows
            .iter()
            .fold(row, |row, (factor, level)| row.with(factor, level))
    };
    let rows: Vec<Row> = rows.take(8).map(shown).collect();
    let is_seen = |row: &Row| {
        let (scene, light) = (scene_of(row), Some(Light::All(u32::MAX)));
        let found = Found::new(
            row,
            &scene,
            (light, by_pixel(&by_path(row, Twice, &scene, master()))),
            master(),
        );
        found
            .objection()
            .is_some_and(|text| text.starts_with("differs"))
    };
    let seen = rows.par_iter().filter(|row| is_seen(row)).count();
    // Some emitters are faint before their background.
    println!("{seen} of {}", rows.len());
    assert!(seen >= 4, "{seen} of {}", rows.len());
}

/// Whether estimators of whole images take a row: they know all materials but rough glass.
fn images_take(row: &Row) -> bool {
    is_calm(row) && !row.has("rough glass")
}

fn passes_of(estimator: &impl ImageEstimator, scene: &Scene, seed: u64) -> Measured {
    let mean = |index| {
        let image = estimator
            .pass(scene, FRAME, seed, index)
            .expect("legal values");
        image.iter().map(|pixel| pixel.x).sum::<f64>() / image.len() as f64
    };
    let mut moments = Moments::default();
    (0..samples()).map(mean).for_each(|mean| moments.push(mean));
    (moments.mean(), moments.standard_error())
}

#[test]
fn bidirectional_paths_are_right_where_any_two_features_meet() {
    let factors = factors(&[("connections", &["all", "ends"])]);
    assert_right(("bdpt", factors, images_take), |row, scene, seed| {
        let connections = if row.is("connections", "all") {
            Connections::All
        } else {
            Connections::Ends
        };
        let bdpt = Bdpt {
            connections,
            ..Bdpt::new(Standard)
        };
        (
            exact(row).is_none().then_some(Light::All(u32::MAX)),
            passes_of(&bdpt, scene, seed),
        )
    });
}

/// Particles know nothing of the background.
fn particles_take(row: &Row) -> bool {
    images_take(row) && (row.get("background").starts_with("closed") || row.is("emitter", "none"))
}

#[test]
fn light_tracing_is_right_where_any_two_features_meet() {
    let tracer = LightTracer { parts: Standard };
    assert_right(
        ("light tracer", &SCENE, particles_take),
        |_, scene, seed| {
            (
                Some(Light::StraightToTheEye),
                passes_of(&tracer, scene, seed),
            )
        },
    );
}

/// Points uniform in area have no finite variance in the corners of a box that shines.
fn by_area(row: &Row) -> bool {
    images_take(row) && !row.is("background", "closed box")
}

fn rays_of(estimator: impl Estimator, scene: &Scene, seed: u64) -> Measured {
    let sampling = Sampling {
        pixel: Random,
        numbers: Numbers::Independent,
        seed,
        outlines: false,
    };
    by_pixel(&film(
        scene,
        &ByRays {
            estimator,
            sampling,
        },
        samples(),
    ))
}

#[test]
fn whitted_is_right_where_any_two_features_meet() {
    let whitted = Whitted {
        segments: 5,
        ..Whitted::new(LightRules::PHYSICAL)
    };
    assert_right(("whitted", &SCENE, by_area), |_, scene, seed| {
        (
            Some(Light::Whitted(whitted.segments)),
            rays_of(whitted, scene, seed),
        )
    });
}

/// So many segments that no light is left.
#[test]
fn the_report_is_right_where_any_two_features_meet() {
    let report = Report {
        segments: 30,
        rules: LightRules::PHYSICAL,
        ..Report::default()
    };
    assert_right(("report", &SCENE, by_area), |row, scene, seed| {
        (
            exact(row).is_none().then_some(Light::All(u32::MAX)),
            rays_of(report, scene, seed),
        )
    });
}

/// Photons and particles come from emitters alone: the background changes no bit of what they show,
/// whatever stands there.
#[test]
fn particles_know_nothing_of_the_background() {
    let takes =
        |row: &Row| images_take(row) && ["constant", "map"].contains(&row.get("background"));
    for row in table(&SCENE, takes)
        .iter()
        .filter(|row| !row.is("emitter", "none"))
    {
        let scenes = [row.clone(), row.with("background", "dark")].map(|row| scene_of(&row));
        let [lit, dark] = scenes.each_ref().map(|scene| {
            let tracer = LightTracer { parts: Standard };
            let sppm = Sppm {
                parts: Standard,
                particles: 300,
                radius: 0.3,
            };
            [
                tracer.pass(scene, [9, 5], 1, 0),
                sppm.pass(scene, [9, 5], 1, 0),
            ]
            .map(|image| image.expect("legal values"))
        });
        assert!(lit == dark, "{row}");
    }
}

/// A pair that is taken out of the table is missed, and rows that are compared have all.
#[test]
fn a_missing_pair_is_noticed() {
    let rows = table(&SCENE, images_take);
    let required = required(&SCENE, images_take);
    assert!(missing(required.clone(), &rows).is_empty());
    let without: Vec<&Row> = rows
        .iter()
        .filter(|row| !(row.has("mesh") && row.has("ggx")))
        .collect();
    assert!(
        missing(required, without.iter().copied())
            .iter()
            .any(|[a, b]| a == "material ggx" && b == "shape mesh")
    );
}
