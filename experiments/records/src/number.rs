//! Formats of numbers in the book and the README.

/// Number of significant digits without a format.
const DIGITS: usize = 4;
/// Below this, integers are printed digit by digit.
const LARGEST_INTEGER: f64 = 1e15;

/// Formats `value` by `format`: `%.3f` fixed, `%.3e` powers of ten, `%.3g` significant digits,
/// `%.1%` per cent, `%d` an integer in groups of three. Without one, integers as with `%d` and
/// others with four significant digits. Powers of ten are HTML. Other formats, and `%d` for a
/// fraction, are errors.
pub fn format(value: f64, format: Option<&str>) -> Result<String, String> {
    let integer = value.fract() == 0.0 && value.abs() < LARGEST_INTEGER;
    let Some(format) = format else {
        return Ok(if integer {
            grouped(value)
        } else {
            significant(value, DIGITS)
        });
    };
    let wrong = || format!("\"{format}\" is not a format; there is %.3f, %.3e, %.3g, %.1%, %d");
    let body = format.strip_prefix('%').ok_or_else(wrong)?;
    if body == "d" {
        return if integer {
            Ok(grouped(value))
        } else {
            Err(format!("{value} is not an integer, which %d asks for"))
        };
    }
    let (digits, kind) = body
        .strip_prefix('.')
        .and_then(|rest| rest.split_at_checked(rest.len().saturating_sub(1)))
        .ok_or_else(wrong)?;
    let digits: usize = digits.parse().map_err(|_| wrong())?;
    if digits > 17 {
        return Err(wrong());
    }
    match kind {
        "f" => Ok(signed(&format!("{value:.digits$}"))),
        "e" => Ok(scientific(value, digits)),
        "g" if digits > 0 => Ok(significant(value, digits)),
        "%" => Ok(signed(&format!("{:.digits$}\u{202f}%", 100.0 * value))),
        _ => Err(wrong()),
    }
}

/// Formats with `digits` significant digits, in powers of ten outside of [1e-4, 1e6).
fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    // The exponent after rounding to the digits shown.
    let rounded = format!("{value:.*e}", digits - 1);
    let exponent: i32 = rounded
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok())
        .unwrap_or(0);
    if !(-4..6).contains(&exponent) {
        return scientific(value, digits - 1);
    }
    let decimals = usize::try_from(digits as i32 - 1 - exponent).unwrap_or(0);
    signed(&format!("{value:.decimals$}"))
}

/// Formats like 1.23 × 10⁻⁴, with the exponent as HTML.
fn scientific(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    format!(
        "{}\u{a0}×\u{a0}10<sup>{}</sup>",
        signed(mantissa),
        signed(exponent)
    )
}

/// Formats an integer with narrow spaces between groups of three, from five digits on.
fn grouped(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && digits.len() > 4 && (digits.len() - at) % 3 == 0 {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    if value < 0.0 {
        format!("−{text}")
    } else {
        text
    }
}

/// Replaces a hyphen by a minus sign, and removes it before zero.
fn signed(text: &str) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.contains(|c: char| ('1'..='9').contains(&c)) => format!("−{rest}"),
        Some(rest) => rest.to_owned(),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::format;

    #[test]
    fn numbers_are_printed_as_asked() {
        let cases = [
            (2.71849, None, "2.718"),
            (0.0, None, "0"),
            (65536.0, None, "65\u{202f}536"),
            (1e20, None, "1.000\u{a0}×\u{a0}10<sup>20</sup>"),
            (-0.000123456, None, "−0.0001235"),
            (0.0000123456, None, "1.235\u{a0}×\u{a0}10<sup>−5</sup>"),
            (99999.6, None, "100000"),
            (999999.6, None, "1.000\u{a0}×\u{a0}10<sup>6</sup>"),
            (2.5, Some("%.3f"), "2.500"),
            (-0.0001, Some("%.2f"), "0.00"),
            (-12345.0, Some("%.1e"), "−1.2\u{a0}×\u{a0}10<sup>4</sup>"),
            (0.1001, Some("%.1%"), "10.0\u{202f}%"),
            (1234567.0, Some("%d"), "1\u{202f}234\u{202f}567"),
            (1234.0, Some("%d"), "1234"),
            (0.123456, Some("%.2g"), "0.12"),
        ];
        for (value, how, text) in cases {
            assert_eq!(format(value, how).as_deref(), Ok(text), "{value} {how:?}");
        }
    }
}
