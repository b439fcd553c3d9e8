//! Precision of a sampler's numbers, as the option states or as the numbers show.

use std::str::FromStr;

use whitefurnace::harness::directions::{Precision, Rounding};

use super::read::DigitCounts;

/// Value of `--precision`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PrecisionOption {
    Auto,
    All(Rounding),
}

impl FromStr for PrecisionOption {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text {
            "auto" => Self::Auto,
            "double" => Self::All(Rounding::DOUBLE),
            "single" => Self::All(Rounding::SINGLE),
            "half" => Self::All(Rounding::HALF),
            _ => match text.parse() {
                Ok(decimals @ 2..=15) => Self::All(Rounding::printed(decimals, 17)),
                _ => {
                    return Err(
                        "auto, double, single, half, or a number of decimals from 2 to 15"
                            .to_owned(),
                    );
                }
            },
        })
    }
}

/// Observed precision of one group of numbers.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ObservedPrecision {
    /// Number of printed values, and their largest number of decimals and significant digits.
    printed: u64,
    decimals: i32,
    significant: i32,
    /// Largest number of significand bits; for a printed number, of the shortest value that prints
    /// the same.
    bits: u32,
    /// Number of values other than 0, 1 and -1, which show no digits.
    informative: u64,
}

impl ObservedPrecision {
    pub(super) fn add(&mut self, value: f64, digits: Option<DigitCounts>) {
        if value.abs() == 1.0 || value == 0.0 || !value.is_finite() {
            // A zero that is printed with decimals shows them.
            self.decimals = self
                .decimals
                .max(digits.map_or(0, |digits| digits.decimals.min(20)));
            return;
        }
        self.informative += 1;
        let shortest =
            |value: f64| 53 - (value.to_bits() & ((1 << 52) - 1) | 1 << 52).trailing_zeros();
        let Some(DigitCounts {
            decimals,
            significant,
        }) = digits
        else {
            self.bits = self.bits.max(shortest(value));
            return;
        };
        self.printed += 1;
        (self.decimals, self.significant) = (
            self.decimals.max(decimals),
            self.significant.max(significant),
        );
        let single = f64::from(value as f32);
        let is_single = (value - single).abs() <= 0.5 * 10f64.powi(-decimals) * (1.0 + 1e-9);
        self.bits = self.bits.max(if is_single { 24 } else { 53 });
    }

    fn rounding(&self) -> Rounding {
        if self.informative == 0 {
            return Rounding::DOUBLE;
        }
        let computed = match self.bits {
            0..=11 => Rounding::HALF,
            12..=24 => Rounding::SINGLE,
            _ => Rounding::DOUBLE,
        };
        if self.printed == 0 {
            return computed;
        }
        let printed = Rounding::printed(self.decimals, self.significant);
        if printed.half_width(0.75) < 1e-14 {
            return computed;
        }
        Rounding {
            absolute: printed.absolute.max(computed.absolute),
            ..printed
        }
    }

    /// Adds the digits of another group if this one has short numbers only, such as 0.5, which show
    /// no precision.
    fn with(self, other: &Self) -> Self {
        if self.decimals >= 3 || self.printed == 0 {
            return self;
        }
        Self {
            decimals: self.decimals.max(other.decimals),
            significant: self.significant.max(other.significant),
            bits: self.bits.max(other.bits),
            ..self
        }
    }
}

/// Observed precision of all numbers of a file.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FilePrecision {
    pub(super) direction: ObservedPrecision,
    pub(super) weight: ObservedPrecision,
    pub(super) pdf: ObservedPrecision,
}

impl FilePrecision {
    pub(super) fn precision(&self) -> Precision {
        Precision {
            direction: self.direction.rounding(),
            weight: self.weight.with(&self.direction).rounding(),
            pdf: self.pdf.with(&self.direction).rounding(),
        }
    }
}

/// Describes a precision in words.
pub(super) fn words(rounding: &Rounding) -> String {
    match *rounding {
        Rounding::DOUBLE => "double precision".to_owned(),
        Rounding::SINGLE => "single precision".to_owned(),
        Rounding::HALF => "half precision".to_owned(),
        _ => format!("rounded by up to {:.1e}", rounding.half_width(0.75)),
    }
}
