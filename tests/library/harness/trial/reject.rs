//! Tests of the parts of a sample on which faults are rejected.

use std::sync::atomic::{AtomicU64, Ordering};

use super::*;

/// Size of a whole sample.
const WHOLE: u64 = 1_000_000;

/// Returns a function whose outcome is `effect` standard errors off where the sample is whole.
fn off_by(effect: f64) -> impl Fn(&Context) -> Vec<Outcome> + Send + Sync + 'static {
    move |context| {
        let n = context.n(WHOLE);
        let sigmas = effect * context.scale.sqrt();
        vec![Outcome {
            n,
            p: 2.0 * normal_sf(sigmas),
            sensitivity: normal(1.0, n as f64),
            ..outcome(sigmas, normal_upper(0.5 * ALPHA), Claim::Test)
        }]
    }
}

/// Returns the shares of the sample on which a fault runs.
fn shares(outcomes: Run) -> Vec<f64> {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let log = Arc::clone(&seen);
    let run: Run = Box::new(move |context: &Context| {
        log.lock().expect("not poisoned").push(context.scale);
        outcomes(context)
    });
    let share = reject(&run, &[], &context(1.0)).share;
    let seen = seen.lock().expect("not poisoned").clone();
    assert_eq!(seen.last(), Some(&share));
    seen
}

/// A fault runs on the smallest part of the sample first, then on one that promises a clear
/// rejection, and on the whole if none does.
#[test]
fn a_fault_runs_on_no_more_of_the_sample_than_it_takes() {
    let first = 1.0 / 64.0;
    let identity = |_: &Context| vec![Outcome::identity("identity", 1, 2.0, 1.0, "")];
    assert_eq!(shares(Box::new(identity)), [first]);
    assert_eq!(shares(Box::new(off_by(70.0))), [first]);
    for effect in [0.0, 7.0] {
        assert_eq!(shares(Box::new(off_by(effect))), [first, 1.0]);
    }
    for (effect, range) in [(40.0, 0.04..0.1), (26.0, 0.1..0.3), (18.0, 0.5..0.9)] {
        let [smallest, enough] = shares(Box::new(off_by(effect)))[..] else {
            panic!("{effect}");
        };
        assert_eq!(smallest, first);
        assert!(range.contains(&enough), "{effect}: {enough}");
    }
}

/// After a part that did not keep its promise a fault runs on one twice as large or more.
#[test]
fn a_fault_runs_on_few_parts_where_its_effect_seems_larger_in_small_ones() {
    let shrinking = |context: &Context| {
        let seeming = 13.0 / context.scale.powf(0.35);
        off_by(seeming)(context)
    };
    let shares = shares(Box::new(shrinking));
    let [first, promised, rest @ ..] = &shares[..] else {
        panic!("{shares:?}");
    };
    assert!(
        *first == 1.0 / 64.0 && *promised < 2.1 * first,
        "{shares:?}"
    );
    assert!(rest.len() >= 2, "{shares:?}");
    for steps in shares[1..].windows(2) {
        assert!(steps[1] > 1.9 * steps[0] || steps[1] == 1.0, "{shares:?}");
    }
}

/// A part that rejects clearly needs fewer standard errors than a whole sample.
#[test]
fn the_guard_knows_the_part_that_rejected_a_control() {
    let planned = Context::new(DEFAULT_SEED, 1.0).expect("a valid scale");
    let checked = |effect| {
        let control = NegativeControl::new("wrong", "it is not so", off_by(effect));
        check_control(&trial(Vec::new(), Vec::new()), &control, &planned)
    };
    let rows = checked(26.0).expect("clear in a part");
    let sigmas = normal_upper(0.5 * rows[0].outcome.p);
    assert!((9.0..12.0).contains(&sigmas), "{sigmas}");
    let why = checked(13.0).expect_err("rejected, but not clearly by the whole");
    assert!(why.contains("too small for the error budget"), "{why}");
}

/// A fault's trial is told which outcomes must reject it, on every part of the sample.
#[test]
fn a_fault_is_asked_for_the_outcomes_that_must_reject_it() {
    let asked = Arc::new(Mutex::new(Vec::new()));
    let log = Arc::clone(&asked);
    let run: Run = Box::new(move |context: &Context| {
        log.lock()
            .expect("not poisoned")
            .push(context.asked.clone());
        off_by(0.0)(context)
    });
    reject(&run, &["outcome"], &context(1.0));
    let asked = asked.lock().expect("not poisoned");
    assert!(asked.len() > 1 && asked.iter().all(|names| names == &["outcome"]));
    let context = Context {
        asked: vec!["furnace at 40 degrees", "reciprocity"],
        ..context(1.0)
    };
    assert!(context.asks_for(" at 40 degrees") && !context.asks_for(" at 0 degrees"));
}

/// Values that the parts of the sample have in common are made once for a fault, but in each run on
/// its own; values of the same name are told apart by their order.
#[test]
fn what_parts_have_in_common_is_made_once() {
    let made = Arc::new(AtomicU64::new(0));
    let counter = Arc::clone(&made);
    let run: Run = Box::new(move |context: &Context| {
        let values = [10, 20].map(|value| {
            *context.once("value", || {
                counter.fetch_add(1, Ordering::Relaxed);
                value
            })
        });
        assert_eq!(values, [10, 20]);
        assert_eq!(*context.named("other").once("value", || 30), 30);
        off_by(0.0)(context)
    });
    let context = context(1.0);
    let times = || made.swap(0, Ordering::Relaxed);
    let rejected = reject(&run, &["outcome"], &context);
    assert_eq!((rejected.share, times()), (1.0, 2));
    reject(&run, &["outcome"], &context);
    assert_eq!(times(), 2);
    run(&context);
    run(&context);
    assert_eq!(times(), 4);
    // A fault within a run shares nothing with it, nor with one in an earlier run.
    let runs = Arc::new(AtomicU64::new(0));
    let counter = Arc::clone(&runs);
    let outer: Run = Box::new(move |context: &Context| {
        counter.fetch_add(1, Ordering::Relaxed);
        reject(&run, &["outcome"], context).outcomes
    });
    reject(&outer, &["outcome"], &context);
    let runs = runs.load(Ordering::Relaxed);
    assert!(runs > 1);
    assert_eq!(times(), 2 * runs);
}
