//! Radiosity where any two features of diffuse scenes meet.

use super::scenes::{EMITTERS, SHAPES};
use super::*;

/// Materials that radiosity handles; with black ones there would be no closed form, and many more
/// rays were needed.
const MATERIALS: &[&str] = &["lambert", "absorbing"];
/// Factors of scenes at the levels that radiosity handles, without a background, which it ignores.
pub const DIFFUSE: [Factor; 11] = [
    ("a shape", SHAPES),
    ("a material", MATERIALS),
    ("b shape", SHAPES),
    ("b material", MATERIALS),
    ("c material", MATERIALS),
    ("emitter", EMITTERS),
    ("emission", &["black", "lambert"]),
    ("background", &["closed sphere", "closed box"]),
    ("caster", &["none"]),
    ("nesting", &["none"]),
    ("eye", &["outside"]),
];
/// Patches of all surfaces together, most of which are those of the closed background.
const PATCHES: u32 = 80;
/// A few rays, as all radiances are 1.
const RAYS: [u32; 2] = [9, 5];
/// Largest relative error by so coarse a mesh, twice the largest measured.
const MARGIN: f64 = 0.015;

#[test]
fn radiosity_is_right_where_any_two_features_meet() {
    assert_right(
        "radiosity",
        &DIFFUSE,
        |_| true,
        |row, scene, seed| {
            let resolution = resolution(PATCHES, 0);
            let estimator = Radiosity::new(Parts::default(), scene, resolution, &|_| true);
            let renderer = RayRenderer {
                estimator: estimator.expect("a solution"),
                sampling: sampling_of(row, seed),
            };
            let measured = Measured {
                bias: MARGIN,
                ..by_pixel(&film_of(RAYS, scene, &renderer, 2))
            };
            (None, measured)
        },
    );
}
