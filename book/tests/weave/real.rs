//! Tests of the book of this project.

use std::fs;
use std::path::{Path, PathBuf};

use book::{Options, build, check};

#[test]
fn weaves_twice_to_the_same_bytes_and_loads_nothing_from_outside() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bytes = |name: &str| {
        let out = folder.path().join(name);
        let first = build(&Options {
            out: out.clone(),
            ..Options::default()
        });
        let first = first.unwrap_or_else(|error| panic!("{error}"));
        assert!(first.is_file());
        check::output(&out).unwrap_or_else(|error| panic!("{error}"));
        let read = |file: PathBuf| {
            let content = fs::read(&file).expect("a written file");
            (file.strip_prefix(&out).map(Path::to_owned), content)
        };
        check::files(&out)
            .expect("the written files")
            .into_iter()
            .map(read)
            .collect::<Vec<_>>()
    };
    let (files, again) = std::thread::scope(|scope| {
        let again = scope.spawn(|| bytes("two"));
        (bytes("one"), again.join().expect("woven"))
    });
    assert!(files == again, "the second book differs");
    for (name, content) in &files {
        let name = name.as_ref().expect("inside");
        if name.extension().is_some_and(|e| e == "html") {
            let html = String::from_utf8_lossy(content);
            // Addresses in comments and the namespace of inline icons are not fetched.
            let html = without_comments(&html).replace("http://www.w3.org/2000/svg", "");
            assert!(!html.contains("://"), "{} has an address", name.display());
            assert!(!html.contains("{{#"), "{} has a directive", name.display());
            assert!(
                !html.contains("\"playground\""),
                "{} may call out",
                name.display()
            );
        }
    }
    let has = |name: &str| {
        files
            .iter()
            .any(|(file, _)| file.as_deref() == Ok(Path::new(name)))
    };
    assert!(has("searchindex.js") && has("index.html") && has("equations.html"));
    assert!(has("explore/reference.js"));
}

/// Returns HTML without its comments.
fn without_comments(html: &str) -> String {
    let mut parts = html.split("<!--");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        text + part.split_once("-->").map_or("", |(_, rest)| rest)
    })
}

#[test]
fn shows_every_equation_and_every_chapter_asks_and_sets_a_task() {
    let pages = Options::default().book.join("pages");
    let mut shown = Vec::new();
    for file in check::files(&pages).expect("pages") {
        let text = fs::read_to_string(&file).expect("a page");
        let equations = text.lines().filter_map(|line| line.strip_prefix("{{#eq "));
        let before = shown.len();
        shown.extend(equations.map(|id| id.trim_end_matches("}}").to_owned()));
        if shown.len() > before {
            assert!(text.contains("\n\n> "), "{} asks nothing", file.display());
            assert!(
                text.contains("\n## Exercise\n"),
                "{} has no exercise",
                file.display()
            );
            let words = text.split_whitespace().count();
            assert!(words < 2000, "{} has {words} words", file.display());
        }
    }
    shown.sort();
    let mut all: Vec<_> = whitefurnace::equation::ALL
        .iter()
        .map(|e| e.id.to_owned())
        .collect();
    all.sort();
    assert_eq!(shown, all);
}

/// Every exercise has a folded answer, and most chapters ask which trials reject a fault.
#[test]
fn every_exercise_is_answered() {
    let pages = Options::default().book.join("pages");
    let (mut exercises, mut questions) = (0, 0);
    for file in check::files(&pages).expect("pages") {
        let text = fs::read_to_string(&file).unwrap_or_default();
        questions += text.matches("\n{{#question ").count();
        let Some((_, exercise)) = text.split_once("\n## Exercise\n") else {
            continue;
        };
        exercises += 1;
        let answer = exercise.split_once("\n<details><summary>Answer</summary>\n\n");
        let answer = answer.and_then(|(_, rest)| rest.split_once("\n\n</details>\n"));
        let words = answer.map_or(0, |(answer, _)| answer.split_whitespace().count());
        assert!(words > 20, "{} has no answer", file.display());
    }
    assert!(exercises > 20, "{exercises} exercises");
    assert!(questions >= 15, "{questions} questions");
}

/// The README's image is a recorded one in bands, with every band present, at a size without seams.
#[test]
fn the_readme_shows_all_bands_of_its_picture() {
    let options = Options::default();
    let readme = fs::read_to_string(options.sources.join("README.md")).expect("the README");
    let images = readme.split("<img src=\"").skip(1);
    let shown: Vec<&str> = images
        .map(|image| image.split(" align").next().unwrap_or_default())
        .collect();
    let results = records::results::Results::load(&options.results).expect("recorded results");
    let (_, bands) = results
        .figure("fig6/physical.png")
        .expect("a recorded picture");
    let bands: Vec<String> = bands
        .iter()
        .map(|band| {
            let png = fs::read(band).expect("a band");
            // Every PNG header has width and height; the image is shown at three quarters of its
            // size, in whole pixels.
            let number = |at: usize| {
                png[at..at + 4]
                    .iter()
                    .fold(0, |n, &b| 256 * n + u32::from(b))
            };
            let [width, height] = [16, 20].map(|at| {
                assert!(number(at).is_multiple_of(4), "{}", band.display());
                number(at) / 4 * 3
            });
            let name = band.file_name().unwrap_or_default().to_string_lossy();
            format!("book/recorded/fig6/{name}\" width=\"{width}\" height=\"{height}\"")
        })
        .collect();
    assert_eq!(shown, bands);
}
