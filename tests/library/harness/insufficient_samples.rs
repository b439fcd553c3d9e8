//! Tests that no statistic says *holds* of samples that give no evidence.

use whitefurnace::harness::images::ImageMoments;

use super::checkup_parts::{with_eval, without_samples};
use super::*;

const WIDE_CLAIMS: [Claim; 3] = [
    Claim::Equal { delta: 1e3 },
    Claim::Equivalent { margin: 1e3 },
    Claim::Test,
];

/// Returns n equal values.
fn same(n: u64, value: f64) -> Values {
    Values::collect(0.0, n, || value)
}

fn counted(masses: &[f64], observed: &[u64]) -> Outcome {
    let counts = Counts {
        n: observed.iter().sum(),
        observed: observed.to_vec(),
        ..Counts::default()
    };
    chi_square("cells", &cells(masses), &counts, 1e3)
}

/// Returns an image of ones without variance.
fn still(pixels: usize, count: u64) -> Image {
    Image::new(&vec![1.0; pixels], &vec![0.0; pixels], &vec![count; pixels])
}

fn image(pixels: usize, count: u64) -> Outcome {
    let still = still(pixels, count);
    let pixels = still.statistics();
    let image = ImageMoments {
        statistics: &pixels,
        skewness: &still.variance,
    };
    image_mean("image", image, image, 1e3)
}

/// Every statistic is undecided on no value, one value, equal and right values, one cell, and
/// nothing to compare, whatever is claimed.
#[test]
fn samples_that_say_nothing_are_undecided() {
    let mut outcomes = Vec::new();
    for claim in WIDE_CLAIMS {
        for n in [0, 1, 2, 100, 2 * MIN_CONSTANT_VALUES] {
            let (v, squares) = (same(n, 2.0), same(n, 0.5));
            outcomes.extend([
                mean("t", &v, 2.0, claim),
                mean_known_sigma("z", &v, 2.0, 1.0, claim),
                bounded_mean("one place", &v, 2.0, [2.0, 2.0], claim),
                welch("Welch", &v, &v, claim),
                variance_ratio("ratio", &squares, &squares, 1.0, 1e3),
            ]);
        }
        // One value, or none, proves nothing, however wrong it is; nor do a few equal ones.
        for n in [0, 1, 2, 1000] {
            outcomes.push(mean("elsewhere", &same(n, 0.0), 1e-3, claim));
            outcomes.push(welch("elsewhere", &same(n, 0.0), &same(n, 1.0), claim));
        }
        for n in [0, 1] {
            let v = same(n, 2.0);
            outcomes.push(bounded_mean("bounded", &v, 2.0, [0.0, 4.0], claim));
            outcomes.push(mean_known_sigma("z", &v, 9.0, 1.0, claim));
        }
    }
    for groups in [vec![], vec![vec![1.0, 0.1]], vec![vec![1.0, 0.1]; 50]] {
        outcomes.push(slope("slope", &[1.0, 10.0], &groups, -1.0, 1e3));
    }
    outcomes.extend([
        counted(&[1.0], &[1_000_000]),
        counted(&[1.0, 0.0], &[1_000_000, 0]),
        counted(&[0.5, 0.5], &[0, 0]),
        counted(&[0.5, 0.5], &[900, 0]),
        Outcome::identity("identity of nothing", 0, 0.0, 1.0, ""),
    ]);
    outcomes.extend([0.0, 0.5, 1.0].map(|q| binomial("share", 0, 0, q, 1e3)));
    outcomes.extend([0.0, 1.0].map(|events| poisson("events", 0, 0, events, 1e3)));
    outcomes.extend([0, 1].map(|n| kolmogorov_smirnov("law", &mut vec![0.5; n], |x| x, 1e3)));
    outcomes.extend([(0, 9), (4, 0), (4, 1), (4, 9)].map(|(pixels, n)| image(pixels, n)));
    for pixels in [0, 4] {
        let still = still(pixels, 9);
        let map = welch_map(&still.statistics(), &still.statistics(), 2, 1);
        outcomes.extend([map.smallest("least", 9), map.flatness("flat", 1e3)]);
    }
    for outcome in outcomes {
        assert!(
            matches!(outcome.verdict(), Verdict::Undecided { .. }),
            "{:?}: {outcome:?}",
            outcome.verdict()
        );
        assert!(outcome.p >= 0.5, "{outcome:?}");
    }
}

/// Samples that certainly contradict a claim are rejected.
#[test]
fn samples_that_speak_against_a_claim_are_heard() {
    let claim = Claim::Equal { delta: 0.003 };
    let failing = [
        mean("black", &same(2 * MIN_CONSTANT_VALUES, 0.0), 1.0, claim),
        counted(&[1.0, 0.0], &[999_999, 1]),
        kolmogorov_smirnov("stuck", &mut vec![0.5; 1000], |x| x, 0.01),
        binomial("never", 1, 1_000_000, 0.0, 0.01),
        binomial("always", 999_999, 1_000_000, 1.0, 0.01),
        poisson("none", 1, 1_000_000, 0.0, 30.0),
        // Values that are not numbers, even a single one.
        mean("NaN", &same(1, f64::NAN), 1.0, claim),
        welch("NaN", &same(1, f64::NAN), &same(1, 1.0), claim),
        binomial("NaN", 0, 10, f64::NAN, 1.0),
        poisson("NaN", 0, 10, f64::NAN, 1.0),
        counted(&[f64::NAN, 0.5], &[500, 500]),
    ];
    for outcome in failing {
        assert_eq!(outcome.verdict(), Verdict::Fails, "{outcome:?}");
    }
    // No event in many trials bounds a probability and a mean: these intervals are within δ.
    let holding = [
        binomial("never", 0, 1_000_000, 0.0, 0.01),
        binomial("always", 1_000_000, 1_000_000, 1.0, 0.01),
        poisson("none", 0, 1_000_000, 0.0, 30.0),
        bounded_mean(
            "far from its bounds",
            &same(1_000_000, 0.5),
            0.5,
            [0.0, 1.0],
            claim,
        ),
    ];
    for outcome in holding {
        assert_eq!(outcome.verdict(), Verdict::Holds, "{outcome:?}");
    }
}

/// A sampler that always returns +z, against 12 cosine-weighted cells: 1000 samples are undecided,
/// many fail.
#[test]
fn a_stuck_sampler_is_undecided_then_fails() {
    let cells = Partition::equal(Domain::CosineHemisphere, 3, 4);
    let verdict = |n| sampler_against_partition("stuck", &cells, n, || Some(DVec3::Z)).verdict();
    for n in [0, 1, 100, 1000] {
        assert!(matches!(verdict(n), Verdict::Undecided { .. }), "{n}");
    }
    assert_eq!(verdict(100_000), Verdict::Fails);
}

fn small() -> CheckUp {
    CheckUp {
        inclinations: vec![40.0],
        samples: 5000,
        pairs: 100,
        ..CheckUp::default()
    }
}

/// Check-ups of a sampler that returns nothing, and of one whose weights are constant though f
/// cos/pdf is not: outcomes without comparisons do not hold.
#[test]
fn check_ups_without_samples_are_undecided() {
    let context = Context::new(7, 1.0).expect("a scale").named("nothing");
    let nothing = BsdfSubject {
        pdf: Box::new(|_, _| 0.0),
        ..without_samples().loss(Loss::Allowed)
    };
    let outcomes = check_up(&nothing, &small(), &context);
    let stuck = with_eval(|_, wi| wi.z.max(0.0) * 0.75 / PI);
    let stuck = check_up(&stuck, &small(), &context);
    let lobes = LobeSubject::new(|_| Vec::<Lobe>::new(), |_, _| None::<LobeSample>);
    let lobes = check_up_lobes(&lobes.loss(Loss::Allowed), &small(), &context);
    for (outcomes, name) in [
        (&outcomes, "weight = f cos/pdf"),
        (&outcomes, "chi-square of samples at 40 degrees"),
        (&stuck, "furnace at 40 degrees"),
        (&lobes, "weight = throughput/probability"),
        (&lobes, "way back"),
    ] {
        let found = outcomes.iter().find(|outcome| outcome.name == name);
        assert!(
            matches!(found.map(Outcome::verdict), Some(Verdict::Undecided { .. })),
            "{name}: {found:?}"
        );
    }
}

/// One NaN among a thousand values is not lost in their mean.
#[test]
fn nan_and_infinity_never_hold() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut values = Values::new(1.0);
        (0..1000).for_each(|i| values.push(if i == 500 { bad } else { 1.0 }));
        let claim = Claim::Equal { delta: 10.0 };
        assert_eq!(mean("t", &values, 1.0, claim).verdict(), Verdict::Fails);
        assert_eq!(
            welch("w", &values, &values, claim).verdict(),
            Verdict::Fails
        );
        assert_eq!(
            mean_known_sigma("z", &values, 1.0, 1.0, claim).verdict(),
            Verdict::Fails
        );
        assert_ne!(
            bounded_mean("b", &values, 1.0, [0.0, 2.0], claim).verdict(),
            Verdict::Holds
        );
        assert_eq!(
            Outcome::identity("e", 1, bad, 1.0, "").verdict(),
            Verdict::Fails
        );
    }
    let mut values = vec![f64::NAN; 200];
    assert_eq!(
        kolmogorov_smirnov("ks", &mut values, |x| x, 1.0).verdict(),
        Verdict::Fails
    );
}
