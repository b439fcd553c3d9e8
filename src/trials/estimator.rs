//! The family of whole estimators: its trials are in [`super::furnace`], [`super::irradiance`],
//! [`super::glass`] and [`super::images`]; here are its faults.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::subject::{RIGHT, STANDARD, Setup, Subject, Table, parts};
use crate::bsdf::{Bsdf, OrenNayar, OrenNayarForm};
use crate::emitter::{Emitter, EmitterPoint, EmitterShape};
use crate::equation::{
    COSINE, COSINE_HEMISPHERE, ESTIMATOR, FRESNEL, FRESNEL_P, FRESNEL_S, GEOMETRY, HEMISPHERE_PDF,
    HEMISPHERE_PHI, HEMISPHERE_THETA, LAMBERT, MIS, OREN_NAYAR, OREN_NAYAR_CONSTANTS, PATH_LENGTH,
    REFRACTION, RENDERING, ROULETTE, WHITTED,
};
use crate::estimator::LightRules;
use crate::fresnel::{mirror, radiance_factor, reflectance, reflectance_p, reflectance_s, refract};
use crate::sampling::{cosine_hemisphere, uniform_hemisphere, uniform_hemisphere_pdf};
use crate::scene::Scene;
use crate::shape::triangle_point;
use crate::trials::fresnel::{no_total_reflection, schlick};
use crate::trials::hemisphere::{
    half_circle, half_circle_cosine, linear_theta, no_root, shared_number,
};
use crate::trials::{furnace, glass, images, irradiance};
use crate::zoo::{AnyFamily, Family, Mutant, mutant};

/// The family.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let mut benches = furnace::benches();
    benches.extend(irradiance::benches());
    benches.extend(glass::benches());
    benches.extend(images::benches());
    let mut faults = reflection();
    faults.extend(sampling());
    faults.extend(lights());
    faults.extend(interfaces());
    faults.extend(told());
    vec![Box::new(Family {
        whole_estimator: true,
        benches,
        faults,
        equivalents: equivalents(),
        share: 1.0 / 4.0,
        ..Family::new("estimator", STANDARD)
    })]
}

/// The albedo of a diffuse surface squared.
fn squared_albedo(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> DVec3 {
    bsdf.eval(wo, wi) * bsdf.albedo()
}

/// (14) in another form, or with other constants.
fn oren_nayar(bsdf: &Bsdf, wo: DVec3, wi: DVec3, form: OrenNayarForm, a: fn(f64) -> f64) -> DVec3 {
    match *bsdf {
        Bsdf::OrenNayar {
            albedo, constants, ..
        } => {
            let constants = OrenNayar {
                a: a(constants.a),
                ..constants
            };
            Bsdf::OrenNayar {
                albedo,
                constants,
                form,
            }
            .eval(wo, wi)
        }
        _ => bsdf.eval(wo, wi),
    }
}

fn reflection() -> Vec<Mutant<Subject>> {
    vec![
        mutant(
            "no-pi",
            &LAMBERT,
            "the BRDF misses 1/π",
            parts(Table {
                brdf: |bsdf, wo, wi| PI * bsdf.eval(wo, wi),
                ..RIGHT
            }),
            &["irradiance/rectangle-whitted"],
        ),
        mutant(
            "albedo-squared",
            &LAMBERT,
            "the albedo enters twice",
            parts(Table {
                brdf: squared_albedo,
                ..RIGHT
            }),
            &["furnace/path/albedo-0.75"],
        ),
        mutant(
            "printed-oren-nayar",
            &OREN_NAYAR,
            "sin β for tan β, as printed",
            parts(Table {
                brdf: |bsdf, wo, wi| oren_nayar(bsdf, wo, wi, OrenNayarForm::Printed, |a| a),
                ..RIGHT
            }),
            &["furnace/sky/oren-nayar"],
        ),
        mutant(
            "oren-nayar-constant",
            &OREN_NAYAR_CONSTANTS,
            "0.57 for 0.33 in A",
            parts(Table {
                brdf: |bsdf, wo, wi| {
                    // A = 1 − σ²/2(σ² + 0.33), solved for σ².
                    oren_nayar(bsdf, wo, wi, OrenNayarForm::Corrected, |a| {
                        let s2 = 0.66 * (1.0 - a) / (2.0 * a - 1.0);
                        1.0 - s2 / (2.0 * (s2 + 0.57))
                    })
                },
                ..RIGHT
            }),
            &["furnace/sky/oren-nayar"],
        ),
        mutant(
            "cosine-dropped",
            &COSINE,
            "f* = f_r: no cosine",
            parts(Table {
                cosine: |n, w| if n.dot(w) > 0.0 { 1.0 } else { 0.0 },
                ..RIGHT
            }),
            &["irradiance/rectangle", "irradiance/shadow-rays-alone"],
        ),
        mutant(
            "cosine-doubled",
            &COSINE,
            "the cosine enters twice",
            parts(Table {
                cosine: |n, w| n.dot(w).max(0.0).powi(2),
                ..RIGHT
            }),
            &["irradiance/rectangle", "furnace/sky/path"],
        ),
        mutant(
            "reflection-lost",
            &RENDERING,
            "a twentieth of the integral in (8) is lost at each bounce",
            parts(Table {
                brdf: |bsdf, wo, wi| 0.95 * bsdf.eval(wo, wi),
                ..RIGHT
            }),
            &["furnace/cavity/reflecting", "furnace/cavity/black"],
        ),
    ]
}

fn sampling() -> Vec<Mutant<Subject>> {
    vec![
        mutant(
            "uniform-for-cosine",
            &COSINE_HEMISPHERE,
            "uniform directions with the cosine pdf's weight",
            parts(Table {
                cosine_hemisphere: uniform_hemisphere,
                ..RIGHT
            }),
            &["irradiance/hits-alone"],
        ),
        mutant(
            "cosine-no-root",
            &COSINE_HEMISPHERE,
            "sin θ = r for sin θ = √r",
            parts(Table {
                cosine_hemisphere: no_root,
                ..RIGHT
            }),
            &["furnace/sky/path"],
        ),
        mutant(
            "cosine-half-circle",
            &COSINE_HEMISPHERE,
            "φ over half the circle",
            parts(Table {
                cosine_hemisphere: half_circle_cosine,
                ..RIGHT
            }),
            &["furnace/sky/path"],
        ),
        mutant(
            "shared-number",
            &HEMISPHERE_PHI,
            "one random number in (18) and (19)",
            parts(Table {
                uniform_hemisphere: shared_number,
                ..RIGHT
            }),
            &["furnace/sky/report"],
        ),
        mutant(
            "half-circle",
            &HEMISPHERE_PHI,
            "φ = πr for 2πr",
            parts(Table {
                uniform_hemisphere: half_circle,
                ..RIGHT
            }),
            &["furnace/sky/report"],
        ),
        mutant(
            "linear-theta",
            &HEMISPHERE_THETA,
            "θ = rπ/2",
            parts(Table {
                uniform_hemisphere: linear_theta,
                ..RIGHT
            }),
            &["furnace/sky/report"],
        ),
        mutant(
            "cosine-for-uniform",
            &HEMISPHERE_THETA,
            "cosine-weighted directions with the weight of (17)",
            parts(Table {
                uniform_hemisphere: cosine_hemisphere,
                ..RIGHT
            }),
            &["furnace/report/absorption-0.25"],
        ),
        mutant(
            "pdf-twice",
            &HEMISPHERE_PDF,
            "p = 1/π",
            parts(Table {
                uniform_hemisphere_pdf: |cos| 2.0 * uniform_hemisphere_pdf(cos),
                ..RIGHT
            }),
            &[
                "furnace/report/absorption-0.25",
                "furnace/report/seven-segments",
                "furnace/sky/report",
                "images/diffuse-room",
            ],
        ),
        mutant(
            "no-roulette-weight",
            &ROULETTE,
            "survivors are not divided by the survival",
            parts(Table {
                roulette_weight: |_| 1.0,
                ..RIGHT
            }),
            &[
                "furnace/path/albedo-0.75",
                "furnace/report/absorption-0.1",
                "furnace/mirrors/hall",
                "furnace/mirrors/facing",
                "glass/cube-outside",
                "images/white-furnace",
            ],
        ),
        mutant(
            "roulette-flipped",
            &ROULETTE,
            "survives if r ≥ survival",
            parts(Table {
                survives: |r, q| r >= q,
                ..RIGHT
            }),
            &["furnace/path/albedo-0.9"],
        ),
        mutant(
            "roulette-other-share",
            &ROULETTE,
            "divides by α for 1 − α",
            parts(Table {
                roulette_weight: |q| 1.0 / (1.0 - q),
                ..RIGHT
            }),
            &["furnace/sky/path"],
        ),
        mutant(
            "black-holes",
            &ROULETTE,
            "survival 0 where the throughput is below 0.6: light is lost with the path",
            parts(Table {
                survival_by_throughput: |t| {
                    let q = t.max_element();
                    if q < 0.6 { 0.0 } else { q.min(0.95) }
                },
                ..RIGHT
            }),
            &["furnace/path/albedo-0.5"],
        ),
    ]
}

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

fn lights() -> Vec<Mutant<Subject>> {
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
            &["irradiance/half-hidden"],
        ),
        mutant(
            "shadows-pass-glass",
            &MIS,
            "shadow rays pass glass, and light through glass counts as well when it is hit",
            parts(Table {
                visible: |scene, x, y, _| scene.visible(x, y, true),
                ..RIGHT
            }),
            &["glass/index-matched"],
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
            &["irradiance/rectangle"],
        ),
        mutant(
            "not-counted",
            &MIS,
            "light counts neither as hit nor as sampled after a diffuse bounce",
            parts(Table {
                mis_weight: |_, _| 0.0,
                ..RIGHT
            }),
            &["irradiance/rectangle"],
        ),
        mutant(
            "squares-weight",
            &MIS,
            "the square of the balance heuristic: weights sum to less than one",
            parts(Table {
                mis_weight: |p, q| (p / (p + q)).powi(2),
                ..RIGHT
            }),
            &["irradiance/weights", "irradiance/rectangle"],
        ),
        mutant(
            "equal-weights",
            &MIS,
            "half for each strategy: the mean stays, the variance does not",
            parts(Table {
                mis_weight: |_, _| 0.5,
                ..RIGHT
            }),
            &["irradiance/weights"],
        ),
        mutant(
            "weights-swapped",
            &MIS,
            "each strategy gets the other's weight: the mean stays, the variance does not",
            parts(Table {
                mis_weight: |p, q| q / (p + q),
                ..RIGHT
            }),
            &["irradiance/weights"],
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
            &["irradiance/rectangle-report", "irradiance/triangle"],
        ),
        mutant(
            "distance-not-squared",
            &GEOMETRY,
            "the distance for its square",
            parts(Table {
                solid_angle_per_area: |cos, d2| cos / d2.sqrt(),
                ..RIGHT
            }),
            &["irradiance/rectangle-report", "irradiance/sphere"],
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
            &["irradiance/sphere", "irradiance/rectangle"],
        ),
        mutant(
            "light-squeezed",
            &GEOMETRY,
            "points are not uniform on a light",
            parts(Table {
                sample_emitter: squeezed,
                ..RIGHT
            }),
            &["irradiance/sphere"],
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

fn interfaces() -> Vec<Mutant<Subject>> {
    let fresnel = |name, equation, wrong, fresnel: fn(f64, f64, f64) -> f64, caught_by| {
        let table = Table { fresnel, ..RIGHT };
        mutant(name, equation, wrong, parts(table), caught_by)
    };
    let factor = |name, wrong, radiance_factor: fn(f64, f64) -> f64| {
        let table = Table {
            radiance_factor,
            ..RIGHT
        };
        let caught_by: &[&str] = &["glass/cube-inside", "glass/lit-from-below"];
        mutant(name, &REFRACTION, wrong, parts(table), caught_by)
    };
    vec![
        fresnel(
            "only-s",
            &FRESNEL_S,
            "(10) alone",
            reflectance_s,
            &["glass/reflects-60", "glass/snell-aim"],
        ),
        fresnel(
            "only-p",
            &FRESNEL_P,
            "(11) alone",
            reflectance_p,
            &["glass/reflects-75", "glass/reflects-60"],
        ),
        fresnel(
            "schlick",
            &FRESNEL,
            "Schlick's approximation",
            schlick,
            &["glass/reflects-60"],
        ),
        fresnel(
            "indices-swapped",
            &FRESNEL,
            "n₁ and n₂ exchanged in (12)",
            |c, n1, n2| reflectance(c, n2, n1),
            &["glass/reflects-60", "glass/reflects-85"],
        ),
        mutant(
            "no-total-reflection",
            &FRESNEL,
            "past the critical angle a finite R, and light that leaves straight on",
            parts(Table {
                fresnel: no_total_reflection,
                refract: |d, n, n1, n2| Some(refract(d, n, n1, n2).unwrap_or(d)),
                ..RIGHT
            }),
            &["glass/total-reflection", "glass/cube-trapped"],
        ),
        factor(
            "no-radiance-factor",
            "T = 1 − R is all that refraction does, as the report has it",
            |_, _| 1.0,
        ),
        factor(
            "radiance-factor-inverted",
            "(n₂/n₁)² for (n₁/n₂)²",
            |n1, n2| radiance_factor(n2, n1),
        ),
        mutant(
            "snell-inverted",
            &REFRACTION,
            "n₂/n₁ for n₁/n₂ in Snell's law",
            parts(Table {
                refract: |d, n, n1, n2| refract(d, n, n2, n1),
                ..RIGHT
            }),
            &["glass/snell-aim"],
        ),
        mutant(
            "not-refracted",
            &REFRACTION,
            "light goes straight on into the glass",
            parts(Table {
                refract: |d, n, n1, n2| refract(d, n, n1, n2).map(|_| d),
                ..RIGHT
            }),
            &["glass/snell-aim"],
        ),
        mutant(
            "mirror-sign",
            &REFRACTION,
            "the mirror direction with the wrong sign: back to where it came from",
            parts(Table {
                mirror: |d, n| -mirror(d, n),
                ..RIGHT
            }),
            &["glass/mirror-aim"],
        ),
        mutant(
            "mirror-half",
            &REFRACTION,
            "the mirror direction without its factor 2: along the surface",
            parts(Table {
                mirror: |d, n| (d - d.dot(n) * n).normalize(),
                ..RIGHT
            }),
            &["glass/mirror-aim"],
        ),
    ]
}

/// Faults in what an estimator is told.
fn told() -> Vec<Mutant<Subject>> {
    let rules = |rules| Setup { rules, ..STANDARD };
    let segments = |segments| Setup {
        segments: Some(segments),
        ..STANDARD
    };
    vec![
        mutant(
            "seven-segments",
            &PATH_LENGTH,
            "at most seven segments, called unbiased",
            segments(7),
            &["furnace/report/albedo-0.65"],
        ),
        mutant(
            "four-segments",
            &PATH_LENGTH,
            "one segment more than said",
            segments(4),
            &["furnace/report/three-segments"],
        ),
        mutant(
            "not-seen-in-mirrors",
            &WHITTED,
            "lights are dark to rays that have met only mirrors and glass",
            rules(LightRules {
                seen: Some(0.0),
                ..LightRules::PHYSICAL
            }),
            &["glass/mirror-aim"],
        ),
        mutant(
            "lights-show-one",
            &WHITTED,
            "lights that are seen show 1, as in the report's figures",
            rules(LightRules {
                seen: Some(1.0),
                ..LightRules::PHYSICAL
            }),
            &["glass/mirror-aim"],
        ),
        mutant(
            "rules-without-factor",
            &REFRACTION,
            "the report's rules: radiance is not scaled by (n₁/n₂)²",
            rules(LightRules::REPORT),
            &["glass/snell-aim"],
        ),
    ]
}

fn equivalents() -> Vec<Mutant<Subject>> {
    vec![
        mutant(
            "survival-constant",
            &ROULETTE,
            "survival 0.9 whatever the throughput: every policy has the same mean",
            parts(Table {
                survival_by_throughput: |_| 0.9,
                ..RIGHT
            }),
            &["furnace/cavity/black"],
        ),
        mutant(
            "one-minus-r",
            &COSINE_HEMISPHERE,
            "1 − r for r: as uniform as r",
            parts(Table {
                cosine_hemisphere: |[r1, r2]| cosine_hemisphere([1.0 - r1, 1.0 - r2]),
                ..RIGHT
            }),
            &["furnace/sky/path"],
        ),
        mutant(
            "uniform-with-its-weight",
            &ESTIMATOR,
            "uniform directions with the uniform pdf: another density, the same mean",
            parts(Table {
                cosine_hemisphere: uniform_hemisphere,
                cosine_hemisphere_pdf: |_| 0.5 * FRAC_1_PI,
                ..RIGHT
            }),
            &["furnace/cavity/black"],
        ),
    ]
}
