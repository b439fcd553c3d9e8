//! Radiosity in the diffuse room: convergence of the solution as patches are halved, and its
//! distance from the path tracer.

use whitefurnace::integrator::radiosity::ReadOut;

use crate::experiments::prelude::*;

pub(super) const RADIOSITY: Experiment = Experiment {
    id: "radiosity",
    title: "radiosity in the diffuse room: error against the number of patches",
    headline: "radiosity agrees with path tracing: image means {difference %.2%} apart at the finest mesh",
    version: 3,
    equations: &[&equation::RADIOSITY, &equation::FORM_FACTOR],
    run,
};

const SIZE: [u32; 2] = [64, 48];
/// Patches before they are halved.
const COARSE: u32 = 60;
/// Relative margin of image means.
const MARGIN: f64 = 0.005;

/// Results of one mesh.
struct Level {
    patches: f64,
    mean: DVec3,
    /// Root mean square of the pixels' differences from the path tracer without its noise, relative
    /// to the mean, and its standard error: interpolated and gathered.
    distances: [[f64; 2]; 2],
}

fn run(run: &mut Run) -> Result<(), Error> {
    let scene = room::diffuse()?;
    let spp = run.count(run.by_tier(1_000, 20_000)) as u32;
    let sampling = pixel_centres(run.seed());
    let paths = render_paths(&scene, Path::default(), sampling, SIZE, spp.max(2))?;
    let reference = mean(&paths);
    let halvings = run.by_tier(2, 3);
    let mut levels = Vec::new();
    for halvings in 0..=halvings {
        let solved = Radiosity::new(
            Parts::default(),
            &scene,
            MeshResolution {
                patches: COARSE,
                halvings,
            },
            &|_| !interrupted(),
        )?;
        let patches = solved.irradiances().count() as f64 / 2.0;
        let (residual, sweeps) = (solved.residual(), solved.sweeps());
        let image = |solved: &Radiosity| render_samples(&scene, solved, sampling, SIZE, 1);
        let interpolated = image(&solved)?;
        let gathered = image(&solved.read(ReadOut::Gathered))?;
        let distances = [&interpolated, &gathered].map(|film| distance(film, &paths));
        let level = Level {
            patches,
            mean: mean(&interpolated),
            distances,
        };
        let key = format!("halvings-{halvings}");
        let [[interpolated, its_error], [gathered, gathered_error]] = distances;
        run.numbers(
            &key,
            [
                ("patches", patches),
                ("mean", level.mean.y),
                ("residual", residual),
                ("interpolated", interpolated),
                ("interpolated_error", its_error),
                ("gathered", gathered),
                ("gathered_error", gathered_error),
            ],
        );
        let value = format!(
            "image mean {:+.3} % from the path tracer, pixels {:.2} % (gathered {:.2} %), residual \
             {residual:.1e} after {sweeps} sweeps",
            100.0 * (level.mean.y / reference.y - 1.0),
            100.0 * interpolated,
            100.0 * gathered,
        );
        run.note(&format!("{patches} patches"), value);
        levels.push(level);
    }
    let errors = paths.pixels().iter().map(|p| p.standard_error().y.powi(2));
    let noise = errors.sum::<f64>().sqrt() / paths.pixels().len() as f64 / reference.y;
    judge(run, &levels, reference.y, noise);
    draw(run, &levels, reference.y, noise)
}

fn mean(film: &Film) -> DVec3 {
    let pixels = film.pixels();
    pixels.iter().map(|p| p.mean()).sum::<DVec3>() / pixels.len() as f64
}

/// Returns the root mean square of the pixels' differences, relative to the mean, and its standard
/// error. With noise of variance s² on a difference t, x = t + e has x² − s² for an unbiased
/// estimate of t², whose variance 4 t² s² + 2 s⁴ is estimated by 4 x² s² − 2 s⁴.
fn distance(film: &Film, paths: &Film) -> [f64; 2] {
    let pairs = film.pixels().iter().zip(paths.pixels());
    let (mut squares, mut variance) = (0.0, 0.0);
    for (a, b) in pairs {
        let x2 = (a.mean().y - b.mean().y).powi(2);
        let s2 = b.standard_error().y.powi(2);
        squares += x2 - s2;
        variance += 4.0 * x2 * s2 - 2.0 * s2 * s2;
    }
    let (n, scale) = (film.pixels().len() as f64, mean(paths).y);
    let distance = (squares.max(0.0) / n).sqrt();
    let error = variance.max(0.0).sqrt() / n / (2.0 * distance);
    [distance / scale, error / scale]
}

/// Judges the order of convergence: how the deviation from the path tracer falls with the side of
/// the patches, from the coarsest mesh to the finest. Visibility between a node and a patch is all
/// or nothing, and the error of patches crossed by edges of shadows or of other surfaces is of the
/// order of their size. Theory then leaves order 1, with jumps from mesh to mesh, so that
/// Richardson extrapolation from three of them is meaningless.
fn judge(run: &mut Run, levels: &[Level], reference: f64, noise: f64) {
    let [first, .., last] = levels else { return };
    let deviation = |level: &Level| level.mean.y / reference - 1.0;
    let halvings = (levels.len() - 1) as f64;
    let order = |value: &dyn Fn(&Level) -> f64| (value(first) / value(last)).log2() / halvings;
    let orders = [
        ("mean", order(&|l| deviation(l).abs())),
        ("interpolated", order(&|l| l.distances[0][0])),
        ("gathered", order(&|l| l.distances[1][0])),
    ];
    run.numbers("order", orders);
    let [mean, interpolated, gathered] = orders.map(|(_, order)| order);
    run.number("reference", reference);
    run.number("reference_error", noise);
    let value = format!("image mean {mean:.2}, pixels {interpolated:.2} (gathered {gathered:.2})");
    run.note("order in the side of a patch", value);
    let difference = deviation(last);
    run.number("difference", difference);
    run.claim(
        "the finest mesh agrees with the path tracer",
        format!(
            "image means {:+.3} % apart, at most {} %; the path tracer's has a standard error of {:.3} %",
            100.0 * difference,
            100.0 * MARGIN,
            100.0 * noise
        ),
        difference.abs() + 4.0 * noise < MARGIN,
    );
}

/// Length of error bars on either side, in standard errors.
const ERROR_BAR_WIDTH: f64 = 3.0;

fn draw(run: &mut Run, levels: &[Level], reference: f64, noise: f64) -> Result<(), Error> {
    let series = |label: &str, colour, value: &dyn Fn(&Level) -> [f64; 2]| {
        let percent = levels
            .iter()
            .map(|level| (level.patches, value(level).map(|share| 100.0 * share)));
        let points =
            percent.map(|(patches, [value, error])| [patches, value, ERROR_BAR_WIDTH * error]);
        let measured = Series::measured(label, colour, points);
        [
            Series::new("", colour, Mark::Line, measured.points.clone()),
            measured,
        ]
    };
    let (low, high) = (50.0, 10_000.0);
    let slope = |patches: f64| [patches, 8.0 * (low / patches).sqrt()];
    let name = "order 1: as the side of a patch, patches^(−1/2)";
    let slope = Series::new(name, 6, Mark::Faint, [slope(low), slope(high)]);
    let difference = move |level: &Level| [(level.mean.y / reference - 1.0).abs(), noise];
    let mut all = vec![slope];
    all.extend(series("pixels, interpolated (rms)", 2, &|l| l.distances[0]));
    all.extend(series("pixels, gathered (rms)", 1, &|l| l.distances[1]));
    all.extend(series("image mean", 0, &difference));
    let title = "Radiosity in the diffuse room against the path tracer";
    let axes = ["patches", "deviation from the path tracer (%)"];
    let chart = Chart::new(title, axes, [[low, high], [0.03, 20.0]], all).log([true, true]);
    let description = "All three deviations fall about as the side of a patch does, the grey line.";
    charts(run, "radiosity.svg", description, 520, &[chart])
}
