//! The bibliography of the book, from one TOML file.

use std::collections::BTreeMap;
use std::path::Path;

use records::Problem;
use serde::Deserialize;
use whitefurnace::suggest::did_you_mean;

use crate::error::Error;
use crate::links::line;
use crate::mathml::escape;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Work {
    /// Short name in the text, such as "Kajiya 1986".
    pub label: String,
    pub authors: String,
    pub title: String,
    /// Journal, volume and pages; proceedings; publisher.
    pub venue: String,
    pub year: u16,
    /// Digital object identifier, printed as text.
    pub doi: Option<String>,
}

/// All works, by key.
#[derive(Debug, Default)]
pub struct Bibliography {
    works: BTreeMap<String, Work>,
}

impl Bibliography {
    /// Reads the file; a missing file is an empty bibliography.
    pub fn load(file: &Path) -> Result<Self, Error> {
        if !file.exists() {
            return Ok(Self::default());
        }
        let text = std::fs::read_to_string(file).map_err(Error::io(file))?;
        let works = toml::from_str(&text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            Error::Problems(vec![Problem::new(file, line(&text, at), error.message())])
        })?;
        Ok(Self { works })
    }

    pub fn work(&self, key: &str) -> Result<&Work, String> {
        self.works.get(key).ok_or_else(|| {
            format!(
                "no work \"{key}\" in the bibliography{}",
                did_you_mean(key, self.works.keys())
            )
        })
    }

    /// Returns the list of all works as HTML, by key, which begins with the first author's name.
    pub fn list(&self) -> String {
        let mut html = String::from("<ul class=\"bibliography\">");
        for (key, work) in &self.works {
            let doi = work.doi.as_ref().map_or_else(String::new, |doi| {
                format!(" <span class=\"doi\">doi:{}</span>", escape(doi))
            });
            let [authors, title, venue] =
                [&work.authors, &work.title, &work.venue].map(|text| escape(text));
            let year = work.year;
            html += &format!(
                "<li id=\"cite-{key}\">{authors} ({year}). <em>{title}</em>. {venue}.{doi}</li>"
            );
        }
        html.push_str("</ul>");
        html
    }
}
