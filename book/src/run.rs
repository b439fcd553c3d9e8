//! The page that compares a reader's own run with the record: claims, numbers that differ beyond
//! their noise, and figures side by side.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use records::noise::{NumberPair, STANDARD_ERRORS, pairs};
use records::number;
use records::results::{DEFAULT_RUN, ExperimentResult, Finding, Judgement, Results};

use crate::mathml::escape;
use crate::registry;
use crate::registry::code;

/// Source path of the page, for links.
pub const SOURCE: &str = "run.md";
/// File name of the written page, beside the book's first.
pub const PAGE: &str = "run.html";
/// Title of the page.
pub const TITLE: &str = "Your run beside the record";

/// Returns the page as Markdown, and its figures: `EXPERIMENT/NAME` or `run/EXPERIMENT/NAME`, and
/// file.
pub fn page(record: &Results, run: &Results) -> (String, BTreeMap<String, PathBuf>) {
    let mut figures = BTreeMap::new();
    let rows: String = run
        .all()
        .map(|ours| row(record.experiment(&ours.id).ok(), ours))
        .collect();
    let sections: String = run
        .all()
        .map(|ours| section(record, run, ours, &mut figures))
        .collect();
    let missing: Vec<String> = record
        .all()
        .filter(|recorded| recorded.id != DEFAULT_RUN && run.experiment(&recorded.id).is_err())
        .map(|recorded| code(&recorded.id))
        .collect();
    let missing = match &missing[..] {
        [] => String::new(),
        some => format!("<p>Not in this run: {}.</p>\n\n", some.join(", ")),
    };
    let text = format!(
        include_str!("run.md"),
        title = TITLE,
        errors = STANDARD_ERRORS,
        rows = rows,
        missing = missing,
        sections = sections
    );
    (text, figures)
}

/// Returns one line of the table of all experiments.
fn row(recorded: Option<&ExperimentResult>, ours: &ExperimentResult) -> String {
    let [their_options, their_counts, beyond] = match recorded {
        None => ["not recorded", "–", "–"].map(str::to_owned),
        Some(recorded) => {
            let pairs = pairs(recorded, ours);
            let with = pairs.iter().filter(|pair| pair.halves.is_some()).count();
            let beyond = pairs.iter().filter(|pair| pair.differs()).count();
            [
                options(recorded),
                counts(recorded),
                format!("{beyond} of {with}"),
            ]
        }
    };
    let id = escape(&ours.id);
    let link = format!("<a href=\"#run-{id}\">{id}</a>");
    line([
        &link,
        &their_options,
        &options(ours),
        &their_counts,
        &counts(ours),
        &beyond,
    ])
}

/// Returns a row of a table, on its own line.
fn line<const N: usize>(cells: [&str; N]) -> String {
    registry::row(cells) + "\n"
}

/// Describes tier, seed and shrink.
fn options(recorded: &ExperimentResult) -> String {
    format!(
        "{}, {}, {}",
        escape(&recorded.tier),
        recorded.seed,
        recorded.shrink
    )
}

/// Counts the claims that hold, fail and are undecided.
fn counts(recorded: &ExperimentResult) -> String {
    let count = |what| {
        recorded
            .findings
            .iter()
            .filter_map(|f| f.verdict)
            .filter(|&verdict| verdict == what)
            .count()
    };
    let [holds, fails, undecided] =
        [Judgement::Holds, Judgement::Fails, Judgement::Undecided].map(count);
    let fails = match fails {
        0 => "0".to_owned(),
        some => format!("<strong>{some}</strong>"),
    };
    format!("{holds}, {fails}, {undecided}")
}

fn section(
    record: &Results,
    run: &Results,
    ours: &ExperimentResult,
    figures: &mut BTreeMap<String, PathBuf>,
) -> String {
    let id = escape(&ours.id);
    let recorded = record.experiment(&ours.id).ok();
    let mut text = format!("<h2 id=\"run-{id}\">{id}</h2>\n\n");
    match recorded {
        None => text += "<p>There is no record of this experiment.</p>\n\n",
        Some(recorded) => {
            let [(version, theirs), (own_version, own)] =
                [recorded, ours].map(|of| (of.version, options(of)));
            text += &format!(
                "<p>Record: version {version}, tier, seed and shrink {theirs}. \
                 Your run: version {own_version}, {own}.</p>\n\n"
            );
            text += &numbers(&pairs(recorded, ours));
        }
    }
    text += &claims(recorded, ours);
    text += &pictures(record, run, ours, figures);
    text
}

/// Returns a table that is open or under a line that opens it; nothing if it has no rows.
fn table(summary: &str, open: bool, head: &str, rows: &[String]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let open = if open { " open" } else { "" };
    format!(
        "<details{open}><summary>{summary}</summary><div class=\"table-wrapper\"><table class=\"registry\">\
         <thead>{head}</thead><tbody>\n{}</tbody></table></div></details>\n\n",
        rows.concat()
    )
}

fn numbers(pairs: &[NumberPair<'_>]) -> String {
    let shown = |value: f64| number::format(value, None).unwrap_or_default();
    let with = pairs.iter().filter(|pair| pair.halves.is_some()).count();
    let beyond: Vec<String> = pairs
        .iter()
        .filter(|pair| pair.differs())
        .map(|pair| {
            let [a, b] = pair.halves.unwrap_or_default();
            let with = |value, half| format!("{} ± {}", shown(value), shown(half));
            let [theirs, own] = [with(pair.values[0], a), with(pair.values[1], b)];
            let [distance, noise] = [pair.distance(), a.hypot(b)].map(shown);
            line([&code(pair.key), &theirs, &own, &distance, &noise])
        })
        .collect();
    let unjudged: Vec<String> = pairs
        .iter()
        .filter(|pair| pair.halves.is_none() && pair.values[0] != pair.values[1])
        .map(|pair| {
            let [theirs, own] = pair.values.map(shown);
            line([&code(pair.key), &theirs, &own])
        })
        .collect();
    let head = "<tr><th>number</th><th>record</th><th>your run</th>";
    let sentence = match (with, beyond.len()) {
        (0, _) => "No number carries an interval in both.".to_owned(),
        (with, beyond) => {
            format!("Of {with} numbers with an interval in both, {beyond} differ beyond noise.")
        }
    };
    format!(
        "<p>{sentence}</p>\n\n{}{}",
        table(
            &format!("Numbers that differ beyond noise ({})", beyond.len()),
            true,
            &format!("{head}<th>apart</th><th>noise explains</th></tr>"),
            &beyond
        ),
        table(
            &format!(
                "Numbers without an interval that differ ({})",
                unjudged.len()
            ),
            false,
            &format!("{head}</tr>"),
            &unjudged
        )
    )
}

/// Returns the claims in the record and in the run: those that fail or are judged differently
/// first.
fn claims(recorded: Option<&ExperimentResult>, ours: &ExperimentResult) -> String {
    let both: [Vec<(&Finding, Judgement)>; 2] = [recorded, Some(ours)].map(|from| {
        from.into_iter()
            .flat_map(|r| &r.findings)
            .filter_map(|f| Some((f, f.verdict?)))
            .collect()
    });
    let mut seen = BTreeSet::new();
    let names = both.iter().flatten().map(|(f, _)| &f.what);
    let (mut first, mut rest) = (Vec::new(), Vec::new());
    for what in names.filter(|name| seen.insert(*name)) {
        let pair = both
            .each_ref()
            .map(|claims| claims.iter().find(|(f, _)| f.what == *what));
        let cells = pair.map(|found| {
            found.map_or("–".to_owned(), |(f, v)| {
                format!("<strong>{}</strong> {}", v.word(), escape(&f.value))
            })
        });
        let row = line([&escape(what), &cells[0], &cells[1]]);
        let verdicts = pair.map(|found| found.map(|(_, verdict)| *verdict));
        if verdicts[0] != verdicts[1] || verdicts.contains(&Some(Judgement::Fails)) {
            first.push(row);
        } else {
            rest.push(row);
        }
    }
    let head = "<tr><th>claim</th><th>record</th><th>your run</th></tr>";
    let [a, b] = [first.len(), rest.len()];
    // Where a whole tier lies between the two, hundreds may be undecided, so the table is closed.
    table(
        &format!("Claims that fail or are judged differently ({a})"),
        a <= 12,
        head,
        &first,
    ) + &table(&format!("Claims judged alike ({b})"), false, head, &rest)
}

/// Returns figures side by side, the record's on the left.
fn pictures(
    record: &Results,
    run: &Results,
    ours: &ExperimentResult,
    figures: &mut BTreeMap<String, PathBuf>,
) -> String {
    let recorded = record.experiment(&ours.id).ok();
    let mut names: Vec<&String> = ours.figures.iter().collect();
    names.extend(
        recorded
            .iter()
            .flat_map(|r| &r.figures)
            .filter(|n| !ours.figures.contains(n)),
    );
    let mut side = |results: &Results, folder: &str, name: &str, whose: &str| {
        let files = results.figure(&format!("{}/{name}", ours.id));
        let Ok((_, files)) = files else {
            return format!("<div class=\"side\"><p>{whose}: none</p></div>");
        };
        let mut images = String::new();
        for file in files {
            let file_name = file.file_name().unwrap_or_default().to_string_lossy();
            let copy = format!("{folder}{}/{file_name}", ours.id);
            let [name, id, address] = [name, &ours.id, &copy].map(escape);
            images += &format!(
                "<a href=\"figures/{address}\"><img src=\"figures/{address}\" loading=\"lazy\" \
                 alt=\"{name} of {id}, {whose}\"></a>"
            );
            figures.insert(copy, file);
        }
        format!("<div class=\"side\"><p>{whose}</p><div class=\"picture\">{images}</div></div>")
    };
    let mut text = String::new();
    for name in names {
        let left = side(record, "", name, "record");
        let right = side(run, "run/", name, "your run");
        text += &format!(
            "<figure class=\"sides\">{left}{right}<figcaption><code>{}</code></figcaption></figure>\n\n",
            escape(name)
        );
    }
    text
}
