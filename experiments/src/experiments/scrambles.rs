//! Number of scrambles that share a pixel's samples: the gain of long sequences against the quality
//! of error bars from few of them.

use super::variants::{GROUP, Variant, claim_gain, judge_above};
use crate::experiments::prelude::*;
use crate::render::SamplerName;

pub(super) const SCRAMBLES: Experiment = Experiment {
    id: "scrambles",
    title: "64 samples of a pixel in 1 to 64 scrambles: variance, and what error bars are worth",
    headline: "four scrambles of Sobol' points beside independent samples: {holds} claims hold, {fails} fail",
    version: 1,
    equations: &[&equation::SOBOL, &equation::ESTIMATOR],
    run,
};

const SAMPLES: u32 = 64;
/// Numbers of scrambles. The last have one point each: independent numbers.
const COUNTS: [u32; 6] = [1, 2, 4, 8, 16, SAMPLES];
/// Index of the default of `render`.
const DEFAULT_INDEX: usize = 2;
/// Nominal coverage of the intervals.
const LEVEL: f64 = 0.9;
/// Largest loss of coverage, compared with intervals of independent samples, at which error bars
/// count as honest.
const MARGIN: f64 = 0.05;

/// Results of films of one room with a number of scrambles, a value for each group of films.
struct RoomResult {
    /// Variance of a pixel.
    variance: Moments,
    /// Fraction of intervals that contain the mean of the other films.
    coverage: Moments,
    /// Half width of an interval.
    half_width: Moments,
}

impl RoomResult {
    fn of(films: &[Film], replications: u32) -> Self {
        let groups: Vec<[f64; 3]> = films
            .chunks_exact(GROUP)
            .map(|group| Self::of_group(group, replications))
            .collect();
        let moments = |k: usize| groups.iter().map(|group| group[k]).collect();
        Self {
            variance: moments(0),
            coverage: moments(1),
            half_width: moments(2),
        }
    }

    /// Returns the mean variance over all pixels, and the means of coverage and half width over the
    /// pixels that vary: an emitter that fills a pixel leaves no error.
    fn of_group(films: &[Film], replications: u32) -> [f64; 3] {
        let n = films.len() as f64;
        // With one replication the error bar is infinite.
        let critical = student_upper(0.5 * (1.0 - LEVEL), f64::from(replications.max(2) - 1));
        let (mut sums, mut differ) = ([0.0; 3], 0.0);
        for i in 0..films[0].pixels().len() {
            let values: Moments = films.iter().map(|film| film.pixels()[i].mean().y).collect();
            if values.variance() == 0.0 {
                continue;
            }
            differ += 1.0;
            sums[0] += values.variance();
            for pixel in films.iter().map(|film| &film.pixels()[i]) {
                let reach = critical * pixel.standard_error().y;
                // Difference from the mean of the other films, which has an error as well.
                let off = (pixel.mean().y - values.mean()) * n / (n - 1.0);
                let holds = off.abs() <= reach * (1.0 + 1.0 / (n - 1.0)).sqrt();
                sums[1] += f64::from(u8::from(holds)) / n;
                sums[2] += reach / n;
            }
        }
        let [variance, coverage, half_width] = sums;
        [
            variance / films[0].pixels().len() as f64,
            coverage / differ,
            half_width / differ,
        ]
    }
}

fn run(run: &mut Run) -> Result<(), Error> {
    let rooms = [
        SceneName::DiffuseRoom,
        SceneName::Report,
        SceneName::Cornell,
        SceneName::CavityCap,
    ];
    let films = run.by_tier(3, 16) * GROUP;
    let mut series = [const { Vec::new() }; 3];
    let mut rows = Vec::new();
    for (colour, scene) in rooms.into_iter().enumerate() {
        let room = name(scene);
        let mut found = Vec::new();
        for scrambles in COUNTS {
            let variant = Variant {
                label: format!("{room}, {scrambles} scrambles, film"),
                bar: room.clone(),
                job: Job {
                    scene: scene.into(),
                    sampler: SamplerName::Sobol,
                    scrambles: Some(scrambles),
                    spp: SAMPLES,
                    size: [32, 24],
                    ..Job::default()
                },
            };
            let films = (0..films)
                .map(|k| variant.film(run, k))
                .collect::<Result<Vec<_>, _>>()?;
            found.push(RoomResult::of(&films, scrambles));
        }
        let [.., independent] = &found[..] else {
            continue;
        };
        let relative = |of: fn(&RoomResult) -> &Moments| {
            let base = of(independent).mean();
            let of = move |found: &RoomResult| {
                [of(found).mean() / base, of(found).standard_error() / base]
            };
            found.iter().map(of).collect::<Vec<_>>()
        };
        let coverage = found
            .iter()
            .map(|found| [found.coverage.mean(), found.coverage.standard_error()])
            .collect();
        let shown = [
            relative(|f| &f.variance),
            coverage,
            relative(|f| &f.half_width),
        ];
        for (k, scrambles) in COUNTS.into_iter().enumerate() {
            let named = ["variance", "coverage", "half_width"]
                .into_iter()
                .zip(&shown);
            // A single scramble has no error bar.
            for (what, values) in named.filter(|_| scrambles > 1) {
                run.number(&format!("{room}.{scrambles}.{what}"), values[k][0]);
            }
            let values: Vec<String> = shown
                .iter()
                .flat_map(|values| values[k])
                .map(|v| format!("{v:e}"))
                .collect();
            rows.push(format!("{room},{scrambles},{}", values.join(",")));
        }
        judge(run, &room, &found[DEFAULT_INDEX], independent);
        for (series, (values, from)) in series.iter_mut().zip(shown.iter().zip([0, 1, 1])) {
            let points = COUNTS
                .into_iter()
                .zip(values)
                .skip(from)
                .map(|(n, [v, e])| [f64::from(n), *v, *e]);
            series.push(Series::measured(&room, colour, points));
        }
    }
    let columns = "room,scrambles,variance,error,coverage,error,half width,error";
    run.csv("scrambles.csv", columns, &rows)?;
    let [variance, coverage, half_width] = series;
    let x = [0.8, 90.0];
    let chart = |title: &str, y: &str, range, series, log| {
        Chart::new(
            title,
            ["scrambles that share 64 samples", y],
            [x, range],
            series,
        )
        .log([true, log])
    };
    let charts_shown = [
        chart(
            "Variance of a pixel",
            "over that of independent samples",
            [0.03, 4.0],
            variance,
            true,
        ),
        chart(
            "Student's intervals at 90 %",
            "share that hold the mean",
            [0.4, 1.1],
            coverage,
            false,
        ),
        chart(
            "Half their width",
            "over that of independent samples",
            [0.2, 12.0],
            half_width,
            true,
        ),
    ];
    let description = "The fewer scrambles, the smaller the variance; with two their intervals are several times as wide.";
    charts(run, "scrambles.svg", description, 1200, &charts_shown)
}

/// Claims that four sequences per pixel reduce the variance, and that their error bars are as
/// honest as those of independent samples.
fn judge(run: &mut Run, room: &str, ours: &RoomResult, independent: &RoomResult) {
    let critical = |n: u64| student_upper(FAMILYWISE_LEVEL / 2.0 / 8.0, n as f64 - 1.0);
    let variances = [independent, ours].map(|found| &found.variance);
    claim_gain(
        run,
        &format!("{room}: four scrambles gain"),
        variances,
        FAMILYWISE_LEVEL / 8.0,
    );
    let [a, b] = [ours, independent].map(|found| &found.coverage);
    let more = a.mean() - b.mean();
    let half = critical(a.count()) * a.standard_error().hypot(b.standard_error());
    let value = format!(
        "{:.3} of intervals at 0.9 hold, {:.3} of independent samples'; ± {half:.3}",
        a.mean(),
        b.mean()
    );
    let verdict = judge_above([more - half, more + half], -MARGIN);
    run.claim(
        &format!("{room}: error bars of four scrambles are as honest"),
        value,
        verdict,
    );
}
