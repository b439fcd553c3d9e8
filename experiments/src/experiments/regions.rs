//! Regions of the published figure 6, as measured on the image, against our three conventions.

use whitefurnace::integrator::{Published, Quirks};

use crate::experiments::figures::CONVENTIONS;
use crate::experiments::prelude::*;
use crate::plot::differences::{Panel, PanelSettings, differences};

pub(super) const REGIONS: Experiment = Experiment {
    id: "regions",
    title: "region means of the published figure 6 (8-bit R G B) against the three conventions",
    headline: "regions that match the published figure 6: {published.within %d} of 9 by the convention published, {report.within %d} as written, {physical.within %d} under physical rules",
    version: 1,
    equations: &[&equation::RENDERING, &equation::ROULETTE],
    run,
};

/// A rectangle of figure 6 and its published mean.
struct Region {
    name: &'static str,
    window: Window,
    published: [f64; 3],
    /// Margin of the `published` convention, in grey levels.
    margin: f64,
}

const fn region(
    name: &'static str,
    [x0, y0, x1, y1]: [u32; 4],
    published: [f64; 3],
    margin: f64,
) -> Region {
    Region {
        name,
        window: Window {
            corner: [x0, y0],
            size: [x1 - x0, y1 - y0],
        },
        published,
        margin,
    }
}

/// Margin on the white sphere, whose reconstruction is coarser than the rest.
const SPHERE: f64 = 6.0;
const OTHER: f64 = 2.5;

const TABLE: [Region; 9] = [
    region("red wall", [80, 300, 180, 400], [144.0, 36.5, 37.4], OTHER),
    region("blue wall", [350, 280, 430, 380], [23.3, 29.0, 76.8], OTHER),
    region(
        "cyan, near",
        [880, 250, 980, 350],
        [0.0, 150.5, 155.1],
        OTHER,
    ),
    region(
        "floor, mid",
        [600, 690, 660, 740],
        [142.9, 149.9, 164.8],
        OTHER,
    ),
    region(
        "sphere top",
        [560, 335, 590, 355],
        [239.2, 245.6, 248.7],
        SPHERE,
    ),
    region(
        "sphere middle",
        [560, 375, 590, 395],
        [126.6, 129.1, 141.9],
        SPHERE,
    ),
    region(
        "sphere bottom",
        [560, 420, 590, 438],
        [65.4, 61.3, 67.7],
        SPHERE,
    ),
    region(
        "sphere right",
        [612, 375, 626, 395],
        [41.1, 73.6, 73.7],
        SPHERE,
    ),
    region(
        "light in glass",
        [483, 468, 497, 476],
        [111.2, 109.2, 110.8],
        OTHER,
    ),
];

pub(super) const QUIRKS: Experiment = Experiment {
    id: "quirks",
    title: "the published convention with one quirk left out at a time, by region (8-bit R G B)",
    headline: "what an oddity of the published image does, in grey levels: extra cosine {single-cosine.most %.0f}, cosine as random number {own-number.most %.0f}, lost direct light {direct-kept.most %.0f}",
    version: 1,
    equations: &[&equation::ROULETTE, &equation::OREN_NAYAR],
    run: quirks,
};

fn quirks(run: &mut Run) -> Result<(), Error> {
    let all = Quirks::default();
    let [mut own_number, mut direct_kept, mut single_cosine] = [all; 3];
    own_number.roulette_by_cosine = false;
    direct_kept.end_loses_direct = false;
    single_cosine.extra_cosine = false;
    let variants = [
        (
            "without the cosine as roulette number",
            "own-number",
            own_number,
        ),
        (
            "without the loss of direct light",
            "direct-kept",
            direct_kept,
        ),
        ("without the extra cosine", "single-cosine", single_cosine),
    ];
    let with_all = TABLE
        .iter()
        .map(|region| quirked_mean(run, region, all))
        .collect::<Result<Vec<_>, _>>()?;
    let mut panels = Vec::new();
    for (title, stem, quirks) in variants {
        let mut panel = Vec::new();
        for (region, with) in TABLE.iter().zip(&with_all) {
            let without = quirked_mean(run, region, quirks)?;
            let change = [0, 1, 2].map(|c| without[c] - with[c]);
            record(run, stem, region, change);
            let value = format!("{:+.1} {:+.1} {:+.1}", change[0], change[1], change[2]);
            run.note(&format!("{title}: {}", region.name), value);
            panel.push(change);
        }
        let most = panel
            .iter()
            .flatten()
            .fold(0.0f64, |most, change| most.max(change.abs()));
        run.number(&format!("{stem}.most"), most);
        panels.push((title, panel));
    }
    let title = "What each quirk of the published convention does to the regions";
    let description = "The cosine as roulette number moves every region a little, the loss of direct light next to none, \
         the extra cosine the white sphere by up to a hundred grey levels.";
    let band = "what the comparison with the published image allows";
    let labels = ["change (grey levels)", band];
    draw(run, "quirks.svg", title, description, labels, &panels)
}

/// Returns the [`region_mean`] of the reconstruction with these quirks. All variants use the same
/// random numbers, so that a difference shows the quirk and little noise.
fn quirked_mean(run: &Run, region: &Region, quirks: Quirks) -> Result<[f64; 3], Error> {
    let job = region_job(run, ConventionName::Published, region, run.by_tier(16, 512));
    let film = job
        .render_by(Published { quirks }, region.name)?
        .into_complete()?;
    Ok(Display::Truncated.encoded_mean(&film))
}

fn run(run: &mut Run) -> Result<(), Error> {
    let mut panels = Vec::new();
    for (convention, stem) in CONVENTIONS {
        let mut panel = Vec::new();
        for region in &TABLE {
            let mean = region_mean(run, convention, region)?;
            let difference = [0, 1, 2].map(|c| mean[c] - region.published[c]);
            let worst = difference
                .iter()
                .fold(0.0f64, |worst, d| worst.max(d.abs()));
            let what = format!("{stem}: {}", region.name);
            let value = format!(
                "{} (published {}), at most {worst:.1} off",
                triple(mean),
                triple(region.published)
            );
            if convention == ConventionName::Published {
                run.claim(
                    &what,
                    format!("{value} of {} allowed", region.margin),
                    worst <= region.margin,
                );
            } else {
                run.note(&what, value);
            }
            record(run, stem, region, mean);
            panel.push(difference);
        }
        let within = panel
            .iter()
            .zip(&TABLE)
            .filter(|(off, region)| off.iter().all(|d| d.abs() <= region.margin));
        run.number(&format!("{stem}.within"), within.count() as f64);
        panels.push((stem, panel));
    }
    let title = "Regions of figure 6 under three conventions, against the published image";
    let description = "Under the convention named published all points lie within the bands; under the others many do not.";
    let axis = "rendered − published (grey levels)";
    let labels = [axis, "what is allowed of “published”"];
    draw(run, "regions.svg", title, description, labels, &panels)
}

/// Records a number for each channel of a region.
fn record(run: &mut Run, stem: &str, region: &Region, values: [f64; 3]) {
    for (channel, value) in ["r", "g", "b"].into_iter().zip(values) {
        let name = region.name.replace([' ', ','], "");
        run.number(&format!("{stem}.{name}.{channel}"), value);
    }
}

/// Draws all panels on one scale, with each region's margin.
fn draw(
    run: &mut Run,
    file: &str,
    title: &str,
    description: &str,
    [axis, band]: [&str; 2],
    panels: &[Panel<'_>],
) -> Result<(), Error> {
    let regions = TABLE.map(|region| (region.name, region.margin));
    let settings = PanelSettings {
        regions: &regions,
        axis,
        band,
    };
    differences(&run.figure(file), title, description, &settings, panels)
}

fn triple([r, g, b]: [f64; 3]) -> String {
    format!("{r:.1} {g:.1} {b:.1}")
}

/// Returns the mean over the region of floor(255 · min(1, pixel mean)), as the published image was
/// measured.
fn region_mean(run: &Run, convention: ConventionName, region: &Region) -> Result<[f64; 3], Error> {
    // Large regions need fewer samples; the small ones on the sphere are bright, and noise is
    // clipped at 1.
    let [width, height] = region.window.size;
    let quick = if width * height > 2_000 { 32 } else { 128 };
    let job = region_job(run, convention, region, run.by_tier(quick, 512));
    Ok(Display::Truncated.encoded_mean(&run.render(&job, region.name)?))
}

fn region_job(run: &Run, convention: ConventionName, region: &Region, spp: u32) -> Job {
    run.with_run_options(Job {
        window: Some(region.window),
        spp,
        ..Job::report(convention)
    })
}
