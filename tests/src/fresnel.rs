//! Fresnel reflectance (10)-(12): identities that need no reference values, and hemispherical
//! averages.

use whitefurnace::harness::pointwise::LargestError;
use whitefurnace::material::fresnel::{
    reflectance, reflectance_p, reflectance_s, squared_cos_refracted,
};
use whitefurnace::sampling::warp::cosine_hemisphere;

use crate::mean_radiance::largest;
use crate::prelude::*;

/// A reflectance as a function of cos θ₁, n₁, n₂.
pub type Reflectance = fn(f64, f64, f64) -> f64;

const ARGUMENTS: u64 = 20_000;
const SAMPLES: u64 = 21_600_000;
/// Relative tolerance of identities: a few hundred roundings, away from the critical angle.
const TOLERANCE: f64 = 1e-10;
/// Relative δ of the sampled average.
const AVERAGE_DELTA: f64 = 0.003;

/// Samples the refractive indices of an interface, in [1, 3).
fn indices(rng: &mut Stream) -> [f64; 2] {
    [1.0 + 2.0 * uniform(rng), 1.0 + 2.0 * uniform(rng)]
}

/// Returns the largest error of an identity over random angles and indices. Angles whose refracted
/// cosine is below 1e-3 are left out: there R has a square-root singularity and loses digits by
/// conditioning.
fn identity(context: &Context, name: &str, error: impl Fn(f64, f64, f64, f64) -> f64) -> Outcome {
    let mut rng = context.rng(name);
    let mut largest = LargestError {
        place: String::from("no error"),
        ..LargestError::default()
    };
    for _ in 0..context.arguments(ARGUMENTS) {
        let [n1, n2] = indices(&mut rng);
        let cos_1 = uniform(&mut rng);
        let Some(cos_2) = snell(cos_1, n1, n2).filter(|&c| c > 1e-3) else {
            continue;
        };
        largest.update(error(cos_1, cos_2, n1, n2), || {
            format!("cos θ = {cos_1}, n = {n1} to {n2}")
        });
    }
    Outcome::identity(name, ARGUMENTS, largest.error, TOLERANCE, largest.place)
}

/// cos θ₂ from n₁ sin θ₁ = n₂ sin θ₂, computed independently through the angle itself.
fn snell(cos_1: f64, n1: f64, n2: f64) -> Option<f64> {
    let sin_2 = n1 / n2 * (1.0 - cos_1 * cos_1).sqrt();
    (sin_2 < 1.0).then(|| sin_2.asin().cos())
}

/// Tests R + T = 1 for each polarisation, with T from the *amplitudes* of the transmitted wave
/// (Born and Wolf, 1.5.2), not as 1 − R.
fn energy(context: &Context, Reflectances { s, p, .. }: Reflectances) -> Vec<Outcome> {
    let flux = |amplitude: f64, cos_1: f64, cos_2: f64, n1: f64, n2: f64| {
        amplitude * amplitude * n2 * cos_2 / (n1 * cos_1)
    };
    vec![
        identity(context, "R + T = 1, perpendicular", |c1, c2, n1, n2| {
            let t = 2.0 * n1 * c1 / (n1 * c1 + n2 * c2);
            (s(c1, n1, n2) + flux(t, c1, c2, n1, n2) - 1.0).abs()
        }),
        identity(context, "R + T = 1, parallel", |c1, c2, n1, n2| {
            let t = 2.0 * n1 * c1 / (n2 * c1 + n1 * c2);
            (p(c1, n1, n2) + flux(t, c1, c2, n1, n2) - 1.0).abs()
        }),
    ]
}

/// Tests R(n₁, n₂, θ₁) = R(n₂, n₁, θ₂). Errors are scaled by cos θ₁ cos θ₂: Snell's law there and
/// back leaves an error of ε/cos θ₁ in the cosine, and R changes by up to 1/cos θ₂ as much.
fn reversible(
    context: &Context,
    Reflectances { unpolarised: r, .. }: Reflectances,
) -> Vec<Outcome> {
    vec![identity(context, "reversibility", |c1, c2, n1, n2| {
        (r(c1, n1, n2) - r(c2, n2, n1)).abs() * c1 * c2
    })]
}

/// Tests R_p = 0 at Brewster's angle, tan θ = n₂/n₁, and R_s = ((n₁² − n₂²)/(n₁² + n₂²))² there.
fn brewster(context: &Context, Reflectances { s, p, .. }: Reflectances) -> Vec<Outcome> {
    let at_brewster = |n1: f64, n2: f64| 1.0 / (n2 / n1).hypot(1.0);
    vec![
        identity(context, "R_p at Brewster's angle", |_, _, n1, n2| {
            p(at_brewster(n1, n2), n1, n2)
        }),
        identity(context, "R_s at Brewster's angle", |_, _, n1, n2| {
            let r = (n1 * n1 - n2 * n2) / (n1 * n1 + n2 * n2);
            (s(at_brewster(n1, n2), n1, n2) - r * r).abs()
        }),
    ]
}

/// Tests R = ((n₁ − n₂)/(n₁ + n₂))² at normal incidence, and R = 1 at grazing.
fn limits(context: &Context, Reflectances { unpolarised: r, .. }: Reflectances) -> Vec<Outcome> {
    vec![
        identity(context, "normal incidence", |_, _, n1, n2| {
            (r(1.0, n1, n2) - ((n1 - n2) / (n1 + n2)).powi(2)).abs()
        }),
        identity(context, "grazing incidence", |_, _, n1, n2| {
            (r(0.0, n1, n2) - 1.0).abs()
        }),
    ]
}

/// Tests total reflection from the dense side, from the critical angle on, and 1 − R ~ √ just
/// before it.
fn critical(context: &Context, Reflectances { unpolarised: r, .. }: Reflectances) -> Vec<Outcome> {
    let mut rng = context.rng("critical");
    let (mut beyond, mut before) = (0.0_f64, 0.0_f64);
    for _ in 0..context.arguments(ARGUMENTS) {
        let [n, sine] = [1.05 + 1.95 * uniform(&mut rng), uniform(&mut rng)];
        let angle = (1.0 / n).asin();
        let past = angle * 1.001 + sine * (std::f64::consts::FRAC_PI_2 - angle * 1.001);
        let reflected = r(past.cos(), n, 1.0);
        // A NaN counts as a missing reflection.
        let error = if reflected.is_finite() {
            (reflected - 1.0).abs()
        } else {
            1.0
        };
        beyond = beyond.max(error);
        // Just before the critical angle some light is still transmitted.
        let leaves = 1.0 - r((angle * 0.999).cos(), n, 1.0);
        if !(1e-3..0.5).contains(&leaves) {
            before = 1.0;
        }
    }
    vec![
        Outcome::identity(
            "total reflection",
            ARGUMENTS,
            beyond,
            0.0,
            "past the critical angle",
        ),
        Outcome::identity(
            "critical angle times 0.999",
            ARGUMENTS,
            before,
            0.0,
            "before the critical angle",
        ),
    ]
}

/// Hemispherical (cosine-weighted) reflectance from outside, for n > 1: Walsh's closed form (1926).
pub fn walsh(n: f64) -> f64 {
    let n2 = n * n;
    let n4 = n2 * n2;
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
        + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
        - 2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln()
}

/// Tests the averages over cosine-distributed directions from outside and inside, F_ext by Walsh
/// and F_int = 1 − (1 − F_ext)/n², by quadrature and by sampling.
fn averages(context: &Context, Reflectances { unpolarised: r, .. }: Reflectances) -> Vec<Outcome> {
    const N: f64 = 1.5;
    let outside = walsh(N);
    let inside = 1.0 - (1.0 - outside) / (N * N);
    let mut outcomes = Vec::new();
    for (name, n1, n2, reference) in [("outside", 1.0, N, outside), ("inside", N, 1.0, inside)] {
        let integral =
            Domain::CosineHemisphere.integrate_all(1e-9, &|w: DVec3| r(w.z, n1, n2) * w.z / PI);
        outcomes.push(Outcome::identity(
            format!("average by quadrature, {name}"),
            1,
            (integral.value - reference).abs(),
            1e-6,
            format!("{:.9} for {reference:.9}", integral.value),
        ));
        let mut rng = context.rng(name);
        let value = || r(cosine_hemisphere(uniform2(&mut rng)).z, n1, n2);
        let name = format!("average by sampling, {name}");
        outcomes.push(mean_of(
            &name,
            reference,
            AVERAGE_DELTA,
            context.n(SAMPLES),
            value,
        ));
    }
    outcomes
}

/// Indices, angle in degrees, and the amplitudes r_p and r_s as the page *Fresnel's equations* of
/// HyperPhysics gives them and Mitsuba 3 keeps them for its own tests (mitsuba3 at b45b0a930,
/// src/render/tests/test_fresnel.py).
struct SpotValue {
    indices: [f64; 2],
    degrees: f64,
    amplitudes: [f64; 2],
}

const SPOT_VALUES: [SpotValue; 4] = [
    SpotValue {
        indices: [1.0, 1.5],
        degrees: 45.0,
        amplitudes: [0.09201336304552442, 0.3033370452904235],
    },
    SpotValue {
        indices: [1.5, 1.0],
        degrees: 10.0,
        amplitudes: [0.19046797197779405, 0.20949431963852014],
    },
    SpotValue {
        indices: [1.5, 1.0],
        degrees: 45.0,
        amplitudes: [1.0, 1.0],
    },
    // Brewster's angle to four decimals.
    SpotValue {
        indices: [1.0, 1.5],
        degrees: 56.3099,
        amplitudes: [0.0, 0.3846150939598947],
    },
];

/// Largest error of the spot values: at Brewster's angle, which is rounded to four decimals, R_p is
/// of the order of 10⁻¹³.
const SPOT_TOLERANCE: f64 = 1e-12;

/// Compares all three reflectances with values from outside.
fn spot_values(_: &Context, parts: Reflectances) -> Vec<Outcome> {
    let error = |value: &SpotValue| {
        let ([n1, n2], cosine) = (value.indices, value.degrees.to_radians().cos());
        let [p, s] = value.amplitudes.map(|amplitude| amplitude * amplitude);
        [
            (parts.p)(cosine, n1, n2) - p,
            (parts.s)(cosine, n1, n2) - s,
            (parts.unpolarised)(cosine, n1, n2) - 0.5 * (p + s),
        ]
    };
    let errors = SPOT_VALUES.iter().flat_map(error).map(f64::abs);
    vec![Outcome::identity(
        "spot values",
        3 * SPOT_VALUES.len() as u64,
        largest(errors),
        SPOT_TOLERANCE,
        "four angles",
    )]
}

/// The reflectances (10), (11) and (12), each replaceable.
#[derive(Clone, Copy)]
pub struct Reflectances {
    /// (10).
    pub s: Reflectance,
    /// (11).
    pub p: Reflectance,
    /// (12).
    pub unpolarised: Reflectance,
}

const CORRECT: Reflectances = Reflectances {
    s: reflectance_s,
    p: reflectance_p,
    unpolarised: reflectance,
};

/// Schlick's approximation in place of (12).
pub(super) fn schlick(cos_1: f64, n1: f64, n2: f64) -> f64 {
    let r0 = ((n1 - n2) / (n1 + n2)).powi(2);
    r0 + (1.0 - r0) * (1.0 - cos_1).powi(5)
}

/// A finite R past the critical angle, without total reflection.
pub(super) fn no_total_reflection(cos_1: f64, n1: f64, n2: f64) -> f64 {
    let total = squared_cos_refracted(cos_1, n1, n2) <= 0.0;
    reflectance(if total { 1.0 } else { cos_1 }, n1, n2)
}

/// (12) taken literally past the critical angle: NaN.
fn literal(cos_1: f64, n1: f64, n2: f64) -> f64 {
    let cos_2 = (1.0 - (n1 / n2).powi(2) * (1.0 - cos_1 * cos_1)).sqrt();
    let s = (n1 * cos_1 - n2 * cos_2) / (n1 * cos_1 + n2 * cos_2);
    let p = (n1 * cos_2 - n2 * cos_1) / (n1 * cos_2 + n2 * cos_1);
    0.5 * (s * s + p * p)
}

fn trials() -> Vec<FamilyTrial<Reflectances>> {
    let family_trial =
        |name: &str, property: &str, consequence: &str, equation, on: TrialFn<Reflectances>| {
            let subject = "material::fresnel::reflectance, reflectance_s, reflectance_p";
            trial(
                format!("fresnel/{name}"),
                property,
                consequence,
                equation,
                subject,
                "exact",
                on,
            )
        };
    vec![
        family_trial(
            "energy",
            "reflected and transmitted flux sum to one for each polarisation",
            "glass makes light, or swallows it, at its surface",
            &FRESNEL_S,
            energy,
        ),
        family_trial(
            "brewster",
            "R_p vanishes at Brewster's angle and R_s has its closed form",
            "water and glass reflect too much or too little at middle angles",
            &FRESNEL_P,
            brewster,
        ),
        family_trial(
            "reversible",
            "R is the same from both sides along one ray",
            "glass looks right from outside and wrong from within",
            &FRESNEL,
            reversible,
        ),
        family_trial(
            "limits",
            "R at normal and at grazing incidence",
            "glass seen squarely reflects too much, or its rim is no mirror",
            &FRESNEL,
            limits,
        ),
        family_trial(
            "critical",
            "reflection is total past the critical angle and not before",
            "total reflection in glass is missing, comes too early, or leaves NaN pixels",
            &FRESNEL,
            critical,
        ),
        family_trial(
            "spot-values",
            "R_p, R_s and R have the values that Mitsuba 3 keeps for its own tests",
            "glass reflects another share of light than in Mitsuba at the same angle",
            &FRESNEL,
            spot_values,
        ),
        trial(
            "fresnel/averages",
            "hemispherical averages follow Walsh, and 1 − F_int = (1 − F_ext)/n²",
            "glass or water under an even sky passes too much or too little light in all",
            &REFRACTION,
            "material::fresnel::reflectance",
            "t",
            averages,
        ),
    ]
}

fn faults() -> Vec<Fault<Reflectances>> {
    let whole = |r: Reflectance| Reflectances {
        unpolarised: r,
        ..CORRECT
    };
    vec![
        fault!("amplitude", FRESNEL_S, "R_s without its square",
            Reflectances: { s: |c, n1, n2| reflectance_s(c, n1, n2).sqrt() },
            "fresnel/energy: R + T = 1, perpendicular"),
        fault!("exchanged", FRESNEL_P, "R_p for R_s and R_s for R_p",
            Reflectances: { s: reflectance_p, p: reflectance_s },
            "fresnel/brewster: R_p at Brewster's angle", "fresnel/brewster: R_s at Brewster's angle",
            "fresnel/energy: R + T = 1, perpendicular", "fresnel/energy: R + T = 1, parallel"),
        fault!("schlick", FRESNEL, "Schlick's approximation",
            = whole(schlick), "fresnel/reversible", "fresnel/averages: average by quadrature, outside"),
        fault!("sum", FRESNEL, "R_s + R_p without the half",
            = whole(|c, n1, n2| reflectance_s(c, n1, n2) + reflectance_p(c, n1, n2)),
            "fresnel/limits: normal incidence | grazing incidence"),
        fault!("no-total-reflection", FRESNEL, "a finite R past the critical angle",
            = whole(no_total_reflection),
            "fresnel/critical: total reflection", "fresnel/averages: average by quadrature, inside"),
        fault!("literal", FRESNEL, "(10)-(12) as printed: NaN past the critical angle",
            = whole(literal), "fresnel/critical: total reflection"),
        fault!("only-s", FRESNEL, "R_s alone, as if light were polarised",
            = whole(reflectance_s),
            "fresnel/averages: average by sampling, outside | average by sampling, inside",
            "fresnel/spot-values"),
        fault!("swapped-indices", FRESNEL, "n₁ and n₂ exchanged",
            = whole(|c, n1, n2| reflectance(c, n2, n1)), "fresnel/critical: critical angle times 0.999"),
    ]
}

/// Trials and faults of the Fresnel reflectances.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: trials(),
        faults: faults(),
        ..Family::new("fresnel", CORRECT)
    })]
}
