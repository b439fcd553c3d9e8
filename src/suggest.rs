//! Suggestions for mistyped names.

use strsim::levenshtein;

/// Longest name that is compared: no valid one is longer.
const MAX_NAME_LENGTH: usize = 64;

/// Returns the tail of a message: `; did you mean "x"?`, or the valid names if none is near and
/// they are few.
pub fn did_you_mean<S: AsRef<str>>(wrong: &str, valid: impl IntoIterator<Item = S>) -> String {
    let names: Vec<S> = valid.into_iter().collect();
    let names: Vec<&str> = names.iter().map(S::as_ref).collect();
    let wrong: String = wrong.chars().take(MAX_NAME_LENGTH).collect();
    let nearest = names
        .iter()
        .map(|name| (levenshtein(&wrong, name), *name))
        .min()
        .filter(|(distance, name)| 2 * distance <= wrong.chars().count().max(name.chars().count()));
    match nearest {
        Some((_, name)) => format!("; did you mean \"{name}\"?"),
        None if names.is_empty() => "; there are none yet".to_owned(),
        None if names.len() <= 12 => format!("; there is {}", names.join(", ")),
        None => String::new(),
    }
}
