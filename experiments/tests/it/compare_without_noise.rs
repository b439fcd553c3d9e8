//! Tests of `compare` on images without noise.

use crate::compare::{assert_case, assert_output};
use crate::compare_files::{exr, noisy};
use crate::{folder, renders};

/// Images without noise are compared exactly; copies of noisy ones are refused.
#[test]
fn images_without_noise_are_compared_as_they_stand() {
    let folder = folder("compare-noiseless");
    let scene = "background = 1\ncamera = { eye = [0, -4, 0], target = [0, 0, 0], up = [0, 0, 1], fov_deg = 40 }\n\
                 materials.ball = { model = \"lambert\", albedo = 1 }\n\
                 objects = [{ shape = \"sphere\", material = \"ball\", centre = [0, 0, 0], radius = 1 }]\n";
    std::fs::write(folder.join("furnace.toml"), scene).expect("written");
    std::fs::write(
        folder.join("darker.toml"),
        scene.replace("background = 1", "background = 0.99"),
    )
    .expect("written");
    for (name, scene, seed) in [
        ("f-1", "furnace", 1),
        ("f-2", "furnace", 2),
        ("g-1", "furnace", 3),
        ("g-2", "furnace", 4),
        ("d-1", "darker", 5),
        ("d-2", "darker", 6),
    ] {
        renders(
            &folder,
            &format!("--scene {scene}.toml --size 16x12 --spp 8 --seed {seed} --out {name}.exr"),
        );
    }
    let agree = "AGREE: neither side has noise, and no value differs by more than rounding";
    let differ =
        "DIFFER: the image mean in red is −1.00 % off the second's (and neither side has noise)";
    for (options, code, line) in [
        ("--a f-1.exr --b g-1.exr", 0, agree),
        ("--a f-*.exr --b g-*.exr", 0, agree),
        ("--a f-*.exr --reference g-1.exr", 0, agree),
        ("--a f-1.exr --b g-*.exr", 0, agree),
        ("--a d-1.exr --b g-1.exr", 1, differ),
        ("--a d-*.exr --b g-*.exr", 1, differ),
        ("--a d-1.exr --reference g-1.exr", 1, differ),
    ] {
        assert_output(&folder, options, code, line);
    }
    // Also without standard errors.
    let plain = |name: &str, value: f32| {
        let bytes = [
            &b"PF\n16 16\n-1\n"[..],
            &value.to_le_bytes().repeat(3 * 256),
        ]
        .concat();
        std::fs::write(folder.join(format!("{name}.pfm")), bytes).expect("written");
    };
    for (name, value) in [
        ("one", 1.0),
        ("other", 1.0),
        ("dark", 0.99),
        ("black", 0.0),
        ("night", 0.0),
    ] {
        plain(name, value);
    }
    assert_output(&folder, "--a dark.pfm --b one.pfm other.pfm", 1, differ);
    assert_output(&folder, "--a dark.pfm --reference one.pfm", 1, differ);
    for case in [
        "0 --a one.pfm --b other.pfm => \nnote: one.pfm and other.pfm have the same bytes: renders without noise, or one a copy",
        "1 --a dark.pfm --reference one.pfm => \nhint: they agree when the first is multiplied by 1.01010\n",
        "1 --a black.pfm night.pfm --b one.pfm other.pfm => DIFFER: the image mean in red is −100.0 % off",
        "0 --a black.pfm --b night.pfm => differs by more than rounding: all are black",
    ] {
        assert_case(&folder, case);
    }
    // One channel without noise next to two with noise.
    let half = |name: &str, seed: u32, red: f32| {
        let plane: Vec<f32> = (0..256).map(|i| noisy(i % 16, i / 16, seed)).collect();
        exr(
            &folder.join(name),
            [0, 0],
            16,
            &[("R", &[red; 256]), ("G", &plane), ("B", &plane)],
        );
    };
    for seed in 0..4 {
        half(&format!("half-{seed}.exr"), seed, 1.0);
        half(&format!("alike-{seed}.exr"), seed + 10, 1.0);
        half(&format!("off-{seed}.exr"), seed + 20, 0.998);
    }
    for case in [
        "0 --a half-*.exr --b alike-*.exr => AGREE: nothing that could be judged differs",
        "1 --a off-*.exr --b alike-*.exr => DIFFER: the image mean in red is −0.200 % off",
    ] {
        assert_case(&folder, case);
    }
    // A seed used twice: with other bytes, on one side or both.
    let plane: Vec<f32> = (0..256).map(|i| noisy(i % 16, i / 16, 1)).collect();
    let channels = [
        ("R", &[1.0; 256][..]),
        ("G", &plane),
        ("B", &plane),
        ("A", &[1.0; 256]),
    ];
    exr(&folder.join("again.exr"), [0, 0], 16, &channels);
    for case in [
        "3 --a half-*.exr again.exr --b alike-*.exr => half-1.exr and again.exr have the same pixels, a seed used twice",
        "3 --a half-*.exr --b alike-*.exr again.exr => half-1.exr and again.exr have the same pixels, a seed used twice",
    ] {
        assert_case(&folder, case);
    }
    // Rare events: all is black except one pixel of one image.
    let rare = |name: &str, at: Option<usize>| {
        let mut plane = [0.0_f32; 256];
        at.into_iter().for_each(|at| plane[at] = 300.0);
        exr(
            &folder.join(name),
            [0, 0],
            16,
            &[("R", &plane), ("G", &plane), ("B", &plane)],
        );
    };
    for (i, at) in [None, None, Some(77), None].into_iter().enumerate() {
        rare(&format!("rare-{i}.exr"), at);
        rare(&format!("none-{i}.exr"), None);
    }
    assert_output(&folder, "--a rare-*.exr --b none-*.exr", 2, "UNDECIDED");
    rare("rare-4.exr", Some(77));
    assert_case(
        &folder,
        "3 --a rare-*.exr --b none-*.exr => rare-2.exr and rare-4.exr have the same bytes, one is a copy",
    );
}
