//! The report of the benchmark, in Markdown.

use std::fmt::Write;

use super::figures::{ALL_PAGES, PageFigures, growth_per_decade};
use super::load::{RequestPace, Timing};
use super::school::{ITEMS, RESPONSES};

/// The measurements of one school.
pub(super) struct MeasuredSchool {
    /// Attempts of the generated crowd.
    pub attempts: u32,
    /// Trainees of the generated crowd.
    pub trainees: u32,
    /// Name and version of the database engine.
    pub engine: String,
    /// Size of the database, in bytes.
    pub database_bytes: i64,
    /// Time that the service took to start, in s.
    pub started_in_s: f64,
    /// Duration of the database check after the start, in s.
    pub checked_in_s: f64,
    /// Peak resident memory of the service, in bytes.
    pub peak_bytes: u64,
    /// The pages: role and route.
    pub pages: Vec<(&'static str, String)>,
    /// Routes of pages that no visitor reached.
    pub unseen: Vec<String>,
    /// Every request.
    pub timings: Vec<Timing>,
    /// Results of a survey with many answers, requested separately.
    pub results: Vec<Timing>,
    /// The file of all attempts, requested separately.
    pub all_attempts: Vec<Timing>,
    /// The file of the audit log, requested separately.
    pub audit_log: Vec<Timing>,
}

/// Formats one figure of a school.
type SchoolFigure<'a> = dyn Fn(&MeasuredSchool) -> Option<String> + 'a;

/// Returns the durations of requests, in ms, in ascending order.
fn ordered_ms<'a>(timings: impl IntoIterator<Item = &'a Timing>) -> Vec<f64> {
    let mut took: Vec<f64> = timings.into_iter().map(|timing| timing.took.as_secs_f64() * 1e3).collect();
    took.sort_by(f64::total_cmp);
    took
}

/// Returns the median duration of requests, in ms.
fn median_ms(timings: &[Timing]) -> Option<f64> {
    quantile(&ordered_ms(timings), 0.5)
}

/// Returns a quantile of sorted values: the smallest value that at least the given share does not
/// exceed.
fn quantile(ordered: &[f64], share: f64) -> Option<f64> {
    ordered.get(((ordered.len() as f64 * share).ceil() as usize).saturating_sub(1)).copied()
}

impl MeasuredSchool {
    /// Returns the figures of all pages together, followed by those of each page.
    pub(super) fn figures(&self) -> Vec<PageFigures> {
        let of_all = self.figures_of("", ALL_PAGES, self.timings.iter());
        let of_pages = self.pages.iter().enumerate().filter_map(|(place, (role, route))| {
            self.figures_of(role, route, self.timings.iter().filter(move |timing| timing.page == place))
        });
        of_all.into_iter().chain(of_pages).collect()
    }

    fn figures_of<'a>(
        &self,
        seen_by: &str,
        page: &str,
        timings: impl Iterator<Item = &'a Timing>,
    ) -> Option<PageFigures> {
        let timings: Vec<&Timing> = timings.collect();
        let took = ordered_ms(timings.iter().copied());
        let bytes = timings.iter().map(|timing| timing.bytes).sum::<usize>();
        Some(PageFigures {
            engine: self.engine.clone(),
            attempts: self.attempts,
            page: page.to_owned(),
            seen_by: seen_by.to_owned(),
            requests: timings.len(),
            kilobytes: bytes as f64 / 1e3 / timings.len() as f64,
            p50_ms: quantile(&took, 0.5)?,
            p99_ms: quantile(&took, 0.99)?,
        })
    }
}

/// Returns the report on several schools of one engine, compared with another engine where its
/// figures are given. `figures` are the figures of `measured`.
///
/// # Errors
/// Never: writing to a `String` cannot fail.
pub(super) fn write_report(
    measured: &[MeasuredSchool],
    figures: &[PageFigures],
    others: &[PageFigures],
    pace: RequestPace,
) -> Result<String, std::fmt::Error> {
    let mut text = head_of_report(pace);
    write_schools(&mut text, measured, figures)?;
    write_comparison(&mut text, figures, others)?;
    write_page_times(&mut text, measured, figures)?;
    write_unseen_pages(&mut text, measured)?;
    Ok(text)
}

/// Returns the first line of a report, which identifies the command and the version.
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
         until its answer was there whole, compressed; the program that asks takes its share of the same processor, and so does a \
         database's server.\n\n\
         The schools are generated: cohorts of 30, an instructor for four of them, 100 attempts of each trainee over three \
         years, each with score and sums, beside assignments, questions, reviews, and a demonstration school of really \
         simulated attempts. All generated attempts share one recording; a trainee's latest at each exercise and one in ten of \
         the others have metrics, and one in fifty has a curve. The results of a survey with {RESPONSES} answers are asked for by \
         themselves, one after the other, and so are the files of all attempts (of up to a million) and of the audit log. Nothing is \
         asked for before the service has looked through its database, which it does beside serving after each start.\n\n"
    )
}

/// Writes the table of figures per school.
fn write_schools(text: &mut String, measured: &[MeasuredSchool], figures: &[PageFigures]) -> std::fmt::Result {
    let titles: String =
        measured.iter().map(|school| format!(" {} attempts |", group_thousands(school.attempts))).collect();
    let lines: String = measured.iter().map(|_| "---|").collect();
    write!(text, "| |{titles} bar |\n|---|{lines}---|\n")?;
    let of_all = |school: &MeasuredSchool| {
        figures.iter().find(|figure| figure.page == ALL_PAGES && figure.attempts == school.attempts)
    };
    let seconds = |timings: &[Timing]| median_ms(timings).map(|ms| format!("{:.1}", ms / 1e3));
    let results = format!("results of {RESPONSES} responses to {ITEMS} items, p50, ms");
    let rows: [(&str, &SchoolFigure<'_>, &str); 12] = [
        ("kept by", &|school| Some(school.engine.clone()), ""),
        ("trainees", &|school| Some(group_thousands(school.trainees)), ""),
        ("requests", &|school| Some(school.timings.len().to_string()), ""),
        ("all pages, p50, ms", &|school| Some(format!("{:.1}", of_all(school)?.p50_ms)), "≤ 25"),
        ("all pages, p99, ms", &|school| Some(format!("{:.1}", of_all(school)?.p99_ms)), "≤ 150"),
        ("peak memory of the service, MB", &|school| Some(format!("{:.0}", school.peak_bytes as f64 / 1e6)), "≤ 300"),
        (&results, &|school| Some(format!("{:.1}", median_ms(&school.results)?)), "≤ 300"),
        ("all attempts as a file, s", &|school| seconds(&school.all_attempts), ""),
        ("the audit log as a file, s", &|school| seconds(&school.audit_log), ""),
        ("database, MB", &|school| Some(format!("{:.0}", school.database_bytes as f64 / 1e6)), ""),
        ("start of the service, s", &|school| Some(format!("{:.1}", school.started_in_s)), "≤ 2"),
        ("check of the database beside serving, s", &|school| Some(format!("{:.0}", school.checked_in_s)), ""),
    ];
    for (what, figure, bar) in rows {
        let values: String =
            measured.iter().map(|school| format!(" {} |", figure(school).unwrap_or_default())).collect();
        writeln!(text, "| {what} |{values} {bar} |")?;
    }
    Ok(())
}

/// Writes a comparison with another engine, for schools of equal size measured on both.
fn write_comparison(text: &mut String, ours: &[PageFigures], theirs: &[PageFigures]) -> std::fmt::Result {
    let pairs: Vec<_> =
        ours.iter().filter_map(|our| Some((our, theirs.iter().find(|their| their.matches(our))?))).collect();
    let Some((_, first)) = pairs.first() else { return Ok(()) };
    write!(
        text,
        "\n## Beside {}\n\n| attempts | p50, ms | there | ratio | p99, ms | there | page with the largest ratio of medians |\n\
         |---|---|---|---|---|---|---|\n",
        first.engine
    )?;
    for (our, their) in pairs.iter().filter(|(our, _)| our.page == ALL_PAGES) {
        let ratio = |(our, their): &&(&PageFigures, &PageFigures)| our.p50_ms / their.p50_ms;
        let of_school = pairs.iter().filter(|(page, _)| page.attempts == our.attempts && page.page != ALL_PAGES);
        let Some(worst) = of_school.max_by(|one, other| ratio(one).total_cmp(&ratio(other))) else { continue };
        writeln!(
            text,
            "| {} | {:.1} | {:.1} | {:.2} | {:.1} | {:.1} | `{}` by {}: {:.1} to {:.1} |",
            group_thousands(our.attempts),
            our.p50_ms,
            their.p50_ms,
            our.p50_ms / their.p50_ms,
            our.p99_ms,
            their.p99_ms,
            worst.0.page,
            worst.0.seen_by,
            worst.0.p50_ms,
            worst.1.p50_ms,
        )?;
    }
    Ok(())
}

/// Writes the times of each page on every school, slowest first on the largest school.
fn write_page_times(text: &mut String, measured: &[MeasuredSchool], figures: &[PageFigures]) -> std::fmt::Result {
    let Some(largest) = measured.last() else { return Ok(()) };
    let titles = |what: &str| -> String {
        measured.iter().map(|school| format!(" {what} at {} |", group_thousands(school.attempts))).collect()
    };
    let lines: String = measured.iter().map(|_| "---|---|").collect();
    write!(
        text,
        "\nThe last column is how often as long a median takes where the attempts are ten times as many: the power law through all \
         sizes.\n\n| page | seen by | kB |{}{} tenfold |\n|---|---|---|{lines}---|\n",
        titles("p50, ms"),
        titles("p99, ms")
    )?;
    let mut rows: Vec<&PageFigures> = figures.iter().filter(|figure| figure.attempts == largest.attempts).collect();
    rows.sort_by(|a, b| b.p50_ms.total_cmp(&a.p50_ms));
    for row in rows {
        let of_page: Vec<&PageFigures> = figures.iter().filter(|figure| figure.is_same_page(row)).collect();
        let cells = |time: fn(&PageFigures) -> f64| -> String {
            measured
                .iter()
                .map(|school| of_page.iter().find(|figure| figure.attempts == school.attempts))
                .map(|figure| figure.map_or(" |".to_owned(), |figure| format!(" {:.1} |", time(figure))))
                .collect()
        };
        let page = if row.page == ALL_PAGES { ALL_PAGES.to_owned() } else { format!("`{}`", row.page) };
        let grown = growth_per_decade(&of_page).map_or(String::new(), |grown| format!("{grown:.2}"));
        let (p50, p99) = (cells(|figure| figure.p50_ms), cells(|figure| figure.p99_ms));
        writeln!(text, "| {page} | {} | {:.1} |{p50}{p99} {grown} |", row.seen_by, row.kilobytes)?;
    }
    Ok(())
}

fn write_unseen_pages(text: &mut String, measured: &[MeasuredSchool]) -> std::fmt::Result {
    let Some(largest) = measured.last().filter(|school| !school.unseen.is_empty()) else { return Ok(()) };
    let routes: Vec<String> = largest.unseen.iter().map(|route| format!("`{route}`")).collect();
    writeln!(text, "\nNot measured, for no link leads there: {}.", routes.join(", "))
}

/// Formats a number with its digits in groups of three.
fn group_thousands(number: u32) -> String {
    let digits = number.to_string();
    let parts: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|part| std::str::from_utf8(part).ok()).collect();
    parts.join(" ")
}

/// Returns processor, threads and operating system.
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
    fn the_committed_reports_are_of_this_program() {
        let reports =
            [include_str!("../../../bench/pages-sqlite.md"), include_str!("../../../bench/pages-postgresql.md")];
        for report in reports {
            assert!(is_of_this_program(report), "measure anew, with a release build");
            assert!(!is_of_this_program(&report.replace(env!("CARGO_PKG_VERSION"), "0.0.9")));
            assert!(!is_of_this_program(&report.replace("release build", "debug build")));
        }
    }
}
