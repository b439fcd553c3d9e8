//! Points on emitters for the shadow rays of all lanes, and the pdfs with which they are picked. Flat emitters by solid
//! angle, and picks among very many emitters, are asked for lane by lane.

use std::array::from_fn;

use glam::DVec3;

use crate::emitter::{Emitter, EmitterPoint, EmitterShape, LightSampling};
use crate::estimator::{Standard, next_event};
use crate::light_pick;
use crate::real::{Lanes3, Real, Vector, Wide, WideMask, WideVector};
use crate::scene::Scene;
use crate::solid_angle::VisibleCap;

/// Points on emitters, as shadow rays from some points pick them.
pub(super) struct Picked<R: Real> {
    pub point: EmitterPoint<Lanes3<R>>,
    pub radiance: Lanes3<R>,
    pub pdf_area: R,
    /// Where the point was picked by solid angle, and its pdf with respect to that.
    by_angle: R::Mask,
    pdf_angle: R,
}

impl<R: Real<Vector = Lanes3<R>>> Picked<R> {
    /// In each lane of the mask a point on the emitter of this number, seen from a point.
    #[inline]
    pub fn new<const N: usize>(
        emitters: &[Emitter],
        lights: LightSampling,
        (numbers, asking): ([usize; N], R::Mask),
        from: Lanes3<R>,
        random: [R; 2],
    ) -> Self
    where
        R: Wide<N>,
    {
        let (zero, none) = (R::splat(0.0), Lanes3::splat_vector(DVec3::ZERO));
        let mut picked = Self {
            point: EmitterPoint { point: none, normal: none },
            radiance: none,
            pdf_area: zero,
            by_angle: R::Mask::splat(false),
            pdf_angle: zero,
        };
        each_of::<R, N>(numbers, asking, |number, here| {
            let emitter = &emitters[number];
            let mut point = emitter.sample(random);
            if lights.by_solid_angle(emitter) {
                let (seen, seen_point, pdf) = by_solid_angle(emitter, from, random);
                point.point = Vector::choose(seen, seen_point.point, point.point);
                point.normal = Vector::choose(seen, seen_point.normal, point.normal);
                picked.by_angle = picked.by_angle | here & seen;
                picked.pdf_angle = R::choose(here, pdf, picked.pdf_angle);
            }
            picked.point.point = Vector::choose(here, point.point, picked.point.point);
            picked.point.normal = Vector::choose(here, point.normal, picked.point.normal);
            picked.radiance = Vector::choose(here, Lanes3::splat_vector(emitter.radiance), picked.radiance);
            picked.pdf_area = R::choose(here, R::splat(emitter.pdf_area()), picked.pdf_area);
        });
        picked
    }

    /// The pdf on its emitter with respect to solid angle, where that of area stands for so much solid angle per area.
    #[inline]
    pub fn pdf(&self, per_area: R) -> R {
        R::choose(self.by_angle, self.pdf_angle, self.pdf_area / per_area)
    }
}

/// The pdf with which shadow rays from these points pick what was hit on emitters of these numbers, if one of them is
/// picked; see [`Picked::pdf`].
#[inline]
pub(super) fn pdf_of_hit<R: Wide<N>, const N: usize>(
    emitters: &[Emitter],
    lights: LightSampling,
    (numbers, hit): ([usize; N], R::Mask),
    from: Lanes3<R>,
    per_area: R,
) -> R {
    let mut found = R::splat(1.0) / per_area;
    each_of::<R, N>(numbers, hit, |number, here| {
        let emitter = &emitters[number];
        let mut pdf = R::splat(emitter.pdf_area()) / per_area;
        if lights.by_solid_angle(emitter) {
            let (seen, by_angle) = pdf_by_solid_angle(emitter, from);
            pdf = R::choose(seen, by_angle, pdf);
        }
        found = R::choose(here, pdf, found);
    });
    found
}

/// Which emitters shadow rays from the points of some lanes pick, and with what probability.
#[inline]
pub(super) fn pick_emitters<R: Wide<N>, const N: usize>(
    scene: &Scene,
    lights: LightSampling,
    (from, asking): (Lanes3<R>, R::Mask),
    r: R,
) -> ([usize; N], R) {
    let emitters = scene.emitters();
    let count = emitters.len();
    if !lights.by_contribution(count) || scene.light_groups().is_nested() {
        let one = |i| next_event::pick_from(&Standard, scene, lights, from.lane(i), r.lane(i));
        let each: [_; N] = from_fn(|i| if asking.bits() >> i & 1 == 1 { one(i) } else { (0, 1.0) });
        return (each.map(|(index, _)| index), R::from_lanes(|i| each[i].1));
    }
    let mut shares = [R::splat(0.0); light_pick::MOST];
    light_pick::share_all(|i| emitters[i].contribution(from), &mut shares[..count]);
    let (index, share) = light_pick::pick(&shares[..count], r);
    (index.whole().map(|index| index as usize), share)
}

/// The probabilities with which shadow rays from these points pick the emitters of these numbers, where they were hit.
#[inline]
pub(super) fn probability_of_pick<R: Wide<N>, const N: usize>(
    scene: &Scene,
    lights: LightSampling,
    (numbers, hit): ([usize; N], R::Mask),
    from: Lanes3<R>,
) -> R {
    let emitters = scene.emitters();
    let count = emitters.len();
    if count == 1 {
        return R::splat(1.0);
    }
    if !lights.by_contribution(count) || scene.light_groups().is_nested() {
        let one = |i: usize| next_event::probability_of_pick(&Standard, scene, lights, from.lane(i), numbers[i]);
        return R::from_lanes(|i| if hit.bits() >> i & 1 == 1 { one(i) } else { 1.0 });
    }
    let numbers = R::from_lanes(|i| numbers[i] as f64);
    light_pick::share(|i| emitters[i].contribution(from), count, numbers)
}

/// Hands over each of the numbers once, with the lanes that have it.
#[inline]
pub(super) fn each_of<R: Wide<N>, const N: usize>(
    numbers: [usize; N],
    lanes: R::Mask,
    mut number: impl FnMut(usize, R::Mask),
) {
    let mut left = lanes.bits();
    while left != 0 {
        let next = numbers[left.trailing_zeros() as usize];
        let here = R::Mask::from_bits(left) & R::Mask::from_fn(|i| numbers[i] == next);
        left &= !here.bits();
        number(next, here);
    }
}

/// From where an emitter can be sampled by solid angle, and the points and pdfs there.
#[inline]
fn by_solid_angle<R: Wide<N>, const N: usize>(
    emitter: &Emitter,
    from: Lanes3<R>,
    random: [R; 2],
) -> (R::Mask, EmitterPoint<Lanes3<R>>, R) {
    if let EmitterShape::Sphere(sphere) = emitter.shape
        && let Some((cap, seen)) = VisibleCap::of(from, &sphere)
    {
        let point = cap.sample(random);
        return (seen, EmitterPoint { point, normal: sphere.normal(point) }, cap.solid_angle.recip());
    }
    let seen: [Option<(EmitterPoint, f64)>; N] =
        from_fn(|i| emitter.sample_solid_angle(from.lane(i), random.map(|r| r.lane(i))));
    let point = |i: usize| seen[i].map_or(EmitterPoint { point: DVec3::ZERO, normal: DVec3::ZERO }, |(point, _)| point);
    (
        R::Mask::from_fn(|i| seen[i].is_some()),
        EmitterPoint { point: Lanes3::from_fn(|i| point(i).point), normal: Lanes3::from_fn(|i| point(i).normal) },
        R::from_lanes(|i| seen[i].map_or(0.0, |(_, pdf)| pdf)),
    )
}

/// The same pdfs of any point on it.
#[inline]
fn pdf_by_solid_angle<R: Wide<N>, const N: usize>(emitter: &Emitter, from: Lanes3<R>) -> (R::Mask, R) {
    if let EmitterShape::Sphere(sphere) = emitter.shape
        && let Some((cap, seen)) = VisibleCap::of(from, &sphere)
    {
        return (seen, cap.solid_angle.recip());
    }
    let pdf: [Option<f64>; N] = from_fn(|i| emitter.pdf_solid_angle(from.lane(i)));
    (R::Mask::from_fn(|i| pdf[i].is_some()), R::from_lanes(|i| pdf[i].unwrap_or(0.0)))
}
