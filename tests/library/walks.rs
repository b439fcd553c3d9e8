//! Tests of walks and camera rays in lanes, against scalar functions.

use whitefurnace::film::splat::Splats;
use whitefurnace::integrator::Connections;
use whitefurnace::material::rough_glass::RoughGlass;

use crate::lanes::scenes::scenes;
use crate::prelude::*;

const FRAME: [u32; 2] = [29, 23];

/// Returns every number that walks with these parts make.
fn made(parts: Parts<'_>, scene: &Scene, pass: ImagePass) -> Vec<(String, Vec<DVec3>)> {
    let image = |name: &str, image: Result<Vec<DVec3>, Error>| {
        (name.to_owned(), image.expect("legal values"))
    };
    let ends = Bdpt {
        parts,
        connections: Connections::Endpoints,
    };
    let mut all = vec![
        image(
            "light tracer",
            LightTracer { parts }.image(scene, FRAME, pass),
        ),
        image("bdpt", Bdpt::new(parts).image(scene, FRAME, pass)),
        image("bdpt by ends", ends.image(scene, FRAME, pass)),
        image("sppm", sppm(parts, 700, 0.3).image(scene, FRAME, pass)),
    ];
    // More than a pilot has, and than a thread takes at once.
    for kept in [PhotonMapKind::All, PhotonMapKind::Caustic] {
        let map = PhotonMap::new(parts, scene, kept, 2500, pass).expect("a map");
        let photons = map
            .photons()
            .flat_map(|photon| [photon.normal, photon.from, photon.flux]);
        all.push((format!("photons, {kept:?}"), photons.collect()));
    }
    all
}

/// Returns a scene with a ball of rough glass.
fn rough_glass_ball() -> Scene {
    let mut s = SceneBuilder::new("frosted");
    let rough_glass = Bsdf::RoughGlass(RoughGlass {
        index: 1.5,
        alpha: 0.3,
    });
    square(&mut s, 0.5, 2.0, false, lamp(1.0));
    square(&mut s, 2.0, -1.0, true, diffuse(0.5));
    let sphere = Sphere::new(DVec3::ZERO, 0.6);
    ball(&mut s, sphere, Surface::new(rough_glass));
    s.build(Camera::new(
        DVec3::new(0.0, -3.0, 0.5),
        DVec3::ZERO,
        DVec3::Z,
        0.8,
    ))
    .expect("a legal scene")
}

#[test]
fn walks_have_the_same_bits() {
    let mut lit = 0;
    for scene in scenes().into_iter().chain([rough_glass_ball()]) {
        for (numbers, index) in [(SamplerKind::Independent, 3), (SamplerKind::Sobol(4), 6)] {
            let pass = ImagePass {
                sampler: numbers,
                seed: seed_for(master(), "walks"),
                index,
            };
            for (together, alone) in made(Parts::default(), &scene, pass).iter().zip(made(
                Parts::replaced(&ScalarParts),
                &scene,
                pass,
            )) {
                assert!(
                    *together == alone,
                    "{} by {}, {numbers:?}",
                    scene.name(),
                    alone.0
                );
                lit += usize::from(alone.1.iter().any(|value| value.max_element() > 0.0));
            }
        }
    }
    // Some scenes have no lights to start from, or no caustics.
    assert!(lit > 100, "{lit}");
}

/// Walks of one pixel do not depend on those that a thread traced before.
#[test]
fn bidirectional_images_are_those_of_each_pixel_alone() {
    let scene = report_room();
    let pass = ImagePass {
        sampler: SamplerKind::Sobol(4),
        seed: master(),
        index: 2,
    };
    for connections in [Connections::All, Connections::Endpoints] {
        let bdpt = Bdpt {
            parts: Parts::default(),
            connections,
        };
        let alone = Splats::new(FRAME);
        for pixel in 0..FRAME[0] * FRAME[1] {
            let place = [pixel % FRAME[0], pixel / FRAME[0]];
            bdpt.pair(&scene, place, FRAME, &alone, &mut pass.pixel_stream(pixel))
                .expect("legal values");
        }
        let image = on_threads(1, || bdpt.image(&scene, FRAME, pass)).expect("legal values");
        assert!(image == alone.into_values(), "{connections:?}");
    }
}

/// Features of passes have the bits of features rendered alone.
#[test]
fn features_have_the_same_bits() {
    for scene in scenes().into_iter().chain([rough_glass_ball()]) {
        let tracer = LightTracer::default();
        let together = passes(&scene, &tracer, FRAME, &[0..1, 1..3]).expect("legal values");
        let sampling = sampling(Random, SamplerKind::Independent, master());
        let whitted = Whitted::new(TransportRules::PHYSICAL);
        let alone = rendered(&scene, &whitted, FRAME, sampling, &[0..3]).expect("legal values");
        for (together, alone) in together.pixels().iter().zip(alone.pixels()) {
            let [together, alone] =
                [together, alone].map(|pixel| format!("{:?}", pixel.features()));
            assert_eq!(together, alone, "{}", scene.name());
        }
    }
}
