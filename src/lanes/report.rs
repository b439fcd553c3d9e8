//! The report's estimator, [`crate::estimator::Report`] with one sample ray per hit, in lanes.

use super::row::{Paths, Scatter};
use super::samples::PixelSampler;
use super::scene::{LaneScene, Seen};
use super::shading::Surfaces;
use crate::emitter::LightSampling;
use crate::real::{Vector, Wide, WideMask};
use crate::render::OneRayPerHit;
use crate::roulette;

impl Scatter for OneRayPerHit {
    fn scatter<R: Wide<N>, S: PixelSampler<R, N>, const N: usize>(
        &self,
        scene: &LaneScene<'_, R, N>,
        paths: &mut Paths<R, N>,
        (surfaces, arrived): (&Surfaces<'_, R, N>, R::Mask),
        random: &mut S,
        seen: &mut Seen<R, N>,
    ) -> R::Mask {
        let (rules, rough) = (&self.rules, arrived & surfaces.rough);
        paths.see(surfaces.seen(scene, rules, paths.ray.direction), arrived & surfaces.emits & !paths.sampled);
        let goes_on = R::Mask::from_fn(|i| paths.hits[i] < self.segments);
        let next = surfaces.sample_specular(arrived & !rough, random);
        // A shadow ray that passes through glass has looked behind it.
        let below = next.direction.dot(surfaces.vertex.frame.z).below(R::splat(0.0));
        let looked_behind = R::Mask::splat(!rules.caustics) | below & R::Mask::splat(rules.shadows_pass_glass);
        let factor = if rules.radiance_factor { next.radiance_factor } else { R::splat(1.0) };
        let light =
            surfaces.direct_light(scene, LightSampling::Area, rules.shadows_pass_glass, (rough, &mut *random), seen);
        let lit = paths.radiance + paths.throughput * light.reflected;
        paths.radiance = Vector::choose(light.arrives, lit, paths.radiance);
        let survival = roulette::by_absorption(surfaces.absorption);
        let asking = rough & goes_on;
        let survives = asking & roulette::survives(random.uniform(asking), survival);
        let (direction, weight) = surfaces.sample_uniform([random.uniform(survives), random.uniform(survives)]);
        let weight = Vector::choose(rough, weight * roulette::weight(survival), next.weight * factor);
        let direction = Vector::choose(rough, direction, next.direction);
        let goes_on = survives | next.goes_on & goes_on;
        paths.sampled = rough | paths.sampled & looked_behind;
        paths.send(goes_on, surfaces, direction, paths.throughput * weight);
        goes_on
    }
}
