//! Whitted ray tracing, [`crate::estimator::Whitted`], in lanes.

use super::row::{Paths, Scatter};
use super::samples::PixelSampler;
use super::scene::{LaneScene, Seen};
use super::shading::Surfaces;
use crate::emitter::LightSampling;
use crate::estimator::Whitted;
use crate::real::{Mask, Vector, Wide, WideMask};

impl Scatter for Whitted {
    fn scatter<R: Wide<N>, S: PixelSampler<R, N>, const N: usize>(
        &self,
        scene: &LaneScene<'_, R, N>,
        paths: &mut Paths<R, N>,
        (surfaces, arrived): (&Surfaces<'_, R, N>, R::Mask),
        random: &mut S,
        seen: &mut Seen<R, N>,
    ) -> R::Mask {
        let rules = &self.rules;
        paths.see(surfaces.seen(scene, rules, paths.ray.direction), arrived & surfaces.emits);
        let (rough, passes) = (arrived & surfaces.rough, rules.shadows_pass_glass);
        let light = surfaces.direct_light(scene, LightSampling::Area, passes, (rough, random), seen);
        let lit = paths.radiance + paths.throughput * light.reflected;
        paths.radiance = Vector::choose(light.arrives, lit, paths.radiance);
        let goes_on = arrived & surfaces.smooth() & R::Mask::from_fn(|i| paths.hits[i] < self.segments);
        if goes_on.any() {
            let ((direction, weight), refracted) = surfaces.split(rules.radiance_factor);
            let throughput = paths.throughput;
            if let Some(refracted) = refracted {
                let on = goes_on & refracted.passes;
                paths.put_off(on, surfaces, refracted.direction, throughput * refracted.weight);
            }
            paths.send(goes_on, surfaces, direction, throughput * weight);
        }
        goes_on
    }
}
