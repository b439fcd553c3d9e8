//! The registry's equations as HTML: the box on a chapter's page, and the matrix of all.

use whitefurnace::equation::{ALL, Assessment, Equation, by_id};

use crate::mathml::{Math, typeset};
use whitefurnace::suggest::did_you_mean;

pub fn find(id: &str) -> Result<&'static Equation, String> {
    by_id(id).ok_or_else(|| {
        format!(
            "no equation \"{id}\" in the registry{}",
            did_you_mean(id, ALL.iter().map(|e| e.id))
        )
    })
}

/// Returns the short name of an equation: its number, its section, or its title if the report lacks
/// it.
pub fn label(equation: &Equation) -> String {
    match equation.number {
        "" => equation.title.to_lowercase(),
        section if section.contains('.') => format!("§ {section}"),
        number => format!("({number})"),
    }
}

/// Returns the HTML id of an equation.
pub fn fragment(id: &str) -> String {
    format!("eq-{id}")
}

/// Returns the box that shows an equation with our verdict; one line of HTML.
pub fn equation_box(equation: &Equation, math: &Math) -> Result<String, String> {
    let (name, place, badge) = (
        name(equation.verdict),
        fragment(equation.id),
        badge(equation.verdict),
    );
    let [title, finding, source] = [equation.title, equation.finding, equation.source].map(typeset);
    let mut html = format!(
        "<div class=\"equation verdict-{name}\" id=\"{place}\"><div class=\"equation-head\">\
         <span class=\"equation-title\">{title}</span>{badge}</div>"
    );
    let number = match equation.number {
        "" => String::new(),
        _ => format!("<span class=\"equation-number\">{}</span>", label(equation)),
    };
    let formula = math.block(equation.latex, true)?;
    html.push_str(&format!(
        "<div class=\"equation-line\"><div class=\"scroll\">{formula}</div>{number}</div>"
    ));
    if let Some(printed) = equation.printed {
        let printed = math.block(printed, true)?;
        html.push_str(&format!(
            "<div class=\"equation-printed\"><span class=\"equation-note\">As the report prints \
             it:</span><div class=\"scroll\">{printed}</div></div>"
        ));
    }
    html.push_str(&format!(
        "<div class=\"equation-finding\">{finding}</div><div class=\"equation-source\">Source: {source}. \
         Registry: <code>{}</code>.</div></div>",
        equation.id,
    ));
    Ok(html)
}

/// Returns the table of all equations. `place` returns the address of the page that shows one.
pub fn matrix(math: &Math, place: impl Fn(&str) -> Option<String>) -> Result<String, String> {
    let mut html = String::from(
        "<table class=\"matrix\"><thead><tr><th class=\"col-number\">No.</th>\
         <th>Equation, finding, source</th><th class=\"col-verdict\">Assessment</th></tr></thead>\
         <tbody>",
    );
    for equation in ALL {
        let title = typeset(equation.title);
        let title = match place(equation.id) {
            Some(address) => format!("<a href=\"{address}\">{title}</a>"),
            None => title,
        };
        let number = match equation.number {
            "" => "–".to_owned(),
            _ => label(equation),
        };
        let [finding, source] = [equation.finding, equation.source].map(typeset);
        let (id, formula, badge) = (
            equation.id,
            math.block(equation.latex, true)?,
            badge(equation.verdict),
        );
        html.push_str(&format!(
            "<tr><td class=\"nowrap\">{number}</td><td>{title} <code>{id}</code><div class=\"scroll\">{formula}</div>\
             {finding}<div class=\"equation-source\">{source}</div></td><td>{badge}</td></tr>"
        ));
    }
    html.push_str("</tbody></table>");
    Ok(html)
}

/// Returns a table row with the number of equations for each verdict.
pub fn tally() -> String {
    let item = |(verdict, _, meaning): (Assessment, &str, &str)| {
        let count = ALL.iter().filter(|e| e.verdict == verdict).count();
        format!(
            "<li>{} <strong>{count}</strong> <span>{meaning}</span></li>",
            badge(verdict)
        )
    };
    let items = VERDICTS.map(item).concat();
    format!("<ul class=\"tally\">{items}</ul>")
}

/// Returns the verdict as a coloured word.
fn badge(verdict: Assessment) -> String {
    let name = name(verdict);
    format!("<span class=\"badge badge-{name}\">{name}</span>")
}

/// The verdicts, in one word and in one clause each.
const VERDICTS: [(Assessment, &str, &str); 4] = [
    (Assessment::Correct, "correct", "right as printed"),
    (
        Assessment::Trap,
        "trap",
        "right, but silent on a case or an assumption that breaks a literal program",
    ),
    (Assessment::Error, "error", "wrong as printed"),
    (
        Assessment::Added,
        "added",
        "not in the report, added because the report needs it",
    ),
];

fn name(verdict: Assessment) -> &'static str {
    VERDICTS
        .iter()
        .find(|(of, ..)| *of == verdict)
        .map_or("", |(_, name, _)| name)
}
