//! The error budget of this target: the random tests in it, counted.

use whitefurnace::harness::bsdf_checkup::{CheckUp, assertions};

use crate::features;
use crate::harness::{
    checkup_parts, directions, images, lobe_checkup as lobes, narrow_lobes, own_pdf,
    single_precision,
};
use crate::shares::{MIN_COMPARISONS, RANDOM_ASSERTIONS};

/// Asserts that a test of [`MIN_COMPARISONS`] has made enough comparisons.
pub fn assert_enough_compared(name: &str, count: usize) {
    let Some((_, least, _)) = MIN_COMPARISONS.iter().find(|(test, ..)| *test == name) else {
        panic!("{name} has no share of the error budget: add it to MIN_COMPARISONS");
    };
    assert!(count > *least, "{name}: only {count} were compared");
}

/// The counts in the table of shares are those of the modules.
#[test]
fn the_shares_are_counted() {
    let check_up = assertions(&CheckUp::default());
    let counted = [
        ("directions", directions::ASSERTIONS),
        ("images", images::ASSERTIONS),
        ("lobes", lobes::PASSES.iter().sum::<usize>() + lobes::FAULTY),
        ("checkup parts", checkup_parts::ASSERTIONS),
        ("narrow lobes", narrow_lobes::ASSERTIONS),
        ("own pdfs", own_pdf::ASSERTIONS),
        ("features", features::ASSERTIONS),
        ("single precision", single_precision::ASSERTIONS),
        ("documentation", 1 + 10 + 3 * check_up + lobes::PASSES[2]),
    ];
    assert_eq!(RANDOM_ASSERTIONS, counted);
}
