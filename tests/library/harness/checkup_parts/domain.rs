//! Tests of the arguments with which the check-up calls a subject: corners of the domain, and
//! random ones.

use super::*;

#[test]
fn directions_favour_no_axis_and_differ() {
    // No pairs: all samples are from the directions.
    let asked = asked(
        false,
        &CheckUp {
            inclinations: vec![30.0; 3],
            samples: 100,
            pairs: 0,
            ..small()
        },
    );
    let mut directions = asked.sampled;
    directions.dedup();
    assert_eq!(directions.len(), 3);
    for (i, wo) in directions.iter().enumerate() {
        assert!(!directions[..i].contains(wo));
        assert_relative_eq!(wo.z, 0.75_f64.sqrt(), max_relative = 1e-12);
        assert!(wo.x.abs().min(wo.y.abs()) > 0.05, "{wo}");
    }
}

/// Enough pairs to know shares of one eighth to 0.05.
const PAIRS: usize = 7000;

/// Arguments that a subject was called with: pairs of directions, directions to sample from, and
/// random numbers.
#[derive(Clone, Default)]
struct Asked {
    pairs: Vec<[DVec3; 2]>,
    sampled: Vec<DVec3>,
    numbers: Vec<f64>,
}

fn asked(transmits: bool, size: &CheckUp) -> Asked {
    let asked = Arc::new(Mutex::new(Asked::default()));
    let [first, second] = [asked.clone(), asked.clone()];
    let eval = move |wo, wi| {
        first.lock().expect("one thread").pairs.push([wo, wi]);
        1.0
    };
    let sample = move |wo, random| {
        let mut asked = second.lock().expect("one thread");
        asked.sampled.push(wo);
        asked.numbers.extend::<[f64; 3]>(random);
        None
    };
    let subject = BsdfSubject::new(eval, sample, |_, _| 1.0)
        .transmits(transmits)
        .reciprocal(false);
    // A stated precision is not searched for.
    check_up(
        &subject,
        &CheckUp {
            roundoff: Some(DOUBLE),
            ..size.clone()
        },
        &at_scale_1("fuzzed"),
    );
    asked.lock().expect("one thread").clone()
}

fn fuzzed(transmits: bool) -> Asked {
    asked(
        transmits,
        &CheckUp {
            inclinations: Vec::new(),
            pairs: PAIRS as u64,
            ..small()
        },
    )
}

#[test]
fn corners_of_the_domain_are_tried() {
    let close = |found: usize, n: usize, share: f64| assert_share(found, n, share, 0.05);
    let Asked {
        pairs: directions,
        numbers,
        ..
    } = fuzzed(false);
    let n = directions.len();
    assert_eq!((n, numbers.len()), (PAIRS, 2 * 3 * PAIRS));
    for side in 0..2 {
        let inclination = |pair: &[DVec3; 2]| pair[side].truncate().length().atan2(pair[side].z);
        // Four corners of one eighth each; the rest is uniform over the quarter circle.
        for (low, high, expected) in [
            (0.0, 0.0, 0.125),
            (0.5e-9, 2e-9, 0.125),
            (FRAC_PI_4 - 1e-9, FRAC_PI_4 + 1e-9, 0.125),
            (FRAC_PI_2 - 2e-6, FRAC_PI_2, 0.125),
            (0.2 * FRAC_PI_2, 0.4 * FRAC_PI_2, 0.1),
            (0.6 * FRAC_PI_2, 0.8 * FRAC_PI_2, 0.1),
            (0.0, FRAC_PI_2, 1.0),
        ] {
            let within = |pair: &&[DVec3; 2]| (low..=high).contains(&inclination(pair));
            close(directions.iter().filter(within).count(), n, expected);
        }
        // Half of the azimuths are multiples of 45 degrees, all eight of them.
        let turns = |pair: &[DVec3; 2]| 8.0 * pair[side].y.atan2(pair[side].x) / TAU;
        let tilted: Vec<f64> = directions
            .iter()
            .filter(|pair| inclination(pair) > 0.0)
            .map(turns)
            .collect();
        let straight = |turns: &&f64| (**turns - turns.round()).abs() < 1e-9;
        // The first of the uniform picks 0, 2, 4, 6 has no azimuth.
        close(
            tilted.iter().filter(straight).count(),
            tilted.len(),
            3.0 / 7.0,
        );
        for eighth in -3..=4 {
            let there = |turns: &&f64| {
                (turns.rem_euclid(8.0) - f64::from(eighth).rem_euclid(8.0)).abs() < 0.5
            };
            close(tilted.iter().filter(there).count(), tilted.len(), 0.125);
        }
    }
    // A tenth of the fuzzed half.
    for corner in [0.0, 1.0 - f64::EPSILON / 2.0] {
        assert_share(
            numbers.iter().filter(|&&u| u == corner).count(),
            numbers.len() / 2,
            0.1,
            0.02,
        );
    }
    assert!(numbers.iter().all(|u| (0.0..1.0).contains(u)));
    // Both directions are above the surface; if light may pass, each is below it half of the time.
    assert!(directions.iter().flatten().all(|w| w.z >= 0.0));
    let directions = fuzzed(true).pairs;
    for side in 0..2 {
        close(
            directions.iter().filter(|pair| pair[side].z < 0.0).count(),
            n,
            0.5,
        );
    }
    let across = |pair: &&[DVec3; 2]| pair[0].z * pair[1].z < 0.0;
    close(directions.iter().filter(across).count(), n, 0.5);
}
