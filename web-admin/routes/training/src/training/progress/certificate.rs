//! Certificates of mastered courses.

use acts::error::Error;
use acts::training::assignments::find_taught_curriculum;
use acts::training::certificates;
use askama::Template;
use axum::extract::{Path, State};
use axum::response::Response;
use model::ids::{PersonId, SchoolId};
use model::training::certificate::{Certificate, SCOPE, Statement, sign_statement};
use model::training::certificate_note::CertificateNote;
use model::training::progress::{Course, Mastery, Progress, StepState};
use model::training::signatory::Signatory;
use model::{CurrentPerson, Needed, PersonKey};
use pages::format;
use pages::training::certificate::CertificatePage;
use pages::training::paper::Logo;
use pages::training::trainee::{needed_in_words, rule_in_words};
use routes_base::AppState;
use routes_base::auth::{CsrfForm, Visitor};
use routes_base::error::PageError;
use routes_base::export::attach_file;
use serde::Deserialize;
use store::operations::{logos, schools};
use store::people;
use store::training::curricula::TaughtCurriculum;
use store::training::reports::NamedItem;
use store::training::{practice, reports};
use time::OffsetDateTime;
use words::Language;

use crate::training::standing;

/// Issues a certificate if the whole course is mastered.
pub(super) async fn issue_certificate(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path((id, course)): Path<(String, String)>,
    CsrfForm(form): CsrfForm<CertificateForm>,
) -> Result<Response, PageError> {
    let CertifiedTrainee { trainee, curriculum, earned } = find_earned(&state, &person, &id, &course).await?;
    let key = certificates::signing_key(&state.config.keys_dir)?;
    let certificate = sign_statement(&key, &earned.statement)?;
    let query = earned.note().signed_query(&key).map_err(anyhow::Error::from)?;
    let check_href = format!("{}/certificate?{query}", state.config.address());
    let language = find_language(&state, PersonKey { school_id: person.school_id, person_id: trainee.id }).await?;
    let (media_type, ending, bytes) = words::within(language, || {
        let page = earned.page(&certificate, check_href)?;
        anyhow::Ok(match form.format {
            CertificateFormat::Html => ("text/html; charset=utf-8", "html", page.render()?.into_bytes()),
            CertificateFormat::Pdf => ("application/pdf", "pdf", page.paper().to_pdf()?),
        })
    })?;
    certificates::note_issued(&state, &person, trainee.id, &curriculum).await?;
    Ok(attach_file(media_type, &format!("certificate-{}.{ending}", curriculum.curriculum_id), bytes))
}

#[derive(Debug, Deserialize)]
pub(super) struct CertificateForm {
    #[serde(default)]
    format: CertificateFormat,
}

/// File format of a certificate.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum CertificateFormat {
    #[default]
    Html,
    Pdf,
}

/// A trainee who has earned a certificate.
pub(super) struct CertifiedTrainee {
    pub trainee: NamedItem<PersonId>,
    pub curriculum: TaughtCurriculum,
    pub earned: Earned,
}

/// Returns what a trainee has earned in a course, by the ids in an address.
///
/// # Errors
/// [`Error::NotFound`] if the visitor may not see it, [`Error::Conflict`] if the course is not
/// mastered.
pub(super) async fn find_earned(
    state: &AppState,
    visitor: &CurrentPerson,
    id: &str,
    course: &str,
) -> Result<CertifiedTrainee, Error> {
    let id: PersonId = id.parse().map_err(|_| Error::NotFound)?;
    let trainee = reports::trainee(state.db.reader(), visitor, id).await?.ok_or(Error::NotFound)?;
    let (curriculum, course) = find_taught_curriculum(state, visitor.school_id, course).await?;
    let certified = CertifiedCourse { school: visitor.school_id, curriculum: &curriculum, course };
    let earned = earned_by_trainee(state, &trainee, certified).await?;
    Ok(CertifiedTrainee { trainee, curriculum, earned })
}

/// Returns the language of a trainee's certificate.
pub(super) async fn find_language(state: &AppState, trainee: PersonKey) -> Result<Language, Error> {
    Ok(people::find_language(state.db.reader(), trainee).await?.unwrap_or_else(words::current))
}

/// The content of an earned certificate.
pub(super) struct Earned {
    logo: Option<Logo>,
    signatory: Option<Signatory>,
    pub statement: Statement,
    rule: Mastery,
    pub needed: Needed,
    pub mastered: Vec<(String, OffsetDateTime)>,
    issued_at: OffsetDateTime,
}

impl Earned {
    /// Returns the content of the code on the page.
    fn note(&self) -> CertificateNote {
        CertificateNote {
            note: CertificateNote::VERSION,
            school: self.statement.school.clone(),
            trainee: self.statement.trainee.clone(),
            course: self.statement.course.clone(),
            issued_at: self.statement.issued_at.clone(),
        }
    }

    /// The page, in the language that is spoken here.
    fn page(self, certificate: &Certificate, check_href: String) -> anyhow::Result<CertificatePage> {
        Ok(CertificatePage {
            logo: self.logo,
            signatory: self.signatory,
            rule: rule_in_words(&self.rule),
            needed: needed_in_words(self.needed),
            statement: self.statement,
            mastered: self.mastered,
            issued_at: self.issued_at,
            key: certificate.public_key.clone(),
            json: certificate.in_page()?,
            check_href,
        })
    }
}

/// Returns the logo of a school for its papers, which contain it.
pub(in crate::training) async fn logo_of_school(state: &AppState, school: SchoolId) -> Result<Option<Logo>, Error> {
    let logo = logos::find_logo(state.db.reader(), school).await?;
    Ok(logo.map(|logo| Logo { media_type: logo.media_type, bytes: logo.bytes }))
}

/// A course for which a certificate is asked.
struct CertifiedCourse<'a> {
    school: SchoolId,
    curriculum: &'a TaughtCurriculum,
    course: Course,
}

async fn earned_by_trainee(
    state: &AppState,
    trainee: &NamedItem<PersonId>,
    CertifiedCourse { school, curriculum, course }: CertifiedCourse<'_>,
) -> Result<Earned, Error> {
    let reader = state.db.reader();
    let attempts = practice::list_trainee_practice(reader, school, trainee.id).await?;
    let (needed, proved) = standing::proved_attempts(state, school, trainee.id, &attempts).await?;
    let now = state.clock.now();
    let progress = Progress::of(&course, &proved);
    if !progress.complete() {
        let why = tr!(
            "a certificate is issued once every exercise of the course is mastered; the school requires {needed}",
            needed = needed_in_words(needed)
        );
        return Err(Error::Conflict(why));
    }
    let mastered = MasteredRevision::of(&course, &progress);
    let settings = schools::find_school_settings(reader, school).await?;
    let statement = Statement {
        format: Statement::FORMAT,
        school: settings.name.clone(),
        trainee: trainee.name.clone(),
        registrar_id: people::find_registrar_id(reader, school, trainee.id).await?,
        curriculum_id: curriculum.curriculum_id.clone(),
        course: curriculum.title.clone(),
        curriculum_sha256: mastered.sha256.unwrap_or(&curriculum.sha256).to_owned(),
        rule: words::within(Language::ENGLISH, || rule_in_words(mastered.rule)),
        attempts: Some(words::within(Language::ENGLISH, || needed_in_words(needed)).to_owned()),
        exercises: mastered.steps.iter().map(|(title, on)| (title.clone(), format::format_machine_time(on))).collect(),
        issued_at: now.to_string(),
        scope: SCOPE.to_owned(),
    };
    let logo = logo_of_school(state, school).await?;
    let MasteredRevision { steps, rule, .. } = mastered;
    Ok(Earned {
        logo,
        signatory: settings.signatory(),
        statement,
        rule: *rule,
        needed,
        mastered: steps,
        issued_at: now.to_utc(),
    })
}

/// The revision of a course that somebody has mastered.
struct MasteredRevision<'a> {
    /// SHA-256 of its document, where it is an earlier one.
    sha256: Option<&'a str>,
    rule: &'a Mastery,
    /// Titles of its exercises, and since when each is mastered.
    steps: Vec<(String, OffsetDateTime)>,
}

impl<'a> MasteredRevision<'a> {
    fn of(course: &'a Course, progress: &Progress) -> Self {
        if let Some((earlier, mastery)) = progress.earlier_in(course) {
            let titles = earlier.steps.iter().map(|step| step.title.clone());
            let steps = titles.zip(mastery.exercises.iter().copied()).collect();
            return Self { sha256: Some(&earlier.sha256), rule: &earlier.rule, steps };
        }
        let mastered = course.steps.iter().zip(&progress.steps).filter_map(|(step, done)| match done.state {
            StepState::Mastered { on } => Some((step.title.clone(), on)),
            _ => None,
        });
        Self { sha256: None, rule: &course.rule, steps: mastered.collect() }
    }
}
