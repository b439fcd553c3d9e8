//! Replaces directives and formulas on the pages.

mod figures;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};

use mdbook_driver::book::Book;
use records::Problem;
use records::mutants::Record;
use records::number;
use records::results::{ExperimentResult, Results};
use whitefurnace::material::named;

use crate::bibliography::Bibliography;
use crate::glossary::{self, Entry};
use crate::links::{Target, address, line, to_root};
use crate::mathml::{Math, escape};
use crate::scan::{Directive, Page};
use crate::{directives, equations, links, listing, mutants, questions, registry, run, scan};

/// Pages of the book by their contents.
#[derive(Debug, Default)]
struct PageIndex {
    equations: BTreeMap<String, PathBuf>,
    /// Page with the list that a directive generates, by the directive's name.
    lists: BTreeMap<String, PathBuf>,
}

/// Everything that pages may refer to, and the figures and links found on them.
pub struct BookBuilder<'a> {
    /// Folder of the pages, for messages and links.
    pub pages: &'a Path,
    /// The project's folder, for code.
    pub sources: &'a Path,
    pub results: &'a Results,
    pub bibliography: &'a Bibliography,
    /// True if a page compares a run with the record.
    pub has_run: bool,
    math: Math,
    index: PageIndex,
    glossary: Vec<Entry>,
    pub problems: Vec<Problem>,
    /// Figures to copy, as `EXPERIMENT/NAME` and file.
    pub figures: BTreeMap<String, PathBuf>,
    /// Links into pages.
    pub targets: Vec<Target>,
}

struct CurrentPage<'a> {
    path: &'a Path,
    text: &'a str,
    /// The chapter's number such as "4", and its number of figures so far.
    chapter: Option<String>,
    figures: usize,
    shown: BTreeSet<String>,
}

impl<'a> BookBuilder<'a> {
    pub fn new(
        pages: &'a Path,
        sources: &'a Path,
        results: &'a Results,
        bibliography: &'a Bibliography,
    ) -> Self {
        Self {
            pages,
            sources,
            results,
            bibliography,
            has_run: false,
            math: Math::default(),
            index: PageIndex::default(),
            glossary: Vec::new(),
            problems: Vec::new(),
            figures: BTreeMap::new(),
            targets: Vec::new(),
        }
    }

    /// Replaces the directives and formulas of every chapter; errors are collected in `problems`.
    pub fn build(&mut self, book: &mut Book) {
        let mut scanned: BTreeMap<PathBuf, Page> = BTreeMap::new();
        for chapter in book.chapters() {
            if let Some(path) = &chapter.path {
                let page = scan::page(&chapter.content);
                self.index_page(path, &chapter.content, &page);
                if path == Path::new(glossary::PAGE) {
                    self.glossary = glossary::entries(&chapter.content);
                }
                scanned.insert(path.clone(), page);
            }
        }
        let known: BTreeSet<PathBuf> = scanned.keys().cloned().collect();
        book.for_each_chapter_mut(|chapter| {
            let Some((path, page)) = chapter
                .path
                .as_ref()
                .and_then(|path| scanned.remove_entry(path))
            else {
                return;
            };
            let number = chapter.number.as_ref();
            let mut current = CurrentPage {
                path: &path,
                text: &chapter.content,
                chapter: number.map(|n| n.to_string().trim_end_matches('.').to_owned()),
                figures: 0,
                shown: BTreeSet::new(),
            };
            self.targets.extend(links::check(
                self.pages,
                &path,
                current.text,
                &page,
                &known,
                &mut self.problems,
            ));
            chapter.content = self.page(&mut current, page);
        });
        self.problems.sort();
    }

    /// Notes the lists and equations that a page shows.
    fn index_page(&mut self, path: &Path, text: &str, page: &Page) {
        for directive in &page.directives {
            let arguments = &directive.arguments;
            match (directive.name.as_str(), arguments.first()) {
                ("eq", Some(id)) => {
                    if let Some(first) = self.index.equations.get(id) {
                        let message = format!(
                            "equation \"{id}\" is already shown on {}; write {{{{#ref {id}}}}}",
                            first.display()
                        );
                        self.problem(path, text, directive.span.start, message);
                    } else {
                        self.index.equations.insert(id.clone(), path.to_owned());
                    }
                }
                (list @ ("bibliography" | "experiments" | "trials"), _) => {
                    self.index.lists.insert(list.to_owned(), path.to_owned());
                }
                _ => {}
            }
        }
    }

    fn problem(&mut self, path: &Path, text: &str, at: usize, message: impl Into<String>) {
        self.problems
            .push(Problem::new(self.pages.join(path), line(text, at), message));
    }

    /// Returns a page with directives and formulas replaced.
    fn page(&mut self, current: &mut CurrentPage<'_>, page: Page) -> String {
        let mut edits = glossary::edits(&self.glossary, current.path, current.text, &page);
        let mut problems = page.problems;
        for formula in page.formulas {
            match self.math.inline(&formula.latex, formula.display) {
                Ok(html) if formula.display => edits.push((formula.span, html)),
                Ok(html) => edits.push(keep_together(current.text, formula.span, &html)),
                Err(message) => problems.push((formula.span.start, message)),
            }
        }
        for directive in page.directives {
            match self.directive(current, &directive) {
                Ok(text) => edits.push((directive.span, text)),
                Err(message) => problems.push((directive.span.start, message)),
            }
        }
        for (at, message) in problems {
            self.problem(current.path, current.text, at, message);
        }
        replace(current.text, edits, str::to_owned)
    }

    /// Returns the text that replaces a directive.
    fn directive(
        &mut self,
        current: &mut CurrentPage<'_>,
        directive: &Directive,
    ) -> Result<String, String> {
        let words: Vec<&str> = directive.arguments.iter().map(String::as_str).collect();
        let kind = directives::find(&directive.name)?;
        if !kind.inline && !directive.alone {
            return Err(format!(
                "{{{{#{}}}}} must stand alone on its line",
                kind.name
            ));
        }
        let block = |html: String| format!("\n\n{html}\n\n");
        match (kind.name, &words[..]) {
            ("eq", [id]) => equations::equation_box(equations::find(id)?, &self.math).map(block),
            ("ref", [id]) => self.reference(current, id),
            ("equations", []) => {
                let page_of = |id: &str| self.equation_address(current.path, id);
                equations::matrix(&self.math, page_of).map(block)
            }
            ("tally", []) => Ok(block(equations::tally())),
            ("result", [key]) => number::format(self.results.number(key)?, None),
            ("result", [key, format]) => number::format(self.results.number(key)?, Some(format)),
            ("figure", [name, caption]) => self.figure(current, name, caption).map(block),
            ("compare", [left, right, caption]) => {
                self.compare(current, [left, right], caption).map(block)
            }
            ("code", [path, items @ ..]) if !items.is_empty() => self.code(path, items),
            ("cite", [key]) => self.cite(current, key),
            ("bibliography", []) => Ok(block(self.bibliography.list())),
            ("experiments", []) => Ok(block(self.experiments())),
            ("trial", [name]) => self.trial(current, name),
            ("trials", []) => Ok(block(registry::trials(
                |id| self.equation_link(current, id),
                self.results
                    .experiment("trials")
                    .ok()
                    .map(|trials| &trials.numbers),
            ))),
            ("question", [fault, trials @ ..]) if trials.len() > 1 => {
                let link = |name: &str| self.trial(current, name);
                questions::question(self.results, fault, trials, link).map(block)
            }
            ("faults", []) => Ok(block(registry::faults())),
            ("models", []) => Ok(block(named::table())),
            ("run", []) => Ok(block(self.run(current.path))),
            ("mutants", []) => {
                Record::read(self.results.folder()).map(|record| block(mutants::tables(&record)))
            }
            ("traceability", []) => registry::traceability(
                self.sources,
                self.results,
                |id| self.equation_link(current, id),
                |id| self.experiment_link(current.path, id),
            )
            .map(block),
            _ => Err(format!("this directive is written {}", kind.usage())),
        }
    }

    fn reference(&self, current: &CurrentPage<'_>, id: &str) -> Result<String, String> {
        let equation = equations::find(id)?;
        let address = self.equation_address(current.path, id).ok_or_else(|| {
            format!("no page shows equation \"{id}\"; add {{{{#eq {id}}}}} to one")
        })?;
        Ok(format!(
            "<a class=\"equation-ref\" href=\"{address}\">{}</a>",
            equations::label(equation)
        ))
    }

    /// Returns the equation's number with a link to the page that shows it, if one does.
    fn equation_link(&self, current: &CurrentPage<'_>, id: &str) -> String {
        self.reference(current, id)
            .or_else(|_| equations::find(id).map(equations::label))
            .unwrap_or_default()
    }

    /// Returns the experiment's name with a link to its recorded results, if there are any.
    fn experiment_link(&self, from: &Path, id: &str) -> String {
        match self.index.lists.get("experiments") {
            Some(page) if self.results.experiment(id).is_ok() => {
                let address = address(from, page, &experiment_fragment(id));
                format!("<a href=\"{address}\">{}</a>", escape(id))
            }
            _ => escape(id),
        }
    }

    fn equation_address(&self, from: &Path, id: &str) -> Option<String> {
        Some(address(
            from,
            self.index.equations.get(id)?,
            &equations::fragment(id),
        ))
    }

    /// Returns a trial's name with a link to its row.
    fn trial(&self, current: &CurrentPage<'_>, name: &str) -> Result<String, String> {
        let label = registry::trial(name)?;
        let list_page = self.index.lists.get("trials");
        Ok(list_page.map_or(label.clone(), |page| {
            let address = address(current.path, page, &registry::trial_fragment(name));
            format!("<a href=\"{address}\">{label}</a>")
        }))
    }

    fn cite(&self, current: &CurrentPage<'_>, key: &str) -> Result<String, String> {
        let label = escape(&self.bibliography.work(key)?.label);
        Ok(match self.index.lists.get("bibliography") {
            Some(page) => {
                let address = address(current.path, page, &format!("cite-{key}"));
                format!("<a class=\"citation\" href=\"{address}\">{label}</a>")
            }
            None => format!("<span class=\"citation\">{label}</span>"),
        })
    }

    fn code(&self, path: &str, items: &[&str]) -> Result<String, String> {
        let source = listing::read(self.sources, path)?;
        let listings = items
            .iter()
            .map(|item| listing::item(&source, item).map_err(|e| format!("{path}: {e}")))
            .collect::<Result<Vec<_>, _>>()?;
        let (code, lines): (Vec<_>, Vec<_>) = listings
            .into_iter()
            .map(|l| (l.code, l.line.to_string()))
            .unzip();
        let plural = if lines.len() == 1 { "line" } else { "lines" };
        let (path, lines, code) = (escape(path), lines.join(", "), code.join("\n\n"));
        Ok(format!(
            "\n\n<p class=\"listing-source\"><code>{path}</code>, {plural} {lines}</p>\n\n\
             ``````rust,ignore,noplayground\n{code}\n``````\n\n"
        ))
    }

    /// Returns a link to the page with the reader's own run.
    fn run(&self, from: &Path) -> String {
        if self.has_run {
            let (root, page, title) = (to_root(from), run::PAGE, run::TITLE);
            return format!("<p>In this book it is <a href=\"{root}{page}\">{title}</a>.</p>");
        }
        "<p>This book was woven without a run and has no such page.</p>".to_owned()
    }

    /// Returns the list of all recorded experiments.
    fn experiments(&self) -> String {
        let sections: String = self.results.all().map(experiment).collect();
        if sections.is_empty() {
            "<p>No results are recorded yet.</p>".to_owned()
        } else {
            sections
        }
    }
}

/// Returns `text` with spans replaced, and the text between them passed through `rest`.
fn replace(
    text: &str,
    mut edits: Vec<(Range<usize>, String)>,
    rest: impl Fn(&str) -> String,
) -> String {
    edits.sort_by_key(|(span, _)| span.start);
    let mut out = String::with_capacity(2 * text.len());
    let mut from = 0;
    for (span, replacement) in edits {
        out.push_str(&rest(&text[from..span.start]));
        out.push_str(&replacement);
        from = span.end;
    }
    out.push_str(&rest(&text[from..]));
    out
}

/// Joins a formula and the punctuation after it, so that no line begins with the punctuation.
fn keep_together(text: &str, span: Range<usize>, html: &str) -> (Range<usize>, String) {
    let after = &text[span.end..];
    let length = after.len()
        - after
            .trim_start_matches([',', '.', ';', ':', ')', '?'])
            .len();
    if length == 0 {
        return (span, html.to_owned());
    }
    (
        span.start..span.end + length,
        format!("<span class=\"keep\">{html}{}</span>", &after[..length]),
    )
}

fn experiment_fragment(id: &str) -> String {
    format!("experiment-{id}")
}

fn experiment(recorded: &ExperimentResult) -> String {
    let ExperimentResult {
        version,
        seed,
        numbers,
        ..
    } = recorded;
    let row = |(key, &value): (&String, &f64)| {
        let value = number::format(value, None).unwrap_or_default();
        format!(
            "<tr><td><code>{}</code></td><td>{value}</td></tr>",
            escape(key)
        )
    };
    let rows: String = numbers.iter().map(row).collect();
    let [id, tier, command] =
        [&recorded.id, &recorded.tier, &recorded.command].map(|text| escape(text));
    format!(
        "<h2 id=\"{}\">{id}</h2><p>Version {version}, tier {tier}, seed {seed}. Repeat with <code>{command}</code>.</p>\
         <details><summary>Numbers ({})</summary><div class=\"table-wrapper\"><table><thead><tr><th>number</th>\
         <th>value</th></tr></thead><tbody>{rows}</tbody></table></div></details>",
        experiment_fragment(&recorded.id),
        numbers.len(),
    )
}
