//! Every option of `render` changes what it says, and nothing else: the program makes the bytes of the
//! library's own call with the same settings, written down here anew, and another picture than without it.

use std::collections::BTreeSet;

use clap::CommandFactory as _;
use experiments::render::command::Render;
use glam::DVec3;
use whitefurnace::bsdf::ggx::Ggx;
use whitefurnace::bsdf::{Bsdf, OrenNayar, OrenNayarForm};
use whitefurnace::emitter::LightSampling;
use whitefurnace::error::Error;
use whitefurnace::estimator::radiosity::Fineness;
use whitefurnace::estimator::{
    Bdpt, Estimator, Heuristic, ImageEstimator, LightRules, LightTracer, Lookup, Path, PhotonMapping, Published,
    Radiosity, Report, Sppm, Standard, Strategy, Whitted,
};
use whitefurnace::film::Film;
use whitefurnace::image::{Display, write_exr, write_png};
use whitefurnace::pixel::PixelSampling;
use whitefurnace::render::{Numbers, Sampling, render, render_passes};
use whitefurnace::scene::room::{self, Convention};
use whitefurnace::scene::{Scene, simple};

use crate::{folder, job, renders};

/// An estimator and its settings.
enum Method {
    Path(Strategy, LightSampling, Heuristic),
    LightTracer,
    Bdpt,
    Photon(u32, f64, Lookup),
    Sppm(u32, f64),
    Radiosity(u32),
    Whitted(LightRules),
    Report(u32, LightRules),
    Published,
}

/// A call of the library.
struct Call {
    scene: Result<Scene, Error>,
    method: Method,
    pixel: PixelSampling,
    numbers: Numbers,
    size: [u32; 2],
    spp: u32,
    seed: u64,
    display: Display,
}

/// Where an option is tried, as options of the program and as a call.
#[derive(Clone, Copy, PartialEq)]
enum Base {
    Plain,
    Photon,
    Sppm,
    Report,
    Published,
    Cornell,
    Jitter,
    Sobol,
    Radiosity,
}

const BALANCE: (LightSampling, Heuristic) = (LightSampling::Area, Heuristic::Balance);
impl Base {
    fn options(self) -> &'static str {
        match self {
            Self::Plain => "",
            Self::Photon => "--estimator photon --photons 3000 --radius 0.5",
            Self::Sppm => "--estimator sppm --photons 3000 --radius 0.5",
            Self::Report => "--convention report",
            Self::Published => "--convention published",
            Self::Cornell => "--scene cornell",
            Self::Jitter => "--pixel jitter --grid 2",
            Self::Sobol => "--sampler sobol --scrambles 2",
            Self::Radiosity => "--scene cornell --estimator radiosity --patches 60",
        }
    }

    fn call(self) -> Call {
        let (lights, heuristic) = BALANCE;
        let mut call = Call {
            scene: room::report(Convention::Physical, OrenNayarForm::Corrected),
            method: Method::Path(Strategy::Mis, lights, heuristic),
            pixel: PixelSampling::Random,
            numbers: Numbers::Independent,
            size: [16, 12],
            spp: 4,
            seed: 1,
            display: Display::Srgb { exposure: 0.0 },
        };
        match self {
            Self::Plain => {}
            Self::Photon => photons(&mut call, [3000; 2], [0.5; 2]),
            Self::Sppm => call.method = Method::Sppm(3000, 0.5),
            Self::Report => {
                call.method = Method::Report(1, LightRules::REPORT);
                call.display = Display::Truncated;
            }
            Self::Published => published(&mut call),
            Self::Cornell => call.scene = simple::cornell(),
            Self::Jitter => call.pixel = PixelSampling::Jitter(2),
            Self::Sobol => call.numbers = Numbers::Sobol(2),
            Self::Radiosity => {
                call.scene = simple::cornell();
                call.method = Method::Radiosity(60);
            }
        }
        call
    }
}

fn published(call: &mut Call) {
    call.scene = room::report(Convention::Published, OrenNayarForm::Corrected);
    call.method = Method::Published;
    call.display = Display::Truncated;
}

impl Call {
    fn film(&self) -> Result<Film, Error> {
        let scene = self.scene.as_ref().expect("a scene");
        match self.method {
            Method::Path(strategy, lights, heuristic) => {
                self.rays(scene, &Path { parts: Standard, strategy, lights, heuristic })
            }
            Method::LightTracer => self.images(scene, &LightTracer::<Standard>::default()),
            Method::Bdpt => self.images(scene, &Bdpt::<Standard>::default()),
            Method::Photon(particles, radius, lookup) => {
                let (map, name) = ((particles, radius), (self.seed, 0));
                let photons = PhotonMapping::new(Standard, scene, lookup, map, name)?;
                self.rays(scene, &photons)
            }
            Method::Sppm(particles, radius) => self.images(scene, &Sppm { parts: Standard, particles, radius }),
            Method::Radiosity(patches) => {
                let fineness = Fineness { patches, halvings: 0 };
                self.rays(scene, &Radiosity::new(Standard, scene, fineness, &|_| true)?)
            }
            Method::Whitted(rules) => self.rays(scene, &Whitted::new(rules)),
            Method::Report(rays, rules) => {
                let report = Report { rays, rules, ..Report::default() };
                self.rays(scene, &report)
            }
            Method::Published => self.rays(scene, &Published::default()),
        }
    }

    fn rays<E: Estimator>(&self, scene: &Scene, estimator: &E) -> Result<Film, Error> {
        let sampling = Sampling { pixel: self.pixel, numbers: self.numbers, seed: self.seed };
        let each = sampling.samples_per_replication();
        let mut film = Film::new(self.size, None, each)?;
        let range = 0..self.spp / each;
        render(scene, estimator, sampling, &mut film, &range, &|_| true)?;
        Ok(film)
    }

    fn images<E: ImageEstimator>(&self, scene: &Scene, estimator: &E) -> Result<Film, Error> {
        let mut film = Film::new(self.size, None, 1)?;
        render_passes(scene, estimator, self.seed, &mut film, 0..self.spp, &|_| true)?;
        Ok(film)
    }
}

/// An option with a value, where it is tried, and what it changes of the call.
struct Row(&'static str, &'static str, Base, fn(&mut Call));

fn path(call: &mut Call, strategy: Strategy) {
    call.method = Method::Path(strategy, BALANCE.0, BALANCE.1);
}

/// Photon mapping with these photons and radii: for all light, and for caustics.
fn photons(call: &mut Call, particles: [u32; 2], radii: [f64; 2]) {
    let lookup = Lookup::Gather { caustic_particles: particles[1], caustic_radius: radii[1] };
    call.method = Method::Photon(particles[0], radii[0], lookup);
}

fn white_sphere(call: &mut Call, bsdf: Bsdf) {
    call.scene = room::with_white_sphere(bsdf, room::Walls::default());
}

const GREY: DVec3 = DVec3::splat(room::WHITE);

fn rows() -> Vec<Row> {
    use Base::{Cornell, Jitter, Photon, Plain, Radiosity as Mesh, Report as Text, Sobol};
    vec![
        Row("scene", "report", Plain, |_| {}),
        Row("scene", "diffuse-room", Plain, |c| c.scene = room::diffuse()),
        Row("scene", "environment", Plain, |c| c.scene = simple::environment()),
        Row("scene", "furnace-box", Plain, |c| c.scene = simple::furnace_box(0.75)),
        Row("scene", "cavity-cap", Plain, |c| {
            c.scene = simple::cavity_cap(0.75, simple::Cap::Reflecting);
        }),
        Row("scene", "glass-cube", Plain, |c| c.scene = simple::glass_cube(false)),
        Row("scene", "cornell", Plain, |c| c.scene = simple::cornell()),
        Row("convention", "physical", Plain, |_| {}),
        Row("convention", "report", Plain, |c| *c = Text.call()),
        Row("convention", "published", Plain, published),
        Row("estimator", "bsdf", Plain, |c| path(c, Strategy::Bsdf)),
        Row("estimator", "light", Plain, |c| path(c, Strategy::Light)),
        Row("estimator", "mis", Plain, |_| {}),
        Row("estimator", "light-tracer", Cornell, |c| c.method = Method::LightTracer),
        Row("estimator", "photon", Base::Sppm, |c| photons(c, [3000, 3000], [0.5, 0.5])),
        Row("estimator", "sppm", Photon, |c| c.method = Method::Sppm(3000, 0.5)),
        Row("estimator", "bdpt", Plain, |c| c.method = Method::Bdpt),
        // In the report's room it implies the report's convention.
        Row("estimator", "report", Plain, |c| *c = Text.call()),
        Row("estimator", "report", Cornell, |c| c.method = Method::Report(1, LightRules::PHYSICAL)),
        Row("estimator", "radiosity", Mesh, |_| {}),
        Row("estimator", "whitted", Plain, |c| c.method = Method::Whitted(LightRules::PHYSICAL)),
        Row("estimator", "whitted", Text, |c| c.method = Method::Whitted(LightRules::REPORT)),
        Row("light-sampling", "area", Plain, |_| {}),
        Row("light-sampling", "solid-angle", Plain, |c| {
            c.method = Method::Path(Strategy::Mis, LightSampling::SolidAngle, BALANCE.1);
        }),
        Row("heuristic", "balance", Plain, |_| {}),
        Row("heuristic", "power", Plain, |c| {
            c.method = Method::Path(Strategy::Mis, BALANCE.0, Heuristic::Power);
        }),
        Row("diffuse", "lambert", Plain, |c| white_sphere(c, Bsdf::Lambert { albedo: GREY })),
        Row("diffuse", "printed", Plain, |c| {
            c.scene = room::report(Convention::Physical, OrenNayarForm::Printed);
        }),
        Row("diffuse", "corrected", Plain, |_| {}),
        Row("diffuse", "eon", Plain, |c| {
            let roughness = OrenNayar::new(room::SIGMA).roughness();
            white_sphere(c, Bsdf::Eon { albedo: GREY, roughness });
        }),
        Row("diffuse", "ggx", Plain, |c| {
            white_sphere(c, Bsdf::model(Ggx { reflectance: GREY, alpha: room::SIGMA }));
        }),
        Row("rays", "3", Text, |c| c.method = Method::Report(3, LightRules::REPORT)),
        Row("photons", "2000", Base::Sppm, |c| c.method = Method::Sppm(2000, 0.5)),
        Row("photons", "2000", Photon, |c| photons(c, [2000, 2000], [0.5, 0.5])),
        Row("radius", "0.3", Base::Sppm, |c| c.method = Method::Sppm(3000, 0.3)),
        Row("radius", "0.3", Photon, |c| photons(c, [3000, 3000], [0.3, 0.3])),
        Row("gather", "yes", Photon, |_| {}),
        Row("gather", "no", Photon, |c| c.method = Method::Photon(3000, 0.5, Lookup::Direct)),
        Row("caustic-photons", "20000", Photon, |c| photons(c, [3000, 20_000], [0.5, 0.5])),
        Row("caustic-radius", "0.2", Photon, |c| photons(c, [3000, 3000], [0.5, 0.2])),
        Row("patches", "200", Mesh, |c| c.method = Method::Radiosity(200)),
        Row("pixel", "centre", Plain, |c| c.pixel = PixelSampling::Centre),
        Row("pixel", "grid", Plain, |c| {
            c.pixel = PixelSampling::Grid(4);
            c.spp = 16;
        }),
        Row("pixel", "random", Plain, |_| {}),
        Row("pixel", "jitter", Plain, |c| {
            c.pixel = PixelSampling::Jitter(4);
            c.spp = 16;
        }),
        Row("grid", "1", Jitter, |c| c.pixel = PixelSampling::Jitter(1)),
        Row("sampler", "independent", Plain, |_| {}),
        Row("sampler", "sobol", Plain, |c| {
            c.numbers = Numbers::Sobol(2);
            c.spp = 16;
        }),
        Row("scrambles", "4", Sobol, |c| c.numbers = Numbers::Sobol(1)),
        Row("size", "20x10", Plain, |c| c.size = [20, 10]),
        Row("spp", "3", Plain, |c| c.spp = 3),
        Row("seed", "18446744073709551615", Plain, |c| c.seed = u64::MAX),
        Row("threads", "3", Plain, |_| {}),
        Row("exposure", "-1.5", Plain, |c| c.display = Display::Srgb { exposure: -1.5 }),
        Row("out", "other.exr", Plain, |_| {}),
        // The bases themselves.
        Row("", "", Plain, |_| {}),
        Row("", "", Photon, |_| {}),
        Row("", "", Base::Sppm, |_| {}),
        Row("", "", Text, |_| {}),
        Row("", "", Base::Published, |_| {}),
        Row("", "", Cornell, |_| {}),
        Row("", "", Jitter, |_| {}),
        Row("", "", Sobol, |_| {}),
        Row("", "", Mesh, |_| {}),
    ]
}

impl Row {
    /// The words of the command line: an option of the row stands for one of its base.
    fn words(&self) -> Vec<String> {
        let Row(option, value, base, _) = self;
        let call = self.call();
        let (size, spp) = (format!("{}x{}", call.size[0], call.size[1]), call.spp.to_string());
        let rest = format!("--size {size} --spp {spp} --out a.exr {}", base.options());
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
    // The pictures of the bases, and of the rows.
    let mut bases = Vec::new();
    let mut pictures = Vec::new();
    for row in rows() {
        let words = row.words();
        let command = words.join(" ");
        renders(&folder, &words[1..].join(" "));
        let stem = if row.0 == "out" { "other" } else { "a" };
        let made = ["exr", "png"].map(|end| read(&format!("{stem}.{end}")));

        let call = row.call();
        let film = call.film().expect("a film");
        let provenance = job(&command).provenance(true);
        // The file says all that decides its pixels.
        let Row(option, value, ..) = row;
        if !["", "threads", "exposure", "out"].contains(&option) {
            assert!(provenance.contains(&format!("\n{option}={value}\n")), "{command}: {provenance}");
        }
        let (exr, png) = (folder.join("own.exr"), folder.join("own.png"));
        write_exr(&exr, &film, &provenance).expect("written");
        write_png(&png, &film, call.display, 1).expect("written");
        let own = ["own.exr", "own.png"].map(read);
        assert!(made[0] == own[0], "{command}: the EXR is not the library's");
        assert!(made[1] == own[1], "{command}: the PNG is not the library's");
        for end in ["exr", "png"] {
            std::fs::remove_file(folder.join(format!("{stem}.{end}"))).expect("removed");
        }
        if row.0.is_empty() {
            bases.push((row.2, made[1].clone()));
        } else {
            pictures.push((row, command, made[1].clone()));
        }
    }
    for (Row(option, value, base, _), command, picture) in &pictures {
        let (_, of_base) = bases.iter().find(|(other, _)| other == base).expect("a row");
        let same = ["threads", "out"].contains(option) || says(*base, option, value);
        assert_eq!(picture == of_base, same, "{command}");
    }
}

/// Whether a base has this value of an option already: by name, or by default.
fn says(base: Base, option: &str, value: &str) -> bool {
    if base.options().contains(&format!("--{option} {value}")) {
        return true;
    }
    let command = Render::command();
    let argument = command.get_arguments().find(|argument| argument.get_long() == Some(option)).expect("an option");
    let default = argument.get_default_values().first();
    let default = default.and_then(|value| value.to_str());
    // The help says what these are where they are left out.
    let implied = [("convention", "physical"), ("estimator", "mis")];
    let unsaid = !base.options().contains(&format!("--{option} "));
    unsaid && (default == Some(value) || base == Base::Plain && implied.contains(&(option, value)))
}

/// A new option or value needs a row.
#[test]
fn every_option_and_value_has_a_row() {
    let mut lacking: BTreeSet<String> = BTreeSet::new();
    let rows = rows();
    for argument in Render::command().get_arguments() {
        let Some(long) = argument.get_long() else {
            continue;
        };
        let tried =
            |value: Option<&str>| rows.iter().any(|row| row.0 == long && value.is_none_or(|value| row.1 == value));
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
