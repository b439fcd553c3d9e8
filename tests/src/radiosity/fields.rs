//! Direct light on a floor by every kind of emitter, visible or partly hidden, from near and from
//! both sides, against closed forms of rectangles and quadrature over the light. Neither uses the
//! polygon formula.

use whitefurnace::integrator::radiosity::ReadOut;

use crate::cie::{parallel_corner, upright_corner};
use crate::prelude::*;
use crate::radiosity::{Known, SINGLE_PRECISION, SUBJECT};
use crate::scenes::{
    FLOOR, HEIGHT, LIGHT, TINT, TRIANGLE, ball, floor, half_hidden_light, lambert, light, panel,
    ray_to_origin, ray_to_origin_from, rectangle_light, scene, square, triangle_light,
};

/// Form factor from the origin with the normal z to a flat light: the double integral of cos θ cos
/// θ′/(πd²), by quadrature over `domain` stretched along two edges.
fn by_quadrature(domain: Domain, corner: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let across = a.cross(b);
    let kernel = |p: DVec3| {
        let y = corner + p.x * a + p.y * b;
        let squared = y.length_squared();
        (y.z * -y.dot(across)).max(0.0) / (PI * squared * squared)
    };
    domain.integrate_all(1e-9, &kernel).value
}

/// Returns a ray to the origin from so near that little can come between.
fn ray_from_close_by(_: &mut SampleStream) -> Ray {
    ray_to_origin_from(4e-4)
}

/// Returns a ray to the origin from below.
fn from_below() -> Ray {
    let w = whitefurnace::math::frame::from_spherical(25f64.to_radians(), 4.0).with_z(-0.9);
    let w = w.normalize();
    Ray::new(0.1 * w, -w)
}

/// Returns a trial of the radiance that a floor reflects along each kind of ray, given with the
/// form factor F of a light of radiance [`LIGHT`].
fn family_trial(
    name: &str,
    consequence: &str,
    what: &str,
    scene: Arc<Scene>,
    rays: &[(Rays, f64)],
    tolerance: f64,
) -> FamilyTrial<EstimatorSubject> {
    let radiance = |factor: f64| FLOOR * LIGHT * factor;
    let seen: Vec<String> = rays
        .iter()
        .map(|(_, factor)| format!("{:.6}", radiance(*factor)))
        .collect();
    let property = format!("a floor reflects {} of {what}", seen.join(" and "));
    let coloured = |&(ray, factor): &(Rays, f64)| (ray, radiance(factor) * TINT);
    let known = Known {
        scene,
        patches: 4,
        rays: rays.iter().map(coloured).collect(),
        tolerance,
        read_out: ReadOut::default(),
    };
    trial(
        name,
        property,
        consequence,
        &FORM_FACTOR,
        SUBJECT,
        "exact",
        with_parts(known),
    )
}

/// Returns a trial along one ray to the floor's origin.
fn lit(
    name: &str,
    consequence: &str,
    what: &str,
    scene: Arc<Scene>,
    factor: f64,
    tolerance: f64,
) -> FamilyTrial<EstimatorSubject> {
    family_trial(
        name,
        consequence,
        what,
        scene,
        &[(|_| ray_to_origin(), factor)],
        tolerance,
    )
}

pub(super) fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    [rectangles(), kinds(), hidden(), vec![both_sides()]]
        .into_iter()
        .flatten()
        .collect()
}

fn rectangles() -> Vec<FamilyTrial<EstimatorSubject>> {
    let upright = scene("light that sinks below the horizon", |s| {
        floor(s, lambert(FLOOR));
        let edges = [2.0 * DVec3::Z, 2.0 * DVec3::Y];
        panel(s, DVec3::new(1.0, -1.0, -1.0), edges, light(LIGHT));
    });
    let (gap, side) = (1e-3, 0.3);
    let close = scene("light just over the floor", |s| {
        floor(s, lambert(FLOOR));
        square(
            s,
            DVec3::new(1.0 - side, 0.0, gap),
            1.0,
            false,
            light(LIGHT),
        );
    });
    let beside = parallel_corner(side, 1.0, gap) + parallel_corner(2.0 - side, 1.0, gap);
    vec![
        lit(
            "radiosity/rectangle",
            "a floor under a panel lamp is too bright or too dark by radiosity",
            "a square light's radiance",
            rectangle_light(false),
            4.0 * parallel_corner(1.0, 1.0, HEIGHT),
            SINGLE_PRECISION,
        ),
        lit(
            "radiosity/half-hidden",
            "radiosity makes the soft shadow of a wall too dark or too light",
            "a square light that a wall hides by half",
            half_hidden_light(),
            2.0 * parallel_corner(1.0, 1.0, HEIGHT),
            IMAGE_DELTA,
        ),
        lit(
            "radiosity/horizon",
            "lamps half below a floor's horizon darken it, or light it too much, by radiosity",
            "an upright light of which half is below the horizon",
            upright,
            2.0 * upright_corner(1.0, 1.0, 1.0),
            SINGLE_PRECISION,
        ),
        family_trial(
            "radiosity/close",
            "things close to a lamp are too bright or too dark by radiosity",
            "a light a two-thousandth of its side away",
            close,
            &[(ray_from_close_by, 2.0 * beside)],
            SINGLE_PRECISION,
        ),
    ]
}

/// Trials of other kinds of emitters.
fn kinds() -> Vec<FamilyTrial<EstimatorSubject>> {
    let corner = DVec3::new(0.4, -0.7, 1.1);
    let edges = [DVec3::new(0.3, 1.2, 0.5), DVec3::new(0.9, 0.4, -0.2)];
    let skewed = scene("skewed light", |s| {
        floor(s, lambert(FLOOR));
        panel(s, corner, edges, light(LIGHT));
    });
    let [a, b, c] = TRIANGLE;
    let triangle = by_quadrature(Domain::Triangle, a, [b - a, c - a]);
    let (sin, cos) = 40f64.to_radians().sin_cos();
    let (radius, distance) = (0.8, 1.25);
    let sphere = scene("sphere beside and above", |s| {
        square(s, DVec3::ZERO, 0.3, true, Surface::new(lambert(FLOOR)));
        ball(
            s,
            Sphere::new(distance * DVec3::new(sin, 0.0, cos), radius),
            light(LIGHT),
        );
    });
    let share = radius / distance;
    vec![
        lit(
            "radiosity/skewed",
            "radiosity takes a slanted, skewed panel for a rectangle: its light is off",
            "a skewed parallelogram of light",
            skewed,
            by_quadrature(Domain::Square, corner, edges),
            SINGLE_PRECISION,
        ),
        lit(
            "radiosity/triangle",
            "mesh lamps light a floor by a wrong amount by radiosity",
            "a triangle of light",
            triangle_light(),
            triangle,
            SINGLE_PRECISION,
        ),
        family_trial(
            "radiosity/sphere",
            "globe lamps near a wall are blotchy or too bright by radiosity",
            "a sphere of light nearer than its patches are wide",
            sphere,
            &[(ray_from_close_by, share * share * cos)],
            COARSE,
        ),
    ]
}

/// Tolerance of the light of a sphere's near patches.
const COARSE: f64 = 0.005;

/// Trials of an upright light, partly hidden by an upright wall half way: below, above or to one
/// side. The hidden part is weighted by its cosine at the floor, which grows with height.
fn hidden() -> Vec<FamilyTrial<EstimatorSubject>> {
    let [width, height] = [2.0 * DVec3::Y, 2.0 * DVec3::Z];
    let corner = DVec3::new(1.0, -1.0, 0.0);
    let all = 2.0 * upright_corner(2.0, 1.0, 1.0);
    let lower = 2.0 * upright_corner(1.0, 1.0, 1.0);
    let aside = upright_corner(2.0, 1.0, 1.0) - upright_corner(2.0, 0.5, 1.0);
    [
        (
            "radiosity/hidden-below",
            "a low obstacle casts too strong a shadow by radiosity",
            "lower half",
            [-0.6, -0.5],
            [1.2, 1.0],
            all - lower,
        ),
        (
            "radiosity/hidden-above",
            "a high obstacle casts too weak a shadow by radiosity",
            "upper half",
            [-0.6, 0.5],
            [1.2, 0.8],
            lower,
        ),
        (
            "radiosity/hidden-aside",
            "an obstacle at a lamp's side casts no shadow, or too large a one, by radiosity",
            "last quarter",
            [0.25, -0.5],
            [0.8, 1.8],
            all - aside,
        ),
    ]
    .into_iter()
    .map(|(name, consequence, part, [y, z], [wide, high], factor)| {
        let scene = scene(name, |s| {
            floor(s, lambert(FLOOR));
            panel(s, corner, [height, width], light(LIGHT));
            // The floor hides the part of the wall below it.
            let edges = [wide * DVec3::Y, high * DVec3::Z];
            panel(s, DVec3::new(0.5, y, z), edges, Surface::new(Bsdf::Black));
        });
        let what = format!("an upright light of which a wall hides the {part}");
        lit(name, consequence, &what, scene, factor, IMAGE_DELTA)
    })
    .collect()
}

/// Trial of a floor between two lights, each of which it reflects on its own side.
fn both_sides() -> FamilyTrial<EstimatorSubject> {
    let scene = scene("lights above and below", |s| {
        square(s, DVec3::ZERO, 0.2, true, Surface::new(lambert(FLOOR)));
        square(s, DVec3::new(0.5, 0.5, 1.0), 0.5, false, light(LIGHT));
        square(s, DVec3::new(-1.0, 0.5, -0.8), 0.5, true, light(LIGHT));
    });
    let above = parallel_corner(1.0, 1.0, 1.0);
    let below = parallel_corner(1.5, 1.0, 0.8) - parallel_corner(0.5, 1.0, 0.8);
    let rays = [
        ((|_| ray_to_origin()) as Rays, above),
        (|_| from_below(), below),
    ];
    family_trial(
        "radiosity/both-sides",
        "thin walls lit from behind are bright in front by radiosity",
        "a light above and of another below",
        scene,
        &rays,
        SINGLE_PRECISION,
    )
}
