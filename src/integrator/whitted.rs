//! Whitted ray tracing, section 2.1: [`crate::equation::WHITTED`].

use super::{Arrival, Integrator, Parts, PathParts, TransportRules};
use crate::math::real::Mask;
use crate::math::simd::Wide;
use crate::sampling::lanes::LaneSampler;

/// Whitted ray tracer: shadow rays at diffuse surfaces, and a tree of mirror and glass rays, both
/// branches of glass weighted by R and 1 − R. It computes emission and direct light of the first
/// diffuse surface, seen through mirrors and glass alone. All other light at that surface is
/// missing: from further diffuse surfaces, from emitters through mirrors and glass (caustics), and
/// from the background.
#[derive(Clone, Copy, Debug)]
pub struct Whitted<'a> {
    /// Replaceable parts.
    pub parts: Parts<'a>,
    /// Maximum number of ray segments from the eye, a bias: the tree doubles at each glass surface.
    pub segments: u32,
    /// How emitters are seen, and whether shadow rays pass glass.
    pub rules: TransportRules,
}

impl Whitted<'_> {
    /// Creates a ray tracer with the report's limit of seven segments.
    pub fn new(rules: TransportRules) -> Self {
        Self {
            parts: Parts::default(),
            segments: 7,
            rules,
        }
    }
}

impl Integrator for Whitted<'_> {
    /// Traces reflection first at glass, and refraction later.
    fn interact<P: PathParts + ?Sized, S: LaneSampler<R>, R: Wide<N>, const N: usize>(
        &self,
        parts: &P,
        mut arrival: Arrival<'_, S, R, N>,
    ) -> R::Mask {
        let (rules, surface, active) = (&self.rules, arrival.surface, arrival.active);
        // L_e of (8) under the rules.
        let emits = active & surface.emits;
        if emits.any() {
            arrival.paths.add(surface.emitted_under(rules), emits);
        }
        arrival.add_direct_light(parts, rules);
        let paths = arrival.paths;

        // Mirrors and both branches of glass. The first segment is always followed, even with a
        // limit of 0.
        let goes_on =
            active & surface.delta() & R::Mask::from_fn(|i| paths.hits[i] < self.segments);
        if goes_on.any() {
            let split = surface.split(parts, rules.radiance_factor, goes_on);
            let throughput = paths.throughput;
            let (direction, weight) = split.refracted;
            let refracts = goes_on & split.refracts;
            if refracts.any() {
                let never = R::Mask::splat(false);
                paths.push_branch(surface, direction, throughput * weight, never, refracts);
            }
            let (direction, weight) = split.reflected;
            paths.continue_with(surface, direction, throughput * weight, goes_on);
        }
        goes_on
    }
}
