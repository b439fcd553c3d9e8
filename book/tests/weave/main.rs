//! Tests of the weave on small books: its errors and its output; `real` weaves the real book.

use std::fs;
use std::path::PathBuf;

use book::{Error, Options, build};
use tempfile::TempDir;

mod questions;
mod real;

const RESULT: &str = r#"{
  "id": "demo", "title": "", "version": 1, "command": "cargo run --release -- --only demo",
  "tier": "quick", "seed": 1, "shrink": 1, "equations": [], "findings": [], "fingerprint": "",
  "numbers": { "psnr": 31.41592, "count": 12345 },
  "figures": ["plot.svg", "lost.svg"]
}"#;

const SOURCE: &str = "/// Twice `x`.\npub fn twice(x: f64) -> f64 {\n    2.0 * x\n}\n";

/// A book of one page, with one source file, one result and one reference.
struct Small {
    folder: TempDir,
}

impl Small {
    fn new(page: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let book = Self { folder };
        book.write("book/book.toml", BOOK_TOML);
        book.write("book/pages/SUMMARY.md", "- [Page](page.md)\n");
        book.write("book/pages/page.md", page);
        book.write("book/pages/plain.txt", "x");
        book.write("book/bibliography.toml", BIBLIOGRAPHY);
        book.write("src/demo.rs", SOURCE);
        book.write("recorded/demo/result.json", RESULT);
        book.write("recorded/demo/plot.svg", &svg(""));
        book
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("folder");
        fs::write(path, text).expect("file");
    }

    fn build(&self) -> Result<PathBuf, Error> {
        build(&Options {
            book: self.path("book"),
            sources: self.folder.path().to_owned(),
            results: self.path("recorded"),
            run: self.path("run").is_dir().then(|| self.path("run")),
            out: self.path("out"),
        })
    }

    /// Returns the page's HTML.
    fn html(&self) -> String {
        self.build().expect("this book is sound");
        fs::read_to_string(self.path("out/page.html")).expect("the page")
    }

    /// Asserts that the page's HTML has all of these parts, and returns it.
    fn shows(&self, parts: &[&str]) -> String {
        let html = self.html();
        for part in parts {
            assert!(html.contains(part), "no {part:?} in: {html}");
        }
        html
    }

    /// Asserts that the message has all of these parts, and returns it.
    fn says(&self, parts: &[&str]) -> String {
        let message = self.build().expect_err("this book is faulty").to_string();
        for part in parts {
            assert!(message.contains(part), "no {part:?} in: {message}");
        }
        message
    }

    /// Asserts that the message names the page's third line and contains all of `parts`, and that
    /// nothing is written.
    fn refused(&self, parts: &[&str]) {
        self.says(&[parts, &["pages/page.md:3: "]].concat());
        assert!(!self.path("out/page.html").exists(), "nothing is written");
    }
}

/// Returns a figure of the size that the books need.
fn svg(body: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"4\" height=\"3\" viewBox=\"0 0 4 3\">{body}</svg>"
    )
}

const BOOK_TOML: &str = "[book]\ntitle = \"Small\"\nsrc = \"pages\"\n[build]\ncreate-missing = false\n\
                         use-default-preprocessors = false\n[output.html]\ninput-404 = \"\"\n\
                         hash-files = false\n[output.html.print]\nenable = false\n";

const BIBLIOGRAPHY: &str = "[kajiya1986]\nlabel = \"Kajiya 1986\"\nauthors = \"J. Kajiya\"\n\
                            title = \"The rendering equation\"\nvenue = \"SIGGRAPH\"\nyear = 1986\n";

/// Returns a book of a page with this text under its title, from the third line on.
fn small(text: &str) -> Small {
    Small::new(&format!("# Page\n\n{text}\n"))
}

/// Cases under headings: a line of a page, and all parts of its error message.
#[test]
fn what_is_missing_broken_or_misused_is_refused() {
    let is_case = |line: &&str| !line.is_empty() && !line.starts_with("# ");
    for case in include_str!("refused.txt").lines().filter(is_case) {
        let (line, said) = case.split_once(" => ").expect("a line and its message");
        small(line).refused(&said.split(" && ").collect::<Vec<_>>());
    }
}

/// The first use of a word on a page is linked to the glossary, but not in a heading, a link, a
/// formula, code or a directive.
#[test]
fn words_are_linked_to_the_glossary() {
    let book = Small::new(
        "# A trial\n\n> A trial?\n\n`trial` [trial](plain.txt) $trial$ pretrial TRIAL (Trials, trials)\n\nPower of \
         multiple-importance\nsampling by MIS.\n",
    );
    book.write(
        "book/pages/SUMMARY.md",
        "- [Page](page.md)\n- [Glossary](glossary.md)\n",
    );
    let words = "# Glossary\n\n**Trial.** A trial.\n\n**MIS, multiple importance sampling.** x\n\n**Power.** x\n";
    book.write("book/pages/glossary.md", words);
    let html = book.shows(&[
        "(<a href=\"glossary.html#term-trial\">Trials</a>, trials)",
        "Power of <a href=\"glossary.html#term-mis\">multiple-importance\nsampling</a> by MIS.",
    ]);
    assert_eq!(html.matches("glossary.html#").count(), 2);
}

/// Figures that no browser can show, or without a stated size, are refused.
#[test]
fn a_damaged_figure_is_refused() {
    let whole = svg("\n<g/>");
    let without = |text: &str| whole.replace(text, "");
    let faults = [
        (String::new(), 1),
        (without("</svg>"), 1),
        (without("/>"), 2),
        (whole.replace("<g/>", "<g fill=\"#fff\" fill=\"#fff\"/>"), 2),
        (whole.replace("<g/>", "A & B"), 2),
        (without(" xmlns=\"http://www.w3.org/2000/svg\""), 1),
        (without(" width=\"4\""), 1),
        (without(" height=\"3\""), 1),
        (without(" viewBox=\"0 0 4 3\""), 1),
        (whole.replace("\"0 0 4 3\"", "\"0 0 4\""), 1),
        (whole.replace("width=\"4\"", "width=\"0\""), 1),
        (whole.replace("height=\"3\"", "height=\"inf\""), 1),
    ];
    let page = "# Page\n\n{{#figure demo/plot.svg \"A plot.\"}}\n";
    for (text, line) in faults {
        let book = Small::new(page);
        book.write("recorded/demo/plot.svg", &text);
        book.says(&[&format!("recorded/demo/plot.svg:{line}: ")]);
        assert!(!book.path("out/page.html").exists(), "nothing is written");
    }
    let book = Small::new(&page.replace("svg", "png"));
    book.write(
        "recorded/demo/result.json",
        &RESULT.replace("plot.svg", "plot.png"),
    );
    book.write("recorded/demo/plot.png", "no picture");
    book.says(&["plot.png:1: not a whole PNG"]);
    // The figures of a reader's own run are tested in the same way.
    let book = with_run(EMPTY, EMPTY);
    book.write("run/demo/plot.svg", "<svg>");
    book.says(&["run/demo/plot.svg:1: "]);
}

#[test]
fn a_link_to_a_missing_heading_is_refused() {
    small("[Here](#nothing).").says(&["page.md:3: no heading #nothing"]);
}

#[test]
fn raw_html_cannot_reach_outside() {
    for html in [
        "<img src=\"https://example.org/a.png\">",
        "<a href=\"gone.html\">x</a>",
    ] {
        small(html).says(&["page.html:"]);
    }
}

/// Conflict markers, and duplicate texts or figures, which a merge left unresolved, are refused.
#[test]
fn what_a_merge_leaves_is_refused() {
    for mark in ["<<<<<<< HEAD", "||||||| base", ">>>>>>> 3069b86 (Draw)"] {
        small(mark).refused(&["merge"]);
    }
    let figure = "{{#figure demo/plot.svg \"A plot.\"}}";
    Small::new(&format!("{figure}\n\n{figure}\n"))
        .refused(&["demo/plot.svg is already shown on this page"]);
}

#[test]
fn typed_rust_is_refused() {
    small("```rust\nfn f() {}\n```").refused(&["Rust code typed into the page"]);
}

#[test]
fn an_equation_is_shown_once() {
    Small::new("{{#eq ray}}\n\n{{#eq ray}}\n").refused(&["already shown on page.md"]);
}

#[test]
fn a_missing_page_is_refused() {
    let book = Small::new("# Page\n");
    book.write(
        "book/pages/SUMMARY.md",
        "- [Page](page.md)\n- [Lost](lost.md)\n",
    );
    book.says(&["SUMMARY.md:2: there is no page lost.md"]);
}

#[test]
fn a_damaged_record_is_refused() {
    let book = Small::new("# Page\n");
    for (text, part) in [
        ("{\n  \"id\": \"demo\",\n", "result.json:"),
        (&RESULT.replace("31.41592", "null"), "result.json:"),
        (
            &RESULT.replace("\"demo\"", "\"other\""),
            "the folder \"demo\"",
        ),
        (
            &RESULT.replace("plot.svg", "../plot.svg"),
            "beside this one",
        ),
    ] {
        book.write("recorded/demo/result.json", text);
        book.says(&[part]);
    }
}

#[test]
fn a_damaged_bibliography_is_refused() {
    let book = Small::new("# Page\n");
    book.write("book/bibliography.toml", "\n[a]\nlabel = 1\n");
    book.says(&["bibliography.toml:3: "]);
}

#[test]
fn every_fault_of_a_book_is_told_at_once() {
    let message = Small::new("{{#eq a}}\n{{#result b.c}}\n\n{{#cite d}}\n").says(&[]);
    assert_eq!(message.lines().count(), 3, "{message}");
}

#[test]
fn a_folder_of_something_else_is_not_emptied() {
    let book = Small::new("# Page\n");
    book.write("out/precious.txt", "x");
    assert!(matches!(book.build(), Err(Error::Occupied(_))));
    assert!(book.path("out/precious.txt").exists());
}

#[test]
fn equations_numbers_and_code_appear() {
    let text = "{{#eq oren-nayar}}\n\nSee {{#ref oren-nayar}}: {{#result demo.psnr %.1f}} of \
                {{#result demo.count %d}}.\n\n{{#code src/demo.rs twice}}";
    let html = small(text).shows(&[
        "id=\"eq-oren-nayar\"",
        "(14)",
        "As the report prints it",
        "badge-error",
        "page.html#eq-oren-nayar",
        "31.4 of 12\u{202f}345",
        "/// Twice `x`.\npub fn twice",
    ]);
    assert!(!html.contains("{{"), "a directive is left over");
}

#[test]
fn figures_carry_number_caption_and_command() {
    let book = Small::new(
        "# Page\n\n{{#figure demo/plot.svg \"Error $\\sigma$ & {{#result demo.psnr %.1f}} dB.\"}}\n\n{{#experiments}}\n",
    );
    book.shows(&[
        "src=\"figures/demo/plot.svg\"",
        "Figure 1.1.",
        "&amp; 31.4 dB.",
        "<math>",
        "cargo run --release -- --only demo",
        "page.html#experiment-demo",
        "id=\"experiment-demo\"",
    ]);
    assert!(book.path("out/figures/demo/plot.svg").is_file());
}

#[test]
fn citations_lead_to_the_bibliography() {
    let parts = [
        "page.html#cite-kajiya1986\">Kajiya 1986</a>",
        "id=\"cite-kajiya1986\"",
    ];
    small("As {{#cite kajiya1986}}.\n\n{{#bibliography}}").shows(&parts);
}

#[test]
fn formulas_survive_markdown_and_code_does_not_change() {
    let html =
        small("$a_1 * b_2 * [c]$ costs `$5_1$`.\n\n| $|x|$ | b |\n|---|---|\n| 1 | $y_1$ |").html();
    assert!(html.contains("<code>$5_1$</code>"), "code is left alone");
    assert!(!html.contains("<em>"), "no emphasis inside formulas");
    assert!(html.matches("<math").count() >= 2);
}

/// A record without numbers and findings.
const EMPTY: &str = r#""numbers": {}, "findings": []"#;

/// Returns a book with a run of the experiment `demo` that has these numbers and findings.
fn with_run(record: &str, run: &str) -> Small {
    let book = Small::new("# Page\n\n{{#run}}\n");
    for (folder, body) in [("recorded", record), ("run", run)] {
        let text = format!(
            "{{ \"id\": \"demo\", \"title\": \"\", \"version\": 1, \"command\": \"x\", \"tier\": \"quick\", \"seed\": 7, \
             \"shrink\": 4, \"equations\": [], \"figures\": [\"plot.svg\"], \"fingerprint\": \"\", {body} }}"
        );
        book.write(&format!("{folder}/demo/result.json"), &text);
        let plot = svg(&format!("<desc>{folder}</desc>"));
        book.write(&format!("{folder}/demo/plot.svg"), &plot);
    }
    book
}

/// Returns the page that compares the run with the record.
fn run_page(record: &str, run: &str) -> String {
    let book = with_run(record, run);
    book.build().expect("this book is sound");
    fs::read_to_string(book.path("out/run.html")).expect("the page of the run")
}

#[test]
fn a_run_stands_beside_the_record() {
    let findings = r#""numbers": {}, "findings": [
        { "what": "alike", "value": "1", "verdict": "holds" },
        { "what": "worse", "value": "2", "verdict": "holds" },
        { "what": "a note", "value": "3", "verdict": null }]"#;
    let own = r#""numbers": {}, "findings": [
        { "what": "alike", "value": "1", "verdict": "holds" },
        { "what": "worse", "value": "9", "verdict": "fails" },
        { "what": "new", "value": "4", "verdict": "undecided" }]"#;
    let book = with_run(findings, own);
    book.shows(&["<a href=\"run.html\">Your run beside the record</a>"]);
    let page = fs::read_to_string(book.path("out/run.html")).expect("the page of the run");
    // Hold, fail, undecided: in the record and in the run; tier, seed and shrink of both.
    assert!(
        page.contains("<td>2, 0, 0</td><td>1, <strong>1</strong>, 1</td>"),
        "{page}"
    );
    assert_eq!(page.matches("<td>quick, 7, 4</td>").count(), 2);
    let row = "<td>worse</td><td><strong>holds</strong> 2</td><td><strong>fails</strong> 9</td>";
    assert!(page.contains(row), "{page}");
    assert!(page.contains("judged differently (2)") && page.contains("judged alike (1)"));
    assert!(!page.contains("a note"));
    for (file, text) in [
        ("figures/demo/plot.svg", "recorded"),
        ("figures/run/demo/plot.svg", "run"),
    ] {
        assert!(page.contains(&format!("src=\"{file}\"")), "{page}");
        let figure = fs::read_to_string(book.path("out").join(file)).expect("a figure");
        assert!(figure.contains(text));
    }
}

#[test]
fn numbers_are_compared_by_the_noise_that_both_state() {
    let body = |x: f64, plain: f64| {
        format!(
            "\"numbers\": {{ \"x\": {x}, \"x.half\": 3.0, \"t.estimate\": 1.0, \"t.low\": 0.5, \
             \"t.high\": 1.5, \"y\": 2.0, \"y_error\": 0.1, \"plain\": {plain}, \"z\": {x}, \"z.half\": 0.0, \
             \"r.estimate\": {x}, \"r.reference\": {plain}, \"r.low\": 0.0, \"r.high\": 1.0 }}, \"findings\": []"
        )
    };
    // Half widths of 3 each explain 4.24; standard errors count five times. Not compared: plain; z,
    // whose half width is zero; and r, which estimates something else.
    let within = run_page(&body(10.0, 1.0), &body(14.2, 5.0));
    assert!(within.contains("<td>0 of 3</td>"), "{within}");
    assert!(within.contains("without an interval that differ (4)"));
    let beyond = run_page(&body(10.0, 1.0), &body(14.3, 1.0));
    assert!(beyond.contains("<td>2 of 4</td>"), "{beyond}");
    assert!(
        beyond.contains("<td><code>x</code></td><td>10 ± 3</td><td>14.30 ± 3</td>"),
        "{beyond}"
    );
}

#[test]
fn without_a_run_there_is_no_page_of_it() {
    let book = Small::new("# Page\n\n{{#run}}\n");
    book.shows(&["woven without a run"]);
    assert!(!book.path("out/run.html").exists());
    book.write("run/nothing.txt", "");
    book.says(&["run: holds no results of a run"]);
}
