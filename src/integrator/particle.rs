//! Particles: tracing from the emitters, and connecting their vertices to the eye.

use glam::DVec3;

use super::PathParts;
use super::emission::emit_from;
use super::light_sampling::{pick_point, point_pdf};
use super::strategies::{Bidirectional, PathVertex};
use super::walk::{PendingWalk, WalkEvent, trace_walks};
use crate::error::Error;
use crate::geometry::shape::SurfacePoint;
use crate::light::emitter::EmitterPoint;
use crate::sampling::sampler::{FIRST_LIGHT_BLOCK, Sampler};
use crate::scene::Scene;

/// An event in the life of a particle.
pub(super) enum ParticleEvent<'m, 'a, T, R> {
    /// The particle is at this vertex; the first is on the emitter. It carries flux, which
    /// refraction does not change.
    Vertex(&'m mut T, &'m PathVertex<'a>),
    /// The particle has ended.
    End(T, R),
}

/// The point on an emitter where a particle starts, from which its first vertex is made.
struct Start {
    point: EmitterPoint,
    throughput: DVec3,
    emitter: usize,
}

impl Start {
    fn vertex<'a>(&self) -> PathVertex<'a> {
        PathVertex::emitting(&self.point, self.throughput, self.emitter)
    }
}

/// Traces a particle from the emitters for each item, and reports all of its vertices to
/// `on_event`. `named` adds the item to an error.
pub(super) fn particles<'a, P: PathParts + Bidirectional + ?Sized, T, R: Sampler>(
    parts: &P,
    scene: &'a Scene,
    items: &mut dyn Iterator<Item = (T, R)>,
    named: impl Fn(Error, &T) -> Error,
    mut on_event: impl FnMut(ParticleEvent<'_, 'a, T, R>) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut starts = items.map(|(item, mut rng)| {
        rng.block(FIRST_LIGHT_BLOCK);
        let start = pick_point(parts, scene, &mut rng).map(|(emitter, point)| {
            let throughput = scene.emitters()[emitter].radiance / point_pdf(parts, scene, emitter);
            let emission = emit_from(parts, scene, emitter, &point, &mut rng);
            let start = Start {
                point,
                throughput,
                emitter,
            };
            (start, emission)
        });
        let (start, emission) = start.unzip();
        let (ray, flux) = emission.flatten().unzip();
        let item = (item, start, flux.unwrap_or_default());
        PendingWalk::new(item, ray, FIRST_LIGHT_BLOCK, rng)
    });
    trace_walks(parts, scene, &mut starts, |event| match event {
        WalkEvent::Hit((item, start, flux), step, at, _) => {
            let flux = *flux * step.throughput * parts.flux_factor(step.factor);
            let mut arrive = || {
                if let Some(start) = start.take() {
                    on_event(ParticleEvent::Vertex(item, &start.vertex()))?;
                }
                if step.endless {
                    return Err(Error::Radiance {
                        value: f64::NAN,
                        place: String::new(),
                    });
                }
                on_event(ParticleEvent::Vertex(item, &step.path_vertex(*at, flux)))
            };
            arrive().map_err(|error| named(error, item))?;
            Ok(true)
        }
        WalkEvent::End((mut item, start, _), _, rng) => {
            if let Some(start) = start {
                on_event(ParticleEvent::Vertex(&mut item, &start.vertex()))
                    .map_err(|error| named(error, &item))?;
            }
            on_event(ParticleEvent::End(item, rng))?;
            Ok(false)
        }
    })
}

/// Contribution of a particle's vertex to a pixel, with as many particles as pixels.
pub(super) struct Splat {
    /// Column and row.
    pub pixel: [u32; 2],
    /// Radiance added to the pixel, before MIS weights.
    pub value: DVec3,
    /// Pdf of the camera ray that would have found the vertex, as in
    /// [`FullPath`](crate::integrator::strategies::FullPath).
    pub camera_pdf: f64,
}

/// Connects a vertex to the eye; `None` if it contributes nothing.
#[inline]
pub(super) fn connect_to_eye<P: PathParts + Bidirectional + ?Sized>(
    parts: &P,
    scene: &Scene,
    resolution: [u32; 2],
    vertex: &PathVertex<'_>,
) -> Option<Splat> {
    let (point, normal) = (vertex.at.point, vertex.normal());
    let camera = scene.camera();
    let seen = camera.project(resolution, point)?;
    let cosine = parts.cosine(normal, seen.to_eye);
    let outgoing = vertex.outgoing_radiance(parts, seen.to_eye);
    let eye = SurfacePoint::new(camera.eye, -seen.to_eye);
    let here = SurfacePoint::new(point, normal);
    if cosine <= 0.0 || outgoing == DVec3::ZERO || !parts.visible(scene, eye, here, false) {
        return None;
    }
    let camera_pdf = camera_pdf_per_particle(parts, scene, resolution, -seen.to_eye);
    Some(Splat {
        pixel: seen.pixel,
        value: outgoing * parts.solid_angle_per_area(cosine, seen.distance_squared) * camera_pdf,
        camera_pdf,
    })
}

/// Returns W(ω) of a pixel divided by the number of particles, which is that of pixels.
#[inline]
pub(super) fn camera_pdf_per_particle<P: Bidirectional + ?Sized>(
    parts: &P,
    scene: &Scene,
    resolution: [u32; 2],
    direction: DVec3,
) -> f64 {
    let particles = f64::from(resolution[0]) * f64::from(resolution[1]);
    parts.importance(scene.camera(), resolution, direction) / particles
}
