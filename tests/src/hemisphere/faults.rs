//! Faults of the hemisphere samplers.

use whitefurnace::math::frame::from_spherical;
use whitefurnace::sampling::warp::{
    cosine_hemisphere, cosine_hemisphere_pdf, hemisphere_printed, uniform_hemisphere,
    uniform_hemisphere_pdf, uniform_theta,
};

use crate::hemisphere::{Method, Pdf};
use crate::prelude::*;

/// (18) without the inverse cosine, θ = rπ/2.
pub fn linear_theta([r1, r2]: [f64; 2]) -> DVec3 {
    from_spherical(r1 * PI / 2.0, TAU * r2)
}

/// (19) over half the circle.
pub fn half_circle([r1, r2]: [f64; 2]) -> DVec3 {
    from_spherical(uniform_theta(r1), PI * r2)
}

/// (18) and (19) with one random number.
pub fn shared_number([r, _]: [f64; 2]) -> DVec3 {
    hemisphere_printed(r)
}

/// The cosine map with one random number.
pub fn shared_number_cosine([r, _]: [f64; 2]) -> DVec3 {
    cosine_hemisphere([r, r])
}

/// The cosine map without its root: sin θ = r.
pub fn no_root([r1, r2]: [f64; 2]) -> DVec3 {
    let (sin, cos) = (TAU * r2).sin_cos();
    DVec3::new(r1 * cos, r1 * sin, (1.0 - r1 * r1).sqrt())
}

/// The cosine map over half the circle.
pub fn half_circle_cosine([r1, r2]: [f64; 2]) -> DVec3 {
    cosine_hemisphere([r1, 0.5 * r2])
}

/// cos θ slightly too large too often: pdf proportional to cos^0.05 θ.
fn low_cosine_power([r1, r2]: [f64; 2]) -> DVec3 {
    uniform_hemisphere([1.0 - (1.0 - r1).powf(1.0 / 1.05), r2])
}

pub(super) fn uniform_faults() -> Vec<Fault<Method>> {
    let pdf: Pdf = uniform_hemisphere_pdf;
    vec![
        fault!("shared-number", HEMISPHERE_PHI, "one random number for θ and φ, as printed",
            = Method { sampler: shared_number, pdf },
            "hemisphere/uniform/cells", "hemisphere/uniform/moments: mean of x | mean of y",
            "hemisphere/uniform/furnaces: furnace, radiance 1 + x | furnace, radiance 1 + y"),
        fault!("linear-theta", HEMISPHERE_THETA, "θ = rπ/2",
            = Method { sampler: linear_theta, pdf },
            "hemisphere/uniform/moments: mean of z | mean of z²", "hemisphere/uniform/cells",
            "hemisphere/uniform/angles: law of cos θ"),
        fault!("half-circle", HEMISPHERE_PHI, "φ over half the circle",
            = Method { sampler: half_circle, pdf },
            "hemisphere/uniform/angles: law of φ", "hemisphere/uniform/furnaces: furnace, radiance 1 + y"),
        fault!("cosine-weight", ESTIMATOR,
            "uniform directions with the weight of the cosine pdf: radiance 1 does not show it",
            = Method { sampler: uniform_hemisphere, pdf: cosine_hemisphere_pdf }, "hemisphere/uniform/furnaces: furnace, radiance cos θ"),
        fault!("pdf-twice", HEMISPHERE_PDF, "the pdf is 1/π",
            = Method { sampler: uniform_hemisphere, pdf: |cos| 2.0 * uniform_hemisphere_pdf(cos) },
            "hemisphere/uniform/pdf", "hemisphere/uniform/furnaces: furnace, radiance 1"),
        fault!("cosine-for-uniform", HEMISPHERE_THETA,
            "cosine-weighted directions, called importance sampling, for (18)",
            = Method { sampler: cosine_hemisphere, pdf }, "hemisphere/uniform/moments: mean of z"),
        fault!("slip", HEMISPHERE_THETA, "density proportional to the power 0.05 of cos θ",
            = Method { sampler: low_cosine_power, pdf }, "hemisphere/uniform/moments: mean of z"),
    ]
}

pub(super) fn uniform_equivalents() -> Vec<Fault<Method>> {
    vec![
        fault!("one-minus-r", HEMISPHERE_THETA, "1 − r for r in (18): it is as uniform as r",
        = Method { sampler: |[r1, r2]| uniform_hemisphere([1.0 - r1, r2]), pdf: uniform_hemisphere_pdf }, "hemisphere/uniform/moments"),
    ]
}

pub(super) fn cosine_faults() -> Vec<Fault<Method>> {
    let pdf: Pdf = cosine_hemisphere_pdf;
    vec![
        fault!("shared-number", COSINE_HEMISPHERE, "one random number for θ and φ",
            = Method { sampler: shared_number_cosine, pdf },
            "hemisphere/cosine/cells", "hemisphere/cosine/moments: mean of x | mean of y"),
        fault!("no-root", COSINE_HEMISPHERE, "sin θ = r for sin θ = √r",
            = Method { sampler: no_root, pdf },
            "hemisphere/cosine/moments: mean of z | mean of z²", "hemisphere/cosine/cells",
            "hemisphere/cosine/angles: law of cos θ"),
        fault!("half-circle", COSINE_HEMISPHERE, "φ over half the circle",
            = Method { sampler: half_circle_cosine, pdf }, "hemisphere/cosine/angles: law of φ"),
        fault!("uniform-weight", COSINE_HEMISPHERE, "cosine directions with the weight 2 cos θ",
            = Method { sampler: cosine_hemisphere, pdf: uniform_hemisphere_pdf },
            "hemisphere/cosine/furnaces: furnace, radiance 1 | furnace, radiance 1 + x | furnace, radiance 1 + y"),
        fault!("uniform-sampler", COSINE_HEMISPHERE, "uniform directions with the cosine pdf's weight",
            = Method { sampler: uniform_hemisphere, pdf }, "hemisphere/cosine/furnaces: furnace, radiance cos θ"),
        fault!("pdf-twice", HEMISPHERE_PDF, "the pdf is 2 cos θ/π",
            = Method { sampler: cosine_hemisphere, pdf: |cos| 2.0 * cosine_hemisphere_pdf(cos) }, "hemisphere/cosine/pdf"),
    ]
}

pub(super) fn cosine_equivalents() -> Vec<Fault<Method>> {
    vec![
        fault!("turned", COSINE_HEMISPHERE, "φ counted from y: the law has no direction of its own",
        = Method { sampler: |[r1, r2]| cosine_hemisphere([r1, (r2 + 0.25).fract()]), pdf: cosine_hemisphere_pdf }, "hemisphere/cosine/moments"),
    ]
}
