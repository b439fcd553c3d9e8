//! The table of options and values, each with the change of the library's call that it stands for.

use glam::DVec3;
use whitefurnace::integrator::{Bdpt, Connections, LightTracer, Whitted};
use whitefurnace::material::OrenNayar;
use whitefurnace::material::ggx::Ggx;

use super::*;

fn white_sphere(call: &mut Call, bsdf: Bsdf) {
    call.scene = room::with_white_sphere(bsdf, room::Walls::default());
}

const EVERY_KEY: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../tests/library/data/scenes/every-key.toml"
);

const GREY: DVec3 = DVec3::splat(room::WHITE);

/// Returns the table: each option with its values.
pub(super) fn rows() -> Vec<Row> {
    let rows = [
        Row("scene", "report", PLAIN, |_| {}),
        Row("scene", "diffuse-room", PLAIN, |c| {
            c.scene = room::diffuse();
        }),
        Row("scene", "environment", PLAIN, |c| {
            c.scene = simple::environment();
        }),
        Row("scene", "furnace-box", PLAIN, |c| {
            c.scene = simple::furnace_box(0.75);
        }),
        Row("scene", "cavity-cap", PLAIN, |c| {
            c.scene = simple::cavity_cap(0.75, simple::Cap::Reflecting);
        }),
        Row("scene", "glass-cube", PLAIN, |c| {
            c.scene = simple::glass_cube(false);
        }),
        Row("scene", "cornell", PLAIN, |c| c.scene = simple::cornell()),
        Row("scene", EVERY_KEY, PLAIN, |c| c.scene = loaded(EVERY_KEY)),
        Row("convention", "physical", PLAIN, |_| {}),
        Row("convention", "report", PLAIN, |c| *c = REPORT.call()),
        Row("convention", "published", PLAIN, PUBLISHED.1),
        Row("estimator", "bsdf", PLAIN, |c| {
            c.film = |c| c.rays(path(Strategy::Bsdf));
        }),
        Row("estimator", "light", PLAIN, |c| {
            c.film = |c| c.rays(path(Strategy::Light));
        }),
        Row("estimator", "mis", PLAIN, |_| {}),
        Row("estimator", "light-tracer", CORNELL, |c| {
            c.film = |c| c.images(LightTracer::default());
        }),
        Row("estimator", "photon", SPPM, |c| {
            c.film = |c| c.photons([3000, 3000], [0.5, 0.5]);
        }),
        Row("estimator", "sppm", PHOTON, |c| {
            c.film = |c| c.sppm(3000, 0.5);
        }),
        Row("estimator", "bdpt", PLAIN, |c| {
            c.film = |c| c.images(Bdpt::new(Parts::default()));
        }),
        Row("estimator", "bdpt-ends", PLAIN, |c| {
            c.film = |c| {
                c.images(Bdpt {
                    parts: Parts::default(),
                    connections: Connections::Endpoints,
                })
            };
        }),
        // In the report's room it implies the report's convention.
        Row("estimator", "report", PLAIN, |c| *c = REPORT.call()),
        Row("estimator", "report", CORNELL, |c| {
            c.film = |c| c.report(1, TransportRules::PHYSICAL);
            c.sampler = SamplerKind::Independent;
        }),
        Row("estimator", "radiosity", RADIOSITY, |_| {}),
        Row("estimator", "whitted", PLAIN, |c| {
            c.film = |c| c.rays(Whitted::new(TransportRules::PHYSICAL));
        }),
        Row("estimator", "whitted", REPORT, |c| {
            c.film = |c| c.rays(Whitted::new(TransportRules::REPORT));
            c.sampler = SamplerKind::Sobol(1);
        }),
        Row("precision", "double", PLAIN, |_| {}),
        Row("precision", "single", PLAIN, |c| {
            c.film = |c| c.singles(LaneEstimator::Path(path(Strategy::Mis)));
        }),
        Row("light-sampler", "area", LIGHTS, AREA.1),
        Row("light-sampler", "solid-angle", LIGHTS, |c| {
            c.film = |c| c.paths(|path| path.lights = LightSampling::SolidAngle);
        }),
        Row("light-sampler", "sphere-angle", LIGHTS, |c| {
            c.film = |c| c.paths(|path| path.lights = LightSampling::SphereAngle);
        }),
        Row("light-sampler", "importance", LIGHTS, |_| {}),
        Row("scene", KNOT, PLAIN, |c| c.scene = loaded(KNOT)),
        Row("scene", KNOT, AREA, |c| c.scene = loaded(KNOT)),
        Row("heuristic", "balance", PLAIN, |c| {
            c.film = |c| c.paths(|path| path.heuristic = Heuristic::Balance);
        }),
        Row("heuristic", "power", PLAIN, |_| {}),
        Row("specular-nee", "yes", PLAIN, |_| {}),
        Row("specular-nee", "no", PLAIN, |c| {
            c.film = |c| c.paths(|path| path.specular_nee = false);
        }),
        Row("bounces", "2", PLAIN, |c| {
            c.film = |c| c.paths(|path| path.bounces = Some(2));
        }),
        Row("diffuse", "lambert", PLAIN, |c| {
            white_sphere(c, Bsdf::Lambert { albedo: GREY });
        }),
        Row("diffuse", "printed", PLAIN, |c| {
            c.scene = room::report(Convention::Physical, OrenNayarForm::Printed);
        }),
        Row("diffuse", "corrected", PLAIN, |_| {}),
        Row("diffuse", "eon", PLAIN, |c| {
            let roughness = OrenNayar::new(room::SIGMA).roughness();
            white_sphere(
                c,
                Bsdf::Eon {
                    albedo: GREY,
                    roughness,
                },
            );
        }),
        Row("diffuse", "ggx", PLAIN, |c| {
            white_sphere(
                c,
                Bsdf::model(Ggx {
                    reflectance: GREY,
                    alpha: room::SIGMA,
                }),
            );
        }),
        Row("rays", "3", REPORT, |c| {
            c.film = |c| c.report(3, TransportRules::REPORT);
        }),
        Row("photons", "2000", SPPM, |c| c.film = |c| c.sppm(2000, 0.5)),
        Row("photons", "2000", PHOTON, |c| {
            c.film = |c| c.photons([2000, 2000], [0.5, 0.5]);
        }),
        Row("radius", "0.3", SPPM, |c| c.film = |c| c.sppm(3000, 0.3)),
        Row("radius", "0.3", PHOTON, |c| {
            c.film = |c| c.photons([3000, 3000], [0.3, 0.3]);
        }),
        Row("gather", "yes", PHOTON, |_| {}),
        Row("gather", "no", PHOTON, |c| {
            c.film = |c| c.looked_up(3000, 0.5, Lookup::DirectVisualization);
        }),
        Row("caustic-photons", "20000", PHOTON, |c| {
            c.film = |c| c.photons([3000, 20_000], [0.5, 0.5]);
        }),
        Row("caustic-radius", "0.2", PHOTON, |c| {
            c.film = |c| c.photons([3000, 3000], [0.5, 0.2]);
        }),
        Row("patches", "200", RADIOSITY, |c| {
            c.film = |c| c.radiosity(200);
        }),
        Row("silhouettes", "yes", DIM, |_| {}),
        Row("silhouettes", "no", DIM, |c| c.silhouettes = false),
        Row("adaptive", "yes", ADAPTIVE, |_| {}),
        Row("adaptive", "no", ADAPTIVE, |c| c.adaptive = false),
        Row("pixel", "centre", PLAIN, |c| {
            (c.pixel, c.silhouettes) = (PixelSampling::Centre, false);
        }),
        Row("pixel", "grid", PLAIN, |c| {
            divided(c, PixelSampling::Grid(4));
            c.silhouettes = false;
            c.spp = 16;
        }),
        Row("pixel", "random", PLAIN, |_| {}),
        Row("pixel", "jitter", PLAIN, |c| {
            divided(c, PixelSampling::Jitter(4));
            c.spp = 16;
        }),
        Row("grid", "1", JITTER, |c| c.pixel = PixelSampling::Jitter(1)),
        Row("sampler", "independent", PLAIN, |c| {
            c.sampler = SamplerKind::Independent;
        }),
        Row("sampler", "independent", PHOTON, |c| {
            c.sampler = SamplerKind::Independent;
        }),
        Row("sampler", "independent", SPPM, |c| {
            c.sampler = SamplerKind::Independent;
        }),
        Row("sampler", "sobol", PLAIN, |_| {}),
        Row("sampler", "sobol", REPORT, |c| {
            c.sampler = SamplerKind::Sobol(1);
        }),
        Row("scrambles", "2", PLAIN, |c| {
            c.sampler = SamplerKind::Sobol(2);
        }),
        Row("scrambles", "1", SPPM, |c| {
            c.sampler = SamplerKind::Sobol(4);
        }),
        Row("size", "20x10", PLAIN, |c| c.size = [20, 10]),
        Row("spp", "3", PLAIN, |c| c.spp = 3),
        // In four scrambles, five and seven.
        Row("spp", "16", PLAIN, |c| {
            (c.sampler, c.spp) = (SamplerKind::Sobol(4), 16);
        }),
        Row("spp", "21", PLAIN, |c| {
            (c.sampler, c.spp) = (SamplerKind::Sobol(3), 21);
        }),
        Row("spp", "28", PLAIN, |c| {
            (c.sampler, c.spp) = (SamplerKind::Sobol(7), 28);
        }),
        Row("spp", "32", PLAIN, |c| {
            (c.sampler, c.spp, c.adaptive) = (SamplerKind::Sobol(8), 32, true);
        }),
        Row("spp", "65", PLAIN, |c| {
            (c.sampler, c.spp, c.adaptive) = (SamplerKind::Sobol(13), 65, true);
        }),
        Row("spp", "10", PLAIN, |c| {
            (c.sampler, c.spp) = (SamplerKind::Sobol(2), 10);
        }),
        Row("spp", "7", PLAIN, |c| c.spp = 7),
        Row("seed", "18446744073709551615", PLAIN, |c| c.seed = u64::MAX),
        Row("threads", "3", PLAIN, |_| {}),
        // Its options are checked with the scene, which is built on all threads.
        Row("threads", "3", RADIOSITY, |_| {}),
        Row("exposure", "-1.5", PLAIN, |c| {
            c.display = Display::Srgb { exposure: -1.5 }
        }),
        Row("out", "other.exr", PLAIN, |_| {}),
    ];
    // The bases themselves, too.
    rows.into_iter()
        .chain(BASES.map(|base| Row("", "", base, |_| {})))
        .collect()
}
