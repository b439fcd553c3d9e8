//! Plots the data file that a failing trial wrote.

use experiments::print_line;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use experiments::plot::trial_cells;
use experiments::run::cli::{self, Ending};
use whitefurnace::error::Error;

/// Plot the cells of a failed trial: residuals in standard deviations, expected and observed
/// values.
#[derive(Parser)]
#[command(name = "plot-cells", version)]
struct PlotCells {
    /// The data file: place,expected,observed,sigmas
    #[arg(value_name = "FILE.csv")]
    file: PathBuf,
    /// The plot [default: the data file's name with .svg]
    #[arg(long, value_name = "FILE.svg")]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    cli::start(|| cli::exit(run(&cli::parse())))
}

fn run(options: &PlotCells) -> Result<Ending, Error> {
    let out = options
        .out
        .clone()
        .unwrap_or_else(|| options.file.with_extension("svg"));
    if out.extension().is_none_or(|extension| extension != "svg") {
        return Err(Error::Option(format!(
            "--out {} must end in .svg",
            out.display()
        )));
    }
    let cells = trial_cells::read(&options.file)?;
    trial_cells::plot(
        &cells,
        &options
            .file
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy(),
        &out,
    )?;
    print_line!("{} cells: {}", cells.len(), out.display());
    Ok(Ending::Done)
}
