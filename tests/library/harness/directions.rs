//! Tests of sampled directions: tables by hand, and the statistic that detects each fault.

use whitefurnace::harness::directions::{Density, Directions, Precision, Rounding, Sample};
use whitefurnace::material::Model as _;
use whitefurnace::material::ggx::Ggx;

use super::*;

const N: u64 = 400_000;

/// Number of random assertions in this module: chi-squares and means of right samples, and the mean
/// of weights.
pub const ASSERTIONS: usize = 3 * 10 + 1;

/// Returns the names of outcomes that do not hold for samples that are a function of two numbers.
fn not_held(
    name: &str,
    density: &Density,
    mean_weight: Option<f64>,
    sample: impl Fn(u64, [f64; 2]) -> Sample,
) -> Vec<String> {
    let mut rng = rng(name);
    let mut directions = Directions::new(density);
    (0..N).for_each(|i| directions.push(&sample(i, uniform2(&mut rng))));
    let outcomes = directions.outcomes(0.05, mean_weight);
    assert!(outcomes[1].name.ends_with("333 cells") && outcomes[1].claim == Claim::Test);
    let failed = outcomes
        .iter()
        .filter(|outcome| outcome.verdict() != Verdict::Holds);
    failed.map(|outcome| outcome.name.clone()).collect()
}

fn only(direction: DVec3) -> Sample {
    Sample {
        direction: Some(direction),
        weight: None,
        pdf: None,
    }
}

fn cosine() -> Density {
    Density::new(Domain::CosineHemisphere, |w| cosine_hemisphere_pdf(w.z))
}

#[test]
fn right_samples_hold_with_their_weights_and_pdfs() {
    let right = |_, random| {
        let direction: DVec3 = cosine_hemisphere(random);
        let (weight, pdf) = (Some(0.5), Some(direction.z * FRAC_1_PI));
        Sample {
            direction: Some(direction),
            weight,
            pdf,
        }
    };
    assert_eq!(not_held("cosine", &cosine(), Some(0.5), right), [""; 0]);
    // A sampler that loses directions below the horizon.
    let (ggx, wo) = (
        Ggx {
            reflectance: DVec3::ONE,
            alpha: 0.5,
        },
        from_spherical(1.2, 0.0),
    );
    let density = Density::new(Domain::Hemisphere, move |wi| {
        if wi.z > 0.0 { ggx.pdf(wo, wi) } else { 0.0 }
    });
    let albedo = Domain::Hemisphere
        .integrate_all(1e-6, &|wi| ggx.eval(wo, wi).x * wi.z)
        .value;
    let sample = |random| {
        let direction = ggx.sample(wo, random);
        let weight = direction.map_or(0.0, |wi| ggx.eval(wo, wi).x * wi.z / ggx.pdf(wo, wi));
        Sample {
            direction,
            weight: Some(weight),
            pdf: None,
        }
    };
    assert_eq!(
        not_held("losses", &density, Some(albedo), |_, random| sample(random)),
        [""; 0]
    );
    let unlost = |random| Sample {
        direction: ggx.sample(wo, random).or(Some(cosine_hemisphere(random))),
        ..sample(random)
    };
    let wrong = not_held("none lost", &density, None, |_, random| unlost(random));
    assert!(
        wrong[0].ends_with(" cells"),
        "losses are part of the law: {wrong:?}"
    );
}

/// Each fault is detected by the statistic meant for it.
#[test]
fn each_fault_is_noticed_by_its_statistic() {
    let fails = |name: &str, by: &str, sample: &dyn Fn(u64, DVec3) -> Sample| {
        let wrong = not_held(name, &cosine(), Some(0.5), |i, random| {
            sample(i, cosine_hemisphere(random))
        });
        assert!(
            wrong.iter().any(|outcome| outcome.ends_with(by)),
            "{name}: {wrong:?}"
        );
    };
    let with = |direction, weight, pdf| Sample {
        direction: Some(direction),
        weight: Some(weight),
        pdf: Some(pdf),
    };
    fails("narrow", "mean of u", &|_, w| {
        only(DVec3::new(0.97 * w.x, 0.97 * w.y, w.z).normalize())
    });
    fails("leaning", "mean of sin 4πv", &|_, w| {
        only(DVec3::new(w.x + 0.05 * w.y, w.y, w.z).normalize())
    });
    // A hole of 1/250 of all samples, mirrored to where it does not change the means.
    let hole = |w: DVec3| w.distance(DVec3::new(0.6, 0.0, 0.8)) < 0.07;
    fails("hole", "333 cells", &|_, w| {
        only(if hole(w) {
            DVec3::new(-w.x, w.y, w.z)
        } else {
            w
        })
    });
    fails("below", " cells", &|i, w| only(if i == 7 { -w } else { w }));
    fails("heavy", "mean weight", &|_, w| {
        with(w, 0.5001, w.z * FRAC_1_PI)
    });
    fails("uneven", "mean weight", &|i, w| {
        with(w, if i % 2 == 0 { 0.2 } else { 0.86 }, w.z * FRAC_1_PI)
    });
    let lost = |i: u64, w| Sample {
        direction: (!i.is_multiple_of(5)).then_some(w),
        weight: Some(0.5),
        pdf: None,
    };
    fails("lost", "mean weight", &lost);
    fails("one pdf", "reported pdf", &|i, w| {
        with(w, 0.5, w.z * FRAC_1_PI * if i == 9 { 1.002 } else { 1.0 })
    });
    fails("no number", "reported pdf", &|i, w| {
        with(w, 0.5, if i == 9 { f64::NAN } else { w.z * FRAC_1_PI })
    });
}

/// In a table of 2 × 2 cells each entry's pdf is its share over a quarter of the hemisphere.
#[test]
fn a_table_is_constant_on_its_cells() {
    let density = Density::from_table(Domain::Hemisphere, &[vec![3.0, 1.0], vec![0.0, 4.0]]);
    let quarter = 0.5 * PI;
    for (w, share) in [
        (DVec3::new(0.3, 0.1, 0.9), 3.0),
        (DVec3::new(0.3, -0.1, 0.9), 1.0),
        (DVec3::new(0.3, 0.9, 0.1), 0.0),
        (DVec3::new(0.3, -0.9, 0.1), 4.0),
    ] {
        assert_relative_eq!(
            density.pdf(w.normalize()),
            share / 8.0 / quarter,
            max_relative = 1e-9
        );
    }
    assert_eq!(density.pdf(-DVec3::Z), 0.0);
    // Height and azimuth within the cell that the first number selects.
    let cells = [
        ([0.0, 0.375], 1.0, 0.0),
        ([0.375, 0.5], 1.0, 1.0),
        ([0.5, 1.0], 0.0, 1.0),
    ];
    let by_table = |turned: f64| {
        move |_, [r1, r2]: [f64; 2]| {
            let ([from, to], row, column) = cells
                .into_iter()
                .find(|([_, to], ..)| r1 < *to)
                .expect("r1 < 1");
            let (z, phi) = (
                0.5 * (row + (r1 - from) / (to - from)),
                PI * (column + turned + r2),
            );
            let radius = (1.0 - z * z).sqrt();
            only(DVec3::new(radius * phi.cos(), radius * phi.sin(), z))
        }
    };
    assert_eq!(not_held("table", &density, None, by_table(0.0)), [""; 0]);
    assert!(not_held("turned", &density, None, by_table(0.1)).len() > 1);
}

/// Weights with one decimal: differences within rounding are undecided, larger ones fail.
#[test]
fn coarse_weights_are_undecided() {
    let density = cosine();
    let precision = Precision {
        weight: Rounding::printed(1, 17),
        ..Precision::DOUBLE
    };
    let verdict = |weight: f64, expected: f64, margin: f64| {
        let mut directions = Directions::with_precision(&density, precision);
        (0..1000).for_each(|_| {
            directions.push(&Sample {
                weight: Some(weight),
                ..only(DVec3::Z)
            });
        });
        directions
            .outcomes(margin, Some(expected))
            .pop()
            .expect("a mean weight")
            .verdict()
    };
    assert_eq!(verdict(0.5, 0.52, 0.2), Verdict::Holds);
    assert_eq!(
        verdict(0.5, 0.52, 0.05),
        Verdict::Undecided { needed: u64::MAX }
    );
    assert_eq!(
        [verdict(0.5, 0.56, 0.2), verdict(0.5, 0.56, 0.05)],
        [Verdict::Fails; 2]
    );
}

/// Few samples are undecided, and so are none.
#[test]
fn few_samples_are_undecided() {
    let density = cosine();
    let mut directions = Directions::new(&density);
    directions.push(&only(DVec3::Z));
    let undecided = |outcome: &Outcome| matches!(outcome.verdict(), Verdict::Undecided { .. });
    assert!(
        Directions::new(&density)
            .outcomes(0.05, None)
            .iter()
            .all(undecided)
    );
    assert!(
        directions.outcomes(0.05, None).iter().all(undecided) && directions.mean_weight().is_none()
    );
}

/// Samples that rounding may have moved out of the density are not forbidden; many that are make
/// few of these so.
#[test]
fn samples_at_the_border_are_not_forbidden() {
    let density = cosine();
    let mut directions = Directions::new(&density);
    let mut found = |z: f64| {
        let direction = DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
        (0..300).for_each(|_| directions.push(&only(direction)));
        format!("{:?}", directions.outcomes(0.05, None))
    };
    let [at_border, _, after_others] = [-1e-9, -0.5, -1e-9].map(&mut found);
    assert!(!at_border.contains("samples are outside"), "{at_border}");
    let is_count =
        |count: &u32| after_others.contains(&format!("\"{count} of 900 samples are outside"));
    assert!((300..315).any(|count| is_count(&count)), "{after_others}");
}
