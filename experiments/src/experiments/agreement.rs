//! The agreement matrix: every estimator on every scene that it supports, against closed forms and
//! the path tracer.

mod claims;
mod judge;
mod left_out;
mod maps;

use clap::ValueEnum as _;
use serde::{Deserialize, Serialize};

use claims::{Case, Claim, MissingLight, SCENES, cases, replications, replications_left_out};
use judge::judge;
use left_out::{METHODS, left_out};
use maps::{Maps, note_map};

use crate::experiments::prelude::*;
use crate::plot::agreement::{agreement_matrix, histograms};
use crate::render::SilhouettesName;
use crate::render::photons::{Gather, Photons};

/// Compares every estimator with the reference of its scene.
pub const AGREEMENT: Experiment = Experiment {
    id: "agreement",
    title: "estimator × scene: image means agree (accumulates over runs)",
    headline: "estimators against references and each other: {holds} claims hold, {fails} fail, {undecided} undecided",
    version: 5,
    equations: &[
        &equation::RENDERING,
        &equation::ESTIMATOR,
        &equation::WHITTED,
        &equation::GEOMETRY,
    ],
    run,
};

/// Returns the number of photons per image; each image has its own photons.
fn photons(run: &Run) -> u32 {
    run.count(4_000) as u32
}

/// Returns the number of patches for radiosity.
fn patches(run: &Run) -> u32 {
    run.count(1_000) as u32
}

/// Results of one run for a case, image by image.
#[derive(Serialize, Deserialize)]
struct Images {
    #[serde(with = "state")]
    means: Values,
    maps: Maps,
}

/// Serialisation of [`Values`] as their state.
mod state {
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};
    use whitefurnace::harness::mean::Values;

    pub fn serialize<S: Serializer>(values: &Values, to: S) -> Result<S::Ok, S::Error> {
        values.state().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Values, D::Error> {
        <[f64; 5]>::deserialize(from).map(Values::from_state)
    }
}

/// Image means of all runs.
#[derive(Clone, Copy)]
struct Total {
    moments: Moments,
    /// Number of images from which skewness leaves the tail of a t interval valid.
    valid_from: u64,
}

const SIZE: [u32; 2] = [40, 30];
const COLUMNS: &str = "replication,count,mean,variance";

fn run(run: &mut Run) -> Result<(), Error> {
    let cases = cases(run.tier());
    // One interval of the mean and one least p-value of the tiles for each case.
    let share = FAMILYWISE_LEVEL / (2 * cases.len()) as f64;
    let mut totals = Vec::new();
    let mut rendered = Vec::new();
    let mut level = share;
    for case in &cases {
        let mut accumulated = open(run, &format!("{}.csv", case.key()))?;
        let first = accumulated.next() as u32;
        let images = run.part(&case.key(), || render(run, case, first))?;
        level = accumulated.look(share);
        totals.push(add(&mut accumulated, &images.means, level)?);
        rendered.push(images);
    }
    let missing_light = missing_light_of(run, &cases, level)?;
    let mut shown = Vec::new();
    let mut panels = Vec::new();
    let mut tile_maps = Vec::new();
    for (i, case) in cases.iter().enumerate() {
        let closed_form = SCENES
            .iter()
            .find(|(scene, _)| *scene == case.scene)
            .and_then(|(_, mean)| *mean);
        // Without a closed form the path tracer's images are the reference.
        let is_reference =
            |other: &Case| other.scene == case.scene && other.estimator == EstimatorName::Mis;
        let at = cases
            .iter()
            .position(is_reference)
            .filter(|_| closed_form.is_none());
        let Some(against) = closed_form
            .map(Mean::Known)
            .or(at.map(|at| Mean::Measured(totals[at])))
        else {
            continue;
        };
        let square = judge(run, case, &totals[i], against, missing_light[i], level);
        if let Some(at) = at.filter(|&at| at != i) {
            let (tiles, pixels) =
                note_map(run, case, [&rendered[i].maps, &rendered[at].maps], share);
            if case.scene == SceneName::DiffuseRoom {
                tile_maps.push(tiles);
            }
            if let Some(histogram) = pixels {
                panels.push((
                    format!("{}, {}", name(case.estimator), name(case.scene)),
                    histogram,
                ));
            }
        }
        shown.push((case.scene, case.estimator, square));
    }
    let mut scenes: Vec<SceneName> = SCENES.iter().map(|(scene, _)| *scene).collect();
    // A smaller tier leaves scenes out.
    scenes.retain(|scene| shown.iter().any(|(s, ..)| s == scene));
    let estimators = EstimatorName::value_variants();
    let rows: Vec<String> = estimators.iter().copied().map(name).collect();
    let columns: Vec<String> = scenes.iter().copied().map(name).collect();
    agreement_matrix(
        &run.figure("agreement.svg"),
        "Image mean relative to the reference ± half its interval",
        "Methods without bias agree in every scene; others differ as far as their reasons say.",
        &rows,
        &columns,
        run.by_tier(
            "not compared: undefined, without finite variance, or at the full tier alone",
            "not compared: undefined, or without finite variance",
        ),
        |row, column| {
            let at = shown
                .iter()
                .find(|(s, e, _)| *s == scenes[column] && *e == estimators[row]);
            at.map(|(.., square)| square.clone())
        },
    )?;
    histograms(
        &run.figure("p-values.svg"),
        "p-values of the pixels against the path tracer",
        "Flat where expectations are equal; high at the left where a method is biased or leaves light out.",
        &panels,
    )?;
    let description =
        "Noise without a pattern for methods without bias; blue where light is missing.";
    maps(run, "tiles.svg", description, [1080, 700], 3, &tile_maps)
}

/// Opens the file that holds the image means of all runs.
fn open(run: &Run, file: &str) -> Result<Accumulated, Error> {
    let (version, seed, photons, patches) =
        (AGREEMENT.version, run.seed(), photons(run), patches(run));
    let key = format!(
        "agreement version {version}, seed {seed}, {SIZE:?}, {photons} photons, {patches} patches"
    );
    run.accumulated(file, &key, COLUMNS)
}

/// Adds the image means of this run and writes the file; returns those of all runs.
fn add(accumulated: &mut Accumulated, means: &Values, level: f64) -> Result<Total, Error> {
    let moments = means.moments;
    accumulated.push(
        accumulated.next() + moments.count() - 1,
        &[
            moments.count().to_string(),
            format!("{:e}", moments.mean()),
            format!("{:e}", moments.variance()),
        ],
    );
    accumulated.write()?;
    let [counts, averages, variances] =
        ["count", "mean", "variance"].map(|column| accumulated.numbers(column));
    let runs = counts.zip(averages).zip(variances);
    let moments = runs.map(|((count, mean), variance)| Moments::of(count as u64, mean, variance));
    Ok(Total {
        moments: moments.fold(Moments::default(), Moments::merge),
        valid_from: means.valid_from_at(level),
    })
}

/// Returns the radiance that each case's method leaves out, if such a loss is claimed.
fn missing_light_of(run: &Run, cases: &[Case], level: f64) -> Result<Vec<Option<Mean>>, Error> {
    let mut counted = Vec::new();
    for (scene, _) in SCENES {
        let wanted = |case: &Case| {
            case.scene == scene && matches!(case.claim, Claim::Lacks(MissingLight::Measured(_), _))
        };
        if !cases.iter().any(wanted) {
            continue;
        }
        let files = METHODS.map(|method| {
            open(
                run,
                &format!("{}.left-out-{}.csv", name(scene), method.word()),
            )
        });
        let mut files = files.into_iter().collect::<Result<Vec<_>, _>>()?;
        let count = run.count(replications_left_out(scene, run.tier())).max(2) as u32;
        let first = files[0].next() as u32;
        let states: Vec<[f64; 5]> = run.part(&format!("{}.left-out", name(scene)), || {
            Ok(left_out(run, scene, first, count)?
                .iter()
                .map(Values::state)
                .collect())
        })?;
        let values: Vec<Values> = states.into_iter().map(Values::from_state).collect();
        for ((method, accumulated), values) in METHODS.iter().zip(&mut files).zip(&values) {
            accumulated.look(level);
            counted.push((scene, *method, add(accumulated, values, level)?));
        }
    }
    let missing_light = |case: &Case| match case.claim {
        Claim::Lacks(MissingLight::Known(radiance), _) => Some(Mean::Known(radiance)),
        Claim::Lacks(MissingLight::Measured(method), _) => counted
            .iter()
            .find(|(scene, of, _)| *scene == case.scene && *of == method)
            .map(|(.., total)| Mean::Measured(*total)),
        Claim::Equal | Claim::Biased(..) => None,
    };
    Ok(cases.iter().map(missing_light).collect())
}

/// A mean that is known in closed form or measured by images.
#[derive(Clone, Copy)]
enum Mean {
    Known(f64),
    Measured(Total),
}

/// Renders the next replications of a case.
fn render(run: &Run, case: &Case, first: u32) -> Result<Images, Error> {
    let label = format!("{} {}", name(case.scene), name(case.estimator));
    let uses_photons = matches!(case.estimator, EstimatorName::Photon | EstimatorName::Sppm);
    let is_radiosity = case.estimator == EstimatorName::Radiosity;
    let photons = Photons {
        photons: photons(run),
        radius: match case.scene {
            SceneName::FurnaceBox | SceneName::CavityCap => 0.03,
            _ => 0.15,
        },
        // Shadow rays between walls that meet have unbounded variance.
        gather: match (case.estimator, case.scene) {
            (EstimatorName::Photon, SceneName::FurnaceBox) => Gather::No,
            _ => Gather::Yes,
        },
        ..Photons::DEFAULT
    };
    let count = run.count(replications(case, run.tier())).max(2) as u32;
    let job = Job {
        scene: case.scene.into(),
        estimator: case.estimator,
        photons: if uses_photons {
            photons
        } else {
            Photons::DEFAULT
        },
        patches: if is_radiosity {
            patches(run)
        } else {
            Job::default().patches
        },
        // Most of the noise of an image's mean comes from pixels on the border of a light, except
        // for estimators that trace particles.
        silhouettes: SilhouettesName::Yes,
        size: SIZE,
        spp: first + count,
        seed: seed_for(run.seed(), &label),
        ..Job::default()
    };
    let mut images = Images {
        means: Values::new(1.0),
        maps: Maps::new(u64::from(count)),
    };
    let bar = Bar::new(&label, u64::from(count), "images");
    job.replications(first..first + count, |image| {
        images.means.push(images.maps.push(image));
        bar.advance(1);
    })?;
    Ok(images)
}
