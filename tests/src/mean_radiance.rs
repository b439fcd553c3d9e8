//! The commonest trial of a whole estimator: the mean radiance along probe rays is a closed form.

use crate::prelude::*;
use crate::scenes::level;

/// δ of single estimators with closed forms, relative.
pub const SINGLE: f64 = 0.003;
/// δ of means over several bounces, relative.
pub const BOUNCES: f64 = 0.005;
/// δ of image means, relative.
pub const IMAGE: f64 = 0.01;

/// The mean [`level`] along probe rays.
pub struct MeanRadiance {
    /// What is probed.
    pub probe: Probe,
    /// The expectation.
    pub reference: f64,
    /// δ, absolute; 0 if every value is the reference.
    pub delta: f64,
    /// Rays at scale 1.
    pub samples: u64,
}

impl Property for MeanRadiance {
    fn run<P: EstimatorParts + Copy>(&self, context: &Context, setup: Configuration<P>) -> Vec<Outcome> {
        let mut rng = context.rng("radiance");
        let values = Values::collect(self.reference, context.n(self.samples), || {
            level(&self.probe.scene, self.probe.radiance(setup, &mut rng))
        });
        let claim = Claim::Exact { delta: self.delta };
        vec![mean("radiance", &values, self.reference, claim)]
    }
}

/// The path of an estimator of this kind.
pub fn path(kind: EstimatorKind) -> &'static str {
    match kind {
        EstimatorKind::Path | EstimatorKind::PathBy(..) => "estimator::Path",
        EstimatorKind::Report(_) => "estimator::Report",
        EstimatorKind::Whitted(_) => "estimator::Whitted",
    }
}

/// A trial of the mean radiance; `delta` is relative to the reference. 0 claims that every value is the
/// reference.
pub fn radiance(
    name: &'static str,
    property: impl Into<String>,
    equation: &'static Equation,
    (scene, kind, ray): (&Arc<Scene>, EstimatorKind, fn(&mut Stream) -> Ray),
    reference: f64,
    (samples, delta): (u64, f64),
) -> FamilyTrial<EstimatorSubject> {
    let probe = Probe { scene: Arc::clone(scene), kind, ray };
    let mean = MeanRadiance { probe, reference, delta: delta * reference, samples };
    trial(name, property, equation, [path(kind), "t"], with_parts(mean))
}

/// A uniformly distributed direction.
pub fn any_direction(rng: &mut Stream) -> DVec3 {
    whitefurnace::sampling::sphere_zone(uniform2(rng), 1.0, [-1.0, 1.0])
}
