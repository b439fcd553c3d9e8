//! LaTeX to MathML, and text to HTML.

use math_core::{LatexToMathML, MathCoreConfig, MathDisplay};

pub struct Math {
    converter: LatexToMathML,
}

impl Math {
    /// Returns a formula as MathML on one line, for an HTML block.
    pub fn block(&self, latex: &str, display: bool) -> Result<String, String> {
        let mode = if display {
            MathDisplay::Block
        } else {
            MathDisplay::Inline
        };
        // TeX's negative space before \left undoes a space that MathML does not add.
        let spaced = latex.trim().replace(r"\!\left", r"\left");
        match self.converter.convert_with_local_state(&spaced, mode) {
            Ok(result) if result.warnings.has_undefined_references() => Err(format!(
                "formula \"{}\" refers to a label that is not in it",
                one_line(latex)
            )),
            Ok(result) => Ok(result.mathml.replace('\n', " ")),
            Err(error) => Err(format!(
                "formula \"{}\": {}",
                one_line(latex),
                one_line(&error.to_string())
            )),
        }
    }

    /// Returns a formula for running Markdown text: as [`Self::block`], with every character that
    /// Markdown would interpret written as a character reference.
    pub fn inline(&self, latex: &str, display: bool) -> Result<String, String> {
        let mut out = String::new();
        for character in self.block(latex, display)?.chars() {
            match character {
                '*' | '_' | '[' | ']' | '|' | '~' | '\\' | '`' | '$' | '\'' => {
                    out.push_str(&format!("&#{};", u32::from(character)));
                }
                _ => out.push(character),
            }
        }
        Ok(if display {
            format!("<span class=\"formula\">{out}</span>")
        } else {
            out
        })
    }
}

impl Default for Math {
    /// Returns a converter without macros.
    fn default() -> Self {
        // Only macro definitions can fail, and there are none.
        Self {
            converter: LatexToMathML::new(MathCoreConfig::default()).unwrap_or_default(),
        }
    }
}

/// Escapes text for HTML content and quoted attributes.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Converts the registry's plain text to HTML with typographic signs: minus signs, ranges of pages.
pub fn typeset(text: &str) -> String {
    let characters: Vec<char> = text.replace(" - ", " − ").chars().collect();
    let is_digit = |at: Option<usize>| {
        at.and_then(|at| characters.get(at))
            .is_some_and(char::is_ascii_digit)
    };
    let ranged: String = characters
        .iter()
        .enumerate()
        .map(|(at, &c)| {
            let between = is_digit(at.checked_sub(1)) && is_digit(Some(at + 1));
            if c == '-' && between { '–' } else { c }
        })
        .collect();
    let named = ranged
        .replace("Möller-Trumbore", "Möller–Trumbore")
        .replace("Oren-Nayar", "Oren–Nayar");
    superscripts(&escape(&named).replace("f_r", "<i>f</i><sub>r</sub>"))
}

/// Raises the exponent of `a^(b+1)`.
fn superscripts(text: &str) -> String {
    match text
        .split_once("^(")
        .and_then(|(base, rest)| Some((base, rest.split_once(')')?)))
    {
        Some((base, (exponent, rest))) => {
            format!("{base}<sup>{exponent}</sup>{}", superscripts(rest))
        }
        None => text.to_owned(),
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inline_mathml_has_nothing_that_markdown_reads() {
        let html = Math::default().inline(r"a_1^* + [b] \| c | \backslash", false);
        let html = html.expect("valid LaTeX");
        assert!(
            !html.contains(['*', '_', '[', ']', '|', '~', '\\', '`']),
            "{html}"
        );
    }

    #[test]
    fn text_is_typeset() {
        assert_eq!(typeset("23(6), 343-349"), "23(6), 343–349");
        assert_eq!(typeset("1 - R < x-ray"), "1 − R &lt; x-ray");
        assert_eq!(
            typeset("f_r: −a^(b+1) of"),
            "<i>f</i><sub>r</sub>: −a<sup>b+1</sup> of"
        );
    }
}
