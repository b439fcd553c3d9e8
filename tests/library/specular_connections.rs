//! Tests of specular connections through one mirror or glass object: all are found, obey the laws
//! of reflection and refraction, and have the geometry term that finite differences give.

use std::f64::consts::{FRAC_PI_2, PI};

use whitefurnace::geometry::specular_connection::{
    Caster, CasterKind, SpecularConnection, SphereConnections, geometry_term,
};
use whitefurnace::material::fresnel::{reflect, refract};

use crate::prelude::*;

const CASES: u32 = 20_000;

/// A sphere, and two points outside.
#[derive(Debug)]
struct Case {
    caster: Caster<DVec3>,
    refracts: bool,
    x: DVec3,
    y: DVec3,
}

impl Case {
    fn new(i: u32) -> Self {
        let mut rng = stream(master(), i, 77);
        let mut unit = || uniform(&mut rng);
        let refracts = unit() < 0.7;
        let radius = 10_f64.powf(2.0 * unit() - 1.0);
        let centre = DVec3::new(unit(), unit(), unit()) * 4.0 - 2.0;
        let index = 1.0 + 10_f64.powf(1.6 * unit() - 1.6);
        let mut point = || {
            let [r1, r2] = [unit(), unit()];
            let away = from_spherical((1.0 - 2.0 * r1).acos(), 2.0 * PI * r2);
            // Both near and far.
            centre + away * radius * (1.0 + 10_f64.powf(4.0 * unit() - 3.0))
        };
        let (x, y) = (point(), point());
        // Often nearly opposite, where there are three connections.
        let y = if unit() < 0.5 {
            let across = centre - (x - centre).normalize() * (y - centre).length();
            let moved = across + (y - centre) * 0.3 * unit();
            centre + (moved - centre).normalize() * (y - centre).length()
        } else {
            y
        };
        let inverse_ior = if refracts { index.recip() } else { 0.0 };
        let caster = Caster {
            centre,
            radius,
            area: 0.0,
            normal: DVec3::ZERO,
            inverse_ior,
            index: if refracts { index } else { 0.0 },
            reflectance: DVec3::ONE,
            selection_weight: 1.0,
        };
        Self {
            caster,
            refracts,
            x,
            y,
        }
    }

    /// Returns the case with y at this offset from the line through x and the centre.
    fn in_line(self, offset: f64) -> Self {
        let Caster { centre, .. } = self.caster;
        let y = centre + (centre - self.x) + (self.y - centre) * offset;
        Self { y, ..self }
    }

    fn connections(&self) -> Vec<SpecularConnection<DVec3>> {
        SphereConnections::new(&self.caster, self.x, self.y, true, self.refracts)
            .connections()
            .map(|(_, connection)| connection)
            .collect()
    }

    /// Returns x, y and Θ of the equation.
    fn relative_positions(&self) -> [f64; 3] {
        let [x, y] = [self.x, self.y].map(|v| v - self.caster.centre);
        [
            x.length() / self.caster.radius,
            y.length() / self.caster.radius,
            x.angle_between(y),
        ]
    }

    /// Evaluates f of the equation through arc sines.
    fn turned_angle(&self, alpha: f64) -> f64 {
        let ([x, y, _], sin) = (self.relative_positions(), alpha.sin());
        2.0 * alpha
            - 2.0 * (sin * self.caster.inverse_ior).asin()
            - (sin / x).asin()
            - (sin / y).asin()
    }

    /// Estimates the solid angle per area between the connections to four points around y.
    fn geometry_term_by_differences(
        &self,
        connection: &SpecularConnection<DVec3>,
        step: f64,
    ) -> Option<f64> {
        let frame = Frame::new(connection.arriving);
        let moved = |by: DVec3| {
            let moved = Self {
                caster: self.caster,
                refracts: self.refracts,
                x: self.x,
                y: self.y + by,
            };
            let apart = |direction: &DVec3| (*direction - connection.direction).length();
            let directions = moved
                .connections()
                .into_iter()
                .map(|connection| connection.direction);
            directions.min_by(|a, b| apart(a).total_cmp(&apart(b)))
        };
        let [across, along] =
            [frame.x, frame.y].map(|axis| Some(moved(axis * step)? - moved(axis * -step)?));
        Some(across?.cross(along?).length() / (4.0 * step * step))
    }

    /// Returns where a ray from x leaves the sphere, and in which direction.
    fn follow(&self, direction: DVec3) -> Option<(DVec3, DVec3)> {
        let sphere = Sphere::new(self.caster.centre, self.caster.radius);
        let ray = Ray::new(self.x, direction);
        let first = ray.at(sphere.intersect(&ray, f64::INFINITY)?);
        let normal = sphere.normal(first);
        if !self.refracts {
            return Some((first, reflect(direction, normal)));
        }
        let inside = refract(direction, normal, 1.0, self.caster.index)?;
        let last = first - inside * (2.0 * inside.dot(normal)) * self.caster.radius;
        Some((
            last,
            refract(inside, -sphere.normal(last), self.caster.index, 1.0)?,
        ))
    }
}

#[test]
fn every_connection_through_a_sphere_is_found() {
    let mut found = [0; 4];
    for case in (0..CASES / 10).map(Case::new) {
        let [.., angle] = case.relative_positions();
        let targets = if case.refracts {
            vec![PI - angle, angle - PI]
        } else {
            vec![angle]
        };
        const STEPS: u32 = 4_000;
        let grid = |i: u32| FRAC_PI_2 * f64::from(i) / f64::from(STEPS);
        let values: Vec<f64> = (0..=STEPS).map(|i| case.turned_angle(grid(i))).collect();
        let crossings = |target: f64| {
            values
                .windows(2)
                .filter(|w| (w[0] < target) != (w[1] < target))
                .count()
        };
        // Two roots in one step of the grid are not detected.
        let near_fold = targets.iter().any(|target| {
            values
                .windows(3)
                .any(|w| w[1] <= w[0] && w[1] <= w[2] && (w[1] - target).abs() < 1e-6)
        });
        let expected: usize = targets.into_iter().map(crossings).sum();
        let count = case.connections().len();
        if !near_fold {
            assert_eq!(count, expected, "{case:?}");
        }
        found[count] += 1;
    }
    assert!(
        found.iter().all(|&cases| cases > 20),
        "{found:?} cases with 0 to 3 connections"
    );
}

#[test]
fn no_connection_ends_within_the_sphere() {
    for case in (0..CASES / 10).map(Case::new) {
        let within = |v: DVec3, share: f64| {
            case.caster.centre + (v - case.caster.centre).normalize() * case.caster.radius * share
        };
        for share in [0.1, 0.5, 0.9, 0.999] {
            for (x, y) in [
                (within(case.x, share), case.y),
                (case.x, within(case.y, share)),
            ] {
                let case = Case {
                    caster: case.caster,
                    refracts: case.refracts,
                    x,
                    y,
                };
                assert!(case.connections().is_empty(), "{case:?}");
            }
        }
    }
}

#[test]
fn connections_obey_the_laws_of_reflection_and_refraction() {
    let mut count = 0;
    let in_line = |i: u32| Case::new(i).in_line(0.1_f64.powi(1 + i as i32 % 6));
    for case in (0..CASES).flat_map(|i| [Case::new(i), in_line(i)]) {
        for connection in case.connections() {
            let Some((last, direction)) = case.follow(connection.direction) else {
                // At grazing incidence.
                assert!(
                    connection.cosine < 1e-5,
                    "misses, cosine {} of {case:?}",
                    connection.cosine
                );
                continue;
            };
            let towards = case.y - last;
            let miss = towards.cross(direction).length();
            let scale = (case.y - case.x).length() + case.caster.radius;
            // A rounding of the ray moves its end by that over the geometry term.
            let growth = 1.0 + (connection.geometry_term * scale * scale).sqrt().recip();
            assert!(
                miss < 1e-10 * scale * growth,
                "misses by {miss} of {scale}, {growth}, seen {:?} cosine {}: {case:?}",
                case.relative_positions(),
                connection.cosine
            );
            assert!(
                towards.dot(direction) > 0.0
                    && (connection.arriving - direction).length() < 1e-7 * growth,
                "{case:?}"
            );
            count += 1;
        }
    }
    assert!(count > CASES / 2, "{count} connections");
}

#[test]
fn geometry_terms_are_those_of_finite_differences() {
    let mut count = 0;
    for case in (0..CASES).map(Case::new) {
        for connection in case.connections() {
            let [x_distance, y_distance, angle] = case.relative_positions();
            let gap = (x_distance.min(y_distance) - 1.0) * case.caster.radius;
            let step = 1e-5
                * (case.y - case.x)
                    .length()
                    .min(case.caster.radius * angle.sin())
                    .min(gap);
            let differences =
                [step, step / 4.0].map(|step| case.geometry_term_by_differences(&connection, step));
            // Next to a caustic finite differences depend on the step and say little.
            if let [Some(a), Some(b)] = differences
                && (a / b - 1.0).abs() < 1e-3
            {
                assert!(
                    (b / connection.geometry_term - 1.0).abs() < 0.01,
                    "{b} and {} of {case:?}",
                    connection.geometry_term
                );
                count += 1;
            }
            let kind = if case.refracts {
                CasterKind::Refraction
            } else {
                CasterKind::Reflection
            };
            let (of_ray, _) =
                geometry_term(&case.caster, kind, case.x, connection.direction, case.y);
            let grazing = 1e-10 / (connection.cosine * connection.cosine);
            assert!(
                (of_ray / connection.geometry_term - 1.0).abs() < 1e-5 + grazing,
                "{of_ray} and {} of {case:?}",
                connection.geometry_term
            );
        }
    }
    assert!(count > CASES / 2, "{count} connections");
}

#[test]
fn a_flat_mirror_has_connections_at_its_front() {
    let (corner, edges) = (
        DVec3::new(-0.4, 0.1, -0.3),
        [DVec3::new(0.9, 0.2, 0.1), DVec3::new(-0.1, 0.3, 0.8)],
    );
    let scene = scene_from(
        Camera::new(DVec3::new(0.0, -9.0, 0.0), DVec3::ZERO, DVec3::Z, 0.5),
        |s| {
            panel(s, corner, edges, reflecting(0.5));
        },
    );
    let [caster] = scene.specular_casters().all() else {
        panic!("one caster")
    };
    let normal = edges[0].cross(edges[1]).normalize();
    let mut rng = rng("points");
    let mut found = [0; 2];
    for _ in 0..20_000 {
        let [x, y] = [0, 1].map(|_| in_cube(&mut rng, 1.5));
        let [height_x, height_y] = [x, y].map(|v| (v - corner).dot(normal));
        // Intersection of the line from x to the image of y with the plane, in coordinates along
        // the edges.
        let image = y - 2.0 * height_y * normal;
        let met = x + (image - x) * (height_x / (height_x + height_y));
        let across = edges.map(|edge| edge - edge.dot(normal) * normal);
        let along = |k: usize| {
            let dual = across[1 - k].cross(normal);
            (met - corner).dot(dual) / across[k].dot(dual)
        };
        let lies = |share: f64| (0.0..1.0).contains(&share);
        let expected = height_x > 0.0 && height_y > 0.0 && lies(along(0)) && lies(along(1));
        let connections: Vec<_> = caster.connections(x, y).collect();
        assert_eq!(
            connections.len(),
            usize::from(expected),
            "from {x:?} to {y:?}"
        );
        found[usize::from(expected)] += 1;
        for (_, connection) in connections {
            assert!(
                (connection.first.point - met).length() < 1e-12
                    && connection.first == connection.last
            );
            assert!((reflect(connection.direction, normal) - connection.arriving).length() < 1e-9);
            assert!((connection.direction - (met - x).normalize()).length() < 1e-9);
            assert_relative_eq!(
                connection.geometry_term,
                1.0 / (image - x).length_squared(),
                max_relative = 1e-12
            );
            assert_relative_eq!(
                connection.cosine,
                -connection.direction.dot(normal),
                max_relative = 1e-12
            );
            let of_ray = geometry_term(&caster.parameters, caster.kind, x, connection.direction, y);
            assert_relative_eq!(of_ray.0, connection.geometry_term, max_relative = 1e-12);
        }
    }
    assert!(
        found.iter().all(|&cases| cases > 200),
        "{found:?} without and with a connection"
    );
}
