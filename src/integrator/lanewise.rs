//! Parts of estimators evaluated for all lanes: the library's own functions if nothing is replaced,
//! otherwise the replaced functions lane by lane, only in the lanes of a mask.

use glam::DVec3;

use super::PathParts;
use crate::geometry::offsets::RayOrigin;
use crate::geometry::radiometry;
use crate::light::emitter::{Emitter, EmitterPoint};
use crate::material::fresnel;
use crate::math::real::{Mask, MaskOf, Real, Vector};
use crate::math::simd::Wide;
use crate::sampling::mis::{Heuristic, Strategy};
use crate::sampling::{mis, roulette};
use crate::scene::lanes::{IntersectionScratch, LaneScene};

/// A game of Russian roulette in all lanes.
pub(crate) struct RouletteGame<R: Real> {
    /// Lanes whose path goes on.
    pub survives: R::Mask,
    /// Survival probability.
    pub survival: R,
    /// Factor of a survivor's throughput.
    pub weight: R,
    /// Number that decides a survivor's next game.
    pub next: R,
}

/// Parts of estimators over lanes; each function is that of the same name without `lanes_`.
pub(crate) trait Lanewise: PathParts {
    /// Returns cos θ of (9).
    #[inline]
    fn lanes_cosine<V: Vector>(&self, normal: V, direction: V, active: MaskOf<V>) -> V::Real {
        if self.is_default() {
            return radiometry::cosine(normal, direction);
        }
        numbers(active, |i| self.cosine(normal.lane(i), direction.lane(i)))
    }

    /// Returns the Fresnel reflectance R of (12).
    #[inline]
    fn lanes_fresnel<R: Real>(&self, cos_1: R, [n1, n2]: [R; 2], active: R::Mask) -> R {
        if self.is_default() {
            return fresnel::reflectance(cos_1, n1, n2);
        }
        numbers(active, |i| {
            self.fresnel(cos_1.lane(i), n1.lane(i), n2.lane(i))
        })
    }

    /// Returns the refracted directions, and the lanes without total internal reflection.
    #[inline]
    fn lanes_refract<V: Vector>(
        &self,
        direction: V,
        normal: V,
        [n1, n2]: [V::Real; 2],
        active: MaskOf<V>,
    ) -> (V, MaskOf<V>) {
        if self.is_default() {
            return fresnel::refracted(direction, normal, n1, n2);
        }
        let refract = |i| self.refract(direction.lane(i), normal.lane(i), n1.lane(i), n2.lane(i));
        let exists = MaskOf::<V>::from_fn(|i| active.lane(i) && refract(i).is_some());
        (
            vectors(exists, |i| refract(i).unwrap_or(DVec3::ZERO)),
            exists,
        )
    }

    /// Returns the factor by which refraction scales radiance.
    #[inline]
    fn lanes_radiance_factor<R: Real>(&self, [n1, n2]: [R; 2], active: R::Mask) -> R {
        if self.is_default() {
            return fresnel::radiance_factor(n1, n2);
        }
        numbers(active, |i| self.radiance_factor(n1.lane(i), n2.lane(i)))
    }

    /// Returns the mirror directions.
    #[inline]
    fn lanes_mirror<V: Vector>(&self, direction: V, normal: V, active: MaskOf<V>) -> V {
        if self.is_default() {
            return fresnel::reflect(direction, normal);
        }
        vectors(active, |i| self.mirror(direction.lane(i), normal.lane(i)))
    }

    /// Plays Russian roulette by throughput.
    #[inline]
    fn lanes_survive<V: Vector>(
        &self,
        throughput: V,
        early: MaskOf<V>,
        random: V::Real,
        active: MaskOf<V>,
    ) -> RouletteGame<V::Real> {
        if self.is_default() {
            let survival = roulette::by_throughput(throughput, early);
            return RouletteGame {
                survives: active & roulette::survives(random, survival),
                survival,
                weight: roulette::weight(survival),
                next: roulette::rescaled(random, survival),
            };
        }
        let survival: V::Real = numbers(active, |i| {
            self.survival_by_throughput(throughput.lane(i), early.lane(i))
        });
        let survives = MaskOf::<V>::from_fn(|i| {
            active.lane(i) && self.survives(random.lane(i), survival.lane(i))
        });
        RouletteGame {
            survives,
            survival,
            weight: numbers(survives, |i| self.roulette_weight(survival.lane(i))),
            next: numbers(survives, |i| {
                self.rescaled(random.lane(i), survival.lane(i))
            }),
        }
    }

    /// Plays Russian roulette by the absorption of a surface, as in the report.
    #[inline]
    fn lanes_survive_absorption<R: Real>(
        &self,
        absorption: R,
        random: R,
        active: R::Mask,
    ) -> (R::Mask, R) {
        if self.is_default() {
            let survival = roulette::by_absorption(absorption);
            return (
                active & roulette::survives(random, survival),
                roulette::weight(survival),
            );
        }
        let survival = |i: usize| self.survival_by_absorption(absorption.lane(i));
        let survives =
            R::Mask::from_fn(|i| active.lane(i) && self.survives(random.lane(i), survival(i)));
        (
            survives,
            numbers(survives, |i| self.roulette_weight(survival(i))),
        )
    }

    /// Samples a point on an emitter, uniformly in area.
    #[inline(always)]
    fn lanes_sample_emitter<R: Real>(
        &self,
        emitter: &Emitter,
        random: [R; 2],
        active: R::Mask,
    ) -> EmitterPoint<R::Vector> {
        if self.is_default() {
            return emitter.sample(random);
        }
        let none = EmitterPoint::new(DVec3::ZERO, DVec3::Z);
        let points: [_; MAX_LANES] = each(active, none, |i| {
            self.sample_emitter(emitter, random.map(|r| r.lane(i)))
        });
        EmitterPoint::from_fn(|i| points[i])
    }

    /// Samples a point on an emitter uniformly in the solid angle seen from a point: returns the
    /// lanes in which this is possible, the points and their pdfs.
    #[inline]
    fn lanes_sample_solid_angle<R: Real>(
        &self,
        emitter: &Emitter,
        from: R::Vector,
        random: [R; 2],
        active: R::Mask,
    ) -> (R::Mask, EmitterPoint<R::Vector>, R) {
        if self.is_default()
            && let Some(sampled) = emitter.sample_cap(from, random)
        {
            return sampled;
        }
        let samples: [_; MAX_LANES] = each(active, None, |i| {
            self.sample_solid_angle(emitter, from.lane(i), random.map(|r| r.lane(i)))
        });
        let none = (EmitterPoint::new(DVec3::ZERO, DVec3::ZERO), 0.0);
        (
            R::Mask::from_fn(|i| samples[i].is_some()),
            EmitterPoint::from_fn(|i| samples[i].unwrap_or(none).0),
            R::from_lanes(|i| samples[i].unwrap_or(none).1),
        )
    }

    /// Returns the pdf of [`lanes_sample_solid_angle`](Self::lanes_sample_solid_angle) for any
    /// point of the emitter's front, and the lanes that have one.
    #[inline]
    fn lanes_pdf_solid_angle<R: Real>(
        &self,
        emitter: &Emitter,
        from: R::Vector,
        active: R::Mask,
    ) -> (R::Mask, R) {
        if self.is_default()
            && let Some(pdf) = emitter.pdf_cap(from)
        {
            return pdf;
        }
        let pdfs: [_; MAX_LANES] = each(active, None, |i| {
            self.pdf_solid_angle(emitter, from.lane(i))
        });
        (
            R::Mask::from_fn(|i| pdfs[i].is_some()),
            R::from_lanes(|i| pdfs[i].unwrap_or(0.0)),
        )
    }

    /// Returns the pdf of a point on an emitter that is picked with this probability.
    #[inline]
    fn lanes_pdf_of_pick<R: Real>(&self, pdf: R, probability: R, active: R::Mask) -> R {
        if self.is_default() {
            return pdf * probability;
        }
        numbers(active, |i| {
            self.pdf_of_pick(pdf.lane(i), probability.lane(i))
        })
    }

    /// Returns the solid angle per area of an emitter.
    #[inline]
    fn lanes_solid_angle_per_area<R: Real>(
        &self,
        cosine_at_emitter: R,
        distance_squared: R,
        active: R::Mask,
    ) -> R {
        if self.is_default() {
            return radiometry::solid_angle_per_area(cosine_at_emitter, distance_squared);
        }
        numbers(active, |i| {
            self.solid_angle_per_area(cosine_at_emitter.lane(i), distance_squared.lane(i))
        })
    }

    /// Returns the weight of multiple importance sampling by a heuristic.
    #[inline]
    fn lanes_mis_weight<R: Real>(
        &self,
        heuristic: Heuristic,
        pdf: R,
        other: R,
        active: R::Mask,
    ) -> R {
        match heuristic {
            Heuristic::Balance if self.is_default() => mis::balance(pdf, other),
            Heuristic::Power if self.is_default() => mis::power(pdf, other),
            Heuristic::Balance => numbers(active, |i| self.mis_weight(pdf.lane(i), other.lane(i))),
            Heuristic::Power => numbers(active, |i| {
                self.mis_power_weight(pdf.lane(i), other.lane(i))
            }),
        }
    }

    /// Returns the lanes in which emission that a path hits counts without an MIS weight.
    #[inline]
    fn lanes_count_emission<M: Mask>(&self, strategy: Strategy, sampled: M, active: M) -> M {
        if self.is_default() {
            return active
                & if strategy == Strategy::Light {
                    !sampled
                } else {
                    M::splat(true)
                };
        }
        M::from_fn(|i| active.lane(i) && self.counts_emission(strategy, sampled.lane(i)))
    }
}

impl<P: PathParts + ?Sized> Lanewise for P {}

/// Largest number of lanes.
const MAX_LANES: usize = crate::math::simd::SINGLES;

/// Evaluates a value in each lane of the mask; `none` in other lanes.
#[inline]
pub(super) fn each<T: Copy, M: Mask, const N: usize>(
    active: M,
    none: T,
    value: impl Fn(usize) -> T,
) -> [T; N] {
    // A loop: `from_fn` would be unrolled.
    let mut values = [none; N];
    for lane in (0..N).filter(|lane| active.lane(*lane)) {
        values[lane] = value(lane);
    }
    values
}

/// Evaluates a number in each lane of the mask; 0 in other lanes.
#[inline]
pub(crate) fn numbers<R: Real>(active: R::Mask, number: impl Fn(usize) -> f64) -> R {
    R::from_lanes(|i| if active.lane(i) { number(i) } else { 0.0 })
}

/// Evaluates a vector in each lane of the mask; 0 in other lanes.
#[inline]
pub(crate) fn vectors<V: Vector>(active: MaskOf<V>, vector: impl Fn(usize) -> DVec3) -> V {
    V::from_fn(|i| {
        if active.lane(i) {
            vector(i)
        } else {
            DVec3::ZERO
        }
    })
}

/// In which of the `active` lanes two surface points with unit normals see each other, as
/// [`NextEvent::visible`](super::NextEvent::visible).
#[inline]
pub(super) fn visible<P: PathParts + ?Sized, R: Wide<N>, const N: usize>(
    parts: &P,
    scene: LaneScene<'_, R, N>,
    x: &RayOrigin<R::Vector>,
    y: &RayOrigin<R::Vector>,
    through_glass: bool,
    active: R::Mask,
    scratch: &mut IntersectionScratch<R, N>,
) -> R::Mask {
    if parts.is_default() {
        return scene.visible(x, y, through_glass, active, scratch);
    }
    let visible = |i: usize| parts.visible(scene.scene, x.lane(i), y.lane(i), through_glass);
    R::Mask::from_fn(|i| active.lane(i) && visible(i))
}
