//! Rays per second beside another ray tracer, from a record.

use serde::Deserialize;

use crate::experiments::prelude::*;

/// Record of `experiments/peers/rays.py`; not measured by this run.
#[derive(Deserialize)]
struct Record {
    tracer: String,
    meshes: Vec<Mesh>,
}

#[derive(Deserialize)]
struct Mesh {
    mesh: String,
    triangles: u32,
    /// Seconds.
    build: Pair,
    kinds: Vec<Kind>,
}

#[derive(Deserialize)]
struct Kind {
    name: String,
    /// Millions of rays per second on one thread.
    #[serde(flatten)]
    rate: Pair,
}

#[derive(Deserialize)]
struct Pair {
    ours: f64,
    theirs: f64,
}

/// Adds the ratios of rays per second and of build times to the run's numbers.
pub(super) fn rays(run: &mut Run) -> Result<(), Error> {
    let record: Record = recorded("embree.json", include_str!("embree.json"))?;
    run.note("embree", record.tracer);
    for Mesh {
        mesh,
        triangles,
        build,
        kinds,
    } in record.meshes
    {
        run.numbers(
            &format!("embree.{mesh}"),
            [
                ("triangles", f64::from(triangles)),
                ("build.ratio", build.ours / build.theirs),
            ],
        );
        run.numbers(
            &format!("embree.{mesh}.ratio"),
            kinds
                .iter()
                .map(|Kind { name, rate }| (name.as_str(), rate.ours / rate.theirs)),
        );
    }
    Ok(())
}
