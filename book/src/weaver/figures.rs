//! Figures: their pictures, captions, numbers and sources.

use records::results::ExperimentResult;

use super::{BookBuilder, CurrentPage, replace};
use crate::links::to_root;
use crate::mathml::escape;
use crate::{directives, scan};

impl<'a> BookBuilder<'a> {
    pub(super) fn figure(
        &mut self,
        current: &mut CurrentPage<'_>,
        name: &str,
        caption: &str,
    ) -> Result<String, String> {
        self.captioned(current, &[name], caption, |pictures| {
            format!("<div class=\"picture\">{}</div>", pictures[0])
        })
    }

    /// Returns two pictures of one size, one over the other, with a slider that shows more of
    /// either.
    pub(super) fn compare(
        &mut self,
        current: &mut CurrentPage<'_>,
        names: [&str; 2],
        caption: &str,
    ) -> Result<String, String> {
        self.captioned(current, &names, caption, |pictures| {
            format!(
                "<div class=\"compare\"><div class=\"picture\">{}</div>\
                 <div class=\"picture over\">{}</div>\
                 <input type=\"range\" min=\"0\" max=\"100\" value=\"50\" \
                 aria-label=\"how much of the left picture is shown\" \
                 oninput=\"this.parentNode.style.setProperty('--split', this.value + '%')\"></div>",
                pictures[0], pictures[1]
            )
        })
    }

    /// Returns a recorded picture: its experiment, and the addresses of its files.
    fn picture(
        &mut self,
        current: &CurrentPage<'_>,
        name: &str,
    ) -> Result<(&'a ExperimentResult, Vec<String>), String> {
        let results = self.results;
        let (recorded, files) = results.figure(name)?;
        let mut addresses = Vec::new();
        for file in files {
            let file_name = file.file_name().unwrap_or_default().to_string_lossy();
            let name = format!("{}/{file_name}", recorded.id);
            addresses.push(format!(
                "{}figures/{}",
                to_root(current.path),
                escape(&name)
            ));
            self.figures.insert(name, file);
        }
        Ok((recorded, addresses))
    }

    /// Returns a numbered figure with its caption and source. `body` arranges the pictures of these
    /// names.
    fn captioned(
        &mut self,
        current: &mut CurrentPage<'_>,
        names: &[&str],
        caption: &str,
        body: impl Fn(&[String]) -> String,
    ) -> Result<String, String> {
        let found = names
            .iter()
            .map(|name| self.picture(current, name))
            .collect::<Result<Vec<_>, _>>()?;
        if caption.trim().is_empty() {
            return Err("a figure needs a caption that can be read alone".to_owned());
        }
        let id = format!("figure-{}", names.join("-").replace(['/', '.'], "-"));
        if !current.shown.insert(id.clone()) {
            return Err(format!(
                "{} is already shown on this page",
                names.join(" beside ")
            ));
        }
        let html = self.caption(current, caption)?;
        current.figures += 1;
        let label = match &current.chapter {
            Some(chapter) => format!("Figure {chapter}.{}", current.figures),
            None => format!("Figure {}", current.figures),
        };
        let image =
            |address: &String| format!("<img src=\"{address}\" alt=\"{label}, described below\">");
        let pictures: Vec<String> = found
            .iter()
            .map(|(_, addresses)| addresses.iter().map(image).collect())
            .collect();
        let source = |(recorded, _): &(&ExperimentResult, Vec<String>)| {
            let link = self.experiment_link(current.path, &recorded.id);
            format!(
                "Experiment {link}; repeat with <code>{}</code>.",
                escape(&recorded.command)
            )
        };
        let mut sources: Vec<String> = found.iter().map(source).collect();
        sources.dedup();
        let (id, body, sources) = (escape(&id), body(&pictures), sources.join(" "));
        Ok(format!(
            "<figure id=\"{id}\">{body}<figcaption><strong>{label}.</strong> {html} \
             <span class=\"figure-source\">{sources}</span></figcaption></figure>"
        ))
    }

    /// Returns a caption as HTML: plain text with formulas and the directives of running text.
    fn caption(&mut self, current: &mut CurrentPage<'_>, text: &str) -> Result<String, String> {
        let page = scan::page(text);
        if let Some((_, message)) = page.problems.into_iter().next() {
            return Err(message);
        }
        let mut edits = Vec::new();
        for formula in page.formulas {
            edits.push((
                formula.span,
                self.math.block(&formula.latex, formula.display)?,
            ));
        }
        for directive in page.directives {
            if !directives::find(&directive.name)?.inline {
                return Err(format!("{{{{#{}}}}} inside a caption", directive.name));
            }
            let html = self.directive(current, &directive)?;
            edits.push((directive.span, html));
        }
        Ok(replace(text, edits, escape))
    }
}
