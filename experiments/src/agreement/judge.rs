//! What a cell of the matrix says: the interval of its mean, and the maps of its tiles and pixels.

use whitefurnace::harness::mean::{Values, welch_satterthwaite};
use whitefurnace::harness::outcome::{Verdict, approximate_verdict};
use whitefurnace::harness::tails::student_upper;
use whitefurnace::harness::welch_map::{PValueMap, PixelStatistics, map};
use whitefurnace::moments::Moments;

use super::{Cell, Claim, Reference, SIZE, TILE, Total, margin};
use crate::job::{EstimatorName, name};
use crate::lab::Lab;
use crate::plot::agreement::{Square, Standing};

/// Intervals narrower than this are rounding, whose skewness says nothing.
const NOTHING: f64 = 1e-9;

/// Compares a cell with its reference, records it, and returns what the matrix shows.
pub(super) fn judge(
    lab: &mut Lab,
    cell: &Cell,
    total: &Total,
    (reference, totals): (&Reference, &[Total]),
    level: f64,
) -> Square {
    let own = total.moments;
    let (mean, other) = match reference {
        Reference::Known(mean) => (*mean, None),
        Reference::Rendered(at) => (totals[*at].moments.mean(), Some(&totals[*at])),
    };
    if let (Reference::Rendered(_), EstimatorName::Mis) = (reference, cell.estimator) {
        let error = 100.0 * own.standard_error() / own.mean();
        lab.note(
            &format!("{}: {}", name(cell.scene), name(cell.estimator)),
            format!("reference, {:.6} ± {error:.3} % standard error", own.mean()),
        );
        return Square {
            text: format!("{:.4} ± {error:.2} %", own.mean()),
            standing: Standing::Reference,
        };
    }
    let part = |m: Moments| (m.variance() / m.count() as f64, m.count());
    let parts = || std::iter::once(part(own)).chain(other.map(|total| part(total.moments)));
    let standard_error = parts().map(|(v, _)| v).sum::<f64>().sqrt();
    let dof = welch_satterthwaite(parts()).max(1.0);
    let half = student_upper(0.5 * level, dof) * standard_error / mean;
    let difference = own.mean() / mean - 1.0;
    let interval = [difference - half, difference + half];
    let key = format!("{}.{}", name(cell.scene), name(cell.estimator));
    lab.number(&format!("{key}.difference"), difference);
    lab.number(&format!("{key}.half"), half);
    lab.number(&format!("{key}.replications"), own.count() as f64);
    let (size, why) = match cell.claim {
        Claim::Equal => (margin(cell.scene, lab.tier()), ""),
        Claim::Biased(bias, why) => (bias, why),
        Claim::Different(why) => (0.0, why),
    };
    let n = own.count();
    let lacking = std::iter::once(total)
        .chain(other)
        .filter(|total| total.moments.count() < total.valid_from)
        .map(|total| total.valid_from)
        .max();
    let verdict = match (lacking, cell.claim) {
        (Some(needed), _) if half > NOTHING => Verdict::Undecided { needed },
        (_, Claim::Equal | Claim::Biased(..)) => approximate_verdict(interval, 0.0, size, n),
        // It must differ, or the reason is not one.
        (_, Claim::Different(_)) if interval[0] > 0.0 || interval[1] < 0.0 => Verdict::Holds,
        (_, Claim::Different(_)) => Verdict::Undecided { needed: 4 * n },
    };
    let what = format!("{}: {}", name(cell.scene), name(cell.estimator));
    let mut value = format!("{:+.3} % ± {:.3} %", 100.0 * difference, 100.0 * half);
    if size > 0.0 {
        value += &format!(", within {:.1} %", 100.0 * size);
    }
    if !why.is_empty() {
        value += &format!(" ({why})");
    }
    match verdict {
        Verdict::Undecided { needed } => {
            lab.note(
                &what,
                format!("{value}; undecided, needs about {needed} images"),
            );
        }
        verdict => lab.claim(&what, value, verdict == Verdict::Holds),
    }
    let standing = match (verdict, cell.claim) {
        (Verdict::Fails, _) => Standing::Differs,
        (Verdict::Undecided { .. }, _) => Standing::Undecided,
        (Verdict::Holds, Claim::Equal) => Standing::Agrees,
        (Verdict::Holds, _) => Standing::Explained,
    };
    Square {
        text: format!("{:+.2} ± {:.2} %", 100.0 * difference, 100.0 * half),
        standing,
    }
}

/// The Welch map of tiles or pixels of this run's images. The least p-value is recorded; only where equality
/// is claimed can it fail, and only tiles or pixels count whose skewness leaves so far a tail valid.
pub(super) fn note_map(
    lab: &mut Lab,
    cell: &Cell,
    kind: &str,
    [a, b]: [&[Values]; 2],
    share: f64,
) -> PValueMap {
    let table = |run: &[Values]| {
        let column = |of: fn(&Moments) -> f64| run.iter().map(|v| of(&v.moments)).collect();
        let count: Vec<u64> = run.iter().map(|v| v.moments.count()).collect();
        (column(Moments::mean), column(Moments::variance), count)
    };
    let (ours, reference): (Table, Table) = (table(a), table(b));
    let statistics = [&ours, &reference].map(|(mean, variance, count)| PixelStatistics {
        mean,
        variance,
        count,
    });
    let width = SIZE[0] as usize / if kind == "tiles" { TILE } else { 1 };
    let all = map(&statistics[0], &statistics[1], width, 1);
    let level = share / a.len() as f64;
    let valid = |v: &Values| v.moments.count() >= v.valid_from_at(level);
    let mut judged = all.clone();
    for (p, (a, b)) in judged.p.iter_mut().zip(a.iter().zip(b)) {
        if !(valid(a) && valid(b)) {
            *p = f64::NAN;
        }
    }
    let count = judged.p.iter().filter(|p| !p.is_nan()).count();
    let worst = judged.smallest(kind, 2);
    let what = format!("{}: {}, {kind}", name(cell.scene), name(cell.estimator));
    let key = format!("{}.{}.{kind}", name(cell.scene), name(cell.estimator));
    lab.number(&format!("{key}.judged"), count as f64);
    lab.number(&format!("{key}.p"), worst.p);
    let value = format!(
        "least p {:.2e} after Bonferroni over {count} of {} whose skewness allows it",
        worst.p,
        a.len()
    );
    if cell.claim == Claim::Equal && count > 0 {
        lab.claim(&what, value, worst.p >= share);
    } else {
        lab.note(&what, value);
    }
    all
}

/// Means, variances and counts of tiles or pixels.
type Table = (Vec<f64>, Vec<f64>, Vec<u64>);
