//! Comparison of two variants of a render by the variance of their pixels, for `adaptive`,
//! `scrambles` and `specular`.

use crate::experiments::prelude::*;

/// Number of films whose spread is one estimate of the variance.
pub(super) const GROUP: usize = 4;

/// One of the compared renders.
pub(super) struct Variant {
    /// Name, from which the films' seeds are derived.
    pub label: String,
    /// Name on the progress bar.
    pub bar: String,
    /// The render; its seed is replaced.
    pub job: Job,
}

/// Results of the films of a variant.
pub(super) struct VariantResult {
    /// Variance of a pixel's channel, a value for each group of films.
    pub variance: Moments,
    /// Mean of the image, a value for each film.
    pub mean: Moments,
}

impl Variant {
    /// Renders `groups` groups of films.
    pub fn render(&self, run: &Run, groups: usize) -> Result<VariantResult, Error> {
        let [mut variance, mut mean] = [Moments::default(); 2];
        for group in 0..groups {
            let films = (0..GROUP)
                .map(|k| self.film(run, GROUP * group + k))
                .collect::<Result<Vec<_>, _>>()?;
            films.iter().for_each(|film| mean.push(film.mean()));
            variance.push(mean_variance(&films));
        }
        Ok(VariantResult { variance, mean })
    }

    /// Renders film number `k`.
    pub fn film(&self, run: &Run, k: usize) -> Result<Film, Error> {
        let seed = seed_for(run.seed(), &format!("{} {k}", self.label));
        let job = run.with_run_options(self.job);
        Job { seed, ..job }.render(&self.bar)?.into_complete()
    }
}

/// Returns the mean over pixels and channels of the variance among films.
fn mean_variance(films: &[Film]) -> f64 {
    let pixels = films[0].pixels().len();
    let of = |at: usize, channel: usize| {
        films
            .iter()
            .map(|film| film.pixels()[at].mean()[channel])
            .collect::<Moments>()
            .variance()
    };
    (0..pixels)
        .map(|at| (0..3).map(|channel| of(at, channel)).sum::<f64>())
        .sum::<f64>()
        / (3.0 * pixels as f64)
}

/// Returns the first mean over the second, and the half width of its logarithm's interval at a
/// level.
pub(super) fn ratio_interval([a, b]: [&Moments; 2], level: f64) -> (f64, f64) {
    let relative = |m: &Moments| m.standard_error() / m.mean();
    let critical = student_upper(level / 2.0, a.count() as f64 - 1.0);
    (
        a.mean() / b.mean(),
        critical * relative(a).hypot(relative(b)),
    )
}

/// Claims that the second of two variances is smaller; returns the ratio of the first to the
/// second.
pub(super) fn claim_gain(run: &mut Run, what: &str, variances: [&Moments; 2], level: f64) -> f64 {
    let (gain, half) = ratio_interval(variances, level);
    let [low, high] = [-half, half].map(|off| gain * off.exp());
    let value = format!("variance {gain:.2} times smaller, interval [{low:.2}, {high:.2}]");
    run.claim(what, value, judge_above([low, high], 1.0));
    gain
}

/// Judges whether a value with this confidence interval lies above a limit.
pub(super) fn judge_above([low, high]: [f64; 2], limit: f64) -> Judgement {
    if low > limit {
        Judgement::Holds
    } else if high < limit {
        Judgement::Fails
    } else {
        Judgement::Undecided
    }
}
