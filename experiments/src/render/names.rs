//! What the command line calls scenes, estimators and their settings.

use std::ffi::OsStr;
use std::path::Path;

use clap::builder::{EnumValueParser, PossibleValue, TypedValueParser, ValueParserFactory};
use clap::error::ErrorKind;
use clap::{Arg, Command, ValueEnum};
use glam::DVec3;
use whitefurnace::material::ggx::Ggx;
use whitefurnace::material::{Bsdf, OrenNayar, OrenNayarForm};
use whitefurnace::scene::file::SceneFile;

/// The scenes that programs can name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SceneName {
    /// The report's final scene
    Report,
    /// The same room with Lambert surfaces only
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

/// What a job renders.
#[derive(Clone, Copy, Debug)]
pub enum SceneSource {
    /// A built-in scene
    Named(SceneName),
    /// A scene file, which was read once and stays as it was: jobs are copied freely
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
    /// The name or path on the command line.
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

/// Takes the name of a built-in scene, or reads the file if it ends in `.toml`.
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

/// The estimators that programs can name, in the order of figures and tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EstimatorName {
    /// Path tracing by directions and shadow rays, combined by multiple importance sampling
    Mis,
    /// Path tracing that finds lights by the directions of its paths alone
    Bsdf,
    /// Path tracing that finds lights by shadow rays alone
    Light,
    /// Particles from the lights, each hit connected to the camera
    LightTracer,
    /// Bidirectional path tracing: a camera path and a particle, connected in every way
    Bdpt,
    /// Bidirectional path tracing without connections between inner vertices: to lights and to the
    /// camera alone
    BdptEnds,
    /// Photon mapping with a kd-tree; its error bars leave out the noise of the photons that all
    /// pixels share
    Photon,
    /// Stochastic progressive photon mapping: each sample is a pass with photons of its own and a
    /// smaller radius
    Sppm,
    /// Finite elements for Lambert surfaces: no noise, but the error of a mesh
    Radiosity,
    /// Whitted ray tracing: shadow rays, mirror and glass tree, no indirect light
    Whitted,
    /// The report's: shadow rays, uniform hemisphere, roulette, at most 7 segments
    Report,
}

/// All estimators but those that [make images](EstimatorName::makes_images).
pub(super) const SINGLE_RAYS: &str =
    "estimators of single rays, not light-tracer, bdpt, bdpt-ends and sppm";

impl EstimatorName {
    /// Whether it makes whole images, from random points of pixels.
    pub(super) fn makes_images(self) -> bool {
        matches!(
            self,
            Self::LightTracer | Self::Bdpt | Self::BdptEnds | Self::Sppm
        )
    }

    /// Whether pixels share paths or photons, so that their standard errors do not tell that of a
    /// mean of pixels.
    pub(crate) fn shares_paths(self) -> bool {
        self.makes_images() || self == Self::Photon
    }
}

/// What follows the paths of estimators of single rays, as programs name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum EngineName {
    /// Eight paths at a time, in double precision
    #[default]
    Lanes,
    /// Sixteen in single precision: the same paths, rounded
    Single,
}

/// Whether more points tell what lights show directly, as programs name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum OutlinesName {
    /// Where the outline of a light crosses a pixel
    Yes,
    /// Nowhere: the samples alone tell
    #[default]
    No,
}

/// Whether pixels take more samples where a pilot has seen more noise, as programs name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum AdaptiveName {
    /// The more the larger the noise around them; --spp in the mean, and a pilot's on top
    Yes,
    /// All the same number
    #[default]
    No,
}

/// The light-transport conventions, as programs name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ConventionName {
    /// Energy-consistent light transport
    Physical,
    /// What the report's text describes
    Report,
    /// A hypothesis about the program that made the published figure 6
    Published,
}

impl ConventionName {
    /// The estimator that belongs to it.
    pub fn estimator(self) -> EstimatorName {
        match self {
            Self::Physical => EstimatorName::Mis,
            Self::Report | Self::Published => EstimatorName::Report,
        }
    }
}

/// The strategies of section 2.7, as programs name them.
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

/// Where random numbers come from, as programs name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SamplerName {
    /// A stream of its own for each sample
    Independent,
    /// Owen-scrambled Sobol' points, several scrambles per pixel
    Sobol,
}

/// How shadow rays of path tracing pick points on lights, as programs name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum LightSamplingName {
    /// Uniform in area
    Area,
    /// Uniform in the solid angle under which the light is seen
    SolidAngle,
    /// Spheres by solid angle, flat lights in area
    ByShape,
    /// The same, on lights that are picked by what they may contribute
    #[default]
    ByContribution,
}

/// The heuristics of multiple importance sampling, as programs name them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum HeuristicName {
    /// In proportion to the densities
    Balance,
    /// In proportion to their squares
    #[default]
    Power,
}

/// Whether shadow rays go by way of mirrors and glass as well, as programs name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum SpecularName {
    /// By way of flat mirrors and of spheres of mirror and glass
    #[default]
    Yes,
    /// Straight ones alone
    No,
}

/// The models of rough surfaces, as programs name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DiffuseName {
    /// Lambert, equation (13)
    Lambert,
    /// Equation (14) as the report prints it, with sin α sin β
    Printed,
    /// Equation (14) as Oren and Nayar have it, with sin α tan β
    Corrected,
    /// Energy-preserving Oren-Nayar
    Eon,
    /// A rough metal, GGX with α = σ: not diffuse
    Ggx,
}

impl DiffuseName {
    /// The diffuse ones, in the order in which figures show them.
    pub const ALL: [Self; 4] = [Self::Lambert, Self::Printed, Self::Corrected, Self::Eon];

    /// The model with the given albedo and σ in radians; EON gets the roughness of the same shape.
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

    /// How plots and tables name it.
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

/// The name that the command line uses for a value.
pub fn name<T: ValueEnum + Copy>(value: T) -> String {
    value
        .to_possible_value()
        .map_or_else(String::new, |value| value.get_name().to_owned())
}
