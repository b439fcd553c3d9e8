//! Tables of the recorded mutants.

use records::mutants::{Counts, Record, Survivor};

use crate::mathml::typeset;
use crate::registry::{code, row, table};

/// Returns the table of files and, below it, that of the survivors, as HTML.
pub fn tables(record: &Record) -> String {
    let counted = |name: &str, counts: &Counts| {
        let Counts {
            caught,
            timeout,
            missed,
            sample_of,
            ..
        } = counts;
        let [viable, caught, timeout, missed] =
            [&counts.viable(), caught, timeout, missed].map(usize::to_string);
        let tried = sample_of.map_or(viable.clone(), |all| {
            format!("{viable} (a sample of {all})")
        });
        row([name, &tried, &caught, &timeout, &missed])
    };
    let files = record
        .files
        .iter()
        .map(|(file, counts)| counted(&code(file), counts));
    let files: Vec<String> = files.chain([counted("all", &record.total())]).collect();
    let survivor = |s: &Survivor| row([&code(&s.mutant), &typeset(&s.reason)]);
    let survivors: Vec<String> = record.survivors.iter().map(survivor).collect();
    table(
        &["file", "mutants", "caught", "not ended in time", "survived"],
        &files,
    ) + &table(&["survivor", "why it may live"], &survivors)
}
