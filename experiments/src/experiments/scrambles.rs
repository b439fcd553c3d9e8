//! Among how many scrambles a pixel's samples are shared: what long sequences gain, and what error bars from few of
//! them are worth.

use whitefurnace::film::Pixel;

use crate::experiments::prelude::*;
use crate::render::SamplerName;

pub(super) const SCRAMBLES: Experiment = Experiment {
    id: "scrambles",
    title: "64 samples of a pixel in 1 to 64 scrambles: variance, and what error bars are worth",
    version: 1,
    equations: &[&equation::SOBOL, &equation::ESTIMATOR],
    run,
};

const SAMPLES: u32 = 64;
/// The last are of one point each: independent numbers.
const COUNTS: [u32; 6] = [1, 2, 4, 8, 16, SAMPLES];
/// Among so many `render` shares them.
const OURS: usize = 2;
/// How often an interval should hold the pixel's mean.
const LEVEL: f64 = 0.9;

/// What films of one room with so many scrambles show.
struct Found {
    /// The variance of a pixel, a value for each pair of films.
    variance: Moments,
    /// The share of pixels whose interval holds the mean of the other films, a value for each film.
    coverage: Moments,
    /// Half the width of those intervals, mean over the pixels.
    half_width: Moments,
}

impl Found {
    fn of(films: &[Film], replications: u32) -> Self {
        let pixels = |k: usize| films[k].pixels();
        let squares = |pair: &[Film]| {
            let pixels = pair[0].pixels().iter().zip(pair[1].pixels());
            let squares = pixels.map(|(a, b)| 0.5 * (a.mean() - b.mean()).length_squared());
            squares.sum::<f64>() / pair[0].pixels().len() as f64
        };
        let n = films.len() as f64;
        // Of a film alone; the others' mean has an error as well.
        let reach =
            |pixel: &Pixel| student_upper(0.5 * (1.0 - LEVEL), f64::from(replications - 1)) * pixel.standard_error().y;
        let with_others = (1.0 + 1.0 / (n - 1.0)).sqrt();
        let sums: Vec<f64> =
            (0..pixels(0).len()).map(|i| (0..films.len()).map(|k| pixels(k)[i].mean().y).sum()).collect();
        // An emitter that fills a pixel has no error to speak of.
        let noisy = |i: &usize| (0..films.len()).any(|k| pixels(k)[*i].mean() != pixels(0)[*i].mean());
        let noisy: Vec<usize> = (0..pixels(0).len()).filter(noisy).collect();
        let over_pixels = |of: &dyn Fn(usize, &Pixel) -> f64, k: usize| {
            noisy.iter().map(|&i| of(i, &pixels(k)[i])).sum::<f64>() / noisy.len() as f64
        };
        let holds = |i: usize, pixel: &Pixel| {
            let off = pixel.mean().y - (sums[i] - pixel.mean().y) / (n - 1.0);
            f64::from(u8::from(off.abs() <= with_others * reach(pixel)))
        };
        let films_with_bars = || (0..films.len()).filter(|_| replications > 1);
        Self {
            variance: films.chunks_exact(2).map(squares).collect(),
            coverage: films_with_bars().map(|k| over_pixels(&holds, k)).collect(),
            half_width: films_with_bars().map(|k| over_pixels(&|_, pixel| reach(pixel), k)).collect(),
        }
    }
}

fn run(run: &mut Run) -> Result<(), Error> {
    let rooms = [SceneName::DiffuseRoom, SceneName::Report, SceneName::Cornell, SceneName::CavityCap];
    let films = 2 * run.by_tier(6, 32);
    let mut series = [const { Vec::new() }; 3];
    let mut rows = Vec::new();
    for (colour, scene) in rooms.into_iter().enumerate() {
        let room = name(scene);
        let mut found = Vec::new();
        for scrambles in COUNTS {
            let film = |k| {
                let seed = seed_for(run.seed(), &format!("{room}, {scrambles} scrambles, film {k}"));
                let (sampler, scrambles, spp) = (SamplerName::Sobol, Some(scrambles), SAMPLES);
                let job = Job { scene, sampler, scrambles, spp, size: [32, 24], ..Job::default() };
                Job { seed, ..run.prepared(job) }.render(&format!("{room}, {k}"))?.whole()
            };
            let films = (0..films).map(film).collect::<Result<Vec<_>, _>>()?;
            found.push(Found::of(&films, scrambles));
        }
        let [.., independent] = &found[..] else { continue };
        let relative = |of: fn(&Found) -> &Moments| {
            let base = of(independent).mean();
            let of = move |found: &Found| [of(found).mean() / base, of(found).standard_error() / base];
            found.iter().map(of).collect::<Vec<_>>()
        };
        let coverage = found.iter().map(|found| [found.coverage.mean(), found.coverage.standard_error()]).collect();
        let shown = [relative(|f| &f.variance), coverage, relative(|f| &f.half_width)];
        for (k, scrambles) in COUNTS.into_iter().enumerate() {
            let named = ["variance", "coverage", "half_width"].into_iter().zip(&shown);
            // A scramble alone has no error bar.
            for (what, values) in named.filter(|_| scrambles > 1) {
                run.number(&format!("{room}.{scrambles}.{what}"), values[k][0]);
            }
            let values: Vec<String> = shown.iter().flat_map(|values| values[k]).map(|v| format!("{v:e}")).collect();
            rows.push(format!("{room},{scrambles},{}", values.join(",")));
        }
        judge(run, &room, &found[OURS], independent);
        for (series, (values, from)) in series.iter_mut().zip(shown.iter().zip([0, 1, 1])) {
            let points = COUNTS.into_iter().zip(values).skip(from).map(|(n, [v, e])| [f64::from(n), *v, *e]);
            series.push(Series::measured(&room, colour, points));
        }
    }
    let columns = "room,scrambles,variance,error,coverage,error,half width,error";
    run.csv("scrambles.csv", columns, &rows)?;
    let [variance, coverage, half_width] = series;
    let x = [0.8, 90.0];
    let chart = |title: &str, y: &str, range, series, log| {
        Chart::new(title, ["scrambles that share 64 samples", y], [x, range], series).log([true, log])
    };
    let charts_shown = [
        chart("Variance of a pixel", "over that of independent samples", [0.03, 4.0], variance, true),
        chart("Student's intervals at 90 %", "share that hold the mean", [0.4, 1.1], coverage, false),
        chart("Half their width", "over that of independent samples", [0.2, 12.0], half_width, true),
    ];
    let see = "The fewer scrambles, the smaller the variance; with two their intervals are several times as wide.";
    charts(&run.figure("scrambles.svg"), see, [900, 1200], &charts_shown)
}

/// Whether sequences of which four share the samples gain, and whether their error bars are as honest as those of
/// independent samples.
fn judge(run: &mut Run, room: &str, ours: &Found, independent: &Found) {
    let critical = |n: u64| student_upper(FAMILY / 2.0 / 8.0, n as f64 - 1.0);
    let [a, b] = [ours, independent].map(|found| &found.variance);
    let relative = |m: &Moments| m.standard_error() / m.mean();
    let half = critical(a.count()) * relative(a).hypot(relative(b));
    let gain = b.mean() / a.mean();
    let [low, high] = [-half, half].map(|off| gain * off.exp());
    let value = format!("variance {gain:.2} times smaller, interval [{low:.2}, {high:.2}]");
    let verdict = if low > 1.0 {
        Judgement::Holds
    } else if high < 1.0 {
        Judgement::Fails
    } else {
        Judgement::Undecided
    };
    run.claim(&format!("{room}: four scrambles gain"), value, verdict);
    let [a, b] = [ours, independent].map(|found| &found.coverage);
    let more = a.mean() - b.mean();
    let half = critical(a.count()) * a.standard_error().hypot(b.standard_error());
    let value =
        format!("{:.3} of intervals at 0.9 hold, {:.3} of independent samples'; ± {half:.3}", a.mean(), b.mean());
    run.claim(&format!("{room}: error bars of four scrambles are as honest"), value, more + half >= 0.0);
}
