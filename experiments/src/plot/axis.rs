//! Axes: positions of values, and the labelled ones.

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    Linear,
    Logarithmic,
    /// asinh scale: linear about zero, logarithmic far from it on either side.
    Signed,
}

/// An axis over an interval of the drawing.
#[derive(Clone)]
pub(super) struct Axis {
    ends: [f64; 2],
    /// Positions of both ends in the drawing, pixels.
    place: [f64; 2],
    scale: Scale,
    /// Values that are labelled.
    pub ticks: Vec<f64>,
    /// Decimals of a linear axis' labels.
    decimals: usize,
}

/// Room for a label, pixels.
const LABEL_SPACING: f64 = 46.0;

impl Axis {
    /// Creates an axis with labels at round numbers: on a linear axis as many as fit, up to ten; on
    /// a logarithmic one powers of ten, and 2 and 5 times these if it spans few.
    pub fn new([low, high]: [f64; 2], scale: Scale, place: [f64; 2]) -> Self {
        let most = ((place[1] - place[0]).abs() / LABEL_SPACING).clamp(2.0, 10.0);
        let mut decimals = 0;
        let ticks: Vec<f64> = match scale {
            Scale::Linear => {
                let least = (high - low) / most;
                let power = 10f64.powf(least.log10().floor());
                let multiples = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
                let step = multiples.into_iter().find(|m| *m >= least * (1.0 - 1e-9));
                let step = step.unwrap_or(least);
                decimals = (-(step * (1.0 + 1e-9)).log10().floor()).max(0.0) as usize;
                let steps = (low / step - 1e-9).ceil() as i64..=(high / step + 1e-9).floor() as i64;
                steps.map(|i| i as f64 * step).collect()
            }
            Scale::Logarithmic => {
                let [a, b] = [low, high].map(f64::log10);
                let multiples: &[f64] = if 3.0 * (b - a) <= most {
                    &[1.0, 2.0, 5.0]
                } else {
                    &[1.0]
                };
                let step = ((b - a) / most).ceil().max(1.0) as usize;
                (a.floor() as i32..=b.ceil() as i32)
                    .step_by(step)
                    .flat_map(|k| multiples.iter().map(move |m| m * 10f64.powi(k)))
                    .collect()
            }
            Scale::Signed => {
                let powers = (0..=6).flat_map(|k| [1.0, 3.0].map(|m| m * 10f64.powi(k)));
                let either = powers.flat_map(|value| [-value, value]);
                std::iter::once(0.0).chain(either).collect()
            }
        };
        let mut axis = Self {
            ends: [low, high],
            place,
            scale,
            ticks: Vec::new(),
            decimals,
        };
        axis.ticks = ticks.into_iter().filter(|&tick| axis.shows(tick)).collect();
        axis
    }

    /// Returns the position of a value in the drawing; outside the axis if the value is.
    pub fn at(&self, value: f64) -> f64 {
        let scaled = |value: f64| match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => value.max(f64::MIN_POSITIVE).log10(),
            Scale::Signed => value.asinh(),
        };
        let [low, high] = self.ends.map(scaled);
        let share = (scaled(value) - low) / (high - low);
        self.place[0] + share * (self.place[1] - self.place[0])
    }

    /// Returns true if a value lies on the axis, up to rounding.
    pub fn shows(&self, value: f64) -> bool {
        let [low, high] = self.extent();
        (low - 0.01..=high + 0.01).contains(&self.at(value))
    }

    /// Returns the ends of the axis in the drawing, least first.
    pub fn extent(&self) -> [f64; 2] {
        let [a, b] = self.place;
        [a.min(b), a.max(b)]
    }

    /// Formats a labelled value.
    pub fn label(&self, value: f64) -> String {
        let decimals = self.decimals;
        let most = self.ends[0].abs().max(self.ends[1].abs());
        let text = match self.scale {
            Scale::Linear if most >= 1e6 => format!("{value:.0e}"),
            Scale::Linear => format!("{:.decimals$}", value + 0.0),
            Scale::Signed if value == 0.0 => "0".to_owned(),
            Scale::Signed => format!("{value:+.0}"),
            Scale::Logarithmic => {
                let power = (value.log10() + 1e-9).floor();
                if self.ends.iter().any(|end| end.log10().abs() > 4.5) {
                    let first = (value / 10f64.powf(power)).round();
                    let times = if first == 1.0 {
                        String::new()
                    } else {
                        format!("{first}·")
                    };
                    format!("{times}10{}", superscript(power as i32))
                } else {
                    let decimals = (-power).max(0.0) as usize;
                    format!("{value:.decimals$}")
                }
            }
        };
        text.replace('-', "−")
    }
}

fn superscript(power: i32) -> String {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    power
        .to_string()
        .chars()
        .map(|c| c.to_digit(10).map_or('⁻', |digit| digits[digit as usize]))
        .collect()
}
