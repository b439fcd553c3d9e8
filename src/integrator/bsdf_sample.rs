//! BSDF sampling at the surfaces of all lanes.

use std::array::from_fn;
use std::convert::Infallible;
use std::marker::PhantomData;

use glam::DVec3;
use rand::TryRng;

use super::PathParts;
use super::interaction::{ShadingPoint, SurfaceInteraction};
use super::lanewise::{Lanewise, each};
use crate::geometry::radiometry;
use crate::material;
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{Wide, lanes_of};
use crate::sampling::lanes::LaneSampler;
use crate::sampling::warp;
use crate::scene::lanes::material::NOT_COSINE_SAMPLED;

/// A sampled direction per lane.
pub(crate) struct BsdfSample<R: Real> {
    /// Lanes with a sampled direction.
    pub exists: R::Mask,
    /// Unit directions in world space.
    pub direction: R::Vector,
    /// f_r cos θ / p per colour channel, as in [`material::BsdfSample`].
    pub weight: R::Vector,
    /// p with respect to solid angle; 0 where the direction has no pdf.
    pub pdf: R,
    /// Lanes whose direction has a pdf: not at mirrors and glass.
    pub has_pdf: R::Mask,
    /// Factor by which refraction scales radiance; 1 elsewhere.
    pub radiance_factor: R,
}

/// Reflected and refracted directions at mirrors and glass.
pub(crate) struct SpecularSplit<R: Real> {
    /// Direction and weight of reflection.
    pub reflected: (R::Vector, R::Vector),
    /// Lanes in which light is refracted.
    pub refracts: R::Mask,
    /// Direction and weight of refraction.
    pub refracted: (R::Vector, R),
}

impl<R: Wide<N>, const N: usize> SurfaceInteraction<'_, R, N> {
    /// Samples a direction in the active lanes, as
    /// [`Scattering::sample`](crate::material::Scattering::sample). Draws two numbers for a model
    /// with a pdf, three for rough glass, one for glass, none for a mirror.
    #[inline(always)]
    pub fn sample<P: PathParts + ?Sized, S: LaneSampler<R>>(
        &self,
        parts: &P,
        active: R::Mask,
        random: &mut S,
    ) -> BsdfSample<R> {
        if !parts.is_default() {
            return self.sample_per_lane(parts, active, random);
        }
        let mut sample = self.sample_specular(parts, active & !self.non_delta, random);
        sample.has_pdf = active & self.non_delta;
        if sample.has_pdf.any() {
            self.sample_non_delta(parts, &mut sample, random);
        }
        sample
    }

    /// Samples a direction at mirrors and glass.
    #[inline(always)]
    fn sample_specular<P: PathParts + ?Sized, S: LaneSampler<R>>(
        &self,
        parts: &P,
        active: R::Mask,
        random: &mut S,
    ) -> BsdfSample<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let white = R::Vector::splat_vector(DVec3::ONE);
        let vertex = &self.vertex;
        let (d, n) = (vertex.direction, vertex.frame.z);
        let mut sample = BsdfSample {
            exists: active & self.delta(),
            direction: d,
            weight: white,
            pdf: zero,
            has_pdf: R::Mask::splat(false),
            radiance_factor: one,
        };
        if sample.exists.any() {
            sample.direction = parts.lanes_mirror(d, n, sample.exists);
            sample.weight = Vector::select(self.mirror, self.colour, white);
        }
        let glass = active & self.glass;
        if glass.any() {
            let random = random.uniform(glass);
            let (n1, n2) = vertex.indices(self.index);
            let reflectance = parts.lanes_fresnel(-d.dot(n), [n1, n2], glass);
            let (refracted, exists) = parts.lanes_refract(d, n, [n1, n2], glass);
            let refracts = glass & !random.cmplt(reflectance) & exists;
            sample.direction = Vector::select(refracts, refracted, sample.direction);
            let factor = parts.lanes_radiance_factor([n1, n2], refracts);
            sample.radiance_factor = R::select(refracts, factor, one);
        }
        sample
    }

    /// Samples a direction at surfaces whose BSDF is not a Dirac distribution.
    #[inline(always)]
    fn sample_non_delta<P: PathParts + ?Sized, S: LaneSampler<R>>(
        &self,
        parts: &P,
        sample: &mut BsdfSample<R>,
        random: &mut S,
    ) {
        let active = sample.has_pdf;
        let rough_glass = active & self.rough_glass();
        let numbers = [random.uniform(active), random.uniform(active)];
        let third = if rough_glass.any() {
            random.uniform(rough_glass)
        } else {
            R::splat(0.0)
        };
        let mut wi: R::Vector = warp::cosine_hemisphere(numbers);
        let models = active & self.is(NOT_COSINE_SAMPLED);
        let mut exists = active;
        if models.any() {
            let [r1, r2] = numbers;
            let alone = |i: usize| {
                let random = [r1, r2, third].map(|r| r.lane(i));
                self.bsdf(i)
                    .sample_direction(self.vertex.wo.lane(i), random)
            };
            let own: [Option<DVec3>; N] = from_fn(|i| match models.lane(i) {
                true => alone(i),
                false => Some(wi.lane(i)),
            });
            exists = active & R::Mask::from_fn(|i| own[i].is_some());
            wi = R::Vector::from_fn(|i| own[i].unwrap_or(DVec3::Z));
        }
        let pdf = self.pdf(parts, wi, active);
        let weight = self.weighted(parts, wi, pdf, active);
        sample.exists = sample.exists | (exists & !pdf.cmpeq(R::splat(0.0)));
        sample.direction = Vector::select(active, self.vertex.frame.world(wi), sample.direction);
        sample.weight = Vector::select(active, weight, sample.weight);
        sample.pdf = R::select(active, pdf, sample.pdf);
        if rough_glass.any() {
            let factor = |i: usize| self.radiance_factor(parts, wi.lane(i), i);
            let factors = R::from_lanes(|i| if rough_glass.lane(i) { factor(i) } else { 1.0 });
            sample.radiance_factor = R::select(rough_glass, factors, sample.radiance_factor);
        }
    }

    /// Samples lane by lane, as [`sample`](Self::sample), for parts that replace library functions.
    fn sample_per_lane<P: PathParts + ?Sized, S: LaneSampler<R>>(
        &self,
        parts: &P,
        active: R::Mask,
        random: &mut S,
    ) -> BsdfSample<R> {
        let mut samples: [Option<material::BsdfSample>; N] = [None; N];
        for lane in lanes_of(active.bits()) {
            let number = PhantomData;
            let mut rng = LaneRng {
                random,
                lane,
                number,
            };
            let vertex = self.vertex.lane(lane);
            samples[lane] = parts.sample(self.surface_bsdf(lane), &vertex, &mut rng);
        }
        let exists = R::Mask::from_fn(|i| samples[i].is_some());
        let pdf = |i: usize| samples[i].and_then(|sample| sample.pdf);
        BsdfSample {
            exists,
            direction: R::Vector::from_fn(|i| {
                samples[i].map_or(DVec3::Z, |sample| sample.direction)
            }),
            weight: R::Vector::from_fn(|i| samples[i].map_or(DVec3::ZERO, |sample| sample.weight)),
            pdf: R::from_lanes(|i| pdf(i).unwrap_or(0.0)),
            has_pdf: R::Mask::from_fn(|i| pdf(i).is_some()),
            radiance_factor: R::from_lanes(|i| {
                samples[i].map_or(1.0, |sample| sample.radiance_factor)
            }),
        }
    }

    /// Returns both directions, reflected and refracted, at mirrors and glass.
    pub fn split<P: PathParts + ?Sized>(
        &self,
        parts: &P,
        radiance_factor: bool,
        active: R::Mask,
    ) -> SpecularSplit<R> {
        let (d, n) = (self.vertex.direction, self.vertex.frame.z);
        let (one, glass) = (R::splat(1.0), active & self.glass);
        let mut split = SpecularSplit {
            reflected: (parts.lanes_mirror(d, n, active), self.colour),
            refracts: R::Mask::splat(false),
            refracted: (d, one),
        };
        if glass.any() {
            let (n1, n2) = self.vertex.indices(self.index);
            let share = parts.lanes_fresnel(-d.dot(n), [n1, n2], glass);
            let (direction, exists) = parts.lanes_refract(d, n, [n1, n2], glass);
            let factor = if radiance_factor {
                parts.lanes_radiance_factor([n1, n2], glass & exists)
            } else {
                one
            };
            let white = R::Vector::splat_vector(DVec3::ONE);
            split.reflected.1 = Vector::select(glass, white * share, self.colour);
            (split.refracts, split.refracted) =
                (glass & exists, (direction, (one - share) * factor));
        }
        split
    }

    /// Samples a direction uniformly over the hemisphere, in world space, and returns its weight,
    /// too.
    #[inline(always)]
    pub fn sample_uniform<P: PathParts + ?Sized>(
        &self,
        parts: &P,
        random: [R; 2],
        active: R::Mask,
    ) -> (R::Vector, R::Vector) {
        if !parts.is_default() {
            let none = material::BsdfSample {
                direction: DVec3::Z,
                weight: DVec3::ZERO,
                pdf: None,
                radiance_factor: 1.0,
            };
            let samples: [_; N] = each(active, none, |i| {
                let wo = self.vertex.wo.lane(i);
                parts.sample_uniform(&self.bsdf(i), wo, random.map(|r| r.lane(i)))
            });
            let wi = R::Vector::from_fn(|i| samples[i].direction);
            let weight = R::Vector::from_fn(|i| samples[i].weight);
            return (self.vertex.frame.world(wi), weight);
        }
        let wi: R::Vector = warp::uniform_hemisphere(random);
        let weight = self.weighted(parts, wi, warp::uniform_hemisphere_pdf(wi.z()), active);
        (self.vertex.frame.world(wi), weight)
    }

    /// Returns f_r cos θ / p of a direction.
    #[inline(always)]
    fn weighted<P: PathParts + ?Sized>(
        &self,
        parts: &P,
        wi: R::Vector,
        pdf: R,
        active: R::Mask,
    ) -> R::Vector {
        let up = R::Vector::splat_vector(DVec3::Z);
        let [x, y, z] = wi.components();
        let above = if self.rough_glass().any() {
            R::Vector::of([x, y, z.abs()])
        } else {
            wi
        };
        let cosine = radiometry::cosine(up, above);
        let (brdf, one) = (
            self.brdf(parts, wi, active),
            R::Vector::splat_vector(DVec3::ONE),
        );
        radiometry::reflected(brdf, one, cosine, pdf)
    }
}

/// Random number generator that draws from one lane.
struct LaneRng<'a, S, R> {
    random: &'a mut S,
    lane: usize,
    number: PhantomData<R>,
}

impl<R: Real, S: LaneSampler<R>> TryRng for LaneRng<'_, S, R> {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.try_next_u64().map(|word| word as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.random.next_bits(self.lane))
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for bytes in bytes.chunks_mut(8) {
            bytes.copy_from_slice(&self.random.next_bits(self.lane).to_le_bytes()[..bytes.len()]);
        }
        Ok(())
    }
}
