//! The valid name that a wrong one probably meant.

/// A tail for messages: `; did you mean "x"?`, or the valid names if none is near and they are few.
pub fn hint<'a>(wrong: &str, valid: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = valid.into_iter().collect();
    let nearest =
        names.iter().map(|name| (distance(wrong, name), *name)).min().filter(|(distance, name)| {
            2 * distance <= wrong.chars().count().max(name.chars().count())
        });
    match nearest {
        Some((_, name)) => format!("; did you mean \"{name}\"?"),
        None if names.is_empty() => "; there are none yet".to_owned(),
        None if names.len() <= 12 => format!("; there is {}", names.join(", ")),
        None => String::new(),
    }
}

/// Insertions, deletions and replacements that turn `a` into `b` (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_of_known_words() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("same", "same"), 0);
    }

    #[test]
    fn a_near_name_is_suggested_and_a_far_one_is_not() {
        assert_eq!(hint("fresnell", ["fresnel", "sphere"]), "; did you mean \"fresnel\"?");
        assert_eq!(hint("xyz", ["fresnel"]), "; there is fresnel");
        assert_eq!(hint("xyz", []), "; there are none yet");
    }
}
