//! Path tracer with next-event estimation, BSDF sampling or multiple importance sampling of both,
//! and Russian roulette; without a bounce limit unless one is set.

use std::array::from_fn;

use glam::DVec3;

use super::direct_light::{LightSample, ShadowRays, sample_light_by, sample_light_or_map};
use super::lanewise::{Lanewise, numbers};
use super::light_sampling::{LightNumbers, LightView, light_pdf};
use super::specular_nee::{LightHit, SpecularShadowRay, specular_light};
use super::{
    Arrival, Integrator, MAX_PATH_VERTICES, Parts, PathParts, PathState, ShadingPoint as _,
    SurfaceInteraction,
};
use crate::light::emitter::LightSampling;
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::Wide;
use crate::sampling::lanes::LaneSampler;
use crate::sampling::mis::{Heuristic, Strategy};
use crate::sampling::roulette;
use crate::scene::Scene;
use crate::scene::lanes::{IntersectionScratch, LaneScene};

/// Path tracer: an estimator of (8), or with a bounce limit of the first terms of its Neumann
/// series.
///
/// It is unbiased in exact arithmetic where no surfaces coincide. Trials show agreement with closed
/// forms and with other estimators on their scenes, to within the δ that each states.
#[derive(Clone, Copy, Debug, Default)]
pub struct Path<'a> {
    /// Replaceable parts.
    pub parts: Parts<'a>,
    /// Strategy for direct light.
    pub strategy: Strategy,
    /// Sampling of points by shadow rays.
    pub lights: LightSampling,
    /// Heuristic of [`Strategy::Mis`].
    pub heuristic: Heuristic,
    /// Number of first hits at which the survival probability of
    /// [Russian roulette](crate::sampling::roulette::by_throughput) may reach 1. Unlike Mitsuba's
    /// option of this name, it does not switch roulette off there.
    pub rr_depth: u32,
    /// Whether [`Strategy::Mis`] uses specular next-event estimation through
    /// [casters](Scene::specular_casters), except under an environment map.
    pub specular_nee: bool,
    /// Maximum number of scattering events between the emitter or background and the camera; 0
    /// leaves directly visible light. `None` means no limit.
    pub bounces: Option<u32>,
}

impl<'a> Path<'a> {
    /// Creates the textbook configuration: points uniform in area, balance heuristic, no early
    /// hits, no specular next-event estimation, no bounce limit. [`Path::default()`](Default) is
    /// that of the default strategy. The program `render` has other defaults, which
    /// `experiments/src/render/defaults.rs` lists.
    pub fn new(strategy: Strategy) -> Self {
        Self {
            parts: Parts::default(),
            strategy,
            lights: LightSampling::default(),
            heuristic: Heuristic::default(),
            rr_depth: 0,
            specular_nee: false,
            bounces: None,
        }
    }

    /// Returns this configuration with other parts.
    pub const fn with_parts(self, parts: Parts<'a>) -> Self {
        Self { parts, ..self }
    }

    /// Returns whether specular next-event estimation is used in a scene.
    #[inline]
    fn uses_casters(&self, scene: &Scene) -> bool {
        self.specular_nee
            && self.strategy == Strategy::Mis
            && !scene.specular_casters().all().is_empty()
            && !scene.emitters().is_empty()
            && scene.background().map().is_none()
    }

    /// Returns the MIS weight of samples with pdf `pdf` that the other strategy finds with pdf
    /// `other`.
    #[inline]
    fn weight<P: PathParts + ?Sized, R: Real>(
        &self,
        parts: &P,
        pdf: R,
        other: R,
        active: R::Mask,
    ) -> R {
        parts.lanes_mis_weight(self.heuristic, pdf, other, active)
    }

    /// Returns the lanes whose emission has an MIS weight, among those in which shadow rays sample
    /// the same light.
    #[inline]
    fn weighted<M: Mask>(&self, light_sampled: M) -> M {
        light_sampled & M::splat(self.strategy == Strategy::Mis)
    }

    /// Returns the MIS weights of emitters that the active paths have hit. If the ray's direction
    /// has a pdf, a shadow ray could have found the same light; if the ray comes from a specular
    /// caster, a specular connection could have.
    #[inline]
    fn hit_weight<P: PathParts + ?Sized, R: Wide<N>, const N: usize>(
        &self,
        parts: &P,
        scene: LaneScene<'_, R, N>,
        paths: &PathState<R, N>,
        surface: &SurfaceInteraction<'_, R, N>,
        active: R::Mask,
    ) -> R {
        let cosine = parts.lanes_cosine(surface.normal, -paths.ray.direction, active);
        let emitter = from_fn(|i| surface.emitter(i).map_or(0, |emitter| emitter as usize));
        let weighted = self.weighted(active & paths.light_sampled);
        let (past, chain_pdf, chain_other) = if self.uses_casters(scene.scene) {
            let light = LightHit {
                emitter,
                point: surface.vertex.point,
                cosine,
            };
            paths
                .chains
                .pdfs(parts, scene, &light, active & !paths.light_sampled)
        } else {
            (R::Mask::splat(false), R::splat(0.0), R::splat(0.0))
        };
        let counts = parts.lanes_count_emission(
            self.strategy,
            paths.light_sampled,
            active & !weighted & !past,
        );
        let mut weight = R::select(counts, R::splat(1.0), R::splat(0.0));
        if weighted.any() {
            let view = LightView {
                emitter,
                cosine,
                distance_squared: surface.t * surface.t,
            };
            let (scene, from) = (scene.scene, paths.ray.origin);
            let mut other = light_pdf(parts, scene, self.lights, from, view, weighted);
            if scene.background().map().is_some() {
                other = other * (1.0 - parts.map_probability(scene.emitters().len()));
            }
            let of_hits = self.weight(parts, paths.pdf, other, weighted);
            weight = R::select(weighted, of_hits, weight);
        }
        if past.any() {
            let of_chains = self.weight(parts, chain_pdf, chain_other, past);
            weight = R::select(past, of_chains, weight);
        }
        weight
    }

    /// Returns weighted direct light at non-delta surfaces, found by shadow rays.
    #[inline]
    fn direct_light<P: PathParts + ?Sized, S: LaneSampler<R>, R: Wide<N>, const N: usize>(
        &self,
        parts: &P,
        scene: LaneScene<'_, R, N>,
        surface: &SurfaceInteraction<'_, R, N>,
        Asking {
            active,
            remaining_bounces,
        }: Asking<R, N>,
        random: &mut S,
        scratch: &mut IntersectionScratch<R, N>,
    ) -> R::Vector {
        let rays = ShadowRays {
            lights: self.lights,
            pass_glass: false,
        };
        let none = R::Vector::zero();
        let weighted = |light: LightSample<R>| {
            let weight = if self.strategy == Strategy::Mis {
                let other = surface.pdf(parts, light.wi, light.arrives);
                self.weight(parts, light.pdf, other, light.arrives)
            } else {
                R::splat(1.0)
            };
            Vector::select(light.arrives, light.reflected * weight, none)
        };
        if scene.scene.background().map().is_some() {
            let light = sample_light_or_map(parts, scene, surface, rays, active, random, scratch);
            return weighted(light);
        }
        let numbers = LightNumbers::new(scene.scene, active, random);
        let light = sample_light_by(parts, scene, surface, rays, &numbers, active, scratch);
        let reflected = weighted(light);
        let by_casters = active & !surface.rough_glass();
        if !by_casters.any() || !self.uses_casters(scene.scene) {
            return reflected;
        }
        let shadow_ray = SpecularShadowRay {
            caster: random.uniform(by_casters),
            light: &numbers,
            remaining_bounces,
        };
        let weight = |pdf, other, active| self.weight(parts, pdf, other, active);
        reflected
            + specular_light(
                parts, scene, surface, shadow_ray, weight, by_casters, scratch,
            )
    }
}

/// Lanes that send shadow rays, and the bounces that a limit leaves to each.
struct Asking<R: Wide<N>, const N: usize> {
    active: R::Mask,
    remaining_bounces: Option<[Option<u32>; N]>,
}

impl Integrator for Path<'_> {
    fn interact<P: PathParts + ?Sized, S: LaneSampler<R>, R: Wide<N>, const N: usize>(
        &self,
        parts: &P,
        arrival: Arrival<'_, S, R, N>,
    ) -> R::Mask {
        let Arrival {
            scene,
            paths,
            surface,
            active,
            random,
            scratch,
        } = arrival;
        random.start_blocks(active, &paths.hits);
        // A path that will not end is an error and never truncated.
        let endless = active & R::Mask::from_fn(|i| paths.hits[i] > MAX_PATH_VERTICES);
        let throughput = Vector::select(
            endless,
            R::Vector::splat_vector(DVec3::NAN),
            paths.throughput,
        );

        // L_e of (8): an emitter that the path has hit.
        let emits = active & surface.emits;
        if emits.any() {
            let weight = self.hit_weight(parts, scene, paths, surface, emits);
            let added = paths.radiance + throughput * (paths.factor * weight) * surface.emitted();
            paths.radiance = Vector::select(emits, added, paths.radiance);
        }

        // Bounces that the limit still allows, if there is one.
        let remaining_bounces = self
            .bounces
            .map(|bounces| paths.hits.map(|hit| bounces.checked_sub(hit)));
        let within = remaining_bounces.map_or(active, |left| {
            active & R::Mask::from_fn(|i| left[i].is_some())
        });
        let scatters = within & (surface.non_delta | surface.delta());

        // f_r L_e cos θ / p of (8): light that shadow rays find.
        if self.strategy != Strategy::Bsdf {
            let asking = Asking {
                active: within & surface.non_delta,
                remaining_bounces,
            };
            let reflected = self.direct_light(parts, scene, surface, asking, random, scratch);
            let added = paths.radiance + throughput * paths.factor * reflected;
            paths.radiance = Vector::select(scatters, added, paths.radiance);
        }

        // f_r cos θ / p of (8): BSDF sampling.
        let next = surface.sample(parts, scatters & !endless, random);
        let throughput = paths.throughput * next.weight;

        // Russian roulette. One number decides several games, so that the paths that survive are
        // as evenly distributed over the directions of their first hit as all are.
        let early = R::Mask::from_fn(|i| paths.hits[i] <= self.rr_depth);
        let asks = next.exists & paths.roulette_share.cmplt(R::splat(roulette::LEAST_SHARE));
        let (mut number, mut share) = (paths.roulette, paths.roulette_share);
        if asks.any() {
            number = R::select(asks, random.uniform(asks), number);
            share = R::select(asks, R::splat(1.0), share);
        }
        let relative = throughput * R::splat(1.0 / roulette::REFERENCE_THROUGHPUT);
        let game = parts.lanes_survive(relative, early, number, next.exists);
        let (survives, weight) = (game.survives, game.weight);
        paths.roulette = R::select(survives, game.next, paths.roulette);
        paths.roulette_share = R::select(survives, share * game.survival, paths.roulette_share);

        paths.factor = R::select(survives, paths.factor * next.radiance_factor, paths.factor);
        paths.pdf = R::select(survives, next.pdf, paths.pdf);
        paths.light_sampled = next.has_pdf;
        if self.uses_casters(scene.scene) {
            paths.chains.advance(surface, &next, survives);
        }
        paths.continue_with(surface, next.direction, throughput * weight, survives);
        survives
    }

    /// Adds background radiance, weighted where a shadow ray could have sampled its map.
    #[inline]
    fn escape<P: PathParts + ?Sized, R: Wide<N>, const N: usize>(
        &self,
        parts: &P,
        scene: &Scene,
        paths: &mut PathState<R, N>,
        leaving: R::Mask,
    ) {
        let one = R::splat(1.0);
        let Some(map) = scene.background().map().filter(|_| leaving.any()) else {
            return paths.add_background(scene, one, leaving);
        };
        let weighted = self.weighted(leaving & paths.light_sampled);
        let counts =
            parts.lanes_count_emission(self.strategy, paths.light_sampled, leaving & !weighted);
        let share = parts.map_probability(scene.emitters().len());
        let other = numbers(weighted, |i| {
            share * parts.map_pdf(map, paths.ray.direction.lane(i))
        });
        let weight = R::select(counts, one, R::splat(0.0));
        let of_map = self.weight(parts, paths.pdf, other, weighted);
        let weight = R::select(weighted, of_map, weight);
        paths.add_background(scene, weight, leaving);
    }

    /// Bounces at mirrors before the first hit would not count towards a limit.
    fn sees_in_mirrors(&self) -> bool {
        self.bounces.is_none()
    }
}
