//! Rendering in single precision: with the same random numbers the image has the same mean as in
//! double precision.
//!
//! Most samples differ by rounding alone. In a few of a million the path takes another course,
//! because an edge or a decision lay between the roundings; they differ by as much as a sample can
//! be worth, and so rarely that their skewness cannot be estimated. So the trials use scenes whose
//! samples are bounded, take every sample as a value, and a confidence interval for bounded values.
//! It holds for samples of different pixels, too: the variance within pixels is at most that of all
//! values.

use whitefurnace::error::Error;
use whitefurnace::film::Film;
use whitefurnace::harness::mean::bounded_mean;
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::math::simd::SINGLES;
use whitefurnace::render::{LaneEstimator, LaneRenderer, Precision, Renderer, render_lanes};
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::file::{Description, Object};

use crate::images::{CHANNEL_WEIGHTS, not_a_film};
use crate::prelude::*;
use crate::scenes::{TINT, valid};

/// Roundings of the numbers that describe a scene in single precision, and of its pixels; faults
/// are other roundings.
#[derive(Clone, Copy)]
pub struct Roundings {
    /// Coordinates of vertices, centres and radii.
    pub length: fn(f64) -> f64,
    /// Albedos and reflectances.
    pub albedo: fn(f64) -> f64,
    /// Radiances of lights.
    pub radiance: fn(f64) -> f64,
    /// Indices of refraction.
    pub index: fn(f64) -> f64,
    /// The value of the pixel of this number.
    pub pixel: fn(usize, DVec3) -> DVec3,
}

const CORRECT: Roundings = Roundings {
    length: |x| x,
    albedo: |x| x,
    radiance: |x| x,
    index: |x| x,
    pixel: |_, value| value,
};

/// Rounds to the nearest number with `BITS` significant bits.
fn rounded<const BITS: i32>(x: f64) -> f64 {
    in_units::<BITS>(x, f64::round)
}

/// Makes a number a whole multiple of the last of its `BITS` significant bits.
fn in_units<const BITS: i32>(x: f64, whole: fn(f64) -> f64) -> f64 {
    if x == 0.0 {
        return x;
    }
    let unit = 2_f64.powi(x.abs().log2().floor() as i32 + 1 - BITS);
    whole(x / unit) * unit
}

/// Significant bits of a number of bfloat16, which has half the length of a single, and of an RGBE
/// file.
const BFLOAT: i32 = 8;

/// A scene whose numbers can be rounded, and the path tracer that renders it.
struct Image {
    description: Description,
    path: Path<'static>,
    /// Upper bound of a sample, in units of the lights' radiance.
    most: f64,
}

impl Image {
    /// Builds the scene with its numbers rounded, which can make surfaces coincide.
    fn scene(&self, rounded: &Roundings) -> Result<Scene, Error> {
        let mut scene = self.description.clone();
        let vector =
            |v: &mut DVec3, of: fn(f64) -> f64| *v = DVec3::from_array(v.to_array().map(of));
        for (_, surface) in &mut scene.materials {
            vector(&mut surface.emission, rounded.radiance);
            match &mut surface.bsdf {
                Bsdf::Lambert { albedo } => vector(albedo, rounded.albedo),
                Bsdf::Mirror { reflectance } => vector(reflectance, rounded.albedo),
                Bsdf::Glass { index } => *index = (rounded.index)(*index),
                _ => {}
            }
        }
        for object in &mut scene.objects {
            match object {
                Object::Rectangle { corner, edges, .. } => {
                    [corner]
                        .into_iter()
                        .chain(edges)
                        .for_each(|v| vector(v, rounded.length));
                }
                Object::Sphere { sphere, .. } => {
                    vector(&mut sphere.centre, rounded.length);
                    sphere.radius = (rounded.length)(sphere.radius);
                }
                Object::Mesh { vertices, .. } => {
                    vertices.iter_mut().for_each(|v| vector(v, rounded.length));
                }
            }
        }
        scene.build()
    }

    fn run(&self, context: &Context, subject: &Roundings) -> Vec<Outcome> {
        let double = valid(self.scene(&CORRECT));
        let single = match self.scene(subject) {
            Ok(scene) => scene,
            // One scene is wrong.
            Err(error) => return vec![Outcome::identity("scene", 1, 1.0, 0.0, error.to_string())],
        };
        let bound = (1.0 + ROUNDING) * self.most * LAMP * TINT.dot(CHANNEL_WEIGHTS);
        let mut differences = Values::new(0.0);
        for replication in 0..context.n(SAMPLES).div_ceil(PIXELS) as u32 {
            let Some(films) = self.films(context, [&double, &single], replication) else {
                return not_a_film("film");
            };
            for (number, (double, single)) in
                films[0].pixels().iter().zip(films[1].pixels()).enumerate()
            {
                let difference = (subject.pixel)(number, single.mean()) - double.mean();
                differences.push(difference.dot(CHANNEL_WEIGHTS));
            }
        }
        let claim = Claim::Equal {
            delta: DELTA * bound,
        };
        vec![bounded_mean(
            "difference",
            &differences,
            0.0,
            [-bound, bound],
            claim,
        )]
    }

    /// Renders the same samples in double and in single precision.
    fn films(&self, context: &Context, scenes: [&Scene; 2], replication: u32) -> Option<[Film; 2]> {
        let seed = context.seed_of("image");
        let sampling = Sampling {
            pixel: PixelSampling::Random,
            sampler: SamplerKind::Independent,
            seed,
            silhouettes: false,
        };
        let path = LaneEstimator::Path(self.path);
        let mut films = [
            Film::new(SIZE, None, 1).ok()?,
            Film::new(SIZE, None, 1).ok()?,
        ];
        let range = replication..replication + 1;
        render_lanes(scenes[0], path, sampling, &mut films[0], &range, &|_| true).ok()?;
        let singles = LaneRenderer {
            estimator: path,
            sampling,
            precision: Precision::Single,
        };
        singles
            .add(scenes[1], &mut films[1], range, &|_| true)
            .ok()?;
        Some(films)
    }
}

const SIZE: [u32; 2] = [64, 48];
const PIXELS: u64 = 64 * 48;
/// Bound of the relative growth of a sample through rounding.
const ROUNDING: f64 = 1e-5;
/// Number of pairs of samples.
const SAMPLES: u64 = 2_560_000;
/// δ, relative to the upper bound of a sample.
const DELTA: f64 = 1e-4;
/// Radiance of the lights, as far as can be from a number of 8 bits.
const LAMP: f64 = 2.0 + 0.5 / 64.0 - 1e-5;

/// Returns a path tracer whose paths end at lights only, or by roulette once their throughput is
/// below 1/2, so that no throughput exceeds 1.
fn until_light(strategy: Strategy) -> Path<'static> {
    Path {
        rr_depth: 1_000,
        lights: LightSampling::Importance,
        ..Path::new(strategy)
    }
}

/// A cube whose ceiling and one wall emit, with a coloured ball. All its numbers lie between those
/// of 8 bits.
const ROOM: &str = r#"
    camera = { eye = [0.06, 0, 0], target = [0.9, 0.5, -0.4], up = [0, 0, 1], fov_deg = 70 }
    materials.lamp = { model = "black", emission = 1 }
    materials.red = { model = "lambert", albedo = [0.8017, 0.4018, 0.3008] }
    materials.green = { model = "lambert", albedo = [0.4018, 0.7517, 0.6033] }
    materials.white = { model = "lambert", albedo = [0.7517, 0.7517, 0.8494] }

    [[objects]]
    shape = "mesh"
    vertices = [
        [-1.0033, -1.0033, -0.7515], [1.0033, -1.0033, -0.7515], [1.0033, 1.0033, -0.7515], [-1.0033, 1.0033, -0.7515],
        [-1.0033, -1.0033, 1.0035], [1.0033, -1.0033, 1.0035], [1.0033, 1.0033, 1.0035], [-1.0033, 1.0033, 1.0035],
    ]
    [objects.faces]
    lamp = [[4, 7, 6, 5], [0, 4, 5, 1]]
    white = [[0, 1, 2, 3], [3, 7, 4, 0]]
    red = [[1, 5, 6, 2]]
    green = [[2, 6, 7, 3]]

    [[objects]]
    shape = "sphere"
    material = "green"
    centre = [0.7007, 0.1001, -0.5013]
    radius = 0.2507
"#;

/// A glass ball around the camera of [`ROOM`], which is so near to its centre that no light is
/// trapped.
const GLASS: &str = r#"
    [materials.glass]
    model = "glass"
    index = 1.5116

    [[objects]]
    shape = "sphere"
    material = "glass"
    centre = [0.05, 0.02, -0.03]
    radius = 0.2504
"#;

/// A ball that sees nothing but lights of every shape, one of them in front of another.
const LIGHTS: &str = r#"
    camera = { eye = [0, -2.5, 0.5], target = [0, 0, 0], up = [0, 0, 1], fov_deg = 16 }
    materials.lamp = { model = "black", emission = 1 }
    materials.clay = { model = "lambert", albedo = [0.9004, 0.7517, 0.8494] }

    [[objects]]
    shape = "sphere"
    material = "clay"
    centre = [0, 0, 0]
    radius = 0.5017

    [[objects]]
    shape = "rectangle"
    material = "lamp"
    corner = [-1.5035, -1.5035, 1.1994]
    edges = [[0, 3.007, 0], [3.007, 0, 0]]

    [[objects]]
    shape = "sphere"
    material = "lamp"
    centre = [-0.9007, -1.1994, 0.3001]
    radius = 0.4012

    [[objects]]
    shape = "mesh"
    vertices = [[1.1994, -2.0075, -1.5035], [1.1994, 1.0033, -1.0033], [1.1994, -0.5017, 1.1035]]
    faces = { lamp = [[0, 2, 1]] }
"#;

/// Reads a scene and sets its lamps' radiance to [`LAMP`].
fn described(name: &str, text: &str) -> Description {
    let description = Description::parse(name, text);
    let mut description = description.unwrap_or_else(|error| panic!("{error}"));
    for (name, surface) in &mut description.materials {
        if name == "lamp" {
            surface.emission = LAMP * TINT;
        }
    }
    description
}

fn coloured_room() -> Image {
    Image {
        description: described("coloured room", ROOM),
        path: until_light(Strategy::Bsdf),
        most: 1.0,
    }
}

/// Paths from within glass: radiance grows by the square of the index on entering.
fn within_glass() -> Image {
    Image {
        description: described("within glass", &format!("{ROOM}{GLASS}")),
        most: 1.5116 * 1.5116,
        ..coloured_room()
    }
}

/// The report's room with mirror and glass under a lamp that is as large as the ceiling allows.
fn report_room() -> Image {
    let mut description = described("report", include_str!("../../src/scene/files/report.toml"));
    for object in &mut description.objects {
        if let Object::Rectangle { corner, edges, .. } = object {
            *corner = DVec3::new(0.0, -5.9, 4.999);
            *edges = [11.8 * DVec3::Y, 10.01 * DVec3::X];
        }
    }
    Image {
        description,
        ..coloured_room()
    }
}

/// Lights of several shapes. Each point of the ball receives at most its albedo times a light's
/// radiance by a shadow ray, and as much again by BSDF sampling.
fn several_lights() -> Image {
    Image {
        description: described("several lights", LIGHTS),
        path: until_light(Strategy::Mis),
        most: 2.0 * 0.9004,
    }
}

/// Trials and faults of rendering in single precision.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let same = |name: &str, what: &str, consequence: &str, image: Image| {
        trial(
            format!("images/single-precision/{name}"),
            format!("{what} have the same mean in single as in double precision"),
            consequence,
            &SINGLE_PRECISION,
            "render::ByLanes, render::render_lanes",
            "empirical Bernstein",
            move |context: &Context, subject| image.run(context, &subject),
        )
    };
    vec![Box::new(Family {
        trials: vec![
            same(
                "coloured-room",
                "paths in a room of coloured walls",
                "coloured walls change their hue or brightness in the fast single-precision mode",
                coloured_room(),
            ),
            same(
                "within-glass",
                "paths from within glass",
                "glass lets through more or less light in single precision",
                within_glass(),
            ),
            same(
                "report",
                "paths in the report's room, with mirror and glass",
                "rooms with mirrors and glass are darker in single precision, as rays are lost",
                report_room(),
            ),
            same(
                "several-lights",
                "hits and shadow rays to a sphere, a rectangle and a triangle",
                "lamps light things differently in single precision, as they shift or lose rays",
                several_lights(),
            ),
        ],
        faults: vec![
            fault!("albedos-in-bfloat", SINGLE_PRECISION, "albedos and reflectances are rounded to 8 bits",
                = Roundings { albedo: rounded::<BFLOAT>, ..CORRECT },
                "images/single-precision/coloured-room"),
            fault!("vertices-in-bfloat", SINGLE_PRECISION, "coordinates and radii are rounded to 8 bits",
                = Roundings { length: rounded::<BFLOAT>, ..CORRECT },
                // The lamp comes to lie in the ceiling.
                "images/single-precision/several-lights", "images/single-precision/report: scene"),
            fault!("indices-in-bfloat", SINGLE_PRECISION, "indices of refraction are rounded to 8 bits",
                = Roundings { index: rounded::<BFLOAT>, ..CORRECT },
                "images/single-precision/within-glass"),
            fault!("radiance-in-rgbe", SINGLE_PRECISION, "the radiance of lights has the 8 bits of an RGBE file",
                = Roundings { radiance: rounded::<BFLOAT>, ..CORRECT },
                "images/single-precision/coloured-room", "images/single-precision/within-glass",
                "images/single-precision/report", "images/single-precision/several-lights"),
            fault!("pixels-cut", SINGLE_PRECISION, "pixels are cut to 8 bits, not rounded",
                = Roundings { pixel: |_, value| value.map(|x| in_units::<BFLOAT>(x, f64::floor)), ..CORRECT },
                "images/single-precision/several-lights", "images/single-precision/report"),
            fault!("a-lane-lost", SINGLE_PRECISION, "of sixteen lanes one has no radiance",
                = Roundings { pixel: |number, value| if number % SINGLES == 5 { DVec3::ZERO } else { value }, ..CORRECT },
                "images/single-precision/report", "images/single-precision/within-glass"),
        ],
        ..Family::whole("singles", CORRECT)
    })]
}
