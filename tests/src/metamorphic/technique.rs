//! Techniques by which scenes are rendered: estimators with their settings.

use glam::DVec3;
use rand::Rng;
use whitefurnace::error::Error;
use whitefurnace::film::{Film, Pixel};
use whitefurnace::integrator::{
    Bdpt, Connections, DefaultParts, Heuristic, ImageEstimator, Path, Strategy,
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
use crate::subject::EstimatorParts;

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
    Path {
        strategy: Strategy,
        lights: LightSampling,
        heuristic: Heuristic,
        specular_nee: bool,
    },
    /// The default path tracer in single precision.
    Single,
    Bdpt(Connections),
}

const fn technique(name: &'static str, estimator: TechniqueKind) -> Technique {
    Technique {
        name,
        estimator,
        sampler: SamplerKind::Independent,
        silhouettes: false,
    }
}

const fn path(strategy: Strategy, lights: LightSampling, specular_nee: bool) -> TechniqueKind {
    TechniqueKind::Path {
        strategy,
        lights,
        heuristic: Heuristic::Power,
        specular_nee,
    }
}

/// The default of the program `render`.
const DEFAULT: TechniqueKind = path(Strategy::Mis, LightSampling::Importance, true);

/// All techniques; every two agree on every scene that both render.
pub const TECHNIQUES: [Technique; 11] = [
    technique("mis", DEFAULT),
    technique(
        "bsdf",
        path(Strategy::Bsdf, LightSampling::Importance, false),
    ),
    technique(
        "light",
        path(Strategy::Light, LightSampling::Importance, false),
    ),
    technique("mis-area", path(Strategy::Mis, LightSampling::Area, false)),
    technique(
        "mis-solid-angle",
        path(Strategy::Mis, LightSampling::SolidAngle, true),
    ),
    technique(
        "mis-balance",
        TechniqueKind::Path {
            strategy: Strategy::Mis,
            lights: LightSampling::SphereAngle,
            heuristic: Heuristic::Balance,
            specular_nee: true,
        },
    ),
    Technique {
        sampler: SamplerKind::Sobol(SAMPLES),
        ..technique("mis-sobol", DEFAULT)
    },
    Technique {
        silhouettes: true,
        ..technique("mis-silhouettes", DEFAULT)
    },
    technique("single", TechniqueKind::Single),
    technique("bdpt", TechniqueKind::Bdpt(Connections::All)),
    technique("bdpt-ends", TechniqueKind::Bdpt(Connections::Endpoints)),
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

    /// Returns whether it renders scenes with these materials.
    pub fn takes(&self, scene: &SceneText) -> bool {
        !matches!(self.estimator, TechniqueKind::Bdpt(_)) || !scene.uses(&["rough-glass"])
    }

    /// Returns whether its renders are made by the parts that they are given. Single precision has
    /// its own, the correct ones.
    pub fn uses_parts(&self) -> bool {
        self.estimator != TechniqueKind::Single
    }

    /// Returns the path tracer of the technique; `None` if it is another estimator.
    pub fn path<P>(&self, parts: P) -> Option<Path<P>> {
        let TechniqueKind::Path {
            strategy,
            lights,
            heuristic,
            specular_nee,
        } = self.estimator
        else {
            return None;
        };
        Some(Path {
            lights,
            heuristic,
            specular_nee,
            ..Path::new(parts, strategy)
        })
    }

    /// Renders images, each row by row from the top.
    ///
    /// # Errors
    /// [`Error::Option`] for a scene that single precision does not take, [`Error::Radiance`] for
    /// a value that no film can hold.
    pub fn images<P: EstimatorParts + Copy>(
        &self,
        parts: P,
        scene: &Scene,
        seed: u64,
        Images { count, samples }: Images,
    ) -> Result<Vec<Vec<DVec3>>, Error> {
        let sampling = Sampling {
            pixel: PixelSampling::Random,
            sampler: self.sampler,
            seed,
            silhouettes: self.silhouettes,
        };
        if let Some(estimator) = self.path(parts) {
            let renderer = RayRenderer {
                estimator,
                sampling,
            };
            return films(&renderer, scene, Images { count, samples });
        }
        match self.estimator {
            TechniqueKind::Bdpt(connections) => {
                let bdpt = Bdpt { parts, connections };
                let sampler = self.sampler;
                let image = |number: u32| {
                    let mut sum = vec![DVec3::ZERO; (RESOLUTION[0] * RESOLUTION[1]) as usize];
                    for index in number * samples..(number + 1) * samples {
                        let pass = ImagePass {
                            sampler,
                            seed,
                            index,
                        };
                        let image = bdpt.image(scene, RESOLUTION, pass)?;
                        for (sum, value) in sum.iter_mut().zip(image) {
                            *sum += value / f64::from(samples);
                        }
                    }
                    Ok(sum)
                };
                (0..count).map(image).collect()
            }
            TechniqueKind::Path { .. } | TechniqueKind::Single => {
                check_single_precision(scene)?;
                let path = Path {
                    lights: LightSampling::Importance,
                    heuristic: Heuristic::Power,
                    specular_nee: true,
                    ..Path::new(DefaultParts, Strategy::Mis)
                };
                let renderer = LaneRenderer {
                    estimator: LaneEstimator::Path(path),
                    sampling,
                    precision: Precision::Single,
                };
                films(&renderer, scene, Images { count, samples })
            }
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
