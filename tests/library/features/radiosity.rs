//! Radiosity where any two features of diffuse scenes meet.

use whitefurnace::integrator::radiosity::MeshResolution;

use super::*;

/// Materials that radiosity handles; with black ones there would be no closed form, and many more
/// rays were needed.
pub const MATERIALS: &[&str] = &["lambert", "absorbing"];
/// Emitters that radiosity handles.
pub const EMISSIONS: &[&str] = &["black", "lambert"];
/// Patches of all surfaces together, most of which are those of the closed background.
const PATCHES: u32 = 80;
/// A few rays, as all radiances are 1.
const RAYS: [u32; 2] = [9, 5];
/// Largest relative error by so coarse a mesh, twice the largest measured.
const MARGIN: f64 = 0.1;

/// Returns whether radiosity handles a row, and all its light.
pub fn supports_radiosity(row: &Row) -> bool {
    row.get("background").starts_with("closed")
        && ["a material", "b material", "c material"]
            .iter()
            .all(|of| MATERIALS.contains(&row.get(of)))
        && EMISSIONS.contains(&row.get("emission"))
        && row.is("caster", "none")
        && row.is("nesting", "none")
        && row.is("eye", "outside")
}

#[test]
fn radiosity_is_right_where_any_two_features_meet() {
    assert_right(
        "radiosity",
        &SCENE,
        supports_radiosity,
        |row, scene, seed| {
            let resolution = MeshResolution {
                patches: PATCHES,
                halvings: 0,
            };
            let estimator = Radiosity::new(DefaultParts, scene, resolution, &|_| true);
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
