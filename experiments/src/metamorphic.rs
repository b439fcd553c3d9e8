//! The program `metamorphic`: renders random scenes under relations that need no reference, and
//! reduces what breaks one to a small scene file.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use clap::Parser;
use rayon::prelude::*;
use trials::metamorphic::{
    Background, Case, Found, RELATIONS, Relation, SceneText, TECHNIQUES, Technique, generate,
    reduce, relation_named,
};
use whitefurnace::error::Error;
use whitefurnace::image::write_atomically;
use whitefurnace::integrator::Parts;
use whitefurnace::sampling::rng::seed_for;
use whitefurnace::suggest::did_you_mean;

use crate::print_line;
use crate::run::cli::{begin, run_with_verdict};
use crate::run::progress::{Bar, interrupted, print_above};
use crate::run::write_text;

/// Render random scenes under relations that need no reference, such as that a scene and its
/// camera may be moved together, and reduce each that breaks one to a small scene file.
///
/// Examples:
///   metamorphic --time 10m                          hunt for ten minutes
///   metamorphic --scenes 200 --relation split       200 scenes under one relation
///   metamorphic --scene out/metamorphic/a.toml --relation split --technique bdpt --seed 7
///                                                   test one scene file
///
/// A difference counts if three looks see it, each with other random numbers and more images than
/// the last, at levels of 1e-3, 1e-6 and 1e-6. Each finding is written to the folder --out as a
/// scene file, and printed with the command that shows it again; beside it stand the scenes of both
/// sides, NAME-a.toml and NAME-b.toml, for the programs render and compare. After Ctrl-C the hunt
/// ends with what is counted so far. Exit codes: 0 if no relation was broken, 1 if one was, 3 for
/// bad input.
#[derive(Parser)]
#[command(name = "metamorphic", version, verbatim_doc_comment)]
pub struct Metamorphic {
    /// How long to hunt, such as 90s, 10m or 2h [default: 1m]
    #[arg(long, value_parser = duration, value_name = "TIME")]
    time: Option<Duration>,
    /// The number of scenes, in place of a time
    #[arg(long, value_name = "N", conflicts_with = "time")]
    scenes: Option<u64>,
    /// Test this scene file instead of random scenes. It may have a background of one colour or an
    /// image, rectangles, spheres and meshes
    #[arg(long, value_name = "FILE", conflicts_with_all = ["time", "scenes"])]
    scene: Option<PathBuf>,
    /// The only relation to test [default: all]
    #[arg(long, value_name = "NAME", value_parser = relation)]
    relation: Option<&'static Relation>,
    /// The only technique to render by [default: one at random for each relation]
    #[arg(long, value_name = "NAME", value_parser = technique)]
    technique: Option<Technique>,
    /// The seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The folder of the findings
    #[arg(long, default_value = "out/metamorphic", value_name = "FOLDER")]
    out: PathBuf,
}

fn duration(text: &str) -> Result<Duration, String> {
    let unit = text.find(|c: char| c.is_ascii_alphabetic());
    let (number, unit) = text.split_at(unit.unwrap_or(text.len()));
    let seconds = match unit {
        "s" | "" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        _ => return Err("needs a time such as 90s, 10m or 2h".to_owned()),
    };
    match number.parse::<f64>() {
        Ok(count) if (0.0..=1e6).contains(&count) => Ok(Duration::from_secs_f64(count * seconds)),
        _ => Err("needs a number from 0 to 1e6 and s, m or h, such as 10m".to_owned()),
    }
}

fn relation(name: &str) -> Result<&'static Relation, String> {
    let names = RELATIONS.iter().map(|relation| relation.name);
    relation_named(name)
        .ok_or_else(|| format!("there is no such relation{}", did_you_mean(name, names)))
}

fn technique(name: &str) -> Result<Technique, String> {
    let names = TECHNIQUES.iter().map(|technique| technique.name);
    Technique::named(name)
        .ok_or_else(|| format!("there is no such technique{}", did_you_mean(name, names)))
}

/// Counts of a relation's cases by result.
#[derive(Default)]
struct Tally(BTreeMap<&'static str, [u64; 5]>);

impl Tally {
    fn add(&mut self, relation: &'static str, found: &Found) {
        let column = match found {
            Found::Holds => 0,
            Found::Undecided => 1,
            Found::NotApplicable => 2,
            Found::Refused(_) => 3,
            Found::Fails(_) => 4,
        };
        self.0.entry(relation).or_default()[column] += 1;
    }

    fn print(&self) {
        print_line!(
            "{:<16}{:>12}{:>15}{:>16}{:>10}{:>8}",
            "relation",
            "within 1 %",
            "no difference",
            "does not apply",
            "refused",
            "broken"
        );
        for relation in &RELATIONS {
            if let Some([holds, undecided, not, refused, fails]) = self.0.get(relation.name) {
                print_line!(
                    "{:<16}{holds:>12}{undecided:>15}{not:>16}{refused:>10}{fails:>8}",
                    relation.name
                );
            }
        }
    }
}

/// Runs the program.
pub fn main() -> ExitCode {
    run_with_verdict(|options: &Metamorphic| {
        begin();
        let tally = Mutex::new(Tally::default());
        match &options.scene {
            Some(path) => {
                let text = std::fs::read_to_string(path).map_err(Error::file("read", path))?;
                let image = |name: &str| {
                    let image = path.with_file_name(name);
                    std::fs::read(&image).map_err(|error| format!("{}: {error}", image.display()))
                };
                let scene = SceneText::parse(&text, image)
                    .map_err(|message| Error::Option(format!("{}, {message}", path.display())))?;
                options.test(&scene, options.seed, &tally)?;
            }
            None => options.hunt(&tally)?,
        }
        let tally = tally
            .into_inner()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        tally.print();
        Ok(u8::from(tally.0.values().any(|counts| counts[4] > 0)))
    })
}

impl Metamorphic {
    /// Tests random scenes until the time is over or all are done.
    fn hunt(&self, tally: &Mutex<Tally>) -> Result<(), Error> {
        let end = Instant::now() + self.time.unwrap_or(Duration::from_secs(60));
        let count = self.scenes.unwrap_or(u64::MAX);
        let next = AtomicU64::new(0);
        let bar = Bar::new("metamorphic", self.scenes.unwrap_or(0), "scenes");
        let over = || interrupted() || (self.scenes.is_none() && Instant::now() > end);
        (0..rayon::current_num_threads())
            .into_par_iter()
            .try_for_each(|_| {
                while !over() {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count {
                        break;
                    }
                    let seed = seed_for(self.seed, &format!("scene {index}"));
                    self.test(&generate(seed), seed, tally)?;
                    bar.advance(1);
                }
                Ok(())
            })?;
        drop(bar);
        let scenes = next.into_inner().min(count);
        print_line!("{scenes} scenes from seed {}", self.seed);
        Ok(())
    }

    /// Tests a scene under all relations that are asked for.
    fn test(&self, scene: &SceneText, seed: u64, tally: &Mutex<Tally>) -> Result<(), Error> {
        for relation in &RELATIONS {
            if self.relation.is_some_and(|only| only.name != relation.name) {
                continue;
            }
            let any = Case::of(relation, scene, seed);
            let case = Case {
                technique: self.technique.unwrap_or(any.technique),
                ..any
            };
            let found = checked(&case);
            if interrupted() {
                break;
            }
            if let Found::Fails(why) = &found {
                self.report(&case, why)?;
            }
            if let Ok(mut tally) = tally.lock() {
                tally.add(relation.name, &found);
            }
        }
        Ok(())
    }

    /// Reduces a case that fails and prints it.
    fn report(&self, case: &Case, why: &str) -> Result<(), Error> {
        print_above(|| {
            print_line!(
                "broken: {} by {}, seed {}: {why}",
                case.relation.name,
                case.technique.name,
                case.seed
            );
        });
        let stem = format!("{}-{}", case.relation.name, case.seed);
        let path = self.out.join(format!("{stem}.toml"));
        write_finding(&path, case, why)?;
        let smallest = reduce(case, &|smaller| match interrupted() {
            true => Found::NotApplicable,
            false => checked(smaller),
        });
        let Found::Fails(why) = checked(&smallest) else {
            return Ok(());
        };
        let path = self.out.join(format!("{stem}-reduced.toml"));
        write_finding(&path, &smallest, &why)
    }
}

/// Writes a case that fails, with the command that shows it again, and the scenes of both its
/// sides, `NAME-a.toml` and `NAME-b.toml`, or `NAME-b-1.toml` and so on where renders are added;
/// prints the command.
///
/// # Errors
/// [`Error::File`] for a file that cannot be written.
pub fn write_finding(path: &Path, case: &Case, why: &str) -> Result<(), Error> {
    let Case {
        relation,
        technique,
        scene,
        seed,
    } = case;
    let command = format!(
        "cargo run --release --bin metamorphic -- --scene {} --relation {} --technique {} --seed {seed}",
        path.display(),
        relation.name,
        technique.name,
    );
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::file("create", folder))?;
    let head = format!("# Breaks \"{}\": {why}\n# {command}\n", relation.about);
    write_scene(path, scene, &head)?;
    for (letter, side) in ["a", "b"].iter().zip(case.sides().into_iter().flatten()) {
        for (number, part) in side.iter().enumerate() {
            // Renders of one side are to be added.
            let number = match side.len() {
                1 => String::new(),
                _ => format!("-{}", number + 1),
            };
            let path = path.with_extension("");
            let path = format!("{}-{letter}{number}.toml", path.display());
            let head = format!("# By {}.\n", part.technique.name);
            write_scene(Path::new(&path), &part.scene, &head)?;
        }
    }
    let objects = scene.objects.len();
    print_above(|| print_line!("  {objects} objects: {command}"));
    Ok(())
}

/// Writes a scene file after a comment, and the image that it names beside it.
fn write_scene(path: &Path, scene: &SceneText, comment: &str) -> Result<(), Error> {
    let mut scene = scene.clone();
    if let Background::Sky(sky) = &mut scene.background {
        let image = path.with_extension("pfm");
        sky.image = image.file_name().unwrap_or_default().display().to_string();
        write_atomically(&image, |file| {
            file.write_all(&sky.file())
                .map_err(Error::file("write", &image))
        })?;
    }
    write_text(path, &format!("{comment}{}", scene.text()))
}

/// Checks a case; a panic is a failure.
fn checked(case: &Case) -> Found {
    catch_unwind(AssertUnwindSafe(|| case.check(Parts::default())))
        .unwrap_or_else(|_| Found::Fails("the program panics".to_owned()))
}
