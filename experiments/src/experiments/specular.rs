//! What shadow rays by way of mirrors and balls of glass gain, and that the mean stays.

use super::adaptive::variance;
use super::scrambles::above;
use crate::experiments::prelude::*;
use crate::render::{AdaptiveName, OutlinesName, SamplerName, SpecularName};

pub(super) const SPECULAR: Experiment = Experiment {
    id: "specular",
    title: "shadow rays by way of mirrors and balls of glass: variance, and the same mean",
    version: 1,
    equations: &[&equation::SPECULAR_ANGLE, &equation::SPECULAR_SPREAD],
    run,
};

/// Samples per pixel.
const SAMPLES: u32 = 128;
/// Films whose spread is one estimate of the variance.
const GROUP: usize = 4;
/// The means may differ by this share.
const MARGIN: f64 = 0.001;

fn run(run: &mut Run) -> Result<(), Error> {
    let groups = run.by_tier(4, 24);
    let room = name(SceneName::Report);
    let film = |specular_shadow_rays, spp, k: usize| {
        let (sampler, outlines, adaptive) = (SamplerName::Sobol, OutlinesName::Yes, AdaptiveName::No);
        let job = Job { sampler, outlines, adaptive, spp, specular_shadow_rays, size: [128, 96], ..Job::default() };
        let seed = seed_for(run.seed(), &format!("{specular_shadow_rays:?} {spp} {k}"));
        Job { seed, ..run.prepared(job) }.render(&room)?.whole()
    };
    let ways = [SpecularName::No, SpecularName::Yes];
    let (mut variances, mut means) = ([Moments::default(); 2], [Moments::default(); 2]);
    for (way, (variances, means)) in ways.into_iter().zip(variances.iter_mut().zip(&mut means)) {
        for group in 0..groups {
            let films: Vec<Film> =
                (0..GROUP).map(|k| film(way, SAMPLES, GROUP * group + k)).collect::<Result<_, _>>()?;
            films.iter().for_each(|film| means.push(film.mean()));
            variances.push(variance(&films));
        }
    }
    judge(run, &variances, &means);
    let display = Job::default().display(0.0);
    for (way, file) in ways.into_iter().zip(["without.png", "with.png"]) {
        let specular_shadow_rays = way;
        let job = Job {
            specular_shadow_rays,
            sampler: SamplerName::Sobol,
            outlines: OutlinesName::Yes,
            spp: 16,
            ..Job::default()
        };
        let job = Job { size: run.by_tier([128, 96], [256, 192]), ..job };
        let shown = run.prepared(job).render(file)?.whole()?;
        write_png(&run.figure(file), &shown, display, 2)?;
    }
    Ok(())
}

/// The gain, and how far the means are apart.
fn judge(run: &mut Run, variances: &[Moments; 2], means: &[Moments; 2]) {
    let critical = |n: u64| student_upper(FAMILY / 4.0, n as f64 - 1.0);
    let relative = |m: &Moments| m.standard_error() / m.mean();
    let both = |[a, b]: &[Moments; 2]| critical(a.count()) * relative(a).hypot(relative(b));
    let gain = variances[0].mean() / variances[1].mean();
    let half = both(variances);
    let [low, high] = [-half, half].map(|off| gain * off.exp());
    run.number("gain", gain);
    let value = format!("variance {gain:.2} times smaller, interval [{low:.2}, {high:.2}]");
    run.claim("shadow rays by way of mirrors and glass gain", value, above([low, high], 1.0));
    let (apart, half) = (means[1].mean() / means[0].mean() - 1.0, both(means));
    run.number("apart", apart);
    run.number("half-width", half);
    let far = apart.abs();
    let verdict = above([MARGIN - far - half, MARGIN - far + half], 0.0);
    let value = format!("{apart:+.1e} ± {half:.1e} of the mean without, {MARGIN} allowed");
    run.claim("and leave the mean of the image as it is", value, verdict);
}
