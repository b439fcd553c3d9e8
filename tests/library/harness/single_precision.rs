//! Check-ups of BSDFs computed in single precision, with vectors of their own: right ones hold, and
//! with an error of one percent they fail.

mod glass;

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use whitefurnace::harness::directions::{Density, Directions, Precision, Sample};
use whitefurnace::harness::roundoff::{DOUBLE, SINGLE};
use whitefurnace::material::Model as _;
use whitefurnace::material::ggx::Ggx;

use super::*;

type V = [f32; 3];

fn dot(a: V, b: V) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn scaled(a: V, s: f32) -> V {
    a.map(|x| x * s)
}
fn sum(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
fn cross(a: V, b: V) -> V {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
fn unit(a: V) -> V {
    scaled(a, 1.0 / dot(a, a).sqrt())
}
fn mirrored(w: V, h: V) -> V {
    sum(scaled(h, 2.0 * dot(w, h)), scaled(w, -1.0))
}

/// Samples cosine-weighted directions by the polar map.
fn cosine(u: [f32; 2]) -> V {
    let (r, phi) = (u[0].sqrt(), TAU * u[1]);
    [r * phi.cos(), r * phi.sin(), (1.0 - u[0]).max(0.0).sqrt()]
}

/// Samples cosine-weighted directions by the concentric map: z may round to 0.
fn concentric(u: [f32; 2]) -> V {
    let [a, b] = u.map(|u| 2.0 * u - 1.0);
    let (r, phi) = if a == 0.0 && b == 0.0 {
        (0.0, 0.0)
    } else if a.abs() > b.abs() {
        (a, PI / 4.0 * (b / a))
    } else {
        (b, PI / 2.0 - PI / 4.0 * (a / b))
    };
    let [x, y] = [r * phi.cos(), r * phi.sin()];
    [x, y, (1.0 - x * x - y * y).max(0.0).sqrt()]
}

/// Evaluates the Trowbridge-Reitz distribution in the usual form, whose denominator loses digits
/// near the pole of a narrow lobe.
fn distribution(h: V, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let t = h[2] * h[2] * (a2 - 1.0) + 1.0;
    a2 / (PI * t * t)
}
fn lambda(w: V, alpha: f32) -> f32 {
    let tan2 = (w[0] * w[0] + w[1] * w[1]) / (w[2] * w[2]);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}
fn ggx_eval(wo: V, wi: V, alpha: f32) -> f32 {
    let h = unit(sum(wo, wi));
    distribution(h, alpha) / ((1.0 + lambda(wo, alpha) + lambda(wi, alpha)) * 4.0 * wo[2] * wi[2])
}
fn ggx_pdf(wo: V, wi: V, alpha: f32) -> f32 {
    let h = unit(sum(wo, wi));
    let seen = distribution(h, alpha) * dot(wo, h).max(0.0) / ((1.0 + lambda(wo, alpha)) * wo[2]);
    seen / (4.0 * dot(wo, h))
}
fn ggx_normal(wo: V, u: [f32; 2], alpha: f32) -> V {
    let v = unit([alpha * wo[0], alpha * wo[1], wo[2]]);
    let across = v[0] * v[0] + v[1] * v[1];
    let t1 = if across > 0.0 {
        scaled([-v[1], v[0], 0.0], 1.0 / across.sqrt())
    } else {
        [1.0, 0.0, 0.0]
    };
    let t2 = cross(v, t1);
    let (r, phi) = (u[0].sqrt(), TAU * u[1]);
    let (a, s) = (r * phi.cos(), 0.5 * (1.0 + v[2]));
    let b = (1.0 - s) * (1.0 - a * a).max(0.0).sqrt() + s * r * phi.sin();
    let c = (1.0 - a * a - b * b).max(0.0).sqrt();
    let n = sum(sum(scaled(t1, a), scaled(t2, b)), scaled(v, c));
    unit([alpha * n[0], alpha * n[1], n[2].max(0.0)])
}

fn schlick(cosine: f32, f0: f32) -> f32 {
    f0 + (1.0 - f0) * (1.0 - cosine).max(0.0).powi(5)
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Model {
    Lambert,
    /// Diffuse, sampled by the concentric map in a frame that is not that of the axes; the weight
    /// is f cos/pdf.
    Concentric,
    Ggx(f32),
    Phong(f32),
    /// Diffuse below GGX, selected by the Fresnel reflectance of wo.
    Mix {
        alpha: f32,
        f0: f32,
    },
    /// Diffuse below a coat, with equal probability of either; light is lost on its way in and out
    /// of the coat.
    Coated(f32),
}

/// Relative errors of one percent, or none.
#[derive(Clone, Copy, Debug, Default)]
struct RelativeErrors {
    weight: f32,
    pdf: f32,
    choice: f32,
}

const RHO: f32 = 0.7;
const F0: f32 = 0.04;

impl Model {
    fn choice(self, wo: V) -> f32 {
        match self {
            Self::Mix { f0, .. } => 0.2 + 0.6 * schlick(wo[2], f0),
            Self::Coated(_) => 0.5,
            _ => 1.0,
        }
    }

    fn eval(self, wo: V, wi: V) -> f32 {
        if wo[2] <= 0.0 || wi[2] <= 0.0 {
            return 0.0;
        }
        let fresnel = |f0| schlick(dot(wo, unit(sum(wo, wi))), f0);
        match self {
            Self::Lambert | Self::Concentric => RHO * FRAC_1_PI,
            Self::Ggx(alpha) => ggx_eval(wo, wi, alpha),
            Self::Phong(n) => {
                (n + 2.0) / TAU * 0.5 * dot(mirrored(wo, [0.0, 0.0, 1.0]), wi).max(0.0).powf(n)
            }
            Self::Mix { alpha, f0 } => {
                0.5 * RHO * FRAC_1_PI + 0.5 * fresnel(f0) * ggx_eval(wo, wi, alpha)
            }
            Self::Coated(alpha) => {
                let through = (1.0 - schlick(wo[2], F0)) * (1.0 - schlick(wi[2], F0));
                through * RHO * FRAC_1_PI + fresnel(F0) * ggx_eval(wo, wi, alpha)
            }
        }
    }

    fn pdf(self, wo: V, wi: V) -> f32 {
        if wo[2] <= 0.0 || wi[2] <= 0.0 {
            return 0.0;
        }
        match self {
            Self::Lambert | Self::Concentric => wi[2] * FRAC_1_PI,
            Self::Ggx(alpha) => ggx_pdf(wo, wi, alpha),
            Self::Phong(n) => {
                (n + 1.0) / TAU * dot(mirrored(wo, [0.0, 0.0, 1.0]), wi).max(0.0).powf(n)
            }
            Self::Mix { alpha, .. } | Self::Coated(alpha) => {
                let p = self.choice(wo);
                p * ggx_pdf(wo, wi, alpha) + (1.0 - p) * wi[2] * FRAC_1_PI
            }
        }
    }

    fn sample(self, wo: V, u: [f32; 3], errors: RelativeErrors) -> Option<(V, f32, f32)> {
        if wo[2] <= 0.0 {
            return None;
        }
        let pair = [u[0], u[1]];
        let ggx = |alpha| mirrored(wo, ggx_normal(wo, pair, alpha));
        let wi = match self {
            Self::Lambert => cosine(pair),
            Self::Concentric => {
                // To a frame and back: rounding may move the direction below the horizon.
                let n = unit([0.3, -0.5, 0.8]);
                let t = unit(cross(n, [0.0, 1.0, 0.0]));
                let b = cross(n, t);
                let w = concentric(pair);
                let world = sum(sum(scaled(t, w[0]), scaled(b, w[1])), scaled(n, w[2]));
                [dot(world, t), dot(world, b), dot(world, n)]
            }
            Self::Ggx(alpha) => ggx(alpha),
            Self::Phong(n) => {
                let r = mirrored(wo, [0.0, 0.0, 1.0]);
                let c = u[0].powf(1.0 / (n + 1.0));
                let (s, phi) = ((1.0 - c * c).max(0.0).sqrt(), TAU * u[1]);
                let t = unit(cross(
                    r,
                    if r[0].abs() < 0.9 {
                        [1.0, 0.0, 0.0]
                    } else {
                        [0.0, 1.0, 0.0]
                    },
                ));
                sum(
                    sum(scaled(t, s * phi.cos()), scaled(cross(r, t), s * phi.sin())),
                    scaled(r, c),
                )
            }
            Self::Mix { alpha, .. } | Self::Coated(alpha) => {
                if u[2] < self.choice(wo) * (1.0 + errors.choice) {
                    ggx(alpha)
                } else {
                    cosine(pair)
                }
            }
        };
        if matches!(
            self,
            Self::Ggx(_) | Self::Phong(_) | Self::Mix { .. } | Self::Coated(_)
        ) && wi[2] <= 0.0
        {
            return None;
        }
        let pdf = self.pdf(wo, wi);
        let weight = match self {
            Self::Lambert | Self::Concentric => RHO,
            Self::Ggx(alpha) => {
                (1.0 + lambda(wo, alpha)) / (1.0 + lambda(wo, alpha) + lambda(wi, alpha))
            }
            Self::Phong(n) => 0.5 * (n + 2.0) / (n + 1.0) * wi[2],
            Self::Mix { .. } | Self::Coated(_) => self.eval(wo, wi) * wi[2] / pdf,
        };
        Some((wi, weight * (1.0 + errors.weight), pdf))
    }

    /// Returns the model as a subject of the check-up.
    fn subject(self, errors: RelativeErrors) -> BsdfSubject {
        let single = |w: DVec3| w.to_array().map(|x| x as f32);
        BsdfSubject::new(
            move |wo, wi| f64::from(self.eval(single(wo), single(wi))),
            move |wo, u| {
                let (wi, weight, pdf) = self.sample(single(wo), u.map(|u| u as f32), errors)?;
                let pdf = f64::from(pdf * (1.0 + errors.pdf));
                Some(SampledDirection {
                    wi: DVec3::from_array(wi.map(f64::from)),
                    weight: f64::from(weight),
                    pdf,
                })
            },
            move |wo, wi| f64::from(self.pdf(single(wo), single(wi)) * (1.0 + errors.pdf)),
        )
        .loss(Loss::Allowed)
    }
}

const MODELS: [Model; 8] = [
    Model::Lambert,
    Model::Concentric,
    Model::Ggx(0.05),
    Model::Ggx(0.5),
    Model::Ggx(1.0),
    Model::Phong(50.0),
    Model::Mix { alpha: 0.1, f0: F0 },
    Model::Coated(0.1),
];
/// Number of random verdicts: two random outcomes of each model in one direction, and one fault.
pub const ASSERTIONS: usize = 2 * MODELS.len() + 1;

/// A check-up too small for a verdict on cells, large enough for everything else.
fn size(inclinations: Vec<f64>) -> CheckUp {
    CheckUp {
        inclinations,
        samples: 20_000,
        pairs: 2000,
        ..CheckUp::default()
    }
}

#[test]
fn right_models_hold() {
    for model in MODELS {
        for outcome in check_up(
            &model.subject(RelativeErrors::default()),
            &size(vec![60.0]),
            &at_scale_1("single precision"),
        ) {
            assert!(outcome.p >= ALPHA, "{model:?}, {outcome}");
            assert!(
                outcome.is_random() || outcome.verdict() == Verdict::Holds,
                "{model:?}, {outcome}"
            );
        }
    }
}

#[test]
fn an_error_of_one_percent_is_detected_pointwise() {
    let (weight, pdf) = (
        RelativeErrors {
            weight: 0.01,
            ..RelativeErrors::default()
        },
        RelativeErrors {
            pdf: -0.01,
            ..RelativeErrors::default()
        },
    );
    for model in MODELS {
        for errors in [weight, pdf] {
            let outcomes = check_up(
                &model.subject(errors),
                &size(Vec::new()),
                &at_scale_1("slips"),
            );
            let fails = |name| {
                outcomes
                    .iter()
                    .any(|o| o.name == name && o.verdict() == Verdict::Fails)
            };
            assert!(fails("weight = f cos/pdf"), "{model:?}, {errors:?}");
        }
    }
}

/// A sampler that selects one lobe too often by one percent, and whose pdf ignores that, fails: no
/// value at any point is wrong.
#[test]
fn a_wrong_choice_of_lobes_by_one_percent_fails() {
    let errors = RelativeErrors {
        choice: 0.01,
        ..RelativeErrors::default()
    };
    let size = CheckUp {
        samples: 4_000_000,
        ..size(vec![40.0])
    };
    let outcomes = check_up(
        &Model::Coated(0.1).subject(errors),
        &size,
        &at_scale_1("wrong choice"),
    );
    let failed = |random: bool| {
        outcomes
            .iter()
            .filter(move |o| o.is_random() == random && o.verdict() == Verdict::Fails)
    };
    assert!(
        failed(true).any(|outcome| outcome.name.starts_with("furnace")),
        "{outcomes:?}"
    );
    assert_eq!(failed(false).count(), 0, "{outcomes:?}");
}

/// Pdfs of a narrow lobe lose digits at its peak, and hold; with an error of one percent they fail.
#[test]
fn pdfs_of_narrow_lobes_are_judged_where_they_have_digits() {
    const SAMPLES: u32 = 20_000;
    for (alpha, degrees) in [(0.01, 0.0_f64), (0.01, 60.0), (0.01, 85.0), (0.02, 60.0)] {
        let (ggx, wo) = (
            Ggx {
                reflectance: DVec3::ONE,
                alpha,
            },
            from_spherical(degrees.to_radians(), 0.0),
        );
        let density = Density::new(Domain::Hemisphere, move |wi| {
            if wi.z > 0.0 { ggx.pdf(wo, wi) } else { 0.0 }
        });
        let wo = wo.to_array().map(|x| x as f32);
        for (factor, verdict) in [
            (1.0, Verdict::Holds),
            (1.01, Verdict::Fails),
            (0.99, Verdict::Fails),
        ] {
            // A fixed seed: nothing is left to chance.
            let mut rng = stream(seed_for(5, "narrow pdfs"), 0, 0);
            let mut directions = Directions::with_precision(&density, Precision::SINGLE);
            for _ in 0..SAMPLES * if factor == 1.0 { 10 } else { 1 } {
                let random = uniform2(&mut rng).map(|u| u as f32);
                let wi = mirrored(wo, ggx_normal(wo, random, alpha as f32));
                let seen = wi[2] > 0.0;
                let pdf = seen.then(|| factor * f64::from(ggx_pdf(wo, wi, alpha as f32)));
                let direction = seen.then(|| DVec3::from_array(wi.map(f64::from)));
                directions.push(&Sample {
                    direction,
                    weight: None,
                    pdf,
                });
            }
            let found = directions.outcomes(0.5, None).pop().expect("reported pdfs");
            assert_eq!(
                found.verdict(),
                verdict,
                "{alpha}, {degrees}, {factor}: {found}"
            );
        }
    }
}

#[test]
fn a_stated_precision_is_what_counts() {
    let lambert = || Model::Lambert.subject(RelativeErrors::default());
    let found = |roundoff, name: &str| {
        let size = CheckUp {
            roundoff,
            ..size(vec![30.0])
        };
        let outcomes = check_up(&lambert(), &size, &at_scale_1("stated"));
        outcomes
            .into_iter()
            .find(|outcome| outcome.name.starts_with(name))
            .expect("an outcome")
    };
    assert!(
        found(Some(DOUBLE), "chi-square")
            .worst
            .contains("is no unit vector to 1e-9: its length is")
    );
    assert_eq!(found(Some(DOUBLE), "finite").verdict(), Verdict::Fails);
    for roundoff in [None, Some(SINGLE)] {
        let outcome = found(roundoff, "finite");
        assert_eq!(outcome.verdict(), Verdict::Holds, "{outcome}");
        assert!(
            outcome.worst.contains("judged as single precision"),
            "{outcome}"
        );
    }
    // Numbers with eight bits decide nothing.
    assert!(matches!(
        found(Some(1.0 / 512.0), "integral").verdict(),
        Verdict::Undecided { .. }
    ));
}
