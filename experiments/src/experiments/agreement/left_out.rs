//! Measures the light that a method leaves out, path by path: a random walk from the eye finds
//! light by hits alone and tests for each path whether the method samples it. It scatters as the
//! estimators do, without next-event estimation, MIS weights or length limit.

use whitefurnace::geometry::shape::Hit;
use whitefurnace::material::Vertex;
use whitefurnace::sampling::sampler::Sampler;

use super::SIZE;
use crate::experiments::prelude::*;

/// Methods that sample only a part of the paths, in the order of the walk's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    Whitted,
    Report,
    LightTracer,
}

impl Method {
    /// Returns the name in file names.
    pub fn word(self) -> &'static str {
        match self {
            Self::Whitted => "whitted",
            Self::Report => "report",
            Self::LightTracer => "light-tracer",
        }
    }
}

pub(super) const METHODS: [Method; 3] = [Method::Whitted, Method::Report, Method::LightTracer];

/// Largest number of segments from the eye in Whitted's method and the report's.
const MAX_SEGMENTS: u32 = 7;

/// A path from the eye to a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PathKind {
    /// Number of segments, including the one to the light.
    pub segments: u32,
    pub diffuse: u32,
    pub diffuse_first: bool,
    pub diffuse_last: bool,
    /// True if the light is an emitter, false if it is the background.
    pub emitter: bool,
}

impl PathKind {
    pub fn is_sampled_by(&self, method: Method) -> bool {
        // A shadow ray is one segment beyond the limit, and finds emitters only.
        let by_shadow_ray = self.diffuse_last && self.emitter;
        let within = self.segments <= MAX_SEGMENTS + u32::from(by_shadow_ray);
        match method {
            Method::Report => within,
            Method::Whitted => within && (self.diffuse == 0 || self.diffuse == 1 && by_shadow_ray),
            Method::LightTracer => self.segments == 1 || self.diffuse_first,
        }
    }
}

/// The walk: the grey radiance that each of [`METHODS`] leaves out, one per channel.
struct LeftOut;

impl Estimator for LeftOut {
    fn radiance(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut dyn Sampler) -> DVec3 {
        let (mut ray, mut hit) = (*ray, hit);
        let mut left_out = DVec3::ZERO;
        let mut throughput = DVec3::ONE;
        let mut path = PathKind {
            segments: 1,
            diffuse: 0,
            diffuse_first: false,
            diffuse_last: false,
            emitter: false,
        };
        loop {
            let met = hit.map_or(scene.background().radiance(ray.direction), |here| {
                scene.emitted(&here, ray.direction)
            });
            path.emitter = hit.is_some();
            let grey = (throughput * met).element_sum() / 3.0;
            let missed = METHODS.map(|method| f64::from(u8::from(!path.is_sampled_by(method))));
            left_out += grey * DVec3::from_array(missed);
            let Some(here) = hit else {
                return left_out;
            };
            let bsdf = &scene.surface(&here).bsdf;
            let Some(next) = bsdf.sample(&Vertex::new(&here, &ray), rng) else {
                return left_out;
            };
            path.diffuse_last = bsdf.is_non_delta();
            path.diffuse_first |= path.diffuse_last && path.segments == 1;
            path.diffuse += u32::from(path.diffuse_last);
            path.segments += 1;
            throughput *= next.radiance_factor * next.weight;
            // Most of the light beyond the limit comes soon after it, so Russian roulette starts
            // later.
            if path.segments > MAX_SEGMENTS + 2 {
                let survival = throughput.max_element().clamp(0.05, 0.95);
                if uniform(rng) >= survival {
                    return left_out;
                }
                throughput /= survival;
            }
            (ray, hit) = scene.spawn_and_trace(&here, next.direction);
        }
    }
}

/// Returns the image means of the radiance that each of [`METHODS`] leaves out of a scene, for
/// `count` images from `first` on.
pub(super) fn left_out(
    run: &Run,
    scene: SceneName,
    first: u32,
    count: u32,
) -> Result<[Values; 3], Error> {
    let job = Job {
        scene: scene.into(),
        size: SIZE,
        spp: first + count,
        seed: seed_for(run.seed(), &format!("{} left out", name(scene))),
        ..Job::default()
    };
    let mut values = [Values::new(0.0); 3];
    job.replications_by(LeftOut, first..first + count, |image| {
        let mean = image.iter().sum::<DVec3>() / image.len() as f64;
        for (values, mean) in values.iter_mut().zip(mean.to_array()) {
            values.push(mean);
        }
    })?;
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Builds a path from its surfaces: d for diffuse, s for mirror or glass; the light is an
    /// emitter.
    fn path(surfaces: &str) -> PathKind {
        PathKind {
            segments: surfaces.len() as u32 + 1,
            diffuse: surfaces.matches('d').count() as u32,
            diffuse_first: surfaces.starts_with('d'),
            diffuse_last: surfaces.ends_with('d'),
            emitter: true,
        }
    }

    #[test]
    fn paths_are_told_apart() {
        use Method::{LightTracer, Report, Whitted};
        // Surfaces in order from the eye, and the methods that sample the path to an emitter.
        for (surfaces, methods) in [
            ("", &[Whitted, Report, LightTracer][..]),
            ("s", &[Whitted, Report]),
            ("d", &[Whitted, Report, LightTracer]),
            ("sd", &[Whitted, Report]),
            ("ds", &[Report, LightTracer]),
            ("dd", &[Report, LightTracer]),
            ("dsd", &[Report, LightTracer]),
            ("sds", &[Report]),
            ("ssssss", &[Whitted, Report]),
            ("sssssss", &[]),
            ("ssssssd", &[Whitted, Report]),
            ("sssssssd", &[]),
            ("ddddddd", &[Report, LightTracer]),
            ("dddddddd", &[LightTracer]),
            ("dddddds", &[LightTracer]),
        ] {
            let is_sampled_by = METHODS.map(|method| path(surfaces).is_sampled_by(method));
            assert_eq!(
                is_sampled_by,
                METHODS.map(|m| methods.contains(&m)),
                "{surfaces}"
            );
        }
        // No shadow ray finds the background.
        let sky = PathKind {
            emitter: false,
            ..path("d")
        };
        assert_eq!(METHODS.map(|m| sky.is_sampled_by(m)), [false, true, true]);
        let far = PathKind {
            emitter: false,
            ..path("ddddddd")
        };
        assert!(!far.is_sampled_by(Report));
    }
}
