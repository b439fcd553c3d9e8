//! Photons: where particles from the emitters arrive, and the radiance that follows from their
//! density.

use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Error;
use crate::integrator::Walking;
use crate::integrator::emission::{Emission, emit};
use crate::integrator::walk::{PendingWalk, WalkEvent, follow, in_portions};
use crate::material::{Bsdf, Scattering, Vertex};
use crate::math::kd_tree::KdTree;
use crate::sampling::sampler::{LIGHT, Pass, Sampler, Source};
use crate::scene::Scene;

/// A particle's arrival at a diffuse surface.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Unit normal of the surface on the side where it arrived.
    pub normal: DVec3,
    /// Unit direction to where it came from.
    pub from: DVec3,
    /// ΔΦ of [`crate::equation::PHOTON_FLUX`].
    pub flux: DVec3,
}

/// Which arrivals a map keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// All at diffuse surfaces: light that came straight, by mirrors and glass, or by diffuse
    /// surfaces.
    All,
    /// The first at a diffuse surface if only mirrors and glass were met before: caustics.
    Caustic,
}

/// ΔΦ of [`crate::equation::PHOTON_FLUX`]: the share of one particle of `emitted` ≥ 1. Particles
/// that were lost on the way count as well.
#[inline]
pub fn flux_share(flux: DVec3, emitted: u32) -> DVec3 {
    flux / f64::from(emitted)
}

/// What one photon adds to [`crate::equation::PHOTON_DENSITY`]: f_r ΔΦ / πr², with f_r in 1/sr and
/// `r2` = r² > 0. The constant kernel on the disc of radius r.
#[inline]
pub fn density(brdf: DVec3, flux: DVec3, r2: f64) -> DVec3 {
    brdf * flux * (FRAC_1_PI / r2)
}

/// Photons are counted where their normal and that of the point in question have at least this
/// cosine (26°): not from behind nor round a corner. On a sphere of radius R that allows lookups up
/// to r = 0.45 R.
pub const SAME_SIDE: f64 = 0.9;

/// Whether a photon lies on the same surface and side as a point, by their unit normals.
#[inline]
pub fn same_side(at_photon: DVec3, at_point: DVec3) -> bool {
    at_photon.dot(at_point) > SAME_SIDE
}

/// The replaceable parts of photon mapping.
pub trait Photons: Sync {
    /// ΔΦ of one particle of `emitted`, whatever the number of photons that they left.
    #[inline]
    fn photon_flux(&self, flux: DVec3, emitted: u32, _stored: usize) -> DVec3 {
        flux_share(flux, emitted)
    }
    /// Whether light that met so many mirrors and glass surfaces, and nothing else, before it
    /// arrives at a diffuse surface is a caustic. Light that met none is found by shadow rays.
    #[inline]
    fn is_caustic(&self, specular: u32) -> bool {
        specular > 0
    }
    /// Whether a photon lies on the same surface and side as a point, by their normals.
    #[inline]
    fn same_side(&self, at_photon: DVec3, at_point: DVec3) -> bool {
        same_side(at_photon, at_point)
    }
    /// What one photon adds to the reflected radiance. Its direction `_wi`, local, has no say but
    /// by the BRDF: flux per area is irradiance, which holds the cosine.
    #[inline]
    fn photon_density(&self, brdf: DVec3, flux: DVec3, _wi: DVec3, radius_squared: f64) -> DVec3 {
        density(brdf, flux, radius_squared)
    }
    /// Whether an eye path that has met a diffuse surface counts emitters that it hits: not where
    /// shadow rays and caustic photons bring the same light.
    #[inline]
    fn gathers_emission(&self) -> bool {
        false
    }
    /// r² of a pass of stochastic progressive photon mapping.
    #[inline]
    fn pass_radius_squared(&self, first: f64, index: u32) -> f64 {
        radius_squared(first, index)
    }
}

/// The most memory that a map may take while it is made, bytes: a list of photons and the tree.
pub const LARGEST_MAP: usize = 4 << 30;

/// Particles that tell how many photons the others will leave.
const PILOT: u32 = 1024;

/// The photons that a number of particles left.
#[derive(Clone, Debug)]
pub struct PhotonMap {
    tree: KdTree<Photon>,
}

impl PhotonMap {
    /// Follows `emitted` ≥ 1 particles, of which each draws from [`Pass::particle`], and keeps
    /// their photons in an order that does not depend on the threads.
    ///
    /// # Errors
    /// Those of [`check`](Self::check); [`Error::Radiance`] for a photon whose flux is negative or
    /// not finite, and for a particle beyond [`LONGEST_PATH`](crate::integrator::LONGEST_PATH).
    pub fn new<P: Photons + Walking>(
        parts: &P,
        scene: &Scene,
        kept: Kept,
        emitted: u32,
        pass: impl Into<Pass>,
    ) -> Result<Self, Error> {
        let pass = pass.into();
        let rng = |particle| pass.particle(particle, emitted);
        let follow = |particles| follow_particles(parts, scene, kept, particles, rng);
        let mut photons = pilot(emitted, follow)?;
        let first = emitted.min(PILOT);
        let rest =
            in_portions(emitted - first).map(|part| follow(first + part.start..first + part.end));
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
        Ok(Self {
            tree: KdTree::new(&photons),
        })
    }

    /// Refuses a map that would not fit memory.
    ///
    /// # Errors
    /// [`Error::Option`] for no particles, and if the first ones say that all will leave more
    /// photons than fit [`LARGEST_MAP`].
    pub fn check<P: Photons + Walking>(
        parts: &P,
        scene: &Scene,
        kept: Kept,
        emitted: u32,
        pass: impl Into<Pass>,
    ) -> Result<(), Error> {
        let pass = pass.into();
        let rng = |particle| pass.particle(particle, emitted);
        pilot(emitted, |particles| {
            follow_particles(parts, scene, kept, particles, rng)
        })
        .map(|_| ())
    }

    /// The photons, in the tree's order.
    pub fn photons(&self) -> impl Iterator<Item = &Photon> {
        self.tree.values()
    }

    /// [`KdTree::place`] of a point among the photons.
    pub(super) fn place(&self, point: DVec3) -> usize {
        self.tree.place(point)
    }

    /// The radiance that a diffuse vertex reflects, by [`crate::equation::PHOTON_DENSITY`] with the
    /// photons of a ball of the given radius.
    ///
    /// On a plane the expectation is the mean over the disc, and on a sphere the mean over the cap
    /// that the ball cuts out, whose area is πr², too (Archimedes). Within r of an edge it is too
    /// small by the part of the disc that lies beyond.
    #[inline]
    pub(super) fn reflected<P: Photons + Scattering>(
        &self,
        parts: &P,
        bsdf: &Bsdf,
        vertex: &Vertex,
        radius: f64,
    ) -> DVec3 {
        let r2 = radius * radius;
        let mut sum = DVec3::ZERO;
        self.tree.within(vertex.point, r2, |photon| {
            if parts.same_side(photon.normal, vertex.frame.z) {
                // It arrived above its own surface, so it must not drown in the horizon of the
                // vertex.
                let wi = vertex.frame.local(photon.from);
                let wi = wi.with_z(wi.z.max(f64::MIN_POSITIVE));
                let brdf = parts.brdf(bsdf, vertex.wo, wi);
                sum += parts.photon_density(brdf, photon.flux, wi, r2);
            }
        });
        sum
    }
}

/// Refuses a radius in which no photon lies.
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

/// The photons of the first particles, unless they say that those of all would not fit.
fn pilot(
    emitted: u32,
    follow: impl Fn(Range<u32>) -> Result<Vec<(DVec3, Photon)>, Error>,
) -> Result<Vec<(DVec3, Photon)>, Error> {
    if emitted == 0 {
        let message = "0 particles leave no photons: send at least 1".to_owned();
        return Err(Error::Option(message));
    }
    let first = emitted.min(PILOT);
    let photons = follow(0..first)?;
    let each = size_of::<(DVec3, Photon)>() + KdTree::<Photon>::BYTES;
    let per_particle = (photons.len() * each) as f64 / f64::from(first);
    let bytes = per_particle * f64::from(emitted);
    if bytes > LARGEST_MAP as f64 {
        return Err(Error::Option(format!(
            "{emitted} particles would leave about {:.0} GB of photons, more than the {} GB that a map may \
             take: send fewer",
            bytes / f64::from(1 << 30),
            LARGEST_MAP >> 30
        )));
    }
    Ok(photons)
}

/// Follows these particles to their ends; the flux of their photons is not yet shared among all
/// particles.
fn follow_particles<P: Photons + Walking>(
    parts: &P,
    scene: &Scene,
    kept: Kept,
    particles: Range<u32>,
    rng: impl Fn(u32) -> Source,
) -> Result<Vec<(DVec3, Photon)>, Error> {
    let mut photons = vec![Vec::new(); particles.len()];
    let first = particles.start;
    let starts = particles.map(|number| {
        let mut rng = rng(number);
        rng.block(LIGHT);
        let emission = emit(parts, scene, &mut rng);
        let (ray, flux) = emission.map_or((None, DVec3::ZERO), |Emission { ray, flux }| {
            (Some(ray), flux)
        });
        PendingWalk {
            item: (number, flux, 0),
            ray,
            block: LIGHT,
            rng,
        }
    });
    follow(parts, scene, starts, |event| {
        let WalkEvent::Hit((number, flux, specular), step, at, _) = event else {
            return Ok(false);
        };
        let rough = step.bsdf.is_rough();
        // An endless particle is not cut: the map refuses it.
        if step.endless || rough && (kept == Kept::All || parts.is_caustic(*specular)) {
            let photon = Photon {
                normal: at.frame.z,
                from: -step.ray.direction,
                flux: *flux * step.throughput,
            };
            photons[(*number - first) as usize].push((step.here.point, photon));
        }
        *specular += u32::from(!rough);
        Ok(!(rough && kept == Kept::Caustic))
    })?;
    Ok(photons.concat())
}

/// α of [`crate::equation::PHOTON_RADIUS`].
pub const ALPHA: f64 = 2.0 / 3.0;

/// r² of pass `index` = i − 1 by [`crate::equation::PHOTON_RADIUS`], where `first` is that of
/// pass 0.
pub fn radius_squared(first: f64, index: u32) -> f64 {
    (1..=index).fold(first, |r2, i| {
        r2 * (f64::from(i) + ALPHA) / (f64::from(i) + 1.0)
    })
}
