//! The most common trial of a whole estimator: the mean radiance along probe rays has a closed
//! form.
//!
//! The numbers of rays follow from δ and the noise of the estimator: the
//! [guard](whitefurnace::harness::guard) refuses a trial that could not detect its δ.

use rand::Rng;
use whitefurnace::sampling::rng::stream;
use whitefurnace::sampling::sampler::{SampleStream, Sobol, scramble};

use crate::prelude::*;
use crate::scenes::mean_channel;
use crate::subject::{in_batches, sample};

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
    /// Means over the points of one scrambled Sobol' sequence each, which choose the ray as well.
    /// Each point alone is uniform, so the expectation does not depend on how an estimator uses it,
    /// while smooth estimates vary much less.
    Scrambles {
        /// Rays per scramble.
        points: u16,
        /// Number of scrambles at scale 1.
        count: u64,
    },
}

impl Draws {
    /// Returns [`Scrambles`](Self::Scrambles) of so many points, and their number at scale 1.
    pub const fn scrambles(points: u16, count: u64) -> Self {
        Self::Scrambles { points, count }
    }
}

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
            Draws::Scrambles { points, count } => {
                let (seed, estimator) = (context.seed_of("points"), kind.estimator(setup));
                outcome(
                    count,
                    &mut scramble_means(seed, points, scene, estimator, ray),
                )
            }
        }
    }
}

/// Rays per batch of [`scramble_means`].
const BATCH: u16 = 1024;

/// Returns a source of means of the [`mean_channel`], one per call, each over rays by the points of
/// one scrambled Sobol' sequence.
pub fn scramble_means<'a>(
    seed: u64,
    count: u16,
    scene: &'a Scene,
    estimator: Box<dyn Estimator + 'a>,
    mut ray: impl FnMut(&mut SampleStream) -> Ray + 'a,
) -> impl FnMut() -> f64 + 'a {
    let mut scrambles = 0..;
    in_batches(move || {
        let batch = scrambles.by_ref().take((BATCH / count).max(1).into());
        let points = batch.flat_map(|number| points(seed, 0, number, count));
        let mut samples = points.map(|point| {
            let mut rng = SampleStream::from(point);
            sample(ray(&mut rng), rng)
        });
        let radiances = estimator.radiances(scene, &mut samples);
        let mean = |points: &[DVec3]| {
            let values = points.iter().map(|point| mean_channel(scene, *point));
            values.sum::<f64>() / f64::from(count)
        };
        radiances.chunks(count.into()).map(mean).collect()
    })
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
pub type Rays = fn(&mut SampleStream) -> Ray;

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

    /// Returns the trial by [scrambles](Draws::Scrambles) of so many points, and their number at
    /// scale 1.
    pub fn by_scrambles(
        self,
        reference: f64,
        delta: f64,
        points: u16,
        count: u64,
    ) -> FamilyTrial<EstimatorSubject> {
        self.by_draws(reference, delta, Draws::scrambles(points, count))
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
pub fn any_direction<R: Rng + ?Sized>(rng: &mut R) -> DVec3 {
    whitefurnace::sampling::warp::sphere_zone(uniform2(rng), 1.0, [-1.0, 1.0])
}
