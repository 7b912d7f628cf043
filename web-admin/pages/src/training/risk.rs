//! The list of people at risk with their support records, and the school's rules.

use askama::Template;
use askama_web::WebTemplate;
use model::training::risk::{CONSIDERED_DAYS, PersonAtRisk, RiskRule, RuleSetting, TraineeAddress, WEIGHTS};
use model::training::support_note::{MOST_CHARACTERS, SupportKind, SupportNote};
use serde::Deserialize;

use crate::form::{FilledForm, read_ticked_box, read_trimmed_text};
use crate::people::listed::ListPart;
use crate::training::concern::{name_rule, say_concern, say_rule};
use crate::{Shell, format};

/// Reasons shown for a person; more are counted.
const SHOWN_REASONS: usize = 4;

/// The list of people at risk.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/at_risk.html")]
pub struct AtRiskPage {
    /// Page frame.
    pub shell: Shell,
    /// Whose list it is: name and address of a cohort or a person; `None` for everyone the visitor
    /// sees.
    pub part: Option<(String, String)>,
    /// The people of the page.
    pub rows: Vec<AtRiskRow>,
    /// Position in the list.
    pub list: ListPart,
    /// The rules that apply, in words.
    pub rules: Vec<String>,
    /// Whether the visitor may change them.
    pub is_admin: bool,
    /// What was just done, in words.
    pub done: Option<String>,
    /// The form below the list.
    pub form: FilledForm<SupportForm>,
}

/// A person in the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AtRiskRow {
    /// Id of the person.
    pub id: String,
    /// Name.
    pub name: String,
    /// Whether an email address is known.
    pub has_address: bool,
    /// Reasons: kind and words.
    pub concerns: Vec<(&'static str, String)>,
    /// Number of further reasons.
    pub more: usize,
    /// Sum of the weights of the rules.
    pub weight: u32,
    /// The latest support record.
    pub last: Option<SupportNoteRow>,
}

/// A support record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SupportNoteRow {
    /// What, by whom and when.
    pub what: String,
    /// Subject of a message.
    pub subject: Option<String>,
    /// The text.
    pub body: String,
}

/// Input of the form below the list.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct SupportForm {
    /// Ids of the people selected.
    pub person: Vec<String>,
    /// Name of the kind.
    pub kind: String,
    /// Subject of a message.
    pub subject: String,
    /// The text.
    pub body: String,
    /// The cohort to which the list is limited, or empty.
    pub cohort: String,
    /// The person to whom the list is limited, or empty.
    pub trainee: String,
    /// Words searched for.
    pub q: String,
    /// The page of the list.
    pub page: Option<u32>,
}

impl AtRiskRow {
    /// Creates the row of a person at risk.
    #[must_use]
    pub fn new(of: &PersonAtRisk, last: Option<SupportNote>) -> Self {
        Self {
            concerns: of.concerns.iter().take(SHOWN_REASONS).map(say_concern).collect(),
            more: of.concerns.len().saturating_sub(SHOWN_REASONS),
            weight: of.weight,
            ..Self::unconcerned(&of.trainee, last)
        }
    }

    /// Creates the row of a person to whom no rule applies.
    #[must_use]
    pub fn unconcerned(of: &TraineeAddress, last: Option<SupportNote>) -> Self {
        Self {
            id: of.id.to_string(),
            name: of.name.clone(),
            has_address: of.has_address,
            concerns: Vec::new(),
            more: 0,
            weight: 0,
            last: last.map(SupportNoteRow::new),
        }
    }

    fn more_words(&self) -> String {
        trn!("and {n} more reason", "and {n} more reasons", self.more)
    }
}

impl SupportNoteRow {
    /// Describes a record.
    #[must_use]
    pub fn new(note: SupportNote) -> Self {
        let (by, date) = (&note.by, format::format_date(note.made_at.to_utc()));
        let what = match (note.kind, note.mailed) {
            (SupportKind::Message, true) => tr!("mailed by {name} on {date}", name = by, date = date),
            (SupportKind::Message, false) => {
                tr!("message by {name} on {date}, not mailed: no email address", name = by, date = date)
            }
            (SupportKind::Spoken, _) => tr!("spoken to by {name} on {date}", name = by, date = date),
            (SupportKind::Note, _) => tr!("note by {name} on {date}", name = by, date = date),
        };
        Self { what, subject: note.subject, body: note.body }
    }
}

impl AtRiskPage {
    /// Returns the number of characters that a text may have.
    const fn most_characters() -> usize {
        MOST_CHARACTERS
    }

    /// Returns the weeks that are considered.
    const fn considered_weeks() -> i64 {
        CONSIDERED_DAYS / 7
    }

    fn is_ticked(&self, row: &AtRiskRow) -> bool {
        self.form.typed.person.contains(&row.id)
    }

    /// Returns the kinds to choose from: name, label, and whether it is selected.
    fn kinds(&self) -> Vec<(&'static str, &'static str, bool)> {
        let label = |kind| match kind {
            SupportKind::Message => tr!("Send a message: by email, and as news on their page"),
            SupportKind::Spoken => tr!("Record a conversation"),
            SupportKind::Note => tr!("Write a note for the other teachers"),
        };
        let typed = self.form.typed.kind.as_str();
        SupportKind::ALL.into_iter().map(|kind| (kind.name(), label(kind), kind.name() == typed)).collect()
    }
}

/// The rules of the school.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/risk_rules.html")]
pub struct RiskRulesPage {
    /// Page frame.
    pub shell: Shell,
    /// The form with the current rules, or with refused input.
    pub form: FilledForm<RiskRulesForm>,
}

/// Input of a rule.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TypedRule {
    /// Whether it applies.
    pub applies: bool,
    /// Its number.
    pub number: String,
    /// Its weight.
    pub weight: String,
}

/// Input of the form with the rules.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
#[expect(missing_docs, reason = "the fields of each rule: whether it applies, its number, its weight")]
pub struct RiskRulesForm {
    #[serde(deserialize_with = "read_ticked_box")]
    pub not_begun: bool,
    #[serde(deserialize_with = "read_trimmed_text")]
    pub not_begun_number: String,
    #[serde(deserialize_with = "read_trimmed_text")]
    pub not_begun_weight: String,
    #[serde(deserialize_with = "read_ticked_box")]
    pub failing: bool,
    #[serde(deserialize_with = "read_trimmed_text")]
    pub failing_number: String,
    #[serde(deserialize_with = "read_trimmed_text")]
    pub failing_weight: String,
    #[serde(deserialize_with = "read_ticked_box")]
    pub falling: bool,
    #[serde(deserialize_with = "read_trimmed_text")]
    pub falling_number: String,
    #[serde(deserialize_with = "read_trimmed_text")]
    pub falling_weight: String,
    #[serde(deserialize_with = "read_ticked_box")]
    pub inactive: bool,
    #[serde(deserialize_with = "read_trimmed_text")]
    pub inactive_number: String,
    #[serde(deserialize_with = "read_trimmed_text")]
    pub inactive_weight: String,
}

impl RiskRulesForm {
    /// Fills the form with stored rules.
    #[must_use]
    pub fn new(settings: &[RuleSetting; 4]) -> Self {
        let typed = |of: RuleSetting| (of.applies, of.number.to_string(), of.weight.to_string());
        let [not_begun, failing, falling, inactive] = settings.map(typed);
        Self {
            not_begun: not_begun.0,
            not_begun_number: not_begun.1,
            not_begun_weight: not_begun.2,
            failing: failing.0,
            failing_number: failing.1,
            failing_weight: failing.2,
            falling: falling.0,
            falling_number: falling.1,
            falling_weight: falling.2,
            inactive: inactive.0,
            inactive_number: inactive.1,
            inactive_weight: inactive.2,
        }
    }

    /// Returns the input of a rule.
    #[must_use]
    pub fn typed(&self, rule: RiskRule) -> TypedRule {
        let (applies, number, weight) = match rule {
            RiskRule::NotBegun => (self.not_begun, &self.not_begun_number, &self.not_begun_weight),
            RiskRule::Failing => (self.failing, &self.failing_number, &self.failing_weight),
            RiskRule::Falling => (self.falling, &self.falling_number, &self.falling_weight),
            RiskRule::Inactive => (self.inactive, &self.inactive_number, &self.inactive_weight),
        };
        TypedRule { applies, number: number.clone(), weight: weight.clone() }
    }
}

/// A rule in the form.
#[derive(Clone, Debug)]
struct RuleFields {
    name: &'static str,
    label: &'static str,
    unit: &'static str,
    help: &'static str,
    least: u32,
    most: u32,
    typed: TypedRule,
}

impl RiskRulesPage {
    /// Returns the largest weight.
    const fn most_weight() -> u32 {
        *WEIGHTS.end()
    }

    fn fields(&self) -> Vec<RuleFields> {
        RiskRule::ALL.into_iter().map(|rule| make_rule_fields(rule, self.form.typed.typed(rule))).collect()
    }
}

fn make_rule_fields(rule: RiskRule, typed: TypedRule) -> RuleFields {
    let (unit, help) = match rule {
        RiskRule::NotBegun => (
            tr!("Days before the due date"),
            tr!("No attempt so many days before an assignment is due, or later. Extensions count."),
        ),
        RiskRule::Failing => {
            (tr!("Failed attempts in a row"), tr!("So many failed attempts in a row at one exercise, up to the last."))
        }
        RiskRule::Falling => (
            tr!("Points"),
            tr!("The mean of the last three scores at one exercise is so many points below that of the three before."),
        ),
        RiskRule::Inactive => (
            tr!("Weeks without an attempt"),
            tr!("No attempt for so many weeks, though a course was started and not every exercise of it passed."),
        ),
    };
    let (least, most) = (*rule.limits().start(), *rule.limits().end());
    RuleFields { name: rule.name(), label: name_rule(rule), unit, help, least, most, typed }
}

/// Describes the rules that apply.
#[must_use]
pub fn say_rules(settings: &[RuleSetting; 4]) -> Vec<String> {
    settings.iter().filter(|of| of.applies).map(|of| format::as_sentence(&say_rule(*of))).collect()
}

#[cfg(test)]
mod tests {
    //! A person of the list must be named with every reason, and a refused form must keep its input.

    use model::Role;
    use model::ids::PersonId;
    use model::training::risk::{Concern, RiskRules};

    use super::*;
    use crate::NavPlace;
    use crate::people::listed::ListQuery;
    use crate::samples;

    fn at_risk(name: &str, n: u128, concerns: Vec<Concern>) -> PersonAtRisk {
        let trainee = TraineeAddress { id: PersonId::from_u128(n), name: name.to_owned(), has_address: n != 2 };
        PersonAtRisk { trainee, concerns, weight: 5 }
    }

    fn page() -> AtRiskPage {
        let failing = Concern::Failing {
            exercise: "reach-the-muscle".to_owned(),
            title: "Reach the muscle".to_owned(),
            fails: 3,
            last_score: 41.0,
        };
        let note = SupportNote {
            id: model::ids::SupportNoteId::nil(),
            person_id: PersonId::from_u128(1),
            by: "Dr Peter Osei".to_owned(),
            kind: SupportKind::Message,
            subject: Some("Practice <1>".to_owned()),
            body: "Come on Thursday.\nRoom 4.".to_owned(),
            mailed: true,
            made_at: samples::NOW.into(),
        };
        let many = vec![Concern::Inactive { days: 20 }; 6];
        let people = vec![
            AtRiskRow::new(&at_risk("Bruno <Ferrari>", 1, vec![failing]), Some(note)),
            AtRiskRow::new(&at_risk("Emeka Obi", 2, many), None),
        ];
        let (rows, list) = ListPart::of(ListQuery::default(), people, |row| &row.name);
        let typed =
            SupportForm { kind: "message".to_owned(), person: vec![rows[0].id.clone()], ..SupportForm::default() };
        AtRiskPage {
            shell: Shell { place: NavPlace::Cohorts, ..samples::shell(Role::Administrator) },
            part: Some(("Spring 2026".to_owned(), "/cohorts/1".to_owned())),
            rows,
            list,
            rules: say_rules(RiskRules::of(&[]).settings()),
            is_admin: true,
            done: Some("1 person is mailed.".to_owned()),
            form: FilledForm::new(typed),
        }
    }

    #[test]
    fn the_list_names_each_reason_and_what_was_done() {
        let html = samples::keep_page("at-risk", &page());
        for part in [
            "3 failed attempts in a row at “Reach the muscle”",
            "and 2 more reasons",
            "no email address",
            "mailed by Dr Peter Osei on 20 May 2026",
            "No attempt for 2 weeks in a course that is not passed<",
            "/admin/at-risk",
        ] {
            assert!(html.contains(part), "{part} is not in {html}");
        }
        assert_eq!(html.matches(" checked").count(), 2, "a person and a kind");
    }

    #[test]
    fn an_empty_list_says_so_and_a_refused_form_says_why() {
        let empty = AtRiskPage { rows: vec![], done: None, part: None, is_admin: false, ..page() };
        assert!(samples::keep_page("at-risk-empty", &empty).contains("Nobody right now"));
        let form = FilledForm::refused(page().form.typed, "0 people are selected".to_owned());
        let html = samples::keep_page("at-risk-refused", &AtRiskPage { form, ..page() });
        assert!(html.contains("0 people are selected") && html.contains(r#"role="alert""#), "{html}");
    }

    #[test]
    fn the_rules_are_shown_as_they_are_set() {
        let mut settings = *RiskRules::of(&[]).settings();
        settings[3].applies = false;
        let form = RiskRulesForm::new(&settings);
        assert_eq!(form.typed(RiskRule::Failing).number, "3");
        let shell = samples::shell(Role::Administrator);
        let html = samples::keep_page("risk-rules", &RiskRulesPage { shell, form: FilledForm::new(form) });
        assert_eq!(html.matches(" checked").count(), 3, "{html}");
    }
}
