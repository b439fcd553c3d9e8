//! Techniques by which scenes are rendered: estimators with their settings.

use glam::DVec3;
use rand::Rng;
use whitefurnace::error::Error;
use whitefurnace::film::{Film, Pixel};
use whitefurnace::integrator::{
    Bdpt, Connections, DefaultParts, Estimator, Heuristic, ImageEstimator, Path, Strategy,
};
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::render::{
    LaneEstimator, LaneRenderer, Precision, Renderer, check_single_precision, render,
};
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::sampler::{ImagePass, SamplerKind};
use whitefurnace::scene::Scene;

use super::scene::SceneText;
use crate::subject::EstimatorParts;

/// Width and height of the images: not square, so that rows and columns are told apart.
pub const RESOLUTION: [u32; 2] = [12, 8];
/// Samples per pixel of one image.
const SAMPLES: u32 = 64;

/// An estimator with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Technique {
    /// Its name.
    pub name: &'static str,
    estimator: TechniqueKind,
    numbers: SamplerKind,
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
        numbers: SamplerKind::Independent,
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
const DEFAULT: TechniqueKind = path(Strategy::Mis, LightSampling::ByContribution, true);

/// All techniques; every two agree on every scene that both render.
pub const TECHNIQUES: [Technique; 11] = [
    technique("mis", DEFAULT),
    technique(
        "bsdf",
        path(Strategy::Bsdf, LightSampling::ByContribution, false),
    ),
    technique(
        "light",
        path(Strategy::Light, LightSampling::ByContribution, false),
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
            lights: LightSampling::ByShape,
            heuristic: Heuristic::Balance,
            specular_nee: true,
        },
    ),
    Technique {
        numbers: SamplerKind::Sobol(SAMPLES),
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

    /// Renders one image, row by row from the top.
    ///
    /// # Errors
    /// [`Error::Option`] for a scene that single precision does not take, [`Error::Radiance`] for
    /// a value that no film can hold.
    pub fn image<P: EstimatorParts + Copy>(
        &self,
        parts: P,
        scene: &Scene,
        seed: u64,
    ) -> Result<Vec<DVec3>, Error> {
        let sampling = Sampling {
            pixel: PixelSampling::Random,
            numbers: self.numbers,
            seed,
            silhouettes: self.silhouettes,
        };
        match self.estimator {
            TechniqueKind::Path {
                strategy,
                lights,
                heuristic,
                specular_nee,
            } => film(sampling, |film, replications| {
                let path = Path {
                    lights,
                    heuristic,
                    specular_nee,
                    ..Path::new(parts, strategy)
                };
                render_all(scene, &path, sampling, film, replications)
            }),
            TechniqueKind::Single => {
                check_single_precision(scene)?;
                let path = Path {
                    lights: LightSampling::ByContribution,
                    heuristic: Heuristic::Power,
                    specular_nee: true,
                    ..Path::new(DefaultParts, Strategy::Mis)
                };
                let renderer = LaneRenderer {
                    estimator: LaneEstimator::Path(path),
                    sampling,
                    precision: Precision::Single,
                };
                film(sampling, |film, replications| {
                    renderer
                        .add(scene, film, 0..replications, &|_| true)
                        .map(|_| ())
                })
            }
            TechniqueKind::Bdpt(connections) => {
                let mut sum = vec![DVec3::ZERO; (RESOLUTION[0] * RESOLUTION[1]) as usize];
                for index in 0..SAMPLES {
                    let pass = ImagePass {
                        numbers: self.numbers,
                        seed,
                        index,
                    };
                    let image = Bdpt { parts, connections }.image(scene, RESOLUTION, pass)?;
                    for (sum, value) in sum.iter_mut().zip(image) {
                        *sum += value / f64::from(SAMPLES);
                    }
                }
                Ok(sum)
            }
        }
    }
}

fn render_all<E: Estimator>(
    scene: &Scene,
    estimator: &E,
    sampling: Sampling,
    film: &mut Film,
    replications: u32,
) -> Result<(), Error> {
    render(
        scene,
        estimator,
        sampling,
        film,
        &(0..replications),
        &|_| true,
    )
    .map(|_| ())
}

/// Returns the pixel means of a film that `add` adds a number of replications to.
fn film(
    sampling: Sampling,
    add: impl FnOnce(&mut Film, u32) -> Result<(), Error>,
) -> Result<Vec<DVec3>, Error> {
    let samples = sampling.samples_per_replication();
    let mut film = Film::new(RESOLUTION, None, samples)?;
    add(&mut film, SAMPLES / samples)?;
    Ok(film.pixels().iter().map(Pixel::mean).collect())
}
