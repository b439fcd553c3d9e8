//! Reference values, computed with 50 digits by closed forms and quadrature outside this project.

/// Returns the rows of a table in `data`: fields are separated by commas, lines with # are
/// comments.
pub fn fields(table: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    table
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(',').collect())
}

/// Parses a number of a table.
pub fn number(text: &str) -> f64 {
    text.parse().expect("a number in a table")
}

/// Returns the rows of a table of N numbers each.
pub fn rows<const N: usize>(table: &'static str) -> Vec<[f64; N]> {
    let row = |fields: Vec<&str>| {
        let numbers: Vec<f64> = fields.into_iter().map(number).collect();
        numbers.try_into().expect("a full row")
    };
    fields(table).map(row).collect()
}

/// Asserts the values of a table whose rows are the name of a function, its arguments separated by
/// blanks, a value, and the allowed relative error unless it is 1e-9.
pub fn assert_table(table: &'static str, evaluate: impl Fn(&str, &[f64]) -> f64) {
    let mut wrong = Vec::new();
    for row in fields(table) {
        let arguments: Vec<f64> = row[1].split(' ').map(number).collect();
        let (found, value) = (evaluate(row[0], &arguments), number(row[2]));
        let same = found == value || found.is_nan() && value.is_nan();
        let error = if same {
            0.0
        } else {
            (found / value - 1.0).abs()
        };
        if error.is_nan() || error > row.get(3).map_or(1e-9, |allowed| number(allowed)) {
            wrong.push(format!("{row:?}: {found:e}, error {error:e}"));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// Rows of n₁, n₂, cos θ₁, R_s, R_p, R.
pub fn fresnel() -> Vec<[f64; 6]> {
    rows(include_str!("data/fresnel.csv"))
}

/// Rows of σ, θ in degrees, directional albedo of the corrected and of the printed form.
pub fn oren_nayar() -> Vec<[f64; 4]> {
    rows(include_str!("data/oren_nayar.csv"))
}

/// Rows of r, ρ, θ in degrees, directional albedo of EON: single scattering, both lobes.
pub fn eon() -> Vec<[f64; 5]> {
    rows(include_str!("data/eon.csv"))
}

/// Rows of σ, A, B, average albedo of the corrected and of the printed form.
pub fn oren_nayar_average() -> Vec<[f64; 5]> {
    rows(include_str!("data/oren_nayar_average.csv"))
}
