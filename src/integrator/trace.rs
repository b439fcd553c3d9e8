//! Radiance along rays that each have their own sampler.

use std::array::from_fn;

use glam::DVec3;

use super::PathParts;
use super::interaction::SurfaceInteraction;
use super::path_state::{Arrival, Integrator, PathState};
use crate::geometry::shape::Ray;
use crate::math::real::{Mask, Vector};
use crate::math::simd::{Wide, lanes_of};
use crate::sampling::lanes::Sources;
use crate::sampling::sampler::Sampler;
use crate::scene::Scene;
use crate::scene::lanes::{IntersectionScratch, LaneScene};

/// Estimates the radiance along rays, in their order, `N` at a time; each value is the same as for
/// the ray alone.
pub(crate) fn radiances<
    E: Integrator,
    P: PathParts + ?Sized,
    S: Sampler,
    R: Wide<N>,
    const N: usize,
>(
    scene: &Scene,
    estimator: &E,
    parts: &P,
    rays: &mut dyn Iterator<Item = (Ray, S)>,
) -> Vec<DVec3> {
    let lanes: LaneScene<'_, R, N> = LaneScene::new(scene);
    let mut rays = rays.enumerate();
    let mut radiances = Vec::new();
    let mut random: Sources<S, N> = Sources(from_fn(|_| None));
    let (mut number, mut busy) = ([0; N], 0_u32);
    let mut paths: PathState<R, N> = PathState::new();
    let mut scratch = IntersectionScratch::new();
    loop {
        let mut started: [Option<Ray>; N] = [None; N];
        for lane in lanes_of(!busy & u32::MAX >> (32 - N)) {
            if let Some((i, (ray, source))) = rays.next() {
                (number[lane], random.0[lane], started[lane]) = (i, Some(source), Some(ray));
                radiances.push(DVec3::ZERO);
            }
        }
        let starting = R::Mask::from_fn(|i| started[i].is_some());
        if starting.any() {
            let none = Ray::new(DVec3::Z, DVec3::Z);
            paths.start(&Ray::from_fn(|i| started[i].unwrap_or(none)), starting);
            busy |= starting.bits();
        }
        if busy == 0 {
            return radiances;
        }
        let found = lanes.closest(&paths.ray, R::Mask::from_bits(busy), &mut scratch);
        let hit_bits = found.hit_mask.bits();
        let mut ended = busy & !hit_bits;
        estimator.escape(parts, scene, &mut paths, R::Mask::from_bits(ended));
        if hit_bits != 0 {
            let surface = SurfaceInteraction::new(lanes, &paths.ray, &found);
            lanes_of(hit_bits).for_each(|lane| paths.hits[lane] += 1);
            let (paths, surface, active) = (&mut paths, &surface, found.hit_mask);
            let (random, scratch) = (&mut random, &mut scratch);
            let goes_on = estimator.interact(
                parts,
                Arrival {
                    scene: lanes,
                    paths,
                    surface,
                    active,
                    random,
                    scratch,
                },
            );
            ended = busy & !goes_on.bits();
        }
        ended &= !paths.pop_branches(ended);
        busy &= !ended;
        for lane in lanes_of(ended) {
            radiances[number[lane]] = paths.radiance.lane(lane);
        }
    }
}
