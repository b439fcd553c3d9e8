//! References that nobody here wrote: images that the authors of Mitsuba 3 have rendered and
//! committed to judge their own integrators, of scenes that need only what this project has.
//!
//! Their tests allow mean errors of 1.5 to 5 %. Here each image is judged by its mean, and its 64
//! tiles by theirs. Where the radiance has a closed form, their images are within 10⁻⁴ of it.

pub mod cornell;

use std::collections::HashMap;

use rand::RngExt;
use whitefurnace::harness::images::{PixelStatistics, welch_map};
use whitefurnace::harness::mean::MIN_SYMMETRIC_VALUES;
use whitefurnace::sampling::warp::uniform_hemisphere;
use whitefurnace::scene::file::Description;

use crate::mean_radiance::points;
use crate::prelude::*;
use crate::scenes::valid;

/// Tiles across and down.
const TILES: usize = 8;
/// Width and height of an image whose pixels are the tiles.
const SIZE: [u32; 2] = [TILES as u32; 2];
/// Camera rays through each tile in a replication: the points of one scrambled Sobol' sequence.
const POINTS: u16 = 4;
/// Samples of each tile of the references.
const THEIR_SAMPLES: u64 = 12_000 * 16 * 16;
/// Variance of the references, per sample, in units of ours. Their samples are not stratified over
/// tiles as ours are; four times is more than any scene here has without strata.
const THEIR_VARIANCE: u64 = 4;
/// Share of the image's mean below which a tile is faint: so few rays find its light that the mean
/// of its samples is far from normal. Faint tiles are judged as a part of the image alone.
const FAINT: f64 = 0.01;

/// One of their scenes, with one channel of their image.
#[derive(Clone, Copy)]
struct Reference {
    /// Name of the trial.
    name: &'static str,
    /// Scene file.
    scene: &'static str,
    /// Name in the table of tiles.
    image: &'static str,
    /// Red is 0, green 1.
    channel: usize,
    /// Longest path in segments, with the camera ray: their `max_depth`.
    segments: u32,
    /// Relative δ of the mean of the image.
    delta: f64,
    /// Number of replications at scale 1.
    replications: u64,
    /// Whether tiles are judged: faults of what the eye sees directly leave no noise in them.
    tiles_are_judged: bool,
    /// The scene, in words.
    about: &'static str,
    /// Symptom of a renderer whose image differs.
    consequence: &'static str,
}

const REFERENCES: [Reference; 7] = [
    Reference {
        name: "references/mitsuba/sky",
        scene: include_str!("mitsuba-diffuse-albedo.toml"),
        image: "diffuse_albedo",
        channel: 1,
        segments: 2,
        delta: CLOSED_FORM_DELTA,
        replications: 9_000,
        tiles_are_judged: true,
        about: "a ball in a plane under a uniform sky",
        consequence: "a ball outdoors is brighter or darker than in Mitsuba, as is the floor by it",
    },
    Reference {
        name: "references/mitsuba/two-bounces-red",
        scene: include_str!("mitsuba-diffuse-albedo-g-i.toml"),
        image: "diffuse_albedo_g_i",
        channel: 0,
        segments: 3,
        delta: CLOSED_FORM_DELTA,
        replications: MIN_SYMMETRIC_VALUES,
        tiles_are_judged: true,
        about: "a ball in a plane beside a coloured wall, red after two bounces",
        consequence: "a coloured wall tints its neighbours more or less than it does in Mitsuba",
    },
    Reference {
        name: "references/mitsuba/two-bounces-green",
        scene: include_str!("mitsuba-diffuse-albedo-g-i.toml"),
        image: "diffuse_albedo_g_i",
        channel: 1,
        segments: 3,
        delta: CLOSED_FORM_DELTA,
        replications: 9_700,
        tiles_are_judged: true,
        about: "a ball in a plane beside a coloured wall, green after two bounces",
        consequence: "colour bleeding has another hue than in Mitsuba, as green differs from red",
    },
    Reference {
        name: "references/mitsuba/light-and-shadow",
        scene: include_str!("mitsuba-area-light-radiance.toml"),
        image: "area_light_radiance",
        channel: 1,
        segments: 2,
        delta: IMAGE_DELTA,
        replications: 9_900,
        tiles_are_judged: true,
        about: "a ball and its shadow beside an upright light",
        consequence: "the shadow of a ball is missing, or lighter or darker than in Mitsuba",
    },
    Reference {
        name: "references/mitsuba/light-below",
        scene: include_str!("mitsuba-translate-plane-and-area-emitter.toml"),
        image: "translate_plane_and_area_emitter",
        channel: 1,
        segments: 2,
        delta: BOUNCES_DELTA,
        replications: MIN_SYMMETRIC_VALUES,
        tiles_are_judged: true,
        about: "a slanted square over a light",
        consequence: "a lamp lights what it sees at a slant as brightly as what it faces",
    },
    Reference {
        name: "references/mitsuba/visible-light",
        scene: include_str!("mitsuba-directly-visible-area-light-radiance.toml"),
        image: VISIBLE_LIGHT,
        channel: 1,
        segments: 2,
        delta: CLOSED_FORM_DELTA,
        replications: 23_000,
        tiles_are_judged: false,
        about: "a square light in the dark",
        consequence: "a lamp that the eye sees is missing, or has another size than in Mitsuba",
    },
    Reference {
        name: "references/mitsuba/square-under-sky",
        scene: include_str!("mitsuba-translate-diffuse-rectangle-constant.toml"),
        image: SQUARE_UNDER_SKY,
        channel: 1,
        segments: 2,
        delta: CLOSED_FORM_DELTA,
        replications: 12_400,
        tiles_are_judged: true,
        about: "a grey square before a uniform sky",
        consequence: "flat things outdoors are brighter or darker than in Mitsuba, or of another size",
    },
];

/// Images whose mean has a closed form, with a square light and with a grey square.
const VISIBLE_LIGHT: &str = "directly_visible_area_light_radiance";
const SQUARE_UNDER_SKY: &str = "translate_diffuse_rectangle_constant";

/// Mitsuba's default: half of the image's height at distance 1 for 50 mm on the diagonal of 36 x 24
/// mm.
const HALF_HEIGHT: f64 = 0.305_941_170_815_567_1;

/// Returns the image mean by Mitsuba and the closed form of two scenes: a square of side 2 at
/// distance 4 fills a share of the image, which is a light in the dark, or half as bright as the
/// sky around it.
pub fn squares() -> [[f64; 2]; 2] {
    let filled = (1.0 / (4.0 * HALF_HEIGHT)).powi(2);
    let mean = |image| {
        let tiles = tiles(image, 1);
        tiles.iter().sum::<f64>() / tiles.len() as f64
    };
    [
        [mean(VISIBLE_LIGHT), filled],
        [mean(SQUARE_UNDER_SKY), 1.0 - 0.5 * filled],
    ]
}

/// Returns the 64 means of the tiles of an image, row by row from the top.
///
/// # Panics
/// If the table does not have them.
fn tiles(image: &str, channel: usize) -> Vec<f64> {
    let channel = ["R", "G", "B"][channel];
    let rows: HashMap<&str, Vec<f64>> = include_str!("tiles.tsv")
        .lines()
        .filter_map(|line| {
            let (key, rest) = line.split_once('\t')?;
            let (of, rest) = rest.split_once('\t')?;
            let (row, numbers) = rest.split_once('\t')?;
            let numbers = numbers.split('\t').map(|number| number.parse().ok());
            (key == image && of == channel).then_some((row, numbers.collect::<Option<_>>()?))
        })
        .collect();
    let all: Vec<f64> = (0..TILES)
        .flat_map(|row| rows[row.to_string().as_str()].clone())
        .collect();
    assert_eq!(all.len(), TILES * TILES, "tiles of {image}");
    all
}

/// Compares the image of a path tracer with a reference: its mean and its tiles.
struct SameAsReference {
    scene: Arc<Scene>,
    reference: Reference,
    tiles: Vec<f64>,
}

impl SameAsReference {
    /// Returns the mean of each tile in one replication.
    fn replication(&self, setup: Configuration<'_>, seed: u64, number: u32) -> Vec<f64> {
        let camera = self.scene.camera();
        let tiles = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
        let rays = tiles.flat_map(|[x, y]| {
            points(seed, y * SIZE[0] + x, number, POINTS).map(move |mut point| {
                let [u, v]: [f64; 2] = [point.random(), point.random()];
                (camera.ray(SIZE, f64::from(x) + u, f64::from(y) + v), point)
            })
        });
        let kind = EstimatorKind::PathSpecularNeeMaxSegments(self.reference.segments);
        let values = kind.radiances(setup, &self.scene, rays);
        let mean = |points: &[DVec3]| {
            let sum: f64 = points.iter().map(|l| l[self.reference.channel]).sum();
            sum / f64::from(POINTS)
        };
        values.chunks(POINTS.into()).map(mean).collect()
    }
}

impl Property for SameAsReference {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let theirs = self.tiles.iter().sum::<f64>() / self.tiles.len() as f64;
        let mut image = Values::new(theirs);
        let mut tiles: Vec<Values> = self.tiles.iter().map(|mean| Values::new(*mean)).collect();
        let (seed, n) = (
            context.seed_of("image"),
            context.n(self.reference.replications),
        );
        for number in 0..n as u32 {
            let means = self.replication(setup, seed, number);
            image.push(means.iter().sum::<f64>() / means.len() as f64);
            tiles
                .iter_mut()
                .zip(means)
                .for_each(|(values, mean)| values.push(mean));
        }
        let is_faint = |mean: f64| 0.0 < mean && mean < FAINT * theirs;
        // A tile that is black on both sides has no p-value.
        let unless_faint = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let faint = self.tiles.iter().map(|mean| is_faint(*mean)).enumerate();
            faint
                .map(|(i, faint)| if faint { 0.0 } else { of(i) })
                .collect()
        };
        let means = unless_faint(&|i| tiles[i].moments.mean());
        let variances = unless_faint(&|i| tiles[i].moments.variance());
        let expected = unless_faint(&|i| self.tiles[i]);
        let ours = PixelStatistics {
            mean: &means,
            variance: &variances,
            count: &vec![n; tiles.len()],
        };
        let reference = PixelStatistics {
            mean: &expected,
            variance: &variances,
            count: &vec![THEIR_SAMPLES / u64::from(POINTS) / THEIR_VARIANCE; tiles.len()],
        };
        let claim = Claim::Equal {
            delta: self.reference.delta * theirs,
        };
        let mut outcomes = vec![mean("image mean", &image, theirs, claim)];
        if self.reference.tiles_are_judged {
            outcomes.push(welch_map(&ours, &reference, TILES, 1).smallest("tiles", n));
        }
        outcomes
    }
}

/// Trials against references and the faults that they see.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let trial_of = |reference: Reference| {
        let description = Description::parse("reference", reference.scene);
        let same = SameAsReference {
            scene: valid(description.and_then(|scene| scene.build())),
            reference,
            tiles: tiles(reference.image, reference.channel),
        };
        trial(
            reference.name,
            format!("the image of {} is Mitsuba's reference", reference.about),
            reference.consequence,
            &RENDERING,
            "integrator::Path",
            "t, Welch map",
            with_parts(same),
        )
    };
    let images = Family {
        trials: REFERENCES.map(trial_of).into(),
        faults: faults(),
        ..Family::whole("references", STANDARD)
    };
    vec![Box::new(images), cornell::family()]
}

fn faults() -> Vec<Fault<EstimatorSubject>> {
    let segments = |segments| EstimatorSubject {
        segments: Some(segments),
        ..STANDARD
    };
    vec![
        fault!("albedo-low", RENDERING, "every surface reflects 3 % less",
            { brdf: |bsdf, wo, wi| 0.97 * DefaultParts.brdf(bsdf, wo, wi) },
            "references/mitsuba/sky: image mean", "references/mitsuba/two-bounces-red: image mean",
            "references/mitsuba/two-bounces-green: image mean",
            "references/mitsuba/light-and-shadow: image mean",
            "references/mitsuba/light-below: image mean",
            "references/mitsuba/square-under-sky: image mean | tiles"),
        fault!("lights-unseen", RENDERING, "lights that the eye sees are black",
            { counts_emission: |_, sampled| sampled },
            "references/mitsuba/visible-light: image mean"),
        fault!("no-shadow", GEOMETRY, "every point is in sight of every other",
            { visible: |_, _, _, _| true },
            "references/mitsuba/light-and-shadow: tiles"),
        fault!("uniform-directions", HEMISPHERE_PDF, "uniform directions with the weight of cosine-distributed ones",
            { cosine_hemisphere: uniform_hemisphere },
            "references/mitsuba/sky: tiles", "references/mitsuba/two-bounces-red: tiles",
            "references/mitsuba/two-bounces-green: tiles"),
        fault!("bounce-left-out", PATH_LENGTH, "one bounce less than said",
            = segments(2), "references/mitsuba/two-bounces-red: tiles",
            "references/mitsuba/two-bounces-green: tiles"),
        fault!("one-sided-cosine", GEOMETRY, "the cosine at the light is left out",
            { solid_angle_per_area: |_, distance_squared| 1.0 / distance_squared },
            "references/mitsuba/light-below: tiles"),
    ]
}
