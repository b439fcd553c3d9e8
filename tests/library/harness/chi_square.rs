//! Chi-square, binomial and Poisson tests of counts against their definitions on small sets.

use std::cell::Cell;

use whitefurnace::harness::chi_square::pool;
use whitefurnace::harness::tails::binomial_interval;

use super::*;

/// Returns three cells that hold 0.5, 0.3 and 0.2 of the probability that is not lost.
fn partition(loss: f64, error: f64) -> Partition {
    let mut partition = cells(&[0.5, 0.3, 0.2].map(|m| m * (1.0 - loss)));
    (partition.loss, partition.error) = (loss, error);
    partition
}

/// Returns the counts of ten thousand samples in the three cells, and others.
fn counts(lost: u64, forbidden: u64) -> Counts {
    Counts {
        n: 10_000 + lost + forbidden,
        observed: vec![5100, 2950, 1950],
        lost,
        forbidden,
        example: (forbidden > 0).then_some(DVec3::X),
    }
}

/// Returns the p-value of the three cells, for 100²/5000 + 50²/3000 + 50²/2000 with two degrees of
/// freedom.
fn cells_p() -> f64 {
    chi_square_sf(2.0 + 2500.0 / 3000.0 + 1.25, 2.0)
}

#[test]
fn every_sample_is_counted_once() {
    let cells = Partition::equal(Domain::Square, 2, 2);
    let at = |x, y| Some(DVec3::new(x, y, 0.0));
    let samples = [
        at(0.1, 0.1),
        None,
        at(0.1, 0.9),
        at(0.9, 0.1),
        at(0.9, 0.2),
        at(2.0, 0.0),
        at(0.5, 0.5),
        None,
        at(0.2, 0.2),
    ];
    let mut next = samples.into_iter();
    let found = count(
        &cells,
        9,
        || next.next().expect("no more than asked for"),
        |p| p.x != 0.5,
    );
    assert_eq!((found.n, found.lost, found.forbidden), (9, 2, 2));
    assert_eq!(found.observed, [2, 1, 2, 0]);
    assert_eq!(found.example, Some(DVec3::new(2.0, 0.0, 0.0)));
}

#[test]
fn cells_have_simultaneous_intervals() {
    let found = chi_square("cells", &partition(0.0, 0.0), &counts(0, 0), 0.5);
    assert_eq!((found.name.as_str(), found.n), ("cells", 10_000));
    assert_eq!(found.dof, Some(2.0));
    assert_relative_eq!(found.estimate, -0.025, max_relative = 1e-12);
    assert_relative_eq!(found.p, cells_p(), max_relative = 1e-12);
    let z = normal_upper(ALPHA / 6.0);
    let ends = [(0.5, 0.02), (0.3, -1.0 / 60.0), (0.2, -0.025)].map(|(mass, deviation)| {
        let half = z * f64::sqrt((1.0 - mass) / (mass * 10_000.0));
        [deviation - half, deviation + half]
    });
    let low = ends.iter().fold(0.0_f64, |low, end| low.min(end[0]));
    let high = ends.iter().fold(0.0_f64, |high, end| high.max(end[1]));
    assert_relative_eq!(found.interval[..], [low, high][..], max_relative = 1e-9);
    for (cell, (place, mass, observed)) in found.cells.iter().zip([
        ("0", 5000_f64, 5100.0),
        ("1", 3000.0, 2950.0),
        ("2", 2000.0, 1950.0),
    ]) {
        assert_cell(
            cell,
            place,
            [mass, observed, (observed - mass) / mass.sqrt()],
        );
    }
    assert_eq!(found.cells.len(), 3);
    assert_eq!(
        found.worst,
        "cell at 0: 5100 samples, 5000.0 expected, +1.4 sigmas"
    );
    let Sensitivity::Cells {
        dof,
        n,
        min_probability: least,
        tests,
    } = found.sensitivity
    else {
        panic!("{:?}", found.sensitivity);
    };
    assert_eq!((dof, n, tests), (2.0, 10_000.0, 1));
    assert_relative_eq!(least, 0.2, max_relative = 1e-12);
    // Half of the level is left for the cells if lost samples are tested, too.
    let halved = chi_square("cells", &partition(0.1, 0.0), &counts(1100, 0), 0.5);
    let expected = Sensitivity::Cells {
        dof,
        n,
        min_probability: least,
        tests: 2,
    };
    assert_relative_eq!(
        halved.sensitivity.miss(0.1),
        expected.miss(0.1),
        max_relative = 1e-6
    );
    // No samples where none are expected are right; a single cell has no shape to be wrong.
    let all = Counts {
        n: 5000,
        observed: vec![5000, 0],
        ..Counts::default()
    };
    let found = chi_square("single", &cells(&[1.0, 0.0]), &all, 0.5);
    assert_eq!(
        (
            found.p,
            matches!(found.verdict(), Verdict::Undecided { .. })
        ),
        (1.0, true)
    );
    assert!(found.cells.iter().all(|cell| cell.sigmas == 0.0));
    // However the expected count of the cell is rounded.
    for parts in 2..200 {
        let mass = 1.0 / f64::from(parts);
        let all = Counts {
            n: 5001,
            observed: vec![5001],
            ..Counts::default()
        };
        assert_eq!(
            chi_square("single", &cells(&[mass]), &all, 0.5).p,
            1.0,
            "{parts}"
        );
    }
}

#[test]
fn lost_samples_are_tested_beside_the_cells() {
    let p = |partition: &Partition, lost| chi_square("p", partition, &counts(lost, 0), 0.5).p;
    // Half of the level each if both are random; the loss is known within its error.
    for (loss, error, lost) in [
        (0.1_f64, 0.0_f64, 1300_u64),
        (0.1, 0.0, 1120),
        (0.1, 0.0, 950),
        (0.1, 0.01, 1400),
        (0.1, 0.01, 850),
        (0.0, 1e-6, 0),
        (0.0, 0.01, 140),
    ] {
        let n = 10_000 + lost;
        let least = (loss - error).max(0.0);
        let [above, below] = [
            binomial_sf(lost, n, loss + error),
            binomial_cdf(lost, n, least),
        ];
        let lost_p = (2.0 * above.min(below)).min(1.0);
        let expected = (2.0 * cells_p().min(lost_p)).min(1.0);
        assert_relative_eq!(
            p(&partition(loss, error), lost),
            expected,
            max_relative = 1e-9
        );
    }
    // If no loss is possible, having none costs nothing.
    assert_relative_eq!(p(&partition(0.0, 0.0), 0), cells_p(), max_relative = 1e-12);
    assert_eq!(p(&partition(0.0, 0.0), 1), 0.0);
}

#[test]
fn the_worst_is_named() {
    for (loss, lost, forbidden, worst) in [
        (0.0, 5, 0, "5 samples lost, 0.0 expected"),
        (0.1, 0, 0, "0 samples lost, 1000.0 expected"),
        (
            0.0,
            0,
            7,
            "7 of 10007 samples where the pdf is zero or not finite, the first at [1, 0, 0]",
        ),
    ] {
        let found = chi_square(
            "worst",
            &partition(loss, 0.0),
            &counts(lost, forbidden),
            0.5,
        );
        assert_eq!((found.worst.as_str(), found.p), (worst, 0.0));
    }
}

#[test]
fn thin_cells_are_pooled_smallest_first() {
    // 900 + 900 exceeds the third, which is then the smallest and joins them.
    assert_eq!(
        pool(&[900.0, 3000.0, 900.0, 900.0], &[1, 2, 4, 8]),
        [[3000.0, 2.0], [2700.0, 13.0]]
    );
    // Just enough suffices, and a last cell stays, however small.
    assert_eq!(pool(&[1000.0, 1000.0], &[1, 2]).len(), 2);
    assert_eq!(pool(&[5.0], &[3]), [[5.0, 3.0]]);
    assert_eq!(pool(&[], &[]), [[0.0; 2]; 0]);
    // With fewer than 32 cells each must expect at least 1000; from 32 cells on 300 suffice.
    assert_eq!(
        pool(&[5000.0, 999.0, 600.0], &[1, 2, 3]),
        [[5000.0, 1.0], [1599.0, 5.0]]
    );
    assert_eq!(pool(&[5000.0, 100.0], &[7, 8]), [[5100.0, 15.0]]);
    for (each, cells, left) in [(300.0, 32, 32), (299.0, 32, 8), (999.0, 31, 15)] {
        assert_eq!(pool(&vec![each; cells], &vec![0; cells]).len(), left);
    }
}

#[test]
fn a_share_has_its_exact_interval() {
    let found = binomial("share", 3, 10, 0.2, 0.5);
    assert_eq!(
        (found.name.as_str(), found.n, found.value),
        ("share", 10, 3.0)
    );
    assert_eq!(
        (found.estimate, found.reference, found.claim),
        (0.3, 0.2, Claim::Equal { delta: 0.5 })
    );
    assert_eq!(found.p, binomial_two_sided(3, 10, 0.2));
    assert_eq!(found.interval, binomial_interval(3, 10, ALPHA / 2.0));
    // A probability of −0.3 is impossible, and not tried.
    assert!(matches!(&found.graded[..], [graded] if graded.effect == 0.5));
    // (3 − 2)/√(10 · 0.2 · 0.8).
    assert_eq!(found.worst, "3 of 10, 2.0 expected, +0.8 sigmas");
}

#[test]
fn rare_events_follow_the_poisson_law() {
    let found = poisson("rare", 30, 1000, 20.0, 5.0);
    assert_eq!(
        (found.name.as_str(), found.n, found.value),
        ("rare", 1000, 30.0)
    );
    assert_eq!(
        (found.estimate, found.reference, found.claim),
        (30.0, 20.0, Claim::Equal { delta: 5.0 })
    );
    assert_eq!(found.p, 2.0 * poisson_sf(30, 20.0));
    assert_eq!(found.interval, poisson_interval(30, ALPHA / 2.0));
    assert_eq!(found.sensitivity, Sensitivity::Poisson { mean: 20.0 });
    assert_eq!(found.worst, "30 among 1000 values, 2.0e1 expected");
    assert_eq!(found.cells.len(), 1);
    assert_cell(
        &found.cells[0],
        &found.cells[0].place,
        [20.0, 30.0, 5_f64.sqrt()],
    );
    assert_eq!(
        poisson("few", 11, 1000, 20.0, 5.0).p,
        2.0 * poisson_cdf(11, 20.0)
    );
    assert_eq!(poisson("even", 20, 1000, 20.0, 5.0).p, 1.0);
}

#[test]
fn a_sampler_is_compared_with_its_cells() {
    let cells = Partition::equal(Domain::Square, 2, 2);
    let i = Cell::new(0);
    let found = sampler_against_partition("corners", &cells, 800_000, || {
        i.set(i.get() + 1);
        let [x, y] = [i.get() & 1, i.get() >> 1 & 1].map(|bit| 0.25 + 0.5 * f64::from(bit));
        Some(DVec3::new(x, y, 0.0))
    });
    assert_eq!((found.n, found.p, i.get()), (800_000, 1.0, 800_000));
    assert_eq!(found.claim, Claim::Equal { delta: 0.02 });
    assert_eq!(found.verdict(), Verdict::Holds);
}
