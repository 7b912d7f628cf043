//! `/scim/v2`: people and cohorts for a school's directory (SCIM 2.0, RFC 7644).

use acts::error::Error;
use acts::people::provisioning::tokens::admit_directory;
use acts::people::provisioning::users::Listed;
use acts::people::provisioning::{DirectoryRequest, ProvisioningError};
use axum::body::{Bytes, to_bytes};
use axum::extract::{DefaultBodyLimit, FromRequestParts, Path, Query, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use model::people::scim::{Filter, Object, PatchRequest, ScimAddress, ScimError, Selection, read_resource, schemas};
use routes_base::error::{finish_answer, status_of};
use routes_base::{AppState, Routes};
use serde::Deserialize;
use serde_json::{Value, json};
use store::people::provisioning::ProvisioningToken;

use crate::caller::bearer_token;

/// Maximum size of a request, in bytes: a group of a large school is sent as a whole.
const MOST_BYTES: usize = 8 << 20;
/// Maximum size of a refused request that is read, in bytes.
const MOST_READ_AND_REFUSED: usize = 64 << 10;
/// Media type of answers.
const SCIM_JSON: HeaderValue = HeaderValue::from_static("application/scim+json");

/// Returns the endpoints. Directories are authenticated before anything else of a request is read.
#[must_use]
pub fn scim_routes(state: &AppState) -> Routes {
    let routes = Routes::new()
        .route("/ServiceProviderConfig", get(show_config))
        .route("/ResourceTypes", get(list_resource_types))
        .route("/ResourceTypes/{name}", get(show_resource_type))
        .route("/Schemas", get(list_schemas))
        .route("/Schemas/{name}", get(show_schema))
        .route("/Users", get(list_users).post(create_user))
        .route("/Users/{id}", get(show_user).put(replace_user).patch(patch_user).delete(delete_user))
        .route("/Users/.search", post(search_users))
        .route("/Groups/.search", post(search_groups))
        .route("/.search", post(search_everything))
        .route("/Groups", get(list_groups).post(create_group))
        .route("/Groups/{id}", get(show_group).put(replace_group).patch(patch_group).delete(delete_group));
    routes.around(|routes| {
        let fallback =
            async || answer_error(&ScimError { status: 404, kind: None, detail: "nothing is here".to_owned() });
        routes
            .fallback(fallback)
            .layer(DefaultBodyLimit::max(MOST_BYTES))
            .layer(from_fn_with_state(state.clone(), require_directory))
    })
}

/// Admits directories with a valid token.
async fn require_directory(State(state): State<AppState>, mut request: Request, next: Next) -> Response {
    let admitted = match bearer_token(request.headers()) {
        Some(token) => admit_directory(&state, token).await,
        None => Err(Error::Unauthorized),
    };
    match admitted {
        Ok(token) => {
            request.extensions_mut().insert(token);
            next.run(request).await
        }
        Err(error) => {
            // The server closes a connection whose request has not been read, without announcing it,
            // and the next request on that connection is lost.
            let _ = to_bytes(request.into_body(), MOST_READ_AND_REFUSED).await;
            answer_failure(&ProvisioningError::Service(error))
        }
    }
}

/// The directory that sends a request.
struct Directory {
    state: AppState,
    token: ProvisioningToken,
    address: String,
    if_match: Option<String>,
}

impl FromRequestParts<AppState> for Directory {
    type Rejection = Response;

    async fn from_request_parts(parts: &mut Parts, state: &AppState) -> Result<Self, Self::Rejection> {
        let token = parts.extensions.get::<ProvisioningToken>().cloned();
        let token = token.ok_or_else(|| answer_failure(&ProvisioningError::Service(Error::Unauthorized)))?;
        let if_match = parts.headers.get(header::IF_MATCH).and_then(|value| value.to_str().ok()).map(str::to_owned);
        let address = format!("{}/scim/v2", state.config.address());
        Ok(Self { state: state.clone(), token, address, if_match })
    }
}

impl Directory {
    fn request(&self) -> DirectoryRequest<'_> {
        DirectoryRequest {
            service: &self.state,
            token: &self.token,
            address: ScimAddress(&self.address),
            if_match: self.if_match.as_deref(),
        }
    }
}

fn answer_json(status: StatusCode, body: &Value) -> Response {
    (status, [(header::CONTENT_TYPE, SCIM_JSON)], body.to_string()).into_response()
}

fn answer_error(error: &ScimError) -> Response {
    let status = StatusCode::from_u16(error.status).unwrap_or(StatusCode::BAD_REQUEST);
    answer_json(status, &error.to_json())
}

fn answer_failure(error: &ProvisioningError) -> Response {
    match error {
        ProvisioningError::Scim(error) => answer_error(error),
        ProvisioningError::Service(error) => {
            let status = status_of(error);
            let body = ScimError { status: status.as_u16(), kind: None, detail: error.to_string() }.to_json();
            finish_answer(error, answer_json(status, &body))
        }
    }
}

/// A resource as an answer, with its version and address.
struct Resource(Object);

impl Resource {
    fn meta(&self, name: &str) -> Option<HeaderValue> {
        let value = self.0.get("meta")?.get(name)?.as_str()?;
        HeaderValue::from_str(value).ok()
    }

    fn answer(self, status: StatusCode, selection: &Selection) -> Response {
        let (version, location) = (self.meta("version"), self.meta("location"));
        let mut answer = answer_json(status, &Value::Object(selection.of(self.0)));
        if let Some(version) = version {
            answer.headers_mut().insert(header::ETAG, version);
        }
        if let Some(location) = location {
            answer.headers_mut().insert(header::LOCATION, location);
        }
        answer
    }
}

fn answer_resource(done: Result<Object, ProvisioningError>, status: StatusCode, selection: &Selection) -> Response {
    match done {
        Ok(fields) => Resource(fields).answer(status, selection),
        Err(error) => answer_failure(&error),
    }
}

fn answer_deleted(done: Result<(), ProvisioningError>) -> Response {
    match done {
        Ok(()) => StatusCode::NO_CONTENT.into_response(),
        Err(error) => answer_failure(&error),
    }
}

/// Parameters of a query.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct ScimQuery {
    filter: Option<String>,
    start_index: Option<i64>,
    count: Option<i64>,
    attributes: Option<String>,
    excluded_attributes: Option<String>,
}

impl ScimQuery {
    fn selection(&self) -> Selection {
        Selection::parse(self.attributes.as_deref(), self.excluded_attributes.as_deref())
    }

    fn filter(&self) -> Result<Option<Filter>, ScimError> {
        self.filter.as_deref().map(Filter::parse).transpose()
    }

    fn offset(&self) -> u32 {
        (self.start_index.unwrap_or(1).clamp(1, i64::from(u32::MAX)) - 1) as u32
    }

    fn limit(&self) -> u32 {
        let most = schemas::MOST_RESULTS;
        self.count.map_or(most, |count| count.clamp(0, i64::from(most)) as u32)
    }
}

fn answer_list(resources: Vec<Value>, total: u32, start: u32) -> Response {
    let body = json!({
        "schemas": ["urn:ietf:params:scim:api:messages:2.0:ListResponse"],
        "totalResults": total,
        "itemsPerPage": resources.len(),
        "startIndex": start,
        "Resources": resources,
    });
    answer_json(StatusCode::OK, &body)
}

fn answer_listed(listed: Result<Listed, ProvisioningError>, query: &ScimQuery) -> Response {
    match listed {
        Ok(Listed { total, resources }) => {
            let selection = query.selection();
            let resources = resources.into_iter().map(|fields| Value::Object(selection.of(fields))).collect();
            answer_list(resources, total, query.offset() + 1)
        }
        Err(error) => answer_failure(&error),
    }
}

async fn show_config(directory: Directory) -> Response {
    answer_json(StatusCode::OK, &schemas::provider_config(ScimAddress(&directory.address)))
}

async fn list_resource_types(directory: Directory) -> Response {
    let all = schemas::resource_types(ScimAddress(&directory.address));
    let total = all.len() as u32;
    answer_list(all, total, 1)
}

fn answer_named(all: Vec<Value>, name: &str) -> Response {
    match all.into_iter().find(|one| one["id"] == name) {
        Some(found) => answer_json(StatusCode::OK, &found),
        None => answer_failure(&ProvisioningError::Service(Error::NotFound)),
    }
}

async fn show_resource_type(directory: Directory, Path(name): Path<String>) -> Response {
    answer_named(schemas::resource_types(ScimAddress(&directory.address)), &name)
}

async fn list_schemas(directory: Directory) -> Response {
    let all = schemas::schemas(ScimAddress(&directory.address));
    let total = all.len() as u32;
    answer_list(all, total, 1)
}

async fn show_schema(directory: Directory, Path(name): Path<String>) -> Response {
    answer_named(schemas::schemas(ScimAddress(&directory.address)), &name)
}

/// Parses a body as JSON.
fn read_json(body: &Bytes) -> Result<Value, ScimError> {
    serde_json::from_slice(body).map_err(|error| ScimError {
        status: 400,
        kind: Some("invalidSyntax"),
        detail: format!("the body is not JSON: {error}"),
    })
}

fn read_fields(body: &Bytes) -> Result<Object, ProvisioningError> {
    read_json(body).and_then(read_resource).map_err(ProvisioningError::Scim)
}

fn read_patch(body: &Bytes) -> Result<PatchRequest, ProvisioningError> {
    read_json(body).and_then(PatchRequest::read).map_err(ProvisioningError::Scim)
}

/// Reads a search, whose body is a query.
fn read_search(body: &Bytes) -> Result<ScimQuery, ScimError> {
    #[derive(Deserialize)]
    #[serde(rename_all = "camelCase")]
    struct Search {
        filter: Option<String>,
        start_index: Option<i64>,
        count: Option<i64>,
        attributes: Option<Vec<String>>,
        excluded_attributes: Option<Vec<String>>,
    }
    let Search { filter, start_index, count, attributes, excluded_attributes } =
        serde_json::from_slice(body).map_err(|error| ScimError {
            status: 400,
            kind: Some("invalidSyntax"),
            detail: format!("the body is not a search: {error}"),
        })?;
    let join = |names: Option<Vec<String>>| names.map(|names| names.join(","));
    let (attributes, excluded_attributes) = (join(attributes), join(excluded_attributes));
    Ok(ScimQuery { filter, start_index, count, attributes, excluded_attributes })
}

/// Users and groups are searched one kind at a time.
async fn search_everything(_: Directory) -> Response {
    let detail = "search /Users/.search or /Groups/.search".to_owned();
    answer_error(&ScimError { status: 501, kind: None, detail })
}

/// The id in a path. A malformed id is answered like an unknown one.
fn read_id<T: std::str::FromStr>(text: &str) -> Result<T, ProvisioningError> {
    text.parse().map_err(|_| ProvisioningError::Service(Error::NotFound))
}

/// Defines the handlers of a kind of resource.
macro_rules! handlers {
    ($list:ident, $search:ident, $create:ident, $show:ident, $replace:ident, $patch:ident, $delete:ident) => {
        async fn $list(directory: Directory, Query(query): Query<ScimQuery>) -> Response {
            let filter = match query.filter() {
                Ok(filter) => filter,
                Err(error) => return answer_error(&error),
            };
            let listed = directory.request().$list(filter.as_ref(), query.offset(), query.limit()).await;
            answer_listed(listed, &query)
        }

        async fn $search(directory: Directory, body: Bytes) -> Response {
            match read_search(&body) {
                Ok(query) => $list(directory, Query(query)).await,
                Err(error) => answer_error(&error),
            }
        }

        async fn $create(directory: Directory, Query(query): Query<ScimQuery>, body: Bytes) -> Response {
            let made = match read_fields(&body) {
                Ok(fields) => directory.request().$create(&fields).await,
                Err(error) => Err(error),
            };
            answer_resource(made, StatusCode::CREATED, &query.selection())
        }

        async fn $show(directory: Directory, Path(id): Path<String>, Query(query): Query<ScimQuery>) -> Response {
            let found = match read_id(&id) {
                Ok(id) => directory.request().$show(id).await,
                Err(error) => Err(error),
            };
            answer_resource(found, StatusCode::OK, &query.selection())
        }

        async fn $replace(
            directory: Directory,
            Path(id): Path<String>,
            Query(query): Query<ScimQuery>,
            body: Bytes,
        ) -> Response {
            let replaced = match read_id(&id).and_then(|id| Ok((id, read_fields(&body)?))) {
                Ok((id, fields)) => directory.request().$replace(id, &fields).await,
                Err(error) => Err(error),
            };
            answer_resource(replaced, StatusCode::OK, &query.selection())
        }

        async fn $patch(
            directory: Directory,
            Path(id): Path<String>,
            Query(query): Query<ScimQuery>,
            body: Bytes,
        ) -> Response {
            let patched = match read_id(&id).and_then(|id| Ok((id, read_patch(&body)?))) {
                Ok((id, patch)) => directory.request().$patch(id, patch).await,
                Err(error) => Err(error),
            };
            answer_resource(patched, StatusCode::OK, &query.selection())
        }

        async fn $delete(directory: Directory, Path(id): Path<String>) -> Response {
            answer_deleted(match read_id(&id) {
                Ok(id) => directory.request().$delete(id).await,
                Err(error) => Err(error),
            })
        }
    };
}

handlers!(list_users, search_users, create_user, show_user, replace_user, patch_user, delete_user);
handlers!(list_groups, search_groups, create_group, show_group, replace_group, patch_group, delete_group);
