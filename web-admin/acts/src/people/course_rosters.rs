//! Rosters from courses of learning platforms: read, stored for a preview, and compared.

use std::collections::BTreeSet;
use std::time::Duration;

use model::CurrentPerson;
use model::ids::{CohortId, RosterId, SchoolId};
use model::people::roster::{CourseRoster, KnownMembers, RosterDifference, RosterRequest};
use serde_json::json;
use store::Connection;
use store::audit::AuditEntry;
use store::auth::lti::courses::{CourseKey, PlatformCourse};
use store::auth::lti::platforms::Platform;
use store::auth::lti::{courses, platforms};
use store::people::rosters;
use store::people::rosters::{About, AboutMembers, NewRosterDraft};
use store::training::cohorts;

use crate::auth::lti::members;
use crate::error::{Error, error_chain};
use crate::replicas::{self, Duty};
use crate::service::Service;

/// Interval between searches for courses to compare.
const EVERY: Duration = Duration::from_mins(10);
/// Interval between comparisons of a course with its cohort, in s.
const CHECK_INTERVAL_S: i64 = 24 * 3600;
/// Number of courses compared at once.
const BATCH: u32 = 20;

/// Ties a course to a cohort of the school, or to none.
///
/// # Errors
/// Fails if there is no such course or cohort, or the database fails.
pub async fn tie_course(
    service: &Service,
    by: &CurrentPerson,
    key: CourseKey,
    cohort: Option<CohortId>,
) -> Result<(), Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let course = courses::find_course(&mut *tx, key).await?.ok_or(Error::NotFound)?;
    if course.cohort_id == cohort {
        return Ok(());
    }
    if let Some(cohort) = cohort {
        let known = cohorts::list_cohorts(&mut *tx, by.school_id).await?;
        known.iter().find(|known| known.id == cohort).ok_or(Error::NotFound)?;
    }
    courses::tie_course(&mut tx, key, cohort, now).await?;
    AuditEntry::by(by, "platform.course_tied", key.platform_id)
        .with(json!({ "course": key.course_id, "cohort": cohort }))
        .append(&mut tx, now)
        .await?;
    Ok(tx.commit().await?)
}

/// Reads the members of a course, and stores them as a roster for preview. With `remove_missing`,
/// trainees who have left the course are proposed to leave its cohort.
///
/// # Errors
/// Returns [`Error::Unprocessable`] if the course is tied to no cohort, or its members cannot be read;
/// fails if there is no such course, or the database fails.
pub async fn read_course(
    service: &Service,
    by: &CurrentPerson,
    key: CourseKey,
    remove_missing: bool,
) -> Result<RosterId, Error> {
    let (platform, course) = find_course(service, key).await?;
    let (roster, wanted) = read_members(service, &platform, &course, remove_missing).await?;
    let body = serde_json::to_vec(&roster).map_err(anyhow::Error::from)?;
    let file_name = course.title.unwrap_or(course.context_id);
    let draft =
        NewRosterDraft { school_id: by.school_id, made_by: by.id, file_name: &file_name, body: &body, wanted: &wanted };
    let mut tx = service.db.write().await?;
    let id = rosters::keep_roster(&mut tx, &draft, service.clock.now()).await?;
    tx.commit().await?;
    Ok(id)
}

async fn find_course(service: &Service, key: CourseKey) -> Result<(Platform, PlatformCourse), Error> {
    let reader = service.db.reader();
    let platform = platforms::find_platform(reader, key.school_id, key.platform_id).await?.ok_or(Error::NotFound)?;
    Ok((platform, courses::find_course(reader, key).await?.ok_or(Error::NotFound)?))
}

/// Reads the members of a course, for its cohort.
async fn read_members(
    service: &Service,
    platform: &Platform,
    course: &PlatformCourse,
    remove_missing: bool,
) -> Result<(CourseRoster, RosterRequest), Error> {
    let refused = |why: &str| Error::Unprocessable(why.to_owned());
    let cohort = course.cohort.clone().ok_or_else(|| refused(tr!("choose the cohort of the course first")))?;
    let address = course.members_url.as_ref().ok_or_else(|| {
        refused(tr!("the learning platform does not share the members of this course: permit the service there, then open a link of the course"))
    })?;
    let members = members::read_course(service, platform, address).await?;
    let roster = CourseRoster { platform_id: platform.id, issuer: platform.settings.identity_issuer(), members };
    Ok((roster, RosterRequest { cohort: Some(cohort), remove_missing, mapping: None, is_course: true }))
}

/// Compares courses with their cohorts daily until the future is dropped, which may happen at any time.
pub async fn run(service: Service) {
    loop {
        if let Err(error) = replicas::do_duty(&service, Duty::Courses, check_courses(&service)).await {
            tracing::warn!(cause = error_chain(&error), "failed to compare courses with their cohorts");
        }
        tokio::time::sleep(EVERY).await;
    }
}

/// Compares the members of courses with their cohorts, each course once a day, and stores the number
/// of differences. No account and no cohort is changed.
///
/// # Errors
/// Fails if the database fails; members that cannot be read are recorded as unknown.
pub async fn check_courses(service: &Service) -> Result<(), Error> {
    let since = service.clock.now().plus_s(-CHECK_INTERVAL_S);
    for key in courses::list_unchecked_courses(service.db.reader(), since, BATCH).await? {
        let differences = match count_differences(service, key).await {
            Ok(count) => Some(count),
            Err(Error::Unprocessable(why)) => {
                tracing::info!(course = %key.course_id, why, "the members of a course cannot be read");
                None
            }
            Err(error) => return Err(error),
        };
        let mut tx = service.db.write().await?;
        courses::note_check(&mut tx, key, differences, service.clock.now()).await?;
        tx.commit().await?;
    }
    Ok(())
}

/// Returns the number of members to add or change and of people who have left.
async fn count_differences(service: &Service, key: CourseKey) -> Result<usize, Error> {
    let (platform, course) = find_course(service, key).await?;
    let (roster, wanted) = read_members(service, &platform, &course, true).await?;
    let mut connection = service.db.reader().acquire().await?;
    Ok(compare(&mut connection, key.school_id, &roster, &wanted).await?.count_changes())
}

/// Compares a roster with the people of the school.
pub(super) async fn compare(
    connection: &mut Connection,
    school: SchoolId,
    roster: &CourseRoster,
    wanted: &RosterRequest,
) -> Result<RosterDifference, Error> {
    let about = AboutMembers {
        issuer: &roster.issuer,
        subjects: roster.members.iter().map(|member| member.subject.as_str()).collect(),
        numbers: roster.members.iter().filter_map(|member| member.number.as_deref()).collect(),
        cohort: wanted.cohort.as_deref(),
    };
    let people = rosters::list_known_members(connection, school, &about).await?;
    let emails: BTreeSet<String> = roster.members.iter().filter_map(|member| member.email.clone()).collect();
    let about = About { emails, ..About::default() };
    let holders = rosters::list_known_people(connection, school, &about).await?;
    let taken_emails = holders.into_iter().map(|person| person.email).collect();
    Ok(roster.compare(KnownMembers { people: &people, taken_emails: &taken_emails }, wanted))
}
