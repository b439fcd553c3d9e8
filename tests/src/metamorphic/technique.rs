//! Techniques by which scenes are rendered: unbiased estimators with their settings. Photon mapping
//! and radiosity, which are biased, are left out.

use glam::DVec3;
use rand::Rng;
use whitefurnace::error::Error;
use whitefurnace::film::{Film, Pixel};
use whitefurnace::integrator::{
    Bdpt, Connections, Heuristic, ImageEstimator, LightTracer, Parts, Path, Report, Strategy,
    TransportRules,
};
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::render::{
    LaneEstimator, LaneRenderer, Precision, RayRenderer, Renderer, check_single_precision,
};
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::sampler::{ImagePass, SamplerKind};
use whitefurnace::scene::Scene;

use super::scene::SceneText;

/// Width and height of the images: not square, so that rows and columns are told apart.
pub const RESOLUTION: [u32; 2] = [12, 8];
/// Samples per pixel of an image of the hunt, and of all images by Sobol' points.
pub const SAMPLES: u32 = 64;

/// An estimator with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Technique {
    /// Its name.
    pub name: &'static str,
    estimator: TechniqueKind,
    sampler: SamplerKind,
    silhouettes: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum TechniqueKind {
    Path(PathSettings),
    /// The default path tracer in single precision.
    Single,
    Bdpt(Connections),
    /// The report's estimator under physical rules, without a limit on segments that matters.
    Report,
    LightTracer,
}

/// Settings of a path tracer.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PathSettings {
    strategy: Strategy,
    lights: LightSampling,
    heuristic: Heuristic,
    specular_nee: bool,
}

impl PathSettings {
    /// Returns the path tracer with these parts.
    fn tracer(self, parts: Parts<'_>) -> Path<'_> {
        Path {
            lights: self.lights,
            heuristic: self.heuristic,
            specular_nee: self.specular_nee,
            ..Path::new(self.strategy).with_parts(parts)
        }
    }
}

/// Ray segments after which the report's estimator stops: longer paths carry less than
/// rounding in scenes whose surfaces absorb.
const SEGMENTS: u32 = 200;

const fn technique(name: &'static str, estimator: TechniqueKind) -> Technique {
    Technique {
        name,
        estimator,
        sampler: SamplerKind::Independent,
        silhouettes: false,
    }
}

const fn path(strategy: Strategy, lights: LightSampling, specular_nee: bool) -> PathSettings {
    PathSettings {
        strategy,
        lights,
        heuristic: Heuristic::Power,
        specular_nee,
    }
}

const fn path_tracer(name: &'static str, settings: PathSettings) -> Technique {
    technique(name, TechniqueKind::Path(settings))
}

/// The default of the program `render`.
const DEFAULT: PathSettings = path(Strategy::Mis, LightSampling::Importance, true);

/// All techniques; every two agree on every scene that both render.
pub const TECHNIQUES: [Technique; 13] = [
    path_tracer("mis", DEFAULT),
    path_tracer(
        "bsdf",
        path(Strategy::Bsdf, LightSampling::Importance, false),
    ),
    path_tracer(
        "light",
        path(Strategy::Light, LightSampling::Importance, false),
    ),
    path_tracer("mis-area", path(Strategy::Mis, LightSampling::Area, false)),
    path_tracer(
        "mis-solid-angle",
        path(Strategy::Mis, LightSampling::SolidAngle, true),
    ),
    path_tracer(
        "mis-balance",
        PathSettings {
            heuristic: Heuristic::Balance,
            ..path(Strategy::Mis, LightSampling::SphereAngle, true)
        },
    ),
    Technique {
        sampler: SamplerKind::Sobol(SAMPLES),
        ..path_tracer("mis-sobol", DEFAULT)
    },
    Technique {
        silhouettes: true,
        ..path_tracer("mis-silhouettes", DEFAULT)
    },
    technique("single", TechniqueKind::Single),
    technique("bdpt", TechniqueKind::Bdpt(Connections::All)),
    technique("bdpt-ends", TechniqueKind::Bdpt(Connections::Endpoints)),
    technique("report", TechniqueKind::Report),
    technique("light-tracer", TechniqueKind::LightTracer),
];

impl Technique {
    /// Returns the technique of a name.
    pub fn named(name: &str) -> Option<Self> {
        TECHNIQUES.into_iter().find(|one| one.name == name)
    }

    /// Picks one that renders the scene.
    pub fn pick(scene: &SceneText, rng: &mut impl Rng) -> Self {
        loop {
            let one = TECHNIQUES[rng.next_u32() as usize % TECHNIQUES.len()];
            if one.takes(scene) {
                return one;
            }
        }
    }

    /// Returns whether it renders all light of the scene, with noise that a few images show: the
    /// report's estimator meets the lobes of GGX by chance only.
    pub fn takes(&self, scene: &SceneText) -> bool {
        match self.estimator {
            TechniqueKind::Path(_) | TechniqueKind::Single => true,
            TechniqueKind::Bdpt(_) => !scene.uses(&["rough-glass"]),
            TechniqueKind::Report => !scene.uses(&["ggx", "rough-glass"]),
            TechniqueKind::LightTracer => {
                scene.background.is_black() && !scene.uses(&["mirror", "glass", "rough-glass"])
            }
        }
    }

    /// Returns whether its renders are made by the parts that they are given. Single precision has
    /// its own, the correct ones.
    pub fn uses_parts(&self) -> bool {
        self.estimator != TechniqueKind::Single
    }

    /// Returns the path tracer of the technique; `None` if it is another estimator.
    pub fn path<'a>(&self, parts: Parts<'a>) -> Option<Path<'a>> {
        match self.estimator {
            TechniqueKind::Path(settings) => Some(settings.tracer(parts)),
            _ => None,
        }
    }

    /// Renders images, each row by row from the top.
    ///
    /// # Errors
    /// [`Error::Option`] for a scene that single precision does not take, [`Error::Radiance`] for
    /// a value that no film can hold.
    pub fn images(
        &self,
        parts: Parts<'_>,
        scene: &Scene,
        seed: u64,
        images: Images,
    ) -> Result<Vec<Vec<DVec3>>, Error> {
        let sampling = Sampling {
            pixel: PixelSampling::Random,
            sampler: self.sampler,
            seed,
            silhouettes: self.silhouettes,
        };
        match self.estimator {
            TechniqueKind::Path(settings) => {
                let renderer = RayRenderer {
                    estimator: settings.tracer(parts),
                    sampling,
                };
                films(&renderer, scene, images)
            }
            TechniqueKind::Report => {
                let estimator = Report {
                    parts,
                    rays: 1,
                    segments: SEGMENTS,
                    rules: TransportRules::PHYSICAL,
                };
                let renderer = RayRenderer {
                    estimator,
                    sampling,
                };
                films(&renderer, scene, images)
            }
            TechniqueKind::Single => {
                check_single_precision(scene)?;
                let path = DEFAULT.tracer(Parts::default());
                let renderer = LaneRenderer {
                    estimator: LaneEstimator::Path(path),
                    sampling,
                    precision: Precision::Single,
                };
                films(&renderer, scene, images)
            }
            TechniqueKind::Bdpt(connections) => {
                passes(&Bdpt { parts, connections }, scene, sampling, images)
            }
            TechniqueKind::LightTracer => passes(&LightTracer { parts }, scene, sampling, images),
        }
    }
}

/// Number of images, and samples per pixel of each; at least a replication.
#[derive(Clone, Copy, Debug)]
pub struct Images {
    /// Number of images.
    pub count: u32,
    /// Samples per pixel.
    pub samples: u32,
}

/// Returns the pixel means of a film for each image.
fn films(renderer: &dyn Renderer, scene: &Scene, images: Images) -> Result<Vec<Vec<DVec3>>, Error> {
    let per_replication = renderer.samples_per_replication();
    let replications = images.samples.div_ceil(per_replication);
    let prepared = renderer.prepare(scene, RESOLUTION)?;
    let image = |number: u32| {
        let mut film = Film::new(RESOLUTION, None, per_replication)?;
        let range = number * replications..(number + 1) * replications;
        prepared.add(&mut film, range, &|_| true)?;
        Ok(film.pixels().iter().map(Pixel::mean).collect())
    };
    (0..images.count).map(image).collect()
}

/// Returns the mean of the passes of an estimator of whole images, for each image.
fn passes(
    estimator: &dyn ImageEstimator,
    scene: &Scene,
    Sampling { sampler, seed, .. }: Sampling,
    Images { count, samples }: Images,
) -> Result<Vec<Vec<DVec3>>, Error> {
    let image = |number: u32| {
        let mut sum = vec![DVec3::ZERO; (RESOLUTION[0] * RESOLUTION[1]) as usize];
        for index in number * samples..(number + 1) * samples {
            let pass = ImagePass {
                sampler,
                seed,
                index,
            };
            let image = estimator.image(scene, RESOLUTION, pass)?;
            for (sum, value) in sum.iter_mut().zip(image) {
                *sum += value / f64::from(samples);
            }
        }
        Ok(sum)
    };
    (0..count).map(image).collect()
}
