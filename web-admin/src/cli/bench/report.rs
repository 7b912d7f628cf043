//! The report, in Markdown.

use std::fmt::Write;

use super::load::{RequestPace, Timing};
use super::school::{ITEMS, RESPONSES};

/// What was measured on one school.
pub(super) struct MeasuredSchool {
    /// Attempts of the crowd.
    pub attempts: u32,
    /// Its trainees.
    pub trainees: u32,
    /// What keeps the database.
    pub engine: String,
    /// Size of the database, in bytes.
    pub database_bytes: i64,
    /// How long the service took to start, in s.
    pub started_in_s: f64,
    /// The most memory that the service had resident, in bytes.
    pub peak_bytes: u64,
    /// The pages: role and route.
    pub pages: Vec<(&'static str, String)>,
    /// Routes of pages that nobody came to.
    pub unseen: Vec<String>,
    /// Every request.
    pub timings: Vec<Timing>,
    /// Results of a survey with many answers, asked for by themselves.
    pub results: Vec<Timing>,
    /// The file of all attempts, asked for by itself.
    pub all_attempts: Vec<Timing>,
    /// The file of the audit log, likewise.
    pub audit_log: Vec<Timing>,
}

/// A figure of a school, in words.
type SchoolFigure = fn(&MeasuredSchool) -> Option<String>;

/// Times of some requests, in ms, and the size of the answers.
struct RequestTimes {
    p50: f64,
    p99: f64,
    bytes: usize,
}

impl RequestTimes {
    fn of(timings: impl Iterator<Item = Timing>) -> Option<Self> {
        let mut timings: Vec<Timing> = timings.collect();
        timings.sort_by_key(|timing| timing.took);
        let at = |share: f64| timings.get(((timings.len() as f64 * share).ceil() as usize).saturating_sub(1));
        let ms = |share: f64| at(share).map(|timing| timing.took.as_secs_f64() * 1e3);
        let bytes = timings.iter().map(|timing| timing.bytes).sum::<usize>() / timings.len().max(1);
        Some(Self { p50: ms(0.5)?, p99: ms(0.99)?, bytes })
    }
}

impl MeasuredSchool {
    fn all(&self) -> Option<RequestTimes> {
        RequestTimes::of(self.timings.iter().copied())
    }

    fn page(&self, role: &str, route: &str) -> Option<RequestTimes> {
        let place = self.pages.iter().position(|page| page.0 == role && page.1 == route)?;
        RequestTimes::of(self.timings.iter().filter(|timing| timing.page == place).copied())
    }
}

/// The report on several schools.
///
/// # Errors
/// Never: a text takes whatever is written to it.
pub(super) fn write_report(measured: &[MeasuredSchool], pace: RequestPace) -> Result<String, std::fmt::Error> {
    let mut text = head_of_report(pace);
    let titles: String =
        measured.iter().map(|school| format!(" {} attempts |", group_thousands(school.attempts))).collect();
    let lines: String = measured.iter().map(|_| "---|").collect();
    write!(text, "| |{titles} bar |\n|---|{lines}---|\n")?;
    let results = format!("results of {RESPONSES} responses to {ITEMS} items, p50, ms");
    let figures: [(&str, SchoolFigure, &str); 11] = [
        ("kept by", |school| Some(school.engine.clone()), ""),
        ("trainees", |school| Some(group_thousands(school.trainees)), ""),
        ("requests", |school| Some(school.timings.len().to_string()), ""),
        ("all pages, p50, ms", |school| Some(format!("{:.1}", school.all()?.p50)), "≤ 25"),
        ("all pages, p99, ms", |school| Some(format!("{:.1}", school.all()?.p99)), "≤ 150"),
        ("peak memory, MB", |school| Some(format!("{:.0}", school.peak_bytes as f64 / 1e6)), "≤ 300"),
        (&results, |school| Some(format!("{:.1}", RequestTimes::of(school.results.iter().copied())?.p50)), "≤ 300"),
        (
            "all attempts as a file, s",
            |school| Some(format!("{:.1}", RequestTimes::of(school.all_attempts.iter().copied())?.p50 / 1e3)),
            "",
        ),
        (
            "the audit log as a file, s",
            |school| Some(format!("{:.1}", RequestTimes::of(school.audit_log.iter().copied())?.p50 / 1e3)),
            "",
        ),
        ("database, MB", |school| Some(format!("{:.0}", school.database_bytes as f64 / 1e6)), ""),
        ("start of the service, s", |school| Some(format!("{:.1}", school.started_in_s)), ""),
    ];
    for (what, figure, bar) in figures {
        let values: String =
            measured.iter().map(|school| format!(" {} |", figure(school).unwrap_or_default())).collect();
        writeln!(text, "| {what} |{values} {bar} |")?;
    }
    write_page_times(&mut text, measured)?;
    write_unseen_pages(&mut text, measured)?;
    Ok(text)
}

/// The command and the version: what a report must say first to be of this program.
fn first_line_of_report(profile: &str) -> String {
    let version = env!("CARGO_PKG_VERSION");
    format!("Measured by `web-admin bench --data-dir DIR --out DIR` with web-admin {version} ({profile} build) on ")
}

fn head_of_report(pace: RequestPace) -> String {
    let (made_by, machine) =
        (first_line_of_report(if cfg!(debug_assertions) { "debug" } else { "release" }), describe_machine());
    let RequestPace { rate, seconds } = pace;
    format!(
        "# Pages\n\n\
         {made_by}{machine}: {rate} requests a second \
         for {seconds} s, every page in turn, whether or not the answers kept up. A time is from the moment a request was due \
         until its answer was there whole, compressed; the program that asks takes its share of the same processor.\n\n\
         The schools are generated: cohorts of 30, an instructor for four of them, 100 attempts of each trainee over three \
         years, each with score and sums, beside assignments, questions, reviews, and a demonstration school of really \
         simulated attempts. All generated attempts share one recording; a trainee's latest at each exercise and one in ten of \
         the others have metrics, and one in fifty has a curve. The results of a survey with {RESPONSES} answers are asked for by \
         themselves, one after the other, and so are the files of all attempts and of the audit log.\n\n"
    )
}

/// Each page on every school, the slowest first.
fn write_page_times(text: &mut String, measured: &[MeasuredSchool]) -> std::fmt::Result {
    let Some(largest) = measured.last() else { return Ok(()) };
    let titles = |what: &str| -> String {
        measured.iter().map(|school| format!(" {what} at {} |", group_thousands(school.attempts))).collect()
    };
    let lines: String = measured.iter().map(|_| "---|---|").collect();
    write!(text, "\n| page | seen by | kB |{}{}\n|---|---|---|{lines}\n", titles("p50, ms"), titles("p99, ms"))?;
    let mut rows: Vec<_> =
        largest.pages.iter().filter_map(|page| Some((page, largest.page(page.0, &page.1)?))).collect();
    rows.sort_by(|(_, a), (_, b)| b.p50.total_cmp(&a.p50));
    for ((role, route), times) in rows {
        let figures = |figure: fn(RequestTimes) -> f64| -> String {
            measured
                .iter()
                .map(|school| school.page(role, route).map_or(" |".to_owned(), |t| format!(" {:.1} |", figure(t))))
                .collect()
        };
        let kilobytes = times.bytes as f64 / 1e3;
        writeln!(text, "| `{route}` | {role} | {kilobytes:.1} |{}{}", figures(|t| t.p50), figures(|t| t.p99))?;
    }
    Ok(())
}

fn write_unseen_pages(text: &mut String, measured: &[MeasuredSchool]) -> std::fmt::Result {
    let Some(largest) = measured.last().filter(|school| !school.unseen.is_empty()) else { return Ok(()) };
    let routes: Vec<String> = largest.unseen.iter().map(|route| format!("`{route}`")).collect();
    writeln!(text, "\nNot measured, for no link leads there: {}.", routes.join(", "))
}

/// A number with its thousands apart.
fn group_thousands(number: u32) -> String {
    let digits = number.to_string();
    let parts: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|part| std::str::from_utf8(part).ok()).collect();
    parts.join(" ")
}

/// Processor, threads and system.
fn describe_machine() -> String {
    let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = information.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or("an unknown processor", |(_, name)| name.trim());
    let threads = std::thread::available_parallelism().map_or(0, usize::from);
    format!("{model}, {threads} threads, {} {}", std::env::consts::OS, std::env::consts::ARCH)
}

#[cfg(test)]
mod tests {
    use super::first_line_of_report;

    fn is_of_this_program(report: &str) -> bool {
        report.lines().nth(2).is_some_and(|head| head.starts_with(&first_line_of_report("release")))
    }

    #[test]
    fn the_committed_report_is_of_this_program() {
        let report = include_str!("../../../bench/pages.md");
        assert!(is_of_this_program(report), "measure anew, with a release build");
        assert!(!is_of_this_program(&report.replace(env!("CARGO_PKG_VERSION"), "0.0.9")));
        assert!(!is_of_this_program(&report.replace("release build", "debug build")));
    }
}
