//! Tests of solid angles of emitters, and of points and pdfs when they are sampled by solid angle.

use whitefurnace::geometry::solid_angle::{
    MIN_SOLID_ANGLE, SphericalRectangle, SphericalTriangle, VisibleCap,
};

use crate::prelude::*;

const TRIES: usize = 2000;

/// Returns random emitters of each shape, some large and near, some small and far, each with a
/// point in front of it.
fn cases(name: &str) -> Vec<(Emitter, DVec3)> {
    let mut rng = rng(name);
    let mut cases = Vec::new();
    for _ in 0..TRIES {
        let from = in_cube(&mut rng, 3.0);
        let size = 10f64.powf(between(&mut rng, -2.0, 1.0));
        let [corner, x] = [in_cube(&mut rng, 3.0), size * unit_vector(&mut rng)];
        let y = between(&mut rng, 0.2, 2.0) * x.cross(unit_vector(&mut rng));
        let before = |normal: DVec3| normal.dot(from - corner) > 0.0;
        let edges = if before(x.cross(y)) { [x, y] } else { [y, x] };
        let slanted = y + between(&mut rng, -0.5, 0.5) * x;
        let [b, c] = if before(x.cross(slanted)) {
            [x, slanted]
        } else {
            [slanted, x]
        };
        let sphere = Sphere::new(
            from + (size * between(&mut rng, 1.001, 20.0)) * unit_vector(&mut rng),
            size,
        );
        for shape in [
            EmitterShape::Rectangle { corner, edges },
            EmitterShape::Triangle([corner, corner + b, corner + c]),
            EmitterShape::Sphere(sphere),
        ] {
            cases.push((Emitter::new(shape, DVec3::ONE), from));
        }
    }
    cases
}

/// Returns the solid angle of a triangle of unit vectors: tan(Ω/2) by Van Oosterom and Strackee,
/// 1983.
fn triangle([a, b, c]: [DVec3; 3]) -> f64 {
    2.0 * a
        .dot(b.cross(c))
        .abs()
        .atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// Computes the solid angle in another way: from triangles, or as 2π(1 − cos θ).
fn reference(emitter: &Emitter, from: DVec3) -> f64 {
    match emitter.shape {
        EmitterShape::Rectangle {
            corner,
            edges: [x, y],
        } => {
            let [a, b, c, d] =
                [corner, corner + x, corner + x + y, corner + y].map(|v| (v - from).normalize());
            triangle([a, b, c]) + triangle([a, c, d])
        }
        EmitterShape::Triangle(vertices) => triangle(vertices.map(|v| (v - from).normalize())),
        EmitterShape::Sphere(Sphere { centre, radius, .. }) => {
            TAU * (1.0 - (radius / centre.distance(from)).asin().cos())
        }
    }
}

#[test]
fn solid_angle_is_the_closed_form_and_the_pdf_its_inverse() {
    let mut seen = 0;
    for (emitter, from) in cases("solid angle") {
        let reference = reference(&emitter, from);
        let Some(view) = emitter.solid_angle_shape(from) else {
            assert!(
                reference < 1.01 * MIN_SOLID_ANGLE,
                "{emitter:?} from {from} has {reference}"
            );
            continue;
        };
        seen += 1;
        // The arc sine of R/d near 1 and angles between nearly coincident planes lose half of the
        // digits.
        assert_abs_diff_eq!(
            view.solid_angle(),
            reference,
            epsilon = 1e-6 * reference.max(1e-2)
        );
        let pdf = emitter.pdf_solid_angle(from).expect("visible");
        assert_relative_eq!(pdf, 1.0 / view.solid_angle(), max_relative = 1e-15);
        assert_eq!(
            pdf,
            emitter
                .sample_solid_angle(from, [0.3, 0.6])
                .expect("visible")
                .1
        );
    }
    assert!(2 * seen > 3 * TRIES, "only {seen} are visible");
}

#[test]
fn points_lie_on_the_emitter_and_its_front_is_seen() {
    for (emitter, from) in cases("points") {
        let Some(view) = emitter.solid_angle_shape(from) else {
            continue;
        };
        for random in [
            [0.0, 0.0],
            [0.5, 0.5],
            [1.0 - f64::EPSILON, 1.0 - f64::EPSILON],
            [0.9, 0.1],
        ] {
            let (light, _) = emitter.sample_solid_angle(from, random).expect("visible");
            assert_eq!(light.point, view.sample(random));
            assert!(
                light.point.is_finite(),
                "{emitter:?} from {from} at {random:?}"
            );
            let scale = light.point.length() + from.length() + emitter.area.sqrt();
            let height = light.normal.dot(from - light.point);
            assert!(
                height > -1e-12 * scale,
                "{emitter:?} from {from} at {random:?}: {height}"
            );
            let (off, [u, v]) = match emitter.shape {
                EmitterShape::Rectangle { corner, edges } => {
                    let p = light.point - corner;
                    (
                        p.dot(light.normal),
                        edges.map(|e| e.dot(p) / e.length_squared()),
                    )
                }
                EmitterShape::Triangle([a, b, c]) => {
                    let (p, n) = (light.point - a, (b - a).cross(c - a));
                    let share = |x: DVec3, y: DVec3| x.cross(y).dot(n) / n.length_squared();
                    let [u, v] = [share(p, c - a), share(b - a, p)];
                    (p.dot(light.normal), [u, u + v])
                }
                EmitterShape::Sphere(sphere) => (
                    light.point.distance(sphere.centre) - sphere.radius,
                    [0.5; 2],
                ),
            };
            assert!(off.abs() < 1e-14 * scale, "{off} off {emitter:?}");
            let inside = -1e-11..1.0 + 1e-11;
            assert!(
                inside.contains(&u) && inside.contains(&v),
                "{emitter:?}: {u}, {v}"
            );
        }
    }
}

/// Estimates the ratio of areas of a map from the square into space, by central differences.
fn area_ratio(map: impl Fn([f64; 2]) -> DVec3, [r1, r2]: [f64; 2]) -> f64 {
    const STEP: f64 = 1.0 / 131_072.0;
    let d1 = map([r1 + STEP, r2]) - map([r1 - STEP, r2]);
    let d2 = map([r1, r2 + STEP]) - map([r1, r2 - STEP]);
    d1.cross(d2).length() / (4.0 * STEP * STEP)
}

/// The map from the unit square to directions has the same ratio of areas everywhere: the solid
/// angle.
#[test]
fn directions_are_uniform_in_solid_angle() {
    let mut rng = rng("uniform");
    for (emitter, from) in cases("uniform") {
        let Some(view) = emitter
            .solid_angle_shape(from)
            .filter(|view| view.solid_angle() > 1e-2)
        else {
            continue;
        };
        let random = [between(&mut rng, 0.1, 0.9), between(&mut rng, 0.1, 0.9)];
        let ratio = area_ratio(|r| (view.sample(r) - from).normalize(), random);
        // Central differences: third derivatives grow as a point nears the plane of the shape.
        let grazing = 1.0 / (2.0 * PI - view.solid_angle()).max(1e-3);
        assert_relative_eq!(
            ratio,
            view.solid_angle(),
            max_relative = 1e-6 * grazing.powi(3).max(1.0)
        );
    }
}

#[test]
fn far_and_small_shapes_keep_their_digits() {
    // Ω = A cos θ/d² to the relative order (size/d)².
    for size in [1e-2, 3e-3] {
        let from = DVec3::new(0.3, 0.4, 0.0);
        let corner = from + DVec3::Z - 0.5 * size * (DVec3::X + DVec3::Y);
        let edges = [size * DVec3::Y, size * DVec3::X];
        let rectangle = SphericalRectangle::new(from, corner, edges).expect("in front");
        let vertices = [corner, corner + edges[0], corner + edges[1]];
        let triangle = SphericalTriangle::new(from, vertices).expect("in front");
        let cap = VisibleCap::new(from, &Sphere::new(from + DVec3::Z, size)).expect("outside");
        let second_order = 2.0 * size * size;
        let area = size * size;
        assert_relative_eq!(rectangle.solid_angle, area, max_relative = second_order);
        assert_relative_eq!(
            triangle.solid_angle,
            0.5 * area,
            max_relative = second_order
        );
        assert_relative_eq!(cap.solid_angle, PI * area, max_relative = second_order);
        // From its axis, a rectangle has twice the solid angle of its half, a triangle.
        assert_relative_eq!(
            rectangle.solid_angle,
            2.0 * triangle.solid_angle,
            max_relative = 1e-11
        );
    }
}

/// Checks [`whitefurnace::equation::SOLID_ANGLE`] and its kin where the value is a simple fraction
/// of the sphere.
#[test]
fn exact_values() {
    // A face of a cube from its centre, an octant, a sphere that touches a cone of 60°.
    let corner = DVec3::new(-1.0, -1.0, 1.0);
    let face = SphericalRectangle::new(DVec3::ZERO, corner, [2.0 * DVec3::Y, 2.0 * DVec3::X]);
    assert_relative_eq!(
        face.expect("in front").solid_angle,
        TAU / 3.0,
        max_relative = 1e-15
    );
    let octant = SphericalTriangle::new(DVec3::ZERO, [DVec3::X, DVec3::Z, DVec3::Y]);
    assert_relative_eq!(
        octant.expect("in front").solid_angle,
        PI / 2.0,
        max_relative = 1e-15
    );
    let cap = VisibleCap::new(DVec3::ZERO, &Sphere::new(2.0 * DVec3::Z, 3f64.sqrt()));
    assert_relative_eq!(cap.expect("outside").solid_angle, PI, max_relative = 1e-15);
}

#[test]
fn what_cannot_be_sampled_says_so() {
    let rectangle = |from, edges| SphericalRectangle::new(from, DVec3::ZERO, edges).is_some();
    let edges = [DVec3::X, DVec3::Y];
    assert!(rectangle(DVec3::Z, edges));
    assert!(!rectangle(-DVec3::Z, edges), "from behind");
    assert!(!rectangle(2.0 * DVec3::X, edges), "in its plane");
    assert!(
        !rectangle(DVec3::Z, [DVec3::X, DVec3::X + DVec3::Y]),
        "no right angle"
    );
    assert!(!rectangle(2e3 * DVec3::Z, edges), "too small");
    let triangle = |from| SphericalTriangle::new(from, [DVec3::ZERO, DVec3::X, DVec3::Y]).is_some();
    assert!(triangle(DVec3::Z));
    assert!(!triangle(-DVec3::Z), "from behind");
    assert!(!triangle(DVec3::ONE.with_z(0.0)), "in its plane");
    assert!(!triangle(DVec3::ZERO), "at a vertex");
    let whole = Sphere::new(DVec3::ZERO, 1.0);
    let cap = |from, sphere| VisibleCap::new(from, &sphere).is_some();
    assert!(cap(2.0 * DVec3::Z, whole));
    // 1e-6 sr is a disc of radius d/1772.
    assert!(cap(1700.0 * DVec3::X, whole) && !cap(1800.0 * DVec3::X, whole));
    let ball = Emitter::new(EmitterShape::Sphere(whole), DVec3::ONE);
    for inside in [DVec3::ZERO, 0.5 * DVec3::Z, 0.999 * DVec3::X, DVec3::X] {
        assert!(!cap(inside, whole));
        assert_eq!(ball.pdf_solid_angle(inside), None);
        assert_eq!(ball.sample_solid_angle(inside, [0.3, 0.7]), None);
    }
    assert!(!cap(2.0 * DVec3::Z, inward(whole)), "inward");
    assert!(
        !cap(2.0 * DVec3::Z, between_heights(whole, [-0.5, 1.0])),
        "a zone"
    );
}
