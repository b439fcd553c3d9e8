//! The program `judge`: tests a sampler in any language by the directions that it writes to a file.

mod columns;
mod density;
mod npy;
mod own_pdf;
mod precision;
pub mod read;
mod text;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use serde_json::{Value, json};
use whitefurnace::error::Error;
use whitefurnace::harness::directions::{Density, Directions, Precision};
use whitefurnace::harness::domain::Domain;
use whitefurnace::harness::outcome::{ALPHA, Outcome, Verdict};

use crate::plot::trial_cells;
use crate::print_line;
use crate::run::cli::{number, run_with_verdict};
use crate::run::record::write_json;
use columns::Columns;
use density::NamedDensity;
use precision::{FilePrecision, PrecisionOption, words};
use read::{DigitCounts, Row};

/// Decide whether directions follow a density: chi-square over few and many cells, means, and the
/// sampler's own weights and pdfs.
///
/// Examples:
///   judge --samples directions.csv --density cosine         a Lambert sampler
///   judge --samples reflected.npy --density ggx:0.3,60      GGX visible normals, viewed at 60 deg
///   judge --samples sky.npy --table sky.csv --domain sphere against a table
///
/// A file of samples has a row for each sample: x, y, z, and optionally its weight f cos/pdf and
/// its pdf (1/sr). It is text with commas, semicolons, tabs or blanks between numbers, with or
/// without a header, or a numpy array: NPY, or NPZ of one array or of arrays called x, y, z, weight
/// and pdf (file.npz:name chooses one). The normal is z; with ggx, light goes out in the x-z plane
/// towards x. A lost sample is a row 0,0,0: leave none out. Lines that begin with # are skipped.
///
/// Numbers in single precision or with few decimals are judged as such: a direction stands for all
/// that are rounded to the same numbers, so correct samples pass as often as exact ones, and
/// effects hidden by the rounding are not judged.
///
/// With --own-pdf no density is needed: the column pdf is tested against the density of the samples
/// themselves, which the distances of nearest neighbours show. Eight million samples are a good
/// start.
///
/// The folder --out gets judge.json and a plot of the cells. Exit codes: 0 if the samples follow
/// the density, 1 if not, 2 if more samples are needed to tell, 3 for bad input.
#[derive(Parser)]
#[command(name = "judge", version, verbatim_doc_comment)]
pub struct Judge {
    /// The samples
    #[arg(long, value_name = "FILE")]
    samples: PathBuf,
    /// uniform-sphere, uniform-hemisphere, cosine, cosine-power:N, henyey-greenstein:G (about z),
    /// ggx-normals:ALPHA (all normals, by their projected area), or ggx:ALPHA,DEGREES (reflected at
    /// visible normals)
    #[arg(long, value_name = "NAME", required_unless_present_any = ["table", "own_pdf"])]
    density: Option<NamedDensity>,
    /// Text or an array of at most a million numbers in proportion to the pdf, in place of
    /// --density: a row for each band of equal height from z = 1 down, a column for each sector of
    /// azimuth from x towards y
    #[arg(long, value_name = "FILE", conflicts_with = "density")]
    table: Option<PathBuf>,
    /// The directions that a table covers
    #[arg(long, value_enum, default_value_t = TableDomain::Hemisphere, requires = "table", conflicts_with_all = ["density", "own_pdf"])]
    domain: TableDomain,
    /// Test the column pdf by the samples themselves
    #[arg(long, conflicts_with_all = ["density", "table", "mean_weight"])]
    own_pdf: bool,
    /// The pdf is positive over this whole domain: test integrals over it as means of g/pdf, too
    #[arg(long, value_enum, requires = "own_pdf", conflicts_with_all = ["density", "table"])]
    covers: Option<TableDomain>,
    /// The columns, of x, y, z, weight, pdf and - for one that is ignored [default: the file's
    /// names, or these in order]
    #[arg(
        long,
        value_delimiter = ',',
        allow_hyphen_values = true,
        value_name = "NAMES"
    )]
    columns: Vec<String>,
    /// Expected mean weight, lost samples counted as 0: the directional albedo; from 1e-9 to 1e9
    #[arg(long, allow_hyphen_values = true, value_parser = number(1e-9..=1e9))]
    mean_weight: Option<f64>,
    /// The precision of the numbers: auto (as the numbers show), double, single, half, or the
    /// number of decimals, from 2 to 15
    #[arg(long, value_name = "WHICH", default_value = "auto")]
    precision: PrecisionOption,
    /// Tolerance of a cell's probability and of the mean weight in percent, and of means of
    /// quantiles in hundredths; from 0.01 to 50
    #[arg(long, default_value_t = 5.0, allow_hyphen_values = true, value_parser = number(0.01..=50.0))]
    margin: f64,
    /// Folder for the report
    #[arg(long, value_name = "DIR", default_value = "out/judge")]
    out: PathBuf,
}

/// Directions that a table or a pdf covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TableDomain {
    /// Directions with z of at least 0
    Hemisphere,
    /// All directions
    Sphere,
}

impl From<TableDomain> for Domain {
    fn from(domain: TableDomain) -> Self {
        match domain {
            TableDomain::Hemisphere => Self::Hemisphere,
            TableDomain::Sphere => Self::Sphere,
        }
    }
}

/// Largest number of entries of a table.
const LARGEST_TABLE: usize = 1_000_000;

/// Runs the whole program.
pub fn main() -> ExitCode {
    run_with_verdict(run)
}

/// Tests of a file of samples.
struct Judgement {
    /// Columns as they were read.
    columns: Columns,
    /// Mean weight and its standard error, from samples with weights.
    mean_weight: Option<[f64; 2]>,
    outcomes: Vec<Outcome>,
}

fn run(options: &Judge) -> Result<u8, Error> {
    let density = match (&options.density, &options.table) {
        (Some(named), _) => Some(named.density()),
        (None, Some(table)) => Some(read_table(table, options.domain)?),
        (None, None) => None,
    };
    let columns = Columns::by_names(&options.columns).map_err(Error::Option)?;
    let precision = match options.precision {
        PrecisionOption::All(rounding) => Precision {
            direction: rounding,
            weight: rounding,
            pdf: rounding,
        },
        PrecisionOption::Auto => observe_precision(&options.samples, columns.clone())?.precision(),
    };
    let judgement = match density {
        Some(density) => by_density(options, &density, columns, precision)?,
        None => own_pdf::judge(options, columns, precision)?,
    };
    report(options, &precision, &judgement)
}

/// Tests samples against a density.
fn by_density(
    options: &Judge,
    density: &Density,
    columns: Option<Columns>,
    precision: Precision,
) -> Result<Judgement, Error> {
    let mut directions = Directions::with_precision(density, precision);
    let columns = each_row(&options.samples, columns, &mut |columns, row| {
        directions.push(&columns.sample(row.numbers, &precision)?);
        Ok(())
    })?;
    if options.mean_weight.is_some() && directions.mean_weight().is_none() {
        return Err(Error::Option(
            "--mean-weight needs samples with a column weight".to_owned(),
        ));
    }
    Ok(Judgement {
        columns,
        mean_weight: directions.mean_weight(),
        outcomes: directions.outcomes(options.margin / 100.0, options.mean_weight),
    })
}

/// Calls `each` with each row of samples and the indices of its columns; returns these.
fn each_row(
    path: &Path,
    mut columns: Option<Columns>,
    each: &mut dyn FnMut(&Columns, &Row) -> Result<(), String>,
) -> Result<Columns, Error> {
    let mut any = false;
    read::rows(path, &mut |row| {
        any = true;
        let columns = match &mut columns {
            Some(columns) => columns,
            None => columns.insert(Columns::found(row.names, row.numbers.len())?),
        };
        columns.check(row.numbers.len())?;
        each(columns, row)
    })?;
    columns
        .filter(|_| any)
        .ok_or_else(|| Error::Option(format!("{}: no samples", path.display())))
}

/// Measures the precision of a file from its numbers.
fn observe_precision(path: &Path, columns: Option<Columns>) -> Result<FilePrecision, Error> {
    let mut seen = FilePrecision::default();
    each_row(path, columns, &mut |columns, row| {
        for (which, place) in columns.places.iter().enumerate() {
            let Some(place) = *place else { continue };
            let group = match which {
                0..3 => &mut seen.direction,
                3 => &mut seen.weight,
                _ => &mut seen.pdf,
            };
            group.add(
                row.numbers[place],
                row.digits.map(|digits: &[DigitCounts]| digits[place]),
            );
        }
        Ok(())
    })?;
    Ok(seen)
}

/// Returns the density of a name and its parameters, as after `--density`.
///
/// # Errors
/// An error that says which name or parameter is wrong.
pub fn density_of_name(name: &str) -> Result<Density, String> {
    name.parse::<NamedDensity>().map(|named| named.density())
}

/// Reads a table's density.
///
/// # Errors
/// [`Error::File`] or [`Error::Option`].
pub fn read_table(path: &Path, domain: TableDomain) -> Result<Density, Error> {
    let mut table: Vec<Vec<f64>> = Vec::new();
    read::rows(path, &mut |row| {
        let row = row.numbers;
        if row
            .iter()
            .any(|value| !(value.is_finite() && *value >= 0.0))
        {
            return Err("a pdf must be finite and at least 0".to_owned());
        }
        if table.first().is_some_and(|first| first.len() != row.len()) {
            return Err(format!(
                "{} numbers, where the first row has {}",
                row.len(),
                table[0].len()
            ));
        }
        table.push(row.to_vec());
        let fits = table.len() * row.len() <= LARGEST_TABLE;
        if fits {
            Ok(())
        } else {
            Err(format!("more than {LARGEST_TABLE} numbers"))
        }
    })?;
    let sum: f64 = table.iter().flatten().sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return Err(Error::Option(format!(
            "{}: no number above 0, or too large ones",
            path.display()
        )));
    }
    Ok(Density::from_table(domain.into(), &table))
}

/// Writes judge.json and the plot, prints the result, and returns the exit code.
fn report(
    options: &Judge,
    precision: &Precision,
    Judgement {
        columns,
        mean_weight,
        outcomes,
    }: &Judgement,
) -> Result<u8, Error> {
    let fails = outcomes
        .iter()
        .find(|outcome| outcome.verdict() == Verdict::Fails);
    let (code, word, decisive) = if fails.is_some() {
        (1, "DIFFER", fails)
    } else if let Some(undecided) = outcomes
        .iter()
        .max_by_key(|outcome| samples_needed(outcome))
        .filter(|o| samples_needed(o) > 0)
    {
        (2, "UNDECIDED", Some(undecided))
    } else {
        (0, "AGREE", None)
    };
    std::fs::create_dir_all(&options.out).map_err(Error::file("create", &options.out))?;
    let plot = options.out.join("cells.svg");
    trial_cells::plot(
        &outcomes[0].cells,
        &format!("{}, {}", options.samples.display(), outcomes[0].name),
        &plot,
    )?;
    let random = outcomes
        .iter()
        .filter(|outcome| outcome.is_random())
        .count();
    let false_alarm = ALPHA * random as f64;
    let numbers = json!({
        "samples": options.samples.display().to_string(),
        "n": outcomes[0].n,
        "columns": columns.words(),
        "verdict": word.to_lowercase(),
        "false_alarm": false_alarm,
        "precision": {
            "direction": words(&precision.direction),
            "weight": words(&precision.weight),
            "pdf": words(&precision.pdf),
        },
        "mean_weight": mean_weight,
        "outcomes": outcomes.iter().map(outcome_numbers).collect::<Vec<_>>(),
    });
    write_json(&options.out.join("judge.json"), &numbers)?;
    let why = match decisive {
        None => {
            let density = if options.own_pdf {
                "their own pdf"
            } else {
                "the density"
            };
            format!("the samples follow {density}, within the precision stated below")
        }
        Some(outcome) if samples_needed(outcome) > 0 => {
            let how_many = match samples_needed(outcome) {
                u64::MAX => "cannot be decided by more samples".to_owned(),
                needed => format!("needs about {needed} samples"),
            };
            format!("nothing differs, but {} {how_many}", subject(outcome))
        }
        Some(outcome) => format!("{}: {}", subject(outcome), outcome.worst),
    };
    print_line!("{word}: {why}");
    print_line!(
        "{} samples; chance of a false alarm at most {false_alarm:.0e}",
        outcomes[0].n
    );
    let how = if options.precision == PrecisionOption::Auto {
        "as the numbers show; --precision sets another"
    } else {
        "as asked"
    };
    print_line!("columns read: {}", columns.words());
    print_line!("directions: {}, {how}", words(&precision.direction));
    for outcome in outcomes {
        print_line!("{}", line(outcome));
    }
    if let (Some([mean, error]), None) = (*mean_weight, options.mean_weight) {
        print_line!("mean weight: {mean:.6} ± {error:.1e}; --mean-weight tests it");
    }
    print_line!("{}", plot.display());
    Ok(code)
}

/// Returns the number of samples that would decide; 0 if the outcome is decided.
fn samples_needed(outcome: &Outcome) -> u64 {
    match outcome.verdict() {
        Verdict::Undecided { needed } => needed,
        Verdict::Holds | Verdict::Fails => 0,
    }
}

/// Returns the tested quantity as the subject of a clause.
fn subject(outcome: &Outcome) -> String {
    match outcome.statistic {
        "chi-square" => format!("the histogram of {}", outcome.name),
        _ => format!("the {}", outcome.name),
    }
}

/// Formats a number, with 0 for −0.
fn plain(value: f64) -> String {
    format!("{value:.6}").replace("-0.000000", "0.000000")
}

/// Describes the result of one statistic.
fn line(outcome: &Outcome) -> String {
    let Outcome {
        name,
        p,
        estimate,
        reference,
        ..
    } = outcome;
    let word = match samples_needed(outcome) {
        0 => outcome.verdict().word().to_owned(),
        u64::MAX => "undecided".to_owned(),
        needed => format!("undecided (needs about {needed} samples)"),
    };
    match outcome.statistic {
        "exact" => format!("{name}: {word}; {}", outcome.worst),
        "chi-square" => {
            format!(
                "{name}: {word}, p {p:.1e}; the largest is {:+.2} % off; {}",
                100.0 * estimate,
                outcome.worst
            )
        }
        _ => {
            let seen = outcome.minimum_detectable_effect();
            format!(
                "{name}: {word}, p {p:.1e}; {}, should be {}; smallest detectable difference {seen:.1e}",
                plain(*estimate),
                plain(*reference)
            )
        }
    }
}

fn outcome_numbers(outcome: &Outcome) -> Value {
    json!({
        "name": outcome.name,
        "statistic": outcome.statistic,
        "verdict": outcome.verdict().word(),
        "value": outcome.value,
        "dof": outcome.dof,
        "p": outcome.p,
        "n": outcome.n,
        "estimate": outcome.estimate,
        "reference": outcome.reference,
        "interval": outcome.interval,
        "claim": outcome.claim.size(),
        "detects": outcome.minimum_detectable_effect(),
        "worst": outcome.worst,
    })
}
