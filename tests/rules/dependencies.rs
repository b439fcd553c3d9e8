//! Packages that `Cargo.lock` holds back: later versions compile more, which is no use here, and make
//! the first build longer for everyone.

use std::fs;
use std::path::Path;

/// A package that is held back.
struct HeldBack {
    name: &'static str,
    version: &'static str,
    /// Dependencies of later versions.
    spares: &'static str,
}

const HELD_BACK: [HeldBack; 7] = [
    HeldBack {
        name: "clap",
        version: "4.6.1",
        spares: "a second version of syn",
    },
    HeldBack {
        name: "exr",
        version: "1.74.0",
        spares: "pulp",
    },
    HeldBack {
        name: "flate2",
        version: "1.1.9",
        spares: "a second version of miniz_oxide",
    },
    HeldBack {
        name: "half",
        version: "2.4.1",
        spares: "zerocopy",
    },
    HeldBack {
        name: "pest",
        version: "2.9.2",
        spares: "a second version of syn, and psm, which needs a C compiler",
    },
    HeldBack {
        name: "serde",
        version: "1.0.228",
        spares: "a second version of syn",
    },
    HeldBack {
        name: "thiserror",
        version: "2.0.18",
        spares: "a second version of syn",
    },
];

#[test]
fn slow_versions_are_held_back() {
    let lock = Path::new(env!("CARGO_MANIFEST_DIR")).join("../Cargo.lock");
    let lock = fs::read_to_string(lock).expect("a lock file");
    for HeldBack {
        name,
        version,
        spares,
    } in HELD_BACK
    {
        let entry = format!("name = \"{name}\"\nversion = \"{version}\"\n");
        assert!(
            lock.contains(&entry),
            "`cargo update {name} --precise {version}` spares {spares}"
        );
    }
}
