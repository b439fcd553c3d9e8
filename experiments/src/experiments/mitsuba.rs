//! Comparison with another renderer's images of our scenes and its speed, and with a ray tracer's.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::embree;
use crate::experiments::prelude::*;

pub(super) const MITSUBA: Experiment = Experiment {
    id: "mitsuba",
    title: "our images and their cost beside Mitsuba 3's, our rays beside Embree's, from records",
    headline: "from records: images agree with Mitsuba 3's in {scenes.agree %d} of {scenes.right %d} scenes; with wrong albedos {scenes.differ %d} of {scenes.wrong %d} differ",
    version: 6,
    equations: &[&equation::RENDERING],
    run,
};

/// Record of `experiments/mitsuba/compare.py`; not computed by this run.
#[derive(Deserialize)]
struct Record {
    renderer: String,
    scenes: Vec<Compared>,
}

#[derive(Deserialize)]
struct Compared {
    scene: String,
    /// Factor on Mitsuba's diffuse albedos: 1, or another in a test that must detect it.
    albedos: f64,
    size: String,
    spp: u32,
    /// Number of images of each renderer.
    images: u32,
    verdict: String,
    /// Relative difference of our image mean from Mitsuba's by channel, and its confidence
    /// interval.
    means: BTreeMap<String, [f64; 3]>,
}

/// Record of `experiments/mitsuba/efficiency.py`; not measured by this run.
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
    images(run)?;
    efficiency(run)?;
    embree::rays(run)
}

fn read<T: for<'a> Deserialize<'a>>(name: &str, text: &str) -> Result<T, Error> {
    serde_json::from_str(text)
        .map_err(|error| Error::Option(format!("{name} cannot be read: {error}")))
}

fn efficiency(run: &mut Run) -> Result<(), Error> {
    let record: Efficiencies = read("efficiency.json", include_str!("efficiency.json"))?;
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

fn images(run: &mut Run) -> Result<(), Error> {
    let record: Record = read("mitsuba.json", include_str!("mitsuba.json"))?;
    run.note("renderer", record.renderer);
    let (mut right, mut agree, mut wrong, mut differ) = (0.0, 0.0, 0.0, 0.0);
    for Compared {
        scene,
        albedos,
        size,
        spp,
        images,
        verdict,
        means,
    } in record.scenes
    {
        let (key, what) = if albedos == 1.0 {
            right += 1.0;
            agree += f64::from(verdict == "agree");
            (scene.clone(), scene)
        } else {
            wrong += 1.0;
            differ += f64::from(verdict == "differ");
            (
                format!("off.{scene}"),
                format!("{scene}, albedos × {albedos} in Mitsuba"),
            )
        };
        let mut values = Vec::new();
        for (channel, [difference, low, high]) in means {
            run.numbers(
                &format!("{key}.{channel}"),
                [("difference", difference), ("low", low), ("high", high)],
            );
            values.push(format!("{channel} {:+.3} %", 100.0 * difference));
        }
        run.note(
            &what,
            format!(
                "{verdict}: {}; {images} images each, {size}, {spp} spp",
                values.join(", ")
            ),
        );
    }
    run.numbers(
        "scenes",
        [
            ("right", right),
            ("agree", agree),
            ("wrong", wrong),
            ("differ", differ),
        ],
    );
    Ok(())
}
