//! Rooms in the manner of CIE 171:2006 (test cases to assess the accuracy of lighting computer
//! programs), with closed forms derived here: a luminous rectangle over a floor and beside a wall,
//! a roof opening and a window under a uniform sky, an obstruction before the window. The CIE
//! overcast sky is in the module `environment_map`.

use crate::prelude::*;
use crate::scenes::{FLOOR, LIGHT, floor, lambert, light, panel, scene};

/// Form factor from a point to a rectangle of sides `a` and `b` in a parallel plane at distance
/// `c`, one corner of which is on the point's normal: ∫∫ c²/(π(x² + y² + c²)²) dx dy by elementary
/// integration.
pub fn parallel_corner(a: f64, b: f64, c: f64) -> f64 {
    let part = |a: f64, b: f64| {
        let r = a.hypot(c);
        a / r * (b / r).atan()
    };
    (part(a, b) + part(b, a)) / TAU
}

/// Form factor from a point to an upright rectangle of width `b` and height `a` at distance `c`,
/// whose lower edge is in the point's own plane and one lower corner at the foot of the
/// perpendicular: ∫∫ cz/(π(c² + y² + z²)²) dy dz by elementary integration.
pub fn upright_corner(a: f64, b: f64, c: f64) -> f64 {
    let r = a.hypot(c);
    ((b / c).atan() - c / r * (b / r).atan()) / TAU
}

/// Extends a quantity of rectangles with one corner at the origin, odd in each side, to rectangles
/// anywhere: `x` and `y` are the ranges of its sides.
fn sum_over_corners(
    [x0, x1]: [f64; 2],
    [y0, y1]: [f64; 2],
    corner: impl Fn(f64, f64) -> f64,
) -> f64 {
    let odd = |x: f64, y: f64| corner(x.abs(), y.abs()) * x.signum() * y.signum();
    odd(x1, y1) - odd(x0, y1) - odd(x1, y0) + odd(x0, y0)
}

/// Returns a ray to a point of a surface from 25° off its normal.
fn ray_to(point: DVec3, normal: DVec3) -> Ray {
    let aside = normal.any_orthonormal_vector();
    let (sin, cos) = 25f64.to_radians().sin_cos();
    let w = cos * normal + sin * aside;
    Ray::new(point + 0.1 * w, -w)
}

const CEILING: f64 = 3.0;
/// Ranges in x and y of the luminous rectangle in the ceiling; the receivers are below and beside
/// it.
const PANEL: [[f64; 2]; 2] = [[0.3, 2.3], [-0.4, 1.2]];

/// Builds the luminous rectangle and a diffuse rectangle that it illuminates.
fn lit(name: &str, corner: DVec3, edges: [DVec3; 2]) -> Arc<Scene> {
    scene(name, |s| {
        panel(s, corner, edges, Surface::new(lambert(FLOOR)));
        let [[x0, x1], [y0, y1]] = PANEL;
        let edges = [(y1 - y0) * DVec3::Y, (x1 - x0) * DVec3::X];
        panel(s, DVec3::new(x0, y0, CEILING), edges, light(LIGHT));
    })
}

/// Height of the opening over the floor: low, so that much of the sky is visible.
const SILL: f64 = 0.5;
/// Half width of the openings.
const HALF: f64 = 1.2;

/// Adds a black sheet in the plane z = `height` with a square opening around the z axis.
fn sheet(s: &mut SceneBuilder, height: f64) {
    const FAR: f64 = 50.0;
    const REST: f64 = FAR - HALF;
    for (corner, [x, y]) in [
        ([-FAR, -FAR], [2.0 * FAR, REST]),
        ([-FAR, HALF], [2.0 * FAR, REST]),
        ([-FAR, -HALF], [REST, 2.0 * HALF]),
        ([HALF, -HALF], [REST, 2.0 * HALF]),
    ] {
        let corner = DVec3::new(corner[0], corner[1], height);
        let edges = [x * DVec3::X, y * DVec3::Y];
        panel(s, corner, edges, Surface::new(Bsdf::Black));
    }
}

/// Height of the obstruction over the floor, and the x at which it ends.
const OBSTRUCTION: [f64; 2] = [4.0, -3.0];

/// Builds a floor below a roof with a square opening under a sky of radiance 1; beyond the opening
/// a black half plane, if `obstructed`.
fn roof(name: &str, obstructed: bool) -> Arc<Scene> {
    scene(name, |s| {
        s.background(DVec3::ONE);
        floor(s, lambert(FLOOR));
        sheet(s, SILL);
        if obstructed {
            let [height, edge] = OBSTRUCTION;
            let corner = DVec3::new(-100.0, -100.0, height);
            panel(
                s,
                corner,
                [(edge + 100.0) * DVec3::X, 200.0 * DVec3::Y],
                Surface::new(Bsdf::Black),
            );
        }
    })
}

pub(crate) fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let family_trial =
        |name, consequence, what: &str, scene: &Arc<Scene>, ray: Rays, l, f: f64, draws| {
            let reference = FLOOR * l * f;
            let property = format!("{what}: F = {f:.6}, and {reference:.6} is reflected");
            radiance(name, &GEOMETRY, scene, EstimatorKind::Path, ray)
                .states(property, consequence)
                .by_draws(reference, CLOSED_FORM_DELTA, draws)
        };
    let [x, y] = PANEL;
    let whole = [-HALF, HALF];
    // The obstruction's edge, projected from the origin onto the plane of the opening.
    let [height, edge] = OBSTRUCTION;
    let shadow = edge * SILL / height;
    let opening = |x| sum_over_corners(x, whole, |a, b| parallel_corner(a, b, SILL));
    vec![
        family_trial(
            "cie/panel-floor",
            "a plan for ceiling panels gives a desk too many or too few lux",
            "a luminous rectangle over a floor",
            &lit(
                "luminous panel over a floor",
                DVec3::new(0.0, -4.0, 0.0),
                [4.0 * DVec3::X, 8.0 * DVec3::Y],
            ),
            |_| ray_to(DVec3::new(1.0, 0.0, 0.0), DVec3::Z),
            LIGHT,
            sum_over_corners([x[0] - 1.0, x[1] - 1.0], y, |a, b| {
                parallel_corner(a, b, CEILING)
            }),
            Draws::scrambles(32, 12_500),
        ),
        family_trial(
            "cie/panel-wall",
            "a plan for lit panels beside a wall gives it too many or too few lux",
            "a luminous rectangle beside a wall",
            &lit(
                "luminous panel beside a wall",
                DVec3::new(0.0, -4.0, 0.0),
                [8.0 * DVec3::Y, CEILING * DVec3::Z],
            ),
            |_| ray_to(DVec3::new(0.0, 0.0, 1.5), DVec3::X),
            LIGHT,
            sum_over_corners(x, y, |a, b| upright_corner(a, b, CEILING - 1.5)),
            Draws::scrambles(32, 18_600),
        ),
        family_trial(
            "cie/roof-opening",
            "a daylight study lets too much or too little sky in through a skylight",
            "a roof opening under a uniform sky",
            &roof("roof opening", false),
            |_| ray_to(DVec3::ZERO, DVec3::Z),
            1.0,
            opening(whole),
            Draws::scrambles(32, 17_800),
        ),
        family_trial(
            "cie/obstruction",
            "a daylight study ignores the house before the window, or counts it twice",
            "an opening before which an obstruction hides a part of a uniform sky",
            &roof("obstructed roof opening", true),
            |_| ray_to(DVec3::ZERO, DVec3::Z),
            1.0,
            opening([shadow, HALF]),
            Draws::scrambles(64, 19_000),
        ),
    ]
}
