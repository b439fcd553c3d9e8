//! Light by way of one mirror or glass body for all lanes, as [`crate::estimator::specular`] has it.

use std::array::from_fn;

use glam::DVec3;

use super::lights::{Picked, each_of};
use super::row::lanes_of;
use super::scene::{LaneScene, Seen};
use super::shading::{LightNumbers, Onward, Surfaces};
use crate::emitter::LightSampling;
use crate::estimator::specular::Stage;
use crate::real::{Lanes3, Mask, Row, Scalar, Vector, Wide, WideMask};
use crate::specular::{Body, BySphere, Kind, NONE, Route, by_flat, spread_of};
use crate::{light_pick, radiometry};

/// What lanes need of a body.
pub(super) struct BodyData<T> {
    kind: Kind,
    numbers: Row<T, 16>,
}

impl<T: Scalar> BodyData<T> {
    pub fn new(kind: Kind, body: &Body<DVec3>) -> Self {
        let [a, b, c] = [body.centre, body.normal, body.reflectance].map(|v| v.to_array());
        let numbers = [a, b, c, [body.radius, body.area, body.strength], [body.bending, body.index, 0.0], [0.0; 3]];
        Self { kind, numbers: Row(from_fn(|i| T::rounded(numbers[i / 3][i % 3]))) }
    }
}

/// Bodies of these numbers, and in which of the `active` lanes they are flat and refract.
#[inline]
fn gather<R: Wide<N>, const N: usize>(
    scene: &LaneScene<'_, R, N>,
    (numbers, active): ([usize; N], R::Mask),
) -> (Body<Lanes3<R>>, R::Mask, R::Mask) {
    let data = numbers.map(|number| &scene.bodies[number]);
    let [a, b, c, d, e, f, g, h, i, radius, area, strength, bending, index, ..] =
        R::of_rows(data.map(|body| &body.numbers));
    let [centre, normal, reflectance] = [[a, b, c], [d, e, f], [g, h, i]].map(Lanes3::of);
    let is = |kind| active & R::Mask::from_fn(|i| data[i].kind == kind);
    let body = Body { centre, radius, area, normal, bending, index, reflectance, strength };
    (body, is(Kind::Flat), is(Kind::Refraction))
}

impl<R: Wide<N>, const N: usize> Surfaces<'_, R, N> {
    /// The routes by way of flat mirrors of these numbers in the lanes of the mask; `None` if there is none.
    #[inline]
    fn by_flat(
        &self,
        scene: &LaneScene<'_, R, N>,
        body: &Body<Lanes3<R>>,
        (of_body, flat): ([usize; N], R::Mask),
        ends: (Lanes3<R>, Lanes3<R>),
    ) -> Option<Route<Lanes3<R>>> {
        let mut route = by_flat(body, ends, flat);
        let mut held = R::Mask::splat(false);
        each_of::<R, N>(of_body, flat, |number, here| {
            held = held | (here & scene.scene.bodies().all()[number].holds(route.first.0));
        });
        route.exists = route.exists & held;
        route.exists.any().then_some(route)
    }

    /// Light by one shadow ray by way of a body from each lane of the mask, all of which are rough; weighted. Bodies that
    /// scatter light more often than `most` says, if it does, are passed over.
    #[inline]
    pub fn light_by_body(
        &self,
        scene: &LaneScene<'_, R, N>,
        asking: R::Mask,
        (body, numbers, most): (R, &LightNumbers<R>, Option<[Option<u32>; N]>),
        weight: impl Fn(R, R) -> R,
        seen: &mut Seen<R, N>,
    ) -> Lanes3<R> {
        let zero = R::splat(0.0);
        let mut sum = Lanes3::splat_vector(DVec3::ZERO);
        let (emitters, bodies, flux) = (scene.scene.emitters(), scene.scene.bodies(), scene.scene.flux_picks());
        let vertex = &self.vertex;
        let shares = bodies.shares(vertex.point);
        let (number, share) = light_pick::pick(&shares[..bodies.all().len()], body);
        let of_body = number.whole().map(|number| number as usize);
        let mut asking = asking & share.above(zero);
        if let Some(most) = most {
            let goes = |i: usize| most[i] >= Some(scene.bodies[of_body[i]].kind.bounces());
            asking = asking & R::Mask::from_fn(goes);
        }
        if !asking.any() {
            return sum;
        }
        let (body, flat, refracts) = gather(scene, (of_body, asking));
        let indices = if emitters.len() == 1 { [0; N] } else { from_fn(|i| flux.pick(numbers.pick.lane(i))) };
        let probability = R::from_lanes(|i| flux.probability(indices[i]));
        let picked = Picked::new(emitters, LightSampling::Area, (indices, asking), vertex.point, numbers.point);
        let light = &picked.point;
        let pdf_area = picked.pdf_area * probability * share;
        let ends = (vertex.point, light.point);
        let reflected = if flat.any() { self.by_flat(scene, &body, (of_body, flat), ends) } else { None };
        let curved = asking & !flat;
        let balls = if curved.any() { Some(BySphere::new(&body, ends, (curved, refracts))) } else { None };
        let none = R::Mask::splat(false);
        let roots = balls.as_ref().map(BySphere::roots);
        // Each lane takes its own next route.
        let mut left = roots.map_or([none; 3], |roots| roots.map(|root| root.exists));
        let mut flat = reflected.as_ref().map_or(none, |route| route.exists);
        loop {
            let first = left[0];
            let larger = left[1] & !first;
            let smaller = left[2] & !first & !larger;
            left = [none, left[1] & !larger, left[2] & !smaller];
            let curved = first | larger | smaller;
            let route = match (&reflected, &balls, roots) {
                (Some(flat), ..) if !curved.any() => *flat,
                (reflected, Some(balls), Some(roots)) => {
                    let mut root = roots[0].or(first, roots[1].or(larger, roots[2]));
                    root.exists = root.exists & curved;
                    let route = balls.route(root, first);
                    reflected.map_or(route, |reflected| Route::choose(flat, reflected, route))
                }
                _ => return sum,
            };
            if !(curved | flat).any() {
                return sum;
            }
            let taken = flat;
            flat = none;
            let wi = vertex.frame.local(route.direction);
            let brdf = self.brdf(wi);
            let cosine = radiometry::cosine(vertex.frame.z, route.direction);
            let cosine_at_light = radiometry::cosine(light.normal, -route.arriving);
            let dark = brdf.x.equals(zero) & brdf.y.equals(zero) & brdf.z.equals(zero);
            let mut free = (curved | taken) & route.exists & cosine.above(zero) & cosine_at_light.above(zero) & !dark;
            let [first, last, light] = [route.first, route.last, (light.point, light.normal)]
                .map(|(point, normal)| scene.scene.place(point, normal));
            let pieces = [(self.place(), first, free), (first, last, refracts), (last, light, free)];
            for (from, to, lanes) in pieces {
                let asking = free & lanes;
                if asking.any() {
                    free = free & (!asking | scene.visible(&from, &to, false, asking, seen));
                }
            }
            let pdf = pdf_area / (route.spread * cosine_at_light);
            let (passed, chance) = body.lets_on(route.cosine, refracts);
            let reflected = radiometry::reflected(brdf, picked.radiance * passed, cosine, pdf);
            let weighted = reflected * weight(pdf, self.pdf(wi) * chance);
            sum = sum + Vector::choose(free, weighted, Lanes3::splat_vector(DVec3::ZERO));
        }
    }
}

/// Where the paths have gone since they left a vertex from which a shadow ray by way of a body could have found the same
/// light.
pub(super) struct Trails<R: Wide<N>, const N: usize> {
    from: Lanes3<R>,
    direction: Lanes3<R>,
    pdf: R,
    stages: [Stage; N],
}

impl<R: Wide<N>, const N: usize> Trails<R, N> {
    pub fn new() -> Self {
        let zero = Lanes3::splat_vector(DVec3::ZERO);
        Self { from: zero, direction: zero, pdf: R::splat(0.0), stages: [Stage::Lost; N] }
    }

    /// Begins a path from the camera in a lane.
    pub fn start(&mut self, lane: usize) {
        self.stages[lane] = Stage::Lost;
    }

    /// Goes on from surfaces in the lanes of the mask.
    #[inline]
    pub fn go_on(&mut self, surfaces: &Surfaces<'_, R, N>, next: &Onward<R>, on: R::Mask) {
        let fresh = on & next.has_pdf;
        self.from = Vector::choose(fresh, surfaces.vertex.point, self.from);
        self.direction = Vector::choose(fresh, next.direction, self.direction);
        self.pdf = R::choose(fresh, next.pdf, self.pdf);
        lanes_of(fresh.bits()).for_each(|lane| self.stages[lane] = Stage::Fresh);
        let specular = (on & !next.has_pdf).bits();
        if specular != 0 {
            let outside = surfaces.vertex.outside.bits();
            let passes = surfaces.vertex.frame.z.dot(next.direction).below(R::splat(0.0)).bits();
            for lane in lanes_of(specular) {
                let bit = |bits: u32| bits >> lane & 1 == 1;
                self.stages[lane] = self.stages[lane].next((surfaces.bodies(lane), bit(outside), bit(passes)));
            }
        }
    }

    /// Where hits on emitters of these numbers, among the `hit`, could have been found by way of a body, the pdf with which
    /// the path came there and that with which a shadow ray does.
    #[inline]
    pub fn pdfs(
        &self,
        scene: &LaneScene<'_, R, N>,
        (numbers, hit): ([usize; N], R::Mask),
        (point, cosine_at_light): (Lanes3<R>, R),
    ) -> (R::Mask, R, R) {
        let zero = R::splat(0.0);
        let of = |stage| if let Stage::Behind(number) = stage { number } else { NONE };
        let behind = hit & R::Mask::from_fn(|i| of(self.stages[i]) != NONE);
        if !behind.any() {
            return (behind, zero, zero);
        }
        let of_body = self.stages.map(|stage| if of(stage) == NONE { 0 } else { usize::from(of(stage)) });
        let (body, flat, refracts) = gather(scene, (of_body, behind));
        let along = (self.from, self.direction, point);
        let (of_flat, of_sphere) = (spread_of(&body, Kind::Flat, along), spread_of(&body, Kind::Reflection, along));
        let spread = R::choose(flat, of_flat.0, of_sphere.0);
        let (_, chance) = body.lets_on(R::choose(flat, of_flat.1, of_sphere.1), refracts);
        let share = scene.scene.bodies().share_of(R::from_lanes(|i| of_body[i] as f64), self.from);
        let (emitters, flux) = (scene.scene.emitters(), scene.scene.flux_picks());
        let pdf_area = R::from_lanes(|i| emitters[numbers[i]].pdf_area());
        let probability = R::from_lanes(|i| flux.probability(numbers[i]));
        let other = pdf_area * probability * share / (spread * cosine_at_light);
        (behind, self.pdf * chance, R::choose(spread.above(zero), other, zero))
    }
}
