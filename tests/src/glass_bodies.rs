//! Glass bodies with known answers: a slab with all its internal reflections, a prism that turns
//! light by total reflection, a sphere of index 1, which must not be visible.

use crate::glass::{GLASS, INDEX, reflectance_by_angles};
use crate::mean_radiance::any_direction;
use crate::prelude::*;
use crate::scenes::{LIGHT, ball, floor, light, panel, ray_to_origin_at, scene, square};

/// A slab of glass over a ground that emits 1.
fn slab() -> Arc<Scene> {
    scene("glass slab", |s| {
        floor(s, GLASS);
        square(s, -0.5 * DVec3::Z, 50.0, false, Surface::new(GLASS));
        square(s, -3.0 * DVec3::Z, 50.0, true, light(1.0));
    })
}

/// A prism over the right isosceles triangle (0, 0), (1, 0), (0, 1) of the xz plane, and a light
/// below its lower leg: a ray along x meets the hypotenuse at 45° from within and is turned down.
fn prism() -> Arc<Scene> {
    scene("glass prism", |s| {
        let [x, y, z] = [DVec3::X, 2.0 * DVec3::Y, DVec3::Z];
        let start = -DVec3::Y;
        for (corner, edges) in [(start, [z, y]), (start, [y, x]), (start + x, [y, z - x])] {
            panel(s, corner, edges, Surface::new(GLASS));
        }
        square(s, DVec3::new(0.6, 0.0, -1.0), 0.2, true, light(LIGHT));
    })
}

/// Black surfaces that emit, with or without a sphere of index 1 before them.
fn lights(sphere: bool) -> Arc<Scene> {
    scene("lights", |s| {
        for (i, radiance) in [1.0, 2.0, 4.0].into_iter().enumerate() {
            let centre = DVec3::new(i as f64 - 1.0, 0.0, -2.0);
            square(s, centre, 0.4, true, light(radiance));
        }
        if sphere {
            ball(
                s,
                Sphere::new(DVec3::ZERO, 1.0),
                Surface::new(Bsdf::Glass { index: 1.0 }),
            );
        }
    })
}

/// With and without the sphere of index 1 every ray finds the same radiance.
struct Vanishing {
    scenes: [Arc<Scene>; 2],
}

const RAYS: u64 = 2_000;

impl Property for Vanishing {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let mut rng = context.rng("rays");
        let mut worst = 0.0_f64;
        for _ in 0..RAYS {
            let aim = 0.9 * any_direction(&mut rng);
            let origin = DVec3::new(0.2, -0.3, 3.0);
            let ray = Ray::new(origin, (aim - origin).normalize());
            let [with, without] = [0, 1].map(|i| {
                EstimatorKind::Whitted(5).radiance(setup, &self.scenes[i], &ray, &mut rng)
            });
            worst = worst.max((with - without).abs().max_element());
        }
        vec![Outcome::identity(
            "difference",
            RAYS,
            worst,
            1e-12,
            "the worst ray",
        )]
    }
}

pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let r = reflectance_by_angles(60f64.to_radians(), 1.0, INDEX);
    let r0 = ((INDEX - 1.0) / (INDEX + 1.0)).powi(2);
    let through = |r: f64| (1.0 - r) / (1.0 + r);
    vec![
        radiance("glass/slab", &FRESNEL, &slab(), EstimatorKind::Path, |_| {
            ray_to_origin_at(60f64.to_radians())
        })
        .states(
            format!(
                "a slab lets (1 − R)/(1 + R) = {:.6} of unpolarised light through at 60°, R taken \
                 anew for light without polarisation at each face, as (12) has it",
                through(r)
            ),
            "a window pane seen at a slant is too dark or too clear",
        )
        .by_scrambles(through(r), CLOSED_FORM_DELTA, 64, 17_000),
        radiance(
            "glass/prism",
            &FRESNEL,
            &prism(),
            EstimatorKind::Path,
            |_| Ray::new(DVec3::new(-1.0, 0.0, 0.4), DVec3::X),
        )
        .states(
            format!(
                "a prism turns light by 90° and lets (1 − R)/(1 + R) = {:.6} through its legs",
                through(r0)
            ),
            "the view through a prism or a periscope is too dark or in the wrong place",
        )
        .by_scrambles(through(r0) * LIGHT, CLOSED_FORM_DELTA, 64, 13_500),
        trial(
            "glass/vanishing",
            "a sphere of index 1 before lights leaves the image as it is",
            "a body of the index of air, which should be invisible, shows as an outline",
            &REFRACTION,
            "integrator::Whitted",
            "exact",
            with_parts(Vanishing {
                scenes: [lights(true), lights(false)],
            }),
        ),
    ]
}
