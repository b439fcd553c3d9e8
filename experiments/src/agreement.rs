//! The agreement matrix: every estimator on every scene that it can handle, against closed forms and the
//! path tracer.

mod judge;

use glam::DVec3;
use whitefurnace::equation;
use whitefurnace::error::Error;
use whitefurnace::harness::mean::Values;
use whitefurnace::harness::welch_map::PValueMap;
use whitefurnace::moments::Moments;
use whitefurnace::rng::seed_for;

use judge::{judge, note_map};

use crate::job::{EstimatorName, Job, SceneName, name};
use crate::lab::{Experiment, Lab, Tier};
use crate::ledger::{Ledger, number};
use crate::photons::{Gather, Photons};
use crate::plot::agreement::{histograms, squares};
use crate::plot::map::{Map, maps};
use crate::suite::FAMILY;

/// Every estimator against the reference of its scene.
pub const AGREEMENT: Experiment = Experiment {
    id: "agreement",
    title: "estimator × scene: image means agree (accumulates over runs)",
    version: 2,
    equations: &[
        &equation::RENDERING,
        &equation::ESTIMATOR,
        &equation::WHITTED,
        &equation::GEOMETRY,
    ],
    run,
};

/// The scenes, with the mean radiance of every pixel where a closed form gives it.
const SCENES: [(SceneName, Option<f64>); 7] = [
    (SceneName::DiffuseRoom, None),
    (SceneName::Report, None),
    (SceneName::Cornell, None),
    (SceneName::FurnaceBox, Some(4.0)),
    (SceneName::CavityCap, None),
    (SceneName::Environment, Some(1.0)),
    (SceneName::GlassCube, Some(1.0)),
];

const ESTIMATORS: [EstimatorName; 10] = [
    EstimatorName::Mis,
    EstimatorName::Bsdf,
    EstimatorName::Light,
    EstimatorName::LightTracer,
    EstimatorName::Bdpt,
    EstimatorName::Photon,
    EstimatorName::Sppm,
    EstimatorName::Radiosity,
    EstimatorName::Whitted,
    EstimatorName::Report,
];

/// What is claimed of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Claim {
    /// Within the margin of the tier.
    Equal,
    /// Within this share, for a reason that is known.
    Biased(f64, &'static str),
    /// Different, for a reason that is known.
    Different(&'static str),
}

const DENSITY: &str = "density estimation blurs over its radius";
const MESH: &str = "the mesh of finite elements";
const DIRECT_ONLY: &str = "leaves out light between diffuse surfaces";

/// What is claimed of an estimator on a scene; `None` where it is not defined or its variance infinite.
fn claim(scene: SceneName, estimator: EstimatorName) -> Option<Claim> {
    use EstimatorName as E;
    use SceneName as S;
    let lit_by_background = matches!(scene, S::Environment | S::GlassCube);
    let specular = matches!(scene, S::Report | S::Environment | S::GlassCube);
    Some(match estimator {
        E::Mis | E::Bsdf | E::Bdpt => Claim::Equal,
        // Points uniform in area on walls that meet: the geometry term has no bound.
        E::Light | E::Whitted if scene == S::FurnaceBox => return None,
        E::Light => Claim::Equal,
        E::LightTracer if lit_by_background => return None,
        E::LightTracer if scene == S::Report => {
            Claim::Different("the eye sees nothing in mirrors and through glass")
        }
        E::LightTracer => Claim::Equal,
        E::Photon | E::Sppm if lit_by_background => return None,
        E::Photon => Claim::Biased(0.02, DENSITY),
        E::Sppm => Claim::Biased(0.06, DENSITY),
        E::Radiosity if specular => return None,
        E::Radiosity => Claim::Biased(0.02, MESH),
        E::Whitted if scene == S::GlassCube => {
            Claim::Different("cut after seven segments, it loses light that stays in the glass")
        }
        E::Whitted => Claim::Different(DIRECT_ONLY),
        E::Report if scene == S::CavityCap => {
            Claim::Different("cut after seven segments, it loses what more bounces carry")
        }
        // One scene is enough to show what its limit removes.
        E::Report => return None,
    })
}

/// Photons per image: each image has its own.
const PHOTONS: u32 = 4_000;
/// Patches of radiosity.
const PATCHES: u32 = 1_000;

/// A cell of the matrix.
struct Cell {
    scene: SceneName,
    estimator: EstimatorName,
    claim: Claim,
}

/// What one run renders of a cell, image by image.
struct Run {
    means: Values,
    tiles: Vec<Values>,
    pixels: Vec<Values>,
}

impl Run {
    fn push(&mut self, image: &[DVec3]) {
        let grey = |value: &DVec3| value.element_sum() / 3.0;
        let width = SIZE[0] as usize;
        let mut tiles = vec![0.0; self.tiles.len()];
        for (i, (pixel, value)) in self.pixels.iter_mut().zip(image).enumerate() {
            let value = grey(value);
            pixel.push(value);
            tiles[i / width / TILE * (width / TILE) + i % width / TILE] += value;
        }
        for (tile, sum) in self.tiles.iter_mut().zip(&tiles) {
            tile.push(sum / (TILE * TILE) as f64);
        }
        self.means
            .push(tiles.iter().sum::<f64>() / image.len() as f64);
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

/// Within which image means must agree. The lights of the Cornell box and the caustics of the report's room
/// make the standard deviation of one image's mean some ten per cent and more: half a per cent would take
/// an hour.
fn margin(scene: SceneName, tier: Tier) -> f64 {
    match (tier, scene) {
        (Tier::Quick, _) => 0.02,
        (Tier::Full, SceneName::Report | SceneName::Cornell) => 0.01,
        (Tier::Full, _) => 0.005,
    }
}

const TILE: usize = 5;
const BINS: usize = 10;

fn run(lab: &mut Lab) -> Result<(), Error> {
    let cells = cells(lab.tier());
    // One interval of the mean, one least p-value of tiles and one of pixels for each cell.
    let share = FAMILY / (3 * cells.len()) as f64;
    let mut totals = Vec::new();
    let mut runs = Vec::new();
    let mut level = share;
    for cell in &cells {
        let key = format!(
            "agreement version {}, seed {}, {SIZE:?}, {PHOTONS} photons, {PATCHES} patches",
            AGREEMENT.version,
            lab.seed()
        );
        let file = format!("{}.{}.csv", name(cell.scene), name(cell.estimator));
        let mut ledger = Ledger::open(lab.path(&file), &key, COLUMNS);
        let run = render(lab, cell, ledger.next() as u32)?;
        let moments = run.means.moments;
        ledger.push(
            ledger.next() + moments.count() - 1,
            &[
                moments.count().to_string(),
                format!("{:e}", moments.mean()),
                format!("{:e}", moments.variance()),
            ],
        );
        level = ledger.look(share);
        ledger.write()?;
        totals.push(total(&ledger, &run.means, level));
        runs.push(run);
    }
    let mut shown = Vec::new();
    let mut panels = Vec::new();
    let mut maps_of_tiles = Vec::new();
    for (i, cell) in cells.iter().enumerate() {
        let closed_form = SCENES.iter().find(|(scene, _)| *scene == cell.scene);
        let reference = match closed_form.and_then(|(_, mean)| *mean) {
            Some(mean) => Reference::Known(mean),
            None => match cells
                .iter()
                .position(|other| is_reference(other, cell.scene))
            {
                Some(at) => Reference::Rendered(at),
                None => continue,
            },
        };
        let square = judge(lab, cell, &totals[i], (&reference, &totals), level);
        if let Reference::Rendered(at) = reference
            && at != i
        {
            let tiles = note_map(lab, cell, "tiles", [&runs[i].tiles, &runs[at].tiles], share);
            if cell.scene == SceneName::DiffuseRoom {
                maps_of_tiles.push(tile_map(&name(cell.estimator), tiles));
            }
            let pixels = note_map(
                lab,
                cell,
                "pixels",
                [&runs[i].pixels, &runs[at].pixels],
                share,
            );
            let title = format!("{}, {}", name(cell.estimator), name(cell.scene));
            panels.push((title, pixels.histogram(BINS)));
        }
        shown.push((cell.scene, cell.estimator, square));
    }
    let scenes = SCENES.map(|(scene, _)| scene);
    squares(
        &lab.figure("agreement.svg"),
        "Image mean relative to the reference, with the half-width of its interval",
        &ESTIMATORS.map(name),
        &scenes.map(name),
        |row, column| {
            let at = shown
                .iter()
                .find(|(s, e, _)| *s == scenes[column] && *e == ESTIMATORS[row]);
            at.map(|(.., square)| square.clone())
        },
    )?;
    histograms(
        &lab.figure("p-values.svg"),
        "p-values of the pixels against the path tracer",
        &panels,
    )?;
    maps(&lab.figure("tiles.svg"), [1080, 960], 3, &maps_of_tiles)
}

/// Where in the image an estimator differs from the path tracer.
fn tile_map(estimator: &str, tiles: PValueMap) -> Map {
    let size = [tiles.width, tiles.height];
    Map {
        title: format!("{estimator} − mis"),
        axes: ["across (tiles)".into(), "up (tiles)".into()],
        ranges: size.map(|tiles| [0.0, tiles as f64]),
        size: size.map(|tiles| tiles as u32),
        values: tiles.sigmas,
        bound: 4.0,
        unit: "standard errors".into(),
    }
}

/// Quick: the named subset. Full: all.
fn cells(tier: Tier) -> Vec<Cell> {
    let all = SCENES.iter().flat_map(|&(scene, _)| {
        ESTIMATORS.iter().filter_map(move |&estimator| {
            let claim = claim(scene, estimator)?;
            Some(Cell {
                scene,
                estimator,
                claim,
            })
        })
    });
    let quick = [
        SceneName::DiffuseRoom,
        SceneName::FurnaceBox,
        SceneName::Environment,
    ];
    all.filter(|cell| tier == Tier::Full || quick.contains(&cell.scene))
        .collect()
}

fn is_reference(cell: &Cell, scene: SceneName) -> bool {
    cell.scene == scene && cell.estimator == EstimatorName::Mis
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
        photons: PHOTONS,
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
        photons: if uses_photons {
            photons
        } else {
            Photons::default()
        },
        patches: if is_radiosity {
            PATCHES
        } else {
            Job::default().patches
        },
        size: SIZE,
        spp: first + count,
        seed: seed_for(lab.seed(), &label),
        ..Job::default()
    };
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let mut run = Run {
        means: Values::new(1.0),
        tiles: vec![Values::new(1.0); pixels / (TILE * TILE)],
        pixels: vec![Values::new(1.0); pixels],
    };
    job.replications(first..first + count, |image| {
        run.push(image);
        Ok(())
    })?;
    Ok(run)
}

/// Images of a cell per run, by what its noise asks for: most of it is that of pixels on the border of a
/// light, which particles do not have.
fn replications(cell: &Cell, tier: Tier) -> u64 {
    use EstimatorName as E;
    let (quick, full) = match cell.estimator {
        E::Mis => (4_800, 60_000),
        E::Bsdf => (4_800, 60_000),
        E::Light => (1_000, 40_000),
        E::LightTracer => (400, 12_000),
        E::Bdpt => (200, 3_000),
        E::Photon => (1_500, 3_000),
        E::Sppm => (400, 2_000),
        E::Radiosity => (1_500, 3_000),
        E::Whitted | E::Report => (1_000, 8_000),
    };
    match (tier, cell.scene, cell.estimator) {
        (Tier::Quick, SceneName::Environment, E::Whitted) => quick / 4,
        (Tier::Quick, SceneName::Environment | SceneName::FurnaceBox, E::Mis | E::Bsdf) => {
            quick / 8
        }
        (Tier::Quick, SceneName::Environment, _) => quick / 8,
        // The mesh solves it exactly.
        (_, SceneName::FurnaceBox, E::Radiosity) => 100,
        (Tier::Quick, SceneName::FurnaceBox, E::Photon) => quick / 2,
        (Tier::Quick, SceneName::FurnaceBox, E::Sppm) => 2 * quick,
        (Tier::Quick, ..) => quick,
        (Tier::Full, SceneName::Cornell, E::Photon | E::Radiosity) => 4 * full,
        (Tier::Full, SceneName::DiffuseRoom | SceneName::Cornell, _)
        | (Tier::Full, SceneName::Report, E::Bdpt | E::Photon)
        | (Tier::Full, SceneName::CavityCap, E::LightTracer | E::Bdpt)
        | (Tier::Full, SceneName::FurnaceBox, E::Photon) => full,
        (Tier::Full, ..) => full / 4,
    }
}

/// The image means of all runs together.
fn total(ledger: &Ledger, values: &Values, level: f64) -> Total {
    let moments = ledger
        .rows()
        .iter()
        .map(|row| Moments::of(number(row, 1) as u64, number(row, 2), number(row, 3)))
        .fold(Moments::default(), Moments::merge);
    Total {
        moments,
        valid_from: values.valid_from_at(level),
    }
}
