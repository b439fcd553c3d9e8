//! Tests of the selection weights of emitters, and of emitter selection by them.

use whitefurnace::light::emitter::EmitterPoint;
use whitefurnace::light::light_sampler::{
    MAX_EXACT_LIGHTS, PowerLightSampler, UNIFORM_FRACTION, pick, probabilities, probability,
};
use whitefurnace::light::light_tree::LightTree;

use crate::prelude::*;

const WHITE: DVec3 = DVec3::ONE;

/// Returns a rectangle, a triangle and a sphere of one area that face up at the origin, and that
/// area.
fn shapes() -> ([Emitter; 3], f64) {
    let area: f64 = 0.8;
    let a = area.sqrt();
    let corner = -0.5 * a * (DVec3::X + DVec3::Y);
    let side = (area * 4.0 / 3f64.sqrt()).sqrt();
    let triangle = [0.0, 1.0, 2.0]
        .map(|k| Frame::new(DVec3::Z).world(from_spherical(FRAC_PI_2, k * TAU / 3.0)));
    let shapes = [
        EmitterShape::Rectangle {
            corner,
            edges: [a * DVec3::X, a * DVec3::Y],
        },
        EmitterShape::Triangle(triangle.map(|v| v * side / 3f64.sqrt())),
        EmitterShape::Sphere(Sphere::new(DVec3::ZERO, (area / (4.0 * PI)).sqrt())),
    ];
    (shapes.map(|shape| Emitter::new(shape, WHITE)), area)
}

#[test]
fn from_afar_a_contribution_falls_with_distance_and_slant() {
    let ([rectangle, triangle, sphere], area) = shapes();
    let mut rng = rng("contributions");
    for _ in 0..1000 {
        let (towards, d) = (unit_vector(&mut rng), 1e4);
        let flat = area * towards.z.max(0.0).powi(2) / (d * d);
        for emitter in [rectangle, triangle] {
            assert_abs_diff_eq!(
                emitter.importance(d * towards),
                flat,
                epsilon = 2e-4 * area / (d * d)
            );
        }
        assert_relative_eq!(
            sphere.importance(d * towards),
            0.25 * area / (d * d),
            max_relative = 1e-9
        );
    }
}

#[test]
fn over_a_light_a_contribution_is_about_that_of_a_disc() {
    let ([rectangle, triangle, sphere], area) = shapes();
    for height in [1e-3, 0.1, 1.0, 10.0] {
        let disc = PI / (1.0 + height * height * PI / area);
        for emitter in [rectangle, triangle] {
            let ratio = emitter.importance(height * DVec3::Z) / disc;
            assert!((0.999..=2.0).contains(&ratio), "{ratio} at {height}");
            assert_eq!(emitter.importance(-height * DVec3::Z), 0.0);
        }
    }
    // Within a sphere that shines inward.
    assert_relative_eq!(sphere.importance(DVec3::ZERO), PI, max_relative = 1e-9);
}

/// An emitter has weight 0 for points on its own surface and for origins of rays that left it,
/// wherever rounding puts them, also for a distant camera.
#[test]
fn a_light_has_no_share_from_its_own_surface() {
    let mut rng = rng("own surface");
    let edges = [DVec3::new(0.7, 0.1, -0.3), DVec3::new(0.2, 1.1, 0.4)];
    for far in [3.0, 1e9] {
        let eye = DVec3::new(0.0, -far, 1.0);
        let near = scene_from(
            Camera::new(DVec3::new(0.0, -3.0, 1.0), DVec3::ZERO, DVec3::Z, 0.5),
            |scene| {
                panel(
                    scene,
                    DVec3::new(-0.3, 0.4, 0.2),
                    edges,
                    diffuse(0.5).emitting(WHITE),
                );
            },
        );
        let scene = near
            .with_camera(Camera::new(eye, DVec3::ZERO, DVec3::Z, 0.5))
            .expect("a camera");
        let light = scene.emitters()[0];
        for _ in 0..1000 {
            let EmitterPoint { point, normal } = light.sample(uniform2(&mut rng));
            for from in [
                point,
                scene.spawn_ray(point, normal, normal).origin,
                scene.spawn_ray(point, normal, -normal).origin,
            ] {
                assert_eq!(light.importance(from), 0.0);
            }
            assert!(light.importance(point + 1e-2 * normal) > 0.1);
        }
    }
}

/// All colours count alike, and every emitter that can be visible has a positive weight.
#[test]
fn contributions_are_in_proportion_to_radiance() {
    for emitter in shapes().0 {
        let from = DVec3::new(3.0, 1.0, 1e-9);
        let of = |radiance| Emitter::new(emitter.shape, radiance).importance(from);
        assert!(of(WHITE) > 0.0);
        assert_relative_eq!(
            of(DVec3::new(6.0, 0.0, 0.0)),
            2.0 * of(WHITE),
            max_relative = 1e-12
        );
        assert_eq!(of(DVec3::new(1.0, 2.0, 3.0)), of(DVec3::new(3.0, 1.0, 2.0)));
    }
}

/// Each emitter owns a part of [0, 1), as wide as its selection probability, one after the other.
#[test]
fn picks_by_flux_are_half_in_proportion_and_half_even() {
    let flux = prop_oneof![Just(0.0), 1e-3..1.0, 1e3..1e6];
    property("flux", 500, &prop::collection::vec(flux, 1..20), |fluxes| {
        let picks = PowerLightSampler::new(&fluxes);
        let sum: f64 = fluxes.iter().sum();
        let shining = fluxes.iter().filter(|&&flux| flux > 0.0).count() as f64;
        let mut before = 0.0;
        for (i, &flux) in fluxes.iter().enumerate() {
            let share = match flux {
                _ if sum == 0.0 => 1.0 / fluxes.len() as f64,
                0.0 => 0.0,
                _ => 0.5 * flux / sum + 0.5 / shining,
            };
            assert_abs_diff_eq!(picks.probability(i), share, epsilon = 1e-14);
            for inside in [1e-6, 0.5, 1.0 - 1e-6] {
                assert!(share == 0.0 || picks.pick(before + inside * share) == i);
            }
            before += share;
        }
        for edge in [picks.pick(0.0), picks.pick(1.0 - UNIT_ROUNDOFF)] {
            assert!(picks.probability(edge) > 0.0, "{edge} is never picked");
        }
    });
}

#[test]
fn fluxes_too_large_to_add_have_picks() {
    for (fluxes, shares) in [
        ([1e308, 1e308, 0.0], [0.5, 0.5, 0.0]),
        ([f64::INFINITY, 1e300, 0.0], [0.75, 0.25, 0.0]),
        ([5e-324, 5e-324, 1e308], [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0]),
    ] {
        let picks = PowerLightSampler::new(&fluxes);
        for (i, share) in shares.into_iter().enumerate() {
            assert_abs_diff_eq!(picks.probability(i), share, epsilon = 1e-7);
        }
    }
}

/// Generates some weights, 0 and the ends of the range of doubles among them.
fn contributions() -> impl Strategy<Value = Vec<f64>> {
    let one = prop_oneof![
        Just(0.0),
        0.0..1.0,
        Just(1e300),
        Just(5e-324),
        Just(f64::INFINITY),
        1e-9..1e9
    ];
    prop::collection::vec(one, 1..=MAX_EXACT_LIGHTS)
}

#[test]
fn shares_sum_to_one_and_no_light_is_left_out() {
    property("shares", 2000, &contributions(), |contributions| {
        let mut shares = vec![0.0; contributions.len()];
        probabilities(|i| contributions[i], &mut shares);
        let some = contributions.iter().filter(|&&c| c > 0.0).count();
        let sum: f64 = shares.iter().sum();
        assert_abs_diff_eq!(sum, if some > 0 { 1.0 } else { 0.0 }, epsilon = 1e-12);
        for (i, (&contribution, &of_one)) in contributions.iter().zip(&shares).enumerate() {
            assert_eq!(of_one > 0.0, contribution > 0.0);
            assert!(of_one == 0.0 || of_one >= UNIFORM_FRACTION / some as f64);
            assert_eq!(
                probability(|i| contributions[i], contributions.len(), i as f64),
                of_one
            );
        }
    });
}

#[test]
fn a_number_picks_the_share_that_it_lies_in() {
    property(
        "picks",
        2000,
        &(contributions(), 0.0..1.0),
        |(contributions, r)| {
            let mut shares = vec![0.0; contributions.len()];
            probabilities(|i| contributions[i], &mut shares);
            for r in [r, 0.0, 1.0 - UNIT_ROUNDOFF] {
                let (index, of_it) = pick(&shares, r);
                let index = index as usize;
                assert_eq!(of_it, shares[index]);
                let below: f64 = shares[..index].iter().sum();
                let within = below <= r + 1e-12 && r <= below + of_it + 1e-12;
                assert!(
                    within && of_it > 0.0 || contributions.iter().all(|&c| c == 0.0),
                    "{r} in {shares:?} is {index}"
                );
            }
        },
    );
}

/// A single light needs no selection weight.
#[test]
fn several_lights_are_picked_by_importance() {
    for (count, asked) in [(1, false), (2, true), (1000, true)] {
        assert_eq!(LightSampling::Importance.by_importance(count), asked);
        assert!(!LightSampling::SphereAngle.by_importance(count));
    }
}

/// Returns triangles that face in all directions, and one much brighter light.
fn many(count: usize, rng: &mut impl Rng) -> Vec<Emitter> {
    let mut emitter = |radiance: f64| {
        let centre = between(rng, 1.0, 3.0) * unit_vector(rng);
        let corners = [(); 3].map(|()| centre + 0.2 * unit_vector(rng));
        Emitter::new(EmitterShape::Triangle(corners), DVec3::splat(radiance))
    };
    (0..count)
        .map(|i| emitter(if i == count / 3 { 500.0 } else { 1.0 }))
        .collect()
}

#[test]
fn in_groups_picks_have_the_probabilities_that_they_say() {
    let mut rng = rng("groups");
    // Up to two levels of groups; the last ones are not full.
    for count in [MAX_EXACT_LIGHTS + 1, 100, 576, 1023, 1025, 3000] {
        let emitters = many(count, &mut rng);
        let groups = LightTree::new(&emitters);
        for _ in 0..3 {
            let from = between(&mut rng, 0.0, 5.0) * unit_vector(&mut rng);
            let contribution = |i: usize| emitters[i].importance(from);
            let by_share = |r: f64, shares: &[f64]| DefaultParts.pick_by_probability(r, shares);
            // Each emitter owns one interval of random numbers.
            let picks = 200_000;
            let mut found = vec![0.0; count];
            for k in 0..picks {
                let r = (f64::from(k) + 0.5) / f64::from(picks);
                let (index, probability) = groups.pick(r, from, contribution, by_share);
                if probability > 0.0 {
                    assert_eq!(groups.probability(index, from, contribution), probability);
                    found[index] += 1.0 / f64::from(picks);
                }
            }
            for (index, found) in found.into_iter().enumerate() {
                let probability = groups.probability(index, from, contribution);
                assert_eq!(probability > 0.0, contribution(index) > 0.0);
                assert_abs_diff_eq!(found, probability, epsilon = 1.01 / f64::from(picks));
            }
            // Its group is selected by its weight at a point that it faces.
            let mean = (0..count).map(contribution).sum::<f64>() / count as f64;
            let (bright, even) = (
                groups.probability(count / 3, from, contribution),
                1.0 / count as f64,
            );
            assert!(
                bright > 3.0 * even || contribution(count / 3) < 20.0 * mean,
                "{bright} of {count}"
            );
        }
    }
}

/// Groups hold neighbours: their members are much nearer to each other than to others.
#[test]
fn far_groups_are_picked_seldom() {
    let square = |x: f64| EmitterShape::Rectangle {
        corner: DVec3::new(x, 0.0, 1.0),
        edges: [0.1 * DVec3::Y, 0.1 * DVec3::X],
    };
    // In shuffled order: 700 and 11 are coprime.
    let row: Vec<Emitter> = (0..700)
        .map(|i| Emitter::new(square(f64::from(i * 11 % 700)), WHITE))
        .collect();
    let groups = LightTree::new(&row);
    for x in [40.0, 660.0] {
        let from = DVec3::new(x, 0.0, 0.0);
        let near: f64 = (0..700)
            .filter(|i| (f64::from(i * 11 % 700) - x).abs() < 30.0)
            .map(|i| groups.probability(i as usize, from, |k| row[k].importance(from)))
            .sum();
        assert!(near > 0.72, "{near} at {x}");
    }
}

/// Emitters without extent, in one place, of any radiance, can be grouped.
#[test]
fn degenerate_lights_have_groups() {
    for radiance in [[1.0; 2], [1e-300; 2], [1e300; 2], [1.0, 1e-300]] {
        let at = |place: usize| {
            let sphere = Sphere::new(DVec3::splat(place as f64), 1e-30);
            Emitter::new(EmitterShape::Sphere(sphere), DVec3::splat(radiance[place]))
        };
        let emitters: Vec<Emitter> = (0..1500).map(|i| at(i % 2)).collect();
        let groups = LightTree::new(&emitters);
        for from in [DVec3::ZERO, DVec3::splat(1e30)] {
            let contribution = |i: usize| emitters[i].importance(from);
            let probability = |i| groups.probability(i, from, contribution);
            assert!((0..1500).all(|i| (probability(i) > 0.0) == (contribution(i) > 0.0)));
            let sum: f64 = (0..1500).map(probability).sum();
            let dark = (0..1500).all(|i| contribution(i) == 0.0);
            assert_abs_diff_eq!(sum, if dark { 0.0 } else { 1.0 }, epsilon = 1e-9);
        }
    }
}
