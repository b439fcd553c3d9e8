//! The checks of a BSDF for one outgoing direction: integrals and samples.

use std::cell::Cell;

use glam::DVec3;

use super::{BsdfSubject, CheckUp, find_roundoff};
use crate::harness::chi_square::{CELL_DELTA, Counts, chi_square, count};
use crate::harness::copied;
use crate::harness::domain::{Domain, MASS_TOLERANCE, Partition};
use crate::harness::mean::{ROUNDING, Values, all_equal, mean};
use crate::harness::outcome::{Claim, Outcome};
use crate::harness::pointwise::uniform3;
use crate::harness::roundoff::{MAX_ROUNDING_ERROR, RoundoffBounds};
use crate::harness::tails::{binomial_cdf, binomial_sf};
use crate::harness::trial::Context;

/// Number of samples that measure how far rounding moves integrals.
const ROUNDING_PROBES: usize = 2000;
/// Probability that a number of samples that chance explains, of those that rounding put onto the
/// horizon or of lost ones, is taken for an error: a thousandth of a trial's share of the error
/// budget.
const COUNT_LEVEL: f64 = 1e-12;

/// Number of cells of the fine chi-square, which shows what few cells cannot: a ring around a whole
/// lobe.
const FINE_CELLS: usize = 128;
/// Fraction of the chi-square's level given to the fine cells: so little that the few cells decide
/// as they would alone.
const FINE_LEVEL_FRACTION: f64 = 1e-3;

/// Effect of the subject's precision on its integrals for one outgoing direction.
struct RoundingEffect {
    rounding: RoundoffBounds,
    /// Sampled directions, each with the relative error of f cos and of the pdf that rounding
    /// explains there; empty in double precision.
    probes: Vec<(DVec3, f64)>,
    /// Mean of these errors.
    mean: f64,
}

impl RoundingEffect {
    /// Estimates the errors from the conditioning at samples of the subject.
    fn new(
        subject: &BsdfSubject,
        wo: DVec3,
        rounding: RoundoffBounds,
        mut draw: impl FnMut() -> [f64; 3],
    ) -> Self {
        let count = if rounding.is_coarse() {
            ROUNDING_PROBES
        } else {
            0
        };
        let probes: Vec<(DVec3, f64)> = (0..count)
            .filter_map(|_| subject.sample(wo, draw().map(|u| rounding.round_down(u))))
            .map(|s| {
                let pdf = rounding.conditioning(wo, s.wi, &|wo, wi| subject.pdf(wo, wi));
                let f_cos = rounding.conditioning(wo, s.wi, &|wo, wi| subject.f_cos(wo, wi));
                // A zero f beside a positive pdf is zero with any rounding.
                let f_cos = if subject.eval(wo, s.wi) == 0.0 {
                    0.0
                } else {
                    f_cos
                };
                let bound = rounding.tolerance() + pdf.max(f_cos);
                (s.wi, bound.min(MAX_ROUNDING_ERROR))
            })
            .collect();
        let mean = mean_of(probes.iter().map(|(_, bound)| *bound));
        Self {
            rounding,
            probes,
            mean,
        }
    }

    /// Returns how accurately integrals of size about one can be known.
    fn integral_tolerance(&self) -> f64 {
        MASS_TOLERANCE + self.mean
    }

    /// Returns the outcome, or an undecided one if rounding might hide an error of half a percent.
    fn undecided_if_coarse(&self, outcome: Outcome) -> Outcome {
        if self.mean <= 0.5 * MAX_ROUNDING_ERROR {
            return outcome;
        }
        let why = format!(
            "in {} rounding alone explains errors of {:.1e} and more",
            self.rounding.words(),
            self.mean
        );
        outcome.undecided(&why, u64::MAX)
    }
}

/// Returns the mean of the numbers; 0 if there are none.
fn mean_of(numbers: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = numbers.fold((0.0, 0), |(sum, count), number| (sum + number, count + 1));
    sum / f64::from(count.max(1))
}

/// Weights of samples, plain and with a control variate for lost samples.
struct Weights {
    plain: Values,
    /// A lost sample counts as the mean weight of the others, minus the expected contribution of
    /// such samples.
    controlled: Values,
    /// Mean weight of the samples that are not lost.
    mean_kept_weight: f64,
    /// Probability of a loss, and its largest error.
    loss: f64,
    loss_error: f64,
}

impl Weights {
    fn new(albedo: f64, partition: &Partition) -> Self {
        let mean_kept_weight = albedo / partition.mass();
        Self {
            plain: Values::new(albedo),
            controlled: Values::new(albedo),
            mean_kept_weight,
            loss: partition.loss,
            loss_error: partition.error,
        }
    }

    fn push(&mut self, weight: Option<f64>) {
        self.plain.push(weight.unwrap_or(0.0));
        self.controlled
            .push(weight.unwrap_or(self.mean_kept_weight) - self.mean_kept_weight * self.loss);
    }

    /// Returns the values whose mean is the albedo. The number of lost samples is tested
    /// separately; where it is small, those few alone would make plain weights too skewed for a
    /// test.
    fn values(self, rounding: RoundoffBounds, lost: u64) -> Values {
        let controlled =
            lost > 0 && self.mean_kept_weight.is_finite() && self.plain.moments.variance() > 0.0;
        let better = rounding.is_coarse()
            || (self.plain.valid_from() > self.plain.moments.count() && self.explains(lost));
        if controlled && better {
            self.controlled
        } else {
            self.plain
        }
    }

    /// Returns whether the pdf explains the number of lost samples. Where it does not, the control
    /// variate would hide its error: with a pdf that is too high, fewer samples are expected to be
    /// lost than are, which makes up for the weights that are too low.
    fn explains(&self, lost: u64) -> bool {
        let n = self.plain.moments.count();
        let [least, most] = [-1.0, 1.0].map(|sign| self.loss + sign * self.loss_error);
        binomial_sf(lost, n, most.min(1.0)) >= COUNT_LEVEL
            && binomial_cdf(lost, n, least.max(0.0)) >= COUNT_LEVEL
    }
}

/// Integrals over all directions, for one outgoing direction.
struct Integrals {
    effect: RoundingEffect,
    /// Grid of the pdf's quantiles.
    fine_grid: Partition,
    albedo: f64,
    of_pdf: Outcome,
}

impl Integrals {
    fn new(
        subject: &BsdfSubject,
        size: &CheckUp,
        context: &Context,
        wo: DVec3,
        degrees: f64,
    ) -> Self {
        let rounding = size.rounding(|| find_roundoff(subject, context));
        let mut probes = context.rng(&format!("rounding at {degrees}"));
        let effect = RoundingEffect::new(subject, wo, rounding, || uniform3(&mut probes));
        let f_cos = |wi| subject.f_cos(wo, wi);
        let albedo = subject
            .domain()
            .integrate_all(effect.integral_tolerance(), &f_cos);
        let name = format!("integral of the pdf at {degrees} degrees");
        Self {
            fine_grid: fine_grid(subject, wo, &effect),
            albedo: albedo.value,
            of_pdf: pdf_integral(subject, wo, &name, &effect),
            effect,
        }
    }
}

/// Runs the checks for one outgoing direction, `degrees` from the normal.
pub fn at_direction(
    subject: &BsdfSubject,
    size: &CheckUp,
    context: &Context,
    wo: DVec3,
    degrees: f64,
) -> Vec<Outcome> {
    let integrals = context.once(&format!("integrals at {degrees}"), || {
        Integrals::new(subject, size, context, wo, degrees)
    });
    let Integrals {
        effect,
        fine_grid,
        albedo,
        of_pdf,
    } = &*integrals;
    let (rounding, albedo, tolerance) = (effect.rounding, *albedo, effect.integral_tolerance());
    let n = context.n(size.samples);
    let mut weights = Weights::new(albedo, fine_grid);
    let mut rng = context.rng(&format!("samples at {degrees}"));
    let draw = || {
        let sample = subject.sample(wo, uniform3(&mut rng).map(|u| rounding.round_down(u)));
        // A lost sample has weight 0, and counts.
        weights.push(sample.map(|s| s.weight));
        sample.map(|s| s.wi)
    };
    let horizon = Cell::new(0);
    let mut counts = count(fine_grid, n, draw, |wi| {
        let pdf = subject.pdf(wo, wi);
        let rounded = pdf == 0.0 && rounding.at_horizon(wi);
        horizon.set(horizon.get() + u64::from(rounded));
        rounded || (pdf > 0.0 && pdf.is_finite())
    });
    if exceeds_rounding(subject, wo, rounding, &counts, horizon.get()) {
        counts.forbidden += horizon.get();
        counts.example.get_or_insert(DVec3::X);
    }
    let values = weights.values(effect.rounding, counts.lost);
    let at = |what: &str| format!("{what} at {degrees} degrees");
    let mut outcomes = vec![
        of_pdf.clone(),
        chi_square_of_samples(
            &at("chi-square of samples"),
            fine_grid,
            size.cells,
            &counts,
            effect,
        ),
        furnace_test(
            subject,
            wo,
            &at("furnace"),
            &values,
            albedo,
            effect,
            size.delta,
        ),
        Outcome::identity(
            at("energy bound"),
            1,
            (albedo - subject.energy_bound).max(0.0),
            tolerance,
            format!("directional albedo {albedo:.6}"),
        ),
    ];
    if let Some(known) = &subject.albedo {
        let known = known(copied(wo));
        outcomes.push(Outcome::identity(
            at("directional albedo"),
            1,
            (albedo - known).abs(),
            MASS_TOLERANCE + tolerance,
            format!("{albedo:.9} by quadrature, {known:.9} in closed form"),
        ));
    }
    outcomes
        .into_iter()
        .map(|outcome| effect.undecided_if_coarse(outcome))
        .collect()
}

/// Returns the grid of the pdf's quantiles on which samples are counted.
fn fine_grid(subject: &BsdfSubject, wo: DVec3, effect: &RoundingEffect) -> Partition {
    let pdf = |wi| subject.pdf(wo, wi);
    if effect.rounding.is_coarse() {
        Partition::fine_grid(subject.domain(), effect.integral_tolerance(), &pdf)
            .rounding(effect.rounding.tolerance())
    } else {
        Partition::fine_grid(subject.domain(), MASS_TOLERANCE, &pdf)
    }
}

/// Merges the grid cells into about `cells` cells of nearly equal probability. In single precision
/// their probabilities may be off by the pdf's rounding and by the remaining quadrature error.
fn coarsened(fine_grid: &Partition, cells: usize, effect: &RoundingEffect) -> Partition {
    let mut partition = fine_grid.coarsened(cells);
    if effect.rounding.is_coarse() {
        let mut probes = vec![Vec::new(); partition.masses.len()];
        for (wi, bound) in &effect.probes {
            if let Some(cell) = partition.cell(*wi) {
                probes[cell].push(*bound);
            }
        }
        let relative = (partition.masses.iter().zip(probes))
            .filter(|(mass, _)| **mass > 0.0)
            .map(|(mass, probes)| mean_of(probes.into_iter()) + partition.error / mass);
        partition.relative = relative.fold(0.0, f64::max);
        partition.error = MASS_TOLERANCE;
    }
    partition
}

/// Tests samples by chi-square over few cells, each probability to [`CELL_DELTA`], and over many.
fn chi_square_of_samples(
    name: &str,
    fine_grid: &Partition,
    cells: usize,
    counts: &Counts,
    effect: &RoundingEffect,
) -> Outcome {
    let over = |cells: usize| {
        let partition = coarsened(fine_grid, cells, effect);
        chi_square(name, &partition, &counts.coarsened(&partition), CELL_DELTA)
    };
    let [coarse, fine] = [over(cells), over(FINE_CELLS)];
    let p = (coarse.p / (1.0 - FINE_LEVEL_FRACTION)).min(1.0);
    // Where there are too many samples for the quadrature's accuracy, the few cells judge alone.
    let finer = fine.p / FINE_LEVEL_FRACTION;
    let (p, worst) = if fine.valid_from <= fine.n && finer < p {
        (finer, fine.worst)
    } else {
        (p, coarse.worst)
    };
    Outcome { p, worst, ..coarse }
}

/// Returns whether more samples lie on the horizon without a pdf than the pdf has near it.
fn exceeds_rounding(
    subject: &BsdfSubject,
    wo: DVec3,
    rounding: RoundoffBounds,
    counts: &Counts,
    horizon: u64,
) -> bool {
    let near = rounding.horizon();
    let rows = if subject.domain() == Domain::Sphere {
        [0.5 - 0.5 * near, 0.5 + 0.5 * near]
    } else {
        [1.0 - near, 1.0]
    };
    let mass = || {
        let (part, pdf) = ([rows, [0.0, 1.0]], |wi| subject.pdf(wo, wi));
        let integral = subject.domain().integrate(part, MASS_TOLERANCE, &pdf);
        integral.value + integral.error + MASS_TOLERANCE
    };
    horizon > 0 && binomial_sf(horizon, counts.n, mass()) < COUNT_LEVEL
}

fn pdf_integral(subject: &BsdfSubject, wo: DVec3, name: &str, effect: &RoundingEffect) -> Outcome {
    let (tolerance, pdf) = (0.25 * effect.integral_tolerance(), |wi| subject.pdf(wo, wi));
    let integral = subject.domain().integrate_all(tolerance, &pdf);
    let error = nan_or(integral.value, subject.loss.error(integral.value, wo));
    let worst = format!(
        "the pdf integrates to {:.9} (quadrature error {:.1e})",
        integral.value, integral.error
    );
    Outcome::identity(name, 1, error, effect.integral_tolerance(), worst)
}

/// Checks that the mean weight is the directional albedo by quadrature, as far as that is known.
/// Constant weights are right if quadrature, too, finds f cos/pdf the same for all directions; then
/// each of them must be the albedo.
fn furnace_test(
    subject: &BsdfSubject,
    wo: DVec3,
    name: &str,
    values: &Values,
    albedo: f64,
    effect: &RoundingEffect,
    delta: f64,
) -> Outcome {
    let deviation = |wi| {
        // f cos/pdf − albedo, weighted by the pdf; where the pdf is zero, f must be zero.
        (subject.f_cos(wo, wi) - albedo * subject.pdf(wo, wi)).abs()
    };
    let tolerance = effect.integral_tolerance();
    let coarse = effect.rounding.is_coarse();
    let spread = values.moments.variance().sqrt();
    let min_spread = if coarse {
        effect.rounding.tolerance()
    } else {
        ROUNDING
    };
    let constant = || subject.domain().integrate_all(tolerance, &deviation);
    let estimate = values.moments.mean();
    if spread <= min_spread * albedo && constant().value <= 2.0 * tolerance {
        if coarse {
            // All weights are equal up to rounding, and their mean is known to less than that.
            let worst =
                format!("mean weight {estimate}, varying by {spread:.1e}; each should be {albedo}");
            let (n, error) = (values.moments.count(), (estimate - albedo).abs());
            return Outcome::identity(name, n, error, tolerance, worst);
        }
        return all_equal(name, values.moments, albedo, MASS_TOLERANCE);
    }
    let claim = Claim::Equal {
        delta: delta * albedo,
    };
    // An estimate within the accuracy of the albedo counts as equal to it, however small its
    // variance.
    let reference = if (estimate - albedo).abs() <= tolerance {
        estimate
    } else if coarse {
        albedo + tolerance.copysign(estimate - albedo)
    } else {
        albedo
    };
    mean(name, values, reference, claim)
}

/// Keeps NaN, which `f64::max` drops.
fn nan_or(value: f64, error: f64) -> f64 {
    if value.is_nan() { value } else { error }
}
