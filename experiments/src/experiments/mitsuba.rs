//! Speed beside another renderer and a ray tracer, from records.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::embree;
use crate::experiments::prelude::*;

pub(super) const MITSUBA: Experiment = Experiment {
    id: "mitsuba",
    title: "our efficiency beside Mitsuba 3's, our rays beside Embree's, from records",
    headline: "recorded efficiency {beside.report.efficiency.ratio %.1f} times Mitsuba 3's, {beside.knot.efficiency.ratio %.2f} with a mesh",
    version: 7,
    equations: &[&equation::RENDERING],
    run,
};

/// Record of `experiments/peers/efficiency.py`; not measured by this run.
#[derive(Deserialize)]
struct Efficiencies {
    renderer: String,
    threads: u32,
    scenes: Vec<Measured>,
}

#[derive(Deserialize)]
struct Measured {
    scene: String,
    /// Number of images of each method.
    images: u32,
    methods: BTreeMap<String, Method>,
}

#[derive(Deserialize)]
struct Method {
    /// Millions of camera samples per second, on all threads.
    rate: f64,
    /// One over the product of a pixel's variance, relative to the squared mean of the image, and
    /// the CPU microseconds per pixel.
    efficiency: f64,
}

fn run(run: &mut Run) -> Result<(), Error> {
    efficiency(run)?;
    embree::rays(run)
}

fn efficiency(run: &mut Run) -> Result<(), Error> {
    let record: Efficiencies = recorded("efficiency.json", include_str!("efficiency.json"))?;
    run.note(
        "beside",
        format!("{}, {} threads", record.renderer, record.threads),
    );
    for Measured {
        scene,
        images,
        methods,
    } in record.scenes
    {
        // Best of a renderer's methods, by each measure. Mitsuba's images have no error bars.
        let best = |names: &[&str], of: fn(&Method) -> f64| {
            let named = methods
                .iter()
                .filter(|(name, _)| names.contains(&name.as_str()));
            named.map(|(_, method)| of(method)).fold(0.0, f64::max)
        };
        let [ours, theirs, bare, plain, single, single_bare, single_plain] = [
            &["default", "independent"][..],
            &["mitsuba-multijitter", "mitsuba-independent"],
            &["one-scramble"],
            &["plain"],
            &["single-default", "single-independent"],
            &["single-one-scramble"],
            &["single-plain"],
        ]
        .map(|names| (best(names, |m| m.rate), best(names, |m| m.efficiency)));
        let ratios = [ours.0 / theirs.0, ours.1 / theirs.1];
        // Scenes that are refused in single precision have no such methods.
        let has_single = single.0 > 0.0;
        if has_single {
            run.numbers(
                &format!("beside.{scene}.single"),
                [
                    ("rate", single.0),
                    ("rate-ratio", single.0 / theirs.0),
                    ("efficiency", single.1),
                    ("ratio", single.1 / theirs.1),
                    ("bare", single_bare.1 / theirs.1),
                ],
            );
        }
        let single_rate = has_single.then_some(("single-rate", single_plain.0 / theirs.0));
        run.numbers(
            &format!("beside.{scene}.plain"),
            [("rate", plain.0 / theirs.0)]
                .into_iter()
                .chain(single_rate),
        );
        run.numbers(
            &format!("beside.{scene}.rate"),
            [("ours", ours.0), ("theirs", theirs.0), ("ratio", ratios[0])],
        );
        run.numbers(
            &format!("beside.{scene}.efficiency"),
            [
                ("ours", ours.1),
                ("theirs", theirs.1),
                ("ratio", ratios[1]),
                ("bare", bare.1 / theirs.1),
            ],
        );
        let in_single = |text: String| if has_single { text } else { String::new() };
        let value = format!(
            "{:.2} times the samples, {:.2} times the efficiency{}; by the same method {:.2} times the samples{}; \
                 {images} images each",
            ratios[0],
            ratios[1],
            in_single(format!(
                "; in single precision {:.2} and {:.2}",
                single.0 / theirs.0,
                single.1 / theirs.1
            )),
            plain.0 / theirs.0,
            in_single(format!(
                ", in single precision {:.2}",
                single_plain.0 / theirs.0
            )),
        );
        run.note(&format!("beside, {scene}"), value);
    }
    Ok(())
}
