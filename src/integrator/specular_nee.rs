//! Specular next-event estimation: light through one mirror or glass caster is found both by shadow
//! rays and by paths, weighted by multiple importance sampling.

use std::array::from_fn;

use glam::DVec3;

use super::lanewise::{Lanewise, each, numbers, visible};
use super::light_sampling::{LightNumbers, PickedPoint, for_each_distinct};
use super::{BsdfSample, PathParts, ShadingPoint, SurfaceInteraction};
use crate::geometry::radiometry;
use crate::geometry::shape::SurfacePoint;
use crate::geometry::specular_connection::{
    Caster, CasterKind, SpecularConnection, SphereConnections, geometry_term, mirror_connection,
};
use crate::light::emitter::LightSampling;
use crate::light::light_sampler;
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{Wide, lanes_of};
use crate::scene::lanes::{IntersectionScratch, LaneScene};
use crate::scene::specular_casters::{NO_CASTER, SpecularCaster};

/// A specular caster in each lane.
struct Casters<'a, R: Wide<N>, const N: usize> {
    /// All casters of the scene, and the index of the one in each lane.
    all: &'a [SpecularCaster],
    number: [usize; N],
    caster: Caster<R::Vector>,
    /// Lanes with flat mirrors, and lanes with glass that refracts.
    flat: R::Mask,
    refracts: R::Mask,
}

impl<'a, R: Wide<N>, const N: usize> Casters<'a, R, N> {
    /// Gathers the casters with these indices in the active lanes.
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
            selection_weight,
            inverse_ior,
            index,
            ..,
        ] = R::transpose(data.map(|caster| &caster.numbers));
        let [centre, normal, reflectance] = [[a, b, c], [d, e, f], [g, h, i]].map(Vector::of);
        let is = |kind| active & R::Mask::from_fn(|i| data[i].kind == kind);
        let caster = Caster {
            centre,
            radius,
            area,
            normal,
            inverse_ior,
            index,
            reflectance,
            selection_weight,
        };
        let (flat, refracts) = (is(CasterKind::Flat), is(CasterKind::Refraction));
        Self {
            all: scene.scene.specular_casters().all(),
            number,
            caster,
            flat,
            refracts,
        }
    }

    /// Returns the throughput of the casters where a connection meets them at this cosine, and the
    /// probability that a path samples that branch.
    #[inline]
    fn throughput<P: PathParts + ?Sized>(
        &self,
        parts: &P,
        cosine: R,
        active: R::Mask,
    ) -> (R::Vector, R) {
        if parts.is_default() {
            return self.caster.caster_throughput(cosine, self.refracts);
        }
        let each: [_; N] = each(active, (DVec3::ZERO, 0.0), |i| {
            parts.caster_throughput(&self.all[self.number[i]], cosine.lane(i))
        });
        (
            R::Vector::from_fn(|i| each[i].0),
            R::from_lanes(|i| each[i].1),
        )
    }

    /// Connects two points through flat mirrors; `None` if no lane has a connection.
    #[inline]
    fn mirror_connection(
        &self,
        x: R::Vector,
        y: R::Vector,
    ) -> Option<SpecularConnection<R::Vector>> {
        if !self.flat.any() {
            return None;
        }
        let mut connection = mirror_connection(&self.caster, x, y, self.flat);
        let mut on_mirror = R::Mask::splat(false);
        for_each_distinct(self.number, self.flat, |number, here| {
            on_mirror = on_mirror | (here & self.all[number].contains(connection.first.point));
        });
        connection.exists = connection.exists & on_mirror;
        connection.exists.any().then_some(connection)
    }

    /// Passes connections through the replaceable parts; `number` is a connection's index at its
    /// caster.
    #[inline]
    fn replaced<P: PathParts + ?Sized>(
        &self,
        parts: &P,
        number: impl Fn(usize) -> usize,
        connection: SpecularConnection<R::Vector>,
        active: R::Mask,
    ) -> SpecularConnection<R::Vector> {
        if parts.is_default() {
            return connection;
        }
        let each: [_; N] = each(active, None, |i| {
            parts.connection(&self.all[self.number[i]], number(i), connection.lane(i))
        });
        SpecularConnection::from_lanes(|i| each[i])
    }
}

/// Random numbers and limits of a specular shadow ray in each lane.
#[derive(Clone, Copy)]
pub(super) struct SpecularShadowRay<'a, R, const N: usize> {
    /// Uniform number that picks the caster.
    pub caster: R,
    /// Uniform numbers that pick the light.
    pub light: &'a LightNumbers<R>,
    /// Bounces that the limit still allows, if there is one; casters that need more are skipped.
    pub remaining_bounces: Option<[Option<u32>; N]>,
}

/// Traces one shadow ray through a specular caster from each active lane, all at non-delta
/// surfaces. Returns the sum over all connections of f_r L cos θ / p, each weighted by `weight` of
/// p and of the pdf with which BSDF sampling finds the same path. Both are with respect to solid
/// angle at the surface.
#[inline]
pub(super) fn specular_light<P: PathParts + ?Sized, R: Wide<N>, const N: usize>(
    parts: &P,
    scene: LaneScene<'_, R, N>,
    surface: &SurfaceInteraction<'_, R, N>,
    shadow_ray: SpecularShadowRay<'_, R, N>,
    weight: impl Fn(R, R, R::Mask) -> R,
    active: R::Mask,
    scratch: &mut IntersectionScratch<R, N>,
) -> R::Vector {
    let zero = R::splat(0.0);
    let mut sum = R::Vector::zero();
    let (emitters, flux) = (scene.scene.emitters(), scene.scene.power_light_sampler());
    let specular_casters = scene.scene.specular_casters();
    let vertex = &surface.vertex;
    let shares = specular_casters.selection_probabilities(vertex.point);
    let shares = &shares[..specular_casters.all().len()];
    let (number, share) = pick_caster(parts, shadow_ray.caster, shares, active);
    let mut active = active & share.cmpgt(zero);
    if let Some(remaining) = shadow_ray.remaining_bounces {
        active = active
            & R::Mask::from_fn(|i| {
                remaining[i] >= Some(specular_casters.all()[number[i]].kind.bounces())
            });
    }
    if !active.any() {
        return sum;
    }
    let casters = Casters::new(scene, number, active);
    let LightNumbers {
        pick,
        point: random,
    } = *shadow_ray.light;
    let emitter: [usize; N] = if emitters.len() == 1 {
        [0; N]
    } else {
        each(active, 0, |i| parts.pick_emitter(pick.lane(i), flux))
    };
    let area = LightSampling::Area;
    let picked = PickedPoint::new(parts, emitters, area, emitter, vertex.point, random, active);
    let light = &picked.point;
    let probability = R::from_lanes(|i| flux.probability(emitter[i]));
    let pdf_area = parts.lanes_pdf_of_pick(picked.pdf_area, probability, active);
    let pdf_area = parts.lanes_pdf_of_pick(pdf_area, share, active);
    let (x, y) = (vertex.point, light.point);
    let flat = casters.mirror_connection(x, y);
    let curved = active & !casters.flat;
    let spheres = curved
        .any()
        .then(|| SphereConnections::new(&casters.caster, x, y, curved, casters.refracts));
    let none = R::Mask::splat(false);
    let roots = spheres.as_ref().map(SphereConnections::roots);
    // Each lane takes its own next connection.
    let mut left = roots.map_or([none; 3], |roots| roots.map(|root| root.exists));
    let mut mirror_connection = flat.as_ref().map_or(none, |connection| connection.exists);
    loop {
        let first = left[0];
        let larger = left[1] & !first;
        let smaller = left[2] & !first & !larger;
        left = [none, left[1] & !larger, left[2] & !smaller];
        let curved = first | larger | smaller;
        let connection = match (&flat, &spheres, roots) {
            (Some(flat), ..) if !curved.any() => *flat,
            (flat, Some(spheres), Some(roots)) => {
                let mut root = roots[0].or(first, roots[1].or(larger, roots[2]));
                root.exists = root.exists & curved;
                let connection = spheres.connection(root, first);
                flat.map_or(connection, |flat| {
                    SpecularConnection::select(mirror_connection, flat, connection)
                })
            }
            _ => return sum,
        };
        let here = curved | mirror_connection;
        if !here.any() {
            return sum;
        }
        mirror_connection = none;
        let number = |i: usize| {
            if smaller.lane(i) {
                2
            } else {
                usize::from(larger.lane(i))
            }
        };
        let connection = casters.replaced(parts, number, connection, here & connection.exists);
        let here = here & connection.exists;
        let wi = vertex.frame.local(connection.direction);
        let brdf = surface.brdf(parts, wi, here);
        let cosine = parts.lanes_cosine(vertex.frame.z, connection.direction, here);
        let cosine_at_light = parts.lanes_cosine(light.normal, -connection.arriving, here);
        let mut free = here & cosine.cmpgt(zero) & cosine_at_light.cmpgt(zero) & !brdf.is_zero();
        let [enters, leaves, lamp] = [
            connection.first,
            connection.last,
            SurfacePoint::new(light.point, light.normal),
        ]
        .map(|end| scene.scene.ray_origin(end.point, end.normal));
        let segments = [
            (&surface.ray_origin(), &enters, free),
            (&enters, &leaves, casters.refracts),
            (&leaves, &lamp, free),
        ];
        // Occlusion tests suffice, and cost less than closest hits: the segments end an offset
        // before the caster and the light, and scenes refuse surfaces that lie nearer to them than
        // that (COINCIDENCE_TOLERANCE is four offsets).
        for (from, to, lanes) in segments {
            let asking = free & lanes;
            if asking.any() {
                free = free & (!asking | visible(parts, scene, from, to, false, asking, scratch));
            }
        }
        let pdf = pdf_area / (connection.geometry_term * cosine_at_light);
        let (throughput, branch_probability) = casters.throughput(parts, connection.cosine, free);
        let reflected = radiometry::reflected(brdf, picked.radiance * throughput, cosine, pdf);
        let weighted =
            reflected * weight(pdf, surface.pdf(parts, wi, free) * branch_probability, free);
        sum = sum + Vector::select(free, weighted, R::Vector::zero());
    }
}

/// Picks casters by selection probabilities; returns their indices and probabilities.
#[inline]
fn pick_caster<P: PathParts + ?Sized, R: Wide<N>, const N: usize>(
    parts: &P,
    random: R,
    shares: &[R],
    active: R::Mask,
) -> ([usize; N], R) {
    if parts.is_default() {
        let (number, share) = light_sampler::pick(shares, random);
        return (number.to_u32().map(|number| number as usize), share);
    }
    let pick = |i: usize| {
        let shares: Vec<f64> = shares.iter().map(|share| share.lane(i)).collect();
        parts.pick_by_probability(random.lane(i), &shares)
    };
    let each: [_; N] = each(active, (0, 0.0), pick);
    (each.map(|(number, _)| number), R::from_lanes(|i| each[i].1))
}

/// State of specular chains: where paths are since the last surface at which a shadow ray through a
/// caster could have found the same light.
pub(crate) struct SpecularChains<R: Wide<N>, const N: usize> {
    from: R::Vector,
    direction: R::Vector,
    /// Pdf of the direction with respect to solid angle.
    pdf: R,
    states: [Chain; N],
}

/// State of a path between a diffuse surface and a light behind one caster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Chain {
    /// No specular shadow ray finds what the path hits.
    NotConnectable,
    /// The path has hit nothing since the diffuse surface.
    AfterDiffuse,
    /// The path is inside the caster with this index.
    InsideCaster(u8),
    /// The path has left the caster with this index.
    PastCaster(u8),
}

/// A light that a path has hit, in each lane.
pub(super) struct LightHit<R: Real, const N: usize> {
    /// Index of the emitter.
    pub emitter: [usize; N],
    pub point: R::Vector,
    /// Cosine between the emitter's normal and the direction back along the path.
    pub cosine: R,
}

impl<R: Wide<N>, const N: usize> SpecularChains<R, N> {
    pub fn new() -> Self {
        let zero = R::Vector::zero();
        Self {
            from: zero,
            direction: zero,
            pdf: R::splat(0.0),
            states: [Chain::NotConnectable; N],
        }
    }

    /// Starts a path from the camera in a lane.
    pub fn start(&mut self, lane: usize) {
        self.states[lane] = Chain::NotConnectable;
    }

    /// Advances the chains by a scattering event in the active lanes.
    #[inline]
    pub fn advance(
        &mut self,
        surface: &SurfaceInteraction<'_, R, N>,
        sample: &BsdfSample<R>,
        active: R::Mask,
    ) {
        let fresh = active & sample.has_pdf;
        self.from = Vector::select(fresh, surface.vertex.point, self.from);
        self.direction = Vector::select(fresh, sample.direction, self.direction);
        self.pdf = R::select(fresh, sample.pdf, self.pdf);
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
            let vertex = &surface.vertex;
            let outside = vertex.outside.bits();
            let behind = vertex.frame.z.dot(sample.direction);
            let passes = behind.cmplt(R::splat(0.0)).bits();
            for lane in lanes_of(specular) {
                let bit = |bits: u32| bits >> lane & 1 == 1;
                self.states[lane] =
                    self.states[lane].after(surface.casters(lane), bit(outside), bit(passes));
            }
        }
    }

    /// Returns the active lanes whose hit on a light a specular shadow ray could have found, the
    /// pdf with which the path got there and that of the shadow ray, both with respect to solid
    /// angle where the path left the diffuse surface.
    #[inline]
    pub(super) fn pdfs<P: PathParts + ?Sized>(
        &self,
        parts: &P,
        scene: LaneScene<'_, R, N>,
        light: &LightHit<R, N>,
        active: R::Mask,
    ) -> (R::Mask, R, R) {
        let zero = R::splat(0.0);
        let caster = |i: usize| match self.states[i] {
            Chain::PastCaster(number) => Some(number),
            _ => None,
        };
        let past = active & R::Mask::from_fn(|i| caster(i).is_some());
        if !past.any() {
            return (past, zero, zero);
        }
        let number = from_fn(|i| caster(i).map_or(0, usize::from));
        let casters = Casters::new(scene, number, past);
        let (x, direction, y) = (self.from, self.direction, light.point);
        let [flat, sphere] = [CasterKind::Flat, CasterKind::Reflection]
            .map(|kind| geometry_term(&casters.caster, kind, x, direction, y));
        let geometry_term = R::select(casters.flat, flat.0, sphere.0);
        let cosine = R::select(casters.flat, flat.1, sphere.1);
        let (_, chance) = casters.throughput(parts, cosine, past);
        let share = scene
            .scene
            .specular_casters()
            .selection_probability(R::from_lanes(|i| number[i] as f64), self.from);
        let (emitters, flux) = (scene.scene.emitters(), scene.scene.power_light_sampler());
        let pdf_area = numbers(past, |i| {
            parts.emitter_pdf_area(&emitters[light.emitter[i]])
        });
        let probability = numbers(past, |i| flux.probability(light.emitter[i]));
        let pdf_area = parts.lanes_pdf_of_pick(pdf_area, probability, past);
        let other = parts.lanes_pdf_of_pick(pdf_area, share, past) / (geometry_term * light.cosine);
        (
            past,
            self.pdf * chance,
            R::select(geometry_term.cmpgt(zero), other, zero),
        )
    }
}

impl Chain {
    /// Returns the state after a mirror or glass surface, given its casters (by which it reflects
    /// and by which it refracts), whether it was hit from outside and whether the path passed
    /// through.
    #[inline]
    fn after(self, [reflecting, refracting]: [u8; 2], outside: bool, passes: bool) -> Self {
        match (self, outside, passes) {
            (Self::AfterDiffuse, true, false) if reflecting != NO_CASTER => {
                Self::PastCaster(reflecting)
            }
            (Self::AfterDiffuse, true, true) if refracting != NO_CASTER => {
                Self::InsideCaster(refracting)
            }
            (Self::InsideCaster(number), false, true) if number == refracting => {
                Self::PastCaster(number)
            }
            _ => Self::NotConnectable,
        }
    }
}
