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
    let columns = "--own-pdf --columns x,y,z,pdf";
    for (options, code, hint) in [
        (format!("--samples right.npy {columns}"), 2, "needs about"),
        (
            format!("--samples doubled.npy {columns}"),
            1,
            "DIFFER: the pdf in region",
        ),
        (
            format!("--samples right.npy {columns} --covers hemisphere"),
            2,
            "integral of z²: holds",
        ),
        (
            format!("--samples right.npy {columns} --covers sphere"),
            1,
            "DIFFER: the integral of |z|",
        ),
        (
            "--samples right.npy --own-pdf --columns x,y,z,-".to_owned(),
            3,
            "--own-pdf needs a column pdf",
        ),
        // A requirement alone is not asked for beside what it excludes.
        (
            "--samples right.npy --density cosine --covers sphere".to_owned(),
            3,
            "cannot be used with '--covers <COVERS>'",
        ),
        (
            "--samples right.npy --density cosine --domain sphere".to_owned(),
            3,
            "cannot be used with '--domain <DOMAIN>'",
        ),
        (
            format!("--samples right.npy {columns} --margin 1"),
            3,
            "is too small for --own-pdf",
        ),
    ] {
        assert_output(&folder, &options, code, hint);
    }
}
