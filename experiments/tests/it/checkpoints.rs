//! Tests of runs that were killed, that resume, or that are part of a whole: the bytes of an
//! uninterrupted run, or a refusal.

use std::path::Path;
use std::process::Output;
use std::time::{Duration, Instant};

use experiments::render::Job;

use crate::signals::{ENDLESS, Running, endless};
use crate::{folder, refused, refuses, render, renders, run, text};

fn bytes(folder: &Path, name: &str) -> [Vec<u8>; 2] {
    ["exr", "png"].map(|kind| std::fs::read(folder.join(format!("{name}.{kind}"))).expect("there"))
}

fn merge(folder: &Path, options: &str) -> Output {
    run(env!("CARGO_BIN_EXE_merge"), folder, options)
}

/// Counts the files in a folder.
fn count(folder: &Path) -> usize {
    std::fs::read_dir(folder).expect("the folder").count()
}

/// Kills the program with a signal that it cannot catch, after each file that it saves.
#[test]
fn what_was_killed_goes_on_to_the_same_bytes() {
    let folder = folder("killed");
    for options in [
        "--scene cornell --size 40x30 --silhouettes no",
        "--scene cornell --estimator bdpt --size 40x30",
    ] {
        // Enough samples for one to two seconds on any machine, and twice as long on one thread: it
        // saves each second.
        const SURELY_SAVED: Duration = Duration::from_secs(3);
        let takes = |spp: u64| {
            let start = Instant::now();
            renders(&folder, &format!("{options} --spp {spp} --out whole.exr"));
            start.elapsed()
        };
        let mut spp = 256;
        while takes(spp) < Duration::from_millis(200) {
            spp *= 2;
        }
        spp *= 5;
        takes(spp);
        let saved = folder.join("a.partial.exr");
        let (mut kills, mut threads) = (0_u32, 1);
        loop {
            let resumed = format!("{options} --spp {spp} --out a.exr --resume --threads {threads}");
            let start = Instant::now();
            let mut render = Running::render(&resumed, &folder);
            let before = std::fs::read(&saved).ok();
            while !render.has_ended() && (kills == 3 || std::fs::read(&saved).ok() == before) {
                std::thread::sleep(Duration::from_millis(5));
            }
            std::thread::sleep(Duration::from_millis(u64::from(kills) * 70));
            if render.has_ended() {
                assert_eq!(render.end(), Some(0), "{resumed}");
                if kills > 0 {
                    break;
                }
                // It was faster than when it was measured.
                assert!(
                    start.elapsed() < SURELY_SAVED,
                    "{options}: nothing was saved"
                );
                spp *= 2;
                takes(spp);
                continue;
            }
            render.signal("-KILL");
            assert_eq!(render.end(), None);
            (kills, threads) = (kills + 1, 3 - threads);
        }
        assert!(
            bytes(&folder, "a") == bytes(&folder, "whole"),
            "{options}: other bytes after {kills} kills"
        );
        // Nothing that was saved is left, not even temporary files.
        assert_eq!(count(&folder), 4, "{options}");
    }
}

#[test]
fn what_cannot_go_on_is_refused_and_stays() {
    let folder = folder("resumed");
    let saved = folder.join("a.partial.exr");
    let mut render_endless = endless(&folder, 1);
    render_endless.wait_for("% of");
    render_endless.signal("-TERM");
    assert_eq!(render_endless.end(), Some(143));
    let good = std::fs::read(&saved).expect("saved");
    let resume = |options: &str| render(&folder, &format!("{options} --resume"));
    let other = |from: &str, to: &str| ENDLESS.replace(from, to) + "1";
    for (options, hint) in [
        (other("64x48", "48x64"), "size=64x48 there, size=48x64 here"),
        (
            other("4000000000", "8"),
            "adaptive=yes, spp=4000000000 there, scrambles=4, adaptive=no, spp=8 here",
        ),
        (
            other("--out", "--seed 2 --out"),
            "seed=1 there, seed=2 here",
        ),
        (
            other("--out", "--estimator bsdf --out"),
            "heuristic=power, specular-nee=yes there, estimator=bsdf here",
        ),
        (
            other("--out", "--shard 1/2 --out"),
            "there, 0..2000000000 of 4000000000 here",
        ),
    ] {
        refused(&resume(&options), hint);
        assert!(
            std::fs::read(&saved).expect("there") == good,
            "{options} changed the file"
        );
    }
    for bytes in [&good[..good.len() / 2], b"no image"] {
        std::fs::write(&saved, bytes).expect("written");
        refused(&resume(&other("", "")), "truncated");
        assert!(std::fs::read(&saved).expect("there") == bytes);
    }
    renders(&folder, "--size 8x6 --spp 4 --out b.exr");
    std::fs::copy(folder.join("b.exr"), &saved).expect("copied");
    refused(&resume(&other("", "")), "no film with sums");

    // A limit on file sizes stands for a full disk: the error is reported, work continues, and the
    // earlier file stays.
    std::fs::write(&saved, &good).expect("written");
    let script = format!(
        "trap '' XFSZ; ulimit -f 8; exec {} {ENDLESS} 1 --resume",
        env!("CARGO_BIN_EXE_render")
    );
    let mut render = Running::start("sh", &["-c", &script], &folder);
    render.wait_for("warning: cannot write a.partial.exr");
    render.signal("-TERM");
    render.wait_for("error: cannot write a.partial.exr");
    assert_eq!(render.end(), Some(2));
    assert!(std::fs::read(&saved).expect("there") == good);
    assert_eq!(count(&folder), 4);
}

#[test]
fn shards_are_the_whole() {
    let folder = folder("shards");
    let all = "--scene cornell --size 12x9 --exposure 1";
    // Replications of several samples, of one, and of several passes.
    for (case, options) in [
        "--spp 14 --scrambles 7",
        "--sampler independent --spp 5",
        "--estimator bdpt --spp 8",
        "--spp 64",
    ]
    .into_iter()
    .enumerate()
    {
        let whole = format!("{all} {options} --out whole.exr");
        renders(&folder, &whole);
        for shard in 1..=3 {
            renders(
                &folder,
                &format!("{all} {options} --shard {shard}/3 --out p{shard}.exr"),
            );
        }
        let joined = merge(&folder, "--out joined.exr p2.exr p3.exr p1.exr");
        assert!(joined.status.success(), "{}", text(&joined.stderr));
        assert!(
            bytes(&folder, "joined") == bytes(&folder, "whole"),
            "{options}"
        );
        if case == 0 {
            renders(
                &folder,
                &format!("{all} {options} --seed 2 --shard 2/3 --out q2.exr"),
            );
            for case in [
                "--out x.exr p1.exr p3.exr => no part has the replications 2..4 of 7",
                "--out x.exr p2.exr p1.exr => no part has the replications 4..7 of 7",
                "--out x.exr p3.exr p1.exr p3.exr => p3.exr and p3.exr have the same",
                "--out x.exr p1.exr whole.exr => whole.exr: no film with sums",
                "--out x.png p1.exr => .exr",
                "--out x.exr p1.exr p9.exr => p9.exr",
                "--out x.exr p1.exr q2.exr p3.exr => q2.exr is of another image than p1.exr: seed=2",
            ] {
                refuses(case, |options| merge(&folder, options));
            }
        }
    }
    let mut render = Running::render(&format!("{ENDLESS} 1 --shard 1/2"), &folder);
    render.wait_for("% of");
    render.signal("-TERM");
    assert_eq!(render.end(), Some(143));
    refused(
        &merge(&folder, "--out x.exr a.partial.exr"),
        "a.partial.exr is not finished",
    );
    assert!(!folder.join("x.exr").exists());
}

/// If the pilot's samples were the image's own, stopping by them would bias it.
#[test]
fn a_pilot_has_samples_of_its_own() {
    let job = Job {
        seed: 7,
        spp: 512,
        ..Job::default()
    };
    let pilot = job.pilot(64);
    assert!(pilot.spp == 64 && pilot.seed != job.seed && pilot.size == job.size);
}

#[test]
fn a_pilot_decides_what_spp_would_say() {
    let folder = folder("pilot");
    for (aim, options) in [
        ("--target-error 5%", "--scene cornell --size 24x18"),
        ("--target-error 10%", "--scene cornell --size 24x18"),
        (
            "--target-error 5%",
            "--scene cornell --estimator light-tracer --sampler independent --size 24x18",
        ),
        (
            "--time 1s",
            "--convention report --pixel jitter --grid 3 --size 24x18",
        ),
    ] {
        let decided = render(&folder, &format!("{options} {aim} --out a.exr"));
        let said = text(&decided.stdout);
        let spp = said
            .split("--spp ")
            .nth(1)
            .and_then(|rest| rest.lines().next())
            .expect("a number");
        renders(&folder, &format!("{options} --spp {spp} --out b.exr"));
        assert!(
            bytes(&folder, "a") == bytes(&folder, "b"),
            "{options} {aim}: {said}"
        );
        // Higher precision needs more samples, and more time allows more.
        assert!(spp.parse::<u32>().expect("a number") > 4, "{said}");
    }
}
