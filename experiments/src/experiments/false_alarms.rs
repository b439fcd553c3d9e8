//! False-alarm rate of `cargo test` on a correct build, under many master seeds.

use whitefurnace::harness::tails::binomial_interval;

use crate::experiments::prelude::*;
use crate::experiments::suite_seeds::{Answer, FAULTS_SEED_STRIDE, Measure, Mutants, SuiteSeeds};

pub(super) const FALSE_ALARMS: Experiment = Experiment {
    id: "false-alarms",
    title: "the whole suite under fresh master seeds (accumulates over runs)",
    headline: "{fails %d} false rejections in {tests %d} tests of correct subjects under {seeds %d} seeds",
    version: 3,
    equations: &[],
    run,
};

const COLUMNS: &str = "replication,holds,fails,undecided,exact,random,smallest_p,where,\
                       faults,rejected,faults_red,red";

fn run(run: &mut Run) -> Result<(), Error> {
    let suite = SuiteSeeds::open(run)?;
    run.add_equations_of(&suite.trials);
    let (version, seed, scale, trials) = (
        FALSE_ALARMS.version,
        run.seed(),
        suite.scale,
        suite.trials.len(),
    );
    let key =
        format!("false-alarms version {version}, seed {seed}, scale {scale}, {trials} trials");
    let mut accumulated = run.accumulated("false-alarms.csv", &key, COLUMNS)?;
    let first = accumulated.next();
    let seeds = run.count(run.by_tier(2, 200));
    let bar = Bar::new("", seeds, "seeds");
    for k in first..first + seeds {
        accumulated.push(k, &fields(&suite.subjects(k)?, &suite.mutants(k)?));
        bar.advance(1);
    }
    let level = accumulated.look(FAMILYWISE_LEVEL);
    accumulated.write()?;
    report(run, &accumulated, suite.scale, level);
    draw(run, &accumulated)
}

/// Returns the fields of a seed. The p-values compared are those of exact claims whose tail is
/// valid at this scale: for an approximate claim the hypothesis of equality need not be true.
fn fields(subjects: &[Measure], mutants: &Mutants) -> Vec<String> {
    let measures = || subjects.iter().chain(&mutants.equivalents);
    let count = |wanted: Judgement| {
        measures()
            .filter(|measure| measure.verdict == wanted)
            .count()
            .to_string()
    };
    let fails = |measure: &&Measure| measure.verdict == Judgement::Fails;
    let compared = || {
        measures().filter(|measure| {
            measure.random && !measure.approximate && measure.n >= measure.valid_from
        })
    };
    let smallest = compared().min_by(|a, b| a.p.total_cmp(&b.p));
    let answers = |wanted: Answer| {
        mutants
            .faults
            .iter()
            .filter(|(_, answer)| *answer == wanted)
            .map(|(name, _)| name.as_str())
            .collect::<Vec<_>>()
    };
    let mut red: Vec<&str> = measures().filter(fails).map(|m| m.name.as_str()).collect();
    red.extend(answers(Answer::Red));
    vec![
        count(Judgement::Holds),
        count(Judgement::Fails),
        count(Judgement::Undecided),
        measures()
            .filter(|measure| !measure.random)
            .count()
            .to_string(),
        compared().count().to_string(),
        smallest.map_or(1.0, |measure| measure.p).to_string(),
        smallest
            .map_or("", |measure| &measure.name)
            .replace(',', ";"),
        mutants.faults.len().to_string(),
        answers(Answer::Rejected).len().to_string(),
        answers(Answer::Red).len().to_string(),
        red.join("; ").replace(',', ";"),
    ]
}

/// Judges all suites at `level`, the share of this look.
fn report(run: &mut Run, accumulated: &Accumulated, scale: f64, level: f64) {
    let seeds = accumulated.rows().len() as f64;
    let sum = |column| accumulated.numbers(column).sum::<f64>();
    let [holds, fails, undecided] = ["holds", "fails", "undecided"].map(sum);
    let [exact, random] = ["exact", "random"].map(sum);
    let [faults, rejected, faults_red] = ["faults", "rejected", "faults_red"].map(sum);
    let bound = ALPHA * CAPACITY as f64;
    let names: Vec<&str> = accumulated
        .column("red")
        .filter(|names| !names.is_empty())
        .collect();
    // With 95 % confidence, and without approximation for a count of 0.
    let below = |k: f64, n: f64| binomial_interval(k as u64, n as u64, 0.05)[1];
    let rate = below(names.len() as f64, seeds);
    let each = below(fails, random);
    for (key, value) in [
        ("seeds", seeds),
        ("scale_divides_by", 1.0 / scale),
        ("fails", fails + faults_red),
        ("tests", random),
        ("exact", exact),
        ("undecided", undecided),
        ("holds", holds),
        ("faults", faults),
        ("faults_rejected", rejected),
        ("bound", bound),
        ("rate_below", rate),
        ("each_below", each),
    ] {
        run.number(key, value);
    }
    let mut value = format!(
        "{} of {seeds} at scale {scale}, bound {bound:.0e} each (look {} of {FAMILYWISE_LEVEL:.0e} for all); the rate is \
         below {rate:.3} with 95 % confidence",
        names.len(),
        accumulated.looks()
    );
    if !names.is_empty() {
        value += &format!(": {}", names.join("; "));
    }
    run.claim("suites with a false statement", value, names.is_empty());
    let value = format!(
        "false rejections of correct subjects and equivalent mutants at this scale: of {random} tests whose tail \
         is valid here, below {each:.1e} each, and of {exact} identities at their full arguments. Not the \
         1e-9 of each, which is theirs by their tails; nor what stays undecided at full size, which the \
         guard excludes"
    );
    run.note("what that bounds", value);
    let value = format!(
        "{faults} under every {FAULTS_SEED_STRIDE}th seed: {rejected} rejected, {} not yet at this scale, \
         {faults_red} accepted or rejected for a number that is none",
        faults - rejected - faults_red
    );
    run.note("faults", value);
    let value =
        "calibration, which `calibration` measures at length; check-ups of BSDFs that are not the program's own"
            .to_owned();
    run.note("not among them", value);
    let smallest = accumulated.numbers("smallest_p").fold(1.0, f64::min);
    // P(least of m p-values ≤ x) ≤ m x, under any dependence.
    let chance = (random * smallest).min(1.0);
    run.number("smallest_p", smallest);
    run.claim(
        "least p-value of all",
        format!(
            "{smallest:.2e} of {random} tests of exact claims whose tail is valid at this scale, about {:.1e} \
             expected; so small with probability at most {chance:.3}",
            1.0 / random
        ),
        chance >= level,
    );
    run.note(
        "undecided",
        format!("{:.1} measures per seed at this scale", undecided / seeds),
    );
}

/// Draws each seed's least p-value against the quantile that independent tests would give it.
fn draw(run: &mut Run, accumulated: &Accumulated) -> Result<(), Error> {
    let mut least: Vec<f64> = accumulated.numbers("smallest_p").collect();
    least.sort_by(f64::total_cmp);
    let seeds = least.len() as f64;
    // The number of valid tails differs a little from seed to seed.
    let random = (accumulated.numbers("random").sum::<f64>() / seeds)
        .round()
        .max(1.0);
    let expected = |i: usize| 1.0 - (1.0 - (i as f64 + 0.5) / seeds).powf(1.0 / random);
    let points = least.iter().enumerate().map(|(i, &p)| [expected(i), p]);
    let low = 0.1 / (random * seeds);
    let series = vec![
        Series::new("as expected", 6, Mark::Line, [[low, low], [0.1, 0.1]]),
        Series::new("a suite under a fresh master seed", 2, Mark::Points, points),
    ];
    let title = format!("Least p-value of each of {seeds} suites of {random} random tests");
    let axes = [
        "expected of independent tests at this rank",
        "least p-value observed",
    ];
    let chart = Chart::new(
        title,
        axes,
        [[low, 0.1], [low.min(0.5 * least[0]), 1.0]],
        series,
    )
    .log([true, true]);
    let description =
        "Points along the line: least p-values as independent tests of true hypotheses give.";
    charts(run, "false-alarms.svg", description, 560, &[chart])
}
