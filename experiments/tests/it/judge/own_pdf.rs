//! Tests of `judge --own-pdf`.

use super::*;

/// Twelve million samples decide (`harness::own_pdf`); fewer tell what is far off.
#[test]
fn a_pdf_is_judged_by_its_own_samples() {
    let folder = folder("own-pdf");
    let directions = cosines(200_000);
    let write = |name: &str, factor: f64| {
        let row = |w: &DVec3| [w.x, w.y, w.z, factor * w.z / PI];
        let shape = [directions.len() as u64, 4];
        let numbers = directions.iter().flat_map(row);
        npy(&folder.join(name), npyz::Order::C, shape, numbers);
    };
    write("right.npy", 1.0);
    write("doubled.npy", 2.0);
    let own = "--own-pdf --columns x,y,z,pdf";
    for case in [
        "2 --samples right.npy OWN => needs about",
        "1 --samples doubled.npy OWN => DIFFER: the pdf in region",
        "2 --samples right.npy OWN --covers hemisphere => integral of z²: holds",
        "1 --samples right.npy OWN --covers sphere => DIFFER: the integral of |z|",
        "3 --samples right.npy --own-pdf --columns x,y,z,- => --own-pdf needs a column pdf",
        // A requirement alone is not asked for beside what it excludes.
        "3 --samples right.npy --density cosine --covers sphere => cannot be used with '--covers <COVERS>'",
        "3 --samples right.npy --density cosine --domain sphere => cannot be used with '--domain <DOMAIN>'",
        "3 --samples right.npy OWN --margin 1 => is too small for --own-pdf",
    ] {
        assert_case(&folder, &case.replace("OWN", own));
    }
}
