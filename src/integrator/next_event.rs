//! The replaceable parts of next-event estimation.

use glam::DVec3;

use crate::geometry::radiometry;
use crate::geometry::shape::SurfacePoint;
use crate::geometry::specular_connection::{CasterKind, SpecularConnection};
use crate::light::emitter::{Emitter, EmitterPoint};
use crate::light::environment::EnvironmentMap;
use crate::light::light_sampler;
use crate::light::light_sampler::PowerLightSampler;
use crate::sampling::mis;
use crate::sampling::mis::Strategy;
use crate::scene::Scene;
use crate::scene::specular_casters::SpecularCaster;

/// Replaceable parts of next-event estimation.
pub trait NextEvent: Sync {
    /// Picks the emitter of a particle, or of a shadow ray that picks independently of its origin.
    #[inline]
    fn pick_emitter(&self, r: f64, picks: &PowerLightSampler) -> usize {
        picks.pick(r)
    }
    /// Returns an estimate of the irradiance from an emitter at a point, used as importance.
    #[inline]
    fn emitter_importance(&self, emitter: &Emitter, from: DVec3) -> f64 {
        emitter.importance(from)
    }
    /// Picks an emitter by selection probabilities, and returns its index and probability.
    #[inline]
    fn pick_by_probability(&self, r: f64, shares: &[f64]) -> (usize, f64) {
        let (index, share) = light_sampler::pick(shares, r);
        (index as usize, share)
    }
    /// Returns the pdf of a point on an emitter that is picked with this probability, from its pdf
    /// on that emitter, with respect to the same measure.
    #[inline]
    fn pdf_of_pick(&self, pdf: f64, probability: f64) -> f64 {
        pdf * probability
    }
    /// Samples a point on an emitter, uniformly in area.
    #[inline]
    fn sample_emitter(&self, emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
        emitter.sample(random)
    }
    /// Returns the pdf of [`sample_emitter`](Self::sample_emitter) with respect to area.
    #[inline]
    fn emitter_pdf_area(&self, emitter: &Emitter) -> f64 {
        emitter.pdf_area()
    }
    /// Returns the solid angle per area of an emitter.
    #[inline]
    fn solid_angle_per_area(&self, cosine_at_emitter: f64, distance_squared: f64) -> f64 {
        radiometry::solid_angle_per_area(cosine_at_emitter, distance_squared)
    }
    /// Samples a point on an emitter uniformly in the solid angle seen from a point, and returns
    /// its pdf with respect to solid angle, too; `None` for emitters that are sampled by area
    /// alone.
    #[inline]
    fn sample_solid_angle(
        &self,
        emitter: &Emitter,
        from: DVec3,
        random: [f64; 2],
    ) -> Option<(EmitterPoint, f64)> {
        emitter.sample_solid_angle(from, random)
    }
    /// Returns the pdf of [`sample_solid_angle`](Self::sample_solid_angle) for any point of the
    /// emitter's front.
    #[inline]
    fn pdf_solid_angle(&self, emitter: &Emitter, from: DVec3) -> Option<f64> {
        emitter.pdf_solid_angle(from)
    }
    /// Returns the probability that a shadow ray samples the environment map rather than one of
    /// `count` emitters.
    #[inline]
    fn map_probability(&self, count: usize) -> f64 {
        if count == 0 { 1.0 } else { 0.5 }
    }
    /// Samples a direction towards an environment map, and returns its pdf (solid angle), too.
    #[inline]
    fn sample_map(&self, map: &EnvironmentMap, random: [f64; 2]) -> (DVec3, f64) {
        map.sample(random)
    }
    /// Returns the pdf of [`sample_map`](Self::sample_map) for any direction.
    #[inline]
    fn map_pdf(&self, map: &EnvironmentMap, direction: DVec3) -> f64 {
        map.pdf(direction)
    }
    /// Returns whether a surface point sees the background in a direction.
    #[inline]
    fn sees_background(&self, scene: &Scene, x: SurfacePoint, direction: DVec3) -> bool {
        scene.sees_background(x, direction)
    }
    /// Returns whether two surface points are mutually visible, through glass if
    /// `glass` is set.
    #[inline]
    fn visible(&self, scene: &Scene, x: SurfacePoint, y: SurfacePoint, glass: bool) -> bool {
        scene.visible(x, y, glass)
    }
    /// Returns the weight of a sample by the balance heuristic.
    #[inline]
    fn mis_weight(&self, pdf: f64, other: f64) -> f64 {
        mis::balance(pdf, other)
    }
    /// Returns the weight of a sample by the power heuristic.
    #[inline]
    fn mis_power_weight(&self, pdf: f64, other: f64) -> f64 {
        mis::power(pdf, other)
    }
    /// Returns the specular connection through a caster, one of up to three, that is used; `None`
    /// omits it.
    #[inline]
    fn connection(
        &self,
        _: &SpecularCaster,
        _number: usize,
        connection: SpecularConnection<DVec3>,
    ) -> Option<SpecularConnection<DVec3>> {
        Some(connection)
    }
    /// Returns the throughput of a caster that is met at this cosine, and the probability that a
    /// path samples that branch.
    #[inline]
    fn caster_throughput(&self, caster: &SpecularCaster, cosine: f64) -> (DVec3, f64) {
        caster
            .parameters
            .caster_throughput(cosine, caster.kind == CasterKind::Refraction)
    }
    /// Returns whether emission that a path hits counts without an MIS weight; `sampled` if shadow
    /// rays sample the same light (in [`Report`](crate::integrator::Report): or if its rules leave
    /// it out).
    #[inline]
    fn counts_emission(&self, strategy: Strategy, sampled: bool) -> bool {
        !(sampled && strategy == Strategy::Light)
    }
}
