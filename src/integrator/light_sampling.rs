//! Points on emitters: how particles and shadow rays pick them, and with what pdfs.

use std::array::from_fn;

use glam::DVec3;

use super::lanewise::Lanewise;
use super::{NextEvent, Walking};
use crate::light::emitter::{Emitter, EmitterPoint, LightSampling};
use crate::light::light_sampler;
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::Wide;
use crate::sampling::lanes::LaneSampler;
use crate::sampling::rng::{uniform, uniform2};
use crate::sampling::sampler::Sampler;
use crate::scene::Scene;

/// The uniform numbers of a shadow ray in each lane.
#[derive(Clone, Copy)]
pub(crate) struct LightNumbers<R> {
    /// Which emitter; of a single one nothing.
    pub pick: R,
    /// Which point.
    pub point: [R; 2],
}

impl<R: Real> LightNumbers<R> {
    /// Draws them in the lanes of the mask, in a scene with emitters.
    #[inline]
    pub fn new<S: LaneSampler<R>>(scene: &Scene, active: R::Mask, random: &mut S) -> Self {
        let zero = R::splat(0.0);
        let pick = match scene.emitters().len() {
            _ if !active.any() => zero,
            0 => {
                return Self {
                    pick: zero,
                    point: [zero; 2],
                };
            }
            1 => {
                random.skip(active);
                zero
            }
            _ => random.uniform(active),
        };
        Self {
            pick,
            point: [random.uniform(active), random.uniform(active)],
        }
    }
}

/// A point on an emitter that is picked among all, and the emitter's number; `None` without
/// emitters.
#[inline]
pub(super) fn pick_point<P: NextEvent, R: Sampler>(
    parts: &P,
    scene: &Scene,
    rng: &mut R,
) -> Option<(usize, EmitterPoint)> {
    if scene.emitters().is_empty() {
        return None;
    }
    let index = parts.pick_emitter(uniform(rng), scene.flux_picks());
    Some((
        index,
        parts.sample_emitter(&scene.emitters()[index], uniform2(rng)),
    ))
}

/// The pdf, with respect to area, of a point that [`pick_point`] returns on the emitter of this
/// number.
#[inline]
pub(super) fn point_pdf<P: NextEvent>(parts: &P, scene: &Scene, index: usize) -> f64 {
    parts.pdf_of_pick(
        parts.emitter_pdf_area(&scene.emitters()[index]),
        scene.flux_picks().probability(index),
    )
}

/// The number of the emitter that a shadow ray from a point picks, by `lights`, and the probability
/// of that.
#[inline]
fn pick_from<P: NextEvent>(
    parts: &P,
    scene: &Scene,
    lights: LightSampling,
    from: DVec3,
    r: f64,
) -> (usize, f64) {
    let emitters = scene.emitters();
    let count = emitters.len();
    if !lights.by_contribution(count) {
        let index = parts.pick_emitter(r, scene.flux_picks());
        return (index, scene.flux_picks().probability(index));
    }
    let contribution = |i: usize| parts.contribution(&emitters[i], from);
    scene
        .light_groups()
        .pick(r, from, contribution, |r, shares| {
            parts.pick_by_share(r, shares)
        })
}

/// The same probability, of the emitter of this number.
#[inline]
fn probability_from<P: NextEvent>(
    parts: &P,
    scene: &Scene,
    lights: LightSampling,
    from: DVec3,
    index: usize,
) -> f64 {
    let emitters = scene.emitters();
    let count = emitters.len();
    if !lights.by_contribution(count) {
        return scene.flux_picks().probability(index);
    }
    scene
        .light_groups()
        .probability(index, from, |i| parts.contribution(&emitters[i], from))
}

/// Which emitters shadow rays from the points of the active lanes pick, and with what probability.
#[inline]
fn pick_emitters<P: Walking, R: Wide<N>, const N: usize>(
    parts: &P,
    scene: &Scene,
    lights: LightSampling,
    from: R::Vector,
    r: R,
    active: R::Mask,
) -> ([usize; N], R) {
    let emitters = scene.emitters();
    let count = emitters.len();
    if count == 1 {
        return ([0; N], R::splat(1.0));
    }
    if !parts.is_standard() || !lights.by_contribution(count) || scene.light_groups().is_nested() {
        let one = |i| pick_from(parts, scene, lights, from.lane(i), r.lane(i));
        let each: [_; N] = from_fn(|i| if active.lane(i) { one(i) } else { (0, 1.0) });
        return (each.map(|(index, _)| index), R::from_lanes(|i| each[i].1));
    }
    let mut shares = [R::splat(0.0); light_sampler::MOST];
    light_sampler::share_all(|i| emitters[i].contribution(from), &mut shares[..count]);
    let (index, share) = light_sampler::pick(&shares[..count], r);
    (index.whole().map(|index| index as usize), share)
}

/// The probabilities with which shadow rays from the points of the active lanes pick the emitters
/// of these numbers.
#[inline]
fn probability_of_pick<P: Walking, R: Wide<N>, const N: usize>(
    parts: &P,
    scene: &Scene,
    lights: LightSampling,
    from: R::Vector,
    emitter: [usize; N],
    active: R::Mask,
) -> R {
    let emitters = scene.emitters();
    let count = emitters.len();
    if count == 1 {
        return R::splat(1.0);
    }
    if !parts.is_standard() || !lights.by_contribution(count) || scene.light_groups().is_nested() {
        let one = |i: usize| probability_from(parts, scene, lights, from.lane(i), emitter[i]);
        return R::from_lanes(|i| if active.lane(i) { one(i) } else { 1.0 });
    }
    light_sampler::share(
        |i| emitters[i].contribution(from),
        count,
        R::from_lanes(|i| emitter[i] as f64),
    )
}

/// Emitters and points on them, as shadow rays from some points pick them.
pub(super) struct PickedLight<R: Real, const N: usize> {
    /// The numbers of the emitters, and the probabilities with which they are picked.
    pub emitter: [usize; N],
    pub probability: R,
    pub on_emitter: PickedPoint<R>,
    /// The lanes that have picked one.
    pub active: R::Mask,
}

impl<R: Wide<N>, const N: usize> PickedLight<R, N> {
    /// By these numbers, from the points of the active lanes.
    #[inline]
    pub fn new<P: Walking>(
        parts: &P,
        scene: &Scene,
        lights: LightSampling,
        from: R::Vector,
        random: &LightNumbers<R>,
        active: R::Mask,
    ) -> Self {
        let (emitter, probability) = pick_emitters(parts, scene, lights, from, random.pick, active);
        let active = active & probability.above(R::splat(0.0));
        let on_emitter = PickedPoint::new(
            parts,
            scene.emitters(),
            lights,
            emitter,
            from,
            random.point,
            active,
        );
        Self {
            emitter,
            probability,
            on_emitter,
            active,
        }
    }
}

/// Points on emitters of given numbers, as shadow rays from some points pick them.
pub(super) struct PickedPoint<R: Real> {
    pub point: EmitterPoint<R::Vector>,
    pub radiance: R::Vector,
    pub pdf_area: R,
    /// Where the point was picked by solid angle, and its pdf with respect to that.
    by_angle: R::Mask,
    pdf_angle: R,
}

impl<R: Real> PickedPoint<R> {
    /// In each active lane a point on the emitter of this number, seen from a point.
    #[inline]
    pub fn new<P: Walking, const N: usize>(
        parts: &P,
        emitters: &[Emitter],
        lights: LightSampling,
        emitter: [usize; N],
        from: R::Vector,
        random: [R; 2],
        active: R::Mask,
    ) -> Self {
        let (zero, none) = (R::splat(0.0), R::Vector::splat_vector(DVec3::ZERO));
        let mut picked = Self {
            point: EmitterPoint {
                point: none,
                normal: none,
            },
            radiance: none,
            pdf_area: zero,
            by_angle: R::Mask::splat(false),
            pdf_angle: zero,
        };
        for_each_distinct(emitter, active, |number, here: R::Mask| {
            let emitter = &emitters[number];
            let mut left = here;
            if lights.by_solid_angle(emitter) {
                let (exists, point, pdf) =
                    parts.lanes_sample_solid_angle(emitter, from, random, here);
                let exists = here & exists;
                left = here & !exists;
                picked.point.point = Vector::choose(exists, point.point, picked.point.point);
                picked.point.normal = Vector::choose(exists, point.normal, picked.point.normal);
                picked.by_angle = picked.by_angle | exists;
                picked.pdf_angle = R::choose(exists, pdf, picked.pdf_angle);
            }
            if left.any() {
                let point = parts.lanes_sample_emitter(emitter, random, left);
                picked.point.point = Vector::choose(left, point.point, picked.point.point);
                picked.point.normal = Vector::choose(left, point.normal, picked.point.normal);
            }
            picked.radiance = Vector::choose(
                here,
                R::Vector::splat_vector(emitter.radiance),
                picked.radiance,
            );
            picked.pdf_area = R::choose(
                here,
                R::splat(parts.emitter_pdf_area(emitter)),
                picked.pdf_area,
            );
        });
        picked
    }

    /// The pdfs with respect to solid angle of points that are seen at these cosines and squared
    /// distances.
    #[inline]
    pub fn pdf<P: Walking>(&self, parts: &P, cosine: R, distance_squared: R, active: R::Mask) -> R {
        let per_area =
            parts.lanes_solid_angle_per_area(cosine, distance_squared, active & !self.by_angle);
        R::choose(self.by_angle, self.pdf_angle, self.pdf_area / per_area)
    }
}

/// A point on an emitter, as it is seen from another.
#[derive(Clone, Copy)]
pub(super) struct SeenLight<R, const N: usize> {
    /// The emitter's number.
    pub emitter: [usize; N],
    /// The cosine there between its normal and the direction to where it is seen from.
    pub cosine: R,
    pub distance_squared: R,
}

/// The pdfs, with respect to solid angle, with which [`sample_light`] at `from` picks these points.
#[inline]
pub(super) fn light_pdf<P: Walking, R: Wide<N>, const N: usize>(
    parts: &P,
    scene: &Scene,
    lights: LightSampling,
    from: R::Vector,
    seen: SeenLight<R, N>,
    active: R::Mask,
) -> R {
    let SeenLight {
        emitter,
        cosine,
        distance_squared,
    } = seen;
    let zero = R::splat(0.0);
    let probability: R = probability_of_pick(parts, scene, lights, from, emitter, active);
    let active = active & probability.above(zero);
    let per_area = parts.lanes_solid_angle_per_area(cosine, distance_squared, active);
    let mut pdf = R::splat(1.0) / per_area;
    for_each_distinct(emitter, active, |number, here: R::Mask| {
        let emitter = &scene.emitters()[number];
        let mut own = R::splat(parts.emitter_pdf_area(emitter)) / per_area;
        if lights.by_solid_angle(emitter) {
            let (exists, by_angle) = parts.lanes_pdf_solid_angle(emitter, from, here);
            own = R::choose(exists, by_angle, own);
        }
        pdf = R::choose(here, own, pdf);
    });
    // Behind an emitter the one is infinite and the other may be 0.
    R::choose(
        active,
        parts.lanes_pdf_of_pick(pdf, probability, active),
        zero,
    )
}

/// Hands over each of the numbers once, with the lanes that have it.
#[inline]
pub(super) fn for_each_distinct<M: Mask, const N: usize>(
    numbers: [usize; N],
    active: M,
    mut number: impl FnMut(usize, M),
) {
    let mut left = active.bits();
    while left != 0 {
        let next = numbers[left.trailing_zeros() as usize % N];
        let here = M::from_bits(left) & M::from_fn(|i| numbers[i] == next);
        left &= !here.bits();
        number(next, here);
    }
}
