//! Photon maps: storage of photons, and radiance from their density.

use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Error;
use crate::integrator::emission::emit;
use crate::integrator::walk::{PendingWalk, WalkEvent, in_batches, trace_walks};
use crate::integrator::{Parts, PathParts, with_parts};
use crate::material::{Bsdf, Scattering, Vertex};
use crate::math::kd_tree::KdTree;
use crate::math::real::{Mask as _, MaskOf, Real, Vector};
use crate::math::simd::{LANES, Lanes3, lanes_of};
use crate::sampling::sampler::{FIRST_LIGHT_BLOCK, ImagePass, SampleStream, Sampler};
use crate::scene::Scene;

/// A particle's arrival at a diffuse surface, or several.
#[derive(Clone, Copy, Debug)]
pub struct Photon<V = DVec3> {
    /// Unit normal of the surface on the side of arrival.
    pub normal: V,
    /// Unit direction towards the particle's previous vertex.
    pub from: V,
    /// ΔΦ of [`crate::equation::PHOTON_FLUX`].
    pub flux: V,
}

impl Photon<Lanes3> {
    fn lane(&self, lane: usize) -> Photon {
        Photon {
            normal: self.normal.lane(lane),
            from: self.from.lane(lane),
            flux: self.flux.lane(lane),
        }
    }
}

/// Which photons a map stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotonMapKind {
    /// All photons at diffuse surfaces: after no other surface, after mirrors and glass, or after
    /// diffuse surfaces.
    All,
    /// Caustics: the first photon at a diffuse surface, after at least one mirror or glass alone.
    Caustic,
}

/// Returns ΔΦ of [`crate::equation::PHOTON_FLUX`]: the flux of one particle of `emitted` ≥ 1.
/// Particles that were lost on the way count as well.
#[inline]
pub fn flux_share(flux: DVec3, emitted: u32) -> DVec3 {
    flux / f64::from(emitted)
}

/// Returns the contribution of one photon to [`crate::equation::PHOTON_DENSITY`]: f_r ΔΦ / πr²,
/// with f_r in 1/sr and `r2` = r² > 0. Constant kernel on the disc of radius r.
#[inline]
pub fn density<V: Vector>(brdf: V, flux: V, r2: V::Real) -> V {
    brdf * flux * (V::Real::splat(FRAC_1_PI) / r2)
}

/// Least cosine (26°) between the normals of a photon and a point that may use it: excludes photons
/// from behind and round a corner. On a sphere of radius R lookups work up to r = 0.45 R.
pub const MIN_SAME_SIDE_COSINE: f64 = 0.9;

/// Returns whether a photon lies on the same surface and side as a point, by their unit normals.
#[inline]
pub fn same_side<V: Vector>(at_photon: V, at_point: V) -> MaskOf<V> {
    at_photon
        .dot(at_point)
        .cmpgt(Real::splat(MIN_SAME_SIDE_COSINE))
}

/// Replaceable parts of photon mapping.
pub trait Photons: Sync {
    /// Returns ΔΦ of one particle of `emitted`, regardless of the number of stored photons.
    #[inline]
    fn photon_flux(&self, flux: DVec3, emitted: u32, _stored: usize) -> DVec3 {
        flux_share(flux, emitted)
    }
    /// Returns whether light is a caustic that arrives at a diffuse surface after this number of
    /// specular surfaces and nothing else. For 0 it is direct light, found by shadow rays.
    #[inline]
    fn is_caustic(&self, specular: u32) -> bool {
        specular > 0
    }
    /// Returns whether a photon lies on the same surface and side as a point, by their normals.
    #[inline]
    fn same_side(&self, at_photon: DVec3, at_point: DVec3) -> bool {
        same_side(at_photon, at_point)
    }
    /// Returns the contribution of one photon to reflected radiance. The photon's local direction
    /// `_wi` enters only through the BRDF: flux per area is irradiance, which includes the cosine.
    #[inline]
    fn photon_density(&self, brdf: DVec3, flux: DVec3, _wi: DVec3, radius_squared: f64) -> DVec3 {
        density(brdf, flux, radius_squared)
    }
    /// Returns whether an eye path counts emitters that it hits after a diffuse surface: not if
    /// shadow rays and caustic photons account for the same light.
    #[inline]
    fn gathers_emission(&self) -> bool {
        false
    }
    /// Returns r² of a pass of stochastic progressive photon mapping.
    #[inline]
    fn pass_radius_squared(&self, first: f64, index: u32) -> f64 {
        radius_squared(first, index)
    }
}

/// Largest memory of a map during construction, in bytes: the list of photons and the tree.
pub const MAX_MAP_MEMORY: usize = 4 << 30;

/// Number of pilot particles, from which the number of photons is estimated.
const PILOT_PARTICLES: u32 = 1024;

/// Photons of a number of particles, in a k-d tree.
#[derive(Clone, Debug)]
pub struct PhotonMap {
    tree: KdTree,
    /// One for each chunk of the tree.
    photons: Vec<Photon<Lanes3>>,
}

impl PhotonMap {
    /// Traces `emitted` ≥ 1 particles, each of which draws from [`ImagePass::particle_stream`], and
    /// stores their photons in an order that does not depend on the threads.
    ///
    /// # Errors
    /// Those of [`check`](Self::check); [`Error::Radiance`] for a photon whose flux is negative or
    /// not finite, and for a particle beyond
    /// [`MAX_PATH_VERTICES`](crate::integrator::MAX_PATH_VERTICES).
    pub fn new(
        parts: Parts<'_>,
        scene: &Scene,
        kind: PhotonMapKind,
        emitted: u32,
        pass: ImagePass,
    ) -> Result<Self, Error> {
        let rng = |particle| pass.particle_stream(particle, emitted);
        let follow = |particles| {
            with_parts!(parts, |parts| trace_photons(
                parts, scene, kind, particles, &rng
            ))
        };
        let mut photons = pilot(emitted, follow)?;
        let first = emitted.min(PILOT_PARTICLES);
        let rest =
            in_batches(emitted - first).map(|part| follow(first + part.start..first + part.end));
        let rest = rest.collect::<Result<Vec<_>, _>>()?;
        photons.extend(rest.into_iter().flatten());
        let stored = photons.len();
        for (_, photon) in &mut photons {
            photon.flux = parts.photon_flux(photon.flux, emitted, stored);
            let flux = photon.flux.to_array();
            if let Some(&value) = flux
                .iter()
                .find(|flux| !(0.0..f64::INFINITY).contains(*flux))
            {
                let place = format!(" as the flux of a photon of pass {}", pass.index);
                return Err(Error::Radiance { value, place });
            }
        }
        let (tree, order) = KdTree::new(photons.iter().map(|(point, _)| *point));
        let lanes = |order: &[u32]| {
            let vector = |of: fn(&Photon) -> DVec3| {
                let photon = |&index: &u32| of(&photons[index as usize].1);
                Lanes3::from_fn(|lane| order.get(lane).map_or(DVec3::ZERO, photon))
            };
            Photon {
                normal: vector(|photon| photon.normal),
                from: vector(|photon| photon.from),
                flux: vector(|photon| photon.flux),
            }
        };
        let photons = order.chunks(LANES).map(lanes).collect();
        Ok(Self { tree, photons })
    }

    /// Refuses a map that would not fit in memory.
    ///
    /// # Errors
    /// [`Error::Option`] for no particles, and if pilot particles predict more photons than fit in
    /// [`MAX_MAP_MEMORY`].
    pub fn check(
        parts: Parts<'_>,
        scene: &Scene,
        kind: PhotonMapKind,
        emitted: u32,
        pass: ImagePass,
    ) -> Result<(), Error> {
        let rng = |particle| pass.particle_stream(particle, emitted);
        pilot(emitted, |particles| {
            with_parts!(parts, |parts| trace_photons(
                parts, scene, kind, particles, &rng
            ))
        })
        .map(|_| ())
    }

    /// Iterates over the photons in the order of the tree.
    pub fn photons(&self) -> impl Iterator<Item = Photon> {
        (0..self.tree.len()).map(|index| self.photons[index / LANES].lane(index % LANES))
    }

    /// Returns [`KdTree::approximate_index`] of a point among the photons.
    pub(super) fn approximate_index(&self, point: DVec3) -> usize {
        self.tree.approximate_index(point)
    }

    /// Returns the radiance that a diffuse vertex reflects, by [`crate::equation::PHOTON_DENSITY`]
    /// with the photons of a ball of the given radius.
    ///
    /// On a plane the expectation is the mean over the disc, and on a sphere the mean over the cap
    /// that the ball cuts out, whose area is πr², too (Archimedes). Within r of an edge it is too
    /// small by the part of the disc that lies beyond.
    #[inline]
    pub(super) fn reflected<P: Photons + Scattering + ?Sized>(
        &self,
        parts: &P,
        bsdf: &Bsdf,
        vertex: &Vertex,
        radius: f64,
    ) -> DVec3 {
        let r2 = radius * radius;
        // Lambert's model is the same for all directions.
        let constant = match bsdf {
            Bsdf::Lambert { .. } if parts.is_default() => {
                Some(parts.brdf(bsdf, vertex.wo, DVec3::Z))
            }
            _ => None,
        };
        let mut sum = DVec3::ZERO;
        self.tree.within(vertex.point, r2, |chunk, near| {
            let photons = &self.photons[chunk];
            if let Some(brdf) = constant {
                let used =
                    near & same_side(photons.normal, Vector::splat_vector(vertex.frame.z)).bits();
                let radiance = density(Vector::splat_vector(brdf), photons.flux, Real::splat(r2));
                lanes_of(used).for_each(|lane| sum += radiance.lane(lane));
                return;
            }
            for photon in lanes_of(near).map(|lane| photons.lane(lane)) {
                if parts.same_side(photon.normal, vertex.frame.z) {
                    // The photon arrived above its own surface, so its direction must not fall
                    // below the horizon of the vertex.
                    let wi = vertex.frame.local(photon.from);
                    let wi = wi.with_z(wi.z.max(f64::MIN_POSITIVE));
                    let brdf = parts.brdf(bsdf, vertex.wo, wi);
                    sum += parts.photon_density(brdf, photon.flux, wi, r2);
                }
            }
        });
        sum
    }
}

/// Refuses a radius within which no photon can lie.
///
/// # Errors
/// [`Error::Option`] unless it is finite and above 0.
pub(crate) fn check_radius(radius: f64) -> Result<(), Error> {
    if radius.is_finite() && radius > 0.0 {
        return Ok(());
    }
    Err(Error::Option(format!(
        "photons are looked up within a radius above 0, in the scene's units, not {radius}"
    )))
}

/// Returns the photons of pilot particles, unless they predict too many for memory.
fn pilot(
    emitted: u32,
    follow: impl Fn(Range<u32>) -> Result<Vec<(DVec3, Photon)>, Error>,
) -> Result<Vec<(DVec3, Photon)>, Error> {
    if emitted == 0 {
        let message = "0 particles leave no photons: send at least 1".to_owned();
        return Err(Error::Option(message));
    }
    let first = emitted.min(PILOT_PARTICLES);
    let photons = follow(0..first)?;
    let each = size_of::<(DVec3, Photon)>() + size_of::<Photon>() + KdTree::BYTES;
    let per_particle = (photons.len() * each) as f64 / f64::from(first);
    let bytes = per_particle * f64::from(emitted);
    if bytes > MAX_MAP_MEMORY as f64 {
        return Err(Error::Option(format!(
            "{emitted} particles would leave about {:.0} GB of photons, more than the {} GB that a map may \
             take: send fewer",
            bytes / f64::from(1 << 30),
            MAX_MAP_MEMORY >> 30
        )));
    }
    Ok(photons)
}

/// Traces these particles to their ends; the flux of their photons is not yet divided among all
/// particles.
fn trace_photons<P: Photons + PathParts + ?Sized>(
    parts: &P,
    scene: &Scene,
    kind: PhotonMapKind,
    particles: Range<u32>,
    rng: &dyn Fn(u32) -> SampleStream,
) -> Result<Vec<(DVec3, Photon)>, Error> {
    let mut photons = vec![Vec::new(); particles.len()];
    let first = particles.start;
    let mut starts = particles.map(|number| {
        let mut rng = rng(number);
        rng.block(FIRST_LIGHT_BLOCK);
        let (ray, flux) = emit(parts, scene, &mut rng).unzip();
        let item = (number, flux.unwrap_or_default(), 0);
        PendingWalk::new(item, ray, FIRST_LIGHT_BLOCK, rng)
    });
    trace_walks(parts, scene, &mut starts, |event| {
        let WalkEvent::Hit((number, flux, specular), step, at, _) = event else {
            return Ok(false);
        };
        let rough = step.bsdf.is_non_delta();
        // A particle that will not end is not truncated: the map refuses it.
        if step.endless || rough && (kind == PhotonMapKind::All || parts.is_caustic(*specular)) {
            let photon = Photon {
                normal: at.frame.z,
                from: -step.ray.direction,
                flux: *flux * step.throughput,
            };
            photons[(*number - first) as usize].push((step.here.point, photon));
        }
        *specular += u32::from(!rough);
        Ok(!(rough && kind == PhotonMapKind::Caustic))
    })?;
    Ok(photons.concat())
}

/// α of [`crate::equation::PHOTON_RADIUS`].
pub const ALPHA: f64 = 2.0 / 3.0;

/// Returns r² of pass `index` = i − 1 by [`crate::equation::PHOTON_RADIUS`], where `first` is r² of
/// pass 0.
pub fn radius_squared(first: f64, index: u32) -> f64 {
    (1..=index).fold(first, |r2, i| {
        r2 * (f64::from(i) + ALPHA) / (f64::from(i) + 1.0)
    })
}
