//! Tests each part of the BSDF check-up on a diffuse BSDF with one fault.

mod domain;

use std::f64::consts::FRAC_PI_4;
use std::hint::black_box;
use std::sync::{Arc, Mutex};

use whitefurnace::harness::bsdf_checkup::{assertions, at_direction};
use whitefurnace::harness::directions::Density;
use whitefurnace::harness::roundoff::DOUBLE;

use super::*;

const ALBEDO: f64 = 0.5;

fn eval(_: DVec3, wi: DVec3) -> f64 {
    if wi.z > 0.0 { ALBEDO * FRAC_1_PI } else { 0.0 }
}
fn pdf(_: DVec3, wi: DVec3) -> f64 {
    cosine_hemisphere_pdf(wi.z)
}
fn sample(wo: DVec3, [r1, r2, _]: [f64; 3]) -> Option<SampledDirection> {
    let wi = cosine_hemisphere([r1, r2]);
    Some(SampledDirection {
        wi,
        weight: ALBEDO,
        pdf: pdf(wo, wi),
    })
}

fn right() -> BsdfSubject {
    BsdfSubject::new(eval, sample, pdf).albedo(|_| ALBEDO)
}

pub fn with_eval(eval: impl Fn(DVec3, DVec3) -> f64 + Send + Sync + 'static) -> BsdfSubject {
    BsdfSubject {
        eval: Box::new(eval),
        ..right()
    }
}

fn with_pdf(pdf: impl Fn(DVec3, DVec3) -> f64 + Send + Sync + 'static) -> BsdfSubject {
    BsdfSubject {
        pdf: Box::new(pdf),
        ..right()
    }
}

/// Returns the subject whose sampler loses all samples.
pub fn without_samples() -> BsdfSubject {
    BsdfSubject {
        sample: Box::new(|_, _| None),
        ..right()
    }
}

/// Returns the subject with the results of its sampler changed.
fn with_sample(change: impl Fn(&mut SampledDirection) + Send + Sync + 'static) -> BsdfSubject {
    BsdfSubject {
        sample: Box::new(move |wo, random| {
            let mut sample = sample(wo, random)?;
            change(&mut sample);
            Some(sample)
        }),
        ..right()
    }
}

/// A check-up too small for a verdict on cells, large enough for everything else.
fn small() -> CheckUp {
    CheckUp {
        inclinations: vec![30.0],
        samples: 20_000,
        pairs: 500,
        ..CheckUp::default()
    }
}

/// Runs a check-up at these inclinations and returns the outcome whose name begins so.
fn found(subject: &BsdfSubject, inclinations: Vec<f64>, name: &str) -> Outcome {
    check_up(
        subject,
        &CheckUp {
            inclinations,
            ..small()
        },
        &at_scale_1(name),
    )
    .into_iter()
    .find(|outcome| outcome.name.starts_with(name))
    .expect("an outcome of this name")
}

fn outcome(subject: &BsdfSubject, name: &str) -> Outcome {
    found(subject, vec![30.0], name)
}

/// Runs the pointwise checks alone, which need no direction.
fn pointwise(subject: &BsdfSubject, name: &str) -> Outcome {
    found(subject, Vec::new(), name)
}

/// Fails only where rustc takes closures' arguments for read-only although they change: without
/// incremental compilation.
#[test]
fn closures_have_arguments_of_their_own() {
    let subject = BsdfSubject::new(
        |mut wo, mut wi| {
            let f = eval(wo, wi);
            (wo.z, wi.z) = (-wo.z, -wi.z);
            black_box((wo, wi));
            f
        },
        |mut wo, mut random| {
            let sample = sample(wo, random);
            (wo.z, random[0]) = (-wo.z, 0.0);
            black_box((wo, random));
            sample
        },
        |mut wo, mut wi| {
            let pdf = pdf(wo, wi);
            (wo.z, wi.z) = (-wo.z, -wi.z);
            black_box((wo, wi));
            pdf
        },
    )
    .albedo(|_| ALBEDO);
    let told = |subject| {
        format!(
            "{:?}",
            check_up(subject, &small(), &at_scale_1("arguments"))
        )
    };
    assert_eq!(told(&subject), told(&right()));
    let density = Density::new(Domain::CosineHemisphere, |mut w| {
        let pdf = cosine_hemisphere_pdf(w.z);
        w.z = -w.z;
        black_box(w);
        pdf
    });
    let w = cosine_hemisphere([0.3, 0.6]);
    assert_eq!(
        [density.pdf(black_box(w)), density.pdf(w)],
        [cosine_hemisphere_pdf(w.z); 2]
    );
}

/// Number of random verdicts in this module: two subjects with two random outcomes each in at most
/// two directions, and one for all shares and means together, which are far within their bounds.
pub const ASSERTIONS: usize = 9;

/// Asserts that a share of n independent trials is as expected to within `reach`, after asserting
/// that chance exceeds `reach` with at most a hundredth of a share of the budget.
fn assert_share(found: usize, n: usize, share: f64, reach: f64) {
    let count = |share: f64| n as f64 * share;
    let above = binomial_sf(count(share + reach).ceil() as u64, n as u64, share);
    let below = match count(share - reach) {
        least if least < 0.0 => 0.0,
        least => binomial_cdf(least as u64, n as u64, share),
    };
    assert!(above + below <= 0.01 * ALPHA, "{share} of {n} ± {reach}");
    assert_abs_diff_eq!(found as f64 / n as f64, share, epsilon = reach);
}

const FINITE: &str = "finite and not negative";
const WEIGHTS: &str = "weight = f cos/pdf";
const INTEGRAL: &str = "integral of the pdf";

#[test]
fn a_check_up_asks_everything() {
    let size = CheckUp {
        inclinations: vec![0.0, 60.0],
        ..small()
    };
    let mut expected = [FINITE, WEIGHTS, "reciprocity"].map(String::from).to_vec();
    for degrees in [0, 60] {
        let each = [
            INTEGRAL,
            "chi-square of samples",
            "furnace",
            "energy bound",
            "directional albedo",
        ];
        expected.extend(each.map(|name| format!("{name} at {degrees} degrees")));
    }
    assert_eq!((assertions(&size), assertions(&small())), (4, 2));
    // Also the first channel of a model as it is rendered.
    let rendered = BsdfSubject::of(Bsdf::Lambert {
        albedo: DVec3::new(ALBEDO, 0.7, 0.9),
    })
    .albedo(|_| ALBEDO);
    for subject in [right(), rendered] {
        let outcomes = check_up(&subject, &size, &at_scale_1("everything"));
        assert!(outcomes.iter().map(|outcome| &outcome.name).eq(&expected));
        // All weights are equal, so the furnace tests are exact.
        assert_eq!(outcomes.iter().filter(|o| o.is_random()).count(), 2);
        for outcome in &outcomes {
            // The sample is too small for the cells to hold at any size; they only must not be
            // rejected.
            let expected = outcome.name.starts_with("chi-square");
            assert!(outcome.p >= ALPHA, "{}: {}", outcome.name, outcome.worst);
            assert_eq!(
                outcome.verdict() != Verdict::Holds,
                expected,
                "{}",
                outcome.name
            );
        }
    }
    // What is asked for has the same values without the rest.
    let everything = at_scale_1("everything");
    let of_all = check_up(&right(), &size, &everything);
    for (asked, ending) in [
        ("furnace at 60 degrees", "at 60 degrees"),
        ("weight = f cos/pdf", "weight = f cos/pdf"),
        ("finite and not negative", "finite and not negative"),
        ("reciprocity", "reciprocity"),
    ] {
        let asking = Context {
            asked: vec![asked],
            ..everything.clone()
        };
        let kept: Vec<_> = of_all.iter().filter(|o| o.name.ends_with(ending)).collect();
        assert!(!kept.is_empty() && kept.len() < of_all.len());
        assert_eq!(
            format!("{:?}", check_up(&right(), &size, &asking)),
            format!("{kept:?}")
        );
    }
    // 75 degrees are not special.
    let outcomes = at_direction(
        &right(),
        &size,
        &at_scale_1("direction"),
        DVec3::new(0.6, 0.0, 0.8),
        75.0,
    );
    assert!(
        outcomes
            .iter()
            .all(|outcome| outcome.name.ends_with("at 75 degrees"))
    );
}

#[test]
fn a_subject_is_what_was_set() {
    let new = || BsdfSubject::new(eval, sample, pdf);
    assert!(new().reciprocal && !new().transmits && matches!(new().loss, Loss::None));
    assert!(new().energy_bound == 1.0 && new().albedo.is_none());
    let set = new()
        .reciprocal(false)
        .transmits(true)
        .loss(Loss::Allowed)
        .energy_bound(0.5);
    assert!(
        !set.reciprocal
            && set.transmits
            && matches!(set.loss, Loss::Allowed)
            && set.energy_bound == 0.5
    );
    let outcomes = check_up(
        &new().reciprocal(false),
        &small(),
        &at_scale_1("no reciprocity"),
    );
    assert!(outcomes.iter().all(|outcome| outcome.name != "reciprocity"));
    assert!(
        outcomes
            .iter()
            .all(|o| !o.name.starts_with("directional albedo"))
    );
}

#[test]
fn no_value_may_be_bad() {
    let stretched = |factor: f64| with_sample(move |s| s.wi *= factor);
    let mut subjects = vec![
        (
            "sampled where the pdf is zero",
            with_sample(|s| s.pdf = 0.0),
            0.0,
        ),
        ("short", stretched(0.999), 0.0),
        ("long", stretched(1.001), 0.0),
        ("right", right(), 1.0),
        ("no light", with_eval(|_, _| 0.0), 1.0),
        ("no pdf there", with_pdf(|_, _| 0.0), 1.0),
        ("black", with_sample(|s| s.weight = 0.0), 1.0),
        ("no sample", without_samples(), 1.0),
    ];
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        subjects.extend([
            ("f", with_eval(move |_, _| bad), 0.0),
            ("pdf", with_pdf(move |_, _| bad), 0.0),
            ("weight", with_sample(move |s| s.weight = bad), 0.0),
            ("sampled pdf", with_sample(move |s| s.pdf = bad), 0.0),
        ]);
    }
    for (what, subject, p) in subjects {
        assert_eq!(pointwise(&subject, FINITE).p, p, "{what}");
    }
}

#[test]
fn pointwise_errors_are_relative() {
    let error = |subject: &BsdfSubject, name| pointwise(subject, name).estimate;
    assert!(error(&right(), WEIGHTS) < 1e-12);
    let heavy = with_sample(|s| s.weight *= 1.25);
    assert_relative_eq!(error(&heavy, WEIGHTS), 0.2, max_relative = 1e-9);
    let dense = with_sample(|s| s.pdf *= 0.75);
    assert_relative_eq!(error(&dense, WEIGHTS), 0.25, max_relative = 1e-9);
    // Samples that all have cosine z, and the pdf of other directions. Grazing directions are left
    // out, as their cosines have lost digits; 1e-4 is the last that counts.
    let with_cosine = |z: f64| {
        let wi = DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
        with_sample(move |s| s.wi = wi)
    };
    assert_eq!(error(&with_cosine(1e-5), WEIGHTS), 0.0);
    assert!(error(&with_cosine(1e-4), WEIGHTS) > 0.5);
    // Samples below the surface are compared in the same way.
    assert_eq!(error(&with_sample(|s| s.wi = -s.wi), WEIGHTS), 1.0);
    assert_eq!(error(&right(), "reciprocity"), 0.0);
    // Without an error there is no worst place.
    assert_eq!(pointwise(&right(), "reciprocity").worst, "");
    // The first direction's half of the hemisphere is twice as bright.
    let lopsided = with_eval(|wo, _| if wo.x > 0.0 { 2.0 } else { 1.0 });
    assert_eq!(error(&lopsided, "reciprocity"), 0.5);
    let broken = with_eval(|wo, wi| if wo.x > wi.x { f64::NAN } else { 1.0 });
    assert!(error(&broken, "reciprocity").is_nan());
    let worst = pointwise(&lopsided, "reciprocity").worst;
    assert!(
        worst.contains("f = 2 and 1") || worst.contains("f = 1 and 2"),
        "{worst}"
    );
}

/// Samples that are lost more or less often than the pdf says do not make up for a pdf that is too
/// high or too low by a factor.
#[test]
fn lost_samples_do_not_hide_the_pdf_s_factor() {
    const KEPT: f64 = 0.8;
    let furnace = |factor: f64| {
        let pdf = move |wo, wi| factor * KEPT * pdf(wo, wi);
        let sample = move |wo, [r1, r2, r3]: [f64; 3]| {
            let sample = sample(wo, [r1, r2, r3]).filter(|_| r3 < KEPT)?;
            Some(SampledDirection {
                weight: sample.weight / (factor * KEPT),
                pdf: pdf(wo, sample.wi),
                ..sample
            })
        };
        outcome(
            &BsdfSubject::new(eval, sample, pdf).loss(Loss::Allowed),
            "furnace",
        )
    };
    // The control variate takes all noise away.
    assert_abs_diff_eq!(furnace(1.0).estimate, ALBEDO, epsilon = 1e-6);
    for factor in [0.9, 1.1] {
        let wrong = furnace(factor);
        assert_ne!(wrong.verdict(), Verdict::Holds, "{factor}");
        assert!(wrong.p < ALPHA, "{factor}: p = {}", wrong.p);
        // Ten standard errors of a mean that 20 000 samples have.
        assert_abs_diff_eq!(wrong.estimate, ALBEDO / factor, epsilon = 0.02);
    }
}

#[test]
fn the_pdf_integrates_to_what_is_not_lost() {
    let error = |factor: f64, loss| {
        outcome(
            &with_pdf(move |wo, wi| factor * pdf(wo, wi)).loss(loss),
            INTEGRAL,
        )
        .estimate
    };
    let declared = |share: f64| Loss::Declared(Box::new(move |_| share));
    for (factor, loss, expected) in [
        (1.0, Loss::None, 0.0),
        (0.9, Loss::None, 0.1),
        (0.9, declared(0.1), 0.0),
        (0.9, declared(0.3), 0.2),
        (0.9, Loss::Allowed, 0.0),
        (1.2, Loss::Allowed, 0.2),
    ] {
        assert_abs_diff_eq!(error(factor, loss), expected, epsilon = 1e-7);
    }
    assert!(error(f64::NAN, Loss::Allowed).is_nan());
    // The whole sphere counts if light may pass.
    let through = with_pdf(|_, wi| wi.z.abs() * FRAC_1_PI);
    assert_abs_diff_eq!(outcome(&through, INTEGRAL).estimate, 0.0, epsilon = 1e-7);
    assert_abs_diff_eq!(
        outcome(&through.transmits(true), INTEGRAL).estimate,
        1.0,
        epsilon = 1e-7
    );
    // A narrow lobe is refined until a quarter of the tolerance is left.
    let lobe = with_pdf(|_, wi| 1001.0 / TAU * wi.z.max(0.0).powi(1000));
    assert_abs_diff_eq!(outcome(&lobe, INTEGRAL).estimate, 0.0, epsilon = 2.5e-7);
}

#[test]
fn albedo_bound_and_furnace_are_those_of_the_quadrature() {
    let found = outcome(&right().energy_bound(0.375), "energy bound");
    assert_abs_diff_eq!(found.estimate, 0.125, epsilon = 1e-7);
    assert_eq!(outcome(&right(), "energy bound").estimate, 0.0);
    let found = outcome(&right().albedo(|_| 0.75), "directional albedo");
    assert_abs_diff_eq!(found.estimate, 0.25, epsilon = 1e-7);
    let known = |excess: f64| {
        outcome(
            &right().albedo(move |_| ALBEDO + excess),
            "directional albedo",
        )
        .verdict()
    };
    let weighing = |weight: f64| outcome(&with_sample(move |s| s.weight = weight), "furnace");
    let found = weighing(ALBEDO);
    assert_eq!((found.n, found.verdict()), (20_000, Verdict::Holds));
    assert!(!found.is_random());
    // The quadrature is accurate to 1e-6; any larger difference fails, as nothing varies.
    for side in [1.0, -1.0] {
        assert_eq!(known(side * 1.9e-6), Verdict::Holds);
        assert_eq!(known(side * 2.1e-6), Verdict::Fails);
        assert_eq!(weighing(ALBEDO + side * 8e-7).verdict(), Verdict::Holds);
        assert_eq!(weighing(ALBEDO + side * 1.2e-6).verdict(), Verdict::Fails);
    }
    // Lost samples contribute zero: losing every other one halves the mean.
    let halved = BsdfSubject {
        sample: Box::new(|wo, random| sample(wo, random).filter(|_| random[2] < 0.5)),
        ..right()
    };
    let found = outcome(&halved, "furnace");
    assert_eq!(found.verdict(), Verdict::Fails);
    assert_relative_eq!(
        found.claim.size(),
        small().delta * ALBEDO,
        max_relative = 1e-5
    );
    assert_share(
        (found.estimate / ALBEDO * found.n as f64).round() as usize,
        found.n as usize,
        0.5,
        0.04,
    );
}

#[test]
fn samples_where_the_pdf_is_zero_or_infinite_are_forbidden() {
    let worst = |wi: DVec3, density: f64| {
        let subject = BsdfSubject {
            sample: Box::new(move |wo, random| {
                let right = sample(wo, random);
                if random[2] < 0.25 {
                    right.map(|s| SampledDirection { wi, ..s })
                } else {
                    right
                }
            }),
            pdf: Box::new(move |wo, at| if at == wi { density } else { pdf(wo, at) }),
            ..right()
        };
        outcome(&subject, "chi-square").worst
    };
    // One direction that no quadrature evaluates.
    let wi = DVec3::new(0.48, 0.6, 0.64);
    for density in [0.0, f64::INFINITY, f64::NAN, -1.0] {
        let found = worst(wi, density);
        assert!(found.contains("samples where the pdf is zero"), "{found}");
    }
    assert!(worst(wi, 1.0).starts_with("cell at"));
}
