//! Bidirectional path tracing (Lafortune and Willems 1993; Veach 1997, chapter 10): connects a path
//! from the eye with one from a light by all strategies, or only to the other path's endpoint.

use glam::DVec3;
use rayon::prelude::*;

use super::direct_light::{ShadowRays, direct_light, light_sampling_pdf};
use super::particle::{ParticleEvent, camera_pdf_per_particle, connect_to_eye, particles};
use super::strategies::{Bidirectional, Density, FullPath, PathVertex};
use super::walk::{PendingWalk, WalkEvent, WalkHit, in_batches, trace_walks};
use super::{ImageEstimator, Parts, PathParts, with_parts};
use crate::error::Error;
use crate::film::splat::{SplatBuffer, Splats};
use crate::geometry::shape::SurfacePoint;
use crate::material::{Bsdf, Vertex};
use crate::sampling::rng::uniform2;
use crate::sampling::sampler::{ImagePass, Sampler};
use crate::scene::Scene;

/// Which vertices of the eye path and the light path are connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connections {
    /// Every vertex with every vertex.
    All,
    /// The particle's vertices with the eye, and the eye path's vertices with a point on a light. A
    /// cheaper pass, with the same caustics.
    Endpoints,
}

/// Bidirectional path tracer, an estimator of (8): one camera ray and one particle per pixel and
/// pass.
///
/// It is unbiased in exact arithmetic where no surfaces coincide. Trials show agreement with closed
/// forms and with other estimators on their scenes, to within the δ that each states.
///
/// A path with s vertices from the light and t from the eye is found when the eye path hits an
/// emitter (s = 0), by a shadow ray to a fresh point of an emitter (s = 1), when the particle is
/// connected to the eye (t = 1), and by connecting the two subpaths otherwise.
/// [`Bidirectional::strategy_weight`] combines them. No particle starts from the background: only
/// the eye path finds its light.
#[derive(Clone, Copy, Debug)]
pub struct Bdpt<'a> {
    /// Replaceable parts.
    pub parts: Parts<'a>,
    /// Strategies that are used.
    pub connections: Connections,
}

impl ImageEstimator for Bdpt<'_> {
    fn image(
        &self,
        scene: &Scene,
        resolution: [u32; 2],
        pass: ImagePass,
    ) -> Result<Vec<DVec3>, Error> {
        let image = Splats::new(resolution);
        let buffers = || (Vec::new(), image.buffer());
        in_batches(resolution[0] * resolution[1]).try_for_each_init(
            buffers,
            |(spare, splats), pixels| {
                let place = |pixel| [pixel % resolution[0], pixel / resolution[0]];
                let mut pixels = pixels.map(|pixel| (place(pixel), pass.pixel_stream(pixel)));
                with_parts!(self.parts, |parts| self.with(parts).pairs(
                    scene,
                    &mut pixels,
                    resolution,
                    splats,
                    spare
                ))?;
                splats.flush()
            },
        )?;
        Ok(image.into_values())
    }
}

/// Eye path and light path of a pixel.
struct Pair<'a> {
    pixel: [u32; 2],
    /// Vertices of the light path.
    light: Vec<PathVertex<'a>>,
    /// Vertices of the eye path.
    eye: Vec<PathVertex<'a>>,
    camera_pdf: f64,
    radiance: DVec3,
}

impl<'a> Bdpt<'a> {
    /// Creates a path tracer with these parts and all strategies.
    pub const fn new(parts: Parts<'a>) -> Self {
        Self {
            parts,
            connections: Connections::All,
        }
    }

    /// Traces a particle and a camera ray through a random point of a pixel, and adds their
    /// contributions.
    pub fn pair(
        &self,
        scene: &Scene,
        pixel: [u32; 2],
        resolution: [u32; 2],
        image: &Splats,
        rng: &mut dyn Sampler,
    ) -> Result<(), Error> {
        let mut splats = image.buffer();
        with_parts!(self.parts, |parts| self.with(parts).pairs(
            scene,
            &mut std::iter::once((pixel, rng)),
            resolution,
            &mut splats,
            &mut Vec::new(),
        ))?;
        splats.flush()
    }

    fn with<'p, P: ?Sized>(&self, parts: &'p P) -> Tracer<'p, P> {
        Tracer {
            parts,
            connections: self.connections,
        }
    }
}

/// A [`Bdpt`] with parts of one type.
struct Tracer<'p, P: ?Sized> {
    parts: &'p P,
    connections: Connections,
}

impl<P: PathParts + Bidirectional + ?Sized> Tracer<'_, P> {
    /// Traces a particle and a camera ray for each of several pixels. `spare` holds vertex buffers
    /// for reuse.
    fn pairs<'s, R: Sampler>(
        &self,
        scene: &'s Scene,
        pixels: &mut dyn Iterator<Item = ([u32; 2], R)>,
        resolution: [u32; 2],
        splats: &mut SplatBuffer<'_>,
        spare: &mut Vec<Vec<PathVertex<'s>>>,
    ) -> Result<(), Error> {
        let parts = self.parts;
        let named = |error: Error, [x, y]: [u32; 2]| error.at(|| format!(" at pixel ({x}, {y})"));
        let mut items = pixels.map(|(pixel, rng)| {
            let [light, eye] = [(); 2].map(|()| spare.pop().unwrap_or_default());
            (
                Pair {
                    pixel,
                    light,
                    eye,
                    camera_pdf: 0.0,
                    radiance: DVec3::ZERO,
                },
                rng,
            )
        });
        let (mut pairs, mut densities) = (Vec::new(), Vec::new());
        particles(
            parts,
            scene,
            &mut items,
            |error, pair: &Pair<'_>| named(error, pair.pixel),
            |event| {
                match event {
                    ParticleEvent::Vertex(pair, light_vertex) => {
                        return self.by_particle(
                            scene,
                            light_vertex,
                            &mut pair.light,
                            &mut densities,
                            resolution,
                            splats,
                        );
                    }
                    ParticleEvent::End(pair, rng) => pairs.push((pair, rng)),
                }
                Ok(())
            },
        )?;
        let eye = scene.camera().eye;
        let mut starts = pairs.into_iter().map(|(mut item, mut rng)| {
            rng.block(0);
            let [x, y] = uniform2(&mut rng);
            let [column, row] = item.pixel.map(f64::from);
            let ray = scene.camera().ray(resolution, column + x, row + y);
            item.camera_pdf = camera_pdf_per_particle(parts, scene, resolution, ray.direction);
            PendingWalk::new(item, Some(ray), 0, rng)
        });
        trace_walks(parts, scene, &mut starts, |event| match event {
            WalkEvent::Hit(pair, step, at, rng) => {
                let vertex = step.path_vertex(*at, DVec3::ZERO);
                pair.eye.push(vertex.after(parts, &pair.eye));
                let path = FullPath {
                    light: &pair.light,
                    eye: &pair.eye,
                    origin: eye,
                    camera_pdf: pair.camera_pdf,
                };
                let found = self.found(scene, step, at, path, &mut densities, rng);
                pair.radiance += step.throughput * step.factor * found;
                Ok(true)
            }
            WalkEvent::End(pair, background, _) => {
                for mut vertices in [pair.light, pair.eye] {
                    vertices.clear();
                    spare.push(vertices);
                }
                splats
                    .add(pair.pixel, pair.radiance + background)
                    .map_err(|error| named(error, pair.pixel))?;
                Ok(false)
            }
        })
    }

    /// Appends a particle's vertex to its light path and connects it to the eye (t = 1).
    fn by_particle<'s>(
        &self,
        scene: &Scene,
        light_vertex: &PathVertex<'s>,
        light: &mut Vec<PathVertex<'s>>,
        densities: &mut Vec<Density>,
        resolution: [u32; 2],
        splats: &mut SplatBuffer<'_>,
    ) -> Result<(), Error> {
        let parts = self.parts;
        light.push(light_vertex.after(parts, light));
        if let [start, next] = &mut light[..] {
            let emitter = start.emitter.map(|emitter| emitter as usize);
            start.sampling_pdf = emitter
                .map(|emitter| light_sampling_pdf(parts, scene, emitter, &start.at, next.at.point));
        }
        if let Some(splat) = connect_to_eye(parts, scene, resolution, light_vertex) {
            let (origin, camera_pdf) = (scene.camera().eye, splat.camera_pdf);
            let path = FullPath {
                light,
                eye: &[],
                origin,
                camera_pdf,
            };
            splats.add(
                splat.pixel,
                self.weight(scene, path, densities) * splat.value,
            )?;
        }
        Ok(())
    }

    /// Returns the radiance from a hit of the eye path towards the eye, over all strategies with a
    /// connection here. `path` holds all vertices of both subpaths.
    fn found<R: Sampler>(
        &self,
        scene: &Scene,
        step: &WalkHit<'_>,
        vertex: &Vertex,
        path: FullPath<'_>,
        densities: &mut Vec<Density>,
        rng: &mut R,
    ) -> DVec3 {
        let parts = self.parts;
        let mut found = step.emitted(scene);
        if found != DVec3::ZERO {
            let hit = FullPath { light: &[], ..path };
            found *= self.weight(scene, hit, densities);
        }
        let bsdf = step.bsdf;
        if !bsdf.is_non_delta() {
            return found;
        }
        if let Some(direct) = direct_light(parts, scene, bsdf, vertex, ShadowRays::DEFAULT, rng) {
            let light = &[PathVertex::emitting(
                &direct.point,
                DVec3::ZERO,
                direct.emitter,
            )];
            found += direct.reflected * self.weight(scene, FullPath { light, ..path }, densities);
        }
        if self.connections == Connections::Endpoints {
            return found;
        }
        for s in 2..=path.light.len() {
            let connected = connect(parts, scene, bsdf, vertex, &path.light[s - 1]);
            if connected != DVec3::ZERO {
                let light = &path.light[..s];
                found += connected * self.weight(scene, FullPath { light, ..path }, densities);
            }
        }
        found
    }

    /// Returns the MIS weight of the strategy that made a path of these two subpaths; `densities`
    /// is a buffer.
    #[inline]
    fn weight(&self, scene: &Scene, path: FullPath<'_>, densities: &mut Vec<Density>) -> f64 {
        path.densities(self.parts, scene, densities);
        if self.connections == Connections::Endpoints
            && let [_, inner @ .., _] = &mut densities[..]
        {
            inner
                .iter_mut()
                .for_each(|density| density.connectible = 0.0);
        }
        self.parts.strategy_weight(densities, path.light.len())
    }
}

/// Returns the unweighted radiance that reaches an eye-path vertex from a light-path vertex and
/// is reflected towards the eye.
#[inline]
fn connect<P: PathParts + ?Sized>(
    parts: &P,
    scene: &Scene,
    bsdf: &Bsdf,
    vertex: &Vertex,
    light_vertex: &PathVertex<'_>,
) -> DVec3 {
    let (here, there) = (
        SurfacePoint::new(vertex.point, vertex.frame.z),
        SurfacePoint::new(light_vertex.at.point, light_vertex.normal()),
    );
    let offset = there.point - here.point;
    let distance_squared = offset.length_squared();
    let direction = offset * distance_squared.sqrt().recip();
    let cosine = parts.cosine(here.normal, direction);
    let cosine_there = parts.cosine(there.normal, -direction);
    if cosine <= 0.0 || cosine_there <= 0.0 {
        return DVec3::ZERO;
    }
    let outgoing = light_vertex.outgoing_radiance(parts, -direction);
    let brdf = parts.brdf(bsdf, vertex.wo, vertex.frame.local(direction));
    let value =
        outgoing * brdf * cosine * parts.solid_angle_per_area(cosine_there, distance_squared);
    if value == DVec3::ZERO || !parts.visible(scene, here, there, false) {
        return DVec3::ZERO;
    }
    value
}
