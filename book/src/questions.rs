//! Questions whose answers come from the recorded matrices of trials and faults: which of some
//! trials reject a fault?

use records::results::Results;
use roxmltree::{Document, Node};
use trials::{all, all_faults};
use whitefurnace::harness::trial::Trial;
use whitefurnace::suggest::did_you_mean;

use crate::mathml::{escape, typeset};
use crate::registry::code;

/// Name of the experiment that records the matrices.
const EXPERIMENT: &str = "faults";
/// Colours of the cells of trials that reject a fault and of those that do not, as
/// `experiments/src/plot/matrix.rs` draws them; a trial with too few samples to say has another.
const COLOURS: [(&str, bool); 2] = [("#0072B2", true), ("#F0C566", false)];

/// Returns a question and its folded answer as HTML: which of these trials reject the fault
/// `FAMILY: NAME`? `link` returns a trial's name as a link.
pub fn question(
    results: &Results,
    fault: &str,
    names: &[&str],
    link: impl Fn(&str) -> Result<String, String>,
) -> Result<String, String> {
    let faults = all_faults();
    let label = |family: &str, name: &str| format!("{family}: {name}");
    let found = faults
        .iter()
        .find(|data| label(data.family, data.name) == fault)
        .ok_or_else(|| {
            let labels: Vec<String> = faults.iter().map(|f| label(f.family, f.name)).collect();
            format!("no fault \"{fault}\"{}", did_you_mean(fault, &labels))
        })?;
    let trials = all();
    let mut asked = String::new();
    let mut answers = [String::new(), String::new()];
    for name in names {
        asked += &format!("<li>{}</li>", link(name)?);
        let rejects = rejects(results, found.family, found.name, name)?;
        if !rejects && found.rejected_by.contains(name) {
            return Err(format!(
                "trial \"{name}\" must reject fault \"{fault}\", but the record says that it does not"
            ));
        }
        let trial = trials.iter().find(|trial| trial.name == *name);
        answers[usize::from(!rejects)] += &trial.map_or_else(String::new, |t| answer(t, rejects));
    }
    if answers.iter().any(String::is_empty) {
        return Err(format!(
            "a question needs a trial that rejects \"{fault}\" and one that does not"
        ));
    }
    Ok(format!(
        "<div class=\"question\"><p>The fault <code>{}</code>: {}. <strong>Which of these trials reject it?</strong></p>\
         <ul>{asked}</ul><details><summary>Answer</summary><ul>{}</ul><p>From the record of all \
         <a href=\"faults.html#fault-by-trial\">faults by trials</a>.</p></details></div>",
        escape(fault),
        typeset(found.wrong),
        answers.concat()
    ))
}

/// Returns a line of the answer.
fn answer(trial: &Trial, rejects: bool) -> String {
    let (name, property) = (code(&trial.name), typeset(&trial.property));
    if rejects {
        format!(
            "<li>{name} <strong>rejects</strong> it. With the fault this is false: {property}.</li>"
        )
    } else {
        format!(
            "<li>{name} <strong>does not</strong>. With the fault this stays true: {property}.</li>"
        )
    }
}

/// Returns whether a trial rejected a fault of its family in the record.
fn rejects(results: &Results, family: &str, fault: &str, trial: &str) -> Result<bool, String> {
    let recorded = results.experiment(EXPERIMENT)?;
    let rows = [fault.to_owned(), format!("{family}: {fault}")];
    for figure in &recorded.figures {
        let (_, files) = results.figure(&format!("{EXPERIMENT}/{figure}"))?;
        for file in files {
            let text = std::fs::read_to_string(&file)
                .map_err(|error| format!("cannot read {}: {error}", file.display()))?;
            if !text.contains(trial) {
                continue;
            }
            if let Some(colour) = cell(&text, &rows, trial)? {
                let verdict = COLOURS.iter().find(|(known, _)| *known == colour);
                return verdict.map(|(_, rejects)| *rejects).ok_or_else(|| {
                    format!("the record does not say whether trial \"{trial}\" rejects fault \"{fault}\": too few samples")
                });
            }
        }
    }
    Err(format!(
        "no recorded matrix has fault \"{family}: {fault}\" under trial \"{trial}\""
    ))
}

/// Returns the colour of a cell of a matrix, drawn as SVG: where the row of one of these names and
/// the column of that name meet; `None` if it is not there.
fn cell(svg: &str, rows: &[String], column: &str) -> Result<Option<String>, String> {
    let document = Document::parse(svg).map_err(|error| error.to_string())?;
    let number = |node: &Node, name| node.attribute(name).and_then(|text| text.parse().ok());
    let text = |node: &Node| node.text().unwrap_or_default().trim().to_owned();
    let texts = || {
        document
            .descendants()
            .filter(|node| node.has_tag_name("text"))
    };
    let x: Option<f64> = texts()
        .find(|node| node.has_attribute("transform") && text(node) == column)
        .and_then(|node| number(&node, "x"));
    let y: Option<f64> = texts()
        .find(|node| node.attribute("text-anchor") == Some("end") && rows.contains(&text(node)))
        .and_then(|node| number(&node, "y"));
    let (Some(x), Some(y)) = (x, y) else {
        return Ok(None);
    };
    let covers = |node: &Node| {
        let place = ["x", "y", "width", "height"].map(|name| number(node, name));
        let [Some(left), Some(top), Some(width), Some(height)] = place else {
            return false;
        };
        (left..left + width).contains(&x) && (top..top + height).contains(&y)
    };
    let cell = document
        .descendants()
        .find(|node| node.has_tag_name("rect") && covers(node));
    Ok(cell.and_then(|node| node.attribute("fill").map(str::to_owned)))
}
