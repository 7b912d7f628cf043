//! What a study finds.

use askama::Template;
use askama_web::WebTemplate;
use assessment::statistics::{Estimate, Summary};
use model::study::{StudyComparison, StudyFindings};
use model::survey::results::{EXPERTS, GroupValidity, ItemGroup, ItemResult, Results};

use crate::charts::{self, BoxRow, Extent, MeansLine};
use crate::survey::figures;
use crate::{Shell, format};

/// Rows that are shown at once: the score and the metrics that tell the groups apart most surely.
const SHOWN: usize = 11;

/// Metrics that are drawn, the score first.
const DRAWN: usize = 6;

/// The results of a study.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "study/results.html")]
pub struct StudyResultsPage {
    /// Frame.
    pub shell: Shell,
    /// The study's title.
    pub title: String,
    /// The study's page.
    pub href: String,
    /// The participants are a program's.
    pub generated: bool,
    /// Title and address of the results at each exercise, and whether they are shown.
    pub exercises: Vec<(String, String, bool)>,
    /// Names of the groups, and how many take part.
    pub groups: Vec<(String, usize)>,
    /// What was found at the exercise that is shown.
    pub findings: StudyFindings,
    /// What participants answered.
    pub surveys: Vec<StudySurveyBlock>,
}

/// What participants answered to an instrument.
#[derive(Debug)]
pub struct StudySurveyBlock {
    /// Its title.
    pub title: String,
    /// Its results as a survey.
    pub href: String,
    /// It was asked after the last attempt.
    pub at_end: bool,
    /// What was found.
    pub results: Results,
}

impl StudySurveyBlock {
    /// Items with figures.
    fn measured(&self) -> Vec<&ItemResult> {
        let has_figures = |item: &&ItemResult| item.groups.iter().any(|group| group.quartiles.value().is_some());
        self.results.items.iter().filter(has_figures).collect()
    }
}

impl StudyResultsPage {
    fn first_group(&self) -> &str {
        self.groups.first().map_or("", |(name, _)| name)
    }

    fn experts(&self) -> &str {
        self.groups.last().map_or("", |(name, _)| name)
    }

    /// The name of a group of answers: those of the last are judged as the experts'.
    fn name_of_group<'a>(&'a self, group: &'a str) -> &'a str {
        if [EXPERTS, "expert"].contains(&group) { self.experts() } else { group }
    }

    /// The score and the metrics that are shown at once.
    fn surest(&self) -> &[StudyComparison] {
        self.findings.comparisons.get(..SHOWN).unwrap_or(&self.findings.comparisons)
    }

    /// The metrics after them.
    fn others(&self) -> &[StudyComparison] {
        self.findings.comparisons.get(SHOWN..).unwrap_or_default()
    }

    /// Group by group, in the order of the study.
    fn answers_to(&self, item: &ItemResult) -> Vec<(&str, String)> {
        let words = |name: &str| {
            let found = item.groups.iter().find(|group| self.name_of_group(&group.group) == name);
            found.map_or_else(|| "–".to_owned(), |group| self.say_group(group))
        };
        self.groups.iter().map(|(name, _)| (name.as_str(), words(name))).collect()
    }

    fn say_group(&self, item: &ItemGroup) -> String {
        tr!("{figures}, n = {n}", figures = figures::say_quartiles(&item.quartiles), n = item.n)
    }

    fn say_validity(&self, found: &GroupValidity) -> String {
        figures::say_validity(&found.validity)
    }

    /// The score and the metrics that are drawn.
    fn drawn(&self) -> &[StudyComparison] {
        self.findings.comparisons.get(..DRAWN).unwrap_or(&self.findings.comparisons)
    }

    fn unit_of<'a>(&self, row: &'a StudyComparison) -> &'a str {
        if ["1", "count"].contains(&row.unit.as_str()) { "" } else { &row.unit }
    }

    /// A metric of each group as boxes, for both widths.
    fn draw_groups(&self, row: &StudyComparison, index: &usize) -> String {
        let names = self.groups.iter().map(|(name, _)| name);
        let rows: Vec<BoxRow> = names
            .zip(&row.groups)
            .map(|(name, found)| BoxRow {
                label: found
                    .as_ref()
                    .map_or_else(|| name.clone(), |found| tr!("{group}, n = {n}", group = name, n = found.n)),
                quartiles: found.as_ref().map(|found| (found.lower_quartile, found.median, found.upper_quartile)),
                ends: found.as_ref().map(|found| (found.min, found.max)),
                mean: None,
            })
            .collect();
        let ends = rows.iter().filter_map(|row| row.ends).flat_map(|(least, greatest)| [least, greatest]);
        let range = Extent::around(ends);
        charts::draw_both_widths(|size| charts::draw_boxes(&rows, range, &format!("groups-{index}"), &row.label, size))
    }

    /// The mean score of each group at each attempt, for both widths.
    fn draw_learning(&self) -> String {
        let line = |((name, _), means): (&(String, usize), &Vec<Option<Estimate>>)| MeansLine {
            label: name.clone(),
            means: means.clone(),
        };
        let lines: Vec<MeansLine> = self.groups.iter().zip(&self.findings.learning).map(line).collect();
        charts::draw_both_widths(|size| charts::draw_means(&lines, "learning", tr!("Learning over attempts"), size))
    }

    /// Which group has the larger values, where one does.
    fn say_direction(&self, auc: &Option<Estimate>) -> String {
        match auc.as_ref().map(|found| found.value) {
            Some(value) if value > 0.5 => tr!("{experts}: larger", experts = self.experts()),
            Some(value) if value < 0.5 => tr!("{experts}: smaller", experts = self.experts()),
            _ => String::new(),
        }
    }

    fn say_summary(&self, found: &Option<Summary>, row: &StudyComparison) -> String {
        let Some(found) = found else { return "–".to_owned() };
        let number = |value: f64| format::format_number(value);
        tr!(
            "{median} ({lower}–{upper}){unit}, n = {n}",
            median = number(found.median),
            lower = number(found.lower_quartile),
            upper = number(found.upper_quartile),
            unit = if ["", "1", "count"].contains(&row.unit.as_str()) {
                String::new()
            } else {
                format!("\u{a0}{}", row.unit)
            },
            n = found.n
        )
    }

    fn say_estimate(&self, found: &Option<Estimate>) -> String {
        let Some(found) = found else { return "–".to_owned() };
        tr!(
            "{value} ({low} to {high})",
            value = format::format_fixed(found.value, 2),
            low = format::format_fixed(found.low, 2),
            high = format::format_fixed(found.high, 2)
        )
    }

    fn say_probability(&self, p: &f64) -> String {
        if *p < 0.001 { format!("<\u{a0}{}", format::format_fixed(0.001, 3)) } else { format::format_fixed(*p, 3) }
    }

    fn say_mean(&self, found: &Option<Estimate>) -> String {
        let Some(found) = found else { return "–".to_owned() };
        let number = |value: f64| format::format_fixed(value, 1);
        tr!(
            "{value} ({low} to {high}), n = {n}",
            value = number(found.value),
            low = number(found.low),
            high = number(found.high),
            n = found.n
        )
    }

    /// How well attempts repeat, in words.
    fn say_repeated(&self) -> String {
        let found = match &self.findings.repeated {
            Ok(found) => found,
            Err(why) => return tr!("Not computable: {why}.", why = words::phrase(&why.in_words())),
        };
        let number = |value: f64| format::format_fixed(value, 2);
        let (low, high) = found.single_random_95.unwrap_or((found.single_random, found.single_random));
        tr!(
            "ICC(2,1) = {single} ({low} to {high}) for one attempt; ICC(2,k) = {average} for the mean of {k} attempts. Of {n} participants with all attempts; {missing} left out.",
            single = number(found.single_random),
            low = number(low),
            high = number(high),
            average = found.average_random.map_or_else(|| "–".to_owned(), number),
            k = found.raters,
            n = found.n,
            missing = found.missing
        )
    }

    /// What each attempt is called, from the first.
    fn attempts(&self) -> Vec<String> {
        let count = self.findings.learning.first().map_or(0, Vec::len);
        (1..=count).map(|n| tr!("Attempt {n}", n = n)).collect()
    }

    /// Each group with the mean at each attempt.
    fn learning(&self) -> Vec<(String, Vec<(String, String)>)> {
        let cells = |means: &[Option<Estimate>]| -> Vec<(String, String)> {
            self.attempts().into_iter().zip(means.iter().map(|mean| self.say_mean(mean))).collect()
        };
        let names = self.groups.iter().map(|(name, _)| name.clone());
        names.zip(&self.findings.learning).map(|(name, means)| (name, cells(means))).collect()
    }
}

#[cfg(test)]
mod tests {
    //! Fails when a group loses its name, or a figure is shown without what it rests on.

    use model::Role;
    use model::study::{StudyGroups, StudyMetric, StudyValue};

    use super::*;
    use crate::samples;
    use crate::survey::samples::sample_survey_results;

    #[test]
    fn every_figure_says_on_how_many_it_rests() {
        let groups = StudyGroups { of_participants: &[0, 0, 0, 1, 1, 1], count: 2 };
        let values = (0..6).flat_map(|participant| (1..=2).map(move |number| (participant, number)));
        let value = |(participant, number): (usize, usize)| {
            let value = 50.0 + participant as f64 * 5.0 + ((participant * number) % 3) as f64;
            StudyValue { participant, number, value }
        };
        let metric = |id: &str, unit: &str| StudyMetric {
            id: id.to_owned(),
            label: id.to_owned(),
            unit: unit.to_owned(),
            values: values.clone().map(value).collect(),
        };
        let findings = StudyFindings::new(groups, 2, &metric("score", ""), &[metric("peak_force_n", "N")]);
        let survey = StudySurveyBlock {
            title: "Validity".to_owned(),
            href: "/surveys/1/results".to_owned(),
            at_end: true,
            results: sample_survey_results(),
        };
        let page = StudyResultsPage {
            shell: samples::shell(Role::Instructor),
            title: "Is it like a patient?".to_owned(),
            href: "/studies/1".to_owned(),
            generated: true,
            exercises: vec![
                ("Layers".to_owned(), "?exercise=a".to_owned(), true),
                ("Depth".to_owned(), "?exercise=b".to_owned(), false),
            ],
            groups: vec![("Novices".to_owned(), 3), ("Masters".to_owned(), 3)],
            findings,
            surveys: vec![survey],
        };
        let html = samples::keep_page("study-results", &page);
        assert!(html.contains("n\u{a0}=\u{a0}3") && html.contains("0.100") && html.contains("ICC(2,1)"), "{html}");
        for drawn in [
            "groups-0-wide",
            "groups-1-narrow",
            "learning-wide",
            "series s1",
            "Masters: larger",
            "0.5 where they do not differ",
        ] {
            assert!(html.contains(drawn), "{drawn}: {html}");
        }
        assert!(html.contains("Masters") && html.contains("/studies/1/results/study.csv"), "{html}");
    }
}
