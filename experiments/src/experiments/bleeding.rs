//! Colour bleeding on the white sphere of the report's room: ratios of the channels along its
//! equator, with the coloured walls and with grey ones of the same luminance.

use whitefurnace::render::{LaneEstimator, LaneRenderer, Precision};
use whitefurnace::scene::room::{Convention, WHITE_SPHERE, Walls, diffuse_with, report_with};

use crate::experiments::figures;
use crate::experiments::prelude::*;

pub(super) const BLEEDING: Experiment = Experiment {
    id: "bleeding",
    title: "colour bleeding on the white sphere of figure 8, with coloured and with grey walls",
    headline: "walls tint the white sphere: red over green is {left.red %.2f} at its left, {right.red %.2f} at its right, 1 with grey walls",
    version: 2,
    equations: &[
        &equation::RENDERING,
        &equation::LAMBERT,
        &equation::OREN_NAYAR,
        &equation::RADIOSITY,
    ],
    run,
};

/// Azimuths along the equator, degrees from the direction to the camera, positive to the right in
/// the picture.
const ANGLES: [f64; 17] = [
    -80.0, -70.0, -60.0, -50.0, -40.0, -30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0, 40.0, 50.0,
    60.0, 70.0, 80.0,
];
/// Number of batches: ratios are taken of means over batches, which are nearly normal.
const BATCHES: u32 = 64;

/// Margins of ratios of irradiance between radiosity and path tracing, by tier.
const TINT: [f64; 2] = [0.05, 0.03];

/// Red and blue over green at a point, each with its standard error.
type Ratios = [[f64; 2]; 2];

fn run(run: &mut Run) -> Result<(), Error> {
    let room = |walls| report_with(Convention::Physical, OrenNayarForm::Corrected, walls);
    let mut profiles = Vec::new();
    let mut rows = Vec::new();
    // The tint by caustics is large, and grey walls leave none at all: few samples show both.
    for (name, scene, quick) in [
        ("report, coloured walls", room(Walls::Coloured)?, 400),
        ("report, grey walls", room(Walls::Grey)?, 100),
        (
            "diffuse room, coloured walls",
            diffuse_with(Walls::Coloured)?,
            1_000,
        ),
    ] {
        let samples = run.count(run.by_tier(quick, 40_000)) as u32;
        let profile = by_paths(&scene, seed_for(run.seed(), name), samples)?;
        rows.extend(ANGLES.iter().zip(&profile).map(|(angle, ratios)| {
            let [[red, red_error], [blue, blue_error]] = ratios;
            format!("{name},{angle},{red:.6},{red_error:.6},{blue:.6},{blue_error:.6}")
        }));
        profiles.push(profile);
    }
    run.csv(
        "bleeding.csv",
        "scene,azimuth,red over green,standard error,blue over green,standard error",
        &rows,
    )?;
    let patches = run.count(run.by_tier(800, 3_000)) as u32;
    let radiosity = by_radiosity(&diffuse_with(Walls::Coloured)?, patches)?;
    judge(run, &profiles, &radiosity);
    picture(run, &diffuse_with(Walls::Coloured)?, "coloured.png")?;
    picture(run, &diffuse_with(Walls::Grey)?, "grey.png")?;
    draw(run, &profiles, &radiosity)
}

/// Renders the white sphere in the window of figure 8, in a diffuse room: no caustics hide the
/// tint.
fn picture(run: &mut Run, scene: &Scene, file: &str) -> Result<(), Error> {
    let job = Job {
        window: Some(figures::WHITE_SPHERE),
        spp: run.by_tier(32, 512),
        ..Job::default()
    };
    let job = run.with_run_options(job);
    let lanes = LaneRenderer {
        estimator: LaneEstimator::Path(Path::default()),
        sampling: random_points(job.seed),
        precision: Precision::Double,
    };
    let film = render_film(&lanes, scene, job.film()?, job.spp)?;
    write_png(&run.figure(file), &film, job.display(0.0), 3)
}

/// Returns the ray from the camera to a point of the equator.
fn equator_ray(scene: &Scene, angle: f64) -> Ray {
    let sphere = WHITE_SPHERE;
    let eye = scene.camera().eye;
    let towards = (eye - sphere.centre).with_z(0.0).normalize();
    // The camera looks along −x: its right is +y.
    let right = DVec3::Z.cross(towards);
    let (sin, cos) = angle.to_radians().sin_cos();
    let point = sphere.centre + sphere.radius * (cos * towards + sin * right);
    // Starts just before the point: occluders on the way do not matter.
    let outward = (point - sphere.centre) / sphere.radius;
    let origin = point + 0.01 * outward;
    Ray::new(origin, -outward)
}

fn by_paths(scene: &Scene, seed: u64, samples: u32) -> Result<Vec<Ratios>, Error> {
    let path = Path::default();
    let places: Vec<(u32, f64)> = (0..).zip(ANGLES).collect();
    parallel_map(&places, |&(place, angle)| {
        let ray = equator_ray(scene, angle);
        let hit = scene.intersect(&ray);
        let mut ratios = [Moments::default(); 2];
        for batch in 0..BATCHES {
            let mut rng = stream(seed, place, batch);
            let sum: DVec3 = (0..samples)
                .map(|_| path.radiance(scene, &ray, hit, &mut rng))
                .sum();
            ratios[0].push(sum.x / sum.y);
            ratios[1].push(sum.z / sum.y);
        }
        ratios.map(|moments| [moments.mean(), moments.standard_error()])
    })
}

fn by_radiosity(scene: &Scene, patches: u32) -> Result<Vec<[f64; 2]>, Error> {
    let solved = Radiosity::new(
        Parts::default(),
        scene,
        MeshResolution {
            patches,
            halvings: 0,
        },
        &|_| !interrupted(),
    )?;
    let ratios = ANGLES.iter().filter_map(|&angle| {
        let ray = equator_ray(scene, angle);
        let irradiance = solved.irradiance(scene, &ray, &scene.intersect(&ray)?);
        Some([irradiance.x / irradiance.y, irradiance.z / irradiance.y])
    });
    Ok(ratios.collect())
}

/// Judges the profiles at the family-wise level of the experiment.
fn judge(run: &mut Run, profiles: &[Vec<Ratios>], radiosity: &[[f64; 2]]) {
    let critical = normal_upper(FAMILYWISE_LEVEL / (2.0 * 4.0 * ANGLES.len() as f64));
    let [coloured, grey, diffuse] = profiles else {
        return;
    };
    for (place, side) in [
        (1, "left"),
        (ANGLES.len() / 2, "middle"),
        (ANGLES.len() - 2, "right"),
    ] {
        let [[red, red_error], [blue, blue_error]] = coloured[place];
        run.numbers(side, [("red", red), ("blue", blue)]);
        let [red_half, blue_half] = [red_error, blue_error].map(|error| critical * error);
        let [[red_grey, _], [blue_grey, _]] = grey[place];
        let value = format!(
            "R : G : B = {red:.3} ± {red_half:.3} : 1 : {blue:.3} ± {blue_half:.3}; with grey walls {red_grey:.3} : 1 : \
             {blue_grey:.3}"
        );
        run.note(&format!("{side}, {}°", ANGLES[place]), value);
    }
    let worst = |ratios: &[Ratios]| {
        ratios
            .iter()
            .flatten()
            .map(|[ratio, _]| (ratio - 1.0).abs())
            .fold(0.0, f64::max)
    };
    let tinted = coloured
        .iter()
        .filter(|ratios| {
            ratios
                .iter()
                .any(|[ratio, error]| (ratio - 1.0).abs() > critical * error)
        })
        .count();
    let value = format!(
        "at {tinted} of {} points, up to {:.1} %",
        ANGLES.len(),
        100.0 * worst(coloured)
    );
    run.claim(
        "walls colour the white sphere",
        value,
        2 * tinted > ANGLES.len(),
    );
    let value = format!("channels differ by at most {:.1e}", worst(grey));
    run.claim("grey walls do not", value, worst(grey) < 1e-9);
    // Far and near end of the confidence interval of each ratio's distance.
    let [apart, at_least] = [1.0, -1.0].map(|sign| {
        diffuse
            .iter()
            .zip(radiosity)
            .flat_map(|(paths, radiosity)| paths.iter().zip(radiosity))
            .map(|([ratio, error], solved)| (ratio - solved).abs() + sign * critical * error)
            .fold(0.0, f64::max)
    });
    run.number("apart", apart);
    let tint = run.by_tier(TINT[0], TINT[1]);
    let what = "radiosity and path tracer agree on the tint";
    let value = format!("ratios of irradiance within {apart:.4}, at most {tint}");
    let verdict = if apart < tint || at_least > tint {
        Judgement::from(apart < tint)
    } else {
        Judgement::Undecided
    };
    run.claim(what, value, verdict);
}

fn draw(run: &mut Run, profiles: &[Vec<Ratios>], radiosity: &[[f64; 2]]) -> Result<(), Error> {
    let (mut report, mut diffuse) = (Vec::new(), Vec::new());
    for (channel, colour, ratio) in [(0, 0, "R/G"), (1, 2, "B/G")] {
        let measured = |profile: &[Ratios], label: &str| {
            let points = ANGLES
                .iter()
                .zip(profile)
                .map(|(&a, r)| [a, r[channel][0], 3.0 * r[channel][1]]);
            Series::measured(&format!("{ratio}, {label}"), colour, points)
        };
        report.push(measured(&profiles[0], "coloured walls"));
        // The other ratio's line coincides with this one.
        let label = if channel == 0 {
            "both ratios, grey walls"
        } else {
            ""
        };
        let grey = ANGLES
            .iter()
            .zip(&profiles[1])
            .map(|(&a, r)| [a, r[channel][0]]);
        report.push(Series::new(label, colour, Mark::Faint, grey));
        let solved = ANGLES.iter().zip(radiosity).map(|(&a, r)| [a, r[channel]]);
        diffuse.push(Series::new(
            &format!("{ratio}, radiosity"),
            colour,
            Mark::Line,
            solved,
        ));
        diffuse.push(measured(&profiles[2], "paths"));
    }
    let chart = |title: &str, series| {
        let azimuth = "azimuth on the sphere from the camera's direction (°, right is positive)";
        Chart::new(
            title,
            [azimuth, "ratio to green"],
            [[-85.0, 85.0], [0.4, 1.7]],
            series,
        )
    };
    let report = chart(
        "The white sphere in the report's room: radiance along its girdle",
        report,
    );
    let diffuse = chart(
        "The same in the diffuse room: irradiance, by paths and by radiosity",
        diffuse,
    );
    let description = "Towards the walls red and blue leave the ratio one that grey walls would give. Points of path \
               tracing lie on the lines of radiosity.";
    charts(run, "bleeding.svg", description, 880, &[report, diffuse])
}
