//! Tests of pdfs that are judged by their own samples.

use whitefurnace::harness::directions::own_pdf::{OwnPdfs, cap_on_own_side};
use whitefurnace::harness::directions::{Precision, Rounding};
use whitefurnace::material::Model as _;
use whitefurnace::material::ggx::Ggx;
use whitefurnace::sampling::warp::sphere_zone;

use super::*;

/// Number of draws of a sampler. The sample skewness of its blocks, below 0.09, stays below the
/// limit of the t test, 0.30, by six of its standard deviations, 0.032.
const N: u64 = 12_000_000;
const MARGIN: f64 = 0.05;

/// Number of random assertions in this module: ten for each of two right samplers, and of a third
/// two components and three integrals.
pub const ASSERTIONS: usize = 2 * 10 + 2 + 3;

/// A draw: a direction and its reported pdf.
type Draw = (Option<DVec3>, f64);

/// Returns the outcomes of this many draws.
fn outcomes(mut own: OwnPdfs, n: u64, mut draw: impl FnMut() -> Draw) -> Vec<Outcome> {
    for _ in 0..n {
        let (direction, pdf) = draw();
        own.push(direction, pdf);
    }
    own.outcomes(MARGIN)
}

/// Returns the names of the outcomes whose verdict is one of those asked for.
fn named(outcomes: &[Outcome], asked: impl Fn(Verdict) -> bool) -> Vec<&str> {
    let found = outcomes.iter().filter(|o| asked(o.verdict()));
    found.map(|o| o.name.as_str()).collect()
}

fn not_held(outcomes: &[Outcome]) -> Vec<&str> {
    named(outcomes, |verdict| verdict != Verdict::Holds)
}

fn failed(outcomes: &[Outcome]) -> Vec<&str> {
    named(outcomes, |verdict| verdict == Verdict::Fails)
}

fn assert_holds(own: OwnPdfs, draw: impl FnMut() -> Draw) {
    assert_eq!(not_held(&outcomes(own, N, draw)), [""; 0]);
}

/// Compares the solid angle with an integral over circles around the direction.
#[test]
fn caps_end_at_the_horizon() {
    let mut rng = rng("caps");
    for _ in 0..200 {
        let [theta, alpha] = [0.5 * PI, PI].map(|most| between(&mut rng, 1e-3, most));
        // Length of the part of the circle at an angle β that is above the horizon: at the
        // azimuths ψ with cos β cos θ + sin β sin θ cos ψ > 0.
        let circle = |beta: f64| {
            let cos = -(theta.tan() * beta.tan()).recip();
            2.0 * beta.sin() * cos.clamp(-1.0, 1.0).acos()
        };
        const STEPS: u32 = 200_000;
        let step = alpha / f64::from(STEPS);
        let sum: f64 = (0..STEPS)
            .map(|i| circle((f64::from(i) + 0.5) * step))
            .sum();
        let chord = 2.0 * (0.5 * alpha).sin();
        let found = cap_on_own_side(theta.cos(), chord * chord);
        assert!(
            (found - sum * step).abs() < 1e-5,
            "{theta} {alpha}: {found}, not {}",
            sum * step
        );
        assert_eq!(found, cap_on_own_side(-theta.cos(), chord * chord));
    }
}

#[test]
fn right_samplers_hold() {
    let mut rng = rng("right");
    // A smooth density down to the horizon. Means in regions are judged for those that are not.
    let covering = OwnPdfs::covering(Precision::DOUBLE, Domain::Hemisphere);
    let found = outcomes(covering, N, || {
        let w: DVec3 = cosine_hemisphere(uniform2(&mut rng));
        (Some(w), w.z * FRAC_1_PI)
    });
    let mut names = not_held(&found);
    names.retain(|name| !name.starts_with("pdf in region"));
    assert_eq!(names, [""; 0]);
    // A jump of the density, in numbers of five decimals.
    let printed = |x: f64| (1e5 * x).round() / 1e5;
    let rounding = Rounding::printed(5, 5);
    let precision = Precision {
        direction: rounding,
        weight: rounding,
        pdf: rounding,
    };
    assert_holds(OwnPdfs::new(precision), || {
        let w: DVec3 = sphere_zone(uniform2(&mut rng), 1.0, [0.9, 1.0]);
        let direction = DVec3::from_array(w.to_array().map(printed));
        (Some(direction), printed(10.0 / TAU))
    });
    // A narrow lobe with long tails, and samples that are lost.
    let wo = from_spherical(80f64.to_radians(), 0.0);
    let metal = Ggx {
        reflectance: DVec3::ONE,
        alpha: 0.02,
    };
    assert_holds(OwnPdfs::new(Precision::DOUBLE), || {
        let wi = metal.sample(wo, uniform2(&mut rng));
        (wi, wi.map_or(0.0, |wi| metal.pdf(wo, wi)))
    });
}

#[test]
fn wrong_pdfs_fail() {
    let mut rng = rng("wrong");
    let own = || OwnPdfs::covering(Precision::DOUBLE, Domain::Hemisphere);
    let cosine = |random| -> DVec3 { cosine_hemisphere(random) };
    // Normalised, but the density of another sampler.
    let found = outcomes(own(), N / 3, || {
        let w: DVec3 = uniform_hemisphere(uniform2(&mut rng));
        (Some(w), w.z * FRAC_1_PI)
    });
    let names = not_held(&found);
    assert!(
        names == failed(&found) && names.len() == 11 && names[10] == "integral of z²",
        "{found:?}"
    );
    let found = outcomes(own(), N / 3, || {
        let w = cosine(uniform2(&mut rng));
        (Some(w), 1.1 * w.z * FRAC_1_PI)
    });
    let names = failed(&found);
    assert!(names.contains(&"pdf in region 8"), "{found:?}");
    assert!(names.contains(&"integral of |z|"), "{found:?}");
    // One random number for both coordinates: lines in place of an area.
    let found = outcomes(own(), 400_000, || {
        let [r, _] = uniform2(&mut rng);
        let w = cosine([r, r]);
        (Some(w), w.z * FRAC_1_PI)
    });
    let names = not_held(&found);
    assert!(names.contains(&"integral of |z|(1 + y)"), "{names:?}");
    assert!(names.len() > 8, "{names:?}");
    // Random numbers of eight bits, and a sampler that is stuck.
    for levels in [256.0, 1.0] {
        let found = outcomes(OwnPdfs::new(Precision::DOUBLE), 400_000, || {
            let w = cosine(uniform2(&mut rng).map(|r| (r * levels).floor() / levels));
            (Some(w), w.z * FRAC_1_PI)
        });
        let names = not_held(&found);
        assert!(names.contains(&"repeated directions"), "{names:?}");
    }
}

/// Directions of two decimals say nothing about a narrow lobe, and few samples about any.
#[test]
fn what_cannot_be_judged_is_undecided() {
    let mut rng = rng("coarse");
    let rounding = Rounding::printed(2, 2);
    let precision = Precision {
        direction: rounding,
        weight: rounding,
        pdf: Rounding::DOUBLE,
    };
    let mut narrow = OwnPdfs::new(precision);
    let mut few = OwnPdfs::new(Precision::DOUBLE);
    for i in 0..100_000 {
        let w: DVec3 = sphere_zone(uniform2(&mut rng), 1.0, [0.999, 1.0]);
        narrow.push(Some(w), 1e3 / TAU);
        if i < 1000 {
            few.push(Some(w), 1e3 / TAU);
        }
    }
    for own in [narrow, few] {
        for outcome in own
            .outcomes(MARGIN)
            .iter()
            .filter(|outcome| outcome.is_random())
        {
            assert!(
                matches!(outcome.verdict(), Verdict::Undecided { .. }),
                "{outcome}"
            );
        }
    }
}

/// Pdfs are judged if they are rounded by less than 1 %, whatever the size of their significand,
/// and directions if their rounding is small beside the distance of neighbours.
#[test]
fn numbers_that_are_too_coarse_are_not_judged() {
    let exact = Precision::DOUBLE;
    let pdfs = |relative| Precision {
        pdf: Rounding {
            absolute: 0.0,
            relative,
            base: 10.0,
        },
        ..exact
    };
    let directions = |digits| Precision {
        direction: Rounding::printed(digits, digits),
        ..exact
    };
    // The pdf is 0.159: its significand is 1.59.
    for (precision, is_coarse) in [
        (pdfs(0.012), false),
        (pdfs(0.03), true),
        (directions(5), false),
        (directions(2), true),
    ] {
        let mut rng = rng("coarse");
        let found = outcomes(OwnPdfs::new(precision), 50_000, || {
            let w: DVec3 = uniform_hemisphere(uniform2(&mut rng));
            (Some(w), 1.0 / TAU)
        });
        let text = format!("{found:?}");
        assert_eq!(
            text.contains("too coarse for this density"),
            is_coarse,
            "{precision:?}"
        );
    }
}
