//! Light that reaches a diffuse surface through a mirror or glass only, where no shadow ray finds
//! it. Whole estimators count it once.

use crate::fresnel::walsh;
use crate::glass::{GLASS, INDEX};
use crate::irradiance::reflected;
use crate::prelude::*;
use crate::scenes::{
    FLOOR, LIGHT, corners, lambert, light, mirror, polygon_irradiance, scene, square,
};
use crate::specular_nee::SPECULAR_NEE;
use crate::strategies::{LIGHT_ANGLE, MIS_ANGLE, near_origin};

const REFLECTANCE: f64 = 0.9;
/// Three segments: from the eye to the patch, to the mirror or glass, to the light.
const REPORT: EstimatorKind = EstimatorKind::Report(3);

/// A light that faces up, below the level of a diffuse patch at the origin, which sees it in a
/// mirror only. The patch is so small that its own mirror image is 1e-6 of the light.
fn light_in_mirror() -> Arc<Scene> {
    scene("light in mirror", |s| {
        square(s, DVec3::ZERO, 1e-3, true, Surface::new(lambert(FLOOR)));
        square(s, -0.2 * DVec3::Z, 6.0, true, light(LIGHT));
        square(
            s,
            0.4 * DVec3::Z,
            50.0,
            false,
            Surface::new(mirror(REFLECTANCE)),
        );
    })
}

/// A diffuse patch under glass that fills all above it, and a light within the glass. A fraction of
/// 1e-6 of the patch's hemisphere passes beside them.
fn light_in_glass() -> Arc<Scene> {
    scene("light in glass", |s| {
        square(s, DVec3::ZERO, 1e-3, true, Surface::new(lambert(FLOOR)));
        square(s, 0.4 * DVec3::Z, 500.0, false, Surface::new(GLASS));
        square(s, 0.6 * DVec3::Z, 500.0, false, light(LIGHT));
    })
}

/// A patch that sees a light through one specular caster only.
struct LitThroughCaster {
    scene: Arc<Scene>,
    /// The way in which the light is seen, in words.
    how: &'static str,
    /// Radiance that the patch reflects.
    reference: f64,
}

pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let family_trial = |name, consequence, lit: &LitThroughCaster, kind, equation, draws| {
        let LitThroughCaster {
            scene,
            how,
            reference,
        } = lit;
        let property =
            format!("a patch reflects {reference:.6} of a light that it sees {how} only");
        radiance(name, equation, scene, kind, near_origin)
            .states(property, consequence)
            .by_draws(*reference, CLOSED_FORM_DELTA, draws)
    };
    let image = polygon_irradiance(&corners(DVec3::Z, 6.0));
    let mirror = LitThroughCaster {
        scene: light_in_mirror(),
        how: "in a mirror",
        reference: REFLECTANCE * reflected(image),
    };
    let glass = LitThroughCaster {
        scene: light_in_glass(),
        how: "through glass",
        // Transmitted radiance, (1 − R)/n² in the thinner medium, averaged over the hemisphere.
        reference: FLOOR * LIGHT * (1.0 - walsh(INDEX)) / (INDEX * INDEX),
    };
    vec![
        family_trial(
            "irradiance/after-mirror/light",
            "light from a mirror is missing where only shadow rays look for lamps",
            &mirror,
            LIGHT_ANGLE,
            &MIS,
            Draws::scrambles(16, 42_000),
        ),
        family_trial(
            "irradiance/after-mirror/mis",
            "light that a mirror throws on a wall is counted twice or lost when path traced",
            &mirror,
            MIS_ANGLE,
            &MIS,
            Draws::scrambles(16, 42_000),
        ),
        family_trial(
            "irradiance/after-mirror/by-bodies",
            "shadow rays by way of a mirror make its spot of light too bright or too dim",
            &mirror,
            SPECULAR_NEE,
            &SPECULAR_SPREAD,
            Draws::scrambles(16, 42_000),
        ),
        family_trial(
            "irradiance/after-mirror/report",
            "light that a mirror throws on a wall is missing by the report's method",
            &mirror,
            REPORT,
            &RENDERING,
            Draws::scrambles(16, 11_000),
        ),
        family_trial(
            "irradiance/after-glass/mis",
            "the shadow of glass is too dark, as light through it is lost when path traced",
            &glass,
            MIS_ANGLE,
            &REFRACTION,
            Draws::scrambles(64, 18_500),
        ),
        family_trial(
            "irradiance/after-glass/report",
            "the shadow of glass is too dark, or light through it too bright, by the report",
            &glass,
            REPORT,
            &RENDERING,
            Draws::scrambles(16, 60_000),
        ),
    ]
}
