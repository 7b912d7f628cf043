//! The OpenAPI description: the descriptions of the handlers, completed with the parts common to
//! all of them.

use routes_base::error::ProblemDocument;
use utoipa::OpenApi;
use utoipa::openapi::content::{Content, ContentBuilder};
use utoipa::openapi::path::{Operation, PathItem};
use utoipa::openapi::response::{Response, ResponseBuilder};
use utoipa::openapi::schema::{KnownFormat, ObjectBuilder, SchemaFormat, Type};
use utoipa::openapi::security::{Http, HttpAuthScheme, SecurityScheme};
use utoipa::openapi::{OpenApi as Description, Ref, RefOr, Required};

/// Media type of errors (RFC 9457).
const PROBLEM: &str = "application/problem+json";
/// Media type of recordings and frames.
const BYTES: &str = "application/octet-stream";
/// Media type of a piece of an upload.
const PIECE: &str = "application/offset+octet-stream";

#[derive(OpenApi)]
#[openapi(
    info(title = "Stylet", description = "Recordings in, scores out."),
    servers((url = "/api/v1")),
    security(("token" = [])),
    components(schemas(ProblemDocument))
)]
struct ApiDescription;

/// Returns the description of the endpoints, completed with the parts common to all of them:
/// authentication, the form of errors, and the meaning of each status.
pub(super) fn describe_api(endpoints: Description) -> Description {
    let mut description = ApiDescription::openapi();
    description.merge(endpoints);
    let components = description.components.get_or_insert_default();
    components.add_security_scheme("token", SecurityScheme::Http(Http::new(HttpAuthScheme::Bearer)));
    for item in description.paths.paths.values_mut() {
        let answers_head = item.head.is_some();
        operations_of_path(item).for_each(|operation| complete_operation(operation, answers_head));
    }
    description
}

fn operations_of_path(item: &mut PathItem) -> impl Iterator<Item = &mut Operation> {
    let PathItem { get, put, post, delete, options, head, patch, .. } = item;
    [get, put, post, delete, options, head, patch].into_iter().flatten()
}

fn complete_operation(operation: &mut Operation, answers_head: bool) {
    // An operation with a `security` list of its own needs no token.
    let needs_token = operation.security.is_none();
    let responses = &mut operation.responses.responses;
    if needs_token {
        responses.entry("401".to_owned()).or_insert_with(describe_refusal);
        responses.entry("403".to_owned()).or_insert_with(describe_refusal);
    }
    if !answers_head {
        responses.entry("default".to_owned()).or_insert_with(describe_refusal);
    }
    for (status, response) in responses {
        if let RefOr::T(response) = response {
            finish_description(status, response);
        }
    }
    if let Some(RefOr::T(body)) = &mut operation.request_body {
        body.required = Some(Required::True);
        body.content.iter_mut().for_each(|(media_type, content)| show_bytes(media_type, content));
    }
}

fn describe_refusal() -> RefOr<Response> {
    let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build();
    RefOr::T(ResponseBuilder::new().content(PROBLEM, content).build())
}

/// Adds the meaning of a status unless its handler describes it, and the media type of its body.
fn finish_description(status: &str, response: &mut Response) {
    if response.description.is_empty() {
        meaning_of_status(status).clone_into(&mut response.description);
    }
    let is_problem = |content: &RefOr<Content>| match content {
        RefOr::T(Content { schema: Some(RefOr::Ref(schema)), .. }) => schema.ref_location.ends_with("/Problem"),
        _ => false,
    };
    if response.content.get("application/json").is_some_and(is_problem)
        && let Some(content) = response.content.shift_remove("application/json")
    {
        response.content.insert(PROBLEM.to_owned(), content);
    }
    response.content.iter_mut().for_each(|(media_type, content)| show_bytes(media_type, content));
}

/// Gives binary bodies a schema, too, so that client generators produce a file.
fn show_bytes(media_type: &str, content: &mut RefOr<Content>) {
    if let RefOr::T(content) = content
        && content.schema.is_none()
        && [BYTES, PIECE].contains(&media_type)
    {
        let bytes = ObjectBuilder::new().schema_type(Type::String);
        let bytes = bytes.format(Some(SchemaFormat::KnownFormat(KnownFormat::Binary))).build();
        content.schema = Some(bytes.into());
    }
}

/// Returns the meaning of a status, as in `acts::error::Error`.
const fn meaning_of_status(status: &str) -> &'static str {
    match status.as_bytes() {
        b"200" => "Done",
        b"201" => "Made",
        b"202" => "Waiting: try again",
        b"204" => "Done; no content",
        b"206" => "The requested range of bytes",
        b"400" => "The request is invalid; `detail` states what is allowed",
        b"401" => "Missing, invalid or expired bearer token; `detail` states which",
        b"403" => "Not allowed for this caller",
        b"404" => "Not found, or it belongs to another school",
        b"409" => "Conflict with the stored state",
        b"410" => "It existed, and was removed",
        b"412" => "A version of tus other than 1.0.0",
        b"413" => "The body is larger than allowed",
        b"415" => "The media type of the body is not supported",
        b"416" => "The range of bytes does not exist",
        b"422" => "The body is well-formed but invalid",
        b"429" => "Too many attempts; Retry-After states when to try again",
        _ => "Rejected for another reason, stated in `detail`",
    }
}
