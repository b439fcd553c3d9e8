//! Recorded numbers in a Markdown file that is not woven, each as `<!--EXPERIMENT.KEY
//! FORMAT-->number<!---->`.

use crate::number;
use crate::results::Results;

/// Returns the text with every such number replaced by the recorded one. A number that is not
/// recorded, or a missing end mark, is an error.
pub fn with_numbers(text: &str, results: &Results) -> Result<String, String> {
    let mut pieces = text.split("<!--");
    let mut woven = pieces.next().unwrap_or_default().to_owned();
    while let Some(piece) = pieces.next() {
        let (directive, _) = piece
            .split_once("-->")
            .ok_or_else(|| format!("\"<!--{piece}\" has no end"))?;
        let after = pieces.next().and_then(|end| end.strip_prefix("-->"));
        let after =
            after.ok_or_else(|| format!("the number of {directive} has no <!----> behind it"))?;
        let (key, format) = directive
            .split_once(' ')
            .map_or((directive, None), |(key, format)| (key, Some(format)));
        let number = number::format(results.number(key)?, format)?;
        woven += &format!("<!--{directive}-->{number}<!---->{after}");
    }
    Ok(woven)
}
