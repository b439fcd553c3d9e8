//! The report's Monte Carlo estimator: at each diffuse hit a shadow ray and N sample rays over the
//! uniform hemisphere, each ended by Russian roulette, with at most seven segments from the eye.
//!
//! The text does not define the radiance of a ray that hits an emitter. By (8) all light counts
//! once: a hit counts where no shadow ray has sampled the same light, that is before the first
//! diffuse surface and, after a diffuse surface, through mirrors and glass (caustics). The text
//! leaves caustics to later work (3.3), and [`TransportRules::REPORT`] omits them.

use super::lanewise::Lanewise;
use super::{Arrival, Integrator, Parts, PathParts, Strategy, TransportRules};
use crate::math::real::{Mask, Vector};
use crate::math::simd::Wide;
use crate::sampling::lanes::LaneSampler;

/// The report's estimator. Its limit on segments is a bias, [`crate::equation::PATH_LENGTH`].
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// Replaceable parts.
    pub parts: Parts<'a>,
    /// N of (16): sample rays per diffuse hit; with 0 there is direct light alone.
    pub rays: u32,
    /// Maximum number of ray segments from the eye, whatever the kind of bounce.
    pub segments: u32,
    /// How emitters are seen, and whether shadow rays pass glass.
    pub rules: TransportRules,
}

impl Default for Report<'_> {
    fn default() -> Self {
        Self {
            parts: Parts::default(),
            rays: 1,
            segments: 7,
            rules: TransportRules::REPORT,
        }
    }
}

impl Integrator for Report<'_> {
    fn interact<P: PathParts + ?Sized, S: LaneSampler<R>, R: Wide<N>, const N: usize>(
        &self,
        parts: &P,
        mut arrival: Arrival<'_, S, R, N>,
    ) -> R::Mask {
        let (rules, surface, active) = (&self.rules, arrival.surface, arrival.active);
        let (throughput, light_sampled) = (arrival.paths.throughput, arrival.paths.light_sampled);
        // L_e of (8), where next-event estimation has not sampled it.
        let seen =
            surface.emits & parts.lanes_count_emission(Strategy::Light, light_sampled, active);
        if seen.any() {
            arrival.paths.add(surface.emitted_under(rules), seen);
        }
        let diffuse = arrival.add_direct_light(parts, rules);
        let Arrival { paths, random, .. } = arrival;

        // One continuation from mirrors and glass. Where shadow rays pass through glass, they have
        // sampled the light behind it.
        let next = surface.sample(parts, active & !diffuse, random);
        let passes = next
            .direction
            .dot(surface.vertex.frame.z)
            .cmplt(R::splat(0.0));
        let looked_behind =
            R::Mask::splat(!rules.caustics) | passes & R::Mask::splat(rules.shadows_pass_glass);
        let factor = if rules.radiance_factor {
            next.radiance_factor
        } else {
            R::splat(1.0)
        };
        let sampled = diffuse | light_sampled & looked_behind;
        paths.light_sampled = sampled;

        // The first segment is always followed, even with a limit of 0.
        let remain = R::Mask::from_fn(|i| paths.hits[i] < self.segments);
        let mut goes_on = next.exists & remain;
        let (mut direction, mut weight) = (next.direction, next.weight * factor);

        // N sample rays of (16) from diffuse surfaces, each ended by roulette with the surface's
        // absorption.
        let asking = diffuse & remain;
        for _ in 0..self.rays {
            let (survives, compensation) =
                parts.lanes_survive_absorption(surface.absorption, random.uniform(asking), asking);
            let numbers = [random.uniform(survives), random.uniform(survives)];
            let (sampled_direction, reflected) = surface.sample_uniform(parts, numbers, survives);
            let reflected = reflected * (compensation / f64::from(self.rays));
            // The first survivor continues at once, the others later.
            let later = survives & goes_on;
            if later.any() {
                let throughput = throughput * reflected;
                paths.push_branch(surface, sampled_direction, throughput, sampled, later);
            }
            let first = survives & !goes_on;
            direction = Vector::select(first, sampled_direction, direction);
            weight = Vector::select(first, reflected, weight);
            goes_on = goes_on | first;
        }
        paths.continue_with(surface, direction, throughput * weight, goes_on);
        goes_on
    }
}
