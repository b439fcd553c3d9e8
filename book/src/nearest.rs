//! The valid name that a wrong one probably meant.

use strsim::levenshtein;

/// A tail for messages: `; did you mean "x"?`, or the valid names if none is near and they are few.
pub fn hint<S: AsRef<str>>(wrong: &str, valid: impl IntoIterator<Item = S>) -> String {
    let names: Vec<S> = valid.into_iter().collect();
    let names: Vec<&str> = names.iter().map(S::as_ref).collect();
    let nearest = names
        .iter()
        .map(|name| (levenshtein(wrong, name), *name))
        .min()
        .filter(|(distance, name)| 2 * distance <= wrong.chars().count().max(name.chars().count()));
    match nearest {
        Some((_, name)) => format!("; did you mean \"{name}\"?"),
        None if names.is_empty() => "; there are none yet".to_owned(),
        None if names.len() <= 12 => format!("; there is {}", names.join(", ")),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_near_name_is_suggested_and_a_far_one_is_not() {
        assert_eq!(hint("fresnell", ["fresnel", "sphere"]), "; did you mean \"fresnel\"?");
        assert_eq!(hint("xyz", ["fresnel"]), "; there is fresnel");
        assert_eq!(hint("xyz", [""; 0]), "; there are none yet");
    }
}
