//! Tests of the counting of graded controls: rejected as often as stated, or not.

use experiments::experiments::power::graded::{ControlCount, LeftOut, count_rejections};
use experiments::experiments::suite_seeds::{Graded, Measure};
use experiments::run::Judgement;
use whitefurnace::harness::outcome::ALPHA;

const SEEDS: usize = 200;

/// Returns a measure whose graded control has this p-value, and these levels with their powers.
fn measure(p: f64, levels: [[f64; 2]; 2]) -> Measure {
    Measure {
        name: "trial: outcome".to_owned(),
        statistic: "t".to_owned(),
        verdict: Judgement::Undecided,
        random: true,
        approximate: false,
        p: 0.5,
        n: 1000,
        valid_from: 2,
        bound: false,
        graded: vec![Graded {
            up: true,
            p,
            levels,
        }],
    }
}

const LEVELS: [[f64; 2]; 2] = [[0.03, 0.5], [0.4, 0.9]];

/// Returns measures of seeds that reject at both levels, at the second only, or not at all.
fn seeds([both, second]: [usize; 2]) -> Vec<Measure> {
    let p = |i| match i {
        i if i < both => 0.02,
        i if i < both + second => 0.2,
        _ => 0.6,
    };
    (0..SEEDS).map(|i| measure(p(i), LEVELS)).collect()
}

fn count(found: &[Measure]) -> (Vec<ControlCount>, LeftOut) {
    let mut left_out = LeftOut::new();
    (count_rejections(found, &mut left_out), left_out)
}

/// Returns the p-values of the counts, at powers 0.5 and 0.9.
fn p(found: &[Measure]) -> Vec<f64> {
    count(found).0.iter().map(ControlCount::p).collect()
}

#[test]
fn counts_are_held_to_the_stated_power() {
    let right = seeds([100, 80]);
    let (counted, left_out) = count(&right);
    let rejected: Vec<u64> = counted.iter().map(|c| c.rejected).collect();
    assert_eq!((rejected, left_out.len()), (vec![100, 180], 0));
    assert!(p(&right).iter().all(|&p| p > 0.9));
    // Less power than stated, and more.
    for wrong in [[60, 90], [140, 58]] {
        let p = p(&seeds(wrong));
        assert!(p[0] < 1e-6, "{wrong:?} {p:?}");
    }
    assert!(p(&seeds([100, 50]))[1] < 1e-6);
    // A lower bound may be exceeded, but must be reached.
    let bounds = |counts| -> Vec<Measure> {
        seeds(counts)
            .into_iter()
            .map(|measure| Measure {
                bound: true,
                ..measure
            })
            .collect()
    };
    assert!(p(&bounds([180, 20])).iter().all(|&p| p > 0.9));
    assert!(p(&bounds([60, 90]))[0] < 1e-6);
}

#[test]
fn what_is_not_judged_is_named() {
    let why = |change: &dyn Fn(Measure) -> Measure| {
        let found: Vec<Measure> = seeds([100, 80]).into_iter().map(change).collect();
        let (counted, left_out) = count(&found);
        assert!(counted.is_empty());
        let reasons: Vec<&str> = left_out.keys().copied().collect();
        assert_eq!(left_out[reasons[0]], ["trial: outcome"]);
        reasons[0]
    };
    let graded = |levels| {
        move |measure: Measure| Measure {
            graded: vec![Graded {
                up: true,
                p: 0.5,
                levels,
            }],
            ..measure
        }
    };
    let none = |approximate| {
        move |measure| Measure {
            approximate,
            graded: Vec::new(),
            ..measure
        }
    };
    assert!(why(&none(true)).contains("margin"));
    assert!(why(&none(false)).contains("without"));
    assert!(why(&graded([[0.95, 0.5], [1.0, 1.0]])).contains("too small"));
    let skewed = |measure| Measure {
        valid_from: 1_000_000,
        ..measure
    };
    assert!(why(&skewed).contains("skewed"));
}

/// If the effect is detected at the suite's own level, that level is used once, with the power
/// stated there.
#[test]
fn no_level_is_finer_than_the_suites_own() {
    let found: Vec<Measure> = (0..SEEDS)
        .map(|_| measure(0.0, [[ALPHA, 0.97], [ALPHA, 0.97]]))
        .collect();
    let (counted, _) = count(&found);
    assert_eq!(counted.len(), 1);
    assert_eq!((counted[0].level, counted[0].power), (ALPHA, 0.97));
    assert!(counted[0].p() > 1e-3);
}
