//! Names of scenes, estimators and their settings on the command line.

use std::ffi::OsStr;
use std::path::Path;

use clap::builder::{EnumValueParser, PossibleValue, TypedValueParser, ValueParserFactory};
use clap::error::ErrorKind;
use clap::{Arg, Command, ValueEnum};
use glam::DVec3;
use whitefurnace::material::ggx::Ggx;
use whitefurnace::material::{Bsdf, OrenNayar, OrenNayarForm};
use whitefurnace::scene::file::SceneFile;

/// Built-in scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SceneName {
    /// The report's final scene
    Report,
    /// The report's room with Lambert surfaces only
    DiffuseRoom,
    /// White sphere, mirror and glass in a uniform environment: every pixel is 1
    Environment,
    /// Closed cube of albedo 0.75 whose walls emit: every pixel is 4
    FurnaceBox,
    /// Spherical cavity of albedo 0.75 with an emitting cap: off the cap every pixel is 0.75
    CavityCap,
    /// Glass cube in a uniform environment: every pixel is 1
    GlassCube,
    /// The Cornell box
    Cornell,
}

/// Scene of a job.
#[derive(Clone, Copy, Debug)]
pub enum SceneSource {
    /// A built-in scene
    Named(SceneName),
    /// A scene file, read once and leaked, so that jobs can be copied
    File(&'static SceneFile),
}

impl From<SceneName> for SceneSource {
    fn from(name: SceneName) -> Self {
        Self::Named(name)
    }
}

impl PartialEq<SceneName> for SceneSource {
    fn eq(&self, name: &SceneName) -> bool {
        matches!(self, Self::Named(own) if own == name)
    }
}

impl SceneSource {
    /// Returns the name or path as the command line gives it.
    pub fn name(self) -> String {
        match self {
            Self::Named(scene) => name(scene),
            Self::File(file) => file.path.display().to_string(),
        }
    }

    /// Prints the notes of a scene file on standard error, a line each.
    pub fn print_notes(self) {
        if let Self::File(file) = self {
            file.notes.iter().for_each(|note| eprintln!("note: {note}"));
        }
    }
}

/// Parser that takes the name of a built-in scene, or reads the file if it ends in `.toml`.
#[derive(Clone)]
pub struct SceneParser;

impl TypedValueParser for SceneParser {
    type Value = SceneSource;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &OsStr,
    ) -> Result<SceneSource, clap::Error> {
        let path = Path::new(value);
        if path.extension().is_none_or(|extension| extension != "toml") {
            return Ok(EnumValueParser::<SceneName>::new()
                .parse_ref(command, arg, value)?
                .into());
        }
        let refuse = |error| {
            clap::Error::raw(ErrorKind::ValueValidation, format!("{error}\n")).with_cmd(command)
        };
        let file = SceneFile::load(path).map_err(refuse)?;
        Ok(SceneSource::File(Box::leak(Box::new(file))))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let names = SceneName::value_variants()
            .iter()
            .filter_map(SceneName::to_possible_value);
        Some(Box::new(names))
    }
}

impl ValueParserFactory for SceneSource {
    type Parser = SceneParser;

    fn value_parser() -> SceneParser {
        SceneParser
    }
}

/// Estimators, in the order of figures and tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EstimatorName {
    /// Path tracing by BSDF sampling and next-event estimation, combined by multiple importance
    /// sampling
    #[value(alias = "path")]
    Mis,
    /// Path tracing by BSDF sampling alone
    Bsdf,
    /// Path tracing by next-event estimation alone
    Light,
    /// Light tracing: particles from the lights, each hit connected to the camera
    LightTracer,
    /// Bidirectional path tracing: a camera path and a light path, connected in every way
    Bdpt,
    /// Bidirectional path tracing without connections between inner vertices: to lights and to the
    /// camera alone
    BdptEnds,
    /// Photon mapping with a kd-tree; its error bars leave out the noise of the photons, which all
    /// pixels share
    Photon,
    /// Stochastic progressive photon mapping: each sample is a pass with its own photons and a
    /// smaller radius
    Sppm,
    /// Finite elements for Lambert surfaces: no noise, but discretization error
    Radiosity,
    /// Whitted ray tracing: shadow rays, mirror and glass tree, no indirect light
    Whitted,
    /// The report's estimator: shadow rays, uniform hemisphere sampling, Russian roulette, at most
    /// 7 segments
    Report,
}

/// The estimators of single rays in words, as against those
/// [of images](EstimatorName::is_image_estimator).
pub(super) const SINGLE_RAY_ESTIMATORS: &str =
    "estimators of single rays, not light-tracer, bdpt, bdpt-ends and sppm";

impl EstimatorName {
    /// Returns true if the estimator renders whole images, from random points of pixels.
    pub(super) fn is_image_estimator(self) -> bool {
        matches!(
            self,
            Self::LightTracer | Self::Bdpt | Self::BdptEnds | Self::Sppm
        )
    }

    /// Returns true if pixels share paths or photons, so that their standard errors do not give
    /// that of a mean over pixels.
    pub(crate) fn has_correlated_pixels(self) -> bool {
        self.is_image_estimator() || self == Self::Photon
    }
}

/// Precision in which paths of estimators of single rays are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PrecisionName {
    /// Eight paths at a time, in double precision
    #[value(alias = "lanes")]
    Double,
    /// Sixteen paths at a time, in single precision: the same paths, rounded
    Single,
}

/// Whether the outlines of directly visible lights are supersampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SilhouettesName {
    /// Supersample pixels that the outline of a light crosses
    Yes,
    /// No supersampling
    No,
}

/// Whether noisier pixels take more samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AdaptiveName {
    /// More samples where the first ones, a pilot, showed more noise; --spp on average
    Yes,
    /// The same number of samples in all pixels
    No,
}

/// Light-transport conventions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ConventionName {
    /// Energy-consistent light transport
    Physical,
    /// The rules that the report's text describes
    Report,
    /// A hypothesis about the program that made the published figure 6
    Published,
}

impl ConventionName {
    /// Returns the default estimator of the convention.
    pub fn estimator(self) -> EstimatorName {
        match self {
            Self::Physical => EstimatorName::Mis,
            Self::Report | Self::Published => EstimatorName::Report,
        }
    }
}

/// Pixel sampling strategies of section 2.7.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PixelName {
    /// Every ray through the pixel's centre
    Centre,
    /// The centres of n × n sub-pixels
    Grid,
    /// Random points
    Random,
    /// A random point in each of n × n sub-pixels
    Jitter,
}

/// Sources of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SamplerName {
    /// An independent stream for each sample
    Independent,
    /// Owen-scrambled Sobol' points, several scrambles per pixel
    Sobol,
}

/// How shadow rays of path tracing pick points on lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightSamplingName {
    /// Uniform in area
    Area,
    /// Uniform in the solid angle that the light subtends
    SolidAngle,
    /// Spheres by solid angle, flat lights in area
    #[value(alias = "by-shape")]
    SphereAngle,
    /// As sphere-angle, on a light picked in proportion to its estimated contribution
    #[value(alias = "by-contribution")]
    Importance,
}

/// Heuristics of multiple importance sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HeuristicName {
    /// Weights in proportion to the pdfs
    Balance,
    /// Weights in proportion to the squared pdfs
    Power,
}

/// Whether shadow rays also reach lights through mirrors and glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SpecularNeeName {
    /// Also through specular chains: flat mirrors, and spheres of mirror or glass
    Yes,
    /// Straight shadow rays only
    No,
}

/// Models of rough surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DiffuseName {
    /// Lambert, equation (13)
    Lambert,
    /// Equation (14) as the report prints it, with sin α sin β
    Printed,
    /// Equation (14) as in Oren and Nayar's paper, with sin α tan β
    Corrected,
    /// Energy-preserving Oren-Nayar
    Eon,
    /// A rough metal, GGX with α = σ: not diffuse
    Ggx,
}

impl DiffuseName {
    /// Diffuse models, in the order in which figures show them.
    pub const ALL: [Self; 4] = [Self::Lambert, Self::Printed, Self::Corrected, Self::Eon];

    /// Returns the model with the given albedo and σ in radians; EON gets the roughness of the same
    /// shape.
    pub fn bsdf(self, albedo: DVec3, sigma: f64) -> Bsdf {
        match self {
            Self::Lambert => Bsdf::Lambert { albedo },
            Self::Printed => Bsdf::oren_nayar(albedo, sigma, OrenNayarForm::Printed),
            Self::Corrected => Bsdf::oren_nayar(albedo, sigma, OrenNayarForm::Corrected),
            Self::Eon => Bsdf::Eon {
                albedo,
                roughness: OrenNayar::new(sigma).roughness(),
            },
            Self::Ggx => Bsdf::model(Ggx {
                reflectance: albedo,
                alpha: sigma,
            }),
        }
    }

    /// Returns the name in plots and tables.
    pub fn title(self) -> &'static str {
        match self {
            Self::Lambert => "Lambert",
            Self::Printed => "Oren–Nayar as printed",
            Self::Corrected => "Oren–Nayar corrected",
            Self::Eon => "EON",
            Self::Ggx => "GGX",
        }
    }
}

/// Returns the name of a value on the command line.
pub fn name<T: ValueEnum + Copy>(value: T) -> String {
    value
        .to_possible_value()
        .map_or_else(String::new, |value| value.get_name().to_owned())
}
