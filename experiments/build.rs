//! Records the commit that the programs are built from, or `unknown` outside a repository.

use std::process::Command;

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

fn main() {
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).map(|commit| {
        let changed = git(&["status", "--porcelain", "--untracked-files=no"]);
        if changed.is_some_and(|files| files.is_empty()) {
            commit
        } else {
            format!("{commit}+changes")
        }
    });
    println!(
        "cargo::rustc-env=WHITEFURNACE_COMMIT={}",
        commit.as_deref().unwrap_or("unknown")
    );
    for path in ["../.git/logs/HEAD", "../src", "src", "../Cargo.lock"] {
        println!("cargo::rerun-if-changed={path}");
    }
}
