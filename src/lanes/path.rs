//! The path tracer of [`crate::estimator::Path`] in lanes.

use std::array::from_fn;

use glam::DVec3;

use super::lights;
use super::row::{Paths, Scatter};
use super::samples::PixelSampler;
use super::scene::{LaneScene, Seen};
use super::shading::{LightNumbers, Surfaces};
use crate::estimator::{Heuristic, LONGEST_PATH, Path, Strategy};
use crate::real::{Lanes3, Mask, Real, Vector, Wide, WideMask};
use crate::{radiometry, roulette};

impl Scatter for Path {
    fn scatter<R: Wide<N>, S: PixelSampler<R, N>, const N: usize>(
        &self,
        scene: &LaneScene<'_, R, N>,
        paths: &mut Paths<R, N>,
        (surfaces, arrived): (&Surfaces<'_, R, N>, R::Mask),
        random: &mut S,
        seen: &mut Seen<R, N>,
    ) -> R::Mask {
        random.start_blocks(arrived, &paths.hits);
        let endless = arrived & R::Mask::from_fn(|i| paths.hits[i] > LONGEST_PATH);
        let throughput = Vector::choose(endless, Lanes3::splat_vector(DVec3::NAN), paths.throughput);
        let by_bodies = self.goes_by_bodies(scene.scene);
        add_emission((self, by_bodies), scene, paths, (surfaces, arrived), throughput);
        let beyond = self.bounces.map(|_| paths.hits.map(|hit| self.bounces_beyond(hit)));
        let arrived = beyond.map_or(arrived, |beyond| arrived & R::Mask::from_fn(|i| beyond[i].is_some()));
        let scattering = arrived & !surfaces.black();
        if self.strategy != Strategy::Bsdf {
            let asking = arrived & surfaces.rough;
            let numbers = LightNumbers::new(scene.scene, asking, random);
            let light = surfaces.light_from(scene, self.lights, false, (asking, &numbers), seen);
            let direct = match self.strategy {
                Strategy::Mis => weight(self.heuristic, light.pdf, surfaces.pdf(light.wi)),
                _ => R::splat(1.0),
            };
            let mut reflected =
                Vector::choose(light.arrives, light.reflected * direct, Lanes3::splat_vector(DVec3::ZERO));
            if by_bodies && asking.any() {
                let body = random.uniform(asking);
                let weight = |pdf, other| weight(self.heuristic, pdf, other);
                let body = (body, &numbers, beyond);
                reflected = reflected + surfaces.light_by_body(scene, asking, body, weight, seen);
            }
            let added = paths.radiance + throughput * paths.factor * reflected;
            paths.radiance = Vector::choose(scattering, added, paths.radiance);
        }
        let next = surfaces.sample(scattering & !endless, random);
        let throughput = paths.throughput * next.weight;
        let early = R::Mask::from_fn(|i| paths.hits[i] <= self.early);
        let survival = roulette::by_throughput(throughput * R::splat(1.0 / roulette::RAISED), early);
        let survives = next.goes_on & roulette::survives(random.uniform(next.goes_on), survival);
        paths.factor = R::choose(survives, paths.factor * next.radiance_factor, paths.factor);
        paths.pdf = R::choose(survives, next.pdf, paths.pdf);
        paths.sampled = next.has_pdf;
        if by_bodies {
            paths.trails.go_on(surfaces, &next, survives);
        }
        paths.send(survives, surfaces, next.direction, throughput * roulette::weight(survival));
        survives
    }
}

/// Adds what emitters show that the paths have hit.
#[inline]
fn add_emission<R: Wide<N>, const N: usize>(
    (path, by_bodies): (&Path, bool),
    scene: &LaneScene<'_, R, N>,
    paths: &mut Paths<R, N>,
    (surfaces, arrived): (&Surfaces<'_, R, N>, R::Mask),
    throughput: Lanes3<R>,
) {
    let emits = arrived & surfaces.emits;
    if !emits.any() {
        return;
    }
    let emitters = scene.scene.emitters();
    let weighted = paths.sampled & R::Mask::splat(path.strategy == Strategy::Mis);
    let cosine = radiometry::cosine(surfaces.normal, -paths.ray.direction);
    let per_area = radiometry::solid_angle_per_area(cosine, surfaces.t * surfaces.t);
    let numbers = from_fn(|i| surfaces.emitter(i).map_or(0, |emitter| emitter as usize));
    let on_emitter = lights::pdf_of_hit(emitters, path.lights, (numbers, emits), paths.ray.origin, per_area);
    let probability = lights::probability_of_pick(scene.scene, path.lights, (numbers, emits), paths.ray.origin);
    // Behind an emitter the one is infinite and the other may be 0.
    let zero = R::splat(0.0);
    let other = R::choose(probability.above(zero), on_emitter * probability, zero);
    // Light that shadow rays find is not counted when it is hit.
    let counts = if path.strategy == Strategy::Light { !paths.sampled } else { emits };
    let alone = R::choose(counts, R::splat(1.0), R::splat(0.0));
    let mut weights = R::choose(weighted, weight(path.heuristic, paths.pdf, other), alone);
    if by_bodies {
        let of = (numbers, emits & !paths.sampled);
        let (behind, pdf, other) = paths.trails.pdfs(scene, of, (surfaces.vertex.point, cosine));
        weights = R::choose(behind, weight(path.heuristic, pdf, other), weights);
    }
    let shown = surfaces.emitted(scene, paths.ray.direction);
    let added = paths.radiance + throughput * (paths.factor * weights) * shown;
    paths.radiance = Vector::choose(emits, added, paths.radiance);
}

/// The weight of multiple importance sampling.
#[inline]
fn weight<R: Real>(heuristic: Heuristic, pdf: R, other: R) -> R {
    match heuristic {
        Heuristic::Balance => radiometry::balance(pdf, other),
        Heuristic::Power => radiometry::power(pdf, other),
    }
}
