//! The most common trial of a whole estimator: the mean radiance along probe rays has a closed
//! form.
//!
//! The numbers of rays follow from δ and the noise of the estimator: the
//! [guard](whitefurnace::harness::guard) refuses a trial that could not detect its δ.

use whitefurnace::sampling::rng::stream;
use whitefurnace::sampling::sampler::{Sobol, scramble};

use crate::prelude::*;
use crate::scenes::mean_channel;
use crate::subject::in_batches;

/// Relative δ of single estimators with closed forms.
pub const CLOSED_FORM_DELTA: f64 = 0.003;
/// Relative δ of means over several bounces.
pub const BOUNCES_DELTA: f64 = 0.005;
/// Relative δ of image means.
pub const IMAGE_DELTA: f64 = 0.01;

/// Compares the mean of `n` values with a reference. δ is relative to the reference; 0 claims that
/// every single value is the reference.
pub fn mean_of(
    name: &str,
    reference: f64,
    delta: f64,
    n: u64,
    value: impl FnMut() -> f64,
) -> Outcome {
    let values = Values::collect(reference, n, value);
    mean(
        name,
        &values,
        reference,
        Claim::Equal {
            delta: delta * reference,
        },
    )
}

/// Compares the means of several values that are drawn together. Each has a name, a reference and
/// an absolute δ.
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
        mean(name.as_ref(), values, reference, Claim::Equal { delta })
    };
    about.into_iter().zip(&all).map(outcome).collect()
}

/// Compares the mean [`mean_channel`] along probe rays with a closed form.
pub struct MeanRadiance {
    /// Scene, estimator and rays.
    pub probe: Probe,
    /// Expectation.
    pub reference: f64,
    /// Relative δ, as in [`mean_of`].
    pub delta: f64,
    /// How the values are drawn, and their number at scale 1.
    pub draws: Draws,
}

/// How the values of a trial of a mean are drawn.
#[derive(Clone, Copy)]
pub enum Draws {
    /// This many rays with independent random numbers.
    Rays(u64),
    /// This many means of [`POINTS`] rays, each over the points of one scrambled Sobol' sequence.
    /// Each point alone is uniform, so the expectation does not depend on how an estimator uses it,
    /// while smooth estimates vary much less.
    Scrambles(u64),
}

/// Rays per scramble.
const POINTS: u16 = 16;
/// Scrambles per batch.
const BATCH_SIZE: usize = 16;

impl Property for MeanRadiance {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let Probe { scene, kind, ray } = &self.probe;
        let outcome = |n, value: &mut dyn FnMut() -> f64| {
            let n = context.n(n);
            vec![mean_of("radiance", self.reference, self.delta, n, value)]
        };
        match self.draws {
            Draws::Rays(n) => {
                let mut radiance = self.probe.radiances(setup, context.seed_of("radiance"));
                outcome(n, &mut || mean_channel(scene, radiance()))
            }
            Draws::Scrambles(n) => {
                let (mut rng, seed) = (context.rng("radiance"), context.seed_of("points"));
                let mut scrambles = 0..;
                let mut mean = in_batches(|| {
                    let batch = scrambles.by_ref().take(BATCH_SIZE);
                    let points = batch.flat_map(|number| points(seed, 0, number, POINTS));
                    let rays = points.map(|point| (ray(&mut rng), point));
                    let radiances = kind.radiances(setup, scene, rays);
                    let mean = |points: &[DVec3]| {
                        let values = points.iter().map(|point| mean_channel(scene, *point));
                        values.sum::<f64>() / f64::from(POINTS)
                    };
                    radiances.chunks(POINTS.into()).map(mean).collect()
                });
                outcome(n, &mut mean)
            }
        }
    }
}

/// Returns points of one scrambled Sobol' sequence. Strands and numbers have scrambles of their
/// own.
pub fn points(seed: u64, strand: u32, number: u32, count: u16) -> impl Iterator<Item = Sobol> {
    (0..count).map(move |index| {
        let fill = stream(seed, strand << 16 | u32::from(index), number);
        Sobol::new(index, scramble(seed, strand, number), fill)
    })
}

/// Returns the path in the library of an estimator.
pub fn path(kind: EstimatorKind) -> &'static str {
    match kind {
        EstimatorKind::Path
        | EstimatorKind::PathWithRrDepth
        | EstimatorKind::PathWith(..)
        | EstimatorKind::PathSpecularNee(..)
        | EstimatorKind::PathSpecularNeeMaxSegments(..) => "integrator::Path",
        EstimatorKind::Report(_) => "integrator::Report",
        EstimatorKind::Whitted(_) => "integrator::Whitted",
    }
}

/// A source of rays into a scene, from random numbers.
pub type Rays = fn(&mut Stream) -> Ray;

/// Begins a trial of the mean radiance that an estimator finds in a scene along rays.
pub fn radiance(
    name: &'static str,
    equation: &'static Equation,
    scene: &Arc<Scene>,
    kind: EstimatorKind,
    ray: Rays,
) -> Radiance {
    Radiance {
        name,
        equation,
        probe: Probe {
            scene: Arc::clone(scene),
            kind,
            ray,
        },
    }
}

/// A trial of a mean radiance that still lacks its [property and consequence](Self::states).
pub struct Radiance {
    name: &'static str,
    equation: &'static Equation,
    probe: Probe,
}

/// A trial of a mean radiance that still lacks its [reference](Self::by_rays).
pub struct StatedRadiance {
    radiance: Radiance,
    property: String,
    consequence: String,
}

impl Radiance {
    /// Sets the property, and the symptom in a renderer where it is false.
    pub fn states(
        self,
        property: impl Into<String>,
        consequence: impl Into<String>,
    ) -> StatedRadiance {
        StatedRadiance {
            radiance: self,
            property: property.into(),
            consequence: consequence.into(),
        }
    }
}

impl StatedRadiance {
    /// Returns the trial by independent rays: reference and relative δ as in [`mean_of`], and the
    /// number of rays at scale 1.
    pub fn by_rays(self, reference: f64, delta: f64, rays: u64) -> FamilyTrial<EstimatorSubject> {
        self.by_draws(reference, delta, Draws::Rays(rays))
    }

    /// Returns the trial by this many [scrambles](Draws::Scrambles) at scale 1.
    pub fn by_scrambles(
        self,
        reference: f64,
        delta: f64,
        scrambles: u64,
    ) -> FamilyTrial<EstimatorSubject> {
        self.by_draws(reference, delta, Draws::Scrambles(scrambles))
    }

    /// Returns the trial with this design and number of values.
    pub fn by_draws(
        self,
        reference: f64,
        delta: f64,
        draws: Draws,
    ) -> FamilyTrial<EstimatorSubject> {
        let Radiance {
            name,
            equation,
            probe,
        } = self.radiance;
        trial(
            name,
            self.property,
            self.consequence,
            equation,
            path(probe.kind),
            "t",
            with_parts(MeanRadiance {
                probe,
                reference,
                delta,
                draws,
            }),
        )
    }
}

/// Returns the largest of some errors. Unlike a maximum it keeps NaN.
pub fn largest(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}

/// Samples a direction uniformly over the sphere.
pub fn any_direction(rng: &mut Stream) -> DVec3 {
    whitefurnace::sampling::warp::sphere_zone(uniform2(rng), 1.0, [-1.0, 1.0])
}
