//! Figures 6 to 9 of the report.

use crate::experiments::prelude::*;
use crate::render::{AdaptiveName, SamplerName, SilhouettesName};

pub(super) const FIG6: Experiment = Experiment {
    id: "fig6",
    title: "the final scene under the three conventions",
    headline: "three readings of the report: mean radiance {physical.mean %.3f} under physical rules, {report.mean %.3f} as written, {published.mean %.3f} as published",
    version: 2,
    equations: &[&equation::RENDERING, &equation::ESTIMATOR],
    run: |run| {
        for (convention, stem) in CONVENTIONS {
            let (size, spp) = run.by_tier(([400, 300], 16), ([1024, 768], 512));
            let job = Job {
                size,
                spp,
                ..Job::report(convention)
            };
            let job = match convention {
                // Not the report's image, hence not its number of samples, but little noise.
                ConventionName::Physical => Job {
                    spp: run.by_tier(24, 2048),
                    sampler: SamplerName::Sobol,
                    silhouettes: SilhouettesName::Yes,
                    adaptive: AdaptiveName::Yes,
                    ..job
                },
                ConventionName::Report | ConventionName::Published => job,
            };
            run.picture(job, stem)?;
        }
        Ok(())
    },
};

pub(super) const FIG7A: Experiment = Experiment {
    id: "fig7a",
    title: "the mirror sphere, a crop of figure 6",
    headline: "the mirror sphere, noise of a pixel {crop.relative_error %.0%}",
    version: 1,
    equations: &[&equation::WHITTED],
    run: |run| crop(run, [590, 370], [260, 240]),
};

pub(super) const FIG7B: Experiment = Experiment {
    id: "fig7b",
    title: "the glass sphere, a crop of figure 6",
    headline: "the glass sphere, noise of a pixel {crop.relative_error %.0%}",
    version: 1,
    equations: &[&equation::FRESNEL, &equation::REFRACTION],
    run: |run| crop(run, [350, 420], [270, 270]),
};

pub(super) const FIG8: Experiment = Experiment {
    id: "fig8",
    title: "colour bleeding on the white sphere, a crop of figure 6",
    headline: "colour bleeding on the white sphere, noise of a pixel {crop.relative_error %.0%}",
    version: 1,
    equations: &[&equation::OREN_NAYAR, &equation::RENDERING],
    run: |run| crop(run, WHITE_SPHERE.corner, WHITE_SPHERE.size),
};

/// Window of the white sphere in figure 6.
pub const WHITE_SPHERE: Window = Window {
    corner: [490, 300],
    size: [170, 170],
};

pub(super) const FIG9: Experiment = Experiment {
    id: "fig9",
    title: "noise at 64 samples per pixel",
    headline: "grain at 64 samples per pixel: noise of a pixel {noise.relative_error %.0%}",
    version: 1,
    equations: &[&equation::ESTIMATOR],
    run: |run| {
        let size = run.by_tier([256, 256], [512, 512]);
        run.picture(
            Job {
                size,
                spp: 64,
                ..Job::report(ConventionName::Report)
            },
            "noise",
        )
    },
};

pub(super) const ROOM: Experiment = Experiment {
    id: "room",
    title: "the report's room, small and clean",
    headline: "the report's room: mean radiance {room.mean %.3f}, noise of a pixel {room.relative_error %.0%}",
    version: 1,
    equations: &[&equation::RENDERING],
    run: |run| {
        let spp = run.by_tier(64, 512);
        run.picture(
            Job {
                size: [400, 300],
                spp,
                ..Job::report(ConventionName::Report)
            },
            "room",
        )?;
        run.copy_to_run_folder("room.png")
    },
};

/// Conventions, with the names of their pictures.
pub const CONVENTIONS: [(ConventionName, &str); 3] = [
    (ConventionName::Physical, "physical"),
    (ConventionName::Report, "report"),
    (ConventionName::Published, "published"),
];

/// Renders a window of figure 6 under the report's convention, bit for bit equal to that part of
/// the whole figure.
fn crop(run: &mut Run, corner: [u32; 2], size: [u32; 2]) -> Result<(), Error> {
    let spp = run.by_tier(64, 512);
    let window = Some(Window { corner, size });
    run.picture(
        Job {
            window,
            spp,
            ..Job::report(ConventionName::Report)
        },
        "crop",
    )
}
