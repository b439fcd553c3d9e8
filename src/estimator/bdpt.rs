//! Bidirectional path tracing (Lafortune and Willems 1993; Veach 1997, chapter 10): a path from the eye
//! and one from a light, connected in every way that there is, or to the other's end alone.

use glam::DVec3;
use rayon::prelude::*;

use super::next_event::{SHADOW_RAYS, direct_light, picked_pdf};
use super::particle::{connect_to_eye, importance_per_particle, particle};
use super::strategies::{Bidirectional, PathVertex, WholePath};
use super::walk::{Step, Walk};
use super::{ImageEstimator, LightRules, Standard, Walking};
use crate::bsdf::{Bsdf, Vertex};
use crate::error::Error;
use crate::rng::uniform2;
use crate::sampler::{Pass, Sampler};
use crate::scene::Scene;
use crate::splat::Splats;

/// Which vertices of the two walks are connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connections {
    /// Every one with every other.
    All,
    /// Those of the particle with the eye, and those of the eye's path with a point on a light.
    /// A cheaper pass, with the same caustics.
    Ends,
}

/// One camera ray and one particle per pixel and pass, an unbiased estimator of (8) on every scene.
///
/// A path with s vertices from the light and t from the eye is found when the eye's part hits an emitter
/// (s = 0), by a shadow ray to a fresh point of an emitter (s = 1), when the particle is seen (t = 1), and
/// by connecting the two parts otherwise. [`Bidirectional::strategy_weight`] combines them. No particle starts
/// from the background: only the eye's part finds its light.
#[derive(Clone, Copy, Debug)]
pub struct Bdpt<P = Standard> {
    /// Its parts.
    pub parts: P,
    /// The strategies that there are.
    pub connections: Connections,
}

impl<P: Walking + Bidirectional> ImageEstimator for Bdpt<P> {
    fn image(&self, scene: &Scene, frame: [u32; 2], pass: Pass) -> Result<Vec<DVec3>, Error> {
        let image = Splats::new(frame);
        (0..frame[0] * frame[1]).into_par_iter().try_for_each(|pixel| {
            let mut rng = pass.pixel(pixel);
            let [x, y] = [pixel % frame[0], pixel / frame[0]];
            self.pair(scene, [x, y], frame, &image, &mut rng)
                .map_err(|error| error.at(|| format!(" at pixel ({x}, {y})")))
        })?;
        Ok(image.into_values())
    }
}

impl<P> Bdpt<P> {
    /// Every strategy, made of these parts.
    pub const fn new(parts: P) -> Self {
        Self { parts, connections: Connections::All }
    }
}

impl<P: Walking + Bidirectional> Bdpt<P> {
    /// Adds what a particle and a camera ray through a random point of a pixel find.
    pub fn pair<R: Sampler>(
        &self,
        scene: &Scene,
        pixel: [u32; 2],
        frame: [u32; 2],
        image: &Splats,
        rng: &mut R,
    ) -> Result<(), Error> {
        let light = self.light_path(scene, frame, image, rng)?;
        let radiance = self.eye_path(scene, frame, pixel, &light, rng);
        image.add(pixel, radiance)
    }

    /// Follows a particle, adds what the eye sees of it (t = 1), and returns where it was.
    fn light_path<'a, R: Sampler>(
        &self,
        scene: &'a Scene,
        frame: [u32; 2],
        image: &Splats,
        rng: &mut R,
    ) -> Result<Vec<PathVertex<'a>>, Error> {
        let mut light = Vec::new();
        particle(&self.parts, scene, rng, |place| {
            light.push(place);
            if let [start, next] = &mut light[..] {
                let emitter = start.emitter.map(|emitter| (emitter as usize, &start.at));
                start.picked = emitter.map(|emitter| picked_pdf(&self.parts, scene, emitter, next.at.point));
            }
            if let Some(splat) = connect_to_eye(&self.parts, scene, frame, &place) {
                let (origin, importance) = (scene.camera().eye, splat.importance);
                let path = WholePath { light: &light, eye: &[], origin, importance };
                image.add(splat.pixel, self.weight(scene, path) * splat.value)?;
            }
            Ok(())
        })?;
        Ok(light)
    }

    /// The radiance through a random point of a pixel by all strategies but t = 1.
    fn eye_path<R: Sampler>(
        &self,
        scene: &Scene,
        frame: [u32; 2],
        pixel: [u32; 2],
        light: &[PathVertex<'_>],
        rng: &mut R,
    ) -> DVec3 {
        rng.block(0);
        let [x, y] = uniform2(rng);
        let [column, row] = pixel.map(f64::from);
        let ray = scene.camera().ray(frame, column + x, row + y);
        let whole = WholePath {
            light: &[],
            eye: &[],
            origin: ray.origin,
            importance: importance_per_particle(&self.parts, scene, frame, ray.direction),
        };
        let mut radiance = DVec3::ZERO;
        let mut eye = Vec::new();
        let mut walk = Walk::new(scene, (ray, scene.intersect(&ray)), 0);
        while let Some(step) = walk.arrive(rng) {
            let at = step.vertex();
            eye.push(step.path_vertex(at, DVec3::ZERO));
            let found = self.found(scene, (&step, &at), WholePath { eye: &eye, ..whole }, light, rng);
            radiance += step.throughput * step.factor * found;
            walk.scatter(&self.parts, &at, rng);
        }
        radiance + walk.background()
    }

    /// The radiance that leaves a hit of the eye's path towards the eye, by every strategy that joins the
    /// light's path here.
    fn found<R: Sampler>(
        &self,
        scene: &Scene,
        (step, vertex): (&Step<'_>, &Vertex),
        path: WholePath<'_>,
        light: &[PathVertex<'_>],
        rng: &mut R,
    ) -> DVec3 {
        let parts = &self.parts;
        let mut found = step.emitted(scene);
        if found != DVec3::ZERO {
            found *= self.weight(scene, path);
        }
        let bsdf = step.bsdf;
        if !bsdf.is_rough() {
            return found;
        }
        if let Some(direct) = direct_light(parts, scene, bsdf, vertex, &LightRules::PHYSICAL, SHADOW_RAYS, rng)
            && let Some((point, emitter)) = &direct.point
        {
            let light = &[PathVertex::emitting(point, DVec3::ZERO, *emitter)];
            found += direct.reflected * self.weight(scene, WholePath { light, ..path });
        }
        if self.connections == Connections::Ends {
            return found;
        }
        for s in 2..=light.len() {
            let connected = self.connect(scene, bsdf, vertex, &light[s - 1]);
            if connected != DVec3::ZERO {
                let light = &light[..s];
                found += connected * self.weight(scene, WholePath { light, ..path });
            }
        }
        found
    }

    /// What a vertex of the eye's path reflects of the light that reaches it from a place of the
    /// particle, before any weight.
    #[inline]
    fn connect(&self, scene: &Scene, bsdf: &Bsdf, vertex: &Vertex, place: &PathVertex<'_>) -> DVec3 {
        let parts = &self.parts;
        let (here, there) = ((vertex.point, vertex.frame.z), (place.at.point, place.normal()));
        let offset = there.0 - here.0;
        let distance_squared = offset.length_squared();
        let direction = offset * distance_squared.sqrt().recip();
        let cosine = parts.cosine(here.1, direction);
        let cosine_there = parts.cosine(there.1, -direction);
        if cosine <= 0.0 || cosine_there <= 0.0 {
            return DVec3::ZERO;
        }
        let leaving = place.leaving(parts, -direction);
        let brdf = parts.brdf(bsdf, vertex.wo, vertex.frame.local(direction));
        let value = leaving * brdf * cosine * parts.solid_angle_per_area(cosine_there, distance_squared);
        if value == DVec3::ZERO || !parts.visible(scene, here, there, false) {
            return DVec3::ZERO;
        }
        value
    }

    /// The weight of the strategy that made a path of these two pieces.
    #[inline]
    fn weight(&self, scene: &Scene, path: WholePath<'_>) -> f64 {
        let mut densities = path.densities(&self.parts, scene);
        if self.connections == Connections::Ends
            && let [_, inner @ .., _] = &mut densities[..]
        {
            inner.iter_mut().for_each(|density| density.joined = 0.0);
        }
        self.parts.strategy_weight(&densities, path.light.len())
    }
}
