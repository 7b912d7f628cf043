//! `/at-risk`: people at risk, and support records; `/admin/at-risk`: the school's rules.

use acts::error::Error;
use acts::training::risks as acting;
use axum::extract::{Query, State};
use model::ids::{CohortId, PersonId};
use model::training::risk::{PersonAtRisk, RiskRule, RuleSetting, WEIGHTS};
use model::training::support_note::{SupportKind, SupportText};
use model::{CurrentPerson, PersonKey, Role};
use pages::form::FilledForm;
use pages::people::listed::{ListPart, ListQuery};
use pages::training::risk::{AtRiskPage, AtRiskRow, RiskRulesForm, RiskRulesPage, SupportForm, say_rules};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::encode_in_query;
use routes_base::auth::{Administrator, Csrf, CsrfForm, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::training::reports::NamedItem;
use store::training::risks::RiskScope;
use store::training::{reports, risks, support_notes};

use super::cohorts;

/// Which part of the list is shown, and what was just done.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct AtRiskQuery {
    cohort: String,
    trainee: String,
    q: String,
    page: Option<u32>,
    /// Number of people for whom something was recorded.
    people: Option<u32>,
    /// Number of them who are mailed.
    mailed: Option<u32>,
    /// Name of the kind that was recorded.
    kind: String,
}

impl AtRiskQuery {
    fn into_list(self) -> ListQuery {
        let kept = [("cohort", self.cohort), ("trainee", self.trainee)];
        let kept = kept.into_iter().filter(|(_, value)| !value.is_empty()).collect();
        ListQuery { q: self.q, page: self.page, kept }
    }

    /// Describes what was just done.
    fn say_done(&self) -> Option<String> {
        let people = self.people?;
        let mailed = self.mailed.unwrap_or(0).min(people);
        let unmailed = people - mailed;
        if self.kind != SupportKind::Message.name() {
            return Some(trn!("Recorded for {n} person.", "Recorded for {n} people.", people));
        }
        let sent = trn!("The message is mailed to {n} person.", "The message is mailed to {n} people.", mailed);
        let others = trn!(
            "{n} person has no email address: the message is on their page only.",
            "{n} people have no email address: the message is on their pages only.",
            unmailed
        );
        Some(if unmailed == 0 { sent } else { format!("{sent} {others}") })
    }
}

/// The part of the list that a query asks for.
struct ListedPart {
    scope: RiskScope,
    /// Name and address of the cohort or the trainee.
    named: Option<(String, String)>,
}

/// Returns the part of the list, if the visitor may see it.
async fn find_part(state: &AppState, by: &CurrentPerson, query: &AtRiskQuery) -> Result<ListedPart, Error> {
    let reader = state.db.reader();
    if !query.trainee.is_empty() {
        let id: PersonId = query.trainee.parse().map_err(|_| Error::NotFound)?;
        let found = support_notes::find_supported_trainee(reader, by, id).await?.ok_or(Error::NotFound)?;
        let named = Some((found.name, format!("/trainees/{id}")));
        return Ok(ListedPart { scope: RiskScope::Trainee(id), named });
    }
    if !query.cohort.is_empty() {
        let id: CohortId = query.cohort.parse().map_err(|_| Error::NotFound)?;
        let cohort: NamedItem<CohortId> = reports::cohort(reader, by, id).await?.ok_or(Error::NotFound)?;
        let href = cohorts::cohort_href(&cohort);
        return Ok(ListedPart { scope: RiskScope::Cohort(id), named: Some((cohort.name, href)) });
    }
    let scope = match by.role {
        Role::Administrator => RiskScope::School,
        _ => RiskScope::Teacher(by.id),
    };
    Ok(ListedPart { scope, named: None })
}

pub(super) async fn show_at_risk(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    Query(query): Query<AtRiskQuery>,
) -> Result<AtRiskPage, PageError> {
    let done = query.say_done();
    let typed = SupportForm {
        kind: SupportKind::Message.name().to_owned(),
        person: Some(query.trainee.clone()).filter(|id| !id.is_empty()).into_iter().collect(),
        ..SupportForm::default()
    };
    let page = make_page(&state, Visit::new(&person, &csrf), query, FilledForm::new(typed)).await?;
    Ok(AtRiskPage { done, ..page })
}

async fn make_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    query: AtRiskQuery,
    form: FilledForm<SupportForm>,
) -> Result<AtRiskPage, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let ListedPart { scope, named } = find_part(state, person, &query).await?;
    let mut found = acting::list_people_at_risk(state, person, scope).await?;
    if let (RiskScope::Trainee(id), true) = (scope, found.is_empty()) {
        let trainee = support_notes::find_supported_trainee(reader, person, id).await?.ok_or(Error::NotFound)?;
        found.push(PersonAtRisk { trainee, concerns: Vec::new(), weight: 0 });
    }
    let rules = say_rules(risks::find_rules(reader, school).await?.settings());
    let form = FilledForm {
        typed: SupportForm { cohort: query.cohort.clone(), trainee: query.trainee.clone(), ..form.typed },
        ..form
    };
    let (shown, list) = ListPart::of(query.into_list(), found, |of| &of.trainee.name);
    let mut rows = Vec::with_capacity(shown.len());
    for of in &shown {
        let key = PersonKey { school_id: school, person_id: of.trainee.id };
        let last = support_notes::list_support_notes(reader, key, 1).await?.pop();
        rows.push(AtRiskRow::new(of, last));
    }
    Ok(AtRiskPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Cohorts),
        part: named,
        rows,
        list,
        rules,
        is_admin: person.role == Role::Administrator,
        done: None,
        form,
    })
}

/// Adds a support record for the people selected, or sends them a message.
pub(super) async fn record_support(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<SupportForm>,
) -> Result<FormAnswer<AtRiskPage>, PageError> {
    let query = AtRiskQuery {
        cohort: form.cohort.clone(),
        trainee: form.trainee.clone(),
        q: form.q.clone(),
        page: form.page,
        ..AtRiskQuery::default()
    };
    match record(&state, &person, &form).await? {
        Ok(outcome) => {
            let (people, mailed) = (outcome.people, outcome.mailed);
            let part = match (form.trainee.as_str(), form.cohort.as_str()) {
                ("", "") => String::new(),
                ("", cohort) => format!("&cohort={}", encode_in_query(cohort)),
                (trainee, _) => format!("&trainee={}", encode_in_query(trainee)),
            };
            let kind = encode_in_query(&form.kind);
            Ok(FormAnswer::lead_to(&format!("/at-risk?people={people}&mailed={mailed}&kind={kind}{part}")))
        }
        Err(why) => {
            let visit = Visit::new(&person, &csrf);
            Ok(FormAnswer::Refused(make_page(&state, visit, query, FilledForm::refused(form, why)).await?))
        }
    }
}

async fn record(
    state: &AppState,
    by: &CurrentPerson,
    form: &SupportForm,
) -> Result<Result<acting::SupportOutcome, String>, Error> {
    let text = match SupportText::read(&form.kind, &form.subject, &form.body) {
        Ok(text) => text,
        Err(why) => return Ok(Err(why)),
    };
    let mut people = Vec::with_capacity(form.person.len());
    for id in &form.person {
        people.push(id.parse::<PersonId>().map_err(|_| Error::NotFound)?);
    }
    people.sort_unstable();
    people.dedup();
    split_refusal(acting::record_support(state, by, &people, &text).await)
}

pub(super) async fn show_rules(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<RiskRulesPage, PageError> {
    let rules = risks::find_rules(state.db.reader(), person.school_id).await.map_err(Error::from)?;
    let form = FilledForm::new(RiskRulesForm::new(rules.settings()));
    Ok(RiskRulesPage { shell: Shell::new(&person, csrf.token(), NavPlace::Administration), form })
}

pub(super) async fn set_rules(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<RiskRulesForm>,
) -> Result<FormAnswer<RiskRulesPage>, PageError> {
    let outcome = match read_rules(&form) {
        Ok(rules) => split_refusal(acting::set_rules(&state, &person, rules).await)?,
        Err(why) => Err(why),
    };
    Ok(match outcome {
        Ok(()) => FormAnswer::lead_to("/admin/at-risk"),
        Err(why) => {
            let shell = Shell::new(&person, csrf.token(), NavPlace::Administration);
            FormAnswer::Refused(RiskRulesPage { shell, form: FilledForm::refused(form, why) })
        }
    })
}

fn read_rules(form: &RiskRulesForm) -> Result<[RuleSetting; 4], String> {
    let mut settings = RiskRule::ALL.map(RiskRule::usual);
    for of in &mut settings {
        let typed = form.typed(of.rule);
        let refused = |text: &str, limits| acting::refuse_number(text, &limits);
        of.applies = typed.applies;
        of.number = typed.number.parse().map_err(|_| refused(&typed.number, of.rule.limits()))?;
        of.weight = typed.weight.parse().map_err(|_| refused(&typed.weight, WEIGHTS))?;
    }
    Ok(settings)
}
