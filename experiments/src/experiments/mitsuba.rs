//! Another renderer's images of our scenes.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::experiments::prelude::*;

pub(super) const MITSUBA: Experiment = Experiment {
    id: "mitsuba",
    title: "our images beside those of Mitsuba 3, from a record",
    version: 1,
    equations: &[&equation::RENDERING],
    run,
};

/// What `experiments/mitsuba/compare.py` found, and not this run.
#[derive(Deserialize)]
struct Record {
    renderer: String,
    scenes: Vec<Compared>,
}

#[derive(Deserialize)]
struct Compared {
    scene: String,
    /// What Mitsuba's diffuse albedos are multiplied by: 1, or something else that must be noticed.
    albedos: f64,
    size: String,
    spp: u32,
    /// Of each renderer.
    images: u32,
    verdict: String,
    /// By channel: our image mean less Mitsuba's as a share of Mitsuba's, and the interval in which it lies.
    means: BTreeMap<String, [f64; 3]>,
}

fn run(run: &mut Run) -> Result<(), Error> {
    let record: Record = serde_json::from_str(include_str!("mitsuba.json"))
        .map_err(|error| Error::Option(format!("mitsuba.json cannot be read: {error}")))?;
    run.note("renderer", record.renderer);
    let (mut right, mut agree, mut wrong, mut differ) = (0.0, 0.0, 0.0, 0.0);
    for Compared { scene, albedos, size, spp, images, verdict, means } in record.scenes {
        let (key, what) = if albedos == 1.0 {
            right += 1.0;
            agree += f64::from(verdict == "agree");
            (scene.clone(), scene)
        } else {
            wrong += 1.0;
            differ += f64::from(verdict == "differ");
            (format!("off.{scene}"), format!("{scene}, albedos × {albedos} in Mitsuba"))
        };
        let mut values = Vec::new();
        for (channel, [difference, low, high]) in means {
            run.numbers(&format!("{key}.{channel}"), [("difference", difference), ("low", low), ("high", high)]);
            values.push(format!("{channel} {:+.3} %", 100.0 * difference));
        }
        run.note(&what, format!("{verdict}: {}; {images} images each, {size}, {spp} spp", values.join(", ")));
    }
    run.numbers("scenes", [("right", right), ("agree", agree), ("wrong", wrong), ("differ", differ)]);
    Ok(())
}
