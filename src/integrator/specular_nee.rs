//! Specular next-event estimation: light by way of one mirror or glass caster, which shadow rays
//! find and paths hit, both weighted.

use std::array::from_fn;

use glam::DVec3;

use super::lanewise::{Lanewise, numbers, visible};
use super::light_sampling::{LightNumbers, PickedPoint, for_each_distinct};
use super::{BsdfSample, ShadingPoint, SurfaceInteraction, Walking};
use crate::geometry::radiometry;
use crate::geometry::specular_connection::{Body, BySphere, Kind, Route, by_flat, spread_of};
use crate::light::emitter::LightSampling;
use crate::light::light_sampler;
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{Wide, lanes_of};
use crate::scene::lanes::{IntersectionScratch, LaneScene};
use crate::scene::specular_casters::{NONE, SceneBody};

/// A specular caster in each lane.
struct Casters<'a, R: Wide<N>, const N: usize> {
    /// All of the scene, and which of them is in each lane.
    all: &'a [SceneBody],
    number: [usize; N],
    body: Body<R::Vector>,
    /// The lanes of flat mirrors, and those of glass through which light passes.
    flat: R::Mask,
    refracts: R::Mask,
}

impl<'a, R: Wide<N>, const N: usize> Casters<'a, R, N> {
    /// The casters of these numbers in the active lanes.
    #[inline]
    fn new(scene: LaneScene<'a, R, N>, number: [usize; N], active: R::Mask) -> Self {
        let data = number.map(|number| &scene.data.casters[number]);
        let [
            a,
            b,
            c,
            d,
            e,
            f,
            g,
            h,
            i,
            radius,
            area,
            strength,
            bending,
            index,
            ..,
        ] = R::of_rows(data.map(|caster| &caster.numbers));
        let [centre, normal, reflectance] = [[a, b, c], [d, e, f], [g, h, i]].map(Vector::of);
        let is = |kind| active & R::Mask::from_fn(|i| data[i].kind == kind);
        let body = Body {
            centre,
            radius,
            area,
            normal,
            bending,
            index,
            reflectance,
            strength,
        };
        let (flat, refracts) = (is(Kind::Flat), is(Kind::Refraction));
        Self {
            all: scene.scene.bodies().all(),
            number,
            body,
            flat,
            refracts,
        }
    }

    /// Throughput of the casters where a connection meets them at this cosine, and the probability
    /// that a path samples that branch.
    #[inline]
    fn throughput<P: Walking>(&self, parts: &P, cosine: R, active: R::Mask) -> (R::Vector, R) {
        if parts.is_standard() {
            return self.body.lets_on(cosine, self.refracts);
        }
        let one = |i: usize| parts.lets_on(&self.all[self.number[i]], cosine.lane(i));
        let each: [_; N] = from_fn(|i| {
            if active.lane(i) {
                one(i)
            } else {
                (DVec3::ZERO, 0.0)
            }
        });
        (
            R::Vector::from_fn(|i| each[i].0),
            R::from_lanes(|i| each[i].1),
        )
    }

    /// The connections by way of flat mirrors between two points; `None` if there is none.
    #[inline]
    fn by_flat(&self, ends: (R::Vector, R::Vector)) -> Option<Route<R::Vector>> {
        if !self.flat.any() {
            return None;
        }
        let mut route = by_flat(&self.body, ends, self.flat);
        let mut held = R::Mask::splat(false);
        for_each_distinct(self.number, self.flat, |number, here| {
            held = held | (here & self.all[number].holds(route.first.0));
        });
        route.exists = route.exists & held;
        route.exists.any().then_some(route)
    }

    /// The connections that the parts make of these, each by its number among those of its caster.
    #[inline]
    fn replaced<P: Walking>(
        &self,
        parts: &P,
        number: impl Fn(usize) -> usize,
        route: Route<R::Vector>,
        active: R::Mask,
    ) -> Route<R::Vector> {
        if parts.is_standard() {
            return route;
        }
        let one = |i: usize| parts.route(&self.all[self.number[i]], number(i), route.lane(i));
        let each: [_; N] = from_fn(|i| if active.lane(i) { one(i) } else { None });
        Route::from_lanes(|i| each[i])
    }
}

/// A shadow ray by way of a caster, in each lane.
#[derive(Clone, Copy)]
pub(super) struct SpecularShadowRay<'a, R, const N: usize> {
    /// The number that picks the caster.
    pub caster: R,
    /// Those that pick the light.
    pub light: &'a LightNumbers<R>,
    /// Casters that scatter light more often than this are passed over.
    pub remaining_bounces: Option<[Option<u32>; N]>,
}

/// Light by one shadow ray by way of a caster from each active lane, whose surfaces all scatter in
/// all directions: over all connections the sum of f_r L cos θ / p, each weighted by `weight` of p
/// and of the pdf with which a path goes there. Both are with respect to solid angle at the
/// surface.
#[inline]
pub(super) fn specular_light<P: Walking, R: Wide<N>, const N: usize>(
    parts: &P,
    scene: LaneScene<'_, R, N>,
    surface: &SurfaceInteraction<'_, R, N>,
    shadow_ray: SpecularShadowRay<'_, R, N>,
    weight: impl Fn(R, R, R::Mask) -> R,
    active: R::Mask,
    scratch: &mut IntersectionScratch<R, N>,
) -> R::Vector {
    let zero = R::splat(0.0);
    let mut sum = R::Vector::splat_vector(DVec3::ZERO);
    let (emitters, bodies, flux) = (
        scene.scene.emitters(),
        scene.scene.bodies(),
        scene.scene.flux_picks(),
    );
    let vertex = &surface.vertex;
    let shares = bodies.shares(vertex.point);
    let shares = &shares[..bodies.all().len()];
    let (number, share) = pick_caster(parts, shadow_ray.caster, shares, active);
    let mut active = active & share.above(zero);
    if let Some(remaining) = shadow_ray.remaining_bounces {
        active = active
            & R::Mask::from_fn(|i| remaining[i] >= Some(bodies.all()[number[i]].kind.bounces()));
    }
    if !active.any() {
        return sum;
    }
    let casters = Casters::new(scene, number, active);
    let LightNumbers {
        pick,
        point: random,
    } = *shadow_ray.light;
    let pick = |i: usize| {
        if active.lane(i) {
            parts.pick_emitter(pick.lane(i), flux)
        } else {
            0
        }
    };
    let emitter: [usize; N] = if emitters.len() == 1 {
        [0; N]
    } else {
        from_fn(pick)
    };
    let area = LightSampling::Area;
    let picked = PickedPoint::new(parts, emitters, area, emitter, vertex.point, random, active);
    let light = &picked.point;
    let probability = R::from_lanes(|i| flux.probability(emitter[i]));
    let pdf_area = parts.lanes_pdf_of_pick(picked.pdf_area, probability, active);
    let pdf_area = parts.lanes_pdf_of_pick(pdf_area, share, active);
    let ends = (vertex.point, light.point);
    let flat = casters.by_flat(ends);
    let curved = active & !casters.flat;
    let balls = curved
        .any()
        .then(|| BySphere::new(&casters.body, ends, (curved, casters.refracts)));
    let none = R::Mask::splat(false);
    let roots = balls.as_ref().map(BySphere::roots);
    // Each lane takes its own next connection.
    let mut left = roots.map_or([none; 3], |roots| roots.map(|root| root.exists));
    let mut by_flat = flat.as_ref().map_or(none, |route| route.exists);
    loop {
        let first = left[0];
        let larger = left[1] & !first;
        let smaller = left[2] & !first & !larger;
        left = [none, left[1] & !larger, left[2] & !smaller];
        let curved = first | larger | smaller;
        let route = match (&flat, &balls, roots) {
            (Some(flat), ..) if !curved.any() => *flat,
            (flat, Some(balls), Some(roots)) => {
                let mut root = roots[0].or(first, roots[1].or(larger, roots[2]));
                root.exists = root.exists & curved;
                let route = balls.route(root, first);
                flat.map_or(route, |flat| Route::choose(by_flat, flat, route))
            }
            _ => return sum,
        };
        let here = curved | by_flat;
        if !here.any() {
            return sum;
        }
        by_flat = none;
        let number = |i: usize| {
            if smaller.lane(i) {
                2
            } else {
                usize::from(larger.lane(i))
            }
        };
        let route = casters.replaced(parts, number, route, here & route.exists);
        let here = here & route.exists;
        let wi = vertex.frame.local(route.direction);
        let brdf = surface.brdf(parts, wi, here);
        let cosine = parts.lanes_cosine(vertex.frame.z, route.direction, here);
        let cosine_at_light = parts.lanes_cosine(light.normal, -route.arriving, here);
        let [r, g, b] = brdf.components();
        let dark = r.equals(zero) & g.equals(zero) & b.equals(zero);
        let mut free = here & cosine.above(zero) & cosine_at_light.above(zero) & !dark;
        let [enters, leaves, lamp] = [route.first, route.last, (light.point, light.normal)]
            .map(|(point, normal)| scene.scene.place(point, normal));
        let segments = [
            (&surface.place(), &enters, free),
            (&enters, &leaves, casters.refracts),
            (&leaves, &lamp, free),
        ];
        for (from, to, lanes) in segments {
            let asking = free & lanes;
            if asking.any() {
                free = free & (!asking | visible(parts, scene, from, to, false, asking, scratch));
            }
        }
        let pdf = pdf_area / (route.spread * cosine_at_light);
        let (throughput, chance) = casters.throughput(parts, route.cosine, free);
        let reflected = radiometry::reflected(brdf, picked.radiance * throughput, cosine, pdf);
        let weighted = reflected * weight(pdf, surface.pdf(parts, wi, free) * chance, free);
        sum = sum + Vector::choose(free, weighted, R::Vector::splat_vector(DVec3::ZERO));
    }
}

/// The numbers of the casters that uniform numbers pick by shares, and their shares.
#[inline]
fn pick_caster<P: Walking, R: Wide<N>, const N: usize>(
    parts: &P,
    random: R,
    shares: &[R],
    active: R::Mask,
) -> ([usize; N], R) {
    if parts.is_standard() {
        let (number, share) = light_sampler::pick(shares, random);
        return (number.whole().map(|number| number as usize), share);
    }
    let pick = |i: usize| {
        let shares: Vec<f64> = shares.iter().map(|share| share.lane(i)).collect();
        parts.pick_by_share(random.lane(i), &shares)
    };
    let each: [_; N] = from_fn(|i| if active.lane(i) { pick(i) } else { (0, 0.0) });
    (each.map(|(number, _)| number), R::from_lanes(|i| each[i].1))
}

/// Where the paths have gone since they left a surface from which a shadow ray by way of a caster
/// could have found the same light.
pub(crate) struct SpecularChains<R: Wide<N>, const N: usize> {
    from: R::Vector,
    direction: R::Vector,
    /// The pdf of the direction with respect to solid angle.
    pdf: R,
    states: [Chain; N],
}

/// Where a path is on the way from a surface to a light by way of one caster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Chain {
    /// No shadow ray by way of a caster finds what it hits.
    NotConnectable,
    /// It has met nothing since it left the surface.
    AfterDiffuse,
    /// It is within the caster of this number.
    InsideCaster(u8),
    /// It has left the caster of this number.
    PastCaster(u8),
}

/// A light that paths have hit, in each lane.
pub(super) struct LightHit<R: Real, const N: usize> {
    /// Its number among the emitters.
    pub emitter: [usize; N],
    pub point: R::Vector,
    /// The cosine there between its normal and the direction back.
    pub cosine: R,
}

impl<R: Wide<N>, const N: usize> SpecularChains<R, N> {
    pub fn new() -> Self {
        let zero = R::Vector::splat_vector(DVec3::ZERO);
        Self {
            from: zero,
            direction: zero,
            pdf: R::splat(0.0),
            states: [Chain::NotConnectable; N],
        }
    }

    /// Begins a path from the camera in a lane.
    pub fn start(&mut self, lane: usize) {
        self.states[lane] = Chain::NotConnectable;
    }

    /// Goes on from surfaces in the active lanes.
    #[inline]
    pub fn advance(
        &mut self,
        surface: &SurfaceInteraction<'_, R, N>,
        sample: &BsdfSample<R>,
        active: R::Mask,
    ) {
        let fresh = active & sample.has_pdf;
        self.from = Vector::choose(fresh, surface.vertex.point, self.from);
        self.direction = Vector::choose(fresh, sample.direction, self.direction);
        self.pdf = R::choose(fresh, sample.pdf, self.pdf);
        let rough_glass = surface.rough_glass().bits();
        for lane in lanes_of(fresh.bits()) {
            let is_rough_glass = rough_glass >> lane & 1 == 1;
            self.states[lane] = if is_rough_glass {
                Chain::NotConnectable
            } else {
                Chain::AfterDiffuse
            };
        }
        let specular = (active & !sample.has_pdf).bits();
        if specular != 0 {
            let outside = surface.vertex.outside.bits();
            let passes = surface
                .vertex
                .frame
                .z
                .dot(sample.direction)
                .below(R::splat(0.0))
                .bits();
            for lane in lanes_of(specular) {
                let bit = |bits: u32| bits >> lane & 1 == 1;
                self.states[lane] =
                    self.states[lane].after(surface.casters(lane), bit(outside), bit(passes));
            }
        }
    }

    /// Where hits on lights, among the active lanes, could have been found by way of a caster, the
    /// pdf with which the path came there and that with which a shadow ray does, both with respect
    /// to solid angle where the path left.
    #[inline]
    pub(super) fn pdfs<P: Walking>(
        &self,
        parts: &P,
        scene: LaneScene<'_, R, N>,
        light: &LightHit<R, N>,
        active: R::Mask,
    ) -> (R::Mask, R, R) {
        let zero = R::splat(0.0);
        let caster = |i: usize| {
            if let Chain::PastCaster(number) = self.states[i] {
                Some(number)
            } else {
                None
            }
        };
        let past = active & R::Mask::from_fn(|i| caster(i).is_some());
        if !past.any() {
            return (past, zero, zero);
        }
        let number = from_fn(|i| caster(i).map_or(0, usize::from));
        let casters = Casters::new(scene, number, past);
        let along = (self.from, self.direction, light.point);
        let (flat, sphere) = (
            spread_of(&casters.body, Kind::Flat, along),
            spread_of(&casters.body, Kind::Reflection, along),
        );
        let spread = R::choose(casters.flat, flat.0, sphere.0);
        let cosine = R::choose(casters.flat, flat.1, sphere.1);
        let (_, chance) = casters.throughput(parts, cosine, past);
        let share = scene
            .scene
            .bodies()
            .share_of(R::from_lanes(|i| number[i] as f64), self.from);
        let (emitters, flux) = (scene.scene.emitters(), scene.scene.flux_picks());
        let pdf_area = numbers(past, |i| {
            parts.emitter_pdf_area(&emitters[light.emitter[i]])
        });
        let probability = numbers(past, |i| flux.probability(light.emitter[i]));
        let pdf_area = parts.lanes_pdf_of_pick(pdf_area, probability, past);
        let other = parts.lanes_pdf_of_pick(pdf_area, share, past) / (spread * light.cosine);
        (
            past,
            self.pdf * chance,
            R::choose(spread.above(zero), other, zero),
        )
    }
}

impl Chain {
    /// The state after a mirror or glass that was met from outside or not, and passed or not; of
    /// its casters the first is that which reflects, the second that which refracts.
    #[inline]
    fn after(self, [reflecting, refracting]: [u8; 2], outside: bool, passes: bool) -> Self {
        match (self, outside, passes) {
            (Self::AfterDiffuse, true, false) if reflecting != NONE => Self::PastCaster(reflecting),
            (Self::AfterDiffuse, true, true) if refracting != NONE => {
                Self::InsideCaster(refracting)
            }
            (Self::InsideCaster(number), false, true) if number == refracting => {
                Self::PastCaster(number)
            }
            _ => Self::NotConnectable,
        }
    }
}
