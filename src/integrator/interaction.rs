//! Surface interactions of all lanes: hit points, normals, material data and BSDF evaluation. Rare
//! models (EON, rough glass, user-defined models) are evaluated lane by lane.

use glam::DVec3;

use super::lanewise::{Lanewise, numbers, vectors};
use super::{PathParts, TransportRules};
use crate::error::Error;
use crate::film::{Features, Pixel, features, is_valid_depth};
use crate::geometry::bvh::PacketHit;
use crate::geometry::offsets::{RayOrigin, inner_point};
use crate::geometry::shape::{Hit, Ray, outward};
use crate::material::{Bsdf, OrenNayar, OrenNayarForm, Vertex, fresnel, lambert, oren_nayar};
use crate::math::real::{Mask, Real, Vector};
use crate::math::simd::{Wide, map_array};
use crate::sampling::warp;
use crate::scene::Scene;
use crate::scene::lanes::material::{
    EMITTER, GLASS, MIRROR, NON_DELTA, NOT_COSINE_SAMPLED, PER_LANE, PRINTED, ROUGH_GLASS, SPHERE,
};
use crate::scene::lanes::{LaneScene, PrimitiveData};

/// Shading points of shadow rays, one per lane.
pub(crate) trait ShadingPoint<R: Real> {
    /// Returns the shading vertices: points, frames and directions of the rays that arrived.
    fn vertex(&self) -> &Vertex<R::Vector>;
    /// Returns the points, normals and offsets from which shadow rays start.
    fn ray_origin(&self) -> RayOrigin<R::Vector>;
    /// Evaluates f_r in the active lanes, 1/sr.
    fn brdf<P: PathParts + ?Sized>(&self, parts: &P, wi: R::Vector, active: R::Mask) -> R::Vector;
    /// Returns the lanes whose surface is rough glass.
    fn rough_glass(&self) -> R::Mask;
    /// Returns the radiance factor of refraction at rough glass in a lane, for light from the local
    /// direction `wi`.
    fn radiance_factor<P: PathParts + ?Sized>(&self, parts: &P, wi: DVec3, lane: usize) -> f64;

    /// Returns the cosine between the normal and a direction towards light. Rough glass also
    /// accepts light from behind.
    #[inline]
    fn cosine<P: PathParts + ?Sized>(&self, parts: &P, direction: R::Vector, active: R::Mask) -> R {
        let (normal, rough_glass) = (self.vertex().frame.z, self.rough_glass());
        if !rough_glass.any() {
            return parts.lanes_cosine(normal, direction, active);
        }
        let behind = rough_glass & normal.dot(direction).cmplt(R::splat(0.0));
        parts.lanes_cosine(Vector::select(behind, -normal, normal), direction, active)
    }

    /// Converts light from `wi` to radiance on the side of the ray: refraction at rough glass
    /// scales it.
    #[inline]
    fn to_radiance<P: PathParts + ?Sized>(
        &self,
        parts: &P,
        light: R::Vector,
        wi: R::Vector,
        active: R::Mask,
    ) -> R::Vector {
        let rough_glass = active & self.rough_glass();
        if !rough_glass.any() {
            return light;
        }
        let factor = |i: usize| self.radiance_factor(parts, wi.lane(i), i);
        light * R::from_lanes(|i| if rough_glass.lane(i) { factor(i) } else { 1.0 })
    }
}

/// BSDF and vertex of a single ray.
pub(crate) struct ScalarShadingPoint<'a> {
    pub scene: &'a Scene,
    pub bsdf: &'a Bsdf,
    pub vertex: &'a Vertex,
}

impl ShadingPoint<f64> for ScalarShadingPoint<'_> {
    #[inline]
    fn vertex(&self) -> &Vertex {
        self.vertex
    }
    #[inline]
    fn ray_origin(&self) -> RayOrigin<DVec3> {
        self.scene
            .ray_origin(self.vertex.point, self.vertex.frame.z)
    }
    #[inline]
    fn brdf<P: PathParts + ?Sized>(&self, parts: &P, wi: DVec3, active: bool) -> DVec3 {
        if active {
            parts.brdf(self.bsdf, self.vertex.wo, wi)
        } else {
            DVec3::ZERO
        }
    }
    #[inline]
    fn rough_glass(&self) -> bool {
        self.bsdf.is_rough_glass()
    }
    #[inline]
    fn radiance_factor<P: PathParts + ?Sized>(&self, parts: &P, wi: DVec3, _: usize) -> f64 {
        parts.radiance_factor_from(&self.bsdf.oriented(self.vertex.outside), wi)
    }
}

/// Surface interaction of each lane; undefined in lanes whose rays have hit nothing.
pub(crate) struct SurfaceInteraction<'a, R: Wide<N>, const N: usize> {
    primitives: [&'a PrimitiveData<R::Scalar>; N],
    scene: &'a Scene,
    /// Hit points, shading frames and directions of the rays that arrived.
    pub vertex: Vertex<R::Vector>,
    /// Unit normals of the surfaces' own fronts.
    pub normal: R::Vector,
    /// Distance above the surfaces at which spawned rays start.
    offset: R,
    /// Distances along the rays.
    pub t: R,
    /// Lanes whose surface is an emitter.
    pub emits: R::Mask,
    /// Lanes whose BSDF is not a Dirac distribution.
    pub non_delta: R::Mask,
    pub(super) mirror: R::Mask,
    pub(super) glass: R::Mask,
    hit_mask: R::Mask,
    /// Albedo, or the reflectance of a mirror.
    pub(super) colour: R::Vector,
    pub absorption: R,
    pub(super) index: R,
    oren_nayar: OrenNayar<R>,
    /// Kinds of the primitives, and the union of those of all primitives in the scene.
    kinds: [u16; N],
    scene_kinds: u16,
}

impl<R: Wide<N>, const N: usize> ShadingPoint<R> for SurfaceInteraction<'_, R, N> {
    #[inline]
    fn vertex(&self) -> &Vertex<R::Vector> {
        &self.vertex
    }

    #[inline]
    fn ray_origin(&self) -> RayOrigin<R::Vector> {
        RayOrigin {
            point: self.vertex.point,
            normal: self.vertex.frame.z,
            offset: self.offset,
        }
    }

    #[inline(always)]
    fn brdf<P: PathParts + ?Sized>(&self, parts: &P, wi: R::Vector, active: R::Mask) -> R::Vector {
        let (zero, wo) = (R::splat(0.0), self.vertex.wo);
        if !parts.is_default() {
            return vectors(active, |i| {
                parts.brdf(&self.bsdf(i), wo.lane(i), wi.lane(i))
            });
        }
        let mut bracket = oren_nayar(self.oren_nayar, OrenNayarForm::Corrected, wo, wi);
        let is_printed = self.is(PRINTED);
        if is_printed.any() {
            let printed = oren_nayar(self.oren_nayar, OrenNayarForm::Printed, wo, wi);
            bracket = R::select(is_printed, printed, bracket);
        }
        let above = wo.z().cmpgt(zero) & wi.z().cmpgt(zero);
        let none = R::Vector::zero();
        let brdf = Vector::select(above & self.non_delta, lambert(self.colour) * bracket, none);
        let per_lane = self.is(PER_LANE);
        if !per_lane.any() {
            return brdf;
        }
        let alone = |i: usize| self.bsdf(i).eval(wo.lane(i), wi.lane(i));
        Vector::from_fn(|i| {
            if per_lane.lane(i) {
                alone(i)
            } else {
                brdf.lane(i)
            }
        })
    }

    #[inline]
    fn rough_glass(&self) -> R::Mask {
        self.is(ROUGH_GLASS)
    }

    #[inline]
    fn radiance_factor<P: PathParts + ?Sized>(&self, parts: &P, wi: DVec3, lane: usize) -> f64 {
        parts.radiance_factor_from(&self.bsdf(lane), wi)
    }
}

impl<'a, R: Wide<N>, const N: usize> SurfaceInteraction<'a, R, N> {
    /// Computes the surface interactions of hits; the scene has at least one primitive.
    #[inline(always)]
    pub fn new(lanes: LaneScene<'a, R, N>, ray: &Ray<R::Vector>, found: &PacketHit<R, N>) -> Self {
        let primitives = map_array(found.primitive, |primitive| lanes.primitive(primitive));
        let [
            shape @ ..,
            red,
            green,
            blue,
            index,
            a,
            b,
            absorption,
            offset,
            _,
            _,
            _,
        ] = R::transpose(map_array(primitives, |primitive| &primitive.numbers));
        let kinds = map_array(primitives, |primitive| primitive.kinds);
        let is = |kind| of_kind(&kinds, lanes.data.kinds, kind, found.hit_mask);
        let (point, normal) = point_and_normal(shape, is(SPHERE), ray, found);
        Self {
            vertex: Vertex::of(point, normal, ray.direction),
            normal,
            offset,
            t: found.t,
            emits: is(EMITTER),
            non_delta: is(NON_DELTA),
            mirror: is(MIRROR),
            glass: is(GLASS),
            hit_mask: found.hit_mask,
            colour: R::Vector::of([red, green, blue]),
            absorption,
            index,
            oren_nayar: OrenNayar { a, b },
            kinds,
            scene_kinds: lanes.data.kinds,
            primitives,
            scene: lanes.scene,
        }
    }

    /// Returns the lanes whose primitive is of this kind.
    #[inline]
    pub(super) fn is(&self, kind: u16) -> R::Mask {
        of_kind(&self.kinds, self.scene_kinds, kind, self.hit_mask)
    }

    /// Returns rays that leave the surfaces in these directions.
    #[inline]
    pub fn spawn_ray(&self, direction: R::Vector) -> Ray<R::Vector> {
        RayOrigin {
            normal: self.normal,
            ..self.ray_origin()
        }
        .spawn_ray(direction)
    }

    /// Returns the hit of a lane's ray.
    #[inline]
    pub fn hit(&self, lane: usize, primitive: u32) -> Hit {
        let (part, t) = (self.primitives[lane], self.t.lane(lane));
        let [point, normal] = map_array([self.vertex.point, self.normal], |v| v.lane(lane));
        Hit {
            t,
            point,
            normal,
            primitive,
            surface: part.surface,
            emitter: part.emitter,
        }
    }

    /// Returns the BSDF in a lane, oriented to the side of the ray.
    pub(super) fn bsdf(&self, lane: usize) -> Bsdf {
        self.surface_bsdf(lane)
            .oriented(self.vertex.outside.lane(lane))
    }

    /// Returns the BSDF of the surface in a lane, not oriented.
    pub(super) fn surface_bsdf(&self, lane: usize) -> &'a Bsdf {
        &self.scene.surfaces()[self.primitives[lane].surface as usize].bsdf
    }

    /// Returns the index of the emitter in a lane, if there is one.
    #[inline]
    pub fn emitter(&self, lane: usize) -> Option<u32> {
        self.primitives[lane].emitter
    }

    /// Returns the indices of the specular casters by which the primitive in a lane reflects and
    /// refracts.
    #[inline]
    pub fn casters(&self, lane: usize) -> [u8; 2] {
        self.primitives[lane].casters
    }

    /// Returns the emitted radiance towards the rays; zero behind emitters and on other surfaces.
    #[inline]
    pub fn emitted(&self) -> R::Vector {
        let front = self.normal.dot(self.vertex.direction).cmplt(R::splat(0.0));
        let radiance = R::Vector::from_fn(|i| self.emitter_radiance(i));
        Vector::select(front, radiance, R::Vector::zero())
    }

    /// Returns the emitted radiance under these rules.
    pub fn emitted_under(&self, rules: &TransportRules) -> R::Vector {
        let radiance = self.emitted();
        rules.emitted_radiance.map_or(radiance, |shown| {
            let shown = R::Vector::splat_vector(DVec3::splat(shown));
            Vector::select(radiance.is_zero(), R::Vector::zero(), shown)
        })
    }

    /// Returns the lanes whose rays see the front of an emitter.
    pub fn shows_emitter(&self) -> R::Mask {
        self.emits & self.normal.dot(self.vertex.direction).cmplt(R::splat(0.0))
    }

    /// Returns the radiance of the emitter in a lane; zero without one.
    pub fn emitter_radiance(&self, lane: usize) -> DVec3 {
        self.emitter(lane).map_or(DVec3::ZERO, |emitter| {
            self.scene.emitters()[emitter as usize].radiance
        })
    }

    /// Returns a bit for each lane whose ray sees the back of its surface.
    pub fn backs(&self) -> u32 {
        let zero = R::splat(0.0);
        !R::splat(1.0)
            .copysign(self.normal.dot(self.vertex.direction))
            .cmplt(zero)
            .bits()
    }

    /// Adds the features of a lane with a hit to a pixel; `backs` comes from
    /// [`backs`](Self::backs).
    pub fn push_features(&self, lane: usize, backs: u32, pixel: &mut Pixel) -> Result<(), Error> {
        let depth = self.t.lane(lane);
        match &self.primitives[lane].features {
            Some(flat) if is_valid_depth(depth) => {
                pixel.push_fixed_point(flat, backs >> lane & 1 == 1, depth)
            }
            _ => pixel.push_features(&self.features(lane)),
        }
    }

    /// Returns the features (albedo, normal, depth) of a lane with a hit.
    pub fn features(&self, lane: usize) -> Features {
        let [albedo, normal, direction] =
            [self.colour, self.normal, self.vertex.direction].map(|v| v.lane(lane));
        features(albedo, normal, self.t.lane(lane), direction)
    }

    /// Returns the lanes with mirrors that do not emit.
    pub fn dark_mirror(&self) -> R::Mask {
        self.mirror & !self.emits
    }

    /// Returns the mirror directions of the rays.
    pub fn mirrored(&self) -> R::Vector {
        fresnel::reflect(self.vertex.direction, self.vertex.frame.z)
    }

    /// Returns the reflectance of the mirror in a lane.
    pub fn reflectance(&self, lane: usize) -> DVec3 {
        self.colour.lane(lane)
    }

    /// Returns the lanes whose BSDF is a Dirac distribution: mirrors and smooth glass.
    pub fn delta(&self) -> R::Mask {
        self.mirror | self.glass
    }

    /// Returns the pdf of sampled directions with respect to solid angle in the active lanes; 0 for
    /// mirrors and glass.
    #[inline(always)]
    pub fn pdf<P: PathParts + ?Sized>(&self, parts: &P, wi: R::Vector, active: R::Mask) -> R {
        let pdf = |i: usize| parts.pdf(&self.bsdf(i), self.vertex.wo.lane(i), wi.lane(i));
        if !parts.is_default() {
            return numbers(active, pdf);
        }
        let by_cosine = warp::cosine_hemisphere_pdf(wi.z());
        let models = self.is(NOT_COSINE_SAMPLED);
        if !models.any() {
            return by_cosine;
        }
        R::from_lanes(|i| {
            if models.lane(i) {
                pdf(i)
            } else {
                by_cosine.lane(i)
            }
        })
    }
}

/// Returns the active lanes whose primitive is of a kind; primitives are inspected only if the
/// scene has the kind.
#[inline]
fn of_kind<M: Mask, const N: usize>(kinds: &[u16; N], all: u16, kind: u16, active: M) -> M {
    if all & kind == 0 {
        return M::splat(false);
    }
    active & M::from_fn(|i| kinds[i] & kind != 0)
}

/// Computes points and normals of hits on primitives with these numbers, as
/// [`Scene::intersect`](crate::scene::Scene::intersect) does.
#[inline]
fn point_and_normal<R: Wide<N>, const N: usize>(
    [a, b, c, d, e, f, g, h, i, x, y, z, radius]: [R; 13],
    curved: R::Mask,
    ray: &Ray<R::Vector>,
    found: &PacketHit<R, N>,
) -> (R::Vector, R::Vector) {
    let corners = map_array([[a, b, c], [d, e, f], [g, h, i]], R::Vector::of);
    let (point, normal) = (
        inner_point(corners, found.weights, radius),
        R::Vector::of([x, y, z]),
    );
    if !curved.any() {
        return (point, normal);
    }
    let centre = corners[0];
    let away = outward(ray.at(found.t), centre);
    let oriented = Vector::select(radius.cmplt(R::splat(0.0)), -away, away);
    let on_sphere = centre + away * radius.abs();
    (
        Vector::select(curved, on_sphere, point),
        Vector::select(curved, oriented, normal),
    )
}
