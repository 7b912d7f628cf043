//! The client of the tus 1.0.0 protocol: creates an upload, queries its offset, sends a piece.

use data_encoding::BASE64;
use sha2::{Digest, Sha256};
use time::format_description::well_known::Rfc3339;
use ureq::RequestBuilder;
use ureq::http::header::AUTHORIZATION;

use crate::clock;
use crate::service::{Outlook, Reply, Service, Trouble, ask_service};

const VERSION: (&str, &str) = ("Tus-Resumable", "1.0.0");
const PIECE_TYPE: &str = "application/offset+octet-stream";

/// State of an upload.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UploadStanding {
    /// The service does not know it, or not any more.
    Gone,
    /// Number of bytes that the service has stored.
    At(u64),
    /// Id of the session that the service has made of it.
    Session(String),
}

/// Creates an upload of `length` bytes; returns its id.
pub fn begin_upload(service: &Service, name: &str, length: u64) -> Result<String, Trouble> {
    let address = format!("{}/api/v1/uploads", service.address);
    let asked = signed_request(service.agent.post(&address), service)
        .header("Upload-Length", length)
        .header("Stylet-Clock", clock::now().format(&Rfc3339).unwrap_or_default())
        .header("Upload-Metadata", format!("filename {}", BASE64.encode(name.as_bytes())))
        .send_empty();
    let reply = ask_service(&address, asked)?;
    let id = match (reply.status, reply.header("location")) {
        // Only the id is used, so that the token is sent to no address but the configured one.
        (201, Some(location)) => location.rsplit('/').next().filter(|id| is_plain(id)).map(str::to_owned),
        _ => None,
    };
    id.ok_or_else(|| strange_answer(&reply, 201, "without an upload address"))
}

/// Whether an id is safe as a part of an address's path.
fn is_plain(id: &str) -> bool {
    !id.is_empty() && id.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_')
}

/// Queries the state of an upload.
pub fn ask_upload_standing(service: &Service, id: &str) -> Result<UploadStanding, Trouble> {
    let address = upload_address(service, id);
    let asked = signed_request(service.agent.head(&address), service).call();
    let reply = ask_service(&address, asked)?;
    match reply.status {
        404 | 410 => Ok(UploadStanding::Gone),
        200 | 204 => upload_standing(&reply).ok_or_else(|| strange_answer(&reply, reply.status, "without an offset")),
        _ => Err(reply.trouble()),
    }
}

/// Sends a piece that begins at `offset`. An empty one asks the service to make a session of the
/// stored bytes.
pub fn send_upload_piece(service: &Service, id: &str, offset: u64, piece: &[u8]) -> Result<UploadStanding, Trouble> {
    let address = upload_address(service, id);
    let asked = signed_request(service.agent.patch(&address), service)
        .header("Upload-Offset", offset)
        .header("Upload-Checksum", format!("sha256 {}", BASE64.encode(&Sha256::digest(piece))))
        .content_type(PIECE_TYPE)
        .send(piece);
    let reply = ask_service(&address, asked)?;
    match reply.status {
        204 => match upload_standing(&reply) {
            Some(UploadStanding::At(now)) if now != offset + piece.len() as u64 => {
                Err(strange_answer(&reply, 204, "elsewhere"))
            }
            Some(standing) => Ok(standing),
            None => Err(strange_answer(&reply, 204, "without an offset")),
        },
        404 | 410 => Ok(UploadStanding::Gone),
        // Either the offset differs, which a new query resolves, or the service has another
        // recording of this session and has deleted the upload.
        409 => match ask_upload_standing(service, id)? {
            UploadStanding::Gone => Err(reply.trouble()),
            _ => Err(Trouble { outlook: Outlook::Soon, ..reply.trouble() }),
        },
        _ => Err(reply.trouble()),
    }
}

/// Adds the headers of every request: the protocol's version and the token.
fn signed_request<B>(request: RequestBuilder<B>, service: &Service) -> RequestBuilder<B> {
    request.header(VERSION.0, VERSION.1).header(AUTHORIZATION, &service.token)
}

fn upload_address(service: &Service, id: &str) -> String {
    format!("{}/api/v1/uploads/{id}", service.address)
}

fn upload_standing(reply: &Reply) -> Option<UploadStanding> {
    if let Some(session) = reply.header("stylet-session") {
        return Some(UploadStanding::Session(session.to_owned()));
    }
    reply.header("upload-offset")?.parse().ok().map(UploadStanding::At)
}

/// The error for an expected status with unexpected headers: a captive portal, a proxy, or another
/// program.
fn strange_answer(reply: &Reply, hoped: u16, what: &str) -> Trouble {
    if reply.status != hoped {
        return reply.trouble();
    }
    let detail = format!("HTTP {hoped} {what}: is this the address of the service?");
    Trouble { outlook: Outlook::Later, status: Some(hoped), detail }
}
