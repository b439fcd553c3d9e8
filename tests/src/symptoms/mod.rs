//! Symptoms: faults as a user of a renderer meets them, each with a scene whose image shows it. The
//! same code renders both images, with the right parts or with the fault.

use whitefurnace::error::Error;
use whitefurnace::film::Pixel;
use whitefurnace::geometry::shape::Hit;
use whitefurnace::integrator::{
    ImageEstimator as _, Lookup, PhotonMapping, Sppm, TransportRules, Whitted,
};
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::rng::stream;
use whitefurnace::sampling::sampler::{ImagePass, Sampler, SamplerKind};
use whitefurnace::scene::file::Description;

use crate::images::{Frames, independent_film};
use crate::prelude::*;

/// Width and height of the images.
pub const SIZE: [u32; 2] = [80, 80];

/// A symptom, with its cause.
pub struct Symptom {
    /// Its name in numbers and files.
    pub key: &'static str,
    /// The mistake in one line.
    pub wrong: &'static str,
    /// The quantity by which it shows.
    pub shown_by: ShownBy,
    scene: TestScene,
    method: Method,
    mistake: Mistake,
}

/// The quantity that a mistake changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShownBy {
    /// The expectation of pixels.
    Mean,
    /// The variance of pixels.
    Noise,
    /// The covariance of pixels that are neighbours in a row.
    Pattern,
}

/// A scene, as a file's text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TestScene {
    Cornell,
    Balls,
    Lamp,
    Water,
    Shelf,
    Rough,
}

/// An estimator with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Method {
    Path(Strategy),
    /// Path tracing by both strategies with every ray through the middle of its pixel, so that all
    /// noise is that of the paths.
    Centred,
    Whitted,
    /// Photons of one map, looked up within a radius.
    Photons(f64),
    /// Photons of several maps, looked up within shrinking radii.
    Sppm(f64),
}

/// A mistake: a faulty part, or a change where no part can be replaced.
enum Mistake {
    Part(Box<PartTable>),
    /// The pixel and the sample whose random numbers a sample of a pixel gets.
    Streams(fn([u32; 2], u32) -> ([u32; 2], u32)),
    /// The camera's directions ahead, to the right and upwards, where the last number is half of a
    /// pixel at distance 1.
    Camera(fn([DVec3; 3], f64) -> [DVec3; 3]),
}

/// Particles of one map of photons.
const PARTICLES: u32 = 30_000;

impl TestScene {
    fn text(self) -> &'static str {
        match self {
            Self::Cornell => include_str!("../../../src/scene/files/cornell.toml"),
            Self::Balls => include_str!("balls.toml"),
            Self::Lamp => include_str!("lamp.toml"),
            Self::Water => include_str!("water.toml"),
            Self::Shelf => include_str!("shelf.toml"),
            Self::Rough => include_str!("rough.toml"),
        }
    }
}

/// Returns the faulty parts of a fault of whole estimators or of photon mapping, and the mistake in
/// one line.
///
/// # Panics
/// If there is no such fault, which is a mistake in the table of symptoms.
fn part(name: &str) -> (&'static str, Mistake) {
    let mut faults = crate::estimator::faults();
    faults.extend(crate::photon::faults::faults());
    let found = faults.iter().find(|fault| fault.name == name);
    let subject =
        found.and_then(|fault| Some((fault.wrong, Mistake::Part(Box::new(fault.subject.parts?)))));
    subject.unwrap_or_else(|| panic!("no fault {name} of a part"))
}

/// Returns all symptoms, in the order of the book's page.
pub fn all() -> Vec<Symptom> {
    use Method::{Path, Photons, Sppm, Whitted};
    use ShownBy::{Mean, Noise, Pattern};
    use Strategy::{Light, Mis};
    use TestScene::{Balls, Cornell, Lamp, Rough, Shelf, Water};
    let of_part = |key, fault, scene, method| {
        let (wrong, mistake) = part(fault);
        Symptom {
            key,
            wrong,
            shown_by: Mean,
            scene,
            method,
            mistake,
        }
    };
    let by_camera = |key, wrong, change| Symptom {
        key,
        wrong,
        shown_by: Mean,
        scene: Cornell,
        method: Path(Mis),
        mistake: Mistake::Camera(change),
    };
    let by_streams = |key, wrong, shown_by, share| Symptom {
        key,
        wrong,
        shown_by,
        scene: Cornell,
        method: Method::Centred,
        mistake: Mistake::Streams(share),
    };
    vec![
        of_part("dark", "area-twice", Cornell, Path(Light)),
        of_part("bright", "no-pi", Cornell, Whitted),
        of_part("dark-grazing", "cosine-doubled", Lamp, Path(Mis)),
        of_part("bright-grazing", "cosine-dropped", Lamp, Path(Light)),
        of_part("dark-rim", "printed-oren-nayar", Rough, Path(Light)),
        of_part("dark-bounces", "no-roulette-weight", Cornell, Path(Mis)),
        of_part("dark-in-glass", "no-radiance-factor", Water, Path(Mis)),
        of_part(
            "no-total-reflection",
            "no-total-reflection",
            Water,
            Path(Mis),
        ),
        of_part("straight-glass", "not-refracted", Balls, Path(Mis)),
        of_part("wrong-mirror", "mirror-sign", Balls, Path(Mis)),
        of_part("no-shadows", "shadows-ignored", Cornell, Path(Light)),
        of_part("hard-shadows", "light-centre", Cornell, Path(Light)),
        of_part("lit-behind", "back-shines", Lamp, Path(Light)),
        of_part("bright-far", "distance-not-squared", Lamp, Path(Light)),
        of_part("twice", "counted-twice", Cornell, Path(Mis)),
        of_part("no-caustics", "lost-without-pdf", Balls, Path(Mis)),
        of_part("caustics-twice", "shadows-pass-glass", Balls, Path(Mis)),
        of_part(
            "colours-exchanged",
            "channels-exchanged",
            Cornell,
            Path(Mis),
        ),
        of_part("colours-strong", "albedo-squared", Cornell, Path(Mis)),
        by_camera(
            "mirrored",
            "the camera's right is its left",
            |[ahead, right, up], _| [ahead, -right, up],
        ),
        by_camera(
            "shifted",
            "rays pass through the corner of a pixel for its middle",
            |[ahead, right, up], half| [ahead + half * (right - up), right, up],
        ),
        Symptom {
            shown_by: Noise,
            ..of_part("fireflies", "equal-weights", Cornell, Path(Mis))
        },
        by_streams(
            "noise-stays",
            "a pixel gets the random numbers of its first two samples again and again",
            Noise,
            |pixel, sample| (pixel, sample % 2),
        ),
        by_streams(
            "pattern",
            "blocks of eight columns share their random numbers",
            Pattern,
            |[x, y], sample| ([x / 8, y], sample),
        ),
        of_part("leak", "either-side", Shelf, Photons(0.1)),
        of_part("bright-corners", "round-corners", Shelf, Photons(0.1)),
        of_part("blurred", "radius-kept", Balls, Sppm(0.2)),
    ]
}

/// An estimator that takes random numbers of other pixels and samples for those that it is given.
struct SharedStreams {
    path: Path<'static>,
    seed: u64,
    sample: u32,
    share: fn([u32; 2], u32) -> ([u32; 2], u32),
}

impl Estimator for SharedStreams {
    fn radiance(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, _: &mut dyn Sampler) -> DVec3 {
        let ahead = ray.origin + ray.direction;
        let Some(seen) = scene.camera().project(SIZE, ahead) else {
            return DVec3::NAN;
        };
        let ([x, y], sample) = (self.share)(seen.pixel, self.sample);
        let mut rng = stream(self.seed, y * SIZE[0] + x, sample);
        self.path.radiance(scene, ray, hit, &mut rng)
    }
}

impl Symptom {
    /// Names scene and method, which decide the right image.
    pub fn setup(&self) -> String {
        format!("{:?} by {:?}", self.scene, self.method)
    }

    /// Returns the right image of a seed, row by row from the top.
    ///
    /// # Errors
    /// None for these scenes; the type is that of [`whitefurnace::render::render`].
    pub fn right(&self, seed: u64, samples: u32) -> Result<Vec<DVec3>, Error> {
        self.image(&self.scene()?, Parts::replaced(&CORRECT), seed, samples)
    }

    /// Returns the wrong image of a seed, row by row from the top.
    ///
    /// # Errors
    /// None for these scenes; the type is that of [`whitefurnace::render::render`].
    pub fn wrong(&self, seed: u64, samples: u32) -> Result<Vec<DVec3>, Error> {
        match &self.mistake {
            Mistake::Part(parts) => {
                self.image(&self.scene()?, Parts::replaced(&**parts), seed, samples)
            }
            Mistake::Streams(share) => self.streams(*share, seed, samples),
            Mistake::Camera(change) => {
                let scene = self.scene()?;
                let camera = turned(scene.camera(), *change);
                self.image(
                    &scene.with_camera(camera)?,
                    Parts::replaced(&CORRECT),
                    seed,
                    samples,
                )
            }
        }
    }

    fn scene(&self) -> Result<Scene, Error> {
        Description::parse(&format!("{:?}", self.scene), self.scene.text())?.build()
    }

    fn image(
        &self,
        scene: &Scene,
        parts: Parts<'_>,
        seed: u64,
        samples: u32,
    ) -> Result<Vec<DVec3>, Error> {
        let pixel = PixelSampling::Random;
        let whole = |index| ImagePass {
            sampler: SamplerKind::Independent,
            seed,
            index,
        };
        match self.method {
            Method::Path(strategy) => {
                let path = Path::new(strategy).with_parts(parts);
                film(scene, &path, pixel, seed, samples)
            }
            Method::Centred => {
                let path = Path::new(Strategy::Mis).with_parts(parts);
                film(scene, &path, PixelSampling::Centre, seed, samples)
            }
            Method::Whitted => {
                let whitted = Whitted {
                    parts,
                    segments: 7,
                    rules: TransportRules::PHYSICAL,
                };
                film(scene, &whitted, pixel, seed, samples)
            }
            Method::Photons(radius) => {
                let lookup = Lookup::DirectVisualization;
                let map = PhotonMapping::new(parts, scene, lookup, PARTICLES, radius, whole(0))?;
                film(scene, &map, pixel, seed, samples)
            }
            Method::Sppm(radius) => {
                let sppm = Sppm {
                    parts,
                    particles: PARTICLES,
                    radius,
                };
                mean_image(samples, |index| sppm.image(scene, SIZE, whole(index)))
            }
        }
    }

    /// Renders as [`Method::Centred`] with the random numbers that `share` hands out.
    fn streams(
        &self,
        share: fn([u32; 2], u32) -> ([u32; 2], u32),
        seed: u64,
        samples: u32,
    ) -> Result<Vec<DVec3>, Error> {
        let scene = self.scene()?;
        mean_image(samples, |sample| {
            let estimator = SharedStreams {
                path: Path::new(Strategy::Mis),
                seed,
                sample,
                share,
            };
            film(&scene, &estimator, PixelSampling::Centre, seed, 1)
        })
    }
}

/// Returns the mean of so many images.
fn mean_image(
    count: u32,
    image: impl Fn(u32) -> Result<Vec<DVec3>, Error>,
) -> Result<Vec<DVec3>, Error> {
    let mut mean = vec![DVec3::ZERO; (SIZE[0] * SIZE[1]) as usize];
    for index in 0..count {
        for (mean, value) in mean.iter_mut().zip(image(index)?) {
            *mean += value / f64::from(count);
        }
    }
    Ok(mean)
}

/// Renders an image.
fn film(
    scene: &Scene,
    estimator: &dyn Estimator,
    pixel: PixelSampling,
    seed: u64,
    samples: u32,
) -> Result<Vec<DVec3>, Error> {
    let frames = Frames::first(scene, SIZE, samples.into());
    let film = independent_film(&frames, estimator, pixel, seed)?;
    Ok(film.pixels().iter().map(Pixel::mean).collect())
}

/// Returns a camera with other directions.
///
/// # Panics
/// If they are not valid, which is a mistake in the table of symptoms.
fn turned(camera: &Camera, change: fn([DVec3; 3], f64) -> [DVec3; 3]) -> Camera {
    let (directions, half_height) = camera.frame();
    let [forward, right, up] = change(directions, half_height / f64::from(SIZE[1]));
    let line = |name: &str, DVec3 { x, y, z }: DVec3| format!("{name}={x} {y} {z}\n");
    let text = [
        line("eye", camera.eye),
        line("forward", forward),
        line("right", right),
        line("up", up),
        format!("half-height={half_height}\n"),
    ];
    match Camera::parse(&text.concat()) {
        Some(camera) => camera,
        None => panic!("no camera: {text:?}"),
    }
}
