//! Tests of the bounding volume hierarchy against a test of every primitive.

use std::array::from_fn;

use whitefurnace::geometry::bvh::{Bvh, PacketStack, Primitive, PrimitiveHit};
use whitefurnace::geometry::watertight::Shear;
use whitefurnace::math::real::{Mask as _, Vector as _};
use whitefurnace::math::simd::{LANES, Lanes, SINGLES, Scalar, Singles, Wide};

use crate::budget::assert_enough_compared;
use crate::prelude::*;

/// Returns the nearest hit with 0 < t < `t_max`; of several at the same distance, the first.
fn closest_of_all(primitives: &[Primitive], ray: &Ray, t_max: f64) -> Option<PrimitiveHit> {
    let shear = Shear::new(ray);
    let hits = primitives
        .iter()
        .zip(0..)
        .filter_map(|(primitive, id)| match *primitive {
            Primitive::Triangle(vertices) => {
                let hit = shear.intersect(vertices, t_max)?;
                Some(PrimitiveHit {
                    primitive: id,
                    t: hit.t,
                    weights: hit.weights,
                })
            }
            Primitive::Sphere(sphere) => {
                let t = sphere.distance(ray);
                (t < t_max).then_some(PrimitiveHit {
                    primitive: id,
                    t,
                    weights: [0.0; 3],
                })
            }
        });
    hits.min_by(|a, b| a.t.total_cmp(&b.t))
}

/// Checks all queries for a ray, and returns whether it hit.
///
/// Primitives are tested by the same operations, so hits agree to the last bit.
fn check(bvh: &Bvh, primitives: &[Primitive], ray: &Ray, t_max: f64) -> bool {
    let expected = closest_of_all(primitives, ray, t_max);
    let found = bvh.closest(ray, t_max);
    assert_eq!(found, expected, "{ray:?} up to {t_max}");
    assert_eq!(bvh.occluded(ray, t_max, |_| true), expected.is_some());
    assert!(!bvh.occluded(ray, t_max, |_| false));
    if let Some(hit) = expected {
        assert!(!bvh.occluded(ray, hit.t, |_| true), "t_max is exclusive");
        assert!(bvh.occluded(ray, hit.t.next_up(), |_| true));
        let only = found.map(|hit| hit.primitive);
        assert!(bvh.occluded(ray, t_max, |id| Some(id) == only));
    }
    expected.is_some()
}

/// Checks that packet queries return the hits of single rays, to the last bit, and none for lanes
/// that the mask leaves out.
fn check_together(bvh: &Bvh, rays: &[Ray]) {
    check_packets::<Lanes, LANES>(bvh, rays);
    check_packets::<Singles, SINGLES>(bvh, rays);
}

/// Checks packets of rays, whose numbers are rounded to the precision of the packets.
fn check_packets<R: Wide<N>, const N: usize>(bvh: &Bvh, rays: &[Ray]) {
    let mut stack = PacketStack::default();
    for first in (0..rays.len()).step_by(N) {
        let rays: [Ray; N] = from_fn(|i| rounded::<R::Scalar>(&rays[(first + i) % rays.len()]));
        let ray = Ray::new(
            R::Vector::from_fn(|i| rays[i].origin),
            R::Vector::from_fn(|i| rays[i].direction),
        );
        let alone = rays.map(|ray| bvh.closest_in::<R::Scalar>(&ray, f64::INFINITY));
        // All lanes, and each lane alone, so that no other ray opens a box for it.
        for active in (0..N).map(|i| 1 << i).chain([(1 << N) - 1]) {
            let active = R::Mask::from_bits(active);
            let hits = bvh.closest_of_packet::<R, N>(&ray, active, &mut stack);
            for (i, closest) in alone.iter().enumerate() {
                let expected = closest.filter(|_| active.lane(i));
                let found = hits.hit_mask.lane(i).then(|| PrimitiveHit {
                    primitive: hits.primitive[i],
                    t: hits.t.lane(i),
                    weights: hits.weights.map(|weight| weight.lane(i)),
                });
                assert_eq!(found, expected, "{:?}", rays[i]);
                assert_eq!(hits.t.lane(i).is_finite(), found.is_some());
            }
        }
    }
}

/// Returns a ray whose numbers are rounded to a precision.
fn rounded<T: Scalar>(ray: &Ray) -> Ray {
    let [origin, direction] = [ray.origin, ray.direction].map(|v| v.map(|x| T::rounded(x).into()));
    Ray::new(origin, direction)
}

/// Checks that boxes hide no hit in single precision. Of two hits that differ by rounding only,
/// either may be found.
fn check_single(bvh: &Bvh, primitives: &[Primitive], rays: &[Ray]) {
    // A hierarchy of one primitive has no boxes.
    let each: Vec<Bvh> = primitives
        .iter()
        .map(|primitive| Bvh::new(&[*primitive]))
        .collect();
    for ray in rays.iter().map(rounded::<f32>) {
        let expected = each
            .iter()
            .filter_map(|one| one.closest_in::<f32>(&ray, f64::INFINITY))
            .map(|hit| hit.t)
            .min_by(f64::total_cmp);
        let found = bvh.closest_in::<f32>(&ray, f64::INFINITY);
        assert_eq!(found.is_some(), expected.is_some(), "{ray:?}");
        if let (Some(found), Some(t)) = (found, expected) {
            assert_relative_eq!(found.t, t, max_relative = 1e-3);
        }
        let is_within = expected.is_some_and(|t| t < 1.0);
        assert_eq!(bvh.occluded_in::<f32>(&ray, 1.0, |_| true), is_within);
        assert!(!bvh.occluded_in::<f32>(&ray, 1.0, |_| false));
    }
}

fn random_triangle<R: Rng>(rng: &mut R, size: f64) -> [DVec3; 3] {
    let centre = in_cube(rng, 1.0);
    [0; 3].map(|_| centre + size * in_cube(rng, 1.0))
}

/// Returns rays of every awkward kind: random, along an axis, in a coordinate plane, from far away.
fn rays<R: Rng>(rng: &mut R, count: usize) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let mut origin = in_cube(rng, 1.5);
            let mut direction = unit_vector(rng);
            let axis = i / 5 % 3;
            match i % 5 {
                0 => {}
                1 => direction = DVec3::AXES[axis].copysign(direction),
                2 => direction[axis] = 0f64.copysign(direction[axis]),
                3 => origin[axis] = (2.0 * origin[axis]).round() * 0.5,
                _ => origin -= 1e4 * direction,
            }
            Ray::new(origin, direction)
        })
        .collect()
}

fn check_all(primitives: &[Primitive], rays: &[Ray]) -> usize {
    let bvh = Bvh::new(primitives);
    check_together(&bvh, rays);
    if primitives.len() <= 400 {
        check_single(&bvh, primitives, rays);
    }
    rays.iter()
        .enumerate()
        .filter(|(i, ray)| {
            let t_max = if i % 3 == 0 { 1.0 } else { f64::INFINITY };
            check(&bvh, primitives, ray, t_max)
        })
        .count()
}

#[test]
fn empty() {
    let bvh = Bvh::new(&[]);
    let ray = Ray::new(DVec3::ZERO, DVec3::X);
    assert_eq!(bvh.closest(&ray, f64::INFINITY), None);
    assert!(!bvh.occluded(&ray, f64::INFINITY, |_| true));
    check_together(&bvh, &[ray; LANES]);
}

#[test]
fn random_soups() {
    let mut rng = rng("soups");
    for count in [1, 2, 3, 4, 5, 8, 9, 17, 60, 400] {
        for size in [1.0, 0.1, 1e-3] {
            let soup: Vec<_> = (0..count)
                .map(|_| Primitive::Triangle(random_triangle(&mut rng, size)))
                .collect();
            check_all(&soup, &rays(&mut rng, 300));
        }
    }
}

#[test]
fn spheres_among_triangles() {
    let mut rng = rng("mixed");
    for count in [2, 10, 100] {
        let mixed: Vec<_> = (0..count)
            .map(|i| {
                if i % 2 == 0 {
                    return Primitive::Triangle(random_triangle(&mut rng, 0.3));
                }
                let radius = between(&mut rng, 0.01, 0.3);
                let whole = Sphere::new(in_cube(&mut rng, 1.0), radius);
                let height = between(&mut rng, -radius, radius);
                let zone = [height, f64::INFINITY];
                Primitive::Sphere(if i % 4 == 1 {
                    whole
                } else {
                    between_heights(whole, zone)
                })
            })
            .collect();
        let hits = check_all(&mixed, &rays(&mut rng, 3000));
        // Two small primitives may be missed by all rays; a hundred may not.
        if count == 100 {
            assert_enough_compared("mixed", hits);
        }
    }
}

#[test]
fn flat_and_axis_aligned_geometry() {
    let mut rng = rng("flat");
    for axis in 0..3 {
        // Unit squares of a grid in one plane, and the faces of boxes: bounds without thickness.
        let mut flat = Vec::new();
        for i in 0..100 {
            let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
            let (x, y) = (DVec3::AXES[p] * 0.2, DVec3::AXES[q] * 0.2);
            let corner = -DVec3::splat(1.0) + f64::from(i % 10) * x + f64::from(i / 10) * y;
            let corner = corner + DVec3::AXES[axis] * (1.0 + 0.5 * f64::from(i % 3));
            flat.push(Primitive::Triangle([corner, corner + x, corner + x + y]));
            flat.push(Primitive::Triangle([corner, corner + x + y, corner + y]));
        }
        assert_enough_compared("flat", check_all(&flat, &rays(&mut rng, 4000)));
        // Rays within the plane of the faces, aimed at their corners.
        let bvh = Bvh::new(&flat);
        let corners = flat.iter().filter_map(|primitive| match primitive {
            Primitive::Triangle([a, ..]) => Some(*a),
            Primitive::Sphere(_) => None,
        });
        let rays: Vec<Ray> = corners
            .flat_map(|corner| {
                let mut along = unit_vector(&mut rng);
                along[axis] = 0.0;
                let origin = in_cube(&mut rng, 2.0);
                [
                    Ray::new(corner - along, along),
                    Ray::new(origin, corner - origin),
                ]
            })
            .collect();
        check_together(&bvh, &rays);
        for ray in rays {
            check(&bvh, &flat, &ray, f64::INFINITY);
        }
    }
}

/// Tests triangles that touch a plane through the origin from either side, with rays within that
/// plane that start at the origin or near it.
#[test]
fn rays_from_the_origin_along_sides_of_boxes() {
    let mut rng = rng("origin");
    for axis in 0..3 {
        let within = |v: DVec3| v - v * DVec3::AXES[axis];
        let triangles: Vec<[DVec3; 3]> = (0..60)
            .map(|i| {
                let [a, b, c] = random_triangle(&mut rng, 0.3);
                let side = DVec3::AXES[axis] * if i % 2 == 0 { 0.1 } else { -0.1 };
                [within(a), within(b), within(c) + side]
            })
            .collect();
        let mut rays = Vec::new();
        for _ in 0..2000 {
            let [a, b, _] = triangles[(60.0 * uniform(&mut rng)) as usize];
            let origin = within(in_cube(&mut rng, 1.0))
                * [0.0, 1e-30, 1e-12, 1.0][(4.0 * uniform(&mut rng)) as usize];
            rays.push(Ray::new(
                origin,
                0.5 * (a.lerp(b, uniform(&mut rng)) - origin),
            ));
        }
        let primitives: Vec<Primitive> = triangles.into_iter().map(Primitive::Triangle).collect();
        // Each ray meets the edge that it aims at, halfway to where two of three may end.
        assert!(check_all(&primitives, &rays) > 1000);
    }
}

#[test]
fn scales_and_offsets() {
    let mut rng = rng("scales");
    for scale in [1e-30, 1e-4, 1e4, 1e30] {
        for offset in [0.0, 100.0] {
            let mesh = Mesh::globe(12, 16)
                .map(|v| (v + offset) * scale)
                .primitives();
            let rays: Vec<_> = rays(&mut rng, 2000)
                .into_iter()
                .enumerate()
                // Every other ray is a segment, as shadow rays are.
                .map(|(i, ray)| (ray, if i % 2 == 0 { 1.0 } else { scale }))
                .map(|(ray, length)| {
                    Ray::new((ray.origin + offset) * scale, ray.direction * length)
                })
                .collect();
            assert_enough_compared("scales", check_all(&mesh, &rays));
        }
    }
}

#[test]
fn equal_primitives_are_all_there() {
    // A heuristic that insists on a split would not end: nothing separates them.
    let equal = [Primitive::Triangle([DVec3::ZERO, DVec3::X, DVec3::Y]); 100];
    let bvh = Bvh::new(&equal);
    let ray = Ray::new(DVec3::new(0.25, 0.25, 1.0), -DVec3::Z);
    // The first of several at the same distance is hit.
    for hit in [bvh.closest(&ray, 2.0), closest_of_all(&equal, &ray, 2.0)] {
        assert_eq!(hit.map(|hit| (hit.t, hit.primitive)), Some((1.0, 0)));
    }
    check_together(&bvh, &[ray; LANES]);
    // The first is hit even if the box of another is entered first: both are in the plane z = x.
    let inclined =
        |corners: [[f64; 2]; 3]| Primitive::Triangle(corners.map(|[x, y]| DVec3::new(x, y, x)));
    let [near, far] = [
        [[-0.5, -0.5], [0.5, -0.5], [0.0, 0.5]],
        [[-1.0, -1.0], [7.0, -1.0], [-1.0, 7.0]],
    ]
    .map(inclined);
    let others = (2..20).map(|i| {
        inclined([[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]].map(|[x, y]| [x - f64::from(i), y]))
    });
    let sorted = Bvh::new(&[near, far].into_iter().chain(others).collect::<Vec<_>>());
    let down = Ray::new(DVec3::new(0.0, 0.0, 5.0), -DVec3::Z);
    assert_eq!(
        sorted
            .closest(&down, f64::INFINITY)
            .map(|hit| hit.primitive),
        Some(0)
    );
    check_together(&sorted, &[down; LANES]);
    for id in 0..100 {
        assert!(bvh.occluded(&ray, 2.0, |other| other == id), "lost {id}");
    }
    // Many equal primitives make no hierarchy deeper than the traversal stack.
    let many = Bvh::new(&vec![equal[0]; 3000]);
    check_together(&many, &[ray; LANES]);
    for id in [0, 1, 1500, 2999] {
        assert!(many.occluded(&ray, 2.0, |other| other == id), "lost {id}");
    }
}

/// Splits by area take the largest triangle off, again and again: the deepest tree there is.
#[test]
fn ever_smaller_triangles_make_no_tree_too_deep() {
    let mut rng = rng("smaller");
    for ratio in [0.5_f64, 0.9, 0.99] {
        let primitives: Vec<_> = (0..1500)
            .map(|i| {
                let size = ratio.powi(i).max(1e-30);
                Primitive::Triangle(random_triangle(&mut rng, 1.0).map(|v| (v + 2.0) * size))
            })
            .collect();
        let rays: Vec<Ray> = (0..2000)
            .map(|i| {
                let Primitive::Triangle([a, b, c]) = primitives[i % primitives.len()] else {
                    unreachable!("all are triangles")
                };
                let origin = 8.0 * unit_vector(&mut rng);
                Ray::new(origin, (a + b + c) / 3.0 - origin)
            })
            .collect();
        let hits = check_all(&primitives, &rays);
        assert!(hits > 100, "{hits} hits at a ratio of {ratio}");
    }
}

/// A ray whose packet opens the boxes of triangles that it passes far away misses them, as alone.
#[test]
fn slivers_are_missed_beside_them() {
    let slivers = slivers_beside_z(f64::EPSILON);
    let up = Ray::new(DVec3::ZERO, 32.0 * DVec3::Z);
    let rays: Vec<Ray> = slivers
        .iter()
        .flat_map(|[a, b, c]| {
            let origin = DVec3::new(7.0, -5.0, 1.0);
            [up, Ray::new(origin, (a + b + c) / 3.0 - origin)]
        })
        .collect();
    let primitives: Vec<_> = slivers.into_iter().map(Primitive::Triangle).collect();
    check_all(&primitives, &rays);
    assert_eq!(Bvh::new(&primitives).closest(&up, f64::INFINITY), None);
}

#[test]
fn rays_of_no_numbers_hit_nothing() {
    let mut rng = rng("no numbers");
    for count in [1, 9, 400] {
        let primitives: Vec<_> = (0..count)
            .map(|i| match i % 3 {
                0 => Primitive::Sphere(Sphere::new(in_cube(&mut rng, 1.0), 0.1)),
                _ => Primitive::Triangle(random_triangle(&mut rng, 0.3)),
            })
            .collect();
        let bvh = Bvh::new(&primitives);
        for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for axes in 1..8 {
                let spoilt = |v: DVec3| {
                    DVec3::from_array(
                        [0, 1, 2].map(|i| if axes >> i & 1 == 1 { number } else { v[i] }),
                    )
                };
                let [origin, direction] = [0, 1].map(|_| unit_vector(&mut rng));
                for ray in [
                    Ray::new(spoilt(origin), direction),
                    Ray::new(origin, spoilt(direction)),
                ] {
                    assert_eq!(bvh.closest(&ray, f64::INFINITY), None, "{ray:?}");
                    assert!(!bvh.occluded(&ray, f64::INFINITY, |_| true), "{ray:?}");
                    check_together(&bvh, &[ray; LANES]);
                }
            }
        }
    }
}

#[test]
fn hundred_thousand_triangles() {
    let mut rng = rng("large mesh");
    let globe = Mesh::globe(225, 223).map(|v| v * DVec3::new(1.0, 0.7, 0.4));
    assert!(globe.triangles.len() > 99_000);
    let primitives = globe.primitives();
    let bvh = Bvh::new(&primitives);
    let rays = rays(&mut rng, 400);
    check_together(&bvh, &rays);
    assert_enough_compared(
        "large mesh",
        rays.iter()
            .filter(|ray| check(&bvh, &primitives, ray, f64::INFINITY))
            .count(),
    );
    // From inside, at vertices and edges: closed, so every ray meets it.
    let aimed: Vec<Ray> = (0..20_000)
        .map(|_| {
            let origin = 0.2 * in_cube(&mut rng, 1.0);
            Ray::new(origin, border(&mut rng, &globe) - origin)
        })
        .collect();
    check_together(&bvh, &aimed);
    for ray in aimed {
        assert!(bvh.closest(&ray, f64::INFINITY).is_some(), "lost {ray:?}");
    }
}

/// Rounding may decide whether a ray that starts on a triangle hits it; the hierarchy decides as
/// the test of all primitives does.
#[test]
fn rays_that_start_on_a_triangle() {
    let mut rng = rng("starts");
    for _ in 0..20_000 {
        let pick = |rng: &mut _, count: usize| between(rng, 0.0, count as f64) as usize;
        // Nearly all in a plane through the origin.
        let mut size = DVec3::splat([1e-3, 1.0, 1e7][pick(&mut rng, 3)]);
        size[pick(&mut rng, 3)] = [0.0, 1e-300, 1e-23][pick(&mut rng, 3)];
        let triangle = random_triangle(&mut rng, 1.0).map(|v| v * size);
        let [a, b, c] = triangle;
        let [u, v] = uniform2(&mut rng).map(|r| 0.4 * r);
        let alone = [Primitive::Triangle(triangle)];
        let bvh = Bvh::new(&alone);
        for origin in [DVec3::ZERO, a + u * (b - a) + v * (c - a)] {
            let ray = Ray::new(origin, unit_vector(&mut rng));
            check(&bvh, &alone, &ray, f64::INFINITY);
            check_together(&bvh, &[ray; LANES]);
        }
    }
}
