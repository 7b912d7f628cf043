//! Publishes courses and instruments from a folder, each call in one transaction.

use std::path::{Path, PathBuf};

use crate::authoring::publishing::{CourseRefused, Published};
use crate::authoring::{instruments, publishing};
use crate::people::admin_commands::{RegistryError, choose_in};
use crate::service::Service;

impl From<CourseRefused> for RegistryError {
    fn from(refused: CourseRefused) -> Self {
        match refused {
            CourseRefused::Document(words) => Self::Usage(words),
            CourseRefused::Work(error) => Self::Work(error),
        }
    }
}

/// Publishes the course in a folder at the named school, or at the only school.
///
/// # Errors
/// Fails if a document is invalid, the school is ambiguous or unknown, or the database fails.
pub async fn import_course(
    service: &Service,
    school: Option<&str>,
    course: &Path,
) -> Result<Vec<Published>, RegistryError> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    let school = choose_in(&mut tx, school, now).await?;
    let published = publishing::course(&mut tx, school.id, course, now).await?;
    instruments::course_surveys(&mut tx, school.id, now).await?;
    tx.commit().await?;
    Ok(published)
}

/// Publishes instruments at the named school, or at the only school.
///
/// # Errors
/// Fails if a document is invalid, the school is ambiguous or unknown, or the database fails.
pub async fn import_instruments(
    service: &Service,
    school: Option<&str>,
    files: &[PathBuf],
) -> Result<Vec<Published>, RegistryError> {
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    let school = choose_in(&mut tx, school, now).await?;
    let mut published = Vec::new();
    for file in files {
        published.push(instruments::publish(&mut tx, school.id, file, now).await?);
    }
    instruments::course_surveys(&mut tx, school.id, now).await?;
    tx.commit().await?;
    Ok(published)
}
