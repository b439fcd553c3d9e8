//! Tests each density that `judge` knows by name with right and wrong samples over its whole range,
//! by samplers written here.

use std::f64::consts::{PI, TAU};

use experiments::judge::density_of_name;
use glam::DVec3;
use whitefurnace::harness::directions::{Directions, Precision, Sample};
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::material::Model as _;
use whitefurnace::material::ggx::Ggx;
use whitefurnace::math::frame::from_spherical;
use whitefurnace::sampling::rng::{seed_for, stream, uniform2};

/// Samples a density by inverting its distribution function, from two uniform numbers; `None` if
/// the sample is lost.
type Sampler = Box<dyn Fn([f64; 2]) -> Option<DVec3>>;

fn around(z: f64, r2: f64) -> Option<DVec3> {
    let (sin, cos) = (TAU * r2).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Some(DVec3::new(radius * cos, radius * sin, z))
}

/// z^n about the normal: z = (1 − r)^(1/(n + 1)).
fn power(n: f64) -> Sampler {
    Box::new(move |[r1, r2]| around((1.0 - r1).powf(1.0 / (n + 1.0)), r2))
}

/// Samples Henyey and Greenstein's phase function: forward, towards z, for g > 0.
fn henyey_greenstein(g: f64) -> Sampler {
    Box::new(move |[r1, r2]| {
        let square = (1.0 - g * g) / (1.0 - g + 2.0 * g * r1);
        around((1.0 + g * g - square * square) / (2.0 * g), r2)
    })
}

/// Samples all facets by their projected area: tan² θ = α² r/(1 − r).
fn facets(alpha: f64) -> Sampler {
    Box::new(move |[r1, r2]| around(((1.0 - r1) / (1.0 - r1 + alpha * alpha * r1)).sqrt(), r2))
}

fn ggx(alpha: f64, degrees: f64) -> Sampler {
    let (ggx, wo) = (
        Ggx {
            reflectance: DVec3::ONE,
            alpha,
        },
        from_spherical(degrees.to_radians(), 0.0),
    );
    Box::new(move |random| ggx.sample(wo, random))
}

/// Samples two cones about a direction, at the radii of one and three quarters of a lobe of this
/// width.
fn cones(axis: DVec3, width: f64) -> Sampler {
    Box::new(move |[r1, r2]| {
        let (sin, cos) = (TAU * r2).sin_cos();
        let (x, y) = axis.any_orthonormal_pair();
        let radius = width * if r1 < 0.5 { 0.5 } else { 1.2 };
        Some((axis + radius * (cos * x + sin * y)).normalize())
            .filter(|w| w.z > 0.0 || axis.z < 0.1)
    })
}

/// Returns the verdicts on a number of samples, as text: "holds", or the outcomes that fail.
fn verdict(
    name: &str,
    samples: &str,
    precision: Precision,
    sample: &dyn Fn([f64; 2]) -> Option<DVec3>,
) -> String {
    let n = match samples {
        // They are far off.
        "cones" => 3000,
        // Half of them are lost below the horizon where facets are roughest.
        _ if name.starts_with("ggx:1,") => 60_000,
        _ => 30_000,
    };
    let density = density_of_name(name).unwrap_or_else(|error| panic!("{name}: {error}"));
    // A fixed seed: nothing is left to chance.
    let mut rng = stream(seed_for(5, &format!("{name} {samples}")), 0, 0);
    let mut directions = Directions::with_precision(&density, precision);
    for _ in 0..n {
        let direction = sample(uniform2(&mut rng));
        let pdf = direction.map(|w| density.pdf(w));
        directions.push(&Sample {
            direction,
            weight: None,
            pdf,
        });
    }
    let outcomes = directions.outcomes(0.25, None);
    let failed = outcomes
        .iter()
        .filter(|outcome| outcome.verdict() != Verdict::Holds);
    let failed: Vec<String> = failed.map(|outcome| format!("{outcome}")).collect();
    if failed.is_empty() {
        "holds".to_owned()
    } else {
        failed.join("; ")
    }
}

/// Lists names, their samplers, a slightly wrong sampler, and the direction and width of the lobe.
fn cases() -> Vec<(String, Sampler, Sampler, DVec3, f64)> {
    let mut cases: Vec<(String, Sampler, Sampler, DVec3, f64)> = vec![
        (
            "uniform-sphere".into(),
            Box::new(|[r1, r2]| around(1.0 - 2.0 * r1, r2)),
            power(0.0),
            DVec3::Z,
            0.7,
        ),
        (
            "uniform-hemisphere".into(),
            power(0.0),
            power(0.2),
            DVec3::Z,
            0.7,
        ),
        ("cosine".into(), power(1.0), power(1.2), DVec3::Z, 0.7),
    ];
    for n in [0.0, 30.0, 10_000.0f64] {
        cases.push((
            format!("cosine-power:{n}"),
            power(n),
            power(1.2 * n + 0.2),
            DVec3::Z,
            1.4 / (n + 2.0).sqrt(),
        ));
    }
    for g in [-0.99, -0.3, 0.3, 0.9, 0.99f64] {
        let right = henyey_greenstein(g);
        cases.push((
            format!("henyey-greenstein:{g}"),
            right,
            henyey_greenstein(-g),
            g.signum() * DVec3::Z,
            1.0 - g.abs(),
        ));
        cases.push((
            format!("henyey-greenstein:{g}"),
            henyey_greenstein(g),
            henyey_greenstein(0.9 * g),
            g.signum() * DVec3::Z,
            1.0 - g.abs(),
        ));
    }
    for alpha in [0.01, 0.2, 1.0] {
        cases.push((
            format!("ggx-normals:{alpha}"),
            facets(alpha),
            facets(0.9 * alpha),
            DVec3::Z,
            alpha,
        ));
        for degrees in [0.0, 60.0, 89.0f64] {
            let axis = from_spherical(degrees.to_radians(), PI);
            cases.push((
                format!("ggx:{alpha},{degrees}"),
                ggx(alpha, degrees),
                ggx(0.9 * alpha, degrees),
                axis,
                alpha,
            ));
        }
    }
    cases
}

/// Right samples hold, in double precision and rounded to single precision; wrong widths, the other
/// sign of g, and cones fail.
#[test]
fn each_named_density_tells_right_samples_from_wrong_ones() {
    let single = |right: &Sampler, random| {
        right(random).map(|w| DVec3::from_array(w.to_array().map(|v| f64::from(v as f32))))
    };
    for (name, right, wrong, axis, width) in cases() {
        assert_eq!(
            verdict(&name, "right", Precision::DOUBLE, &right),
            "holds",
            "{name}"
        );
        if ["cosine", "0.01", "0.99", "10000"]
            .iter()
            .any(|sharp| name.contains(sharp))
        {
            let stored = verdict(&name, "single", Precision::SINGLE, &|random| {
                single(&right, random)
            });
            assert_eq!(stored, "holds", "{name} in single precision");
        }
        assert!(
            verdict(&name, "wrong", Precision::DOUBLE, &wrong).contains("fails"),
            "{name}: wrong samples"
        );
        let two = cones(axis, width);
        assert!(
            verdict(&name, "cones", Precision::DOUBLE, &two).contains("fails"),
            "{name}: two cones"
        );
    }
}

/// A million samples measure each of a dozen cells to 5 % for every density: its cells are equally
/// probable.
#[test]
fn cells_are_equally_probable_however_narrow_the_lobe() {
    for (name, ..) in cases() {
        let density = density_of_name(&name).expect("a density");
        let cells = density.cells(12);
        let kept: f64 = cells.iter().sum();
        for mass in &cells {
            assert!(
                (0.9..1.1).contains(&(mass * 12.0 / kept)),
                "{name}: {cells:?}"
            );
        }
    }
}
