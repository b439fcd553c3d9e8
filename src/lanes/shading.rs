//! The surfaces that rays have met, as all lanes see them at once. What few scenes have (EON, models that are not of
//! the library) is asked for lane by lane.

use std::array::from_fn;

use glam::DVec3;

use super::lights::{Picked, pick_emitters};
use super::samples::LaneSampler;
use super::scene::{LaneScene, PrimitiveData, Seen};
use crate::accel::PacketHit;
use crate::bsdf::{Bsdf, OrenNayar, OrenNayarForm, Vertex, lambert, oren_nayar};
use crate::emitter::LightSampling;
use crate::error::Error;
use crate::estimator::LightRules;
use crate::film::{Features, Pixel, is_legal_depth};
use crate::real::{Lanes3, Mask, Real, Vector, Wide, WideMask, WideVector};
use crate::render::features;
use crate::scene::{Hit, Place, Scene, Surface, inner_point};
use crate::shape::{Ray, outward};
use crate::{fresnel, radiometry, sampling};

/// What lanes need of a surface.
pub(super) struct Material {
    /// The index of glass, A and B of (15), and α of section 2.6.2.
    pub numbers: [f64; 4],
    /// A bit for each of the kinds below.
    pub kinds: u8,
}

/// Light leaves in all directions.
const ROUGH: u8 = 1;
/// Directions are sampled by the cosine.
const COSINE: u8 = 2;
const MIRROR: u8 = 4;
const GLASS: u8 = 8;
/// (14) as it is printed.
const PRINTED: u8 = 16;
/// f_r is evaluated lane by lane.
const ONE_BY_ONE: u8 = 32;
/// It emits light, whatever it is made of.
pub(super) const EMITTER: u8 = 64;
/// It is no triangle.
pub(super) const SPHERE: u8 = 128;

impl Material {
    pub fn new(&Surface { bsdf, absorption, .. }: &Surface) -> Self {
        // (14) is (13) with these.
        let (mut index, mut oren_nayar) = (1.0, OrenNayar { a: 1.0, b: 0.0 });
        let kinds = match bsdf {
            Bsdf::Black => 0,
            Bsdf::Lambert { .. } => ROUGH,
            Bsdf::OrenNayar { constants, form, .. } => {
                oren_nayar = constants;
                if form == OrenNayarForm::Printed { ROUGH | PRINTED } else { ROUGH }
            }
            Bsdf::Mirror { .. } => MIRROR,
            Bsdf::Glass { index: of_glass } => {
                index = of_glass;
                GLASS
            }
            // No scene with rough glass comes here.
            Bsdf::Eon { .. } | Bsdf::RoughGlass(_) | Bsdf::Model(_) => ROUGH | ONE_BY_ONE,
        };
        let kinds = if bsdf.is_sampled_by_cosine() { kinds | COSINE } else { kinds };
        Self { numbers: [index, oren_nayar.a, oren_nayar.b, absorption], kinds }
    }
}

/// What the rays of all lanes have met; of lanes that have met nothing it means nothing.
pub(super) struct Surfaces<'a, R: Wide<N>, const N: usize> {
    parts: [&'a PrimitiveData<R::Scalar>; N],
    /// All that the scene has.
    surfaces: &'a [Surface],
    pub vertex: Vertex<Lanes3<R>>,
    /// The unit normals of the surfaces' own fronts.
    pub normal: Lanes3<R>,
    /// How far above the surfaces rays start.
    offset: R,
    pub t: R,
    /// Where an emitter is.
    pub emits: R::Mask,
    /// Where light leaves in all directions.
    pub rough: R::Mask,
    /// Of these, where it is sampled by the cosine.
    cosine: R::Mask,
    mirror: R::Mask,
    glass: R::Mask,
    /// The albedo or the reflectance of a mirror.
    colour: Lanes3<R>,
    pub absorption: R,
    index: R,
    oren_nayar: OrenNayar<R>,
    printed: R::Mask,
    /// Lanes whose f_r is evaluated one by one.
    one_by_one: u32,
}

/// A way on from surfaces, as [`crate::bsdf::BsdfSample`].
pub(super) struct Onward<R: Real> {
    /// Where there is one.
    pub goes_on: R::Mask,
    pub direction: Lanes3<R>,
    pub weight: Lanes3<R>,
    /// 0 where the direction has no pdf.
    pub pdf: R,
    pub has_pdf: R::Mask,
    pub radiance_factor: R,
}

/// The direction and the weight of what mirrors and glass reflect.
type Reflected<R> = (Lanes3<R>, Lanes3<R>);

/// What glass lets through.
pub(super) struct Refracted<R: Real> {
    /// Where it does.
    pub passes: R::Mask,
    pub direction: Lanes3<R>,
    pub weight: R,
}

/// Light that arrives from points picked on emitters, as in the scalar engine's next-event estimation.
pub(super) struct Light<R: Real> {
    /// Where some does.
    pub arrives: R::Mask,
    pub wi: Lanes3<R>,
    pub reflected: Lanes3<R>,
    pub pdf: R,
}

/// The uniform numbers of shadow rays.
pub(super) struct LightNumbers<R> {
    /// Which emitter; of a single one nothing.
    pub pick: R,
    /// Which point.
    pub point: [R; 2],
}

impl<R: Real> LightNumbers<R> {
    /// Draws them in the lanes of the mask, in a scene with emitters.
    #[inline]
    pub fn new<S: LaneSampler<R>>(scene: &Scene, asking: R::Mask, random: &mut S) -> Self {
        let zero = R::splat(0.0);
        let pick = match scene.emitters().len() {
            _ if !asking.any() => zero,
            0 => return Self { pick: zero, point: [zero; 2] },
            1 => {
                random.skip(asking);
                zero
            }
            _ => random.uniform(asking),
        };
        Self { pick, point: [random.uniform(asking), random.uniform(asking)] }
    }
}

impl<'a, R: Wide<N>, const N: usize> Surfaces<'a, R, N> {
    /// Of a scene with at least one primitive.
    #[inline]
    pub fn new(lanes: &'a LaneScene<'_, R, N>, ray: &Ray<Lanes3<R>>, found: &PacketHit<R, N>) -> Self {
        let parts = found.primitive.map(|primitive| &lanes.parts[primitive as usize]);
        let [shape @ .., red, green, blue, index, a, b, absorption, offset, _, _, _] =
            R::of_rows(parts.map(|part| &part.numbers));
        let kinds = parts.map(|part| part.kinds);
        let is = |kind: u8| found.met & R::Mask::from_fn(|i| kinds[i] & kind != 0);
        let (point, normal) = place(shape, is(SPHERE), ray, found);
        Self {
            vertex: Vertex::of(point, normal, ray.direction),
            normal,
            offset,
            t: found.t,
            emits: is(EMITTER),
            rough: is(ROUGH),
            cosine: is(COSINE),
            mirror: is(MIRROR),
            glass: is(GLASS),
            colour: Lanes3::of([red, green, blue]),
            absorption,
            index,
            oren_nayar: OrenNayar { a, b },
            printed: is(PRINTED),
            one_by_one: is(ONE_BY_ONE).bits(),
            parts,
            surfaces: lanes.scene.surfaces(),
        }
    }

    /// Where rays start, with the normals on the side of the rays that have come.
    #[inline]
    pub fn place(&self) -> Place<Lanes3<R>> {
        Place { point: self.vertex.point, normal: self.vertex.frame.z, offset: self.offset }
    }

    /// The rays that leave in these directions.
    #[inline]
    pub fn leave(&self, direction: Lanes3<R>) -> Ray<Lanes3<R>> {
        Place { normal: self.normal, ..self.place() }.leave(direction)
    }

    /// What a ray has met in a lane.
    #[inline]
    pub fn hit(&self, lane: usize, primitive: u32) -> Hit {
        let (part, t) = (self.parts[lane], self.t.lane(lane));
        let [point, normal] = [self.vertex.point, self.normal].map(|v| v.lane(lane));
        Hit { t, point, normal, primitive, surface: part.surface, emitter: part.emitter }
    }

    fn bsdf(&self, lane: usize) -> &'a Bsdf {
        &self.surfaces[self.parts[lane].surface as usize].bsdf
    }

    /// The emitter in a lane, of all that the scene has.
    #[inline]
    pub fn emitter(&self, lane: usize) -> Option<u32> {
        self.parts[lane].emitter
    }

    /// The bodies by which a lane's primitive reflects and refracts.
    #[inline]
    pub fn bodies(&self, lane: usize) -> [u8; 2] {
        self.parts[lane].bodies
    }

    /// What emitters show to rays of this direction; zero from behind and elsewhere.
    pub fn emitted(&self, scene: &LaneScene<'_, R, N>, direction: Lanes3<R>) -> Lanes3<R> {
        let emitters = scene.scene.emitters();
        let radiance =
            Lanes3::from_fn(|i| self.emitter(i).map_or(DVec3::ZERO, |emitter| emitters[emitter as usize].radiance));
        let front = self.normal.dot(direction).below(R::splat(0.0));
        Vector::choose(front, radiance, Lanes3::splat_vector(DVec3::ZERO))
    }

    /// The same by these rules.
    pub fn seen(&self, scene: &LaneScene<'_, R, N>, rules: &LightRules, direction: Lanes3<R>) -> Lanes3<R> {
        let radiance = self.emitted(scene, direction);
        let none = Lanes3::splat_vector(DVec3::ZERO);
        let dark = radiance.x.equals(none.x) & radiance.y.equals(none.y) & radiance.z.equals(none.z);
        rules.seen.map_or(radiance, |shown| Vector::choose(dark, none, Lanes3::splat_vector(DVec3::splat(shown))))
    }

    /// A bit for each lane: which show emitters' fronts to the rays.
    pub fn shining(&self) -> u32 {
        (self.emits & self.normal.dot(self.vertex.direction).below(R::splat(0.0))).bits()
    }

    /// The radiance of the emitter in a lane.
    pub fn shown_in(&self, scene: &LaneScene<'_, R, N>, lane: usize) -> DVec3 {
        let emitters = scene.scene.emitters();
        self.emitter(lane).map_or(DVec3::ZERO, |emitter| emitters[emitter as usize].radiance)
    }

    /// A bit for each lane: which do not show the surfaces' own fronts to the rays.
    pub fn backs(&self) -> u32 {
        let zero = R::splat(0.0);
        !R::splat(1.0).copysign(self.normal.dot(self.vertex.direction)).below(zero).bits()
    }

    /// Adds the features of a lane that has met something to a pixel; `backs` are those of all lanes.
    pub fn push_features(&self, lane: usize, backs: u32, pixel: &mut Pixel) -> Result<(), Error> {
        let depth = self.t.lane(lane);
        match &self.parts[lane].features {
            Some(flat) if is_legal_depth(depth) => pixel.push_flat(flat, backs >> lane & 1 == 1, depth),
            _ => pixel.push_features(&self.features(lane)),
        }
    }

    /// The features of a lane that a ray has met.
    pub fn features(&self, lane: usize) -> Features {
        let [albedo, normal, direction] = [self.colour, self.normal, self.vertex.direction].map(|v| v.lane(lane));
        features(albedo, normal, self.t.lane(lane), direction)
    }

    /// Where there are mirrors that do not emit.
    pub fn dark_mirror(&self) -> R::Mask {
        self.mirror & !self.emits
    }

    /// How mirrors turn the rays.
    pub fn mirrored(&self) -> Lanes3<R> {
        fresnel::mirror(self.vertex.direction, self.vertex.frame.z)
    }

    /// What a mirror in a lane reflects.
    pub fn reflectance(&self, lane: usize) -> DVec3 {
        self.colour.lane(lane)
    }

    /// Where there are mirrors and glass.
    pub fn smooth(&self) -> R::Mask {
        self.mirror | self.glass
    }

    /// Where something absorbs all light.
    pub fn black(&self) -> R::Mask {
        !(self.rough | self.smooth())
    }

    /// f_r, as [`Bsdf::eval`].
    #[inline]
    pub fn brdf(&self, wi: Lanes3<R>) -> Lanes3<R> {
        let (zero, wo) = (R::splat(0.0), self.vertex.wo);
        let mut bracket = oren_nayar(self.oren_nayar, OrenNayarForm::Corrected, wo, wi);
        if self.printed.any() {
            let printed = oren_nayar(self.oren_nayar, OrenNayarForm::Printed, wo, wi);
            bracket = R::choose(self.printed, printed, bracket);
        }
        let above = wo.z.above(zero) & wi.z.above(zero);
        let none = Lanes3::splat_vector(DVec3::ZERO);
        let brdf = Vector::choose(above & self.rough, lambert(self.colour) * bracket, none);
        if self.one_by_one == 0 {
            return brdf;
        }
        Lanes3::from_fn(|i| {
            if self.one_by_one >> i & 1 == 1 { self.bsdf(i).eval(wo.lane(i), wi.lane(i)) } else { brdf.lane(i) }
        })
    }

    /// The pdf of directions of rough surfaces with respect to solid angle.
    #[inline]
    pub fn pdf(&self, wi: Lanes3<R>) -> R {
        let pdf = sampling::cosine_hemisphere_pdf(wi.z);
        let models = (self.rough & !self.cosine).bits();
        if models == 0 {
            return pdf;
        }
        R::from_lanes(|i| {
            let alone = models >> i & 1 == 1;
            if alone { self.bsdf(i).pdf(self.vertex.wo.lane(i), wi.lane(i)) } else { pdf.lane(i) }
        })
    }

    /// Light by one shadow ray from each lane of the mask, all of which are rough.
    #[inline]
    pub fn direct_light<S: LaneSampler<R>>(
        &self,
        scene: &LaneScene<'_, R, N>,
        lights: LightSampling,
        through_glass: bool,
        (asking, random): (R::Mask, &mut S),
        seen: &mut Seen<R, N>,
    ) -> Light<R> {
        let numbers = LightNumbers::new(scene.scene, asking, random);
        self.light_from(scene, lights, through_glass, (asking, &numbers), seen)
    }

    /// The same by these numbers.
    #[inline]
    pub fn light_from(
        &self,
        scene: &LaneScene<'_, R, N>,
        lights: LightSampling,
        through_glass: bool,
        (asking, numbers): (R::Mask, &LightNumbers<R>),
        seen: &mut Seen<R, N>,
    ) -> Light<R> {
        let zero = R::splat(0.0);
        let none = Lanes3::splat_vector(DVec3::ZERO);
        let emitters = scene.scene.emitters();
        if emitters.is_empty() || !asking.any() {
            return Light { arrives: R::Mask::splat(false), wi: none, reflected: none, pdf: zero };
        }
        let vertex = &self.vertex;
        let (picked, probability) = if emitters.len() == 1 {
            ([0; N], R::splat(1.0))
        } else {
            pick_emitters(scene.scene, lights, (vertex.point, asking), numbers.pick)
        };
        let asking = asking & probability.above(zero);
        let picked = Picked::new(emitters, lights, (picked, asking), vertex.point, numbers.point);
        let point = &picked.point;
        let to_light = point.point - vertex.point;
        let distance_squared = to_light.length_squared();
        let direction = to_light * distance_squared.sqrt().recip();
        let cosine = radiometry::cosine(vertex.frame.z, direction);
        let cosine_at_light = radiometry::cosine(point.normal, -direction);
        let wi = vertex.frame.local(direction);
        let brdf = self.brdf(wi);
        let pdf = picked.pdf(radiometry::solid_angle_per_area(cosine_at_light, distance_squared)) * probability;
        let dark = brdf.x.equals(zero) & brdf.y.equals(zero) & brdf.z.equals(zero);
        let asking = asking & cosine.above(zero) & cosine_at_light.above(zero) & !dark;
        let arrives = if asking.any() {
            let light = scene.scene.place(point.point, point.normal);
            scene.visible(&self.place(), &light, through_glass, asking, seen)
        } else {
            asking
        };
        Light { arrives, wi, reflected: radiometry::reflected(brdf, picked.radiance, cosine, pdf), pdf }
    }

    /// A way on, as [`Scattering::sample`](crate::bsdf::Scattering::sample), in world space.
    #[inline]
    pub fn sample<S: LaneSampler<R>>(&self, active: R::Mask, random: &mut S) -> Onward<R> {
        let mut onward = self.sample_specular(active & !self.rough, random);
        onward.has_pdf = active & self.rough;
        if onward.has_pdf.any() {
            self.sample_rough(&mut onward, random);
        }
        onward
    }

    /// The same of mirrors and glass alone.
    #[inline]
    pub fn sample_specular<S: LaneSampler<R>>(&self, active: R::Mask, random: &mut S) -> Onward<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let white = Lanes3::splat_vector(DVec3::ONE);
        let vertex = &self.vertex;
        let (d, n) = (vertex.direction, vertex.frame.z);
        let mut onward = Onward {
            goes_on: active & self.smooth(),
            direction: d,
            weight: white,
            pdf: zero,
            has_pdf: R::Mask::splat(false),
            radiance_factor: one,
        };
        if onward.goes_on.any() {
            onward.direction = fresnel::mirror(d, n);
            onward.weight = Vector::choose(self.mirror, self.colour, white);
        }
        let glass = active & self.glass;
        if glass.any() {
            let random = random.uniform(glass);
            let (n1, n2) = vertex.indices(self.index);
            let reflectance = fresnel::reflectance(-d.dot(n), n1, n2);
            let (refracted, passes) = fresnel::refracted(d, n, n1, n2);
            let refracts = glass & !random.below(reflectance) & passes;
            onward.direction = Vector::choose(refracts, refracted, onward.direction);
            onward.radiance_factor = R::choose(refracts, fresnel::radiance_factor(n1, n2), one);
        }
        onward
    }

    /// Both ways on from mirrors and glass, without choice: the direction and weight of what is reflected, and of what is
    /// refracted.
    pub fn split(&self, radiance_factor: bool) -> (Reflected<R>, Option<Refracted<R>>) {
        let (d, n) = (self.vertex.direction, self.vertex.frame.z);
        let reflected = fresnel::mirror(d, n);
        if !self.glass.any() {
            return ((reflected, self.colour), None);
        }
        let one = R::splat(1.0);
        let (n1, n2) = self.vertex.indices(self.index);
        let share = fresnel::reflectance(-d.dot(n), n1, n2);
        let (direction, passes) = fresnel::refracted(d, n, n1, n2);
        let factor = if radiance_factor { fresnel::radiance_factor(n1, n2) } else { one };
        let refracted = Refracted { passes: self.glass & passes, direction, weight: (one - share) * factor };
        let weight = Vector::choose(self.glass, Lanes3::splat_vector(DVec3::ONE) * share, self.colour);
        ((reflected, weight), Some(refracted))
    }

    /// A direction uniform over the hemisphere, in world space, and its weight.
    #[inline]
    pub fn sample_uniform(&self, random: [R; 2]) -> (Lanes3<R>, Lanes3<R>) {
        let wi: Lanes3<R> = sampling::uniform_hemisphere(random);
        (self.vertex.frame.world(wi), self.weighted(wi, sampling::uniform_hemisphere_pdf(wi.z)))
    }

    #[inline]
    fn sample_rough<S: LaneSampler<R>>(&self, onward: &mut Onward<R>, random: &mut S) {
        let rough = onward.has_pdf;
        let random = [random.uniform(rough), random.uniform(rough)];
        let mut wi: Lanes3<R> = sampling::cosine_hemisphere(random);
        let models = (rough & !self.cosine).bits();
        let mut lost = 0;
        if models != 0 {
            let own: [Option<DVec3>; N] = from_fn(|i| match *self.bsdf(i) {
                Bsdf::Model(model) if models >> i & 1 == 1 => {
                    model.sample(self.vertex.wo.lane(i), random.map(|r| r.lane(i)))
                }
                _ => Some(wi.lane(i)),
            });
            lost = (0..N).fold(0, |lost, i| lost | u32::from(own[i].is_none()) << i);
            wi = Lanes3::from_fn(|i| own[i].unwrap_or(DVec3::Z));
        }
        let pdf = self.pdf(wi);
        let weight = self.weighted(wi, pdf);
        let exists = rough & !pdf.equals(R::splat(0.0)) & !R::Mask::from_bits(lost);
        onward.goes_on = onward.goes_on | exists;
        onward.direction = Vector::choose(rough, self.vertex.frame.world(wi), onward.direction);
        onward.weight = Vector::choose(rough, weight, onward.weight);
        onward.pdf = R::choose(rough, pdf, onward.pdf);
    }

    /// f_r cos θ / p of a direction.
    #[inline]
    fn weighted(&self, wi: Lanes3<R>, pdf: R) -> Lanes3<R> {
        let cosine = radiometry::cosine(Lanes3::splat_vector(DVec3::Z), wi);
        radiometry::reflected(self.brdf(wi), Lanes3::splat_vector(DVec3::ONE), cosine, pdf)
    }
}

/// Points and normals of hits on primitives of these numbers, as [`Scene::intersect`](crate::scene::Scene::intersect)
/// says them.
#[inline]
fn place<R: Wide<N>, const N: usize>(
    [a, b, c, d, e, f, g, h, i, x, y, z, radius]: [R; 13],
    curved: R::Mask,
    ray: &Ray<Lanes3<R>>,
    found: &PacketHit<R, N>,
) -> (Lanes3<R>, Lanes3<R>) {
    let corners = [[a, b, c], [d, e, f], [g, h, i]].map(Lanes3::of);
    let (point, normal) = (inner_point(corners, found.weights, radius), Lanes3::of([x, y, z]));
    if !curved.any() {
        return (point, normal);
    }
    let centre = corners[0];
    let away = outward(ray.at(found.t), centre);
    let facing = Vector::choose(radius.below(R::splat(0.0)), -away, away);
    let on_sphere = centre + away * radius.abs();
    (Vector::choose(curved, on_sphere, point), Vector::choose(curved, facing, normal))
}
