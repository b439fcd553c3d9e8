//! Tail probabilities and quantiles that stay valid down to 1e-300: tails are computed as tails,
//! never as 1 − cdf.
//!
//! Incomplete gamma and beta functions are evaluated by series and continued fractions (Lentz's
//! method; Press et al., Numerical Recipes, 3rd ed., 6.2 and 6.4). Their prefactors use the
//! deviance and Stirling's remainder (Loader, "Fast and Accurate Computation of Binomial
//! Probabilities", 2000), so that they do not cancel for large arguments.
//! `tests/library/harness/tails.rs` compares every function with values of 25 digits.

use statrs::function::erf::erfc;
use statrs::function::gamma::ln_gamma;

const LN_SQRT_TAU: f64 = 0.918_938_533_204_672_8;
/// Relative change of the sum at which series and fractions stop.
const SERIES_TOLERANCE: f64 = 1e-16;
/// Bound that keeps Lentz's denominators from zero.
const MIN_DENOMINATOR: f64 = 1e-300;

/// Returns P(Z ≥ z) of the standard normal distribution.
pub fn normal_sf(z: f64) -> f64 {
    0.5 * erfc(z * std::f64::consts::FRAC_1_SQRT_2)
}

/// Returns the z with P(Z ≥ z) = p, for p in (0, 1).
pub fn normal_upper(p: f64) -> f64 {
    if p > 0.5 {
        return -normal_upper(1.0 - p);
    }
    decreasing_root(normal_sf, p, 0.0, 40.0)
}

/// Returns P(|T| ≥ |t|) of Student's distribution with `dof` > 0 degrees of freedom.
pub fn student_two_sided(t: f64, dof: f64) -> f64 {
    if !t.is_finite() {
        return if t.is_nan() { f64::NAN } else { 0.0 };
    }
    let scale = dof + t * t;
    beta(0.5 * dof, 0.5, dof / scale, t * t / scale)
}

/// Returns the t with P(T ≥ t) = p, for p in (0, 1/2], of Student's distribution.
pub fn student_upper(p: f64, dof: f64) -> f64 {
    let mut high = 64.0;
    while student_two_sided(high, dof) > 2.0 * p {
        high *= 16.0;
    }
    decreasing_root(|t| student_two_sided(t, dof), 2.0 * p, 0.0, high)
}

/// Returns P(X ≥ x) of the chi-square distribution with `dof` > 0 degrees of freedom.
pub fn chi_square_sf(x: f64, dof: f64) -> f64 {
    gamma_q(0.5 * dof, 0.5 * x)
}

/// Returns the x with P(X ≥ x) = p of the chi-square distribution with `dof` > 0 degrees of
/// freedom.
pub fn chi_square_upper(p: f64, dof: f64) -> f64 {
    let mut high = 64.0 + 2.0 * dof;
    while chi_square_sf(high, dof) > p {
        high *= 2.0;
    }
    decreasing_root(|x| chi_square_sf(x, dof), p, 0.0, high)
}

/// Returns P(X ≤ x) of the noncentral chi-square distribution: a Poisson mixture, with mean
/// `noncentrality`/2 ≥ 0, of central distributions with `dof` + 2j degrees of freedom (Johnson,
/// Kotz and Balakrishnan, Continuous Univariate Distributions 2, 1995, chapter 29). All terms are
/// positive: the tail keeps its digits.
pub fn noncentral_chi_square_cdf(x: f64, dof: f64, noncentrality: f64) -> f64 {
    let half = 0.5 * noncentrality;
    let (mut sum, mut j) = (0.0, 0.0);
    loop {
        let weight = if half > 0.0 {
            (j * half.ln() - half - ln_gamma(j + 1.0)).exp()
        } else if j == 0.0 {
            1.0
        } else {
            0.0
        };
        let term = weight * gamma_p(0.5 * dof + j, 0.5 * x);
        sum += term;
        j += 1.0;
        // The weights fall beyond their mean, the central tails everywhere.
        if j > half && term <= SERIES_TOLERANCE * sum {
            return sum;
        }
    }
}

/// Returns P(F ≥ f) of the F distribution with `d1` and `d2` degrees of freedom.
pub fn f_sf(f: f64, d1: f64, d2: f64) -> f64 {
    let scale = d1 * f + d2;
    beta(0.5 * d2, 0.5 * d1, d2 / scale, d1 * f / scale)
}

/// Returns P(√n D ≥ x) of Kolmogorov's limit distribution.
pub fn kolmogorov_limit_sf(x: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if x <= 0.0 {
        return 1.0;
    }
    if x < 0.5 {
        // Lower tail by the distribution's other series; its second term is less than 1e-17 of the
        // first.
        let lower = TAU.sqrt() / x * (-(PI / x).powi(2) / 8.0).exp();
        return 1.0 - lower;
    }
    let term = |k: f64| (-2.0 * k * k * x * x).exp();
    let pairs = (0..6).map(|k| term(2.0 * f64::from(k) + 1.0) - term(2.0 * f64::from(k) + 2.0));
    2.0 * pairs.sum::<f64>()
}

/// Probability below which [`kolmogorov_sf`] is a proved bound.
pub const KOLMOGOROV_BOUND_LEVEL: f64 = 1e-4;

/// Returns P(D ≥ d) of Kolmogorov's statistic of n independent values, for n ≥ 100.
///
/// Above [`KOLMOGOROV_BOUND_LEVEL`] the limit distribution at √n d + 1/(6√n) + (√n d − 1)/(4n)
/// (Vrbik, "Small-Sample Corrections to Kolmogorov-Smirnov Test Statistic", 2018), with an absolute
/// error below 1e-3 for n ≥ 100; below it the inequality 2 exp(−2nd²) ≥ P (Massart, Ann. Probab.
/// 18(3), 1990), which holds for every n: such a p-value is never too small.
pub fn kolmogorov_sf(n: u64, d: f64) -> f64 {
    let n = n as f64;
    let x = n.sqrt() * d;
    let body = kolmogorov_limit_sf(x + 1.0 / (6.0 * n.sqrt()) + (x - 1.0) / (4.0 * n));
    if body > KOLMOGOROV_BOUND_LEVEL {
        body
    } else {
        (2.0 * (-2.0 * x * x).exp()).min(KOLMOGOROV_BOUND_LEVEL)
    }
}

/// Returns the d with P(D ≥ d) ≤ p, for p ≤ [`KOLMOGOROV_BOUND_LEVEL`]: Massart's inequality solved
/// for d.
pub fn kolmogorov_upper(n: u64, p: f64) -> f64 {
    ((2.0 / p).ln() / (2.0 * n as f64)).sqrt()
}

/// Returns P(X ≥ k) of the binomial distribution of n trials with success probability q in [0, 1].
pub fn binomial_sf(k: u64, n: u64, q: f64) -> f64 {
    if k == 0 {
        1.0
    } else if k > n || q <= 0.0 {
        0.0
    } else {
        beta(k as f64, (n - k + 1) as f64, q, 1.0 - q)
    }
}

/// Returns P(X ≤ k) of the binomial distribution of n trials with success probability q.
pub fn binomial_cdf(k: u64, n: u64, q: f64) -> f64 {
    if k >= n {
        1.0
    } else {
        beta((n - k) as f64, (k + 1) as f64, 1.0 - q, q)
    }
}

/// Returns twice the smaller binomial tail, at most 1: the two-sided p-value of k successes.
pub fn binomial_two_sided(k: u64, n: u64, q: f64) -> f64 {
    (2.0 * binomial_sf(k, n, q).min(binomial_cdf(k, n, q))).min(1.0)
}

/// Returns the interval for a success probability after k of n, each side at level `p` (Clopper and
/// Pearson 1934: it covers at least 1 − 2p for every n).
pub fn binomial_interval(k: u64, n: u64, p: f64) -> [f64; 2] {
    let low = if k == 0 {
        0.0
    } else {
        decreasing_root(|q| -binomial_sf(k, n, q), -p, 0.0, 1.0)
    };
    let high = if k == n {
        1.0
    } else {
        decreasing_root(|q| binomial_cdf(k, n, q), p, 0.0, 1.0)
    };
    [low, high]
}

/// Returns P(X ≥ k) of the Poisson distribution with the given mean.
pub fn poisson_sf(k: u64, mean: f64) -> f64 {
    if k == 0 { 1.0 } else { gamma_p(k as f64, mean) }
}

/// Returns P(X ≤ k) of the Poisson distribution with the given mean.
pub fn poisson_cdf(k: u64, mean: f64) -> f64 {
    gamma_q(k as f64 + 1.0, mean)
}

/// Returns the interval for a Poisson mean after k events, each side at level `p` (Garwood,
/// Biometrika 28, 1936: it covers at least 1 − 2p).
pub fn poisson_interval(k: u64, p: f64) -> [f64; 2] {
    let largest = 2.0 * k as f64 - 4.0 * p.ln() + 64.0;
    let low = decreasing_root(|mean| -poisson_sf(k, mean), -p, 0.0, largest);
    let high = decreasing_root(|mean| poisson_cdf(k, mean), p, 0.0, largest);
    [if k == 0 { 0.0 } else { low }, high]
}

/// Returns ln Γ(a) − [(a − ½) ln a − a + ln √2π], Stirling's remainder, for a > 0.
fn stirling_remainder(a: f64) -> f64 {
    /// Argument from which five terms of the series give 16 digits.
    const SERIES_FROM: f64 = 16.0;
    if a < SERIES_FROM {
        return ln_gamma(a) - ((a - 0.5) * a.ln() - a + LN_SQRT_TAU);
    }
    let s = 1.0 / (a * a);
    (1.0 / 12.0 - s * (1.0 / 360.0 - s * (1.0 / 1260.0 - s * (1.0 / 1680.0 - s / 1188.0)))) / a
}

/// Returns x − ln(1 + x) for x > −1, without cancellation near 0. `whole` is 1 + x: where that is
/// small, it has digits that x has lost.
fn log_defect(x: f64, whole: f64) -> f64 {
    if x.abs() > 0.05 {
        return x - whole.ln();
    }
    // x²/2 − x³/3 + …: fourteen terms reach 1e-18 of the first.
    let series = (2..16)
        .rev()
        .fold(0.0, |sum, k| 1.0 / f64::from(k) - x * sum);
    x * x * series
}

/// Returns x^a e^(−x)/Γ(a).
fn gamma_prefactor(a: f64, x: f64) -> f64 {
    let deviance = a * log_defect((x - a) / a, x / a);
    (0.5 * a.ln() - LN_SQRT_TAU - deviance - stirling_remainder(a)).exp()
}

/// Returns the upper regularised incomplete gamma function Q(a, x), a > 0.
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        1.0
    } else if x < a + 1.0 {
        1.0 - gamma_series(a, x)
    } else {
        gamma_fraction(a, x)
    }
}

/// Returns the lower regularised incomplete gamma function P(a, x), a > 0.
pub fn gamma_p(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        0.0
    } else if x < a + 1.0 {
        gamma_series(a, x)
    } else {
        1.0 - gamma_fraction(a, x)
    }
}

fn gamma_series(a: f64, x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0 / a, 1.0 / a, a);
    while term > SERIES_TOLERANCE * sum {
        k += 1.0;
        term *= x / k;
        sum += term;
    }
    sum * gamma_prefactor(a, x)
}

fn gamma_fraction(a: f64, x: f64) -> f64 {
    let b = x + 1.0 - a;
    let fraction = lentz(b, |i| (-i * (i - a), b + 2.0 * i));
    gamma_prefactor(a, x) / fraction
}

/// Evaluates b₀ + a₁/(b₁ + a₂/(b₂ + …)) with (aᵢ, bᵢ) = `term(i)`, by the modified Lentz method.
fn lentz(b0: f64, term: impl Fn(f64) -> (f64, f64)) -> f64 {
    let away_from_zero = |x: f64| {
        if x.abs() < MIN_DENOMINATOR {
            MIN_DENOMINATOR
        } else {
            x
        }
    };
    let mut value = away_from_zero(b0);
    let (mut c, mut d, mut i) = (value, 0.0, 0.0);
    loop {
        i += 1.0;
        let (a, b) = term(i);
        d = 1.0 / away_from_zero(b + a * d);
        c = away_from_zero(b + a / c);
        let step = c * d;
        value *= step;
        // The fractions used here converge long before this many steps, or never.
        if (step - 1.0).abs() <= 4.0 * SERIES_TOLERANCE || step.is_nan() || i > 1e7 {
            return value;
        }
    }
}

/// Returns the regularised incomplete beta function I_x(a, b); y = 1 − x is given separately, so
/// that neither is rounded away.
pub fn beta(a: f64, b: f64, x: f64, y: f64) -> f64 {
    if x <= 0.0 {
        0.0
    } else if y <= 0.0 {
        1.0
    } else if x * (a + b + 2.0) <= a + 1.0 {
        beta_fraction(a, b, x, y)
    } else {
        1.0 - beta_fraction(b, a, y, x)
    }
}

fn beta_fraction(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let fraction = lentz(1.0, |i| {
        let m = (0.5 * i).floor();
        let numerator = if i % 2.0 == 0.0 {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        };
        (numerator, 1.0)
    });
    beta_prefactor(a, b, x, y) / (a * fraction)
}

/// Returns x^a y^b / B(a, b).
fn beta_prefactor(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let sum = a + b;
    // Distance of x from the mean a/(a + b), computed symmetrically in x and y.
    let shift = x * b - y * a;
    let deviance = a * log_defect(shift / a, x * sum / a) + b * log_defect(-shift / b, y * sum / b);
    let remainders = stirling_remainder(sum) - stirling_remainder(a) - stirling_remainder(b);
    (0.5 * (a * b / sum).ln() - LN_SQRT_TAU - deviance + remainders).exp()
}

/// Returns where a decreasing function takes a value, to the last bit, by bisection of [low, high].
fn decreasing_root(f: impl Fn(f64) -> f64, value: f64, mut low: f64, mut high: f64) -> f64 {
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if f(middle) > value {
            low = middle;
        } else {
            high = middle;
        }
    }
}
