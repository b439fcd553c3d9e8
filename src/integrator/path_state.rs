//! State of the paths in all lanes, and the interface of estimators that advance them.
//!
//! Functions that every hit calls are always inlined: a call would hand their wide numbers over
//! through memory.

use std::array::from_fn;

use glam::DVec3;

use super::direct_light::sample_light;
use super::interaction::SurfaceInteraction;
use super::{PathParts, SpecularChains, TransportRules};
use crate::geometry::shape::Ray;
use crate::math::real::{Mask, Vector};
use crate::math::simd::{Scalar as _, Wide, lanes_of};
use crate::sampling::lanes::LaneSampler;
use crate::scene::Scene;
use crate::scene::lanes::{IntersectionScratch, LaneScene};

/// Paths in the active lanes that have reached surfaces.
pub(crate) struct Arrival<'a, S, R: Wide<N>, const N: usize> {
    pub scene: LaneScene<'a, R, N>,
    pub paths: &'a mut PathState<R, N>,
    pub surface: &'a SurfaceInteraction<'a, R, N>,
    pub active: R::Mask,
    pub random: &'a mut S,
    pub scratch: &'a mut IntersectionScratch<R, N>,
}

impl<S: LaneSampler<R>, R: Wide<N>, const N: usize> Arrival<'_, S, R, N> {
    /// Adds f_r L_e cos θ / p of (8) at surfaces with a density, by next-event estimation, and
    /// returns their lanes.
    #[inline]
    pub fn add_direct_light<P: PathParts + ?Sized>(
        &mut self,
        parts: &P,
        rules: &TransportRules,
    ) -> R::Mask {
        let diffuse = self.active & self.surface.non_delta;
        let (rays, random) = (rules.shadow_rays(), &mut *self.random);
        let (scene, scratch) = (self.scene, &mut *self.scratch);
        let light = sample_light(parts, scene, self.surface, rays, diffuse, random, scratch);
        self.paths.add(light.reflected, light.arrives);
        diffuse
    }
}

/// An estimator that advances the paths of all lanes from hit to hit.
pub(crate) trait Integrator: Sync {
    /// Adds to the radiance of the paths that have arrived, sends those that continue, and returns
    /// their lanes.
    fn interact<P: PathParts + ?Sized, S: LaneSampler<R>, R: Wide<N>, const N: usize>(
        &self,
        parts: &P,
        arrival: Arrival<'_, S, R, N>,
    ) -> R::Mask;

    /// [`Estimator::sees_in_mirrors`](crate::integrator::Estimator::sees_in_mirrors).
    fn sees_in_mirrors(&self) -> bool {
        false
    }

    /// Adds background radiance to the paths that leave the scene.
    #[inline]
    fn escape<P: PathParts + ?Sized, R: Wide<N>, const N: usize>(
        &self,
        _parts: &P,
        scene: &Scene,
        paths: &mut PathState<R, N>,
        leaving: R::Mask,
    ) {
        paths.add_background(scene, R::splat(1.0), leaving);
    }
}

/// State of the paths in all lanes.
pub(crate) struct PathState<R: Wide<N>, const N: usize> {
    pub ray: Ray<R::Vector>,
    pub radiance: R::Vector,
    /// Throughput without radiance factors: these cancel when the path leaves the glass, and
    /// Russian roulette should not depend on them.
    pub throughput: R::Vector,
    /// Product of the radiance factors along the path.
    pub factor: R,
    /// Lanes in which next-event estimation has sampled the light that the ray may hit.
    pub light_sampled: R::Mask,
    /// Pdf of the ray's direction with respect to solid angle, where `light_sampled` is set.
    pub pdf: R,
    /// Number that decides the next game of Russian roulette.
    pub roulette: R,
    /// Probability of the survivals that this number has decided; 0 before the first game.
    pub roulette_share: R,
    /// Number of hits of each path.
    pub hits: [u32; N],
    /// Specular chains of the paths.
    pub chains: SpecularChains<R, N>,
    /// Stacks of pending branches, popped when a lane's path ends.
    branches: [Vec<Branch>; N],
    /// Bits of the lanes with pending branches.
    has_branches: u32,
}

/// A pending branch of a path.
struct Branch {
    ray: Ray,
    throughput: DVec3,
    light_sampled: bool,
    hits: u32,
}

impl<R: Wide<N>, const N: usize> PathState<R, N> {
    pub fn new() -> Self {
        let zero = R::Vector::zero();
        Self {
            ray: Ray::new(zero, R::Vector::splat_vector(DVec3::Z)),
            radiance: zero,
            throughput: zero,
            factor: R::splat(1.0),
            pdf: R::splat(0.0),
            roulette: R::splat(0.0),
            roulette_share: R::splat(0.0),
            light_sampled: R::Mask::splat(false),
            hits: [0; N],
            chains: SpecularChains::new(),
            branches: from_fn(|_| Vec::new()),
            has_branches: 0,
        }
    }

    /// Starts paths along these rays in the lanes of the mask.
    #[inline]
    pub fn start(&mut self, ray: &Ray<R::Vector>, starting: R::Mask) {
        let new = |value: R::Vector, old: R::Vector| Vector::select(starting, value, old);
        self.ray = Ray::select(starting, ray, &self.ray);
        self.radiance = new(R::Vector::zero(), self.radiance);
        self.throughput = new(R::Vector::splat_vector(DVec3::ONE), self.throughput);
        self.factor = R::select(starting, R::splat(1.0), self.factor);
        self.light_sampled = self.light_sampled & !starting;
        self.roulette_share = R::select(starting, R::splat(0.0), self.roulette_share);
        for lane in lanes_of(starting.bits()) {
            self.hits[lane] = 0;
            self.chains.start(lane);
        }
    }

    /// Adds weighted background radiance to the paths of these lanes.
    #[inline]
    pub fn add_background(&mut self, scene: &Scene, weight: R, leaving: R::Mask) {
        if leaving.any() {
            let background =
                R::Vector::from_fn(|i| scene.background().radiance(self.ray.direction.lane(i)));
            let shown = self.throughput * self.factor * background * weight;
            self.radiance = Vector::select(leaving, self.radiance + shown, self.radiance);
        }
    }

    /// Adds light that arrives at the current ends of these paths, times their throughput.
    #[inline]
    pub fn add(&mut self, light: R::Vector, active: R::Mask) {
        if active.any() {
            self.radiance = Vector::select(
                active,
                self.radiance + self.throughput * light,
                self.radiance,
            );
        }
    }

    /// Pushes a branch that leaves the surfaces for the paths of these lanes.
    #[inline(never)]
    pub fn push_branch(
        &mut self,
        surface: &SurfaceInteraction<'_, R, N>,
        direction: R::Vector,
        throughput: R::Vector,
        light_sampled: R::Mask,
        active: R::Mask,
    ) {
        let ray = surface.spawn_ray(direction);
        self.has_branches |= active.bits();
        for lane in lanes_of(active.bits()) {
            self.branches[lane].push(Branch {
                ray: ray.lane(lane),
                throughput: throughput.lane(lane),
                light_sampled: light_sampled.lane(lane),
                hits: self.hits[lane],
            });
        }
    }

    /// Pops a branch in each of the `ended` lanes that has one, and returns these lanes.
    #[inline]
    pub fn pop_branches(&mut self, ended: u32) -> u32 {
        let popped = ended & self.has_branches;
        if popped != 0 {
            self.pop(popped);
        }
        popped
    }

    /// Pops a branch in each of these lanes.
    #[inline(never)]
    fn pop(&mut self, popped: u32) {
        let vectors = [self.ray.origin, self.ray.direction, self.throughput];
        let mut lanes = vectors.map(|vector| vector.components().map(R::lanes));
        let mut light_sampled = self.light_sampled.bits();
        for lane in lanes_of(popped) {
            let Some(branch) = self.branches[lane].pop() else {
                continue;
            };
            let vectors = [branch.ray.origin, branch.ray.direction, branch.throughput];
            for (components, vector) in lanes.iter_mut().zip(vectors) {
                for (component, value) in components.iter_mut().zip(vector.to_array()) {
                    component[lane] = R::Scalar::rounded(value);
                }
            }
            light_sampled = light_sampled & !(1 << lane) | u32::from(branch.light_sampled) << lane;
            self.hits[lane] = branch.hits;
            if self.branches[lane].is_empty() {
                self.has_branches &= !(1 << lane);
            }
        }
        let vector = |components: [_; 3]| R::Vector::of(components.map(R::from_array));
        let [origin, direction, throughput] = lanes.map(vector);
        self.ray = Ray::new(origin, direction);
        self.throughput = throughput;
        self.light_sampled = R::Mask::from_bits(light_sampled);
    }

    /// Continues the paths of these lanes from surfaces, with this throughput.
    #[inline]
    pub fn continue_with(
        &mut self,
        surface: &SurfaceInteraction<'_, R, N>,
        direction: R::Vector,
        throughput: R::Vector,
        active: R::Mask,
    ) {
        self.ray = Ray::select(active, &surface.spawn_ray(direction), &self.ray);
        self.throughput = Vector::select(active, throughput, self.throughput);
    }
}
