//! Tests of questions: their answers are those of the recorded matrices.

use std::fs;

use book::{Options, check};

use crate::Small;

/// Returns a book with this question on its page, and the recorded matrices.
fn asking(question: &str) -> Small {
    let book = Small::new(&format!("# Page\n\n{question}\n"));
    book.write(
        "book/pages/SUMMARY.md",
        "- [Page](page.md)\n- [Faults](faults.md)\n",
    );
    book.write("book/pages/faults.md", "# Faults\n\n## Fault by trial\n");
    let recorded = Options::default().results.join("faults");
    for file in check::files(&recorded).expect("recorded matrices") {
        let name = file.file_name().expect("a name").to_string_lossy();
        let text = fs::read_to_string(&file).expect("a figure or a result");
        book.write(&format!("recorded/faults/{name}"), &text);
    }
    book
}

#[test]
fn answers_are_those_of_the_recorded_matrices() {
    let of = |trials: &str| {
        asking(&format!(
            "{{{{#question \"uniform: shared-number\" {trials}}}}}"
        ))
    };
    let book = of("hemisphere/uniform/cells hemisphere/uniform/pdf");
    book.shows(&[
        "<strong>Which of these trials reject it?</strong>",
        "hemisphere/<wbr>uniform/<wbr>cells</code> <strong>rejects</strong> it",
        "hemisphere/<wbr>uniform/<wbr>pdf</code> <strong>does not</strong>",
    ]);
    // A matrix of another run has another answer.
    let file = "recorded/faults/faults-scattering.svg";
    let svg = fs::read_to_string(book.path(file)).expect("a matrix");
    let exchanged = svg
        .replace("#0072B2", "#blue")
        .replace("#F0C566", "#0072B2");
    book.write(file, &exchanged.replace("#blue", "#F0C566"));
    book.says(&["must reject fault", "the record says that it does not"]);
    of("hemisphere/uniform/cells hemisphere/uniform/moments")
        .refused(&["needs a trial that rejects", "and one that does not"]);
    of("hemisphere/uniform/cells hemisphere/uniform/angles")
        .refused(&["the record does not say whether"]);
    of("hemisphere/uniform/cells hemisphere/cosine/pdf").refused(&["no recorded matrix has fault"]);
}
