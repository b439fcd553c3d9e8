//! Tests of equation (16): running moments, in floating point and exact.

use whitefurnace::math::moments::in_units;

use crate::prelude::*;

fn values() -> impl Strategy<Value = Vec<f64>> {
    let offset = prop_oneof![Just(0.0), -1e3..1e3, Just(1e6)];
    (offset, prop::collection::vec(-1.0..1.0, 2..200))
        .prop_map(|(offset, values): (f64, Vec<f64>)| values.iter().map(|x| x + offset).collect())
}

/// Computes mean and unbiased variance in two passes.
fn two_pass(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, squares / (n - 1.0))
}

/// Bounds on the errors of mean and variance: sums of n terms lose at most n U of the largest; a
/// running variance loses n U κ of itself, κ² = 1 + mean²/variance (Chan, Golub and LeVeque 1983),
/// to first order. A factor of 2 for the two methods, another 2 for the rest.
fn error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let (mean, variance) = two_pass(values);
    let largest = values.iter().fold(0f64, |m, x| m.max(x.abs()));
    let kappa = (1.0 + mean * mean / variance).sqrt();
    (
        4.0 * n * UNIT_ROUNDOFF * largest,
        4.0 * n * UNIT_ROUNDOFF * kappa * variance,
    )
}

fn exact(values: &[f64]) -> ExactMoments {
    let mut moments = ExactMoments::default();
    for &value in values {
        moments.push(value).expect("a legal value");
    }
    moments
}

#[test]
fn moments_meet_two_passes() {
    property("two passes", 500, &values(), |values| {
        let n = values.len() as u32;
        let (running, exact) = (values.iter().copied().collect::<Moments>(), exact(&values));
        let ((mean, variance), (e_mean, e_variance)) = (two_pass(&values), error(&values));
        assert_eq!(running.count(), u64::from(n));
        assert_abs_diff_eq!(running.mean(), mean, epsilon = e_mean);
        assert_abs_diff_eq!(running.variance(), variance, epsilon = e_variance);
        assert_eq!(
            running.standard_error(),
            (running.variance() / f64::from(n)).sqrt()
        );
        // Every value moves by at most half a unit.
        assert_abs_diff_eq!(
            exact.mean(n),
            mean,
            epsilon = e_mean + 0.5 * FIXED_POINT_UNIT
        );
        let moved =
            2.0 * (2.0 * variance).sqrt() * FIXED_POINT_UNIT + FIXED_POINT_UNIT * FIXED_POINT_UNIT;
        assert_abs_diff_eq!(exact.variance(n), variance, epsilon = e_variance + moved);
        assert_eq!(
            exact.standard_error(n),
            (exact.variance(n) / f64::from(n)).sqrt()
        );
    });
}

#[test]
fn merging_is_associative_up_to_rounding() {
    property(
        "merging",
        500,
        &(values(), 0.0..1.0, 0.0..1.0),
        |(values, s, t): (Vec<f64>, f64, f64)| {
            let cut = |share: f64| (share * values.len() as f64) as usize;
            let (first, second) = (cut(s.min(t)), cut(s.max(t)));
            let part =
                |from: usize, to: usize| values[from..to].iter().copied().collect::<Moments>();
            let (a, b, c) = (
                part(0, first),
                part(first, second),
                part(second, values.len()),
            );
            let (e_mean, e_variance) = error(&values);
            let all = part(0, values.len());
            for merged in [
                a.merge(b).merge(c),
                a.merge(b.merge(c)),
                c.merge(a).merge(b),
            ] {
                assert_eq!(merged.count(), all.count());
                assert_abs_diff_eq!(merged.mean(), all.mean(), epsilon = e_mean);
                assert_abs_diff_eq!(merged.variance(), all.variance(), epsilon = e_variance);
            }
        },
    );
}

#[test]
fn few_values() {
    let none = Moments::default();
    let [one, two] =
        [&[3.0][..], &[3.0, 5.0]].map(|values| values.iter().copied().collect::<Moments>());
    let [few, more] = [&[3.0][..], &[3.0, 5.0]].map(exact);
    let infinite = f64::INFINITY;
    assert_eq!(
        (none.count(), none.mean(), none.variance()),
        (0, 0.0, infinite)
    );
    assert_eq!(
        (one.mean(), one.variance(), one.standard_error()),
        (3.0, infinite, infinite)
    );
    assert_eq!(
        (two.mean(), two.variance(), two.standard_error()),
        (4.0, 2.0, 1.0)
    );
    assert_eq!(
        (
            ExactMoments::default().mean(0),
            ExactMoments::default().variance(0)
        ),
        (0.0, infinite)
    );
    assert_eq!(
        (few.variance(1), few.standard_error(1)),
        (infinite, infinite)
    );
    assert_eq!(
        (more.mean(2), more.variance(2), more.standard_error(2)),
        (4.0, 2.0, 1.0)
    );
    assert_eq!(
        [none.merge(none), none.merge(two), two.merge(none)],
        [none, two, two]
    );
    assert_eq!(one.merge([5.0].into_iter().collect()), two);
}

#[test]
fn units_are_the_nearest_multiples() {
    assert_eq!((FIXED_POINT_UNIT, LARGEST), (2f64.powi(-32), 2f64.powi(24)));
    property("units", 2000, &(-(1i64 << 56)..=(1i64 << 56)), |units| {
        // Within the precision of a double.
        assert_eq!(
            in_units(units as f64 * FIXED_POINT_UNIT),
            units as f64 as i64
        );
    });
    property("large units", 500, &((1i64 << 52)..(1i64 << 53)), |units| {
        assert_eq!(
            in_units(units as f64 * FIXED_POINT_UNIT),
            units,
            "every integer of 53 bits"
        );
        assert_eq!(in_units(-units as f64 * FIXED_POINT_UNIT), -units);
    });
    for (units, expected) in [(0.5, 1), (-0.5, -1), (1.5, 2), (0.25, 0), (-1.75, -2)] {
        assert_eq!(in_units(units * FIXED_POINT_UNIT), expected, "{units}");
    }
    assert_eq!(in_units(0.5f64.next_down() * FIXED_POINT_UNIT), 0);
    assert_eq!(in_units(-0.5f64.next_down() * FIXED_POINT_UNIT), 0);
}

#[test]
fn exact_moments_merge_in_any_order() {
    let strategy = (
        values(),
        prop::collection::vec(any::<prop::sample::Index>(), 3),
    );
    property("any order", 500, &strategy, |(mut values, cuts)| {
        let all = exact(&values);
        let (left, right) = values.split_at(cuts[0].index(values.len()));
        for (a, b) in [(left, right), (right, left)] {
            let mut merged = exact(a);
            merged.merge(&exact(b)).expect("room for more");
            assert_eq!(merged, all);
        }
        let turn = cuts[1].index(values.len());
        values.rotate_left(turn);
        assert_eq!(exact(&values), all);
        values.reverse();
        assert_eq!(exact(&values), all);
    });
}

#[test]
fn constants_have_no_variance() {
    property(
        "constants",
        500,
        &(-LARGEST..LARGEST, 2..500u32),
        |(value, n)| {
            let moments = exact(&vec![value; n as usize]);
            assert_eq!(moments.variance(n), 0.0);
            assert_abs_diff_eq!(
                moments.mean(n),
                value,
                epsilon = 0.5 * FIXED_POINT_UNIT + 2.0 * UNIT_ROUNDOFF * value.abs()
            );
        },
    );
}

#[test]
fn large_offsets_do_not_cancel() {
    // Mean 2²³ + 1/2, deviations 1/2: Σ(x − m)² = n/4.
    let n = 1000;
    let values: Vec<f64> = (0..n).map(|i| LARGEST / 2.0 + f64::from(i % 2)).collect();
    let moments = exact(&values);
    assert_eq!(moments.mean(n), LARGEST / 2.0 + 0.5);
    assert_relative_eq!(
        moments.variance(n),
        f64::from(n) / 4.0 / f64::from(n - 1),
        max_relative = 4.0 * UNIT_ROUNDOFF
    );
    // The smallest difference that the unit resolves, on top of the largest value.
    let two = exact(&[LARGEST, LARGEST - FIXED_POINT_UNIT * 8.0]);
    assert_eq!(two.variance(2), 32.0 * FIXED_POINT_UNIT * FIXED_POINT_UNIT);
    // Means between two integers: Σx² − (Σx)²/n = 1 − 1/2, 1 − 1/3, 6 − 16/3 units².
    for (units, squares) in [
        (vec![0.0, 1.0], 0.5),
        (vec![0.0, -1.0, 0.0], 2.0 / 3.0),
        (vec![1.0, 1.0, 2.0], 2.0 / 3.0),
    ] {
        let n = units.len() as u32;
        let scaled: Vec<f64> = units.iter().map(|x| x * FIXED_POINT_UNIT).collect();
        let found = exact(&scaled).variance(n) / (FIXED_POINT_UNIT * FIXED_POINT_UNIT);
        assert_relative_eq!(
            found,
            squares / f64::from(n - 1),
            max_relative = 4.0 * UNIT_ROUNDOFF
        );
    }
}

#[test]
fn values_that_no_film_holds_are_refused() {
    let above = LARGEST.next_up();
    for value in [
        f64::NAN,
        f64::INFINITY,
        -f64::INFINITY,
        above,
        -above,
        f64::MAX,
    ] {
        let mut moments = ExactMoments::default();
        assert!(
            matches!(moments.push(value), Err(Error::Radiance { .. })),
            "{value}"
        );
        assert_eq!(moments, ExactMoments::default());
    }
    assert!(ExactMoments::default().push(LARGEST).is_ok());
    assert!(ExactMoments::default().push(-LARGEST).is_ok());
    assert_refused(ExactMoments::default().push(f64::NAN), "NaN");
}

#[test]
fn moments_can_be_restored_from_what_they_say() {
    let mut rng = rng("restored moments");
    let moments: Moments = (0..50).map(|_| uniform(&mut rng)).collect();
    let restored = Moments::of(moments.count(), moments.mean(), moments.variance());
    assert_eq!(restored.count(), moments.count());
    assert_eq!(restored.mean(), moments.mean());
    assert_relative_eq!(
        restored.variance(),
        moments.variance(),
        max_relative = 1e-14
    );
    // 1 and 4: two values are enough for a variance, one is not.
    assert_eq!(Moments::of(2, 2.5, 4.5), [1.0, 4.0].into_iter().collect());
    assert_eq!(
        Moments::of(1, 3.0, f64::INFINITY),
        std::iter::once(3.0).collect()
    );
    // Merging more values into it gives the same variance as with the original.
    let more: Moments = (0..50).map(|_| uniform(&mut rng)).collect();
    let [a, b] = [moments, restored].map(|m| m.merge(more).variance());
    assert_relative_eq!(a, b, max_relative = 1e-14);
    assert_eq!(
        Moments::of(1, 3.0, f64::INFINITY).merge(restored).count(),
        51
    );
    assert!(
        Moments::of(1, 3.0, f64::INFINITY)
            .merge(restored)
            .variance()
            .is_finite()
    );
}
