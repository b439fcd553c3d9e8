//! The agreement matrix: every estimator on every scene that it can handle, against closed forms and the
//! path tracer.

mod claims;
mod judge;
mod left_out;
mod maps;

use whitefurnace::equation;
use whitefurnace::error::Error;
use whitefurnace::harness::mean::Values;
use whitefurnace::moments::Moments;
use whitefurnace::rng::seed_for;

use claims::{Cell, Claim, ESTIMATORS, Lack, SCENES, cells, replications, replications_left_out};
use judge::judge;
use left_out::{METHODS, left_out};
use maps::{Maps, note_map};

use crate::job::{EstimatorName, Job, SceneName, name};
use crate::lab::{Experiment, Lab};
use crate::ledger::{Ledger, number};
use crate::photons::{Gather, Photons};
use crate::plot::agreement::{histograms, squares};
use crate::plot::map::maps as draw_maps;
use crate::progress::Progress;
use crate::suite::FAMILY;

/// Every estimator against the reference of its scene.
pub const AGREEMENT: Experiment = Experiment {
    id: "agreement",
    title: "estimator × scene: image means agree (accumulates over runs)",
    version: 3,
    equations: &[
        &equation::RENDERING,
        &equation::ESTIMATOR,
        &equation::WHITTED,
        &equation::GEOMETRY,
    ],
    run,
};

/// Photons per image: each image has its own.
fn photons(lab: &Lab) -> u32 {
    lab.count(4_000) as u32
}

/// Patches of radiosity.
fn patches(lab: &Lab) -> u32 {
    lab.count(1_000) as u32
}

/// What one run renders of a cell, image by image.
struct Run {
    means: Values,
    maps: Maps,
}

/// A [`Run`] as numbers to be stored: the states of the means, and of the maps.
type States = ([f64; 5], maps::States);

impl Run {
    fn states(&self) -> States {
        (self.means.state(), self.maps.states())
    }

    fn of_states((means, maps): States) -> Self {
        Self { means: Values::of_state(means), maps: Maps::of_states(maps) }
    }
}

/// Image means of all runs.
#[derive(Clone, Copy)]
struct Total {
    moments: Moments,
    /// From how many images on skewness leaves the tail of a t interval valid.
    valid_from: u64,
}

const SIZE: [u32; 2] = [40, 30];
const COLUMNS: &str = "replication,count,mean,variance";

fn run(lab: &mut Lab) -> Result<(), Error> {
    let cells = cells(lab.tier());
    // One interval of the mean and one least p-value of the tiles for each cell.
    let share = FAMILY / (2 * cells.len()) as f64;
    let mut totals = Vec::new();
    let mut runs = Vec::new();
    let mut level = share;
    for cell in &cells {
        let file = format!("{}.{}.csv", name(cell.scene), name(cell.estimator));
        let mut ledger = open(lab, &file)?;
        let first = ledger.next() as u32;
        let part = format!("{}.{}", name(cell.scene), name(cell.estimator));
        let run = Run::of_states(lab.part(&part, || Ok(render(lab, cell, first)?.states()))?);
        level = ledger.look(share);
        totals.push(add(&mut ledger, &run.means, level)?);
        runs.push(run);
    }
    let lacks = lacks(lab, &cells, level)?;
    let mut shown = Vec::new();
    let mut panels = Vec::new();
    let mut tile_maps = Vec::new();
    for (i, cell) in cells.iter().enumerate() {
        let closed_form = SCENES.iter().find(|(scene, _)| *scene == cell.scene);
        let reference = match closed_form.and_then(|(_, mean)| *mean) {
            Some(mean) => Reference::Known(mean),
            None => match cells.iter().position(|other| is_reference(other, cell.scene)) {
                Some(at) => Reference::Rendered(at),
                None => continue,
            },
        };
        let against = match reference {
            Reference::Known(mean) => Mean::Known(mean),
            Reference::Rendered(at) => Mean::Measured(totals[at]),
        };
        let square = judge(lab, cell, &totals[i], (against, lacks[i]), level);
        if let Reference::Rendered(at) = reference
            && at != i
        {
            let (tiles, pixels) = note_map(lab, cell, [&runs[i].maps, &runs[at].maps], share);
            if cell.scene == SceneName::DiffuseRoom {
                tile_maps.push(tiles);
            }
            if let Some(histogram) = pixels {
                let title = format!("{}, {}", name(cell.estimator), name(cell.scene));
                panels.push((title, histogram));
            }
        }
        shown.push((cell.scene, cell.estimator, square));
    }
    let mut scenes: Vec<SceneName> = SCENES.iter().map(|(scene, _)| *scene).collect();
    // A smaller tier leaves scenes out.
    scenes.retain(|scene| shown.iter().any(|(s, ..)| s == scene));
    let columns: Vec<String> = scenes.iter().copied().map(name).collect();
    squares(
        &lab.figure("agreement.svg"),
        (
            "Image mean relative to the reference ± half its interval",
            "Methods without bias agree in every scene; others differ as far as their reasons say.",
        ),
        (&ESTIMATORS.map(name), &columns),
        "not compared: undefined, or without finite variance",
        |row, column| {
            let at = shown.iter().find(|(s, e, _)| *s == scenes[column] && *e == ESTIMATORS[row]);
            at.map(|(.., square)| square.clone())
        },
    )?;
    histograms(
        &lab.figure("p-values.svg"),
        (
            "p-values of the pixels against the path tracer",
            "Flat where expectations are equal; high at the left where a method is biased or leaves light out.",
        ),
        &panels,
    )?;
    let see = "Noise without a pattern for methods without bias; blue where light is missing.";
    draw_maps(&lab.figure("tiles.svg"), see, [1080, 700], 3, &tile_maps)
}

/// The file that holds the image means of all runs.
fn open(lab: &Lab, file: &str) -> Result<Ledger, Error> {
    let key = format!(
        "agreement version {}, seed {}, {SIZE:?}, {} photons, {} patches",
        AGREEMENT.version,
        lab.seed(),
        photons(lab),
        patches(lab)
    );
    lab.ledger(file, &key, COLUMNS)
}

/// Adds the image means of this run and writes the file; returns those of all runs.
fn add(ledger: &mut Ledger, means: &Values, level: f64) -> Result<Total, Error> {
    let moments = means.moments;
    ledger.push(
        ledger.next() + moments.count() - 1,
        &[
            moments.count().to_string(),
            format!("{:e}", moments.mean()),
            format!("{:e}", moments.variance()),
        ],
    );
    ledger.write()?;
    Ok(total(ledger, means, level))
}

/// What each cell's method leaves out, if that is claimed.
fn lacks(lab: &Lab, cells: &[Cell], level: f64) -> Result<Vec<Option<Mean>>, Error> {
    let mut counted = Vec::new();
    for (scene, _) in SCENES {
        let wanted = |cell: &Cell| {
            cell.scene == scene && matches!(cell.claim, Claim::Lacks(Lack::Counted(_), _))
        };
        if !cells.iter().any(wanted) {
            continue;
        }
        let ledgers = METHODS.map(|method| {
            let file = format!("{}.left-out-{}.csv", name(scene), method.word());
            open(lab, &file)
        });
        let mut ledgers = ledgers.into_iter().collect::<Result<Vec<_>, _>>()?;
        let count = lab.count(replications_left_out(scene, lab.tier())).max(2) as u32;
        let first = ledgers[0].next() as u32;
        let states: Vec<[f64; 5]> = lab.part(&format!("{}.left-out", name(scene)), || {
            let values = left_out(lab, scene, first, count)?;
            Ok(values.iter().map(Values::state).collect())
        })?;
        let values: Vec<Values> = states.into_iter().map(Values::of_state).collect();
        for ((method, ledger), values) in METHODS.iter().zip(&mut ledgers).zip(&values) {
            ledger.look(level);
            counted.push((scene, *method, add(ledger, values, level)?));
        }
    }
    let lack = |cell: &Cell| match cell.claim {
        Claim::Lacks(Lack::Known(radiance), _) => Some(Mean::Known(radiance)),
        Claim::Lacks(Lack::Counted(method), _) => counted
            .iter()
            .find(|(scene, of, _)| *scene == cell.scene && *of == method)
            .map(|(.., total)| Mean::Measured(*total)),
        Claim::Equal | Claim::Biased(..) => None,
    };
    Ok(cells.iter().map(lack).collect())
}

fn is_reference(cell: &Cell, scene: SceneName) -> bool {
    cell.scene == scene && cell.estimator == EstimatorName::Mis
}

/// A mean that is known, or that images tell.
#[derive(Clone, Copy)]
enum Mean {
    Known(f64),
    Measured(Total),
}

/// What a cell is compared with.
enum Reference {
    Known(f64),
    /// The cell with this index.
    Rendered(usize),
}

/// Renders the next replications of a cell.
fn render(lab: &Lab, cell: &Cell, first: u32) -> Result<Run, Error> {
    let label = format!("{} {}", name(cell.scene), name(cell.estimator));
    let uses_photons = matches!(cell.estimator, EstimatorName::Photon | EstimatorName::Sppm);
    let is_radiosity = cell.estimator == EstimatorName::Radiosity;
    let photons = Photons {
        photons: photons(lab),
        radius: match cell.scene {
            SceneName::FurnaceBox | SceneName::CavityCap => 0.03,
            _ => 0.15,
        },
        // Shadow rays between walls that meet have no bounded variance.
        gather: match (cell.estimator, cell.scene) {
            (EstimatorName::Photon, SceneName::FurnaceBox) => Gather::No,
            _ => Gather::Yes,
        },
        ..Photons::default()
    };
    let count = lab.count(replications(cell, lab.tier())).max(2) as u32;
    let job = Job {
        scene: cell.scene,
        estimator: cell.estimator,
        photons: if uses_photons { photons } else { Photons::default() },
        patches: if is_radiosity { patches(lab) } else { Job::default().patches },
        size: SIZE,
        spp: first + count,
        seed: seed_for(lab.seed(), &label),
        ..Job::default()
    };
    let mut run = Run { means: Values::new(1.0), maps: Maps::new(u64::from(count)) };
    let bar = Progress::new(&label).bar_of(u64::from(count), "images");
    job.replications(first..first + count, |image| {
        run.means.push(run.maps.push(image));
        bar.advance(1);
        Ok(())
    })?;
    bar.finish();
    Ok(run)
}

/// The image means of all runs together.
fn total(ledger: &Ledger, values: &Values, level: f64) -> Total {
    let moments = ledger
        .rows()
        .iter()
        .map(|row| Moments::of(number(row, 1) as u64, number(row, 2), number(row, 3)))
        .fold(Moments::default(), Moments::merge);
    Total { moments, valid_from: values.valid_from_at(level) }
}
