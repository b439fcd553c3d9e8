//! Covering array of features: every pair of features occurs in a scene, and every estimator is
//! compared there with a closed form or with a path tracer that does not share its code.
//!
//! In a furnace the incident radiance is 1 everywhere whatever is in it, if all that absorbs emits
//! as much. Where surfaces lose light there is no closed form, but a path tracer without shadow
//! rays has little noise.
//!
//! Means detect gross errors, of as many per cent as each table prints. Errors that are smaller, or
//! affect few paths, are found path by path: [`shadow_rays`] and [`strategies`] follow the path
//! that one strategy found and compare it with the others.
//!
//! Photons are looked up in discs that reach beyond edges, and the means of [`photons`] are right
//! within a margin for that. Radiosity ([`radiosity`]) handles diffuse scenes only, and has the
//! error of its mesh. Not compared is the published figure's estimator, which is wrong by design.
//!
//! Some pairs have no comparison, and `pairs_that_are_left_out_are_named` lists all of them:
//! emitters in the dark, alone, leave too much noise in the reference; only path tracing supports
//! rough glass; particles and photons ignore the background, so that they are compared in closed
//! scenes; single precision refuses surfaces that nearly coincide.

mod bidirectional;
mod left_out;
mod photons;
mod radiosity;
mod reference_path_tracer;
mod scenes;
mod shadow_rays;
mod strategies;
mod table;

use std::sync::LazyLock;

use rayon::prelude::*;
use whitefurnace::integrator::Connections;
use whitefurnace::sampling::roulette::RR_DEPTH;

use reference_path_tracer::{Light, ReferencePathTracer};
use scenes::{SCENE, exact, scene_of};
use table::{Factor, Row, missing, required, table};

use crate::prelude::*;

/// A wide frame whose sides are no multiples of a tile's.
const FRAME: [u32; 2] = [45, 23];
/// Samples per pixel of an estimator, at scale 1; noisy ones take more. The reference takes half as
/// many, as it has less noise than what is compared with it.
const SAMPLES: f64 = 96.0;
/// Number of standard errors beyond which a difference is not chance: the probability is below
/// 10⁻¹³ in a t distribution of 95 degrees of freedom, and below 10⁻⁹ in all comparisons together
/// however skewed their means of thousands of samples are.
const MAX_SIGMAS: f64 = 9.0;
/// Largest relative standard error of a comparison, half as large again as the largest measured: an
/// error of 5 % of an image's mean is detected. Smaller ones are left to the trials of single
/// scenes.
const MAX_RELATIVE_ERROR: f64 = 0.0035;
/// Largest relative standard error of a comparison of the light tracer: an error of 20 % is
/// detected.
const MAX_RELATIVE_ERROR_OF_PARTICLES: f64 = 0.0125;

/// Number of random assertions: a comparison for each table of scenes, two negative controls, and
/// identities of random paths.
pub const ASSERTIONS: usize = 13;

/// Factors of path tracing: sampling strategies, random numbers and the engine.
const SETTINGS: [Factor; 9] = [
    ("finds", &["bsdf", "light", "mis"]),
    (
        "lights",
        &["area", "solid angle", "sphere angle", "importance"],
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

/// Number of samples per pixel that show a gross error.
fn few_samples() -> u32 {
    samples().div_ceil(4)
}

/// Returns the factors of a scene, and these settings.
fn factors(settings: &[Factor]) -> &'static [Factor] {
    Box::leak([&SCENE[..], settings].concat().into_boxed_slice())
}

/// Returns the table of scenes and settings of paths, which several tests use.
fn path_rows() -> Vec<Row> {
    static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| table(factors(&SETTINGS), supports_paths));
    ROWS.clone()
}

/// Returns whether a row has little noise: emitters alone would leave too much in the reference, as
/// would points uniform in area in the corners of a closed box that emits.
fn has_low_noise(row: &Row) -> bool {
    let dark = row.is("background", "dark") && !row.is("emitter", "none");
    let corners = row.is("background", "closed box")
        && row.is("finds", "light")
        && !row.is("lights", "solid angle");
    !dark && !corners
}

/// Returns whether a row has surfaces that coincide in single precision.
fn is_near_coincident(row: &Row) -> bool {
    ["twins", "sheets"]
        .iter()
        .any(|what| row.has(what) || row.has(&format!("{what} reversed")))
}

fn supports_paths(row: &Row) -> bool {
    has_low_noise(row) && !(row.is("engine", "single") && is_near_coincident(row))
}

fn path_of(row: &Row) -> Path<'static> {
    let strategy = match row.get("finds") {
        "bsdf" => PathStrategy::Bsdf,
        "light" => PathStrategy::Light,
        _ => PathStrategy::Mis,
    };
    Path {
        lights: match row.get("lights") {
            "area" => LightSampling::Area,
            "solid angle" => LightSampling::SolidAngle,
            "sphere angle" => LightSampling::SphereAngle,
            _ => LightSampling::Importance,
        },
        heuristic: if row.is("heuristic", "power") {
            Heuristic::Power
        } else {
            Heuristic::Balance
        },
        rr_depth: if row.is("early", "some") { RR_DEPTH } else { 0 },
        specular_nee: row.is("bodies", "yes"),
        bounces: row.is("bounces", "three").then_some(3),
        ..Path::new(strategy)
    }
}

fn sampling_of(row: &Row, seed: u64) -> Sampling {
    let pixel = match row.get("pixel") {
        "jitter" => Jitter(2),
        "grid" => Grid(2),
        _ => Random,
    };
    let numbers = if row.is("numbers", "sobol") {
        SamplerKind::Sobol(4)
    } else {
        SamplerKind::Independent
    };
    Sampling {
        silhouettes: row.is("pixel", "outlines"),
        ..sampling(pixel, numbers, seed)
    }
}

/// Renders a film of about this many samples per pixel.
fn film(scene: &Scene, renderer: &impl Renderer, samples: u32) -> Film {
    film_of(FRAME, scene, renderer, samples)
}

fn film_of(size: [u32; 2], scene: &Scene, renderer: &impl Renderer, samples: u32) -> Film {
    let replications = samples.div_ceil(renderer.samples_per_replication());
    filled(renderer, scene, size, 0..replications).expect("legal values")
}

fn by_path(row: &Row, parts: Parts<'_>, scene: &Scene, seed: u64, samples: u32) -> Film {
    let (path, sampling) = (path_of(row).with_parts(parts), sampling_of(row, seed));
    let lanes = |precision| lanes(LaneEstimator::Path(path), sampling, precision);
    // Shadow rays alone are noisy where surfaces emit.
    let count = samples * if row.is("finds", "light") { 4 } else { 1 };
    match row.get("engine") {
        "single" if parts.are_default() => film(scene, &lanes(Precision::Single), count),
        _ => film(scene, &lanes(Precision::Double), count),
    }
}

/// Comparison of a film with its expectation: the mean difference of red light, its standard error
/// from the spread over pixels, and the expectation.
struct Found {
    row: String,
    difference: f64,
    error: f64,
    expected: f64,
    /// Relative bias that is allowed.
    bias: f64,
    max_relative_error: f64,
}

impl Found {
    fn new(row: &Row, scene: &Scene, light: Option<Light>, measured: Measured, seed: u64) -> Self {
        let straight = matches!(light, Some(Light::StraightToTheEye));
        let max_relative_error = if measured.bias > 0.0 {
            photons::MAX_RELATIVE_ERROR
        } else if straight {
            MAX_RELATIVE_ERROR_OF_PARTICLES
        } else {
            MAX_RELATIVE_ERROR
        } / context("features").scale.sqrt();
        let reference = match light {
            None => Measured {
                mean: exact(row).expect("a closed form"),
                error: 0.0,
                bias: 0.0,
            },
            Some(light) => {
                let sampling = Sampling {
                    sampler: SamplerKind::Independent,
                    silhouettes: false,
                    ..sampling_of(row, seed)
                };
                by_pixel(&film(
                    scene,
                    &RayRenderer {
                        estimator: ReferencePathTracer(light),
                        sampling,
                    },
                    samples().div_ceil(2),
                ))
            }
        };
        Self {
            row: row.to_string(),
            difference: measured.mean - reference.mean,
            error: measured.error.hypot(reference.error),
            expected: reference.mean,
            bias: measured.bias,
            max_relative_error,
        }
    }

    /// Returns why the comparison fails, if it does.
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
        // Rounding in single precision.
        let rounding = self.bias.max(1e-4) * expected;
        // False for NaN.
        let is_near = difference.abs() <= MAX_SIGMAS * error + rounding;
        if !is_near {
            return text("differs");
        }
        if *error > self.max_relative_error * expected {
            text("undecided")
        } else {
            None
        }
    }
}

/// Mean of red light over an image, and its standard error.
#[derive(Clone, Copy)]
struct Measured {
    mean: f64,
    error: f64,
    /// Largest relative bias.
    bias: f64,
}

/// Returns the mean over a film, whose pixels are independent.
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
    Measured {
        mean: mean / count,
        error: squares.sqrt() / count,
        bias: 0.0,
    }
}

/// Asserts that an estimator is right in a table of scenes that has all pairs. `run` returns the
/// paths that it counts, unless they have a closed form, and the measured mean.
fn assert_right(
    name: &str,
    factors: &'static [Factor],
    takes: impl Fn(&Row) -> bool,
    run: impl Fn(&Row, &Scene, u64) -> (Option<Light>, Measured) + Sync,
) {
    let rows = table(factors, &takes);
    let check = |(at, row): (usize, &Row)| {
        let scene = scene_of(row);
        let seed = |side: &str| seed_for(context("features").seed, &format!("{name} {side} {at}"));
        let (light, measured) = run(row, &scene, seed("subject"));
        Found::new(row, &scene, light, measured, seed("reference"))
    };
    let found: Vec<Found> = rows.par_iter().enumerate().map(check).collect();
    let pairs = required(factors, takes);
    let seen = found
        .iter()
        .filter(|found| found.expected > 0.0)
        .map(|found| MAX_SIGMAS * found.error / found.expected + found.bias);
    let seen = 100.0 * seen.fold(0.0, f64::max);
    let off = found
        .iter()
        .filter(|found| found.expected > 0.0)
        .map(|found| (found.difference / found.expected).abs());
    println!(
        "{name}: {} pairs in {} scenes; an error of {seen:.1} % is detected in each, the largest difference is {:.1} %",
        pairs.len(),
        rows.len(),
        100.0 * off.fold(0.0, f64::max)
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
        "path",
        factors(&SETTINGS),
        supports_paths,
        |row, scene, seed| {
            let light = match row.get("bounces") {
                "three" => Some(Light::All(3)),
                _ if exact(row).is_some() => None,
                _ => Some(Light::All(u32::MAX)),
            };
            (
                light,
                by_pixel(&by_path(row, Parts::default(), scene, seed, samples())),
            )
        },
    );
}

/// Weights that count light twice are detected in most scenes.
#[test]
fn paths_that_are_wrong_are_seen() {
    struct Twice;
    default_parts!(Twice: Scattering, Roulette, Photons, Bidirectional, FiniteElements);

    impl NextEvent for Twice {
        fn mis_weight(&self, _: f64, _: f64) -> f64 {
            1.0
        }
    }
    // Shadow rays from a camera in glass do not find lights outside.
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
        let film = by_path(
            row,
            Parts::replaced(&Twice),
            &scene,
            master(),
            few_samples(),
        );
        let found = Found::new(row, &scene, light, by_pixel(&film), master());
        found
            .objection()
            .is_some_and(|text| text.starts_with("differs"))
    };
    let seen = rows.par_iter().filter(|row| is_seen(row)).count();
    // Some emitters are faint next to their background.
    println!("{seen} of {} detected", rows.len());
    assert!(seen >= 4, "{seen} of {} detected", rows.len());
}

/// Returns whether estimators of whole images handle a row: all materials but rough glass.
fn supports_images(row: &Row) -> bool {
    has_low_noise(row) && !row.has("rough glass")
}

/// Excludes closed boxes that emit: in their corners points uniform in area have infinite variance.
fn by_area(row: &Row) -> bool {
    supports_images(row) && !row.is("background", "closed box")
}

fn rays_of(estimator: impl Estimator, scene: &Scene, seed: u64) -> Measured {
    let sampling = sampling(Random, SamplerKind::Independent, seed);
    by_pixel(&film(
        scene,
        &RayRenderer {
            estimator,
            sampling,
        },
        // Near an emitter, shadow rays to points uniform in area are noisy.
        2 * samples(),
    ))
}

#[test]
fn whitted_is_right_where_any_two_features_meet() {
    let whitted = Whitted {
        segments: 5,
        ..Whitted::new(TransportRules::PHYSICAL)
    };
    assert_right("whitted", &SCENE, by_area, |_, scene, seed| {
        (
            Some(Light::Whitted(whitted.segments)),
            rays_of(whitted, scene, seed),
        )
    });
}

/// The number of segments bounds the weight of a path, which uniform directions can double at each
/// diffuse surface.
#[test]
fn the_report_is_right_where_any_two_features_meet() {
    let report = Report {
        rules: TransportRules::PHYSICAL,
        ..Report::default()
    };
    assert_right("report", &SCENE, by_area, |_, scene, seed| {
        (
            Some(Light::Report(report.segments)),
            rays_of(report, scene, seed),
        )
    });
}

/// A pair that is missing from the table is noticed, and the rows that are compared have all pairs.
#[test]
fn a_missing_pair_is_noticed() {
    let rows = table(&SCENE, supports_images);
    let required = required(&SCENE, supports_images);
    assert!(missing(required.clone(), &rows).is_empty());
    let without: Vec<&Row> = rows
        .iter()
        .filter(|row| !(row.has("mesh") && row.has("ggx")))
        .collect();
    assert!(
        missing(required, without.iter().copied())
            .iter()
            .any(|[a, b]| a.level == "ggx" && b.level == "mesh")
    );
}
