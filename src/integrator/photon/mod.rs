//! Photon mapping (Jensen 1996): eye paths look up photons left by particles from the emitters.

pub mod photon_map;
pub mod sppm;

use std::cell::RefCell;

use glam::DVec3;

use super::direct_light::{ShadowRays, direct_light};
use super::walk::{PendingWalk, WalkEvent, trace_walks};
use super::{Estimator, Parts, PathParts, Sample, with_parts};
use crate::error::Error;
use crate::geometry::shape::{Hit, Ray};
use crate::material::{Scattering, Vertex};
use crate::sampling::sampler::{ImagePass, Sampler};
use crate::scene::Scene;
use photon_map::{PhotonMap, PhotonMapKind, Photons, check_radius};

/// Where photons are looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lookup {
    /// Direct visualization: all light at the first diffuse surface seen by the eye comes from
    /// photons.
    DirectVisualization,
    /// Final gathering: the first diffuse surface gets direct light by a shadow ray, caustics from
    /// a separate photon map, and all other light along one cosine-weighted ray to a second
    /// surface, where photons are looked up.
    FinalGather {
        /// Particles emitted for the caustic map.
        caustic_particles: u32,
        /// Lookup radius of the caustic map.
        caustic_radius: f64,
    },
}

/// Photon mapping estimator with the bias of [`crate::equation::PHOTON_DENSITY`], for light that
/// leaves an emitter; light of the background is missing.
///
/// Its estimates share the photons: their mean converges to the value of this map, and their
/// standard error does not include the variance of the map. Maps of different seeds are independent
/// replications.
#[derive(Clone, Debug)]
pub struct PhotonMapping<'a> {
    parts: Parts<'a>,
    all: PhotonMap,
    radius: f64,
    /// Caustic photons and their radius, for final gathering.
    caustics: Option<(PhotonMap, f64)>,
}

/// First diffuse surface of a path, reached directly or through mirrors and glass alone.
#[derive(Clone, Copy)]
struct PhotonHit {
    hit: Hit,
    at: Vertex,
    /// Throughput from this surface to the start of the path.
    throughput: DVec3,
    /// Block of random numbers.
    block: u32,
}

/// A pending photon lookup for a sample.
struct GatherPoint {
    sample: u32,
    surface: u32,
    point: DVec3,
    /// Normal of the surface, and direction of the ray that arrived.
    normal: DVec3,
    direction: DVec3,
    throughput: DVec3,
}

impl GatherPoint {
    /// Creates a lookup at an arrival; `weight` multiplies its throughput.
    fn new(sample: usize, arrival: &PhotonHit, weight: DVec3) -> Self {
        Self {
            sample: sample as u32,
            surface: arrival.hit.surface,
            point: arrival.hit.point,
            normal: arrival.hit.normal,
            direction: arrival.at.direction,
            throughput: weight * arrival.throughput,
        }
    }
}

impl<'a> PhotonMapping<'a> {
    /// Emits `particles` ≥ 1 and stores their photons, to be looked up within `radius` > 0, in the
    /// scene's units. The photons are functions of the pass.
    ///
    /// # Errors
    /// Those of [`PhotonMap::new`].
    pub fn new(
        parts: Parts<'a>,
        scene: &Scene,
        lookup: Lookup,
        particles: u32,
        radius: f64,
        pass: ImagePass,
    ) -> Result<Self, Error> {
        check_radius(radius)?;
        if let Lookup::FinalGather { caustic_radius, .. } = lookup {
            check_radius(caustic_radius)?;
        }
        let map = |kind, particles, name| {
            PhotonMap::new(parts, scene, kind, particles, pass.for_part(name))
        };
        let all = map(PhotonMapKind::All, particles, "photons")?;
        let caustics = match lookup {
            Lookup::DirectVisualization => None,
            Lookup::FinalGather {
                caustic_particles,
                caustic_radius,
            } => {
                let map = map(PhotonMapKind::Caustic, caustic_particles, "caustics")?;
                Some((map, caustic_radius))
            }
        };
        Ok(Self {
            all,
            radius,
            caustics,
            parts,
        })
    }

    /// Estimates the radiance along rays with these parts, [`TRACED_TOGETHER`] at a time.
    fn radiances_with<P: Photons + PathParts + ?Sized, R: Sampler>(
        &self,
        parts: &P,
        scene: &Scene,
        rays: &mut dyn Iterator<Item = (Ray, R)>,
    ) -> Vec<DVec3> {
        let radiances = RefCell::new(Vec::new());
        let (mut first_points, mut second_points) = (Vec::new(), Vec::new());
        let mut rays = rays.enumerate().peekable();
        while rays.peek().is_some() {
            let together = rays.by_ref().take(TRACED_TOGETHER);
            let mut together = together.map(|(item, (ray, rng))| {
                radiances.borrow_mut().push(DVec3::ZERO);
                PendingWalk::new(item, Some(ray), 0, rng)
            });
            let arrivals = trace_to_diffuse(parts, scene, &mut together, &mut |i, emission| {
                radiances.borrow_mut()[i] += emission;
            });
            first_points.extend(
                arrivals
                    .iter()
                    .map(|(i, arrival, _)| GatherPoint::new(*i, arrival, DVec3::ONE)),
            );
            if self.caustics.is_some() {
                let radiances = &mut radiances.borrow_mut()[..];
                second_points.extend(second_gather_points(parts, scene, arrivals, radiances));
            }
        }
        let mut radiances = radiances.into_inner();
        let (map, radius) = match &self.caustics {
            Some((caustics, radius)) => {
                let (all, r) = (&self.all, self.radius);
                gather(parts, scene, all, r, second_points, &mut radiances);
                (caustics, *radius)
            }
            None => (&self.all, self.radius),
        };
        gather(parts, scene, map, radius, first_points, &mut radiances);
        radiances
    }
}

/// Follows rays through mirrors and glass to the first diffuse surfaces. `on_emission` receives
/// the emission seen on the way, and the item of the path.
fn trace_to_diffuse<P: PathParts + ?Sized, T: Copy, R: Sampler>(
    parts: &P,
    scene: &Scene,
    rays: &mut dyn Iterator<Item = PendingWalk<T, R>>,
    on_emission: &mut dyn FnMut(T, DVec3),
) -> Vec<(T, PhotonHit, R)> {
    // Walks are moved several times, so that they hold only the index of their arrival.
    let (count, _) = rays.size_hint();
    let (mut hits, mut arrivals) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut walks = rays.map(|walk| {
        let item = (walk.item, walk.block, None);
        PendingWalk::new(item, walk.ray, walk.block, walk.rng)
    });
    let followed = trace_walks(parts, scene, &mut walks, |event| {
        match event {
            WalkEvent::Hit((number, block, arrival), hit, at, _) => {
                *block += 1;
                if hit.here.emitter.is_some() {
                    on_emission(*number, hit.factor * hit.throughput * hit.emitted(scene));
                }
                if hit.endless || hit.bsdf.is_non_delta() {
                    let throughput = hit.factor * hit.throughput;
                    *arrival = Some(hits.len());
                    hits.push(PhotonHit {
                        hit: hit.here,
                        at: *at,
                        throughput,
                        block: *block,
                    });
                    return Ok(false);
                }
            }
            WalkEvent::End((number, _, arrival), _, rng) => {
                arrivals.extend(arrival.map(|index| (number, hits[index], rng)));
            }
        }
        Ok(true)
    });
    debug_assert!(followed.is_ok(), "no event is an error");
    arrivals
}

/// Adds the radiance reflected at the gather points, from the photons of a map. Sorts them by
/// position for cache locality: neighbours share photons.
fn gather<P: Photons + Scattering + ?Sized>(
    parts: &P,
    scene: &Scene,
    map: &PhotonMap,
    radius: f64,
    mut gather_points: Vec<GatherPoint>,
    radiances: &mut [DVec3],
) {
    gather_points.sort_by_cached_key(|at| map.approximate_index(at.point));
    for at in gather_points {
        let bsdf = &scene.surfaces()[at.surface as usize].bsdf;
        let vertex = Vertex::of(at.point, at.normal, at.direction);
        let reflected = map.reflected(parts, bsdf, &vertex, radius);
        radiances[at.sample as usize] += at.throughput * reflected;
    }
}

/// Adds the light that arrives at the first diffuse surfaces directly from emitters, and follows
/// a ray from each to a second one; returns the gather points there.
fn second_gather_points<P: Photons + PathParts + ?Sized, R: Sampler>(
    parts: &P,
    scene: &Scene,
    arrivals: Vec<(usize, PhotonHit, R)>,
    radiances: &mut [DVec3],
) -> Vec<GatherPoint> {
    let mut gathering = Vec::with_capacity(arrivals.len());
    for (item, arrival, mut rng) in arrivals {
        let (hit, at, throughput) = (arrival.hit, &arrival.at, arrival.throughput);
        let bsdf = &scene.surface(&hit).bsdf;
        if let Some(light) = direct_light(parts, scene, bsdf, at, ShadowRays::DEFAULT, &mut rng) {
            radiances[item] += throughput * light.reflected;
        }
        if let Some(next) = parts.sample(bsdf, at, &mut rng) {
            let ray = scene.spawn_ray(hit.point, hit.normal, next.direction);
            let item = (item, throughput * next.weight);
            gathering.push(PendingWalk::new(item, Some(ray), arrival.block, rng));
        }
    }
    let second = trace_to_diffuse(
        parts,
        scene,
        &mut gathering.into_iter(),
        &mut |(i, weight), emission| {
            if parts.gathers_emission() {
                radiances[i] += weight * emission;
            }
        },
    );
    second
        .iter()
        .map(|((i, weight), arrival, _)| GatherPoint::new(*i, arrival, *weight))
        .collect()
}

/// Number of camera rays whose paths are traced together: they and their random numbers fit the
/// cache.
const TRACED_TOGETHER: usize = 512;

impl Estimator for PhotonMapping<'_> {
    fn batch_size(&self) -> u32 {
        1 << 16
    }

    fn radiance(&self, scene: &Scene, ray: &Ray, _: Option<Hit>, rng: &mut dyn Sampler) -> DVec3 {
        let rays = &mut std::iter::once((*ray, rng));
        with_parts!(self.parts, |parts| self.radiances_with(parts, scene, rays)
            [0])
    }

    fn radiances(&self, scene: &Scene, samples: &mut dyn Iterator<Item = Sample>) -> Vec<DVec3> {
        let rays = &mut samples.map(|Sample { ray, rng, .. }| (ray, rng));
        with_parts!(self.parts, |parts| self.radiances_with(parts, scene, rays))
    }
}
