//! Tests of rendering: the same bytes on any number of threads, and every scene with every
//! estimator.

use clap::ValueEnum as _;
use experiments::render::photons::{Gather, Photons};
use experiments::render::{EstimatorName, Job, LightSamplingName, SceneName};

use rayon::ThreadPoolBuilder;
use whitefurnace::image::write_exr;

use crate::{folder, job};

#[test]
fn same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let cases = [
        "--convention physical --pixel random --spp 5",
        "--convention report --pixel jitter --grid 2 --spp 8",
        "--convention published --pixel grid --grid 3 --spp 9",
        "--estimator whitted --pixel centre --spp 3",
        "--scene diffuse-room --spp 3",
        "--scene cornell --light-sampler solid-angle --heuristic power --spp 3",
        "--diffuse eon --sampler sobol --scrambles 2 --spp 8",
        "--estimator photon --photons 3000 --radius 0.5 --spp 3",
        "--estimator photon --photons 3000 --gather no --sampler sobol --spp 16",
        "--estimator sppm --photons 3000 --radius 0.5 --spp 3",
        "--estimator sppm --photons 3000 --radius 0.5 --sampler sobol --scrambles 2 --spp 4",
        "--estimator light-tracer --spp 3",
        "--estimator light-tracer --sampler sobol --spp 8",
        "--estimator bdpt --sampler sobol --scrambles 2 --spp 4",
        "--estimator bdpt --spp 2",
        "--scene diffuse-room --estimator radiosity --patches 60 --spp 2",
    ];
    let path = folder("threads").join("a.exr");
    for case in cases {
        let bytes = |threads, seed| {
            let job = job(&format!("render {case} --size 40x30 --seed {seed}"));
            let pool = ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads");
            let rendered = pool.install(|| job.render("")).expect("a film");
            let camera = job.camera().expect("a scene");
            write_exr(
                &path,
                &rendered.film,
                &camera,
                &job.provenance(&camera, true),
            )
            .expect("written");
            std::fs::read(&path).expect("the EXR is there")
        };
        let one = bytes(1, 1);
        assert!(
            one == bytes(2, 1) && one == bytes(16, 1),
            "{case}: threads changed the bytes"
        );
        assert!(one != bytes(2, 2), "{case}: the seed changed nothing");
    }
}

/// The estimators that handle a scene are listed anew here; all others are refused. All have the
/// same albedo, normal and depth, to the last bit.
#[test]
fn every_scene_renders_with_every_legal_estimator() {
    use EstimatorName::{LightTracer, Photon, Radiosity, Sppm};
    use LightSamplingName::{Area, SolidAngle};
    use SceneName::{CavityCap, Cornell, DiffuseRoom, Environment, FurnaceBox, GlassCube};
    for &scene in SceneName::value_variants() {
        let is_legal = |estimator| match estimator {
            LightTracer | Photon | Sppm => ![Environment, GlassCube].contains(&scene),
            Radiosity => [CavityCap, Cornell, DiffuseRoom, FurnaceBox].contains(&scene),
            _ => true,
        };
        let mut features = None;
        for &estimator in EstimatorName::value_variants() {
            for (gather, light_sampler) in [(Gather::Yes, Area), (Gather::No, SolidAngle)] {
                let job = Job {
                    scene: scene.into(),
                    estimator,
                    light_sampler,
                    photons: Photons {
                        photons: 2000,
                        gather,
                        ..Photons::DEFAULT
                    },
                    patches: 60,
                    size: [8, 6],
                    spp: 2,
                    ..Job::default()
                };
                let made = job.render("");
                assert_eq!(
                    made.is_ok(),
                    is_legal(estimator),
                    "{scene:?}, {estimator:?}: {:?}",
                    made.as_ref().err()
                );
                let Ok(made) = made else { continue };
                let shown = made
                    .film
                    .pixels()
                    .iter()
                    .map(|pixel| format!("{:?}", pixel.features()));
                let shown: Vec<String> = shown.collect();
                assert_eq!(
                    features.get_or_insert_with(|| shown.clone()),
                    &shown,
                    "{scene:?}, {estimator:?}"
                );
            }
        }
    }
}
