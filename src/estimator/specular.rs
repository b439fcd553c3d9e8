//! Light by way of one mirror or glass body: shadow rays find it, paths hit it, and both are weighted.

use glam::DVec3;

use super::Walking;
use super::next_event::{LightNumbers, point_pdf};
use crate::bsdf::{Bsdf, Vertex};
use crate::radiometry;
use crate::scene::{Hit, Scene};
use crate::specular::{Kind, NONE, Route, SceneBody, spread_of};

/// Light by one shadow ray by way of a body, from a vertex that scatters in all directions: over all routes the sum of
/// f_r L cos θ / p, each weighted by `weight` of p and of the pdf with which a path goes there. Both are with respect to
/// solid angle at the vertex. Bodies that scatter light more than `most` times are passed over.
#[inline]
pub(super) fn light_by_body<P: Walking>(
    parts: &P,
    scene: &Scene,
    (bsdf, vertex): (&Bsdf, &Vertex),
    (body, numbers, most): (f64, LightNumbers, u32),
    weight: impl Fn(f64, f64) -> f64,
) -> DVec3 {
    let mut sum = DVec3::ZERO;
    let bodies = scene.bodies();
    let shares = bodies.shares(vertex.point);
    let (number, share) = parts.pick_by_share(body, &shares[..bodies.all().len()]);
    if share == 0.0 {
        return sum;
    }
    let body = &bodies.all()[number];
    if body.kind.bounces() > most {
        return sum;
    }
    let index = parts.pick_emitter(numbers.pick, scene.flux_picks());
    let emitter = &scene.emitters()[index];
    let light = parts.sample_emitter(emitter, numbers.point);
    let pdf_area = parts.pdf_of_pick(point_pdf(parts, scene, index), share);
    for (number, route) in body.routes((vertex.point, light.point)) {
        let Some(route) = parts.route(body, number, route) else {
            continue;
        };
        let wi = vertex.frame.local(route.direction);
        let brdf = parts.brdf(bsdf, vertex.wo, wi);
        let cosine = parts.cosine(vertex.frame.z, route.direction);
        let cosine_at_light = parts.cosine(light.normal, -route.arriving);
        if cosine <= 0.0 || cosine_at_light <= 0.0 || brdf == DVec3::ZERO {
            continue;
        }
        let ends = ((vertex.point, vertex.frame.z), (light.point, light.normal));
        if !is_free(parts, scene, (body, &route), ends) {
            continue;
        }
        let pdf = pdf_area / (route.spread * cosine_at_light);
        let (passed, chance) = parts.lets_on(body, route.cosine);
        let reflected = radiometry::reflected(brdf, emitter.radiance * passed, cosine, pdf);
        sum += reflected * weight(pdf, parts.pdf(bsdf, vertex.wo, wi) * chance);
    }
    sum
}

/// Whether nothing stands in the way of a route between two surface points with their normals.
#[inline]
fn is_free<P: Walking>(
    parts: &P,
    scene: &Scene,
    (body, route): (&SceneBody, &Route<DVec3>),
    (x, y): ((DVec3, DVec3), (DVec3, DVec3)),
) -> bool {
    parts.visible(scene, x, route.first, false)
        && (body.kind != Kind::Refraction || parts.visible(scene, route.first, route.last, false))
        && parts.visible(scene, route.last, y, false)
}

/// Where a path has gone since it left a vertex from which a shadow ray by way of a body could have found the same light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trail {
    from: DVec3,
    direction: DVec3,
    /// Of the direction, with respect to solid angle.
    pdf: f64,
    stage: Stage,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// No such shadow ray finds what it hits.
    Lost,
    /// It has met nothing.
    Fresh,
    /// It is within the body of this number.
    Within(u8),
    /// It has left the body of this number.
    Behind(u8),
}

impl Trail {
    /// Of a path that comes from the camera.
    pub const LOST: Self = Self { from: DVec3::ZERO, direction: DVec3::Z, pdf: 0.0, stage: Stage::Lost };

    /// Goes on from a hit in a direction of this pdf, if it has one.
    #[inline]
    pub fn go_on(
        &mut self,
        (scene, bsdf): (&Scene, &Bsdf),
        (here, at): (&Hit, &Vertex),
        (direction, pdf): (DVec3, Option<f64>),
    ) {
        if let Some(pdf) = pdf {
            let stage = if bsdf.is_rough_glass() { Stage::Lost } else { Stage::Fresh };
            *self = Self { from: at.point, direction, pdf, stage };
            return;
        }
        let [reflecting, refracting] = scene.bodies().of(here.primitive);
        let passes = at.frame.z.dot(direction) < 0.0;
        self.stage = self.stage.next(([reflecting, refracting], at.outside, passes));
    }

    /// Of a hit on the emitter of this number, the pdf with which the path came here and that with which a shadow ray by
    /// way of the same body does, both with respect to solid angle where the path left; `None` if none does.
    #[inline]
    pub fn pdfs<P: Walking>(
        &self,
        parts: &P,
        scene: &Scene,
        index: usize,
        (direction, hit): (DVec3, &Hit),
    ) -> Option<(f64, f64)> {
        let Stage::Behind(number) = self.stage else {
            return None;
        };
        let bodies = scene.bodies();
        let body = &bodies.all()[usize::from(number)];
        let (spread, cosine) = spread_of(&body.body, body.kind, (self.from, self.direction, hit.point));
        let (_, chance) = parts.lets_on(body, cosine);
        let share: f64 = bodies.share_of(f64::from(number), self.from);
        let per_area = spread * parts.cosine(hit.normal, -direction);
        let other =
            if spread > 0.0 { parts.pdf_of_pick(point_pdf(parts, scene, index), share) / per_area } else { 0.0 };
        Some((self.pdf * chance, other))
    }
}

impl Stage {
    /// Where a path is after a mirror or glass whose bodies reflect and refract by these numbers, which it met outside or
    /// not and passed or not.
    #[inline]
    pub fn next(self, ([reflecting, refracting], outside, passes): ([u8; 2], bool, bool)) -> Self {
        match (self, outside, passes) {
            (Self::Fresh, true, false) if reflecting != NONE => Self::Behind(reflecting),
            (Self::Fresh, true, true) if refracting != NONE => Self::Within(refracting),
            (Self::Within(number), false, true) if number == refracting => Self::Behind(number),
            _ => Self::Lost,
        }
    }
}
