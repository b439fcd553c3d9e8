//! The path tracer: light found by shadow rays, by directions of the BRDF's cosine, or by both with
//! multiple importance sampling; Russian roulette, and no limit on bounces unless one is set.

use glam::DVec3;

use super::next_event::{LightNumbers, LightSample, direct_light, emitter_pdf, light_from, light_of_map};
use super::specular::{Trail, light_by_body};
use super::walk::{Step, Walk};
use super::{Estimator, LightRules, Standard, Walking};
use crate::bsdf::{Bsdf, Vertex};
use crate::emitter::LightSampling;
use crate::rng::{uniform, uniform2};
use crate::roulette::RAISED;
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// How light that reaches a diffuse surface straight from an emitter is found. Each counts it once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strategy {
    /// By the directions in which paths go on, which hit emitters by chance.
    Bsdf,
    /// By shadow rays to points on emitters. With points uniform in area its variance is infinite in
    /// corners of emitting rooms: the geometry term has no bound.
    Light,
    /// By both, weighted by a [`Heuristic`].
    #[default]
    Mis,
}

/// How multiple importance sampling weights: any of them leaves the mean as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heuristic {
    /// [`NextEvent::mis_weight`](super::NextEvent::mis_weight).
    #[default]
    Balance,
    /// [`NextEvent::mis_power_weight`](super::NextEvent::mis_power_weight).
    Power,
}

/// A path tracer: an estimator of (8), or with a limit on bounces of the first terms of its Neumann series.
///
/// It is unbiased in exact arithmetic where no surfaces coincide. Trials show agreement with closed forms and with other
/// estimators on their scenes, to within the δ that each states.
#[derive(Clone, Copy, Debug, Default)]
pub struct Path<P = Standard> {
    /// Its parts.
    pub parts: P,
    /// How it finds direct light.
    pub strategy: Strategy,
    /// How its shadow rays pick points.
    pub lights: LightSampling,
    /// How [`Strategy::Mis`] weights.
    pub heuristic: Heuristic,
    /// How many hits are early for [roulette](crate::roulette::by_throughput).
    pub early: u32,
    /// Whether [`Strategy::Mis`] sends shadow rays by way of [bodies](Scene::bodies) as well, where no environment map
    /// shines.
    pub by_bodies: bool,
    /// How often light is scattered at most on its way from an emitter or the background to the camera; 0 leaves what is
    /// seen directly. `None` is no limit.
    pub bounces: Option<u32>,
}

impl<P> Path<P> {
    /// The plainest: points uniform in area, the balance heuristic, no hits that are early, no bodies, no limit. `render`
    /// takes [`LightSampling::ByContribution`], [`Heuristic::Power`] and [`EARLY`](crate::roulette::EARLY).
    pub fn new(parts: P, strategy: Strategy) -> Self {
        Self {
            parts,
            strategy,
            lights: LightSampling::default(),
            heuristic: Heuristic::default(),
            early: 0,
            by_bodies: false,
            bounces: None,
        }
    }

    /// How many more bounces there may be beyond that at the hit of this number, the first being 1; `None` if there may not
    /// even be that one.
    #[inline]
    pub(crate) fn bounces_beyond(&self, hit: u32) -> Option<u32> {
        self.bounces.unwrap_or(u32::MAX).checked_sub(hit)
    }
}

impl<P: Walking> Path<P> {
    /// Whether shadow rays go by way of bodies in a scene.
    #[inline]
    pub(crate) fn goes_by_bodies(&self, scene: &Scene) -> bool {
        self.by_bodies
            && self.strategy == Strategy::Mis
            && !scene.bodies().all().is_empty()
            && !scene.emitters().is_empty()
            && scene.background().map().is_none()
    }

    /// The weight of an emitter that the path hit. Where the ray's direction has a pdf, a shadow ray could have found the
    /// same light; where it comes from a body, one by way of that.
    #[inline]
    fn weight_of_hit(&self, scene: &Scene, step: &Step<'_>, pdf: Option<f64>, trail: &Trail) -> f64 {
        if pdf.is_none()
            && let Some(index) = step.here.emitter
            && let Some((pdf, other)) = trail.pdfs(&self.parts, scene, index as usize, (step.ray.direction, &step.here))
        {
            return self.weight(pdf, other);
        }
        match (pdf, self.strategy, step.here.emitter) {
            (Some(pdf), Strategy::Mis, Some(index)) => {
                let other = emitter_pdf(&self.parts, scene, index as usize, self.lights, (&step.ray, &step.here));
                let share =
                    scene.background().map().map_or(1.0, |_| 1.0 - self.parts.share_of_map(scene.emitters().len()));
                self.weight(pdf, share * other)
            }
            _ => f64::from(self.parts.hit_counts(self.strategy, pdf.is_some())),
        }
    }

    /// The weight of a sample of pdf `pdf` that the other strategy finds with pdf `other`.
    #[inline]
    fn weight(&self, pdf: f64, other: f64) -> f64 {
        match self.heuristic {
            Heuristic::Balance => self.parts.mis_weight(pdf, other),
            Heuristic::Power => self.parts.mis_power_weight(pdf, other),
        }
    }

    /// The weight of an environment map that the path hit.
    #[inline]
    fn weight_of_background(&self, scene: &Scene, (direction, pdf): (DVec3, Option<f64>)) -> f64 {
        match (scene.background().map(), pdf, self.strategy) {
            (None, ..) => 1.0,
            (Some(map), Some(pdf), Strategy::Mis) => {
                let share = self.parts.share_of_map(scene.emitters().len());
                self.weight(pdf, share * self.parts.map_pdf(map, direction))
            }
            _ => f64::from(self.parts.hit_counts(self.strategy, pdf.is_some())),
        }
    }

    /// Light by a shadow ray from a vertex, weighted; zero for the strategy that sends none.
    #[inline]
    fn shadow_ray<R: Sampler>(&self, scene: &Scene, (bsdf, at): (&Bsdf, &Vertex), beyond: u32, rng: &mut R) -> DVec3 {
        if !bsdf.is_rough() || self.strategy == Strategy::Bsdf {
            return DVec3::ZERO;
        }
        if bsdf.is_rough_glass() {
            return self.weighted_light(scene, (&bsdf.facing(at.outside), at), beyond, rng);
        }
        self.weighted_light(scene, (bsdf, at), beyond, rng)
    }

    #[inline]
    fn weighted_light<R: Sampler>(
        &self,
        scene: &Scene,
        (bsdf, at): (&Bsdf, &Vertex),
        beyond: u32,
        rng: &mut R,
    ) -> DVec3 {
        if !self.goes_by_bodies(scene) || bsdf.is_rough_glass() {
            return self.weighted(bsdf, at, self.light(scene, bsdf, at, rng));
        }
        let numbers = (LightNumbers::new(rng), uniform(rng));
        let light = light_from(&self.parts, scene, (bsdf, at), &LightRules::PHYSICAL, self.lights, numbers.0);
        let weight = |pdf, other| self.weight(pdf, other);
        let by_body = light_by_body(&self.parts, scene, (bsdf, at), (numbers.1, numbers.0, beyond), weight);
        self.weighted(bsdf, at, light) + by_body
    }

    #[inline]
    fn weighted(&self, bsdf: &Bsdf, at: &Vertex, light: Option<LightSample>) -> DVec3 {
        let Some(light) = light else {
            return DVec3::ZERO;
        };
        let weight = if self.strategy == Strategy::Mis {
            let other = self.parts.pdf(bsdf, at.wo, light.wi);
            self.weight(light.pdf, other)
        } else {
            1.0
        };
        weight * light.reflected
    }

    /// Light that a shadow ray finds, on an emitter or in an environment map.
    #[inline]
    fn light<R: Sampler>(&self, scene: &Scene, bsdf: &Bsdf, at: &Vertex, rng: &mut R) -> Option<LightSample> {
        let (parts, rules) = (&self.parts, &LightRules::PHYSICAL);
        let Some(map) = scene.background().map() else {
            return direct_light(parts, scene, bsdf, at, rules, self.lights, rng);
        };
        let share = parts.share_of_map(scene.emitters().len());
        if uniform(rng) < share {
            return light_of_map(parts, (scene, map), bsdf, at, uniform2(rng)).map(|light| light.picked(share));
        }
        direct_light(parts, scene, bsdf, at, rules, self.lights, rng).map(|light| light.picked(1.0 - share))
    }
}

impl<P: Walking> Estimator for Path<P> {
    #[inline]
    fn radiance<R: Sampler>(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut R) -> DVec3 {
        let mut walk = Walk::new(scene, (*ray, hit), 0).raising_to(RAISED, self.early);
        let mut radiance = DVec3::ZERO;
        let (mut trail, follows) = (Trail::LOST, self.goes_by_bodies(scene));
        while let Some(step) = walk.arrive(rng) {
            if step.here.emitter.is_some() {
                let weight = self.weight_of_hit(scene, &step, walk.last().1, &trail);
                radiance += step.factor * weight * step.throughput * step.emitted(scene);
            }
            if matches!(step.bsdf, Bsdf::Black) {
                return radiance;
            }
            let Some(beyond) = self.bounces_beyond(walk.hits()) else {
                return radiance;
            };
            let at = step.vertex();
            radiance += step.factor * step.throughput * self.shadow_ray(scene, (step.bsdf, &at), beyond, rng);
            walk.scatter(&self.parts, &at, rng);
            if follows {
                trail.go_on((scene, step.bsdf), (&step.here, &at), walk.last());
            }
        }
        radiance + self.weight_of_background(scene, walk.last()) * walk.background()
    }

    /// Bounces at mirrors that camera rays follow before it begins would not be counted.
    fn sees_in_mirrors(&self) -> bool {
        self.bounces.is_none()
    }
}
