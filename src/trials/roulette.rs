//! Russian roulette and path length in an abstract closed furnace: a walk in which every surface emits
//! 1 and reflects the share a, so that the radiance is 1/(1 − a).

use crate::equation::{PATH_LENGTH, ROULETTE};
use crate::harness::mean::{Values, mean, welch};
use crate::harness::outcome::{Claim, Outcome};
use crate::harness::trial::{Context, Control, Trial};
use crate::rng::{Stream, uniform};
use crate::roulette;

const SAMPLES: u64 = 8_000_000;
const VARIANCE_SAMPLES: u64 = 16_000_000;
/// δ of multi-bounce means, relative.
const MEAN_DELTA: f64 = 0.005;
/// δ of variances, relative.
const VARIANCE_DELTA: f64 = 0.01;

/// The parts of roulette, so that each can be replaced.
#[derive(Clone, Copy)]
pub struct Parts {
    /// Whether the path goes on, from r and the survival probability.
    pub survives: fn(f64, f64) -> bool,
    /// What a survivor is multiplied by.
    pub weight: fn(f64) -> f64,
    /// Bounces after which the path is cut, if at all.
    pub longest: Option<u32>,
}

/// The program's parts.
pub const RIGHT: Parts = Parts {
    survives: roulette::survives,
    weight: roulette::weight,
    longest: None,
};

/// A walk that never ends is a fault of roulette; so long a right one is never met (0.95^2000 = 3e-45).
const GIVE_UP: u32 = 2_000;

/// One estimate of the furnace's radiance.
pub fn walk(rng: &mut Stream, parts: Parts, albedo: f64, survival: f64) -> f64 {
    let (mut radiance, mut throughput) = (1.0, 1.0);
    for _ in 0..parts.longest.unwrap_or(GIVE_UP) {
        if !(parts.survives)(uniform(rng), survival) {
            break;
        }
        throughput *= albedo * (parts.weight)(survival);
        radiance += throughput;
    }
    radiance
}

fn walks(context: &Context, part: &str, n: u64, parts: Parts, [a, q]: [f64; 2]) -> Values {
    let mut rng = context.rng(part);
    Values::collect(1.0 / (1.0 - a), context.n(n), || {
        walk(&mut rng, parts, a, q)
    })
}

/// The mean is 1/(1 − a).
pub fn mean_is_right(context: &Context, parts: Parts, [a, q]: [f64; 2]) -> Vec<Outcome> {
    let reference = 1.0 / (1.0 - a);
    let values = walks(context, "mean", SAMPLES, parts, [a, q]);
    let delta = MEAN_DELTA * reference;
    vec![mean(
        "furnace radiance",
        &values,
        reference,
        Claim::Exact { delta },
    )]
}

/// Var = (1 + 2a m)/(1 − a²/q) − m² with m = 1/(1 − a): from X = 1 + 1(survival) (a/q) X′. Infinite for
/// q ≤ a².
pub fn variance(a: f64, q: f64) -> f64 {
    let m = 1.0 / (1.0 - a);
    if q <= a * a {
        return f64::INFINITY;
    }
    (1.0 + 2.0 * a * m) / (1.0 - a * a / q) - m * m
}

/// The mean of (X − m)² is the closed form of the variance.
pub fn variance_is_right(context: &Context, parts: Parts, [a, q]: [f64; 2]) -> Vec<Outcome> {
    let (m, reference) = (1.0 / (1.0 - a), variance(a, q));
    let mut rng = context.rng("variance");
    let values = Values::collect(reference, context.n(VARIANCE_SAMPLES), || {
        (walk(&mut rng, parts, a, q) - m).powi(2)
    });
    let delta = VARIANCE_DELTA * reference;
    vec![mean("variance", &values, reference, Claim::Exact { delta })]
}

/// Two survival policies have the same mean.
pub fn same_mean(context: &Context, parts: [Parts; 2], a: f64, q: [f64; 2]) -> Vec<Outcome> {
    let first = walks(context, "first", SAMPLES, parts[0], [a, q[0]]);
    let second = walks(context, "second", SAMPLES, parts[1], [a, q[1]]);
    let margin = MEAN_DELTA / (1.0 - a);
    vec![welch(
        "difference of means",
        &first,
        &second,
        Claim::Approximate { margin },
    )]
}

/// Cutting paths after b bounces leaves (1 − a^(b+1))/(1 − a), for b from 1 to 12. The path is cut
/// after b + `slip` bounces: 0 is right.
pub fn truncation(context: &Context, a: f64, slip: u32) -> Vec<Outcome> {
    (1..=12)
        .map(|b: u32| {
            let reference = (1.0 - a.powi(b as i32 + 1)) / (1.0 - a);
            let parts = Parts {
                longest: Some(b + slip),
                ..RIGHT
            };
            let values = walks(
                context,
                &format!("{b} bounces"),
                SAMPLES / 2,
                parts,
                [a, 0.95],
            );
            let delta = MEAN_DELTA * reference;
            mean(
                &format!("{b} bounces"),
                &values,
                reference,
                Claim::Exact { delta },
            )
        })
        .collect()
}

const NO_WEIGHT: Parts = Parts {
    weight: |_| 1.0,
    ..RIGHT
};
const FLIPPED: Parts = Parts {
    survives: |r, q| r >= q,
    ..RIGHT
};
const OTHER_SHARE: Parts = Parts {
    weight: |q| 1.0 / (1.0 - q),
    ..RIGHT
};
const CUT: Parts = Parts {
    longest: Some(7),
    ..RIGHT
};

/// (albedo, survival). From survival = albedo on weights are bounded, lengths geometric, and all moments
/// exist; at (0.5, 0.45) seven do (the tail falls with the power ln q/ln(q/a) = 7.6), enough for the
/// mean. Survival at or below the squared albedo has infinite variance and no such trial.
const PAIRS: [[f64; 2]; 9] = [
    [0.5, 0.45],
    [0.5, 0.5],
    [0.5, 0.75],
    [0.5, 0.9],
    [0.75, 0.75],
    [0.75, 0.9],
    [0.75, 0.95],
    [0.9, 0.9],
    [0.9, 0.95],
];

fn trial(name: String, property: String, samples: u64, delta: f64, assertions: usize) -> Trial {
    Trial {
        name,
        property,
        equation: &ROULETTE,
        subject: "roulette::survives, roulette::weight",
        statistic: "t",
        samples,
        delta,
        assertions,
        run: Box::new(|_| Vec::new()),
        controls: Vec::new(),
    }
}

/// Every trial of roulette and path length.
pub fn trials() -> Vec<Trial> {
    let mut trials: Vec<Trial> = PAIRS.into_iter().flat_map(pair_trials).collect();
    trials.push(Trial {
        statistic: "Welch, equivalence",
        run: Box::new(|c| same_mean(c, [RIGHT; 2], 0.75, [0.75, 0.9])),
        controls: vec![Control::new(
            "no-weight",
            "one policy omits the weight",
            |c| same_mean(c, [RIGHT, NO_WEIGHT], 0.75, [0.75, 0.9]),
        )],
        ..trial(
            String::from("roulette/same-mean"),
            String::from("survivals 0.75 and 0.9 have the same mean at albedo 0.75"),
            SAMPLES,
            MEAN_DELTA,
            1,
        )
    });
    trials.extend([0.5, 0.75, 0.9].map(|a| Trial {
        equation: &PATH_LENGTH,
        run: Box::new(move |c| truncation(c, a, 0)),
        controls: vec![Control::new(
            "off-by-one",
            "one bounce more than said",
            move |c| truncation(c, a, 1),
        )],
        ..trial(
            format!("roulette/albedo-{a}/cut"),
            String::from("a path cut after b bounces has the relative bias −a^(b+1), b = 1 to 12"),
            SAMPLES / 2,
            MEAN_DELTA,
            12,
        )
    }));
    trials
}

fn pair_trials(pair: [f64; 2]) -> Vec<Trial> {
    let [a, q] = pair;
    let name = |what| format!("roulette/albedo-{a}/survival-{q}/{what}");
    let mut controls = vec![Control::new(
        "no-weight",
        "survivors are not divided by the survival",
        move |c| mean_is_right(c, NO_WEIGHT, pair),
    )];
    // At survival 1/2, α and 1 − α are the same and these two are right.
    if q != 0.5 {
        controls.push(Control::new(
            "flipped",
            "survives if r ≥ survival",
            move |c| mean_is_right(c, FLIPPED, pair),
        ));
    }
    if a == 0.75 {
        controls.push(Control::new(
            "cut",
            "paths end after seven bounces",
            move |c| mean_is_right(c, CUT, pair),
        ));
    }
    if q < 0.5 {
        // Above 1/2 this fault's mean is infinite, and a t test says nothing of it.
        controls.push(Control::new(
            "other-share",
            "divides by α for 1 − α",
            move |c| mean_is_right(c, OTHER_SHARE, pair),
        ));
    }
    let mut trials = vec![Trial {
        run: Box::new(move |c| mean_is_right(c, RIGHT, pair)),
        controls,
        ..trial(
            name("mean"),
            format!("the mean is {} whatever the survival", 1.0 / (1.0 - a)),
            SAMPLES,
            MEAN_DELTA,
            1,
        )
    }];
    if q >= a {
        trials.push(Trial {
            run: Box::new(move |c| variance_is_right(c, RIGHT, pair)),
            controls: vec![Control::new(
                "no-weight",
                "survivors are not divided",
                move |c| variance_is_right(c, NO_WEIGHT, pair),
            )],
            ..trial(
                name("variance"),
                format!("the variance is {:.6}", variance(a, q)),
                VARIANCE_SAMPLES,
                VARIANCE_DELTA,
                1,
            )
        });
    }
    trials
}
