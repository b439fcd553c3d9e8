//! Faults of radiosity.

use glam::Vec3Swizzles;
use whitefurnace::geometry::{form_factor, radiometry};
use whitefurnace::integrator::radiosity;

use crate::prelude::*;

/// Form factor towards the middle of a polygon, for a surface that faces it: the receiver's cosine
/// is missing.
fn without_cosine(_: DVec3, corners: &[DVec3]) -> f64 {
    let middle: DVec3 = corners.iter().sum();
    form_factor::polygon(middle.normalize_or_zero(), corners)
}

pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("form-factor-without-cosine", FORM_FACTOR, "the cosine at the receiver is missing",
            { form_factor: without_cosine },
            "radiosity/horizon", "radiosity/skewed", "radiosity/triangle", "radiosity/closure",
            "radiosity/parallel-plates"),
        fault!("form-factor-orientation", FORM_FACTOR, "the edges run the wrong way: fronts are taken for backs",
            { form_factor: |normal, corners| -form_factor::polygon(normal, corners) },
            "radiosity/rectangle", "radiosity/closure"),
        fault!("form-factor-doubled", FORM_FACTOR, "1/π for 1/2π",
            { form_factor: |normal, corners| 2.0 * form_factor::polygon(normal, corners) },
            "radiosity/close", "radiosity/parallel-plates", "radiosity/perpendicular-plates"),
        fault!("form-factor-open", FORM_FACTOR, "the edge from the last corner to the first is left out",
            { form_factor: |normal, corners| {
                let edge = |pair: &[DVec3]| {
                    pair[0].angle_between(pair[1]) * pair[0].cross(pair[1]).normalize_or_zero().dot(normal)
                };
                corners.windows(2).map(edge).sum::<f64>() * -0.5 * FRAC_1_PI
            } },
            "radiosity/reciprocity", "radiosity/perpendicular-plates"),
        fault!("horizon-not-cut", FORM_FACTOR, "the part of a polygon below the horizon counts, negatively",
            { clip_to_horizon: |_, polygon| *polygon }, "radiosity/horizon"),
        fault!("hidden-patches-seen", FORM_FACTOR, "nothing hides anything",
            { visible: |_, _, _, _| true }, "radiosity/half-hidden", "radiosity/hidden-below",
            "radiosity/hidden-above", "radiosity/hidden-aside", "radiosity/nested"),
        fault!("both-sides-alike", FORM_FACTOR,
            "neither horizons nor signs count: light from behind a surface arrives",
            {
                clip_to_horizon: |_, polygon| *polygon,
                form_factor: |normal, corners| form_factor::polygon(normal, corners).abs(),
                visibility_weight: |_, solid_angle| solid_angle
            }, "radiosity/both-sides", "radiosity/horizon"),
        fault!("share-without-cosine", FORM_FACTOR,
            "the visible share of a light is taken without the receiver's cosine",
            { visibility_weight: |_, solid_angle| solid_angle }, "radiosity/hidden-below",
            "radiosity/hidden-above"),
        fault!("share-by-area", FORM_FACTOR, "the visible share of a light is that of its area",
            { visibility_weight: |_, _| 1.0 }, "radiosity/hidden-below", "radiosity/hidden-above",
            "radiosity/hidden-aside"),
        fault!("seen-by-the-middle", FORM_FACTOR, "a light is looked for at its middle alone",
            { sample_emitter: |emitter, _| emitter.sample([0.5, 0.5]) }, "radiosity/hidden-aside",
            "radiosity/hidden-above"),
        fault!("seen-by-one-end", FORM_FACTOR, "lights are looked for nearer to one end",
            { sample_emitter: |emitter, [u, v]| emitter.sample([u * u, v]) }, "radiosity/hidden-below",
            "radiosity/hidden-above"),
        fault!("near-patches-whole", FORM_FACTOR, "near patches of spheres are never divided",
            { is_near: |_, _| false }, "radiosity/sphere"),
        fault!("near-by-length", FORM_FACTOR,
            "patches of spheres are divided by their distance, not by its square",
            { is_near: |area, squared| radiosity::is_near(0.05 * area, squared.sqrt()) },
            "radiosity/sphere"),
        fault!("cosines-squared", FORM_FACTOR, "the cosines between parts of a sphere are squared",
            { cosine: |normal, direction| radiometry::cosine(normal, direction).powi(2) },
            "radiosity/cavity/reflecting", "radiosity/sphere", "radiosity/ball"),
        fault!("sphere-cosine-missing", FORM_FACTOR, "the cosines between parts of a sphere are 1",
            { cosine: |_, _| 1.0 }, "radiosity/sphere"),
        fault!("channels-mixed", RADIOSITY, "each channel is reflected by the next one's albedo",
            { leaving: |albedo, emitted, irradiance| radiosity::leaving(albedo.yzx(), emitted, irradiance) },
            "radiosity/coloured"),
        fault!("emission-exchanged", RADIOSITY,
            "patches send each other what they emit, which was counted as direct light",
            { reflected: |leaving, _| leaving },
            "radiosity/furnace-box", "radiosity/corners", "radiosity/energy"),
        fault!("emission-reflected", RADIOSITY, "the albedo is applied to what a surface emits, too",
            { leaving: |albedo, emitted, irradiance| radiosity::leaving(albedo, albedo * emitted, irradiance) },
            "radiosity/furnace-box"),
        fault!("channels-exchanged", RADIOSITY, "red and blue of the irradiance are exchanged",
            { leaving: |albedo, emitted, irradiance| radiosity::leaving(albedo, emitted, irradiance.zyx()) },
            "radiosity/rectangle"),
        fault!("two-sweeps", RADIOSITY, "the solution ends after two sweeps",
            { has_converged: |_, sweeps| sweeps >= 2 },
            "radiosity/furnace-box", "radiosity/cavity/black", "radiosity/diffuse-room"),
        fault!("exitance-for-radiance", RADIOSITY, "ρE is taken for the radiance, without 1/π",
            { leaving: |albedo, emitted, irradiance| emitted + albedo * irradiance },
            "radiosity/rectangle", "radiosity/skewed", "radiosity/triangle"),
    ]
}
