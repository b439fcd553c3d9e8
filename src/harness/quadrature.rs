//! Adaptive quadrature of functions of two variables: products of the Gauss-Kronrod pair (7, 15).

use std::array;
use std::collections::BinaryHeap;

/// Nodes of the 15-point Kronrod rule on [−1, 1] that lie in [0, 1), largest first; those of odd
/// index are Gauss nodes.
const NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];
/// Kronrod weights of [`NODES`].
const KRONROD: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_55,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_82,
];
/// Gauss weights of the [`NODES`] of odd index.
const GAUSS: [f64; 4] = [
    0.129_484_966_168_869_7,
    0.279_705_391_489_276_64,
    0.381_830_050_505_118_9,
    0.417_959_183_673_469_4,
];

/// Axis-parallel rectangle: x in [`x[0]`, `x[1]`], y in [`y[0]`, `y[1]`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Range of the first variable.
    pub x: [f64; 2],
    /// Range of the second variable.
    pub y: [f64; 2],
}

/// Value of an integral with an estimate of its error from the pair of rules.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Integral {
    /// ∫∫ f dx dy.
    pub value: f64,
    /// Sum of the differences between the Kronrod and Gauss values.
    pub error: f64,
}

/// Number of nodes of the Kronrod rule.
const NODE_COUNT: usize = 15;

/// Values of a function on a grid of nodes: a row for each of the first variable's.
type GridValues = [[f64; NODE_COUNT]; NODE_COUNT];

/// Largest number of rectangles, 225 evaluations each.
const MAX_RECTANGLES: usize = 20_000;

/// Largest fraction of the error that four times as many rectangles may leave. Refinement steps
/// leave a quarter to a half; more is due to rounding, noise, or a pair of rules that disagree.
const MAX_REMAINING_ERROR: f64 = 0.9;

/// Integrates f over `domain`, refined where the error is largest until its sum is below
/// `tolerance` (absolute), refinement gains nothing, or 20 000 rectangles are used; then `error` is
/// the error reached. A value that is not finite makes the integral NaN.
pub fn integrate(
    domain: Rectangle,
    tolerance: f64,
    f: &mut dyn FnMut(f64, f64) -> f64,
) -> Integral {
    let mut on_grid = |x: [f64; NODE_COUNT], y: [f64; NODE_COUNT]| x.map(|x| y.map(|y| f(x, y)));
    integrate_within(domain, tolerance, &mut halving_budget(), &mut on_grid)
}

/// Returns how often rectangles may be halved in one task.
pub(super) fn halving_budget() -> usize {
    MAX_RECTANGLES - 1
}

/// Integrates f over `domain` as [`integrate`], with `budget` halvings shared among several
/// integrals. f is evaluated on a whole grid of nodes at a time.
pub(super) fn integrate_within(
    domain: Rectangle,
    tolerance: f64,
    budget: &mut usize,
    on_grid: &mut dyn FnMut([f64; NODE_COUNT], [f64; NODE_COUNT]) -> GridValues,
) -> Integral {
    let first = Subrectangle::new(domain, on_grid);
    let mut total = first.integral;
    let mut parts = BinaryHeap::from([first]);
    // Number of parts at the next check of progress, and the error at the last check.
    let (mut look, mut before) = (16, f64::INFINITY);
    while total.error > tolerance && *budget > 0 {
        if parts.len() == look {
            if total.error > MAX_REMAINING_ERROR * before {
                break;
            }
            (look, before) = (4 * look, total.error);
        }
        *budget -= 1;
        let Some(worst) = parts.pop() else { break };
        for half in worst.halves() {
            parts.push(Subrectangle::new(half, on_grid));
        }
        // Sums are recomputed rather than updated, lest rounding accumulates.
        total = parts
            .iter()
            .fold(Integral::default(), |sum, part| Integral {
                value: sum.value + part.integral.value,
                error: sum.error + part.integral.error,
            });
    }
    total
}

/// Rectangle with its integral.
struct Subrectangle {
    domain: Rectangle,
    integral: Integral,
    /// Whether the error comes mainly from the first variable.
    along_x: bool,
}

impl Subrectangle {
    fn new(
        domain: Rectangle,
        on_grid: &mut dyn FnMut([f64; NODE_COUNT], [f64; NODE_COUNT]) -> GridValues,
    ) -> Self {
        let [x, y] = [nodes(domain.x), nodes(domain.y)];
        let values = on_grid(x.map(|[node, ..]| node), y.map(|[node, ..]| node));
        // Kronrod in both variables, Gauss in x only, Gauss in y only.
        let (mut both, mut gauss_x, mut gauss_y) = (0.0, 0.0, 0.0);
        for ([_, kronrod_x, weight_gauss_x], row) in x.into_iter().zip(values) {
            for ([_, kronrod_y, weight_gauss_y], value) in y.into_iter().zip(row) {
                both += kronrod_x * kronrod_y * value;
                gauss_x += weight_gauss_x * kronrod_y * value;
                gauss_y += kronrod_x * weight_gauss_y * value;
            }
        }
        let errors = [(both - gauss_x).abs(), (both - gauss_y).abs()];
        Self {
            domain,
            integral: Integral {
                value: both,
                error: errors[0] + errors[1],
            },
            along_x: errors[0] >= errors[1],
        }
    }

    fn halves(&self) -> [Rectangle; 2] {
        let Rectangle { x, y } = self.domain;
        let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
        if self.along_x {
            let m = middle(x);
            [[x[0], m], [m, x[1]]].map(|x| Rectangle { x, y })
        } else {
            let m = middle(y);
            [[y[0], m], [m, y[1]]].map(|y| Rectangle { x, y })
        }
    }
}

impl PartialEq for Subrectangle {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Subrectangle {}
impl PartialOrd for Subrectangle {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Subrectangle {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.integral.error.total_cmp(&other.integral.error)
    }
}

/// Returns the 15 nodes of an interval, each with its Kronrod and its Gauss weight (0 if it is no
/// Gauss node).
fn nodes([low, high]: [f64; 2]) -> [[f64; 3]; NODE_COUNT] {
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
    array::from_fn(|i| {
        let (k, sign) = if i < 8 { (i, -1.0) } else { (14 - i, 1.0) };
        let gauss = if k % 2 == 1 { GAUSS[k / 2] } else { 0.0 };
        [
            centre + sign * half * NODES[k],
            half * KRONROD[k],
            half * gauss,
        ]
    })
}
