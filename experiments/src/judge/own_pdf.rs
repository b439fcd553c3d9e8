//! Samples judged by their own column of pdfs.

use whitefurnace::error::Error;
use whitefurnace::harness::directions::Precision;
use whitefurnace::harness::directions::own_pdf::OwnPdfs;

use super::{Columns, Judge, Judgement, each_row};

/// Least margin, percent. Neighbours show a jump or a heavy tail of a density to some three
/// percent.
const MIN_MARGIN: f64 = 4.0;

/// Tests a file's samples by their own pdfs.
///
/// # Errors
/// [`Error::File`] or [`Error::Option`], the latter for a margin below 4 % and for a file without a
/// column of pdfs.
pub(super) fn judge(
    options: &Judge,
    columns: Option<Columns>,
    precision: Precision,
) -> Result<Judgement, Error> {
    if options.margin < MIN_MARGIN {
        return Err(Error::Option(format!(
            "--margin {} is too small for --own-pdf, which tells a jump of the density to no less than {MIN_MARGIN} %: \
             take {MIN_MARGIN} or more, or state the --density",
            options.margin
        )));
    }
    let mut own = options.covers.map_or_else(
        || OwnPdfs::new(precision),
        |domain| OwnPdfs::covering(precision, domain.into()),
    );
    let columns = each_row(&options.samples, columns, &mut |columns, row| {
        let sample = columns.sample(row.numbers, &precision)?;
        let pdf = sample.pdf.ok_or(
            "--own-pdf needs a column pdf: name it by --columns, as in x,y,z,-,pdf, or state the --density",
        )?;
        own.push(sample.direction, pdf);
        Ok(())
    })?;
    Ok(Judgement {
        columns,
        mean_weight: None,
        outcomes: own.outcomes(options.margin / 100.0),
    })
}
