//! Trials of estimators of whole images: the means of their passes, against a closed form or
//! against the path tracer.

use whitefurnace::harness::mean::welch;
use whitefurnace::integrator::{Bdpt, Connections, ImageEstimator, LightTracer};
use whitefurnace::sampling::sampler::{ImagePass, SamplerKind};

use crate::images::not_a_film;
use crate::mean_radiance::scramble_means;
use crate::prelude::*;
use crate::scenes::mean_channel;

/// An estimator of whole images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageEstimatorKind {
    /// [`LightTracer`].
    LightTracer,
    /// [`Bdpt`] with all connections.
    Bdpt,
    /// [`Bdpt`] with connections to the endpoints only: lights and the eye.
    BdptEnds,
}

impl ImageEstimatorKind {
    /// Renders one pass; `None` if it has values that no film can hold, which is a fault.
    pub fn pass(
        self,
        parts: Parts<'_>,
        scene: &Scene,
        frame: [u32; 2],
        pass: ImagePass,
    ) -> Option<Vec<DVec3>> {
        let image = match self {
            Self::LightTracer => LightTracer { parts }.image(scene, frame, pass),
            Self::Bdpt => Bdpt::new(parts).image(scene, frame, pass),
            Self::BdptEnds => Bdpt {
                parts,
                connections: Connections::Endpoints,
            }
            .image(scene, frame, pass),
        };
        image.ok()
    }

    fn path(self) -> &'static str {
        match self {
            Self::LightTracer => "integrator::LightTracer",
            Self::Bdpt | Self::BdptEnds => "integrator::Bdpt",
        }
    }
}

/// A part of the image whose mean is on trial.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// Its name.
    pub name: &'static str,
    /// Whether the pixel (x, y) of a frame belongs to it.
    pub holds: fn([u32; 2], [u32; 2]) -> bool,
    /// δ, relative to the reference (absolute if that is 0).
    pub delta: f64,
}

/// The whole image.
pub const fn whole(delta: f64) -> Region {
    Region {
        name: "image mean",
        holds: |_, _| true,
        delta,
    }
}

/// Passes of an estimator of whole images. A replication is one value: the mean of many pixels,
/// nearly normal.
#[derive(Clone)]
pub struct Passes {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The estimator.
    pub kind: ImageEstimatorKind,
    /// Width and height of the image.
    pub frame: [u32; 2],
    /// Source of random numbers: independent, or Sobol' points with this many passes per
    /// replication.
    pub sampler: SamplerKind,
    /// Number of replications at scale 1.
    pub count: u64,
}

impl Passes {
    /// Returns the values of the mean [`mean_channel`] of each region, one per replication. Cubes
    /// are summed about the number beside the region.
    fn means(
        &self,
        context: &Context,
        parts: Parts<'_>,
        regions: &[(Region, f64)],
    ) -> Option<Vec<Values>> {
        let [width, height] = self.frame;
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        let inside: Vec<Vec<usize>> = regions
            .iter()
            .map(|(region, _)| {
                let holds = |(_, pixel): &(usize, [u32; 2])| (region.holds)(*pixel, self.frame);
                pixels
                    .clone()
                    .enumerate()
                    .filter(holds)
                    .map(|(i, _)| i)
                    .collect()
            })
            .collect();
        let mut values: Vec<_> = regions
            .iter()
            .map(|(_, centre)| Values::new(*centre))
            .collect();
        let (numbers, seed, passes) = (
            self.sampler,
            context.seed_of("passes"),
            self.sampler.samples(),
        );
        for replication in 0..context.n(self.count) as u32 {
            let mut sums = vec![DVec3::ZERO; regions.len()];
            for index in replication * passes..(replication + 1) * passes {
                let image = self.kind.pass(
                    parts,
                    &self.scene,
                    self.frame,
                    ImagePass {
                        sampler: numbers,
                        seed,
                        index,
                    },
                )?;
                for (sum, inside) in sums.iter_mut().zip(&inside) {
                    *sum += inside.iter().map(|&i| image[i]).sum::<DVec3>();
                }
            }
            for ((values, sum), inside) in values.iter_mut().zip(sums).zip(&inside) {
                values.push(
                    mean_channel(&self.scene, sum) / (inside.len() as f64 * f64::from(passes)),
                );
            }
        }
        Some(values)
    }
}

/// Compares the mean radiance of each region with its closed form.
struct MeanImage {
    passes: Passes,
    regions: Vec<(Region, f64)>,
}

impl Property for MeanImage {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let Some(means) = self.passes.means(context, setup.parts, &self.regions) else {
            return not_a_film("image");
        };
        let outcome = |((region, reference), values): (&(Region, f64), &Values)| {
            let claim = Claim::Equal {
                delta: region.delta * reference,
            };
            mean(region.name, values, *reference, claim)
        };
        self.regions.iter().zip(&means).map(outcome).collect()
    }
}

/// Returns a trial of regions whose mean radiance is `reference`, to within a δ relative to it; δ =
/// 0 claims it of every single pass.
pub fn image(
    name: &'static str,
    property: impl Into<String>,
    consequence: &'static str,
    equation: &'static Equation,
    passes: &Passes,
    reference: f64,
    regions: &[Region],
) -> FamilyTrial<EstimatorSubject> {
    let regions = regions.iter().map(|region| (*region, reference)).collect();
    image_of_regions(name, property, consequence, equation, passes, regions)
}

/// Returns a trial of regions, each with its own mean radiance, to within a δ relative to it.
pub fn image_of_regions(
    name: &'static str,
    property: impl Into<String>,
    consequence: &'static str,
    equation: &'static Equation,
    passes: &Passes,
    regions: Vec<(Region, f64)>,
) -> FamilyTrial<EstimatorSubject> {
    let same = MeanImage {
        passes: passes.clone(),
        regions,
    };
    trial(
        name,
        property,
        consequence,
        equation,
        passes.kind.path(),
        "t",
        with_parts(same),
    )
}

/// Compares the mean of the image with the path tracer's.
struct SameAsPath {
    passes: Passes,
    scrambles: u64,
    delta: f64,
}

/// Camera rays per scramble of the path tracer.
const POINTS: u16 = 64;

impl Property for SameAsPath {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let Passes { scene, frame, .. } = &self.passes;
        let [width, height] = frame.map(f64::from);
        let ray = |rng: &mut SampleStream| {
            let [x, y] = uniform2(rng);
            scene.camera().ray(*frame, width * x, height * y)
        };
        let (seed, by) = (context.seed_of("path tracer"), Box::new(Path::default()));
        let means = scramble_means(seed, POINTS, scene, by, ray);
        let path = Values::collect(0.0, context.n(self.scrambles), means);
        let mean = path.moments.mean();
        let regions = [(whole(self.delta), mean)];
        let means = self.passes.means(context, setup.parts, &regions);
        let Some(image) = means.as_deref().and_then(<[Values]>::first) else {
            return not_a_film("image");
        };
        let claim = Claim::Equal {
            delta: self.delta * mean,
        };
        vec![welch("image mean", image, &path, claim)]
    }
}

/// Returns a trial of equality with the path tracer, whose mean is over so many scrambles of camera
/// rays; `delta` is relative to it.
pub fn same_as_path(
    name: &'static str,
    property: impl Into<String>,
    consequence: &'static str,
    equation: &'static Equation,
    passes: &Passes,
    scrambles: u64,
    delta: f64,
) -> FamilyTrial<EstimatorSubject> {
    let same = SameAsPath {
        passes: passes.clone(),
        scrambles,
        delta,
    };
    trial(
        name,
        property,
        consequence,
        equation,
        passes.kind.path(),
        "Welch",
        with_parts(same),
    )
}
