//! Other renderers on trial: their images of our scenes, their BSDFs' samples, their samplers, from
//! records.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::experiments::prelude::*;
use crate::plot::forest::{Line, forest};

pub(super) const PEERS: Experiment = Experiment {
    id: "peers",
    title: "Mitsuba 3 and Blender's Cycles on trial, from records",
    headline: "from records: images of Mitsuba's path tracer agree with ours in {images.path.agree %d} of {images.path.scenes %d} scenes, of Cycles in {images.cycles.agree %d} of {images.cycles.scenes %d}; as Blender ships it in {images.cycles-default.agree %d}",
    version: 1,
    equations: &[&equation::RENDERING],
    run,
};

/// Record of `experiments/peers/images.py`; not computed by this run.
#[derive(Deserialize)]
struct Images {
    size: String,
    images: Vec<Compared>,
}

#[derive(Deserialize)]
struct Compared {
    scene: String,
    /// The renderer with its options, as the script names it.
    peer: String,
    renderer: String,
    spp: u32,
    /// Number of the peer's images.
    images: u32,
    verdict: Word,
    why: String,
    /// Relative difference of our image mean from the peer's by channel, and its confidence
    /// interval.
    means: BTreeMap<String, [f64; 3]>,
}

/// A verdict of `compare` or `judge`.
#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Word {
    Agree,
    Differ,
    Undecided,
}

impl Word {
    const ALL: [(Self, &'static str); 3] = [
        (Self::Agree, "agree"),
        (Self::Differ, "differ"),
        (Self::Undecided, "undecided"),
    ];
}

/// Record of `experiments/peers/bsdfs.py`.
#[derive(Deserialize)]
struct Bsdfs {
    renderer: String,
    samples: f64,
    found: Vec<Judged>,
    /// Pdfs that are wrong.
    wrong: Vec<Judged>,
    smooth: Vec<Smooth>,
}

#[derive(Deserialize)]
struct Judged {
    model: String,
    /// Angle of the outgoing direction from the normal.
    degrees: f64,
    verdict: Word,
    why: String,
    /// Median, 99.9 % quantile and largest of the relative difference of the weight from f cos/pdf.
    #[serde(default)]
    weight: [f64; 3],
    /// The same of the pdf that a sample reports from the function `pdf`.
    #[serde(default)]
    reported: [f64; 3],
}

/// Smooth glass at an angle.
#[derive(Deserialize)]
struct Smooth {
    degrees: f64,
    /// Largest difference of a direction from the laws of reflection and refraction.
    direction: f64,
    /// Deviation of the share of reflected samples from Fresnel's, in standard deviations.
    sigmas: f64,
}

/// Record of `experiments/peers/samplers.py`.
#[derive(Deserialize)]
struct Samplers {
    found: Vec<Correlated>,
}

/// The pair of a sampler's dimensions with the most significant correlation.
#[derive(Deserialize)]
struct Correlated {
    sampler: String,
    samples: u32,
    pair: [u32; 2],
    correlation: f64,
    sigmas: f64,
}

/// Peers whose image means are drawn, with the names of the plot.
const DRAWN: [(&str, &str); 3] = [
    ("path", "Mitsuba"),
    ("cycles", "Cycles"),
    ("path-darker", "Mitsuba, albedos 1 % lower"),
];
/// Margin of `compare`, the unit of the plot.
const MARGIN: f64 = 0.01;

fn run(run: &mut Run) -> Result<(), Error> {
    images(run)?;
    bsdfs(run)?;
    samplers(run)
}

/// Parses a record that another program made.
pub(super) fn recorded<T: DeserializeOwned>(name: &str, text: &str) -> Result<T, Error> {
    serde_json::from_str(text)
        .map_err(|error| Error::Option(format!("{name} cannot be read: {error}")))
}

/// Returns the number of each verdict.
fn counts(verdicts: &[Word]) -> [(&'static str, f64); 3] {
    Word::ALL.map(|(word, name)| (name, verdicts.iter().filter(|&&v| v == word).count() as f64))
}

fn images(run: &mut Run) -> Result<(), Error> {
    let record: Images = recorded("peers/images.json", include_str!("peers/images.json"))?;
    let mut by_peer: BTreeMap<&str, Vec<&Compared>> = BTreeMap::new();
    for compared in &record.images {
        by_peer.entry(&compared.peer).or_default().push(compared);
        let (what, means) = (&compared.peer, &compared.means);
        for (channel, &[difference, low, high]) in means {
            run.numbers(
                &format!("images.{what}.{}.{channel}", compared.scene),
                [("difference", difference), ("low", low), ("high", high)],
            );
        }
        run.note(
            &format!("{what}, {}", compared.scene),
            format!(
                "{}; {} images of {}, {}, {} spp",
                compared.why, compared.images, compared.renderer, record.size, compared.spp
            ),
        );
    }
    for (peer, compared) in &by_peer {
        let verdicts: Vec<Word> = compared.iter().map(|compared| compared.verdict).collect();
        let largest = compared
            .iter()
            .flat_map(|compared| compared.means.values())
            .fold(0.0f64, |largest, [difference, ..]| {
                largest.max(difference.abs())
            });
        run.numbers(
            &format!("images.{peer}"),
            [("scenes", compared.len() as f64), ("largest", largest)]
                .into_iter()
                .chain(counts(&verdicts)),
        );
    }
    let lines: Vec<Line> = DRAWN
        .iter()
        .flat_map(|(peer, name)| {
            let compared = by_peer.get(peer).into_iter().flatten();
            compared.filter_map(move |compared| line(compared, name))
        })
        .collect();
    let figure = run.figure("images.svg");
    forest(
        &figure,
        "Ours minus theirs, image means of the green channel, in units of 1 %",
        "Relative differences of image means, with confidence intervals, a line for each scene and renderer.",
        "confidence interval",
        &lines,
    )
}

/// Returns the line of the green channel's mean.
fn line(compared: &Compared, name: &str) -> Option<Line> {
    let [estimate, low, high] = compared.means.get("G")?.map(|x| x / MARGIN);
    let verdict = match compared.verdict {
        Word::Agree => Verdict::Holds,
        Word::Differ => Verdict::Fails,
        Word::Undecided => Verdict::Undecided { needed: u64::MAX },
    };
    Some(Line {
        label: format!("{name}: {}", compared.scene),
        estimate,
        interval: [low, high],
        verdict,
    })
}

fn bsdfs(run: &mut Run) -> Result<(), Error> {
    let record: Bsdfs = recorded("peers/bsdfs.json", include_str!("peers/bsdfs.json"))?;
    run.number("bsdfs.samples", record.samples);
    for (name, judged) in [("found", &record.found), ("wrong", &record.wrong)] {
        let verdicts: Vec<Word> = judged.iter().map(|judged| judged.verdict).collect();
        let all = [("all", judged.len() as f64)];
        run.numbers(
            &format!("bsdfs.{name}"),
            all.into_iter().chain(counts(&verdicts)),
        );
        for Judged {
            model,
            degrees,
            why,
            ..
        } in judged
        {
            run.note(
                &format!("{model}, {degrees}°"),
                format!("{why}; {}", record.renderer),
            );
        }
    }
    let largest = |of: fn(&Judged) -> f64| record.found.iter().map(of).fold(0.0, f64::max);
    let worst = |of: fn(&Smooth) -> f64| record.smooth.iter().map(of).fold(0.0, f64::max);
    run.numbers(
        "bsdfs",
        [
            ("weight", largest(|judged| judged.weight[1])),
            ("reported", largest(|judged| judged.reported[1])),
            ("smooth.direction", worst(|smooth| smooth.direction)),
            ("smooth.sigmas", worst(|smooth| smooth.sigmas.abs())),
        ],
    );
    for Smooth {
        degrees, sigmas, ..
    } in record.smooth
    {
        let value =
            format!("share of reflected light {sigmas:+.2} standard deviations off Fresnel's");
        run.note(&format!("smooth glass, {degrees}°"), value);
    }
    Ok(())
}

fn samplers(run: &mut Run) -> Result<(), Error> {
    let record: Samplers = recorded("peers/samplers.json", include_str!("peers/samplers.json"))?;
    for Correlated {
        sampler,
        samples,
        pair: [i, j],
        correlation,
        sigmas,
    } in record.found
    {
        run.numbers(
            &format!("samplers.{sampler}.{samples}"),
            [("correlation", correlation), ("sigmas", sigmas)],
        );
        let value = format!(
            "dimensions {i} and {j}: correlation {correlation:+.4}, {sigmas:+.1} standard errors"
        );
        run.note(&format!("{sampler}, {samples} samples"), value);
    }
    Ok(())
}
