//! A random walk from hit to hit, for paths from the eye and from lights alike.

use glam::DVec3;

use super::strategies::Corner;
use super::vertex::{Scattered, Vertex, onward, scatter, survive};
use super::{LONGEST_PATH, Parts};
use crate::bsdf::Bsdf;
use crate::error::Error;
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;

/// A walk at one of its hits, before it scatters.
pub(super) struct Step {
    /// The ray that arrived, and what it hit.
    pub ray: Ray,
    pub here: Hit,
    /// Product of the weights of all scattering on the way, without radiance factors: they cancel when the
    /// walk leaves the glass, and roulette should not see them.
    pub throughput: DVec3,
    /// Product of the radiance factors on the way.
    pub factor: f64,
}

impl Step {
    /// The hit as a scattering surface sees it.
    #[inline]
    pub fn vertex(&self) -> Vertex {
        Vertex::new(&self.here, &self.ray)
    }

    /// The hit as a vertex of a path that does not start here.
    #[inline]
    pub fn corner(&self, scene: &Scene) -> Corner {
        let bsdf = &scene.surface(&self.here).bsdf;
        Corner {
            point: self.here.point,
            normal: self.vertex().frame.z,
            specular: matches!(bsdf, Bsdf::Mirror { .. } | Bsdf::Glass { .. }),
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
pub(super) fn walk<P: Parts, R: Sampler>(
    parts: &P,
    scene: &Scene,
    ray: &Ray,
    block: u32,
    rng: &mut R,
    mut visit: impl FnMut(&Step, &mut R) -> Result<(), Error>,
) -> Result<Option<(DVec3, f64)>, Error> {
    let (mut ray, mut hit) = (*ray, scene.intersect(ray));
    let (mut throughput, mut factor) = (DVec3::ONE, 1.0);
    for vertex in 1..=LONGEST_PATH {
        let Some(here) = hit else {
            return Ok(Some((throughput, factor)));
        };
        rng.block(block + vertex);
        let step = Step { ray, here, throughput, factor };
        visit(&step, rng)?;
        let Some(Scattered { direction, throughput: share, factor: scale, .. }) =
            scatter(parts, scene, &here, &ray, rng)
        else {
            return Ok(None);
        };
        throughput *= share;
        factor *= scale;
        let Some(weight) = survive(parts, throughput, rng) else {
            return Ok(None);
        };
        throughput *= weight;
        (ray, hit) = onward(scene, &here, direction);
    }
    Err(Error::Radiance { value: f64::NAN, place: String::new() })
}
