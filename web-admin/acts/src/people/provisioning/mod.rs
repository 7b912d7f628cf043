//! Provisioning of people and cohorts by a school's directory (SCIM 2.0). The directory disables
//! people, and never erases them.

pub mod groups;
pub mod tokens;
pub mod users;

use model::people::scim::{ScimAddress, ScimError};
use store::people::provisioning::ProvisioningToken;

use crate::error::Error;
use crate::service::Service;

/// A request of a directory.
#[derive(Clone, Copy, Debug)]
pub struct DirectoryRequest<'a> {
    /// The service.
    pub service: &'a Service,
    /// Its token.
    pub token: &'a ProvisioningToken,
    /// Address of the SCIM endpoints.
    pub address: ScimAddress<'a>,
    /// Version that the resource must still have.
    pub if_match: Option<&'a str>,
}

/// Why a request of a directory failed.
#[derive(Debug)]
pub enum ProvisioningError {
    /// The request is at fault.
    Scim(ScimError),
    /// Another error.
    Service(Error),
}

impl<E: Into<Error>> From<E> for ProvisioningError {
    fn from(error: E) -> Self {
        Self::Service(error.into())
    }
}

impl ProvisioningError {
    fn of(error: ScimError) -> Self {
        Self::Scim(error)
    }
}

fn forbidden(detail: &str) -> ProvisioningError {
    ProvisioningError::Scim(ScimError { status: 403, kind: None, detail: detail.to_owned() })
}

impl DirectoryRequest<'_> {
    /// Refuses a change of a resource that has changed since the directory has read it.
    fn check_version(&self, fields: &model::people::scim::Object) -> Result<(), ProvisioningError> {
        let version = fields.get("meta").and_then(|meta| meta.get("version")).and_then(serde_json::Value::as_str);
        match self.if_match {
            Some(wanted) if wanted != "*" && Some(wanted) != version => Err(ProvisioningError::Scim(ScimError {
                status: 412,
                kind: None,
                detail: "the resource has changed since it was read".to_owned(),
            })),
            _ => Ok(()),
        }
    }
}
