//! Surfaces just farther apart than those that a scene refuses because they coincide: each
//! estimator meets the one in front, and shadow rays agree with paths, in either order of the
//! surfaces in the scene.

use whitefurnace::scene::COINCIDENCE_TOLERANCE;

use crate::irradiance::reflected;
use crate::prelude::*;
use crate::scenes::{
    FLOOR, LIGHT, NEAR, ball, corners, floor, lambert, light, mirror, polygon_irradiance, scene,
    square,
};
use crate::specular_nee::{SPECULAR_NEE, add_lens, lens};
use crate::strategies::{LIGHT_ANGLE, MIS_ANGLE, near_origin};

/// Half the side of the largest squares, which is the largest coordinate.
const EXTENT: f64 = 50.0;
/// Distance of the two surfaces.
const GAP: f64 = 1.25 * COINCIDENCE_TOLERANCE * EXTENT;
const REFLECTANCE: f64 = 0.9;
/// Height of the mirror over the patch, and of the light that the patch sees in it.
const MIRROR: f64 = 0.4;
const LAMP: f64 = -0.2;

const BLACK: Surface = Surface {
    bsdf: Bsdf::Black,
    emission: DVec3::ZERO,
    absorption: 0.0,
};

/// Adds the parts in this order, or reversed.
fn in_order(s: &mut SceneBuilder, is_reversed: bool, mut parts: [&dyn Fn(&mut SceneBuilder); 2]) {
    if is_reversed {
        parts.reverse();
    }
    for part in parts {
        part(s);
    }
}

/// Builds a patch at the origin that sees a light only in the mirror above it, and black sheets at
/// distance [`GAP`] from mirror and light: in front of the mirror, or behind both.
fn mirror_with_sheets(covers: bool, is_reversed: bool) -> Arc<Scene> {
    scene("mirror with sheets", |s| {
        square(s, DVec3::ZERO, 1e-3, true, Surface::new(lambert(FLOOR)));
        in_order(
            s,
            is_reversed,
            [
                &|s| {
                    square(s, LAMP * DVec3::Z, 6.0, true, light(LIGHT));
                    square(
                        s,
                        MIRROR * DVec3::Z,
                        EXTENT,
                        false,
                        Surface::new(mirror(REFLECTANCE)),
                    );
                },
                &|s| {
                    square(s, (LAMP - GAP) * DVec3::Z, EXTENT, true, BLACK);
                    let height = if covers { MIRROR - GAP } else { MIRROR + GAP };
                    square(s, height * DVec3::Z, EXTENT, true, BLACK);
                },
            ],
        );
    })
}

/// Builds a light over the floor, covered by a black sheet.
fn covered_light(is_reversed: bool) -> Arc<Scene> {
    scene("covered light", |s| {
        floor(s, lambert(FLOOR));
        let height = NEAR[0].z;
        in_order(
            s,
            is_reversed,
            [
                &|s| square(s, height * DVec3::Z, 2.0, false, light(LIGHT)),
                &|s| {
                    square(s, (height - GAP) * DVec3::Z, 2.0 + 1e-6, false, BLACK);
                },
            ],
        );
    })
}

/// Builds a patch that sees a light only through a ball of glass, enclosed in a black ball.
fn covered_lens(is_reversed: bool) -> Arc<Scene> {
    scene("covered lens", |s| {
        in_order(
            s,
            is_reversed,
            [&|s| add_lens(s), &|s| {
                ball(
                    s,
                    Sphere {
                        radius: 1.0 + GAP,
                        ..lens()
                    },
                    BLACK,
                );
            }],
        );
    })
}

/// No light arrives at the origin from covered surfaces, in either order of the parts.
struct Covered([(&'static str, [Probe; 2]); 5]);

impl Property for Covered {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let n = context.arguments(5_000);
        let outcome = |(name, probes): &(&str, [Probe; 2])| {
            let mut radiances = probes
                .each_ref()
                .map(|probe| probe.radiances(setup, context.seed_of(name)));
            let brightest = (0..n).flat_map(|_| radiances.each_mut().map(|radiance| radiance()));
            let brightest = brightest.fold(0.0, |brightest: f64, radiance| {
                brightest.max(radiance.max_element())
            });
            Outcome::identity(*name, n, brightest, 0.0, "the brightest of all rays")
        };
        self.0.iter().map(outcome).collect()
    }
}

pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let mirror: fn(bool) -> Arc<Scene> = |is_reversed| mirror_with_sheets(true, is_reversed);
    let covered = [
        (
            "light by light",
            covered_light as fn(bool) -> Arc<Scene>,
            LIGHT_ANGLE,
        ),
        ("light by mis", covered_light, MIS_ANGLE),
        ("light by bodies", covered_light, SPECULAR_NEE),
        ("mirror by bodies", mirror, SPECULAR_NEE),
        ("lens by bodies", covered_lens, SPECULAR_NEE),
    ];
    let covered = covered.map(|(name, scene, kind)| {
        (
            name,
            [false, true].map(|is_reversed| Probe {
                scene: scene(is_reversed),
                kind,
                ray: near_origin,
            }),
        )
    });
    let image = polygon_irradiance(&corners((2.0 * MIRROR - LAMP) * DVec3::Z, 6.0));
    let in_mirror = REFLECTANCE * reflected(image);
    vec![
        trial(
            "near-coincident/covered",
            "nothing is seen of a light, mirror or ball of glass just behind another surface",
            "a lamp or mirror just behind a wall shines through it",
            &GEOMETRY,
            "integrator::Path",
"exact",
            with_parts(Covered(covered)),
        ),
        radiance(
            "near-coincident/backed",
            &SPECULAR_SPREAD,
            &mirror_with_sheets(false, true),
            SPECULAR_NEE,
            near_origin,
        )
        .states(
            format!(
                "a patch reflects {in_mirror:.6} of a light in a mirror, whatever is just behind both"
            ),
            "a mirror hung close to a wall, or a lamp close to a ceiling, goes dark",
        )
        .by_scrambles(in_mirror, CLOSED_FORM_DELTA, 32, 12_600),
    ]
}

pub fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("cover-ignored", GEOMETRY, "shadow rays start and end a little off surfaces, and miss what covers them",
            { visible: |scene, x, y, glass| {
                let off = |SurfacePoint { point, normal }: SurfacePoint, other: DVec3| {
                    SurfacePoint::new(point + 1e-4 * normal * normal.dot(other - point).signum(), normal)
                };
                scene.visible(off(x, y.point), off(y, x.point), glass)
            } },
            "near-coincident/covered: light by light | light by mis | light by bodies | mirror by bodies | lens by bodies"),
        fault!("behind-the-body", GEOMETRY, "shadow rays end a little behind what they aim at",
            { visible: |scene, x, SurfacePoint { point, normal }, glass| {
                scene.visible(x, SurfacePoint::new(point - 1e-4 * normal, normal), glass)
            } },
            "near-coincident/backed"),
    ]
}
