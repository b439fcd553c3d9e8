//! Light sampling: how particles and shadow rays pick points on emitters, and their pdfs.

use arrayvec::ArrayVec;
use glam::DVec3;

use super::lanewise::{Lanewise, each};
use super::{NextEvent, PathParts};
use crate::light::emitter::{Emitter, EmitterPoint, LightSampling};
use crate::light::light_sampler;
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::Wide;
use crate::sampling::lanes::LaneSampler;
use crate::sampling::rng::{uniform, uniform2};
use crate::sampling::sampler::Sampler;
use crate::scene::Scene;

/// Uniform random numbers of a shadow ray in each lane.
#[derive(Clone, Copy)]
pub(crate) struct LightNumbers<R> {
    /// Picks the emitter; unused if there is only one.
    pub pick: R,
    /// Picks the point on the emitter.
    pub point: [R; 2],
}

impl<R: Real> LightNumbers<R> {
    /// Draws the numbers in the lanes of the mask; all are 0 in a scene without emitters.
    #[inline(always)]
    pub fn new<S: LaneSampler<R>>(scene: &Scene, active: R::Mask, random: &mut S) -> Self {
        let (mut pick, mut point) = (R::splat(0.0), [R::splat(0.0); 2]);
        if active.any() && !scene.emitters().is_empty() {
            if scene.emitters().len() == 1 {
                random.skip(active);
            } else {
                pick = random.uniform(active);
            }
            point = [random.uniform(active), random.uniform(active)];
        }
        Self { pick, point }
    }
}

/// Picks an emitter by flux and samples a point on it; returns its index and the point, `None`
/// without emitters.
#[inline]
pub(super) fn pick_point<P: NextEvent + ?Sized, R: Sampler>(
    parts: &P,
    scene: &Scene,
    rng: &mut R,
) -> Option<(usize, EmitterPoint)> {
    if scene.emitters().is_empty() {
        return None;
    }
    let index = parts.pick_emitter(uniform(rng), scene.power_light_sampler());
    Some((
        index,
        parts.sample_emitter(&scene.emitters()[index], uniform2(rng)),
    ))
}

/// Returns the pdf, with respect to area, of a point that [`pick_point`] returns on the emitter
/// with this index.
#[inline]
pub(super) fn point_pdf<P: NextEvent + ?Sized>(parts: &P, scene: &Scene, index: usize) -> f64 {
    parts.pdf_of_pick(
        parts.emitter_pdf_area(&scene.emitters()[index]),
        scene.power_light_sampler().probability(index),
    )
}

/// Picks an emitter for a shadow ray from a point, by `lights`; returns its index and the
/// probability of picking it.
#[inline]
fn pick_from<P: NextEvent + ?Sized>(
    parts: &P,
    scene: &Scene,
    lights: LightSampling,
    from: DVec3,
    r: f64,
) -> (usize, f64) {
    let emitters = scene.emitters();
    let count = emitters.len();
    if !lights.by_importance(count) {
        let index = parts.pick_emitter(r, scene.power_light_sampler());
        return (index, scene.power_light_sampler().probability(index));
    }
    let importance = |i: usize| parts.emitter_importance(&emitters[i], from);
    scene.light_tree().pick(r, from, importance, |r, shares| {
        parts.pick_by_probability(r, shares)
    })
}

/// Returns the probability with which [`pick_from`] picks the emitter with this index.
#[inline]
fn probability_from<P: NextEvent + ?Sized>(
    parts: &P,
    scene: &Scene,
    lights: LightSampling,
    from: DVec3,
    index: usize,
) -> f64 {
    let emitters = scene.emitters();
    let count = emitters.len();
    if !lights.by_importance(count) {
        return scene.power_light_sampler().probability(index);
    }
    scene.light_tree().probability(index, from, |i| {
        parts.emitter_importance(&emitters[i], from)
    })
}

/// Picks emitters for shadow rays from the points of the active lanes; returns their indices and
/// probabilities.
#[inline]
fn pick_emitters<P: PathParts + ?Sized, R: Wide<N>, const N: usize>(
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
    if !parts.is_default() || !lights.by_importance(count) || scene.light_tree().is_nested() {
        let one = |i| pick_from(parts, scene, lights, from.lane(i), r.lane(i));
        let each: [_; N] = each(active, (0, 1.0), one);
        return (each.map(|(index, _)| index), R::from_lanes(|i| each[i].1));
    }
    let zeros = std::iter::repeat_n(R::splat(0.0), count);
    let mut shares: ArrayVec<R, { light_sampler::MAX_EXACT_LIGHTS }> = zeros.collect();
    light_sampler::probabilities(|i| emitters[i].importance(from), &mut shares);
    let (index, share) = light_sampler::pick(&shares, r);
    (index.to_u32().map(|index| index as usize), share)
}

/// Returns the probabilities with which [`pick_emitters`] picks these emitters.
#[inline]
fn probability_of_pick<P: PathParts + ?Sized, R: Wide<N>, const N: usize>(
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
    if !parts.is_default() || !lights.by_importance(count) || scene.light_tree().is_nested() {
        let one = |i: usize| probability_from(parts, scene, lights, from.lane(i), emitter[i]);
        return R::from_lanes(|i| if active.lane(i) { one(i) } else { 1.0 });
    }
    light_sampler::probability(
        |i| emitters[i].importance(from),
        count,
        R::from_lanes(|i| emitter[i] as f64),
    )
}

/// Emitters that shadow rays have picked, and points on them.
pub(super) struct PickedLight<R: Real, const N: usize> {
    /// Indices of the emitters, and the probabilities with which they are picked.
    pub emitter: [usize; N],
    pub probability: R,
    pub on_emitter: PickedPoint<R>,
    /// Lanes that have picked an emitter.
    pub active: R::Mask,
}

impl<R: Wide<N>, const N: usize> PickedLight<R, N> {
    /// Picks emitters and points with these numbers, for shadow rays from the points of the active
    /// lanes.
    #[inline]
    pub fn new<P: PathParts + ?Sized>(
        parts: &P,
        scene: &Scene,
        lights: LightSampling,
        from: R::Vector,
        random: &LightNumbers<R>,
        active: R::Mask,
    ) -> Self {
        let (emitter, probability) = pick_emitters(parts, scene, lights, from, random.pick, active);
        let active = active & probability.cmpgt(R::splat(0.0));
        let (emitters, random) = (scene.emitters(), random.point);
        let on_emitter = PickedPoint::new(parts, emitters, lights, emitter, from, random, active);
        Self {
            emitter,
            probability,
            on_emitter,
            active,
        }
    }
}

/// Points that shadow rays have picked on given emitters.
pub(super) struct PickedPoint<R: Real> {
    pub point: EmitterPoint<R::Vector>,
    pub radiance: R::Vector,
    pub pdf_area: R,
    /// Lanes whose point was sampled by solid angle, and its pdf with respect to solid angle.
    by_angle: R::Mask,
    pdf_angle: R,
}

impl<R: Real> PickedPoint<R> {
    /// Samples a point on the given emitter in each active lane, for a shadow ray from `from`.
    #[inline]
    pub fn new<P: PathParts + ?Sized, const N: usize>(
        parts: &P,
        emitters: &[Emitter],
        lights: LightSampling,
        emitter: [usize; N],
        from: R::Vector,
        random: [R; 2],
        active: R::Mask,
    ) -> Self {
        let (zero, none) = (R::splat(0.0), R::Vector::zero());
        let mut picked = Self {
            point: EmitterPoint::new(none, none),
            radiance: none,
            pdf_area: zero,
            by_angle: R::Mask::splat(false),
            pdf_angle: zero,
        };
        if let [emitter] = emitters {
            picked.sample(parts, emitter, lights, from, random, active);
        } else {
            for_each_distinct(emitter, active, |number, here: R::Mask| {
                picked.sample(parts, &emitters[number], lights, from, random, here);
            });
        }
        picked
    }

    /// Samples a point on an emitter in the lanes of the mask.
    #[inline(always)]
    fn sample<P: PathParts + ?Sized>(
        &mut self,
        parts: &P,
        emitter: &Emitter,
        lights: LightSampling,
        from: R::Vector,
        random: [R; 2],
        here: R::Mask,
    ) {
        let mut left = here;
        if lights.by_solid_angle(emitter) {
            let (exists, point, pdf) = parts.lanes_sample_solid_angle(emitter, from, random, here);
            let exists = here & exists;
            left = here & !exists;
            self.point = EmitterPoint::select(exists, point, self.point);
            self.by_angle = self.by_angle | exists;
            self.pdf_angle = R::select(exists, pdf, self.pdf_angle);
        }
        if left.any() {
            let point = parts.lanes_sample_emitter(emitter, random, left);
            self.point = EmitterPoint::select(left, point, self.point);
        }
        let radiance = R::Vector::splat_vector(emitter.radiance);
        self.radiance = Vector::select(here, radiance, self.radiance);
        let pdf_area = R::splat(parts.emitter_pdf_area(emitter));
        self.pdf_area = R::select(here, pdf_area, self.pdf_area);
    }

    /// Returns the pdfs of the points with respect to solid angle, given cosines at the emitters
    /// and squared distances.
    #[inline]
    pub fn pdf<P: PathParts + ?Sized>(
        &self,
        parts: &P,
        cosine: R,
        distance_squared: R,
        active: R::Mask,
    ) -> R {
        let per_area =
            parts.lanes_solid_angle_per_area(cosine, distance_squared, active & !self.by_angle);
        R::select(self.by_angle, self.pdf_angle, self.pdf_area / per_area)
    }
}

/// A point on an emitter, as seen from another point.
#[derive(Clone, Copy)]
pub(super) struct LightView<R, const N: usize> {
    /// Index of the emitter.
    pub emitter: [usize; N],
    /// Cosine between the emitter's normal and the direction to the other point.
    pub cosine: R,
    pub distance_squared: R,
}

/// Returns the pdfs, with respect to solid angle, with which
/// [`sample_light`](super::direct_light::sample_light) at `from` picks these points.
#[inline]
pub(super) fn light_pdf<P: PathParts + ?Sized, R: Wide<N>, const N: usize>(
    parts: &P,
    scene: &Scene,
    lights: LightSampling,
    from: R::Vector,
    view: LightView<R, N>,
    active: R::Mask,
) -> R {
    let zero = R::splat(0.0);
    let probability: R = probability_of_pick(parts, scene, lights, from, view.emitter, active);
    let active = active & probability.cmpgt(zero);
    let per_area = parts.lanes_solid_angle_per_area(view.cosine, view.distance_squared, active);
    let mut pdf = R::splat(1.0) / per_area;
    for_each_distinct(view.emitter, active, |number, here: R::Mask| {
        let emitter = &scene.emitters()[number];
        let mut own = R::splat(parts.emitter_pdf_area(emitter)) / per_area;
        if lights.by_solid_angle(emitter) {
            let (exists, by_angle) = parts.lanes_pdf_solid_angle(emitter, from, here);
            own = R::select(exists, by_angle, own);
        }
        pdf = R::select(here, own, pdf);
    });
    // Behind an emitter the pdf is infinite, and the probability may be 0.
    R::select(
        active,
        parts.lanes_pdf_of_pick(pdf, probability, active),
        zero,
    )
}

/// Calls `number` once for each distinct number, with the lanes that have it.
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
