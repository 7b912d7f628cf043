//! The head of every report: the command that makes it, the versions of the measured parts, and the
//! machine. A test compares the committed reports with it, so that none becomes outdated.

use assessment::catalogue::DEFINITIONS;
use law::Judging;
use law::axial::ForceLaw;

use super::Subject;
use crate::machine::{self, Machine};

/// Version of the error estimate. Later versions change which field an attempt uses, but not the
/// estimate.
const ESTIMATES: Judging = Judging::Second;

/// A part with its own version, in addition to the program's.
#[derive(Clone, Copy)]
enum Versioned {
    Law,
    Estimates,
    /// A changed metric is added as a new version, so the number of definitions serves as the
    /// version.
    Metrics,
}

impl Versioned {
    fn now(self) -> String {
        match self {
            Self::Law => format!("law {}", u32::from(ForceLaw::default())),
            Self::Estimates => format!("estimates {}", ESTIMATES.number()),
            Self::Metrics => format!("{} metrics", DEFINITIONS.len()),
        }
    }
}

/// Returns the versioned parts that a report measures.
fn measured(what: Subject) -> &'static [Versioned] {
    match what {
        Subject::Render | Subject::Anatomy => &[],
        Subject::Field | Subject::Estimates | Subject::Lumps => &[Versioned::Estimates],
        Subject::HardCases => &[Versioned::Law, Versioned::Estimates],
        Subject::Metrics => &[Versioned::Law, Versioned::Metrics],
        Subject::Force
        | Subject::Coupling
        | Subject::Recording
        | Subject::Servo
        | Subject::Hiccup
        | Subject::Soak
        | Subject::Operators
        | Subject::Calibrate => &[Versioned::Law],
    }
}

/// Returns the command and the versions with which a report of the program `program` must begin.
fn made_by(what: Subject, options: &str, program: &str) -> String {
    let versions: String = measured(what).iter().map(|part| format!(", {}", part.now())).collect();
    format!("Measured by `stylet bench {}{options} --out DIR` with {program}{versions} on ", what.name())
}

/// Returns the head of a report, below its title.
pub fn measured_by(what: Subject, options: &str, quick: bool) -> String {
    let (options, shortened) = match quick {
        true => (format!("{options} --quick"), " **Shortened to a hundredth: not to be reported.**"),
        false => (options.to_owned(), ""),
    };
    format!("{}{}.{shortened}", made_by(what, &options, &machine::program()), Machine::this().in_words())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use super::super::{Subject, field};
    use super::*;

    const RELEASE: &str = concat!("stylet ", env!("CARGO_PKG_VERSION"), " (release build)");

    fn committed() -> PathBuf {
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("reports")
    }

    /// Committed reports are complete, and that of the tissue includes other solvers.
    fn options(what: Subject) -> &'static str {
        if what == Subject::Field { field::BESIDE } else { "" }
    }

    /// Returns why a report does not belong to a release build of this program; `None` if it does.
    fn stale(what: Subject, report: &str) -> Option<String> {
        let wanted = made_by(what, options(what), RELEASE);
        let head = report.lines().nth(2).unwrap_or_default();
        (!head.starts_with(&wanted)).then(|| format!("{}.md: '{head}' should begin '{wanted}'", what.name()))
    }

    #[test]
    fn committed_reports_match_the_current_versions() {
        let found = Subject::ALL.iter().filter_map(|what| {
            let file = committed().join(format!("{}.md", what.name()));
            match fs::read_to_string(&file) {
                Ok(report) => stale(*what, &report),
                Err(error) => Some(format!("{}: {error}", file.display())),
            }
        });
        let found: Vec<String> = found.collect();
        assert!(found.is_empty(), "measure anew, with a release build:\n{}", found.join("\n"));
    }

    #[test]
    fn every_committed_figure_is_of_this_program() {
        let files = fs::read_dir(committed()).expect("the reports").map(|entry| entry.expect("a file").path());
        let figures: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|name| name == "svg")).collect();
        assert!(figures.len() > 10, "{figures:?}");
        for figure in figures {
            let svg = fs::read_to_string(&figure).expect("a figure");
            assert!(
                svg.contains(&format!(">{RELEASE}, ")),
                "{} does not say that it is of {RELEASE}",
                figure.display()
            );
        }
    }

    #[test]
    fn report_of_another_version_build_or_command_is_stale() {
        let today = format!("# Force law\n\n{}some machine.\n", made_by(Subject::Force, "", RELEASE));
        assert_eq!(stale(Subject::Force, &today), None);
        let law = Versioned::Law.now();
        for (now, then) in [
            (law.as_str(), "law 1"),
            (env!("CARGO_PKG_VERSION"), "0.0.9"),
            ("release", "debug"),
            ("force --out", "force --quick --out"),
            ("stylet bench", "bench"),
        ] {
            let old = today.replace(now, then);
            assert!(old != today && stale(Subject::Force, &old).is_some(), "{then}");
        }
        assert!(stale(Subject::Metrics, &today).is_some() && stale(Subject::Force, "").is_some());
        let metrics = format!("# Metrics\n\n{}a machine.\n", made_by(Subject::Metrics, "", RELEASE));
        assert_eq!(stale(Subject::Metrics, &metrics), None);
        let fewer = metrics.replace(&Versioned::Metrics.now(), "3 metrics");
        assert!(stale(Subject::Metrics, &fewer).is_some(), "{fewer}");
    }
}
