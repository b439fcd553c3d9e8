//! Tests that every option of `render` changes what it states, and nothing else: the program writes
//! the bytes of the library's own call with the same settings, which are written anew here, and
//! another image than without the option.

mod rows;

use std::collections::BTreeSet;

use clap::CommandFactory as _;
use experiments::render::command::Render;
use whitefurnace::error::Error;
use whitefurnace::film::Film;
use whitefurnace::image::{Display, write_exr, write_png};
use whitefurnace::integrator::radiosity::MeshResolution;
use whitefurnace::integrator::{
    Estimator, Heuristic, ImageEstimator, Lookup, Parts, Path, PhotonMapping, Published, Radiosity,
    Report, Sppm, Strategy, TransportRules,
};
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::material::{Bsdf, OrenNayarForm};
use whitefurnace::render::adaptive::Pilot;
use whitefurnace::render::{
    ImageRenderer, LaneEstimator, LaneRenderer, Precision, RayRenderer, Renderer,
};
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::roulette::RR_DEPTH;
use whitefurnace::sampling::sampler::{ImagePass, SamplerKind};
use whitefurnace::scene::file::SceneFile;
use whitefurnace::scene::room::Convention;
use whitefurnace::scene::{Scene, room, simple};

use crate::{folder, job, renders};
use rows::rows;

/// A call of the library, with its settings.
struct Call {
    scene: Result<Scene, Error>,
    /// Renders with some estimator.
    film: fn(&Call) -> Result<Film, Error>,
    pixel: PixelSampling,
    sampler: SamplerKind,
    silhouettes: bool,
    adaptive: bool,
    size: [u32; 2],
    spp: u32,
    seed: u64,
    display: Display,
}

/// Path tracing with the defaults of the program.
fn path(strategy: Strategy) -> Path<'static> {
    let lights = LightSampling::Importance;
    Path {
        lights,
        heuristic: Heuristic::Power,
        rr_depth: RR_DEPTH,
        specular_nee: true,
        ..Path::new(strategy)
    }
}

/// Settings with which an option is tested: options of the program, and the same changes to a call.
#[derive(Clone, Copy)]
struct Base(&'static str, fn(&mut Call));

const PLAIN: Base = Base("", |_| {});
const PHOTON: Base = Base("--estimator photon --photons 3000 --radius 0.5", |c| {
    c.film = |c| c.photons([3000; 2], [0.5; 2]);
});
const SPPM: Base = Base("--estimator sppm --photons 3000 --radius 0.5", |c| {
    c.film = |c| c.sppm(3000, 0.5);
});
const REPORT: Base = Base("--convention report", |c| {
    c.silhouettes = false;
    c.film = |c| c.report(1, TransportRules::REPORT);
    c.sampler = SamplerKind::Independent;
    c.display = Display::Truncated;
});
const PUBLISHED: Base = Base("--convention published", |c| {
    c.silhouettes = false;
    c.scene = room::report(Convention::Published, OrenNayarForm::Corrected);
    c.film = |c| c.rays(Published::default());
    c.sampler = SamplerKind::Independent;
    c.display = Display::Truncated;
});
const CORNELL: Base = Base("--scene cornell", |c| c.scene = simple::cornell());
const JITTER: Base = Base("--pixel jitter --grid 2", |c| {
    divided(c, PixelSampling::Jitter(2));
});
/// So dark that lights are not clipped to white.
const DIM: Base = Base("--scene diffuse-room --exposure -8", |c| {
    (c.scene, c.display) = (room::diffuse(), Display::Srgb { exposure: -8.0 });
});
const RADIOSITY: Base = Base("--scene cornell --estimator radiosity --patches 60", |c| {
    c.scene = simple::cornell();
    c.film = |c| c.radiosity(60);
});
const AREA: Base = Base("--light-sampler area", |c| {
    c.film = |c| c.paths(|path| path.lights = LightSampling::Area);
});
const ADAPTIVE: Base = Base("--adaptive yes", |c| {
    (c.sampler, c.spp, c.adaptive) = (SamplerKind::Sobol(3), 12, true);
});
macro_rules! knot {
    () => {
        concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../tests/library/data/scenes/knot.toml"
        )
    };
}
const KNOT: &str = knot!();
/// Three lights, one of which is a sphere.
const LIGHTS: Base = Base(concat!("--scene ", knot!()), |c| c.scene = loaded(KNOT));
const BASES: [Base; 12] = [
    PLAIN, PHOTON, SPPM, REPORT, PUBLISHED, CORNELL, JITTER, DIM, RADIOSITY, AREA, LIGHTS, ADAPTIVE,
];

impl Base {
    fn call(self) -> Call {
        let mut call = Call {
            scene: room::report(Convention::Physical, OrenNayarForm::Corrected),
            film: |c| c.rays(path(Strategy::Mis)),
            pixel: PixelSampling::Random,
            // In four scrambles.
            sampler: SamplerKind::Sobol(1),
            silhouettes: true,
            adaptive: false,
            size: [16, 12],
            spp: 4,
            seed: 1,
            display: Display::Srgb { exposure: 0.0 },
        };
        self.1(&mut call);
        call
    }
}

impl Call {
    fn scene(&self) -> &Scene {
        self.scene.as_ref().expect("a scene")
    }

    fn sampling(&self) -> Sampling {
        Sampling {
            pixel: self.pixel,
            sampler: self.sampler,
            seed: self.seed,
            silhouettes: self.silhouettes,
        }
    }

    /// Photon mapping with these photons and radii: for all light, and for caustics.
    fn photons(&self, particles: [u32; 2], radii: [f64; 2]) -> Result<Film, Error> {
        let lookup = Lookup::FinalGather {
            caustic_particles: particles[1],
            caustic_radius: radii[1],
        };
        self.looked_up(particles[0], radii[0], lookup)
    }

    fn looked_up(&self, particles: u32, radius: f64, lookup: Lookup) -> Result<Film, Error> {
        let pass = ImagePass {
            sampler: self.sampler,
            seed: self.seed,
            index: 0,
        };
        self.rays(PhotonMapping::new(
            Parts::default(),
            self.scene(),
            lookup,
            particles,
            radius,
            pass,
        )?)
    }

    fn sppm(&self, particles: u32, radius: f64) -> Result<Film, Error> {
        self.images(Sppm {
            parts: Parts::default(),
            particles,
            radius,
        })
    }

    fn radiosity(&self, patches: u32) -> Result<Film, Error> {
        self.rays(Radiosity::new(
            Parts::default(),
            self.scene(),
            MeshResolution {
                patches,
                halvings: 0,
            },
            &|_| true,
        )?)
    }

    fn report(&self, rays: u32, rules: TransportRules) -> Result<Film, Error> {
        self.rays(Report {
            rays,
            rules,
            ..Report::default()
        })
    }

    /// Path tracing with a change of the defaults.
    fn paths(&self, change: fn(&mut Path)) -> Result<Film, Error> {
        let mut path = path(Strategy::Mis);
        change(&mut path);
        self.rays(path)
    }

    fn rays(&self, estimator: impl Estimator) -> Result<Film, Error> {
        let renderer = RayRenderer {
            estimator,
            sampling: self.sampling(),
        };
        if !self.adaptive {
            return self.rendered(&renderer);
        }
        let renderer = renderer.prepare(self.scene(), self.size)?;
        let each = self.sampler.samples();
        let (mut film, all) = (Film::new(self.size, None, each)?, self.spp / each);
        let pilot = Pilot::take(&*renderer, &film, all, &(0..all), &|_| true)?;
        let pilot = pilot.ok_or(Error::Interrupted)?;
        let counts = pilot.counts();
        pilot.begin(&mut film, counts)?;
        renderer.add(&mut film, 0..all, &|_| true)?;
        Ok(film)
    }

    fn singles(&self, estimator: LaneEstimator) -> Result<Film, Error> {
        self.rendered(&LaneRenderer {
            estimator,
            sampling: self.sampling(),
            precision: Precision::Single,
        })
    }

    fn images(&self, estimator: impl ImageEstimator) -> Result<Film, Error> {
        self.rendered(&ImageRenderer {
            estimator,
            sampler: self.sampler,
            seed: self.seed,
        })
    }

    fn rendered(&self, renderer: &dyn Renderer) -> Result<Film, Error> {
        let each = renderer.samples_per_replication();
        let mut film = Film::new(self.size, None, each)?;
        renderer.add(self.scene(), &mut film, 0..self.spp / each, &|_| true)?;
        Ok(film)
    }
}

/// An option with a value, the base that it is added to, and its change to the call.
struct Row(&'static str, &'static str, Base, fn(&mut Call));

/// Sets sub-pixels, which need independent numbers.
fn divided(call: &mut Call, pixel: PixelSampling) {
    (call.pixel, call.sampler) = (pixel, SamplerKind::Independent);
}

fn loaded(file: &str) -> Result<Scene, Error> {
    SceneFile::load(file.as_ref()).and_then(|file| file.description.build())
}

impl Row {
    /// Returns the words of the command line: an option of the row replaces that of its base.
    fn words(&self) -> Vec<String> {
        let Row(option, value, base, _) = self;
        let call = self.call();
        let (size, spp) = (
            format!("{}x{}", call.size[0], call.size[1]),
            call.spp.to_string(),
        );
        let rest = format!("--size {size} --spp {spp} --out a.exr {}", base.0);
        let rest: Vec<&str> = rest.split_whitespace().collect();
        let option = format!("--{option}");
        let mut words = vec![String::from("render")];
        for pair in rest.chunks(2).filter(|pair| pair[0] != option) {
            words.extend(pair.iter().map(|&word| word.to_owned()));
        }
        if option != "--" {
            words.extend([option, (*value).to_owned()]);
        }
        words
    }

    fn call(&self) -> Call {
        let mut call = self.2.call();
        (self.3)(&mut call);
        call
    }
}

#[test]
fn every_option_is_the_librarys_own_call() {
    let folder = folder("options");
    let read = |file: &str| std::fs::read(folder.join(file)).expect("a file");
    // Images of the bases, and of the rows.
    let mut bases = Vec::new();
    let mut pictures = Vec::new();
    for row in rows() {
        let words = row.words();
        let command = words.join(" ");
        renders(&folder, &words[1..].join(" "));
        let stem = if row.0 == "out" { "other" } else { "a" };
        let made = ["exr", "png"].map(|end| read(&format!("{stem}.{end}")));

        let call = row.call();
        let film = (call.film)(&call).expect("a film");
        let camera = call.scene().camera();
        let provenance = job(&command).provenance(camera, true);
        // The file records every setting that affects its pixels.
        let Row(option, value, ..) = row;
        let says_nothing = option == "precision" && value != "single";
        if !says_nothing && !["", "threads", "exposure", "out"].contains(&option) {
            assert!(
                provenance.contains(&format!("\n{option}={value}\n")),
                "{command}: {provenance}"
            );
        }
        let (exr, png) = (folder.join("own.exr"), folder.join("own.png"));
        write_exr(&exr, &film, camera, &provenance).expect("written");
        write_png(&png, &film, call.display, 1).expect("written");
        let own = ["own.exr", "own.png"].map(read);
        assert!(made[0] == own[0], "{command}: the EXR is not the library's");
        assert!(made[1] == own[1], "{command}: the PNG is not the library's");
        for end in ["exr", "png"] {
            std::fs::remove_file(folder.join(format!("{stem}.{end}"))).expect("removed");
        }
        if row.0.is_empty() {
            bases.push((row.2.0, made[1].clone()));
        } else {
            pictures.push((row, command, made[1].clone()));
        }
    }
    for (Row(option, value, base, _), command, picture) in &pictures {
        let (_, of_base) = bases
            .iter()
            .find(|(other, _)| *other == base.0)
            .expect("a row");
        let same_bytes =
            ["threads", "out"].contains(option) || *option == "precision" && *value != "single";
        let same = same_bytes || has_value(*base, option, value);
        assert_eq!(picture == of_base, same, "{command}");
    }
}

/// Returns whether a base has this value of an option already: by name, or by default.
fn has_value(base: Base, option: &str, value: &str) -> bool {
    if base.0.contains(&format!("--{option} {value}")) {
        return true;
    }
    let command = Render::command();
    let argument = command
        .get_arguments()
        .find(|argument| argument.get_long() == Some(option))
        .expect("an option");
    let default = argument
        .get_default_values()
        .first()
        .filter(|_| !argument.is_hide_default_value_set());
    let default = default.and_then(|value| value.to_str());
    // Values that the help states for omitted options.
    let implied = [
        ("convention", "physical"),
        ("estimator", "mis"),
        ("sampler", "sobol"),
        ("silhouettes", "yes"),
    ];
    let unsaid = !base.0.contains(&format!("--{option} "));
    unsaid
        && (default == Some(value)
            || [PLAIN.0, DIM.0].contains(&base.0) && implied.contains(&(option, value)))
}

/// Every option and every value has a row.
#[test]
fn every_option_and_value_has_a_row() {
    let mut lacking: BTreeSet<String> = BTreeSet::new();
    let rows = rows();
    for argument in Render::command().get_arguments() {
        let Some(long) = argument.get_long() else {
            continue;
        };
        // Options about the course of a run are tested in `checkpoints` and `preview`.
        if ["time", "target-error", "resume", "shard", "preview", "tev"].contains(&long) {
            continue;
        }
        let tried = |value: Option<&str>| {
            rows.iter()
                .any(|row| row.0 == long && value.is_none_or(|value| row.1 == value))
        };
        let values = argument.get_possible_values();
        if values.is_empty() && !tried(None) {
            lacking.insert(format!("--{long}"));
        }
        for value in values.iter().filter(|value| !tried(Some(value.get_name()))) {
            lacking.insert(format!("--{long} {}", value.get_name()));
        }
    }
    assert!(lacking.is_empty(), "no row for {lacking:?}");
}

/// Old names of options and values, which `CHANGELOG.md` lists, are still accepted, and a name that
/// other renderers have for an estimator.
#[test]
fn other_names_of_options_are_accepted() {
    for (other, own) in [
        ("--estimator path", "--estimator mis"),
        ("--engine lanes", "--precision double"),
        ("--engine single", "--precision single"),
        ("--outlines no", "--silhouettes no"),
        ("--light-sampling by-shape", "--light-sampler sphere-angle"),
        (
            "--light-sampling by-contribution",
            "--light-sampler importance",
        ),
        ("--specular-shadow-rays no", "--specular-nee no"),
    ] {
        let [other, own] =
            [other, own].map(|options| format!("{:?}", job(&format!("render {options}"))));
        assert_eq!(other, own);
    }
}
