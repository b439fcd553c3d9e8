//! A random walk from hit to hit, for paths from the eye and from lights alike.

use glam::DVec3;

use super::steps::onward;
use super::strategies::Corner;
use super::{LONGEST_PATH, Walking};
use crate::bsdf::{Bsdf, Vertex};
use crate::error::Error;
use crate::rng::uniform;
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// A walk at one of its hits, before it scatters.
pub(super) struct Step<'a> {
    /// The ray that arrived, and what it hit.
    pub ray: Ray,
    pub here: Hit,
    /// The hit as light that scatters there sees it.
    pub at: Vertex,
    pub bsdf: &'a Bsdf,
    /// Product of the weights of all scattering on the way, without radiance factors: they cancel when the
    /// walk leaves the glass, and roulette should not see them.
    pub throughput: DVec3,
    /// Product of the radiance factors on the way.
    pub factor: f64,
}

impl<'a> Step<'a> {
    /// The hit as a vertex of a path that does not start here.
    #[inline]
    pub fn corner(&self) -> Corner<'a> {
        Corner {
            point: self.here.point,
            normal: self.at.frame.z,
            bsdf: Some(self.bsdf),
            squared_index: 1.0 / self.factor,
            start: 0.0,
        }
    }
}

/// Follows a ray until it is absorbed, loses at roulette or leaves the scene; `visit` is shown every hit.
/// Returns throughput and radiance factor of a walk that left. The k-th hit draws from block `block` + k.
///
/// # Errors
/// What `visit` returns; [`Error::Radiance`] for a walk beyond [`LONGEST_PATH`].
#[inline]
pub(super) fn walk<'a, P: Walking, R: Sampler>(
    parts: &P,
    scene: &'a Scene,
    ray: &Ray,
    block: u32,
    rng: &mut R,
    mut visit: impl FnMut(&Step<'a>, &mut R) -> Result<(), Error>,
) -> Result<Option<(DVec3, f64)>, Error> {
    let (mut ray, mut hit) = (*ray, scene.intersect(ray));
    let (mut throughput, mut factor) = (DVec3::ONE, 1.0);
    for vertex in 1..=LONGEST_PATH {
        let Some(here) = hit else {
            return Ok(Some((throughput, factor)));
        };
        rng.block(block + vertex);
        let bsdf = &scene.surface(&here).bsdf;
        let at = Vertex::new(&here, &ray);
        visit(&Step { ray, here, at, bsdf, throughput, factor }, rng)?;
        let Some(next) = parts.sample(bsdf, &at, rng) else {
            return Ok(None);
        };
        throughput *= next.weight;
        factor *= next.radiance_factor;
        let Some(weight) = parts.survive(throughput, uniform(rng)) else {
            return Ok(None);
        };
        throughput *= weight;
        (ray, hit) = onward(scene, &here, next.direction);
    }
    Err(Error::Radiance { value: f64::NAN, place: String::new() })
}
