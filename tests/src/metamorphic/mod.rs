//! Random scenes under metamorphic relations: statements about renders of any scene that need no
//! reference, such as that a scene and its camera may be moved together.
//!
//! [`generate()`] makes a scene file from a seed, [`Case::check`] tests a [`Relation`] on it, and
//! [`reduce()`] looks for the smallest scene file that still breaks it. The program `metamorphic`
//! hunts with all three; the trials of this module run a few fixed scenes.

mod background;
mod generate;
mod reciprocity;
mod reduce;
mod relations;
mod scene;
mod technique;
pub mod trials;

use glam::DVec3;
use whitefurnace::error::Error;
use whitefurnace::harness::images::{Rules, Side, compare};
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::integrator::Parts;
use whitefurnace::math::moments::FIXED_POINT_UNIT;
use whitefurnace::sampling::rng::{seed_for, stream};
use whitefurnace::scene::Scene;

pub use background::{Background, Sky};
pub use generate::generate;
pub use reduce::reduce;
pub use relations::{Part, RELATIONS, Relation};
pub use scene::{Material, Object, SceneText, Similarity, View};
use technique::{Images, SAMPLES};
pub use technique::{RESOLUTION, TECHNIQUES, Technique};

use crate::subject::PartTable;

/// A relation on a scene.
#[derive(Clone)]
pub struct Case {
    /// The relation.
    pub relation: &'static Relation,
    /// The technique of its renders.
    pub technique: Technique,
    /// The scene.
    pub scene: SceneText,
    /// Seed of its choices and of the images.
    pub seed: u64,
}

/// Result of a case.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// No difference, and the means are equal within 1 %.
    Holds,
    /// No difference, but noise may hide one of 1 %.
    Undecided,
    /// The relation does not apply to the scene.
    NotApplicable,
    /// A program would refuse one of the scenes, with this message.
    Refused(String),
    /// The sides differ, in words.
    Fails(String),
}

/// Returns the relation of a name.
pub fn relation_named(name: &str) -> Option<&'static Relation> {
    RELATIONS.iter().find(|relation| relation.name == name)
}

/// Parts of estimators of which one is wrong.
#[derive(Clone, Copy)]
pub struct FaultyParts {
    /// Name of the fault.
    pub name: &'static str,
    /// The error in one line.
    pub wrong: &'static str,
    /// The parts.
    pub parts: PartTable,
}

/// Returns the faults of whole estimators that replace a part of the path tracers.
pub fn faults() -> Vec<FaultyParts> {
    crate::estimator::faults()
        .into_iter()
        .filter_map(|fault| {
            let parts = fault.subject.parts?;
            Some(FaultyParts {
                name: fault.name,
                wrong: fault.wrong,
                parts,
            })
        })
        .collect()
}

/// Images of each side of a first look, and of the looks that confirm a difference. Few images may
/// lack rare bright paths, and their spread does not show it; the last look has most of them.
const IMAGES: [u32; 3] = [8, 32, 512];
/// Levels of the looks. A difference must be seen in all, so a right renderer whose brightest paths
/// are seen fails a case with a probability of at most 1e-15.
const LEVELS: [f64; 3] = [1e-3, 1e-6, 1e-6];
/// Differences below this fraction are rounding, by which the sides may differ; that of single
/// precision is larger.
const ROUNDING: f64 = 1e-3;

/// Rounding of a pixel's mean in the fixed-point sums of films, a few units.
const FILM_ROUNDING: f64 = 16.0 * FIXED_POINT_UNIT;

/// Tests the random scene of a seed under all relations, each by a random technique, until one
/// fails. Cases that `takes` refuses are left out.
pub fn test_scene(seed: u64, parts: Parts<'_>, takes: fn(&Case) -> bool) -> Vec<(Case, Found)> {
    let scene = generate(seed);
    let mut all = Vec::new();
    for relation in &RELATIONS {
        let case = Case::of(relation, &scene, seed);
        if !takes(&case) {
            continue;
        }
        let found = case.check(parts);
        let fails = matches!(found, Found::Fails(_));
        all.push((case, found));
        if fails {
            break;
        }
    }
    all
}

/// A render of a side with its scene built.
struct Render {
    part: Part,
    scene: Scene,
}

/// Renders the images of a side, each the sum over its renders.
fn images_of(
    parts: Parts<'_>,
    side: &[Render],
    seed: u64,
    images: Images,
) -> Result<Vec<Vec<DVec3>>, Error> {
    let mut sums = vec![Vec::new(); images.count as usize];
    for (number, Render { part, scene }) in side.iter().enumerate() {
        let seed = seed_for(seed, &format!("render {number}"));
        let rendered = part.technique.images(parts, scene, seed, images)?;
        for (sum, image) in sums.iter_mut().zip(rendered) {
            add(sum, (part.adjust)(image));
        }
    }
    Ok(sums)
}

impl Case {
    /// Creates the case of a relation on a scene, with a random technique.
    pub fn of(relation: &'static Relation, scene: &SceneText, seed: u64) -> Self {
        let mut rng = stream(seed_for(seed, relation.name), 0, 0);
        Self {
            relation,
            technique: Technique::pick(scene, &mut rng),
            scene: scene.clone(),
            seed,
        }
    }

    /// Returns whether all its renders are made by the parts that [`check`](Self::check) is given.
    pub fn uses_parts(&self) -> bool {
        let sides = self.sides();
        let mut renders = sides.iter().flatten().flatten();
        renders.all(|part| part.technique.uses_parts())
    }

    /// Tests the relation by the images that these parts of estimators make.
    pub fn check(&self, parts: Parts<'_>) -> Found {
        let found = || {
            let Some(sides) = self.renders()? else {
                return Ok(Found::NotApplicable);
            };
            let mut found = Found::Undecided;
            for (count, level) in IMAGES.into_iter().zip(LEVELS) {
                found = self.look(parts, &sides, count, level)?;
                if !matches!(found, Found::Fails(_)) {
                    break;
                }
            }
            Ok(found)
        };
        found().unwrap_or_else(|error: Error| match error {
            Error::Scene { .. } | Error::Option(_) => Found::Refused(error.to_string()),
            _ => Found::Fails(error.to_string()),
        })
    }

    /// Returns the two sides of the relation; `None` where it does not apply to the scene.
    pub fn sides(&self) -> Option<[Vec<Part>; 2]> {
        let mut rng = stream(seed_for(self.seed, self.relation.name), 1, 0);
        (self.relation.sides)(&self.scene, self.technique, &mut rng)
    }

    /// Returns the two sides with their scenes built.
    fn renders(&self) -> Result<Option<[Vec<Render>; 2]>, Error> {
        let build = |part: Part| {
            let scene = part.scene.build()?;
            Ok(Render { part, scene })
        };
        let build_all =
            |parts: Vec<Part>| parts.into_iter().map(build).collect::<Result<_, Error>>();
        let Some([first, second]) = self.sides() else {
            return Ok(None);
        };
        Ok(Some([build_all(first)?, build_all(second)?]))
    }

    /// Compares `count` images of each side at a level, or one of each under one seed where the
    /// relation is exact.
    fn look(
        &self,
        parts: Parts<'_>,
        sides: &[Vec<Render>; 2],
        count: u32,
        level: f64,
    ) -> Result<Found, Error> {
        let seed = |side: &str| seed_for(self.seed, &format!("{count} images, {side}"));
        let images = |side: usize, count, seed| {
            let samples = SAMPLES;
            images_of(parts, &sides[side], seed, Images { count, samples })
        };
        let Some(tolerance) = self.relation.tolerance else {
            let sides = [
                images(0, count, seed("first"))?,
                images(1, count, seed("second"))?,
            ];
            return Ok(judge(&sides, level));
        };
        let [a, b] = [images(0, 1, seed("both"))?, images(1, 1, seed("both"))?];
        Ok(match differing_pixels(&a[0], &b[0], tolerance) {
            0 => Found::Holds,
            count => Found::Fails(format!("{count} pixels differ under one seed")),
        })
    }
}

/// Adds an image to a sum that is empty before the first.
fn add(sum: &mut Vec<DVec3>, image: Vec<DVec3>) {
    if sum.is_empty() {
        *sum = image;
    } else {
        sum.iter_mut().zip(image).for_each(|(sum, of)| *sum += of);
    }
}

/// Counts the pixels that differ by more than a fraction of their brightest channel, and rounding
/// of the film unless the fraction is 0.
fn differing_pixels(a: &[DVec3], b: &[DVec3], tolerance: f64) -> usize {
    let units = if tolerance > 0.0 { FILM_ROUNDING } else { 0.0 };
    let differs = |(a, b): &(&DVec3, &DVec3)| {
        (**a - **b).abs().max_element() > tolerance * a.max_element() + units
    };
    a.iter().zip(b).filter(differs).count()
}

/// Compares two sides as the program `compare` does.
fn judge(sides: &[Vec<Vec<DVec3>>; 2], level: f64) -> Found {
    let channel = |side: usize, channel: usize| -> Vec<Vec<f64>> {
        let of = |image: &Vec<DVec3>| image.iter().map(|pixel| pixel[channel]).collect();
        sides[side].iter().map(of).collect()
    };
    let values = [0, 1, 2].map(|c| [channel(0, c), channel(1, c)]);
    let of_channels = values.each_ref().map(|sides| {
        sides
            .each_ref()
            .map(|side| Side::Images(side.iter().map(Vec::as_slice).collect()))
    });
    let rules = Rules {
        level,
        tile: 4,
        rounding: ROUNDING,
        ..Rules::default()
    };
    let comparison = compare(RESOLUTION[0] as usize, &of_channels, &rules);
    match comparison.verdict {
        Verdict::Holds => Found::Holds,
        Verdict::Undecided { .. } => Found::Undecided,
        Verdict::Fails => {
            let rejected = comparison.kinds.iter().flat_map(|kind| {
                kind.rejected().map(|test| {
                    let [x0, y0, x1, y1] = test.area;
                    let [a, b] = test.means;
                    format!(
                        "{} [{x0}..{x1}, {y0}..{y1}] channel {}: {a:.6e} and {b:.6e}, {:.1} standard errors",
                        kind.name, test.channel, test.sigmas
                    )
                })
            });
            let all: Vec<String> = rejected.collect();
            let more = match all.len() {
                0 | 1 => String::new(),
                count => format!(" (and {} more)", count - 1),
            };
            Found::Fails(format!("{}{more}", all.first().map_or("", String::as_str)))
        }
    }
}
