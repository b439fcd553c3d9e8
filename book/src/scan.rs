//! Scans one page for directives, formulas, links and code.

use std::ops::Range;

use mdbook_markdown::pulldown_cmark::{
    BrokenLink, CodeBlockKind, CowStr, Event, LinkType, Options, Parser, Tag, TagEnd,
};

/// A directive `{{#name arguments}}` outside of code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Directive {
    /// Range from the opening to the closing braces.
    pub span: Range<usize>,
    /// Name after `#`.
    pub name: String,
    /// Words, and quoted texts without their quotes.
    pub arguments: Vec<String>,
    /// True if nothing else stands on its lines.
    pub alone: bool,
}

/// A formula `$…$` or `$$…$$`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formula {
    /// Range in the text, dollar signs included.
    pub span: Range<usize>,
    /// LaTeX between the dollar signs.
    pub latex: String,
    /// True if it stands on its own line.
    pub display: bool,
}

/// Everything on a page that the weave replaces or checks. Spans are in bytes.
#[derive(Debug, Default)]
pub struct Page {
    /// Directives in order of appearance.
    pub directives: Vec<Directive>,
    /// Formulas in order of appearance, without those in directives' arguments.
    pub formulas: Vec<Formula>,
    /// Link and image targets.
    pub links: Vec<(Range<usize>, String)>,
    /// Running text outside of headings, quotes, links and code, with directives.
    pub prose: Vec<Range<usize>>,
    /// Errors in the Markdown itself.
    pub problems: Vec<(usize, String)>,
}

/// Returns the Markdown options of mdBook's HTML renderer, with formulas.
fn options() -> Options {
    Options::ENABLE_TABLES
        | Options::ENABLE_FOOTNOTES
        | Options::ENABLE_STRIKETHROUGH
        | Options::ENABLE_TASKLISTS
        | Options::ENABLE_HEADING_ATTRIBUTES
        | Options::ENABLE_SMART_PUNCTUATION
        | Options::ENABLE_DEFINITION_LIST
        | Options::ENABLE_GFM
        | Options::ENABLE_MATH
}

pub fn page(text: &str) -> Page {
    let mut page = Page::default();
    let mut code = Vec::new();
    let mut formulas = Vec::new();
    let mut broken = Vec::new();
    let mut on_broken = |link: BrokenLink<'_>| -> Option<(CowStr<'_>, CowStr<'_>)> {
        if matches!(link.link_type, LinkType::Reference | LinkType::Collapsed) {
            broken.push((
                link.span.start,
                format!("link to \"{}\", which is not defined", link.reference),
            ));
        }
        None
    };
    let parser = Parser::new_with_broken_link_callback(text, options(), Some(&mut on_broken));
    // Number of open elements whose text is not prose.
    let mut apart = 0_u32;
    let is_apart = |tag: TagEnd| {
        use TagEnd::{BlockQuote, CodeBlock, Heading, Image, Link};
        matches!(tag, Heading(_) | BlockQuote(_) | CodeBlock | Link | Image)
    };
    for (event, span) in parser.into_offset_iter() {
        match &event {
            Event::Start(tag) if is_apart(tag.to_end()) => apart += 1,
            Event::End(tag) if is_apart(*tag) => apart -= 1,
            Event::Text(_) | Event::SoftBreak if apart == 0 => match page.prose.last_mut() {
                Some(last) if last.end == span.start => last.end = span.end,
                _ => page.prose.push(span.clone()),
            },
            _ => {}
        }
        match event {
            Event::Code(_) => code.push(span),
            Event::Start(Tag::CodeBlock(kind)) => {
                if let CodeBlockKind::Fenced(info) = kind
                    && is_rust(&info)
                {
                    let message = "Rust code typed into the page; take it from the source with \
                                   {{#code PATH ITEM}}";
                    page.problems.push((span.start, message.to_owned()));
                }
                code.push(span);
            }
            Event::InlineMath(latex) => formulas.push(Formula {
                span,
                latex: latex.into_string(),
                display: false,
            }),
            Event::DisplayMath(latex) => formulas.push(Formula {
                span,
                latex: latex.into_string(),
                display: true,
            }),
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                page.links.push((span, dest_url.into_string()));
            }
            _ => {}
        }
    }
    page.problems.extend(broken);
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if ["<<<<<<< ", ">>>>>>> ", "||||||| "]
            .iter()
            .any(|mark| line.starts_with(mark))
        {
            page.problems
                .push((at, "an unresolved merge conflict".to_owned()));
        }
        at += line.len();
    }
    directives(text, &code, &mut page);
    for formula in formulas {
        let Range { start, end } = formula.span;
        match page
            .directives
            .iter()
            .find(|d| d.span.start < end && start < d.span.end)
        {
            None => page.formulas.push(formula),
            // The formula is in an argument.
            Some(d) if d.span.start <= start && end <= d.span.end => {}
            Some(_) => {
                page.problems.push((
                    start,
                    "a directive inside a formula; put it beside the formula".to_owned(),
                ));
            }
        }
    }
    page
}

/// Returns true if a fence's info string says Rust.
fn is_rust(info: &str) -> bool {
    let language = info
        .split([',', ' ', '\t', '{'])
        .next()
        .unwrap_or_default()
        .to_ascii_lowercase();
    matches!(language.as_str(), "rust" | "rs")
}

/// Finds the directives outside of the code spans.
fn directives(text: &str, code: &[Range<usize>], page: &mut Page) {
    let mut from = 0;
    while let Some(found) = text[from..].find("{{#") {
        let start = from + found;
        if let Some(span) = code.iter().find(|span| span.contains(&start)) {
            from = span.end;
            continue;
        }
        let inner = start + 3;
        let Some(end) = closing(&text[inner..]).map(|length| inner + length) else {
            page.problems
                .push((start, "this directive is not closed by }}".to_owned()));
            return;
        };
        from = end + 2;
        let mut words = words(&text[inner..end]);
        if words.is_empty() {
            page.problems
                .push((start, "a directive without a name".to_owned()));
            continue;
        }
        let before = text[..start].rsplit('\n').next().unwrap_or_default();
        let after = text[from..].split('\n').next().unwrap_or_default();
        page.directives.push(Directive {
            span: start..from,
            name: words.remove(0),
            arguments: words,
            alone: before.trim().is_empty() && after.trim().is_empty(),
        });
    }
}

/// Returns the position of the `}}` outside of quotes.
fn closing(text: &str) -> Option<usize> {
    let mut quoted = false;
    for (at, character) in text.char_indices() {
        match character {
            '"' => quoted = !quoted,
            '}' if !quoted && text[at..].starts_with("}}") => return Some(at),
            _ => {}
        }
    }
    None
}

/// Splits at white space outside of quotes; line ends in quotes become spaces.
fn words(text: &str) -> Vec<String> {
    let mut words = Vec::new();
    for (index, part) in text.split('"').enumerate() {
        if index % 2 == 1 {
            words.push(part.split_whitespace().collect::<Vec<_>>().join(" "));
        } else {
            words.extend(part.split_whitespace().map(str::to_owned));
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directives_in_code_are_left_alone() {
        let text = "`{{#eq a}}` and {{#eq b}}\n\n```text\n{{#eq c}}\n```\n";
        let names: Vec<_> = page(text)
            .directives
            .into_iter()
            .map(|d| d.arguments)
            .collect();
        assert_eq!(names, [["b"]]);
    }

    #[test]
    fn quotes_hold_braces_spaces_and_formulas() {
        let found = page("{{#figure a/b.svg \"one $\\frac{a}{b_{c}}$\ntwo\"}}\n");
        let directive = &found.directives[0];
        assert!(directive.alone && found.formulas.is_empty());
        assert_eq!(
            directive.arguments,
            ["a/b.svg", "one $\\frac{a}{b_{c}}$ two"]
        );
    }

    #[test]
    fn rust_fences_are_problems_and_other_fences_are_not() {
        for info in ["rust", "Rust", "rs", "rust,ignore", "rust ignore"] {
            assert_eq!(
                page(&format!("```{info}\nfn f() {{}}\n```\n"))
                    .problems
                    .len(),
                1,
                "{info}"
            );
        }
        assert!(page("```sh\nls\n```\n").problems.is_empty());
    }

    #[test]
    fn formulas_are_found_outside_of_code_only() {
        let found = page("$a_1$ `$b$` and $$c$$");
        let latex: Vec<_> = found
            .formulas
            .iter()
            .map(|f| (f.latex.as_str(), f.display))
            .collect();
        assert_eq!(latex, [("a_1", false), ("c", true)]);
    }
}
