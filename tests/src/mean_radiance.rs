//! The commonest trial of a whole estimator: the mean radiance along probe rays is a closed form.

use whitefurnace::sampling::rng::stream;
use whitefurnace::sampling::sampler::{Sobol, scramble};

use crate::prelude::*;
use crate::scenes::level;

/// δ of single estimators with closed forms, relative.
pub const SINGLE: f64 = 0.003;
/// δ of means over several bounces, relative.
pub const BOUNCES: f64 = 0.005;
/// δ of image means, relative.
pub const IMAGE: f64 = 0.01;

/// The mean of so many values against a reference; δ is relative to it, and 0 if every value is the
/// reference.
pub fn mean_of(
    name: &str,
    (reference, delta): (f64, f64),
    n: u64,
    value: impl FnMut() -> f64,
) -> Outcome {
    let values = Values::collect(reference, n, value);
    mean(
        name,
        &values,
        reference,
        Claim::Exact {
            delta: delta * reference,
        },
    )
}

/// The same of several values that are drawn together: each has a name, a reference and an absolute
/// δ.
pub fn means<S: AsRef<str>, const N: usize>(
    about: [(S, f64, f64); N],
    n: u64,
    mut draw: impl FnMut() -> [f64; N],
) -> Vec<Outcome> {
    let mut all = about
        .each_ref()
        .map(|(_, reference, _)| Values::new(*reference));
    for _ in 0..n {
        for (values, value) in all.iter_mut().zip(draw()) {
            values.push(value);
        }
    }
    let outcome = |((name, reference, delta), values): ((S, f64, f64), &Values)| {
        mean(name.as_ref(), values, reference, Claim::Exact { delta })
    };
    about.into_iter().zip(&all).map(outcome).collect()
}

/// The mean [`level`] along probe rays.
pub struct MeanRadiance {
    /// What is probed.
    pub probe: Probe,
    /// The expectation, and δ as of [`mean_of`].
    pub claim: (f64, f64),
    /// How many values are drawn at scale 1, and of what.
    pub draws: Draws,
}

/// What the values are.
#[derive(Clone, Copy)]
pub enum Draws {
    /// So many rays, by independent numbers.
    Rays(u64),
    /// So many means of [`POINTS`] rays, by the points of a scramble of a Sobol' sequence. Each
    /// point alone is uniform, whence the expectation is the same whatever an estimator does with
    /// it, and a smooth estimate varies much less.
    Scrambles(u64),
}

/// Rays of a scramble.
const POINTS: u16 = 16;
/// Scrambles that are followed together.
const TOGETHER: u32 = 16;

impl Property for MeanRadiance {
    fn run<P: EstimatorParts + Copy>(
        &self,
        context: &Context,
        setup: Configuration<P>,
    ) -> Vec<Outcome> {
        let Probe { scene, kind, .. } = &self.probe;
        let outcome = match self.draws {
            Draws::Rays(n) => {
                let mut radiance = self.probe.radiances(setup, context.seed_of("radiance"));
                mean_of("radiance", self.claim, context.n(n), || {
                    level(scene, radiance())
                })
            }
            Draws::Scrambles(n) => {
                let (mut rng, seed) = (context.rng("radiance"), context.seed_of("points"));
                let (mut means, mut next) = (Vec::new().into_iter(), 0);
                let value = || {
                    means.next().unwrap_or_else(|| {
                        let names = (next..next + TOGETHER)
                            .flat_map(|scramble| (0..POINTS).map(move |i| (scramble, i)));
                        next += TOGETHER;
                        let rays = names.map(|(number, index)| {
                            let fill = stream(seed, index.into(), number);
                            (
                                (self.probe.ray)(&mut rng),
                                Sobol::new(index, scramble(seed, 0, number), fill),
                            )
                        });
                        let radiances = kind.radiances(setup, scene, rays);
                        let mean = |points: &[DVec3]| {
                            points.iter().map(|point| level(scene, *point)).sum::<f64>()
                                / f64::from(POINTS)
                        };
                        means = radiances
                            .chunks(POINTS.into())
                            .map(mean)
                            .collect::<Vec<_>>()
                            .into_iter();
                        means.next().expect("a mean of each scramble")
                    })
                };
                mean_of("radiance", self.claim, context.n(n), value)
            }
        };
        vec![outcome]
    }
}

/// The path of an estimator of this kind.
pub fn path(kind: EstimatorKind) -> &'static str {
    match kind {
        EstimatorKind::Path
        | EstimatorKind::PathEarly
        | EstimatorKind::PathBy(..)
        | EstimatorKind::PathByBodies(..)
        | EstimatorKind::PathWithin(..) => "integrator::Path",
        EstimatorKind::Report(_) => "integrator::Report",
        EstimatorKind::Whitted(_) => "integrator::Whitted",
    }
}

/// Rays into a scene, from random numbers.
pub type Rays = fn(&mut Stream) -> Ray;

/// A trial of the mean radiance that an estimator finds in a scene along rays.
pub fn radiance(
    name: &'static str,
    equation: &'static Equation,
    (scene, kind, ray): (&Arc<Scene>, EstimatorKind, Rays),
) -> Radiance {
    Radiance {
        name,
        equation,
        probe: Probe {
            scene: Arc::clone(scene),
            kind,
            ray,
        },
        property: String::new(),
    }
}

/// A trial of a mean radiance that is still to be told its [property](Self::says) and
/// [reference](Self::is).
pub struct Radiance {
    name: &'static str,
    equation: &'static Equation,
    probe: Probe,
    property: String,
}

impl Radiance {
    /// With its property in words.
    pub fn says(self, property: impl Into<String>) -> Self {
        Self {
            property: property.into(),
            ..self
        }
    }

    /// The trial: reference and relative δ as in [`mean_of`], and the number of rays at scale 1.
    pub fn is(self, claim: (f64, f64), rays: u64) -> FamilyTrial<EstimatorSubject> {
        self.drawn(claim, Draws::Rays(rays))
    }

    /// The same by so many [scrambles](Draws::Scrambles).
    pub fn by_points(self, claim: (f64, f64), scrambles: u64) -> FamilyTrial<EstimatorSubject> {
        self.drawn(claim, Draws::Scrambles(scrambles))
    }

    /// The same by rays or scrambles.
    pub fn drawn(self, claim: (f64, f64), draws: Draws) -> FamilyTrial<EstimatorSubject> {
        let Self {
            name,
            equation,
            probe,
            property,
        } = self;
        let judged = [path(probe.kind), "t"];
        trial(
            name,
            property,
            equation,
            judged,
            with_parts(MeanRadiance {
                probe,
                claim,
                draws,
            }),
        )
    }
}

/// The largest of some errors; unlike a maximum it keeps NaN.
pub fn largest(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}

/// A uniformly distributed direction.
pub fn any_direction(rng: &mut Stream) -> DVec3 {
    whitefurnace::sampling::warp::sphere_zone(uniform2(rng), 1.0, [-1.0, 1.0])
}
