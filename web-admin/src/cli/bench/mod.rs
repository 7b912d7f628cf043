//! `web-admin bench`: measures how fast every page is served, on a small school and on a large one.
//!
//! The service runs as a process of its own. Its pages are found by following links, as several
//! people of each role and as an anonymous visitor, so that a new page is measured as soon as it is
//! linked; pages without a link are opened beforehand. Then they are requested at a steady rate
//! that does not wait for responses.

mod doors;
mod figures;
mod load;
mod pages;
mod report;
mod school;
mod service;
mod visitor;

use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, value_parser};
use figures::PageFigures;
use load::RequestPace;
use pages::Tour;
use platform::config;
use platform::config::Config;
use report::MeasuredSchool;
use service::BenchService;
use store::DatabaseAddress;

use super::{CommandFailure, say_line};
use crate::demo::ATTEMPTS_EACH;

/// Password of every account of the generated schools.
const PASSWORD: &str = "a password for measurements";

/// CSV file of all attempts of a school: not a page, and its size grows with the number of
/// attempts.
const ALL_ATTEMPTS: &str = "/progress/attempts.csv";
/// CSV file of the audit log, excluded from the tour as well: the service limits how many such
/// files a school can generate at a time.
const AUDIT_LOG: &str = "/admin/audit.csv";

/// Largest school whose file of all attempts is requested: ten times as many attempts take a
/// quarter of an hour.
const MOST_IN_A_FILE: u32 = 1_000_000;

/// Number of consecutive requests for the results of a large survey.
const REPEATS: usize = 41;

/// Measure how fast pages are served, on generated schools, and write a report
///
/// The load is generated on this machine, so it takes some of the processor time that it measures.
/// Use a release build for figures to report.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  web-admin bench --data-dir /tmp/schools --out bench")]
pub struct BenchArgs {
    /// Folder for the generated schools, 6 GB at a million attempts; a school that exists already
    /// is measured again
    #[arg(long, value_name = "DIR")]
    data_dir: PathBuf,
    /// Database server or folder for the schools' databases, each created next to this database and
    /// named after its school [default: files in the data folder, or on this machine's server]
    #[arg(long, value_name = "URL", env = "STYLET_DATABASE", hide_env_values = true)]
    database: Option<String>,
    /// Folder for the report and its figures, pages-ENGINE.md and pages-ENGINE.csv; older files are
    /// replaced
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Figures of another engine, written by this command, to compare with
    #[arg(long, value_name = "FILE")]
    beside: Option<PathBuf>,
    /// Attempts in each school, a hundred per trainee; separated by commas
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [10_000, 1_000_000],
        value_parser = value_parser!(u32).range(3_000..=10_000_000))]
    attempts: Vec<u32>,
    /// Requests per second
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = value_parser!(u32).range(1..=10_000))]
    rate: u32,
    /// Duration of the load on each school, in s
    #[arg(long, value_name = "S", default_value_t = 120, value_parser = value_parser!(u32).range(1..=86_400))]
    seconds: u32,
}

pub(super) async fn run_bench(args: &BenchArgs) -> Result<(), CommandFailure> {
    std::fs::create_dir_all(&args.data_dir)?;
    std::fs::create_dir_all(&args.out)?;
    let others = args.beside.as_deref().map_or(Ok(Vec::new()), figures::read_figures)?;
    let place = match &args.database {
        Some(given) => config::database_address(given)?,
        None => DatabaseAddress::in_folder(&args.data_dir),
    };
    let pace = RequestPace { rate: args.rate, seconds: args.seconds };
    let mut measured = Vec::new();
    for attempts in &args.attempts {
        measured.push(measure_school(args, &place, *attempts, pace).await?);
    }
    let figures: Vec<PageFigures> = measured.iter().flat_map(MeasuredSchool::figures).collect();
    let report = report::write_report(&measured, &figures, &others, pace).map_err(anyhow::Error::from)?;
    let engine = measured.first().map_or("", |school| school.engine.split(' ').next().unwrap_or_default());
    let file = args.out.join(format!("pages-{}.md", engine.to_lowercase()));
    std::fs::write(&file, report)?;
    figures::write_figures(&file.with_extension("csv"), &figures)?;
    say_line(format_args!("{}", file.display()));
    Ok(())
}

async fn measure_school(
    args: &BenchArgs,
    place: &DatabaseAddress,
    attempts: u32,
    pace: RequestPace,
) -> anyhow::Result<MeasuredSchool> {
    let name = format!("attempts-{attempts}");
    let mut config = Config::in_folder(&args.data_dir.join(&name));
    config.database = place.sibling(&name)?;
    let trainees = attempts / ATTEMPTS_EACH;
    say_line(format_args!("{attempts} attempts: making the school"));
    let school = school::prepare_school(&config, trainees).await?;
    let service = BenchService::start(&config)?;
    say_line(format_args!("{attempts} attempts: checked while served, after a start of {:.1} s", service.started_in_s));
    let checked_in_s = service.wait_until_checked().await?;
    say_line(format_args!("{attempts} attempts: looking for pages, after a check of {checked_in_s:.0} s"));
    let visitors = visitor::sign_in(&service.url, trainees, school.doors).await?;
    let tour = Tour::take(&visitors, school.routes, &[&school.survey, ALL_ATTEMPTS, AUDIT_LOG]).await?;
    say_line(format_args!("{attempts} attempts: asking for {} pages", tour.pages.len()));
    let timings = load::ask_steadily(&visitors, &tour.pages, pace).await?;
    let results = format!("{}/results", school.survey);
    let administrator = visitors.iter().find(|visitor| visitor.role == "administrator").context("an administrator")?;
    let results = load::ask_repeatedly(administrator, &results, REPEATS).await?;
    let all_attempts =
        load::ask_repeatedly(administrator, ALL_ATTEMPTS, usize::from(attempts <= MOST_IN_A_FILE)).await?;
    let audit_log = load::ask_repeatedly(administrator, AUDIT_LOG, 1).await?;
    Ok(MeasuredSchool {
        attempts,
        trainees,
        engine: school.engine,
        database_bytes: school.database_bytes,
        started_in_s: service.started_in_s,
        checked_in_s,
        peak_bytes: service.peak_bytes()?,
        pages: tour.pages.into_iter().map(|page| (page.role, page.route)).collect(),
        unseen: tour.unseen,
        timings,
        results,
        all_attempts,
        audit_log,
    })
}
