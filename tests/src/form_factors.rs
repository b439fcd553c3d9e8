//! Form factors of finite squares, by whole estimators: rays to points uniform on a reflecting
//! square, illuminated by a square light of radiance L, see ρ L F on average.

use whitefurnace::math::frame::from_spherical;

use crate::prelude::*;
use crate::scenes::{FLOOR, LIGHT, lambert, light, panel, scene, square};

/// Form factor between two equal parallel rectangles of sides x and y opposite each other at
/// distance 1 (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11).
pub fn parallel(x: f64, y: f64) -> f64 {
    let [x2, y2] = [1.0 + x * x, 1.0 + y * y];
    let logarithm = 0.5 * (x2 * y2 / (x2 + y * y)).ln();
    let far = |a: f64, root: f64| a * root * (a / root).atan();
    let near = |a: f64| a * a.atan();
    2.0 / (PI * x * y) * (logarithm + far(x, y2.sqrt()) + far(y, x2.sqrt()) - near(x) - near(y))
}

/// Form factor from a rectangle of width w to one of height h at right angles to it, with a common
/// edge of length 1 (Howell, C-14).
pub fn perpendicular(h: f64, w: f64) -> f64 {
    let [h2, w2] = [h * h, w * w];
    let (sum, all) = (h2 + w2, 1.0 + h2 + w2);
    let logarithm = |a2: f64| (a2 * all / ((1.0 + a2) * sum)).ln();
    let logarithms = ((1.0 + w2) * (1.0 + h2) / all).ln() + w2 * logarithm(w2) + h2 * logarithm(h2);
    let angle = |a: f64| a * (1.0 / a).atan();
    (angle(w) + angle(h) - angle(sum.sqrt()) + 0.25 * logarithms) * FRAC_1_PI / w
}

/// Builds the reflecting square [0, 1]² at z = 0, its front up, and a light.
fn lit(name: &str, light: impl FnOnce(&mut SceneBuilder)) -> Arc<Scene> {
    scene(name, |s| {
        square(
            s,
            DVec3::new(0.5, 0.5, 0.0),
            0.5,
            true,
            Surface::new(lambert(FLOOR)),
        );
        light(s);
    })
}

/// Samples a ray to a point uniform on the reflecting square, from the side on which no light is in
/// the way.
fn ray_to_square(rng: &mut SampleStream) -> Ray {
    let [x, y] = uniform2(rng);
    let w = from_spherical(0.5, 0.3);
    Ray::new(DVec3::new(x, y, 0.0) + 0.5 * w, -w)
}

pub(crate) fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let opposite = lit("parallel squares", |s| {
        square(s, DVec3::new(0.5, 0.5, 1.0), 0.5, false, light(LIGHT));
    });
    let upright = lit("perpendicular squares", |s| {
        panel(s, DVec3::ZERO, [DVec3::Y, DVec3::Z], light(LIGHT));
    });
    let family_trial = |name, consequence, how: &str, scene, factor: f64, scrambles| {
        let property = format!("the form factor between {how} unit squares is {factor:.6}");
        let reference = FLOOR * LIGHT * factor;
        radiance(
            name,
            &GEOMETRY,
            scene,
            EstimatorKind::Path,
            ray_to_square as Rays,
        )
        .states(property, consequence)
        .by_scrambles(reference, CLOSED_FORM_DELTA, 64, scrambles)
    };
    vec![
        family_trial(
            "irradiance/parallel-squares",
            "a luminous ceiling lights the floor opposite by a wrong amount",
            "opposite",
            &opposite,
            parallel(1.0, 1.0),
            40_000,
        ),
        // Shadow rays alone would have infinite variance at the common edge; the weights of
        // multiple importance sampling bound every value.
        family_trial(
            "irradiance/perpendicular-squares",
            "a luminous wall is too bright or dark on the floor along their common edge",
            "perpendicular, adjacent",
            &upright,
            perpendicular(1.0, 1.0),
            240_000,
        ),
    ]
}
